//! What a pipeline file says, before anybody asks whether it makes sense.

use std::path::Path;

use serde_json::{Map, Value};

use super::json;
use super::nearest::nearest;
use super::options::Place;
use crate::error::InputError;

/// One element of the array of a pipeline.
#[derive(Debug, Clone, PartialEq)]
pub struct StageSpec {
    /// Its number in the array, from 1.
    pub number: usize,
    /// Its type, such as `filters.crop`; `None` when the file name shall tell.
    pub kind: Option<String>,
    /// Its tag.
    pub tag: Option<String>,
    /// The tags of its inputs; `None` for all leaves before it.
    pub inputs: Option<Vec<String>>,
    /// Everything else.
    pub options: Map<String, Value>,
}

impl StageSpec {
    /// The stage, for messages.
    pub fn place(&self, file: &Path) -> Place {
        let name = self.kind.as_deref().or_else(|| self.options.get("filename").and_then(Value::as_str));
        let name = name.map(|name| format!(" ({name})")).unwrap_or_default();
        let tag = self.tag.as_ref().map(|tag| format!(", tag {tag}")).unwrap_or_default();
        Place { file: file.to_path_buf(), stage: format!("stage {}{name}{tag}", self.number) }
    }
}

/// Reads the text of a pipeline: an array of stages, or an object that holds it as `pipeline`. `file` is for messages.
///
/// # Errors
/// The text is no JSON, or not of that form.
pub fn read(text: &str, file: &Path) -> Result<Vec<StageSpec>, InputError> {
    const EXPECTED: &str = "an array of stages, or an object with the array as `pipeline`";
    let mut root = json::parse(text, file)?;
    let stages = match &mut root {
        Value::Array(stages) => std::mem::take(stages),
        Value::Object(object) => {
            let Some(stages) = object.get_mut("pipeline") else {
                let near = nearest("pipeline", object.keys().map(String::as_str));
                let found = near.map_or("an object without `pipeline`".to_owned(), |near| format!("`{near}`"));
                return Err(InputError::new(file, found, EXPECTED));
            };
            match stages.take() {
                Value::Array(stages) => stages,
                other => return Err(InputError::new(file, kind_of(&other), "an array of stages").at("`pipeline`")),
            }
        }
        other => return Err(InputError::new(file, kind_of(other), EXPECTED)),
    };
    if stages.is_empty() {
        return Err(InputError::new(file, "no stage", "a reader, and what shall become of its points"));
    }
    stages.into_iter().enumerate().map(|(i, stage)| read_stage(stage, i + 1, file)).collect()
}

fn read_stage(stage: Value, number: usize, file: &Path) -> Result<StageSpec, InputError> {
    let mut spec = StageSpec { number, kind: None, tag: None, inputs: None, options: Map::new() };
    match stage {
        Value::String(filename) => {
            spec.options.insert("filename".to_owned(), Value::String(filename));
            return Ok(spec);
        }
        Value::Object(options) => spec.options = options,
        other => {
            let place = spec.place(file);
            return Err(place.fault(kind_of(&other), "an object with options, or the name of a file"));
        }
    }
    let place = spec.place(file);
    let text = |value: Value, name: &str| match value {
        Value::String(text) => Ok(text),
        other => Err(place.fault(format!("{} as `{name}`", kind_of(&other)), "a text")),
    };
    spec.kind = spec.options.shift_remove("type").map(|value| text(value, "type")).transpose()?;
    spec.tag = spec.options.shift_remove("tag").map(|value| text(value, "tag")).transpose()?;
    if let Some(tag) = &spec.tag {
        let mut letters = tag.chars();
        let is_name = letters.next().is_some_and(|c| c.is_ascii_alphabetic())
            && letters.all(|c| c.is_ascii_alphanumeric() || c == '_');
        if !is_name {
            let expected = "a letter, followed by letters, digits or `_`";
            return Err(place.fault(format!("the tag `{tag}`"), expected));
        }
    }
    spec.inputs = match spec.options.shift_remove("inputs") {
        None => None,
        Some(Value::Array(tags)) => {
            Some(tags.into_iter().map(|tag| text(tag, "inputs")).collect::<Result<Vec<_>, _>>()?)
        }
        Some(tag) => Some(vec![text(tag, "inputs")?]),
    };
    Ok(spec)
}

fn kind_of(value: &Value) -> String {
    match value {
        Value::Null => "null".to_owned(),
        Value::Array(_) => "an array".to_owned(),
        Value::Object(_) => "an object".to_owned(),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stages_are_objects_or_names_of_files() {
        let text = r#"{"$schema": "x", "pipeline": ["a.las", /* keep */ {"type": "filters.crop", "tag": "c1",
            "inputs": "a", "bounds": "([0,1],[0,1])"}, {"inputs": ["b", "c"], "filename": "o.laz"}]}"#;
        let stages = read(text, Path::new("p.json")).unwrap();
        assert_eq!(stages[0].options["filename"], "a.las");
        assert_eq!((stages[1].kind.as_deref(), stages[1].tag.as_deref()), (Some("filters.crop"), Some("c1")));
        assert_eq!(stages[1].inputs.as_deref(), Some(&["a".to_owned()][..]));
        assert_eq!(stages[1].options.len(), 1);
        assert_eq!(stages[2].inputs.as_ref().map(Vec::len), Some(2));
        assert_eq!(stages[1].place(Path::new("p.json")).stage, "stage 2 (filters.crop), tag c1");
    }

    #[test]
    fn other_forms_are_refused_with_their_place() {
        let fault = |text: &str| read(text, Path::new("p.json")).unwrap_err().to_string();
        assert!(fault("[]").contains("no stage"));
        assert!(fault("3").contains("found 3"));
        assert!(fault(r#"{"pipelines": []}"#).contains("`pipelines`"));
        assert!(fault(r#"["a.las", 3]"#).contains("stage 2"));
        assert!(fault(r#"[{"type": 3}]"#).contains("`type`"));
        assert!(fault(r#"[{"type": "filters.head", "tag": "1a"}]"#).contains("a letter"));
        assert!(fault(r#"[{"inputs": [1]}]"#).contains("`inputs`"));
    }
}
