//! `writers.text`: points as CSV or GeoJSON, in PDAL's format to the letter.

use std::io::{self, Write};
use std::path::PathBuf;

use serde_json::{Map, json};

use crate::error::{Error, InputError, Result};
use crate::pipeline::expression::Misfit;
use crate::pipeline::options::{Kind, OptionSpec, Values};
use crate::pipeline::output::{NewFile, Sturdy};
use crate::pipeline::points::{Layout, Points};
use crate::pipeline::stage::{Context, Finished, Flow, Role, Stage, StageKind, Writer};

/// The type of this stage.
pub const KIND: StageKind = StageKind {
    name: "writers.text",
    summary: "Writes points as CSV or GeoJSON",
    role: Role::Writer,
    options,
    elsewhere: &["option_file"],
    collects: "",
    build,
};

fn options() -> Vec<OptionSpec> {
    let formats = Kind::choice(&[("csv", "a line per point"), ("geojson", "a feature per point")]);
    vec![
        OptionSpec::new("filename", Kind::File, "File, or STDOUT for standard output").required(),
        OptionSpec::new("format", formats, "Format").or("csv"),
        OptionSpec::new(
            "order",
            Kind::Text,
            "Dimensions that come first, each perhaps with its precision: `X:2,Y:2,Classification:0`",
        ),
        OptionSpec::new("keep_unspecified", Kind::Boolean, "Whether dimensions that `order` does not name follow")
            .or(true),
        OptionSpec::new("precision", Kind::whole(0, 30), "Digits behind the point").or(3),
        OptionSpec::new("write_header", Kind::Boolean, "Whether a header is written").or(true),
        OptionSpec::new("quote_header", Kind::Boolean, "CSV: whether names in the header are in quotation marks")
            .or(true),
        OptionSpec::new("delimiter", Kind::Text, "CSV: what stands between values").or(","),
        OptionSpec::new("newline", Kind::Text, "CSV: what ends a line").or("\n"),
        OptionSpec::new("jscallback", Kind::Text, "GeoJSON: name of a function that is called with it"),
    ]
}

#[expect(clippy::unnecessary_wraps, reason = "the type of all stages")]
fn build(values: &Values) -> Result<Stage> {
    Ok(Stage::Writer(Box::new(TextWriter {
        filename: values.text("filename").unwrap_or_default().into(),
        is_geojson: values.text("format") == Some("geojson"),
        values: values.clone(),
        columns: Vec::new(),
        coordinates: [3; 3],
        target: None,
        features: 0,
    })))
}

struct TextWriter {
    values: Values,
    filename: PathBuf,
    is_geojson: bool,
    /// The dimensions that are written: place, name and precision.
    columns: Vec<(usize, String, usize)>,
    /// The precisions of the coordinates of features.
    coordinates: [usize; 3],
    target: Option<Target>,
    features: u64,
}

enum Target {
    File(NewFile, Sturdy),
    /// Standard output; over when nobody listens any more.
    Out {
        is_over: bool,
    },
}

impl Target {
    fn write(&mut self, bytes: &[u8]) -> Result<()> {
        match self {
            Self::File(file, sturdy) => {
                // It never fails; what went wrong is kept.
                let _ = sturdy.write_all(bytes);
                file.check()
            }
            Self::Out { is_over: true } => Ok(()),
            Self::Out { is_over } => match io::stdout().lock().write_all(bytes) {
                Err(fault) if fault.kind() == io::ErrorKind::BrokenPipe => {
                    *is_over = true;
                    Ok(())
                }
                outcome => outcome.map_err(|e| Error::io("standard output", "write", e)),
            },
        }
    }
}

impl TextWriter {
    /// The dimensions in the order in which they are written.
    fn arrange(&mut self, layout: &Layout) -> Result<(), InputError> {
        let fault = |text: &str, expected: String| {
            let misfit = Misfit::new(format!("`{text}`"), expected);
            self.values.misfit("order", misfit)
        };
        let usual = self.values.whole("precision").unwrap_or(3) as usize;
        let order = self.values.text("order").unwrap_or_default();
        let mut columns: Vec<(usize, String, usize)> = Vec::new();
        for text in order.split(',').map(str::trim).filter(|text| !text.is_empty()) {
            let (name, precision) = match text.split_once(':') {
                None => (text, usual),
                Some((name, digits)) => {
                    let digits = digits.trim().parse().ok().filter(|digits: &usize| *digits <= 30);
                    let digits =
                        digits.ok_or_else(|| fault(text, "a dimension and its precision, such as X:3".into()))?;
                    (name.trim(), digits)
                }
            };
            let place = layout.require(name).map_err(|known| fault(name, known))?;
            columns.push((place, layout.dimensions()[place].name.clone(), precision));
        }
        if columns.is_empty() || self.values.is_on("keep_unspecified") {
            for (place, dimension) in layout.dimensions().iter().enumerate() {
                if !columns.iter().any(|(own, ..)| *own == place) {
                    columns.push((place, dimension.name.clone(), usual));
                }
            }
        }
        self.coordinates = std::array::from_fn(|axis| {
            columns.iter().find(|(place, ..)| *place == axis).map_or(usual, |(.., precision)| *precision)
        });
        self.columns = columns;
        Ok(())
    }

