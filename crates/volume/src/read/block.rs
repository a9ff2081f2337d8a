//! The one way from stored bytes to typed samples: every reader finds out where its samples lie and
//! how they are encoded, says so in a [`Block`], and gets a typed vector.
//!
//! Memory is taken only for data that is there. Raw samples: the file is long enough before
//! anything is reserved. Packed samples: the vector grows as bytes come out of the decompressor, up
//! to the number of samples the header promises and never beyond, so a header that lies costs
//! nothing. Samples are read into the memory where they stay; there is no second copy.

use super::Bytes;
use crate::error::{Error, ErrorKind};
use crate::memory::reserve;
use crate::{Sample, SampleType, Samples, cores, with_samples};
use flate2::bufread::{GzDecoder, ZlibDecoder};
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom};

/// How samples are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Encoding {
    /// As they are.
    Raw,
    /// gzip (RFC 1952), one or several members.
    Gzip,
    /// zlib (RFC 1950).
    Zlib,
    /// bzip2, one or several streams.
    Bzip2,
    /// Decimal numbers between white space.
    Ascii,
    /// Two hexadecimal digits per byte; white space means nothing.
    Hex,
}

impl Encoding {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Encoding::Raw => "raw",
            Encoding::Gzip => "gzip",
            Encoding::Zlib => "zlib",
            Encoding::Bzip2 => "bzip2",
            Encoding::Ascii => "ascii",
            Encoding::Hex => "hex",
        }
    }

    /// The most bytes that `stored` ones may become. Deflate sets a limit itself (a match of 258 bytes takes at
    /// least two bits). bzip2 does not: 46 bytes can stand for 45 million, so a file of 12 KB for more than anyone
    /// waits for. It may grow as much as deflate does, or to 1 GiB.
    fn most_unpacked(self, stored: u64) -> u64 {
        const DEFLATE_GROWTH: u64 = 1032;
        const FREE_BYTES: u64 = 1 << 30;
        match self {
            Encoding::Gzip | Encoding::Zlib => stored.saturating_mul(DEFLATE_GROWTH),
            Encoding::Bzip2 => stored.saturating_mul(DEFLATE_GROWTH).max(FREE_BYTES),
            Encoding::Raw | Encoding::Ascii | Encoding::Hex => stored,
        }
    }
}

/// Order of the bytes in a stored number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Endian {
    Little,
    Big,
}

impl Endian {
    pub(crate) const NATIVE: Endian = if cfg!(target_endian = "big") {
        Endian::Big
    } else {
        Endian::Little
    };
}

/// What to make of data after the last sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Trailing {
    /// The format allows it: it is left alone.
    Ignored,
    /// The format does not: an error.
    Refused,
}

/// Where samples lie and how they are stored.
#[derive(Clone, Copy)]
pub(crate) struct Block<'a> {
    /// The file.
    pub(crate) bytes: &'a dyn Bytes,
    /// Position of the first stored (encoded) byte.
    pub(crate) offset: u64,
    /// How the samples are stored.
    pub(crate) encoding: Encoding,
    /// Decoded bytes to leave out before the first sample (ASCII: numbers).
    pub(crate) skip: u64,
    /// Byte order of the decoded samples.
    pub(crate) endian: Endian,
    /// What to make of data after the last sample.
    pub(crate) trailing: Trailing,
}

/// Samples are read and turned to this machine's byte order in pieces that stay in the cache.
const PIECE_BYTES: usize = 1 << 18;

