//! The cut and the surface on generated complexes: everything inside a ball is the building.
//!
//! `cargo bench --bench surface`

mod generated;

use divan::Bencher;
use gable::reconstruct::complex::Complex;
use gable::reconstruct::labelling::{Evidence, LabellingParameters, label};
use gable::reconstruct::surface::{Labelled, SurfaceParameters, extract};
use generated::random_planes;

fn main() {
    divan::main();
}

/// A complex of random planes with what the cut has to know of it.
struct Ball {
    complex: Complex,
    occupancy: Vec<f64>,
    volumes: Vec<f64>,
    areas: Vec<f64>,
    support: Vec<f64>,
    fixed: Vec<Option<bool>>,
}

impl Ball {
    fn new(planes: usize) -> Self {
        let (primitives, bounds) = random_planes(planes);
        let complex = Complex::adaptive(&primitives, &bounds).unwrap_or_default();
        let cells = 0..complex.cells.len() as u32;
        let facets = 0..complex.facets.len() as u32;
        // The nearer the centre of a cell to the sphere of 35 m, the less certain it is.
        let occupancy = |cell| 1.0 / (1.0 + (0.2 * (complex.cell_centroid(cell).coords.norm() - 35.0)).exp());
        Self {
            occupancy: cells.clone().map(occupancy).collect(),
            volumes: cells.clone().map(|cell| complex.cell_volume(cell)).collect(),
            areas: facets.clone().map(|facet| complex.facet_area(facet)).collect(),
            support: facets.map(|_| 0.0).collect(),
            fixed: cells.map(|_| None).collect(),
            complex,
        }
    }

    fn cut(&self) -> Vec<bool> {
        let Self { occupancy, volumes, areas, support, fixed, .. } = self;
        let evidence =
            Evidence { occupancy, volumes, areas, support, fixed, marked: &[], height_field: false, noise: 0.0 };
        label(&self.complex, &evidence, &LabellingParameters::default())
    }
}

#[divan::bench(args = [30, 100, 300])]
fn cut(bencher: Bencher, planes: usize) {
    let ball = Ball::new(planes);
    bencher.bench_local(|| ball.cut());
}

#[divan::bench(args = [30, 100, 300], sample_count = 10, sample_size = 1)]
fn surface(bencher: Bencher, planes: usize) {
    let ball = Ball::new(planes);
    let inside = ball.cut();
    let Ball { complex, occupancy, volumes, fixed, .. } = &ball;
    let labelled = Labelled { complex, inside: &inside, occupancy, volumes, fixed };
    bencher.bench_local(|| extract(&labelled, [1e-4; 3], &SurfaceParameters::default()).map(|e| e.shells.len()));
}
