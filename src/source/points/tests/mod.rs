mod arguments;
mod times;

use super::fixture::{self, Plain, Style};
use super::{ScanPoint, Tile, TileProblem};
use std::fs;
use std::path::Path;
use tempfile::tempdir;

fn cloud(count: usize) -> Vec<Plain> {
    let classes = [2, 6, 1];
    (0..count)
        .map(|i| {
            let t = i as f64;
            let position = [85_000.0 + t * 0.25 % 97.0, 447_000.0 + t * 0.125 % 89.0, 3.0 + t * 0.5 % 7.0];
            (position, classes[i % classes.len()])
        })
        .collect()
}

fn read(tile: &Tile) -> (Vec<ScanPoint>, super::Reading) {
    let mut points = Vec::new();
    let reading = tile.stream(None, &mut |block| points.extend(block.points())).unwrap();
    (points, reading)
}

fn assert_same(points: &[ScanPoint], expected: &[Plain]) {
    assert_eq!(points.len(), expected.len());
    for (point, (position, class)) in points.iter().zip(expected) {
        assert_eq!(point.class, *class);
        for axis in 0..3 {
            assert!((point.position[axis] - position[axis]).abs() < 6e-4, "{point:?} is not {position:?}");
        }
    }
}

#[test]
fn every_version_and_format_reads_back_compressed_or_not() {
    let folder = tempdir().unwrap();
    let expected = cloud(300);
    let styles = [(0, 0..=1), (1, 0..=1), (2, 0..=3), (3, 0..=5), (4, 0..=10)];
    for (minor, formats) in styles {
        for format in formats {
            for extension in ["las", "LAZ"] {
                let path = folder.path().join(format!("{minor}_{format}.{extension}"));
                let style =
                    Style { version: (1, minor), format, offset: [85_000.0, 447_000.0, 0.0], ..Style::default() };
                // The writer looks at the extension in lower case only.
                let written = path.with_extension(extension.to_lowercase());
                fixture::write(&written, style, &expected);
                fs::rename(&written, &path).unwrap();
                let tile = Tile::open(&path).unwrap();
                assert_eq!((tile.version.as_str(), tile.point_format), (format!("1.{minor}").as_str(), format));
                assert_eq!(tile.points, 300);
                let (points, reading) = read(&tile);
                assert_same(&points, &expected);
                assert_eq!(reading.problems(&tile), []);
            }
        }
    }
}

#[test]
fn flags_are_told_in_old_and_new_formats() {
    let folder = tempdir().unwrap();
    for format in [1, 6] {
        for extension in ["las", "laz"] {
            let path = folder.path().join(format!("flags.{extension}"));
            fixture::write_with(&path, Style { format, ..Style::default() }, &cloud(4), |index, point| {
                point.is_withheld = index == 1;
                point.is_synthetic = index == 2;
                point.is_overlap = index == 3 && format == 6;
                point.number_of_returns = 3;
                point.return_number = index as u8 % 3 + 1;
            });
            let (points, _) = read(&Tile::open(&path).unwrap());
            let flags: Vec<_> = points.iter().map(|p| (p.withheld, p.synthetic, p.overlap, p.return_number)).collect();
            let expected = [(false, false, false, 1), (true, false, false, 2), (false, true, false, 3)];
            assert_eq!(flags[..3], expected);
            assert_eq!(flags[3], (false, false, format == 6, 1));
        }
    }
}

#[test]
fn a_file_that_is_cut_off_gives_what_it_has() {
    let folder = tempdir().unwrap();
    // More points than two chunks of 50 000, so that layered formats keep whole chunks.
    let expected = cloud(120_000);
    for (format, name, least) in
        [(1, "a.las", 59_000), (1, "b.laz", 55_000), (6, "c.laz", 50_000), (3, "d.laz", 55_000)]
    {
        let path = folder.path().join(name);
        fixture::write(&path, Style { format, ..Style::default() }, &expected);
        let bytes = fs::read(&path).unwrap();
        fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
        let tile = Tile::open(&path).unwrap();
        let (points, reading) = read(&tile);
        assert!(points.len() >= least && points.len() < 65_000, "{name}: {}", points.len());
        // The decoder looks a few bytes ahead: the last points before the cut may be made up.
        assert_same(&points[..points.len() - 20], &expected[..points.len() - 20]);
        let [TileProblem::MissingPoints { expected, read, cause, .. }] = &reading.problems(&tile)[..] else {
            panic!("{:?}", reading.problems(&tile));
        };
        assert_eq!((*expected, *read), (120_000, points.len() as u64));
        assert!(cause.contains("ends early") || cause.contains("cut off"), "{cause}");
    }
}

