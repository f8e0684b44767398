//! What runs the graphs: the embedded runtime, or ONNX Runtime from a library.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, OnceLock, PoisonError};

use ort::environment::Environment;
use ort::session::Session;
use ort::session::builder::GraphOptimizationLevel;

use crate::error::{InputError, Result};

/// The runtime of this process. There can be only one: sessions of different runtimes do not mix.
static STARTED: OnceLock<Started> = OnceLock::new();
/// Held while the runtime is started.
static STARTING: Mutex<()> = Mutex::new(());

#[derive(Debug)]
struct Started {
    library: Option<PathBuf>,
    environment: Environment,
}

/// A runtime for graphs.
#[derive(Debug, Clone, Copy)]
pub struct Runtime {
    started: &'static Started,
}

impl Runtime {
    /// Starts the embedded runtime, or with a library ONNX Runtime; asked again it gives what was started.
    ///
    /// # Errors
    /// Fails when the library cannot be loaded or is too old, or when this process has started another runtime.
    pub fn start(library: Option<&Path>) -> Result<Self> {
        let _guard = STARTING.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(started) = STARTED.get() {
            if started.library.as_deref() == library {
                return Ok(Self { started });
            }
            let name =
                |library: Option<&Path>| library.map_or("the embedded one".into(), |path| path.display().to_string());
            return Err(InputError::new(
                "--onnxruntime",
                name(library),
                format!("the runtime that this process has started ({})", name(started.library.as_deref())),
            )
            .into());
        }
        let environment = match library {
            None => {
                ort::set_api(ort_tract::api());
                ort::init().build().map_err(|error| error.to_string())
            }
            Some(path) => absolute(path).and_then(|path| {
                let builder = ort::init_from(path).map_err(|error| error.to_string())?;
                builder.build().map_err(|error| error.to_string())
            }),
        }
        .map_err(|detail| {
            InputError::new(library.unwrap_or(Path::new("the embedded runtime")), detail, "a library of ONNX Runtime")
                .remedy("Name its libonnxruntime.so, or leave --onnxruntime out")
        })?;
        let started = STARTED.get_or_init(|| Started { library: library.map(Path::to_path_buf), environment });
        Ok(Self { started })
    }

    /// A session for a graph, which runs on the thread that asks.
    pub(super) fn session(self, graph: &[u8]) -> std::result::Result<Session, String> {
        let text = |error: &dyn std::error::Error| error.to_string();
        let builder = Session::builder(&self.started.environment).map_err(|error| text(&error))?;
        let builder = builder.with_intra_threads(1).map_err(|error| text(&error))?;
        // The embedded runtime runs graphs as they stand unless it is told.
        let builder = builder.with_optimization_level(GraphOptimizationLevel::Level3).map_err(|error| text(&error))?;
        let mut builder = match self.started.library {
            Some(_) => {
                builder.with_config_entry("session.intra_op.allow_spinning", "0").map_err(|error| text(&error))?
            }
            None => builder,
        };
        builder.commit_from_memory(graph).map_err(|error| text(&error))
    }
}

/// The library is looked for where the user stands, not beside the program.
fn absolute(path: &Path) -> std::result::Result<PathBuf, String> {
    std::path::absolute(path).map_err(|error| error.to_string())
}
