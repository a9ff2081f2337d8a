//! Where everything of a scene lies in the world.

use crate::frame::PlacedFrame;
use crate::object::{OWN_VOLUME, placements};
use crate::problem::Checker;
use crate::{Headers, Scene, SceneObject};
use glam::{DAffine3, DMat3, DVec3};
use std::collections::HashMap;
use strahl_volume::Grid;

/// Where everything of a scene lies in the world.
pub(crate) struct Places {
    /// The scene's own volume, then those of its objects.
    pub volumes: Vec<PlacedVolume>,
    pub meshes: Vec<PlacedMesh>,
    /// A grid around everything: what the camera frames.
    pub framed: Grid,
    /// Frames that clips may have: that of every object with a name.
    pub frames: Vec<PlacedFrame>,
}

/// A volume that is drawn.
pub(crate) struct PlacedVolume {
    /// Which object of the scene it is; `None` for the scene's own volume.
    pub object: Option<usize>,
    /// What clips call it.
    pub name: Option<String>,
    /// Which of the headers it has.
    pub volume: usize,
    /// Where the voxels of level 0 lie.
    pub grid: Grid,
    /// Where the voxels of the level that is drawn lie.
    pub drawn: Grid,
}

/// A mesh that is drawn.
pub(crate) struct PlacedMesh {
    /// Which object of the scene it is.
    pub object: usize,
    /// Which of the meshes.
    pub mesh: usize,
    /// What the scene calls its file.
    pub file: String,
    pub world_from_mesh: DAffine3,
}

impl Places {
    pub fn new(scene: &Scene, headers: &Headers, checker: &mut Checker) -> Places {
        let objects = scene.objects.as_deref().unwrap_or(&[]);
        let worlds = placements(scene.transform.as_ref(), objects, checker);
        let own = &headers.volumes[0];
        let mut places = Places {
            volumes: vec![PlacedVolume {
                object: None,
                name: Some(OWN_VOLUME.to_owned()),
                volume: 0,
                grid: place(&own.grid, worlds[0], "transform", checker),
                drawn: place(&headers.drawn(0).grid, worlds[0], "transform", checker),
            }],
            meshes: Vec::new(),
            framed: own.grid,
            frames: Vec::new(),
        };
        for (i, volume) in volume_indices(objects).into_iter().enumerate() {
            if let Some(file) = &objects[i].mesh {
                places.meshes.push(PlacedMesh {
                    object: i,
                    mesh: places.meshes.len(),
                    file: file.clone(),
                    world_from_mesh: worlds[1 + i],
                });
            }
            let Some((volume, header)) = volume.and_then(|v| Some((v, headers.volumes.get(v)?)))
            else {
                continue;
            };
            let path = format!("objects[{i}].transform");
            places.volumes.push(PlacedVolume {
                object: Some(i),
                name: objects[i].name.clone(),
                volume,
                grid: place(&header.grid, worlds[1 + i], &path, checker),
                drawn: place(&headers.drawn(volume).grid, worlds[1 + i], &path, checker),
            });
        }
        places.framed = places.around(headers);
        places.frames = places.frames(objects, &worlds);
        places
    }

    /// The frames of all objects with a name, that of the scene's own volume first.
    fn frames(&self, objects: &[SceneObject], worlds: &[DAffine3]) -> Vec<PlacedFrame> {
        let own = std::iter::once((None, OWN_VOLUME));
        let named = objects.iter().enumerate();
        let named = named.filter_map(|(i, object)| Some((Some(i), object.name.as_deref()?)));
        let by_object = self.volumes.iter();
        let by_object: HashMap<_, _> = by_object.map(|volume| (volume.object, volume)).collect();
        let frame = |(object, name): (Option<usize>, &str)| PlacedFrame {
            name: name.to_owned(),
            world_from_object: worlds[object.map_or(0, |i| 1 + i)],
            grid: by_object.get(&object).map(|volume| volume.grid),
        };
        own.chain(named).map(frame).collect()
    }

    /// The grid of one volume, or a box around all.
    fn around(&self, headers: &Headers) -> Grid {
        let own = &self.volumes[0].grid;
        if self.volumes.len() == 1 && self.meshes.is_empty() {
            return *own;
        }
        let (mut lo, mut hi) = own.bounds_mm();
        for volume in &self.volumes {
            let (a, b) = volume.grid.bounds_mm();
            (lo, hi) = (lo.min(a), hi.max(b));
        }
        for mesh in &self.meshes {
            let Some([a, b]) = headers.meshes.get(mesh.mesh) else {
                continue;
            };
            for corner in 0..8 {
                let at = |axis: usize| {
                    if corner >> axis & 1 == 0 {
                        a[axis]
                    } else {
                        b[axis]
                    }
                };
                let corner = DVec3::new(at(0), at(1), at(2));
                let corner = mesh.world_from_mesh.transform_point3(corner);
                (lo, hi) = (lo.min(corner), hi.max(corner));
            }
        }
        let cube = DAffine3::from_mat3_translation(DMat3::from_diagonal(hi - lo), 0.5 * (lo + hi));
        Grid::new([1; 3], cube).unwrap_or(*own)
    }
}

/// `grid`, moved.
fn place(grid: &Grid, world: DAffine3, path: &str, checker: &mut Checker) -> Grid {
    if world == DAffine3::IDENTITY {
        return *grid;
    }
    Grid::new(grid.dims(), world * grid.world_from_voxel()).unwrap_or_else(|error| {
        checker.add(
            path,
            format!("a transform after which {error}"),
            "a volume of a size that can be drawn",
        );
        *grid
    })
}

/// Which of the headers each object shows; `None` for meshes, groups and what cannot be found.
fn volume_indices(objects: &[SceneObject]) -> Vec<Option<usize>> {
    let mut by_name = HashMap::from([(OWN_VOLUME, 0)]);
    let mut own = Vec::with_capacity(objects.len());
    let mut number = 0;
    for object in objects {
        number += usize::from(object.volume.is_some());
        own.push(object.volume.as_ref().map(|_| number));
        if let (Some(_), Some(name)) = (&object.volume, &object.name) {
            by_name.entry(name).or_insert(number);
        }
    }
    let index = |(object, own): (&SceneObject, &Option<usize>)| {
        let shown_again = || by_name.get(object.like.as_deref()?).copied();
        own.or_else(shown_again)
    };
    objects.iter().zip(&own).map(index).collect()
}

/// Whether labels lie somewhere in the volume; a problem if not.
pub(crate) fn check_labels(grid: &Grid, labels: &Grid, checker: &mut Checker) -> bool {
    let ([low, high], [from, to]) = (grid.bounds_mm().into(), labels.bounds_mm().into());
    let (low, high, from, to): (DVec3, DVec3, DVec3, DVec3) = (low, high, from, to);
    if from.cmplt(high).all() && low.cmplt(to).all() {
        return true;
    }
    let describe = |grid: &Grid| {
        let [x, y, z] = grid.dims();
        let spacing = grid.spacing_mm();
        let center = grid.center_mm();
        format!(
            "{x}×{y}×{z} voxels of {:.4}×{:.4}×{:.4} mm, axes {}, center ({:.2}, {:.2}, {:.2}) mm",
            spacing.x,
            spacing.y,
            spacing.z,
            grid.orientation(),
            center.x,
            center.y,
            center.z
        )
    };
    checker.add(
        "labels",
        format!("on a grid of {}", describe(labels)),
        &format!("a grid that meets the volume's: {}", describe(grid)),
    );
    false
}
