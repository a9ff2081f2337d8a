//! DICOM files of all shapes, built element by element.

use crate::{assert_affine, gzip, message, read, read_with};
use glam::{DAffine3, DMat3, DVec3};
use std::io::Write;
use strahl_volume::read::{
    LoadedVolume, MemoryFiles, ReadOptions, read_file, read_file_under, read_folder,
};
use strahl_volume::{Control, Error, Remedy, Samples};

/// Elements in explicit little endian, kept in rising order of their tags.
#[derive(Clone, Default)]
struct Set(Vec<(u16, u16, [u8; 2], Vec<u8>)>);

impl Set {
    fn put(&mut self, tag: (u16, u16), vr: &[u8; 2], value: &[u8]) -> &mut Set {
        self.0
            .retain(|(group, element, ..)| (*group, *element) != tag);
        let mut value = value.to_vec();
        if value.len() % 2 == 1 {
            value.push(if vr == b"UI" || vr == b"OB" { 0 } else { b' ' });
        }
        self.0.push((tag.0, tag.1, *vr, value));
        self.0.sort();
        self
    }

    fn text(&mut self, tag: (u16, u16), vr: &[u8; 2], value: &str) -> &mut Set {
        self.put(tag, vr, value.as_bytes())
    }

    fn shorts(&mut self, tag: (u16, u16), vr: &[u8; 2], values: &[u16]) -> &mut Set {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.put(tag, vr, &bytes)
    }

    fn doubles(&mut self, tag: (u16, u16), values: &[f64]) -> &mut Set {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.put(tag, b"FD", &bytes)
    }

    fn sequence(&mut self, tag: (u16, u16), items: &[Set]) -> &mut Set {
        let mut bytes = Vec::new();
        for item in items {
            let item = item.explicit();
            bytes.extend([0xFE, 0xFF, 0x00, 0xE0]);
            bytes.extend((item.len() as u32).to_le_bytes());
            bytes.extend(item);
        }
        self.put(tag, b"SQ", &bytes)
    }

    fn explicit(&self) -> Vec<u8> {
        let mut out = Vec::new();
        for (group, element, vr, value) in &self.0 {
            out.extend(group.to_le_bytes());
            out.extend(element.to_le_bytes());
            out.extend(vr);
            if matches!(vr, b"OB" | b"OW" | b"SQ" | b"UN") {
                out.extend([0, 0]);
                out.extend((value.len() as u32).to_le_bytes());
            } else {
                out.extend((value.len() as u16).to_le_bytes());
            }
            out.extend(value);
        }
        out
    }

    fn implicit(&self) -> Vec<u8> {
        let mut out = Vec::new();
        for (group, element, _, value) in &self.0 {
            out.extend(group.to_le_bytes());
            out.extend(element.to_le_bytes());
            out.extend((value.len() as u32).to_le_bytes());
            out.extend(value);
        }
        out
    }

    fn file(&self) -> Vec<u8> {
        file_of("1.2.840.10008.1.2.1", &self.explicit())
    }
}

fn file_of(syntax: &str, set: &[u8]) -> Vec<u8> {
    let mut meta = Set::default();
    meta.text((2, 0x10), b"UI", syntax);
    [&[0; 128], &b"DICM"[..], &meta.explicit(), set].concat()
}

const ROWS: (u16, u16) = (0x28, 0x10);
const COLUMNS: (u16, u16) = (0x28, 0x11);
const POSITION: (u16, u16) = (0x20, 0x32);
const ORIENTATION: (u16, u16) = (0x20, 0x37);
const SPACING: (u16, u16) = (0x28, 0x30);
const IMAGE_TYPE: (u16, u16) = (8, 8);
const INSTANCE: (u16, u16) = (0x20, 0x13);
const FRAMES: (u16, u16) = (0x28, 8);
const PIXELS: (u16, u16) = (0x7FE0, 0x10);
const BETWEEN_SLICES: (u16, u16) = (0x18, 0x88);
const PER_FRAME: (u16, u16) = (0x5200, 0x9230);

/// An image of 16-bit samples at the origin, 1 mm apart, without further elements.
fn image(columns: u16, rows: u16, samples: &[u16]) -> Set {
    static NEXT: std::sync::atomic::AtomicU32 = std::sync::atomic::AtomicU32::new(1);
    let number = NEXT.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
    let mut set = Set::default();
    set.text((8, 0x18), b"UI", &format!("1.2.3.{number}"))
        .text((8, 0x60), b"CS", "MR")
        .text((0x20, 0x0E), b"UI", "1.2.3")
        .text(POSITION, b"DS", "0\\0\\0")
        .text(ORIENTATION, b"DS", "1\\0\\0\\0\\1\\0")
        .shorts((0x28, 2), b"US", &[1])
        .text((0x28, 4), b"CS", "MONOCHROME2")
        .shorts(ROWS, b"US", &[rows])
        .shorts(COLUMNS, b"US", &[columns])
        .text(SPACING, b"DS", "1\\1")
        .shorts((0x28, 0x100), b"US", &[16])
        .shorts((0x28, 0x101), b"US", &[16])
        .shorts((0x28, 0x102), b"US", &[15])
        .shorts((0x28, 0x103), b"US", &[0])
        .shorts(PIXELS, b"OW", samples);
    set
}

fn folder(sets: &[Set], time_index: usize) -> Result<LoadedVolume, Error> {
    let files: MemoryFiles = sets
        .iter()
        .enumerate()
        .map(|(i, set)| (format!("{i:03}.dcm"), set.file()))
        .collect();
    let options = ReadOptions {
        time_index,
        ..ReadOptions::default()
    };
    read_folder("series", &files, &options)
}

fn one(set: &Set) -> Result<LoadedVolume, Error> {
    read(&[("a.dcm", &set.file())])
}

fn samples(loaded: &LoadedVolume) -> Vec<u16> {
    match loaded.volume.samples() {
        Samples::U16(samples) => samples.clone(),
        other => panic!("{}", other.sample_type()),
    }
}

fn affine(columns: [[f64; 3]; 3], translation: [f64; 3]) -> DAffine3 {
    let matrix = DMat3::from_cols_array_2d(&columns);
    DAffine3::from_mat3_translation(matrix, DVec3::from(translation))
}

/// The shared cases' picture, made by an encoder that libjpeg agrees with: predictor 1, 12 bits, point transform 2.
const POINT_TRANSFORM: &str = "ffd8ffc400240000000000110000000000000000000000000102030405060708090a0b0c\
    0d0e0f10ffc3000b0c0008000c01011100ffda000801010001000253fe694d29a534a694d2a090d29a534a694f94d29a534a69504\
    8694d29a534a694d29f29a54121a534a694d29a534a82434a6950c8694d29a534a695048694d29a534a694f94d29a54121a534a694\
    d29a534a82434a7ca82434a694d29a534a695048694d29a54321a534a694d2a090d29a534a694d29a53e534a82434a694d29a534a6\
    95048694d2fffd9";

/// The same without point transform, with a restart marker after each row of 12.
const RESTARTS: &str = "ffd8ffc400240000000000110000000000000000000000000102030405060708090a0b0c0d0e0f10\
    ffc3000b0c0008000c01011100ffdd0004000cffda000801010001000063ff00a25112889444a2251128a24d12889444a2253fffd05\
    99344a2251128894512689444a225112889444a7fffd15b2744a289344a225112889444a2251449a251129fffd258bb44a22511288\
    9444a289344a225112889444a7fffd35a4f44a2251449a25112889444a2251128a24d129fffd45be3512689444a225112889444a28\
    9344a2251129fffd5597744a2251128894512689444a225112889444a7fffd65b0b44a289344a225112889444a2251449a251129ff\
    fd9";

#[test]
fn lossless_jpeg_has_the_values_that_libjpeg_finds() {
    let expected: Vec<u16> = (0..96)
        .map(|i| 4 * ((37 * (i % 12) + 101 * (i / 12)) % 256))
        .collect();
    for hex in [POINT_TRANSFORM, RESTARTS] {
        let mut set = image(12, 8, &[]);
        set.shorts((0x28, 0x101), b"US", &[12])
            .shorts((0x28, 0x102), b"US", &[11]);
        let file = packed("1.2.840.10008.1.2.4.70", &set, &of_hex(hex));
        let loaded = read(&[("a.dcm", &file)]).unwrap();
        assert_eq!(samples(&loaded), expected);
    }
}

/// An image of one packed frame.
fn packed(syntax: &str, set: &Set, frame: &[u8]) -> Vec<u8> {
    let mut set = set.clone();
    set.0.retain(|element| element.0 != 0x7FE0);
    let mut elements = set.explicit();
    elements.extend([0xE0, 0x7F, 0x10, 0, b'O', b'B', 0, 0, 255, 255, 255, 255]);
    elements.extend([0xFE, 0xFF, 0, 0xE0, 0, 0, 0, 0]);
    elements.extend([0xFE, 0xFF, 0, 0xE0]);
    elements.extend((frame.len() as u32).to_le_bytes());
    elements.extend(frame);
    elements.extend([0xFE, 0xFF, 0xDD, 0xE0, 0, 0, 0, 0]);
    file_of(syntax, &elements)
}

fn of_hex(hex: &str) -> Vec<u8> {
    let byte = |i: usize| u8::from_str_radix(&hex[2 * i..2 * i + 2], 16).unwrap();
    (0..hex.len() / 2).map(byte).collect()
}

