//! How well laser points agree with the buildings they fell on.

use std::sync::Arc;

use nalgebra::Point3;
use rayon::prelude::*;
use serde::Serialize;

use super::hausdorff::NearestFace;
use super::outlines::Outlines;
use super::shape::Shape;
use super::summary::DistanceSummary;
use crate::geometry::Cover;

/// Agreement of the points inside an outline with the building.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Agreement {
    /// Points inside the outline.
    pub points: usize,
    /// Those of them that have no roof above or below them, and so no vertical distance.
    pub without_roof: usize,
    /// Height of a point over the roof at its place (the one nearest in z), metres; positive above the roof. `None` when no
    /// point has a roof.
    pub vertical: Option<DistanceSummary>,
    /// Distance of a point to the nearest face of any type, metres, not negative. `None` without faces.
    pub orthogonal: Option<DistanceSummary>,
    /// Top of the model minus the highest point, metres: positive when the model shoots up over what was scanned. `None`
    /// without faces, without points, and over all buildings.
    pub top: Option<f64>,
}

/// Collects points, chunk by chunk, on the buildings that they fall on.
///
/// It keeps two 4-byte numbers per point inside an outline and nothing of the others.
pub struct PointMeter {
    buildings: Vec<Scanned>,
    outlines: Arc<Outlines>,
}

struct Scanned {
    roofs: Cover,
    nearest: Option<NearestFace>,
    top: Option<f64>,
    found: Found,
}

/// The distances of the points of one building.
#[derive(Debug, Clone)]
struct Found {
    points: usize,
    highest: f64,
    vertical: Vec<f32>,
    orthogonal: Vec<f32>,
}

impl PointMeter {
    /// A meter over these buildings, in their order.
    pub fn new(shapes: &[Shape]) -> Self {
        let buildings: Vec<Scanned> = shapes
            .par_iter()
            .map(|shape| Scanned {
                roofs: shape.roofs(),
                nearest: NearestFace::new(shape),
                top: shape.aabb().map(|aabb| aabb.max[2]),
                found: Found { points: 0, highest: f64::NEG_INFINITY, vertical: Vec::new(), orthogonal: Vec::new() },
            })
            .collect();
        Self { buildings, outlines: Arc::new(Outlines::new(shapes)) }
    }

    /// The outlines of the buildings.
    pub fn outlines(&self) -> &Arc<Outlines> {
        &self.outlines
    }

    /// The boxes around the outlines, as `[min, max]` in local metres: points outside of all of them change nothing.
    pub fn boxes(&self) -> impl Iterator<Item = [[f64; 2]; 2]> + '_ {
        self.outlines.boxes()
    }

    /// Measures points in local metres. A point inside the outlines of several buildings counts for the first of them.
    pub fn add(&mut self, points: &[Point3<f64>]) {
        let buildings = &self.buildings;
        let outlines = &self.outlines;
        let measured: Vec<(usize, f64, Option<f32>, Option<f32>)> = points
            .par_iter()
            .filter_map(|p| {
                let index = outlines.at(p.x, p.y)?;
                let building = buildings.get(index)?;
                let vertical = building.roofs.nearest_height(p.x, p.y, p.z).map(|z| (p.z - z) as f32);
                let orthogonal = building.nearest.as_ref().map(|nearest| nearest.distance(p) as f32);
                Some((index, p.z, vertical, orthogonal))
            })
            .collect();
        for (index, z, vertical, orthogonal) in measured {
            let Some(building) = self.buildings.get_mut(index) else { continue };
            building.found.points += 1;
            building.found.highest = building.found.highest.max(z);
            building.found.vertical.extend(vertical);
            building.found.orthogonal.extend(orthogonal);
        }
    }

    /// The agreement over all buildings, then that of each building in the order given to [`Self::new`].
    pub fn finish(self) -> (Agreement, Vec<Agreement>) {
        let each = self.buildings.par_iter().map(|building| building.found.agreement(building.top)).collect();
        let mut all = Found { points: 0, highest: f64::NEG_INFINITY, vertical: Vec::new(), orthogonal: Vec::new() };
        for building in self.buildings {
            all.points += building.found.points;
            all.vertical.extend(building.found.vertical);
            all.orthogonal.extend(building.found.orthogonal);
        }
        (all.agreement(None), each)
    }
}

impl Found {
    fn agreement(&self, top: Option<f64>) -> Agreement {
        Agreement {
            points: self.points,
            without_roof: self.points - self.vertical.len(),
            vertical: DistanceSummary::of(self.vertical.iter().copied()),
            orthogonal: DistanceSummary::of(self.orthogonal.iter().copied()),
            top: top.filter(|_| self.points > 0).map(|top| top - self.highest),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::shape::tests::block;
    use super::*;

    #[test]
    fn points_are_measured_on_the_building_they_fell_on() {
        let shapes = [block("a", [0.0; 3], [10.0, 10.0, 6.0]), block("b", [20.0, 0.0, 0.0], [30.0, 10.0, 9.0])];
        let mut meter = PointMeter::new(&shapes);
        assert_eq!(meter.boxes().count(), 2);
        // On a: 0.2 above, 0.1 below, low on the wall; on b: at 8, which is 1 m below; one beside both.
        let at = |x, y, z| Point3::new(x, y, z);
        meter.add(&[at(5.0, 5.0, 6.2), at(4.0, 5.0, 5.9)]);
        meter.add(&[at(0.1, 5.0, 2.0), at(25.0, 5.0, 8.0), at(15.0, 5.0, 8.0)]);
        let (all, each) = meter.finish();
        assert_eq!((all.points, all.without_roof, all.top), (4, 0, None));
        let a = each[0].vertical.unwrap();
        assert!(
            (a.median - 0.2).abs() < 1e-6 && (a.offset + 0.1).abs() < 1e-6 && (a.within_0_5 - 2.0 / 3.0).abs() < 1e-9
        );
        // The point on the wall is 4 m below the roof, but 0.1 m from the nearest face, as is the one below the roof.
        assert!((each[0].orthogonal.unwrap().median - 0.1).abs() < 1e-6);
        assert!((each[0].top.unwrap() + 0.2).abs() < 1e-9 && (each[1].top.unwrap() - 1.0).abs() < 1e-9);
    }

    #[test]
    fn a_footprint_without_a_roof_counts_its_points() {
        let ring = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]].map(|[x, y]| Point3::new(x, y, 0.0)).to_vec();
        let mut meter = PointMeter::new(&[Shape::new("bare", Vec::new(), &[vec![ring]])]);
        meter.add(&[Point3::new(1.0, 2.0, 3.0)]);
        let (_, each) = meter.finish();
        assert_eq!((each[0].points, each[0].without_roof), (1, 1));
        assert!(each[0].vertical.is_none() && each[0].orthogonal.is_none() && each[0].top.is_none());
    }
}
