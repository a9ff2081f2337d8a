//! NIfTI and Analyze headers made byte by byte, so that the reader's table is checked against
//! another hand than the writer's.

use crate::{assert_affine, gzip, message, read, read_with};
use glam::{DAffine3, DMat3, DQuat, DVec3};
use strahl_volume::read::ReadOptions;
use strahl_volume::{Label, Rescale, Samples};

#[derive(Clone)]
pub struct NiftiFile {
    pub big: bool,
    pub version: u8,
    pub pair: bool,
    pub dim: Vec<i64>,
    pub datatype: i16,
    pub pixdim: [f64; 4],
    pub vox_offset: f64,
    pub slope: f64,
    pub inter: f64,
    pub units: u8,
    pub intent: i16,
    pub qform_code: i16,
    pub sform_code: i16,
    pub quatern: [f64; 3],
    pub qoffset: [f64; 3],
    pub srow: [[f64; 4]; 3],
    pub data: Vec<u8>,
}

impl Default for NiftiFile {
    fn default() -> NiftiFile {
        NiftiFile {
            big: false,
            version: 1,
            pair: false,
            dim: vec![3, 2, 3, 1],
            datatype: 4,
            pixdim: [1.0, 2.0, 3.0, 4.0],
            vox_offset: 352.0,
            slope: 0.0,
            inter: 0.0,
            units: 2,
            intent: 0,
            qform_code: 0,
            sform_code: 1,
            quatern: [0.0; 3],
            qoffset: [0.0; 3],
            srow: [
                [2.0, 0.0, 0.0, -10.0],
                [0.0, 3.0, 0.0, -20.0],
                [0.0, 0.0, 4.0, -30.0],
            ],
            data: (1..=6i16).flat_map(|v| v.to_le_bytes()).collect(),
        }
    }
}

impl NiftiFile {
    pub fn header(&self) -> Vec<u8> {
        let mut head = vec![0u8; if self.version == 2 { 540 } else { 348 }];
        let mut put = |at: usize, mut bytes: Vec<u8>| {
            if self.big {
                bytes.reverse();
            }
            head[at..at + bytes.len()].copy_from_slice(&bytes);
        };
        let i16s = |v: i64| (v as i16).to_le_bytes().to_vec();
        let i32s = |v: i64| (v as i32).to_le_bytes().to_vec();
        let i64s = |v: i64| v.to_le_bytes().to_vec();
        let f32s = |v: f64| (v as f32).to_le_bytes().to_vec();
        let f64s = |v: f64| v.to_le_bytes().to_vec();
        if self.version == 2 {
            put(0, i32s(540));
            put(12, i16s(self.datatype.into()));
            for i in 0..8 {
                put(16 + 8 * i, i64s(self.dim.get(i).copied().unwrap_or(1)));
            }
            for i in 0..4 {
                put(104 + 8 * i, f64s(self.pixdim[i]));
                for row in 0..3 {
                    put(400 + 32 * row + 8 * i, f64s(self.srow[row][i]));
                }
            }
            put(168, i64s(self.vox_offset as i64));
            put(176, f64s(self.slope));
            put(184, f64s(self.inter));
            put(344, i32s(self.qform_code.into()));
            put(348, i32s(self.sform_code.into()));
            for i in 0..3 {
                put(352 + 8 * i, f64s(self.quatern[i]));
                put(376 + 8 * i, f64s(self.qoffset[i]));
            }
            put(500, i32s(self.units.into()));
            put(504, i32s(self.intent.into()));
            let magic: &[u8] = if self.pair {
                b"ni2\0\r\n\x1a\n"
            } else {
                b"n+2\0\r\n\x1a\n"
            };
            head[4..12].copy_from_slice(magic);
            head[240..248].copy_from_slice(b"made up\0");
        } else {
            put(0, i32s(348));
            for i in 0..8 {
                put(40 + 2 * i, i16s(self.dim.get(i).copied().unwrap_or(1)));
            }
            put(68, i16s(self.intent.into()));
            put(70, i16s(self.datatype.into()));
            for i in 0..4 {
                put(76 + 4 * i, f32s(self.pixdim[i]));
                for row in 0..3 {
                    put(280 + 16 * row + 4 * i, f32s(self.srow[row][i]));
                }
            }
            put(108, f32s(self.vox_offset));
            put(112, f32s(self.slope));
            put(116, f32s(self.inter));
            put(252, i16s(self.qform_code.into()));
            put(254, i16s(self.sform_code.into()));
            for i in 0..3 {
                put(256 + 4 * i, f32s(self.quatern[i]));
                put(268 + 4 * i, f32s(self.qoffset[i]));
            }
            head[123] = self.units;
            head[148..156].copy_from_slice(b"made up\0");
            head[344..348].copy_from_slice(if self.pair { b"ni1\0" } else { b"n+1\0" });
        }
        head
    }

