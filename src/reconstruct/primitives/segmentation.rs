//! Which point belongs to which plane: what both detectors produce.

use nalgebra::Point3;

use super::moments::{Fit, Moments};
use super::neighbours::Neighbours;
use super::parameters::DetectionParameters;
use crate::geometry::Plane;

/// The label of a point that belongs to no plane.
pub(super) const NONE: u32 = u32::MAX;

/// What a point and a segment must satisfy, derived from the parameters and from what was measured of the cloud.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tolerances {
    /// Standard deviation of the points across the surface, metres.
    pub noise: f64,
    /// Largest distance of a point from its plane, metres.
    pub distance: f64,
    /// Largest distance at which a point may still belong to the plane of its neighbours, metres. Planes are grown
    /// from points within `distance`; tiles, gutters and the tail of the noise reach a little farther.
    pub border: f64,
    /// Largest distance from its plane of a point that was moved onto its local plane, metres. Smoothing takes most of
    /// the noise away, so that in noisy clouds a step between two roofs stays visible.
    pub smoothed: f64,
    /// Least cosine of the angle between the normals of a point and of its plane.
    pub cosine: f64,
    /// Fewest points of a segment at this density.
    pub inliers: usize,
    /// Fewest points of a segment at any density.
    pub fewest: usize,
    /// Largest distance between neighbours of one segment, metres: about three times the spacing of the points. What is
    /// left over is sparse, and its nearest neighbours may be on another roof.
    pub reach: f64,
    /// Least standard deviation of a segment along its minor axis, metres: a row of points along an eave bears no
    /// plane.
    pub width: f64,
}

impl Tolerances {
    /// The tolerances for a cloud of this noise (metres) and density (points per square metre), with normals from
    /// `neighbours` points.
    pub fn new(parameters: &DetectionParameters, noise: f64, density: f64, neighbours: usize) -> Self {
        /// On AHN3 this explains 2.5 % more of the points than 1 does, with as many planes; 2 adds little but noise.
        const BORDER: f64 = 1.5;
        let least = parameters.minimum_tolerance.max(1e-3);
        let scaled = parameters.noise_factor.max(1.0) * noise;
        let most = parameters.maximum_tolerance.max(least);
        let distance = scaled.clamp(least, most);
        // The error of a local plane at its own point is about σ √(3/k), and half as much again at its border.
        let smoothing = 1.5 * (3.0 / (neighbours + 1) as f64).sqrt();
        let fewest = parameters.minimum_inliers.max(3);
        Self {
            noise,
            distance,
            border: (BORDER * distance).clamp(distance, most),
            smoothed: (scaled * smoothing).clamp(least, distance),
            cosine: parameters.normal_deviation.clamp(1.0, 90.0).to_radians().cos(),
            inliers: ((parameters.minimum_area * density).round() as usize).max(fewest),
            fewest,
            reach: 3.0 / density.max(1e-6).sqrt(),
            width: (2.0 * noise).max(0.15),
        }
    }

    /// Whether a point lies on a plane and looks the same way, given the local plane of the point.
    pub fn admit(&self, plane: &Plane, point: &Point3<f64>, local: &Plane) -> bool {
        let distance = plane.distance(point);
        if distance.abs() > self.distance {
            return false;
        }
        let cosine = plane.normal.dot(&local.normal);
        let smoothed = distance - cosine * local.distance(point);
        cosine.abs() >= self.cosine && smoothed.abs() <= self.smoothed
    }

    /// How many points a plane needs where one that faces the sky needs `fewest`.
    pub fn needed(plane: &Plane, fewest: usize) -> usize {
        /// Cosine of 65°: steeper than roofs are built.
        const STEEP: f64 = 0.42;
        // Seen from the air, points line up on steep planes by accident: gutters, edges of dormers, antennas. A wall
        // that was really scanned has many.
        if plane.normal.z.abs() < STEEP { 2 * fewest } else { fewest }
    }

    /// Laxer tolerances, for what stands on a roof: normals of few points are worse, so they may deviate one and a half
    /// times as much, and an object that stands free needs a quarter fewer points to be believed.
    pub fn lax(&self) -> Self {
        let deviation = 1.5 * self.cosine.clamp(0.0, 1.0).acos();
        let inliers = (self.inliers * 3 / 4).max(self.fewest);
        Self { cosine: deviation.min(std::f64::consts::FRAC_PI_2).cos(), inliers, ..*self }
    }
}

/// A label for every point and a plane for every label.
#[derive(Debug, Clone)]
pub(super) struct Segmentation {
    /// For each point an index into `planes`, or [`NONE`].
    pub labels: Vec<u32>,
    /// The planes.
    pub planes: Vec<Plane>,
}

impl Segmentation {
    /// No point belongs anywhere.
    pub fn empty(points: usize) -> Self {
        Self { labels: vec![NONE; points], planes: Vec::new() }
    }

    /// Adds a segment.
    pub fn push(&mut self, members: &[u32], plane: Plane) {
        let label = self.planes.len() as u32;
        for &member in members {
            self.labels[member as usize] = label;
        }
        self.planes.push(plane);
    }

    /// The points of each segment, ascending.
    pub fn members(&self) -> Vec<Vec<u32>> {
        let mut members = vec![Vec::new(); self.planes.len()];
        for (i, &label) in (0u32..).zip(&self.labels) {
            if label != NONE {
                members[label as usize].push(i);
            }
        }
        members
    }

