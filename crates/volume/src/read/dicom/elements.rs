//! The data elements of a DICOM file: which are kept, and where the pixels lie.
//!
//! | part      | bytes                                                                             |
//! |-----------|-----------------------------------------------------------------------------------|
//! | preamble  | 128 of anything, `DICM` (some files begin without)                                |
//! | meta      | elements of group 0002, explicit little endian: the transfer syntax               |
//! | data set  | elements in rising order of tags, up to the pixel data                            |
//! | element   | group u16, element u16, then                                                      |
//! | … explicit| two letters (VR); OB OD OF OL OV OW SQ SV UC UN UR UT UV: 2 empty, length u32;    |
//! |           | others: length u16                                                                |
//! | … implicit| length u32                                                                        |
//! | sequence  | items (FFFE,E000) length u32; a length of FFFF FFFF ends at a delimiter           |
//!
//! The walk is ours and not that of dicom-rs, which takes memory for the length an element claims,
//! follows nested sequences by recursion without a bound (a few kilobytes of file overflow the
//! stack, which nothing can catch), and does not say where the pixels begin, so that they would
//! have to be copied. Tags and character sets alone would bring twenty crates with them.

use super::character_set;
use super::syntax::Syntax;
use super::tags::{self, Tag, field_name};
use crate::error::{Error, ErrorKind};
use crate::read::Bytes;
use flate2::read::DeflateDecoder;
use std::io::Read;

/// Sequences nest four deep in real files; the bound keeps the stack small.
const MAX_DEPTH: usize = 24;

/// Values longer than this are not kept. The longest of use is the offset table of a multi-frame
/// file with 8 bytes a frame.
const MAX_VALUE_BYTES: u64 = 1 << 20;

/// How much of a deflated data set is unpacked to look for the pixels.
const MAX_DEFLATED_HEADER_BYTES: u64 = 1 << 24;

const UNDEFINED: u32 = u32::MAX;
const ITEM: Tag = Tag(0xFFFE, 0xE000);
const ITEM_END: Tag = Tag(0xFFFE, 0xE00D);
const SEQUENCE_END: Tag = Tag(0xFFFE, 0xE0DD);

/// The sequences that are descended into.
const SEQUENCES: &[Tag] = &[
    tags::DIRECTORY_RECORD_SEQUENCE,
    tags::SEGMENT_SEQUENCE,
    tags::SEGMENTED_PROPERTY_CATEGORY_CODE_SEQUENCE,
    tags::SEGMENT_IDENTIFICATION_SEQUENCE,
    tags::DIMENSION_INDEX_SEQUENCE,
    tags::DIFFUSION_GRADIENT_DIRECTION_SEQUENCE,
    tags::SHARED_FUNCTIONAL_GROUPS_SEQUENCE,
    tags::PER_FRAME_FUNCTIONAL_GROUPS_SEQUENCE,
    tags::PLANE_POSITION_SEQUENCE,
    tags::PLANE_ORIENTATION_SEQUENCE,
    tags::PIXEL_MEASURES_SEQUENCE,
    tags::PIXEL_VALUE_TRANSFORMATION_SEQUENCE,
    tags::FRAME_CONTENT_SEQUENCE,
    tags::FRAME_VOILUT_SEQUENCE,
    tags::MR_ECHO_SEQUENCE,
    tags::MR_DIFFUSION_SEQUENCE,
    tags::MR_IMAGE_FRAME_TYPE_SEQUENCE,
    tags::CT_IMAGE_FRAME_TYPE_SEQUENCE,
    tags::CARDIAC_SYNCHRONIZATION_SEQUENCE,
    tags::DETECTOR_INFORMATION_SEQUENCE,
    tags::MODALITY_LUT_SEQUENCE,
    tags::REFERENCED_FRAME_OF_REFERENCE_SEQUENCE,
    tags::RT_REFERENCED_STUDY_SEQUENCE,
    tags::RT_REFERENCED_SERIES_SEQUENCE,
    tags::STRUCTURE_SET_ROI_SEQUENCE,
    tags::ROI_CONTOUR_SEQUENCE,
    tags::CONTOUR_SEQUENCE,
    tags::RT_ROI_OBSERVATIONS_SEQUENCE,
];

