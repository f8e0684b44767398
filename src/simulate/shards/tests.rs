use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use nalgebra::Point3;
use serde_json::Value;

use super::super::model::tests::model;
use super::super::options::{ScanOptions, SetupChoice};
use super::super::real::RealSource;
use super::super::real::tests::real;
use super::super::source::Source;
use super::super::span::Span;
use super::super::split::Split;
use super::super::truth::Truth;
use super::*;
use crate::reconstruct::occupancy::inputs::{PATCH_CHANNELS, PLACE_CHANNELS, RASTER_CHANNELS};

struct Silent;

impl Observer for Silent {
    fn advanced(&self, _by: u64) {}
}

/// Scans of the house of the tests under ten names in five tiles.
fn job(output: &Path, options: ScanOptions) -> Job {
    let models = (0..10)
        .map(|i| {
            let mut model = model();
            model.id = format!("house {i}");
            model.tile = Arc::from(format!("tile {}", i / 2));
            model
        })
        .collect();
    let source = Source {
        name: "houses".into(),
        models,
        left_out: BTreeMap::from([("302 SHELL_NOT_CLOSED".into(), 3)]),
        crs: None,
        tiling: "by hand".into(),
        is_generated: false,
    };
    Job {
        sources: vec![source],
        real: Vec::new(),
        variants: 2,
        options,
        augment: false,
        interface: Interface::Field,
        sizes: Sizes::of(Interface::Field),
        shares: [0.8, 0.2, 0.0],
        seed: 11,
        shard: 6,
        output: output.to_path_buf(),
    }
}

/// Airborne, 8 pulses per m², and everything that is known is true.
fn exact() -> ScanOptions {
    ScanOptions { density: Span::fixed(8.0), ..ScanOptions::clean() }
}

/// The head of a shard and its tensors, read by hand: 8 bytes with the length of the head, the head, the numbers.
struct Shard {
    head: Value,
    body: Vec<u8>,
}

impl Shard {
    fn read(path: &Path) -> Self {
        let bytes = std::fs::read(path).unwrap();
        let length = u64::from_le_bytes(bytes[..8].try_into().unwrap()) as usize;
        assert_eq!(length % 8, 0);
        safetensors::SafeTensors::deserialize(&bytes).unwrap();
        Self { head: serde_json::from_slice(&bytes[8..8 + length]).unwrap(), body: bytes[8 + length..].to_vec() }
    }

    fn metadata(&self, name: &str) -> &str {
        self.head["__metadata__"][name].as_str().unwrap()
    }

    fn shape(&self, tensor: &str) -> Vec<u64> {
        self.head[tensor]["shape"].as_array().unwrap().iter().map(|n| n.as_u64().unwrap()).collect()
    }

    fn bytes(&self, tensor: &str) -> &[u8] {
        let offset = |i: usize| self.head[tensor]["data_offsets"][i].as_u64().unwrap() as usize;
        &self.body[offset(0)..offset(1)]
    }

    fn floats(&self, tensor: &str) -> Vec<f64> {
        assert_eq!(self.head[tensor]["dtype"], "F32");
        self.bytes(tensor).chunks_exact(4).map(|b| f64::from(f32::from_le_bytes(b.try_into().unwrap()))).collect()
    }
}

