//! `writers.lod2`: reconstructs the buildings in the points and writes a city model; or converts one that was read.

mod hosted;
mod job;
mod words;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde_json::{Map, Value, json};

use self::words::in_words_of;
use crate::convert::{Conversion, convert};
use crate::error::{Error, InputError, Result};
use crate::network::FieldOptions;
use crate::pipeline::options::{Kind, OptionSpec, Values, tunings};
use crate::pipeline::points::Points;
use crate::pipeline::stage::{Context, Finished, Flow, Role, SourceFile, Stage, StageKind, Writer};
use crate::reconstruct::Parameters;
use crate::report::Report;
use crate::run::{self, Feed, Job};
use crate::segment::SegmentOptions;
use crate::sink::{self, PREFIX};
use crate::source::crs::Crs;
use crate::source::points::{ScanPoint, Unit, UpAxis};
use crate::terrain::TerrainOptions;

pub use hosted::{HostOption, hosted_job, hosted_options};
pub use job::feed;

/// The type of this stage.
pub const KIND: StageKind = StageKind {
    name: "writers.lod2",
    summary: "Reconstructs buildings and writes a city model, or converts one",
    role: Role::Writer,
    options,
    elsewhere: &[],
    collects: "",
    build,
};

/// The options of `gable reconstruct` under the same names, with `_` for `-`: those of the job as they stand here, which a
/// test holds against that command, those of the method from the structures that hold them.
fn options() -> Vec<OptionSpec> {
    let segmentation = SegmentOptions::default();
    let text = |name: &'static str, help: &'static str| OptionSpec::new(name, Kind::Text, help);
    let switch = |name: &'static str, help: &'static str| OptionSpec::new(name, Kind::Boolean, help).or(false);
    let mut options = vec![
        OptionSpec::new("filename", Kind::File, "City model; the extension chooses the format, such as .city.json")
            .required(),
        OptionSpec::new(
            "footprints",
            Kind::File,
            "Building footprints: GeoPackage, GeoJSON, Shapefile, FlatGeobuf, GeoParquet, SpatiaLite, or a PostGIS database \
             (`PG:host=… dbname=…`); needed unless `no_footprint`",
        ),
        OptionSpec::new(
            "roofprint",
            Kind::File,
            "Outlines of the roofs, where the footprints are those of the walls: roofs hang over as far as these reach, at LoD \
             2.3",
        ),
        switch("no_footprint", "Take what stands apart in the building points for an object each"),
        OptionSpec::new(
            "edits",
            Kind::File,
            "What a person has decided about buildings: a JSON file of edits, by which each of them is made",
        ),
        text("title", "Title of the city model; the name of the file of footprints when it is not given"),
        OptionSpec::new(
            "translation",
            Kind::Names,
            "Where the number 0 of the coordinates of a CityJSON file is, X,Y,Z in CRS units, whole multiples of `grid_scale`; \
             whole units at the corner of the model when it is not given",
        ),
        switch(
            "crop_only",
            "Write the points of each building, and those up to `ring_width` around it, to a LAZ file of its own in the folder \
             `filename`, with all of them in index.gpkg there, instead of models",
        ),
        switch("overwrite", "Replace files that exist"),
        switch("resume", "Go on from what a run that was killed has left beside the file"),
        OptionSpec::new("report", Kind::File, "Where the report goes; beside the city model when it is not given"),
        text("crs", "CRS of the points, such as EPSG:7415; goes before what they say"),
        OptionSpec::new(
            "unit",
            Kind::choice(&Unit::ALL.map(Unit::name)),
            "Unit of the coordinates of points without a CRS, with `no_footprint`; m when it is not given",
        ),
        OptionSpec::new(
            "up_axis",
            Kind::choice(&UpAxis::ALL.map(UpAxis::name)),
            "Axis that points up in points without a CRS, with `no_footprint`; z when it is not given",
        ),
        text("footprint_crs", "CRS of the footprints; goes before what the file says"),
        text("layer", "Layer or table of the footprints, if there are several"),
        text("query", "`SELECT` that gives the footprints of a database, instead of a layer"),
        text("filter", "Only footprints whose attributes satisfy this, such as `status = 'in use' AND height > 3`"),
        text("id_attribute", "Attribute that holds the ids of the buildings; guessed when it is not given"),
        OptionSpec::new(
            "box",
            Kind::Names,
            "Only buildings in this box, MINX,MINY,MAXX,MAXY in the CRS of the points; a building is where a point inside its \
             footprint is, and the right and the upper edge do not belong to the box",
        ),
        OptionSpec::new(
            "limit_area",
            Kind::File,
            "Only buildings in the polygons of this file, in any format of footprints and any CRS",
        ),
        OptionSpec::new(
            "building_class",
            Kind::Names,
            "Classes of building points, such as 1,6; `any` for clouds that are not classified",
        )
        .or(segmentation.building_classes.to_string()),
        OptionSpec::new("ground_class", Kind::Names, "Classes of ground points").or(segmentation
            .ground_classes
            .iter()
            .map(u8::to_string)
            .collect::<Vec<_>>()
            .join(",")),
        switch(
            "terrain",
            "Write the terrain around the buildings too: a TIN of the ground points, which the buildings stand in",
        ),
        OptionSpec::new(
            "cloud",
            Kind::Texts,
            "More point clouds, of which each building gets the best, the points that come being one of them: each a text such \
             as `AHN4=ahn4/*.laz,date=2020-05-01,priority=2`",
        ),
        text("point_cloud_source", "Name of the point cloud, such as AHN3; an attribute of every building"),
        text(
            "point_cloud_date",
            "When the point cloud was recorded, such as 2014 or 2014-03-04; an attribute of every building",
        ),
        OptionSpec::new(
            "attributes",
            Kind::Names,
            "Which of gable's own attributes are written: names with or without their prefix, or patterns such as `height_*`; \
             `none` writes none of them; all when it is not given",
        ),
        text("attribute_prefix", "What the names of gable's own attributes begin with; an empty text for nothing")
            .or(PREFIX),
        OptionSpec::new(
            "footprint_attributes",
            Kind::Names,
            "Which attributes of the footprints are kept: names or patterns; `none` keeps none; all when it is not given",
        ),
        OptionSpec::new(
            "jobs",
            Kind::whole(1, run::MOST_THREADS),
            "Number of threads; one per processor when it is not given",
        ),
        text(
            "memory",
            "How many points that wait for the rest of their building may be held in memory, such as 64MB; the others wait in a \
             temporary file, and the model is the same; 2GiB when it is not given",
        ),
    ];
    let lod = "Levels of detail, such as 0,1.2,1.3,2.2: of a reconstruction 0,1.2,2.2 when it is not given, and 2.3 with `roofprint`; behind \
               readers.lod2 only these, whatever their names";
    options.push(OptionSpec::new("lod", Kind::Names, lod));
    options.extend(tunings::<FieldOptions>().into_iter().map(OptionSpec::from));
    options.extend(tunings::<SegmentOptions>().into_iter().map(OptionSpec::from));
    options.extend(tunings::<Parameters>().into_iter().map(OptionSpec::from));
    options.extend(tunings::<TerrainOptions>().into_iter().map(OptionSpec::from));
    options
}

