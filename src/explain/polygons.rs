//! Polygons of pages: planes and faces, as columns of numbers.

use geo::Polygon;
use nalgebra::Point3;

use crate::geometry::{Aabb, triangle_indices};
use crate::reconstruct::Partitioning;
use crate::reconstruct::primitives::{Extent, Primitive, PrimitiveKind};
use crate::solid::{Solid, SurfaceType};
use crate::view::packed::{Column, steps as to_steps};

/// What planes are.
pub(crate) const PLANES: [&str; 5] = ["roof", "underside", "scanned wall", "footprint edge", "height jump"];

/// What faces are.
pub(crate) const SURFACES: [&str; 4] = ["RoofSurface", "WallSurface", "GroundSurface", "OuterCeilingSurface"];

/// The faces of solids.
#[derive(Debug, Default)]
pub(crate) struct Faces {
    /// Their polygons.
    pub polygons: Column,
    /// Per face: what it is, an index into [`SURFACES`].
    pub kinds: Column,
}

impl Faces {
    /// Those of some solids.
    pub fn of<'a>(solids: impl IntoIterator<Item = &'a Solid>) -> Self {
        let mut faces = Self::default();
        let mut last = [0; 3];
        for solid in solids {
            for face in &solid.faces {
                let rings: Vec<Vec<Point3<f64>>> =
                    face.rings.iter().map(|ring| ring.iter().map(|&v| solid.point(v)).collect()).collect();
                push_polygon(&mut faces.polygons, &rings, &mut last);
                faces.kinds.push_index(match solid.kind(face) {
                    SurfaceType::Roof => 0,
                    SurfaceType::Wall => 1,
                    SurfaceType::Ground => 2,
                    SurfaceType::OuterCeiling => 3,
                });
            }
        }
        faces
    }
}

/// All planes that cut a box, and what each is, an index into [`PLANES`].
pub(crate) fn push_cutting(planes: &mut Column, kinds: &mut Column, partition: &Partitioning) {
    push_hulls(planes, partition.primitives.iter(), Some(&partition.bounds));
    (0..).zip(&partition.primitives).for_each(|(i, p)| kinds.push_index(kind_of(partition, i, p)));
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

/// How far each of some primitives reaches, as a polygon; one that reaches everywhere has none. What was not detected stands
/// within `bounds`, beyond which it cuts nothing.
pub(crate) fn push_hulls<'a>(
    column: &mut Column,
    primitives: impl Iterator<Item = &'a Primitive>,
    bounds: Option<&Aabb>,
) {
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
pub(crate) fn push_polygon(column: &mut Column, rings: &[Vec<Point3<f64>>], last: &mut [i64; 3]) {
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
pub(crate) fn at_height(polygon: &Polygon<f64>, height: f64) -> Vec<Vec<Point3<f64>>> {
    let rings = std::iter::once(polygon.exterior()).chain(polygon.interiors());
    rings.map(|ring| ring.coords().skip(1).map(|c| Point3::new(c.x, c.y, height)).collect()).collect()
}
