//! The judge: cells with their points, held against a model.

use std::collections::BTreeMap;
use std::ops::Range;

use geo::MultiPolygon;
use nalgebra::Point3;

use super::areas::{Cell, Completeness, Fault, join};
use super::limits::Limits;
use crate::geometry::{Cover, PreparedPolygon};
use crate::site::Site;

/// What is known of a building beside its model. Everything in local metres.
#[derive(Debug, Clone, Copy)]
pub struct Scan<'a> {
    /// The footprint; without one every cell is judged.
    pub footprint: Option<&'a MultiPolygon<f64>>,
    /// Height of the ground: where there is no model, that is how high it stands.
    pub floor: f64,
    /// Building points.
    pub points: &'a [Point3<f64>],
    /// Ground points inside the footprint.
    pub ground_points: &'a [Point3<f64>],
}

impl<'a> Scan<'a> {
    /// What a site knows.
    pub fn of(site: &'a Site) -> Self {
        let Site { footprint, ground, points, ground_points, .. } = site;
        Self { footprint: footprint.as_ref(), floor: ground.height, points, ground_points }
    }
}

/// Judges models of one building.
#[derive(Debug)]
pub struct Judge<'a> {
    floor: f64,
    limits: Limits,
    points: Lattice<'a>,
    ground: Lattice<'a>,
    /// The cells of the plan with building points in or around them, sorted, of which each has the top points.
    tops: Vec<(Cell, Vec<u32>)>,
}

impl<'a> Judge<'a> {
    /// Sorts the points into cells.
    pub fn new(scan: &Scan<'a>, limits: &Limits) -> Self {
        // A side of nothing would have no cells.
        let limits = Limits { cell: limits.cell.max(0.1), ..*limits };
        let prepared = scan.footprint.map(PreparedPolygon::new);
        let is_judged = |cell: &Cell| {
            let centre = centre(*cell, limits.cell);
            prepared.as_ref().is_none_or(|footprint| {
                footprint.contains(centre) && footprint.boundary_distance(centre, limits.margin) >= limits.margin
            })
        };
        let points = Lattice::new(scan.points, limits.cell);
        let mut ground = Lattice::new(scan.ground_points, limits.cell);
        ground.cells.retain(|(cell, _)| is_judged(cell));
        // The centre of a cell is half a cell from its side.
        let around = (limits.reach / limits.cell - 0.5).ceil().clamp(0.0, 16.0) as i64;
        let mut cells: Vec<Cell> = Vec::with_capacity(points.cells.len());
        for ([column, row], _) in &points.cells {
            let neighbours = (-around..=around).flat_map(|dx| (-around..=around).map(move |dy| [dx, dy]));
            cells.extend(neighbours.map(|[dx, dy]| [column + dx, row + dy]));
        }
        cells.sort_unstable();
        cells.dedup();
        cells.retain(is_judged);
        let tops = cells.into_iter().map(|cell| (cell, points.tops(cell, limits.top))).collect();
        Self { floor: scan.floor, limits, points, ground, tops }
    }

    /// What is wrong with a model of which these are the tops.
    pub fn judge(&self, tops: &Cover) -> Completeness {
        let Limits { cell: side, smallest, .. } = self.limits;
        let areas = |faults: BTreeMap<Cell, Fault>| join(faults, side, smallest);
        let of_cells = |of: &dyn Fn(Cell, &[u32]) -> Option<Fault>| {
            self.tops.iter().filter_map(|(cell, points)| Some((*cell, of(*cell, points)?))).collect()
        };
        let ground = self.ground.cells.iter();
        Completeness {
            judged: self.tops.iter().filter(|(_, points)| !points.is_empty()).count(),
            missing: areas(of_cells(&|_, points| self.missing(points, tops))),
            excess: areas(of_cells(&|cell, _| self.excess(cell, tops))),
            roofed_ground: areas(
                ground.filter_map(|(cell, range)| Some((*cell, self.roofed(range.clone(), tops)?))).collect(),
            ),
        }
    }

    /// Whether most of the top points of a cell lie above the model.
    fn missing(&self, top_points: &[u32], tops: &Cover) -> Option<Fault> {
        let over = |&index: &u32| {
            let p = self.points.point(index)?;
            let over = p.z - tops.highest(p.x, p.y).unwrap_or(self.floor).max(self.floor);
            (over > self.limits.height).then_some((index, p.z, over))
        };
        let found: Vec<(u32, f64, f64)> = top_points.iter().filter_map(over).collect();
        (2 * found.len() > top_points.len()).then(|| Fault {
            z: median(found.iter().map(|f| f.1)),
            height: median(found.iter().map(|f| f.2)),
            points: found.iter().map(|f| f.0).collect(),
        })
    }

