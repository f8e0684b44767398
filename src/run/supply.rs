//! What a run works on: sites as they get ready while tiles are read, or all of them at once.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::time::Duration;

use super::buildings::Task;
use super::flow::{Ready, Source};
use super::roster::Roster;
use super::{edited, single};
use crate::edits::Edits;
use crate::error::Result;
use crate::guard::lock;
use crate::report::{Scope, Stopwatch};
use crate::segment::{Part, Sweep, Swept};
use crate::site::Site;

/// What a run works on.
pub(super) enum Supply<'a> {
    /// Sites that get ready while tiles are read.
    Sweeping(Box<Sweeping<'a>>),
    /// Tasks that are all there.
    Collected(Collected),
}

/// Sites that get ready while tiles are read.
pub(super) struct Sweeping<'a> {
    pub(super) sweep: Sweep<'a>,
    pub(super) roster: &'a Roster,
    /// Whether the footprints stand in for those that there are not.
    pub(super) has_stand_ins: bool,
    /// What a person has decided about buildings.
    pub(super) edits: &'a Edits,
    /// Is told the number of points that were read since it was last told.
    pub(super) progress: Box<dyn Fn(u64) + Sync + 'a>,
    /// Is called when the last tile has been taken, with the processor time that reading them took.
    pub(super) all_read: Box<dyn Fn(Option<Duration>) + Sync + 'a>,
    /// Footprints that the tiles do not wholly cover.
    pub(super) incomplete: AtomicUsize,
    /// Processor time of reading and of making sites, nanoseconds.
    pub(super) cpu: AtomicU64,
}

/// Tasks that are all there, in the order of the model.
pub(super) struct Collected(Mutex<Vec<Option<Task>>>);

impl Supply<'_> {
    /// Tasks that are all there, in the order of the model.
    pub(super) fn collected(tasks: Vec<Task>) -> Self {
        Self::Collected(Collected(Mutex::new(tasks.into_iter().map(Some).collect())))
    }

    /// What was told of the points, and how many footprints the tiles do not wholly cover; nothing of tasks that were there.
    ///
    /// # Errors
    /// The building classes do not occur.
    pub(super) fn finish(self) -> Result<Option<(Swept, usize)>> {
        match self {
            Self::Sweeping(sweeping) => {
                let incomplete = sweeping.incomplete.into_inner();
                sweeping.sweep.finish().map(|swept| Some((swept, incomplete)))
            }
            Self::Collected(_) => Ok(None),
        }
    }
}

impl Sweeping<'_> {
    /// Does something and adds the processor time that it took.
    fn timed<T>(&self, work: impl FnOnce() -> T) -> T {
        let watch = Stopwatch::start(Scope::Thread);
        let done = work();
        let cpu = watch.cpu().map_or(0, |cpu| u64::try_from(cpu.as_nanos()).unwrap_or(u64::MAX));
        self.cpu.fetch_add(cpu, Ordering::Relaxed);
        done
    }

    fn ready(&self, footprints: Vec<(usize, usize)>) -> Vec<Ready> {
        footprints.into_iter().map(|(index, size)| Ready { place: self.roster.place(index), size }).collect()
    }
}

impl Source for Supply<'_> {
    type Part = Option<Part>;
    type Item = Task;

    fn parts(&self) -> usize {
        match self {
            Self::Sweeping(sweeping) => sweeping.sweep.tiles(),
            Self::Collected(_) => 1,
        }
    }

    fn read(&self, part: usize) -> Result<Self::Part> {
        match self {
            Self::Sweeping(sweeping) => sweeping.timed(|| sweeping.sweep.read(part, &sweeping.progress).map(Some)),
            Self::Collected(_) => Ok(None),
        }
    }

    fn take(&self, part: usize, read: Self::Part) -> Result<Vec<Ready>> {
        match (self, read) {
            (Self::Sweeping(sweeping), Some(read)) => {
                let mut ready = sweeping.ready(sweeping.timed(|| sweeping.sweep.take(part, read))?);
                if part == 0 {
                    ready.extend(sweeping.roster.places_of_rejected().map(|place| Ready { place, size: 0 }));
                }
                if part + 1 == sweeping.sweep.tiles() {
                    let cpu = Duration::from_nanos(sweeping.cpu.load(Ordering::Relaxed));
                    (sweeping.all_read)((cpu > Duration::ZERO).then_some(cpu));
                }
                Ok(ready)
            }
            (Self::Collected(Collected(tasks)), _) => {
                let tasks = lock(tasks);
                let size = |task: &Option<Task>| task.as_ref().map_or(0, Task::size);
                Ok(tasks.iter().enumerate().map(|(place, task)| Ready { place, size: size(task) }).collect())
            }
            _ => Ok(Vec::new()),
        }
    }

    fn rest(&self) -> Vec<Ready> {
        match self {
            Self::Sweeping(sweeping) => sweeping.ready(sweeping.sweep.rest()),
            Self::Collected(_) => Vec::new(),
        }
    }

    fn item(&self, place: usize) -> Result<Option<Task>> {
        let sweeping = match self {
            Self::Sweeping(sweeping) => sweeping,
            Self::Collected(Collected(tasks)) => {
                let mut tasks = lock(tasks);
                return Ok(tasks.get_mut(place).and_then(Option::take));
            }
        };
        let Some(index) = sweeping.roster.footprint(place) else {
            return Ok(sweeping.roster.rejected(place).cloned().map(|building| Task::Keep(Box::new(building))));
        };
        let Some((site, notes)) = sweeping.timed(|| sweeping.sweep.site(index))? else { return Ok(None) };
        // What is beside those that are wanted counts, and is not written.
        if place >= sweeping.roster.len() {
            return Ok(None);
        }
        let mut site: Site = if sweeping.has_stand_ins {
            single::without_footprint(site)
        } else {
            sweeping.incomplete.fetch_add(usize::from(!site.coverage.is_complete()), Ordering::Relaxed);
            site
        };
        edited::give(sweeping.edits, &mut site);
        Ok(Some(Task::Reconstruct { site: Box::new(site), notes }))
    }
}
