//! How far the floor lies under the ground: on a slope the floor is level and the ground is not.

use std::ops::Range;

use nalgebra::{Point2, Point3};

use crate::site::Site;
use crate::solid::{Solid, SurfaceType};

/// A place of the ground is at a wall that is no farther than this in the plan, metres.
const AT_WALL: f64 = 0.1;

/// Least and greatest depth of the floor under the ground along the footprint's outline, metres; negative where the floor
/// hangs above it. `None` where the ground was not seen.
pub(super) fn range(site: &Site) -> Option<[f64; 2]> {
    let depths = site.ground_line.iter().map(|p| p.z - site.ground.height);
    depths.map(|depth| [depth, depth]).reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
}

/// Tells every wall that stands on the floor how far this lies under the ground there, at most.
pub(super) fn tell(solid: &mut Solid, site: &Site) {
    if site.ground_line.is_empty() {
        return;
    }
    let floor = (site.ground.height / solid.step[2]).round() as i64;
    let mut line: Vec<&Point3<f64>> = site.ground_line.iter().collect();
    line.sort_unstable_by(|a, b| a.x.total_cmp(&b.x));
    let mut deepest: Vec<Option<f64>> = vec![None; solid.surfaces.len()];
    for face in &solid.faces {
        let Some(deepest) = deepest.get_mut(face.surface as usize) else { continue };
        if solid.surfaces.get(face.surface as usize).is_none_or(|surface| surface.kind != SurfaceType::Wall) {
            continue;
        }
        for ring in &face.rings {
            for (&a, &b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
                if [a, b].iter().all(|v| solid.vertices.get(*v as usize).is_some_and(|vertex| vertex[2] == floor)) {
                    let (a, b) = (solid.point(a).xy(), solid.point(b).xy());
                    let near = line.get(within(&line, a, b)).unwrap_or_default();
                    let at_wall = near.iter().filter(|p| distance(p.xy(), a, b) <= AT_WALL);
                    *deepest = at_wall.map(|p| p.z - site.ground.height).chain(*deepest).reduce(f64::max);
                }
            }
        }
    }
    for (surface, depth) in solid.surfaces.iter_mut().zip(deepest) {
        surface.floor_depth = depth;
    }
}

/// Which of the places, sorted by x, may be at the edge.
fn within(line: &[&Point3<f64>], a: Point2<f64>, b: Point2<f64>) -> Range<usize> {
    let up_to = |x: f64| line.partition_point(|p| p.x < x);
    up_to(a.x.min(b.x) - AT_WALL)..up_to(a.x.max(b.x) + AT_WALL)
}

fn distance(p: Point2<f64>, a: Point2<f64>, b: Point2<f64>) -> f64 {
    let (along, to) = (b - a, p - a);
    let t = (to.dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    (to - along * t).norm()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reconstruct::blocks::block;
    use crate::site::Frame;

    #[test]
    fn walls_are_told_how_deep_the_floor_lies() {
        let frame = Frame { origin: [0.0; 3], metres_per_unit: [1.0; 3] };
        let mut site = Site::new("a", frame, Vec::new(), 2.0);
        assert_eq!(range(&site), None);
        // 10 % upwards to the east; nothing is known of the north.
        let along = (0..20).map(|i| 0.25 + 0.5 * f64::from(i));
        for t in along {
            site.ground_line.push(Point3::new(t, 0.0, 2.0 + 0.1 * t));
            site.ground_line.push(Point3::new(0.0, t, 2.0));
            site.ground_line.push(Point3::new(10.0, t, 3.0));
        }
        let [least, most] = range(&site).unwrap();
        assert!(least.abs() < 1e-9 && (most - 1.0).abs() < 1e-9);
        let ring = vec![[0, 0], [100_000, 0], [100_000, 100_000], [0, 100_000]];
        let mut solid = block(&vec![ring], 20_000, 80_000, [1e-4; 3]).unwrap();
        tell(&mut solid, &site);
        let depths: Vec<Option<f64>> = solid.surfaces.iter().map(|surface| surface.floor_depth).collect();
        let told: Vec<f64> = depths.iter().flatten().copied().collect();
        assert_eq!(depths.len(), 6);
        // South, east and west.
        assert_eq!(told.len(), 3, "{depths:?}");
        for (told, expected) in told.iter().zip([0.975, 1.0, 0.0]) {
            assert!((told - expected).abs() < 1e-9, "{depths:?}");
        }
    }
}
