//! Footprints.
use geo::MultiPolygon;
use serde_json::{Map, Value};
/// One footprint with usable geometry.
#[derive(Debug, Clone)]
pub struct Footprint {
    /// The id as text, exactly as it stands in the file; unique within the layer.
    pub id: String,
    /// Valid by the simple-feature rules, exteriors counter-clockwise, z dropped; in the coordinates of the layer's CRS.
    pub polygon: MultiPolygon<f64>,
    /// All attributes.
    pub attributes: Map<String, Value>,
    /// What was repaired or made up, one sentence each.
    pub notes: Vec<String>,
}
