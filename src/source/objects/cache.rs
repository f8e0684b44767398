//! Blocks of objects that were read last, all readers together: headers and indexes are read in small pieces, often twice.

use std::collections::HashMap;
use std::sync::{LazyLock, Mutex, PoisonError};

use super::object::Bytes;

/// Bytes of a block.
pub(super) const BLOCK: u64 = 16 << 10;
/// Bytes of all blocks together, at most.
const BUDGET: usize = 16 << 20;

/// The object, by its number, and the number of the block in it.
pub(super) type Key = (u64, u64);

#[derive(Default)]
struct Cache {
    blocks: HashMap<Key, (Bytes, u64)>,
    /// Bytes of all blocks.
    held: usize,
    /// How often it was asked.
    tick: u64,
}

static CACHE: LazyLock<Mutex<Cache>> = LazyLock::new(Mutex::default);

/// A block that is there.
pub(super) fn get(key: Key) -> Option<Bytes> {
    let mut cache = CACHE.lock().unwrap_or_else(PoisonError::into_inner);
    cache.tick += 1;
    let tick = cache.tick;
    let (block, used) = cache.blocks.get_mut(&key)?;
    *used = tick;
    Some(block.clone())
}

/// Keeps a block, and forgets the one that was not asked for longest where there is no room.
pub(super) fn keep(key: Key, block: Bytes) {
    let mut cache = CACHE.lock().unwrap_or_else(PoisonError::into_inner);
    cache.tick += 1;
    let tick = cache.tick;
    cache.held += block.len();
    if let Some((old, _)) = cache.blocks.insert(key, (block, tick)) {
        cache.held -= old.len();
    }
    while cache.held > BUDGET {
        let Some(oldest) = cache.blocks.iter().min_by_key(|(_, (_, used))| *used).map(|(key, _)| *key) else { return };
        if let Some((old, _)) = cache.blocks.remove(&oldest) {
            cache.held -= old.len();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_not_asked_for_longest_is_forgotten() {
        let number = u64::MAX;
        let block = || Bytes::from(vec![0; BUDGET / 4]);
        for index in 0..3 {
            keep((number, index), block());
        }
        assert!(get((number, 0)).is_some());
        keep((number, 3), block());
        keep((number, 4), block());
        let held: Vec<bool> = (0..5).map(|index| get((number, index)).is_some()).collect();
        assert!(held[4] && !held[1], "{held:?}");
    }
}
