//! The options that say how coordinates without a CRS are meant.

use clap::ValueEnum;
use clap::builder::PossibleValue;

use crate::source::points::{Unit, UpAxis};

impl ValueEnum for Unit {
    fn value_variants<'a>() -> &'a [Self] {
        &Self::ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        let (name, help) = self.name();
        Some(PossibleValue::new(name).help(help))
    }
}

impl ValueEnum for UpAxis {
    fn value_variants<'a>() -> &'a [Self] {
        &Self::ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        let (name, help) = self.name();
        Some(PossibleValue::new(name).help(help))
    }
}