/// The other elements that are kept. Nothing that names a person is among them.
const VALUES: &[Tag] = &[
    tags::TRANSFER_SYNTAX_UID,
    tags::SPECIFIC_CHARACTER_SET,
    tags::IMAGE_TYPE,
    tags::SOP_CLASS_UID,
    tags::SOP_INSTANCE_UID,
    tags::STUDY_DATE,
    tags::CODE_MEANING,
    tags::ACQUISITION_DATE_TIME,
    tags::ACQUISITION_TIME,
    tags::MODALITY,
    tags::MANUFACTURER,
    tags::STUDY_DESCRIPTION,
    tags::SERIES_DESCRIPTION,
    tags::MANUFACTURER_MODEL_NAME,
    tags::FRAME_TYPE,
    tags::BODY_PART_EXAMINED,
    tags::SLICE_THICKNESS,
    tags::KVP,
    tags::ECHO_TIME,
    tags::SPACING_BETWEEN_SLICES,
    tags::PROTOCOL_NAME,
    tags::TRIGGER_TIME,
    tags::CONVOLUTION_KERNEL,
    tags::PATIENT_POSITION,
    tags::FRAME_ACQUISITION_DATE_TIME,
    tags::EFFECTIVE_ECHO_TIME,
    tags::DIFFUSION_B_VALUE,
    tags::SERIES_INSTANCE_UID,
    tags::SERIES_NUMBER,
    tags::ACQUISITION_NUMBER,
    tags::IMAGE_POSITION_PATIENT,
    tags::IMAGE_ORIENTATION_PATIENT,
    tags::TEMPORAL_POSITION_IDENTIFIER,
    tags::TEMPORAL_POSITION_INDEX,
    tags::NOMINAL_CARDIAC_TRIGGER_DELAY_TIME,
    tags::SAMPLES_PER_PIXEL,
    tags::PHOTOMETRIC_INTERPRETATION,
    tags::PLANAR_CONFIGURATION,
    tags::RED_PALETTE_DESCRIPTOR,
    tags::GREEN_PALETTE_DESCRIPTOR,
    tags::BLUE_PALETTE_DESCRIPTOR,
    tags::RED_PALETTE_DATA,
    tags::GREEN_PALETTE_DATA,
    tags::BLUE_PALETTE_DATA,
    tags::SEGMENTED_RED_PALETTE_DATA,
    tags::SEGMENTED_GREEN_PALETTE_DATA,
    tags::SEGMENTED_BLUE_PALETTE_DATA,
    tags::NUMBER_OF_FRAMES,
    tags::ROWS,
    tags::COLUMNS,
    tags::PIXEL_SPACING,
    tags::BITS_ALLOCATED,
    tags::BITS_STORED,
    tags::HIGH_BIT,
    tags::PIXEL_REPRESENTATION,
    tags::PIXEL_PADDING_VALUE,
    tags::WINDOW_CENTER,
    tags::WINDOW_WIDTH,
    tags::RESCALE_INTERCEPT,
    tags::RESCALE_SLOPE,
    tags::RESCALE_TYPE,
    tags::UNITS,
    tags::DOSE_UNITS,
    tags::GRID_FRAME_OFFSET_VECTOR,
    tags::DOSE_GRID_SCALING,
    tags::EXTENDED_OFFSET_TABLE,
    tags::REFERENCED_FILE_ID,
    tags::SEGMENTATION_TYPE,
    tags::SEGMENT_NUMBER,
    tags::SEGMENT_LABEL,
    tags::REFERENCED_SEGMENT_NUMBER,
    tags::RECOMMENDED_DISPLAY_CIELAB_VALUE,
    tags::MAXIMUM_FRACTIONAL_VALUE,
    tags::CONTENT_TIME,
    tags::COMPLEX_IMAGE_COMPONENT,
    tags::INVERSION_TIME,
    tags::ACQUISITION_MATRIX,
    tags::FLIP_ANGLE,
    tags::DIFFUSION_GRADIENT_ORIENTATION,
    tags::NUMBER_OF_IMAGES_IN_MOSAIC,
    tags::INSTANCE_NUMBER,
    tags::DIMENSION_INDEX_VALUES,
    tags::DIMENSION_INDEX_POINTER,
    tags::FRAME_INCREMENT_POINTER,
    tags::CSA_IMAGE_HEADER,
    tags::CSA_IMAGE_HEADER_IN_BLOCK_11,
    tags::CSA_IMAGE_HEADER_IN_BLOCK_12,
    tags::ENERGY_WINDOW_VECTOR,
    tags::DETECTOR_VECTOR,
    tags::PHASE_VECTOR,
    tags::RR_INTERVAL_VECTOR,
    tags::TIME_SLOT_VECTOR,
    tags::SLICE_VECTOR,
    tags::ANGULAR_VIEW_VECTOR,
    tags::TIME_SLICE_VECTOR,
    tags::FRAME_REFERENCE_TIME,
    tags::STRUCTURE_SET_LABEL,
    tags::ROI_NUMBER,
    tags::ROI_NAME,
    tags::ROI_DISPLAY_COLOR,
    tags::CONTOUR_GEOMETRIC_TYPE,
    tags::CONTOUR_SLAB_THICKNESS,
    tags::CONTOUR_DATA,
    tags::REFERENCED_ROI_NUMBER,
    tags::RT_ROI_INTERPRETED_TYPE,
];

