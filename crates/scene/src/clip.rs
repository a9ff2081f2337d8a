//! Planes, boxes, masks and the like that cut parts away, as people write them.

use crate::frame::PlacedFrame;
use crate::object::{OWN_VOLUME, WORLD};
use crate::plan::{ALL_LAYERS, ClipPlane, ClipShape, LayerSet, MOST_MASKS, SampleClip};
use crate::problem::{Checker, Problems, Within};
use glam::{DAffine3, DMat3, DQuat, DVec3, EulerRot};
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use strahl_volume::{Grid, LabelVolume};

/// Cuts away a part of the picture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
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
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct PlaneClip {
    /// Direction to the side that is kept, RAS; any length above 0.
    pub normal: [f64; 3],
    /// A point of the plane in RAS mm; default the center of the volume.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub point: Option<[f64; 3]>,
    /// Instead of a point: distance of the plane from the world origin along the normal.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub distance_mm: Option<f64>,
    /// Frame of the plane: `world` (default), or the name of an object that it moves with. Its numbers are then mm of
    /// the object before its transforms.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frame: Option<String>,
    /// Names of the objects that are cut; default all. `volume` is the scene's own volume.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub objects: Option<Vec<String>>,
}

/// A box, and whether its inside or its outside is kept.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct BoxClip {
    /// One corner.
    pub min: [f64; 3],
    /// The opposite corner, larger in every part.
    pub max: [f64; 3],
    /// What the corners count in; default `world`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub space: Option<BoxSpace>,
    /// Turns the box about its center: about x, then y, then z; default 0. World space only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotation_deg: Option<[f64; 3]>,
    /// What is kept; default `inside`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub keep: Option<KeptSide>,
    /// Frame of the box: `world`, or the name of an object that it moves with. Corners in `world` space are then mm of
    /// the object before its transforms. Default in `world` space: `world`; in `voxels` and `fraction`: the object in
    /// `objects` if that is a single one, else the scene's own volume.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frame: Option<String>,
    /// Names of the objects that are cut; default all. `volume` is the scene's own volume.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub objects: Option<Vec<String>>,
}

/// A volume whose values define the inside.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct MaskClip {
    /// File with the mask, on a grid of its own; relative to the folder of the scene file.
    pub path: String,
    /// The inside is where the mask, interpolated linearly, is above this; default 0.5.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub threshold: Option<f64>,
    /// Instead of a threshold: the inside is made of these labels of the file, given by id or
    /// by name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub labels: Option<Vec<LabelName>>,
    /// What is kept; default `inside`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub keep: Option<KeptSide>,
    /// Frame of the mask: `world` (default), or the name of an object that it moves with. The file then lies in mm of
    /// the object before its transforms.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frame: Option<String>,
    /// Names of the objects that are cut; default all. `volume` is the scene's own volume.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub objects: Option<Vec<String>>,
}

/// A label in a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(
    untagged,
    expecting = "the id of a label, a whole number from 0, or its name"
)]
pub enum LabelName {
    /// The id: the number of its voxels.
    Id(u32),
    /// The name in the file.
    Name(String),
}

/// What the corners of a box count in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum BoxSpace {
    /// RAS mm.
    World,
    /// Voxel indices; voxel centers are whole numbers.
    Voxels,
    /// Fractions of the volume along its voxel axes: 0 is its first face, 1 its last.
    Fraction,
}

/// Which side of a shape is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum KeptSide {
    /// The inside of the shape.
    Inside,
    /// The outside of the shape.
    Outside,
}

/// [`Clip`] with every default filled in.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SettledClip {
    pub shape: SettledShape,
    /// Name of its frame.
    pub frame: String,
    /// `None`: all.
    pub objects: Option<Vec<String>>,
}

/// What cuts.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum SettledShape {
    Plane {
        normal: [f64; 3],
        place: PlanePlace,
    },
    Box(SettledBox),
    Ellipsoid(SettledBox),
    Cylinder(SettledBox),
    Mask {
        path: String,
        inside: MaskInside,
        keep: KeptSide,
    },
}

