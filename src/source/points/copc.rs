//! The octree of a COPC file (COPC 1.0): which chunks are wanted.

use super::chunks::Chunk;
use super::stream::Region;
use super::tile::Tile;
use las::copc::{CopcInfoVlr, VoxelKey};
use std::collections::HashSet;
use std::io::{Read, Seek, SeekFrom};

/// Bytes of an entry of the hierarchy.
const ENTRY: usize = 32;
/// Where the place and the size of the root page stand in the info record.
const ROOT_PAGE: std::ops::Range<usize> = 40..56;
/// The count of points of an entry that refers to another page.
const PAGE: i32 = -1;
/// Deeper than any octree over 32-bit coordinates.
const DEEPEST: i32 = 30;

/// A node of the octree: its key, and the chunk with its points.
struct Node {
    key: VoxelKey,
    chunk: Chunk,
}

impl Tile {
    /// The chunks of the octree nodes that touch the region, in the order of the file, and the number of points in the
    /// others; `None` when the tile is not COPC or its hierarchy is damaged (it can still be read as LAZ).
    pub(super) fn copc_nodes(&self, file: &mut (impl Read + Seek), region: &Region) -> Option<(Vec<Chunk>, u64)> {
        let info = self.header.copc_info_vlr().filter(|_| self.is_copc && self.placement.is_identity())?;
        let mut chunks = Vec::new();
        let mut passed_over = 0;
        for Node { key, chunk } in self.hierarchy(file)? {
            let node = key.bounds(&info);
            if region([node.min.x, node.min.y], [node.max.x, node.max.y]) {
                chunks.push(chunk);
            } else {
                passed_over += chunk.points;
            }
        }
        chunks.sort_by_key(|chunk| chunk.start);
        let listed = passed_over + chunks.iter().map(|c| c.points).sum::<u64>();
        (listed == self.layout().points).then_some((chunks, passed_over))
    }

    /// The nodes that hold points, from all pages. The root page is where the info record says, which need not be the
    /// beginning of the hierarchy; the others are where pages refer to.
    fn hierarchy(&self, file: &mut (impl Read + Seek)) -> Option<Vec<Node>> {
        let info = self.header.vlrs().iter().find(|vlr| {
            vlr.user_id.eq_ignore_ascii_case(las::copc::USER_ID) && vlr.record_id == CopcInfoVlr::RECORD_ID
        })?;
        let root = info.data.get(ROOT_PAGE)?.as_chunks::<8>().0;
        let mut pages = vec![(u64::from_le_bytes(*root.first()?), u64::from_le_bytes(*root.get(1)?))];
        // Pages that refer to one another in a circle would never end.
        let mut seen = HashSet::new();
        let size = self.layout().file_size;
        let mut left = size;
        let mut nodes = Vec::new();
        while let Some((offset, length)) = pages.pop() {
            // All pages together are no larger than the file.
            left = left.checked_sub(length)?;
            if !seen.insert(offset) || offset.checked_add(length)? > size {
                return None;
            }
            file.seek(SeekFrom::Start(offset)).ok()?;
            let mut page = vec![0; length as usize];
            file.read_exact(&mut page).ok()?;
            for entry in page.as_chunks::<ENTRY>().0 {
                let int = |at: usize| i32::from_le_bytes(std::array::from_fn(|i| entry[at + i]));
                let key = VoxelKey { l: int(0), x: int(4), y: int(8), z: int(12) };
                let start = u64::from_le_bytes(std::array::from_fn(|i| entry[16 + i]));
                let (bytes, points) = (u64::try_from(int(24)).ok()?, int(28));
                if !(0..=DEEPEST).contains(&key.l) || start.checked_add(bytes)? > size {
                    return None;
                }
                match points {
                    PAGE => pages.push((start, bytes)),
                    0 => {}
                    points => {
                        let points = u64::try_from(points).ok()?;
                        nodes.push(Node { key, chunk: Chunk { start, bytes, points } });
                    }
                }
            }
        }
        Some(nodes)
    }
}
