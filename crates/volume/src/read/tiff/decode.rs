//! The samples of a page: strips or tiles, unpacked row by row, so that memory grows only as data
//! comes out of the decompressor.

use super::directory::{Chunk, Compression, Page, Predictor};
use crate::error::{Error, ErrorKind};
use crate::read::Bytes;
use crate::read::bit_fields::unpacked;
use crate::read::block::{Block, ByteReader, Endian, to_native};
use crate::{Sample, Samples, memory, with_samples};
use std::io::{self, BufRead, BufReader, Read};

/// Appends the samples of a page, top row first.
pub(super) fn append(
    page: &Page,
    bytes: &dyn Bytes,
    endian: Endian,
    into: &mut Samples,
) -> Result<(), Error> {
    let decoding = Decoding {
        page,
        bytes,
        endian,
    };
    with_samples!(into, samples => decoding.append(samples))
        .map_err(|error| decoding.explain(error))
}

struct Decoding<'a> {
    page: &'a Page,
    bytes: &'a dyn Bytes,
    endian: Endian,
}

impl Decoding<'_> {
    fn append<T: Sample>(&self, into: &mut Vec<T>) -> Result<(), Error> {
        let page = self.page;
        if page.depth > 1 || page.chunk_depth > 1 {
            return self.append_slices(into);
        }
        let across = page.width.div_ceil(page.chunk_width);
        let mut row = 0;
        for band in page.chunks.chunks(across) {
            let rows = page.chunk_height.min(page.height - row);
            row += rows;
            if page.chunk_width == page.width {
                self.append_chunk(band[0], rows, into)?;
                continue;
            }
            let mut tiles = vec![Vec::new(); across];
            for (&chunk, tile) in band.iter().zip(&mut tiles) {
                self.append_chunk(chunk, rows, tile)?;
            }
            for row in 0..rows {
                let start = into.len();
                memory::grow(into, page.width)?;
                for tile in &tiles {
                    // The last tile may stand out beyond the page.
                    let width = page.chunk_width.min(start + page.width - into.len());
                    into.extend_from_slice(&tile[row * page.chunk_width..][..width]);
                }
            }
        }
        Ok(())
    }

    /// All slices of a page that has several: a layer of tiles is unpacked, then put together slice by slice.
    fn append_slices<T: Sample>(&self, into: &mut Vec<T>) -> Result<(), Error> {
        let page = self.page;
        let across = page.width.div_ceil(page.chunk_width);
        let down = page.height.div_ceil(page.chunk_height);
        let is_tiled = page.chunk_depth > 1 || page.chunk_width != page.width;
        for (layer, chunks) in page.chunks.chunks(across * down).enumerate() {
            let slices = page.chunk_depth.min(page.depth - layer * page.chunk_depth);
            let mut tiles: Vec<Vec<T>> = Vec::new();
            for (i, chunk) in chunks.iter().enumerate() {
                let rows = match is_tiled {
                    true => page.chunk_height * slices,
                    // The last strip is as long as what is left.
                    false => page.chunk_height.min(page.height - i * page.chunk_height),
                };
                let mut tile = Vec::new();
                self.append_chunk(*chunk, rows, &mut tile)?;
                tiles.push(tile);
            }
            for slice in 0..slices {
                for y in 0..page.height {
                    let row = slice * page.chunk_height + y % page.chunk_height;
                    memory::grow(into, page.width)?;
                    for (i, tile) in tiles[y / page.chunk_height * across..][..across]
                        .iter()
                        .enumerate()
                    {
                        let width = page.chunk_width.min(page.width - i * page.chunk_width);
                        into.extend_from_slice(&tile[row * page.chunk_width..][..width]);
                    }
                }
            }
        }
        Ok(())
    }

    /// The first `rows` rows of a strip or tile.
    fn append_chunk<T: Sample>(
        &self,
        chunk: Chunk,
        rows: usize,
        into: &mut Vec<T>,
    ) -> Result<(), Error> {
        let page = self.page;
        let width = page.chunk_width;
        if page.compression == Compression::None && page.is_whole_bytes() && !page.is_reversed {
            let block = Block {
                endian: self.endian,
                ..Block::raw(self.bytes, chunk.offset)
            };
            return block.append_typed(into, width * rows);
        }
        let mut source = self.decoder(chunk)?;
        let mut packed = vec![0; page.chunk_row_bytes()];
        for row in 0..rows {
            source.read_exact(&mut packed).map_err(|error| {
                let row_bytes = packed.len() as u64;
                self.decode_error(error, rows as u64 * row_bytes, row as u64 * row_bytes)
            })?;
            let start = into.len();
            memory::grow(into, width)?;
            if !page.is_whole_bytes() {
                into.extend(
                    unpacked(&packed, page.bits, width).map(|number| T::from_f64(number.into())),
                );
                continue;
            }
            into.resize(start + width, T::zeroed());
            let samples = &mut into[start..];
            if page.predictor == Predictor::FloatingPoint {
                undo_floating_point(&mut packed, samples, page.numbers);
                continue;
            }
            bytemuck::cast_slice_mut(samples).copy_from_slice(&packed);
            to_native(samples, self.endian);
            if page.predictor == Predictor::Horizontal {
                undo_horizontal(samples, page.numbers);
            }
        }
        Ok(())
    }

    fn decoder(&self, chunk: Chunk) -> Result<Box<dyn Read + '_>, Error> {
        let source = Ordered {
            source: ByteReader::new(self.bytes, chunk.offset).take(chunk.bytes),
            is_reversed: self.page.is_reversed,
        };
        let source = BufReader::new(source);
        Ok(match self.page.compression {
            Compression::None => Box::new(source),
            Compression::Deflate => Box::new(flate2::bufread::ZlibDecoder::new(source)),
            Compression::Lzw => Box::new(Lzw::new(source)),
            Compression::PackBits => Box::new(PackBits {
                source,
                run: Run::Literal(0),
            }),
            Compression::Zstd => Box::new(
                ruzstd::decoding::StreamingDecoder::new(source)
                    .map_err(|error| self.decode_error(io::Error::other(error), 0, 0))?,
            ),
        })
    }

    fn decode_error(&self, error: io::Error, expected: u64, found: u64) -> Error {
        match error.kind() {
            io::ErrorKind::UnexpectedEof => ErrorKind::Truncated {
                what: "a strip or tile".into(),
                expected,
                found,
            }
            .into(),
            io::ErrorKind::InvalidData | io::ErrorKind::InvalidInput | io::ErrorKind::Other => {
                ErrorKind::Compression {
                    codec: match self.page.compression {
                        Compression::None => "plain",
                        Compression::Lzw => "LZW",
                        Compression::Deflate => "Deflate",
                        Compression::PackBits => "PackBits",
                        Compression::Zstd => "Zstandard",
                    },
                    why: error.to_string(),
                }
                .into()
            }
            _ => error.into(),
        }
    }

    /// Says in which page.
    fn explain(&self, error: Error) -> Error {
        let page = self.page.number;
        match error.kind() {
            ErrorKind::Truncated {
                what,
                expected,
                found,
            } => ErrorKind::Truncated {
                what: format!("page {page}: {what}"),
                expected: *expected,
                found: *found,
            }
            .into(),
            ErrorKind::Compression { codec, why } => ErrorKind::Compression {
                codec,
                why: format!("page {page}: {why}"),
            }
            .into(),
            _ => error,
        }
    }
}

