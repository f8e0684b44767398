//! Rounds: a model is judged by the points that it was made from, and made again with new hypotheses where it leaves some
//! of them unexplained.

use std::collections::BTreeSet;

use super::occupancy::Occupancy;
use super::{Detected, Parameters, Solution, solve};
use crate::completeness::{Area, Completeness, Extents, Judge, Scan, tops};
use crate::geometry::Cover;
use crate::site::Site;

/// No building gets more rounds than this: what two rounds do not explain, a third hardly does.
const MOST: usize = 2;
/// Smaller areas that are missing or in excess get no hypothesis of their own, square metres: chimneys, shafts and the
/// clutter on flat roofs, which would cost more faces than they show.
const SMALLEST: f64 = 2.0;

/// Makes the model of `solution` again as long as that explains more of what was scanned. The better of two models is the
/// one with less missing and excess area; a model that cannot be made again stays as it is.
pub(super) fn improve(
    site: &Site,
    detected: &Detected,
    parameters: &Parameters,
    field: &dyn Occupancy,
    solution: &mut Solution,
) {
    let judge = Judge::new(&Scan::of(site), &parameters.completeness);
    let mut model = tops(&solution.solids);
    let mut judged = judge.judge(&model);
    let mut detected = detected.clone();
    for _ in 0..MOST {
        let parts = unexplained(&judged, &model, site, parameters);
        if parts.is_empty() {
            break;
        }
        let Some(revised) = detected.revised(site, &parts, parameters) else { break };
        let mut next = solution.clone();
        if solve(site, &revised, parameters, field, &mut next).is_err() {
            break;
        }
        let next_model = tops(&next.solids);
        let next_judged = judge.judge(&next_model);
        if faulty_area(&next_judged) >= faulty_area(&judged) {
            break;
        }
        (detected, *solution, model, judged) = (revised, next, next_model, next_judged);
    }
    solution.measures.completeness = Some(Extents::from(&judged));
}

/// Missing and excess area together, square metres.
fn faulty_area(judged: &Completeness) -> f64 {
    judged.missing.iter().chain(&judged.excess).map(|area| area.area).sum()
}

/// For each area that is missing or in excess, the building points that show it and those beside it that the model misses
/// in the same way: areas end where cells are mixed or too near to the outline, parts of a roof do not.
fn unexplained(judged: &Completeness, model: &Cover, site: &Site, parameters: &Parameters) -> Vec<Vec<u32>> {
    let limits = &parameters.completeness;
    let missing = judged.missing.iter().map(|area| (area, 1.0));
    let areas: Vec<(&Area, f64)> = missing
        .chain(judged.excess.iter().map(|area| (area, -1.0)))
        .filter(|(area, _)| area.area >= SMALLEST)
        .collect();
    if areas.is_empty() {
        return Vec::new();
    }
    let floor = site.ground.height;
    let side = limits.cell.max(0.1);
    let cells: Vec<[i64; 2]> =
        site.points.iter().map(|p| [p.x, p.y].map(|value| (value / side).floor() as i64)).collect();
    let part = |(area, sign): (&Area, f64)| -> Vec<u32> {
        let beside = |[x, y]: &[i64; 2]| {
            let [x, y] = [*x, *y];
            (-1..=1).flat_map(move |i| (-1..=1).map(move |j| [x + i, y + j]))
        };
        let around: BTreeSet<[i64; 2]> = area.cells.iter().flat_map(beside).collect();
        let is_missed = |index: usize| {
            let point = &site.points[index];
            let over = point.z - model.highest(point.x, point.y).unwrap_or(floor).max(floor);
            sign * over > limits.height / 2.0
        };
        let indices = (0..site.points.len()).filter(|&i| around.contains(&cells[i]) && is_missed(i));
        indices.map(|i| i as u32).collect()
    };
    areas.into_iter().map(part).collect()
}
