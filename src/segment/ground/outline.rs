//! Places along the outline of a footprint.

use geo::{LineString, MultiPolygon};

/// Distance between places, metres …
const STEP: f64 = 0.5;
/// … unless there would be more than so many; then they lie farther apart.
const MOST: f64 = 1024.0;

/// Places along all rings of `polygon` (local metres), evenly spaced along each edge.
pub(super) fn places(polygon: &MultiPolygon<f64>) -> Vec<[f64; 2]> {
    let rings = || polygon.iter().flat_map(|p| std::iter::once(p.exterior()).chain(p.interiors()));
    let edges = || rings().flat_map(LineString::lines);
    let length: f64 = edges().map(|edge| edge.delta().x.hypot(edge.delta().y)).sum();
    let step = STEP.max(length / MOST);
    let mut places = Vec::new();
    // Evenly along the whole, so that short edges count no more than long ones.
    let mut ahead = 0.5 * step;
    for edge in edges() {
        let (start, delta) = (edge.start, edge.delta());
        let length = delta.x.hypot(delta.y);
        while ahead < length {
            let along = ahead / length;
            places.push([start.x + along * delta.x, start.y + along * delta.y]);
            ahead += step;
        }
        ahead -= length;
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;
    use geo::polygon;

    #[test]
    fn places_are_even_however_the_outline_is_cut() {
        let plain = polygon![(x: 0.0, y: 0.0), (x: 10.0, y: 0.0), (x: 10.0, y: 10.0), (x: 0.0, y: 10.0)];
        let cut = polygon![(x: 0.0, y: 0.0), (x: 3.1, y: 0.0), (x: 3.2, y: 0.0), (x: 10.0, y: 0.0), (x: 10.0, y: 10.0),
            (x: 0.0, y: 10.0)];
        let places = [plain, cut].map(|p| places(&MultiPolygon(vec![p])));
        assert_eq!(places[0].len(), 80);
        assert_eq!(places[1].len(), 80);
        assert!(places[0].iter().zip(&places[1]).all(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1]) < 1e-6));
        let wide = polygon![(x: 0.0, y: 0.0), (x: 1e6, y: 0.0), (x: 1e6, y: 1e6), (x: 0.0, y: 1e6)];
        assert!(super::places(&MultiPolygon(vec![wide])).len() <= 1024);
    }
}
