//! `writers.lod2` as a stage of another program's pipelines.

use std::ffi::{CString, c_char, c_int};
use std::sync::OnceLock;

use super::entry::make;
use super::job::{GableJob, GableStatus, POINTS};
use super::text::{from_c, to_c};
use crate::pipeline::stages::lod2_writer::{feed, hosted_job, hosted_options};

/// An option of the stage `writers.lod2` of `gable pipeline`.
#[repr(C)]
#[derive(Debug)]
pub struct GableOption {
    /// Its name, such as "building_class".
    pub name: *const c_char,
    /// What it does and what it accepts: one line without a full stop.
    pub help: *const c_char,
    /// Its default as text; NULL when it has none.
    pub default_value: *const c_char,
    /// Not 0 when it takes several values: an array of texts, or one text with commas.
    pub is_list: c_int,
    /// Not 0 when the stage cannot do without it.
    pub is_required: c_int,
}

/// The options, and the texts that they point to.
struct Table {
    options: Vec<GableOption>,
    _texts: Vec<CString>,
}

// SAFETY: nobody writes to what the pointers point to, and it lives as long as they do.
unsafe impl Send for Table {}
// SAFETY: as above.
unsafe impl Sync for Table {}

impl Table {
    fn new() -> Self {
        let mut texts = Vec::new();
        let mut keep = |text: String| {
            let text = to_c(text);
            let pointer = text.as_ptr();
            // Moving a CString does not move its text.
            texts.push(text);
            pointer
        };
        let options = hosted_options().into_iter().map(|option| GableOption {
            name: keep(option.name),
            help: keep(option.help),
            default_value: option.default.map_or(std::ptr::null(), &mut keep),
            is_list: option.is_list.into(),
            is_required: option.is_required.into(),
        });
        let options = options.collect();
        Self { options, _texts: texts }
    }
}

/// The options of the stage `writers.lod2` of `gable pipeline`, for a program with pipelines of its own; those that all
/// stages have, such as "where", are not among them. *count becomes their number. They are never freed.
///
/// # Safety
/// `count` is null or may be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn gable_writer_options(count: *mut usize) -> *const GableOption {
    static TABLE: OnceLock<Table> = OnceLock::new();
    let options = &TABLE.get_or_init(Table::new).options;
    if !count.is_null() && count.is_aligned() {
        // SAFETY: not null, aligned, and the caller vouches that it may be written to.
        unsafe { count.write(options.len()) };
    }
    options.as_ptr()
}

/// As gable_create, for a stage of another program's pipeline: options has the members that gable_writer_options tells, with
/// the same checks and the same words as in `gable pipeline`. "filename" is required, and "footprints" or "no_footprint". A
/// file of that name is refused at once unless "overwrite" says otherwise. "crs" goes before the crs of the points. The points
/// that are pushed wait beside the file that is to be written.
///
/// # Safety
/// `options` and `crs` are null or end with a zero, and `job` is null or may be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn gable_create_writer(
    options: *const c_char,
    crs: *const c_char,
    job: *mut *mut GableJob,
) -> GableStatus {
    // SAFETY: the caller vouches for the texts and for the place of the job.
    unsafe {
        make(job, |created| {
            let (options, crs) = (from_c(options, "options")?, from_c(crs, "crs")?);
            let job = hosted_job(options.unwrap_or_default(), POINTS.as_ref())?;
            created.set_up_writer(job, crs, |job| feed(job, POINTS.as_ref()))
        })
    }
}
