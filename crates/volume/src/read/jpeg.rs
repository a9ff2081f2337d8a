//! One JPEG picture of 8 bits, gray or colored: a slice of a sequence that somebody saved with loss.

use super::components::{self, Meaning};
use super::png::Picture;
use super::{Bytes, ReadOptions};
use crate::error::{Error, ErrorKind};
use crate::{Grid, Samples, memory};
use jpeg_decoder::{CodingProcess, Decoder, PixelFormat};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// What any file may unpack to; beyond, its size has to make it likely.
const FREE_BYTES: u64 = 1 << 24;
const LARGEST_GROWTH: u64 = 4096;

pub(crate) fn read(
    bytes: &dyn Bytes,
    options: &ReadOptions,
    notes: &mut Vec<String>,
) -> Result<Picture, Error> {
    bytes.has_room(bytes.len())?;
    let mut packed: Vec<u8> = memory::zeroed(bytes.len() as usize)?;
    bytes.read_at(0, &mut packed)?;
    // The decoder is not ours: a panic of it says that the data is damaged.
    let (dims, format, decoded) = catch_unwind(AssertUnwindSafe(|| decode(bytes, &packed)))
        .unwrap_or_else(|_| Err(damaged("the data is damaged".into())))?;
    let numbers = match format {
        PixelFormat::L8 => 1,
        PixelFormat::RGB24 => 3,
        _ => {
            return Err(ErrorKind::Unsupported {
                feature: format!("a JPEG picture of {format:?}"),
                instead: "convert it to gray or RGB of 8 bits".into(),
            }
            .into());
        }
    };
    let choice = components::choice(numbers, Meaning::Color, options, notes)?;
    if decoded.len() != components::total(dims[0] * dims[1], numbers)? {
        return Err(damaged(format!("it decodes to {} bytes", decoded.len())));
    }
    notes.push("JPEG changes the numbers of a scan a little; other formats do not".into());
    let samples = components::reduced(Samples::U8(decoded), numbers, choice);
    Ok(Picture {
        dims,
        samples,
        components: Meaning::Color.of(numbers),
    })
}

fn damaged(why: String) -> Error {
    ErrorKind::Compression { codec: "JPEG", why }.into()
}

fn decode(bytes: &dyn Bytes, packed: &[u8]) -> Result<([usize; 2], PixelFormat, Vec<u8>), Error> {
    let mut decoder = Decoder::new(packed);
    let failed = |error: jpeg_decoder::Error| damaged(error.to_string());
    decoder.read_info().map_err(failed)?;
    let info = decoder
        .info()
        .ok_or_else(|| damaged("it has no frame header".into()))?;
    if info.coding_process == CodingProcess::Lossless {
        return Err(ErrorKind::Unsupported {
            feature: "a picture in lossless JPEG".into(),
            instead: "convert it to PNG".into(),
        }
        .into());
    }
    let dims = [usize::from(info.width), usize::from(info.height)];
    debug_assert!(dims.iter().all(|edge| *edge <= Grid::MAX_EDGE));
    let size = (dims[0] * dims[1] * info.pixel_format.pixel_bytes()) as u64;
    let possible = (packed.len() as u64)
        .saturating_mul(LARGEST_GROWTH)
        .max(FREE_BYTES);
    if size > possible {
        return Err(ErrorKind::Truncated {
            what: "the picture".into(),
            expected: size,
            found: possible,
        }
        .into());
    }
    bytes.has_room(size)?;
    decoder.set_max_decoding_buffer_size(size as usize);
    let decoded = decoder.decode().map_err(failed)?;
    Ok((dims, info.pixel_format, decoded))
}
