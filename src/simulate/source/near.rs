//! What stands near a building.

use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

use crate::geometry::Aabb;

/// What is farther away hides nothing of a building from a scanner that looks 30° to the side, unless it is a tower.
const REACH: f64 = 20.0;
/// Two boxes that have so much of both in common are of the same building, which a file may hold twice.
const SAME: f64 = 0.9;

/// The boxes of all buildings of a source, searchable by place.
pub(super) struct Near {
    tree: RTree<GeomWithData<Rectangle<[f64; 2]>, usize>>,
    boxes: Vec<Aabb>,
}

impl Near {
    /// Indexes boxes in metres.
    pub fn new(boxes: Vec<Aabb>) -> Self {
        let rectangle = |aabb: &Aabb| Rectangle::from_corners([aabb.min[0], aabb.min[1]], [aabb.max[0], aabb.max[1]]);
        let items = boxes.iter().map(rectangle).zip(0..).map(|(r, i)| GeomWithData::new(r, i)).collect();
        Self { tree: RTree::bulk_load(items), boxes }
    }

    /// The numbers of the buildings around another, ascending, without itself and its doubles.
    pub fn around(&self, index: usize) -> Vec<usize> {
        let Some(own) = self.boxes.get(index) else { return Vec::new() };
        let envelope =
            AABB::from_corners([own.min[0] - REACH, own.min[1] - REACH], [own.max[0] + REACH, own.max[1] + REACH]);
        let found = self.tree.locate_in_envelope_intersecting(&envelope).map(|item| item.data);
        let mut found: Vec<usize> =
            found.filter(|&i| i != index && self.boxes.get(i).is_some_and(|other| !is_same(own, other))).collect();
        found.sort_unstable();
        found
    }
}

/// Whether two boxes have nearly everything in common.
fn is_same(a: &Aabb, b: &Aabb) -> bool {
    let volume = |extent: [f64; 3]| extent.into_iter().map(|side| side.max(0.0)).product::<f64>();
    let both = volume(std::array::from_fn(|i| a.max[i].min(b.max[i]) - a.min[i].max(b.min[i])));
    both > SAME * volume(a.extent()).max(volume(b.extent()))
}
