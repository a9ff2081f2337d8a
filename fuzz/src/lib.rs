//! What the fuzz targets share: how one input becomes several files, what must hold for whatever
//! was read, and an allocator that tells when a header's claim was believed.

pub mod dicom_frame;
pub mod graph;

use std::alloc::{GlobalAlloc, Layout, System};
use strahl_volume::read::mesh::{self, MeshSpace};
use strahl_volume::read::{LoadedVolume, MemoryFiles, ReadOptions, read_file, read_folder};

/// Stands between the files of one input (a header and its data, the slices of a series).
pub const SEPARATOR: &[u8] = b"\n--next file--\n";

/// The most that one allocation may take. Inputs are at most 64 KiB; deflate makes at most 1032 bytes
/// of one, and a growing vector doubles: 132 MiB. More was never in the file.
const LARGEST_ALLOCATION: usize = 160 << 20;

struct Believer;

// SAFETY: every call goes to the system's allocator unchanged, or does not return.
unsafe impl GlobalAlloc for Believer {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        check(layout.size());
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        check(layout.size());
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn realloc(&self, at: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        check(size);
        unsafe { System.realloc(at, layout, size) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        unsafe { System.dealloc(at, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Believer = Believer;

fn check(size: usize) {
    if size > LARGEST_ALLOCATION {
        eprintln!("one allocation of {size} bytes: a claim was believed");
        std::process::abort();
    }
}

/// The files of an input, called `names` in turn; what is left over is not used.
pub fn files(input: &[u8], names: &[&str]) -> MemoryFiles {
    names
        .iter()
        .zip(parts(input))
        .map(|(name, bytes)| (name.to_string(), bytes.to_vec()))
        .collect()
}

fn parts(mut input: &[u8]) -> Vec<&[u8]> {
    let mut parts = Vec::new();
    while let Some(at) = input
        .windows(SEPARATOR.len())
        .position(|window| window == SEPARATOR)
    {
        parts.push(&input[..at]);
        input = &input[at + SEPARATOR.len()..];
    }
    parts.push(input);
    parts
}

/// Reads the file `name`, once more for the last time point, and checks what comes.
pub fn read(name: &str, files: &MemoryFiles, mut options: ReadOptions) {
    let Ok(loaded) = read_file(name, files, &options) else {
        return;
    };
    check_loaded(&loaded);
    let time_points = loaded.volume.metadata().time_points;
    if time_points > 1 {
        options.time_index = time_points - 1;
        if let Ok(loaded) = read_file(name, files, &options) {
            check_loaded(&loaded);
        }
    }
}

/// Reads the folder of `files`, with and without resampled gaps, and checks what comes.
pub fn read_all(files: &MemoryFiles) {
    for allow_gaps in [false, true] {
        let options = ReadOptions {
            allow_gaps,
            ..ReadOptions::default()
        };
        if let Ok(loaded) = read_folder("folder", files, &options) {
            check_loaded(&loaded);
        }
    }
}

/// Reads a mesh, as it says and as LPS, and checks what comes.
pub fn read_mesh(name: &str, input: &[u8]) {
    let files = MemoryFiles::from([(name.to_owned(), input.to_vec())]);
    for space in [None, Some(MeshSpace::Lps)] {
        let Ok(loaded) = mesh::read_mesh(name, &files, space) else {
            continue;
        };
        let (lo, hi) = loaded.mesh.bounds_mm();
        assert!(lo.is_finite() && hi.is_finite() && lo.cmple(hi).all());
        let normals = loaded.mesh.vertex_normals();
        assert_eq!(normals.len(), loaded.mesh.positions().len());
        assert!(normals.iter().flatten().all(|c| c.abs() < 1.001));
        let corners = loaded.mesh.triangles().iter().flatten();
        assert!(corners.max().is_some_and(|&c| (c as usize) < normals.len()));
    }
}

/// What must hold for every volume, whatever the file said.
fn check_loaded(loaded: &LoadedVolume) {
    let volume = &loaded.volume;
    let grid = volume.grid();
    assert_eq!(volume.samples().len(), grid.voxel_count());
    assert!(grid.world_from_voxel().is_finite());
    assert!(grid.voxel_from_world().is_finite());
    assert!(grid.min_spacing_mm() > 0.0);
    let rescale = volume.rescale();
    assert!(rescale.slope != 0.0 && rescale.slope.is_finite() && rescale.intercept.is_finite());
    let metadata = volume.metadata();
    assert!(metadata.time_index < metadata.time_points.max(1));
}
