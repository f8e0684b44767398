//! The options that choose the field.

use std::path::PathBuf;

use clap::ValueEnum;
use clap::builder::PossibleValue;

use crate::network::{Field, FieldOptions};
use crate::reconstruct::occupancy::CellRule;

/// Which implicit field, and from where.
#[derive(Debug, Clone, clap::Args)]
#[command(next_help_heading = "Field")]
pub struct FieldArgs {
    /// What says how much each cell is inside
    #[arg(long, value_enum, default_value_t = Field::default())]
    field: Field,
    /// Use this network, exported by training/train.py, instead of the embedded one
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// Run the network with this library of ONNX Runtime (libonnxruntime.so) instead of the embedded runtime
    #[arg(long, value_name = "LIBRARY")]
    onnxruntime: Option<PathBuf>,
    /// How a network's answers at the samples of a cell become its occupancy
    #[arg(long, value_enum, default_value_t = CellRule::default(), hide_short_help = true)]
    cell_rule: CellRule,
}

impl From<FieldArgs> for FieldOptions {
    fn from(args: FieldArgs) -> Self {
        Self { field: args.field, model: args.model, onnxruntime: args.onnxruntime, cell_rule: args.cell_rule }
    }
}

impl ValueEnum for Field {
    fn value_variants<'a>() -> &'a [Self] {
        &Self::ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        let help = match self {
            Self::Neural => "the network of this project",
            Self::HeightField => "the vote of the roof evidence; fastest, knows no overhangs",
            Self::Points2Surf => "the network of the paper at reduced width; slow, for comparison",
        };
        Some(PossibleValue::new(self.name()).help(help))
    }
}

impl ValueEnum for CellRule {
    fn value_variants<'a>() -> &'a [Self] {
        &[Self::Mean, Self::Paper]
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(match self {
            Self::Mean => PossibleValue::new("mean").help("mean probability of samples in the whole cell"),
            Self::Paper => PossibleValue::new("paper").help("sigmoid of signed distance times volume, for comparison"),
        })
    }
}
