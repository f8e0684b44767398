//! What stands behind the opaque pointer.

use std::ffi::CString;
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};

use super::text::to_c;
use crate::error::{Error, InputError, Result};
use crate::guard::guarded;
use crate::run::{Feed, Job};
use crate::source::crs::Crs;

/// What came of a call.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GableStatus {
    /// Done. After gable_run: every footprint that holds points has a model.
    Ok = 0,
    /// Nothing could be done; gable_error says why.
    Failed = 1,
    /// The run finished and wrote what there is, but some buildings lack a model or some points could not be read;
    /// gable_report says which and why.
    Incomplete = 2,
    /// The run finished, but no building has a model; gable_report says why.
    Empty = 3,
    /// A callback stopped the run. What was done until then was written and handed over.
    Cancelled = 4,
    /// The job is in use: by another thread, or the call came from one of its own callbacks. Nothing was done.
    Busy = 5,
}

/// How messages and reports call the points.
pub(super) const POINTS: &str = "points";

/// Opens the feed of a job.
pub(super) type OpenFeed = fn(&Job) -> Result<Feed>;

/// A job: options, points, and what came of them. Only pointers to it are used; gable_create makes one and gable_free
/// takes it back.
pub struct GableJob {
    state: Mutex<State>,
    error: Mutex<CString>,
    report: Mutex<Option<Told>>,
    part: Mutex<CString>,
}

/// What a run has to tell.
pub(super) struct Told {
    /// As JSON.
    pub text: CString,
    /// The same.
    pub value: serde_json::Value,
}

/// How far a job is.
pub(super) struct State {
    /// What is to be done; `None` when the options were of no use.
    pub job: Option<Job>,
    /// The CRS of the points.
    pub crs: Option<String>,
    /// Takes points until the run.
    pub feed: Option<Feed>,
    /// Opens the feed.
    open: OpenFeed,
    /// Whether there may be no points.
    may_be_empty: bool,
    /// Whether it has run.
    pub has_run: bool,
}

impl GableJob {
    /// A job that knows nothing yet.
    pub(super) fn new() -> Self {
        let state = State {
            job: None,
            crs: None,
            feed: None,
            open: |_| Feed::new(POINTS),
            may_be_empty: false,
            has_run: false,
        };
        Self { state: Mutex::new(state), error: Mutex::default(), report: Mutex::new(None), part: Mutex::default() }
    }

    /// Takes the options of a stage of another program's pipeline, which may have no points for it; a CRS among them goes before
    /// that of the points.
    ///
    /// # Errors
    /// The CRS is not what it should be.
    #[cfg(feature = "pipelines")]
    pub(super) fn set_up_writer(&self, mut job: Job, crs: Option<&str>, open: OpenFeed) -> Result<()> {
        let own = job.crs.take();
        self.set_up(job, own.as_deref().or(crs))?;
        let mut state = self.lock().map_err(|()| unusable("a job in use"))?;
        (state.open, state.may_be_empty) = (open, true);
        Ok(())
    }

    /// Takes the options and the CRS of the points.
    ///
    /// # Errors
    /// One of them is not what it should be.
    pub(super) fn set_up(&self, job: Job, crs: Option<&str>) -> Result<()> {
        let crs = crs.filter(|text| !text.trim().is_empty());
        if let Some(text) = crs {
            Crs::parse(text)?;
        }
        let mut state = self.lock().map_err(|()| unusable("a job in use"))?;
        state.crs = crs.map(str::to_owned);
        state.job = Some(job);
        Ok(())
    }

    /// Does `work` on the state: keeps its error, and takes a panic for one.
    pub(super) fn enter(&self, work: impl FnOnce(&mut State) -> Result<GableStatus>) -> GableStatus {
        let Ok(mut state) = self.lock() else { return GableStatus::Busy };
        let outcome = guarded(|| work(&mut state));
        let (status, error) = match outcome {
            Ok(Ok(status)) => (status, String::new()),
            Ok(Err(Error::Interrupted)) => (GableStatus::Cancelled, Error::Interrupted.to_string()),
            Ok(Err(error)) => (GableStatus::Failed, error.to_string()),
            Err(detail) => (GableStatus::Failed, format!("a fault of gable itself: {detail}")),
        };
        self.keep_error(&error);
        status
    }

    /// Whether nobody uses it.
    pub(super) fn is_idle(&self) -> bool {
        self.lock().is_ok()
    }

    fn lock(&self) -> Result<MutexGuard<'_, State>, ()> {
        match self.state.try_lock() {
            Ok(state) => Ok(state),
            Err(TryLockError::Poisoned(poisoned)) => Ok(poisoned.into_inner()),
            Err(TryLockError::WouldBlock) => Err(()),
        }
    }

    /// The text that says why the last call failed.
    pub(super) fn error(&self) -> MutexGuard<'_, CString> {
        self.error.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn keep_error(&self, error: &str) {
        *self.error() = to_c(error);
    }

    /// The report of the last run.
    pub(super) fn report(&self) -> MutexGuard<'_, Option<Told>> {
        self.report.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The part of the report that was asked for last.
    pub(super) fn part(&self) -> MutexGuard<'_, CString> {
        self.part.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    /// What takes points.
    ///
    /// # Errors
    /// The options were of no use, the run has been, or the temporary folder cannot be written to.
    pub(super) fn feed(&mut self) -> Result<&mut Feed> {
        self.refuse_misuse()?;
        match &mut self.feed {
            Some(feed) => Ok(feed),
            none => {
                let job = self.job.as_ref().ok_or_else(|| unusable("a job without options"))?;
                Ok(none.insert((self.open)(job)?))
            }
        }
    }

    /// What is to be done, with all points.
    ///
    /// # Errors
    /// As [`Self::feed`].
    pub(super) fn finish(&mut self) -> Result<Job> {
        if self.may_be_empty {
            self.feed()?;
        }
        self.refuse_misuse()?;
        let mut job = self.job.clone().ok_or_else(|| unusable("a job without options"))?;
        job.crs.clone_from(&self.crs);
        self.has_run = true;
        let feed = self.feed.take().filter(|feed| feed.points() > 0 || self.may_be_empty);
        if feed.is_none() && job.tiles.is_empty() && job.clouds.is_empty() {
            let fault = InputError::new("the job", "no points", "points that were pushed, or the option \"tiles\"");
            return Err(fault.into());
        }
        job.fed = feed.map(|feed| feed.finish(self.crs.as_deref())).transpose()?;
        Ok(job)
    }

    fn refuse_misuse(&self) -> Result<()> {
        if self.job.is_none() {
            return Err(unusable("a job whose gable_create failed"));
        }
        if self.has_run {
            return Err(unusable("a job that has run"));
        }
        Ok(())
    }
}

/// A job that can do no more.
fn unusable(found: &str) -> Error {
    InputError::new("the job", found, "a new one").remedy("Free it and create another").into()
}