/// Where a plane lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum PlanePlace {
    Point([f64; 3]),
    DistanceMm(f64),
}

/// [`BoxClip`] with everything said.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SettledBox {
    pub min: [f64; 3],
    pub max: [f64; 3],
    pub space: BoxSpace,
    pub rotation_deg: [f64; 3],
    pub keep: KeptSide,
}

/// What of a file is the inside of a mask.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum MaskInside {
    Above(f64),
    Labels(Vec<LabelName>),
}

impl MaskInside {
    /// Values above this are inside; masks of labels hold 1 there and 0 elsewhere.
    fn threshold(&self) -> f64 {
        match self {
            MaskInside::Above(threshold) => *threshold,
            MaskInside::Labels(_) => DEFAULT_THRESHOLD,
        }
    }
}

/// Halfway between nothing and 1.
const DEFAULT_THRESHOLD: f64 = 0.5;

/// What a clip needs to know of the scene around it.
pub(crate) struct ClipPlaces<'c> {
    /// Frames that clips may have, that of the scene's own volume first.
    pub frames: &'c [PlacedFrame],
    /// Of each mask, in the order of the clips.
    pub masks: &'c [Grid],
    /// Of each layer, in the order of the Plan, `None` for nameless ones.
    pub names: Vec<Option<&'c str>>,
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

    /// The clip that this means beside these frames, of which the first is that of the scene's own volume. Keys that
    /// exclude each other are problems.
    pub(crate) fn settled(
        &self,
        frames: &[PlacedFrame],
        path: &str,
        checker: &mut Checker,
    ) -> SettledClip {
        let (shape, frame, objects) = match self {
            Clip::Plane(plane) => {
                let frame = plane.frame.as_deref().unwrap_or(WORLD);
                let place = plane.place(&center_in(frames, frame), path, checker);
                let normal = plane.normal;
                let shape = SettledShape::Plane { normal, place };
                (shape, frame, &plane.objects)
            }
            Clip::Box(clip) => (
                SettledShape::Box(clip.settled()),
                clip.frame(),
                &clip.objects,
            ),
            Clip::Ellipsoid(clip) => (
                SettledShape::Ellipsoid(clip.settled()),
                clip.frame(),
                &clip.objects,
            ),
            Clip::Cylinder(clip) => (
                SettledShape::Cylinder(clip.settled()),
                clip.frame(),
                &clip.objects,
            ),
            Clip::Mask(mask) => {
                let shape = SettledShape::Mask {
                    path: mask.path.clone(),
                    inside: mask.inside(path, checker),
                    keep: mask.keep.unwrap_or(KeptSide::Inside),
                };
                let frame = mask.frame.as_deref().unwrap_or(WORLD);
                (shape, frame, &mask.objects)
            }
        };
        SettledClip {
            shape,
            frame: frame.to_owned(),
            objects: objects.clone(),
        }
    }
}

/// The center of the volume of a frame, in mm of the frame; of the scene's own volume if the frame has none.
fn center_in(frames: &[PlacedFrame], frame: &str) -> DVec3 {
    let found = frames.iter().find(|known| known.name == frame);
    let shows = found
        .filter(|frame| frame.grid.is_some())
        .or(frames.first());
    let center = shows.and_then(|frame| Some(frame.grid?.center_mm()));
    let world_from_object = found.map_or(DAffine3::IDENTITY, |frame| frame.world_from_object);
    let center = center.unwrap_or(DVec3::ZERO);
    match world_from_object == DAffine3::IDENTITY {
        true => center,
        false => world_from_object.inverse().transform_point3(center),
    }
}

