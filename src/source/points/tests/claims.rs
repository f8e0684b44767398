//! Headers that do not tell the truth.

use super::{assert_same, cloud, read};
use crate::source::points::fixture::{self, Plain, Style};
use crate::source::points::{Tile, TileProblem};
use std::fs;
use std::path::Path;
use tempfile::tempdir;

/// Moves the largest and smallest x in a header.
fn shift_box(path: &Path, by: [f64; 2]) {
    let mut bytes = fs::read(path).unwrap();
    for (at, by) in [(179, by[1]), (187, by[0])] {
        let x = f64::from_le_bytes(bytes[at..at + 8].try_into().unwrap());
        bytes[at..at + 8].copy_from_slice(&(x + by).to_le_bytes());
    }
    fs::write(path, bytes).unwrap();
}

#[test]
fn a_box_that_does_not_hold_the_points_is_not_believed() {
    let folder = tempdir().unwrap();
    for name in ["a.las", "a.laz"] {
        let path = folder.path().join(name);
        fixture::write(&path, Style { format: 1, ..Style::default() }, &cloud(5_000));
        let sound = fs::read(&path).unwrap();
        assert!(Tile::open(&path).unwrap().is_true_to_its_extent());
        // A kilometre to the east, and so plausible.
        shift_box(&path, [1000.0, 1000.0]);
        let tile = Tile::open(&path).unwrap();
        assert_eq!((tile.extent, tile.stated_extent.is_some()), (None, true), "{name}");
        let summary = tile.summary([1.0; 3]).unwrap();
        assert_eq!(summary.points, 5_000);
        let said = summary.problems[0].to_string();
        assert!(said.contains("5000 of 5000 points lie outside the extent in the header"), "{said}");
        // One damaged point says nothing of the box.
        let mut damaged = sound;
        let start = u32::from_le_bytes(damaged[96..100].try_into().unwrap()) as usize;
        if name == "a.las" {
            damaged[start..start + 4].copy_from_slice(&2_000_000_000_i32.to_le_bytes());
            fs::write(&path, damaged).unwrap();
            assert!(Tile::open(&path).unwrap().extent.is_some());
        }
    }
}

#[test]
fn a_box_that_holds_only_the_first_points_is_found_out_by_others() {
    let folder = tempdir().unwrap();
    for (name, format) in [("a.las", 1), ("a.laz", 1), ("b.laz", 6)] {
        let path = folder.path().join(name);
        let points: Vec<Plain> = (0..3000).map(|i| ([f64::from(i) * 0.1, 5.0, 1.0], 6)).collect();
        fixture::write(&path, Style { format, ..Style::default() }, &points);
        shift_box(&path, [0.0, -40.0]);
        let tile = Tile::open(&path).unwrap();
        assert!(tile.extent.is_some() && !tile.is_true_to_its_extent(), "{name}");
        let problems = tile.summary([1.0; 3]).unwrap().problems;
        assert!(matches!(problems[..], [TileProblem::PointsOutsideExtent { points: 389..=390, read: 3000, .. }]), "{problems:?}");
    }
}

#[test]
fn more_points_than_announced_are_told() {
    let folder = tempdir().unwrap();
    for (name, format) in [("a.las", 1), ("b.las", 6), ("c.laz", 1), ("d.laz", 6)] {
        let path = folder.path().join(name);
        fixture::write(&path, Style { format, ..Style::default() }, &cloud(120_000));
        assert_eq!(Tile::open(&path).unwrap().unannounced, 0, "{name}");
        let mut bytes = fs::read(&path).unwrap();
        bytes[107..111].copy_from_slice(&40_000_u32.to_le_bytes());
        bytes[247..255].copy_from_slice(&40_000_u64.to_le_bytes());
        fs::write(&path, bytes).unwrap();
        let tile = Tile::open(&path).unwrap();
        // Chunks hold 50 000 points.
        let expected = if name.ends_with("las") { 80_000 } else { 50_001 };
        assert_eq!((tile.points, tile.unannounced), (40_000, expected), "{name}");
        let said = tile.summary([1.0; 3]).unwrap().problems[0].to_string();
        assert!(said.contains(&format!("at least {expected} points more than the 40000")), "{said}");
    }
}

#[test]
fn returns_without_a_number_tell_no_pulses() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.las");
    fixture::write_with(&path, Style { format: 1, ..Style::default() }, &cloud(50), |_, point| {
        (point.return_number, point.number_of_returns) = (0, 0);
    });
    let summary = Tile::open(&path).unwrap().summary([1.0; 3]).unwrap();
    assert_eq!(summary.pulse_density, None);
    assert!(summary.density > 0.0);
}

#[test]
fn version_1_5_is_read_as_what_it_shares_with_1_4() {
    let folder = tempdir().unwrap();
    for name in ["a.las", "a.laz"] {
        let path = folder.path().join(name);
        fixture::write(&path, Style::default(), &cloud(2_000));
        let mut bytes = fs::read(&path).unwrap();
        // Three fields more behind the header of 1.4, and everything else moves.
        bytes.splice(375..375, [0xff; 18]);
        bytes[25] = 5;
        bytes[94..96].copy_from_slice(&393_u16.to_le_bytes());
        let start = u32::from_le_bytes(bytes[96..100].try_into().unwrap()) + 18;
        bytes[96..100].copy_from_slice(&start.to_le_bytes());
        if name == "a.laz" {
            let table = start as usize;
            let at = u64::from_le_bytes(bytes[table..table + 8].try_into().unwrap()) + 18;
            bytes[table..table + 8].copy_from_slice(&at.to_le_bytes());
        }
        fs::write(&path, bytes).unwrap();
        let tile = Tile::open(&path).unwrap();
        assert_eq!((tile.version.as_str(), tile.unannounced), ("1.5", 0));
        assert_same(&read(&tile).0, &cloud(2_000));
    }
}
