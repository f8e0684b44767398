//! `filters.stats`: figures of dimensions, for the metadata.

use std::collections::BTreeMap;

use serde_json::{Map, Value, json};

use crate::error::Result;
use crate::pipeline::options::{Kind, OptionSpec, Values};
use crate::pipeline::points::{Chosen, Points};
use crate::pipeline::stage::{Context, Filter, Flow, Role, Stage, StageKind};

/// The type of this stage.
pub const KIND: StageKind = StageKind {
    name: "filters.stats",
    summary: "Puts figures of dimensions into the metadata: count, least, largest, mean, deviation",
    role: Role::Filter,
    options,
    elsewhere: &["commonsrs", "option_file"],
    collects: "",
    build,
};

fn options() -> Vec<OptionSpec> {
    vec![
        OptionSpec::new("dimensions", Kind::Names, "Of which dimensions; all when it is not given"),
        OptionSpec::new("enumerate", Kind::Names, "Of which of them to list the values"),
        OptionSpec::new("count", Kind::Names, "Of which of them to list the values, each with how often it comes"),
        OptionSpec::new(
            "global",
            Kind::Names,
            "Of which of them to give median and median absolute deviation; keeps their values",
        ),
        OptionSpec::new("advanced", Kind::Boolean, "Whether skewness and kurtosis are given").or(false),
    ]
}

#[expect(clippy::unnecessary_wraps, reason = "the type of all stages")]
fn build(values: &Values) -> Result<Stage> {
    let stats = Stats { values: values.clone(), figures: Vec::new(), warnings: Vec::new() };
    Ok(Stage::Filter(Box::new(stats)))
}

/// What is listed of the values of a dimension.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Listing {
    None,
    Values,
    Counts,
    Median,
}

struct Stats {
    values: Values,
    figures: Vec<Figures>,
    warnings: Vec<String>,
}

/// The figures of a dimension.
#[derive(Debug, Clone)]
struct Figures {
    name: String,
    place: usize,
    listing: Listing,
    minimum: f64,
    maximum: f64,
    /// Number, mean, and sums of the second to fourth powers of the deviations from it.
    n: f64,
    mean: f64,
    powers: [f64; 3],
    /// How often each value came, by the bits of a number that sorts like it.
    counts: BTreeMap<Sorted, u64>,
    all: Vec<f64>,
}

/// A number in the order of numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Sorted(f64);

impl Eq for Sorted {}

impl PartialOrd for Sorted {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Sorted {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

impl Figures {
    fn new(name: String, place: usize) -> Self {
        Self {
            name,
            place,
            listing: Listing::None,
            minimum: f64::INFINITY,
            maximum: f64::NEG_INFINITY,
            n: 0.0,
            mean: 0.0,
            powers: [0.0; 3],
            counts: BTreeMap::new(),
            all: Vec::new(),
        }
    }

    /// Takes a value in. The sums are updated so that no digits are lost (Pébay, Sandia report SAND2008-6212, with one
    /// value at a time).
    fn take(&mut self, value: f64) {
        self.minimum = self.minimum.min(value);
        self.maximum = self.maximum.max(value);
        let before = self.n;
        self.n += 1.0;
        let n = self.n;
        let delta = value - self.mean;
        let step = delta / n;
        let term = delta * step * before;
        self.mean += step;
        let [second, third, fourth] = &mut self.powers;
        *fourth += term * step * step * (n * n - 3.0 * n + 3.0) + 6.0 * step * step * *second - 4.0 * step * *third;
        *third += term * step * (n - 2.0) - 3.0 * step * *second;
        *second += term;
        match self.listing {
            Listing::None => {}
            Listing::Values | Listing::Counts => *self.counts.entry(Sorted(value)).or_default() += 1,
            Listing::Median => self.all.push(value),
        }
    }

    /// Of the sample, like the other figures.
    fn variance(&self) -> f64 {
        self.powers[0] / (self.n - 1.0)
    }

    fn skewness(&self) -> f64 {
        let n = self.n;
        let population = n.sqrt() * self.powers[1] / self.powers[0].powf(1.5);
        population * (n * (n - 1.0)).sqrt() / (n - 2.0)
    }

    /// Beyond that of the normal distribution.
    fn kurtosis(&self) -> f64 {
        let n = self.n;
        let excess = n * self.powers[2] / self.powers[0].powi(2) - 3.0;
        (n - 1.0) / ((n - 2.0) * (n - 3.0)) * ((n + 1.0) * excess + 6.0)
    }