/// A picture of 8-bit colors without its pixels.
fn color_image(columns: u16, rows: u16, photometric: &str, planar: u16) -> Set {
    let mut set = image(columns, rows, &[]);
    set.shorts((0x28, 2), b"US", &[3])
        .text((0x28, 4), b"CS", photometric)
        .shorts((0x28, 6), b"US", &[planar])
        .shorts((0x28, 0x100), b"US", &[8])
        .shorts((0x28, 0x101), b"US", &[8])
        .shorts((0x28, 0x102), b"US", &[7]);
    set
}

/// Red, green and blue of all pixels, each read as a component.
fn colors_of(file: &[u8]) -> Vec<[f64; 3]> {
    let component = |component: usize| {
        let options = ReadOptions {
            component: Some(component),
            ..ReadOptions::default()
        };
        let loaded = read_with(&[("a.dcm", file)], &options).unwrap();
        let metadata = loaded.volume.metadata();
        assert_eq!(
            (metadata.components.count, metadata.components.are_colors),
            (3, true)
        );
        let [columns, rows, _] = loaded.volume.grid().dims();
        let value = |i: usize| loaded.volume.value(i % columns, i / columns, 0);
        (0..columns * rows).map(value).collect::<Vec<_>>()
    };
    let [red, green, blue] = [0, 1, 2].map(component);
    let pixels = red.iter().zip(&green).zip(&blue);
    pixels.map(|((r, g), b)| [*r, *g, *b]).collect()
}

const PIXELS_RGB: [[u8; 3]; 8] = [
    [0, 255, 30],
    [60, 205, 31],
    [120, 155, 32],
    [180, 105, 33],
    [9, 235, 70],
    [69, 185, 71],
    [129, 135, 72],
    [189, 85, 73],
];

/// [`PIXELS_RGB`] taken for Y, Cb and Cr: the red, green and blue that pydicom's `convert_color_space` gives.
const PIXELS_OF_YBR: [[u8; 3]; 8] = [
    [0, 26, 225],
    [0, 103, 196],
    [0, 179, 168],
    [47, 255, 139],
    [0, 14, 199],
    [0, 90, 170],
    [50, 167, 141],
    [112, 243, 113],
];

/// [`PIXELS_RGB`] in JPEG 2000, lossless with the reversible color transform, by OpenJPEG.
const COLORS_IN_JPEG_2000: &str = "ff4fff51002f00000000000400000002000000000000000000000004000000020000\
    0000000000000003070101070101070101ff52000c00000001010004040001ff5c00044040ff64002500014372656174656420\
    6279204f70656e4a5045472076657273696f6e20322e352e34ff90000a0000000000320001ff93c3e70e16793a297be1c7df80\
    4808b5af5a7ffdc52c53df805808b4d88c06c4659db4537fffd9";

/// 8×8 pixels, (20 x + 40, 200 − 20 y, 10 x + 10 y), in baseline JPEG without subsampling, by libjpeg.
const COLORS_IN_JPEG: &str = "ffd8ffe000104a46494600010100000100010000ffdb00430003020203020203\
    03030304030304050805050404050a070706080c0a0c0c0b0a0b0b0d0e12100d0e110e0b0b1016101113141515\
    150c0f171816141812141514ffdb00430103040405040509050509140d0b0d1414141414141414141414141414\
    141414141414141414141414141414141414141414141414141414141414141414141414ffc000110800080008\
    03011100021101031101ffc40014000100000000000000000000000000000005ffc40019100001050000000000\
    0000000000000000070023334151ffc4001501010100000000000000000000000000000407ffc4001911000203\
    01000000000000000000000000000604223262ffda000c03010002110311003f00087c6189fcb5388e95c81555\
    dcd4ffd9";

#[test]
fn colors_are_red_green_and_blue_however_they_are_stored() {
    let as_f64 = |pixels: [[u8; 3]; 8]| pixels.map(|pixel| pixel.map(f64::from)).to_vec();
    let planes = |pixels: [[u8; 3]; 8]| [0, 1, 2].map(|i| pixels.map(|p| p[i])).concat();
    let native = |photometric: &str, planar: u16, bytes: &[u8]| {
        let mut set = color_image(4, 2, photometric, planar);
        set.put(PIXELS, b"OB", bytes);
        colors_of(&set.file())
    };
    let stored = PIXELS_RGB.concat();
    assert_eq!(native("RGB", 0, &stored), as_f64(PIXELS_RGB));
    assert_eq!(native("RGB", 1, &planes(PIXELS_RGB)), as_f64(PIXELS_RGB));
    assert_eq!(native("YBR_FULL", 0, &stored), as_f64(PIXELS_OF_YBR));
    let planar = native("YBR_FULL", 1, &planes(PIXELS_RGB));
    assert_eq!(planar, as_f64(PIXELS_OF_YBR));
    // Pairs of Y, Y, Cb, Cr: gray, then what pydicom gives for (60, 205, 31).
    let pairs = [7, 200, 128, 128, 60, 60, 205, 31].repeat(2);
    let row = [
        [7.0; 3],
        [200.0; 3],
        [0.0, 103.0, 196.0],
        [0.0, 103.0, 196.0],
    ];
    assert_eq!(native("YBR_FULL_422", 0, &pairs), [row, row].concat());

    // Run lengths: always planes, whatever PlanarConfiguration says.
    let mut frame = vec![3, 0, 0, 0];
    for plane in 0..3u32 {
        frame.extend((64 + 10 * plane).to_le_bytes());
    }
    frame.resize(64, 0);
    for plane in planes(PIXELS_RGB).chunks(8) {
        frame.push(7);
        frame.extend(plane);
        frame.push(0x80);
    }
    let rle = packed("1.2.840.10008.1.2.5", &color_image(4, 2, "RGB", 0), &frame);
    assert_eq!(colors_of(&rle), as_f64(PIXELS_RGB));
    let rle = packed(
        "1.2.840.10008.1.2.5",
        &color_image(4, 2, "YBR_FULL", 1),
        &frame,
    );
    assert_eq!(colors_of(&rle), as_f64(PIXELS_OF_YBR));

    let frame = of_hex(COLORS_IN_JPEG_2000);
    let set = color_image(4, 2, "YBR_RCT", 0);
    let jpeg_2000 = packed("1.2.840.10008.1.2.4.90", &set, &frame);
    assert_eq!(colors_of(&jpeg_2000), as_f64(PIXELS_RGB));

    // Luminance without a choice, and gray images have nothing to choose.
    let loaded = read(&[("a.dcm", &jpeg_2000)]).unwrap();
    assert_eq!(loaded.volume.value(0, 0, 0), 185.0);
    assert!(loaded.notes.iter().any(|note| note.contains("luminance")));
}

#[test]
fn colors_in_lossy_jpeg_are_what_the_stream_says() {
    let jpeg = of_hex(COLORS_IN_JPEG);
    // The first and the last pixel as libjpeg decodes them, and without the transform.
    let (rgb, ybr) = (
        [[41, 199, 1], [179, 61, 137]],
        [[129, 56, 65], [105, 146, 181]],
    );
    let without_jfif = [&jpeg[..2], &jpeg[20..]].concat();
    for (photometric, frame, expected) in [
        ("YBR_FULL_422", &jpeg, rgb),
        ("RGB", &jpeg, rgb),
        ("YBR_FULL_422", &without_jfif, rgb),
        ("RGB", &without_jfif, ybr),
    ] {
        let set = color_image(8, 8, photometric, 0);
        let found = colors_of(&packed("1.2.840.10008.1.2.4.50", &set, frame));
        for (found, expected) in [found[0], found[63]].iter().zip(expected) {
            for (found, expected) in found.iter().zip(expected) {
                let difference = (found - f64::from(expected)).abs();
                assert!(
                    difference <= 1.0,
                    "{photometric}: {found} is not {expected}"
                );
            }
        }
    }
}

/// 9×6 pixels of [`jpeg_ls_color`] with 8 bits, by CharLS: component by component, line by line, pixel by pixel.
const COLORS_IN_JPEG_LS: [&str; 3] = [
    "ffd8fff70011080006000903011100021100031100ffda0008010100000000f0000016602aeaa6b6536961ad2e33af2b\
     de47f8ffda0008010200000000aa9457829ecb66664d9836630c43981806888e429c30c6630c414600c000d111c8539c\
     ffda0008010300000000495f9ff8a0000023a000406021c6145430200c58a0010b001220a608183cb040ffd9",
    "ffd8fff70011080006000903011100021100031100ffda000c03010002000300000100f0000016602aeaa742a515fdfa\
     2821088888877326d2cd99993669f8d5a97036630c439847ab6af00d111c85384088e0502038302883dd26f18cc61882\
     8c01a1862041c10f16c93f00068889510c6a204518302881c0ffd9",
    "ffd8fff70011080006000903011100021100031100ffda000c030100020003000002004b8a6b6580000059458000008c\
     3e038580e4c3cb8d34cd0c688d19a3244d168cd03068ad3348d20d2225d2c9088a01b683b20224075c19405541173d08\
     7b8c498d186988861120e941549e8062d8000d244441285646683280ce885a38ffd9",
];

