//! Footprints: polygons with attributes, from GeoJSON, GeoPackage, SpatiaLite, Shapefile, FlatGeobuf, GeoParquet and
//! `PostGIS`.
//!
//! Every format has one file with one function of the same signature, which hands over feature after feature as it
//! stands. What follows is the same for all: the filter, the repair of rings, the choice of ids. No feature is ever
//! dropped in silence: what the filter lets through ends up either in [`FootprintLayer::footprints`] or, with the
//! reason, in [`FootprintLayer::rejected`].

mod arcs;
mod attributes;
mod dbf;
mod fetched;
mod filter;
mod flatgeobuf;
mod format;
mod geojson;
mod geoparquet;
mod ids;
mod names;
mod outline;
mod postgis;
mod reference_system;
mod rings;
mod shapefile;
mod sqlite;
mod sqlite_bounds;
mod wkb;

#[cfg(test)]
mod tests;

use std::io::Read;
use std::path::{Path, PathBuf};

use geo::{BoundingRect, MapCoordsInPlace, MultiPolygon, Rect};
use serde_json::{Map, Value};

use super::crs::{Crs, Transformer};
use super::objects;
use crate::error::{InputError, Result};
use attributes::Columns;
pub use attributes::{Attributes, attribute};
use fetched::Fetched;
use filter::Filter;
use outline::Outline;
pub(crate) use reference_system::extents_in;
pub(crate) use rings::{Rings, polygons, rings};

/// One footprint with usable geometry.
#[derive(Debug, Clone)]
pub struct Footprint {
    /// The id as text, exactly as it stands in the file; unique within the layer.
    pub id: String,
    /// Valid by the simple-feature rules, exteriors counter-clockwise, z dropped; in the coordinates of the layer's CRS.
    pub polygon: MultiPolygon<f64>,
    /// The outline of its roof, where one is known and hangs over no other footprint: valid by the simple-feature rules, in
    /// the same CRS. The footprints of a file have none.
    pub roofprint: Option<MultiPolygon<f64>>,
    /// All attributes.
    pub attributes: Attributes,
    /// What was repaired or made up, one sentence each.
    pub notes: Vec<String>,
}

impl Footprint {
    /// The value of an attribute by its name; by its name without regard to case where there is no such.
    pub fn attribute(&self, name: &str) -> Option<Value> {
        self.attributes.meant(name)
    }
}

/// A feature that has no usable geometry.
#[derive(Debug, Clone, PartialEq)]
pub struct Rejected {
    /// Its number in the file, from 0.
    pub index: usize,
    /// Its id, unique within the layer as that of a footprint.
    pub id: String,
    /// All attributes.
    pub attributes: Attributes,
    /// Why it cannot be used.
    pub reason: String,
}

/// What to read of a file.
#[derive(Debug, Clone, Default)]
pub struct FootprintOptions {
    /// The layer of a file with several; `None` takes the only one, or the only one with polygons. Of a database also
    /// `schema.table`, and `table(column)` where a table has several columns of geometry.
    pub layer: Option<String>,
    /// Of a database: the `SELECT` whose rows are the features, instead of a layer.
    pub query: Option<String>,
    /// Which features: comparisons (`= != <> < <= > >=`), `LIKE`, `ILIKE`, `IN`, `IS [NOT] NULL`, joined by `AND`, `OR`,
    /// `NOT` and parentheses; `'text'`, `"attribute"`. Where SQL says *unknown*, a feature is left out.
    pub filter: Option<String>,
    /// The attribute that holds the id; `None` guesses.
    pub id_attribute: Option<String>,
    /// The CRS of the coordinates, whatever the file says.
    pub crs: Option<Crs>,
    /// Where features are wanted: of a format that says where each of them is, the others are not read; see
    /// [`is_read_in_part`].
    pub within: Option<Within>,
}

/// Where features are wanted.
#[derive(Debug, Clone, PartialEq)]
pub struct Within {
    /// The CRS of the extent.
    pub crs: Crs,
    /// Smallest x and y, largest x and y.
    pub extent: [f64; 4],
}

