use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;

use geo::{Area, MultiPolygon, Polygon, polygon};
use proptest::prelude::*;

use super::ring::doubled_area;
use super::*;
use crate::validate;

const STEP: [f64; 3] = [1e-4; 3];

/// A footprint on the grid, and what was done to it.
fn on_grid(polygons: &MultiPolygon<f64>) -> (Vec<FootprintPolygon>, Vec<String>) {
    let mut notes = Vec::new();
    (footprint(polygons, STEP, &mut notes), notes)
}

/// Every directed edge once, and its reverse once; every vertex used and different; the faces around every vertex one fan.
fn assert_closed_manifold(solid: &Solid) {
    let mut edges: BTreeMap<[u32; 2], usize> = BTreeMap::new();
    let mut next_face: BTreeMap<(u32, usize), BTreeSet<usize>> = BTreeMap::new();
    let mut owner: BTreeMap<[u32; 2], usize> = BTreeMap::new();
    for (index, face) in solid.faces.iter().enumerate() {
        for ring in &face.rings {
            assert!(ring.len() >= 3);
            for (i, &a) in ring.iter().enumerate() {
                let edge = [a, ring[(i + 1) % ring.len()]];
                *edges.entry(edge).or_default() += 1;
                owner.insert(edge, index);
            }
        }
    }
    for (&[a, b], &count) in &edges {
        assert_eq!(count, 1, "edge {a}-{b}");
        assert!(edges.contains_key(&[b, a]), "edge {a}-{b} has no reverse");
        let (here, there) = (owner[&[a, b]], owner[&[b, a]]);
        next_face.entry((a, here)).or_default().insert(there);
        next_face.entry((a, there)).or_default().insert(here);
    }
    for vertex in 0..solid.vertices.len() as u32 {
        let around: BTreeSet<usize> = next_face.range((vertex, 0)..(vertex + 1, 0)).map(|((_, f), _)| *f).collect();
        let mut seen: Vec<usize> = around.iter().copied().take(1).collect();
        let mut at = 0;
        while at < seen.len() {
            for &f in &next_face[&(vertex, seen[at])] {
                if !seen.contains(&f) {
                    seen.push(f);
                }
            }
            at += 1;
        }
        assert!(!around.is_empty() && seen.len() == around.len(), "vertex {vertex} is not one fan");
    }
    assert_eq!(solid.vertices.iter().collect::<BTreeSet<_>>().len(), solid.vertices.len());
}

/// Twice the area of a polygon of grid points, in square steps.
fn doubled(polygon: &FootprintPolygon) -> i128 {
    assert!(doubled_area(&polygon[0]) > 0 && polygon[1..].iter().all(|hole| doubled_area(hole) < 0));
    polygon.iter().map(|ring| doubled_area(ring)).sum()
}

/// The blocks over all polygons, checked; returns the total area in square metres.
fn check_blocks(polygons: &[FootprintPolygon]) -> f64 {
    polygons
        .iter()
        .map(|polygon| {
            let solid = block(polygon, -12_345, 67_890, STEP).unwrap();
            assert_closed_manifold(&solid);
            let area = doubled(polygon) as f64 / 2.0 * 1e-8;
            assert!((solid.volume() - area * 8.0235).abs() < 1e-6 * area.max(1.0), "{} {}", solid.volume(), area);
            area
        })
        .sum()
}

#[test]
fn a_courtyard_block_is_as_worked_out_by_hand() {
    // 10 m × 8 m with a hole of 4 m × 2 m, and a collinear vertex on the south side.
    let footprint = polygon!(
        exterior: [(x: 0., y: 0.), (x: 5., y: 0.), (x: 10., y: 0.), (x: 10., y: 8.), (x: 0., y: 8.)],
        interiors: [[(x: 3., y: 3.), (x: 3., y: 5.), (x: 7., y: 5.), (x: 7., y: 3.)]],
    );
    let (polygons, notes) = footprint_of(footprint);
    assert!(notes.is_empty());
    let solid = block(&polygons[0], 0, 30_000, STEP).unwrap();
    assert_closed_manifold(&solid);
    assert_eq!(solid.vertices.len(), 16);
    assert_eq!(solid.faces.len(), 2 + 8);
    assert!((solid.volume() - 72.0 * 3.0).abs() < 1e-9);
    let kinds: Vec<_> = solid.faces.iter().map(|face| solid.kind(face)).collect();
    assert_eq!(kinds[..2], [SurfaceType::Ground, SurfaceType::Roof]);
    assert!(kinds[2..].iter().all(|&kind| kind == SurfaceType::Wall));
    assert_eq!(solid.surfaces[1].heights, Some([3.0, 3.0]));
    let up = solid.newell(&solid.faces[1].rings[0]);
    assert!(up.z > 0.0 && up.x == 0.0 && up.y == 0.0);
    assert!(block(&polygons[0], 0, 9, STEP).is_none());
}