/// The same with 12 bits and errors of at most 3.
const COLORS_IN_LOSSY_JPEG_LS: [&str; 3] = [
    "ffd8fff700110c0006000903011100021100031100ffda0008010100030000f3b3bb8a611094211294911a24554954d5\
     2564d878ffda0008010200030000d184df3ba612954843221a24b26a9a48ab0b528b630ad2a8ffda0008010300030000\
     421125543ff1212224494254cc6b65a119111b90ffd9",
    "ffd8fff700110c0006000903011100021100031100ffda000c03010002000300030100f3b3bb8e984df7a21125526684\
     a10895612ad3443fd08c44a8c9089297a542154570a490a122244946293c14f524a062436ea4ca4f0b554394848489b8\
     ffd9",
    "ffd8fff700110c0006000903011100021100031100ffda000c03010002000300030200422c2213450802993b5fa6d3f6\
     90d0a428550950aa253510a2a8434c6c5965acaca1883414c5b152d124a22890b2a2929074a50656b588a29606a542c1\
     c15136e0ffd9",
];

/// The same with 5 bits and errors of at most 1, line by line: few levels have other thresholds.
const COLORS_OF_5_BITS: &str = "ffd8fff70011050006000903011100021100031100ffda000c03010002000300010100f020c572eaef5195a4924a7b4a\
    a5925dabf10be614888645bde549a006851c4738e0830628372953adba418bf708dcd7209b682c5fd232104b09153b22ffd9";

/// Ramps, waves and flat parts, so that all ways of coding occur.
fn jpeg_ls_color(x: i32, y: i32, largest: i32) -> [f64; 3] {
    let red = if x < 4 { 7 * y } else { 13 * x + y };
    let green = x * x + 3 * y * y;
    let blue = if y < 3 { largest } else { 5 * x * y };
    [red, green, blue].map(|number| f64::from(number & largest))
}

#[test]
fn colors_in_jpeg_ls_are_those_that_charls_packed() {
    let expected = |largest: i32| -> Vec<[f64; 3]> {
        let pixels = (0..54).map(|i| jpeg_ls_color(i % 9, i / 9, largest));
        pixels.collect()
    };
    let set = color_image(9, 6, "RGB", 0);
    for hex in COLORS_IN_JPEG_LS {
        let file = packed("1.2.840.10008.1.2.4.80", &set, &of_hex(hex));
        assert_eq!(colors_of(&file), expected(255));
    }
    let lossy = COLORS_IN_LOSSY_JPEG_LS.map(|hex| (12, 3.0, hex));
    for (bits, most, hex) in [&lossy[..], &[(5, 1.0, COLORS_OF_5_BITS)]].concat() {
        let mut set = set.clone();
        set.shorts((0x28, 0x100), b"US", &[if bits > 8 { 16 } else { 8 }])
            .shorts((0x28, 0x101), b"US", &[bits])
            .shorts((0x28, 0x102), b"US", &[bits - 1]);
        let found = colors_of(&packed("1.2.840.10008.1.2.4.81", &set, &of_hex(hex)));
        let expected = expected((1 << bits) - 1);
        let pairs = found.as_flattened().iter().zip(expected.as_flattened());
        let error = pairs.map(|(found, expected)| (found - expected).abs());
        let error = error.fold(0.0, f64::max);
        // Errors are there, or it would not be the near-lossless stream.
        assert!(error > 0.0 && error <= most, "{bits} bits: {error}");
    }
    // Y, Cb and Cr become red, green and blue as in every other packing.
    let ybr = color_image(9, 6, "YBR_FULL", 0);
    let file = packed(
        "1.2.840.10008.1.2.4.80",
        &ybr,
        &of_hex(COLORS_IN_JPEG_LS[1]),
    );
    // Of (0, 0, 255), by pydicom's weights: 1.402·127, −(0.299·1.402·127 − 0.114·1.772·128)/0.587, 1.772·(−128).
    assert_eq!(colors_of(&file)[0], [178.0, 0.0, 0.0]);
}

#[test]
fn jpeg_ls_says_what_is_wrong_with_its_colors() {
    let set = color_image(9, 6, "RGB", 0);
    let said = |frame: &[u8]| message(&[("a.dcm", &packed("1.2.840.10008.1.2.4.80", &set, frame))]);
    let [planes, lines, _] = COLORS_IN_JPEG_LS.map(of_hex);
    let with = |frame: &[u8], at: usize, byte: u8| {
        let mut frame = frame.to_vec();
        frame[at] = byte;
        said(&frame)
    };
    // A transform of HP, as CharLS writes it.
    let hp = [
        &[0xFF, 0xD8, 0xFF, 0xE8, 0, 7],
        &b"mrfx\x01"[..],
        &lines[2..],
    ]
    .concat();
    assert!(said(&hp).contains("transform of HP"), "{}", said(&hp));
    let none = [&[0xFF, 0xD8, 0xFF, 0xE8, 0, 7], &b"mrfx\0"[..], &lines[2..]].concat();
    let file = packed("1.2.840.10008.1.2.4.80", &set, &none);
    assert_eq!(colors_of(&file)[0], jpeg_ls_color(0, 0, 255));
    // Bytes of the frame: components at 11, the sampling of the second at 16; then the scan.
    for (found, part) in [
        (with(&lines, 11, 1), "1 components"),
        (with(&lines, 16, 0x21), "subsampled color"),
        (with(&lines, 25, 2), "wrong length"),
        (with(&lines, 26, 9), "component 9; the frame has [1, 2, 3]"),
        (with(&lines, 28, 1), "component 1 is in two scans"),
        (with(&lines, 27, 1), "mapping tables"),
        (with(&lines, 33, 0), "interleave mode 0"),
        (with(&lines, 34, 1), "point transforms"),
        (said(&lines[..80]), "ends before"),
        (said(&planes[..56]), "a marker is cut off"),
        (said(&planes[..90]), "ends before"),
    ] {
        assert!(found.contains(part), "{part}: {found}");
    }
    // A gray stream where colors are stated, and the reverse.
    let gray = packed("1.2.840.10008.1.2.4.80", &image(9, 6, &[]), &lines);
    assert!(message(&[("a.dcm", &gray)]).contains("3 components of 8 bits; allowed are 1"));
}

#[test]
fn indices_stand_for_colors_of_the_palette() {
    let tables = |set: &mut Set, descriptor: [u16; 3], tables: [Vec<u8>; 3]| {
        for (i, table) in tables.iter().enumerate() {
            set.shorts((0x28, 0x1101 + i as u16), b"US", &descriptor)
                .put((0x28, 0x1201 + i as u16), b"OW", table);
        }
    };
    let palette = |descriptor: [u16; 3], of_colors: [Vec<u8>; 3]| {
        let mut set = color_image(4, 1, "PALETTE COLOR", 0);
        set.shorts((0x28, 2), b"US", &[1])
            .put(PIXELS, b"OB", &[0, 2, 3, 9]);
        tables(&mut set, descriptor, of_colors);
        set
    };
    let words = |numbers: [u16; 3]| numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
    // Three colors from index 1 on; what lies outside gets the first or the last (PS3.3, C.7.6.3.1.5).
    let wide = [[1, 2, 300], [4, 5, 600], [7, 8, 65535]].map(words);
    let set = palette([3, 1, 16], wide);
    let (first, second) = ([1.0, 4.0, 7.0], [2.0, 5.0, 8.0]);
    let third = [300.0, 600.0, 65535.0];
    assert_eq!(colors_of(&set.file()), [first, second, third, third]);
    let narrow = [vec![10, 20, 30], vec![40, 50, 60], vec![70, 80, 90]];
    let set = palette([3, 1, 8], narrow.clone());
    let last = [30.0, 60.0, 90.0];
    assert_eq!(
        colors_of(&set.file()),
        [[10.0, 40.0, 70.0], [20.0, 50.0, 80.0], last, last]
    );
    // Shades of gray are one number, and object ids are the indices.
    let gray = palette([3, 1, 8], [vec![5, 6, 7], vec![5, 6, 7], vec![5, 6, 7]]);
    let loaded = one(&gray).unwrap();
    assert_eq!(*loaded.volume.samples(), Samples::U8(vec![5, 6, 7, 7]));
    let options = ReadOptions {
        as_labels: true,
        ..ReadOptions::default()
    };
    let labels = read_with(&[("a.dcm", &set.file())], &options).unwrap();
    assert_eq!(*labels.volume.samples(), Samples::U8(vec![0, 2, 3, 9]));

    let short = palette([5, 1, 8], narrow.clone());
    assert!(message(&[("a.dcm", &short.file())]).contains("of 5 numbers of 8 or 16 bits"));
    let mut other = palette([3, 1, 8], narrow.clone());
    other.shorts((0x28, 0x1103), b"US", &[3, 2, 8]);
    let said = message(&[("a.dcm", &other.file())]);
    for part in [
        "BluePaletteColorLookupTableDescriptor (0028,1103)",
        "3 numbers of 8 bits from index 2 on",
        "that of red: 3 numbers of 8 bits from index 1 on",
    ] {
        assert!(said.contains(part), "{said}");
    }
    let mut missing = palette([3, 1, 8], Default::default());
    missing
        .0
        .retain(|element| element.1 < 0x1200 || element.0 > 0x28);
    assert!(message(&[("a.dcm", &missing.file())]).contains("RedPaletteColorLookupTableData"));
}

/// Three colors tables in segments, for indices from 0 on.
fn in_segments(entries: u16, bits: u16, segments: [Vec<u8>; 3], pixels: &[u8]) -> Set {
    let mut set = color_image(pixels.len() as u16, 1, "PALETTE COLOR", 0);
    set.shorts((0x28, 2), b"US", &[1])
        .put(PIXELS, b"OB", pixels);
    for (i, table) in segments.iter().enumerate() {
        set.shorts((0x28, 0x1101 + i as u16), b"US", &[entries, 0, bits])
            .put((0x28, 0x1221 + i as u16), b"OW", table);
    }
    set
}

