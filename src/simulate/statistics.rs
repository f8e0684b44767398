//! What scans look like, real ones beside virtual ones: what differs is what a network learns wrongly.

use std::fmt::Write as _;

use nalgebra::Point3;
use rayon::prelude::*;

use super::model::Model;
use super::options::ScanOptions;
use super::plan::Plan;
use super::random::hash;
use super::real::RealSite;
use super::scan::scan;
use crate::reconstruct::Parameters;
use crate::reconstruct::primitives::{Primitive, detect};
use crate::site::Site;

/// A point with another this much above it within [`BESIDE`] lies on a wall, or under a roof. Metres.
const UNDER: f64 = 1.0;
/// See [`UNDER`]; metres in the plan.
const BESIDE: f64 = 0.5;
/// A point with no other within this distance is alone, metres.
const ALONE: f64 = 1.5;
/// Planes steeper than this are walls (sine of the slope).
const STEEP: f64 = 0.9;
/// Parts of a roof smaller than this are small, m² in the plan.
const SMALL: f64 = 10.0;
/// Sites with fewer points are not counted.
const FEWEST: usize = 50;

/// The figures of a building, in the order of [`Figures::NAMES`]; `None` where it has none.
type Figures = [Option<f64>; NAMES.len()];

/// What is told of every scan.
const NAMES: [&str; 9] = [
    "points per m²",
    "distance of the nearest point in the plan, m",
    "spread around roof planes (RMS), m",
    "points off any plane, %",
    "points on walls or under roofs, %",
    "points with none within 1.5 m, %",
    "roof parts per 100 m²",
    "of these under 10 m², %",
    "height of small parts over what is around, m",
];

/// What the scans of some buildings look like.
#[derive(Debug, Clone)]
pub struct Statistics {
    /// Where the scans are from.
    pub name: String,
    /// Number of buildings that count.
    pub buildings: usize,
    /// For each figure the tenth, half and nine tenths of the buildings.
    quantiles: [Option<[f64; 3]>; NAMES.len()],
}

impl Statistics {
    /// Of real scans, as they are.
    pub fn of_real(name: &str, sites: &[RealSite]) -> Self {
        Self::of(name, sites.par_iter().map(|real| figures(&real.site)).collect())
    }

    /// Of one virtual scan of each model.
    pub fn of_models<'a>(name: &str, models: &[&'a Model], options: &ScanOptions, seed: u64) -> Self {
        let scanned = |model: &&'a Model| {
            let scan = scan(&model.placed(), options, 0.0, hash(seed, &model.id))?;
            figures(&scan.site(&model.id))
        };
        Self::of(name, models.par_iter().map(scanned).collect())
    }

    fn of(name: &str, buildings: Vec<Option<Figures>>) -> Self {
        let buildings: Vec<Figures> = buildings.into_iter().flatten().collect();
        let quantiles = std::array::from_fn(|row| {
            let mut values: Vec<f64> = buildings.iter().filter_map(|figures| figures[row]).collect();
            values.sort_unstable_by(f64::total_cmp);
            let last = values.len().checked_sub(1)?;
            Some([0.1, 0.5, 0.9].map(|share| values[(share * last as f64).round() as usize]))
        });
        Self { name: name.to_owned(), buildings: buildings.len(), quantiles }
    }
}

/// The figures side by side as a Markdown table: the median of the buildings, and in brackets the span of the middle four
/// fifths of them.
pub fn table(columns: &[Statistics]) -> String {
    let mut text = String::from("| |");
    for column in columns {
        let _ = write!(text, " {} ({}) |", column.name, column.buildings);
    }
    let _ = write!(text, "\n|---|{}\n", "---|".repeat(columns.len()));
    for (row, name) in NAMES.iter().enumerate() {
        let _ = write!(text, "| {name} |");
        for column in columns {
            let _ = match column.quantiles[row] {
                Some([low, middle, high]) => write!(text, " {middle:.2} ({low:.2}–{high:.2}) |"),
                None => write!(text, " – |"),
            };
        }
        text.push('\n');
    }
    text
}

