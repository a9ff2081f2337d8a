//! The Plan: a scene with nothing left to decide, the contract of all renderers (`docs/plan.md`).
//!
//! No field is optional, every length is in mm or says its unit, every color is linear, every
//! number is finite and inside its range. Only [`resolve`](crate::resolve) makes a Plan; a renderer
//! that gets one meets no bad value any more.

use crate::transfer::TransferTable;
use glam::{DAffine3, DVec3};
use std::collections::BTreeMap;
use std::sync::Arc;
use strahl_shader::Module;
pub use strahl_shader::for_each_function;
pub use strahl_shader::registry::{
    Classify, Composite, DebugView, Fetch, GradientInput, GradientMethod, Illuminate, Illustrate,
    Reconstruct, Shade,
};
use strahl_volume::{Grid, Rescale};

/// Everything a renderer needs beside the data (voxels, masks, triangles), which is handed to it as
/// [`Datasets`](strahl_volume::Datasets).
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Pixels per row, 1 to [`MOST_EDGE_PIXELS`].
    pub width: u32,
    /// Rows, 1 to [`MOST_EDGE_PIXELS`].
    pub height: u32,
    /// Where the rays start and go.
    pub camera: PlanCamera,
    /// What can be sampled, at least one.
    pub fields: Vec<Field>,
    /// How it can be drawn, at least one.
    pub techniques: Vec<Technique>,
    /// Which fields are drawn by which techniques, 1 to [`MOST_LAYERS`]; more than one only with composites
    /// that [mix](Composite::mixes_layers).
    pub layers: Vec<Layer>,
    /// How runs of segments become a pixel, where a layer has segments of a label volume. Without them nothing asks for it.
    pub global_rule: GlobalRule,
    /// How important places are, where a technique or the rule of runs asks for it.
    pub importance: Option<PlanImportance>,
    /// Opaque surfaces among them, any number.
    pub meshes: Vec<PlanMesh>,
    /// Where along the ray samples lie.
    pub lattice: Lattice,
    /// Which points of the lattice, or between them, are looked at.
    pub sampling: Sampling,
    /// The lights, none if unlit and without meshes.
    pub lights: Vec<PlanLight>,
    /// Half-spaces that rays are cut to before the lattice is laid.
    pub ray_clips: Vec<ClipPlane>,
    /// Shapes that drop single samples.
    pub sample_clips: Vec<SampleClip>,
    /// The user's own shader functions, each in place of what the field of its slot says (clips and
    /// lights: beside them). A renderer without a twin for one refuses the Plan by name.
    pub modules: Vec<PlanModule>,
    /// Behind everything; premultiplied, in the space of `compositing`. Alpha 0 leaves the picture
    /// transparent.
    pub background: [f32; 4],
    /// What the colors of tables, lights, meshes and background are, and therefore in which numbers
    /// samples are added up. Pictures are linear whatever this says: see
    /// [`Image::into_linear`](crate::Image::into_linear).
    pub compositing: Compositing,
    /// Whether the distance of the hit is wanted beside the color.
    pub with_depth: bool,
    /// How linear light becomes a picture file.
    pub display: Display,
}

/// Layers in one picture: a bit each in [`LayerSet`], an object each in a ray loop of shader programs.
pub const MOST_LAYERS: usize = strahl_shader::MOST_OBJECTS;

/// Masks in one picture. Shader programs, by which the GPU and graphs draw, hold fewer:
/// [`strahl_shader::MOST_MASKS`].
pub const MOST_MASKS: usize = 256;

/// Pixels along an edge of a picture.
pub const MOST_EDGE_PIXELS: u32 = 65_535;

/// Frames that a picture is the mean of.
pub const MOST_FRAMES: u32 = 65_536;

/// A set of layers: bit i is layer i.
pub type LayerSet = u32;

/// Every layer.
pub const ALL_LAYERS: LayerSet = LayerSet::MAX;

/// What can be sampled: a volume at its place, and how values and gradients are read from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Field {
    /// Which of the volumes; several fields may read the same.
    pub volume: usize,
    /// Where its voxels lie in the world, with all transforms.
    pub grid: Grid,
    /// Whether there are transforms: without, `grid` is the volume's own.
    pub is_moved: bool,
    /// What a stored number means.
    pub rescale: Rescale,
    /// What a voxel holds.
    pub fetch: Fetch,
    /// Interpolation between voxels.
    pub reconstruct: Reconstruct,
    /// How the gradient is found.
    pub gradient: GradientMethod,
}

