//! The samples of one frame: found in the file, unpacked, put into the range of their stored bits.

use super::color::{self, Color, Palette};
use super::elements::{DataSet, Elements, PixelData};
use super::syntax::{CONVERT, Packing};
use super::tags::{self, Tag, field_name, missing};
use super::{jpeg_lossless, jpeg_ls, rle};
use crate::error::{Error, ErrorKind, Remedy};
use crate::memory::zeroed;
use crate::read::Bytes;
use crate::read::components::{self, Choice};
use crate::{Components, Sample, SampleType};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// How the samples of a frame are stored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Layout {
    pub(super) columns: usize,
    pub(super) rows: usize,
    /// The type of a number as it is stored.
    stored_type: SampleType,
    /// The type of a number that is read. That of indices is the type of their colors.
    pub(super) sample_type: SampleType,
    /// What the stored numbers of a pixel are.
    color: Color,
    /// Bits that hold the sample …
    bits_stored: u32,
    /// … beginning this many bits above the lowest.
    shift: u32,
}

impl Layout {
    /// What the elements say, checked. Indices of a palette count as values if `keeps_indices`.
    ///
    /// # Errors
    /// A missing or impossible value, or colors that are not read.
    pub(super) fn of(
        set: &DataSet,
        pixels: &PixelData,
        keeps_indices: bool,
    ) -> Result<Layout, Error> {
        let edge = |tag: Tag| match set.u16(tag) {
            Some(0) => Err(Error::field(field_name(tag), 0, "1 to 65535")),
            Some(n) => Ok(usize::from(n)),
            None => Err(missing(tag, "1 to 65535")),
        };
        let (rows, columns) = (edge(tags::ROWS)?, edge(tags::COLUMNS)?);
        let color = Color::of(set, keeps_indices)?;
        let allocated = match pixels.tag {
            tags::FLOAT_PIXEL_DATA => 32,
            tags::DOUBLE_FLOAT_PIXEL_DATA => 64,
            _ => set
                .u16(tags::BITS_ALLOCATED)
                .ok_or_else(|| missing(tags::BITS_ALLOCATED, "8, 16 or 32"))?,
        };
        let stored_type = stored_type(set, pixels, allocated)?;
        let is_narrow = matches!(stored_type, SampleType::U8 | SampleType::U16);
        if color != Color::Gray && !is_narrow {
            let [bits, sign] = [tags::BITS_ALLOCATED, tags::PIXEL_REPRESENTATION].map(field_name);
            return Err(Error::field(
                format!("{bits} with {sign}"),
                stored_type,
                "unsigned numbers of 8 or 16 bits for colors",
            ));
        }
        if color == Color::Ybr422 && columns % 2 == 1 {
            // Two neighbors share their differences.
            let allowed = "an even number for YBR_FULL_422";
            return Err(Error::field(field_name(tags::COLUMNS), columns, allowed));
        }
        let (bits_stored, shift) = match stored_type.is_integer() {
            true => stored_bits(set, allocated)?,
            false => (u32::from(allocated), 0),
        };
        Ok(Layout {
            columns,
            rows,
            stored_type,
            sample_type: match color {
                Color::Palette { sample_type, .. } => sample_type,
                _ => stored_type,
            },
            color,
            bits_stored,
            shift,
        })
    }

    /// The same for frames of another size.
    pub(super) fn with_size(&self, columns: usize, rows: usize) -> Layout {
        Layout {
            columns,
            rows,
            ..*self
        }
    }

    /// Samples of a frame.
    pub(super) fn frame_samples(&self) -> usize {
        self.rows * self.columns
    }

    /// Bytes of a frame that is not packed.
    pub(super) fn frame_bytes(&self) -> u64 {
        let numbers_per_pixel = match self.color {
            Color::Ybr422 => 2,
            color => color.stored_numbers(),
        };
        self.frame_samples() as u64 * (numbers_per_pixel * self.stored_type.size()) as u64
    }

    /// What a pixel is, of which one number is read.
    pub(super) fn components(&self) -> Components {
        self.color.components()
    }

    /// The same number, from the stored bits alone: what lies above them may be an old overlay.
    fn sample(&self, raw: i64, size_bits: u32, is_signed: bool) -> i64 {
        if self.bits_stored == size_bits && self.shift == 0 {
            return raw;
        }
        let unused = 64 - self.bits_stored;
        let bits = raw >> self.shift << unused;
        match is_signed {
            true => bits >> unused,
            false => (bits as u64 >> unused) as i64,
        }
    }
}

