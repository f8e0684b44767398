//! Whole buildings with known shapes, scanned without noise or with a little.

use geo::{LineString, MultiPolygon, Polygon};
use nalgebra::Point3;
use serde_json::Map;

use super::*;
use crate::building::RoofType;
use crate::record::Record;
use crate::site::{Coverage, Frame, Ground, GroundSource};
use crate::solid::SurfaceType;

/// A site whose roof is `height(x, y)` over `footprint`, sampled every `spacing` metres on a jittered grid.
fn site(footprint: MultiPolygon<f64>, spacing: f64, height: impl Fn(f64, f64) -> Option<f64>) -> Site {
    let rect = geo::BoundingRect::bounding_rect(&footprint).unwrap();
    let mut points = Vec::new();
    let mut state = 7_u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / f64::from(1_u32 << 31) - 0.5
    };
    let steps = |length: f64| (length / spacing) as i32;
    for i in 0..steps(rect.width()) {
        for j in 0..steps(rect.height()) {
            let x = rect.min().x + (f64::from(i) + 0.5 + 0.4 * random()) * spacing;
            let y = rect.min().y + (f64::from(j) + 0.5 + 0.4 * random()) * spacing;
            if geo::Contains::contains(&footprint, &geo::Point::new(x, y))
                && let Some(z) = height(x, y)
            {
                points.push(Point3::new(x, y, z + 0.02 * random()));
            }
        }
    }
    points.sort_by(|a, b| (a.x, a.y, a.z).partial_cmp(&(b.x, b.y, b.z)).unwrap());
    Site {
        id: "house".into(),
        frame: Frame { origin: [85_000.0, 447_000.0, 0.0], metres_per_unit: [1.0; 3] },
        footprint: Some(footprint),
        points,
        ground_points: Vec::new(),
        ground_line: Vec::new(),
        ground: Ground { height: 0.0, spread: 0.1, source: GroundSource::GroundPoints },
        coverage: Coverage { share: 1.0 },
        covered: None,
        eaves: None,
        attributes: Map::new(),
        record: Record::default(),
        edits: Vec::new(),
    }
}

fn outline(corners: &[(f64, f64)]) -> MultiPolygon<f64> {
    MultiPolygon(vec![Polygon::new(LineString::from(corners.to_vec()), vec![])])
}

fn rectangle(width: f64, depth: f64) -> MultiPolygon<f64> {
    outline(&[(0.0, 0.0), (width, 0.0), (width, depth), (0.0, depth)])
}

fn only_solid(building: &Building) -> &Solid {
    assert_eq!(building.outcome, Outcome::Lod22, "{:?}", building.measures);
    let solids: Vec<&Solid> = building.model.lod22().collect();
    assert_eq!(solids.len(), 1);
    solids[0]
}

fn count(solid: &Solid, kind: SurfaceType) -> usize {
    solid.faces.iter().filter(|face| solid.kind(face) == kind).count()
}

#[test]
fn a_gable_roof_has_seven_faces_and_its_volume() {
    let site = site(rectangle(12.0, 8.0), 0.35, |_, y| Some(8.0 - (y - 4.0).abs() * 0.8));
    let building = reconstruct(&site, &Parameters::default(), &occupancy::HeightField);
    let solid = only_solid(&building);
    assert_eq!((count(solid, SurfaceType::Roof), count(solid, SurfaceType::Wall)), (2, 4));
    assert_eq!(count(solid, SurfaceType::Ground), 1);
    let expected = 12.0 * (8.0 * 8.0 - 4.0 * 3.2);
    assert!((solid.volume() / expected - 1.0).abs() < 0.01, "{} {expected}", solid.volume());
    assert_eq!(building.measures.roof_type, Some(RoofType::Slanted));
    assert!((building.measures.ridge_height.unwrap() - 8.0).abs() < 0.05);
    assert!(building.measures.rmse_lod22.unwrap() < 0.03);
    assert!(building.measures.rmse_lod12.unwrap() > 0.5);
    let block = building.model.lod12().next().unwrap();
    assert_eq!(block.faces.len(), 6);
}

