//! GPS times of the point formats 6 to 10, whose fields are compressed in layers.
//!
//! Whether a point has a time of its own, and which scanner it is from, stands in the layer of the coordinates. So that
//! layer is walked here beside the crate, which keeps what it finds there to itself; see [`super::gps_time`] for why.
//! Only readers of all fields pay for it.

use super::gps_time::{Coding, GpsTimes};
use laz::decoders::ArithmeticDecoder;
use laz::decompressors::{IntegerDecompressor, IntegerDecompressorBuilder};
use laz::models::{ArithmeticModel, ArithmeticModelBuilder};
use std::io::{self, Cursor, Read, Seek, SeekFrom};

/// Layers of the fields that all records have; the first is that of coordinates, returns and scanners, the last that of
/// the times.
const LAYERS: usize = 9;
/// Bytes of those fields, and where in them returns, scanner and time stand (LAS 1.4 R15, table 15).
const FIELDS: usize = 30;
const RETURNS: usize = 14;
const FLAGS: usize = 15;
const TIME: usize = 22;
/// Scanners of one system.
const SCANNERS: usize = 4;

/// What the coder takes for alike of the pairs of number of returns (row) and number of the return (column).
const KINDS_OF_RETURN: [[u8; 16]; 16] = [
    [0, 1, 2, 3, 4, 5, 3, 4, 4, 5, 5, 5, 5, 5, 5, 5],
    [1, 0, 1, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3],
    [2, 1, 2, 4, 4, 4, 4, 4, 4, 4, 4, 3, 3, 3, 3, 3],
    [3, 3, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4],
    [4, 3, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4],
    [5, 3, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4],
    [3, 3, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4, 4],
    [4, 3, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4, 4],
    [4, 3, 4, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4, 4],
    [5, 3, 4, 4, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4, 4],
    [5, 3, 4, 4, 4, 4, 4, 4, 4, 4, 5, 4, 4, 4, 4, 4],
    [5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 4, 4, 4],
    [5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5, 4, 4],
    [5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5, 4],
    [5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5],
    [5, 3, 3, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 4, 5, 5],
];

type Layer = ArithmeticDecoder<Cursor<Vec<u8>>>;

/// Decodes the times of one chunk, record by record.
pub(super) struct LayeredTimes {
    returns: Layer,
    /// `None` when all times of the chunk are those of the first point of their scanner.
    times: Option<Layer>,
    scanners: [Option<Box<Scanner>>; SCANNERS],
    current: usize,
    is_first: bool,
}

impl LayeredTimes {
    /// Reads what it takes of the chunk that begins at byte `start`, with records of `record_len` bytes in `layers`
    /// layers, whose sizes have been checked.
    ///
    /// # Errors
    /// The chunk cannot be read.
    pub fn read<R: Read + Seek>(source: &mut R, start: u64, record_len: usize, layers: u64) -> io::Result<Self> {
        source.seek(SeekFrom::Start(start))?;
        let mut first = [0; FIELDS];
        source.read_exact(&mut first)?;
        source.seek(SeekFrom::Start(start + record_len as u64 + 4))?;
        let mut sizes = [[0; 4]; LAYERS];
        source.read_exact(sizes.as_flattened_mut())?;
        let sizes = sizes.map(u32::from_le_bytes);
        let data = start + record_len as u64 + 4 + 4 * layers;
        let before: u64 = sizes[..LAYERS - 1].iter().map(|size| u64::from(*size)).sum();
        let returns = layer(source, data, sizes[0])?.unwrap_or_else(|| Layer::new(Cursor::default()));
        let times = layer(source, data + before, sizes[LAYERS - 1])?;
        let mut scanners = [const { None }; SCANNERS];
        let current = usize::from(first[FLAGS] >> 4 & 3);
        let time = first[TIME..].first_chunk().map_or(0, |bytes| i64::from_le_bytes(*bytes));
        scanners[current] = Some(Box::new(Scanner::new(first[RETURNS] & 15, first[RETURNS] >> 4, time)));
        Ok(Self { returns, times, scanners, current, is_first: true })
    }

    /// Writes the time of the next record into it.
    ///
    /// # Errors
    /// The data end, or cannot be what a writer wrote.
    pub fn fill(&mut self, record: &mut [u8]) -> io::Result<()> {
        let damaged = || io::Error::new(io::ErrorKind::InvalidData, "the coordinates are damaged");
        if std::mem::take(&mut self.is_first) {
            return Ok(());
        }
        let scanner = self.scanners[self.current].as_mut().ok_or_else(damaged)?;
        let changes = self.returns.decode_symbol(&mut scanner.changes[scanner.place()])?;
        if changes & 1 << 6 != 0 {
            let on = self.returns.decode_symbol(&mut scanner.which)?;
            let (return_number, returns, time) = (scanner.return_number, scanner.returns, scanner.time);
            self.current = (self.current + on as usize + 1) % SCANNERS;
            self.scanners[self.current].get_or_insert_with(|| Box::new(Scanner::new(return_number, returns, time)));
        }
        let scanner = self.scanners[self.current].as_mut().ok_or_else(damaged)?;
        scanner.walk(changes, &mut self.returns)?;
        if let Some(layer) = self.times.as_mut().filter(|_| scanner.has_new_time) {
            scanner.time = scanner.times.next(layer)?;
        }
        if let Some(place) = record.get_mut(TIME..TIME + 8) {
            place.copy_from_slice(&scanner.time.to_le_bytes());
        }
        Ok(())
    }
}

