//! What the page draws of a building, as columns of numbers: places in steps of the page, each as its difference from the one
//! before.

use std::collections::HashMap;

use nalgebra::Point3;

use super::around::Around;
use super::planes::Addressed;
use crate::building::Building;
use crate::evaluate::{Residuals, Shape};
use crate::explain::cells::Cells;
use crate::explain::polygons::{Faces, at_height, push_cutting, push_hulls, push_polygon};
use crate::reconstruct::Steps;
use crate::segment::as_collected;
use crate::site::Site;
use crate::view::packed::{Column, STEPS_PER_METRE, folded, steps as to_steps};

/// At most so many points around a building are shown; of more every second, third, …
const MOST_AROUND: usize = 200_000;

/// What no edit changes: what was scanned.
#[derive(Debug, Default)]
pub(super) struct Scanned {
    /// Points of the tiles around the building.
    cloud: Column,
    /// Per point around: its class.
    classes: Column,
    /// Per point around: its intensity.
    cloud_intensity: Column,
    /// The building points, those that edits exclude among them.
    points: Column,
    /// Per building point: its class.
    point_classes: Column,
    /// Per building point: its intensity.
    intensity: Column,
    /// Where each building point is among them, by the bits of its coordinates.
    index: HashMap<[u64; 3], usize>,
}

/// What an edit may change.
#[derive(Debug, Default)]
pub(super) struct Made {
    /// Per building point: the plane that it is on, plus 1; 0 for none.
    on: Column,
    /// Per building point: how far it lies from the model, in steps, negative inside; nothing without a model.
    distances: Column,
    /// Per building point: 1 where edits exclude it.
    excluded: Column,
    /// The outline of what of the footprint stands, at the floor: polygons.
    outline: Column,
    /// The planes that edits can name: polygons.
    hulls: Column,
    /// All planes that cut: polygons.
    planes: Column,
    /// Per plane that cuts: what it is.
    plane_kinds: Column,
    cells: Cells,
    /// What came out.
    faces: Faces,
    /// What comes out without edits.
    before: Faces,
}

fn bits(p: &Point3<f64>) -> [u64; 3] {
    [p.x, p.y, p.z].map(f64::to_bits)
}

impl Scanned {
    /// What was scanned of a building and around it.
    pub fn new(site: &Site, around: &Around) -> Self {
        let mut scanned = Self { index: site.points.iter().map(bits).zip(0..).collect(), ..Self::default() };
        let mut of_points = vec![(0_u8, 0_u16); site.points.len()];
        let mut others = Vec::new();
        let near = extent(site).into_iter().flat_map(|own| around.of(own, site.frame.metres_per_unit));
        for near in near {
            let local = as_collected(&site.frame, near.position);
            match scanned.index.get(&bits(&local)).and_then(|at| of_points.get_mut(*at)) {
                Some(own) => *own = (near.class, near.intensity),
                None => others.push((to_steps(local.into()), near.class, near.intensity)),
            }
        }
        let mut last = [0; 3];
        for (place, class, intensity) in others.iter().step_by(others.len().div_ceil(MOST_AROUND).max(1)) {
            scanned.cloud.push_place(*place, &mut last);
            scanned.classes.push(u64::from(*class));
            scanned.cloud_intensity.push(u64::from(*intensity));
        }
        let mut last = [0; 3];
        for (point, (class, intensity)) in site.points.iter().zip(of_points) {
            scanned.points.push_place(to_steps((*point).into()), &mut last);
            scanned.point_classes.push(u64::from(class));
            scanned.intensity.push(u64::from(intensity));
        }
        scanned
    }
}

impl Made {
    /// What was made of a building: `edited` is its site as its edits make it.
    pub fn new(
        scanned: &Scanned,
        (site, edited): (&Site, &Site),
        (building, before): (&Building, &Building),
        steps: &Steps,
        addressed: &[Addressed],
    ) -> Self {
        let mut made = Self { cells: Cells::of(steps), ..Self::default() };
        let points = &site.points;
        let mut on = vec![0_u64; points.len()];
        let used = steps.site.as_ref().map(|site| &site.points);
        for (label, plane) in (1..).zip(addressed) {
            let inliers = plane.primitive.inliers.iter().filter_map(|&i| used?.get(i as usize));
            for at in inliers.filter_map(|p| scanned.index.get(&bits(p))) {
                if let Some(own) = on.get_mut(*at) {
                    *own = label;
                }
            }
        }
        for label in on {
            made.on.push(label);
        }
        if let Some(residuals) = Shape::of_building(building).and_then(|shape| Residuals::new(&shape)) {
            let far = |p: &Point3<f64>| folded((residuals.of(p) * STEPS_PER_METRE).round() as i64);
            for p in points {
                made.distances.push(far(p));
            }
        }
        let mut left = edited.points.iter().map(bits).peekable();
        for p in points {
            made.excluded.push(u64::from(left.next_if_eq(&bits(p)).is_none()));
        }
        if let Some(stands) = &steps.site {
            let mut last = [0; 3];
            for polygon in stands.footprint.iter().flatten() {
                push_polygon(&mut made.outline, &at_height(polygon, stands.ground.height), &mut last);
            }
        }
        push_hulls(&mut made.hulls, addressed.iter().map(|plane| plane.primitive), None);
        if let Some(partition) = &steps.partition {
            push_cutting(&mut made.planes, &mut made.plane_kinds, partition);
        }
        made.faces = faces(building);
        made.before = faces(before);
        made
    }

    /// All columns with their names.
    pub fn in_order<'a>(&'a self, scanned: &'a Scanned) -> impl Iterator<Item = (&'static str, &'a Column)> {
        let of_points = [
            ("cloud", &scanned.cloud),
            ("classes", &scanned.classes),
            ("cloud_intensity", &scanned.cloud_intensity),
            ("points", &scanned.points),
            ("point_classes", &scanned.point_classes),
            ("intensity", &scanned.intensity),
            ("on", &self.on),
            ("distances", &self.distances),
            ("excluded", &self.excluded),
        ];
        let of_planes = [
            ("outline", &self.outline),
            ("hulls", &self.hulls),
            ("planes", &self.planes),
            ("plane_kinds", &self.plane_kinds),
        ];
        let of_faces = [
            ("faces", &self.faces.polygons),
            ("face_kinds", &self.faces.kinds),
            ("before_faces", &self.before.polygons),
            ("before_face_kinds", &self.before.kinds),
        ];
        of_points.into_iter().chain(of_planes).chain(self.cells.in_order()).chain(of_faces)
    }
}

/// The faces of the highest level of detail that was reached.
fn faces(building: &Building) -> Faces {
    Faces::of(building.model.parts.iter().filter_map(|part| part.lod22.as_ref().or(part.lod12.as_ref())))
}

/// Smallest and largest x and y of a building, in the CRS; `None` where it has neither a footprint nor points.
pub(super) fn extent(site: &Site) -> Option<[[f64; 2]; 2]> {
    let in_crs = |[x, y]: [f64; 2]| {
        let [x, y, _] = site.frame.to_crs(&Point3::new(x, y, 0.0));
        [x, y]
    };
    site.extent().map(|corners| corners.map(in_crs))
}