#[test]
fn a_low_wing_gets_its_wall_and_no_more() {
    let footprint = outline(&[(0.0, 0.0), (14.0, 0.0), (14.0, 6.0), (8.0, 6.0), (8.0, 10.0), (0.0, 10.0)]);
    let site = site(footprint, 0.35, |x, _| Some(if x < 8.0 { 9.0 } else { 3.5 }));
    let building = reconstruct(&site, &Parameters::default(), &occupancy::HeightField);
    let solid = only_solid(&building);
    assert_eq!(count(solid, SurfaceType::Roof), 2);
    // Six walls on the outline, and the one above the wing, which is part of the long wall at x = 8.
    assert_eq!(count(solid, SurfaceType::Wall), 6);
    assert!((solid.volume() - (80.0 * 9.0 + 36.0 * 3.5)).abs() < 10.0, "{}", solid.volume());
    assert_eq!(building.measures.roof_type, Some(RoofType::MultipleFlat));
}

#[test]
fn a_hip_roof_a_courtyard_and_a_dormer_are_closed_solids() {
    let hip = site(rectangle(14.0, 8.0), 0.35, |x, y| {
        Some(5.0 + (0.7 * y).min(0.7 * (8.0 - y)).min(0.7 * x).min(0.7 * (14.0 - x)))
    });
    assert_eq!(
        count(only_solid(&reconstruct(&hip, &Parameters::default(), &occupancy::HeightField)), SurfaceType::Roof),
        4
    );

    let ring = |a: f64, b: f64| LineString::from(vec![(a, a), (b, a), (b, b), (a, b)]);
    let court = MultiPolygon(vec![Polygon::new(ring(0.0, 16.0), vec![ring(5.0, 11.0)])]);
    let court = site(court, 0.4, |_, _| Some(7.0));
    let building = reconstruct(&court, &Parameters::default(), &occupancy::HeightField);
    let solid = only_solid(&building);
    assert_eq!(solid.faces.len(), 10);
    assert!((solid.volume() - 220.0 * 7.0).abs() < 5.0, "{}", solid.volume());

    let dormer = site(rectangle(12.0, 9.0), 0.3, |x, y| {
        let roof = 9.0 - (y - 4.5).abs() * 0.9;
        Some(if (4.0..7.0).contains(&x) && (0.8..4.0).contains(&y) { f64::max(roof, 8.2) } else { roof })
    });
    let building = reconstruct(&dormer, &Parameters::default(), &occupancy::HeightField);
    let solid = only_solid(&building);
    assert_eq!(count(solid, SurfaceType::Roof), 3);
    assert!(building.measures.rmse_lod22.unwrap() < 0.25, "{:?}", building.measures);
}

#[test]
fn the_same_site_gives_the_same_model_and_empty_sites_a_reason() {
    let mut house = site(rectangle(12.0, 8.0), 0.5, |_, y| Some(8.0 - (y - 4.0).abs() * 0.8));
    let first = reconstruct(&house, &Parameters::default(), &occupancy::HeightField);
    let second = reconstruct(&house, &Parameters::default(), &occupancy::HeightField);
    assert_eq!(first.model.parts, second.model.parts);

    house.points.truncate(2);
    let sparse = reconstruct(&house, &Parameters::default(), &occupancy::HeightField);
    assert_eq!(sparse.outcome, Outcome::Lod22);
    assert_eq!(sparse.measures.roof_type, Some(RoofType::Flat));

    house.points.clear();
    let empty = reconstruct(&house, &Parameters::default(), &occupancy::HeightField);
    assert_eq!(empty.outcome.reason().map(|(reason, _)| reason), Some(Reason::NoPoints));
    assert!(empty.model.parts.is_empty() && empty.model.footprint.len() == 1);
}

#[test]
fn no_roof_rises_above_the_evidence() {
    // Half of the roof is missing; its slope must not shoot up over the gap.
    let site = site(rectangle(20.0, 8.0), 0.35, |x, _| (x < 9.0).then_some(4.0 + 0.6 * x));
    let building = reconstruct(&site, &Parameters::default(), &occupancy::HeightField);
    let solid = only_solid(&building);
    let top = (0..solid.vertices.len() as u32).map(|v| solid.point(v).z).fold(f64::NEG_INFINITY, f64::max);
    assert!(top <= 4.0 + 0.6 * 9.0 + 0.5, "{top}");
}

#[test]
fn a_single_object_without_a_footprint_closes() {
    let mut house = site(rectangle(12.0, 8.0), 0.3, |_, y| Some(8.0 - (y - 4.0).abs() * 0.8));
    house.footprint = None;
    let building = reconstruct(&house, &Parameters::default(), &occupancy::HeightField);
    let solid = only_solid(&building);
    let expected = 12.0 * (8.0 * 8.0 - 4.0 * 3.2);
    assert!((solid.volume() / expected - 1.0).abs() < 0.1, "{} {expected}", solid.volume());
    // LoD 0 is what it stands on, and LoD 1.2 stands on that.
    let area: f64 = 12.0 * 8.0;
    let block = building.model.lod12().next().unwrap();
    let ground = block.faces.iter().find(|face| block.kind(face) == SurfaceType::Ground).unwrap();
    assert_eq!(building.model.footprint.len(), 1);
    assert!((block.area(ground) / area - 1.0).abs() < 0.1, "{}", block.area(ground));
    assert_eq!(building.notes, ["no footprint was given: LoD 0 and LoD 1.2 stand on the ground surfaces of the model"]);
}

