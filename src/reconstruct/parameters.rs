//! The parameters of the method.

use serde::{Deserialize, Serialize};

/// All parameters of the method, metric whatever the units of the CRS.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Parameters {
    /// How planar primitives are detected.
    pub detector: Detector,
}

/// How planar primitives are detected.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Detector {
    /// Region growing on estimated normals.
    RegionGrowing,
    /// Efficient RANSAC (Schnabel et al. 2007).
    Ransac,
}

impl Default for Parameters {
    fn default() -> Self {
        Self { detector: Detector::RegionGrowing }
    }
}
