//! TIFF stacks, put together byte by byte.

use crate::{gzip, message, read, read_with};
use glam::DVec3;
use std::io::Write;
use strahl_volume::read::ReadOptions;
use strahl_volume::{Modality, Samples};

const BYTE: u16 = 1;
const TEXT: u16 = 2;
const SHORT: u16 = 3;
const LONG: u16 = 4;
const RATIONAL: u16 = 5;
const LONG8: u16 = 16;

/// A file; its pages follow each other, each with its data before its directory.
#[derive(Clone)]
struct Tiff {
    big_endian: bool,
    big: bool,
    pages: Vec<Page>,
}

#[derive(Clone)]
struct Page {
    /// (tag, type, numbers); a RATIONAL is two numbers.
    tags: Vec<(u16, u16, Vec<u64>)>,
    /// Strips or tiles as they are stored.
    chunks: Vec<Vec<u8>>,
    tiled: bool,
}

impl Page {
    fn new(width: u64, height: u64, bits: u64, format: u64, data: &[u8]) -> Page {
        Page {
            tags: vec![
                (256, SHORT, vec![width]),
                (257, LONG, vec![height]),
                (258, SHORT, vec![bits]),
                (259, SHORT, vec![1]),
                (262, SHORT, vec![1]),
                (277, SHORT, vec![1]),
                (339, SHORT, vec![format]),
            ],
            chunks: vec![data.to_vec()],
            tiled: false,
        }
    }

    fn set(mut self, tag: u16, kind: u16, numbers: &[u64]) -> Page {
        self.tags.retain(|(other, ..)| *other != tag);
        self.tags.push((tag, kind, numbers.to_vec()));
        self
    }

    fn without(mut self, tag: u16) -> Page {
        self.tags.retain(|(other, ..)| *other != tag);
        self
    }

    fn describe(self, text: &str) -> Page {
        let bytes: Vec<u64> = text.bytes().chain([0]).map(u64::from).collect();
        self.set(270, TEXT, &bytes)
    }
}

impl Tiff {
    fn new(pages: Vec<Page>) -> Tiff {
        Tiff {
            big_endian: false,
            big: false,
            pages,
        }
    }

    fn number(&self, value: u64, size: usize) -> Vec<u8> {
        match self.big_endian {
            true => value.to_be_bytes()[8 - size..].to_vec(),
            false => value.to_le_bytes()[..size].to_vec(),
        }
    }

    fn bytes(&self) -> Vec<u8> {
        let word = if self.big { 8 } else { 4 };
        let mut file = if self.big_endian { b"MM" } else { b"II" }.to_vec();
        file.extend(self.number(if self.big { 43 } else { 42 }, 2));
        if self.big {
            file.extend(self.number(8, 2));
            file.extend(self.number(0, 2));
        }
        let mut link = file.len();
        file.extend(self.number(0, word));
        for page in &self.pages {
            let (mut offsets, mut sizes) = (Vec::new(), Vec::new());
            for chunk in &page.chunks {
                offsets.push(file.len() as u64);
                sizes.push(chunk.len() as u64);
                file.extend(chunk);
            }
            let kind = if self.big { LONG8 } else { LONG };
            let (offset_tag, size_tag) = if page.tiled { (324, 325) } else { (273, 279) };
            let mut tags = page.tags.clone();
            for (tag, numbers) in [(offset_tag, offsets), (size_tag, sizes)] {
                if !tags.iter().any(|(other, ..)| *other == tag) {
                    tags.push((tag, kind, numbers));
                }
            }
            tags.sort();
            let mut entries = Vec::new();
            for (tag, kind, numbers) in &tags {
                let size = match *kind {
                    BYTE | TEXT => 1,
                    SHORT => 2,
                    LONG8 => 8,
                    _ => 4,
                };
                let count = numbers.len() / if *kind == RATIONAL { 2 } else { 1 };
                let mut value: Vec<u8> =
                    numbers.iter().flat_map(|&n| self.number(n, size)).collect();
                if value.len() > word {
                    let at = file.len() as u64;
                    file.extend(value);
                    value = self.number(at, word);
                }
                value.resize(word, 0);
                entries.extend(self.number(u64::from(*tag), 2));
                entries.extend(self.number(u64::from(*kind), 2));
                entries.extend(self.number(count as u64, word));
                entries.extend(value);
            }
            let at = self.number(file.len() as u64, word);
            file[link..link + word].copy_from_slice(&at);
            file.extend(self.number(tags.len() as u64, if self.big { 8 } else { 2 }));
            file.extend(entries);
            link = file.len();
            file.extend(self.number(0, word));
        }
        file
    }
}

/// Two pages of 2 × 3 u8, deflated.
pub(crate) fn small() -> Vec<u8> {
    let page = |data: &[u8]| Page::new(2, 3, 8, 1, &deflate(data)).set(259, SHORT, &[8]);
    Tiff::new(vec![page(&[1, 2, 3, 4, 5, 6]), page(&[7; 6])]).bytes()
}

