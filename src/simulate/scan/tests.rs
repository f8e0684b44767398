use super::super::mesh::Mesh;
use super::super::mesh::tests::block;
use super::super::model::tests::model;
use super::super::span::Span;
use super::super::truth::Truth;
use super::*;

fn clean() -> ScanOptions {
    ScanOptions { neighbours: 0.0, ..ScanOptions::clean() }
}

/// Shares of the points on the roof, the walls and the bottom of the house of the tests, which is 390 m³ between ground and
/// ridge; all must lie on its surface.
fn shares(scan: &Scan, tolerance: f64) -> [f64; 3] {
    let placed = model().placed();
    let truth = Truth::new(&placed.mesh).unwrap();
    let mut counts = [0.0; 3];
    for p in &scan.points {
        assert!(truth.distance(p) <= tolerance, "{p} is {} off", truth.distance(p));
        let side = match p.z {
            z if z < 0.01 => 2,
            z if z > 5.0 && (z - 5.0 - (3.0 - (p.y.abs()))).abs() < 0.05 => 0,
            _ => 1,
        };
        counts[side] += 1.0 / scan.points.len() as f64;
    }
    counts
}

#[test]
fn a_full_view_sees_all_sides_and_no_bottom_does_not() {
    let placed = model().placed();
    let options = |setup| ScanOptions { setup, footprint: 0.0, density: Span::fixed(5.0), ..clean() };
    let full = scan(&placed, &options(SetupChoice::FullView), 0.0, 1).unwrap();
    let [roof, wall, bottom] = shares(&full, 0.002);
    assert!(roof > 0.2 && wall > 0.3 && bottom > 0.1, "{roof} {wall} {bottom}");
    // 60 of bottom, 160 + 18 of walls, 60·√2 of roof: 323 m² at 5 points.
    assert!((1500..1650).contains(&full.points.len()), "{}", full.points.len());
    let upper = scan(&placed, &options(SetupChoice::NoBottom), 0.0, 1).unwrap();
    let [roof, wall, bottom] = shares(&upper, 0.002);
    assert!(roof > 0.3 && wall > 0.3 && bottom < 0.01, "{roof} {wall} {bottom}");
}

#[test]
fn strips_see_the_walls_that_look_at_them() {
    let placed = model().placed();
    let options = |angle| ScanOptions {
        strips: Span::fixed(1.0),
        scan_angle: Span::fixed(angle),
        density: Span::fixed(20.0),
        footprint: 0.0,
        ..clean()
    };
    let vertical = scan(&placed, &options(0.0), 0.0, 4).unwrap();
    let [roof, wall, _] = shares(&vertical, 0.002);
    assert!(wall < 0.03 && roof > 0.97, "{wall}");
    // 20 pulses on each of 60 m²; the lattice leaves a row more or less.
    assert!((1080..1320).contains(&vertical.points.len()), "{}", vertical.points.len());
    let oblique = scan(&placed, &options(30.0), 0.0, 4).unwrap();
    let [_, wall, _] = shares(&oblique, 0.002);
    // Of a wall of height 5, seen at 30°, tan 30° = 0.58 of its area is met: 5.8 to 9.6 m wide, with 60 m² of roof.
    assert!((0.15..0.5).contains(&wall), "{wall}");
    let sides: std::collections::BTreeSet<i8> = oblique
        .points
        .iter()
        .filter(|p| p.z < 4.9 && p.z > 0.1)
        .map(|p| if (p.y + 3.0).abs() < 0.002 { -1 } else { i8::from((p.y - 3.0).abs() < 0.002) })
        .collect();
    assert!(!(sides.contains(&-1) && sides.contains(&1)), "one strip cannot see both long walls");
}

#[test]
fn neighbours_hide_what_is_behind_them() {
    let mut model = model();
    // A tower against the wall in the south, higher than the ridge.
    let tower = block([30_000, -100, 70], [30_100, 0, 370]);
    model.neighbours = vec![std::sync::Arc::new(Mesh::of(&tower))];
    let options = |neighbours| ScanOptions {
        setup: SetupChoice::NoBottom,
        footprint: 0.0,
        density: Span::fixed(10.0),
        neighbours,
        ..clean()
    };
    let on_south_wall = |neighbours| {
        let scan = scan(&model.placed(), &options(neighbours), 0.0, 2).unwrap();
        scan.points.iter().filter(|p| (p.y + 3.0).abs() < 0.002 && p.z < 4.9).count()
    };
    assert!(on_south_wall(0.0) > 100);
    assert_eq!(on_south_wall(1.0), 0);
}

