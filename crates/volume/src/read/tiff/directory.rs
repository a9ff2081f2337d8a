//! The pages of a TIFF: where they lie, what is in them.
//!
//! | classic | BigTIFF | what                                                                 |
//! |---------|---------|----------------------------------------------------------------------|
//! | 2       | 8       | number of entries                                                    |
//! | 12 each | 20 each | entry: tag (2), type (2), count (4, 8), value or its position (4, 8) |
//! | 4       | 8       | position of the next directory, 0 after the last                     |

use crate::error::{Error, ErrorKind};
use crate::read::Bytes;
use crate::read::block::Endian;
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
}

/// One picture.
pub(super) struct Page {
    /// From 1.
    pub(super) number: usize,
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) sample_type: SampleType,
    pub(super) bits: u32,
    pub(super) photometric: Photometric,
    pub(super) compression: Compression,
    pub(super) predictor: Predictor,
    /// Size of a strip (as wide as the page) or of a tile.
    pub(super) chunk_width: usize,
    pub(super) chunk_height: usize,
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
    /// Differences of neighbours.
    Horizontal,
    /// Differences of the bytes of a row, all high bytes first.
    FloatingPoint,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Photometric {
    WhiteIsZero,
    BlackIsZero,
    Palette,
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
    pub(super) const PREDICTOR: u16 = 317;
    pub(super) const TILE_WIDTH: u16 = 322;
    pub(super) const TILE_LENGTH: u16 = 323;
    pub(super) const TILE_OFFSETS: u16 = 324;
    pub(super) const TILE_BYTE_COUNTS: u16 = 325;
    pub(super) const SAMPLE_FORMAT: u16 = 339;
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
        };
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
            let directory = source.directory(next, number)?;
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
    pub(super) fn shape(&self) -> (usize, usize, SampleType) {
        (self.width, self.height, self.sample_type)
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
            && self.chunk_width == self.width;
        let joined = self
            .chunks
            .windows(2)
            .all(|pair| pair[0].offset.checked_add(pair[0].bytes) == Some(pair[1].offset));
        let first = self.chunks.first()?.offset;
        (plain && joined).then_some(first)
    }
}

/// A file with its byte order and size of positions.
struct Source<'a> {
    bytes: &'a dyn Bytes,
    endian: Endian,
    big: bool,
}

