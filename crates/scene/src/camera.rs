//! The camera, as people write it, and its way to a [`PlanCamera`].
//!
//! Two forms. *Orbit*: a start view of the volume, then elevation, azimuth and zoom with the meaning
//! that VTK gives them (`vtkRenderer::ResetCamera`, `vtkCamera::Elevation`, `Azimuth`, `Zoom`), so
//! that pictures can be compared side by side. *Free*: position, focus and up in RAS mm.

use crate::patient::is_patient;
use crate::plan::{PlanCamera, Projection as PlanProjection};
use crate::problem::{Checker, Within};
use glam::{DQuat, DVec3};
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use strahl_volume::{Grid, VolumeHeader};

/// The camera: on an orbit around the volume, or, with `position`, free.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(default, deny_unknown_fields)]
pub struct Camera {
    /// The projection; default `perspective`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub projection: Option<Projection>,
    /// Orbit: the side from which the volume is seen at the start.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub view: Option<View>,
    /// Orbit: raises the camera from its start view, −90 to 90.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub elevation_deg: Option<f64>,
    /// Orbit: turns the raised camera about the up direction of the start view; positive is to
    /// the right of the picture.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub azimuth_deg: Option<f64>,
    /// Free: position of the camera in RAS mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub position: Option<[f64; 3]>,
    /// The point that the camera looks at (and orbits around) in RAS mm; default the center of
    /// the volume.
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
    /// Divides the view angle (or the height). With 1, the bounding sphere just fits. By
    /// default, the bounding box just fits on an orbit, and a free camera has 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub zoom: Option<f64>,
}

/// The projection.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Projection {
    /// From the eye: near things are larger.
    Perspective,
    /// Parallel: lengths can be compared.
    Orthographic,
}

/// The side that an orbit starts from, in RAS: `front` is the face of a patient, with the
/// patient's left on the right of the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
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
    /// From above the head, front up: looking along −z with y up, VTK's initial view.
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

/// Radius of the sphere about the voxel centers: what VTK calls the bounds of an image.
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
        grid.center_mm().distance(grid.corners_mm()[0])
    }
}

/// [`Camera`] with everything said.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SettledCamera {
    pub projection: SettledProjection,
    pub place: Place,
    pub focus: [f64; 3],
    pub zoom: f64,
}

/// How rays spread, before zoom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum SettledProjection {
    Perspective { view_angle_deg: f64 },
    Orthographic { height_mm: f64 },
}

/// Where a camera stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Place {
    Orbit {
        view: View,
        elevation_deg: f64,
        azimuth_deg: f64,
    },
    Free {
        position: [f64; 3],
        up: [f64; 3],
    },
}

impl Camera {
    /// The camera that this means for a scene whose own volume has this header and that lies in `grid`; keys that do
    /// not go together are problems.
    pub(crate) fn settled(
        &self,
        header: &VolumeHeader,
        grid: &Grid,
        size: [u32; 2],
        checker: &mut Checker,
    ) -> SettledCamera {
        self.check_together(checker);
        let projection = match self.projection.unwrap_or(Projection::Perspective) {
            Projection::Perspective => SettledProjection::Perspective {
                view_angle_deg: self.view_angle_deg.unwrap_or(VIEW_ANGLE_DEG),
            },
            Projection::Orthographic => SettledProjection::Orthographic {
                height_mm: self
                    .height_mm
                    .unwrap_or_else(|| 2.0 * bounding_radius_mm(grid) / aspect(size).min(1.0)),
            },
        };
        let focus = self.focus.unwrap_or_else(|| grid.center_mm().to_array());
        let place = self.place(header);
        let unzoomed = SettledCamera {
            projection,
            place,
            focus,
            zoom: 1.0,
        };
        let zoom = self.zoom.unwrap_or_else(|| match place {
            Place::Free { .. } => 1.0,
            Place::Orbit { .. } => unzoomed.fitting_zoom(grid, size),
        });
        SettledCamera { zoom, ..unzoomed }
    }

    fn place(&self, header: &VolumeHeader) -> Place {
        if let Some(position) = self.position {
            let up = self.up.unwrap_or_else(|| {
                let up = if is_patient(header) {
                    DVec3::Z
                } else {
                    start_view(header).0.axes().1
                };
                up.to_array()
            });
            return Place::Free { position, up };
        }
        let (view, elevation_deg, azimuth_deg) = start_view(header);
        // Angles that are given count from a plain view, not from the three-quarter view.
        let plain =
            self.view.is_some() || self.elevation_deg.is_some() || self.azimuth_deg.is_some();
        let start = |angle: f64| if plain { 0.0 } else { angle };
        Place::Orbit {
            view: self.view.unwrap_or(view),
            elevation_deg: self.elevation_deg.unwrap_or(start(elevation_deg)),
            azimuth_deg: self.azimuth_deg.unwrap_or(start(azimuth_deg)),
        }
    }

    fn check_together(&self, checker: &mut Checker) {
        match self.projection.unwrap_or(Projection::Perspective) {
            Projection::Perspective => {
                if let Some(height) = self.height_mm {
                    checker.add(
                        "camera.height_mm",
                        height,
                        "view_angle_deg instead; a height belongs to an orthographic projection",
                    );
                }
            }
            Projection::Orthographic => {
                if let Some(angle) = self.view_angle_deg {
                    checker.add(
                        "camera.view_angle_deg",
                        angle,
                        "height_mm instead; an angle belongs to a perspective projection",
                    );
                }
            }
        }
        if self.position.is_some() {
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
        } else if let Some(up) = self.up {
            checker.add(
                "camera.up",
                format!("{up:?} without position"),
                "view, elevation_deg and azimuth_deg; up belongs to a camera with position",
            );
        }
    }
}

