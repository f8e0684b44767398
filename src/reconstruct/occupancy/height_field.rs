//! The height-field vote: the baseline occupancy, which needs no network.

use nalgebra::Point3;

use super::doubt::Doubt;
use super::{Occupancy, OccupancyError};
use crate::geometry::Plane;
use crate::reconstruct::complex::OUTSIDE;
use crate::reconstruct::primitives::Primitive;
use crate::reconstruct::primitives::roof_map::{NOTHING, RoofMap};
use crate::reconstruct::{Hypotheses, Partitioned};
use crate::site::Site;

/// How much of a cell lies under the roof evidence and inside the footprint.
///
/// Vertical lines through the pixels of the [`RoofMap`] sample each cell; the vote of a line is the share of its stretch
/// within the cell that lies below the roof primitive seen there, and lines count by their length. That is an integral
/// over the volume of the cell, so that slivers and large cells are judged alike.
#[derive(Debug, Clone, Copy, Default)]
pub struct HeightField;

/// The roof evidence over the plan: a roof map, whose labels are indices of its primitives.
#[derive(Debug, Clone, Copy)]
pub(super) struct RoofEvidence<'a> {
    map: &'a RoofMap,
    primitives: &'a [Primitive],
}

impl<'a> RoofEvidence<'a> {
    /// What the hypotheses of a building say.
    pub fn new(hypotheses: &'a Hypotheses) -> Self {
        Self { map: &hypotheses.map, primitives: &hypotheses.primitives }
    }

    /// Height of the roof evidence over a point of the plan; `None` where there is none.
    pub fn height(&self, p: &nalgebra::Point2<f64>) -> Option<f64> {
        let [column, row] = self.map.pixel_at(p)?;
        self.label_height(self.map.label(column, row), p.x, p.y)
    }

    fn label_height(&self, label: u32, x: f64, y: f64) -> Option<f64> {
        if label == NOTHING {
            return None;
        }
        let height = self.primitives.get(label as usize)?.plane.height_at(x, y)?;
        Some(height.min(self.map.top(label)))
    }

    /// The vote about the cell behind these sides, in this box and around this centre.
    fn cell(
        &self,
        doubt: Option<&Doubt>,
        sides: &[Plane],
        low: &Point3<f64>,
        high: &Point3<f64>,
        centre: &Point3<f64>,
    ) -> Vote {
        let (mut inside, mut doubtful, mut total) = (0.0, 0.0, 0.0);
        for row in self.map.range(1, low.y, high.y) {
            let [west, east] = between_walls(sides, self.map.centre(0, row).y, [low.x, high.x]);
            // A pixel more at both ends: the stretches below decide, to the last bit.
            let [west, east] = [(west - self.map.pixel()).max(low.x), (east + self.map.pixel()).min(high.x)];
            for column in self.map.range(0, west, east) {
                let p = self.map.centre(column, row);
                let Some([bottom, top]) = stretch(sides, p.x, p.y, low.z, high.z) else { continue };
                total += top - bottom;
                if let Some(roof) = self.label_height(self.map.label(column, row), p.x, p.y) {
                    inside += (roof - bottom).clamp(0.0, top - bottom);
                }
                doubtful += doubt.map_or(0.0, |doubt| doubt.overlap(column, row, bottom, top));
            }
        }
        if total > 0.0 {
            return Vote { inside: inside / total, doubt: doubtful / total };
        }
        // A cell too narrow for any line of the raster is judged at its centre.
        let inside = f64::from(u8::from(self.height(&centre.xy()).is_some_and(|roof| centre.z < roof)));
        Vote { inside, doubt: 0.0 }
    }

    /// The doubt about the roofs that it sees.
    fn doubt(&self, site: &Site, hypotheses: &Hypotheses) -> Doubt {
        Doubt::new(site, hypotheses, |column, row| {
            let p = self.map.centre(column, row);
            self.label_height(self.map.label(column, row), p.x, p.y)
        })
    }
}

/// What the vote says of a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Vote {
    /// How much of the cell is inside, 0 to 1.
    pub inside: f64,
    /// How much of it is in [doubt](Doubt), 0 to 1.
    pub doubt: f64,
}

