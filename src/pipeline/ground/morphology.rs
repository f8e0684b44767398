//! The simple morphological filter (SMRF): Pingel, Clarke and `McBride` (2013), An improved simple morphological filter for
//! the terrain classification of airborne LIDAR data, ISPRS Journal of Photogrammetry and Remote Sensing 77, with a
//! structuring element that is a diamond and gaps filled by the mean of eight neighbours, as in PDAL.

use super::Failure;
use super::raster::{Grid, Raster};

/// The slope by which cells that lie lower than all around them are told (section 2.3 of the paper: 500 %).
const LOW_SLOPE: f64 = 5.0;

/// The parameters.
#[derive(Debug, Clone, Copy)]
pub(in crate::pipeline) struct Morphology {
    /// Side of a cell, CRS units.
    pub cell: f64,
    /// The steepest terrain, rise over run.
    pub slope: f64,
    /// Radius of the largest window, CRS units: larger objects are not told.
    pub window: f64,
    /// How much a slope adds to the threshold.
    pub scalar: f64,
    /// How far from the terrain a point may lie and be ground, CRS units.
    pub threshold: f64,
    /// Distance of the lines of a net of low heights; 0 for no net.
    pub cut: f64,
}

impl Morphology {
    /// Which of the positions are ground.
    ///
    /// # Errors
    /// An interruption, or too many cells.
    pub fn ground(&self, positions: &[[f64; 3]], stop: &(dyn Fn() -> bool + Sync)) -> Result<Vec<bool>, Failure> {
        let grid = Grid::around(positions, self.cell)?;
        let mut lowest = Raster::lowest(&grid, positions);
        lowest.fill();
        let mut inverted = lowest.clone();
        for value in &mut inverted.values {
            *value = -*value;
        }
        let is_low = self.objects(&grid, inverted, LOW_SLOPE, self.cell, stop)?;
        let net = self.net(&grid, &lowest, stop)?;
        let start = net.as_ref().map_or_else(|| lowest.clone(), |(raster, _)| raster.clone());
        let is_object = self.objects(&grid, start, self.slope, self.window, stop)?;
        let mut terrain = lowest;
        for (i, value) in terrain.values.iter_mut().enumerate() {
            let is_net = net.as_ref().is_some_and(|(_, is_net)| is_net[i]);
            if is_low[i] || is_object[i] || is_net {
                *value = f64::NAN;
            }
        }
        terrain.fill();
        let slopes = terrain.slopes(self.cell);
        let is_ground = |position: &[f64; 3]| {
            let cell = grid.cell_of(*position);
            // Where no cell is left that is terrain nothing is near to it.
            (terrain.values[cell] - position[2]).abs() <= self.threshold + self.scalar * slopes[cell]
        };
        Ok(positions.iter().map(is_ground).collect())
    }

