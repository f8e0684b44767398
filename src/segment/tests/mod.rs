//! Made-up villages, from tiles to sites.

mod claims;
mod floors;
mod ground;
mod naming;
mod prepared;
mod real;
mod sweep;

use super::neighbourhood::{frame_of, polygon_to_local, snap};
use super::{BuildingClasses, GroundLevel, SegmentOptions, Segmentation, segment};
use crate::geometry::{PreparedPolygon, Random};
use crate::site::{GroundSource, Site};
use crate::source::crs::Crs;
use crate::source::footprints::{Attributes, Footprint};
use crate::source::points::fixture::{self, Plain, Style};
use crate::source::points::{Tile, TileProblem};
use geo::{Contains, Distance, Euclidean, MultiPolygon, Point, coord, polygon};
use nalgebra::Point3;
use proptest::prelude::*;
use serde_json::Map;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use tempfile::{TempDir, tempdir};

fn crs(metres: f64) -> Crs {
    Crs {
        wkt: String::new(),
        code: Some("EPSG:28992".into()),
        name: "Amersfoort / RD New".into(),
        metres_per_unit: [metres; 3],
        is_geographic: false,
    }
}

fn footprint(id: &str, polygon: MultiPolygon<f64>) -> Footprint {
    Footprint {
        id: id.into(),
        polygon,
        roofprint: None,
        attributes: Attributes::default(),
        notes: vec![format!("note of {id}")],
    }
}

fn block(x: [f64; 2], y: [f64; 2]) -> MultiPolygon<f64> {
    MultiPolygon::new(vec![polygon![(x: x[0], y: y[0]), (x: x[1], y: y[0]), (x: x[1], y: y[1]), (x: x[0], y: y[1])]])
}

/// Two houses that share a wall at x = 1020, the second 4 m higher, on ground at 1 m; about nine points per m².
fn village() -> (Vec<Plain>, Vec<Footprint>) {
    let mut points = Vec::new();
    for row in 0..150 {
        for column in 0..180 {
            let (x, y) = (1000.0 + f64::from(column) * 0.333, 5000.0 + f64::from(row) * 0.333);
            let built = (5010.0..5030.0).contains(&y);
            let point = match x {
                _ if built && (1010.0..1020.0).contains(&x) => ([x, y, 7.0 + f64::from(row % 3) * 0.01], 6),
                _ if built && (1020.0..1032.0).contains(&x) => ([x, y, 11.0 + f64::from(row % 3) * 0.01], 6),
                _ => ([x, y, 1.0 + f64::from((row + column) % 5) * 0.01], 2),
            };
            points.push(point);
        }
    }
    let houses = [("low", [1010.0, 1020.0]), ("high", [1020.0, 1032.0])];
    (points, houses.map(|(id, x)| footprint(id, block(x, [5010.0, 5030.0]))).into())
}

struct Cloud {
    folder: TempDir,
    tiles: Vec<PathBuf>,
}

impl Cloud {
    fn new() -> Self {
        Self { folder: tempdir().unwrap(), tiles: Vec::new() }
    }

    fn tile(mut self, name: &str, style: Style, points: &[Plain]) -> Self {
        let path = self.folder.path().join(name);
        fixture::write(&path, style, points);
        self.tiles.push(path);
        self
    }

    fn segment(&self, footprints: &[Footprint], options: &SegmentOptions) -> crate::error::Result<Segmentation> {
        let tiles: Vec<_> = self.tiles.iter().map(|path| Tile::open(path).unwrap()).collect();
        let done = AtomicU64::new(0);
        let progress = |n: u64| {
            done.fetch_add(n, Ordering::Relaxed);
        };
        let result = segment(&tiles, footprints.to_vec(), &crs(1.0), options, &progress, None);
        if result.is_ok() {
            assert_eq!(done.into_inner(), tiles.iter().map(|tile| tile.points).sum::<u64>());
        }
        result
    }
}

/// Id, building points, ground points, ground along the outline, numbers, and where the ground comes from.
type Bits = (String, Vec<[u64; 3]>, Vec<[u64; 3]>, Vec<[u64; 3]>, [u64; 3], GroundSource);

