//! The functions of the header.

use std::ffi::{CStr, c_char, c_void};
use std::sync::atomic::AtomicBool;
use std::sync::mpsc;

use super::chunk::{Columns, GableChunk};
use super::job::{GableJob, GableStatus, Told};
use super::messages::{Callbacks, GableLineCallback, GableProgressCallback, Lines, Listener, Message};
use super::text::{from_c, to_c};
use crate::cli::{options, summary};
use crate::error::{Error, InputError, Result};
use crate::guard::guarded;
use crate::report::Report;
use crate::run::{Job, run, run_into};
use crate::sink::{Metadata, Sequence, Sink};
use crate::source::points::Extent;

/// What the pointer to a job must be.
const NO_JOB: &CStr = c"the job is a null pointer";
/// Lines and news that wait for the callbacks; more make the run wait, so that memory stays flat.
const WAITING: usize = 64;

/// The version of the library, such as "0.1.0". The text is never freed.
#[unsafe(no_mangle)]
pub extern "C" fn gable_version() -> *const c_char {
    const VERSION: &CStr = match CStr::from_bytes_with_nul(concat!(env!("CARGO_PKG_VERSION"), "\0").as_bytes()) {
        Ok(version) => version,
        Err(_) => c"",
    };
    VERSION.as_ptr()
}

/// Creates a job.
///
/// options is a JSON object whose members are the options of `gable reconstruct`, without the dashes in front:
/// {"footprints": "buildings.gpkg", "output": "city.city.json", "overwrite": true, "building-class": "6"}. NULL or "" is {}.
/// Nothing is required: without "footprints" the points are one building, or one for each id that they name; without
/// "output" no file is written and the callback of gable_run gets the model. "tiles" names LAS, LAZ or COPC files to be read
/// besides the points that are pushed, or instead of any.
///
/// crs is the CRS of the points: a code such as "EPSG:7415", WKT or PROJJSON. NULL or "" if tiles name it.
///
/// *job becomes a job in any case (NULL only when job itself is NULL or memory has run out), which must be freed with
/// gable_free. When the status is not GABLE_STATUS_OK, gable_error(*job) says why, and the job can do nothing else.
///
/// # Safety
/// `options` and `crs` are null or end with a zero, and `job` is null or may be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn gable_create(
    options: *const c_char,
    crs: *const c_char,
    job: *mut *mut GableJob,
) -> GableStatus {
    // SAFETY: the caller vouches for the texts and for the place of the job.
    unsafe {
        make(job, |created| {
            let (options, crs) = (from_c(options, "options")?, from_c(crs, "crs")?);
            created.set_up(options::job(options.unwrap_or_default())?, crs)
        })
    }
}

/// Makes a job and sets it up; it goes to `job` in any case, with the error where there is one.
///
/// # Safety
/// `job` is null or may be written to.
pub(super) unsafe fn make(job: *mut *mut GableJob, set_up: impl FnOnce(&GableJob) -> Result<()>) -> GableStatus {
    if job.is_null() || !job.is_aligned() {
        return GableStatus::Failed;
    }
    let created = Box::new(GableJob::new());
    let status = match guarded(|| set_up(&created)) {
        Ok(Ok(())) => GableStatus::Ok,
        Ok(Err(error)) => {
            created.keep_error(&error.to_string());
            GableStatus::Failed
        }
        Err(detail) => {
            created.keep_error(&format!("a fault of gable itself: {detail}"));
            GableStatus::Failed
        }
    };
    // SAFETY: not null, aligned, and the caller vouches that it may be written to.
    unsafe { job.write(Box::into_raw(created)) };
    status
}

