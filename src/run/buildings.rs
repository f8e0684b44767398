//! From sites to buildings: in parallel, each on its own, in the order of the footprints.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::ThreadPool;

use super::flow::flow;
use super::identity::hash_of;
use super::observer::{Event, Observer, Stage};
use super::outbox::{Done, Outbox};
use super::records::{Record, Records};
use super::supply::Supply;
use crate::building::{Building, Measures, Outcome, Reason};
use crate::error::Result;
use crate::guard::guarded;
use crate::reconstruct::blocks;
use crate::report::{BuildingReport, Counts, Scope, Stopwatch};
use crate::site::Site;
use crate::solid::Model;

/// What is known of one feature of the footprint file before the method sees it.
#[derive(Debug)]
pub enum Task {
    /// A building to reconstruct.
    Reconstruct {
        /// What is known of it.
        site: Box<Site>,
        /// What the reader of the result should know: repairs, a made-up id, an incomplete tile.
        notes: Vec<String>,
    },
    /// A feature that is written as it is.
    Keep(Box<Building>),
}

impl Task {
    /// The id of the building.
    pub fn id(&self) -> &str {
        match self {
            Self::Reconstruct { site, .. } => &site.id,
            Self::Keep(building) => &building.id,
        }
    }

    /// What is known of it, if it is to be reconstructed.
    pub fn site(&self) -> Option<&Site> {
        match self {
            Self::Reconstruct { site, .. } => Some(site),
            Self::Keep(_) => None,
        }
    }

    /// How much work it is, for starting the largest first.
    pub(super) fn size(&self) -> usize {
        match self {
            Self::Reconstruct { site, .. } => site.points.len(),
            Self::Keep(_) => 0,
        }
    }
}

/// What is told of all buildings.
#[derive(Debug, Default)]
pub(super) struct Told {
    pub(super) counts: Counts,
    pub(super) buildings: Vec<BuildingReport>,
    /// Buildings that an earlier run had made from other points or footprints.
    pub(super) outdated: usize,
}

/// Reconstructs all `total` tasks of `supply` on the threads of `pool` with `reconstruct` and hands them to `write` in the order of the
/// model, on the calling thread, each with its place in it and what it cost.
///
/// A building whose reconstruction panics is written as its footprint with [`Reason::Internal`] and the place of
/// the panic. When the observer interrupts, buildings under way are completed and written and the others are counted as
/// not reached. What `records` hold of the same site is taken from there, and what is made is kept there: at once where
/// `is_safe` asks for that, else only what has to wait and is too much for memory.
/// `grid_steps` is [`Parameters::grid_steps`](crate::reconstruct::Parameters::grid_steps).
///
/// # Errors
/// What `write` says, that a tile can no longer be opened, or that records or a temporary file cannot be written.
pub(super) fn reconstruct_all(
    supply: &Supply<'_>,
    total: usize,
    pool: &ThreadPool,
    observer: &dyn Observer,
    (records, is_safe): (&Records, bool),
    (grid_steps, reconstruct): (i64, impl Fn(&Site) -> Building + Sync),
    mut write: impl FnMut(&Record<&Building>) -> Result<()>,
) -> Result<Told> {
    let counts = Counts { footprints: total, ..Counts::default() };
    let mut told = Told { counts, buildings: Vec::with_capacity(total), ..Told::default() };
    let outdated = AtomicUsize::new(0);
    let mut each = |place: usize, done: Done| {
        let Done { building, wall, cpu, resumed, inputs, .. } = done;
        write(&Record { index: place, inputs, wall, cpu, building: &building })?;
        let report = BuildingReport { resumed, ..BuildingReport::new(&building, wall, cpu) };
        told.counts.add(&report);
        observer.event(Event::Building(&report));
        told.buildings.push(report);
        Ok(())
    };
    let mut outbox = Outbox::new(records);
    flow(
        pool,
        supply,
        // What is there already comes first: an interruption costs none of it.
        |place| records.has(place),
        |place, task| {
            let done = if records.has(place) || is_safe {
                recalled(place, task, records, &outdated, is_safe, grid_steps, &reconstruct)
            } else {
                Ok(one(task, grid_steps, &reconstruct))
            };
            observer.event(Event::Advanced { stage: Stage::Reconstruct, by: 1 });
            done
        },
        || observer.interrupted(),
        |place, done| outbox.put(place, done?, &mut each),
    )?;
    outbox.finish(&mut each)?;
    told.counts.not_reached = total - told.counts.written;
    told.outdated = outdated.into_inner();
    Ok(told)
}

