//! Rounds: a model is judged by the points that it was made from, and made again with new hypotheses where it leaves some
//! of them unexplained.

use std::collections::BTreeSet;

use super::decision::Decision;
use super::means::Means;
use super::{Detected, Failure, Parameters, Partitioned, Solution, as_block};
use crate::building::{Reason, Revision};
use crate::completeness::{Area, Completeness, Extents, Judge, Scan, tops};
use crate::geometry::Cover;
use crate::site::Site;

/// No building gets more rounds than this: what two rounds do not explain, a third hardly does.
const MOST: usize = 2;
/// Smaller areas that are missing or in excess get no hypothesis of their own, square metres: chimneys, shafts and the
/// clutter on flat roofs, which would cost more faces than they show.
const SMALLEST: f64 = 2.0;

/// Makes a model of the planes that were detected in a site, and again as long as that explains more of what was scanned.
/// The better of two models is the one with less missing and excess area; a model that cannot be made again stays as it
/// is.
///
/// Under a footprint the vote decides in all rounds, which costs little, and the field that was asked for has the last
/// word, about the best planes: where the model of the vote still leaves something missing or in excess, or something
/// hangs over, and unless its own leaves more. Without a footprint the vote knows the outline from the same points, and
/// the field decides throughout.
///
/// # Errors
/// Fails where neither makes solids of the first planes. What was measured before stands in `solution`.
pub(super) fn solve(
    site: &Site,
    mut detected: Detected,
    parameters: &Parameters,
    means: Means,
    solution: &mut Solution,
) -> Result<(), Failure> {
    let is_height_field = means.field.is_height_field();
    let asks_last = site.footprint.is_some() && !is_height_field;
    let vote = if is_height_field { means } else { means.by_vote() };
    let decide = |building: &Partitioned| {
        let vote = Decision::by_height_field(vote, building)
            .map_err(|error| Failure::new(Reason::NothingInside, error.to_string()))?;
        Ok(if is_height_field || asks_last { vote } else { Decision::new(means, building, vote) })
    };
    if let Some(steps) = &mut solution.steps {
        steps.detect(&detected);
    }
    solution.tally.merge(&detected.tally);
    let partitioned = means.partition(site, &detected, parameters);
    if partitioned.as_ref().is_err_and(|failure| failure.reason == Reason::TooComplex) {
        solution.measure_roofs(site, &detected.roofs);
    }
    let mut building = partitioned?;
    solution.measure(&building);
    as_block::check(&solution.measures, parameters)?;
    let mut decision = decide(&building)?;
    let judge = Judge::new(&Scan::of(site), &parameters.completeness);
    if let Err(mut failure) = solution.build(&building, &decision, parameters) {
        // What the vote makes no solid of, the field may.
        if asks_last {
            decision = Decision::new(means, &building, decision);
        }
        let mut is_mended = false;
        if asks_last && !decision.height_field {
            match solution.build(&building, &decision, parameters) {
                Ok(()) => is_mended = true,
                Err(second) => failure = second,
            }
        }
        if !is_mended {
            return follow_marks(&mut building, &decision, parameters, solution, &judge)?.map_or(
                Err(failure),
                |judged| {
                    solution.measures.completeness = Some(Extents::from(&judged));
                    Ok(())
                },
            );
        }
    }
    let mut model = tops(&solution.solids);
    let mut judged = judge.judge(&model);
    let before = faulty_area(&judged);
    let mut rounds = 0;
    for _ in 0..MOST {
        let parts = unexplained(&judged, &model, site, parameters);
        if parts.is_empty() {
            break;
        }
        let Some(revised) = detected.revised(site, &parts, parameters) else { break };
        let Ok(next_building) = means.partition(site, &revised, parameters) else { break };
        let mut next = solution.clone();
        if let Some(steps) = &mut next.steps {
            steps.detect(&revised);
        }
        next.measure(&next_building);
        let Ok(next_decision) = decide(&next_building) else { break };
        if next.build(&next_building, &next_decision, parameters).is_err() {
            break;
        }
        let next_model = tops(&next.solids);
        let next_judged = judge.judge(&next_model);
        if faulty_area(&next_judged) >= faulty_area(&judged) {
            break;
        }
        (detected, building, decision) = (revised, next_building, next_decision);
        (*solution, model, judged) = (next, next_model, next_judged);
        rounds += 1;
    }
    let is_in_question = building.hypotheses.shows_overhang || faulty_area(&judged) > 0.0;
    if asks_last && decision.height_field && is_in_question {
        (judged, decision) = ask(means, &building, decision, parameters, &judge, solution, judged);
    }
    // What a person has marked are cells of the model that was seen: they are no reason to make it anew.
    if let Some(marked) = follow_marks(&mut building, &decision, parameters, solution, &judge)? {
        judged = marked;
    }
    solution.measures.revision = (rounds > 0).then(|| Revision { rounds, before, after: faulty_area(&judged) });
    solution.measures.completeness = Some(Extents::from(&judged));
    Ok(())
}