/// The type of the stored numbers.
fn stored_type(set: &DataSet, pixels: &PixelData, allocated: u16) -> Result<SampleType, Error> {
    let is_signed = match set.u16(tags::PIXEL_REPRESENTATION) {
        None | Some(0) => false,
        Some(1) => true,
        Some(n) => {
            return Err(Error::field(
                field_name(tags::PIXEL_REPRESENTATION),
                n,
                "0 (unsigned) or 1 (signed)",
            ));
        }
    };
    Ok(match (pixels.tag, allocated, is_signed) {
        (tags::FLOAT_PIXEL_DATA, ..) => SampleType::F32,
        (tags::DOUBLE_FLOAT_PIXEL_DATA, ..) => SampleType::F64,
        (_, 8, false) => SampleType::U8,
        (_, 8, true) => SampleType::I8,
        (_, 16, false) => SampleType::U16,
        (_, 16, true) => SampleType::I16,
        (_, 32, false) => SampleType::U32,
        (_, 32, true) => SampleType::I32,
        (_, 1, _) => {
            return Err(ErrorKind::Unsupported {
                feature: "a DICOM file of 1-bit pixels (a segmentation)".into(),
                instead: "convert it to .seg.nrrd or a NIfTI label volume".into(),
            }
            .into());
        }
        _ => {
            return Err(Error::field(
                field_name(tags::BITS_ALLOCATED),
                allocated,
                "8, 16 or 32",
            ));
        }
    })
}

/// How many bits of the allocated ones hold a number, and above how many others.
fn stored_bits(set: &DataSet, allocated: u16) -> Result<(u32, u32), Error> {
    let bits_stored: u32 = set.u16(tags::BITS_STORED).unwrap_or(allocated).into();
    let high = set
        .u16(tags::HIGH_BIT)
        .map_or(bits_stored.wrapping_sub(1), u32::from);
    if bits_stored == 0 || bits_stored > u32::from(allocated) {
        return Err(Error::field(
            field_name(tags::BITS_STORED),
            bits_stored,
            format!("1 to {allocated}, the allocated bits"),
        ));
    }
    if high >= u32::from(allocated) || high + 1 < bits_stored {
        return Err(Error::field(
            field_name(tags::HIGH_BIT),
            high,
            format!("{} to {}", bits_stored - 1, allocated - 1),
        ));
    }
    Ok((bits_stored, high + 1 - bits_stored))
}

/// What to say of `slices` frames whose distance nothing says.
pub(super) fn missing_spacing(slices: usize) -> Error {
    Error::from(ErrorKind::Unsupported {
        feature: format!(
            "a file of {slices} frames that states neither their positions (functional groups) nor {}",
            field_name(tags::SPACING_BETWEEN_SLICES)
        ),
        instead: "its frames may be moments of a film; if they are slices, give their spacing".into(),
    })
    .with_remedy(Remedy::Spacing)
}

/// An element type of DICOM pixels.
pub(super) trait Stored: Sample {
    /// The sample whose low bits these are.
    fn from_low_bits(bits: i64) -> Self;
    /// The sample as a number; for floating point the truth does not matter, nobody asks.
    fn to_number(self) -> i64;
    const IS_SIGNED: bool;
}

macro_rules! stored {
    ($($type:ident)*) => { $(
        impl Stored for $type {
            #[inline(always)]
            fn from_low_bits(bits: i64) -> Self { bits as $type }
            #[inline(always)]
            fn to_number(self) -> i64 { self as i64 }
            const IS_SIGNED: bool = $type::MIN as f64 != 0.0;
        }
    )* };
}
stored! { u8 i8 u16 i16 u32 i32 f32 f64 }