/// Whether a file begins like DICOM: `DICM` after the preamble, or an element of group 0002 or 0008
/// at once, as files of old programs do.
pub(super) fn is_dicom(bytes: &dyn Bytes) -> bool {
    let mut magic = [0; 4];
    if bytes.len() >= 132 && bytes.read_at(128, &mut magic).is_ok() && &magic == b"DICM" {
        return true;
    }
    let mut first = [0; 8];
    bytes.len() > 8
        && bytes.read_at(0, &mut first).is_ok()
        && matches!(first[..2], [2, 0] | [8, 0])
        && first[3] == 0
        && (is_vr([first[4], first[5]])
            || u32::from_le_bytes([first[4], first[5], first[6], first[7]]) < 256)
}

/// Two capital letters.
fn is_vr(vr: [u8; 2]) -> bool {
    vr.iter().all(u8::is_ascii_uppercase)
}

/// The elements of a data set, or of an item of a sequence, that are of use.
#[derive(Clone, Debug, Default)]
pub(super) struct DataSet {
    elements: Vec<(Tag, Value)>,
}

#[derive(Clone, Debug)]
enum Value {
    Bytes(Box<[u8]>),
    Items(Vec<DataSet>),
}

impl DataSet {
    fn find(&self, tag: Tag) -> Option<&Value> {
        self.elements
            .iter()
            .find(|(found, _)| *found == tag)
            .map(|(_, value)| value)
    }

    /// The bytes of an element; `None` also if it is empty.
    pub(super) fn bytes(&self, tag: Tag) -> Option<&[u8]> {
        match self.find(tag)? {
            Value::Bytes(bytes) if !bytes.is_empty() => Some(bytes),
            _ => None,
        }
    }

    /// The items of a sequence.
    pub(super) fn items(&self, tag: Tag) -> &[DataSet] {
        match self.find(tag) {
            Some(Value::Items(items)) => items,
            _ => &[],
        }
    }

    /// Whether the element is there, even empty.
    pub(super) fn has(&self, tag: Tag) -> bool {
        self.find(tag).is_some()
    }
}

/// Where the pixels of a file lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PixelData {
    /// Pixel Data, Float Pixel Data or Double Float Pixel Data.
    pub(super) tag: Tag,
    /// The first byte of the value, in the (inflated) data set's own counting.
    pub(super) offset: u64,
    /// Bytes; `None` for fragments.
    pub(super) length: Option<u64>,
    /// The value representation was OW: in big endian, 8-bit samples are then swapped in pairs.
    pub(super) is_ow: bool,
}

/// What was read of one file, without its pixels.
#[derive(Clone, Debug)]
pub(super) struct Elements {
    /// The data set up to the pixels.
    pub(super) set: DataSet,
    /// How it and the pixels are encoded.
    pub(super) syntax: Syntax,
    /// Where the data set begins in the file.
    pub(super) set_offset: u64,
    /// The pixels, if there are any.
    pub(super) pixels: Option<PixelData>,
    /// Whether the elements are written otherwise than the transfer syntax says: with or without their value
    /// representations. They were read as they are written.
    pub(super) is_mislabeled: bool,
}

