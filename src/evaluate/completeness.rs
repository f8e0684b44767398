//! What was scanned and is not in a model, and what is in it and was not scanned, building by building.

use std::sync::Arc;

use geo::{LineString, MultiPolygon, Polygon};
use nalgebra::Point3;
use rayon::prelude::*;
use serde::Serialize;

use super::outlines::Outlines;
use super::shape::Shape;
use crate::completeness::{self, Completeness, Extents, Judge, Limits, Scan};
use crate::site::Frame;

/// The completeness of one building.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BuildingCompleteness {
    /// Cells of the plan that were judged.
    pub judged: usize,
    /// What the areas come to.
    #[serde(flatten)]
    pub extents: Extents,
    /// The areas, fault by fault, the largest first.
    pub areas: Vec<FaultyArea>,
}

/// What is wrong with an area.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Fault {
    /// Scanned above the model.
    Missing,
    /// Modelled above everything that was scanned around.
    Excess,
    /// Open ground under the model.
    RoofedGround,
}

/// An area with a fault.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FaultyArea {
    /// The fault.
    pub fault: Fault,
    /// Its size, m².
    pub area: f64,
    /// A place in its midst, CRS coordinates; the height is that of what is at fault.
    pub place: [f64; 3],
    /// How far model and points are apart there, metres.
    pub height: f64,
}

/// Collects points, chunk by chunk, and judges buildings by them. It keeps every point inside an outline.
pub struct CompletenessMeter<'a> {
    shapes: &'a [Shape],
    outlines: Arc<Outlines>,
    limits: Limits,
    points: Vec<Vec<Point3<f64>>>,
    ground_points: Vec<Vec<Point3<f64>>>,
}

impl<'a> CompletenessMeter<'a> {
    /// A meter over these buildings and their outlines.
    pub fn new(shapes: &'a [Shape], outlines: Arc<Outlines>, limits: Limits) -> Self {
        let none = || vec![Vec::new(); shapes.len()];
        Self { shapes, outlines, limits, points: none(), ground_points: none() }
    }

    /// Takes building points in local metres.
    pub fn add(&mut self, points: &[Point3<f64>]) {
        distribute(&self.outlines, points, &mut self.points);
    }

    /// Takes ground points in local metres.
    pub fn add_ground(&mut self, points: &[Point3<f64>]) {
        distribute(&self.outlines, points, &mut self.ground_points);
    }

    /// The completeness over all buildings, then that of each in the order of the shapes; `None` for those without
    /// geometry or points. `frame` is that of the shapes.
    pub fn finish(self, frame: &Frame) -> (completeness::Counts, Vec<Option<BuildingCompleteness>>) {
        let limits = self.limits;
        let each: Vec<_> = self
            .shapes
            .par_iter()
            .zip(self.points)
            .zip(self.ground_points)
            .map(|((shape, mut points), mut ground_points)| {
                if shape.faces.is_empty() || points.is_empty() {
                    return None;
                }
                // The order of tiles changes nothing.
                points.sort_unstable_by(by_coordinates);
                ground_points.sort_unstable_by(by_coordinates);
                let found = judge(shape, &points, &ground_points, &limits);
                Some(BuildingCompleteness::new(&found, frame))
            })
            .collect();
        let counts = completeness::Counts::of(each.iter().flatten().map(|building| &building.extents));
        (counts, each)
    }
}

/// Judges a shape by building points and ground points inside its outline.
fn judge(shape: &Shape, points: &[Point3<f64>], ground_points: &[Point3<f64>], limits: &Limits) -> Completeness {
    let corners = shape.outline.iter().flatten();
    let floor = corners.map(|p| p.z).fold(f64::INFINITY, f64::min);
    let footprint = footprint(shape);
    let scan = Scan { footprint: Some(&footprint), floor, points, ground_points };
    Judge::new(&scan, limits).judge(&shape.roofs())
}

/// The outline of a shape as a polygon.
fn footprint(shape: &Shape) -> MultiPolygon<f64> {
    let triangles: Vec<Polygon<f64>> = shape
        .outline
        .iter()
        .map(|triangle| Polygon::new(LineString::from(triangle.map(|p| (p.x, p.y)).to_vec()), Vec::new()))
        .collect();
    geo::unary_union(&triangles)
}

