//! Flight strips: parallel rays are nearly what a building sees of a scanner far above it.

use nalgebra::{Point3, Unit, Vector2, Vector3};

use super::super::options::ScanOptions;
use super::super::random::Random;
use super::scene::{Return, Scene};
use crate::geometry::Aabb;

/// Pulses that pass the box of the building farther off than this are not followed, metres.
const MARGIN: f64 = 1.0;

/// No scanner looks farther to the side, degrees from the vertical.
const MOST_ANGLE: f64 = 60.0;
/// No aircraft flies lower, metres.
const LEAST_ALTITUDE: f64 = 50.0;

/// One flight strip as the building sees it.
#[derive(Debug, Clone, Copy)]
struct Strip {
    /// The direction of flight in the plane.
    along: Vector2<f64>,
    /// Height above ground, metres.
    altitude: f64,
    /// Where the scanner is, from the place on the ground that the pulse aims at: metres along and across the flight. The
    /// first is the same for all pulses, the second only for those to the middle of the building.
    lead: [f64; 2],
    /// Distance of pulses on the ground along and across the flight, metres.
    spacing: [f64; 2],
}

/// Flies all strips; `density` is that of all strips together. With a margin of ground around the building (metres) more
/// than 0 all pulses there are followed, else only those that could meet the building.
pub(super) fn fly(
    scene: &Scene,
    ground: f64,
    options: &ScanOptions,
    density: f64,
    surroundings: f64,
    random: &mut Random,
) -> (Vec<Return>, u32) {
    let strips = options.strips.draw_count(random).max(1) as u32;
    // Strips run side by side, there and back, now and then one across.
    let heading = random.between(0.0, std::f64::consts::TAU);
    let mut returns = Vec::new();
    for strip in 0..strips {
        let turn = match strip {
            0 => 0.0,
            _ if random.chance(0.3) => std::f64::consts::FRAC_PI_2,
            _ => std::f64::consts::PI,
        };
        let strip_of = Strip::draw(heading + turn, options, density / f64::from(strips), random);
        strip_of.fly(scene, ground, surroundings, strip, &mut returns, random);
    }
    (returns, strips)
}

impl Strip {
    fn draw(heading: f64, options: &ScanOptions, density: f64, random: &mut Random) -> Self {
        let (sin, cos) = heading.sin_cos();
        let altitude = options.altitude.draw(random).max(LEAST_ALTITUDE);
        let lead = [&options.look_angle, &options.scan_angle].map(|angle| {
            let degrees = angle.draw(random).min(MOST_ANGLE);
            let side = if random.chance(0.5) { 1.0 } else { -1.0 };
            side * altitude * degrees.to_radians().tan()
        });
        // Pulses along a scan line are closer to each other than scan lines are, or the other way round.
        let stretch = random.between(0.7, 1.4);
        let even = density.max(1e-3).sqrt().recip();
        Self { along: Vector2::new(cos, sin), altitude, lead, spacing: [even * stretch, even / stretch] }
    }

    fn fly(
        &self,
        scene: &Scene,
        ground: f64,
        surroundings: f64,
        strip: u32,
        returns: &mut Vec<Return>,
        random: &mut Random,
    ) {
        let across = Vector2::new(-self.along.y, self.along.x);
        let Aabb { min, max } = scene.aabb;
        let middle = Vector2::new((min[0] + max[0]) / 2.0, (min[1] + max[1]) / 2.0);
        // What is high is met by pulses that aim at the ground behind it.
        let mut range = [[f64::INFINITY, f64::NEG_INFINITY]; 2];
        for corner in 0..8 {
            let pick = |axis: usize| if corner >> axis & 1 == 1 { max[axis] } else { min[axis] };
            let off = Vector2::new(pick(0), pick(1)) - middle;
            let behind = (pick(2) - ground) / self.altitude;
            for (axis, direction) in [self.along, across].iter().enumerate() {
                let place = off.dot(direction) - self.lead[axis] * behind;
                range[axis] = [range[axis][0].min(place), range[axis][1].max(place)];
            }
        }
        let margin = MARGIN + surroundings;
        let steps = [0, 1].map(|axis| {
            let [from, to] = range[axis];
            (((to - from + 2.0 * margin) / self.spacing[axis]).ceil() as usize, from - margin)
        });
        let start = [random.unit(), random.unit()];
        for row in 0..steps[0].0 {
            for column in 0..steps[1].0 {
                // A quarter of the spacing off the lattice: more even than chance, less than a lattice.
                let mut place = |axis: usize, step: usize| {
                    let jitter = start[axis] + random.between(-0.25, 0.25);
                    steps[axis].1 + (step as f64 + jitter) * self.spacing[axis]
                };
                let (s, t) = (place(0, row), place(1, column));
                let aim = middle + self.along * s + across * t;
                let from = middle + self.along * (s + self.lead[0]) + across * self.lead[1];
                let origin = Point3::new(from.x, from.y, ground + self.altitude);
                let direction = Vector3::new(aim.x - from.x, aim.y - from.y, -self.altitude);
                if surroundings <= 0.0 && !meets(&scene.aabb, &origin, &direction) {
                    continue;
                }
                returns.extend(scene.cast(&origin, Unit::new_normalize(direction), strip, random));
            }
        }
    }
}

/// Whether a pulse meets the box, or passes it by no more than the margin.
fn meets(aabb: &Aabb, origin: &Point3<f64>, direction: &Vector3<f64>) -> bool {
    let (mut enter, mut leave) = (0.0_f64, f64::INFINITY);
    for axis in 0..3 {
        let inverse = direction[axis].recip();
        let low = (aabb.min[axis] - MARGIN - origin[axis]) * inverse;
        let high = (aabb.max[axis] + MARGIN - origin[axis]) * inverse;
        if inverse.is_finite() {
            enter = enter.max(low.min(high));
            leave = leave.min(low.max(high));
        } else if origin[axis] < aabb.min[axis] - MARGIN || origin[axis] > aabb.max[axis] + MARGIN {
            return false;
        }
    }
    enter <= leave
}
