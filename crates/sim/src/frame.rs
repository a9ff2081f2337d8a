//! What a run needs beside the Spec, settled before the first clock: whatever can fail, fails here.

use crate::Error;
use crate::adaptive::RadiusStore;
use crate::distance::DistanceStore;
use crate::rays::RaySetup;
use crate::spec::{Shading, Spec};
use crate::stages::classify::Tables;
use crate::stages::fetch::Voxels;
use crate::stages::material::Materials;
use crate::stages::shade::ReflectanceMap;
use crate::volume_store::VolumeStore;
use crate::voxel_layout::VoxelLayout;
use std::sync::Arc;

/// A volume, loaded, classified and distance-coded, and the rays of a picture of it.
#[derive(Clone, Debug)]
pub struct Frame {
    /// What is built.
    pub spec: Spec,
    /// Rays and tiles.
    pub setup: RaySetup,
    /// Voxels as they are on the data buses.
    pub voxels: Arc<Voxels>,
    /// Tables behind interpolation.
    pub tables: Arc<Tables>,
    /// Light; none if unlit.
    pub map: Option<ReflectanceMap>,
    /// Colour; none if grey.
    pub materials: Option<Materials>,
    /// How far rays may leap; none without leaping.
    pub distance: Option<Arc<DistanceStore>>,
    /// How many steps may be interpolated; none without adaptive sampling.
    pub radius: Option<Arc<RadiusStore>>,
    /// Where voxels lie.
    pub layout: VoxelLayout,
    /// Polygons, as a fragment per pixel (rows from the bottom).
    pub fragments: Option<Arc<Vec<Option<Fragment>>>>,
    /// How rays are bent.
    pub deformation: Option<Arc<Deformation>>,
}

impl Frame {
    /// Settles a frame.
    ///
    /// # Errors
    /// If the Spec contradicts itself, the volume or the view.
    pub fn new(spec: &Spec, volume: &VolumeStore) -> Result<Frame, Error> {
        spec.check()?;
        let layout = VoxelLayout::new(&spec.memory, volume.dims)?;
        let setup = RaySetup::new(spec, volume.dims)?;
        let widths = &spec.widths;
        let tables = Tables::new(
            &spec.look.settled(volume.range),
            widths.data,
            |word| volume.value(word),
            volume.range,
        );
        let words = volume.words.iter().map(|w| tables.bus_word(*w)).collect();
        let voxels = Voxels::new(volume.dims, words);
        let nominal = spec.view.step * if spec.view.is_moving { 2.0 } else { 1.0 };
        let distance = DistanceStore::new(
            &spec.optimisation,
            &voxels,
            &tables,
            widths.distance,
            nominal,
            setup.largest_step,
        );
        let radius = RadiusStore::new(spec.optimisation.adaptive_error, &voxels, &tables, nominal);
        let map = (spec.look.shading == Shading::ReflectanceMap).then(|| {
            ReflectanceMap::new(
                &spec.look,
                widths.norm,
                widths.reflectance_index,
                widths.intensity,
                &setup.axes,
            )
        });
        let materials = Materials::new(
            &spec.look,
            widths.data,
            volume.range,
            widths.norm,
            widths.reflectance_index,
            widths.intensity,
            &setup.axes,
        );
        Ok(Frame {
            spec: spec.clone(),
            materials,
            setup,
            voxels: Arc::new(voxels),
            tables: Arc::new(tables),
            map,
            distance: distance.map(Arc::new),
            radius: radius.map(Arc::new),
            layout,
            fragments: None,
            deformation: None,
        })
    }

    /// The frame with polygons among the samples, one fragment per pixel, first row at the bottom.
    ///
    /// # Errors
    /// If there is not one entry per pixel.
    pub fn with_fragments(mut self, fragments: Vec<Option<Fragment>>) -> Result<Frame, Error> {
        if fragments.len() != self.setup.pixel_count() {
            let problem = format!("there must be one per pixel, {}", self.setup.pixel_count());
            return Err(Error::field("fragments", fragments.len(), problem));
        }
        self.fragments = Some(Arc::new(fragments));
        Ok(self)
    }

    /// The frame with bent rays.
    ///
    /// # Errors
    /// If there are not `planes` offsets for every pixel, or rays leap: distances say nothing about bent rays.
    pub fn with_deformation(mut self, deformation: Deformation) -> Result<Frame, Error> {
        let needed = self.setup.pixel_count() * deformation.planes as usize;
        if deformation.offsets.len() != needed {
            let problem = format!(
                "there must be {} for each pixel, {needed}",
                deformation.planes
            );
            return Err(Error::field(
                "deformation offsets",
                deformation.offsets.len(),
                problem,
            ));
        }
        if self.distance.is_some() {
            let problem = "distances say nothing about bent rays: set it to off";
            return Err(Error::field("optimisation.leaping", "on", problem));
        }
        self.deformation = Some(Arc::new(deformation));
        Ok(self)
    }
}

/// What a polygon shows in a pixel (document §8.5): the frame buffer of a rasteriser.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fragment {
    /// Its distance from the image plane in steps: samples of this plane and behind are behind it.
    pub plane: u16,
    /// Its opacity: `widths.data` bits. A ray ends at an opaque one.
    pub opacity: u32,
    /// Its light: `widths.intensity` bits; grey pictures use the first.
    pub intensity: [u32; 3],
}

/// Offsets of every sample perpendicular to its ray (document §8.7): per pixel (rows from the bottom) and plane, to the
/// right and up, in 1/256 voxels, 2 bytes each.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Deformation {
    /// Planes per ray; beyond them the last offset counts.
    pub planes: u32,
    /// Pixel after pixel, `planes` each.
    pub offsets: Vec<[i16; 2]>,
}