impl<'a> Block<'a> {
    /// Raw little-endian samples from `offset` on, anything after them ignored.
    pub(crate) fn raw(bytes: &'a dyn Bytes, offset: u64) -> Block<'a> {
        Block {
            bytes,
            offset,
            encoding: Encoding::Raw,
            skip: 0,
            endian: Endian::Little,
            trailing: Trailing::Ignored,
        }
    }

    /// `count` samples.
    ///
    /// # Errors
    /// Too few or too many of them, damaged compressed data, a number that is none or does not fit,
    /// no memory, or what the system says.
    pub(crate) fn read(&self, sample_type: SampleType, count: usize) -> Result<Samples, Error> {
        let mut samples = Samples::new(sample_type);
        self.append(&mut samples, count)?;
        Ok(samples)
    }

    /// Appends `count` samples: for volumes that lie in several files. On an error `samples` holds
    /// an unspecified part of them.
    ///
    /// # Errors
    /// As [`Block::read`].
    pub(crate) fn append(&self, samples: &mut Samples, count: usize) -> Result<(), Error> {
        self.bytes.keep(bytes_of(count, samples.sample_type()))?;
        with_samples!(samples, s => self.append_typed(s, count))
    }

    /// As [`Block::append`], for a vector of known type whose memory has been asked for.
    pub(crate) fn append_typed<T: Sample>(
        &self,
        into: &mut Vec<T>,
        count: usize,
    ) -> Result<(), Error> {
        let expected = (count as u64)
            .checked_mul(size_of::<T>() as u64)
            .ok_or_else(|| too_large(count))?;
        let appended = match self.encoding {
            Encoding::Raw => self.append_raw(into, count, expected),
            Encoding::Ascii => self.append_ascii(into, count),
            _ => self.append_packed(into, count, expected),
        };
        if appended.is_err() {
            cores::free(std::mem::take(into));
        }
        appended
    }

    fn append_raw<T: Sample>(
        &self,
        into: &mut Vec<T>,
        count: usize,
        expected: u64,
    ) -> Result<(), Error> {
        let start = self
            .offset
            .checked_add(self.skip)
            .ok_or_else(|| too_large(count))?;
        let found = self.bytes.len().saturating_sub(start);
        if found < expected {
            return Err(truncated(expected, found));
        }
        if found > expected && self.trailing == Trailing::Refused {
            return Err(too_long(expected));
        }
        reserve(into, count)?;
        let mut position = start;
        let end = into.len() + count;
        while into.len() < end {
            let piece = extend_zeroed(into, end);
            let bytes: &mut [u8] = bytemuck::cast_slice_mut(piece);
            self.bytes.read_at(position, bytes).map_err(|error| {
                if error.kind() == io::ErrorKind::UnexpectedEof {
                    truncated(expected, position - start)
                } else {
                    error.into()
                }
            })?;
            position += bytes.len() as u64;
            to_native(piece, self.endian);
        }
        Ok(())
    }

    fn append_packed<T: Sample>(
        &self,
        into: &mut Vec<T>,
        count: usize,
        expected: u64,
    ) -> Result<(), Error> {
        let stored = self.bytes.len().saturating_sub(self.offset);
        let possible = self.encoding.most_unpacked(stored);
        if expected.saturating_add(self.skip) > possible {
            return Err(match self.encoding {
                Encoding::Bzip2 => unpacks_to_too_much(stored, possible),
                _ => truncated(expected, possible.saturating_sub(self.skip)),
            });
        }
        let mut decoder = decoder(self.bytes, self.offset, self.encoding);
        let fail = |found: u64, error| self.decode_error(error, expected, found);
        let skipped = io::copy(&mut (&mut decoder).take(self.skip), &mut io::sink())
            .map_err(|error| fail(0, error))?;
        if skipped < self.skip {
            return Err(truncated(expected, 0));
        }

        let end = into.len() + count;
        let mut found = 0u64;
        while into.len() < end {
            if into.len() == into.capacity() {
                // Four times the packed size is a common gain, so most files need one reservation;
                // then doubling keeps the number of moves small.
                let step = into
                    .len()
                    .max(
                        usize::try_from(stored.saturating_mul(4)).unwrap_or(usize::MAX)
                            / size_of::<T>(),
                    )
                    .max(PIECE_BYTES / size_of::<T>());
                reserve(into, step.min(end - into.len()))?;
            }
            // Few packed bytes may become many samples.
            self.bytes.check()?;
            let piece = extend_zeroed(into, end.min(into.capacity()));
            let bytes: &mut [u8] = bytemuck::cast_slice_mut(piece);
            let mut filled = 0;
            while filled < bytes.len() {
                match decoder.read(&mut bytes[filled..]) {
                    Ok(0) => return Err(truncated(expected, found + filled as u64)),
                    Ok(n) => filled += n,
                    Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                    Err(error) => return Err(fail(found + filled as u64, error)),
                }
            }
            found += filled as u64;
            to_native(piece, self.endian);
        }

        // Asking for one byte more also makes the decompressor compare its checksum.
        match decoder.read(&mut [0]) {
            Ok(0) => Ok(()),
            Ok(_) if self.trailing == Trailing::Ignored => Ok(()),
            Ok(_) => Err(ErrorKind::Compression {
                codec: self.encoding.name(),
                why: format!(
                    "it unpacks to more than the {expected} bytes that the header promises"
                ),
            }
            .into()),
            Err(error) => Err(fail(found, error)),
        }
    }

    fn append_ascii<T: Sample>(&self, into: &mut Vec<T>, count: usize) -> Result<(), Error> {
        // A number and the space behind it take two characters.
        let stored = self.bytes.len().saturating_sub(self.offset);
        let possible = stored.saturating_add(1) / 2;
        let short = |found: u64| {
            Error::from(ErrorKind::Truncated {
                what: "the list of numbers".into(),
                expected: count as u64,
                found,
            })
        };
        if count as u64 > possible {
            return Err(short(possible));
        }
        let mut tokens = Tokens {
            source: BufReader::new(ByteReader::new(self.bytes, self.offset)),
            token: Vec::new(),
        };
        for _ in 0..self.skip {
            tokens.next()?.ok_or_else(|| short(0))?;
        }
        reserve(into, count)?;
        for found in 0..count {
            let token = tokens.next()?.ok_or_else(|| short(found as u64))?;
            into.push(parse_sample(token, found)?);
        }
        if self.trailing == Trailing::Refused && tokens.next()?.is_some() {
            return Err(Error::field(
                "number of samples",
                "larger",
                format!("{count}, as in the header"),
            ));
        }
        Ok(())
    }

    fn decode_error(&self, error: io::Error, expected: u64, found: u64) -> Error {
        decode_error(self.encoding, error, expected, found)
    }
}

/// The first decoded bytes from `offset` on, at most `limit`: fewer if there are no more.
///
/// # Errors
/// Damaged compressed data, or what the system says.
pub(crate) fn head(
    bytes: &dyn Bytes,
    offset: u64,
    encoding: Encoding,
    limit: usize,
) -> Result<Vec<u8>, Error> {
    let mut into = Vec::new();
    match decoder(bytes, offset, encoding)
        .take(limit as u64)
        .read_to_end(&mut into)
    {
        Ok(_) => Ok(into),
        // A cut-off stream: what came out before still says what it is.
        Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => Ok(into),
        Err(error) => Err(decode_error(
            encoding,
            error,
            limit as u64,
            into.len() as u64,
        )),
    }
}

/// How many bytes everything from `offset` on unpacks to. They are counted, and not kept.
///
/// # Errors
/// Damaged data; more bytes than so few stored ones may become; what the system says.
pub(crate) fn unpacked_length(
    bytes: &dyn Bytes,
    offset: u64,
    encoding: Encoding,
) -> Result<u64, Error> {
    let stored = bytes.len().saturating_sub(offset);
    length_within(bytes, offset, encoding, encoding.most_unpacked(stored))
}

fn length_within(
    bytes: &dyn Bytes,
    offset: u64,
    encoding: Encoding,
    most: u64,
) -> Result<u64, Error> {
    let mut decoder = decoder(bytes, offset, encoding);
    let mut piece = vec![0; PIECE_BYTES];
    let mut length = 0;
    loop {
        // Few stored bytes may become many, so that nobody else asks.
        bytes.check()?;
        match decoder.read(&mut piece) {
            Ok(0) => return Ok(length),
            Ok(n) => length += n as u64,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => {
                return Err(ErrorKind::Compression {
                    codec: encoding.name(),
                    why: error.to_string(),
                }
                .into());
            }
        }
        if length > most {
            return Err(unpacks_to_too_much(
                bytes.len().saturating_sub(offset),
                most,
            ));
        }
    }
}

fn unpacks_to_too_much(stored: u64, most: u64) -> Error {
    Error::field(
        "the unpacked size",
        format!("more than {most} bytes"),
        format!("up to {most} bytes for {stored} packed ones; unpack the file first"),
    )
}

/// Everything from `offset` on, decoded. ASCII is handed out as it is.
pub(crate) fn decoder<'a>(
    bytes: &'a dyn Bytes,
    offset: u64,
    encoding: Encoding,
) -> Box<dyn Read + Send + 'a> {
    let source = BufReader::with_capacity(1 << 14, ByteReader::new(bytes, offset));
    match encoding {
        Encoding::Raw | Encoding::Ascii => Box::new(source),
        Encoding::Gzip => Box::new(GzipMembers::Inside(Box::new(GzDecoder::new(source)))),
        Encoding::Zlib => Box::new(ZlibDecoder::new(source)),
        Encoding::Bzip2 => Box::new(bzip2::bufread::MultiBzDecoder::new(source)),
        Encoding::Hex => Box::new(HexDecoder { source }),
    }
}