/// Checks, before any memory is taken, that the pixels of `frames` frames can be there.
///
/// # Errors
/// Fewer bytes than the frames need, or so few packed ones that the claim cannot be true.
pub(super) fn check_size(
    elements: &Elements,
    pixels: &PixelData,
    layout: &Layout,
    frames: usize,
    file_bytes: u64,
) -> Result<(), Error> {
    let expected = layout
        .frame_bytes()
        .checked_mul(frames as u64)
        .ok_or_else(|| Error::field(field_name(tags::NUMBER_OF_FRAMES), frames, "fewer frames"))?;
    let truncated = |expected, found| -> Result<(), Error> {
        Err(ErrorKind::Truncated {
            what: format!(
                "the pixel data ({}×{}, {frames} frames)",
                layout.columns, layout.rows
            ),
            expected,
            found,
        }
        .into())
    };
    // What each packing can reach at most: run lengths 64, deflate 1032, and for the JPEG family
    // more than any real image does; below 16 MiB a frame nothing is asked.
    let in_file = file_bytes.saturating_sub(pixels.offset);
    if elements.syntax.is_deflated {
        if let Some(length) = pixels.length
            && length < expected
        {
            return truncated(expected, length);
        }
        if expected > file_bytes.saturating_mul(1032) {
            return truncated(expected, file_bytes.saturating_mul(1032));
        }
        return Ok(());
    }
    if elements.syntax.is_encapsulated != pixels.length.is_none() {
        return Err(Error::field(
            "the length of the pixel data",
            pixels.length.map_or("undefined".into(), |n| n.to_string()),
            "undefined for packed pixels, the number of bytes for others",
        ));
    }
    if let Some(length) = pixels.length {
        let found = length.min(in_file);
        return match found < expected {
            true => truncated(expected, found),
            false => Ok(()),
        };
    }
    let ratio: u64 = match elements.syntax.packing {
        Packing::Native => 1,
        Packing::Rle => 64,
        Packing::Jpeg | Packing::JpegLs | Packing::Jpeg2000 => 4096,
    };
    let free = match elements.syntax.packing {
        Packing::Jpeg | Packing::JpegLs | Packing::Jpeg2000 => {
            (frames as u64).saturating_mul(1 << 24)
        }
        _ => 0,
    };
    // A frame is at least an item of 8 bytes.
    if in_file < 8 * frames as u64 || expected > in_file.saturating_mul(ratio).max(free) {
        return truncated(expected, in_file.saturating_mul(ratio));
    }
    Ok(())
}

/// One file that is open for its frames.
pub(super) struct Source<'a> {
    elements: &'a Elements,
    pixels: PixelData,
    layout: &'a Layout,
    bytes: &'a dyn Bytes,
    /// Which number of a pixel is read.
    choice: Choice,
    /// The colors of indices.
    palette: Option<Palette>,
    /// For packed pixels: which bytes make each frame.
    fragments: Vec<Vec<(u64, u64)>>,
}