fn deflate(data: &[u8]) -> Vec<u8> {
    let mut packer = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    packer.write_all(data).unwrap();
    packer.finish().unwrap()
}

fn samples(file: &[u8]) -> Samples {
    let loaded = read(&[("v.tif", file)]).unwrap();
    assert_eq!(loaded.notes, Vec::<String>::new());
    let (_, samples, ..) = loaded.volume.into_parts();
    samples
}

fn u8_pages(count: u8) -> Vec<Page> {
    (0..count)
        .map(|k| Page::new(3, 2, 8, 1, &[0, 1, 2, 3, 4, 5].map(|v| 10 * k + v)))
        .collect()
}

#[test]
fn every_type_in_both_byte_orders_and_sizes() {
    macro_rules! check {
        ($($variant:ident $type:ty, $format:expr;)*) => {$(
            let numbers = [<$type>::MIN, <$type>::MAX, 0 as $type, 1 as $type, 2 as $type, 3 as $type];
            for big_endian in [false, true] {
                let data: Vec<u8> = numbers
                    .iter()
                    .flat_map(|n| if big_endian { n.to_be_bytes() } else { n.to_le_bytes() })
                    .collect();
                let page = Page::new(3, 2, 8 * size_of::<$type>() as u64, $format, &data);
                for big in [false, true] {
                    let file = Tiff { big_endian, big, pages: vec![page.clone(), page.clone()] };
                    let expected = Samples::$variant([numbers, numbers].concat());
                    assert_eq!(samples(&file.bytes()), expected);
                }
            }
        )*};
    }
    check! {
        U8 u8, 1; I8 i8, 2; U16 u16, 1; I16 i16, 2; U32 u32, 1; I32 i32, 2; F32 f32, 3; F64 f64, 3;
    }
}

#[test]
fn numbers_of_odd_bits_are_not_stretched() {
    // 12 bits: two numbers in three bytes.
    let page = Page::new(2, 1, 12, 1, &[0xab, 0xcd, 0xef]);
    let file = Tiff::new(vec![page]).bytes();
    assert_eq!(samples(&file), Samples::U16(vec![0xabc, 0xdef]));
    // 1 bit: each row begins with a byte of its own.
    let page = Page::new(3, 2, 1, 1, &[0b1010_0000, 0b0110_0000]).without(258);
    let file = Tiff::new(vec![page]).bytes();
    assert_eq!(samples(&file), Samples::U8(vec![1, 0, 1, 0, 1, 1]));
}

#[test]
fn strips_tiles_and_compressions_say_the_same() {
    let (width, height) = (37usize, 21usize);
    let numbers: Vec<u16> = (0..width * height).map(|i| (i * 131) as u16).collect();
    // A strip or tile of rows and columns, with what stands out beyond the page as zeros.
    let cut = |x0: usize, y0: usize, w: usize, h: usize, difference: bool| -> Vec<u8> {
        let mut data = Vec::new();
        for y in y0..y0 + h {
            let mut before = 0u16;
            for x in x0..x0 + w {
                let inside = x < width && y < height;
                let value = if inside { numbers[y * width + x] } else { 0 };
                let stored = if difference {
                    value.wrapping_sub(before)
                } else {
                    value
                };
                before = value;
                data.extend(stored.to_le_bytes());
            }
        }
        data
    };
    type Pack = fn(&[u8]) -> Vec<u8>;
    let packers: [(u64, Pack); 6] = [
        (1, |data| data.to_vec()),
        (5, |data| {
            weezl::encode::Encoder::with_tiff_size_switch(weezl::BitOrder::Msb, 8)
                .encode(data)
                .unwrap()
        }),
        (8, deflate),
        (32946, deflate),
        (32773, |data| {
            // Literal runs and an empty one.
            let runs = data
                .chunks(128)
                .map(|run| [&[run.len() as u8 - 1], run].concat());
            [vec![0x80], runs.collect::<Vec<_>>().concat()].concat()
        }),
        (50000, |data| zstd::encode_all(data, 1).unwrap()),
    ];
    for (method, pack) in packers {
        for difference in [false, true] {
            if difference && matches!(method, 1 | 32773) {
                continue;
            }
            let page = Page::new(width as u64, height as u64, 16, 1, &[])
                .set(259, SHORT, &[method])
                .set(317, SHORT, &[1 + u64::from(difference)]);
            let mut strips = page.clone().set(278, SHORT, &[8]);
            strips.chunks = [(0, 8), (8, 8), (16, 5)]
                .map(|(y, h)| pack(&cut(0, y, width, h, difference)))
                .to_vec();
            let mut tiles = page.set(322, SHORT, &[16]).set(323, SHORT, &[16]);
            tiles.tiled = true;
            tiles.chunks = (0..6)
                .map(|i| pack(&cut(i % 3 * 16, i / 3 * 16, 16, 16, difference)))
                .collect();
            for page in [strips, tiles] {
                let file = Tiff::new(vec![page]).bytes();
                assert_eq!(
                    samples(&file),
                    Samples::U16(numbers.clone()),
                    "method {method}"
                );
            }
        }
    }
}

