//! How much of a convex cell lies inside a closed mesh, exactly up to rounding.
//!
//! A closed mesh is the sum of the prisms between its triangles and a plane far below: those under triangles that look up
//! count, those under triangles that look down count back. Each prism is convex, so that what a cell has of it is found by
//! cutting the cell with four planes; nothing is sampled.

use nalgebra::{Point3, Unit, Vector3};

use crate::geometry::{Aabb, Plane};
use crate::reconstruct::complex::{CellId, Complex};
use crate::simulate::{Mesh, Truth};

/// Triangles narrower than this seen from above have no prism, m².
const FLAT: f64 = 1e-12;

/// The share of each cell of a complex that lies inside a closed mesh, 0 to 1; the mesh and its truth are in the frame of
/// the complex.
pub fn inside_fraction(complex: &Complex, mesh: &Mesh, truth: &Truth) -> Vec<f64> {
    let prisms: Vec<Prism> = mesh.all_corners().filter_map(|corners| Prism::under(&corners)).collect();
    let surface: Vec<Aabb> = mesh.all_corners().filter_map(|corners| Aabb::of(&corners)).collect();
    (0..complex.cells.len() as CellId)
        .map(|cell| {
            let aabb = complex.cell_aabb(cell);
            // A cell that no triangle is near is wholly inside or wholly outside.
            let volume = complex.cell_volume(cell);
            if volume <= 0.0 || !surface.iter().any(|triangle| overlap(triangle, &aabb, 3)) {
                return f64::from(u8::from(truth.is_inside(&complex.cell_centroid(cell))));
            }
            let body = Convex::of(complex, cell);
            let near = prisms.iter().filter(|prism| overlap(&prism.aabb, &aabb, 2) && prism.aabb.max[2] > aabb.min[2]);
            let inside: f64 = near.map(|prism| prism.sign * body.volume_within(&prism.sides)).sum();
            (inside / body.volume()).clamp(0.0, 1.0)
        })
        .collect()
}

fn overlap(a: &Aabb, b: &Aabb, axes: usize) -> bool {
    (0..axes).all(|i| a.min[i] <= b.max[i] && b.min[i] <= a.max[i])
}

/// All that lies below a triangle.
struct Prism {
    /// 1 when the triangle looks up, −1 when it looks down.
    sign: f64,
    /// The planes of its sides and of the triangle, normals outwards.
    sides: [Plane; 4],
    /// The box of the triangle.
    aabb: Aabb,
}

impl Prism {
    /// `None` under a triangle that stands.
    fn under(&[a, b, c]: &[Point3<f64>; 3]) -> Option<Self> {
        let turn = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
        if turn.abs() <= FLAT {
            return None;
        }
        let [b, c] = if turn > 0.0 { [b, c] } else { [c, b] };
        let wall = |from: Point3<f64>, to: Point3<f64>| {
            let out = Unit::try_new(Vector3::new(to.y - from.y, from.x - to.x, 0.0), 0.0)?;
            Some(Plane::through(&from, out))
        };
        let top = Plane::through(&a, Unit::try_new((b - a).cross(&(c - a)), 0.0)?);
        Some(Self {
            sign: turn.signum(),
            sides: [wall(a, b)?, wall(b, c)?, wall(c, a)?, top],
            aabb: Aabb::of(&[a, b, c])?,
        })
    }
}

/// A convex body as its faces, in no order of turning: each a convex polygon.
#[derive(Debug, Clone, Default)]
struct Convex {
    faces: Vec<Vec<Point3<f64>>>,
}

impl Convex {
    fn of(complex: &Complex, cell: CellId) -> Self {
        let facets = complex.cells.get(cell as usize).map(|cell| cell.facets.as_slice()).unwrap_or_default();
        Self { faces: facets.iter().map(|&facet| complex.facet_positions(facet).collect()).collect() }
    }

    /// Volume: the pyramids from a corner to all faces.
    fn volume(&self) -> f64 {
        let Some(&apex) = self.faces.first().and_then(|face| face.first()) else { return 0.0 };
        let pyramid = |face: &Vec<Point3<f64>>| {
            let spokes = face.windows(2).map(|pair| (pair[0] - apex, pair[1] - apex));
            let first = face.first().map_or(Vector3::zeros(), |p| p - apex);
            // Triangles of a fan all turn the same way, so that their pyramids have one sign.
            spokes.map(|(p, q)| first.dot(&p.cross(&q))).sum::<f64>().abs() / 6.0
        };
        self.faces.iter().map(pyramid).sum()
    }

    /// Volume of what lies behind all these planes.
    fn volume_within(&self, sides: &[Plane]) -> f64 {
        let mut body = None;
        for side in sides {
            match body.as_ref().unwrap_or(self).behind(side) {
                Cut::All => {}
                Cut::Nothing => return 0.0,
                Cut::Part(part) => body = Some(part),
            }
        }
        body.as_ref().unwrap_or(self).volume()
    }

    /// What lies behind a plane.
    fn behind(&self, side: &Plane) -> Cut {
        let distances = || self.faces.iter().flatten().map(|p| side.distance(p));
        if distances().all(|d| d <= 0.0) {
            return Cut::All;
        }
        if distances().all(|d| d >= 0.0) {
            return Cut::Nothing;
        }
        let mut rim = Vec::new();
        let mut faces = Vec::with_capacity(self.faces.len() + 1);
        for face in &self.faces {
            let mut kept = Vec::with_capacity(face.len() + 1);
            for (p, q) in face.iter().zip(face.iter().cycle().skip(1)) {
                let [here, there] = [side.distance(p), side.distance(q)];
                if here <= 0.0 {
                    kept.push(*p);
                    if here == 0.0 {
                        rim.push(*p);
                    }
                }
                if here * there < 0.0 {
                    let meeting = p + (q - p) * (here / (here - there));
                    kept.push(meeting);
                    rim.push(meeting);
                }
            }
            if kept.len() >= 3 {
                faces.push(kept);
            }
        }
        faces.push(ordered(rim, &side.normal));
        Cut::Part(Self { faces })
    }
}

/// What a plane leaves of a body.
enum Cut {
    All,
    Nothing,
    Part(Convex),
}

/// The corners of a convex polygon in the order in which they turn about its middle.
fn ordered(mut corners: Vec<Point3<f64>>, normal: &Vector3<f64>) -> Vec<Point3<f64>> {
    let middle = Point3::from(corners.iter().map(|p| p.coords).sum::<Vector3<f64>>() / corners.len().max(1) as f64);
    let across = if normal.x.abs() < 0.6 { Vector3::x() } else { Vector3::y() };
    let u = normal.cross(&across).normalize();
    let v = normal.cross(&u);
    let angle = |p: &Point3<f64>| (p - middle).dot(&v).atan2((p - middle).dot(&u));
    corners.sort_by(|p, q| angle(p).total_cmp(&angle(q)));
    corners
}
