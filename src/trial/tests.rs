//! Fields that are right or wrong in a way that can be worked out by hand.

use nalgebra::{Point3, Unit, Vector3};

use super::*;
use crate::geometry::{Aabb, Plane};
use crate::reconstruct::complex::Complex;
use crate::reconstruct::occupancy::{HeightField, OccupancyError};
use crate::reconstruct::primitives::{Extent, Primitive, PrimitiveKind};
use crate::reconstruct::{Partitioned, occupancy::Occupancy};
use crate::simulate::{Mesh, Placed, Truth, generate};
use crate::site::Frame;
use crate::solid::{Face, Solid, Surface, SurfaceType};

/// A body with this profile in x and z, from y = 0 to y = `depth`, in metres.
fn profile(corners: &[[i64; 2]], depth: i64) -> Mesh {
    let n = corners.len() as u32;
    let vertices = [0, depth].iter().flat_map(|&y| corners.iter().map(move |&[x, z]| [x, y, z])).collect();
    let mut rings: Vec<Vec<u32>> = vec![(0..n).collect(), (n..2 * n).rev().collect()];
    rings.extend((0..n).map(|i| vec![i, i + n, (i + 1) % n + n, (i + 1) % n]));
    let faces = rings.into_iter().map(|ring| Face { rings: vec![ring], surface: 0 }).collect();
    Mesh::of(&Solid { step: [1.0; 3], vertices, faces, surfaces: vec![Surface::of(SurfaceType::Wall)] })
}

/// A house of 10 m by 6 m by 5 m under a ridge at 8 m over the middle of its length.
fn house() -> Mesh {
    profile(&[[0, 0], [10, 0], [10, 5], [5, 8], [0, 5]], 6)
}

/// A table: a slab of 10 m by 6 m by 2 m on two legs that are 2 m wide and 3 m high.
fn table() -> Mesh {
    profile(&[[0, 0], [2, 0], [2, 3], [8, 3], [8, 0], [10, 0], [10, 5], [0, 5]], 6)
}

/// A scan of a body as the column has it.
fn subject(mesh: Mesh, column: Column) -> Subject {
    let placed = Placed {
        frame: Frame { origin: [0.0; 3], metres_per_unit: [1.0; 3] },
        footprint: mesh.outline(),
        ground: 0.0,
        neighbours: Vec::new(),
        mesh,
    };
    let scan = scan(&placed, &column.options(), 0.0, 7).unwrap();
    Subject::new(scan.site("house"), placed.mesh, 7).unwrap()
}

/// What an occupancy of its own cells makes of the truth about them.
#[derive(Debug)]
struct Distorted<'a>(&'a Subject, fn(f64) -> f64);

impl Occupancy for Distorted<'_> {
    fn occupancy(&self, building: &Partitioned) -> Result<Vec<f64>, OccupancyError> {
        Ok(self.0.fractions(building).iter().map(|&fraction| (self.1)(fraction)).collect())
    }

    fn probability(&self, _: &Partitioned, places: &[Point3<f64>]) -> Result<Vec<f64>, OccupancyError> {
        Ok(places.iter().map(|p| (self.1)(f64::from(u8::from(self.0.truth().is_inside(p))))).collect())
    }
}

