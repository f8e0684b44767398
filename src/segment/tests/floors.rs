//! Floors that do not come from the ground around: stated, of neighbours, and guessed.

use super::*;
use crate::site::Ground;
use serde_json::json;
use tiff::encoder::TiffEncoder;
use tiff::encoder::colortype::Gray32Float;
use tiff::tags::Tag;

/// Four houses of 10 m, 40 m apart, on a plane that rises by 1 % to the east; their walls are scanned if `walls`, the ground
/// around those in `grounded`.
fn street(walls: bool, grounded: &[usize]) -> (Vec<Plain>, Vec<Footprint>) {
    let mut random = Random::new(3);
    let mut points = Vec::new();
    let mut houses = Vec::new();
    for house in 0..4 {
        let (x, y) = (1000.0 + 40.0 * house as f64, 5000.0);
        let floor = floor(house);
        for _ in 0..1000 {
            points.push(([random.between(x, x + 10.0), random.between(y, y + 10.0), floor + 6.0], 6));
        }
        for _ in 0..if walls { 200 } else { 0 } {
            points.push(([random.between(x, x + 10.0), y + 0.02, floor + random.between(0.0, 6.0)], 6));
        }
        for _ in 0..if grounded.contains(&house) { 2000 } else { 0 } {
            let place = [random.between(x - 5.0, x + 15.0), random.between(y - 5.0, y)];
            points.push(([place[0], place[1], floor], 2));
        }
        houses.push(footprint(&house.to_string(), block([x, x + 10.0], [y, y + 10.0])));
    }
    (points, houses)
}

fn floor(house: usize) -> f64 {
    2.0 + 0.4 * house as f64
}

fn grounds(points: &[Plain], houses: &[Footprint], options: &SegmentOptions) -> Vec<Ground> {
    let found = Cloud::new().tile("a.laz", Style::default(), points).segment(houses, options).unwrap();
    found.sites.iter().map(|site| site.ground).collect()
}

#[test]
fn walls_tell_their_foot() {
    let (points, houses) = street(true, &[]);
    for (house, ground) in grounds(&points, &houses, &SegmentOptions::default()).iter().enumerate() {
        assert_eq!(ground.source, GroundSource::LowestPoints);
        assert!((ground.height - floor(house)).abs() < 0.1, "{house} {ground:?}");
    }
}

#[test]
fn neighbours_on_ground_tell_the_floor_between_them() {
    let (points, houses) = street(false, &[0, 1, 3]);
    let found = grounds(&points, &houses, &SegmentOptions::default());
    assert_eq!(found[2].source, GroundSource::Neighbours);
    // Three neighbours give a level, not a slope: it lies between them.
    assert!((2.0..=3.2).contains(&found[2].height), "{:?}", found[2]);
    assert!([0, 1, 3].iter().all(|i| found[*i].source == GroundSource::GroundPoints));
    // Walls that reach lower know better.
    let (points, houses) = street(true, &[0, 1, 3]);
    let found = grounds(&points, &houses, &SegmentOptions::default());
    assert_eq!(found[2].source, GroundSource::LowestPoints);
    // Two neighbours are none.
    let (points, houses) = street(false, &[0, 1]);
    assert_eq!(grounds(&points, &houses, &SegmentOptions::default())[2].source, GroundSource::BoundingBox);
}

#[test]
fn an_attribute_goes_first_and_what_is_no_number_is_told() {
    let (points, mut houses) = street(false, &[0, 1, 2, 3]);
    for (house, value) in [(0, json!(1.25)), (1, json!(" 2.5 ")), (2, json!("unknown"))] {
        houses[house].attributes = Map::from_iter([("floor".to_owned(), value)]).into();
    }
    let cloud = Cloud::new().tile("a.laz", Style::default(), &points);
    let options = SegmentOptions { ground_attribute: Some("floor".into()), ..SegmentOptions::default() };
    let found = cloud.segment(&houses, &options).unwrap();
    let sources: Vec<_> = found.sites.iter().map(|site| site.ground.source).collect();
    let (stated, seen) = (GroundSource::Attribute, GroundSource::GroundPoints);
    assert_eq!(sources, [stated, stated, seen, seen]);
    assert_eq!([0, 1].map(|i| found.sites[i].ground.height), [1.25, 2.5]);
    // The ground around is still known, so that it can be told how deep the floor lies in it.
    assert!(!found.sites[0].ground_line.is_empty());
    assert!(found.notes[2].iter().any(|note| note.contains("\"floor\" is \"unknown\"")), "{:?}", found.notes);
    assert!(found.notes[3].iter().any(|note| note.contains("is not there")), "{:?}", found.notes);
    assert!(found.warnings.iter().any(|warning| warning.contains("2 of 4 footprints")), "{:?}", found.warnings);
    let options = SegmentOptions { ground_attribute: Some("flor".into()), ..SegmentOptions::default() };
    let error = cloud.segment(&houses, &options).unwrap_err().to_string();
    assert!(error.contains("no attribute \"flor\"") && error.contains("floor"), "{error}");
}

