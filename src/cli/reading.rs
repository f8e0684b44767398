//! Progress through files: a bar on a terminal, plain lines otherwise.

use std::io::IsTerminal;
use std::path::Path;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use super::output::{counted, say};

/// The size of a file in bytes; 0 where the system does not tell.
pub fn file_size(path: &Path) -> u64 {
    std::fs::metadata(path).map_or(0, |m| m.len())
}

/// How often a plain line says how far it is.
const PLAIN_INTERVAL: Duration = Duration::from_secs(10);

/// How far a file has been read: a bar on a terminal, a plain line now and then otherwise.
pub struct ReadingProgress {
    label: &'static str,
    bar: Option<ProgressBar>,
    size: u64,
    read: u64,
    last_line: Instant,
}

impl ReadingProgress {
    /// Shows what is done with this many bytes.
    pub fn new(label: &'static str, size: u64) -> Self {
        let bar = std::io::stderr().is_terminal().then(|| {
            let template = "{prefix} {wide_bar} {msg}, {bytes} of {total_bytes}, {eta} left";
            let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
            let bar = ProgressBar::new(size).with_style(style).with_prefix(label);
            bar.enable_steady_tick(Duration::from_millis(200));
            bar
        });
        Self { label, bar, size, read: 0, last_line: Instant::now() }
    }

    /// So many features are done, and so many more bytes are read.
    pub fn advance(&mut self, features: usize, bytes: u64) {
        self.read += bytes;
        let features = counted(features as u64, "feature");
        if let Some(bar) = &self.bar {
            bar.inc(bytes);
            bar.set_message(features);
        } else if self.last_line.elapsed() >= PLAIN_INTERVAL {
            self.last_line = Instant::now();
            say(&format!(
                "{}: {features}, {:.0} % read",
                self.label,
                100.0 * self.read as f64 / self.size.max(1) as f64
            ));
        }
    }
}

impl Drop for ReadingProgress {
    fn drop(&mut self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
