//! The volume crate from outside: files in, volumes out, and back.

mod crashes;
mod dicom;
mod hostile;
mod labels;
mod mesh;
mod metaimage;
mod mgh;
mod mrc;
mod nifti;
mod nrrd;
mod real_files;
mod round_trip;
mod slices;
mod tiff;
mod vtk;

use glam::DAffine3;
use strahl_volume::read::{LoadedVolume, MemoryFiles, ReadOptions, read_file};
use strahl_volume::{Error, Samples};

/// Reads the first of `files`; the others lie beside it.
fn read_with(files: &[(&str, &[u8])], options: &ReadOptions) -> Result<LoadedVolume, Error> {
    let folder: MemoryFiles = files
        .iter()
        .map(|&(name, bytes)| (name.to_owned(), bytes.to_vec()))
        .collect();
    read_file(files[0].0, &folder, options)
}

fn read(files: &[(&str, &[u8])]) -> Result<LoadedVolume, Error> {
    read_with(files, &ReadOptions::default())
}

/// The message of the error that reading must give.
fn message(files: &[(&str, &[u8])]) -> String {
    match read(files) {
        Ok(loaded) => panic!("{} was read as {:?}", files[0].0, loaded.volume.header()),
        Err(error) => error.to_string(),
    }
}

/// Compares within `tolerance` of the largest number.
#[track_caller]
fn assert_affine(found: DAffine3, expected: DAffine3, tolerance: f64) {
    let (found, expected) = (found.to_cols_array(), expected.to_cols_array());
    let largest = expected.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    for (f, e) in found.iter().zip(expected) {
        assert!(
            (f - e).abs() <= tolerance * largest,
            "{found:?} is not {expected:?}"
        );
    }
}

/// The bits of the samples, so that NaN equals itself.
fn bits(samples: &Samples) -> (strahl_volume::SampleType, Vec<u8>) {
    (samples.sample_type(), samples.as_bytes().to_vec())
}

fn gzip(data: &[u8]) -> Vec<u8> {
    use std::io::Write;
    let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    packer.write_all(data).unwrap();
    packer.finish().unwrap()
}
