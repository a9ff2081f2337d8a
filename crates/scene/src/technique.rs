//! How segments can be drawn: the techniques of a scene, and the two that every scene has.

use crate::{
    Color, FunctionUse, Gradient, GradientInput, Method, PresetInfo, Scene, Shading,
    TransferFunction, TransferPoint,
};
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The technique that the keys of the scene itself say.
pub const SCENE: &str = "scene";

/// The technique of segments for which nothing is said: solid, in the color of the segment, lit by its border.
pub const SOLID: &str = "solid";

/// How segments are drawn.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct SegmentTechnique {
    /// Name of a preset that fills in what is not set here.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub preset: Option<String>,
    /// How the samples of a run become one; default `emission-absorption`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub method: Option<Method>,
    /// The value of the surface that method `first-hit` draws.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub threshold: Option<f64>,
    /// Method `mida`: −1 is emission–absorption, 0 the method itself (default).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub blend: Option<f64>,
    /// Value → color and opacity. Without it, and without a preset: white, so that segments have their own colors; solid,
    /// or for projections grey over the window.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub transfer_function: Option<TransferFunction>,
    /// How light and surface make a color.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shading: Option<Shading>,
    /// What the gradient is taken of; default `segment` where there is no transfer function, `value` elsewhere.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gradient_of: Option<GradientInput>,
    /// Functions of the library for the slots `classify` and `composite`, with their parameters.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub functions: Option<BTreeMap<String, FunctionUse>>,
}

impl SegmentTechnique {
    /// Whether its transfer function is its own, and with it its colors.
    pub(crate) fn has_colors(&self) -> bool {
        self.preset.is_some() || self.transfer_function.is_some()
    }

    /// A scene of one volume that is drawn by this technique.
    pub(crate) fn scene(&self, scene: &Scene) -> Scene {
        let is_projection = self.method.is_some_and(Method::is_projection);
        let solid = || TransferFunction {
            points: Some(vec![TransferPoint::new(0.0, 0.95, Color::WHITE)]),
            ..TransferFunction::default()
        };
        let (transfer_function, of) = match self.has_colors() || is_projection {
            true => (self.transfer_function.clone(), GradientInput::Value),
            false => (Some(solid()), GradientInput::Segment),
        };
        let method = match self.preset.as_deref().and_then(PresetInfo::find) {
            Some(_) => self.method,
            None => Some(self.method.unwrap_or(Method::EmissionAbsorption)),
        };
        Scene {
            preset: self.preset.clone(),
            method,
            threshold: self.threshold,
            blend: self.blend,
            transfer_function,
            shading: self.shading,
            gradient: Some(Gradient {
                of: Some(self.gradient_of.unwrap_or(of)),
                method: None,
            }),
            functions: self.functions.clone(),
            transform: scene.transform,
            early_termination: scene.early_termination,
            compositing: scene.compositing,
            step_mm: scene.step_mm,
            step_voxels: scene.step_voxels,
            ..Scene::default()
        }
    }
}
