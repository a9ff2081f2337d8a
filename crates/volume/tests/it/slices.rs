//! Sequences of pictures, and single ones.

use crate::{gzip, message, read, read_with, tiff};
use glam::DVec3;
use strahl_volume::read::{LoadedVolume, MemoryFiles, ReadOptions, read_folder};
use strahl_volume::{Error, Samples};

/// A gray PNG.
fn encode(
    width: u32,
    height: u32,
    depth: png::BitDepth,
    color: png::ColorType,
    data: &[u8],
) -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width, height);
    encoder.set_depth(depth);
    encoder.set_color(color);
    if color == png::ColorType::Indexed {
        let last = if depth == png::BitDepth::One { 1 } else { 255 };
        let blue_to_red = (0..=last).flat_map(|i| [i, 0, 255 - i]);
        encoder.set_palette(blue_to_red.collect::<Vec<u8>>());
    }
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(data).unwrap();
    writer.finish().unwrap();
    file
}

/// A gray PNG of 8 bits.
pub(crate) fn png(width: u32, height: u32, data: &[u8]) -> Vec<u8> {
    encode(
        width,
        height,
        png::BitDepth::Eight,
        png::ColorType::Grayscale,
        data,
    )
}

fn folder(files: &[(&str, Vec<u8>)]) -> Result<LoadedVolume, Error> {
    let files: MemoryFiles = files
        .iter()
        .map(|(name, bytes)| (name.to_string(), bytes.clone()))
        .collect();
    read_folder("scan", &files, &ReadOptions::default())
}

fn refused(files: &[(&str, Vec<u8>)]) -> String {
    match folder(files) {
        Ok(loaded) => panic!("read as {:?}", loaded.volume.header()),
        Err(error) => error.to_string(),
    }
}

#[test]
fn slices_lie_in_the_order_of_their_numbers() {
    let names: Vec<String> = (1..=40).map(|k| format!("slice{k}.png")).collect();
    let files: Vec<(&str, Vec<u8>)> = names
        .iter()
        .enumerate()
        .map(|(k, name)| (name.as_str(), png(2, 1, &[k as u8, 100 + k as u8])))
        .collect();
    let loaded = folder(&files).unwrap();
    assert_eq!(loaded.notes, Vec::<String>::new());
    let volume = loaded.volume;
    assert_eq!(volume.grid().dims(), [2, 1, 40]);
    let expected = (0..40).flat_map(|k| [k, 100 + k]).collect();
    assert_eq!(*volume.samples(), Samples::U8(expected));
    assert_eq!(volume.grid().orientation(), "LPS");
    assert!(!volume.metadata().has_length_unit);
}

#[test]
fn the_top_row_lies_at_y_0_and_spacing_is_what_the_user_says() {
    let slice = png(2, 2, &[1, 2, 3, 4]);
    let files = MemoryFiles::from([("a1.png".into(), slice.clone()), ("a2.png".into(), slice)]);
    let options = ReadOptions {
        spacing_mm: Some([0.5, 0.5, 2.0]),
        ..ReadOptions::default()
    };
    let volume = read_folder("scan", &files, &options).unwrap().volume;
    assert_eq!([volume.value(1, 0, 0), volume.value(0, 1, 1)], [2.0, 3.0]);
    assert_eq!(volume.grid().spacing_mm(), DVec3::new(0.5, 0.5, 2.0));
    // Right column: patient's left. Lower row: patient's back.
    let place = volume
        .grid()
        .world_from_voxel()
        .transform_point3(DVec3::ONE);
    assert_eq!(place, DVec3::new(-0.5, -0.5, 2.0));
}

#[test]
fn every_depth_keeps_its_numbers() {
    use png::BitDepth::{Four, One, Sixteen, Two};
    let grey = png::ColorType::Grayscale;
    for (depth, data, expected) in [
        (
            One,
            &[0b1010_0000, 0b0100_0000][..],
            Samples::U8(vec![1, 0, 1, 0, 1, 0]),
        ),
        (
            Two,
            &[0b1101_1000, 0b0011_0100],
            Samples::U8(vec![3, 1, 2, 0, 3, 1]),
        ),
        (
            Four,
            &[0x12, 0x30, 0xfe, 0xd0],
            Samples::U8(vec![1, 2, 3, 15, 14, 13]),
        ),
        (
            Sixteen,
            &[1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12],
            Samples::U16(vec![0x102, 0x304, 0x506, 0x708, 0x90a, 0xb0c]),
        ),
    ] {
        let loaded = read(&[("a.png", &encode(3, 2, depth, grey, data))]).unwrap();
        assert_eq!(*loaded.volume.samples(), expected);
        assert_eq!(loaded.volume.grid().dims(), [3, 2, 1]);
        assert!(loaded.notes[0].contains("one slice"));
    }
}

