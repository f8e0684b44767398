//! Refinement (paper, Algorithm 1): planes that are one are merged, in metric terms.
//!
//! The paper's reference code compares centroids along the normal of the first plane in units of the building's size.
//! Here the distance is symmetric and metric, it allows for the uncertainty of both normals, and a merge must leave
//! every primitive that goes into it as close to the merged plane as its own noise explains (method, section 2).

use std::collections::BinaryHeap;

use nalgebra::Point3;

use super::moments::{Fit, Moments};
use super::parameters::DetectionParameters;
use super::{Primitive, PrimitiveKind, regularise};
use crate::geometry::{Aabb, Plane};

/// Largest angle between planes that the uncertainty of their normals can excuse, radians.
const MOST_ANGLE: f64 = 0.5;

/// Merges and gently regularises detected primitives; the result is ordered by support.
///
/// `points` are those that the inliers refer to and `noise` their standard deviation across the surface, in metres.
/// Primitives that were not detected, and detected ones whose inliers bear no plane, pass through unchanged at the end.
/// Inliers are only ever joined: no point changes its plane otherwise.
pub fn refine(
    points: &[Point3<f64>],
    primitives: Vec<Primitive>,
    parameters: &DetectionParameters,
    noise: f64,
) -> Vec<Primitive> {
    let anchor = Aabb::of(points).map_or(Point3::origin(), |aabb| aabb.min.into());
    let (mut patches, mut others) = (Vec::new(), Vec::new());
    for primitive in primitives {
        let moments =
            (primitive.kind == PrimitiveKind::Detected).then(|| Moments::of(anchor, points, &primitive.inliers));
        match moments.and_then(|moments| Patch::new(moments, primitive.inliers.clone())) {
            Some(patch) => patches.push(patch),
            None => others.push(primitive),
        }
    }
    let patches = refine_patches(patches, parameters, noise);
    let refined = patches.into_iter().filter_map(|patch| Primitive::on_plane(patch.plane, points, patch.members));
    refined.chain(others).collect()
}

/// Merges and regularises, ordered by support.
pub(super) fn refine_patches(patches: Vec<Patch>, parameters: &DetectionParameters, noise: f64) -> Vec<Patch> {
    let mut patches = merge(patches, parameters, noise);
    let by_support = |patches: &mut Vec<Patch>| {
        patches.sort_by(|a, b| b.members.len().cmp(&a.members.len()).then(a.members.cmp(&b.members)));
    };
    by_support(&mut patches);
    regularise::regularise(&mut patches, parameters, noise);
    by_support(&mut patches);
    patches
}

/// A plane with the points on it, during refinement.
#[derive(Debug, Clone)]
pub(super) struct Patch {
    /// The plane.
    pub plane: Plane,
    /// Moments of all its points.
    pub moments: Moments,
    /// Standard deviation of the points along the minor axis, metres.
    pub width: f64,
    /// The points, ascending.
    pub members: Vec<u32>,
    /// The patches that went into it, each with the mean square of its residuals on its own plane.
    parts: Vec<(Moments, f64)>,
}

impl Patch {
    /// The patch of some points; `None` when they bear no plane.
    pub fn new(moments: Moments, mut members: Vec<u32>) -> Option<Self> {
        members.sort_unstable();
        let fit = moments.fit()?;
        Some(Self { plane: fit.plane, moments, width: fit.width, members, parts: vec![(moments, fit.rms * fit.rms)] })
    }

    /// Standard error of the direction of the normal, radians.
    pub fn tilt_error(&self, noise: f64) -> f64 {
        noise.max(1e-6) / (self.moments.count().sqrt() * self.width.max(1e-6))
    }

    /// Whether every part is as close to a plane as to its own, up to `slack` metres (root mean square) and what the
    /// noise makes of a plane from so few points.
    pub fn bears(&self, plane: &Plane, slack: f64, noise: f64) -> bool {
        self.parts.iter().all(|(moments, own)| {
            // Three parameters estimated elsewhere instead of here cost 3σ²/n on average; twice the root of that.
            let chance = 12.0 * noise * noise / moments.count();
            moments.mean_square(plane) <= own + slack * slack + chance
        })
    }

