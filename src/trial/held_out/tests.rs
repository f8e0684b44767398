//! A made-up street, scanned and parted.

use std::sync::Arc;

use geo::{LineString, MultiPolygon, Polygon};
use nalgebra::Point3;

use super::*;
use crate::completeness::{Extent, Extents};
use crate::reconstruct::occupancy::HeightField;
use crate::site::Frame;

/// A flat roof of 12 m × 10 m at `height` over ground at 0, 16 points per m², with ground in the middle of it.
fn house(id: &str, height: f64) -> Site {
    let ring = LineString::from(vec![(0.0, 0.0), (12.0, 0.0), (12.0, 10.0), (0.0, 10.0)]);
    let points =
        (0..1920).map(|i| Point3::new(0.125 + 0.25 * f64::from(i % 48), 0.125 + 0.25 * f64::from(i / 48), height));
    let frame = Frame { origin: [0.0; 3], metres_per_unit: [1.0; 3] };
    let ground_points =
        (0..100).map(|i| Point3::new(4.0 + 0.3 * f64::from(i % 10), 4.0 + 0.2 * f64::from(i / 10), 0.0));
    Site { ground_points: ground_points.collect(), ..Site::new(id, frame, points.collect(), 0.0) }
        .with_footprint(&MultiPolygon(vec![Polygon::new(ring, vec![])]))
}

fn holding(density: Option<f64>) -> Holding {
    Holding { share: 0.5, density, seed: 7 }
}

#[test]
fn every_point_is_either_given_or_held_out() {
    let site = house("a", 6.0);
    let split = Split::new(&site, &holding(None));
    assert_eq!(split.input.points.len() + split.points.len(), 1920);
    assert!((800..1120).contains(&split.points.len()), "{}", split.points.len());
    assert_eq!(split.input.ground_points.len() + split.ground_points.len(), 100);
    assert!(!split.points.iter().any(|p| split.input.points.contains(p)));
    // Thinned, it is judged by the same points; the same seed chooses the same ones, another others.
    let thin = Split::new(&site, &holding(Some(2.0)));
    assert_eq!((&thin.points, &thin.ground_points), (&split.points, &split.ground_points));
    assert!((180..300).contains(&thin.input.points.len()), "{}", thin.input.points.len());
    assert!(thin.input.points.iter().all(|p| split.input.points.contains(p)));
    assert_eq!(Split::new(&site, &holding(Some(2.0))).input.points, thin.input.points);
    assert_ne!(Split::new(&site, &Holding { seed: 8, ..holding(None) }).points, split.points);
    // What has fewer points stays as it is.
    assert_eq!(Split::new(&site, &holding(Some(1e6))).input.points, split.input.points);
}

#[test]
fn fields_are_judged_by_what_they_have_not_seen() {
    let field = |name: &str| Contender { name: name.to_owned(), field: Some(Arc::new(HeightField)) };
    let trial = HeldOutTrial {
        contenders: vec![field("one"), field("other")],
        holding: holding(None),
        parameters: Parameters::default(),
    };
    let few =
        Site { points: house("few", 6.0).points.into_iter().take(FEWEST_POINTS - 1).collect(), ..house("few", 6.0) };
    let sites = [house("a", 6.0), few, house("b", 9.0)];
    let found = trial.run(&sites, &|| ());
    let [one, other] = &found[..] else { panic!() };
    assert_eq!(one.buildings.iter().map(|b| b.id.as_str()).collect::<Vec<_>>(), ["a", "b"]);
    let figures = &one.figures;
    assert_eq!((figures.buildings, figures.lod22, figures.faces), (2, 2, Some(6.0)));
    // The ground in the middle lies under the roof, but points above it say that this is right.
    assert_eq!(figures.completeness, crate::completeness::Counts { buildings: 2, ..Default::default() });
    assert!(figures.vertical.unwrap().median < 0.01);
    assert_eq!(figures.completeness, other.figures.completeness);
    assert!(one.buildings.iter().all(|b| b.held_out > 0 && b.points + b.held_out == 1920));
}

#[test]
fn without_a_model_all_is_missing() {
    // Thinned to hardly any points.
    let trial = HeldOutTrial {
        contenders: vec![Contender { name: "vote".to_owned(), field: Some(Arc::new(HeightField)) }],
        holding: holding(Some(0.01)),
        parameters: Parameters::default(),
    };
    let found = trial.run(&[house("a", 6.0)], &|| ());
    let building = &found[0].buildings[0];
    assert!(building.failure.is_some() && building.faces.is_none());
    assert!(building.extents.missing.largest > 110.0, "of 120 m²: {:?}", building.extents);
}

#[test]
fn confidence_is_held_against_faults() {
    let of = |largest| Extents { excess: Extent { area: largest, largest }, ..Extents::default() };
    let (sound, small, large) = (of(0.0), of(9.0), of(10.0));
    let counted = Confident::of([
        (Some(0.95), &sound),
        (Some(0.9), &large),
        (Some(0.99), &small),
        (Some(0.5), &large),
        (None, &large),
    ]);
    assert_eq!((counted.buildings, counted.at_fault), (3, 1));
    assert!((counted.share.unwrap() - 1.0 / 3.0).abs() < 1e-12);
    assert_eq!(Confident::of([]).share, None);
}
