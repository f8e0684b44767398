//! How long the unit of a projection really is.
//!
//! A map cannot be true to length everywhere. Grids for surveying are, to some parts in ten thousand; maps of the whole
//! world are not: the metres of EPSG:3857 are 0.6 m in the Netherlands.

use super::{Crs, Transformer};

/// Semi-major axis (metres) and square of the eccentricity of WGS 84.
const ELLIPSOID: (f64, f64) = (6_378_137.0, 6.694_379_990_141e-3);
/// Over so many units the scale is measured: few enough to be at one place, many enough for the digits.
const SPAN: f64 = 100.0;
/// Deviations from this share on are told.
const NOTABLE: f64 = 0.01;

impl Crs {
    /// How many metres on the ground are a metre of the projection along x and y at `place` (x and y, CRS units); `None`
    /// where both are one as nearly as in any grid for surveying, where units are no lengths, or nobody knows.
    pub fn distortion(&self, place: [f64; 2]) -> Option<[f64; 2]> {
        if self.is_geographic {
            return None;
        }
        let [x, y] = place;
        let mut points = [[x, y], [x + SPAN, y], [x, y + SPAN]];
        let globe = Self::wgs84().ok()?;
        Transformer::new(self, &globe, Some([x, y, x + SPAN, y + SPAN])).ok()?.transform(&mut points);
        let [origin, east, north] = points;
        let metres = |axis: usize, end: [f64; 2]| on_ellipsoid(origin, end) / (SPAN * self.metres_per_unit[axis]);
        let scale = [metres(0, east), metres(1, north)];
        let is_notable =
            scale.iter().all(|s| s.is_finite() && *s > 0.0) && scale.iter().any(|s| (s - 1.0).abs() > NOTABLE);
        is_notable.then_some(scale)
    }

    /// The same system with units as long as they are on the ground, where a metre of it is `metres` along x and y.
    #[must_use]
    pub fn corrected(mut self, metres: [f64; 2]) -> Self {
        for (unit, metres) in self.metres_per_unit.iter_mut().zip(metres) {
            *unit *= metres;
        }
        self
    }
}

/// The distance in metres between two near points in degrees, longitude first.
fn on_ellipsoid(from: [f64; 2], to: [f64; 2]) -> f64 {
    let (axis, eccentricity) = ELLIPSOID;
    let latitude = f64::midpoint(from[1], to[1]).to_radians();
    let root = (1.0 - eccentricity * latitude.sin().powi(2)).sqrt();
    let (meridian, normal) = (axis * (1.0 - eccentricity) / root.powi(3), axis / root);
    let east = (to[0] - from[0]).to_radians() * normal * latitude.cos();
    let north = (to[1] - from[1]).to_radians() * meridian;
    east.hypot(north)
}

#[cfg(test)]
mod tests {
    use super::super::Crs;

    #[test]
    fn maps_of_the_world_are_not_true_to_length_and_grids_are() {
        let mercator = Crs::parse("EPSG:3857").unwrap();
        let [x, y] = mercator.distortion([487_000.0, 6_800_000.0]).unwrap();
        // The cosine of the latitude, 52.0 degrees.
        assert!((x - 0.615).abs() < 0.005 && (y - 0.615).abs() < 0.005, "{x} {y}");
        assert_eq!(mercator.distortion([487_000.0, 0.0]), None, "true at the equator");
        let corrected = mercator.corrected([x, y]);
        assert!((corrected.metres_per_unit[0] - x).abs() < 1e-9 && corrected.metres_per_unit[2] == 1.0);
        for (grid, place) in [
            ("EPSG:7415", [85_000.0, 446_000.0]),
            ("EPSG:32631", [200_000.0, 5_800_000.0]),
            ("EPSG:2994", [640_000.0, 850_000.0]),
            ("EPSG:4326", [4.0, 52.0]),
        ] {
            assert_eq!(Crs::parse(grid).unwrap().distortion(place), None, "{grid}");
        }
    }
}
