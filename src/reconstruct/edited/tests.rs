//! Edits of a hall with a tower: a flat roof of 20 m by 16 m at 6 m, and a part of 5 m by 5 m at 10 m.

use geo::{MultiPolygon, polygon};

use super::*;
use crate::building::{Building, Outcome};
use crate::edits::{Action, Lie, PlaneAt, Region};
use crate::reconstruct::occupancy::HeightField;
use crate::reconstruct::{Memory, Parameters, reconstruct, reconstruct_again, reconstruct_in_steps};
use crate::site::GroundSource;

/// The place of the hall in its CRS.
const ORIGIN: [f64; 3] = [85_000.0, 447_000.0, 2.0];

fn hall() -> Site {
    let is_tower = |x: f64, y: f64| (10.0..15.0).contains(&x) && (6.0..11.0).contains(&y);
    let grid = (0_u32..40 * 32).map(|i| (0.25 + 0.5 * f64::from(i % 40), 0.25 + 0.5 * f64::from(i / 40)));
    let points = grid.map(|(x, y)| Point3::new(x, y, if is_tower(x, y) { 10.0 } else { 6.0 })).collect();
    let footprint = polygon![(x: 0.0, y: 0.0), (x: 20.0, y: 0.0), (x: 20.0, y: 16.0), (x: 0.0, y: 16.0)];
    let frame = Frame { origin: ORIGIN, metres_per_unit: [1.0; 3] };
    Site::new("hall", frame, points, 0.0).with_footprint(&MultiPolygon(vec![footprint]))
}

fn crs([x, y, z]: [f64; 3]) -> Place {
    [x + ORIGIN[0], y + ORIGIN[1], z + ORIGIN[2]]
}

fn flat([x, y]: [f64; 2]) -> [f64; 2] {
    [x + ORIGIN[0], y + ORIGIN[1]]
}

/// The corners of a level rectangle.
fn level(x: [f64; 2], y: [f64; 2], z: f64) -> Vec<Place> {
    [[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]].map(|[x, y]| crs([x, y, z])).into()
}

/// A level plane that was seen there.
fn plane_at(x: [f64; 2], y: [f64; 2], z: f64) -> PlaneAt {
    PlaneAt { equation: [0.0, 0.0, 1.0, -(z + ORIGIN[2])], extent: level(x, y, z) }
}

fn with(actions: impl IntoIterator<Item = Action>) -> Site {
    Site { edits: actions.into_iter().map(Edit::from).collect(), ..hall() }
}

fn made(actions: impl IntoIterator<Item = Action>) -> Building {
    let building = reconstruct(&with(actions), &Parameters::default(), &HeightField);
    assert_eq!(building.outcome, Outcome::Lod22, "{:?}", building.notes);
    building
}

fn volume(building: &Building) -> f64 {
    building.measures.volume_lod22.unwrap()
}

/// That all edits of a building apply.
fn all_apply(building: &Building) {
    let tally = building.measures.edits.as_ref().unwrap();
    assert_eq!(tally.refused, [], "{tally:?}");
}

fn bytes(building: &Building) -> String {
    serde_json::to_string(building).unwrap()
}

/// What stands in the tower; its walls were not scanned, and are known to a pixel of the roof map.
const TOWER: f64 = 5.0 * 5.0 * 4.0;
const HALL: f64 = 20.0 * 16.0 * 6.0;
/// Half a metre on each side of the tower is a fifth of it.
const OF_TOWER: f64 = 25.0;

#[test]
fn a_plane_that_is_off_is_not_modelled_and_comes_back_when_it_is_on() {
    let before = made([]);
    assert!((volume(&before) - HALL - TOWER).abs() < OF_TOWER && before.measures.edits.is_none());
    let tower = plane_at([10.3, 14.7], [6.3, 10.7], 10.0);
    let off = Action::SwitchPlane { plane: tower.clone(), on: false };
    let without = made([off.clone()]);
    all_apply(&without);
    assert!((volume(&without) - HALL).abs() < 1.0, "{}", volume(&without));
    let mut again = made([off, Action::SwitchPlane { plane: tower, on: true }]);
    all_apply(&again);
    again.measures.edits = None;
    assert_eq!(bytes(&again), bytes(&before));
}

