//! What a level of quality decides; keys of the scene count more.

use crate::{
    DebugView, Gradient, GradientMethod, Method, Quality, Reconstruct, Scene, Shading, ShadingModel,
};

impl Quality {
    /// The keys that it decides, as a scene.
    pub(crate) fn scene(self, method: Method) -> Scene {
        let shading = |model| {
            (!method.is_projection()).then_some(Shading {
                model: Some(model),
                ..Shading::default()
            })
        };
        match self {
            Quality::Medium => Scene::default(),
            Quality::Null => Scene {
                debug: Some(DebugView::Entry),
                ..Scene::default()
            },
            Quality::Minimum => Scene {
                reconstruct: Some(Reconstruct::Nearest),
                shading: shading(ShadingModel::Unlit),
                ..Scene::default()
            },
            Quality::Maximum => Scene {
                reconstruct: Some(Reconstruct::BSplineInterpolating),
                gradient: Some(Gradient {
                    method: Some(GradientMethod::Central9),
                    of: None,
                }),
                shading: shading(ShadingModel::CookTorrance),
                ..Scene::default()
            },
        }
    }

    /// Whether the value itself is shown as gray, without a transfer function.
    pub(crate) fn shows_values(self, method: Method) -> bool {
        self == Quality::Minimum && !method.is_projection()
    }
}