/// Reads all elements of use. What was read before an error stays in the second part, because even
/// a broken file may still say which series it belongs to.
pub(super) fn read(bytes: &dyn Bytes) -> (Elements, Result<(), Error>) {
    let mut elements = Elements {
        set: DataSet::default(),
        syntax: Syntax::implicit_little_endian(),
        set_offset: 0,
        pixels: None,
        is_mislabeled: false,
    };
    let result = read_into(bytes, &mut elements);
    (elements, result)
}

fn read_into(bytes: &dyn Bytes, elements: &mut Elements) -> Result<(), Error> {
    let mut magic = [0; 4];
    let start = if bytes.len() >= 132 && bytes.read_at(128, &mut magic).is_ok() && &magic == b"DICM"
    {
        132
    } else {
        0
    };
    let mut meta = Walk::new(bytes, Syntax::explicit_little_endian());
    let mut meta_set = DataSet::default();
    elements.set_offset = meta.set(
        start,
        bytes.len(),
        true,
        0,
        Some(&mut meta_set),
        Stop::AfterMeta,
    )?;
    let looks_explicit = looks_explicit(bytes, elements.set_offset);
    elements.syntax = match meta_set.bytes(tags::TRANSFER_SYNTAX_UID) {
        Some(uid) => Syntax::of(&plain_text(uid))?,
        // Files without meta elements: explicit ones show a VR behind the first tag.
        None if looks_explicit == Some(true) => Syntax::explicit_little_endian(),
        None => Syntax::implicit_little_endian(),
    };
    let said = elements.syntax;
    if let Some(is_explicit) = looks_explicit
        && !said.is_deflated
        && !said.is_big_endian
    {
        elements.is_mislabeled = is_explicit != said.is_explicit;
        elements.syntax.is_explicit = is_explicit;
    }
    let syntax = elements.syntax;
    let keep = Some(&mut elements.set);
    if syntax.is_deflated {
        let inflated = inflate(bytes, elements.set_offset, MAX_DEFLATED_HEADER_BYTES)?;
        let mut walk = Walk::new(&inflated, syntax);
        walk.set(
            0,
            inflated.len() as u64,
            syntax.is_explicit,
            0,
            keep,
            Stop::AtPixels,
        )?;
        elements.pixels = walk.pixels;
    } else {
        let mut walk = Walk::new(bytes, syntax);
        walk.set(
            elements.set_offset,
            bytes.len(),
            syntax.is_explicit,
            0,
            keep,
            Stop::AtPixels,
        )?;
        elements.pixels = walk.pixels;
    }
    Ok(())
}

/// Whether the element at `at` names its value representation. `None` if it looks like neither.
fn looks_explicit(bytes: &dyn Bytes, at: u64) -> Option<bool> {
    let mut head = [0; 8];
    bytes.read_at(at, &mut head).ok()?;
    let [group, high, _, _, a, b, c, d] = head;
    if VALUE_REPRESENTATIONS.contains(&&[a, b]) {
        return Some(true);
    }
    // As a length: of a first element, which is short.
    let length = u32::from_le_bytes([a, b, c, d]);
    (matches!((group, high), (4 | 8 | 16, 0)) && length < 1024).then_some(false)
}

/// Those of PS3.5, table 6.2-1.
const VALUE_REPRESENTATIONS: [&[u8; 2]; 34] = [
    b"AE", b"AS", b"AT", b"CS", b"DA", b"DS", b"DT", b"FL", b"FD", b"IS", b"LO", b"LT", b"OB",
    b"OD", b"OF", b"OL", b"OV", b"OW", b"PN", b"SH", b"SL", b"SQ", b"SS", b"ST", b"SV", b"TM",
    b"UC", b"UI", b"UL", b"UN", b"UR", b"US", b"UT", b"UV",
];

