//! Tiles whose headers do not tell where their points lie.

use super::*;

/// Writes another range of x into the header of a tile.
fn state_x(path: &Path, low: f64, high: f64) {
    let mut bytes = std::fs::read(path).unwrap();
    bytes[179..187].copy_from_slice(&high.to_le_bytes());
    bytes[187..195].copy_from_slice(&low.to_le_bytes());
    std::fs::write(path, bytes).unwrap();
}

#[test]
fn no_building_is_lost_to_a_box_that_lies() {
    let (points, footprints) = village();
    let options = SegmentOptions::default();
    let part = |east: bool| points.iter().filter(|(p, _)| (p[0] >= 1019.9) == east).copied().collect::<Vec<_>>();
    for name in ["east.las", "east.laz"] {
        let cloud = || Cloud::new().tile("west.laz", Style::default(), &part(false));
        let cloud = cloud().tile(name, Style { format: 1, ..Style::default() }, &part(true));
        let expected = bits(&cloud.segment(&footprints, &options).unwrap().sites);
        // Far away, wholly or with the first points in it; beside the second house, too.
        for (low, high) in [(5000.0, 5040.0), (1019.9, 1020.1), (1040.0, 1059.6), (1019.9, 1024.0)] {
            state_x(&cloud.tiles[1], low, high);
            let found = cloud.segment(&footprints, &options).unwrap();
            assert!(bits(&found.sites) == expected, "{name}: {low} to {high}");
            let [TileProblem::PointsOutsideExtent { points, read, .. }] = &found.problems[..] else {
                panic!("{:?}", found.problems)
            };
            assert!(*points > 1000 && points <= read);
        }
        // Alone it is not said to lie elsewhere.
        state_x(&cloud.tiles[1], 5000.0, 5040.0);
        let alone = Cloud { tiles: vec![cloud.tiles[1].clone()], folder: tempdir().unwrap() };
        let found = alone.segment(&footprints[1..], &options).unwrap();
        assert!(found.sites[0].coverage.is_complete() && !found.sites[0].points.is_empty());
    }
}

#[test]
fn a_few_strays_outside_the_box_cover_nothing() {
    let (mut points, mut footprints) = village();
    footprints.push(footprint("beyond", block([1300.0, 1310.0], [5010.0, 5020.0])));
    points.push(([1400.0, 5015.0, 3.0], 1));
    let cloud = Cloud::new().tile("a.laz", Style::default(), &points);
    state_x(&cloud.tiles[0], 1000.0, 1059.607);
    let found = cloud.segment(&footprints, &SegmentOptions::default()).unwrap();
    assert_eq!(found.sites[2].coverage.share, 0.0);
    assert!(matches!(found.problems[..], [TileProblem::PointsOutsideExtent { points: 1, .. }]));
}
