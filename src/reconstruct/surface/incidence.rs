//! Exact incidence of vertices, planes and lines.

use std::cmp::Ordering;

use crate::reconstruct::complex::{Cell, CellId, Complex, IntegerPlane, Vertex, VertexId};

/// Coordinates that differ by more than this (metres) are in the order of their floating-point values, which are right
/// to below 10⁻⁹ m for coordinates below 10⁵ m.
const CERTAIN: f64 = 1e-6;

/// Whether the vertex lies in the closed cell.
pub(super) fn contains(complex: &Complex, id: CellId, cell: &Cell, vertex: &Vertex) -> bool {
    cell.facets.iter().all(|&facet| {
        let facet = &complex.facets[facet as usize];
        let away = if facet.cells[0] == id { Ordering::Greater } else { Ordering::Less };
        complex.planes[facet.plane as usize].side(vertex) != away
    })
}

/// The line where two planes meet, in Plücker coordinates without common divisor and with a fixed sign: the same
/// line gives the same array whichever two planes it is made from. `None` if the planes are parallel.
pub(super) fn line(p: &IntegerPlane, q: &IntegerPlane) -> Option<[i128; 6]> {
    let [n, m] = [p.normal.map(i128::from), q.normal.map(i128::from)];
    let (d, e) = (i128::from(p.offset), i128::from(q.offset));
    let direction = [n[1] * m[2] - n[2] * m[1], n[2] * m[0] - n[0] * m[2], n[0] * m[1] - n[1] * m[0]];
    if direction == [0; 3] {
        return None;
    }
    let mut line = [0; 6];
    line[..3].copy_from_slice(&direction);
    for axis in 0..3 {
        line[3 + axis] = n[axis] * e - m[axis] * d;
    }
    let divisor = line.iter().fold(0u128, |g, v| gcd(g, v.unsigned_abs())) as i128;
    let sign = line.iter().find(|v| **v != 0).map_or(1, |v| v.signum());
    Some(line.map(|v| v / (divisor * sign)))
}

fn gcd(mut a: u128, mut b: u128) -> u128 {
    while b != 0 {
        // Most numbers here fit 64 bits, where the division is an order of magnitude faster.
        let rest = match (u64::try_from(a), u64::try_from(b)) {
            (Ok(a), Ok(b)) => u128::from(a % b),
            _ => a % b,
        };
        (a, b) = (b, rest);
    }
    a
}

/// Order of two vertices of one line along it; `axis` is the first in which they can differ.
fn compare_along(axis: usize, a: &Vertex, b: &Vertex) -> Ordering {
    let (p, q) = (a.position[axis], b.position[axis]);
    // The exact order costs long divisions.
    if (p - q).abs() > CERTAIN { p.total_cmp(&q) } else { a.order(b) }
}

/// Puts the vertices on a line in their order along it, each once.
pub(super) fn sort_along(complex: &Complex, line: &[i128; 6], found: &mut Vec<VertexId>) {
    let axis = line.iter().take(3).position(|component| *component != 0).unwrap_or(0);
    found.sort_unstable();
    found.dedup();
    found.sort_by(|&a, &b| compare_along(axis, &complex.vertices[a as usize], &complex.vertices[b as usize]));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_the_same_from_any_two_of_its_planes() {
        // The line x = y, z = 5 lies on all three.
        let planes = [([0, 0, 1], -5), ([1, -1, 0], 0), ([2, -2, 3], -15)]
            .map(|(normal, offset)| IntegerPlane { normal, offset });
        let expected = line(&planes[0], &planes[1]).unwrap();
        for (p, q) in [(0, 2), (1, 2), (2, 1), (2, 0), (1, 0)] {
            assert_eq!(line(&planes[p], &planes[q]).unwrap(), expected);
        }
        let other = IntegerPlane { normal: [1, -1, 0], offset: -1 };
        assert_ne!(line(&planes[0], &other).unwrap(), expected);
        assert_eq!(line(&planes[1], &other), None);
    }
}
