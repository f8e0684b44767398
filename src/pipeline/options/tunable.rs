//! Structures whose fields are options.
//!
//! A new field of [`Parameters`], [`SegmentOptions`], [`TerrainOptions`] or [`FieldOptions`] becomes an option of `writers.lod2` without a
//! line here, and a flag of `gable reconstruct`: its name is the option, its documentation the help, its default the
//! default, its type and range decide what is accepted. Fields of nested structures are options like all others.

use schemars::JsonSchema;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

use super::kind::{Kind, description};
use crate::completeness::Limits;
use crate::network::FieldOptions;
use crate::reconstruct::Parameters;
use crate::segment::SegmentOptions;
use crate::terrain::TerrainOptions;

/// A structure whose fields are options.
pub trait Tunable: Clone + Default + Serialize + DeserializeOwned + JsonSchema {
    /// Under which heading a help lists them.
    const HEADING: &'static str;
    /// Fields that have an option of their own elsewhere.
    const ELSEWHERE: &'static [&'static str];
    /// The ranges of options where the structure sets none or takes what lies outside for the nearest value inside: such a
    /// value is a slip, and is refused.
    const LIMITS: &'static [(&'static str, [f64; 2])];
}

impl Tunable for Parameters {
    const HEADING: &'static str = "Method";
    const ELSEWHERE: &'static [&'static str] = &["lod"];
    const LIMITS: &'static [(&'static str, [f64; 2])] = &[
        ("block_step", [0.0, 1000.0]),
        ("eaves_thickness", [0.02, 5.0]),
        ("block_above", [0.0, 1e9]),
        ("minimum_density", [0.0, 10_000.0]),
        ("maximum_no_data", [0.0, 1.0]),
        ("grid_scale", [0.0001, 0.1]),
        ("noise_factor", [1.0, 100.0]),
        ("minimum_tolerance", [0.001, 10.0]),
        ("maximum_tolerance", [0.001, 10.0]),
        ("minimum_area", [0.0, 10_000.0]),
        ("minimum_inliers", [3.0, 100_000.0]),
        ("maximum_density", [1.0, 10_000.0]),
        ("merge_tolerance", [0.0, 10.0]),
        ("regularise_tolerance", [0.0, 10.0]),
        ("footprint_tolerance", [0.0, 10.0]),
        ("open_ground_area", [0.0, 10_000.0]),
        ("minimum_height", [0.0, 100.0]),
        ("step_height", [0.0, 100.0]),
        ("step_length", [0.0, 100.0]),
        ("lambda", [0.0, 1000.0]),
        ("volume_exponent", [0.0, 1.0]),
        ("minimum_feature", [0.0, 10.0]),
        ("judge_cell", [0.1, 100.0]),
        ("judge_margin", [0.0, 100.0]),
        ("judge_height", [0.0, 100.0]),
        ("judge_top", [0.0, 100.0]),
        ("judge_reach", [0.0, 10.0]),
        ("judge_fewest", [1.0, 1000.0]),
        ("judge_ground_reach", [0.0, 10.0]),
        ("judge_smallest", [0.0, 10_000.0]),
    ];
}

impl Tunable for Limits {
    const HEADING: &'static str = "What is missing, in excess, or roofed ground";
    const ELSEWHERE: &'static [&'static str] = &[];
    const LIMITS: &'static [(&'static str, [f64; 2])] = Parameters::LIMITS;
}

impl Tunable for SegmentOptions {
    const HEADING: &'static str = "Which points belong to a building";
    const ELSEWHERE: &'static [&'static str] = &["building_classes", "ground_classes"];
    const LIMITS: &'static [(&'static str, [f64; 2])] = &[
        ("ring_width", [0.1, 1000.0]),
        ("ring_limit", [0.0, 1000.0]),
        ("ring_area", [0.0, 100_000.0]),
        ("ground_percentile", [0.0, 100.0]),
        ("cloud_density", [0.0, 10_000.0]),
        ("cloud_no_data", [0.0, 1.0]),
        ("least_height", [0.0, 1000.0]),
        ("flatness", [0.0, 1.0]),
        ("hover_gap", [0.01, 1000.0]),
        ("party_wall_band", [0.0, 100.0]),
        ("party_wall_rise", [0.01, 1000.0]),
    ];
}

impl Tunable for FieldOptions {
    const HEADING: &'static str = "Field";
    const ELSEWHERE: &'static [&'static str] = &[];
    const LIMITS: &'static [(&'static str, [f64; 2])] = &[];
}

impl Tunable for TerrainOptions {
    const HEADING: &'static str = "Terrain";
    const ELSEWHERE: &'static [&'static str] = &[];
    const LIMITS: &'static [(&'static str, [f64; 2])] =
        &[("terrain_error", [0.01, 100.0]), ("terrain_tile", [20.0, 2000.0]), ("terrain_gap", [2.0, 200.0])];
}