/// Takes a chunk of points. Chunks may have any size, also none, and any order. The points wait in a nameless temporary
/// file (32 bytes a point, in the folder that TMPDIR names, or /tmp), not in memory.
///
/// Points that name a building are given to the footprint of that id wherever they lie; without footprints each
/// building that is named is reconstructed on its own, and points that name none belong to none. The class counts all the
/// same: points of a building have one of the building classes, and ground points around it help to find its height.
///
/// When the status is not GABLE_STATUS_OK none of the chunk's points were taken, unless the temporary file could not be
/// written. Coordinates that are not finite numbers are an error.
///
/// # Safety
/// `job` is null or was created and not freed; `chunk` is null or points to a chunk whose columns are null or as long as it
/// says.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn gable_push(job: *mut GableJob, chunk: *const GableChunk) -> GableStatus {
    // SAFETY: the caller vouches for the job.
    let Some(job) = (unsafe { job.as_ref() }) else { return GableStatus::Failed };
    job.enter(|state| {
        let feed = state.feed()?;
        // SAFETY: the caller vouches for the chunk.
        unsafe { Columns::read(chunk) }?.push(feed)?;
        Ok(GableStatus::Ok)
    })
}

/// Says that a rectangle was scanned (in the units of the CRS), although points of it may have been left out, so that
/// footprints in it do not count as incomplete. May be called several times; without it the extent of the points is taken.
///
/// # Safety
/// `job` is null or was created and not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn gable_cover(
    job: *mut GableJob,
    min_x: f64,
    min_y: f64,
    max_x: f64,
    max_y: f64,
) -> GableStatus {
    // SAFETY: the caller vouches for the job.
    let Some(job) = (unsafe { job.as_ref() }) else { return GableStatus::Failed };
    job.enter(|state| {
        state.feed()?.cover(Extent { min: [min_x, min_y, 0.0], max: [max_x, max_y, 0.0] })?;
        Ok(GableStatus::Ok)
    })
}

/// Reconstructs the buildings. Returns when it is done; a job runs once.
///
/// on_line gets the model line by line, and on_progress is told how far it is; either may be NULL. Both are called on the
/// thread that called gable_run, one at a time, with user_data. They must return (no exception, no longjmp) and may use other
/// jobs but not this one. Without on_line the options must name an output; with both, the model goes to both.
///
/// # Safety
/// `job` is null or was created and not freed; the callbacks are null or may be called with `user_data`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn gable_run(
    job: *mut GableJob,
    on_line: GableLineCallback,
    on_progress: GableProgressCallback,
    user_data: *mut c_void,
) -> GableStatus {
    // SAFETY: the caller vouches for the job.
    let Some(job) = (unsafe { job.as_ref() }) else { return GableStatus::Failed };
    let mut lack = None;
    let status = job.enter(|state| {
        let task = state.finish()?;
        let callbacks = Callbacks { line: on_line, progress: on_progress, user_data };
        // SAFETY: the caller vouches for the callbacks.
        let report = unsafe { reconstruct(&task, callbacks) }?;
        let fault = |e: serde_json::Error| Error::io("the report", "write", e.into());
        let text = to_c(serde_json::to_string(&report).map_err(fault)?);
        lack = summary::lack(&report);
        *job.report() = Some(Told { text, value: serde_json::to_value(&report).map_err(fault)? });
        Ok(match report.exit_code {
            _ if report.interrupted => GableStatus::Cancelled,
            0 => GableStatus::Ok,
            1 => GableStatus::Empty,
            _ => GableStatus::Incomplete,
        })
    });
    if let (GableStatus::Incomplete | GableStatus::Empty, Some(lack)) = (status, lack) {
        job.keep_error(&lack);
    }
    status
}

/// Why the last call on the job failed, in one line: what was found where, what was expected, and what to do; or what the
/// model lacks when a run was GABLE_STATUS_INCOMPLETE or GABLE_STATUS_EMPTY. "" after all other calls. Valid until the next call on the job.
///
/// # Safety
/// `job` is null or was created and not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn gable_error(job: *const GableJob) -> *const c_char {
    // SAFETY: the caller vouches for the job.
    match unsafe { job.as_ref() } {
        Some(job) => job.error().as_ptr(),
        None => NO_JOB.as_ptr(),
    }
}

