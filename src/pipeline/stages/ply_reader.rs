//! `readers.ply`: the vertices of PLY files, with all their numbers.

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::Arc;

use serde_json::{Map, Value, json};

use crate::error::{InputError, Result};
use crate::pipeline::options::{OptionSpec, Values};
use crate::pipeline::points::{Dimension, Layout, NumberType, usual_name};
use crate::pipeline::rows::Rows;
use crate::pipeline::source::{named_crs, plain_reader_options};
use crate::pipeline::stage::{Context, Flow, Next, Reader, Role, Stage, StageKind};
use crate::source::crs::Crs;
use crate::source::points::{PlyFile, Scalar};

/// The type of this stage.
pub const KIND: StageKind = StageKind {
    name: "readers.ply",
    summary: "Reads PLY files: their vertices with all numbers that they have",
    role: Role::Reader,
    options,
    elsewhere: &["option_file"],
    collects: "",
    build,
};

fn options() -> Vec<OptionSpec> {
    plain_reader_options("PLY file; a pattern such as scans/*.ply stands for one reader per file")
}

fn build(values: &Values) -> Result<Stage> {
    let [stated, default] = named_crs(values)?;
    Ok(Stage::Reader(Box::new(PlyReader {
        path: values.text("filename").unwrap_or_default().into(),
        count: values.whole("count").unwrap_or(u64::MAX),
        crs: stated.or(default),
        opened: None,
        read: None,
        is_whole: true,
    })))
}

struct PlyReader {
    path: PathBuf,
    count: u64,
    crs: Option<Arc<Crs>>,
    opened: Option<Opened>,
    /// Number of points that were handed on; `None` before.
    read: Option<u64>,
    is_whole: bool,
}

struct Opened {
    file: PlyFile,
    layout: Arc<Layout>,
    /// The place in the layout of each number of a vertex.
    places: Vec<usize>,
}

fn number_type(scalar: Scalar) -> NumberType {
    match scalar {
        Scalar::I8 => NumberType::I8,
        Scalar::U8 => NumberType::U8,
        Scalar::I16 => NumberType::I16,
        Scalar::U16 => NumberType::U16,
        Scalar::I32 => NumberType::I32,
        Scalar::U32 => NumberType::U32,
        Scalar::I64 => NumberType::I64,
        Scalar::U64 => NumberType::U64,
        Scalar::F32 => NumberType::F32,
        Scalar::F64 => NumberType::F64,
    }
}

impl Reader for PlyReader {
    fn prepare(&mut self, _context: &Context<'_>) -> Result<Flow> {
        let file = PlyFile::open(&self.path)?;
        let mut layout = Layout::default();
        let mut places: Vec<usize> = Vec::new();
        for (name, scalar) in file.properties() {
            let place = layout.add(usual_name(name), number_type(scalar));
            if places.contains(&place) {
                let Dimension { name: usual, .. } = &layout.dimensions()[place];
                let found = format!("the property `{name}` of a vertex for {usual}, which has one already");
                return Err(InputError::new(&self.path, found, "one for each dimension").at("header").into());
            }
            places.push(place);
        }
        let points = Some(file.vertices().min(self.count));
        let flow = Flow { layout: layout.clone(), crs: self.crs.clone(), points, ..Flow::default() };
        self.opened = Some(Opened { file, layout: Arc::new(layout), places });
        self.read = None;
        self.is_whole = true;
        Ok(flow)
    }

    fn read(&mut self, context: &Context<'_>, next: &mut Next<'_>) -> Result<()> {
        let Some(Opened { file, layout, places }) = &self.opened else { return Ok(()) };
        let mut rows = Rows::new(Arc::clone(layout), self.crs.clone(), places.clone());
        let (mut given, mut outcome) = (0, Ok(()));
        let fault = if self.count == 0 {
            None
        } else {
            file.read(&mut |values| {
                given += 1;
                outcome = rows.push(values, context, next);
                if outcome.is_err() || given >= self.count { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            })?
        };
        outcome?;
        rows.finish(context, next)?;
        self.read = Some(given);
        if let Some(fault) = fault {
            self.is_whole = false;
            context.warn(&format!(
                "{fault}; {} points are missing, the {given} that could be read are used",
                file.vertices() - given
            ));
        }
        Ok(())
    }

    fn is_whole(&self) -> bool {
        self.is_whole
    }

    fn metadata(&self) -> Map<String, Value> {
        let Some(Opened { file, layout, .. }) = &self.opened else { return Map::new() };
        Map::from_iter([
            ("filename".to_owned(), json!(self.path.display().to_string())),
            ("format".to_owned(), json!(file.encoding())),
            ("count".to_owned(), json!(file.vertices())),
            ("read".to_owned(), json!(self.read)),
            ("dimensions".to_owned(), json!(layout.names())),
        ])
    }
}
