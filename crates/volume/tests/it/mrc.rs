//! Maps of electron microscopes and NumPy archives, put together byte by byte.

use crate::{assert_affine, message, read, read_with};
use glam::{DAffine3, DMat3, DVec3};
use std::io::Write;
use strahl_volume::Samples;
use strahl_volume::read::ReadOptions;

/// A map of 3×2×2 voxels of 1, 2 and 4 Å.
fn map(is_big: bool, mode: i32, data: &[u8], change: impl Fn(&mut Vec<i32>)) -> Vec<u8> {
    let mut words = vec![0i32; 256];
    words[..4].copy_from_slice(&[3, 2, 2, mode]);
    words[7..10].copy_from_slice(&[3, 2, 2]);
    for (word, length) in words[10..16]
        .iter_mut()
        .zip([3.0f32, 4.0, 8.0, 90.0, 90.0, 90.0])
    {
        *word = length.to_bits() as i32;
    }
    words[16..19].copy_from_slice(&[1, 2, 3]);
    words[22] = 1;
    change(&mut words);
    let mut file: Vec<u8> = words
        .iter()
        .flat_map(|n| {
            if is_big {
                n.to_be_bytes()
            } else {
                n.to_le_bytes()
            }
        })
        .collect();
    file[208..212].copy_from_slice(b"MAP ");
    file[212..214].copy_from_slice(if is_big { &[0x11, 0x11] } else { &[0x44, 0x44] });
    file.extend(data);
    file
}

#[test]
fn maps_lie_where_their_cell_says() {
    let angstrom = 1e-7;
    for is_big in [false, true] {
        let data: Vec<u8> = (0..12i16)
            .flat_map(|n| {
                if is_big {
                    n.to_be_bytes()
                } else {
                    n.to_le_bytes()
                }
            })
            .collect();
        let file = map(is_big, 1, &data, |words| {
            words[4..7].copy_from_slice(&[1, -1, 0])
        });
        let loaded = read(&[("v.mrc", &file)]).unwrap();
        assert_eq!(*loaded.volume.samples(), Samples::I16((0..12).collect()));
        assert_eq!(loaded.volume.grid().dims(), [3, 2, 2]);
        let place = DAffine3::from_mat3_translation(
            DMat3::from_diagonal(DVec3::new(-1.0, -2.0, 4.0) * angstrom),
            DVec3::new(-1.0, 2.0, 0.0) * angstrom,
        );
        assert_affine(loaded.volume.grid().world_from_voxel(), place, 1e-12);
        assert!(loaded.notes.is_empty() && loaded.volume.metadata().has_length_unit);
    }
    // Columns along z, sections along x, behind an extended header, at an origin; 60° between x and y.
    let data: Vec<u8> = [vec![9; 80], (0..12).collect()].concat();
    let file = map(false, 0, &data, |words| {
        words[16..19].copy_from_slice(&[3, 2, 1]);
        words[23] = 80;
        words[15] = 60f32.to_bits() as i32;
        words[49] = 5f32.to_bits() as i32;
    });
    let loaded = read(&[("v.map", &file)]).unwrap();
    assert_eq!(*loaded.volume.samples(), Samples::I8((0..12).collect()));
    let half = 0.75f64.sqrt();
    let place = DAffine3::from_cols(
        DVec3::new(0.0, 0.0, 4.0) * angstrom,
        DVec3::new(-1.0, -2.0 * half, 0.0) * angstrom,
        DVec3::new(-1.0, 0.0, 0.0) * angstrom,
        DVec3::new(-5.0, 0.0, 0.0) * angstrom,
    );
    assert_affine(loaded.volume.grid().world_from_voxel(), place, 1e-7);
}

