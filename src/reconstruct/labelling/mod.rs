//! Labelling (paper, section 3.4): a Markov random field over the cells, solved exactly by an s-t cut.
//!
//! The energy is `E(x) = D(x) + λ V(x)`: `D` asks every cell to follow its occupancy, `V` asks the surface to be
//! small. The paper divides `D` by the number of cells and `V` by the largest facet, which makes λ depend on how
//! finely the box happens to be cut; the [default](Energy::Normalised) weights cells by volume and facets by area,
//! both normalised to sum 1 over what is left to decide, so that λ is the same for a shed and for a hall.

mod cavities;
pub mod maxflow;

use serde::{Deserialize, Serialize};

use super::complex::{Complex, OUTSIDE};

pub use cavities::fill_cavities;

/// What hangs over pays so many times for its underside, as far as no points were seen on it: buildings stand on the
/// ground unless there is reason to think otherwise.
const UNDERCUT: f64 = 4.0;

/// Undersides on which no points were seen are this level at least, as the cosine of their angle to the horizontal: a roof
/// plane that goes on into the inside is none.
const LEVEL: f64 = 0.95;

/// Detail that is narrower than so many standard deviations of the noise was made by it.
const NARROWEST: f64 = 3.0;

/// How the two terms of the energy are weighted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Energy {
    /// Cells by volume, facets by area not supported by points, both normalised to sum 1; facets on the bounding box
    /// count, with an outside that is outside.
    #[default]
    Normalised,
    /// The paper's literal energy (section 3.4), for comparison: `D = 1/|C| Σ |x − occ|` and
    /// `V = 1/A Σ a [x_i ≠ x_j]` with `A` the largest facet; facets on the bounding box do not count.
    Paper,
}

/// Parameters of the labelling.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct LabellingParameters {
    /// How the two terms of the energy are weighted.
    pub energy: Energy,
    /// λ, the weight of the smoothness term, without unit; a value below 0 counts as 0. The two energies need
    /// different values: the paper uses 0.001 with its own. Where the points are noisy, the normalised energy takes more
    /// than this, as much as it needs for detail that the noise made to give way.
    pub lambda: f64,
    /// Power of the cell volume in the data weight of the normalised energy: 1 weighs cells by volume, 2/3 gives
    /// small cells more say. Between 0 and 1.
    pub volume_exponent: f64,
}

impl Default for LabellingParameters {
    /// With λ = 0.1 and cells of 2 m, a certain detail narrower than about 0.3 m gives way to the smoother surface.
    fn default() -> Self {
        Self { energy: Energy::Normalised, lambda: 0.1, volume_exponent: 1.0 }
    }
}

/// What is known about the cells and facets of a complex before the labelling.
///
/// A slice that is too short is as if it went on with the value that says nothing.
#[derive(Debug, Clone, Copy)]
pub struct Evidence<'a> {
    /// How much each cell is inside, 0 to 1; what is missing or not a number counts as 0.5.
    pub occupancy: &'a [f64],
    /// Volume of each cell, cubic metres.
    pub volumes: &'a [f64],
    /// Area of each facet, square metres.
    pub areas: &'a [f64],
    /// Share of each facet that lies under inliers of its plane, 0 to 1: that share of its area costs nothing in the
    /// normalised energy. May be empty.
    pub support: &'a [f64],
    /// Cells whose label is known: those below the ground or outside the footprint are outside. May be empty.
    pub fixed: &'a [Option<bool>],
    /// Those of them that a person has marked: there something may hang over whatever the evidence is. May be empty.
    pub marked: &'a [Option<bool>],
    /// Whether the evidence is a height field. It cannot know of overhangs then, and whatever lies under the inside is
    /// inside.
    pub height_field: bool,
    /// Standard deviation of the noise of the points, metres.
    pub noise: f64,
}

impl Evidence<'_> {
    fn occupancy(&self, cell: usize) -> f64 {
        self.occupancy.get(cell).copied().filter(|o| !o.is_nan()).unwrap_or(0.5).clamp(0.0, 1.0)
    }

    fn fixed(&self, cell: usize) -> Option<bool> {
        self.fixed.get(cell).copied().flatten()
    }

    /// Whether marks say that one of two cells is inside and what lies right below it is not.
    fn marks_overhang(&self, above: usize, below: usize) -> bool {
        let mark = |cell: usize| self.marked.get(cell).copied().flatten();
        let is_marked = mark(above) == Some(true) || mark(below) == Some(false);
        is_marked && self.fixed(below) == Some(false)
    }

    fn area(&self, facet: usize) -> f64 {
        positive(self.areas.get(facet).copied())
    }

    fn support(&self, facet: usize) -> f64 {
        positive(self.support.get(facet).copied()).min(1.0)
    }
}