/// How values are drawn, whatever they are values of.
#[derive(Clone, Debug, PartialEq)]
pub struct Technique {
    /// Maps values to color and opacity.
    pub classify: Classify,
    /// Its transfer function.
    pub table: TransferTable,
    /// The input of the gradient.
    pub gradient_input: GradientInput,
    /// How a sample's color follows from its surface color, gradient and the lights.
    pub shade: Shade,
    /// What illustration makes of that color.
    pub illustrate: Illustrate,
    /// How samples in a row become one.
    pub composite: Composite,
}

/// A field in the picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// Which of the fields.
    pub field: usize,
    /// What is drawn of it, and by which techniques.
    pub segments: Segments,
}

/// What a layer draws of its field.
#[derive(Clone, Debug, PartialEq)]
pub enum Segments {
    /// All of it, by technique number `technique`.
    Whole {
        /// Which of the techniques.
        technique: usize,
    },
    /// The segments of a label volume, each by a technique of its own. Such a layer is the only one, and its
    /// techniques have any [local rule](Composite::is_local).
    Labeled(Box<Labeled>),
}

/// The segments of a label volume. Beyond its extent is the segment with id 0.
///
/// ```
/// use strahl_scene::plan::{Composite, Labeled, SegmentLook, Segments};
/// use strahl_scene::{Scene, resolve};
/// use strahl_volume::{Datasets, Phantom};
///
/// let dims = [40, 30, 50];
/// let volume = Phantom::Anatomy.volume(dims)?;
/// let labels = Phantom::Anatomy.labels(dims)?.expect("the anatomy has labels");
/// let mut plan = resolve(&Scene::parse("scene", "{}")?, &volume.header(), None)?;
/// // Technique 0 is the scene's; technique 1 shows the largest value of a run.
/// let mut projection = plan.technique().clone();
/// projection.composite = Composite::Mip;
/// plan.techniques.push(projection);
/// plan.layers[0].segments = Segments::Labeled(Box::new(Labeled {
///     labels: 0,
///     grid: *labels.grid(),
///     is_moved: false,
///     looks: [(0, SegmentLook::HIDDEN), (1, SegmentLook::of(1))].into(),
///     others: SegmentLook::of(0),
///     groups: Vec::new(),
/// }));
/// let data = Datasets { labels: vec![labels], ..Datasets::from(&volume) };
/// plan.check(&data)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Labeled {
    /// Which of the label volumes.
    pub labels: usize,
    /// Where its voxels lie in the world, with all transforms.
    pub grid: Grid,
    /// Whether there are transforms: without, `grid` is the label volume's own.
    pub is_moved: bool,
    /// How the segment with an id is drawn.
    pub looks: BTreeMap<u32, SegmentLook>,
    /// The same for all other ids.
    pub others: SegmentLook,
    /// At most [`MOST_GROUPS`].
    pub groups: Vec<SegmentGroup>,
}

/// Segments whose runs add up among themselves: those in a row make one sample, which counts as a run beside those of
/// segments without a group.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SegmentGroup {
    /// How its runs become its sample; it ends no ray.
    pub rule: GlobalRule,
    /// What the opacity of the sample is multiplied by, 0 to 1.
    pub opacity: f32,
    /// Of the sample, for [`GlobalRule::ImportanceAware`]; 0 or more.
    pub importance: f32,
}

/// Groups of segments.
pub const MOST_GROUPS: usize = 8;

/// How a segment is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SegmentLook {
    /// By which of the techniques; `None` hides the segment.
    pub technique: Option<usize>,
    /// What the color of each of its runs is multiplied by; in the space of `compositing`.
    pub tint: [f32; 3],
    /// What the opacity of each of its runs is multiplied by, 0 to 1.
    pub opacity: f32,
    /// Of its runs, for [`GlobalRule::ImportanceAware`]; 0 or more.
    pub importance: f32,
    /// Which of the groups it belongs to, if to one.
    pub group: Option<usize>,
}

/// How runs of segments become a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GlobalRule {
    /// Each run hides what is behind it by its opacity.
    EmissionAbsorption {
        /// The ray ends when less than this share of light still passes, 0 to 1.
        stop_at_transmittance: f32,
    },
    /// The run of the largest luminance, premultiplied.
    Mip,
    /// The mean of all runs that are not transparent, premultiplied.
    Average,
    /// The first run that is not transparent.
    First,
    /// Runs of important segments show through what lies before them: [`Composite::ImportanceAware`] over runs.
    ImportanceAware,
}

