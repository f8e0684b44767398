//! Writing COPC files (COPC 1.0 on LAS 1.4 R15): a chunk of LAZ for each node of the octree, in any order, and behind the
//! points the hierarchy, which says where they are.

use std::io::{self, Seek, SeekFrom, Write};

use las::copc::{CopcHierarchyVlr, CopcInfoVlr, USER_ID};
use las::{Header, Vlr, raw};
use laz::LazVlr;
use laz::LazVlrBuilder;
use laz::laszip::{ChunkTable, ChunkTableEntry};
use laz::record::{LayeredPointRecordCompressor, RecordCompressor};
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};

use super::octree::{Cube, Node};

/// Bytes of the header, behind which the info record stands.
const HEADER: u32 = 375;
/// Bytes of the heads of records, and of extended ones.
const RECORD: u32 = 54;
const EXTENDED: usize = 60;
/// Nodes that are compressed at once.
const AT_ONCE: usize = 64;

/// Points with what a file says of all of them.
pub(in crate::pipeline) struct Cloud<'a> {
    /// Point formats 6 to 8, CRS, transforms and further records; counts and bounds are not looked at.
    pub header: &'a Header,
    /// The records of the points, one behind the other.
    pub records: &'a [u8],
    /// The lowest and the highest coordinates, as the records have them.
    pub bounds: [[f64; 3]; 2],
    /// The octree.
    pub cube: Cube,
    /// Its nodes, each with one point at least.
    pub nodes: &'a [Node],
}

/// Bytes of a number that a record holds.
fn at<const N: usize>(record: &[u8], place: usize) -> [u8; N] {
    record.get(place..).and_then(|rest| rest.first_chunk()).copied().unwrap_or([0; N])
}

