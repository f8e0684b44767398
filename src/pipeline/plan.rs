//! From what a pipeline file says to stages that are joined to one another.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde_json::{Map, Value, json};

use super::files::{in_folder, matches};
use super::nearest::nearest;
use super::options::{Place, Values};
use super::spec::{self, StageSpec};
use super::stage::{Role, StageKind};
use super::{catalogue, expression};
use crate::error::{InputError, Result};
use crate::source::footprints::redacted;
use crate::source::{objects, points};

/// An option set on the command line: `--readers.las.count=5` or `--stage.TAG.count=5`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Override {
    /// Which stages.
    pub target: Target,
    /// The name of the option.
    pub option: String,
    /// Its value.
    pub value: String,
}

/// Which stages an [`Override`] is for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Target {
    /// All of this type.
    Type(String),
    /// The one of this tag, which goes before.
    Tag(String),
}

impl Override {
    /// Reads `readers.las.count=5` or `stage.TAG.count=5`, without the dashes before it.
    ///
    /// # Errors
    /// It is of another form.
    pub fn parse(text: &str) -> Result<Self, InputError> {
        let fault = || {
            let expected = "--TYPE.OPTION=VALUE such as --readers.las.count=1000, or --stage.TAG.OPTION=VALUE";
            InputError::new(format!("--{text}"), "another form", expected)
        };
        let (name, value) = text.split_once('=').ok_or_else(fault)?;
        let [first, second, option] = *name.split('.').collect::<Vec<_>>() else { return Err(fault()) };
        let target = match first {
            "stage" => Target::Tag(second.to_owned()),
            "readers" | "filters" | "writers" => Target::Type(format!("{first}.{second}")),
            _ => return Err(fault()),
        };
        Ok(Self { target, option: option.to_owned(), value: value.to_owned() })
    }

    fn name(&self) -> String {
        match &self.target {
            Target::Type(kind) => format!("--{kind}.{}", self.option),
            Target::Tag(tag) => format!("--stage.{tag}.{}", self.option),
        }
    }
}

/// A stage of the plan.
#[derive(Debug, Clone)]
pub struct Planned {
    /// Its type.
    pub kind: &'static StageKind,
    /// Its tag: the one that was given, or one made of its type.
    pub tag: String,
    /// The stages whose points it gets, by their number in the plan, all before it.
    pub inputs: Vec<usize>,
    /// Its options.
    pub values: Values,
    /// Which points it acts on.
    pub condition: Option<expression::Condition>,
}

/// Stages that are joined to one another, in the order of the file.
#[derive(Debug, Clone)]
pub struct Plan {
    /// The pipeline file, for messages.
    pub file: PathBuf,
    /// The stages.
    pub stages: Vec<Planned>,
}

impl Plan {
    /// Reads the text of a pipeline and joins its stages. `file` is for messages; names of files in it are relative to the
    /// working folder, as in PDAL.
    ///
    /// # Errors
    /// What is wrong with it, and where.
    pub fn read(text: &str, file: &Path, overrides: &[Override]) -> Result<Self> {
        let specs = spec::read(text, file)?;
        let mut builder = Builder { file, stages: Vec::new(), tags: BTreeMap::new(), leaves: Vec::new() };
        let last = specs.len();
        let mut used = vec![false; overrides.len()];
        for spec in specs {
            builder.add(&spec, last, overrides, &mut used)?;
        }
        if let Some((unused, _)) = overrides.iter().zip(&used).find(|(_, used)| !**used) {
            return Err(builder.nothing_to_override(unused).into());
        }
        Ok(Self { file: file.to_path_buf(), stages: builder.stages })
    }

    /// The stages whose points nobody takes.
    pub fn leaves(&self) -> Vec<usize> {
        let taken = |stage: usize| self.stages.iter().any(|other| other.inputs.contains(&stage));
        (0..self.stages.len()).filter(|&stage| !taken(stage)).collect()
    }

