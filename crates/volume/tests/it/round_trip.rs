//! What a writer wrote, its reader reads: the same voxels, the same place.

use crate::{assert_affine, bits};
use glam::{DAffine3, DMat3, DQuat, DVec3};
use proptest::prelude::*;
use strahl_volume::read::{LoadedVolume, RawLayout, ReadOptions, read_components, read_file};
use strahl_volume::write::{NewMemoryFiles, WriteOptions, write, write_components};
use strahl_volume::{
    Components, Error, Grid, Label, Metadata, Modality, Remedy, Rescale, Sample, SampleType,
    Samples, Volume, with_samples,
};

fn samples_of(sample_type: SampleType, bytes: &[u8], count: usize) -> Samples {
    let mut samples = Samples::new(sample_type);
    with_samples!(&mut samples, s => fill(s, bytes, count));
    samples
}

fn fill<T: Sample>(into: &mut Vec<T>, bytes: &[u8], count: usize) {
    let mut bytes = bytes.iter().copied().cycle();
    for _ in 0..count {
        let mut value = T::zeroed();
        for byte in bytemuck::bytes_of_mut(&mut value) {
            *byte = bytes.next().unwrap_or(0);
        }
        into.push(value);
    }
}

/// Rotated, mirrored or sheared voxel axes.
fn affine() -> impl Strategy<Value = DAffine3> {
    let angle = -3.2..3.2f64;
    (
        [angle.clone(), angle.clone(), angle],
        [0.01..50.0f64, 0.01..50.0, 0.01..50.0],
        [-0.6..0.6f64, -0.6..0.6, -0.6..0.6],
        any::<[bool; 4]>(),
        [-500.0..500.0f64, -500.0..500.0, -500.0..500.0],
    )
        .prop_map(
            |([a, b, c], spacing, [xy, xz, yz], [mx, my, mz, sheared], origin)| {
                let rotation = DMat3::from_quat(DQuat::from_euler(glam::EulerRot::XYZ, a, b, c));
                let mirror = DVec3::new(sign(mx), sign(my), sign(mz));
                let shear = if sheared {
                    DMat3::from_cols(DVec3::X, DVec3::new(xy, 1.0, 0.0), DVec3::new(xz, yz, 1.0))
                } else {
                    DMat3::IDENTITY
                };
                let scale = DMat3::from_diagonal(DVec3::from(spacing) * mirror);
                DAffine3::from_mat3_translation(rotation * shear * scale, origin.into())
            },
        )
}

fn sign(negative: bool) -> f64 {
    if negative { -1.0 } else { 1.0 }
}

fn volume() -> impl Strategy<Value = Volume> {
    (
        [1..6usize, 1..6usize, 1..6usize],
        0..8usize,
        prop::collection::vec(any::<u8>(), 1..200),
        affine(),
    )
        .prop_map(|(dims, sample_type, bytes, affine)| {
            let grid = Grid::new(dims, affine).unwrap();
            let samples = samples_of(SampleType::ALL[sample_type], &bytes, grid.voxel_count());
            Volume::new(grid, samples, Rescale::IDENTITY, Metadata::default()).unwrap()
        })
}

