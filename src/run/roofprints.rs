//! Which roof belongs to which footprint, where the outlines of roofs are mapped beside those of walls.

use std::collections::HashMap;
use std::path::Path;

use geo::{Area, BooleanOps, BoundingRect, Intersects, MultiPolygon};
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};
use serde_json::Value;

use super::job::{FootprintSource, Job};
use super::journal::Journal;
use super::layer::Outlines;
use super::tiles;
use crate::error::{InputError, Result};
use crate::report::FootprintsReport;
use crate::source::crs::Crs;
use crate::source::footprints::{Footprint, FootprintLayer, FootprintOptions};

/// A roof is that of a footprint of which it covers at least this share.
const LEAST_SHARE: f64 = 0.5;

type Tree = RTree<GeomWithData<Rectangle<[f64; 2]>, usize>>;

/// The outlines of roofs as a source: of their file everything is taken.
pub(super) fn source(path: &Path) -> FootprintSource {
    FootprintSource { path: path.to_path_buf(), options: FootprintOptions::default() }
}

/// Brings the outlines of roofs into the CRS of the tiles and gives them to their footprints, and says what was read.
///
/// # Errors
/// There are none, or they cannot be brought into the CRS.
pub(super) fn give(
    mut layer: FootprintLayer,
    outlines: &mut Outlines,
    crs: &Crs,
    job: &Job,
    journal: &Journal<'_>,
) -> Result<FootprintsReport> {
    let file = layer.path.display().to_string();
    if layer.crs.is_none() {
        layer.crs = job.footprints.as_ref().and_then(|source| source.options.crs.clone());
    }
    let own_crs = layer.crs.as_ref().map(tiles::label);
    if layer.footprints.is_empty() {
        let fault = InputError::new(&layer.path, "no polygon where the tiles are", "the outlines of roofs");
        return Err(fault.remedy("See whether they are of one place, and in which CRS they are").into());
    }
    let warnings = std::mem::take(&mut layer.warnings);
    for warning in warnings.into_iter().chain(layer.reproject(crs)?) {
        journal.warn(&format!("{file}: {warning}"));
    }
    layer.reject_giants(crs);
    if !layer.rejected.is_empty() {
        journal.warn(&format!("{file}: {} features have no usable polygon and are left out", layer.rejected.len()));
    }
    let id = outlines.report.id_attribute.as_deref();
    for warning in attach(&mut outlines.footprints, &layer.footprints, id) {
        journal.warn(&format!("{file}: {warning}"));
    }
    Ok(FootprintsReport {
        file,
        footprints: layer.footprints.len(),
        rejected: layer.rejected.len(),
        outside: 0,
        missing: layer.missing,
        is_damaged: layer.is_damaged,
        crs: own_crs,
        id_attribute: layer.id_attribute,
    })
}

/// Gives each of the `footprints` its roof among `roofs`, which are in the same CRS: the one of the same id, as the attribute
/// `id` of the roofs tells, or else the one that covers most of it. A roof ends where another footprint begins. Returns
/// what the user should know, one sentence each.
fn attach(footprints: &mut [Footprint], roofs: &[Footprint], id: Option<&str>) -> Vec<String> {
    let by_id: HashMap<String, usize> = id.map_or_else(HashMap::new, |id| {
        let named = roofs.iter().enumerate();
        named.filter_map(|(index, roof)| Some((text(&roof.attributes.get(id)?)?, index))).collect()
    });
    let over = tree(roofs);
    let roof_of = |footprint: &Footprint| {
        let named = by_id.get(&footprint.id).copied();
        named.filter(|&roof| roofs[roof].polygon.intersects(&footprint.polygon)).or_else(|| {
            let area = footprint.polygon.unsigned_area();
            let shares = touching(&over, &footprint.polygon).map(|roof| {
                let covered = roofs[roof].polygon.intersection(&footprint.polygon).unsigned_area();
                (covered / area.max(f64::MIN_POSITIVE), roof)
            });
            let best = shares.max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
            best.filter(|(share, _)| *share >= LEAST_SHARE).map(|(_, roof)| roof)
        })
    };
    let found: Vec<Option<usize>> = footprints.iter().map(roof_of).collect();
    let mut shared = vec![0_usize; roofs.len()];
    found.iter().flatten().for_each(|&roof| shared[roof] += 1);
    let beside = tree(footprints);
    let outlines: Vec<Result<MultiPolygon<f64>, String>> = footprints
        .iter()
        .zip(&found)
        .enumerate()
        .map(|(index, (footprint, roof))| match roof {
            None => Err("no roof lies over it".to_owned()),
            Some(roof) if shared[*roof] > 1 => Err(format!(
                "the roof over it lies over {} footprints, and nothing says where one ends and the next begins",
                shared[*roof]
            )),
            Some(roof) => {
                let roof = &roofs[*roof].polygon;
                let others: Vec<&MultiPolygon<f64>> = touching(&beside, roof)
                    .filter(|other| *other != index)
                    .map(|other| &footprints[other].polygon)
                    .collect();
                Ok(outline(&footprint.polygon, roof, &others))
            }
        })
        .collect();
    let without = outlines.iter().filter(|outline| outline.is_err()).count();
    for (footprint, outline) in footprints.iter_mut().zip(outlines) {
        match outline {
            Ok(outline) => footprint.roofprint = Some(outline),
            Err(reason) => footprint.notes.push(format!("it has no outline of its roof: {reason}")),
        }
    }
    let total = footprints.len();
    let told = (without > 0).then(|| {
        format!("{without} of {total} footprints have no outline of their roof, and so no LoD 2.3; their notes say why")
    });
    told.into_iter().collect()
}

