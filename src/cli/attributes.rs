//! The options that choose which attributes are written.

use crate::sink::{AttributeOptions, Names, PREFIX, own_names, prefix};

/// Which attributes, and what gable's own are called.
#[derive(Debug, Clone, clap::Args)]
#[command(next_help_heading = "Attributes")]
pub struct AttributeArgs {
    /// Which of gable's own attributes are written: names with or without their prefix, or patterns such as "height_*",
    /// parted by commas; "none" writes none of them [default: all]
    #[arg(long, value_name = "NAMES", value_parser = own_names)]
    attributes: Option<Names>,

    /// What the names of gable's own attributes begin with; "" for nothing
    #[arg(long, value_name = "PREFIX", default_value = PREFIX, value_parser = prefix)]
    attribute_prefix: String,

    /// Which attributes of the footprints are kept: names or patterns, parted by commas; "none" keeps none [default: all]
    #[arg(long, value_name = "NAMES", conflicts_with = "no_footprint")]
    footprint_attributes: Option<Names>,
}

impl From<AttributeArgs> for AttributeOptions {
    fn from(args: AttributeArgs) -> Self {
        Self {
            own: args.attributes.unwrap_or_default(),
            prefix: args.attribute_prefix,
            source: args.footprint_attributes.unwrap_or_default(),
        }
    }
}