fn write_and_read(name: &str, volume: &Volume, options: &WriteOptions) -> LoadedVolume {
    let mut folder = NewMemoryFiles::default();
    write(name, volume, options, &mut folder).unwrap();
    let mut options = ReadOptions::default();
    if name.ends_with(".raw") {
        options.raw = RawLayout {
            dims: Some(volume.grid().dims()),
            sample_type: Some(volume.sample_type()),
            ..RawLayout::default()
        };
    }
    read_file(name, &folder.0, &options).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn every_writer_keeps_voxels_and_place(volume in volume(), compress in any::<bool>()) {
        let options = WriteOptions { compress, labels: None };
        // NRRD has the same f64 numbers as text; MetaImage splits them into direction and spacing;
        // NIfTI-1 stores f32 (24 bits).
        let placed = [("v.nrrd", 0.0), ("v.mha", 1e-14), ("v.mhd", 1e-14), ("v.nii", 1e-7), ("v.nii.gz", 1e-7)];
        for (name, tolerance) in placed {
            let read = write_and_read(name, &volume, &options).volume;
            prop_assert_eq!(bits(read.samples()), bits(volume.samples()), "{}", name);
            prop_assert_eq!(read.grid().dims(), volume.grid().dims());
            assert_affine(
                read.grid().world_from_voxel(),
                volume.grid().world_from_voxel(),
                tolerance,
            );
        }
        for name in ["v.npy", "v.raw"] {
            let read = write_and_read(name, &volume, &options).volume;
            prop_assert_eq!(bits(read.samples()), bits(volume.samples()), "{}", name);
            prop_assert_eq!(read.grid().dims(), volume.grid().dims());
        }
    }

    /// NIfTI says the same twice where it can: the qform alone gives the sform's affine.
    #[test]
    fn the_qform_of_nifti_agrees_with_the_sform(volume in volume()) {
        let mut folder = NewMemoryFiles::default();
        write("v.nii", &volume, &WriteOptions::default(), &mut folder).unwrap();
        let file = folder.0.get_mut("v.nii").unwrap();
        let qform_code = i16::from_le_bytes([file[252], file[253]]);
        let m = volume.grid().world_from_voxel().matrix3;
        let [x, y, z] = [m.x_axis, m.y_axis, m.z_axis].map(|axis| axis.normalize());
        let skew = x.dot(y).abs().max(x.dot(z).abs()).max(y.dot(z).abs());
        prop_assert_eq!(qform_code != 0, skew < 1e-6);
        if qform_code != 0 {
            file[254] = 0;
            let read = read_file("v.nii", &folder.0, &ReadOptions::default()).unwrap().volume;
            // A scalar part near 0 is the root of a difference of f32s: half their digits.
            assert_affine(
                read.grid().world_from_voxel(),
                volume.grid().world_from_voxel(),
                2e-3,
            );
        }
    }

    /// Formats without a rescale hold values; NIfTI holds the stored numbers and the rescale.
    #[test]
    fn values_survive_a_rescale(
        volume in volume(),
        slope in prop_oneof![Just(1.0), Just(-2.0), Just(0.1), 0.001..100.0f64],
        intercept in prop_oneof![Just(0.0), Just(-1024.0), -1e4..1e4f64],
    ) {
        let (grid, samples, _, metadata) = volume.into_parts();
        let rescale = Rescale::new(slope, intercept);
        let volume = Volume::new(grid, samples, rescale, metadata).unwrap();
        for name in ["v.nrrd", "v.mha", "v.nii.gz"] {
            let read = write_and_read(name, &volume, &WriteOptions::default()).volume;
            let whole = slope.fract() == 0.0 && intercept.fract() == 0.0;
            for index in 0..grid.voxel_count() {
                let expected = volume.rescale().value(volume.samples().get(index));
                let found = read.rescale().value(read.samples().get(index));
                // f32 holds 24 bits of the value, or of slope and intercept before they are summed;
                // near 0 it has steps of its smallest number.
                let stored = (slope * volume.samples().get(index)).abs();
                let room = if whole && volume.sample_type().is_integer() && expected.abs() < 2e9 {
                    0.0
                } else {
                    1.3e-7 * (stored + intercept.abs()) + f64::from(f32::from_bits(1))
                };
                let too_large = !(expected as f32).is_finite();
                let same = (found - expected).abs() <= room
                    || (found.is_nan() && expected.is_nan())
                    || found == expected
                    || too_large;
                prop_assert!(same, "{} {}: {} is not {}", name, index, found, expected);
            }
        }
    }
}

fn ct() -> Volume {
    let grid = Grid::centered([4, 3, 2], DVec3::new(0.5, 0.5, 2.0)).unwrap();
    let stored: Vec<u16> = (0..24).map(|i| i * 170).collect();
    Volume::new(
        grid,
        Samples::U16(stored),
        Rescale::new(1.0, -1024.0),
        Metadata {
            modality: Some(Modality::Ct),
            value_unit: Some("HU".into()),
            has_length_unit: true,
            entries: vec![
                (
                    "series".into(),
                    "thorax\nwith a \\ and a = and a : in it".into(),
                ),
                ("odd:key".into(), "left out".into()),
                ("space".into(), "scanner".into()),
            ],
            ..Metadata::default()
        },
    )
    .unwrap()
}

#[test]
fn hounsfield_units_stay_whole_numbers_of_16_bits() {
    for name in ["v.nrrd", "v.mha", "v.npy"] {
        let read = write_and_read(name, &ct(), &WriteOptions::default()).volume;
        assert_eq!(read.sample_type(), SampleType::I16, "{name}");
        assert_eq!(read.rescale(), Rescale::IDENTITY);
        assert_eq!(read.value(1, 0, 0), 170.0 - 1024.0);
    }
    let read = write_and_read("v.nii", &ct(), &WriteOptions::default()).volume;
    assert_eq!(read.sample_type(), SampleType::U16);
    assert_eq!(read.rescale(), Rescale::new(1.0, -1024.0));
}

