//! One feature: a top-level object with its children, geometry by geometry.

use std::ops::ControlFlow;

use super::Options;
use super::attributes;
use super::grid::{Grid, Shell, UNLABELLED, Weld};
use super::report::{Feature, Finding};
use super::templates::Templates;
use crate::solid::{Face, Solid, SurfaceType};
use crate::source::cityjson::{CityModel, CityObject, Geometry, GeometryKind};
use crate::validate::semantics::{self, Label};
use crate::validate::{Claim, Fault, Place, composite, relief, solid, visit};

/// A geometry on the grid.
pub(super) struct Primitive<'a> {
    pub object: &'a CityObject,
    pub geometry: &'a Geometry,
    /// `coid=…|geom=…`
    pub id: String,
    /// Its solids, each its shells; the faces of a surface are one shell.
    pub solids: Vec<Vec<Solid>>,
    pub valid: bool,
    /// Whether its solids have an inside that can be held against that of others.
    pub has_inside: bool,
}

/// Checks a top-level object with its children; the names of gable's own attributes begin with `prefix`.
pub(super) fn check(
    model: &CityModel,
    grid: &Grid,
    templates: &Templates,
    group: &[&CityObject],
    options: &Options,
    prefix: &str,
) -> Feature {
    let indices = group.iter().flat_map(|object| &object.geometries).flat_map(|geometry| &geometry.shells);
    let first = indices.flat_map(|shell| &shell.faces).flat_map(|face| &face.rings).flatten().next();
    let first = first.and_then(|&vertex| model.vertices.get(vertex as usize)).copied().unwrap_or_default();
    let grid = grid.starting_at(first);
    let (mut errors, mut semantic_errors, mut primitives) = (Vec::new(), Vec::new(), Vec::new());
    let mut instances = Vec::new();
    for object in group {
        for (geometry, g) in object.geometries.iter().zip(0..) {
            let id = format!("coid={}|geom={g}", object.id);
            if let GeometryKind::Other(kind) = &geometry.kind {
                if kind == "GeometryInstance" {
                    let checked = templates.check(geometry, options);
                    let in_place = |fault: &Finding| Finding { id: format!("{id}{}", fault.id), ..fault.clone() };
                    errors.extend(checked.faults.iter().map(in_place));
                    instances.push((checked.kind, checked.faults.is_empty()));
                }
                continue;
            }
            let before = errors.len();
            let solids =
                geometry_faults(model, &grid, (object, geometry), &id, options, [&mut errors, &mut semantic_errors]);
            if options.first_level {
                keep_first_level(&mut errors, before);
            }
            let (valid, has_inside) = (errors.len() == before, have_inside(&errors[before..], options));
            primitives.push(Primitive { object, geometry, id, solids, valid, has_inside });
        }
    }
    errors.extend(overlaps(&primitives, &grid, options));
    semantic_errors.extend(attributes::check(&primitives, group, &grid, prefix));
    let top = group.first();
    Feature {
        id: top.map_or_else(String::new, |object| object.id.clone()),
        kind: top.map_or_else(String::new, |object| object.kind.clone()),
        validity: errors.is_empty(),
        errors,
        semantic_errors,
        primitives: primitives.iter().map(|p| (name(&p.geometry.kind), p.valid)).chain(instances).collect(),
    }
}

/// Whether solids with these faults still have an inside: faces a little off their planes close it as flat ones do. Where only
/// the first level is asked for, the next one waits for a sound one, as in val3dity.
fn have_inside(faults: &[Finding], options: &Options) -> bool {
    faults.iter().all(|fault| matches!(fault.code, 203 | 204) && !options.first_level)
}

/// Of the findings from `start` on, those of the first step that val3dity would have ended with. What cannot be read (9xx)
/// belongs to none and stays.
fn keep_first_level(findings: &mut Vec<Finding>, start: usize) {
    let Some(first) = findings[start..].iter().map(|finding| step(finding.code)).min() else { return };
    let mut of_geometry = findings.split_off(start);
    of_geometry.retain(|finding| step(finding.code) == first || finding.code >= 900);
    findings.append(&mut of_geometry);
}

