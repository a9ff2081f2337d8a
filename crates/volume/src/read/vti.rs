//! VTK's image data in XML (`.vti`): samples as text, base64 or appended bytes, plain or packed with zlib.
//!
//! ```text
//! <VTKFile type="ImageData" byte_order="LittleEndian" header_type="UInt64" compressor="vtkZLibDataCompressor">
//!   <ImageData WholeExtent="0 4 0 3 0 2" Origin="0 0 0" Spacing="1 1 1" Direction="1 0 0 0 1 0 0 0 1">
//!     <Piece Extent="0 4 0 3 0 2"><PointData Scalars="s">
//!       <DataArray type="Int16" Name="s" format="appended" offset="0"/>
//!     </PointData></Piece></ImageData>
//!   <AppendedData encoding="raw">_…</AppendedData></VTKFile>
//! ```
//!
//! Binary data begins with its number of bytes (UInt32, or `header_type`); packed data with the number of its blocks, the
//! size of a block and of the last one, and the packed size of each. Base64 writes that header by itself if data is packed.

use super::block::{self, Block, Encoding, Endian, Trailing};
use super::components;
use super::stored::Stored;
use super::{Bytes, Input, LoadedVolume, ReadOptions, base64, unoriented, vtk, xml};
use crate::error::{Error, ErrorKind};
use crate::{Components, Grid, Metadata, Rescale, Samples, Volume, memory};
use flate2::bufread::ZlibDecoder;
use glam::{DMat3, DVec3};
use std::io::Read;

/// Elements of XML take no more; the samples stand between or behind them.
const MOST_XML_BYTES: u64 = 1 << 31;

pub(crate) fn read(input: &Input, options: &ReadOptions) -> Result<LoadedVolume, Error> {
    let mut notes = vec![
        "VTK files do not state the patient's orientation; the axes are read as left, back, up (LPS), as by ITK".into(),
    ];
    let file = File::open(input.bytes)?;
    let (array, is_of_cells) = file.array(&mut notes)?;
    let grid = file.grid(is_of_cells, options)?;
    let (samples, components) = file.samples(&array, grid.voxel_count(), options, &mut notes)?;
    let volume = Volume::new(
        grid,
        samples,
        Rescale::IDENTITY,
        Metadata {
            name: input.name.to_owned(),
            format: "VTK ImageData".into(),
            has_length_unit: options.spacing_mm.is_some(),
            time_points: 1,
            components,
            entries: vec![(
                "array".into(),
                array.attribute("Name").unwrap_or_default().into(),
            )],
            ..Metadata::default()
        },
    )?;
    Ok(LoadedVolume {
        volume,
        labels: None,
        notes,
    })
}

/// The whole file: XML has no end before its last byte.
struct File<'a> {
    /// What holds for reading it.
    source: &'a dyn Bytes,
    bytes: Vec<u8>,
    endian: Endian,
    /// Bytes of a number in the header of binary data.
    word: usize,
    is_packed: bool,
}

/// An element with what stands behind it.
struct Element<'a> {
    name: &'a str,
    attributes: &'a str,
    /// Behind its `>`.
    end: usize,
}

impl<'a> Element<'a> {
    fn attribute(&self, name: &str) -> Option<&'a str> {
        xml::attribute(self.attributes, name)
    }

    fn required(&self, name: &str) -> Result<&'a str, Error> {
        self.attribute(name).ok_or_else(|| {
            ErrorKind::Missing {
                field: format!("{name} of {}", self.name),
                allowed: "an image of VTK has it".into(),
            }
            .into()
        })
    }
}

fn numbers<const N: usize, T: std::str::FromStr>(name: &str, text: &str) -> Result<[T; N], Error> {
    let found: Option<Vec<T>> = text.split_whitespace().map(|n| n.parse().ok()).collect();
    found
        .and_then(|found| found.try_into().ok())
        .ok_or_else(|| Error::field(name, format!("`{text}`"), format!("{N} numbers")))
}

