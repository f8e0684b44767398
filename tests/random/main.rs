//! Random buildings through the method and the validator: never a panic, never an invalid solid, never a model above its
//! points or outside its footprint, never without an explanation, never long.
//!
//! Every building has a number, which is all that it is made from; even ones are decided by the neural field, odd ones by
//! the vote. The test runs a few; many are run with
//!
//! ```text
//! GABLE_RANDOM_COUNT=100000 cargo test --release --test random -- --nocapture
//! ```
//!
//! from number `GABLE_RANDOM_FIRST` on, by `GABLE_RANDOM_THREADS` threads; outcomes that hold the text of
//! `GABLE_RANDOM_SHOW` are listed. What breaks a rule is named by its number; with a count of 1 a building is shown whole.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on fails")]

mod clouds;
mod draw;
mod footprints;
mod overlap;
mod plan;
mod rules;

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use gable::network::{Field, FieldOptions};
use gable::record::Record;
use gable::site::{Coverage, Frame, Ground, GroundSource, Site};
use geo::{BooleanOps, BoundingRect, MultiPolygon, Rect, Translate, coord};
use nalgebra::{Point3, Vector3};
use serde_json::Map;

use draw::Draw;

/// How many buildings the test runs.
const COUNT: u64 = 1000;

/// A random site and what it is.
struct Case {
    site: Site,
    name: String,
}

/// The random site with this number.
fn case(number: u64) -> Case {
    let mut draw = Draw::new(number);
    let (mut footprint, shape) = footprints::footprint(&mut draw);
    let mut cloud = clouds::cloud(&footprint, &mut draw);
    // The local frame ought to be near; a site that breaks that must not break more.
    let far = if draw.chance(0.01) { draw.of(&[1e6, -1e7]) } else { 0.0 };
    if far != 0.0 {
        footprint = footprint.translate(far, far);
        cloud.points.iter_mut().for_each(|p| *p += Vector3::new(far, far, 0.0));
    }
    let is_bare = draw.chance(0.1);
    let unit = draw.of(&[1.0, 1.0, 1.0, 0.3048, 1200.0 / 3937.0]);
    let mut site = Site {
        id: number.to_string(),
        frame: Frame { origin: [85_000.0, 447_000.0, 0.0], metres_per_unit: [unit; 3] },
        footprint: (!is_bare).then_some(footprint),
        points: cloud.points,
        ground_points: Vec::new(),
        ground_line: Vec::new(),
        ground: Ground { height: cloud.ground, spread: 0.1, source: GroundSource::GroundPoints },
        coverage: Coverage { share: draw.of(&[1.0, 1.0, 0.5]) },
        covered: None,
        eaves: None,
        attributes: Map::new(),
        record: Record::default(),
        edits: Vec::new(),
    };
    thin_out(&mut site, &mut draw);
    let bare = if is_bare { "no footprint" } else { shape };
    let far = if far == 0.0 { "" } else { ", far" };
    let name = format!("{bare}, {} {:.2} m above ground, {}{far}", cloud.roof, cloud.eaves - cloud.ground, cloud.ill);
    Case { site, name }
}

/// Opens the ground in a part of some sites, and leaves a part of some without any tile.
fn thin_out(site: &mut Site, draw: &mut Draw) {
    let Some(around) = site.footprint.as_ref().and_then(BoundingRect::bounding_rect) else { return };
    let mut place = || {
        let (x, y) = (draw.of(&[0.0, 0.2, 0.4, 0.7]), draw.of(&[0.0, 0.3, 0.6]));
        let low = coord! { x: around.min().x + x * around.width(), y: around.min().y + y * around.height() };
        let size = draw.of(&[0.2, 0.5, 1.0]);
        Rect::new(low, coord! { x: low.x + size * around.width(), y: low.y + size * around.height() })
    };
    let (open, covered) = (place(), place());
    if draw.chance(0.3) {
        let inside =
            |x: f64, y: f64| (open.min().x..open.max().x).contains(&x) && (open.min().y..open.max().y).contains(&y);
        site.points.retain(|p| !inside(p.x, p.y));
        let steps = |length: f64| (length / 0.5).min(100.0) as u32;
        for i in 0..steps(open.width()) {
            for j in 0..steps(open.height()) {
                let (x, y) = (open.min().x + 0.5 * f64::from(i), open.min().y + 0.5 * f64::from(j));
                site.ground_points.push(Point3::new(x, y, site.ground.height + 0.1));
            }
        }
    }
    if draw.chance(0.2) {
        let part =
            site.footprint.as_ref().map(|footprint| footprint.intersection(&MultiPolygon(vec![covered.to_polygon()])));
        site.coverage.share = 0.5;
        site.covered = part;
    }
}

/// A number from the environment.
fn from_environment(name: &str, default: u64) -> u64 {
    match std::env::var(name) {
        Ok(text) => text.parse().unwrap_or_else(|_| panic!("{name}={text} is no number")),
        Err(_) => default,
    }
}

#[test]
fn random_buildings_keep_the_rules() {
    let count = from_environment("GABLE_RANDOM_COUNT", COUNT);
    let first = from_environment("GABLE_RANDOM_FIRST", 0);
    let shown = std::env::var("GABLE_RANDOM_SHOW");
    let threads = from_environment("GABLE_RANDOM_THREADS", 2);
    let [neural, vote] = [Field::Neural, Field::HeightField].map(|field| {
        FieldOptions { field, ..FieldOptions::default() }.load().expect("the embedded networks can be loaded")
    });
    let next = AtomicU64::new(first);
    // Outcomes, how often they came, and the first number of each.
    let tally: Mutex<BTreeMap<String, (usize, u64)>> = Mutex::default();
    let broken: Mutex<Vec<String>> = Mutex::default();
    let slowest: Mutex<(u128, u64)> = Mutex::default();
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                loop {
                    let number = next.fetch_add(1, Ordering::Relaxed);
                    if number >= first + count {
                        break;
                    }
                    if number > first && (number - first).is_multiple_of(5000) {
                        eprintln!("{} buildings", number - first);
                    }
                    let case = case(number);
                    if count == 1 {
                        println!("{}: {:?}", case.name, case.site.footprint);
                    }
                    let field = if number.is_multiple_of(2) { &neural } else { &vote };
                    let judged = rules::judge(&case.site, &**field, number.is_multiple_of(50));
                    let mut worst = slowest.lock().unwrap_or_else(PoisonError::into_inner);
                    *worst = (*worst).max((judged.time.as_millis(), number));
                    drop(worst);
                    if shown.as_ref().is_ok_and(|text| judged.outcome.contains(text.as_str())) {
                        println!("{number} ({}): {}", case.name, judged.outcome);
                    }
                    let mut counts = tally.lock().unwrap_or_else(PoisonError::into_inner);
                    counts.entry(judged.outcome).or_insert((0, number)).0 += 1;
                    drop(counts);
                    for breach in judged.breaches {
                        let line = format!("{number} ({}): {breach}", case.name);
                        eprintln!("{line}");
                        broken.lock().unwrap_or_else(PoisonError::into_inner).push(line);
                    }
                }
            });
        }
    });
    for (outcome, (count, number)) in tally.into_inner().unwrap() {
        println!("{count:>8}  {outcome} (such as {number})");
    }
    let (slowest, number) = slowest.into_inner().unwrap();
    println!("slowest: {slowest} ms, number {number}");
    let broken = broken.into_inner().unwrap();
    assert!(broken.is_empty(), "{} of {count} buildings break a rule, such as {}", broken.len(), broken[0]);
}