    /// The pipeline with all types, tags, inputs and matches of glob patterns written out, and without passwords.
    pub fn to_json(&self) -> Value {
        let stage = |planned: &Planned| {
            let mut stage = Map::new();
            stage.insert("type".to_owned(), json!(planned.kind.name));
            stage.insert("tag".to_owned(), json!(planned.tag));
            if planned.kind.role != Role::Reader {
                let inputs: Vec<&str> = planned.inputs.iter().map(|&i| self.stages[i].tag.as_str()).collect();
                stage.insert("inputs".to_owned(), json!(inputs));
            }
            stage.extend(planned.values.to_json().into_iter().map(|(name, value)| {
                let shown = value.as_str().map(|text| Value::String(redacted(text)));
                (name, shown.unwrap_or(value))
            }));
            Value::Object(stage)
        };
        json!({ "pipeline": self.stages.iter().map(stage).collect::<Vec<_>>() })
    }
}

struct Builder<'a> {
    file: &'a Path,
    stages: Vec<Planned>,
    /// The stages that a tag names: several when a pattern matched several files.
    tags: BTreeMap<String, Vec<usize>>,
    /// The stages whose points nobody takes until now.
    leaves: Vec<usize>,
}

impl Builder<'_> {
    fn add(&mut self, spec: &StageSpec, last: usize, overrides: &[Override], used: &mut [bool]) -> Result<()> {
        let place = spec.place(self.file);
        let kind = if let Some(name) = &spec.kind {
            catalogue::find(name, &place)?
        } else {
            let is_writer = spec.number == last && spec.number > 1;
            let role = if is_writer { Role::Writer } else { Role::Reader };
            let filename = spec.options.get("filename").and_then(Value::as_str).ok_or_else(|| {
                place.fault("neither `type` nor `filename`", "one of them, so that there is something to do")
            })?;
            catalogue::infer(filename, role, &place)?
        };
        let tag = spec.tag.clone().unwrap_or_else(|| self.made_up_tag(kind));
        if self.tags.contains_key(&tag) {
            return Err(place.fault(format!("the tag `{tag}` a second time"), "a tag for each stage").into());
        }
        let mut options = spec.options.clone();
        // Those of a tag after those of a type, so that they win.
        for by_tag in [false, true] {
            for (one, used) in overrides.iter().zip(used.iter_mut()) {
                let is_meant = match &one.target {
                    Target::Type(name) => !by_tag && name == kind.name,
                    Target::Tag(name) => by_tag && *name == tag,
                };
                if is_meant {
                    *used = true;
                    options.insert(one.option.clone(), Value::String(one.value.clone()));
                }
            }
        }
        let inputs = self.inputs(spec, kind, &place)?;
        let many = match (kind.role, options.get("filename").and_then(Value::as_str)) {
            (Role::Reader, Some(address)) if objects::is_object(Path::new(address)) => {
                let files = points::expand(&[address.to_owned()])?;
                files.into_iter().map(|file| with_filename(&options, &file)).collect()
            }
            (Role::Reader, Some(pattern)) if pattern.contains(['*', '?', '[']) && !Path::new(pattern).exists() => {
                let files = matches(pattern, &place)?;
                files.into_iter().map(|file| with_filename(&options, &file)).collect()
            }
            (Role::Reader, Some(folder)) if Path::new(folder).is_dir() => {
                let files = in_folder(folder, kind, &place)?;
                files.into_iter().map(|file| with_filename(&options, &file)).collect()
            }
            _ => vec![options],
        };
        let mut added = Vec::with_capacity(many.len());
        for options in many {
            let values = Values::new(place.clone(), kind.table(), kind.elsewhere, &options)?;
            let condition = values.text("where").map(expression::Condition::parse).transpose();
            let condition = condition.map_err(|misfit| values.misfit("where", misfit))?;
            // Only the first of several matches has the tag itself, so that every stage has its own.
            let tag = if added.is_empty() { tag.clone() } else { self.made_up_tag(kind) };
            let number = self.stages.len();
            self.tags.insert(tag.clone(), vec![number]);
            self.stages.push(Planned { kind, tag, inputs: inputs.clone(), values, condition });
            added.push(number);
        }
        self.tags.insert(tag, added.clone());
        if kind.role == Role::Reader {
            self.leaves.extend(added);
        } else {
            self.leaves = added;
        }
        Ok(())
    }

    /// A tag that no stage has: the type with an underscore and the first number that is free.
    fn made_up_tag(&self, kind: &StageKind) -> String {
        let name = kind.name.replace('.', "_");
        let mut number = 1;
        while self.tags.contains_key(&format!("{name}{number}")) {
            number += 1;
        }
        format!("{name}{number}")
    }

    fn inputs(&self, spec: &StageSpec, kind: &StageKind, place: &Place) -> Result<Vec<usize>, InputError> {
        if kind.role == Role::Reader {
            return Ok(Vec::new());
        }
        let Some(tags) = &spec.inputs else {
            if self.leaves.is_empty() {
                return Err(place.fault("no stage before it", "a reader, which gives it points"));
            }
            return Ok(self.leaves.clone());
        };
        let mut inputs = Vec::new();
        for tag in tags {
            let Some(stages) = self.tags.get(tag) else {
                let known: Vec<&str> = self.tags.keys().map(String::as_str).collect();
                let near = nearest(tag, known.iter().copied()).map(|near| format!("`{near}`, or another of "));
                let expected = format!("a tag of a stage before: {}{}", near.unwrap_or_default(), known.join(", "));
                return Err(place.fault(format!("the input `{tag}`, which no stage before has as its tag"), expected));
            };
            inputs.extend(stages);
        }
        if inputs.is_empty() {
            return Err(place.fault("no input", "the tag of a stage before"));
        }
        Ok(inputs)
    }

    fn nothing_to_override(&self, unused: &Override) -> InputError {
        let (found, known): (String, Vec<&str>) = match &unused.target {
            Target::Type(kind) => {
                (format!("no stage of the type `{kind}`"), self.stages.iter().map(|stage| stage.kind.name).collect())
            }
            Target::Tag(tag) => {
                (format!("no stage with the tag `{tag}`"), self.stages.iter().map(|stage| stage.tag.as_str()).collect())
            }
        };
        let fault = InputError::new(self.file, found, format!("one of {}", known.join(", ")));
        fault.at(unused.name())
    }
}

