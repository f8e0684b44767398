use super::*;
use crate::reconstruct::surface::boxes::{Block, STRAIGHT, complex, grid, volume};

fn cube(n: i64) -> Vec<Block> {
    let axis: Vec<i64> = (0..=n).collect();
    grid([&axis, &axis, &axis])
}

/// Energy of a labelling, written down anew from the definition.
fn energy(blocks: &[Block], complex: &Complex, occupancy: &[f64], parameters: &LabellingParameters, x: &[bool]) -> f64 {
    let of = |cell: u32| cell != OUTSIDE && x[cell as usize];
    let differ = |c: [u32; 2]| of(c[0]) != of(c[1]);
    let deviation = |i: usize| (f64::from(u8::from(x[i])) - occupancy[i]).abs();
    match parameters.energy {
        Energy::Normalised => {
            let total: f64 = blocks.iter().map(|b| volume(b, &STRAIGHT)).sum();
            let data: f64 = (0..x.len()).map(|i| volume(&blocks[i], &STRAIGHT) / total * deviation(i)).sum();
            // Unit facets.
            let cut = complex.facets.iter().filter(|f| differ(f.cells)).count() as f64;
            let stands_on = |[low, high]: &Block, [_, top]: &Block| {
                (low[0], low[1], low[2]) == (top[0] - 1, top[1] - 1, top[2]) && high[2] > low[2]
            };
            let hangs_over =
                |above: usize, below: usize| x[above] && !x[below] && stands_on(&blocks[above], &blocks[below]);
            let pairs = (0..x.len()).flat_map(|above| (0..x.len()).map(move |below| (above, below)));
            let undercut = pairs.filter(|&(above, below)| hangs_over(above, below)).count() as f64;
            data + parameters.lambda * (cut + (UNDERCUT - 1.0) * undercut) / complex.facets.len() as f64
        }
        Energy::Paper => {
            let data: f64 = (0..x.len()).map(deviation).sum::<f64>() / x.len() as f64;
            let cut = complex.facets.iter().filter(|f| !f.cells.contains(&OUTSIDE) && differ(f.cells)).count();
            data + parameters.lambda * cut as f64
        }
    }
}

#[test]
fn the_label_is_the_best_of_all() {
    let blocks = grid([&[0, 1, 2], &[0, 1, 2], &[0, 1, 2, 3]]);
    let complex = complex(&blocks, STRAIGHT);
    let volumes: Vec<f64> = blocks.iter().map(|b| volume(b, &STRAIGHT)).collect();
    let areas = vec![1.0; complex.facets.len()];
    for (energy_of, lambda) in
        [(Energy::Normalised, 0.0), (Energy::Normalised, 0.3), (Energy::Normalised, 1.0), (Energy::Paper, 0.01)]
    {
        let parameters = LabellingParameters { energy: energy_of, lambda, volume_exponent: 1.0 };
        for seed in 0..20u64 {
            let occupancy: Vec<f64> =
                (0..12u64).map(|i| ((i * 7919 + seed * 104_729 + 13) * 2_654_435_761 % 1000) as f64 / 999.0).collect();
            let evidence = Evidence {
                occupancy: &occupancy,
                volumes: &volumes,
                areas: &areas,
                support: &[],
                fixed: &[],
                height_field: false,
                marked: &[],
                noise: 0.0,
            };
            let found = label(&complex, &evidence, &parameters);
            let least = (0u32..1 << 12)
                .map(|mask| {
                    let x: Vec<bool> = (0..12).map(|i| mask >> i & 1 == 1).collect();
                    energy(&blocks, &complex, &occupancy, &parameters, &x)
                })
                .fold(f64::INFINITY, f64::min);
            // Twelve cells of two by two have no interior: no cavity changes the labels afterwards.
            let reached = energy(&blocks, &complex, &occupancy, &parameters, &found);
            assert!((reached - least).abs() < 1e-9, "{reached} {least}");
            // Where nothing hangs over, what is told of the cost is all of it.
            let upright = label(&complex, &Evidence { height_field: true, ..evidence }, &parameters);
            let told = cost(&complex, &evidence, &parameters, &upright);
            let sum = told.data + told.lambda * told.smoothness;
            let of_upright = energy(&blocks, &complex, &occupancy, &parameters, &upright);
            assert!(energy_of == Energy::Paper || (sum - of_upright).abs() < 1e-9, "{sum} {of_upright}");
            let told = cost(&complex, &evidence, &parameters, &found);
            assert!(told.data + told.lambda * told.smoothness <= reached + 1e-9 && told.lambda == lambda);
        }
    }
}

#[test]
fn fixed_labels_hold_whatever_the_occupancy() {
    let blocks = cube(3);
    let complex = complex(&blocks, STRAIGHT);
    let (volumes, areas) = (vec![1.0; 27], vec![1.0; complex.facets.len()]);
    let fixed: Vec<Option<bool>> = (0..27).map(|i| (i % 5 == 0).then_some(i % 2 == 0)).collect();
    for occupancy in [vec![0.0; 27], vec![1.0; 27], vec![f64::NAN; 27]] {
        let evidence = Evidence {
            occupancy: &occupancy,
            volumes: &volumes,
            areas: &areas,
            support: &[],
            fixed: &fixed,
            height_field: false,
            marked: &[],
            noise: 0.0,
        };
        let found = label(&complex, &evidence, &LabellingParameters { lambda: 5.0, ..Default::default() });
        for (label, fixed) in found.iter().zip(&fixed) {
            assert!(fixed.is_none_or(|f| f == *label));
        }
    }
}

