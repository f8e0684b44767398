//! What is most likely wrong with a `CityObject` that the schema refuses: it says no more than that none of its
//! alternatives fits.

use serde_json::{Map, Value};

/// The types that stand for themselves, and those that need a parent (CityJSON 1.0 to 2.0).
const FIRST: [&str; 17] = [
    "Bridge",
    "Building",
    "CityObjectGroup",
    "CityFurniture",
    "GenericCityObject",
    "LandUse",
    "OtherConstruction",
    "PlantCover",
    "SolitaryVegetationObject",
    "TINRelief",
    "TransportSquare",
    "Railway",
    "Road",
    "Tunnel",
    "WaterBody",
    "Waterway",
    "BuildingComplex",
];
const SECOND: [&str; 17] = [
    "BridgePart",
    "BridgeInstallation",
    "BridgeConstructiveElement",
    "BridgeConstructionElement",
    "BridgeRoom",
    "BridgeFurniture",
    "BuildingPart",
    "BuildingInstallation",
    "BuildingConstructiveElement",
    "BuildingFurniture",
    "BuildingStorey",
    "BuildingRoom",
    "BuildingUnit",
    "TunnelPart",
    "TunnelInstallation",
    "TunnelConstructiveElement",
    "TunnelHollowSpace",
];
/// Needs a parent as well.
const THIRD: &str = "TunnelFurniture";
/// The types of semantic surfaces.
const SURFACES: [&str; 19] = [
    "RoofSurface",
    "GroundSurface",
    "WallSurface",
    "ClosureSurface",
    "OuterCeilingSurface",
    "OuterFloorSurface",
    "Window",
    "Door",
    "InteriorWallSurface",
    "CeilingSurface",
    "FloorSurface",
    "WaterSurface",
    "WaterGroundSurface",
    "WaterClosureSurface",
    "TrafficArea",
    "AuxiliaryTrafficArea",
    "TransportationMarking",
    "TransportationHole",
    "Address",
];

/// What is wrong with an object, one phrase each; none where it is nothing usual.
pub(super) fn of(object: &Map<String, Value>) -> Vec<String> {
    let mut hints = Vec::new();
    let kind = object.get("type").and_then(Value::as_str).unwrap_or_default();
    let is_child = SECOND.contains(&kind) || kind == THIRD;
    if !FIRST.contains(&kind) && !is_child && !kind.starts_with('+') {
        hints.push(format!("its type {kind:?} is none of CityJSON"));
    }
    let parents = object.get("parents").and_then(Value::as_array);
    if is_child && parents.is_none_or(Vec::is_empty) {
        hints.push(format!("a {kind} needs \"parents\""));
    }
    for geometry in object.get("geometry").and_then(Value::as_array).into_iter().flatten() {
        match geometry.get("lod") {
            Some(Value::String(_)) => {}
            Some(lod) => hints.push(format!("\"lod\" is {lod}, not text")),
            None if geometry.get("template").is_none() => hints.push("a geometry has no \"lod\"".to_owned()),
            None => {}
        }
        let surfaces = geometry.pointer("/semantics/surfaces").and_then(Value::as_array).into_iter().flatten();
        for kind in surfaces.map(|surface| surface.get("type").and_then(Value::as_str).unwrap_or_default()) {
            if !SURFACES.contains(&kind) && !kind.starts_with('+') {
                hints.push(format!("the surface type {kind:?} is none of CityJSON"));
            }
        }
    }
    hints.dedup();
    hints
}
