//! Names of files with places for the tile and the id of a building: `out/{tile}.city.json`, `out/{id}.obj`.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use geo::{Distance, Euclidean, InteriorPoint, Rect, coord, point};

use super::file_names;
use crate::error::{InputError, Result};
use crate::sink::Format;
use crate::source::footprints::{Footprint, Rejected};
use crate::source::objects;
use crate::source::points::Tile;

/// Where the tile of a building stands in a name.
const TILE: &str = "{tile}";
/// Where the id of a building stands in a name.
const ID: &str = "{id}";

/// The name of an output with places for what differs from file to file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Template {
    text: String,
    /// What comes before the first folder or file that differs.
    folder: PathBuf,
}

/// The files of a model that goes to several.
#[derive(Debug, Clone)]
pub(super) struct Files {
    /// The files, in the order in which they are written.
    pub(super) paths: Vec<PathBuf>,
    /// For each building, by its id, its file.
    pub(super) of_building: HashMap<String, usize>,
}

impl Template {
    /// The template that an output is; `None` for one without places.
    ///
    /// # Errors
    /// A place for something else, or an extension of no format.
    pub(super) fn of(output: &Path) -> Result<Option<Self>, InputError> {
        let Some(text) = output.to_str() else { return Ok(None) };
        let name = output.file_name().map(|name| name.to_string_lossy()).unwrap_or_default();
        if let Some(place) = unknown_place(&name) {
            let fault = InputError::new(output, format!("the place {place} in a name"), format!("{TILE} or {ID}"));
            return Err(fault.remedy("Give a name such as 'out/{tile}.city.json' or 'out/{id}.obj'"));
        }
        if !text.contains(TILE) && !text.contains(ID) {
            return Ok(None);
        }
        Format::of(output)?;
        let folder = if objects::is_object(output) {
            // The parts of a path are not those of an address: two separators follow its scheme.
            let fixed = &text[..text.find('{').unwrap_or(text.len())];
            PathBuf::from(&fixed[..fixed.rfind('/').map_or(0, |at| at + 1)])
        } else {
            output.components().take_while(|part| !part.as_os_str().to_string_lossy().contains('{')).collect()
        };
        Ok(Some(Self { text: text.to_owned(), folder }))
    }

    /// What the report and the checkpoint of the run are named after: `gable` in the last folder that all files share.
    pub(super) fn base(&self) -> PathBuf {
        self.folder.join("gable")
    }

    /// Whether a building's tile is in the name.
    pub(super) fn is_by_tile(&self) -> bool {
        self.text.contains(TILE)
    }

    /// The files for some footprints and features without a usable polygon, of which only the `wanted` ones are written.
    ///
    /// A building belongs to the tile whose extent holds a point inside its footprint: of several the first by its path, of
    /// none the nearest. What has no polygon belongs to the first tile.
    pub(super) fn files(
        &self,
        tiles: &[Tile],
        footprints: &[Footprint],
        wanted: &[bool],
        rejected: &[Rejected],
    ) -> Files {
        let extents = extents(tiles);
        let wanted = footprints.iter().zip(wanted).filter(|(_, is_wanted)| **is_wanted);
        let outlines = wanted.map(|(footprint, _)| {
            let tile = if self.is_by_tile() { tile_of(footprint, &extents) } else { 0 };
            (footprint.id.clone(), tile)
        });
        let paths: Vec<&Path> = tiles.iter().map(|tile| tile.path.as_path()).collect();
        self.arrange(
            &paths,
            &outlines.chain(rejected.iter().map(|feature| (feature.id.clone(), 0))).collect::<Vec<_>>(),
        )
    }

    /// The files for buildings of which the ids and the places of their tiles among `tiles` are known.
    pub(super) fn arrange(&self, tiles: &[&Path], buildings: &[(String, usize)]) -> Files {
        let stems: Vec<String> = tiles.iter().map(|path| stem(path)).collect();
        let names = file_names::for_ids(&stems.iter().map(String::as_str).collect::<Vec<_>>());
        let ids: Vec<&str> = buildings.iter().map(|(id, _)| id.as_str()).collect();
        let ids = if self.text.contains(ID) { file_names::for_ids(&ids) } else { Vec::new() };
        let path = |index: usize, tile: usize| {
            let text = self.text.replace(TILE, names.get(tile).map_or("tile", String::as_str));
            PathBuf::from(text.replace(ID, ids.get(index).map_or("", String::as_str)))
        };
        // One file after the other, however many there are.
        let mut order: Vec<usize> = (0..buildings.len()).collect();
        order.sort_by_key(|&index| buildings[index].1);
        let mut files = Files { paths: Vec::new(), of_building: HashMap::new() };
        for index in order {
            let (id, tile) = &buildings[index];
            let own = path(index, *tile);
            if files.paths.last() != Some(&own) {
                files.paths.push(own);
            }
            files.of_building.insert(id.clone(), files.paths.len() - 1);
        }
        files
    }
}