fn build(values: &Values) -> Result<Stage> {
    let filename: PathBuf = values.text("filename").unwrap_or_default().into();
    Ok(Stage::Writer(Box::new(Lod2Writer {
        job: job::job(values, &filename)?,
        values: values.clone(),
        flow: Flow::default(),
        source: Source::Points,
        feed: None,
        crs: None,
    })))
}

struct Lod2Writer {
    values: Values,
    /// What is to be done, without points.
    job: Job,
    flow: Flow,
    source: Source,
    feed: Option<Feed>,
    /// The CRS of the points that came.
    crs: Option<Arc<Crs>>,
}

/// Where the input comes from.
enum Source {
    /// Points that are handed over.
    Points,
    /// Files that the job reads itself.
    Tiles { paths: Vec<PathBuf>, crs: Option<String> },
    /// City models, which are converted.
    Models(Vec<PathBuf>),
}

/// The options that also count where city models are converted.
const OF_CONVERSION: [&str; 5] = ["filename", "overwrite", "crs", "lod", "user_data"];

impl Lod2Writer {
    /// The files, when they are all that comes in and nobody waits for points behind this stage.
    fn source_of(flow: &Flow, is_last: bool) -> Source {
        let Some(files) = flow.files.as_ref().filter(|_| is_last) else { return Source::Points };
        let mut paths = Vec::new();
        let mut override_crs = None;
        for (i, file) in files.iter().enumerate() {
            let SourceFile::Tile { path, crs } = file else { return Source::Points };
            // A job has one CRS for all tiles.
            if i > 0 && override_crs != *crs {
                return Source::Points;
            }
            override_crs.clone_from(crs);
            paths.push(path.clone());
        }
        Source::Tiles { paths, crs: override_crs }
    }

