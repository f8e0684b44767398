//! Large buildings in pieces: a network looks at each through a window of the size of the buildings that it was trained on.

use nalgebra::Point3;

use super::Inputs;
use crate::geometry::Aabb;

/// Up to this length and width, metres, a building is looked at as a whole: a raster of 32 pixels a side still shows its
/// gables. What is beyond no network has seen in its training.
const WHOLE: f64 = 120.0;
/// A window of a larger one has sides of about this length, metres …
const WINDOW: f64 = 50.0;
/// … and shows this much more on each side, metres, so that what it answers for is not at its rim.
const RIM: f64 = 5.0;

/// The windows through which a building is looked at, in rows from its corner.
#[derive(Debug, Clone)]
pub(in crate::reconstruct::occupancy) struct Windows<'a> {
    low: [f64; 2],
    side: [f64; 2],
    count: [usize; 2],
    inputs: Vec<Inputs<'a>>,
}

impl<'a> Windows<'a> {
    /// Those of a building: one, unless it is too large.
    pub fn new(whole: &Inputs<'a>) -> Self {
        let bounds = whole.building.hypotheses.bounds;
        let extent = bounds.extent();
        let low = [bounds.min[0], bounds.min[1]];
        if extent[0].max(extent[1]) <= WHOLE {
            return Self::whole(whole);
        }
        let count = [0, 1].map(|axis| (extent[axis] / WINDOW).ceil().max(1.0) as usize);
        let side = [0, 1].map(|axis| extent[axis] / count[axis] as f64);
        let window = |i: usize| {
            let (mut min, mut max) = (bounds.min, bounds.max);
            for (axis, place) in [i % count[0], i / count[0]].into_iter().enumerate() {
                let from = low[axis] + place as f64 * side[axis];
                (min[axis], max[axis]) = (from - RIM, from + side[axis] + RIM);
            }
            whole.window(&Aabb { min, max })
        };
        Self { low, side, count, inputs: (0..count[0] * count[1]).map(window).collect() }
    }

    /// One window of the whole building, however large.
    pub fn whole(whole: &Inputs<'a>) -> Self {
        Self { low: [0.0; 2], side: [f64::INFINITY; 2], count: [1; 2], inputs: vec![whole.clone()] }
    }

    /// What is seen through each of them.
    pub fn inputs(&self) -> &[Inputs<'a>] {
        &self.inputs
    }

    /// The window that answers for a place.
    pub fn at(&self, place: &Point3<f64>) -> usize {
        let [column, row] = [0, 1].map(|axis| {
            // A cast takes what is below 0 for 0.
            (((place[axis] - self.low[axis]) / self.side[axis]) as usize).min(self.count[axis] - 1)
        });
        row * self.count[0] + column
    }
}
