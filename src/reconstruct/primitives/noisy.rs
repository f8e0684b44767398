//! Detection in clouds whose noise hides the normals: among points that were carried onto the surface, and then in all.
//!
//! What is found among the carried points is refitted to all points, which choose among the planes around them. A plane
//! stays only if it pays for itself, by the length of a description of the points (minimum description length): what
//! they lie farther from the planes around it, in nats of the noise, against its three parameters and the bounds of its
//! region. So noise makes no planes, and the bevels that smoothing leaves along edges go.

use std::collections::BTreeSet;
use std::num::NonZero;

use kiddo::{ImmutableKdTree, SquaredEuclidean};
use nalgebra::{Point3, Unit, Vector3};

use super::cloud::Cloud;
use super::detect::{Detection, Stage, found, local_planes, primitives, refined};
use super::moments::Moments;
use super::moving_least_squares::Carried;
use super::normals::LocalPlanes;
use super::parameters::DetectionParameters;
use super::segmentation::{NONE, Segmentation, Tolerances};
use crate::geometry::Plane;

/// So many carried points around a point say which planes are near.
const AROUND: usize = 12;
/// A point is of a plane up to this many standard deviations of the noise.
const TOLERANCE: f64 = 3.0;
/// What a point of a plane must gain by it, nats: the price of the bounds of its region. Bevels gain half of it, true faces
/// several times as much.
const PER_POINT: f64 = 0.2;

/// What a point of two planes must gain by their being two, nats: points of one plane that are parted into those above and
/// those below it gain 1/π, by noise alone.
const LAYERS: f64 = 0.4;

/// Detects the primitives of `points`, of which `cloud` holds the distinct ones and `carried` a sample.
pub(super) fn detect(
    stage: Stage,
    points: &[Point3<f64>],
    cloud: &Cloud,
    carried: &Carried,
    parameters: &DetectionParameters,
    seed: u64,
) -> Detection {
    // What is smaller than a neighbourhood is smoothed away, or was made by noise.
    let least = std::f64::consts::PI * carried.radius.powi(2) / 2.0;
    let coarse = DetectionParameters { minimum_area: parameters.minimum_area.max(least), ..parameters.clone() };
    let (neighbours, local, _) = local_planes(&carried.points, &coarse);
    let tolerances = Tolerances::new(&coarse, local.noise, neighbours.density(), neighbours.width());
    let segmentation = found(&carried.points, &neighbours, &local, &tolerances, &coarse, seed);
    let reach = (TOLERANCE * carried.noise).min(parameters.maximum_tolerance.max(parameters.minimum_tolerance));
    let mut nearby = Nearby::new(cloud, carried, segmentation.labels, reach);
    let settled = nearby.settle(cloud, segmentation.planes, carried.noise);
    let whole = match stage {
        Stage::Found => settled,
        Stage::Refined => refined(&cloud.points, &settled, &coarse, carried.noise),
    };
    let primitives = primitives(points, cloud, &whole.labels, &whole.planes, parameters);
    let density = cloud.points.len() as f64 / carried.points.len().max(1) as f64 * neighbours.density();
    Detection::new(points, cloud, primitives, |i| nearby.normal(i, &local), carried.noise, density)
}

/// The carried points around each point of a cloud, and their planes.
struct Nearby<'a> {
    width: usize,
    /// For each point of the cloud so many carried points, nearest first.
    slots: Vec<u32>,
    places: &'a [Point3<f64>],
    /// The plane of each carried point.
    labels: Vec<u32>,
    /// A point is of a plane up to this far from it, metres.
    reach: f64,
}

impl<'a> Nearby<'a> {
    fn new(cloud: &Cloud, carried: &'a Carried, labels: Vec<u32>, reach: f64) -> Self {
        let coordinates: Vec<[f64; 3]> = carried.points.iter().map(|p| [p.x, p.y, p.z]).collect();
        let mut nearby = Self { width: 0, slots: Vec::new(), places: &carried.points, labels, reach };
        let width = AROUND.min(coordinates.len());
        let (Ok(tree), Some(quantity)) = (ImmutableKdTree::<f64, 3>::new_from_slice(&coordinates), NonZero::new(width))
        else {
            return nearby;
        };
        nearby.width = width;
        nearby.slots.reserve_exact(width * cloud.points.len());
        for p in &cloud.points {
            let mut near = tree.query(&[p.x, p.y, p.z]).nearest_n::<SquaredEuclidean<f64>>(quantity).execute();
            near.sort_unstable_by(|a, b| a.distance.total_cmp(&b.distance).then(a.item.cmp(&b.item)));
            let start = nearby.slots.len();
            nearby.slots.extend(near.iter().take(width).map(|near| near.item));
            // A tree that found fewer would shift everything behind.
            let last = nearby.slots.last().copied().unwrap_or(0);
            nearby.slots.resize(start + width, last);
        }
        nearby
    }

    fn around(&self, point: usize) -> &[u32] {
        &self.slots[point * self.width..(point + 1) * self.width]
    }

    fn normal(&self, point: usize, local: &LocalPlanes) -> Unit<Vector3<f64>> {
        let plane = self.around(point).first().and_then(|&slot| local.planes.get(slot as usize));
        plane.map_or(Vector3::z_axis(), |plane| plane.normal)
    }

