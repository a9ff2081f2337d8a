//! The camera, as people write it, and its way to a [`PlanCamera`].
//!
//! Two forms. *Orbit*: a start view of the volume, then elevation, azimuth and zoom with the meaning
//! that VTK gives them (`vtkRenderer::ResetCamera`, `vtkCamera::Elevation`, `Azimuth`, `Zoom`), so
//! that pictures can be compared side by side. *Free*: position, focus and up in RAS mm.

use crate::plan::{PlanCamera, Projection as PlanProjection};
use crate::problem::{Checker, Within};
use glam::{DQuat, DVec3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use strahl_volume::{Grid, Modality, VolumeHeader};

/// Where the picture is taken from: an orbit about the volume, or, with `position`, a free place.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Camera {
    /// How rays spread; default `perspective`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub projection: Option<Projection>,
    /// Orbit: the side that the volume is first seen from.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view: Option<View>,
    /// Orbit: turns the camera up from its start view, −89.9 to 89.9.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub elevation_deg: Option<f64>,
    /// Orbit: turns the raised camera about the up direction of the start view; to the right of the
    /// picture is positive.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub azimuth_deg: Option<f64>,
    /// Free: the eye in RAS mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position: Option<[f64; 3]>,
    /// The point that the camera looks at (and orbits about) in RAS mm; default the volume's centre.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub focus: Option<[f64; 3]>,
    /// Free: the direction that is up in the picture, RAS; default that of the start view.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub up: Option<[f64; 3]>,
    /// Perspective: angle between the top and the bottom edge before zoom, 0.01 to 179; default 30.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view_angle_deg: Option<f64>,
    /// Orthographic: height of the picture in mm before zoom; default the bounding sphere's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub height_mm: Option<f64>,
    /// Divides the view angle (or the height). 1: the bounding sphere just fits. Default of an orbit:
    /// the volume's box just fits; of a free camera: 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub zoom: Option<f64>,
}

/// How rays spread.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Projection {
    /// From the eye: near things are larger.
    Perspective,
    /// Parallel: lengths can be compared.
    Orthographic,
}

/// The side that an orbit starts from. In RAS, so that `front` means the face of a patient; the
/// patient's left is then on the right of the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum View {
    /// From the front (anterior), head up.
    Front,
    /// From behind (posterior), head up.
    Back,
    /// From the patient's left, head up.
    Left,
    /// From the patient's right, head up.
    Right,
    /// From above the head, front up: looking down −z with y up, VTK's start view.
    #[serde(alias = "down-z")]
    Top,
    /// From the feet, front up, as axial slices are shown.
    Bottom,
}

impl View {
    /// Every view.
    pub const ALL: [View; 6] = [
        View::Front,
        View::Back,
        View::Left,
        View::Right,
        View::Top,
        View::Bottom,
    ];

    /// The name used in scenes and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            View::Front => "front",
            View::Back => "back",
            View::Left => "left",
            View::Right => "right",
            View::Top => "top",
            View::Bottom => "bottom",
        }
    }

    /// From the volume to the eye, and up: RAS unit vectors.
    fn axes(self) -> (DVec3, DVec3) {
        match self {
            View::Front => (DVec3::Y, DVec3::Z),
            View::Back => (-DVec3::Y, DVec3::Z),
            View::Left => (-DVec3::X, DVec3::Z),
            View::Right => (DVec3::X, DVec3::Z),
            View::Top => (DVec3::Z, DVec3::Y),
            View::Bottom => (-DVec3::Z, DVec3::Y),
        }
    }
}

impl std::str::FromStr for View {
    type Err = String;

    fn from_str(name: &str) -> Result<View, String> {
        if name == "down-z" {
            return Ok(View::Top);
        }
        View::ALL
            .into_iter()
            .find(|view| view.name() == name)
            .ok_or_else(|| {
                let names = View::ALL.map(View::name).join(", ");
                format!("{name:?} is not a view; known are {names}, down-z")
            })
    }
}

/// Angle between the top and the bottom edge of the picture, as VTK's cameras start.
const VIEW_ANGLE_DEG: f64 = 30.0;
/// Share of the picture's height or width that a fitted box fills.
const FIT: f64 = 0.96;

/// Whether the volume looks like a patient's: it names a clinical modality, or its place in the
/// world is more than what a writer makes up (1 mm steps, centred on the origin).
pub(crate) fn is_patient(header: &VolumeHeader) -> bool {
    match header.metadata.modality {
        Some(Modality::Ct | Modality::Mr | Modality::Nuclear | Modality::Ultrasound) => true,
        Some(Modality::Microscopy | Modality::Simulation) => false,
        None => {
            let grid = &header.grid;
            let centre = grid.centre_mm();
            let made_up = grid.spacing_mm() == DVec3::ONE
                && grid.orientation() == "RAS"
                && centre.abs().max_element() <= 1.0;
            header.metadata.has_length_unit && !made_up
        }
    }
}

