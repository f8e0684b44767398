use std::collections::BTreeMap;

use geo::{Area, Contains};
use nalgebra::{Point2, Point3};

use super::expression::Expression;
use super::plan::{Axis, Plan, Rectangle};
use super::roof::{Block, Roof};
use super::*;
use crate::geometry::Aabb;
use crate::solid::SurfaceType;
use crate::validate::{Tolerances, check, composite};

/// The buildings of the first seeds; fails where more than one in 200 gave none.
fn buildings(count: u64) -> Vec<(u64, Generated)> {
    let found: Vec<_> = (0..count).filter_map(|seed| Some((seed, building(seed).ok()?))).collect();
    assert!(found.len() as f64 >= 0.995 * count as f64, "{} of {count}", found.len());
    found
}

fn area_of(solid: &Solid, kind: SurfaceType) -> f64 {
    solid.faces.iter().filter(|face| solid.kind(face) == kind).map(|face| solid.area(face)).sum()
}

#[test]
fn two_thousand_seeds_give_valid_buildings_of_all_kinds() {
    let found = buildings(2000);
    let mut counts: BTreeMap<String, f64> = BTreeMap::new();
    for (seed, Generated { solid, footprint, neighbours, shape, ground, .. }) in &found {
        for solid in neighbours.iter().chain([solid]) {
            assert_eq!(check(solid, &Tolerances::default()), [], "seed {seed}");
        }
        // Where nothing hangs over, the outline is that of the ground; else it is larger.
        let bottom = area_of(solid, SurfaceType::Ground);
        let outline = footprint.unsigned_area();
        if shape.is_height_field() {
            assert!((outline - bottom).abs() < 1e-3 * outline, "seed {seed}: {outline} m² over {bottom} m²");
        } else {
            assert!(outline > bottom + 0.2, "seed {seed}: {outline} m² over {bottom} m²");
        }
        let lowest = solid.vertices.iter().map(|v| v[2] as f64 * solid.step[2]).fold(f64::INFINITY, f64::min);
        assert!((lowest - ground).abs() < 1e-3, "seed {seed}");
        assert_eq!(neighbours.len(), usize::from(shape.party_walls), "seed {seed}");
        assert_eq!(footprint.0.iter().any(|polygon| !polygon.interiors().is_empty()), shape.courtyard, "seed {seed}");

        let features = [
            ("dormers", shape.dormers > 0),
            ("chimneys", shape.chimneys > 0),
            ("courtyard", shape.courtyard),
            ("overhang", shape.overhang),
            ("arcade", shape.arcade),
            ("eaves", shape.eaves),
            ("party walls", shape.party_walls > 0),
            ("several blocks", shape.blocks > 1),
            ("four or more blocks", shape.blocks > 3),
            ("not a height field", !shape.is_height_field()),
        ];
        let names = features.into_iter().filter(|(_, has)| *has).map(|(name, _)| name.to_owned());
        for name in names.chain([format!("{:?}", shape.roof)]) {
            *counts.entry(name).or_default() += 1.0 / found.len() as f64;
        }
        assert!((1..=5).contains(&shape.blocks), "seed {seed}: {} blocks", shape.blocks);
    }
    let expected = [
        ("Flat", 0.22),
        ("Shed", 0.075),
        ("Gable", 0.22),
        ("Hip", 0.12),
        ("HalfHip", 0.08),
        ("Mansard", 0.08),
        ("Gambrel", 0.07),
        ("Pyramid", 0.07),
        ("Dome", 0.058),
        ("dormers", 0.08),
        ("chimneys", 0.32),
        ("courtyard", 0.065),
        ("overhang", 0.065),
        ("arcade", 0.065),
        ("eaves", 0.11),
        ("party walls", 0.23),
        ("several blocks", 0.54),
        ("four or more blocks", 0.14),
        ("not a height field", 0.13),
    ];
    assert_eq!(counts.len(), expected.len(), "{counts:?}");
    for (name, share) in expected {
        // Four standard deviations of a share of 2 000.
        let doubt = 4.0 * (share * (1.0 - share) / 2000.0_f64).sqrt();
        assert!((counts[name] - share).abs() < doubt, "{name}: {} instead of {share}", counts[name]);
    }
}

#[test]
fn the_volume_is_that_of_the_pieces() {
    let mut random = Random::new(1);
    for seed in (0..4000).step_by(100) {
        let (draft, Generated { solid, footprint, .. }) = drawn(seed).unwrap();
        // The pieces as they were drawn: no complex, no snapping, no extraction.
        let expression = draft.placed(&draft.expression);
        let corners: Vec<Point3<f64>> = (0..solid.vertices.len() as u32).map(|v| solid.point(v)).collect();
        let bounds = Aabb::of(&corners).unwrap();
        let extent = bounds.extent();
        let count = 20_000;
        let mut hits = 0.0;
        for _ in 0..count {
            let point = Point3::from(std::array::from_fn(|i| bounds.min[i] + extent[i] * random.unit()));
            if expression.contains(&point) {
                hits += 1.0;
                let below = geo::Point::new(point.x, point.y);
                assert!(draft.shape.eaves || footprint.contains(&below), "seed {seed}: {point} is beyond the outline");
            }
        }
        let share: f64 = hits / f64::from(count);
        let box_volume: f64 = extent.iter().product();
        let doubt = 4.0 * (share * (1.0 - share) / f64::from(count)).sqrt();
        assert!((solid.volume() / box_volume - share).abs() < doubt, "seed {seed}: {} m³", solid.volume());
    }
}

