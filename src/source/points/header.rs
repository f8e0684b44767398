//! The header of a tile, checked before any library acts upon it.
//!
//! A damaged header can make a reader panic or ask for tens of gigabytes at once, which nothing can catch. So every
//! length, offset and count is held against the size of the file first.

use super::chunks::Compression;
use crate::error::{Error, InputError, Result};
use crate::source::open::Input;
use las::raw;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

/// Public header block sizes of LAS 1.0 to 1.5 (LAS 1.4 R15, section 2.4; LAS 1.3 and 1.2 likewise; LAS 1.5 R0).
const HEADER_SIZE: [u16; 6] = [227, 227, 227, 235, 375, 393];
/// Byte of the minor version in the header.
const VERSION_MINOR: usize = 25;
/// The latest version that the `las` crate knows. Version 1.5 adds three fields behind those of 1.4, none of which
/// concerns us, and takes the point formats 0 to 5 away: its header is read as one of 1.4 with some bytes more.
const LATEST_KNOWN: u8 = 4;
const VLR_HEADER_SIZE: u64 = 54;
const EVLR_HEADER_SIZE: u64 = 60;
/// More than any real WKT or COPC hierarchy; longer records are passed over.
const LONGEST_EVLR: u64 = 1 << 30;

/// Where and how the points stand in the file.
#[derive(Debug, Clone)]
pub(super) struct Layout {
    /// The version as it stands in the file, minor number of LAS 1.x.
    pub version_minor: u8,
    /// The point format as it stands in the file.
    pub point_format: u8,
    /// Byte at which the points begin.
    pub data_start: u64,
    /// Byte at which something else begins behind them, as far as the header tells.
    pub data_end: Option<u64>,
    /// Size of the file in bytes.
    pub file_size: u64,
    /// Points announced.
    pub points: u64,
    /// Bytes per uncompressed record.
    pub record_len: usize,
    /// How the records are compressed; `None` when they are not.
    pub compression: Option<Compression>,
}

