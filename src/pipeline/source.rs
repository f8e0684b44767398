//! Reading tiles: what `readers.las` and `readers.copc` have in common.

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::Arc;

use serde_json::{Map, Value, json};

use super::area::Area;
use super::las::Record;
use super::options::{Kind, OptionSpec, Values};
use super::points::{Layout, Points};
use super::stage::{Context, Flow, Next, Reader, SourceFile};
use crate::error::{InputError, Result};
use crate::source::crs::Crs;
use crate::source::points::{Region, Tile};

/// The options that all readers of points have; `filename` says which files they read.
pub(super) fn reader_options(filename: &str) -> Vec<OptionSpec> {
    vec![
        OptionSpec::new("filename", Kind::File, filename).required(),
        OptionSpec::new("count", Kind::count(), "Number of points that are read at most"),
        OptionSpec::new("override_srs", Kind::Text, "CRS of the points, whatever the file says")
            .aliases(&["spatialreference"]),
        OptionSpec::new("default_srs", Kind::Text, "CRS of the points where the file names none"),
        OptionSpec::new("nosrs", Kind::Boolean, "Whether what the file says of its CRS is passed over").or(false),
    ]
}

/// The options that readers have whose files name no CRS.
pub(super) fn plain_reader_options(filename: &str) -> Vec<OptionSpec> {
    let mut options = reader_options(filename);
    for option in &mut options {
        let help = match option.name.as_str() {
            "override_srs" => "CRS of the points; the file names none",
            "default_srs" => "The same: the file names none",
            "nosrs" => "Taken for the sake of PDAL's files: the file names no CRS",
            _ => continue,
        };
        help.clone_into(&mut option.help);
    }
    options
}

/// Reads a tile.
pub(super) struct TileReader {
    path: PathBuf,
    start: u64,
    count: Option<u64>,
    /// The CRS that the points are to have, whatever the file says, as it was given.
    override_text: Option<String>,
    override_crs: Option<Arc<Crs>>,
    default_crs: Option<Arc<Crs>>,
    no_crs: bool,
    /// In one area of each of these lists points must lie.
    wanted: Vec<Vec<Area>>,
    opened: Option<Opened>,
    /// Number of points that were handed on; `None` before.
    read: Option<u64>,
    is_whole: bool,
}

struct Opened {
    tile: Tile,
    record: Record,
    layout: Arc<Layout>,
    crs: Option<Arc<Crs>>,
}

impl TileReader {
    /// A reader with these options, of the points in one area of each list.
    ///
    /// # Errors
    /// A CRS that cannot be understood.
    pub fn new(values: &Values, wanted: Vec<Vec<Area>>) -> Result<Self, InputError> {
        let [override_crs, default_crs] = named_crs(values)?;
        Ok(Self {
            path: values.text("filename").unwrap_or_default().into(),
            start: values.whole("start").unwrap_or(0),
            count: values.whole("count"),
            override_text: values.text("override_srs").map(str::to_owned),
            override_crs,
            default_crs,
            no_crs: values.is_on("nosrs"),
            wanted,
            opened: None,
            read: None,
            is_whole: true,
        })
    }

    fn wants(&self, position: [f64; 3]) -> bool {
        self.wanted.iter().all(|areas| areas.iter().any(|area| area.has(position)))
    }
}

/// The CRS that the points have whatever their file says, and the one that they have where it says nothing.
///
/// # Errors
/// One that cannot be understood, or both.
pub(super) fn named_crs(values: &Values) -> Result<[Option<Arc<Crs>>; 2], InputError> {
    let crs = |option: &str| {
        let parsed = values.text(option).map(|text| crs_of(values, option, text));
        parsed.transpose().map(|crs| crs.map(Arc::new))
    };
    if values.is_given("override_srs") && values.is_given("default_srs") {
        return Err(values.place().fault("both `override_srs` and `default_srs`", "one of them"));
    }
    Ok([crs("override_srs")?, crs("default_srs")?])
}

/// The CRS that an option names.
///
/// # Errors
/// It cannot be understood.
pub(super) fn crs_of(values: &Values, option: &str, text: &str) -> Result<Crs, InputError> {
    Crs::parse(text).map_err(|fault| values.fault(option, &fault.found, fault.expected).remedy(fault.remedy))
}