impl<'a> Source<'a> {
    /// `bytes` counts as the pixels' offset does: the file, or its inflated data set.
    ///
    /// # Errors
    /// Fragments that do not make `frames` frames; a damaged palette.
    pub(super) fn new(
        elements: &'a Elements,
        pixels: PixelData,
        layout: &'a Layout,
        frames: usize,
        bytes: &'a dyn Bytes,
        choice: Choice,
    ) -> Result<Source<'a>, Error> {
        let fragments = match elements.syntax.is_encapsulated {
            true => fragments_of_frames(bytes, &pixels, &elements.set, frames)?,
            false => Vec::new(),
        };
        Ok(Source {
            elements,
            pixels,
            layout,
            bytes,
            choice,
            palette: match layout.color {
                Color::Palette { .. } => Some(Palette::of(&elements.set)?),
                _ => None,
            },
            fragments,
        })
    }

    /// Reads one number of each pixel of a frame, row by row, into `samples`, whose type is that of the layout.
    ///
    /// # Errors
    /// Damaged or unsupported data, or what the system says.
    pub(super) fn read<T: Stored>(&self, frame: usize, samples: &mut [T]) -> Result<(), Error> {
        assert_eq!(T::TYPE, self.layout.sample_type);
        assert_eq!(samples.len(), self.layout.frame_samples());
        let color = self.layout.color;
        // Decoders have their numbers in 4 bytes, and once more as they are stored.
        let mut pixel_bytes = match self.elements.syntax.is_encapsulated {
            true => 8 * color.stored_numbers(),
            false => 0,
        };
        // Colors are there as they are stored, and as red, green and blue.
        if color != Color::Gray {
            pixel_bytes += 2 * 3 * T::TYPE.size();
        }
        self.bytes
            .has_room(samples.len() as u64 * pixel_bytes as u64)?;
        match (color, &self.palette) {
            (Color::Gray, _) => self.read_numbers(frame, samples).map(|_| ()),
            (Color::Palette { .. }, Some(palette)) => match self.layout.stored_type {
                SampleType::U8 => self.look_up::<u8, T>(frame, palette, samples),
                _ => self.look_up::<u16, T>(frame, palette, samples),
            },
            (color, _) => {
                let mut numbers = zeroed(samples.len() * color.stored_numbers())?;
                let are_rgb = self.read_numbers(frame, &mut numbers)?;
                if !are_rgb && !matches!(color, Color::Rgb { .. }) {
                    color::to_rgb(&mut numbers, self.layout.bits_stored);
                }
                self.choose(numbers, samples);
                Ok(())
            }
        }
    }

    /// The colors of the indices of a frame.
    fn look_up<I: Stored, T: Stored>(
        &self,
        frame: usize,
        palette: &Palette,
        samples: &mut [T],
    ) -> Result<(), Error> {
        let mut indices = zeroed::<I>(samples.len())?;
        self.read_numbers(frame, &mut indices)?;
        let mut colors = zeroed::<T>(3 * samples.len())?;
        for (color, index) in colors.chunks_exact_mut(3).zip(indices) {
            let found = palette.color(index.to_number() as usize);
            color.copy_from_slice(&found.map(|number| T::from_low_bits(number.into())));
        }
        self.choose(colors, samples);
        Ok(())
    }

    /// One number of each color.
    fn choose<T: Stored>(&self, colors: Vec<T>, samples: &mut [T]) {
        let chosen = components::reduced(T::wrap(colors), 3, self.choice);
        if let Some(chosen) = T::of(&chosen) {
            samples.copy_from_slice(chosen);
        }
    }

    /// Reads the stored numbers of a frame, those of a pixel side by side. Returns whether they are red, green and
    /// blue, whatever the elements say.
    fn read_numbers<T: Stored>(&self, frame: usize, numbers: &mut [T]) -> Result<bool, Error> {
        let syntax = &self.elements.syntax;
        if !syntax.is_encapsulated {
            let offset = self.pixels.offset + frame as u64 * self.layout.frame_bytes();
            self.in_order(numbers, &|numbers| self.read_plain(offset, numbers))?;
            self.keep_stored_bits(numbers);
            return Ok(false);
        }
        let packed = self.packed(frame)?;
        match syntax.packing {
            Packing::Rle => {
                self.rle(&packed, numbers)?;
                self.keep_stored_bits(numbers);
            }
            Packing::Native => {
                let found = packed.len() as u64;
                self.in_order(numbers, &|numbers| {
                    let bytes: &mut [u8] = bytemuck::cast_slice_mut(numbers);
                    bytes.copy_from_slice(packed.get(..bytes.len()).ok_or_else(|| {
                        ErrorKind::Truncated {
                            what: format!("frame {}", frame + 1),
                            expected: bytes.len() as u64,
                            found,
                        }
                    })?);
                    from_little_endian(numbers);
                    Ok(())
                })?;
                self.keep_stored_bits(numbers);
            }
            Packing::Jpeg => return guarded("JPEG", || self.jpeg(&packed, numbers)),
            Packing::Jpeg2000 => guarded("JPEG 2000", || self.jpeg_2000(&packed, numbers))?,
            Packing::JpegLs => self.jpeg_ls(&packed, numbers)?,
        }
        Ok(false)
    }

    /// What `read` gives as it is stored, with the numbers of a pixel side by side.
    fn in_order<T: Stored>(
        &self,
        numbers: &mut [T],
        read: &dyn Fn(&mut [T]) -> Result<(), Error>,
    ) -> Result<(), Error> {
        match self.layout.color {
            Color::Rgb { is_planar: true } | Color::Ybr { is_planar: true } => {
                let mut planes = zeroed(numbers.len())?;
                read(&mut planes)?;
                color::of_planes(&planes, numbers);
                Ok(())
            }
            Color::Ybr422 => {
                let mut pairs = zeroed(numbers.len() / 3 * 2)?;
                read(&mut pairs)?;
                color::of_pairs(&pairs, numbers);
                Ok(())
            }
            _ => read(numbers),
        }
    }

    /// Numbers that lie in the file as they are.
    fn read_plain<T: Stored>(&self, offset: u64, numbers: &mut [T]) -> Result<(), Error> {
        let syntax = &self.elements.syntax;
        self.bytes
            .read_at(offset, bytemuck::cast_slice_mut(numbers))?;
        if syntax.is_big_endian && T::TYPE.size() == 1 && self.pixels.is_ow {
            // Written as 16-bit words, each with its first byte behind.
            bytemuck::cast_slice_mut::<T, u8>(numbers)
                .chunks_exact_mut(2)
                .for_each(<[u8]>::reverse);
        }
        if syntax.is_big_endian != cfg!(target_endian = "big") {
            numbers.iter_mut().for_each(|s| *s = s.swapped());
        }
        Ok(())
    }

    fn rle<T: Stored>(&self, packed: &[u8], numbers: &mut [T]) -> Result<(), Error> {
        let count = self.layout.color.stored_numbers();
        let failed = |why| compression("RLE", why);
        if count == 1 {
            let bytes = bytemuck::cast_slice_mut(numbers);
            rle::decode(packed, T::TYPE.size(), 1, bytes).map_err(failed)?;
        } else {
            let mut planes = zeroed::<T>(numbers.len())?;
            let bytes = bytemuck::cast_slice_mut(&mut planes);
            rle::decode(packed, T::TYPE.size(), count, bytes).map_err(failed)?;
            color::of_planes(&planes, numbers);
        }
        from_little_endian(numbers);
        Ok(())
    }

    fn jpeg_ls<T: Stored>(&self, packed: &[u8], numbers: &mut [T]) -> Result<(), Error> {
        let mut decoded = zeroed(numbers.len())?;
        let (columns, rows) = (self.layout.columns, self.layout.rows);
        let components = self.layout.color.stored_numbers();
        jpeg_ls::decode(packed, columns, rows, components, &mut decoded)
            .map_err(|why| compression("JPEG-LS", why))?;
        self.take(decoded.iter().map(|v| i64::from(*v)), numbers);
        Ok(())
    }

    fn keep_stored_bits<T: Stored>(&self, samples: &mut [T]) {
        let size_bits = 8 * T::TYPE.size() as u32;
        if !T::TYPE.is_integer() || self.layout.bits_stored == size_bits {
            return;
        }
        for sample in samples {
            let number = self
                .layout
                .sample(sample.to_number(), size_bits, T::IS_SIGNED);
            *sample = T::from_low_bits(number);
        }
    }

    /// Decoded numbers: their low bits count, whatever sign the codec gave them.
    fn take<T: Stored>(&self, decoded: impl Iterator<Item = i64>, samples: &mut [T]) {
        let size_bits = 8 * T::TYPE.size() as u32;
        for (sample, number) in samples.iter_mut().zip(decoded) {
            *sample = T::from_low_bits(self.layout.sample(number, size_bits, T::IS_SIGNED));
        }
    }

    fn packed(&self, frame: usize) -> Result<Vec<u8>, Error> {
        let parts = self.fragments.get(frame).map_or(&[][..], Vec::as_slice);
        let length = parts.iter().map(|part| part.1).sum::<u64>();
        // The fragments were found inside of the file, so this much is there.
        let mut packed = zeroed(length as usize)?;
        let mut rest = &mut packed[..];
        for (offset, length) in parts {
            let (part, after) = rest.split_at_mut(*length as usize);
            self.bytes.read_at(*offset, part)?;
            rest = after;
        }
        Ok(packed)
    }

    /// Returns whether the numbers are red, green and blue: lossy JPEG undoes its transform itself.
    fn jpeg<T: Stored>(&self, packed: &[u8], samples: &mut [T]) -> Result<bool, Error> {
        use jpeg_decoder::{ColorTransform, PixelFormat};
        let frame = jpeg_frame(packed).map_err(|why| compression("JPEG", why))?;
        self.check_frame("JPEG", frame.columns, frame.rows, frame.components)?;
        if frame.bits == 12 && !frame.is_lossless {
            return Err(ErrorKind::Unsupported {
                feature: "lossy JPEG of 12 bits (process 4, extended)".into(),
                instead: CONVERT.into(),
            }
            .into());
        }
        if frame.is_lossless {
            let mut decoded = zeroed(samples.len())?;
            let (columns, rows) = (self.layout.columns, self.layout.rows);
            jpeg_lossless::decode(packed, columns, rows, frame.components, &mut decoded)
                .map_err(|why| compression("lossless JPEG", why))?;
            self.take(decoded.iter().map(|v| i64::from(*v)), samples);
            return Ok(false);
        }
        let mut decoder = jpeg_decoder::Decoder::new(packed);
        decoder.set_max_decoding_buffer_size(2 * samples.len());
        if frame.components == 3 {
            match (frame.colors_by, self.layout.color) {
                // The decoder follows it.
                (Some(ColorMarker::Adobe), _) => {}
                (None, Color::Rgb { .. }) => decoder.set_color_transform(ColorTransform::RGB),
                _ => decoder.set_color_transform(ColorTransform::YCbCr),
            }
        }
        let decoded = decoder
            .decode()
            .map_err(|error| compression("JPEG", error.to_string()))?;
        let format = decoder.info().map(|info| info.pixel_format);
        match format {
            Some(PixelFormat::L8 | PixelFormat::RGB24) if decoded.len() == samples.len() => {
                self.take(decoded.iter().map(|v| i64::from(*v)), samples);
            }
            Some(PixelFormat::L16) if decoded.len() == 2 * samples.len() => {
                let numbers = decoded
                    .chunks_exact(2)
                    .map(|pair| i64::from(u16::from_ne_bytes([pair[0], pair[1]])));
                self.take(numbers, samples);
            }
            _ => {
                return Err(compression(
                    "JPEG",
                    format!("it decodes to {} bytes of {format:?}", decoded.len()),
                ));
            }
        }
        Ok(true)
    }

    fn jpeg_2000<T: Stored>(&self, packed: &[u8], samples: &mut [T]) -> Result<(), Error> {
        let failed = |error: jpeg2k::error::Error| compression("JPEG 2000", error.to_string());
        // What is checked is what is decoded: the decoder gets no box that could say another size.
        let stream = jpeg_2000_stream(packed).map_err(|why| compression("JPEG 2000", why))?;
        let (columns, rows, components) =
            jpeg_2000_size(stream).map_err(|why| compression("JPEG 2000", why))?;
        self.check_frame("JPEG 2000", columns, rows, components)?;
        // Strict: else a cut stream decodes to a blurred image without a word.
        let parameters = jpeg2k::DecodeParameters::new().strict(true);
        let image = jpeg2k::Image::from_bytes_with(stream, parameters).map_err(failed)?;
        let decoded = image.components();
        for component in decoded {
            let (width, height) = (component.width() as usize, component.height() as usize);
            self.check_frame("JPEG 2000", width, height, decoded.len())?;
        }
        let count = self.layout.color.stored_numbers();
        let number = |i: usize| i64::from(decoded[i % count].data()[i / count]);
        self.take((0..samples.len()).map(number), samples);
        Ok(())
    }

    /// The packed frame must be of the size that the elements say, before anything is decoded.
    fn check_frame(
        &self,
        codec: &'static str,
        columns: usize,
        rows: usize,
        components: usize,
    ) -> Result<(), Error> {
        let (wanted_columns, wanted_rows) = (self.layout.columns, self.layout.rows);
        let wanted = self.layout.color.stored_numbers();
        if (columns, rows, components) == (wanted_columns, wanted_rows, wanted) {
            return Ok(());
        }
        Err(compression(
            codec,
            format!(
                "it holds {columns}×{rows} samples of {components} components, the elements state {wanted_columns}×{wanted_rows} of {wanted}"
            ),
        ))
    }
}