    /// The city models, when nothing else comes in and all options that were given count for them.
    fn models(&self, flow: &Flow, model: &Path, is_last: bool) -> Result<Vec<PathBuf>, InputError> {
        let place = self.values.place();
        let given = self.values.to_json();
        if let Some(option) = given.keys().find(|option| !OF_CONVERSION.contains(&option.as_str())) {
            let found = format!("`{option}`, which is for points, with a city model as the input");
            return Err(place.fault(found, format!("one of {}", OF_CONVERSION.join(", "))));
        }
        let models = flow.files.iter().flatten().map(|file| match file {
            SourceFile::Model(path) => Some(path.clone()),
            SourceFile::Tile { .. } => None,
        });
        let fault = |found: &str, expected: &str| InputError::new(model, found, expected).at(place.stage.clone());
        let models: Option<Vec<PathBuf>> = models.collect();
        let models = models.ok_or_else(|| fault("a city model among points", "city models only, or points only"))?;
        if is_last { Ok(models) } else { Err(fault("a stage behind, which would get no points", "no stage behind")) }
    }

    /// Writes city models in another format.
    fn convert(&self, models: &[PathBuf], context: &Context<'_>) -> Result<Finished> {
        let conversion = Conversion {
            inputs: models.to_vec(),
            output: self.job.output.clone(),
            overwrite: self.job.overwrite,
            crs: self.job.crs.clone(),
            lods: self.values.texts("lod").into_iter().map(str::to_owned).collect(),
        };
        context.observer.ready(&conversion.output);
        let converted = convert(&conversion, &mut |_| {});
        let converted = converted.map_err(|error| in_words_of(&self.values, error))?;
        for warning in &converted.warnings {
            context.warn(warning);
        }
        context.observer.done(&converted.written.path);
        let metadata = Map::from_iter([
            ("filename".to_owned(), json!([converted.written.path.display().to_string()])),
            ("features".to_owned(), json!(converted.written.features)),
            ("objects".to_owned(), json!(converted.written.objects)),
        ]);
        Ok(Finished { metadata, ..Finished::default() })
    }

    /// Refuses an output that exists before a filter runs for hours; what is in the way of several files is known later.
    fn refuse_what_exists(&self) -> Result<()> {
        let names = match &self.source {
            Source::Tiles { paths, .. } => paths.clone(),
            Source::Points | Source::Models(_) => vec![self.values.place().file.clone()],
        };
        let may_be_there = self.job.overwrite || self.job.resume || self.job.goes_to_many_files()?;
        if may_be_there || sink::is_stream(&self.job.output) {
            return Ok(());
        }
        let model = self.job.base(&names)?;
        run::output::refuse_existing(&model).map_err(|fault| in_words_of(&self.values, fault))
    }

    fn start(&mut self) -> Result<Feed> {
        let mut feed = feed(&self.job, &self.values.place().file)?;
        for area in self.flow.areas.iter().flatten() {
            feed.cover(*area)?;
        }
        Ok(feed)
    }