/// The steps in which val3dity checks, and 809 like 405: all faces by themselves, rings and polygons; the number of faces of a shell, how they
/// join, whether they hang together, whether they close, what crosses, which way they look; the shells of a solid; the
/// solids of a composite by pairs and then as a whole.
fn step(code: u16) -> u16 {
    match code {
        101..=299 => 1,
        301 => 2,
        303 | 307 => 3,
        305 => 4,
        302 => 5,
        306 => 6,
        405 | 809 => 7,
        401..=404 => 8,
        501 | 502 => 9,
        503 => 10,
        _ => 11,
    }
}

pub(super) fn name(kind: &GeometryKind) -> &'static str {
    kind.of_faces().unwrap_or("other")
}

/// Checks a geometry on all its levels and returns it on the grid; empty if that is not possible.
pub(super) fn geometry_faults(
    model: &CityModel,
    grid: &Grid,
    (object, geometry): (&CityObject, &Geometry),
    id: &str,
    options: &Options,
    [errors, semantic_errors]: [&mut Vec<Finding>; 2],
) -> Vec<Vec<Solid>> {
    let is_surface = matches!(geometry.kind, GeometryKind::MultiSurface | GeometryKind::CompositeSurface);
    let several = matches!(geometry.kind, GeometryKind::MultiSolid | GeometryKind::CompositeSolid);
    if geometry.shells.iter().all(|shell| shell.faces.is_empty()) {
        errors.push(Finding::new(902, id, "a geometry without faces"));
        return Vec::new();
    }
    let (mut sound, mut labels_count) = (true, true);
    let mut solids: Vec<Vec<Solid>> = Vec::new();
    let mut weld = Weld::new(grid.step, options.tolerances.snap);
    for of_solid in geometry.shells.chunk_by(|a, b| a.solid == b.solid) {
        let s = of_solid.first().map_or(0, |shell| shell.solid);
        let place = if several { format!("{id}|solid={s}") } else { id.to_owned() };
        let mut shells = Vec::new();
        let before = errors.len();
        for (n, shell) in of_solid.iter().enumerate() {
            let place = format!("{place}|shell={n}");
            if shell.faces.is_empty() {
                errors.push(Finding::new(902, place, "a shell without faces"));
                continue;
            }
            let shell = match grid.shell(model, &shell.faces, &mut weld) {
                Ok(shell) => shell,
                Err(reason) => {
                    errors.push(Finding::new(901, place, reason));
                    return Vec::new();
                }
            };
            let claim = match geometry.kind {
                GeometryKind::MultiSurface => Claim::Faces,
                GeometryKind::CompositeSurface => Claim::Surface,
                _ if n == 0 => Claim::Exterior,
                _ => Claim::Void,
            };
            let _ = visit(&shell.solid, claim, &options.tolerances, &mut |fault| {
                labels_count &= fault.code >= 300;
                errors.push(finding(&fault, &place, &shell.names));
                ControlFlow::Continue(())
            });
            if labels_count && is_surface && object.kind == "TINRelief" {
                for fault in relief::check(&shell.solid) {
                    let of = if relief::is_geometric(&fault) { &mut *errors } else { &mut *semantic_errors };
                    of.push(finding(&fault, &place, &shell.names));
                }
            }
            shells.push(shell);
        }
        let shells: Vec<Solid> = shells.into_iter().map(|shell: Shell| shell.solid).collect();
        if have_inside(&errors[before..], options) && shells.len() > 1 {
            let found = solid::check_voids(&shells);
            errors.extend(found.iter().map(|f| finding(&f.fault, &format!("{place}|shell={}", f.shell), &[])));
        }
        sound &= have_inside(&errors[before..], options);
        solids.push(shells);
    }
    if sound && geometry.kind == GeometryKind::CompositeSolid {
        let found = composite::check(&solids, options.overlap);
        errors.extend(found.iter().map(|f| finding(&f.fault, &format!("{id}|solid={}", f.solid), &[])));
    }
    if labels_count && !is_surface && is_building(object) {
        labels(geometry, &solids, several, id, semantic_errors);
    }
    solids
}