/// Every bit of the sites that comes from the points.
fn bits(sites: &[Site]) -> Vec<Bits> {
    let of = |site: &Site| {
        let points = |of: &[Point3<f64>]| of.iter().map(|p| [p.x, p.y, p.z].map(f64::to_bits)).collect();
        let numbers = [site.ground.height, site.ground.spread, site.coverage.share].map(f64::to_bits);
        let [own, inside, line] = [&site.points, &site.ground_points, &site.ground_line].map(|of| points(of));
        (site.id.clone(), own, inside, line, numbers, site.ground.source)
    };
    sites.iter().map(of).collect()
}

#[test]
fn houses_get_their_points_their_ground_and_their_notes() {
    let (points, footprints) = village();
    let cloud = Cloud::new().tile("a.laz", Style::default(), &points);
    let found = cloud.segment(&footprints, &SegmentOptions::default()).unwrap();
    assert_eq!(found.notes, [["note of low"], ["note of high"]]);
    let [low, high] = &found.sites[..] else { panic!() };
    let expected = |x: [f64; 2]| points.iter().filter(|(p, class)| *class == 6 && (x[0]..x[1]).contains(&p[0])).count();
    assert_eq!(low.points.len(), expected([1010.0, 1020.0]));
    assert_eq!(high.points.len(), expected([1020.0, 1032.0]));
    assert_eq!(low.frame.origin, [1010.0, 5010.0, 0.0]);
    assert!(low.points.iter().all(|p| (0.0..=10.0).contains(&p.x) && (p.z - 7.01).abs() < 0.011));
    assert!(low.points.is_sorted_by(|a, b| (a.x, a.y, a.z) < (b.x, b.y, b.z)));
    for site in [low, high] {
        assert_eq!(site.ground.source, GroundSource::GroundPoints);
        assert!((site.ground.height - 1.02).abs() < 0.006, "{:?}", site.ground);
        assert!((0.0..=0.04).contains(&site.ground.spread));
        assert_eq!(site.coverage.share, 1.0);
    }
    assert_eq!(found.counts.kept, (low.points.len() + high.points.len()) as u64);
    assert_eq!(found.counts.read, points.len() as u64);
    assert_eq!(found.problems, []);
}

#[test]
fn order_tiling_overlap_duplicates_and_threads_change_nothing() {
    let (points, footprints) = village();
    let options = SegmentOptions::default();
    let whole = Cloud::new().tile("a.laz", Style::default(), &points).segment(&footprints, &options).unwrap();
    let expected = bits(&whole.sites);

    let mut reversed = points.clone();
    reversed.reverse();
    let style = Style { version: (1, 2), format: 1, scale: 0.0005, offset: [1000.5, 5000.25, -3.0] };
    let cloud = Cloud::new().tile("a.las", style, &reversed);
    assert_eq!(bits(&cloud.segment(&footprints, &options).unwrap().sites), expected);

    let part = |east: bool, north: bool| {
        let wanted = |p: &&Plain| (p.0[0] >= 1018.1) == east && (p.0[1] >= 5017.0) == north;
        points.iter().filter(wanted).copied().collect::<Vec<_>>()
    };
    let offsets = [[0.0; 3], [1000.0, 5000.0, 0.0], [123.456, 7.89, 1.0], [-1e5, 2e5, 100.0]];
    let parts = [part(false, false), part(true, false), part(false, true), part(true, true)];
    let mut cut = Cloud::new();
    for (index, (offset, part)) in offsets.into_iter().zip(&parts).enumerate() {
        cut = cut.tile(&format!("{index}.laz"), Style { offset, ..Style::default() }, part);
    }
    assert_eq!(bits(&cut.segment(&footprints, &options).unwrap().sites), expected, "cut in four");
    cut.tiles.reverse();
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let found = pool.install(|| cut.segment(&footprints, &options)).unwrap();
        assert_eq!(bits(&found.sites), expected, "{threads} threads");
    }
    let again = cut.tile("again.laz", Style::default(), &points);
    let found = again.segment(&footprints, &options).unwrap();
    assert_eq!(bits(&found.sites), expected, "given twice");
    assert_eq!(found.counts.dropped.duplicate, whole.counts.kept);

    // A site does not know its neighbours.
    let alone = again.segment(&footprints[..1], &options).unwrap();
    assert_eq!(bits(&alone.sites), expected[..1]);
}