fn footprint_of(polygon: Polygon<f64>) -> (Vec<FootprintPolygon>, Vec<String>) {
    on_grid(&MultiPolygon(vec![polygon]))
}

#[test]
fn walls_on_one_line_share_a_surface() {
    // A comb: three teeth whose tips lie on one line.
    let comb: Polygon<f64> = polygon![
        (x: 0., y: 0.), (x: 5., y: 0.), (x: 5., y: 2.), (x: 4., y: 2.), (x: 4., y: 1.), (x: 3., y: 1.),
        (x: 3., y: 2.), (x: 2., y: 2.), (x: 2., y: 1.), (x: 1., y: 1.), (x: 1., y: 2.), (x: 0., y: 2.),
    ];
    let solid = block(&footprint_of(comb).0[0], 0, 10_000, STEP).unwrap();
    assert_closed_manifold(&solid);
    // South, east, west, the tips, the two gaps' floors, and six flanks less the outer two.
    assert_eq!(solid.surfaces.len() - 2, 3 + 1 + 1 + 4);
}

#[test]
fn a_hole_that_touches_the_exterior_is_set_apart() {
    // The hole's west corner touches the middle of the exterior's west side; its east corner a corner of a dent.
    let touching = polygon!(
        exterior: [(x: 0., y: 0.), (x: 10., y: 0.), (x: 10., y: 4.), (x: 7., y: 5.), (x: 10., y: 6.), (x: 10., y: 10.), (x: 0., y: 10.)],
        interiors: [[(x: 0., y: 5.), (x: 3., y: 7.), (x: 7., y: 5.), (x: 3., y: 3.)]],
    );
    let (polygons, notes) = footprint_of(touching.clone());
    assert_eq!(polygons.len(), 1);
    assert_eq!(polygons[0].len(), 2, "the hole is still there");
    assert_eq!(notes.len(), 1, "{notes:?}");
    assert!((check_blocks(&polygons) - touching.unsigned_area()).abs() < 1e-3);
}

#[test]
fn holes_that_touch_each_other_are_set_apart() {
    let touching = polygon!(
        exterior: [(x: 0., y: 0.), (x: 10., y: 0.), (x: 10., y: 10.), (x: 0., y: 10.)],
        interiors: [
            [(x: 2., y: 2.), (x: 2., y: 5.), (x: 5., y: 5.), (x: 5., y: 2.)],
            [(x: 5., y: 5.), (x: 5., y: 8.), (x: 8., y: 8.), (x: 8., y: 5.)],
        ],
    );
    let (polygons, _) = footprint_of(touching);
    assert_eq!((polygons.len(), polygons[0].len()), (1, 3));
    assert!((check_blocks(&polygons) - 82.0).abs() < 1e-3);
}

#[test]
fn what_is_wrong_is_mended_or_told() {
    let bow_tie: Polygon<f64> = polygon![(x: 0., y: 0.), (x: 4., y: 4.), (x: 4., y: 0.), (x: 0., y: 4.)];
    let (polygons, notes) = footprint_of(bow_tie);
    assert_eq!((polygons.len(), notes.len()), (2, 1), "{notes:?}");
    assert!((check_blocks(&polygons) - 8.0).abs() < 1e-3);

    let thread: Polygon<f64> = polygon![(x: 0., y: 0.), (x: 40., y: 0.), (x: 40., y: 0.0005), (x: 0., y: 0.0005)];
    let (polygons, notes) = footprint_of(thread);
    assert!(polygons.is_empty());
    assert_eq!(notes.len(), 1, "{notes:?}");

    let stray_hole = polygon!(
        exterior: [(x: 0., y: 0.), (x: 4., y: 0.), (x: 4., y: 4.), (x: 0., y: 4.)],
        interiors: [[(x: 5., y: 1.), (x: 6., y: 1.), (x: 6., y: 2.)]],
    );
    let (polygons, notes) = footprint_of(stray_hole);
    assert_eq!((polygons[0].len(), notes.len()), (1, 1), "{notes:?}");
    assert!((check_blocks(&polygons) - 16.0).abs() < 1e-9);
}