#[test]
fn nothing_known_is_nothing_inside() {
    let blocks = cube(2);
    let complex = complex(&blocks, STRAIGHT);
    let evidence = Evidence {
        occupancy: &[],
        volumes: &[],
        areas: &[],
        support: &[],
        fixed: &[],
        height_field: false,
        marked: &[],
        noise: 0.0,
    };
    assert_eq!(label(&complex, &evidence, &LabellingParameters::default()), [false; 8]);
}

#[test]
fn smoothness_removes_a_spike_unless_its_facets_are_supported() {
    // A tower of two cells on a base of nine: without support the tower gains 2 × 0.6/27 and costs 8 λ/108, the base
    // gains 9 × 0.6/27 and costs 30 λ/108.
    let blocks = cube(3);
    let complex = complex(&blocks, STRAIGHT);
    let (volumes, areas) = (vec![1.0; 27], vec![1.0; complex.facets.len()]);
    let tower = |b: &Block| b[0][2] > 0 && b[0][0] == 1 && b[0][1] == 1;
    let occupancy: Vec<f64> = blocks.iter().map(|b| if b[0][2] == 0 || tower(b) { 0.8 } else { 0.1 }).collect();
    let support: Vec<f64> = complex
        .facets
        .iter()
        .map(|f| {
            let at_tower = f.cells.iter().any(|&c| c != OUTSIDE && tower(&blocks[c as usize]));
            f64::from(u8::from(at_tower))
        })
        .collect();
    let towers = |support: &[f64], lambda: f64, noise: f64| {
        let parameters = LabellingParameters { lambda, ..Default::default() };
        let evidence = Evidence {
            occupancy: &occupancy,
            volumes: &volumes,
            areas: &areas,
            support,
            fixed: &[],
            height_field: false,
            marked: &[],
            noise,
        };
        let found = label(&complex, &evidence, &parameters);
        assert_eq!(blocks.iter().zip(&found).filter(|(b, l)| b[0][2] == 0 && **l).count(), 9);
        blocks.iter().zip(&found).filter(|(b, l)| tower(b) && **l).count()
    };
    assert_eq!(towers(&[], 0.65, 0.0), 0);
    assert_eq!(towers(&support, 0.65, 0.0), 2);
    // Noise takes away what is not wider than itself, whatever λ is, and no more.
    assert_eq!([0.1, 0.22].map(|noise| towers(&[], 0.0, noise)), [2, 0]);
}

#[test]
fn cavities_are_filled_and_courtyards_stay() {
    let blocks = cube(4);
    let complex = complex(&blocks, STRAIGHT);
    let at = |x: i64, y: i64, z: i64| blocks.iter().position(|b| b[0] == [x, y, z]).unwrap();
    let mut inside = vec![true; 64];
    // A cavity of two cells; a shaft to the top; a cell that touches the shaft along an edge only.
    for (x, y, z) in [(1, 1, 1), (1, 1, 2)] {
        inside[at(x, y, z)] = false;
    }
    for z in 2..4 {
        inside[at(2, 2, z)] = false;
    }
    assert_eq!(fill_cavities(&complex, &mut inside), 2);
    assert_eq!(inside.iter().filter(|i| !**i).count(), 2);
    assert!(!inside[at(2, 2, 3)] && inside[at(1, 1, 2)]);
}

#[test]
fn under_a_height_field_nothing_hangs_over() {
    // A column whose lower cell looks empty under a full one: the evidence for the upper cell decides for both, or the
    // evidence against the lower.
    let blocks: Vec<Block> = cube(2).into_iter().filter(|b| b[0][0] == 0 && b[0][1] == 0).collect();
    let complex = complex(&blocks, STRAIGHT);
    let (volumes, areas) = (vec![1.0; 2], vec![1.0; complex.facets.len()]);
    let lower = usize::from(blocks[0][0][2] != 0);
    for (low, high, together) in [(0.3, 0.9, true), (0.1, 0.6, false)] {
        let mut occupancy = [low; 2];
        occupancy[1 - lower] = high;
        let free = Evidence {
            occupancy: &occupancy,
            volumes: &volumes,
            areas: &areas,
            support: &[],
            fixed: &[],
            height_field: false,
            marked: &[],
            noise: 0.0,
        };
        let parameters = LabellingParameters { lambda: 0.0, ..Default::default() };
        let hanging = label(&complex, &free, &parameters);
        assert_eq!((hanging[lower], hanging[1 - lower]), (false, true));
        let standing = label(&complex, &Evidence { height_field: true, ..free }, &parameters);
        assert_eq!(standing, [together; 2]);
    }
}
