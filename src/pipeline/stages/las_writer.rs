//! `writers.las`: LAS and LAZ files.

mod header;
pub(super) mod settings;

use std::path::PathBuf;
use std::sync::Arc;

use las::{PointDataBuilder, Transform};
use serde_json::{Map, json};

use self::settings::Settings;
use crate::error::{InputError, Result};
use crate::pipeline::las::Record;
use crate::pipeline::options::{Kind, OptionSpec, Values};
use crate::pipeline::output::{NewFile, Sturdy};
use crate::pipeline::points::Points;
use crate::pipeline::stage::{Context, Finished, Flow, Role, Stage, StageKind, Writer};
use crate::source::crs::Crs;

/// The type of this stage.
pub const KIND: StageKind = StageKind {
    name: "writers.las",
    summary: "Writes LAS and LAZ files",
    role: Role::Writer,
    options,
    elsewhere: &[
        "major_version",
        "vlrs",
        "pdal_metadata",
        "global_encoding",
        "project_id",
        "enhanced_srs_vlrs",
        "srs_consume_preference",
        "option_file",
    ],
    collects: "with a scale or an offset of auto, which follow from all points",
    build,
};

fn options() -> Vec<OptionSpec> {
    let mut options = vec![
        OptionSpec::new("filename", Kind::File, "File; a `#` in it stands for a number and means one file per set of points")
            .required(),
        whole("minor_version", 4, "Version of LAS: 1.this; 4, unless the point format or `forward` say otherwise"),
        whole("dataformat_id", 8, "Point format, 0 to 3 or 6 to 8; 7, or 3 before LAS 1.4").aliases(&["format"]),
        OptionSpec::new("compression", Kind::Text, "Whether the file is compressed (LAZ); by default when its name ends with .laz"),
        OptionSpec::new(
            "discard_high_return_numbers",
            Kind::Boolean,
            "Whether points are dropped whose number of the return the point format does not have (5, or 15 from format 6)",
        )
        .or(false),
    ];
    options.extend(header_options());
    options
}

fn whole(name: &'static str, most: u32, help: &'static str) -> OptionSpec {
    OptionSpec::new(name, Kind::whole(0, most), help)
}

/// What the header of a file is to say, whatever its version.
pub(super) fn header_options() -> Vec<OptionSpec> {
    let mut options = vec![
        OptionSpec::new(
            "forward",
            Kind::Names,
            "What is taken from the header of the source: minor_version, dataformat_id, filesource_id, global_encoding, \
             project_id, system_id, software_id, creation_doy, creation_year, scale_x …, offset_x …; or `header`, `scale`, \
             `offset`, `vlr`, or `all`",
        ),
        OptionSpec::new("a_srs", Kind::Text, "CRS of the file, in place of that of the points"),
        OptionSpec::new(
            "extra_dims",
            Kind::Names,
            "Further dimensions to write, such as HeightAboveGround=float32; or `all`",
        ),
        whole("filesource_id", 65_535, "Number of the source"),
        OptionSpec::new("system_id", Kind::Text, "What made the points").or("gable"),
        OptionSpec::new("software_id", Kind::Text, "What wrote the file; gable and its version when it is not given"),
        whole(
            "creation_doy",
            366,
            "Day of the year of the file; none when it is not given, so that the same input gives the same file",
        ),
        whole("creation_year", 65_535, "Year of the file"),
    ];
    for axis in ["x", "y", "z"] {
        let help = format!("Smallest step of {axis}; auto uses the whole range of the file's numbers");
        options.push(OptionSpec::new(format!("scale_{axis}"), Kind::NumberOrAuto, help).or(0.01));
    }
    for axis in ["x", "y", "z"] {
        let help = format!("Where the number 0 of {axis} is; auto takes the smallest");
        options.push(OptionSpec::new(format!("offset_{axis}"), Kind::NumberOrAuto, help).or(0.0));
    }
    options
}

fn build(values: &Values) -> Result<Stage> {
    // Of the options alone; prepare looks at the sources again.
    let settings = Settings::new(values, &Flow::default())?;
    Ok(Stage::Writer(Box::new(LasWriter {
        filename: values.text("filename").unwrap_or_default().to_owned(),
        values: values.clone(),
        settings,
        flow: Flow::default(),
        open: None,
        held: Vec::new(),
        files: Vec::new(),
        discarded: 0,
    })))
}

struct LasWriter {
    values: Values,
    filename: String,
    settings: Settings,
    flow: Flow,
    open: Option<OpenFile>,
    /// Points that wait for scales and offsets.
    held: Vec<Points>,
    files: Vec<PathBuf>,
    discarded: u64,
}

struct OpenFile {
    path: PathBuf,
    file: NewFile,
    writer: las::Writer<Sturdy>,
    record: Record,
    crs: Option<Arc<Crs>>,
}

impl LasWriter {
    /// Whether there is a file for every view.
    fn is_numbered(&self) -> bool {
        self.filename.contains('#')
    }

    fn path(&self) -> PathBuf {
        self.filename.replacen('#', &(self.files.len() + 1).to_string(), 1).into()
    }