    /// Opens the file and writes what stands before the points.
    fn open(&mut self, context: &Context<'_>) -> Result<()> {
        if self.target.is_some() {
            return Ok(());
        }
        context.observer.ready(&self.filename);
        let mut target = if self.filename.as_os_str().eq_ignore_ascii_case("stdout") {
            Target::Out { is_over: false }
        } else {
            let (file, sturdy) = NewFile::create(&self.filename)?;
            Target::File(file, sturdy)
        };
        let mut head = String::new();
        if self.values.is_on("write_header") {
            if self.is_geojson {
                if let Some(callback) = self.values.text("jscallback") {
                    head = format!("{callback}(");
                }
                head += "{ \"type\": \"FeatureCollection\", \"features\": [";
            } else {
                let quote = if self.values.is_on("quote_header") { "\"" } else { "" };
                let names: Vec<String> =
                    self.columns.iter().map(|(_, name, _)| format!("{quote}{name}{quote}")).collect();
                head = names.join(&self.delimiter()) + &self.newline();
            }
        }
        target.write(head.as_bytes())?;
        self.target = Some(target);
        Ok(())
    }

    fn delimiter(&self) -> String {
        escaped(self.values.text("delimiter").unwrap_or(","))
    }

    fn newline(&self) -> String {
        escaped(self.values.text("newline").unwrap_or("\n"))
    }
}

/// A text in which `\n`, `\r` and `\t` may be written out.
fn escaped(text: &str) -> String {
    text.replace("\\r", "\r").replace("\\n", "\n").replace("\\t", "\t")
}

/// A number as C writes it.
fn number(value: f64, precision: usize, out: &mut Vec<u8>) {
    let text = if value.is_nan() { "nan".to_owned() } else { format!("{value:.precision$}") };
    out.extend_from_slice(text.as_bytes());
}

impl Writer for TextWriter {
    fn prepare(&mut self, flow: &Flow, _is_last: bool) -> Result<()> {
        self.arrange(&flow.layout)?;
        self.target = None;
        self.features = 0;
        Ok(())
    }

    fn write(&mut self, points: &Points, context: &Context<'_>) -> Result<()> {
        self.open(context)?;
        let (delimiter, newline) = (self.delimiter(), self.newline());
        let mut out = Vec::with_capacity(points.len() * 16 * self.columns.len());
        for i in 0..points.len() {
            if !self.is_geojson {
                for (n, (place, _, precision)) in self.columns.iter().enumerate() {
                    if n > 0 {
                        out.extend_from_slice(delimiter.as_bytes());
                    }
                    number(points.get(*place, i), *precision, &mut out);
                }
                out.extend_from_slice(newline.as_bytes());
                continue;
            }
            if self.features > 0 {
                out.push(b',');
            }
            self.features += 1;
            out.extend_from_slice(b"{ \"type\":\"Feature\",\"geometry\": { \"type\": \"Point\", \"coordinates\": [");
            for (axis, precision) in self.coordinates.into_iter().enumerate() {
                if axis > 0 {
                    out.push(b',');
                }
                number(points.get(axis, i), precision, &mut out);
            }
            out.extend_from_slice(b"]},\"properties\": {");
            for (n, (place, name, precision)) in self.columns.iter().enumerate() {
                let comma = if n > 0 { "," } else { "" };
                out.extend_from_slice(format!("{comma}\"{name}\":\"").as_bytes());
                number(points.get(*place, i), *precision, &mut out);
                out.push(b'"');
            }
            out.extend_from_slice(b"}}");
        }
        match &mut self.target {
            Some(target) => target.write(&out),
            None => Ok(()),
        }
    }

    fn finish(&mut self, context: &Context<'_>) -> Result<Finished> {
        self.open(context)?;
        let Some(mut target) = self.target.take() else { return Ok(Finished::default()) };
        if self.is_geojson {
            let end = if self.values.is_given("jscallback") { "]})" } else { "]}" };
            target.write(end.as_bytes())?;
        }
        if let Target::File(file, sturdy) = target {
            drop(sturdy);
            file.commit()?;
        }
        context.observer.done(&self.filename);
        let filename = json!([self.filename.display().to_string()]);
        Ok(Finished { metadata: Map::from_iter([("filename".to_owned(), filename)]), ..Finished::default() })
    }
}