fn with_filename(options: &Map<String, Value>, file: &Path) -> Map<String, Value> {
    let mut options = options.clone();
    options.insert("filename".to_owned(), Value::String(file.to_string_lossy().into_owned()));
    options
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(text: &str, overrides: &[&str]) -> Result<Plan> {
        let overrides: Vec<Override> = overrides.iter().map(|text| Override::parse(text).unwrap()).collect();
        Plan::read(text, Path::new("p.json"), &overrides)
    }

    fn fault(text: &str) -> String {
        plan(text, &[]).unwrap_err().to_string()
    }

    #[test]
    fn a_folder_stands_for_the_files_in_it() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["b.laz", "a.las", "c.csv", "d.city.json", "e.tif"] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        let path = folder.path().display().to_string();
        let files = |stage: Value| {
            let plan = plan(&json!([stage, {"type": "writers.null"}]).to_string(), &[]).unwrap();
            let readers = plan.stages.iter().filter(|stage| stage.kind.role == Role::Reader);
            let names =
                readers.map(|stage| stage.values.text("filename").unwrap().rsplit('/').next().unwrap().to_owned());
            names.collect::<Vec<_>>()
        };
        assert_eq!(files(json!(path)), ["a.las", "b.laz"]);
        assert_eq!(files(json!({"type": "readers.text", "filename": path})), ["c.csv"]);
        let empty = tempfile::tempdir().unwrap();
        assert!(
            fault(&json!([empty.path(), "out.las"]).to_string()).contains("in which no file is one for `readers.las`")
        );
    }

    #[test]
    fn readers_gather_and_other_stages_take_all_leaves() {
        let plan = plan(
            r#"["a.las", "b.laz", {"type": "filters.head"}, {"filename": "c.copc.laz", "tag": "c"},
                {"type": "filters.merge", "inputs": "c"}, {"type": "writers.null", "inputs": ["filters_head1", "c"]},
                "out.csv"]"#,
            &[],
        )
        .unwrap();
        let names: Vec<&str> = plan.stages.iter().map(|stage| stage.kind.name).collect();
        let expected = [
            "readers.las",
            "readers.las",
            "filters.head",
            "readers.copc",
            "filters.merge",
            "writers.null",
            "writers.text",
        ];
        assert_eq!(names, expected);
        let inputs: Vec<&[usize]> = plan.stages.iter().map(|stage| stage.inputs.as_slice()).collect();
        assert_eq!(inputs, [&[][..], &[], &[0, 1], &[], &[3], &[2, 3], &[5]]);
        // The merge has no taker: the default list was replaced by the writer behind it.
        assert_eq!(plan.leaves(), [4, 6]);
        assert_eq!(plan.stages[1].tag, "readers_las2");
    }

    #[test]
    fn a_tag_goes_before_a_type() {
        let text = r#"["a.las", {"type": "filters.head", "tag": "h", "count": 3}, {"type": "filters.head"}]"#;
        let plan = plan(text, &["stage.h.count=7", "filters.head.count=5", "stage.readers_las1.count=9"]).unwrap();
        let counts: Vec<Option<u64>> = plan.stages.iter().map(|stage| stage.values.whole("count")).collect();
        assert_eq!(counts, [Some(9), Some(7), Some(5)]);
    }

    #[test]
    fn overrides_must_hit_something() {
        let overrides = |text: &str| plan(r#"["a.las"]"#, &[text]).unwrap_err().to_string();
        assert!(overrides("filters.head.count=5").contains("`filters.head`"));
        assert!(overrides("stage.x.count=5").contains("readers_las1"));
        assert!(overrides("readers.las.cuont=5").contains("`count`"));
        for bad in ["readers.las=5", "readers.las.count", "las.x.count=5"] {
            assert!(Override::parse(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn patterns_become_one_reader_per_file() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["b.las", "a.las", "c.txt"] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        let text = format!(
            r#"[{{"filename": "{0}/*.las", "tag": "t"}}, {{"type": "filters.merge", "inputs": "t"}}]"#,
            folder.path().display()
        );
        let plan = plan(&text, &[]).unwrap();
        let files: Vec<Option<&str>> = plan.stages.iter().map(|stage| stage.values.text("filename")).collect();
        assert!(files[0].unwrap().ends_with("a.las") && files[1].unwrap().ends_with("b.las"));
        assert_eq!(plan.stages[2].inputs, [0, 1]);
        assert!(fault(r#"["nowhere/*.las"]"#).contains("matches no file"));
    }

    #[test]
    fn unknown_names_name_the_nearest() {
        let unknown = fault(r#"["a.las", {"type": "filters.crp"}]"#);
        assert!(
            unknown.starts_with("p.json, stage 2 (filters.crp)") && unknown.contains("`filters.crop`"),
            "{unknown}"
        );
        let option = fault(r#"["a.las", {"type": "filters.crop", "bound": "([0,1],[0,1])"}]"#);
        assert!(option.contains("`bounds`"), "{option}");
        let elsewhere = fault(r#"["a.las", {"type": "filters.pmf"}]"#);
        assert!(elsewhere.contains("pdal pipeline") && elsewhere.contains("writers.las"), "{elsewhere}");
        let option = fault(r#"["a.las", {"type": "filters.crop", "ogr": {}}]"#);
        assert!(option.contains("which PDAL has"), "{option}");
        assert!(fault(r#"["a.las", "out.tif"]"#).contains("`writers.gdal`"));
        assert!(fault(r#"["a.docx"]"#).contains("extension"));
        assert!(fault(r#"[{"type": "filters.head"}]"#).contains("a reader"));
        assert!(fault(r#"["a.las", {"type": "filters.head", "inputs": "readers_las2"}]"#).contains("`readers_las1`"));
        assert!(fault(r#"["a.las", {"type": "filters.head", "where": "Z >"}]"#).contains("`where`"));
    }

    #[test]
    fn the_serialization_has_everything_written_out() {
        let text = r#"["a.las", {"type": "filters.head", "count": "3", "user_data": {"why": "test"}}, "o.las"]"#;
        let json = plan(text, &[]).unwrap().to_json();
        assert_eq!(
            json,
            json!({"pipeline": [
                {"type": "readers.las", "tag": "readers_las1", "filename": "a.las"},
                {"type": "filters.head", "tag": "filters_head1", "inputs": ["readers_las1"], "count": 3,
                    "user_data": {"why": "test"}},
                {"type": "writers.las", "tag": "writers_las1", "inputs": ["filters_head1"], "filename": "o.las"}
            ]})
        );
        assert_eq!(plan(&json.to_string(), &[]).unwrap().to_json(), json);
    }
}
