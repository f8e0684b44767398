//! Small tiles for tests, written by the `las` crate.

use las::point::Classification;
use las::{Builder, Color, Point, Transform, Vector, Version, Writer, point::Format};
use std::path::Path;

/// A point to write: coordinates and class.
pub(crate) type Plain = ([f64; 3], u8);

/// How a tile is to be written.
#[derive(Clone, Copy)]
pub(crate) struct Style {
    pub version: (u8, u8),
    pub format: u8,
    pub scale: f64,
    pub offset: [f64; 3],
}

impl Default for Style {
    fn default() -> Self {
        Self { version: (1, 4), format: 6, scale: 0.001, offset: [0.0; 3] }
    }
}

/// A header in the given style.
pub(crate) fn header(style: Style) -> las::Header {
    let mut builder = Builder::from(Version::new(style.version.0, style.version.1));
    builder.point_format = Format::new(style.format).unwrap();
    builder.has_wkt_crs = style.format >= 6;
    let [x, y, z] = style.offset.map(|offset| Transform { scale: style.scale, offset });
    builder.transforms = Vector { x, y, z };
    builder.into_header().unwrap()
}

/// A full point record for the format of `header`.
pub(crate) fn record(header: &las::Header, (position, class): Plain) -> Point {
    let format = header.point_format();
    let [x, y, z] = position;
    let mut point = Point { x, y, z, return_number: 1, number_of_returns: 1, ..Point::default() };
    point.classification = Classification::new(class).unwrap();
    point.gps_time = format.has_gps_time.then_some(1.0);
    point.color = format.has_color.then(|| Color::new(1, 2, 3));
    point.nir = format.has_nir.then_some(4);
    point.waveform = format.has_waveform.then(Default::default);
    point
}

/// Writes a tile; `.laz` in the name makes it compressed.
pub(crate) fn write(path: &Path, style: Style, points: &[Plain]) {
    write_with(path, style, points, |_, _| {});
}

/// The same, with every point changed before it is written.
pub(crate) fn write_with(path: &Path, style: Style, points: &[Plain], change: impl Fn(usize, &mut Point)) {
    let mut writer = Writer::from_path(path, header(style)).unwrap();
    for (index, plain) in points.iter().enumerate() {
        let mut point = record(writer.header(), *plain);
        change(index, &mut point);
        writer.write_point(point).unwrap();
    }
    writer.close().unwrap();
}
