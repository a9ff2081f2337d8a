//! NRRD headers of all shapes.

use crate::{gzip, message, read, read_with};
use glam::{DAffine3, DMat3, DVec3};
use strahl_volume::read::ReadOptions;
use strahl_volume::{Label, Samples};

const U8: &str = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 3 1\nencoding: raw\n";

fn attached(header: &str, data: &[u8]) -> Vec<u8> {
    [header.as_bytes(), b"\n", data].concat()
}

fn affine(header: &str) -> DAffine3 {
    let file = attached(header, &[1, 2, 3, 4, 5, 6]);
    read(&[("v.nrrd", &file)])
        .unwrap()
        .volume
        .grid()
        .world_from_voxel()
}

#[test]
fn spaces_are_turned_into_ras() {
    let directions = "space directions: (1,0.5,0) (0,2,0) (0,0,3)\nspace origin: (10,20,30)\n";
    for (space, sign) in [
        ("right-anterior-superior", DVec3::new(1.0, 1.0, 1.0)),
        ("RAS", DVec3::new(1.0, 1.0, 1.0)),
        ("left-anterior-superior", DVec3::new(-1.0, 1.0, 1.0)),
        ("LAS", DVec3::new(-1.0, 1.0, 1.0)),
        ("left-posterior-superior", DVec3::new(-1.0, -1.0, 1.0)),
        ("LPS", DVec3::new(-1.0, -1.0, 1.0)),
        ("scanner-xyz", DVec3::new(-1.0, -1.0, 1.0)),
    ] {
        let found = affine(&format!("{U8}space: {space}\n{directions}"));
        let expected = DAffine3::from_cols(
            sign * DVec3::new(1.0, 0.5, 0.0),
            sign * DVec3::new(0.0, 2.0, 0.0),
            sign * DVec3::new(0.0, 0.0, 3.0),
            sign * DVec3::new(10.0, 20.0, 30.0),
        );
        assert_eq!(found, expected, "{space}");
    }
    let found = affine(&format!(
        "{U8}space: LPS\nspace units: \"um\" \"um\" \"um\"\n{directions}"
    ));
    assert!((found.translation - DVec3::new(-0.01, -0.02, 0.03)).length() < 1e-15);
}

#[test]
fn without_a_space_spacings_and_ends_place_the_grid() {
    let found = affine(&format!("{U8}spacings: 0.5 2 NaN\naxis mins: 10 20 NaN\n"));
    // Cells are the default: the first sample lies half a step inside.
    let expected = DAffine3::from_mat3_translation(
        DMat3::from_diagonal(DVec3::new(-0.5, -2.0, 1.0)),
        DVec3::new(-10.25, -21.0, 0.0),
    );
    assert_eq!(found, expected);
    let ends = "axis mins: 0 0 0\naxis maxs: 4 6 8\ncenterings: cell node cell\n";
    let found = affine(&format!("{U8}{ends}"));
    let expected = DAffine3::from_mat3_translation(
        DMat3::from_diagonal(DVec3::new(-2.0, -3.0, 8.0)),
        DVec3::new(-1.0, 0.0, 4.0),
    );
    assert_eq!(found, expected);
}

