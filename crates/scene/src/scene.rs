//! The Scene: what is to be drawn, as people write it. Every key may be left out.

use crate::plan;
use crate::problem::{Checker, Number, Within};
use crate::{
    Background, Camera, Clip, DebugView, FunctionUse, GradientInput, GradientMethod, GraphText,
    ImportanceSource, LabelSource, Light, Method, Placement, Reconstruct, Sampling, SceneObject,
    SegmentComposite, SegmentTechnique, SegmentUse, Shading, TransferFunction, VolumeSource,
};
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A description of a picture. A missing key takes the value of the preset, and otherwise the
/// default in `docs/scene.md`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Scene {
    /// Version of the scene format: 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("const" = 1)))]
    pub format: Option<u32>,
    /// The volume that is drawn.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub volume: Option<VolumeSource>,
    /// Moves, turns or scales the volume; default: the place in its file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub transform: Option<Placement>,
    /// Further volumes, meshes and groups to draw.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub objects: Option<Vec<SceneObject>>,
    /// Where segments come from: a label file, masks, or intervals of values. Each is drawn as `segments` says.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub labels: Option<LabelSource>,
    /// How segments can be drawn, by name. `solid` and `scene` are always there.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub techniques: Option<BTreeMap<String, SegmentTechnique>>,
    /// Which segments are drawn how; later entries count more. Without, all but the background are solid in their colors.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub segments: Option<Vec<SegmentUse>>,
    /// How the runs of segments become a pixel; default `emission-absorption`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub composite: Option<SegmentComposite>,
    /// A volume that says how important each place is: for method `importance-aware`, and for `composite`
    /// `importance-aware`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub importance: Option<ImportanceSource>,
    /// Name of the preset that fills in what is not said; without, it is chosen from the volume.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub preset: Option<String>,
    /// Reconstruction, gradient and shading, from the cheapest to the best; keys set explicitly
    /// take precedence.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub quality: Option<Quality>,
    /// The composite rule: how the samples of a ray become a pixel.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub method: Option<Method>,
    /// The value of the surface that method `first-hit` draws.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub threshold: Option<f64>,
    /// Method `mida`: −1 is emission–absorption, 0 the method itself (default), 1 the largest value alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub blend: Option<f64>,
    /// Draws a debug view instead of the data.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub debug: Option<DebugView>,
    /// The numbers that are black and white in method `gmip` (per mm) and in the debug views
    /// `gradient-magnitude` (per mm), `sample-count` and `depth` (mm); default chosen from the
    /// data.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grey_range: Option<[f64; 2]>,
    /// Maps values to color and opacity.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub transfer_function: Option<TransferFunction>,
    /// How surfaces reflect light.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shading: Option<Shading>,
    /// The lights; with an empty list only the ambient term remains.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lights: Option<Vec<Light>>,
    /// The camera.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub camera: Option<Camera>,
    /// Planes, boxes, ellipsoids, cylinders and masks that cut parts away.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clips: Option<Vec<Clip>>,
    /// Interpolation between voxels.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reconstruct: Option<Reconstruct>,
    /// How gradients are computed. Shading uses them as normals.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gradient: Option<Gradient>,
    /// Distance between samples in mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub step_mm: Option<f64>,
    /// Distance between samples in units of the smallest voxel spacing; default 0.5.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub step_voxels: Option<f64>,
    /// Where along a ray samples are taken.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sampling: Option<Sampling>,
    /// Position of the samples within their steps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub jitter: Option<Jitter>,
    /// The picture is the mean of this many frames, each with its own jitter, 1 to 65,536;
    /// default 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frames: Option<u32>,
    /// Shader functions by slot, such as `classify`: the name of a library function, or a
    /// `.wgsl` file of your own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub functions: Option<BTreeMap<String, FunctionUse>>,
    /// A render graph, or edits of the standard graph. Its keys are in
    /// `docs/graph.schema.json`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub graph: Option<GraphText>,
    /// A ray ends when its transmittance falls below this (0 to 1; 0 means never); default
    /// 1/256.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub early_termination: Option<f64>,
    /// The color encoding for compositing; default `linear`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub compositing: Option<Compositing>,
    /// The color behind everything.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub background: Option<Background>,
    /// Width and height of the picture in pixels, 1 to 65,535 each.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub size: Option<[u32; 2]>,
    /// How linear light becomes a picture file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub display: Option<Display>,
}

/// From the cheapest to the best: the four settings that S0's measurements are made with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Quality {
    /// The entry points of the rays as colors; nothing is sampled.
    Null,
    /// Nearest voxel, the value as gray, no light.
    Minimum,
    /// Trilinear, transfer function, central differences, Blinn–Phong: the defaults.
    Medium,
    /// Tricubic, the mean of nine central differences, Cook–Torrance.
    Maximum,
}

/// The color encoding for compositing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Compositing {
    /// Linear light.
    Linear,
    /// sRGB-encoded numbers, as in many other programs; for pictures that have to match theirs.
    Display,
}

/// How gradients are computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Gradient {
    /// The method; default `central`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub method: Option<GradientMethod>,
    /// The input of the gradient; default `value`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub of: Option<GradientInput>,
}

/// Position of the samples within their steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Jitter {
    /// In the middle, for every ray.
    Off,
    /// A position that differs from ray to ray, the same for the same seed.
    Seed(u32),
    /// A trigonometric hash of column and row.
    SineHash,
    /// A repeated tile of random numbers with this seed.
    WhiteTile(u32),
    /// A repeated tile of blue noise with this seed: the least visible grain.
    BlueTile(u32),
}

