//! Floors that the user states: by an attribute of the footprints, or by a terrain model.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use geo::BoundingRect;
use serde_json::Value;

use super::around::{Level, height_of};
use super::{Found, outline};
use crate::error::{InputError, Result};
use crate::segment::neighbourhood::{Neighbourhood, frame_of};
use crate::segment::options::{GroundLevel, SegmentOptions};
use crate::site::{Ground, GroundSource};
use crate::source::crs::Crs;
use crate::source::footprints::Footprint;
use crate::source::raster::{HIGHEST, Mosaic};

/// Side of the squares in whose order the terrain model is asked, metres: it is read in pieces, of which few are kept.
const SQUARE: f64 = 500.0;
/// Attributes that an error names at most.
const MOST_NAMES: usize = 20;

/// What the user states of the floors.
#[derive(Debug, Clone, Default)]
pub(in crate::segment) struct Stated {
    /// Floors that attributes give, local metres, by the footprint.
    attributes: BTreeMap<usize, f64>,
    /// The terrain along the outline, local metres, by the footprint.
    terrain: BTreeMap<usize, Vec<[f64; 3]>>,
    /// The terrain in the middle of the footprint.
    middles: BTreeMap<usize, f64>,
    /// What is to be told of single footprints.
    pub notes: BTreeMap<usize, String>,
    /// What is to be told of all.
    pub warnings: Vec<String>,
}

impl Stated {
    /// The ground of footprint `index`: what is stated, else what the ground points tell.
    pub(in crate::segment) fn of(&self, index: usize, seen: Option<&Level>, options: &SegmentOptions) -> Option<Found> {
        let (spread, line) = seen.map_or((0.0, &[][..]), |level| (level.spread, level.line.as_slice()));
        let terrain = self.terrain.get(&index);
        let line = terrain.map_or(line, Vec::as_slice);
        let ground = |height, source| Some((Ground { height, spread, source }, line.to_vec()));
        if let Some(height) = self.attributes.get(&index) {
            return ground(*height, GroundSource::Attribute);
        }
        if let Some(terrain) = terrain {
            let middle = self.middles.get(&index).filter(|_| options.ground == GroundLevel::Plane);
            return ground(middle.copied().unwrap_or_else(|| height_of(terrain, options)), GroundSource::TerrainModel);
        }
        ground(seen?.height, GroundSource::GroundPoints)
    }
}

/// What an attribute of `footprints` that `options` name says of their floors.
///
/// # Errors
/// No footprint has the attribute, unless these are a share of a run.
pub(in crate::segment) fn read_attributes(
    footprints: &[Footprint],
    crs: &Crs,
    options: &SegmentOptions,
    is_share: bool,
) -> Result<Stated> {
    let mut stated = Stated::default();
    if let Some(name) = &options.ground_attribute {
        if !is_share {
            refuse_unknown(name, footprints)?;
        }
        by_attribute(name, footprints, crs, &mut stated);
    }
    Ok(stated)
}

/// What the terrain model that `options` name says of the floors of those footprints that are `wanted` and of which nothing is stated yet.
///
/// # Errors
/// The terrain model cannot be read or has no height for any footprint, unless these are a share of a run.
pub(in crate::segment) fn read_terrain(
    all: &Neighbourhood,
    crs: &Crs,
    wanted: impl Fn(usize) -> bool,
    options: &SegmentOptions,
    is_share: bool,
    stated: &mut Stated,
) -> Result<()> {
    let Some(path) = &options.dtm else { return Ok(()) };
    match by_terrain(path, all, crs, wanted, stated)? {
        Some(fault) if !is_share => Err(fault.into()),
        _ => Ok(()),
    }
}

/// Refuses an attribute of floors that no footprint has.
///
/// # Errors
/// The attributes that there are.
pub(in crate::segment) fn refuse_unknown(name: &str, footprints: &[Footprint]) -> Result<()> {
    if !footprints.iter().any(|footprint| footprint.attributes.get(name).is_some()) {
        let names: BTreeSet<String> = footprints
            .iter()
            .flat_map(|footprint| footprint.attributes.to_map().into_iter().map(|(name, _)| name))
            .collect();
        let mut names: Vec<String> = names.into_iter().collect();
        let more = if names.len() > MOST_NAMES { ", …" } else { "" };
        names.truncate(MOST_NAMES);
        let expected = match names.as_slice() {
            [] => "an attribute with the heights of their floors".to_owned(),
            names => format!("one of {}{more}", names.join(", ")),
        };
        let fault = InputError::new("footprints", format!("no attribute {name:?}"), expected);
        return Err(fault.remedy("Name another one with --ground-attribute, or leave it out").into());
    }
    Ok(())
}