    /// The union of two patches on a plane; `fit` describes their points.
    pub fn join(&self, other: &Self, plane: Plane, fit: &Fit) -> Self {
        let mut moments = self.moments;
        moments.merge(&other.moments);
        let mut members = [&self.members[..], &other.members[..]].concat();
        members.sort_unstable();
        Self { plane, moments, width: fit.width, members, parts: [&self.parts[..], &other.parts[..]].concat() }
    }
}

/// A pair of patches in the queue: the smallest angle first, then the lower indices.
#[derive(Debug, PartialEq)]
struct Pair {
    cosine: f64,
    first: usize,
    second: usize,
}

impl Eq for Pair {}

impl Ord for Pair {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.cosine.total_cmp(&other.cosine).then(other.first.cmp(&self.first)).then(other.second.cmp(&self.second))
    }
}

impl PartialOrd for Pair {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

/// Algorithm 1: the pair with the smallest angle is merged if it may be, until no pair is left.
fn merge(patches: Vec<Patch>, parameters: &DetectionParameters, noise: f64) -> Vec<Patch> {
    let angle = parameters.merge_angle.clamp(0.0, 45.0).to_radians();
    let mut patches: Vec<Option<Patch>> = patches.into_iter().map(Some).collect();
    let mut queue = BinaryHeap::new();
    let pair = |first: usize, a: &Patch, second: usize, b: &Patch| {
        let cosine = a.plane.normal.dot(&b.plane.normal).abs();
        let excuse = 2.0 * (a.tilt_error(noise) + b.tilt_error(noise));
        let limit = (angle + excuse).min(MOST_ANGLE.max(angle));
        (cosine > limit.cos()).then_some(Pair { cosine, first, second })
    };
    for (j, b) in patches.iter().enumerate() {
        for (i, a) in patches[..j].iter().enumerate() {
            queue.extend(a.as_ref().zip(b.as_ref()).and_then(|(a, b)| pair(i, a, j, b)));
        }
    }
    while let Some(Pair { first, second, .. }) = queue.pop() {
        // A patch that is gone was merged with another before: lazy deletion.
        let (Some(a), Some(b)) = (&patches[first], &patches[second]) else { continue };
        let Some(merged) = try_merge(a, b, parameters, noise) else { continue };
        (patches[first], patches[second]) = (None, None);
        let index = patches.len();
        for (i, other) in patches.iter().enumerate() {
            queue.extend(other.as_ref().and_then(|other| pair(i, other, index, &merged)));
        }
        patches.push(Some(merged));
    }
    patches.into_iter().flatten().collect()
}

/// The merged patch, if the two are close and the merged plane bears both.
fn try_merge(a: &Patch, b: &Patch, parameters: &DetectionParameters, noise: f64) -> Option<Patch> {
    let between = a.moments.mean() - b.moments.mean();
    // The mean of both normals by their certainty (antiparallel walls are parallel), so that a small patch with a poor
    // normal is measured along the good one of the large patch, whichever comes first.
    let [weight_a, weight_b] = [a, b].map(|patch| patch.tilt_error(noise).powi(-2));
    let sign = a.plane.normal.dot(&b.plane.normal).signum();
    let normal = a.plane.normal.into_inner() * weight_a + b.plane.normal.into_inner() * (sign * weight_b);
    let apart = between.dot(&normal.normalize()).abs();
    let tilt = (weight_a + weight_b).sqrt().recip();
    let slack = parameters.merge_tolerance.max(0.0);
    // A normal that is off by twice its standard error moves a plane by so much at the other patch.
    if apart > (3.0 * noise).max(2.0 * slack) + 2.0 * tilt * between.norm() {
        return None;
    }
    let mut moments = a.moments;
    moments.merge(&b.moments);
    let fit = moments.fit()?;
    let bears = a.bears(&fit.plane, slack, noise) && b.bears(&fit.plane, slack, noise);
    bears.then(|| a.join(b, fit.plane, &fit))
}
