use super::neighbourhood::{frame_of, polygon_to_local, snap};
use super::prepared::Prepared;
use super::{BuildingClasses, SegmentOptions, Segmentation, segment};
use crate::site::{GroundSource, Site};
use crate::source::crs::Crs;
use crate::source::footprints::Footprint;
use crate::source::points::fixture::{self, Plain, Style};
use crate::source::points::{Tile, TileProblem};
use geo::{Contains, Distance, Euclidean, MultiPolygon, Point, coord, polygon};
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
    Footprint { id: id.into(), polygon, attributes: Map::new(), notes: vec![format!("note of {id}")] }
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
        let result = segment(&tiles, footprints.to_vec(), &crs(1.0), options, &progress);
        if result.is_ok() {
            assert_eq!(done.into_inner(), tiles.iter().map(|tile| tile.points).sum::<u64>());
        }
        result
    }
}

/// Id, points, numbers, and where the ground comes from.
type Bits = (String, Vec<[u64; 3]>, [u64; 3], GroundSource);

/// Every bit of the sites that comes from the points.
fn bits(sites: &[Site]) -> Vec<Bits> {
    let of = |site: &Site| {
        let points = site.points.iter().map(|p| [p.x, p.y, p.z].map(f64::to_bits)).collect();
        let numbers = [site.ground.height, site.ground.spread, site.coverage.share].map(f64::to_bits);
        (site.id.clone(), points, numbers, site.ground.source)
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
        assert!((0.999..=1.01).contains(&site.ground.height), "{:?}", site.ground);
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
    let found = segment(&tiles, footprints, &crs(per_foot), &SegmentOptions::default(), &|_| {}).unwrap();
    let low = &found.sites[0];
    assert!((low.ground.height - 1.0).abs() < 0.01, "{:?}", low.ground);
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
fn ground_on_a_slope_is_that_of_the_low_side() {
    // 10 % downwards to the east; the footprint spans 10 m, the ring 3 m more on either side.
    let mut points: Vec<Plain> = Vec::new();
    for i in 0..120 {
        for j in 0..120 {
            let (x, y) = (f64::from(i) * 0.5, f64::from(j) * 0.5);
            let roof = (20.0..30.0).contains(&x) && (20.0..30.0).contains(&y);
            points.push(if roof { ([x, y, 20.0], 6) } else { ([x, y, 10.0 - 0.1 * x], 2) });
        }
    }
    // A hole in the ground, and ground inside another building, are not the ground.
    points.extend([([31.5, 25.0, -20.0], 2), ([18.5, 25.1, 100.0], 2)]);
    let footprints =
        [footprint("a", block([20.0, 30.0], [20.0, 30.0])), footprint("b", block([10.0, 20.0], [20.0, 30.0]))];
    let cloud = Cloud::new().tile("a.laz", Style::default(), &points);
    let found = cloud.segment(&footprints[..1], &SegmentOptions::default()).unwrap();
    let ground = found.sites[0].ground;
    // The ring lies between x = 17 and 33: between 6.7 and 8.3 m.
    assert!((6.7..6.9).contains(&ground.height), "{ground:?}");
    assert!((0.5..1.6).contains(&ground.spread), "{ground:?}");
    // Between two neighbours the ring keeps to the free sides.
    let found = cloud.segment(&footprints, &SegmentOptions::default()).unwrap();
    assert!(found.sites[0].ground.height < 7.0 && found.sites[0].ground.spread < ground.spread);
}

#[test]
fn ground_falls_back_and_says_so() {
    let (points, footprints) = village();
    let roofs: Vec<Plain> = points.iter().filter(|(_, class)| *class == 6).copied().collect();
    let far: Vec<Plain> = points.iter().filter(|(p, c)| *c == 6 || p[0] > 1045.0).copied().collect();
    let options = SegmentOptions::default();
    let ground = |points: &[Plain], options: &SegmentOptions| {
        let cloud = Cloud::new().tile("a.laz", Style::default(), points);
        cloud.segment(&footprints, options).unwrap().sites[0].ground
    };
    // Ground 25 m away is out of reach; then the lowest points inside are the roof.
    assert_eq!(ground(&far, &options).source, GroundSource::LowestPoints);
    assert!((ground(&far, &options).height - 7.0).abs() < 0.02);
    // 13 m away it is found by widening.
    let near: Vec<Plain> = points.iter().filter(|(p, c)| *c == 6 || p[0] > 1033.0).copied().collect();
    assert_eq!(ground(&near, &options).source, GroundSource::GroundPoints);
    let three = [([1011.0, 5011.0, 4.0], 6), ([1012.0, 5011.0, 5.0], 6), ([1013.0, 5015.0, 6.0], 6)];
    let last = ground(&three, &options);
    assert_eq!((last.source, last.height), (GroundSource::BoundingBox, 4.0));
    assert_eq!(ground(&roofs, &options).source, GroundSource::LowestPoints);
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
    let error = segment(&[], footprints, &degrees, &options, &|_| {}).unwrap_err().to_string();
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

/// A star-shaped polygon with a hole, by the radii of its corners.
fn star(radii: &[f64]) -> MultiPolygon<f64> {
    let corner = |(i, r): (usize, &f64)| {
        let angle = std::f64::consts::TAU * i as f64 / radii.len() as f64;
        (r * angle.cos(), r * angle.sin())
    };
    let outer: Vec<_> = radii.iter().enumerate().map(corner).collect();
    let inner: Vec<_> = outer.iter().map(|(x, y)| (0.4 * x, 0.4 * y)).collect();
    MultiPolygon::new(vec![geo::Polygon::new(outer.into(), vec![inner.into()])])
}

proptest! {
    #[test]
    fn prepared_polygons_answer_like_geo(
        radii in prop::collection::vec(2.0..10.0_f64, 3..60),
        places in prop::collection::vec((-12.0..12.0_f64, -12.0..12.0_f64), 50),
    ) {
        let polygon = star(&radii);
        let prepared = Prepared::new(&polygon);
        let boundary = |p: Point<f64>| {
            let rings = polygon.0.iter().flat_map(|p| std::iter::once(p.exterior()).chain(p.interiors()));
            rings.map(|ring| Euclidean.distance(&p, ring)).fold(f64::INFINITY, f64::min)
        };
        for (x, y) in places {
            let place = Point::new(x, y);
            let expected = boundary(place);
            if expected > 1e-9 {
                prop_assert_eq!(prepared.contains([x, y]), polygon.contains(&place));
            }
            let found = prepared.boundary_distance([x, y], 3.0);
            let at_limit = (expected - 3.0).abs() < 1e-9;
            let agrees = if expected > 3.0 { found.is_infinite() } else { (found - expected).abs() < 1e-9 };
            prop_assert!(at_limit || agrees, "{} is not {}", found, expected);
        }
    }

    #[test]
    fn points_of_a_shared_edge_belong_to_one_side(ends in prop::array::uniform4(-100_000..100_000_i32), t in 1..1000_i32) {
        let [x0, y0, x1, y1] = ends.map(|v| f64::from(v) * 1e-3 + 85_000.0);
        let (dx, dy) = (x1 - x0, y1 - y0);
        prop_assume!(dx.hypot(dy) > 0.1);
        // Two triangles on either side of the edge, each in its own frame.
        let triangle = |side: f64| {
            let apex = (x0 + dx / 2.0 - side * dy, y0 + dy / 2.0 + side * dx);
            MultiPolygon::new(vec![geo::Polygon::new(vec![(x0, y0), (x1, y1), apex].into(), vec![])])
        };
        let at = f64::from(t) / 1000.0;
        let place = [snap(x0 + at * dx), snap(y0 + at * dy), 0.0];
        let inside = [1.0, -1.0].map(|side| {
            let polygon = triangle(side);
            let frame = frame_of(&polygon, &crs(1.0));
            let [x, y, _] = super::neighbourhood::to_local(&frame, place);
            let prepared = Prepared::new(&polygon_to_local(&frame, &polygon));
            (prepared.contains([x, y]), prepared.boundary_distance([x, y], 1.0))
        });
        prop_assert!(inside.iter().all(|(_, distance)| *distance < 1e-5));
        let on_it = inside.iter().any(|(_, distance)| *distance < 1e-9);
        prop_assert!(on_it || inside[0].0 != inside[1].0);
    }
}

fn shared(name: &str) -> Option<PathBuf> {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/data")).join(name);
    if !path.exists() {
        println!("skipped: shared data not found");
    }
    path.exists().then_some(path)
}

fn geojson_footprints(path: &Path, id: &str) -> Vec<Footprint> {
    let text = std::fs::read_to_string(path).unwrap();
    let collection: geojson::FeatureCollection = text.parse::<geojson::GeoJson>().unwrap().try_into().unwrap();
    let of = |feature: &geojson::Feature| {
        let geometry: geo::Geometry<f64> = feature.geometry.clone().unwrap().try_into().unwrap();
        let polygon = match geometry {
            geo::Geometry::Polygon(polygon) => MultiPolygon::new(vec![polygon]),
            geo::Geometry::MultiPolygon(polygon) => polygon,
            other => panic!("{other:?}"),
        };
        footprint(feature.property(id).unwrap().as_str().unwrap(), polygon)
    };
    collection.features.iter().map(of).collect()
}

#[test]
fn delft_gives_what_a_plain_count_gives() {
    let Some(folder) = shared("delft-quickstart") else { return };
    let footprints = geojson_footprints(&folder.join("footprints.geojson"), "id");
    let tile = Tile::open(folder.join("delft_ahn3.laz")).unwrap();
    let found = segment(&[tile], footprints.clone(), &crs(1.0), &SegmentOptions::default(), &|_| {}).unwrap();
    assert_eq!(found.sites.len(), 71);
    assert_eq!(found.counts.read, 141_577);
    assert_eq!(
        found.counts.classes.iter().map(|(c, n)| (*c, *n)).collect::<Vec<_>>(),
        [(1, 41_029), (2, 54_879), (6, 45_646), (9, 23)]
    );
    assert!(found.sites.iter().filter(|site| site.points.len() >= 50).count() >= 66);

    let mut plain = vec![0; footprints.len()];
    let mut reader = las::Reader::from_path(folder.join("delft_ahn3.laz")).unwrap();
    for point in reader.read_all().unwrap().points() {
        let point = point.unwrap();
        if u8::from(point.classification) == 6 {
            let place = Point::new(point.x, point.y);
            plain.iter_mut().zip(&footprints).filter(|(_, f)| f.polygon.contains(&place)).for_each(|(n, _)| *n += 1);
        }
    }
    let dropped = found.counts.dropped;
    let kept: usize = found.sites.iter().map(|site| site.points.len()).sum();
    let lost = (dropped.duplicate + dropped.hovering + dropped.beyond_party_wall) as usize;
    assert!((kept + lost).abs_diff(plain.iter().sum()) <= 2, "{kept} + {lost} of {}", plain.iter().sum::<usize>());
    assert!(lost * 200 < kept, "{dropped:?}");
    println!("{:?}", found.counts);

    // The makers of the reference state the ground that they found, from the same points.
    let text = std::fs::read_to_string(folder.join("reference_3dbag_lod22.city.jsonl")).unwrap();
    let mut differences = Vec::new();
    for line in text.lines().skip(1) {
        let feature: serde_json::Value = serde_json::from_str(line).unwrap();
        for (id, object) in feature["CityObjects"].as_object().unwrap() {
            let stated = object["attributes"]["h_maaiveld"].as_f64();
            if let (Some(stated), Some(site)) = (stated, found.sites.iter().find(|site| site.id == *id)) {
                println!("{id} {stated:.3} {:.3} spread {:.3}", site.ground.height, site.ground.spread);
                differences.push((site.ground.height - stated).abs());
            }
        }
    }
    differences.sort_by(f64::total_cmp);
    println!("{differences:?}");
    assert!(differences.len() >= 10 && differences[differences.len() / 2] < 0.1, "{differences:?}");
}

#[test]
fn amsterdam_reports_what_the_tile_edge_cuts() {
    let Some(folder) = shared("amsterdam-dense") else { return };
    let text = std::fs::read_to_string(folder.join("footprints.geojson")).unwrap();
    let id = if text.contains("\"identificatie\"") { "identificatie" } else { "id" };
    let footprints = geojson_footprints(&folder.join("footprints.geojson"), id);
    let tiles = ["ahn_2386_9702.laz", "ahn_2397_9705.laz"].map(|name| Tile::open(folder.join(name)).unwrap());
    let found = segment(&tiles, footprints, &crs(1.0), &SegmentOptions::default(), &|_| {}).unwrap();
    for site in &found.sites {
        println!("{} {} points, {:?}, {:?}", site.id, site.points.len(), site.ground, site.coverage);
    }
    println!("{:?}", found.counts);
    let complete = found.sites.iter().filter(|site| site.coverage.is_complete()).count();
    assert!(complete > 0 && complete < found.sites.len(), "{complete} of {}", found.sites.len());
}
