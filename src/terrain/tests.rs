//! Terrain on made-up ground, around made-up buildings.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::ControlFlow;
use std::sync::Arc;

use super::outlines::{Inside, Outlines, Vertex};
use super::tile::Made;
use super::*;
use crate::geometry::Random;
use crate::sink::Feature;
use crate::solid::{Face, Solid};
use crate::validate::{Claim, Place, Tolerances, visit};

/// Where the tests take place, in steps: coordinates as they are in real systems.
const ORIGIN: [i64; 2] = [850_000_000, 4_470_000_000];

fn options(error: f64, tile: f64) -> TerrainOptions {
    TerrainOptions { terrain_error: error, terrain_tile: tile, ..TerrainOptions::default() }
}

/// A building of these vertices, in metres from the origin.
fn building(ring: &[[f64; 3]]) -> (Inside, Vec<Vertex>) {
    (Inside::Hole, ring.iter().map(|v| v.map(|c| (c * 1e4).round() as i64)).collect())
}

fn house(x: f64, y: f64, [w, h]: [f64; 2], z: f64) -> (Inside, Vec<Vertex>) {
    building(&[[x, y, z], [x + w, y, z], [x + w, y + h, z], [x, y + h, z]])
}

/// Terrain around buildings on ground that is `height` where that is some, each 30 cm in a square of `side` metres.
fn terrain(
    options: &TerrainOptions,
    side: f64,
    buildings: &[(Inside, Vec<Vertex>)],
    height: impl Fn(f64, f64) -> Option<f64>,
) -> Terrain {
    terrain_in([1.0; 3], options, side, buildings, height)
}

/// The same in units of so many metres.
fn terrain_in(
    metres_per_unit: [f64; 3],
    options: &TerrainOptions,
    side: f64,
    buildings: &[(Inside, Vec<Vertex>)],
    height: impl Fn(f64, f64) -> Option<f64>,
) -> Terrain {
    let folder = tempfile::tempdir().unwrap();
    let grid = Grid::new(options, metres_per_unit);
    let store = GroundStore::create(folder.path(), grid).unwrap();
    let mut collector = store.collector();
    let corner = ORIGIN.map(|c| c as f64 / 1e4);
    let count = (side / 0.3) as i32;
    for i in 0..count {
        for j in 0..count {
            let (x, y) = (f64::from(i) * 0.3 + 0.13, f64::from(j) * 0.3 + 0.17);
            if let Some(z) = height(x, y) {
                collector.add([corner[0] + x, corner[1] + y, z], true);
            }
        }
    }
    collector.finish().unwrap();
    let mut outlines = Outlines::default();
    for (inside, ring) in buildings {
        outlines.polygon(*inside, [ORIGIN[0], ORIGIN[1], 0], std::slice::from_ref(ring));
    }
    let area = Extent { min: [corner[0], corner[1], 0.0], max: [corner[0] + side, corner[1] + side, 0.0] };
    Terrain::new(options.clone(), Arc::new(store), outlines, vec![area])
}

/// All tiles of a terrain, each valid in all of its pieces.
fn made(terrain: &Terrain) -> Vec<Made> {
    let tiles: Vec<Made> = terrain.tiles().into_iter().map(|key| terrain.tile(key).unwrap()).collect();
    tiles.iter().flat_map(|tile| &tile.features).for_each(assert_valid);
    tiles
}

/// The triangles of a feature in steps from the origin of the test.
fn triangles(feature: &Feature) -> Vec<[Vertex; 3]> {
    let vertex = |v: u32| {
        let [x, y, z] = feature.vertex(v).map(|c| (c * 1e4).round() as i64);
        [x - ORIGIN[0], y - ORIGIN[1], z]
    };
    let faces = feature.objects[0].geometries[0].shells[0].faces.iter();
    faces.map(|face| [face.rings[0][0], face.rings[0][1], face.rings[0][2]].map(vertex)).collect()
}