impl<'a> Source<'a> {
    fn open(bytes: &'a dyn Bytes) -> Result<Source<'a>, Error> {
        let mut source = Source {
            bytes,
            endian: Endian::Little,
            big: false,
        };
        let magic = source.fetch(0, 4, "the TIFF header")?;
        source.endian = match &magic[..2] {
            b"II" => Endian::Little,
            b"MM" => Endian::Big,
            other => {
                return Err(Error::field("byte order", other.escape_ascii(), "II or MM"));
            }
        };
        source.big = match integer(&magic[2..], source.endian) {
            42 => false,
            43 => true,
            other => return Err(Error::field("TIFF version", other, "42 or 43 (BigTIFF)")),
        };
        if source.big {
            let sizes = source.fetch(4, 4, "the BigTIFF header")?;
            let offset_bytes = integer(&sizes[..2], source.endian);
            if offset_bytes != 8 {
                return Err(Error::field("bytes of a position", offset_bytes, "8"));
            }
        }
        Ok(source)
    }

    fn first_directory(&self) -> Result<u64, Error> {
        let (at, size) = if self.big { (8, 8) } else { (4, 4) };
        let position = self.fetch(at, size, "the TIFF header")?;
        Ok(integer(&position, self.endian))
    }

    fn fetch(&self, offset: u64, size: u64, what: &str) -> Result<Vec<u8>, Error> {
        let end = offset.saturating_add(size);
        if end > self.bytes.len() {
            return Err(ErrorKind::Truncated {
                what: what.into(),
                expected: end,
                found: self.bytes.len(),
            }
            .into());
        }
        let mut into = vec![0; size as usize];
        self.bytes.read_at(offset, &mut into)?;
        Ok(into)
    }

    fn directory(&self, at: u64, page: usize) -> Result<Directory<'_>, Error> {
        const MOST_ENTRIES: u64 = 4096;
        let what = format!("the directory of page {page}");
        let (count_size, entry_size, word) = if self.big { (8, 20, 8) } else { (2, 12, 4) };
        let count = integer(&self.fetch(at, count_size, &what)?, self.endian);
        if count > MOST_ENTRIES {
            return Err(Error::field(
                format!("number of entries of page {page}"),
                count,
                format!("at most {MOST_ENTRIES}"),
            ));
        }
        // `fetch` has seen that `at` lies in the file, so these sums cannot overflow.
        let table = self.fetch(at + count_size, count * entry_size, &what)?;
        let entries = table
            .chunks_exact(entry_size as usize)
            .map(|entry| Entry {
                tag: integer(&entry[..2], self.endian) as u16,
                kind: integer(&entry[2..4], self.endian) as u16,
                count: integer(&entry[4..4 + word], self.endian),
                value: std::array::from_fn(|i| entry.get(4 + word + i).copied().unwrap_or(0)),
                room: word,
            })
            .collect();
        let end = at + count_size + count * entry_size;
        let next = self.fetch(end, word as u64, &what)?;
        Ok(Directory {
            source: self,
            number: page,
            entries,
            next: integer(&next, self.endian),
        })
    }
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
        let photometric = self.photometric()?;
        let (sample_type, bits) = self.sample_type()?;
        let compression = self.compression()?;
        let predictor = self.predictor(compression, sample_type, bits)?;
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
        let mut page = Page {
            number: self.number,
            width,
            height,
            sample_type,
            bits,
            photometric,
            compression,
            predictor,
            chunk_width,
            chunk_height,
            chunks: Vec::new(),
        };
        page.chunks = self.chunks(&page, is_tiled)?;
        Ok(page)
    }

    fn photometric(&self) -> Result<Photometric, Error> {
        let samples = self.number(tag::SAMPLES_PER_PIXEL)?.unwrap_or(1);
        let photometric = self.number(tag::PHOTOMETRIC)?;
        match photometric {
            Some(2) => return Err(colour("RGB")),
            Some(5) => return Err(colour("CMYK")),
            Some(6) => return Err(colour("YCbCr")),
            Some(8..=10) => return Err(colour("Lab")),
            _ => {}
        }
        if samples != 1 {
            return Err(Error::field(
                self.field("SamplesPerPixel"),
                samples,
                "1; save grey pages without alpha, and channels as files of their own",
            ));
        }
        match photometric {
            Some(0) => Ok(Photometric::WhiteIsZero),
            None | Some(1) => Ok(Photometric::BlackIsZero),
            Some(3) => Ok(Photometric::Palette),
            Some(other) => Err(Error::field(
                self.field("PhotometricInterpretation"),
                other,
                "0 or 1 (grey)",
            )),
        }
    }

    fn sample_type(&self) -> Result<(SampleType, u32), Error> {
        let bits = self.number(tag::BITS_PER_SAMPLE)?.unwrap_or(1);
        let format = self.number(tag::SAMPLE_FORMAT)?.unwrap_or(1);
        let sample_type = match (format, bits) {
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
                    "unsigned of 1 to 16 or 32 bits, signed of 8, 16 or 32, floating point of 32 or 64",
                ));
            }
        };
        if bits % 8 != 0 && self.number(tag::FILL_ORDER)? == Some(2) {
            return Err(Error::field(self.field("FillOrder"), 2, "1"));
        }
        Ok((sample_type, bits as u32))
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
        sample_type: SampleType,
        bits: u32,
    ) -> Result<Predictor, Error> {
        // Only these methods have one (TIFF 6.0, section 14); elsewhere the tag means nothing.
        if matches!(compression, Compression::None | Compression::PackBits) {
            return Ok(Predictor::None);
        }
        let whole = bits as usize == 8 * sample_type.size();
        match self.number(tag::PREDICTOR)?.unwrap_or(1) {
            1 => Ok(Predictor::None),
            2 if whole => Ok(Predictor::Horizontal),
            3 if !sample_type.is_integer() => Ok(Predictor::FloatingPoint),
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
        let count = across * page.height.div_ceil(page.chunk_height) as u64;
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
                allowed: "a page says where its strips or tiles lie".into(),
            })
        };
        let offsets =
            counted(offsets_tag, "strips or tiles")?.ok_or_else(|| missing("StripOffsets"))?;
        let row_bytes = page.chunk_row_bytes() as u64;
        if page.compression == Compression::None {
            // Their sizes follow from the page; what the file says is often wrong.
            let rows = |first: usize| match is_tiled {
                true => page.chunk_height,
                false => page
                    .chunk_height
                    .min(page.height - first * page.chunk_height),
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

/// A page that is not grey.
pub(super) fn colour(what: &str) -> Error {
    ErrorKind::Unsupported {
        feature: format!("colour ({what})"),
        instead: "a volume has one number per voxel: convert to grey first, \
                  for example with ImageMagick's `-colorspace gray`"
            .into(),
    }
    .into()
}

/// An unsigned number of 1 to 8 bytes.
fn integer(bytes: &[u8], endian: Endian) -> u64 {
    let join = |number: u64, &byte: &u8| number << 8 | u64::from(byte);
    match endian {
        Endian::Big => bytes.iter().fold(0, join),
        Endian::Little => bytes.iter().rev().fold(0, join),
    }
}
