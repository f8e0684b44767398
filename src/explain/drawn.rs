//! What the page draws, as columns of numbers: places in steps of the page, each as its difference from the one before.

use geo::{BoundingRect, Polygon};
use nalgebra::Point3;

use crate::building::Building;
use crate::evaluate::{NearestFace, Shape};
use crate::geometry::{Aabb, triangle_indices};
use crate::reconstruct::complex::{Complex, OUTSIDE};
use crate::reconstruct::primitives::{Extent, Primitive, PrimitiveKind};
use crate::reconstruct::{Detected, Partitioning, Steps};
use crate::site::Site;
use crate::solid::{Solid, SurfaceType};
use crate::view::cloud::Cloud;
use crate::view::packed::{Column, STEPS_PER_METRE, steps as to_steps};

/// Steps of a probability.
const OF_ONE: f64 = 1000.0;

/// Litres in a cubic metre.
const LITRES: f64 = 1000.0;

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
    /// Vertices of the cells.
    vertices: Column,
    /// Per facet: the number of its corners, and their vertices.
    facets: Column,
    /// Per facet: the cells below and above it, each plus 1; 0 for none.
    sides: Column,
    /// Per cell: 1 where its label is fixed, because it is beyond the footprint.
    fixed: Column,
    /// Per cell: its volume in litres.
    volumes: Column,
    /// Per cell: how much it is inside, in thousandths.
    occupancy: Column,
    /// Per cell: 1 where the cut says that it is inside.
    cut: Column,
    /// Per cell: the same after the surface was cleaned.
    cleaned: Column,
    /// The faces of the surface: polygons.
    faces: Column,
    /// Per face: what it is, an index into [`SURFACES`].
    face_kinds: Column,
}

/// What planes are.
pub(super) const PLANES: [&str; 5] = ["roof", "underside", "scanned wall", "footprint edge", "height jump"];

/// What faces are.
pub(super) const SURFACES: [&str; 4] = ["RoofSurface", "WallSurface", "GroundSurface", "OuterCeilingSurface"];

impl Drawn {
    /// The columns with their names.
    pub fn in_order(&self) -> [(&'static str, &Column); 21] {
        [
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
            ("vertices", &self.vertices),
            ("facets", &self.facets),
            ("sides", &self.sides),
            ("fixed", &self.fixed),
            ("volumes", &self.volumes),
            ("occupancy", &self.occupancy),
            ("cut", &self.cut),
            ("cleaned", &self.cleaned),
            ("faces", &self.faces),
            ("face_kinds", &self.face_kinds),
        ]
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
            push_hulls(&mut self.planes, partition.primitives.iter(), Some(&partition.bounds));
            (0..).zip(&partition.primitives).for_each(|(i, p)| self.plane_kinds.push_index(kind_of(partition, i, p)));
        }
    }

    /// The cells and what was decided about them.
    pub fn add_cells(&mut self, steps: &Steps) {
        let Some(Partitioning { complex, fixed, volumes, .. }) = &steps.partition else { return };
        self.add_complex(complex);
        for fixed in fixed {
            self.fixed.push(u64::from(fixed.is_some()));
        }
        for volume in volumes {
            self.volumes.push((volume * LITRES).round() as u64);
        }
        if let Some(field) = &steps.field {
            let thousandths = |o: &f64| (o.clamp(0.0, 1.0) * OF_ONE).round() as u64;
            field.occupancy.iter().for_each(|o| self.occupancy.push(thousandths(o)));
        }
        if let Some(cut) = &steps.cut {
            cut.inside.iter().for_each(|inside| self.cut.push(u64::from(*inside)));
        }
        if let Some(surface) = &steps.surface {
            surface.inside.iter().for_each(|inside| self.cleaned.push(u64::from(*inside)));
        }
    }

    fn add_complex(&mut self, complex: &Complex) {
        let mut last = [0; 3];
        complex.vertices.iter().for_each(|v| self.vertices.push_place(to_steps(v.position.into()), &mut last));
        for facet in &complex.facets {
            self.facets.push_index(facet.corners.len());
            facet.corners.iter().for_each(|vertex| self.facets.push(u64::from(*vertex)));
            let cell = |cell: u32| if cell == OUTSIDE { 0 } else { u64::from(cell) + 1 };
            facet.cells.into_iter().for_each(|side| self.sides.push(cell(side)));
        }
    }