#[test]
fn samples_are_found_in_every_place() {
    let header = "NRRD0004\ntype: unsigned short\ndimension: 3\nsizes: 2 3 1\nendian: big\n";
    let data: Vec<u8> = (1..=6u16).flat_map(|v| v.to_be_bytes()).collect();
    let expected = Samples::U16((1..=6).collect());
    let check = |files: &[(&str, &[u8])]| {
        let loaded = read(files).unwrap();
        assert_eq!(
            *loaded.volume.samples(),
            expected,
            "{:?}",
            files[0].1.escape_ascii()
        );
    };
    let with = |rest: &str| format!("{header}{rest}");

    check(&[("v.nrrd", &attached(&with("encoding: raw\n"), &data))]);
    check(&[("v.nrrd", &attached(&with("encoding: gz\n"), &gzip(&data)))]);
    check(&[(
        "v.nrrd",
        &attached(&with("encoding: TXT\n"), b"1 2 3\n4 5 6\n"),
    )]);
    check(&[(
        "v.nrrd",
        &attached(&with("encoding: hex\n"), b"00010002 00030004\n00050006\n"),
    )]);
    // The whole file packed.
    check(&[(
        "v.nrrd.gz",
        &gzip(&attached(&with("encoding: raw\n"), &data)),
    )]);
    // Detached: with and without an end of the header, with folders in the name.
    check(&[
        (
            "v.nhdr",
            with("encoding: raw\ndata file: v.raw\n").as_bytes(),
        ),
        ("v.raw", &data),
    ]);
    check(&[
        (
            "v.nhdr",
            with("encoding: raw\ndatafile: ./v 1.raw\n\n").as_bytes(),
        ),
        ("v 1.raw", &data),
    ]);
    // Skipped lines, then bytes; with gzip the bytes are skipped after unpacking.
    let skipped = [b"line one\nline two\nxyz", data.as_slice()].concat();
    let skips = "line skip: 2\nbyte skip: 3\ndata file: v.raw\n";
    check(&[
        (
            "v.nhdr",
            with(&format!("encoding: raw\n{skips}")).as_bytes(),
        ),
        ("v.raw", &skipped),
    ]);
    let skipped = [
        b"line one\nline two\n",
        gzip(&[b"xyz", data.as_slice()].concat()).as_slice(),
    ]
    .concat();
    check(&[
        (
            "v.nhdr",
            with(&format!("encoding: gzip\n{skips}")).as_bytes(),
        ),
        ("v.raw", &skipped),
    ]);
    let end = "encoding: raw\nbyte skip: -1\ndata file: v.raw\n";
    check(&[
        ("v.nhdr", with(end).as_bytes()),
        ("v.raw", &[b"unknown header", data.as_slice()].concat()),
    ]);
    // Several files.
    let list = "encoding: raw\ndata file: LIST 2\na.raw\nb.raw\nc.raw\n";
    check(&[
        ("v.nhdr", with(list).as_bytes()),
        ("a.raw", &data[..4]),
        ("b.raw", &data[4..8]),
        ("c.raw", &data[8..]),
    ]);
    let pattern = "encoding: gzip\ndata file: s%03d.gz 9 11 2\n";
    check(&[
        ("v.nhdr", with(pattern).as_bytes()),
        ("s009.gz", &gzip(&data[..6])),
        ("s011.gz", &gzip(&data[6..])),
    ]);
}

#[test]
fn a_list_or_time_axis_is_picked_from_wherever_it_stands() {
    let data: Vec<u8> = (0..24).collect();
    let cases = [
        ("4 2 3 1", "list domain domain domain", 1usize, 4),
        ("2 4 3 1", "domain list domain domain", 2, 4),
        ("2 3 1 4", "domain domain domain time", 6, 4),
    ];
    for (sizes, kinds, before, length) in cases {
        let header = format!(
            "NRRD0004\ntype: uchar\ndimension: 4\nsizes: {sizes}\nkinds: {kinds}\nencoding: raw\n"
        );
        let file = attached(&header, &data);
        for time_index in 0..length {
            let options = ReadOptions {
                time_index,
                ..ReadOptions::default()
            };
            let volume = read_with(&[("v.nrrd", &file)], &options).unwrap().volume;
            let expected: Vec<u8> = data
                .iter()
                .enumerate()
                .filter(|(i, _)| i / before % length == time_index)
                .map(|(_, v)| *v)
                .collect();
            assert_eq!(*volume.samples(), Samples::U8(expected), "{kinds}");
            assert_eq!(volume.metadata().time_points, length);
        }
    }
    let vector = "NRRD0004\ntype: uchar\ndimension: 4\nsizes: 3 2 2 2\nkinds: 3-vector domain domain domain\nencoding: raw\n";
    let message = message(&[("v.nrrd", &attached(vector, &data))]);
    assert!(message.contains("3 numbers per voxel"), "{message}");
}

/// Where the layers of [`segmentation`] lie.
#[derive(Clone, Copy)]
enum LayersAt {
    Front,
    End,
}

