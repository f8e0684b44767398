//! How far a simulation is.

use std::io::IsTerminal;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use super::super::interrupt;
use super::super::output::{counted, duration, say, thousands};
use crate::simulate::shards::Observer;

/// How often a plain line says how far it is.
const PLAIN_INTERVAL: Duration = Duration::from_secs(10);

/// A bar on a terminal, a plain line now and then otherwise.
pub(super) struct Progress {
    bar: Option<ProgressBar>,
    quiet: bool,
    total: u64,
    done: AtomicU64,
    started: Instant,
    last_line: Mutex<Instant>,
}

impl Progress {
    pub fn new(total: u64, quiet: bool) -> Self {
        let bar = (!quiet && std::io::stderr().is_terminal()).then(|| {
            let template = "simulating {wide_bar} {human_pos} of {human_len} scans, {per_sec}, {eta} left";
            let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
            let bar = ProgressBar::new(total).with_style(style);
            bar.enable_steady_tick(Duration::from_millis(200));
            bar
        });
        let now = Instant::now();
        Self { bar, quiet, total, done: AtomicU64::new(0), started: now, last_line: Mutex::new(now) }
    }

    /// Clears the bar; returns the seconds that it took.
    pub fn finish(&self) -> f64 {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
        self.started.elapsed().as_secs_f64()
    }
}

impl Observer for Progress {
    fn advanced(&self, by: u64) {
        let done = self.done.fetch_add(by, Ordering::Relaxed) + by;
        if let Some(bar) = &self.bar {
            bar.inc(by);
        } else if !self.quiet {
            let mut last = self.last_line.lock().unwrap_or_else(PoisonError::into_inner);
            if last.elapsed() >= PLAIN_INTERVAL {
                *last = Instant::now();
                let left = self.total.saturating_sub(done) as f64 / done.max(1) as f64;
                let left = duration(left * self.started.elapsed().as_secs_f64());
                say(&format!("simulating: {} of {}, about {left} left", thousands(done), counted(self.total, "scan")));
            }
        }
    }

    fn interrupted(&self) -> bool {
        interrupt::pressed()
    }
}

/// Clears the bar of a simulation that failed.
impl Drop for Progress {
    fn drop(&mut self) {
        self.finish();
    }
}