#[test]
fn the_floating_point_predictor_is_undone() {
    let numbers = [1.5f32, -2.25, 1e-30, f32::MAX];
    // The bytes of a row, highest first, then the differences of neighbors.
    let mut planes: Vec<u8> = (0..4)
        .flat_map(|k| numbers.map(|n| n.to_be_bytes()[k]))
        .collect();
    for i in (1..planes.len()).rev() {
        planes[i] = planes[i].wrapping_sub(planes[i - 1]);
    }
    let page = Page::new(4, 1, 32, 3, &deflate(&planes))
        .set(259, SHORT, &[8])
        .set(317, SHORT, &[3]);
    let file = Tiff::new(vec![page]).bytes();
    assert_eq!(samples(&file), Samples::F32(numbers.to_vec()));
}

#[test]
fn pages_are_slices_from_the_patients_left_front() {
    let volume = read(&[("v.tif", &Tiff::new(u8_pages(4)).bytes())])
        .unwrap()
        .volume;
    assert_eq!(volume.grid().dims(), [3, 2, 4]);
    assert_eq!(volume.grid().orientation(), "LPS");
    assert_eq!(volume.value(2, 1, 3), 35.0);
    assert!(!volume.metadata().has_length_unit);
    let options = ReadOptions {
        spacing_mm: Some([0.5, 0.5, 2.0]),
        ..ReadOptions::default()
    };
    let file = Tiff::new(u8_pages(4)).bytes();
    let volume = read_with(&[("v.tif", &file)], &options).unwrap().volume;
    assert_eq!(volume.grid().spacing_mm(), DVec3::new(0.5, 0.5, 2.0));
    assert!(volume.metadata().has_length_unit);
}

#[test]
fn imagej_gives_spacing_time_and_stacks_of_one_page() {
    let text = "ImageJ=1.53t\nimages=6\nslices=3\nframes=2\nunit=micron\nspacing=2\n";
    let mut pages = u8_pages(6);
    pages[0] = pages[0]
        .clone()
        .describe(text)
        .set(282, RATIONAL, &[2, 1])
        .set(283, RATIONAL, &[4, 1]);
    let file = Tiff::new(pages).bytes();
    for time_index in 0..2 {
        let options = ReadOptions {
            time_index,
            ..ReadOptions::default()
        };
        let volume = read_with(&[("v.tif", &file)], &options).unwrap().volume;
        assert_eq!(volume.grid().dims(), [3, 2, 3]);
        let spacing = volume.grid().spacing_mm();
        assert!((spacing - DVec3::new(0.0005, 0.00025, 0.002)).length() < 1e-15);
        assert_eq!(volume.metadata().time_points, 2);
        assert_eq!(volume.value(0, 0, 1), (10 * (3 * time_index + 1)) as f64);
    }
    let options = ReadOptions {
        time_index: 2,
        ..ReadOptions::default()
    };
    let error = read_with(&[("v.tif", &file)], &options).unwrap_err();
    assert!(error.to_string().contains("0 to 1"), "{error}");

    // One directory, three pictures after each other: how ImageJ writes more than 4 GiB.
    let text = "ImageJ=1.53t\nimages=3\nslices=3\n";
    let page = Page::new(2, 1, 16, 1, &[1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 6, 0]).describe(text);
    let file = Tiff::new(vec![page.clone()]).bytes();
    assert_eq!(samples(&file), Samples::U16(vec![1, 2, 3, 4, 5, 6]));
    // The directory in front and the data at the end, cut off.
    let moved = page.clone().set(273, LONG, &[500]);
    let mut file = Tiff::new(vec![moved]).bytes();
    file.resize(500, 0);
    file.extend([1, 0, 2, 0, 3, 0, 4, 0, 5, 0]);
    let error = message(&[("v.tif", &file)]);
    assert!(
        error.contains("3 images") && error.contains("12 bytes, 10"),
        "{error}"
    );

    let channels = page.describe("ImageJ=1.53t\nimages=3\nchannels=3\n");
    let error = message(&[("v.tif", &Tiff::new(vec![channels]).bytes())]);
    assert!(error.contains("channels is 3"), "{error}");
}

#[test]
fn ome_gives_spacing_and_order() {
    let text = "<OME><Image><Pixels DimensionOrder=\"XYTZC\" SizeZ=\"2\" SizeC=\"1\" SizeT=\"2\" \
                PhysicalSizeX=\"0.5\" PhysicalSizeY=\"0.5\" PhysicalSizeZ=\"2\" \
                PhysicalSizeZUnit=\"nm\"/></Image></OME>";
    let mut pages = u8_pages(4);
    pages[0] = pages[0].clone().describe(text);
    let volume = read(&[("v.tif", &Tiff::new(pages).bytes())])
        .unwrap()
        .volume;
    assert_eq!(volume.grid().dims(), [3, 2, 2]);
    assert_eq!(volume.value(0, 0, 1), 20.0);
    let spacing = volume.grid().spacing_mm();
    assert!((spacing - DVec3::new(0.0005, 0.0005, 0.000002)).length() < 1e-15);
    assert_eq!(volume.metadata().modality, Some(Modality::Microscopy));
}

