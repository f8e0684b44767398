//! Cell complexes of boxes, for tests: any partition of a box into boxes, T-junctions included, sheared if asked.

use std::collections::BTreeMap;

use nalgebra::Point3;

use crate::reconstruct::complex::{Cell, Complex, Facet, IntegerPlane, OUTSIDE, PlaneId, Vertex, VertexId};

/// Smallest and largest corner, in units of the complex.
pub(crate) type Block = [[i64; 3]; 2];

/// A linear map with determinant 1, rows first, with its inverse, and the number of units in a metre.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shape {
    map: [[i64; 3]; 3],
    inverse: [[i64; 3]; 3],
    units: i64,
}

/// Boxes as they are, in metres.
pub(crate) const STRAIGHT: Shape =
    Shape { map: [[1, 0, 0], [0, 1, 0], [0, 0, 1]], inverse: [[1, 0, 0], [0, 1, 0], [0, 0, 1]], units: 1 };
/// Boxes as they are, in micrometres.
pub(crate) const MICRO: Shape = Shape { units: 1_000_000, ..STRAIGHT };
/// Oblique cells in thirds of a metre: no plane is parallel to an axis but one, and few vertices are on the grid.
pub(crate) const OBLIQUE: Shape =
    Shape { map: [[1, 0, 0], [2, 1, 0], [1, -1, 1]], inverse: [[1, 0, 0], [-2, 1, 0], [-3, 1, 1]], units: 3 };

/// All boxes of a grid with these coordinates along each axis.
pub(crate) fn grid(axes: [&[i64]; 3]) -> Vec<Block> {
    let mut blocks = Vec::new();
    for x in axes[0].windows(2) {
        for y in axes[1].windows(2) {
            for z in axes[2].windows(2) {
                blocks.push([[x[0], y[0], z[0]], [x[1], y[1], z[1]]]);
            }
        }
    }
    blocks
}

/// Boxes from cutting a box of this size again and again; `cuts` picks box, axis and place.
pub(crate) fn subdivide(size: i64, cuts: &[(usize, usize, i64)]) -> Vec<Block> {
    let mut blocks = vec![[[0; 3], [size; 3]]];
    for &(which, axis, place) in cuts {
        let which = which % blocks.len();
        let [min, max] = blocks[which];
        let extent = max[axis] - min[axis];
        if extent >= 2 {
            let at = min[axis] + 1 + place.rem_euclid(extent - 1);
            let (mut low, mut high) = ([min, max], [min, max]);
            low[1][axis] = at;
            high[0][axis] = at;
            blocks[which] = low;
            blocks.push(high);
        }
    }
    blocks
}

pub(crate) fn volume(block: &Block, shape: &Shape) -> f64 {
    (0..3).map(|i| (block[1][i] - block[0][i]) as f64 / shape.units as f64).product()
}

struct Builder {
    shape: Shape,
    complex: Complex,
    vertices: BTreeMap<[i64; 3], VertexId>,
    planes: BTreeMap<(usize, i64), PlaneId>,
}

fn apply(map: &[[i64; 3]; 3], p: [i64; 3]) -> [i64; 3] {
    map.map(|row| row[0] * p[0] + row[1] * p[1] + row[2] * p[2])
}

fn gcd(a: i64, b: i64) -> i64 {
    if b == 0 { a.abs() } else { gcd(b, a % b) }
}

impl Builder {
    fn vertex(&mut self, p: [i64; 3]) -> VertexId {
        let (shape, complex) = (self.shape, &mut self.complex);
        *self.vertices.entry(p).or_insert_with(|| {
            let q = apply(&shape.map, p);
            let divisor = q.iter().fold(shape.units, |g, v| gcd(g, *v));
            let [x, y, z] = q.map(|v| i128::from(v / divisor));
            let position = Point3::from(q.map(|v| v as f64 / shape.units as f64));
            complex.vertices.push(Vertex { homogeneous: [x, y, z, i128::from(shape.units / divisor)], position });
            complex.vertices.len() as VertexId - 1
        })
    }

    fn plane(&mut self, axis: usize, at: i64) -> PlaneId {
        let (shape, complex) = (self.shape, &mut self.complex);
        *self.planes.entry((axis, at)).or_insert_with(|| {
            // The row of the inverse takes a point back to its coordinate along the axis.
            let normal = shape.inverse[axis].map(|v| v * shape.units);
            let divisor = normal.iter().fold(at, |g, v| gcd(g, *v));
            let normal = normal.map(|v| v / divisor);
            complex.planes.push(IntegerPlane { normal, offset: -at / divisor });
            complex.planes.len() as PlaneId - 1
        })
    }

    fn facet(&mut self, axis: usize, at: i64, min: [i64; 2], max: [i64; 2], cells: [u32; 2]) {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let corners = [[min[0], min[1]], [max[0], min[1]], [max[0], max[1]], [min[0], max[1]]]
            .map(|[a, b]| {
                let mut p = [at; 3];
                (p[u], p[v]) = (a, b);
                self.vertex(p)
            })
            .to_vec();
        let edges = vec![self.plane(v, min[1]), self.plane(u, max[0]), self.plane(v, max[1]), self.plane(u, min[0])];
        let plane = self.plane(axis, at);
        let id = self.complex.facets.len() as u32;
        self.complex.facets.push(Facet { plane, corners, edges, cells });
        for cell in cells.into_iter().filter(|&c| c != OUTSIDE) {
            self.complex.cells[cell as usize].facets.push(id);
        }
    }
}

/// The complex whose cells are these boxes, which together fill a box.
pub(crate) fn complex(blocks: &[Block], shape: Shape) -> Complex {
    let cells = vec![Cell::default(); blocks.len()];
    let complex = Complex { cells, ..Complex::default() };
    let mut builder = Builder { shape, complex, vertices: BTreeMap::new(), planes: BTreeMap::new() };
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        let low = blocks.iter().map(|b| b[0][axis]).min().unwrap();
        let high = blocks.iter().map(|b| b[1][axis]).max().unwrap();
        for (i, a) in blocks.iter().enumerate() {
            let (min, max) = ([a[0][u], a[0][v]], [a[1][u], a[1][v]]);
            if a[0][axis] == low {
                builder.facet(axis, low, min, max, [OUTSIDE, i as u32]);
            }
            if a[1][axis] == high {
                builder.facet(axis, high, min, max, [i as u32, OUTSIDE]);
            }
            for (j, b) in blocks.iter().enumerate().filter(|(_, b)| b[0][axis] == a[1][axis]) {
                let min = [min[0].max(b[0][u]), min[1].max(b[0][v])];
                let max = [max[0].min(b[1][u]), max[1].min(b[1][v])];
                if min[0] < max[0] && min[1] < max[1] {
                    builder.facet(axis, a[1][axis], min, max, [i as u32, j as u32]);
                }
            }
        }
    }
    builder.complex
}
