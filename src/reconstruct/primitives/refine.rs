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

/// Planes with more verticality than this are walls (paper, section 3.2).
const WALL_VERTICALITY: f64 = 0.9;
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
    // Roofs sag and are tiled; walls that stand at an angle are two, however small it is.
    let stand = [a, b].iter().all(|patch| patch.plane.verticality() > WALL_VERTICALITY);
    let most = if stand { 2.0 * noise } else { f64::INFINITY };
    let slack = parameters.merge_tolerance.clamp(0.0, most);
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Points of a grid of 0.5 m over a rectangle on the plane z = height + slope · x, ±`ripple` in turns.
    fn grid(x: [f64; 2], y: [f64; 2], height: f64, slope: f64, ripple: f64) -> Vec<Point3<f64>> {
        let steps =
            |range: [f64; 2]| (0..((range[1] - range[0]) * 2.0) as u32).map(move |i| range[0] + f64::from(i) / 2.0);
        let mut sign = ripple;
        let mut points = Vec::new();
        for px in steps(x) {
            for py in steps(y) {
                points.push(Point3::new(px, py, height + slope * px + sign));
                sign = -sign;
            }
            sign = -sign;
        }
        points
    }

    fn refined(parts: &[Vec<Point3<f64>>], parameters: &DetectionParameters, noise: f64) -> Vec<Primitive> {
        let points = parts.concat();
        let mut start = 0;
        let primitives = parts
            .iter()
            .map(|part| {
                let inliers = (start..start + part.len() as u32).collect();
                start += part.len() as u32;
                Primitive::from_inliers(&points, inliers).unwrap()
            })
            .collect();
        refine(&points, primitives, parameters, noise)
    }

    fn merge_only() -> DetectionParameters {
        DetectionParameters { horizontal_slope: 0.0, regularise_angle: 0.0, ..DetectionParameters::default() }
    }

    #[test]
    fn coplanar_wings_merge_even_when_far_apart() {
        let wings = [
            grid([0.0, 6.0], [0.0, 8.0], 5.0, 0.5, 0.02),
            grid([10.0, 14.0], [30.0, 36.0], 5.0, 0.5, 0.02),
            grid([0.0, 6.0], [60.0, 64.0], 5.0, 0.5, 0.02),
        ];
        let [one] = &refined(&wings, &merge_only(), 0.02)[..] else { panic!("one plane") };
        assert_eq!(one.inliers.len(), 192 + 96 + 96);
        assert!((one.plane.height_at(20.0, 0.0).unwrap() - 15.0).abs() < 0.01);
        assert!((one.residual - 0.02 / 1.25f64.sqrt()).abs() < 0.002, "{}", one.residual);
    }

    #[test]
    fn large_patches_with_a_slight_tilt_do_not_merge_into_a_bad_fit() {
        // 1.7° between them, well below θ = 10°, and they meet at x = 20; but the best plane through both leaves a V of
        // ±0.015 over 20 m on each side: 0.015 · 20 m / √12 = 8.7 cm root mean square, above the tolerance of 7 cm.
        let halves = [grid([0.0, 20.0], [0.0, 8.0], 5.0, 0.0, 0.02), grid([20.0, 40.0], [0.0, 8.0], 4.4, 0.03, 0.02)];
        assert_eq!(refined(&halves, &merge_only(), 0.02).len(), 2);
        // A tenth of that tilt is within the tolerance of 7 cm.
        let halves = [grid([0.0, 20.0], [0.0, 8.0], 5.0, 0.0, 0.02), grid([20.0, 40.0], [0.0, 8.0], 4.94, 0.003, 0.02)];
        assert_eq!(refined(&halves, &merge_only(), 0.02).len(), 1);
    }

    #[test]
    fn the_result_does_not_depend_on_which_comes_first() {
        // A small patch with a poor normal beside a large one: the reference code asks the first one's normal only.
        let large = grid([0.0, 20.0], [0.0, 10.0], 5.0, 0.0, 0.02);
        let small = grid([24.0, 25.0], [4.0, 6.0], 5.0 - 0.06 * 24.0, 0.06, 0.0);
        for parts in [[large.clone(), small.clone()], [small, large]] {
            let [one] = &refined(&parts, &merge_only(), 0.02)[..] else { panic!("one plane") };
            assert_eq!(one.inliers.len(), 800 + 8);
        }
    }

    #[test]
    fn a_step_stays_and_a_gable_stays() {
        let step = [grid([0.0, 8.0], [0.0, 8.0], 5.0, 0.0, 0.02), grid([8.0, 16.0], [0.0, 8.0], 5.3, 0.0, 0.02)];
        assert_eq!(refined(&step, &DetectionParameters::default(), 0.02).len(), 2);
        let gable = [grid([0.0, 4.0], [0.0, 8.0], 5.0, 0.05, 0.0), grid([4.0, 8.0], [0.0, 8.0], 5.4, -0.05, 0.0)];
        assert_eq!(refined(&gable, &merge_only(), 0.01).len(), 1, "5.7° and 4 cm: one plane for Algorithm 1");
        let gable = [grid([0.0, 4.0], [0.0, 8.0], 5.0, 0.3, 0.0), grid([4.0, 8.0], [0.0, 8.0], 7.4, -0.3, 0.0)];
        assert_eq!(refined(&gable, &DetectionParameters::default(), 0.01).len(), 2);
    }

    #[test]
    fn flat_roofs_become_horizontal_and_drained_halls_do_not() {
        // A fall of 2.5 cm over 5 m: no point leaves the level plane by more than 2 cm.
        let flat = [grid([0.0, 5.0], [0.0, 8.0], 5.0, 0.005, 0.02)];
        assert_eq!(refined(&flat, &DetectionParameters::default(), 0.02)[0].plane.normal.z, 1.0);
        // 0.6° over 40 m is a fall of 40 cm, 12 cm root mean square: the points forbid it.
        let hall = [grid([0.0, 40.0], [0.0, 8.0], 5.0, 0.01, 0.02)];
        let [hall] = &refined(&hall, &DetectionParameters::default(), 0.02)[..] else { panic!() };
        assert!((hall.plane.normal.x + 0.01).abs() < 1e-3, "{:?}", hall.plane);
    }

    #[test]
    fn slopes_become_symmetric_where_it_costs_nothing() {
        // 30° on one side and 29.4° on the other.
        let (a, b) = (30f64.to_radians().tan(), 29.4f64.to_radians().tan());
        let gable =
            [grid([0.0, 4.0], [0.0, 8.0], 5.0, a, 0.02), grid([4.0, 7.5], [0.0, 8.0], 5.0 + 4.0 * (a + b), -b, 0.02)];
        let [one, other] = &refined(&gable, &DetectionParameters::default(), 0.02)[..] else { panic!("two planes") };
        let (n, m) = (one.plane.normal, other.plane.normal);
        assert!((n.x + m.x).abs() < 1e-12 && (n.y + m.y).abs() < 1e-12 && n.z == m.z, "{n:?} {m:?}");
        // 5° apart is another roof.
        let b = 25f64.to_radians().tan();
        let gable =
            [grid([0.0, 4.0], [0.0, 8.0], 5.0, a, 0.02), grid([4.0, 7.5], [0.0, 8.0], 5.0 + 4.0 * (a + b), -b, 0.02)];
        let [one, other] = &refined(&gable, &DetectionParameters::default(), 0.02)[..] else { panic!("two planes") };
        assert!((one.plane.slope_degrees() - other.plane.slope_degrees() - 5.0).abs() < 0.5);
    }

    #[test]
    fn a_wall_turns_to_the_slope_above_it_only_as_far_as_its_points_allow() {
        let roof = grid([0.0, 10.0], [0.0, 9.0], 5.0, 0.5, 0.001);
        // 9 m long: turned by 1° its ends would move by 8 cm, by 0.1° by 8 mm.
        for (degrees, is_turned) in [(1.0_f64, false), (0.1, true)] {
            let at = |y: f64, z: f64| Point3::new(y * degrees.to_radians().tan(), y, z);
            let wall: Vec<_> = (0..18).flat_map(|i| (0..10).map(move |j| (f64::from(i), f64::from(j)))).collect();
            let wall: Vec<_> = wall.into_iter().map(|(i, j)| at(0.5 * i, 0.5 * j)).collect();
            let found = refined(&[roof.clone(), wall.clone()], &DetectionParameters::default(), 0.001);
            let plane = &found.iter().find(|primitive| primitive.plane.normal.z.abs() < 0.1).unwrap().plane;
            assert_eq!(plane.normal.y.abs() < 1e-9, is_turned, "{degrees}°: {plane:?}");
            assert!(wall.iter().all(|point| plane.distance(point).abs() <= 0.02), "{degrees}°: {plane:?}");
        }
    }

    #[test]
    fn what_was_not_detected_passes_through() {
        let mut wall = Primitive::from_inliers(&grid([0.0, 4.0], [0.0, 4.0], 5.0, 0.0, 0.0), vec![0, 1, 20]).unwrap();
        wall.kind = PrimitiveKind::FootprintEdge;
        wall.inliers.clear();
        assert_eq!(refine(&[], vec![wall.clone()], &DetectionParameters::default(), 0.02), [wall]);
    }
}
