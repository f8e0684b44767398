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

/// A COPC file of octree nodes by their keys, over a cube of 100 m, written by hand: the info record, a chunk per node,
/// and the hierarchy.
pub(crate) fn write_copc(path: &Path, nodes: &[([i32; 4], Vec<Plain>)]) {
    let style = Style::default();
    let plain = header(style);
    let items = laz::LazItemRecordBuilder::default_version_of::<laz::las::Point6>(0);
    let vlr = laz::LazVlrBuilder::default().with_laz_items(items).with_variable_chunk_size().build();
    let mut laz_data = Vec::new();
    vlr.write_to(&mut laz_data).unwrap();
    let vlr_of = |user_id: &str, record_id: u16, data: Vec<u8>| las::Vlr {
        user_id: user_id.to_owned(),
        record_id,
        description: String::new(),
        data,
    };
    let mut builder = Builder::from(plain);
    builder.vlrs = vec![vlr_of("copc", 1, vec![0; 160]), vlr_of("laszip encoded", 22204, laz_data)];
    let mut header = builder.into_header().unwrap();
    nodes.iter().flat_map(|(_, points)| points).for_each(|p| header.add_point(&record(&header.clone(), *p)));
    let mut bytes = Vec::new();
    header.write_to(&mut bytes).unwrap();
    let (info, start) = (375 + 54, bytes.len());
    bytes[104] |= 0x80;

    let mut hierarchy = Vec::new();
    let mut body = std::io::Cursor::new(bytes);
    body.set_position(start as u64);
    let mut compressor = laz::LasZipCompressor::new(body, vlr).unwrap();
    compressor.reserve_offset_to_chunk_table().unwrap();
    let mut chunk = start as u64 + 8;
    for (key, points) in nodes {
        let transforms = header.transforms();
        for plain in points {
            let mut raw = Vec::new();
            let point = record(&header, *plain).into_raw(transforms).unwrap();
            point.write_to(&mut raw, header.point_format()).unwrap();
            compressor.compress_one(&raw).unwrap();
        }
        compressor.finish_current_chunk().unwrap();
        let end = compressor.get().position();
        hierarchy.extend(key.map(i32::to_le_bytes).concat());
        hierarchy.extend(chunk.to_le_bytes());
        hierarchy.extend(((end - chunk) as i32).to_le_bytes());
        hierarchy.extend((points.len() as i32).to_le_bytes());
        chunk = end;
    }
    compressor.done().unwrap();
    let mut bytes = compressor.into_inner().into_inner();
    // A foreign extended record before the hierarchy: readers must not stop at the first.
    let evlrs = bytes.len() as u64;
    for (user_id, id, data) in [("other", 7_u16, vec![1; 5]), ("copc", 1000, hierarchy)] {
        let mut head = [0; 60];
        head[2..2 + user_id.len()].copy_from_slice(user_id.as_bytes());
        head[18..20].copy_from_slice(&id.to_le_bytes());
        head[20..28].copy_from_slice(&(data.len() as u64).to_le_bytes());
        bytes.extend(head);
        bytes.extend(data);
    }
    bytes[235..243].copy_from_slice(&evlrs.to_le_bytes());
    bytes[243..247].copy_from_slice(&2_u32.to_le_bytes());
    let size = nodes.len() as u64 * 32;
    let cube = [50.0_f64, 50.0, 50.0, 50.0, 1.0].map(f64::to_le_bytes).concat();
    let root = [bytes.len() as u64 - size, size].map(u64::to_le_bytes).concat();
    bytes[info..info + 40].copy_from_slice(&cube);
    bytes[info + 40..info + 56].copy_from_slice(&root);
    std::fs::write(path, bytes).unwrap();
}
