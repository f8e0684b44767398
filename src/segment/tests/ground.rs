//! The ground of a site, and what stands in for it.

use super::*;

#[test]
fn ground_on_a_slope_is_that_of_the_low_side() {
    // 10 % downwards to the east; the footprint spans 10 m, the ring 3 m more on either side.
    let mut points: Vec<Plain> = Vec::new();
    for i in 0..120 {
        for j in 0..120 {
            let (x, y) = (f64::from(i) * 0.5, f64::from(j) * 0.5);
            let roof = (20.0..30.0).contains(&x) && (20.0..30.0).contains(&y);
            points.push(if roof { ([x, y, 20.0], 6) } else { ([x, y, 10.0 - 0.1 * x], 2) });
        }
    }
    // A hole in the ground, and ground inside another building, are not the ground.
    points.extend([([31.5, 25.0, -20.0], 2), ([18.5, 25.1, 100.0], 2)]);
    let footprints =
        [footprint("a", block([20.0, 30.0], [20.0, 30.0])), footprint("b", block([10.0, 20.0], [20.0, 30.0]))];
    let cloud = Cloud::new().tile("a.laz", Style::default(), &points);
    let found = cloud.segment(&footprints[..1], &SegmentOptions::default()).unwrap();
    let ground = found.sites[0].ground;
    // The ring lies between x = 17 and 33, between 6.7 and 8.3 m, and the outline between 7 and 8 m.
    assert!((ground.height - 7.0).abs() < 0.01, "{ground:?}");
    assert!((0.5..1.6).contains(&ground.spread), "{ground:?}");
    let line = &found.sites[0].ground_line;
    assert_eq!(line.len(), 80);
    assert!(line.iter().all(|p| (p.z - (8.0 - 0.1 * p.x)).abs() < 0.01), "{line:?}");
    // Between two neighbours the ring keeps to the free sides.
    let found = cloud.segment(&footprints, &SegmentOptions::default()).unwrap();
    assert!((found.sites[0].ground.height - 7.0).abs() < 0.01 && found.sites[0].ground.spread < ground.spread);
    // The middle of the outline, and of the plane, lies half a metre higher.
    for level in [GroundLevel::Median, GroundLevel::Plane] {
        let options = SegmentOptions { ground: level, ..SegmentOptions::default() };
        let found = cloud.segment(&footprints[..1], &options).unwrap();
        assert!((found.sites[0].ground.height - 7.5).abs() < 0.03, "{level:?} {:?}", found.sites[0].ground);
    }
}

/// A house of 10 m on ground that `height` says, with noise of `sigma`, ten points per square metre.
fn on_ground(seed: u64, sigma: f64, height: impl Fn(f64, f64) -> f64) -> (Vec<Plain>, Footprint) {
    let mut random = Random::new(seed);
    let mut points = Vec::new();
    for _ in 0..10 * 30 * 30 {
        let (x, y) = (random.between(0.0, 30.0), random.between(0.0, 30.0));
        let noise = sigma * random.bell();
        let is_roof = (10.0..20.0).contains(&x) && (10.0..20.0).contains(&y);
        points.push(if is_roof { ([x, y, 40.0 + noise], 6) } else { ([x, y, height(x, y) + noise], 2) });
    }
    (points, footprint("a", block([10.0, 20.0], [10.0, 20.0])))
}

#[test]
fn noise_does_not_lower_flat_ground() {
    let mut errors: Vec<f64> = (0..9)
        .map(|seed| {
            let (points, house) = on_ground(seed, 0.03, |_, _| 5.0);
            let found = Cloud::new().tile("a.laz", Style::default(), &points);
            let ground = found.segment(&[house], &SegmentOptions::default()).unwrap().sites[0].ground;
            (ground.height - 5.0).abs()
        })
        .collect();
    errors.sort_by(f64::total_cmp);
    assert!(errors[4] < 0.005 && errors[8] < 0.015, "{errors:?}");
}

#[test]
fn a_steep_slope_holds_the_house_on_its_low_side() {
    let (points, house) = on_ground(1, 0.03, |x, _| 30.0 - x);
    let found = Cloud::new().tile("a.laz", Style::default(), &points);
    let site = &found.segment(&[house], &SegmentOptions::default()).unwrap().sites[0];
    assert!((site.ground.height - 10.0).abs() < 0.1, "{:?}", site.ground);
    let least = site.ground_line.iter().map(|p| p.z - site.ground.height).fold(f64::MAX, f64::min);
    let most = site.ground_line.iter().map(|p| p.z - site.ground.height).fold(f64::MIN, f64::max);
    assert!(least.abs() < 0.15 && (most - 10.0).abs() < 0.3, "{least} {most}");
}

