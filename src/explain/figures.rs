//! The figures of each step, and the parameters that it went by.

use geo::Area;
use serde::Serialize;
use serde_json::{Value, json};

use super::Step;
use crate::building::{Building, Measures};
use crate::network::FieldOptions;
use crate::reconstruct::{Asked, Parameters, Partitioning, Steps, Surfaced};
use crate::segment::SegmentOptions;
use crate::site::{Frame, GroundSource};
use crate::solid::{Solid, SurfaceType};

/// An occupancy this near to 0 or 1 leaves no doubt.
const SURE: f64 = 0.1;

/// A figure.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Figure {
    /// What it is.
    name: &'static str,
    /// A number, or words.
    value: Value,
    /// Its unit; empty for counts, shares and words.
    unit: &'static str,
}

/// A parameter, by the name of its option.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Parameter {
    option: String,
    value: Value,
}

/// Figures while they are gathered.
#[derive(Default)]
struct Figures(Vec<Figure>);

impl Figures {
    fn add(&mut self, name: &'static str, value: impl Into<Value>, unit: &'static str) {
        self.0.push(Figure { name, value: value.into(), unit });
    }

    /// A number to so many decimals, if there is one.
    fn number(&mut self, name: &'static str, value: impl Into<Option<f64>>, decimals: i32, unit: &'static str) {
        let scale = 10_f64.powi(decimals);
        if let Some(value) = value.into().filter(|value| value.is_finite()) {
            self.add(name, (value * scale).round() / scale + 0.0, unit);
        }
    }

    fn words(&mut self, name: &'static str, value: impl Into<Option<String>>) {
        if let Some(value) = value.into() {
            self.add(name, value, "");
        }
    }
}

/// The figures of a step, as far as the method got.
pub(super) fn figures(step: Step, steps: &Steps, building: &Building, field: &FieldOptions) -> Vec<Figure> {
    let mut out = Figures::default();
    match step {
        Step::Points => points(steps, &building.frame, &building.measures, &mut out),
        Step::Found => found(steps, &mut out),
        Step::Refined => refined(steps, &mut out),
        Step::Walls => walls(steps, &mut out),
        Step::Cells => cells(steps, &mut out),
        Step::Field => {
            if let (Some(partition), Some(asked)) = (&steps.partition, &steps.field) {
                occupancy(partition, asked, field, &mut out);
            }
        }
        Step::Cut => cut(steps, &mut out),
        Step::Surface => {
            if let Some(surface) = &steps.surface {
                faces(surface, &mut out);
            }
        }
        Step::Result => result(building, &mut out),
    }
    out.0
}

fn points(steps: &Steps, frame: &Frame, measures: &Measures, out: &mut Figures) {
    let Some(site) = &steps.site else { return };
    out.add("points of the building", site.points.len(), "");
    out.number("density", measures.point_density, 1, "points per m²");
    out.number("footprint", site.footprint.as_ref().map(Area::unsigned_area), 1, "m²");
    out.number("of it open ground, on which nothing stands", measures.open_ground.filter(|area| *area > 0.0), 1, "m²");
    out.number("covered by the tiles", (!site.coverage.is_complete()).then_some(100.0 * site.coverage.share), 1, "%");
    let floor = frame.origin[2] + site.ground.height / frame.metres_per_unit[2];
    let unit = if (frame.metres_per_unit[2] - 1.0).abs() < 1e-9 { "m" } else { "units of the CRS" };
    out.number("floor, in the CRS", floor, 3, unit);
    out.words("taken from", ground_source(site.ground.source).to_owned());
}

/// Where the floor comes from, in words.
fn ground_source(source: GroundSource) -> &'static str {
    match source {
        GroundSource::Attribute => "an attribute of the footprint",
        GroundSource::TerrainModel => "the terrain model",
        GroundSource::GroundPoints => "the ground points around",
        GroundSource::Neighbours => "the floors of its neighbours",
        GroundSource::LowestPoints => "the lowest points around",
        GroundSource::ScannedFloor => "the floor, which was scanned",
        GroundSource::BoundingBox => "the lowest of its own points",
        GroundSource::Edit => "a person who edited it",
    }
}

fn found(steps: &Steps, out: &mut Figures) {
    let (Some(site), Some(found)) = (&steps.site, &steps.found) else { return };
    let on_planes: usize = found.iter().map(|plane| plane.inliers.len()).sum();
    out.add("planes", found.len(), "");
    out.number("points on them", 100.0 * on_planes as f64 / site.points.len().max(1) as f64, 1, "%");
    out.add("points on none", site.points.len().saturating_sub(on_planes), "");
    out.number("noise across the surfaces", steps.detected.as_ref().map(|detected| detected.noise), 3, "m");
}

