//! The labelled solid: what [`reconstruct`](mod@crate::reconstruct) returns and every sink takes.

use geo::MultiPolygon;
use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};

use crate::geometry::triangulate;

/// What a face is: the semantic surface types of CityGML that gable writes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub enum SurfaceType {
    /// `RoofSurface`: faces up.
    Roof,
    /// `WallSurface`: stands.
    Wall,
    /// `GroundSurface`: faces down, on the ground.
    Ground,
    /// `OuterCeilingSurface`: the underside of an overhang.
    OuterCeiling,
}

/// One semantic surface: all faces on the same plane of the same type share one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Surface {
    /// Its type.
    pub kind: SurfaceType,
    /// Angle to the horizontal in degrees, 0 to 90; roofs only.
    pub slope: Option<f64>,
    /// Direction of steepest descent in degrees clockwise from north, 0 to 360; sloped roofs only.
    pub azimuth: Option<f64>,
    /// Lowest and highest vertex, metres in the local frame; roofs only.
    pub heights: Option<[f64; 2]>,
    /// Whether a wall stands on an edge of the footprint (and not between two roofs); walls only.
    pub on_footprint_edge: Option<bool>,
    /// How sure the field is of it, 0 to 1; roofs at LoD 2.2 only.
    pub confidence: Option<f64>,
    /// How far the floor lies under the ground at this wall, metres, where that is most; walls on the floor only, where
    /// the ground was seen. Negative where the floor hangs above the ground.
    pub floor_depth: Option<f64>,
}

impl Surface {
    /// A surface of this type without further properties.
    pub fn of(kind: SurfaceType) -> Self {
        Self {
            kind,
            slope: None,
            azimuth: None,
            heights: None,
            on_footprint_edge: None,
            confidence: None,
            floor_depth: None,
        }
    }
}

/// A planar polygon of a shell, with holes.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Face {
    /// Vertex indices; the first ring is the exterior, counter-clockwise seen from outside the solid, the others are
    /// holes, clockwise. The first vertex is not repeated.
    pub rings: Vec<Vec<u32>>,
    /// Index into [`Solid::surfaces`].
    pub surface: u32,
}

/// One closed shell of labelled polygons on the integer grid of the output.
///
/// Coordinates are grid steps of the building's [`Frame`](crate::site::Frame): what is validated is what is written.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Solid {
    /// Size of a grid step in metres, along x, y and z.
    pub step: [f64; 3],
    /// Vertices in grid steps from the frame's origin; no two are equal and each is used.
    pub vertices: Vec<[i64; 3]>,
    /// The polygons of the shell.
    pub faces: Vec<Face>,
    /// The semantic surfaces that the faces refer to.
    pub surfaces: Vec<Surface>,
}

impl Solid {
    /// A vertex in local metres; the origin if there is no such vertex.
    pub fn point(&self, vertex: u32) -> Point3<f64> {
        let v = self.vertices.get(vertex as usize).copied().unwrap_or_default();
        Point3::from(std::array::from_fn(|i| v[i] as f64 * self.step[i]))
    }

    /// Twice the vector area of a ring (Newell), in square metres.
    pub fn newell(&self, ring: &[u32]) -> Vector3<f64> {
        let Some(&first) = ring.first() else { return Vector3::zeros() };
        let anchor = self.point(first);
        let mut sum = Vector3::zeros();
        for (i, &v) in ring.iter().enumerate() {
            let next = ring.get(i + 1).copied().unwrap_or(first);
            sum += (self.point(v) - anchor).cross(&(self.point(next) - anchor));
        }
        sum
    }

    /// Area of a face without its holes, in square metres.
    pub fn area(&self, face: &Face) -> f64 {
        let total: Vector3<f64> = face.rings.iter().map(|ring| self.newell(ring)).sum();
        total.norm() / 2.0
    }

    /// Volume by the divergence theorem, in cubic metres; positive when the faces look outwards.
    pub fn volume(&self) -> f64 {
        let Some(anchor) = self.vertices.first().map(|_| self.point(0)) else { return 0.0 };
        let mut six = 0.0;
        for ring in self.faces.iter().flat_map(|face| &face.rings) {
            let Some(&first) = ring.first() else { continue };
            six += self.newell(ring).dot(&(self.point(first) - anchor));
        }
        six / 6.0
    }

    /// The triangles of a face, in local metres.
    pub fn triangles(&self, face: &Face) -> Vec<[Point3<f64>; 3]> {
        let ring = |ring: &Vec<u32>| ring.iter().map(|&vertex| self.point(vertex)).collect();
        triangulate(&face.rings.iter().map(ring).collect::<Vec<_>>())
    }

