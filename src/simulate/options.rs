//! How a scan is made, and what goes wrong with it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::span::Span;

/// Where the scanner stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Setup {
    /// On a sphere around the building, below it too.
    FullView,
    /// On the upper half of a sphere around the building, which stands on the ground.
    NoBottom,
    /// In aircraft that fly straight strips.
    Airborne,
    /// In aircraft, with cameras that look down and obliquely; pictures are matched.
    Photographs,
}

impl Setup {
    /// All, in the order of the numbers that shards have for them.
    pub const ALL: [Self; 4] = [Self::FullView, Self::NoBottom, Self::Airborne, Self::Photographs];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::FullView => "full-view",
            Self::NoBottom => "no-bottom",
            Self::Airborne => "airborne",
            Self::Photographs => "photographs",
        }
    }
}

/// Which set-up a scan has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SetupChoice {
    /// Positions on a sphere around the building.
    FullView,
    /// Positions on the upper half of a sphere.
    NoBottom,
    /// Flight strips.
    Airborne,
    /// Image matching of vertical and oblique pictures.
    Photographs,
    /// 8 scans of 10 airborne, one full-view, one no-bottom.
    Mixed,
}

/// How a scan is made, and what goes wrong with it. Of a [`Span`] every scan draws its own value; lengths are metres,
/// shares and chances are 0 to 1. R is the largest side of the building's box.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ScanOptions {
    /// Where the scanner stands.
    pub setup: SetupChoice,
    /// Airborne: pulses per m² of ground, all strips together; otherwise points per m² of the building's surface.
    pub density: Span,
    /// Most points that a scan has: of large buildings the density is lower.
    #[schemars(range(min = 16, max = 1_000_000))]
    pub most_points: u32,
    /// Standard deviation of the noise along each axis, as a share of R.
    pub noise: Span,
    /// Airborne: number of flight strips.
    pub strips: Span,
    /// Airborne: angle of the pulses across the strip, degrees from the vertical.
    pub scan_angle: Span,
    /// Airborne: angle of the pulses along the strip, forwards or backwards, degrees from the vertical.
    pub look_angle: Span,
    /// Airborne: height above ground.
    pub altitude: Span,
    /// Standard deviation of the height of a strip.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub strip_height: f64,
    /// Standard deviation of the position of a strip along x and y.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub strip_shift: f64,
    /// Photographs: standard deviation of the waves of a matched surface, along the line of sight.
    pub ripples: Span,
    /// Photographs: length of these waves.
    pub ripple_length: Span,
    /// Photographs: share of the points that is missing where there is no texture.
    pub texture_missing: Span,
    /// Photographs: height above ground below which walls are hidden more and more.
    pub blind_height: Span,
    /// Chance that the buildings around are there (never full-view).
    #[schemars(range(min = 0.0, max = 1.0))]
    pub neighbours: f64,
    /// Chance that trees stand beside or over the building (never full-view).
    #[schemars(range(min = 0.0, max = 1.0))]
    pub tree_chance: f64,
    /// Number of trees where there are any.
    pub trees: Span,
    /// Share of the pulses that a tree stops.
    pub tree_opacity: Span,
    /// Chance that the roof has holes.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub hole_chance: f64,
    /// Number of holes where there are any.
    pub holes: Span,
    /// Radius of a hole.
    pub hole_radius: Span,
    /// Chance that a larger part of the roof is missing.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub missing_chance: f64,
    /// Share of the roof's points that is missing then, in holes.
    pub roof_missing: Span,
    /// Share of the walls that give no points, whatever the geometry.
    pub walls_missing: Span,
    /// Share of the pulses that do not come back.
    pub dropped: Span,
    /// Share of the pulses that come back too late, from below the surface, by reflection.
    pub ghosts: Span,
    /// Outliers within 2 m of the building's box, as a share of its points.
    pub outliers: Span,
    /// Share of the points of neighbours in the footprint that are taken for building.
    pub stray_neighbours: Span,
    /// Share of the ground points in the footprint that are taken for building.
    pub stray_ground: Span,
    /// Share of the tree points over the footprint that are taken for building.
    pub stray_vegetation: Span,
    /// Chance that the building has a footprint.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub footprint: f64,
    /// How far the footprint is displaced.
    pub footprint_shift: Span,
    /// Standard deviation of the known height of the ground.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub ground_error: f64,
}

impl ScanOptions {
    /// What networks are trained on: everything that goes wrong with airborne scans, in the amounts in which it does among
    /// the building points of a cloud that is classified (`training/SCANS.md`).
    pub fn training() -> Self {
        Self {
            setup: SetupChoice::Mixed,
            density: Span::new(1.0, 60.0),
            most_points: 20_000,
            noise: Span::new(0.0, 0.005),
            strips: Span::new(1.0, 3.0),
            scan_angle: Span::new(0.0, 30.0),
            look_angle: Span::new(0.0, 12.0),
            altitude: Span::new(300.0, 1500.0),
            strip_height: 0.03,
            strip_shift: 0.05,
            ripples: Span::new(0.0, 0.1),
            ripple_length: Span::new(1.0, 4.0),
            texture_missing: Span::new(0.0, 0.9),
            blind_height: Span::new(0.0, 3.0),
            neighbours: 0.8,
            tree_chance: 0.35,
            trees: Span::new(1.0, 3.0),
            tree_opacity: Span::new(0.4, 1.0),
            hole_chance: 0.3,
            holes: Span::new(1.0, 3.0),
            hole_radius: Span::new(0.5, 3.0),
            missing_chance: 0.1,
            roof_missing: Span::new(0.05, 0.3),
            walls_missing: Span::new(0.0, 1.0),
            dropped: Span::new(0.0, 0.1),
            ghosts: Span::new(0.0, 0.001),
            outliers: Span::new(0.0, 0.002),
            stray_neighbours: Span::new(0.0, 0.1),
            stray_ground: Span::new(0.0, 0.03),
            stray_vegetation: Span::new(0.0, 0.03),
            footprint: 0.85,
            footprint_shift: Span::new(0.0, 0.5),
            ground_error: 0.2,
        }
    }

    /// A scan in which nothing goes wrong: airborne, 10 pulses per m², two strips up to 20° off the vertical, no noise,
    /// neighbours where there are any. What is to be evaluated is set one by one.
    pub fn clean() -> Self {
        let none = Span::fixed(0.0);
        Self {
            setup: SetupChoice::Airborne,
            density: Span::fixed(10.0),
            most_points: 200_000,
            noise: none,
            strips: Span::fixed(2.0),
            scan_angle: Span::new(0.0, 20.0),
            look_angle: none,
            altitude: Span::fixed(800.0),
            strip_height: 0.0,
            strip_shift: 0.0,
            ripples: none,
            ripple_length: Span::fixed(2.0),
            texture_missing: none,
            blind_height: none,
            neighbours: 1.0,
            tree_chance: 0.0,
            trees: Span::fixed(1.0),
            tree_opacity: Span::fixed(1.0),
            hole_chance: 0.0,
            holes: Span::fixed(1.0),
            hole_radius: Span::new(0.5, 3.0),
            missing_chance: 1.0,
            roof_missing: none,
            walls_missing: none,
            dropped: none,
            ghosts: none,
            outliers: none,
            stray_neighbours: Span::fixed(1.0),
            stray_ground: none,
            stray_vegetation: none,
            footprint: 1.0,
            footprint_shift: none,
            ground_error: 0.0,
        }
    }
}

impl Default for ScanOptions {
    /// Those for training.
    fn default() -> Self {
        Self::training()
    }
}
