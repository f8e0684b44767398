//! `writers.copc`: cloud-optimised point clouds.

use std::path::PathBuf;
use std::sync::Arc;

use las::{Header, Transform};
use serde_json::{Map, json};

use super::las_writer::header_options;
use super::las_writer::settings::Settings;
use crate::error::{Error, InputError, Result};
use crate::pipeline::las::Record;
use crate::pipeline::las::copc::Cloud;
use crate::pipeline::las::octree::Cube;
use crate::pipeline::options::{Kind, OptionSpec, Values};
use crate::pipeline::output::NewFile;
use crate::pipeline::points::Points;
use crate::pipeline::stage::{Context, Finished, Flow, Role, Stage, StageKind, Writer};
use crate::source::crs::Crs;

/// The type of this stage.
pub const KIND: StageKind = StageKind {
    name: "writers.copc",
    summary: "Writes COPC files: LAZ in an octree, from which places and coarse views can be read on their own",
    role: Role::Writer,
    options,
    elsewhere: &[
        "vlrs",
        "pipeline",
        "global_encoding",
        "project_id",
        "enhanced_srs_vlrs",
        "fixed_seed",
        "threads",
        "option_file",
    ],
    collects: "always",
    build,
};

fn options() -> Vec<OptionSpec> {
    let mut options =
        vec![OptionSpec::new("filename", Kind::File, "File; PDAL expects a name that ends with .copc.laz").required()];
    options.extend(header_options());
    options
}

fn build(values: &Values) -> Result<Stage> {
    let settings = Settings::of_copc(values, &Flow::default())?;
    Ok(Stage::Writer(Box::new(CopcWriter {
        path: values.text("filename").unwrap_or_default().into(),
        values: values.clone(),
        settings,
        encoder: None,
        crs: None,
        held: Vec::new(),
        records: Vec::new(),
    })))
}

struct CopcWriter {
    values: Values,
    path: PathBuf,
    settings: Settings,
    encoder: Option<Encoder>,
    /// The CRS of the points that have come.
    crs: Option<Arc<Crs>>,
    /// Points that wait for scales and offsets.
    held: Vec<Points>,
    /// The records of all points, one behind the other.
    records: Vec<u8>,
}

/// What makes records of points.
struct Encoder {
    header: Header,
    record: Record,
    transforms: [Transform; 3],
}

impl CopcWriter {
    /// Appends the records of points.
    fn encode(&mut self, points: &Points, transforms: [Transform; 3]) -> Result<()> {
        let encoder = if let Some(encoder) = self.encoder.take() {
            encoder
        } else {
            let (header, extra) = self.settings.header(&self.path, points.crs.as_ref(), transforms)?;
            Encoder { record: Record::new(&header, &extra), header, transforms }
        };
        let encoded = encoder.record.encode(points, &mut self.records);
        self.encoder = Some(encoder);
        encoded.map_err(|unfit| self.settings.unfit(&unfit, &self.path, self.values.place()).into())
    }

    /// All points are of one CRS.
    ///
    /// # Errors
    /// These are of another than those before.
    fn agree(&mut self, points: &Points) -> Result<()> {
        let own = self.settings.crs.as_ref().or(points.crs.as_ref()).cloned();
        if self.records.is_empty() && self.held.is_empty() {
            self.crs.clone_from(&own);
        }
        if self.crs == own {
            return Ok(());
        }
        let name = |crs: &Option<Arc<Crs>>| crs.as_ref().map_or("no CRS".to_owned(), ToString::to_string);
        let found = format!("points in {} among points in {}", name(&own), name(&self.crs));
        let fault = InputError::new(&self.path, found, "points of one CRS");
        Err(fault.remedy("Put filters.reprojection before, or name one with `a_srs`").into())
    }

    /// The coordinates of all records as they are stored.
    fn positions(&self, Encoder { header, transforms, .. }: &Encoder) -> Vec<[f64; 3]> {
        let coordinate = |record: &[u8], axis: usize| {
            let stored = record.get(4 * axis..).and_then(|rest| rest.first_chunk()).copied().unwrap_or([0; 4]);
            transforms[axis].direct(i32::from_le_bytes(stored))
        };
        let records = self.records.chunks_exact(usize::from(header.point_format().len()));
        records.map(|record| [0, 1, 2].map(|axis| coordinate(record, axis))).collect()
    }
}

impl Writer for CopcWriter {
    fn prepare(&mut self, flow: &Flow, _is_last: bool) -> Result<()> {
        self.settings = Settings::of_copc(&self.values, flow)?;
        self.encoder = None;
        self.crs = None;
        self.held.clear();
        self.records.clear();
        Ok(())
    }

    fn streams(&self) -> bool {
        false
    }

    fn write(&mut self, points: &Points, _context: &Context<'_>) -> Result<()> {
        if points.is_empty() {
            return Ok(());
        }
        self.agree(points)?;
        if self.settings.is_automatic() {
            self.held.push(points.clone());
            return Ok(());
        }
        self.encode(points, self.settings.transforms(&[]))
    }

    fn finish(&mut self, context: &Context<'_>) -> Result<Finished> {
        let held = std::mem::take(&mut self.held);
        let transforms = self.settings.transforms(&held);
        for points in held {
            self.encode(&points, transforms)?;
        }
        let Some(encoder) = self.encoder.take() else {
            let fault = InputError::new(&self.path, "no points", "one at least, for the root of the octree");
            return Err(fault.at(self.values.place().stage.clone()).into());
        };
        let positions = self.positions(&encoder);
        if positions.len() > u32::MAX as usize {
            let fault =
                InputError::new(&self.path, "more points than 4 294 967 295", "as many as an octree here holds");
            return Err(fault.remedy("Part them with filters.splitter").into());
        }
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for position in &positions {
            for axis in 0..3 {
                low[axis] = low[axis].min(position[axis]);
                high[axis] = high[axis].max(position[axis]);
            }
        }
        let steps = encoder.transforms.map(|transform| transform.scale.abs());
        let cube = Cube::around(low, high, steps.into_iter().fold(0.0, f64::max));
        let stop = || context.observer.interrupted();
        let nodes = cube.nodes(&positions, &stop).ok_or(Error::Interrupted)?;
        drop(positions);
        context.observer.ready(&self.path);
        let (file, mut sturdy) = NewFile::create(&self.path)?;
        let cloud = Cloud { header: &encoder.header, records: &self.records, bounds: [low, high], cube, nodes: &nodes };
        let written = cloud.write(&mut sturdy, &stop);
        drop(sturdy);
        file.check()?;
        match written {
            Ok(true) => {}
            Ok(false) => return Err(Error::Interrupted),
            Err(e) => return Err(Settings::misfit(&self.path, &e).into()),
        }
        let path = file.commit()?;
        context.observer.done(&path);
        self.records = Vec::new();
        let metadata = Map::from_iter([
            ("filename".to_owned(), json!([path.display().to_string()])),
            ("nodes".to_owned(), json!(nodes.len())),
        ]);
        Ok(Finished { metadata, ..Finished::default() })
    }
}
