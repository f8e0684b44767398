//! Fields on one core, by the embedded runtime: `cargo bench --bench field`.
//!
//! The building is generated and scanned from the air at 10 pulses per m². `queries` is what a place costs with its
//! nearest points and all other inputs, without what is done once for a building: `inputs`, `encoder`.

use std::path::Path;
use std::sync::{Arc, LazyLock};

use divan::Bencher;
use divan::counter::ItemsCount;
use gable::network::{Field, FieldOptions, NetworkFile, OnnxNetwork, Runtime};
use gable::reconstruct::occupancy::inputs::Inputs;
use gable::reconstruct::occupancy::network::{Interface, Network, Queries};
use gable::reconstruct::occupancy::{HeightField, Occupancy};
use gable::reconstruct::{Parameters, Partitioned};
use gable::simulate::{ScanOptions, generate, scan};
use gable::site::Site;
use nalgebra::Point3;

fn main() {
    divan::main();
}

/// The scan of a generated building.
static SITE: LazyLock<Site> = LazyLock::new(|| {
    let model = generate(1, 3).models.remove(0);
    match scan(&model.placed(), &ScanOptions::clean(), 0.0, 1) {
        Some(scan) => scan.site("bench"),
        None => unreachable!("a generated building has a surface"),
    }
});

/// The same cut into cells.
static BUILDING: LazyLock<Partitioned<'static>> =
    LazyLock::new(|| match Partitioned::new(&SITE, &Parameters::default()) {
        Ok(building) => building,
        Err(failure) => unreachable!("{failure:?}"),
    });

fn field(field: Field) -> Arc<dyn Occupancy> {
    match (FieldOptions { field, ..FieldOptions::default() }).load() {
        Ok(field) => field,
        Err(error) => unreachable!("{error}"),
    }
}

/// The places in the cells of the building at which a network is asked.
fn places(count: usize) -> Vec<Point3<f64>> {
    let complex = &BUILDING.complex;
    let samples = BUILDING.free().flat_map(|cell| complex.samples(cell, complex.median_volume(), 1));
    let samples: Vec<Point3<f64>> = samples.collect();
    samples.into_iter().cycle().take(count).collect()
}

fn embedded() -> OnnxNetwork {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/network/weights/field.safetensors");
    let network = NetworkFile::open(&path).and_then(|file| Runtime::start(None).map(|runtime| (file, runtime)));
    match network.map(|(file, runtime)| OnnxNetwork::new(&file, runtime)) {
        Ok(Ok(network)) => network,
        other => unreachable!("{other:?}"),
    }
}

/// All that a building costs whatever is asked, and one query.
#[divan::bench(args = [1, 4096])]
fn encoder_and_queries(bencher: Bencher, count: usize) {
    let (field, places) = (field(Field::Neural), places(count));
    bencher.counter(ItemsCount::new(count)).bench_local(|| field.probability(&BUILDING, &places));
}

#[divan::bench(sample_count = 3, sample_size = 1, args = [64])]
fn points2surf_queries(bencher: Bencher, count: usize) {
    let (field, places) = (field(Field::Points2Surf), places(count));
    bencher.counter(ItemsCount::new(count)).bench_local(|| field.probability(&BUILDING, &places));
}

#[divan::bench]
fn encoder(bencher: Bencher) {
    let network = embedded();
    let Interface::Field { grid, .. } = network.interface() else { return };
    let raster = Inputs::new(&BUILDING).raster(grid);
    bencher.bench_local(|| network.encode(&raster).map(|code| code.len()));
}

#[divan::bench]
fn decoder(bencher: Bencher) {
    let network = embedded();
    let Interface::Field { code, neighbours, .. } = network.interface() else { return };
    let [place, patch] = {
        use gable::reconstruct::occupancy::inputs::{PATCH_CHANNELS, PLACE_CHANNELS};
        [PLACE_CHANNELS.len(), neighbours * PATCH_CHANNELS.len()]
    };
    let count = 4096;
    let [code, place, patch] = [code, place, patch].map(|width| vec![0.1; width * count]);
    let queries = Queries { count, code, place, patch, subsample: Vec::new() };
    bencher.counter(ItemsCount::new(count)).bench_local(|| network.decode(&queries).map(|answers| answers.len()));
}

#[divan::bench]
fn inputs_and_raster(bencher: Bencher) {
    bencher.bench_local(|| Inputs::new(&BUILDING).raster(32).len());
}

#[divan::bench]
fn building_by_network(bencher: Bencher) {
    let field = field(Field::Neural);
    bencher.counter(ItemsCount::new(BUILDING.free().count())).bench_local(|| field.occupancy(&BUILDING));
}

#[divan::bench]
fn building_by_vote(bencher: Bencher) {
    bencher.counter(ItemsCount::new(BUILDING.free().count())).bench_local(|| HeightField.occupancy(&BUILDING));
}