/// Each stored number is the difference to the same one of the pixel on its left, as bits and modulo their number.
fn undo_horizontal<T: Sample>(row: &mut [T], numbers: usize) {
    macro_rules! sum_up {
        ($unsigned:ty) => {{
            let bits = bytemuck::cast_slice_mut::<T, $unsigned>(row);
            for i in numbers..bits.len() {
                bits[i] = bits[i].wrapping_add(bits[i - numbers]);
            }
        }};
    }
    match size_of::<T>() {
        1 => sum_up!(u8),
        2 => sum_up!(u16),
        4 => sum_up!(u32),
        _ => sum_up!(u64),
    }
}

/// The row's bytes are stored highest bytes of all samples first, each as the difference to the one
/// before (TIFF Technical Note 3).
fn undo_floating_point<T: Sample>(packed: &mut [u8], row: &mut [T], numbers: usize) {
    undo_horizontal(packed, numbers);
    let (size, width) = (size_of::<T>(), row.len());
    let bytes: &mut [u8] = bytemuck::cast_slice_mut(row);
    for (i, sample) in bytes.chunks_exact_mut(size).enumerate() {
        for (k, byte) in sample.iter_mut().enumerate() {
            *byte = packed[k * width + i];
        }
    }
    to_native(row, Endian::Big);
}

/// Stored bytes, with their bits turned round where they lie the other way (as libtiff, before they are unpacked).
struct Ordered<R> {
    source: R,
    is_reversed: bool,
}

impl<R: Read> Read for Ordered<R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let n = self.source.read(into)?;
        if self.is_reversed {
            into[..n]
                .iter_mut()
                .for_each(|byte| *byte = byte.reverse_bits());
        }
        Ok(n)
    }
}