/// What the sides that stand, whose normals point out of the cell, leave of the range `x` at `y`: of a long cell that
/// runs askew only a small part of the box.
fn between_walls(sides: &[Plane], y: f64, x: [f64; 2]) -> [f64; 2] {
    let walls = sides.iter().filter(|side| side.normal.z.abs() < 1e-9 && side.normal.x.abs() > 1e-9);
    walls.fold(x, |[west, east], side| {
        let crossing = -(side.normal.y * y + side.offset) / side.normal.x;
        if side.normal.x > 0.0 { [west, east.min(crossing)] } else { [west.max(crossing), east] }
    })
}

/// The stretch of the vertical line at `(x, y)` on the inner side of all `sides`, whose normals point out of the cell.
fn stretch(sides: &[Plane], x: f64, y: f64, low: f64, high: f64) -> Option<[f64; 2]> {
    let (mut bottom, mut top) = (low, high);
    for side in sides {
        let n = side.normal;
        let at_zero = n.x * x + n.y * y + side.offset;
        if n.z.abs() < 1e-9 {
            if at_zero > 0.0 {
                return None;
            }
        } else if n.z > 0.0 {
            top = top.min(-at_zero / n.z);
        } else {
            bottom = bottom.max(-at_zero / n.z);
        }
        if bottom >= top {
            return None;
        }
    }
    Some([bottom, top])
}

impl Occupancy for HeightField {
    fn occupancy(&self, building: &Partitioned) -> Result<Vec<f64>, OccupancyError> {
        Ok(votes(building, false).into_iter().map(|vote| vote.inside).collect())
    }

    /// 1 below the roof evidence and inside the footprint, 0 elsewhere.
    fn probability(&self, building: &Partitioned, places: &[Point3<f64>]) -> Result<Vec<f64>, OccupancyError> {
        let hypotheses = &building.hypotheses;
        let evidence = RoofEvidence::new(hypotheses);
        let ground = building.site.ground.height;
        let is_inside = |p: &Point3<f64>| {
            let plan = p.xy();
            p.z > ground && hypotheses.covers(&plan) && evidence.height(&plan).is_some_and(|roof| p.z < roof)
        };
        Ok(places.iter().map(|p| f64::from(u8::from(is_inside(p)))).collect())
    }

    fn is_height_field(&self) -> bool {
        true
    }
}

/// The vote about every cell; how much it is in doubt is told if asked for.
pub(super) fn votes(building: &Partitioned, with_doubt: bool) -> Vec<Vote> {
    let complex = &building.complex;
    let evidence = RoofEvidence::new(&building.hypotheses);
    let doubt = with_doubt.then(|| evidence.doubt(building.site, &building.hypotheses));
    let planes: Vec<Plane> = complex.planes.iter().map(crate::reconstruct::complex::IntegerPlane::to_plane).collect();
    let mut sides = Vec::new();
    let cells = (0u32..).zip(&complex.cells);
    cells
        .map(|(id, cell)| {
            sides.clear();
            let (mut low, mut high) = (Point3::from([f64::INFINITY; 3]), Point3::from([f64::NEG_INFINITY; 3]));
            let (mut sum, mut corners) = (nalgebra::Vector3::zeros(), 0.0);
            for &facet in &cell.facets {
                let facet = &complex.facets[facet as usize];
                debug_assert!(facet.cells.contains(&id) && id != OUTSIDE);
                let plane = planes[facet.plane as usize];
                let out = if facet.cells[0] == id { plane } else { plane.flipped() };
                if !sides.contains(&out) {
                    sides.push(out);
                }
                for &corner in &facet.corners {
                    let p = complex.vertices[corner as usize].position;
                    (low, high) = (low.inf(&p), high.sup(&p));
                    sum += p.coords;
                    corners += 1.0;
                }
            }
            evidence.cell(doubt.as_ref(), &sides, &low, &high, &Point3::from(sum / f64::max(corners, 1.0)))
        })
        .collect()
}
