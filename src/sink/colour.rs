//! The colours of semantic surfaces, the same in every format.

/// The colour of a class: red, green and blue from 0 to 1, sRGB.
pub(super) fn colour(class: &str) -> [f64; 3] {
    match class {
        "RoofSurface" => [0.78, 0.27, 0.22],
        "WallSurface" | "InteriorWallSurface" => [0.87, 0.84, 0.78],
        "GroundSurface" | "FloorSurface" | "OuterFloorSurface" => [0.45, 0.42, 0.38],
        "OuterCeilingSurface" | "CeilingSurface" => [0.62, 0.58, 0.54],
        "Window" => [0.45, 0.62, 0.78],
        "Door" => [0.5, 0.33, 0.2],
        "TINRelief" | "LandUse" | "PlantCover" | "SolitaryVegetationObject" => [0.47, 0.63, 0.36],
        "WaterBody" | "WaterSurface" | "WaterGroundSurface" => [0.36, 0.55, 0.78],
        "Road" | "Railway" | "TransportSquare" | "TrafficArea" | "AuxiliaryTrafficArea" => [0.55, 0.55, 0.57],
        _ => [0.72, 0.72, 0.72],
    }
}