fn from_little_endian<T: Sample>(numbers: &mut [T]) {
    if cfg!(target_endian = "big") {
        numbers
            .iter_mut()
            .for_each(|number| *number = number.swapped());
    }
}

fn compression(codec: &'static str, why: String) -> Error {
    ErrorKind::Compression { codec, why }.into()
}

/// Runs a decoder of others. Theirs may panic on damaged data (slices out of range, arithmetic);
/// that is the file's fault and must not end the program. Nothing they touched is used after it.
fn guarded<T>(codec: &'static str, decode: impl FnOnce() -> Result<T, Error>) -> Result<T, Error> {
    catch_unwind(AssertUnwindSafe(decode))
        .unwrap_or_else(|_| Err(compression(codec, "the data is damaged".into())))
}

/// A marker in JPEG that says what the colors are.
#[derive(Clone, Copy, PartialEq)]
enum ColorMarker {
    /// Y, Cb and Cr.
    Jfif,
    /// One of several spaces.
    Adobe,
}

struct JpegFrame {
    columns: usize,
    rows: usize,
    components: usize,
    bits: u8,
    is_lossless: bool,
    /// Which marker before it says what the colors are.
    colors_by: Option<ColorMarker>,
}

/// The first frame header of a JPEG stream.
fn jpeg_frame(data: &[u8]) -> Result<JpegFrame, String> {
    if data.first_chunk() != Some(&[0xFF, 0xD8]) {
        return Err("it does not begin with FF D8".into());
    }
    let mut at = 2;
    let mut colors_by = None;
    loop {
        match data.get(at..at + 2) {
            Some([0xFF, 0xFF]) => at += 1,
            Some(&[0xFF, marker @ 0xC0..=0xCF]) if !matches!(marker, 0xC4 | 0xC8 | 0xCC) => {
                let header = data
                    .get(at + 4..at + 10)
                    .ok_or("its frame header is cut off")?;
                let edge = |i: usize| usize::from(header[i]) << 8 | usize::from(header[i + 1]);
                return Ok(JpegFrame {
                    bits: header[0],
                    rows: edge(1),
                    columns: edge(3),
                    components: header[5].into(),
                    is_lossless: marker == 0xC3,
                    colors_by,
                });
            }
            Some([0xFF, marker]) => {
                match (*marker, data.get(at + 4..at + 9)) {
                    (0xE0, Some(b"JFIF\0")) => colors_by = colors_by.or(Some(ColorMarker::Jfif)),
                    (0xEE, Some(b"Adobe")) => colors_by = Some(ColorMarker::Adobe),
                    _ => {}
                }
                let length = data.get(at + 2..at + 4).ok_or("it has no frame header")?;
                at += 2 + (usize::from(length[0]) << 8 | usize::from(length[1])).max(2);
            }
            _ => return Err("it has no frame header".into()),
        }
    }
}