/// The layer of `size` bytes at byte `start`; `None` when it is empty.
fn layer<R: Read + Seek>(source: &mut R, start: u64, size: u32) -> io::Result<Option<Layer>> {
    if size == 0 {
        return Ok(None);
    }
    source.seek(SeekFrom::Start(start))?;
    let mut bytes = vec![0; size as usize];
    source.read_exact(&mut bytes)?;
    let mut layer = Layer::new(Cursor::new(bytes));
    layer.read_init_bytes()?;
    Ok(Some(layer))
}

/// What the coder knows of the last point of a scanner.
struct Scanner {
    return_number: u8,
    returns: u8,
    time: i64,
    has_new_time: bool,
    x: [Median; 12],
    y: [Median; 12],
    changes: [ArithmeticModel; 8],
    /// Tells which scanner the next point is from.
    which: ArithmeticModel,
    returns_model: [Option<ArithmeticModel>; 16],
    return_number_model: [Option<ArithmeticModel>; 16],
    return_number_same_time: ArithmeticModel,
    dx: IntegerDecompressor,
    dy: IntegerDecompressor,
    times: GpsTimes,
}

impl Scanner {
    fn new(return_number: u8, returns: u8, time: i64) -> Self {
        let numbers = |contexts| IntegerDecompressorBuilder::new().bits(32).contexts(contexts).build_initialized();
        let model = |symbols| ArithmeticModelBuilder::new(symbols).build();
        Self {
            return_number,
            returns,
            time,
            has_new_time: false,
            x: Default::default(),
            y: Default::default(),
            changes: std::array::from_fn(|_| model(128)),
            which: model(3),
            returns_model: [const { None }; 16],
            return_number_model: [const { None }; 16],
            return_number_same_time: model(13),
            dx: numbers(2),
            dy: numbers(22),
            times: GpsTimes::new(Coding::Layered, time),
        }
    }

    /// Which model tells what has changed: by whether the last point was the first and the last of its pulse, and had a
    /// time of its own.
    fn place(&self) -> usize {
        usize::from(self.return_number == 1)
            + 2 * usize::from(self.return_number >= self.returns)
            + 4 * usize::from(self.has_new_time)
    }

    /// Decodes returns and coordinates of the next point, of which `changes` tells what has changed.
    fn walk(&mut self, changes: u32, layer: &mut Layer) -> io::Result<()> {
        let last = usize::from(self.return_number);
        self.has_new_time = changes & 1 << 4 != 0;
        if changes & 1 << 2 != 0 {
            self.returns = layer.decode_symbol(of_sixteen(&mut self.returns_model[usize::from(self.returns)]))? as u8;
        }
        let return_number = match changes & 3 {
            0 => last,
            1 => last + 1,
            2 => last + 15,
            _ if self.has_new_time => layer.decode_symbol(of_sixteen(&mut self.return_number_model[last]))? as usize,
            _ => last + layer.decode_symbol(&mut self.return_number_same_time)? as usize + 2,
        };
        self.return_number = (return_number % 16) as u8;
        let kind = KINDS_OF_RETURN[usize::from(self.returns)][usize::from(self.return_number)];
        let place = usize::from(kind) << 1 | usize::from(self.has_new_time);
        let is_only = u32::from(self.returns == 1);
        let x = self.dx.decompress(layer, self.x[place].get(), is_only)?;
        self.x[place].add(x);
        let bits = (self.dx.k() & !1).min(20);
        let y = self.dy.decompress(layer, self.y[place].get(), is_only + bits)?;
        self.y[place].add(y);
        Ok(())
    }
}

/// A model of sixteen symbols that is made when it is first needed.
fn of_sixteen(model: &mut Option<ArithmeticModel>) -> &mut ArithmeticModel {
    model.get_or_insert_with(|| ArithmeticModelBuilder::new(16).build())
}

/// The coder's estimate of the median of the last five numbers: in order, and the largest and the smallest make room for
/// a new one in turn.
#[derive(Clone, Copy)]
struct Median {
    values: [i32; 5],
    is_largest_next: bool,
}

impl Default for Median {
    fn default() -> Self {
        Self { values: [0; 5], is_largest_next: true }
    }
}

impl Median {
    fn get(&self) -> i32 {
        self.values[2]
    }

    fn add(&mut self, value: i32) {
        let middle = self.values[2];
        // The one that makes room is the same as long as the numbers keep to its other side.
        let (makes_room, stays) = if self.is_largest_next { (4, value < middle) } else { (0, middle < value) };
        self.values[makes_room] = value;
        self.values.sort_unstable();
        self.is_largest_next ^= !stays;
    }
}
