//! Where the points of a cloud that names no CRS lie: how long its units are, and which of its axes is up.

/// The unit of the coordinates of a cloud.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Unit {
    /// Metres.
    #[default]
    Metre,
    /// Centimetres.
    Centimetre,
    /// Millimetres.
    Millimetre,
    /// Kilometres.
    Kilometre,
    /// Inches.
    Inch,
    /// International feet.
    Foot,
    /// US survey feet.
    UsSurveyFoot,
}

/// The axis of the coordinates that points up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum UpAxis {
    /// As surveyors have it.
    #[default]
    Z,
    /// As programs for modelling and photogrammetry have it: x stays, -z becomes y.
    Y,
    /// y becomes x, and z becomes y.
    X,
}

/// How the coordinates of a file become metres with heights along z.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Placement {
    /// Their unit.
    pub unit: Unit,
    /// The axis that is up.
    pub up: UpAxis,
}

impl Unit {
    /// All of them.
    pub const ALL: [Self; 7] =
        [Self::Metre, Self::Centimetre, Self::Millimetre, Self::Kilometre, Self::Inch, Self::Foot, Self::UsSurveyFoot];

    /// Its name as an option, that of PROJ, and what it is.
    pub fn name(self) -> (&'static str, &'static str) {
        match self {
            Self::Metre => ("m", "metres"),
            Self::Centimetre => ("cm", "centimetres"),
            Self::Millimetre => ("mm", "millimetres"),
            Self::Kilometre => ("km", "kilometres"),
            Self::Inch => ("in", "inches (0.0254 m)"),
            Self::Foot => ("ft", "international feet (0.3048 m)"),
            Self::UsSurveyFoot => ("us-ft", "US survey feet (1200/3937 m)"),
        }
    }

    /// Its length in metres.
    pub fn metres(self) -> f64 {
        match self {
            Self::Metre => 1.0,
            Self::Centimetre => 0.01,
            Self::Millimetre => 0.001,
            Self::Kilometre => 1000.0,
            Self::Inch => 0.0254,
            Self::Foot => 0.3048,
            Self::UsSurveyFoot => 1200.0 / 3937.0,
        }
    }
}

impl UpAxis {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Z, Self::Y, Self::X];

    /// Its name as an option, and what it means.
    pub fn name(self) -> (&'static str, &'static str) {
        match self {
            Self::Z => ("z", "as surveyors have it"),
            Self::Y => ("y", "as programs for modelling and photographs have it: x stays, -z becomes y"),
            Self::X => ("x", "y becomes x and z becomes y"),
        }
    }
}

impl Placement {
    /// What options say; `None` where they say nothing.
    pub fn given(unit: Option<Unit>, up: Option<UpAxis>) -> Option<Self> {
        let is_given = unit.is_some() || up.is_some();
        is_given.then(|| Self { unit: unit.unwrap_or_default(), up: up.unwrap_or_default() })
    }

    /// Whether it leaves everything as it is.
    pub fn is_identity(self) -> bool {
        self == Self::default()
    }

    /// A place of the file in metres, heights along z. A rotation and a scale: right-handed stays right-handed.
    #[inline]
    pub fn apply(self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let turned = match self.up {
            UpAxis::Z => [x, y, z],
            UpAxis::Y => [x, -z, y],
            UpAxis::X => [y, z, x],
        };
        if self.unit == Unit::Metre { turned } else { turned.map(|value| value * self.unit.metres()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix3, Vector3};

    #[test]
    fn axes_turn_and_are_never_mirrored() {
        for (up, axis) in [(UpAxis::Z, 2), (UpAxis::Y, 1), (UpAxis::X, 0)] {
            let turned = |k: usize| {
                let mut unit = [0.0; 3];
                unit[k] = 1.0;
                Vector3::from(Placement { unit: Unit::Metre, up }.apply(unit))
            };
            assert_eq!(turned(axis), Vector3::z());
            assert_eq!(Matrix3::from_columns(&[turned(0), turned(1), turned(2)]).determinant(), 1.0);
        }
        let feet = Placement { unit: Unit::Foot, up: UpAxis::Y };
        assert_eq!(feet.apply([10.0, 20.0, -100.0]), [3.048, 30.48, 6.096]);
        assert!(Placement::default().is_identity() && !feet.is_identity());
    }
}