#[test]
fn roofs_have_the_volumes_of_the_text_books() {
    let (length, width, eave) = (12.0_f64, 8.0_f64, 5.0_f64);
    let volume = |kind: RoofKind, tangents: [f64; 2], rise: f64| {
        let plan = Plan::rectangle(Rectangle { u: [0.0, length], v: [0.0, width] });
        let roof = Roof { kind, ridge: Axis::U, tangents, rise, ..Roof::flat(eave) };
        let expression = Expression { added: vec![Block { plan, roof }.body()], ..Expression::default() };
        expression.solid([1e-4; 3], &MultiPolygon(Vec::new())).unwrap().volume() - length * width * eave
    };
    let close = |found: f64, expected: f64| assert!((found - expected).abs() < 0.01, "{found} instead of {expected}");
    close(volume(RoofKind::Flat, [0.0; 2], 0.0), 0.0);
    close(volume(RoofKind::Shed, [0.5, 0.0], 0.0), length * width * 4.0 / 2.0);
    close(volume(RoofKind::Gable, [1.0; 2], 0.0), length * width * 4.0 / 2.0);
    // Ridge of length − width; a wedge with ends that slope like the sides.
    close(volume(RoofKind::Hip, [1.0; 2], 0.0), width * 4.0 * (2.0 * length + (length - width)) / 6.0);
    // The gable without its tips, 2 m wide and 1 m high, which the hips cut off 1 m deep at the ridge.
    close(volume(RoofKind::HalfHip, [1.0; 2], 3.0), 192.0 - 2.0 * (2.0 * 1.0 / 2.0) * 1.0 / 3.0);
    close(volume(RoofKind::Pyramid, [0.0; 2], 3.0), length * width * 3.0 / 3.0);
    // 2 m up at 2 : 1 on all sides, then flat: a frustum.
    let (lower, upper) = (length * width, (length - 2.0) * (width - 2.0));
    let middle = (length - 1.0) * (width - 1.0);
    close(volume(RoofKind::Mansard, [2.0, 0.0], 2.0), 2.0 * (lower + 4.0 * middle + upper) / 6.0);
    // 2 m up at 2 : 1 on two sides, then 1.5 m at 1 : 2.
    close(volume(RoofKind::Gambrel, [2.0, 0.5], 2.0), length * (2.0 * 7.0 + 6.0 * 1.5 / 2.0));
}

#[test]
fn a_dome_of_many_facets_comes_near_to_an_ellipsoid() {
    let plan = Plan::regular(Point2::new(1.0, 2.0), 5.0, 12);
    let roof = Roof { kind: RoofKind::Dome, rise: 3.0, ..Roof::flat(4.0) };
    let expression = Expression { added: vec![Block { plan, roof }.body()], ..Expression::default() };
    let found = expression.solid([1e-4; 3], &MultiPolygon(Vec::new())).unwrap().volume();
    let disc = std::f64::consts::PI * 25.0;
    let round = disc * 4.0 + disc * 2.0 / 3.0 * 3.0;
    // Chords lie inside of the curve, and the polygon outside of the disc.
    assert!((found / round - 1.0).abs() < 0.04, "{found} m³ instead of {round} m³");
}

#[test]
fn what_hangs_over_has_an_underside() {
    for (seed, Generated { solid, shape, ground, .. }) in buildings(300) {
        let undersides = solid.faces.iter().filter(|face| solid.kind(face) == SurfaceType::OuterCeiling);
        let lowest = |face: &crate::solid::Face| {
            let ring = face.rings[0].iter();
            ring.map(|&v| solid.point(v).z).fold(f64::INFINITY, f64::min) - ground
        };
        let level = |face: &&crate::solid::Face| solid.newell(&face.rings[0]).normalize().z < -0.999;
        let level: Vec<f64> = undersides.clone().filter(level).map(lowest).collect();
        if shape.arcade || shape.overhang {
            assert!(level.iter().any(|height| *height > 0.5), "seed {seed}: {shape:?}");
        }
        if shape.arcade {
            let largest = undersides.clone().map(|face| solid.area(face)).fold(0.0, f64::max);
            assert!(level.iter().any(|height| *height >= 2.0) && largest > 1.0, "seed {seed}: {shape:?}");
        }
        if shape.is_height_field() && !shape.eaves {
            assert_eq!(undersides.count(), 0, "seed {seed}: {shape:?}");
        }
    }
}

#[test]
fn neighbours_share_a_wall_and_no_space() {
    let joined = buildings(400).into_iter().filter(|(_, generated)| generated.shape.party_walls > 0);
    let mut count = 0;
    for (seed, Generated { solid, neighbours, .. }) in joined {
        for neighbour in neighbours {
            let faults = composite::check(&[vec![solid.clone()], vec![neighbour]], 0.001);
            assert_eq!(faults, [], "seed {seed}");
            count += 1;
        }
    }
    assert!(count > 50);
}

#[test]
fn the_same_seed_gives_the_same_building() {
    for seed in [0, 7, 1 << 60] {
        assert_eq!(building(seed), building(seed));
    }
    assert_ne!(building(1).unwrap().solid, building(2).unwrap().solid);
}
