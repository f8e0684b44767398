//! A few points of a tile, read without decoding it, to hold its header against.
//!
//! A header whose box is plausible and wrong would make a tile pass for one that is far from all footprints, and nobody
//! would ever read a point of it.

use super::header::Layout;
use super::tile::Extent;
use las::{Transform, Vector};
use std::io::{Read, Seek, SeekFrom};

/// Points that are looked at.
const SAMPLES: u64 = 64;
/// Share of the box's sides, and CRS units, by which points may lie outside it without a word: headers are rounded.
const TOLERANCE: (f64, f64) = (0.01, 1.0);

/// Whether the box of the header holds the points, as far as a few of them tell: spread over the records of a LAS file, or
/// the first of some chunks of a LAZ file, which stand uncompressed. True where none can be read.
pub(super) fn are_within<R: Read + Seek>(
    source: &mut R,
    layout: &Layout,
    transforms: &Vector<Transform>,
    extent: &Extent,
) -> bool {
    let (mut inside, mut outside) = (0, 0);
    for start in starts(source, layout) {
        let mut record = [[0; 4]; 2];
        if source.seek(SeekFrom::Start(start)).and_then(|_| source.read_exact(record.as_flattened_mut())).is_err() {
            continue;
        }
        let [x, y] = record.map(i32::from_le_bytes);
        let place = [transforms.x.direct(x), transforms.y.direct(y)];
        let is_inside = (0..2).all(|axis| {
            let (low, high) = (extent.min[axis], extent.max[axis]);
            let tolerance = TOLERANCE.0 * (high - low) + TOLERANCE.1;
            (low - tolerance..=high + tolerance).contains(&place[axis])
        });
        if is_inside { inside += 1 } else { outside += 1 }
    }
    // Damage puts single points anywhere: those are left out later on, and the box stands.
    outside * 4 <= inside + outside
}

/// The bytes at which some records begin.
fn starts<R: Read + Seek>(source: &mut R, layout: &Layout) -> Vec<u64> {
    let spread = |count: u64| {
        let taken = count.min(SAMPLES);
        (0..taken).map(move |i| if taken > 1 { i * (count - 1) / (taken - 1) } else { 0 })
    };
    match &layout.compression {
        None => {
            let record_len = layout.record_len as u64;
            let held = ((layout.file_size - layout.data_start) / record_len.max(1)).min(layout.points);
            spread(held).map(|index| layout.data_start + index * record_len).collect()
        }
        Some(compression) => {
            let chunks = compression.table(source, layout).unwrap_or_default();
            spread(chunks.len() as u64)
                .filter_map(|index| chunks.get(index as usize))
                .map(|chunk| chunk.start)
                .collect()
        }
    }
}
