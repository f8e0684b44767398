//! Surface (paper, section 3.5): the facets between inside and outside cells, merged into polygons.
//!
//! [`extract`] turns labels into closed shells in five steps, each of which keeps what the one before it guarantees:
//!
//! 1. slivers between planes that nearly coincide, and cells that only make a feature below the minimum size, are
//!    relabelled (`features`);
//! 2. the inside falls into components that hang together through facets: each becomes a shell of its own, so parts
//!    may touch along edges and at vertices; where a component touches itself in that way, a wedge joins it (`wedge`) or
//!    cells are relabelled until its boundary is a 2-manifold (`repair`);
//! 3. the boundary facets, oriented from inside to outside by construction, are cut at every vertex on their edges, so
//!    that there are no T-junctions (`boundary`);
//! 4. coplanar facets are merged into polygons with holes and vertices that are no corner are dropped (`polygons`);
//! 5. the polygons are rounded to the output grid, what collapses there is taken out consistently (`quantise`), and what
//!    rounding folded is flattened (`unfold`).
//!
//! Steps 1 to 4 are exact. Step 5 cannot be: the shell check of [`validate`](crate::validate) has the last word.

mod boundary;
#[cfg(test)]
pub(crate) mod boxes;
mod collapse;
mod features;
mod incidence;
mod polygons;
mod quantise;
mod repair;
mod unfold;
mod wedge;

use serde::{Deserialize, Serialize};

use super::complex::{CellId, Complex, FacetId, OUTSIDE, PlaneId};
use super::labelling::fill_cavities;
use crate::solid::Solid;
use boundary::Boundary;
use repair::{Repair, repair};

/// Parameters of the surface extraction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SurfaceParameters {
    /// Spikes, slots and steps thinner than this (metres) are removed; no point farther than this from the labelled
    /// surface changes sides. Of a building whose points are noisier than this, what is thinner than their noise.
    pub minimum_feature: f64,
}

impl Default for SurfaceParameters {
    fn default() -> Self {
        Self { minimum_feature: 0.1 }
    }
}

/// A complex with a label for each cell, and what is needed to change labels sensibly.
#[derive(Debug, Clone, Copy)]
pub struct Labelled<'a> {
    /// The cells.
    pub complex: &'a Complex,
    /// Per cell, whether it is inside. A cell without a label is outside.
    pub inside: &'a [bool],
    /// Per cell, how much it is inside, 0 to 1; a cell that is missing counts as undecided.
    pub occupancy: &'a [f64],
    /// Volume of each cell, cubic metres.
    pub volumes: &'a [f64],
    /// Cells whose label must stay. May be empty. (A cavity is filled all the same.)
    pub fixed: &'a [Option<bool>],
}

/// One closed shell, not yet classified into semantic surfaces.
#[derive(Debug, Clone, PartialEq)]
pub struct Shell {
    /// The shell; [`Solid::surfaces`] is empty and the faces' `surface` is an index into [`Self::planes`].
    pub solid: Solid,
    /// The planes of the faces, each with whether the outside is on its positive side.
    pub planes: Vec<(PlaneId, bool)>,
}

/// What [`extract`] returns.
#[derive(Debug, Clone, PartialEq)]
pub struct Extraction {
    /// The shells, in the order of the lowest cell of their component. They touch at most along edges and at
    /// vertices.
    pub shells: Vec<Shell>,
    /// The labels that the shells bound, after all relabelling, but for the wedges.
    pub inside: Vec<bool>,
    /// How many slivers between planes that nearly coincide were relabelled.
    pub slivers: usize,
    /// How many cells were relabelled to remove small features.
    pub features: usize,
    /// How many cells were relabelled to make the shells manifold.
    pub repairs: usize,
    /// How many wedges were put where the inside touches itself along an upright edge.
    pub wedges: usize,
}

/// Why there is no surface.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SurfaceError {
    /// Every cell that could resolve a non-manifold edge or vertex is fixed.
    #[error("non-manifold at ({:.3}, {:.3}, {:.3}) and every cell around is fixed", at[0], at[1], at[2])]
    NonManifold {
        /// Where, metres in the local frame.
        at: [f64; 3],
    },
    /// The complex breaks its own contract.
    #[error("facet {facet} of the cell complex has a corner that is not on its edges' planes")]
    Inconsistent {
        /// The facet.
        facet: FacetId,
    },
}

impl SurfaceError {
    /// val3dity codes of the surface that there would have been.
    pub fn codes(&self) -> Vec<u16> {
        match self {
            Self::NonManifold { .. } => vec![303],
            Self::Inconsistent { .. } => Vec::new(),
        }
    }
}