#[test]
fn tiff_slices_are_read_as_png_slices_are() {
    use crate::tiff::slice;
    let files = [
        ("a9.tif", slice(&[1, 2, 3, 4, 5, 6])),
        ("a10.tif", slice(&[7; 6])),
    ];
    let loaded = folder(&files).unwrap();
    let expected = [1, 2, 3, 4, 5, 6, 7, 7, 7, 7, 7, 7].to_vec();
    assert_eq!(*loaded.volume.samples(), Samples::U8(expected));
    let stack = refused(&[("a1.tif", tiff::small()), ("a2.tif", tiff::small())]);
    assert!(
        stack.contains("a1.tif") && stack.contains("2 pages"),
        "{stack}"
    );
    // One stack alone is read as it is.
    let alone = folder(&[("a1.tif", tiff::small()), ("notes.txt", b"x".to_vec())]).unwrap();
    assert_eq!(alone.volume.grid().dims(), [2, 3, 2]);
    assert!(alone.notes[0].contains("notes.txt"), "{:?}", alone.notes);
}

#[test]
fn the_odd_one_out_is_named() {
    let good = png(2, 1, &[1, 2]);
    let wide = png(3, 1, &[1, 2, 3]);
    let deep = encode(
        2,
        1,
        png::BitDepth::Sixteen,
        png::ColorType::Grayscale,
        &[1, 2, 3, 4],
    );
    for (odd, part) in [(wide, "a2.png is 3 x 1 u8"), (deep, "a2.png is 2 x 1 u16")] {
        let error = refused(&[
            ("a1.png", good.clone()),
            ("a2.png", odd),
            ("a3.png", good.clone()),
        ]);
        assert!(
            error.starts_with("scan: ") && error.contains(part),
            "{error}"
        );
    }
    let broken = refused(&[("a1.png", good.clone()), ("a2.png", good[..40].to_vec())]);
    assert!(broken.contains("a2.png"), "{broken}");
}

#[test]
fn mixed_names_are_asked_about() {
    let good = png(2, 1, &[1, 2]);
    let error = refused(&[
        ("ct1.png", good.clone()),
        ("ct2.png", good.clone()),
        ("mask1.png", good.clone()),
    ]);
    assert!(
        error.contains("ct#.png") && error.contains("mask#.png"),
        "{error}"
    );
    let loaded = folder(&[
        ("a1.png", good.clone()),
        ("a2.png", good.clone()),
        ("a4.png", good),
    ]);
    let notes = loaded.unwrap().notes;
    assert!(notes[0].contains("2 to 4"), "{notes:?}");
}

#[test]
fn colors_become_luminance_and_components_can_be_picked() {
    use png::ColorType::{GrayscaleAlpha, Indexed, Rgb, Rgba};
    let pick = |file: &[u8], component| {
        let options = ReadOptions {
            component,
            ..ReadOptions::default()
        };
        let loaded = read_with(&[("a.png", file)], &options)?;
        assert!(loaded.notes.len() == 2, "{:?}", loaded.notes);
        Ok::<_, Error>(loaded.volume.samples().clone())
    };
    // The palette goes from blue to red.
    for (color, data, grey, second) in [
        (Rgb, &[255, 0, 0, 10, 20, 30][..], [54, 19], [0, 20]),
        (
            Rgba,
            &[0, 255, 0, 9, 100, 100, 100, 9],
            [182, 100],
            [255, 100],
        ),
        (GrayscaleAlpha, &[7, 255, 8, 0], [7, 8], [255, 0]),
        (Indexed, &[10, 255], [20, 54], [0, 0]),
    ] {
        let file = encode(2, 1, png::BitDepth::Eight, color, data);
        assert_eq!(
            pick(&file, None).unwrap(),
            Samples::U8(grey.to_vec()),
            "{color:?}"
        );
        assert_eq!(
            pick(&file, Some(1)).unwrap(),
            Samples::U8(second.to_vec()),
            "{color:?}"
        );
        let error = pick(&file, Some(4)).unwrap_err().to_string();
        assert!(error.contains("component is 4"), "{error}");
    }
    let deep = [0xFF, 0xFF, 0, 0, 0, 0];
    let file = encode(1, 1, png::BitDepth::Sixteen, Rgb, &deep);
    assert_eq!(pick(&file, None).unwrap(), Samples::U16(vec![13933]));
    // One bit an index.
    let file = encode(3, 1, png::BitDepth::One, Indexed, &[0b0100_0000]);
    assert_eq!(
        pick(&file, Some(2)).unwrap(),
        Samples::U8(vec![255, 254, 255])
    );
}

