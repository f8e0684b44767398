//! The vertex list of a file: every grid point once.

use foldhash::fast::RandomState;
use std::collections::{BTreeMap, HashMap};

/// Vertices in the order of their first use, as integers of the file's grid.
///
/// A key is split in its upper and lower halves: neighbouring vertices share the upper ones, so that an entry takes 16
/// bytes instead of 32.
#[derive(Debug, Default)]
pub(super) struct Vertices {
    blocks: BTreeMap<[i64; 3], HashMap<[u32; 3], u32, RandomState>>,
    len: usize,
    fresh: Vec<[i64; 3]>,
}

impl Vertices {
    /// The index of a vertex, which is added unless it is there.
    ///
    /// Beyond 2³² vertices indices are meaningless; see [`Self::len`].
    pub(super) fn index(&mut self, vertex: [i64; 3]) -> u32 {
        let block = self.blocks.entry(vertex.map(|c| c >> 32)).or_default();
        *block.entry(vertex.map(|c| c as u32)).or_insert_with(|| {
            self.fresh.push(vertex);
            self.len += 1;
            (self.len - 1) as u32
        })
    }

    /// How many vertices there are.
    pub(super) fn len(&self) -> usize {
        self.len
    }

    /// Takes those added since the last call, in order.
    pub(super) fn take_fresh(&mut self) -> Vec<[i64; 3]> {
        std::mem::take(&mut self.fresh)
    }

    /// Forgets all, but keeps the memory for the next feature.
    pub(super) fn clear(&mut self) {
        self.blocks.values_mut().for_each(HashMap::clear);
        self.len = 0;
        self.fresh.clear();
    }
}

/// Appends vertices as JSON arrays separated by commas.
pub(super) fn write_json(vertices: &[[i64; 3]], out: &mut Vec<u8>) {
    for (i, [x, y, z]) in vertices.iter().enumerate() {
        if i > 0 {
            out.push(b',');
        }
        out.extend_from_slice(format!("[{x},{y},{z}]").as_bytes());
    }
}
