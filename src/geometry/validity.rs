//! Whether polygons are valid (OGC 06-103r4, section 6.1.11).
//!
//! The rules and the words are those of the crate geo, which compares every edge of a ring with every other: ten thousand
//! vertices then take seconds. Here edges, and polygons, are compared where their boxes meet.

use super::Boxes;
use geo::algorithm::validation::{CoordIndex, GeometryIndex, InvalidMultiPolygon, InvalidPolygon, RingRole};
use geo::coordinate_position::CoordPos;
use geo::dimensions::Dimensions;
use geo::{BoundingRect, Intersects, Line, LineString, MultiPolygon, Polygon, PreparedGeometry, Relate, Validation};

/// Rings of up to so many edges are left to geo: a tree costs more than it saves.
const SMALL: usize = 32;

/// Whether polygons are valid.
pub fn is_valid(polygons: &MultiPolygon<f64>) -> bool {
    check(polygons).is_ok()
}

/// Whether a polygon is valid.
pub fn is_valid_polygon(polygon: &Polygon<f64>) -> bool {
    check_polygon(polygon).is_ok()
}

/// What geo's [`Validation`] says of polygons.
///
/// # Errors
/// The first rule that they break.
pub fn check(polygons: &MultiPolygon<f64>) -> Result<(), InvalidMultiPolygon> {
    let boxes = Boxes::new(polygons.iter().map(corners));
    for (i, polygon) in polygons.iter().enumerate() {
        check_polygon(polygon).map_err(|fault| InvalidMultiPolygon::InvalidPolygon(GeometryIndex(i), fault))?;
        for j in later(&boxes, polygon, i) {
            let matrix = polygon.relate(&polygons.0[j]);
            if matrix.get(CoordPos::Inside, CoordPos::Inside) == Dimensions::TwoDimensional {
                return Err(InvalidMultiPolygon::ElementsOverlaps(GeometryIndex(i), GeometryIndex(j)));
            }
            if matrix.get(CoordPos::OnBoundary, CoordPos::OnBoundary) == Dimensions::OneDimensional {
                return Err(InvalidMultiPolygon::ElementsTouchOnALine(GeometryIndex(i), GeometryIndex(j)));
            }
        }
    }
    Ok(())
}

fn check_polygon(polygon: &Polygon<f64>) -> Result<(), InvalidPolygon> {
    if polygon.exterior().0.is_empty() {
        return Ok(());
    }
    let rings = || std::iter::once(polygon.exterior()).chain(polygon.interiors());
    if polygon.interiors().is_empty() && rings().all(|ring| ring.0.len() <= SMALL) {
        return polygon.check_validation();
    }
    for (ring, role) in rings().zip(roles()).filter(|(ring, _)| !ring.0.is_empty()) {
        let mut vertices = ring.0.clone();
        vertices.dedup();
        if vertices.len() < 4 {
            return Err(InvalidPolygon::TooFewPointsInRing(role));
        }
        // A tree has no place for what is no number.
        if let Some(at) = ring.coords().position(|c| !c.x.is_finite() || !c.y.is_finite()) {
            return Err(InvalidPolygon::NonFiniteCoord(role, CoordIndex(at)));
        }
        if meets_itself(ring) {
            return Err(InvalidPolygon::SelfIntersection(role));
        }
    }
    check_holes(polygon)
}

fn roles() -> impl Iterator<Item = RingRole> {
    std::iter::once(RingRole::Exterior).chain((0..).map(RingRole::Interior))
}

/// The holes of a polygon, whose rings are simple, against its exterior and each other.
fn check_holes(polygon: &Polygon<f64>) -> Result<(), InvalidPolygon> {
    let holes: Vec<Polygon<f64>> =
        polygon.interiors().iter().map(|ring| Polygon::new(ring.clone(), Vec::new())).collect();
    if holes.iter().all(|hole| hole.exterior().0.is_empty()) {
        return Ok(());
    }
    let exterior = Polygon::new(polygon.exterior().clone(), Vec::new());
    let exterior = PreparedGeometry::from(&exterior);
    let boxes = Boxes::new(holes.iter().map(corners));
    for (i, hole) in holes.iter().enumerate().filter(|(_, hole)| !hole.exterior().0.is_empty()) {
        let role = RingRole::Interior(i);
        let prepared = PreparedGeometry::from(hole);
        let matrix = exterior.relate(&prepared);
        if !matrix.is_contains() {
            return Err(InvalidPolygon::InteriorRingNotContainedInExteriorRing(role));
        }
        if matrix.get(CoordPos::OnBoundary, CoordPos::OnBoundary) == Dimensions::OneDimensional {
            return Err(InvalidPolygon::IntersectingRingsOnALine(RingRole::Exterior, role));
        }
        for j in later(&boxes, hole, i) {
            let matrix = prepared.relate(&holes[j]);
            if matrix.get(CoordPos::Inside, CoordPos::Inside) == Dimensions::TwoDimensional {
                return Err(InvalidPolygon::IntersectingRingsOnAnArea(role, RingRole::Interior(j)));
            }
            if matrix.get(CoordPos::OnBoundary, CoordPos::OnBoundary) == Dimensions::OneDimensional {
                return Err(InvalidPolygon::IntersectingRingsOnALine(role, RingRole::Interior(j)));
            }
        }
    }
    Ok(())
}

