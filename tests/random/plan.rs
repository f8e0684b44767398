//! Whether solids stay in their footprint in the plan.

use gable::solid::{Face, Solid};
use geo::orient::{Direction, Orient};
use geo::{Area, BooleanOps, Coord, Euclidean, Length, LineString, MultiPolygon, Polygon};

/// How far a solid stands outside a footprint (local metres), metres: the thickness of the widest piece outside, which is
/// that of the rectangle of the same area and length of outline.
pub fn outside<'a>(solids: impl Iterator<Item = &'a Solid>, footprint: &MultiPolygon<f64>) -> f64 {
    let faces: Vec<Polygon<f64>> = solids.flat_map(|solid| solid.faces.iter().filter_map(|f| plan(solid, f))).collect();
    let outside = geo::unary_union(&faces).difference(footprint);
    outside.iter().map(thickness).fold(0.0, f64::max)
}

/// A face seen from above, unless it stands.
fn plan(solid: &Solid, face: &Face) -> Option<Polygon<f64>> {
    let mut rings: Vec<LineString<f64>> = (face.rings.iter())
        .map(|ring| ring.iter().map(|&v| solid.point(v)).map(|p| Coord { x: p.x, y: p.y }).collect())
        .collect();
    let polygon = Polygon::new(rings.remove(0), rings).orient(Direction::Default);
    (polygon.unsigned_area() > 0.0).then_some(polygon)
}

fn thickness(polygon: &Polygon<f64>) -> f64 {
    let rings = std::iter::once(polygon.exterior()).chain(polygon.interiors());
    let half = rings.map(|ring| Euclidean.length(ring)).sum::<f64>() / 4.0;
    half - (half * half - polygon.unsigned_area()).max(0.0).sqrt()
}

#[test]
fn what_stands_out_is_measured() {
    let ring = vec![[0, 0], [50_000, 0], [50_000, 40_000], [0, 40_000]];
    let block = gable::reconstruct::blocks::block(&vec![ring], 0, 30_000, [1e-4; 3]).unwrap();
    let rectangle = |east: f64| {
        let rectangle = geo::Rect::new(Coord { x: 0.0, y: 0.0 }, Coord { x: east, y: 4.0 });
        MultiPolygon(vec![rectangle.to_polygon()])
    };
    assert!(outside([&block].into_iter(), &rectangle(5.0)) < 1e-6);
    assert!((outside([&block].into_iter(), &rectangle(4.97)) - 0.03).abs() < 1e-6);
}
