//! Lights, as people write them.

use crate::Color;
use crate::plan::{Compositing, PlanCamera, PlanLight};
use crate::problem::{Checker, Within};
use glam::DVec3;
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A light.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Light {
    /// What kind of light.
    #[serde(rename = "type")]
    pub kind: LightKind,
    /// What `azimuth_deg` and `elevation_deg` of a directional light are relative to; default
    /// `camera`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub space: Option<LightSpace>,
    /// Direction to the light. In camera space, 0 is at the camera and 90 is to the right of
    /// the picture. In world space, 0 is to the front (anterior) and 90 is to the patient's
    /// left.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub azimuth_deg: Option<f64>,
    /// Elevation of the light above the horizontal plane of the picture (camera space) or of
    /// the patient (world space), −90 to 90.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub elevation_deg: Option<f64>,
    /// Position of a point light, RAS mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position: Option<[f64; 3]>,
    /// The distance at which a point light has its `intensity`; default 500.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reach_mm: Option<f64>,
    /// Its color; default white.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub color: Option<Color>,
    /// Its strength, 0 to 1,000; default 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub intensity: Option<f64>,
}

/// A kind of light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum LightKind {
    /// Parallel light from one direction.
    Directional,
    /// A lamp at a position; its light decreases with the square of the distance.
    Point,
    /// Light from the camera along each ray.
    Head,
}

/// What the angles of a light are relative to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum LightSpace {
    /// The light moves with the camera.
    Camera,
    /// The light stays with the patient.
    World,
}

impl Light {
    /// A white light that moves with the camera.
    pub const fn from_camera(azimuth_deg: f64, elevation_deg: f64, intensity: f64) -> Light {
        Light {
            kind: LightKind::Directional,
            space: Some(LightSpace::Camera),
            azimuth_deg: Some(azimuth_deg),
            elevation_deg: Some(elevation_deg),
            position: None,
            reach_mm: None,
            color: Some(Color::WHITE),
            intensity: Some(intensity),
        }
    }

    /// A white light at the eye.
    pub const fn head(intensity: f64) -> Light {
        Light {
            kind: LightKind::Head,
            space: None,
            azimuth_deg: None,
            elevation_deg: None,
            position: None,
            reach_mm: None,
            color: Some(Color::WHITE),
            intensity: Some(intensity),
        }
    }

    /// The light that this means; keys that its kind does not have are problems.
    pub(crate) fn settled(self, path: &str, checker: &mut Checker) -> SettledLight {
        self.check_together(path, checker);
        SettledLight {
            place: match self.kind {
                LightKind::Directional => LightPlace::Directional {
                    space: self.space.unwrap_or(LightSpace::Camera),
                    azimuth_deg: self.azimuth_deg.unwrap_or(0.0),
                    elevation_deg: self.elevation_deg.unwrap_or(0.0),
                },
                LightKind::Point => LightPlace::Point {
                    position: self.position,
                    reach_mm: self.reach_mm.unwrap_or(500.0),
                },
                LightKind::Head => LightPlace::Head,
            },
            color: self.color.unwrap_or(Color::WHITE),
            intensity: self.intensity.unwrap_or(1.0),
        }
    }

    fn check_together(&self, path: &str, checker: &mut Checker) {
        let (kind, why) = match self.kind {
            LightKind::Directional => ("a directional", "it comes from infinitely far away"),
            LightKind::Point => ("a point", "it shines in every direction"),
            LightKind::Head => ("a head", "it always comes from the eye"),
        };
        let directional = self.kind == LightKind::Directional;
        let point = self.kind == LightKind::Point;
        for (given, fits, key) in [
            (self.space.is_some(), directional, "space"),
            (self.azimuth_deg.is_some(), directional, "azimuth_deg"),
            (self.elevation_deg.is_some(), directional, "elevation_deg"),
            (self.position.is_some(), point, "position"),
            (self.reach_mm.is_some(), point, "reach_mm"),
        ] {
            if given && !fits {
                checker.add(
                    format!("{path}.{key}"),
                    format!("given for {kind} light"),
                    &format!("nothing: {why}"),
                );
            }
        }
    }
}

