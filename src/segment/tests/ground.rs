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
    // The ring lies between x = 17 and 33: between 6.7 and 8.3 m.
    assert!((6.7..6.9).contains(&ground.height), "{ground:?}");
    assert!((0.5..1.6).contains(&ground.spread), "{ground:?}");
    // Between two neighbours the ring keeps to the free sides.
    let found = cloud.segment(&footprints, &SegmentOptions::default()).unwrap();
    assert!(found.sites[0].ground.height < 7.0 && found.sites[0].ground.spread < ground.spread);
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
    // Ground 25 m away is out of reach; then the lowest points inside are the roof.
    assert_eq!(ground(&far, &options).source, GroundSource::LowestPoints);
    assert!((ground(&far, &options).height - 7.0).abs() < 0.02);
    // 13 m away it is found by widening.
    let near: Vec<Plain> = points.iter().filter(|(p, c)| *c == 6 || p[0] > 1033.0).copied().collect();
    assert_eq!(ground(&near, &options).source, GroundSource::GroundPoints);
    let three = [([1011.0, 5011.0, 4.0], 6), ([1012.0, 5011.0, 5.0], 6), ([1013.0, 5015.0, 6.0], 6)];
    let last = ground(&three, &options);
    assert_eq!((last.source, last.height), (GroundSource::BoundingBox, 4.0));
    assert_eq!(ground(&roofs, &options).source, GroundSource::LowestPoints);
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
    assert_eq!(bits(&alone.sites), bits(&both.sites[..1]));
}
