//! `readers.lod2`: city models, for `writers.lod2` to write in another format.

use std::path::PathBuf;

use serde_json::{Map, Value, json};

use crate::error::{Error, InputError, Result};
use crate::pipeline::options::{Kind, OptionSpec, Values};
use crate::pipeline::points::Layout;
use crate::pipeline::stage::{Context, Flow, Next, Reader, Role, SourceFile, Stage, StageKind};

/// The type of this stage.
pub const KIND: StageKind = StageKind {
    name: "readers.lod2",
    summary: "Reads a city model (CityJSON or CityJSONSeq), for writers.lod2 to convert",
    role: Role::Reader,
    options,
    elsewhere: &[],
    collects: "",
    build,
};

fn options() -> Vec<OptionSpec> {
    vec![OptionSpec::new("filename", Kind::File, "CityJSON or CityJSONSeq file").required()]
}

#[expect(clippy::unnecessary_wraps, reason = "the type of all stages")]
fn build(values: &Values) -> Result<Stage> {
    let path = values.text("filename").unwrap_or_default().into();
    Ok(Stage::Reader(Box::new(ModelReader { path })))
}

struct ModelReader {
    path: PathBuf,
}

impl Reader for ModelReader {
    fn prepare(&mut self, _context: &Context<'_>) -> Result<Flow> {
        std::fs::metadata(&self.path).map_err(|e| Error::io(&self.path, "open", e))?;
        Ok(Flow {
            layout: Layout::default(),
            points: Some(0),
            files: Some(vec![SourceFile::Model(self.path.clone())]),
            ..Flow::default()
        })
    }

    fn read(&mut self, _context: &Context<'_>, _next: &mut Next<'_>) -> Result<()> {
        let found = "a city model, which has no points";
        Err(InputError::new(&self.path, found, "writers.lod2 behind readers.lod2, and nothing between").into())
    }

    fn metadata(&self) -> Map<String, Value> {
        Map::from_iter([("filename".to_owned(), json!(self.path.display().to_string()))])
    }
}
