//! The folder of a plan: `plan.json`, `jobs/K.jsonl` with the footprints of each job, and `parts/`.

use std::fs;
use std::path::{Path, PathBuf};

use super::file::{JobPlan, LAYOUT};
use super::share::{Share, ShareLine};
use crate::error::{Error, InputError, Result};
use crate::sink::{write_json, write_whole};

/// The plan's file.
const FILE: &str = "plan.json";
/// The folder of the files of footprints.
const JOBS: &str = "jobs";
/// The folder of the parts.
const PARTS: &str = "parts";

/// The folder of a plan.
#[derive(Debug, Clone)]
pub struct PlanFolder {
    path: PathBuf,
}

impl PlanFolder {
    /// The folder at `path`.
    pub fn new(path: impl Into<PathBuf>) -> Self {
        Self { path: path.into() }
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Where parts go unless the user says otherwise.
    pub fn parts(&self) -> PathBuf {
        self.path.join(PARTS)
    }

    /// Makes room for a plan: the folder is made, or what an earlier plan has left in it goes.
    ///
    /// # Errors
    /// There is a plan and `overwrite` is off, or something else than a plan.
    pub(super) fn prepare(&self, overwrite: bool) -> Result<()> {
        let is_plan = self.file().is_file();
        let is_used = self.path.is_file() || fs::read_dir(&self.path).is_ok_and(|mut entries| entries.next().is_some());
        if is_used && !is_plan {
            let fault = InputError::new(&self.path, "something else than a plan", "a folder for a plan");
            return Err(fault.remedy("Give the name of a folder that does not exist yet").into());
        }
        if is_plan && !overwrite {
            let fault = InputError::new(&self.path, "a plan", "nothing, so that no part of it is lost");
            return Err(fault.remedy("Give --overwrite to replace it with its parts, or another folder").into());
        }
        if is_plan {
            // Without its file the rest is no plan: whatever happens, no half of two plans is taken for one.
            fs::remove_file(self.file()).map_err(|e| Error::io(self.file(), "remove", e))?;
            for folder in [JOBS, PARTS].map(|name| self.path.join(name)) {
                if folder.is_dir() {
                    fs::remove_dir_all(&folder).map_err(|e| Error::io(&folder, "remove", e))?;
                }
            }
        }
        let jobs = self.path.join(JOBS);
        fs::create_dir_all(&jobs).map_err(|e| Error::io(&jobs, "create", e))
    }

    /// Writes the footprints of a job; the checksum of the file.
    ///
    /// # Errors
    /// The system refuses.
    pub(super) fn write_share(&self, job: usize, lines: impl Iterator<Item = ShareLine>) -> Result<String> {
        let path = self.share(job);
        let (bytes, checksum) = super::share::encoded(lines).map_err(|e| Error::io(&path, "write", e.into()))?;
        write_whole(&path, &bytes)?;
        Ok(checksum)
    }

    /// Writes the plan itself, when all else is there.
    ///
    /// # Errors
    /// The system refuses.
    pub(super) fn write(&self, plan: &JobPlan) -> Result<()> {
        write_json(&self.file(), plan)
    }

    /// Reads the plan.
    ///
    /// # Errors
    /// There is none, it is damaged or was changed, or another version of gable made it.
    pub fn read(&self) -> Result<JobPlan> {
        let path = self.file();
        let text = fs::read(&path).map_err(|e| Error::io(&path, "read", e))?;
        let no_plan = |found: String| {
            let fault = InputError::new(&path, found, "a plan that `gable plan` made");
            fault.remedy("Make it anew with `gable plan`")
        };
        let value: serde_json::Value = serde_json::from_slice(&text).map_err(|e| no_plan(e.to_string()))?;
        let made_by = value["gable"].as_str().unwrap_or("another program").to_owned();
        let own = env!("CARGO_PKG_VERSION");
        if made_by != own || value["layout"] != LAYOUT {
            let fault = InputError::new(&path, format!("a plan of gable {made_by}"), format!("one of gable {own}"));
            return Err(fault.remedy("Use the same version for the plan, all of its jobs and joining them").into());
        }
        let plan: JobPlan = serde_json::from_value(value).map_err(|e| no_plan(e.to_string()))?;
        let identity = plan.identify().map_err(|e| no_plan(e.to_string()))?;
        if identity != plan.identity {
            let found = "a plan that was changed after it was made".to_owned();
            return Err(no_plan(found).into());
        }
        Ok(plan)
    }

    /// Reads the footprints of a job.
    ///
    /// # Errors
    /// There is no such job, or the file is not the one that the plan was made with.
    pub(super) fn read_share(&self, plan: &JobPlan, job: usize) -> Result<Share> {
        let Some(planned) = plan.jobs.get(job) else {
            let found = format!("no job {job}");
            let last = plan.jobs.len().saturating_sub(1);
            return Err(InputError::new(self.file(), found, format!("one from 0 to {last}")).at("--job").into());
        };
        let path = self.share(job);
        let bytes = fs::read(&path).map_err(|e| Error::io(&path, "read", e))?;
        let share = super::share::decoded(&bytes, &planned.checksum);
        share.ok_or_else(|| {
            let fault = InputError::new(&path, "other bytes than those of the plan", "the footprints of the plan");
            fault.remedy("It is damaged or of another plan: copy the folder again, or make the plan anew").into()
        })
    }

    fn file(&self) -> PathBuf {
        self.path.join(FILE)
    }

    fn share(&self, job: usize) -> PathBuf {
        self.path.join(JOBS).join(format!("{job}.jsonl"))
    }
}