/// Whether a file is of a format whose features far from [`FootprintOptions::within`] are not read: GeoParquet, of which
/// one file may hold the buildings of a continent; or a database, which may, too.
pub fn is_read_in_part(path: &Path) -> bool {
    if postgis::is_database(path) {
        return true;
    }
    let mut start = [0; 4];
    let opened = crate::source::open::regular(path, "");
    opened.is_ok_and(|(mut file, _)| file.read_exact(&mut start).is_ok()) && start == *geoparquet::MAGIC
}

/// Whether a path is no file but the address of a database: `PG:…` or `postgresql://…`.
pub fn is_database(path: &Path) -> bool {
    postgis::is_database(path)
}

/// The path as messages and reports show it: of a database without its password, of a web address without login and query.
pub fn label(path: &Path) -> PathBuf {
    objects::label(&postgis::label(path))
}

/// A text, such as an argument of a command line, with the passwords of connection strings and the logins and queries of web
/// addresses in it replaced by `***`.
pub fn redacted(text: &str) -> String {
    objects::redacted(&postgis::redacted(text))
}

/// The path that results are named after: of a database the name of the layer, or of the database.
pub fn name(path: &Path, options: &FootprintOptions) -> PathBuf {
    if postgis::is_database(path) {
        return PathBuf::from(postgis::name(path, options).unwrap_or_else(|| "footprints".to_owned()));
    }
    objects::label(path)
}

/// What is in a footprint file.
#[derive(Debug, Clone)]
pub struct FootprintLayer {
    /// The file; of a database its [`label`].
    pub path: PathBuf,
    /// The layer's name; that of the file where the format has no layers.
    pub layer: String,
    /// The CRS of the coordinates; `None` when the file does not tell, which means that of the points.
    pub crs: Option<Crs>,
    /// Features with usable geometry, in the order of the file.
    pub footprints: Vec<Footprint>,
    /// Features without, in the order of the file.
    pub rejected: Vec<Rejected>,
    /// The attribute that the ids come from; `None` when they were made up.
    pub id_attribute: Option<String>,
    /// The names of all attributes, in order; empty where no feature was read and the format has no schema.
    pub columns: Vec<String>,
    /// What concerns the file as a whole, one sentence each.
    pub warnings: Vec<String>,
    /// How many features are missing because the file is cut off, as far as the file tells.
    pub missing: u64,
    /// Whether it lacks something else that belongs to it, such as a part of a shapefile; the warnings tell.
    pub is_damaged: bool,
    /// Whether there are, or may be, features beside [`FootprintOptions::within`] that were not read.
    pub has_more: bool,
    /// The number in the file of every footprint, in the same order.
    numbers: Vec<usize>,
}

/// What a format tells of a file besides its features.
#[derive(Debug, Default)]
struct LayerInfo {
    layer: String,
    crs: Option<Crs>,
    /// The attributes, in order, as far as the format has a schema.
    columns: Vec<String>,
    /// How many features a file that is cut off has lost.
    missing: u64,
    /// Whether it lacks something else that belongs to it, which the warnings tell.
    is_damaged: bool,
    /// Whether there are, or may be, features that were not wanted and not read.
    has_more: bool,
    warnings: Vec<String>,
}

/// A feature as it stands in the file.
struct RawFeature {
    attributes: Map<String, Value>,
    /// Rings, or why there are none.
    outline: Result<Outline, String>,
}

/// A feature that the filter lets through.
struct Kept {
    /// Its number in the file.
    index: usize,
    attributes: Attributes,
    /// Its polygon and what was repaired, or why there is none.
    polygon: Result<(MultiPolygon<f64>, Vec<String>), String>,
}

