use super::cloud;
use crate::source::points::fixture::{self, Style};
use crate::source::points::{Block, Tile};
use std::fs;
use std::ops::ControlFlow;
use tempfile::tempdir;

/// Times of four scanners that jump, stand still, run on and change their pace: everything that the coder knows.
fn interleaved_times(format: u8, index: usize, point: &mut las::Point) {
    let i = index as u64;
    let mixed = i.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40;
    let base = [1e5, 3e8, -2.5, 7.25e3][index % 4];
    let pace = [1e-5, 3e-4, 0.5, 1e-9][index / 40 % 4];
    let time = if mixed.is_multiple_of(97) { f64::from_bits(mixed << 20) } else { base + pace * (i / 7) as f64 };
    point.gps_time = Some(time + if mixed.is_multiple_of(11) { 60.0 } else { 0.0 });
    if format >= 6 && index > 500 {
        point.scanner_channel = (mixed / 7 % 4) as u8;
    }
    point.number_of_returns = (mixed % 5 + 1) as u8;
    point.return_number = (mixed / 5 % 5 + 1) as u8;
}

#[test]
fn times_are_decoded_as_they_were_written() {
    let folder = tempdir().unwrap();
    for format in [1, 3, 6, 7] {
        let path = folder.path().join("a.laz");
        fixture::write_with(&path, Style { format, ..Style::default() }, &cloud(120_000), |index, point| {
            interleaved_times(format, index, point);
        });
        let written = |index| {
            let mut point = las::Point::default();
            interleaved_times(format, index, &mut point);
            point.gps_time.unwrap().to_bits()
        };
        let expected: Vec<u64> = (0..120_000).map(written).collect();
        let at = if format < 6 { 20 } else { 22 };
        let mut times = Vec::new();
        let reading = Tile::open(&path).unwrap().stream_records(None, &mut |block| {
            times.extend(block.records().map(|r| u64::from_le_bytes(r[at..at + 8].try_into().unwrap())));
            ControlFlow::Continue(())
        });
        assert_eq!(reading.unwrap().read, 120_000);
        assert!(times == expected, "format {format}");
    }
}

/// The decoder of the laz crate calls itself on such data until the stack overflows.
#[test]
fn times_that_change_their_sequence_without_end_cost_their_chunk_only() {
    let folder = tempdir().unwrap();
    for format in [1, 6] {
        let path = folder.path().join("a.laz");
        fixture::write_with(&path, Style { format, ..Style::default() }, &cloud(120_000), |index, point| {
            interleaved_times(format, index, point);
        });
        let mut bytes = fs::read(&path).unwrap();
        let first = u32::from_le_bytes(bytes[96..100].try_into().unwrap()) as usize + 8;
        if format == 1 {
            bytes[first + 40_000..first + 70_000].fill(0xff);
        } else {
            let sizes = &bytes[first + 34..first + 70];
            let sizes: Vec<usize> = sizes.as_chunks::<4>().0.iter().map(|s| u32::from_le_bytes(*s) as usize).collect();
            let times = first + 70 + sizes[..8].iter().sum::<usize>();
            assert!(sizes[8] > 60_000);
            bytes[times + 8..times + sizes[8]].fill(0xff);
        }
        fs::write(&path, bytes).unwrap();
        let tile = Tile::open(&path).unwrap();
        let mut read = 0;
        let visit = &mut |block: &Block| {
            read += block.len();
            ControlFlow::Continue(())
        };
        let reading = tile.stream_records(None, visit).unwrap();
        assert!((70_000..120_000).contains(&read), "format {format}: {read}");
        let told = reading.problems(&tile)[0].to_string();
        assert!(told.contains(&format!("a.laz: {} of 120000 points are missing", 120_000 - read)), "{told}");
        assert!(told.contains(&format!("in the chunk at byte {first}: the GPS times are damaged")), "{told}");
    }
}
