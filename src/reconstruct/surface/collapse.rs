//! Takes out of a polygon mesh what collapsed when its vertices were rounded: edges, slivers, double faces.
//!
//! Every step keeps the mesh closed: what it takes away are half-edges in pairs.

use nalgebra::{Point3, Vector3};
use std::collections::BTreeMap;

/// A ring narrower than this (metres) has collapsed: after rounding to 0.1 mm its normal would be noise.
const COLLAPSED: f64 = 0.0005;

/// A polygon mesh in metres.
#[derive(Debug, Clone)]
pub(super) struct Mesh {
    pub(super) points: Vec<Point3<f64>>,
    pub(super) faces: Vec<MeshFace>,
}

/// A face of the mesh.
#[derive(Debug, Clone)]
pub(super) struct MeshFace {
    /// Exterior first.
    pub(super) rings: Vec<Vec<u32>>,
    /// Unit normal, outwards.
    pub(super) normal: Vector3<f64>,
    /// What the caller wants to know again.
    pub(super) label: u32,
}

impl Mesh {
    /// Removes repeated vertices, spikes, slivers, pairs of opposite faces, edges between faces of the same plane (the
    /// sliver between them is gone) and vertices that are no corner, until
    /// nothing is left to remove. Each step makes the mesh smaller, so this ends.
    pub(super) fn clean(&mut self) {
        loop {
            self.tidy_rings();
            if !(self.close_sliver() || self.cancel_opposite() || self.join_coplanar() || self.drop_straight_vertex()) {
                return;
            }
        }
    }

    /// Repeated vertices and spikes go; rings that touch themselves at a vertex are cut there.
    fn tidy_rings(&mut self) {
        let mut split = Vec::new();
        self.faces.retain_mut(|face| {
            for ring in &mut face.rings {
                tidy(ring);
            }
            let exterior_left = face.rings.first().is_some_and(|ring| ring.len() >= 3);
            face.rings.retain(|ring| ring.len() >= 3);
            if !exterior_left {
                return false;
            }
            if face.rings.iter().any(|ring| touches_itself(ring)) {
                split.push(face.clone());
                return false;
            }
            true
        });
        for face in split {
            let simple = self.simple_faces(&face);
            self.faces.extend(simple);
        }
    }

    /// A face whose rings touch themselves as faces with simple rings.
    fn simple_faces(&self, face: &MeshFace) -> Vec<MeshFace> {
        let mut exteriors: Vec<MeshFace> = Vec::new();
        let mut holes = Vec::new();
        for mut ring in face.rings.iter().flat_map(|ring| simple_rings(ring)) {
            tidy(&mut ring);
            if ring.len() < 3 {
                continue;
            }
            if self.twice_area(&ring).dot(&face.normal) > 0.0 {
                exteriors.push(MeshFace { rings: vec![ring], ..face.clone() });
            } else {
                holes.push(ring);
            }
        }
        for hole in holes {
            let home = exteriors.iter().position(|e| self.surrounds(&e.rings[0], &hole, &face.normal)).unwrap_or(0);
            if let Some(exterior) = exteriors.get_mut(home) {
                exterior.rings.push(hole);
            }
        }
        exteriors
    }

    fn twice_area(&self, ring: &[u32]) -> Vector3<f64> {
        let at = |v: u32| self.points[v as usize];
        let Some(&first) = ring.first() else { return Vector3::zeros() };
        ring.windows(2).map(|e| (at(e[0]) - at(first)).cross(&(at(e[1]) - at(first)))).sum()
    }

    /// Whether a vertex of `inner` that is not on `outer` lies inside it, seen along the normal.
    fn surrounds(&self, outer: &[u32], inner: &[u32], normal: &Vector3<f64>) -> bool {
        let Some(&probe) = inner.iter().find(|v| !outer.contains(v)) else { return false };
        let drop = normal.iamax();
        let (u, w) = ((drop + 1) % 3, (drop + 2) % 3);
        let p = self.points[probe as usize];
        let mut inside = false;
        for (i, &a) in outer.iter().enumerate() {
            let (a, b) = (self.points[a as usize], self.points[outer[(i + 1) % outer.len()] as usize]);
            if (a[w] > p[w]) != (b[w] > p[w]) {
                inside ^= p[u] < a[u] + (p[w] - a[w]) / (b[w] - a[w]) * (b[u] - a[u]);
            }
        }
        inside
    }

