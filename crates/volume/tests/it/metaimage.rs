//! MetaImage headers of all shapes.

use crate::{assert_affine, gzip, message, read, read_with};
use glam::{DAffine3, DVec3};
use std::io::Write;
use strahl_volume::read::ReadOptions;
use strahl_volume::{Modality, Rescale, Samples};

const START: &str = "ObjectType = Image\nNDims = 3\nDimSize = 2 3 1\nElementType = MET_SHORT\n";

fn zlib(data: &[u8]) -> Vec<u8> {
    let mut packer = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    packer.write_all(data).unwrap();
    packer.finish().unwrap()
}

fn little() -> Vec<u8> {
    (1..=6i16).flat_map(|v| v.to_le_bytes()).collect()
}

fn local(rest: &str, data: &[u8]) -> Vec<u8> {
    [
        START.as_bytes(),
        rest.as_bytes(),
        b"ElementDataFile = LOCAL\n",
        data,
    ]
    .concat()
}

#[test]
fn samples_are_found_in_every_place() {
    let expected = Samples::I16((1..=6).collect());
    let check = |files: &[(&str, &[u8])]| {
        let loaded = read(files).unwrap();
        assert_eq!(
            *loaded.volume.samples(),
            expected,
            "{:?}",
            files[0].1.escape_ascii()
        );
    };
    let data = little();
    let big: Vec<u8> = (1..=6i16).flat_map(|v| v.to_be_bytes()).collect();
    check(&[("v.mha", &local("", &data))]);
    check(&[("v.mha", &local("BinaryDataByteOrderMSB = True\n", &big))]);
    check(&[("v.mha", &local("ElementByteOrderMSB = true\n", &big))]);
    check(&[("v.mha", &local("BinaryData = False\n", b"1 2 3 4 5 6\n"))]);
    check(&[(
        "v.mha",
        &local(
            "CompressedData = True\nCompressedDataSize = 20\n",
            &zlib(&data),
        ),
    )]);
    check(&[("v.mha", &local("CompressedData = True\n", &gzip(&data)))]);
    check(&[("v.mha.gz", &gzip(&local("", &data)))]);
    check(&[(
        "v.mha",
        &local("HeaderSize = 3\n", &[b"xyz", data.as_slice()].concat()),
    )]);

    let detached = |rest: &str| format!("{START}{rest}").into_bytes();
    check(&[
        ("v.mhd", &detached("ElementDataFile = v 1.raw\n")),
        ("v 1.raw", &data),
    ]);
    check(&[
        ("v.mhd", &detached("ElementDataFile = v.raw")),
        ("v.raw", &data),
    ]);
    check(&[
        (
            "v.mhd",
            &detached("HeaderSize = -1\nElementDataFile = v.raw\n"),
        ),
        ("v.raw", &[b"any header", data.as_slice()].concat()),
    ]);
    check(&[
        ("v.mhd", &detached("ElementDataFile = LIST\na\nb\n")),
        ("a", &data[..6]),
        ("b", &data[6..]),
    ]);
    check(&[
        ("v.mhd", &detached("ElementDataFile = s%02d.raw 1 3 1\n")),
        ("s01.raw", &data[..4]),
        ("s02.raw", &data[4..8]),
        ("s03.raw", &data[8..]),
    ]);
}

#[test]
fn rows_of_the_matrix_are_directions_in_lps() {
    let rest = "TransformMatrix = 0 1 0 -1 0 0 0 0 1\nOffset = 10 20 30\nElementSpacing = 2 3 4\n";
    let expected = DAffine3::from_cols(
        DVec3::new(0.0, -2.0, 0.0),
        DVec3::new(3.0, 0.0, 0.0),
        DVec3::new(0.0, 0.0, 4.0),
        DVec3::new(-10.0, -20.0, 30.0),
    );
    let synonyms = rest
        .replace("TransformMatrix", "Orientation")
        .replace("Offset", "Position")
        .replace("ElementSpacing", "ElementSize");
    for rest in [rest, &synonyms] {
        let volume = read(&[("v.mha", &local(rest, &little()))]).unwrap().volume;
        assert_affine(volume.grid().world_from_voxel(), expected, 0.0);
        assert!(volume.metadata().has_length_unit);
    }
    let both = "ElementSize = 9 9 9\nElementSpacing = 2 3 4\nDistanceUnits = cm\n";
    let volume = read(&[("v.mha", &local(both, &little()))]).unwrap().volume;
    assert_eq!(volume.grid().spacing_mm(), DVec3::new(20.0, 30.0, 40.0));
}

