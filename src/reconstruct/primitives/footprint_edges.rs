//! Wall planes from the footprint: what an airborne scanner hardly sees.

use geo::{Coord, LineString, MultiPolygon, Polygon, Validation};
use nalgebra::Point2;

use super::PrimitiveKind;
use super::trace::Trace;

/// The footprint with every vertex left out that is not needed to stay within `tolerance` metres of the original
/// outline. Rings that would collapse and polygons that would become invalid stay as they are.
pub fn simplify(footprint: &MultiPolygon<f64>, tolerance: f64) -> MultiPolygon<f64> {
    MultiPolygon(
        footprint
            .iter()
            .map(|polygon| {
                let simpler = Polygon::new(
                    simplify_ring(polygon.exterior(), tolerance),
                    polygon.interiors().iter().map(|ring| simplify_ring(ring, tolerance)).collect(),
                );
                if simpler.is_valid() { simpler } else { polygon.clone() }
            })
            .collect(),
    )
}

fn simplify_ring(ring: &LineString<f64>, tolerance: f64) -> LineString<f64> {
    let mut original: Vec<Coord<f64>> = ring.coords().copied().collect();
    original.pop();
    let mut simpler = LineString(needed(&original, tolerance).into_iter().map(|i| original[i]).collect());
    simpler.close();
    simpler
}

/// Indices of the vertices of a ring (not closed) that are needed to stay within `tolerance` metres of it, at least
/// three: drops, one after the other, the vertex that costs least, as long as every vertex stays within `tolerance` of
/// the chord that replaces it.
pub(in crate::reconstruct) fn needed(ring: &[Coord<f64>], tolerance: f64) -> Vec<usize> {
    let mut kept: Vec<usize> = (0..ring.len()).collect();
    let cost = |kept: &[usize], i: usize| {
        let count = kept.len();
        chord_error(ring, kept[(i + count - 1) % count], kept[(i + 1) % count])
    };
    let mut costs: Vec<f64> = (0..kept.len()).map(|i| cost(&kept, i)).collect();
    while kept.len() > 3 {
        let cheapest = (0..costs.len()).min_by(|&a, &b| costs[a].total_cmp(&costs[b]).then(a.cmp(&b)));
        let Some(i) = cheapest.filter(|&i| costs[i] <= tolerance) else { break };
        kept.remove(i);
        costs.remove(i);
        let count = kept.len();
        for neighbour in [(i + count - 1) % count, i % count] {
            costs[neighbour] = cost(&kept, neighbour);
        }
    }
    kept
}

/// Largest distance from the chord `before → after` to the vertices of the ring between the two.
fn chord_error(ring: &[Coord<f64>], before: usize, after: usize) -> f64 {
    let (a, b) = (ring[before], ring[after]);
    let chord = b - a;
    let length2 = chord.x * chord.x + chord.y * chord.y;
    let mut worst = 0.0_f64;
    let mut i = (before + 1) % ring.len();
    while i != after {
        let d = ring[i] - a;
        let t = if length2 > 0.0 { ((d.x * chord.x + d.y * chord.y) / length2).clamp(0.0, 1.0) } else { 0.0 };
        worst = worst.max((d.x - t * chord.x).hypot(d.y - t * chord.y));
        i = (i + 1) % ring.len();
    }
    worst
}

/// One trace per edge of the (simplified) footprint.
pub fn traces(footprint: &MultiPolygon<f64>) -> Vec<Trace> {
    let point = |c: Coord<f64>| Point2::new(c.x, c.y);
    footprint
        .iter()
        .flat_map(|polygon| std::iter::once(polygon.exterior()).chain(polygon.interiors()))
        .flat_map(LineString::lines)
        .filter_map(|line| Trace::between(point(line.start), point(line.end), PrimitiveKind::FootprintEdge))
        .collect()
}

#[cfg(test)]
mod tests {
    use geo::{Area, polygon};

    use super::*;

    #[test]
    fn a_jog_smaller_than_the_tolerance_goes_and_a_larger_one_stays() {
        let ring = |jog: f64| {
            MultiPolygon(vec![polygon![
                (x: 0.0, y: 0.0), (x: 5.0, y: 0.0), (x: 5.0, y: jog), (x: 10.0, y: jog), (x: 10.0, y: 8.0), (x: 0.0, y: 8.0)
            ]])
        };
        let small = simplify(&ring(0.05), 0.1);
        assert_eq!(small.0[0].exterior().0.len(), 5);
        assert!((small.unsigned_area() - 80.0).abs() < 0.3);
        assert_eq!(simplify(&ring(0.3), 0.1), ring(0.3));
        assert_eq!(traces(&small).len(), 4);
    }

    #[test]
    fn a_long_shallow_arc_does_not_creep_away() {
        // Every vertex is within 1 cm of its neighbours' chord; the whole arc rises by 2 m.
        let mut coords: Vec<(f64, f64)> =
            (0..=40).map(|i| (f64::from(i), 2.0 - f64::from(i - 20).powi(2) / 200.0)).collect();
        coords.push((20.0, -30.0));
        let arc = MultiPolygon(vec![Polygon::new(LineString::from(coords.clone()), vec![])]);
        let simpler = simplify(&arc, 0.1);
        let line = simpler.0[0].exterior();
        let far = coords.iter().map(|&(x, y)| {
            use geo::{Distance, Euclidean};
            Euclidean.distance(&geo::Point::new(x, y), line)
        });
        assert!(far.fold(0.0, f64::max) <= 0.1 + 1e-9);
        assert!(line.0.len() < 16);
    }
}