fn refined(steps: &Steps, out: &mut Figures) {
    let Some(detected) = &steps.detected else { return };
    out.add("planes before", steps.found.as_ref().map_or(0, Vec::len), "");
    out.add("planes after", detected.count, "");
    out.add("roofs, in pieces that hang together", detected.roofs.len(), "");
    if !detected.undersides.is_empty() {
        out.add("undersides", detected.undersides.len(), "");
    }
    out.add("walls that were scanned", detected.walls.len(), "");
    if detected.revised > 0 {
        out.add("added because a first model left their points unexplained", detected.revised, "");
    }
}

fn walls(steps: &Steps, out: &mut Figures) {
    let Some(Partitioning { primitives, roofs, undersides, .. }) = &steps.partition else { return };
    let of = |kind| primitives.iter().filter(|primitive| primitive.kind == kind).count();
    out.add("planes that cut", primitives.len(), "");
    out.add("roofs", *roofs, "");
    if *undersides > 0 {
        out.add("undersides", *undersides, "");
    }
    out.add("edges of the footprint", of(crate::reconstruct::primitives::PrimitiveKind::FootprintEdge), "");
    out.add("height jumps and scanned walls", of(crate::reconstruct::primitives::PrimitiveKind::HeightJump), "");
}

fn cells(steps: &Steps, out: &mut Figures) {
    let Some(Partitioning { complex, bounds, volumes, fixed, .. }) = &steps.partition else { return };
    let [x, y, z] = bounds.extent();
    out.words("box", format!("{x:.1} × {y:.1} × {z:.1} m"));
    out.add("planes that differ", complex.planes.len(), "");
    out.add("cells", complex.cells.len(), "");
    out.add("facets between them", complex.facets.len(), "");
    let outside = fixed.iter().filter(|fixed| fixed.is_some()).count();
    out.add("cells beyond the footprint, which are outside", outside, "");
    let free = volumes.iter().zip(fixed).filter(|(_, fixed)| fixed.is_none());
    out.number("volume that is left to decide", free.map(|(volume, _)| volume).sum::<f64>(), 1, "m³");
}

fn occupancy(partition: &Partitioning, asked: &Asked, field: &FieldOptions, out: &mut Figures) {
    out.words("asked for", field.field.name().to_owned());
    let answered = if asked.is_height_field { "the vote of the roof evidence" } else { "the network" };
    out.words("answered by", answered.to_owned());
    let is_unasked = asked.is_height_field && asked.fallback.is_none() && field.field.name() != "height-field";
    out.words(
        "why",
        asked.fallback.clone().or_else(|| is_unasked.then(|| "the vote leaves nothing unexplained".into())),
    );
    let answers = || asked.occupancy.iter().zip(&partition.fixed).filter(|(_, fixed)| fixed.is_none()).map(|(o, _)| *o);
    out.add("cells asked about", answers().count(), "");
    out.add("surely inside (0.9 or more)", answers().filter(|o| *o >= 1.0 - SURE).count(), "");
    out.add("in doubt", answers().filter(|o| (SURE..1.0 - SURE).contains(o)).count(), "");
    out.add("surely outside (less than 0.1)", answers().filter(|o| *o < SURE).count(), "");
}

fn cut(steps: &Steps, out: &mut Figures) {
    let (Some(partition), Some(asked), Some(cut)) = (&steps.partition, &steps.field, &steps.cut) else { return };
    let inside = |cell: usize| cut.inside.get(cell) == Some(&true);
    let volume = |cell: usize| partition.volumes.get(cell).copied().unwrap_or(0.0);
    let all = 0..partition.volumes.len();
    out.add("cells inside", all.clone().filter(|&cell| inside(cell)).count(), "");
    out.number("volume inside", all.filter(|&cell| inside(cell)).map(volume).sum::<f64>(), 1, "m³");
    let likelier = |cell: usize| asked.occupancy.get(cell).is_some_and(|o| *o > 0.5);
    let free = (0..partition.fixed.len()).filter(|&cell| partition.fixed[cell].is_none());
    let overruled: Vec<usize> = free.filter(|&cell| inside(cell) != likelier(cell)).collect();
    out.add("cells that went against their own probability", overruled.len(), "");
    out.number("volume of these", overruled.into_iter().map(volume).sum::<f64>(), 2, "m³");
    out.number("λ", cut.cost.lambda, 4, "");
    out.number("D, distance from the probabilities", cut.cost.data, 4, "");
    out.number("V, unexplained surface", cut.cost.smoothness, 4, "");
    out.number("E = D + λ V", cut.cost.data + cut.cost.lambda * cut.cost.smoothness, 4, "");
}