#[test]
fn types_and_stacks_of_maps() {
    let bytes: Vec<u8> = (250..=255).chain(0..6).collect();
    let unsigned = map(false, 0, &bytes, |words| {
        words[38] = i32::from_le_bytes(*b"IMOD")
    });
    let loaded = read(&[("v.mrc", &unsigned)]).unwrap();
    assert_eq!(*loaded.volume.samples(), Samples::U8(bytes.clone()));
    let half: Vec<u8> = [0x3C00u16; 12]
        .iter()
        .flat_map(|n| n.to_le_bytes())
        .collect();
    let loaded = read(&[("v.mrc", &map(false, 12, &half, |_| ()))]).unwrap();
    assert_eq!(*loaded.volume.samples(), Samples::F32(vec![1.0; 12]));
    let volumes = map(false, 0, &bytes, |words| (words[9], words[22]) = (1, 401));
    let options = ReadOptions {
        time_index: 1,
        ..ReadOptions::default()
    };
    let loaded = read_with(&[("v.mrc", &volumes)], &options).unwrap();
    assert_eq!(loaded.volume.grid().dims(), [3, 2, 1]);
    assert_eq!(*loaded.volume.samples(), Samples::I8((0..6).collect()));
    assert!(message(&[("v.mrc", &map(false, 4, &bytes, |_| ()))]).contains("MODE is 4"));
    assert!(message(&[("v.mrc", &map(false, 2, &bytes, |_| ()))]).contains("cut off"));
}

/// A ZIP file; `deflated` says how the arrays are packed.
fn zip(arrays: &[(&str, Vec<u8>)], deflated: bool) -> Vec<u8> {
    let (mut file, mut directory) = (Vec::new(), Vec::new());
    for (name, array) in arrays {
        let mut packed = array.clone();
        if deflated {
            let mut packer =
                flate2::write::DeflateEncoder::new(Vec::new(), flate2::Compression::fast());
            packer.write_all(array).unwrap();
            packed = packer.finish().unwrap();
        }
        let method = if deflated { 8u16 } else { 0 };
        let at = file.len() as u32;
        // numpy leaves the sizes to 64-bit numbers behind the name.
        file.extend(b"PK\x03\x04\x2d\0\0\0");
        file.extend(method.to_le_bytes());
        file.extend([0; 8]);
        file.extend([0xFF; 8]);
        file.extend((name.len() as u16).to_le_bytes());
        file.extend(20u16.to_le_bytes());
        file.extend(name.as_bytes());
        file.extend([0; 20]);
        file.extend(&packed);
        directory.extend(b"PK\x01\x02\x2d\x03\x2d\0\0\0");
        directory.extend(method.to_le_bytes());
        directory.extend([0; 8]);
        directory.extend((packed.len() as u32).to_le_bytes());
        directory.extend((array.len() as u32).to_le_bytes());
        directory.extend((name.len() as u16).to_le_bytes());
        directory.extend([0; 12]);
        directory.extend(at.to_le_bytes());
        directory.extend(name.as_bytes());
    }
    let start = file.len() as u32;
    file.extend(&directory);
    file.extend(b"PK\x05\x06\0\0\0\0");
    file.extend([(arrays.len() as u16).to_le_bytes(); 2].concat());
    file.extend((directory.len() as u32).to_le_bytes());
    file.extend(start.to_le_bytes());
    file.extend([0, 0]);
    file
}

fn npy(shape: &str, data: &[u8]) -> Vec<u8> {
    let header = format!("{{'descr': '|u1', 'fortran_order': False, 'shape': {shape}, }}\n");
    let length = (header.len() as u16).to_le_bytes();
    [b"\x93NUMPY\x01\0", &length[..], header.as_bytes(), data].concat()
}

#[test]
fn the_volume_of_an_archive_is_found() {
    let volume = npy("(1, 2, 3)", &[1, 2, 3, 4, 5, 6]);
    let affine = npy("(2, 2)", &[0; 4]);
    for deflated in [false, true] {
        let alone = zip(&[("arr_0.npy", volume.clone())], deflated);
        let loaded = read(&[("v.npz", &alone)]).unwrap();
        assert_eq!(*loaded.volume.samples(), Samples::U8((1..=6).collect()));
        assert_eq!(loaded.volume.grid().dims(), [3, 2, 1]);
        let both = zip(
            &[("affine.npy", affine.clone()), ("scan.npy", volume.clone())],
            deflated,
        );
        let loaded = read(&[("v.npz", &both)]).unwrap();
        assert_eq!(*loaded.volume.samples(), Samples::U8((1..=6).collect()));
        assert!(
            loaded.notes[0].contains("scan.npy is one of 2"),
            "{:?}",
            loaded.notes
        );
        let two = zip(
            &[("a.npy", volume.clone()), ("b.npy", volume.clone())],
            deflated,
        );
        assert!(message(&[("v.npz", &two)]).contains("2 arrays (a.npy, b.npy)"));
        for length in 0..alone.len() {
            assert!(read(&[("v.npz", &alone[..length])]).is_err(), "{length}");
        }
    }
}