/// The outline of a roof that covers its footprint and none of the others.
fn outline(own: &MultiPolygon<f64>, roof: &MultiPolygon<f64>, others: &[&MultiPolygon<f64>]) -> MultiPolygon<f64> {
    let free = others.iter().fold(roof.clone(), |roof, &other| roof.difference(other));
    let mut outline = free.union(own);
    // What another footprint has cut off is none of this roof.
    outline.0.retain(|part| part.intersects(own));
    outline
}

fn tree(of: &[Footprint]) -> Tree {
    let boxes = of.iter().enumerate().filter_map(|(index, footprint)| {
        let rect = footprint.polygon.bounding_rect()?;
        let corners = [rect.min(), rect.max()].map(|corner| [corner.x, corner.y]);
        Some(GeomWithData::new(Rectangle::from_corners(corners[0], corners[1]), index))
    });
    RTree::bulk_load(boxes.collect())
}

/// Those whose boxes touch that of a polygon, ascending.
fn touching(tree: &Tree, polygon: &MultiPolygon<f64>) -> impl Iterator<Item = usize> {
    let around = polygon
        .bounding_rect()
        .map(|rect| AABB::from_corners([rect.min().x, rect.min().y], [rect.max().x, rect.max().y]));
    let found = around.iter().flat_map(|around| tree.locate_in_envelope_intersecting(around));
    let mut found: Vec<usize> = found.map(|found| found.data).collect();
    found.sort_unstable();
    found.into_iter()
}

fn text(value: &Value) -> Option<String> {
    match value {
        Value::String(text) => Some(text.clone()),
        Value::Number(number) => Some(number.to_string()),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use geo::polygon;
    use serde_json::{Map, json};

    use super::*;

    fn block(id: &str, x: [f64; 2], y: [f64; 2], attributes: Value) -> Footprint {
        let polygon = polygon![(x: x[0], y: y[0]), (x: x[1], y: y[0]), (x: x[1], y: y[1]), (x: x[0], y: y[1])];
        let attributes = if let Value::Object(attributes) = attributes { attributes } else { Map::new() };
        let polygon = MultiPolygon(vec![polygon]);
        Footprint { id: id.to_owned(), polygon, roofprint: None, attributes: attributes.into(), notes: Vec::new() }
    }

    #[test]
    fn roofs_are_found_by_id_and_by_place_and_end_at_neighbours() {
        let mut footprints = vec![
            block("a", [0.0, 10.0], [0.0, 10.0], json!({})),
            block("b", [10.0, 20.0], [0.0, 10.0], json!({})),
            block("c", [40.0, 50.0], [0.0, 10.0], json!({})),
            block("d", [80.0, 90.0], [0.0, 10.0], json!({})),
        ];
        let roofs = [
            // Half a metre over its walls on all sides, so over the neighbour, too.
            block("1", [-0.5, 10.5], [-0.5, 10.5], json!({"house": "a"})),
            block("2", [10.0, 20.5], [-0.5, 10.5], json!({"house": 17})),
            // A third of the third: but it has its name.
            block("3", [46.7, 52.0], [0.0, 10.0], json!({"house": "c"})),
        ];
        let told = attach(&mut footprints, &roofs, Some("house"));
        let areas: Vec<Option<f64>> = footprints.iter().map(|f| Some(f.roofprint.as_ref()?.unsigned_area())).collect();
        let near = |found: Option<f64>, expected: f64| found.is_some_and(|found| (found - expected).abs() < 1e-6);
        // Of the first roof 0.5 m by 10 m lie over the second footprint.
        assert!(near(areas[0], 11.0 * 11.0 - 5.0), "{areas:?}");
        assert!(near(areas[1], 10.5 * 11.0) && near(areas[2], 120.0), "{areas:?}");
        assert_eq!(areas[3], None);
        assert!(told.len() == 1 && told[0].starts_with("1 of 4 footprints"), "{told:?}");
        assert_eq!(footprints[3].notes, ["it has no outline of its roof: no roof lies over it"]);
        // Without ids the third has too little of a roof.
        for footprint in &mut footprints {
            footprint.roofprint = None;
        }
        attach(&mut footprints, &roofs, None);
        assert!(footprints[2].roofprint.is_none() && footprints[1].roofprint.is_some());
    }

    #[test]
    fn a_roof_over_several_footprints_is_nobodys() {
        let mut footprints =
            vec![block("a", [0.0, 5.0], [0.0, 8.0], json!({})), block("b", [5.0, 10.0], [0.0, 8.0], json!({}))];
        attach(&mut footprints, &[block("1", [-1.0, 11.0], [-1.0, 9.0], json!({}))], None);
        assert!(footprints.iter().all(|f| f.roofprint.is_none() && f.notes[0].contains("over 2 footprints")));
    }
}
