//! A network that is a pair of ONNX graphs.

use std::sync::{Mutex, PoisonError};

use ort::session::Session;
use ort::value::TensorRef;

use super::{NetworkFile, Runtime};
use crate::reconstruct::occupancy::inputs::{PATCH_CHANNELS, PLACE_CHANNELS, RASTER_CHANNELS};
use crate::reconstruct::occupancy::network::{Answer, Interface, Network, NetworkError, Queries};

/// A network that is run from its graphs. Every thread that asks has sessions of its own.
#[derive(Debug)]
pub struct OnnxNetwork {
    interface: Interface,
    batch: usize,
    encoder: Option<Vec<u8>>,
    decoder: Vec<u8>,
    runtime: Runtime,
    /// Sessions that nobody uses at the moment.
    idle: Mutex<Vec<Sessions>>,
}

/// What one thread runs.
#[derive(Debug)]
struct Sessions {
    encoder: Option<Session>,
    decoder: Session,
}

/// An input of a graph: its name, its values and its shape.
type Input<'a> = (&'static str, &'a [f32], Vec<usize>);

impl OnnxNetwork {
    /// Prepares the graphs of a file.
    ///
    /// # Errors
    /// Says in words why the runtime cannot run them.
    pub fn new(file: &NetworkFile, runtime: Runtime) -> Result<Self, String> {
        let network = Self {
            interface: file.interface,
            batch: file.batch,
            encoder: file.encoder.clone(),
            decoder: file.decoder.clone(),
            runtime,
            idle: Mutex::new(Vec::new()),
        };
        // Asked once about nothing in particular, so that a file with other sizes than it says is refused at once.
        network.try_out().map_err(|error| error.to_string())?;
        Ok(network)
    }

    fn try_out(&self) -> Result<(), NetworkError> {
        let mut queries = Queries { count: 1, ..Queries::default() };
        match self.interface {
            Interface::Field { grid, code, neighbours } => {
                let maps = self.encode(&vec![0.0; RASTER_CHANNELS.len() * grid * grid])?;
                if maps.len() != code * grid * grid {
                    return Err(NetworkError(format!(
                        "a code of {} numbers, not of {}",
                        maps.len(),
                        code * grid * grid
                    )));
                }
                queries.code = vec![0.0; code];
                queries.place = vec![0.0; PLACE_CHANNELS.len()];
                queries.patch = vec![0.0; neighbours * PATCH_CHANNELS.len()];
            }
            Interface::Points2Surf { neighbours, subsample } => {
                queries.patch = vec![0.0; 3 * neighbours];
                queries.subsample = vec![0.0; 3 * subsample];
            }
        }
        self.decode(&queries).map(drop)
    }

    /// Runs `ask` with sessions that no other thread uses.
    fn with_sessions<T>(&self, ask: impl FnOnce(&mut Sessions) -> Result<T, String>) -> Result<T, NetworkError> {
        let idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let mut sessions = match idle {
            Some(sessions) => sessions,
            None => self.open().map_err(NetworkError)?,
        };
        let answer = ask(&mut sessions).map_err(NetworkError);
        self.idle.lock().unwrap_or_else(PoisonError::into_inner).push(sessions);
        answer
    }

    fn open(&self) -> Result<Sessions, String> {
        let encoder = self.encoder.as_ref().map(|graph| self.runtime.session(graph)).transpose()?;
        Ok(Sessions { encoder, decoder: self.runtime.session(&self.decoder)? })
    }

    /// One batch of queries; those that lack to a full batch are zeros.
    fn batch(&self, session: &mut Session, queries: &Queries, from: usize) -> Result<Vec<Answer>, String> {
        let count = self.batch.min(queries.count - from);
        let sizes: Vec<(&'static str, &[f32], Vec<usize>)> = match self.interface {
            Interface::Field { code, neighbours, .. } => vec![
                ("code", &queries.code, vec![code]),
                ("place", &queries.place, vec![PLACE_CHANNELS.len()]),
                ("patch", &queries.patch, vec![neighbours, PATCH_CHANNELS.len()]),
            ],
            Interface::Points2Surf { neighbours, subsample } => vec![
                ("patch", &queries.patch, vec![neighbours, 3]),
                ("subsample", &queries.subsample, vec![subsample, 3]),
            ],
        };
        let mut padded = Vec::with_capacity(sizes.len());
        for (name, values, shape) in sizes {
            let width: usize = shape.iter().product();
            let rows = values
                .get(from * width..(from + count) * width)
                .ok_or_else(|| format!("too few numbers for the input `{name}`"))?;
            let mut rows = rows.to_vec();
            rows.resize(self.batch * width, 0.0);
            padded.push((name, rows, [vec![self.batch], shape].concat()));
        }
        let inputs = padded.iter().map(|(name, rows, shape)| (*name, rows.as_slice(), shape.clone())).collect();
        let field = run(session, inputs)?;
        if field.len() != 2 * self.batch {
            return Err(format!("{} numbers came out for {} queries, not two for each", field.len(), self.batch));
        }
        Ok(field.chunks_exact(2).take(count).map(|pair| Answer { inside: pair[0], distance: pair[1] }).collect())
    }
}

/// Runs a graph and returns the numbers of its only output.
fn run(session: &mut Session, inputs: Vec<Input>) -> Result<Vec<f32>, String> {
    let mut values = Vec::with_capacity(inputs.len());
    for (name, numbers, shape) in inputs {
        let tensor = TensorRef::from_array_view((shape, numbers)).map_err(|error| error.to_string())?;
        values.push((name, ort::session::SessionInputValue::from(tensor)));
    }
    let outputs = session.run(values).map_err(|error| error.to_string())?;
    let output = outputs.values().next().ok_or_else(|| "the graph has no output".to_owned())?;
    let (_, numbers) = output.try_extract_tensor::<f32>().map_err(|error| error.to_string())?;
    if numbers.iter().all(|number| number.is_finite()) {
        Ok(numbers.to_vec())
    } else {
        Err("the graph gave a number that is not finite".to_owned())
    }
}

impl Network for OnnxNetwork {
    fn interface(&self) -> Interface {
        self.interface
    }

    fn encode(&self, raster: &[f32]) -> Result<Vec<f32>, NetworkError> {
        let Interface::Field { grid, .. } = self.interface else { return Ok(Vec::new()) };
        self.with_sessions(|sessions| {
            let session = sessions.encoder.as_mut().ok_or("there is no encoder")?;
            run(session, vec![("raster", raster, vec![1, RASTER_CHANNELS.len(), grid, grid])])
        })
    }

    fn decode(&self, queries: &Queries) -> Result<Vec<Answer>, NetworkError> {
        self.with_sessions(|sessions| {
            let mut answers = Vec::with_capacity(queries.count);
            while answers.len() < queries.count {
                answers.extend(self.batch(&mut sessions.decoder, queries, answers.len())?);
            }
            Ok(answers)
        })
    }
}