#[test]
fn fractions_of_cells_are_as_worked_out_by_hand() {
    let cut = |point: [f64; 3], normal: [f64; 3]| Primitive {
        kind: PrimitiveKind::Detected,
        plane: Plane::through(&Point3::from(point), Unit::new_normalize(Vector3::from(normal))),
        inliers: Vec::new(),
        residual: 0.0,
        extent: Extent::Everywhere,
    };
    let bounds = Aabb { min: [0.0; 3], max: [10.0, 6.0, 10.0] };
    let fractions = |mesh: &Mesh, cuts: &[Primitive]| {
        let complex = Complex::adaptive(cuts, &bounds).unwrap();
        let truth = Truth::new(mesh).unwrap();
        let mut found: Vec<(Point3<f64>, f64)> = inside_fraction(&complex, mesh, &truth)
            .into_iter()
            .zip(0..)
            .map(|(fraction, cell)| (complex.cell_centroid(cell), fraction))
            .collect();
        found.sort_by(|(p, _), (q, _)| p.z.total_cmp(&q.z).then(p.x.total_cmp(&q.x)));
        found.into_iter().map(|(_, fraction)| fraction).collect::<Vec<_>>()
    };
    let near = |found: Vec<f64>, expected: &[f64]| {
        assert_eq!(found.len(), expected.len());
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?}");
    };
    // Below the eaves all; above them the prism of 10 · 3 / 2 · 6 of 10 · 5 · 6.
    near(fractions(&house(), &[cut([0.0, 0.0, 5.0], [0.0, 0.0, 1.0])]), &[1.0, 0.3]);
    // Along the western slope: all below it but the wedge behind the ridge, which is 5 · 6 / 2 · 6 of the box below.
    // The plane z = 5 + 0.6 x leaves the box at x = 25 / 3, z = 10: below it are 600 − 5 · 25 / 3 / 2 · 6 = 475.
    near(fractions(&house(), &[cut([0.0, 0.0, 5.0], [-0.6, 0.0, 1.0])]), &[390.0 / 475.0, 0.0]);
    // The whole box: 390 of 600, and of the table 60 · 2 + 2 · 2 · 3 · 6.
    near(fractions(&house(), &[]), &[390.0 / 600.0]);
    near(fractions(&table(), &[]), &[192.0 / 600.0]);
    // Under the slab, above it, and within: legs are 4 of 10 m.
    let slab = [cut([0.0, 0.0, 3.0], [0.0, 0.0, 1.0]), cut([0.0, 0.0, 5.0], [0.0, 0.0, 1.0])];
    near(fractions(&table(), &slab), &[0.4, 1.0, 0.0]);
}

#[test]
fn fractions_agree_with_samples() {
    for model in generate(6, 11).models {
        let placed = model.placed();
        let scan = scan(&placed, &Column::Noise001.options(), 0.0, 3).unwrap();
        let site = scan.site("a");
        let building = Partitioned::new(&site, &Parameters::default()).unwrap();
        let truth = Truth::new(&placed.mesh).unwrap();
        let fractions = inside_fraction(&building.complex, &placed.mesh, &truth);
        let (mut off, mut total) = (0.0, 0.0);
        for (cell, (fraction, volume)) in fractions.iter().zip(&building.volumes).enumerate() {
            let mut samples = building.complex.samples(cell as u32, 1e-9, 5);
            samples.remove(0);
            let inside = samples.iter().filter(|p| truth.is_inside(p)).count();
            let sampled = inside as f64 / samples.len().max(1) as f64;
            total += volume;
            off += volume * (sampled - fraction);
            // 32 samples, stratified: a standard error of less than 0.09.
            assert!(samples.is_empty() || (sampled - fraction).abs() < 0.45, "{sampled} {fraction} {volume}");
        }
        assert!((off / total).abs() < 0.01, "{}", off / total);
    }
}

#[test]
fn the_oracle_is_right_by_definition() {
    for mesh in [house(), table()] {
        let subject = subject(mesh, Column::Airborne10);
        let found = observe(&subject, &Oracle::new(&subject), &Parameters::default());
        let cells = found.cells.unwrap();
        assert_eq!((cells.accuracy, cells.iou, cells.all_outside), (Some(1.0), Some(1.0), false));
        assert_eq!((found.near, found.uniform), (Some(1.0), Some(1.0)));
        assert!(cells.calibration.error().unwrap() < 1e-9);
    }
    let subject = subject(house(), Column::Airborne10);
    let surface = observe(&subject, &Oracle::new(&subject), &Parameters::default()).surface.unwrap();
    assert!(surface.volume_iou.unwrap() > 0.99 && surface.symmetric_mean.unwrap() < 0.005, "{surface:?}");
    assert!(surface.roof_rmse.unwrap() < 0.02 && surface.faces == 7, "{surface:?}");
}

