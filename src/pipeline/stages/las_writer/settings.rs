//! What the options of `writers.las` come to, with what is taken from the headers of the sources.

use std::path::Path;
use std::sync::Arc;

use las::{Header, Vlr};

use crate::error::InputError;
use crate::pipeline::expression::Misfit;
use crate::pipeline::nearest::nearest;
use crate::pipeline::options::Values;
use crate::pipeline::points::NumberType;
use crate::pipeline::source::crs_of;
use crate::pipeline::stage::Flow;
use crate::source::crs::Crs;

/// The fields of `header` in `forward`.
const HEADER: [&str; 10] = [
    "major_version",
    "minor_version",
    "dataformat_id",
    "filesource_id",
    "global_encoding",
    "project_id",
    "system_id",
    "software_id",
    "creation_doy",
    "creation_year",
];
const SCALE: [&str; 3] = ["scale_x", "scale_y", "scale_z"];
const OFFSET: [&str; 3] = ["offset_x", "offset_y", "offset_z"];
/// Dimensions that are part of every point but not of every record, and are no extra dimension for that.
const NEVER_EXTRA: [&str; 1] = ["Overlap"];

/// A number that is given, or follows from the points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Number {
    /// This one.
    Is(f64),
    /// It follows from the points.
    Auto,
}

/// What a file is to be like.
#[derive(Debug, Clone)]
pub struct Settings {
    pub minor_version: u8,
    pub format: u8,
    /// Whether the point format follows from the points.
    pub follows_points: bool,
    pub scale: [Number; 3],
    pub offset: [Number; 3],
    pub system_id: String,
    pub software_id: String,
    pub filesource_id: u16,
    /// Year and day of the year.
    creation: (Option<u16>, Option<u16>),
    pub crs: Option<Arc<Crs>>,
    pub extra: Vec<(String, NumberType)>,
    /// Further records of the source.
    pub vlrs: Vec<Vlr>,
    /// The header whose meaning of times is taken over.
    pub encoding_of: Option<Arc<Header>>,
    /// The header whose identifier is taken over.
    pub id_of: Option<Arc<Header>>,
    compression: Option<bool>,
}

impl Settings {
    /// The settings for points of this flow.
    ///
    /// # Errors
    /// Options that do not go together or with the points.
    pub fn new(values: &Values, flow: &Flow) -> Result<Self, InputError> {
        let forward = Forward::new(values, flow)?;
        let whole = |name: &str| values.given(name).and_then(serde_json::Value::as_u64);
        let format = whole("dataformat_id")
            .map(|format| format as u8)
            .or_else(|| forward.of("dataformat_id", |header| header.point_format().to_u8().ok()).flatten());
        let minor_version = whole("minor_version")
            .map(|version| version as u8)
            .or_else(|| forward.of("minor_version", |header| header.version().minor))
            .unwrap_or(4);
        let format = format.unwrap_or(if minor_version < 4 { 3 } else { 7 });
        if !matches!(format, 0..=3 | 6..=8) {
            let expected = "a point format from 0 to 3 or 6 to 8: those with waveforms cannot be written";
            return Err(values.fault("dataformat_id", &format.to_string(), expected));
        }
        if format >= 6 && minor_version < 4 {
            let found = format!("point format {format} in LAS 1.{minor_version}");
            let expected = "LAS 1.4 (`minor_version` 4), or a point format from 0 to 3";
            return Err(values.place().fault(found, expected));
        }
        if format >= 2 && minor_version < 2 {
            let found = format!("point format {format} in LAS 1.{minor_version}");
            return Err(values.place().fault(found, "LAS 1.2 or later, or point format 0 or 1"));
        }
        Self::of_format(values, flow, &forward, [minor_version, format])
    }

