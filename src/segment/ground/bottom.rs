//! The lower end of an object's points, where nothing else tells of its floor.
//!
//! Heights near the lower end come from walls, evenly, and from the floor, all at one height, where it was scanned; noise smears
//! both. What lies below the floor is noise.

use super::percentile;

/// Share of the points that may lie below the end, per cent: wrong ones.
const BELOW: f64 = 0.5;
/// A floor that was scanned with little noise shows as a layer: of so many times the points of the next one above …
const LAYER: usize = 2;
/// … and so many times those below it …
const LAYER_BELOW: usize = 2;
/// … with at least this share of all points, one in so many.
const LEAST_SHARE: usize = 50;
/// Thicknesses of a layer that are tried: shares of the whole height, thin ones first.
const THICKNESSES: [f64; 3] = [0.005, 0.01, 0.02];
/// Thinner layers are not told apart, metres.
const LEAST_THICKNESS: f64 = 0.02;
/// Fewer points than this tell no noise.
const FEWEST: usize = 200;
/// Cells in which heights are counted, over the lower half of the whole height.
const CELLS: usize = 64;
/// Standard deviations of noise that are tried, as shares of the whole height …
const NOISES: [f64; 9] = [0.01, 0.02, 0.03, 0.045, 0.06, 0.08, 0.1, 0.13, 0.17];
/// … and, around the best of them, as shares of it.
const FINER_NOISES: [f64; 5] = [0.7, 0.85, 1.0, 1.2, 1.4];
/// Heights of the floor that are tried over these cells, and around the best of them.
const HEIGHTS: [usize; 2] = [46, 11];
/// Share of the points that may be wrong anywhere.
const WRONG: f64 = 1e-3;
/// Rounds in which the shares of floor and walls settle.
const ROUNDS: usize = 30;

/// Where points with these sorted heights begin, of which one in two hundred may be wrong; `None` without points.
pub(super) fn first(sorted: &[f64]) -> Option<f64> {
    sorted.first().map(|_| percentile(sorted, BELOW))
}

/// The floor of an object that was scanned from around, by the sorted heights of its points; `None` without points.
///
/// Where there is a thin layer at the lower end, its middle: the floor was scanned, with little noise. Else the height, the
/// noise and the shares of floor and walls are found under which the heights of the lower half are the most likely.
pub(super) fn of_object(sorted: &[f64]) -> Option<f64> {
    let (low, high) = (percentile(sorted, BELOW), percentile(sorted, 100.0 - BELOW));
    let thin = |share: &f64| layer(sorted, (share * (high - low)).max(LEAST_THICKNESS));
    THICKNESSES.iter().find_map(thin).or_else(|| smeared(sorted)).or_else(|| first(sorted))
}

/// The middle of the layer of this thickness that has the most points, if that is one.
fn layer(sorted: &[f64], thickness: f64) -> Option<f64> {
    let up_to = |height: f64| sorted.partition_point(|z| *z <= height);
    let half = 0.5 * (sorted.first()? + sorted.last()?);
    let count = |from: usize| up_to(sorted[from] + thickness) - from;
    let from = (0..up_to(half)).max_by(|a, b| count(*a).cmp(&count(*b)).then(b.cmp(a)))?;
    let own = count(from);
    let above = up_to(sorted[from] + 2.0 * thickness) - from - own;
    let is_layer = own >= LAYER * above && own >= LAYER_BELOW * from && own * LEAST_SHARE >= sorted.len() && own >= 3;
    is_layer.then(|| percentile(&sorted[from..from + own], 50.0))
}

/// Heights counted in cells of a width.
struct Counts {
    low: f64,
    width: f64,
    of_cell: [f64; CELLS],
}

/// The most likely height of the floor under noise; `None` where there are too few points.
fn smeared(sorted: &[f64]) -> Option<f64> {
    let (low, high) = (percentile(sorted, 0.1), percentile(sorted, 100.0 - BELOW));
    let whole = high - low;
    let counts = Counts::of(sorted, low, 0.5 * whole / CELLS as f64).filter(|_| sorted.len() >= FEWEST)?;
    let best = |noises: &[f64], heights: &dyn Fn(usize) -> f64, count: usize| {
        let tried = noises.iter().flat_map(|noise| (0..count).map(|step| (heights(step), *noise)));
        let rated = tried.map(|(height, noise)| (counts.likelihood(height, noise), height, noise));
        rated.max_by(|a, b| a.0.total_cmp(&b.0))
    };
    let (_, height, noise) =
        best(&NOISES.map(|share| share * whole), &|step| low + 0.01 * whole * step as f64, HEIGHTS[0])?;
    let around = |step: usize| height + 0.002 * whole * (step as f64 - (HEIGHTS[1] / 2) as f64);
    best(&FINER_NOISES.map(|share| share * noise), &around, HEIGHTS[1]).map(|(_, height, _)| height)
}