    /// Removes one ring that is narrower than [`COLLAPSED`]: its vertices are inserted in the opposite edges of its
    /// neighbours, which then meet along the same chain.
    fn close_sliver(&mut self) -> bool {
        let sliver = self.faces.iter().enumerate().find_map(|(f, face)| {
            face.rings.iter().enumerate().find_map(|(r, ring)| self.sliver(ring).map(|order| (f, r, order)))
        });
        let Some((face, ring, order)) = sliver else { return false };
        let gone =
            if ring == 0 { self.faces.remove(face).rings.swap_remove(0) } else { self.faces[face].rings.remove(ring) };
        let rank: BTreeMap<u32, usize> = order.iter().enumerate().map(|(i, &v)| (v, i)).collect();
        for (i, &from) in gone.iter().enumerate() {
            let to = gone[(i + 1) % gone.len()];
            let (a, b) = (rank[&from], rank[&to]);
            let between = &order[a.min(b) + 1..a.max(b)];
            if between.is_empty() {
                continue;
            }
            let neighbour = self.faces.iter_mut().flat_map(|face| &mut face.rings).find_map(|ring| {
                let count = ring.len();
                (0..count).find(|&k| ring[k] == to && ring[(k + 1) % count] == from).map(|k| (ring, k))
            });
            if let Some((ring, k)) = neighbour {
                // The neighbour runs from `to` to `from`.
                let mut chain = between.to_vec();
                if b > a {
                    chain.reverse();
                }
                ring.splice((k + 1)..=k, chain);
            }
        }
        true
    }

    /// The vertices of a ring in order along it, if it is a sliver.
    fn sliver(&self, ring: &[u32]) -> Option<Vec<u32>> {
        let at = |v: u32| self.points[v as usize];
        let farthest = |from: Point3<f64>| {
            ring.iter()
                .copied()
                .max_by(|&a, &b| (at(a) - from).norm_squared().total_cmp(&(at(b) - from).norm_squared()))
        };
        let start = at(farthest(at(*ring.first()?))?);
        let end = at(farthest(start)?);
        let along = (end - start).try_normalize(0.0)?;
        let off = |v: u32| {
            let to = at(v) - start;
            (to - along * to.dot(&along)).norm()
        };
        if ring.iter().any(|&v| off(v) >= COLLAPSED) {
            return None;
        }
        let mut order = ring.to_vec();
        order.sort_by(|&a, &b| {
            (at(a) - start).dot(&along).total_cmp(&(at(b) - start).dot(&along)).then_with(|| a.cmp(&b))
        });
        Some(order)
    }

    /// Removes one pair of faces that are the same with opposite direction: a wall without thickness.
    fn cancel_opposite(&mut self) -> bool {
        let mut keys: BTreeMap<Vec<Vec<u32>>, usize> = BTreeMap::new();
        let mut pair = None;
        for (i, face) in self.faces.iter().enumerate() {
            let mut reversed: Vec<Vec<u32>> =
                face.rings.iter().map(|ring| canonical(ring.iter().rev().copied())).collect();
            reversed.sort_unstable();
            if let Some(&other) = keys.get(&reversed) {
                pair = Some((other, i));
                break;
            }
            let mut key: Vec<Vec<u32>> = face.rings.iter().map(|ring| canonical(ring.iter().copied())).collect();
            key.sort_unstable();
            keys.insert(key, i);
        }
        let Some((a, b)) = pair else { return false };
        self.faces.remove(b);
        self.faces.remove(a);
        true
    }

    /// Joins one pair of faces of the same plane along an edge that they share.
    fn join_coplanar(&mut self) -> bool {
        let mut sides: BTreeMap<(u32, u32, u32), (usize, usize, usize)> = BTreeMap::new();
        for (f, face) in self.faces.iter().enumerate() {
            for (r, ring) in face.rings.iter().enumerate() {
                for (k, &from) in ring.iter().enumerate() {
                    sides.insert((face.label, from, ring[(k + 1) % ring.len()]), (f, r, k));
                }
            }
        }
        let pair = sides.iter().find_map(|(&(label, from, to), &here)| {
            let there = *sides.get(&(label, to, from))?;
            // The second gives its exterior to a ring of the first.
            (here.0 != there.0 && there.1 == 0).then_some((here, there))
        });
        let Some(((f, r, k), (g, _, l))) = pair else { return false };
        let mut other = self.faces[g].rings.remove(0);
        other.rotate_left(l + 1);
        let holes = std::mem::take(&mut self.faces[g].rings);
        let face = &mut self.faces[f];
        // The other way round from `from` to `to`, without these two.
        face.rings[r].splice((k + 1)..=k, other[1..other.len() - 1].iter().copied());
        face.rings.extend(holes);
        self.faces.remove(g);
        true
    }