/// Reads and checks the header of the tile at `path`, of `size` bytes; gives it with its variable length records.
///
/// # Errors
/// What is wrong with the header, and where; or that the file cannot be read.
pub(super) fn read(path: &Path, file: &mut BufReader<Input>, size: u64) -> Result<(las::Header, Layout)> {
    let fault = |place: &str, found: String, expected: &str| -> Error {
        InputError::new(path, found, expected)
            .at(place)
            .remedy("The file is damaged or not a LAS file: fetch it again, or repair it")
            .into()
    };
    let io = |e| Error::io(path, "read", e);
    if size == 0 {
        return Err(fault("", "an empty file (0 bytes)".into(), "a LAS, LAZ or COPC tile"));
    }
    let mut start = Vec::new();
    file.by_ref().take(u64::from(HEADER_SIZE[0])).read_to_end(&mut start).map_err(io)?;
    if !start.starts_with(&raw::LASF) {
        let shown: String = start.iter().take(8).map(|b| b.escape_ascii().to_string()).collect();
        return Err(fault("byte 0", format!("'{shown}'"), "the signature 'LASF' of a LAS or LAZ file"));
    }
    let short = |needed: u64| fault("", format!("a file of {size} bytes"), &format!("a header of {needed} bytes"));
    if start.len() < usize::from(HEADER_SIZE[0]) {
        return Err(short(u64::from(HEADER_SIZE[0])));
    }
    let (major, minor) = (start[24], start[25]);
    let Some(&smallest) = HEADER_SIZE.get(usize::from(minor)).filter(|_| major == 1) else {
        let found = format!("LAS version {major}.{minor}");
        let fault = InputError::new(path, found, "LAS version 1.0 to 1.5").at("byte 24");
        return Err(fault.remedy("Write it as one of these, or look whether the file is damaged").into());
    };
    if size < u64::from(smallest) {
        return Err(short(u64::from(smallest)));
    }
    let header_size = u16::from_le_bytes([start[94], start[95]]);
    if header_size == 0 && start[96..100] == [0; 4] {
        let writer = String::from_utf8_lossy(&start[58..90]).trim_end_matches('\0').to_owned();
        let found = format!("a header that was never completed: the program that wrote it ({writer}) was interrupted");
        return Err(InputError::new(path, found, "a finished file").remedy("Make or fetch the file again").into());
    }
    if header_size < smallest || u64::from(header_size) > size {
        return Err(fault("byte 94", format!("a header size of {header_size}"), &format!("{smallest} bytes or more")));
    }
    file.seek(SeekFrom::Start(0)).map_err(io)?;
    let mut head = start;
    head.resize(usize::from(header_size), 0);
    file.read_exact(&mut head).map_err(io)?;
    head[VERSION_MINOR] = minor.min(LATEST_KNOWN);
    let raw_header =
        raw::Header::read_from(head.as_slice()).map_err(|e| fault("header", e.to_string(), "a LAS header"))?;
    let data_start = u64::from(raw_header.offset_to_point_data);
    if data_start < u64::from(header_size) || data_start > size {
        let found = format!("points that begin at byte {data_start}");
        let expected = format!("a byte after the header of {header_size} bytes and within the file of {size}");
        return Err(fault("byte 96", found, &expected));
    }
    let records = u64::from(raw_header.number_of_variable_length_records);
    if records * VLR_HEADER_SIZE > data_start - u64::from(header_size) {
        let found = format!("{records} variable length records");
        return Err(fault("byte 100", found, "as many as fit between header and points"));
    }
    let numbers = [
        ("scale", [raw_header.x_scale_factor, raw_header.y_scale_factor, raw_header.z_scale_factor]),
        ("offset", [raw_header.x_offset, raw_header.y_offset, raw_header.z_offset]),
    ];
    for (name, values) in numbers {
        if values.iter().any(|v| !v.is_finite() || (name == "scale" && *v == 0.0)) {
            return Err(fault(&format!("coordinate {name}"), format!("{values:?}"), "finite numbers, scales not 0"));
        }
    }

    let point_format = raw_header.point_data_record_format & 0x3f;
    if point_format > 10 {
        return Err(fault("byte 104", format!("point format {point_format}"), "a point format from 0 to 10"));
    }
    let record_len = usize::from(raw_header.point_data_record_length);
    let points = match raw_header.large_file {
        Some(large) if large.number_of_point_records > 0 => large.number_of_point_records,
        _ => u64::from(raw_header.number_of_point_records),
    };
    let evlr = raw_header.evlr;
    let behind = [evlr.map(|evlr| evlr.start_of_first_evlr), raw_header.start_of_waveform_data_packet_record];
    let data_end = behind.into_iter().flatten().filter(|start| *start > data_start).min();
    let mut builder = las::Builder::new(raw_header)
        .map_err(|e| fault("byte 104", e.to_string(), "a record length that fits the point format"))?;
    let mut vlrs = file.by_ref().take(data_start - u64::from(header_size));
    for index in 0..records {
        let vlr = raw::Vlr::read_from(&mut vlrs, false)
            .map_err(|_| fault(&format!("VLR {index}"), "one that runs into the points".into(), "shorter records"))?;
        builder.vlrs.push(las::Vlr::new(vlr));
    }
    if let Some(evlr) = evlr {
        builder.evlrs = read_evlrs(file, evlr.start_of_first_evlr, evlr.number_of_evlrs, size);
    }
    let is_compressed = builder.point_format.is_compressed;
    // Writers exist that use a feature of a later version than they state: read what is there.
    let header = builder.clone().into_header().or_else(|e| match builder.minimum_supported_version() {
        Some(version) => {
            builder.version = version;
            builder.into_header()
        }
        None => Err(e),
    });
    let header = header.map_err(|e| fault("header", e.to_string(), "a consistent header"))?;
    let compression = if is_compressed && points > 0 {
        let compression = Compression::of(&header, record_len)
            .map_err(|(found, expected)| fault("the VLR of LASzip", found, &expected))?;
        Some(compression)
    } else {
        None
    };
    let version_minor = minor;
    let file_size = size;
    Ok((
        header,
        Layout { version_minor, point_format, data_start, data_end, file_size, points, record_len, compression },
    ))
}

/// The extended records that matter: CRS and COPC. A file that is cut off has lost its extended records, which stand at
/// its end; that is no reason to refuse its points, so what cannot be read is left out.
fn read_evlrs(file: &mut BufReader<Input>, start: u64, count: u32, size: u64) -> Vec<las::Vlr> {
    let mut found = Vec::new();
    let mut position = start;
    for _ in 0..count {
        let Some(data) = position.checked_add(EVLR_HEADER_SIZE).filter(|data| *data <= size) else { break };
        let mut head = [0; EVLR_HEADER_SIZE as usize];
        if file.seek(SeekFrom::Start(position)).and_then(|_| file.read_exact(&mut head)).is_err() {
            break;
        }
        let length = u64::from_le_bytes(std::array::from_fn(|i| head[20 + i]));
        let Some(end) = data.checked_add(length).filter(|end| *end <= size) else { break };
        let users: [&[u8]; 3] = [b"LASF_Projection\0", b"liblas\0", b"copc\0"];
        let matters = users.iter().any(|user| head[2..18].starts_with(user));
        if matters && length <= LONGEST_EVLR {
            if file.seek(SeekFrom::Start(position)).is_err() {
                break;
            }
            let Ok(record) = raw::Vlr::read_from(file.by_ref(), true) else { break };
            found.push(las::Vlr::new(record));
        }
        position = end;
    }
    found
}
