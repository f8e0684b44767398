//! What has become of a building between two surveys: built, torn down, raised or lowered.
//!
//! Both clouds are held against each other in cells of one metre. A cell has changed where the middle of what one cloud saw
//! lies beyond all that the other saw within a cell of it, and the other way round, by more than a tolerance: three standard
//! deviations of the noise of both clouds together, and never less than 0.3 m, so that a shift of a decimetre between the
//! surveys is none; so have those beside such a cell whose middles differ by more than the tolerance. Where only the ground was seen, there is no building. A building has changed where that is so of a tenth
//! of what both saw, and of four square metres at least.

use std::collections::BTreeMap;

use nalgebra::{Matrix3, Point3, Vector3};

use crate::geometry::PreparedPolygon;
use crate::record::{Change, Mutation};
use crate::site::Site;

/// Side of the cells, metres.
const CELL: f64 = 1.0;
/// Heights that differ by less are the same, metres.
const LEAST: f64 = 0.3;
/// So many standard deviations of the noise are noise.
const DEVIATIONS: f64 = 3.0;
/// A cell with fewer points tells nothing of the noise.
const FEWEST_OF_NOISE: usize = 5;
/// What both clouds saw must be so much of the footprint to tell anything.
const LEAST_SEEN: f64 = 0.3;
/// A building has changed where so much of it has,
const LEAST_SHARE: f64 = 0.1;
/// and so many square metres.
const LEAST_AREA: f64 = 4.0;

/// What one cloud saw of a cell.
#[derive(Debug, Clone, Copy)]
struct Seen {
    low: f64,
    middle: f64,
    high: f64,
    is_ground: bool,
}

/// What one cloud saw of a building.
struct Survey {
    cells: BTreeMap<[i64; 2], Seen>,
    /// Standard deviation of the points about the planes of the cells, metres.
    noise: f64,
}

/// What has become of a building between `before` and `after`, two clouds of the same footprint in the same frame; `None`
/// where they do not tell.
pub fn between(before: &Site, after: &Site) -> Option<Change> {
    let footprint = after.footprint.as_ref()?;
    let prepared = PreparedPolygon::new(footprint);
    let [old, new] = [before, after].map(|site| Survey::of(site, &prepared));
    let area = geo::Area::unsigned_area(footprint);
    let tolerance = LEAST.max(DEVIATIONS * (old.noise.powi(2) + new.noise.powi(2)).sqrt());
    let mut seen = 0_usize;
    let mut core: BTreeMap<[i64; 2], (Seen, Seen)> = BTreeMap::new();
    let mut others: BTreeMap<[i64; 2], (Seen, Seen)> = BTreeMap::new();
    for (cell, of_new) in &new.cells {
        let Some(of_old) = old.cells.get(cell) else { continue };
        seen += 1;
        let is_beyond = |one: &Seen, other: &Survey| {
            let [low, high] = other.around(*cell);
            one.middle < low - tolerance || one.middle > high + tolerance
        };
        let list = if is_beyond(of_new, &old) && is_beyond(of_old, &new) { &mut core } else { &mut others };
        list.insert(*cell, (*of_old, *of_new));
    }
    // At its edge a part that has changed is beside one that has not.
    let is_beside = |cell: &[i64; 2]| beside(*cell).any(|other| core.contains_key(&other));
    let rim = others.iter().filter(|(cell, (old, new))| (new.middle - old.middle).abs() > tolerance && is_beside(cell));
    let changed: Vec<(Seen, Seen)> = core.values().chain(rim.map(|(_, seen)| seen)).copied().collect();
    let [seen_area, changed_area] = [seen, changed.len()].map(|cells| cells as f64 * CELL * CELL);
    if seen_area < LEAST_SEEN * area {
        return None;
    }
    let has_changed = changed_area >= LEAST_AREA.max(LEAST_SHARE * seen_area);
    let mutation = has_changed.then(|| {
        let most =
            |is_so: &dyn Fn(&(Seen, Seen)) -> bool| 2 * changed.iter().filter(|one| is_so(one)).count() > changed.len();
        if most(&|(old, new)| old.is_ground && !new.is_ground) {
            Mutation::Built
        } else if most(&|(old, new)| !old.is_ground && new.is_ground) {
            Mutation::TornDown
        } else if most(&|(old, new)| new.middle > old.middle) {
            Mutation::Raised
        } else {
            Mutation::Lowered
        }
    });
    Some(Change { mutation, area: changed_area, tolerance, since: None })
}

