//! New hypotheses for what a model left unexplained.
//!
//! A part of a roof is missing in a model because no plane was found in its points, because its plane lost against those
//! around it, or because nothing cut it out of the cell in which it stands. A revision answers all three: the points of
//! the part become primitives of their own, which the roof map sees and around which walls are put up.

use std::collections::BTreeSet;

use nalgebra::{Point3, Vector3};

use super::hypotheses::WALL_VERTICALITY;
use super::primitives::{self, Primitive};
use super::{Detected, Parameters};
use crate::geometry::{Plane, seed_of};
use crate::site::Site;

/// Fewest points of a primitive that is added.
const FEWEST: usize = 3;
/// The second detection looks for parts as small as this, square metres, …
const SMALLEST: f64 = 0.5;
/// … and lets normals deviate this much, degrees: those of few points are bad.
const DEVIATION: f64 = 35.0;
/// A level patch, the last resort, explains the points so near to it, metres.
const LEVEL_TOLERANCE: f64 = 0.5;
/// No part gets more level patches than this.
const LEVEL_PATCHES: usize = 2;

impl Detected {
    /// The planes with new ones for the points of each part that was left unexplained (`parts` are indices into the
    /// points of the site); `None` where they bear none.
    pub(super) fn revised(&self, site: &Site, parts: &[Vec<u32>], parameters: &Parameters) -> Option<Self> {
        let mut added = Vec::new();
        let mut claimed = BTreeSet::new();
        for (number, part) in (0u64..).zip(parts) {
            let is_off = |point: &u32| self.off.binary_search(point).is_ok();
            let part: Vec<u32> =
                part.iter().copied().filter(|point| !claimed.contains(point) && !is_off(point)).collect();
            let seed = seed_of(&site.id) ^ (number + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
            for primitive in self.explain(&site.points, &part, parameters, seed) {
                claimed.extend(primitive.inliers.iter().copied());
                added.push(primitive);
            }
        }
        if added.is_empty() {
            return None;
        }
        let mut revised = self.clone();
        for roof in &mut revised.roofs {
            roof.inliers.retain(|point| !claimed.contains(point));
        }
        // A plane that all its points have left is not seen anywhere; which of them are older ones must stay known.
        let older = revised.roofs.len() - revised.revised;
        let before = &self.roofs;
        let stays: Vec<bool> = revised
            .roofs
            .iter()
            .zip(before)
            .map(|(roof, old)| !roof.inliers.is_empty() || old.asserted().is_some())
            .collect();
        revised.revised = stays.iter().skip(older).filter(|stays| **stays).count() + added.len();
        let mut stays = stays.into_iter();
        revised.roofs.retain(|_| stays.next().unwrap_or(true));
        revised.roofs.extend(added);
        Some(revised)
    }

    /// Primitives for the points of one part: first pieces of the planes that they lie on, then planes of a looser
    /// detection in what is left, in the last resort level patches.
    fn explain(&self, points: &[Point3<f64>], part: &[u32], parameters: &Parameters, seed: u64) -> Vec<Primitive> {
        let mut found = Vec::new();
        let mut left: BTreeSet<u32> = part.iter().copied().collect();
        let mut take = |primitive: Option<Primitive>, left: &mut BTreeSet<u32>| {
            let Some(primitive) = primitive.filter(|p| p.inliers.len() >= FEWEST) else { return };
            primitive.inliers.iter().for_each(|point| {
                left.remove(point);
            });
            found.push(primitive);
        };
        for roof in &self.roofs {
            let shared: Vec<u32> = roof.inliers.iter().copied().filter(|point| left.contains(point)).collect();
            if shared.len() >= FEWEST {
                take(Primitive::on_plane(roof.plane, points, shared), &mut left);
            }
        }
        if left.len() >= FEWEST {
            let rest: Vec<u32> = left.iter().copied().collect();
            let cloud: Vec<Point3<f64>> = rest.iter().filter_map(|&i| points.get(i as usize).copied()).collect();
            let mut looser = parameters.clone();
            looser.detection.minimum_area = looser.detection.minimum_area.min(SMALLEST);
            looser.detection.minimum_inliers = looser.detection.minimum_inliers.min(FEWEST + 1);
            looser.detection.normal_deviation = looser.detection.normal_deviation.max(DEVIATION);
            for primitive in primitives::detect(&cloud, &looser, seed).primitives {
                if primitive.plane.verticality() <= WALL_VERTICALITY {
                    let members = primitive.inliers.iter().filter_map(|&i| rest.get(i as usize).copied()).collect();
                    take(Primitive::on_plane(primitive.plane, points, members), &mut left);
                }
            }
        }
        for _ in 0..LEVEL_PATCHES {
            let Some(patch) = level_patch(points, &left) else { break };
            take(Some(patch), &mut left);
        }
        found
    }
}

/// The level primitive that explains most of the points `left`; `None` where that is too few.
fn level_patch(points: &[Point3<f64>], left: &BTreeSet<u32>) -> Option<Primitive> {
    let mut heights: Vec<(f64, u32)> =
        left.iter().filter_map(|&i| points.get(i as usize).map(|point| (point.z, i))).collect();
    heights.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let (mut first, mut best) = (0, 0..0);
    for last in 0..heights.len() {
        while heights[last].0 - heights[first].0 > 2.0 * LEVEL_TOLERANCE {
            first += 1;
        }
        if last + 1 - first > best.len() {
            best = first..last + 1;
        }
    }
    let explained = heights.get(best).filter(|explained| explained.len() >= FEWEST)?;
    let (middle, _) = explained.get(explained.len() / 2)?;
    let plane = Plane::through(&Point3::new(0.0, 0.0, *middle), Vector3::z_axis());
    Primitive::on_plane(plane, points, explained.iter().map(|(_, i)| *i).collect())
}

#[cfg(test)]
mod tests {
    use super::super::edited::Tally;
    use super::*;
    use crate::reconstruct::primitives::{Extent, PrimitiveKind};
    use crate::site::Frame;

