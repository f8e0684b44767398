//! Where a GeoTIFF lies: OGC 19-008r4, section 7.4 and annex B.

use std::io::{Read, Seek};

use tiff::decoder::Decoder;
use tiff::tags::Tag;

use crate::source::crs::Crs;

/// The key that says whether a place of the raster is a corner of a pixel or its centre.
const RASTER_TYPE: u16 = 1025;
/// Its value where places are centres.
const PIXEL_IS_POINT: u16 = 2;

/// From columns and rows, from the outer corner of the first pixel, to coordinates: x = a₀ i + a₁ j + a₂, and y alike.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Placement([[f64; 3]; 2]);

impl Placement {
    /// The coordinates of a place in columns and rows.
    pub fn place(&self, pixel: [f64; 2]) -> [f64; 2] {
        self.0.map(|[i, j, shift]| i * pixel[0] + j * pixel[1] + shift)
    }

    /// Columns and rows of a place.
    pub fn pixel(&self, place: [f64; 2]) -> [f64; 2] {
        let [[a, b, x], [c, d, y]] = self.0;
        let [x, y] = [place[0] - x, place[1] - y];
        let determinant = a * d - b * c;
        [(d * x - b * y) / determinant, (a * y - c * x) / determinant]
    }
}

/// Reads it from the tags; else what was found instead.
pub(super) fn read<R: Read + Seek>(decoder: &mut Decoder<R>) -> Result<Placement, String> {
    let mut numbers = |tag| decoder.get_tag_f64_vec(tag).unwrap_or_default();
    let (matrix, scale, tie) =
        (numbers(Tag::ModelTransformationTag), numbers(Tag::ModelPixelScaleTag), numbers(Tag::ModelTiepointTag));
    let mut placement = match (matrix.as_slice(), scale.as_slice(), tie.as_slice()) {
        ([a, b, _, x, c, d, _, y, ..], ..) => [[*a, *b, *x], [*c, *d, *y]],
        (_, [sx, sy, ..], [i, j, _, x, y, ..]) => [[*sx, 0.0, x - i * sx], [0.0, -sy, y + j * sy]],
        _ => return Err("no place".to_owned()),
    };
    let [[a, b, _], [c, d, _]] = placement;
    let determinant = a * d - b * c;
    if determinant == 0.0 || !placement.iter().flatten().all(|value| value.is_finite()) {
        return Err("pixels without a size".to_owned());
    }
    let keys = decoder.get_tag_u16_vec(Tag::GeoKeyDirectoryTag).unwrap_or_default();
    let is_point = |key: &[u16; 4]| key[0] == RASTER_TYPE && key[1] == 0 && key[3] == PIXEL_IS_POINT;
    if keys.get(4..).unwrap_or_default().as_chunks::<4>().0.iter().any(is_point) {
        // The place (0, 0) is the centre of the first pixel: its corner lies half a pixel before.
        for row in &mut placement {
            row[2] -= 0.5 * (row[0] + row[1]);
        }
    }
    Ok(Placement(placement))
}

/// The CRS in the GeoTIFF keys; `None` without any.
pub(super) fn crs<R: Read + Seek>(decoder: &mut Decoder<R>) -> Result<Option<Crs>, String> {
    let directory = decoder.get_tag_u16_vec(Tag::GeoKeyDirectoryTag).unwrap_or_default();
    let doubles = decoder.get_tag_f64_vec(Tag::GeoDoubleParamsTag).unwrap_or_default();
    let ascii = decoder.get_tag_ascii_string(Tag::GeoAsciiParamsTag).unwrap_or_default();
    if directory.is_empty() { Ok(None) } else { Crs::from_geotiff_keys(&directory, &doubles, &ascii) }
}
