//! All buildings of a model while a person works on them: what the page asks for, and what it asks to be done.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, TryLockError};

use serde::Serialize;

use super::around::Around;
use super::book::{Book, Unwritten};
use super::drawn::{Scanned, extent};
use super::need::Condition;
use super::payload::{payload, refused};
use super::roll::{Roll, Row, conditions};
use super::sessions::{Sessions, Slot};
use super::{Figures, Session};
use crate::edits::{Action, Edit, Edited, Edits, State, some};
use crate::error::{Error, Result};
use crate::guard::lock;
use crate::reconstruct::occupancy::Occupancy;
use crate::report::{Report, now};
use crate::run::{Collected, Job, Observer, Silent, collected, edits_crs, run};
use crate::site::Site;

/// All buildings of a model while a person works on them.
pub struct Desk {
    /// How the model is made.
    job: Job,
    author: Option<String>,
    /// Where the model goes with what was accepted.
    export: PathBuf,
    name: String,
    crs: String,
    metres_per_unit: [f64; 3],
    /// What is known of each building, with the notes on it.
    buildings: Vec<(Site, Vec<String>)>,
    /// Where each of them is, by its id.
    index: HashMap<String, usize>,
    around: Around,
    field: Arc<dyn Occupancy>,
    /// What the model says of each building.
    conditions: HashMap<String, Condition>,
    /// What is to be known of all of it.
    notes: Vec<String>,
    book: Mutex<Book>,
    /// What the last solve says of each building that was opened.
    latest: Mutex<HashMap<String, Condition>>,
    sessions: Mutex<Sessions>,
    /// The last revision that was given out.
    revision: AtomicU64,
    exporting: Mutex<()>,
}

/// What a desk is opened with.
#[derive(Debug, Clone)]
pub struct Opening {
    /// The model that is to be mended, CityJSON of gable's.
    pub model: PathBuf,
    /// The file of edits, which need not exist.
    pub edits: PathBuf,
    /// Who edits.
    pub author: Option<String>,
    /// Where the model goes with what was accepted.
    pub export: PathBuf,
}

/// Why something that was asked for is not done.
#[derive(Debug)]
pub enum Refusal {
    /// There is no such building.
    Unknown(String),
    /// The building has changed since: this is its revision.
    Stale(u64),
    /// The method breaks on it; nothing has changed.
    Broken(String),
    /// An export is under way.
    Busy,
    /// The system refuses, or a file is not what it was.
    Failed(String),
}

/// What came of an export.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Exported {
    /// The model.
    pub path: String,
    /// How many buildings it has.
    pub buildings: usize,
    /// What the run warned of.
    pub warnings: Vec<String>,
}

impl Desk {
    /// Reads the model, the tiles and footprints of the job that made it, and the file of edits.
    ///
    /// # Errors
    /// One of them cannot be read; as [`collected`].
    pub fn open(job: Job, opening: Opening, observer: &dyn Observer) -> Result<Self> {
        let Opening { model, edits, author, export } = opening;
        let conditions = conditions(&model)?;
        let field = job.field.load()?;
        let job = Job { edits: None, ..job };
        let scanned = Job { terrain: None, ..job.clone() };
        let Collected { buildings, rejected, tiles, crs } = collected(&scanned, observer)?;
        let book = Book::open(&edits, &crs)?;
        let metres_per_unit = crs.metres_per_unit;
        let boxes: Vec<[[f64; 2]; 2]> = buildings.iter().filter_map(|(site, _)| extent(site)).collect();
        let around = Around::read(&tiles, &boxes, metres_per_unit)?;
        let index: HashMap<String, usize> = buildings.iter().map(|(site, _)| site.id.clone()).zip(0..).collect();
        let is_known = |id: &str| index.contains_key(id) || rejected.iter().any(|own| own == id);
        let mut notes = Vec::new();
        let mut note = |mut ids: Vec<String>, what: &str| {
            ids.sort();
            if !ids.is_empty() {
                notes.push(format!("{} building(s) {what}: {}", ids.len(), some(&ids)));
            }
        };
        note(conditions.keys().filter(|id| !is_known(id)).cloned().collect(), "of the model have no footprint here");
        note(index.keys().filter(|id| !conditions.contains_key(*id)).cloned().collect(), "are not in the model");
        note(rejected.clone(), "have a footprint that is no polygon, and cannot be edited");
        note(book.ids().filter(|id| !is_known(id)).map(str::to_owned).collect(), "with edits have no footprint here");
        let name = model.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        Ok(Self {
            job,
            author,
            export,
            name,
            crs: edits_crs(&crs),
            metres_per_unit,
            buildings,
            index,
            around,
            field,
            conditions,
            notes,
            book: Mutex::new(book),
            latest: Mutex::default(),
            sessions: Mutex::default(),
            revision: AtomicU64::new(0),
            exporting: Mutex::default(),
        })
    }