/// Takes one building from the records if it is that of the same site, or makes it and keeps it there.
///
/// # Errors
/// The records cannot be written.
fn recalled(
    place: usize,
    task: Task,
    records: &Records,
    outdated: &AtomicUsize,
    is_safe: bool,
    grid_steps: i64,
    reconstruct: &impl Fn(&Site) -> Building,
) -> Result<Done> {
    let inputs = hash_of(&task);
    if let Some(Record { wall, cpu, building, inputs: before, .. }) = records.recall(place) {
        if building.id == task.id() && before == inputs {
            return Ok(Done { building, wall, cpu, resumed: true, inputs, is_kept: true });
        }
        outdated.fetch_add(1, Ordering::Relaxed);
    }
    // What needs no work needs no keeping.
    let is_made = task.site().is_some_and(|site| !site.points.is_empty());
    let mut done = Done { inputs, ..one(task, grid_steps, reconstruct) };
    if is_made && is_safe {
        let (wall, cpu) = (done.wall, done.cpu);
        records.keep(&Record { index: place, inputs, wall, cpu, building: &done.building })?;
        done.is_kept = true;
    }
    Ok(done)
}

/// Does one task; the points of its site are freed on return.
fn one(task: Task, grid_steps: i64, reconstruct: &impl Fn(&Site) -> Building) -> Done {
    let watch = Stopwatch::start(Scope::Thread);
    let building = match task {
        Task::Keep(building) => *building,
        Task::Reconstruct { site, mut notes } => {
            let mut building =
                guarded(|| reconstruct(&site)).unwrap_or_else(|detail| broken(&site, grid_steps, detail));
            notes.append(&mut building.notes);
            building.notes = notes;
            building
        }
    };
    Done { building, wall: watch.wall(), cpu: watch.cpu(), resumed: false, inputs: 0, is_kept: false }
}

/// What is written of a site on which the method failed.
fn broken(site: &Site, grid_steps: i64, detail: String) -> Building {
    without_model(site, grid_steps, Outcome::FootprintOnly { reason: Reason::Internal, detail })
}