    /// Takes points; those of another CRS than the first are refused.
    fn feed(&mut self, feed: &mut Feed, points: &Points) -> Result<()> {
        if feed.points() == 0 {
            self.crs.clone_from(&points.crs);
        } else if self.crs != points.crs && self.job.crs.is_none() {
            let name = |crs: &Option<Arc<Crs>>| crs.as_ref().map_or("no CRS".to_owned(), ToString::to_string);
            let found = format!("points in {} among points in {}", name(&points.crs), name(&self.crs));
            let fault = self.values.place().fault(found, "points of one CRS");
            return Err(fault.remedy("Put filters.reprojection before").into());
        }
        let layout = points.layout();
        let place = |name: &str| layout.find(name);
        let (class, number) = (place("Classification"), place("ReturnNumber"));
        let flags = ["Synthetic", "Withheld", "Overlap"].map(place);
        let value = |place: Option<usize>, i: usize| place.map_or(0.0, |place| points.get(place, i));
        feed.push((0..points.len()).map(|i| {
            let [synthetic, withheld, overlap] = flags.map(|place| value(place, i) != 0.0);
            let mut point = ScanPoint::new(points.position(i), value(class, i) as u8);
            point.return_number = value(number, i) as u8;
            (point.synthetic, point.withheld, point.overlap) = (synthetic, withheld, overlap);
            point
        }))
    }
}

impl Writer for Lod2Writer {
    fn prepare(&mut self, flow: &Flow, is_last: bool) -> Result<()> {
        if let Some(model) = flow.model() {
            self.source = Source::Models(self.models(flow, model, is_last)?);
            return Ok(());
        }
        job::complete(&self.values, &mut self.job)?;
        self.source = Self::source_of(flow, is_last);
        self.refuse_what_exists()?;
        self.flow = flow.clone();
        self.feed = None;
        self.crs.clone_from(&flow.crs);
        Ok(())
    }

    fn takes_models(&self) -> bool {
        true
    }

    fn needs_points(&self) -> bool {
        matches!(self.source, Source::Points)
    }

    fn write(&mut self, points: &Points, _context: &Context<'_>) -> Result<()> {
        let mut feed = match self.feed.take() {
            Some(feed) => feed,
            None => self.start()?,
        };
        self.feed(&mut feed, points)?;
        self.feed = Some(feed);
        Ok(())
    }

    fn finish(&mut self, context: &Context<'_>) -> Result<Finished> {
        if let Source::Models(models) = &self.source {
            return self.convert(models, context);
        }
        let mut job = self.job.clone();
        job.command = context.command.to_vec();
        match &self.source {
            Source::Points => {
                let feed = match self.feed.take() {
                    Some(feed) => feed,
                    None => self.start()?,
                };
                job.fed = Some(feed.finish(self.crs.as_ref().map(|crs| crs.wkt.as_str()))?);
            }
            Source::Tiles { paths, crs } => {
                for path in paths {
                    let text = path.to_str().ok_or_else(|| {
                        let fault = std::io::Error::new(std::io::ErrorKind::InvalidInput, "its name is not Unicode");
                        Error::io(path, "open", fault)
                    })?;
                    job.tiles.push(text.to_owned());
                }
                job.crs = job.crs.or_else(|| crs.clone());
            }
            Source::Models(_) => {}
        }
        let output = job.output.clone();
        context.observer.ready(&output);
        let report = run::run(&job, context.observer.reconstruction());
        let report = report.map_err(|error| in_words_of(&self.values, error))?;
        // The report comes last; a stream has no file to be named after.
        let written: Vec<PathBuf> = match report.outputs.split_last() {
            Some((_, models)) if !sink::is_stream(&output) => models.iter().map(PathBuf::from).collect(),
            _ => vec![output],
        };
        for path in &written {
            context.observer.done(path);
        }
        Ok(Finished { metadata: metadata(&report), exit_code: report.exit_code, report: Some(report) })
    }
}

/// What the metadata say of a reconstruction; the report says more.
fn metadata(report: &Report) -> Map<String, Value> {
    let counts = serde_json::to_value(&report.counts).unwrap_or_default();
    Map::from_iter([
        ("filename".to_owned(), json!(report.outputs)),
        ("counts".to_owned(), counts),
        ("exit_code".to_owned(), json!(report.exit_code)),
    ])
}