#[test]
fn a_header_that_claims_much_costs_nothing() {
    let mut file = png(2, 1, &[1, 2]);
    // IHDR: width and height, then the checksum of the chunk.
    file[16..20].copy_from_slice(&60_000u32.to_be_bytes());
    file[20..24].copy_from_slice(&60_000u32.to_be_bytes());
    let crc = {
        let mut crc = flate2::Crc::new();
        crc.update(&file[12..29]);
        crc.sum()
    };
    file[29..33].copy_from_slice(&crc.to_be_bytes());
    let error = message(&[("a.png", &file)]);
    assert!(error.contains("the picture is cut off"), "{error}");
    let error = message(&[("a.png.gz", &gzip(&file))]);
    assert!(error.contains("the picture is cut off"), "{error}");
}

/// The header of a bitmap of 3×2 pixels, with its palette.
fn bitmap(bits: u16, is_downward: bool, palette: &[[u8; 3]]) -> Vec<u8> {
    let height = if is_downward { -2i32 } else { 2 };
    let mut file = b"BM\0\0\0\0\0\0\0\0".to_vec();
    file.extend((54 + 4 * palette.len() as u32).to_le_bytes());
    file.extend(40u32.to_le_bytes());
    file.extend(3i32.to_le_bytes());
    file.extend(height.to_le_bytes());
    file.extend(1u16.to_le_bytes());
    file.extend(bits.to_le_bytes());
    file.extend([0; 16]);
    file.extend((palette.len() as u32).to_le_bytes());
    file.extend([0; 4]);
    file.extend(palette.iter().flat_map(|[r, g, b]| [*b, *g, *r, 0]));
    file
}

#[test]
fn bitmaps_are_slices() {
    // Rows are filled up to 4 bytes.
    let grey = [[0, 0, 0], [100, 100, 100], [7, 7, 7]];
    let (first, second) = ([0, 1, 2, 0], [2, 2, 1, 0]);
    let options = ReadOptions::default();
    for (is_downward, rows) in [(false, [&second[..], &first]), (true, [&first, &second])] {
        let mut file = bitmap(8, is_downward, &grey);
        file.extend(rows.concat());
        let loaded = read_with(&[("a.bmp", &file)], &options).unwrap();
        assert_eq!(
            *loaded.volume.samples(),
            Samples::U8(vec![0, 100, 7, 7, 7, 100])
        );
        assert!(message(&[("a.bmp", &file[..70])]).contains("cut off"));
    }
    let mut file = bitmap(24, false, &[]);
    file.extend([9, 9, 9, 9, 9, 9, 9, 9, 9, 0, 0, 0]);
    file.extend([0, 0, 255, 0, 255, 0, 255, 0, 0, 0, 0, 0]);
    let loaded = read_with(&[("a.bmp", &file)], &options).unwrap();
    assert_eq!(
        *loaded.volume.samples(),
        Samples::U8(vec![54, 182, 18, 9, 9, 9])
    );
    file[30] = 1;
    assert!(message(&[("a.bmp", &file)]).contains("compression 1"));
}

/// 8 × 8 samples of 16·x + 8·y, as libjpeg packs them with quality 90; it unpacks to the same within 1.
const JPEG: &str = "ffd8ffdb0043000302020302020303030304030304050805050404050a070706080c0a0c0c0b0a0b0b0d0e1210\
    0d0e110e0b0b1016101113141515150c0f171816141812141514ffc0000b080008000801011100ffc400140001\
    00000000000000000000000000000007ffc4001a100000070000000000000000000000000000070823344151ff\
    da0008010100003f000a4da5b456b287ffd9";

#[cfg(feature = "dicom")]
#[test]
fn jpeg_pictures_are_slices() {
    let file: Vec<u8> = (0..JPEG.len() / 2)
        .map(|i| u8::from_str_radix(&JPEG[2 * i..2 * i + 2], 16).unwrap())
        .collect();
    let loaded = folder(&[("s1.jpg", file.clone()), ("s2.jpg", file.clone())]).unwrap();
    assert_eq!(loaded.volume.grid().dims(), [8, 8, 2]);
    for (x, y) in [(0, 0), (7, 0), (0, 7), (7, 7), (3, 4)] {
        let value = loaded.volume.value(x, y, 1);
        assert!(
            (value - (16 * x + 8 * y) as f64).abs() <= 1.0,
            "{value} at {x}, {y}"
        );
    }
    assert!(
        loaded
            .notes
            .iter()
            .any(|note| note.contains("JPEG changes"))
    );
    assert!(message(&[("a.jpg", &file[..60])]).contains("JPEG"));
}