#[test]
fn corruption_has_the_amount_that_was_asked_for() {
    let placed = model().placed();
    let base = ScanOptions { density: Span::fixed(50.0), scan_angle: Span::fixed(0.0), ..clean() };
    let run = |options: ScanOptions| scan(&placed, &options, 0.0, 7).unwrap();
    let all = run(base.clone()).points.len() as f64;
    let missing = run(ScanOptions { roof_missing: Span::fixed(0.1), ..base.clone() }).points.len() as f64;
    assert!((missing / all - 0.9).abs() < 0.003, "{}", missing / all);
    let dropped = run(ScanOptions { dropped: Span::fixed(0.25), ..base.clone() }).points.len() as f64;
    assert!((dropped / all - 0.75).abs() < 0.04);
    let truth = Truth::new(&placed.mesh).unwrap();
    let off = |scan: &Scan, limit: f64| {
        scan.points.iter().filter(|p| truth.distance(p) > limit).count() as f64 / scan.points.len() as f64
    };
    let ghosts = run(ScanOptions { ghosts: Span::fixed(0.2), ..base.clone() });
    assert!((off(&ghosts, 0.1) - 0.2).abs() < 0.04);
    assert!(ghosts.points.iter().all(|p| truth.is_inside(p) || truth.distance(p) < 0.002), "late is below the roof");
    // The normal distribution: 31.7 % lie farther than σ from the plane, which is 0.01 R = 0.1 m here.
    let noisy = run(ScanOptions { noise: Span::fixed(0.01), footprint: 0.0, ..base.clone() });
    assert!((off(&noisy, 0.1) - 0.317).abs() < 0.04, "{}", off(&noisy, 0.1));
    let outliers = run(ScanOptions { outliers: Span::fixed(0.5), footprint: 0.0, ..base.clone() });
    assert!((outliers.points.len() as f64 / all - 1.5).abs() < 0.01);
    // Trees that stop everything over all of the roof leave nothing but themselves.
    let shifted = run(ScanOptions { footprint_shift: Span::fixed(0.5), stray_ground: Span::fixed(1.0), ..base });
    let footprint = shifted.footprint.as_ref().unwrap();
    let ground = shifted.points.iter().filter(|p| p.z < 0.01).count();
    assert!(ground > 0 && shifted.points.iter().all(|p| footprint.contains(&geo::Point::new(p.x, p.y))));
}

#[test]
fn trees_hide_the_roof_and_leave_points_above_it() {
    let placed = model().placed();
    let options = |opacity, chance| ScanOptions {
        density: Span::fixed(20.0),
        tree_chance: chance,
        trees: Span::fixed(6.0),
        tree_opacity: Span::fixed(opacity),
        stray_vegetation: Span::fixed(1.0),
        ..clean()
    };
    let truth = Truth::new(&placed.mesh).unwrap();
    let count = |options: &ScanOptions| {
        let scan = scan(&placed, options, 0.0, 3).unwrap();
        let off = scan.points.iter().filter(|p| truth.distance(p) > 0.01).count();
        (scan.points.len() - off, off)
    };
    let (bare, none) = count(&options(1.0, 0.0));
    assert_eq!(none, 0);
    let (hidden, leaves) = count(&options(1.0, 1.0));
    assert!(hidden < bare && leaves > 0, "{bare} {hidden} {leaves}");
}

#[test]
fn the_surroundings_are_ground() {
    let placed = model().placed();
    let scan = scan(&placed, &ScanOptions { density: Span::fixed(5.0), ..clean() }, 5.0, 9).unwrap();
    assert!(scan.ground_points.len() > 500);
    assert!(scan.ground_points.iter().all(|p| p.z.abs() < 0.002 && !(p.x.abs() < 4.99 && p.y.abs() < 2.99)));
}

#[test]
fn a_scan_depends_on_its_seed_alone() {
    let placed = model().augmented(&mut Random::new(8));
    let training = ScanOptions::training();
    for seed in 0..20 {
        let [a, b] = [0, 1].map(|_| scan(&placed, &training, 0.0, seed).unwrap());
        assert_eq!((&a.points, a.ground, &a.footprint), (&b.points, b.ground, &b.footprint));
        let other = scan(&placed, &training, 0.0, seed + 100).unwrap();
        assert_ne!(a.points, other.points);
        assert!(a.points.len() <= 2 * training.most_points as usize);
    }
}

#[test]
fn matched_pictures_wave_along_the_line_of_sight_and_miss_the_foot_of_walls() {
    let placed = model().placed();
    let options =
        ScanOptions { setup: SetupChoice::Photographs, footprint: 0.0, density: Span::fixed(20.0), ..clean() };
    let exact = scan(&placed, &options, 0.0, 1).unwrap();
    let [roof, wall, bottom] = shares(&exact, 0.002);
    assert!(roof > 0.3 && wall > 0.2 && bottom < 0.01, "{roof} {wall} {bottom}");
    let low = |scan: &Scan| scan.points.iter().filter(|p| p.z < 1.0).count();
    assert!(low(&exact) > 100, "{}", low(&exact));
    let blind = scan(&placed, &ScanOptions { blind_height: Span::fixed(3.0), ..options.clone() }, 0.0, 1).unwrap();
    assert!(low(&blind) * 5 < low(&exact) && blind.points.len() * 2 > exact.points.len(), "{}", low(&blind));
    let plain = scan(&placed, &ScanOptions { texture_missing: Span::fixed(0.9), ..options.clone() }, 0.0, 1).unwrap();
    let left = plain.points.len() as f64 / exact.points.len() as f64;
    assert!((0.4..0.75).contains(&left), "{left}");
    let waves = ScanOptions { ripples: Span::fixed(0.05), ripple_length: Span::fixed(2.0), ..options };
    let waves = scan(&placed, &waves, 0.0, 1).unwrap();
    let truth = Truth::new(&placed.mesh).unwrap();
    let squares: f64 = waves.points.iter().map(|p| truth.distance(p).powi(2)).sum();
    let rms = (squares / waves.points.len() as f64).sqrt();
    // Along the line of sight 0.05; across a surface that is seen obliquely less.
    assert!((0.02..0.05).contains(&rms), "{rms}");
}
