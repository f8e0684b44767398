//! Detection from raw points to refined primitives.

use nalgebra::{Point3, Unit, Vector3};

use super::cloud::{Cloud, Thinned};
use super::moments::Moments;
use super::moving_least_squares::Carried;
use super::neighbours::Neighbours;
use super::normals::LocalPlanes;
use super::parameters::{DetectionParameters, Detector};
use super::refine::{Patch, refine_patches};
use super::segmentation::{NONE, Segmentation, Tolerances};
use super::{Primitive, noisy, ransac, region_growing};
use crate::geometry::Plane;
use crate::reconstruct::Parameters;

/// Neighbourhoods never grow beyond this.
const MOST_NEIGHBOURS: usize = 64;

/// What was detected in the points of a building.
#[derive(Debug, Clone, PartialEq)]
pub struct Detection {
    /// The primitives, refined, ordered by the number of their inliers, largest first. No point is in two of them.
    pub primitives: Vec<Primitive>,
    /// The normal of each point of the input, pointing up; vertical for a point without a neighbourhood.
    pub normals: Vec<Unit<Vector3<f64>>>,
    /// Standard deviation of the points across the surfaces they sample, metres; at least 0.01.
    pub noise: f64,
    /// Median density of the points on the surfaces they sample, per square metre; 0 for fewer than two points. Of a
    /// cloud that was thinned, the density after thinning.
    pub density: f64,
    /// Indices of the points that belong to no primitive, ascending.
    pub unassigned: Vec<u32>,
}

/// Detects the planar primitives of a building and refines them.
///
/// Any input is answered: of points that bear no plane, no primitive comes. The result depends on the set of points,
/// not on their order (up to the indices), and for RANSAC on `seed`. Exact duplicates share a primitive; points that
/// are not finite are in none.
pub fn detect(points: &[Point3<f64>], parameters: &Parameters, seed: u64) -> Detection {
    detect_up_to(Stage::Refined, points, parameters, seed)
}

/// The primitives as the detector finds them, before any is merged or regularised: what [`detect`] begins with.
pub fn found_at_first(points: &[Point3<f64>], parameters: &Parameters, seed: u64) -> Detection {
    detect_up_to(Stage::Found, points, parameters, seed)
}

/// How far detection goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stage {
    /// As the detector finds them.
    Found,
    /// Merged and regularised.
    Refined,
}

fn detect_up_to(stage: Stage, points: &[Point3<f64>], parameters: &Parameters, seed: u64) -> Detection {
    let parameters = &parameters.detection;
    let cloud = Cloud::new(points);
    let thinned = cloud.thin(parameters.maximum_density);
    let sample: Vec<Point3<f64>> = match &thinned {
        Some(thinned) => thinned.keepers.iter().map(|&i| cloud.points[i as usize]).collect(),
        None => cloud.points.clone(),
    };
    let (neighbours, local, is_clear) = local_planes(&sample, parameters);
    if !is_clear && let Some(carried) = Carried::new(&cloud.points) {
        return noisy::detect(stage, points, &cloud, &carried, parameters, seed);
    }
    let tolerances = Tolerances::new(parameters, local.noise, neighbours.density(), neighbours.width());
    let mut segmentation = found(&sample, &neighbours, &local, &tolerances, parameters, seed);
    if stage == Stage::Refined {
        segmentation = refined(&sample, &segmentation, parameters, local.noise);
        // Planes have moved a little: let the points near borders choose again.
        segmentation.settle_borders(&sample, &neighbours, &tolerances);
    }
    let labels = match &thinned {
        Some(thinned) => spread(&cloud, thinned, &segmentation, &neighbours, &tolerances),
        None => segmentation.labels,
    };
    let primitives = primitives(points, &cloud, &labels, &segmentation.planes, parameters);
    let normal_of = |i: usize| {
        let slot = thinned.as_ref().map_or(i, |thinned| thinned.representative[i] as usize);
        local.planes[slot].normal
    };
    Detection::new(points, &cloud, primitives, normal_of, local.noise, neighbours.density())
}

/// What the detector finds.
pub(super) fn found(
    sample: &[Point3<f64>],
    neighbours: &Neighbours,
    local: &LocalPlanes,
    tolerances: &Tolerances,
    parameters: &DetectionParameters,
    seed: u64,
) -> Segmentation {
    match parameters.detector {
        Detector::RegionGrowing => region_growing::segment(sample, neighbours, local, tolerances),
        Detector::Ransac => ransac::segment(sample, neighbours, local, tolerances, parameters.probability, seed),
    }
}

