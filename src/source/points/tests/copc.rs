//! Octrees: which nodes are read.

use super::{assert_same, read};
use crate::source::points::Tile;
use crate::source::points::fixture::{self, Plain};
use std::fs;
use tempfile::tempdir;

/// A root and three nodes below it.
fn nodes() -> Vec<([i32; 4], Vec<Plain>)> {
    let node = |x: f64, y: f64, n: u32| (0..n).map(|i| ([x + f64::from(i) * 0.01, y, 1.0], 6)).collect::<Vec<_>>();
    vec![
        ([0, 0, 0, 0], node(10.0, 10.0, 30)),
        ([1, 0, 0, 0], node(20.0, 20.0, 200)),
        ([1, 1, 0, 0], node(70.0, 20.0, 300)),
        ([1, 1, 1, 0], node(70.0, 70.0, 400)),
    ]
}

#[test]
fn copc_is_read_where_it_is_wanted() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.copc.laz");
    let nodes = nodes();
    fixture::write_copc(&path, &nodes);
    let tile = Tile::open(&path).unwrap();
    assert!(tile.is_copc);
    assert_eq!(tile.points, 930);
    let (all, _) = read(&tile);
    assert_same(&all, &nodes.iter().flat_map(|(_, p)| p.clone()).collect::<Vec<_>>());

    // Something at (80, 80): the root and the node that covers it, in the order of the file.
    let wanted = |low: [f64; 2], high: [f64; 2]| low[0] <= 80.0 && 80.0 <= high[0] && low[1] <= 80.0 && 80.0 <= high[1];
    let mut points = Vec::new();
    let reading = tile.stream(Some(&wanted), &mut |block| points.extend(block.points())).unwrap();
    assert_same(&points, &[nodes[0].1.clone(), nodes[3].1.clone()].concat());
    assert_eq!((reading.expected, reading.read, reading.passed_over), (430, 430, 500));

    // Cut within the last node: the hierarchy is lost and the chunk table too, but not the nodes before.
    let bytes = fs::read(&path).unwrap();
    let cut = bytes.len() - 128 - 125 - 60;
    fs::write(&path, &bytes[..cut]).unwrap();
    let tile = Tile::open(&path).unwrap();
    assert!(!tile.is_copc);
    let (points, reading) = read(&tile);
    assert_same(&points, &nodes[..3].iter().flat_map(|(_, p)| p.clone()).collect::<Vec<_>>());
    assert_eq!(reading.problems(&tile).len(), 1);
}

#[test]
fn the_root_page_may_stand_last() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("a.copc.laz");
    let nodes = nodes();
    fixture::write_copc(&path, &nodes);
    let mut bytes = fs::read(&path).unwrap();
    // The two nodes in the east get a page of their own, and the root, which refers to it, stands behind that.
    let start = bytes.len() - 4 * 32;
    let (west, east) = (bytes[start..start + 64].to_vec(), bytes[start + 64..].to_vec());
    let refers = [[1_i32, 1, 0, 0].map(i32::to_le_bytes).concat(), (start as u64).to_le_bytes().to_vec()].concat();
    let refers = [refers, 64_i32.to_le_bytes().to_vec(), (-1_i32).to_le_bytes().to_vec()].concat();
    bytes.truncate(start);
    bytes.extend([east, west, refers].concat());
    bytes[start - 40..start - 32].copy_from_slice(&(5 * 32_u64).to_le_bytes());
    let info = 375 + 54;
    bytes[info + 40..info + 48].copy_from_slice(&(start as u64 + 64).to_le_bytes());
    bytes[info + 48..info + 56].copy_from_slice(&96_u64.to_le_bytes());
    fs::write(&path, &bytes).unwrap();
    let count = |tile: &Tile| {
        let wanted = |low: [f64; 2], high: [f64; 2]| low[0] <= 80.0 && 80.0 <= high[0] && low[1] <= 80.0 && 80.0 <= high[1];
        let reading = tile.stream(Some(&wanted), &mut |_| {}).unwrap();
        (reading.read, reading.passed_over)
    };
    let tile = Tile::open(&path).unwrap();
    assert!(tile.is_copc);
    assert_eq!(count(&tile), (430, 500));

    // A page that refers to itself is no hierarchy; the points can be read all the same.
    let page = bytes.len() - 32 + 16;
    bytes[page..page + 8].copy_from_slice(&(start as u64 + 64).to_le_bytes());
    fs::write(&path, &bytes).unwrap();
    assert_eq!(count(&Tile::open(&path).unwrap()), (930, 0));
}
