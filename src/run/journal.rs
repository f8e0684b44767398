//! What is noted down during a run for its report.

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use super::observer::{Event, Observer, Stage};
use crate::error::{Error, Result};
use crate::report::{Scope, StageReport, Stopwatch};

/// Passes events on, and keeps the warnings and what each stage cost.
pub struct Journal<'a> {
    observer: &'a dyn Observer,
    warnings: Mutex<Vec<String>>,
    stages: Mutex<Vec<StageReport>>,
    total: Stopwatch,
}

impl<'a> Journal<'a> {
    /// Starts the clock.
    pub fn new(observer: &'a dyn Observer) -> Self {
        let total = Stopwatch::start(Scope::Process);
        Self { observer, warnings: Mutex::new(Vec::new()), stages: Mutex::default(), total }
    }

    /// Does a stage of `total` units.
    ///
    /// # Errors
    /// What `work` says, or [`Error::Interrupted`] when the run was stopped before the stage.
    pub fn stage<T>(&self, stage: Stage, total: u64, work: impl FnOnce(&Self) -> Result<T>) -> Result<T> {
        // These two write what is done.
        if self.observer.interrupted() && !matches!(stage, Stage::Terrain | Stage::Finish) {
            return Err(Error::Interrupted);
        }
        let watch = Stopwatch::start(Scope::Process);
        let within = self.within();
        self.event(Event::Started { stage, total });
        let done = work(self)?;
        let cpu = watch.cpu().map(|cpu| cpu.saturating_sub(self.within().saturating_sub(within)));
        self.end(stage, &watch, cpu);
        Ok(done)
    }

    /// Ends a stage that went on while another did, and took so much processor time of its own.
    pub fn end(&self, stage: Stage, watch: &Stopwatch, cpu: Option<Duration>) {
        self.event(Event::Finished { stage });
        let (wall_seconds, cpu_seconds) = (watch.wall().as_secs_f64(), cpu.map(|cpu| cpu.as_secs_f64()));
        self.stages().push(StageReport { stage, wall_seconds, cpu_seconds });
    }

    /// The processor time of the stages that have ended.
    fn within(&self) -> Duration {
        self.stages().iter().filter_map(|stage| stage.cpu_seconds).map(Duration::from_secs_f64).sum()
    }

    fn stages(&self) -> MutexGuard<'_, Vec<StageReport>> {
        self.stages.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The warnings, the stages, and the clock of the whole run.
    pub fn close(self) -> (Vec<String>, Vec<StageReport>, Stopwatch) {
        (
            self.warnings.into_inner().unwrap_or_else(PoisonError::into_inner),
            self.stages.into_inner().unwrap_or_else(PoisonError::into_inner),
            self.total,
        )
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
