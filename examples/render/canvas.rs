//! A picture with a depth buffer.

use nalgebra::Point3;
use tiny_skia::{ColorU8, Pixmap};

use crate::camera::Camera;

/// Linear red, green, blue, 0 to 1.
pub type Colour = [f32; 3];

/// Pictures up to this many pixels are drawn with 3 × 3 samples per pixel, larger ones with 2 × 2.
const FINE_PIXELS: usize = 1_500_000;

/// A picture under way, oversampled.
pub struct Canvas {
    width: usize,
    height: usize,
    oversampling: usize,
    colours: Vec<Colour>,
    nearness: Vec<f32>,
    /// How squarely the lamp shines on the face, 0 to 1; for [`Self::shade`].
    facing: Vec<f32>,
}

impl Canvas {
    /// An empty picture of `size` pixels.
    pub fn new(size: [usize; 2], background: Colour) -> Self {
        let oversampling = if size[0] * size[1] <= FINE_PIXELS { 3 } else { 2 };
        let [width, height] = size.map(|s| s.max(1) * oversampling);
        let samples = width * height;
        Self {
            width,
            height,
            oversampling,
            colours: vec![background; samples],
            nearness: vec![f32::NEG_INFINITY; samples],
            facing: vec![1.0; samples],
        }
    }

    /// Size in samples: what a camera for this canvas has to be fitted to.
    pub fn samples(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// Samples per pixel along a side: how much wider than in pixels a line has to be.
    pub fn oversampling(&self) -> f64 {
        self.oversampling as f64
    }

    /// Fills a triangle given in screen coordinates.
    fn triangle(&mut self, [a, b, c]: [[f64; 3]; 3], colour: Colour, facing: f32) {
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if area == 0.0 || !area.is_finite() {
            return;
        }
        let span = |axis: usize, count: usize| {
            let (low, high) = (a[axis].min(b[axis]).min(c[axis]), a[axis].max(b[axis]).max(c[axis]));
            let clamp = |v: f64| v.clamp(0.0, count as f64) as usize;
            clamp((low - 0.5).ceil())..clamp((high + 0.5).floor())
        };
        for y in span(1, self.height) {
            for x in span(0, self.width) {
                let (px, py) = (x as f64 + 0.5, y as f64 + 0.5);
                let wb = ((px - a[0]) * (c[1] - a[1]) - (py - a[1]) * (c[0] - a[0])) / area;
                let wc = ((b[0] - a[0]) * (py - a[1]) - (b[1] - a[1]) * (px - a[0])) / area;
                if wb >= -1e-9 && wc >= -1e-9 && wb + wc <= 1.0 + 1e-9 {
                    self.set(x, y, a[2] + wb * (b[2] - a[2]) + wc * (c[2] - a[2]), colour, facing);
                }
            }
        }
    }

    /// Draws a line of this width in samples where nothing is in front of it.
    pub fn line(&mut self, a: [f64; 3], b: [f64; 3], width: f64, colour: Colour) {
        let steps = (b[0] - a[0]).abs().max((b[1] - a[1]).abs()).ceil().clamp(1.0, 1e5) as usize;
        for step in 0..=steps {
            let t = step as f64 / steps as f64;
            self.disc(std::array::from_fn(|i| a[i] + t * (b[i] - a[i])), width / 2.0, colour);
        }
    }

    /// Draws a disc of this radius in samples where nothing is in front of it.
    pub fn disc(&mut self, centre: [f64; 3], radius: f64, colour: Colour) {
        let span = |v: f64, count: usize| {
            let clamp = |v: f64| v.clamp(0.0, count as f64) as usize;
            clamp((v - radius).floor())..clamp((v + radius).ceil() + 1.0)
        };
        for y in span(centre[1], self.height) {
            for x in span(centre[0], self.width) {
                let (dx, dy) = (x as f64 + 0.5 - centre[0], y as f64 + 0.5 - centre[1]);
                if dx * dx + dy * dy <= radius * radius {
                    self.set(x, y, centre[2], colour, 1.0);
                }
            }
        }
    }

    fn set(&mut self, x: usize, y: usize, near: f64, colour: Colour, facing: f32) {
        let index = y * self.width + x;
        if let (Some(nearness), Some(sample)) = (self.nearness.get_mut(index), self.colours.get_mut(index))
            && near as f32 >= *nearness
        {
            *nearness = near as f32;
            *sample = colour;
            self.facing[index] = facing;
        }
    }

    /// Lights the faces by how squarely they face the lamp, and leaves dark what lies in the shadow of the depth picture
    /// `light` that was taken from the lamp.
    pub fn shade(&mut self, camera: &Camera, light: &Self, lamp: &Camera) {
        for (index, (colour, &near)) in self.colours.iter_mut().zip(&self.nearness).enumerate() {
            let facing = self.facing[index];
            if !near.is_finite() {
                continue;
            }
            let place = [(index % self.width) as f64 + 0.5, (index / self.width) as f64 + 0.5, f64::from(near)];
            let lit = lamp.project(&camera.unproject(place));
            // A sample of the depth picture is off by its own width over the slope against the light.
            let slope = f64::from((1.0 - facing * facing).sqrt() / facing.max(0.05));
            let bias = 0.03 + (1.0 + 1.5 * slope) / lamp.scale;
            let shadow = facing <= 0.0 || f64::from(light.nearest(lit[0], lit[1])) > lit[2] + bias;
            let brightness = 0.48 + if shadow { 0.0 } else { 0.52 * facing };
            *colour = colour.map(|c| c * brightness);
        }
    }

    fn nearest(&self, x: f64, y: f64) -> f32 {
        if x < 0.0 || y < 0.0 || x >= self.width as f64 || y >= self.height as f64 {
            return f32::NEG_INFINITY;
        }
        self.nearness[y as usize * self.width + x as usize]
    }

    /// Fills a triangle of the scene, which the lamp meets at an angle of cosine `facing`.
    pub fn face(&mut self, camera: &Camera, triangle: &[Point3<f64>; 3], colour: Colour, facing: f32) {
        self.triangle(triangle.map(|p| camera.project(&p)), colour, facing);
    }

    /// The picture in its own size, samples averaged in linear light.
    pub fn finish(&self) -> Option<Pixmap> {
        let side = self.oversampling;
        let [width, height] = [self.width, self.height].map(|s| s / side);
        let mut pixmap = Pixmap::new(width as u32, height as u32)?;
        for (index, pixel) in pixmap.pixels_mut().iter_mut().enumerate() {
            let (x, y) = (index % width * side, index / width * side);
            let mut sum = [0.0; 3];
            for sample in (0..side).flat_map(|row| {
                let start = (y + row) * self.width + x;
                &self.colours[start..start + side]
            }) {
                sum = std::array::from_fn(|i| sum[i] + sample[i]);
            }
            let mean = sum.map(|s| s / (side * side) as f32);
            let [r, g, b] = mean.map(encode);
            *pixel = ColorU8::from_rgba(r, g, b, 255).premultiply();
        }
        Some(pixmap)
    }
}

/// Linear light to an sRGB byte.
pub fn encode(linear: f32) -> u8 {
    let linear = linear.clamp(0.0, 1.0);
    let curved = if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    (curved * 255.0).round() as u8
}

/// An sRGB colour in linear light.
pub fn srgb(bytes: [u8; 3]) -> Colour {
    bytes.map(|b| {
        let value = f32::from(b) / 255.0;
        if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
    })
}