#[test]
fn what_is_known_of_the_data_is_kept_where_the_format_has_room() {
    let nrrd = write_and_read("v.nrrd", &ct(), &WriteOptions::default()).volume;
    let metadata = nrrd.metadata();
    assert_eq!(metadata.modality, Some(Modality::Ct));
    assert_eq!(metadata.value_unit.as_deref(), Some("HU"));
    assert!(metadata.has_length_unit);
    let series = metadata.entries.iter().find(|(key, _)| key == "series");
    assert_eq!(
        series.map(|(_, value)| value.as_str()),
        Some("thorax\nwith a \\ and a = and a : in it")
    );
    assert!(
        !metadata
            .entries
            .iter()
            .any(|(_, value)| value == "left out")
    );
    // Not as `space`, which is a field of the format.
    let space = ("header space".to_owned(), "scanner".to_owned());
    assert!(metadata.entries.contains(&space));
    let meta = write_and_read("v.mha", &ct(), &WriteOptions::default()).volume;
    assert_eq!(meta.metadata().modality, Some(Modality::Ct));
    let nifti = write_and_read("v.nii", &ct(), &WriteOptions::default()).volume;
    assert!(nifti.metadata().has_length_unit);
}

#[test]
fn labels_are_kept_by_nrrd_and_marked_by_nifti() {
    let grid = Grid::centered([2, 1, 1], DVec3::ONE).unwrap();
    let volume = Volume::new(
        grid,
        Samples::U16(vec![3, 300]),
        Rescale::IDENTITY,
        Metadata::default(),
    )
    .unwrap();
    let labels = vec![
        Label {
            color: Some([0.25, 1.0, 0.1]),
            ..Label::new(3, "left kidney: \\upper")
        },
        Label::new(300, "Leber äöü"),
    ];
    let options = WriteOptions {
        compress: true,
        labels: Some(labels.clone()),
    };
    let nrrd = write_and_read("v.seg.nrrd", &volume, &options);
    assert_eq!(nrrd.labels, Some(labels));
    assert_eq!(nrrd.notes, Vec::<String>::new());
    let nifti = write_and_read("v.nii.gz", &volume, &options);
    assert_eq!(nifti.labels, Some(vec![]));
    assert_eq!(
        write_and_read("v.nii.gz", &volume, &WriteOptions::default()).labels,
        None
    );
}

/// ITK reads exactly as many bytes behind the header.
#[test]
fn the_size_of_packed_samples_stands_in_an_mha() {
    let mut folder = NewMemoryFiles::default();
    write("v.mha", &ct(), &WriteOptions::default(), &mut folder).unwrap();
    let file = &folder.0["v.mha"];
    let end = b"ElementDataFile = LOCAL\n";
    let at = file.windows(end.len()).position(|w| w == end).unwrap() + end.len();
    let line = format!("CompressedDataSize = {}\n", file.len() - at);
    assert!(String::from_utf8_lossy(&file[..at]).contains(&line));
}

#[test]
fn an_axis_too_long_for_nifti_1_makes_nifti_2() {
    let grid = Grid::centered([40_000, 1, 1], DVec3::splat(0.1)).unwrap();
    let samples = Samples::U8((0..40_000).map(|i| i as u8).collect());
    let volume = Volume::new(grid, samples, Rescale::new(0.1, 3.0), Metadata::default()).unwrap();
    let read = write_and_read("v.nii", &volume, &WriteOptions::default()).volume;
    assert_eq!(read.metadata().format, "NIfTI-2");
    assert_eq!(read.samples(), volume.samples());
    assert_eq!(read.rescale(), volume.rescale());
    assert_eq!(read.grid(), volume.grid());
}

#[test]
fn an_unknown_ending_is_refused_with_the_known_ones() {
    let mut folder = NewMemoryFiles::default();
    let error = write("v.dcm", &ct(), &WriteOptions::default(), &mut folder).unwrap_err();
    let message = error.to_string();
    for part in ["v.dcm", ".nii.gz", ".nrrd", ".mha"] {
        assert!(message.contains(part), "{message}");
    }
    assert!(folder.0.is_empty());
}

#[test]
fn a_name_that_the_header_cannot_hold_is_refused() {
    let mut folder = NewMemoryFiles::default();
    assert!(write("v%d.mhd", &ct(), &WriteOptions::default(), &mut folder).is_err());
    assert!(folder.0.is_empty());
}

