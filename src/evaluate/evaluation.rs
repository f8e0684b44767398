//! The evaluation of a city model as data: what the table prints and the JSON file holds.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Bound;

use rayon::prelude::*;
use serde::Serialize;

use super::agreement::Agreement;
use super::completeness::BuildingCompleteness;
use super::faces::{FaceCount, count_faces};
use super::hausdorff::{SurfaceDistance, surface_distance};
use super::overlap::{Overlap, overlap};
use super::shape::Shape;
use super::summary::median;
use crate::completeness;
use crate::geometry::seed_of;

/// Sample points per surface for the distances between surfaces.
const SAMPLES: usize = 20_000;
/// Vertical rays per pair of buildings for the overlap of volumes.
const RAYS: usize = 40_000;

/// How good a city model is.
#[derive(Debug, Clone, Serialize)]
pub struct Evaluation {
    /// Over all buildings.
    pub overall: Overall,
    /// Building by building, in the order of the model.
    pub buildings: Vec<BuildingEvaluation>,
}

/// How good one building is.
#[derive(Debug, Clone, Serialize)]
pub struct BuildingEvaluation {
    /// Its id.
    pub id: String,
    /// Number of faces, solid by solid.
    pub solids: Vec<FaceCount>,
    /// Faults of its solids; absent when validity was not checked.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub faults: Option<Vec<String>>,
    /// How well the points agree with it; absent when no points were given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub points: Option<Agreement>,
    /// What was scanned and is not in it, and what is in it and was not scanned; absent without points or geometry.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub completeness: Option<BuildingCompleteness>,
    /// How well it agrees with the building of the same id in the reference; absent when there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference: Option<ReferenceAgreement>,
}

/// How well a building agrees with a reference.
#[derive(Debug, Clone, Serialize)]
pub struct ReferenceAgreement {
    /// Id in the reference.
    pub id: String,
    /// Distances between the surfaces.
    pub surfaces: Option<SurfaceDistance>,
    /// Overlap of the volumes and distance between the roofs; absent when a shell is open.
    pub overlap: Option<Overlap>,
    /// Top of the model minus top of the reference, metres.
    pub top_offset: Option<f64>,
    /// Bottom of the model minus bottom of the reference, metres.
    pub ground_offset: Option<f64>,
}

/// A mean and a median.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Typical {
    /// Mean.
    pub mean: f64,
    /// Median.
    pub median: f64,
}

/// The figures over all buildings.
#[derive(Debug, Clone, Serialize)]
pub struct Overall {
    /// Buildings in the model.
    pub buildings: usize,
    /// Buildings that have a solid or surface in the level of detail that was asked for.
    pub with_geometry: usize,
    /// Solids.
    pub solids: usize,
    /// Solids without a fault; absent when validity was not checked.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub valid_solids: Option<usize>,
    /// Number of solids with each fault: val3dity codes, or what keeps a geometry from being a solid of one shell.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub faults: BTreeMap<String, usize>,
    /// Faces per solid as the model has them.
    pub faces: Option<Typical>,
    /// Faces per solid once coplanar neighbours are merged.
    pub merged_faces: Option<Typical>,
    /// Triangles per solid.
    pub triangles: Option<Typical>,
    /// Agreement of all points with the buildings.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub points: Option<Agreement>,
    /// Buildings by how far their top is above their highest point.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tops: Option<Tops>,
    /// Buildings of which something was scanned and is not in the model, or is in it and was not scanned.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub completeness: Option<completeness::Counts>,
    /// Agreement with the reference.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference: Option<OverallReference>,
}

/// How many models shoot up over the highest point that was scanned of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Tops {
    /// Buildings with faces and points.
    pub buildings: usize,
    /// By more than 0.5 m.
    pub above_0_5: usize,
    /// By more than 1 m.
    pub above_1: usize,
}

/// Agreement with the reference over all buildings; medians of the figures per building.
#[derive(Debug, Clone, Serialize)]
pub struct OverallReference {
    /// Buildings found in both.
    pub matched: usize,
    /// Ids of the reference that the model lacks.
    pub missing: Vec<String>,
    /// Intersection over union of the volumes.
    pub volume_iou: Option<f64>,
    /// The smallest of them.
    pub least_volume_iou: Option<f64>,
    /// Median distance between the roofs, metres.
    pub roof_distance: Option<f64>,
    /// Signed median distance between the roofs, metres.
    pub roof_offset: Option<f64>,
    /// Hausdorff distance, metres.
    pub hausdorff: Option<f64>,
    /// Symmetric mean Hausdorff distance, metres.
    pub symmetric_mean: Option<f64>,
    /// Symmetric mean Hausdorff distance relative to the largest side of the box.
    pub relative_symmetric_mean: Option<f64>,
    /// Difference between the tops, metres.
    pub top_offset: Option<f64>,
    /// Difference between the bottoms, metres.
    pub ground_offset: Option<f64>,
}

