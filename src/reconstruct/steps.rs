//! What each step of the method made of one building: told on request, on the way to the model that came out.
//!
//! [`reconstruct_in_steps`](super::reconstruct_in_steps) returns it beside the building. It is a record of what happened and not
//! another way to do it: of the attempts and rounds of a building it holds those of the model that was kept.

use super::complex::Complex;
use super::decision::Decision;
use super::evidence;
use super::labelling::Cost;
use super::means::Means;
use super::primitives::Primitive;
use super::surface::Extraction;
use super::{Detected, Parameters, Partitioned};
use crate::geometry::{Aabb, seed_of};
use crate::site::Site;
use crate::solid::Solid;

/// The steps of the method, as far as it got: what stands after the step at which it failed is `None`.
#[derive(Debug, Clone, Default)]
pub struct Steps {
    /// What was made a model of: the points, to which all indices of points below refer, the floor, and the part of the
    /// footprint that stands.
    pub site: Option<Site>,
    /// The parameters of the attempt that was kept: on the coarser steps of the ladder its tolerances are coarser.
    pub parameters: Parameters,
    /// The planes as they were found, before any was merged or regularised. Largest first.
    pub found: Option<Vec<Primitive>>,
    /// The planes after refinement and regularisation, and those that a revision added.
    pub detected: Option<Detected>,
    /// The planes that cut the box, and the cells that they cut.
    pub partition: Option<Partitioning>,
    /// What was asked about the cells, and answered.
    pub field: Option<Asked>,
    /// What the minimum cut decided.
    pub cut: Option<Cut>,
    /// What became of the border between inside and outside.
    pub surface: Option<Surfaced>,
}

/// The planes that cut the box of a building, and its cells.
#[derive(Debug, Clone)]
pub struct Partitioning {
    /// The planes: detected roofs, then undersides, then walls.
    pub primitives: Vec<Primitive>,
    /// How many of the planes are roofs.
    pub roofs: usize,
    /// How many of the planes are undersides.
    pub undersides: usize,
    /// The box that they cut, local metres.
    pub bounds: Aabb,
    /// The cells.
    pub complex: Complex,
    /// Volume of each cell, cubic metres.
    pub volumes: Vec<f64>,
    /// Cells whose label was known before the field was asked: those beyond the footprint are outside.
    pub fixed: Vec<Option<bool>>,
}

/// What was answered about the cells.
#[derive(Debug, Clone)]
pub struct Asked {
    /// How much each cell is inside, 0 to 1.
    pub occupancy: Vec<f64>,
    /// Whether the answer is that of a height field, such as the vote, in which nothing hangs over.
    pub is_height_field: bool,
    /// Why the vote answered although another field was asked.
    pub fallback: Option<String>,
}

/// What the minimum cut decided.
#[derive(Debug, Clone)]
pub struct Cut {
    /// The label of each cell: whether it is inside.
    pub inside: Vec<bool>,
    /// What that costs.
    pub cost: Cost,
}

/// What became of the border between inside and outside.
#[derive(Debug, Clone)]
pub struct Surfaced {
    /// The labels that the surface bounds, after slivers and small features were removed and what touched itself was mended.
    pub inside: Vec<bool>,
    /// How many slivers between planes that nearly coincide were relabelled.
    pub slivers: usize,
    /// How many cells were relabelled to remove small features.
    pub features: usize,
    /// How many cells were relabelled to make the surface a manifold.
    pub repairs: usize,
    /// How many wedges were put where the inside touched itself along an upright edge.
    pub wedges: usize,
    /// The solids, with their semantic surfaces. A solid that was refused afterwards is here all the same.
    pub solids: Vec<Solid>,
}

impl Steps {
    /// The steps of an attempt at a site, of which nothing is done yet.
    pub(super) fn begin(site: &Site, parameters: &Parameters, means: Means) -> Self {
        let found = (!site.points.is_empty())
            .then(|| means.found_at_first(&site.points, parameters, seed_of(&site.id)).primitives.clone());
        Self { site: Some(site.clone()), parameters: parameters.clone(), found, ..Self::default() }
    }

    /// Notes the planes that were taken.
    pub(super) fn detect(&mut self, detected: &Detected) {
        self.detected = Some(detected.clone());
    }

    /// Notes the cells of a building. What was made of others is forgotten.
    pub(super) fn part(&mut self, building: &Partitioned) {
        let Partitioned { hypotheses, complex, volumes, fixed, .. } = building;
        self.partition = Some(Partitioning {
            primitives: hypotheses.primitives.clone(),
            roofs: hypotheses.roofs,
            undersides: hypotheses.undersides,
            bounds: hypotheses.bounds,
            complex: complex.clone(),
            volumes: volumes.clone(),
            fixed: fixed.clone(),
        });
        (self.field, self.cut, self.surface) = (None, None, None);
    }

    /// Notes what was answered about the cells, and what the cut made of it.
    pub(super) fn decide(&mut self, building: &Partitioned, decision: &Decision, inside: &[bool]) {
        let Decision { occupancy, height_field, fallback } = decision;
        let cost = evidence::cost(building, occupancy, *height_field, &self.parameters, inside);
        self.field =
            Some(Asked { occupancy: occupancy.clone(), is_height_field: *height_field, fallback: fallback.clone() });
        self.cut = Some(Cut { inside: inside.to_vec(), cost });
        self.surface = None;
    }

    /// Notes the surface; its solids come with [`Self::close`].
    pub(super) fn extract(&mut self, extraction: &Extraction) {
        let Extraction { inside, slivers, features, repairs, wedges, .. } = extraction;
        self.surface = Some(Surfaced {
            inside: inside.clone(),
            slivers: *slivers,
            features: *features,
            repairs: *repairs,
            wedges: *wedges,
            solids: Vec::new(),
        });
    }

    /// Notes a solid with its semantic surfaces.
    pub(super) fn close(&mut self, solid: &Solid) {
        if let Some(surface) = &mut self.surface {
            surface.solids.push(solid.clone());
        }
    }
}
