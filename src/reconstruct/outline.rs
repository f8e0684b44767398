//! LoD 0 of a site without a footprint: the ground that its solids stand on, or else the outline of its roofs.

use geo::{Area, MultiPolygon, Rect, coord};

use super::blocks;
use super::primitives::footprint_edges;
use super::primitives::roof_map::{NOTHING, RoofMap};
use crate::solid::{Face, FootprintPolygon, Solid, SurfaceType, quantise_footprint};

/// Parts of the outline beside a larger one, and holes in it, are strays and gaps between points below this, square
/// metres.
const SMALLEST: f64 = 4.0;
/// How far the outline may leave that of the pixels, in pixels: enough to take the steps off a slanting edge.
const SMOOTHING: f64 = 1.5;

/// LoD 0 in grid steps: the ground surfaces of `solids`, without any the `outline` (local metres). What it was made from,
/// and what had to be changed for the grid, is told in `notes`. Empty without both.
pub(super) fn footprint(
    solids: &[Solid],
    outline: Option<&MultiPolygon<f64>>,
    step: [f64; 3],
    notes: &mut Vec<String>,
) -> Vec<FootprintPolygon> {
    let mut source = "the ground surfaces of the model";
    let mut polygons: Vec<FootprintPolygon> = solids
        .iter()
        .flat_map(|solid| solid.faces.iter().map(move |face| (solid, face)))
        .filter(|(solid, face)| solid.kind(face) == SurfaceType::Ground)
        .map(|(solid, face)| seen_from_above(solid, face))
        .collect();
    if polygons.is_empty() {
        source = "the outline of the roofs";
        polygons = outline.map(|outline| quantise_footprint(outline, step)).unwrap_or_default();
    }
    let mut repairs = Vec::new();
    let polygons = blocks::mend(polygons, step, &mut repairs);
    if polygons.is_empty() {
        notes.push("no footprint was given, and no roof was found to take an outline from".to_owned());
    } else {
        notes.push(format!("no footprint was given: LoD 0 and LoD 1.2 stand on {source}"));
        notes.append(&mut repairs);
    }
    polygons
}

/// A face that looks down, in the plan: its exterior becomes counter-clockwise.
fn seen_from_above(solid: &Solid, face: &Face) -> FootprintPolygon {
    let plan = |&v: &u32| solid.vertices.get(v as usize).map(|p| [p[0], p[1]]);
    face.rings.iter().map(|ring| ring.iter().rev().filter_map(plan).collect()).collect()
}

/// The outline of the labelled pixels of a map, in local metres, with straightened edges.
pub(super) fn of_map(map: &RoofMap) -> MultiPolygon<f64> {
    let [columns, rows] = map.size();
    let half = map.pixel() / 2.0;
    let mut runs = Vec::new();
    for row in 0..rows {
        let mut start = None;
        for column in 0..=columns {
            match (start, map.label(column, row) != NOTHING) {
                (None, true) => start = Some(column),
                (Some(first), false) => {
                    let (low, high) = (map.centre(first, row), map.centre(column - 1, row));
                    let corners =
                        [coord! { x: low.x - half, y: low.y - half }, coord! { x: high.x + half, y: high.y + half }];
                    runs.push(Rect::new(corners[0], corners[1]).to_polygon());
                    start = None;
                }
                _ => {}
            }
        }
    }
    let mut outline = footprint_edges::simplify(&geo::unary_union(&runs), SMOOTHING * map.pixel());
    let largest = outline.iter().map(Area::unsigned_area).fold(0.0, f64::max);
    outline.0.retain(|polygon| polygon.unsigned_area() >= SMALLEST.min(largest));
    for polygon in &mut outline.0 {
        let (exterior, mut holes) = std::mem::replace(polygon, geo::polygon![]).into_inner();
        holes.retain(|hole| geo::Polygon::new(hole.clone(), Vec::new()).unsigned_area() >= SMALLEST);
        *polygon = geo::Polygon::new(exterior, holes);
    }
    outline
}

#[cfg(test)]
mod tests {
    use geo::{HausdorffDistance, polygon};
    use nalgebra::{Point3, Vector3};

    use super::*;
    use crate::geometry::Plane;
    use crate::reconstruct::primitives::{Extent, Primitive, PrimitiveKind};

    /// The map of a flat roof over the points of a grid of 0.25 m for which `inside` holds.
    fn map(inside: impl Fn(f64, f64) -> bool) -> RoofMap {
        let axis = |i: i32| 0.25 * f64::from(i) + 0.125;
        let points: Vec<Point3<f64>> = (0..80)
            .flat_map(|i| (0..80).map(move |j| (axis(i), axis(j))))
            .filter(|&(x, y)| inside(x, y))
            .map(|(x, y)| Point3::new(x, y, 5.0))
            .collect();
        let roof = Primitive {
            kind: PrimitiveKind::Detected,
            plane: Plane::through(&Point3::new(0.0, 0.0, 5.0), Vector3::z_axis()),
            inliers: (0..points.len() as u32).collect(),
            residual: 0.0,
            extent: Extent::Everywhere,
        };
        RoofMap::new(&points, &[roof], None, 0.9).unwrap()
    }

    #[test]
    fn the_outline_follows_the_roofs() {
        let outline = of_map(&map(|x, y| (x < 16.0 && y < 6.0) || (x < 6.0 && y < 16.0)));
        let expected = polygon![
            (x: 0.0, y: 0.0), (x: 16.0, y: 0.0), (x: 16.0, y: 6.0), (x: 6.0, y: 6.0), (x: 6.0, y: 16.0), (x: 0.0, y: 16.0)
        ];
        assert_eq!(outline.0.len(), 1);
        assert!(outline.0[0].hausdorff_distance(&expected) < 0.6, "{outline:?}");
        assert!((outline.unsigned_area() / expected.unsigned_area() - 1.0).abs() < 0.1);
        assert!(outline.0[0].exterior().0.len() <= 10, "{outline:?}");
    }

    #[test]
    fn courtyards_stay_and_strays_go() {
        let outline = of_map(&map(|x, y| {
            (x < 14.0 && y < 14.0 && !((4.0..10.0).contains(&x) && (4.0..10.0).contains(&y))) || (x > 18.0 && y > 18.75)
        }));
        assert_eq!((outline.0.len(), outline.0[0].interiors().len()), (1, 1));
        let mut notes = Vec::new();
        let polygons = footprint(&[], Some(&outline), [1e-4; 3], &mut notes);
        assert_eq!((polygons.len(), polygons[0].len()), (1, 2));
        assert_eq!(notes, ["no footprint was given: LoD 0 and LoD 1.2 stand on the outline of the roofs"]);
        assert!(footprint(&[], None, [1e-4; 3], &mut notes).is_empty());
        // A kiosk is no stray when there is nothing else.
        assert_eq!(of_map(&map(|x, y| x < 1.5 && y < 1.5)).0.len(), 1);
    }
}
