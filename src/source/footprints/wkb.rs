//! Geometry in the binary forms of databases: WKB, EWKB, GeoPackage and SpatiaLite.

use geo::Coord;
use geozero::GeomProcessor;
use geozero::error::{GeozeroError, Result as GeozeroResult};
use geozero::wkb::{process_ewkb_geom, process_gpkg_geom, process_spatialite_geom, process_wkb_geom};

use super::outline::{Outline, Ring};

/// How deep collections may be nested.
const DEEPEST: usize = 16;
/// Bits of an EWKB type that say: z, m, SRID (`PostGIS`).
const EWKB_FLAGS: u32 = 0xE000_0000;

/// The polygons of a blob, whichever of the four forms it has.
pub(super) fn outline(blob: &[u8]) -> Result<Outline, String> {
    let mut polygons = Polygons::default();
    let mut bytes = blob;
    let read = match blob {
        [b'G', b'P', ..] => process_gpkg_geom(&mut bytes, &mut polygons),
        // SpatiaLite: start 0x00, byte 38 ends the bounds, the last byte ends the whole.
        [0x00, ..] if blob.get(38) == Some(&0x7C) && blob.last() == Some(&0xFE) => {
            process_spatialite_geom(&mut bytes, &mut polygons)
        }
        [0x00 | 0x01, a, b, c, d, ..] => {
            let kind = [*a, *b, *c, *d];
            let kind = if blob[0] == 0 { u32::from_be_bytes(kind) } else { u32::from_le_bytes(kind) };
            if kind & EWKB_FLAGS == 0 {
                process_wkb_geom(&mut bytes, &mut polygons)
            } else {
                process_ewkb_geom(&mut bytes, &mut polygons)
            }
        }
        _ => return Err("its geometry is neither WKB nor a GeoPackage or SpatiaLite blob".into()),
    };
    if let Some(unusable) = polygons.unusable {
        return Err(unusable);
    }
    read.map_err(|error| format!("its geometry cannot be understood: {error}"))?;
    let Polygons { outline, others, .. } = polygons;
    outline.beside(&others)
}

/// Collects polygons and the names of whatever else there is. It reserves no memory on the word of a file.
#[derive(Default)]
struct Polygons {
    outline: Outline,
    others: Vec<&'static str>,
    unusable: Option<String>,
    ring: Ring,
    is_in_polygon: bool,
    depth: usize,
}

impl Polygons {
    fn refuse<T>(&mut self, reason: &str) -> GeozeroResult<T> {
        self.unusable = Some(reason.to_string());
        Err(GeozeroError::Geometry(reason.to_string()))
    }

    fn curves<T>(&mut self) -> GeozeroResult<T> {
        self.refuse("its geometry has curved edges")
    }
}

impl GeomProcessor for Polygons {
    fn xy(&mut self, x: f64, y: f64, _: usize) -> GeozeroResult<()> {
        if self.is_in_polygon {
            self.ring.push(Coord { x, y });
        }
        Ok(())
    }

    fn polygon_begin(&mut self, _: bool, _: usize, _: usize) -> GeozeroResult<()> {
        self.is_in_polygon = true;
        self.outline.polygons.push(Vec::new());
        Ok(())
    }

    fn polygon_end(&mut self, _: bool, _: usize) -> GeozeroResult<()> {
        self.is_in_polygon = false;
        Ok(())
    }

    fn linestring_begin(&mut self, tagged: bool, _: usize, _: usize) -> GeozeroResult<()> {
        self.ring.clear();
        if tagged {
            self.others.push("LineString");
        }
        Ok(())
    }

    fn linestring_end(&mut self, _: bool, _: usize) -> GeozeroResult<()> {
        let ring = std::mem::take(&mut self.ring);
        if let (true, Some(polygon)) = (self.is_in_polygon, self.outline.polygons.last_mut()) {
            polygon.push(ring);
        }
        Ok(())
    }

    fn geometrycollection_begin(&mut self, _: usize, _: usize) -> GeozeroResult<()> {
        self.depth += 1;
        if self.depth > DEEPEST { self.refuse("its collections are nested too deep") } else { Ok(()) }
    }

    fn geometrycollection_end(&mut self, _: usize) -> GeozeroResult<()> {
        self.depth -= 1;
        Ok(())
    }

    fn point_begin(&mut self, _: usize) -> GeozeroResult<()> {
        self.others.push("Point");
        Ok(())
    }

    fn empty_point(&mut self, _: usize) -> GeozeroResult<()> {
        self.others.push("Point");
        Ok(())
    }

    fn multipoint_begin(&mut self, _: usize, _: usize) -> GeozeroResult<()> {
        self.others.push("MultiPoint");
        Ok(())
    }

    fn multilinestring_begin(&mut self, _: usize, _: usize) -> GeozeroResult<()> {
        self.others.push("MultiLineString");
        Ok(())
    }

    fn circularstring_begin(&mut self, _: usize, _: usize) -> GeozeroResult<()> {
        self.curves()
    }

    fn compoundcurve_begin(&mut self, _: usize, _: usize) -> GeozeroResult<()> {
        self.curves()
    }

    fn curvepolygon_begin(&mut self, _: usize, _: usize) -> GeozeroResult<()> {
        self.curves()
    }

    fn multicurve_begin(&mut self, _: usize, _: usize) -> GeozeroResult<()> {
        self.curves()
    }

    fn triangle_begin(&mut self, _: bool, _: usize, _: usize) -> GeozeroResult<()> {
        self.refuse("its geometry is a surface in space, not a polygon in the plane")
    }

    fn polyhedralsurface_begin(&mut self, _: usize, _: usize) -> GeozeroResult<()> {
        self.refuse("its geometry is a surface in space, not a polygon in the plane")
    }

    fn tin_begin(&mut self, _: usize, _: usize) -> GeozeroResult<()> {
        self.refuse("its geometry is a surface in space, not a polygon in the plane")
    }
}