/// Bytes of `count` samples.
pub(crate) fn bytes_of(count: usize, sample_type: SampleType) -> u64 {
    (count as u64).saturating_mul(sample_type.size() as u64)
}

/// The bytes of a file from a position on, as a stream.
pub(crate) struct ByteReader<'a> {
    bytes: &'a dyn Bytes,
    position: u64,
}

impl<'a> ByteReader<'a> {
    pub(crate) fn new(bytes: &'a dyn Bytes, position: u64) -> ByteReader<'a> {
        ByteReader { bytes, position }
    }
}

impl Read for ByteReader<'_> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let left = self.bytes.len().saturating_sub(self.position);
        let n = into.len().min(usize::try_from(left).unwrap_or(usize::MAX));
        self.bytes.read_at(self.position, &mut into[..n])?;
        self.position += n as u64;
        Ok(n)
    }
}

impl Seek for ByteReader<'_> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let position = match to {
            SeekFrom::Start(position) => Some(position),
            SeekFrom::Current(by) => self.position.checked_add_signed(by),
            SeekFrom::End(by) => self.bytes.len().checked_add_signed(by),
        };
        self.position = position.ok_or(io::ErrorKind::InvalidInput)?;
        Ok(self.position)
    }
}

/// All members of a gzip file, one after the other. Whatever follows the last member and does not
/// begin like another one (tapes and some tools pad with zeros) ends the data.
enum GzipMembers<R> {
    Inside(Box<GzDecoder<R>>),
    Ended,
}