impl Cloud<'_> {
    /// Bytes of a record.
    fn record_len(&self) -> usize {
        usize::from(self.header.point_format().len())
    }

    /// Writes the file. The target does not fail: what went wrong is known to whoever made it.
    ///
    /// # Errors
    /// The header cannot be written as it is, or points cannot be compressed.
    pub fn write(&self, out: &mut (impl Write + Seek), stop: &(dyn Fn() -> bool + Sync)) -> las::Result<bool> {
        let format = self.header.point_format();
        let laz = LazVlrBuilder::default()
            .with_point_format(format.to_u8()?, format.extra_bytes)
            .map_err(las::Error::from)?
            .with_variable_chunk_size()
            .build();
        self.head(out, &laz, [0; 2])?;
        let start = out.stream_position()?;
        out.write_all(&(-1_i64).to_le_bytes())?;
        let mut table = ChunkTable::with_capacity(self.nodes.len());
        let mut hierarchy = Vec::with_capacity(32 * self.nodes.len());
        let mut place = start + 8;
        for nodes in self.nodes.chunks(AT_ONCE) {
            if stop() {
                return Ok(false);
            }
            let chunks: Vec<laz::Result<Vec<u8>>> = nodes.par_iter().map(|node| self.compress(&laz, node)).collect();
            for (node, chunk) in nodes.iter().zip(chunks) {
                let chunk = chunk?;
                let (bytes, points) = (chunk.len() as u64, node.points.len() as u64);
                out.write_all(&chunk)?;
                for number in [node.key.l, node.key.x, node.key.y, node.key.z] {
                    hierarchy.extend(number.to_le_bytes());
                }
                hierarchy.extend(place.to_le_bytes());
                for number in [bytes, points] {
                    let number = i32::try_from(number).map_err(|_| io::Error::other("a node of more than 2 GiB"))?;
                    hierarchy.extend(number.to_le_bytes());
                }
                place += bytes;
                table.push(ChunkTableEntry { point_count: points, byte_count: bytes });
            }
        }
        table.write_to(&mut *out, &laz)?;
        let records = out.stream_position()?;
        let length = hierarchy.len() as u64;
        let record = Vlr {
            user_id: USER_ID.to_owned(),
            record_id: CopcHierarchyVlr::RECORD_ID,
            description: "COPC hierarchy".to_owned(),
            data: hierarchy,
        };
        record.into_raw(true)?.write_to(&mut *out)?;
        // Now that it is known where everything lies.
        out.seek(SeekFrom::Start(start))?;
        out.write_all(&place.to_le_bytes())?;
        out.seek(SeekFrom::Start(0))?;
        self.head(out, &laz, [records, length])?;
        Ok(true)
    }

    /// The points of a node as a chunk of LAZ.
    fn compress(&self, laz: &LazVlr, node: &Node) -> laz::Result<Vec<u8>> {
        let mut chunk = Vec::new();
        {
            let mut compressor = LayeredPointRecordCompressor::new(&mut chunk);
            compressor.set_fields_from(laz.items())?;
            let length = self.record_len();
            for &i in &node.points {
                let start = i as usize * length;
                compressor.compress_next(self.records.get(start..start + length).unwrap_or_default())?;
            }
            compressor.done()?;
        }
        Ok(chunk)
    }

    /// The header and the records before the points. `hierarchy` is where the record of the hierarchy starts, and the
    /// number of bytes of its only page.
    fn head(&self, out: &mut impl Write, laz: &LazVlr, hierarchy: [u64; 2]) -> las::Result<()> {
        let mut raw = self.header.clone().into_raw()?;
        let mut laszip = Vec::new();
        laz.write_to(&mut laszip)?;
        let record = |user_id: &str, record_id, description: &str, data| Vlr {
            user_id: user_id.to_owned(),
            record_id,
            description: description.to_owned(),
            data,
        };
        let mut records = vec![record(
            USER_ID,
            CopcInfoVlr::RECORD_ID,
            "COPC info",
            self.info([hierarchy[0] + EXTENDED as u64, hierarchy[1]]),
        )];
        records.push(record(LazVlr::USER_ID, LazVlr::RECORD_ID, "laszip", laszip));
        records.extend(self.header.all_vlrs().cloned());
        let lengths = records.iter().map(|record| RECORD + record.data.len() as u32);
        raw.offset_to_point_data = HEADER + lengths.sum::<u32>();
        raw.header_size = HEADER as u16;
        raw.number_of_variable_length_records = records.len() as u32;
        raw.point_data_record_format |= 0x80;
        self.count(&mut raw);
        raw.evlr = Some(raw::header::Evlr { start_of_first_evlr: hierarchy[0], number_of_evlrs: 1 });
        raw.padding = Vec::new();
        raw.write_to(&mut *out)?;
        for record in records {
            record.into_raw(false)?.write_to(&mut *out)?;
        }
        Ok(())
    }

    /// How many points there are, of which return, and where they lie.
    fn count(&self, raw: &mut raw::Header) {
        let records = || self.records.chunks_exact(self.record_len());
        let mut by_return = [0; 15];
        for record in records() {
            // Numbers from 1 on; 0 is none.
            if let Some(count) =
                usize::from(at::<1>(record, 14)[0] & 15).checked_sub(1).and_then(|i| by_return.get_mut(i))
            {
                *count += 1;
            }
        }
        // The fields of old readers stay empty: they do not know these point formats.
        raw.number_of_point_records = 0;
        raw.number_of_points_by_return = [0; 5];
        raw.large_file = Some(raw::header::LargeFile {
            number_of_point_records: records().len() as u64,
            number_of_points_by_return: by_return,
        });
        let [low, high] = self.bounds;
        [raw.min_x, raw.min_y, raw.min_z] = low;
        [raw.max_x, raw.max_y, raw.max_z] = high;
    }

    /// The info record; its last eleven numbers are reserved.
    fn info(&self, page: [u64; 2]) -> Vec<u8> {
        let times = self.records.chunks_exact(self.record_len()).map(|record| f64::from_le_bytes(at(record, 22)));
        let (first, last) = times.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), t| (a.min(t), b.max(t)));
        let Cube { centre: [x, y, z], half } = self.cube;
        let mut info: Vec<u8> = [x, y, z, half, self.cube.spacing()].into_iter().flat_map(f64::to_le_bytes).collect();
        info.extend(page.into_iter().flat_map(u64::to_le_bytes));
        info.extend([first, last].into_iter().flat_map(f64::to_le_bytes));
        info.resize(160, 0);
        info
    }
}
