//! Points of a noisy cloud carried onto the surface that they sample, by moving least squares.
//!
//! Where the noise is several times the spacing of the points, as in clouds from image matching, the nearest neighbours of
//! a point lie around it on all sides and tell no normal. Here a neighbourhood grows until it is wider than the noise; a
//! few points, evenly spread, are carried onto the planes of theirs, and what is detected among them is believed of all.

use std::collections::BTreeMap;
use std::num::NonZero;

use kiddo::{ImmutableKdTree, SquaredEuclidean};
use nalgebra::Point3;

use super::moments::{Fit, Moments};

/// A neighbourhood is wide enough when the noise is at most this share of its standard deviation along the surface: it
/// then reaches over four standard deviations of the noise around its centre.
const NOISE_TO_SPREAD: f64 = 0.7;
/// The ends of a neighbourhood cut the tails of the noise off: measured in one, it is so much too small.
const TAILS: f64 = 1.1;
/// Neighbourhoods are tried from this many points on, each larger than the last by [`GROWTH`].
const SMALLEST: usize = 64;
const GROWTH: f64 = 1.5;
/// No neighbourhood holds more than this share of the cloud: it would tell the whole of the building, not its parts.
const LARGEST: f64 = 0.1;
/// Neighbourhoods that are looked at for the noise.
const PROBES: usize = 100;
/// Points that are carried: one for each cube of this many standard deviations of the noise …
const SPACING: f64 = 1.5;
/// … but not more than this.
const MOST: usize = 4_000;
/// How often a point is carried; the second time its neighbourhood is that of its place on the surface.
const ROUNDS: usize = 2;
/// Neighbours farther than this from the plane of the others are of another surface, in standard deviations.
const SAME_SURFACE: f64 = 2.5;

/// A sample of a cloud, carried onto the surface.
#[derive(Debug, Clone)]
pub(super) struct Carried {
    /// The points of the sample on the surface, ordered by the box that they stand for.
    pub points: Vec<Point3<f64>>,
    /// Standard deviation of the whole cloud across the surface, metres.
    pub noise: f64,
    /// Radius of the neighbourhoods, metres: what is smaller is lost in the noise.
    pub radius: f64,
}

impl Carried {
    /// Carries some of the points of a cloud, which are distinct. `None` where too few of them are there to tell.
    pub fn new(points: &[Point3<f64>]) -> Option<Self> {
        let coordinates: Vec<[f64; 3]> = points.iter().map(|p| [p.x, p.y, p.z]).collect();
        let tree = ImmutableKdTree::<f64, 3>::new_from_slice(&coordinates).ok()?;
        let around = |place: &Point3<f64>, count: usize| -> Vec<u32> {
            let Some(count) = NonZero::new(count) else { return Vec::new() };
            let near = tree.query(&[place.x, place.y, place.z]).nearest_n::<SquaredEuclidean<f64>>(count).execute();
            near.iter().map(|near| near.item).collect()
        };
        let largest = (points.len() as f64 * LARGEST) as usize;
        let (mut count, mut noise, mut radius) = (SMALLEST, 0.0, 0.0);
        while count <= largest {
            let step = points.len().div_ceil(PROBES).max(1);
            let fits: Vec<Fit> =
                points.iter().step_by(step).filter_map(|p| Moments::of(*p, points, &around(p, count)).fit()).collect();
            noise = rank(fits.iter().map(|fit| fit.rms), 0.4)?;
            let spread = rank(fits.iter().map(|fit| fit.width), 0.5)?;
            // A disc of radius r has a standard deviation of r/2 along each axis.
            radius = 2.0 * spread;
            if noise <= NOISE_TO_SPREAD * spread {
                break;
            }
            count = (count as f64 * GROWTH) as usize;
        }
        if radius == 0.0 {
            return None;
        }
        let count = count.min(largest);
        let carried = sample(points, SPACING * noise).into_iter().map(|index| {
            let mut place = points[index as usize];
            for _ in 0..ROUNDS {
                let mut near = around(&place, count);
                let Some(fit) = Moments::of(place, points, &near).fit() else { break };
                near.retain(|&i| fit.plane.distance(&points[i as usize]).abs() <= SAME_SURFACE * noise);
                let fit = Moments::of(place, points, &near).fit().unwrap_or(fit);
                place -= fit.plane.normal.scale(fit.plane.distance(&place));
            }
            place
        });
        let mut carried: Vec<Point3<f64>> = carried.collect();
        // What the detection sees must be distinct.
        carried.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z)));
        carried.dedup();
        Some(Self { points: carried, noise: TAILS * noise, radius })
    }
}

/// The value at this share of the ordered values; `None` without any.
fn rank(values: impl Iterator<Item = f64>, share: f64) -> Option<f64> {
    let mut values: Vec<f64> = values.collect();
    let at = (values.len() as f64 * share) as usize;
    (at < values.len()).then(|| *values.select_nth_unstable_by(at, f64::total_cmp).1)
}

/// One point for each cube of side `side`, the one nearest to its centre; the cubes grow until there are few enough.
fn sample(points: &[Point3<f64>], mut side: f64) -> Vec<u32> {
    side = side.max(0.01);
    loop {
        let mut nearest: BTreeMap<[i64; 3], (f64, u32)> = BTreeMap::new();
        for (index, point) in (0u32..).zip(points) {
            let cube = [0, 1, 2].map(|axis| (point[axis] / side).floor() as i64);
            let off: f64 = (0..3).map(|axis| (point[axis] / side - cube[axis] as f64 - 0.5).powi(2)).sum();
            let best = nearest.entry(cube).or_insert((off, index));
            if off < best.0 {
                *best = (off, index);
            }
        }
        if nearest.len() <= MOST {
            return nearest.into_values().map(|(_, index)| index).collect();
        }
        side *= (nearest.len() as f64 / MOST as f64).sqrt().max(1.1);
    }
}
