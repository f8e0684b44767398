//! How well a building was scanned: how densely, and of how much of its footprint nothing is known.

use geo::{Area, BoundingRect};

use crate::geometry::PreparedPolygon;
use crate::site::Site;

/// Side of the cells of the plan, metres.
const CELL: f64 = 0.5;
/// What is nearer to a point than this was scanned, metres.
const REACH: f64 = 1.0;
/// Cells of a plan, at most; of larger footprints they are larger.
const MOST_CELLS: f64 = 1e6;

/// How well a building was scanned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scanned {
    /// Building points per square metre of footprint.
    pub density: f64,
    /// Share of the footprint farther than 1 m from any building point, 0 to 1.
    pub no_data: f64,
    /// Share of the footprint that the tiles cover, 0 to 1.
    pub coverage: f64,
}

impl Scanned {
    /// Of a site; one without a footprint, or with an empty one, counts as scanned if it has points.
    pub fn of(site: &Site) -> Self {
        let coverage = site.coverage.share;
        let nothing = Self { density: 0.0, no_data: 1.0, coverage };
        let Some(footprint) = &site.footprint else { return Self { no_data: 0.0, density: f64::INFINITY, coverage } };
        let (area, Some(rect)) = (footprint.unsigned_area(), footprint.bounding_rect()) else { return nothing };
        if area <= 0.0 || site.points.is_empty() {
            return nothing;
        }
        let side = CELL.max((rect.width() * rect.height() / MOST_CELLS).sqrt());
        let low = [rect.min().x, rect.min().y];
        let [columns, rows] = [rect.width(), rect.height()].map(|length| (length / side).ceil().max(1.0) as usize);
        let mut near = vec![false; columns * rows];
        let reach = (REACH / side).ceil() as i64;
        for point in &site.points {
            let [column, row] = [0, 1].map(|axis| ((point[axis] - low[axis]) / side).floor() as i64);
            for y in (row - reach).max(0)..=(row + reach).min(rows as i64 - 1) {
                for x in (column - reach).max(0)..=(column + reach).min(columns as i64 - 1) {
                    let away = [x, y].map(|cell| (cell as f64 + 0.5) * side);
                    let [dx, dy] = [0, 1].map(|axis| low[axis] + away[axis] - point[axis]);
                    if dx * dx + dy * dy <= REACH * REACH {
                        near[y as usize * columns + x as usize] = true;
                    }
                }
            }
        }
        let prepared = PreparedPolygon::new(footprint);
        let (mut all, mut empty) = (0_u64, 0_u64);
        for (cell, is_near) in near.iter().enumerate() {
            let centre = [cell % columns, cell / columns].map(|place| (place as f64 + 0.5) * side);
            if prepared.contains([low[0] + centre[0], low[1] + centre[1]]) {
                all += 1;
                empty += u64::from(!is_near);
            }
        }
        let no_data = if all == 0 { 0.0 } else { empty as f64 / all as f64 };
        Self { density: site.points.len() as f64 / area, no_data, coverage }
    }
}

#[cfg(test)]
mod tests {
    use geo::{MultiPolygon, polygon};
    use nalgebra::Point3;

    use super::*;
    use crate::site::Frame;

    #[test]
    fn half_a_roof_is_half_scanned() {
        let footprint = polygon![(x: 0.0, y: 0.0), (x: 20.0, y: 0.0), (x: 20.0, y: 10.0), (x: 0.0, y: 10.0)];
        let footprint = MultiPolygon(vec![footprint]);
        let frame = Frame { origin: [0.0; 3], metres_per_unit: [1.0; 3] };
        let points = (0..200).map(|i| Point3::new(0.5 + f64::from(i % 10), 0.5 + f64::from(i / 20), 5.0)).collect();
        let found = Scanned::of(&Site::new("half", frame, points, 0.0).with_footprint(&footprint));
        // The last points are at 9.5 m: up to 10.5 m is near them.
        assert!((found.no_data - 0.475).abs() < 0.02 && found.coverage == 1.0, "{found:?}");
        assert!((found.density - 0.5).abs() < 1e-9, "{found:?}");
        let none = Scanned::of(&Site::new("none", frame, Vec::new(), 0.0).with_footprint(&footprint));
        assert_eq!((none.density, none.no_data), (0.0, 1.0));
    }
}