/// The codestream of a JPEG 2000 frame, which may lie in a JP2 file (ISO 15444-1, annex I) against the standard: boxes
/// of a length, four letters and, where the length is 1, a longer one.
fn jpeg_2000_stream(data: &[u8]) -> Result<&[u8], String> {
    const FIRST_BOX: &[u8] = b"\0\0\0\x0cjP  ";
    if !data.starts_with(FIRST_BOX) {
        return Ok(data);
    }
    let mut rest = data;
    loop {
        let (head, _) = rest
            .split_first_chunk::<8>()
            .ok_or("its boxes hold no codestream")?;
        let [a, b, c, d, kind @ ..] = *head;
        let (length, head_bytes) = match u32::from_be_bytes([a, b, c, d]) {
            0 => (rest.len() as u64, 8),
            1 => {
                let long = rest.get(8..).and_then(|bytes| bytes.first_chunk());
                let long = long.ok_or("a box of it is cut off")?;
                (u64::from_be_bytes(*long), 16)
            }
            length => (length.into(), 8),
        };
        let inside = usize::try_from(length).ok();
        let inside = inside.and_then(|length| rest.get(head_bytes..length));
        let inside = inside.ok_or("a box of it is cut off")?;
        match &kind {
            b"jp2c" => return Ok(inside),
            b"jp2h" if inside.windows(4).any(|name| name == b"pclr") => {
                return Err("it holds indices of a palette (pclr); save the images in RGB".into());
            }
            _ => rest = &rest[length as usize..],
        }
    }
}

