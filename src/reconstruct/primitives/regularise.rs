//! Gentle regularisation: flat roofs become horizontal, walls vertical, slopes parallel or symmetric, wherever the
//! points allow it. Models get compact by it: planes that are one meet in one, and ridges are level.

use nalgebra::{Unit, Vector3};

use super::parameters::DetectionParameters;
use super::refine::Patch;
use crate::geometry::Plane;

/// Uncertain normals of small patches may excuse no more than this, radians.
const MOST_EXCUSE: f64 = 0.2;
/// The least slope that has an azimuth worth comparing, radians.
const LEAST_SLOPE: f64 = 0.09;

/// Regularises patches that are ordered by support: the larger gives the direction.
pub(super) fn regularise(patches: &mut Vec<Patch>, parameters: &DetectionParameters, noise: f64) {
    let slack = parameters.regularise_tolerance.max(0.0);
    let level = parameters.horizontal_slope.clamp(0.0, 10.0).to_radians();
    if level > 0.0 {
        for patch in patches.iter_mut() {
            upright(patch, level, slack, noise);
        }
        join_levels(patches, parameters.merge_tolerance.max(0.0), noise);
    }
    let angle = parameters.regularise_angle.clamp(0.0, 10.0).to_radians();
    if angle > 0.0 {
        align(patches, angle, slack, noise);
    }
}

/// Makes a plane horizontal or vertical if it is nearly so and its points allow it.
fn upright(patch: &mut Patch, angle: f64, slack: f64, noise: f64) {
    let limit = angle + (2.0 * patch.tilt_error(noise)).min(MOST_EXCUSE);
    let n = patch.plane.normal;
    let target = if n.xy().norm() <= limit.sin() {
        Some(Vector3::z_axis())
    } else if n.z.abs() <= limit.sin() {
        Unit::try_new(Vector3::new(n.x, n.y, 0.0), 1e-9)
    } else {
        None
    };
    if let Some(normal) = target {
        adopt(patch, normal, slack, noise);
    }
}

/// Gives a patch the plane through its mean with this normal, if that leaves no point by more than `slack` metres, up to
/// what the noise makes of its own plane.
fn adopt(patch: &mut Patch, normal: Unit<Vector3<f64>>, slack: f64, noise: f64) -> bool {
    let plane = Plane::through(&patch.moments.mean(), normal);
    // A plane that turns about its middle goes off most at its ends: √3 times the root mean square.
    let bears = patch.bears(&plane, slack / 3f64.sqrt(), noise);
    if bears {
        patch.plane = plane;
    }
    bears
}

fn is_level(patch: &Patch) -> bool {
    patch.plane.normal.z == 1.0
}

/// Merges horizontal planes at the same height within the noise, the closest first.
fn join_levels(patches: &mut Vec<Patch>, slack: f64, noise: f64) {
    loop {
        let mut levels: Vec<usize> = (0..patches.len()).filter(|&i| is_level(&patches[i])).collect();
        levels.sort_by(|&a, &b| patches[a].plane.offset.total_cmp(&patches[b].plane.offset).then(a.cmp(&b)));
        let best = levels
            .windows(2)
            .filter_map(|pair| {
                let (a, b) = (&patches[pair[0]], &patches[pair[1]]);
                let mut moments = a.moments;
                moments.merge(&b.moments);
                let plane = Plane::through(&moments.mean(), Vector3::z_axis());
                let joined = a.join(b, plane, &moments.fit()?);
                let gap = (a.plane.offset - b.plane.offset).abs();
                joined.bears(&plane, slack, noise).then_some((gap, pair[0], pair[1], joined))
            })
            .min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((_, a, b, joined)) = best else { return };
        patches[a.min(b)] = joined;
        patches.remove(a.max(b));
    }
}

/// Turns slopes and walls towards the directions of larger ones: the same plane direction, its mirror image, or a
/// quarter turn of it; failing that, the same azimuth with its own slope.
fn align(patches: &mut [Patch], angle: f64, slack: f64, noise: f64) {
    let mut references: Vec<Vector3<f64>> = Vec::new();
    for patch in patches {
        let n = patch.plane.normal.into_inner();
        let run = n.xy().norm();
        if run < LEAST_SLOPE.sin() {
            continue;
        }
        let limit = angle + (2.0 * patch.tilt_error(noise)).min(MOST_EXCUSE);
        let turned = |r: &Vector3<f64>| {
            let r = *r;
            [r, Vector3::new(-r.x, -r.y, r.z), Vector3::new(-r.y, r.x, r.z), Vector3::new(r.y, -r.x, r.z)]
        };
        let with_own_slope = |r: Vector3<f64>| {
            let scale = run / r.xy().norm();
            Vector3::new(r.x * scale, r.y * scale, n.z)
        };
        let near = |target: &Vector3<f64>| target.dot(&n) >= limit.cos();
        // Turned copies of a unit vector are unit vectors; normalising again would make them differ in the last bit.
        let mut same = references.iter().flat_map(turned).filter(near).map(Unit::new_unchecked);
        if same.any(|normal| adopt(patch, normal, slack, noise)) {
            continue;
        }
        let azimuth = references.iter().flat_map(turned).map(with_own_slope).filter(near);
        azimuth.map(Unit::new_normalize).any(|normal| adopt(patch, normal, slack, noise));
        references.push(patch.plane.normal.into_inner());
    }
}