/// Radius of the sphere about the voxel centres: what VTK calls the bounds of an image.
fn bounding_radius_mm(grid: &Grid) -> f64 {
    let last = grid.extent_in_voxels().1 - 0.5;
    let axes = grid.world_from_voxel().matrix3;
    let diagonal = |y: f64, z: f64| {
        (axes.x_axis * last.x + y * axes.y_axis * last.y + z * axes.z_axis * last.z).length()
    };
    let longest = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)]
        .into_iter()
        .map(|(y, z)| diagonal(y, z))
        .fold(0.0, f64::max);
    if longest > 0.0 {
        0.5 * longest
    } else {
        grid.centre_mm().distance(grid.corners_mm()[0])
    }
}

impl Camera {
    pub(crate) fn settled(&self, header: &VolumeHeader, size: [u32; 2]) -> Camera {
        let grid = &header.grid;
        let mut camera = *self;
        let projection = *camera.projection.get_or_insert(Projection::Perspective);
        camera
            .focus
            .get_or_insert_with(|| grid.centre_mm().to_array());
        match projection {
            Projection::Perspective => {
                camera.view_angle_deg.get_or_insert(VIEW_ANGLE_DEG);
            }
            Projection::Orthographic => {
                let aspect = aspect(size);
                camera
                    .height_mm
                    .get_or_insert_with(|| 2.0 * bounding_radius_mm(grid) / aspect.min(1.0));
            }
        }
        if camera.position.is_some() {
            camera.up.get_or_insert_with(|| {
                let up = if is_patient(header) {
                    DVec3::Z
                } else {
                    start_view(header).0.axes().1
                };
                up.to_array()
            });
            camera.zoom.get_or_insert(1.0);
        } else {
            let (view, elevation, azimuth) = start_view(header);
            // Angles that are given count from a plain view, not from the three-quarter view.
            let plain = camera.view.is_some()
                || camera.elevation_deg.is_some()
                || camera.azimuth_deg.is_some();
            camera.view.get_or_insert(view);
            camera
                .elevation_deg
                .get_or_insert(if plain { 0.0 } else { elevation });
            camera
                .azimuth_deg
                .get_or_insert(if plain { 0.0 } else { azimuth });
            if camera.zoom.is_none() {
                camera.zoom = Some(camera.fitting_zoom(grid, size));
            }
        }
        camera
    }

    /// The zoom at which the sampled box of the volume just fits; 1 where that makes no sense.
    fn fitting_zoom(&self, grid: &Grid, size: [u32; 2]) -> f64 {
        let mut ignored = Checker::default();
        let unzoomed = Camera {
            zoom: Some(1.0),
            ..*self
        };
        let Some(camera) = unzoomed.plan(grid, size, &mut ignored) else {
            return 1.0;
        };
        let aspect = aspect(size);
        // The largest distance of a corner from the picture's middle, in half heights.
        let mut reach: f64 = 0.0;
        for corner in grid.corners_mm() {
            let from_eye = corner - camera.eye_mm;
            let (across, upward) = (from_eye.dot(camera.right), from_eye.dot(camera.up));
            let half_height = match camera.projection {
                PlanProjection::Perspective { tan_half_height } => {
                    let depth = from_eye.dot(camera.forward);
                    if depth <= 0.0 {
                        return 1.0;
                    }
                    depth * tan_half_height
                }
                PlanProjection::Orthographic { half_height_mm } => half_height_mm,
            };
            reach = reach.max(upward.abs().max(across.abs() / aspect) / half_height);
        }
        if !reach.is_finite() || reach <= 0.0 {
            return 1.0;
        }
        let zoom = match camera.projection {
            PlanProjection::Perspective { tan_half_height } => {
                tan_half_height.atan() / (tan_half_height * reach / FIT).atan()
            }
            PlanProjection::Orthographic { .. } => FIT / reach,
        };
        // Four digits are what a picture can show and a person wants to read; rounded down, so that
        // nothing is cut.
        if (1e-3..1e3).contains(&zoom) {
            (zoom * 1000.0).floor() / 1000.0
        } else {
            1.0
        }
    }