/// The primitives of labelled points of a cloud, largest first.
pub(super) fn primitives(
    points: &[Point3<f64>],
    cloud: &Cloud,
    labels: &[u32],
    planes: &[Plane],
    parameters: &DetectionParameters,
) -> Vec<Primitive> {
    let mut members = vec![Vec::new(); planes.len()];
    for (i, &label) in labels.iter().enumerate() {
        if let Some(members) = members.get_mut(label as usize) {
            members.extend_from_slice(cloud.originals(i));
        }
    }
    let mut primitives: Vec<Primitive> = members
        .into_iter()
        .zip(planes)
        .filter(|(members, _)| members.len() >= parameters.minimum_inliers.max(3))
        .filter_map(|(members, plane)| Primitive::on_plane(*plane, points, members))
        .collect();
    primitives.sort_by(|a, b| {
        let height = |p: &Primitive| p.plane.offset;
        b.inliers.len().cmp(&a.inliers.len()).then(height(a).total_cmp(&height(b)))
    });
    primitives
}

impl Detection {
    /// With the normals that `normal_of` gives for the points of the cloud.
    pub(super) fn new(
        points: &[Point3<f64>],
        cloud: &Cloud,
        primitives: Vec<Primitive>,
        normal_of: impl Fn(usize) -> Unit<Vector3<f64>>,
        noise: f64,
        density: f64,
    ) -> Self {
        let mut is_free = vec![true; points.len()];
        primitives.iter().flat_map(|p| &p.inliers).for_each(|&i| is_free[i as usize] = false);
        let unassigned = (0u32..).zip(is_free).filter_map(|(i, free)| free.then_some(i)).collect();
        let mut normals = vec![Vector3::z_axis(); points.len()];
        for i in 0..cloud.points.len() {
            let normal = normal_of(i);
            cloud.originals(i).iter().for_each(|&original| normals[original as usize] = normal);
        }
        Self { primitives, normals, noise, density, unassigned }
    }
}

/// Neighbours and local planes, from as many neighbours as the noise asks for, and whether they were enough of them.
pub(super) fn local_planes(
    points: &[Point3<f64>],
    parameters: &DetectionParameters,
) -> (Neighbours, LocalPlanes, bool) {
    /// Largest standard error of a slope that still tells a roof from its neighbour, radians (6°).
    const SLOPE_ERROR: f64 = 0.1;
    /// Largest noise, relative to the spread of a neighbourhood, at which principal components tell them apart: where
    /// the two are alike, the noise is underestimated and the normal means nothing.
    const NOISE_TO_SPREAD: f64 = 0.5;
    let mut k = parameters.neighbours.clamp(4, 64);
    loop {
        let neighbours = Neighbours::new(points, k);
        let local = LocalPlanes::estimate(points, &neighbours, None);
        let (slope_error, spread) = local.quality(&neighbours);
        let enough = slope_error <= SLOPE_ERROR && local.noise <= NOISE_TO_SPREAD * spread;
        if enough || k >= MOST_NEIGHBOURS || neighbours.width() < k {
            return (neighbours, local, enough);
        }
        k = (k * 8 / 5).min(MOST_NEIGHBOURS);
    }
}

/// The segmentation after Algorithm 1 and regularisation.
pub(super) fn refined(
    points: &[Point3<f64>],
    found: &Segmentation,
    parameters: &DetectionParameters,
    noise: f64,
) -> Segmentation {
    let mut refined = Segmentation::empty(points.len());
    let Some(&anchor) = points.first() else { return refined };
    let patches: Vec<Patch> = found
        .members()
        .into_iter()
        .filter_map(|members| Patch::new(Moments::of(anchor, points, &members), members))
        .collect();
    for patch in refine_patches(patches, parameters, noise) {
        refined.push(&patch.members, patch.plane);
    }
    refined
}

/// Labels for the whole cloud from those of its thinned sample: each point joins the plane nearest to it among those
/// of its representative and the neighbours of that.
fn spread(
    cloud: &Cloud,
    thinned: &Thinned,
    segmentation: &Segmentation,
    neighbours: &Neighbours,
    tolerances: &Tolerances,
) -> Vec<u32> {
    let label_of = |(point, &slot): (&Point3<f64>, &u32)| {
        let near = std::iter::once(slot).chain(neighbours.of(slot).iter().copied());
        near.map(|slot| segmentation.labels[slot as usize])
            .filter_map(|label| Some((segmentation.planes.get(label as usize)?.distance(point).abs(), label)))
            .filter(|(distance, _)| *distance <= tolerances.border)
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map_or(NONE, |(_, label)| label)
    };
    let mut labels: Vec<u32> = cloud.points.iter().zip(&thinned.representative).map(label_of).collect();
    for (&keeper, &label) in thinned.keepers.iter().zip(&segmentation.labels) {
        labels[keeper as usize] = label;
    }
    labels
}