/// Writes a raster of 100 × 100 pixels from its upper left corner, in the system of this EPSG code.
fn terrain(path: &Path, code: u16, corner: [f64; 2], pixel: f64, height: impl Fn(f64, f64) -> f32) {
    let mut encoder = TiffEncoder::new(std::fs::File::create(path).unwrap()).unwrap();
    let mut image = encoder.new_image::<Gray32Float>(100, 100).unwrap();
    let tags = image.encoder();
    let keys: [u16; 16] = [
        1,
        1,
        0,
        3,
        1024,
        0,
        1,
        if code == 4326 { 2 } else { 1 },
        1025,
        0,
        1,
        1,
        if code == 4326 { 2048 } else { 3072 },
        0,
        1,
        code,
    ];
    tags.write_tag(Tag::ModelPixelScaleTag, &[pixel, pixel, 0.0][..]).unwrap();
    tags.write_tag(Tag::ModelTiepointTag, &[0.0, 0.0, 0.0, corner[0], corner[1], 0.0][..]).unwrap();
    tags.write_tag(Tag::GeoKeyDirectoryTag, &keys[..]).unwrap();
    tags.write_tag(Tag::GdalNodata, "-9999").unwrap();
    let place =
        |i: u32| (corner[0] + (f64::from(i % 100) + 0.5) * pixel, corner[1] - (f64::from(i / 100) + 0.5) * pixel);
    let data: Vec<f32> = (0..10_000).map(place).map(|(x, y)| height(x, y)).collect();
    image.write_data(&data).unwrap();
}

#[test]
fn a_terrain_model_goes_before_the_points_in_whatever_system_it_comes() {
    let (mut points, mut houses) = street(false, &[0, 1, 2, 3]);
    // In Delft, where the Dutch system is at home.
    let (east, north) = (84_000.0, 442_000.0);
    for (p, _) in &mut points {
        *p = [p[0] + east, p[1] + north, p[2]];
    }
    for house in &mut houses {
        house.polygon = geo::MapCoords::map_coords(&house.polygon, |c| coord! { x: c.x + east, y: c.y + north });
    }
    let cloud = Cloud::new().tile("a.laz", Style { offset: [85_000.0, 447_000.0, 0.0], ..Style::default() }, &points);
    let tiles = [Tile::open(&cloud.tiles[0]).unwrap()];
    let crs = Crs::parse("EPSG:7415").unwrap();
    let path = cloud.folder.path().join("dtm.tif");
    let run = |options: &SegmentOptions| segment(&tiles, houses.clone(), &crs, options, &|_| {}, None);
    let options = SegmentOptions { dtm: Some(path.clone()), ..SegmentOptions::default() };
    // 10 % downwards to the north, and nothing under the last house.
    let (x, y) = (east + 1000.0, north + 5000.0);
    terrain(&path, 28992, [x - 20.0, y + 150.0], 2.0, |east, north| {
        if east > x + 115.0 { -9999.0 } else { (5.0 - 0.1 * (north - y)) as f32 }
    });
    let found = run(&options).unwrap();
    for site in &found.sites[..3] {
        assert_eq!(site.ground.source, GroundSource::TerrainModel);
        assert!((site.ground.height - 4.0).abs() < 0.01, "{:?}", site.ground);
        assert_eq!(site.ground_line.len(), 80);
    }
    assert_eq!(found.sites[3].ground.source, GroundSource::GroundPoints);
    assert!(
        found.warnings.iter().any(|warning| warning.contains("no height at 1 of 4 footprints")),
        "{:?}",
        found.warnings
    );
    let plane = run(&SegmentOptions { ground: GroundLevel::Plane, ..options.clone() }).unwrap();
    assert!((plane.sites[0].ground.height - 4.5).abs() < 0.01, "{:?}", plane.sites[0].ground);
    // In degrees: the place is 4.37° E, 52.0° N.
    terrain(&path, 4326, [4.3, 52.05], 0.001, |_, _| 7.0);
    let found = run(&options).unwrap();
    assert!(found.sites.iter().all(|site| (site.ground.height - 7.0).abs() < 1e-6), "{:?}", found.sites[0].ground);
    // Sheets in a folder, one of them finer: it counts where it lies, and the other elsewhere.
    let folder = cloud.folder.path().join("sheets");
    std::fs::create_dir(&folder).unwrap();
    terrain(&folder.join("wide.tif"), 28992, [x - 20.0, y + 150.0], 2.0, |_, _| 3.0);
    terrain(&folder.join("fine.TIFF"), 28992, [x - 20.0, y + 40.0], 0.5, |_, _| 4.0);
    let found = run(&SegmentOptions { dtm: Some(folder), ..SegmentOptions::default() }).unwrap();
    let floors: Vec<f64> = found.sites.iter().map(|site| site.ground.height).collect();
    assert_eq!((floors[0], floors[3]), (4.0, 3.0), "{floors:?}");
    terrain(&path, 28992, [0.0, 0.0], 1.0, |_, _| 7.0);
    let error = run(&options).unwrap_err().to_string();
    assert!(error.contains("dtm.tif") && error.contains("no height at any of 4 footprints"), "{error}");
}