impl PlaneClip {
    fn place(&self, center: &DVec3, path: &str, checker: &mut Checker) -> PlanePlace {
        if let (Some(_), Some(distance)) = (self.point, self.distance_mm) {
            checker.add(
                format!("{path}.plane.distance_mm"),
                distance,
                "either point or distance_mm",
            );
        }
        match (self.point, self.distance_mm) {
            (None, Some(distance_mm)) => PlanePlace::DistanceMm(distance_mm),
            (point, _) => PlanePlace::Point(point.unwrap_or(center.to_array())),
        }
    }
}

impl BoxClip {
    fn frame(&self) -> &str {
        match (&self.frame, &self.space, self.objects.as_deref()) {
            (Some(frame), ..) => frame,
            (None, None | Some(BoxSpace::World), _) => WORLD,
            (None, _, Some([cut])) => cut,
            (None, ..) => OWN_VOLUME,
        }
    }

    fn settled(&self) -> SettledBox {
        SettledBox {
            min: self.min,
            max: self.max,
            space: self.space.unwrap_or(BoxSpace::World),
            rotation_deg: self.rotation_deg.unwrap_or([0.0; 3]),
            keep: self.keep.unwrap_or(KeptSide::Inside),
        }
    }
}

impl SettledClip {
    /// As a scene says it.
    pub fn scene(&self) -> Clip {
        let objects = self.objects.clone();
        let frame = Some(self.frame.clone());
        let of_box = |clip: &SettledBox| BoxClip {
            frame: frame.clone(),
            min: clip.min,
            max: clip.max,
            space: Some(clip.space),
            rotation_deg: Some(clip.rotation_deg),
            keep: Some(clip.keep),
            objects: objects.clone(),
        };
        match &self.shape {
            SettledShape::Plane { normal, place } => {
                let (point, distance_mm) = match *place {
                    PlanePlace::Point(point) => (Some(point), None),
                    PlanePlace::DistanceMm(distance_mm) => (None, Some(distance_mm)),
                };
                Clip::Plane(PlaneClip {
                    normal: *normal,
                    point,
                    distance_mm,
                    frame,
                    objects,
                })
            }
            SettledShape::Box(clip) => Clip::Box(of_box(clip)),
            SettledShape::Ellipsoid(clip) => Clip::Ellipsoid(of_box(clip)),
            SettledShape::Cylinder(clip) => Clip::Cylinder(of_box(clip)),
            SettledShape::Mask { path, inside, keep } => {
                let (threshold, labels) = match inside {
                    MaskInside::Above(threshold) => (Some(*threshold), None),
                    MaskInside::Labels(labels) => (None, Some(labels.clone())),
                };
                Clip::Mask(MaskClip {
                    path: path.clone(),
                    threshold,
                    labels,
                    keep: Some(*keep),
                    frame,
                    objects,
                })
            }
        }
    }