impl<R: BufRead> Read for GzipMembers<R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        if into.is_empty() {
            return Ok(0);
        }
        loop {
            let GzipMembers::Inside(member) = self else {
                return Ok(0);
            };
            let n = member.read(into)?;
            if n > 0 {
                return Ok(n);
            }
            let GzipMembers::Inside(member) = std::mem::replace(self, GzipMembers::Ended) else {
                return Ok(0);
            };
            let mut source = member.into_inner();
            if source.fill_buf()?.first() == Some(&0x1f) {
                *self = GzipMembers::Inside(Box::new(GzDecoder::new(source)));
            }
        }
    }
}

struct HexDecoder<R> {
    source: R,
}

impl<R: BufRead> HexDecoder<R> {
    fn digit(&mut self) -> io::Result<Option<u8>> {
        loop {
            let Some(&c) = self.source.fill_buf()?.first() else {
                return Ok(None);
            };
            self.source.consume(1);
            match char::from(c).to_digit(16) {
                Some(digit) => return Ok(Some(digit as u8)),
                None if c.is_ascii_whitespace() => {}
                None => {
                    return Err(io::Error::new(
                        io::ErrorKind::InvalidData,
                        format!("'{}' is not a hexadecimal digit", c.escape_ascii()),
                    ));
                }
            }
        }
    }
}

impl<R: BufRead> Read for HexDecoder<R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        for (n, byte) in into.iter_mut().enumerate() {
            let Some(high) = self.digit()? else {
                return Ok(n);
            };
            let low = self.digit()?.ok_or(io::ErrorKind::UnexpectedEof)?;
            *byte = high << 4 | low;
        }
        Ok(into.len())
    }
}

