//! What broke elsewhere, by the files that were made from the reports: each row of their table by the real command. They lie
//! beside the project; without them every test says so and passes.
//!
//! Every kind has a test with data of our own, which always runs:
//!
//! | rows | kind | test |
//! |---|---|---|
//! | 01, 01c, b24 | rings that touch, sliver holes | `standing::rings_that_touch_and_sliver_holes_cost_no_part_of_the_building` |
//! | 02, 02c | open ground in a footprint | `standing::a_courtyard_that_nobody_drew_is_carved_or_kept`, `standing::a_garage_below_the_ground_is_not_built_over` |
//! | 03, 14, 15, 17 | what a header claims | `src/source/points/tests/claims.rs` |
//! | 04, 04b, 05 | curves and byte orders | `src/source/footprints/tests/curves.rs`, `formats.rs` |
//! | 06 | a system that is none | `src/source/footprints/tests/formats.rs` |
//! | 07 | features by lines | `src/source/footprints/tests/sequences.rs` |
//! | 08, 09 | systems in odd places, unknown heights | `src/source/crs/tests.rs`, `told::heights_of_an_unknown_datum_leave_the_horizontal_system` |
//! | 10, 13 | points that are not used | `told` |
//! | 11, 11c | what hovers or is too slender | `src/reconstruct/unmodelled.rs`, `src/reconstruct/tests.rs` |
//! | 12 | a floor that nothing tells of | `told::a_roof_alone_is_no_success` |
//! | 16 | metres that are none | `told::metres_that_are_none_are_told_and_corrected` |
//! | 18 | standard output | `streams` |
//! | 19 | the hierarchy of COPC | `src/source/points/tests/copc.rs` |
//! | 20 to 23 | codes of val3dity | `agreement`, `src/reconstruct/surface/unfold.rs` |
//! | b05 | regularised planes | `src/reconstruct/primitives/refine.rs` |
//! | `missing_block` | a part that was missed | `src/reconstruct/rounds.rs` |
//! | `leak_partywall` | a slope beyond its points | `standing::a_slope_ends_where_its_points_end` |
//! | `extrapolated` | a part that no tile covers | `standing::a_building_beyond_the_tile_is_partial` |
//! | saws and rows | halls | `tests/library/halls.rs` |
//! | `stack-overflow`, `tr.fgb`, `h2.gpkg` | damage, views without end | `damaged_times`, `src/source/footprints/tests/formats.rs` |

mod footprints;
mod load;
mod models;
mod roofs;
mod tiles;

use std::path::{Path, PathBuf};

use serde_json::Value;
use tempfile::{TempDir, tempdir};

use crate::bench::*;

/// The folder of the reports; `None`, and a line that says so, without it.
fn reports() -> Option<PathBuf> {
    shared("reported")
}

/// What came of one row.
struct Row {
    run: Run,
    folder: TempDir,
}

impl Row {
    /// The model that was written.
    fn model(&self) -> PathBuf {
        self.folder.path().join("out.city.json")
    }

    /// The attributes of a building.
    fn building(&self, id: &str) -> Value {
        json_of(self.model())["CityObjects"][id]["attributes"].clone()
    }

    /// The reference system of the model.
    fn system(&self) -> Value {
        json_of(self.model())["metadata"]["referenceSystem"].clone()
    }

    /// Asserts that it ended so, said this on standard error, and that what was written is valid.
    fn ends(&self, code: i32, says: &[&str]) {
        assert_ends(&self.run, code, says);
        if code != 1 {
            assert_valid(&self.model());
        }
    }

    /// Asserts that it ended with exit code 0, and without a warning.
    fn succeeds(&self) {
        self.ends(0, &[]);
        assert!(!self.run.err.contains("warning"), "{}", self.run.err);
    }
}

/// Reconstructs what a row says, with blanks between tiles and between options.
fn row(reports: &Path, tiles: &str, footprints: &str, rest: &str) -> Row {
    let folder = tempdir().unwrap();
    let tiles: Vec<PathBuf> = tiles.split_whitespace().map(|tile| reports.join(tile)).collect();
    let tiles: Vec<&Path> = tiles.iter().map(PathBuf::as_path).collect();
    let run = reconstruct(&tiles, &reports.join(footprints), &folder.path().join("out.city.json"), rest);
    Row { run, folder }
}

/// A number among attributes.
fn number(of: &Value, name: &str) -> f64 {
    of[name].as_f64().unwrap_or_else(|| panic!("{name}: {of:#}"))
}

/// Asserts that an attribute is near a number.
fn assert_near(of: &Value, name: &str, expected: f64, tolerance: f64) {
    let found = number(of, name);
    assert!((found - expected).abs() <= tolerance, "{name} {found}, not {expected} ± {tolerance}: {of:#}");
}

/// Asserts that both sound buildings come out right: a saddle roof of 608 m³ and a flat one of 672 m³.
fn assert_base(row: &Row, ids: [&str; 2]) {
    for (id, volume) in ids.into_iter().zip([608.0, 672.0]) {
        let building = row.building(id);
        assert_eq!(building["gable_success"], true, "{building:#}");
        assert_near(&building, "gable_volume_lod22", volume, 0.01 * volume);
        assert!(number(&building, "gable_rmse_lod22") < 0.05, "{building:#}");
    }
}