#[test]
fn coordinates_that_are_no_numbers_are_left_out() {
    let mut house = site(rectangle(12.0, 8.0), 0.35, |_, y| Some(8.0 - (y - 4.0).abs() * 0.8));
    let expected = reconstruct(&house, &Parameters::default(), &occupancy::HeightField);
    let absurd = [[3.0, 3.0, f64::NAN], [f64::INFINITY, 3.0, 4.0], [3.0, 3.0, 1e300]];
    house.points.extend(absurd.map(Point3::from));
    let building = reconstruct(&house, &Parameters::default(), &occupancy::HeightField);
    assert_eq!(building.model.parts, expected.model.parts);
    assert_eq!(building.measures.points, expected.measures.points);
    assert_eq!(building.notes, ["3 point(s) with coordinates that are absurd or no numbers: left out"]);
}

/// A field that says the same of all places.
#[derive(Debug)]
struct Everywhere(f64);

impl Occupancy for Everywhere {
    fn occupancy(&self, building: &Partitioned) -> Result<Vec<f64>, occupancy::OccupancyError> {
        Ok(vec![self.0; building.complex.cells.len()])
    }

    fn probability(&self, _: &Partitioned, places: &[Point3<f64>]) -> Result<Vec<f64>, occupancy::OccupancyError> {
        Ok(vec![self.0; places.len()])
    }
}

/// A gabled house with a chimney that is too small for a hypothesis of its own, so that something is left unexplained.
fn house_with_a_chimney() -> Site {
    let mut house = site(rectangle(12.0, 8.0), 0.35, |_, y| Some(8.0 - (y - 4.0).abs() * 0.8));
    for i in 0..25 {
        house.points.push(Point3::new(5.1 + 0.2 * f64::from(i % 5), 5.1 + 0.2 * f64::from(i / 5), 9.5));
    }
    house
}

#[test]
fn a_field_is_asked_only_where_the_vote_leaves_something_unexplained() {
    let vote = occupancy::HeightField;
    let mut house = site(rectangle(12.0, 8.0), 0.35, |_, y| Some(8.0 - (y - 4.0).abs() * 0.8));
    let spared = reconstruct(&house, &Parameters::default(), &Everywhere(0.1));
    let by_vote = reconstruct(&house, &Parameters::default(), &vote);
    assert_eq!((spared.model.parts, spared.measures), (by_vote.model.parts, by_vote.measures));
    // Without a footprint the vote is no judge.
    house.footprint = None;
    let asked = reconstruct(&house, &Parameters::default(), &Everywhere(0.1));
    assert!(asked.measures.field_fallback.is_some());

    // A field that fills the footprint up to the top of the box explains the chimney, and is far above all else.
    let chimney = house_with_a_chimney();
    let by_vote = reconstruct(&chimney, &Parameters::default(), &vote);
    assert!(by_vote.measures.completeness.is_some_and(|found| found.missing.area == 1.0), "{:?}", by_vote.measures);
    let worse = reconstruct(&chimney, &Parameters::default(), &Everywhere(0.9));
    assert_eq!(worse.model.parts, by_vote.model.parts);
    let why = worse.measures.field_fallback.unwrap_or_default();
    assert!(why.ends_with("in excess, and the vote 1 m²"), "{why}");
}

#[test]
fn a_height_field_of_ones_own_decides_in_place_of_the_vote() {
    #[derive(Debug)]
    struct Nothing;
    impl Occupancy for Nothing {
        fn occupancy(&self, building: &Partitioned) -> Result<Vec<f64>, occupancy::OccupancyError> {
            Everywhere(0.0).occupancy(building)
        }

        fn probability(&self, _: &Partitioned, places: &[Point3<f64>]) -> Result<Vec<f64>, occupancy::OccupancyError> {
            Ok(vec![0.0; places.len()])
        }

        fn is_height_field(&self) -> bool {
            true
        }
    }
    let building = reconstruct(&house_with_a_chimney(), &Parameters::default(), &Nothing);
    assert_eq!(building.outcome.reason().map(|(reason, _)| reason), Some(Reason::NothingInside));
    assert_eq!(building.measures.field_fallback, None);
}