/// The report of the run as JSON (schemas/report.schema.json): counts, quality, warnings, and what became of each
/// building. NULL before the run, and when it failed. Valid until the job is freed.
///
/// # Safety
/// `job` is null or was created and not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn gable_report(job: *const GableJob) -> *const c_char {
    // SAFETY: the caller vouches for the job.
    let report = unsafe { job.as_ref() }.map(GableJob::report);
    report.as_ref().and_then(|report| report.as_ref()).map_or(std::ptr::null(), |told| told.text.as_ptr())
}

/// A part of the report by its JSON Pointer (RFC 6901), such as "/counts" or "/warnings/0": a text without its quotes, all
/// else as JSON. NULL when there is none, such as behind the last warning. Valid until this is called again for the job.
///
/// # Safety
/// `job` is null or was created and not freed; `pointer` is null or ends with a zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn gable_report_part(job: *const GableJob, pointer: *const c_char) -> *const c_char {
    // SAFETY: the caller vouches for both.
    let (job, pointer) = unsafe { (job.as_ref(), from_c(pointer, "pointer")) };
    let (Some(job), Ok(Some(pointer))) = (job, pointer) else { return std::ptr::null() };
    let report = job.report();
    let Some(found) = report.as_ref().and_then(|told| told.value.pointer(pointer)) else { return std::ptr::null() };
    let text = found.as_str().map_or_else(|| found.to_string(), str::to_owned);
    let mut part = job.part();
    *part = to_c(text);
    part.as_ptr()
}

/// Frees a job and its points; NULL is fine. A job may be freed once, and neither it nor its texts may be used after that.
/// A job that is running is not freed: the status is GABLE_STATUS_BUSY.
///
/// # Safety
/// `job` is null or was created and not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn gable_free(job: *mut GableJob) -> GableStatus {
    // SAFETY: the caller vouches for the job.
    match unsafe { job.as_ref() } {
        None => GableStatus::Ok,
        Some(running) if !running.is_idle() => GableStatus::Busy,
        Some(_) => {
            // SAFETY: gable_create made it with `Box::into_raw`, and the caller vouches that it was not freed before.
            let job = unsafe { Box::from_raw(job) };
            match guarded(|| drop(job)) {
                Ok(()) => GableStatus::Ok,
                Err(_) => GableStatus::Failed,
            }
        }
    }
}

/// Runs on a thread of its own and calls back on this one.
///
/// # Safety
/// The callbacks may be called until this returns.
unsafe fn reconstruct(job: &Job, callbacks: Callbacks) -> Result<Report> {
    let stop = AtomicBool::new(false);
    let (sender, receiver) = mpsc::sync_channel(WAITING);
    std::thread::scope(|scope| {
        let listener = Listener::new(sender.clone(), &stop);
        let wants_lines = callbacks.line.is_some();
        let worker = std::thread::Builder::new().name("gable-run".to_owned()).spawn_scoped(scope, move || {
            guarded(|| {
                if !wants_lines {
                    drop(sender);
                    return run(job, &listener);
                }
                run_into(job, &listener, |metadata: &Metadata| {
                    let sequence = Sequence::new(metadata.clone())?;
                    let head = sequence.head()?;
                    let _ = sender.send(Message::Line(head));
                    Ok(Box::new(Lines { sequence, sender, features: 0 }) as Box<dyn Sink>)
                })
            })
        });
        let worker = worker.map_err(|e| Error::io("the run", "start a thread for", e))?;
        // SAFETY: the caller vouches for the callbacks.
        unsafe { callbacks.serve(&receiver, &stop) };
        match worker.join() {
            Ok(Ok(outcome)) => outcome,
            Ok(Err(detail)) => Err(internal(&detail)),
            Err(_) => Err(internal("the run ended without a word")),
        }
    })
}

/// A fault of the program.
fn internal(detail: &str) -> Error {
    InputError::new("gable", format!("a fault of its own: {detail}"), "none").into()
}