#[test]
fn a_foot_is_not_a_metre() {
    let (points, footprints) = village();
    let per_foot = 0.3048;
    let feet: Vec<Plain> = points.iter().map(|(p, class)| (p.map(|v| v / per_foot), *class)).collect();
    let scaled = |polygon: &MultiPolygon<f64>| {
        geo::MapCoords::map_coords(polygon, |c| coord! { x: c.x / per_foot, y: c.y / per_foot })
    };
    let footprints: Vec<_> = footprints.iter().map(|f| footprint(&f.id, scaled(&f.polygon))).collect();
    let cloud = Cloud::new().tile("a.laz", Style { scale: 0.0001, ..Style::default() }, &feet);
    let tiles = [Tile::open(&cloud.tiles[0]).unwrap()];
    let found = segment(&tiles, footprints, &crs(per_foot), &SegmentOptions::default(), &|_| {}, None).unwrap();
    let low = &found.sites[0];
    assert!((low.ground.height - 1.02).abs() < 0.006, "{:?}", low.ground);
    let (x, y) = low.points.iter().fold((0.0_f64, 0.0_f64), |(x, y), p| (x.max(p.x), y.max(p.y)));
    assert!((9.0..10.5).contains(&x) && (19.0..20.5).contains(&y), "{x} {y}");
    assert!((low.points[0].z - 7.0).abs() < 0.03);
}

#[test]
fn flagged_and_noise_points_are_dropped() {
    let (mut points, footprints) = village();
    let base = points.len();
    points.extend([([1015.0, 5020.0, 3.0], 7), ([1015.1, 5020.0, 3.0], 18), ([1015.2, 5020.0, 3.0], 6)]);
    points.extend([([1015.3, 5020.0, 3.0], 6)]);
    let cloud = Cloud::new();
    let path = cloud.folder.path().join("a.laz");
    fixture::write_with(&path, Style::default(), &points, |index, point| {
        point.is_withheld = index == base + 2;
        point.is_synthetic = index == base + 3;
    });
    let found = Cloud { tiles: vec![path], ..cloud }.segment(&footprints, &SegmentOptions::default()).unwrap();
    assert!(found.sites[0].points.iter().all(|p| p.z > 6.9));
    let dropped = found.counts.dropped;
    assert_eq!((dropped.noise, dropped.withheld, dropped.synthetic), (2, 1, 1));
}

#[test]
fn unclassified_clouds_work_with_any() {
    let (points, footprints) = village();
    // A hedge and a car inside the footprint's box are low; the ground has no class.
    let unclassified: Vec<Plain> = points.iter().map(|(p, _)| (*p, 1)).collect();
    let cloud = Cloud::new().tile("a.laz", Style::default(), &unclassified);
    let error = cloud.segment(&footprints, &SegmentOptions::default()).unwrap_err().to_string();
    assert!(error.contains("no point of building class 6; the classes are 1 (27000 points)"), "{error}");
    assert!(error.contains("--building-class any"), "{error}");

    let options = SegmentOptions { building_classes: "any".parse().unwrap(), ..SegmentOptions::default() };
    let found = cloud.segment(&footprints, &options).unwrap();
    let (points, footprints_again) = village();
    let classified = Cloud::new().tile("a.laz", Style::default(), &points);
    let reference = classified.segment(&footprints_again, &SegmentOptions::default()).unwrap();
    for (site, expected) in found.sites.iter().zip(&reference.sites) {
        assert_eq!(site.points, expected.points);
        assert_eq!(site.ground.source, GroundSource::LowestPoints);
        assert!((0.999..=1.02).contains(&site.ground.height), "{:?}", site.ground);
    }
}

