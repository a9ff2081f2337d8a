//! The Plan: a scene with nothing left to decide, the contract of all renderers (`docs/plan.md`).
//!
//! No field is optional, every length is in mm or says its unit, every colour is linear, every
//! number is finite and inside its range. Only [`resolve`](crate::resolve) makes a Plan; a renderer
//! that gets one meets no bad value any more.

use crate::transfer::TransferTable;
use glam::{DAffine3, DVec3};
use strahl_volume::{Grid, Rescale};

/// Everything a renderer needs beside the voxels.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Pixels per row, 1 to 65,535.
    pub width: u32,
    /// Rows, 1 to 65,535.
    pub height: u32,
    /// Where the rays start and go.
    pub camera: PlanCamera,
    /// Place and meaning of the voxels.
    pub volume: PlanVolume,
    /// Where along the ray samples lie.
    pub lattice: Lattice,
    /// How a value between voxels is found.
    pub reconstruct: Reconstruct,
    /// Value → colour and opacity.
    pub classify: TransferTable,
    /// How the gradient is found.
    pub gradient: Gradient,
    /// How a sample's colour follows from its surface colour, gradient and the lights.
    pub shade: Shade,
    /// The lights, none if unlit.
    pub lights: Vec<PlanLight>,
    /// How the samples of a ray become a pixel.
    pub composite: Composite,
    /// Half-spaces that every ray is cut to before its lattice is laid.
    pub ray_clips: Vec<ClipPlane>,
    /// Boxes that drop single samples.
    pub sample_clips: Vec<ClipBox>,
    /// Behind everything; linear, premultiplied. Alpha 0 leaves the picture transparent.
    pub background: [f32; 4],
    /// How linear light becomes a picture file.
    pub display: Display,
}

/// A camera in world space. `right`, `up`, `forward` are unit vectors, pairwise perpendicular, and
/// right × up = −forward (the picture is not mirrored).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanCamera {
    /// The eye of a perspective camera; the middle of the image plane of an orthographic one.
    pub eye_mm: DVec3,
    /// Towards the right edge of the picture.
    pub right: DVec3,
    /// Towards the top edge.
    pub up: DVec3,
    /// Into the picture.
    pub forward: DVec3,
    /// How rays spread.
    pub projection: Projection,
}

/// How rays spread over the picture. Pixels are square.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// All rays start at the eye.
    Perspective {
        /// Tangent of half the vertical view angle, > 0.
        tan_half_height: f64,
    },
    /// All rays are parallel to `forward` and start in the plane through `eye_mm`.
    Orthographic {
        /// Half the height of the picture in mm, > 0.
        half_height_mm: f64,
    },
}

/// A ray in world space; points are `origin_mm + t · direction`, t ≥ 0 in mm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// t = 0.
    pub origin_mm: DVec3,
    /// Unit length.
    pub direction: DVec3,
}

impl PlanCamera {
    /// The ray through the centre of the pixel in column `x`, row `y` of a `width` × `height`
    /// picture (row 0 is the top).
    pub fn ray(&self, x: u32, y: u32, width: u32, height: u32) -> Ray {
        let aspect = f64::from(width) / f64::from(height);
        let across = (2.0 * (f64::from(x) + 0.5) / f64::from(width) - 1.0) * aspect;
        let upward = 1.0 - 2.0 * (f64::from(y) + 0.5) / f64::from(height);
        let offset = self.right * across + self.up * upward;
        match self.projection {
            Projection::Perspective { tan_half_height } => Ray {
                origin_mm: self.eye_mm,
                direction: (self.forward + offset * tan_half_height).normalize(),
            },
            Projection::Orthographic { half_height_mm } => Ray {
                origin_mm: self.eye_mm + offset * half_height_mm,
                direction: self.forward,
            },
        }
    }
}

/// Place and meaning of the voxels; the samples themselves are handed to the renderer beside the
/// Plan and must lie on this grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanVolume {
    /// Where the samples lie.
    pub grid: Grid,
    /// What a stored number means.
    pub rescale: Rescale,
}

/// Sample k of a ray lies at t = t_entry + (k + jitter)·step_mm, k = 0, 1, … while t < t_exit.
/// t_entry is where the ray, starting at t ≥ 0, enters the sampled extent cut by the ray clips.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    /// Distance between samples in mm, > 0.
    pub step_mm: f64,
    /// Where in its step a sample lies.
    pub jitter: Jitter,
}

/// Where in its step the samples of a ray lie, in [0, 1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Jitter {
    /// In the middle: 0.5 for every ray.
    Centre,
    /// A hash of column, row and this seed, so that a picture can be made again.
    Hash(u32),
}

/// How a value between voxels is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reconstruct {
    /// The nearest voxel.
    Nearest,
    /// Linear in x, y, z over the eight voxels around; clamped at the border.
    Trilinear,
}

/// How the gradient (of the value, in world space, per mm) is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gradient {
    /// Central differences of reconstructed values one voxel spacing to either side along each
    /// voxel axis, turned into world space by the inverse transpose of `world_from_voxel`.
    Central,
}

/// How a sample's colour is made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shade {
    /// The classified colour.
    Unlit,
    /// Blinn–Phong with the gradient as normal, turned towards the eye (two-sided). A zero gradient
    /// means unlit. Ambient and diffuse are multiplied by the surface colour, specular is white.
    BlinnPhong {
        /// Share of the surface colour that is always there, ≥ 0.
        ambient: f32,
        /// Share that follows N·L, ≥ 0.
        diffuse: f32,
        /// Strength of the highlight, ≥ 0.
        specular: f32,
        /// Exponent of N·H, > 0.
        shininess: f32,
    },
}

/// A light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PlanLight {
    /// Parallel light.
    Directional {
        /// Towards the light, world space, unit length.
        to_light: DVec3,
        /// Linear RGB, ≥ 0.
        radiance: [f32; 3],
    },
    /// Parallel to each ray, from the eye.
    Head {
        /// Linear RGB, ≥ 0.
        radiance: [f32; 3],
    },
}

/// How the samples of a ray become a pixel (before the background).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Composite {
    /// Front to back, C += (1−A)·a'·c, A += (1−A)·a', with a' = 1 − (1−a)^(step/reference).
    EmissionAbsorption {
        /// The ray ends when 1 − A falls below this; 0 never ends it early.
        stop_at_transmittance: f32,
    },
    /// The largest value of the ray, classified once. No opacity correction; unlit.
    Mip,
    /// The smallest value of the ray, classified once.
    MinIp,
    /// The mean of the values of the ray, classified once.
    Average,
    /// The first sample whose value reaches `threshold`, moved back to where it is reached between it
    /// and the sample before; shaded, opaque. `docs/plan.md` has the refinement.
    FirstHit {
        /// In values.
        threshold: f64,
    },
}

/// Keeps the half-space normal·p + offset_mm ≥ 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClipPlane {
    /// World space, unit length.
    pub normal: DVec3,
    /// Signed distance of the world's origin from the plane.
    pub offset_mm: f64,
}

/// Drops the samples inside a box, or those outside it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClipBox {
    /// World (mm) → the cube from −0.5 to 0.5.
    pub unit_from_world: DAffine3,
    /// Whether the inside is kept (else the outside).
    pub keep_inside: bool,
}

/// How linear light becomes a picture file; renderers do not use it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Display {
    /// Linear light is multiplied by this first, > 0.
    pub exposure: f32,
    /// How light above 1 is brought down.
    pub tone_map: ToneMap,
}

/// How light above 1 is brought down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ToneMap {
    /// Cut off at 1.
    Clamp,
    /// L / (1 + L) on the luminance.
    Reinhard,
}
