//! The roof map: which roof primitive is on top where.

use geo::{Area, BoundingRect, MultiPolygon, Polygon};
use nalgebra::{Point2, Point3};

use super::{Primitive, gaps};
use crate::geometry::{Aabb, PreparedPolygon};

/// A pixel outside of the building.
pub const NOTHING: u32 = u32::MAX;

/// Half-width in pixels of the band around the outline that is labelled too, so that evidence reaches the walls.
const BORDER: f64 = 1.5;
/// No map has more pixels than this, whatever the building's size: a quarter of a square kilometre at four points per
/// square metre, in 50 MB.
const MAX_PIXELS: f64 = 2_000_000.0;
/// A roof may go on into a gap as long as it does not fall this many metres below the heights at which it was seen …
const FALL: f64 = 1.0;
/// … nor rise this many above them: eaves are often hidden, ridges hardly ever.
const RISE: f64 = 0.3;
/// Regions of the map smaller than this are absorbed by their neighbours, square metres.
const SMALLEST_REGION: f64 = 1.0;

/// A raster over the footprint that holds, for every pixel, the index of the roof primitive that is seen there.
///
/// It carries the evidence of the points to where no point lies: every pixel of the footprint has a label as soon as
/// there is a roof primitive at all. Height jumps and the height-field vote are both read from it.
#[derive(Debug, Clone)]
pub struct RoofMap {
    corner: Point2<f64>,
    pixel: f64,
    columns: usize,
    rows: usize,
    labels: Vec<u32>,
    /// For every primitive, the lowest and the highest inlier.
    ranges: Vec<[f64; 2]>,
}

impl RoofMap {
    /// The map of `primitives` (those whose verticality is at most `max_verticality` are roofs) from their inliers among
    /// `points`. With a footprint every pixel in it is labelled and none beyond it; without one, every pixel
    /// close to an inlier. `None` when no roof primitive has an inlier or the area is empty.
    pub fn new(
        points: &[Point3<f64>],
        primitives: &[Primitive],
        footprint: Option<&MultiPolygon<f64>>,
        max_verticality: f64,
    ) -> Option<Self> {
        let roofs: Vec<(u32, &Primitive)> = (0u32..)
            .zip(primitives)
            .filter(|(_, p)| p.plane.verticality() <= max_verticality && !p.inliers.is_empty())
            .collect();
        let seen: Vec<Point3<f64>> =
            roofs.iter().flat_map(|(_, p)| &p.inliers).filter_map(|&i| points.get(i as usize).copied()).collect();
        let (low, high) = if let Some(rect) = footprint.and_then(BoundingRect::bounding_rect) {
            ([rect.min().x, rect.min().y], [rect.max().x, rect.max().y])
        } else {
            let aabb = Aabb::of(&seen)?;
            ([aabb.min[0], aabb.min[1]], [aabb.max[0], aabb.max[1]])
        };
        let area = (high[0] - low[0]) * (high[1] - low[1]);
        if seen.is_empty() || !area.is_finite() || area <= 0.0 {
            return None;
        }
        // Of a building that stands askew most of the box is empty.
        let built = footprint.map_or(area, |footprint| footprint.unsigned_area().clamp(f64::MIN_POSITIVE, area));
        let spacing = (built / seen.len() as f64).sqrt().clamp(0.1, 2.0);
        let pixel = (0.7 * spacing).clamp(0.2, 1.0).max((area / MAX_PIXELS).sqrt());
        let margin = 2.0 * pixel;
        let corner = Point2::new(low[0] - margin, low[1] - margin);
        let size = |axis: usize| (((high[axis] - low[axis] + 2.0 * margin) / pixel).ceil() as usize).max(1);
        let (columns, rows) = (size(0), size(1));
        let mut map = Self {
            corner,
            pixel,
            columns,
            rows,
            labels: vec![NOTHING; columns * rows],
            ranges: height_ranges(points, primitives),
        };
        let reach = 1.5 * spacing.max(pixel);
        let weights = map.splat(points, &roofs, reach);
        let inside = if let Some(footprint) = footprint {
            map.rasterise(footprint)
        } else {
            // At the edge of a roof half of the kernel lies over points.
            let edge = std::f64::consts::PI / 6.0 * (reach / spacing).powi(2);
            let mut inside: Vec<bool> = weights.iter().map(|&weight| weight >= edge).collect();
            let squares = roofs.iter().map(|(_, roof)| roof.inliers.len() as f64 * roof.residual.powi(2));
            let noise = (squares.sum::<f64>() / seen.len() as f64).sqrt();
            gaps::close(&mut inside, columns, (gaps::bridged(&seen, noise) / pixel).round() as usize);
            inside
        };
        map.assert(primitives);
        map.fill_and_mask(&inside, primitives);
        map.smooth();
        map.absorb_small_regions();
        Some(map)
    }

