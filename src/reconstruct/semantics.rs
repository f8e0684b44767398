//! Semantics: which faces of a solid are roof, wall, ground or outer ceiling.

use geo::{Contains, MultiPolygon};
use nalgebra::{Point2, Vector3};

use super::complex::PlaneId;
use super::confidence::Confidence;
use crate::solid::{Face, Solid, Surface, SurfaceType};

/// The plane of the ground: the bottom of the box, third pair of the six faces that come first in a complex.
const GROUND_PLANE: PlaneId = 4;
/// A face whose unit normal rises by more than this is a roof, or a ceiling when it falls by as much: 80° of slope.
const STANDS: f64 = 0.173_648;
/// How far beyond a wall one looks to see whether one has left the footprint, metres.
const BEYOND_WALL: f64 = 0.05;

/// Gives every face of a solid its semantic surface, one per plane and type. `planes` are the planes that the faces
/// refer to so far, `footprint` the outline that the walls were made from (none without a footprint: all walls are
/// outer walls then). Roofs are told how sure the field is of them.
pub fn assign(
    solid: &mut Solid,
    planes: &[(PlaneId, bool)],
    footprint: Option<&MultiPolygon<f64>>,
    confidence: &Confidence,
) {
    let mut surfaces: Vec<((PlaneId, bool), Surface)> = Vec::new();
    let mut of_face = Vec::with_capacity(solid.faces.len());
    for face in &solid.faces {
        let key = planes.get(face.surface as usize).copied().unwrap_or((PlaneId::MAX, true));
        let mut surface = describe(solid, face, key.0, footprint);
        if surface.kind == SurfaceType::Roof {
            surface.confidence = confidence.of_plane(key);
        }
        let same = surfaces
            .iter()
            .position(|(k, s)| *k == key && s.kind == surface.kind && s.on_footprint_edge == surface.on_footprint_edge);
        let index = same.unwrap_or(surfaces.len());
        match surfaces.get_mut(index) {
            Some((_, known)) => {
                if let (Some(known), Some(new)) = (&mut known.heights, surface.heights) {
                    *known = [known[0].min(new[0]), known[1].max(new[1])];
                }
            }
            None => surfaces.push((key, surface)),
        }
        of_face.push(index as u32);
    }
    for (face, surface) in solid.faces.iter_mut().zip(of_face) {
        face.surface = surface;
    }
    solid.surfaces = surfaces.into_iter().map(|(_, surface)| surface).collect();
}

fn describe(solid: &Solid, face: &Face, plane: PlaneId, footprint: Option<&MultiPolygon<f64>>) -> Surface {
    let exterior = face.rings.first().map_or(&[][..], Vec::as_slice);
    let normal = solid.newell(exterior).try_normalize(0.0).unwrap_or_else(Vector3::z);
    if normal.z < -STANDS {
        return Surface::of(if plane == GROUND_PLANE { SurfaceType::Ground } else { SurfaceType::OuterCeiling });
    }
    if normal.z <= STANDS {
        let outer = footprint.is_none_or(|footprint| leaves(solid, exterior, &normal, footprint));
        return Surface { on_footprint_edge: Some(outer), ..Surface::of(SurfaceType::Wall) };
    }
    let heights = exterior
        .iter()
        .map(|&v| solid.point(v).z)
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], z| [low.min(z), high.max(z)]);
    let slope = normal.z.clamp(-1.0, 1.0).acos().to_degrees();
    // Below half a degree the direction of descent is noise.
    let azimuth = (slope > 0.5).then(|| normal.x.atan2(normal.y).to_degrees().rem_euclid(360.0));
    Surface { slope: Some(slope), azimuth, heights: Some(heights), ..Surface::of(SurfaceType::Roof) }
}

/// Whether one leaves the footprint by stepping out of a wall, at the middle of its longest edge in the plan.
fn leaves(solid: &Solid, ring: &[u32], normal: &Vector3<f64>, footprint: &MultiPolygon<f64>) -> bool {
    let edge = ring
        .iter()
        .zip(ring.iter().cycle().skip(1))
        .map(|(&a, &b)| (solid.point(a).xy(), solid.point(b).xy()))
        .max_by(|(a, b), (c, d)| (b - a).norm_squared().total_cmp(&(d - c).norm_squared()));
    let Some((a, b)) = edge else { return false };
    let p: Point2<f64> = nalgebra::center(&a, &b) + normal.xy() * BEYOND_WALL;
    !footprint.contains(&geo::Point::new(p.x, p.y))
}
