//! The attributes that gable gives a building, and the source's own beside them.

use serde::Serialize;
use serde_json::{Map, Value, json};

use super::selection::{AttributeOptions, Names, PREFIX};
use crate::building::{Building, Outcome, RoofHeights};
use crate::completeness::Extents;
use crate::record::{Change, PointCloud};
use crate::site::Frame;

/// An attribute that gable gives a building.
pub struct Attribute {
    /// Its name in the model, unless another prefix is asked for.
    pub name: &'static str,
    /// Its unit; empty for text, counts and shares. `CRS` is the vertical unit of the CRS.
    pub unit: &'static str,
    /// What it means.
    pub meaning: &'static str,
    /// Its value; `None` when it does not apply.
    value: fn(&Subject) -> Option<Value>,
}

/// A building with the notes on its attributes.
struct Subject<'a> {
    building: &'a Building,
    point_cloud: &'a PointCloud,
    notes: Vec<String>,
}

impl Subject<'_> {
    /// An absolute height from one in metres of the local frame.
    fn height(&self, local: Option<f64>) -> Option<Value> {
        height(&self.building.frame, local?).map(Value::from)
    }

    /// The point cloud that the building is of.
    fn cloud(&self) -> &PointCloud {
        self.building.record.cloud.as_ref().map_or(self.point_cloud, |of| &of.cloud)
    }

    fn change(&self) -> Option<&Change> {
        self.building.record.change.as_ref()
    }

    fn extent(&self, pick: fn(&Extents) -> f64) -> Option<Value> {
        number(self.building.measures.completeness.as_ref().map(pick), 2)
    }

    fn roof_height(&self, pick: fn(&RoofHeights) -> f64) -> Option<Value> {
        self.height(self.building.measures.roof_heights.as_ref().map(pick))
    }
}

/// A short-hand for the rows of the table.
const fn row(
    name: &'static str,
    unit: &'static str,
    meaning: &'static str,
    value: fn(&Subject) -> Option<Value>,
) -> Attribute {
    Attribute { name, unit, meaning, value }
}

