//! Points that name their building.

use super::{block, crs, footprint};
use crate::segment::{Meaning, SegmentOptions, Segmentation, segment, segment_as};
use crate::source::points::{ScanPoint, SpillWriter, Tile};

/// Three points in footprint `a` that name nothing, `b` and a building that there is not, and one that names `a` far away.
fn tiles() -> Vec<Tile> {
    let mut writer = SpillWriter::create(&std::env::temp_dir(), "pushed").unwrap();
    let place = |x: f64| [1000.0 + x, 5000.5, 7.0];
    let points = [
        ScanPoint::new(place(1.0), 6),
        ScanPoint { building: Some(1), ..ScanPoint::new(place(2.0), 6) },
        ScanPoint { building: Some(2), ..ScanPoint::new(place(3.0), 6) },
        ScanPoint { building: Some(0), ..ScanPoint::new(place(900.0), 6) },
        // What is ground stays ground, whatever it names.
        ScanPoint { building: Some(0), ..ScanPoint::new(place(4.0), 2) },
    ];
    for point in &points {
        writer.push(point).unwrap();
    }
    writer.finish(None, Vec::new(), ["a", "b", "c"].map(str::to_owned).into()).unwrap()
}

fn places(found: &Segmentation) -> Vec<Vec<f64>> {
    let place = |site: &crate::site::Site| site.points.iter().map(|p| p.x + site.frame.origin[0] - 1000.0).collect();
    found.sites.iter().map(place).collect()
}

#[test]
fn a_name_goes_before_the_place() {
    let houses = || {
        vec![
            footprint("a", block([1000.0, 1010.0], [5000.0, 5010.0])),
            footprint("b", block([1020.0, 1030.0], [5000.0, 5010.0])),
        ]
    };
    let options = SegmentOptions::default();
    let found = segment(&tiles(), houses(), &crs(1.0), &options, &|_| {}, None).unwrap();
    assert_eq!(places(&found), [vec![1.0, 900.0], vec![2.0]]);
    assert_eq!((found.counts.read, found.counts.kept, found.counts.dropped.unknown_building), (5, 3, 1));
    let named = segment_as(&tiles(), houses(), &crs(1.0), &options, Meaning::PlacesOfNamed, &|_| {}, None).unwrap();
    assert_eq!(places(&named), [vec![900.0], vec![2.0]]);
}
