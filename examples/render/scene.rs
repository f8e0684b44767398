//! Buildings and points as what the camera sees.

use gable::evaluate::{Cover, Shape};
use gable::solid::SurfaceType;
use nalgebra::{Point3, Vector3};
use tiny_skia::Pixmap;

use crate::camera::Camera;
use crate::canvas::{Canvas, Colour, srgb};

/// How a picture is taken.
#[derive(Debug, Clone, Copy)]
pub struct View {
    /// Where the viewer stands, degrees clockwise from north.
    pub azimuth: f64,
    /// How high, degrees over the horizon.
    pub elevation: f64,
    /// Width and height in pixels.
    pub size: [usize; 2],
}

/// A laser point and its height over the roof below or above it.
pub type ScannedPoint = (Point3<f64>, Option<f64>);

/// A building to draw.
#[derive(Debug, Clone)]
pub struct Subject {
    /// Its shape.
    pub shape: Shape,
    /// Whether it is a block for want of the level of detail that was asked for.
    pub is_fallback: bool,
}

/// Takes a picture of the subjects, with points over them.
pub fn picture(subjects: &[&Subject], points: &[ScannedPoint], view: View) -> Option<Pixmap> {
    let shapes: Vec<&Shape> = subjects.iter().map(|subject| &subject.shape).collect();
    let mut canvas = Canvas::new(view.size, srgb([250, 250, 248]));
    let seen = || {
        shapes
            .iter()
            .flat_map(|s| s.faces.iter().flat_map(|f| f.rings.iter().flatten()).chain(s.outline.iter().flatten()))
            .chain(points.iter().map(|(p, _)| p))
    };
    let dot = canvas.oversampling();
    let camera = Camera::at(view.azimuth, view.elevation).fit(seen(), canvas.samples(), 12.0 * dot);
    // The lamp stands to the left of the viewer, so that one wall of every corner is bright and the other is not.
    let lamp_azimuth = view.azimuth + 65.0;
    let mut light = Canvas::new([1000, 1000], [0.0; 3]);
    let lamp = Camera::at(lamp_azimuth, 42.0).fit(seen(), light.samples(), 4.0);
    for triangle in floor(&shapes) {
        canvas.face(&camera, &triangle, srgb([250, 249, 245]), 1.0);
    }
    for Subject { shape, is_fallback } in subjects {
        for (triangle, face) in &shape.triangles {
            canvas.face(&camera, triangle, colour_of(shape.kind(*face), *is_fallback), facing(triangle, &lamp));
            light.face(&lamp, triangle, [0.0; 3], 1.0);
        }
        if shape.faces.is_empty() {
            for triangle in &shape.outline {
                canvas.face(&camera, &triangle.map(|p| p + Vector3::z() * 0.02), srgb(MISSING), 1.0);
            }
        }
    }
    canvas.shade(&camera, &light, &lamp);
    let width = if shapes.len() > 1 { 0.6 } else { 1.1 } * dot;
    for face in shapes.iter().flat_map(|s| &s.faces) {
        for ring in &face.rings {
            for (a, b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
                // Towards the viewer by a little, or an edge would sink into the faces that it bounds.
                let lift = camera.back * (1.5 * dot / camera.scale).min(0.15);
                canvas.line(camera.project(&(a + lift)), camera.project(&(b + lift)), width, srgb([45, 40, 40]));
            }
        }
    }
    for (point, distance) in points {
        let radius = (0.09 * camera.scale).clamp(0.6 * dot, 2.0 * dot);
        // A point up to 0.3 m below its roof still shows: those are the ones to look at.
        canvas.disc(camera.project(&(point + camera.back * 0.3)), radius, distance_colour(*distance));
    }
    canvas.finish()
}

/// Where the level of detail that was asked for is missing: a colour that no surface has.
const MISSING: [u8; 3] = [120, 130, 200];

/// Colours of the semantic surfaces.
fn colour_of(kind: SurfaceType, is_fallback: bool) -> Colour {
    srgb(match kind {
        SurfaceType::Roof if is_fallback => MISSING,
        SurfaceType::Roof => [222, 92, 62],
        SurfaceType::Wall => [226, 224, 220],
        SurfaceType::Ground => [139, 101, 62],
        SurfaceType::OuterCeiling => [120, 150, 110],
    })
}

/// Cosine of the angle between a triangle and the light, 0 when it looks away.
fn facing([a, b, c]: &[Point3<f64>; 3], lamp: &Camera) -> f32 {
    let normal = (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_else(Vector3::z);
    normal.dot(&lamp.back).max(0.0) as f32
}

/// The colour of a point by its height over the roof in metres: green on it, to red above and to blue below, black where
/// there is no roof. The scale ends at half a metre.
pub fn distance_colour(distance: Option<f64>) -> Colour {
    let Some(distance) = distance else { return [0.0; 3] };
    let share = (distance.abs() / 0.5).min(1.0) as f32;
    let [near, far] = [srgb([40, 190, 90]), srgb(if distance > 0.0 { [230, 0, 60] } else { [20, 40, 230] })];
    std::array::from_fn(|i| near[i] + share * (far[i] - near[i]))
}

/// A floor under all shapes, at the lowest of them.
fn floor(shapes: &[&Shape]) -> Vec<[Point3<f64>; 3]> {
    let outline = || shapes.iter().flat_map(|s| s.outline.iter().flatten());
    let bound =
        |pick: fn(&Point3<f64>) -> f64, start: f64, keep: fn(f64, f64) -> f64| outline().map(pick).fold(start, keep);
    // Wide enough to fill the picture whatever its shape.
    let margin =
        10.0 * shapes.iter().filter_map(|s| s.aabb()).fold(50.0, |m: f64, b| b.extent().into_iter().fold(m, f64::max));
    let (x0, x1) =
        (bound(|p| p.x, f64::INFINITY, f64::min) - margin, bound(|p| p.x, f64::NEG_INFINITY, f64::max) + margin);
    let (y0, y1) =
        (bound(|p| p.y, f64::INFINITY, f64::min) - margin, bound(|p| p.y, f64::NEG_INFINITY, f64::max) + margin);
    let lowest = |s: &&Shape| s.aabb().map(|b| b.min[2]);
    let z = shapes.iter().filter_map(lowest).fold(f64::INFINITY, f64::min) - 0.05;
    if !(x0.is_finite() && y0.is_finite() && z.is_finite()) {
        return Vec::new();
    }
    let [a, b, c, d] = [[x0, y0], [x1, y0], [x1, y1], [x0, y1]].map(|[x, y]| Point3::new(x, y, z));
    vec![[a, b, c], [a, c, d]]
}

/// The points over the outline of a shape, with their heights over its roofs.
pub fn on_shape(shape: &Shape, points: &[Point3<f64>]) -> Vec<ScannedPoint> {
    let outline = Cover::new(shape.outline.iter().copied());
    let roofs = shape.roofs();
    points
        .iter()
        .filter(|p| outline.contains(p.x, p.y))
        .map(|p| (*p, roofs.nearest_height(p.x, p.y, p.z).map(|z| p.z - z)))
        .collect()
}