    /// The place of its frame, and the grid of its volume. `path` is that of the clip's own keys.
    fn placed<'c>(
        &self,
        path: &str,
        places: &'c ClipPlaces,
        checker: &mut Checker,
    ) -> Option<(DAffine3, Option<&'c Grid>)> {
        if self.frame == WORLD {
            return Some((DAffine3::IDENTITY, None));
        }
        let found = places.frames.iter().find(|frame| frame.name == self.frame);
        if found.is_none() {
            let names = places.frames.iter().map(|frame| frame.name.as_str());
            let names: Vec<&str> = std::iter::once(WORLD).chain(names).collect();
            checker.add(
                format!("{path}.frame"),
                format!("{:?}", self.frame),
                &names.join(", "),
            );
        }
        found.map(|frame| (frame.world_from_object, frame.grid.as_ref()))
    }

    /// Adds the clip to a plan's. A box that keeps its inside is convex: it becomes six planes, so that rays start at
    /// its faces.
    pub fn plan(
        &self,
        path: &str,
        places: &ClipPlaces,
        checker: &mut Checker,
        clips: &mut PlanClips,
    ) {
        let (kind, shape, clip) = match &self.shape {
            SettledShape::Plane { normal, place } => {
                let path = format!("{path}.plane");
                let layers = layers(&path, &self.objects, &places.names, checker);
                let plane = plan_plane(*normal, *place, &path, checker);
                if let (Some((world_from_frame, _)), Some(plane)) =
                    (self.placed(&path, places, checker), plane)
                {
                    let plane = ClipPlane { layers, ..plane };
                    clips.planes.push(moved_plane(plane, world_from_frame));
                }
                return;
            }
            SettledShape::Mask {
                path: file,
                inside,
                keep,
            } => {
                let path = format!("{path}.mask");
                let layers = layers(&path, &self.objects, &places.names, checker);
                let clip = plan_mask(file, inside.threshold(), &path, places, checker, clips);
                if let (Some((world_from_frame, _)), Some(clip)) =
                    (self.placed(&path, places, checker), clip)
                {
                    clips.shapes.push(SampleClip {
                        keep_inside: *keep == KeptSide::Inside,
                        layers,
                        unit_from_world: moved(clip.unit_from_world, world_from_frame),
                        ..clip
                    });
                }
                return;
            }
            SettledShape::Box(clip) => ("box", ClipShape::Box, clip),
            SettledShape::Ellipsoid(clip) => ("ellipsoid", ClipShape::Ellipsoid, clip),
            SettledShape::Cylinder(clip) => ("cylinder", ClipShape::Cylinder, clip),
        };
        let path = format!("{path}.{kind}");
        let layers = layers(&path, &self.objects, &places.names, checker);
        let Some((world_from_frame, grid)) = self.placed(&path, places, checker) else {
            return;
        };
        let Some(unit_from_world) = clip.plan(&path, world_from_frame, grid, checker) else {
            return;
        };
        let keep_inside = clip.keep == KeptSide::Inside;
        if shape == ClipShape::Box && keep_inside {
            clips.planes.extend(faces(&unit_from_world, layers));
        } else {
            clips.shapes.push(SampleClip {
                shape,
                unit_from_world,
                keep_inside,
                layers,
            });
        }
    }
}

/// A plane of a frame in the world.
fn moved_plane(plane: ClipPlane, world_from_frame: DAffine3) -> ClipPlane {
    if world_from_frame == DAffine3::IDENTITY {
        return plane;
    }
    let frame_from_world = world_from_frame.inverse();
    let normal = frame_from_world.matrix3.transpose() * plane.normal;
    let offset_mm = plane.normal.dot(frame_from_world.translation) + plane.offset_mm;
    ClipPlane {
        normal: normal.normalize(),
        offset_mm: offset_mm / normal.length(),
        ..plane
    }
}

/// From the world to a shape that lies in a frame.
fn moved(unit_from_frame: DAffine3, world_from_frame: DAffine3) -> DAffine3 {
    match world_from_frame == DAffine3::IDENTITY {
        true => unit_from_frame,
        false => unit_from_frame * world_from_frame.inverse(),
    }
}

/// The planes that keep the inside of a box.
fn faces(unit_from_world: &DAffine3, layers: LayerSet) -> Vec<ClipPlane> {
    let rows = unit_from_world.matrix3.transpose();
    let shift = unit_from_world.translation;
    let mut planes = Vec::new();
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
                layers,
            });
        }
    }
    planes
}

/// The layers of the objects that have these names.
fn layers(
    path: &str,
    wanted: &Option<Vec<String>>,
    names: &[Option<&str>],
    checker: &mut Checker,
) -> LayerSet {
    let Some(wanted) = wanted else {
        return ALL_LAYERS;
    };
    let known: Vec<&str> = names.iter().flatten().copied().collect();
    let mut set = 0;
    for (i, name) in wanted.iter().enumerate() {
        match names.iter().position(|known| *known == Some(name.as_str())) {
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
                let allowed = format!("a label of {}: {}", self.path, listed(known, labels));
                checker.add(format!("{path}.mask.labels[{i}]"), value, &allowed);
            }
            ids.extend(id);
        }
        Problems::none_of(checker.problems)?;
        Ok(ids)
    }

    /// What of the file is inside. `path` is that of the clip.
    fn inside(&self, path: &str, checker: &mut Checker) -> MaskInside {
        let Some(labels) = &self.labels else {
            return MaskInside::Above(self.threshold.unwrap_or(DEFAULT_THRESHOLD));
        };
        if labels.is_empty() {
            checker.add(format!("{path}.mask.labels"), "empty", "one label or more");
        }
        if let Some(threshold) = self.threshold {
            checker.add(
                format!("{path}.mask.threshold"),
                threshold,
                "either labels or a threshold",
            );
        }
        MaskInside::Labels(labels.clone())
    }
}

