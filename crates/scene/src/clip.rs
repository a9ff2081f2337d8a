//! Clip planes and boxes, as people write them.

use crate::plan::{ClipBox, ClipPlane};
use crate::problem::{Checker, Within};
use glam::{DAffine3, DMat3, DQuat, DVec3, EulerRot};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use strahl_volume::Grid;

/// Something that cuts a part of the volume away.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Clip {
    /// Keeps one side of a plane.
    Plane(PlaneClip),
    /// Keeps the inside or the outside of a box.
    Box(BoxClip),
}

/// Keeps the side of a plane that its normal points to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlaneClip {
    /// Towards the side that is kept, RAS; any length above 0.
    pub normal: [f64; 3],
    /// A point of the plane in RAS mm; default the centre of the volume.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub point: Option<[f64; 3]>,
    /// Instead of a point: distance of the plane from the world's origin along the normal.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub distance_mm: Option<f64>,
}

/// Keeps the inside or the outside of a box.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoxClip {
    /// One corner.
    pub min: [f64; 3],
    /// The opposite corner, larger in every part.
    pub max: [f64; 3],
    /// What the corners count in; default `world`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub space: Option<BoxSpace>,
    /// Turns the box about its middle: about x, then y, then z; default no turn. World space only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotation_deg: Option<[f64; 3]>,
    /// What is kept; default `inside`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub keep: Option<Keep>,
}

/// What the corners of a box count in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum BoxSpace {
    /// RAS mm.
    World,
    /// Voxel indices; voxel centres are whole numbers.
    Voxels,
    /// Shares of the volume along its voxel axes: 0 is its first face, 1 its last.
    Fraction,
}

/// What a box keeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Keep {
    /// What is in the box.
    Inside,
    /// What is around the box.
    Outside,
}

impl Clip {
    pub(crate) fn settled(self, grid: &Grid) -> Clip {
        match self {
            Clip::Plane(plane) => Clip::Plane(PlaneClip {
                point: plane.point.or(plane
                    .distance_mm
                    .is_none()
                    .then(|| grid.centre_mm().to_array())),
                ..plane
            }),
            Clip::Box(clip) => Clip::Box(BoxClip {
                space: clip.space.or(Some(BoxSpace::World)),
                rotation_deg: clip.rotation_deg.or(Some([0.0; 3])),
                keep: clip.keep.or(Some(Keep::Inside)),
                ..clip
            }),
        }
    }

    /// Adds the clip to a plan's; `self` must be settled. A box that keeps its inside is convex: it
    /// becomes six planes, so that rays start at its faces.
    pub(crate) fn plan(
        &self,
        path: &str,
        grid: &Grid,
        checker: &mut Checker,
        planes: &mut Vec<ClipPlane>,
        boxes: &mut Vec<ClipBox>,
    ) {
        match self {
            Clip::Plane(plane) => planes.extend(plane.plan(&format!("{path}.plane"), checker)),
            Clip::Box(clip) => {
                let Some(unit_from_world) = clip.plan(&format!("{path}.box"), grid, checker) else {
                    return;
                };
                if clip.keep == Some(Keep::Outside) {
                    boxes.push(ClipBox {
                        unit_from_world,
                        keep_inside: false,
                    });
                    return;
                }
                let rows = unit_from_world.matrix3.transpose();
                let shift = unit_from_world.translation;
                for (row, shift) in [
                    (rows.x_axis, shift.x),
                    (rows.y_axis, shift.y),
                    (rows.z_axis, shift.z),
                ] {
                    let length = row.length();
                    for side in [1.0, -1.0] {
                        planes.push(ClipPlane {
                            normal: side * row / length,
                            offset_mm: (0.5 + side * shift) / length,
                        });
                    }
                }
            }
        }
    }
}

impl PlaneClip {
    fn plan(&self, path: &str, checker: &mut Checker) -> Option<ClipPlane> {
        let before = checker.problems.len();
        let normal = DVec3::from_array(self.normal);
        if !normal.is_finite() || normal.abs().max_element() > 1e12 || normal.length() < 1e-12 {
            checker.add(
                format!("{path}.normal"),
                format!("{:?}", self.normal),
                "three numbers, not all 0",
            );
        }
        let normal = normal.normalize_or_zero();
        let offset_mm = match (self.point, self.distance_mm) {
            (Some(_), Some(distance)) => {
                checker.add(
                    format!("{path}.distance_mm"),
                    distance,
                    "either point or distance_mm",
                );
                0.0
            }
            (Some(point), None) => {
                checker.point(&format!("{path}.point"), point);
                -normal.dot(DVec3::from_array(point))
            }
            (None, distance) => {
                let distance = distance.unwrap_or(0.0);
                checker.number(
                    &format!("{path}.distance_mm"),
                    distance,
                    Within::Closed(-1e12, 1e12),
                );
                -distance
            }
        };
        (checker.problems.len() == before).then_some(ClipPlane { normal, offset_mm })
    }
}

impl BoxClip {
    fn plan(&self, path: &str, grid: &Grid, checker: &mut Checker) -> Option<DAffine3> {
        let before = checker.problems.len();
        let good = checker.point(&format!("{path}.min"), self.min)
            & checker.point(&format!("{path}.max"), self.max);
        let (min, max) = (DVec3::from_array(self.min), DVec3::from_array(self.max));
        if good && (max - min).min_element() < 1e-9 {
            checker.add(
                format!("{path}.max"),
                format!("{:?}", self.max),
                &format!("larger than min {:?} in every part", self.min),
            );
        }
        let turn = self.rotation_deg.unwrap_or([0.0; 3]);
        for (axis, degrees) in turn.into_iter().enumerate() {
            checker.number(
                &format!("{path}.rotation_deg[{axis}]"),
                degrees,
                Within::Closed(-360.0, 360.0),
            );
        }
        let space = self.space.unwrap_or(BoxSpace::World);
        if space != BoxSpace::World && turn != [0.0; 3] {
            checker.add(
                format!("{path}.rotation_deg"),
                format!("{turn:?}"),
                "[0, 0, 0] unless the box is in world space",
            );
        }
        if checker.problems.len() > before {
            return None;
        }
        let size = max - min;
        let turned = DMat3::from_quat(DQuat::from_euler(
            EulerRot::ZYX,
            turn[2].to_radians(),
            turn[1].to_radians(),
            turn[0].to_radians(),
        ));
        let space_from_unit =
            DAffine3::from_mat3_translation(turned * DMat3::from_diagonal(size), 0.5 * (min + max));
        let (first, last) = grid.extent_in_voxels();
        let world_from_space = match space {
            BoxSpace::World => DAffine3::IDENTITY,
            BoxSpace::Voxels => grid.world_from_voxel(),
            BoxSpace::Fraction => {
                grid.world_from_voxel()
                    * DAffine3::from_mat3_translation(DMat3::from_diagonal(last - first), first)
            }
        };
        let unit_from_world = (world_from_space * space_from_unit).inverse();
        if !unit_from_world.is_finite() {
            checker.add(
                path,
                format!("{:?} to {:?}", self.min, self.max),
                "a box with a volume",
            );
            return None;
        }
        Some(unit_from_world)
    }
}
