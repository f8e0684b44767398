use super::fixture::{self, Plain, Style};
use super::{ScanPoint, Tile, TileProblem, expand};
use std::fs;
use std::path::{Path, PathBuf};
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

/// Times of four scanners that jump, stand still, run on and change their pace: everything that the coder knows.
fn interleaved_times(format: u8, index: usize, point: &mut las::Point) {
    let i = index as u64;
    let mixed = i.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40;
    let base = [1e5, 3e8, -2.5, 7.25e3][index % 4];
    let pace = [1e-5, 3e-4, 0.5, 1e-9][index / 40 % 4];
    let time = if mixed.is_multiple_of(97) { f64::from_bits(mixed << 20) } else { base + pace * (i / 7) as f64 };
    point.gps_time = Some(time + if mixed.is_multiple_of(11) { 60.0 } else { 0.0 });
    if format >= 6 && index > 500 {
        point.scanner_channel = (mixed / 7 % 4) as u8;
    }
    point.number_of_returns = (mixed % 5 + 1) as u8;
    point.return_number = (mixed / 5 % 5 + 1) as u8;
}

#[test]
fn times_are_decoded_as_they_were_written() {
    let folder = tempdir().unwrap();
    for format in [1, 3, 6, 7] {
        let path = folder.path().join("a.laz");
        fixture::write_with(&path, Style { format, ..Style::default() }, &cloud(120_000), |index, point| {
            interleaved_times(format, index, point);
        });
        let written = |index| {
            let mut point = las::Point::default();
            interleaved_times(format, index, &mut point);
            point.gps_time.unwrap().to_bits()
        };
        let expected: Vec<u64> = (0..120_000).map(written).collect();
        let at = if format < 6 { 20 } else { 22 };
        let mut times = Vec::new();
        let reading = Tile::open(&path).unwrap().stream_records(None, &mut |block| {
            times.extend(block.records().map(|r| u64::from_le_bytes(r[at..at + 8].try_into().unwrap())));
            std::ops::ControlFlow::Continue(())
        });
        assert_eq!(reading.unwrap().read, 120_000);
        assert!(times == expected, "format {format}");
    }
}

/// The decoder of the laz crate calls itself on such data until the stack overflows.
#[test]
fn times_that_change_their_sequence_without_end_cost_their_chunk_only() {
    let folder = tempdir().unwrap();
    for format in [1, 6] {
        let path = folder.path().join("a.laz");
        fixture::write_with(&path, Style { format, ..Style::default() }, &cloud(120_000), |index, point| {
            interleaved_times(format, index, point);
        });
        let mut bytes = fs::read(&path).unwrap();
        let first = u32::from_le_bytes(bytes[96..100].try_into().unwrap()) as usize + 8;
        if format == 1 {
            bytes[first + 40_000..first + 70_000].fill(0xff);
        } else {
            let sizes = &bytes[first + 34..first + 70];
            let sizes: Vec<usize> = sizes.as_chunks::<4>().0.iter().map(|s| u32::from_le_bytes(*s) as usize).collect();
            let times = first + 70 + sizes[..8].iter().sum::<usize>();
            assert!(sizes[8] > 60_000);
            bytes[times + 8..times + sizes[8]].fill(0xff);
        }
        fs::write(&path, bytes).unwrap();
        let tile = Tile::open(&path).unwrap();
        let mut read = 0;
        let visit = &mut |block: &super::Block| {
            read += block.len();
            std::ops::ControlFlow::Continue(())
        };
        let reading = tile.stream_records(None, visit).unwrap();
        assert!((70_000..120_000).contains(&read), "format {format}: {read}");
        let told = reading.problems(&tile)[0].to_string();
        assert!(told.contains(&format!("a.laz: {} of 120000 points are missing", 120_000 - read)), "{told}");
        assert!(told.contains(&format!("in the chunk at byte {first}: the GPS times are damaged")), "{told}");
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
    assert_eq!((summary.density, summary.pulse_density), (0.25, 0.1875));
    assert_eq!(summary.extent, Some([[101.0, 200.0, 0.0], [113.0, 201.5, 15.0]]));
    assert_eq!(summary.problems, []);
}

#[test]
fn arguments_become_sorted_tiles_without_duplicates() {
    let folder = tempdir().unwrap();
    let touch = |name: &str| {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, "").unwrap();
        path
    };
    let (a, b, c) = (touch("b/a.LAS"), touch("b/b.copc.laz"), touch("c.laz"));
    touch("b/readme.txt");
    fs::create_dir(folder.path().join("empty")).unwrap();
    let arg = |path: PathBuf| path.display().to_string();
    let inside = |name: &str| arg(folder.path().join(name));
    assert_eq!(
        expand(&[arg(c.clone()), inside("b"), inside("b/../c.laz")]).unwrap(),
        [a.clone(), b.clone(), c.clone()]
    );
    assert_eq!(expand(&[inside("**/*")]).unwrap(), [a, b, c]);
    let refused = |name: &str| expand(&[inside(name)]).unwrap_err().to_string();
    assert!(refused("d.laz").contains("no such file or folder"));
    assert!(refused("d*.laz").contains("matches no .las or .laz file"));
    assert!(refused("empty").contains("a folder without .las or .laz files"));
    assert!(refused("[").contains("malformed"));
    assert!(expand(&[]).unwrap_err().to_string().contains("no argument"));
}