#[test]
fn of_terraces_the_lower_one_counts_and_of_pits_none() {
    let floor = |height: fn(f64, f64) -> f64| {
        let (points, house) = on_ground(2, 0.02, height);
        let found = Cloud::new().tile("a.laz", Style::default(), &points);
        found.segment(&[house], &SegmentOptions::default()).unwrap().sites[0].ground.height
    };
    let terraces = floor(|x, _| if x < 15.0 { 3.0 } else { 5.0 });
    assert!((terraces - 3.0).abs() < 0.05, "{terraces}");
    let pit = floor(|x, y| if (13.0..14.5).contains(&x) && (8.5..10.0).contains(&y) { 2.0 } else { 5.0 });
    assert!((pit - 5.0).abs() < 0.02, "{pit}");
    let cars = floor(|x, y| if x < 10.0 && (x + 3.0 * y) % 6.0 < 1.5 { 6.5 } else { 5.0 });
    assert!((cars - 5.0).abs() < 0.03, "{cars}");
}

#[test]
fn ground_falls_back_and_says_so() {
    let (points, footprints) = village();
    let roofs: Vec<Plain> = points.iter().filter(|(_, class)| *class == 6).copied().collect();
    let far: Vec<Plain> = points.iter().filter(|(p, c)| *c == 6 || p[0] > 1045.0).copied().collect();
    let options = SegmentOptions::default();
    let ground = |points: &[Plain], options: &SegmentOptions| {
        let cloud = Cloud::new().tile("a.laz", Style::default(), points);
        cloud.segment(&footprints, options).unwrap().sites[0].ground
    };
    // Ground 25 m away is out of reach, and one neighbour is none; no wall was scanned either, so the roof is all there is.
    assert_eq!(ground(&far, &options).source, GroundSource::BoundingBox);
    assert!((ground(&far, &options).height - 7.0).abs() < 0.02);
    // 13 m away it is found by widening.
    let near: Vec<Plain> = points.iter().filter(|(p, c)| *c == 6 || p[0] > 1033.0).copied().collect();
    assert_eq!(ground(&near, &options).source, GroundSource::GroundPoints);
    let three = [([1011.0, 5011.0, 4.0], 6), ([1012.0, 5011.0, 5.0], 6), ([1013.0, 5015.0, 6.0], 6)];
    let last = ground(&three, &options);
    assert_eq!(last.source, GroundSource::BoundingBox);
    assert!((last.height - 4.0).abs() < 0.02, "{last:?}");
    assert_eq!(ground(&roofs, &options).source, GroundSource::BoundingBox);
}

#[test]
fn ground_inside_a_footprint_is_kept_for_it_alone() {
    let (mut points, footprints) = village();
    // A courtyard of 4 m in the low house, scanned twice, and some ground right behind the wall that both share.
    for row in 0..40 {
        for column in 0..40 {
            let place = [1013.05 + f64::from(column) * 0.1, 5015.05 + f64::from(row) * 0.1, 1.0];
            points.extend([(place, 2), (place, 2)]);
        }
        points.push(([1020.05, 5015.0 + f64::from(row) * 0.1, 1.0], 2));
    }
    let cloud = Cloud::new().tile("a.laz", Style::default(), &points);
    let both = cloud.segment(&footprints, &SegmentOptions::default()).unwrap();
    // One of each half metre.
    let open = &both.sites[0].ground_points;
    assert_eq!(open.len(), 64);
    assert!(open.iter().all(|p| (3.0..7.0).contains(&p.x) && (5.0..9.0).contains(&p.y) && p.z == 1.0));
    assert!(open.is_sorted_by(|a, b| (a.x, a.y, a.z) < (b.x, b.y, b.z)));
    assert_eq!(both.sites[1].ground_points.len(), 8);
    let alone = cloud.segment(&footprints[..1], &SegmentOptions::default()).unwrap();
    assert_eq!(alone.sites[0].ground_points, both.sites[0].ground_points);
    assert_eq!(alone.sites[0].points, both.sites[0].points);
}