#[test]
fn parts_that_share_an_edge_stay_apart() {
    let left: Polygon<f64> = polygon![(x: 0., y: 0.), (x: 1., y: 0.), (x: 1., y: 1.), (x: 0., y: 1.)];
    let right: Polygon<f64> = polygon![(x: 1., y: 0.), (x: 2., y: 0.), (x: 2., y: 1.), (x: 1., y: 1.)];
    let (polygons, notes) = on_grid(&MultiPolygon(vec![left, right]));
    assert_eq!((polygons.len(), notes.len()), (2, 0));
    assert!((check_blocks(&polygons) - 2.0).abs() < 1e-9);
}

#[test]
fn places_that_validators_would_snap_together_are_set_apart() {
    // The hole's corner is 0.4 mm from the exterior's side.
    let close = polygon!(
        exterior: [(x: 0., y: 0.), (x: 10., y: 0.), (x: 10., y: 10.), (x: 0., y: 10.)],
        interiors: [[(x: 0.0004, y: 5.), (x: 3., y: 7.), (x: 3., y: 3.)]],
    );
    let (polygons, _) = footprint_of(close);
    assert!((check_blocks(&polygons) - 94.0).abs() < 1e-2);
    let nearest =
        polygons[0][1].iter().map(|&p| ring::distance_to_segment(p, [0, 100_000], [0, 0])).fold(f64::MAX, f64::min);
    assert!(nearest > 10.0, "{nearest} steps");
}

#[test]
fn real_footprints_come_through_unharmed() {
    for (name, count) in [("delft-quickstart/footprints.geojson", 71), ("amsterdam-dense/footprints.geojson", 31)] {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data").join(name);
        let Ok(text) = std::fs::read_to_string(&path) else {
            println!("skipped: shared data not found");
            return;
        };
        let root: serde_json::Value = serde_json::from_str(&text).unwrap();
        let features = root["features"].as_array().unwrap();
        assert_eq!(features.len(), count);
        for feature in features {
            let polygons = match feature["geometry"]["type"].as_str().unwrap() {
                "Polygon" => vec![feature["geometry"]["coordinates"].clone()],
                _ => feature["geometry"]["coordinates"].as_array().unwrap().clone(),
            };
            let polygons = polygons.iter().map(|rings| {
                let mut lines = rings.as_array().unwrap().iter().map(|ring| -> geo::LineString<f64> {
                    let corner = |p: &serde_json::Value| (p[0].as_f64().unwrap(), p[1].as_f64().unwrap());
                    ring.as_array().unwrap().iter().map(corner).collect()
                });
                Polygon::new(lines.next().unwrap(), lines.collect())
            });
            let outline = MultiPolygon(polygons.collect());
            let (x, y) = outline.0[0].exterior().0[0].x_y();
            let local = geo::Translate::translate(&outline, -x.floor(), -y.floor());
            let expected = local.unsigned_area();
            let (polygons, notes) = on_grid(&local);
            let area = check_blocks(&polygons);
            assert!((area - expected).abs() < 1e-4 * expected, "{area} {expected}");
            assert!(notes.is_empty(), "{notes:?} {feature}");
        }
    }
}

/// A star-shaped ring around a point, radii in metres.
fn star(centre: [f64; 2], radii: &[f64], turn: f64) -> Vec<(f64, f64)> {
    let n = radii.len() as f64;
    let corner = |(i, r): (usize, &f64)| {
        let angle = turn + TAU * i as f64 / n;
        (centre[0] + r * angle.cos(), centre[1] + r * angle.sin())
    };
    radii.iter().enumerate().map(corner).collect()
}

prop_compose! {
    /// A star with up to five star-shaped holes, each in its own sector; some holes reach out to touch the exterior.
    fn holed_polygon()(
        radii in prop::collection::vec(12.0..30.0f64, 5..40),
        holes in prop::collection::vec((prop::collection::vec(0.2..2.0f64, 3..8), 0.0..TAU, any::<bool>()), 0..=5),
        turn in 0.0..TAU,
    ) -> (Polygon<f64>, bool) {
        let exterior = star([0.0, 0.0], &radii, turn);
        let mut touches = false;
        let interiors = holes.iter().enumerate().map(|(i, (radii, turn, touch))| {
            let angle = TAU * i as f64 / 5.0;
            let mut ring = star([5.0 * angle.cos(), 5.0 * angle.sin()], radii, *turn);
            // The exterior vertex in the middle of the hole's sector, if there is one: straight ahead, nothing between.
            let ahead = exterior.iter().find(|(x, y)| {
                let off = (y.atan2(*x) - angle).rem_euclid(TAU);
                !(0.1..=TAU - 0.1).contains(&off)
            });
            if let (true, Some(&vertex)) = (*touch && exterior.len() < 12, ahead) {
                let arm = |side: f64| (5.0 * (angle + side).cos(), 5.0 * (angle + side).sin());
                ring = vec![arm(-0.1), vertex, arm(0.1)];
                touches = true;
            }
            geo::LineString::from(ring)
        }).collect();
        (Polygon::new(geo::LineString::from(exterior), interiors), touches)
    }
}

