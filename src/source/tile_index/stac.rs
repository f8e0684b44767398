//! STAC 1.0 and 1.1: an Item, an `ItemCollection`, or the items that a Collection or Catalog links to.

use std::path::Path;

use serde_json::Value;

use super::IndexedTile;
use crate::error::{InputError, Result};
use crate::source::objects;
use crate::source::open;

/// What is expected, for messages.
const WANTED: &str = "a STAC Item, an ItemCollection, or a Collection that links to its items";

/// The tiles of a STAC document; `None` where it is none.
///
/// # Errors
/// An item has no point cloud, or cannot be read.
pub(super) fn tiles(path: &Path, document: &Value) -> Result<Option<Vec<IndexedTile>>> {
    let kind = document["type"].as_str().unwrap_or_default();
    match kind {
        "FeatureCollection" => {
            let features = document["features"].as_array().map(Vec::as_slice).unwrap_or_default();
            if !features.iter().any(|feature| feature["assets"].is_object()) {
                return Ok(None);
            }
            if let Some(next) = link(document, "next").next() {
                let fault = InputError::new(path, "one page of several", "all items in one file").at("its link `next`");
                let remedy =
                    format!("Ask for more items at once, or fetch {} too and join them", objects::redacted(next));
                return Err(fault.remedy(remedy).into());
            }
            features.iter().map(|item| tile(path, item)).collect::<Result<_>>().map(Some)
        }
        "Feature" if document["assets"].is_object() => Ok(Some(vec![tile(path, document)?])),
        "Collection" | "Catalog" => {
            let mut found = Vec::new();
            for reference in link(document, "item") {
                let file = objects::label(&objects::resolved(reference, path));
                let bytes = open::whole(&file, "a STAC Item")?;
                let item: Value = serde_json::from_slice(&bytes)
                    .map_err(|e| InputError::new(&file, e.to_string(), "a STAC Item in JSON"))?;
                found.push(tile(&file, &item)?);
            }
            if found.is_empty() {
                let fault = InputError::new(path, format!("a {kind} without links to items"), WANTED);
                return Err(fault.remedy("Ask its server for the items, and give their ItemCollection").into());
            }
            Ok(Some(found))
        }
        _ => Ok(None),
    }
}

/// Where the links of a relation lead.
fn link<'a>(document: &'a Value, relation: &'a str) -> impl Iterator<Item = &'a str> {
    let links = document["links"].as_array().map(Vec::as_slice).unwrap_or_default();
    links.iter().filter(move |link| link["rel"] == relation).filter_map(|link| link["href"].as_str())
}

/// The tile that an item is: the best of its assets for reading parts of it.
fn tile(path: &Path, item: &Value) -> Result<IndexedTile> {
    let place = || format!("item {}", item["id"].as_str().unwrap_or("without an id"));
    let assets = item["assets"].as_object().into_iter().flatten();
    let best =
        assets.filter_map(|(_, asset)| Some((rank(asset)?, asset["href"].as_str()?))).min_by_key(|(rank, _)| *rank);
    let Some((_, reference)) = best else {
        let fault = InputError::new(path, "no asset that is a point cloud", "an asset that is COPC, LAZ or LAS");
        return Err(fault.at(place()).into());
    };
    let extent = bounds(&item["geometry"]["coordinates"]).or_else(|| bbox(&item["bbox"]));
    Ok(IndexedTile { path: objects::label(&objects::resolved(reference, path)), extent })
}

/// How good an asset is as a tile, smaller is better; `None` where it is none.
fn rank(asset: &Value) -> Option<u8> {
    let kind = asset["type"].as_str().unwrap_or_default().to_ascii_lowercase();
    let href = asset["href"].as_str()?.to_ascii_lowercase();
    let name = href.split(['?', '#']).next().unwrap_or_default();
    if kind.contains("copc") || name.ends_with(".copc.laz") {
        return Some(0);
    }
    if name.ends_with(".laz") || kind.contains("laszip") {
        return Some(1);
    }
    name.ends_with(".las").then_some(2)
}

/// The box of all positions in nested arrays.
fn bounds(coordinates: &Value) -> Option<[f64; 4]> {
    let array = coordinates.as_array()?;
    if let [x, y, ..] = array.as_slice()
        && let (Some(x), Some(y)) = (x.as_f64(), y.as_f64())
    {
        return Some([x, y, x, y]);
    }
    let boxes = array.iter().filter_map(bounds);
    boxes.reduce(|a, b| [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])])
}

/// A box of four numbers, or of six.
fn bbox(value: &Value) -> Option<[f64; 4]> {
    let numbers: Vec<f64> = value.as_array()?.iter().map(Value::as_f64).collect::<Option<_>>()?;
    match numbers.as_slice() {
        [x0, y0, x1, y1] | [x0, y0, _, x1, y1, _] => Some([*x0, *y0, *x1, *y1]),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn item(assets: Value) -> Value {
        json!({"type": "Feature", "stac_version": "1.0.0", "id": "a", "bbox": [4.0, 52.0, 0.0, 5.0, 53.0, 9.0],
            "geometry": null, "properties": {}, "assets": assets})
    }

    #[test]
    fn the_asset_that_can_be_read_in_parts_is_taken() {
        let base = Path::new("https://h.example/c/items.json");
        let best =
            item(json!({"a": {"href": "./a.laz"}, "b": {"href": "b?sig=1", "type": "application/vnd.laszip+copc"},
            "c": {"href": "c.tif"}}));
        let found = tiles(base, &json!({"type": "FeatureCollection", "features": [best]})).unwrap().unwrap();
        assert_eq!(found[0].path, Path::new("https://h.example/c/b"));
        assert_eq!(found[0].extent, Some([4.0, 52.0, 5.0, 53.0]));
        let message = tiles(base, &item(json!({"c": {"href": "c.tif"}}))).unwrap_err().to_string();
        assert!(message.contains("item a") && message.contains("COPC"), "{message}");
        let pages = json!({"type": "FeatureCollection", "features": [item(json!({"a": {"href": "a.laz"}}))],
            "links": [{"rel": "next", "href": "https://h.example/next?token=secret"}]});
        let message = tiles(base, &pages).unwrap_err().to_string();
        assert!(message.contains("one page of several") && !message.contains("secret"), "{message}");
        let plain = json!({"type": "FeatureCollection", "features": [{"type": "Feature", "properties": {}}]});
        assert_eq!(tiles(base, &plain).unwrap(), None);
    }
}
