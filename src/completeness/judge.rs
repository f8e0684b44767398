//! The judge: cells with their points, held against a model.

use std::collections::BTreeMap;

use geo::MultiPolygon;
use nalgebra::Point3;

use super::areas::{Completeness, Fault, join};
use super::lattice::{Cell, Lattice, centre};
use super::limits::Limits;
use crate::geometry::{Cover, PreparedPolygon};
use crate::site::Site;

/// What is known of a building beside its model. Everything in local metres.
#[derive(Debug, Clone, Copy)]
pub struct Scan<'a> {
    /// The footprint; without one every point counts.
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
    /// The cells that hold top points away from the outline, sorted, with these.
    tops: Vec<(Cell, Vec<u32>)>,
    /// The cells whose centre is away from the outline and near building points, sorted.
    centres: Vec<Cell>,
    /// The cells that hold ground points away from the outline, sorted; with these, and those of them that are open.
    open: Vec<(Cell, usize, Vec<u32>)>,
}

impl<'a> Judge<'a> {
    /// Sorts the points into cells.
    pub fn new(scan: &Scan<'a>, limits: &Limits) -> Self {
        // A side of nothing would have no cells.
        let limits = Limits { cell: limits.cell.max(0.1), ..*limits };
        let prepared = scan.footprint.map(PreparedPolygon::new);
        let is_judged = |place: [f64; 2]| {
            prepared.as_ref().is_none_or(|footprint| {
                footprint.contains(place) && footprint.boundary_distance(place, limits.margin) >= limits.margin
            })
        };
        let points = Lattice::new(scan.points, limits.cell);
        let ground = Lattice::new(scan.ground_points, limits.cell);
        let is_judged_point = |p: &Point3<f64>| is_judged([p.x, p.y]);
        let is_sheltered = |p: &Point3<f64>| {
            points.around([p.x, p.y], limits.roof_reach).any(|(_, other)| other.z > p.z + limits.top)
        };
        let tops = points
            .cells()
            .map(|(cell, found)| {
                let tops = found.filter(|(_, p)| is_judged_point(p) && !is_sheltered(p));
                (cell, tops.map(|(index, _)| index).collect::<Vec<u32>>())
            })
            .filter(|(_, tops)| !tops.is_empty())
            .collect();
        let open = ground
            .cells()
            .map(|(cell, found)| {
                let found: Vec<_> = found.filter(|(_, p)| is_judged_point(p)).collect();
                let open = found.iter().filter(|(_, p)| !is_sheltered(p)).map(|(index, _)| *index);
                (cell, found.len(), open.collect())
            })
            .collect();
        let mut centres = points.cells_around(limits.reach);
        centres.retain(|cell| is_judged(centre(*cell, limits.cell)));
        Self { floor: scan.floor, limits, tops, centres, open, points, ground }
    }

    /// What is wrong with a model of which these are the tops.
    pub fn judge(&self, tops: &Cover) -> Completeness {
        let areas = |faults: BTreeMap<Cell, Fault>| join(faults, self.limits.cell, self.limits.smallest);
        let missing = self.tops.iter().filter_map(|(cell, points)| Some((*cell, self.missing(points, tops)?)));
        let excess = self.centres.iter().filter_map(|cell| Some((*cell, self.excess(*cell, tops)?)));
        let roofed =
            self.open.iter().filter_map(|(cell, all, open)| Some((*cell, self.roofed(*all, open, tops)?)));
        Completeness {
            judged: self.tops.len(),
            missing: areas(missing.collect()),
            excess: areas(excess.collect()),
            roofed_ground: areas(roofed.collect()),
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
        (2 * found.len() > top_points.len()).then(|| Fault::told_by(&found))
    }

    /// Whether the model is above every point around the centre of a cell.
    fn excess(&self, cell: Cell, tops: &Cover) -> Option<Fault> {
        let place = centre(cell, self.limits.cell);
        let z = tops.highest(place[0], place[1])?;
        let mut points = Vec::new();
        let mut highest = self.floor;
        for (index, p) in self.points.around(place, self.limits.reach) {
            points.push(index);
            highest = highest.max(p.z);
        }
        let is_told = points.len() >= self.limits.fewest.max(1) as usize && z - highest > self.limits.height;
        is_told.then_some(Fault { z, height: z - highest, points })
    }

    /// Whether at least half of so many ground points of a cell lie under the model; `open` are those with nothing above.
    fn roofed(&self, all: usize, open: &[u32], tops: &Cover) -> Option<Fault> {
        let under = |&index: &u32| {
            let p = self.ground.point(index)?;
            let height = tops.highest(p.x, p.y)? - p.z;
            (height > self.limits.height).then_some((index, p.z, height))
        };
        let found: Vec<(u32, f64, f64)> = open.iter().filter_map(under).collect();
        (!found.is_empty() && 2 * found.len() >= all).then(|| Fault::told_by(&found))
    }
}