#[test]
fn a_damaged_chunk_costs_its_own_points_only() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.laz");
    fixture::write(&path, Style::default(), &cloud(120_000));
    let mut bytes = fs::read(&path).unwrap();
    // The layer sizes of the first chunk stand behind the chunk table's offset, the first point and its count.
    let start = u32::from_le_bytes(bytes[96..100].try_into().unwrap()) as usize + 8;
    bytes[start + 34..start + 38].fill(0xff);
    fs::write(&path, bytes).unwrap();
    let tile = Tile::open(&path).unwrap();
    let (points, reading) = read(&tile);
    assert_same(&points, &cloud(120_000)[50_000..]);
    assert!(reading.problems(&tile)[0].to_string().contains("50000 of 120000 points are missing"));
}

#[test]
fn what_is_no_tile_is_refused_with_a_reason() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.laz");
    fixture::write(&path, Style::default(), &cloud(10));
    let good = fs::read(&path).unwrap();
    let refused = |bytes: &[u8]| {
        fs::write(&path, bytes).unwrap();
        Tile::open(&path).unwrap_err().to_string()
    };
    assert!(refused(&[]).contains("an empty file (0 bytes)"));
    assert!(refused(b"PK\x03\x04 a zip").contains("'PK\\x03\\x04 a z', expected the signature 'LASF'"));
    assert!(refused(&good[..100]).contains("found a file of 100 bytes, expected a header of 227 bytes"));
    assert!(refused(&good[..300]).contains("expected a header of 375 bytes"));
    let patched = |at: usize, value: &[u8]| {
        let mut bytes = good.clone();
        bytes[at..at + value.len()].copy_from_slice(value);
        bytes
    };
    assert!(refused(&patched(24, &[2, 0])).contains("byte 24: found LAS version 2.0"));
    assert!(refused(&patched(25, &[6])).contains("found LAS version 1.6, expected LAS version 1.0 to 1.5"));
    assert!(refused(&patched(94, &[10, 0])).contains("a header size of 10"));
    assert!(refused(&patched(96, &u32::MAX.to_le_bytes())).contains("points that begin at byte 4294967295"));
    assert!(refused(&patched(100, &u32::MAX.to_le_bytes())).contains("4294967295 variable length records"));
    assert!(refused(&patched(104, &[0xaa])).contains("point format"));
    assert!(refused(&patched(131, &f64::NAN.to_le_bytes())).contains("coordinate scale"));
    assert!(refused(&patched(105, &[34, 0])).contains("fields of 30 bytes in all, expected 34"));
    assert!(Tile::open(folder.path()).unwrap_err().to_string().contains("a folder, not a file"));
}

#[test]
fn a_chunk_count_out_of_all_proportion_does_not_take_the_memory() {
    let folder = tempdir().unwrap();
    for format in [1, 6] {
        let path = folder.path().join("a.laz");
        fixture::write(&path, Style { format, ..Style::default() }, &cloud(1000));
        let mut bytes = fs::read(&path).unwrap();
        let start = u32::from_le_bytes(bytes[96..100].try_into().unwrap()) as usize;
        let table = u64::from_le_bytes(bytes[start..start + 8].try_into().unwrap()) as usize;
        bytes[table + 4..table + 8].fill(0xff);
        fs::write(&path, bytes).unwrap();
        let (points, _) = read(&Tile::open(&path).unwrap());
        assert_same(&points, &cloud(1000));
    }
}