#[test]
fn a_plane_that_nobody_scanned_is_added_and_one_that_was_is_found_in_its_points() {
    let add = |places, unseen| Action::AddPlane { places, lie: None, unseen };
    let asserted = made([add(level([2.0, 7.0], [2.0, 7.0], 9.0), true)]);
    all_apply(&asserted);
    let more = volume(&asserted) - volume(&made([]));
    assert!((more - 25.0 * 3.0).abs() < 15.0, "{more}");
    let refused = made([add(level([2.0, 7.0], [2.0, 7.0], 9.0), false)]);
    assert!(refused.notes.iter().any(|note| note.contains("edit 1 (add-plane)") && note.contains("0 point(s)")));
    // Through the points of the tower, of which the detector is told to see none.
    let tower = plane_at([10.3, 14.7], [6.3, 10.7], 10.0);
    let places = level([10.0, 15.0], [6.0, 11.0], 10.0);
    let level = Action::AddPlane { places, lie: Some(Lie::Level), unseen: false };
    let again = made([Action::SwitchPlane { plane: tower, on: false }, level]);
    all_apply(&again);
    assert!((volume(&again) - HALL - TOWER).abs() < OF_TOWER, "{}", volume(&again));
}

#[test]
fn marks_are_followed_on_both_sides() {
    let outside = made([Action::MarkPlace { place: crs([12.5, 8.5, 8.0]), inside: false }]);
    all_apply(&outside);
    assert!((volume(&outside) - HALL).abs() < 1.0, "{}", volume(&outside));
    let inside = made([Action::MarkPlace { place: crs([3.0, 8.0, 8.0]), inside: true }]);
    all_apply(&inside);
    assert!(volume(&inside) > HALL + TOWER + 50.0, "{}", volume(&inside));
    let beyond = made([
        Action::MarkPlace { place: crs([-0.5, 8.0, 3.0]), inside: true },
        Action::MarkPlace { place: crs([100.0, 8.0, 3.0]), inside: true },
    ]);
    let whys: Vec<String> = beyond.measures.edits.unwrap().refused.into_iter().map(|refused| refused.why).collect();
    assert!(whys[0].contains("beyond the footprint") && whys[1].contains("beyond the building"), "{whys:?}");
}

#[test]
fn something_hangs_over_where_marks_say_so() {
    // The tower stays, and what lies under it goes: a bridge from nowhere, which no height field could be.
    let marks = [([12.5, 8.5, 8.0], true), ([12.5, 8.5, 3.0], false)];
    let building = made(marks.map(|(place, inside)| Action::MarkPlace { place: crs(place), inside }));
    let tally = building.measures.edits.as_ref().unwrap();
    assert_eq!(tally.applied + tally.refused.len(), 2);
    assert!(volume(&building) < HALL + TOWER - 20.0, "{}", volume(&building));
}

#[test]
fn planes_are_turned_and_moved() {
    let tower = || plane_at([10.3, 14.7], [6.3, 10.7], 10.0);
    let moved = made([Action::MovePlane { plane: tower(), to: [0.0, 0.0, 1.0, -(9.0 + ORIGIN[2])] }]);
    all_apply(&moved);
    assert!((volume(&moved) - HALL - 0.75 * TOWER).abs() < 12.0, "{}", volume(&moved));
    let slope = [0.0, -0.1, 1.0];
    let turned = made([Action::AlignPlane { plane: tower(), lie: Lie::Parallel(slope) }]);
    all_apply(&turned);
    assert_eq!(turned.measures.roof_type, Some(crate::building::RoofType::Slanted));
    let level = made([Action::AlignPlane { plane: tower(), lie: Lie::Level }]);
    assert_eq!(level.measures.roof_type, Some(crate::building::RoofType::MultipleFlat));
}

