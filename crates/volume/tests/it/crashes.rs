//! Inputs that once broke a reader, found by `cargo xtask fuzz`, and the seeds it starts from.
//! `tests/crashes/TARGET/` is read by the reader of that fuzz target, the same way as `fuzz/` does.

use std::path::{Path, PathBuf};
use strahl_volume::read::mesh::{self, MeshSpace};
use strahl_volume::read::{
    LoadedVolume, MemoryFiles, ReadOptions, read_file, read_file_under, read_folder,
    read_folder_under, read_label_table,
};
use strahl_volume::{Control, Error, ErrorKind, Remedy};

const SEPARATOR: &[u8] = b"\n--next file--\n";

/// What the files of an input are called, and whether they are also read as a folder.
const TARGETS: [(&str, &[&str], bool); 14] = [
    ("dat", &["scan.dat", "scan.raw"], false),
    (
        "dicom",
        &["a.dcm", "b.dcm", "c.dcm", "d.dcm", "e.dcm"],
        true,
    ),
    ("metaimage", &["scan.mhd", "scan.raw", "scan.1.raw"], false),
    ("nifti", &["scan.hdr", "scan.img"], false),
    ("mgh", &["scan.mgh"], false),
    ("mrc", &["scan.mrc"], false),
    ("npy", &["scan.npy"], false),
    ("npz", &["scan.npz"], false),
    ("nrrd", &["scan.nhdr", "scan.raw", "scan.1.raw"], false),
    (
        "png",
        &["slice_8.png", "slice_9.png", "slice_10.png", "slice_11.png"],
        true,
    ),
    ("pvm", &["scan.pvm"], false),
    ("tiff", &["scan.tif"], false),
    ("vti", &["scan.vti"], false),
    ("vtk", &["scan.vtk"], false),
];

fn folder(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

fn inputs(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return Vec::new();
    };
    let mut paths: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths
        .into_iter()
        .map(|path| (path.clone(), std::fs::read(path).unwrap()))
        .collect()
}

fn parts<'a>(input: &'a [u8], names: &[&str]) -> MemoryFiles {
    let mut rest = Some(input);
    let mut next = || -> Option<&'a [u8]> {
        let input = rest?;
        let at = input
            .windows(SEPARATOR.len())
            .position(|window| window == SEPARATOR);
        rest = at.map(|at| &input[at + SEPARATOR.len()..]);
        Some(&input[..at.unwrap_or(input.len())])
    };
    names
        .iter()
        .map_while(|name| Some((name.to_string(), next()?.to_vec())))
        .collect()
}

/// The fuzz targets that read meshes.
const MESHES: [&str; 3] = ["obj", "ply", "stl"];

/// What must hold for every volume, whatever the file said.
fn check(loaded: &LoadedVolume, input: &Path) {
    let volume = &loaded.volume;
    let grid = volume.grid();
    assert_eq!(volume.samples().len(), grid.voxel_count(), "{input:?}");
    assert!(grid.world_from_voxel().is_finite(), "{input:?}");
    assert!(grid.voxel_from_world().is_finite(), "{input:?}");
    assert!(grid.min_spacing_mm() > 0.0, "{input:?}");
    let rescale = volume.rescale();
    assert!(
        rescale.slope != 0.0 && rescale.slope.is_finite() && rescale.intercept.is_finite(),
        "{input:?}"
    );
}

fn read_mesh(target: &str, input: &[u8]) -> bool {
    let name = format!("mesh.{target}");
    let files = MemoryFiles::from([(name.clone(), input.to_vec())]);
    let loaded = [None, Some(MeshSpace::Lps)].map(|space| mesh::read_mesh(&name, &files, space));
    for loaded in loaded.iter().flatten() {
        let (lo, hi) = loaded.mesh.bounds_mm();
        assert!(lo.is_finite() && hi.is_finite() && lo.cmple(hi).all());
        assert_eq!(
            loaded.mesh.vertex_normals().len(),
            loaded.mesh.positions().len()
        );
    }
    loaded.iter().any(Result::is_ok)
}