/// No damage may end the process; whatever is read is no more than announced.
#[test]
fn damage_anywhere_is_survived() {
    let folder = tempdir().unwrap();
    let mut random = 12_345_u64;
    let mut next = move |below: usize| {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (random >> 33) as usize % below
    };
    let mut opened = 0;
    for (format, name) in [(1, "a.las"), (3, "b.laz"), (7, "c.laz")] {
        let path = folder.path().join(name);
        fixture::write(&path, Style { format, ..Style::default() }, &cloud(200));
        let good = fs::read(&path).unwrap();
        for round in 0..700 {
            let mut bytes = good.clone();
            for _ in 0..=next(3) {
                // Two thirds of the damage go to the header and the first records.
                let within = if round % 3 == 0 { bytes.len() } else { 700.min(bytes.len()) };
                let at = 24 + next(within - 24);
                bytes[at] = [0, 0xff, 0x7f, next(256) as u8][next(4)];
            }
            bytes.truncate(bytes.len() - if round % 5 == 0 { next(good.len() / 2) } else { 0 });
            fs::write(&path, &bytes).unwrap();
            if let Ok(tile) = Tile::open(&path) {
                opened += 1;
                let (points, reading) = read(&tile);
                assert!(points.len() as u64 <= reading.read && reading.read <= reading.expected);
            }
        }
    }
    assert!(opened > 500, "only {opened} of the damaged files could be opened");
}

#[test]
fn absurd_coordinates_are_left_out_and_counted() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.las");
    fixture::write(&path, Style { format: 1, ..Style::default() }, &cloud(50));
    let mut bytes = fs::read(&path).unwrap();
    let start = u32::from_le_bytes(bytes[96..100].try_into().unwrap()) as usize;
    // x of the fourth record, 28 bytes each: 2 000 km.
    bytes[start + 3 * 28..start + 3 * 28 + 4].copy_from_slice(&2_000_000_000_i32.to_le_bytes());
    fs::write(&path, bytes).unwrap();
    let tile = Tile::open(&path).unwrap();
    let (points, reading) = read(&tile);
    assert_eq!(points.len(), 49);
    assert_eq!(reading.problems(&tile), [TileProblem::AbsurdCoordinates { tile: path, points: 1 }]);
}

#[test]
fn a_summary_counts_by_hand() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.laz");
    // Sixteen points in four cells of 4 m, a quarter of them second returns.
    let points: Vec<Plain> = (0..16)
        .map(|i| {
            (
                [100.0 + f64::from(i % 4) * 4.0 + 1.0, 200.0 + f64::from(i / 4) * 0.5, f64::from(i)],
                2 + (i % 2) as u8 * 4,
            )
        })
        .collect();
    fixture::write_with(&path, Style::default(), &points, |index, point| {
        point.number_of_returns = 2;
        point.return_number = if index % 4 == 3 { 2 } else { 1 };
        point.is_withheld = index == 0;
    });
    let summary = Tile::open(&path).unwrap().summary([1.0; 3]).unwrap();
    assert_eq!((summary.points, summary.points_stated, summary.withheld), (16, 16, 1));
    assert_eq!(summary.classes.into_iter().collect::<Vec<_>>(), [(2, 8), (6, 8)]);
    assert_eq!(summary.returns.into_iter().collect::<Vec<_>>(), [(1, 12), (2, 4)]);
    assert_eq!(summary.area, 64.0);
    assert_eq!((summary.density, summary.pulse_density), (0.25, Some(0.1875)));
    assert_eq!(summary.extent, Some([[101.0, 200.0, 0.0], [113.0, 201.5, 15.0]]));
    assert_eq!(summary.problems, []);
}

#[test]
fn edge_cases_of_the_shared_data() {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/data/edge-cases"));
    if !folder.exists() {
        println!("skipped: shared data not found");
        return;
    }
    let empty = Tile::open(folder.join("empty.laz")).unwrap();
    assert_eq!((empty.points, empty.extent.is_none()), (0, true));
    assert_eq!(read(&empty).0, []);
    let error = Tile::open(folder.join("truncated.laz")).unwrap_err().to_string();
    assert!(
        error.contains("never completed: the program that wrote it (PDAL 2.10.0 (Releas)) was interrupted"),
        "{error}"
    );
    let feet = Tile::open(folder.join("autzen-feet.laz")).unwrap().summary([0.3048; 3]).unwrap();
    assert_eq!(feet.points, 110_000);
    assert!(!feet.classes.contains_key(&6));
}