impl Counts {
    fn of(sorted: &[f64], low: f64, width: f64) -> Option<Self> {
        if width.is_nan() || width <= 0.0 {
            return None;
        }
        let mut of_cell = [0.0; CELLS];
        for cell in sorted.iter().map(|z| (z - low) / width).filter(|cell| (0.0..CELLS as f64).contains(cell)) {
            of_cell[cell as usize] += 1.0;
        }
        Some(Self { low, width, of_cell })
    }

    /// The logarithm of how likely these counts are with the floor at `height` and this standard deviation of noise, the
    /// shares of floor, walls and wrong points being the most likely ones.
    fn likelihood(&self, height: f64, noise: f64) -> f64 {
        let total: f64 = self.of_cell.iter().sum();
        let off = |cell: usize| ((self.low + (cell as f64 + 0.5) * self.width - height) / noise).clamp(-8.0, 8.0);
        let density = self.width / (noise * std::f64::consts::TAU.sqrt());
        let floor: [f64; CELLS] = std::array::from_fn(|cell| density * (-0.5 * off(cell).powi(2)).exp());
        let walls: [f64; CELLS] = std::array::from_fn(|cell| share_below(off(cell)));
        let wrong = WRONG * total / CELLS as f64;
        let sums = [floor, walls].map(|of| of.iter().sum::<f64>().max(1e-9));
        let mut parts = [0.3 * total, 0.7 * total / CELLS as f64];
        let expected = |parts: [f64; 2], cell: usize| parts[0] * floor[cell] + parts[1] * walls[cell] + wrong;
        for _ in 0..ROUNDS {
            let mut taken = [0.0; 2];
            for cell in 0..CELLS {
                let ratio = self.of_cell[cell] / expected(parts, cell).max(f64::MIN_POSITIVE);
                taken[0] += ratio * floor[cell];
                taken[1] += ratio * walls[cell];
            }
            parts = std::array::from_fn(|part| parts[part] * taken[part] / sums[part]);
        }
        (0..CELLS)
            .map(|cell| {
                let expected = expected(parts, cell).max(f64::MIN_POSITIVE);
                self.of_cell[cell] * expected.ln() - expected
            })
            .sum()
    }
}

/// The share of a normal distribution below so many standard deviations, to 2 · 10⁻⁴.
fn share_below(off: f64) -> f64 {
    1.0 / (1.0 + (-1.5976 * off - 0.070_56 * off.powi(3)).exp())
}

#[cfg(test)]
mod tests {
    use super::super::fit::tests::normal;
    use super::*;
    use crate::geometry::Random;

    /// Heights of a house of 10 m × 10 m × 6 m, its roof flat, with or without its floor scanned.
    fn house(noise: f64, has_floor: bool) -> Vec<f64> {
        let mut random = Random::new(11);
        let mut heights: Vec<f64> = (0..4800).map(|_| random.between(0.0, 6.0)).collect();
        heights.extend(std::iter::repeat_n(6.0, 2000));
        heights.extend(std::iter::repeat_n(0.0, if has_floor { 2000 } else { 0 }));
        for z in &mut heights {
            *z += noise * normal(&mut random);
        }
        heights.sort_unstable_by(f64::total_cmp);
        heights
    }

    #[test]
    fn a_scanned_floor_is_the_end_whatever_the_noise() {
        for (noise, most) in [(0.0, 0.02), (0.02, 0.02), (0.15, 0.03), (0.7, 0.2)] {
            let found = of_object(&house(noise, true)).unwrap();
            assert!(found.abs() < most, "noise {noise}: {found}");
        }
    }

    #[test]
    fn without_a_floor_it_is_where_the_points_begin() {
        for (noise, most) in [(0.0, 0.15), (0.02, 0.15), (0.15, 0.3), (0.7, 0.9)] {
            let mut heights = house(noise, false);
            heights[0] = -9.0;
            let found = of_object(&heights).unwrap();
            assert!(found.abs() < most, "noise {noise}: {found}");
        }
        assert_eq!((of_object(&[]), first(&[])), (None, None));
        assert_eq!((of_object(&[3.0]), first(&[3.0])), (Some(3.0), Some(3.0)));
        assert_eq!(of_object(&[3.0; 500]), Some(3.0));
    }
}
