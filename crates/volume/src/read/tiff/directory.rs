//! The pages of a TIFF: where they lie, what is in them.
//!
//! | classic | BigTIFF | what                                                                 |
//! |---------|---------|----------------------------------------------------------------------|
//! | 2       | 8       | number of entries                                                    |
//! | 12 each | 20 each | entry: tag (2), type (2), count (4, 8), value or its position (4, 8) |
//! | 4       | 8       | position of the next directory, 0 after the last                     |

use super::metamorph::{self, MetaMorph};
use super::palette::Palette;
use super::source::{Source, integer};
use crate::error::{Error, ErrorKind};
use crate::read::Bytes;
use crate::read::block::Endian;
use crate::read::components::Meaning;
use crate::read::stored::Stored;
use crate::{Grid, SampleType};
use std::collections::HashSet;

/// All pages of a file, and what its first page says about all.
pub(super) struct Directories {
    pub(super) endian: Endian,
    pub(super) big: bool,
    pub(super) pages: Vec<Page>,
    /// How many pages were smaller copies or masks of others, and left out.
    pub(super) reduced: usize,
    /// ImageDescription of the first page.
    pub(super) description: String,
    /// Pixels per unit along x and y.
    pub(super) resolution: Option<[f64; 2]>,
    /// Bytes that the pages take in the file.
    pub(super) stored_bytes: u64,
    /// The palette of all pages, if they have one.
    pub(super) palette: Option<Palette>,
    /// What MetaMorph says of the planes behind the first page.
    pub(super) metamorph: Option<MetaMorph>,
}

/// One picture.
pub(super) struct Page {
    /// From 1.
    pub(super) number: usize,
    /// Numbers of a row: pixels times numbers of a pixel.
    pub(super) width: usize,
    /// Numbers of a pixel, and what they are.
    pub(super) numbers: usize,
    pub(super) meaning: Meaning,
    pub(super) height: usize,
    /// Slices behind one another in this page (SGI's ImageDepth).
    pub(super) depth: usize,
    /// The type that is read.
    pub(super) sample_type: SampleType,
    /// What its bits mean.
    pub(super) stored: Stored,
    pub(super) bits: u32,
    /// Whether the bits of each stored byte are the other way round (FillOrder 2).
    pub(super) is_reversed: bool,
    pub(super) photometric: Photometric,
    pub(super) compression: Compression,
    pub(super) predictor: Predictor,
    /// Size of a strip (as wide as the page) or of a tile.
    pub(super) chunk_width: usize,
    pub(super) chunk_height: usize,
    pub(super) chunk_depth: usize,
    pub(super) chunks: Vec<Chunk>,
}