/// All attributes that gable gives a building, in the order in which they are written. Those that do not apply are left
/// out.
pub const ATTRIBUTES: &[Attribute] = &[
    row(
        "gable_success",
        "",
        "whether every part is a valid LoD 2.2 solid, and the tiles cover the whole footprint",
        |s| Some((s.building.outcome == Outcome::Lod22).into()),
    ),
    row("gable_lod", "", "highest level of detail that was reached: 2.3, 2.2, 1.2 or 0", |s| {
        let lod = s.building.outcome.lod()?;
        let hangs_over = lod == "2.2" && s.building.model.lod23().next().is_some();
        Some(if hangs_over { "2.3" } else { lod }.into())
    }),
    row("gable_fallback_reason", "", "why LoD 2.2 of the whole building was not reached, as a keyword", |s| {
        s.building.outcome.reason().and_then(|(reason, _)| keyword(reason))
    }),
    row("gable_fallback_detail", "", "why LoD 2.2 of the whole building was not reached, in words", |s| {
        s.building.outcome.reason().map(|(_, detail)| detail.into())
    }),
    row(
        "gable_ladder_step",
        "",
        "on which step of the ladder the model stands: lod22, lod22-coarse (tolerances times 2), lod22-coarsest (times \
         4), partial (LoD 2.2 of what the tiles cover), lod12 or footprint",
        |s| s.building.ladder_step().and_then(keyword),
    ),
    row("gable_ladder_reasons", "", "why the steps of LoD 2.2 above it were left, as keywords, finest first", |s| {
        let reasons: Vec<Value> = s.building.measures.setbacks.iter().filter_map(|b| keyword(b.reason)).collect();
        (!reasons.is_empty()).then(|| reasons.into())
    }),
    row("gable_ladder_codes", "", "val3dity codes of the faults that were met on these steps", |s| {
        let mut codes: Vec<u16> = s.building.measures.setbacks.iter().flat_map(|b| &b.codes).copied().collect();
        codes.sort_unstable();
        codes.dedup();
        (!codes.is_empty()).then(|| json!(codes))
    }),
    row("gable_roof_type", "", "flat, multiple-flat or slanted", |s| s.building.measures.roof_type.and_then(keyword)),
    row("gable_roof_planes", "", "number of roof planes at LoD 2.2", |s| {
        s.building.measures.roof_planes.map(Value::from)
    }),
    row("gable_height_ground", "CRS", "height of the ground", |s| {
        s.height(s.building.measures.ground.map(|ground| ground.height))
    }),
    row("gable_height_roof_min", "CRS", "height of the lowest roof point", |s| s.roof_height(|h| h.min)),
    row("gable_height_roof_50p", "CRS", "median height of the roof points", |s| s.roof_height(|h| h.p50)),
    row("gable_height_roof_70p", "CRS", "70th percentile of the heights of the roof points: top of LoD 1.2", |s| {
        s.roof_height(|h| h.p70)
    }),
    row("gable_height_roof_98p", "CRS", "98th percentile of the heights of the roof points", |s| {
        s.roof_height(|h| h.p98)
    }),
    row(
        "gable_height_roof_max",
        "CRS",
        "height of the highest point of the roof: of the model at LoD 2.2, without it of the points",
        |s| s.roof_height(|h| h.max),
    ),
    row("gable_height_ridge", "CRS", "height of the highest edge between two roof planes", |s| {
        s.height(s.building.measures.ridge_height)
    }),
    row("gable_ridges", "", "number of ridges: level lines from which two roof planes fall", |s| {
        s.building.measures.ridges.map(|ridges| ridges.count.into())
    }),
    row("gable_ridge_length", "m", "length of all ridges together", |s| {
        number(s.building.measures.ridges.map(|ridges| ridges.length), 2)
    }),
    row(
        "gable_rmse_lod12",
        "m",
        "root mean square of the distances of the points to the nearest face at LoD 1.2",
        |s| number(s.building.measures.rmse_lod12, 3),
    ),
    row(
        "gable_rmse_lod13",
        "m",
        "root mean square of the distances of the points to the nearest face at LoD 1.3",
        |s| number(s.building.measures.rmse_lod13, 3),
    ),
    row(
        "gable_rmse_lod22",
        "m",
        "root mean square of the distances of the points to the nearest face at LoD 2.2",
        |s| number(s.building.measures.rmse_lod22, 3),
    ),
    row(
        "gable_rmse_lod23",
        "m",
        "root mean square of the distances of the points to the nearest face at LoD 2.3",
        |s| number(s.building.measures.rmse_lod23, 3),
    ),
    row(
        "gable_confidence",
        "",
        "how far the model at LoD 2.2 can be trusted, 0 to 1: how sure the field is, less what is missing, in excess, without \
         data or not covered",
        |s| number(s.building.measures.confidence, 3),
    ),
    row(
        "gable_missing_area",
        "m²",
        "roof that was scanned more than 1 m above the model at LoD 2.2, all such areas together",
        |s| s.extent(|e| e.missing.area),
    ),
    row("gable_missing_largest", "m²", "the largest of these areas", |s| s.extent(|e| e.missing.largest)),
    row(
        "gable_excess_area",
        "m²",
        "model at LoD 2.2 more than 1 m above everything that was scanned around, all such areas together",
        |s| s.extent(|e| e.excess.area),
    ),
    row("gable_excess_largest", "m²", "the largest of these areas", |s| s.extent(|e| e.excess.largest)),
    row("gable_roofed_ground_area", "m²", "open ground under the model at LoD 2.2, all such areas together", |s| {
        s.extent(|e| e.roofed_ground.area)
    }),
    row("gable_roofed_ground_largest", "m²", "the largest of these areas", |s| s.extent(|e| e.roofed_ground.largest)),
    row("gable_field_fallback", "", "why the height-field vote decided, not the field that was asked for", |s| {
        s.building.measures.field_fallback.clone().map(Value::from)
    }),
    row("gable_volume_lod12", "m³", "volume at LoD 1.2", |s| number(s.building.measures.volume_lod12, 3)),
    row("gable_volume_lod13", "m³", "volume at LoD 1.3", |s| number(s.building.measures.volume_lod13, 3)),
    row("gable_volume_lod22", "m³", "volume at LoD 2.2", |s| number(s.building.measures.volume_lod22, 3)),
    row("gable_volume_lod23", "m³", "volume at LoD 2.3", |s| number(s.building.measures.volume_lod23, 3)),
    row("gable_validity_lod12", "", "val3dity codes of the faults at LoD 1.2; empty when valid", |s| {
        // Blocks are valid by construction, and nothing invalid is written.
        s.building.model.lod12().next().map(|_| json!([]))
    }),
    row("gable_validity_lod13", "", "val3dity codes of the faults at LoD 1.3; empty when valid", |s| {
        // What would not be valid is replaced by a block.
        s.building.model.lod13().next().map(|_| json!([]))
    }),
    row("gable_validity_lod22", "", "val3dity codes of the faults at LoD 2.2; empty when valid", |s| {
        let faults = &s.building.measures.faults_lod22;
        (!faults.is_empty() || s.building.model.lod22().next().is_some()).then(|| json!(faults))
    }),
    row("gable_validity_lod23", "", "val3dity codes of the faults at LoD 2.3; empty when valid", |s| {
        // What would not be valid is left out.
        s.building.model.lod23().next().map(|_| json!([]))
    }),
    row("gable_point_cloud_source", "", "name of the point cloud, as given", |s| {
        s.cloud().source.clone().map(Value::from)
    }),
    row("gable_point_cloud_date", "", "when the point cloud was recorded, as given", |s| {
        s.cloud().date.clone().map(Value::from)
    }),
    row(
        "gable_point_cloud_choice",
        "",
        "of several point clouds, why it is made from this one: first, others-too-thin, best-of-thin, others-outdated or \
         none-new-enough",
        |s| s.building.record.cloud.as_ref().and_then(|cloud| keyword(cloud.choice)),
    ),
    row("gable_is_mutated", "", "whether it has changed between two surveys, where two point clouds tell", |s| {
        s.change().map(|change| change.mutation.is_some().into())
    }),
    row("gable_mutation", "", "what became of it between two surveys: built, torn-down, raised or lowered", |s| {
        s.change()?.mutation.and_then(keyword)
    }),
    row("gable_mutated_area", "m²", "how much of it has changed between two surveys", |s| {
        number(s.change().filter(|change| change.mutation.is_some()).map(|change| change.area), 0)
    }),
    row("gable_mutated_since", "", "the older of the two surveys: the name of its point cloud, or its date", |s| {
        let since = s.change()?.since.as_ref()?;
        since.source.clone().or_else(|| since.date.clone()).map(Value::from)
    }),
    row("gable_points", "", "number of building points", |s| Some(s.building.measures.points.into())),
    row("gable_point_density", "1/m²", "building points per area of footprint", |s| {
        number(s.building.measures.point_density, 3)
    }),
    row("gable_no_data_share", "", "share of the footprint farther than 1 m from any building point", |s| {
        number(s.building.measures.no_data_share, 4)
    }),
    row("gable_coverage", "", "share of the footprint that the given tiles cover", |s| {
        number(s.building.measures.coverage.map(|coverage| coverage.share), 4)
    }),
    row("gable_open_ground_area", "m²", "open ground inside the footprint: nothing was scanned above it", |s| {
        number(s.building.measures.open_ground, 2)
    }),
    row(
        "gable_ground_source",
        "",
        "what the floor was taken from: attribute, terrain-model, ground-points, neighbours, lowest-points, scanned-floor, bounding-box or edit",
        |s| s.building.measures.ground.and_then(|ground| keyword(ground.source)),
    ),
    row("gable_ground_spread", "m", "interquartile range of the ground heights around the building", |s| {
        number(s.building.measures.ground.map(|ground| ground.spread), 3)
    }),
    row(
        "gable_floor_depth_min",
        "m",
        "least depth of the floor under the ground along the outline; negative where it hangs above",
        |s| number(s.building.measures.floor_depth.map(|depth| depth[0]), 3),
    ),
    row("gable_floor_depth_max", "m", "greatest depth of the floor under the ground along the outline", |s| {
        number(s.building.measures.floor_depth.map(|depth| depth[1]), 3)
    }),
    row("gable_primitives", "", "number of planes found in the points", |s| {
        (s.building.measures.points > 0).then(|| s.building.measures.primitives.into())
    }),
    row("gable_edits", "", "how many edits of a person it follows", |s| {
        s.building.measures.edits.as_ref().map(|edits| edits.applied.into())
    }),
    row("gable_edits_refused", "", "how many edits of a person do not apply to it; the notes say why", |s| {
        s.building.measures.edits.as_ref().map(|edits| edits.refused.len().into())
    }),
    row("gable_points_file", "", "the file of its points beside the index, where they were cropped", |s| {
        s.building.record.points_file.as_ref().map(|file| file.name.clone().into())
    }),
    row("gable_points_in_file", "", "number of points in that file, of all classes", |s| {
        s.building.record.points_file.as_ref().map(|file| file.points.into())
    }),
    row("gable_notes", "", "what else there is to know: repairs, a made-up id, an incomplete tile", |s| {
        (!s.notes.is_empty()).then(|| s.notes.clone().into())
    }),
];