    /// The points that belong nowhere, ascending.
    pub fn unassigned(&self) -> Vec<u32> {
        (0u32..).zip(&self.labels).filter(|(_, label)| **label == NONE).map(|(i, _)| i).collect()
    }

    /// Gives every point near a border to the adjacent segment whose plane fits it best, whatever its normal: points
    /// on ridges and in valleys have bad ones. Points that no adjacent plane fits are set free.
    pub fn settle_borders(&mut self, points: &[Point3<f64>], neighbours: &Neighbours, tolerances: &Tolerances) {
        /// Labels travel one neighbourhood a sweep; bad normals do not reach farther than that around a border.
        const SWEEPS: usize = 3;
        if neighbours.width() == 0 {
            return;
        }
        let share = 1.0 / neighbours.width() as f64;
        let mut votes: Vec<(u32, f64)> = Vec::new();
        for _ in 0..SWEEPS {
            let mut changed = false;
            for (i, point) in (0u32..).zip(points) {
                let own = self.labels[i as usize];
                votes.clear();
                votes.push((own, 0.0));
                for &j in neighbours.of(i) {
                    let label = self.labels[j as usize];
                    match votes.iter_mut().find(|(voted, _)| *voted == label) {
                        Some((_, weight)) => *weight += share,
                        None => votes.push((label, share)),
                    }
                }
                // Distance decides; the neighbours decide between planes that fit alike.
                let cost = |&(label, weight): &(u32, f64)| -> Option<(f64, u32)> {
                    let plane = self.planes.get(label as usize)?;
                    let ratio = plane.distance(point).abs() / tolerances.border;
                    (ratio <= 1.0).then_some((ratio * ratio + 0.5 * (1.0 - weight), label))
                };
                let best = votes.iter().filter_map(cost).min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
                let label = best.map_or(NONE, |(_, label)| label);
                changed |= label != own;
                self.labels[i as usize] = label;
            }
            if !changed {
                break;
            }
        }
    }

    /// Refits every plane to its points and dissolves the segments that no longer bear one.
    pub fn refit(&mut self, points: &[Point3<f64>], tolerances: &Tolerances, fewest: usize) {
        let Some(&anchor) = points.first() else { return };
        let members = self.members();
        self.planes.clear();
        for members in members {
            let fit = Moments::of(anchor, points, &members).fit();
            let enough = |fit: &Fit| members.len() >= Tolerances::needed(&fit.plane, fewest);
            match fit.filter(|fit| enough(fit) && fit.width >= tolerances.width) {
                Some(fit) => self.push(&members, fit.plane),
                None => members.iter().for_each(|&m| self.labels[m as usize] = NONE),
            }
        }
    }

    /// The planes refitted to their points; a plane whose points bear none stays as it is.
    pub fn refitted(&self, points: &[Point3<f64>]) -> Vec<Plane> {
        let Some(&anchor) = points.first() else { return self.planes.clone() };
        let fit = |members: Vec<u32>| Moments::of(anchor, points, &members).fit();
        let members = self.members().into_iter().zip(&self.planes);
        members.map(|(members, plane)| fit(members).map_or(*plane, |fit| fit.plane)).collect()
    }

    /// Dissolves segments that explain nothing: whose points the planes around them explain as well, up to the noise.
    /// Such are the strips of points with mixed normals along ridges. The smallest go first.
    pub fn dissolve_redundant(&mut self, points: &[Point3<f64>], neighbours: &Neighbours, tolerances: &Tolerances) {
        /// Share of the points of a segment that the planes around it must explain.
        const SHARE: f64 = 0.75;
        /// Largest root mean square of the residuals there, relative to a third of the tolerance (one σ of the noise).
        const RESIDUAL: f64 = 2.0;
        let mut members = self.members();
        let mut order: Vec<u32> = (0..members.len() as u32).collect();
        order.sort_by_key(|&label| (members[label as usize].len(), label));
        for label in order {
            let own = std::mem::take(&mut members[label as usize]);
            let mut around: Vec<u32> = own
                .iter()
                .flat_map(|&i| neighbours.of(i))
                .map(|&j| self.labels[j as usize])
                .filter(|&other| other != label && other != NONE)
                .collect();
            around.sort_unstable();
            around.dedup();
            let nearest = |&i: &u32| {
                let at = |&other: &u32| (self.planes[other as usize].distance(&points[i as usize]).abs(), other);
                around.iter().map(at).min_by(|a, b| a.0.total_cmp(&b.0))
            };
            let explained: Vec<(u32, f64, u32)> = own
                .iter()
                .filter_map(|i| nearest(i).map(|(distance, other)| (*i, distance, other)))
                .filter(|(_, distance, _)| *distance <= tolerances.border)
                .collect();
            let squares: f64 = explained.iter().map(|(_, distance, _)| distance * distance).sum();
            let limit = RESIDUAL * tolerances.distance / 3.0;
            if explained.len() as f64 >= SHARE * own.len() as f64 && squares <= limit * limit * explained.len() as f64 {
                for &i in &own {
                    self.labels[i as usize] = NONE;
                }
                for (i, _, other) in explained {
                    self.labels[i as usize] = other;
                    members[other as usize].push(i);
                }
            }
        }
    }
}
