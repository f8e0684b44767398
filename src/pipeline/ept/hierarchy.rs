//! Which nodes there are: `ept-hierarchy/`.

use std::collections::{HashMap, HashSet};
use std::fmt;

use super::{Ept, read_json};
use crate::error::{InputError, Result};
use crate::source::points::Extent;

/// Deeper than any octree over doubles.
pub(super) const DEEPEST: u32 = 60;
/// What is said of a file that is none.
const WANTED: &str = "a file of the hierarchy: node names and their numbers of points";
/// The number of points of a node whose own file of the hierarchy says more.
const FURTHER: i64 = -1;

/// A node: its level, and its place along the axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(in crate::pipeline) struct Key {
    level: u32,
    place: [u64; 3],
}

impl fmt::Display for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { level, place: [x, y, z] } = self;
        write!(f, "{level}-{x}-{y}-{z}")
    }
}

impl Key {
    const ROOT: Self = Self { level: 0, place: [0; 3] };

    fn parse(text: &str) -> Option<Self> {
        let mut numbers = text.split('-').map(|number| number.parse::<u64>().ok());
        let mut next = || numbers.next().flatten();
        let (level, place) = (next()?, [next()?, next()?, next()?]);
        let level = u32::try_from(level).ok().filter(|level| *level <= DEEPEST)?;
        (numbers.next().is_none() && place.iter().all(|n| *n < 1 << level)).then_some(Self { level, place })
    }

    fn child(self, octant: u64) -> Self {
        let place = std::array::from_fn(|axis| 2 * self.place[axis] + (octant >> axis & 1));
        Self { level: self.level + 1, place }
    }

    /// The box of the node within the cube of the root.
    fn extent(self, cube: &Extent) -> Extent {
        let side = |axis: usize| (cube.max[axis] - cube.min[axis]) / (1_u64 << self.level) as f64;
        let low = |axis: usize, n: u64| cube.min[axis] + n as f64 * side(axis);
        Extent {
            min: std::array::from_fn(|axis| low(axis, self.place[axis])),
            max: std::array::from_fn(|axis| low(axis, self.place[axis] + 1)),
        }
    }
}

impl Ept {
    /// The nodes that hold points, whose level is below `levels` and whose box `wanted` says yes to, the coarse ones first;
    /// each with its number of points.
    ///
    /// # Errors
    /// A file of the hierarchy that cannot be read, or is not what it should be.
    pub fn nodes(&self, levels: u32, wanted: &dyn Fn(&Extent) -> bool) -> Result<Vec<(Key, u64)>> {
        let mut nodes = Vec::new();
        let mut level = vec![Key::ROOT];
        let mut counts = HashMap::new();
        let mut opened = HashSet::new();
        self.read_hierarchy(Key::ROOT, &mut counts)?;
        opened.insert(Key::ROOT);
        while !level.is_empty() {
            let mut below = Vec::new();
            for key in level {
                if key.level >= levels || !wanted(&key.extent(&self.cube)) {
                    continue;
                }
                if counts.get(&key) == Some(&FURTHER) {
                    if !opened.insert(key) {
                        return Err(self.circle(key).into());
                    }
                    self.read_hierarchy(key, &mut counts)?;
                }
                match counts.get(&key).copied() {
                    None => continue,
                    Some(FURTHER) => return Err(self.circle(key).into()),
                    // Nobody stores more than there are bytes; negative numbers are refused on reading.
                    Some(count) => nodes.extend(u64::try_from(count).ok().filter(|n| *n > 0).map(|n| (key, n))),
                }
                if key.level < DEEPEST {
                    below.extend((0..8).map(|octant| key.child(octant)));
                }
            }
            level = below;
        }
        Ok(nodes)
    }

    fn hierarchy_path(&self, key: Key) -> std::path::PathBuf {
        self.root.join("ept-hierarchy").join(format!("{key}.json"))
    }

    fn circle(&self, key: Key) -> InputError {
        InputError::new(
            self.hierarchy_path(key),
            format!("{FURTHER} for the node {key} itself"),
            "its number of points",
        )
    }

    fn read_hierarchy(&self, key: Key, counts: &mut HashMap<Key, i64>) -> Result<()> {
        let path = self.hierarchy_path(key);
        let told: HashMap<String, i64> = read_json(&path, WANTED)?;
        for (name, count) in told {
            let Some(key) = Key::parse(&name) else {
                let expected = "LEVEL-X-Y-Z, such as 2-0-3-1";
                return Err(InputError::new(&path, format!("the node `{name}`"), expected).into());
            };
            if count < FURTHER {
                let found = format!("{count} points in the node {name}");
                return Err(InputError::new(&path, found, "0 or more, or -1 for a file of its own").into());
            }
            counts.insert(key, count);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nodes_have_names_and_boxes() {
        let key = Key::parse("2-0-3-1").unwrap();
        assert_eq!((key.to_string(), key.child(5).to_string()), ("2-0-3-1".into(), "3-1-6-3".into()));
        for bad in ["", "2-0-3", "2-0-4-1", "2-0-3-1-0", "a-0-0-0", "61-0-0-0", "-1-0-0-0"] {
            assert_eq!(Key::parse(bad), None, "{bad}");
        }
        let cube = Extent { min: [0.0; 3], max: [8.0; 3] };
        assert_eq!(key.extent(&cube), Extent { min: [0.0, 6.0, 2.0], max: [2.0, 8.0, 4.0] });
    }
}