    /// The file of the model.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What is to be known of all of it: buildings that are in one of its inputs only.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// How many buildings there are, and how many of them need a person.
    pub fn counts(&self) -> (usize, usize) {
        let rows = self.rows();
        (rows.len(), rows.iter().filter(|row| row.urgency > 0.0).count())
    }

    /// The list of buildings as JSON, the most urgent first.
    ///
    /// # Errors
    /// Never in practice.
    pub fn list(&self) -> Result<String, Refusal> {
        // On its own: the rows ask the book as well.
        let edits_file = whole(lock(&self.book).path());
        json(&Roll {
            name: &self.name,
            gable: env!("CARGO_PKG_VERSION"),
            crs: &self.crs,
            units: self.metres_per_unit.into(),
            author: self.author.as_deref(),
            edits_file,
            export_file: whole(&self.export),
            notes: &self.notes,
            buildings: self.rows().into(),
        })
    }

    /// A building as the page is given it.
    ///
    /// # Errors
    /// There is no such building, or the method breaks on it.
    pub fn building(&self, id: &str) -> Result<String, Refusal> {
        self.with_open(id, |slot| self.told(slot))
    }

    /// Does an edit of a building whose revision is known.
    ///
    /// # Errors
    /// As [`Self::building`]; the revision is another, or the file of edits cannot be written.
    pub fn edit(&self, id: &str, revision: u64, action: Action) -> Result<String, Refusal> {
        let edit = Edit { action, time: Some(now()), author: self.author.clone() };
        self.change(id, revision, |session| session.edit(edit).map(|_| true))
    }

    /// Undoes the last edit of a building.
    ///
    /// # Errors
    /// As [`Self::edit`].
    pub fn undo(&self, id: &str, revision: u64) -> Result<String, Refusal> {
        self.change(id, revision, Session::undo)
    }

    /// Does the edit of a building again that was undone last.
    ///
    /// # Errors
    /// As [`Self::edit`].
    pub fn redo(&self, id: &str, revision: u64) -> Result<String, Refusal> {
        self.change(id, revision, Session::redo)
    }

    /// Undoes all edits of a building.
    ///
    /// # Errors
    /// As [`Self::edit`].
    pub fn clear(&self, id: &str, revision: u64) -> Result<String, Refusal> {
        self.change(id, revision, Session::clear)
    }

    /// Says how far a person has come with a building. The answer is its row of the list, as JSON.
    ///
    /// # Errors
    /// There is no such building, or the file of edits cannot be written.
    pub fn decide(&self, id: &str, state: State) -> Result<String, Refusal> {
        #[derive(Serialize)]
        struct Answer {
            row: Row,
        }
        let (site, _) = self.known(id)?;
        // An edit under way is done first: the decision is about what came of it.
        let slot = lock(&self.sessions).of(id);
        let mut slot = lock(&slot);
        let written = {
            let mut book = lock(&self.book);
            let edited = Edited { state, ..book.of(id) };
            book.decide(id, edited)
        };
        self.check(written, &mut slot)?;
        json(&Answer { row: self.row(site) })
    }

