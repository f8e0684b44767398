//! From an edit to its result: random edits of the buildings of the bundled corner of Delft, each made again by its session.
//!
//! `cargo bench --bench edit` tells the median, the 90th and 99th percentile and the longest, all together, by action, and how
//! many buildings are made again within the time that a person does not notice.

#![allow(clippy::expect_used, reason = "a bench on the bundled data has nobody to report to")]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use gable::edit::Session;
use gable::edits::{Action, Edit, Lie, PlaneAt, Region};
use gable::geometry::Random;
use gable::reconstruct::equation;
use gable::reconstruct::primitives::{Extent, Primitive};
use gable::run::{FootprintSource, Job, Silent, sites};
use gable::source::footprints::FootprintOptions;

/// Edits of each building.
const EDITS: usize = 8;
/// What a person does not notice, milliseconds.
const UNNOTICED: f64 = 100.0;

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/data").join(name)
}

fn main() {
    // `cargo test --benches` asks whether it runs at all.
    let edits = if std::env::args().any(|argument| argument == "--test") { 1 } else { EDITS };
    let job = Job {
        tiles: vec![data("delft_ahn3.laz").display().to_string()],
        footprints: Some(FootprintSource { path: data("footprints.geojson"), options: FootprintOptions::default() }),
        ..Job::default()
    };
    let field = job.field.load().expect("the network is in the program");
    let sites = sites(&job, &Silent).expect("the bundled data is sound");
    let mut random = Random::new(15);
    let mut opened = Vec::new();
    let mut all = Vec::new();
    let mut by_action: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    let mut slow_buildings = 0;
    let mut buildings = 0;
    for site in sites.into_iter().filter(|site| site.points.len() > 10) {
        let (parameters, field) = (job.parameters.clone(), field.clone());
        let mut session = Session::open(site, Vec::new(), parameters, field, Vec::new(), Vec::new())
            .expect("the method does not break");
        opened.push(milliseconds(&session));
        let mut own = Vec::new();
        for _ in 0..edits {
            let Some(action) = any(&session, &mut random) else { break };
            let name = action.name();
            session.edit(Edit::from(action)).expect("the method does not break");
            own.push(milliseconds(&session));
            by_action.entry(name).or_default().push(milliseconds(&session));
        }
        buildings += 1;
        slow_buildings += usize::from(median(&mut own.clone()) > UNNOTICED);
        all.extend(own);
    }
    println!("{buildings} buildings, {} edits; milliseconds: median, 90 %, 99 %, longest", all.len());
    tell("opened", &mut opened);
    tell("edited", &mut all);
    for (name, times) in &mut by_action {
        tell(name, times);
    }
    println!("half of the edits take longer than {UNNOTICED} ms of {slow_buildings} buildings");
}

fn milliseconds(session: &Session) -> f64 {
    session.now().took.as_secs_f64() * 1e3
}

fn median(times: &mut [f64]) -> f64 {
    times.sort_by(f64::total_cmp);
    times.get(times.len() / 2).copied().unwrap_or(0.0)
}

fn tell(name: &str, times: &mut [f64]) {
    times.sort_by(f64::total_cmp);
    let at =
        |share: f64| times.get((times.len().saturating_sub(1) as f64 * share).round() as usize).copied().unwrap_or(0.0);
    println!("{name:<18} {:8.1} {:8.1} {:8.1} {:8.1}   {}", at(0.5), at(0.9), at(0.99), at(1.0), times.len());
}

/// An edit that a person might make of what a session shows.
fn any(session: &Session, random: &mut Random) -> Option<Action> {
    let (site, steps) = (session.site(), &session.now().steps);
    let roofs = &steps.detected.as_ref()?.roofs;
    let mut of = |count: usize| (random.unit() * count as f64) as usize % count.max(1);
    let roof = roofs.get(of(roofs.len()))?;
    let point = |i: usize| site.points.get(i).map(|p| site.frame.to_crs(p));
    let plane_at = |primitive: &Primitive| {
        let corners = match &primitive.extent {
            Extent::Patch(corners) => corners.iter().map(|corner| site.frame.to_crs(corner)).collect(),
            Extent::Everywhere => Vec::new(),
        };
        PlaneAt { equation: equation(&site.frame, &primitive.plane), extent: corners }
    };
    Some(match of(7) {
        0 => Action::SwitchPlane { plane: plane_at(roof), on: false },
        1 => {
            let places = (0..3).filter_map(|_| point(of(site.points.len()))).collect();
            Action::AddPlane { places, lie: None, unseen: true }
        }
        2 => Action::AlignPlane { plane: plane_at(roof), lie: Lie::Level },
        3 => {
            let [x, y, z] = point(of(site.points.len()))?;
            let inside = of(2) == 0;
            Action::MarkPlace { place: [x, y, if inside { z + 0.3 } else { z - 0.3 }], inside }
        }
        4 => Action::SetFloor { height: point(0)?[2] - 3.0 - of(100) as f64 / 100.0 },
        5 => Action::SetParameters { lambda: Some(0.05 + of(40) as f64 / 100.0), minimum_feature: None },
        _ => {
            let place = point(of(site.points.len()))?;
            Action::ExcludePoints { region: Region::Near { places: vec![place], radius: 1.0 } }
        }
    })
}