/// The first bytes of a deflated data set, at most `limit`.
///
/// # Errors
/// Damaged data, or what the system says.
pub(super) fn inflate(bytes: &dyn Bytes, offset: u64, limit: u64) -> Result<Vec<u8>, Error> {
    let reader = Sequential {
        bytes,
        position: offset,
    };
    // Its first part is looked at wherever it leads; all of it has been promised by elements.
    if limit > MAX_DEFLATED_HEADER_BYTES {
        bytes.has_room(limit)?;
    }
    let mut inflated = Vec::new();
    DeflateDecoder::new(reader)
        .take(limit)
        .read_to_end(&mut inflated)
        .map_err(|error| ErrorKind::Compression {
            codec: "deflate",
            why: error.to_string(),
        })?;
    Ok(inflated)
}

/// Bytes from a position on, one after another.
struct Sequential<'a> {
    bytes: &'a dyn Bytes,
    position: u64,
}

impl Read for Sequential<'_> {
    fn read(&mut self, into: &mut [u8]) -> std::io::Result<usize> {
        let n = (into.len() as u64).min(self.bytes.len().saturating_sub(self.position)) as usize;
        self.bytes.read_at(self.position, &mut into[..n])?;
        self.position += n as u64;
        Ok(n)
    }
}

/// Where a walk over elements ends by itself.
#[derive(Clone, Copy, PartialEq)]
enum Stop {
    /// Before the first element that is not of group 0002.
    AfterMeta,
    /// At the pixel data, whose place is noted.
    AtPixels,
    /// At the end of the item.
    AtEnd,
}

/// Bytes read ahead: the elements of most files fit into one or two such pieces.
const WINDOW_BYTES: usize = 8192;

struct Walk<'a> {
    bytes: &'a dyn Bytes,
    syntax: Syntax,
    window: Vec<u8>,
    window_start: u64,
    pixels: Option<PixelData>,
}

struct ElementHead {
    tag: Tag,
    vr: [u8; 2],
    length: u32,
    value: u64,
}

