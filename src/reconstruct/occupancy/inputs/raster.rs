//! The global branch: the building seen from above.

use nalgebra::Point2;

use super::Inputs;

/// The raster reaches so far from the origin of the field frame along x and y.
pub const HALF_WIDTH: f64 = 0.55;

/// How many layers of heights between ground and highest roof the points are counted in.
const LAYERS: usize = 8;

/// What is told of each pixel, in this order.
pub const RASTER_CHANNELS: [&str; 11 + LAYERS] = [
    "hit",
    "count",
    "lowest",
    "mean",
    "highest",
    "layer_0",
    "layer_1",
    "layer_2",
    "layer_3",
    "layer_4",
    "layer_5",
    "layer_6",
    "layer_7",
    "on_plane",
    "plane_upward",
    "evidence_flag",
    "evidence_height",
    "footprint_flag",
    "footprint_distance",
];

/// Sums over the points of one pixel.
#[derive(Debug, Clone, Copy)]
struct Pixel {
    count: f64,
    lowest: f64,
    highest: f64,
    sum: f64,
    layers: [f64; LAYERS],
    on_plane: f64,
    upward: f64,
}

impl Pixel {
    const EMPTY: Self = Self {
        count: 0.0,
        lowest: f64::INFINITY,
        highest: f64::NEG_INFINITY,
        sum: 0.0,
        layers: [0.0; LAYERS],
        on_plane: 0.0,
        upward: 0.0,
    };
}

impl Inputs<'_> {
    /// The raster [[`RASTER_CHANNELS`], `grid`, `grid`]: rows along y, columns along x, both ascending.
    ///
    /// - `hit`, `count` (logarithm of one more, over 3), `lowest`, `mean`, `highest` (field frame) of the points, and
    ///   `layer_…`: the same count in eight layers between the ground and the highest roof point.
    /// - `on_plane`: share of the points on a primitive; `plane_upward`: mean |z| of the normals of their planes.
    /// - `evidence_…`: whether and at which height (field frame) the vote sees a roof at the pixel's centre.
    /// - `footprint_…`: whether the centre lies in the footprint, and the distance to its outline (positive inside, over
    ///   a quarter of the scale, −1 to 1); 0 without a footprint.
    pub fn raster(&self, grid: usize) -> Vec<f32> {
        let mut pixels = vec![Pixel::EMPTY; grid * grid];
        let roof = (self.building.hypotheses.bounds.max[2] - self.origin.z).max(1e-3);
        for (point, owner) in self.building.site.points.iter().zip(self.owners.iter()) {
            let p = self.to_field(point);
            let index = |v: f64| ((v + HALF_WIDTH) / (2.0 * HALF_WIDTH) * grid as f64).floor();
            let (column, row) = (index(p.x), index(p.y));
            if column < 0.0 || row < 0.0 || column >= grid as f64 || row >= grid as f64 {
                continue;
            }
            let pixel = &mut pixels[row as usize * grid + column as usize];
            pixel.count += 1.0;
            pixel.lowest = pixel.lowest.min(p.z);
            pixel.highest = pixel.highest.max(p.z);
            pixel.sum += p.z;
            let layer = (point.z - self.origin.z) / roof * LAYERS as f64;
            pixel.layers[layer.clamp(0.0, LAYERS as f64 - 1.0) as usize] += 1.0;
            if let Some(primitive) = owner.and_then(|label| self.primitive(label)) {
                pixel.on_plane += 1.0;
                pixel.upward += primitive.plane.normal.z.abs();
            }
        }
        let size = grid * grid;
        let mut raster = vec![0.0_f32; RASTER_CHANNELS.len() * size];
        for (i, pixel) in pixels.iter().enumerate() {
            let centre = self.centre(i % grid, i / grid, grid);
            let mut numbers = [0.0; RASTER_CHANNELS.len()];
            if pixel.count > 0.0 {
                numbers[0] = 1.0;
                numbers[1] = logarithmic(pixel.count);
                numbers[2] = pixel.lowest;
                numbers[3] = pixel.sum / pixel.count;
                numbers[4] = pixel.highest;
                for (number, count) in numbers[5..].iter_mut().zip(pixel.layers) {
                    *number = logarithmic(count);
                }
                numbers[5 + LAYERS] = pixel.on_plane / pixel.count;
                numbers[6 + LAYERS] = if pixel.on_plane > 0.0 { pixel.upward / pixel.on_plane } else { 0.0 };
            }
            if let Some(roof) = self.evidence.height(&centre) {
                numbers[7 + LAYERS] = 1.0;
                numbers[8 + LAYERS] = (roof - self.origin.z) / self.scale;
            }
            if let Some(outline) = &self.outline {
                let distance = outline.distance(&centre);
                numbers[9 + LAYERS] = f64::from(u8::from(distance > 0.0));
                numbers[10 + LAYERS] = (distance / (0.25 * self.scale)).clamp(-1.0, 1.0);
            }
            for (channel, number) in numbers.into_iter().enumerate() {
                raster[channel * size + i] = number as f32;
            }
        }
        raster
    }

    /// Centre of a pixel, local metres.
    fn centre(&self, column: usize, row: usize, grid: usize) -> Point2<f64> {
        let at = |index: usize| (2.0 * (index as f64 + 0.5) / grid as f64 - 1.0) * HALF_WIDTH * self.scale;
        Point2::new(self.origin.x + at(column), self.origin.y + at(row))
    }
}

/// Tames a count.
fn logarithmic(count: f64) -> f64 {
    count.ln_1p() / 3.0
}

/// The code of a place: the values of the `channels` maps of a `grid` × `grid` raster at `(x, y)` of the field frame,
/// bilinear between pixel centres and constant beyond the outer ones. Appends to `values`.
pub fn lookup(maps: &[f32], channels: usize, grid: usize, x: f64, y: f64, values: &mut Vec<f32>) {
    let at = |v: f64| (f64::midpoint(v / HALF_WIDTH, 1.0) * grid as f64 - 0.5).clamp(0.0, grid as f64 - 1.0);
    let (column, row) = (at(x), at(y));
    let (left, low) = (column.floor() as usize, row.floor() as usize);
    let (right, high) = ((left + 1).min(grid - 1), (low + 1).min(grid - 1));
    let (s, t) = ((column - left as f64) as f32, (row - low as f64) as f32);
    values.extend((0..channels).map(|channel| {
        let map = &maps[channel * grid * grid..];
        let lower = map[low * grid + left] * (1.0 - s) + map[low * grid + right] * s;
        let upper = map[high * grid + left] * (1.0 - s) + map[high * grid + right] * s;
        lower * (1.0 - t) + upper * t
    }));
}