    fn open(&mut self, crs: Option<Arc<Crs>>, transforms: [Transform; 3], context: &Context<'_>) -> Result<OpenFile> {
        let path = self.path();
        let (header, extra) = self.settings.header(&path, crs.as_ref(), transforms)?;
        let record = Record::new(&header, &extra);
        let crs = self.settings.crs.clone().or(crs);
        context.observer.ready(&path);
        let (file, sturdy) = NewFile::create(&path)?;
        let writer = las::Writer::new(sturdy, header).map_err(|e| Settings::misfit(&path, &e))?;
        Ok(OpenFile { path, file, writer, record, crs })
    }

    /// Writes points into the open file, or opens one.
    fn put(&mut self, points: &Points, transforms: Option<[Transform; 3]>, context: &Context<'_>) -> Result<()> {
        let mut open = if let Some(open) = self.open.take() {
            open
        } else {
            let transforms = transforms.unwrap_or_else(|| self.settings.transforms(&[]));
            self.open(points.crs.clone(), transforms, context)?
        };
        let own = self.settings.crs.as_ref().or(points.crs.as_ref());
        if own != open.crs.as_ref() {
            let name = |crs: Option<&Arc<Crs>>| crs.map_or("no CRS".to_owned(), ToString::to_string);
            let found = format!("points in {} among points in {}", name(own), name(open.crs.as_ref()));
            let fault = InputError::new(&open.path, found, "points of one CRS");
            return Err(fault.remedy("Put filters.reprojection before, or name one with `a_srs`").into());
        }
        let outcome = self.write_to(&mut open, points);
        self.open = Some(open);
        outcome
    }

    fn write_to(&mut self, open: &mut OpenFile, points: &Points) -> Result<()> {
        let mut bytes = Vec::new();
        let is_legacy = self.settings.format < 6;
        let most = if is_legacy { 5.0 } else { 15.0 };
        let returns = points.layout().find("ReturnNumber").filter(|_| self.values.is_on("discard_high_return_numbers"));
        let encoded = if let Some(returns) = returns {
            let kept: Vec<usize> = (0..points.len()).filter(|&i| points.get(returns, i) <= most).collect();
            self.discarded += (points.len() - kept.len()) as u64;
            open.record.encode(&points.gather(&kept), &mut bytes)
        } else {
            open.record.encode(points, &mut bytes)
        };
        encoded.map_err(|unfit| self.settings.unfit(&unfit, &open.path, self.values.place()))?;
        let header = open.writer.header();
        if is_legacy && header.number_of_points() + points.len() as u64 > u64::from(u32::MAX) {
            let fault =
                InputError::new(&open.path, "more points than 4 294 967 295", "as many as the point format holds");
            return Err(fault.remedy("Set `dataformat_id` to 6 or more").into());
        }
        let data = PointDataBuilder::new().for_header(header).build_from_bytes(bytes);
        let written = data.and_then(|data| open.writer.write_points(&data));
        open.file.check()?;
        written.map_err(|e| InputError::new(&open.path, e.to_string(), "points that the file can hold").into())
    }

    /// Completes the file under way.
    fn close(&mut self, context: &Context<'_>) -> Result<()> {
        if self.settings.is_automatic() && !self.held.is_empty() {
            let held = std::mem::take(&mut self.held);
            let transforms = self.settings.transforms(&held);
            for points in &held {
                self.put(points, Some(transforms), context)?;
            }
        }
        let Some(OpenFile { path, file, mut writer, .. }) = self.open.take() else { return Ok(()) };
        let closed = writer.close();
        drop(writer);
        file.check()?;
        closed.map_err(|e| InputError::new(&path, e.to_string(), "a file that can be completed"))?;
        let path = file.commit()?;
        context.observer.done(&path);
        self.files.push(path);
        Ok(())
    }
}

impl Writer for LasWriter {
    fn prepare(&mut self, flow: &Flow, _is_last: bool) -> Result<()> {
        self.settings = Settings::new(&self.values, flow)?;
        self.flow = flow.clone();
        self.open = None;
        self.held.clear();
        self.files.clear();
        self.discarded = 0;
        Ok(())
    }

    fn streams(&self) -> bool {
        !self.settings.is_automatic()
    }

    fn write(&mut self, points: &Points, context: &Context<'_>) -> Result<()> {
        if points.is_empty() {
            return Ok(());
        }
        if self.settings.is_automatic() {
            self.held.push(points.clone());
            return Ok(());
        }
        self.put(points, None, context)
    }

    fn end_view(&mut self, context: &Context<'_>) -> Result<()> {
        if self.is_numbered() { self.close(context) } else { Ok(()) }
    }

    fn finish(&mut self, context: &Context<'_>) -> Result<Finished> {
        self.close(context)?;
        if self.files.is_empty() && !self.is_numbered() {
            let transforms = self.settings.transforms(&[]);
            let open = self.open(self.flow.crs.clone(), transforms, context)?;
            self.open = Some(open);
            self.close(context)?;
        }
        if self.discarded > 0 {
            context.warn(&format!("{}: {} points of high returns were dropped", self.filename, self.discarded));
        }
        let files: Vec<String> = self.files.iter().map(|path| path.display().to_string()).collect();
        Ok(Finished { metadata: Map::from_iter([("filename".to_owned(), json!(files))]), ..Finished::default() })
    }
}