    /// The cells that stand out of the surface by more than a slope allows, in windows that grow up to `window`
    /// (section 2.2).
    fn objects(
        &self,
        grid: &Grid,
        surface: Raster,
        slope: f64,
        window: f64,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Result<Vec<bool>, Failure> {
        // From there on a window covers everything, and nothing changes any more.
        let everything = grid.columns + grid.rows;
        let largest = ((window / self.cell).ceil() as usize).min(everything);
        let mut is_object = vec![false; surface.values.len()];
        let mut eroded = surface.clone();
        let mut before = surface;
        for radius in 1..=largest {
            eroded.spread(1, f64::min, stop)?;
            let mut opened = eroded.clone();
            opened.spread(radius, f64::max, stop)?;
            let most = slope * self.cell * radius as f64;
            for ((is_object, before), opened) in is_object.iter_mut().zip(&before.values).zip(&opened.values) {
                *is_object |= (before - opened).abs() > most;
            }
            before = opened;
        }
        Ok(is_object)
    }

    /// The surface with a net of low heights, so that buildings larger than the window fall apart, and which cells are of
    /// the net (section 2.5).
    fn net(
        &self,
        grid: &Grid,
        lowest: &Raster,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Result<Option<(Raster, Vec<bool>)>, Failure> {
        if self.cut <= 0.0 {
            return Ok(None);
        }
        // Beyond the raster no line follows.
        let mesh = ((self.cut / self.cell).ceil() as usize).min(grid.columns + grid.rows);
        let mut opened = lowest.clone();
        opened.spread(2 * mesh, f64::min, stop)?;
        opened.spread(2 * mesh, f64::max, stop)?;
        let is_net: Vec<bool> = (0..lowest.values.len())
            .map(|i| (i % grid.columns).is_multiple_of(mesh) || (i / grid.columns).is_multiple_of(mesh))
            .collect();
        let mut surface = lowest.clone();
        for (i, value) in surface.values.iter_mut().enumerate().filter(|(i, _)| is_net[*i]) {
            *value = opened.values[i];
        }
        Ok(Some((surface, is_net)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DEFAULT: Morphology =
        Morphology { cell: 1.0, slope: 0.15, window: 18.0, scalar: 1.25, threshold: 0.5, cut: 0.0 };

    /// A point in the middle of each of 40 × 40 cells, of which the first lies at the origin, at this height.
    fn scene(height: impl Fn(f64, f64) -> f64) -> Vec<[f64; 3]> {
        let place = |i: i32| f64::from(i) + if i == 0 { 0.0 } else { 0.5 };
        (0..40).flat_map(|y| (0..40).map(move |x| (place(x), place(y)))).map(|(x, y)| [x, y, height(x, y)]).collect()
    }

    /// A block of 10 by 10 on a plane of 10 %.
    fn block(x: f64, y: f64) -> f64 {
        let stands = (15.0..25.0).contains(&x) && (15.0..25.0).contains(&y);
        0.1 * x + if stands { 6.0 } else { 0.0 }
    }

    fn others(method: &Morphology, positions: &[[f64; 3]]) -> usize {
        method.ground(positions, &|| false).unwrap().into_iter().filter(|is_ground| !is_ground).count()
    }

    #[test]
    fn a_block_stands_on_a_slope() {
        let positions = scene(block);
        let is_ground = DEFAULT.ground(&positions, &|| false).unwrap();
        for (position, is_ground) in positions.iter().zip(&is_ground) {
            let [x, y, z] = *position;
            assert_eq!(*is_ground, z < 0.1 * x + 1.0, "{x} {y} {z}");
        }
    }

    #[test]
    fn windows_limit_what_is_told() {
        let positions = scene(block);
        // Of a window of 2 the block of 10 is terrain; the corners, which a diamond of 2 cannot fill, are not.
        assert!(others(&Morphology { window: 2.0, ..DEFAULT }, &positions) < 40);
        assert_eq!(others(&DEFAULT, &positions), 100);
        // A threshold above the block makes everything ground.
        assert_eq!(others(&Morphology { threshold: 7.0, ..DEFAULT }, &positions), 0);
        // A net parts the block, so that a window that is smaller than it does. (Beside the upper border of a slope the net
        // lies too low: there is nothing beyond to open.)
        let net = Morphology { window: 5.0, cut: 5.0, ..DEFAULT };
        let is_ground = net.ground(&positions, &|| false).unwrap();
        let stands = |position: &[f64; 3]| position[2] > 0.1 * position[0] + 1.0;
        let block = positions.iter().zip(&is_ground).filter(|(position, _)| stands(position));
        assert_eq!(block.filter(|(_, is_ground)| !**is_ground).count(), 100);
        assert_eq!(DEFAULT.ground(&positions, &|| true), Err(Failure::Interrupted));
    }

    #[test]
    fn a_point_below_the_ground_is_none() {
        let mut positions = scene(|x, _| 0.1 * x);
        positions[820][2] -= 8.0;
        let is_ground = DEFAULT.ground(&positions, &|| false).unwrap();
        let others: Vec<usize> = (0..positions.len()).filter(|&i| !is_ground[i]).collect();
        assert_eq!(others, [820]);
        // One point is terrain.
        assert_eq!(DEFAULT.ground(&[[5.0, 5.0, 5.0]], &|| false).unwrap(), [true]);
    }
}
