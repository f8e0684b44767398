//! The foot of the walls, where no ground was scanned: from the lowest points on them.
//!
//! The heights of the points of a wall are random between its foot and the eaves. So the lowest of them lies above the
//! foot by about as much as they lie apart, and the foot is estimated below it by that.

use crate::geometry::PreparedPolygon;

/// Points this far inside the outline are of the roof, metres …
const INSIDE: f64 = 0.75;
/// … and below their low end by so much are those of walls, metres: a roof of 45° falls as far to its eaves.
const BELOW_ROOF: f64 = 1.0;
/// Share of the roof points that may lie lower, per cent: wrong ones.
const LOW_END: f64 = 2.0;
/// So many of the lowest points tell how far they lie apart.
const LOWEST: usize = 12;
/// Fewer wall points than this are no wall …
const FEWEST: usize = 2;
/// … nor are those of which less than this was seen below the roof, metres …
const LEAST_SEEN: f64 = 1.0;
/// … nor those of which the lowest lie so many times closer together than all of them: they are of a low roof.
const LAYER: f64 = 4.0;
/// The lowest of several points is so many spacings above the foot in half of all cases.
const MEDIAN_GAP: f64 = std::f64::consts::LN_2;
/// A lowest point below the next by more than so many spacings (one in a thousand) is wrong …
const WRONG_GAP: f64 = 6.9;
/// … if that is more than this, metres.
const LEAST_WRONG_GAP: f64 = 0.5;
/// One in so many of the wall points may be wrong …
const WRONG: usize = 20;
/// … and one in so many lies below the foot by its noise: where there are as many, the next one counts as the lowest.
const NOISY: usize = 100;

/// What the points of walls tell of their foot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Feet {
    /// Height of the foot, local metres.
    pub height: f64,
    /// The lowest point of a wall: the foot is not above it.
    pub lowest: f64,
    /// How far the lowest points lie apart in height, metres: what the height is unsure by.
    pub spacing: f64,
    /// Whether they are points of walls for all that is known.
    pub is_wall: bool,
}

/// The foot of the walls of the building whose outline this is: `points` lie inside, sorted or not, `beside` around it; local
/// metres. `None` where no wall was seen.
///
/// Wall points are those a metre lower than the low end of the roof. Of n of them, let the lowest be z₁ and the 13th z₁₃, or
/// where there are fewer the height below which they are taken for wall points: they are d = (z₁₃ − z₁) / 12 apart, or this
/// height less z₁ by n, and the foot is at z₁ − d ln 2, as often too high as too low. A lowest point that is too far below
/// the next is left out. Where the lowest ones lie in a layer there is a low roof, and what stands below it
/// is not known.
pub(super) fn of(outline: &PreparedPolygon, points: &[[f64; 3]], beside: &[[f64; 3]]) -> Option<Feet> {
    let is_roof = |p: &&[f64; 3]| outline.boundary_distance([p[0], p[1]], INSIDE) >= INSIDE;
    let mut roof: Vec<f64> = points.iter().filter(is_roof).map(|p| p[2]).collect();
    if roof.is_empty() {
        return None;
    }
    roof.sort_unstable_by(f64::total_cmp);
    let top = super::percentile(&roof, LOW_END) - BELOW_ROOF;
    let mut walls: Vec<f64> = points.iter().chain(beside).map(|p| p[2]).filter(|z| *z < top).collect();
    walls.sort_unstable_by(f64::total_cmp);
    from_heights(&walls, top)
}

/// The foot from the sorted heights of wall points below `top`.
fn from_heights(walls: &[f64], top: f64) -> Option<Feet> {
    let mut walls = walls;
    for _ in 0..walls.len() / WRONG {
        let (lowest, rest) = walls.split_first()?;
        if rest.first()? - lowest <= LEAST_WRONG_GAP.max(WRONG_GAP * spacing(rest, top)) {
            break;
        }
        walls = rest;
    }
    // Where there are many, the lowest of all lies below the foot by the noise.
    let below = walls.len() / NOISY;
    let (lowest, spacing) = (*walls.get(below)?, spacing(&walls[below..], top));
    let seen = top - lowest;
    let is_layer = LAYER * spacing < seen / walls.len() as f64;
    let is_wall = walls.len() >= FEWEST && seen >= LEAST_SEEN && !is_layer;
    Some(Feet { height: lowest - (MEDIAN_GAP + below as f64) * spacing, lowest, spacing, is_wall })
}

/// How far the lowest of sorted heights below `top` lie apart.
fn spacing(walls: &[f64], top: f64) -> f64 {
    let count = walls.len().min(LOWEST);
    let end = walls.get(LOWEST).copied().unwrap_or(top);
    walls.first().map_or(f64::INFINITY, |lowest| (end - lowest) / count as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Random;
    use geo::{MultiPolygon, polygon};

    /// Median error of the foot of walls 5 m high, of which `count` points are seen below a flat roof.
    fn median_error(count: usize, noise: f64) -> f64 {
        let square = polygon![(x: 0.0, y: 0.0), (x: 10.0, y: 0.0), (x: 10.0, y: 10.0), (x: 0.0, y: 10.0)];
        let outline = PreparedPolygon::new(&MultiPolygon(vec![square]));
        let mut errors: Vec<f64> = (0..99)
            .map(|seed| {
                let mut random = Random::new(seed);
                let mut points: Vec<[f64; 3]> =
                    (0..500).map(|_| [random.between(0.0, 10.0), random.between(0.0, 10.0), 5.0]).collect();
                points.extend((0..count).map(|_| [random.between(0.0, 10.0), 0.01, random.between(0.0, 5.0)]));
                for p in &mut points {
                    p[2] += noise * (random.unit() - 0.5);
                }
                of(&outline, &points, &[]).map_or(f64::INFINITY, |feet| feet.height.abs())
            })
            .collect();
        errors.sort_by(f64::total_cmp);
        errors[errors.len() / 2]
    }

    #[test]
    fn the_foot_is_as_sure_as_the_points_are_dense() {
        for (count, most) in [(200, 0.03), (50, 0.08), (12, 0.35), (5, 0.8)] {
            let error = median_error(count, 0.05);
            assert!(error < most, "{count} points: {error}");
        }
        assert_eq!(median_error(0, 0.05), f64::INFINITY);
    }

    #[test]
    fn a_point_below_the_ground_is_no_foot() {
        let heights: Vec<f64> = std::iter::once(-7.0).chain((0..60).map(|i| f64::from(i) * 0.05)).collect();
        let feet = from_heights(&heights, 4.0).unwrap();
        assert!(feet.lowest == 0.0 && (-0.06..0.0).contains(&feet.height), "{feet:?}");
        assert_eq!(from_heights(&[], 4.0), None);
        assert!(!from_heights(&[1.0], 4.0).unwrap().is_wall);
    }

    #[test]
    fn a_low_roof_is_no_wall() {
        let mut heights: Vec<f64> = (0..40).map(|i| 3.0 + f64::from(i % 5) * 0.01).collect();
        heights.extend((0..20).map(|i| 3.1 + f64::from(i) * 0.2));
        heights.sort_unstable_by(f64::total_cmp);
        assert!(!from_heights(&heights, 7.2).unwrap().is_wall);
        assert!(!from_heights(&[3.0, 3.1, 3.2, 3.3], 3.5).unwrap().is_wall);
    }
}
