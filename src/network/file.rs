//! Network files: the graphs of a network, its interface, and its model card, in one safetensors file.
//!
//! | entry | what |
//! |---|---|
//! | tensors `encoder.onnx` (none for Points2Surf), `decoder.onnx` | bytes of the ONNX graphs |
//! | `interface`, `version` | `field` or `points2surf`; `1` |
//! | `grid`, `code`, `neighbours`, `subsample`, `batch` | sizes |
//! | `raster_channels`, `place_channels`, `patch_channels` | names, in order, separated by commas |
//! | `name`, `card` | what the network is called, and its model card as Markdown |

use std::collections::HashMap;
use std::path::Path;

use safetensors::{Dtype, SafeTensors};

use crate::error::{Error, InputError, Result};
use crate::reconstruct::occupancy::inputs::{PATCH_CHANNELS, PLACE_CHANNELS, RASTER_CHANNELS};
use crate::reconstruct::occupancy::network::Interface;
use crate::source::open;

/// The version of the interface that this code speaks.
const VERSION: &str = "1";
/// No size in a network file is larger: what is larger is a damaged file.
const LARGEST: usize = 65_536;

/// A network as it stands in its file.
#[derive(Debug, Clone)]
pub struct NetworkFile {
    /// What the network is called.
    pub name: String,
    /// Sizes of its inputs and outputs.
    pub interface: Interface,
    /// How many queries the decoder takes at once.
    pub batch: usize,
    /// The model card, Markdown.
    pub card: String,
    /// The graph of the encoder; none for Points2Surf.
    pub encoder: Option<Vec<u8>>,
    /// The graph of the decoder.
    pub decoder: Vec<u8>,
}

impl NetworkFile {
    /// Reads a network file.
    ///
    /// # Errors
    /// Fails when the file cannot be read or [is no network](Self::parse).
    pub fn open(path: &Path) -> Result<Self> {
        let bytes = open::whole(path, "a network")?;
        Self::parse(&bytes, path)
    }

    /// Reads the bytes of a network file; `path` is what messages call it.
    ///
    /// # Errors
    /// Fails when the bytes are no safetensors file, lack an entry, or are of an interface that is not spoken here.
    pub fn parse(bytes: &[u8], path: &Path) -> Result<Self> {
        let reader = Reader::new(bytes, path)?;
        reader.must_be("version", VERSION)?;
        let interface = match reader.text("interface")? {
            "field" => {
                reader.must_be("raster_channels", &RASTER_CHANNELS.join(","))?;
                reader.must_be("place_channels", &PLACE_CHANNELS.join(","))?;
                reader.must_be("patch_channels", &PATCH_CHANNELS.join(","))?;
                Interface::Field {
                    grid: reader.size("grid")?,
                    code: reader.size("code")?,
                    neighbours: reader.size("neighbours")?,
                }
            }
            "points2surf" => {
                Interface::Points2Surf { neighbours: reader.size("neighbours")?, subsample: reader.size("subsample")? }
            }
            other => {
                return Err(reader.fault("interface", &format!("`{other}`"), "`field` or `points2surf`"));
            }
        };
        let encoder = match interface {
            Interface::Field { .. } => Some(reader.graph("encoder.onnx")?),
            Interface::Points2Surf { .. } => None,
        };
        Ok(Self {
            name: reader.text("name")?.to_owned(),
            interface,
            batch: reader.size("batch")?,
            card: reader.text("card")?.to_owned(),
            encoder,
            decoder: reader.graph("decoder.onnx")?,
        })
    }

    /// What the file calls its interface.
    pub fn interface_name(&self) -> &'static str {
        match self.interface {
            Interface::Field { .. } => "field",
            Interface::Points2Surf { .. } => "points2surf",
        }
    }
}

/// A safetensors file and its metadata.
struct Reader<'a> {
    path: &'a Path,
    tensors: SafeTensors<'a>,
    metadata: HashMap<String, String>,
}

impl<'a> Reader<'a> {
    fn new(bytes: &'a [u8], path: &'a Path) -> Result<Self> {
        let damaged = |error: safetensors::SafeTensorError| {
            InputError::new(path, format!("no readable safetensors file ({error})"), "a network file")
                .remedy("Take a file that `training/train.py` has exported")
        };
        let (_, header) = SafeTensors::read_metadata(bytes).map_err(damaged)?;
        let metadata = header.metadata().clone().unwrap_or_default();
        let tensors = SafeTensors::deserialize(bytes).map_err(damaged)?;
        Ok(Self { path, tensors, metadata })
    }

    fn fault(&self, entry: &str, found: &str, expected: &str) -> Error {
        InputError::new(self.path, found, expected)
            .at(format!("entry `{entry}`"))
            .remedy("Take a network that was trained for this version")
            .into()
    }

    fn text(&self, entry: &str) -> Result<&str> {
        self.metadata.get(entry).map(String::as_str).ok_or_else(|| self.fault(entry, "nothing", "a text"))
    }

    fn must_be(&self, entry: &str, expected: &str) -> Result<()> {
        let found = self.text(entry)?;
        if found == expected { Ok(()) } else { Err(self.fault(entry, &format!("`{found}`"), &format!("`{expected}`"))) }
    }

    fn size(&self, entry: &str) -> Result<usize> {
        let found = self.text(entry)?;
        found
            .parse()
            .ok()
            .filter(|size| (1..=LARGEST).contains(size))
            .ok_or_else(|| self.fault(entry, &format!("`{found}`"), &format!("a number from 1 to {LARGEST}")))
    }

    fn graph(&self, entry: &str) -> Result<Vec<u8>> {
        match self.tensors.tensor(entry) {
            Ok(tensor) if tensor.dtype() == Dtype::U8 => Ok(tensor.data().to_vec()),
            Ok(tensor) => Err(self.fault(entry, &format!("a tensor of {:?}", tensor.dtype()), "one of U8")),
            Err(_) => Err(self.fault(entry, "nothing", "the bytes of an ONNX graph")),
        }
    }
}