/// Area inside a ring by the even-odd rule: between the x of all vertices and crossings, the length of a vertical line
/// inside is linear in x, so that its middle gives the area.
fn even_odd_area(ring: &geo::LineString<f64>) -> f64 {
    let edges: Vec<_> = ring.lines().collect();
    let mut breaks: Vec<f64> = ring.coords().map(|c| c.x).collect();
    for (i, e) in edges.iter().enumerate() {
        for f in &edges[i + 1..] {
            let (d, g, w) = (e.delta(), f.delta(), f.start - e.start);
            let cross = d.x * g.y - d.y * g.x;
            if cross != 0.0 {
                breaks.push(e.start.x + d.x * (w.x * g.y - w.y * g.x) / cross);
            }
        }
    }
    breaks.sort_by(f64::total_cmp);
    let slab = |pair: &[f64]| {
        let x = f64::midpoint(pair[0], pair[1]);
        let over = edges.iter().filter(|e| (e.start.x > x) != (e.end.x > x));
        let mut y: Vec<f64> = over.map(|e| e.start.y + e.delta().y * (x - e.start.x) / e.delta().x).collect();
        y.sort_by(f64::total_cmp);
        y.chunks(2).map(|inside| inside[1] - inside[0]).sum::<f64>() * (pair[1] - pair[0])
    };
    breaks.windows(2).map(slab).sum()
}

proptest! {
    #[test]
    fn any_polygon_with_holes_gives_valid_blocks((polygon, touches) in holed_polygon()) {
        let expected = polygon.unsigned_area();
        let holes = polygon.interiors().len();
        let (polygons, notes) = footprint_of(polygon);
        let area = check_blocks(&polygons);
        prop_assert!((area - expected).abs() < 0.02, "{area} {expected} {notes:?}");
        prop_assert_eq!(polygons.iter().map(|p| p.len() - 1).sum::<usize>(), holes);
        prop_assert!(touches || notes.is_empty(), "{:?}", notes);
    }

    /// Any ring whatever, far from valid, on a coarse lattice so that touches and overlaps are the rule:
    /// nothing of its area (even-odd) is lost.
    #[test]
    fn any_ring_gives_valid_blocks(ring in prop::collection::vec((0..12i32, 0..12i32), 0..24)) {
        let line: geo::LineString<f64> = ring.iter().map(|&(x, y)| (f64::from(x) * 0.5, f64::from(y) * 0.5)).collect();
        let polygon = Polygon::new(line, Vec::new());
        let expected = even_odd_area(polygon.exterior());
        let (polygons, notes) = footprint_of(polygon);
        let area = check_blocks(&polygons);
        prop_assert!((area - expected).abs() < 0.02, "{area} {expected} {notes:?}");
    }

    /// The same at the scale of the grid, where rounding and snapping decide.
    #[test]
    fn any_tiny_ring_gives_valid_blocks(ring in prop::collection::vec((0..60i32, 0..60i32), 0..16)) {
        let line: geo::LineString<f64> = ring.iter().map(|&(x, y)| (f64::from(x) * 1e-3, f64::from(y) * 1e-3)).collect();
        let (polygons, _) = footprint_of(Polygon::new(line, Vec::new()));
        check_blocks(&polygons);
    }
}

#[test]
fn an_edge_of_exactly_the_snapping_distance_is_none() {
    // The tip of the needle is 6 by 8 steps wide: 1 mm, which validators compute as a little less.
    let needle = polygon![
        (x: 0.0, y: 0.0), (x: 4.0, y: 0.0), (x: 6.0, y: -4.0), (x: 6.0006, y: -3.9992), (x: 4.1, y: 0.2), (x: 8.0, y: 3.0),
        (x: 0.0, y: 6.0)
    ];
    let (polygons, _) = on_grid(&MultiPolygon(vec![needle]));
    let solid = block(&polygons[0], 0, 30_000, STEP).unwrap();
    assert_eq!(validate::check(&solid, &validate::Tolerances::default()), []);
    assert_eq!(polygons[0][0].len(), 6);
}