/// Takes features one by one, in the order of the file.
type Sink<'a> = &'a mut dyn FnMut(RawFeature);
/// What each format has: reads a file, hands over its features.
type Reader = fn(&Path, &FootprintOptions, Sink<'_>) -> Result<LayerInfo>;

/// Reads a footprint file of any supported format, told by its content first and its name second; or a database, told by
/// `PG:` or `postgresql://` at the beginning of its name.
///
/// # Errors
/// When the file cannot be read or is no footprint file, when the layer or an attribute named in the options is not
/// there, when the filter is wrong, or when the file's CRS cannot be understood and none is given. A feature that is
/// wrong is never an error; see [`FootprintLayer::rejected`].
pub fn read(path: &Path, options: &FootprintOptions) -> Result<FootprintLayer> {
    read_until(path, options, &|| false)
}

/// The same, until `interrupted` says to stop: a database may take its time.
///
/// # Errors
/// As [`read`], or [`crate::error::Error::Interrupted`].
pub fn read_until(path: &Path, options: &FootprintOptions, interrupted: &dyn Fn() -> bool) -> Result<FootprintLayer> {
    let address = path;
    let (path, format) = if postgis::is_database(address) {
        (postgis::label(address), None)
    } else {
        let (path, format) = format::of(&objects::label(address))?;
        (path, Some(format))
    };
    refuse_query(&path, options, format.is_none())?;
    let filter = options.filter.as_deref().map(|text| Filter::parse(text, &path)).transpose()?;
    let mut columns = Columns::default();
    let mut index = 0;
    let mut kept: Vec<Kept> = Vec::new();
    let mut take = |feature: RawFeature| {
        columns.extend(feature.attributes.keys());
        if filter.as_ref().is_none_or(|filter| filter.matches(&feature.attributes)) {
            let RawFeature { attributes, outline } = feature;
            // Judged at once: a polygon takes less room than the rings that it is made of.
            let attributes = attributes.into();
            kept.push(Kept { index, attributes, polygon: outline.and_then(Outline::into_valid) });
        }
        index += 1;
    };
    let info = match &format {
        Some(format) if objects::is_object(&path) && !format.is_read_by_ranges => {
            let copy = Fetched::of(&path)?;
            (format.reader)(copy.file(), options, &mut take).map_err(|error| copy.renamed(error))?
        }
        Some(format) => (format.reader)(&path, options, &mut take)?,
        None => postgis::read(address, options, &mut take, interrupted)?,
    };
    columns.extend(&info.columns);
    if let Some(wanted) = options.layer.as_ref().filter(|_| format.is_some())
        && ![info.layer.clone(), format::stem(&path)].iter().any(|name| name.eq_ignore_ascii_case(wanted))
    {
        let fault = InputError::new(&path, format!("no layer `{wanted}`"), "a layer of the file");
        return Err(fault.remedy(names::remedy(wanted, std::iter::once(info.layer.as_str()))).into());
    }
    if let Some(filter) = filter.as_ref().filter(|_| !columns.names.is_empty()) {
        filter.check(&columns.names, &path)?;
    }
    let ids = ids::assign(kept.iter().map(|feature| &feature.attributes), &columns.names, options, &path)?;
    let mut layer = FootprintLayer {
        path,
        layer: info.layer,
        crs: options.crs.clone().or(info.crs),
        footprints: Vec::new(),
        rejected: Vec::new(),
        id_attribute: ids.attribute,
        columns: columns.names,
        warnings: info.warnings,
        missing: info.missing,
        is_damaged: info.is_damaged,
        has_more: info.has_more,
        numbers: Vec::new(),
    };
    layer.warnings.extend(ids.warnings);
    for (Kept { index, attributes, polygon }, assigned) in kept.into_iter().zip(ids.assigned) {
        match polygon {
            Ok((polygon, repairs)) => {
                let notes = assigned.note.into_iter().chain(repairs).collect();
                layer.numbers.push(index);
                layer.footprints.push(Footprint { id: assigned.id, polygon, roofprint: None, attributes, notes });
            }
            Err(reason) => layer.rejected.push(Rejected { index, id: assigned.id, attributes, reason }),
        }
    }
    if index > 0 && layer.footprints.is_empty() && layer.rejected.is_empty() {
        layer.warnings.push(format!("the filter lets none of {index} features through"));
    }
    Ok(layer)
}

/// Refuses a query where there is no database, or one beside a layer.
fn refuse_query(path: &Path, options: &FootprintOptions, is_database: bool) -> Result<()> {
    match (&options.query, &options.layer) {
        (Some(_), _) if !is_database => Err(InputError::new(path, "a query to a file", "a query to a database")
            .remedy("Files are read by --layer and --filter; a database is PG:host=… dbname=…")
            .into()),
        (Some(_), Some(_)) => Err(InputError::new(path, "both a query and a layer", "one of them")
            .remedy("Leave out --layer: the query says from which table")
            .into()),
        _ => Ok(()),
    }
}

impl FootprintLayer {
    /// The box of all footprints in the layer's CRS; `None` without any.
    pub fn extent(&self) -> Option<Rect<f64>> {
        let boxes = self.footprints.iter().filter_map(|f| f.polygon.bounding_rect());
        boxes.reduce(|a, b| {
            Rect::new(
                (a.min().x.min(b.min().x), a.min().y.min(b.min().y)),
                (a.max().x.max(b.max().x), a.max().y.max(b.max().y)),
            )
        })
    }

    /// What to say to someone who asked for an attribute that there is not: the nearest, and all of them.
    pub fn attributes_like(&self, wanted: &str) -> String {
        names::remedy(wanted, self.columns.iter().map(String::as_str))
    }

    /// Rejects the footprints that are larger than any building: one vertex gone astray would cost more memory than there
    /// is. `crs` is that of the layer, which must not be in degrees.
    pub fn reject_giants(&mut self, crs: &Crs) {
        let numbers = std::mem::take(&mut self.numbers);
        for (footprint, index) in std::mem::take(&mut self.footprints).into_iter().zip(numbers) {
            let extent = footprint.polygon.bounding_rect().map_or(0.0, |rect| {
                (rect.width() * crs.metres_per_unit[0]).max(rect.height() * crs.metres_per_unit[1])
            });
            if extent <= LARGEST_BUILDING {
                self.footprints.push(footprint);
                self.numbers.push(index);
                continue;
            }
            let reason = format!("it extends over {extent:.0} m, more than {LARGEST_BUILDING} m");
            let Footprint { id, attributes, .. } = footprint;
            self.rejected.push(Rejected { index, id, attributes, reason });
        }
        self.rejected.sort_by_key(|rejected| rejected.index);
    }

    /// Takes all footprints to another CRS, vertex by vertex; what is no longer valid afterwards is repaired or
    /// rejected. A layer of unknown CRS is taken to be in `target` already. Returns what the user must know of the
    /// accuracy.
    ///
    /// # Errors
    /// When PROJ knows no way from one to the other.
    pub fn reproject(&mut self, target: &Crs) -> Result<Vec<String>> {
        let Some(source) = self.crs.replace(target.clone()) else {
            return Ok(vec![format!(
                "{} does not say its reference system; its coordinates are taken to be in {target}: give --footprint-crs if \
                 they are not",
                self.path.display()
            )]);
        };
        let extent = self.extent().map(|r| [r.min().x, r.min().y, r.max().x, r.max().y]);
        let transformer = Transformer::new(&source, target, extent).map_err(|reason| {
            InputError::new(
                &self.path,
                format!("coordinates in {source}"),
                format!("coordinates that can be taken to {target}"),
            )
            .at(reason)
            .remedy("Give the footprints in the reference system of the points, or say with --footprint-crs which one theirs is")
        })?;
        if transformer.is_identity() {
            return Ok(Vec::new());
        }
        let numbers = std::mem::take(&mut self.numbers);
        for (mut footprint, index) in std::mem::take(&mut self.footprints).into_iter().zip(numbers) {
            footprint.polygon.map_coords_in_place(|c| {
                let mut point = [[c.x, c.y]];
                transformer.transform(&mut point);
                point[0].into()
            });
            match Outline::from(&footprint.polygon).into_valid() {
                Ok((polygon, repairs)) => {
                    footprint.polygon = polygon;
                    footprint.notes.extend(repairs);
                    self.footprints.push(footprint);
                    self.numbers.push(index);
                }
                Err(reason) => {
                    let Footprint { id, attributes, .. } = footprint;
                    let reason = format!("in {target}: {reason}");
                    self.rejected.push(Rejected { index, id, attributes, reason });
                }
            }
        }
        self.rejected.sort_by_key(|rejected| rejected.index);
        Ok(transformer.warning().map(str::to_string).into_iter().collect())
    }
}

/// The largest extent of a building in metres. What is larger has a corner in the wrong place, or is no building.
pub const LARGEST_BUILDING: f64 = 5000.0;
