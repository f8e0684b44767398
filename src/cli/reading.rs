//! How far the reading of a city model is.

use std::io::IsTerminal;
use std::path::Path;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use super::output::{counted, say};

/// How often a plain line says how far it is.
const PLAIN_INTERVAL: Duration = Duration::from_secs(10);

/// How far a file has been read: a bar on a terminal, a plain line now and then otherwise.
pub struct Reading {
    action: &'static str,
    bar: Option<ProgressBar>,
    size: u64,
    read: u64,
    last_line: Instant,
}

impl Reading {
    /// Nothing of the file at `path` has been read. `action` is the first word of what is shown.
    pub fn new(action: &'static str, path: &Path) -> Self {
        let size = std::fs::metadata(path).map_or(0, |m| m.len());
        let bar = std::io::stderr().is_terminal().then(|| {
            let template = format!("{action} {{wide_bar}} {{msg}}, {{bytes}} of {{total_bytes}}, {{eta}} left");
            let style = ProgressStyle::with_template(&template).unwrap_or_else(|_| ProgressStyle::default_bar());
            let bar = ProgressBar::new(size).with_style(style);
            bar.enable_steady_tick(Duration::from_millis(200));
            bar
        });
        Self { action, bar, size, read: 0, last_line: Instant::now() }
    }

    /// So many features in all, and so many bytes more than before.
    pub fn advance(&mut self, features: usize, bytes: u64) {
        self.read += bytes;
        let features = counted(features as u64, "feature");
        if let Some(bar) = &self.bar {
            bar.inc(bytes);
            bar.set_message(features);
        } else if self.last_line.elapsed() >= PLAIN_INTERVAL {
            self.last_line = Instant::now();
            say(&format!(
                "{}: {features}, {:.0} % of the file",
                self.action,
                100.0 * self.read as f64 / self.size.max(1) as f64
            ));
        }
    }
}

impl Drop for Reading {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