/// Words between white space (or commas, which some writers add).
struct Tokens<R> {
    source: R,
    token: Vec<u8>,
}

impl<R: BufRead> Tokens<R> {
    /// No number that a program writes is longer.
    const LONGEST: usize = 400;

    fn next(&mut self) -> Result<Option<&str>, Error> {
        self.token.clear();
        loop {
            let buffer = self.source.fill_buf()?;
            if buffer.is_empty() {
                break;
            }
            let separates = |c: &u8| c.is_ascii_whitespace() || *c == b',';
            if self.token.is_empty() {
                let blank = buffer.iter().take_while(|c| separates(c)).count();
                if blank > 0 {
                    self.source.consume(blank);
                    continue;
                }
            }
            let word = buffer.iter().take_while(|c| !separates(c)).count();
            let ended = word < buffer.len();
            if self.token.len() + word > Self::LONGEST {
                return Err(Error::field(
                    "a number in the list of samples",
                    format!("longer than {} characters", Self::LONGEST),
                    "numbers between white space",
                ));
            }
            self.token.extend_from_slice(&buffer[..word]);
            self.source.consume(word);
            if ended {
                break;
            }
        }
        if self.token.is_empty() {
            return Ok(None);
        }
        std::str::from_utf8(&self.token).map(Some).map_err(|_| {
            Error::field(
                "a number in the list of samples",
                self.token.escape_ascii(),
                "a decimal number",
            )
        })
    }
}

fn parse_sample<T: Sample>(token: &str, index: usize) -> Result<T, Error> {
    let wrong = || {
        Error::field(
            format!("sample {index}"),
            format!("`{token}`"),
            format!("a decimal number of type {}", T::TYPE),
        )
    };
    let value = match T::TYPE {
        // Straight to f32: by way of f64 it could be rounded twice.
        SampleType::F32 => f64::from(token.parse::<f32>().map_err(|_| wrong())?),
        SampleType::F64 => token.parse::<f64>().map_err(|_| wrong())?,
        _ => token.parse::<i64>().map_err(|_| wrong())? as f64,
    };
    let sample = T::from_f64(value);
    if T::TYPE.is_integer() && sample.to_f64() != value {
        return Err(wrong());
    }
    Ok(sample)
}

/// Lengthens `into` by one piece of zeros, to at most `end`, and returns the piece.
fn extend_zeroed<T: Sample>(into: &mut Vec<T>, end: usize) -> &mut [T] {
    let start = into.len();
    let piece = (PIECE_BYTES / size_of::<T>()).min(end - start);
    into.resize(start + piece, T::zeroed());
    &mut into[start..]
}

/// Turns samples in `endian` order, in place, into this machine's order.
pub(crate) fn to_native<T: Sample>(samples: &mut [T], endian: Endian) {
    if endian != Endian::NATIVE && size_of::<T>() > 1 {
        for sample in samples {
            *sample = sample.swapped();
        }
    }
}

fn decode_error(encoding: Encoding, error: io::Error, expected: u64, found: u64) -> Error {
    match error.kind() {
        io::ErrorKind::UnexpectedEof => truncated(expected, found),
        io::ErrorKind::InvalidInput | io::ErrorKind::InvalidData | io::ErrorKind::Other => {
            ErrorKind::Compression {
                codec: encoding.name(),
                why: error.to_string(),
            }
            .into()
        }
        _ => error.into(),
    }
}

fn truncated(expected: u64, found: u64) -> Error {
    ErrorKind::Truncated {
        what: "the sample data".into(),
        expected,
        found,
    }
    .into()
}

fn too_long(expected: u64) -> Error {
    Error::field(
        "size of the sample data",
        "larger",
        format!("{expected} bytes, as in the header"),
    )
}