/// [`Light`] with everything said.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SettledLight {
    pub place: LightPlace,
    pub color: Color,
    pub intensity: f64,
}

/// Where a light comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum LightPlace {
    Directional {
        space: LightSpace,
        azimuth_deg: f64,
        elevation_deg: f64,
    },
    Point {
        /// There is no default: without one the light is a problem.
        position: Option<[f64; 3]>,
        reach_mm: f64,
    },
    Head,
}

impl SettledLight {
    /// As a scene says it.
    pub fn scene(self) -> Light {
        let light = |kind| Light {
            kind,
            space: None,
            azimuth_deg: None,
            elevation_deg: None,
            position: None,
            reach_mm: None,
            color: Some(self.color),
            intensity: Some(self.intensity),
        };
        match self.place {
            LightPlace::Directional {
                space,
                azimuth_deg,
                elevation_deg,
            } => Light {
                space: Some(space),
                azimuth_deg: Some(azimuth_deg),
                elevation_deg: Some(elevation_deg),
                ..light(LightKind::Directional)
            },
            LightPlace::Point { position, reach_mm } => Light {
                position,
                reach_mm: Some(reach_mm),
                ..light(LightKind::Point)
            },
            LightPlace::Head => light(LightKind::Head),
        }
    }

    /// The light of a plan.
    pub fn plan(
        self,
        path: &str,
        camera: &PlanCamera,
        compositing: Compositing,
        checker: &mut Checker,
    ) -> Option<PlanLight> {
        let before = checker.problems.len();
        check_color(&format!("{path}.color"), self.color, checker);
        let mut number = |key: &str, value: f64, within: Within| {
            checker.number(&format!("{path}.{key}"), value, within);
        };
        number("intensity", self.intensity, Within::Closed(0.0, 1000.0));
        let radiance = self
            .color
            .in_space(compositing)
            .map(|part| part * self.intensity as f32);
        let light = match self.place {
            LightPlace::Head => PlanLight::Head { radiance },
            LightPlace::Point { position, reach_mm } => {
                number("reach_mm", reach_mm, Within::Closed(1e-3, 1e6));
                let Some(position) = position else {
                    checker.add(
                        format!("{path}.position"),
                        "missing",
                        "the place of the point light, three numbers in RAS mm",
                    );
                    return None;
                };
                checker.point(&format!("{path}.position"), position);
                PlanLight::Point {
                    place_mm: DVec3::from_array(position),
                    reach_mm: reach_mm as f32,
                    radiance,
                }
            }
            LightPlace::Directional {
                space,
                azimuth_deg,
                elevation_deg,
            } => {
                number("azimuth_deg", azimuth_deg, Within::Closed(-360.0, 360.0));
                number("elevation_deg", elevation_deg, Within::Closed(-90.0, 90.0));
                PlanLight::Directional {
                    to_light: space.towards(azimuth_deg, elevation_deg, camera),
                    radiance,
                }
            }
        };
        (checker.problems.len() == before).then_some(light)
    }
}

impl LightSpace {
    /// Towards a light at these angles: a unit vector of the world.
    fn towards(self, azimuth_deg: f64, elevation_deg: f64, camera: &PlanCamera) -> DVec3 {
        let (right, up, towards_eye) = match self {
            LightSpace::Camera => (camera.right, camera.up, -camera.forward),
            LightSpace::World => (-DVec3::X, DVec3::Z, DVec3::Y),
        };
        let (sin_a, cos_a) = azimuth_deg.to_radians().sin_cos();
        let (sin_e, cos_e) = elevation_deg.to_radians().sin_cos();
        (towards_eye * (cos_a * cos_e) + right * (sin_a * cos_e) + up * sin_e)
            .normalize_or(towards_eye)
    }
}

pub(crate) fn check_color(path: &str, color: Color, checker: &mut Checker) {
    if !color.0.iter().all(|part| (0.0..=1.0).contains(part)) {
        checker.add(
            path,
            format!("{:?}", color.0),
            "red, green and blue from 0 to 1",
        );
    }
}