/// LZW as TIFF writes it: codes of 9 to 12 bits, highest bit first, wider one code early.
struct Lzw<R> {
    source: R,
    decoder: weezl::decode::Decoder,
    /// What came out and was not asked for yet: the decoder stops for good when it is given a few bytes of room.
    held: Vec<u8>,
    next: usize,
    ended: bool,
}

/// Room for many of the longest strings that a code stands for (4096 bytes).
const LZW_BYTES: usize = 1 << 16;

impl<R: BufRead> Lzw<R> {
    fn new(source: R) -> Lzw<R> {
        let order = weezl::BitOrder::Msb;
        Lzw {
            source,
            decoder: weezl::decode::Decoder::with_tiff_size_switch(order, 8),
            held: Vec::new(),
            next: 0,
            ended: false,
        }
    }
}

impl<R: BufRead> Read for Lzw<R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        while self.next == self.held.len() && !self.ended && !into.is_empty() {
            self.held.resize(LZW_BYTES, 0);
            let stored = self.source.fill_buf()?;
            let result = self.decoder.decode_bytes(stored, &mut self.held);
            self.source.consume(result.consumed_in);
            match result.status {
                Ok(weezl::LzwStatus::Ok) => {}
                // No end code, as some writers leave it: what is there counts.
                Ok(weezl::LzwStatus::NoProgress | weezl::LzwStatus::Done) => self.ended = true,
                Err(error) => return Err(io::Error::new(io::ErrorKind::InvalidData, error)),
            }
            self.held.truncate(result.consumed_out);
            self.next = 0;
        }
        let n = into.len().min(self.held.len() - self.next);
        into[..n].copy_from_slice(&self.held[self.next..][..n]);
        self.next += n;
        Ok(n)
    }
}

/// Runs of equal bytes (TIFF 6.0, section 9).
struct PackBits<R> {
    source: R,
    run: Run,
}

/// What is left of a run.
#[derive(Clone, Copy)]
enum Run {
    Literal(usize),
    Repeat(u8, usize),
}

impl<R: BufRead> PackBits<R> {
    fn byte(&mut self) -> io::Result<Option<u8>> {
        let byte = self.source.fill_buf()?.first().copied();
        self.source.consume(usize::from(byte.is_some()));
        Ok(byte)
    }
}

impl<R: BufRead> Read for PackBits<R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        if into.is_empty() {
            return Ok(0);
        }
        while let Run::Literal(0) | Run::Repeat(_, 0) = self.run {
            let Some(head) = self.byte()? else {
                return Ok(0);
            };
            self.run = match head as i8 {
                // Stands for nothing.
                -128 => Run::Literal(0),
                n @ 0.. => Run::Literal(n as usize + 1),
                n => {
                    let byte = self.byte()?.ok_or(io::ErrorKind::UnexpectedEof)?;
                    Run::Repeat(byte, 1 + n.unsigned_abs() as usize)
                }
            };
        }
        match &mut self.run {
            Run::Literal(left) => {
                let n = into.len().min(*left);
                let n = self.source.read(&mut into[..n])?;
                if n == 0 {
                    return Err(io::ErrorKind::UnexpectedEof.into());
                }
                *left -= n;
                Ok(n)
            }
            Run::Repeat(byte, left) => {
                let n = into.len().min(*left);
                into[..n].fill(*byte);
                *left -= n;
                Ok(n)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packbits_of_the_specification() {
        let packed = [
            0xfe, 0xaa, 0x02, 0x80, 0x00, 0x2a, 0xfd, 0xaa, 0x03, 0x80, 0x00, 0x2a, 0x22, 0xf7,
            0xaa,
        ];
        let mut plain = Vec::new();
        let mut source = PackBits {
            source: &packed[..],
            run: Run::Literal(0),
        };
        source.read_to_end(&mut plain).unwrap();
        let expected = [
            0xaa, 0xaa, 0xaa, 0x80, 0x00, 0x2a, 0xaa, 0xaa, 0xaa, 0xaa, 0x80, 0x00, 0x2a, 0x22,
            0xaa, 0xaa, 0xaa, 0xaa, 0xaa, 0xaa, 0xaa, 0xaa, 0xaa, 0xaa,
        ];
        assert_eq!(plain, expected);
    }

    #[test]
    fn differences_are_summed_modulo() {
        let mut row = [250u8, 10, 255];
        undo_horizontal(&mut row, 1);
        assert_eq!(row, [250, 4, 3]);
        let mut row = [250u8, 10, 255, 7];
        undo_horizontal(&mut row, 2);
        assert_eq!(row, [250, 10, 249, 17]);
        let mut row = [-1i16, 2];
        undo_horizontal(&mut row, 1);
        assert_eq!(row, [-1, 1]);
    }
}
