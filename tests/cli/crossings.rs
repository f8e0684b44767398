//! Neighbours are modelled one by one: their models overlap in the plan only where their footprints do.

use std::collections::BTreeMap;
use std::path::Path;

use geo::orient::{Direction, Orient};
use geo::{Area, BooleanOps, BoundingRect, Coord, Euclidean, Intersects, Length, LineString, MultiPolygon, Polygon};
use serde_json::{Value, json};
use tempfile::tempdir;

use crate::bench::*;

/// How far rounding to the grid of the file may move a wall, in steps of 0.1 mm.
const ROUNDING: f64 = 1.0;

/// What each building of a CityJSON file covers in the plan at a level of detail, in grid steps.
fn plans(model: &Value, lod: &str) -> BTreeMap<String, MultiPolygon<f64>> {
    let vertex = |index: &Value| {
        let vertex = &model["vertices"][usize::try_from(index.as_u64().unwrap()).unwrap()];
        Coord { x: vertex[0].as_f64().unwrap(), y: vertex[1].as_f64().unwrap() }
    };
    let polygon = |face: &Value| {
        let mut rings: Vec<LineString<f64>> = (face.as_array().unwrap().iter())
            .map(|ring| LineString(ring.as_array().unwrap().iter().map(vertex).collect()))
            .collect();
        let exterior = rings.remove(0);
        Polygon::new(exterior, rings).orient(Direction::Default)
    };
    let mut faces: BTreeMap<String, Vec<Polygon<f64>>> = BTreeMap::new();
    for (id, object) in model["CityObjects"].as_object().unwrap() {
        let building = object["parents"][0].as_str().unwrap_or(id);
        let geometries = object["geometry"].as_array().into_iter().flatten();
        for geometry in geometries.filter(|geometry| geometry["lod"] == lod) {
            let (faces_of, kinds) = match geometry["type"].as_str() {
                Some("Solid") => (&geometry["boundaries"][0], &geometry["semantics"]["values"][0]),
                _ => (&geometry["boundaries"], &geometry["semantics"]["values"]),
            };
            for (face, kind) in faces_of.as_array().unwrap().iter().zip(kinds.as_array().unwrap()) {
                let kind = &geometry["semantics"]["surfaces"][usize::try_from(kind.as_u64().unwrap()).unwrap()];
                if kind["type"] != "WallSurface" {
                    faces.entry(building.to_owned()).or_default().push(polygon(face));
                }
            }
        }
    }
    faces.into_iter().map(|(id, faces)| (id, geo::unary_union(&faces))).collect()
}

/// The thickest piece of an area, in grid steps: that of the rectangle of the same area and length of outline.
fn thickness(area: &MultiPolygon<f64>) -> f64 {
    let thickness = |polygon: &Polygon<f64>| {
        let rings = std::iter::once(polygon.exterior()).chain(polygon.interiors());
        let around: f64 = rings.map(|ring| Euclidean.length(ring)).sum();
        let half = around / 4.0;
        half - (half * half - polygon.unsigned_area()).max(0.0).sqrt()
    };
    area.iter().map(thickness).fold(0.0, f64::max)
}

/// Asserts that no model at this level of detail leaves its footprint, and that no two overlap where their footprints do
/// not. Returns how many pairs of footprints touch or overlap.
fn assert_no_crossing(model: &Path, lod: &str) -> usize {
    let model = json_of(model);
    let (footprints, models) = (plans(&model, "0"), plans(&model, lod));
    assert!(!models.is_empty());
    for (id, plan) in &models {
        // Of a building that the tiles cover in part only that part is modelled.
        let coverage = model["CityObjects"][id]["attributes"]["gable_coverage"].as_f64().unwrap();
        assert!(plan.unsigned_area() > 0.5 * coverage * footprints[id].unsigned_area(), "{id} has no plan");
        let outside = thickness(&plan.difference(&footprints[id]));
        assert!(outside <= ROUNDING, "{id} leaves its footprint by {} m at LoD {lod}", outside * 1e-4);
    }
    let near = |a: &MultiPolygon<f64>, b: &MultiPolygon<f64>| {
        a.bounding_rect().zip(b.bounding_rect()).is_some_and(|(a, b)| a.intersects(&b))
    };
    let mut touching = 0;
    for (i, (one, a)) in models.iter().enumerate() {
        for (other, b) in models.iter().skip(i + 1) {
            let (f, g) = (&footprints[one], &footprints[other]);
            if !near(f, g) && !near(a, b) {
                continue;
            }
            touching += usize::from(f.intersects(g));
            let crossing = a.intersection(b).difference(&f.intersection(g));
            let depth = thickness(&crossing);
            assert!(depth <= 2.0 * ROUNDING, "{one} and {other} cross by {} m at LoD {lod}", depth * 1e-4);
        }
    }
    touching
}

