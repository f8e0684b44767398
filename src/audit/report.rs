//! The findings on a file, in the shape of val3dity's report.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use serde::Serialize;

use super::Options;
use crate::validate::codes;

/// A fault in a file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// The code: val3dity's, or one of gable's own (801 to 810).
    pub code: u16,
    /// The name of the code.
    pub description: &'static str,
    /// Where it is: `coid=…|geom=0|shell=0|face=3`, as far as it goes; `solid=` stands before `shell=` in geometries of
    /// several solids.
    pub id: String,
    /// What is wrong, for a person; vertices by their indices in the file.
    pub info: String,
}

impl Finding {
    /// A fault of this code.
    pub fn new(code: u16, id: impl Into<String>, info: impl Into<String>) -> Self {
        Self { code, description: codes::name(code), id: id.into(), info: info.into() }
    }
}

/// A top-level `CityObject` with all its children.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Feature {
    /// Its id.
    pub id: String,
    /// Its type: `Building`, `TINRelief`, …
    #[serde(rename = "type")]
    pub kind: String,
    /// Whether it has no geometric fault.
    pub validity: bool,
    /// Its geometric faults.
    pub errors: Vec<Finding>,
    /// What its labels and attributes say that is not so; does not count against its validity.
    pub semantic_errors: Vec<Finding>,
    /// Its geometries: type and whether it is valid.
    #[serde(skip)]
    pub primitives: Vec<(&'static str, bool)>,
}

/// How many there are of a type, and how many of them are valid.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Overview {
    /// The type.
    #[serde(rename = "type")]
    pub kind: String,
    /// How many there are.
    pub total: usize,
    /// How many of them are valid.
    pub valid: usize,
}

/// The tolerances that were used, under val3dity's names.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Parameters {
    /// Vertices no farther apart than this are one, metres.
    pub snap_tol: f64,
    /// How far a vertex may be off the plane of its face, metres.
    pub planarity_d2p_tol: f64,
    /// How far a part of a face may turn from its plane, degrees.
    pub planarity_n_tol: f64,
    /// How far solids and building parts may overlap, metres.
    pub overlap_tol: f64,
}

/// All findings on a file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// Always `val3dity_report`, for programs that read those.
    #[serde(rename = "type")]
    pub kind: &'static str,
    /// The version of gable.
    pub gable_version: &'static str,
    /// The file, as it was given.
    pub input_file: String,
    /// `CityJSON` and its version; `unknown` for a file that was refused.
    pub input_file_type: String,
    /// The CRS, when the file names one that is understood; else lengths are taken for metres.
    pub crs: Option<String>,
    /// Size of a step of the grid on which the file was checked, metres; `None` for a file without features.
    pub grid_step: Option<[f64; 3]>,
    /// The tolerances.
    pub parameters: Parameters,
    /// Whether nothing is invalid.
    pub validity: bool,
    /// The codes of all geometric faults, in order.
    pub all_errors: BTreeSet<u16>,
    /// The codes of all semantic faults, in order.
    pub all_semantic_errors: BTreeSet<u16>,
    /// What is wrong with the file as a whole, and features that could not be read.
    pub dataset_errors: Vec<Finding>,
    /// Where the file is not as the official schema of its version wants it.
    pub schema_errors: Vec<Finding>,
    /// What the schema allows and its makers warn of, one sentence each; does not count against the validity.
    pub schema_warnings: Vec<String>,
    /// What could not be checked, one sentence each.
    pub notes: Vec<String>,
    /// The features by type.
    pub features_overview: Vec<Overview>,
    /// The geometries by type.
    pub primitives_overview: Vec<Overview>,
    /// The features, in the order of the file.
    pub features: Vec<Feature>,
}

impl Report {
    /// A report on a file of which nothing is known yet.
    pub(super) fn open(path: &Path, options: &Options) -> Self {
        Self {
            kind: "val3dity_report",
            gable_version: env!("CARGO_PKG_VERSION"),
            input_file: path.display().to_string(),
            input_file_type: "unknown".to_owned(),
            crs: None,
            grid_step: None,
            parameters: Parameters {
                snap_tol: options.tolerances.snap,
                planarity_d2p_tol: options.tolerances.planarity,
                planarity_n_tol: options.tolerances.normals,
                overlap_tol: options.overlap,
            },
            validity: true,
            all_errors: [].into(),
            all_semantic_errors: [].into(),
            dataset_errors: Vec::new(),
            schema_errors: Vec::new(),
            schema_warnings: Vec::new(),
            notes: Vec::new(),
            features_overview: Vec::new(),
            primitives_overview: Vec::new(),
            features: Vec::new(),
        }
    }

    /// What is invalid, in words: `schema`, `geometry`, `file`, or several of them; empty when all is valid.
    pub fn invalid(&self) -> Vec<&'static str> {
        let geometry = self.features.iter().any(|feature| !feature.validity);
        let kinds = [
            ("file", !self.dataset_errors.is_empty()),
            ("schema", !self.schema_errors.is_empty()),
            ("geometry", geometry),
        ];
        kinds.into_iter().filter(|(_, is_invalid)| *is_invalid).map(|(kind, _)| kind).collect()
    }

    /// What is told and makes nothing invalid, in words: `labels and attributes`, `warnings`, or both; empty without.
    pub fn told(&self) -> Vec<&'static str> {
        let kinds = [
            ("labels and attributes", !self.all_semantic_errors.is_empty()),
            ("warnings", !self.schema_warnings.is_empty()),
        ];
        kinds.into_iter().filter(|(_, is_told)| *is_told).map(|(kind, _)| kind).collect()
    }

    /// Counts and closes.
    pub(super) fn close(mut self) -> Self {
        let mut kinds = BTreeMap::new();
        let mut primitives = BTreeMap::new();
        for feature in &self.features {
            count(&mut kinds, &feature.kind, feature.validity);
            feature.primitives.iter().for_each(|(kind, valid)| count(&mut primitives, kind, *valid));
            self.all_errors.extend(feature.errors.iter().map(|f| f.code));
            self.all_semantic_errors.extend(feature.semantic_errors.iter().map(|f| f.code));
        }
        self.all_errors.extend(self.dataset_errors.iter().chain(&self.schema_errors).map(|f| f.code));
        self.features_overview = kinds.into_values().collect();
        self.primitives_overview = primitives.into_values().collect();
        self.validity = self.all_errors.is_empty();
        self
    }
}

fn count(overview: &mut BTreeMap<String, Overview>, kind: &str, valid: bool) {
    let row = overview.entry(kind.to_owned()).or_insert_with(|| Overview { kind: kind.to_owned(), total: 0, valid: 0 });
    row.total += 1;
    row.valid += usize::from(valid);
}