/// Makes the model again with the cells that a person has marked; `None` where no edit marks any.
///
/// # Errors
/// Nothing valid can be made of it so.
fn follow_marks(
    building: &mut Partitioned,
    decision: &Decision,
    parameters: &Parameters,
    solution: &mut Solution,
    judge: &Judge,
) -> Result<Option<Completeness>, Failure> {
    building.mark(&mut solution.tally);
    if building.marked.iter().all(Option::is_none) {
        return Ok(None);
    }
    let fallback = solution.measures.field_fallback.take();
    solution.build(building, decision, parameters)?;
    if fallback.is_some() {
        solution.measures.field_fallback = fallback;
    }
    Ok(Some(judge.judge(&tops(&solution.solids))))
}

/// Lets a field decide about a building of which the vote has made the model of `solution`; the better of both stays.
/// Returns how it is `judged`, and who decided.
fn ask(
    means: Means,
    building: &Partitioned,
    vote: Decision,
    parameters: &Parameters,
    judge: &Judge,
    solution: &mut Solution,
    judged: Completeness,
) -> (Completeness, Decision) {
    let shows_overhang = building.hypotheses.shows_overhang;
    let voted = vote.clone();
    let decision = Decision::new(means, building, vote);
    if decision.fallback.is_some() {
        solution.measures.field_fallback = decision.fallback;
        return (judged, voted);
    }
    if decision.occupancy == voted.occupancy && !shows_overhang {
        return (judged, voted);
    }
    let mut asked = solution.clone();
    if let Err(failure) = asked.build(building, &decision, parameters) {
        solution.measures.field_fallback = Some(format!("what it says makes no solid: {}", failure.detail));
        return (judged, voted);
    }
    let asked_judged = judge.judge(&tops(&asked.solids));
    let [by_field, by_vote] = [&asked_judged, &judged].map(faulty_area);
    // The vote fills what hangs over; no small fault of a field that knows better is worth that.
    let allowed = if shows_overhang { SMALLEST } else { 0.0 };
    if by_field > by_vote + allowed {
        let why = format!("it leaves {by_field:.0} m² missing or in excess, and the vote {by_vote:.0} m²");
        solution.measures.field_fallback = Some(why);
        return (judged, voted);
    }
    *solution = asked;
    (asked_judged, decision)
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

#[cfg(test)]
mod tests {
    use geo::polygon;
    use nalgebra::Point3;

    use super::super::occupancy::HeightField;
    use super::super::reconstruct;
    use super::*;
    use crate::site::Frame;

    /// A flat roof at 6 m, 20 m by 16 m, with a part of 3.5 m by 3 m two to four metres above it whose points lie on no
    /// plane.
    fn cluttered() -> Site {
        let is_part = |x: f64, y: f64| (8.0..11.5).contains(&x) && (6.0..9.0).contains(&y);
        let grid = (0_u32..40 * 32).map(|i| (0.25 + 0.5 * f64::from(i % 40), 0.25 + 0.5 * f64::from(i / 40), i));
        let random = |i: u32| f64::from((i.wrapping_mul(2_654_435_761) >> 8) % 1000) / 1000.0;
        let height = |x, y, i| if is_part(x, y) { 8.0 + 2.0 * random(i) } else { 6.0 };
        let points = grid.map(|(x, y, i)| Point3::new(x, y, height(x, y, i))).collect();
        let footprint = polygon![(x: 0.0, y: 0.0), (x: 20.0, y: 0.0), (x: 20.0, y: 16.0), (x: 0.0, y: 16.0)];
        let frame = Frame { origin: [0.0; 3], metres_per_unit: [1.0; 3] };
        Site::new("cluttered", frame, points, 0.0).with_footprint(&geo::MultiPolygon(vec![footprint]))
    }

    #[test]
    fn a_part_that_bears_no_plane_is_found_in_a_second_round() {
        let building = reconstruct(&cluttered(), &Parameters::default(), &HeightField);
        let found = building.measures.completeness.unwrap();
        let Revision { rounds, before, after } = building.measures.revision.expect("made again");
        assert!((1..=2).contains(&rounds) && before >= 6.0 && after < before / 2.0, "{rounds} {before} {after}");
        assert!((found.missing.area + found.excess.area - after).abs() < 1e-9);
        // A roof that is explained at once is made once.
        let mut flat = cluttered();
        flat.points.iter_mut().for_each(|p| p.z = 6.0);
        assert_eq!(reconstruct(&flat, &Parameters::default(), &HeightField).measures.revision, None);
    }
}