#[test]
fn what_the_user_should_know_is_noted() {
    let notes = |pages: Vec<Page>| {
        let loaded = read(&[("v.tif", &Tiff::new(pages).bytes())]).unwrap();
        (loaded.volume.grid().dims()[2], loaded.notes.join("; "))
    };
    let white = u8_pages(1).remove(0).set(262, SHORT, &[0]);
    assert!(notes(vec![white]).1.contains("0 as white"));
    // A thumbnail of another size, in color.
    let mut pages = u8_pages(2);
    let thumbnail = Page::new(1, 1, 8, 1, &[1, 2, 3])
        .set(254, LONG, &[1])
        .set(262, SHORT, &[2]);
    pages.insert(1, thumbnail);
    let (slices, said) = notes(pages);
    assert!(
        slices == 2 && said.contains("1 pages that are reduced"),
        "{said}"
    );
    let mut pages = u8_pages(2);
    pages[0] = pages[0].clone().describe("ImageJ=1\nimages=7\n");
    let (slices, said) = notes(pages);
    assert!(
        slices == 2 && said.contains("promises 7 images, 2"),
        "{said}"
    );
}

#[test]
fn what_is_not_grey_is_refused() {
    let page = || u8_pages(1).remove(0);
    for (page, part) in [
        (
            page().set(262, SHORT, &[3]).set(320, SHORT, &[0; 765]),
            "ColorMap of page 1 is of 765 numbers",
        ),
        (
            page().set(262, SHORT, &[3]),
            "ColorMap of page 1 is missing",
        ),
        (
            page().set(262, SHORT, &[6]).set(277, SHORT, &[3]),
            "color (YCbCr)",
        ),
        (
            page().set(262, SHORT, &[2]).set(277, SHORT, &[2]),
            "SamplesPerPixel of page 1 is 2",
        ),
        (
            page().set(277, SHORT, &[3]).set(284, SHORT, &[2]),
            "PlanarConfiguration of page 1 is 2",
        ),
        (
            page().set(277, SHORT, &[2]).set(258, SHORT, &[8, 16]),
            "BitsPerSample of page 1 is [8, 16]",
        ),
        (
            page().set(262, SHORT, &[77]),
            "PhotometricInterpretation of page 1 is 77",
        ),
    ] {
        let error = message(&[("v.tif", &Tiff::new(vec![page]).bytes())]);
        assert!(
            error.starts_with("v.tif: ") && error.contains(part),
            "{error}"
        );
    }
}

#[test]
fn pages_of_another_kind_are_named() {
    for (page, part) in [
        (
            Page::new(2, 2, 8, 1, &[0; 4]),
            "page 2 is 2 x 2 u8, page 1 is 3 x 2 u8",
        ),
        (Page::new(3, 2, 16, 2, &[0; 12]), "page 2 is 3 x 2 i16"),
    ] {
        let error = message(&[(
            "v.tif",
            &Tiff::new(vec![u8_pages(1).remove(0), page]).bytes(),
        )]);
        assert!(error.contains(part), "{error}");
    }
}

#[test]
fn tags_that_lie_are_refused() {
    let page = || u8_pages(1).remove(0);
    let packed = || page().set(259, SHORT, &[8]);
    let cases: Vec<(Page, &str)> = vec![
        (page().set(256, SHORT, &[0]), "ImageWidth of page 1 is 0"),
        (
            page().set(257, LONG, &[u64::from(u32::MAX)]),
            "ImageLength of page 1 is 4294967295",
        ),
        (page().without(256), "ImageWidth of page 1 is missing"),
        (
            page().set(258, SHORT, &[13]).set(339, SHORT, &[2]),
            "13 bits, signed",
        ),
        (page().set(258, SHORT, &[24]), "24 bits, unsigned"),
        (
            page().set(258, SHORT, &[24]).set(339, SHORT, &[3]),
            "24 bits, floating point",
        ),
        (page().set(259, SHORT, &[7]), "method JPEG"),
        (page().set(259, SHORT, &[999]), "method number 999"),
        (packed().set(317, SHORT, &[3]), "Predictor of page 1 is 3"),
        (page().set(278, SHORT, &[0]), "RowsPerStrip of page 1 is 0"),
        (
            page().set(278, SHORT, &[1]),
            "number of strips or tiles of page 1 is 1",
        ),
        (page().set(273, LONG, &[1 << 30]), "cut off"),
        (
            page().set(256, SHORT, &[60_000]).set(257, SHORT, &[60_000]),
            "cut off",
        ),
        (
            packed()
                .set(256, SHORT, &[60_000])
                .set(257, SHORT, &[60_000]),
            "page 1",
        ),
        (packed().set(279, LONG, &[0]), "size of a strip or tile"),
        (packed().set(279, LONG, &[1 << 31]), "cut off"),
        (page().set(257, RATIONAL, &[2, 1]), "type of tag 257"),
    ];
    for (page, part) in cases {
        let error = message(&[("v.tif", &Tiff::new(vec![page]).bytes())]);
        assert!(
            error.starts_with("v.tif: ") && error.contains(part),
            "{part}: {error}"
        );
    }
    let error = message(&[("v.tif", b"II*\0\0\0\0\0")]);
    assert!(error.contains("a page is missing"), "{error}");
    let error = message(&[("v.tif", b"II+\0\x04\0\0\0\x10\0\0\0\0\0\0\0")]);
    assert!(error.contains("bytes of a position is 4"), "{error}");
    // The last directory leads back to the first.
    let mut file = Tiff::new(u8_pages(1)).bytes();
    let (first, end) = (file[4..8].to_vec(), file.len());
    file[end - 4..].copy_from_slice(&first);
    let error = message(&[("v.tif", &file)]);
    assert!(error.contains("after page 1"), "{error}");
}