/// The first word in braces in a name that is no place.
fn unknown_place(name: &str) -> Option<String> {
    let words = name.split('{').skip(1).filter_map(|rest| rest.split_once('}'));
    let mut words = words.map(|(word, _)| word).filter(|word| word.chars().all(|c| c.is_ascii_alphabetic()));
    words.find(|word| !["tile", "id"].contains(word)).map(|word| format!("{{{word}}}"))
}

/// The name of a tile up to its first dot.
fn stem(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    name.split('.').find(|part| !part.is_empty()).unwrap_or("tile").to_owned()
}

/// Where tiles lie; `None` where nobody knows.
pub(super) fn extents(tiles: &[Tile]) -> Vec<Option<Rect<f64>>> {
    tiles.iter().map(rectangle).collect()
}

fn rectangle(tile: &Tile) -> Option<Rect<f64>> {
    let extent = tile.extent.or(tile.stated_extent).filter(|extent| !extent.is_empty())?;
    let ([x0, y0, _], [x1, y1, _]) = (extent.min, extent.max);
    Some(Rect::new(coord! { x: x0, y: y0 }, coord! { x: x1, y: y1 }))
}

/// The tile that a footprint belongs to, as a place among `extents`.
pub(super) fn tile_of(footprint: &Footprint, extents: &[Option<Rect<f64>>]) -> usize {
    let Some(place) = footprint.polygon.interior_point() else { return 0 };
    let distance = |rect: &Rect<f64>| {
        let nearest = point!(
            x: place.x().clamp(rect.min().x, rect.max().x),
            y: place.y().clamp(rect.min().y, rect.max().y)
        );
        Euclidean.distance(place, nearest)
    };
    let distances = extents.iter().enumerate().filter_map(|(tile, extent)| Some((tile, distance(extent.as_ref()?))));
    distances.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(tile, _)| tile)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn base(output: &str) -> PathBuf {
        Template::of(Path::new(output)).unwrap().unwrap().base()
    }

    #[test]
    fn the_report_stands_in_the_last_folder_that_all_share() {
        assert_eq!(base("out/{tile}.city.json"), Path::new("out/gable"));
        assert_eq!(base("{id}.obj"), Path::new("gable"));
        assert_eq!(base("/a/b/{tile}/x-{id}.gpkg"), Path::new("/a/b/gable"));
        assert_eq!(base("s3://a/b/{tile}.gpkg").to_str(), Some("s3://a/b/gable"));
        assert_eq!(base("s3://a/{tile}/{id}.obj").to_str(), Some("s3://a/gable"));
        assert_eq!(Template::of(Path::new("out/a.city.json")), Ok(None));
        assert_eq!(Template::of(Path::new("{a}/b.city.json")), Ok(None), "a folder may be called so");
        for bad in ["out/{tile}-{x}.city.json", "out/{ids}.city.json"] {
            let message = Template::of(Path::new(bad)).unwrap_err().to_string();
            assert!(message.contains("expected {tile} or {id}"), "{message}");
        }
        assert!(Template::of(Path::new("out/{tile}")).unwrap_err().to_string().contains(".city.json"));
    }

    #[test]
    fn a_building_belongs_to_the_tile_that_holds_it_or_the_nearest() {
        let rect = |x0: f64, x1: f64| Some(Rect::new(coord! { x: x0, y: 0.0 }, coord! { x: x1, y: 10.0 }));
        let extents = [rect(0.0, 10.0), None, rect(8.0, 20.0)];
        let at = |x: f64, y: f64| {
            let square = Rect::new(coord! { x: x - 1.0, y: y - 1.0 }, coord! { x: x + 1.0, y: y + 1.0 });
            let polygon = geo::MultiPolygon(vec![square.to_polygon()]);
            tile_of(
                &Footprint {
                    id: String::new(),
                    polygon,
                    roofprint: None,
                    attributes: crate::source::footprints::Attributes::default(),
                    notes: Vec::new(),
                },
                &extents,
            )
        };
        assert_eq!([at(5.0, 5.0), at(9.0, 5.0), at(15.0, 5.0), at(-30.0, 5.0), at(19.0, 90.0)], [0, 0, 2, 0, 2]);
    }
}