#[test]
fn the_vote_decides_where_the_field_denies_what_was_seen() {
    let house = house_with_a_chimney();
    let vote = reconstruct(&house, &Parameters::default(), &occupancy::HeightField);
    let denied = reconstruct(&house, &Parameters::default(), &Everywhere(0.1));
    assert_eq!(denied.model.parts, vote.model.parts);
    assert_eq!(denied.measures.field_fallback.as_deref(), Some("it says that everything is outside"));
    assert!(denied.notes.iter().any(|note| note.contains("the height-field vote decided")), "{:?}", denied.notes);
    assert_eq!(vote.measures.field_fallback, None);

    // The vote is sure of a house that was seen well, and more so of its roof than of cells that it doubts.
    assert!(vote.measures.confidence.is_some_and(|confidence| confidence > 0.9 && confidence <= 1.0));
    let roofs: Vec<f64> = only_solid(&vote).surfaces.iter().filter_map(|surface| surface.confidence).collect();
    assert_eq!(roofs.len(), 2);
    assert!(roofs.iter().all(|confidence| (0.9..=1.0).contains(confidence)), "{roofs:?}");
}

#[test]
fn a_passage_that_was_scanned_stays_open_under_a_field_that_knows_it() {
    /// Outside in the passage, inside elsewhere under the roof.
    #[derive(Debug)]
    struct Passage;
    impl Occupancy for Passage {
        fn occupancy(&self, building: &Partitioned) -> Result<Vec<f64>, occupancy::OccupancyError> {
            let cells = 0..building.complex.cells.len() as u32;
            let centroids: Vec<Point3<f64>> = cells.map(|cell| building.complex.cell_centroid(cell)).collect();
            self.probability(building, &centroids)
        }

        fn probability(&self, _: &Partitioned, places: &[Point3<f64>]) -> Result<Vec<f64>, occupancy::OccupancyError> {
            let inside = |p: &Point3<f64>| p.z < 9.0 && !(p.z < 3.0 && (4.0..8.0).contains(&p.x));
            Ok(places.iter().map(|p| f64::from(u8::from(inside(p)))).collect())
        }
    }
    let mut house = site(rectangle(12.0, 8.0), 0.3, |_, _| Some(9.0));
    // Its ceiling and its two walls, seen from the ground.
    for i in 0..26 {
        for j in 0..12 {
            let along = 0.15 + 0.3 * f64::from(i);
            house.points.push(Point3::new(4.1 + 0.32 * f64::from(j), along, 3.0));
            for wall in [4.0, 8.0] {
                house.points.push(Point3::new(wall, along, 0.1 + 0.25 * f64::from(j)));
            }
        }
    }
    let building = reconstruct(&house, &Parameters::default(), &Passage);
    let solid = only_solid(&building);
    assert!((solid.volume() - (12.0 * 8.0 * 9.0 - 4.0 * 8.0 * 3.0)).abs() < 10.0, "{}", solid.volume());
    assert_eq!(count(solid, SurfaceType::OuterCeiling), 1);
    let vote = reconstruct(&house, &Parameters::default(), &occupancy::HeightField);
    assert!((only_solid(&vote).volume() - 12.0 * 8.0 * 9.0).abs() < 10.0, "the ceiling is not taken for the roof");
}

/// A flat roof of 20 m by 16 m at 6 m around a courtyard of 8 m by 6 m, which the footprint has not.
fn around_a_courtyard() -> Site {
    let court = |x: f64, y: f64| (6.0..14.0).contains(&x) && (5.0..11.0).contains(&y);
    let roofs = site(rectangle(20.0, 16.0), 0.5, |x, y| (!court(x, y)).then_some(6.0));
    let ground = site(rectangle(20.0, 16.0), 0.5, |x, y| court(x, y).then_some(0.0));
    Site { ground_points: ground.points, ..roofs }
}

