//! The footprint of a feature in the plane.

use geo::orient::Direction;
use geo::{LineString, Orient, Polygon, Winding, unary_union};

use super::blob::Polygons;
use crate::sink::Feature;
use crate::sink::faces::{finest, level, surfaces};
use crate::source::cityjson::Face;

/// What the feature covers: its geometry at LoD 0, the coarsest there is of it, where it has one, else its ground surfaces, else all that does not stand
/// upright; empty where there is nothing.
pub(super) fn footprint(feature: &Feature, metres: [f64; 3]) -> Polygons<2> {
    let geometries = || feature.objects.iter().flat_map(|object| object.geometries.iter());
    let flat = || geometries().filter(|g| level(&g.lod) < 1.0 && !g.shells.is_empty());
    let coarsest = flat().map(|geometry| level(&geometry.lod)).fold(f64::INFINITY, f64::min);
    let flat = flat().filter(|geometry| level(&geometry.lod) <= coarsest).flat_map(|geometry| &geometry.shells);
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
    // All at once: one after the other, the thousands of triangles of a terrain would take minutes.
    let union = unary_union(&shadow);
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
    // Seen from above, half of all faces turn the other way.
    (area > f64::EPSILON * 1e3).then(|| polygon.orient(Direction::Default))
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::cityjson::{CityObject, Geometry, GeometryKind, Shell};

    #[test]
    fn faces_that_turn_either_way_cover_what_they_cover_together() {
        // A square of 2 × 2 in two triangles, one of them seen from below, and a wall.
        let vertices =
            vec![[10.0, 10.0, 0.0], [12.0, 10.0, 0.0], [12.0, 12.0, 0.0], [10.0, 12.0, 0.0], [12.0, 10.0, 3.0]];
        let faces = [[0, 1, 2], [0, 3, 2], [0, 1, 4]].map(|ring| Face { rings: vec![ring.to_vec()], surface: None });
        let shells = vec![Shell { solid: 0, faces: faces.to_vec() }];
        let geometry = Geometry {
            lod: "2".into(),
            kind: GeometryKind::MultiSurface,
            shells,
            surfaces: Vec::new(),
            instance: None,
        };
        let object = CityObject { kind: "TINRelief".into(), geometries: vec![geometry], ..CityObject::default() };
        let feature = Feature { id: String::new(), objects: vec![object], vertices };
        let [polygon] = footprint(&feature, [1.0; 3]).try_into().unwrap();
        let [ring]: [Vec<[f64; 2]>; 1] = polygon.try_into().unwrap();
        let next = ring.iter().cycle().skip(1);
        let twice: f64 = ring.iter().zip(next).map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum();
        assert!((twice - 8.0).abs() < 1e-9, "4 m², counter-clockwise: {ring:?}");
    }
}