    pub fn bytes(&self) -> Vec<u8> {
        let mut file = self.header();
        file.resize(self.vox_offset as usize, 0);
        file.extend(&self.data);
        file
    }
}

const EXPECTED: [i16; 6] = [1, 2, 3, 4, 5, 6];

fn big_data() -> Vec<u8> {
    EXPECTED.iter().flat_map(|v| v.to_be_bytes()).collect()
}

fn sform() -> DAffine3 {
    DAffine3::from_mat3_translation(
        DMat3::from_diagonal(DVec3::new(2.0, 3.0, 4.0)),
        DVec3::new(-10.0, -20.0, -30.0),
    )
}

#[test]
fn both_versions_and_byte_orders_in_one_file_and_in_a_pair_packed_and_not() {
    for version in [1, 2] {
        for big in [false, true] {
            for pair in [false, true] {
                let first = if version == 2 { 544.0 } else { 352.0 };
                let file = NiftiFile {
                    version,
                    big,
                    pair,
                    vox_offset: if pair { 0.0 } else { first },
                    data: if big {
                        big_data()
                    } else {
                        NiftiFile::default().data
                    },
                    ..NiftiFile::default()
                };
                let head = file.header();
                let plain = if pair {
                    vec![("v.hdr", head.clone()), ("v.img", file.data.clone())]
                } else {
                    vec![("v.nii", file.bytes())]
                };
                let packed = if pair {
                    vec![("v.hdr.gz", gzip(&head)), ("v.img.gz", gzip(&file.data))]
                } else {
                    // The name says nothing about packing.
                    vec![("volume", gzip(&file.bytes()))]
                };
                for files in [plain, packed] {
                    let files: Vec<(&str, &[u8])> =
                        files.iter().map(|(n, b)| (*n, b.as_slice())).collect();
                    let loaded = read(&files).unwrap();
                    let volume = &loaded.volume;
                    assert_eq!(*volume.samples(), Samples::I16(EXPECTED.to_vec()));
                    assert_eq!(volume.grid().dims(), [2, 3, 1]);
                    assert_eq!(volume.grid().world_from_voxel(), sform());
                    assert_eq!(volume.metadata().format, format!("NIfTI-{version}"));
                    assert!(volume.metadata().has_length_unit);
                    assert_eq!(volume.metadata().time_points, 1);
                    assert_eq!(
                        volume.metadata().entries[0],
                        ("description".into(), "made up".into())
                    );
                    assert_eq!(loaded.notes, Vec::<String>::new());
                }
            }
        }
    }
}

#[test]
fn the_img_of_a_pair_leads_to_its_header() {
    let file = NiftiFile {
        pair: true,
        vox_offset: 0.0,
        ..NiftiFile::default()
    };
    let loaded = read(&[("v.img", &file.data), ("v.hdr", &file.header())]).unwrap();
    assert_eq!(*loaded.volume.samples(), Samples::I16(EXPECTED.to_vec()));
    let message = message(&[("v.hdr", &file.header())]);
    assert!(
        message.contains("v.hdr") && message.contains("v.img"),
        "{message}"
    );
}

#[test]
fn the_sform_counts_before_the_qform_and_the_qform_before_the_spacings() {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let mut file = NiftiFile {
        quatern: [0.0, 0.0, half],
        qoffset: [7.0, 8.0, 9.0],
        qform_code: 1,
        sform_code: 2,
        ..NiftiFile::default()
    };
    let affine = |file: &NiftiFile| {
        read(&[("v.nii", &file.bytes())])
            .unwrap()
            .volume
            .grid()
            .world_from_voxel()
    };
    assert_eq!(affine(&file), sform());
    file.sform_code = 0;
    // A quarter turn about z: x runs along y, y along −x.
    let turned = DAffine3::from_cols(
        DVec3::new(0.0, 2.0, 0.0),
        DVec3::new(-3.0, 0.0, 0.0),
        DVec3::new(0.0, 0.0, 4.0),
        DVec3::new(7.0, 8.0, 9.0),
    );
    assert_affine(affine(&file), turned, 1e-7);
    // qfac −1 turns the last axis round; 0 means 1.
    file.pixdim[0] = -1.0;
    let mut mirrored = turned;
    mirrored.matrix3.z_axis = DVec3::new(0.0, 0.0, -4.0);
    assert_affine(affine(&file), mirrored, 1e-7);
    file.pixdim[0] = 0.0;
    assert_affine(affine(&file), turned, 1e-7);
    // Nothing set: about the center of the grid, x to the left, as nibabel does.
    file.qform_code = 0;
    let centered = DAffine3::from_mat3_translation(
        DMat3::from_diagonal(DVec3::new(-2.0, 3.0, 4.0)),
        DVec3::new(1.0, -3.0, 0.0),
    );
    assert_eq!(affine(&file), centered);
    let notes = read(&[("v.nii", &file.bytes())]).unwrap().notes;
    assert!(
        notes[0].contains("sform_code and qform_code are 0"),
        "{notes:?}"
    );
}

