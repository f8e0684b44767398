//! Progress: bars with rate and remaining time on a terminal, plain lines otherwise.

use std::fmt::Write;
use std::io::IsTerminal;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{MultiProgress, ProgressBar, ProgressState, ProgressStyle};

use super::output::{counted, duration, say, thousands};
use super::{interrupt, summary};
use crate::run::{Event, Observer, Stage};

/// How often a plain line says how far it is.
const PLAIN_INTERVAL: Duration = Duration::from_secs(10);

/// How much to say.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verbosity {
    /// Errors only.
    Quiet,
    /// Progress, warnings, summary.
    Normal,
    /// Also a line for every building.
    Verbose,
}

/// Shows the progress of a run on standard error.
pub struct Progress {
    verbosity: Verbosity,
    terminal: bool,
    /// The stages under way: tiles are read while buildings are made of what was read.
    under_way: Mutex<Vec<UnderWay>>,
    bars: MultiProgress,
}

/// A stage under way.
struct UnderWay {
    stage: Stage,
    total: u64,
    done: u64,
    started: Instant,
    last_line: Instant,
    bar: Option<ProgressBar>,
}

impl Progress {
    /// Bars if standard error is a terminal, plain lines if not.
    pub fn new(verbosity: Verbosity) -> Self {
        let terminal = std::io::stderr().is_terminal();
        Self { verbosity, terminal, under_way: Mutex::default(), bars: MultiProgress::new() }
    }

    fn lock(&self) -> MutexGuard<'_, Vec<UnderWay>> {
        self.under_way.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Writes a line above the bars.
    fn line(&self, text: &str) {
        if self.terminal { self.bars.suspend(|| say(text)) } else { say(text) }
    }

    fn start(&self, stage: Stage, total: u64) {
        let bar = self.terminal.then(|| {
            let template = "{msg} {wide_bar} {done} of {all}s, {rate}/s, {eta} left";
            let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
            let style = style
                .with_key("done", |state: &ProgressState, w: &mut dyn Write| {
                    let _ = w.write_str(&thousands(state.pos()));
                })
                .with_key("all", move |state: &ProgressState, w: &mut dyn Write| {
                    let _ = write!(w, "{} {}", thousands(state.len().unwrap_or(0)), stage.unit());
                })
                .with_key("rate", |state: &ProgressState, w: &mut dyn Write| {
                    let _ = w.write_str(&thousands(state.per_sec().round() as u64));
                });
            let bar = self.bars.add(ProgressBar::new(total).with_style(style));
            bar.set_message(stage.label());
            bar.enable_steady_tick(Duration::from_millis(200));
            bar
        });
        let now = Instant::now();
        self.lock().push(UnderWay { stage, total, done: 0, started: now, last_line: now, bar });
    }

    fn advance(&self, stage: Stage, by: u64) {
        let mut lock = self.lock();
        let Some(stage) = lock.iter_mut().find(|under_way| under_way.stage == stage) else { return };
        stage.done += by;
        if let Some(bar) = &stage.bar {
            bar.inc(by);
        } else if stage.last_line.elapsed() >= PLAIN_INTERVAL {
            stage.last_line = Instant::now();
            let elapsed = stage.started.elapsed().as_secs_f64();
            let left = stage.total.saturating_sub(stage.done) as f64 / stage.done.max(1) as f64 * elapsed;
            let (name, unit) = (stage.stage.label(), stage.stage.unit());
            let (done, total) = (thousands(stage.done), counted(stage.total, unit));
            drop(lock);
            self.line(&format!("{name}: {done} of {total}, about {} left", duration(left)));
        }
    }

    fn finish(&self, stage: Stage) {
        let mut lock = self.lock();
        let Some(at) = lock.iter().position(|under_way| under_way.stage == stage) else { return };
        let stage = lock.remove(at);
        drop(lock);
        if let Some(bar) = &stage.bar {
            bar.finish_and_clear();
        }
        let elapsed = duration(stage.started.elapsed().as_secs_f64());
        let done = counted(stage.done, stage.stage.unit());
        self.line(&format!("{}: {done} in {elapsed}", stage.stage.label()));
    }
}

/// Clears the bars of stages that failed.
impl Drop for Progress {
    fn drop(&mut self) {
        for bar in self.lock().drain(..).filter_map(|stage| stage.bar) {
            bar.finish_and_clear();
        }
    }
}

impl Observer for Progress {
    fn event(&self, event: Event<'_>) {
        if let Event::Finished { stage: Stage::Segment } | Event::Advanced { stage: Stage::Reconstruct, .. } = event {
            interrupt::something_to_save();
        }
        if self.verbosity == Verbosity::Quiet {
            return;
        }
        match event {
            Event::Started { stage, total } => self.start(stage, total),
            Event::Advanced { stage, by } => self.advance(stage, by),
            Event::Finished { stage } => self.finish(stage),
            Event::Building(building) if self.verbosity == Verbosity::Verbose => {
                self.line(&summary::building(building));
            }
            Event::Building(_) => {}
            Event::Warning(text) => self.line(&format!("warning: {text}")),
        }
    }

    fn interrupted(&self) -> bool {
        interrupt::pressed()
    }
}