    /// The type of a face.
    pub fn kind(&self, face: &Face) -> SurfaceType {
        self.surfaces.get(face.surface as usize).map_or(SurfaceType::Wall, |s| s.kind)
    }
}

/// One part of a building: a `BuildingPart` of the city model.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// The LoD 1.2 block.
    pub lod12: Option<Solid>,
    /// The LoD 1.3 block with steps.
    #[serde(default)]
    pub lod13: Option<Solid>,
    /// The LoD 2.2 solid.
    pub lod22: Option<Solid>,
    /// The LoD 2.3 solid, whose roofs reach beyond its walls.
    #[serde(default)]
    pub lod23: Option<Solid>,
}

impl Part {
    /// Its solids of all levels of detail, the coarsest first.
    pub fn solids(&self) -> impl Iterator<Item = &Solid> {
        [&self.lod12, &self.lod13, &self.lod22, &self.lod23].into_iter().flatten()
    }
}

/// The model of one building in its local frame.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Model {
    /// LoD 0: the footprint in grid steps (x, y), horizontal at `ground`. Empty without a footprint.
    pub footprint: Vec<FootprintPolygon>,
    /// Height of the footprint and of the ground surface, in grid steps.
    pub ground: i64,
    /// The parts, which touch but do not overlap.
    pub parts: Vec<Part>,
    /// LoD 0.1: what the roofs cover, all at one height. Empty unless asked for.
    #[serde(default)]
    pub roof_outlines: Vec<RoofPolygon>,
    /// LoD 0.3: what each of the roofs of LoD 1.3 covers, at its height. Empty unless asked for.
    #[serde(default)]
    pub roof_parts: Vec<RoofPolygon>,
}

/// A level polygon at the height of a roof.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct RoofPolygon {
    /// Its rings.
    pub polygon: FootprintPolygon,
    /// Its height in grid steps.
    pub height: i64,
}

/// A polygon of the LoD 0 footprint: rings of grid steps, exterior first and counter-clockwise, holes clockwise,
/// first vertex not repeated.
pub type FootprintPolygon = Vec<Vec<[i64; 2]>>;

impl Model {
    /// The same on a grid whose steps are that many times finer.
    pub fn refine(&mut self, times: i64) {
        if times == 1 {
            return;
        }
        self.ground *= times;
        for place in self.footprint.iter_mut().flatten().flatten() {
            *place = place.map(|steps| steps * times);
        }
        for roof in self.roof_outlines.iter_mut().chain(&mut self.roof_parts) {
            roof.height *= times;
            for place in roof.polygon.iter_mut().flatten() {
                *place = place.map(|steps| steps * times);
            }
        }
        for part in &mut self.parts {
            for solid in [&mut part.lod12, &mut part.lod13, &mut part.lod22].into_iter().flatten() {
                solid.step = solid.step.map(|step| step / times as f64);
                for vertex in &mut solid.vertices {
                    *vertex = vertex.map(|steps| steps * times);
                }
            }
        }
    }

    /// The LoD 2.2 solids.
    pub fn lod22(&self) -> impl Iterator<Item = &Solid> {
        self.parts.iter().filter_map(|p| p.lod22.as_ref())
    }

    /// The LoD 2.3 solids.
    pub fn lod23(&self) -> impl Iterator<Item = &Solid> {
        self.parts.iter().filter_map(|p| p.lod23.as_ref())
    }

    /// The LoD 1.3 solids.
    pub fn lod13(&self) -> impl Iterator<Item = &Solid> {
        self.parts.iter().filter_map(|p| p.lod13.as_ref())
    }

    /// The LoD 1.2 solids.
    pub fn lod12(&self) -> impl Iterator<Item = &Solid> {
        self.parts.iter().filter_map(|p| p.lod12.as_ref())
    }
}

/// Rounds a footprint in local metres to grid steps and drops repeated vertices; rings that collapse are left out.
pub fn quantise_footprint(footprint: &MultiPolygon<f64>, step: [f64; 3]) -> Vec<FootprintPolygon> {
    let ring = |line: &geo::LineString<f64>| -> Option<Vec<[i64; 2]>> {
        let mut out: Vec<[i64; 2]> =
            line.coords().map(|c| [(c.x / step[0]).round() as i64, (c.y / step[1]).round() as i64]).collect();
        out.dedup();
        while out.len() > 1 && out.first() == out.last() {
            out.pop();
        }
        (out.len() >= 3).then_some(out)
    };
    footprint
        .iter()
        .filter_map(|polygon| {
            let mut rings = vec![ring(polygon.exterior())?];
            rings.extend(polygon.interiors().iter().filter_map(ring));
            Some(rings)
        })
        .collect()
}
