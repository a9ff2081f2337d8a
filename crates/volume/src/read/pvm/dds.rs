//! DDS v3, the differential compression around PVM volumes (S. Roettger, V^3 package).
//!
//! ```text
//! bytes 0..8   "DDS v3d\n" or "DDS v3e\n"
//! then bits, the most significant of a byte first:
//!   2   interleave − 1: bytes of a sample were sorted into planes before coding
//!   16  strip − 1: bytes of a row (of one plane)
//!   runs, until one has length 0 or the file ends:
//!     7   number of bytes n
//!     3   code c of the width: 0 → 0 bits, c → c + 1 bits
//!     n × width bits: difference + 2^(width − 1)
//! ```
//!
//! A byte is the one before it, plus what the byte above it gained on its own left neighbor, plus
//! the difference, all modulo 256. The byte above lies `strip` bytes back; the first `strip + 1`
//! bytes have none, and with a strip of 1 there is none at all.
//!
//! v3d sorts the planes over the whole data, v3e over blocks of 2^24 samples, so that the sorting
//! needs bounded memory.

use crate::Error;
use crate::error::ErrorKind;
use crate::read::Bytes;
use std::io;

/// Samples per interleaved block of v3e.
const BLOCK_SAMPLES: u64 = 1 << 24;

/// A power of two above the largest strip + 1: how far back a prediction looks.
const HISTORY: usize = 1 << 17;

/// A DDS file whose magic and two parameters were read.
pub(super) struct Stream<'a> {
    bytes: &'a dyn Bytes,
    interleave: u64,
    strip: usize,
    block_bytes: Option<u64>,
}

impl<'a> Stream<'a> {
    /// Asks for memory that stays.
    ///
    /// # Errors
    /// It is more than whoever reads allows.
    pub(super) fn keep(&self, bytes: u64) -> Result<(), Error> {
        self.bytes.keep(bytes)
    }

    /// The stream in `bytes`, or `None` if the magic is another.
    pub(super) fn open(bytes: &'a dyn Bytes) -> io::Result<Option<Stream<'a>>> {
        let mut magic = [0; 8];
        if bytes.len() < 8 {
            return Ok(None);
        }
        bytes.read_at(0, &mut magic)?;
        let blocks = match &magic {
            b"DDS v3d\n" => false,
            b"DDS v3e\n" => true,
            _ => return Ok(None),
        };
        let mut bits = BitReader::new(bytes, 8);
        let interleave = u64::from(bits.read(2)?) + 1;
        let strip = bits.read(16)? as usize + 1;
        Ok(Some(Stream {
            bytes,
            interleave,
            strip,
            block_bytes: blocks.then_some(interleave * BLOCK_SAMPLES),
        }))
    }

    fn runs(&self) -> io::Result<BitReader<'a>> {
        let mut bits = BitReader::new(self.bytes, 8);
        bits.read(18)?;
        Ok(bits)
    }

    /// How many bytes the stream really holds. Needs no memory: only the runs' heads matter.
    ///
    /// # Errors
    /// If the file ends inside a run.
    pub(super) fn decoded_len(&self) -> Result<u64, Error> {
        let mut bits = self.runs()?;
        let mut total = 0;
        loop {
            let (length, width) = bits.run()?;
            if length == 0 {
                return Ok(total);
            }
            bits.skip(length * width)?;
            if bits.overran() {
                return Err(ErrorKind::Compression {
                    codec: "DDS",
                    why: format!(
                        "the file ends inside a run, after {total} unpacked bytes; it was probably cut off"
                    ),
                }
                .into());
            }
            total += u64::from(length);
        }
    }

    /// Unpacks `total` (= [`Stream::decoded_len`]) bytes and hands each to `put` with its place in
    /// the data, in the order of the stream, until `put` says `false`.
    pub(super) fn decode(
        &self,
        total: u64,
        mut put: impl FnMut(u64, u8) -> bool,
    ) -> io::Result<()> {
        let mut bits = self.runs()?;
        let mut places = Places::new(total, self.interleave, self.block_bytes);
        let mut history = vec![0u8; HISTORY];
        let mut byte = 0u8;
        let mut index = 0usize;
        let strip = self.strip;
        loop {
            let (length, width) = bits.run()?;
            if length == 0 {
                return Ok(());
            }
            let half = (1u32 << width >> 1) as u8;
            for _ in 0..length {
                let difference = (bits.read(width)? as u8).wrapping_sub(half);
                byte = byte.wrapping_add(difference);
                if index > strip && strip > 1 {
                    let above = history[(index - strip) & (HISTORY - 1)];
                    let above_left = history[(index - strip - 1) & (HISTORY - 1)];
                    byte = byte.wrapping_add(above).wrapping_sub(above_left);
                }
                history[index & (HISTORY - 1)] = byte;
                index += 1;
                let Some(place) = places.next() else {
                    return Ok(());
                };
                if !put(place, byte) {
                    return Ok(());
                }
            }
        }
    }
}

