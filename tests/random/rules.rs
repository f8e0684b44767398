//! The rules that every building keeps.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::Duration;

use gable::building::{Building, Outcome, Reason, Setback};
use gable::reconstruct::occupancy::Occupancy;
use gable::reconstruct::{Parameters, reconstruct};
use gable::report::{Scope, Stopwatch};
use gable::site::Site;
use gable::solid::Solid;

use gable::validate::{Tolerances, check};

use super::{overlap, plan};

/// The most processor time that a building of the harness may take.
const LONGEST: Duration = Duration::from_secs(2);
/// The most that a model may rise above the highest point, metres; a millimetre for the grid.
const MOST_ABOVE_POINTS: f64 = 0.501;
/// The most that a model of LoD 2.2 may stand outside its footprint, metres: slits narrower than 3 mm are closed, and
/// vertices nearer than 1 mm are welded.
const MOST_OUTSIDE_LOD22: f64 = 0.003;
/// The same of LoD 1.2, whose footprint loses the tip of a corner of 1 cm where it touches itself.
const MOST_OUTSIDE_LOD12: f64 = 0.005;

/// The most that a model may fit its points worse than the block, metres; a millimetre for rounding.
const MOST_WORSE_THAN_BLOCK: f64 = 0.021;

/// What became of a building.
pub struct Judged {
    /// Its step of the ladder, and why it is not the first.
    pub outcome: String,
    /// The rules that it breaks.
    pub breaches: Vec<String>,
    /// Processor time.
    pub time: Duration,
}

/// Reconstructs a site under a field and looks for what must not be; twice if `again`, to see that the same comes out.
pub fn judge(site: &Site, field: &dyn Occupancy, again: bool) -> Judged {
    let watch = Stopwatch::start(Scope::Thread);
    let parameters = Parameters::default();
    let result = catch_unwind(AssertUnwindSafe(|| reconstruct(site, &parameters, field)));
    let time = watch.cpu().unwrap_or_default();
    let Ok(building) = result else {
        return Judged { outcome: "panic".into(), breaches: vec!["panic".into()], time };
    };
    let mut breaches = breaches(site, &building);
    if time > LONGEST {
        breaches.push(format!("took {} ms", time.as_millis()));
    }
    // One building alone is looked at by a person.
    if std::env::var_os("GABLE_RANDOM_COUNT").is_some_and(|count| count == "1") {
        println!("{:#?}\n{:#?}\n{:?}", building.outcome, building.measures, building.notes);
    }
    if again && reconstruct(site, &parameters, field).model.parts != building.model.parts {
        breaches.push("another model on the second run".into());
    }
    Judged { outcome: outcome(&building), breaches, time }
}

fn outcome(building: &Building) -> String {
    let setbacks = &building.measures.setbacks;
    let reasons: Vec<String> =
        setbacks.iter().map(|setback| format!("{:?} {}", setback.reason, of_kind(setback))).collect();
    let step = building.ladder_step().map_or("none".into(), |step| format!("{step:?}"));
    format!("{step:<13} {}", reasons.join(" > "))
}

/// The codes of a setback, or else its detail without the figures in it.
fn of_kind(setback: &Setback) -> String {
    if !setback.codes.is_empty() {
        return format!("{:?}", setback.codes);
    }
    let words = setback.detail.split(' ').filter(|word| !word.contains(|c: char| c.is_ascii_digit()));
    words.collect::<Vec<_>>().join(" ")
}

fn breaches(site: &Site, building: &Building) -> Vec<String> {
    let mut breaches = Vec::new();
    let model = &building.model;
    let highest = site.points.iter().map(|p| p.z).filter(|z| z.is_finite()).fold(f64::NEG_INFINITY, f64::max);
    let solids = model.lod12().map(|s| ("1.2", s)).chain(model.lod22().map(|s| ("2.2", s)));
    for (lod, solid) in solids {
        if let Some(fault) = check(solid, &Tolerances::default()).first() {
            breaches.push(format!("LoD {lod}: {fault}"));
        }
        if solid.volume() <= 0.0 {
            breaches.push(format!("LoD {lod}: volume {}", solid.volume()));
        }
        let top = top(solid);
        if top > highest + MOST_ABOVE_POINTS {
            breaches.push(format!("LoD {lod}: {:.3} m above the highest point", top - highest));
        }
        if solid.faces.iter().any(|face| face.surface as usize >= solid.surfaces.len()) {
            breaches.push(format!("LoD {lod}: a face without a surface"));
        }
    }
    for (lod, solids) in [("1.2", model.lod12().collect::<Vec<_>>()), ("2.2", model.lod22().collect::<Vec<_>>())] {
        for (i, a) in solids.iter().enumerate() {
            for b in &solids[i + 1..] {
                if overlap::overlap(a, b) {
                    breaches.push(format!("LoD {lod}: parts overlap"));
                }
            }
        }
    }
    if let Some(footprint) = &site.footprint {
        for (lod, outside, most) in [
            ("1.2", plan::outside(model.lod12(), footprint), MOST_OUTSIDE_LOD12),
            ("2.2", plan::outside(model.lod22(), footprint), MOST_OUTSIDE_LOD22),
        ] {
            if outside > most {
                breaches.push(format!("LoD {lod}: {outside:.4} m outside the footprint"));
            }
        }
    }
    let measures = &building.measures;
    if let (Some(rmse), Some(block)) = (measures.rmse_lod22, measures.rmse_lod12)
        && rmse > block + MOST_WORSE_THAN_BLOCK
    {
        breaches.push(format!("LoD 2.2 fits its points to {rmse:.3} m, LoD 1.2 to {block:.3} m"));
    }
    let (solids, blocks) = (model.lod22().count(), model.lod12().count());
    let explained = match &building.outcome {
        Outcome::Lod22 => solids > 0 && building.ladder_step().is_some(),
        Outcome::Partial { reason, detail } => {
            solids > 0 && site.covered.is_some() && *reason == Reason::Incomplete && !detail.is_empty()
        }
        Outcome::Lod12 { reason, detail } => {
            solids == 0 && blocks > 0 && *reason != Reason::Internal && !detail.is_empty()
        }
        Outcome::FootprintOnly { reason, detail } => {
            solids + blocks == 0 && *reason != Reason::Internal && !detail.is_empty()
        }
        Outcome::Rejected { .. } => false,
    };
    if !explained {
        breaches.push(format!("{solids} + {blocks} solids and {:?}", building.outcome));
    }
    breaches
}

fn top(solid: &Solid) -> f64 {
    (0..solid.vertices.len() as u32).map(|v| solid.point(v).z).fold(f64::NEG_INFINITY, f64::max)
}