#[test]
fn pages_cannot_share_their_data_to_fill_memory() {
    let data = deflate(&[0; 1 << 16]);
    let page = Page::new(256, 256, 8, 1, &data).set(259, SHORT, &[8]);
    let mut pages = vec![page.clone()];
    for _ in 0..20 {
        let mut copy = page
            .clone()
            .set(273, LONG, &[8])
            .set(279, LONG, &[data.len() as u64]);
        copy.chunks.clear();
        pages.push(copy);
    }
    let error = message(&[("v.tif", &Tiff::new(pages).bytes())]);
    assert!(error.contains("the data of the pages"), "{error}");
}

/// One page of 2 × 3 u8.
pub(crate) fn slice(data: &[u8; 6]) -> Vec<u8> {
    Tiff::new(vec![Page::new(2, 3, 8, 1, data)]).bytes()
}

#[test]
fn the_last_row_of_an_lzw_strip_comes_out() {
    // 16 rows of 2 pixels in one strip, packed by libtiff through tifffile.
    let packed = [
        0x80, 0x3f, 0xe0, 0x40, 0x08, 0x24, 0x16, 0x05, 0x07, 0x84, 0x40, 0xe0, 0x60, 0x08, 0x54,
        0x0e, 0x02,
    ];
    let page = Page::new(2, 16, 8, 1, &packed).set(259, SHORT, &[5]);
    let expected = [
        255, 255, 255, 0, 0, 0, 0, 0, 0, 255, 255, 255, 255, 255, 255, 255, 255, 255, 255, 255, 0,
        255, 255, 0, 0, 255, 255, 0, 255, 255, 255, 0,
    ];
    assert_eq!(
        samples(&Tiff::new(vec![page]).bytes()),
        Samples::U8(expected.to_vec())
    );
    // Rows of all lengths, strings of all lengths.
    for width in [1, 2, 3, 5, 64, 300] {
        let rows = 40;
        let data: Vec<u8> = (0..width * rows).map(|i| (i / 7 % 3) as u8).collect();
        let packed = weezl::encode::Encoder::with_tiff_size_switch(weezl::BitOrder::Msb, 8)
            .encode(&data)
            .unwrap();
        let page = Page::new(width, rows, 8, 1, &packed).set(259, SHORT, &[5]);
        assert_eq!(
            samples(&Tiff::new(vec![page]).bytes()),
            Samples::U8(data),
            "{width}"
        );
    }
}

#[test]
fn bits_may_lie_the_other_way_round() {
    let numbers: Vec<u16> = (0..20).map(|i| 1000 * i).collect();
    let plain: Vec<u8> = numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
    let turned = |data: &[u8]| {
        data.iter()
            .map(|byte| byte.reverse_bits())
            .collect::<Vec<_>>()
    };
    for (method, data) in [(1, turned(&plain)), (8, turned(&deflate(&plain)))] {
        let page = Page::new(5, 4, 16, 1, &data)
            .set(259, SHORT, &[method])
            .set(266, SHORT, &[2]);
        assert_eq!(
            samples(&Tiff::new(vec![page]).bytes()),
            Samples::U16(numbers.clone())
        );
    }
    let page = Page::new(3, 2, 1, 1, &[0b0000_0101, 0b0000_0110]).set(266, SHORT, &[2]);
    assert_eq!(
        samples(&Tiff::new(vec![page]).bytes()),
        Samples::U8(vec![1, 0, 1, 0, 1, 1])
    );
}

