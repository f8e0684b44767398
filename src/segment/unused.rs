//! Points that are there and not used, because of their class or a flag.

use super::counts::PointCounts;
use super::options::{BuildingClasses, SegmentOptions};
use crate::source::classes::{OVERLAP, class_name};
use crate::source::points::ScanPoint;
use std::collections::BTreeMap;

/// Fewer points than this in a footprint are nothing to be told.
const FEWEST: u64 = 10;

/// Why a point that could be of a building is not used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Unused {
    /// Its class was not asked for.
    Class(u8),
    /// It is marked as synthetic.
    Synthetic,
    /// It is marked as withheld.
    Withheld,
}

impl Unused {
    /// Why this point is not used: for a flag, or for its class.
    pub fn of(point: &ScanPoint, is_flagged: bool) -> Self {
        match (is_flagged, point.withheld) {
            (true, true) => Self::Withheld,
            (true, false) => Self::Synthetic,
            (false, _) => Self::Class(point.class),
        }
    }

    /// Whether one building that most points of this kind are missing from is worth a word. Points of other classes stand
    /// on many a footprint whose building was taken down: trees, cars, heaps.
    fn is_telling(self) -> bool {
        !matches!(self, Self::Class(class) if class != OVERLAP)
    }

    fn name(self) -> String {
        match self {
            Self::Class(class) => format!("of class {class} ({})", class_name(class)),
            Self::Synthetic => "marked as synthetic".to_owned(),
            Self::Withheld => "marked as withheld".to_owned(),
        }
    }
}

/// Counts `n` more points of a kind.
pub(super) fn add(counts: &mut Vec<(Unused, u64)>, kind: Unused, n: u64) {
    match counts.iter_mut().find(|(known, _)| *known == kind) {
        Some((_, count)) => *count += n,
        None => counts.push((kind, n)),
    }
}

/// What is not used in all footprints that were seen.
#[derive(Debug, Default)]
pub(super) struct Tally {
    /// The building points in all footprints.
    used: u64,
    /// Per kind, how many points there are, and the footprints of which it holds more than are used.
    kinds: BTreeMap<Unused, (u64, Vec<usize>)>,
}

impl Tally {
    /// Sees a footprint with so many building points, and the others that could be of it.
    pub(super) fn see(&mut self, footprint: usize, used: u64, unused: &[(Unused, u64)]) {
        self.used += used;
        for &(kind, n) in unused {
            let (total, footprints) = self.kinds.entry(kind).or_default();
            *total += n;
            if n >= FEWEST && n > used {
                footprints.push(footprint);
            }
        }
    }

    /// One line about the footprints, of `all`, of which most points are not used, with the options that would use them; `None`
    /// where there is nothing to tell.
    pub(super) fn warning(self, all: usize, options: &SegmentOptions) -> Option<String> {
        let Self { used, mut kinds } = self;
        kinds.retain(|kind, (total, footprints)| !footprints.is_empty() && (kind.is_telling() || *total > used));
        told(all, used, &kinds, options)
    }
}

fn told(
    all: usize,
    used: u64,
    kinds: &BTreeMap<Unused, (u64, Vec<usize>)>,
    options: &SegmentOptions,
) -> Option<String> {
    if kinds.is_empty() {
        return None;
    }
    let mut footprints: Vec<usize> = kinds.values().flat_map(|(_, footprints)| footprints).copied().collect();
    footprints.sort_unstable();
    footprints.dedup();
    let counts: Vec<String> = kinds.iter().map(|(kind, (n, _))| format!("{n} {}", kind.name())).collect();
    let mut remedies = Vec::new();
    let classes: Vec<u8> =
        kinds.keys().filter_map(|k| if let Unused::Class(class) = k { Some(*class) } else { None }).collect();
    if let (BuildingClasses::Listed(listed), false) = (&options.building_classes, classes.is_empty()) {
        let mut classes = [listed.as_slice(), &classes].concat();
        classes.sort_unstable();
        let names: Vec<String> = classes.iter().map(u8::to_string).collect();
        remedies.push(format!("--building-class {}", names.join(",")));
    }
    match (kinds.contains_key(&Unused::Synthetic), kinds.contains_key(&Unused::Withheld)) {
        (true, true) => remedies.push("--use-flagged both".to_owned()),
        (true, false) => remedies.push("--use-flagged synthetic".to_owned()),
        (false, true) => remedies.push("--use-flagged withheld".to_owned()),
        (false, false) => {}
    }
    Some(format!(
        "in {} of {} footprints most points that could be of a building are not used (in all footprints {}, against {used} \
         that are used): {} would use them",
        footprints.len(),
        all,
        counts.join(", "),
        remedies.join(" and ")
    ))
}

