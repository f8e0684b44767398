//! How well a model fits the points that it was made from, and how well the block of the same building does.
//!
//! Both are held against the same points. What is too small to stand, or hovers, is rightly in neither and counts for
//! neither.

use geo::MultiPolygon;
use nalgebra::Point3;

use super::{Failure, Parameters, blocks, grid_height, measures, outline, unmodelled};
use crate::building::{Reason, RoofHeights};
use crate::completeness::tops;
use crate::site::Site;
use crate::solid::{FootprintPolygon, Solid};

/// A model that fits worse than its block by no more than this fits alike, metres: so much the noise of a scan makes.
const ALIKE: f64 = 0.02;

/// A model of a building beside its block.
#[derive(Debug, Clone, Default)]
pub(super) struct Fit {
    /// The points that count for nothing, ascending.
    pub left_out: Vec<u32>,
    /// Heights of the points on roofs, of those that count; `None` without any.
    pub roof_heights: Option<RoofHeights>,
    /// The LoD 1.2 blocks.
    pub blocks: Vec<Solid>,
    /// Root mean square of the distances of the points to the blocks, metres.
    pub rmse_lod12: Option<f64>,
    /// The same of the LoD 2.2 model.
    pub rmse_lod22: Option<f64>,
}

/// What was scanned of a building, and what its block stands on.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scanned<'a> {
    /// The building, and the part of its footprint that stands.
    pub site: &'a Site,
    /// The building points on roofs, ascending.
    pub roof_points: &'a [u32],
    /// The heights of all points on roofs, should none of those that count be on one.
    pub roof_heights: Option<RoofHeights>,
    /// The outline of the roofs in local metres, for a site without a footprint.
    pub outline: Option<&'a MultiPolygon<f64>>,
    /// Size of a grid step, metres.
    pub step: [f64; 3],
    /// The top of the block where no point is on a roof, local metres; without it there is none.
    pub stated_top: Option<f64>,
}

impl Fit {
    /// That of a LoD 2.2 model.
    pub fn of_model(scanned: &Scanned, solids: &[Solid], parameters: &Parameters) -> Self {
        let Scanned { site, .. } = scanned;
        let left_out = left_out(site, solids, false, parameters);
        let roof_heights = scanned.heights(&left_out);
        let blocks = scanned.blocks(solids, roof_heights);
        let points = counting(&site.points, &left_out);
        let [rmse_lod12, rmse_lod22] = [&blocks[..], solids].map(|solids| measures::rmse(solids, &points));
        Self { left_out, roof_heights, blocks, rmse_lod12, rmse_lod22 }
    }

    /// That of a building without a LoD 2.2 model.
    pub fn of_blocks(scanned: &Scanned, parameters: &Parameters) -> Self {
        let Scanned { site, .. } = scanned;
        let blocks = scanned.blocks(&[], scanned.heights(&[]));
        let left_out = left_out(site, &blocks, true, parameters);
        let rmse_lod12 = measures::rmse(&blocks, &counting(&site.points, &left_out));
        Self { roof_heights: scanned.heights(&left_out), left_out, blocks, rmse_lod12, rmse_lod22: None }
    }

    /// A model that explains its points worse than the block is none.
    pub fn check(&self) -> Result<(), Failure> {
        match (self.rmse_lod22, self.rmse_lod12) {
            (Some(model), Some(block)) if model > block + ALIKE => {
                let detail = format!("the model fits its points to {model:.2} m, the block to {block:.2} m");
                Err(Failure::new(Reason::WorseThanBlock, detail))
            }
            _ => Ok(()),
        }
    }
}

impl Scanned<'_> {
    /// Heights of the points on roofs that count.
    fn heights(&self, left_out: &[u32]) -> Option<RoofHeights> {
        let counting = self.roof_points.iter().filter(|i| left_out.binary_search(i).is_err());
        let mut heights: Vec<f64> = counting.filter_map(|&i| Some(self.site.points.get(i as usize)?.z)).collect();
        measures::roof_heights(&mut heights).or(self.roof_heights)
    }

    /// A block on every polygon that something stands on, up to the 70th percentile of the roof heights, or to the height that
    /// is stated.
    fn blocks(&self, solids: &[Solid], heights: Option<RoofHeights>) -> Vec<Solid> {
        let Some(top) = heights.map(|heights| heights.p70).or(self.stated_top) else { return Vec::new() };
        let step = self.step;
        let polygons: Vec<FootprintPolygon> = match &self.site.footprint {
            Some(footprint) => blocks::footprint(footprint, step, &mut Vec::new()),
            None => outline::footprint(solids, self.outline, step, &mut Vec::new()),
        };
        let [ground, top] = [self.site.ground.height, top].map(|height| grid_height(height, step));
        polygons.iter().filter_map(|polygon| blocks::block(polygon, ground, top, step)).collect()
    }
}

/// The points of what is too small to stand, or hovers, over solids; none without solids. Ascending.
fn left_out(site: &Site, solids: &[Solid], is_block: bool, parameters: &Parameters) -> Vec<u32> {
    if solids.is_empty() {
        return Vec::new();
    }
    let model = tops(solids);
    unmodelled::unmodelled(&site.points, &model, site.ground.height, parameters.completeness.height, is_block)
}

/// The points that count.
pub(super) fn counting(points: &[Point3<f64>], left_out: &[u32]) -> Vec<Point3<f64>> {
    let mut left_out = left_out.iter().peekable();
    (0_u32..).zip(points).filter(|(i, _)| left_out.next_if_eq(&i).is_none()).map(|(_, p)| *p).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_model_that_fits_worse_than_its_block_is_refused() {
        let fit = |rmse_lod22: f64, rmse_lod12: Option<f64>| {
            Fit { rmse_lod22: Some(rmse_lod22), rmse_lod12, ..Fit::default() }.check()
        };
        assert_eq!(fit(0.02, Some(0.80)), Ok(()));
        // A flat roof: both are as good as the noise.
        assert_eq!(fit(0.024, Some(0.021)), Ok(()));
        assert_eq!(fit(1.68, None), Ok(()), "without a block there is nothing better");
        let failure = fit(1.68, Some(0.80)).unwrap_err();
        assert_eq!(
            (failure.reason, failure.detail.as_str()),
            (Reason::WorseThanBlock, "the model fits its points to 1.68 m, the block to 0.80 m")
        );
    }
}
