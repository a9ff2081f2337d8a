//! Planes, boxes, masks and the like that cut parts away, as people write them.

use crate::plan::{ALL_LAYERS, ClipPlane, ClipShape, LayerSet, MOST_MASKS, SampleClip};
use crate::problem::{Checker, Problems, Within};
use glam::{DAffine3, DMat3, DQuat, DVec3, EulerRot};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use strahl_volume::{Grid, LabelVolume};

/// Something that cuts a part of the picture away.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Clip {
    /// Keeps one side of a plane.
    Plane(PlaneClip),
    /// Keeps the inside or the outside of a box.
    Box(BoxClip),
    /// Keeps the inside or the outside of the ellipsoid that touches the faces of a box.
    Ellipsoid(BoxClip),
    /// Keeps the inside or the outside of the elliptic cylinder along z that touches the faces of a box.
    Cylinder(BoxClip),
    /// Keeps the inside or the outside of a mask.
    Mask(MaskClip),
}

/// Keeps the side of a plane that its normal points to.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
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
    /// Names of the objects that are cut; default all. `volume` is the scene's own volume.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub objects: Option<Vec<String>>,
}

/// A box, and whether its inside or its outside is kept.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
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
    /// Names of the objects that are cut; default all. `volume` is the scene's own volume.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub objects: Option<Vec<String>>,
}

/// A volume whose values say what is inside.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MaskClip {
    /// File with the mask, on a grid of its own; relative to the folder of the scene file.
    pub path: String,
    /// Inside is where the mask, linear between its voxels, is above this; default 0.5.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub threshold: Option<f64>,
    /// Instead of a threshold: the file holds labels, and these are inside, by their ids or by their names in the file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub labels: Option<Vec<LabelName>>,
    /// What is kept; default `inside`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub keep: Option<Keep>,
    /// Names of the objects that are cut; default all. `volume` is the scene's own volume.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub objects: Option<Vec<String>>,
}

/// A label, as people write it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "the id of a label, a whole number from 0, or its name"
)]
pub enum LabelName {
    /// Its id: the number that its voxels have.
    Id(u32),
    /// Its name in the file.
    Name(String),
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

/// What a shape keeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Keep {
    /// What is in it.
    Inside,
    /// What is around it.
    Outside,
}

/// What a clip needs to know of the scene around it.
pub(crate) struct ClipPlaces<'c> {
    /// Of the scene's own volume, that boxes may count in.
    pub grid: &'c Grid,
    /// Of each mask, in the order of the clips.
    pub masks: &'c [Grid],
    /// Of each object, in the order of the Plan, `None` for nameless ones.
    pub names: &'c [Option<String>],
}

/// The clips of a plan.
#[derive(Default)]
pub(crate) struct PlanClips {
    pub planes: Vec<ClipPlane>,
    pub shapes: Vec<SampleClip>,
    /// Masks met so far.
    pub masks: usize,
}

impl Clip {
    /// Where the mask lies, if this is one.
    pub fn mask_path(&mut self) -> Option<&mut String> {
        match self {
            Clip::Mask(mask) => Some(&mut mask.path),
            _ => None,
        }
    }

    pub(crate) fn settled(self, grid: &Grid) -> Clip {
        let shape = |clip: BoxClip| BoxClip {
            space: clip.space.or(Some(BoxSpace::World)),
            rotation_deg: clip.rotation_deg.or(Some([0.0; 3])),
            keep: clip.keep.or(Some(Keep::Inside)),
            ..clip
        };
        match self {
            Clip::Plane(plane) => Clip::Plane(PlaneClip {
                point: plane.point.or(plane
                    .distance_mm
                    .is_none()
                    .then(|| grid.centre_mm().to_array())),
                ..plane
            }),
            Clip::Box(clip) => Clip::Box(shape(clip)),
            Clip::Ellipsoid(clip) => Clip::Ellipsoid(shape(clip)),
            Clip::Cylinder(clip) => Clip::Cylinder(shape(clip)),
            Clip::Mask(mask) => Clip::Mask(MaskClip {
                threshold: mask.threshold.or(mask.labels.is_none().then_some(0.5)),
                keep: mask.keep.or(Some(Keep::Inside)),
                ..mask
            }),
        }
    }