    /// Side of a pixel in metres.
    pub fn pixel(&self) -> f64 {
        self.pixel
    }

    /// Columns and rows.
    pub fn size(&self) -> [usize; 2] {
        [self.columns, self.rows]
    }

    /// Label of a pixel: an index of a primitive, or [`NOTHING`].
    pub fn label(&self, column: usize, row: usize) -> u32 {
        if column < self.columns {
            self.labels.get(row * self.columns + column).copied().unwrap_or(NOTHING)
        } else {
            NOTHING
        }
    }

    /// The height up to which the roof of a label reaches at most: little more than where it was seen, however steep.
    pub fn top(&self, label: u32) -> f64 {
        self.ranges.get(label as usize).map_or(f64::INFINITY, |[_, high]| high + RISE)
    }

    /// Centre of a pixel in local metres.
    pub fn centre(&self, column: usize, row: usize) -> Point2<f64> {
        Point2::new(self.corner.x + (column as f64 + 0.5) * self.pixel, self.corner.y + (row as f64 + 0.5) * self.pixel)
    }

    /// The pixel that holds a point of the plan; `None` off the map.
    pub fn pixel_at(&self, p: &Point2<f64>) -> Option<[usize; 2]> {
        let index = |value: f64, count: usize| {
            let cell = (value / self.pixel).floor();
            (cell >= 0.0 && cell < count as f64).then_some(cell as usize)
        };
        Some([index(p.x - self.corner.x, self.columns)?, index(p.y - self.corner.y, self.rows)?])
    }

    /// The columns or rows whose centres lie between two coordinates.
    pub fn range(&self, axis: usize, from: f64, to: f64) -> std::ops::Range<usize> {
        let (start, count) = if axis == 0 { (self.corner.x, self.columns) } else { (self.corner.y, self.rows) };
        let index = |value: f64| ((value - start) / self.pixel - 0.5).ceil().clamp(0.0, count as f64) as usize;
        let (first, last) = (index(from), index(to));
        first..last.max(first)
    }

    /// For each of `count` labels the corners, in the plan, of the first and the last of its pixels in every row: their
    /// convex hull is that of all its pixels.
    pub fn extremes(&self, count: usize) -> Vec<Vec<Point2<f64>>> {
        let half = self.pixel / 2.0;
        let mut corners = vec![Vec::new(); count];
        // For each label the first and last column of the row at hand.
        let mut spans: Vec<Option<[usize; 2]>> = vec![None; count];
        let mut seen = Vec::new();
        for (row, labels) in self.labels.chunks_exact(self.columns).enumerate() {
            for (column, &label) in labels.iter().enumerate() {
                let Some(span) = spans.get_mut(label as usize) else { continue };
                if let Some([_, last]) = span {
                    *last = column;
                } else {
                    *span = Some([column, column]);
                    seen.push(label as usize);
                }
            }
            for label in seen.drain(..) {
                let Some([first, last]) = spans[label].take() else { continue };
                let (low, high) = (self.centre(first, row), self.centre(last, row));
                corners[label].extend([
                    Point2::new(low.x - half, low.y - half),
                    Point2::new(high.x + half, low.y - half),
                    Point2::new(high.x + half, low.y + half),
                    Point2::new(low.x - half, low.y + half),
                ]);
            }
        }
        corners
    }