    /// As PDAL's metadata has it.
    fn to_json(&self, position: usize, is_advanced: bool) -> Value {
        let mut figures = Map::new();
        let mut add = |name: &str, value: Value| {
            if !value.is_null() {
                figures.insert(name.to_owned(), value);
            }
        };
        add("position", json!(position));
        add("count", json!(self.n as u64));
        for (name, value) in figures_of(self, is_advanced) {
            add(name, json!(value));
        }
        add("name", json!(self.name));
        match self.listing {
            Listing::None => {}
            Listing::Values => add("values", self.counts.keys().map(|value| json!(value.0)).collect()),
            Listing::Counts => {
                add("counts", self.counts.iter().map(|(value, n)| json!(format!("{:.6}/{n}", value.0))).collect());
            }
            Listing::Median => {
                let median = median(self.all.clone());
                let deviations = self.all.iter().map(|value| (value - median).abs()).collect();
                add("median", json!(median));
                add("mad", json!(self::median(deviations)));
            }
        }
        Value::Object(figures)
    }
}

fn figures_of(figures: &Figures, is_advanced: bool) -> Vec<(&'static str, f64)> {
    if figures.n == 0.0 {
        return Vec::new();
    }
    let mut all = vec![
        ("minimum", figures.minimum),
        ("maximum", figures.maximum),
        ("average", figures.mean),
        ("stddev", figures.variance().sqrt()),
        ("variance", figures.variance()),
    ];
    if is_advanced {
        all.extend([("kurtosis", figures.kurtosis()), ("skewness", figures.skewness())]);
    }
    all
}

/// The upper median; not a number where there is no value.
fn median(mut values: Vec<f64>) -> f64 {
    let middle = values.len() / 2;
    if values.is_empty() {
        return f64::NAN;
    }
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

impl Filter for Stats {
    fn prepare(&mut self, flow: &mut Flow) -> Result<()> {
        self.figures.clear();
        self.warnings.clear();
        let asked = self.values.texts("dimensions");
        if asked.is_empty() {
            let all = flow.layout.dimensions().iter().enumerate();
            self.figures.extend(all.map(|(place, d)| Figures::new(d.name.clone(), place)));
        }
        for name in asked {
            match flow.layout.find(name) {
                Some(place) if self.figures.iter().any(|own| own.place == place) => {}
                Some(place) => self.figures.push(Figures::new(flow.layout.dimensions()[place].name.clone(), place)),
                None => self.warnings.push(format!("filters.stats: there is no dimension `{name}`")),
            }
        }
        let listings = [("enumerate", Listing::Values), ("count", Listing::Counts), ("global", Listing::Median)];
        for (option, listing) in listings {
            for name in self.values.texts(option) {
                match self.figures.iter_mut().find(|own| own.name.eq_ignore_ascii_case(name)) {
                    Some(figures) => figures.listing = listing,
                    None => self.warnings.push(format!(
                        "filters.stats: `{name}` in `{option}` is none of the dimensions whose figures are taken"
                    )),
                }
            }
        }
        Ok(())
    }

    fn chunk(&mut self, points: &mut Points, chosen: &Chosen) -> Result<()> {
        for figures in &mut self.figures {
            for i in (0..points.len()).filter(|&i| chosen.has(i)) {
                figures.take(points.get(figures.place, i));
            }
        }
        Ok(())
    }

    fn finish(&mut self, context: &Context<'_>) {
        for warning in &self.warnings {
            context.warn(warning);
        }
    }

    fn metadata(&self) -> Map<String, Value> {
        let is_advanced = self.values.is_on("advanced");
        let all = self.figures.iter().enumerate().map(|(position, figures)| figures.to_json(position, is_advanced));
        let mut metadata = Map::from_iter([("statistic".to_owned(), all.collect())]);
        let of = |name: &str| self.figures.iter().find(|own| own.name == name).filter(|own| own.n > 0.0);
        if let (Some(x), Some(y), Some(z)) = (of("X"), of("Y"), of("Z")) {
            let bbox = json!({
                "minx": x.minimum, "miny": y.minimum, "minz": z.minimum,
                "maxx": x.maximum, "maxy": y.maximum, "maxz": z.maximum,
            });
            metadata.insert("bbox".to_owned(), json!({ "native": { "bbox": bbox } }));
        }
        metadata
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_by_hand() {
        let mut figures = Figures::new("Z".into(), 2);
        for value in [2.0, 4.0, 4.0, 4.0, 5.0, 5.0, 7.0, 9.0] {
            figures.take(value);
        }
        // Mean 5; deviations -3 -1 -1 -1 0 0 2 4, their squares 32, cubes 42, fourth powers 356.
        assert_eq!((figures.minimum, figures.maximum, figures.mean), (2.0, 9.0, 5.0));
        let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
        assert!(near(figures.powers[0], 32.0) && near(figures.powers[1], 42.0) && near(figures.powers[2], 356.0));
        assert!(near(figures.variance(), 32.0 / 7.0));
        // 0.65625 × √56 / 6, and 7 / 30 × (9 × (8 × 356 / 1024 - 3) + 6).
        assert!(near(figures.skewness(), 0.65625 * 56.0_f64.sqrt() / 6.0), "{}", figures.skewness());
        assert!(near(figures.kurtosis(), 7.0 / 30.0 * (9.0 * (2848.0 / 1024.0 - 3.0) + 6.0)), "{}", figures.kurtosis());
        assert_eq!(median(vec![3.0, 1.0, 2.0, 9.0]), 3.0);
    }
}