#[cfg(unix)]
#[test]
fn links_that_lead_back_do_not_make_a_pattern_endless() {
    let folder = tempdir().unwrap();
    for name in ["a", "b", "c", "d", "e", "f"] {
        let inner = folder.path().join(name);
        fs::create_dir(&inner).unwrap();
        fs::write(inner.join("tile.laz"), "").unwrap();
        for back in ["1", "2", "3"] {
            std::os::unix::fs::symlink("..", inner.join(back)).unwrap();
        }
    }
    let pattern = |tail: &str| folder.path().join(tail).display().to_string();
    assert_eq!(expand(&[pattern("**/*.laz")]).unwrap().len(), 6);
    assert_eq!(expand(&[pattern("**/tile.laz")]).unwrap().len(), 6);
    assert_eq!(expand(&[pattern("a/**/t*.laz")]).unwrap(), [folder.path().join("a/tile.laz")]);
    // A link before the first wildcard is meant.
    assert_eq!(expand(&[pattern("a/1/b/**/*.laz")]).unwrap(), [folder.path().join("a/1/b/tile.laz")]);
    assert!(expand(&[pattern("**/*.las")]).unwrap_err().to_string().contains("matches no .las or .laz file"));
}

#[test]
fn copc_is_read_where_it_is_wanted() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.copc.laz");
    let node = |x: f64, y: f64, n: u32| (0..n).map(|i| ([x + f64::from(i) * 0.01, y, 1.0], 6)).collect::<Vec<_>>();
    let nodes = vec![
        ([0, 0, 0, 0], node(10.0, 10.0, 30)),
        ([1, 0, 0, 0], node(20.0, 20.0, 200)),
        ([1, 1, 0, 0], node(70.0, 20.0, 300)),
        ([1, 1, 1, 0], node(70.0, 70.0, 400)),
    ];
    fixture::write_copc(&path, &nodes);
    let tile = Tile::open(&path).unwrap();
    assert!(tile.is_copc);
    assert_eq!(tile.points, 930);
    let (all, _) = read(&tile);
    assert_same(&all, &nodes.iter().flat_map(|(_, p)| p.clone()).collect::<Vec<_>>());

    // Something at (80, 80): the root and the node that covers it, in the order of the file.
    let wanted = |low: [f64; 2], high: [f64; 2]| low[0] <= 80.0 && 80.0 <= high[0] && low[1] <= 80.0 && 80.0 <= high[1];
    let mut points = Vec::new();
    let reading = tile.stream(Some(&wanted), &mut |block| points.extend(block.points())).unwrap();
    assert_same(&points, &[nodes[0].1.clone(), nodes[3].1.clone()].concat());
    assert_eq!((reading.expected, reading.read, reading.passed_over), (430, 430, 500));

    // Cut within the last node: the hierarchy is lost and the chunk table too, but not the nodes before.
    let bytes = fs::read(&path).unwrap();
    let cut = bytes.len() - 128 - 125 - 60;
    fs::write(&path, &bytes[..cut]).unwrap();
    let tile = Tile::open(&path).unwrap();
    assert!(!tile.is_copc);
    let (points, reading) = read(&tile);
    assert_same(&points, &nodes[..3].iter().flat_map(|(_, p)| p.clone()).collect::<Vec<_>>());
    assert_eq!(reading.problems(&tile).len(), 1);
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