    /// Whether the model is above every point around the centre of a cell.
    fn excess(&self, cell: Cell, tops: &Cover) -> Option<Fault> {
        let place = centre(cell, self.limits.cell);
        let z = tops.highest(place[0], place[1])?;
        let mut points = Vec::new();
        for (index, p) in self.points.around(place, self.limits.reach) {
            if p.z + self.limits.height >= z {
                return None;
            }
            points.push(index);
        }
        let highest = points.iter().filter_map(|&i| self.points.point(i)).map(|p| p.z).fold(self.floor, f64::max);
        let is_told = points.len() >= self.limits.fewest.max(1) as usize && z - highest > self.limits.height;
        is_told.then_some(Fault { z, height: z - highest, points })
    }

    /// Whether at least half of the ground points of a cell lie under the model with no building point above them.
    fn roofed(&self, ground: Range<usize>, tops: &Cover) -> Option<Fault> {
        let indices = self.ground.order.get(ground)?;
        let under = |&index: &u32| {
            let p = self.ground.point(index)?;
            let height = tops.highest(p.x, p.y)? - p.z;
            let is_built = || self.points.around([p.x, p.y], self.limits.ground_reach).any(|(_, above)| above.z > p.z);
            (height > self.limits.height && !is_built()).then_some((index, p.z, height))
        };
        let found: Vec<(u32, f64, f64)> = indices.iter().filter_map(under).collect();
        (!found.is_empty() && 2 * found.len() >= indices.len()).then(|| Fault {
            z: median(found.iter().map(|f| f.1)),
            height: median(found.iter().map(|f| f.2)),
            points: found.iter().map(|f| f.0).collect(),
        })
    }
}

/// The centre of a cell of this side.
fn centre(cell: Cell, side: f64) -> [f64; 2] {
    cell.map(|index| (index as f64 + 0.5) * side)
}

/// The upper of the two middle values; 0 of none.
fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_unstable_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or_default()
}

/// Points in the cells of the plan.
#[derive(Debug)]
struct Lattice<'a> {
    points: &'a [Point3<f64>],
    side: f64,
    /// The points cell by cell, ascending in each.
    order: Vec<u32>,
    /// The cells that hold points, sorted, each with its points in `order`.
    cells: Vec<(Cell, Range<usize>)>,
}

impl<'a> Lattice<'a> {
    /// Points that are not finite are in no cell.
    fn new(points: &'a [Point3<f64>], side: f64) -> Self {
        let cell = |p: &Point3<f64>| [p.x, p.y].map(|c| (c / side).floor() as i64);
        let finite = points.iter().zip(0_u32..).filter(|(p, _)| p.iter().all(|c| c.is_finite() && c.abs() < 1e12));
        let mut keyed: Vec<(Cell, u32)> = finite.map(|(p, index)| (cell(p), index)).collect();
        keyed.sort_unstable();
        let mut cells: Vec<(Cell, Range<usize>)> = Vec::new();
        for (place, (cell, _)) in keyed.iter().enumerate() {
            match cells.last_mut() {
                Some((last, range)) if last == cell => range.end = place + 1,
                _ => cells.push((*cell, place..place + 1)),
            }
        }
        Self { points, side, order: keyed.into_iter().map(|(_, index)| index).collect(), cells }
    }

    fn point(&self, index: u32) -> Option<&'a Point3<f64>> {
        self.points.get(index as usize)
    }

    /// The points of a cell at most `depth` metres below its highest.
    fn tops(&self, cell: Cell, depth: f64) -> Vec<u32> {
        let found = self.cells.binary_search_by_key(&cell, |(cell, _)| *cell).ok();
        let range = found.and_then(|place| self.cells.get(place)).map(|(_, range)| range.clone());
        let indices = range.and_then(|range| self.order.get(range)).unwrap_or_default();
        let height = |index: &u32| self.point(*index).map_or(f64::NEG_INFINITY, |p| p.z);
        let highest = indices.iter().map(height).fold(f64::NEG_INFINITY, f64::max);
        indices.iter().filter(|index| height(index) >= highest - depth).copied().collect()
    }

    /// The points at most `reach` metres from a place of the plan.
    fn around(&self, place: [f64; 2], reach: f64) -> impl Iterator<Item = (u32, &'a Point3<f64>)> + '_ {
        let [columns, rows] =
            place.map(|c| ((c - reach) / self.side).floor() as i64..=((c + reach) / self.side).floor() as i64);
        columns
            .flat_map(move |column| {
                // The cells of a column stand one after the other.
                let from = self.cells.partition_point(|(cell, _)| *cell < [column, *rows.start()]);
                let to = self.cells.partition_point(|(cell, _)| *cell <= [column, *rows.end()]);
                self.cells.get(from..to.max(from)).unwrap_or_default()
            })
            .flat_map(|(_, range)| self.order.get(range.clone()).unwrap_or_default())
            .filter_map(move |&index| {
                let p = self.point(index)?;
                let near = (p.x - place[0]).powi(2) + (p.y - place[1]).powi(2) <= reach * reach;
                near.then_some((index, p))
            })
    }
}
