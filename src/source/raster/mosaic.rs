//! Rasters of heights side by side: the sheets of a terrain model.

use std::path::{Path, PathBuf};

use super::HeightRaster;
use crate::error::{InputError, Result};
use crate::source::crs::{Crs, Transformer};
use crate::source::expand::{self, Kind};

/// Sheets that are open at the same time, at most: where four meet, all are.
const OPEN: usize = 4;

/// The kind of file that a sheet is.
const SHEETS: Kind = Kind {
    name: "terrain model",
    wanted: "a GeoTIFF, a folder of such or a glob pattern",
    extensions: &["tif", "tiff"],
    meant: &[],
};

/// The GeoTIFF files that an argument names: one, those directly in a folder, or those that match a glob pattern.
///
/// # Errors
/// There is none.
pub fn sheets(argument: &Path) -> Result<Vec<PathBuf>> {
    expand::expand(&[argument.to_string_lossy().into_owned()], &SHEETS)
}

/// Sheets of a terrain model, asked in the coordinates of another CRS.
pub struct Mosaic {
    /// Finer ones first, then by name.
    sheets: Vec<Sheet>,
    /// The ways to the systems of the sheets, each once.
    ways: Vec<(Crs, Transformer)>,
    /// Sheets that are open, the last one used first.
    open: Vec<(usize, HeightRaster)>,
    warnings: Vec<String>,
}

struct Sheet {
    path: PathBuf,
    /// In its own CRS: min x, min y, max x, max y.
    extent: [f64; 4],
    pixel: f64,
    way: usize,
}

impl Mosaic {
    /// Reads where the sheets that `argument` names lie; places are asked in `crs`, within `bounds` (min x, min y, max x,
    /// max y).
    ///
    /// # Errors
    /// There is no sheet, one is no GeoTIFF, or there is no way from the CRS to that of a sheet.
    pub fn open(argument: &Path, crs: &Crs, bounds: [f64; 4]) -> Result<Self> {
        let mut mosaic = Self { sheets: Vec::new(), ways: Vec::new(), open: Vec::new(), warnings: Vec::new() };
        let mut without_crs = Vec::new();
        for path in sheets(argument)? {
            let raster = HeightRaster::open(&path)?;
            if raster.crs().is_none() {
                without_crs.push(path.clone());
            }
            let own = raster.crs().unwrap_or(crs);
            let known = mosaic.ways.iter().position(|(known, _)| known == own);
            let way = if let Some(way) = known {
                way
            } else {
                let transformer = Transformer::new(crs, own, Some(bounds)).map_err(|reason| {
                    let expected = "a terrain model in a CRS to which there is a way from that of the points";
                    InputError::new(&path, reason, expected)
                })?;
                let warning = transformer.warning().map(|warning| format!("{}: {warning}", path.display()));
                mosaic.warnings.extend(warning);
                mosaic.ways.push((own.clone(), transformer));
                mosaic.ways.len() - 1
            };
            let (extent, pixel) = (raster.extent(), raster.pixel_size());
            mosaic.sheets.push(Sheet { path, extent, pixel, way });
        }
        mosaic.sheets.sort_by(|a, b| a.pixel.total_cmp(&b.pixel).then_with(|| a.path.cmp(&b.path)));
        if let Some(first) = without_crs.first() {
            let others =
                if without_crs.len() > 1 { format!(" (and {} others)", without_crs.len() - 1) } else { String::new() };
            let warning =
                format!("{}{others}: it names no CRS and is taken to be in that of the points", first.display());
            mosaic.warnings.push(warning);
        }
        Ok(mosaic)
    }

    /// What the user must know of it.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// What the first sheets cover, in words.
    pub fn covers(&self) -> String {
        /// Sheets that are named.
        const MOST: usize = 3;
        let told = self.sheets.iter().take(MOST).map(|sheet| {
            let [x0, y0, x1, y1] = sheet.extent;
            let own = self.ways.get(sheet.way).map(|(own, _)| format!(" in {own}")).unwrap_or_default();
            format!("x {x0:.2} to {x1:.2}, y {y0:.2} to {y1:.2}{own}")
        });
        let more =
            if self.sheets.len() > MOST { format!("; and {} others", self.sheets.len() - MOST) } else { String::new() };
        told.collect::<Vec<_>>().join("; ") + &more
    }

    /// The height at each of these places; of sheets over each other the finest that has one. `None` where none has.
    ///
    /// # Errors
    /// A sheet cannot be read.
    pub fn heights(&mut self, places: &[[f64; 2]]) -> Result<Vec<Option<f64>>> {
        let there: Vec<Vec<[f64; 2]>> = self
            .ways
            .iter()
            .map(|(_, way)| {
                let mut there = places.to_vec();
                way.transform(&mut there);
                there
            })
            .collect();
        let mut heights = vec![None; places.len()];
        for sheet in 0..self.sheets.len() {
            let Sheet { extent: [x0, y0, x1, y1], way, .. } = self.sheets[sheet];
            for (height, [x, y]) in heights.iter_mut().zip(&there[way]) {
                if height.is_none() && (x0..=x1).contains(x) && (y0..=y1).contains(y) {
                    *height = self.raster(sheet)?.height([*x, *y])?;
                }
            }
        }
        Ok(heights)
    }

    /// A sheet, open.
    fn raster(&mut self, sheet: usize) -> Result<&mut HeightRaster> {
        let found = match self.open.iter().position(|(open, _)| *open == sheet) {
            Some(known) => self.open.remove(known),
            None => (sheet, HeightRaster::open(&self.sheets[sheet].path)?),
        };
        self.open.truncate(OPEN - 1);
        self.open.insert(0, found);
        Ok(&mut self.open[0].1)
    }
}