#[test]
fn shards_hold_what_was_asked_and_the_truth() {
    let folder = tempfile::tempdir().unwrap();
    let manifest = run(&job(folder.path(), exact()), &Silent).unwrap();
    // Four of five tiles, of two houses and two scans each, in shards of six.
    assert_eq!(
        manifest.shards,
        ["train-00000", "train-00001", "train-00002", "validation-00000"].map(|name| format!("{name}.safetensors"))
    );
    assert_eq!(manifest.scans, BTreeMap::from([(Split::Train, 16), (Split::Validation, 4)]));
    assert_eq!((manifest.failed.len(), manifest.tiles.len(), manifest.sources[0].found), (0, 5, 13));
    let written: Value = serde_json::from_slice(&std::fs::read(folder.path().join("manifest.json")).unwrap()).unwrap();
    assert_eq!(written["options"]["density"], "8");

    let shard = Shard::read(&folder.path().join("train-00000.safetensors"));
    let channels = |name: &str| shard.metadata(name).split(',').map(str::to_owned).collect::<Vec<_>>();
    assert_eq!(channels("raster_channels"), RASTER_CHANNELS);
    assert_eq!(channels("place_channels"), PLACE_CHANNELS);
    assert_eq!(channels("patch_channels"), PATCH_CHANNELS);
    assert_eq!(channels("setups"), ["full-view", "no-bottom", "airborne", "photographs", "real"]);
    let named = ["interface", "version", "split", "seed", "near", "uniform", "cells", "samples_per_cell"];
    assert_eq!(named.map(|name| shard.metadata(name)), ["field", "2", "train", "11", "64", "48", "18", "8"]);
    let (r, f, p) = (RASTER_CHANNELS.len() as u64, PLACE_CHANNELS.len() as u64, PATCH_CHANNELS.len() as u64);
    assert_eq!(shard.shape("raster"), [6, r, 32, 32]);
    assert_eq!(shard.shape("subsample"), [6, 1000, 3]);
    assert_eq!(shard.shape("place"), [6, 256, f]);
    assert_eq!(shard.shape("patch"), [6, 256, 16, p]);
    assert_eq!(shard.shape("cell_vote"), [6, 18]);
    let sizes = |tensor: &str| shard.bytes(tensor).len() as u64 / shard.shape(tensor).iter().product::<u64>();
    assert_eq!(["raster", "subsample", "patch", "place", "inside", "setup"].map(sizes), [2, 2, 2, 4, 1, 1]);
    let total: usize =
        shard.head.as_object().unwrap().keys().filter(|k| *k != "__metadata__").map(|k| shard.bytes(k).len()).sum();
    assert_eq!(total, shard.body.len(), "tensors cover the file");
    assert_eq!(shard.bytes("setup"), [2; 6]);

    // The origin of the field frame is that of the placed house: its outline is centred and its ground is at 0.
    let truth = Truth::new(&model().placed().mesh).unwrap();
    let (place, scale) = (shard.floats("place"), shard.floats("scale"));
    let (distance, radius) = (shard.floats("distance"), shard.floats("radius"));
    let (mut inside, mut far) = (0, 0);
    for (i, channels) in place.chunks_exact(f as usize).enumerate() {
        let s = scale[i / 256];
        assert!((10.0..13.0).contains(&s), "{s}");
        let p = Point3::new(channels[0] * s, channels[1] * s, channels[2] * s);
        assert!((truth.distance(&p) - distance[i]).abs() < 1e-4);
        if distance[i] > 1e-4 {
            assert_eq!(u8::from(truth.is_inside(&p)), shard.bytes("inside")[i]);
        }
        assert!(radius[i] > 0.0);
        inside += usize::from(shard.bytes("inside")[i]);
        if i % 256 < 64 {
            // Five standard deviations.
            assert!(distance[i] < 0.2 * s, "{}", distance[i]);
            far += usize::from(distance[i] > 0.04 * s);
        }
    }
    assert!((0.2..0.6).contains(&(inside as f64 / place.len() as f64 * f as f64)));
    // Of the half with 0.04 S, 31.7 % lie farther than that along the normal, fewer from the surface.
    assert!((0.05..0.2).contains(&(far as f64 / (6.0 * 64.0))), "{far}");
    // Clean points make a perfect partition: cells are inside or outside, and the vote knows.
    for (inside, vote) in shard.floats("cell_inside").iter().zip(shard.floats("cell_vote")) {
        assert!((inside - vote).abs() < 0.3, "{inside} {vote}");
    }
}

#[test]
fn bytes_do_not_depend_on_threads() {
    let made = |threads: usize| -> Vec<Vec<u8>> {
        let folder = tempfile::tempdir().unwrap();
        let job = Job { augment: true, shard: 100, ..job(folder.path(), ScanOptions::training()) };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let manifest = pool.install(|| run(&job, &Silent)).unwrap();
        let files = manifest.shards.iter().map(String::as_str).chain(["manifest.json"]);
        files.map(|name| std::fs::read(folder.path().join(name)).unwrap()).collect()
    };
    let (one, three) = (made(1), made(3));
    assert_eq!(one.len(), 3);
    assert!(one == three);
}

#[test]
fn the_network_of_the_paper_has_its_own_shapes() {
    let folder = tempfile::tempdir().unwrap();
    let mut job = job(folder.path(), ScanOptions { setup: SetupChoice::FullView, ..exact() });
    (job.interface, job.sizes) = (Interface::Points2surf, Sizes::of(Interface::Points2surf));
    job.sources[0].models.truncate(2);
    run(&job, &Silent).unwrap();
    let shard = Shard::read(&folder.path().join("train-00000.safetensors"));
    assert_eq!(shard.shape("patch"), [4, 256, 300, 3]);
    assert_eq!(shard.shape("place"), [4, 256, 3]);
    assert_eq!(shard.metadata("place_channels"), "x,y,z");
    assert_eq!((shard.metadata("interface"), shard.metadata("raster_channels")), ("points2surf", ""));
    assert!(shard.head.get("raster").is_none());
    assert_eq!(shard.bytes("setup"), [0; 4]);
}