/// One field.
#[derive(Debug, Clone)]
pub struct Tuning {
    /// Its name.
    pub name: String,
    /// Where it stands in the JSON form of its structure, as a JSON pointer.
    pub pointer: String,
    /// What its documentation says.
    pub help: String,
    /// What it accepts.
    pub kind: Kind,
    /// Its default; null when it has none.
    pub default: Value,
}

/// The fields of a structure, in their order.
pub fn tunings<T: Tunable>() -> Vec<Tuning> {
    let settings = schemars::generate::SchemaSettings::draft2020_12().with(|s| s.inline_subschemas = true);
    let schema = settings.into_generator().into_root_schema_for::<T>().to_value();
    let default = serde_json::to_value(T::default()).unwrap_or_default();
    let mut tunings = Vec::new();
    collect(&schema, &default, "", &mut tunings);
    tunings.retain(|tuning| !T::ELSEWHERE.contains(&tuning.pointer.trim_start_matches('/')));
    for tuning in &mut tunings {
        let known = T::LIMITS.iter().find(|(name, _)| *name == tuning.name);
        if let (Some((_, [low, high])), Kind::Number { limits, .. }) = (known, &mut tuning.kind) {
            *limits = [limits[0].max(*low), limits[1].min(*high)];
        }
    }
    tunings
}

/// The structure with the values that `given` has for its fields, by name, in the form that [`Kind::accept`] gives.
///
/// # Errors
/// The name of the field whose value the structure does not take, and why.
pub fn tuned<'a, T: Tunable>(structure: &T, given: impl Fn(&str) -> Option<&'a Value>) -> Result<T, (String, String)> {
    let mut structure = structure.clone();
    for tuning in tunings::<T>() {
        let Some(value) = given(&tuning.name) else { continue };
        let fault = |e: serde_json::Error| (tuning.name.clone(), e.to_string());
        let mut fields = serde_json::to_value(&structure).map_err(fault)?;
        let Some(place) = fields.pointer_mut(&tuning.pointer) else { continue };
        *place = value.clone();
        structure = serde_json::from_value(fields).map_err(fault)?;
    }
    Ok(structure)
}

fn collect(schema: &Value, default: &Value, pointer: &str, tunings: &mut Vec<Tuning>) {
    let Some(properties) = schema.get("properties").and_then(Value::as_object) else { return };
    for (field, schema) in properties {
        let pointer = format!("{pointer}/{field}");
        let default = default.get(field).unwrap_or(&Value::Null);
        if schema.get("properties").is_some() {
            collect(schema, default, &pointer, tunings);
        } else {
            tunings.push(Tuning {
                name: field.clone(),
                pointer,
                help: description(schema),
                kind: Kind::of_schema(schema),
                default: default.clone(),
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn check<T: Tunable>() -> Vec<String> {
        let fields = serde_json::to_value(T::default()).unwrap();
        let tunings = tunings::<T>();
        assert!(tunings.len() + T::ELSEWHERE.len() >= fields.as_object().unwrap().len());
        for tuning in &tunings {
            assert!(!tuning.help.is_empty(), "{} has no help", tuning.name);
            assert!(fields.pointer(&tuning.pointer).is_some(), "{} is nowhere in the structure", tuning.pointer);
        }
        for (name, _) in T::LIMITS {
            assert!(tunings.iter().any(|tuning| tuning.name == *name), "a range for {name}, which is no option");
        }
        tunings.into_iter().map(|tuning| tuning.name).collect()
    }

    #[test]
    fn every_parameter_is_an_option_with_help() {
        let mut names = check::<Parameters>();
        names.extend(check::<SegmentOptions>());
        names.extend(check::<FieldOptions>());
        names.extend(check::<TerrainOptions>());
        let count = names.len();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), count, "two options of one name");
    }

    #[test]
    fn an_option_sets_its_field_and_nothing_else() {
        let (value, other) = (json!(4.5), json!("wide"));
        let set = tuned(&SegmentOptions::default(), |name| (name == "ring_width").then_some(&value)).unwrap();
        assert_eq!(set, SegmentOptions { ring_width: 4.5, ..SegmentOptions::default() });
        let fault = tuned(&SegmentOptions::default(), |name| (name == "ring_width").then_some(&other)).unwrap_err();
        assert_eq!(fault.0, "ring_width");
    }

    #[test]
    fn nested_fields_keep_their_own_names() {
        let schema =
            json!({"properties": {"cut": {"properties": {"max_cells": {"type": "integer", "description": "d"}}}}});
        let mut tunings = Vec::new();
        collect(&schema, &json!({"cut": {"max_cells": 3}}), "", &mut tunings);
        assert_eq!((tunings[0].name.as_str(), tunings[0].pointer.as_str()), ("max_cells", "/cut/max_cells"));
        assert_eq!(tunings[0].default, json!(3));
    }
}
