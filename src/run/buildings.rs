//! From sites to buildings: in parallel, each on its own, in the order of the footprints.

use std::time::Duration;

use rayon::ThreadPool;

use super::checkpoint::{Checkpoint, Record};
use super::observer::{Event, Observer, Stage};
use super::ordered::in_order;
use crate::building::{Building, Measures, Outcome, Reason};
use crate::error::{Error, Result};
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
    fn size(&self) -> usize {
        match self {
            Self::Reconstruct { site, .. } => site.points.len(),
            Self::Keep(_) => 0,
        }
    }
}

/// A building and what it cost.
struct Done {
    building: Building,
    wall: Duration,
    cpu: Option<Duration>,
    resumed: bool,
}

/// Reconstructs all tasks on the threads of `pool` with `reconstruct` and hands them to `write` in their order, on the
/// calling thread.
///
/// A building whose reconstruction panics is written as its footprint with [`Reason::Internal`] and the place of
/// the panic. When the observer interrupts, buildings under way are completed and written and the others are counted as
/// not reached. What `checkpoint` holds is taken from there, and what is made is kept there as soon as it is done.
/// `grid_steps` is [`Parameters::grid_steps`](crate::reconstruct::Parameters::grid_steps).
///
/// # Errors
/// What `write` says, or that the checkpoint cannot be written.
pub(super) fn reconstruct_all(
    tasks: Vec<Task>,
    pool: &ThreadPool,
    observer: &dyn Observer,
    checkpoint: Option<&Checkpoint>,
    grid_steps: i64,
    reconstruct: impl Fn(&Site) -> Building + Sync,
    mut write: impl FnMut(&Building) -> Result<()>,
) -> Result<(Counts, Vec<BuildingReport>)> {
    let mut counts = Counts { footprints: tasks.len(), ..Counts::default() };
    let mut reports = Vec::with_capacity(tasks.len());
    in_order(
        pool,
        tasks.into_iter().enumerate().collect(),
        // What is there already comes first: an interruption costs none of it.
        |(index, task)| if checkpoint.is_some_and(|c| c.has(*index)) { usize::MAX } else { task.size() },
        |(index, task)| {
            let done = match checkpoint {
                Some(checkpoint) => recalled(index, task, checkpoint, grid_steps, &reconstruct),
                None => Ok(one(task, grid_steps, &reconstruct)),
            };
            observer.event(Event::Advanced { stage: Stage::Reconstruct, by: 1 });
            done
        },
        || observer.interrupted(),
        |_, done| {
            let Some(done) = done else {
                counts.not_reached += 1;
                return Ok::<(), Error>(());
            };
            let Done { building, wall, cpu, resumed } = done?;
            write(&building)?;
            let report = BuildingReport { resumed, ..BuildingReport::new(&building, wall, cpu) };
            counts.add(&report);
            observer.event(Event::Building(&report));
            reports.push(report);
            Ok(())
        },
    )?;
    Ok((counts, reports))
}

/// Takes one building from the checkpoint, or makes it and keeps it there.
///
/// # Errors
/// The checkpoint cannot be written.
fn recalled(
    index: usize,
    task: Task,
    checkpoint: &Checkpoint,
    grid_steps: i64,
    reconstruct: &impl Fn(&Site) -> Building,
) -> Result<Done> {
    if let Some(Record { wall, cpu, building, .. }) = checkpoint.recall(index).filter(|r| r.building.id == task.id()) {
        return Ok(Done { building, wall, cpu, resumed: true });
    }
    // What needs no work needs no keeping.
    let is_made = task.site().is_some_and(|site| !site.points.is_empty());
    let done = one(task, grid_steps, reconstruct);
    if is_made {
        checkpoint.keep(&Record { index, wall: done.wall, cpu: done.cpu, building: &done.building })?;
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
    Done { building, wall: watch.wall(), cpu: watch.cpu(), resumed: false }
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

    /// A method that fails on building 3.
    fn method(site: &Site) -> Building {
        assert!(site.id != "3", "bad angle");
        Building { outcome: Outcome::Lod22, notes: vec!["own".into()], ..broken(site, 1, String::new()) }
    }

    #[test]
    fn buildings_are_written_in_order_and_a_panic_is_one_buildings_fate() {
        for threads in 1..=3 {
            let mut written = Vec::new();
            let write = |b: &Building| {
                written.push(b.clone());
                Ok(())
            };
            let (counts, reports) =
                reconstruct_all(tasks(20), &pool(threads), &Silent, None, 1, method, write).unwrap();
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
        let write = |b: &Building| {
            written.push(b.id.clone());
            Ok(())
        };
        let observer = Impatient(Mutex::new(0));
        let (counts, reports) = reconstruct_all(tasks(8), &pool(1), &observer, None, 1, method, write).unwrap();
        // The largest first: 7·i mod 11 is 10 for building 3 and 9 for building 6.
        assert_eq!(written, ["3", "6"]);
        assert_eq!((counts.footprints, counts.written, counts.not_reached, reports.len()), (8, 2, 6, 2));
    }

    #[test]
    fn a_feature_that_is_kept_passes_through() {
        let kept = broken(&site(9), 1, "a line".into());
        let mut written = Vec::new();
        let write = |b: &Building| {
            written.push((b.id.clone(), b.notes.clone()));
            Ok(())
        };
        reconstruct_all(vec![Task::Keep(Box::new(kept))], &pool(1), &Silent, None, 1, method, write).unwrap();
        assert_eq!(written, [("9".to_owned(), Vec::<String>::new())]);
    }
}
