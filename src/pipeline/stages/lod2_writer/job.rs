//! From the options of `writers.lod2` to a job.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use crate::error::{InputError, Result};
use crate::network::FieldOptions;
use crate::pipeline::options::{Tunable, Values, tuned, tunings};
use crate::pipeline::source::crs_of;
use crate::reconstruct::{Levels, Parameters};
use crate::run::{self, CloudSource, Feed, FootprintSource, Job, Limit};
use crate::segment::{BuildingClasses, SegmentOptions};
use crate::sink::{AttributeOptions, Format, Names, PointCloud, own_names, prefix};
use crate::source::footprints::FootprintOptions;
use crate::source::points::{Placement, Unit, UpAxis};
use crate::terrain::TerrainOptions;

/// The job without its points.
///
/// # Errors
/// A value that cannot be understood, options that contradict each other, or an output in no known format.
pub fn job(values: &Values, filename: &Path) -> Result<Job> {
    let given = |name: &str| values.text(name).map(str::to_owned);
    let has_footprints = values.is_given("footprints");
    if has_footprints && values.is_on("no_footprint") {
        return Err(values.place().fault("both `footprints` and `no_footprint`", "one of them").into());
    }
    if !has_footprints {
        let needless = [
            "roofprint",
            "footprint_crs",
            "layer",
            "query",
            "filter",
            "id_attribute",
            "footprint_attributes",
            "box",
            "limit_area",
        ];
        let needless = needless.into_iter().find(|name| values.is_given(name));
        if let Some(name) = needless {
            return Err(values.place().fault(format!("`{name}` without `footprints`"), "`footprints`").into());
        }
    }
    if filename.extension().is_some() && !filename.is_dir() {
        Format::of(filename).map_err(|fault| InputError { place: values.place().stage.clone(), ..fault })?;
    }
    let crs = values.text("footprint_crs").map(|text| crs_of(values, "footprint_crs", text)).transpose()?;
    let options = FootprintOptions {
        layer: given("layer"),
        query: given("query"),
        filter: given("filter"),
        id_attribute: given("id_attribute"),
        crs,
        within: None,
    };
    let date = values.text("point_cloud_date").map(run::recording_date).transpose();
    let date = date.map_err(|expected| {
        values.fault("point_cloud_date", &given("point_cloud_date").unwrap_or_default(), expected)
    })?;
    let segmentation = SegmentOptions {
        building_classes: building_classes(values)?,
        ground_classes: ground_classes(values)?,
        ..structure(values)?
    };
    let roofprints = values.text("roofprint").map(PathBuf::from);
    let parameters = Parameters { lod: Levels::usual(roofprints.is_some()), ..structure::<Parameters>(values)? };
    let job = Job {
        roofprints,
        footprints: given("footprints").map(|path| FootprintSource { path: path.into(), options }),
        clouds: clouds(values)?,
        limit: limit(values)?,
        output: filename.to_path_buf(),
        crop_only: values.is_on("crop_only"),
        edits: values.text("edits").map(PathBuf::from),
        title: given("title"),
        translation: translation(values)?,
        overwrite: values.is_on("overwrite"),
        resume: values.is_on("resume"),
        report: values.text("report").map(PathBuf::from),
        crs: given("crs"),
        placement: placement(values),
        threads: values.whole("jobs").and_then(|jobs| NonZeroUsize::new(usize::try_from(jobs).ok()?)),
        memory: memory(values)?,
        segmentation,
        parameters,
        field: structure::<FieldOptions>(values)?,
        terrain: terrain(values)?,
        attributes: attributes(values)?,
        point_cloud: PointCloud { source: given("point_cloud_source"), date },
        ..Job::default()
    };
    job.refuse_contradictions().map_err(|fault| InputError { place: values.place().stage.clone(), ..fault })?;
    Ok(job)
}

/// How much memory points that wait may take up.
fn memory(values: &Values) -> Result<Option<usize>, InputError> {
    let text = values.text("memory");
    text.map(|text| run::memory(text).map_err(|expected| values.place().fault(format!("`memory` {text:?}"), expected)))
        .transpose()
}

/// What the terrain shall be like, if there is to be one.
fn terrain(values: &Values) -> Result<Option<TerrainOptions>, InputError> {
    let options = structure::<TerrainOptions>(values)?;
    if values.is_on("terrain") {
        return Ok(Some(options));
    }
    let needless = tunings::<TerrainOptions>().into_iter().find(|tuning| values.is_given(&tuning.name));
    match needless {
        Some(tuning) => Err(values.place().fault(format!("`{}` without `terrain`", tuning.name), "`terrain`")),
        None => Ok(None),
    }
}

