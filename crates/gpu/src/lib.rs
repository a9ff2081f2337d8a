//! Draws a Plan on the graphics processor, through wgpu.
//!
//! The same ray loop as on the processor, linked from the same functions ([`strahl_shader`]), runs in
//! the fragment stage, in strips small enough that no driver loses patience. It needs no window.
//!
//! ```
//! use strahl_gpu::{Device, Renderer, no_progress};
//! use strahl_scene::{Scene, resolve};
//! use strahl_volume::Phantom;
//!
//! let device = match Device::open(None) {
//!     Ok(device) => device,
//!     Err(error) => return Ok(println!("skipped: {error}")),
//! };
//! let volume = Phantom::Tree.volume([32, 32, 32])?;
//! let scene = Scene::parse("scene", r#"{ "size": [64, 48] }"#)?;
//! let plan = resolve(&scene, &volume.header(), None)?;
//! let picture = Renderer::new(&device, &volume)?.render(&plan, no_progress)?;
//! assert_eq!((picture.image.width(), picture.image.height()), (64, 48));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![warn(missing_docs)]

mod device;
mod error;
mod frame;
mod functions;
mod occupancy;
mod pipelines;
mod target;
mod volume_texture;

pub use device::{Adapter, Device, adapters};
pub use error::Error;

use frame::Frame;
use functions::Functions;
use pipelines::Pipelines;
use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Instant;
use strahl_scene::Image;
use strahl_scene::plan::{
    ALL_OBJECTS, Classify, ClipShape, Composite, Fetch, GradientMethod, Jitter, ObjectSet, Plan,
    Reconstruct, SampleClip,
};
use strahl_shader::{Linker, PARAMETERS_BINDING, Program, TABLE_ROW, ray_loop};
use strahl_volume::{Volume, bricks::Bricks};
use target::{PART, Target};
use volume_texture::VolumeTexture;

/// A function that does nothing with the progress and never ends the picture.
pub fn no_progress(_drawn: usize, _total: usize) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// Draws Plans of one volume.
#[derive(Debug)]
pub struct Renderer<'d> {
    device: &'d Device,
    grid: strahl_volume::Grid,
    bricks: Bricks,
    volume: VolumeTexture,
    linker: Linker,
    pipelines: Pipelines,
    target: Target,
    upload_seconds: f64,
}

/// A picture and what it has cost.
#[derive(Clone, Debug)]
pub struct Rendered {
    /// The picture.
    pub image: Image,
    /// What it has cost.
    pub stats: Stats,
}

/// What a picture has cost.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stats {
    /// Copying the volume to the device, once per [`Renderer`].
    pub upload_seconds: f64,
    /// Linking the program and making its pipeline; almost nothing for a combination of functions
    /// that was drawn before.
    pub link_seconds: f64,
    /// Table, bricks and parameters.
    pub prepare_seconds: f64,
    /// Drawing and copying back.
    pub draw_seconds: f64,
}

/// Refuses what this renderer cannot draw yet.
fn check_means(plan: &Plan) -> Result<(), Error> {
    let of_some = |objects: ObjectSet| objects != ALL_OBJECTS;
    let is_mask = |clip: &SampleClip| matches!(clip.shape, ClipShape::Mask { .. });
    let means = [
        (plan.objects.len() > 1, "several volumes"),
        (!plan.meshes.is_empty(), "meshes"),
        (plan.fetch != Fetch::Stored, "procedural volumes"),
        (
            plan.reconstruct == Reconstruct::BSplineInterpolating,
            "interpolating B-splines",
        ),
        (
            plan.classify == Classify::PreClassified,
            "pre-classified volumes",
        ),
        (
            plan.gradient.method == GradientMethod::BSpline,
            "B-spline gradients",
        ),
        (plan.composite == Composite::BackToFront, "back to front"),
        (matches!(plan.composite, Composite::Debug(_)), "debug views"),
        (
            !matches!(plan.lattice.jitter, Jitter::Centre | Jitter::Hash(_)),
            "jitter by tiles and sine hashes",
        ),
        (plan.sample_clips.iter().any(is_mask), "clips by masks"),
        (
            plan.sample_clips.iter().any(|clip| of_some(clip.objects))
                || plan.ray_clips.iter().any(|clip| of_some(clip.objects)),
            "clips of single objects",
        ),
        (plan.with_depth, "a depth channel"),
    ];
    match means.into_iter().find(|(wanted, _)| *wanted) {
        Some((_, what)) => Err(Error::NotYet(what)),
        None => Ok(()),
    }
}

