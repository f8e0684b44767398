//! Convex pieces of a building, as half-spaces.

use nalgebra::{Matrix2, Matrix3, Point2, Point3, Unit, Vector2, Vector3};

use crate::geometry::Plane;

/// Half the side of the square that a face is cut from, metres: beyond every building.
const REACH: f64 = 1000.0;
/// Faces smaller than this (m²) are none: the half-space follows from the others, or only touches.
const LEAST_AREA: f64 = 1e-7;
/// Planes with a normal that rises by less are walls.
const STANDS: f64 = 1e-6;

/// The points on the negative side of all these planes.
#[derive(Debug, Clone, Default)]
pub(super) struct Convex {
    pub(super) sides: Vec<Plane>,
}

/// The half-space on the left of the line from `from` to `to`, widened by `beyond` metres.
pub(super) fn wall(from: Point2<f64>, to: Point2<f64>, beyond: f64) -> Plane {
    let out = outward(from, to);
    Plane { normal: Unit::new_unchecked(Vector3::new(out.x, out.y, 0.0)), offset: -out.dot(&from.coords) - beyond }
}

/// The half-space under the plane that has this height over the line from `from` to `to` and rises to the left of it with
/// this tangent.
pub(super) fn slope(from: Point2<f64>, to: Point2<f64>, height: f64, tangent: f64) -> Plane {
    let out = outward(from, to);
    let normal = Unit::new_normalize(Vector3::new(tangent * out.x, tangent * out.y, 1.0));
    Plane::through(&Point3::new(from.x, from.y, height), normal)
}

/// The half-space below a height.
pub(super) fn below(height: f64) -> Plane {
    Plane { normal: Vector3::z_axis(), offset: -height }
}

/// The half-space above a height.
pub(super) fn above(height: f64) -> Plane {
    below(height).flipped()
}

/// The unit normal on the right of a line.
pub(super) fn outward(from: Point2<f64>, to: Point2<f64>) -> Vector2<f64> {
    let along = (to - from).normalize();
    Vector2::new(along.y, -along.x)
}

impl Convex {
    /// The intersection of half-spaces.
    pub(super) fn new(sides: impl IntoIterator<Item = Plane>) -> Self {
        Self { sides: sides.into_iter().collect() }
    }

    /// The part of it in further half-spaces.
    #[must_use]
    pub(super) fn and(mut self, sides: impl IntoIterator<Item = Plane>) -> Self {
        self.sides.extend(sides);
        self
    }

    /// Whether it holds a point.
    pub(super) fn contains(&self, point: &Point3<f64>) -> bool {
        self.sides.iter().all(|side| side.distance(point) <= 0.0)
    }

    /// Height of its upper side over a place; infinite without one.
    pub(super) fn top_at(&self, place: Point2<f64>) -> f64 {
        let upper = self.sides.iter().filter(|side| side.normal.z > STANDS);
        upper.filter_map(|side| side.height_at(place.x, place.y)).fold(f64::INFINITY, f64::min)
    }

    /// It in another frame.
    pub(super) fn placed(&self, placement: &Placement) -> Self {
        Self { sides: self.sides.iter().map(|side| placement.plane(side)).collect() }
    }

    /// Its faces above the ground, as polygons, counter-clockwise seen from outside, each with the number of its side.
    pub(super) fn faces(&self, ground: f64) -> Vec<(usize, Vec<Point3<f64>>)> {
        let floor = above(ground);
        let faces = self.sides.iter().enumerate().map(|(index, side)| {
            let others = self.sides.iter().enumerate().filter(|(other, _)| *other != index).map(|(_, plane)| plane);
            let face = others.chain([&floor]).fold(square(side), |face, plane| clip(&face, plane));
            (index, face)
        });
        faces.filter(|(_, face)| area(face) > LEAST_AREA).collect()
    }
}

/// A large square on a plane around the point nearest to the origin, counter-clockwise seen from the side of its normal.
fn square(plane: &Plane) -> Vec<Point3<f64>> {
    let normal = plane.normal.into_inner();
    let least = normal.iamin();
    let u = normal.cross(&Vector3::ith(least, 1.0)).normalize() * REACH;
    let v = normal.cross(&u);
    let centre = Point3::from(-normal * plane.offset);
    vec![centre - u - v, centre + u - v, centre + u + v, centre - u + v]
}

/// The part of a convex polygon on the negative side of a plane (Sutherland and Hodgman 1974).
fn clip(polygon: &[Point3<f64>], plane: &Plane) -> Vec<Point3<f64>> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (a, b) in polygon.iter().zip(polygon.iter().cycle().skip(1)) {
        let (from, to) = (plane.distance(a), plane.distance(b));
        if from <= 0.0 {
            kept.push(*a);
        }
        if (from <= 0.0) != (to <= 0.0) {
            kept.push(a + (b - a) * (from / (from - to)));
        }
    }
    kept
}

fn area(polygon: &[Point3<f64>]) -> f64 {
    let Some(first) = polygon.first() else { return 0.0 };
    let twice: Vector3<f64> = polygon.windows(2).map(|w| (w[0] - first).cross(&(w[1] - first))).sum();
    twice.norm() / 2.0
}

/// From the frame in which a building is drawn (its main ridge along x, the ground at 0) to its local frame.
#[derive(Debug, Clone)]
pub(super) struct Placement {
    plan: Matrix2<f64>,
    /// Transposed inverse of the linear part: what normals are mapped by.
    normals: Matrix3<f64>,
    shift: Vector3<f64>,
}

impl Placement {
    /// Shears the plan by `shear` (x grows by it for each unit of y), turns it by `angle` radians and shifts it.
    pub(super) fn new(shear: f64, angle: f64, shift: Vector3<f64>) -> Self {
        let (sin, cos) = angle.sin_cos();
        let plan = Matrix2::new(cos, -sin, sin, cos) * Matrix2::new(1.0, shear, 0.0, 1.0);
        // The inverse of a turn is its transpose; that of a shear has the opposite sign.
        let normals = Matrix2::new(cos, -sin, sin, cos) * Matrix2::new(1.0, 0.0, -shear, 1.0);
        let mut matrix = Matrix3::identity();
        matrix.fixed_view_mut::<2, 2>(0, 0).copy_from(&normals);
        Self { plan, normals: matrix, shift }
    }

    /// A place of the plan in the local frame.
    pub(super) fn place(&self, place: Point2<f64>) -> Point2<f64> {
        self.plan * place + self.shift.xy()
    }

    fn plane(&self, plane: &Plane) -> Plane {
        let (normal, length) = Unit::new_and_get(self.normals * plane.normal.into_inner());
        Plane { normal, offset: plane.offset / length - normal.dot(&self.shift) }
    }
}