#[test]
fn quaternions_are_normalized() {
    let oblique = DQuat::from_euler(glam::EulerRot::XYZ, 0.3, -0.8, 1.9);
    let with = |quatern: [f64; 3]| {
        let file = NiftiFile {
            quatern,
            pixdim: [1.0; 4],
            qform_code: 1,
            sform_code: 0,
            ..NiftiFile::default()
        };
        read(&[("v.nii", &file.bytes())])
            .unwrap()
            .volume
            .grid()
            .world_from_voxel()
            .matrix3
    };
    let m = with([oblique.x, oblique.y, oblique.z]);
    assert!(m.abs_diff_eq(DMat3::from_quat(oblique), 1e-6));
    // Too long for a unit quaternion: a half turn about the same direction, still a rotation.
    let m = with([0.9, 0.9, 0.0]);
    let axis = DVec3::new(1.0, 1.0, 0.0).normalize();
    assert!(m.abs_diff_eq(DMat3::from_axis_angle(axis, std::f64::consts::PI), 1e-6));
    assert!((m.determinant() - 1.0).abs() < 1e-12);
}

#[test]
fn units_become_millimeters() {
    for (units, factor, known) in [
        (0, 1.0, false),
        (1, 1000.0, true),
        (2, 1.0, true),
        (3, 1e-3, true),
        (2 | 8, 1.0, true),
    ] {
        let file = NiftiFile {
            units,
            ..NiftiFile::default()
        };
        let volume = read(&[("v.nii", &file.bytes())]).unwrap().volume;
        let spacing = volume.grid().spacing_mm();
        assert!((spacing - DVec3::new(2.0, 3.0, 4.0) * factor).length() < 1e-9);
        let first = volume.grid().world_from_voxel().translation;
        assert!((first - DVec3::new(-10.0, -20.0, -30.0) * factor).length() < 1e-9);
        assert_eq!(volume.metadata().has_length_unit, known);
    }
}

#[test]
fn a_slope_of_0_or_nan_means_none() {
    let rescale = |slope, inter| {
        let file = NiftiFile {
            slope,
            inter,
            ..NiftiFile::default()
        };
        read(&[("v.nii", &file.bytes())]).unwrap()
    };
    for slope in [0.0, f64::NAN, f64::INFINITY] {
        assert_eq!(rescale(slope, 5.0).volume.rescale(), Rescale::IDENTITY);
    }
    assert_eq!(rescale(0.5, -7.0).volume.rescale(), Rescale::new(0.5, -7.0));
    let broken = rescale(2.0, f64::NAN);
    assert_eq!(broken.volume.rescale(), Rescale::new(2.0, 0.0));
    assert!(broken.notes[0].contains("scl_inter"), "{:?}", broken.notes);
}

#[test]
fn a_time_point_is_picked_from_four_dimensions() {
    let mut file = NiftiFile {
        dim: vec![4, 2, 1, 1, 3],
        ..NiftiFile::default()
    };
    for packed in [false, true] {
        let bytes = if packed {
            gzip(&file.bytes())
        } else {
            file.bytes()
        };
        for time_index in 0..3 {
            let options = ReadOptions {
                time_index,
                ..ReadOptions::default()
            };
            let loaded = read_with(&[("v.nii", &bytes)], &options).unwrap();
            let first = 2 * time_index as i16 + 1;
            assert_eq!(
                *loaded.volume.samples(),
                Samples::I16(vec![first, first + 1])
            );
            assert_eq!(loaded.volume.metadata().time_points, 3);
            assert_eq!(loaded.volume.metadata().time_index, time_index);
        }
        let options = ReadOptions {
            time_index: 3,
            ..ReadOptions::default()
        };
        let error = read_with(&[("v.nii", &bytes)], &options)
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("time point is 3") && error.contains("0 to 2"),
            "{error}"
        );
    }
    file.dim = vec![5, 2, 1, 1, 1, 3];
    let message = message(&[("v.nii", &file.bytes())]);
    assert!(message.contains("3 numbers per voxel"), "{message}");
    file.dim = vec![6, 2, 1, 1, 1, 1, 3];
    let message = crate::message(&[("v.nii", &file.bytes())]);
    assert!(message.contains("dim[6] = 3"), "{message}");
}