    /// The file of edits, as it is on disk; one without any where nothing is decided.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn edits(&self) -> Result<Vec<u8>, Refusal> {
        let path = lock(&self.book).path().to_path_buf();
        match std::fs::read(&path) {
            Ok(bytes) => Ok(bytes),
            Err(fault) if fault.kind() == std::io::ErrorKind::NotFound => {
                json(&Edits { crs: Some(self.crs.clone()), ..Edits::default() }).map(String::into_bytes)
            }
            Err(fault) => Err(Refusal::Failed(Error::io(path, "read", fault).to_string())),
        }
    }

    /// Writes the model with what was accepted: the run that made it, with the edits.
    ///
    /// # Errors
    /// One is under way, or as [`run`].
    pub fn export(&self) -> Result<Exported, Refusal> {
        let _alone = match self.exporting.try_lock() {
            Ok(alone) => alone,
            Err(TryLockError::Poisoned(alone)) => alone.into_inner(),
            Err(TryLockError::WouldBlock) => return Err(Refusal::Busy),
        };
        let edits = lock(&self.book).path().to_path_buf();
        let job = Job { overwrite: true, ..export_job(self.job.clone(), &edits, &self.export) };
        let report = run(&job, &Silent).map_err(|fault| Refusal::Failed(fault.to_string()))?;
        let path = report.outputs.first().map(|path| whole(Path::new(path))).unwrap_or_default();
        Ok(Exported { path, buildings: report.counts.written, warnings: report.warnings })
    }

    fn rows(&self) -> Vec<Row> {
        self.buildings.iter().map(|(site, _)| self.row(site)).collect()
    }

    fn row(&self, site: &Site) -> Row {
        let state = lock(&self.book).state(&site.id);
        let latest = lock(&self.latest);
        Row::new(site, state, latest.get(&site.id).or_else(|| self.conditions.get(&site.id)))
    }

    fn known(&self, id: &str) -> Result<&(Site, Vec<String>), Refusal> {
        let found = self.index.get(id).and_then(|at| self.buildings.get(*at));
        found.ok_or_else(|| Refusal::Unknown(format!("there is no building {id:?}")))
    }

    fn next_revision(&self) -> u64 {
        self.revision.fetch_add(1, Ordering::Relaxed) + 1
    }

    /// Does something with an open session; nobody else does with that of the same building meanwhile.
    fn with_open<T>(&self, id: &str, act: impl FnOnce(&mut Slot) -> Result<T, Refusal>) -> Result<T, Refusal> {
        let (site, notes) = self.known(id)?;
        let slot = lock(&self.sessions).of(id);
        let mut slot = lock(&slot);
        if slot.open.is_none() {
            let edits = lock(&self.book).of(id).edits;
            let undone = std::mem::take(&mut slot.undone);
            let parameters = self.job.parameters.clone();
            let session = Session::open(site.clone(), notes.clone(), parameters, self.field.clone(), edits, undone)
                .map_err(Refusal::Broken)?;
            self.note(&session);
            slot.open = Some((session, Scanned::new(site, &self.around)));
            if slot.revision == 0 {
                slot.revision = self.next_revision();
            }
        }
        act(&mut slot)
    }

    /// Changes a building, writes that down, and gives it as it is then. Where nothing has changed, nothing is written.
    fn change(
        &self,
        id: &str,
        revision: u64,
        act: impl FnOnce(&mut Session) -> Result<bool, String>,
    ) -> Result<String, Refusal> {
        self.with_open(id, |slot| {
            if slot.revision != revision {
                return Err(Refusal::Stale(slot.revision));
            }
            let Some((session, _)) = &mut slot.open else { return Err(Refusal::Stale(slot.revision)) };
            if act(session).map_err(Refusal::Broken)? {
                let edits = session.edits().to_vec();
                let state = if edits.is_empty() { State::Open } else { State::Edited };
                let written = lock(&self.book).decide(id, Edited { state, edits });
                self.note(session);
                self.check(written, slot)?;
                slot.revision = self.next_revision();
            }
            self.told(slot)
        })
    }

    /// Closes a session whose change was not written down: what stands in the file is what holds.
    fn check(&self, written: Result<(), Unwritten>, slot: &mut Slot) -> Result<(), Refusal> {
        let Err(why) = written else { return Ok(()) };
        slot.open = None;
        slot.revision = self.next_revision();
        Err(match why {
            Unwritten::Overtaken => Refusal::Stale(slot.revision),
            Unwritten::Failed(fault) => Refusal::Failed(fault.to_string()),
        })
    }

    /// Notes what the last solve says, for the list.
    fn note(&self, session: &Session) {
        let building = &session.now().building;
        let reason = building.outcome.reason().map(|(reason, _)| reason);
        let condition = Condition::of_figures(&Figures::of(building), reason, refused(building));
        lock(&self.latest).insert(session.site().id.clone(), condition);
    }

    fn told(&self, slot: &Slot) -> Result<String, Refusal> {
        let Some((session, scanned)) = &slot.open else { return Err(Refusal::Stale(slot.revision)) };
        let row = self.row(session.site());
        payload(session, scanned, (slot.revision, &row, &self.crs)).map_err(|e| Refusal::Failed(e.to_string()))
    }
}

/// A path for a person, from the root.
fn whole(path: &Path) -> String {
    std::path::absolute(path).as_deref().unwrap_or(path).display().to_string()
}

fn json(value: &impl Serialize) -> Result<String, Refusal> {
    serde_json::to_string(value).map_err(|fault| Refusal::Failed(fault.to_string()))
}

/// The job that writes a model with what was accepted of the edits in a file, if there is one.
fn export_job(job: Job, edits: &Path, output: &Path) -> Job {
    Job { edits: edits.exists().then(|| edits.to_path_buf()), output: output.to_path_buf(), report: None, ..job }
}

/// Writes the model with what was accepted of the edits in a file, without a desk.
///
/// # Errors
/// As [`run`].
pub fn export(job: Job, edits: &Path, output: &Path, observer: &dyn Observer) -> Result<Report> {
    run(&export_job(job, edits, output), observer)
}