/// Columns, rows and components of a JPEG 2000 codestream, by its SIZ marker, which has to come first; of its tiles
/// there may be as many as it has bytes for.
fn jpeg_2000_size(stream: &[u8]) -> Result<(usize, usize, usize), String> {
    /// Of a tile: the marker SOT with what belongs to it, and SOD.
    const LEAST_TILE_BYTES: u64 = 14;
    if !stream.starts_with(&[0xFF, 0x4F, 0xFF, 0x51]) {
        return Err("it does not begin with its size (FF 4F FF 51)".into());
    }
    let word = |i: usize| -> Result<u32, String> {
        stream
            .get(i..)
            .and_then(|bytes| bytes.first_chunk())
            .map(|bytes| u32::from_be_bytes(*bytes))
            .ok_or_else(|| "its size marker is cut off".to_owned())
    };
    let (right, bottom, left, top) = (word(8)?, word(12)?, word(16)?, word(20)?);
    let (tile, tile_from) = ([word(24)?, word(28)?], [word(32)?, word(36)?]);
    let components = word(40)? >> 16;
    let tiles = |to: u32, axis: usize| -> Result<u64, String> {
        let covered = u64::from(to.saturating_sub(tile_from[axis]));
        match tile[axis] {
            0 => Err("its tiles have no pixels".into()),
            edge => Ok(covered.div_ceil(edge.into())),
        }
    };
    let tiles = tiles(right, 0)? * tiles(bottom, 1)?;
    if tiles.saturating_mul(LEAST_TILE_BYTES) > stream.len() as u64 {
        return Err(format!(
            "its {} bytes cannot hold the {tiles} tiles that it says",
            stream.len()
        ));
    }
    Ok((
        right.saturating_sub(left) as usize,
        bottom.saturating_sub(top) as usize,
        components as usize,
    ))
}

