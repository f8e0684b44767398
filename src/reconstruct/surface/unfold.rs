//! Flattens faces that the rounding of their vertices folded: slivers of a face a fraction of a millimetre high, whose apex
//! rounding moved off the plane by as much.
//!
//! They are no part of the shape, but a validator that does not know the grid calls them folds (204).

use crate::solid::Solid;
use crate::validate::polygon::{self, Turn};
use crate::validate::{Tolerances, ring};

/// No triangle of a face turns from its plane by more than this, degrees: well below what validators allow.
const MOST: f64 = 15.0;

/// How many steps along each axis a vertex may be moved.
const FAR: i64 = 3;

/// Vertices no farther apart than this are one to validators, metres, with a hair for the comparison.
const APART: f64 = 0.001_01;

/// So many vertices of faces are looked at for a solid, all trials together, before the rest is left as it is: a second's
/// work. A roof of thousands of vertices would take hours.
const MOST_WORK: usize = 1_000_000;

/// Moves vertices by a few grid steps where that makes a fold flat and breaks nothing else. What cannot be flattened so is
/// left to the check before writing.
pub(super) fn unfold(solid: &mut Solid) {
    let mut work = MOST_WORK;
    // Every move flattens a face for good or makes the worst one flatter.
    for _ in 0..solid.faces.len() {
        let folded = solid.faces.iter().filter_map(|face| polygon::steepest(solid, face, false));
        let Some(worst) = folded.filter(|turn| turn.angle > MOST).max_by(|a, b| a.angle.total_cmp(&b.angle)) else {
            return;
        };
        let Some((vertex, place)) = best_move(solid, &worst, &mut work) else { return };
        solid.vertices[vertex as usize] = place;
    }
}

/// The move of a corner of a triangle that leaves the faces around flattest, if they are flatter than the triangle; the
/// shortest of equal ones. None where that is more than the `work` that is left.
fn best_move(solid: &Solid, worst: &Turn, work: &mut usize) -> Option<(u32, [i64; 3])> {
    let mut trial = solid.clone();
    let mut best: Option<(f64, i64, u32, [i64; 3])> = None;
    for vertex in worst.triangle {
        let around: Vec<usize> =
            (0..solid.faces.len()).filter(|&f| solid.faces[f].rings.iter().flatten().any(|&v| v == vertex)).collect();
        let size: usize = around.iter().flat_map(|&f| &solid.faces[f].rings).map(Vec::len).sum();
        *work = work.checked_sub(size * moves().count())?;
        let from = solid.vertices[vertex as usize];
        for by in moves() {
            let place: [i64; 3] = std::array::from_fn(|i| from[i] + by[i]);
            let length = by.iter().map(|b| b * b).sum();
            trial.vertices[vertex as usize] = place;
            if let Some(angle) = flatness(&trial, vertex, &around).filter(|angle| *angle < worst.angle)
                && best.is_none_or(|(a, l, ..)| (angle.max(MOST), length) < (a.max(MOST), l))
            {
                best = Some((angle, length, vertex, place));
            }
        }
        trial.vertices[vertex as usize] = from;
    }
    best.map(|(.., vertex, place)| (vertex, place))
}

fn moves() -> impl Iterator<Item = [i64; 3]> {
    let range = || -FAR..=FAR;
    range().flat_map(move |x| range().flat_map(move |y| range().map(move |z| [x, y, z]))).filter(|by| *by != [0; 3])
}

