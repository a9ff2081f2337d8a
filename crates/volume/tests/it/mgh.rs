//! FreeSurfer volumes, put together byte by byte.

use crate::{assert_affine, gzip, message, read, read_with};
use glam::{DAffine3, DMat3, DVec3};
use strahl_volume::Samples;
use strahl_volume::read::ReadOptions;

/// Two frames of 2×3×4 samples that count up.
fn file(is_placed: bool, kind: i32, samples: &[u8]) -> Vec<u8> {
    let mut out = Vec::new();
    for number in [1, 2, 3, 4, 2, kind, 0] {
        out.extend(number.to_be_bytes());
    }
    out.extend([0, u8::from(is_placed)]);
    let place: [f32; 15] = [
        2.0, 2.0, 3.0, -1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0, 7.0, 8.0, 9.0,
    ];
    out.extend(place.iter().flat_map(|number| number.to_be_bytes()));
    out.resize(284, 0);
    out.extend(samples);
    // Parameters of the scan may follow.
    out.extend([1, 2, 3, 4]);
    out
}

fn shorts() -> Vec<u8> {
    (0..48i16).flat_map(|n| n.to_be_bytes()).collect()
}

#[test]
fn samples_and_place_are_those_of_freesurfer() {
    let options = ReadOptions {
        time_index: 1,
        ..ReadOptions::default()
    };
    let plain = file(true, 4, &shorts());
    for (name, file) in [("v.mgh", plain.clone()), ("v.mgz", gzip(&plain))] {
        let loaded = read_with(&[(name, &file)], &options).unwrap();
        assert_eq!(*loaded.volume.samples(), Samples::I16((24..48).collect()));
        assert_eq!(loaded.volume.metadata().time_points, 2);
        assert!(loaded.notes.is_empty());
        // Voxel (1, 1.5, 2) lies at (7, 8, 9).
        let matrix = DMat3::from_cols(
            DVec3::new(-2.0, 0.0, 0.0),
            DVec3::new(0.0, 0.0, -2.0),
            DVec3::new(0.0, 3.0, 0.0),
        );
        let place = DAffine3::from_mat3_translation(matrix, DVec3::new(9.0, 2.0, 12.0));
        assert_affine(loaded.volume.grid().world_from_voxel(), place, 1e-12);
    }
    let loaded = read(&[("v.mgh", &file(false, 4, &shorts()))]).unwrap();
    assert_eq!(loaded.volume.grid().orientation(), "LIA");
    assert!(loaded.notes[0].contains("coronal"), "{:?}", loaded.notes);
    let floats: Vec<u8> = (0..48).flat_map(|n| (n as f32).to_be_bytes()).collect();
    let loaded = read(&[("v.mgh", &file(true, 3, &floats))]).unwrap();
    assert_eq!(loaded.volume.value(1, 2, 3), 23.0);
}

#[test]
fn wrong_headers_are_refused() {
    let cut = file(true, 3, &[0; 50]);
    assert!(message(&[("v.mgh", &cut)]).contains("cut off"));
    let options = ReadOptions {
        time_index: 2,
        ..ReadOptions::default()
    };
    let file = file(true, 4, &shorts());
    let late = read_with(&[("v.mgh", &file)], &options).unwrap_err();
    assert!(late.to_string().contains("0 to 1"), "{late}");
}

#[test]
fn formats_that_are_not_read_are_named() {
    for (name, bytes, tool) in [
        ("v.mnc", &b"CDF\x01\0\0\0\0"[..], "mnc2nii"),
        ("w.mnc", b"\x89HDF\r\n\x1a\n\0\0", "mnc2nii"),
        ("v+orig.BRIK", b"\x05\x07\x09", "3dAFNItoNIFTI"),
        ("v.REC", b"\x05\x07\x09", "dcm2niix"),
        ("v.mif", b"mrtrix image\n", "mrconvert"),
        ("v.czi", b"ZISRAWFILE\0\0\0\0\0\0", "bfconvert"),
        ("v.jxl", b"\xff\x0a\x00", "djxl"),
    ] {
        let message = message(&[(name, bytes)]);
        assert!(
            message.contains(tool) && message.contains("not supported"),
            "{message}"
        );
    }
}