/// How linear light becomes a picture file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Display {
    /// Factor for the light before tone mapping, 1e-6 to 1e6.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exposure: Option<f64>,
    /// The tone map: how light above white is compressed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tone_map: Option<ToneMap>,
    /// The light that becomes white with `reinhard-extended` and `hable`, 0.001 to 1e6.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub white_point: Option<f64>,
    /// Encodes colors with the power 1/gamma, 0.1 to 10, instead of the sRGB curve.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gamma: Option<f64>,
    /// Smooths jagged edges of the finished picture (FXAA).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fxaa: Option<bool>,
    /// Makes the negative of the finished colors: white becomes black, as figures in print often are. Opacity stays.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub invert: Option<bool>,
}

/// The tone map: how light above white is compressed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum ToneMap {
    /// Cut off.
    Clamp,
    /// L / (1 + L) on the luminance.
    Reinhard,
    /// L · (1 + L / W²) / (1 + L) on the luminance: `white_point` W becomes white.
    ReinhardExtended,
    /// The filmic curve of the ACES reference, as fitted by K. Narkowicz.
    Aces,
    /// The filmic curve of J. Hable; `white_point` becomes white.
    Hable,
}

impl ToneMap {
    /// Every tone map.
    pub const ALL: [ToneMap; 5] = [
        ToneMap::Clamp,
        ToneMap::Reinhard,
        ToneMap::ReinhardExtended,
        ToneMap::Aces,
        ToneMap::Hable,
    ];

    /// The name used in scenes and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            ToneMap::Clamp => "clamp",
            ToneMap::Reinhard => "reinhard",
            ToneMap::ReinhardExtended => "reinhard-extended",
            ToneMap::Aces => "aces",
            ToneMap::Hable => "hable",
        }
    }

    /// The light that becomes white unless a scene says otherwise; `None` where nothing can be said.
    pub fn default_white_point(self) -> Option<f64> {
        match self {
            ToneMap::ReinhardExtended => Some(4.0),
            // As in the game that it was made for.
            ToneMap::Hable => Some(11.2),
            ToneMap::Clamp | ToneMap::Reinhard | ToneMap::Aces => None,
        }
    }
}

impl std::str::FromStr for ToneMap {
    type Err = String;

    fn from_str(name: &str) -> Result<ToneMap, String> {
        ToneMap::ALL
            .into_iter()
            .find(|map| map.name() == name)
            .ok_or_else(|| {
                let names = ToneMap::ALL.map(ToneMap::name).join(", ");
                format!("{name:?} is not a tone map; known are {names}")
            })
    }
}

/// [`Display`] with everything said.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SettledDisplay {
    pub exposure: f64,
    pub tone_map: ToneMap,
    /// Read by the tone maps that have one.
    pub white_point: f64,
    /// `None`: the curve of sRGB.
    pub gamma: Option<f64>,
    pub fxaa: bool,
    pub invert: bool,
}

impl Display {
    /// The numbers of this, then of `preset`, then the defaults.
    pub(crate) fn settled(self, preset: Display, checker: &mut Checker) -> SettledDisplay {
        let tone_map = self.tone_map.or(preset.tone_map).unwrap_or(ToneMap::Clamp);
        let default_white = tone_map.default_white_point();
        if let (Some(white), None) = (self.white_point, default_white) {
            checker.add(
                "display.white_point",
                Number(white),
                &format!(
                    "none with tone_map {:?}; reinhard-extended and hable have one",
                    tone_map.name()
                ),
            );
        }
        let preset_white = (preset.tone_map == Some(tone_map)).then_some(preset.white_point);
        SettledDisplay {
            exposure: self.exposure.or(preset.exposure).unwrap_or(1.0),
            tone_map,
            white_point: match default_white {
                Some(white) => self.white_point.or(preset_white.flatten()).unwrap_or(white),
                None => 1.0,
            },
            gamma: self.gamma.or(preset.gamma),
            fxaa: self.fxaa.or(preset.fxaa).unwrap_or(false),
            invert: self.invert.or(preset.invert).unwrap_or(false),
        }
    }
}

impl SettledDisplay {
    /// As a scene says it.
    pub fn scene(self) -> Display {
        Display {
            exposure: Some(self.exposure),
            tone_map: Some(self.tone_map),
            white_point: self
                .tone_map
                .default_white_point()
                .map(|_| self.white_point),
            gamma: self.gamma,
            fxaa: Some(self.fxaa),
            invert: Some(self.invert),
        }
    }

    /// With every number checked.
    pub fn plan(self, checker: &mut Checker) -> plan::Display {
        checker.number("display.exposure", self.exposure, Within::Closed(1e-6, 1e6));
        checker.number(
            "display.white_point",
            self.white_point,
            Within::Closed(1e-3, 1e6),
        );
        if let Some(gamma) = self.gamma {
            checker.number("display.gamma", gamma, Within::Closed(0.1, 10.0));
        }
        let white = self.white_point as f32;
        plan::Display {
            exposure: self.exposure as f32,
            tone_map: match self.tone_map {
                ToneMap::Clamp => plan::ToneMap::Clamp,
                ToneMap::Reinhard => plan::ToneMap::Reinhard,
                ToneMap::ReinhardExtended => plan::ToneMap::ReinhardExtended { white },
                ToneMap::Aces => plan::ToneMap::Aces,
                ToneMap::Hable => plan::ToneMap::Hable { white },
            },
            curve: match self.gamma {
                None => plan::DisplayCurve::Srgb,
                Some(gamma) => plan::DisplayCurve::Power {
                    gamma: gamma as f32,
                },
            },
            invert: self.invert,
            fxaa: self.fxaa,
            background: None,
        }
    }
}