fn all_triangles(tiles: &[Made]) -> Vec<[Vertex; 3]> {
    tiles.iter().flat_map(|tile| &tile.features).flat_map(triangles).collect()
}

/// Twice the area of a triangle from above.
fn area(t: &[Vertex; 3]) -> i64 {
    let [a, b, c] = t;
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn assert_valid(feature: &Feature) {
    let vertices: Vec<Vertex> = feature.vertices.iter().map(|v| v.map(|c| (c * 1e4).round() as i64)).collect();
    let low = vertices[0];
    let local = vertices.iter().map(|v| std::array::from_fn(|i| v[i] - low[i])).collect();
    let faces = &feature.objects[0].geometries[0].shells[0].faces;
    let faces = faces.iter().map(|face| Face { rings: face.rings.clone(), surface: 0 }).collect();
    let solid = Solid { step: [1e-4; 3], vertices: local, faces, surfaces: Vec::new() };
    let mut faults = Vec::new();
    let _ = visit(&solid, Claim::Surface, &Tolerances::written(), &mut |fault| {
        let corners = match fault.place {
            Place::Face(f) | Place::Ring(f, _) => {
                solid.faces[f as usize].rings[0].iter().map(|v| vertices[*v as usize]).collect()
            }
            _ => Vec::new(),
        };
        faults.push(format!("{fault} {corners:?}"));
        ControlFlow::Continue(())
    });
    faults.extend(crate::validate::relief::check(&solid).iter().map(ToString::to_string));
    assert!(faults.is_empty(), "{}: {faults:?}", feature.id);
}

/// How far a place is from the nearest vertex of the terrain in plan and height, and from its triangles, steps.
fn off_vertices(place: Vertex, tiles: &[Made]) -> f64 {
    let vertices = all_triangles(tiles).into_iter().flatten();
    let squared = vertices.map(|v| (0..3).map(|i| (v[i] - place[i]).pow(2)).sum::<i64>()).min().unwrap();
    (squared as f64).sqrt()
}

#[test]
fn a_plane_needs_no_vertex_between_the_corners_of_its_tiles() {
    for slope in [0.0, 0.3] {
        let terrain = terrain(&options(0.05, 40.0), 120.0, &[], |x, y| Some(2.0 + slope * x - 0.1 * y));
        let tiles = made(&terrain);
        let whole: Vec<&Made> = tiles.iter().filter(|tile| tile.tally.triangles == 2).collect();
        assert!(!whole.is_empty(), "{slope}: {:?}", tiles.iter().map(|tile| tile.tally).collect::<Vec<_>>());
        for tile in &tiles {
            assert!(tile.tally.largest <= 0.05, "{slope}: {:?}", tile.tally);
        }
    }
}

#[test]
fn ground_is_met_to_the_tolerance_with_more_vertices_the_smaller_it_is() {
    let hills = |x: f64, y: f64| Some(3.0 * (x / 9.0).sin() * (y / 7.0).cos() + if x > 55.3 { 1.4 } else { 0.0 });
    let counts: Vec<usize> = [0.5, 0.1, 0.02]
        .into_iter()
        .map(|error| {
            let tiles = made(&terrain(&options(error, 50.0), 100.0, &[], hills));
            let tally = tiles.iter().fold(Tally::default(), |mut all, tile| {
                all.add(&tile.tally);
                all
            });
            // Beside the border, where there is no room, a point may be off by more; there is none here.
            assert!(tally.largest <= error * 1.001, "{error}: {tally:?}");
            assert!(tally.rmse().unwrap() <= error && tally.points > 30_000, "{tally:?}");
            tally.triangles
        })
        .collect();
    assert!(counts[0] * 3 < counts[1] && counts[1] * 3 < counts[2], "{counts:?}");
}

#[test]
fn a_house_in_a_slope_is_met_at_its_floor_and_the_ground_is_reached_within_the_collar() {
    let slope = |x: f64, _: f64| Some(10.0 + 0.25 * x);
    let floor = 10.0 + 0.25 * 45.0;
    let ring = house(45.0, 45.0, [12.0, 9.0], floor);
    let terrain = terrain(&options(0.1, 50.0), 100.0, std::slice::from_ref(&ring), slope);
    let tiles = made(&terrain);
    for vertex in &ring.1 {
        assert_eq!(off_vertices(*vertex, &tiles), 0.0);
    }
    // The floor is 3 m below the ground at the upper wall: two metres from it the terrain is the ground again.
    for t in all_triangles(&tiles) {
        for v in t {
            let [x, y] = [0, 1].map(|i| v[i] as f64 / 1e4);
            let away = (45.0 - x).max(x - 57.0).max(45.0 - y).max(y - 54.0);
            if away > 2.0 {
                assert!((v[2] as f64 / 1e4 - (10.0 + 0.25 * x)).abs() < 0.15, "{v:?}");
            }
        }
    }
    let covered: i64 = all_triangles(&tiles).iter().map(area).sum();
    let expected = 100.0 * 100.0 - 12.0 * 9.0;
    assert!((covered as f64 / 2e8 - expected).abs() < 450.0, "{} m²", covered as f64 / 2e8);
}

/// The edges of triangles along outlines and around courtyards: every one that has but one triangle.
fn border(triangles: &[[Vertex; 3]]) -> BTreeSet<[Vertex; 2]> {
    let mut count: BTreeMap<[Vertex; 2], i32> = BTreeMap::new();
    for t in triangles {
        for i in 0..3 {
            let (a, b) = (t[i], t[(i + 1) % 3]);
            *count.entry(if a < b { [a, b] } else { [b, a] }).or_default() += if a < b { 1 } else { -1 };
        }
    }
    count.into_iter().filter(|(_, n)| *n != 0).map(|(edge, _)| edge).collect()
}

#[test]
fn a_row_of_houses_with_different_floors_is_closed_by_upright_triangles() {
    let floors = [1.0, 1.4, 1.2, 1.2, 0.7];
    let row: Vec<_> = (0..5).map(|i| house(20.0 + 6.0 * f64::from(i), 20.0, [6.0, 10.0], floors[i as usize])).collect();
    let terrain = terrain(&options(0.1, 100.0), 100.0, &row, |_, _| Some(1.1));
    let tiles = made(&terrain);
    let found = all_triangles(&tiles);
    let tally = tiles.iter().map(|tile| tile.tally.upright).sum::<usize>();
    // Front and back: at each of the four walls between two floors the higher one stands on a triangle, but for one wall between
    // equal floors; the last wall's two belong to one house that has another at its other end.
    assert_eq!(tally, 2 * 3);
    assert_eq!(found.iter().filter(|t| area(t) == 0).count(), tally);
    let open = border(&found);
    for (_, ring) in &row {
        for i in [0, 2] {
            let (a, b) = (ring[i], ring[i + 1]);
            assert!(
                open.contains(&if a < b { [a, b] } else { [b, a] }),
                "the wall foot {a:?} {b:?} is an edge of the terrain"
            );
        }
        for vertex in ring {
            assert_eq!(off_vertices(*vertex, &tiles), 0.0);
        }
    }
}

#[test]
fn a_courtyard_is_a_piece_of_its_own() {
    let ring = [
        house(30.0, 30.0, [20.0, 5.0], 0.5),
        house(30.0, 45.0, [20.0, 5.0], 0.5),
        house(30.0, 35.0, [5.0, 10.0], 0.5),
        house(45.0, 35.0, [5.0, 10.0], 0.5),
    ];
    let tiles = made(&terrain(&options(0.1, 100.0), 100.0, &ring, |_, _| Some(0.5)));
    let ids: Vec<&str> = tiles.iter().flat_map(|tile| &tile.features).map(|feature| feature.id.as_str()).collect();
    assert!(ids.contains(&"terrain-85000-447000-1"), "{ids:?}");
    let yard = tiles.iter().flat_map(|tile| &tile.features).find(|feature| feature.id.ends_with("447000-1")).unwrap();
    assert_eq!(triangles(yard).iter().map(area).sum::<i64>(), 2 * 100_000 * 100_000);
}

#[test]
fn houses_that_touch_in_a_corner_leave_valid_pieces() {
    let corners = [
        house(20.0, 20.0, [10.0, 10.0], 1.0),
        house(30.0, 30.0, [10.0, 10.0], 1.3),
        house(30.0, 10.0, [9.0, 10.0], 0.8),
    ];
    let tiles = made(&terrain(&options(0.1, 100.0), 60.0, &corners, |_, _| Some(1.0)));
    for (_, ring) in &corners {
        for vertex in ring {
            assert!(off_vertices(*vertex, &tiles) <= 10.0);
        }
    }
}

#[test]
fn tiles_share_every_vertex_of_their_borders_also_through_buildings_and_gaps() {
    let hills = |x: f64, y: f64| {
        let is_pond = (x - 61.0).hypot(y - 33.0) < 14.0;
        (!is_pond).then(|| (x / 6.0).sin() + 0.4 * (y / 5.0).cos())
    };
    let buildings = [
        building(&[[33.1, 34.7, 0.2], [47.3, 38.2, 0.2], [44.0, 51.3, 0.2], [29.9, 47.1, 0.2]]),
        building(&[[47.3, 38.2, 0.9], [55.0, 40.1, 0.9], [52.0, 53.2, 0.9], [44.0, 51.3, 0.9]]),
        house(79.0, 60.0, [2.0, 30.0], 0.0),
        house(80.0, 90.0, [7.0, 7.0], 0.4),
    ];
    let terrain = terrain(&options(0.05, 40.0), 120.0, &buildings, hills);
    let tiles = made(&terrain);
    assert_eq!(tiles.iter().filter(|tile| tile.tally.tiles > 0).count(), 9);
    for line in [1, 2].map(|n: i64| n * 400_000) {
        for axis in 0..2 {
            // The edges on the line, of the triangles on either side.
            let mut sides = [BTreeSet::new(), BTreeSet::new()];
            for t in all_triangles(&tiles).iter().filter(|t| area(t) != 0) {
                for i in 0..3 {
                    let (a, b, c) = (t[i], t[(i + 1) % 3], t[(i + 2) % 3]);
                    if a[axis] == line && b[axis] == line {
                        sides[usize::from(c[axis] > line)].insert(if a < b { [a, b] } else { [b, a] });
                    }
                }
            }
            let [one, other] = &sides;
            let both = one.intersection(other).count();
            // Where only one side is terrain, on a wall or at the pond, the other has no edge.
            assert!(both > 15, "{line} {axis}: {both}");
            for lone in one.symmetric_difference(other) {
                let inner = |v: &Vertex| one.iter().chain(other).filter(|edge| edge.contains(v)).count();
                assert!(lone.iter().all(|v| inner(v) >= 1));
                let (low, high) = (lone[0][1 - axis], lone[1][1 - axis]);
                let crossed = one
                    .iter()
                    .chain(other)
                    .any(|edge| edge != lone && edge[0][1 - axis] < high && low < edge[1][1 - axis]);
                assert!(!crossed, "{line} {axis}: {lone:?} has other vertices on the other side");
            }
        }
    }
}

#[test]
fn wide_gaps_are_left_out_and_told() {
    let pond = |x: f64, y: f64| (!((30.0..70.0).contains(&x) && (30.0..70.0).contains(&y))).then_some(0.0);
    let tiles = made(&terrain(&options(0.1, 100.0), 100.0, &[], pond));
    let tally = tiles.iter().fold(Tally::default(), |mut all, tile| {
        all.add(&tile.tally);
        all
    });
    // The pond without what lies within a part of its shore, and without its corners.
    assert!((1000.0..=1300.0).contains(&tally.left_out), "{tally:?}");
    let found = all_triangles(&tiles);
    let centre = |t: &[Vertex; 3], axis: usize| t.iter().map(|v| v[axis]).sum::<i64>() as f64 / 3e4;
    assert!(!found.iter().any(|t| (0..2).all(|axis| (38.0..62.0).contains(&centre(t, axis)))));
}

#[test]
fn lengths_are_metres_whatever_the_unit() {
    // 300 by 300 US survey feet, a house in them, and ground that rises by a foot in ten: a tile of 30 m is one of 98 ft.
    let foot = 1200.0 / 3937.0;
    let ring = house(120.0, 120.0, [40.0, 30.0], 10.0);
    let slope = |x: f64, _: f64| Some(0.1 * x + 0.3 * (x / 9.0).sin());
    let terrain = terrain_in([foot; 3], &options(0.03, 30.0), 300.0, std::slice::from_ref(&ring), slope);
    let tiles = made(&terrain);
    let ids: BTreeSet<&str> = tiles.iter().flat_map(|tile| &tile.features).map(|feature| feature.id.as_str()).collect();
    assert!(ids.contains("terrain-85064-447076"), "{ids:?}");
    assert!(
        tiles.iter().all(|tile| tile.tally.largest <= 0.03001),
        "{:?}",
        tiles.iter().map(|tile| tile.tally.largest).collect::<Vec<_>>()
    );
    ring.1.iter().for_each(|vertex| assert_eq!(off_vertices(*vertex, &tiles), 0.0));
}

#[test]
fn a_pad_is_level_and_no_hole() {
    let mut pad = house(40.0, 40.0, [10.0, 10.0], 1.5);
    pad.0 = Inside::Pad;
    let tiles = made(&terrain(&options(0.1, 100.0), 100.0, std::slice::from_ref(&pad), |_, _| Some(1.0)));
    pad.1.iter().for_each(|vertex| assert_eq!(off_vertices(*vertex, &tiles), 0.0));
    let inside = all_triangles(&tiles)
        .into_iter()
        .filter(|t| t.iter().all(|v| (0..2).all(|i| (400_000..=500_000).contains(&v[i]))));
    let inside: Vec<[Vertex; 3]> = inside.collect();
    assert_eq!(inside.iter().map(area).sum::<i64>(), 2 * 100_000 * 100_000);
    assert!(inside.iter().flatten().all(|v| v[2] == 15_000));
}

#[test]
fn whatever_stands_there_the_terrain_is_valid_and_meets_it() {
    for seed in 0..40 {
        let mut random = Random::new(seed);
        let mut buildings = Vec::new();
        for _ in 0..12 {
            let [x, y] = [0; 2].map(|_| 5.0 + random.below(16) as f64 * 4.0 + 0.001 * random.below(3) as f64);
            let [w, h] = [0; 2].map(|_| 4.0 + random.below(3) as f64 * 4.0);
            let z = 0.25 * random.below(5) as f64;
            let turn = if random.chance(0.3) { random.between(-1.0, 1.0) } else { 0.0 };
            buildings.push(building(&[
                [x, y, z],
                [x + w, y + turn, z],
                [x + w - turn, y + h, z],
                [x - turn, y + h - turn, z],
            ]));
        }
        let noise: Vec<f64> = (0..1000).map(|_| 0.1 * random.bell()).collect();
        let ground = |x: f64, y: f64| Some(0.5 + noise[(x * 31.0 + y * 57.0) as usize % 1000]);
        let terrain = terrain(&options(0.15, 40.0), 90.0, &buildings, ground);
        let tiles = made(&terrain);
        assert_eq!(tiles.iter().map(|tile| tile.tally.missed).sum::<usize>(), 0, "seed {seed}");
    }
}
