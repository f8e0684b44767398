//! Names of files from ids and names of tiles: whatever they hold, the files stay in their folder, and no two are one.
//!
//! Letters, digits and `- _ .` stay; everything else becomes `_`, so do dots at either end, and names that a system keeps
//! for devices get a `_` more. What is longer than 100 bytes is cut, with a hash of all of it at its end. Of names that
//! differ in case alone, or not at all any more, the later ones get a number; who needs no change goes first.

use std::collections::{HashMap, HashSet};

use crate::geometry::seed_of;

/// Bytes of a name, at most; systems allow 255 with everything around it.
const LONGEST: usize = 100;
/// Bytes of a name that is cut off, before its hash.
const CUT: usize = 80;
/// What a system keeps for devices, whatever stands behind a dot.
const DEVICES: [&str; 6] = ["con", "prn", "aux", "nul", "com", "lpt"];

/// The names of the files for some ids, in their order.
pub(super) fn for_ids(ids: &[&str]) -> Vec<String> {
    let mut taken: HashSet<String> = HashSet::new();
    let mut names: HashMap<usize, String> = HashMap::new();
    for is_first in [true, false] {
        for (index, id) in ids.iter().enumerate() {
            let name = safe(id);
            if (name == *id) != is_first {
                continue;
            }
            let mut free = name.clone();
            let mut number = 1;
            while !taken.insert(free.to_lowercase()) {
                number += 1;
                free = format!("{name}_{number}");
            }
            names.insert(index, free);
        }
    }
    (0..names.len()).filter_map(|index| names.remove(&index)).collect()
}

/// The name of a file for an id.
fn safe(id: &str) -> String {
    let plain = |c: char| if c.is_alphanumeric() || "-_.".contains(c) { c } else { '_' };
    let mut name: String = id.chars().map(plain).collect();
    let dots = name.len() - name.trim_start_matches('.').len();
    name.replace_range(..dots, &"_".repeat(dots));
    let dots = name.len() - name.trim_end_matches('.').len();
    let end = name.len() - dots;
    name.replace_range(end.., &"_".repeat(dots));
    if name.is_empty() {
        name.push('_');
    }
    let stem = name.split('.').next().unwrap_or_default().to_lowercase();
    let bare = stem.strip_suffix(|c: char| c.is_ascii_digit()).unwrap_or(&stem);
    if DEVICES.contains(&bare) {
        name.insert(0, '_');
    }
    if name.len() > LONGEST {
        let cut = (0..=CUT).rev().find(|at| name.is_char_boundary(*at)).unwrap_or_default();
        name.truncate(cut);
        name.extend([format!("-{:016x}", seed_of(id))]);
    }
    name
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stay_in_their_folder_and_apart() {
        let ids = [
            "a/b",
            "a_b",
            "../../etc/passwd",
            "A_B",
            "..",
            "",
            "con",
            "COM1.x",
            "é ü",
            "a_b_2",
            "a?b",
            ".hidden",
            "x.",
        ];
        let names = for_ids(&ids);
        let expected = [
            "a_b_3",
            "a_b",
            "___.._etc_passwd",
            "A_B_2",
            "__",
            "_",
            "_con",
            "_COM1.x",
            "é_ü",
            "a_b_2_2",
            "a_b_4",
            "_hidden",
            "x_",
        ];
        assert_eq!(names, expected);
        let long: Vec<String> = (0..2).map(|i| format!("{}{i}", "ß".repeat(200))).collect();
        let names = for_ids(&long.iter().map(String::as_str).collect::<Vec<_>>());
        assert!(names.iter().all(|name| name.len() <= LONGEST) && names[0] != names[1], "{names:?}");
    }
}
