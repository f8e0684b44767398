//! The stages in words and as JSON Schema.

use std::fmt::Write;

use serde_json::{Map, Value, json};

use super::catalogue::STAGES;
use super::options::{Kind, OptionSpec};
use super::stage::{Role, StageKind};

/// Columns of the text.
const WIDTH: usize = 100;
/// Columns before the help of an option.
const INDENT: usize = 6;

/// All stages, a line each. (Writing into a text never fails.)
pub fn list() -> String {
    let mut out = String::new();
    for (role, heading) in [(Role::Reader, "Readers"), (Role::Filter, "Filters"), (Role::Writer, "Writers")] {
        let _ = writeln!(out, "{heading}:");
        for kind in STAGES.iter().filter(|kind| kind.role == role) {
            let _ = writeln!(out, "  {:<22}{}", kind.name, kind.summary);
        }
    }
    out
}

/// A stage with its options.
pub fn stage(kind: &StageKind) -> String {
    let mut out = format!("{}\n\n", kind.name);
    wrap(&format!("{}.", kind.summary), 0, &mut out);
    let _ = match kind.collects {
        "" => writeln!(out, "It streams: memory does not grow with the number of points."),
        "always" => writeln!(out, "It needs all points at once, so memory grows with their number."),
        when => writeln!(out, "It streams, except {when}."),
    };
    out += "\nOptions:\n";
    for spec in kind.table() {
        let _ = writeln!(out, "  {} {}", spec.name, spec.kind.placeholder());
        let mut help = vec![spec.help.clone()];
        if let Kind::Choice(names) = &spec.kind {
            for (name, meaning) in names {
                help.push(if meaning.is_empty() { format!("- {name}") } else { format!("- {name}: {meaning}") });
            }
        } else if let Kind::Number { limits, .. } = &spec.kind
            && limits.iter().any(|limit| limit.is_finite())
        {
            help.push(format!("[{}]", spec.kind.expected()));
        }
        if spec.required {
            help.push("[required]".to_owned());
        } else if !spec.default.is_null() {
            help.push(format!("[default: {}]", shown(&spec.default)));
        }
        for line in help {
            wrap(&line, INDENT, &mut out);
        }
    }
    out += "  tag NAME\n";
    wrap("Name of the stage, by which others can name it as an input", INDENT, &mut out);
    if kind.role != Role::Reader {
        out += "  inputs NAMES\n";
        wrap(
            "Tags of the stages whose points it takes; all before it whose points nobody takes, when not given",
            INDENT,
            &mut out,
        );
    }
    let elsewhere: Vec<&str> = kind.elsewhere.iter().copied().filter(|name| *name != "option_file").collect();
    if !elsewhere.is_empty() {
        out += "\nPDAL has further options here, which gable has not:\n";
        wrap(&elsewhere.join(", "), INDENT, &mut out);
    }
    out
}

/// A default as one would write it.
fn shown(value: &Value) -> String {
    match value {
        Value::String(text) => text.replace('\n', "\\n"),
        other => other.to_string(),
    }
}

/// Appends a paragraph, indented and broken into lines.
fn wrap(text: &str, indent: usize, out: &mut String) {
    let mut column = 0;
    for (n, word) in text.split_whitespace().enumerate() {
        let length = word.chars().count();
        if n > 0 && column + 1 + length <= WIDTH {
            *out += " ";
            column += 1;
        } else {
            if n > 0 {
                *out += "\n";
            }
            *out += &" ".repeat(indent);
            column = indent;
        }
        *out += word;
        column += length;
    }
    *out += "\n";
}

/// The JSON Schema of pipelines, as text with a line end: what `schemas/pipeline.schema.json` holds.
pub fn schema() -> String {
    let mut definitions = Map::new();
    let mut variants = vec![
        json!({ "type": "string", "description": "A file: a reader, or, at the end, a writer, by its extension" }),
        json!({ "$ref": "#/$defs/inferred" }),
    ];
    definitions.insert("inferred".to_owned(), inferred());
    for kind in STAGES {
        definitions.insert(kind.name.to_owned(), stage_schema(kind));
        variants.push(json!({ "$ref": format!("#/$defs/{}", kind.name) }));
    }
    definitions.insert(
        "stages".to_owned(),
        json!({
            "type": "array",
            "minItems": 1,
            "items": { "anyOf": variants },
            "description": "Stages; each takes the points of those before it whose points nobody takes",
        }),
    );
    let schema = json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "gable pipeline",
        "description": "A pipeline of gable: PDAL's grammar, with stages of gable",
        "anyOf": [
            { "$ref": "#/$defs/stages" },
            {
                "type": "object",
                "required": ["pipeline"],
                "properties": {
                    "$schema": { "type": "string" },
                    "pipeline": { "$ref": "#/$defs/stages" },
                },
            },
        ],
        "$defs": definitions,
    });
    format!("{schema:#}\n")
}