impl Evaluation {
    /// Evaluates `shapes`: their complexity, the faults of each of their solids if they were validated (shape by shape), the
    /// agreement with points if they were measured (over all, and shape by shape), and with reference shapes in the same
    /// frame if there are any.
    pub fn new(
        shapes: &[Shape],
        faults: Option<&[Vec<Vec<String>>]>,
        points: Option<(Agreement, Vec<Agreement>)>,
        reference: Option<&[Shape]>,
    ) -> Self {
        let references = reference.map(|shapes| by_id(shapes));
        let (all_points, mut each_points) = points.map_or((None, Vec::new()), |(all, each)| (Some(all), each));
        each_points.truncate(shapes.len());
        let buildings: Vec<BuildingEvaluation> = shapes
            .par_iter()
            .enumerate()
            .map(|(index, shape)| {
                let of_shape = |faults: &[Vec<Vec<String>>]| {
                    let all: BTreeSet<&String> = faults.get(index).into_iter().flatten().flatten().collect();
                    all.into_iter().cloned().collect()
                };
                let other = references.as_ref().and_then(|map| find(map, &shape.id));
                BuildingEvaluation {
                    id: shape.id.clone(),
                    solids: count_faces(shape),
                    faults: faults.map(of_shape),
                    points: each_points.get(index).copied(),
                    completeness: None,
                    reference: other.map(|other| compare(shape, other)),
                }
            })
            .collect();
        let counts: Vec<FaceCount> = buildings.iter().flat_map(|b| &b.solids).copied().collect();
        let typical = |of: fn(&FaceCount) -> usize| Typical::of(counts.iter().map(|c| of(c) as f64));
        let mut by_fault = BTreeMap::new();
        for fault in faults.iter().flat_map(|all| all.iter().flatten().flatten()) {
            *by_fault.entry(fault.clone()).or_insert(0) += 1;
        }
        let overall = Overall {
            buildings: buildings.len(),
            with_geometry: buildings.iter().filter(|b| !b.solids.is_empty()).count(),
            solids: counts.len(),
            valid_solids: faults.map(|faults| faults.iter().flatten().filter(|faults| faults.is_empty()).count()),
            faults: by_fault,
            faces: typical(|c| c.faces),
            merged_faces: typical(|c| c.merged),
            triangles: typical(|c| c.triangles),
            points: all_points,
            tops: all_points.map(|_| Tops::of(&each_points)),
            completeness: None,
            reference: references.map(|map| OverallReference::of(&buildings, &map)),
        };
        Self { overall, buildings }
    }

    /// The same with what a [`CompletenessMeter`](super::CompletenessMeter) found over all and shape by shape.
    #[must_use]
    pub fn with_completeness(mut self, (all, each): (completeness::Counts, Vec<Option<BuildingCompleteness>>)) -> Self {
        self.overall.completeness = Some(all);
        for (building, found) in self.buildings.iter_mut().zip(each) {
            building.completeness = found;
        }
        self
    }
}

impl Typical {
    fn of(values: impl Iterator<Item = f64> + Clone) -> Option<Self> {
        let count = values.clone().count();
        let median = median(values.clone())?;
        Some(Self { mean: values.sum::<f64>() / count as f64, median })
    }
}

impl Tops {
    fn of(each: &[Agreement]) -> Self {
        let above = |limit: f64| each.iter().filter_map(|a| a.top).filter(|&top| top > limit).count();
        Self { buildings: above(f64::NEG_INFINITY), above_0_5: above(0.5), above_1: above(1.0) }
    }
}

impl OverallReference {
    fn of(buildings: &[BuildingEvaluation], references: &BTreeMap<&str, &Shape>) -> Self {
        let found: Vec<&ReferenceAgreement> = buildings.iter().filter_map(|b| b.reference.as_ref()).collect();
        let typical = |of: &dyn Fn(&ReferenceAgreement) -> Option<f64>| median(found.iter().filter_map(|r| of(r)));
        let iou = |r: &ReferenceAgreement| r.overlap.map(|o| o.volume_iou);
        let missing = references.values().filter(|shape| !found.iter().any(|r| r.id == shape.id));
        Self {
            matched: found.len(),
            missing: missing.map(|shape| shape.id.clone()).collect(),
            volume_iou: typical(&iou),
            least_volume_iou: found.iter().filter_map(|r| iou(r)).min_by(f64::total_cmp),
            roof_distance: typical(&|r| r.overlap?.roofs.map(|d| d.median)),
            roof_offset: typical(&|r| r.overlap?.roofs.map(|d| d.offset)),
            hausdorff: typical(&|r| r.surfaces.map(|s| s.hausdorff)),
            symmetric_mean: typical(&|r| r.surfaces.map(|s| s.symmetric_mean)),
            relative_symmetric_mean: typical(&|r| r.surfaces.map(|s| s.relative_symmetric_mean)),
            top_offset: typical(&|r| r.top_offset),
            ground_offset: typical(&|r| r.ground_offset),
        }
    }
}