#[test]
fn wrong_fields_score_as_worked_out() {
    let subject = subject(house(), Column::Airborne10);
    let places = |places: &Places| {
        let inside = places.inside.iter().filter(|inside| **inside).count();
        1.0 - inside as f64 / places.inside.len() as f64
    };
    // The house has 390 of the 480 m³ of its box.
    assert!((places(&subject.uniform) - 90.0 / 480.0).abs() < 0.06 && (places(&subject.near) - 0.5).abs() < 0.08);
    let building = Partitioned::new(&subject.site, &Parameters::default()).unwrap();
    let fractions = subject.fractions(&building);
    let free: Vec<f64> = building.free().map(|cell| fractions[cell as usize]).collect();
    let outside = free.iter().filter(|fraction| **fraction <= 0.5).count() as f64 / free.len() as f64;
    assert!(outside > 0.0 && outside < 1.0);

    let nothing = observe(&subject, &Distorted(&subject, |_| 0.0), &Parameters::default());
    let cells = nothing.cells.clone().unwrap();
    assert_eq!((cells.accuracy, cells.iou, cells.all_outside), (Some(outside), Some(0.0), true));
    assert_eq!(nothing.near, Some(places(&subject.near)));
    assert_eq!(nothing.uniform, Some(places(&subject.uniform)));
    let mean = free.iter().sum::<f64>() / free.len() as f64;
    assert!((cells.calibration.error().unwrap() - mean).abs() < 1e-12);
    assert!(nothing.surface.is_some(), "the vote explains all");

    let inverted = observe(&subject, &Distorted(&subject, |fraction| 1.0 - fraction), &Parameters::default());
    let cells = inverted.cells.unwrap();
    assert_eq!((cells.accuracy, cells.iou, cells.all_outside), (Some(0.0), Some(0.0), false));
    assert_eq!((inverted.near, inverted.uniform), (Some(0.0), Some(0.0)));
}

#[test]
fn the_vote_knows_no_overhang() {
    let subject = subject(table(), Column::FullView);
    let found = observe(&subject, &HeightField, &Parameters::default());
    // It takes all under the slab for inside, 108 of the 300 m³ of the box, and without a footprint some of what lies
    // beside it.
    let wrong = 1.0 - found.uniform.unwrap();
    assert!((108.0 / 300.0 - 0.06..0.5).contains(&wrong), "{found:?}");
    let subject = self::subject(house(), Column::Airborne50);
    let found = observe(&subject, &HeightField, &Parameters::default());
    assert!(found.uniform.unwrap() > 0.98 && found.near.unwrap() > 0.9, "{found:?}");
}

#[test]
fn giving_up_never_pays() {
    let with = |id: &str, surface: Option<f64>| Findings {
        id: id.into(),
        cells: None,
        near: Some(0.5),
        uniform: None,
        surface: surface.map(|figure| SurfaceFindings {
            volume_iou: Some(figure),
            hausdorff: Some(figure / 10.0),
            symmetric_mean: Some(figure / 100.0),
            roof_rmse: None,
            faces: (10.0 * figure) as usize,
        }),
        failure: None,
        fallback: surface.map(|_| String::new()),
    };
    let figures = Figures::of(&[with("a", Some(0.9)), with("b", None), with("c", Some(0.8))]);
    assert!((figures.volume_iou.unwrap() - 1.7 / 3.0).abs() < 1e-12);
    assert!((figures.hausdorff.unwrap() - 0.09).abs() < 1e-12, "the second of 0.08, 0.09 and infinity");
    assert_eq!((figures.roof_rmse, figures.cell_iou, figures.calibration_error), (None, None, None));
    assert!((figures.lod22.unwrap() - 2.0 / 3.0).abs() < 1e-12 && figures.lod22 == figures.fallback);
    assert_eq!((figures.faces_mean, figures.sign_near, figures.sign_uniform), (Some(8.5), Some(0.5), None));
    assert_eq!(Figures::of(&[with("a", Some(1.0)), with("b", None), with("c", None)]).hausdorff, None);
}

#[test]
fn a_trial_does_not_depend_on_threads() {
    let trial = Trial {
        contenders: vec![
            Contender { name: "oracle".into(), field: None },
            Contender { name: "vote".into(), field: Some(Arc::new(HeightField)) },
        ],
        columns: vec![Column::Airborne5, Column::Everything, Column::OverhangsNoBottom],
        models: generate(3, 5).models,
        overhanging: overhanging(2, 5),
        parameters: Parameters::default(),
        seed: 9,
    };
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        serde_json::to_value(pool.install(|| trial.run(&|_| {}))).unwrap()
    };
    let alone = run(1);
    assert_eq!(alone, run(3));
    let buildings = |column: usize| alone[column]["fields"][0]["buildings"].as_array().unwrap().len();
    assert_eq!([0, 1, 2].map(buildings), [3, 3, 2]);
    for column in 0..3 {
        assert_eq!(alone[column]["fields"][0]["figures"]["cell_accuracy"], 1.0);
        assert_eq!(alone[column]["fields"][0]["figures"]["sign_near"], 1.0);
    }
}
