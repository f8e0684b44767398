//! What the jobs of a run cost that was done in several.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What one of the jobs of a run cost.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct JobReport {
    /// Its number in the plan, from 0.
    pub job: usize,
    /// Number of footprints.
    pub footprints: usize,
    /// Wall time in seconds.
    pub wall_seconds: f64,
    /// Processor time in seconds, all threads; where the system tells.
    pub cpu_seconds: Option<f64>,
    /// Number of threads that reconstructed buildings.
    pub threads: usize,
    /// Most memory that its process held, in bytes; where the system tells.
    pub peak_memory_bytes: Option<u64>,
}