impl<'d> Renderer<'d> {
    /// Copies `volume` to the device.
    ///
    /// # Errors
    /// The volume does not fit, or the driver refuses.
    pub fn new(device: &'d Device, volume: &Volume) -> Result<Renderer<'d>, Error> {
        let start = Instant::now();
        let texture = VolumeTexture::new(device, volume)?;
        Ok(Renderer {
            pipelines: Pipelines::new(device, &texture.storage),
            target: Target::new(device),
            grid: *volume.grid(),
            bricks: Bricks::new(volume),
            volume: texture,
            linker: Linker::new(),
            device,
            upload_seconds: start.elapsed().as_secs_f64(),
        })
    }

    /// The program that would draw `plan`.
    ///
    /// # Errors
    /// The functions cannot be linked.
    pub fn program(&mut self, plan: &Plan) -> Result<Arc<Program>, Error> {
        let storage = self.volume.storage;
        let functions = Functions::of(plan, &storage)?;
        Ok(self
            .linker
            .link(&ray_loop(storage.texels), &functions.selection)?)
    }

    /// Draws `plan`. `progress` is told the rows drawn and all rows, and may end the picture.
    ///
    /// # Errors
    /// The Plan belongs to another grid, the device is lost or refuses, or `progress` says stop.
    pub fn render(
        &mut self,
        plan: &Plan,
        progress: impl Fn(usize, usize) -> ControlFlow<()>,
    ) -> Result<Rendered, Error> {
        let object = &plan.objects[0];
        if object.grid.dims() != self.grid.dims() || !(object.is_moved || object.grid == self.grid)
        {
            return Err(Error::OtherGrid {
                plan: object.grid.dims(),
                volume: self.grid.dims(),
            });
        }
        check_means(plan)?;
        let start = Instant::now();
        let storage = self.volume.storage;
        let functions = Functions::of(plan, &storage)?;
        let skeleton = ray_loop(storage.texels);
        let program = self.linker.link(&skeleton, &functions.selection)?;
        self.pipelines.of(self.device, &program)?;
        let linked = Instant::now();

        let mut frame = Frame::of(plan, &storage);
        let frame_buffer = self.uniform("frame", size_of::<Frame>());
        let parameters = functions.parameters(&program)?;
        let parameter_buffer = self.uniform("parameters", parameters.len().max(16));
        self.device
            .queue
            .write_buffer(&parameter_buffer, 0, &parameters);
        let bindings = self.bindings(plan, &frame_buffer, &parameter_buffer);
        self.device.check()?;
        let prepared = Instant::now();

        let (width, height) = (plan.width as usize, plan.height as usize);
        let mut pixels = vec![[0.0; 4]; width * height];
        let frames = plan.lattice.frames;
        let mut sums = vec![[0.0f64; 4]; if frames == 1 { 0 } else { width * height }];
        let pipeline = self.pipelines.of(self.device, &program)?;
        let mut drawn = 0;
        for number in 0..frames {
            frame.number = number;
            for y in (0..plan.height).step_by(PART as usize) {
                for x in (0..plan.width).step_by(PART as usize) {
                    frame.origin = [x, y];
                    self.device
                        .queue
                        .write_buffer(&frame_buffer, 0, bytemuck::bytes_of(&frame));
                    let size = [PART.min(plan.width - x), PART.min(plan.height - y)];
                    let (pixels, sums) = (&mut pixels, &mut sums);
                    self.target
                        .draw(self.device, pipeline, &bindings, size, |row, part| {
                            let start = (y + row) as usize * width + x as usize;
                            let place = start..start + part.len();
                            if frames == 1 {
                                pixels[place].copy_from_slice(part);
                                return;
                            }
                            for (sum, pixel) in sums[place].iter_mut().zip(part) {
                                for (sum, c) in sum.iter_mut().zip(pixel) {
                                    *sum += f64::from(*c);
                                }
                            }
                        })?;
                }
                drawn += PART.min(plan.height - y) as usize;
                if progress(drawn, frames as usize * height).is_break() {
                    return Err(Error::Cancelled);
                }
            }
        }
        for (pixel, sum) in pixels.iter_mut().zip(&sums) {
            *pixel = sum.map(|c| (c / f64::from(frames)) as f32);
        }
        Ok(Rendered {
            image: Image::from_pixels(plan.width, plan.height, pixels)
                .into_linear(plan.compositing),
            stats: Stats {
                upload_seconds: self.upload_seconds,
                link_seconds: (linked - start).as_secs_f64(),
                prepare_seconds: (prepared - linked).as_secs_f64(),
                draw_seconds: prepared.elapsed().as_secs_f64(),
            },
        })
    }

    fn uniform(&self, label: &str, bytes: usize) -> wgpu::Buffer {
        self.device.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: bytes as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        })
    }

    fn bindings(
        &self,
        plan: &Plan,
        frame: &wgpu::Buffer,
        parameters: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        let device = &self.device.device;
        let filter = if self.volume.storage.is_filterable {
            wgpu::FilterMode::Linear
        } else {
            wgpu::FilterMode::Nearest
        };
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("volume"),
            mag_filter: filter,
            min_filter: filter,
            ..Default::default()
        });
        let table = self.table(plan);
        let bricks = self.occupancy(plan);
        let entries = [
            (0, frame.as_entire_binding()),
            (PARAMETERS_BINDING, parameters.as_entire_binding()),
            (2, wgpu::BindingResource::TextureView(&self.volume.view)),
            (3, wgpu::BindingResource::Sampler(&sampler)),
            (4, wgpu::BindingResource::TextureView(&table)),
            (5, wgpu::BindingResource::TextureView(&bricks)),
        ]
        .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource });
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("ray loop"),
            layout: &self.pipelines.bindings,
            entries: &entries,
        })
    }

    /// The transfer table in rows of [`TABLE_ROW`] entries.
    fn table(&self, plan: &Plan) -> wgpu::TextureView {
        let mut entries = plan.objects[0].table.entries().to_vec();
        let width = (entries.len() as u32).min(TABLE_ROW);
        let height = (entries.len() as u32).div_ceil(TABLE_ROW);
        entries.resize((width * height) as usize, [0.0; 4]);
        self.texture(
            "transfer table",
            wgpu::TextureDimension::D2,
            wgpu::TextureFormat::Rgba32Float,
            [width, height, 1],
            bytemuck::cast_slice(&entries),
        )
    }

    fn occupancy(&self, plan: &Plan) -> wgpu::TextureView {
        self.texture(
            "bricks",
            wgpu::TextureDimension::D3,
            wgpu::TextureFormat::R8Uint,
            self.bricks.dims().map(|n| n as u32),
            &occupancy::occupancy(&self.bricks, plan, 0),
        )
    }

    fn texture(
        &self,
        label: &str,
        dimension: wgpu::TextureDimension,
        format: wgpu::TextureFormat,
        [width, height, depth]: [u32; 3],
        bytes: &[u8],
    ) -> wgpu::TextureView {
        let size = wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: depth,
        };
        let texture = self.device.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size,
            mip_level_count: 1,
            sample_count: 1,
            dimension,
            format,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let texel_bytes = format.block_copy_size(None).unwrap_or(1);
        self.device.queue.write_texture(
            texture.as_image_copy(),
            bytes,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(width * texel_bytes),
                rows_per_image: Some(height),
            },
            size,
        );
        texture.create_view(&wgpu::TextureViewDescriptor::default())
    }
}
