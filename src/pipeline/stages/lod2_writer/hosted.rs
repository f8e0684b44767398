//! The stage in another program, which hands over the points that its own stages give.

use std::path::{Path, PathBuf};

use serde_json::{Map, Value};

use super::{KIND, job};
use crate::error::{InputError, Result};
use crate::pipeline::options::{Kind, OptionSpec, Place, Values};
use crate::run::{self, Job};

/// How messages call the options.
const NAME: &str = "options";

/// An option for the help of another program.
#[derive(Debug)]
pub struct HostOption {
    /// Its name.
    pub name: String,
    /// What it does and what it accepts, in one line without a full stop.
    pub help: String,
    /// Its default as text.
    pub default: Option<String>,
    /// Whether it takes several values.
    pub is_list: bool,
    /// Whether the stage cannot do without it.
    pub is_required: bool,
}

impl From<OptionSpec> for HostOption {
    fn from(spec: OptionSpec) -> Self {
        let mut help = spec.help.clone();
        if let Some(accepted) = accepted(&spec.kind) {
            help = format!("{help} ({accepted})");
        }
        let default = match &spec.default {
            Value::Null => None,
            Value::String(text) => Some(text.clone()),
            other => Some(other.to_string()),
        };
        let is_list = matches!(spec.kind, Kind::Names | Kind::Texts);
        Self { name: spec.name, help, default, is_list, is_required: spec.required }
    }
}

/// What a kind accepts, where its help does not say it.
fn accepted(kind: &Kind) -> Option<String> {
    match kind {
        Kind::Choice(names) => {
            let one = |(name, meaning): &(String, String)| match meaning.as_str() {
                "" => name.clone(),
                meaning => format!("{name}: {meaning}"),
            };
            Some(names.iter().map(one).collect::<Vec<_>>().join("; "))
        }
        Kind::Number { .. } | Kind::NumberOrAuto | Kind::Boolean => Some(kind.expected()),
        Kind::Text | Kind::File | Kind::Names | Kind::Texts | Kind::Anything => None,
    }
}

/// The options of the stage, without those that every stage has.
pub fn hosted_options() -> Vec<HostOption> {
    (KIND.options)().into_iter().map(HostOption::from).collect()
}

/// The job that `text` describes, a JSON object with the options of the stage; its points, which messages call `points`, are
/// still to come, into the feed that [`job::feed`] opens.
///
/// # Errors
/// It is no JSON object; an option or a value that the stage does not take, or one that is missing; or the output exists
/// and is not to be replaced.
pub fn hosted_job(text: &str, points: &Path) -> Result<Job> {
    let given: Map<String, Value> =
        serde_json::from_str(if text.trim().is_empty() { "{}" } else { text }).map_err(|e| {
            InputError::new(NAME, "no JSON object", "an object with the options of writers.lod2").remedy(e.to_string())
        })?;
    let place = Place { file: NAME.into(), stage: String::new() };
    let values = Values::new(place, (KIND.options)(), KIND.elsewhere, &given)?;
    let filename: PathBuf = values.text("filename").unwrap_or_default().into();
    let mut job = job::job(&values, &filename)?;
    job::complete(&values, &mut job)?;
    run::output::spare_results(&job::model(&job, points), job.overwrite || job.resume)?;
    Ok(job)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hosted_job(text: &str) -> Result<Job> {
        super::hosted_job(text, Path::new("points"))
    }

    #[test]
    fn the_options_are_those_of_the_stage() {
        let hosted = hosted_options();
        let table = KIND.table();
        assert_eq!(hosted.len() + 2, table.len(), "all but `where` and `user_data`");
        for (own, spec) in hosted.iter().zip(&table) {
            assert_eq!((&own.name, own.is_required), (&spec.name, spec.name == "filename"));
            assert!(own.help.starts_with(&spec.help) && !own.help.contains('\n'), "{}", own.help);
        }
        let find = |name: &str| hosted.iter().find(|option| option.name == name).unwrap();
        assert!(find("unit").help.contains("(m: "), "{}", find("unit").help);
        assert_eq!(find("building_class").default.as_deref(), Some("6"));
        assert_eq!((find("lod").is_list, find("overwrite").default.as_deref()), (true, Some("false")));
    }

    #[test]
    fn the_job_is_that_of_the_stage_and_what_is_wrong_is_said() {
        let job = hosted_job(
            r#"{"filename": "a.city.json", "footprints": "f.gpkg", "lod": ["0", "2.2"], "lambda": "2.5",
            "overwrite": "true", "building_class": ["1", "6"], "crs": "EPSG:7415"}"#,
        )
        .unwrap();
        assert_eq!((job.parameters.lod.to_string(), job.parameters.labelling.lambda), ("0,2.2".to_owned(), 2.5));
        assert_eq!((job.overwrite, job.crs.as_deref()), (true, Some("EPSG:7415")));
        let folder = tempfile::tempdir().unwrap();
        let there = folder.path().join("there.city.json");
        std::fs::write(&there, "x").unwrap();
        let cases = [
            ("[]".to_owned(), "options: found no JSON object"),
            (r#"{"footprints": "f.gpkg"}"#.to_owned(), "options: found no option `filename`"),
            (r#"{"filename": "a.city.json"}"#.to_owned(), "options: found neither `footprints` nor `no_footprint`"),
            (r#"{"filename": "a.city.json", "no_footprint": true, "lod": "7"}"#.to_owned(), "found `7` as `lod`"),
            (r#"{"filename": "a.city.json", "no_footprint": "maybe"}"#.to_owned(), "true or false"),
            (r#"{"filename": "a.city.json", "lamda": 1}"#.to_owned(), "`lambda`"),
            (format!(r#"{{"filename": {there:?}, "no_footprint": true}}"#), "a file of that name"),
        ];
        for (options, part) in cases {
            let message = hosted_job(&options).unwrap_err().to_string();
            assert!(message.contains(part), "{options}: {message}");
        }
    }
}
