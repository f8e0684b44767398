//! Which objects belong together.

use std::collections::HashMap;

use super::CityModel;

/// How many levels of parents are followed: objects that are each other's parents would never end.
const MOST_LEVELS: usize = 16;

impl CityModel {
    /// Indices into [`Self::objects`] by their top-level object, which comes first; in the order of the file.
    pub fn groups(&self) -> Vec<Vec<usize>> {
        let index: HashMap<&str, usize> =
            self.objects.iter().zip(0..).map(|(object, i)| (object.id.as_str(), i)).collect();
        let parent = |i: usize| {
            let parents = &self.objects.get(i)?.parents;
            parents.iter().find_map(|id| index.get(id.as_str()).copied())
        };
        let root = |start: usize| {
            let mut at = start;
            for _ in 0..MOST_LEVELS {
                match parent(at) {
                    Some(up) => at = up,
                    None => return at,
                }
            }
            start
        };
        let mut groups: Vec<Vec<usize>> = Vec::new();
        let mut of_root: HashMap<usize, usize> = HashMap::new();
        for i in 0..self.objects.len() {
            let root = root(i);
            let group = *of_root.entry(root).or_insert_with(|| {
                groups.push(Vec::new());
                groups.len() - 1
            });
            if let Some(group) = groups.get_mut(group) {
                if i == root { group.insert(0, i) } else { group.push(i) }
            }
        }
        groups
    }
}