#[test]
fn palettes_in_segments_are_unfolded() {
    let words =
        |numbers: &[u16]| -> Vec<u8> { numbers.iter().flat_map(|n| n.to_le_bytes()).collect() };
    // 10 20, then 4 even steps up to 60; the ramp again, from 60 down to 60; 7.
    let red = words(&[0, 2, 10, 20, 1, 4, 60, 2, 1, 8, 0, 0, 1, 7]);
    // The discrete segment and the ramp again: 5, 5 + 1000·i/2, 5, 2505, …
    let green = words(&[0, 1, 5, 1, 2, 1005, 2, 2, 0, 0, 0, 5, 1, 2, 3, 4, 65535]);
    let blue = words(&[0, 1, 0, 1, 10, 65535]);
    let mut set = in_segments(
        11,
        16,
        [red, green, blue],
        &[0, 1, 2, 3, 4, 5, 6, 7, 9, 10, 99],
    );
    let expected = [
        [10.0, 5.0, 0.0],
        [20.0, 505.0, 6554.0],
        [30.0, 1005.0, 13107.0],
        [40.0, 5.0, 19661.0],
        [50.0, 505.0, 26214.0],
        [60.0, 1005.0, 32768.0],
        [60.0, 1.0, 39321.0],
        [60.0, 2.0, 45875.0],
        [60.0, 4.0, 58982.0],
        [7.0, 65535.0, 65535.0],
        [7.0, 65535.0, 65535.0],
    ];
    assert_eq!(colors_of(&set.file()), expected);
    // A table without segments comes first.
    for (i, color) in [1, 2, 3].iter().enumerate() {
        set.put((0x28, 0x1201 + i as u16), b"OW", &words(&[*color; 11]));
    }
    assert_eq!(colors_of(&set.file()), [[1.0, 2.0, 3.0]; 11]);

    // Numbers of 8 bits; the offset of the indirect segment has 4 of them. 9 bytes and one to fill up.
    let red = vec![0, 2, 1, 2, 2, 1, 0, 0, 0, 0];
    let green = vec![0, 1, 9, 1, 3, 0];
    let blue = vec![0, 4, 4, 3, 2, 1];
    let set = in_segments(4, 8, [red, green, blue], &[0, 1, 2, 3]);
    let expected = [
        [1.0, 9.0, 4.0],
        [2.0, 6.0, 3.0],
        [1.0, 3.0, 2.0],
        [2.0, 0.0, 1.0],
    ];
    assert_eq!(colors_of(&set.file()), expected);
}

#[test]
fn damaged_segments_of_palettes_are_refused() {
    let good: Vec<u8> = [0u16, 4, 1, 2, 3, 4]
        .iter()
        .flat_map(|n| n.to_le_bytes())
        .collect();
    for (numbers, part) in [
        (&[1u16, 4, 9][..], "a linear segment comes first"),
        (&[0, 3, 1, 2, 3], "its segments make 3 of 4 colors"),
        (&[0, 5, 1, 2, 3, 4, 5], "more than 4 colors"),
        (&[0, 4, 1, 2, 3, 4, 0, 1, 5], "more than 4 colors"),
        (&[0, 1, 1, 1, 4, 9], "more than 4 colors"),
        (&[0, 4, 1, 2, 3], "the segment at number 0 is cut off"),
        (
            &[0, 1, 1, 7, 1, 1],
            "is of kind 7; allowed are 0 (discrete)",
        ),
        (&[0, 1, 1, 2, 1, 6, 0], "names another indirect one"),
        (&[0, 1, 1, 2, 1, 1, 0], "names the odd byte 1"),
        (&[0, 1, 1, 2, 1, 0xFFFE, 0xFFFF], "is cut off"),
        (
            &[0, 1, 1, 0, 0, 2, 0xFFFF, 6, 0],
            "the segment at number 3 is of length 0",
        ),
    ] {
        let green: Vec<u8> = numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
        let set = in_segments(4, 16, [good.clone(), green, good.clone()], &[0, 1]);
        let said = message(&[("a.dcm", &set.file())]);
        let named = said.contains("SegmentedGreenPaletteColorLookupTableData (0028,1222)");
        assert!(named && said.contains(part), "{part}: {said}");
        assert!(
            said.contains("segments of 16 bits that make 4 colors"),
            "{said}"
        );
    }
}

#[test]
fn colors_that_are_not_read_are_named() {
    for (photometric, part) in [
        ("HSV", "HSV with 3 samples"),
        ("YBR_PARTIAL_422", "YBR_PARTIAL_422"),
    ] {
        let mut set = color_image(4, 2, photometric, 0);
        set.put(PIXELS, b"OB", &[0; 24]);
        assert!(message(&[("a.dcm", &set.file())]).contains(part));
    }
    // Fewer bytes than three numbers per pixel.
    let mut set = color_image(4, 2, "RGB", 0);
    set.put(PIXELS, b"OB", &[0; 22]);
    assert!(message(&[("a.dcm", &set.file())]).contains("cut off"));
    let mut set = color_image(3, 2, "YBR_FULL_422", 0);
    set.put(PIXELS, b"OB", &[0; 12]);
    assert!(message(&[("a.dcm", &set.file())]).contains("an even number"));
    // The header of a frame of 12 bits with DCT (SOF1).
    let twelve = [0xFF, 0xD8, 0xFF, 0xC1, 0, 11, 12, 0, 2, 0, 4, 1, 1, 0x11, 0];
    let jpeg = packed("1.2.840.10008.1.2.4.51", &image(4, 2, &[]), &twelve);
    let said = message(&[("a.dcm", &jpeg)]);
    assert!(
        said.contains("lossy JPEG of 12 bits") && said.contains("dcmdjpeg"),
        "{said}"
    );
}

/// Frames of colors are there as they are stored and in order, beside the samples that stay.
#[test]
fn colors_take_no_more_memory_than_they_may() {
    let mut set = color_image(4, 2, "RGB", 0);
    set.put(PIXELS, b"OB", &PIXELS_RGB.concat());
    let plain = MemoryFiles::from([("a.dcm".to_owned(), set.file())]);
    let mut encoder = flate2::write::DeflateEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all(&set.explicit()).unwrap();
    let deflated = file_of("1.2.840.10008.1.2.1.99", &encoder.finish().unwrap());
    let deflated = MemoryFiles::from([("a.dcm".to_owned(), deflated)]);
    let needed = 8 + 8 * 2 * 3;
    for files in [plain, deflated] {
        let read = |bytes| {
            let control = Control::new().with_memory(bytes);
            read_file_under("a.dcm", &files, &ReadOptions::default(), &control)
        };
        let error = read(needed - 1).unwrap_err();
        assert_eq!(error.remedy(), Some(Remedy::Memory), "{error}");
        read(needed).unwrap();
    }
}

/// A CSA header with text values, in version 1 or 2.
fn csa(version: u8, tags: &[(&str, &[&str])]) -> Vec<u8> {
    let mut out = Vec::new();
    let number = |out: &mut Vec<u8>, n: usize| out.extend((n as u32).to_le_bytes());
    if version == 2 {
        out.extend(b"SV10\x04\x03\x02\x01");
    }
    number(&mut out, tags.len());
    number(&mut out, 77);
    // As scanners do: six items whatever the number of values.
    let items = 6;
    for (name, values) in tags {
        let mut padded = name.as_bytes().to_vec();
        padded.resize(64, 0);
        out.extend(padded);
        number(&mut out, values.len());
        out.extend(b"FD\0\0");
        number(&mut out, 4);
        number(&mut out, items);
        number(&mut out, 77);
        for item in 0..items {
            let mut text = values
                .get(item)
                .map_or(Vec::new(), |v| v.as_bytes().to_vec());
            if !text.is_empty() {
                text.push(0);
            }
            let length = text.len();
            match version {
                2 => [0, length, 77, length]
                    .iter()
                    .for_each(|n| number(&mut out, *n)),
                _ => [length + items, 0, 77, 0]
                    .iter()
                    .for_each(|n| number(&mut out, *n)),
            }
            text.resize(length.next_multiple_of(4), 0);
            out.extend(text);
        }
    }
    out
}

/// Five slices of 2×2 in 3×3 tiles; sample (x, y) of slice k is 100·k + 10·y + x.
fn mosaic() -> Set {
    let at = |i: u16| {
        let (x, y) = (i % 6, i / 6);
        let k = y / 2 * 3 + x / 2;
        if k < 5 {
            100 * k + 10 * (y % 2) + x % 2
        } else {
            0
        }
    };
    let mut set = image(6, 6, &(0..36).map(at).collect::<Vec<u16>>());
    set.text(IMAGE_TYPE, b"CS", "ORIGINAL\\PRIMARY\\M\\ND\\MOSAIC")
        .text(SPACING, b"DS", "2\\3")
        .text(POSITION, b"DS", "-9\\-6\\5")
        .text(BETWEEN_SLICES, b"DS", "4")
        .text((0x18, 0x50), b"DS", "3.5")
        .shorts((0x18, 0x1310), b"US", &[2, 0, 0, 2]);
    set
}

