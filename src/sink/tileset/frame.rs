//! The frame of the tileset: metres east, north and up from a point on earth, in which its tiles stand.

use nalgebra::{Matrix3, Point3, Vector3};

/// Semi-axes of WGS 84 in metres.
const EQUATOR: f64 = 6_378_137.0;
const POLE: f64 = 6_356_752.314_245_179;

/// East, north, up from an origin on earth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct EarthFrame {
    /// The origin in geocentric metres.
    origin: Point3<f64>,
    /// East, north and up in geocentric axes, as columns.
    axes: Matrix3<f64>,
}

impl EarthFrame {
    /// The frame at a geocentric point near the surface of the earth.
    pub(super) fn at(origin: [f64; 3]) -> Self {
        let origin = Point3::from(origin);
        // The normal of the ellipsoid through the origin that is similar to that of the earth: within 1e-8 of the vertical of
        // WGS 84 for any building on it. It only has to be the same for all.
        let up = Vector3::new(origin.x / (EQUATOR * EQUATOR), origin.y / (EQUATOR * EQUATOR), origin.z / (POLE * POLE));
        let up = up.try_normalize(0.0).unwrap_or_else(Vector3::z);
        // At the poles any direction is east.
        let east = Vector3::z().cross(&up).try_normalize(1e-12).unwrap_or_else(Vector3::x);
        let north = up.cross(&east);
        Self { origin, axes: Matrix3::from_columns(&[east, north, up]) }
    }

    /// A geocentric point in the frame.
    pub(super) fn to_local(self, geocentric: [f64; 3]) -> [f64; 3] {
        let local = self.axes.transpose() * (Point3::from(geocentric) - self.origin);
        [local.x, local.y, local.z]
    }

    /// The transform from the frame to geocentric coordinates as 3D Tiles has it: 4 × 4, column by column.
    pub(super) fn matrix(&self) -> [f64; 16] {
        let column = |i: usize| [self.axes[(0, i)], self.axes[(1, i)], self.axes[(2, i)], 0.0];
        let origin = [self.origin.x, self.origin.y, self.origin.z, 1.0];
        let mut matrix = [0.0; 16];
        for (out, value) in matrix.iter_mut().zip([column(0), column(1), column(2), origin].into_iter().flatten()) {
            *out = value;
        }
        matrix
    }
}

/// A box of the frame along its axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bounds {
    min: [f64; 3],
    max: [f64; 3],
}

impl Bounds {
    /// The smallest box around points; `None` without any.
    pub(super) fn of(points: impl IntoIterator<Item = [f64; 3]>) -> Option<Self> {
        points.into_iter().fold(None, |bounds, p| {
            Some(Self::union(bounds.unwrap_or(Self { min: p, max: p }), Self { min: p, max: p }))
        })
    }

    /// A box of no size at the origin.
    pub(super) fn nothing() -> Self {
        Self { min: [0.0; 3], max: [0.0; 3] }
    }

    /// The smallest box around two.
    pub(super) fn union(self, other: Self) -> Self {
        Self {
            min: std::array::from_fn(|i| self.min[i].min(other.min[i])),
            max: std::array::from_fn(|i| self.max[i].max(other.max[i])),
        }
    }

    pub(super) fn centre(&self) -> [f64; 3] {
        std::array::from_fn(|i| f64::midpoint(self.min[i], self.max[i]))
    }

    /// Length of the diagonal in metres.
    pub(super) fn diagonal(&self) -> f64 {
        (0..3).map(|i| (self.max[i] - self.min[i]).powi(2)).sum::<f64>().sqrt()
    }

    /// Its longest side, metres, to the millimetre; 0 where it holds nothing.
    pub(super) fn extent(self) -> f64 {
        let sides = (0..3).map(|i| self.max[i] - self.min[i]);
        (sides.fold(0.0, f64::max) * 1e3).round() / 1e3
    }

    /// As 3D Tiles has it: centre, then half of each side, to the millimetre and never too small.
    pub(super) fn to_tiles(self) -> [f64; 12] {
        let round = |value: f64| (value * 1e3).round() / 1e3;
        let centre = self.centre().map(round);
        // Rounding moves the centre by half a millimetre; a flat box would have no volume.
        let half: [f64; 3] = std::array::from_fn(|i| (((self.max[i] - self.min[i]) / 2.0 + 1e-3) * 1e3).ceil() / 1e3);
        [centre[0], centre[1], centre[2], half[0], 0.0, 0.0, 0.0, half[1], 0.0, 0.0, 0.0, half[2]]
    }
}
