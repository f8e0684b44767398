//! The exact predicates: where three planes meet, and on which side of a plane that is.
//!
//! # Why nothing overflows
//!
//! Normals have components of at most 2²⁰ and offsets of at most √3 · 2³⁴ · (1 + 2⁻²⁰) < 2³⁵ ([`IntegerPlane::snap`]
//! accepts 2¹⁴ m and multiplies by the length of the normal, at most √3 · 2²⁰; in truth it is 2²⁰ + 1).
//!
//! | value | bound | type |
//! |---|---|---|
//! | 2×2 minor of normals | 2 · 2⁴⁰ = 2⁴¹ | `i64` |
//! | `w`, 3×3 determinant of normals, and its partial sums | 3 · 2⁶¹ < 2⁶³ | `i64` |
//! | `x`, `y`, `z` before reduction | 3 · 2³⁵ · 2⁴¹ < 2⁷⁸ | `i128` |
//! | the side `a x + b y + c z + d w` | 3 · 2²⁰ · 2⁷⁸ + 2³⁵ · 2⁶³ < 2¹⁰⁰ | `i128` |
//! | order of two coordinates, after the whole metres are taken off | 2⁶³ · 2⁶³ = 2¹²⁶ | `i128` |

use std::cmp::Ordering;

use nalgebra::Point3;

use super::plane::gcd;
use super::{IntegerPlane, Vertex};

/// Bound of the relative error of the floating-point side test, of the sum of the absolute values of its terms.
///
/// A position carries three roundings (two conversions, one division), each product one, the sums three: less than
/// 8 · 2⁻⁵³ = 2⁻⁵⁰. Doubled to cover the products of these errors and the roundings of the bound itself.
const FILTER: f64 = 1.0 / (1_u64 << 49) as f64;

impl Vertex {
    /// The point where three planes meet; `None` when they have no single point in common.
    pub fn meet(planes: [&IntegerPlane; 3]) -> Option<Self> {
        let [p, q, r] = planes;
        let qr = cross(&q.normal, &r.normal);
        let w = dot(&p.normal, &qr);
        if w == 0 {
            return None;
        }
        let rp = cross(&r.normal, &p.normal);
        let pq = cross(&p.normal, &q.normal);
        // Cramer: x = −(d₁ n₂×n₃ + d₂ n₃×n₁ + d₃ n₁×n₂) / w.
        let sign = if w < 0 { 1 } else { -1 };
        let numerator = |axis: usize| {
            sign * (i128::from(p.offset) * i128::from(qr[axis])
                + i128::from(q.offset) * i128::from(rp[axis])
                + i128::from(r.offset) * i128::from(pq[axis]))
        };
        Some(Self::new([numerator(0), numerator(1), numerator(2)], w.unsigned_abs()))
    }

    /// The point `numerators / w` in canonical form.
    fn new(numerators: [i128; 3], w: u64) -> Self {
        // The divisor divides w, which is small: one long division each, the rest in 64 bits, and usually 1 at once.
        let mut divisor = w;
        for n in numerators {
            if divisor == 1 {
                break;
            }
            divisor = gcd(divisor, (n.unsigned_abs() % u128::from(divisor)) as u64);
        }
        let [x, y, z] = if divisor == 1 { numerators } else { numerators.map(|n| n / i128::from(divisor)) };
        let w = w / divisor;
        let scale = w as f64;
        let position = Point3::new(x as f64 / scale, y as f64 / scale, z as f64 / scale);
        Self { homogeneous: [x, y, z, i128::from(w)], position }
    }

    /// The order of two vertices by x, then y, then z, exactly. Along a line it is the order on that line.
    pub fn order(&self, other: &Self) -> Ordering {
        let (p, q) = (&self.homogeneous, &other.homogeneous);
        (0..3).map(|axis| ratio_order(p[axis], p[3], q[axis], q[3])).find(|o| o.is_ne()).unwrap_or(Ordering::Equal)
    }
}

impl IntegerPlane {
    /// On which side of the plane a vertex lies, exactly: `Greater` on the side of the normal, `Equal` on the plane.
    pub fn side(&self, vertex: &Vertex) -> Ordering {
        let p = &vertex.position;
        let terms =
            [self.normal[0] as f64 * p.x, self.normal[1] as f64 * p.y, self.normal[2] as f64 * p.z, self.offset as f64];
        let value = terms[0] + terms[1] + terms[2] + terms[3];
        let bound = FILTER * (terms[0].abs() + terms[1].abs() + terms[2].abs() + terms[3].abs());
        if value > bound {
            return Ordering::Greater;
        }
        if value < -bound {
            return Ordering::Less;
        }
        let [x, y, z, w] = vertex.homogeneous;
        let exact = i128::from(self.normal[0]) * x
            + i128::from(self.normal[1]) * y
            + i128::from(self.normal[2]) * z
            + i128::from(self.offset) * w;
        exact.cmp(&0)
    }
}

/// The sign of the determinant of three normals, exactly.
pub(super) fn orientation(planes: [&IntegerPlane; 3]) -> Ordering {
    let [p, q, r] = planes;
    dot(&p.normal, &cross(&q.normal, &r.normal)).cmp(&0)
}

fn cross(a: &[i64; 3], b: &[i64; 3]) -> [i64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: &[i64; 3], b: &[i64; 3]) -> i64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The order of `a / v` and `b / w` for positive `v` and `w`.
fn ratio_order(a: i128, v: i128, b: i128, w: i128) -> Ordering {
    // The products of the numerators would need 141 bits; those of the remainders need 126.
    a.div_euclid(v).cmp(&b.div_euclid(w)).then_with(|| (a.rem_euclid(v) * w).cmp(&(b.rem_euclid(w) * v)))
}
