//! From a definition to a [`Crs`]: parsing, identification, units.

use std::rc::Rc;

use super::Crs;
use super::proj_ffi::{Context, Kind, Object};

/// Metres along the equator per radian: the semi-major axis of WGS 84.
const EQUATOR_METRES_PER_RADIAN: f64 = 6_378_137.0;
/// Confidence in per cent from which PROJ says that two systems are equivalent (proj.h, `proj_identify`).
const EQUIVALENT: i32 = 70;

/// A CRS from whatever text; the error is the reason.
pub(super) fn parse(text: &str) -> Result<Crs, String> {
    let context = Context::new()?;
    from_object(object_of(&context, text)?)
}

/// A CRS from WKT of any dialect; the error is the reason.
pub(super) fn from_wkt(wkt: &str) -> Result<Crs, String> {
    from_object(Object::from_wkt(&Context::new()?, wkt)?)
}

/// WKT1 of what WKT of any dialect says.
pub(super) fn wkt1(wkt: &str) -> Option<String> {
    Object::from_wkt(&Context::new().ok()?, wkt).ok()?.wkt1()
}

fn object_of(context: &Rc<Context>, text: &str) -> Result<Object, String> {
    let text = text.trim();
    if text.is_empty() {
        return Err("it is empty".into());
    }
    if text.bytes().all(|b| b.is_ascii_digit()) {
        return Object::parse(context, &format!("EPSG:{text}"));
    }
    if text.contains('[') && !text.starts_with('{') {
        return Object::from_wkt(context, text);
    }
    if text.starts_with('+') {
        let typed = if text.contains("+type=crs") { text.to_string() } else { format!("{text} +type=crs") };
        return Object::parse(context, &typed);
    }
    let object = Object::parse(context, text)?;
    // PROJ also finds systems by part of their name; a guess like that must not place a whole city.
    let is_name = !text.contains([':', '{']);
    if is_name && !object.name().eq_ignore_ascii_case(text) {
        return Err(format!("it is no exact name (the nearest is `{}`)", object.name()));
    }
    Ok(object)
}

/// A CRS from an object of PROJ; the error is the reason.
pub(super) fn from_object(object: Object) -> Result<Crs, String> {
    let object = identified(object);
    match object.kind() {
        Kind::Geographic2D | Kind::Geographic3D | Kind::Projected | Kind::Compound | Kind::Engineering => {}
        Kind::Bound => return Err("it is a system with an unusable shift to another datum".into()),
        Kind::Geocentric => return Err(format!("`{}` is geocentric; heights are not along z", object.name())),
        Kind::Vertical => return Err(format!("`{}` is vertical and says nothing of x and y", object.name())),
        Kind::Conversion | Kind::Other => return Err("it is no coordinate reference system".into()),
    }
    let (metres_per_unit, is_geographic) = units(&object)?;
    let name = object.name();
    let wkt = object.wkt2().ok_or_else(|| format!("`{name}` cannot be written as WKT"))?;
    Ok(Crs { wkt, code: code_of(&object), name, metres_per_unit, is_geographic })
}

/// The system of the database that this one is, where there is exactly one; else the system itself. A shift to WGS 84
/// that came with it (`TOWGS84`) is dropped where a better one follows from the database.
fn identified(object: Object) -> Object {
    let object = match (object.kind(), object.source_crs()) {
        (Kind::Bound, Some(source)) => source,
        _ => object,
    };
    if object.id().is_some() {
        return object;
    }
    if let Some(known) = best_match(&object) {
        return known;
    }
    let (Kind::Compound, Some(horizontal), Some(vertical)) = (object.kind(), object.sub_crs(0), object.sub_crs(1))
    else {
        return object;
    };
    match Object::compound(&identified(horizontal), &identified(vertical)) {
        Some(compound) => best_match(&compound).unwrap_or(compound),
        None => object,
    }
}

fn best_match(object: &Object) -> Option<Object> {
    let mut candidates = object.identify();
    let best = candidates.iter().map(|(_, confidence)| *confidence).max().filter(|&c| c >= EQUIVALENT)?;
    candidates.retain(|(candidate, confidence)| *confidence == best && candidate.id().is_some());
    // Other authorities list copies of what EPSG has.
    let epsg = candidates.iter().filter(|(c, _)| is_epsg(c)).count();
    if epsg > 0 {
        candidates.retain(|(c, _)| is_epsg(c));
    }
    let (only, _) = candidates.pop()?;
    candidates.is_empty().then_some(only)
}

fn is_epsg(object: &Object) -> bool {
    object.id().is_some_and(|(authority, _)| authority == "EPSG")
}

/// Authority and code, or those of the two parts of a compound system when both are of one authority; those of the
/// horizontal part where the vertical one has none.
fn code_of(object: &Object) -> Option<String> {
    if let Some((authority, code)) = object.id() {
        return Some(format!("{authority}:{code}"));
    }
    let (authority, horizontal) = object.sub_crs(0)?.id()?;
    match object.sub_crs(1)?.id() {
        Some((other, vertical)) if authority == other => Some(format!("{authority}:{horizontal}+{vertical}")),
        Some(_) | None => Some(format!("{authority}:{horizontal}")),
    }
}

/// The name of the vertical part of a compound system that [`code_of`] leaves out.
pub(super) fn unknown_heights(wkt: &str) -> Option<String> {
    let object = Object::from_wkt(&Context::new().ok()?, wkt).ok()?;
    if object.id().is_some() {
        return None;
    }
    let (horizontal, vertical) = (object.sub_crs(0)?.id()?, object.sub_crs(1)?);
    vertical.id().is_none_or(|vertical| vertical.0 != horizontal.0).then(|| vertical.name())
}

/// Metres per unit along x, y, z, and whether x and y are angles.
fn units(object: &Object) -> Result<([f64; 3], bool), String> {
    let part = |index| {
        let part = object.sub_crs(index)?;
        Some(if part.kind() == Kind::Bound { part.source_crs()? } else { part })
    };
    let is_compound = object.kind() == Kind::Compound;
    let horizontal = if is_compound { part(0) } else { None };
    let horizontal = horizontal.as_ref().unwrap_or(object);
    let is_geographic = matches!(horizontal.kind(), Kind::Geographic2D | Kind::Geographic3D);
    let mut axes = horizontal.axis_units();
    if is_compound {
        axes.truncate(2);
        axes.extend(part(1).and_then(|vertical| vertical.axis_units().first().copied()));
    }
    let scale = if is_geographic { EQUATOR_METRES_PER_RADIAN } else { 1.0 };
    let [x, y] = *axes.first_chunk::<2>().ok_or_else(|| format!("`{}` has fewer than two axes", object.name()))?;
    let z = axes.get(2).copied().unwrap_or(if is_geographic { 1.0 } else { x });
    let metres = [x * scale, y * scale, z];
    if metres.iter().all(|m| m.is_finite() && *m > 0.0) {
        Ok((metres, is_geographic))
    } else {
        Err(format!("the units of `{}` are unknown", object.name()))
    }
}
