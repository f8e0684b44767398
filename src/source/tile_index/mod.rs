//! Indexes of tiles: files that say which tiles there are and where each of them lies.
//!
//! A STAC item, a collection of such, or a file of polygons with the name of a tile each, as `pdal tindex` and `gdaltindex` write
//! it. With one, only the tiles that touch what is wanted need to be opened.

mod stac;

use std::io::Read;
use std::path::{Path, PathBuf};

use geo::BoundingRect;
use serde_json::Value;

use super::crs::Crs;
use super::footprints::{self, Attributes, Footprint, FootprintOptions, Rejected};
use super::objects;
use super::open;
use crate::error::{Error, InputError, Result};

/// The extensions of files that are indexes where tiles are asked for.
const EXTENSIONS: [&str; 9] = ["json", "geojson", "gpkg", "fgb", "shp", "sqlite", "db", "parquet", "geoparquet"];
/// The attributes that may hold the name of a tile: that of `pdal tindex` and `gdaltindex`, and other usual ones.
const LOCATION: [&str; 4] = ["location", "href", "url", "filename"];
/// No index in JSON is larger, bytes.
const LARGEST: u64 = 1 << 30;

/// An index of tiles.
#[derive(Debug, Clone)]
pub struct TileIndex {
    /// The file or object, without secrets.
    pub path: PathBuf,
    /// The CRS of the extents; `None` where nobody knows it.
    pub crs: Option<Crs>,
    /// The tiles, in the order of the file.
    pub tiles: Vec<IndexedTile>,
}

/// A tile of an index.
#[derive(Debug, Clone, PartialEq)]
pub struct IndexedTile {
    /// The file or object.
    pub path: PathBuf,
    /// Smallest x and y, largest x and y of its outline; `None` where the index does not say.
    pub extent: Option<[f64; 4]>,
}

/// Whether an argument for tiles names an index of them, by its extension; a folder or a pattern is none.
pub fn is_index(path: &Path) -> bool {
    let path = objects::label(path);
    let is_pattern = path.to_string_lossy().contains(['*', '?', '[']) && !path.exists();
    EXTENSIONS.contains(&extension(&path).as_str()) && !is_pattern && !path.is_dir()
}

/// The extension of a name, in lower case.
fn extension(path: &Path) -> String {
    path.extension().map(|extension| extension.to_string_lossy().to_lowercase()).unwrap_or_default()
}

/// Reads the index at `path`. Names in it are relative to its folder.
///
/// # Errors
/// It cannot be read, is no index, or a feature of it names no tile.
pub fn read(path: &Path) -> Result<TileIndex> {
    let path = objects::label(path);
    let tiles = if ["json", "geojson"].contains(&extension(&path).as_str()) { stac_of(&path)? } else { None };
    let index = match tiles {
        Some(tiles) => TileIndex { path, crs: Some(Crs::wgs84()?), tiles },
        None => of_polygons(path)?,
    };
    if index.tiles.is_empty() {
        return Err(InputError::new(&index.path, "an index without tiles", "one with tiles").into());
    }
    Ok(index)
}

/// The tiles of a STAC file; `None` where it is something else.
fn stac_of(path: &Path) -> Result<Option<Vec<IndexedTile>>> {
    let (mut input, size) = open::regular(path, "an index of tiles")?;
    if size > LARGEST {
        let fault = InputError::new(path, format!("{size} bytes of JSON"), format!("an index of at most {LARGEST}"));
        return Err(fault.remedy("Write it as GeoPackage").into());
    }
    input.expect(std::iter::once(0..size));
    let mut bytes = Vec::new();
    input.read_to_end(&mut bytes).map_err(|e| Error::io(path, "read", e))?;
    let read: std::result::Result<Value, _> = serde_json::from_slice(&bytes);
    let value = read.map_err(|e| {
        let place = format!("line {}, column {}", e.line(), e.column());
        InputError::new(path, "something else", "JSON, as STAC and GeoJSON are").at(place).remedy(e.to_string())
    })?;
    stac::tiles(path, &value)
}

