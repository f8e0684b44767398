//! From the threads of a run to the callbacks, which all come on the thread that asked for the run.

use std::ffi::{c_char, c_int, c_void};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use super::text::to_c;
use crate::error::{Error, Result};
use crate::run::{Event, Observer, Stage};
use crate::sink::{Feature, Sequence, Sink, Written};

/// How often progress is told at most, and how often the callback is asked whether to go on at least.
const BEAT: Duration = Duration::from_millis(50);

/// The stages of a run, in order; the terrain is made before the output is completed.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GableStage {
    /// Reads footprints and what the points are; counted in files.
    Read = 0,
    /// Gives the points to the buildings that they belong to; counted in points.
    Segment = 1,
    /// Reconstructs the buildings; counted in buildings.
    Reconstruct = 2,
    /// Completes the output; counted in files.
    Finish = 3,
    /// Makes the terrain, if the job asks for it; counted in tiles.
    Terrain = 4,
    /// Writes the points of each building to a file of its own, before the output is completed; counted in points.
    Crop = 5,
}

impl From<Stage> for GableStage {
    fn from(stage: Stage) -> Self {
        match stage {
            // One run has no stages of plans: nobody is told these two.
            Stage::Read | Stage::Plan => Self::Read,
            Stage::Segment => Self::Segment,
            Stage::Reconstruct => Self::Reconstruct,
            Stage::Crop => Self::Crop,
            Stage::Finish | Stage::Merge => Self::Finish,
            Stage::Terrain => Self::Terrain,
        }
    }
}

/// Takes the model line by line: first a CityJSON object without buildings (its "transform" is that of all that
/// follow), then one CityJSONFeature per building, in the order of the footprints, then one per piece of the terrain if the job
/// asks for it. Together they are a CityJSONSeq. The line has no line end, ends with a zero after its length, and is yours
/// until you return.
///
/// Return 0 to go on, anything else to stop the run.
pub type GableLineCallback =
    Option<unsafe extern "C" fn(line: *const c_char, length: usize, user_data: *mut c_void) -> c_int>;

/// Is told how far the run is: done of total in the unit of the stage. It is called some twenty times a second, also
/// while nothing changes.
///
/// Return 0 to go on, anything else to stop the run: buildings under way are completed and what is done is written.
pub type GableProgressCallback =
    Option<unsafe extern "C" fn(stage: GableStage, done: u64, total: u64, user_data: *mut c_void) -> c_int>;

/// Something to be told on the caller's thread.
pub(super) enum Message {
    /// A line of the model.
    Line(Vec<u8>),
    /// How far it is.
    Progress(Progress),
}

/// How far the run is.
#[derive(Debug, Clone, Copy)]
pub(super) struct Progress {
    stage: GableStage,
    done: u64,
    total: u64,
}

/// Tells the caller's thread how far the run is, and the run whether to stop.
pub(super) struct Listener<'a> {
    pub sender: SyncSender<Message>,
    pub stop: &'a AtomicBool,
    pub at: Mutex<(Progress, Option<Instant>)>,
}

impl<'a> Listener<'a> {
    /// Tells through `sender`.
    pub(super) fn new(sender: SyncSender<Message>, stop: &'a AtomicBool) -> Self {
        let start = Progress { stage: GableStage::Read, done: 0, total: 0 };
        Self { sender, stop, at: Mutex::new((start, None)) }
    }
}

impl Observer for Listener<'_> {
    fn event(&self, event: Event<'_>) {
        let mut at = self.at.lock().unwrap_or_else(PoisonError::into_inner);
        let (progress, told) = &mut *at;
        let is_due = match event {
            Event::Started { stage, total } => {
                *progress = Progress { stage: stage.into(), done: 0, total };
                true
            }
            // Of stages that go on at the same time the one that began last is told.
            Event::Advanced { stage, by } if progress.stage == stage.into() => {
                progress.done += by;
                told.is_none_or(|told| told.elapsed() >= BEAT)
            }
            Event::Finished { stage } => progress.stage == stage.into(),
            _ => false,
        };
        if is_due {
            *told = Some(Instant::now());
            let progress = *progress;
            // Without the lock: the channel may have to wait for the callback.
            drop(at);
            let _ = self.sender.send(Message::Progress(progress));
        }
    }

    fn interrupted(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

/// Sends the model to the caller's thread.
pub(super) struct Lines {
    pub sequence: Sequence,
    pub sender: SyncSender<Message>,
    pub features: usize,
}

impl Sink for Lines {
    fn write(&mut self, feature: &Feature) -> Result<()> {
        self.features += 1;
        let line = self.sequence.feature(feature)?.to_vec();
        self.sender.send(Message::Line(line)).map_err(|_| Error::Interrupted)
    }

    fn finish(self: Box<Self>) -> Result<Written> {
        let (features, objects) = (self.features, self.sequence.objects());
        Ok(Written { path: PathBuf::new(), format: None, features, objects, bytes: 0, notes: Vec::new() })
    }
}

/// The caller's functions, and what they want to be called with.
#[derive(Clone, Copy)]
pub(super) struct Callbacks {
    pub line: GableLineCallback,
    pub progress: GableProgressCallback,
    pub user_data: *mut c_void,
}

impl Callbacks {
    /// Calls back for all messages until there can be no more; sets `stop` when a callback wants it.
    ///
    /// # Safety
    /// The functions may be called with the user data until this returns.
    pub(super) unsafe fn serve(self, messages: &Receiver<Message>, stop: &AtomicBool) {
        let mut progress = None;
        loop {
            let message = match messages.recv_timeout(BEAT) {
                Ok(message) => message,
                Err(RecvTimeoutError::Disconnected) => return,
                Err(RecvTimeoutError::Timeout) => match progress {
                    Some(progress) => Message::Progress(progress),
                    None => continue,
                },
            };
            let answer = match (message, self.line, self.progress) {
                (Message::Line(line), Some(call), _) => {
                    let length = line.len();
                    let line = to_c(line);
                    // SAFETY: the text outlives the call, and the caller vouches for the function.
                    unsafe { call(line.as_ptr(), length, self.user_data) }
                }
                (Message::Progress(at), _, Some(call)) => {
                    progress = Some(at);
                    // SAFETY: the caller vouches for the function.
                    unsafe { call(at.stage, at.done, at.total, self.user_data) }
                }
                _ => 0,
            };
            if answer != 0 {
                stop.store(true, Ordering::Relaxed);
            }
        }
    }
}