#[test]
fn rescale_modality_and_other_keys_are_kept() {
    let rest = "Modality = MET_MOD_CT\nElementToIntensityFunctionSlope = 2\nElementToIntensityFunctionOffset = -1024\nMyKey = my value\n";
    let volume = read(&[("v.mha", &local(rest, &little()))]).unwrap().volume;
    assert_eq!(volume.metadata().modality, Some(Modality::Ct));
    assert_eq!(volume.rescale(), Rescale::new(2.0, -1024.0));
    let entries = &volume.metadata().entries;
    assert!(
        entries.contains(&("MyKey".into(), "my value".into())),
        "{entries:?}"
    );
}

#[test]
fn a_time_point_is_picked_from_four_dimensions() {
    let header = "NDims = 4\nDimSize = 2 1 1 3\nElementType = MET_SHORT\nElementDataFile = LOCAL\n";
    let file = [header.as_bytes(), &little()].concat();
    for time_index in 0..3 {
        let options = ReadOptions {
            time_index,
            ..ReadOptions::default()
        };
        let volume = read_with(&[("v.mha", &file)], &options).unwrap().volume;
        let first = 2 * time_index as i16 + 1;
        assert_eq!(*volume.samples(), Samples::I16(vec![first, first + 1]));
        assert_eq!(volume.metadata().time_points, 3);
    }
    let options = ReadOptions {
        time_index: 3,
        ..ReadOptions::default()
    };
    assert!(read_with(&[("v.mha", &file)], &options).is_err());
}

#[test]
fn wrong_headers_are_refused_with_the_key_named() {
    let base = format!("{START}ElementSpacing = 1 1 1\nElementDataFile = LOCAL\n");
    let change = |from: &str, to: &str| base.replace(from, to);
    let more = |line: &str| change("ElementDataFile", &format!("{line}\nElementDataFile"));
    let cases = [
        (
            change("ObjectType = Image", "ObjectType = Tube"),
            "ObjectType is `Tube`",
        ),
        (change("NDims = 3\n", ""), "NDims is missing"),
        (change("NDims = 3", "NDims = 7"), "NDims is 7"),
        (change("DimSize = 2 3 1\n", ""), "DimSize is missing"),
        (
            change("DimSize = 2 3 1", "DimSize = 2 3"),
            "DimSize is `2 3`",
        ),
        (
            change("DimSize = 2 3 1", "DimSize = 2 0 1"),
            "DimSize is [2, 0, 1]",
        ),
        (
            change("DimSize = 2 3 1", "DimSize = 2 3 99999999999"),
            "dimension z",
        ),
        (
            change("MET_SHORT", "MET_STRING"),
            "ElementType is `MET_STRING`",
        ),
        (
            change("ElementSpacing = 1 1 1", "ElementSpacing = 1 1"),
            "ElementSpacing is `1 1`",
        ),
        (
            change("ElementSpacing = 1 1 1", "ElementSpacing = 1 0 1"),
            "cannot be inverted",
        ),
        (
            change("ElementSpacing = 1 1 1", "ElementSpacing = 1 nan 1"),
            "not finite",
        ),
        (change("LOCAL", "gone.raw"), "gone.raw"),
        (change("LOCAL", "../../../secret"), "secret"),
        (
            change("ElementDataFile = LOCAL\n", ""),
            "`ElementDataFile` ends the header",
        ),
        (more("ElementNumberOfChannels = 3"), "3 numbers per voxel"),
        (more("BinaryData = Maybe"), "BinaryData is `maybe`"),
        (more("HeaderSize = -2"), "HeaderSize is -2"),
        (more("NDims = 4"), "NDims is given twice"),
        (more("DistanceUnits = miles"), "DistanceUnits is `miles`"),
        (more("TransformMatrix = 1 0 0"), "TransformMatrix"),
        (more("no equals sign"), "no equals sign"),
    ];
    for (header, part) in cases {
        let message = message(&[("v.mha", &[header.as_bytes(), &little()].concat())]);
        assert!(
            message.starts_with("v.mha: ") && message.contains(part),
            "{message}"
        );
    }
}

