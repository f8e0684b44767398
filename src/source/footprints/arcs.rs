//! Circular arcs of databases (ISO/IEC 13249-3, `ST_CircularString`) as straight edges.

use geo::Coord;

use super::outline::Ring;

/// An edge lies within so many CRS units of its arc; and within [`RADIUS_SHARE`] of the radius, for units that are
/// large, degrees above all.
const TOLERANCE: f64 = 0.01;
/// See [`TOLERANCE`].
const RADIUS_SHARE: f64 = 1e-3;
/// No arc becomes more edges, whatever its radius.
const MOST_EDGES: f64 = 4096.0;

/// What is said of an outline that had arcs.
pub(super) fn note() -> String {
    format!("its arcs became straight edges, which lie within {TOLERANCE} units of them")
}

/// Appends the arcs through `control` to `ring`: start, a point on the way, end, a point on the way, end and so on. All
/// control points become vertices. Where the ring ends at the start already, it is not repeated.
///
/// # Errors
/// Their number is not that of a string of arcs.
pub(super) fn linearise(control: &[Coord<f64>], ring: &mut Ring) -> Result<(), String> {
    let Some(first) = control.first() else { return Ok(()) };
    if control.len() < 3 || control.len().is_multiple_of(2) {
        return Err(format!("a string of arcs has {} points, not an odd number from 3 on", control.len()));
    }
    if ring.last() != Some(first) {
        ring.push(*first);
    }
    for arc in control.windows(3).step_by(2) {
        append(arc[0], arc[1], arc[2], ring);
    }
    Ok(())
}

/// Appends the arc from `start` through `way` to `end`, without its start.
fn append(start: Coord<f64>, way: Coord<f64>, end: Coord<f64>, ring: &mut Ring) {
    if let Some(centre) = centre(start, way, end) {
        let angle = |c: Coord<f64>| (c.y - centre.y).atan2(c.x - centre.x);
        let (from, middle, to) = (angle(start), angle(way), angle(end));
        // Counter-clockwise turns to both, in [0, 2π).
        let turn = |angle: f64| (angle - from).rem_euclid(std::f64::consts::TAU);
        let (to_way, to_end) = (turn(middle), turn(to));
        let is_clockwise = start != end && to_way > to_end;
        let halves = if start == end {
            [std::f64::consts::PI; 2]
        } else if is_clockwise {
            [to_way - std::f64::consts::TAU, to_end - to_way]
        } else {
            [to_way, to_end - to_way]
        };
        sweep(centre, start, halves[0], ring);
        ring.push(way);
        sweep(centre, way, halves[1], ring);
    } else {
        ring.push(way);
    }
    ring.push(end);
}

/// Appends what lies between the ends of the arc that turns `start` around `centre` by `angle` (radians).
fn sweep(centre: Coord<f64>, start: Coord<f64>, angle: f64, ring: &mut Ring) {
    let arm = start - centre;
    let radius = arm.x.hypot(arm.y);
    let sagitta = TOLERANCE.min(RADIUS_SHARE * radius);
    let step = 2.0 * (1.0 - sagitta / radius).acos();
    let edges = (angle.abs() / step).ceil().clamp(1.0, MOST_EDGES);
    for i in 1..edges as u32 {
        let (sin, cos) = (angle * f64::from(i) / edges).sin_cos();
        ring.push(Coord { x: centre.x + arm.x * cos - arm.y * sin, y: centre.y + arm.x * sin + arm.y * cos });
    }
}

/// The centre of the circle through three points; of a whole circle, whose ends are one, the middle of the other two.
/// `None` where they lie on a line.
fn centre(a: Coord<f64>, b: Coord<f64>, c: Coord<f64>) -> Option<Coord<f64>> {
    if a == c {
        return (a != b).then(|| (a + b) / 2.0);
    }
    // Relative to the first point: large coordinates would take all digits away.
    let (b, c) = (b - a, c - a);
    let cross = 2.0 * (b.x * c.y - b.y * c.x);
    let (bb, cc) = (b.x * b.x + b.y * b.y, c.x * c.x + c.y * c.y);
    let offset = Coord { x: (c.y * bb - b.y * cc) / cross, y: (b.x * cc - c.x * bb) / cross };
    let radius = offset.x.hypot(offset.y);
    // Flatter than that is straight: the arc stays within the tolerance of its chord.
    (radius.is_finite() && radius > 0.0 && bb.max(cc) / (8.0 * radius) > 1e-9 * radius.min(1.0)).then_some(a + offset)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f64, y: f64) -> Coord<f64> {
        Coord { x, y }
    }

    /// The area that a ring encloses.
    fn area(ring: &[Coord<f64>]) -> f64 {
        ring.windows(2).map(|e| e[0].x * e[1].y - e[1].x * e[0].y).sum::<f64>() / 2.0
    }

    #[test]
    fn arcs_stay_within_the_tolerance_in_either_direction() {
        let far = at(85_000.0, 446_000.0);
        for (way, end, signed) in [(at(0.0, 5.0), at(-5.0, 0.0), 1.0), (at(0.0, -5.0), at(-5.0, 0.0), -1.0)] {
            let mut ring = vec![at(5.0, 0.0) + far];
            linearise(&[ring[0], way + far, end + far], &mut ring).unwrap();
            assert!(ring.contains(&(way + far)) && ring.last() == Some(&(end + far)));
            for edge in ring.windows(2) {
                let middle = (edge[0] + edge[1]) / 2.0 - far;
                assert!(5.0 - middle.x.hypot(middle.y) <= TOLERANCE, "{middle:?}");
                let vertex = edge[1] - far;
                assert!((vertex.x.hypot(vertex.y) - 5.0).abs() < 1e-6);
            }
            ring.push(ring[0]);
            let half_disk = std::f64::consts::PI * 12.5;
            assert!((area(&ring.iter().map(|c| *c - far).collect::<Vec<_>>()) * signed - half_disk).abs() < 0.1);
        }
    }

    #[test]
    fn a_whole_circle_and_a_straight_one() {
        let mut ring = Ring::new();
        linearise(&[at(0.0, 0.0), at(2e-4, 0.0), at(0.0, 0.0)], &mut ring).unwrap();
        assert!((area(&ring).abs() / (std::f64::consts::PI * 1e-8) - 1.0).abs() < 0.01, "in degrees, too");
        let mut ring = Ring::new();
        linearise(&[at(0.0, 0.0), at(5.0, 0.0), at(10.0, 0.0)], &mut ring).unwrap();
        assert_eq!(ring, [at(0.0, 0.0), at(5.0, 0.0), at(10.0, 0.0)]);
        let mut ring = Ring::new();
        linearise(&[at(0.0, 0.0), at(1e9, 1.0), at(-1e9, 1.0)], &mut ring).unwrap();
        assert!(ring.len() < 10_000);
    }

    #[test]
    fn an_even_number_is_refused() {
        assert!(linearise(&[at(0.0, 0.0), at(1.0, 0.0)], &mut Ring::new()).unwrap_err().contains("2 points"));
        assert_eq!(linearise(&[], &mut Ring::new()), Ok(()));
    }
}
