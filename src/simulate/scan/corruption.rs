//! What goes wrong between the surface and the points.

use geo::{Contains, MultiPolygon};
use nalgebra::{Point2, Point3, Vector3};

use super::super::mesh::Mesh;
use super::super::options::ScanOptions;
use super::super::random::{Draw, Random};
use super::scene::{Return, Target};
use crate::geometry::Aabb;

/// Faces whose normal is nearer to the horizontal than this are walls (sine).
const WALL: f64 = 0.1;
/// Least and largest delay of a reflection, metres.
const DELAY: [f64; 2] = [0.2, 3.0];
/// How far from the building's box outliers are, metres.
const OUTLIER_REACH: f64 = 2.0;

/// What a face is for a scanner.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Side {
    Roof,
    Wall,
    Underside,
}

/// Takes away the walls that give no points, the holes of the roof and the pulses that do not come back.
pub(super) fn lose(returns: &mut Vec<Return>, mesh: &Mesh, options: &ScanOptions, random: &mut Random) {
    let sides = sides(mesh);
    let side = |hit: &Return| match hit.target {
        Target::Building(face) => sides.get(face as usize).copied(),
        _ => None,
    };
    let share = options.walls_missing.draw(random);
    let missing: Vec<bool> = sides.iter().map(|_| random.chance(share)).collect();
    returns.retain(|hit| match hit.target {
        Target::Building(face) => {
            side(hit) != Some(Side::Wall) || !missing.get(face as usize).copied().unwrap_or(false)
        }
        _ => true,
    });

    let holes = if random.chance(options.hole_chance) { options.holes.draw_count(random) } else { 0 };
    for _ in 0..holes {
        let roof: Vec<usize> = (0..returns.len()).filter(|&i| side(&returns[i]) == Some(Side::Roof)).collect();
        let radius = options.hole_radius.draw(random);
        let Some(&centre) = roof.get(random.below(roof.len())) else { break };
        punch(returns, &roof, centre, radius, usize::MAX);
    }
    let mut left = if random.chance(options.missing_chance) {
        let roof = returns.iter().filter(|hit| side(hit) == Some(Side::Roof)).count();
        (options.roof_missing.draw(random).min(1.0) * roof as f64).round() as usize
    } else {
        0
    };
    while left > 0 {
        let roof: Vec<usize> = (0..returns.len()).filter(|&i| side(&returns[i]) == Some(Side::Roof)).collect();
        // A hole takes its own centre at least, so that this ends.
        let radius = options.hole_radius.draw(random).max(0.1);
        let Some(&centre) = roof.get(random.below(roof.len())) else { break };
        left -= punch(returns, &roof, centre, radius, left).min(left);
    }

    let dropped = options.dropped.draw(random);
    returns.retain(|_| !random.chance(dropped));
}

/// Takes the roof points within a radius of one of them, seen from above: the nearest first, no more than `most`. Returns
/// how many.
fn punch(returns: &mut Vec<Return>, roof: &[usize], centre: usize, radius: f64, most: usize) -> usize {
    let middle: Point2<f64> = returns[centre].position.xy();
    let mut near: Vec<(f64, usize)> = roof
        .iter()
        .map(|&i| ((returns[i].position.xy() - middle).norm(), i))
        .filter(|(distance, _)| *distance <= radius)
        .collect();
    near.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    near.truncate(most);
    let mut gone: Vec<usize> = near.into_iter().map(|(_, i)| i).collect();
    gone.sort_unstable();
    let mut index = 0;
    returns.retain(|_| {
        index += 1;
        gone.binary_search(&(index - 1)).is_err()
    });
    gone.len()
}

/// What each face is.
fn sides(mesh: &Mesh) -> Vec<Side> {
    let mut areas = vec![Vector3::zeros(); mesh.faces.iter().max().map_or(0, |&last| last as usize + 1)];
    for ([a, b, c], &face) in mesh.all_corners().zip(&mesh.faces) {
        areas[face as usize] += (b - a).cross(&(c - a));
    }
    let side = |area: &Vector3<f64>| match area.z / area.norm().max(f64::MIN_POSITIVE) {
        up if up > WALL => Side::Roof,
        up if up < -WALL => Side::Underside,
        _ => Side::Wall,
    };
    areas.iter().map(side).collect()
}

/// Moves every strip a little.
pub(super) fn shift_strips(returns: &mut [Return], strips: u32, options: &ScanOptions, random: &mut Random) {
    let shifts: Vec<Vector3<f64>> = (0..strips)
        .map(|_| {
            let plane = [random.normal(), random.normal()].map(|n| n * options.strip_shift);
            Vector3::new(plane[0], plane[1], random.normal() * options.strip_height)
        })
        .collect();
    for hit in returns {
        hit.position += shifts.get(hit.strip as usize).copied().unwrap_or_default();
    }
}

/// Lets some pulses come back late, by way of something else.
pub(super) fn reflect(returns: &mut [Return], options: &ScanOptions, random: &mut Random) {
    let share = options.ghosts.draw(random);
    for hit in returns {
        if random.chance(share) {
            hit.position += hit.direction.into_inner() * random.between(DELAY[0], DELAY[1]);
        }
    }
}

/// Adds noise of this standard deviation along each axis, metres.
pub(super) fn blur(returns: &mut [Return], sigma: f64, random: &mut Random) {
    if sigma > 0.0 {
        for hit in returns {
            hit.position += Vector3::from_fn(|_, _| sigma * random.normal());
        }
    }
}

/// Adds points that are of nothing, around the building and in its footprint.
pub(super) fn add_outliers(
    points: &mut Vec<Point3<f64>>,
    aabb: &Aabb,
    footprint: Option<&MultiPolygon<f64>>,
    options: &ScanOptions,
    random: &mut Random,
) {
    let count = (options.outliers.draw(random) * points.len() as f64).round() as usize;
    for _ in 0..count {
        let p = Point3::from(std::array::from_fn(|i| {
            random.between(aabb.min[i] - OUTLIER_REACH, aabb.max[i] + OUTLIER_REACH)
        }));
        if footprint.is_none_or(|f| f.contains(&geo::Point::new(p.x, p.y))) {
            points.push(p);
        }
    }
}