    /// Lets points choose and planes be refitted, and gives up the plane that pays least for itself, until all pay.
    fn settle(&mut self, cloud: &Cloud, mut planes: Vec<Plane>, noise: f64) -> Segmentation {
        /// Rounds of choosing and refitting before the planes are weighed.
        const ROUNDS: usize = 2;
        loop {
            for _ in 0..ROUNDS {
                planes = self.choose(cloud, &planes).refitted(&cloud.points);
            }
            let whole = self.choose(cloud, &planes);
            let beside = self.beside(&whole);
            if let Some((first, second, plane)) = layers(cloud, &whole, &beside, noise) {
                planes[first as usize] = plane;
                self.labels.iter_mut().filter(|label| **label == second).for_each(|label| *label = first);
                continue;
            }
            let Some(worst) = worst(cloud, &whole, &beside, noise) else { return whole };
            let around = &beside[worst as usize];
            for (place, own) in self.places.iter().zip(&mut self.labels).filter(|(_, own)| **own == worst) {
                let distances = around.iter().map(|&label| (planes[label as usize].distance(place).abs(), label));
                let nearest = distances.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
                *own = nearest.map_or(NONE, |(_, label)| label);
            }
        }
    }

    /// Every point takes the nearest of the planes around it, if one is near enough.
    fn choose(&self, cloud: &Cloud, planes: &[Plane]) -> Segmentation {
        let choice = |(i, point): (usize, &Point3<f64>)| {
            let around = self.around(i).iter().map(|&slot| self.labels[slot as usize]);
            around
                .filter_map(|label| Some((planes.get(label as usize)?.distance(point).abs(), label)))
                .filter(|(distance, _)| *distance <= self.reach)
                .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
                .map_or(NONE, |(_, label)| label)
        };
        Segmentation { labels: cloud.points.iter().enumerate().map(choice).collect(), planes: planes.to_vec() }
    }

    /// For each plane those of the carried points around its points.
    fn beside(&self, whole: &Segmentation) -> Vec<BTreeSet<u32>> {
        let mut beside = vec![BTreeSet::new(); whole.planes.len()];
        for (i, &own) in whole.labels.iter().enumerate().filter(|(_, own)| **own != NONE) {
            for other in self.around(i).iter().map(|&slot| self.labels[slot as usize]) {
                if other != own && other != NONE {
                    beside[own as usize].insert(other);
                    beside[other as usize].insert(own);
                }
            }
        }
        beside
    }
}

/// The two planes beside each other that gain least by being two, if any gain too little, and the plane of both.
fn layers(cloud: &Cloud, whole: &Segmentation, beside: &[BTreeSet<u32>], noise: f64) -> Option<(u32, u32, Plane)> {
    let anchor = *cloud.points.first()?;
    let moments: Vec<Moments> = whole.members().iter().map(|m| Moments::of(anchor, &cloud.points, m)).collect();
    let squares = |moments: &Moments| moments.fit().map(|fit| (moments.count() * fit.rms * fit.rms, fit.plane));
    let own: Vec<Option<f64>> = moments.iter().map(|moments| squares(moments).map(|(squares, _)| squares)).collect();
    let mut best: Option<(f64, u32, u32, Plane)> = None;
    for (a, others) in (0u32..).zip(beside) {
        for &b in others.range(a + 1..) {
            let mut both = moments[a as usize];
            both.merge(&moments[b as usize]);
            let (Some(one), Some(other), Some((joint, plane))) = (own[a as usize], own[b as usize], squares(&both))
            else {
                continue;
            };
            let count = both.count();
            let gain = (joint - one - other) / (2.0 * noise * noise * count) - LAYERS - 1.5 * count.ln() / count;
            if gain < 0.0 && best.as_ref().is_none_or(|best| gain < best.0) {
                best = Some((gain, a, b, plane));
            }
        }
    }
    best.map(|(_, a, b, plane)| (a, b, plane))
}

/// The plane that pays least for itself, if one does not.
fn worst(cloud: &Cloud, whole: &Segmentation, beside: &[BTreeSet<u32>], noise: f64) -> Option<u32> {
    // Of a point that is of no plane, so much is told at most.
    let most = TOLERANCE * TOLERANCE / 2.0;
    let cost = |plane: u32, point: &Point3<f64>| {
        let distance = whole.planes[plane as usize].distance(point) / noise;
        (distance * distance / 2.0).min(most)
    };
    let gain = |(plane, members): (u32, Vec<u32>)| {
        let gains = members.iter().map(|&i| {
            let point = &cloud.points[i as usize];
            let others = beside[plane as usize].iter().map(|&other| cost(other, point));
            others.fold(most, f64::min) - cost(plane, point)
        });
        let count = members.len() as f64;
        let price = 1.5 * count.ln() + PER_POINT * count;
        (count > 0.0).then(|| ((gains.sum::<f64>() - price) / count, plane))
    };
    let weighed = (0u32..).zip(whole.members()).filter_map(gain);
    let (least, worst) = weighed.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))?;
    (least < 0.0).then_some(worst)
}
