//! The parts of all jobs, each building findable by its place in the model; and what is wrong with them.
//!
//! Of a building no more is held than where it stands: 24 bytes.

use std::collections::{BTreeMap, VecDeque};
use std::fs::{self, File};
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use super::file::JobPlan;
use super::folder::PlanFolder;
use super::part::{self, Glance};
use crate::building::Building;
use crate::error::{Error, InputError, Result};
use crate::run::records::{Record, content};

/// Parts that are open at the same time, at most.
const OPEN: usize = 128;
/// So many ids or jobs are named in a message.
const NAMED: usize = 20;

/// Where a building stands.
#[derive(Debug, Clone, Copy)]
struct Place {
    part: u32,
    length: u32,
    at: u64,
}

/// The place of a building that has not been found.
const NOWHERE: Place = Place { part: u32::MAX, length: 0, at: 0 };

/// The parts of all jobs.
pub(super) struct Shelf {
    /// The files, by the numbers of their jobs.
    parts: Vec<PathBuf>,
    places: Vec<Place>,
    /// Those that are open, the last one used first.
    open: VecDeque<(u32, File)>,
}

/// The numbers of the jobs whose parts are not in `folders` (without any, the plan's own), ascending.
///
/// # Errors
/// A folder or a part cannot be read.
pub fn missing(plan: &JobPlan, folder: &PlanFolder, folders: &[PathBuf]) -> Result<Vec<usize>> {
    Ok(Found::look(plan, folder, folders)?.missing(plan))
}

/// The parts that are there.
struct Found {
    /// Of each job, its parts.
    parts: BTreeMap<usize, Vec<PathBuf>>,
    /// Those that are of no job of this plan or damaged, and why.
    faulty: Vec<(PathBuf, String)>,
}

impl Found {
    fn look(plan: &JobPlan, folder: &PlanFolder, folders: &[PathBuf]) -> Result<Self> {
        let own = [folder.parts()];
        let folders = if folders.is_empty() { &own } else { folders };
        let mut found = Self { parts: BTreeMap::new(), faulty: Vec::new() };
        for folder in folders {
            let entries = match fs::read_dir(folder) {
                Ok(entries) => entries,
                // Before the first job there is none.
                Err(e) if e.kind() == std::io::ErrorKind::NotFound && folders.len() == 1 => continue,
                Err(e) => return Err(Error::io(folder, "list", e)),
            };
            let mut jobs = Vec::new();
            for entry in entries {
                let name = entry.map_err(|e| Error::io(folder, "list", e))?.file_name();
                jobs.extend(part::job_of(&name.to_string_lossy()));
            }
            jobs.sort_unstable();
            for job in jobs {
                let path = part::path_of(folder, job);
                match part::head(&path).map_err(|e| Error::io(&path, "read", e))? {
                    Some(head) if head.plan != plan.identity => {
                        found.faulty.push((path, "it is of another plan".to_owned()));
                    }
                    Some(head) if head.job == job && job < plan.jobs.len() => {
                        found.parts.entry(job).or_default().push(path);
                    }
                    Some(head) => found.faulty.push((path, format!("it is of job {}", head.job))),
                    None => found.faulty.push((path, "it is damaged or cut off".to_owned())),
                }
            }
        }
        Ok(found)
    }

    fn missing(&self, plan: &JobPlan) -> Vec<usize> {
        (0..plan.jobs.len()).filter(|job| !self.parts.contains_key(job)).collect()
    }
}

impl Shelf {
    /// Looks through the parts in `folders` (without any, in the plan's own); `each` is told the place of every building, its
    /// id, and the origin of its frame.
    ///
    /// # Errors
    /// A job has no part or several, a part is damaged or of another plan, or a footprint is missing or there twice: all of
    /// them are listed.
    pub(super) fn open(
        plan: &JobPlan,
        folder: &PlanFolder,
        folders: &[PathBuf],
        mut each: impl FnMut(usize, &str, [f64; 3]),
        mut advanced: impl FnMut() -> Result<()>,
    ) -> Result<Self> {
        let found = Found::look(plan, folder, folders)?;
        let mut faults: Vec<String> = Vec::new();
        let missing = found.missing(plan);
        if !missing.is_empty() {
            let (n, all) = (missing.len(), plan.jobs.len());
            faults.push(format!("{n} of {all} jobs have no part: {}", ranges(&missing)));
        }
        faults.extend(found.faulty.iter().map(|(path, why)| format!("{}: {why}", path.display())));
        let doubled = found.parts.iter().filter(|(_, paths)| paths.len() > 1);
        faults.extend(doubled.map(|(job, paths)| {
            let paths: Vec<String> = paths.iter().map(|path| path.display().to_string()).collect();
            format!("job {job} has {} parts: {}", paths.len(), paths.join(", "))
        }));
        let mut shelf = Self { parts: Vec::new(), places: vec![NOWHERE; plan.footprints], open: VecDeque::new() };
        let mut twice: Vec<String> = Vec::new();
        for (job, paths) in &found.parts {
            let Some(path) = paths.first() else { continue };
            shelf.parts.resize(job + 1, PathBuf::new());
            shelf.parts[*job].clone_from(path);
            let places = &mut shelf.places;
            let mut foreign = 0_usize;
            let looked = part::look_through(path, |glance: Glance, at, length| {
                let Glance { index, building } = glance;
                match places.get_mut(index) {
                    Some(place) if place.part == NOWHERE.part => {
                        *place = Place { part: *job as u32, length: length as u32, at };
                        each(index, &building.id, building.frame.origin);
                    }
                    Some(_) => twice.push(building.id),
                    None => foreign += 1,
                }
            });
            let fault = looked.map_err(|e| Error::io(path, "read", e))?;
            faults.extend(fault.map(|why| format!("{}: {why}", path.display())));
            if foreign > 0 {
                faults.push(format!("{}: {foreign} buildings that are not in the plan", path.display()));
            }
            advanced()?;
        }
        if !twice.is_empty() {
            faults.push(format!("{} footprints are there twice: {}", twice.len(), named(&twice)));
        }
        let lost = shelf.lost(plan, folder, &found)?;
        if !lost.is_empty() {
            faults.push(format!("{} footprints are in no part: {}", lost.len(), named(&lost)));
        }
        if faults.is_empty() { Ok(shelf) } else { Err(refusal(folder, &faults, &missing)) }
    }