/// The figures of a building; `None` for one with hardly a point.
fn figures(site: &Site) -> Option<Figures> {
    let points = &site.points;
    if points.len() < FEWEST {
        return None;
    }
    let count = points.len() as f64;
    let share = |number: usize| Some(100.0 * number as f64 / count);
    let plan = Plan::new(points, ALONE);
    let mut nearest = Vec::with_capacity(points.len());
    let (mut under, mut alone) = (0, 0);
    for (i, p) in (0u32..).zip(points) {
        let others = plan.around(&p.xy(), ALONE).filter(|&j| j != i).filter_map(|j| points.get(j as usize));
        let (mut flat, mut close, mut is_under) = (f64::INFINITY, false, false);
        for q in others {
            let distance = (q.xy() - p.xy()).norm();
            flat = flat.min(distance);
            close |= (q - p).norm() <= ALONE;
            is_under |= distance <= BESIDE && q.z > p.z + UNDER;
        }
        nearest.extend(flat.is_finite().then_some(flat));
        under += usize::from(is_under);
        alone += usize::from(!close);
    }
    let detection = detect(points, &Parameters::default(), 0);
    let on_planes: usize = detection.primitives.iter().map(|primitive| primitive.inliers.len()).sum();
    let roofs: Vec<&Primitive> = detection.primitives.iter().filter(|p| p.plane.verticality() <= STEEP).collect();
    let weight: f64 = roofs.iter().map(|roof| roof.inliers.len() as f64).sum();
    let squares: f64 = roofs.iter().map(|roof| roof.residual.powi(2) * roof.inliers.len() as f64).sum();
    let area = site.footprint.as_ref().map(geo::Area::unsigned_area).filter(|area| *area > 0.0);
    let small: Vec<&&Primitive> = roofs.iter().filter(|roof| plan_area(roof, points) < SMALL).collect();
    let mut heights: Vec<f64> = small.iter().filter_map(|roof| rise(roof, points, &plan)).collect();
    Some([
        area.map(|area| count / area),
        median(&mut nearest),
        (weight > 0.0).then(|| (squares / weight).sqrt()),
        share(points.len() - on_planes.min(points.len())),
        share(under),
        share(alone),
        area.map(|area| 100.0 * roofs.len() as f64 / area),
        (!roofs.is_empty()).then(|| 100.0 * small.len() as f64 / roofs.len() as f64),
        median(&mut heights),
    ])
}

/// The area of the hull of a part in the plan, m².
fn plan_area(roof: &Primitive, points: &[Point3<f64>]) -> f64 {
    let inliers = roof.inliers.iter().filter_map(|&i| points.get(i as usize));
    let places: geo::MultiPoint<f64> = inliers.map(|p| geo::Point::new(p.x, p.y)).collect();
    geo::Area::unsigned_area(&geo::ConvexHull::convex_hull(&places))
}

/// How far the median point of a part lies above that of the other points around it, metres; `None` where there are none.
fn rise(roof: &Primitive, points: &[Point3<f64>], plan: &Plan) -> Option<f64> {
    let mut own: Vec<f64> = Vec::new();
    let mut around: Vec<u32> = Vec::new();
    for p in roof.inliers.iter().filter_map(|&i| points.get(i as usize)) {
        own.push(p.z);
        around.extend(plan.around(&p.xy(), ALONE));
    }
    around.sort_unstable();
    around.dedup();
    let inliers: std::collections::BTreeSet<u32> = roof.inliers.iter().copied().collect();
    let mut others: Vec<f64> =
        around.iter().filter(|i| !inliers.contains(i)).filter_map(|&i| points.get(i as usize)).map(|p| p.z).collect();
    Some(median(&mut own)? - median(&mut others)?)
}

fn median(values: &mut [f64]) -> Option<f64> {
    values.sort_unstable_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

#[cfg(test)]
mod tests {
    use super::super::real::tests::real;
    use super::*;

    #[test]
    fn figures_of_a_known_house() {
        let house = real("house", "tile");
        let [density, nearest, spread, off, under, alone, parts, small, rise] = figures(&house.site).unwrap();
        // 248 roof points of 320 less 36 of open ground and 36 of a hole, and 16 on a wall between, over 80 m².
        assert!((density.unwrap() - 264.0 / 80.0).abs() < 1e-9, "{density:?}");
        assert!((nearest.unwrap() - 0.5).abs() < 1e-9 && spread.unwrap() < 1e-6);
        // The row on the wall lies 1.25 m under the first row of the slope.
        assert!((under.unwrap() - 100.0 * under_the_slope() / 264.0).abs() < 1e-9, "{under:?}");
        assert!(off.unwrap() < 7.0 && alone.unwrap() == 0.0);
        assert!((parts.unwrap() - 2.5).abs() < 1.3 && small.unwrap() <= 50.0 && rise.is_none(), "{parts:?} {rise:?}");
        // One more point, far above.
        let mut lonely = house.site.clone();
        lonely.points.push(Point3::new(2.0, 2.0, 9.0));
        let figures = figures(&lonely).unwrap();
        assert!((figures[5].unwrap() - 100.0 / 265.0).abs() < 1e-9);
    }

    /// How many points of the house have another 1 m above them within half a metre: those of the west that lie beside the
    /// wall or the slope, and those of the wall beside the slope.
    fn under_the_slope() -> f64 {
        let points = real("house", "tile").site.points;
        let under = |p: &&Point3<f64>| points.iter().any(|q| q.z > p.z + 1.0 && (q.xy() - p.xy()).norm() <= 0.5);
        points.iter().filter(under).count() as f64
    }

    #[test]
    fn a_table_has_a_column_for_every_source() {
        let houses = vec![real("a", "tile"), real("b", "tile"), real("c", "tile")];
        let text = table(&[Statistics::of_real("tile", &houses), Statistics::of_real("none", &[])]);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[0], "| | tile (3) | none (0) |");
        assert_eq!(lines.len(), 2 + NAMES.len());
        assert_eq!(lines[2], "| points per m² | 3.30 (3.30–3.30) | – |");
    }
}
