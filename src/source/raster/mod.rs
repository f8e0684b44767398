//! Rasters of heights: terrain models in GeoTIFF (OGC 19-008r4).
//!
//! A raster is read by its strips or tiles, where heights are asked for, and few of them are kept: one of a country needs
//! no more memory than one of a street.

mod mosaic;
mod placement;

use std::collections::VecDeque;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use tiff::decoder::{ChunkType, Decoder, DecodingResult};
use tiff::tags::Tag;
use tiff::{TiffError, TiffFormatError};

use super::crs::Crs;
use super::open::{self, Input};
use crate::error::{Error, InputError, Result};
pub use mosaic::{Mosaic, sheets};
use placement::Placement;

/// No height of the Earth is larger, in any unit: what is there is no height.
pub const HIGHEST: f64 = 100_000.0;
/// Memory for the strips and tiles that were read last, bytes.
const MEMORY: usize = 32 << 20;
/// The tag in which GDAL keeps scale and offset.
const GDAL_METADATA: Tag = Tag::Unknown(42112);
/// What makes any raster one that can be read.
const REMEDY: &str =
    "Write it anew, for example with `gdal_translate -co TILED=YES -co COMPRESS=DEFLATE IN.tif OUT.tif`";

/// A raster of heights, open for reading.
pub struct HeightRaster {
    path: PathBuf,
    decoder: Decoder<BufReader<Input>>,
    /// The CRS that it names; `None` where it names none.
    crs: Option<Crs>,
    placement: Placement,
    /// Columns and rows.
    size: [u32; 2],
    /// Columns and rows of a strip or tile.
    chunk: [u32; 2],
    /// Numbers per pixel within a strip or tile; the first is the height.
    samples: usize,
    nodata: Option<f64>,
    /// What a number is multiplied by, and what is added then.
    scale: [f64; 2],
    recent: VecDeque<(u32, Values)>,
}

/// The numbers of a strip or tile.
struct Values {
    numbers: DecodingResult,
    columns: u32,
    rows: u32,
}

impl HeightRaster {
    /// Opens the file and reads where it lies.
    ///
    /// # Errors
    /// It cannot be opened, is no TIFF, does not say where it lies, or its CRS cannot be understood.
    pub fn open(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref().to_path_buf();
        let (file, _) = open::regular(&path, "a terrain model (GeoTIFF)")?;
        let fault = |error: &TiffError| unreadable(&path, "", error);
        let mut decoder = Decoder::new(BufReader::new(file)).map_err(|error| fault(&error))?;
        let (columns, rows) = decoder.dimensions().map_err(|error| fault(&error))?;
        let samples = decoder.find_tag_unsigned(Tag::SamplesPerPixel).map_err(|error| fault(&error))?.unwrap_or(1_u16);
        let is_planar = decoder.find_tag_unsigned(Tag::PlanarConfiguration).ok().flatten() == Some(2_u16);
        let (chunk_columns, chunk_rows) = decoder.chunk_dimensions();
        if columns == 0 || rows == 0 || chunk_columns == 0 || chunk_rows == 0 {
            return Err(
                InputError::new(&path, format!("{columns} columns and {rows} rows"), "a raster of heights").into()
            );
        }
        let placement = placement::read(&mut decoder).map_err(|found| {
            let expected = "where it lies: ModelPixelScale and ModelTiepoint, or ModelTransformation";
            InputError::new(&path, found, expected).remedy("Terrain models come as GeoTIFF; a plain TIFF has no place")
        })?;
        let crs = placement::crs(&mut decoder)
            .map_err(|reason| InputError::new(&path, reason, "a CRS in GeoTIFF keys").remedy(REMEDY))?;
        let text = |decoder: &mut Decoder<_>, tag| decoder.get_tag_ascii_string(tag).ok();
        let nodata = text(&mut decoder, Tag::GdalNodata).and_then(|text| text.trim_matches(['\0', ' ']).parse().ok());
        let metadata = text(&mut decoder, GDAL_METADATA).unwrap_or_default();
        let scale = ["scale", "offset"].map(|role| of_role(&metadata, role));
        Ok(Self {
            path,
            decoder,
            crs,
            placement,
            size: [columns, rows],
            chunk: [chunk_columns, chunk_rows],
            samples: if is_planar { 1 } else { usize::from(samples.max(1)) },
            nodata,
            scale: [scale[0].unwrap_or(1.0), scale[1].unwrap_or(0.0)],
            recent: VecDeque::new(),
        })
    }

    /// The CRS that the file names, if any.
    pub fn crs(&self) -> Option<&Crs> {
        self.crs.as_ref()
    }

    /// The rectangle that it covers, in its own CRS: min x, min y, max x, max y.
    pub fn extent(&self) -> [f64; 4] {
        let [columns, rows] = self.size.map(f64::from);
        let corners = [[0.0, 0.0], [columns, 0.0], [0.0, rows], [columns, rows]].map(|c| self.placement.place(c));
        let bound = |axis: usize, of: fn(f64, f64) -> f64| corners.iter().map(|c| c[axis]).reduce(of).unwrap_or(0.0);
        [bound(0, f64::min), bound(1, f64::min), bound(0, f64::max), bound(1, f64::max)]
    }

    /// The width of a pixel, in units of its own CRS.
    pub fn pixel_size(&self) -> f64 {
        let [a, b] = [[0.0, 0.0], [1.0, 0.0]].map(|pixel| self.placement.place(pixel));
        (b[0] - a[0]).hypot(b[1] - a[1])
    }