    /// The faces of the surface.
    pub fn add_faces(&mut self, solids: &[Solid]) {
        let mut last = [0; 3];
        for solid in solids {
            for face in &solid.faces {
                let rings: Vec<Vec<Point3<f64>>> =
                    face.rings.iter().map(|ring| ring.iter().map(|&v| solid.point(v)).collect()).collect();
                push_polygon(&mut self.faces, &rings, &mut last);
                self.face_kinds.push_index(match solid.kind(face) {
                    SurfaceType::Roof => 0,
                    SurfaceType::Wall => 1,
                    SurfaceType::Ground => 2,
                    SurfaceType::OuterCeiling => 3,
                });
            }
        }
    }
}

/// The refined planes, roofs first.
fn refined(detected: &Detected) -> impl Iterator<Item = &Primitive> {
    detected.roofs.iter().chain(&detected.undersides).chain(&detected.walls)
}

/// Smallest and largest x and y of what is shown of a building, local metres.
pub(super) fn extent(steps: &Steps, site: &Site) -> [[f64; 2]; 2] {
    let site = steps.site.as_ref().unwrap_or(site);
    let rect = site.footprint.as_ref().and_then(BoundingRect::bounding_rect);
    let of_points = || Aabb::of(&site.points).map(|b| [[b.min[0], b.min[1]], [b.max[0], b.max[1]]]);
    let of_footprint = rect.map(|rect| [rect.min(), rect.max()].map(|corner| [corner.x, corner.y]));
    of_footprint.or_else(of_points).unwrap_or_default()
}

/// What a plane that cuts is; see [`PLANES`].
fn kind_of(partition: &Partitioning, index: usize, primitive: &Primitive) -> usize {
    match primitive.kind {
        PrimitiveKind::FootprintEdge => 3,
        PrimitiveKind::HeightJump => 4,
        PrimitiveKind::Detected if index < partition.roofs => 0,
        PrimitiveKind::Detected if index < partition.roofs + partition.undersides => 1,
        PrimitiveKind::Detected => 2,
    }
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

/// How far each of some primitives reaches, as a polygon; one that reaches everywhere has none. What was not detected stands
/// within `bounds`, beyond which it cuts nothing.
fn push_hulls<'a>(column: &mut Column, primitives: impl Iterator<Item = &'a Primitive>, bounds: Option<&Aabb>) {
    let mut last = [0; 3];
    for primitive in primitives {
        let mut ring = match &primitive.extent {
            Extent::Patch(corners) => corners.clone(),
            Extent::Everywhere => Vec::new(),
        };
        if let Some(bounds) = bounds.filter(|_| primitive.kind != PrimitiveKind::Detected) {
            for p in &mut ring {
                p.z = p.z.clamp(bounds.min[2], bounds.max[2]);
            }
        }
        push_polygon(column, &[ring], &mut last);
    }
}

/// A polygon: the number of its rings; of each the number of its corners, and these; the number of its triangles, and the
/// corners of these, counted through all rings.
fn push_polygon(column: &mut Column, rings: &[Vec<Point3<f64>>], last: &mut [i64; 3]) {
    column.push_index(rings.len());
    for ring in rings {
        column.push_index(ring.len());
        for p in ring {
            column.push_place(to_steps((*p).into()), last);
        }
    }
    let triangles = triangle_indices(rings);
    column.push_index(triangles.len());
    triangles.iter().flatten().for_each(|&corner| column.push_index(corner));
}

/// The rings of a polygon at a height.
fn at_height(polygon: &Polygon<f64>, height: f64) -> Vec<Vec<Point3<f64>>> {
    let rings = std::iter::once(polygon.exterior()).chain(polygon.interiors());
    rings.map(|ring| ring.coords().skip(1).map(|c| Point3::new(c.x, c.y, height)).collect()).collect()
}
