//! A building cut into cells, before anything is decided about them.

use std::borrow::Cow;

use nalgebra::Point3;

use super::complex::Complex;
use super::{Detected, Failure, Hypotheses, Parameters, Partition};
use crate::building::Reason;
use crate::geometry::seed_of;
use crate::site::Site;

/// A site, the planes that were found in it and the cells that they cut: all that an
/// [`Occupancy`](super::occupancy::Occupancy) may look at.
#[derive(Debug)]
pub struct Partitioned<'a> {
    /// The building's points, footprint and ground.
    pub site: &'a Site,
    /// The planes, and the evidence about the roof.
    pub hypotheses: Hypotheses,
    /// The cells.
    pub complex: Complex,
    /// Volume of each cell, cubic metres.
    pub volumes: Vec<f64>,
    /// Cells whose label is known before the field is asked: those outside the footprint are outside.
    pub fixed: Vec<Option<bool>>,
    /// Cells that a person has marked as inside or outside, which goes before all else. May be empty.
    pub marked: Vec<Option<bool>>,
    /// The number of its cells in a [`Memory`](super::Memory), if they are kept.
    pub(super) number: Option<u64>,
}

impl<'a> Partitioned<'a> {
    /// Finds the planes of a site, whose coordinates must be finite, and cuts its box (paper, sections 3.1 and 3.2).
    ///
    /// # Errors
    /// Fails where there is no point, no roof above the ground, or the complex would be larger than
    /// [`MAX_CELLS`](super::complex::MAX_CELLS).
    pub fn new(site: &'a Site, parameters: &Parameters) -> Result<Self, Failure> {
        Self::with(site, &Detected::new(site, parameters)?, parameters)
    }

    /// Cuts the box of a site by planes that were found before.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with(site: &'a Site, detected: &Detected, parameters: &Parameters) -> Result<Self, Failure> {
        let hypotheses = Hypotheses::new(site, detected, parameters)?;
        let complex = match parameters.partition {
            Partition::Adaptive => Complex::adaptive(&hypotheses.primitives, &hypotheses.bounds),
            Partition::Exhaustive => Complex::exhaustive(&hypotheses.primitives, &hypotheses.bounds),
        }
        .map_err(|error| Failure::new(Reason::TooComplex, error.to_string()))?;
        let known = |cell| {
            let (volume, centroid) = complex.cell_moments(cell);
            (volume, (!hypotheses.covers(&centroid.xy())).then_some(false))
        };
        let (volumes, fixed) = (0..complex.cells.len() as u32).map(known).unzip();
        Ok(Self { site, hypotheses, complex, volumes, fixed, marked: Vec::new(), number: None })
    }

    /// The seed of everything random about the building.
    pub fn seed(&self) -> u64 {
        seed_of(&self.site.id)
    }

    /// Cells whose label is known whatever the field says: those that are fixed, and those that a person has marked.
    pub(super) fn decided(&self) -> Cow<'_, [Option<bool>]> {
        if self.marked.is_empty() {
            return Cow::Borrowed(&self.fixed);
        }
        let marks = self.marked.iter().chain(std::iter::repeat(&None));
        Cow::Owned(self.fixed.iter().zip(marks).map(|(fixed, mark)| mark.or(*fixed)).collect())
    }

    /// The highest places that bear witness to a roof: the building's points, and the corners of roofs that a person says are
    /// there.
    pub(super) fn evidence_of_roofs(&self) -> Cow<'_, [Point3<f64>]> {
        let asserted = &self.hypotheses.asserted;
        if asserted.is_empty() {
            return Cow::Borrowed(&self.site.points);
        }
        Cow::Owned([&self.site.points[..], asserted].concat())
    }

    /// The cells whose label is not known yet.
    pub fn free(&self) -> impl Iterator<Item = u32> + '_ {
        (0u32..).zip(&self.fixed).filter(|(_, fixed)| fixed.is_none()).map(|(cell, _)| cell)
    }
}
