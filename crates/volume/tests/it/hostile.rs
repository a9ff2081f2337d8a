//! Files that are cut off, empty, or lie. Each must be an error, fast, without memory for what a
//! header merely claims.

use crate::nifti::NiftiFile;
use crate::{gzip, message, read};
use strahl_volume::ErrorKind;
use strahl_volume::read::{Bytes, Files, MemoryFiles, ReadOptions, read_file, read_folder};

fn small_files() -> Vec<(&'static str, Vec<u8>)> {
    let nifti1 = NiftiFile::default();
    let nifti2 = NiftiFile {
        version: 2,
        vox_offset: 544.0,
        ..NiftiFile::default()
    };
    let nrrd = |encoding: &str, data: &[u8]| {
        let header = format!(
            "NRRD0004\ntype: uint8\ndimension: 3\nspace: LPS\nsizes: 2 3 1\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nencoding: {encoding}\n\n"
        );
        [header.as_bytes(), data].concat()
    };
    let mha = [
        &b"NDims = 3\nDimSize = 2 3 1\nElementSpacing = 1 1 1\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n"[..],
        &[1, 2, 3, 4, 5, 6],
    ]
    .concat();
    vec![
        ("v.nii", nifti1.bytes()),
        ("v.nii.gz", gzip(&nifti1.bytes())),
        ("w.nii", nifti2.bytes()),
        ("v.nrrd", nrrd("raw", &[1, 2, 3, 4, 5, 6])),
        ("w.nrrd", nrrd("gzip", &gzip(&[1, 2, 3, 4, 5, 6]))),
        ("x.nrrd", nrrd("hex", b"010203040506")),
        ("v.mha", mha.clone()),
        ("v.mha.gz", gzip(&mha)),
        ("v.tif", crate::tiff::small()),
        ("v.png", crate::slices::png(2, 3, &[1, 2, 3, 4, 5, 6])),
    ]
}

#[test]
fn every_prefix_of_a_file_is_an_error() {
    for (name, file) in small_files() {
        assert!(read(&[(name, &file)]).is_ok(), "{name}");
        for length in 0..file.len() {
            let error = match read(&[(name, &file[..length])]) {
                Ok(_) => panic!("{name} cut to {length} of {} bytes was read", file.len()),
                Err(error) => error.to_string(),
            };
            assert!(error.starts_with(name), "{error}");
        }
    }
}

#[test]
fn every_single_changed_byte_is_an_error_or_a_volume() {
    for (name, file) in small_files() {
        for at in 0..file.len() {
            for change in [0x01, 0x80, 0xff] {
                let mut changed = file.clone();
                changed[at] ^= change;
                // Either is right; a panic or an endless loop is not.
                let _ = read(&[(name, &changed)]);
            }
        }
    }
}

#[test]
fn an_empty_or_unknown_file_says_so() {
    let empty = message(&[("v.nii", b"")]);
    assert!(
        empty.contains("v.nii") && empty.contains("empty"),
        "{empty}"
    );
    let unknown = message(&[("v.xyz", b"hello, world")]);
    assert!(
        unknown.contains("hello") && unknown.contains("NRRD"),
        "{unknown}"
    );
    let missing = read_file("v.nii", &MemoryFiles::new(), &ReadOptions::default()).unwrap_err();
    assert!(missing.to_string().starts_with("v.nii: "), "{missing}");
    let zip = message(&[("v.zip", b"PK\x03\x04and so on")]);
    assert!(
        zip.contains("zip archive") && zip.contains("unpack"),
        "{zip}"
    );
    let folder = read_folder("scans", &MemoryFiles::new(), &ReadOptions::default()).unwrap_err();
    let folder = folder.to_string();
    assert!(
        folder.starts_with("scans: ") && folder.contains("the folder is empty"),
        "{folder}"
    );
}