impl SettledCamera {
    /// As a scene says it.
    pub fn scene(&self) -> Camera {
        let mut camera = Camera {
            focus: Some(self.focus),
            zoom: Some(self.zoom),
            ..Camera::default()
        };
        match self.projection {
            SettledProjection::Perspective { view_angle_deg } => {
                camera.projection = Some(Projection::Perspective);
                camera.view_angle_deg = Some(view_angle_deg);
            }
            SettledProjection::Orthographic { height_mm } => {
                camera.projection = Some(Projection::Orthographic);
                camera.height_mm = Some(height_mm);
            }
        }
        match self.place {
            Place::Orbit {
                view,
                elevation_deg,
                azimuth_deg,
            } => {
                camera.view = Some(view);
                camera.elevation_deg = Some(elevation_deg);
                camera.azimuth_deg = Some(azimuth_deg);
            }
            Place::Free { position, up } => {
                camera.position = Some(position);
                camera.up = Some(up);
            }
        }
        camera
    }

    /// The zoom of this camera, whose zoom is 1, at which the sampled box of the volume just fits; 1 where that makes
    /// no sense.
    fn fitting_zoom(&self, grid: &Grid, size: [u32; 2]) -> f64 {
        let mut ignored = Checker::default();
        let Some(camera) = self.plan(grid, size, &mut ignored) else {
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

    /// The camera of a plan.
    pub fn plan(&self, grid: &Grid, size: [u32; 2], checker: &mut Checker) -> Option<PlanCamera> {
        let before = checker.problems.len();
        let zoom = self.zoom;
        checker.number("camera.zoom", zoom, Within::Closed(1e-3, 1e6));
        checker.point("camera.focus", self.focus);
        let focus = DVec3::from_array(self.focus);
        match self.projection {
            SettledProjection::Perspective { view_angle_deg } => checker.number(
                "camera.view_angle_deg",
                view_angle_deg,
                Within::Closed(0.01, 179.0),
            ),
            SettledProjection::Orthographic { height_mm } => {
                checker.number("camera.height_mm", height_mm, Within::Above(0.0, 1e12))
            }
        };
        let (eye, up, up_path) = match self.place {
            Place::Free { position, up } => free(position, up, focus, checker),
            Place::Orbit {
                view,
                elevation_deg,
                azimuth_deg,
            } => {
                checker.number(
                    "camera.elevation_deg",
                    elevation_deg,
                    Within::Closed(-90.0, 90.0),
                );
                checker.number(
                    "camera.azimuth_deg",
                    azimuth_deg,
                    Within::Closed(-3600.0, 3600.0),
                );
                let turn = view.turned(elevation_deg, azimuth_deg);
                let distance = bounding_radius_mm(grid) / self.half_angle(aspect(size)).sin();
                let up = view.up(elevation_deg, azimuth_deg);
                (focus + turn * distance, up, "camera.elevation_deg")
            }
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
        Some(PlanCamera {
            eye_mm: eye,
            right,
            up: right.cross(forward).normalize(),
            forward,
            projection: self.plan_projection(checker)?,
        })
    }

    fn plan_projection(&self, checker: &mut Checker) -> Option<PlanProjection> {
        let zoom = self.zoom;
        match self.projection {
            // A zoom below 1 may open the angle to 180° and more.
            SettledProjection::Perspective { view_angle_deg } if view_angle_deg / zoom >= 180.0 => {
                checker.add(
                    "camera.zoom",
                    zoom,
                    &format!(
                        "above {:.4}, so that view_angle_deg / zoom stays below 180",
                        view_angle_deg / 180.0
                    ),
                );
                None
            }
            SettledProjection::Perspective { view_angle_deg } => {
                Some(PlanProjection::Perspective {
                    tan_half_height: (0.5 * view_angle_deg.to_radians() / zoom).tan(),
                })
            }
            SettledProjection::Orthographic { height_mm } => Some(PlanProjection::Orthographic {
                half_height_mm: 0.5 * height_mm / zoom,
            }),
        }
    }

    /// Half the angle from the eye of an orbit within which the bounding sphere fits.
    fn half_angle(&self, aspect: f64) -> f64 {
        match self.projection {
            SettledProjection::Perspective { view_angle_deg } => {
                let half_angle = 0.5 * view_angle_deg.to_radians();
                // A portrait picture is narrower than its view angle says: the sphere must fit its width.
                if aspect < 1.0 {
                    (half_angle.tan() * aspect).atan()
                } else {
                    half_angle
                }
            }
            // The eye only needs to be outside the volume.
            SettledProjection::Orthographic { .. } => 15f64.to_radians(),
        }
    }
}

impl View {
    /// From the volume to the eye of a camera that is raised, and then turned about the up direction.
    fn turned(self, elevation_deg: f64, azimuth_deg: f64) -> DVec3 {
        let (towards_eye, up) = self.axes();
        let right = up.cross(towards_eye);
        let raised = DQuat::from_axis_angle(-right, elevation_deg.to_radians()) * towards_eye;
        DQuat::from_axis_angle(up, azimuth_deg.to_radians()) * raised
    }

    /// The up direction of such a camera: that of the start view. A camera that looks along that takes the direction
    /// that is up just before.
    fn up(self, elevation_deg: f64, azimuth_deg: f64) -> DVec3 {
        if elevation_deg.abs() <= 89.9 {
            return self.axes().1;
        }
        let further = self.turned(elevation_deg + 90.0, azimuth_deg);
        further.normalize_or_zero()
    }
}

/// The eye and the up direction of a camera at `position`, and the key that says what is up.
fn free(
    position: [f64; 3],
    up: [f64; 3],
    focus: DVec3,
    checker: &mut Checker,
) -> (DVec3, DVec3, &'static str) {
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