/// The largest angle of the triangles of the faces around a vertex, degrees; `None` if a face is faulty otherwise than by a
/// fold, or the vertex stands on another.
fn flatness(solid: &Solid, vertex: u32, around: &[usize]) -> Option<f64> {
    let at = solid.point(vertex);
    let alone = |v: u32| v == vertex || (solid.point(v) - at).norm() > APART;
    if !(0..solid.vertices.len() as u32).all(alone) {
        return None;
    }
    let tolerances = Tolerances { normals: 180.0, ..Tolerances::written() };
    let mut largest = 0.0f64;
    for &f in around {
        let (face, id) = (&solid.faces[f], f as u32);
        if !ring::check(solid, id, face, &tolerances).is_empty()
            || !polygon::check(solid, id, face, &tolerances).is_empty()
        {
            return None;
        }
        largest = largest.max(polygon::steepest(solid, face, false).map_or(0.0, |turn| turn.angle));
    }
    Some(largest)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use proptest::prelude::*;

    use super::*;
    use crate::site::Frame;
    use crate::solid::Face;
    use crate::source::cityjson;
    use crate::validate::check;

    /// A block on a grid of 0.1 mm with a notch whose tip ends `neck` steps before the opposite wall; above, the tip is `high`
    /// steps too high.
    fn notched(neck: i64, high: i64) -> Solid {
        let plan = [[0, 0], [40, 0], [60, 0], [100, 0], [100, 80], [0, 80]].map(|p| p.map(|c| c * 1_000));
        let at = |z: i64| plan.into_iter().chain([[50_000, 80_000 - neck]]).map(move |[x, y]| [x, y, z]);
        let mut vertices: Vec<[i64; 3]> = at(0).chain(at(30_000)).collect();
        vertices[13][2] += high;
        let around = [0, 1, 6, 2, 3, 4, 5];
        let wall = |i: usize| [around[i], around[(i + 1) % 7], around[(i + 1) % 7] + 7, around[i] + 7].to_vec();
        let mut rings: Vec<Vec<u32>> = (0..7).map(wall).collect();
        rings.push(around.iter().rev().copied().collect());
        rings.push(around.iter().map(|v| v + 7).collect());
        let faces = rings.into_iter().map(|ring| Face { rings: vec![ring], surface: 0 }).collect();
        Solid { step: [1e-4; 3], vertices, faces, surfaces: Vec::new() }
    }

    #[test]
    fn a_fold_of_a_step_is_flattened() {
        let mut folded = notched(1, 1);
        let found: Vec<u16> = check(&folded, &Tolerances::written()).iter().map(|fault| fault.code).collect();
        assert_eq!(found, [204]);
        unfold(&mut folded);
        assert_eq!(check(&folded, &Tolerances::written()), []);
        // What is flat stays.
        let flat = notched(1, 0);
        let mut same = flat.clone();
        unfold(&mut same);
        assert_eq!(flat, same);
    }

    /// Solids that gable wrote with fine settings before it flattened them, each with a fold.
    #[test]
    fn folds_that_were_written_are_flattened() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/reported");
        let names = [
            "validator/204-gable-output-bag-020.city.json",
            "validator/204-gable-output-bag-025.city.json",
            "20-normals-204.city.jsonl",
        ];
        for name in names {
            let path = folder.join(name);
            if !path.exists() {
                println!("skipped: {name} not found");
                continue;
            }
            let model = cityjson::read(&path).unwrap();
            let frame = Frame { origin: model.transform.unwrap().translate, metres_per_unit: [1.0; 3] };
            let geometries = model.objects.iter().flat_map(|object| &object.geometries);
            let solids = geometries.filter(|geometry| geometry.kind == cityjson::GeometryKind::Solid);
            let mut folds = 0;
            for mut solid in solids.map(|geometry| model.solid(geometry, &frame).unwrap()) {
                let codes: Vec<u16> = check(&solid, &Tolerances::written()).iter().map(|fault| fault.code).collect();
                assert!(codes.iter().all(|code| *code == 204), "{name}: {codes:?}");
                folds += codes.len();
                unfold(&mut solid);
                assert_eq!(check(&solid, &Tolerances::written()), [], "{name}");
            }
            assert!(folds > 0, "{name}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(100))]

        #[test]
        fn no_fold_is_left_and_nothing_moves_far(neck in 1..20i64, high in -6..=6i64) {
            let folded = notched(neck, high);
            let mut flat = folded.clone();
            unfold(&mut flat);
            prop_assert_eq!(check(&flat, &Tolerances::written()), []);
            for (a, b) in folded.vertices.iter().zip(&flat.vertices) {
                prop_assert!((0..3).all(|i| (a[i] - b[i]).abs() <= 2 * FAR));
            }
        }
    }
}