#[test]
fn data_in_a_folder_below_is_not_that_beside_the_header() {
    let header = |name: &str| format!("{START}ElementDataFile = {name}\n").into_bytes();
    let (zeros, data) = ([0; 12], little());
    let expected = Samples::I16((1..=6).collect());
    for name in [
        "data/v.raw",
        "./data/v.raw",
        "data\\v.raw",
        "other/../data/v.raw",
    ] {
        let files = [
            ("v.mhd", &header(name)[..]),
            ("v.raw", &zeros),
            ("data/v.raw", &data),
        ];
        let loaded = read(&files).unwrap();
        assert_eq!(*loaded.volume.samples(), expected, "{name}");
        assert!(loaded.notes.is_empty());
    }
    // What is not there is not looked for elsewhere …
    let missing = message(&[("v.mhd", &header("data/v.raw")), ("v.raw", &zeros)]);
    assert!(missing.contains("there is no data/v.raw"), "{missing}");
    let outside = message(&[("v.mhd", &header("../v.raw")), ("v.raw", &zeros)]);
    assert!(outside.contains("a file beside v.mhd"), "{outside}");
    // … but a path from the root was that of another machine.
    for name in ["/scans/v.raw", "C:\\scans\\v.raw"] {
        let loaded = read(&[("v.mhd", &header(name)[..]), ("v.raw", &data)]).unwrap();
        assert_eq!(*loaded.volume.samples(), expected);
        assert!(
            loaded.notes[0].contains("v.raw beside v.mhd was read"),
            "{:?}",
            loaded.notes
        );
    }
}

#[test]
fn headers_may_begin_with_a_byte_order_mark() {
    let file = [b"\xEF\xBB\xBF", &local("", &little())[..]].concat();
    let loaded = read(&[("v.mha", &file)]).unwrap();
    assert_eq!(*loaded.volume.samples(), Samples::I16((1..=6).collect()));
}

#[test]
fn whole_numbers_of_64_bits_are_read_where_they_fit() {
    let header = |rest: &str| {
        let start = START.replace("MET_SHORT", "MET_LONG_LONG");
        format!("{start}{rest}ElementDataFile = LOCAL\n")
    };
    let big: Vec<u8> = (-3..3i64).flat_map(|v| v.to_be_bytes()).collect();
    let binary = [header("BinaryDataByteOrderMSB = True\n").as_bytes(), &big].concat();
    let text = [
        header("BinaryData = False\n").as_bytes(),
        b"-3 -2 -1 0 1 2\n",
    ]
    .concat();
    for file in [binary, text] {
        let loaded = read(&[("v.mha", &file)]).unwrap();
        assert_eq!(*loaded.volume.samples(), Samples::I32((-3..3).collect()));
        assert!(loaded.notes[0].contains("as i32"), "{:?}", loaded.notes);
    }
}

#[test]
fn channels_lie_side_by_side() {
    let header = |kind: &str, channels: usize| {
        format!(
            "NDims = 2\nDimSize = 2 1\nElementType = {kind}\nElementNumberOfChannels = {channels}\nElementDataFile = LOCAL\n"
        )
    };
    let options = ReadOptions {
        component: Some(2),
        ..ReadOptions::default()
    };
    let file = [header("MET_SHORT", 3).as_bytes(), &little()].concat();
    let loaded = read_with(&[("v.mha", &file)], &options).unwrap();
    assert_eq!(*loaded.volume.samples(), Samples::I16(vec![3, 6]));
    let file = [header("MET_UCHAR", 3).as_bytes(), &[255, 0, 0, 9, 9, 9]].concat();
    let loaded = read(&[("v.mha", &file)]).unwrap();
    assert_eq!(*loaded.volume.samples(), Samples::U8(vec![54, 9]));
}
