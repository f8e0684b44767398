//! Which point belongs to which plane: what both detectors produce.

use nalgebra::Point3;

use super::moments::Moments;
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
    /// Largest distance from its plane of a point that was moved onto its local plane, metres. Smoothing takes most of
    /// the noise away, so that in noisy clouds a step between two roofs stays visible.
    pub smoothed: f64,
    /// Least cosine of the angle between the normals of a point and of its plane.
    pub cosine: f64,
    /// Fewest points of a segment.
    pub inliers: usize,
    /// Least standard deviation of a segment along its minor axis, metres: a row of points along an eave bears no
    /// plane.
    pub width: f64,
}

impl Tolerances {
    /// The tolerances for a cloud of this noise (metres) and density (points per square metre), with normals from
    /// `neighbours` points.
    pub fn new(parameters: &DetectionParameters, noise: f64, density: f64, neighbours: usize) -> Self {
        let least = parameters.minimum_tolerance.max(1e-3);
        let scaled = parameters.noise_factor.max(1.0) * noise;
        let distance = scaled.clamp(least, parameters.maximum_tolerance.max(least));
        // The error of a local plane at its own point is about σ √(3/k), and half as much again at its border.
        let smoothing = 1.5 * (3.0 / (neighbours + 1) as f64).sqrt();
        Self {
            noise,
            distance,
            smoothed: (scaled * smoothing).clamp(least, distance),
            cosine: parameters.normal_deviation.clamp(1.0, 90.0).to_radians().cos(),
            inliers: ((parameters.minimum_area * density).round() as usize).max(parameters.minimum_inliers).max(3),
            width: (2.0 * noise).max(0.15),
        }
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
                    let ratio = plane.distance(point).abs() / tolerances.distance;
                    (ratio <= 1.0).then(|| (ratio * ratio + 0.5 * (1.0 - weight), label))
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
            match fit.filter(|fit| members.len() >= fewest && fit.width >= tolerances.width) {
                Some(fit) => self.push(&members, fit.plane),
                None => members.iter().for_each(|&m| self.labels[m as usize] = NONE),
            }
        }
    }
}