/// Which byte ranges make each frame (PS3.5, annex A.4).
fn fragments_of_frames(
    bytes: &dyn Bytes,
    pixels: &PixelData,
    set: &DataSet,
    frames: usize,
) -> Result<Vec<Vec<(u64, u64)>>, Error> {
    let mut items = Vec::new();
    let mut at = pixels.offset;
    loop {
        let mut head = [0; 8];
        if at + 8 > bytes.len() {
            // The last delimiter is often missing where files were cut to size.
            break;
        }
        bytes.read_at(at, &mut head)?;
        let length = u64::from(u32::from_le_bytes([head[4], head[5], head[6], head[7]]));
        match head[..4] {
            [0xFE, 0xFF, 0x00, 0xE0] => {}
            [0xFE, 0xFF, 0xDD, 0xE0] => break,
            _ => {
                return Err(Error::field(
                    format!("the fragment at byte {at}"),
                    format!(
                        "{:02X} {:02X} {:02X} {:02X}",
                        head[0], head[1], head[2], head[3]
                    ),
                    "an item (FFFE,E000)",
                ));
            }
        }
        if at + 8 + length > bytes.len() {
            return Err(ErrorKind::Truncated {
                what: format!("fragment {} of the pixel data", items.len()),
                expected: at + 8 + length,
                found: bytes.len(),
            }
            .into());
        }
        items.push((at + 8, length));
        at += 8 + length;
    }
    if items.is_empty() {
        return Err(missing(tags::PIXEL_DATA, "fragments of packed pixels"));
    }
    let (table_offset, table_length) = items.remove(0);
    let data: Vec<(u64, u64)> = items;
    if frames == 1 {
        return Ok(vec![data]);
    }
    if data.len() == frames {
        return Ok(data.into_iter().map(|part| vec![part]).collect());
    }
    // Offsets count from the first fragment's item.
    let mut starts: Vec<u64> = Vec::new();
    if let Some(table) = set.bytes(tags::EXTENDED_OFFSET_TABLE) {
        starts.extend(
            table
                .chunks_exact(8)
                .map(|b| u64::from_le_bytes([b[0], b[1], b[2], b[3], b[4], b[5], b[6], b[7]])),
        );
    } else if table_length == 4 * frames as u64 {
        let mut table = zeroed(table_length as usize)?;
        bytes.read_at(table_offset, &mut table)?;
        starts.extend(
            table
                .chunks_exact(4)
                .map(|b| u64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]]))),
        );
    }
    let first = data.first().map_or(0, |part| part.0);
    let mut grouped: Vec<Vec<(u64, u64)>> = Vec::new();
    for (offset, length) in data {
        let begins = if starts.is_empty() {
            // Without a table: JPEG and JPEG 2000 frames begin with a marker of their own.
            let mut magic = [0; 2];
            length >= 2 && {
                bytes.read_at(offset, &mut magic)?;
                matches!(magic, [0xFF, 0xD8 | 0x4F])
            }
        } else {
            starts.contains(&(offset - first))
        };
        match grouped.last_mut() {
            Some(frame) if !begins => frame.push((offset, length)),
            _ => grouped.push(vec![(offset, length)]),
        }
    }
    if grouped.len() != frames {
        return Err(Error::field(
            field_name(tags::NUMBER_OF_FRAMES),
            frames,
            format!("{}, as many as the packed pixels hold", grouped.len()),
        ));
    }
    Ok(grouped)
}
