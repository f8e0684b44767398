//! The groups of abspy's tutorial: what it made of them is written down in the method digest, section 10.

use std::path::Path;
use std::time::Instant;

use geo::{ConvexHull, Coord, MultiPoint};
use nalgebra::{Matrix3, Point3, Vector3};

use super::super::{Complex, IntegerPlane};
use crate::geometry::{Aabb, Plane};
use crate::reconstruct::primitives::{Extent, Primitive, PrimitiveKind};

const SHARED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/data/partition");

/// The groups of a .vg file (text), each as the positions of its points; `None` where the file is not there.
fn groups(name: &str) -> Option<Vec<Vec<Point3<f64>>>> {
    let text = std::fs::read_to_string(Path::new(SHARED).join(name)).ok();
    if text.is_none() {
        println!("skipped: shared data not found");
    }
    let text = text?;
    let mut lines = text.lines();
    let numbers = |line: &str| line.split_whitespace().map(|n| n.parse::<f64>().unwrap()).collect::<Vec<_>>();
    assert!(lines.next()?.starts_with("num_points:"));
    let points: Vec<_> = numbers(lines.next()?).chunks_exact(3).map(Point3::from_slice).collect();
    let mut groups = Vec::new();
    while let Some(line) = lines.next() {
        if line.starts_with("group_num_point:") {
            groups.push(numbers(lines.next()?).into_iter().map(|i| points[i as usize]).collect());
        }
    }
    Some(groups)
}

/// Refitted planes (method, section 1) with the convex hulls of their points, or with their axis-aligned boxes only.
fn primitives(groups: &[Vec<Point3<f64>>]) -> Vec<Primitive> {
    let mut primitives = Vec::new();
    let mut first = 0;
    for points in groups {
        let (plane, residual) = Plane::fit(points).unwrap();
        let u = plane.normal.cross(&if plane.normal.z.abs() < 0.9 { Vector3::z() } else { Vector3::x() }).normalize();
        let v = plane.normal.cross(&u);
        let foot = plane.normal.into_inner() * -plane.offset;
        let flat: MultiPoint = points.iter().map(|p| Coord { x: u.dot(&p.coords), y: v.dot(&p.coords) }).collect();
        let hull = flat.convex_hull();
        let patch = hull.exterior().0.iter().skip(1).map(|c| Point3::from(foot + u * c.x + v * c.y)).collect();
        let inliers = (first..first + points.len() as u32).collect();
        first += points.len() as u32;
        primitives.push(Primitive {
            kind: PrimitiveKind::Detected,
            plane,
            inliers,
            residual,
            extent: Extent::Patch(patch),
        });
    }
    primitives
}

/// The box of all points, padded by a tenth of each side (method, section 1).
fn bounds(groups: &[Vec<Point3<f64>>]) -> Aabb {
    let mut bounds = Aabb::of(groups.iter().flatten()).unwrap();
    for (axis, side) in bounds.extent().into_iter().enumerate() {
        bounds.min[axis] -= side / 10.0;
        bounds.max[axis] += side / 10.0;
    }
    bounds
}

/// The number of regions into which planes in general position divide a box: one, and one more for every plane, every
/// line of two and every point of three that meets the box. In floating point and without any cell: another road to
/// the number of cells.
fn regions(planes: &[Plane], bounds: &Aabb) -> usize {
    let planes: Vec<_> = planes.iter().map(|p| (p.normal.into_inner(), p.offset)).collect();
    let (min, max) = (Vector3::from(bounds.min), Vector3::from(bounds.max));
    let (middle, half) = ((min + max) / 2.0, (max - min) / 2.0);
    let mut count = 1;
    for (i, (n, d)) in planes.iter().enumerate() {
        count += usize::from((n.dot(&middle) + d).abs() < n.abs().dot(&half));
        for (j, (m, e)) in planes.iter().enumerate().skip(i + 1) {
            let along = n.cross(m);
            let Some(inverse) = Matrix3::from_rows(&[n.transpose(), m.transpose(), along.transpose()]).try_inverse()
            else {
                continue;
            };
            let foot = inverse * Vector3::new(-d, -e, 0.0);
            let (a, b) = ((min - foot).component_div(&along), (max - foot).component_div(&along));
            count += usize::from(a.inf(&b).max() < a.sup(&b).min());
            for (o, f) in &planes[j + 1..] {
                let point = foot - along * ((o.dot(&foot) + f) / o.dot(&along));
                count += usize::from((0..3).all(|axis| (point[axis] - middle[axis]).abs() < half[axis]));
            }
        }
    }
    count
}

#[test]
fn tutorial_points_have_as_many_cells_as_the_formula_says() {
    let Some(groups) = groups("test_points.vg") else { return };
    assert_eq!(groups.len(), 21);
    let (primitives, bounds) = (primitives(&groups), bounds(&groups));
    let fitted: Vec<_> = primitives.iter().map(|p| p.plane).collect();
    let exhaustive = Complex::exhaustive(&primitives, &bounds).unwrap();
    exhaustive.check().unwrap();
    // Groups 3 and 17 differ by 2e-7: one plane on the grid. abspy, without a grid, found 599 cells.
    let snapped: Vec<_> = exhaustive.planes[6..].iter().map(IntegerPlane::to_plane).collect();
    assert_eq!((snapped.len(), regions(&fitted, &bounds)), (20, 599));
    assert_eq!(exhaustive.primitive_planes[3].plane, exhaustive.primitive_planes[17].plane);
    assert_eq!(exhaustive.cells.len(), regions(&snapped, &bounds));
    // abspy found 102 adaptive cells with boxes for patches, which is coarser.
    let adaptive = Complex::adaptive(&primitives, &bounds).unwrap();
    adaptive.check().unwrap();
    println!("test_points: {} cells, exhaustive {}", adaptive.cells.len(), exhaustive.cells.len());
    assert!((30..=102).contains(&adaptive.cells.len()));
}

#[test]
fn the_church_of_218_primitives() {
    let Some(groups) = groups("test_church.vg") else { return };
    assert_eq!(groups.len(), 218);
    let (primitives, bounds) = (primitives(&groups), bounds(&groups));
    let start = Instant::now();
    let complex = Complex::adaptive(&primitives, &bounds).unwrap();
    println!(
        "church: {} cells, {} facets, {} vertices in {:.0} ms",
        complex.cells.len(),
        complex.facets.len(),
        complex.vertices.len(),
        start.elapsed().as_secs_f64() * 1e3
    );
    complex.check().unwrap();
    // abspy had 1 554 cells when it was stopped.
    assert!((1_000..20_000).contains(&complex.cells.len()));
}