/// Importance by place: values of one of the masks, linear between its voxels; 0 beyond its extent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanImportance {
    /// Which of the masks.
    pub mask: usize,
    /// World (mm) → the cube from −0.5 to 0.5 that holds the mask.
    pub unit_from_world: DAffine3,
    /// The value that counts as 0 …
    pub low: f32,
    /// … and the one that counts as 1; not `low`.
    pub high: f32,
    /// Of [`GlobalRule::ImportanceAware`]: to the importance of a run the largest share among its samples is added, times
    /// this; 0 or more.
    pub gain_of_runs: f32,
}

impl GlobalRule {
    /// The share of light at which a ray ends whatever its segments are.
    pub fn stop_at_transmittance(self) -> f32 {
        match self {
            GlobalRule::EmissionAbsorption {
                stop_at_transmittance,
            } => stop_at_transmittance,
            _ => 0.0,
        }
    }
}

impl SegmentLook {
    /// That of a segment that is not drawn.
    pub const HIDDEN: SegmentLook = SegmentLook {
        technique: None,
        tint: [1.0; 3],
        opacity: 1.0,
        importance: 0.0,
        group: None,
    };

    /// That of a segment as technique number `technique` draws it.
    pub const fn of(technique: usize) -> SegmentLook {
        SegmentLook {
            technique: Some(technique),
            ..SegmentLook::HIDDEN
        }
    }

    /// What the runs, premultiplied, are multiplied by.
    fn factors(&self) -> [f32; 4] {
        let [r, g, b] = self.tint.map(|channel| channel * self.opacity);
        [r, g, b, self.opacity]
    }
}

/// Segments by the numbers that label volumes have in place of ids.
#[derive(Clone, Debug, PartialEq)]
pub struct NumberedSegments {
    /// By the number of a segment its technique, counted from 1; 0 hides it.
    pub techniques: Vec<u32>,
    /// By the number of a segment what its runs, premultiplied, are multiplied by: tint and opacity.
    pub factors: Vec<[f32; 4]>,
    /// By the number of a segment the importance of its runs.
    pub importances: Vec<f32>,
    /// By the number of a segment its group, counted from 1; 0 without.
    pub groups: Vec<u32>,
    /// The number of the segment beyond the extent of the label volume.
    pub outside: u32,
}

impl Labeled {
    /// The map from the voxels of `field` to those of the label volume: no map where both have one grid.
    pub fn label_from_voxel(&self, field: &Field) -> DAffine3 {
        if self.grid == field.grid {
            DAffine3::IDENTITY
        } else {
            self.grid.voxel_from_world() * field.grid.world_from_voxel()
        }
    }

    /// The techniques of segments that have numbers, where number n belongs to the id `ids[n]`.
    pub fn numbered(&self, ids: &[u32]) -> NumberedSegments {
        // Beyond the extent is id 0, whether a voxel has it or not.
        let outside = ids.iter().position(|id| *id == 0).unwrap_or(ids.len());
        let drawn = ids.iter().chain((outside == ids.len()).then_some(&0));
        let looks: Vec<_> = drawn.map(|id| self.look_of(*id)).collect();
        let technique =
            |look: &SegmentLook| look.technique.map_or(0, |technique| technique as u32 + 1);
        NumberedSegments {
            techniques: looks.iter().map(technique).collect(),
            factors: looks.iter().map(SegmentLook::factors).collect(),
            importances: looks.iter().map(|look| look.importance).collect(),
            // One that is hidden is in no group, so that rays may pass it without a look at it.
            groups: looks
                .iter()
                .map(|look| look.group.filter(|_| look.technique.is_some()))
                .map(|group| group.map_or(0, |group| group as u32 + 1))
                .collect(),
            outside: outside as u32,
        }
    }

    /// How the segment with this id is drawn.
    pub fn look_of(&self, id: u32) -> SegmentLook {
        self.looks.get(&id).copied().unwrap_or(self.others)
    }
}

impl Field {
    /// Whether it is reconstructed from B-spline coefficients, which are values, instead of its volume.
    pub fn reads_coefficients(&self) -> bool {
        self.reconstruct == Reconstruct::BSplineInterpolating && self.fetch == Fetch::Stored
    }
}

impl Plan {
    /// The field of the first layer: the only one of most pictures.
    pub fn field(&self) -> &Field {
        self.field_of(0)
    }

    /// [`field`](Self::field), to be changed.
    pub fn field_mut(&mut self) -> &mut Field {
        &mut self.fields[self.layers[0].field]
    }

