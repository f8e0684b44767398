//! A compressed tile whose damage sends the decoder of the laz crate into an endless recursion.

use std::path::Path;

/// South-west corner of the made-up house, in the Dutch system.
const CORNER: [f64; 2] = [85_000.0, 447_000.0];
/// Points in a chunk, and in the tile.
const CHUNK: usize = 50_000;
const COUNT: usize = 120_000;
/// Bytes of the header that say where the points begin.
const BEGIN: usize = 96;

/// A tile of a point format with a flat roof of class 6 over [0, 10] × [0, 8] in its first chunk, and the GPS times of its
/// second chunk damaged.
pub fn write_damaged(path: &Path, format: u8) {
    let mut builder = las::Builder::from((1, 4));
    builder.point_format = las::point::Format::new(format).unwrap();
    builder.point_format.is_compressed = true;
    let transform = |offset| las::Transform { scale: 0.001, offset };
    builder.transforms = las::Vector { x: transform(CORNER[0]), y: transform(CORNER[1]), z: transform(0.0) };
    let mut writer = las::Writer::from_path(path, builder.into_header().unwrap()).unwrap();
    for i in 0..COUNT {
        let mixed = (i as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let part = |shift: u32| f64::from((mixed >> shift) as u16);
        // A quarter of a metre apart: the house and what is around it, then ground farther off.
        let (x, y) = (0.25 * (i % 200) as f64 - 9.9, 0.25 * (i / 200) as f64 - 9.9);
        let is_roof = (0.0..10.0).contains(&x) && (0.0..8.0).contains(&y);
        let mut point = las::Point { x: CORNER[0] + x, y: CORNER[1] + y, ..las::Point::default() };
        point.z = if is_roof { 6.0 } else { 0.0 };
        point.classification = las::point::Classification::new(if is_roof { 6 } else { 2 }).unwrap();
        // Times without any order take most of the file.
        point.gps_time = Some(part(8) * 1e3 + part(24) + part(40) * 1e-6);
        writer.write_point(point).unwrap();
    }
    writer.close().unwrap();
    let mut bytes = std::fs::read(path).unwrap();
    let begin = u32::from_le_bytes(std::array::from_fn(|i| bytes[BEGIN + i])) as usize;
    // The times come last in a chunk of layers.
    let from = begin + (bytes.len() - begin) * (CHUNK + CHUNK * 3 / 4) / COUNT;
    bytes[from..from + 60_000].fill(0xff);
    std::fs::write(path, bytes).unwrap();
}
