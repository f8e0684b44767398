//! GeoJSON by lines, and as RFC 8142 has it.

use std::fs;

use serde_json::json;
use tempfile::TempDir;

use super::{ids, plain, polygon, square};
use crate::source::footprints::{FootprintOptions, read};

fn lines() -> Vec<String> {
    let feature = |id: &str, x: f64| polygon(&json!({"id": id}), &json!([square(x, 52.0, 0.001)])).to_string();
    vec![feature("a", 4.0), feature("b\u{1e}", 4.1), feature("c", 4.2)]
}

#[test]
fn features_may_stand_one_a_line_or_after_separators() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("made.geojsonl");
    let lines = lines();
    let separated = lines.iter().fold(String::new(), |text, line| text + "\u{1e}" + line + "\n");
    let pretty = |line: &String| format!("{:#}\r\n", serde_json::from_str::<serde_json::Value>(line).unwrap());
    let pretty: Vec<String> = lines.iter().map(pretty).collect();
    let (plain_text, pretty) = (lines.join("\n"), pretty.join("\r\n"));
    for text in [plain_text.clone(), plain_text.clone() + "\n", separated, pretty, format!("\u{feff}{plain_text}")] {
        fs::write(&path, &text).unwrap();
        let layer = plain(&path);
        assert_eq!(ids(&layer), ["a", "b\u{1e}", "c"], "{text}");
        assert_eq!(layer.crs.unwrap().code.as_deref(), Some("OGC:CRS84"));
        assert_eq!((layer.layer.as_str(), layer.missing), ("made", 0));
    }
}

#[test]
fn a_sequence_that_is_cut_off_says_so_and_one_that_is_something_else_is_refused() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("made.geojsonl");
    let text = lines().join("\n");
    fs::write(&path, &text[..text.len() - 20]).unwrap();
    let layer = plain(&path);
    assert_eq!((ids(&layer).len(), layer.missing), (2, 1));
    assert!(layer.warnings[0].contains("cut off"), "{:?}", layer.warnings);
    for (line, says) in [("[1, 2]", "line 2"), (r#"{"type": "CityJSONFeature"}"#, "CityJSONFeature"), ("}", "line 2")] {
        fs::write(&path, format!("{}\n{line}\n", lines()[0])).unwrap();
        let error = read(&path, &FootprintOptions::default()).unwrap_err().to_string();
        assert!(error.contains("made.geojsonl") && error.contains(says), "{line}: {error}");
    }
}
