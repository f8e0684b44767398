//! Networks: where they come from and what runs them.
//!
//! The method asks its questions through [`Network`](crate::reconstruct::occupancy::network::Network); this module
//! answers them with ONNX graphs. The embedded runtime is written in Rust and goes into the binary, with the weights;
//! ONNX Runtime can be loaded instead where it is installed. A build without the feature `networks` has none of both, and
//! [`Field::HeightField`] is its only field.

mod file;
#[cfg(feature = "networks")]
mod onnx;
#[cfg(feature = "networks")]
mod runtime;
#[cfg(test)]
mod tests;

use std::hash::{DefaultHasher, Hash, Hasher};
#[cfg(feature = "networks")]
use std::path::Path;
use std::path::PathBuf;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::error::{InputError, Result};
#[cfg(feature = "networks")]
use crate::reconstruct::occupancy::Neural;
#[cfg(feature = "networks")]
use crate::reconstruct::occupancy::network::Interface;
use crate::reconstruct::occupancy::{CellRule, HeightField, Occupancy};
use crate::source::open;

pub use file::NetworkFile;
#[cfg(feature = "networks")]
pub use onnx::OnnxNetwork;
#[cfg(feature = "networks")]
pub use runtime::Runtime;

/// The embedded network of [`Field::Neural`].
#[cfg(feature = "networks")]
const FIELD: &[u8] = include_bytes!("weights/field.safetensors");
/// The embedded network of [`Field::Points2Surf`].
#[cfg(feature = "networks")]
const POINTS2SURF: &[u8] = include_bytes!("weights/points2surf.safetensors");

/// How messages call a network that is not in a file of its own.
#[cfg(feature = "networks")]
const EMBEDDED: &str = "the embedded network";

/// Which implicit field says how much each cell is inside.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Field {
    /// The network of this project: a code of the whole building, the nearest points, and the roof evidence.
    #[cfg_attr(feature = "networks", default)]
    Neural,
    /// The height-field vote: what lies under the roof evidence is inside. Needs no network and knows no overhangs.
    #[cfg_attr(not(feature = "networks"), default)]
    HeightField,
    /// The network of the paper, at reduced width; slow, for comparison.
    #[serde(rename = "points2surf")]
    Points2Surf,
}

impl Field {
    /// All fields.
    pub const ALL: [Self; 3] = [Self::Neural, Self::HeightField, Self::Points2Surf];

    /// Those that this build has.
    pub fn built_in() -> &'static [Self] {
        if cfg!(feature = "networks") { &Self::ALL } else { &[Self::HeightField] }
    }

    /// Its name in options and reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Neural => "neural",
            Self::HeightField => "height-field",
            Self::Points2Surf => "points2surf",
        }
    }
}

/// Which field, and from where.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct FieldOptions {
    /// Which implicit field says how much each cell is inside.
    pub field: Field,
    /// A network file to use instead of the embedded one.
    pub model: Option<PathBuf>,
    /// The library of ONNX Runtime to run networks with, instead of the embedded runtime.
    pub onnxruntime: Option<PathBuf>,
    /// How the answers at the samples of a cell become its occupancy.
    pub cell_rule: CellRule,
}

impl FieldOptions {
    /// The field, ready to be asked.
    ///
    /// # Errors
    /// Fails when the network file cannot be read, is none, or has another interface than the field, and when ONNX
    /// Runtime cannot be loaded.
    pub fn load(&self) -> Result<Arc<dyn Occupancy>> {
        if self.field != Field::HeightField {
            return self.network();
        }
        let given = [("--model", &self.model), ("--onnxruntime", &self.onnxruntime)];
        if let Some((option, _)) = given.into_iter().find(|(_, value)| value.is_some()) {
            let expected = "none with --field height-field, which needs no network";
            return Err(InputError::new(option, "a value", expected).remedy("Leave one of the two options out").into());
        }
        Ok(Arc::new(HeightField))
    }

    /// There are no networks in this build.
    #[cfg(not(feature = "networks"))]
    fn network(&self) -> Result<Arc<dyn Occupancy>> {
        let found = format!("{}, which needs a network, in a build without networks", self.field.name());
        Err(InputError::new("--field", found, Field::HeightField.name())
            .remedy("Build gable with its feature `networks`, or leave --field out")
            .into())
    }

    /// The field of a network.
    #[cfg(feature = "networks")]
    fn network(&self) -> Result<Arc<dyn Occupancy>> {
        let embedded = if self.field == Field::Points2Surf { POINTS2SURF } else { FIELD };
        let file = match &self.model {
            None => NetworkFile::parse(embedded, Path::new(EMBEDDED))?,
            Some(path) => NetworkFile::open(path)?,
        };
        let fits = matches!(
            (self.field, file.interface),
            (Field::Neural, Interface::Field { .. }) | (Field::Points2Surf, Interface::Points2Surf { .. })
        );
        let path = self.model.as_deref().unwrap_or(Path::new(EMBEDDED));
        if !fits {
            let found = format!("a network of another interface ({})", file.interface_name());
            return Err(InputError::new(path, found, format!("one for --field {}", self.field.name()))
                .remedy("Choose another --field, or another network")
                .into());
        }
        let runtime = Runtime::start(self.onnxruntime.as_deref())?;
        let network = OnnxNetwork::new(&file, runtime).map_err(|detail| {
            let found = format!("graphs that cannot be run ({detail})");
            InputError::new(path, found, "those that `training/train.py` exports").remedy("Export the network again")
        })?;
        Ok(Arc::new(Neural::new(Arc::new(network), self.cell_rule)))
    }

    /// All that the answers of the field depend on, with the content of the network file instead of its name.
    ///
    /// # Errors
    /// Fails when the network file cannot be read.
    pub fn identity(&self) -> Result<serde_json::Value> {
        let network = match &self.model {
            None => None,
            Some(path) => {
                let mut hasher = DefaultHasher::new();
                open::whole(path, "a network")?.hash(&mut hasher);
                Some(hasher.finish())
            }
        };
        Ok(serde_json::json!({
            "field": self.field,
            "model": network,
            "onnxruntime": self.onnxruntime.is_some(),
            "cell_rule": self.cell_rule,
        }))
    }
}
