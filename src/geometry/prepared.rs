//! A polygon made ready for many questions.

use geo::{LineString, MultiPolygon};

/// A polygon in a local frame, its edges sorted into horizontal bands, so that a question looks at few of them.
#[derive(Debug)]
pub struct PreparedPolygon {
    /// Edges, lower end first: the two polygons at a shared edge then compute the same crossing.
    edges: Vec<[[f64; 2]; 2]>,
    min: [f64; 2],
    max: [f64; 2],
    bands: Vec<Vec<u32>>,
    band_height: f64,
}

impl PreparedPolygon {
    /// Prepares `polygon`.
    pub fn new(polygon: &MultiPolygon<f64>) -> Self {
        let rings = polygon.iter().flat_map(|p| std::iter::once(p.exterior()).chain(p.interiors()));
        Self::of_edges(rings.flat_map(LineString::lines).map(|line| {
            let (a, b) = (line.start, line.end);
            [[a.x, a.y], [b.x, b.y]]
        }))
    }

    /// Prepares the polygon of these edges, which make closed rings; what an odd number of rings holds is inside.
    pub fn of_edges(edges: impl IntoIterator<Item = [[f64; 2]; 2]>) -> Self {
        let upwards = |[a, b]: [[f64; 2]; 2]| if a[1] <= b[1] { [a, b] } else { [b, a] };
        let edges: Vec<_> = edges.into_iter().map(upwards).collect();
        let (mut min, mut max) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for end in edges.iter().flatten() {
            for axis in 0..2 {
                min[axis] = min[axis].min(end[axis]);
                max[axis] = max[axis].max(end[axis]);
            }
        }
        let count = (edges.len() / 2).clamp(1, 256);
        let band_height = ((max[1] - min[1]) / count as f64).max(f64::MIN_POSITIVE);
        let mut prepared = Self { edges: Vec::new(), min, max, bands: vec![Vec::new(); count], band_height };
        for (index, [low, high]) in edges.iter().enumerate() {
            for band in prepared.bands_between(low[1], high[1]) {
                prepared.bands[band].push(index as u32);
            }
        }
        prepared.edges = edges;
        prepared
    }

    /// Whether `point` is inside. Half-open: of two polygons that share an edge, a point on it belongs to one.
    pub fn contains(&self, point: [f64; 2]) -> bool {
        if (0..2).any(|axis| point[axis] < self.min[axis] || point[axis] > self.max[axis]) {
            return false;
        }
        let [x, y] = point;
        let mut inside = false;
        for &index in &self.bands[self.band(y)] {
            let [low, high] = self.edges[index as usize];
            if low[1] <= y && y < high[1] {
                let side = (high[0] - low[0]) * (y - low[1]) - (x - low[0]) * (high[1] - low[1]);
                inside ^= side > 0.0;
            }
        }
        inside
    }

    /// Distance from `point` to the nearest edge; infinite when that is more than `limit`.
    pub fn boundary_distance(&self, point: [f64; 2], limit: f64) -> f64 {
        let apart = (0..2).any(|axis| point[axis] < self.min[axis] - limit || point[axis] > self.max[axis] + limit);
        if apart {
            return f64::INFINITY;
        }
        let mut nearest = limit * limit;
        let mut found = false;
        for band in self.bands_between(point[1] - limit, point[1] + limit) {
            for &index in &self.bands[band] {
                let distance = squared_distance(point, self.edges[index as usize]);
                if distance <= nearest {
                    nearest = distance;
                    found = true;
                }
            }
        }
        if found { nearest.sqrt() } else { f64::INFINITY }
    }

    fn band(&self, y: f64) -> usize {
        // A cast from float to integer saturates, so y below the polygon gives band 0.
        (((y - self.min[1]) / self.band_height) as usize).min(self.bands.len() - 1)
    }

    fn bands_between(&self, low: f64, high: f64) -> std::ops::RangeInclusive<usize> {
        self.band(low)..=self.band(high)
    }
}

fn squared_distance(point: [f64; 2], [a, b]: [[f64; 2]; 2]) -> f64 {
    let along = [b[0] - a[0], b[1] - a[1]];
    let to = [point[0] - a[0], point[1] - a[1]];
    let length = along[0] * along[0] + along[1] * along[1];
    let t = if length > 0.0 { ((to[0] * along[0] + to[1] * along[1]) / length).clamp(0.0, 1.0) } else { 0.0 };
    let off = [to[0] - t * along[0], to[1] - t * along[1]];
    off[0] * off[0] + off[1] * off[1]
}
