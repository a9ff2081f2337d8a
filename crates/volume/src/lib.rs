//! Volumes, label volumes and meshes, with readers, writers, phantoms and min/max bricks.
//!
//! - A [`Volume`] has samples on a [`Grid`]. Samples keep the type of their file ([`Samples`]). A
//!   *value* is a rescaled sample ([`Rescale`]), such as HU for CT.
//! - `world_from_voxel` of the grid maps voxel indices to patient space, RAS, in millimeters. Voxel
//!   centers have whole-number indices.
//! - A [`Mesh`] is a surface of triangles in the same space; [`read::mesh`] reads meshes.
//! - [`read`] detects the format of a file by its content. A reader accesses files only through
//!   [`read::Files`], so it works on folders, uploads and memory alike.
//!
//! This crate depends on no other crate of the workspace, on no file system and on no GPU.
//!
//! ```
//! use strahl_volume::read::{MemoryFiles, ReadOptions, read_file};
//! let text = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 3 1 1\nencoding: ascii\n\n7 8 9";
//! let files = MemoryFiles::from([("three.nrrd".into(), text.into())]);
//! let loaded = read_file("three.nrrd", &files, &ReadOptions::default())?;
//! assert_eq!(loaded.volume.grid().dims(), [3, 1, 1]);
//! assert_eq!(loaded.volume.value(2, 0, 0), 9.0);
//! # Ok::<(), strahl_volume::Error>(())
//! ```

#![warn(missing_docs)]

pub mod bends;
pub mod bricks;
mod content_id;
mod control;
pub mod cores;
mod datasets;
mod error;
mod grid;
mod label_numbers;
mod labels;
mod level_of_detail;
mod made_labels;
mod memory;
mod mesh;
mod prefilter;
mod rescale;
mod rows;
mod samples;
mod statistics;
mod stopwatch;
mod store;
mod values;
mod volume;

pub mod phantom;
pub mod read;
pub mod write;

pub use content_id::ContentId;
pub use control::{Cancelled, Control, OverBudget, Parts, Work};
pub use datasets::Datasets;
pub use error::{Error, ErrorKind, Remedy};
pub use grid::{Grid, voxel_count};
pub use label_numbers::{LabelNumbers, LabelNumbersKey};
pub use labels::{Label, LabelIds, LabelVolume};
pub use made_labels::{MOST_THRESHOLDS, MergedMasks};
pub use mesh::Mesh;
pub use phantom::Phantom;
pub use prefilter::CoefficientsKey;
pub use rescale::Rescale;
pub use samples::{Sample, SampleType, Samples};
pub use statistics::Statistics;
pub use stopwatch::Stopwatch;
pub use store::{Counts, Key, Store};
pub use values::ValuesKey;
pub use volume::{Components, Metadata, Modality, Volume, VolumeHeader};
