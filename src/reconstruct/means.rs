//! What the method has at hand beside a site and its parameters: a field to ask, and what is told and kept on the way.

use std::sync::Arc;

use nalgebra::Point3;

use super::memory::{Extent, Memory};
use super::occupancy::{HeightField, Occupancy, OccupancyError};
use super::primitives::{self, Detection};
use super::{Detected, Failure, Parameters, Partitioned, Steps};
use crate::site::Site;

/// What is told of a building.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Telling {
    /// What came out.
    Result,
    /// The steps on the way, too.
    Steps,
}

/// What the method has at hand.
#[derive(Debug, Clone, Copy)]
pub(super) struct Means<'a> {
    /// The field that says how much a cell is inside.
    pub field: &'a dyn Occupancy,
    /// What is told.
    pub telling: Telling,
    /// What was done before, if that is kept.
    pub memory: Option<&'a Memory>,
}

impl Means<'_> {
    /// The vote, and nothing told or kept.
    pub fn plain() -> Self {
        Self { field: &HeightField, telling: Telling::Result, memory: None }
    }

    /// The same with the vote for a field.
    pub fn by_vote(self) -> Self {
        Self { field: &HeightField, ..self }
    }

    /// The same, and only the result is told.
    pub fn quietly(self) -> Self {
        Self { telling: Telling::Result, ..self }
    }

    /// The steps of an attempt, if they are to be told.
    pub fn begin(self, site: &Site, parameters: &Parameters) -> Option<Box<Steps>> {
        (self.telling == Telling::Steps).then(|| Box::new(Steps::begin(site, parameters, self)))
    }

    /// The planes of some points, refined.
    pub fn detect(self, points: &[Point3<f64>], parameters: &Parameters, seed: u64) -> Arc<Detection> {
        self.detection(Extent::Refined, points, parameters, seed)
    }

    /// The planes of some points as they are found at first.
    pub fn found_at_first(self, points: &[Point3<f64>], parameters: &Parameters, seed: u64) -> Arc<Detection> {
        self.detection(Extent::Found, points, parameters, seed)
    }

    fn detection(self, extent: Extent, points: &[Point3<f64>], parameters: &Parameters, seed: u64) -> Arc<Detection> {
        let detect = || match extent {
            Extent::Found => primitives::found_at_first(points, parameters, seed),
            Extent::Refined => primitives::detect(points, parameters, seed),
        };
        match self.memory {
            Some(memory) => memory.detection(extent, points, parameters, seed, detect),
            None => Arc::new(detect()),
        }
    }

    /// A site cut by planes that were found.
    ///
    /// # Errors
    /// As [`Partitioned::with`].
    pub fn partition<'s>(
        self,
        site: &'s Site,
        detected: &Detected,
        parameters: &Parameters,
    ) -> Result<Partitioned<'s>, Failure> {
        let cut = || Partitioned::with(site, detected, parameters);
        match self.memory {
            Some(memory) => memory.partition(site, detected, parameters, cut),
            None => cut(),
        }
    }

    /// How much the cells of a building are inside, by the field.
    ///
    /// # Errors
    /// As [`Occupancy::occupancy`].
    pub fn occupancy(self, building: &Partitioned) -> Result<Vec<f64>, OccupancyError> {
        let ask = || self.field.occupancy(building);
        match self.memory {
            Some(memory) => memory.answer(building, self.field.is_height_field(), ask),
            None => ask(),
        }
    }
}