fn faces(surface: &Surfaced, out: &mut Figures) {
    let Surfaced { slivers, features, repairs, wedges, solids, .. } = surface;
    let of = |kind| {
        let faces = solids.iter().flat_map(|solid| solid.faces.iter().map(move |face| solid.kind(face)));
        faces.filter(|own| *own == kind).count()
    };
    out.add("solids", solids.len(), "");
    out.add("faces", solids.iter().map(|solid| solid.faces.len()).sum::<usize>(), "");
    out.add("roofs", of(SurfaceType::Roof), "");
    out.add("walls", of(SurfaceType::Wall), "");
    out.add("floors", of(SurfaceType::Ground), "");
    if of(SurfaceType::OuterCeiling) > 0 {
        out.add("ceilings in the open", of(SurfaceType::OuterCeiling), "");
    }
    out.add("vertices", solids.iter().map(|solid| solid.vertices.len()).sum::<usize>(), "");
    out.number("volume", solids.iter().map(Solid::volume).sum::<f64>(), 1, "m³");
    out.add("cells relabelled: slivers", *slivers, "");
    out.add("cells relabelled: small features", *features, "");
    out.add("cells relabelled: where the surface touched itself", *repairs, "");
    if *wedges > 0 {
        out.add("wedges where two parts touched along an edge", *wedges, "");
    }
}

fn result(building: &Building, out: &mut Figures) {
    let Building { outcome, measures, .. } = building;
    let reached = match building.ladder_step() {
        Some(step) => serde_json::to_value(step).ok().and_then(|step| step.as_str().map(str::to_owned)),
        None => None,
    };
    out.words("step of the ladder", reached);
    out.words("fell short because", outcome.reason().map(|(_, detail)| detail.to_owned()));
    for setback in &measures.setbacks {
        out.words("an attempt failed", setback.detail.clone());
    }
    if let Some(revision) = measures.revision {
        out.add("rounds in which it was made again", revision.rounds, "");
        out.number("missing or in excess before", revision.before, 1, "m²");
        out.number("and after", revision.after, 1, "m²");
    }
    out.number("RMSE, points to the nearest face of LoD 2.2", measures.rmse_lod22, 3, "m");
    out.number("the same of the block, LoD 1.2", measures.rmse_lod12, 3, "m");
    if let Some(extents) = &measures.completeness {
        out.number("scanned and missing", extents.missing.area, 1, "m²");
        out.number("modelled and not scanned", extents.excess.area, 1, "m²");
        out.number("roofed ground", extents.roofed_ground.area, 1, "m²");
    }
    out.number("confidence", measures.confidence, 3, "");
    let codes = &measures.faults_lod22;
    let validity = if codes.is_empty() { "valid, or it would not be written".to_owned() } else { format!("{codes:?}") };
    out.words("faults of LoD 2.2, by val3dity's codes", measures.rmse_lod22.map(|_| validity));
}

/// The parameters of a step by the names of their options.
pub(super) fn parameters(
    step: Step,
    parameters: &Parameters,
    segmentation: &SegmentOptions,
    field: &FieldOptions,
) -> Vec<Parameter> {
    let Parameters { detection, labelling, surface, .. } = parameters;
    let (all, names): (Value, &[&str]) = match step {
        Step::Points => (
            json!({
                "building-class": segmentation.building_classes.to_string(),
                "ground-class": segmentation.ground_classes,
                "ring-width": segmentation.ring_width,
            }),
            &["building-class", "ground-class", "ring-width"],
        ),
        Step::Found => (
            json!(detection),
            &["detector", "neighbours", "noise_factor", "normal_deviation", "minimum_area", "minimum_inliers"],
        ),
        Step::Refined => (
            json!(detection),
            &["merge_angle", "merge_tolerance", "horizontal_slope", "regularise_angle", "regularise_tolerance"],
        ),
        Step::Walls => (json!(parameters), &["footprint_tolerance", "step_height", "step_length"]),
        Step::Cells => (json!(parameters), &["partition"]),
        Step::Field => (json!({"field": field.field.name(), "cell-rule": field.cell_rule}), &["field", "cell-rule"]),
        Step::Cut => (json!(labelling), &["energy", "lambda", "volume_exponent"]),
        Step::Surface => (json!(surface), &["minimum_feature"]),
        Step::Result => (json!(parameters), &["minimum_height"]),
    };
    let named = |name: &&str| {
        let value = all.get(*name)?.clone();
        Some(Parameter { option: format!("--{}", name.replace('_', "-")), value })
    };
    names.iter().filter_map(named).collect()
}
