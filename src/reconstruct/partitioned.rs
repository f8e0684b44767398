//! A building cut into cells, before anything is decided about them.

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
        Ok(Self { site, hypotheses, complex, volumes, fixed })
    }

    /// The seed of everything random about the building.
    pub fn seed(&self) -> u64 {
        seed_of(&self.site.id)
    }

    /// The cells whose label is not known yet.
    pub fn free(&self) -> impl Iterator<Item = u32> + '_ {
        (0u32..).zip(&self.fixed).filter(|(_, fixed)| fixed.is_none()).map(|(cell, _)| cell)
    }
}
