//! Samples as little-endian bytes, x fastest: what all writers end with.

use super::voxels::Voxels;
use crate::error::Error;
use crate::samples::with_type;
use crate::{Rescale, Sample, SampleType, Volume, with_samples};
use flate2::Compression;
use flate2::write::{GzEncoder, ZlibEncoder};
use std::io::{self, Write};

/// How bytes are packed on the way out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Packing {
    None,
    Gzip,
    Zlib,
}

/// Within a few percent of the size of higher levels, several times as fast.
const LEVEL: Compression = Compression::new(4);

/// Samples are converted in pieces that stay in the cache.
const PIECE: usize = 1 << 15;

/// The type in which the values of a volume are written by formats without a rescale: the stored
/// type if the rescale is identity, else the narrowest of whole numbers that holds them, else f32 or
/// f64.
pub fn value_type(volume: &Volume) -> SampleType {
    value_type_of(std::slice::from_ref(volume))
}

/// The same for several volumes, one or more of one type and rescale.
pub(crate) fn value_type_of(volumes: &[Volume]) -> SampleType {
    let volume = &volumes[0];
    let stored = volume.sample_type();
    let Rescale { slope, intercept } = volume.rescale();
    if volume.rescale() == Rescale::IDENTITY {
        return stored;
    }
    if stored.is_integer() && slope.fract() == 0.0 && intercept.fract() == 0.0 {
        let ranges = volumes.iter().map(|volume| volume.statistics().range);
        let (lo, hi) = ranges.fold((f64::MAX, f64::MIN), |(lo, hi), range| {
            (lo.min(range[0]), hi.max(range[1]))
        });
        let narrowest = [
            (SampleType::U8, 0.0, f64::from(u8::MAX)),
            (SampleType::I8, i8::MIN.into(), i8::MAX.into()),
            (SampleType::U16, 0.0, u16::MAX.into()),
            (SampleType::I16, i16::MIN.into(), i16::MAX.into()),
            (SampleType::U32, 0.0, u32::MAX.into()),
            (SampleType::I32, i32::MIN.into(), i32::MAX.into()),
        ];
        if let Some((fitting, ..)) = narrowest
            .into_iter()
            .find(|&(_, min, max)| lo >= min && hi <= max)
        {
            return fitting;
        }
    }
    match stored {
        SampleType::U32 | SampleType::I32 | SampleType::F64 => SampleType::F64,
        _ => SampleType::F32,
    }
}

/// Writes the values in their [`value_type`], the numbers of a voxel side by side.
///
/// # Errors
/// What the system says.
pub(crate) fn write_values(
    voxels: &Voxels,
    packing: Packing,
    out: &mut dyn Write,
) -> Result<(), Error> {
    packed(packing, out, &mut |out| {
        if voxels.first.rescale() == Rescale::IDENTITY {
            return match voxels.all {
                [volume] => stored(volume, out),
                _ => side_by_side(voxels, out),
            };
        }
        with_type!(value_type_of(voxels.all), U => interleaved::<U>(voxels, true, out))
    })
}

/// Writes the stored numbers of one volume, not packed.
///
/// # Errors
/// What the system says.
pub(crate) fn stored(volume: &Volume, out: &mut dyn Write) -> io::Result<()> {
    with_samples!(volume.samples(), s => little_endian(s, out))
}

/// Writes the stored numbers, those of a voxel side by side, not packed.
///
/// # Errors
/// What the system says.
pub(crate) fn side_by_side(voxels: &Voxels, out: &mut dyn Write) -> io::Result<()> {
    with_type!(voxels.first.sample_type(), U => interleaved::<U>(voxels, false, out))
}

/// Runs `body` with a stream that packs what is written to it.
///
/// # Errors
/// What the system says.
pub(crate) fn packed(
    packing: Packing,
    out: &mut dyn Write,
    body: &mut dyn FnMut(&mut dyn Write) -> io::Result<()>,
) -> Result<(), Error> {
    match packing {
        Packing::None => body(out)?,
        Packing::Gzip => {
            let mut packer = GzEncoder::new(out, LEVEL);
            body(&mut packer)?;
            packer.finish()?;
        }
        Packing::Zlib => {
            let mut packer = ZlibEncoder::new(out, LEVEL);
            body(&mut packer)?;
            packer.finish()?;
        }
    }
    Ok(())
}

fn little_endian<T: Sample>(samples: &[T], out: &mut dyn Write) -> io::Result<()> {
    if cfg!(target_endian = "little") {
        return out.write_all(bytemuck::cast_slice(samples));
    }
    for piece in samples.chunks(PIECE) {
        let piece: Vec<T> = piece.iter().map(|s| s.swapped()).collect();
        out.write_all(bytemuck::cast_slice(&piece))?;
    }
    Ok(())
}

/// Values, or stored numbers, of type `U`.
fn interleaved<U: Sample>(
    voxels: &Voxels,
    are_values: bool,
    out: &mut dyn Write,
) -> io::Result<()> {
    let count = voxels.all.len();
    let rescale = voxels.first.rescale();
    let total = voxels.first.samples().len();
    let voxels_per_piece = (PIECE / count).max(1);
    let mut piece: Vec<U> = Vec::new();
    for start in (0..total).step_by(voxels_per_piece) {
        let range = start..total.min(start + voxels_per_piece);
        piece.clear();
        piece.resize(range.len() * count, U::zeroed());
        for (component, volume) in voxels.all.iter().enumerate() {
            let into = piece[component..].iter_mut().step_by(count);
            match U::of(volume.samples()).filter(|_| !are_values) {
                Some(stored) => {
                    let numbers = stored[range.clone()].iter();
                    into.zip(numbers).for_each(|(into, stored)| *into = *stored);
                }
                None => with_samples!(volume.samples(), s => {
                    let numbers = s[range.clone()].iter();
                    into.zip(numbers).for_each(|(into, stored)| {
                        *into = U::from_f64(rescale.value(stored.to_f64()));
                    });
                }),
            }
        }
        little_endian(&piece, out)?;
    }
    Ok(())
}
