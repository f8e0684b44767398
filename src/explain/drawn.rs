//! What the page draws, as columns of numbers: places in steps of the page, each as its difference from the one before.

use nalgebra::Point3;

use super::cells::Cells;
use super::polygons::{Faces, at_height, push_cutting, push_hulls, push_polygon};
use crate::building::Building;
use crate::evaluate::{NearestFace, Shape};
use crate::reconstruct::primitives::Primitive;
use crate::reconstruct::{Detected, Steps};
use crate::site::Site;
use crate::view::cloud::Cloud;
use crate::view::packed::{Column, STEPS_PER_METRE, steps as to_steps};

/// The columns, in the order in which they are packed.
#[derive(Debug, Default)]
pub(super) struct Drawn {
    /// Points of the tiles around the building.
    cloud: Column,
    /// Per point around: its class.
    classes: Column,
    /// The building points.
    points: Column,
    /// Per building point: the plane that it was found on, plus 1; 0 for none.
    found: Column,
    /// Per building point: the refined plane that it is on, plus 1; 0 for none.
    refined: Column,
    /// Per building point: how far it lies from the model, in steps; nothing without a model.
    distances: Column,
    /// The outline of the footprint at the floor: polygons.
    outline: Column,
    /// The planes as they were found: polygons.
    found_hulls: Column,
    /// The refined planes: polygons.
    refined_hulls: Column,
    /// All planes that cut: polygons.
    planes: Column,
    /// Per plane that cuts: what it is, an index into [`PLANES`].
    plane_kinds: Column,
    /// The cells.
    pub cells: Cells,
    /// The faces of the surface.
    pub faces: Faces,
}

impl Drawn {
    /// The columns with their names.
    pub fn in_order(&self) -> impl Iterator<Item = (&'static str, &Column)> {
        let own = [
            ("cloud", &self.cloud),
            ("classes", &self.classes),
            ("points", &self.points),
            ("found", &self.found),
            ("refined", &self.refined),
            ("distances", &self.distances),
            ("outline", &self.outline),
            ("found_hulls", &self.found_hulls),
            ("refined_hulls", &self.refined_hulls),
            ("planes", &self.planes),
            ("plane_kinds", &self.plane_kinds),
        ];
        let faces = [("faces", &self.faces.polygons), ("face_kinds", &self.faces.kinds)];
        own.into_iter().chain(self.cells.in_order()).chain(faces)
    }

    /// The points around a building.
    pub fn add_cloud(&mut self, cloud: &Cloud) {
        let mut last = [0; 3];
        for (place, class) in &cloud.points {
            self.cloud.push_place(*place, &mut last);
            self.classes.push(u64::from(*class));
        }
    }

    /// The building points, the planes that they are on, and how far they are from the model.
    pub fn add_points(&mut self, steps: &Steps, building: &Building) {
        let Some(site) = &steps.site else { return };
        let mut last = [0; 3];
        site.points.iter().for_each(|p| self.points.push_place(to_steps((*p).into()), &mut last));
        if let Some(found) = &steps.found {
            push_labels(&mut self.found, site.points.len(), found.iter());
        }
        if let Some(detected) = &steps.detected {
            push_labels(&mut self.refined, site.points.len(), refined(detected));
        }
        if let Some(nearest) = Shape::of_building(building).and_then(|shape| NearestFace::new(&shape)) {
            let far = |p: &Point3<f64>| (nearest.distance(p) * STEPS_PER_METRE).round() as u64;
            site.points.iter().for_each(|p| self.distances.push(far(p)));
        }
    }

    /// The outline of the footprint and all planes.
    pub fn add_planes(&mut self, steps: &Steps) {
        if let Some(site) = &steps.site {
            let mut last = [0; 3];
            for polygon in site.footprint.iter().flatten() {
                push_polygon(&mut self.outline, &at_height(polygon, site.ground.height), &mut last);
            }
        }
        push_hulls(&mut self.found_hulls, steps.found.iter().flatten(), None);
        push_hulls(&mut self.refined_hulls, steps.detected.iter().flat_map(refined), None);
        if let Some(partition) = &steps.partition {
            push_cutting(&mut self.planes, &mut self.plane_kinds, partition);
        }
    }
}

/// The refined planes, roofs first.
fn refined(detected: &Detected) -> impl Iterator<Item = &Primitive> {
    detected.roofs.iter().chain(&detected.undersides).chain(&detected.walls)
}

/// Smallest and largest x and y of what is shown of a building, local metres.
pub(super) fn extent(steps: &Steps, site: &Site) -> [[f64; 2]; 2] {
    steps.site.as_ref().unwrap_or(site).extent().unwrap_or_default()
}

/// Per point the primitive that it is on, plus 1; 0 for none.
fn push_labels<'a>(column: &mut Column, points: usize, primitives: impl Iterator<Item = &'a Primitive>) {
    let mut labels = vec![0_u64; points];
    for (label, primitive) in (1..).zip(primitives) {
        for &inlier in &primitive.inliers {
            if let Some(own) = labels.get_mut(inlier as usize) {
                *own = label;
            }
        }
    }
    for label in labels {
        column.push(label);
    }
}