    /// Points of a grid of 0.5 m over a rectangle, at a height.
    fn grid(x: [i32; 2], y: [i32; 2], height: impl Fn(f64, f64) -> f64) -> Vec<Point3<f64>> {
        let axis = |range: [i32; 2]| (range[0]..range[1]).map(|i| f64::from(i) / 2.0);
        axis(x).flat_map(|x| axis(y).map(move |y| (x, y))).map(|(x, y)| Point3::new(x, y, height(x, y))).collect()
    }

    fn site(points: Vec<Point3<f64>>) -> Site {
        Site::new("a", Frame { origin: [0.0; 3], metres_per_unit: [1.0; 3] }, points, 0.0)
    }

    fn detected(roofs: Vec<Primitive>) -> Detected {
        Detected {
            count: roofs.len(),
            roofs,
            undersides: vec![],
            walls: vec![],
            covered: vec![],
            revised: 0,
            added_walls: vec![],
            off_planes: vec![],
            edited: vec![],
            off: vec![],
            noise: 0.02,
            tally: Tally::default(),
        }
    }

    #[test]
    fn a_part_takes_its_points_from_the_plane_that_it_lies_on() {
        let points = grid([0, 20], [0, 20], |x, _| 5.0 + x / 2.0);
        let roof = Primitive::from_inliers(&points, (0..400).collect()).unwrap();
        let part: Vec<u32> = (0..40).collect();
        let found = detected(vec![roof.clone()]);
        let revised = found.revised(&site(points), std::slice::from_ref(&part), &Parameters::default());
        let revised = revised.unwrap();
        assert_eq!((revised.roofs.len(), revised.revised), (2, 1));
        assert_eq!((&revised.roofs[1].inliers, revised.roofs[0].inliers.len()), (&part, 360));
        assert_eq!(revised.roofs[1].plane, roof.plane);
    }

    #[test]
    fn a_slope_that_was_too_small_is_found_and_what_bears_no_plane_becomes_level() {
        let mut points = grid([0, 6], [0, 3], |x, _| 9.0 + x);
        let slope: Vec<u32> = (0..points.len() as u32).collect();
        points.extend(
            [[8.0, 0.0, 4.1], [8.4, 0.7, 4.5], [9.0, 0.2, 4.2], [8.2, 1.0, 4.4], [8.9, 1.1, 30.0]].map(Point3::from),
        );
        let clutter: Vec<u32> = (slope.len() as u32..points.len() as u32).collect();
        let none = Primitive {
            kind: PrimitiveKind::Detected,
            plane: Plane::through(&Point3::new(0.0, 0.0, 1.0), Vector3::z_axis()),
            inliers: vec![],
            residual: 0.0,
            extent: Extent::Everywhere,
        };
        let site = site(points);
        let revised = detected(vec![none]).revised(&site, &[slope, clutter], &Parameters::default()).unwrap();
        let normals: Vec<f64> = revised.roofs.iter().map(|roof| roof.plane.normal.z).collect();
        assert!(normals.len() == 2 && (normals[0] - 0.5_f64.sqrt()).abs() < 1e-6 && normals[1] == 1.0, "{normals:?}");
        assert_eq!(revised.roofs[1].inliers.len(), 4);
        assert!(detected(vec![]).revised(&site, &[vec![]], &Parameters::default()).is_none());
    }
}