    /// The field that layer number `layer` shows.
    pub fn field_of(&self, layer: usize) -> &Field {
        &self.fields[self.layers[layer].field]
    }

    /// The fields of the layers, in their order.
    pub fn drawn_fields(&self) -> impl Iterator<Item = &Field> {
        self.layers.iter().map(|layer| &self.fields[layer.field])
    }

    /// The technique of the first layer: the only one of most pictures.
    pub fn technique(&self) -> &Technique {
        self.technique_of(0)
    }

    /// [`technique`](Self::technique), to be changed.
    pub fn technique_mut(&mut self) -> &mut Technique {
        let technique = self.technique_number(0);
        &mut self.techniques[technique]
    }

    /// The technique that draws layer number `layer`; of one with segments the first of all.
    pub fn technique_of(&self, layer: usize) -> &Technique {
        &self.techniques[self.technique_number(layer)]
    }

    pub(crate) fn technique_number(&self, layer: usize) -> usize {
        match self.layers[layer].segments {
            Segments::Whole { technique } => technique,
            Segments::Labeled(_) => 0,
        }
    }

    /// The segments of the layer, if it has those of a label volume.
    pub fn labeled(&self) -> Option<&Labeled> {
        match &self.layers[0].segments {
            Segments::Whole { .. } => None,
            Segments::Labeled(labeled) => Some(labeled),
        }
    }

    /// Whether the importance of runs makes a difference.
    pub fn weighs_runs(&self) -> bool {
        let is_weighing = |rule: GlobalRule| rule == GlobalRule::ImportanceAware;
        self.labeled().is_some_and(|labeled| {
            is_weighing(self.global_rule) || labeled.groups.iter().any(|g| is_weighing(g.rule))
        })
    }

    /// Among what the samples of a ray choose: the techniques of the layers, in their order; of one with
    /// segments all techniques.
    pub fn drawn_techniques(&self) -> impl Iterator<Item = &Technique> {
        let (of_segments, of_layers) = match self.labeled() {
            Some(_) => (&self.techniques[..], &self.layers[..0]),
            None => (&self.techniques[..0], &self.layers[..]),
        };
        let of_layers = (0..of_layers.len()).map(|layer| self.technique_of(layer));
        of_segments.iter().chain(of_layers)
    }

    /// How all that a ray meets adds up: the rule of the one technique, or that of runs of segments.
    pub fn composite(&self) -> Composite {
        match self.labeled() {
            Some(_) => Composite::EmissionAbsorption {
                stop_at_transmittance: self.global_rule.stop_at_transmittance(),
            },
            None => self.technique().composite,
        }
    }

    /// Whether all layers are drawn in the same way, but for their tables, and none has segments.
    pub fn has_one_technique(&self) -> bool {
        let first = self.technique();
        self.labeled().is_none()
            && self.drawn_techniques().all(|technique| {
                technique.classify == first.classify
                    && technique.gradient_input == first.gradient_input
                    && technique.shade == first.shade
                    && technique.illustrate == first.illustrate
                    && technique.composite == first.composite
            })
    }

    /// Adds a layer that shows `field` by `technique`.
    pub fn add_layer(&mut self, field: Field, technique: Technique) {
        self.layers.push(Layer {
            field: self.fields.len(),
            segments: Segments::Whole {
                technique: self.techniques.len(),
            },
        });
        self.fields.push(field);
        self.techniques.push(technique);
    }
}

/// An opaque surface of triangles, seen from both sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanMesh {
    /// Which of the meshes.
    pub mesh: usize,
    /// Its place.
    pub world_from_mesh: DAffine3,
    /// Its color, lit by the lights of the Plan as [`Illuminate::Lambert`] with diffuse 0.75 and ambient 0.25.
    pub color: [f32; 3],
}

/// A shader function of the user.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanModule {
    /// The function, checked; it names its slot.
    pub module: Arc<Module>,
    /// Values of parameters, checked; those that are not here have their default.
    pub values: Vec<(String, Vec<f64>)>,
}