impl Survey {
    fn of(site: &Site, footprint: &PreparedPolygon) -> Self {
        let cell_of = |p: &Point3<f64>| [p.x, p.y].map(|c| (c / CELL).floor() as i64);
        let mut points: BTreeMap<[i64; 2], Vec<Point3<f64>>> = BTreeMap::new();
        for point in site.points.iter().filter(|p| footprint.contains([p.x, p.y])) {
            points.entry(cell_of(point)).or_default().push(*point);
        }
        let mut noises: Vec<f64> = points.values().filter_map(|points| noise(points)).collect();
        let noise = middle(&mut noises).unwrap_or(0.0);
        let mut ground: BTreeMap<[i64; 2], Vec<f64>> = BTreeMap::new();
        for point in site.ground_points.iter().filter(|p| footprint.contains([p.x, p.y])) {
            ground.entry(cell_of(point)).or_default().push(point.z);
        }
        let seen = |heights: &mut Vec<f64>, is_ground: bool| {
            let middle = middle(heights)?;
            Some(Seen { low: *heights.first()?, middle, high: *heights.last()?, is_ground })
        };
        let grounds = ground.into_iter().filter_map(|(cell, mut heights)| Some((cell, seen(&mut heights, true)?)));
        let mut cells: BTreeMap<[i64; 2], Seen> = grounds.collect();
        for (cell, points) in points {
            let mut heights: Vec<f64> = points.iter().map(|p| p.z).collect();
            cells.extend(seen(&mut heights, false).map(|seen| (cell, seen)));
        }
        Self { cells, noise }
    }

    /// The lowest and the highest that was seen in a cell and the eight around it.
    fn around(&self, cell: [i64; 2]) -> [f64; 2] {
        let cells = beside(cell).filter_map(|cell| self.cells.get(&cell));
        cells.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], seen| [low.min(seen.low), high.max(seen.high)])
    }
}

/// A cell and the eight around it.
fn beside([x, y]: [i64; 2]) -> impl Iterator<Item = [i64; 2]> {
    (-1..=1).flat_map(move |dx| (-1..=1).map(move |dy| [x + dx, y + dy]))
}