    /// Adds the clip to a plan's; `self` must be settled. A box that keeps its inside is convex: it
    /// becomes six planes, so that rays start at its faces.
    pub(crate) fn plan(
        &self,
        path: &str,
        places: &ClipPlaces,
        checker: &mut Checker,
        clips: &mut PlanClips,
    ) {
        let (kind, shape, clip) = match self {
            Clip::Plane(plane) => {
                let path = format!("{path}.plane");
                let layers = layers(&path, &plane.objects, places.names, checker);
                let plane = plane.plan(&path, checker);
                clips
                    .planes
                    .extend(plane.map(|plane| ClipPlane { layers, ..plane }));
                return;
            }
            Clip::Mask(mask) => {
                mask.plan(&format!("{path}.mask"), places, checker, clips);
                return;
            }
            Clip::Box(clip) => ("box", ClipShape::Box, clip),
            Clip::Ellipsoid(clip) => ("ellipsoid", ClipShape::Ellipsoid, clip),
            Clip::Cylinder(clip) => ("cylinder", ClipShape::Cylinder, clip),
        };
        let path = format!("{path}.{kind}");
        let layers = layers(&path, &clip.objects, places.names, checker);
        let Some(unit_from_world) = clip.plan(&path, places.grid, checker) else {
            return;
        };
        let keep_inside = clip.keep != Some(Keep::Outside);
        if shape != ClipShape::Box || !keep_inside {
            clips.shapes.push(SampleClip {
                shape,
                unit_from_world,
                keep_inside,
                layers,
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
                clips.planes.push(ClipPlane {
                    normal: side * row / length,
                    offset_mm: (0.5 + side * shift) / length,
                    layers,
                });
            }
        }
    }
}

/// The layers of the objects that have these names.
fn layers(
    path: &str,
    wanted: &Option<Vec<String>>,
    names: &[Option<String>],
    checker: &mut Checker,
) -> LayerSet {
    let Some(wanted) = wanted else {
        return ALL_LAYERS;
    };
    let known: Vec<&str> = names.iter().flatten().map(String::as_str).collect();
    let mut set = 0;
    for (i, name) in wanted.iter().enumerate() {
        match names.iter().position(|known| known.as_ref() == Some(name)) {
            Some(layer) => set |= 1 << layer,
            None => checker.add(
                format!("{path}.objects[{i}]"),
                format!("{name:?}"),
                &format!("the name of a volume of the scene: {}", known.join(", ")),
            ),
        }
    }
    set
}

impl MaskClip {
    /// The ids of the labels that are inside, found in the `labels` that its file holds; `path` is that of the clip
    /// in the scene. None if it names none: its file is a mask as it is.
    ///
    /// # Errors
    /// Each label that the file does not have.
    pub fn label_ids(&self, path: &str, labels: &LabelVolume) -> Result<Vec<u32>, Problems> {
        let names = self.labels.as_deref().unwrap_or(&[]);
        let known = labels.known_ids();
        let of_name = |name: &str| labels.labels().iter().find(|label| label.name == name);
        let mut checker = Checker::default();
        let mut ids = Vec::new();
        for (i, name) in names.iter().enumerate() {
            let id = match name {
                LabelName::Id(id) => known.contains(id).then_some(*id),
                LabelName::Name(name) => of_name(name).map(|label| label.id),
            };
            if id.is_none() {
                let value = match name {
                    LabelName::Id(id) => id.to_string(),
                    LabelName::Name(name) => format!("{name:?}"),
                };
                let allowed = format!("a label of {}: {}", self.path, listed(&known, labels));
                checker.add(format!("{path}.mask.labels[{i}]"), value, &allowed);
            }
            ids.extend(id);
        }
        Problems::none_of(checker.problems)?;
        Ok(ids)
    }

    fn plan(&self, path: &str, places: &ClipPlaces, checker: &mut Checker, clips: &mut PlanClips) {
        let layers = layers(path, &self.objects, places.names, checker);
        if self.labels.as_ref().is_some_and(Vec::is_empty) {
            checker.add(format!("{path}.labels"), "empty", "one label or more");
        }
        if let (Some(_), Some(threshold)) = (&self.labels, self.threshold) {
            checker.add(
                format!("{path}.threshold"),
                threshold,
                "either labels or a threshold",
            );
        }
        let threshold = self.threshold.unwrap_or(0.5);
        checker.number(
            &format!("{path}.threshold"),
            threshold,
            Within::Closed(-1e30, 1e30),
        );
        let mask = clips.masks;
        clips.masks += 1;
        if mask >= MOST_MASKS {
            checker.add(
                path,
                "one mask more",
                &format!("at most {MOST_MASKS} masks in one picture"),
            );
            return;
        }
        let Some(grid) = places.masks.get(mask) else {
            checker.add(
                path,
                format!("{:?}, which is not loaded", self.path),
                "a mask that is handed over with the scene",
            );
            return;
        };
        let (first, last) = grid.extent_in_voxels();
        let voxel_from_unit = DAffine3::from_mat3_translation(
            DMat3::from_diagonal(last - first),
            0.5 * (first + last),
        );
        clips.shapes.push(SampleClip {
            shape: ClipShape::Mask {
                mask,
                threshold: threshold as f32,
            },
            unit_from_world: (grid.world_from_voxel() * voxel_from_unit).inverse(),
            keep_inside: self.keep != Some(Keep::Outside),
            layers,
        });
    }
}

/// The labels with these ascending ids, with names where they have any, as far as they fit a message.
fn listed(ids: &[u32], labels: &LabelVolume) -> String {
    const MOST: usize = 16;
    let name = |id: u32| {
        let label = labels.labels().iter().find(|label| label.id == id);
        label.map(|label| label.name.as_str())
    };
    // Numbers in a row that nobody has named are a range.
    let in_a_row = |a: &u32, b: &u32| *b == a + 1 && name(*a).is_none() && name(*b).is_none();
    let rows: Vec<&[u32]> = ids.chunk_by(in_a_row).collect();
    let describe = |row: &&[u32]| {
        let (first, last) = (row[0], row[row.len() - 1]);
        match name(first) {
            Some(name) => format!("{first} ({name:?})"),
            None if first == last => first.to_string(),
            None => format!("{first} to {last}"),
        }
    };
    let listed: Vec<String> = rows.iter().take(MOST).map(describe).collect();
    match rows.len().saturating_sub(MOST) {
        0 => listed.join(", "),
        more => format!("{} and {more} more", listed.join(", ")),
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
        (checker.problems.len() == before).then_some(ClipPlane {
            normal,
            offset_mm,
            layers: ALL_LAYERS,
        })
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
