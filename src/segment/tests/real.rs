//! Real tiles, where they lie beside the project.

use super::*;

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
    let found = segment(&[tile], footprints.clone(), &crs(1.0), &SegmentOptions::default(), &|_| {}, None).unwrap();
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
    let found = segment(&tiles, footprints, &crs(1.0), &SegmentOptions::default(), &|_| {}, None).unwrap();
    for site in &found.sites {
        println!("{} {} points, {:?}, {:?}", site.id, site.points.len(), site.ground, site.coverage);
    }
    println!("{:?}", found.counts);
    let complete = found.sites.iter().filter(|site| site.coverage.is_complete()).count();
    assert!(complete > 0 && complete < found.sites.len(), "{complete} of {}", found.sites.len());
}
