//! What image matching does to a surface: it finds points where there is texture, sees little at the foot of walls, and
//! its surface waves.

use nalgebra::{Point3, Vector3};

use super::super::options::ScanOptions;
use super::super::random::{Draw, Random};
use super::scene::Return;

/// Waves that make up a field: enough for its values to be near to normal.
const WAVES: usize = 12;
/// Over so many metres surfaces change from such with texture to such without.
const TEXTURE: f64 = 4.0;

/// A random field over space: smooth, with mean 0 and standard deviation 1.
struct Field {
    /// Wave vectors, radians per metre, and phases.
    waves: Vec<(Vector3<f64>, f64)>,
}

impl Field {
    /// A field whose waves are about so long, metres.
    fn new(length: f64, random: &mut Random) -> Self {
        let wave = |random: &mut Random| {
            let number = std::f64::consts::TAU / length.max(1e-3) * random.between(0.7, 1.4);
            (random.direction() * number, random.between(0.0, std::f64::consts::TAU))
        };
        Self { waves: (0..WAVES).map(|_| wave(random)).collect() }
    }

    fn at(&self, point: &Point3<f64>) -> f64 {
        let sum: f64 = self.waves.iter().map(|(vector, phase)| (vector.dot(&point.coords) + phase).cos()).sum();
        sum * (2.0 / WAVES as f64).sqrt()
    }
}

/// Turns what cameras see of surfaces into what the matching of their pictures makes of it: thinned where there is little
/// texture and at the foot of walls, whose `ground` is at this height, and displaced along the line of sight.
pub(super) fn match_pictures(returns: &mut Vec<Return>, ground: f64, options: &ScanOptions, random: &mut Random) {
    let texture = Field::new(TEXTURE, random);
    let poor = options.texture_missing.draw(random).min(1.0);
    let blind = options.blind_height.draw(random);
    let waves = Field::new(options.ripple_length.draw(random), random);
    let ripple = options.ripples.draw(random);
    returns.retain(|hit| {
        // Half of the surface has more than the middle texture, and keeps most of its points.
        let plain = 1.0 / (1.0 + (4.0 * texture.at(&hit.position)).exp());
        let height = hit.position.z - ground;
        let seen = if height < blind { (height / blind).clamp(0.0, 1.0).powi(2) } else { 1.0 };
        random.chance((1.0 - poor * plain) * seen)
    });
    for hit in returns {
        hit.position += hit.direction.into_inner() * (ripple * waves.at(&hit.position));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_field_has_unit_variance_and_is_smooth_at_its_length() {
        let mut random = Random::new(5);
        let (mut squares, mut near, mut far) = (0.0, 0.0, 0.0);
        let count = 4_000;
        for _ in 0..count {
            let field = Field::new(2.0, &mut random);
            let place = Point3::from(random.direction() * 10.0);
            let value = field.at(&place);
            let at = |random: &mut Random, distance: f64| field.at(&(place + random.direction() * distance));
            squares += value * value;
            near += value * at(&mut random, 0.1);
            far += value * at(&mut random, 3.0);
        }
        let [variance, near, far] = [squares, near, far].map(|sum| sum / f64::from(count));
        assert!((variance - 1.0).abs() < 0.08, "{variance}");
        assert!(near > 0.9 && far.abs() < 0.15, "{near} {far}");
    }
}