    /// The settings of a COPC file for points of this flow: LAS 1.4, with colours where the points have some.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn of_copc(values: &Values, flow: &Flow) -> Result<Self, InputError> {
        let has = |name: &str| flow.layout.find(name).is_some();
        let format = match (has("Infrared"), ["Red", "Green", "Blue"].into_iter().any(has)) {
            (true, _) => 8,
            (false, true) => 7,
            (false, false) => 6,
        };
        let settings = Self::of_format(values, flow, &Forward::new(values, flow)?, [4, format])?;
        Ok(Self { follows_points: true, ..settings })
    }

    /// The settings for a version of LAS and a point format that go together.
    fn of_format(
        values: &Values,
        flow: &Flow,
        forward: &Forward<'_>,
        [minor_version, format]: [u8; 2],
    ) -> Result<Self, InputError> {
        let whole = |name: &str| values.given(name).and_then(serde_json::Value::as_u64);
        let numbers = |names: [&str; 3], of: fn(&las::Transform) -> f64, usual: f64| {
            let mut numbers = [Number::Is(usual); 3];
            for (axis, name) in names.into_iter().enumerate() {
                let transform = |header: &Header| {
                    let transforms = header.transforms();
                    of([&transforms.x, &transforms.y, &transforms.z][axis])
                };
                numbers[axis] = match values.given(name) {
                    Some(value) => value.as_f64().map_or(Number::Auto, Number::Is),
                    None => Number::Is(forward.of(name, transform).unwrap_or(usual)),
                };
            }
            numbers
        };
        let scale = numbers(SCALE, |transform| transform.scale, 0.01);
        if let Some(axis) = scale.iter().position(|scale| matches!(scale, Number::Is(s) if !s.is_normal())) {
            return Err(values.fault(SCALE[axis], "0", "a number other than 0"));
        }
        let text = |name: &str, of: fn(&Header) -> &str, usual: String| {
            let given = values.given(name).and_then(|value| value.as_str().map(str::to_owned));
            given.or_else(|| forward.of(name, |header| of(header).to_owned())).unwrap_or(usual)
        };
        let crs = values.text("a_srs").map(|text| crs_of(values, "a_srs", text)).transpose()?.map(Arc::new);
        let ours = format!("gable {}", env!("CARGO_PKG_VERSION"));
        let day = |part: fn(&Header) -> Option<u16>, name: &str| {
            whole(name).map(|n| n as u16).or_else(|| forward.of(name, part).flatten())
        };
        Ok(Self {
            minor_version,
            format,
            follows_points: false,
            scale,
            offset: numbers(OFFSET, |transform| transform.offset, 0.0),
            system_id: text("system_id", Header::system_identifier, "gable".to_owned()),
            software_id: text("software_id", Header::generating_software, ours),
            filesource_id: whole("filesource_id")
                .map(|id| id as u16)
                .or_else(|| forward.of("filesource_id", Header::file_source_id))
                .unwrap_or(0),
            creation: (
                day(|header| Some(header.clone().into_raw().ok()?.file_creation_year), "creation_year"),
                day(|header| Some(header.clone().into_raw().ok()?.file_creation_day_of_year), "creation_doy"),
            ),
            crs,
            extra: extra_dimensions(values, flow, format)?,
            vlrs: forward.vlrs(),
            encoding_of: forward.same("global_encoding", |header| {
                (header.gps_time_type().is_standard(), header.has_synthetic_return_numbers())
            }),
            id_of: forward.same("project_id", Header::guid),
            compression: compression(values)?,
        })
    }

    /// Whether a number follows from the points.
    pub fn is_automatic(&self) -> bool {
        self.scale.iter().chain(&self.offset).any(|number| *number == Number::Auto)
    }

    /// Whether a file of this name is compressed.
    pub fn is_compressed(&self, path: &Path) -> bool {
        let by_name = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("laz"));
        self.compression.unwrap_or(by_name) || by_name
    }

    /// Gives a file its date; a year without a day means its first.
    pub fn date(&self, builder: &mut las::Builder) {
        let (Some(year), day) = self.creation else { return };
        let raw = las::raw::Header {
            file_creation_year: year,
            file_creation_day_of_year: day.unwrap_or(1),
            ..las::raw::Header::default()
        };
        builder.date = las::Builder::new(raw).ok().and_then(|builder| builder.date);
    }
}

/// Whether `compression` was asked for: PDAL takes the names of libraries for true.
fn compression(values: &Values) -> Result<Option<bool>, InputError> {
    let Some(text) = values.text("compression") else { return Ok(None) };
    match text.to_ascii_lowercase().as_str() {
        "true" | "laszip" | "lazperf" => Ok(Some(true)),
        "false" | "none" => Ok(Some(false)),
        _ => Err(values.fault("compression", &format!("`{text}`"), "true or false")),
    }
}