/// A stage whose file name tells its type.
fn inferred() -> Value {
    json!({
        "type": "object",
        "description": "A stage whose type follows from the extension of its file",
        "required": ["filename"],
        "not": { "required": ["type"] },
        "properties": { "filename": { "type": "string" }, "tag": tag(), "inputs": inputs() },
    })
}

fn tag() -> Value {
    json!({
        "type": "string",
        "pattern": "^[A-Za-z][A-Za-z0-9_]*$",
        "description": "Name of the stage, by which others can name it as an input",
    })
}

fn inputs() -> Value {
    json!({
        "anyOf": [{ "type": "string" }, { "type": "array", "items": { "type": "string" } }],
        "description": "Tags of the stages whose points it takes",
    })
}

fn stage_schema(kind: &StageKind) -> Value {
    let mut properties = Map::new();
    properties.insert("type".to_owned(), json!({ "const": kind.name, "description": kind.summary }));
    properties.insert("tag".to_owned(), tag());
    properties.insert("inputs".to_owned(), inputs());
    let mut required = vec!["type".to_owned()];
    for spec in kind.table() {
        for alias in spec.aliases {
            let mut schema = option_schema(&spec);
            schema.insert("deprecated".to_owned(), json!(true));
            properties.insert((*alias).to_owned(), Value::Object(schema));
        }
        if spec.required {
            required.push(spec.name.clone());
        }
        properties.insert(spec.name.clone(), Value::Object(option_schema(&spec)));
    }
    json!({
        "type": "object",
        "description": kind.summary,
        "required": required,
        "properties": properties,
        "additionalProperties": false,
    })
}

fn option_schema(spec: &OptionSpec) -> Map<String, Value> {
    let mut schema = spec.kind.schema();
    schema.insert("description".to_owned(), json!(spec.help));
    if !spec.default.is_null() {
        schema.insert("default".to_owned(), spec.default.clone());
    }
    schema
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn the_checked_in_schema_is_up_to_date() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("schemas/pipeline.schema.json");
        if std::env::var_os("GABLE_UPDATE_SCHEMAS").is_some() {
            std::fs::write(&path, schema()).unwrap();
        }
        let found = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(
            found == schema(),
            "{} is stale; GABLE_UPDATE_SCHEMAS=1 cargo test --release --lib up_to_date renews it",
            path.display()
        );
    }

    #[test]
    fn the_schema_tells_good_pipelines_from_bad_ones() {
        let schema: Value = serde_json::from_str(&schema()).unwrap();
        let validator = jsonschema::validator_for(&schema).unwrap();
        let good = json!({"$schema": "x", "pipeline": [
            "a.las",
            {"filename": "b.laz", "tag": "b"},
            {"type": "filters.crop", "bounds": ["([0,1],[0,1])"], "where": "Z > 1", "inputs": "b"},
            {"type": "writers.lod2", "filename": "o.city.json", "footprints": "f.gpkg", "detector": "ransac",
                "building_class": [1, 6], "ring_width": "4"}
        ]});
        assert!(validator.is_valid(&good));
        for bad in [
            json!([{"type": "filters.crop", "bound": "([0,1],[0,1])"}]),
            json!([{"type": "filters.pmf"}]),
            json!([{"type": "writers.lod2", "filename": "o.city.json", "detector": "ransack"}]),
            json!([{"type": "readers.las"}]),
            json!({"stages": []}),
            json!([]),
        ] {
            assert!(!validator.is_valid(&bad), "{bad}");
        }
    }

    #[test]
    fn every_option_has_help_and_a_default_that_it_accepts() {
        for kind in STAGES {
            assert!(!kind.summary.is_empty());
            let table = kind.table();
            for (i, spec) in table.iter().enumerate() {
                assert!(!spec.help.is_empty() && !spec.help.ends_with('.'), "{} {}", kind.name, spec.name);
                assert!(
                    !table[..i].iter().any(|other| other.is_called(&spec.name)),
                    "{} {} twice",
                    kind.name,
                    spec.name
                );
                let is_accepted = spec.default.is_null() || spec.kind.accept(&spec.default).is_some();
                assert!(is_accepted, "{} {}: {}", kind.name, spec.name, spec.default);
                assert!(!kind.elsewhere.contains(&spec.name.as_str()), "{} {} is not elsewhere", kind.name, spec.name);
            }
            let text = stage(kind);
            assert!(text.lines().all(|line| line.chars().count() <= WIDTH), "{text}");
        }
    }
}