/// Where a strip or tile lies.
#[derive(Clone, Copy)]
pub(super) struct Chunk {
    pub(super) offset: u64,
    pub(super) bytes: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Compression {
    None,
    Lzw,
    Deflate,
    PackBits,
    Zstd,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Predictor {
    None,
    /// Differences of neighbors.
    Horizontal,
    /// Differences of the bytes of a row, all high bytes first.
    FloatingPoint,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Photometric {
    WhiteIsZero,
    BlackIsZero,
    Palette,
    Rgb,
}

mod tag {
    pub(super) const NEW_SUBFILE_TYPE: u16 = 254;
    pub(super) const IMAGE_WIDTH: u16 = 256;
    pub(super) const IMAGE_LENGTH: u16 = 257;
    pub(super) const BITS_PER_SAMPLE: u16 = 258;
    pub(super) const COMPRESSION: u16 = 259;
    pub(super) const PHOTOMETRIC: u16 = 262;
    pub(super) const FILL_ORDER: u16 = 266;
    pub(super) const IMAGE_DESCRIPTION: u16 = 270;
    pub(super) const STRIP_OFFSETS: u16 = 273;
    pub(super) const SAMPLES_PER_PIXEL: u16 = 277;
    pub(super) const ROWS_PER_STRIP: u16 = 278;
    pub(super) const STRIP_BYTE_COUNTS: u16 = 279;
    pub(super) const X_RESOLUTION: u16 = 282;
    pub(super) const Y_RESOLUTION: u16 = 283;
    pub(super) const PLANAR_CONFIGURATION: u16 = 284;
    pub(super) const COLOR_MAP: u16 = 320;
    pub(super) const PREDICTOR: u16 = 317;
    pub(super) const TILE_WIDTH: u16 = 322;
    pub(super) const TILE_LENGTH: u16 = 323;
    pub(super) const TILE_OFFSETS: u16 = 324;
    pub(super) const TILE_BYTE_COUNTS: u16 = 325;
    pub(super) const EXTRA_SAMPLES: u16 = 338;
    pub(super) const SAMPLE_FORMAT: u16 = 339;
    pub(super) const IMAGE_DEPTH: u16 = 32997;
    pub(super) const TILE_DEPTH: u16 = 32998;
    pub(super) const UIC1: u16 = 33628;
    pub(super) const UIC2: u16 = 33629;
}

impl Directories {
    pub(super) fn read(bytes: &dyn Bytes) -> Result<Directories, Error> {
        let source = Source::open(bytes)?;
        let mut file = Directories {
            endian: source.endian,
            big: source.big,
            pages: Vec::new(),
            reduced: 0,
            description: String::new(),
            resolution: None,
            stored_bytes: 0,
            palette: None,
            metamorph: None,
        };
        let mut palette_place = None;
        let mut seen = HashSet::new();
        let mut next = source.first_directory()?;
        while next != 0 {
            let number = seen.len() + 1;
            if !seen.insert(next) {
                return Err(Error::field(
                    format!("the directory after page {}", number - 1),
                    format!("the one at byte {next} again"),
                    "a directory that was not read before",
                ));
            }
            if number > Grid::MAX_EDGE {
                return Err(Error::field(
                    "number of pages",
                    "larger",
                    format!("at most {}", Grid::MAX_EDGE),
                ));
            }
            let directory = directory(&source, next, number)?;
            next = directory.next;
            // Bit 0: a smaller copy of another page; bit 2: a mask of one.
            if directory.number(tag::NEW_SUBFILE_TYPE)?.unwrap_or(0) & 5 != 0 {
                file.reduced += 1;
                continue;
            }
            let page = directory.page()?;
            if file.pages.is_empty() {
                file.description = directory.text(tag::IMAGE_DESCRIPTION)?;
                let [x, y] = [tag::X_RESOLUTION, tag::Y_RESOLUTION]
                    .map(|tag| directory.positive_real(tag).ok().flatten());
                file.resolution = x.zip(y).map(|(x, y)| [x, y]);
                file.metamorph = directory.metamorph()?;
            }
            if page.photometric == Photometric::Palette {
                // A palette that pages share is read once for all indices of the same size.
                let place = (directory.map_place(), page.bits);
                if palette_place != Some(place) {
                    palette_place = Some(place);
                    file.add_palette(directory.palette(page.bits)?, number)?;
                }
            } else if file.palette.is_some() {
                return Err(other_palette(number));
            }
            for chunk in &page.chunks {
                file.stored_bytes = file.stored_bytes.saturating_add(chunk.bytes);
            }
            // Pages that share their data would let a small file fill all memory.
            if file.stored_bytes > bytes.len() {
                return Err(ErrorKind::Truncated {
                    what: format!("the data of the pages up to {number}"),
                    expected: file.stored_bytes,
                    found: bytes.len(),
                }
                .into());
            }
            file.pages.push(page);
        }
        Ok(file)
    }

    /// Takes the palette of the first page, and checks that those of others are equal.
    fn add_palette(&mut self, (palette, bytes): (Palette, u64), page: usize) -> Result<(), Error> {
        self.stored_bytes = self.stored_bytes.saturating_add(bytes);
        match &self.palette {
            Some(first) if *first != palette => Err(other_palette(page)),
            // Those before have none.
            None if !self.pages.is_empty() => Err(other_palette(page)),
            _ => {
                self.palette = Some(palette);
                Ok(())
            }
        }
    }

    pub(super) fn first(&self) -> Result<&Page, Error> {
        self.pages.first().ok_or_else(|| {
            ErrorKind::Missing {
                field: "a page".into(),
                allowed: "a TIFF stack has one page for each slice".into(),
            }
            .into()
        })
    }
}

impl Page {
    /// Pages of one stack agree in these.
    pub(super) fn shape(&self) -> ([usize; 3], usize, Stored) {
        let dims = [self.pixels(), self.height, self.depth];
        (dims, self.numbers, self.stored)
    }

    /// Pixels of a row.
    pub(super) fn pixels(&self) -> usize {
        self.width / self.numbers
    }

    /// Whether samples are stored in whole bytes.
    pub(super) fn is_whole_bytes(&self) -> bool {
        self.bits as usize == 8 * self.sample_type.size()
    }

    /// Bytes of an unpacked row of a strip or tile.
    pub(super) fn chunk_row_bytes(&self) -> usize {
        (self.chunk_width * self.bits as usize).div_ceil(8)
    }

    /// Where the samples begin if they lie as they are, row after row.
    pub(super) fn contiguous(&self) -> Option<u64> {
        let plain = self.compression == Compression::None
            && self.is_whole_bytes()
            && !self.is_reversed
            && self.depth == 1
            && self.chunk_width == self.width;
        let joined = self
            .chunks
            .windows(2)
            .all(|pair| pair[0].offset.checked_add(pair[0].bytes) == Some(pair[1].offset));
        let first = self.chunks.first()?.offset;
        (plain && joined).then_some(first)
    }
}

/// The directory at a position.
fn directory<'a>(source: &'a Source<'a>, at: u64, page: usize) -> Result<Directory<'a>, Error> {
    const MOST_ENTRIES: u64 = 4096;
    let what = format!("the directory of page {page}");
    let (count_size, entry_size, word) = if source.big { (8, 20, 8) } else { (2, 12, 4) };
    let count = integer(&source.fetch(at, count_size, &what)?, source.endian);
    if count > MOST_ENTRIES {
        return Err(Error::field(
            format!("number of entries of page {page}"),
            count,
            format!("at most {MOST_ENTRIES}"),
        ));
    }
    // `fetch` has seen that `at` lies in the file, so these sums cannot overflow.
    let table = source.fetch(at + count_size, count * entry_size, &what)?;
    let entries = table
        .chunks_exact(entry_size as usize)
        .map(|entry| Entry {
            tag: integer(&entry[..2], source.endian) as u16,
            kind: integer(&entry[2..4], source.endian) as u16,
            count: integer(&entry[4..4 + word], source.endian),
            value: std::array::from_fn(|i| entry.get(4 + word + i).copied().unwrap_or(0)),
            room: word,
        })
        .collect();
    let end = at + count_size + count * entry_size;
    let next = source.fetch(end, word as u64, &what)?;
    Ok(Directory {
        source,
        number: page,
        entries,
        next: integer(&next, source.endian),
    })
}

struct Entry {
    tag: u16,
    kind: u16,
    count: u64,
    /// The value, or where it lies if it takes more than `room` bytes.
    value: [u8; 8],
    room: usize,
}

struct Directory<'a> {
    source: &'a Source<'a>,
    /// Of the page, from 1.
    number: usize,
    entries: Vec<Entry>,
    next: u64,
}

impl Directory<'_> {
    fn field(&self, name: &str) -> String {
        format!("{name} of page {}", self.number)
    }

    fn find(&self, tag: u16) -> Option<&Entry> {
        self.entries.iter().find(|entry| entry.tag == tag)
    }

    /// The bytes of an entry whose elements have `size` bytes.
    fn bytes_of(&self, entry: &Entry, size: u64) -> Result<Vec<u8>, Error> {
        let what = format!("tag {} of page {}", entry.tag, self.number);
        let total = entry.count.checked_mul(size).ok_or_else(|| {
            Error::field(format!("count of {what}"), entry.count, "fewer elements")
        })?;
        if total <= entry.room as u64 {
            return Ok(entry.value[..total as usize].to_vec());
        }
        let at = integer(&entry.value[..entry.room], self.source.endian);
        self.source.fetch(at, total, &what)
    }

    /// The whole numbers of a tag, at most `most`.
    fn numbers(&self, tag: u16, most: u64) -> Result<Option<Vec<u64>>, Error> {
        let Some(entry) = self.find(tag) else {
            return Ok(None);
        };
        let size = match entry.kind {
            1 => 1,
            3 => 2,
            4 | 13 => 4,
            16 | 18 => 8,
            kind => {
                return Err(Error::field(
                    format!("type of tag {tag} of page {}", self.number),
                    kind,
                    "BYTE, SHORT, LONG or LONG8 (1, 3, 4, 16)",
                ));
            }
        };
        if entry.count == 0 || entry.count > most {
            return Err(Error::field(
                format!("count of tag {tag} of page {}", self.number),
                entry.count,
                format!("1 to {most}"),
            ));
        }
        let bytes = self.bytes_of(entry, size)?;
        let numbers = bytes.chunks_exact(size as usize);
        Ok(Some(
            numbers.map(|n| integer(n, self.source.endian)).collect(),
        ))
    }

    /// The first number of a tag.
    fn number(&self, tag: u16) -> Result<Option<u64>, Error> {
        Ok(self.numbers(tag, 1 << 16)?.map(|numbers| numbers[0]))
    }

    /// A number above 0: RATIONAL, FLOAT or DOUBLE.
    fn positive_real(&self, tag: u16) -> Result<Option<f64>, Error> {
        let Some(entry) = self.find(tag).filter(|entry| entry.count == 1) else {
            return Ok(None);
        };
        let endian = self.source.endian;
        let value = match entry.kind {
            5 => {
                let bytes = self.bytes_of(entry, 8)?;
                integer(&bytes[..4], endian) as f64 / integer(&bytes[4..], endian) as f64
            }
            11 => f64::from(f32::from_bits(
                integer(&self.bytes_of(entry, 4)?, endian) as u32
            )),
            12 => f64::from_bits(integer(&self.bytes_of(entry, 8)?, endian)),
            _ => return Ok(None),
        };
        Ok(Some(value).filter(|value| value.is_finite() && *value > 0.0))
    }

    /// A text, up to its first NUL; empty if there is none.
    fn text(&self, tag: u16) -> Result<String, Error> {
        const LONGEST: u64 = 64 << 20;
        let Some(entry) = self.find(tag).filter(|entry| entry.kind == 2) else {
            return Ok(String::new());
        };
        if entry.count > LONGEST {
            return Err(Error::field(
                format!("length of tag {tag} of page {}", self.number),
                entry.count,
                format!("at most {LONGEST}"),
            ));
        }
        let bytes = self.bytes_of(entry, 1)?;
        let end = bytes.iter().position(|&byte| byte == 0);
        Ok(String::from_utf8_lossy(&bytes[..end.unwrap_or(bytes.len())]).into_owned())
    }

    fn edge(&self, tag: u16, name: &str) -> Result<usize, Error> {
        let edge = self.number(tag)?.ok_or_else(|| ErrorKind::Missing {
            field: self.field(name),
            allowed: "a page has ImageWidth, ImageLength, and strips or tiles".into(),
        })?;
        if edge == 0 || edge > Grid::MAX_EDGE as u64 {
            return Err(Error::field(
                self.field(name),
                edge,
                format!("1 to {}", Grid::MAX_EDGE),
            ));
        }
        Ok(edge as usize)
    }

    fn page(&self) -> Result<Page, Error> {
        let width = self.edge(tag::IMAGE_WIDTH, "ImageWidth")?;
        let height = self.edge(tag::IMAGE_LENGTH, "ImageLength")?;
        let (photometric, numbers) = self.photometric()?;
        let meaning = self.meaning(photometric, numbers)?;
        let (stored, bits) = self.sample_type()?;
        let compression = self.compression()?;
        let predictor = self.predictor(compression, stored, bits)?;
        let depth = match self.find(tag::IMAGE_DEPTH) {
            Some(_) => self.edge(tag::IMAGE_DEPTH, "ImageDepth")?,
            None => 1,
        };
        let is_tiled = self.find(tag::TILE_OFFSETS).is_some();
        let (chunk_width, chunk_height) = if is_tiled {
            (
                self.edge(tag::TILE_WIDTH, "TileWidth")?,
                self.edge(tag::TILE_LENGTH, "TileLength")?,
            )
        } else {
            let rows = self.number(tag::ROWS_PER_STRIP)?;
            let rows = rows.unwrap_or(height as u64).min(height as u64);
            if rows == 0 {
                return Err(Error::field(self.field("RowsPerStrip"), 0, "1 or more"));
            }
            (width, rows as usize)
        };
        let chunk_depth = match self.find(tag::TILE_DEPTH) {
            Some(_) if is_tiled => self.edge(tag::TILE_DEPTH, "TileDepth")?,
            _ => 1,
        };
        let mut page = Page {
            number: self.number,
            width: width * numbers,
            numbers,
            meaning,
            height,
            depth,
            sample_type: stored.bits(),
            stored,
            bits,
            is_reversed: self.number(tag::FILL_ORDER)? == Some(2),
            photometric,
            compression,
            predictor,
            chunk_width: chunk_width * numbers,
            chunk_height,
            chunk_depth,
            chunks: Vec::new(),
        };
        page.chunks = self.chunks(&page, is_tiled)?;
        Ok(page)
    }

    /// What the numbers of a pixel are, which have to lie side by side and be of one type.
    fn meaning(&self, photometric: Photometric, numbers: usize) -> Result<Meaning, Error> {
        if numbers > 1 && self.number(tag::PLANAR_CONFIGURATION)? == Some(2) {
            return Err(Error::field(
                self.field("PlanarConfiguration"),
                2,
                "1; save channels side by side or as files of their own",
            ));
        }
        for (tag, name) in [
            (tag::BITS_PER_SAMPLE, "BitsPerSample"),
            (tag::SAMPLE_FORMAT, "SampleFormat"),
        ] {
            let all = self.numbers(tag, 1 << 16)?.unwrap_or_default();
            if all.iter().any(|n| *n != all[0]) {
                let found = format!("{all:?}");
                return Err(Error::field(
                    self.field(name),
                    found,
                    "the same for all numbers of a pixel",
                ));
            }
        }
        // 1 and 2 are opacity.
        let extra = self.number(tag::EXTRA_SAMPLES)?.unwrap_or(0);
        Ok(match photometric {
            Photometric::Rgb => Meaning::Color,
            _ if numbers == 2 && matches!(extra, 1 | 2) => Meaning::Color,
            _ => Meaning::Vector,
        })
    }

    fn photometric(&self) -> Result<(Photometric, usize), Error> {
        let samples = self.number(tag::SAMPLES_PER_PIXEL)?.unwrap_or(1);
        let photometric = self.number(tag::PHOTOMETRIC)?;
        match photometric {
            Some(5) => return Err(color("CMYK")),
            Some(6) => return Err(color("YCbCr")),
            Some(8..=10) => return Err(color("Lab")),
            _ => {}
        }
        const MOST: u64 = 64;
        let least = if photometric == Some(2) { 3 } else { 1 };
        if !(least..=MOST).contains(&samples) {
            return Err(Error::field(
                self.field("SamplesPerPixel"),
                samples,
                format!("{least} to {MOST}"),
            ));
        }
        let numbers = samples as usize;
        match photometric {
            Some(0) => Ok((Photometric::WhiteIsZero, numbers)),
            None | Some(1) => Ok((Photometric::BlackIsZero, numbers)),
            Some(2) => Ok((Photometric::Rgb, numbers)),
            Some(3) if numbers == 1 => Ok((Photometric::Palette, 1)),
            Some(3) => Err(Error::field(
                self.field("SamplesPerPixel"),
                numbers,
                "1 for indices of a palette",
            )),
            Some(other) => Err(Error::field(
                self.field("PhotometricInterpretation"),
                other,
                "0 or 1 (gray), 2 (RGB) or 3 (a palette)",
            )),
        }
    }

    /// Where the palette lies.
    fn map_place(&self) -> Option<(u64, [u8; 8])> {
        self.find(tag::COLOR_MAP)
            .map(|entry| (entry.count, entry.value))
    }

    /// The palette for indices of `bits`, and the bytes that it takes in the file.
    fn palette(&self, bits: u32) -> Result<(Palette, u64), Error> {
        const MOST: u64 = 3 << 16;
        let field = self.field("ColorMap");
        let map = self.numbers(tag::COLOR_MAP, MOST)?;
        let map = map.ok_or_else(|| ErrorKind::Missing {
            field: field.clone(),
            allowed: "a page of PhotometricInterpretation 3 has a palette".into(),
        })?;
        Ok((Palette::new(&map, bits, &field)?, 2 * map.len() as u64))
    }

    /// The tables of MetaMorph. Their counts mean other things than elsewhere.
    fn metamorph(&self) -> Result<Option<MetaMorph>, Error> {
        let place = |tag: u16| -> Option<metamorph::Place> {
            let entry = self.find(tag)?;
            let at = integer(&entry.value[..entry.room], self.source.endian);
            Some((entry.count, at))
        };
        // Fractions in the first table are those of a version before this one.
        let is_pairs = self.find(tag::UIC1).is_some_and(|entry| entry.kind == 4);
        let uic1 = place(tag::UIC1).filter(|_| is_pairs);
        MetaMorph::read(self.source, uic1, place(tag::UIC2))
    }

    fn sample_type(&self) -> Result<(Stored, u32), Error> {
        let bits = self.number(tag::BITS_PER_SAMPLE)?.unwrap_or(1);
        let format = self.number(tag::SAMPLE_FORMAT)?.unwrap_or(1);
        let kept = match (format, bits) {
            (1 | 4, 64) => return Ok((Stored::U64, 64)),
            (2, 64) => return Ok((Stored::I64, 64)),
            (3, 16) => return Ok((Stored::F16, 16)),
            (1 | 4, 1..=8) => SampleType::U8,
            (1 | 4, 9..=16) => SampleType::U16,
            (1 | 4, 32) => SampleType::U32,
            (2, 8) => SampleType::I8,
            (2, 16) => SampleType::I16,
            (2, 32) => SampleType::I32,
            (3, 32) => SampleType::F32,
            (3, 64) => SampleType::F64,
            _ => {
                let format = match format {
                    1 | 4 => "unsigned".into(),
                    2 => "signed".into(),
                    3 => "floating point".into(),
                    5 | 6 => "complex".into(),
                    other => format!("format {other}"),
                };
                return Err(Error::field(
                    self.field("the sample type"),
                    format!("{bits} bits, {format}"),
                    "unsigned of 1 to 16, 32 or 64 bits, signed of 8, 16, 32 or 64, floating point of 16, 32 or 64",
                ));
            }
        };
        Ok((Stored::Kept(kept), bits as u32))
    }

    fn compression(&self) -> Result<Compression, Error> {
        let name = match self.number(tag::COMPRESSION)?.unwrap_or(1) {
            1 => return Ok(Compression::None),
            5 => return Ok(Compression::Lzw),
            8 | 32946 => return Ok(Compression::Deflate),
            32773 => return Ok(Compression::PackBits),
            50000 => return Ok(Compression::Zstd),
            2..=4 => "fax".into(),
            6 | 7 => "JPEG".into(),
            33003 | 33005 | 34712 => "JPEG 2000".into(),
            34925 => "LZMA".into(),
            50001 => "WebP".into(),
            other => format!("number {other}"),
        };
        Err(ErrorKind::Unsupported {
            feature: format!("compression of page {} with method {name}", self.number),
            instead:
                "save the file without compression, or with LZW, Deflate, PackBits or Zstandard"
                    .into(),
        }
        .into())
    }

    fn predictor(
        &self,
        compression: Compression,
        stored: Stored,
        bits: u32,
    ) -> Result<Predictor, Error> {
        // Only these methods have one (TIFF 6.0, section 14); elsewhere the tag means nothing.
        if matches!(compression, Compression::None | Compression::PackBits) {
            return Ok(Predictor::None);
        }
        let whole = bits as usize == 8 * stored.bits().size();
        match self.number(tag::PREDICTOR)?.unwrap_or(1) {
            1 => Ok(Predictor::None),
            2 if whole => Ok(Predictor::Horizontal),
            3 if stored.is_float() => Ok(Predictor::FloatingPoint),
            other => Err(Error::field(
                self.field("Predictor"),
                other,
                "1, 2 (samples of whole bytes) or 3 (floating point)",
            )),
        }
    }

    fn chunks(&self, page: &Page, is_tiled: bool) -> Result<Vec<Chunk>, Error> {
        let (offsets_tag, sizes_tag) = if is_tiled {
            (tag::TILE_OFFSETS, tag::TILE_BYTE_COUNTS)
        } else {
            (tag::STRIP_OFFSETS, tag::STRIP_BYTE_COUNTS)
        };
        let across = page.width.div_ceil(page.chunk_width) as u64;
        let layers = page.depth.div_ceil(page.chunk_depth) as u64;
        let down = page.height.div_ceil(page.chunk_height);
        // Edges have 20 bits each.
        let count = across * down as u64 * layers;
        let counted = |tag, name: &str| {
            let numbers = self.numbers(tag, count)?;
            match numbers {
                Some(numbers) if numbers.len() as u64 != count => Err(Error::field(
                    self.field(&format!("number of {name}")),
                    numbers.len(),
                    format!("{count}, for its size"),
                )),
                numbers => Ok(numbers),
            }
        };
        let missing = |field: &str| {
            Error::from(ErrorKind::Missing {
                field: self.field(field),
                allowed: "a page states where its strips or tiles are".into(),
            })
        };
        let offsets =
            counted(offsets_tag, "strips or tiles")?.ok_or_else(|| missing("StripOffsets"))?;
        let row_bytes = page.chunk_row_bytes() as u64;
        if page.compression == Compression::None {
            // Their sizes follow from the page; what the file says is often wrong.
            let rows = |first: usize| match is_tiled {
                true => page.chunk_height * page.chunk_depth,
                false => page
                    .chunk_height
                    .min(page.height - first % down * page.chunk_height),
            };
            return Ok(offsets
                .into_iter()
                .enumerate()
                .map(|(i, offset)| Chunk {
                    offset,
                    bytes: rows(i) as u64 * row_bytes,
                })
                .collect());
        }
        let sizes =
            counted(sizes_tag, "strip or tile sizes")?.ok_or_else(|| missing("StripByteCounts"))?;
        if sizes.contains(&0) {
            return Err(Error::field(
                self.field("the size of a strip or tile"),
                0,
                "1 byte or more",
            ));
        }
        Ok(offsets
            .into_iter()
            .zip(sizes)
            .map(|(offset, bytes)| Chunk { offset, bytes })
            .collect())
    }
}

fn other_palette(page: usize) -> Error {
    ErrorKind::Slices(format!(
        "page {page} has another palette than the first; save the pages in RGB"
    ))
    .into()
}

/// A page that is not gray.
fn color(what: &str) -> Error {
    ErrorKind::Unsupported {
        feature: format!("color ({what})"),
        instead:
            "convert it to RGB or gray first, for example with ImageMagick's `-colorspace gray`"
                .into(),
    }
    .into()
}