#[test]
fn mosaics_are_taken_apart() {
    let slices: Vec<u16> = (0..5)
        .flat_map(|k| [0, 1, 10, 11].map(|sample| 100 * k + sample))
        .collect();
    // nibabel's MosaicWrapper: the position moves by half of 6 − 2 pixels.
    let upward = affine(
        [[-3.0, 0.0, 0.0], [0.0, -2.0, 0.0], [0.0, 0.0, 4.0]],
        [3.0, 2.0, 5.0],
    );
    for version in [1, 2] {
        for (normal, reversed) in [(["0.0", "0.0", "1.0"], false), (["0", "0", "-1"], true)] {
            let tags: [(&str, &[&str]); 3] = [
                ("EchoLinePosition", &["2"]),
                ("NumberOfImagesInMosaic", &["5"]),
                ("SliceNormalVector", &normal),
            ];
            let mut set = mosaic();
            set.put((0x29, 0x1010), b"OB", &csa(version, &tags));
            let loaded = one(&set).unwrap();
            assert_eq!(loaded.volume.grid().dims(), [2, 2, 5]);
            let mut expected = slices.clone();
            let mut place = upward;
            if reversed {
                // Downward from the first tile: the last one is the lowest.
                expected = slices.chunks(4).rev().flatten().copied().collect();
                place.translation.z = 5.0 - 16.0;
            }
            assert_eq!(samples(&loaded), expected, "version {version}");
            assert_affine(loaded.volume.grid().world_from_voxel(), place, 1e-12);
        }
    }
    // The number alone, from the other private element.
    let mut set = mosaic();
    set.shorts((0x19, 0x100A), b"US", &[5]);
    assert_eq!(samples(&one(&set).unwrap()), slices);
}

#[test]
fn what_only_says_mosaic_is_none() {
    // Larger than what was acquired, but of how many slices?
    let refused = message(&[("a.dcm", &mosaic().file())]);
    assert!(refused.contains("NumberOfImagesInMosaic"), "{refused}");
    // As large as what was acquired: one slice, with a note.
    let mut set = mosaic();
    set.shorts((0x18, 0x1310), b"US", &[6, 0, 0, 6]);
    let loaded = one(&set).unwrap();
    assert_eq!(loaded.volume.grid().dims(), [6, 6, 1]);
    assert!(loaded.notes.iter().any(|note| note.contains("MOSAIC")));
    // Frames with places of their own are slices whatever the image type says.
    let mut set = image(6, 3, &(0..36).collect::<Vec<u16>>());
    let frame = |z: u16| {
        let mut place = Set::default();
        place.text(POSITION, b"DS", &format!("0\\0\\{z}"));
        let mut groups = Set::default();
        groups.sequence((0x20, 0x9113), &[place]);
        groups
    };
    set.text(IMAGE_TYPE, b"CS", "ORIGINAL\\PRIMARY\\M\\ND\\MOSAIC")
        .text(FRAMES, b"IS", "2")
        .shorts((0x19, 0x100A), b"US", &[4])
        .sequence(PER_FRAME, &[frame(0), frame(2)]);
    assert_eq!(one(&set).unwrap().volume.grid().dims(), [6, 3, 2]);
    // Tiles that do not fill the picture.
    let mut set = mosaic();
    set.shorts((0x19, 0x100A), b"US", &[17]);
    assert!(message(&[("a.dcm", &set.file())]).contains("5×5 tiles"));
}

/// Frames of 2×1 with samples 10·k, 10·k + 1.
fn nuclear(kind: &str, frames: u16) -> Set {
    let all: Vec<u16> = (0..frames).flat_map(|k| [10 * k, 10 * k + 1]).collect();
    let mut place = Set::default();
    place
        .text(POSITION, b"DS", "-100\\-90\\50")
        .text(ORIENTATION, b"DS", "1\\0\\0\\0\\1\\0");
    let mut set = image(2, 1, &all);
    set.0
        .retain(|element| element.0 != 0x20 || element.1 == 0x0E);
    set.text(
        IMAGE_TYPE,
        b"CS",
        &format!("ORIGINAL\\PRIMARY\\{kind}\\EMISSION"),
    )
    .text((8, 0x60), b"CS", "NM")
    .text(FRAMES, b"IS", &frames.to_string())
    .text(BETWEEN_SLICES, b"DS", "4")
    .sequence((0x54, 0x22), &[place]);
    set
}

#[test]
fn vectors_of_nuclear_medicine_say_slice_and_group() {
    let time = |set: &Set, time_index| {
        let options = ReadOptions {
            time_index,
            ..ReadOptions::default()
        };
        read_with(&[("a.dcm", &set.file())], &options)
    };
    let place = affine(
        [[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 4.0]],
        [100.0, 90.0, 50.0],
    );
    let mut set = nuclear("RECON GATED TOMO", 6);
    set.shorts((0x54, 0x70), b"US", &[1, 1, 1, 2, 2, 2]).shorts(
        (0x54, 0x80),
        b"US",
        &[1, 2, 3, 3, 2, 1],
    );
    let first = time(&set, 0).unwrap();
    assert_eq!(first.volume.grid().dims(), [2, 1, 3]);
    assert_eq!(first.volume.metadata().time_points, 2);
    assert_affine(first.volume.grid().world_from_voxel(), place, 1e-12);
    assert_eq!(samples(&first), [0, 1, 10, 11, 20, 21]);
    assert_eq!(samples(&time(&set, 1).unwrap()), [50, 51, 40, 41, 30, 31]);

    // Two energy windows of two phases; the slices change slowest.
    let mut set = nuclear("RECON TOMO", 8);
    set.shorts((0x54, 0x10), b"US", &[1, 1, 2, 2, 1, 1, 2, 2])
        .shorts((0x54, 0x30), b"US", &[1, 2, 1, 2, 1, 2, 1, 2])
        .shorts((0x54, 0x80), b"US", &[1, 1, 1, 1, 2, 2, 2, 2]);
    let third = time(&set, 2).unwrap();
    assert_eq!(third.volume.metadata().time_points, 4);
    assert_eq!(samples(&third), [20, 21, 60, 61]);
    assert!(
        third
            .notes
            .iter()
            .any(|note| note.contains("energy window and phase"))
    );

    // Without SliceVector, slices follow one another within their group.
    let mut set = nuclear("RECON TOMO", 4);
    set.shorts((0x54, 0x10), b"US", &[1, 1, 2, 2]);
    assert_eq!(samples(&time(&set, 1).unwrap()), [20, 21, 30, 31]);

    set.shorts((0x54, 0x80), b"US", &[1, 2, 3]);
    assert!(
        time(&set, 0)
            .unwrap_err()
            .to_string()
            .contains("SliceVector (0054,0080)")
    );
    for kind in ["TOMO", "GATED TOMO", "DYNAMIC", "STATIC", "WHOLE BODY"] {
        let refused = message(&[("a.dcm", &nuclear(kind, 4).file())]);
        assert!(refused.contains("no slices"), "{kind}: {refused}");
    }
}

/// Two places of 1×1 images; image `t` at place `k` has the value 10·t + k.
fn series(volumes: usize, describe: impl Fn(usize, usize, &mut Set)) -> Vec<Set> {
    let mut sets = Vec::new();
    for t in 0..volumes {
        for k in 0..2 {
            let mut set = image(1, 1, &[(10 * t + k) as u16]);
            set.text(POSITION, b"DS", &format!("0\\0\\{}", 2 * k));
            describe(t, k, &mut set);
            sets.push(set);
        }
    }
    // The order of the files says nothing.
    sets.reverse();
    sets
}

fn assert_volumes(sets: &[Set], order: &[u16], said: &str) {
    for (time, t) in order.iter().enumerate() {
        let loaded = folder(sets, time).unwrap();
        assert_eq!(samples(&loaded), [10 * t, 10 * t + 1], "{said} {time}");
        assert_eq!(loaded.volume.metadata().time_points, order.len());
        assert!(
            loaded.notes.iter().any(|note| note.contains(said)),
            "{:?}",
            loaded.notes
        );
    }
}

#[test]
fn volumes_are_told_apart_by_what_is_there() {
    let number = |n: usize| n.to_string();
    let blocks = series(3, |t, k, set| {
        set.text(INSTANCE, b"IS", &number(2 * t + k + 1));
    });
    assert_volumes(&blocks, &[0, 1, 2], "instance number (1, 3, 5)");
    let in_turns = series(12, |t, k, set| {
        set.text(INSTANCE, b"IS", &number(12 * k + t));
    });
    assert_volumes(&in_turns, &(0..12).collect::<Vec<_>>(), "instance number");
    let times = series(2, |t, k, set| {
        set.text((8, 0x33), b"TM", &format!("1200{:02}.5", 59 - 30 * t + k))
            .text(INSTANCE, b"IS", &number(2 * t + k));
    });
    assert_volumes(&times, &[1, 0], "content time");
}

#[test]
fn diffusion_directions_come_as_they_were_acquired() {
    // b = 0 has no direction; the first gradient is along x, and 700 comes after 1000.
    let gradients = [
        (0.0, None),
        (1000.0, Some([1.0, 0.0, 0.0])),
        (700.0, Some([1.0, 0.0, 0.0])),
        (1000.0, Some([0.0, 0.6, -0.8])),
    ];
    let sets = series(4, |t, k, set| {
        let (b, direction) = gradients[t];
        set.doubles((0x18, 0x9087), &[b])
            .text(INSTANCE, b"IS", &(4 * k + t).to_string());
        if let Some(direction) = direction {
            set.doubles((0x18, 0x9089), &direction);
        }
    });
    assert_volumes(
        &sets,
        &[0, 1, 2, 3],
        "b-value (s/mm²) and diffusion gradient direction",
    );
    let note = folder(&sets, 0).unwrap().notes.join("\n");
    assert!(
        note.contains("0 · none, 1000 · 1 0 0, 700 · 1 0 0, 1000 · 0 0.6 -0.8"),
        "{note}"
    );
}

