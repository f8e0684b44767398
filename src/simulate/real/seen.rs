//! What a real scan shows: where it is free, where inside, and where nobody knows.

use nalgebra::{Matrix3, Point2, Point3, Vector3};

use super::super::plan::Plan;
use super::RealSite;
use crate::geometry::Aabb;
use crate::reconstruct::occupancy::inputs::Outline;

/// A point with another this much above it …
const UNDER: f64 = 1.0;
/// … within this distance in the plan is no top: it lies on a wall, or under a roof. Metres.
const BESIDE: f64 = 0.7;
/// Nearer to the outline than this nothing is known: wall points mislead, and footprints are displaced. Metres.
const EDGE: f64 = 0.3;
/// How far around the known height of the ground nothing is known, metres.
const GROUND: f64 = 0.3;
/// Least and most reach of the tops that speak for a place, metres; between them it is as many spacings as below.
const REACH: [f64; 2] = [0.5, 1.5];
/// The same in typical distances of the tops.
const SPACINGS: f64 = 1.5;
/// A place with fewer tops within reach was not scanned.
const FEWEST: usize = 3;
/// So many of the nearest tops make a plane …
const NEAREST: usize = 8;
/// … if they lie within this of it (root mean square), metres.
const FLAT: f64 = 0.12;
/// Least half-width of the band around a height in which noise decides, metres.
const NOISE: f64 = 0.08;

/// The truth about a scanned building as far as its points tell it.
#[derive(Debug)]
pub(in crate::simulate) struct Seen {
    tops: Vec<Point3<f64>>,
    plan: Plan,
    reach: f64,
    outline: Option<Outline>,
    ground: f64,
    aabb: Aabb,
}

/// Below the first height a place is inside, above the second it is free.
type Heights = [f64; 2];

impl Seen {
    /// What all points of a site show, those on the ground too; `None` for a site without building points.
    pub fn new(real: &RealSite) -> Option<Self> {
        let all: Vec<Point3<f64>> = real.site.points.iter().chain(&real.site.ground_points).copied().collect();
        let mut aabb = Aabb::of(&real.site.points)?;
        aabb.min[2] = aabb.min[2].min(real.site.ground.height);
        let everything = Plan::new(&all, BESIDE);
        let is_top = |p: &Point3<f64>| {
            let above = everything.around(&p.xy(), BESIDE).filter_map(|i| all.get(i as usize));
            !above.into_iter().any(|q| q.z > p.z + UNDER && (q.xy() - p.xy()).norm() <= BESIDE)
        };
        let tops: Vec<Point3<f64>> = all.iter().filter(|p| is_top(p)).copied().collect();
        let extent = aabb.extent();
        let area = real.site.footprint.as_ref().map_or(extent[0] * extent[1], geo::Area::unsigned_area);
        let reach = (SPACINGS * (area / tops.len().max(1) as f64).sqrt()).clamp(REACH[0], REACH[1]);
        Some(Self {
            plan: Plan::new(&tops, reach),
            tops,
            reach,
            outline: real.site.footprint.as_ref().map(Outline::new),
            ground: real.site.ground.height,
            aabb,
        })
    }

    /// Whether a place is inside; `None` where the scan does not tell.
    pub fn is_inside(&self, p: &Point3<f64>) -> Option<bool> {
        if p.z < self.ground - GROUND {
            return Some(false);
        }
        if self.distance_from_outline(&p.xy()).is_some_and(|within| within < EDGE) {
            return None;
        }
        let [low, high] = self.heights(&p.xy())?;
        if p.z > high {
            return Some(false);
        }
        (p.z < low && p.z > self.ground + GROUND).then_some(true)
    }

    /// How far a place is from the nearest height at which the scan changes its mind, metres: along the vertical, so more
    /// than the distance of the surface. 0 where nothing is known.
    pub fn clearance(&self, p: &Point3<f64>) -> f64 {
        self.heights(&p.xy()).map_or(0.0, |[low, high]| if p.z > high { p.z - high } else { (low - p.z).max(0.0) })
    }

    /// The box around the points, from the ground.
    pub fn aabb(&self) -> &Aabb {
        &self.aabb
    }

    /// The points on top.
    pub fn tops(&self) -> &[Point3<f64>] {
        &self.tops
    }

    fn distance_from_outline(&self, p: &Point2<f64>) -> Option<f64> {
        self.outline.as_ref().map(|outline| outline.distance(p))
    }

    /// Between which heights the surface lies over a point of the plan; `None` where nothing was scanned.
    fn heights(&self, p: &Point2<f64>) -> Option<Heights> {
        let mut near: Vec<(f64, Vector3<f64>)> = self
            .plan
            .around(p, self.reach)
            .filter_map(|i| self.tops.get(i as usize))
            .map(|top| ((top.xy() - p).norm(), Vector3::new(top.x - p.x, top.y - p.y, top.z)))
            .filter(|(distance, _)| *distance <= self.reach)
            .collect();
        if near.len() < FEWEST {
            return None;
        }
        near.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.z.total_cmp(&b.1.z)));
        let nearest: Vec<Vector3<f64>> = near.iter().take(NEAREST).map(|(_, offset)| *offset).collect();
        plane(&nearest, self.reach).or_else(|| {
            let heights = near.iter().map(|(_, offset)| offset.z);
            let [low, high] =
                heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], z| [low.min(z), high.max(z)]);
            Some([low - NOISE, high + NOISE])
        })
    }
}

/// The heights of a plane through points around the origin of the plan; `None` where they make none, or lie to one side.
fn plane(offsets: &[Vector3<f64>], reach: f64) -> Option<Heights> {
    let count = offsets.len() as f64;
    let mean = offsets.iter().sum::<Vector3<f64>>() / count;
    if offsets.len() <= FEWEST || mean.xy().norm() > 0.4 * reach {
        return None;
    }
    let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for offset in offsets {
        let row = Vector3::new(1.0, offset.x, offset.y);
        normal += row * row.transpose();
        right += row * (offset.z - mean.z);
    }
    // Points in a line make any plane.
    let spread = normal.fixed_view::<2, 2>(1, 1).determinant() / (count * count);
    if spread < (0.1 * reach).powi(4) {
        return None;
    }
    let fit = normal.try_inverse()? * right;
    let squares: f64 =
        offsets.iter().map(|o| (o.z - mean.z - fit.x - fit.y * o.x - fit.z * o.y).powi(2)).sum::<f64>() / count;
    let residual = squares.sqrt();
    let (height, band) = (mean.z + fit.x, f64::max(NOISE, 2.0 * residual));
    (residual < FLAT).then_some([height - band, height + band])
}