#[test]
fn floor_points_and_parameters_are_the_buildings_own() {
    let raised = made([Action::SetFloor { height: ORIGIN[2] + 1.0 }]);
    all_apply(&raised);
    assert_eq!(raised.measures.ground.map(|ground| (ground.height, ground.source)), Some((1.0, GroundSource::Edit)));
    assert!((volume(&raised) + HALL / 6.0 - volume(&made([]))).abs() < 1.0, "{}", volume(&raised));
    let ring = [[9.8, 5.8], [15.2, 5.8], [15.2, 11.2], [9.8, 11.2]].map(flat).to_vec();
    let region = Region::Polygon { ring, heights: Some([9.0 + ORIGIN[2], 99.0]) };
    let lower = made([Action::ExcludePoints { region }]);
    all_apply(&lower);
    assert!((volume(&lower) - HALL).abs() < 1.0 && lower.measures.points == 40 * 32 - 100);
    let few = made([Action::SetParameters { lambda: Some(0.3), minimum_feature: None }]);
    all_apply(&few);
    let none = made([Action::SetParameters { lambda: None, minimum_feature: None }]);
    assert_eq!(none.measures.edits.unwrap().applied, 0);
}

#[test]
fn footprints_are_redrawn_split_and_merged() {
    let before = volume(&made([]));
    let edge = [[20.0, 0.1], [20.1, 16.0]].map(flat);
    let wider = made([Action::OffsetEdge { edge, distance: 1.0 }]);
    all_apply(&wider);
    assert!((volume(&wider) - before - 96.0).abs() < 5.0, "{} {before}", volume(&wider));
    let narrower = made([Action::OffsetEdge { edge, distance: -2.0 }]);
    assert!((volume(&narrower) - before + 192.0).abs() < 5.0, "{} {before}", volume(&narrower));
    let split = made([Action::SplitParts { line: vec![flat([5.0, 0.0]), flat([5.0, 16.0])] }]);
    all_apply(&split);
    assert_eq!((split.model.lod22().count(), made([]).model.lod22().count()), (2, 1));
    let rings = |x: [f64; 2]| vec![[[x[0], 0.0], [x[1], 0.0], [x[1], 16.0], [x[0], 16.0]].map(flat).to_vec()];
    let apart = Action::RedrawFootprint { polygons: vec![rings([0.0, 8.0]), rings([8.2, 20.0])] };
    let two = made([apart.clone()]);
    all_apply(&two);
    assert_eq!(two.model.lod22().count(), 2);
    let merged = made([apart, Action::MergeParts { gap: 0.5 }]);
    all_apply(&merged);
    assert_eq!(merged.model.lod22().count(), 1);
    assert!((volume(&merged) - before).abs() < 0.01 * before, "{} {before}", volume(&merged));
    let bow = vec![vec![[[0.0, 0.0], [20.0, 16.0], [20.0, 0.0], [0.0, 10.0]].map(flat).to_vec()]];
    let bad = made([Action::RedrawFootprint { polygons: bow }]);
    assert!(bad.measures.edits.unwrap().refused[0].why.contains("invalid"));
}

#[test]
fn what_no_longer_applies_is_told_and_stops_nothing() {
    let elsewhere = Action::SwitchPlane { plane: plane_at([0.0, 5.0], [0.0, 5.0], 14.0), on: false };
    let far = Action::MarkPlace { place: [0.0, 0.0, 0.0], inside: true };
    let absurd = Action::MovePlane { plane: plane_at([10.3, 14.7], [6.3, 10.7], 10.0), to: [0.0; 4] };
    let nowhere = Action::ExcludePoints { region: Region::Near { places: vec![crs([5.0, 5.0, 20.0])], radius: 1.0 } };
    let floor = Action::SetFloor { height: ORIGIN[2] + 1.0 };
    let building = made([elsewhere, far, absurd, nowhere, floor]);
    let tally = building.measures.edits.as_ref().unwrap();
    assert_eq!((tally.applied, tally.refused.len()), (1, 4), "{tally:?}");
    assert_eq!(tally.refused.iter().map(|refused| refused.number).collect::<Vec<_>>(), [1, 2, 3, 4]);
    for refused in &tally.refused {
        let note = format!("edit {} ({}) does not apply: {}", refused.number, refused.action, refused.why);
        assert!(building.notes.contains(&note), "{note}");
    }
}

