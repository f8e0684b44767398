//! Ids that occur more than once.

use std::cmp::Ordering;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::PathBuf;

use serde_json::Value;

use crate::sink::{Feature, own};
use crate::source::cityjson::CityModel;

/// How many examples a warning gives.
const EXAMPLES: usize = 5;
/// Coordinates that differ by less are the same: a millimetre where the unit is the metre.
const SAME: f64 = 1e3;

/// A feature that was left out because another of its id stands in its place: a building on the border of two tiles, say.
///
/// Two features of one id are the same building if the boxes around them overlap, or one of them has no geometry. Of these
/// the better one is kept: the one with the higher level of detail; of the same level, the one with the larger
/// `gable_coverage`, then with more `gable_points` (of terrain `gable_terrain_points`), then the one that comes first. If the boxes do not overlap they are
/// different buildings: both are kept, and the later one gets another id.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Repeat {
    /// The id.
    pub id: String,
    /// The file in which the feature was left out.
    pub left_out: PathBuf,
    /// The file whose feature stands in its place.
    pub kept: PathBuf,
    /// Whether both have the same geometry, to a thousandth of a unit.
    pub is_same: bool,
}

/// The hash of an id. A false alarm costs a comparison, nothing more.
fn hash_of(id: &str) -> u64 {
    let mut hasher = DefaultHasher::new();
    id.hash(&mut hasher);
    hasher.finish()
}

/// A feature whose id occurs more than once.
#[derive(Debug)]
struct Candidate {
    input: usize,
    number: usize,
    geometry: u64,
    extent: Option<[[f64; 3]; 2]>,
    /// Level of detail, coverage and points: larger is better.
    rank: [f64; 3],
}

impl Candidate {
    fn of(feature: &Feature, prefix: &str, input: usize, number: usize) -> Self {
        let geometries = || feature.objects.iter().flat_map(|object| &object.geometries);
        let lod = geometries().filter_map(|geometry| geometry.lod.parse().ok()).fold(-1.0, f64::max);
        let attribute = |name: &str| {
            let value = feature.root().and_then(|root| own(&root.attributes, prefix, name));
            value.and_then(Value::as_f64).unwrap_or(-1.0)
        };
        let mut hasher = DefaultHasher::new();
        for geometry in geometries() {
            geometry.lod.hash(&mut hasher);
            for ring in geometry.shells.iter().flat_map(|shell| &shell.faces).flat_map(|face| &face.rings) {
                ring.len().hash(&mut hasher);
                for &v in ring {
                    feature.vertex(v).map(|c| (c * SAME).round() as i64).hash(&mut hasher);
                }
            }
        }
        Self {
            input,
            number,
            geometry: hasher.finish(),
            extent: feature.extent(),
            rank: [lod, attribute("coverage"), attribute("points").max(attribute("terrain_points"))],
        }
    }

    fn is_same_building(&self, other: &Self) -> bool {
        let (Some([a, b]), Some([c, d])) = (self.extent, other.extent) else { return true };
        (0..2).all(|i| a[i] <= d[i] && c[i] <= b[i])
    }

    fn compare(&self, other: &Self) -> Ordering {
        let ranks = self.rank.iter().zip(&other.rank).map(|(a, b)| a.total_cmp(b));
        ranks.fold(Ordering::Equal, Ordering::then)
    }
}

/// All ids, and those that occur more than once.
#[derive(Debug, Default)]
pub(super) struct Survey {
    taken: HashSet<u64>,
    repeated: HashSet<u64>,
    candidates: BTreeMap<String, Vec<Candidate>>,
}

impl Survey {
    /// Takes the ids of all objects of a model.
    pub(super) fn see(&mut self, model: &CityModel) {
        for object in &model.objects {
            let id = hash_of(&object.id);
            if !self.taken.insert(id) {
                self.repeated.insert(id);
            }
        }
    }

    pub(super) fn has_repeats(&self) -> bool {
        !self.repeated.is_empty()
    }

    /// Looks at feature `number` of an input, if its id is one of those; there the names of gable's attributes begin with
    /// `prefix`.
    pub(super) fn compare(&mut self, feature: &Feature, prefix: &str, input: usize, number: usize) {
        if self.repeated.contains(&hash_of(&feature.id)) {
            let candidates = self.candidates.entry(feature.id.clone()).or_default();
            candidates.push(Candidate::of(feature, prefix, input, number));
        }
    }

