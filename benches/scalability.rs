//! How time grows with the number of primitives: partition, cells and cut, as lines of CSV.
//!
//! `cargo bench --bench scalability`, or `make plots`, which draws them. A partition that takes longer than a minute is the
//! last one.

mod generated;

use std::time::Instant;

use gable::reconstruct::complex::Complex;
use gable::reconstruct::labelling::{Evidence, LabellingParameters, label};
use generated::random_planes;

/// Numbers of primitives.
const COUNTS: [usize; 9] = [10, 20, 50, 100, 200, 260, 500, 1000, 2000];
/// Cells at most.
const MOST_CELLS: usize = 2_000_000;
/// Partitions of so many seconds and more are not tried with more primitives.
const LONG: f64 = 60.0;

fn main() {
    println!("primitives,cells,facets,partition_s,cut_s,inside");
    for count in COUNTS {
        let (primitives, bounds) = random_planes(count);
        let start = Instant::now();
        let complex = match Complex::adaptive_within(&primitives, &bounds, MOST_CELLS) {
            Ok(complex) => complex,
            Err(fault) => {
                eprintln!("{count} primitives: {fault}");
                break;
            }
        };
        let partition = start.elapsed().as_secs_f64();
        let cells = 0..complex.cells.len() as u32;
        // Everything inside a ball is the building; the nearer the centre of a cell to the sphere, the less certain it is.
        let occupancy: Vec<f64> = cells
            .clone()
            .map(|cell| 1.0 / (1.0 + (0.2 * (complex.cell_centroid(cell).coords.norm() - 35.0)).exp()))
            .collect();
        let volumes: Vec<f64> = cells.clone().map(|cell| complex.cell_volume(cell)).collect();
        let areas = complex.facet_areas();
        let support = vec![0.0; areas.len()];
        let fixed: Vec<Option<bool>> = cells.map(|_| None).collect();
        let evidence = Evidence {
            occupancy: &occupancy,
            volumes: &volumes,
            areas: &areas,
            support: &support,
            fixed: &fixed,
            height_field: false,
            marked: &[],
            noise: 0.0,
        };
        let start = Instant::now();
        let inside = label(&complex, &evidence, &LabellingParameters::default());
        let cut = start.elapsed().as_secs_f64();
        let inside = inside.iter().filter(|is_inside| **is_inside).count();
        println!("{count},{},{},{partition:.6},{cut:.6},{inside}", complex.cells.len(), complex.facets.len());
        if partition > LONG {
            break;
        }
    }
}