/// In which numbers colors are added up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compositing {
    /// Linear light: what light does.
    Linear,
    /// sRGB-encoded numbers, as programs do that know no color spaces; for pictures that have to
    /// match theirs.
    Display,
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
    /// The projection.
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
    /// How far from the start of its ray what is nearest in the box of `grid` is, and what is farthest.
    pub fn depths_mm(&self, grid: &Grid) -> [f64; 2] {
        let (low, high) = grid.bounds_mm();
        let corners = (0..8).map(|i| {
            let at = |axis: usize| {
                if i >> axis & 1 == 0 {
                    low[axis]
                } else {
                    high[axis]
                }
            };
            DVec3::new(at(0), at(1), at(2))
        });
        let depth = |corner: DVec3| match self.projection {
            Projection::Perspective { .. } => corner.distance(self.eye_mm),
            Projection::Orthographic { .. } => (corner - self.eye_mm).dot(self.forward).max(0.0),
        };
        let (mut near, mut far) = (f64::INFINITY, 0.0f64);
        for corner in corners {
            (near, far) = (near.min(depth(corner)), far.max(depth(corner)));
        }
        if let Projection::Perspective { .. } = self.projection {
            // A face may be nearer than all corners.
            near = self.eye_mm.clamp(low, high).distance(self.eye_mm);
        }
        [near, far]
    }

    /// The ray through the center of the pixel in column `x`, row `y` of a `width` × `height`
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

/// Sample k of a ray lies at t = t_entry + (k + jitter)·step_mm, k = 0, 1, … while t < t_exit.
/// t_entry is where the ray, starting at t ≥ 0, first enters the sampled extent of an object, cut by
/// the ray clips for it; t_exit where it has left all.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    /// Distance between samples in mm, > 0.
    pub step_mm: f64,
    /// Position of the samples within their steps.
    pub jitter: Jitter,
    /// The picture is the mean of this many, each with its own jitter; 1 to [`MOST_FRAMES`].
    pub frames: u32,
}

/// Where in its step the samples of a ray lie, in [0, 1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Jitter {
    /// In the middle: 0.5 for every ray.
    Center,
    /// A hash of column, row, this seed and the frame, so that a picture can be made again.
    Hash(u32),
    /// The trigonometric hash fract(cos(11.55·x + 42.123·y)·35684.525), moved on by the golden ratio
    /// each frame. It depends on how a machine computes cosines.
    SineHash,
    /// A tile of 32 × 32 random numbers with this seed, repeated over the picture.
    WhiteTile(u32),
    /// A tile of 64 × 64 numbers of blue noise with this seed, repeated over the picture.
    BlueTile(u32),
}

/// Which points of a ray are looked at (`docs/plan.md` says exactly which). All but `Regular` come with
/// [`Composite::EmissionAbsorption`] and one object only; `Refine` with [`Composite::Mip`] and [`Composite::Minip`], too.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sampling {
    /// One sample at every lattice point.
    Regular,
    /// `parts` samples per step where the transfer function shows something between the values at both ends. Of a
    /// projection: a look around its value, down to one of `parts` of a step.
    Refine {
        /// 1 to 64.
        parts: u32,
    },
    /// The same with values between those of lattice points, and gradients on the line between both.
    Split {
        /// 1 to 64.
        parts: u32,
        /// How values go from one lattice point to the next.
        curve: Curve,
    },
    /// What the table shows along the line of values from one lattice point to the next, lit by one gradient;
    /// [`Classify::Table`].
    Integrated,
    /// One sample for several lattice points in a row where the table hardly changes; unlit, [`Classify::Table`].
    Adaptive {
        /// By how much a channel of a pixel may differ from the regular picture (in light of which a ray may not end
        /// early), above 0 to 0.5.
        error: f32,
    },
    /// One sample for one, two or four lattice points in a row, as the opacity around allows; [`Classify::Table`].
    ByOpacity {
        /// How much of the pixel a sample for more than one may make up, above 0 to 1.
        share: f32,
    },
}

impl Sampling {
    /// Samples per step where something is shown.
    pub fn parts(self) -> u32 {
        match self {
            Sampling::Regular
            | Sampling::Integrated
            | Sampling::Adaptive { .. }
            | Sampling::ByOpacity { .. } => 1,
            Sampling::Refine { parts } | Sampling::Split { parts, .. } => parts,
        }
    }

    /// Whether what lies between two lattice points is shown, not only what lies at them.
    pub fn is_of_segments(self) -> bool {
        self.parts() > 1 || self == Sampling::Integrated
    }

    /// The name that scenes give it.
    pub fn name(self) -> &'static str {
        match self {
            Sampling::Regular => "regular",
            Sampling::Refine { .. } => "refine",
            Sampling::Split {
                curve: Curve::Linear,
                ..
            } => "split",
            Sampling::Split {
                curve: Curve::Cubic,
                ..
            } => "split-cubic",
            Sampling::Integrated => "integrated",
            Sampling::Adaptive { .. } => "adaptive",
            Sampling::ByOpacity { .. } => "by-opacity",
        }
    }
}

