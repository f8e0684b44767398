//! What counts as building and as ground, and how far to look.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

/// Noise classes of the ASPRS (low point, high noise); never used.
pub const NOISE: [u8; 2] = [7, 18];
/// Classes that say for certain that a point is not of a building: vegetation, water, rail, road surface, wires and
/// transmission towers (LAS 1.4 R15, table 17).
pub(super) const NEVER_BUILDING: [u8; 10] = [3, 4, 5, 9, 10, 11, 13, 14, 15, 16];

/// The classes whose points are building points: a list such as `1,6`, or `any`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum BuildingClasses {
    /// Points of these ASPRS classes.
    Listed(Vec<u8>),
    /// For clouds that are not classified.
    Keyword(AnyClass),
}

/// Takes every class that can be a building: not ground, vegetation, water, rail, road or wires. What stands out of the
/// ground inside a footprint counts, with vegetation thinned by planarity.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum AnyClass {
    /// Every class that can be a building.
    Any,
}

impl BuildingClasses {
    /// `any`.
    pub const ANY: Self = Self::Keyword(AnyClass::Any);

    /// Whether it is `any`.
    pub fn is_any(&self) -> bool {
        *self == Self::ANY
    }
}

impl FromStr for BuildingClasses {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text.trim().eq_ignore_ascii_case("any") {
            return Ok(Self::ANY);
        }
        let parsed: Result<Vec<u8>, _> = text.split(',').map(|part| part.trim().parse()).collect();
        match parsed {
            Ok(classes) => Ok(Self::Listed(classes)),
            Err(_) => Err(format!("found '{text}', expected classes from 0 to 255 such as '1,6', or 'any'")),
        }
    }
}

impl fmt::Display for BuildingClasses {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Listed(classes) => {
                let names: Vec<String> = classes.iter().map(u8::to_string).collect();
                f.write_str(&names.join(","))
            }
            Self::Keyword(AnyClass::Any) => f.write_str("any"),
        }
    }
}

/// Which points count although they are marked as not to be used or not made by the scanner.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum UseFlagged {
    /// None of them.
    #[default]
    None,
    /// Synthetic points.
    Synthetic,
    /// Withheld points.
    Withheld,
    /// Both.
    Both,
}

impl UseFlagged {
    /// Whether a point with these flags counts.
    pub fn takes(self, withheld: bool, synthetic: bool) -> bool {
        (!withheld || matches!(self, Self::Withheld | Self::Both))
            && (!synthetic || matches!(self, Self::Synthetic | Self::Both))
    }
}

/// Which height of the ground is the floor of a building.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum GroundLevel {
    /// The low side of the ground along the outline: the building stands in a slope.
    #[default]
    Lowest,
    /// The median height of the ground along the outline.
    Median,
    /// The height of the plane through the ground around at the centre of the footprint.
    Plane,
}

/// What heights that the user states are counted from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum HeightAbove {
    /// The zero of the heights of the points: sea level, mostly.
    #[default]
    Datum,
    /// The floor of the building.
    Ground,
}

/// How tiles and footprints become sites. All lengths are metres, whatever the unit of the CRS.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct SegmentOptions {
    /// Classes of building points: a list, or `any` for clouds that are not classified.
    pub building_classes: BuildingClasses,
    /// Classes of ground points.
    pub ground_classes: Vec<u8>,
    /// Which points count although they are marked as synthetic or withheld.
    pub use_flagged: UseFlagged,
    /// Width of the ring around a footprint in which the ground is looked for, metres.
    pub ring_width: f64,
    /// Where too little ground is found, the ring is widened up to this width, metres.
    pub ring_limit: f64,
    /// How much ground is enough, square metres that hold a ground point.
    pub ring_area: u32,
    /// Which height of the ground along the outline of a footprint is its floor.
    pub ground: GroundLevel,
    /// With `lowest`: the floor is this percentile of the height of the ground along the outline: of a surface without the
    /// noise of its points, so that it is the ground itself where that is flat. Low, so that the walls of a building on a
    /// slope reach down to the terrain at its lowest side; not the minimum, which is any cellar stair's.
    pub ground_percentile: f64,
    /// Attribute of the footprints that holds the height of the floor, in the vertical unit of the CRS of the points; it goes
    /// before a terrain model and the points. Where it holds no number the floor comes from these, with a note.
    pub ground_attribute: Option<String>,
    /// Attribute of the footprints that holds the height of the roof, in the vertical unit of the CRS of the points: a
    /// building without points on its roof becomes a block of this height instead of a footprint.
    pub roof_height_attribute: Option<String>,
    /// What the heights of `roof_height_attribute` are counted from.
    pub roof_height_above: HeightAbove,
    /// Terrain model from which the height of the ground is taken: a GeoTIFF, a folder of such or a glob pattern, in any
    /// CRS, their heights in the vertical system of the points; where sheets lie over each other the finest that has a
    /// height counts. It goes before the points; where it has no height they are asked.
    pub dtm: Option<PathBuf>,
    /// Of several point clouds: one with fewer building points per square metre of a footprint than this is too thin for it,
    /// and the next is looked at.
    pub cloud_density: f64,
    /// Of several point clouds: one that leaves a larger share of a footprint than this (0 to 1) farther than 1 m from any
    /// building point is too thin for it.
    pub cloud_no_data: f64,
    /// Attribute of the footprints that holds the year in which the building was built: no point cloud of an earlier year is
    /// taken for it.
    pub year_attribute: Option<String>,
    /// With `any`: points lower than this above the ground are not building points, metres.
    pub least_height: f64,
    /// With `any`: a point is vegetation when neither it nor a neighbour of it lies in a flat neighbourhood: one whose
    /// smallest variance is at most this share of the whole.
    pub flatness: f64,
    /// A handful of points this high above everything around them is not part of the building, metres.
    pub hover_gap: f64,
    /// Width of the band along the footprint's edges into which a higher neighbour's wall and roof may reach, metres.
    pub party_wall_band: f64,
    /// A point in that band this high above the highest point further inside is the neighbour's, metres.
    pub party_wall_rise: f64,
}

impl Default for SegmentOptions {
    fn default() -> Self {
        Self {
            building_classes: BuildingClasses::Listed(vec![6]),
            ground_classes: vec![2],
            use_flagged: UseFlagged::None,
            ring_width: 3.0,
            ring_limit: 24.0,
            ring_area: 12,
            ground: GroundLevel::Lowest,
            ground_percentile: 5.0,
            ground_attribute: None,
            roof_height_attribute: None,
            roof_height_above: HeightAbove::Datum,
            dtm: None,
            cloud_density: 1.0,
            cloud_no_data: 0.3,
            year_attribute: None,
            least_height: 1.5,
            flatness: 0.03,
            hover_gap: 3.0,
            party_wall_band: 0.5,
            party_wall_rise: 1.5,
        }
    }
}