    /// Every pixel takes the label with the largest sum of kernel weights of inliers within `reach` metres. Returns the
    /// sum over all labels.
    fn splat(&mut self, points: &[Point3<f64>], roofs: &[(u32, &Primitive)], reach: f64) -> Vec<f64> {
        let mut sum = vec![0.0_f64; self.labels.len()];
        let mut best = vec![0.0_f64; self.labels.len()];
        let mut weight = vec![0.0_f64; self.labels.len()];
        let mut touched = Vec::new();
        for &(label, primitive) in roofs {
            for point in primitive.inliers.iter().filter_map(|&i| points.get(i as usize)) {
                for row in self.range(1, point.y - reach, point.y + reach) {
                    for column in self.range(0, point.x - reach, point.x + reach) {
                        let d = (self.centre(column, row) - point.xy()).norm() / reach;
                        if d < 1.0 {
                            let i = row * self.columns + column;
                            if weight[i] == 0.0 {
                                touched.push(i);
                            }
                            weight[i] += (1.0 - d * d).powi(2);
                        }
                    }
                }
            }
            for i in touched.drain(..) {
                sum[i] += weight[i];
                if weight[i] > best[i] {
                    best[i] = weight[i];
                    self.labels[i] = label;
                }
                weight[i] = 0.0;
            }
        }
        sum
    }

    /// Where a person says that there is a roof, there is one, whatever was scanned.
    fn assert(&mut self, primitives: &[Primitive]) {
        for (label, corners) in (0u32..).zip(primitives).filter_map(|(label, p)| Some((label, p.asserted()?))) {
            let Some(bounds) = Aabb::of(corners) else { continue };
            let ring = corners.iter().map(|p| (p.x, p.y)).collect();
            let prepared = PreparedPolygon::new(&MultiPolygon(vec![Polygon::new(ring, Vec::new())]));
            for row in self.range(1, bounds.min[1], bounds.max[1]) {
                for column in self.range(0, bounds.min[0], bounds.max[0]) {
                    let p = self.centre(column, row);
                    if prepared.contains([p.x, p.y]) {
                        self.labels[row * self.columns + column] = label;
                    }
                }
            }
        }
    }

    /// Which pixels lie in the footprint or within [`BORDER`] pixels of its outline.
    fn rasterise(&self, footprint: &MultiPolygon<f64>) -> Vec<bool> {
        let mut inside = vec![false; self.labels.len()];
        let lines: Vec<geo::Line<f64>> = footprint
            .iter()
            .flat_map(|p| std::iter::once(p.exterior()).chain(p.interiors()))
            .flat_map(geo::LineString::lines)
            .collect();
        let mut crossings = Vec::new();
        for row in 0..self.rows {
            let y = self.centre(0, row).y;
            crossings.clear();
            crossings.extend(
                lines
                    .iter()
                    .filter(|l| (l.start.y > y) != (l.end.y > y))
                    .map(|l| l.start.x + (y - l.start.y) / (l.end.y - l.start.y) * (l.end.x - l.start.x)),
            );
            crossings.sort_by(f64::total_cmp);
            for pair in crossings.chunks_exact(2) {
                for column in self.range(0, pair[0], pair[1]) {
                    inside[row * self.columns + column] = true;
                }
            }
        }
        let border = BORDER * self.pixel;
        for line in &lines {
            let (a, b) = (Point2::new(line.start.x, line.start.y), Point2::new(line.end.x, line.end.y));
            let steps = ((b - a).norm() / self.pixel).ceil().max(1.0) as usize;
            for step in 0..=steps {
                let p = a + (b - a) * (step as f64 / steps as f64);
                for row in self.range(1, p.y - border, p.y + border) {
                    for column in self.range(0, p.x - border, p.x + border) {
                        inside[row * self.columns + column] = true;
                    }
                }
            }
        }
        inside
    }

    /// Clears the pixels outside and gives every empty one inside the label of the nearest labelled pixel whose roof
    /// stays near the heights at which it was seen; where there is none, of the nearest at all.
    fn fill_and_mask(&mut self, inside: &[bool], primitives: &[Primitive]) {
        for (label, _) in self.labels.iter_mut().zip(inside).filter(|(_, inside)| !**inside) {
            *label = NOTHING;
        }
        let plausible = |map: &Self, label: u32, i: usize| {
            let p = map.centre(i % map.columns, i / map.columns);
            let height = primitives.get(label as usize).and_then(|roof| roof.plane.height_at(p.x, p.y));
            height
                .zip(map.ranges.get(label as usize))
                .is_some_and(|(height, [low, high])| height > low - FALL && height < high + RISE)
        };
        let near = self.spread(&self.labels, |label, i| plausible(self, label, i));
        let all = self.spread(&near, |_, _| true);
        for (i, label) in self.labels.iter_mut().enumerate().filter(|(i, _)| inside[*i]) {
            *label = all[i];
        }
    }