/// Whether the input was read; the target's name and its files decide how.
fn read(target: &str, path: &Path, input: &[u8]) -> bool {
    if MESHES.contains(&target) {
        return read_mesh(target, input);
    }
    if target == "label_table" {
        return read_label_table("table", input).is_ok();
    }
    if target == "raw" {
        let end = input.iter().position(|&byte| byte == b'\n').unwrap_or(0);
        let Ok(name) = std::str::from_utf8(&input[..end]) else {
            return false;
        };
        let data = input.get(end + 1..).unwrap_or_default().to_vec();
        let files = MemoryFiles::from([(name.to_owned(), data)]);
        let loaded = read_file(name, &files, &ReadOptions::default());
        return loaded.map(|loaded| check(&loaded, path)).is_ok();
    }
    let (_, names, as_folder) = TARGETS
        .into_iter()
        .find(|(name, ..)| *name == target)
        .unwrap_or_else(|| panic!("no reader for the inputs of `{target}`"));
    let files = parts(input, names);
    let mut was_read = false;
    for allow_gaps in [false, true] {
        let options = ReadOptions {
            allow_gaps,
            ..ReadOptions::default()
        };
        let mut results = vec![read_file(names[0], &files, &options)];
        if as_folder {
            results.push(read_folder("folder", &files, &options));
        }
        for loaded in results.into_iter().flatten() {
            check(&loaded, path);
            was_read = true;
        }
    }
    was_read
}

#[test]
fn what_once_broke_a_reader_does_not() {
    let mut count = 0;
    for target in std::fs::read_dir(folder("tests/crashes")).unwrap() {
        let target = target.unwrap();
        for (path, input) in inputs(&target.path()) {
            read(target.file_name().to_str().unwrap(), &path, &input);
            count += 1;
        }
    }
    assert!(count > 0, "no input was found");
}

/// Reads the first file of an input with so much memory.
fn read_within(most_bytes: u64, names: &[&str], input: &[u8]) -> Result<LoadedVolume, Error> {
    let control = Control::new().with_memory(most_bytes);
    let files = parts(input, names);
    read_file_under(names[0], &files, &ReadOptions::default(), &control)
}

#[test]
fn no_reader_takes_more_memory_than_it_may() {
    for (target, names, _) in TARGETS {
        let mut refused = 0;
        for (path, input) in inputs(&folder("../../fuzz/seeds").join(target)) {
            let Ok(loaded) = read_within(1 << 24, names, &input) else {
                continue;
            };
            let bytes = loaded.volume.samples().as_bytes().len() as u64;
            let read = read_within(bytes - 1, names, &input);
            let error = read.err().unwrap_or_else(|| panic!("{path:?} was read"));
            assert!(
                matches!(error.kind(), ErrorKind::OverBudget(over) if over.most_bytes == bytes - 1),
                "{path:?}: {error}"
            );
            assert_eq!(error.remedy(), Some(Remedy::Memory), "{path:?}");
            refused += 1;
        }
        assert!(refused > 0, "{target}");
    }
    let pictures = ["slice_1.png", "slice_2.png"].map(|name| {
        let picture = crate::slices::png(2, 3, &[1, 2, 3, 4, 5, 6]);
        (name.to_owned(), picture)
    });
    let control = Control::new().with_memory(11);
    let options = ReadOptions::default();
    let read = read_folder_under("folder", &MemoryFiles::from(pictures), &options, &control);
    assert_eq!(read.unwrap_err().remedy(), Some(Remedy::Memory));
    let meshes = MESHES.map(|target| inputs(&folder("../../fuzz/seeds").join(target)));
    for (name, inputs) in MESHES.iter().zip(meshes) {
        let name = format!("mesh.{name}");
        for (path, input) in inputs {
            let files = MemoryFiles::from([(name.clone(), input)]);
            let control = Control::new().with_memory(10);
            let error = mesh::read_mesh_under(&name, &files, None, &control).unwrap_err();
            assert_eq!(error.remedy(), Some(Remedy::Memory), "{path:?}");
        }
    }
}

/// Files that are read under one control share what it allows.
#[test]
fn the_limit_holds_for_all_files_together() {
    let npy = inputs(&folder("../../fuzz/seeds/npy"));
    let (_, input) = &npy[0];
    let files = MemoryFiles::from([("scan.npy".to_owned(), input.clone())]);
    let control = Control::new().with_memory(1 << 20);
    let read = || read_file_under("scan.npy", &files, &ReadOptions::default(), &control);
    let bytes = read().unwrap().volume.samples().as_bytes().len() as u64;
    let times = (1..=(1 << 20) / bytes).filter(|_| read().is_ok()).count() as u64;
    assert_eq!(times + 1, (1 << 20) / bytes);
}

/// A seed that is refused at its first byte leads a fuzzer nowhere.
#[test]
fn seeds_are_read_except_those_of_what_is_refused() {
    let refused: [&str; 0] = [];
    let seeds = folder("../../fuzz/seeds");
    let targets = TARGETS
        .iter()
        .map(|(name, ..)| *name)
        .chain(["raw", "label_table"])
        .chain(MESHES);
    for target in targets {
        let inputs = inputs(&seeds.join(target));
        assert!(!inputs.is_empty(), "{target} has no seeds");
        for (path, input) in inputs {
            let expected = !refused.iter().any(|refused| path.ends_with(refused));
            assert_eq!(read(target, &path, &input), expected, "{path:?}");
        }
    }
}