impl Reader for TileReader {
    fn prepare(&mut self, context: &Context<'_>) -> Result<Flow> {
        let tile = Tile::open(&self.path)?;
        if !tile.is_las() {
            let fault = InputError::new(&self.path, format!("a {} file", tile.kind()), "a LAS, LAZ or COPC file");
            return Err(fault.remedy("`gable reconstruct` reads it; for a pipeline convert it to LAS first").into());
        }
        let record = Record::of_header(&tile.header);
        let layout = record.layout();
        let own = tile.crs.clone().map(Arc::new).filter(|_| !self.no_crs);
        if let (Some(fault), None, false) = (&tile.crs_fault, &self.override_crs, self.no_crs) {
            context.warn(&format!("{}: {fault}; override_srs can name the CRS", self.path.display()));
        }
        let crs = self.override_crs.clone().or(own).or_else(|| self.default_crs.clone());
        let file = SourceFile::Tile { path: self.path.clone(), crs: self.override_text.clone() };
        // Of a part of the points nobody knows where they lie.
        let is_all = self.count.is_none() && self.start == 0;
        let mut areas = tile.extent.map(|extent| vec![extent]).filter(|_| is_all);
        for wanted in &self.wanted {
            areas = areas.map(|areas| Area::clip(wanted, &areas));
        }
        let plain = is_all && self.wanted.is_empty() && self.default_crs.is_none() && !self.no_crs;
        let most = tile.points.saturating_sub(self.start);
        let flow = Flow {
            layout: layout.clone(),
            crs: crs.clone(),
            is_mixed: false,
            areas,
            points: Some(self.count.map_or(most, |count| count.min(most))),
            headers: vec![Arc::new(tile.header.clone())],
            files: plain.then(|| vec![file]),
        };
        self.opened = Some(Opened { tile, record, layout: Arc::new(layout), crs });
        self.read = None;
        self.is_whole = true;
        Ok(flow)
    }

    fn read(&mut self, context: &Context<'_>, next: &mut Next<'_>) -> Result<()> {
        let Some(Opened { tile, record, layout, crs }) = &self.opened else { return Ok(()) };
        let (mut to_skip, mut left) = (self.start, self.count.unwrap_or(u64::MAX));
        let mut outcome = Ok(());
        let mut given = 0;
        let mut seen = 0;
        let near = |low: [f64; 2], high: [f64; 2]| {
            self.wanted.iter().all(|areas| areas.iter().any(|area| area.touches(low, high)))
        };
        let region: Option<&Region<'_>> = if self.wanted.is_empty() { None } else { Some(&near) };
        let reading = tile.stream_records(region, &mut |block| {
            let mut records: Vec<&[u8]> = block.records().collect();
            seen += block.len() as u64;
            let skipped = to_skip.min(records.len() as u64);
            to_skip -= skipped;
            records.drain(..skipped as usize);
            let mut points = Points::of_columns(Arc::clone(layout), record.decode(&records), crs.clone());
            if !self.wanted.is_empty() {
                let kept: Vec<bool> = (0..points.len()).map(|i| self.wants(points.position(i))).collect();
                points.retain(&kept);
            }
            if points.len() as u64 > left {
                let places: Vec<usize> = (0..left as usize).collect();
                points = points.gather(&places);
            }
            left -= points.len() as u64;
            given += points.len() as u64;
            context.observer.advanced(block.len() as u64);
            if !points.is_empty() {
                outcome = next(points);
            }
            if outcome.is_err() || left == 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })?;
        outcome?;
        self.read = Some(given);
        self.is_whole = reading.read >= reading.expected;
        for problem in reading.problems(tile) {
            context.warn(&problem.to_string());
        }
        Ok(())
    }

    fn is_whole(&self) -> bool {
        self.is_whole
    }

    fn metadata(&self) -> Map<String, Value> {
        let Some(Opened { tile, crs, .. }) = &self.opened else { return Map::new() };
        let header = &tile.header;
        let (bounds, transforms) = (header.bounds(), header.transforms());
        let wkt = crs.as_ref().map(|crs| crs.wkt.clone()).unwrap_or_default();
        let metadata = json!({
            "filename": self.path.display().to_string(),
            "compressed": header.point_format().is_compressed,
            "copc": tile.is_copc,
            "major_version": 1,
            "minor_version": header.version().minor,
            "dataformat_id": tile.point_format,
            "count": tile.points,
            "read": self.read,
            "minx": bounds.min.x,
            "miny": bounds.min.y,
            "minz": bounds.min.z,
            "maxx": bounds.max.x,
            "maxy": bounds.max.y,
            "maxz": bounds.max.z,
            "scale_x": transforms.x.scale,
            "scale_y": transforms.y.scale,
            "scale_z": transforms.z.scale,
            "offset_x": transforms.x.offset,
            "offset_y": transforms.y.offset,
            "offset_z": transforms.z.offset,
            "filesource_id": header.file_source_id(),
            "system_id": header.system_identifier(),
            "software_id": header.generating_software(),
            "srs": { "wkt": wkt, "code": crs.as_ref().and_then(|crs| crs.code.clone()) },
        });
        match metadata {
            Value::Object(map) => map,
            _ => Map::new(),
        }
    }
}
