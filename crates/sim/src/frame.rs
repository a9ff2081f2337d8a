//! What a run needs beside the Spec, settled before the first clock: whatever can fail, fails here.

use crate::Error;
use crate::adaptive::RadiusStore;
use crate::deformation::Deformation;
use crate::distance::DistanceStore;
use crate::polygons::{Fragment, Surface};
use crate::rays::RaySetup;
use crate::spec::{DistanceMemory, Leaping, MemoryModel, Shading, Shadow, Shape, Spec};
use crate::stages::classify::Tables;
use crate::stages::fetch::Voxels;
use crate::stages::material::Materials;
use crate::stages::shade::ReflectanceMap;
use crate::volume_store::VolumeStore;
use crate::voxel_layout::VoxelLayout;
use std::ops::Range;
use std::sync::Arc;
use strahl_volume::Mesh;

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
    /// How many columns light rays may leap; none without shadows or leaping.
    pub light_distance: Option<Arc<DistanceStore>>,
    /// How many steps may be interpolated; none without adaptive sampling.
    pub radius: Option<Arc<RadiusStore>>,
    /// Where voxels lie.
    pub layout: VoxelLayout,
    /// Where distances lie, and the bits of a cell's coordinates that share a word; none if they have no rows to open.
    pub distance_layout: Option<(VoxelLayout, u32)>,
    /// Polygons, as a fragment per pixel (rows from the bottom).
    pub fragments: Option<Arc<Vec<Option<Fragment>>>>,
    /// What those polygons are, for a picture in slabs.
    pub(crate) surface: Option<Arc<Surface>>,
    /// How rays are bent.
    pub deformation: Option<Arc<Deformation>>,
    /// Bytes that the host reads per ray.
    pub(crate) result_bytes: u32,
}

impl Frame {
    /// Settles a frame that is one run: one volume on one board, in one slab.
    ///
    /// # Errors
    /// If the Spec contradicts itself, the volume or the view, or needs several runs or a mesh: those are for
    /// [`draw`](crate::draw).
    pub fn new(spec: &Spec, volume: &VolumeStore) -> Result<Frame, Error> {
        spec.check()?;
        let is_elsewhere = |field, value: String| {
            let problem = "it takes several runs or a mesh, which `draw` does";
            Err(Error::field(field, value, problem))
        };
        if spec.view.slabs > 1 {
            return is_elsewhere("view.slabs", spec.view.slabs.to_string());
        }
        if spec.merge.is_on() {
            return is_elsewhere("merge", format!("{:?}", spec.merge));
        }
        if let Shape::File { path } = &spec.polygons.shape {
            return is_elsewhere("polygons.shape.file.path", path.clone());
        }
        Frame::with_mesh(spec, volume, None)
    }

    /// As [`new`](Frame::new), with the mesh that `polygons.shape.file` names, and as what the first of several runs is made
    /// of.
    pub(crate) fn with_mesh(
        spec: &Spec,
        volume: &VolumeStore,
        mesh: Option<&Mesh>,
    ) -> Result<Frame, Error> {
        spec.check()?;
        let setup = RaySetup::new(spec, volume.dims)?;
        let mut frame = Frame::of_setup(spec, volume, setup)?;
        let surface = match (&spec.polygons.shape, mesh) {
            (Shape::File { .. }, Some(mesh)) => {
                Some(Surface::of_mesh(mesh, volume.voxel_from_world))
            }
            (Shape::File { path }, None) => {
                let problem = "this mesh is not loaded";
                return Err(Error::field("polygons.shape.file.path", path, problem));
            }
            (shape, _) => Surface::of_shape(shape),
        };
        frame.surface = surface.map(Arc::new);
        frame.rasterise(0..u32::MAX);
        frame.deformation = Deformation::of_bend(spec.bend, &frame.setup)?.map(Arc::new);
        Ok(frame)
    }