#[test]
fn neighbours_of_the_quick_start_do_not_cross() {
    let folder = tempdir().unwrap();
    let out = folder.path().join("quick.city.json");
    assert_eq!(delft(&out, "").code, 0);
    assert!(assert_no_crossing(&out, "2.2") >= 10);
    assert_no_crossing(&out, "1.2");
}

#[test]
fn neighbours_of_real_cities_do_not_cross() {
    let Some(data) = shared("") else { return };
    let cities = [
        ("delft", ["ahn3_cropped_1.laz", "ahn3_cropped_2.laz", "bgt_pand.sqlite"]),
        ("amsterdam-dense", ["ahn_2386_9702.laz", "ahn_2397_9705.laz", "footprints.geojson"]),
    ];
    for (city, names) in cities {
        let [one, two, footprints] = names.map(|name| data.join(city).join(name));
        let folder = tempdir().unwrap();
        let out = folder.path().join("city.city.json");
        let run = reconstruct(&[&one, &two], &footprints, &out, "--crs EPSG:7415");
        assert!(matches!(run.code, 0 | 2), "{}{}", run.out, run.err);
        let touching = assert_no_crossing(&out, "2.2");
        assert!(touching >= 10, "{city}: only {touching} pairs touch");
        assert_no_crossing(&out, "1.2");
    }
}

/// A row of three houses under saddle roofs of different heights. The walls between them were digitised with an error
/// of up to 9 cm, each house with vertices of its own along them, so that neighbours overlap a little here and there.
#[test]
fn neighbours_with_a_badly_digitised_wall_do_not_cross() {
    let folder = tempdir().unwrap();
    let mut points = Vec::new();
    for (i, j) in (-20..140).flat_map(|i| (-20..60).map(move |j| (i, j))) {
        let (x, y) = (f64::from(i) * 0.25 + 0.125, f64::from(j) * 0.25 + 0.125);
        let house = (x / 10.0).floor();
        let roof = (0.0..30.0).contains(&x) && (0.0..10.0).contains(&y);
        let (z, class) = if roof { (8.0 + house - (y - 5.0).abs() * 0.8, 6) } else { (0.0, 2) };
        points.push((CORNER[0] + x, CORNER[1] + y, z, class));
    }
    write_tile(&folder.path().join("row.laz"), None, &points);
    let mut state = 1_u64;
    let mut jitter = |most: f64| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((state >> 33) as f64 / f64::from(1_u32 << 31) * 2.0 - 1.0) * most
    };
    let mut wall = |x: f64, count: u32| -> Vec<[f64; 2]> {
        let along = |i: u32| f64::from(i) * 10.0 / f64::from(count);
        (1..count).map(|i| [x + jitter(0.09), along(i)]).collect()
    };
    let mut footprint = |west: f64, east: f64| {
        let mut ring = vec![[west, 0.0], [east, 0.0]];
        ring.extend(wall(east, 9));
        ring.extend([[east, 10.0], [west, 10.0]]);
        ring.extend(wall(west, 7).into_iter().rev());
        ring.push([west, 0.0]);
        let ring: Vec<[f64; 2]> = ring.iter().map(|p| [p[0] + CORNER[0], p[1] + CORNER[1]]).collect();
        json!({"type": "Polygon", "coordinates": [ring]})
    };
    let row = [("a", footprint(0.0, 10.0)), ("b", footprint(10.0, 20.0)), ("c", footprint(20.0, 30.0))];
    write_footprints(&folder.path().join("row.geojson"), &row);
    let run = run_in(folder.path(), "row.laz", "row.geojson", "");
    assert_eq!(run.code, 0, "{}{}", run.out, run.err);
    let out = folder.path().join("out.city.json");
    assert_eq!(assert_no_crossing(&out, "2.2"), 2);
    assert_no_crossing(&out, "1.2");
    for building in report_of(&out)["buildings"].as_array().unwrap() {
        assert_eq!(building["outcome"], "lod22", "{building:#}");
    }
}