/// The value if it is a positive number, else 0.
fn positive(value: Option<f64>) -> f64 {
    value.filter(|v| v.is_finite() && *v > 0.0).unwrap_or(0.0)
}

/// The energy in floating point: what a cell pays per label, what a facet pays where its cells differ.
struct Terms {
    /// Per cell: cost of being outside, cost of being inside; nothing for cells whose label is fixed.
    data: Vec<[f64; 2]>,
    /// Per facet.
    smoothness: Vec<f64>,
    /// λ as it was used.
    lambda: f64,
}

/// What labels cost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cost {
    /// λ as it was used: more than was asked for where the points are noisy.
    pub lambda: f64,
    /// How far the labels are from the occupancies (`D`), 0 to 1 in the normalised energy.
    pub data: f64,
    /// The size of the surface (`V`, without λ), in the normalised energy as a share of all facets that are to be decided,
    /// less what the evidence asks for.
    pub smoothness: f64,
}

/// What labels cost, without what hangs over pays beyond its size.
pub fn cost(complex: &Complex, evidence: &Evidence, parameters: &LabellingParameters, inside: &[bool]) -> Cost {
    let Terms { data, smoothness, lambda } = terms(complex, evidence, parameters);
    let is_inside = |cell: u32| cell != OUTSIDE && inside.get(cell as usize) == Some(&true);
    let free = (0u32..).zip(&data).filter(|(cell, _)| evidence.fixed(*cell as usize).is_none());
    let told = free.map(|(cell, &[outside, within])| if is_inside(cell) { within } else { outside }).sum();
    let border = complex.facets.iter().zip(&smoothness).filter(|(facet, _)| {
        let [a, b] = facet.cells.map(is_inside);
        a != b
    });
    let size: f64 = border.map(|(_, cost)| cost).sum();
    Cost { lambda, data: told, smoothness: if lambda > 0.0 { size / lambda } else { 0.0 } }
}

fn terms(complex: &Complex, evidence: &Evidence, parameters: &LabellingParameters) -> Terms {
    match parameters.energy {
        Energy::Normalised => normalised(complex, evidence, parameters),
        Energy::Paper => paper(complex, evidence, parameters),
    }
}

/// Labels every cell of the complex: true is inside.
///
/// The labelling minimises the energy of `parameters` exactly, under the fixed labels of `evidence`; among several
/// minima it is the one with the fewest inside cells, so that a cell about which nothing is known stays outside. In the
/// normalised energy what hangs over pays more for an underside on which no points were seen, and that must be level.
/// Afterwards [cavities are filled](fill_cavities).
pub fn label(complex: &Complex, evidence: &Evidence, parameters: &LabellingParameters) -> Vec<bool> {
    let terms = terms(complex, evidence, parameters);
    let total: f64 = terms.data.iter().flatten().chain(&terms.smoothness).sum();
    // 2⁵⁰ steps for the whole energy keep every sum far from overflow and every rounding far below what matters.
    let scale = if total > 0.0 { 2f64.powi(50) / total } else { 0.0 };
    let capacity = |value: f64| (value * scale).round() as i64;
    let forever = 1i64 << 60;
    let marked = 1i64 << 52;
    let is_marked = |cell: usize| evidence.marked.get(cell).is_some_and(Option::is_some);

    let mut network = maxflow::Network::new(complex.cells.len(), 2 * complex.facets.len());
    for (cell, &[outside, inside]) in terms.data.iter().enumerate() {
        match evidence.fixed(cell) {
            // No flow comes near this: every way between two fixed cells leads over a facet.
            // Marks may contradict one another through cells that are free: theirs is less, so that no sum overflows.
            Some(true) if is_marked(cell) => network.add_terminals(cell, marked, 0),
            Some(false) if is_marked(cell) => network.add_terminals(cell, 0, marked),
            Some(true) => network.add_terminals(cell, forever, 0),
            Some(false) => network.add_terminals(cell, 0, forever),
            None => network.add_terminals(cell, capacity(outside), capacity(inside)),
        }
    }
    for (facet, &cost) in complex.facets.iter().zip(&terms.smoothness) {
        match facet.cells {
            [OUTSIDE, OUTSIDE] => {}
            [OUTSIDE, cell] | [cell, OUTSIDE] => {
                if evidence.fixed(cell as usize).is_none() {
                    network.add_terminals(cell as usize, 0, capacity(cost));
                }
            }
            [a, b] => network.add_edge(a as usize, b as usize, capacity(cost)),
        }
    }
    for (index, (facet, &cost)) in complex.facets.iter().zip(&terms.smoothness).enumerate() {
        // Planes that are not vertical point up, so that the cell on the negative side is the lower one.
        let upward = complex.planes.get(facet.plane as usize).map_or(0.0, |plane| plane.to_plane().normal.z);
        if let ([below, above], true) = (facet.cells, upward > 0.0)
            && below != OUTSIDE
            && above != OUTSIDE
            && !evidence.marks_overhang(above as usize, below as usize)
        {
            let more = match parameters.energy {
                _ if evidence.height_field => forever,
                Energy::Normalised if upward < LEVEL && evidence.support(index) < 0.5 => forever,
                Energy::Normalised => capacity(cost * upward * (UNDERCUT - 1.0)),
                Energy::Paper => continue,
            };
            network.add_arc(above as usize, below as usize, more);
        }
    }
    let mut inside = network.cut().source_side;
    fill_cavities(complex, &mut inside);
    inside
}

