//! What is noted down during a run for its report.

use std::sync::{Mutex, PoisonError};

use super::observer::{Event, Observer, Stage};
use crate::error::{Error, Result};
use crate::report::{Scope, StageReport, Stopwatch};

/// Passes events on, and keeps the warnings and what each stage cost.
pub struct Journal<'a> {
    observer: &'a dyn Observer,
    warnings: Mutex<Vec<String>>,
    stages: Vec<StageReport>,
    total: Stopwatch,
}

impl<'a> Journal<'a> {
    /// Starts the clock.
    pub fn new(observer: &'a dyn Observer) -> Self {
        let total = Stopwatch::start(Scope::Process);
        Self { observer, warnings: Mutex::new(Vec::new()), stages: Vec::new(), total }
    }

    /// Does a stage of `total` units.
    ///
    /// # Errors
    /// What `work` says, or [`Error::Interrupted`] when the run was stopped before the stage.
    pub fn stage<T>(&mut self, stage: Stage, total: u64, work: impl FnOnce(&Self) -> Result<T>) -> Result<T> {
        // These two write what is done.
        if self.observer.interrupted() && !matches!(stage, Stage::Terrain | Stage::Finish) {
            return Err(Error::Interrupted);
        }
        let watch = Stopwatch::start(Scope::Process);
        self.event(Event::Started { stage, total });
        let done = work(self)?;
        self.event(Event::Finished { stage });
        let seconds = |time: std::time::Duration| time.as_secs_f64();
        let cpu_seconds = watch.cpu().map(seconds);
        self.stages.push(StageReport { stage, wall_seconds: seconds(watch.wall()), cpu_seconds });
        Ok(done)
    }

    /// The warnings, the stages, and the clock of the whole run.
    pub fn close(self) -> (Vec<String>, Vec<StageReport>, Stopwatch) {
        (self.warnings.into_inner().unwrap_or_else(PoisonError::into_inner), self.stages, self.total)
    }

    /// Warns.
    pub fn warn(&self, text: &str) {
        self.event(Event::Warning(text));
    }
}

impl Observer for Journal<'_> {
    fn event(&self, event: Event<'_>) {
        if let Event::Warning(text) = event {
            self.warnings.lock().unwrap_or_else(PoisonError::into_inner).push(text.to_owned());
        }
        self.observer.event(event);
    }

    fn interrupted(&self) -> bool {
        self.observer.interrupted()
    }
}
