//! From exact polygons to shells on the integer grid of the output.

use nalgebra::{Point3, Vector3};

use super::Shell;
use super::collapse::{Mesh, MeshFace};
use super::polygons::Polygon;
use super::unfold::unfold;
use crate::reconstruct::complex::{Complex, PlaneId, VertexId};
use crate::solid::{Face, Solid};

/// Vertices nearer than this (metres) become one: validators take them for the same point (val3dity's `snap_tol` is
/// 1 mm; a hair is added for the comparison).
const SNAP: f64 = 0.001_01;

/// A shell with fewer faces encloses nothing: it is what is left of a component that collapsed.
const LEAST_FACES: usize = 4;

/// Rounds the polygons of one component to the grid, welds vertices that fall together, takes out what collapses, and
/// returns what is left, one shell per set of faces that hang together by edges.
pub(super) fn quantise(complex: &Complex, polygons: &[Polygon], step: [f64; 3]) -> Vec<Shell> {
    let mut planes: Vec<(PlaneId, bool)> = polygons.iter().map(|p| (p.plane, p.positive)).collect();
    planes.sort_unstable();
    planes.dedup();
    let mut vertices: Vec<VertexId> = polygons.iter().flat_map(|p| p.rings.iter().flatten().copied()).collect();
    vertices.sort_unstable();
    vertices.dedup();
    let (grid, welded) = weld(complex, polygons, &vertices, step);
    let position = |v: VertexId| welded[vertices.binary_search(&v).unwrap_or(0)];
    let faces = polygons
        .iter()
        .map(|polygon| MeshFace {
            rings: polygon.rings.iter().map(|ring| ring.iter().map(|&v| position(v)).collect()).collect(),
            normal: outward(complex, polygon),
            label: planes.binary_search(&(polygon.plane, polygon.positive)).unwrap_or(0) as u32,
        })
        .collect();
    let points = grid.iter().map(|g| metres(*g, step)).collect();
    let mut mesh = Mesh { points, faces };
    mesh.clean();
    mesh.connected().into_iter().filter_map(|faces| assemble(&mesh, &faces, &grid, &planes, step)).collect()
}

fn outward(complex: &Complex, polygon: &Polygon) -> Vector3<f64> {
    let normal = Vector3::from(complex.planes[polygon.plane as usize].normal.map(|n| n as f64)).normalize();
    if polygon.positive { normal } else { -normal }
}

fn metres(grid: [i64; 3], step: [f64; 3]) -> Point3<f64> {
    Point3::from(std::array::from_fn(|i| grid[i] as f64 * step[i]))
}

fn round(p: &Point3<f64>, step: [f64; 3]) -> [i64; 3] {
    std::array::from_fn(|i| (p[i] / step[i]).round() as i64)
}

/// Grid positions of clusters of vertices nearer than [`SNAP`], and the cluster of each vertex.
///
/// A cluster stands where its planes are met best, so that the faces around stay planar.
fn weld(complex: &Complex, polygons: &[Polygon], vertices: &[VertexId], step: [f64; 3]) -> (Vec<[i64; 3]>, Vec<u32>) {
    let position = |i: usize| &complex.vertices[vertices[i] as usize].position;
    let mut clusters: Vec<(Vec<usize>, [i64; 3])> =
        (0..vertices.len()).map(|i| (vec![i], round(position(i), step))).collect();
    loop {
        clusters.sort_unstable_by(|a, b| a.1.cmp(&b.1).then_with(|| a.0.cmp(&b.0)));
        let mut merged = vec![false; clusters.len()];
        let mut changed = false;
        for i in 0..clusters.len() {
            if merged[i] {
                continue;
            }
            let here = metres(clusters[i].1, step);
            for j in i + 1..clusters.len() {
                let there = metres(clusters[j].1, step);
                if there.x - here.x > SNAP {
                    break;
                }
                if !merged[j] && (there - here).norm() < SNAP {
                    merged[j] = true;
                    changed = true;
                    let members = std::mem::take(&mut clusters[j].0);
                    clusters[i].0.extend(members);
                }
            }
        }
        if !changed {
            break;
        }
        let mut gone = merged.iter();
        clusters.retain(|_| !gone.next().copied().unwrap_or(false));
        for (members, grid) in clusters.iter_mut().filter(|(members, _)| members.len() > 1) {
            members.sort_unstable();
            *grid = best_position(complex, polygons, vertices, members, step);
        }
    }
    let mut of_vertex = vec![0; vertices.len()];
    for (cluster, (members, _)) in clusters.iter().enumerate() {
        for &i in members {
            of_vertex[i] = cluster as u32;
        }
    }
    (clusters.into_iter().map(|(_, grid)| grid).collect(), of_vertex)
}

/// The grid point nearest to all planes of the polygons that have a member, among the members and their mean.
fn best_position(
    complex: &Complex,
    polygons: &[Polygon],
    vertices: &[VertexId],
    members: &[usize],
    step: [f64; 3],
) -> [i64; 3] {
    let ids: Vec<VertexId> = members.iter().map(|&i| vertices[i]).collect();
    let planes: Vec<(Vector3<f64>, f64)> = polygons
        .iter()
        .filter(|p| p.rings.iter().flatten().any(|v| ids.contains(v)))
        .map(|p| {
            let plane = &complex.planes[p.plane as usize];
            let normal = Vector3::from(plane.normal.map(|n| n as f64));
            (normal / normal.norm(), plane.offset as f64 / normal.norm())
        })
        .collect();
    let positions: Vec<Point3<f64>> = ids.iter().map(|&v| complex.vertices[v as usize].position).collect();
    let mean = Point3::from(positions.iter().map(|p| p.coords).sum::<Vector3<f64>>() / positions.len() as f64);
    let deviation = |grid: [i64; 3]| {
        let p = metres(grid, step);
        planes.iter().map(|(normal, offset)| (normal.dot(&p.coords) + offset).abs()).fold(0.0, f64::max)
    };
    positions
        .iter()
        .chain([&mean])
        .map(|p| round(p, step))
        .min_by(|a, b| deviation(*a).total_cmp(&deviation(*b)).then(a.cmp(b)))
        .unwrap_or_else(|| round(&mean, step))
}

/// A shell of some faces of the mesh, with only the vertices and planes that they use.
fn assemble(
    mesh: &Mesh,
    faces: &[usize],
    grid: &[[i64; 3]],
    planes: &[(PlaneId, bool)],
    step: [f64; 3],
) -> Option<Shell> {
    if faces.len() < LEAST_FACES {
        return None;
    }
    let mut used: Vec<u32> = faces.iter().flat_map(|&f| mesh.faces[f].rings.iter().flatten().copied()).collect();
    used.sort_unstable();
    used.dedup();
    let mut labels: Vec<u32> = faces.iter().map(|&f| mesh.faces[f].label).collect();
    labels.sort_unstable();
    labels.dedup();
    let index = |list: &[u32], value: u32| list.binary_search(&value).unwrap_or(0) as u32;
    let mut solid = Solid {
        step,
        vertices: used.iter().map(|&v| grid[v as usize]).collect(),
        faces: faces
            .iter()
            .map(|&f| Face {
                rings: mesh.faces[f].rings.iter().map(|ring| ring.iter().map(|&v| index(&used, v)).collect()).collect(),
                surface: index(&labels, mesh.faces[f].label),
            })
            .collect(),
        surfaces: Vec::new(),
    };
    unfold(&mut solid);
    Some(Shell { solid, planes: labels.iter().map(|&label| planes[label as usize]).collect() })
}
