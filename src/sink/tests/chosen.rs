//! Which attributes are written, and under which names.

use serde_json::{Value, json};

use super::building;
use crate::sink::{AttributeOptions, Encoder, own_names};

#[test]
fn attributes_are_chosen_and_named_as_asked() {
    let mut house = building("h");
    let given = json!({"year": 1990, "use": "x", "gable_lod": "old", "b_lod": "older"});
    house.attributes = given.as_object().unwrap().clone();
    let chosen = |own: &str, prefix: &str, source: &str| {
        let options = AttributeOptions {
            own: own_names(own).unwrap(),
            prefix: prefix.to_owned(),
            source: source.parse().unwrap(),
        };
        let mut encoder = Encoder::default().with_attributes(options);
        Value::Object(encoder.feature(&house).objects.remove(0).attributes)
    };
    assert_eq!(chosen("none", "gable_", "year"), json!({"year": 1990}));
    assert_eq!(chosen("success,gable_points", "b_", "none"), json!({"b_success": false, "b_points": 0}));
    // What would be taken for gable's under the prefix gets another name, and the notes tell.
    let note = "the attribute \"b_lod\" is written as \"source_b_lod\"";
    assert_eq!(chosen("notes", "b_", "*lod"), json!({"gable_lod": "old", "source_b_lod": "older", "b_notes": [note]}));
    assert_eq!(chosen("points", "", "*e*"), json!({"year": 1990, "use": "x", "gable_lod": "old", "points": 0}));
    let message = own_names("heigt_ridge").unwrap_err();
    assert!(message.contains("nearest is height_ridge"), "{message}");
}
