//! What the terrain shall be like.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What the terrain shall be like. All lengths are metres, whatever the unit of the CRS.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct TerrainOptions {
    /// With `terrain`: how far the ground points may lie above or below the terrain, metres. The larger, the fewer and larger
    /// triangles.
    pub terrain_error: f64,
    /// With `terrain`: side of its tiles, metres, rounded to whole units of the CRS. Tiles begin at multiples of it, wherever
    /// the files end, so that those of two runs are the same.
    pub terrain_tile: f64,
    /// With `terrain`: where a circle of this width finds no ground point, metres, there is no terrain: water, or a building
    /// without a footprint. Narrower gaps are spanned.
    pub terrain_gap: f64,
}

impl Default for TerrainOptions {
    fn default() -> Self {
        Self { terrain_error: 0.15, terrain_tile: 250.0, terrain_gap: 20.0 }
    }
}
