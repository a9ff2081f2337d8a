//! The Spec of what the document designs in its chapter 8: several volumes and boards, polygons, bent rays, shadows.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Volumes and boards whose pictures are laid over each other.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Merge {
    /// Processors with a memory each, 1 to 64: every volume is cut into as many parts, of which each draws one at the same
    /// time as the others.
    pub boards: u32,
    /// The axis across which volumes are cut.
    pub cut: Axis,
    /// Buses to the host, 1 to `boards`, which share them evenly.
    pub buses: u32,
    /// Further volumes beside the first, at most 15; on each board they are drawn one after the other.
    pub volumes: Vec<PlacedVolume>,
}

impl Default for Merge {
    fn default() -> Merge {
        Merge {
            boards: 1,
            cut: Axis::Y,
            buses: 1,
            volumes: Vec::new(),
        }
    }
}

impl Merge {
    /// Whether there is more than one volume on one board.
    pub fn is_on(&self) -> bool {
        self.boards > 1 || !self.volumes.is_empty()
    }
}

/// A volume beside the first.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlacedVolume {
    /// A volume file, or a phantom as `strahl sim run` takes it.
    pub path: String,
    /// Where its first voxel lies, in voxels of the first volume: its box may touch no other.
    pub at: [i32; 3],
    /// Its curve, as `look.opacity`; none: that of the Spec.
    #[serde(default)]
    pub opacity: Vec<[f64; 2]>,
}

/// An axis of a volume.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Axis {
    /// From voxel to voxel of a row.
    X,
    /// From row to row; the view direction without rotation.
    Y,
    /// From slice to slice.
    Z,
}

/// Polygons, which the host rasterises and the processor merges by their distance.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Polygons {
    /// What they make.
    pub shape: Shape,
    /// Their opacity, 0 to 1. Behind an opaque one a ray ends; of one behind the other only the first is seen.
    pub opacity: f64,
    /// Red, green, blue, 0 to 1, lit by `look.lights`; a grey picture shows their mean.
    pub color: [f64; 3],
}

impl Default for Polygons {
    fn default() -> Polygons {
        Polygons {
            shape: Shape::None,
            opacity: 1.0,
            color: [1.0; 3],
        }
    }
}

/// A surface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Shape {
    /// No polygons.
    None,
    /// An endless plane, in voxels.
    Plane {
        /// A point of it; the centre of the first voxel is 0, 0, 0.
        point: [f64; 3],
        /// Across it, of any length but 0.
        normal: [f64; 3],
    },
    /// A ball, in voxels.
    Sphere {
        /// Its centre; that of the first voxel is 0, 0, 0.
        centre: [f64; 3],
        /// Its radius.
        radius: f64,
    },
    /// The triangles of an STL, OBJ or PLY file, in the millimetres of the volume.
    File {
        /// The file.
        path: String,
    },
}

/// Bent rays: every sample is moved across its ray, by two words of 2 bytes per ray and plane.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Bend {
    /// Rays are straight.
    None,
    /// Turned about the middle of the picture, farther from plane to plane.
    Twist {
        /// Degrees from one plane of samples to the next.
        deg_per_plane: f64,
    },
    /// Enlarged in the middle of the picture: samples move towards the middle by strength · (1 − (r / radius)²)² of their
    /// distance r from it.
    Lens {
        /// 0 to below 1; the middle is enlarged 1 / (1 − strength) times.
        strength: f64,
        /// In voxels; nothing moves beyond it.
        radius: f64,
    },
}

/// A light pass before every tile: shadows of a light that crosses the picture within the planes of samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Shadow {
    /// No shadows, one read per sample.
    None,
    /// Light comes from the left of the picture.
    FromLeft,
    /// Light comes from the right.
    FromRight,
}