/// One line about classes that were asked for, by other than the defaults, and do not occur; `None` where there are none,
/// or nothing was read.
pub(super) fn absent(counts: &PointCounts, options: &SegmentOptions) -> Option<String> {
    let default = SegmentOptions::default();
    let mut missing = Vec::new();
    let mut look = |option: &str, classes: &[u8]| {
        let classes = classes.iter().filter(|class| !counts.classes.contains_key(class));
        missing.extend(classes.map(|class| format!("{class} of {option}")));
    };
    match &options.building_classes {
        BuildingClasses::Listed(classes) if options.building_classes != default.building_classes => {
            look("--building-class", classes);
        }
        _ => {}
    }
    if options.ground_classes != default.ground_classes {
        look("--ground-class", &options.ground_classes);
    }
    if missing.is_empty() || counts.classes.is_empty() {
        return None;
    }
    let there: Vec<String> = counts.classes.iter().map(|(class, n)| format!("{class} ({n} points)")).collect();
    Some(format!("no point is of class {}; the classes are {}", missing.join(", "), there.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classes_that_do_not_occur_are_told_unless_they_are_the_defaults() {
        let counts = PointCounts { classes: [(2, 7), (6, 9)].into(), ..PointCounts::default() };
        let default = SegmentOptions::default();
        assert_eq!(absent(&counts, &default), None);
        let ground = SegmentOptions { ground_classes: vec![2, 8], ..default.clone() };
        let said = absent(&counts, &ground).unwrap();
        assert_eq!(said, "no point is of class 8 of --ground-class; the classes are 2 (7 points), 6 (9 points)");
        let building = SegmentOptions { building_classes: BuildingClasses::Listed(vec![6, 60]), ..default };
        assert!(absent(&counts, &building).unwrap().contains("class 60 of --building-class"));
        assert_eq!(absent(&PointCounts::default(), &building), None);
    }

    #[test]
    fn what_most_points_of_a_building_are_is_told_and_what_stands_about_is_not() {
        let said = |used: &[u64], unused: &[((usize, Unused), u64)]| {
            let mut tally = Tally::default();
            for (footprint, &used) in used.iter().enumerate() {
                let own = unused.iter().filter(|((of, _), _)| *of == footprint);
                tally.see(footprint, used, &own.map(|((_, kind), n)| (*kind, *n)).collect::<Vec<_>>());
            }
            tally.warning(used.len(), &SegmentOptions::default())
        };
        assert_eq!(said(&[500, 33], &[((0, Unused::Class(12)), 100), ((1, Unused::Class(1)), 200)]), None);
        assert_eq!(said(&[0], &[((0, Unused::Synthetic), 9)]), None);
        let overlap = said(&[500, 33], &[((0, Unused::Class(12)), 10), ((1, Unused::Class(12)), 627)]).unwrap();
        assert!(overlap.starts_with("in 1 of 2 footprints") && overlap.contains("637 of class 12"), "{overlap}");
        assert!(overlap.contains("against 533") && overlap.contains("--building-class 6,12 would"), "{overlap}");
        let many = [((0, Unused::Class(1)), 600), ((0, Unused::Withheld), 501), ((1, Unused::Synthetic), 40)];
        let both = said(&[500, 33], &many).unwrap();
        assert!(both.contains("--building-class 1,6 and --use-flagged both"), "{both}");
    }
}