fn by_attribute(name: &str, footprints: &[Footprint], crs: &Crs, stated: &mut Stated) {
    for (index, footprint) in footprints.iter().enumerate() {
        let value = footprint.attributes.get(name);
        if let Some(height) = value.as_ref().and_then(number) {
            let frame = frame_of(&footprint.polygon, crs.metres_per_unit);
            stated.attributes.insert(index, (height - frame.origin[2]) * frame.metres_per_unit[2]);
        } else {
            let found =
                value.as_ref().map_or_else(|| "is not there".to_owned(), |value| format!("is {value}, no height"));
            stated.notes.insert(index, format!("the attribute {name:?} {found}: its floor comes from elsewhere"));
        }
    }
    if !stated.notes.is_empty() {
        let (without, total) = (stated.notes.len(), footprints.len());
        stated.warnings.push(format!(
            "{without} of {total} footprints have no number in {name:?} (--ground-attribute): their floors come from elsewhere"
        ));
    }
}

/// A number that may be a height, or a text that is one.
pub(in crate::segment) fn number(value: &Value) -> Option<f64> {
    let number = match value {
        Value::Number(number) => number.as_f64(),
        Value::String(text) => text.trim().parse().ok(),
        _ => None,
    };
    number.filter(|number: &f64| number.abs() <= HIGHEST)
}

/// Asks the terrain model; what is to be said where it has no height at all.
fn by_terrain(
    path: &Path,
    all: &Neighbourhood,
    crs: &Crs,
    wanted: impl Fn(usize) -> bool,
    stated: &mut Stated,
) -> Result<Option<InputError>> {
    let mut order: Vec<(usize, [f64; 2], [i64; 2])> = all
        .boxes
        .iter()
        .filter(|(index, _)| wanted(*index) && !stated.attributes.contains_key(index))
        .map(|(index, (low, _))| {
            let square = [1, 0].map(|axis| (low[axis] * crs.metres_per_unit[axis] / SQUARE).floor() as i64);
            (index, low, square)
        })
        .collect();
    order.sort_by_key(|(index, _, square)| (*square, *index));
    let bounds = order.iter().fold([f64::MAX, f64::MAX, f64::MIN, f64::MIN], |[x0, y0, x1, y1], (_, [x, y], _)| {
        [x0.min(*x), y0.min(*y), x1.max(*x), y1.max(*y)]
    });
    if order.is_empty() {
        return Ok(None);
    }
    let mut terrain = Mosaic::open(path, crs, bounds)?;
    stated.warnings.extend_from_slice(terrain.warnings());
    let mut without = 0;
    for (index, ..) in &order {
        let place = all.place(*index);
        let (frame, polygon) = (&place.frame, &place.polygon);
        let centre = polygon.bounding_rect().map(|rect| [rect.center().x, rect.center().y]);
        let mut places = outline::places(polygon);
        places.extend(centre);
        let to_crs = |axis: usize, local: f64| frame.origin[axis] + local / frame.metres_per_unit[axis];
        let there: Vec<[f64; 2]> = places.iter().map(|p| [to_crs(0, p[0]), to_crs(1, p[1])]).collect();
        let mut line = Vec::with_capacity(places.len());
        for (place, height) in places.iter().zip(terrain.heights(&there)?) {
            if let Some(height) = height {
                line.push([place[0], place[1], (height - frame.origin[2]) * frame.metres_per_unit[2]]);
            }
        }
        if line.last().map(|p| [p[0], p[1]]) == centre
            && let Some(middle) = line.pop()
        {
            stated.middles.insert(*index, middle[2]);
        }
        if line.is_empty() {
            without += 1;
        } else {
            stated.terrain.insert(*index, line);
        }
    }
    let total = order.len();
    if without > 0 {
        stated.warnings.push(format!(
            "{}: it has no height at {without} of {total} footprints; their floors come from elsewhere",
            path.display()
        ));
    }
    if without < total {
        return Ok(None);
    }
    let found = format!("no height at any of {total} footprints: it covers {}", terrain.covers());
    let fault = InputError::new(path, found, "a terrain model that covers the footprints");
    Ok(Some(fault.remedy("Check its CRS, or leave --dtm out")))
}