#[test]
fn tiles_may_have_a_depth() {
    let dims = [37u64, 21, 19];
    let value = |x: u64, y: u64, z: u64| (x + 37 * (y + 21 * z)) as u16;
    let expected: Vec<u16> = (0..19)
        .flat_map(|z| (0..21).flat_map(move |y| (0..37).map(move |x| value(x, y, z))))
        .collect();
    let tile = |x0: u64, y0: u64, z0: u64, [w, h, d]: [u64; 3]| -> Vec<u8> {
        let mut data = Vec::new();
        for z in z0..z0 + d {
            for y in y0..y0 + h {
                for x in x0..x0 + w {
                    let inside = x < 37 && y < 21 && z < 19;
                    data.extend(if inside { value(x, y, z) } else { 0 }.to_le_bytes());
                }
            }
        }
        data
    };
    for size in [[16, 16, 16], [16, 16, 1], [48, 32, 8]] {
        for method in [1, 8] {
            let mut page = Page::new(dims[0], dims[1], 16, 1, &[])
                .set(259, SHORT, &[method])
                .set(32997, LONG, &[dims[2]])
                .set(322, SHORT, &[size[0]])
                .set(323, SHORT, &[size[1]])
                .set(32998, LONG, &[size[2]]);
            page.tiled = true;
            page.chunks.clear();
            for z in (0..dims[2]).step_by(size[2] as usize) {
                for y in (0..dims[1]).step_by(size[1] as usize) {
                    for x in (0..dims[0]).step_by(size[0] as usize) {
                        let data = tile(x, y, z, size);
                        page.chunks
                            .push(if method == 1 { data } else { deflate(&data) });
                    }
                }
            }
            let file = Tiff::new(vec![page]).bytes();
            let loaded = read(&[("v.tif", &file)]).unwrap();
            assert_eq!(loaded.volume.grid().dims(), [37, 21, 19]);
            assert_eq!(
                *loaded.volume.samples(),
                Samples::U16(expected.clone()),
                "{size:?}"
            );
        }
    }
}

/// A MetaMorph stack of 3 planes of 2×1; tables behind the samples.
fn metamorph(heights: [u32; 3], calibrated: bool) -> Vec<u8> {
    let mut data: Vec<u8> = vec![1, 2, 3, 4, 5, 6];
    // The samples come first in the file, behind 8 bytes of header.
    let table = |data: &mut Vec<u8>, numbers: &[u32]| {
        let at = 8 + data.len() as u64;
        data.extend(numbers.iter().flat_map(|n| n.to_le_bytes()));
        at
    };
    let planes: Vec<u32> = heights.iter().flat_map(|h| [*h, 2, 0, 0, 0, 0]).collect();
    let uic2 = table(&mut data, &planes);
    let x = table(&mut data, &[1, 2]) as u32;
    let y = table(&mut data, &[1, 4]) as u32;
    let unit = table(&mut data, &[2, u32::from_le_bytes(*b"um\0\0")]) as u32;
    let pairs = [3, u32::from(calibrated), 4, x, 5, y, 6, unit];
    let uic1 = table(&mut data, &pairs);
    let page = Page::new(2, 1, 8, 1, &data)
        .set(279, LONG, &[2])
        .set(33628, LONG, &[uic1])
        .set(33629, RATIONAL, &[uic2, 0]);
    let mut file = Tiff::new(vec![page]).bytes();
    // The counts and places of these entries follow rules of their own.
    for (tag, count, at) in [(33628u16, 4u32, uic1), (33629, 3, uic2)] {
        let entry = file
            .windows(2)
            .rposition(|bytes| bytes == tag.to_le_bytes())
            .unwrap();
        file[entry + 4..entry + 8].copy_from_slice(&count.to_le_bytes());
        file[entry + 8..entry + 12].copy_from_slice(&(at as u32).to_le_bytes());
    }
    file
}

#[test]
fn planes_of_metamorph_follow_their_one_page() {
    let loaded = read(&[("v.stk", &metamorph([4, 4, 4], true))]).unwrap();
    assert_eq!(loaded.volume.grid().dims(), [2, 1, 3]);
    assert_eq!(
        *loaded.volume.samples(),
        Samples::U8(vec![1, 2, 3, 4, 5, 6])
    );
    let spacing = loaded.volume.grid().spacing_mm();
    assert!(
        (spacing - DVec3::new(0.0005, 0.00025, 0.002)).length() < 1e-12,
        "{spacing}"
    );
    assert!(loaded.volume.metadata().has_length_unit && loaded.notes.is_empty());

    let loaded = read(&[("v.stk", &metamorph([4, 4, 6], false))]).unwrap();
    assert_eq!(loaded.volume.grid().spacing_mm(), DVec3::new(1.0, 1.0, 2.0));
    assert_eq!(loaded.notes.len(), 2, "{:?}", loaded.notes);

    let mut cut = metamorph([4, 4, 4], true);
    // Fewer bytes than planes: the strip begins near the end.
    let strip = cut
        .windows(2)
        .rposition(|bytes| bytes == 273u16.to_le_bytes())
        .unwrap();
    let late = cut.len() as u32 - 4;
    cut[strip + 8..strip + 12].copy_from_slice(&late.to_le_bytes());
    assert!(message(&[("v.stk", &cut)]).contains("MetaMorph"));
}