/// The median of some values, which are sorted; `None` without any.
fn middle(values: &mut [f64]) -> Option<f64> {
    values.sort_unstable_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

/// Standard deviation of the heights of some points about the plane through them, metres; `None` of too few, or of points
/// on a line.
fn noise(points: &[Point3<f64>]) -> Option<f64> {
    if points.len() < FEWEST_OF_NOISE {
        return None;
    }
    let centre = points.iter().map(|p| p.coords).sum::<Vector3<f64>>() / points.len() as f64;
    let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
    let rows = || points.iter().map(|p| (Vector3::new(p.x - centre.x, p.y - centre.y, 1.0), p.z - centre.z));
    for (row, z) in rows() {
        normal += row * row.transpose();
        right += row * z;
    }
    let plane = normal.try_inverse()? * right;
    let squares: f64 = rows().map(|(row, z)| (z - row.dot(&plane)).powi(2)).sum();
    Some((squares / (points.len() - 3) as f64).sqrt())
}

#[cfg(test)]
mod tests {
    use geo::{MultiPolygon, polygon};

    use super::*;
    use crate::geometry::Random;
    use crate::site::Frame;

    /// A footprint of 12 m by 10 m with points at these heights, ground where there is none, at a spacing and with noise.
    fn survey(seed: u64, spacing: f64, noise: f64, height: impl Fn(f64, f64) -> Option<f64>) -> Site {
        let mut random = Random::new(seed);
        let (mut points, mut ground) = (Vec::new(), Vec::new());
        let [columns, rows] = [12.0, 10.0].map(|length: f64| (length / spacing) as u32);
        for (i, j) in (0..columns).flat_map(|i| (0..rows).map(move |j| (i, j))) {
            let [x, y] = [i, j].map(|k| (f64::from(k) + random.between(0.05, 0.95)) * spacing);
            let z = height(x, y);
            let list = if z.is_some() { &mut points } else { &mut ground };
            list.push(Point3::new(x, y, z.unwrap_or(0.0) + noise * random.bell()));
        }
        let footprint = polygon![(x: 0.0, y: 0.0), (x: 12.0, y: 0.0), (x: 12.0, y: 10.0), (x: 0.0, y: 10.0)];
        let frame = Frame { origin: [0.0; 3], metres_per_unit: [1.0; 3] };
        let site = Site::new("house", frame, points, 0.0).with_footprint(&MultiPolygon(vec![footprint]));
        Site { ground_points: ground, ..site }
    }

    fn gable(y: f64) -> f64 {
        9.0 - (y - 5.0).abs()
    }

    fn gabled(seed: u64, spacing: f64, noise: f64) -> Site {
        survey(seed, spacing, noise, |_, y| Some(gable(y)))
    }

    fn found(before: &Site, after: &Site) -> Option<Mutation> {
        between(before, after).expect("both tell").mutation
    }

    #[test]
    fn another_survey_of_the_same_roof_is_no_change() {
        for (seed, spacing, noise) in [(1, 0.3, 0.02), (2, 0.7, 0.05), (3, 0.5, 0.3)] {
            let before = gabled(10 + seed, 0.4, 0.03);
            // The surveys are a decimetre apart as well.
            let after = survey(seed, spacing, noise, |_, y| Some(gable(y) + 0.1));
            assert_eq!(found(&before, &after), None, "spacing {spacing}, noise {noise}");
        }
        let part = |x: f64, y: f64| Some(if x < 1.5 && y < 1.5 { 14.0 } else { gable(y) });
        assert_eq!(found(&gabled(1, 0.4, 0.03), &survey(2, 0.4, 0.03, part)), None, "a chimney");
    }

    #[test]
    fn what_became_of_a_building_is_told() {
        let (house, empty) = (gabled(1, 0.5, 0.03), survey(2, 0.5, 0.03, |_, _| None));
        assert_eq!(found(&empty, &house), Some(Mutation::Built));
        assert_eq!(found(&house, &empty), Some(Mutation::TornDown));
        // A storey more on a third of it.
        let storey = survey(3, 0.5, 0.03, |x, y| Some(if x < 4.0 { 12.0 } else { gable(y) }));
        assert_eq!(found(&house, &storey), Some(Mutation::Raised));
        assert_eq!(found(&storey, &house), Some(Mutation::Lowered));
        let change = between(&house, &storey).unwrap();
        assert!((change.area - 40.0).abs() < 4.0 && change.tolerance == LEAST, "{change:?}");
        // What one of them hardly saw cannot be told.
        let glimpse = gabled(4, 0.5, 0.03);
        let few = Site { points: glimpse.points.into_iter().filter(|p| p.x < 2.0).collect(), ..house.clone() };
        assert_eq!(between(&house, &few), None);
    }

    #[test]
    fn noise_widens_the_tolerance() {
        let before = gabled(1, 0.4, 0.3);
        let after = survey(2, 0.4, 0.3, |_, y| Some(gable(y) + 0.5));
        let change = between(&before, &after).unwrap();
        assert!(change.tolerance > 0.9 && change.mutation.is_none(), "{change:?}");
        let quiet = [1, 2].map(|seed| survey(seed, 0.3, 0.02, |_, _| Some(if seed == 1 { 6.0 } else { 6.5 })));
        assert_eq!(found(&quiet[0], &quiet[1]), Some(Mutation::Raised));
    }
}
