//! A raster of what is nearer: open ground or something built.

use geo::{MultiPolygon, Rect, coord};
use nalgebra::Point2;

/// Side of a pixel, metres, where the area is not too large for it.
const PIXEL: f64 = 0.25;
/// No raster has more pixels than this.
const MAX_PIXELS: f64 = 250_000.0;

/// A raster of the plan with a mark on every pixel that is open ground.
#[derive(Debug)]
pub(super) struct Pixels {
    corner: Point2<f64>,
    side: f64,
    columns: usize,
    rows: usize,
    open: Vec<bool>,
}

/// Connected pixels of open ground, ascending.
#[derive(Debug)]
pub(super) struct Piece(Vec<usize>);

impl Pixels {
    /// A raster with no mark that reaches `margin` metres beyond some points; `None` without any.
    pub fn around(points: &[Point2<f64>], margin: f64) -> Option<Self> {
        let first = *points.first()?;
        let (mut low, mut high) = (first, first);
        for p in points {
            (low, high) = (low.inf(p), high.sup(p));
        }
        let size = (high - low).add_scalar(2.0 * margin);
        let side = PIXEL.max((size.x * size.y / MAX_PIXELS).sqrt());
        // One pixel more all around, so that nothing is open at the border.
        let count = |length: f64| (length / side).ceil() as usize + 2;
        let (columns, rows) = (count(size.x), count(size.y));
        let corner = low - nalgebra::Vector2::repeat(margin + side);
        Some(Self { corner, side, columns, rows, open: vec![false; columns * rows] })
    }

    /// Marks the pixels that are at most `reach` metres from a point of `open` and nearer to it than to one of `built`.
    pub fn set_nearer(&mut self, open: &[Point2<f64>], built: impl Iterator<Item = Point2<f64>>, reach: f64) {
        let mut to_open = vec![f64::INFINITY; self.open.len()];
        let mut to_built = to_open.clone();
        for p in open {
            self.reach_out(p, reach, &mut to_open);
        }
        for p in built {
            self.reach_out(&p, reach, &mut to_built);
        }
        for (mark, (open, built)) in self.open.iter_mut().zip(to_open.into_iter().zip(to_built)) {
            *mark = open <= reach * reach && open < built;
        }
    }

    /// Lowers the squared distances of the pixels within `reach` metres of a point to that to the point.
    fn reach_out(&self, p: &Point2<f64>, reach: f64, squares: &mut [f64]) {
        let range = |at: f64, start: f64, count: usize| {
            let index = |value: f64| (value - start) / self.side - 0.5;
            let first = index(at - reach).ceil().clamp(0.0, count as f64) as usize;
            first..(index(at + reach).floor() + 1.0).clamp(first as f64, count as f64) as usize
        };
        for row in range(p.y, self.corner.y, self.rows) {
            for column in range(p.x, self.corner.x, self.columns) {
                let i = row * self.columns + column;
                squares[i] = squares[i].min((self.centre(i) - p).norm_squared());
            }
        }
    }

    fn centre(&self, i: usize) -> Point2<f64> {
        let (column, row) = (i % self.columns, i / self.columns);
        self.corner + nalgebra::Vector2::new(column as f64 + 0.5, row as f64 + 0.5) * self.side
    }

    /// The connected pieces of open ground that are `narrowest` metres wide within `inside`, without what is narrower,
    /// but with what belongs to them beyond.
    pub fn pieces(&self, narrowest: f64, inside: impl Fn(&Point2<f64>) -> bool) -> Vec<Piece> {
        let radius = (narrowest / 2.0 / self.side).round() as usize;
        let within: Vec<bool> =
            self.open.iter().enumerate().map(|(i, open)| *open && inside(&self.centre(i))).collect();
        let core = self.spread(&self.spread(&within, radius, false), radius, true);
        // With what is open right beside it: else the fringe would be lost on one side only, and what lies beyond the
        // outline with it.
        let wide = self.spread(&core, radius, true);
        let mut left: Vec<bool> =
            core.iter().zip(wide).zip(&self.open).map(|((core, wide), open)| *core || (wide && *open)).collect();
        let mut pieces = Vec::new();
        for start in 0..left.len() {
            if !std::mem::take(&mut left[start]) {
                continue;
            }
            let mut piece = vec![start];
            let mut head = 0;
            while let Some(&i) = piece.get(head) {
                head += 1;
                for j in self.neighbours(i) {
                    if std::mem::take(&mut left[j]) {
                        piece.push(j);
                    }
                }
            }
            piece.sort_unstable();
            pieces.push(Piece(piece));
        }
        pieces
    }

    fn neighbours(&self, i: usize) -> impl Iterator<Item = usize> + use<> {
        let (column, columns, rows) = (i % self.columns, self.columns, self.rows);
        let candidates = [
            (column > 0).then(|| i - 1),
            (column + 1 < columns).then_some(i + 1),
            i.checked_sub(columns),
            (i / columns + 1 < rows).then_some(i + columns),
        ];
        candidates.into_iter().flatten()
    }

    /// Every pixel takes `value` if one in the square of `radius` pixels around it has it.
    fn spread(&self, marks: &[bool], radius: usize, value: bool) -> Vec<bool> {
        let pass = |marks: &[bool], step: usize, place: &dyn Fn(usize) -> usize, count: usize| -> Vec<bool> {
            (0..marks.len())
                .map(|i| {
                    let at = place(i);
                    let (back, forth) = (radius.min(at), radius.min(count - 1 - at));
                    let hit = (0..=back + forth).any(|k| marks[i + k * step - back * step] == value);
                    hit == value
                })
                .collect()
        };
        let along = pass(marks, 1, &|i| i % self.columns, self.columns);
        pass(&along, self.columns, &|i| i / self.columns, self.rows)
    }
}

impl Piece {
    /// Area of the pixels whose centres fulfil a condition, square metres.
    pub fn area_where(&self, pixels: &Pixels, holds: impl Fn(&Point2<f64>) -> bool) -> f64 {
        self.0.iter().filter(|&&i| holds(&pixels.centre(i))).count() as f64 * pixels.side * pixels.side
    }

    /// Whether a point lies in one of the pixels.
    pub fn holds(&self, pixels: &Pixels, p: &Point2<f64>) -> bool {
        let [column, row] = [p.x - pixels.corner.x, p.y - pixels.corner.y].map(|d| (d / pixels.side).floor());
        let on_raster = column >= 0.0 && row >= 0.0 && column < pixels.columns as f64;
        on_raster && self.0.binary_search(&(row as usize * pixels.columns + column as usize)).is_ok()
    }

    /// The outline along the sides of the pixels, local metres.
    pub fn outline(&self, pixels: &Pixels) -> MultiPolygon<f64> {
        let is_end = |a: &usize, b: &usize| a + 1 == *b && !b.is_multiple_of(pixels.columns);
        let half = pixels.side / 2.0;
        let runs = self.0.chunk_by(is_end).filter_map(|run| {
            let (low, high) = (pixels.centre(*run.first()?), pixels.centre(*run.last()?));
            let corners = [coord! { x: low.x - half, y: low.y - half }, coord! { x: high.x + half, y: high.y + half }];
            Some(Rect::new(corners[0], corners[1]).to_polygon())
        });
        geo::unary_union(&runs.collect::<Vec<_>>())
    }
}
