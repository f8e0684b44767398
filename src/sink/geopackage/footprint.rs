//! The footprint of a feature in the plane.

use geo::{BooleanOps, LineString, MultiPolygon, Polygon, Winding};

use super::blob::Polygons;
use crate::sink::Feature;
use crate::sink::faces::{finest, level, surfaces};
use crate::source::cityjson::Face;

/// What the feature covers: its geometry at LoD 0 where it has one, else its ground surfaces, else all that does not stand
/// upright; empty where there is nothing.
pub(super) fn footprint(feature: &Feature, metres: [f64; 3]) -> Polygons<2> {
    let geometries = || feature.objects.iter().flat_map(|object| object.geometries.iter());
    let flat = geometries().filter(|geometry| level(&geometry.lod) < 1.0).flat_map(|geometry| &geometry.shells);
    let drawn: Vec<Polygon> = flat.flat_map(|shell| &shell.faces).filter_map(|face| flatten(feature, face)).collect();
    if !drawn.is_empty() {
        // It is kept as it was drawn.
        return drawn.into_iter().map(rings).collect();
    }
    let all: Vec<_> = finest(feature)
        .into_iter()
        .flat_map(|(object, geometry)| surfaces(feature, object, geometry, metres))
        .collect();
    let faces = |is_ground: bool| {
        let wanted = all.iter().filter(move |surface| !is_ground || surface.class == "GroundSurface");
        wanted.flat_map(|surface| &surface.faces).filter_map(|face| flatten(feature, face)).collect::<Vec<_>>()
    };
    let mut shadow = faces(true);
    if shadow.is_empty() {
        shadow = faces(false);
    }
    let union = shadow.into_iter().fold(MultiPolygon::new(Vec::new()), |union, polygon| union.union(&polygon));
    union.into_iter().map(rings).collect()
}

/// A face from above; `None` where nothing of it is left.
fn flatten(feature: &Feature, face: &Face) -> Option<Polygon> {
    let ring =
        |ring: &Vec<u32>| -> LineString { ring.iter().map(|&v| feature.vertex(v)).map(|v| (v[0], v[1])).collect() };
    let mut lines = face.rings.iter().map(ring);
    let polygon = Polygon::new(lines.next()?, lines.collect());
    // Coordinates are large: an area that is but their rounding is none.
    let area = geo::Area::unsigned_area(&relative(&polygon)?);
    (area > f64::EPSILON * 1e3).then_some(polygon)
}

/// A polygon from its first vertex.
fn relative(polygon: &Polygon) -> Option<Polygon> {
    let first = *polygon.exterior().0.first()?;
    Some(geo::Translate::translate(polygon, -first.x, -first.y))
}

/// The rings of a polygon: the exterior counter-clockwise, holes clockwise.
fn rings(polygon: Polygon) -> Vec<Vec<[f64; 2]>> {
    let (mut exterior, mut holes) = polygon.into_inner();
    exterior.make_ccw_winding();
    holes.iter_mut().for_each(Winding::make_cw_winding);
    let open = |line: &LineString| {
        let mut ring: Vec<[f64; 2]> = line.coords().map(|c| [c.x, c.y]).collect();
        ring.pop();
        ring
    };
    std::iter::once(&exterior).chain(&holes).map(open).collect()
}
