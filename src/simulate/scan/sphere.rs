//! Positions on a sphere around the building: full-view, on its upper half no-bottom, and higher up photographs.

use nalgebra::{Point3, Unit, Vector3};

use super::super::options::Setup;
use super::super::random::{Draw, Random};
use super::scene::{Return, Scene, Target};
use crate::geometry::Aabb;

/// Positions of the scanner, least and most.
const POSITIONS: [usize; 2] = [8, 24];
/// Radius of the sphere, in half diagonals of the building's box.
const DISTANCE: f64 = 4.0;
/// How steeply a position of the upper half looks down at least, as the sine; and that of a camera in an aircraft.
const LOWEST: [f64; 2] = [0.05, 0.6];
/// Pulses per point that is wanted, at most: most of those that aim at the sphere around a building meet it or the ground.
const PATIENCE: usize = 12;

/// Pulses from positions on the part of a sphere that a set-up has, until the building has sent `wanted` back or there is nothing to
/// be seen; and the number of positions.
pub(super) fn scan(scene: &Scene, setup: Setup, wanted: usize, random: &mut Random) -> (Vec<Return>, u32) {
    let lowest = match setup {
        Setup::FullView => None,
        Setup::NoBottom | Setup::Airborne => Some(LOWEST[0]),
        Setup::Photographs => Some(LOWEST[1]),
    };
    let Aabb { min, max } = scene.aabb;
    let [low, high] = [min, max].map(Point3::from);
    let (centre, radius) = (nalgebra::center(&low, &high), (high - low).norm() / 2.0);
    let count = POSITIONS[0] + random.below(POSITIONS[1] - POSITIONS[0] + 1);
    let positions: Vec<Point3<f64>> = (0..count)
        .map(|_| {
            let mut direction = random.direction();
            if let Some(lowest) = lowest {
                direction.z = direction.z.abs().max(lowest);
            }
            centre + direction.normalize() * radius * DISTANCE
        })
        .collect();
    let mut returns = Vec::with_capacity(wanted);
    let mut found = 0;
    for pulse in 0..PATIENCE * wanted {
        if found >= wanted {
            break;
        }
        let position = pulse % count;
        let aim = centre + random.direction() * radius * random.unit().cbrt();
        let Some(origin) = positions.get(position) else { break };
        let direction: Vector3<f64> = aim - origin;
        let Some(hit) = scene.cast(origin, Unit::new_normalize(direction), position as u32, random) else { continue };
        if matches!(hit.target, Target::Building(_)) {
            found += 1;
        }
        returns.push(hit);
    }
    (returns, count as u32)
}