/// What is written of a site without a model of it.
pub(super) fn without_model(site: &Site, grid_steps: i64, outcome: Outcome) -> Building {
    let step = site.frame.step().map(|step| step * grid_steps as f64);
    // Whatever broke the method may lie in the footprint.
    let mut notes = Vec::new();
    let footprint = guarded(|| {
        site.footprint.as_ref().map(|footprint| blocks::footprint(footprint, step, &mut notes)).unwrap_or_default()
    })
    .unwrap_or_default();
    let mut model = Model { footprint, ground: (site.ground.height / step[2]).round() as i64, ..Model::default() };
    model.refine(grid_steps);
    let measures = Measures {
        ground: Some(site.ground),
        coverage: Some(site.coverage),
        points: site.points.len(),
        ..Measures::default()
    };
    Building {
        id: site.id.clone(),
        frame: site.frame,
        attributes: site.attributes.clone(),
        model,
        outcome,
        record: site.record.clone(),
        measures,
        notes,
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use nalgebra::Point3;

    use super::*;
    use crate::run::Silent;
    use crate::site::{Coverage, Frame, Ground, GroundSource};

    const FRAME: Frame = Frame { origin: [100.0, 200.0, 0.0], metres_per_unit: [1.0; 3] };

    fn site(id: usize) -> Site {
        let square = geo::wkt!(MULTIPOLYGON(((0. 0., 4. 0., 4. 3., 0. 3., 0. 0.)))).clone();
        Site {
            id: id.to_string(),
            frame: FRAME,
            footprint: Some(square),
            points: vec![Point3::new(1.0, 1.0, 5.0); 7 * id % 11],
            ground_points: Vec::new(),
            ground_line: Vec::new(),
            ground: Ground { height: 1.25, spread: 0.1, source: GroundSource::GroundPoints },
            coverage: Coverage { share: 1.0 },
            covered: None,
            eaves: None,
            attributes: serde_json::Map::new(),
            record: crate::record::Record::default(),
            edits: Vec::new(),
        }
    }

    fn pool(threads: usize) -> ThreadPool {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap()
    }

    fn tasks(n: usize) -> Vec<Task> {
        (0..n).map(|i| Task::Reconstruct { site: Box::new(site(i)), notes: vec![format!("note {i}")] }).collect()
    }

    fn made(
        tasks: Vec<Task>,
        pool: &ThreadPool,
        observer: &dyn Observer,
        method: impl Fn(&Site) -> Building + Sync,
        write: impl FnMut(&Record<&Building>) -> Result<()>,
    ) -> Told {
        let (total, records) = (tasks.len(), Records::nameless().unwrap());
        let supply = Supply::collected(tasks);
        reconstruct_all(&supply, total, pool, observer, (&records, false), (1, method), write).unwrap()
    }

    /// A method that fails on building 3.
    fn method(site: &Site) -> Building {
        assert!(site.id != "3", "bad angle");
        Building { outcome: Outcome::Lod22, notes: vec!["own".into()], ..broken(site, 1, String::new()) }
    }

    #[test]
    fn buildings_are_written_in_order_and_a_panic_is_one_buildings_fate() {
        for threads in 1..=3 {
            let mut written = Vec::new();
            let write = |record: &Record<&Building>| {
                written.push(record.building.clone());
                Ok(())
            };
            let Told { counts, buildings: reports, .. } = made(tasks(20), &pool(threads), &Silent, method, write);
            let ids: Vec<_> = written.iter().map(|b| b.id.clone()).collect();
            assert_eq!(ids, (0..20).map(|i| i.to_string()).collect::<Vec<_>>());
            assert_eq!((counts.footprints, counts.written, counts.buildings_lod22), (20, 20, 19));
            assert_eq!(counts.skipped, [(Reason::Internal, 1)].into());
            let Outcome::FootprintOnly { reason: Reason::Internal, detail } = &reports[3].outcome else {
                panic!("{:?}", reports[3].outcome)
            };
            assert!(detail.starts_with("bad angle at ") && detail.contains("buildings.rs"), "{detail}");
            assert_eq!(reports[3].points, 10);
            assert_eq!(reports[4].notes, ["note 4", "own"]);
            assert_eq!(written[3].model.ground, 12_500);
            assert_eq!(written[3].model.footprint[0][0].len(), 4);
        }
    }

    /// Interrupts after two buildings.
    struct Impatient(Mutex<usize>);

    impl Observer for Impatient {
        fn event(&self, event: Event<'_>) {
            if let Event::Advanced { by, .. } = event {
                *self.0.lock().unwrap() += by as usize;
            }
        }

        fn interrupted(&self) -> bool {
            *self.0.lock().unwrap() >= 2
        }
    }

    #[test]
    fn an_interruption_keeps_what_is_done() {
        let mut written = Vec::new();
        let write = |record: &Record<&Building>| {
            written.push(record.building.id.clone());
            Ok(())
        };
        let observer = Impatient(Mutex::new(0));
        let Told { counts, buildings: reports, .. } = made(tasks(8), &pool(1), &observer, method, write);
        // The largest first: 7·i mod 11 is 10 for building 3 and 9 for building 6.
        assert_eq!(written, ["3", "6"]);
        assert_eq!((counts.footprints, counts.written, counts.not_reached, reports.len()), (8, 2, 6, 2));
    }

    #[test]
    fn a_feature_that_is_kept_passes_through() {
        let kept = broken(&site(9), 1, "a line".into());
        let mut written = Vec::new();
        let write = |record: &Record<&Building>| {
            written.push((record.building.id.clone(), record.building.notes.clone()));
            Ok(())
        };
        made(vec![Task::Keep(Box::new(kept))], &pool(1), &Silent, method, write);
        assert_eq!(written, [("9".to_owned(), Vec::<String>::new())]);
    }
}