#[test]
fn two_attributes_together_tell_volumes_apart() {
    let sets = series(4, |t, k, set| {
        set.text((0x18, 0x81), b"DS", ["5", "2"][t % 2])
            .text(
                IMAGE_TYPE,
                b"CS",
                ["ORIGINAL\\PRIMARY\\P", "ORIGINAL\\PRIMARY\\M"][t / 2],
            )
            .text(INSTANCE, b"IS", &(4 * k + t).to_string());
    });
    assert_volumes(&sets, &[3, 1, 2, 0], "echo time (ms) and image type");
}

#[test]
fn frames_follow_their_dimension_index() {
    // Echo is the first dimension, the place the second, the component the third.
    let pointer = |group, element| {
        let mut item = Set::default();
        item.shorts((0x20, 0x9165), b"AT", &[group, element]);
        item
    };
    let frame = |echo: u32, place: u32, component: u32| {
        let mut content = Set::default();
        let values: Vec<u8> = [echo, place, component]
            .iter()
            .flat_map(|v| v.to_le_bytes())
            .collect();
        content.put((0x20, 0x9157), b"UL", &values);
        let mut position = Set::default();
        position.text(POSITION, b"DS", &format!("0\\0\\{}", 3 * place));
        let mut groups = Set::default();
        groups
            .sequence((0x20, 0x9111), &[content])
            .sequence((0x20, 0x9113), &[position]);
        groups
    };
    let mut groups = Vec::new();
    for place in [2, 1] {
        for component in [2, 1] {
            for echo in [1, 2] {
                groups.push(frame(echo, place, component));
            }
        }
    }
    let mut set = image(1, 1, &[0, 1, 2, 3, 4, 5, 6, 7]);
    set.text(FRAMES, b"IS", "8")
        .sequence(PER_FRAME, &groups)
        .sequence(
            (0x20, 0x9222),
            &[
                pointer(0x18, 0x9082),
                pointer(0x20, 0x9057),
                pointer(8, 0x9208),
            ],
        );
    for (time_index, expected) in [[6, 2], [4, 0], [7, 3], [5, 1]].iter().enumerate() {
        let options = ReadOptions {
            time_index,
            ..ReadOptions::default()
        };
        let loaded = read_with(&[("a.dcm", &set.file())], &options).unwrap();
        assert_eq!(samples(&loaded), expected);
        assert!(
            loaded.notes[0].contains("dimension index (1 1, 1 2, 2 1, 2 2)"),
            "{:?}",
            loaded.notes
        );
    }
}

#[test]
fn frames_of_a_tomograph_are_as_far_apart_as_they_are_thick() {
    let mut set = image(2, 1, &[0, 1, 2, 3, 4, 5]);
    set.text((8, 0x60), b"CS", "CT")
        .text(FRAMES, b"IS", "3")
        .text((0x18, 0x50), b"DS", "0.3");
    let loaded = one(&set).unwrap();
    assert_eq!(loaded.volume.grid().dims(), [2, 1, 3]);
    assert_eq!(loaded.volume.grid().spacing_mm().z, 0.3);
    assert!(
        loaded.notes[0].contains("slice thickness, 0.3 mm"),
        "{:?}",
        loaded.notes
    );
    // Frames that follow in time are no slices.
    set.shorts((0x28, 9), b"AT", &[0x18, 0x1063]);
    assert!(message(&[("a.dcm", &set.file())]).contains("moments of a film"));
}

#[test]
fn elements_are_read_as_they_are_written() {
    let set = image(2, 1, &[7, 8]);
    for (syntax, elements) in [
        ("1.2.840.10008.1.2.1", set.implicit()),
        ("1.2.840.10008.1.2", set.explicit()),
    ] {
        let loaded = read(&[("a.dcm", &file_of(syntax, &elements))]).unwrap();
        assert_eq!(samples(&loaded), [7, 8]);
        assert!(
            loaded
                .notes
                .iter()
                .any(|note| note.contains("value representations"))
        );
    }
    for (syntax, elements) in [
        ("1.2.840.10008.1.2", set.implicit()),
        ("1.2.840.10008.1.2.1", set.explicit()),
    ] {
        let loaded = read(&[("a.dcm", &file_of(syntax, &elements))]).unwrap();
        assert!(
            !loaded
                .notes
                .iter()
                .any(|note| note.contains("value representations"))
        );
    }
}

#[test]
fn the_missing_part_of_the_place_is_named() {
    for (tag, name) in [
        (POSITION, "ImagePositionPatient (0020,0032)"),
        (ORIENTATION, "ImageOrientationPatient (0020,0037)"),
    ] {
        let mut set = image(2, 1, &[7, 8]);
        set.0.retain(|element| (element.0, element.1) != tag);
        let found = message(&[("a.dcm", &set.file())]);
        assert!(found.contains(&format!("{name} is missing")), "{found}");
    }
}

/// Three slices in folders as on a CD, and the directory that names them in capitals.
fn disk() -> MemoryFiles {
    let mut files = MemoryFiles::new();
    let mut records = Vec::new();
    for k in 0..3u16 {
        let mut set = image(1, 1, &[k]);
        set.text(POSITION, b"DS", &format!("0\\0\\{}", 2 * k));
        files.insert(format!("images/s1/im{k}"), set.file());
        let mut record = Set::default();
        record.text((4, 0x1430), b"CS", "IMAGE").text(
            (4, 0x1500),
            b"CS",
            &format!("IMAGES\\S1\\IM{k}"),
        );
        records.push(record);
    }
    let mut directory = Set::default();
    directory.sequence((4, 0x1220), &records);
    files.insert("DICOMDIR".into(), directory.file());
    files.insert("autorun.inf".into(), b"[autorun]".to_vec());
    files
}

#[test]
fn folders_of_a_disk_are_walked() {
    let mut files = disk();
    let options = ReadOptions::default();
    let loaded = read_folder("disk", &files, &options).unwrap();
    assert_eq!(samples(&loaded), [0, 1, 2]);
    assert!(
        loaded.notes[0].contains("images/s1/im0"),
        "{:?}",
        loaded.notes
    );
    assert_eq!(
        strahl_volume::read::dicom::list_series(&files)
            .unwrap()
            .len(),
        1
    );
    // The directory says which files count.
    let mut other = image(1, 1, &[9]);
    other.text((0x20, 0x0E), b"UI", "1.2.4");
    files.insert("images/s2/im0".into(), other.file());
    let directory =
        |files: &MemoryFiles| strahl_volume::read::read_file("DICOMDIR", files, &options);
    assert_eq!(samples(&directory(&files).unwrap()), [0, 1, 2]);
    let several = read_folder("disk", &files, &options)
        .unwrap_err()
        .to_string();
    assert!(several.contains("there are 2 series"), "{several}");
    files.remove("images/s1/im2");
    let loaded = directory(&files).unwrap();
    assert_eq!(samples(&loaded), [0, 1]);
    assert!(
        loaded
            .notes
            .iter()
            .any(|note| note.contains("1 of the 3 files"))
    );
    files.retain(|name, _| !name.contains('/'));
    let missing = directory(&files).unwrap_err().to_string();
    assert!(missing.contains("`IMAGES/S1/IM0` and 2 more"), "{missing}");
    let nothing = read_folder("disk", &files, &options)
        .unwrap_err()
        .to_string();
    assert!(
        nothing.contains("no file here is a DICOM image"),
        "{nothing}"
    );
    // Folders without images are named.
    let files = MemoryFiles::from([("a/x.txt".to_owned(), vec![1]), ("b/y".to_owned(), vec![2])]);
    let folders = read_folder("disk", &files, &options)
        .unwrap_err()
        .to_string();
    assert!(folders.contains("name one of them: a, b"), "{folders}");
}

#[test]
fn packed_files_make_a_series() {
    let files: MemoryFiles = (0..3u16)
        .map(|k| {
            let mut set = image(1, 1, &[k]);
            set.text(POSITION, b"DS", &format!("0\\0\\{k}"));
            (format!("{k}.dcm.gz"), gzip(&set.file()))
        })
        .collect();
    let options = ReadOptions::default();
    assert_eq!(
        samples(&read_folder("series", &files, &options).unwrap()),
        [0, 1, 2]
    );
    let loaded = strahl_volume::read::read_file("1.dcm.gz", &files, &options).unwrap();
    assert_eq!(samples(&loaded), [0, 1, 2]);
    assert!(
        loaded.notes[0].contains("1.dcm.gz is one of 3 files"),
        "{:?}",
        loaded.notes
    );
}

