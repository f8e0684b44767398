//! Coplanar parts of a roof that lie far apart: one plane, several primitives.
//!
//! A primitive cuts what its hull reaches. That of forty gables of a hall on one plane reaches over the whole hall, and
//! cuts every roof between them; the hull of each does not.

use std::collections::BTreeMap;

use nalgebra::Point3;

use super::Primitive;

/// Parts stay together across gaps of so many spacings of the points …
const SPACINGS: f64 = 3.0;
/// … and of this, metres: what is nearer serves one part of a building, and its cut between does no harm.
const LEAST_GAP: f64 = 3.0;
/// A part of fewer points goes with the largest.
const FEWEST: usize = 5;

/// The parts of a primitive whose inliers, seen from above, are connected, each on the very same plane; `spacing` is that
/// of the points, metres. Whatever is too small for a part of its own is with the largest, which comes first.
pub fn parts(points: &[Point3<f64>], primitive: Primitive, spacing: f64) -> Vec<Primitive> {
    let side = (SPACINGS * spacing).max(LEAST_GAP);
    let mut squares: BTreeMap<[i64; 2], Vec<u32>> = BTreeMap::new();
    for &index in &primitive.inliers {
        if let Some(point) = points.get(index as usize) {
            squares.entry([point.x, point.y].map(|value| (value / side).floor() as i64)).or_default().push(index);
        }
    }
    let mut parts: Vec<Vec<u32>> = Vec::new();
    while let Some((start, members)) = squares.pop_first() {
        let (mut part, mut front) = (members, vec![start]);
        while let Some([column, row]) = front.pop() {
            for beside in (-1..=1).flat_map(|i| (-1..=1).map(move |j| [column + i, row + j])) {
                if let Some(members) = squares.remove(&beside) {
                    part.extend(members);
                    front.push(beside);
                }
            }
        }
        parts.push(part);
    }
    if parts.len() < 2 {
        return vec![primitive];
    }
    parts.sort_by(|a, b| b.len().cmp(&a.len()).then(a.cmp(b)));
    let scraps: Vec<u32> = parts.extract_if(1.., |part| part.len() < FEWEST).flatten().collect();
    let on_plane = |part: Vec<u32>| Primitive::on_plane(primitive.plane, points, part);
    let mut rest = scraps;
    let mut found = Vec::new();
    for part in parts.drain(1..) {
        match on_plane(part.clone()) {
            Some(part) => found.push(part),
            None => rest.extend(part),
        }
    }
    rest.extend(parts.pop().unwrap_or_default());
    match on_plane(rest) {
        Some(first) => std::iter::once(first).chain(found).collect(),
        None => vec![primitive],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gables_of_a_hall_on_one_plane_are_cut_one_by_one() {
        // Squares of 4 m on z = x / 2, 12 m apart, with a gap of 1 m in each; three points lie by themselves.
        let grid =
            |from: f64| (0..8).flat_map(move |i| (0..8).map(move |j| [from + 0.5 * f64::from(i), 0.5 * f64::from(j)]));
        let is_seen = |p: &[f64; 2]| !(1.5..2.5).contains(&p[1]);
        let strays = [[50.0, 0.0], [50.5, 0.0], [50.0, 0.5]];
        let places = grid(0.0).chain(grid(12.0)).chain(grid(24.0)).filter(is_seen).chain(strays);
        let points: Vec<Point3<f64>> = places.map(|[x, y]| Point3::new(x, y, x / 2.0)).collect();
        let whole = Primitive::from_inliers(&points, (0..points.len() as u32).collect()).unwrap();
        let found = parts(&points, whole.clone(), 0.5);
        assert_eq!(found.len(), 3);
        assert!(found.iter().all(|part| part.plane == whole.plane));
        assert_eq!(found.iter().map(|part| part.inliers.len()).sum::<usize>(), points.len());
        assert_eq!(found[1].inliers.len(), 48);
        // Of one part nothing changes.
        assert_eq!(parts(&points, found[1].clone(), 0.5), [found[1].clone()]);
    }
}
