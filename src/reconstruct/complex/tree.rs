//! The binary space partition as a tree: which cells a patch meets.

use super::patch::Patch;
use super::{CellId, PlaneId};
use crate::geometry::Plane;

/// Index of a node of the tree.
pub(super) type NodeId = usize;

enum Node {
    Leaf(CellId),
    /// A cell that was cut by a plane.
    Cut {
        plane: PlaneId,
        /// Its parts on the negative and on the positive side.
        children: [NodeId; 2],
    },
}

/// The history of cuts; its leaves are the cells.
pub(super) struct Tree {
    nodes: Vec<Node>,
}

impl Tree {
    /// The tree of one cell.
    pub(super) fn new(cell: CellId) -> Self {
        Self { nodes: vec![Node::Leaf(cell)] }
    }

    /// The leaves that `patch` meets within its tolerance, or all leaves without one.
    ///
    /// The patch is divided along the cuts on its way down. As every cell is bounded by the cuts above it, what
    /// arrives at a leaf is the part of the patch inside that cell: a finer test than those of boxes and of
    /// rectangles by separating axes (paper, section 3.2; method, section 4), which it makes superfluous.
    pub(super) fn leaves(&self, patch: Option<Patch>, planes: &[Plane]) -> Vec<(NodeId, CellId)> {
        let mut met = Vec::new();
        let mut open = vec![(0, patch)];
        while let Some((node, patch)) = open.pop() {
            match &self.nodes[node] {
                Node::Leaf(cell) => met.push((node, *cell)),
                Node::Cut { plane, children } => {
                    let Some(patch) = patch else {
                        open.extend(children.map(|child| (child, None)));
                        continue;
                    };
                    let (negative, positive) = patch.divide(&planes[*plane as usize]);
                    for (child, part) in children.iter().zip([negative, positive]) {
                        if part.is_some() {
                            open.push((*child, part));
                        }
                    }
                }
            }
        }
        // By cell, so that the order of cutting does not depend on the shape of the tree.
        met.sort_unstable_by_key(|&(_, cell)| cell);
        met
    }

    /// Notes that the cell at `leaf` was cut by `plane` into these cells on its negative and positive side.
    pub(super) fn cut(&mut self, leaf: NodeId, plane: PlaneId, cells: [CellId; 2]) {
        let first = self.nodes.len();
        self.nodes.extend(cells.map(Node::Leaf));
        self.nodes[leaf] = Node::Cut { plane, children: [first, first + 1] };
    }
}
