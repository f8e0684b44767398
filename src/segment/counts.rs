//! What became of the points.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Points left out, by reason.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct DroppedPoints {
    /// Marked as withheld.
    pub withheld: u64,
    /// Marked as synthetic.
    pub synthetic: u64,
    /// Of the noise classes 7 and 18.
    pub noise: u64,
    /// With impossible coordinates.
    pub absurd: u64,
    /// Building points that name a building of which there is no footprint.
    pub unknown_building: u64,
    /// Building points that stand in the tiles more than once.
    pub duplicate: u64,
    /// Of buildings that hold far more points than their planes need.
    pub dense: u64,
    /// With `any`: in a footprint, but too low above the ground.
    pub low: u64,
    /// With `any`: in a footprint, but not on anything flat.
    pub vegetation: u64,
    /// A handful of building points high above everything around them.
    pub hovering: u64,
    /// At a footprint's edge and above everything in its middle: the neighbour's.
    pub beyond_party_wall: u64,
}

/// What became of the points of all tiles.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct PointCounts {
    /// Points read.
    pub read: u64,
    /// Points not read because no footprint is near their tile or octree node.
    pub passed_over: u64,
    /// Building points kept; one that lies in two footprints counts twice.
    pub kept: u64,
    /// Points read per class, those with absurd coordinates excepted.
    pub classes: BTreeMap<u8, u64>,
    /// Points left out.
    pub dropped: DroppedPoints,
}

impl PointCounts {
    /// Adds other counts.
    pub fn add(&mut self, other: &Self) {
        self.read += other.read;
        self.passed_over += other.passed_over;
        self.kept += other.kept;
        for (class, n) in &other.classes {
            *self.classes.entry(*class).or_default() += n;
        }
        let (a, b) = (&mut self.dropped, &other.dropped);
        a.withheld += b.withheld;
        a.synthetic += b.synthetic;
        a.noise += b.noise;
        a.absurd += b.absurd;
        a.unknown_building += b.unknown_building;
        a.duplicate += b.duplicate;
        a.dense += b.dense;
        a.low += b.low;
        a.vegetation += b.vegetation;
        a.hovering += b.hovering;
        a.beyond_party_wall += b.beyond_party_wall;
    }
}
