//! The scans that lie beside the checkout, in `../shared/data`.

use glam::DVec3;
use std::path::PathBuf;
use strahl_volume::read::{MemoryFiles, ReadOptions, read_file};
use strahl_volume::{Label, LabelVolume, SampleType, read::LoadedVolume};

fn load(name: &str) -> Option<LoadedVolume> {
    load_with(name, &[])
}

/// The same with other files beside it.
fn load_with(name: &str, beside: &[&str]) -> Option<LoadedVolume> {
    let shared = std::env::var_os("STRAHL_SHARED").map_or_else(
        || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared"),
        PathBuf::from,
    );
    let mut folder = MemoryFiles::new();
    for name in [&[name], beside].concat() {
        let path = shared.join("data").join(name);
        let Ok(bytes) = std::fs::read(&path) else {
            eprintln!("skipped: {} is not there", path.display());
            return None;
        };
        folder.insert(name.to_owned(), bytes);
    }
    Some(read_file(name, &folder, &ReadOptions::default()).unwrap())
}

#[track_caller]
fn check(name: &str, dims: [usize; 3], sample_type: SampleType, spacing_mm: DVec3, first: DVec3) {
    let Some(loaded) = load(name) else { return };
    let volume = &loaded.volume;
    assert_eq!(volume.grid().dims(), dims, "{name}");
    assert_eq!(volume.sample_type(), sample_type);
    assert!((volume.grid().spacing_mm() - spacing_mm).length() < 1e-6);
    let translation = volume.grid().world_from_voxel().translation;
    assert!((translation - first).length() < 1e-4, "{translation}");
    assert_eq!(volume.grid().orientation(), "RAS");
    let counted: u64 = volume.statistics().histogram.iter().sum();
    assert_eq!(counted, volume.grid().voxel_count() as u64);
    assert_eq!(loaded.notes, Vec::<String>::new());
}

#[test]
fn engine() {
    let first = DVec3::new(-127.0, -127.0, -64.0);
    check(
        "engine.nii.gz",
        [256, 256, 128],
        SampleType::U8,
        DVec3::ONE,
        first,
    );
}

#[test]
fn bonsai() {
    let first = DVec3::new(-127.0, -127.0, -128.0);
    check(
        "bonsai.nii.gz",
        [256, 256, 256],
        SampleType::U8,
        DVec3::ONE,
        first,
    );
}

#[test]
fn fuel() {
    let first = DVec3::new(-31.0, -16.0, -16.0);
    check(
        "fuel.nii.gz",
        [64, 33, 32],
        SampleType::U8,
        DVec3::ONE,
        first,
    );
}

#[test]
fn head_cta() {
    let spacing = DVec3::new(0.719_942_57, 0.720_913_6, 1.0);
    let first = DVec3::new(-73.397_689_82, -69.694_198_61, -64.110_000_61);
    check(
        "head-cta.nii.gz",
        [256, 242, 154],
        SampleType::U8,
        spacing,
        first,
    );
}

#[test]
fn brain() {
    let first = DVec3::new(-78.0, -115.0, -78.0);
    check(
        "brain-t1.nii.gz",
        [157, 197, 165],
        SampleType::U8,
        DVec3::ONE,
        first,
    );
    check(
        "brain-labels.nii.gz",
        [157, 197, 165],
        SampleType::U8,
        DVec3::ONE,
        first,
    );
}

/// Names and numbers of voxels as Python's re and NumPy find them.
#[test]
fn labels_named_in_the_header() {
    let counts = |loaded: LoadedVolume| {
        let labels = LabelVolume::from_volume(loaded.volume, loaded.labels.unwrap()).unwrap();
        let counts = labels.counts();
        (labels, counts)
    };
    if let Some(loaded) = load("abdomen-labels.nii.gz") {
        let (labels, counts) = counts(loaded);
        let named = labels.labels();
        assert_eq!((named.len(), counts.len()), (117, 42));
        assert_eq!((named[4].id, named[4].name.as_str()), (5, "liver"));
        assert_eq!(named[5].color, Some([1.0, 128.0 / 255.0, 0.0]));
        assert_eq!(
            (named[116].id, named[116].name.as_str()),
            (117, "costal_cartilages")
        );
        assert_eq!(counts[..3], [(0, 259_435), (1, 9452), (2, 3947)]);
        assert_eq!((counts[5], counts[41]), ((5, 38_634), (117, 2100)));
        assert_eq!(counts.iter().map(|(_, n)| n).sum::<u64>(), 122 * 101 * 30);
        assert_eq!(labels.known_ids(), (0..=117).collect::<Vec<u32>>());
    }
    if let Some(loaded) = load("brain-labels.nii.gz") {
        let (labels, counts) = counts(loaded);
        let named = labels.labels();
        assert_eq!((named.len(), counts.len()), (207, 208));
        assert_eq!(named[0], Label::new(1, "Area 3b (PostCG)"));
        assert_eq!(named[206], Label::new(207, "Area TeI (STG)"));
        assert_eq!(counts[..3], [(0, 4_625_346), (1, 7596), (2, 4432)]);
    }
}

/// Colors as Python's json reads them.
#[test]
fn labels_named_by_niivue() {
    let beside = ["brain-labels.json"];
    let Some(loaded) = load_with("brain-labels.nii.gz", &beside) else {
        return;
    };
    let note = "names and colors of labels are those of brain-labels.json";
    assert_eq!(loaded.notes, [note]);
    let labels = loaded.labels.unwrap();
    let label = |id, name: &str, color: [u8; 3]| Label {
        color: Some(color.map(|c| f32::from(c) / 255.0)),
        ..Label::new(id, name)
    };
    // The first entry is a background without a name.
    assert_eq!(labels.len(), 207);
    assert_eq!(labels[0], label(1, "Area 3b (PostCG)", [71, 46, 154]));
    assert_eq!(labels[206], label(207, "Area TeI (STG)", [173, 208, 231]));
}
