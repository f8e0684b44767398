//! Fields tried on real scans: reconstructed from a share of the points, judged by the rest.
//!
//! ```text
//! Site ─► split ─┬─► the input, thinned if wanted ─► per field: reconstruct ─┐
//!                └─► the points held out ───────────────────────────► judge ─┴─► HeldOutFigures
//! ```
//!
//! There is no truth about a real building, but there are points that the method has not seen. They tell what is missing,
//! what is in excess and what is roofed ground (see [`completeness`](crate::completeness)), and how far the roofs are off.

mod figures;
mod split;

use rayon::prelude::*;
use serde::Serialize;

use super::Contender;
use crate::building::{Building, Reason};
use crate::completeness::{Extents, Judge, Scan, tops};
use crate::evaluate::DistanceSummary;
use crate::reconstruct::{Parameters, reconstruct};
use crate::report::{Scope, Stopwatch};
use crate::site::Site;
use crate::solid::Solid;

pub use figures::{Confident, HeldOutFigures};
pub use split::{Holding, Split};

/// Sites with fewer building points are left out: half of them is no roof.
pub const FEWEST_POINTS: usize = 50;

/// A trial of fields on real scans.
#[derive(Debug, Clone)]
pub struct HeldOutTrial {
    /// The fields; an oracle, which knows the truth about virtual scans, is none of them.
    pub contenders: Vec<Contender>,
    /// Which points are held out.
    pub holding: Holding,
    /// Parameters of the reconstruction, and what the judge calls a fault.
    pub parameters: Parameters,
}

/// What a field came to.
#[derive(Debug, Clone, Serialize)]
pub struct HeldOutField {
    /// The field.
    pub field: String,
    /// Over all buildings.
    pub figures: HeldOutFigures,
    /// Building by building, in the order of the sites.
    pub buildings: Vec<HeldOutFindings>,
}

/// What a field came to on one building.
#[derive(Debug, Clone, Serialize)]
pub struct HeldOutFindings {
    /// The building.
    pub id: String,
    /// Points that it was reconstructed from.
    pub points: usize,
    /// Points that it was judged by.
    pub held_out: usize,
    /// What is missing, in excess and roofed ground, by the points held out.
    #[serde(flatten)]
    pub extents: Extents,
    /// Height of the points held out over the roof at their place (the one nearest in z); `None` where no point has a roof.
    pub vertical: Option<DistanceSummary>,
    /// Faces of the LoD 2.2 model; `None` without one.
    pub faces: Option<usize>,
    /// Why there is none.
    pub failure: Option<Reason>,
    /// How sure the field is of it, 0 to 1.
    pub confidence: Option<f64>,
    /// Processor time of the reconstruction in milliseconds; where the system tells.
    pub cpu_ms: Option<f64>,
}

impl HeldOutTrial {
    /// Tries all fields on these sites, on the rayon pool that it is called in; `progress` is called for every building.
    /// Sites with fewer than [`FEWEST_POINTS`] points, or without a footprint, are left out.
    pub fn run(&self, sites: &[Site], progress: &(dyn Fn() + Sync)) -> Vec<HeldOutField> {
        let usable = sites.par_iter().filter(|site| site.points.len() >= FEWEST_POINTS && site.footprint.is_some());
        let tried: Vec<Vec<(HeldOutFindings, Vec<f32>)>> = usable
            .map(|site| {
                let split = Split::new(site, &self.holding);
                let tried = self.contenders.iter().filter_map(|contender| self.building(&split, contender)).collect();
                progress();
                tried
            })
            .collect();
        let mut fields: Vec<(Vec<HeldOutFindings>, Vec<f32>)> = vec![Default::default(); self.contenders.len()];
        for building in tried {
            for ((findings, distances), (found, measured)) in fields.iter_mut().zip(building) {
                findings.push(found);
                distances.extend(measured);
            }
        }
        let named = self.contenders.iter().zip(fields);
        named
            .map(|(contender, (buildings, distances))| HeldOutField {
                field: contender.name.clone(),
                figures: HeldOutFigures::of(&buildings, distances),
                buildings,
            })
            .collect()
    }

    /// One building by one field, with the vertical distances; `None` for an oracle.
    fn building(&self, split: &Split, contender: &Contender) -> Option<(HeldOutFindings, Vec<f32>)> {
        let field = contender.field.as_deref()?;
        let watch = Stopwatch::start(Scope::Thread);
        let building = reconstruct(&split.input, &self.parameters, field);
        let cpu_ms = watch.cpu().map(|time| time.as_secs_f64() * 1e3);
        let tops = tops(finest(&building));
        let scan = Scan { points: &split.points, ground_points: &split.ground_points, ..Scan::of(&split.input) };
        let found = Judge::new(&scan, &self.parameters.completeness).judge(&tops);
        let over = split.points.iter().filter_map(|p| Some((p.z - tops.nearest_height(p.x, p.y, p.z)?) as f32));
        let distances: Vec<f32> = over.collect();
        let faces: usize = building.model.lod22().map(|solid| solid.faces.len()).sum();
        let findings = HeldOutFindings {
            points: split.input.points.len(),
            held_out: split.points.len(),
            extents: Extents::from(&found),
            vertical: DistanceSummary::of(distances.iter().copied()),
            faces: (faces > 0).then_some(faces),
            failure: building.outcome.reason().map(|(reason, _)| reason),
            confidence: building.measures.confidence,
            cpu_ms,
            id: building.id,
        };
        Some((findings, distances))
    }
}

/// The solids that a reader of the model looks at: LoD 2.2 where there is one, else the blocks.
fn finest(building: &Building) -> impl Iterator<Item = &Solid> {
    building.model.parts.iter().filter_map(|part| part.lod22.as_ref().or(part.lod12.as_ref()))
}

#[cfg(test)]
mod tests;