/// Four voxels in two layers: 1 1 0 2 and 0 b b 0, and these keys.
fn segmentation(at: LayersAt, b: u8, keys: &str) -> Vec<u8> {
    let (sizes, directions, kinds, samples) = match at {
        LayersAt::Front => (
            "2 4 1 1",
            "none (1,0,0) (0,1,0) (0,0,1)",
            "list domain domain domain",
            [1, 0, 1, b, 0, b, 2, 0],
        ),
        LayersAt::End => (
            "4 1 1 2",
            "(1,0,0) (0,1,0) (0,0,1) none",
            "domain domain domain list",
            [1, 1, 0, 2, 0, b, b, 0],
        ),
    };
    let header = format!(
        "NRRD0004\ntype: uint8\ndimension: 4\nsizes: {sizes}\nspace: LPS\n\
        space directions: {directions}\nkinds: {kinds}\nencoding: raw\n{keys}"
    );
    attached(&header, &samples)
}

const BONE: &str = "Segment0_Name:=bone\nSegment0_LabelValue:=1\nSegment0_Layer:=0\n\
    Segment0_Color:=0.9 0.8 0.7\nSegment0_Tags:=Segmentation.Status:inprogress|\
    TerminologyEntry:a list~SCT^85756007^Tissue~SCT^272673000^Bone~^^~other list~^^~^^|\n";

#[test]
fn layers_of_segments_become_one() {
    let bone = |id| Label {
        color: Some([0.9, 0.8, 0.7]),
        group: Some("Tissue".into()),
        ..Label::new(id, "bone")
    };
    for at in [LayersAt::Front, LayersAt::End] {
        let read_with_value = |b: u8, order: [u8; 2]| {
            let [bone, other] = order;
            let bone = BONE.replace("Segment0", &format!("Segment{bone}"));
            let keys = format!(
                "{bone}Segment{other}_ID:=Segment_2\nSegment{other}_LabelValue:={b}\n\
                Segment{other}_Layer:=1\n"
            );
            read(&[("v.seg.nrrd", &segmentation(at, b, &keys))]).unwrap()
        };
        // Numbers that no two segments share stay ids; the second voxel is in both.
        let loaded = read_with_value(7, [0, 1]);
        assert_eq!(*loaded.volume.samples(), Samples::U8(vec![1, 7, 7, 2]));
        assert_eq!(
            loaded.labels,
            Some(vec![bone(1), Label::new(7, "Segment_2")])
        );
        assert_eq!(
            loaded.notes,
            ["1 voxels belong to several segments; the last segment is kept"]
        );
        assert_eq!(loaded.volume.metadata().time_points, 1);
        let loaded = read_with_value(7, [5, 3]);
        assert_eq!(*loaded.volume.samples(), Samples::U8(vec![1, 1, 7, 2]));
        // Else they are counted, and what has no name comes behind.
        let loaded = read_with_value(1, [0, 1]);
        assert_eq!(*loaded.volume.samples(), Samples::U8(vec![1, 2, 2, 3]));
        assert_eq!(
            loaded.labels,
            Some(vec![bone(1), Label::new(2, "Segment_2")])
        );
        assert!(
            loaded.notes[0].contains("share numbers"),
            "{:?}",
            loaded.notes
        );
        let loaded = read_with_value(1, [1, 0]);
        assert_eq!(*loaded.volume.samples(), Samples::U8(vec![2, 2, 1, 3]));
        assert_eq!(
            loaded.labels,
            Some(vec![Label::new(1, "Segment_2"), bone(2)])
        );
        let loaded = read_with_value(2, [0, 1]);
        assert_eq!(*loaded.volume.samples(), Samples::U8(vec![1, 2, 2, 3]));
    }
}