#[test]
fn the_shape_that_tifffile_writes_is_kept() {
    let file = |text: &str, pages: u8| {
        let mut all = u8_pages(pages);
        all[0] = all[0].clone().describe(text);
        Tiff::new(all).bytes()
    };
    let time = |file: &[u8], time_index| {
        let options = ReadOptions {
            time_index,
            ..ReadOptions::default()
        };
        read_with(&[("v.tif", file)], &options)
    };
    let first = |loaded: &strahl_volume::read::LoadedVolume| {
        (0..loaded.volume.grid().dims()[2])
            .map(|z| loaded.volume.value(0, 0, z))
            .collect::<Vec<_>>()
    };
    for (text, expected) in [
        (
            r#"{"shape": [2, 3, 2, 3], "axes": "TZYX"}"#,
            [30.0, 40.0, 50.0],
        ),
        (
            r#"{"shape": [3, 2, 2, 3], "axes": "ZTYX"}"#,
            [10.0, 30.0, 50.0],
        ),
        (r#"{"shape": [2, 3, 2, 3]}"#, [30.0, 40.0, 50.0]),
    ] {
        let loaded = time(&file(text, 6), 1).unwrap();
        assert_eq!(loaded.volume.metadata().time_points, 2, "{text}");
        assert_eq!(first(&loaded), expected, "{text}");
        assert_eq!(loaded.notes.len(), usize::from(!text.contains("axes")));
    }
    let channels = file(r#"{"shape": [2, 3, 2, 3], "axes": "CZYX"}"#, 6);
    assert!(
        time(&channels, 0)
            .unwrap_err()
            .to_string()
            .contains("channels")
    );
    // All samples behind one page, as `truncate` writes them.
    let page = Page::new(3, 2, 8, 1, &(0..36).collect::<Vec<u8>>())
        .set(279, LONG, &[6])
        .describe(r#"{"shape": [2, 3, 2, 3], "axes": "TZYX", "truncated": true}"#);
    let loaded = time(&Tiff::new(vec![page]).bytes(), 1).unwrap();
    assert_eq!(*loaded.volume.samples(), Samples::U8((18..36).collect()));
}

#[test]
fn half_floats_and_64_bit_numbers_are_read() {
    let half: Vec<u8> = [0x3C00u16, 0xBE00]
        .iter()
        .flat_map(|n| n.to_be_bytes())
        .collect();
    let file = Tiff {
        big_endian: true,
        big: false,
        pages: vec![Page::new(2, 1, 16, 3, &half)],
    };
    let loaded = read(&[("v.tif", &file.bytes())]).unwrap();
    assert_eq!(*loaded.volume.samples(), Samples::F32(vec![1.0, -1.5]));
    // The floating-point predictor: high bytes first, as differences.
    let packed = deflate(&[0x3C, 0xBE - 0x3C, 0u8.wrapping_sub(0xBE), 0]);
    let page = Page::new(2, 1, 16, 3, &packed)
        .set(259, SHORT, &[8])
        .set(317, SHORT, &[3]);
    let loaded = read(&[("v.tif", &Tiff::new(vec![page]).bytes())]).unwrap();
    assert_eq!(*loaded.volume.samples(), Samples::F32(vec![1.0, -1.5]));
    let long: Vec<u8> = [-5i64, 6].iter().flat_map(|n| n.to_le_bytes()).collect();
    let loaded = read(&[(
        "v.tif",
        &Tiff::new(vec![Page::new(2, 1, 64, 2, &long)]).bytes(),
    )])
    .unwrap();
    assert_eq!(*loaded.volume.samples(), Samples::I32(vec![-5, 6]));
    // Packed as a whole.
    let loaded = read(&[("v.tif.gz", &gzip(&small()))]).unwrap();
    assert_eq!(loaded.volume.grid().dims(), [2, 3, 2]);
}

#[test]
fn colors_become_luminance_and_components_can_be_picked() {
    let pick = |page: &Page, component| {
        let options = ReadOptions {
            component,
            ..ReadOptions::default()
        };
        let file = Tiff::new(vec![page.clone(), page.clone()]).bytes();
        let loaded = read_with(&[("v.tif", &file)], &options)?;
        assert_eq!(loaded.volume.grid().dims(), [3, 1, 2]);
        let first = (0..3)
            .map(|x| loaded.volume.value(x, 0, 0))
            .collect::<Vec<_>>();
        assert_eq!(loaded.volume.value(2, 0, 1), first[2]);
        Ok::<_, strahl_volume::Error>(first)
    };
    let pixels = [[255u8, 0, 0], [0, 255, 0], [10, 20, 30]];
    let rgb = Page::new(3, 1, 8, 1, &pixels.concat())
        .set(258, SHORT, &[8, 8, 8])
        .set(262, SHORT, &[2])
        .set(277, SHORT, &[3]);
    assert_eq!(pick(&rgb, None).unwrap(), [54.0, 182.0, 19.0]);
    assert_eq!(pick(&rgb, Some(2)).unwrap(), [0.0, 0.0, 30.0]);
    // Packed, with differences to the pixel on the left; tiles beyond the page.
    let differences = [255, 0, 0, 1, 255, 0, 10, 21, 30, 0, 0, 0];
    let mut tiles = rgb
        .clone()
        .set(259, SHORT, &[8])
        .set(317, SHORT, &[2])
        .set(322, SHORT, &[4])
        .set(323, SHORT, &[1]);
    tiles.tiled = true;
    tiles.chunks = vec![deflate(&differences)];
    assert_eq!(pick(&tiles, Some(1)).unwrap(), [0.0, 255.0, 20.0]);
    // Gray with opacity, and numbers that nobody names.
    let two = Page::new(3, 1, 8, 1, &[1, 255, 2, 255, 3, 0]).set(277, SHORT, &[2]);
    let grey = two.clone().set(338, SHORT, &[2]);
    assert_eq!(pick(&grey, None).unwrap(), [1.0, 2.0, 3.0]);
    assert!(pick(&two, None).unwrap_err().to_string().contains("0 to 1"));
    assert_eq!(pick(&two, Some(1)).unwrap(), [255.0, 255.0, 0.0]);
}

/// Four pixels of two bits: indices 0, 1, 2, 3.
fn indices(palette: &[u64]) -> Page {
    Page::new(4, 1, 2, 1, &[0b0001_1011])
        .set(262, SHORT, &[3])
        .set(320, SHORT, palette)
}

#[test]
fn indices_stand_for_the_colors_of_their_palette() {
    // Black, red, green and (10, 20, 30): all reds, then all greens, then all blues, times 257.
    let reds_greens_blues = [0, 255, 0, 10, 0, 0, 255, 20, 0, 0, 0, 30];
    let wide = reds_greens_blues.map(|c| 257 * c);
    let values = |pages: Vec<Page>, options: &ReadOptions| {
        let loaded = read_with(&[("v.tif", &Tiff::new(pages).bytes())], options)?;
        let [nx, _, nz] = loaded.volume.grid().dims();
        let value = |i: usize| loaded.volume.value(i % nx, 0, i / nx);
        Ok::<_, strahl_volume::Error>((0..nx * nz).map(value).collect::<Vec<_>>())
    };
    let plain = ReadOptions::default();
    let blue = ReadOptions {
        component: Some(2),
        ..ReadOptions::default()
    };
    // What Pillow gives in mode L (BT.601) differs; these are the grays of BT.709.
    let luminance = [0.0, 54.0, 182.0, 19.0];
    for palette in [wide, reds_greens_blues] {
        assert_eq!(values(vec![indices(&palette)], &plain).unwrap(), luminance);
        let blues = values(vec![indices(&palette)], &blue).unwrap();
        assert_eq!(blues, [0.0, 0.0, 0.0, 30.0]);
    }
    // Two pages of one palette make a stack, of two palettes not.
    let two = values(vec![indices(&wide), indices(&wide)], &plain).unwrap();
    assert_eq!(two, [luminance, luminance].concat());
    let other = values(vec![indices(&wide), indices(&[0; 12])], &plain);
    assert!(
        other
            .unwrap_err()
            .to_string()
            .contains("page 2 has another palette")
    );
    // A palette of grays: one number per voxel.
    let grey = [65535, 30000, 256, 0].repeat(3);
    assert_eq!(
        values(vec![indices(&grey)], &plain).unwrap(),
        [255.0, 117.0, 1.0, 0.0]
    );
    assert!(values(vec![indices(&grey)], &blue).is_err());
    // Object ids are the indices.
    let labels = ReadOptions {
        as_labels: true,
        ..ReadOptions::default()
    };
    let ids = values(vec![indices(&wide)], &labels).unwrap();
    assert_eq!(ids, [0.0, 1.0, 2.0, 3.0]);
    // 16 bits of index.
    let reds: Vec<u64> = (0..65536).collect();
    let map = [
        reds.clone(),
        reds.iter().rev().copied().collect(),
        vec![0; 65536],
    ]
    .concat();
    let page = Page::new(2, 1, 16, 1, &[0x00, 0xFF, 0x34, 0x12])
        .set(262, SHORT, &[3])
        .set(320, SHORT, &map);
    let green = ReadOptions {
        component: Some(1),
        ..ReadOptions::default()
    };
    assert_eq!(values(vec![page], &green).unwrap(), [0.0, 237.0]);
}

/// A page whose indices are larger than the palette that it shares with the first page.
#[test]
fn indices_beyond_a_shared_palette_are_refused() {
    let palette: Vec<u64> = (0..12).collect();
    let wide = Page::new(4, 1, 8, 1, &[0, 3, 4, 255])
        .set(262, SHORT, &[3])
        .set(320, SHORT, &palette);
    let mut file = Tiff::new(vec![indices(&palette), wide]).bytes();
    // ColorMap in both directories: tag, type, number of colors, place.
    let entry = [0x40, 1, 3, 0, 12, 0, 0, 0];
    let places: Vec<usize> = (0..file.len() - 12)
        .filter(|at| file[*at..].starts_with(&entry))
        .collect();
    let [first, second] = places[..] else {
        panic!("{places:?}");
    };
    file.copy_within(first + 8..first + 12, second + 8);
    let said = message(&[("v.tif", &file)]);
    assert!(
        said.contains("ColorMap of page 2 is of 12 numbers") && said.contains("of 768 numbers"),
        "{said}"
    );
}