#[test]
fn an_intent_of_labels_is_told() {
    let labels = |intent| {
        let file = NiftiFile {
            intent,
            ..NiftiFile::default()
        };
        read(&[("v.nii", &file.bytes())]).unwrap().labels
    };
    assert_eq!(labels(1002), Some(vec![]));
    assert_eq!(labels(0), None);
}

/// A file with extensions between header and samples: the code and the content of each.
fn extended(file: &NiftiFile, extender: u8, extensions: &[(i32, &str)]) -> Vec<u8> {
    let word = |number: i32| match file.big {
        true => number.to_be_bytes(),
        false => number.to_le_bytes(),
    };
    let mut head = vec![extender, 0, 0, 0];
    for (code, content) in extensions {
        let size = (8 + content.len()).next_multiple_of(16);
        let end = head.len() + size;
        head.extend(word(size as i32).into_iter().chain(word(*code)));
        head.extend(content.as_bytes());
        head.resize(end, 0);
    }
    let mut bytes = file.header();
    let start = bytes.len();
    bytes.extend(head);
    let place: &[u8] = match (file.version, file.big) {
        (2, true) => &(bytes.len() as i64).to_be_bytes(),
        (2, false) => &(bytes.len() as i64).to_le_bytes(),
        (_, true) => &(bytes.len() as f32).to_be_bytes(),
        (_, false) => &(bytes.len() as f32).to_le_bytes(),
    };
    let at = if start == 540 { 168 } else { 108 };
    bytes[at..at + place.len()].copy_from_slice(place);
    bytes.extend(&file.data);
    bytes
}

#[test]
fn extensions_name_labels() {
    let caret = "<?xml version=\"1.0\"?><CaretExtension><VolumeInformation Index=\"0\"><LabelTable>\
        <Label Key=\"2\" Red=\"1\" Green=\"0.5\" Blue=\"0\" Alpha=\"1\"><![CDATA[left <lung>]]></Label>\
        </LabelTable></VolumeInformation></CaretExtension>";
    let of_caret = vec![Label {
        color: Some([1.0, 0.5, 0.0]),
        ..Label::new(2, "left <lung>")
    }];
    let comment = "1 Area 3b (PostCG)\n\n 4  hOc1\n";
    let of_comment = vec![Label::new(1, "Area 3b (PostCG)"), Label::new(4, "hOc1")];
    for (version, big) in [(1, false), (1, true), (2, false), (2, true)] {
        let named = |intent, extensions: &[(i32, &str)]| {
            let mut data: Vec<i16> = vec![1, 2, 3, 4, 5, 6];
            if big {
                data.iter_mut().for_each(|n| *n = n.swap_bytes());
            }
            let file = NiftiFile {
                big,
                version,
                intent,
                data: data.iter().flat_map(|n| n.to_le_bytes()).collect(),
                ..NiftiFile::default()
            };
            let bytes = extended(&file, 1, extensions);
            let packed = gzip(&bytes);
            let [plain, packed] = [("v.nii", bytes), ("v.nii.gz", packed)].map(|(name, bytes)| {
                let loaded = read(&[(name, &bytes)]).unwrap();
                assert_eq!(*loaded.volume.samples(), Samples::I16(EXPECTED.to_vec()));
                assert_eq!(loaded.notes, [""; 0]);
                loaded.labels
            });
            assert_eq!(plain, packed);
            plain
        };
        // Caret's table says that the numbers are ids; a comment may begin with any number.
        assert_eq!(
            named(0, &[(6, "by hand"), (30, caret)]),
            Some(of_caret.clone())
        );
        assert_eq!(named(1002, &[(0, caret)]), Some(of_caret.clone()));
        assert_eq!(named(1002, &[(6, comment)]), Some(of_comment.clone()));
        assert_eq!(named(0, &[(6, comment)]), None);
        assert_eq!(named(1002, &[(6, "made in May")]), Some(vec![]));
    }
}

