//! Records as the content of a tile.

use nalgebra::{Point3, Vector3};
use serde_json::{Map, Value};

use super::frame::{Bounds, EarthFrame};
use super::glb::Content;
use super::record::{Level, Record};
use crate::source::crs::Geocentric;

/// The names of the properties that every feature has, before its attributes.
pub(super) const FEATURE_PROPERTIES: [&str; 4] = ["id", "type", "lod", "height"];
/// What stands before the name of an attribute that gives way to one of these.
const GIVEN_WAY: &str = "attribute_";
/// The names of the properties that every surface has, before its attributes.
pub(super) const SURFACE_PROPERTIES: [&str; 2] = ["object", "surface_type"];

/// Brings records from their CRS to the frame of the tileset.
pub(super) struct Placer<'a> {
    pub geocentric: &'a Geocentric,
    pub frame: EarthFrame,
    /// Metres per unit of heights.
    pub metres: f64,
}

/// Which level of detail a tile shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Detail {
    /// The block of LoD 1; where a feature has none, its finest level.
    Block,
    /// The finest level.
    Fine,
}

impl Placer<'_> {
    /// Replaces the vertices of records by those in the frame of the tileset. Returns how many records are dropped because
    /// some vertex of theirs has no place on earth.
    pub(super) fn place(&self, records: &mut Vec<Record>) -> usize {
        let before = records.len();
        for record in records.iter_mut() {
            self.geocentric.transform(&mut record.vertices);
            record.vertices.iter_mut().for_each(|v| *v = self.frame.to_local(*v));
        }
        records.retain(|record| record.vertices.iter().flatten().all(|c| c.is_finite()));
        before - records.len()
    }

    /// The content of a tile, and its bounds in the frame; `None` where there is no triangle.
    pub(super) fn content(&self, records: &[Record], detail: Detail) -> Option<(Content, Bounds)> {
        let levels = || {
            let shown = records.iter().map(|record| match (&record.block, detail) {
                (Some(block), Detail::Block) => (record, block),
                _ => (record, &record.fine),
            });
            shown.filter(|(_, level)| !level.patches.is_empty())
        };
        let used = levels().flat_map(|(record, level)| corners(record, level));
        let bounds = Bounds::of(used)?;
        let mut content = Content { centre: bounds.centre(), ..Content::default() };
        for (record, level) in levels() {
            let row = content.features.len();
            content.features.push(feature_row(record, level, self.metres));
            let first_surface = content.surfaces.len();
            for surface in &level.surfaces {
                content.surfaces.push(surface_row(&surface.object, &surface.class, &surface.attributes));
            }
            for patch in &level.patches {
                let Some(surface) = level.surfaces.get(patch.surface as usize) else { continue };
                let rows = [row, first_surface + patch.surface as usize];
                let (corners, triangles) = flat(record, &patch.triangles, content.centre);
                let Some(normal) = normal(&corners, &triangles) else { continue };
                let primitive = content.primitives.entry(surface.class.clone()).or_default();
                primitive.add(&corners, &triangles, normal, rows);
            }
        }
        (!content.primitives.is_empty()).then_some((content, bounds))
    }
}

/// The vertices of a level, some of them often.
fn corners<'a>(record: &'a Record, level: &'a Level) -> impl Iterator<Item = [f64; 3]> + 'a {
    let used = level.patches.iter().flat_map(|patch| &patch.triangles).flatten();
    used.filter_map(|&v| record.vertices.get(v as usize).copied())
}

/// The row of a feature without its geometry: what it is called, then its attributes.
pub(super) fn feature_row(record: &Record, level: &Level, metres: f64) -> Map<String, Value> {
    let height = (level.heights[1] - level.heights[0]) * metres;
    let height = if height.is_finite() { Value::from((height * 1e3).round() / 1e3) } else { Value::Null };
    let own = [record.id.as_str().into(), record.kind.as_str().into(), level.lod.as_str().into(), height];
    row(FEATURE_PROPERTIES.into_iter().zip(own), &record.attributes)
}

/// The row of a semantic surface.
pub(super) fn surface_row(object: &str, class: &str, attributes: &Map<String, Value>) -> Map<String, Value> {
    row(SURFACE_PROPERTIES.into_iter().zip([object.into(), class.into()]), attributes)
}

/// What every row has, then the attributes; one that has the name of the former gives way.
fn row<'a>(own: impl Iterator<Item = (&'a str, Value)>, attributes: &Map<String, Value>) -> Map<String, Value> {
    let mut row: Map<String, Value> = own.map(|(name, value)| (name.to_owned(), value)).collect();
    let taken: Vec<String> = row.keys().cloned().collect();
    for (name, value) in attributes {
        let name = if gives_way(name, &taken) { format!("{GIVEN_WAY}{name}") } else { name.clone() };
        row.insert(name, value.clone());
    }
    row
}

/// The attributes that give way to what a row has, and say something else.
pub(super) fn giving_way<'a>(
    row: &'a Map<String, Value>,
    attributes: &'a Map<String, Value>,
    taken: &'a [&str],
) -> impl Iterator<Item = String> + 'a {
    let named = attributes.iter().filter(|(name, _)| gives_way(name, taken));
    named.filter(|(name, value)| !value.is_null() && row.get(*name) != Some(value)).map(|(name, _)| name.clone())
}

/// Whether an attribute has one of these names, or one that an attribute of these names is given: so that however many give
/// way, all stay apart.
fn gives_way<S: AsRef<str>>(name: &str, taken: &[S]) -> bool {
    let bare = name.trim_start_matches(GIVEN_WAY);
    taken.iter().any(|taken| taken.as_ref() == bare)
}

/// The corners of a face from the centre of the tile, each once, and its triangles as indices of them.
fn flat(record: &Record, triangles: &[[u32; 3]], centre: [f64; 3]) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let mut used: Vec<u32> = triangles.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    let corner = |&v: &u32| -> [f64; 3] {
        let vertex = record.vertices.get(v as usize).copied().unwrap_or_default();
        std::array::from_fn(|i| vertex[i] - centre[i])
    };
    let index = |v: u32| used.binary_search(&v).unwrap_or_default() as u32;
    (used.iter().map(corner).collect(), triangles.iter().map(|triangle| triangle.map(index)).collect())
}

/// The unit normal of a face; `None` for one without area.
fn normal(corners: &[[f64; 3]], triangles: &[[u32; 3]]) -> Option<[f64; 3]> {
    let corner = |v: u32| corners.get(v as usize).copied().map_or_else(Point3::origin, Point3::from);
    let area: Vector3<f64> =
        triangles.iter().map(|&[a, b, c]| (corner(b) - corner(a)).cross(&(corner(c) - corner(a)))).sum();
    let normal = area.try_normalize(1e-9)?;
    Some([normal.x, normal.y, normal.z])
}