/// A segmentation of 3×3 samples: segment 1 at z = 0 and 6, segment 2 at z = 2; bits follow one another.
fn segmentation() -> Set {
    let frame = |segment: u16, z: u16| {
        let mut number = Set::default();
        number.shorts((0x62, 0x0B), b"US", &[segment]);
        let mut place = Set::default();
        place.text(POSITION, b"DS", &format!("-5\\-6\\{z}"));
        let mut groups = Set::default();
        groups
            .sequence((0x62, 0x0A), &[number])
            .sequence((0x20, 0x9113), &[place]);
        groups
    };
    let segment = |number: u16, name: &str| {
        let mut segment = Set::default();
        let mut category = Set::default();
        category.text((8, 0x104), b"LO", "Tissue");
        segment
            .sequence((0x62, 3), &[category])
            .shorts((0x62, 4), b"US", &[number])
            .text((0x62, 5), b"LO", name)
            .shorts((0x62, 0x0D), b"US", &[65535, 32896, 32896]);
        segment
    };
    let mut axes = Set::default();
    axes.text(ORIENTATION, b"DS", "1\\0\\0\\0\\1\\0");
    let mut measures = Set::default();
    measures
        .text(SPACING, b"DS", "0.5\\0.25")
        .text(BETWEEN_SLICES, b"DS", "2");
    let mut shared = Set::default();
    shared
        .sequence((0x20, 0x9116), &[axes])
        .sequence((0x28, 0x9110), &[measures]);
    let mut set = image(3, 3, &[]);
    set.0
        .retain(|element| element.0 != 0x20 || element.1 == 0x0E);
    // Frames of 9 bits: 100000001, 000010000, 010000010, lowest bit first.
    set.put(
        PIXELS,
        b"OB",
        &[0b0000_0001, 0b0010_0001, 0b0000_1000, 0b0000_0010],
    )
    .text((8, 0x16), b"UI", "1.2.840.10008.5.1.4.1.1.66.4")
    .text((8, 0x60), b"CS", "SEG")
    .shorts((0x28, 0x100), b"US", &[1])
    .shorts((0x28, 0x101), b"US", &[1])
    .shorts((0x28, 0x102), b"US", &[0])
    .text(FRAMES, b"IS", "3")
    .sequence((0x62, 2), &[segment(1, "liver"), segment(2, "tumour")])
    .sequence((0x5200, 0x9229), &[shared])
    .sequence(PER_FRAME, &[frame(1, 0), frame(2, 2), frame(1, 6)]);
    set
}

#[test]
fn segmentations_become_labels() {
    let set = segmentation();
    for loaded in [
        one(&set).unwrap(),
        folder(std::slice::from_ref(&set), 0).unwrap(),
    ] {
        assert_eq!(loaded.volume.grid().dims(), [3, 3, 4]);
        let place = affine(
            [[-0.25, 0.0, 0.0], [0.0, -0.5, 0.0], [0.0, 0.0, 2.0]],
            [5.0, 6.0, 0.0],
        );
        assert_affine(loaded.volume.grid().world_from_voxel(), place, 1e-12);
        let mut expected = vec![0; 36];
        for (at, label) in [(0, 1), (8, 1), (9 + 4, 2), (27 + 1, 1), (27 + 7, 1)] {
            expected[at] = label;
        }
        assert_eq!(*loaded.volume.samples(), Samples::U8(expected));
        let labels = loaded.labels.unwrap();
        assert_eq!((labels[1].id, labels[1].name.as_str()), (2, "tumour"));
        assert_eq!(labels[1].group.as_deref(), Some("Tissue"));
        let color = labels[0].color.unwrap();
        assert!(color.iter().all(|c| *c > 0.99), "{color:?}");
    }
    // One segment over another.
    let mut set = segmentation();
    let groups = |z: u16, segment: u16| {
        let mut number = Set::default();
        number.shorts((0x62, 0x0B), b"US", &[segment]);
        let mut place = Set::default();
        place.text(POSITION, b"DS", &format!("0\\0\\{z}"));
        let mut groups = Set::default();
        groups
            .sequence((0x62, 0x0A), &[number])
            .sequence((0x20, 0x9113), &[place]);
        groups
    };
    set.sequence(PER_FRAME, &[groups(0, 1), groups(0, 2), groups(0, 3)])
        .put(PIXELS, b"OB", &[0xFF; 4]);
    let loaded = one(&set).unwrap();
    assert_eq!(*loaded.volume.samples(), Samples::U8(vec![3; 9]));
    assert!(loaded.notes[0].contains("18 voxels"), "{:?}", loaded.notes);
    // A place that lies far off would be empty memory.
    set.sequence(PER_FRAME, &[groups(0, 1), groups(60_000, 2), groups(2, 3)]);
    assert!(message(&[("a.dcm", &set.file())]).contains("slices"));
    set.put(PIXELS, b"OB", &[0xFF; 2]);
    assert!(message(&[("a.dcm", &set.file())]).contains("cut off"));
}

/// A structure set with these structures: number, name, type, color, and contours by their corners in mm.
type Drawn<'a> = (&'a str, &'a str, &'a str, &'a str, &'a [(&'a str, &'a str)]);

fn structure_set(series: &str, structures: &[Drawn]) -> Set {
    let (mut rois, mut drawings, mut observations) = (Vec::new(), Vec::new(), Vec::new());
    for (number, name, kind, color, contours) in structures {
        let mut roi = Set::default();
        roi.text((0x3006, 0x22), b"IS", number)
            .text((0x3006, 0x26), b"LO", name);
        let contours: Vec<Set> = contours
            .iter()
            .map(|(kind, corners)| {
                let mut contour = Set::default();
                contour
                    .text((0x3006, 0x42), b"CS", kind)
                    .text((0x3006, 0x50), b"DS", corners);
                contour
            })
            .collect();
        let mut drawing = Set::default();
        drawing
            .text((0x3006, 0x2A), b"IS", color)
            .sequence((0x3006, 0x40), &contours)
            .text((0x3006, 0x84), b"IS", number);
        let mut observation = Set::default();
        observation
            .text((0x3006, 0x84), b"IS", number)
            .text((0x3006, 0xA4), b"CS", kind);
        rois.push(roi);
        drawings.push(drawing);
        observations.push(observation);
    }
    let nested = |tag: (u16, u16), inner: &Set| {
        let mut outer = Set::default();
        outer.sequence(tag, std::slice::from_ref(inner));
        outer
    };
    let mut of_series = Set::default();
    of_series.text((0x20, 0x0E), b"UI", series);
    let study = nested((0x3006, 0x14), &of_series);
    let frame = nested((0x3006, 0x12), &study);
    let mut set = nested((0x3006, 0x10), &frame);
    set.text((8, 5), b"CS", "ISO_IR 192")
        .text((8, 0x16), b"UI", "1.2.840.10008.5.1.4.1.1.481.3")
        .text((8, 0x60), b"CS", "RTSTRUCT")
        .text((0x3006, 2), b"SH", "plan")
        .sequence((0x3006, 0x20), &rois)
        .sequence((0x3006, 0x39), &drawings)
        .sequence((0x3006, 0x80), &observations);
    set
}

/// Corners of a rectangle in a plane.
fn rectangle(x: [f64; 2], y: [f64; 2], z: f64) -> String {
    let corners = [[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]];
    corners.map(|[x, y]| format!("{x}\\{y}\\{z}")).join("\\")
}

#[test]
fn contours_fill_the_grid_of_their_images() {
    // Four slices of 6×5 pixels, 2 mm wide, 1 mm high, 3 mm apart, from (10, 20, 30) in LPS.
    let slices = (0..4).map(|k: u16| {
        let mut set = image(6, 5, &[k; 30]);
        set.text(POSITION, b"DS", &format!("10\\20\\{}", 30 + 3 * k))
            .text(SPACING, b"DS", "1\\2");
        set
    });
    // A body on all slices; a liver with a hole on the second, and on the third.
    let body: Vec<String> = (0..4)
        .map(|k| rectangle([9.0, 21.0], [20.5, 24.5], f64::from(30 + 3 * k)))
        .collect();
    let body: Vec<(&str, &str)> = body.iter().map(|c| ("CLOSED_PLANAR", c.as_str())).collect();
    let [outer, hole, other] = [
        rectangle([11.0, 19.0], [20.5, 23.5], 33.0),
        rectangle([13.0, 15.0], [21.5, 22.5], 33.0),
        rectangle([13.0, 15.0], [21.5, 22.5], 36.0),
    ];
    let liver = [
        ("CLOSED_PLANAR", outer.as_str()),
        ("CLOSED_PLANAR", hole.as_str()),
        ("CLOSED_PLANAR", other.as_str()),
        ("POINT", "13\\21\\33"),
    ];
    let structures = [
        ("7", "Ле́вая", "ORGAN", "255\\0\\51", &liver[..]),
        ("3", "Body", "EXTERNAL", "0\\255\\0", &body),
    ];
    let set = structure_set("1.2.3", &structures);
    let mut files: MemoryFiles = slices
        .enumerate()
        .map(|(i, set)| (format!("{i}.dcm"), set.file()))
        .collect();
    files.insert("rs.dcm".into(), set.file());
    let loaded = read_file("rs.dcm", &files, &ReadOptions::default()).unwrap();
    assert_eq!(loaded.volume.grid().dims(), [6, 5, 4]);
    let place = affine(
        [[-2.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 3.0]],
        [-10.0, -20.0, 30.0],
    );
    assert_affine(loaded.volume.grid().world_from_voxel(), place, 1e-12);
    #[rustfmt::skip]
    let (plain, second, third) = (
        [
            0, 0, 0, 0, 0, 0,
            3, 3, 3, 3, 3, 3,
            3, 3, 3, 3, 3, 3,
            3, 3, 3, 3, 3, 3,
            3, 3, 3, 3, 3, 3,
        ],
        [
            0, 0, 0, 0, 0, 0,
            3, 7, 7, 7, 7, 3,
            3, 7, 3, 7, 7, 3,
            3, 7, 7, 7, 7, 3,
            3, 3, 3, 3, 3, 3,
        ],
        [
            0, 0, 0, 0, 0, 0,
            3, 3, 3, 3, 3, 3,
            3, 3, 7, 3, 3, 3,
            3, 3, 3, 3, 3, 3,
            3, 3, 3, 3, 3, 3,
        ],
    );
    let expected = [plain, second, third, plain].concat();
    assert_eq!(*loaded.volume.samples(), Samples::U8(expected));
    let labels = loaded.labels.unwrap();
    assert_eq!((labels[0].id, labels[0].name.as_str()), (7, "Ле́вая"));
    assert_eq!(labels[0].color, Some([1.0, 0.0, 0.2]));
    assert_eq!(labels[1].group.as_deref(), Some("EXTERNAL"));
    let said = loaded.notes.join("\n");
    for part in [
        "4 slices of the series 1.2.3",
        "12 times, a voxel is in two",
        "1 contours that",
    ] {
        assert!(said.contains(part), "{said}");
    }

    // Without images: the user gives a grid.
    let alone = [("rs.dcm", &set.file()[..])];
    let refused = message(&alone);
    assert!(
        refused.contains("put the series 1.2.3 beside it"),
        "{refused}"
    );
    let options = ReadOptions {
        spacing_mm: Some([1.0, 1.0, 3.0]),
        ..ReadOptions::default()
    };
    let loaded = read_with(&alone, &options).unwrap();
    assert_eq!(loaded.volume.grid().dims(), [13, 5, 4]);
    let volume = |id: f64| {
        let samples = loaded.volume.samples();
        (0..samples.len()).filter(|i| samples.get(*i) == id).count()
    };
    // 8×3 mm less a hole of 2×1, and 2×1: of voxels of 1×1 mm.
    assert_eq!(volume(7.0), 8 * 3 - 2 + 2);
    let options = ReadOptions {
        spacing_mm: Some([1e-4; 3]),
        ..ReadOptions::default()
    };
    let error = read_with(&alone, &options).unwrap_err().to_string();
    assert!(error.contains("a larger one"), "{error}");
}

