//! Whether gable's attributes say what the geometry is: codes 806 to 808.

use nalgebra::Vector3;
use serde_json::{Map, Value};

use super::feature::{Primitive, is_building, label};
use super::grid::Grid;
use super::report::Finding;
use crate::sink::own;
use crate::solid::{Face, Solid, SurfaceType};
use crate::source::cityjson::CityObject;
use crate::validate::semantics::Label;

/// Attributes have three decimals; heights also have the rounding of the grid.
const ROUNDING: f64 = 0.001;
/// How far a roof may rise above the highest point on it, metres.
const ABOVE_EVIDENCE: f64 = 0.5;
/// How far slopes and azimuths may be off, degrees.
const ANGLE: f64 = 0.5;

/// The faults of the attributes of a building of gable's making, whose names begin with `prefix`; those of others are not
/// looked at, whatever their names.
pub(super) fn check(primitives: &[Primitive], group: &[&CityObject], grid: &Grid, prefix: &str) -> Vec<Finding> {
    let is_ours =
        |object: &&&CityObject| is_building(object) && object.attributes.keys().any(|k| k.starts_with(prefix));
    let mut found = Vec::new();
    let Some(building) = group.iter().find(is_ours) else { return found };
    let number = |name: &str| own(&building.attributes, prefix, name).and_then(Value::as_f64);
    let coid = format!("coid={}", building.id);
    let of_lod = |lod: &str| -> Vec<&Primitive> { primitives.iter().filter(|p| p.geometry.lod == lod).collect() };
    for lod in ["1.2", "1.3", "2.2", "2.3"] {
        let solids = of_lod(lod);
        if solids.is_empty() {
            continue;
        }
        let name = format!("volume_lod{}", lod.replace('.', ""));
        let volume: f64 = shells(&solids).map(|(_, shell)| shell.volume()).sum();
        if let Some(said) = number(&name).filter(|said| (said - volume).abs() > ROUNDING + 1e-6 * volume.abs()) {
            found.push(Finding::new(
                807,
                &coid,
                format!("{prefix}{name} is {said} m³; the solids have {volume:.3} m³"),
            ));
        }
        let mut height = |name: &str, at: Option<f64>| {
            let (Some(said), Some(at)) = (number(name), at) else { return };
            if (said - at).abs() > ROUNDING {
                found.push(Finding::new(806, &coid, format!("{prefix}{name} is {said}; at LoD {lod} it is {at:.4}")));
            }
        };
        let all = || shells(&solids).flat_map(|(_, shell)| &shell.vertices).map(|v| v[2]);
        height("height_ground", all().min().map(|z| grid.height(z)));
        if lod == "2.2" {
            height("height_ridge", ridge(&solids).map(|z| grid.height(z)));
            let top = all().max().map(|z| grid.height(z));
            let metres_per_unit = grid.metres_per_unit();
            let above = |said: f64| Some((top? - said) * metres_per_unit).filter(|above| *above > ABOVE_EVIDENCE);
            if let Some(above) = number("height_roof_max").and_then(above) {
                let message = format!("the model rises {above:.3} m above {prefix}height_roof_max");
                found.push(Finding::new(806, &coid, message));
            }
        }
        found.extend(solids.iter().flat_map(|primitive| surfaces(primitive, grid)));
    }
    found
}

fn shells<'a>(primitives: &'a [&Primitive]) -> impl Iterator<Item = (&'a Primitive<'a>, &'a Solid)> {
    primitives.iter().flat_map(|p| p.solids.iter().flatten().map(move |shell| (*p, shell)))
}

/// Height of the highest edge between two roof faces, in steps.
fn ridge(primitives: &[&Primitive]) -> Option<i64> {
    let mut highest = None;
    for (primitive, shell) in shells(primitives) {
        let is_roof = |face: &&Face| label(primitive.geometry, face) == Label::Known(SurfaceType::Roof);
        let mut sides: Vec<([u32; 2], i64)> = Vec::new();
        for ring in shell.faces.iter().filter(is_roof).flat_map(|face| &face.rings) {
            for (&a, &b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
                let [low, high] = [a.min(b), a.max(b)];
                sides.push(([low, high], z(shell, low).max(z(shell, high))));
            }
        }
        sides.sort_unstable();
        let shared = sides.windows(2).filter(|pair| pair[0].0 == pair[1].0).map(|pair| pair[0].1);
        highest = highest.max(shared.max());
    }
    highest
}

fn z(shell: &Solid, vertex: u32) -> i64 {
    shell.vertices.get(vertex as usize).map_or(0, |v| v[2])
}

/// The faults of the properties of the roof surfaces of a geometry: slope, azimuth and heights.
fn surfaces(primitive: &Primitive, grid: &Grid) -> Vec<Finding> {
    let mut found = Vec::new();
    for (surface, s) in primitive.geometry.surfaces.iter().zip(0..).filter(|(surface, _)| surface.kind == "RoofSurface")
    {
        let mut twice = Vector3::zeros();
        let (mut low, mut high) = (i64::MAX, i64::MIN);
        let mut around = 0.0;
        for shell in primitive.solids.iter().flatten() {
            for ring in shell.faces.iter().filter(|face| face.surface == s).flat_map(|face| &face.rings) {
                twice += shell.newell(ring);
                for (&a, &b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
                    (low, high) = (low.min(z(shell, a)), high.max(z(shell, a)));
                    around += (shell.point(a) - shell.point(b)).norm();
                }
            }
        }
        let Some(normal) = twice.try_normalize(0.0) else { continue };
        let mut fault = |what: &str, said: f64, is: f64, tolerance: f64, code: u16| {
            if (said - is).abs() > tolerance {
                let message = format!("semantic surface {s}: {what} is {said}; that of its faces is {is:.4}");
                found.push(Finding::new(code, &primitive.id, message));
            }
        };
        let number = |members: &Map<String, Value>, name: &str| members.get(name).and_then(Value::as_f64);
        let said = |name: &str| number(&surface.attributes, name);
        for (name, is) in [("height_min", low), ("height_max", high)] {
            if let Some(said) = said(name) {
                fault(name, said, grid.height(is), ROUNDING, 806);
            }
        }
        // A narrow face turns when its vertices are rounded.
        let rounding = (grid.step.iter().fold(0.0f64, |m, s| m.max(*s)) * around / twice.norm()).to_degrees();
        let slope = normal.z.clamp(-1.0, 1.0).acos().to_degrees();
        if let Some(said) = said("slope") {
            fault("slope", said, slope, ANGLE + rounding, 808);
        }
        let tolerance = (ANGLE + rounding) / slope.to_radians().sin().max(1e-9);
        if let Some(said) = said("azimuth").filter(|_| tolerance < 90.0) {
            let azimuth = normal.x.atan2(normal.y).to_degrees();
            let off = (said - azimuth + 180.0).rem_euclid(360.0) - 180.0;
            fault("azimuth", said, said - off, tolerance, 808);
        }
    }
    found
}