/// A mask that keeps its inside of every layer.
fn plan_mask(
    file: &str,
    threshold: f64,
    path: &str,
    places: &ClipPlaces,
    checker: &mut Checker,
    clips: &mut PlanClips,
) -> Option<SampleClip> {
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
            format!("mask number {}", mask + 1),
            &format!("at most {MOST_MASKS} masks in one picture; one mask can have several labels"),
        );
        return None;
    }
    let Some(grid) = places.masks.get(mask) else {
        checker.add(
            path,
            format!("{file:?}, which is not loaded"),
            "a mask that is handed over with the scene",
        );
        return None;
    };
    Some(SampleClip {
        shape: ClipShape::Mask {
            mask,
            threshold: threshold as f32,
        },
        unit_from_world: unit_from_world(grid),
        keep_inside: true,
        layers: ALL_LAYERS,
    })
}

/// World (mm) → the cube from −0.5 to 0.5 that holds a mask on this grid.
pub(crate) fn unit_from_world(grid: &Grid) -> DAffine3 {
    let (first, last) = grid.extent_in_voxels();
    let voxel_from_unit =
        DAffine3::from_mat3_translation(DMat3::from_diagonal(last - first), 0.5 * (first + last));
    (grid.world_from_voxel() * voxel_from_unit).inverse()
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

/// A plane that cuts every layer.
fn plan_plane(
    normal: [f64; 3],
    place: PlanePlace,
    path: &str,
    checker: &mut Checker,
) -> Option<ClipPlane> {
    let before = checker.problems.len();
    let direction = DVec3::from_array(normal);
    if !direction.is_finite() || direction.abs().max_element() > 1e12 || direction.length() < 1e-12
    {
        checker.add(
            format!("{path}.normal"),
            format!("{normal:?}"),
            "three numbers, not all 0",
        );
    }
    let normal = direction.normalize_or_zero();
    let offset_mm = match place {
        PlanePlace::Point(point) => {
            checker.point(&format!("{path}.point"), point);
            -normal.dot(DVec3::from_array(point))
        }
        PlanePlace::DistanceMm(distance) => {
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

impl SettledBox {
    /// From the world to the unit cube of a box in a frame, whose volume has this grid.
    fn plan(
        &self,
        path: &str,
        world_from_frame: DAffine3,
        grid: Option<&Grid>,
        checker: &mut Checker,
    ) -> Option<DAffine3> {
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
        let turn = self.rotation_deg;
        for (axis, degrees) in turn.into_iter().enumerate() {
            checker.number(
                &format!("{path}.rotation_deg[{axis}]"),
                degrees,
                Within::Closed(-360.0, 360.0),
            );
        }
        if self.space != BoxSpace::World && turn != [0.0; 3] {
            checker.add(
                format!("{path}.rotation_deg"),
                format!("{turn:?}"),
                "[0, 0, 0] unless the box is in world space",
            );
        }
        if self.space != BoxSpace::World && grid.is_none() {
            checker.add(
                format!("{path}.space"),
                "not \"world\", and its frame has no volume",
                "\"world\", or the name of an object with a volume as frame",
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
        let world_from_space = match (self.space, grid) {
            (BoxSpace::World, _) | (_, None) => world_from_frame,
            (BoxSpace::Voxels, Some(grid)) => grid.world_from_voxel(),
            (BoxSpace::Fraction, Some(grid)) => {
                let (first, last) = grid.extent_in_voxels();
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
