//! The conditions of a trial: each changes one thing of a clean airborne scan.

use serde::{Serialize, Serializer};

use crate::simulate::{ScanOptions, SetupChoice, Span};

/// A condition under which buildings are scanned: a column of the table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Column {
    /// Positions on a sphere around the building, which has no footprint.
    FullView,
    /// Positions on the upper half of a sphere around the building, which has no footprint.
    NoBottom,
    /// Airborne, 1 pulse per m² of ground.
    Airborne1,
    /// 5 pulses per m².
    Airborne5,
    /// 10 pulses per m²: what the columns below start from; its noise is 0.
    Airborne10,
    /// 20 pulses per m².
    Airborne20,
    /// 50 pulses per m².
    Airborne50,
    /// No wall gives a point.
    WallsMissing,
    /// 10 % of the points on roofs are missing, in holes of 0.5 to 3 m radius.
    RoofMissing,
    /// Noise with a standard deviation of 0.001 R along each axis; R is the largest side of the building's box.
    Noise0001,
    /// 0.005 R.
    Noise0005,
    /// 0.01 R.
    Noise001,
    /// 0.05 R.
    Noise005,
    /// [`Self::FullView`] with noise of 0.005 R.
    FullViewNoise0005,
    /// [`Self::FullView`] with noise of 0.05 R.
    FullViewNoise005,
    /// [`Self::NoBottom`] with noise of 0.005 R.
    NoBottomNoise0005,
    /// [`Self::NoBottom`] with noise of 0.05 R.
    NoBottomNoise005,
    /// All that goes wrong with airborne scans at once, drawn as for training.
    Everything,
    /// Generated buildings with overhangs or arcades, scanned as [`Self::FullView`].
    OverhangsFullView,
    /// Generated buildings with overhangs or arcades, scanned as [`Self::NoBottom`].
    OverhangsNoBottom,
}

impl Column {
    /// All, in the order of the table.
    pub const ALL: [Self; 20] = [
        Self::FullView,
        Self::NoBottom,
        Self::Airborne1,
        Self::Airborne5,
        Self::Airborne10,
        Self::Airborne20,
        Self::Airborne50,
        Self::WallsMissing,
        Self::RoofMissing,
        Self::Noise0001,
        Self::Noise0005,
        Self::Noise001,
        Self::Noise005,
        Self::FullViewNoise0005,
        Self::FullViewNoise005,
        Self::NoBottomNoise0005,
        Self::NoBottomNoise005,
        Self::Everything,
        Self::OverhangsFullView,
        Self::OverhangsNoBottom,
    ];

    /// Its name in options, tables and reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::FullView => "full-view",
            Self::NoBottom => "no-bottom",
            Self::Airborne1 => "airborne-1",
            Self::Airborne5 => "airborne-5",
            Self::Airborne10 => "airborne-10",
            Self::Airborne20 => "airborne-20",
            Self::Airborne50 => "airborne-50",
            Self::WallsMissing => "walls-missing",
            Self::RoofMissing => "roof-missing",
            Self::Noise0001 => "noise-0.001",
            Self::Noise0005 => "noise-0.005",
            Self::Noise001 => "noise-0.01",
            Self::Noise005 => "noise-0.05",
            Self::FullViewNoise0005 => "full-view-noise-0.005",
            Self::FullViewNoise005 => "full-view-noise-0.05",
            Self::NoBottomNoise0005 => "no-bottom-noise-0.005",
            Self::NoBottomNoise005 => "no-bottom-noise-0.05",
            Self::Everything => "everything",
            Self::OverhangsFullView => "overhangs-full-view",
            Self::OverhangsNoBottom => "overhangs-no-bottom",
        }
    }

    /// Whether it is about generated buildings with overhangs only.
    pub fn needs_overhangs(self) -> bool {
        matches!(self, Self::OverhangsFullView | Self::OverhangsNoBottom)
    }

    /// How its scans are made.
    pub fn options(self) -> ScanOptions {
        let clean = ScanOptions::clean();
        let density = |pulses: f64| ScanOptions { density: Span::fixed(pulses), ..clean.clone() };
        let noise = |share: f64| ScanOptions { noise: Span::fixed(share), ..clean.clone() };
        let single = |setup, share: f64| ScanOptions { setup, footprint: 0.0, neighbours: 0.0, ..noise(share) };
        match self {
            Self::FullView | Self::OverhangsFullView => single(SetupChoice::FullView, 0.0),
            Self::NoBottom | Self::OverhangsNoBottom => single(SetupChoice::NoBottom, 0.0),
            Self::Airborne1 => density(1.0),
            Self::Airborne5 => density(5.0),
            Self::Airborne10 => clean,
            Self::Airborne20 => density(20.0),
            Self::Airborne50 => density(50.0),
            Self::WallsMissing => ScanOptions { walls_missing: Span::fixed(1.0), ..clean },
            Self::RoofMissing => ScanOptions { roof_missing: Span::fixed(0.1), ..clean },
            Self::Noise0001 => noise(0.001),
            Self::Noise0005 => noise(0.005),
            Self::Noise001 => noise(0.01),
            Self::Noise005 => noise(0.05),
            Self::FullViewNoise0005 => single(SetupChoice::FullView, 0.005),
            Self::FullViewNoise005 => single(SetupChoice::FullView, 0.05),
            Self::NoBottomNoise0005 => single(SetupChoice::NoBottom, 0.005),
            Self::NoBottomNoise005 => single(SetupChoice::NoBottom, 0.05),
            Self::Everything => ScanOptions { setup: SetupChoice::Airborne, footprint: 1.0, ..ScanOptions::training() },
        }
    }
}

impl Serialize for Column {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}
