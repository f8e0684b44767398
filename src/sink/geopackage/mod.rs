//! `GeoPackage` 1.3 (OGC 12-128r17): a table of footprints with all attributes, and one of the faces in 3D.
//!
//! | table | a row is | columns |
//! |---|---|---|
//! | `footprints` | a feature | `id`, `type`, `lod` (the finest), and every attribute in the type of its values |
//! | `faces` | a semantic surface of a geometry | `feature`, `object`, `object_type`, `lod`, `surface_type`, and every attribute of the surface |
//!
//! `fid` is the key of a table and `id` the id of the feature. An attribute of the name of such a column has none of its own where
//! it says the same in every row, as the id of the footprints does; else it is `source_…`. A list or an object among the
//! attributes is its JSON. Both tables have a spatial index and a style for QGIS.

mod blob;
mod footprint;
mod schema;
mod style;
mod table;

use std::collections::BTreeSet;
use std::path::Path;

use rusqlite::Connection;
use serde_json::Map;

use super::columns::row_of;
use super::faces::{level, surfaces};
use super::header::Metadata;
use super::output::Output;
use super::{Feature, Format, Sink, Written};
use crate::error::{Error, InputError, Result};
use blob::Polygons;
use footprint::footprint;
use table::Table;

/// Writes a `GeoPackage`; nothing of a feature stays in memory.
pub(super) struct GeoPackage {
    output: Output,
    connection: Connection,
    srs: i32,
    metres: [f64; 3],
    footprints: Table,
    faces: Table,
    classes: BTreeSet<String>,
    features: usize,
    objects: usize,
    /// Children whose attributes are in no table.
    left_out: usize,
}

/// A fault of `SQLite` while writing.
fn fault(path: &Path) -> impl Fn(rusqlite::Error) -> Error {
    move |error| Error::io(path, "write", std::io::Error::other(error))
}

impl GeoPackage {
    /// Opens a sink for `path`.
    pub(super) fn create(path: &Path, metadata: Metadata, overwrite: bool, scratch: Option<&Path>) -> Result<Self> {
        let output = Output::create(path, overwrite, scratch)?;
        let crs = metadata.crs;
        let open = || {
            let connection = Connection::open(output.temporary())?;
            let srs = schema::create(&connection, crs.as_ref())?;
            let footprints = Table::create(&connection, "footprints", &["id", "type", "lod"])?;
            let fixed = &["feature", "object", "object_type", "lod", "surface_type"];
            let faces = Table::create(&connection, "faces", fixed)?;
            Ok((connection, srs, footprints, faces))
        };
        let (connection, srs, footprints, faces) = open().map_err(fault(path))?;
        Ok(Self {
            output,
            connection,
            srs,
            metres: crs.map_or([1.0; 3], |crs| crs.metres_per_unit),
            footprints,
            faces,
            classes: BTreeSet::new(),
            features: 0,
            objects: 0,
            left_out: 0,
        })
    }

    /// The rows of a feature. `Ok(false)` when a table would have too many columns.
    fn insert(&mut self, feature: &Feature) -> rusqlite::Result<bool> {
        let (attributes, left_out) = row_of(feature);
        self.left_out += left_out;
        let geometries = feature.objects.iter().flat_map(|object| &object.geometries);
        let lods = geometries.filter(|g| !g.shells.is_empty()).map(|geometry| geometry.lod.as_str());
        let lod = lods.max_by(|a, b| level(a).total_cmp(&level(b))).unwrap_or_default();
        let kind = feature.root().map(|root| root.kind.as_str()).unwrap_or_default();
        let polygons = footprint(feature, self.metres);
        let fixed = [feature.id.as_str(), kind, lod];
        if !self.footprints.insert(&self.connection, &fixed, &attributes, &polygons, self.srs)? {
            return Ok(false);
        }
        let none = Map::new();
        for object in &feature.objects {
            for geometry in &object.geometries {
                for surface in surfaces(feature, object, geometry, self.metres) {
                    let ring = |ring: &Vec<u32>| ring.iter().map(|&v| feature.vertex(v)).collect();
                    let polygons: Polygons<3> =
                        surface.faces.iter().map(|face| face.rings.iter().map(ring).collect()).collect();
                    let fixed = [feature.id.as_str(), &object.id, &object.kind, surface.lod, surface.class];
                    let attributes = surface.attributes.unwrap_or(&none);
                    if !self.faces.insert(&self.connection, &fixed, attributes, &polygons, self.srs)? {
                        return Ok(false);
                    }
                    if !self.classes.contains(surface.class) {
                        self.classes.insert(surface.class.to_owned());
                    }
                }
            }
        }
        Ok(true)
    }

    /// What is known only at the end: types, bounds, styles.
    fn close(&mut self) -> rusqlite::Result<()> {
        let tables = [
            ("footprints", "footprints with all attributes", false, &mut self.footprints),
            ("faces", "faces in 3D, a row per semantic surface", true, &mut self.faces),
        ];
        for (name, description, has_z, table) in tables {
            table.finish(&self.connection)?;
            schema::register(&self.connection, name, description, has_z, self.srs, table.bounds())?;
            schema::index_triggers(&self.connection, name)?;
        }
        schema::style(&self.connection, "footprints", &style::footprints())?;
        schema::style(&self.connection, "faces", &style::faces(self.classes.iter()))?;
        schema::register_styles(&self.connection)?;
        self.connection.execute_batch("COMMIT")
    }
}

impl Sink for GeoPackage {
    fn write(&mut self, feature: &Feature) -> Result<()> {
        let has_room = self.insert(feature).map_err(fault(self.output.path()))?;
        if !has_room {
            return Err(InputError::new(self.output.path(), "more than 1 980 different attributes", "fewer")
                .at(format!("feature {:?}", feature.id))
                .remedy("A table cannot have more columns; write another format, or fewer attributes.")
                .into());
        }
        self.features += 1;
        self.objects += feature.objects.len();
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> Result<Written> {
        let path = self.output.path().to_path_buf();
        self.close().map_err(fault(&path))?;
        let renamed = [self.footprints.renamed(), self.faces.renamed()];
        let Self { output, connection, features, objects, left_out, .. } = *self;
        connection.close().map_err(|(_, error)| fault(&path)(error))?;
        let bytes = output.commit(&[])?;
        let left_out = (left_out > 0)
            .then(|| format!("the attributes of {left_out} children have no column of their own and are not written"));
        let notes = left_out.into_iter().chain(renamed.into_iter().flatten()).collect();
        Ok(Written { path, format: Some(Format::GeoPackage), features, objects, bytes, notes })
    }
}