#[test]
fn nifti_headers_that_lie_are_refused_with_the_field_named() {
    let base = NiftiFile::default();
    let nan = f64::NAN;
    let cases: Vec<(NiftiFile, &str)> = vec![
        (
            NiftiFile {
                dim: vec![0],
                ..base.clone()
            },
            "dim[0]",
        ),
        (
            NiftiFile {
                dim: vec![8, 1, 1, 1],
                ..base.clone()
            },
            "dim[0]",
        ),
        (
            NiftiFile {
                dim: vec![3, 2, 0, 1],
                ..base.clone()
            },
            "dim[2] is 0",
        ),
        (
            NiftiFile {
                dim: vec![3, 2, -3, 1],
                ..base.clone()
            },
            "dim[2] is -3",
        ),
        (
            NiftiFile {
                dim: vec![3, 2, 3, 4],
                ..base.clone()
            },
            "cut off",
        ),
        (
            NiftiFile {
                dim: vec![3, 32767, 32767, 32767],
                ..base.clone()
            },
            "cut off",
        ),
        (
            NiftiFile {
                datatype: 77,
                ..base.clone()
            },
            "datatype is 77",
        ),
        (
            NiftiFile {
                srow: [[nan; 4]; 3],
                ..base.clone()
            },
            "not finite",
        ),
        (
            NiftiFile {
                srow: [[0.0; 4]; 3],
                ..base.clone()
            },
            "cannot be inverted",
        ),
        (
            NiftiFile {
                srow: [
                    [1.0, 2.0, 0.0, 0.0],
                    [1.0, 2.0, 0.0, 0.0],
                    [0.0, 0.0, 1.0, 0.0],
                ],
                ..base.clone()
            },
            "cannot be inverted",
        ),
        (
            NiftiFile {
                sform_code: 0,
                qform_code: 1,
                quatern: [nan; 3],
                ..base.clone()
            },
            "not finite",
        ),
        (
            NiftiFile {
                sform_code: 0,
                pixdim: [1.0, nan, 1.0, 1.0],
                ..base.clone()
            },
            "not finite",
        ),
    ];
    for (file, part) in cases {
        let message = message(&[("v.nii", &file.bytes())]);
        assert!(
            message.starts_with("v.nii: ") && message.contains(part),
            "{message}"
        );
    }
    for offset in [nan, -1.0, f64::INFINITY] {
        let mut file = base.bytes();
        file[108..112].copy_from_slice(&(offset as f32).to_le_bytes());
        let message = message(&[("v.nii", &file)]);
        assert!(message.contains("vox_offset"), "{message}");
    }
    let huge = NiftiFile {
        version: 2,
        vox_offset: 544.0,
        dim: vec![4, i64::MAX, i64::MAX, i64::MAX, i64::MAX],
        ..base
    };
    let message = message(&[("v.nii", &huge.bytes())]);
    assert!(message.contains("dim is"), "{message}");
}

#[test]
fn a_bomb_costs_no_memory() {
    // 64 MiB of zeros behind a header that promises 12 bytes, and behind one that promises 8 GiB.
    let mut file = NiftiFile::default().bytes();
    file.resize(64 << 20, 0);
    let loaded = read(&[("v.nii.gz", &gzip(&file))]).unwrap();
    assert_eq!(loaded.volume.samples().len(), 6);

    let claims_more = NiftiFile {
        dim: vec![3, 2048, 2048, 1024],
        ..NiftiFile::default()
    };
    let error = read(&[("v.nii.gz", &gzip(&claims_more.bytes()))]).unwrap_err();
    assert!(
        matches!(error.kind(), ErrorKind::Truncated { found, .. } if *found < 1 << 20),
        "{error}"
    );

    let header = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 3 1\nencoding: gzip\n\n";
    let bomb = [header.as_bytes(), &gzip(&vec![0; 64 << 20])].concat();
    let message = message(&[("v.nrrd", &bomb)]);
    assert!(message.contains("more than the 6 bytes"), "{message}");
}

/// Bytes that claim to be many: a sparse file of 8 TiB would look like this.
struct Endless;

impl Bytes for Endless {
    fn len(&self) -> u64 {
        1 << 43
    }

    fn read_at(&self, _: u64, into: &mut [u8]) -> std::io::Result<()> {
        into.fill(b'x');
        Ok(())
    }
}

impl Files for Endless {
    fn names(&self) -> Vec<String> {
        vec!["v".into()]
    }

    fn open(&self, _: &str) -> std::io::Result<Box<dyn Bytes + '_>> {
        Ok(Box::new(Endless))
    }
}

#[test]
fn a_huge_file_of_nothing_known_is_refused_at_once() {
    let error = read_file("v", &Endless, &ReadOptions::default()).unwrap_err();
    assert!(error.to_string().contains("xxxx"), "{error}");
}

#[test]
fn a_text_header_without_an_end_is_refused() {
    let endless_line = [&b"NRRD0004\ncontent: "[..], &vec![b'x'; 1 << 20]].concat();
    let error = message(&[("v.nrrd", &endless_line)]);
    assert!(error.contains("header line"), "{error}");
    let mut endless_lines = b"NDims = 3\n".to_vec();
    for i in 0..2_000_000 {
        endless_lines.extend(format!("Key{i} = x\n").bytes());
    }
    let error = message(&[("v.mha", &endless_lines)]);
    assert!(error.contains("text header"), "{error}");
}