pub(super) fn is_building(object: &CityObject) -> bool {
    matches!(object.kind.as_str(), "Building" | "BuildingPart")
}

/// A fault of a shell with its place in the file.
fn finding(fault: &Fault, shell: &str, names: &[u32]) -> Finding {
    let name = |v: u32| names.get(v as usize).copied().unwrap_or(v);
    match fault.place {
        Place::Solid => Finding::new(fault.code, shell, fault.message.clone()),
        Place::Face(face) => Finding::new(fault.code, format!("{shell}|face={face}"), fault.message.clone()),
        Place::Ring(face, ring) => {
            Finding::new(fault.code, format!("{shell}|face={face}"), format!("ring {ring}: {}", fault.message))
        }
        Place::Edge(a, b) => {
            let (a, b) = (name(a).min(name(b)), name(a).max(name(b)));
            Finding::new(fault.code, shell, format!("edge {a}-{b}: {}", fault.message))
        }
        Place::Vertex(v) => Finding::new(fault.code, shell, format!("vertex {}: {}", name(v), fault.message)),
    }
}

/// 801 to 805 of the exterior shells of a building. Blocks (LoD 1) need no labels, but may have them.
fn labels(geometry: &Geometry, solids: &[Vec<Solid>], several: bool, id: &str, out: &mut Vec<Finding>) {
    let exteriors = || solids.iter().enumerate().filter_map(|(s, shells)| Some((s, shells.first()?)));
    if exteriors().flat_map(|(_, shell)| &shell.faces).all(|face| face.surface == UNLABELLED) {
        if !geometry.lod.starts_with(['0', '1']) {
            out.push(Finding::new(801, id, "no face has a label"));
        }
        return;
    }
    let label = |face: &Face| label(geometry, face);
    for (s, shell) in exteriors() {
        let place = if several { format!("{id}|solid={s}|shell=0") } else { format!("{id}|shell=0") };
        let found = semantics::check(shell, label).into_iter().chain(semantics::check_ground(shell, label));
        out.extend(found.map(|fault| finding(&fault, &place, &[])));
    }
}

pub(super) fn label(geometry: &Geometry, face: &Face) -> Label {
    if face.surface == UNLABELLED {
        return Label::None;
    }
    match geometry.surfaces.get(face.surface as usize).map(|surface| surface.kind.as_str()) {
        Some("RoofSurface" | "OuterFloorSurface") => Label::Known(SurfaceType::Roof),
        Some("WallSurface") => Label::Known(SurfaceType::Wall),
        Some("GroundSurface") => Label::Known(SurfaceType::Ground),
        Some("OuterCeilingSurface") => Label::Known(SurfaceType::OuterCeiling),
        _ => Label::Other,
    }
}

/// 601: solids of one level of detail that overlap though they belong to different objects of a building.
fn overlaps(primitives: &[Primitive], grid: &Grid, options: &Options) -> Vec<Finding> {
    let solid = |p: &&Primitive| p.has_inside && is_building(p.object) && p.geometry.kind == GeometryKind::Solid;
    let solids: Vec<&Primitive> = primitives.iter().filter(solid).collect();
    let mut found = Vec::new();
    for (j, later) in solids.iter().enumerate() {
        for earlier in &solids[..j] {
            if earlier.object.id == later.object.id || earlier.geometry.lod != later.geometry.lod {
                continue;
            }
            let (Some(one), Some(other)) = (earlier.solids.first(), later.solids.first()) else { continue };
            if let Some(overlap) = composite::check_parts(one, other, options.overlap) {
                let ([x, y, z], depth) = (grid.to_crs(overlap.at), overlap.depth);
                let info = format!("overlaps {} by {depth:.4} m or more, at ({x:.3}, {y:.3}, {z:.3})", earlier.id);
                found.push(Finding::new(601, &later.id, info));
            }
        }
    }
    found
}