fn normalised(complex: &Complex, evidence: &Evidence, parameters: &LabellingParameters) -> Terms {
    let exponent = parameters.volume_exponent.clamp(0.0, 1.0);
    let free = |cell: u32| cell != OUTSIDE && evidence.fixed(cell as usize).is_none();
    let weights: Vec<f64> = (0..complex.cells.len())
        .map(|cell| {
            let volume = positive(evidence.volumes.get(cell).copied());
            if evidence.fixed(cell).is_none() && volume > 0.0 { volume.powf(exponent) } else { 0.0 }
        })
        .collect();
    let total = weights.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    // Facets between two fixed cells decide nothing; were they counted, λ would depend on the padding of the box.
    let areas: Vec<f64> = complex
        .facets
        .iter()
        .enumerate()
        .map(|(i, facet)| if facet.cells.iter().any(|&c| free(c)) { evidence.area(i) } else { 0.0 })
        .collect();
    let area = areas.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    // A bar of width b that sticks out by t costs λ 4bt/area and is worth b²t/volume: narrower than 4λ volume/area, it
    // gives way.
    let volume: f64 = (0..complex.cells.len())
        .filter(|&cell| evidence.fixed(cell).is_none())
        .map(|cell| positive(evidence.volumes.get(cell).copied()))
        .sum();
    let against_noise = positive(Some(NARROWEST * evidence.noise * area / (4.0 * volume)));
    let lambda = positive(Some(parameters.lambda)).max(against_noise);
    Terms {
        data: weights
            .iter()
            .enumerate()
            .map(|(cell, w)| [w / total * evidence.occupancy(cell), w / total * (1.0 - evidence.occupancy(cell))])
            .collect(),
        smoothness: areas
            .iter()
            .enumerate()
            .map(|(facet, a)| lambda * a / area * (1.0 - evidence.support(facet)))
            .collect(),
        lambda,
    }
}

fn paper(complex: &Complex, evidence: &Evidence, parameters: &LabellingParameters) -> Terms {
    let count = complex.cells.len().max(1) as f64;
    let inner = |i: usize| complex.facets[i].cells.iter().all(|&c| c != OUTSIDE);
    let areas: Vec<f64> = (0..complex.facets.len()).map(|i| if inner(i) { evidence.area(i) } else { 0.0 }).collect();
    let largest = areas.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let lambda = positive(Some(parameters.lambda));
    Terms {
        data: (0..complex.cells.len())
            .map(|cell| match evidence.fixed(cell) {
                Some(_) => [0.0; 2],
                None => [evidence.occupancy(cell) / count, (1.0 - evidence.occupancy(cell)) / count],
            })
            .collect(),
        smoothness: areas.iter().map(|a| lambda * a / largest).collect(),
        lambda,
    }
}

#[cfg(test)]
mod tests;
