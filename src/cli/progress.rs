//! Progress: bars with rate and remaining time on a terminal, plain lines otherwise.

use std::fmt::Write;
use std::io::IsTerminal;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

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
    under_way: Mutex<Option<UnderWay>>,
}

/// The stage under way.
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
        Self { verbosity, terminal: std::io::stderr().is_terminal(), under_way: Mutex::new(None) }
    }

    fn lock(&self) -> MutexGuard<'_, Option<UnderWay>> {
        self.under_way.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Writes a line above the bar.
    fn line(under_way: Option<&UnderWay>, text: &str) {
        let write = || say(text);
        match under_way.and_then(|u| u.bar.as_ref()) {
            Some(bar) => bar.suspend(write),
            None => write(),
        }
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
            let bar = ProgressBar::with_draw_target(Some(total), ProgressDrawTarget::hidden()).with_style(style);
            bar.set_message(stage.label());
            bar.set_draw_target(ProgressDrawTarget::stderr());
            bar.enable_steady_tick(Duration::from_millis(200));
            bar
        });
        let now = Instant::now();
        *self.lock() = Some(UnderWay { stage, total, done: 0, started: now, last_line: now, bar });
    }

    fn advance(&self, by: u64) {
        let mut lock = self.lock();
        let Some(stage) = lock.as_mut() else { return };
        stage.done += by;
        if let Some(bar) = &stage.bar {
            bar.inc(by);
        } else if stage.last_line.elapsed() >= PLAIN_INTERVAL {
            stage.last_line = Instant::now();
            let elapsed = stage.started.elapsed().as_secs_f64();
            let left = stage.total.saturating_sub(stage.done) as f64 / stage.done.max(1) as f64 * elapsed;
            let (name, unit) = (stage.stage.label(), stage.stage.unit());
            let (done, total) = (thousands(stage.done), counted(stage.total, unit));
            Self::line(None, &format!("{name}: {done} of {total}, about {} left", duration(left)));
        }
    }

    fn finish(&self) {
        let Some(stage) = self.lock().take() else { return };
        if let Some(bar) = &stage.bar {
            bar.finish_and_clear();
        }
        let elapsed = duration(stage.started.elapsed().as_secs_f64());
        let done = counted(stage.done, stage.stage.unit());
        Self::line(None, &format!("{}: {done} in {elapsed}", stage.stage.label()));
    }
}

/// Clears the bar of a stage that failed.
impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = self.lock().take().and_then(|stage| stage.bar) {
            bar.finish_and_clear();
        }
    }
}

impl Observer for Progress {
    fn event(&self, event: Event<'_>) {
        if let Event::Finished { stage: Stage::Segment } = event {
            interrupt::something_to_save();
        }
        if self.verbosity == Verbosity::Quiet {
            return;
        }
        match event {
            Event::Started { stage, total } => self.start(stage, total),
            Event::Advanced { by, .. } => self.advance(by),
            Event::Finished { .. } => self.finish(),
            Event::Building(building) if self.verbosity == Verbosity::Verbose => {
                Self::line(self.lock().as_ref(), &summary::building(building));
            }
            Event::Building(_) => {}
            Event::Warning(text) => Self::line(self.lock().as_ref(), &format!("warning: {text}")),
        }
    }

    fn interrupted(&self) -> bool {
        interrupt::pressed()
    }
}
