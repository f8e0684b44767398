//! Points that arrive in chunks.

use std::fs;

use gable::run::{Feed, Job, Silent, run};
use gable::source::points::Extent;

use super::{points, quickstart};

#[test]
fn pushed_points_give_the_model_of_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let [from_file, from_feed] = ["file", "feed"].map(|name| folder.path().join(name).join("delft.city.json"));
    let report = run(&quickstart(&from_file), &Silent).unwrap();

    let mut feed = Feed::new_in(folder.path(), "pushed").unwrap();
    for chunk in points().chunks(10_007) {
        feed.push(chunk.iter().copied()).unwrap();
    }
    let fed = feed.finish(Some("EPSG:7415")).unwrap();
    let job = Job { tiles: Vec::new(), fed: Some(fed), ..quickstart(&from_feed) };
    let fed_report = run(&job, &Silent).unwrap();
    assert!(fs::read(&from_file).unwrap() == fs::read(&from_feed).unwrap(), "two models");
    assert_eq!(fed_report.counts, report.counts);
    assert_eq!(fed_report.inputs.points, report.inputs.points);
    let [tile] = fed_report.inputs.tiles.as_slice() else { panic!("{:?}", fed_report.inputs.tiles) };
    assert_eq!((tile.file.as_str(), tile.points, tile.crs.as_deref()), ("pushed", 141_577, Some("EPSG:7415")));
    // Twice the same points, from the file and pushed, are the same points.
    let both = Job { overwrite: true, fed: job.fed.clone(), ..quickstart(&from_feed) };
    run(&both, &Silent).unwrap();
    assert!(fs::read(&from_file).unwrap() == fs::read(&from_feed).unwrap(), "two models");
}

#[test]
fn what_was_scanned_counts_and_not_what_is_left() {
    let folder = tempfile::tempdir().unwrap();
    // Of a corner of the cloud only the buildings are left: the footprints at its edge reach beyond the points.
    let points = points();
    let mut whole = Extent::EMPTY;
    for point in &points {
        whole.grow(point.position);
    }
    let half = whole.min[0] + 0.5 * (whole.max[0] - whole.min[0]);
    let buildings = || points.iter().copied().filter(|p| p.class == 6 && p.position[0] < half);
    let incomplete = |areas: &[Extent], name: &str| {
        let mut feed = Feed::new("pushed").unwrap();
        feed.push(buildings()).unwrap();
        for area in areas {
            feed.cover(*area).unwrap();
        }
        let fed = Some(feed.finish(Some("EPSG:7415")).unwrap());
        let job = Job { tiles: Vec::new(), fed, ..quickstart(&folder.path().join(name)) };
        let report = run(&job, &Silent).unwrap();
        report.buildings.iter().filter(|b| b.coverage.is_some_and(|share| share < 0.999)).count()
    };
    let (without, with) = (incomplete(&[], "without.city.json"), incomplete(&[whole], "with.city.json"));
    assert!(without > 10 && with == 0, "{without} and {with}");
}

#[test]
fn bad_points_and_systems_are_errors() {
    let mut feed = Feed::new("pushed").unwrap();
    let nowhere = Extent { min: [0.0, f64::NAN, 0.0], max: [1.0; 3] };
    assert!(feed.cover(nowhere).unwrap_err().to_string().contains("covered area"));
    let fault = feed.finish(Some("EPSG:0")).unwrap_err().to_string();
    assert!(fault.contains("EPSG:0"), "{fault}");

    let folder = tempfile::tempdir().unwrap();
    let fed = Some(Feed::new("pushed").unwrap().finish(Some("EPSG:7415")).unwrap());
    let job = Job { tiles: Vec::new(), fed, ..quickstart(&folder.path().join("none.city.json")) };
    let fault = run(&job, &Silent).unwrap_err().to_string();
    assert!(fault.starts_with("pushed: found no point"), "{fault}");
}
