//! Both detectors on real buildings: how much of the roofs they explain, with how many planes, in what time.

// The loader of the fixture stands outside the test functions, where clippy's exception for tests does not reach.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::path::Path;
use std::time::Instant;

use gable::reconstruct::Parameters;
use gable::reconstruct::primitives::{DetectionParameters, Detector, detect};
use geo::{BoundingRect, Contains, Polygon};
use nalgebra::Point3;

/// The class-6 points in each footprint of the quick start, local to its first corner; `None` without the data.
fn quick_start() -> Option<Vec<Vec<Point3<f64>>>> {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/data/delft-quickstart"));
    if !folder.exists() {
        println!("skipped: shared data not found");
        return None;
    }
    let text = std::fs::read_to_string(folder.join("footprints.geojson")).unwrap();
    let features = geojson::FeatureCollection::try_from(text.parse::<geojson::GeoJson>().unwrap()).unwrap();
    let footprints: Vec<Polygon<f64>> = features
        .features
        .into_iter()
        .map(|feature| match geo::Geometry::try_from(feature.geometry.unwrap()).unwrap() {
            geo::Geometry::Polygon(polygon) => polygon,
            geo::Geometry::MultiPolygon(several) => several.0.into_iter().next().unwrap(),
            other => panic!("{other:?}"),
        })
        .collect();
    let mut clouds = vec![Vec::new(); footprints.len()];
    let mut reader = las::Reader::from_path(folder.join("delft_ahn3.laz")).unwrap();
    for point in reader.read_all().unwrap().points().map(Result::unwrap) {
        if u8::from(point.classification) != 6 {
            continue;
        }
        let place = geo::Coord { x: point.x, y: point.y };
        for (footprint, cloud) in footprints.iter().zip(&mut clouds) {
            let rectangle = footprint.bounding_rect().unwrap();
            if rectangle.contains(&place) && footprint.contains(&place) {
                let origin = rectangle.min();
                cloud.push(Point3::new(point.x - origin.x.floor(), point.y - origin.y.floor(), point.z));
            }
        }
    }
    Some(clouds)
}

#[test]
fn roofs_of_delft_are_explained_by_few_planes() {
    let Some(clouds) = quick_start() else { return };
    for detector in [Detector::RegionGrowing, Detector::Ransac] {
        let parameters = Parameters {
            detection: DetectionParameters { detector, ..DetectionParameters::default() },
            ..Parameters::default()
        };
        let (mut points, mut near, mut primitives, mut noises) = (0, 0, Vec::new(), Vec::new());
        let started = Instant::now();
        for cloud in clouds.iter().filter(|cloud| cloud.len() >= 50) {
            let found = detect(cloud, &parameters, 1);
            points += cloud.len();
            let distance =
                |p: &gable::reconstruct::primitives::Primitive, i: u32| p.plane.distance(&cloud[i as usize]).abs();
            near += found
                .primitives
                .iter()
                .flat_map(|p| p.inliers.iter().map(|&i| distance(p, i)))
                .filter(|d| *d <= 0.1)
                .count();
            primitives.push(found.primitives.len());
            noises.push(found.noise);
        }
        let milliseconds = started.elapsed().as_secs_f64() * 1e3 / primitives.len() as f64;
        primitives.sort_unstable();
        noises.sort_by(f64::total_cmp);
        let share = f64::from(near as u32) / points as f64;
        println!(
            "{detector:?}: {:.1} % of {points} points within 0.1 m of their plane; {} planes in {} buildings, median {}, \
             most {}; median noise {:.3} m; {milliseconds:.2} ms per building",
            100.0 * share,
            primitives.iter().sum::<usize>(),
            primitives.len(),
            primitives[primitives.len() / 2],
            primitives.last().unwrap(),
            noises[noises.len() / 2],
        );
        assert!(share > 0.8, "{share}");
        assert!(primitives[primitives.len() / 2] <= 10);
        assert!(primitives[0] >= 1);
    }
}
