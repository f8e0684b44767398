//! The parameters of the method.

use serde::{Deserialize, Serialize};

use super::primitives::DetectionParameters;

/// All parameters of the method, metric whatever the units of the CRS.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Parameters {
    /// How planar primitives are detected and refined.
    pub detection: DetectionParameters,
}
