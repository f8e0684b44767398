//! Region growing on estimated normals: the detector that suits airborne roofs.
//!
//! A region starts where the points are smoothest and takes in neighbours that lie on its plane and share its normal;
//! the plane is refitted as the region grows. What is left over is looked at once more among itself: the
//! neighbourhoods of a dormer of ten points are full of points of the roof around it.

use nalgebra::Point3;

use super::moments::{Fit, Moments};
use super::neighbours::Neighbours;
use super::normals::LocalPlanes;
use super::segmentation::{NONE, Segmentation, Tolerances};
use crate::geometry::Plane;

/// Segments a cloud of distinct points. `local` must come from the same points and neighbours.
pub(super) fn segment(
    points: &[Point3<f64>],
    neighbours: &Neighbours,
    local: &LocalPlanes,
    tolerances: &Tolerances,
) -> Segmentation {
    /// Passes over what the ones before left: dormers, then what stands on them.
    const LATER_PASSES: usize = 2;
    let mut segmentation = Segmentation::empty(points.len());
    let lax = tolerances.lax();
    Grower::new(points, neighbours, local, tolerances).run(&mut segmentation);
    settle(&mut segmentation, points, neighbours, tolerances, lax.inliers);
    for _ in 0..LATER_PASSES {
        let left = segmentation.unassigned();
        let before = segmentation.planes.len();
        if left.len() < lax.inliers {
            break;
        }
        let points_left: Vec<Point3<f64>> = left.iter().map(|&i| points[i as usize]).collect();
        let neighbours_left = Neighbours::new(&points_left, neighbours.width().min(lax.inliers.max(6)));
        let local_left = LocalPlanes::estimate(&points_left, &neighbours_left, Some(local.noise));
        let mut found = Segmentation::empty(points_left.len());
        Grower::new(&points_left, &neighbours_left, &local_left, &lax).run(&mut found);
        for (members, plane) in found.members().iter().zip(&found.planes) {
            let members: Vec<u32> = members.iter().map(|&m| left[m as usize]).collect();
            segmentation.push(&members, *plane);
        }
        settle(&mut segmentation, points, neighbours, tolerances, lax.inliers);
        if segmentation.planes.len() <= before {
            break;
        }
    }
    segmentation
}

fn settle(
    segmentation: &mut Segmentation,
    points: &[Point3<f64>],
    neighbours: &Neighbours,
    tolerances: &Tolerances,
    fewest: usize,
) {
    segmentation.settle_borders(points, neighbours, tolerances);
    segmentation.dissolve_redundant(points, neighbours, tolerances);
    segmentation.refit(points, tolerances, fewest);
}

struct Grower<'a> {
    points: &'a [Point3<f64>],
    neighbours: &'a Neighbours,
    local: &'a LocalPlanes,
    tolerances: &'a Tolerances,
    /// For each point the last attempt that took it in.
    taken: Vec<u32>,
    attempt: u32,
}

impl<'a> Grower<'a> {
    fn new(
        points: &'a [Point3<f64>],
        neighbours: &'a Neighbours,
        local: &'a LocalPlanes,
        tolerances: &'a Tolerances,
    ) -> Self {
        Self { points, neighbours, local, tolerances, taken: vec![0; points.len()], attempt: 0 }
    }

    /// Grows regions from every point that no region has taken yet, the smoothest first.
    fn run(&mut self, segmentation: &mut Segmentation) {
        let mut seeds: Vec<u32> =
            (0..self.points.len() as u32).filter(|&i| self.local.roughness[i as usize].is_finite()).collect();
        seeds.sort_by(|&a, &b| {
            let roughness = |i: u32| self.local.roughness[i as usize];
            roughness(a).total_cmp(&roughness(b)).then(a.cmp(&b))
        });
        for seed in seeds {
            if segmentation.labels[seed as usize] == NONE
                && let Some((members, fit)) = self.grow(seed, &segmentation.labels)
            {
                segmentation.push(&members, fit.plane);
            }
        }
    }

    /// The region around a seed and its plane, if it is large enough to be one.
    fn grow(&mut self, seed: u32, labels: &[u32]) -> Option<(Vec<u32>, Fit)> {
        /// A refit moves the border once or twice; a region that has not come to rest by then wanders along a curved
        /// surface.
        const ROUNDS: usize = 3;
        self.attempt += 1;
        let anchor = self.points[seed as usize];
        let mut plane = self.local.planes[seed as usize];
        let mut members = vec![seed];
        let mut moments = Moments::new(anchor);
        moments.add(&anchor);
        self.taken[seed as usize] = self.attempt;
        let mut settled = None;
        let reach = self.tolerances.reach.powi(2);
        for _ in 0..ROUNDS {
            let before = members.len();
            let mut next_fit = before.max(5) * 3 / 2;
            let mut front = 0;
            while let Some(&point) = members.get(front) {
                front += 1;
                for &near in self.neighbours.of(point) {
                    let slot = near as usize;
                    if labels[slot] == NONE
                        && self.taken[slot] != self.attempt
                        && (self.points[slot] - self.points[point as usize]).norm_squared() <= reach
                        && self.belongs(near, &plane)
                    {
                        self.taken[slot] = self.attempt;
                        members.push(near);
                        moments.add(&self.points[slot]);
                    }
                }
                if members.len() >= next_fit {
                    next_fit = members.len() * 3 / 2;
                    // Until the region is wide enough to carry a plane, that of the seed is better.
                    if let Some(fit) = moments.fit().filter(|fit| fit.width >= self.tolerances.width) {
                        plane = fit.plane;
                    }
                }
            }
            if settled.is_some() && members.len() == before {
                break;
            }
            let fit = moments.fit().filter(|fit| fit.width >= self.tolerances.width)?;
            plane = fit.plane;
            let mut kept = Moments::new(anchor);
            members.retain(|&m| {
                let point = &self.points[m as usize];
                let stays = plane.distance(point).abs() <= self.tolerances.distance;
                if stays {
                    kept.add(point);
                } else {
                    self.taken[m as usize] = 0;
                }
                stays
            });
            moments = kept;
            settled = moments.fit().filter(|fit| fit.width >= self.tolerances.width);
        }
        let fit = settled.filter(|_| members.len() >= self.tolerances.inliers)?;
        Some((members, fit))
    }

    fn belongs(&self, point: u32, plane: &Plane) -> bool {
        let slot = point as usize;
        self.tolerances.admit(plane, &self.points[slot], &self.local.planes[slot])
    }
}
