//! Geometry in the binary forms of databases: WKB, EWKB, GeoPackage and SpatiaLite.

use geo::Coord;
use geozero::GeomProcessor;
use geozero::error::{GeozeroError, Result as GeozeroResult};
use geozero::wkb::{process_ewkb_geom, process_spatialite_geom, process_wkb_geom};

use super::arcs;
use super::outline::{Outline, Ring};

/// How deep collections may be nested.
const DEEPEST: usize = 16;
/// Bits of an EWKB type that say: z, m, SRID (`PostGIS`).
const EWKB_FLAGS: u32 = 0xE000_0000;

/// The polygons of a blob, whichever of the four forms it has.
pub(super) fn outline(blob: &[u8]) -> Result<Outline, String> {
    let mut polygons = Polygons::default();
    let blob = without_gpkg_header(blob)?;
    let mut bytes = blob;
    let read = match blob {
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
    let Polygons { mut outline, others, has_arcs, .. } = polygons;
    if has_arcs {
        outline.notes.push(arcs::note());
    }
    outline.beside(&others)
}

/// The WKB in a GeoPackage blob (OGC 12-128r19, section 2.1.3); any other blob as it is. The header and the WKB have an
/// order of bytes each, and they need not agree.
fn without_gpkg_header(blob: &[u8]) -> Result<&[u8], String> {
    let [b'G', b'P', _, flags, ..] = blob else { return Ok(blob) };
    // Magic, version, flags and SRID, then a box of no, two, three or four axes.
    let box_bytes = match flags >> 1 & 7 {
        0 => 0,
        1 => 32,
        2 | 3 => 48,
        4 => 64,
        _ => return Err("its geometry cannot be understood: the GeoPackage header is damaged".into()),
    };
    blob.get(8 + box_bytes..).ok_or_else(|| "its geometry cannot be understood: it is cut off".into())
}

/// Collects polygons and the names of whatever else there is. It reserves no memory on the word of a file.
#[derive(Default)]
struct Polygons {
    outline: Outline,
    others: Vec<&'static str>,
    unusable: Option<String>,
    ring: Ring,
    is_in_polygon: bool,
    /// Within a curve of several parts, which make one ring.
    is_in_compound: bool,
    /// The control points of the string of arcs that is being read.
    arc: Option<Ring>,
    has_arcs: bool,
    depth: usize,
}

impl Polygons {
    fn refuse<T>(&mut self, reason: &str) -> GeozeroResult<T> {
        self.unusable = Some(reason.to_string());
        Err(GeozeroError::Geometry(reason.to_string()))
    }

    fn begin_polygon(&mut self) {
        self.is_in_polygon = true;
        self.outline.polygons.push(Vec::new());
    }

    /// A ring begins, or a part of one.
    fn begin_ring(&mut self) {
        if !self.is_in_compound {
            self.ring.clear();
        }
    }

    /// A ring ends, or a part of one.
    fn end_ring(&mut self) {
        if self.is_in_compound {
            return;
        }
        let ring = std::mem::take(&mut self.ring);
        if let (true, Some(polygon)) = (self.is_in_polygon, self.outline.polygons.last_mut()) {
            polygon.push(ring);
        }
    }
}

impl GeomProcessor for Polygons {
    fn xy(&mut self, x: f64, y: f64, _: usize) -> GeozeroResult<()> {
        let point = Coord { x, y };
        match &mut self.arc {
            _ if !self.is_in_polygon => {}
            Some(control) => control.push(point),
            // A part begins where the one before it ends.
            None if self.is_in_compound && self.ring.last() == Some(&point) => {}
            None => self.ring.push(point),
        }
        Ok(())
    }

    fn polygon_begin(&mut self, _: bool, _: usize, _: usize) -> GeozeroResult<()> {
        self.begin_polygon();
        Ok(())
    }

    fn polygon_end(&mut self, _: bool, _: usize) -> GeozeroResult<()> {
        self.is_in_polygon = false;
        Ok(())
    }

    fn linestring_begin(&mut self, tagged: bool, _: usize, _: usize) -> GeozeroResult<()> {
        self.begin_ring();
        if tagged {
            self.others.push("LineString");
        }
        Ok(())
    }

    fn linestring_end(&mut self, _: bool, _: usize) -> GeozeroResult<()> {
        self.end_ring();
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
        self.begin_ring();
        if self.is_in_polygon {
            self.arc = Some(Ring::new());
        } else {
            self.others.push("CircularString");
        }
        Ok(())
    }

    fn circularstring_end(&mut self, _: usize) -> GeozeroResult<()> {
        if let Some(control) = self.arc.take() {
            self.has_arcs = true;
            if let Err(fault) = arcs::linearise(&control, &mut self.ring) {
                return self.refuse(&fault);
            }
        }
        self.end_ring();
        Ok(())
    }

    fn compoundcurve_begin(&mut self, _: usize, _: usize) -> GeozeroResult<()> {
        if self.is_in_polygon {
            self.begin_ring();
            self.is_in_compound = true;
        } else {
            self.others.push("CompoundCurve");
        }
        Ok(())
    }

    fn compoundcurve_end(&mut self, _: usize) -> GeozeroResult<()> {
        if self.is_in_polygon {
            self.is_in_compound = false;
            self.end_ring();
        }
        Ok(())
    }

    fn curvepolygon_begin(&mut self, _: usize, _: usize) -> GeozeroResult<()> {
        self.begin_polygon();
        Ok(())
    }

    fn curvepolygon_end(&mut self, _: usize) -> GeozeroResult<()> {
        self.is_in_polygon = false;
        Ok(())
    }

    fn multicurve_begin(&mut self, _: usize, _: usize) -> GeozeroResult<()> {
        self.others.push("MultiCurve");
        Ok(())
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
