//! Thinning of vegetation in clouds that are not classified.
//!
//! Roofs are flat nearby, foliage is not. The smallest eigenvalue of the covariance of a point's neighbourhood, as a
//! share of the sum of all three (the *surface variation* of Pauly, Gross, Kobbelt, "Efficient simplification of
//! point-sampled surfaces", IEEE Visualization 2002), is near 0 on a plane and 1/3 in a ball of leaves.

use super::options::SegmentOptions;
use kiddo::{ImmutableKdTree, SquaredEuclidean};
use nalgebra::{Matrix3, Vector3};
use std::num::NonZeroUsize;

/// Points in a neighbourhood, the point itself included.
const NEIGHBOURS: NonZeroUsize = NonZeroUsize::new(12).unwrap();
/// Neighbours whose planes a point may lie on: far enough to find a flat one from a ridge.
const WITNESSES: NonZeroUsize = NonZeroUsize::new(30).unwrap();
/// A point this near to the plane of a flat neighbour belongs to it, metres: points at ridges and eaves, whose own
/// neighbourhoods are bent.
const NEAR_PLANE: f64 = 0.15;

/// Normal and centre.
type Plane = (Vector3<f64>, Vector3<f64>);

/// Drops the points that lie neither in a flat neighbourhood nor on the plane of a flat neighbour. Gives how many.
pub(super) fn drop_vegetation(points: &mut Vec<[f64; 3]>, options: &SegmentOptions) -> usize {
    let before = points.len();
    let tree = ImmutableKdTree::new_from_slice(points).ok().filter(|_| before > NEIGHBOURS.get());
    // Too few points to tell, or no tree over them: leave them be.
    let Some(tree) = tree else { return 0 };
    let neighbours = |point: &[f64; 3], count: NonZeroUsize| {
        let found = tree.query(point).nearest_n::<SquaredEuclidean<f64>>(count).execute();
        found.into_iter().map(|hit| hit.item as usize).collect::<Vec<_>>()
    };
    let flat = |p: &[f64; 3]| flat_plane(&neighbours(p, NEIGHBOURS), points, options.flatness);
    let planes: Vec<_> = points.iter().map(flat).collect();
    let is_kept = |(point, plane): (&[f64; 3], &Option<Plane>)| {
        let at = Vector3::from(*point);
        let is_on = |(normal, centre): &Plane| normal.dot(&(at - centre)).abs() <= NEAR_PLANE;
        let has_witness = || neighbours(point, WITNESSES).iter().any(|i| planes[*i].as_ref().is_some_and(is_on));
        plane.is_some() || has_witness()
    };
    let keep: Vec<bool> = points.iter().zip(&planes).map(is_kept).collect();
    let mut kept = keep.iter();
    points.retain(|_| kept.next().copied().unwrap_or(true));
    before - points.len()
}

/// The plane of a neighbourhood when it is flat.
fn flat_plane(members: &[usize], points: &[[f64; 3]], flatness: f64) -> Option<Plane> {
    let members = || members.iter().map(|i| Vector3::from(points[*i]));
    let count = members().count() as f64;
    let centre = members().sum::<Vector3<f64>>() / count;
    let covariance = members().map(|p| (p - centre) * (p - centre).transpose()).sum::<Matrix3<f64>>() / count;
    let eigen = covariance.symmetric_eigen();
    let smallest = eigen.eigenvalues.imin();
    let is_flat = eigen.eigenvalues[smallest] <= flatness * eigen.eigenvalues.sum();
    is_flat.then(|| (eigen.eigenvectors.column(smallest).into_owned(), centre))
}

#[cfg(test)]
mod tests {
    use super::drop_vegetation;
    use crate::segment::SegmentOptions;

    #[test]
    fn a_gable_stays_and_the_tree_beside_it_goes() {
        // A gable roof of 45° with its ridge at y = 5, and a ball of leaves of 3 m radius well above it.
        let mut points: Vec<[f64; 3]> = (0..900)
            .map(|i| {
                let (x, y) = (f64::from(i % 30) / 3.0, f64::from(i / 30) / 3.0);
                [x, y, 8.0 - (y - 5.0).abs()]
            })
            .collect();
        let golden = 0.618_033_988_75;
        let leaves = (0..600).filter_map(|i| {
            let p = [0.754_877_666, 0.569_840_291, golden].map(|step: f64| (f64::from(i) * step).fract() * 6.0 - 3.0);
            (p[0] * p[0] + p[1] * p[1] + p[2] * p[2] < 9.0).then(|| [p[0] + 20.0, p[1] + 5.0, p[2] + 9.0])
        });
        points.extend(leaves);
        let leaves = points.len() - 900;
        drop_vegetation(&mut points, &SegmentOptions::default());
        let roof = points.iter().filter(|p| p[0] < 12.0).count();
        assert!(roof >= 895, "{roof} of 900 roof points are left");
        assert!((points.len() - roof) * 5 < leaves, "{} of {leaves} leaves are left", points.len() - roof);
    }
}
