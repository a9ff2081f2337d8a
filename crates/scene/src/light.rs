//! Lights, as people write them.

use crate::Color;
use crate::plan::{Compositing, PlanCamera, PlanLight};
use crate::problem::{Checker, Within};
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A light.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Light {
    /// What kind of light.
    #[serde(rename = "type")]
    pub kind: LightKind,
    /// What `azimuth_deg` and `elevation_deg` of a directional light count from; default `camera`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub space: Option<LightSpace>,
    /// Towards the light: in camera space 0 is from the eye and 90 from the right of the picture; in
    /// world space 0 is from the front (anterior) and 90 from the patient's left.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub azimuth_deg: Option<f64>,
    /// Towards the light, above the horizontal plane of the picture (camera) or of the patient
    /// (world), −90 to 90.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub elevation_deg: Option<f64>,
    /// Where a point light is, RAS mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position: Option<[f64; 3]>,
    /// The distance at which a point light is as strong as `intensity` says; default 500.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reach_mm: Option<f64>,
    /// Its colour; default white.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub color: Option<Color>,
    /// Its strength, 0 to 1,000; default 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub intensity: Option<f64>,
}

/// A kind of light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LightKind {
    /// Parallel light from one direction.
    Directional,
    /// A lamp at a place; its light falls with the square of the distance.
    Point,
    /// From the eye along each ray.
    Head,
}

/// What the angles of a light count from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
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

    pub(crate) fn settled(self) -> Light {
        let directional = self.kind == LightKind::Directional;
        Light {
            kind: self.kind,
            space: self.space.or(directional.then_some(LightSpace::Camera)),
            azimuth_deg: self.azimuth_deg.or(directional.then_some(0.0)),
            elevation_deg: self.elevation_deg.or(directional.then_some(0.0)),
            position: self.position,
            reach_mm: self
                .reach_mm
                .or((self.kind == LightKind::Point).then_some(500.0)),
            color: self.color.or(Some(Color::WHITE)),
            intensity: self.intensity.or(Some(1.0)),
        }
    }

    /// The light of a plan; `self` must be settled.
    pub(crate) fn plan(
        &self,
        path: &str,
        camera: &PlanCamera,
        compositing: Compositing,
        checker: &mut Checker,
    ) -> Option<PlanLight> {
        let before = checker.problems.len();
        let color = self.color.unwrap_or(Color::WHITE);
        check_color(&format!("{path}.color"), color, checker);
        let intensity = self.intensity.unwrap_or(1.0);
        checker.number(
            &format!("{path}.intensity"),
            intensity,
            Within::Closed(0.0, 1000.0),
        );
        let radiance = color
            .in_space(compositing)
            .map(|part| part * intensity as f32);
        let directional = self.kind == LightKind::Directional;
        let point = self.kind == LightKind::Point;
        for (given, key, allowed) in [
            (self.space.is_some() && !directional, "space", "nothing"),
            (
                self.azimuth_deg.is_some() && !directional,
                "azimuth_deg",
                "nothing",
            ),
            (
                self.elevation_deg.is_some() && !directional,
                "elevation_deg",
                "nothing",
            ),
            (self.position.is_some() && !point, "position", "nothing"),
            (self.reach_mm.is_some() && !point, "reach_mm", "nothing"),
        ] {
            if given {
                let (kind, why) = match self.kind {
                    LightKind::Directional => {
                        ("a directional", "it comes from infinitely far away")
                    }
                    LightKind::Point => ("a point", "it shines in every direction"),
                    LightKind::Head => ("a head", "it always comes from the eye"),
                };
                checker.add(
                    format!("{path}.{key}"),
                    format!("given for {kind} light"),
                    &format!("{allowed}: {why}"),
                );
            }
        }
        match self.kind {
            LightKind::Directional => {}
            LightKind::Head => {
                return (checker.problems.len() == before).then_some(PlanLight::Head { radiance });
            }
            LightKind::Point => {
                let reach = self.reach_mm.unwrap_or(500.0);
                checker.number(
                    &format!("{path}.reach_mm"),
                    reach,
                    Within::Closed(1e-3, 1e6),
                );
                let Some(position) = self.position else {
                    checker.add(
                        format!("{path}.position"),
                        "missing",
                        "the place of the point light, three numbers in RAS mm",
                    );
                    return None;
                };
                checker.point(&format!("{path}.position"), position);
                return (checker.problems.len() == before).then_some(PlanLight::Point {
                    place_mm: DVec3::from_array(position),
                    reach_mm: reach as f32,
                    radiance,
                });
            }
        }
        let azimuth = self.azimuth_deg.unwrap_or(0.0);
        let elevation = self.elevation_deg.unwrap_or(0.0);
        checker.number(
            &format!("{path}.azimuth_deg"),
            azimuth,
            Within::Closed(-360.0, 360.0),
        );
        checker.number(
            &format!("{path}.elevation_deg"),
            elevation,
            Within::Closed(-90.0, 90.0),
        );
        let (right, up, towards_eye) = match self.space.unwrap_or(LightSpace::Camera) {
            LightSpace::Camera => (camera.right, camera.up, -camera.forward),
            LightSpace::World => (-DVec3::X, DVec3::Z, DVec3::Y),
        };
        let (sin_a, cos_a) = azimuth.to_radians().sin_cos();
        let (sin_e, cos_e) = elevation.to_radians().sin_cos();
        let to_light = (towards_eye * (cos_a * cos_e) + right * (sin_a * cos_e) + up * sin_e)
            .normalize_or(towards_eye);
        (checker.problems.len() == before).then_some(PlanLight::Directional { to_light, radiance })
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
