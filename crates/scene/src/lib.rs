//! Scenes, Plans and images.
//!
//! A [`Scene`] describes a picture, as a user writes it: most keys are missing. [`resolve`] combines it
//! with the headers of its volumes, fills in every default, checks every value, and returns a
//! [`plan::Plan`] or all problems at once. A renderer draws the Plan and returns an [`Image`]. This
//! crate reads no voxels and starts no threads.
//!
//! ```
//! use strahl_scene::{Method, Scene, resolve};
//! use strahl_volume::{Grid, Metadata, Rescale, Samples, Volume};
//!
//! let grid = Grid::centered([2, 2, 2], glam::DVec3::ONE)?;
//! let volume = Volume::new(grid, Samples::U8(vec![0; 8]), Rescale::IDENTITY, Metadata::default())?;
//! let scene = Scene { method: Some(Method::Mip), size: Some([64, 48]), ..Scene::default() };
//! let plan = resolve(&scene, &volume.header(), None)?;
//! assert_eq!((plan.width, plan.height), (64, 48));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![warn(missing_docs)]

pub mod plan;
pub mod transfer;
pub mod visibility;

mod camera;
mod clip;
mod coarser;
mod color;
mod color_map;
mod composite;
mod drawable;
mod emptiness;
mod frame;
mod function;
mod graph_text;
mod headers;
mod illustration;
mod image;
mod importance;
mod json_size;
mod label_source;
mod light;
mod nearest;
mod noise_tile;
mod object;
mod parse;
mod patient;
mod places;
mod planning;
mod preset;
mod problem;
mod quality;
mod rendered;
mod resolve;
mod sampling;
mod scene;
mod segment_looks;
mod segmented;
mod segments;
mod settled;
mod shading;
mod source;
mod step;
mod technique;
mod transfer_function;
mod volume_source;
mod window;
mod without_effect;
mod words;

pub use camera::{Camera, Projection, View};
pub use clip::{BoxClip, BoxSpace, Clip, KeptSide, LabelName, MaskClip, PlaneClip};
pub use color::{Background, Color, linear_from_srgb};
pub use color_map::ColorMap;
pub use emptiness::why_nothing_is_seen;
pub use function::{FunctionUse, ParameterValue};
pub use graph_text::GraphText;
pub use headers::{Headers, LabelHeader};
pub use image::Image;
pub use importance::ImportanceSource;
pub use json_size::check_json_size;
pub use label_source::{LabelSource, NamedLayer, NamedMask, ValueLayer, ValueLayers};
pub use light::{Light, LightKind, LightSpace};
pub use noise_tile::NoiseTile;
pub use object::{Placement, SceneObject};
#[cfg(feature = "schema")]
pub use parse::schema;
pub use parse::{Error, MOST_SCENE_BYTES};
pub use preset::{PresetInfo, preset_notes, presets};
pub use problem::{Problem, Problems};
pub use rendered::{Counts, Rendered, Stats};
pub use resolve::{resolve, resolve_with};
pub use sampling::{Sampling, SamplingRule};
pub use scene::{Compositing, Display, Gradient, Jitter, Quality, Scene, ToneMap};
pub use segmented::segment_notes;
pub use segments::{AllBut, OfGroup, SegmentChoice, SegmentComposite, SegmentUse};
pub use settled::{FORMAT, settled, settled_with};
pub use shading::Shading;
pub use source::{OtherData, Source};
pub use step::MAX_SAMPLES_PER_RAY;
pub use technique::SegmentTechnique;
pub use transfer_function::{PointsIn, TransferFunction, TransferPoint, TransferRegion};
pub use volume_source::{Endian, VolumeSource};
pub use without_effect::{WithoutEffect, keys_without_effect};
pub use words::{DebugView, GradientInput, GradientMethod, Method, Reconstruct, ShadingModel};
