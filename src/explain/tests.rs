//! The pages of buildings of the quick start, read back.

use std::io::Read;
use std::path::{Path, PathBuf};

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flate2::read::DeflateDecoder;
use serde_json::Value;

use super::*;
use crate::network::Field;
use crate::reconstruct::reconstruct;
use crate::run::{FootprintSource, Silent, chosen};
use crate::source::footprints::FootprintOptions;

fn data(name: &str) -> String {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/data")).join(name).display().to_string()
}

/// The quick start, with the vote: it needs no network.
fn job() -> Job {
    Job {
        tiles: vec![data("delft_ahn3.laz")],
        footprints: Some(FootprintSource {
            path: PathBuf::from(data("footprints.geojson")),
            options: FootprintOptions::default(),
        }),
        field: FieldOptions { field: Field::HeightField, ..FieldOptions::default() },
        ..Job::default()
    }
}

/// The head of a page, and the numbers of its columns.
fn unpacked(html: &[u8]) -> (Value, impl Fn(&str) -> Vec<u64>) {
    let html = std::str::from_utf8(html).unwrap();
    let (_, rest) = html.split_once("type=\"application/octet-stream\">").unwrap();
    let deflated = STANDARD.decode(rest.split_once("</script>").unwrap().0).unwrap();
    let mut bytes = Vec::new();
    DeflateDecoder::new(&deflated[..]).read_to_end(&mut bytes).unwrap();
    let length = u32::from_le_bytes(bytes[..4].try_into().unwrap()) as usize;
    let head: Value = serde_json::from_slice(&bytes[4..4 + length]).unwrap();
    let columns = head["columns"].clone();
    let of = move |name: &str| {
        let mut at = 4 + length;
        for column in columns.as_array().unwrap() {
            let size = column[1].as_u64().unwrap() as usize;
            if column[0] == name {
                let mut numbers = vec![0];
                let mut shift = 0;
                for byte in &bytes[at..at + size] {
                    *numbers.last_mut().unwrap() |= u64::from(byte & 0x7f) << shift;
                    shift += 7;
                    if byte & 0x80 == 0 {
                        numbers.push(0);
                        shift = 0;
                    }
                }
                numbers.pop();
                return numbers;
            }
            at += size;
        }
        panic!("no column {name}");
    };
    (head, of)
}

fn figure(head: &Value, step: &str, name: &str) -> Value {
    let steps = head["steps"].as_array().unwrap();
    let figures = &steps.iter().find(|own| own["key"] == step).unwrap()["figures"];
    let found = figures.as_array().unwrap().iter().find(|own| own["name"] == name);
    found.unwrap_or_else(|| panic!("{step}: {name} in {figures}"))["value"].clone()
}

#[test]
fn the_steps_of_a_building_are_those_of_its_run() {
    let job = job();
    let id = "NL.IMBAG.Pand.0503100000017310";
    let chosen = chosen(&job, id, &Silent).unwrap();
    let (building, page) = explain(&job, &chosen).unwrap();
    let alone = reconstruct(&chosen.site, &job.parameters, &*job.field.load().unwrap());
    assert_eq!(format!("{:?}", building.model), format!("{:?}", alone.model), "it is the building of a run");
    assert_eq!(building.measures, alone.measures);

    let (head, column) = unpacked(&page.html);
    assert_eq!((&head["id"], &head["lod"], &head["failure"]), (&id.into(), &"2.2".into(), &Value::Null));
    assert!(head["steps"].as_array().unwrap().iter().all(|step| step["is_reached"] == true));
    let points = building.measures.points;
    assert_eq!(figure(&head, "points", "points of the building"), points);
    assert_eq!((column("found").len(), column("refined").len(), column("distances").len()), (points, points, points));
    assert_eq!(column("classes").len(), page.contents.points[1]);
    // Refinement merges: there are no more planes after it, and their points are labelled with them.
    let [found, refined, all] = page.contents.planes;
    assert_eq!(figure(&head, "found", "planes"), found);
    assert!(building.measures.primitives <= found && all > refined, "{found} {refined} {all}");
    assert_eq!(column("refined").iter().max(), Some(&(refined as u64)));
    assert_eq!(column("plane_kinds").len(), all);
    // The cells are those that were counted; the surface bounds those that are inside.
    let [cells, inside] = page.contents.cells;
    assert_eq!(building.measures.cells, cells);
    for name in ["fixed", "volumes", "occupancy", "cut", "cleaned"] {
        assert_eq!(column(name).len(), cells, "{name}");
    }
    assert_eq!(column("cut").iter().sum::<u64>(), inside as u64);
    assert!(column("cut").iter().zip(column("fixed")).all(|(cut, fixed)| cut + fixed < 2), "nothing beyond is inside");
    let litres: u64 = column("cleaned").iter().zip(column("volumes")).map(|(is_in, volume)| is_in * volume).sum();
    let volume = building.measures.volume_lod22.unwrap();
    assert!((litres as f64 / 1000.0 - volume).abs() < 0.01 * volume, "{litres} litres, {volume} m³");
    let faces: usize = building.model.lod22().map(|solid| solid.faces.len()).sum();
    assert_eq!((page.contents.faces, column("face_kinds").len()), (faces, faces));
    // The root mean square of the distances is what the run tells of all points that count.
    let squares = column("distances").iter().map(|mm| (*mm as f64 / 1000.0).powi(2)).sum::<f64>();
    let rmse = (squares / points as f64).sqrt();
    assert!((rmse - building.measures.rmse_lod22.unwrap()).abs() < 0.02, "{rmse} {:?}", building.measures.rmse_lod22);
    // The energy is that of λ and its two terms.
    let [lambda, d, v, e] = ["λ", "D, distance from the probabilities", "V, unexplained surface", "E = D + λ V"]
        .map(|name| figure(&head, "cut", name).as_f64().unwrap());
    assert!(lambda >= job.parameters.labelling.lambda && (d + lambda * v - e).abs() < 2e-4, "{lambda} {d} {v} {e}");
    assert!((0.0..0.5).contains(&d) && (0.0..1.0).contains(&v), "{d} {v}");
}

