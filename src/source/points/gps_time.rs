//! GPS times of compressed points.
//!
//! The decoder of the laz crate calls itself whenever the stream says that the next time belongs to another sequence of
//! times. A writer says so once per point at most, but damaged data may say so without end, and the stack overflows,
//! which nothing can catch. So the times are decoded here, in a loop with a bound; all else is left to the crate. The
//! coding is that of `LASzip` (Isenburg 2013, "`LASzip`: lossless compression of lidar data").

use laz::decoders::ArithmeticDecoder;
use laz::decompressors::{IntegerDecompressor, IntegerDecompressorBuilder};
use laz::models::{ArithmeticModel, ArithmeticModelBuilder};
use laz::record::FieldDecompressor;
use std::io::{self, Read};

/// Sequences of times that are kept at once, one for each of several interleaved scanners.
const SEQUENCES: usize = 4;
/// Changes of the sequence that are believed for one point. A writer needs one.
const MOST_CHANGES: usize = 8;
/// From this multiple of the step before on, the multiple is no longer told exactly; likewise below [`LOWEST`].
const HIGHEST: i32 = 500;
const LOWEST: i32 = -10;
/// What stands for "the same time as before" after a step.
const SAME: i32 = HIGHEST - LOWEST + 1;
/// What stands for a time that is written out.
const WRITTEN_OUT: i32 = SAME + 1;
/// Steps far off the one before that make a new usual step.
const FAR_STEPS: i32 = 3;

/// Which of the two codings is read. In layers, a point whose time is that of the one before is told elsewhere, and the
/// two symbols for it are left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Coding {
    /// Point formats 0 to 5, compression version 2.
    Sequential,
    /// Point formats 6 to 10.
    Layered,
}

/// The state of the decoder of times.
pub(super) struct GpsTimes {
    coding: Coding,
    /// The sequence that is in use, and the one that was begun last.
    current: usize,
    newest: usize,
    /// The last time of each sequence, as the bits of the number.
    last: [i64; SEQUENCES],
    /// The usual step of each sequence, in units of the bits.
    step: [i32; SEQUENCES],
    far_steps: [i32; SEQUENCES],
    without_step: ArithmeticModel,
    multiple: ArithmeticModel,
    numbers: IntegerDecompressor,
}

impl GpsTimes {
    /// A decoder after a first point at `time`, the bits of the number.
    pub fn new(coding: Coding, time: i64) -> Self {
        let left_out = u32::from(coding == Coding::Layered);
        let mut last = [0; SEQUENCES];
        last[0] = time;
        Self {
            coding,
            current: 0,
            newest: 0,
            last,
            step: [0; SEQUENCES],
            far_steps: [0; SEQUENCES],
            without_step: ArithmeticModelBuilder::new(6 - left_out).build(),
            multiple: ArithmeticModelBuilder::new((WRITTEN_OUT + 4) as u32 - left_out).build(),
            numbers: IntegerDecompressorBuilder::new().bits(32).contexts(9).build_initialized(),
        }
    }

    /// The next time, as the bits of the number.
    ///
    /// # Errors
    /// The data end, or cannot be what a writer wrote.
    pub fn next<R: Read>(&mut self, decoder: &mut ArithmeticDecoder<R>) -> io::Result<i64> {
        for _ in 0..=MOST_CHANGES {
            let change = match self.step[self.current] {
                0 => self.next_without_step(decoder)?,
                step => self.next_with_step(decoder, step)?,
            };
            if change == 0 {
                return Ok(self.last[self.current]);
            }
            self.current = (self.current + change) % SEQUENCES;
        }
        Err(io::Error::new(io::ErrorKind::InvalidData, "the GPS times are damaged"))
    }

    /// Decodes a time of a sequence without a usual step; gives how many sequences on the time is, should it be none of
    /// this one.
    fn next_without_step<R: Read>(&mut self, decoder: &mut ArithmeticDecoder<R>) -> io::Result<usize> {
        let mut symbol = decoder.decode_symbol(&mut self.without_step)?;
        if self.coding == Coding::Layered {
            symbol += 1;
        }
        match symbol {
            0 => {}
            1 => {
                let step = self.numbers.decompress(decoder, 0, 0)?;
                self.step[self.current] = step;
                self.far_steps[self.current] = 0;
                self.advance(step);
            }
            2 => self.begin_sequence(decoder)?,
            other => return Ok(other as usize - 2),
        }
        Ok(0)
    }

    /// The same for a sequence with a usual `step`: the time is told as a multiple of it and what is off that.
    fn next_with_step<R: Read>(&mut self, decoder: &mut ArithmeticDecoder<R>, step: i32) -> io::Result<usize> {
        let mut symbol = decoder.decode_symbol(&mut self.multiple)? as i32;
        if self.coding == Coding::Layered && symbol >= SAME {
            symbol += 1;
        }
        let (multiple, context, is_far) = match symbol {
            SAME => return Ok(0),
            WRITTEN_OUT => {
                self.begin_sequence(decoder)?;
                return Ok(0);
            }
            _ if symbol > WRITTEN_OUT => return Ok((symbol - WRITTEN_OUT) as usize),
            1 => (1, 1, false),
            ..=0 => (0, 7, true),
            2..10 => (symbol, 2, false),
            10..HIGHEST => (symbol, 3, false),
            HIGHEST => (HIGHEST, 4, true),
            _ if HIGHEST - symbol > LOWEST => (HIGHEST - symbol, 5, false),
            _ => (LOWEST, 6, true),
        };
        let taken = self.numbers.decompress(decoder, step.wrapping_mul(multiple), context)?;
        let far_steps = &mut self.far_steps[self.current];
        if is_far {
            *far_steps += 1;
            if *far_steps > FAR_STEPS {
                self.step[self.current] = taken;
                *far_steps = 0;
            }
        } else if multiple == 1 {
            *far_steps = 0;
        }
        self.advance(taken);
        Ok(0)
    }

    fn advance(&mut self, step: i32) {
        self.last[self.current] = self.last[self.current].wrapping_add(i64::from(step));
    }

    /// A time that is written out begins a sequence of its own, in the place of the oldest.
    fn begin_sequence<R: Read>(&mut self, decoder: &mut ArithmeticDecoder<R>) -> io::Result<()> {
        let high = self.numbers.decompress(decoder, (self.last[self.current] >> 32) as i32, 8)?;
        let low = decoder.read_int()?;
        self.newest = (self.newest + 1) % SEQUENCES;
        self.current = self.newest;
        self.last[self.current] = i64::from(high) << 32 | i64::from(low);
        self.step[self.current] = 0;
        self.far_steps[self.current] = 0;
        Ok(())
    }
}

impl<R: Read> FieldDecompressor<R> for GpsTimes {
    fn size_of_field(&self) -> usize {
        size_of::<f64>()
    }

    fn decompress_first(&mut self, src: &mut R, first_point: &mut [u8]) -> io::Result<()> {
        src.read_exact(first_point)?;
        let bytes = first_point.first_chunk().ok_or(io::ErrorKind::InvalidData)?;
        *self = Self::new(self.coding, i64::from_le_bytes(*bytes));
        Ok(())
    }

    fn decompress_with(&mut self, decoder: &mut ArithmeticDecoder<R>, buf: &mut [u8]) -> io::Result<()> {
        let time = self.next(decoder)?;
        buf.copy_from_slice(&time.to_le_bytes());
        Ok(())
    }
}
