use super::*;
use crate::building::{Building, Measures, Outcome};
use crate::solid::{Model, Part, quantise_footprint};

fn dump(path: &str, seeds: &[(u64, Generated)]) {
    let _ = std::fs::remove_file(path);
    let metadata = crate::sink::Metadata {
        title: "generated".into(),
        reference_system: None,
        translate: [0; 3],
        point_cloud: crate::sink::PointCloud::default(),
        parameters: serde_json::Value::Null,
        ids: crate::sink::Ids::default(),
    };
    let mut sink = crate::sink::create(std::path::Path::new(path), metadata, true).unwrap();
    for (seed, g) in seeds {
        let frame = Frame { origin: [(seed % 40) as f64 * 100.0, (seed / 40) as f64 * 100.0, 0.0], ..g.frame };
        let mut parts = vec![Part { lod12: None, lod22: Some(g.solid.clone()) }];
        if std::env::var("GEN_NEIGHBOURS").is_ok() {
            parts.extend(g.neighbours.iter().map(|n| Part { lod12: None, lod22: Some(n.clone()) }));
        }
        let s = &g.shape;
        let id = format!(
            "{seed} {:?} b{} d{} c{}{}{}{}{}",
            s.roof,
            s.blocks,
            s.dormers,
            s.chimneys,
            if s.courtyard { " court" } else { "" },
            if s.overhang { " over" } else { "" },
            if s.arcade { " arcade" } else { "" },
            if s.eaves { " eaves" } else { "" }
        );
        sink.write(&Building {
            id,
            frame,
            attributes: serde_json::Map::new(),
            model: Model {
                footprint: quantise_footprint(&g.footprint, g.frame.step()),
                ground: (g.ground * 1e4).round() as i64,
                parts,
            },
            outcome: Outcome::Lod22,
            measures: Measures::default(),
            notes: vec![],
        })
        .unwrap();
    }
    sink.finish().unwrap();
}

#[test]
fn smoke() {
    let n: u64 = std::env::var("GEN_N").map_or(200, |s| s.parse().unwrap());
    let mut random = Random::new(99);
    let mut flaws = std::collections::BTreeMap::<String, usize>::new();
    for _ in 0..n {
        let draft = principal::draw(&mut random);
        if let Err(e) = draft.clone().finish() {
            let text: String = format!("{e:?}").chars().take(26).collect();
            // Which pieces are to blame: leave them out one by one.
            let mut blame = Vec::new();
            for i in 0..draft.expression.added.len() {
                let mut d = draft.clone();
                d.expression.added.remove(i);
                if d.finish().is_ok() {
                    blame.push(format!("a{i}"));
                }
            }
            for i in 0..draft.expression.removed.len() {
                let mut d = draft.clone();
                d.expression.removed.remove(i);
                if d.finish().is_ok() {
                    blame.push(format!("r{i}"));
                }
            }
            for p in &draft.expression.added {
                println!(
                    "   {:?}",
                    p.sides
                        .iter()
                        .map(|s| (s.normal.x * 1e4, s.normal.y * 1e4, s.normal.z * 1e4, s.offset * 1e4))
                        .map(|(a, b, c, d)| format!("{:.4} {:.4} {:.4} {:.4}", a / 1e4, b / 1e4, c / 1e4, d / 1e4))
                        .collect::<Vec<_>>()
                );
            }
            println!("{e} {:?} added {} blame {blame:?}", draft.shape, draft.expression.added.len());
            *flaws.entry(text).or_default() += 1;
        }
    }
    println!("{flaws:#?}");
    let start = std::time::Instant::now();
    let all: Vec<(u64, Generated)> = (0..n).map(|s| (s, building(s).unwrap())).collect();
    println!("{:?}", start.elapsed());
    let mut counts = std::collections::BTreeMap::<String, usize>::new();
    for (_, g) in &all {
        let s = &g.shape;
        let mut add = |k: String| *counts.entry(k).or_default() += 1;
        add(format!("roof {:?}", s.roof));
        add(format!("blocks {}", s.blocks));
        for (k, v) in [
            ("dormers", s.dormers > 0),
            ("chimneys", s.chimneys > 0),
            ("court", s.courtyard),
            ("over", s.overhang),
            ("arcade", s.arcade),
            ("eaves", s.eaves),
            ("party", s.party_walls > 0),
        ] {
            if v {
                add(k.into());
            }
        }
        let ground: f64 = g
            .solid
            .faces
            .iter()
            .filter(|f| g.solid.kind(f) == crate::solid::SurfaceType::Ground)
            .map(|f| g.solid.area(f))
            .sum();
        let area = geo::Area::unsigned_area(&g.footprint);
        if s.is_height_field() && (ground - area).abs() > 0.05 {
            println!("area {area} ground {ground} {s:?}");
        }
    }
    for (k, v) in counts {
        println!("{k}: {:.1} %", 100.0 * v as f64 / n as f64);
    }
    let pick = |name: &str, f: &dyn Fn(&Shape) -> bool| {
        let some: Vec<_> = all.iter().filter(|(_, g)| f(&g.shape)).take(30).cloned().collect();
        dump(&format!("/tmp/gen_{name}.city.json"), &some);
    };
    pick("all", &|_| true);
    pick("odd", &|s| !s.is_height_field());
    pick("court", &|s| s.courtyard);
    pick("dormers", &|s| s.dormers > 0);
    pick("eaves", &|s| s.eaves);
    pick("many", &|s| s.blocks > 2);
}