/// Where each byte of the stream belongs: plane after plane within each block.
struct Places {
    total: u64,
    interleave: u64,
    block_start: u64,
    block_len: u64,
    plane: u64,
    within: u64,
}

impl Places {
    fn new(total: u64, interleave: u64, block_bytes: Option<u64>) -> Places {
        Places {
            total,
            interleave,
            block_start: 0,
            block_len: block_bytes.unwrap_or(total).min(total),
            plane: 0,
            within: 0,
        }
    }
}

impl Iterator for Places {
    type Item = u64;

    #[inline]
    fn next(&mut self) -> Option<u64> {
        while self.within >= self.block_len {
            self.plane += 1;
            if self.plane >= self.interleave {
                self.block_start += self.block_len;
                self.block_len = self.block_len.min(self.total - self.block_start);
                if self.block_len == 0 {
                    return None;
                }
                self.plane = 0;
            }
            self.within = self.plane;
        }
        let place = self.block_start + self.within;
        self.within += self.interleave;
        Some(place)
    }
}

/// Bits of a file, the most significant of a byte first; zeros after its end.
struct BitReader<'a> {
    bytes: &'a dyn Bytes,
    /// Where the next piece comes from.
    position: u64,
    piece: Vec<u8>,
    at: usize,
    /// The next bits, the first on top.
    window: u64,
    filled: u32,
    /// How many of the filled bits are zeros from behind the end.
    invented: u32,
}

const PIECE_BYTES: u64 = 1 << 16;

impl<'a> BitReader<'a> {
    fn new(bytes: &'a dyn Bytes, position: u64) -> BitReader<'a> {
        BitReader {
            bytes,
            position,
            piece: Vec::new(),
            at: 0,
            window: 0,
            filled: 0,
            invented: 0,
        }
    }

    /// Whether bits were taken that are not in the file.
    fn overran(&self) -> bool {
        self.invented > self.filled
    }

    /// Length and width in bits of the next run; (0, 0) at the end.
    fn run(&mut self) -> io::Result<(u32, u32)> {
        let length = self.read(7)?;
        let code = if length == 0 { 0 } else { self.read(3)? };
        Ok((length, if code == 0 { 0 } else { code + 1 }))
    }

    /// The next `count` (0 to 32) bits.
    #[inline]
    fn read(&mut self, count: u32) -> io::Result<u32> {
        if count == 0 {
            return Ok(0);
        }
        if self.filled < count {
            self.refill()?;
        }
        let value = (self.window >> (64 - count)) as u32;
        self.window <<= count;
        self.filled -= count;
        Ok(value)
    }

    fn skip(&mut self, mut count: u32) -> io::Result<()> {
        while count > 0 {
            let now = count.min(32);
            self.read(now)?;
            count -= now;
        }
        Ok(())
    }

    #[inline]
    fn refill(&mut self) -> io::Result<()> {
        if let Some(eight) = self.piece.get(self.at..self.at + 8) {
            let next = u64::from_be_bytes(eight.try_into().expect("eight bytes"));
            let whole = (64 - self.filled) / 8;
            // Bits below `filled + 8 · whole` are put there again, the same, by the next refill.
            self.window |= next >> self.filled;
            self.filled += 8 * whole;
            self.at += whole as usize;
            return Ok(());
        }
        self.refill_bytewise()
    }

    #[cold]
    fn refill_bytewise(&mut self) -> io::Result<()> {
        // What the fast way left below `filled` would be added twice.
        if self.filled < 64 {
            self.window &= !(u64::MAX >> self.filled);
        }
        while self.filled <= 56 {
            if self.at == self.piece.len() {
                let left = self.bytes.len().saturating_sub(self.position);
                self.piece.resize(left.min(PIECE_BYTES) as usize, 0);
                self.bytes.read_at(self.position, &mut self.piece)?;
                self.position += self.piece.len() as u64;
                self.at = 0;
            }
            match self.piece.get(self.at) {
                Some(&byte) => {
                    self.window |= u64::from(byte) << (56 - self.filled);
                    self.at += 1;
                }
                None => self.invented = (self.invented + 8).min(1 << 20),
            }
            self.filled += 8;
        }
        Ok(())
    }
}

/// The coder, after the same description: only tests write DDS.
#[cfg(test)]
pub(super) mod encode {
    use super::BLOCK_SAMPLES;

    struct BitWriter {
        bytes: Vec<u8>,
        used: u32,
    }