    /// The height at a place in its own CRS, between the four pixels around by their nearness; pixels without a height do
    /// not count. `None` outside, and where the nearest pixel has no height.
    ///
    /// # Errors
    /// A strip or tile cannot be read.
    pub fn height(&mut self, place: [f64; 2]) -> Result<Option<f64>> {
        // Columns and rows from the centre of the first pixel.
        let at: [f64; 2] = self.placement.pixel(place).map(|v| v - 0.5);
        let last = self.size.map(|size| f64::from(size - 1));
        if !(0..2).all(|axis| (-0.5..=last[axis] + 0.5).contains(&at[axis])) {
            return Ok(None);
        }
        let low = [0, 1].map(|axis| at[axis].clamp(0.0, last[axis]).floor());
        let share = [0, 1].map(|axis| at[axis].clamp(0.0, last[axis]) - low[axis]);
        let (mut sum, mut weights, mut nearest) = (0.0, 0.0, (0.0, false));
        for (step, weight) in [
            ([0.0, 0.0], (1.0 - share[0]) * (1.0 - share[1])),
            ([1.0, 0.0], share[0] * (1.0 - share[1])),
            ([0.0, 1.0], (1.0 - share[0]) * share[1]),
            ([1.0, 1.0], share[0] * share[1]),
        ] {
            if weight <= 0.0 {
                continue;
            }
            let pixel = [0, 1].map(|axis| (low[axis] + step[axis]).min(last[axis]) as u32);
            let height = self.pixel(pixel)?;
            if weight > nearest.0 {
                nearest = (weight, height.is_some());
            }
            if let Some(height) = height {
                sum += weight * height;
                weights += weight;
            }
        }
        Ok((nearest.1 && weights > 0.0).then(|| sum / weights))
    }

    /// The height of a pixel; `None` where it has none.
    fn pixel(&mut self, pixel: [u32; 2]) -> Result<Option<f64>> {
        let across = match self.decoder.get_chunk_type() {
            ChunkType::Strip => 1,
            ChunkType::Tile => self.size[0].div_ceil(self.chunk[0]),
        };
        let [column, row] = [0, 1].map(|axis| pixel[axis] / self.chunk[axis]);
        let index = row * across + column;
        let (samples, nodata, [scale, offset]) = (self.samples, self.nodata, self.scale);
        let [x, y] = [pixel[0] - column * self.chunk[0], pixel[1] - row * self.chunk[1]];
        let values = self.values(index)?;
        if x >= values.columns || y >= values.rows {
            return Ok(None);
        }
        let place = (y as usize * values.columns as usize + x as usize) * samples;
        let is_given =
            |value: &f64| value.is_finite() && nodata.is_none_or(|nodata| *value != nodata && !alike(*value, nodata));
        let height = number(&values.numbers, place).filter(is_given).map(|value| scale * value + offset);
        Ok(height.filter(|height| height.abs() <= HIGHEST))
    }

    /// The strip or tile, read or remembered.
    fn values(&mut self, index: u32) -> Result<&Values> {
        if let Some(known) = self.recent.iter().position(|(known, _)| *known == index) {
            if let Some(found) = self.recent.remove(known) {
                self.recent.push_front(found);
            }
        } else {
            let read = self.decoder.read_chunk(index);
            let numbers = read.map_err(|error| unreadable(&self.path, &format!("strip or tile {index}"), &error))?;
            let (columns, rows) = self.decoder.chunk_data_dimensions(index);
            // No number is longer than eight bytes.
            let bytes = (columns as usize * rows as usize * self.samples).saturating_mul(8).max(1);
            self.recent.truncate((MEMORY / bytes).clamp(4, 4096) - 1);
            self.recent.push_front((index, Values { numbers, columns, rows }));
        }
        match self.recent.front() {
            Some((_, values)) => Ok(values),
            None => Err(InputError::new(&self.path, "no pixel", "heights").into()),
        }
    }
}

/// GDAL writes the value of missing heights in decimals that may not be those of a 32-bit number.
fn alike(value: f64, nodata: f64) -> bool {
    (value as f32).to_bits() == (nodata as f32).to_bits()
}

/// What a TIFF reader says, as a fault of the file.
fn unreadable(path: &Path, place: &str, error: &TiffError) -> Error {
    let expected = match error {
        TiffError::FormatError(TiffFormatError::TiffSignatureNotFound | TiffFormatError::TiffSignatureInvalid) => {
            "a terrain model in GeoTIFF"
        }
        TiffError::UnsupportedError(_) => "numbers of 8 to 64 bits, uncompressed or by LZW, Deflate, ZSTD or PackBits",
        _ => "a whole and sound GeoTIFF",
    };
    InputError::new(path, error.to_string(), expected).at(place).remedy(REMEDY).into()
}

/// The number that GDAL keeps for a role of the first band.
fn of_role(metadata: &str, role: &str) -> Option<f64> {
    let (_, after) = metadata.split_once(&format!("role=\"{role}\""))?;
    let (_, text) = after.split_once('>')?;
    text.split('<').next()?.trim().parse().ok()
}

fn number(numbers: &DecodingResult, place: usize) -> Option<f64> {
    Some(match numbers {
        DecodingResult::U8(all) => f64::from(*all.get(place)?),
        DecodingResult::U16(all) => f64::from(*all.get(place)?),
        DecodingResult::U32(all) => f64::from(*all.get(place)?),
        DecodingResult::U64(all) => *all.get(place)? as f64,
        DecodingResult::I8(all) => f64::from(*all.get(place)?),
        DecodingResult::I16(all) => f64::from(*all.get(place)?),
        DecodingResult::I32(all) => f64::from(*all.get(place)?),
        DecodingResult::I64(all) => *all.get(place)? as f64,
        DecodingResult::F16(all) => all.get(place)?.to_f64(),
        DecodingResult::F32(all) => f64::from(*all.get(place)?),
        DecodingResult::F64(all) => *all.get(place)?,
    })
}

#[cfg(test)]
mod tests;