/// Volumes of 2 × 2 × 1 voxels, one for each number of a voxel: `10 · component + voxel`.
fn components(sample_type: SampleType, count: usize, are_colors: bool) -> Vec<Volume> {
    let one = |component: usize| {
        let mut samples = Samples::new(sample_type);
        with_samples!(&mut samples, s => numbers(s, component));
        let metadata = Metadata {
            components: Components { count, are_colors },
            ..Metadata::default()
        };
        let grid = Grid::centered([2, 2, 1], DVec3::new(1.0, 2.0, 3.0)).unwrap();
        Volume::new(grid, samples, Rescale::new(2.0, 1.0), metadata).unwrap()
    };
    (0..count).map(one).collect()
}

fn numbers<T: Sample>(into: &mut Vec<T>, component: usize) {
    into.extend((0..4).map(|voxel| T::from_f64((10 * component + voxel) as f64)));
}

fn has(file: &[u8], text: &str) -> bool {
    file.windows(text.len()).any(|part| part == text.as_bytes())
}

#[test]
fn all_numbers_of_a_voxel_are_kept() {
    let cases = [
        (SampleType::U8, 3, true),
        (SampleType::U8, 4, true),
        (SampleType::U16, 3, true),
        (SampleType::U8, 3, false),
        (SampleType::F32, 2, false),
        (SampleType::I16, 6, false),
    ];
    let names = ["v.nii", "v.nii.gz", "v.nrrd", "v.mha", "v.mhd"];
    for ((sample_type, count, are_colors), name) in cases
        .iter()
        .flat_map(|case| names.map(|name| (*case, name)))
    {
        let written = components(sample_type, count, are_colors);
        let mut folder = NewMemoryFiles::default();
        write_components(name, &written, &WriteOptions::default(), &mut folder).unwrap();
        let mut read = |component| {
            let options = ReadOptions {
                component,
                ..ReadOptions::default()
            };
            read_file(name, &folder.0, &options)
        };
        let wants = |error: &Error| error.remedy() == Some(Remedy::Component);
        let loaded = read_components(&mut read, wants).unwrap();
        assert!(loaded.notes.is_empty(), "{name}: {:?}", loaded.notes);
        assert_eq!(loaded.volumes.len(), count, "{name}");
        for (component, volume) in loaded.volumes.iter().enumerate() {
            let found: Vec<f64> = (0..4).map(|i| volume.value(i % 2, i / 2, 0)).collect();
            let value = |voxel| f64::from(2 * (10 * component as u32 + voxel) + 1);
            assert_eq!(found, [0, 1, 2, 3].map(value), "{name} {component}");
        }
    }
}

/// What nibabel, pynrrd and SimpleITK read of such files.
#[test]
fn headers_say_what_the_numbers_of_a_voxel_are() {
    let written = |name: &str, sample_type, count, are_colors| {
        let volumes = components(sample_type, count, are_colors);
        let mut folder = NewMemoryFiles::default();
        write_components(name, &volumes, &WriteOptions::default(), &mut folder).unwrap();
        folder.0.remove(name).unwrap()
    };
    let i16_at = |file: &[u8], at: usize| i16::from_le_bytes([file[at], file[at + 1]]);
    // Datatype, bits, number of dimensions, dim[5], intent.
    for (case, expected) in [
        ((SampleType::U8, 3, true), [128, 24, 3, 1, 0]),
        ((SampleType::U8, 4, true), [2304, 32, 3, 1, 0]),
        ((SampleType::U16, 3, true), [512, 16, 5, 3, 1007]),
        ((SampleType::F32, 2, false), [16, 32, 5, 2, 1007]),
    ] {
        let (sample_type, count, are_colors) = case;
        let file = written("v.nii", sample_type, count, are_colors);
        assert_eq!(
            [70, 72, 40, 50, 68].map(|at| i16_at(&file, at)),
            expected,
            "{case:?}"
        );
    }
    let file = written("v.nrrd", SampleType::U8, 3, true);
    assert!(has(&file, "\ndimension: 4\n") && has(&file, "\nsizes: 3 2 2 1\n"));
    assert!(has(&file, "\nspace directions: none (1,0,0) "));
    assert!(has(&file, "\nkinds: RGB-color domain domain domain\n"));
    let file = written("v.nrrd", SampleType::F32, 2, false);
    assert!(has(&file, "\nkinds: vector domain domain domain\n"));
    let file = written("v.mha", SampleType::F32, 2, false);
    assert!(has(&file, "\nElementNumberOfChannels = 2\n"));

    for name in ["v.npy", "v.raw"] {
        let volumes = components(SampleType::U8, 3, true);
        let mut folder = NewMemoryFiles::default();
        let written = write_components(name, &volumes, &WriteOptions::default(), &mut folder);
        let error = written.unwrap_err();
        assert!(error.to_string().contains("write .nrrd"), "{error}");
        assert_eq!(error.remedy(), Some(Remedy::Component));
    }
}
