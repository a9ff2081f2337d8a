//! A cycle-accurate model of a multithreaded ray-casting processor.
//!
//! The processor comes from B. Vettermann's doctoral thesis (Mannheim 2006; "the document" on these pages). Its
//! pipeline draws volumes with one sample per clock, with the rays of a tile as threads. It sorts the rays so that
//! the open rows of its SDRAM work as a cache. The model is exact in bits and clocks: [`spec`] describes the
//! design, [`messages`] has every word on every wire, and [`processor`] simulates one clock.
//!
//! This crate has its own integer arithmetic and calls no renderer, so its pictures check renderers independently.
//!
//! ```
//! use strahl_sim::{Frame, NoObserver, Spec, VolumeStore, jaw, no_progress, run};
//! use strahl_sim::spec::Optimisation;
//!
//! let volume = VolumeStore::new(&jaw([64, 64, 32])?)?;
//! let spec = Spec { optimisation: Optimisation::none(), ..Spec::default() };
//! let drawn = run(&Frame::new(&spec, &volume)?, &mut NoObserver, &no_progress)?;
//! assert_eq!(drawn.size, [64, 32]);
//! // One sample per voxel; 8 tiles · 4 rows of tiles, each through four blocks of 16³ voxels.
//! assert_eq!(drawn.counters.samples, 64 * 64 * 32);
//! assert_eq!(drawn.counters.thesis_row_changes, 8 * 4 * 4);
//! # Ok::<(), strahl_sim::Error>(())
//! ```
//!
//! In reading order: [`spec`], [`messages`], [`processor`], [`stages`], [`ray_queue`], [`memory`], [`dram`],
//! [`distance`], [`rays`], [`mod@picture`].

pub mod spec;

pub mod messages;

mod latch;

mod data_path;

mod values_ahead;

pub mod processor;

pub mod stages;

pub mod ray_queue;

pub mod access;

pub mod memory;

pub mod voxel_layout;

pub mod dram;

pub mod distance;

pub mod distance_engine;

pub mod adaptive;

pub mod picture;

pub mod merge;

pub mod intermediate_planes;

pub mod polygons;

pub mod deformation;

mod shadow;

pub mod rays;

pub mod frame;

pub mod host;

pub mod local_bus;

pub mod host_script;

pub mod counters;

pub mod observer;

pub mod fixed_point;

pub mod statistics;

pub mod gray_png;

pub mod waveform;

pub mod pipeline_diagram;

pub mod chart;

pub mod report;

pub mod study;

mod error;
mod jaw;
mod subject;
mod volume_store;

pub use counters::Counters;
pub use error::Error;
pub use frame::Frame;
pub use jaw::jaw;
pub use observer::{NoObserver, Observer, Wires};
pub use picture::{Picture, draw};
pub use processor::{Progress, Run, no_progress, run};
pub use spec::Spec;
pub use subject::Subject;
pub use volume_store::VolumeStore;
