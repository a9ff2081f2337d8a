//! One PNG of 1, 2, 4, 8 or 16 bits, gray or colored. Numbers are kept as they are stored: those of fewer than
//! 8 bits become u8 without being stretched.

use super::Bytes;
use super::ReadOptions;
use super::bit_fields::unpacked;
use super::block::{ByteReader, Endian, to_native};
use super::components::{self, Meaning};
use crate::error::{Error, ErrorKind};
use crate::{Components, Grid, Samples, memory};
use png::{BitDepth, ColorType, DecodingError, Transformations};
use std::io::{self, BufReader};

/// A decoded picture, top row first.
pub(crate) struct Picture {
    /// Width and height.
    pub(crate) dims: [usize; 2],
    pub(crate) samples: Samples,
    pub(crate) components: Components,
}

/// The most bytes that one stored byte can become (deflate).
const LARGEST_GROWTH: u64 = 1032;

pub(crate) fn read(
    bytes: &dyn Bytes,
    options: &ReadOptions,
    notes: &mut Vec<String>,
) -> Result<Picture, Error> {
    let mut decoder = png::Decoder::new(BufReader::new(ByteReader::new(bytes, 0)));
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    let fail = |error| decode_error(error, bytes.len());
    let info = decoder.read_header_info().map_err(fail)?;
    let dims = [info.width as usize, info.height as usize];
    let (depth, row_bytes) = (info.bit_depth, info.raw_row_length() - 1);
    let color_type = info.color_type;
    for (name, edge) in ["width", "height"].iter().zip(dims) {
        if edge == 0 || edge > Grid::MAX_EDGE {
            return Err(Error::field(
                *name,
                edge,
                format!("1 to {}", Grid::MAX_EDGE),
            ));
        }
    }
    let channels = match color_type {
        ColorType::Grayscale => 1,
        ColorType::GrayscaleAlpha => 2,
        ColorType::Rgb => 3,
        ColorType::Rgba => 4,
        // Palettes are turned into what they stand for.
        ColorType::Indexed => {
            decoder.set_transformations(Transformations::EXPAND);
            0
        }
    };
    let picture_bytes = row_bytes as u64 * dims[1] as u64;
    let possible = bytes.len().saturating_mul(LARGEST_GROWTH);
    if picture_bytes > possible {
        return Err(ErrorKind::Truncated {
            what: "the picture".into(),
            expected: picture_bytes,
            found: possible,
        }
        .into());
    }

    let mut reader = decoder.read_info().map_err(fail)?;
    let channels = match channels {
        0 => reader.output_color_type().0.samples(),
        n => n,
    };
    let choice = components::choice(channels, Meaning::Color, options, notes)?;
    let count = components::total(dims[0] * dims[1], channels)?;
    bytes.has_room(2 * count as u64)?;
    let samples = match depth {
        _ if color_type == ColorType::Indexed => {
            let mut samples: Vec<u8> = memory::zeroed(count)?;
            reader.next_frame(&mut samples).map_err(fail)?;
            Samples::U8(samples)
        }
        BitDepth::Sixteen => {
            let mut samples: Vec<u16> = memory::zeroed(count)?;
            reader
                .next_frame(bytemuck::cast_slice_mut(&mut samples))
                .map_err(fail)?;
            to_native(&mut samples, Endian::Big);
            Samples::U16(samples)
        }
        depth => {
            let mut packed: Vec<u8> = memory::zeroed(picture_bytes as usize)?;
            reader.next_frame(&mut packed).map_err(fail)?;
            if depth != BitDepth::Eight {
                let rows = std::mem::take(&mut packed);
                memory::reserve(&mut packed, count)?;
                for row in rows.chunks_exact(row_bytes) {
                    packed.extend(unpacked(row, depth as u32, dims[0]).map(|n| n as u8));
                }
            }
            Samples::U8(packed)
        }
    };
    // To the end of the file: one that is cut off must not pass.
    reader.finish().map_err(fail)?;
    let samples = components::reduced(samples, channels, choice);
    Ok(Picture {
        dims,
        samples,
        components: Meaning::Color.of(channels),
    })
}

fn decode_error(error: DecodingError, found: u64) -> Error {
    match error {
        DecodingError::IoError(error) if error.kind() == io::ErrorKind::UnexpectedEof => {
            ErrorKind::Compression {
                codec: "PNG",
                why: format!("the file is cut off after {found} bytes"),
            }
            .into()
        }
        DecodingError::IoError(error) => error.into(),
        error => ErrorKind::Compression {
            codec: "PNG",
            why: error.to_string(),
        }
        .into(),
    }
}
