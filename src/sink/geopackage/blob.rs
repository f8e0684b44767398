//! Geometries as GeoPackage holds them: a head of its own (OGC 12-128r17, clause 2.1.3), then ISO WKB.

/// ISO WKB codes.
const POLYGON: u32 = 3;
const MULTIPOLYGON: u32 = 6;
const WITH_Z: u32 = 1000;
/// Little-endian numbers, an envelope of x and y.
const FLAGS: u8 = 0b0000_0011;
/// The byte order of WKB: little-endian.
const LITTLE_ENDIAN: u8 = 1;

/// Polygons of rings of `D` coordinates, which do not repeat their first vertex.
pub(super) type Polygons<const D: usize> = Vec<Vec<Vec<[f64; D]>>>;

/// Smallest x, y and largest x, y; `None` without vertices.
pub(super) fn bounds<const D: usize>(polygons: &Polygons<D>) -> Option<[f64; 4]> {
    let vertices = polygons.iter().flatten().flatten();
    vertices.fold(None, |bounds: Option<[f64; 4]>, v| {
        let (x, y) = (v.first().copied()?, v.get(1).copied()?);
        let [x0, y0, x1, y1] = bounds.unwrap_or([x, y, x, y]);
        Some([x0.min(x), y0.min(y), x1.max(x), y1.max(y)])
    })
}

/// A multipolygon as a blob, 2D or with z.
pub(super) fn multipolygon<const D: usize>(polygons: &Polygons<D>, bounds: [f64; 4], srs: i32) -> Vec<u8> {
    let dimension = if D == 3 { WITH_Z } else { 0 };
    let mut out = b"GP\0".to_vec();
    out.push(FLAGS);
    out.extend_from_slice(&srs.to_le_bytes());
    let [x0, y0, x1, y1] = bounds;
    for bound in [x0, x1, y0, y1] {
        out.extend_from_slice(&bound.to_le_bytes());
    }
    head(MULTIPOLYGON + dimension, polygons.len(), &mut out);
    for rings in polygons {
        head(POLYGON + dimension, rings.len(), &mut out);
        for ring in rings {
            let closed = ring.iter().chain(ring.first());
            out.extend_from_slice(&(closed.clone().count() as u32).to_le_bytes());
            closed.flatten().for_each(|c| out.extend_from_slice(&c.to_le_bytes()));
        }
    }
    out
}

fn head(code: u32, count: usize, out: &mut Vec<u8>) {
    out.push(LITTLE_ENDIAN);
    out.extend_from_slice(&code.to_le_bytes());
    out.extend_from_slice(&(count as u32).to_le_bytes());
}
