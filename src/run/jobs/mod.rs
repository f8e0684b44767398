//! A run in several jobs, on as many machines: planned, done job by job, and joined.
//!
//! [`make`] opens the tiles and reads the footprints, divides these into jobs of about the same cost, and writes a
//! [plan](JobPlan) into a folder: all options of the run, the tiles, and for each job a file of its footprints with those
//! beside them. [`do_job`] does one of them and leaves a *part*, which holds its buildings as the method returned them, bit for
//! bit. [`merge`] joins the parts: it gives each building to the same sinks in the same order as one run would, and so
//! writes the same bytes, whatever the number of jobs.
//!
//! Nobody here starts a job: that is what Dask, Ray, Slurm, Kubernetes and the like are for. A job that is done again does
//! nothing; one that was killed goes on where it was.
//!
//! What could differ from one run, and why it does not:
//!
//! - *Sites*: a job gets the footprints [beside](crate::segment::Company) its own and all tiles that any of them needs. Of
//!   the other tiles it knows where they lie, for the seams between tiles.
//! - *Ids, repairs, the filter, the CRS, which features are rejected*: settled in the plan, where all footprints are read
//!   once. A feature without a usable polygon is in exactly one job.
//! - *Ids of building parts, the corner of the model, files by tile or id, the order*: settled by [`merge`], which knows all.
//! - *What does not occur in a share*, such as points of the building classes: no fault of a job. [`merge`] refuses what
//!   occurs in none.
//!
//! A tile that is damaged, or has points outside the box in its header, shows this only where it is read: there the share of a
//! footprint that tiles cover may differ from that of one run.

mod cost;
mod file;
mod folder;
mod join;
mod make;
mod part;
mod share;
mod shelf;
mod split;
#[cfg(test)]
mod tests;
mod work;

pub use file::{JobPlan, Options, PlannedCloud, PlannedJob, PlannedTile, schema};
pub use folder::PlanFolder;
pub use join::{Merge, merge};
pub use make::make;
pub use shelf::{missing, ranges};
pub use split::Split;
pub use work::{JobRun, Outcome, do_job};