impl BuildingCompleteness {
    fn new(found: &Completeness, frame: &Frame) -> Self {
        let faults = [
            (Fault::Missing, &found.missing),
            (Fault::Excess, &found.excess),
            (Fault::RoofedGround, &found.roofed_ground),
        ];
        // To the millimetre: more says nothing.
        let rounded = |value: f64| (value * 1000.0).round() / 1000.0 + 0.0;
        let areas = faults.into_iter().flat_map(|(fault, areas)| {
            areas.iter().map(move |area| FaultyArea {
                fault,
                area: area.area,
                place: frame.to_crs(&area.place).map(rounded),
                height: rounded(area.height),
            })
        });
        Self { judged: found.judged, extents: Extents::from(found), areas: areas.collect() }
    }
}

fn by_coordinates(a: &Point3<f64>, b: &Point3<f64>) -> std::cmp::Ordering {
    a.x.total_cmp(&b.x).then_with(|| a.y.total_cmp(&b.y)).then_with(|| a.z.total_cmp(&b.z))
}

/// Gives points to the buildings whose outlines they are in.
fn distribute(outlines: &Outlines, points: &[Point3<f64>], buildings: &mut [Vec<Point3<f64>>]) {
    let found: Vec<Option<usize>> = points.par_iter().map(|p| outlines.at(p.x, p.y)).collect();
    for (point, index) in points.iter().zip(found) {
        if let Some(building) = index.and_then(|index| buildings.get_mut(index)) {
            building.push(*point);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::shape::tests::block;
    use super::*;

    #[test]
    fn buildings_are_judged_by_the_points_in_their_outlines() {
        let shapes = [block("a", [0.0; 3], [10.0, 10.0, 6.0]), block("b", [20.0, 0.0, 0.0], [30.0, 10.0, 9.0])];
        let outlines = Arc::new(Outlines::new(&shapes));
        let mut meter = CompletenessMeter::new(&shapes, outlines, Limits::default());
        // A tower of 3 m × 2 m on a; of b one half was scanned at 4 m, and of the other the ground.
        let grid =
            |x0: f64| (0..400).map(move |i| (x0 + 0.25 + 0.5 * f64::from(i % 20), 0.25 + 0.5 * f64::from(i / 20)));
        let is_tower = |x: f64, y: f64| (4.0..7.0).contains(&x) && (3.0..5.0).contains(&y);
        let of_a: Vec<_> = grid(0.0).map(|(x, y)| Point3::new(x, y, if is_tower(x, y) { 9.0 } else { 6.0 })).collect();
        meter.add(&of_a);
        meter.add(&grid(20.0).filter(|(x, _)| *x < 25.0).map(|(x, y)| Point3::new(x, y, 4.0)).collect::<Vec<_>>());
        meter.add_ground(
            &grid(20.0).filter(|(x, _)| *x > 25.0).map(|(x, y)| Point3::new(x, y, 0.2)).collect::<Vec<_>>(),
        );
        meter.add(&[Point3::new(15.0, 5.0, 20.0)]);
        let frame = Frame { origin: [1000.0, 2000.0, 0.0], metres_per_unit: [1.0; 3] };
        let (counts, each) = meter.finish(&frame);
        let [Some(a), Some(b)] = &each[..] else { panic!() };
        assert_eq!(a.areas.len(), 1);
        let tower = a.areas[0];
        assert_eq!((tower.fault, tower.area, tower.height), (Fault::Missing, 6.0, 3.0));
        assert_eq!(tower.place, [1005.5, 2003.5, 9.0]);
        // Excess: four columns of eight cells, and a fifth that still sees them; ground: every cell has some in the midst.
        assert_eq!((b.extents.excess.area, b.extents.roofed_ground.area), (40.0, 50.0));
        assert_eq!((counts.buildings, counts.missing.from_4, counts.missing.from_10), (2, 1, 0));
        assert_eq!((counts.excess.from_25, counts.roofed_ground.area), (1, 50.0));
    }

    #[test]
    fn a_building_without_points_is_not_judged() {
        let shapes = [block("a", [0.0; 3], [10.0, 10.0, 6.0])];
        let outlines = Arc::new(Outlines::new(&shapes));
        let frame = Frame { origin: [0.0; 3], metres_per_unit: [1.0; 3] };
        let (counts, each) = CompletenessMeter::new(&shapes, outlines, Limits::default()).finish(&frame);
        assert_eq!((counts.buildings, each), (0, vec![None]));
    }
}
