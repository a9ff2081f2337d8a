//! How light and surface make a color: from what a scene says to the Plan's [`Shade`].

use crate::plan::Shade;
use crate::problem::{Checker, Within};
use crate::{Method, ShadingModel};
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How surfaces reflect light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Shading {
    /// The model.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub model: Option<ShadingModel>,
    /// Factor of the color that is visible without light, 0 to 10.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ambient: Option<f64>,
    /// Factor of the color that depends on the angle to the light, 0 to 10.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub diffuse: Option<f64>,
    /// Strength of the white highlight, 0 to 10.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub specular: Option<f64>,
    /// Exponent of the highlight, above 0 to 1000: the larger, the smaller the highlight.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shininess: Option<f64>,
    /// `cook-torrance`: how rough the surface is, 0.05 to 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub roughness: Option<f64>,
    /// `cook-torrance`: fraction of the light that is reflected at normal incidence, 0 to 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reflectance: Option<f64>,
    /// A sample without a gradient uses the last normal of its ray; default false.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub keep_last_normal: Option<bool>,
    /// `gradient-opacity`: the gradient magnitude at which the opacity is unchanged, in values
    /// per mm; default chosen from the data.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub full_per_mm: Option<f64>,
}

/// [`Shading`] with a number for everything, also for what the model does not ask for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SettledShading {
    pub model: ShadingModel,
    pub ambient: f64,
    pub diffuse: f64,
    pub specular: f64,
    pub shininess: f64,
    pub roughness: f64,
    pub reflectance: f64,
    pub keep_last_normal: bool,
    pub full_per_mm: f64,
}

impl Shading {
    /// What this says, then what `preset` does, then the defaults; `steep_per_mm` is a gradient that is steep in the data.
    pub(crate) fn settled(
        self,
        preset: Shading,
        method: Method,
        steep_per_mm: f64,
    ) -> SettledShading {
        let default = if method.is_projection() {
            ShadingModel::Unlit
        } else {
            preset.model.unwrap_or(ShadingModel::BlinnPhong)
        };
        let number =
            |own: Option<f64>, preset: Option<f64>, default: f64| own.or(preset).unwrap_or(default);
        SettledShading {
            model: self.model.unwrap_or(default),
            ambient: number(self.ambient, preset.ambient, 0.25),
            diffuse: number(self.diffuse, preset.diffuse, 0.75),
            specular: number(self.specular, preset.specular, 0.2),
            shininess: number(self.shininess, preset.shininess, 24.0),
            roughness: number(self.roughness, preset.roughness, 0.4),
            reflectance: number(self.reflectance, preset.reflectance, 0.08),
            keep_last_normal: self
                .keep_last_normal
                .or(preset.keep_last_normal)
                .unwrap_or(false),
            full_per_mm: number(
                self.full_per_mm,
                preset.full_per_mm,
                (0.5 * steep_per_mm).max(SMALLEST_PER_MM),
            ),
        }
    }

    /// This with the settled numbers that the model asks for.
    pub(crate) fn filled(self, settled: &SettledShading) -> Shading {
        let model = settled.model;
        let is_lit = model.is_lit();
        let of =
            |key: &str, own: Option<f64>, settled: f64| own.or(model.has(key).then_some(settled));
        let fades = model == ShadingModel::GradientOpacity;
        Shading {
            model: Some(model),
            ambient: self.ambient.or(is_lit.then_some(settled.ambient)),
            diffuse: of("diffuse", self.diffuse, settled.diffuse),
            specular: of("specular", self.specular, settled.specular),
            shininess: of("shininess", self.shininess, settled.shininess),
            roughness: of("roughness", self.roughness, settled.roughness),
            reflectance: of("reflectance", self.reflectance, settled.reflectance),
            keep_last_normal: self
                .keep_last_normal
                .or(is_lit.then_some(settled.keep_last_normal)),
            full_per_mm: self.full_per_mm.or(fades.then_some(settled.full_per_mm)),
        }
    }
}

/// Smaller gradients are no help to anybody.
const SMALLEST_PER_MM: f64 = 1e-30;

impl SettledShading {
    /// What is wrong stands under the key `path`.
    pub fn plan(&self, path: &str, method: Method, checker: &mut Checker) -> Shade {
        let mut number = |key: &str, value: f64, within: Within| {
            checker.number(&format!("{path}.{key}"), value, within);
            value as f32
        };
        let share = Within::Closed(0.0, 10.0);
        // Models measure it differently.
        let roughness = (self.model.function()).and_then(|f| f.parameter("roughness"));
        let [least, most] = roughness.map_or([0.05, 1.0], |parameter| parameter.range);
        let ambient = number("ambient", self.ambient, share);
        number("diffuse", self.diffuse, share);
        number("specular", self.specular, share);
        number("shininess", self.shininess, Within::Above(0.0, 1000.0));
        number("roughness", self.roughness, Within::Closed(least, most));
        number("reflectance", self.reflectance, Within::Closed(0.0, 1.0));
        let within = Within::Closed(SMALLEST_PER_MM, 1e30);
        let full_per_mm = number("full_per_mm", self.full_per_mm, within);
        match self.model {
            ShadingModel::Unlit => return Shade::Unlit,
            ShadingModel::GradientOpacity if !method.is_projection() => {
                return Shade::GradientOpacity { full_per_mm };
            }
            _ => {}
        }
        // Keys of the scene, by the names of the parameters that they are.
        let illuminate = self.model.illuminate(|parameter| match parameter {
            "diffuse" => self.diffuse,
            "specular" => self.specular,
            "shininess" => self.shininess,
            "roughness" => self.roughness,
            "reflectance" => self.reflectance,
            other => (self.model.function()).map_or(0.0, |function| function.default_of(other)),
        });
        let has_place = (method.function()).is_none_or(|function| function.has_place);
        let Some(illuminate) = illuminate.filter(|_| has_place) else {
            checker.add(
                format!("{path}.model"),
                format!("{:?} with method {:?}", self.model.name(), method.name()),
                "\"unlit\" (or nothing): such a projection has no surface",
            );
            return Shade::Unlit;
        };
        Shade::Lit {
            ambient,
            illuminate,
            keep_last_normal: self.keep_last_normal,
        }
    }
}