impl Attribute {
    /// Its name without the prefix.
    pub fn bare(&self) -> &'static str {
        self.name.strip_prefix(PREFIX).unwrap_or(self.name)
    }
}

/// Some of gable's own attributes, by their names with or without the prefix.
///
/// # Errors
/// One that does not exist, with the nearest that does.
pub fn own_names(text: &str) -> Result<Names, String> {
    let names: Names = text.parse()?;
    let known: Vec<&str> = ATTRIBUTES.iter().flat_map(|attribute| [attribute.name, attribute.bare()]).collect();
    let Some(unknown) = names.unknown(&known) else { return Ok(names) };
    let unknown = unknown.to_string();
    let likeness = |name: &str| strsim::jaro_winkler(&unknown.to_lowercase(), name);
    let nearest = known.into_iter().max_by(|a, b| likeness(a).total_cmp(&likeness(b))).unwrap_or_default();
    Err(format!("there is no attribute {unknown}; the nearest is {nearest}"))
}

/// The attributes that are written, gable's own under their names.
#[derive(Debug)]
pub(super) struct Chosen {
    /// Indices into [`ATTRIBUTES`], with the name of each.
    own: Vec<(usize, String)>,
    options: AttributeOptions,
}

impl Default for Chosen {
    fn default() -> Self {
        Self::new(AttributeOptions::default())
    }
}

