//! Rows of the load test. The tile that sent a decoder into a recursion is in `damaged_times`.

use std::time::{Duration, Instant};

use super::{number, reports, row};
use crate::bench::*;

/// A hall of 80 saw teeth, and a long row at 45 degrees, both with 2 cm of noise.
#[test]
fn halls_and_rows_fit_as_well_as_the_noise_allows() {
    let Some(reports) = reports() else { return };
    for id in ["saw_160x100", "row180_45"] {
        let row = row(&reports, &format!("load/{id}.laz"), &format!("load/{id}.geojson"), "--crs EPSG:7415");
        row.ends(0, &[]);
        let building = row.building(id);
        assert_eq!(building["gable_success"], true, "{building:#}");
        assert!(number(&building, "gable_rmse_lod22") <= 0.03, "{building:#}");
        assert!(number(&building, "gable_rmse_lod12") > 0.5, "{building:#}");
    }
}

/// A view that never ends.
#[test]
fn a_view_without_end_is_refused_within_seconds() {
    let Some(reports) = reports() else { return };
    let begun = Instant::now();
    let row = row(&reports, "base.laz", "load/h2.gpkg", "--layer v");
    row.ends(1, &["h2.gpkg: found tables or views without end (more than ", " MB of them)"]);
    // A tenth of a second where nothing else runs.
    assert!(begun.elapsed() < Duration::from_mins(1), "{:?}", begun.elapsed());
}

/// Footprints that are cut off after 102 000 bytes.
#[test]
fn footprints_that_are_missing_are_counted() {
    let (Some(reports), Some(delft)) = (reports(), shared("delft")) else { return };
    let tiles = ["ahn3_cropped_1.laz", "ahn3_cropped_2.laz"].map(|tile| delft.join(tile).display().to_string());
    let row = row(&reports, &tiles.join(" "), "load/tr.fgb", "--crs EPSG:7415 --field height-field");
    row.ends(2, &["tr.fgb: it is cut off: 2 of 160 features are missing"]);
    let report = report_of(&row.model());
    assert_eq!(report["inputs"]["footprints"]["missing"], 2);
    assert_eq!(report["counts"]["written"], 158);
}
