//! What a model of a building comes to, to be compared with the one before.

use serde::Serialize;

use crate::building::Building;

/// The figures of a model. Lengths are metres, areas square metres, volumes cubic metres.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Figures {
    /// The highest level of detail that was reached: 2.2, 1.2, 0 or nothing.
    pub lod: &'static str,
    /// Why LoD 2.2 of the whole building was not reached.
    pub failure: Option<String>,
    /// Number of solids at LoD 2.2. Each is valid: nothing else is made.
    pub solids: usize,
    /// Number of faces at LoD 2.2.
    pub faces: usize,
    /// Number of roof planes.
    pub roof_planes: Option<usize>,
    /// Root mean square of the distances of the building points to the model.
    pub rmse: Option<f64>,
    /// Volume at LoD 2.2.
    pub volume: Option<f64>,
    /// What is scanned and not modelled.
    pub missing: Option<f64>,
    /// What is modelled and not scanned.
    pub excess: Option<f64>,
    /// How far the model can be trusted, 0 to 1.
    pub confidence: Option<f64>,
    /// The height of the floor, CRS units.
    pub floor: Option<f64>,
}

impl Figures {
    /// Those of a building.
    pub fn of(building: &Building) -> Self {
        let Building { measures, frame, model, outcome, .. } = building;
        let floor = |height: f64| frame.origin[2] + height / frame.metres_per_unit[2];
        Self {
            lod: outcome.lod().unwrap_or_default(),
            failure: outcome.reason().map(|(_, detail)| detail.to_owned()),
            solids: model.lod22().count(),
            faces: model.lod22().map(|solid| solid.faces.len()).sum(),
            roof_planes: measures.roof_planes,
            rmse: measures.rmse_lod22,
            volume: measures.volume_lod22,
            missing: measures.completeness.as_ref().map(|extents| extents.missing.area),
            excess: measures.completeness.as_ref().map(|extents| extents.excess.area),
            confidence: measures.confidence,
            floor: measures.ground.map(|ground| floor(ground.height)),
        }
    }
}