#[test]
fn extensions_that_are_broken_cost_their_names_only() {
    let file = NiftiFile {
        intent: 1002,
        ..NiftiFile::default()
    };
    let read = |bytes: Vec<u8>| {
        let loaded = read(&[("v.nii", &bytes)]).unwrap();
        assert_eq!(*loaded.volume.samples(), Samples::I16(EXPECTED.to_vec()));
        (loaded.labels, loaded.notes)
    };
    let none = Some(vec![]);
    let (labels, notes) = read(extended(&file, 1, &[(6, "1 a\n2 b\n1 c")]));
    assert_eq!(labels, none);
    assert_eq!(
        notes,
        [
            "the names of labels in the header are not used: line 3: the id is 1, as in line 1; allowed: each id once"
        ]
    );
    // Names without the words of an extension, as some have them.
    let mut bytes = extended(&file, 0, &[(6, "")]);
    bytes[352..368].copy_from_slice(b"7 a thing\n\n8 b\n ");
    let named = vec![Label::new(7, "a thing"), Label::new(8, "b")];
    assert_eq!(read(bytes.clone()), (Some(named), vec![]));
    // The same taken for an extension that is longer than the file.
    bytes[348] = 1;
    assert_eq!(read(bytes.clone()), (none.clone(), vec![]));
    for size in [0i32, 7, 8, -1] {
        bytes[352..356].copy_from_slice(&size.to_le_bytes());
        assert_eq!(read(bytes.clone()), (none.clone(), vec![]));
    }
}

#[test]
fn what_cannot_be_read_is_named() {
    for (datatype, name) in [(32, "complex64"), (1536, "float128"), (1, "binary")] {
        let file = NiftiFile {
            datatype,
            ..NiftiFile::default()
        };
        let message = message(&[("v.nii", &file.bytes())]);
        assert!(
            message.contains(name) && message.contains("v.nii") && message.contains("write"),
            "{message}"
        );
    }
}

#[test]
fn analyze_is_read_about_its_origin_or_its_center() {
    let file = NiftiFile {
        vox_offset: 0.0,
        ..NiftiFile::default()
    };
    let mut header = file.header();
    header[344..348].fill(0);
    header[38] = b'r';
    header[252..270].fill(0);
    let read_analyze = |header: &[u8]| read(&[("v.hdr", header), ("v.img", &file.data)]).unwrap();
    let centered = read_analyze(&header);
    assert_eq!(centered.volume.metadata().format, "Analyze 7.5");
    assert_eq!(*centered.volume.samples(), Samples::I16(EXPECTED.to_vec()));
    assert!(
        centered.notes.iter().any(|note| note.contains("left")),
        "{:?}",
        centered.notes
    );
    assert_eq!(
        centered.volume.grid().world_from_voxel().translation,
        DVec3::new(1.0, -3.0, 0.0)
    );
    // SPM's origin: voxel (2, 3, 1) counted from 1.
    header[253] = 2;
    header[255] = 3;
    header[257] = 1;
    let placed = read_analyze(&header);
    assert_eq!(
        placed.volume.grid().world_from_voxel().translation,
        DVec3::new(2.0, -6.0, 0.0)
    );
}

#[test]
fn an_sform_that_places_nothing_gives_way() {
    let file = NiftiFile {
        srow: [[0.0; 4]; 3],
        qform_code: 1,
        qoffset: [10.0, -20.0, 5.0],
        ..NiftiFile::default()
    };
    let loaded = read(&[("v.nii", &file.bytes())]).unwrap();
    let expected = DAffine3::from_mat3_translation(
        DMat3::from_diagonal(DVec3::new(2.0, 3.0, 4.0)),
        DVec3::new(10.0, -20.0, 5.0),
    );
    assert_affine(loaded.volume.grid().world_from_voxel(), expected, 1e-7);
    assert!(
        loaded.notes[0].contains("the qform is taken"),
        "{:?}",
        loaded.notes
    );

    // A flat one as well, but not without a qform.
    let mut flat = file;
    flat.srow = [
        [1.0, 0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0, 0.0],
    ];
    assert!(read(&[("v.nii", &flat.bytes())]).is_ok());
    flat.qform_code = 0;
    assert!(message(&[("v.nii", &flat.bytes())]).contains("cannot be inverted"));
}

