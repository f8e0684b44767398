//! A surface in pieces that are valid each by itself: triangles that hang together by their edges, with one fan of them at
//! every vertex.
//!
//! Courtyards are pieces of their own, and where two buildings touch in a corner only, the few triangles of one side of it
//! become a piece.

use std::collections::HashMap;

use foldhash::fast::FixedState;

/// The triangles of each piece, by their numbers; the largest piece first.
pub(super) fn pieces(triangles: &[[u32; 3]]) -> Vec<Vec<usize>> {
    let neighbours = neighbours(triangles);
    let mut waiting = connected((0..triangles.len()).collect(), &neighbours);
    let mut done = Vec::new();
    while let Some(piece) = waiting.pop() {
        let Some(cut) = pinch(&piece, triangles, &neighbours) else {
            done.push(piece);
            continue;
        };
        let rest = piece.into_iter().filter(|triangle| cut.binary_search(triangle).is_err()).collect();
        waiting.extend(connected(cut, &neighbours));
        waiting.extend(connected(rest, &neighbours));
    }
    for piece in &mut done {
        piece.sort_unstable();
    }
    done.sort_by(|a, b| b.len().cmp(&a.len()).then_with(|| a.cmp(b)));
    done
}

/// The triangles beyond the sides of each, from one corner to the next; only where an edge has two, which run it in opposite
/// directions.
fn neighbours(triangles: &[[u32; 3]]) -> Vec<[Option<usize>; 3]> {
    let mut sides: HashMap<[u32; 2], Vec<(usize, usize, bool)>, FixedState> = HashMap::default();
    for (number, triangle) in triangles.iter().enumerate() {
        for side in 0..3 {
            let (a, b) = (triangle[side], triangle[(side + 1) % 3]);
            sides.entry([a.min(b), a.max(b)]).or_default().push((number, side, a < b));
        }
    }
    let mut neighbours = vec![[None; 3]; triangles.len()];
    for uses in sides.values() {
        if let [(one, of_one, forth), (other, of_other, back)] = uses[..]
            && forth != back
        {
            neighbours[one][of_one] = Some(other);
            neighbours[other][of_other] = Some(one);
        }
    }
    neighbours
}

/// Parts of a set of triangles that hang together by edges.
fn connected(set: Vec<usize>, neighbours: &[[Option<usize>; 3]]) -> Vec<Vec<usize>> {
    let mut set = set;
    set.sort_unstable();
    let mut is_open = vec![true; set.len()];
    let mut parts = Vec::new();
    for start in 0..set.len() {
        if !std::mem::take(&mut is_open[start]) {
            continue;
        }
        let (mut part, mut next) = (vec![set[start]], 0);
        while let Some(triangle) = part.get(next).copied() {
            next += 1;
            for beside in neighbours[triangle].iter().flatten() {
                if let Ok(slot) = set.binary_search(beside)
                    && std::mem::take(&mut is_open[slot])
                {
                    part.push(*beside);
                }
            }
        }
        parts.push(part);
    }
    parts
}

/// The triangles of all fans but the largest at the first vertex where a piece has several, in order; `None` where none has.
fn pinch(piece: &[usize], triangles: &[[u32; 3]], neighbours: &[[Option<usize>; 3]]) -> Option<Vec<usize>> {
    let mut members: Vec<usize> = piece.to_vec();
    members.sort_unstable();
    let mut at: Vec<(u32, usize)> = members.iter().flat_map(|&t| triangles[t].map(|vertex| (vertex, t))).collect();
    at.sort_unstable();
    for of_vertex in at.chunk_by(|a, b| a.0 == b.0) {
        let vertex = of_vertex[0].0;
        let mut fans = fans(vertex, of_vertex.iter().map(|(_, triangle)| *triangle).collect(), triangles, neighbours);
        if fans.len() > 1 {
            fans.sort_by(|a, b| b.len().cmp(&a.len()).then_with(|| a.cmp(b)));
            let mut cut: Vec<usize> = fans.into_iter().skip(1).flatten().collect();
            cut.sort_unstable();
            return Some(cut);
        }
    }
    None
}

/// The triangles at a vertex by fans: those that hang together by edges that end there.
fn fans(
    vertex: u32,
    mut left: Vec<usize>,
    triangles: &[[u32; 3]],
    neighbours: &[[Option<usize>; 3]],
) -> Vec<Vec<usize>> {
    let mut fans = Vec::new();
    while let Some(start) = left.pop() {
        let (mut fan, mut next) = (vec![start], 0);
        while let Some(triangle) = fan.get(next).copied() {
            next += 1;
            for side in 0..3 {
                let ends = [triangles[triangle][side], triangles[triangle][(side + 1) % 3]];
                let Some(beside) = neighbours[triangle][side].filter(|_| ends.contains(&vertex)) else { continue };
                if let Some(slot) = left.iter().position(|other| *other == beside) {
                    left.swap_remove(slot);
                    fan.push(beside);
                }
            }
        }
        fan.sort_unstable();
        fans.push(fan);
    }
    fans
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ring_that_touches_itself_in_a_corner_is_cut_there() {
        // A strip around two holes that touch in vertex 0: two fans there.
        let around = [[0, 1, 2], [2, 1, 3], [2, 3, 4], [4, 3, 5], [4, 5, 0]];
        assert_eq!(pieces(&around), [vec![0, 1, 2, 3], vec![4]]);
        // Closed at vertex 0 it is one piece.
        let closed = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]];
        assert_eq!(pieces(&closed), [[0, 1, 2, 3]]);
    }

    #[test]
    fn triangles_that_share_but_a_corner_are_apart() {
        assert_eq!(pieces(&[[0, 1, 2], [2, 3, 4], [3, 5, 4]]), [vec![1, 2], vec![0]]);
        // Three on one edge belong to none of the others.
        assert_eq!(pieces(&[[0, 1, 2], [1, 0, 3], [0, 1, 4]]), [[0], [1], [2]]);
    }
}
