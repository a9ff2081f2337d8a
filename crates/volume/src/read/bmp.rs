//! One Windows bitmap, gray or colored, not compressed.
//!
//! | offset | type  | what                                                                   |
//! |--------|-------|------------------------------------------------------------------------|
//! | 0      | text  | `BM`                                                                   |
//! | 10     | u32   | position of the pixels                                                 |
//! | 14     | u32   | bytes of the header that follows, 40 or more; then the palette         |
//! | 18, 22 | i32   | width, height; rows go upward unless the height is negative            |
//! | 28     | u16   | bits of a pixel: 1, 4, 8 (of a palette), 24 or 32 (blue, green, red)   |
//! | 30     | u32   | compression; 0 for none                                                |
//! | 46     | u32   | entries of the palette; 0 for all                                      |
//!
//! Rows are filled up to 4 bytes. A palette whose entries are all gray gives gray pictures.

use super::bit_fields::unpacked;
use super::components::{self, Meaning};
use super::png::Picture;
use super::{Bytes, ReadOptions};
use crate::error::{Error, ErrorKind};
use crate::{Grid, Samples, memory};

pub(crate) fn read(
    bytes: &dyn Bytes,
    options: &ReadOptions,
    notes: &mut Vec<String>,
) -> Result<Picture, Error> {
    let mut head = [0; 54];
    let truncated = |what: &str, expected, found| {
        Error::from(ErrorKind::Truncated {
            what: what.into(),
            expected,
            found,
        })
    };
    if bytes.len() < 54 {
        return Err(truncated("the header", 54, bytes.len()));
    }
    bytes.read_at(0, &mut head)?;
    let word = |at: usize| u32::from_le_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]);
    let (header_bytes, compression) = (word(14), word(30));
    if header_bytes < 40 || compression != 0 {
        return Err(ErrorKind::Unsupported {
            feature: format!(
                "a bitmap with a header of {header_bytes} bytes and compression {compression}"
            ),
            instead: "save it as PNG, or as a plain bitmap".into(),
        }
        .into());
    }
    let (width, height) = (word(18) as i32, word(22) as i32);
    let is_downward = height < 0;
    let dims = [width.max(0) as usize, height.unsigned_abs() as usize];
    for (name, edge) in ["width", "height"].iter().zip(dims) {
        if edge == 0 || edge > Grid::MAX_EDGE {
            return Err(Error::field(
                *name,
                edge,
                format!("1 to {}", Grid::MAX_EDGE),
            ));
        }
    }
    let bits = u32::from(u16::from_le_bytes([head[28], head[29]]));
    if !matches!(bits, 1 | 4 | 8 | 24 | 32) {
        return Err(Error::field("bits of a pixel", bits, "1, 4, 8, 24 or 32"));
    }
    let palette = match bits {
        1..=8 => palette(bytes, 14 + u64::from(header_bytes), word(46), bits)?,
        _ => Vec::new(),
    };
    let numbers = match bits {
        1..=8 => components::of_palette(&palette).count,
        _ => 3,
    };
    let choice = components::choice(numbers, Meaning::Color, options, notes)?;

    let row_bytes = (dims[0] * bits as usize).div_ceil(32) * 4;
    let start = u64::from(word(10));
    let expected = start + (row_bytes * dims[1]) as u64;
    if bytes.len() < expected {
        return Err(truncated("the picture", expected, bytes.len()));
    }
    let count = components::total(dims[0] * dims[1], numbers)?;
    bytes.has_room(count as u64)?;
    let mut samples: Vec<u8> = memory::reserved(count)?;
    let mut row = vec![0; row_bytes];
    for y in 0..dims[1] {
        let stored = if is_downward { y } else { dims[1] - 1 - y };
        bytes.read_at(start + (stored * row_bytes) as u64, &mut row)?;
        let pixel_bytes = bits as usize / 8;
        match bits {
            24 | 32 => {
                let pixels = row.chunks_exact(pixel_bytes).take(dims[0]);
                samples.extend(pixels.flat_map(|pixel| [pixel[2], pixel[1], pixel[0]]));
            }
            _ => {
                for index in unpacked(&row, bits, dims[0]) {
                    let color = palette.get(usize::from(index)).copied();
                    let color = color.ok_or_else(|| {
                        Error::field(
                            "an index",
                            index,
                            format!("0 to {}", palette.len().max(1) - 1),
                        )
                    })?;
                    samples.extend(&color[..numbers]);
                }
            }
        }
    }
    let samples = components::reduced(Samples::U8(samples), numbers, choice);
    Ok(Picture {
        dims,
        samples,
        components: Meaning::Color.of(numbers),
    })
}

/// Red, green and blue of each index.
fn palette(bytes: &dyn Bytes, at: u64, said: u32, bits: u32) -> Result<Vec<[u8; 3]>, Error> {
    let most = 1u32 << bits;
    let entries = if said == 0 { most } else { said.min(most) };
    let mut stored = vec![0; 4 * entries as usize];
    bytes.read_at(at, &mut stored)?;
    Ok(stored.chunks_exact(4).map(|c| [c[2], c[1], c[0]]).collect())
}
