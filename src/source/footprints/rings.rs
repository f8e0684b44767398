//! Polygons as plain numbers, which come back to the last bit from JSON.

use geo::{LineString, MultiPolygon, Polygon};

/// Polygons as their rings, the exterior first; each ring closed, x and y.
pub(crate) type Rings = Vec<Vec<Vec<[f64; 2]>>>;

/// The rings of polygons.
pub(crate) fn rings(polygons: &MultiPolygon<f64>) -> Rings {
    let ring = |ring: &LineString<f64>| ring.coords().map(|c| [c.x, c.y]).collect();
    let polygon = |p: &Polygon<f64>| std::iter::once(p.exterior()).chain(p.interiors()).map(ring).collect();
    polygons.iter().map(polygon).collect()
}

/// The polygons of rings.
pub(crate) fn polygons(rings: Rings) -> MultiPolygon<f64> {
    let polygon = |rings: Vec<Vec<[f64; 2]>>| {
        let mut rings = rings.into_iter().map(LineString::from);
        Polygon::new(rings.next().unwrap_or_else(|| LineString::new(Vec::new())), rings.collect())
    };
    MultiPolygon(rings.into_iter().map(polygon).collect())
}