#[test]
fn a_scan_without_a_partition_is_counted() {
    let folder = tempfile::tempdir().unwrap();
    let options = ScanOptions { dropped: Span::fixed(1.0), ..exact() };
    let manifest = run(&job(folder.path(), options), &Silent).unwrap();
    assert_eq!(manifest.failed.values().sum::<usize>(), 20, "{:?}", manifest.failed);
    assert!(manifest.shards.is_empty() && folder.path().join("manifest.json").exists());
}

/// Two tiles with two buildings each and one in both; the second tile is held back.
fn real_job(output: &Path) -> Job {
    let source = |tile: &str, ids: [&str; 3], held_back: bool| RealSource {
        name: tile.to_owned(),
        sites: ids.map(|id| real(id, tile)).to_vec(),
        left_out: BTreeMap::new(),
        held_back,
        warnings: Vec::new(),
    };
    Job {
        sources: Vec::new(),
        real: vec![source("west", ["a", "b", "middle"], false), source("east", ["middle", "c", "d"], true)],
        shares: [1.0, 0.0, 0.0],
        augment: true,
        ..job(output, ScanOptions::training())
    }
}

#[test]
fn of_real_scans_only_a_part_is_known() {
    let folder = tempfile::tempdir().unwrap();
    let manifest = run(&real_job(folder.path()), &Silent).unwrap();
    assert!(manifest.failed.is_empty(), "{:?}", manifest.failed);
    // The building in both tiles is held back with the second, both scans of it.
    assert_eq!(manifest.scans, BTreeMap::from([(Split::Train, 4), (Split::Validation, 6)]));
    assert_eq!(
        manifest.sources.iter().map(|s| s.tiling.as_str()).collect::<Vec<_>>(),
        ["one tile", "one tile, held back"]
    );

    let shard = Shard::read(&folder.path().join("validation-00000.safetensors"));
    assert_eq!((shard.bytes("exact"), shard.bytes("setup")), (&[0; 6][..], &[4; 6][..]));
    assert!(shard.floats("noise").iter().all(|noise| noise.is_nan()));
    let known = shard.bytes("known");
    let share = known.iter().map(|known| f64::from(*known)).sum::<f64>() / known.len() as f64;
    assert!((0.3..0.9).contains(&share), "{share}");
    for (inside, known) in shard.bytes("inside").iter().zip(known) {
        assert!(inside <= known, "what is unknown is not inside");
    }
    let [inside, cell_known] = ["cell_inside", "cell_known"].map(|name| shard.floats(name));
    assert!(inside.iter().zip(&cell_known).all(|(i, k)| (0.0..=1.0).contains(i) && (0.01..=1.0).contains(k)));
    assert!(cell_known.iter().any(|known| *known < 0.9) && cell_known.iter().any(|known| *known > 0.9));
    // Flat and even roofs that were seen: the vote is right about most of what is known.
    let right = inside.iter().zip(shard.floats("cell_vote")).zip(&cell_known);
    let right: f64 =
        right.map(|((inside, vote), known)| known * f64::from(u8::from((*inside > 0.5) == (vote > 0.5)))).sum();
    assert!(right / cell_known.iter().sum::<f64>() > 0.85, "{right}");
    // Of a model all is known.
    let virtual_ones = tempfile::tempdir().unwrap();
    run(&job(virtual_ones.path(), exact()), &Silent).unwrap();
    let shard = Shard::read(&virtual_ones.path().join("train-00000.safetensors"));
    assert!(shard.bytes("known").iter().chain(shard.bytes("exact")).all(|known| *known == 1));
    assert!(shard.floats("cell_known").iter().all(|known| *known == 1.0));
}

#[test]
fn real_scans_do_not_depend_on_threads() {
    let made = |threads: usize| -> Vec<Vec<u8>> {
        let folder = tempfile::tempdir().unwrap();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let manifest = pool.install(|| run(&real_job(folder.path()), &Silent)).unwrap();
        manifest.shards.iter().map(|name| std::fs::read(folder.path().join(name)).unwrap()).collect()
    };
    let (one, three) = (made(1), made(3));
    assert!(one.len() == 2 && one == three);
}