    /// Lets labels grow ring by ring into empty pixels, also those outside, so that a part of a footprint without any
    /// point is reached.
    fn spread(&self, from: &[u32], may: impl Fn(u32, usize) -> bool) -> Vec<u32> {
        let mut reached = from.to_vec();
        let mut front: Vec<usize> = (0..reached.len()).filter(|&i| reached[i] != NOTHING).collect();
        while !front.is_empty() {
            let mut next = Vec::new();
            for &i in &front {
                for j in self.neighbours(i).into_iter().flatten() {
                    if reached[j] == NOTHING && may(reached[i], j) {
                        reached[j] = reached[i];
                        next.push(j);
                    }
                }
            }
            front = next;
        }
        reached
    }

    fn neighbours(&self, i: usize) -> [Option<usize>; 4] {
        let column = i % self.columns;
        [
            (column > 0).then(|| i - 1),
            (column + 1 < self.columns).then_some(i + 1),
            i.checked_sub(self.columns),
            (i + self.columns < self.labels.len()).then_some(i + self.columns),
        ]
    }

    /// Two passes of a 3×3 mode filter: takes the fringe off the borders between regions.
    fn smooth(&mut self) {
        for _ in 0..2 {
            let before = self.labels.clone();
            for row in 1..self.rows.saturating_sub(1) {
                for column in 1..self.columns.saturating_sub(1) {
                    let i = row * self.columns + column;
                    if before[i] == NOTHING {
                        continue;
                    }
                    let window: [u32; 9] =
                        std::array::from_fn(|k| before[i + (k / 3) * self.columns + k % 3 - self.columns - 1]);
                    if window.iter().all(|&l| l == before[i]) {
                        continue;
                    }
                    let votes = |label: u32| window.iter().filter(|&&l| l == label).count();
                    let own = votes(before[i]);
                    let winner =
                        window.iter().filter(|&&l| l != NOTHING).max_by_key(|&&l| (votes(l), std::cmp::Reverse(l)));
                    if let Some(&label) = winner.filter(|&&l| votes(l) > own) {
                        self.labels[i] = label;
                    }
                }
            }
        }
    }

    /// Connected regions under [`SMALLEST_REGION`] take the label that most of their border pixels see.
    fn absorb_small_regions(&mut self) {
        let least = (SMALLEST_REGION / (self.pixel * self.pixel)).ceil() as usize;
        let mut visited = vec![false; self.labels.len()];
        for start in 0..self.labels.len() {
            if visited[start] || self.labels[start] == NOTHING {
                continue;
            }
            let label = self.labels[start];
            visited[start] = true;
            let mut region = vec![start];
            let mut border: Vec<u32> = Vec::new();
            let mut head = 0;
            while let Some(&i) = region.get(head) {
                head += 1;
                for j in self.neighbours(i).into_iter().flatten() {
                    if self.labels[j] == label {
                        if !visited[j] {
                            visited[j] = true;
                            region.push(j);
                        }
                    } else if self.labels[j] != NOTHING {
                        border.push(self.labels[j]);
                    }
                }
            }
            if region.len() < least && !border.is_empty() {
                border.sort_unstable();
                let mode = border.chunk_by(|a, b| a == b).max_by_key(|run| run.len()).and_then(|run| run.first());
                if let Some(&winner) = mode {
                    for i in region {
                        self.labels[i] = winner;
                    }
                }
            }
        }
    }
}

/// Lowest and highest inlier of every primitive, or corner of one that is asserted.
fn height_ranges(points: &[Point3<f64>], primitives: &[Primitive]) -> Vec<[f64; 2]> {
    let range = |primitive: &Primitive| {
        let asserted = primitive.asserted().into_iter().flatten();
        let heights = primitive.inliers.iter().filter_map(|&i| points.get(i as usize)).chain(asserted).map(|p| p.z);
        heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], z| [low.min(z), high.max(z)])
    };
    primitives.iter().map(range).collect()
}
