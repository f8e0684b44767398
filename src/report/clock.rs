//! Time and memory of the process. Nothing of it ever reaches a model: it differs from run to run.

use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// Which processor time is meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scope {
    /// Of this thread alone.
    Thread,
    /// Of all threads of the process.
    Process,
}

/// A stopwatch for wall and processor time.
#[derive(Debug, Clone, Copy)]
pub struct Stopwatch {
    scope: Scope,
    wall: Instant,
    cpu: Option<Duration>,
}

impl Stopwatch {
    /// Starts it. With [`Scope::Thread`] it must be read on the same thread.
    pub fn start(scope: Scope) -> Self {
        Self { scope, wall: Instant::now(), cpu: cpu(scope) }
    }

    /// Wall time since the start.
    pub fn wall(&self) -> Duration {
        self.wall.elapsed()
    }

    /// Processor time since the start; `None` where the system does not tell.
    pub fn cpu(&self) -> Option<Duration> {
        Some(cpu(self.scope)?.saturating_sub(self.cpu?))
    }
}

#[cfg(unix)]
fn cpu(scope: Scope) -> Option<Duration> {
    let id = match scope {
        Scope::Thread => rustix::time::ClockId::ThreadCPUTime,
        Scope::Process => rustix::time::ClockId::ProcessCPUTime,
    };
    let time = rustix::time::clock_gettime(id);
    Some(Duration::new(u64::try_from(time.tv_sec).ok()?, u32::try_from(time.tv_nsec).ok()?))
}

#[cfg(not(unix))]
fn cpu(_scope: Scope) -> Option<Duration> {
    None
}

/// Most memory that the process has held so far, in bytes (`VmHWM`); `None` where `/proc` does not tell.
pub fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024)
}

/// The present moment in UTC as RFC 3339 writes it, to the second.
pub fn now() -> String {
    let seconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    rfc3339(seconds)
}

/// Seconds since 1970 in UTC as RFC 3339 writes them.
fn rfc3339(seconds: u64) -> String {
    let (mut day, second) = (seconds / 86_400, seconds % 86_400);
    let mut year = 1970;
    loop {
        let length = if is_leap(year) { 366 } else { 365 };
        if day < length {
            break;
        }
        day -= length;
        year += 1;
    }
    let mut month = 1;
    for length in [31, if is_leap(year) { 29 } else { 28 }, 31, 30, 31, 30, 31, 31, 30, 31, 30] {
        if day < length {
            break;
        }
        day -= length;
        month += 1;
    }
    let (hour, minute, second) = (second / 3600, second / 60 % 60, second % 60);
    format!("{year:04}-{month:02}-{:02}T{hour:02}:{minute:02}:{second:02}Z", day + 1)
}

fn is_leap(year: u64) -> bool {
    year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_are_those_of_the_calendar() {
        assert_eq!(rfc3339(0), "1970-01-01T00:00:00Z");
        assert_eq!(rfc3339(951_782_400), "2000-02-29T00:00:00Z");
        assert_eq!(rfc3339(1_709_251_199), "2024-02-29T23:59:59Z");
        assert_eq!(rfc3339(1_735_689_599), "2024-12-31T23:59:59Z");
        assert_eq!(rfc3339(4_107_542_400), "2100-03-01T00:00:00Z");
    }

    #[cfg(unix)]
    #[test]
    fn sleeping_costs_wall_time_but_no_processor_time() {
        let watch = Stopwatch::start(Scope::Thread);
        std::thread::sleep(Duration::from_millis(60));
        assert!(watch.wall() >= Duration::from_millis(60));
        assert!(watch.cpu().unwrap() < Duration::from_millis(30));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn peak_memory_grows_with_what_is_touched() {
        let before = peak_memory().unwrap();
        let block = std::hint::black_box(vec![1u8; 256 << 20]);
        assert!(block.iter().step_by(4096).all(|&b| b == 1));
        assert!(peak_memory().unwrap() > before.max(256 << 20));
    }
}
