//! Polygons with curved edges, and curved types with straight ones.

use std::f64::consts::PI;
use std::slice::from_ref;

use geo::Area;

use super::super::wkb::outline;

/// A geometry of WKB: byte order, type, number of elements, elements.
fn geometry(big_endian: bool, kind: u32, elements: &[Vec<u8>]) -> Vec<u8> {
    let number = |n: u32| if big_endian { n.to_be_bytes() } else { n.to_le_bytes() };
    let head = [&[u8::from(!big_endian)][..], &number(kind), &number(elements.len() as u32)].concat();
    [head, elements.concat()].concat()
}

fn points(big_endian: bool, points: &[[f64; 2]]) -> Vec<Vec<u8>> {
    let bytes = |c: f64| if big_endian { c.to_be_bytes() } else { c.to_le_bytes() };
    points.iter().map(|point| point.iter().flat_map(|c| bytes(*c)).collect()).collect()
}

/// The area of a blob, and what is noted of it.
fn area(blob: &[u8]) -> (f64, Vec<String>) {
    let (polygon, notes) = outline(blob).and_then(super::super::Outline::into_valid).unwrap();
    (polygon.unsigned_area(), notes)
}

const SQUARE: [[f64; 2]; 5] = [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0], [0.0, 0.0]];
const CIRCLE: [[f64; 2]; 3] = [[2.0, 5.0], [8.0, 5.0], [2.0, 5.0]];

#[test]
fn curves_are_straightened_and_straight_ones_are_polygons() {
    for big_endian in [false, true] {
        let line = geometry(big_endian, 2, &points(big_endian, &SQUARE));
        let circle = geometry(big_endian, 8, &points(big_endian, &CIRCLE));
        // Three sides of the square and half a disk beyond the fourth.
        let sides = geometry(big_endian, 2, &points(big_endian, &[[0.0, 10.0], [0.0, 0.0], [10.0, 0.0], [10.0, 10.0]]));
        let arc = geometry(big_endian, 8, &points(big_endian, &[[10.0, 10.0], [5.0, 15.0], [0.0, 10.0]]));
        let compound = geometry(big_endian, 9, &[sides, arc]);

        assert_eq!(area(&geometry(big_endian, 10, from_ref(&line))), (100.0, Vec::new()));
        let (holed, notes) = area(&geometry(big_endian, 10, &[line, circle.clone()]));
        assert!((holed - (100.0 - 9.0 * PI)).abs() < 0.1, "{holed}");
        assert!(notes.len() == 1 && notes[0].contains("within 0.01 units"), "{notes:?}");
        let (domed, notes) = area(&geometry(big_endian, 10, from_ref(&compound)));
        assert!((domed - (100.0 + 12.5 * PI)).abs() < 0.1, "{domed}");
        assert_eq!(notes.len(), 1, "no vertex is repeated where the parts meet: {notes:?}");

        // A surface of several parts, straight and curved.
        let apart = geometry(big_endian, 8, &points(big_endian, &[[20.0, 0.0], [26.0, 0.0], [20.0, 0.0]]));
        let plain_ring = [if big_endian { 5_u32.to_be_bytes() } else { 5_u32.to_le_bytes() }.to_vec()];
        let ring = [&plain_ring[..], &points(big_endian, &SQUARE)].concat().concat();
        let parts = [geometry(big_endian, 3, &[ring]), geometry(big_endian, 10, &[apart])];
        let (both, _) = area(&geometry(big_endian, 12, &parts));
        assert!((both - (100.0 + 9.0 * PI)).abs() < 0.1, "{both}");

        // What is no surface stays none.
        for line in [circle, compound.clone(), geometry(big_endian, 11, &[compound])] {
            assert!(outline(&line).unwrap_err().contains("not a polygon"));
        }
        let two = geometry(big_endian, 8, &points(big_endian, &CIRCLE[..2]));
        assert!(outline(&geometry(big_endian, 10, &[two])).unwrap_err().contains("2 points"));
    }
}
