//! Rows about footprints.

use super::{assert_base, assert_near, number, reports, row};
use crate::bench::*;

/// 01 and 01c: a hole that touches the outline, and an outline that is pinched to the same shape.
#[test]
fn rings_that_touch_cost_only_a_tip() {
    let Some(reports) = reports() else { return };
    for (footprints, id) in
        [("01-hole-touches-outer-ring.geojson", "touch"), ("01c-outer-ring-pinched.geojson", "pinch")]
    {
        let row = row(&reports, "01-hole-touches-outer-ring.laz", footprints, "");
        row.ends(0, &[]);
        let building = row.building(id);
        assert_eq!(building["gable_success"], true, "{building:#}");
        // 74 m² under a flat roof of 6 m.
        assert_near(&building, "gable_volume_lod22", 6.0 * 74.0, 6.0 * 0.2);
        assert!(number(&building, "gable_rmse_lod22") < 0.05, "{building:#}");
        assert_says(&building["gable_notes"].to_string(), &["touches itself at a point"]);
    }
}

/// 02: a courtyard of 8 m by 8 m that the footprint does not have.
#[test]
fn a_courtyard_stays_open() {
    let Some(reports) = reports() else { return };
    let row = row(&reports, "02-courtyard-not-in-footprint.laz", "02-courtyard-not-in-footprint.geojson", "");
    row.ends(0, &[]);
    let building = row.building("court");
    assert_near(&building, "gable_open_ground_area", 64.0, 5.0);
    assert_near(&building, "gable_volume_lod22", 6.0 * (400.0 - 64.0), 6.0 * 5.0);
    assert_says(&building["gable_notes"].to_string(), &["m² of the footprint are open ground"]);
}

/// 02c: a garage below the ground, 504 m², of which 328 m² are open.
#[test]
fn a_garage_is_built_only_where_something_stands() {
    let Some(reports) = reports() else { return };
    let row = row(&reports, "02c-underground-garage.laz", "02c-underground-garage.geojson", "");
    row.ends(0, &[]);
    let garage = row.building("garage");
    assert_near(&garage, "gable_open_ground_area", 328.0, 8.0);
    // What stands on it are the two houses: no block of 2 547 m³.
    assert_near(&garage, "gable_volume_lod22", 960.0, 20.0);
    assert_says(&garage["gable_notes"].to_string(), &["m² of the footprint are open ground"]);
}

/// 04, 04b and 05: curved and straight polygons of the curved type, and a byte order that is not that of the header.
#[test]
fn geopackages_of_other_writers_are_read() {
    let Some(reports) = reports() else { return };
    let arc = row(&reports, "base.laz", "04-curvepolygon-arc.gpkg", "");
    arc.ends(0, &[]);
    let building = arc.building("1");
    assert_says(&building["gable_notes"].to_string(), &["its arcs became straight edges"]);
    assert_eq!(building["gable_success"], true, "{building:#}");
    assert_eq!(arc.building("2")["gable_success"], true);
    for footprints in ["04b-curvepolygon-straight-lines-only.gpkg", "05-wkb-big-endian-header-little.gpkg"] {
        let row = row(&reports, "base.laz", footprints, "");
        row.succeeds();
        assert_base(&row, ["1", "2"]);
        assert!(!row.building("1")["gable_notes"].to_string().contains("arcs"), "{footprints}");
    }
}

/// 06: a system of GDAL that stands for none.
#[test]
fn an_undefined_system_is_that_of_the_tiles_and_told() {
    let Some(reports) = reports() else { return };
    let row = row(&reports, "base.laz", "06-gdal-undefined-srs-99999.gpkg", "");
    row.ends(0, &["warning: ", "does not say its reference system", "EPSG:7415", "--footprint-crs"]);
    assert_base(&row, ["1", "2"]);
}

/// 07: a feature on each line, and after record separators (RFC 8142).
#[test]
fn features_by_lines_are_read() {
    let Some(reports) = reports() else { return };
    let lines = row(&reports, "base.laz", "07-lines.geojsonl", "");
    lines.ends(0, &[]);
    assert_base(&lines, ["b0", "b1"]);
    let text = std::fs::read_to_string(reports.join("07-lines.geojsonl")).unwrap();
    let records: String = text.lines().flat_map(|line| ["\u{1e}", line, "\n"]).collect();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("f.geojsonl");
    std::fs::write(&file, records).unwrap();
    let records = row(&reports, "base.laz", file.to_str().unwrap(), "");
    records.ends(0, &[]);
    assert_base(&records, ["b0", "b1"]);
}

/// b24: three sliver holes of some square centimetres.
#[test]
fn sliver_holes_are_noise() {
    let Some(reports) = reports() else { return };
    let systems = "--crs EPSG:7415 --footprint-crs EPSG:28992";
    let [with, without] =
        ["b24.geojson", "b24_nohole.geojson"].map(|footprints| row(&reports, "b24.laz", footprints, systems));
    with.ends(0, &[]);
    without.ends(0, &[]);
    let [with, without] = [with, without].map(|row| row.building("b24"));
    assert_eq!((&with["gable_success"], &with["gable_lod"]), (&true.into(), &"2.2".into()), "{with:#}");
    assert_says(&with["gable_notes"].to_string(), &["3 hole(s) of the footprint are slivers", "closed"]);
    assert_near(&with, "gable_volume_lod22", number(&without, "gable_volume_lod22"), 1.0);
}