#[test]
fn numbers_that_are_none_break_nothing() {
    let numbers = [f64::NAN, f64::INFINITY, -f64::INFINITY, 1e308, 0.0];
    for n in numbers {
        let plane = PlaneAt { equation: [n; 4], extent: vec![[n; 3]; 3] };
        let actions = [
            Action::SwitchPlane { plane: plane.clone(), on: false },
            Action::AddPlane { places: vec![[n; 3]; 4], lie: None, unseen: true },
            Action::AlignPlane { plane: plane_at([10.3, 14.7], [6.3, 10.7], 10.0), lie: Lie::Parallel([n; 3]) },
            Action::MovePlane { plane, to: [n; 4] },
            Action::MarkPlace { place: [n; 3], inside: false },
            Action::SetFloor { height: if n == 0.0 { 2.0 } else { n } },
            Action::ExcludePoints { region: Region::Near { places: vec![[n; 3]], radius: n } },
            Action::ExcludePoints { region: Region::Box { min: [n; 3], max: [n; 3] } },
            Action::ExcludePoints { region: Region::Polygon { ring: vec![[n; 2]; 3], heights: Some([n; 2]) } },
            Action::RedrawFootprint { polygons: vec![vec![vec![[n; 2]; 4]], vec![]] },
            Action::OffsetEdge { edge: [[n; 2]; 2], distance: n },
            Action::SplitParts { line: vec![[n; 2]; 2] },
        ];
        let building = made(actions.clone());
        assert!(building.measures.edits.as_ref().is_some_and(|edits| edits.refused.len() >= 11), "{n}: {building:?}");
    }
}

#[test]
fn a_session_makes_the_same_bytes_whatever_it_remembers() {
    let tower = || plane_at([10.3, 14.7], [6.3, 10.7], 10.0);
    let mark = |z: f64, inside: bool| Action::MarkPlace { place: crs([12.5, 8.5, z]), inside };
    let off = Action::SwitchPlane { plane: tower(), on: false };
    let lambda = |lambda| Action::SetParameters { lambda: Some(lambda), minimum_feature: Some(0.2) };
    let steps = [
        vec![],
        vec![mark(8.0, false)],
        vec![mark(8.0, false), off.clone()],
        vec![off.clone()],
        vec![off, lambda(0.3)],
        vec![lambda(0.3)],
        vec![],
        vec![Action::SetFloor { height: ORIGIN[2] + 1.0 }],
        vec![],
    ];
    let memory = Memory::default();
    for actions in steps {
        let site = with(actions);
        let (again, told) = reconstruct_again(&site, &Parameters::default(), &HeightField, &memory);
        let (once, steps) = reconstruct_in_steps(&site, &Parameters::default(), &HeightField);
        assert_eq!(bytes(&again), bytes(&once));
        let cut = |steps: &crate::reconstruct::Steps| steps.cut.as_ref().map(|cut| cut.inside.clone());
        assert_eq!((cut(&told), &told.found, &told.detected), (cut(&steps), &steps.found, &steps.detected));
    }
}

#[test]
fn an_equation_is_the_same_plane_in_both_frames() {
    let frame = Frame { origin: ORIGIN, metres_per_unit: [0.3048, 0.3048, 1.0] };
    let own = Plane::through(&Point3::new(3.0, -4.0, 5.0), Unit::new_normalize(Vector3::new(0.2, 0.3, 0.9)));
    let [a, b, c, d] = equation(&frame, &own);
    let [x, y, z] = frame.to_crs(&Point3::new(3.0, -4.0, 5.0));
    assert!((a * x + b * y + c * z + d).abs() < 1e-6);
    let back = plane(&frame, [a, b, c, d]).unwrap();
    assert!(
        (back.offset - own.offset).abs() < 1e-6 && (back.normal.into_inner() - own.normal.into_inner()).norm() < 1e-9
    );
}
