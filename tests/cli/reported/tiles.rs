//! Rows about tiles.

use super::{assert_base, assert_near, number, reports, row};
use crate::bench::*;

/// 03 and 03b: a header whose box is elsewhere.
#[test]
fn the_box_of_the_points_counts_and_not_that_of_the_header() {
    let Some(reports) = reports() else { return };
    let told = "1727 of 1727 points lie outside the extent in the header; that of the points is used";
    let both = row(&reports, "03-west.laz 03-east-wrong-box.laz", "03-header-box.geojson", "");
    both.ends(0, &["03-east-wrong-box.laz", told]);
    assert_base(&both, ["b0", "b1"]);
    let alone = row(&reports, "03-east-wrong-box.laz", "03-header-box.geojson", "");
    alone.ends(0, &["03-east-wrong-box.laz", told]);
    assert!(!alone.run.err.contains("overlap"), "{}", alone.run.err);
    assert_near(&alone.building("b1"), "gable_volume_lod22", 672.0, 7.0);
    let west = alone.building("b0");
    assert_eq!(west["gable_fallback_reason"], "incomplete", "the west tile is not there: {west:#}");
    let info = gable(["info".as_ref(), reports.join("03-east-wrong-box.laz").as_os_str()]);
    assert_says(&info.out, &[told]);
}

/// 08: the WKT of a later edition of the standard, in a record of its own.
#[test]
fn a_system_in_record_4224_is_read() {
    let Some(reports) = reports() else { return };
    let row = row(&reports, "08-wkt2-record-4224.laz", "base.geojson", "");
    row.succeeds();
    assert_base(&row, ["b0", "b1"]);
    assert!(row.system().is_string(), "{}", row.system());
}

/// 09: heights of a geoid file that nobody has.
#[test]
fn an_unknown_datum_leaves_the_horizontal_system() {
    let Some(reports) = reports() else { return };
    let row = row(&reports, "09-unknown-vertical-datum.laz", "base.geojson", "");
    row.ends(0, &["warning: nobody knows the vertical system", "EPSG:28992", "--crs"]);
    assert_base(&row, ["b0", "b1"]);
    assert_eq!(row.system(), "https://www.opengis.net/def/crs/EPSG/0/28992");
    let tiles = row.folder.path().join("x.3dtiles");
    let run = gable(["convert".as_ref(), row.model().as_os_str(), "-o".as_ref(), tiles.as_os_str()]);
    assert_ends(&run, 0, &[]);
    assert!(tiles.join("tileset.json").exists());
}

/// 10: nearly all points of the buildings are of class 12.
#[test]
fn points_of_class_12_are_told_with_the_option_for_them() {
    let Some(reports) = reports() else { return };
    let without = row(&reports, "10-class12-overlap.laz", "base.geojson", "");
    without.ends(0, &["627 of class 12 (overlap), against 33 that are used", "--building-class 6,12 would use them"]);
    let with = row(&reports, "10-class12-overlap.laz", "base.geojson", "--building-class 6,12");
    with.succeeds();
    assert_base(&with, ["b0", "b1"]);
}

/// 13: all points of the building are marked as synthetic.
#[test]
fn synthetic_points_are_told_with_the_option_for_them() {
    let Some(reports) = reports() else { return };
    let (tile, footprints) = ("13-synthetic-flag.laz", "13-synthetic-flag.geojson");
    let without = row(&reports, tile, footprints, "");
    without.ends(1, &["305 points marked as synthetic", "--use-flagged synthetic would use them"]);
    let with = row(&reports, tile, footprints, "--use-flagged synthetic");
    with.ends(0, &[]);
    assert_eq!(with.building("b0")["gable_success"], true);
}

/// 14: the header announces a third of the points.
#[test]
fn points_beyond_the_count_of_the_header_are_told() {
    let Some(reports) = reports() else { return };
    let row = row(&reports, "14-fewer-points-in-header.las", "14-fewer-points-in-header.geojson", "");
    row.ends(0, &["holds at least 1174 points more than the 586 that its header announces"]);
}

/// 15: a version that came after the reader.
#[test]
fn las_1_5_is_read() {
    let Some(reports) = reports() else { return };
    let row = row(&reports, "15-las-1.5.laz", "base.geojson", "");
    row.ends(0, &[]);
    let building = row.building("b0");
    assert_eq!(building["gable_success"], true, "{building:#}");
    assert_near(&building, "gable_height_roof_max", 6.0, 0.05);
    let info = gable(["info".as_ref(), reports.join("15-las-1.5.laz").as_os_str()]);
    assert_says(&info.out, &["LAZ 1.5", "1 760 points"]);
}

/// 16: metres of a map of the world.
#[test]
fn web_mercator_is_told_and_corrected() {
    let Some(reports) = reports() else { return };
    let row = row(&reports, "16-web-mercator.laz", "16-web-mercator.geojson", "");
    row.ends(0, &["warning: a metre of EPSG:3857", "is 0.617 m on the ground here"]);
    assert_near(&row.building("merc"), "gable_volume_lod22", 612.0, 12.0);
}

/// 17: returns without a number.
#[test]
fn pulses_that_nobody_counted_are_unknown() {
    let Some(reports) = reports() else { return };
    let run = gable(["info".as_ref(), reports.join("17-return-number-zero.laz").as_os_str()]);
    assert_ends(&run, 0, &[]);
    assert_says(&run.out, &["unknown pulses/m²"]);
    assert!(!run.out.contains("0.0 pulses"), "{}", run.out);
}

/// 19: the first page of the hierarchy stands last.
#[test]
fn the_hierarchy_of_copc_is_used_wherever_it_stands() {
    let Some(reports) = reports() else { return };
    let row = row(&reports, "19-copc-root-page-last.copc.laz", "19-small.geojson", "");
    row.succeeds();
    assert_says(&row.run.out, &["points read           5 184"]);
    assert!(number(&row.building("b0"), "gable_rmse_lod22") < 0.05);
}