#[test]
fn every_building_of_the_quick_start_can_be_told_in_steps() {
    let job = job();
    let field = job.field.load().unwrap();
    let sites = crate::run::sites(&job, &Silent).unwrap();
    for site in &sites {
        let (building, steps) = reconstruct_in_steps(site, &job.parameters, &*field);
        let alone = reconstruct(site, &job.parameters, &*field);
        assert_eq!(format!("{:?}", building.model), format!("{:?}", alone.model), "{}", site.id);
        let surface = steps.surface.expect("all of them have a model");
        assert_eq!(surface.solids.len(), building.model.lod22().count(), "{}", site.id);
    }
}

#[test]
fn a_building_without_points_says_so_and_shows_what_is_around() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("nobody.geojson");
    // In the yard of the quick start.
    let square = [[84_958.0, 447_523.0], [84_961.0, 447_523.0], [84_961.0, 447_526.0], [84_958.0, 447_526.0]];
    let ring: Vec<[f64; 2]> = square.into_iter().chain([square[0]]).collect();
    let feature = serde_json::json!({"type": "Feature", "properties": {"id": "nobody"},
        "geometry": {"type": "Polygon", "coordinates": [ring]}});
    let layer = serde_json::json!({"type": "FeatureCollection", "features": [feature],
        "crs": {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::28992"}}});
    std::fs::write(&path, layer.to_string()).unwrap();
    let source = FootprintSource { path, options: FootprintOptions::default() };
    let job = Job { footprints: Some(source), ..job() };
    let chosen = chosen(&job, "nobody", &Silent).unwrap();
    let (building, page) = explain(&job, &chosen).unwrap();
    assert!(building.model.lod22().next().is_none());
    let failure = page.contents.failure.expect("it says why");
    assert!(failure.contains("no building point lies in the footprint"), "{failure}");
    let (head, column) = unpacked(&page.html);
    let reached: Vec<&str> = head["steps"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|step| step["is_reached"] == true)
        .map(|step| step["key"].as_str().unwrap())
        .collect();
    assert_eq!(reached, ["points", "result"]);
    assert!(column("classes").len() > 10, "what is around is shown");
}

#[test]
fn an_id_that_is_not_there_is_told_with_those_most_like_it() {
    let id = "NL.IMBAG.Pand.05031000000173";
    let message = chosen(&job(), id, &Silent).expect_err("there is no such building").to_string();
    for part in ["footprints", &format!("no building with the id {id:?}"), "71 buildings", "0173", "--id-attribute"] {
        assert!(message.contains(part), "{part} in {message}");
    }
}

#[test]
fn the_page_is_made_from_its_sources() {
    let named = page::tests::named("src/explain/page", &["src/view/page"]);
    assert!(TEMPLATE.contains(&named), "src/explain/page/dist/page.html is stale: run `make page` ({named})");
}
