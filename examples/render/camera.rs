//! An orthographic camera.

use nalgebra::{Point3, Vector3};

/// Looks along parallel rays; screen x goes right and screen y down, in pixels.
#[derive(Debug, Clone, Copy)]
pub struct Camera {
    right: Vector3<f64>,
    up: Vector3<f64>,
    /// Unit vector from the scene to the viewer.
    pub back: Vector3<f64>,
    /// Pixels per metre.
    pub scale: f64,
    offset: [f64; 2],
}

impl Camera {
    /// A camera that stands at `azimuth` (degrees clockwise from north) and `elevation` (degrees over the horizon) of what
    /// it looks at.
    pub fn at(azimuth: f64, elevation: f64) -> Self {
        let (sin_a, cos_a) = azimuth.to_radians().sin_cos();
        let (sin_e, cos_e) = elevation.to_radians().sin_cos();
        Self {
            right: Vector3::new(-cos_a, sin_a, 0.0),
            up: Vector3::new(-sin_a * sin_e, -cos_a * sin_e, cos_e),
            back: Vector3::new(sin_a * cos_e, cos_a * cos_e, sin_e),
            scale: 1.0,
            offset: [0.0; 2],
        }
    }

    /// The same view, scaled and shifted so that all points lie in a picture of this size, `margin` pixels from its border.
    pub fn fit<'a>(self, points: impl IntoIterator<Item = &'a Point3<f64>>, size: [usize; 2], margin: f64) -> Self {
        let (mut min, mut max) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for p in points {
            for (axis, value) in [p.coords.dot(&self.right), -p.coords.dot(&self.up)].into_iter().enumerate() {
                min[axis] = min[axis].min(value);
                max[axis] = max[axis].max(value);
            }
        }
        let room = size.map(|s| (s as f64 - 2.0 * margin).max(1.0));
        let extent = [max[0] - min[0], max[1] - min[1]].map(|e| if e.is_finite() { e.max(1e-6) } else { 1.0 });
        let scale = (room[0] / extent[0]).min(room[1] / extent[1]);
        let centre = [0, 1].map(|axis| {
            let middle = f64::midpoint(min[axis], max[axis]);
            size[axis] as f64 / 2.0 - scale * if middle.is_finite() { middle } else { 0.0 }
        });
        Self { scale, offset: centre, ..self }
    }

    /// Screen x, screen y and nearness (metres towards the viewer) of a point.
    pub fn project(&self, p: &Point3<f64>) -> [f64; 3] {
        let [right, up, back] = [self.right, self.up, self.back].map(|axis| p.coords.dot(&axis));
        [self.offset[0] + self.scale * right, self.offset[1] - self.scale * up, back]
    }

    /// The point at a place of the screen: the inverse of [`Self::project`].
    pub fn unproject(&self, [x, y, near]: [f64; 3]) -> Point3<f64> {
        let right = (x - self.offset[0]) / self.scale;
        let up = (self.offset[1] - y) / self.scale;
        Point3::from(self.right * right + self.up * up + self.back * near)
    }
}
