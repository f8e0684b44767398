//! Boxes in the plan, and which of them meet.

use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

/// Numbered boxes in a tree: those that meet are found without comparing all.
pub(crate) struct Boxes(RTree<GeomWithData<Rectangle<[f64; 2]>, usize>>);

impl Boxes {
    /// Boxes by two opposite corners; the others have no box. Each has the number of its place.
    pub fn new(corners: impl IntoIterator<Item = Option<[[f64; 2]; 2]>>) -> Self {
        let boxes = corners.into_iter().zip(0..);
        let boxes = boxes.filter_map(|(corners, i)| {
            let [a, b] = corners?;
            Some(GeomWithData::new(Rectangle::from_corners(a, b), i))
        });
        Self(RTree::bulk_load(boxes.collect()))
    }

    /// Those of segments on a grid, farther on each side by a margin. Coordinates below 2⁵³ are exact.
    pub fn of_segments(segments: impl IntoIterator<Item = [[i64; 2]; 2]>, margin: i64) -> Self {
        Self::new(segments.into_iter().map(|[a, b]| {
            let low = [0, 1].map(|i| (a[i].min(b[i]) - margin) as f64);
            Some([low, [0, 1].map(|i| (a[i].max(b[i]) + margin) as f64)])
        }))
    }

    /// The pairs of a box of these and one of the others that meet, borders included; in no order.
    pub fn meeting<'a>(&'a self, others: &'a Self) -> impl Iterator<Item = (usize, usize)> + 'a {
        self.0.intersection_candidates_with_other_tree(&others.0).map(|(a, b)| (a.data, b.data))
    }

    /// The boxes that meet one, ascending.
    pub fn at(&self, [low, high]: [[f64; 2]; 2]) -> Vec<usize> {
        let meeting = self.0.locate_in_envelope_intersecting(&AABB::from_corners(low, high));
        let mut found: Vec<usize> = meeting.map(|found| found.data).collect();
        found.sort_unstable();
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_meet_at_their_borders_and_not_beyond() {
        let boxes = Boxes::of_segments([[[0, 0], [4, 4]], [[4, 9], [8, 4]], [[20, 0], [9, 3]]], 0);
        let mut pairs: Vec<(usize, usize)> = boxes.meeting(&boxes).filter(|(a, b)| a < b).collect();
        pairs.sort_unstable();
        assert_eq!(pairs, [(0, 1)]);
        let wider = Boxes::of_segments([[[0, 0], [4, 4]], [[4, 9], [8, 4]], [[20, 0], [9, 3]]], 1);
        assert_eq!(wider.meeting(&wider).filter(|(a, b)| a < b).count(), 2);
        assert_eq!(boxes.at([[8.0, 3.0], [9.0, 4.0]]), [1, 2]);
        assert_eq!(Boxes::new([None, Some([[1.0, 1.0], [0.0, 0.0]])]).at([[0.5; 2]; 2]), [1]);
    }
}