    impl BitWriter {
        fn write(&mut self, value: u32, count: u32) {
            for bit in (0..count).rev() {
                if self.used.is_multiple_of(8) {
                    self.bytes.push(0);
                }
                let last = self.bytes.last_mut().unwrap();
                *last |= ((value >> bit & 1) as u8) << (7 - self.used % 8);
                self.used += 1;
            }
        }
    }

    /// `data` as a DDS file. `max_run` (1 to 127) bounds the runs, so that tests meet many.
    pub(in crate::read::pvm) fn dds(
        data: &[u8],
        interleave: usize,
        strip: usize,
        blocks: bool,
        max_run: usize,
    ) -> Vec<u8> {
        let block = if blocks {
            interleave * BLOCK_SAMPLES as usize
        } else {
            data.len().max(1)
        };
        let planes: Vec<u8> = data
            .chunks(block)
            .flat_map(|block| {
                (0..interleave).flat_map(|plane| block.iter().skip(plane).step_by(interleave))
            })
            .copied()
            .collect();
        let differences: Vec<i8> = (0..planes.len())
            .map(|i| {
                let left = if i > 0 { planes[i - 1] } else { 0 };
                let mut predicted = left;
                if strip > 1 && i > strip {
                    predicted = predicted
                        .wrapping_add(planes[i - strip])
                        .wrapping_sub(planes[i - strip - 1]);
                }
                planes[i].wrapping_sub(predicted) as i8
            })
            .collect();
        let width = |d: i8| match d {
            0 => 0,
            _ => (2..=8)
                .find(|w| (-(1 << (w - 1))..1 << (w - 1)).contains(&i32::from(d)))
                .unwrap(),
        };
        let mut out = BitWriter {
            bytes: if blocks { b"DDS v3e\n" } else { b"DDS v3d\n" }.to_vec(),
            used: 0,
        };
        out.write(interleave as u32 - 1, 2);
        out.write(strip as u32 - 1, 16);
        let mut rest = &differences[..];
        while let Some(&first) = rest.first() {
            let bits = width(first);
            let run = rest
                .iter()
                .take(max_run)
                .take_while(|&&d| width(d) == bits)
                .count();
            out.write(run as u32, 7);
            out.write(if bits == 0 { 0 } else { bits - 1 }, 3);
            for &d in &rest[..run] {
                out.write((i32::from(d) + (1 << bits >> 1)) as u32, bits);
            }
            rest = &rest[run..];
        }
        out.bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn unpack(file: &[u8]) -> Vec<u8> {
        let stream = Stream::open(&file).unwrap().unwrap();
        let total = stream.decoded_len().unwrap();
        let mut data = vec![0; total as usize];
        stream
            .decode(total, |place, byte| {
                data[place as usize] = byte;
                true
            })
            .unwrap();
        data
    }

    /// Coded by hand from the description: interleave 1, strip 1; a run of three of width 2
    /// (+1, −1, 0), then one of width 0, then the end.
    #[test]
    fn hand_made_stream() {
        let mut bits = String::from("00");
        bits += "0000000000000000";
        bits += "0000011 001 11 01 10";
        bits += "0000010 000";
        bits += "0000000";
        let bits: String = bits.chars().filter(|c| *c != ' ').collect();
        let mut file = b"DDS v3d\n".to_vec();
        for byte in bits.as_bytes().chunks(8) {
            let text = format!("{:0<8}", std::str::from_utf8(byte).unwrap());
            file.push(u8::from_str_radix(&text, 2).unwrap());
        }
        assert_eq!(unpack(&file), [1, 0, 0, 0, 0]);
    }

    #[test]
    fn places_of_uneven_blocks() {
        let places: Vec<u64> = Places::new(11, 2, Some(6)).collect();
        assert_eq!(places, [0, 2, 4, 1, 3, 5, 6, 8, 10, 7, 9]);
    }

    #[test]
    fn cut_off_streams_never_grow() {
        let data: Vec<u8> = (0..4000u32).map(|i| ((i * i) >> 7) as u8).collect();
        let file = encode::dds(&data, 2, 40, false, 127);
        for end in 0..file.len() {
            let part = &file[..end];
            if let Some(stream) = Stream::open(&part).unwrap()
                && let Ok(total) = stream.decoded_len()
            {
                assert!(total < data.len() as u64, "cut at {end}");
            }
        }
    }

    proptest! {
        #[test]
        fn round_trip(
            data in proptest::collection::vec(any::<u8>(), 1..2000),
            smooth: bool,
            interleave in 1usize..=4,
            strip in prop_oneof![Just(1usize), 2usize..50, Just(65536)],
            blocks: bool,
            max_run in 1usize..=127,
        ) {
            let data: Vec<u8> = if smooth { data.iter().map(|b| b / 32).collect() } else { data };
            let file = encode::dds(&data, interleave, strip, blocks, max_run);
            prop_assert_eq!(unpack(&file), data);
        }
    }
}