impl Chosen {
    /// Those that are asked for.
    pub(super) fn new(options: AttributeOptions) -> Self {
        let is_chosen = |(_, a): &(usize, &Attribute)| options.own.have(a.name) || options.own.have(a.bare());
        let named = |(i, a): (usize, &Attribute)| (i, format!("{}{}", options.prefix, a.bare()));
        let own = ATTRIBUTES.iter().enumerate().filter(is_chosen).map(named).collect();
        Self { own, options }
    }

    /// The attributes of a building: the source's as they are, then gable's.
    ///
    /// A name that begins with `+` would ask for an Extension, and one of gable's would be hidden: such a source attribute
    /// is written as `source_…`, and a note says so.
    pub(super) fn of(&self, building: &Building, point_cloud: &PointCloud) -> Map<String, Value> {
        let mut out = Map::new();
        let mut notes = building.notes.clone();
        for (name, value) in building.attributes.iter().filter(|(name, _)| self.options.source.have(name)) {
            let mut written = name.clone();
            if self.options.reserves(name) {
                written = format!("source_{}", name.trim_start_matches('+'));
                while building.attributes.contains_key(&written) || out.contains_key(&written) {
                    written.insert_str(0, "source_");
                }
                notes.push(format!("the attribute {name:?} is written as {written:?}"));
            }
            out.insert(written, value.clone());
        }
        let subject = Subject { building, point_cloud, notes };
        for (index, name) in &self.own {
            if let Some(value) = ATTRIBUTES.get(*index).and_then(|attribute| (attribute.value)(&subject)) {
                out.insert(name.clone(), value);
            }
        }
        out
    }
}

impl AttributeOptions {
    /// Whether an attribute of the source of this name is written under another: it is one of gable's, chosen or not, so
    /// that nobody takes it for what gable says; or it asks for an Extension.
    pub fn reserves(&self, name: &str) -> bool {
        let bare = name.strip_prefix(self.prefix.as_str());
        name.starts_with('+') || ATTRIBUTES.iter().any(|attribute| bare == Some(attribute.bare()))
    }
}

/// A height in metres of the local frame as a height in the vertical unit of the CRS, to three decimals.
pub(super) fn height(frame: &Frame, local: f64) -> Option<f64> {
    rounded(frame.origin[2] + local / frame.metres_per_unit[2], 3)
}

/// A number to so many decimals; `None` when it is not finite. There is no negative zero.
pub(super) fn rounded(value: f64, decimals: i32) -> Option<f64> {
    let scale = 10f64.powi(decimals);
    let rounded = (value * scale).round() / scale;
    rounded.is_finite().then_some(rounded + 0.0)
}

fn number(value: Option<f64>, decimals: i32) -> Option<Value> {
    rounded(value?, decimals).map(Value::from)
}

/// The keyword of a unit variant.
fn keyword(value: impl Serialize) -> Option<Value> {
    serde_json::to_value(value).ok()
}