/// The dimensions that are written behind the others.
fn extra_dimensions(values: &Values, flow: &Flow, format: u8) -> Result<Vec<(String, NumberType)>, InputError> {
    let mut extra: Vec<(String, NumberType)> = Vec::new();
    let fault = |text: &str, expected: &str| values.misfit("extra_dims", Misfit::new(format!("`{text}`"), expected));
    let mut builder = las::Builder::from((1, 4));
    builder.point_format = las::point::Format::new(format)
        .map_err(|e| values.fault("dataformat_id", &format.to_string(), e.to_string()))?;
    let header =
        builder.into_header().map_err(|e| values.fault("dataformat_id", &format.to_string(), e.to_string()))?;
    let record = crate::pipeline::las::Record::new(&header, &[]);
    let is_known = !flow.layout.dimensions().is_empty() && !flow.headers.is_empty();
    for text in values.texts("extra_dims") {
        if text.eq_ignore_ascii_case("all") {
            let further =
                flow.layout.dimensions().iter().filter(|dimension| {
                    !record.has(&dimension.name) && !NEVER_EXTRA.contains(&dimension.name.as_str())
                });
            extra.extend(further.map(|dimension| (dimension.name.clone(), dimension.kind)));
            continue;
        }
        let Some((name, kind)) = text.split_once('=') else {
            return Err(fault(text, "NAME=TYPE such as HeightAboveGround=float32, or `all`"));
        };
        let name = name.trim();
        let Some(kind) = NumberType::parse(kind) else {
            let types: Vec<&str> = NumberType::ALL.iter().map(|kind| kind.name()).collect();
            return Err(fault(text, &format!("a type out of {}", types.join(", "))));
        };
        let own = match flow.layout.require(name) {
            Ok(place) => flow.layout.dimensions()[place].name.clone(),
            Err(known) if is_known => return Err(fault(name, &known)),
            Err(_) => name.to_owned(),
        };
        if record.has(&own) {
            return Err(fault(name, "a dimension that the point format does not have anyway"));
        }
        extra.push((own, kind));
    }
    Ok(extra)
}

/// What is taken from the headers of the sources.
struct Forward<'a> {
    fields: Vec<&'static str>,
    vlrs: bool,
    headers: &'a [Arc<Header>],
}

impl<'a> Forward<'a> {
    fn new(values: &Values, flow: &'a Flow) -> Result<Self, InputError> {
        let mut forward = Self { fields: Vec::new(), vlrs: false, headers: &flow.headers };
        for name in values.texts("forward") {
            let known = || HEADER.into_iter().chain(SCALE).chain(OFFSET);
            match name.to_ascii_lowercase().as_str() {
                "header" => forward.fields.extend(HEADER),
                "scale" => forward.fields.extend(SCALE),
                "offset" => forward.fields.extend(OFFSET),
                "vlr" => forward.vlrs = true,
                "all" => {
                    forward.fields.extend(known());
                    forward.vlrs = true;
                }
                name => {
                    let Some(field) = known().find(|field| *field == name) else {
                        let groups = ["header", "scale", "offset", "vlr", "all"];
                        let near = nearest(name, known().chain(groups)).map(|near| format!("`{near}`, or another of "));
                        let names: Vec<&str> = groups.into_iter().chain(known()).collect();
                        let expected = format!("{}{}", near.unwrap_or_default(), names.join(", "));
                        return Err(values.fault("forward", &format!("`{name}`"), expected));
                    };
                    forward.fields.push(field);
                }
            }
        }
        Ok(forward)
    }

    /// The value of a field, when it is asked for and all sources have the same.
    fn of<T: PartialEq>(&self, field: &str, of: impl Fn(&Header) -> T) -> Option<T> {
        self.same(field, &of).map(|header| of(&header))
    }

    /// A header whose value of a field all sources have, when it is asked for.
    fn same<T: PartialEq>(&self, field: &str, of: impl Fn(&Header) -> T) -> Option<Arc<Header>> {
        let first = self.headers.first().filter(|_| self.fields.contains(&field))?;
        self.headers.iter().all(|header| of(header) == of(first)).then(|| Arc::clone(first))
    }

    /// The records of the sources, without those that say how the file is built and where it lies.
    fn vlrs(&self) -> Vec<Vlr> {
        let passes = |vlr: &&Vlr| {
            let user = vlr.user_id.to_ascii_lowercase();
            let is_of_the_format = user == "lasf_spec" && !matches!(vlr.record_id, 0 | 3);
            !matches!(user.as_str(), "lasf_projection" | "liblas" | "laszip encoded" | "copc") && !is_of_the_format
        };
        let headers = self.headers.iter().filter(|_| self.vlrs);
        headers.flat_map(|header| header.all_vlrs().filter(passes).cloned()).collect()
    }
}
