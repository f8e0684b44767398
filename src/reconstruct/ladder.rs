//! The ladder: what is tried when the method comes to nothing (LoD 2.2, LoD 2.2 with coarser tolerances, LoD 1.2, the
//! footprint), and the rule that no roof rises above the evidence.
//!
//! Coarser tolerances help because what fails is almost always a feature near their size: two planes that nearly
//! coincide, a jog of a few centimetres, a roof of a dozen points. Then the coarser model lacks that feature, but stands.

use std::slice::from_ref;

use nalgebra::Point3;

use super::{Attempt, Failure, Parameters};
use crate::building::{LadderStep, Reason, Setback};
use crate::site::{Ground, GroundSource};
use crate::solid::Solid;
use crate::validate::composite;

/// No part of a model is higher than this above the highest point of its building, metres.
pub const MOST_ABOVE_POINTS: f64 = 0.5;

/// How many times as coarse the tolerances are on each step of LoD 2.2.
const SCALES: [f64; LadderStep::LOD22.len()] = [1.0, 2.0, 4.0];

/// Goes down the ladder until an attempt succeeds. Where none does, the first attempt is returned, which has seen most;
/// its failure is the reason for the fallback, and its codes are those of all attempts.
pub(super) fn descend(parameters: &Parameters, attempt: impl Fn(&Parameters) -> Attempt) -> Attempt {
    let mut now = attempt(parameters);
    let Err(first) = &now.result else { return now };
    let mut setbacks = vec![setback(LadderStep::Lod22, first.clone())];
    let steps = LadderStep::LOD22.into_iter().zip(SCALES).skip(1);
    for (step, scale) in steps.take_while(|_| is_a_matter_of_size(first.reason)) {
        let mut next = attempt(&coarser(parameters, scale));
        match next.result {
            Ok(_) => {
                next.measures.setbacks = setbacks;
                return next;
            }
            Err(failure) => setbacks.push(setback(step, failure)),
        }
    }
    let mut codes: Vec<u16> = setbacks.iter().flat_map(|setback| &setback.codes).copied().collect();
    codes.sort_unstable();
    codes.dedup();
    now.measures.faults_lod22 = codes;
    now.measures.setbacks = setbacks;
    now
}

fn setback(step: LadderStep, Failure { reason, detail, codes }: Failure) -> Setback {
    Setback { step, reason, detail, codes }
}

/// Whether coarser tolerances may help: they make neither points nor planes.
fn is_a_matter_of_size(reason: Reason) -> bool {
    matches!(
        reason,
        Reason::NothingInside
            | Reason::InvalidSolid
            | Reason::TooComplex
            | Reason::AboveEvidence
            | Reason::WorseThanBlock
    )
}

/// The parameters with every tolerance `scale` times as coarse; one that is almost 0 counts as half of its default, so
/// that it becomes coarser too.
fn coarser(parameters: &Parameters, scale: f64) -> Parameters {
    let default = Parameters::default();
    let scaled = |value: f64, default: f64| scale * value.max(default / 2.0);
    let mut coarser = parameters.clone();
    coarser.footprint_tolerance = scaled(parameters.footprint_tolerance, default.footprint_tolerance);
    coarser.step_height = scaled(parameters.step_height, default.step_height);
    coarser.step_length = scaled(parameters.step_length, default.step_length);
    coarser.surface.minimum_feature = scaled(parameters.surface.minimum_feature, default.surface.minimum_feature);
    let (given, default) = (&parameters.detection, &default.detection);
    coarser.detection.minimum_tolerance = scaled(given.minimum_tolerance, default.minimum_tolerance);
    coarser.detection.minimum_area = scaled(given.minimum_area, default.minimum_area);
    coarser.detection.merge_angle = scaled(given.merge_angle, default.merge_angle);
    coarser.detection.merge_tolerance = scaled(given.merge_tolerance, default.merge_tolerance);
    coarser.detection.regularise_angle = scaled(given.regularise_angle, default.regularise_angle);
    coarser.detection.regularise_tolerance = scaled(given.regularise_tolerance, default.regularise_tolerance);
    coarser
}

/// Refuses solids that rise more than [`MOST_ABOVE_POINTS`] above the highest point of the building.
pub(super) fn check_top(solids: &[Solid], points: &[Point3<f64>]) -> Result<(), Failure> {
    let highest = points.iter().map(|p| p.z).fold(f64::NEG_INFINITY, f64::max);
    let top = solids
        .iter()
        .flat_map(|solid| solid.vertices.iter().map(|v| v[2] as f64 * solid.step[2]))
        .fold(f64::NEG_INFINITY, f64::max);
    if top <= highest + MOST_ABOVE_POINTS {
        return Ok(());
    }
    let detail = format!("the model would rise {:.2} m above the highest point", top - highest);
    Err(Failure::new(Reason::AboveEvidence, detail))
}