#[test]
fn one_layer_of_segments_is_a_component() {
    let keys = format!("{BONE}Segment1_ID:=Segment_2\nSegment1_LabelValue:=7\nSegment1_Layer:=1\n");
    let file = segmentation(LayersAt::Front, 7, &keys);
    let read = |component, time_index| {
        let options = ReadOptions {
            component: Some(component),
            time_index,
            ..ReadOptions::default()
        };
        read_with(&[("v.seg.nrrd", &file)], &options)
    };
    let second = read(1, 0).unwrap();
    assert_eq!(*second.volume.samples(), Samples::U8(vec![0, 7, 7, 0]));
    assert_eq!(second.labels, Some(vec![Label::new(7, "Segment_2")]));
    let message = read(2, 0).unwrap_err().to_string();
    assert!(
        message.contains("component is 2; allowed: 0 to 1"),
        "{message}"
    );
    let message = read(0, 1).unwrap_err().to_string();
    assert!(
        message.contains("time point is 1; allowed: 0: layers"),
        "{message}"
    );
}

#[test]
fn segments_without_layers_have_one_each() {
    let keys = "Segment0_Name:=a\nSegment1_Name:=b\nSegment2_Name:=c\nSegment2_LabelValue:=0\n";
    let loaded = read(&[("v.seg.nrrd", &segmentation(LayersAt::End, 1, keys))]).unwrap();
    // In the first layer 2 has no name.
    assert_eq!(*loaded.volume.samples(), Samples::U8(vec![1, 2, 2, 3]));
    let labels = vec![Label::new(1, "a"), Label::new(2, "b")];
    assert_eq!(loaded.labels, Some(labels));
    assert_eq!(loaded.notes[0], "`c` (value 0 in layer 0) has no voxels");
    for (key, expected) in [
        ("Segment0_Layer:=x\n", "Segment0_Layer is `x`"),
        ("Segment0_LabelValue:=-1\n", "Segment0_LabelValue is `-1`"),
        ("Segment0_Color:=1 2\n", "Segment0_Color is `1 2`"),
    ] {
        let file = segmentation(LayersAt::End, 1, &format!("{keys}{key}"));
        let message = message(&[("v.seg.nrrd", &file)]);
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn comments_and_entries_are_told_apart() {
    let header = format!(
        "{U8}# a comment: with a colon\ncontent: a thing\nmodality:=MR\nkey:=a:=b\\nc\nsample units: \"HU\"\n"
    );
    let file = attached(&header, &[0; 6]);
    let loaded = read(&[("v.nrrd", &file)]).unwrap();
    let metadata = loaded.volume.metadata();
    assert_eq!(metadata.modality, Some(strahl_volume::Modality::Mr));
    assert_eq!(metadata.value_unit.as_deref(), Some("HU"));
    let expected = [
        ("content", "a thing"),
        ("modality", "MR"),
        ("key", "a:=b\nc"),
    ];
    let expected = expected.map(|(k, v)| (k.to_owned(), v.to_owned()));
    assert_eq!(metadata.entries, expected);
}

#[test]
fn wrong_headers_are_refused_with_the_field_named() {
    let base = "NRRD0004\ntype: short\ndimension: 3\nsizes: 2 3 1\nencoding: raw\nendian: little\n";
    let change = |from: &str, to: &str| base.replace(from, to);
    let cases = [
        (change("NRRD0004", "NRRD0009"), "NRRD0001"),
        (change("type: short\n", ""), "type is missing"),
        (change("type: short", "type: quad"), "type is `quad`"),
        (change("type: short", "type: block"), "block"),
        (change("dimension: 3\n", ""), "dimension is missing"),
        (change("dimension: 3", "dimension: 99"), "dimension is 99"),
        (change("sizes: 2 3 1", "sizes: 2 3"), "sizes is `2 3`"),
        (change("sizes: 2 3 1", "sizes: 2 0 1"), "sizes is [2, 0, 1]"),
        (change("sizes: 2 3 1", "sizes: 2 -3 1"), "sizes is `2 -3 1`"),
        (
            change("sizes: 2 3 1", "sizes: 1048576 1048576 1048576"),
            "cut off",
        ),
        (
            change("sizes: 2 3 1", "sizes: 4194304 4194304 4194304"),
            "sizes",
        ),
        (change("encoding: raw\n", ""), "encoding is missing"),
        (
            change("encoding: raw", "encoding: zip"),
            "encoding is `zip`",
        ),
        (change("endian: little\n", ""), "endian is missing"),
        (
            change("endian: little", "endian: middle"),
            "endian is `middle`",
        ),
        (
            change("endian: little", "endian: little\nendian: big"),
            "endian is given twice",
        ),
        (
            change("endian: little", "endian: little\nno such: 1"),
            "no such",
        ),
        (
            change("endian: little", "endian: little\nnonsense"),
            "nonsense",
        ),
        (
            change("endian: little", "endian: little\nbyte skip: -2"),
            "byte skip is -2",
        ),
        (
            change("endian: little", "endian: little\nline skip: -1"),
            "line skip is -1",
        ),
        (
            change("endian: little", "endian: little\ndata file: gone.raw"),
            "gone.raw",
        ),
        (
            change("endian: little", "endian: little\ndata file: ../../secret"),
            "secret",
        ),
        (
            change("endian: little", "endian: little\ndata file: s%s.raw 1 2 1"),
            "s%s.raw",
        ),
        (
            change(
                "endian: little",
                "endian: little\nspace: inside-out\nspace directions: (1,0,0) (0,1,0) (0,0,1)",
            ),
            "space is `inside-out`",
        ),
        (
            change(
                "endian: little",
                "endian: little\nspace: LPS\nspace directions: (1,0,0) (0,1,0)",
            ),
            "space directions",
        ),
        (
            change(
                "endian: little",
                "endian: little\nspace: LPS\nspace directions: (1,0,0) (2,0,0) (0,0,1)",
            ),
            "cannot be inverted",
        ),
        (
            change(
                "endian: little",
                "endian: little\nspace: LPS\nspace directions: (nan,0,0) (0,1,0) (0,0,1)",
            ),
            "not finite",
        ),
        (
            change("endian: little", "endian: little\nspacings: 1 0 1"),
            "cannot be inverted",
        ),
        (
            change("endian: little", "endian: little\nkinds: domain domain"),
            "kinds",
        ),
    ];
    for (header, part) in cases {
        let message = message(&[("v.nrrd", &attached(&header, &[0; 12]))]);
        assert!(
            message.starts_with("v.nrrd: ") && message.contains(part),
            "{message}"
        );
    }
    let message = message(&[("v.nrrd", base.as_bytes())]);
    assert!(message.contains("empty line"), "{message}");
}

#[test]
fn samples_at_the_end_of_a_packed_file() {
    let header = b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 3 1\nencoding: gzip\nbyte skip: -1\ndata file: v.gz\n";
    for before in [0, 1, 352, 100_000] {
        let whole = [vec![9; before], (1..=6).collect()].concat();
        let loaded = read(&[("v.nhdr", &header[..]), ("v.gz", &gzip(&whole))]).unwrap();
        assert_eq!(
            *loaded.volume.samples(),
            Samples::U8((1..=6).collect()),
            "{before}"
        );
    }
    let short = message(&[("v.nhdr", &header[..]), ("v.gz", &gzip(&[1, 2, 3]))]);
    assert!(short.contains("promises 6 bytes, 3 are there"), "{short}");
}

#[test]
fn images_of_four_dimensions_as_itk_writes_them() {
    let start = "NRRD0004\ntype: uint8\ndimension: 4\nsizes: 2 3 1 2\nencoding: raw\nkinds: domain domain domain domain\n";
    let placed = "space dimension: 4\nspace directions: (2,0,0,0) (0,3,0,0) (0,0,4,0) (0,0,0,1.5)\nspace origin: (-10,20,5,0)\n";
    for (rest, scale) in [
        (placed, DVec3::new(-2.0, -3.0, 4.0)),
        ("spacings: 2 3 4 1.5\n", DVec3::new(-2.0, -3.0, 4.0)),
    ] {
        let file = attached(&format!("{start}{rest}"), &(0..12).collect::<Vec<u8>>());
        let options = ReadOptions {
            time_index: 1,
            ..ReadOptions::default()
        };
        let loaded = read_with(&[("v.nrrd", &file)], &options).unwrap();
        assert_eq!(*loaded.volume.samples(), Samples::U8((6..12).collect()));
        assert_eq!(loaded.volume.metadata().time_points, 2);
        let found = loaded.volume.grid().world_from_voxel();
        assert_eq!(found.matrix3, DMat3::from_diagonal(scale));
        if rest == placed {
            assert_eq!(found.translation, DVec3::new(10.0, -20.0, 5.0));
        }
    }
}

#[test]
fn an_origin_that_is_not_known_is_zero_with_a_note() {
    let rest = "space: LPS\nspace directions: (2,0,0) (0,2,0) (0,0,3)\n";
    let header = format!("{U8}{rest}space origin: (nan,NaN, nan)\n");
    let loaded = read(&[("v.nrrd", &attached(&header, &[1, 2, 3, 4, 5, 6]))]).unwrap();
    assert_eq!(
        loaded.volume.grid().world_from_voxel().translation,
        DVec3::ZERO
    );
    assert!(
        loaded.notes[0].contains("space origin"),
        "{:?}",
        loaded.notes
    );
    let half = format!("{U8}{rest}space origin: (nan,1,2)\n");
    assert!(message(&[("v.nrrd", &attached(&half, &[1, 2, 3, 4, 5, 6]))]).contains("finite"));
    let marked = [b"\xEF\xBB\xBF", &attached(U8, &[1, 2, 3, 4, 5, 6])[..]].concat();
    assert_eq!(
        *read(&[("v.nrrd", &marked)]).unwrap().volume.samples(),
        Samples::U8((1..=6).collect())
    );
}

#[test]
fn whole_numbers_of_64_bits_are_read_where_they_fit() {
    for (name, least) in [
        ("int64", -3i64),
        ("long long", -3),
        ("unsigned long long", 0),
    ] {
        let header = U8.replace("uint8", name) + "endian: little\n";
        let data: Vec<u8> = (least..least + 6).flat_map(|v| v.to_le_bytes()).collect();
        let loaded = read(&[("v.nrrd", &attached(&header, &data))]).unwrap();
        let expected = (least as i32..least as i32 + 6).collect();
        assert_eq!(*loaded.volume.samples(), Samples::I32(expected), "{name}");
    }
}

#[test]
fn vectors_lie_along_any_axis() {
    let read_one = |header: &str, component, time_index| {
        let options = ReadOptions {
            component,
            time_index,
            ..ReadOptions::default()
        };
        read_with(
            &[("v.nrrd", &attached(header, &(0..24).collect::<Vec<u8>>()))],
            &options,
        )
    };
    let start = "NRRD0004\ntype: uint8\nencoding: raw\n";
    // Two numbers, then x, y and two times.
    let first =
        format!("{start}dimension: 5\nsizes: 2 2 3 1 2\nkinds: vector domain domain domain time\n");
    let loaded = read_one(&first, Some(1), 1).unwrap();
    assert_eq!(
        *loaded.volume.samples(),
        Samples::U8((0..6).map(|i| 12 + 2 * i + 1).collect())
    );
    let asked = read_one(&first, None, 0).unwrap_err().to_string();
    assert!(
        asked.contains("pick one of its components, 0 to 1"),
        "{asked}"
    );
    // The times in front, the numbers behind.
    let last =
        format!("{start}dimension: 5\nsizes: 2 2 3 1 2\nkinds: time domain domain domain vector\n");
    let loaded = read_one(&last, Some(1), 0).unwrap();
    assert_eq!(
        *loaded.volume.samples(),
        Samples::U8((0..6).map(|i| 12 + 2 * i).collect())
    );
    let color =
        format!("{start}dimension: 4\nsizes: 4 2 3 1\nkinds: RGBA-color domain domain domain\n");
    let loaded = read_one(&color, None, 0).unwrap();
    // 0.2126 · 4k + 0.7152 · (4k + 1) + 0.0722 · (4k + 2)
    let expected = (0..6)
        .map(|k| (4.0 * f64::from(k) + 0.8596).round() as u8)
        .collect();
    assert_eq!(*loaded.volume.samples(), Samples::U8(expected));
}