/// How values go from one lattice point to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Curve {
    /// On a line.
    Linear,
    /// On J. Lagrange's cubic through two lattice points to either side, cut to between both ends.
    Cubic,
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
    /// A lamp; its light falls with the square of the distance.
    Point {
        /// Where it is.
        place_mm: DVec3,
        /// The distance at which the radiance is as given, > 0; none is nearer than a thousandth of it.
        reach_mm: f32,
        /// Linear RGB, ≥ 0.
        radiance: [f32; 3],
    },
    /// Parallel to each ray, from the eye.
    Head {
        /// Linear RGB, ≥ 0.
        radiance: [f32; 3],
    },
}

/// Keeps the half-space normal·p + offset_mm ≥ 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClipPlane {
    /// World space, unit length.
    pub normal: DVec3,
    /// Signed distance of the world's origin from the plane.
    pub offset_mm: f64,
    /// Which layers it cuts.
    pub layers: LayerSet,
}

/// Drops the samples inside a shape, or those outside it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampleClip {
    /// The shape.
    pub shape: ClipShape,
    /// World (mm) → the cube from −0.5 to 0.5 that holds the shape.
    pub unit_from_world: DAffine3,
    /// Whether the inside is kept (else the outside).
    pub keep_inside: bool,
    /// Which layers it cuts.
    pub layers: LayerSet,
}

impl SampleClip {
    /// Whether it cuts layer number `layer`.
    pub fn cuts(&self, layer: usize) -> bool {
        self.layers >> layer & 1 == 1
    }
}

/// A shape in the cube from −0.5 to 0.5.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ClipShape {
    /// The cube.
    Box,
    /// The ball.
    Ellipsoid,
    /// The cylinder along z.
    Cylinder,
    /// Where the values of a mask, linear between its voxel centers, are above a threshold. The cube is
    /// the extent of the mask's grid; outside it is no mask.
    Mask {
        /// Which of the masks.
        mask: usize,
        /// In values of the mask.
        threshold: f32,
    },
}

/// How linear light becomes a picture file; renderers do not use it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Display {
    /// Linear light is multiplied by this first, > 0.
    pub exposure: f32,
    /// How light above 1 is brought down.
    pub tone_map: ToneMap,
    /// Light from 0 to 1 → the numbers of the file.
    pub curve: DisplayCurve,
    /// Whether jagged edges of the encoded picture are smoothed.
    pub fxaa: bool,
    /// Whether encoded colors become their negative.
    pub invert: bool,
    /// An opaque background, in linear light, that is put behind the picture after the tone map, so that it keeps its
    /// color. The background of the Plan is transparent then. `None` if exposure, tone map and curve do not change
    /// light from 0 to 1: the picture contains its background.
    pub background: Option<[f32; 3]>,
}

impl Display {
    /// Light as it is, up to 1, in the curve of sRGB.
    pub const PLAIN: Display = Display {
        exposure: 1.0,
        tone_map: ToneMap::Clamp,
        curve: DisplayCurve::Srgb,
        fxaa: false,
        invert: false,
        background: None,
    };

    /// Whether light from 0 to 1 keeps its color.
    fn is_plain(&self) -> bool {
        self.exposure == 1.0 && self.tone_map == ToneMap::Clamp && self.curve == DisplayCurve::Srgb
    }

    /// Takes over an opaque background that this would change; `linear` is its color in linear light.
    pub(crate) fn take_background(&mut self, background: &mut [f32; 4], linear: [f32; 3]) {
        if background[3] == 1.0 && !self.is_plain() {
            self.background = Some(linear);
            *background = [0.0; 4];
        }
    }
}

/// How light above 1 is brought down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ToneMap {
    /// Cut off at 1.
    Clamp,
    /// L / (1 + L) on the luminance.
    Reinhard,
    /// L · (1 + L / white²) / (1 + L) on the luminance.
    ReinhardExtended {
        /// The luminance that becomes 1, > 0.
        white: f32,
    },
    /// Narkowicz's fit of the ACES curve, per channel.
    Aces,
    /// Hable's filmic curve, per channel.
    Hable {
        /// The light that becomes 1, > 0.
        white: f32,
    },
}

/// Light from 0 to 1 → display numbers from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DisplayCurve {
    /// IEC 61966-2-1.
    Srgb,
    /// light^(1/gamma).
    Power {
        /// > 0.
        gamma: f32,
    },
}