/// An index that is a file of polygons.
fn of_polygons(path: PathBuf) -> Result<TileIndex> {
    let layer = footprints::read(&path, &FootprintOptions::default())?;
    let name = LOCATION.iter().find(|name| layer.columns.iter().any(|column| column.eq_ignore_ascii_case(name)));
    let Some(name) = name else {
        let fault = InputError::new(
            &path,
            "polygons without names of tiles",
            "an index of tiles, with an attribute `location`",
        );
        let remedy = format!(
            "Make one with `pdal tindex create`. If these are footprints, give them with --footprints. {}",
            layer.attributes_like(LOCATION[0])
        );
        return Err(fault.remedy(remedy).into());
    };
    let tile = |attributes: &Attributes, id: &str, extent: Option<[f64; 4]>| match attributes.meant(name) {
        Some(Value::String(text)) if !text.is_empty() => {
            Ok(IndexedTile { path: objects::label(&objects::resolved(&text, &path)), extent })
        }
        _ => Err(InputError::new(&path, "no name of a tile", "text").at(format!("feature {id}, `{name}`"))),
    };
    let placed = layer.footprints.iter().map(|Footprint { attributes, id, polygon, .. }| {
        let rect = polygon.bounding_rect();
        tile(attributes, id, rect.map(|rect| [rect.min().x, rect.min().y, rect.max().x, rect.max().y]))
    });
    // A tile whose outline is of no use may lie anywhere.
    let others = layer.rejected.iter().map(|Rejected { attributes, id, .. }| tile(attributes, id, None));
    let tiles = placed.chain(others).collect::<Result<Vec<_>, _>>()?;
    Ok(TileIndex { crs: layer.crs, tiles, path })
}

/// The tiles that arguments name, with those of indexes in their places; see [`is_index`].
///
/// # Errors
/// As [`read`].
pub fn spread(arguments: &[String]) -> Result<Vec<String>> {
    let mut out = Vec::with_capacity(arguments.len());
    for argument in arguments {
        if is_index(Path::new(argument)) {
            let index = read(Path::new(argument))?;
            out.extend(index.tiles.into_iter().map(|tile| tile.path.to_string_lossy().into_owned()));
        } else {
            out.push(argument.clone());
        }
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn index(name: &str, text: &str) -> Result<TileIndex> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        let mut index = read(&path)?;
        for tile in &mut index.tiles {
            tile.path = tile.path.strip_prefix(folder.path()).map(Path::to_path_buf).unwrap_or(tile.path.clone());
        }
        Ok(index)
    }

    const SQUARE: &str = r#"{"type":"Polygon","coordinates":[[[4,52],[5,52],[5,53],[4,53],[4,52]]]}"#;

    #[test]
    fn names_of_a_tile_index_are_relative_to_it() {
        let feature = |location: &str| {
            format!(r#"{{"type":"Feature","properties":{{"Location":"{location}"}},"geometry":{SQUARE}}}"#)
        };
        let text =
            |features: &[String]| format!(r#"{{"type":"FeatureCollection","features":[{}]}}"#, features.join(","));
        let found = index("i.geojson", &text(&[feature("t/a.laz"), feature("s3://b/c.laz")])).unwrap();
        assert_eq!(found.tiles[0], IndexedTile { path: "t/a.laz".into(), extent: Some([4.0, 52.0, 5.0, 53.0]) });
        assert_eq!(found.tiles[1].path, Path::new("s3://b/c.laz"));
        assert!(found.crs.unwrap().is_geographic);
        let message = index("i.geojson", &text(&[feature("")])).unwrap_err().to_string();
        assert!(message.contains("no name of a tile") && message.contains("`location`"), "{message}");
        let message = index("i.geojson", &text(&[feature("a").replace("Location", "name")])).unwrap_err().to_string();
        assert!(message.contains("--footprints") && message.contains("name"), "{message}");
        assert!(index("i.json", "{").unwrap_err().to_string().contains("line 1"));
        assert!(is_index(Path::new("https://h/i.JSON?x=1.laz")) && !is_index(Path::new("a.laz")));
    }
}
