//! Terrain: triangles that look up, once each, with holes where they may be.

use serde_json::{Value, json};

use super::*;

/// Neither faults nor anything to be told.
const NOTHING: [Vec<u16>; 2] = [Vec::new(), Vec::new()];

/// The findings on a `TINRelief` of these triangles over a grid of five by five vertices, 10 m apart.
fn relief(triangles: &[[usize; 3]], heights: impl Fn(usize) -> i64) -> [Vec<u16>; 2] {
    let faces: Vec<Value> = triangles.iter().map(|triangle| json!([triangle])).collect();
    faults_of(&faces, heights)
}

fn faults_of(faces: &[Value], heights: impl Fn(usize) -> i64) -> [Vec<u16>; 2] {
    let file = boxed(0.001, |file| {
        let vertices: Vec<Value> = (0..25).map(|v| json!([v % 5 * 10_000, v / 5 * 10_000, heights(v)])).collect();
        file["vertices"] = vertices.into();
        file["CityObjects"] = json!({"t": {"type": "TINRelief", "geometry": [{
            "type": "CompositeSurface", "lod": "1", "boundaries": faces
        }]}});
    });
    findings(&file).map(|found| found.into_iter().map(|(code, _)| code).collect())
}

/// Two triangles for each of the sixteen squares but the ones in `holes`.
fn squares(holes: &[usize]) -> Vec<[usize; 3]> {
    let corner = |square: usize| square / 4 * 5 + square % 4;
    let all = (0..16).filter(|square| !holes.contains(square)).map(corner);
    all.flat_map(|v| [[v, v + 1, v + 6], [v, v + 6, v + 5]]).collect()
}

fn bumps(v: usize) -> i64 {
    (v * v % 7) as i64 * 900
}

#[test]
fn terrain_with_holes_is_sound() {
    for holes in [&[][..], &[5], &[5, 6, 9], &[0, 15]] {
        assert_eq!(relief(&squares(holes), bumps), NOTHING, "{holes:?}");
    }
}

#[test]
fn holes_that_touch_in_a_corner_leave_two_fans_there() {
    let [faults, _] = relief(&squares(&[5, 10]), bumps);
    assert_eq!(faults, [303]);
}

#[test]
fn a_triangle_that_is_there_twice_is_a_fault() {
    let mut twice = squares(&[]);
    twice.push(twice[12]);
    let [faults, _] = relief(&twice, bumps);
    assert!(faults.contains(&303) && faults.contains(&306), "{faults:?}");
}

#[test]
fn triangles_that_cross_are_a_fault() {
    // A triangle from corner to corner over the others, which rise through it.
    let mut crossing = squares(&[]);
    crossing.push([0, 4, 24]);
    let [faults, _] = relief(&crossing, |v| if v == 7 { 5000 } else { 0 });
    assert!(faults.contains(&306), "{faults:?}");
}

#[test]
fn terrain_that_looks_down_is_a_fault_and_one_of_quadrangles_is_told() {
    let down: Vec<[usize; 3]> = squares(&[5]).into_iter().map(|[a, b, c]| [a, c, b]).collect();
    let [faults, told] = relief(&down, bumps);
    assert_eq!((faults, told), (vec![809; down.len()], vec![]));
    let mut one = squares(&[]);
    one[0].swap(0, 1);
    let [faults, _] = relief(&one, bumps);
    assert!(faults.contains(&307) && faults.contains(&809), "{faults:?}");
    let [faults, told] = faults_of(&[json!([[0, 1, 6, 5]]), json!([[1, 2, 7, 6]])], |_| 0);
    assert_eq!((faults, told), (vec![], vec![810, 810]));
    // Upright is neither up nor down, as where two floors differ.
    let upright = relief(&[[0, 1, 6], [0, 6, 5], [1, 0, 2]], |v| if v == 2 { 3000 } else { 0 });
    assert_eq!(upright, NOTHING);
}