/// The shapes by the id under which they are looked up.
fn by_id(shapes: &[Shape]) -> BTreeMap<&str, &Shape> {
    shapes.iter().map(|shape| (shape.id.as_str(), shape)).collect()
}

/// The shape of the same id, or else one whose id is this one but for the number of a part at the end of either, as the
/// 3DBAG has them: `<id>-0`.
fn find<'a>(shapes: &BTreeMap<&str, &'a Shape>, id: &str) -> Option<&'a Shape> {
    let exact = || shapes.get(id);
    let whole = || shapes.get(without_part(id)?);
    let part = || {
        let prefix = format!("{id}-");
        shapes
            .range::<str, _>((Bound::Included(prefix.as_str()), Bound::Unbounded))
            .take_while(|(key, _)| key.starts_with(&prefix))
            .find_map(|(key, shape)| (without_part(key) == Some(id)).then_some(shape))
    };
    exact().or_else(whole).or_else(part).copied()
}

/// An id without the number of a part at its end; `None` when there is no such number.
fn without_part(id: &str) -> Option<&str> {
    let (whole, part) = id.rsplit_once('-')?;
    (!whole.is_empty() && !part.is_empty() && part.bytes().all(|b| b.is_ascii_digit())).then_some(whole)
}

fn compare(shape: &Shape, reference: &Shape) -> ReferenceAgreement {
    let boxes = shape.aabb().zip(reference.aabb());
    ReferenceAgreement {
        id: reference.id.clone(),
        surfaces: surface_distance(shape, reference, SAMPLES, seed_of(&reference.id)),
        overlap: overlap(shape, reference, RAYS),
        top_offset: boxes.map(|(a, b)| a.max[2] - b.max[2]),
        ground_offset: boxes.map(|(a, b)| a.min[2] - b.min[2]),
    }
}

#[cfg(test)]
mod tests {
    use super::super::shape::tests::block;
    use super::*;

    #[test]
    fn ids_match_exactly_or_up_to_the_number_of_a_part() {
        let shapes = ["b-7", "b-10-0", "c", "d-x"].map(|id| block(id, [0.0; 3], [1.0; 3]));
        let map = by_id(&shapes);
        let found = |id: &str| find(&map, id).map(|s| s.id.as_str());
        assert_eq!(found("b-7"), Some("b-7"));
        assert_eq!(found("b-10"), Some("b-10-0"));
        assert_eq!(found("b"), Some("b-7"));
        assert_eq!(found("c-0"), Some("c"));
        assert_eq!([found("d"), found("a"), found("-1")], [None, None, None]);
    }

    #[test]
    fn a_model_against_its_reference() {
        let ours = [block("a", [0.0; 3], [10.0, 10.0, 6.0]), block("b", [20.0, 0.0, 0.0], [30.0, 10.0, 9.0])];
        let theirs = [block("a-0", [0.0; 3], [10.0, 10.0, 5.0]), block("z", [0.0; 3], [1.0; 3])];
        let faults = [vec![vec![]], vec![vec!["302".to_owned(), "203".to_owned()]]];
        let found = Evaluation::new(&ours, Some(&faults), None, Some(&theirs));
        let reference = found.overall.reference.as_ref().unwrap();
        assert_eq!((reference.matched, reference.missing.as_slice()), (1, ["z".to_owned()].as_slice()));
        assert!((reference.volume_iou.unwrap() - 5.0 / 6.0).abs() < 1e-6);
        assert!((reference.roof_distance.unwrap() - 1.0).abs() < 1e-6);
        assert_eq!((reference.top_offset, reference.ground_offset), (Some(1.0), Some(0.0)));
        assert_eq!((found.overall.solids, found.overall.valid_solids), (2, Some(1)));
        assert_eq!(found.buildings[1].faults.as_deref(), Some(["203".to_owned(), "302".to_owned()].as_slice()));
        assert_eq!(found.overall.merged_faces, Some(Typical { mean: 6.0, median: 6.0 }));
        assert!(found.buildings[1].reference.is_none() && found.overall.points.is_none());
    }
}