    /// Decides which of them are written.
    pub(super) fn decide(self) -> Ids {
        let mut ids = Ids { taken: self.taken, repeated: self.repeated, ..Ids::default() };
        for (id, candidates) in self.candidates {
            // The best of each building so far.
            let mut buildings: Vec<Candidate> = Vec::new();
            for candidate in candidates {
                let Some(best) = buildings.iter_mut().find(|best| best.is_same_building(&candidate)) else {
                    buildings.push(candidate);
                    continue;
                };
                let is_same = best.geometry == candidate.geometry;
                let loser = if candidate.compare(best) == Ordering::Greater {
                    std::mem::replace(best, candidate)
                } else {
                    candidate
                };
                ids.dropped.insert((loser.input, loser.number));
                ids.repeats.push((id.clone(), loser.input, best.input, is_same));
            }
        }
        ids
    }
}

/// Which features are written, and under which ids.
#[derive(Debug, Default)]
pub(super) struct Ids {
    taken: HashSet<u64>,
    repeated: HashSet<u64>,
    /// Those of `repeated` that are written.
    written: HashSet<u64>,
    dropped: HashSet<(usize, usize)>,
    /// Id, input that is left out, input that is kept, whether both are the same.
    repeats: Vec<(String, usize, usize, bool)>,
    renamed: Vec<(String, String, usize)>,
    count: usize,
}

impl Ids {
    /// Whether feature `number` of an input is written. Its ids are made unique.
    pub(super) fn admit(&mut self, feature: &mut Feature, input: usize, number: usize) -> bool {
        if self.dropped.contains(&(input, number)) {
            return false;
        }
        let mut names: HashMap<String, String> = HashMap::new();
        for object in &feature.objects {
            let id = hash_of(&object.id);
            if self.repeated.contains(&id) && !self.written.insert(id) {
                let name = self.free(&object.id);
                names.insert(object.id.clone(), name);
            }
        }
        for object in &mut feature.objects {
            let links = object.parents.iter_mut().chain(&mut object.children);
            for id in links.chain([&mut object.id]) {
                if let Some(name) = names.get(id) {
                    id.clone_from(name);
                }
            }
        }
        if let Some(name) = names.get(&feature.id) {
            feature.id.clone_from(name);
        }
        self.count += names.len();
        let room = EXAMPLES.saturating_sub(self.renamed.len());
        let mut names: Vec<_> = names.into_iter().map(|(old, new)| (old, new, input)).collect();
        names.sort_unstable();
        self.renamed.extend(names.into_iter().take(room));
        true
    }

    /// A free id like this one.
    fn free(&mut self, id: &str) -> String {
        let mut n = 2;
        loop {
            let name = format!("{id}-{n}");
            if self.taken.insert(hash_of(&name)) {
                return name;
            }
            n += 1;
        }
    }

    /// What was left out, and what there is to say of it.
    pub(super) fn close(self, paths: &[PathBuf]) -> (Vec<Repeat>, Vec<String>) {
        let path = |input: usize| paths.get(input).cloned().unwrap_or_default();
        let repeats: Vec<Repeat> = self
            .repeats
            .into_iter()
            .map(|(id, loser, winner, is_same)| Repeat { id, left_out: path(loser), kept: path(winner), is_same })
            .collect();
        let mut messages = Vec::new();
        let same = repeats.iter().filter(|repeat| repeat.is_same).count();
        if same > 0 {
            messages.push(format!("{same} features occur again with the same geometry and are kept once"));
        }
        let different: Vec<&Repeat> = repeats.iter().filter(|repeat| !repeat.is_same).collect();
        if !different.is_empty() {
            let example = |repeat: &&Repeat| {
                format!("{} ({} before {})", repeat.id, repeat.kept.display(), repeat.left_out.display())
            };
            messages.push(format!(
                "{} features occur again with another geometry; the better one is kept (higher level of detail, then larger \
                 gable_coverage, then more gable_points, then the first): {}{}",
                different.len(),
                different.iter().take(EXAMPLES).map(example).collect::<Vec<_>>().join(", "),
                if different.len() > EXAMPLES { ", …" } else { "" }
            ));
        }
        if self.count > 0 {
            let example =
                |(old, new, input): &(String, String, usize)| format!("{old} of {} is {new}", path(*input).display());
            messages.push(format!(
                "{} ids belong to different objects, and the later ones are renamed: {}{}",
                self.count,
                self.renamed.iter().map(example).collect::<Vec<_>>().join(", "),
                if self.count > self.renamed.len() { ", …" } else { "" }
            ));
        }
        (repeats, messages)
    }
}