/// Completes the job with what only counts where points come in.
///
/// # Errors
/// Levels of detail that there are not, or neither footprints nor the wish for none.
pub fn complete(values: &Values, job: &mut Job) -> Result<(), InputError> {
    if job.footprints.is_none() && !values.is_on("no_footprint") {
        let expected = "`footprints`, or `no_footprint` for a single object";
        return Err(values.place().fault("neither `footprints` nor `no_footprint`", expected));
    }
    if values.is_given("lod") {
        let text = values.texts("lod").join(",");
        let fault =
            || values.fault("lod", &format!("`{text}`"), "some of 0, 0.1, 0.3, 1.2, 1.3, 2.2, 2.3, parted by commas");
        job.parameters.lod = text.parse().map_err(|_| fault())?;
        job.refuse_contradictions().map_err(|fault| InputError { place: values.place().stage.clone(), ..fault })?;
    }
    Ok(())
}

/// Opens the feed before the first point: an output that cannot be written must not cost an hour of reading. The points,
/// which messages call `name`, wait beside the output.
///
/// # Errors
/// The output exists and is not to be replaced, or cannot be written.
pub fn feed(job: &Job, name: &Path) -> Result<Feed> {
    let model = model(job, name);
    run::output::prepare(&model, job.overwrite || job.resume)?;
    let folder = model.parent().filter(|folder| !folder.as_os_str().is_empty());
    Feed::new_in(folder.unwrap_or(Path::new(".")), name)
}

/// The file that the model of points called `name` goes to.
pub(super) fn model(job: &Job, name: &Path) -> PathBuf {
    let footprints = job.footprints.as_ref().map(FootprintSource::name);
    run::output::model_path(&job.output, &[name.to_path_buf()], footprints.as_deref())
}

/// How coordinates without a CRS are meant.
fn placement(values: &Values) -> Option<Placement> {
    let unit = values.text("unit").and_then(|name| Unit::ALL.into_iter().find(|unit| unit.name().0 == name));
    let up = values.text("up_axis").and_then(|name| UpAxis::ALL.into_iter().find(|up| up.name().0 == name));
    Placement::given(unit, up)
}

/// A structure with what was given of its fields.
fn structure<T: Tunable>(values: &Values) -> Result<T, InputError> {
    tuned(&T::default(), |name| values.given(name)).map_err(|(name, reason)| values.fault(&name, "a value", reason))
}

/// More point clouds.
fn clouds(values: &Values) -> Result<Vec<CloudSource>, InputError> {
    let cloud = |text: &str| run::cloud(text).map_err(|expected| values.fault("cloud", &format!("`{text}`"), expected));
    values.texts("cloud").into_iter().map(cloud).collect()
}

/// Which part of the footprints.
fn limit(values: &Values) -> Result<Limit, InputError> {
    let text = values.texts("box").join(",");
    let bounds = values.is_given("box").then(|| run::bounds(&text)).transpose();
    let bounds = bounds.map_err(|expected| values.fault("box", &format!("`{text}`"), expected))?;
    Ok(Limit { bounds, area: values.text("limit_area").map(PathBuf::from) })
}

/// Where the number 0 of the coordinates is.
fn translation(values: &Values) -> Result<Option<[f64; 3]>, InputError> {
    let text = values.texts("translation").join(",");
    let place = values.is_given("translation").then(|| run::translation(&text)).transpose();
    place.map_err(|expected| values.fault("translation", &format!("`{text}`"), expected))
}

/// Which attributes are written.
fn attributes(values: &Values) -> Result<AttributeOptions, InputError> {
    let all = AttributeOptions::default();
    let names = |option: &str, read: fn(&str) -> Result<Names, String>| {
        if !values.is_given(option) {
            return Ok(Names::All);
        }
        let text = values.texts(option).join(",");
        read(&text).map_err(|expected| values.fault(option, &format!("`{text}`"), expected))
    };
    let own = names("attributes", own_names)?;
    let source = names("footprint_attributes", str::parse)?;
    let given = values.text("attribute_prefix").unwrap_or(&all.prefix);
    let prefix = prefix(given).map_err(|expected| values.fault("attribute_prefix", &format!("`{given}`"), expected))?;
    Ok(AttributeOptions { own, prefix, source })
}

fn building_classes(values: &Values) -> Result<BuildingClasses, InputError> {
    if !values.is_given("building_class") {
        return Ok(SegmentOptions::default().building_classes);
    }
    let text = values.texts("building_class").join(",");
    text.parse()
        .map_err(|_| values.fault("building_class", &format!("`{text}`"), "classes from 0 to 255 such as 1,6, or any"))
}

fn ground_classes(values: &Values) -> Result<Vec<u8>, InputError> {
    if !values.is_given("ground_class") {
        return Ok(SegmentOptions::default().ground_classes);
    }
    let texts = values.texts("ground_class");
    let classes: Result<Vec<u8>, _> = texts.iter().map(|text| text.parse::<u8>()).collect();
    classes.map_err(|_| {
        values.fault("ground_class", &format!("`{}`", texts.join(",")), "classes from 0 to 255 such as 2,8")
    })
}