#[test]
fn a_footprint_at_the_edge_of_the_tiles_is_incomplete() {
    let (points, mut footprints) = village();
    footprints.push(footprint("edge", block([1050.0, 1070.0], [5010.0, 5030.0])));
    footprints.push(footprint("outside", block([1500.0, 1510.0], [5010.0, 5030.0])));
    let cloud = Cloud::new().tile("a.laz", Style::default(), &points);
    let found = cloud.segment(&footprints, &SegmentOptions::default()).unwrap();
    let complete: Vec<_> = found.sites.iter().map(|site| site.coverage.is_complete()).collect();
    assert_eq!(complete, [true, true, false, false]);
    // The cloud ends at x = 1059.607.
    assert!((found.sites[2].coverage.share - 9.607 / 20.0).abs() < 1e-6);
    assert_eq!((found.sites[3].coverage.share, found.sites[3].points.len()), (0.0, 0));
}

#[test]
fn what_cannot_be_segmented_is_refused_with_a_reason() {
    let (points, footprints) = village();
    let options = SegmentOptions::default();
    let cloud = Cloud::new().tile("a.laz", Style::default(), &points);
    let elsewhere = [footprint("x", block([4.0, 5.0], [52.0, 53.0]))];
    let error = cloud.segment(&elsewhere, &options).unwrap_err().to_string();
    assert!(error.contains("no overlap"), "{error}");
    assert!(error.contains("x 4.00 to 5.00, y 52.00 to 53.00 in EPSG:28992 (Amersfoort / RD New)"), "{error}");
    assert!(error.contains("x 1000.00 to 1059.61, y 5000.00 to 5049.62 in EPSG:28992"), "{error}");
    let empty = Cloud::new().tile("a.laz", Style::default(), &[]);
    assert!(empty.segment(&footprints, &options).unwrap_err().to_string().contains("no point in 1 tiles"));
    for (bad, name) in [
        (SegmentOptions { ring_width: 0.0, ..SegmentOptions::default() }, "ring_width"),
        (SegmentOptions { ground_percentile: 101.0, ..SegmentOptions::default() }, "ground_percentile"),
        (SegmentOptions { hover_gap: f64::NAN, ..SegmentOptions::default() }, "hover_gap"),
    ] {
        assert!(cloud.segment(&footprints, &bad).unwrap_err().to_string().contains(name));
    }
    let degrees = Crs { is_geographic: true, ..crs(1.0) };
    let error = segment(&[], footprints, &degrees, &options, &|_| {}, None).unwrap_err().to_string();
    assert!(error.contains("expected a projected CRS"), "{error}");
}

#[test]
fn a_tile_that_is_cut_off_is_used_and_told() {
    let (points, footprints) = village();
    let cloud = Cloud::new().tile("a.las", Style { format: 1, ..Style::default() }, &points);
    let bytes = std::fs::read(&cloud.tiles[0]).unwrap();
    std::fs::write(&cloud.tiles[0], &bytes[..bytes.len() / 2]).unwrap();
    let found = cloud.segment(&footprints, &SegmentOptions::default()).unwrap();
    assert!(matches!(&found.problems[..], [TileProblem::MissingPoints { expected: 27_000, .. }]));
    assert!(!found.sites[0].points.is_empty());
    assert!(!found.sites[0].coverage.is_complete(), "{:?}", found.sites[0].coverage);
}

#[test]
fn building_classes_are_a_list_or_any() {
    let parsed: BuildingClasses = "1, 6".parse().unwrap();
    assert_eq!((parsed.to_string().as_str(), &parsed), ("1,6", &BuildingClasses::Listed(vec![1, 6])));
    assert!("ANY".parse::<BuildingClasses>().unwrap().is_any());
    assert!("6,roof".parse::<BuildingClasses>().unwrap_err().contains("'6,roof'"));
    let options: SegmentOptions = serde_json::from_str(r#"{"building_classes": "any", "ring_width": 4}"#).unwrap();
    assert!(options.building_classes.is_any() && options.ring_width == 4.0);
    assert!(serde_json::from_str::<SegmentOptions>(r#"{"ring": 4}"#).is_err());
}