impl<'a> Walk<'a> {
    fn new(bytes: &'a dyn Bytes, syntax: Syntax) -> Walk<'a> {
        Walk {
            bytes,
            syntax,
            window: Vec::new(),
            window_start: 0,
            pixels: None,
        }
    }

    fn array<const N: usize>(&mut self, at: u64) -> Result<[u8; N], Error> {
        let held = |walk: &Self| {
            let start = usize::try_from(at.checked_sub(walk.window_start)?).ok()?;
            walk.window
                .get(start..start.checked_add(N)?)?
                .try_into()
                .ok()
        };
        if let Some(bytes) = held(self) {
            return Ok(bytes);
        }
        let left = self.bytes.len().saturating_sub(at);
        self.window
            .resize((WINDOW_BYTES as u64).min(left) as usize, 0);
        self.window_start = at;
        self.bytes.read_at(at, &mut self.window)?;
        held(self).ok_or_else(|| truncated("the header", at + N as u64, self.bytes.len()))
    }

    fn u16(&mut self, at: u64) -> Result<u16, Error> {
        let bytes = self.array(at)?;
        Ok(match self.syntax.is_big_endian {
            true => u16::from_be_bytes(bytes),
            false => u16::from_le_bytes(bytes),
        })
    }

    fn u32(&mut self, at: u64) -> Result<u32, Error> {
        let bytes = self.array(at)?;
        Ok(match self.syntax.is_big_endian {
            true => u32::from_be_bytes(bytes),
            false => u32::from_le_bytes(bytes),
        })
    }

    fn head(&mut self, at: u64, is_explicit: bool) -> Result<ElementHead, Error> {
        let tag = Tag(self.u16(at)?, self.u16(at + 2)?);
        if !is_explicit || tag.0 == 0xFFFE {
            return Ok(ElementHead {
                tag,
                vr: *b"  ",
                length: self.u32(at + 4)?,
                value: at + 8,
            });
        }
        let vr: [u8; 2] = self.array(at + 4)?;
        match &vr {
            b"OB" | b"OD" | b"OF" | b"OL" | b"OV" | b"OW" | b"SQ" | b"SV" | b"UC" | b"UN"
            | b"UR" | b"UT" | b"UV" => Ok(ElementHead {
                tag,
                vr,
                length: self.u32(at + 8)?,
                value: at + 12,
            }),
            _ if is_vr(vr) => Ok(ElementHead {
                tag,
                vr,
                length: self.u16(at + 6)?.into(),
                value: at + 8,
            }),
            _ => Err(Error::field(
                format!("the value representation of {tag}"),
                format!("{:02X} {:02X}", vr[0], vr[1]),
                "two capital letters; the file is damaged or its transfer syntax is wrong",
            )),
        }
    }

    /// Walks over elements from `at` to `end`, or to an item's delimiter, and returns where it
    /// stopped.
    fn set(
        &mut self,
        mut at: u64,
        end: u64,
        is_explicit: bool,
        depth: usize,
        mut keep: Option<&mut DataSet>,
        stop: Stop,
    ) -> Result<u64, Error> {
        while at < end {
            // A trailing byte or two of padding is no element.
            if end - at < 8 && stop == Stop::AtPixels {
                break;
            }
            let group = self.u16(at)?;
            if stop == Stop::AfterMeta && group != 2 {
                break;
            }
            let head = self.head(at, is_explicit)?;
            if head.tag == ITEM_END && depth > 0 {
                return Ok(head.value);
            }
            if stop == Stop::AtPixels
                && matches!(
                    head.tag,
                    tags::PIXEL_DATA | tags::FLOAT_PIXEL_DATA | tags::DOUBLE_FLOAT_PIXEL_DATA
                )
            {
                self.pixels = Some(PixelData {
                    tag: head.tag,
                    offset: head.value,
                    length: (head.length != UNDEFINED).then_some(head.length.into()),
                    is_ow: &head.vr == b"OW",
                });
                return Ok(head.value);
            }
            let is_sequence = SEQUENCES.contains(&head.tag);
            if head.length == UNDEFINED || is_sequence {
                // The content of a sequence that was written as UN is implicit (PS3.5, 6.2.2).
                let is_explicit = is_explicit && &head.vr != b"UN";
                let mut items = Vec::new();
                let kept = (is_sequence && keep.is_some()).then_some(&mut items);
                at = self.sequence(&head, end, is_explicit, depth + 1, kept)?;
                if is_sequence && let Some(set) = &mut keep {
                    set.elements.push((head.tag, Value::Items(items)));
                }
                continue;
            }
            let value_end = head.value + u64::from(head.length);
            if value_end > end {
                return Err(truncated(
                    &format!("the element {}", head.tag),
                    value_end,
                    end,
                ));
            }
            if let Some(set) = &mut keep
                && VALUES.contains(&head.tag)
                && u64::from(head.length) <= MAX_VALUE_BYTES
            {
                let mut value = vec![0; head.length as usize];
                self.bytes.read_at(head.value, &mut value)?;
                self.to_little_endian(head.tag, &mut value);
                set.elements.push((head.tag, Value::Bytes(value.into())));
            }
            at = value_end;
        }
        Ok(at)
    }

    fn sequence(
        &mut self,
        head: &ElementHead,
        end: u64,
        is_explicit: bool,
        depth: usize,
        mut keep: Option<&mut Vec<DataSet>>,
    ) -> Result<u64, Error> {
        if depth > MAX_DEPTH {
            return Err(Error::field(
                "the nesting of sequences",
                format!("deeper than {MAX_DEPTH}"),
                format!("at most {MAX_DEPTH}"),
            ));
        }
        let is_undefined = head.length == UNDEFINED;
        let sequence_end = match is_undefined {
            true => end,
            false => head.value + u64::from(head.length),
        };
        if sequence_end > end {
            return Err(truncated(
                &format!("the sequence {}", head.tag),
                sequence_end,
                end,
            ));
        }
        let mut at = head.value;
        while at < sequence_end {
            let item = self.head(at, false)?;
            if item.tag == SEQUENCE_END && is_undefined {
                return Ok(item.value);
            }
            if item.tag != ITEM {
                return Err(Error::field(
                    format!("a part of the sequence {}", head.tag),
                    item.tag,
                    "an item (FFFE,E000)",
                ));
            }
            let mut set = DataSet::default();
            at = if item.length == UNDEFINED {
                let kept = keep.is_some().then_some(&mut set);
                self.set(
                    item.value,
                    sequence_end,
                    is_explicit,
                    depth,
                    kept,
                    Stop::AtEnd,
                )?
            } else {
                let item_end = item.value + u64::from(item.length);
                if item_end > sequence_end {
                    return Err(truncated(
                        &format!("an item of the sequence {}", head.tag),
                        item_end,
                        sequence_end,
                    ));
                }
                // What is not kept (fragments of an icon, private data) is jumped over.
                if keep.is_some() {
                    self.set(
                        item.value,
                        item_end,
                        is_explicit,
                        depth,
                        Some(&mut set),
                        Stop::AtEnd,
                    )?;
                }
                item_end
            };
            if let Some(items) = &mut keep {
                items.push(set);
            }
        }
        if is_undefined {
            return Err(truncated(
                &format!("the sequence {}", head.tag),
                at + 8,
                sequence_end,
            ));
        }
        Ok(at)
    }

    /// Numbers are kept in little endian, so that nobody has to ask again.
    fn to_little_endian(&self, tag: Tag, value: &mut [u8]) {
        if self.syntax.is_big_endian {
            let size = match tag {
                tags::SAMPLES_PER_PIXEL
                | tags::ROWS
                | tags::COLUMNS
                | tags::BITS_ALLOCATED
                | tags::BITS_STORED
                | tags::HIGH_BIT
                | tags::PIXEL_REPRESENTATION
                | tags::PIXEL_PADDING_VALUE
                | tags::ACQUISITION_MATRIX
                | tags::NUMBER_OF_IMAGES_IN_MOSAIC
                | tags::DIMENSION_INDEX_POINTER
                | tags::FRAME_INCREMENT_POINTER
                | tags::ENERGY_WINDOW_VECTOR
                | tags::DETECTOR_VECTOR
                | tags::PHASE_VECTOR
                | tags::RR_INTERVAL_VECTOR
                | tags::TIME_SLOT_VECTOR
                | tags::SLICE_VECTOR
                | tags::ANGULAR_VIEW_VECTOR
                | tags::TIME_SLICE_VECTOR
                | tags::SEGMENT_NUMBER
                | tags::REFERENCED_SEGMENT_NUMBER
                | tags::RECOMMENDED_DISPLAY_CIELAB_VALUE
                | tags::MAXIMUM_FRACTIONAL_VALUE
                | tags::PLANAR_CONFIGURATION
                | tags::RED_PALETTE_DESCRIPTOR
                | tags::GREEN_PALETTE_DESCRIPTOR
                | tags::BLUE_PALETTE_DESCRIPTOR
                | tags::RED_PALETTE_DATA
                | tags::GREEN_PALETTE_DATA
                | tags::BLUE_PALETTE_DATA
                | tags::SEGMENTED_RED_PALETTE_DATA
                | tags::SEGMENTED_GREEN_PALETTE_DATA
                | tags::SEGMENTED_BLUE_PALETTE_DATA => 2,
                tags::TEMPORAL_POSITION_INDEX | tags::DIMENSION_INDEX_VALUES => 4,
                tags::DIFFUSION_GRADIENT_ORIENTATION
                | tags::EFFECTIVE_ECHO_TIME
                | tags::DIFFUSION_B_VALUE
                | tags::EXTENDED_OFFSET_TABLE
                | tags::NOMINAL_CARDIAC_TRIGGER_DELAY_TIME => 8,
                _ => return,
            };
            value.chunks_exact_mut(size).for_each(<[u8]>::reverse);
        }
    }
}

fn truncated(what: &str, expected: u64, found: u64) -> Error {
    ErrorKind::Truncated {
        what: what.to_owned(),
        expected,
        found,
    }
    .into()
}

/// A list may be long; then the number alone is shown.
fn not_decimal(tag: Tag, text: &str, number: &str) -> Error {
    const LONGEST: usize = 80;
    let shown = if text.len() > LONGEST { number } else { text };
    let shown: String = shown.chars().take(LONGEST).collect();
    Error::field(field_name(tag), shown, "finite decimal numbers")
}

/// Text of the default repertoire, without padding.
pub(super) fn plain_text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes)
        .trim_matches(|c: char| c == '\0' || c.is_whitespace())
        .to_owned()
}