/// Whether two edges of a closed ring meet that do not follow each other.
fn meets_itself(ring: &LineString<f64>) -> bool {
    let edges: Vec<Line<f64>> = ring.lines().collect();
    let meet = |a: &Line<f64>, b: &Line<f64>| a.start != b.end && a.end != b.start && a.intersects(b);
    let boxes = Boxes::new(edges.iter().map(|edge| Some([edge.start, edge.end].map(|c| [c.x, c.y]))));
    boxes.meeting(&boxes).filter(|(a, b)| a < b).any(|(a, b)| meet(&edges[a], &edges[b]))
}

fn corners(of: &Polygon<f64>) -> Option<[[f64; 2]; 2]> {
    of.bounding_rect().map(|rect| [rect.min(), rect.max()].map(|c| [c.x, c.y]))
}

/// The numbers after `i`, ascending, whose boxes meet that of a polygon.
fn later(boxes: &Boxes, polygon: &Polygon<f64>, i: usize) -> Vec<usize> {
    let found = corners(polygon).map_or_else(Vec::new, |corners| boxes.at(corners));
    found.into_iter().filter(|&j| j > i).collect()
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use geo::{coord, polygon};
    use proptest::prelude::*;

    use super::*;

    /// A ring around a place whose distance from it is given at equal angles.
    fn around(middle: [f64; 2], radii: &[f64]) -> LineString<f64> {
        let at = |(i, r): (usize, &f64)| {
            let angle = TAU * i as f64 / radii.len() as f64;
            coord! { x: middle[0] + r * angle.cos(), y: middle[1] + r * angle.sin() }
        };
        let mut ring = LineString(radii.iter().enumerate().map(|(i, r)| at((i, r))).collect());
        ring.close();
        ring
    }

    #[test]
    fn long_rings_are_compared_where_they_may_meet() {
        let teeth: Vec<f64> = (0..100_000).map(|i| 20.0 + 0.3 * f64::from(i % 2)).collect();
        let hole: Vec<f64> = teeth.iter().map(|r| r / 4.0).collect();
        let sound = Polygon::new(around([0.0; 2], &teeth), vec![around([0.0; 2], &hole)]);
        assert!(is_valid_polygon(&sound));
        // One tooth that reaches over to the other side; a hole that reaches out of the exterior.
        let mut reaching = teeth.clone();
        reaching[7] = -25.0;
        let fault = check(&MultiPolygon(vec![Polygon::new(around([0.0; 2], &reaching), Vec::new())])).unwrap_err();
        assert_eq!(fault.to_string(), "polygon at index 0 is invalid: exterior ring has a self-intersection");
        let aside = Polygon::new(sound.exterior().clone(), vec![around([18.0, 0.0], &hole)]);
        let out = InvalidPolygon::InteriorRingNotContainedInExteriorRing(RingRole::Interior(0));
        assert_eq!(check_polygon(&aside), Err(out));
    }

    #[test]
    fn parts_may_touch_in_points_alone() {
        let square =
            |x: f64, y: f64| polygon![(x: x, y: y), (x: x + 2.0, y: y), (x: x + 2.0, y: y + 2.0), (x: x, y: y + 2.0)];
        let first_and = |other: Polygon<f64>| check(&MultiPolygon(vec![square(0.0, 0.0), square(9.0, 9.0), other]));
        assert_eq!(first_and(square(2.0, 2.0)), Ok(()));
        let pair = (GeometryIndex(0), GeometryIndex(2));
        assert_eq!(
            first_and(square(2.0, 0.0)),
            Err(InvalidMultiPolygon::ElementsTouchOnALine(pair.0.clone(), pair.1.clone()))
        );
        assert_eq!(first_and(square(1.0, 1.0)), Err(InvalidMultiPolygon::ElementsOverlaps(pair.0, pair.1)));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(400))]

        /// On a lattice, so that what may happen does.
        #[test]
        fn the_verdicts_are_those_of_geo(
            rings in prop::collection::vec(prop::collection::vec((0..9i32, 0..9i32), 0..60), 1..4),
            parts in 1..3usize,
        ) {
            let line = |ring: &Vec<(i32, i32)>| {
                let mut line: LineString<f64> = ring.iter().map(|&(x, y)| (f64::from(x), f64::from(y))).collect();
                line.close();
                line
            };
            let polygons: Vec<Polygon<f64>> = rings
                .chunks(rings.len().div_ceil(parts))
                .map(|of_part| Polygon::new(line(&of_part[0]), of_part[1..].iter().map(line).collect()))
                .collect();
            let polygons = MultiPolygon(polygons);
            prop_assert_eq!(check(&polygons), polygons.check_validation());
        }

        /// Rings that are mostly sound.
        #[test]
        fn the_verdicts_on_sound_rings_are_those_of_geo(
            radii in prop::collection::vec(2.0..4.0f64, 3..80),
            hole in prop::collection::vec(0.2..2.2f64, 3..40),
            at in 0.0..3.0f64,
        ) {
            let polygon = Polygon::new(around([0.0; 2], &radii), vec![around([at, 0.0], &hole)]);
            let polygons = MultiPolygon(vec![polygon.clone(), Polygon::new(around([3.0 * at, 0.0], &hole), Vec::new())]);
            prop_assert_eq!(check_polygon(&polygon), polygon.check_validation());
            prop_assert_eq!(check(&polygons), polygons.check_validation());
        }
    }
}
