use std::path::Path;

use super::*;
use crate::building::{Building, LadderStep, Measures, Outcome, Reason};
use crate::network::FieldOptions;
use crate::record::Record;
use crate::site::Frame;
use crate::solid::{Model, Part, Solid};
use crate::terrain::{Tally, TerrainOptions};

fn building(outcome: Outcome, points: usize, parts: Vec<Part>) -> BuildingReport {
    let building = Building {
        id: "0042".into(),
        frame: Frame { origin: [0.0; 3], metres_per_unit: [1.0; 3] },
        attributes: serde_json::Map::new(),
        model: Model { parts, ..Model::default() },
        outcome,
        measures: Measures { points, ..Measures::default() },
        record: Record::default(),
        notes: vec!["a note".into()],
    };
    BuildingReport::new(&building, std::time::Duration::from_micros(1500), None)
}

fn solid() -> Solid {
    Solid { step: [1e-4; 3], vertices: vec![], faces: vec![], surfaces: vec![] }
}

fn lod22() -> BuildingReport {
    building(
        Outcome::Lod22,
        100,
        vec![
            Part { lod12: Some(solid()), lod22: Some(solid()), ..Part::default() },
            Part { lod22: Some(solid()), ..Part::default() },
        ],
    )
}

fn lod12() -> BuildingReport {
    let outcome = Outcome::Lod12 { reason: Reason::InvalidSolid, detail: "302".into() };
    building(outcome, 50, vec![Part { lod12: Some(solid()), ..Part::default() }])
}

fn skipped(reason: Reason, points: usize) -> BuildingReport {
    building(Outcome::FootprintOnly { reason, detail: String::new() }, points, vec![])
}

fn rejected() -> BuildingReport {
    building(Outcome::Rejected { reason: Reason::NoPolygon, detail: "a line".into() }, 0, vec![])
}

fn verdict(buildings: &[BuildingReport]) -> Verdict {
    let mut counts = Counts::default();
    for building in buildings {
        counts.add(building);
    }
    counts.verdict()
}

#[test]
fn counts_add_up() {
    let mut counts = Counts::default();
    for b in [lod22(), lod12(), skipped(Reason::NoPoints, 0), skipped(Reason::TooFewPoints, 2), rejected()] {
        counts.add(&b);
    }
    assert_eq!(counts.written, 5);
    assert_eq!((counts.solids_lod22, counts.solids_lod12), (2, 2));
    assert_eq!((counts.buildings_lod22, counts.buildings_lod12), (1, 1));
    assert_eq!(counts.with_points, 3);
    assert_eq!(counts.points, 152);
    assert_eq!(counts.lacking, 2, "too few points, and no polygon");
    let steps = [(LadderStep::Lod22, 1), (LadderStep::Lod12, 1), (LadderStep::Footprint, 2)];
    assert_eq!(counts.ladder, steps.into(), "a rejected feature stands on none");
    assert_eq!(counts.fallbacks, [(Reason::InvalidSolid, 1)].into());
    assert_eq!(counts.skipped, [(Reason::NoPolygon, 1), (Reason::NoPoints, 1), (Reason::TooFewPoints, 1)].into());
}

#[test]
fn exit_codes_say_what_was_promised() {
    let code = |buildings: &[BuildingReport]| verdict(buildings).exit_code();
    assert_eq!(code(&[lod22(), lod12()]), 0);
    assert_eq!(code(&[lod22(), skipped(Reason::NoPoints, 0)]), 0, "no points, no claim to a model");
    assert_eq!(code(&[lod22(), skipped(Reason::TooFewPoints, 2)]), 2);
    assert_eq!(code(&[lod22(), rejected()]), 2);
    assert_eq!(code(&[skipped(Reason::NoPoints, 0)]), 1);
    assert_eq!(code(&[rejected()]), 1);
    assert_eq!(code(&[]), 1);
    let mut counts = Counts { not_reached: 1, ..Counts::default() };
    counts.add(&lod22());
    assert_eq!(counts.verdict(), Verdict::Partial, "interrupted");
}

#[test]
fn percentiles_are_values_of_buildings() {
    let p = Percentiles::of((1..=10).rev().map(f64::from)).unwrap();
    assert_eq!((p.buildings, p.p50, p.p90, p.p99, p.max), (10, 5.0, 9.0, 10.0, 10.0));
    let p = Percentiles::of([f64::NAN, 3.0]).unwrap();
    assert_eq!((p.buildings, p.p50, p.max), (1, 3.0, 3.0));
    assert!(Percentiles::of([]).is_none());
}

fn report() -> Report {
    let buildings = vec![lod22(), lod12(), rejected()];
    let mut counts = Counts { footprints: 3, ..Counts::default() };
    for building in &buildings {
        counts.add(building);
    }
    Report {
        gable: "0.0.0".into(),
        command: vec!["gable".into()],
        started: now(),
        interrupted: false,
        exit_code: counts.verdict().exit_code(),
        crs: CrsReport { name: "n".into(), code: None, source: CrsSource::Option },
        inputs: Inputs {
            tiles: vec![TileReport {
                file: "a.laz".into(),
                cloud: None,
                points: 7,
                missing_points: 2,
                left_out: false,
                crs: None,
                problems: vec!["cut off".into()],
            }],
            footprints: Some(FootprintsReport {
                file: "f.geojson".into(),
                footprints: 2,
                outside: 0,
                missing: 0,
                is_damaged: false,
                rejected: 1,
                crs: None,
                id_attribute: Some("id".into()),
            }),
            roofprints: None,
            points: PointCounts { classes: [(6, 7)].into(), ..PointCounts::default() },
        },
        parameters: Parameters::default(),
        field: FieldOptions::default(),
        segmentation: SegmentOptions::default(),
        quality: Quality::of(&buildings),
        terrain: Some(TerrainReport::new(TerrainOptions::default(), 9, &Tally::default())),
        counts,
        stages: vec![StageReport { stage: Stage::Segment, wall_seconds: 0.5, cpu_seconds: Some(0.25) }],
        wall_seconds: 0.5,
        cpu_seconds: None,
        threads: 2,
        peak_memory_bytes: peak_memory(),
        jobs: None,
        outputs: vec![],
        warnings: vec![],
        buildings,
    }
}

#[test]
fn a_report_satisfies_its_schema() {
    let schema: serde_json::Value = serde_json::from_str(&schema()).unwrap();
    let validator = jsonschema::validator_for(&schema).unwrap();
    let mut instance = serde_json::to_value(report()).unwrap();
    let faults: Vec<String> = validator.iter_errors(&instance).map(|e| e.to_string()).collect();
    assert!(faults.is_empty(), "{faults:?}");
    assert_eq!(instance["buildings"][1]["outcome"], "lod12");
    assert_eq!(instance["buildings"][1]["reason"], "invalid-solid");
    assert_eq!(instance["counts"]["fallbacks"]["invalid-solid"], 1);
    instance["buildings"][1]["outcome"] = "splendid".into();
    assert!(!validator.is_valid(&instance), "the schema lets anything pass");
}

#[test]
fn the_checked_in_schema_is_up_to_date() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("schemas/report.schema.json");
    if std::env::var_os("GABLE_UPDATE_SCHEMAS").is_some() {
        std::fs::write(&path, schema()).unwrap();
    }
    let found = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        found == schema(),
        "{} is stale: renew it with `GABLE_UPDATE_SCHEMAS=1 cargo test --release --lib report`",
        path.display()
    );
}