impl DataSet {
    /// Text of an element of the default repertoire (codes, dates, UIDs, numbers).
    pub(super) fn text(&self, tag: Tag) -> Option<String> {
        self.bytes(tag)
            .map(plain_text)
            .filter(|text| !text.is_empty())
    }

    /// Free text, in the character set that the data set names.
    pub(super) fn description(&self, tag: Tag) -> Option<String> {
        self.description_within(tag, self)
    }

    /// The same of an item in `outer`, whose character set holds for it too.
    pub(super) fn description_within(&self, tag: Tag, outer: &DataSet) -> Option<String> {
        let bytes = self.bytes(tag)?;
        let own = self.text(tags::SPECIFIC_CHARACTER_SET);
        let sets = own.or_else(|| outer.text(tags::SPECIFIC_CHARACTER_SET));
        let sets = sets.unwrap_or_default();
        let text = character_set::decoded(&sets, bytes);
        // No control characters into terminals and tables.
        let text: String = text
            .chars()
            .filter(|c| !c.is_control())
            .collect::<String>()
            .trim()
            .to_owned();
        (!text.is_empty()).then_some(text)
    }

    /// The numbers of a decimal string, separated by backslashes.
    pub(super) fn decimals(&self, tag: Tag) -> Result<Option<Vec<f64>>, Error> {
        let Some(text) = self.text(tag) else {
            return Ok(None);
        };
        text.split('\\')
            .map(|number| {
                let number = number.trim_matches(|c: char| c == '\0' || c.is_whitespace());
                number
                    .parse::<f64>()
                    .ok()
                    .filter(|number| number.is_finite())
                    .ok_or_else(|| not_decimal(tag, &text, number))
            })
            .collect::<Result<Vec<f64>, Error>>()
            .map(Some)
    }

