//! What is measured of a building once its model stands.

use nalgebra::Point3;
use rstar::{PointDistance, RTree};

use super::patch::Patch;
use super::primitives::roof_map::{NOTHING, RoofMap};
use crate::building::{RoofHeights, RoofType};
use crate::solid::{Solid, SurfaceType};

/// A roof flatter than this is flat, degrees (as city platforms count it).
const FLAT: f64 = 4.0;

/// Heights of the points on roofs; `None` without any.
pub fn roof_heights(heights: &mut [f64]) -> Option<RoofHeights> {
    heights.sort_by(f64::total_cmp);
    let at = |share: f64| heights.get(((heights.len().saturating_sub(1)) as f64 * share).round() as usize).copied();
    Some(RoofHeights { min: at(0.0)?, p50: at(0.5)?, p70: at(0.7)?, p98: at(0.98)?, max: at(1.0)? })
}

/// The highest point of some solids, local metres.
pub fn top<'a>(solids: impl Iterator<Item = &'a Solid>) -> Option<f64> {
    let heights = solids.flat_map(|solid| solid.vertices.iter().map(|v| v[2] as f64 * solid.step[2]));
    heights.max_by(f64::total_cmp)
}

/// The shape of the roof from the slopes of its surfaces; `None` without roof surfaces.
pub fn roof_type(solids: &[Solid]) -> Option<RoofType> {
    let slopes: Vec<f64> = roof_surfaces(solids).filter_map(|surface| surface.slope).collect();
    match slopes.len() {
        0 => None,
        _ if slopes.iter().any(|&slope| slope >= FLAT) => Some(RoofType::Slanted),
        1 => Some(RoofType::Flat),
        _ => Some(RoofType::MultipleFlat),
    }
}

/// The roof surfaces of some solids.
pub fn roof_surfaces(solids: &[Solid]) -> impl Iterator<Item = &crate::solid::Surface> {
    solids.iter().flat_map(|solid| &solid.surfaces).filter(|surface| surface.kind == SurfaceType::Roof)
}

/// Height of the highest edge between two roof faces; `None` when no two roof faces meet.
pub fn ridge_height(solids: &[Solid]) -> Option<f64> {
    let mut highest: Option<f64> = None;
    for solid in solids {
        let mut edges: Vec<([u32; 2], f64)> = Vec::new();
        for face in solid.faces.iter().filter(|face| solid.kind(face) == SurfaceType::Roof) {
            for ring in &face.rings {
                for (&a, &b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
                    edges.push(([a.min(b), a.max(b)], solid.point(a).z.max(solid.point(b).z)));
                }
            }
        }
        edges.sort_by_key(|(key, _)| *key);
        for pair in edges.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
            highest = Some(highest.map_or(pair[0].1, |h| h.max(pair[0].1)));
        }
    }
    highest
}

/// Root mean square of the distances of `points` to the nearest face of some solids, metres; `None` without either.
pub fn rmse<'a>(solids: impl IntoIterator<Item = &'a Solid>, points: &[Point3<f64>]) -> Option<f64> {
    let patches: Vec<Patch> = solids
        .into_iter()
        .flat_map(|solid| solid.faces.iter().filter_map(move |face| Patch::of(solid, face)))
        .collect();
    if patches.is_empty() || points.is_empty() {
        return None;
    }
    let tree = RTree::bulk_load(patches);
    let squares = points.iter().filter_map(|point| {
        let place = [point.x, point.y, point.z];
        tree.nearest_neighbor(&place).map(|patch| patch.distance_2(&place))
    });
    Some((squares.sum::<f64>() / points.len() as f64).sqrt())
}

/// Share of the labelled pixels of a map farther than 1 m from every point.
pub fn no_data_share(map: &RoofMap, points: &[Point3<f64>]) -> Option<f64> {
    const REACH: f64 = 1.0;
    let [columns, rows] = map.size();
    let mut hit = vec![false; columns * rows];
    for [column, row] in points.iter().filter_map(|p| map.pixel_at(&p.xy())) {
        hit[row * columns + column] = true;
    }
    let mut near = vec![false; hit.len()];
    for i in (0..hit.len()).filter(|&i| hit[i]) {
        let p = map.centre(i % columns, i / columns);
        for row in map.range(1, p.y - REACH, p.y + REACH) {
            for column in map.range(0, p.x - REACH, p.x + REACH) {
                if (map.centre(column, row) - p).norm_squared() <= REACH * REACH {
                    near[row * columns + column] = true;
                }
            }
        }
    }
    let (mut total, mut empty) = (0.0, 0.0);
    for i in (0..near.len()).filter(|&i| map.label(i % columns, i / columns) != NOTHING) {
        total += 1.0;
        empty += f64::from(u8::from(!near[i]));
    }
    (total > 0.0).then_some(empty / total)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solid::{Face, Surface};

    /// A 4 m × 2 m roof that rises from 3 m at x = 0 to 5 m at x = 2 and falls again.
    fn gable() -> Solid {
        let vertices = [[0, 0, 3], [2, 0, 5], [4, 0, 3], [4, 2, 3], [2, 2, 5], [0, 2, 3]]
            .map(|v: [i64; 3]| v.map(|c| c * 10_000))
            .to_vec();
        Solid {
            step: [1e-4; 3],
            vertices,
            faces: vec![
                Face { rings: vec![vec![0, 1, 4, 5]], surface: 0 },
                Face { rings: vec![vec![1, 2, 3, 4]], surface: 1 },
            ],
            surfaces: vec![Surface { slope: Some(45.0), ..Surface::of(SurfaceType::Roof) }; 2],
        }
    }

    #[test]
    fn distances_are_to_the_nearest_face_or_its_border() {
        // 0.3 m above the slope at 45°, on the other slope, and 1 m beyond an eave.
        let points = [Point3::new(1.0, 1.0, 4.3), Point3::new(3.0, 1.0, 4.0), Point3::new(5.0, 1.0, 3.0)];
        let squares = 0.3_f64.powi(2) / 2.0 + 1.0;
        assert!((rmse([&gable()], &points).unwrap() - f64::sqrt(squares / 3.0)).abs() < 1e-9);
        assert_eq!(rmse([], &points), None);
        assert_eq!(rmse([&gable()], &[]), None);
    }

    #[test]
    fn the_ridge_is_the_highest_edge_between_roofs() {
        assert_eq!(ridge_height(&[gable()]), Some(5.0));
        assert_eq!(roof_type(&[gable()]), Some(RoofType::Slanted));
    }

    #[test]
    fn percentiles_of_heights() {
        let mut heights: Vec<f64> = (0..=10).rev().map(f64::from).collect();
        let h = roof_heights(&mut heights).unwrap();
        assert_eq!((h.min, h.p50, h.p70, h.p98, h.max), (0.0, 5.0, 7.0, 10.0, 10.0));
        assert!(roof_heights(&mut []).is_none());
    }
}