/// Refuses a roof whose middle (local metres) is less than `minimum` above the ground: whatever it is, it is not modelled
/// as it stands.
pub(super) fn check_height(middle: Option<f64>, ground: f64, minimum: f64) -> Result<(), Failure> {
    match middle.map(|middle| middle - ground) {
        Some(height) if height < minimum => {
            let detail = format!("the middle of the roof is {height:.2} m above the ground, less than {minimum} m");
            Err(Failure::new(Reason::TooLow, detail))
        }
        _ => Ok(()),
    }
}

/// Refuses a roof whose lowest point (local metres) is less than `minimum` above a floor that was taken from the lower end
/// of its own points: no wall was scanned, and nothing says how high they are.
pub(super) fn check_eaves(lowest: Option<f64>, ground: &Ground, minimum: f64) -> Result<(), Failure> {
    if ground.source != GroundSource::BoundingBox {
        return Ok(());
    }
    match lowest.map(|lowest| lowest - ground.height) {
        Some(height) if height < minimum => {
            let detail = format!(
                "nothing tells of the floor: no ground, no neighbour, and of the building no point more than {minimum} m \
                 below its roof"
            );
            Err(Failure::new(Reason::TooLow, detail))
        }
        _ => Ok(()),
    }
}

/// Refuses solids that overlap at all (601): parts of a building may touch only. Their vertices are rounded to the grid one by
/// one, so that parts that touch along a slanted edge may overlap by a hair, and whoever reads the file without knowing
/// its grid finds that.
pub(super) fn check_parts(solids: &[Solid]) -> Result<(), Failure> {
    const EXACT: f64 = 0.0;
    for (i, one) in solids.iter().enumerate() {
        for other in &solids[i + 1..] {
            if let Some(found) = composite::check_parts(from_ref(one), from_ref(other), EXACT) {
                let [x, y, z] = found.at;
                let detail = format!("two parts would overlap by {:.4} m at ({x:.3}, {y:.3}, {z:.3})", found.depth);
                return Err(Failure { codes: vec![601], ..Failure::new(Reason::InvalidSolid, detail) });
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;

    use super::*;
    use crate::building::Measures;

    /// An attempt with this many primitives and this result.
    fn attempt(primitives: usize, result: Result<Vec<Solid>, Failure>) -> Attempt {
        Attempt {
            measures: Measures { primitives, ..Measures::default() },
            outline: None,
            result,
            roof_points: Vec::new(),
            strays: Vec::new(),
            fit: None,
            steps: None,
            overhanging: None,
            tally: super::super::edited::Tally::default(),
        }
    }

    fn invalid(codes: &[u16]) -> Failure {
        Failure { codes: codes.to_vec(), ..Failure::new(Reason::InvalidSolid, "bad") }
    }

    /// Goes down the ladder over these results; returns the footprint tolerances that were tried as well.
    fn descended(results: &[Result<Vec<Solid>, Failure>]) -> (Attempt, Vec<f64>) {
        let tried = RefCell::new(Vec::new());
        let last = descend(&Parameters::default(), |parameters| {
            tried.borrow_mut().push(parameters.footprint_tolerance);
            let at = tried.borrow().len() - 1;
            attempt(at, results[at].clone())
        });
        (last, tried.into_inner())
    }

    #[test]
    fn the_first_attempt_that_succeeds_ends_the_descent() {
        let (last, tried) = descended(&[Ok(vec![])]);
        assert_eq!((last.measures.setbacks.len(), tried), (0, vec![0.1]));

        let (last, tried) = descended(&[Err(invalid(&[203])), Ok(vec![])]);
        assert_eq!(tried, [0.1, 0.2]);
        assert!(last.result.is_ok() && last.measures.primitives == 1 && last.measures.faults_lod22.is_empty());
        let [setback] = &last.measures.setbacks[..] else { panic!("{:?}", last.measures.setbacks) };
        assert_eq!((setback.step, setback.codes.clone()), (LadderStep::Lod22, vec![203]));
    }

    #[test]
    fn where_all_fail_the_first_failure_stands_and_all_codes() {
        let (last, tried) = descended(&[
            Err(invalid(&[303])),
            Err(Failure::new(Reason::NothingInside, "x")),
            Err(invalid(&[203, 303])),
        ]);
        assert_eq!(tried, [0.1, 0.2, 0.4]);
        assert_eq!(last.result, Err(invalid(&[303])));
        assert_eq!((last.measures.primitives, &last.measures.faults_lod22[..]), (0, &[203, 303][..]));
        let steps: Vec<LadderStep> = last.measures.setbacks.iter().map(|setback| setback.step).collect();
        assert_eq!(steps, LadderStep::LOD22);
    }

    #[test]
    fn a_model_that_fits_worse_than_its_block_is_tried_with_coarser_tolerances() {
        let worse = || Err(Failure::new(Reason::WorseThanBlock, "1.68 m, 0.80 m"));
        let (last, tried) = descended(&[worse(), worse(), Ok(vec![])]);
        assert_eq!((last.result.is_ok(), last.measures.setbacks.len(), tried.len()), (true, 2, 3));
        let (last, tried) = descended(&[worse(), worse(), worse()]);
        assert_eq!((last.result, tried.len()), (worse(), 3));
        assert!(last.measures.setbacks.iter().all(|setback| setback.reason == Reason::WorseThanBlock));
    }

    #[test]
    fn what_has_no_points_is_not_tried_again() {
        let (last, tried) = descended(&[Err(Failure::new(Reason::NoPoints, "none"))]);
        assert_eq!((last.measures.setbacks.len(), tried.len()), (1, 1));
    }

    #[test]
    fn a_tolerance_of_nothing_becomes_coarser_too() {
        let mut parameters = Parameters { footprint_tolerance: 0.0, step_height: 0.5, ..Parameters::default() };
        parameters.surface.minimum_feature = 0.0;
        let twice = coarser(&parameters, 2.0);
        assert_eq!((twice.footprint_tolerance, twice.step_height, twice.surface.minimum_feature), (0.1, 1.0, 0.1));
        assert_eq!(coarser(&parameters, 4.0).surface.minimum_feature, 0.2);
    }

    #[test]
    fn a_top_above_the_points_is_refused() {
        let top = |z: i64| Solid { step: [1e-4; 3], vertices: vec![[0, 0, z]], faces: vec![], surfaces: vec![] };
        let points = [Point3::new(0.0, 0.0, 3.0), Point3::new(0.0, 0.0, 7.0)];
        assert_eq!(check_top(&[top(74_990)], &points), Ok(()));
        let failure = check_top(&[top(10), top(75_100)], &points).unwrap_err();
        assert_eq!(
            (failure.reason, &failure.detail[..]),
            (Reason::AboveEvidence, "the model would rise 0.51 m above the highest point")
        );
    }

    #[test]
    fn a_roof_on_the_ground_is_refused() {
        assert_eq!((check_height(Some(3.0), 2.0, 1.0), check_height(None, 2.0, 1.0)), (Ok(()), Ok(())));
        let failure = check_height(Some(2.5), 2.0, 1.0).unwrap_err();
        assert_eq!(failure.reason, Reason::TooLow);
        assert!(failure.detail.contains("0.50 m above the ground, less than 1 m"), "{}", failure.detail);
    }

    #[test]
    fn a_roof_that_is_all_there_is_does_not_stand_on_its_eaves() {
        let ground = |source| Ground { height: 2.0, spread: 0.0, source };
        let failure = check_eaves(Some(2.3), &ground(GroundSource::BoundingBox), 1.0).unwrap_err();
        assert_eq!(failure.reason, Reason::TooLow);
        assert_eq!(check_eaves(Some(5.0), &ground(GroundSource::BoundingBox), 1.0), Ok(()));
        assert_eq!(check_eaves(Some(2.3), &ground(GroundSource::LowestPoints), 1.0), Ok(()));
    }

    #[test]
    fn parts_may_touch_but_not_overlap() {
        let step = 1e-4;
        let part = |from: i64, to: i64| {
            let ring = vec![[from, 0], [to, 0], [to, 40_000], [from, 40_000]];
            crate::reconstruct::blocks::block(&vec![ring], 0, 30_000, [step; 3]).unwrap()
        };
        assert!(check_parts(&[part(0, 50_000), part(50_000, 90_000)]).is_ok());
        for overlap in [1, 1_000] {
            let refused = check_parts(&[part(0, 50_000), part(50_000 - overlap, 90_000)]).unwrap_err();
            assert_eq!((refused.reason, refused.codes), (Reason::InvalidSolid, vec![601]));
        }
    }
}
