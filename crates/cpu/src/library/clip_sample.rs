//! Slot clip_sample: which samples of a ray are dropped.

mod mask;
mod shapes;

pub use shapes::in_box;

use crate::lanes::{Affine, Mask, Vec3s};
use crate::levels::{Level, vectorized};
use crate::library::reconstruct::Values;
use strahl_scene::plan::{ClipShape, Plan};
use strahl_volume::Grid;

/// The sample clips of one object, in its voxel space.
pub struct SampleClips<'v, S: Level>(Vec<Clip<'v, S>>);

struct Clip<'v, S: Level> {
    shape: Shape<'v, S>,
    /// Voxel space → the cube from −0.5 to 0.5.
    unit_from_voxel: Affine,
    /// Whether the inside is kept (else the outside).
    keep_inside: bool,
}

enum Shape<'v, S: Level> {
    Box,
    Ellipsoid,
    Cylinder,
    Mask(&'v dyn Values<S>, f32),
}

impl<'v, S: Level> SampleClips<'v, S> {
    /// The clips of `plan` for object number `object`, which lies on `grid`.
    pub fn new(
        plan: &Plan,
        object: usize,
        grid: &Grid,
        masks: &'v [Box<dyn Values<S> + 'v>],
    ) -> SampleClips<'v, S> {
        let clips = plan.sample_clips.iter().filter(|clip| clip.cuts(object));
        let clip = |clip: &strahl_scene::plan::SampleClip| Clip {
            shape: match clip.shape {
                ClipShape::Box => Shape::Box,
                ClipShape::Ellipsoid => Shape::Ellipsoid,
                ClipShape::Cylinder => Shape::Cylinder,
                ClipShape::Mask { mask, threshold } => Shape::Mask(&*masks[mask], threshold),
            },
            unit_from_voxel: Affine::new(clip.unit_from_world * grid.world_from_voxel()),
            keep_inside: clip.keep_inside,
        };
        SampleClips(clips.map(clip).collect())
    }

    /// Whether every sample is kept.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Where a sample at `position` (voxel space) is kept.
    #[inline(always)]
    pub fn keep(&self, position: Vec3s<S>, asked: Mask<S>) -> Mask<S> {
        if self.is_empty() {
            return asked;
        }
        self.keep_some(position, asked)
    }

    #[inline(never)]
    fn keep_some(&self, position: Vec3s<S>, asked: Mask<S>) -> Mask<S> {
        vectorized::<S, _>(
            #[inline(always)]
            || self.kept(position, asked),
        )
    }

    #[inline(always)]
    fn kept(&self, position: Vec3s<S>, mut kept: Mask<S>) -> Mask<S> {
        for clip in &self.0 {
            let unit = clip.unit_from_voxel.point(position);
            let inside = match clip.shape {
                Shape::Box => shapes::in_box(unit),
                Shape::Ellipsoid => shapes::in_ellipsoid(unit),
                Shape::Cylinder => shapes::in_cylinder(unit),
                Shape::Mask(mask, threshold) => mask::above(mask, unit, threshold),
            };
            kept = kept & if clip.keep_inside { inside } else { !inside };
        }
        kept
    }
}