    /// Clocks of coding distances, once per classification: those of the engine, and of loading it and the caster again if
    /// both share one chip. 0 for software.
    pub fn coding_clocks(&self) -> u64 {
        let Some(engine) = self.spec.optimisation.distance_engine else {
            return 0;
        };
        let stores = [&self.distance, &self.light_distance];
        let coded: u64 = stores
            .into_iter()
            .flatten()
            .map(|store| store.coding_clocks)
            .sum();
        let loads = if coded > 0 { 2 } else { 0 };
        let load = f64::from(engine.load_ms) * 1000.0 * self.spec.clock_mhz;
        coded + loads * load.ceil() as u64
    }

    /// Polygons on the rays as they are set up, as far as they lie in some planes.
    pub(crate) fn rasterise(&mut self, planes: Range<u32>) {
        let fragments = self
            .surface
            .as_ref()
            .map(|surface| surface.fragments(&self.spec, &self.setup, planes));
        self.fragments = fragments.map(Arc::new);
    }

    /// With rays that were set up elsewhere.
    pub(crate) fn of_setup(
        spec: &Spec,
        volume: &VolumeStore,
        setup: RaySetup,
    ) -> Result<Frame, Error> {
        let layout = VoxelLayout::new(&spec.memory, volume.dims)?;
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
        let distances = |largest_step| {
            DistanceStore::new(
                &spec.optimisation,
                &voxels,
                &tables,
                widths.distance,
                nominal,
                largest_step,
            )
        };
        let distance = distances(setup.largest_step);
        let distance_layout = match (&distance, spec.memory.distance_store) {
            (Some(store), DistanceMemory::Sdram) => {
                let (dims, shift) = store.words();
                let memory = crate::spec::Memory {
                    model: MemoryModel::M1Interleaved,
                    ..spec.memory
                };
                Some((VoxelLayout::new(&memory, dims)?, shift))
            }
            _ => None,
        };
        let light_distance = match spec.shadow {
            Shadow::None => None,
            _ => distances(setup.largest_light_step()),
        };
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
            light_distance: light_distance.map(Arc::new),
            radius: radius.map(Arc::new),
            layout,
            distance_layout,
            fragments: None,
            surface: None,
            deformation: None,
            result_bytes: widths.intensity.div_ceil(8),
        })
    }

    /// What a host has written.
    pub(crate) fn of_parts(
        spec: Spec,
        setup: RaySetup,
        voxels: Voxels,
        tables: Tables,
        map: ReflectanceMap,
        distance: DistanceStore,
        layout: VoxelLayout,
    ) -> Frame {
        Frame {
            result_bytes: spec.widths.intensity.div_ceil(8),
            distance: (spec.optimisation.leaping != Leaping::Off).then(|| Arc::new(distance)),
            spec,
            setup,
            voxels: Arc::new(voxels),
            tables: Arc::new(tables),
            map: Some(map),
            materials: None,
            light_distance: None,
            radius: None,
            layout,
            distance_layout: None,
            fragments: None,
            surface: None,
            deformation: None,
        }
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
    /// If there are not `planes` offsets for every pixel, or rays leap: distances do not apply to bent rays.
    pub fn with_deformation(mut self, deformation: Deformation) -> Result<Frame, Error> {
        if let Deformation::Table { planes, offsets } = &deformation {
            let needed = self.setup.pixel_count() * *planes as usize;
            if offsets.len() != needed {
                let problem = format!("there must be {planes} for each pixel, {needed}");
                return Err(Error::field("deformation offsets", offsets.len(), problem));
            }
        }
        if self.spec.shadow != Shadow::None {
            let problem = "light does not follow bent rays: set it to none";
            return Err(Error::field("shadow", "on", problem));
        }
        if self.distance.is_some() {
            let problem = "distances do not apply to bent rays: set it to off";
            return Err(Error::field("optimisation.leaping", "on", problem));
        }
        self.deformation = Some(Arc::new(deformation));
        Ok(self)
    }
}
