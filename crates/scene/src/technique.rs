//! How segments can be drawn: the techniques of a scene, and the two that every scene has.

use crate::{
    FunctionUse, GradientInput, Method, SegmentComposite, SegmentUse, Shading, TransferFunction,
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
    /// Makes it two-level: the runs of the segments that it draws, as far as they follow one another, become one run by this
    /// rule; default `emission-absorption` if `segments` is set.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub composite: Option<SegmentComposite>,
    /// Makes it two-level: how it draws which of its segments; later entries count more. Without, all are solid in their colors.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub segments: Option<Vec<SegmentUse>>,
    /// How the samples of a run become one; default `emission-absorption`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub method: Option<Method>,
    /// The value of the surface that method `first-hit` draws.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub threshold: Option<f64>,
    /// Method `mida`: −1 is emission–absorption, 0 the method itself (default), 1 the largest value alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub blend: Option<f64>,
    /// Value → color and opacity. Without it, and without a preset: white, so that segments have their own colors; solid,
    /// or for projections gray over the window.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub transfer_function: Option<TransferFunction>,
    /// How light and surface make a color.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shading: Option<Shading>,
    /// What the gradient is taken of; default `segment` where there is no transfer function, `value` elsewhere.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gradient_of: Option<GradientInput>,
    /// Functions of the library for the slots `classify`, `gradient_input`, `illuminate`, `shade`,
    /// `illustrate` and `composite`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub functions: Option<BTreeMap<String, FunctionUse>>,
}

impl SegmentTechnique {
    /// Whether its segments have techniques of their own.
    pub(crate) fn is_two_level(&self) -> bool {
        self.composite.is_some() || self.segments.is_some()
    }

    /// How it draws its segments, if it is two-level.
    pub(crate) fn uses(&self) -> &[SegmentUse] {
        self.segments.as_deref().unwrap_or(&[])
    }

    /// Whether its transfer function is its own, and with it its colors.
    pub(crate) fn has_colors(&self) -> bool {
        self.preset.is_some() || self.transfer_function.is_some()
    }
}