    /// The camera of a plan; `self` must be settled.
    pub(crate) fn plan(
        &self,
        grid: &Grid,
        size: [u32; 2],
        checker: &mut Checker,
    ) -> Option<PlanCamera> {
        let before = checker.problems.len();
        let aspect = aspect(size);
        let zoom = self.zoom.unwrap_or(1.0);
        checker.number("camera.zoom", zoom, Within::Closed(1e-3, 1e6));
        let focus = self.focus.unwrap_or(grid.centre_mm().to_array());
        checker.point("camera.focus", focus);
        let focus = DVec3::from_array(focus);

        let projection = self.projection.unwrap_or(Projection::Perspective);
        let view_angle = self.view_angle_deg.unwrap_or(VIEW_ANGLE_DEG);
        match projection {
            Projection::Perspective => {
                checker.number(
                    "camera.view_angle_deg",
                    view_angle,
                    Within::Closed(0.01, 179.0),
                );
                if let Some(height) = self.height_mm {
                    checker.add(
                        "camera.height_mm",
                        height,
                        "view_angle_deg instead; a height belongs to an orthographic projection",
                    );
                }
            }
            Projection::Orthographic => {
                if let Some(height) = self.height_mm {
                    checker.number("camera.height_mm", height, Within::Above(0.0, 1e12));
                }
                if let Some(angle) = self.view_angle_deg {
                    checker.add(
                        "camera.view_angle_deg",
                        angle,
                        "height_mm instead; an angle belongs to a perspective projection",
                    );
                }
            }
        }

        let (eye, up, up_path) = match self.position {
            Some(position) => self.free(position, focus, checker),
            None => self.orbit(grid, focus, projection, view_angle, aspect, checker),
        };
        if checker.problems.len() > before {
            return None;
        }
        let forward = (focus - eye).normalize_or_zero();
        let right = forward.cross(up.normalize_or_zero());
        // Below 1e-6 the direction of `right` would be rounding.
        if right.length() < 1e-6 {
            checker.add(
                up_path,
                format!("{:?}, parallel to the view", up.to_array()),
                "a direction that is not parallel to the line from position to focus",
            );
            return None;
        }
        let right = right.normalize();
        let plan_projection = match projection {
            Projection::Perspective => PlanProjection::Perspective {
                tan_half_height: (0.5 * view_angle.to_radians() / zoom).tan(),
            },
            Projection::Orthographic => PlanProjection::Orthographic {
                half_height_mm: 0.5 * self.height_mm.unwrap_or(2.0 * bounding_radius_mm(grid))
                    / zoom,
            },
        };
        // A zoom below 1 may open the angle to 180° and more.
        if view_angle / zoom >= 180.0 && projection == Projection::Perspective {
            checker.add(
                "camera.zoom",
                zoom,
                &format!(
                    "above {:.4}, so that view_angle_deg / zoom stays below 180",
                    view_angle / 180.0
                ),
            );
            return None;
        }
        Some(PlanCamera {
            eye_mm: eye,
            right,
            up: right.cross(forward).normalize(),
            forward,
            projection: plan_projection,
        })
    }

    fn free(
        &self,
        position: [f64; 3],
        focus: DVec3,
        checker: &mut Checker,
    ) -> (DVec3, DVec3, &'static str) {
        for (given, key) in [
            (self.view.is_some(), "view"),
            (self.elevation_deg.is_some(), "elevation_deg"),
            (self.azimuth_deg.is_some(), "azimuth_deg"),
        ] {
            if given {
                checker.add(
                    format!("camera.{key}"),
                    "given beside position",
                    "either position, focus and up, or view, elevation_deg and azimuth_deg",
                );
            }
        }
        let up = self.up.unwrap_or([0.0, 0.0, 1.0]);
        if checker.point("camera.up", up) && DVec3::from_array(up).length() < 1e-12 {
            checker.add("camera.up", format!("{up:?}"), "three numbers, not all 0");
        }
        let eye = DVec3::from_array(position);
        if checker.point("camera.position", position) && eye.distance(focus) < 1e-9 {
            checker.add(
                "camera.position",
                format!("{position:?}, the focus"),
                "a point away from the focus",
            );
        }
        (eye, DVec3::from_array(up), "camera.up")
    }

    fn orbit(
        &self,
        grid: &Grid,
        focus: DVec3,
        projection: Projection,
        view_angle: f64,
        aspect: f64,
        checker: &mut Checker,
    ) -> (DVec3, DVec3, &'static str) {
        if let Some(up) = self.up {
            checker.add(
                "camera.up",
                format!("{up:?} without position"),
                "view, elevation_deg and azimuth_deg; up belongs to a camera with position",
            );
        }
        let elevation = self.elevation_deg.unwrap_or(0.0);
        let azimuth = self.azimuth_deg.unwrap_or(0.0);
        checker.number(
            "camera.elevation_deg",
            elevation,
            Within::Closed(-89.9, 89.9),
        );
        checker.number(
            "camera.azimuth_deg",
            azimuth,
            Within::Closed(-3600.0, 3600.0),
        );
        let (towards_eye, up) = self.view.unwrap_or(View::Front).axes();
        let right = up.cross(towards_eye);
        let raised = DQuat::from_axis_angle(-right, elevation.to_radians()) * towards_eye;
        let turned = DQuat::from_axis_angle(up, azimuth.to_radians()) * raised;
        // A portrait picture is narrower than its view angle says: the sphere must fit its width.
        let half_angle = 0.5 * view_angle.to_radians();
        let half_angle = match projection {
            Projection::Perspective if aspect < 1.0 => (half_angle.tan() * aspect).atan(),
            Projection::Perspective => half_angle,
            // The eye only needs to be outside the volume.
            Projection::Orthographic => 15f64.to_radians(),
        };
        let distance = bounding_radius_mm(grid) / half_angle.sin();
        (focus + turned * distance, up, "camera.elevation_deg")
    }
}

/// The view, elevation and azimuth of a camera that says nothing.
fn start_view(header: &VolumeHeader) -> (View, f64, f64) {
    if is_patient(header) {
        (View::Front, 0.0, 0.0)
    } else {
        (View::Front, 20.0, 30.0)
    }
}

fn aspect([width, height]: [u32; 2]) -> f64 {
    f64::from(width.max(1)) / f64::from(height.max(1))
}