#[test]
fn open_ground_is_no_part_of_the_solid() {
    let site = around_a_courtyard();
    let carved = reconstruct(&site, &Parameters::default(), &occupancy::HeightField);
    let solid = only_solid(&carved);
    assert!((solid.volume() / 6.0 - 272.0).abs() < 6.0, "{}", solid.volume());
    let block = carved.model.lod12().next().unwrap();
    assert!((block.volume() / 6.0 - 272.0).abs() < 6.0, "{}", block.volume());
    assert_eq!((carved.model.footprint.len(), carved.model.footprint[0].len()), (1, 1), "LoD 0 is the footprint");
    assert!((carved.measures.open_ground.unwrap() - 48.0).abs() < 4.0);
    assert!(carved.notes.iter().any(|note| note.contains("no solid stands there")), "{:?}", carved.notes);

    let parameters = Parameters { open_ground: OpenGround::Keep, ..Parameters::default() };
    let kept = reconstruct(&site, &parameters, &occupancy::HeightField);
    assert!((only_solid(&kept).volume() / 6.0 - 320.0).abs() < 3.0);
    assert_eq!(kept.measures.open_ground, carved.measures.open_ground);
    assert!(kept.notes.iter().any(|note| note.contains("built over")), "{:?}", kept.notes);
    assert!(kept.measures.confidence < carved.measures.confidence);
}

#[test]
fn on_open_ground_nothing_is_built() {
    let site = site(rectangle(12.0, 10.0), 0.5, |_, _| Some(0.0));
    let ground_points = site.points.clone();
    let points = vec![Point3::new(3.0, 3.0, 5.0)];
    let building =
        reconstruct(&Site { points, ground_points, ..site }, &Parameters::default(), &occupancy::HeightField);
    assert!(
        matches!(building.outcome, Outcome::FootprintOnly { reason: Reason::OpenGround, .. }),
        "{:?}",
        building.outcome
    );
    assert_eq!((building.model.footprint.len(), building.model.parts.len()), (1, 0));
}

#[test]
fn what_no_tile_covers_is_not_made_up() {
    let whole = site(rectangle(12.0, 8.0), 0.35, |x, _| (x < 7.0).then_some(6.0));
    let covered = rectangle(7.0, 8.0);
    let partial = Site { coverage: Coverage { share: 7.0 / 12.0 }, covered: Some(covered), ..whole };
    let building = reconstruct(&partial, &Parameters::default(), &occupancy::HeightField);
    assert!(matches!(building.outcome, Outcome::Partial { reason: Reason::Incomplete, .. }), "{:?}", building.outcome);
    let solids: Vec<&Solid> = building.model.lod22().collect();
    assert_eq!((solids.len(), building.ladder_step()), (1, Some(crate::building::LadderStep::Partial)));
    assert!((solids[0].volume() - 336.0).abs() < 5.0, "{}", solids[0].volume());
    assert!(building.measures.confidence.unwrap() <= 7.0 / 12.0);

    let parameters = Parameters { partial: Partial::Block, ..Parameters::default() };
    let block = reconstruct(&partial, &parameters, &occupancy::HeightField);
    assert!(matches!(block.outcome, Outcome::Lod12 { reason: Reason::Incomplete, .. }), "{:?}", block.outcome);
    assert_eq!(block.model.lod22().count(), 0);
    assert!((block.measures.volume_lod12.unwrap() - 576.0).abs() < 3.0, "{:?}", block.measures);
    assert_eq!((block.measures.confidence, block.measures.roof_planes), (None, None));
}

#[test]
fn a_hole_that_touches_the_outline_costs_no_more_than_a_gap() {
    let ring = |corners: &[(f64, f64)]| LineString::from(corners.to_vec());
    let exterior = ring(&[(0.0, 0.0), (10.0, 0.0), (10.0, 8.0), (0.0, 8.0)]);
    let hole = ring(&[(0.0, 4.0), (3.0, 6.0), (3.0, 2.0)]);
    let site = site(MultiPolygon(vec![Polygon::new(exterior, vec![hole])]), 0.4, |_, _| Some(6.0));
    let building = reconstruct(&site, &Parameters::default(), &occupancy::HeightField);
    let solid = only_solid(&building);
    assert!((solid.volume() / 6.0 - 74.0).abs() < 1.0, "{}", solid.volume());
}

#[test]
fn what_hovers_is_in_no_height_and_in_no_rmse() {
    let mut site = site(rectangle(12.0, 8.0), 0.35, |_, _| Some(6.0));
    for i in 0..5 {
        let x = 4.0 + 0.2 * f64::from(i);
        site.points.push(Point3::new(x, 4.0, 500.0));
    }
    let building = reconstruct(&site, &Parameters::default(), &occupancy::HeightField);
    only_solid(&building);
    assert!(building.measures.rmse_lod22.unwrap() < 0.1, "{:?}", building.measures);
    assert!(building.measures.rmse_lod12.unwrap() < 0.1, "{:?}", building.measures);
    assert!(building.measures.roof_heights.unwrap().max < 6.1, "{:?}", building.measures);
    assert!(building.notes.iter().any(|note| note.starts_with("5 point(s)")), "{:?}", building.notes);
}