    /// Removes one vertex between the same two straight edges in the only two rings that have it.
    fn drop_straight_vertex(&mut self) -> bool {
        let mut uses: BTreeMap<u32, Vec<(usize, usize, usize)>> = BTreeMap::new();
        for (f, face) in self.faces.iter().enumerate() {
            for (r, ring) in face.rings.iter().enumerate() {
                for (k, &v) in ring.iter().enumerate() {
                    uses.entry(v).or_default().push((f, r, k));
                }
            }
        }
        for (&v, places) in &uses {
            let [first, second] = places[..] else { continue };
            let neighbours = |(f, r, k): (usize, usize, usize)| {
                let ring = &self.faces[f].rings[r];
                (ring.len() > 3).then(|| (ring[(k + ring.len() - 1) % ring.len()], ring[(k + 1) % ring.len()]))
            };
            let (Some((a, b)), Some((c, d))) = (neighbours(first), neighbours(second)) else { continue };
            let [p, from, to] = [v, a, b].map(|v| self.points[v as usize]);
            let Some(along) = (to - from).try_normalize(0.0) else { continue };
            let t = (p - from).dot(&along);
            let straight = (p - from - along * t).norm() < COLLAPSED && t > 0.0 && t < (to - from).norm();
            if (a, b) == (d, c) && straight {
                for (f, r, k) in [second, first] {
                    self.faces[f].rings[r].remove(k);
                }
                return true;
            }
        }
        false
    }

    /// The faces in sets that hang together by edges; the sets in the order of their first face.
    pub(super) fn connected(&self) -> Vec<Vec<usize>> {
        let mut set: Vec<usize> = (0..self.faces.len()).collect();
        let root = |set: &[usize], mut i: usize| {
            while set[i] != i {
                i = set[i];
            }
            i
        };
        let mut edges: Vec<(u32, u32, usize)> = Vec::new();
        for (f, face) in self.faces.iter().enumerate() {
            for ring in &face.rings {
                for (i, &a) in ring.iter().enumerate() {
                    let b = ring[(i + 1) % ring.len()];
                    edges.push((a.min(b), a.max(b), f));
                }
            }
        }
        edges.sort_unstable();
        for pair in edges.windows(2).filter(|pair| (pair[0].0, pair[0].1) == (pair[1].0, pair[1].1)) {
            let (a, b) = (root(&set, pair[0].2), root(&set, pair[1].2));
            set[a.max(b)] = a.min(b);
        }
        let mut sets: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for f in 0..self.faces.len() {
            sets.entry(root(&set, f)).or_default().push(f);
        }
        sets.into_values().collect()
    }
}

/// Removes repeated vertices and spikes (there and back) from a closed ring.
fn tidy(ring: &mut Vec<u32>) {
    let mut i = 0;
    while ring.len() >= 3 && i < ring.len() {
        let n = ring.len();
        if ring[i] == ring[(i + 1) % n] {
            ring.remove(i);
            i = i.saturating_sub(2);
        } else if ring[i] == ring[(i + 2) % n] {
            // The tip and the way back.
            let tip = (i + 1) % n;
            let back = (i + 2) % n;
            ring.remove(tip.max(back));
            ring.remove(tip.min(back));
            i = i.saturating_sub(2);
        } else {
            i += 1;
        }
    }
}

fn touches_itself(ring: &[u32]) -> bool {
    let mut sorted = ring.to_vec();
    sorted.sort_unstable();
    sorted.windows(2).any(|pair| pair[0] == pair[1])
}

/// Cuts a ring at the vertices that it visits more than once.
pub(super) fn simple_rings(ring: &[u32]) -> Vec<Vec<u32>> {
    let mut simple = Vec::new();
    let mut path: Vec<u32> = Vec::with_capacity(ring.len());
    for &vertex in ring {
        if let Some(at) = path.iter().position(|&v| v == vertex) {
            simple.push(path.split_off(at));
        }
        path.push(vertex);
    }
    simple.push(path);
    simple
}

/// A ring that starts at its lowest vertex.
fn canonical(ring: impl Iterator<Item = u32>) -> Vec<u32> {
    let mut ring: Vec<u32> = ring.collect();
    let lowest = (0..ring.len()).min_by_key(|&i| ring[i]).unwrap_or(0);
    ring.rotate_left(lowest);
    ring
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ring_that_meets_itself_falls_apart_there() {
        assert_eq!(simple_rings(&[1, 2, 3, 1, 4, 5]), [vec![1, 2, 3], vec![1, 4, 5]]);
        assert_eq!(simple_rings(&[1, 2, 3, 2, 4]), [vec![2, 3], vec![1, 2, 4]]);
        assert_eq!(simple_rings(&[7, 8, 9]), [vec![7, 8, 9]]);
    }
}
