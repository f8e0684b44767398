//! Which building a place of the plan belongs to.

use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

use super::shape::Shape;
use crate::geometry::Cover;

/// The outlines of buildings, indexed.
#[derive(Debug)]
pub struct Outlines {
    covers: Vec<Cover>,
    tree: RTree<GeomWithData<Rectangle<[f64; 2]>, usize>>,
}

impl Outlines {
    /// The outlines of these buildings, in their order.
    pub fn new(shapes: &[Shape]) -> Self {
        let boxes = shapes
            .iter()
            .enumerate()
            .filter(|(_, shape)| !shape.outline.is_empty())
            .map(|(index, shape)| {
                let corners: Vec<[f64; 2]> = shape.outline.iter().flatten().map(|p| [p.x, p.y]).collect();
                GeomWithData::new(Rectangle::from_aabb(AABB::from_points(&corners)), index)
            })
            .collect();
        let covers = shapes.iter().map(|shape| Cover::new(shape.outline.iter().copied())).collect();
        Self { covers, tree: RTree::bulk_load(boxes) }
    }

    /// The boxes around the outlines, as `[min, max]` in local metres.
    pub fn boxes(&self) -> impl Iterator<Item = [[f64; 2]; 2]> + '_ {
        self.tree.iter().map(|item| [item.geom().lower(), item.geom().upper()])
    }

    /// The first building whose outline holds the place.
    pub fn at(&self, x: f64, y: f64) -> Option<usize> {
        self.tree
            .locate_all_at_point(&[x, y])
            .map(|item| item.data)
            .filter(|&index| self.covers.get(index).is_some_and(|outline| outline.contains(x, y)))
            .min()
    }
}