impl File<'_> {
    fn open(bytes: &dyn Bytes) -> Result<File<'_>, Error> {
        if bytes.len() > MOST_XML_BYTES {
            return Err(Error::field(
                "the size of the file",
                bytes.len(),
                format!("up to {MOST_XML_BYTES} bytes for XML; convert it to MetaImage or NRRD"),
            ));
        }
        bytes.has_room(bytes.len())?;
        let mut all = memory::zeroed(bytes.len() as usize)?;
        bytes.read_at(0, &mut all)?;
        let mut file = File {
            source: bytes,
            bytes: all,
            endian: Endian::Little,
            word: 4,
            is_packed: false,
        };
        let root = file.find("VTKFile", 0)?;
        let kind = root.required("type")?;
        if kind != "ImageData" {
            return Err(ErrorKind::Unsupported {
                feature: format!("the VTK data set {kind}"),
                instead: "only ImageData lies on an even grid; resample the data in ParaView (Resample To Image)".into(),
            }
            .into());
        }
        let endian = match root.attribute("byte_order") {
            None | Some("LittleEndian") => Endian::Little,
            Some("BigEndian") => Endian::Big,
            Some(other) => {
                let allowed = "LittleEndian or BigEndian";
                return Err(Error::field("byte_order", format!("`{other}`"), allowed));
            }
        };
        let word = match root.attribute("header_type") {
            None | Some("UInt32") => 4,
            Some("UInt64") => 8,
            Some(other) => {
                let allowed = "UInt32 or UInt64";
                return Err(Error::field("header_type", format!("`{other}`"), allowed));
            }
        };
        let is_packed = match root.attribute("compressor") {
            None | Some("") => false,
            Some("vtkZLibDataCompressor") => true,
            Some(other) => {
                return Err(ErrorKind::Unsupported {
                    feature: format!("the compressor {other}"),
                    instead: "write the file with zlib or without compression".into(),
                }
                .into());
            }
        };
        (file.endian, file.word, file.is_packed) = (endian, word, is_packed);
        Ok(file)
    }

    /// The next element of a name, from a position on.
    fn next(&self, name: &str, from: usize) -> Option<Element<'_>> {
        let start = format!("<{name}");
        let mut at = from;
        loop {
            let found = self
                .bytes
                .get(at..)?
                .windows(start.len())
                .position(|w| w == start.as_bytes())?;
            let rest = &self.bytes[at + found + start.len()..];
            at += found + start.len();
            if !matches!(
                rest.first(),
                Some(b' ' | b'\t' | b'\r' | b'\n' | b'>' | b'/')
            ) {
                continue;
            }
            let end = rest.iter().take(1 << 16).position(|c| *c == b'>')?;
            let attributes = std::str::from_utf8(&rest[..end]).ok()?;
            let name = std::str::from_utf8(&self.bytes[at - name.len()..at]).ok()?;
            return Some(Element {
                name,
                attributes,
                end: at + end + 1,
            });
        }
    }

    fn find(&self, name: &str, from: usize) -> Result<Element<'_>, Error> {
        self.next(name, from).ok_or_else(|| {
            ErrorKind::Missing {
                field: format!("the element {name}"),
                allowed: "an image of VTK has it".into(),
            }
            .into()
        })
    }

    /// The array of the voxels and whether it belongs to cells.
    fn array(&self, notes: &mut Vec<String>) -> Result<(Element<'_>, bool), Error> {
        let piece = self.find("Piece", 0)?;
        if self.next("Piece", piece.end).is_some() {
            return Err(ErrorKind::Unsupported {
                feature: "an image of several pieces".into(),
                instead: "write it as one piece".into(),
            }
            .into());
        }
        for (part, is_of_cells) in [("PointData", false), ("CellData", true)] {
            let Some(data) = self.next(part, piece.end) else {
                continue;
            };
            let close = format!("</{part}>");
            let inside = &self.bytes[data.end..];
            let length = inside
                .windows(close.len())
                .position(|w| w == close.as_bytes());
            let end = data.end + length.unwrap_or(0);
            let mut arrays = Vec::new();
            let mut from = data.end;
            while let Some(array) = self
                .next("DataArray", from)
                .filter(|array| array.end <= end)
            {
                from = array.end;
                arrays.push(array);
            }
            let wanted = data.attribute("Scalars");
            if arrays.is_empty() {
                continue;
            }
            let named = arrays
                .iter()
                .position(|array| wanted.is_some() && array.attribute("Name") == wanted);
            if arrays.len() > 1 {
                notes.push(format!(
                    "{} is one of {} arrays",
                    arrays[named.unwrap_or(0)]
                        .attribute("Name")
                        .unwrap_or("the first"),
                    arrays.len()
                ));
            }
            let array = arrays.swap_remove(named.unwrap_or(0));
            return Ok((array, is_of_cells));
        }
        Err(ErrorKind::Missing {
            field: "a DataArray in PointData or CellData".into(),
            allowed: "the samples of the image".into(),
        }
        .into())
    }

    fn grid(&self, is_of_cells: bool, options: &ReadOptions) -> Result<Grid, Error> {
        let image = self.find("ImageData", 0)?;
        let piece = self.find("Piece", 0)?;
        let text = image.required("WholeExtent")?;
        let extent = numbers::<6, i64>("WholeExtent", text)?;
        if let Some(own) = piece.attribute("Extent")
            && numbers::<6, i64>("Extent", own)? != extent
        {
            return Err(Error::field(
                "Extent",
                format!("`{own}`"),
                format!("`{text}`, the whole"),
            ));
        }
        let mut points = [0; 3];
        for (axis, points) in points.iter_mut().enumerate() {
            let (first, last) = (extent[2 * axis], extent[2 * axis + 1]);
            let steps = last.checked_sub(first).filter(|steps| *steps >= 0);
            *points = steps
                .and_then(|steps| usize::try_from(steps).ok()?.checked_add(1))
                .ok_or_else(|| {
                    Error::field("WholeExtent", format!("`{text}`"), "rising numbers")
                })?;
        }
        let triple = |name: &str, default: [f64; 3]| match image.attribute(name) {
            Some(text) => numbers::<3, f64>(name, text),
            None => Ok(default),
        };
        let origin = DVec3::from(triple("Origin", [0.0; 3])?);
        let spacing = triple("Spacing", [1.0; 3])?;
        let (spacing, _) = unoriented::spacing_mm(options, Some((spacing, false)));
        let directions = match image.attribute("Direction") {
            // Row by row.
            Some(text) => {
                DMat3::from_cols_array(&numbers::<9, f64>("Direction", text)?).transpose()
            }
            None => DMat3::IDENTITY,
        };
        let matrix = directions * DMat3::from_diagonal(DVec3::from(spacing));
        let start = DVec3::new(extent[0] as f64, extent[2] as f64, extent[4] as f64);
        vtk::grid(points, is_of_cells, origin + matrix * start, matrix)
    }

    fn samples(
        &self,
        array: &Element,
        count: usize,
        options: &ReadOptions,
        notes: &mut Vec<String>,
    ) -> Result<(Samples, Components), Error> {
        let stored = vtk::sample_type(array.required("type")?)?;
        let components = match array.attribute("NumberOfComponents") {
            None | Some("0") => 1,
            Some(number) => vtk::component_count(number)?,
        };
        let meaning = vtk::meaning(stored);
        let choice = components::choice(components, meaning, options, notes)?;
        let count = components::total(count, components)?;
        let samples = self.numbers(array, count, stored, notes)?;
        let samples = components::reduced(samples, components, choice);
        Ok((samples, meaning.of(components)))
    }

    fn numbers(
        &self,
        array: &Element,
        count: usize,
        stored: Stored,
        notes: &mut Vec<String>,
    ) -> Result<Samples, Error> {
        // The unpacked bytes and the samples are there at the same time.
        let bytes = block::bytes_of(count, stored.bits());
        self.source
            .has_room(bytes.saturating_add(self.source.len()))?;
        self.source.keep(bytes)?;
        let format = array.attribute("format").unwrap_or("ascii");
        if format == "ascii" {
            let inside = &self.bytes[array.end..];
            let end = inside
                .iter()
                .position(|c| *c == b'<')
                .unwrap_or(inside.len());
            let text = inside[..end].to_vec();
            let block = Block {
                encoding: Encoding::Ascii,
                trailing: Trailing::Refused,
                ..Block::raw(&text, 0)
            };
            return stored.kept_of_text(block.read(stored.of_text(), count)?, notes);
        }
        let (data, is_base64) = match format {
            "binary" => {
                let inside = &self.bytes[array.end..];
                let end = inside
                    .iter()
                    .position(|c| *c == b'<')
                    .unwrap_or(inside.len());
                (&inside[..end], true)
            }
            "appended" => self.appended(array)?,
            other => {
                let allowed = "ascii, binary or appended";
                return Err(Error::field("format", format!("`{other}`"), allowed));
            }
        };
        let plain = self.plain(data, is_base64, count, stored)?;
        let block = Block {
            endian: self.endian,
            ..Block::raw(&plain, 0)
        };
        stored.kept_of_bits(block.read(stored.bits(), count)?, self.source, notes)
    }

    /// Where the bytes of an array lie behind the XML.
    fn appended(&self, array: &Element) -> Result<(&[u8], bool), Error> {
        let data = self.find("AppendedData", array.end)?;
        let is_base64 = match data.attribute("encoding") {
            Some("raw") => false,
            None | Some("base64") => true,
            Some(other) => {
                let allowed = "raw or base64";
                return Err(Error::field("encoding", format!("`{other}`"), allowed));
            }
        };
        let rest = &self.bytes[data.end..];
        let mark = rest.iter().position(|c| *c == b'_').map(|at| at + 1);
        let [offset] = numbers::<1, usize>("offset", array.required("offset")?)?;
        let mut inside = mark
            .and_then(|mark| rest.get(mark.checked_add(offset)?..))
            .ok_or_else(|| Error::field("offset", offset, "a place in the appended data"))?;
        if is_base64 {
            let end = inside
                .iter()
                .position(|c| *c == b'<')
                .unwrap_or(inside.len());
            inside = &inside[..end];
        }
        Ok((inside, is_base64))
    }

    fn number(&self, bytes: &[u8]) -> u64 {
        let join = |number: u64, byte: &u8| number << 8 | u64::from(*byte);
        match self.endian {
            Endian::Big => bytes.iter().fold(0, join),
            Endian::Little => bytes.iter().rev().fold(0, join),
        }
    }

    /// The samples' bytes, unpacked.
    fn plain(
        &self,
        data: &[u8],
        is_base64: bool,
        count: usize,
        stored: Stored,
    ) -> Result<Vec<u8>, Error> {
        let expected = (count as u64).saturating_mul(stored.bits().size() as u64);
        let short = |found: usize| {
            Error::from(ErrorKind::Truncated {
                what: "the array".into(),
                expected,
                found: found as u64,
            })
        };
        let (mut bytes, rest) = match is_base64 {
            true => base64::decoded(data)?,
            false => (Vec::new(), data),
        };
        let word = self.word;
        if !self.is_packed {
            let bytes = match is_base64 {
                // The number of bytes may be padded as a text of its own.
                true if bytes.len() == word => [bytes, base64::decoded(rest)?.0].concat(),
                true => bytes,
                false => rest.to_vec(),
            };
            let data = bytes.get(word..).ok_or_else(|| short(0))?;
            return match (data.len() as u64) < expected {
                true => Err(short(data.len())),
                false => Ok(data.to_vec()),
            };
        }
        if !is_base64 {
            bytes = rest.to_vec();
        }
        let at = |i: usize| {
            let bytes = bytes
                .get(i * word..(i + 1) * word)
                .ok_or_else(|| short(0))?;
            Ok::<_, Error>(self.number(bytes))
        };
        let blocks = usize::try_from(at(0)?).unwrap_or(usize::MAX);
        if blocks > bytes.len() / word {
            return Err(Error::field(
                "the number of packed blocks",
                blocks,
                "fewer, for the size of the header",
            ));
        }
        let sizes: Vec<u64> = (0..blocks).map(|i| at(3 + i)).collect::<Result<_, _>>()?;
        let header = (3 + blocks) * word;
        let packed = match is_base64 {
            true if bytes.len() == header => base64::decoded(rest)?.0,
            _ => bytes.split_off(header.min(bytes.len())),
        };
        let mut plain = Vec::new();
        let mut next = &packed[..];
        for size in sizes {
            let size = usize::try_from(size).unwrap_or(usize::MAX);
            let (block, after) = next
                .split_at_checked(size)
                .ok_or_else(|| short(plain.len()))?;
            next = after;
            let left = expected.saturating_sub(plain.len() as u64);
            ZlibDecoder::new(block)
                .take(left)
                .read_to_end(&mut plain)
                .map_err(|error| ErrorKind::Compression {
                    codec: "zlib",
                    why: error.to_string(),
                })?;
        }
        match (plain.len() as u64) < expected {
            true => Err(short(plain.len())),
            false => Ok(plain),
        }
    }
}