/// The shells that bound the inside of a labelled complex, on a grid of `step` metres along x, y and z.
///
/// # Errors
/// [`SurfaceError::NonManifold`] where fixed labels forbid a 2-manifold.
pub fn extract(
    labelled: &Labelled,
    step: [f64; 3],
    parameters: &SurfaceParameters,
) -> Result<Extraction, SurfaceError> {
    let complex = labelled.complex;
    let mut inside = labelled.inside.to_vec();
    inside.resize(complex.cells.len(), false);
    let slivers = features::absorb_slivers(labelled, &mut inside);
    let features = features::remove(labelled, &mut inside, parameters.minimum_feature);

    let mut filled = inside.clone();
    fill_cavities(complex, &mut filled);
    if let Some(wedged) = wedge::wedged(labelled, &filled)? {
        let (shells, relabelled, mut repairs) = shells(&wedged.labelled(), wedged.inside.clone(), step)?;
        repairs += inside.iter().zip(&filled).filter(|(a, b)| a != b).count();
        // What there was before the wedges is told as it was, but for what was relabelled since.
        let kept = wedged.inside.iter().zip(&relabelled).zip(&mut filled);
        kept.for_each(|((before, after), label)| *label = if before == after { *label } else { *after });
        return Ok(Extraction { shells, inside: filled, slivers, features, repairs, wedges: wedged.wedges });
    }
    let (shells, inside, repairs) = shells(labelled, inside, step)?;
    Ok(Extraction { shells, inside, slivers, features, repairs, wedges: 0 })
}

/// The shells of the cells `inside`, after what was relabelled to make them manifold, and how many cells that were.
fn shells(
    labelled: &Labelled,
    mut inside: Vec<bool>,
    step: [f64; 3],
) -> Result<(Vec<Shell>, Vec<bool>, usize), SurfaceError> {
    let before = inside.clone();
    let boundaries = manifold(labelled, &mut inside)?;
    let repairs = before.iter().zip(&inside).filter(|(a, b)| a != b).count();
    let complex = labelled.complex;
    let mut shells = Vec::new();
    for boundary in &boundaries {
        shells.extend(quantise::quantise(complex, &polygons::merge(complex, boundary), step));
    }
    Ok((shells, inside, repairs))
}

/// Relabels cells until the boundary of each component is a 2-manifold. Every round but the last relabels a cell that
/// was not relabelled before, so there are at most as many rounds as cells.
fn manifold(labelled: &Labelled, inside: &mut [bool]) -> Result<Vec<Boundary>, SurfaceError> {
    let complex = labelled.complex;
    let mut relabelled = vec![0; inside.len()];
    let mut now = 0;
    loop {
        now += 1;
        fill_cavities(complex, inside);
        let components = Components::new(complex, inside);
        let mut boundaries = Vec::with_capacity(components.facets.len());
        let mut changed = false;
        let mut stuck = None;
        for (component, facets) in components.facets.iter().enumerate() {
            let member = |cell: CellId| components.of_cell[cell as usize] == component as u32;
            let boundary = Boundary::new(complex, facets, member)?;
            for &spot in &boundary.spots {
                match repair(labelled, inside, member, spot, (&mut relabelled, now)) {
                    Repair::Done | Repair::Stale => changed = true,
                    Repair::Impossible => stuck = stuck.or(Some(spot)),
                }
            }
            boundaries.push(boundary);
        }
        match stuck {
            _ if changed => {}
            None => return Ok(boundaries),
            Some(spot) => {
                let [a, b] = spot.ends().map(|v| complex.vertices[v as usize].position.coords);
                return Err(SurfaceError::NonManifold { at: ((a + b) / 2.0).into() });
            }
        }
    }
}

/// The inside in components that hang together through facets.
struct Components {
    /// Per cell, its component; `u32::MAX` outside.
    of_cell: Vec<u32>,
    /// Per component, the facets between it and what it does not hold, ascending.
    facets: Vec<Vec<FacetId>>,
}

impl Components {
    fn new(complex: &Complex, inside: &[bool]) -> Self {
        let mut of_cell = vec![u32::MAX; inside.len()];
        let mut count = 0;
        let mut pending = Vec::new();
        for seed in 0..inside.len() {
            if !inside[seed] || of_cell[seed] != u32::MAX {
                continue;
            }
            of_cell[seed] = count;
            pending.push(seed);
            while let Some(cell) = pending.pop() {
                for &facet in &complex.cells[cell].facets {
                    for other in complex.facets[facet as usize].cells {
                        if other != OUTSIDE && inside[other as usize] && of_cell[other as usize] == u32::MAX {
                            of_cell[other as usize] = count;
                            pending.push(other as usize);
                        }
                    }
                }
            }
            count += 1;
        }
        let mut facets = vec![Vec::new(); count as usize];
        for (i, facet) in complex.facets.iter().enumerate() {
            let [a, b] = facet.cells.map(|c| if c == OUTSIDE { u32::MAX } else { of_cell[c as usize] });
            // Two components never share a facet, so at most one of the two is a component.
            if a != b {
                facets[a.min(b) as usize].push(i as FacetId);
            }
        }
        Self { of_cell, facets }
    }
}

#[cfg(test)]
mod tests;