#[test]
fn contours_that_are_in_no_slice_are_refused() {
    let spacing = ReadOptions {
        spacing_mm: Some([1.0; 3]),
        ..ReadOptions::default()
    };
    for (kind, corners, part) in [
        (
            "CLOSED_PLANAR",
            "0\\0\\0\\9\\0\\0\\9\\9\\4",
            "lies across 4.0 slices",
        ),
        (
            "CLOSED_PLANAR",
            "0\\0\\0\\9\\0",
            "of 5 numbers; allowed: three for each",
        ),
        ("POINT", "0\\0\\0", "ContourData (3006,0050) is missing"),
        ("CLOSED_PLANAR", "0\\0\\x", "finite decimal numbers"),
    ] {
        let set = structure_set("1.2.3", &[("1", "a", "", "", &[(kind, corners)])]);
        let error = read_with(&[("a.dcm", &set.file())], &spacing).unwrap_err();
        assert!(error.to_string().contains(part), "{error}");
    }
    let component = ReadOptions {
        component: Some(1),
        ..spacing.clone()
    };
    let square = rectangle([0.0, 2.0], [0.0, 2.0], 0.0);
    let contours = [("CLOSED_PLANAR", square.as_str())];
    let set = structure_set("1.2.3", &[("1", "a", "", "", &contours)]);
    let error = read_with(&[("a.dcm", &set.file())], &component).unwrap_err();
    assert!(error.to_string().contains("one number"), "{error}");
    // More structures than there are ids.
    let many = vec![("1", "a", "", "", &contours[..]); 65536];
    let set = structure_set("1.2.3", &many);
    let error = read_with(&[("a.dcm", &set.file())], &spacing).unwrap_err();
    assert!(error.to_string().contains("of 65536 structures"), "{error}");
    // As many structures on the same voxels as no set has.
    let many = vec![("1", "a", "", "", &contours[..]); 200];
    let set = structure_set("1.2.3", &many);
    let error = read_with(&[("a.dcm", &set.file())], &spacing).unwrap_err();
    assert!(
        error.to_string().contains("voxels in all structures"),
        "{error}"
    );
    // Numbers that are no ids are replaced.
    let structures = [("0", "a", "", "", &contours[..]), ("-4", "b", "", "", &[])];
    let set = structure_set("1.2.3", &structures);
    let loaded = read_with(&[("a.dcm", &set.file())], &spacing).unwrap();
    let ids: Vec<u32> = loaded
        .labels
        .unwrap()
        .iter()
        .map(|label| label.id)
        .collect();
    assert_eq!(ids, [1, 2]);
}

/// A box of a JP2 file.
fn jp2_box(kind: &[u8; 4], inside: &[u8]) -> Vec<u8> {
    let length = (8 + inside.len()) as u32;
    [&length.to_be_bytes(), &kind[..], inside].concat()
}

/// The beginning of a JPEG 2000 codestream for one component of 8 bits in tiles of `tile`².
fn jpeg_2000(columns: u32, rows: u32, tile: u32) -> Vec<u8> {
    let words = [columns, rows, 0, 0, tile, tile, 0, 0];
    let words = words.iter().flat_map(|word| word.to_be_bytes());
    let head = [0xFF, 0x4F, 0xFF, 0x51, 0, 41, 0, 0];
    head.into_iter()
        .chain(words)
        .chain([0, 1, 7, 1, 1])
        .collect()
}

#[test]
fn the_size_that_jpeg_2000_decodes_is_the_one_that_is_checked() {
    let file = |packed: &[u8]| {
        let item = |bytes: &[u8]| {
            let length = bytes.len() as u32;
            [&[0xFE, 0xFF, 0, 0xE0][..], &length.to_le_bytes(), bytes].concat()
        };
        let mut set = image(8, 8, &[]);
        set.0.retain(|element| (element.0, element.1) != PIXELS);
        set.shorts((0x28, 0x100), b"US", &[8])
            .shorts((0x28, 0x101), b"US", &[8])
            .shorts((0x28, 0x102), b"US", &[7]);
        let pixels = [
            0xE0, 0x7F, 0x10, 0, b'O', b'B', 0, 0, 0xFF, 0xFF, 0xFF, 0xFF,
        ];
        let set = [&set.explicit()[..], &pixels, &item(&[]), &item(packed)].concat();
        file_of("1.2.840.10008.1.2.4.90", &set)
    };
    let boxes = |parts: &[Vec<u8>]| {
        let first = b"\0\0\0\x0cjP  \r\n\x87\n".to_vec();
        [first, parts.concat()].concat()
    };
    let stream = jpeg_2000(1_000_000, 1_000_000, 1_000_000);
    let palette = jp2_box(b"jp2h", &jp2_box(b"pclr", &[0; 8]));
    let is_long = [&1u32.to_be_bytes()[..], b"free", &u64::MAX.to_be_bytes()].concat();
    for (packed, words) in [
        // An earlier box says the size that the elements have.
        (
            boxes(&[
                jp2_box(b"free", &jpeg_2000(8, 8, 8)),
                jp2_box(b"jp2c", &stream),
            ]),
            "1000000×1000000",
        ),
        (stream, "1000000×1000000"),
        (jpeg_2000(8, 8, 1), "cannot hold the 64 tiles"),
        (jpeg_2000(8, 8, 0), "have no pixels"),
        (
            boxes(&[palette, jp2_box(b"jp2c", &jpeg_2000(8, 8, 8))]),
            "palette",
        ),
        (boxes(&[jp2_box(b"free", &[])]), "no codestream"),
        (boxes(&[is_long]), "cut off"),
        (b"something".to_vec(), "does not begin with its size"),
    ] {
        let said = message(&[("a.dcm", &file(&packed))]);
        assert!(said.contains(words), "{said}");
    }
}

/// Two files with one identity but other values: whoever names one of them gets that one.
#[test]
fn the_file_that_is_asked_for_is_read() {
    let set = |k: u16, value: u16| {
        let mut set = image(1, 1, &[value]);
        set.text((8, 0x18), b"UI", &format!("9.{k}"))
            .text(POSITION, b"DS", &format!("0\\0\\{k}"));
        set.file()
    };
    let files = MemoryFiles::from([
        ("a.dcm".to_owned(), set(0, 10)),
        ("b.dcm".to_owned(), set(0, 20)),
        ("c.dcm".to_owned(), set(1, 30)),
    ]);
    let options = ReadOptions::default();
    for (name, expected, left_out) in [
        (
            "a.dcm",
            [10, 30],
            "b.dcm has the SOPInstanceUID of a.dcm and was left out",
        ),
        (
            "b.dcm",
            [20, 30],
            "a.dcm has the SOPInstanceUID of b.dcm and was left out",
        ),
        (
            "c.dcm",
            [10, 30],
            "b.dcm has the SOPInstanceUID of a.dcm and was left out",
        ),
    ] {
        let loaded = strahl_volume::read::read_file(name, &files, &options).unwrap();
        assert_eq!(samples(&loaded), expected, "{name}");
        assert!(
            loaded.notes.iter().any(|note| note == left_out),
            "{:?}",
            loaded.notes
        );
    }
    assert_eq!(
        samples(&read_folder("series", &files, &options).unwrap()),
        [10, 30]
    );
}