#[test]
fn lengths_of_zero_count_as_one() {
    let file = NiftiFile {
        dim: vec![5, 2, 3, 0, 0, 0],
        ..NiftiFile::default()
    };
    let loaded = read(&[("v.nii", &file.bytes())]).unwrap();
    assert_eq!(loaded.volume.grid().dims(), [2, 3, 1]);
    assert_eq!(loaded.volume.metadata().time_points, 1);
    assert!(
        loaded.notes[1].contains("dim[4] is 0"),
        "{:?}",
        loaded.notes
    );
    for dim in [vec![3, 0, 3, 1], vec![3, 2, 3, -1]] {
        let file = NiftiFile {
            dim,
            ..NiftiFile::default()
        };
        assert!(message(&[("v.nii", &file.bytes())]).contains("1 or more"));
    }
}

#[test]
fn a_packed_pair_is_known_by_either_part() {
    let file = NiftiFile {
        pair: true,
        vox_offset: 0.0,
        ..NiftiFile::default()
    };
    let (head, packed_head) = (file.header(), gzip(&file.header()));
    let (data, packed) = (file.data.clone(), gzip(&file.data));
    for files in [
        [("v.img.gz", &packed[..]), ("v.hdr.gz", &packed_head)],
        [("v.img.gz", &packed), ("v.hdr", &head)],
        [("v.img", &data), ("v.hdr.gz", &packed_head)],
    ] {
        let loaded = read(&files).unwrap();
        assert_eq!(*loaded.volume.samples(), Samples::I16(EXPECTED.to_vec()));
    }
}

#[test]
fn whole_numbers_of_64_bits_are_read_where_they_fit() {
    for (datatype, numbers, expected) in [
        (
            1024,
            [-3i64, 0, 1, 2, 3, 7],
            Samples::I32(vec![-3, 0, 1, 2, 3, 7]),
        ),
        (
            1280,
            [0, 0, 1, 2, 3, 4_000_000_000],
            Samples::U32(vec![0, 0, 1, 2, 3, 4_000_000_000]),
        ),
    ] {
        let file = NiftiFile {
            datatype,
            data: numbers.iter().flat_map(|v| v.to_le_bytes()).collect(),
            ..NiftiFile::default()
        };
        let loaded = read(&[("v.nii", &file.bytes())]).unwrap();
        assert_eq!(*loaded.volume.samples(), expected);
    }
    let file = NiftiFile {
        datatype: 1024,
        data: [i64::MAX; 6].iter().flat_map(|v| v.to_le_bytes()).collect(),
        ..NiftiFile::default()
    };
    let refused = message(&[("v.nii", &file.bytes())]);
    assert!(refused.contains("9223372036854775807"), "{refused}");
}

#[test]
fn colors_become_luminance_and_components_can_be_picked() {
    let with = |file: &NiftiFile, component| {
        let options = ReadOptions {
            component,
            ..ReadOptions::default()
        };
        read_with(&[("v.nii", &file.bytes())], &options)
    };
    // Red, green, blue, white, black, gray of 100.
    let colors = [
        [255, 0, 0],
        [0, 255, 0],
        [0, 0, 255],
        [255; 3],
        [0; 3],
        [100; 3],
    ];
    for (datatype, alpha) in [(128, &[][..]), (2304, &[7][..])] {
        let file = NiftiFile {
            datatype,
            data: colors.iter().flat_map(|c| [c, alpha].concat()).collect(),
            ..NiftiFile::default()
        };
        let loaded = with(&file, None).unwrap();
        assert_eq!(
            *loaded.volume.samples(),
            Samples::U8(vec![54, 182, 18, 255, 0, 100])
        );
        assert!(loaded.notes[0].contains("luminance"), "{:?}", loaded.notes);
        let green = with(&file, Some(1)).unwrap();
        assert_eq!(
            *green.volume.samples(),
            Samples::U8(vec![0, 255, 0, 255, 0, 100])
        );
        assert!(with(&file, Some(4)).is_err());
    }
    // A vector of two numbers at two times: the components are slowest.
    let vectors = NiftiFile {
        dim: vec![5, 2, 3, 1, 2, 2],
        data: (0..24i16).flat_map(|n| n.to_le_bytes()).collect(),
        ..NiftiFile::default()
    };
    let asked = with(&vectors, None).unwrap_err();
    assert!(asked.to_string().contains("0 to 1"), "{asked}");
    let options = ReadOptions {
        component: Some(1),
        time_index: 1,
        ..ReadOptions::default()
    };
    let loaded = read_with(&[("v.nii", &vectors.bytes())], &options).unwrap();
    assert_eq!(*loaded.volume.samples(), Samples::I16((18..24).collect()));
}
