//! Samples as little-endian bytes, x fastest: what all writers end with.

use crate::error::Error;
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
    let stored = volume.sample_type();
    let Rescale { slope, intercept } = volume.rescale();
    if volume.rescale() == Rescale::IDENTITY {
        return stored;
    }
    if stored.is_integer() && slope.fract() == 0.0 && intercept.fract() == 0.0 {
        let [lo, hi] = volume.statistics().range;
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

/// Writes the values in their [`value_type`].
///
/// # Errors
/// What the system says.
pub(crate) fn write_values(
    volume: &Volume,
    packing: Packing,
    out: &mut dyn Write,
) -> Result<(), Error> {
    packed(packing, out, &mut |out| {
        let rescale = volume.rescale();
        if rescale == Rescale::IDENTITY {
            return stored(volume, out);
        }
        with_samples!(volume.samples(), s => match value_type(volume) {
            SampleType::U8 => convert::<_, u8>(s, rescale, out),
            SampleType::I8 => convert::<_, i8>(s, rescale, out),
            SampleType::U16 => convert::<_, u16>(s, rescale, out),
            SampleType::I16 => convert::<_, i16>(s, rescale, out),
            SampleType::U32 => convert::<_, u32>(s, rescale, out),
            SampleType::I32 => convert::<_, i32>(s, rescale, out),
            SampleType::F32 => convert::<_, f32>(s, rescale, out),
            SampleType::F64 => convert::<_, f64>(s, rescale, out),
        })
    })
}

/// Writes the stored numbers, not packed.
///
/// # Errors
/// What the system says.
pub(crate) fn stored(volume: &Volume, out: &mut dyn Write) -> io::Result<()> {
    with_samples!(volume.samples(), s => little_endian(s, out))
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

fn convert<T: Sample, U: Sample>(
    samples: &[T],
    rescale: Rescale,
    out: &mut dyn Write,
) -> io::Result<()> {
    for piece in samples.chunks(PIECE) {
        let values: Vec<U> = piece
            .iter()
            .map(|s| U::from_f64(rescale.value(s.to_f64())))
            .collect();
        little_endian(&values, out)?;
    }
    Ok(())
}