    /// The ids of footprints that should be in the parts that are there, and are not.
    fn lost(&self, plan: &JobPlan, folder: &PlanFolder, found: &Found) -> Result<Vec<String>> {
        let mut lost = Vec::new();
        let held = self.places.iter().filter(|place| place.part != NOWHERE.part).count();
        let expected: usize = found.parts.keys().filter_map(|&job| plan.jobs.get(job)).map(|job| job.footprints).sum();
        if held == expected {
            return Ok(lost);
        }
        for &job in found.parts.keys() {
            let share = folder.read_share(plan, job)?;
            let both = share.places.iter().zip(share.ids());
            let is_lost = |place: &usize| self.places.get(*place).is_none_or(|place| place.part == NOWHERE.part);
            lost.extend(both.filter(|(place, _)| is_lost(place)).map(|(_, id)| id.to_owned()));
        }
        Ok(lost)
    }

    /// The building at a place of the model.
    ///
    /// # Errors
    /// Its part can no longer be read.
    pub(super) fn read(&mut self, index: usize) -> Result<Record<Building>> {
        let place = self.places.get(index).copied().unwrap_or(NOWHERE);
        let path = self.parts.get(place.part as usize).cloned().unwrap_or_default();
        let fault = |e: std::io::Error| Error::io(&path, "read", e);
        let file = self.opened(place.part, &path).map_err(fault)?;
        let mut bytes = vec![0; place.length as usize];
        file.seek(SeekFrom::Start(place.at)).and_then(|_| file.read_exact(&mut bytes)).map_err(fault)?;
        let record: Option<Record<Building>> = content(&bytes).and_then(|json| serde_json::from_slice(json).ok());
        record.filter(|record| record.index == index).ok_or_else(|| {
            let fault = InputError::new(&path, "bytes that are no building", "what stood there a moment ago");
            fault.at(format!("byte {}", place.at)).remedy("Do the job again with --overwrite").into()
        })
    }

    /// The reports of the jobs, by their numbers.
    pub(super) fn reports(&self) -> impl Iterator<Item = (usize, PathBuf)> {
        let folders = self.parts.iter().map(|part| part.parent().map(Path::to_path_buf).unwrap_or_default());
        folders.enumerate().map(|(job, folder)| (job, part::report_of(&folder, job)))
    }

    fn opened(&mut self, part: u32, path: &Path) -> std::io::Result<&mut File> {
        let known = self.open.iter().position(|(open, _)| *open == part);
        let entry = match known.and_then(|at| self.open.remove(at)) {
            Some(entry) => entry,
            None => (part, File::open(path)?),
        };
        self.open.truncate(OPEN - 1);
        self.open.push_front(entry);
        Ok(&mut self.open[0].1)
    }
}

/// Numbers as text: `0-3,7`, as `sbatch --array` takes them.
pub fn ranges(numbers: &[usize]) -> String {
    let runs = numbers.chunk_by(|a, b| a + 1 == *b).filter_map(|run| Some((*run.first()?, *run.last()?)));
    let texts = runs.map(|(first, last)| if first == last { first.to_string() } else { format!("{first}-{last}") });
    texts.collect::<Vec<_>>().join(",")
}

fn named(ids: &[String]) -> String {
    let more = ids.len().saturating_sub(NAMED);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    format!("{}{more}", ids.iter().take(NAMED).cloned().collect::<Vec<_>>().join(", "))
}

fn refusal(folder: &PlanFolder, faults: &[String], missing: &[usize]) -> Error {
    let plan = folder.path();
    let again = match missing {
        [] => "Do these jobs again with --overwrite, or take out what does not belong there".to_owned(),
        [first, ..] => format!("Do the missing jobs: gable reconstruct --plan {} --job {first}", plan.display()),
    };
    InputError::new(plan, faults.join("; "), "each footprint in the part of one job").remedy(again).into()
}

#[cfg(test)]
mod tests {
    use super::ranges;

    #[test]
    fn numbers_are_told_as_ranges() {
        assert_eq!(ranges(&[0, 1, 2, 3, 7, 9, 10]), "0-3,7,9-10");
        assert_eq!(ranges(&[]), "");
    }
}
