//! Long work on a thread of its own, while the thread that asked for it listens to Python: signals are heeded, progress
//! and warnings are handed on, and between them the interpreter's lock is free.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, SyncSender};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use gable::error::{Error, Result};
use gable::run::{self, Event};
use gable::{pipeline, source};
use pyo3::prelude::*;

use crate::errors::{exception, internal};

/// How often progress is told at most, and signals are looked for at least.
const BEAT: Duration = Duration::from_millis(50);
/// News that wait for Python; more make the work wait, so that memory stays flat.
const WAITING: usize = 64;

/// Something to be told to Python.
enum Message {
    Progress(Progress),
    Warning(String),
}

/// How far the work is.
#[derive(Debug, Clone, Copy)]
struct Progress {
    stage: &'static str,
    unit: &'static str,
    done: u64,
    total: u64,
}

/// What leaves work that has no other way to be stopped: it unwinds, so that files under way are removed.
struct Stopped;

/// Tells Python how far the work is, and the work whether to stop.
pub struct Teller<'a> {
    sender: SyncSender<Message>,
    stop: &'a AtomicBool,
    at: Mutex<(Progress, Option<Instant>)>,
}

impl<'a> Teller<'a> {
    fn new(sender: SyncSender<Message>, stop: &'a AtomicBool) -> Self {
        let start = Progress { stage: "", unit: "", done: 0, total: 0 };
        Self { sender, stop, at: Mutex::new((start, None)) }
    }

    /// A stage begins, which has `total` units to do; 0 where nobody knows.
    pub fn start(&self, stage: &'static str, unit: &'static str, total: u64) {
        lock(&self.at).0 = Progress { stage, unit, done: 0, total };
        self.tell();
    }

    /// So many more units are done.
    pub fn advance(&self, by: u64) {
        let mut at = lock(&self.at);
        at.0.done += by;
        let is_due = at.1.is_none_or(|told| told.elapsed() >= BEAT);
        drop(at);
        if is_due {
            self.tell();
        }
    }

    /// Whether the stage that began last is this one.
    fn is_at(&self, label: &str) -> bool {
        lock(&self.at).0.stage == label
    }

    /// The stage is over.
    pub fn finish(&self) {
        self.tell();
    }

    /// Something that the user should know and that stops nothing.
    pub fn warn(&self, text: &str) {
        let _ = self.sender.send(Message::Warning(text.to_owned()));
    }

    /// Leaves the work when it is to stop. Only where it cannot be asked to.
    pub fn heed(&self) {
        if self.is_stopped() {
            resume_unwind(Box::new(Stopped));
        }
    }

    fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    fn tell(&self) {
        let mut at = lock(&self.at);
        at.1 = Some(Instant::now());
        let progress = at.0;
        // Without the lock: the channel may have to wait for Python.
        drop(at);
        let _ = self.sender.send(Message::Progress(progress));
    }
}

impl run::Observer for Teller<'_> {
    fn event(&self, event: Event<'_>) {
        match event {
            Event::Started { stage, total } => self.start(stage.label(), stage.unit(), total),
            // Of stages that go on at the same time the one that began last is told.
            Event::Advanced { stage, by } if self.is_at(stage.label()) => self.advance(by),
            Event::Finished { stage } if self.is_at(stage.label()) => self.finish(),
            Event::Warning(text) => self.warn(text),
            _ => {}
        }
    }

    fn interrupted(&self) -> bool {
        self.is_stopped()
    }
}

impl pipeline::Observer for Teller<'_> {
    fn started(&self, points: Option<u64>) {
        self.start("reading points", "point", points.unwrap_or(0));
    }

    fn advanced(&self, points: u64) {
        self.advance(points);
    }

    fn finished(&self) {
        self.finish();
    }

    fn warning(&self, text: &str) {
        self.warn(text);
    }

    fn interrupted(&self) -> bool {
        self.is_stopped()
    }

    fn reconstruction(&self) -> &dyn run::Observer {
        self
    }
}

/// Does `work` on a thread of its own. `listener` is called on this one: `progress(stage, unit, done, total)` and
/// `warning(text)`. What it raises, and what a signal raises, stops the work and is raised when it has ended.
///
/// # Errors
/// What was raised, or the error of the work as an exception.
pub fn supervised<T: Send>(
    listener: &Bound<'_, PyAny>,
    work: impl FnOnce(&Teller<'_>) -> Result<T> + Send,
) -> PyResult<T> {
    let py = listener.py();
    let stop = AtomicBool::new(false);
    let (sender, receiver) = mpsc::sync_channel(WAITING);
    // Locked by this thread alone: the lock is what lets it be used without that of the interpreter.
    let receiver = Mutex::new(receiver);
    let outcome = std::thread::scope(|scope| {
        let stop = &stop;
        let worker = std::thread::Builder::new().name("gable-run".to_owned()).spawn_scoped(scope, move || {
            let teller = Teller::new(sender, stop);
            catch_unwind(AssertUnwindSafe(|| work(&teller)))
        });
        let worker = worker.map_err(|e| exception(py, &Error::io("the work", "start a thread for", e)))?;
        match serve(listener, &receiver, stop) {
            Some(raised) => Err(raised),
            // The channel is closed: it has ended.
            None => Ok(worker.join()),
        }
    })?;
    match outcome.unwrap_or_else(Err) {
        Ok(Ok(done)) => Ok(done),
        Ok(Err(error)) => Err(exception(py, &error)),
        Err(panic) => Err(internal(py, said(&*panic))),
    }
}

/// Hands on all messages until there can be no more; gives what was raised first.
fn serve(listener: &Bound<'_, PyAny>, receiver: &Mutex<Receiver<Message>>, stop: &AtomicBool) -> Option<PyErr> {
    let py = listener.py();
    let mut raised = None;
    loop {
        let told = match py.detach(|| lock(receiver).recv_timeout(BEAT)) {
            Err(RecvTimeoutError::Disconnected) => return raised,
            Ok(Message::Progress(Progress { stage, unit, done, total })) if raised.is_none() => {
                listener.call_method1("progress", (stage, unit, done, total)).map(drop)
            }
            Ok(Message::Warning(text)) if raised.is_none() => listener.call_method1("warning", (text,)).map(drop),
            Ok(_) | Err(RecvTimeoutError::Timeout) => Ok(()),
        };
        if let Err(error) = told.and_then(|()| py.check_signals()) {
            stop.store(true, Ordering::Relaxed);
            raised.get_or_insert(error);
        }
    }
}

/// The message of a panic.
fn said(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no message")
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The size of a file in bytes, for a bar; 0 where the system does not tell.
pub fn file_size(path: &Path) -> u64 {
    std::fs::metadata(path).map_or(0, |metadata| metadata.len())
}

/// Tiles that the user named: files, folders and glob patterns.
///
/// # Errors
/// A name that stands for no tile.
pub fn tiles(names: &[String]) -> Result<Vec<std::path::PathBuf>> {
    if names.is_empty() { Ok(Vec::new()) } else { source::points::expand(names) }
}