fn too_large(count: usize) -> Error {
    Error::field(
        "number of samples",
        count,
        "fewer than this machine can address",
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::Compression;
    use flate2::write::{GzEncoder, ZlibEncoder};
    use std::io::Write;

    fn packed(encoding: Encoding, data: &[u8]) -> Vec<u8> {
        match encoding {
            Encoding::Raw => data.to_vec(),
            Encoding::Gzip => {
                let mut w = GzEncoder::new(Vec::new(), Compression::default());
                w.write_all(data).unwrap();
                w.finish().unwrap()
            }
            Encoding::Zlib => {
                let mut w = ZlibEncoder::new(Vec::new(), Compression::default());
                w.write_all(data).unwrap();
                w.finish().unwrap()
            }
            Encoding::Bzip2 => {
                let mut w = bzip2::write::BzEncoder::new(Vec::new(), bzip2::Compression::best());
                w.write_all(data).unwrap();
                w.finish().unwrap()
            }
            Encoding::Hex => data
                .iter()
                .flat_map(|b| format!("{b:02x}\n").into_bytes())
                .collect(),
            Encoding::Ascii => unreachable!("numbers, not bytes"),
        }
    }

    #[expect(
        clippy::ptr_arg,
        reason = "a slice has no size, so it cannot become a trait object"
    )]
    fn block(bytes: &Vec<u8>, encoding: Encoding) -> Block<'_> {
        Block {
            encoding,
            trailing: Trailing::Refused,
            ..Block::raw(bytes, 0)
        }
    }

    const PACKED: [Encoding; 4] = [
        Encoding::Gzip,
        Encoding::Zlib,
        Encoding::Bzip2,
        Encoding::Hex,
    ];

    #[test]
    fn every_encoding_gives_the_samples_in_both_byte_orders() {
        let values: Vec<i16> = (0..300_000)
            .map(|i| (i * 7 % 65_536 - 32_768) as i16)
            .collect();
        for endian in [Endian::Little, Endian::Big] {
            let data: Vec<u8> = values
                .iter()
                .flat_map(|v| match endian {
                    Endian::Little => v.to_le_bytes(),
                    Endian::Big => v.to_be_bytes(),
                })
                .collect();
            for encoding in [&[Encoding::Raw][..], &PACKED].concat() {
                let file = packed(encoding, &data);
                let block = Block {
                    endian,
                    ..block(&file, encoding)
                };
                let samples = block.read(SampleType::I16, values.len()).unwrap();
                assert_eq!(samples, Samples::I16(values.clone()), "{encoding:?}");
                let skipping = Block {
                    skip: 2000,
                    ..block
                };
                let rest = skipping.read(SampleType::I16, values.len() - 1000).unwrap();
                assert_eq!(rest, Samples::I16(values[1000..].to_vec()), "{encoding:?}");
            }
        }
    }

    #[test]
    fn a_cut_off_block_is_an_error_at_every_length() {
        let data: Vec<u8> = (0..200u8).collect();
        for encoding in [&[Encoding::Raw][..], &PACKED].concat() {
            let file = packed(encoding, &data);
            for length in 0..file.len() {
                let cut = file[..length].to_vec();
                let result = block(&cut, encoding).read(SampleType::U8, 200);
                // Hex ends in a line break that may go.
                if encoding != Encoding::Hex || length < file.len() - 1 {
                    assert!(result.is_err(), "{encoding:?} cut to {length} bytes");
                }
            }
        }
    }

    #[test]
    fn more_than_promised_is_refused_and_costs_no_memory() {
        let zeros = vec![0u8; 4 << 20];
        for encoding in [Encoding::Gzip, Encoding::Zlib, Encoding::Bzip2] {
            let file = packed(encoding, &zeros);
            let mut samples = Samples::new(SampleType::U8);
            let error = block(&file, encoding).append(&mut samples, 10).unwrap_err();
            assert!(
                error.to_string().contains("more than the 10 bytes"),
                "{error}"
            );
            let Samples::U8(s) = samples else {
                unreachable!()
            };
            assert!(s.capacity() <= 64, "{} bytes reserved", s.capacity());
            let lenient = Block {
                trailing: Trailing::Ignored,
                ..block(&file, encoding)
            };
            assert_eq!(lenient.read(SampleType::U8, 10).unwrap().len(), 10);
        }
        let raw = vec![0u8; 11];
        assert!(block(&raw, Encoding::Raw).read(SampleType::U8, 10).is_err());
    }

    #[test]
    fn unpacking_ends_where_it_is_too_much() {
        let zeros = vec![0u8; 4 << 20];
        for encoding in [Encoding::Gzip, Encoding::Zlib, Encoding::Bzip2] {
            let file = packed(encoding, &zeros);
            assert_eq!(unpacked_length(&file, 0, encoding).unwrap(), 4 << 20);
            let error = length_within(&file, 0, encoding, 1 << 20).unwrap_err();
            let error = error.to_string();
            assert!(error.contains("up to 1048576 bytes"), "{error}");
        }
        // bzip2 sets no limit itself: a claim that little cannot keep is refused before it is unpacked.
        let file = packed(Encoding::Bzip2, &zeros);
        let bomb = Block {
            skip: 1 << 40,
            ..block(&file, Encoding::Bzip2)
        };
        let error = bomb.read(SampleType::U8, 10).unwrap_err().to_string();
        assert!(error.contains("unpack the file first"), "{error}");
    }

    #[test]
    fn a_lying_header_takes_no_memory() {
        for encoding in [&[Encoding::Raw, Encoding::Ascii][..], &PACKED].concat() {
            let file = if encoding == Encoding::Ascii {
                b"1 2 3".to_vec()
            } else {
                packed(encoding, &[1, 2, 3])
            };
            for claim in [4, 1 << 40, usize::MAX / 8, usize::MAX] {
                let mut samples = Samples::new(SampleType::F64);
                assert!(block(&file, encoding).append(&mut samples, claim).is_err());
                let Samples::F64(s) = samples else {
                    unreachable!()
                };
                assert!(s.capacity() * 8 <= PIECE_BYTES, "{encoding:?} {claim}");
            }
        }
    }

    #[test]
    fn damage_is_noticed_by_the_checksum() {
        let data: Vec<u8> = (0..100_000u32)
            .map(|i| (i.wrapping_mul(i) >> 7) as u8)
            .collect();
        for encoding in [Encoding::Gzip, Encoding::Zlib, Encoding::Bzip2] {
            let mut file = packed(encoding, &data);
            let near_the_end = file.len() - 6;
            file[near_the_end] ^= 0x10;
            assert!(
                block(&file, encoding)
                    .read(SampleType::U8, data.len())
                    .is_err()
            );
        }
    }

    #[test]
    fn several_gzip_members_and_padding_are_one_stream() {
        let mut file = packed(Encoding::Gzip, &[1, 2, 3]);
        file.extend(packed(Encoding::Gzip, &[4, 5]));
        file.extend([0; 512]);
        let samples = block(&file, Encoding::Gzip)
            .read(SampleType::U8, 5)
            .unwrap();
        assert_eq!(samples, Samples::U8(vec![1, 2, 3, 4, 5]));
    }

    #[test]
    fn ascii_numbers_are_parsed_strictly() {
        let read = |text: &str, sample_type, count| {
            block(&text.as_bytes().to_vec(), Encoding::Ascii).read(sample_type, count)
        };
        assert_eq!(
            read(" 1 -2\n3\t", SampleType::I8, 3).unwrap(),
            Samples::I8(vec![1, -2, 3])
        );
        assert_eq!(
            read("1.5 -2e3 16777217", SampleType::F32, 3).unwrap(),
            Samples::F32(vec![1.5, -2000.0, 16_777_216.0])
        );
        for (text, sample_type) in [
            ("1 2", SampleType::U8),
            ("1 2 3 4", SampleType::U8),
            ("1 2 256", SampleType::U8),
            ("1 2 -1", SampleType::U16),
            ("1 2 3.5", SampleType::I32),
            ("1 2 x", SampleType::F64),
        ] {
            assert!(read(text, sample_type, 3).is_err(), "{text}");
        }
        let error = read("1 2 256", SampleType::U8, 3).unwrap_err().to_string();
        assert!(
            error.contains("sample 2") && error.contains("256"),
            "{error}"
        );
    }
}