    /// Exactly `N` decimal numbers.
    pub(super) fn decimal_array<const N: usize>(
        &self,
        tag: Tag,
    ) -> Result<Option<[f64; N]>, Error> {
        let Some(numbers) = self.decimals(tag)? else {
            return Ok(None);
        };
        match <[f64; N]>::try_from(numbers.as_slice()) {
            Ok(array) => Ok(Some(array)),
            Err(_) => Err(Error::field(
                field_name(tag),
                numbers
                    .iter()
                    .map(f64::to_string)
                    .collect::<Vec<_>>()
                    .join("\\"),
                format!("{N} numbers"),
            )),
        }
    }

    /// The first number of a decimal string.
    pub(super) fn decimal(&self, tag: Tag) -> Result<Option<f64>, Error> {
        Ok(self.decimals(tag)?.and_then(|all| all.first().copied()))
    }

    /// An unsigned 16-bit number.
    pub(super) fn u16(&self, tag: Tag) -> Option<u16> {
        let bytes = self.bytes(tag)?.first_chunk()?;
        Some(u16::from_le_bytes(*bytes))
    }

    /// An unsigned 32-bit number.
    pub(super) fn u32(&self, tag: Tag) -> Option<u32> {
        let bytes = self.bytes(tag)?.first_chunk()?;
        Some(u32::from_le_bytes(*bytes))
    }

    /// All unsigned 16-bit numbers.
    pub(super) fn u16s(&self, tag: Tag) -> Option<Vec<u16>> {
        let (numbers, _) = self.bytes(tag)?.as_chunks();
        Some(
            numbers
                .iter()
                .map(|bytes| u16::from_le_bytes(*bytes))
                .collect(),
        )
    }

    /// All unsigned 32-bit numbers.
    pub(super) fn u32s(&self, tag: Tag) -> Option<Vec<u32>> {
        let (numbers, _) = self.bytes(tag)?.as_chunks();
        Some(
            numbers
                .iter()
                .map(|bytes| u32::from_le_bytes(*bytes))
                .collect(),
        )
    }

    /// All 64-bit floating-point numbers, if they are finite.
    pub(super) fn f64s(&self, tag: Tag) -> Option<Vec<f64>> {
        let (numbers, _) = self.bytes(tag)?.as_chunks();
        let numbers = numbers.iter().map(|bytes| f64::from_le_bytes(*bytes));
        numbers.map(|n| n.is_finite().then_some(n)).collect()
    }

    /// A 64-bit floating-point number.
    pub(super) fn f64(&self, tag: Tag) -> Option<f64> {
        let bytes = self.bytes(tag)?.first_chunk()?;
        Some(f64::from_le_bytes(*bytes))
    }
}
