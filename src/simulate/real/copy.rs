//! The copy of a real scan that a network gets: thinner, with holes, cropped.

use geo::Translate;
use nalgebra::Point3;

use super::super::options::ScanOptions;
use super::super::random::{Draw, Random};
use super::RealSite;
use crate::site::{Ground, Site};

/// No copy has more of the points than this share: what is asked about is never all known.
const MOST: f64 = 0.8;

impl RealSite {
    /// A copy for a network, under this id. Of the options those count that are not of a scanner: density, holes, what is
    /// missing, the footprint, the ground.
    pub(in crate::simulate) fn copy(&self, id: &str, options: &ScanOptions, random: &mut Random) -> Site {
        let area = self.site.footprint.as_ref().map_or(1.0, geo::Area::unsigned_area).max(1.0);
        let found = self.site.points.len() as f64;
        let wanted = (options.density.draw_magnitude(random) * area).min(f64::from(options.most_points));
        let share = (wanted / found.max(1.0)).min(MOST);
        let mut thinned = |points: &[Point3<f64>]| -> Vec<Point3<f64>> {
            points.iter().filter(|_| random.chance(share)).copied().collect()
        };
        let [mut points, mut ground_points] = [&self.site.points, &self.site.ground_points].map(|all| thinned(all));
        let holes = if random.chance(options.hole_chance) { options.holes.draw_count(random) } else { 0 };
        for _ in 0..holes {
            let radius = options.hole_radius.draw(random);
            let Some(middle) = points.get(random.below(points.len())).map(Point3::xy) else { break };
            for kept in [&mut points, &mut ground_points] {
                kept.retain(|p| (p.xy() - middle).norm() > radius);
            }
        }
        if random.chance(options.missing_chance) {
            crop(&mut points, &mut ground_points, options.roof_missing.draw(random), random);
        }
        for kept in [&mut points, &mut ground_points] {
            kept.sort_unstable_by(|a, b| {
                a.x.total_cmp(&b.x).then_with(|| a.y.total_cmp(&b.y)).then_with(|| a.z.total_cmp(&b.z))
            });
        }
        let footprint = self.site.footprint.as_ref().filter(|_| random.chance(options.footprint)).map(|outline| {
            let (distance, angle) = (options.footprint_shift.draw(random), random.unit() * std::f64::consts::TAU);
            outline.translate(distance * angle.cos(), distance * angle.sin())
        });
        let ground =
            Ground { height: self.site.ground.height + options.ground_error * random.normal(), ..self.site.ground };
        Site { id: id.to_owned(), points, ground_points, footprint, ground, ..self.site.clone() }
    }
}

/// Takes this share of the points away, all from one side, as the end of a tile does; of the ground what lies there.
fn crop(points: &mut Vec<Point3<f64>>, ground_points: &mut Vec<Point3<f64>>, share: f64, random: &mut Random) {
    let (sin, cos) = (random.unit() * std::f64::consts::TAU).sin_cos();
    let along = |p: &Point3<f64>| p.x * cos + p.y * sin;
    let left = ((1.0 - share.clamp(0.0, 1.0)) * points.len() as f64).round() as usize;
    points.sort_by(|a, b| along(a).total_cmp(&along(b)));
    points.truncate(left);
    if let Some(end) = points.last().map(&along) {
        ground_points.retain(|p| along(p) <= end);
    }
}
