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

mod data;
mod device;
mod error;
mod geometry;
mod pipelines;
mod target;
mod volume_texture;

pub use device::{Adapter, Device, adapters};
pub use error::Error;

use data::Data;
use geometry::Geometry;
use pipelines::{Output, Pipelines, Ready};
use std::ops::ControlFlow;
use std::sync::Arc;
use std::time::Instant;
use strahl_program::{
    Frame, Functions, Object, Slices, Slicing, Table2d, noise_tile, stacked, tables, visible_bricks,
};
use strahl_scene::Image;
use strahl_scene::plan::Plan;
use strahl_shader::{Linker, NOWHERE_MM, Program, RayLoop, TABLE_ROW, bindings, ray_loop};
use strahl_volume::Datasets;
use target::{PART, Target};
use wgpu::BindingResource::{Sampler, TextureView};

/// A function that does nothing with the progress and never ends the picture.
pub fn no_progress(_drawn: usize, _total: usize) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// Draws Plans of the same data.
#[derive(Debug)]
pub struct Renderer<'d, 'v> {
    device: &'d Device,
    data: Data<'v>,
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
    /// Distance of the first hit or of opaque geometry from the start of each ray in mm, row by row,
    /// infinite without; `None` if the Plan does not ask.
    pub depth_mm: Option<Vec<f32>>,
    /// What it has cost.
    pub stats: Stats,
}

/// What a picture has cost.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stats {
    /// Copying the data to the device, once per [`Renderer`].
    pub upload_seconds: f64,
    /// Linking the program and making its pipeline; almost nothing for a combination of functions
    /// that was drawn before.
    pub link_seconds: f64,
    /// Tables, bricks and parameters.
    pub prepare_seconds: f64,
    /// Drawing and copying back.
    pub draw_seconds: f64,
}

/// What the ray loop reads of a Plan beside its parameters.
struct Prepared {
    frame: Frame,
    objects: Vec<Object>,
    frame_buffer: wgpu::Buffer,
    bindings: wgpu::BindGroup,
    geometry: Option<Geometry>,
}

/// What the rays of `plan` are drawn into.
fn into(plan: &Plan) -> Output {
    match plan.with_depth {
        true => Output::ColorAndDepth,
        false => Output::Color,
    }
}

impl<'d, 'v> Renderer<'d, 'v> {
    /// Copies `data`, one volume or more, to the device. A volume with an edge longer than the device's
    /// largest texture is cut into pages.
    ///
    /// # Errors
    /// The data does not fit, or the driver refuses.
    pub fn new(
        device: &'d Device,
        data: impl Into<Datasets<'v>>,
    ) -> Result<Renderer<'d, 'v>, Error> {
        let most = device.device.limits().max_texture_dimension_3d;
        Renderer::with_largest_texture(device, data, most)
    }

    /// The same on a device whose textures have at most this many voxels along an axis: for tests, and to
    /// leave room for others.
    ///
    /// # Errors
    /// As [`Renderer::new`].
    pub fn with_largest_texture(
        device: &'d Device,
        data: impl Into<Datasets<'v>>,
        most: u32,
    ) -> Result<Renderer<'d, 'v>, Error> {
        let start = Instant::now();
        Ok(Renderer {
            data: Data::new(device, data.into(), most)?,
            pipelines: Pipelines::default(),
            target: Target::new(device),
            linker: Linker::new(),
            device,
            upload_seconds: start.elapsed().as_secs_f64(),
        })
    }

    /// The functions of `plan` as this device runs them.
    ///
    /// # Errors
    /// As [`Renderer::program`].
    pub fn functions(&self, plan: &Plan) -> Result<Functions, Error> {
        let threshold = |mask: usize, threshold| self.data.masks[mask].threshold(threshold);
        Ok(Functions::of(plan, self.data.is_filtered(plan), threshold)?)
    }

    /// The ray loop over the data of `plan` as this device holds it.
    ///
    /// # Errors
    /// The Plan belongs to other data.
    pub fn loop_of(&mut self, plan: &Plan) -> Result<RayLoop, Error> {
        self.data.check(plan)?;
        self.data.make_coefficients(self.device, plan)?;
        Ok(RayLoop {
            volumes: self.data.texels(plan),
            objects: plan.layers.len(),
            is_before_geometry: !plan.meshes.is_empty(),
            is_finite: self.data.are_finite() && plan.modules.is_empty(),
        })
    }

    fn link(&mut self, plan: &Plan, functions: &Functions) -> Result<Arc<Program>, Error> {
        let skeleton = ray_loop(&self.loop_of(plan)?)?;
        Ok(self.linker.link(&skeleton, &functions.selection)?)
    }

    /// The program that would draw `plan`.
    ///
    /// # Errors
    /// The Plan belongs to other data, or its functions cannot be linked.
    pub fn program(&mut self, plan: &Plan) -> Result<Arc<Program>, Error> {
        self.data.check(plan)?;
        self.data.make_coefficients(self.device, plan)?;
        let functions = self.functions(plan)?;
        self.link(plan, &functions)
    }

    /// Whether [`Renderer::render`] can begin at once. If not, the pipeline is being made in the background
    /// from now on: a viewer goes on with the last Plan that is ready, and asks again.
    ///
    /// # Errors
    /// As [`Renderer::program`]; the driver refuses the program.
    pub fn is_ready(&mut self, plan: &Plan) -> Result<bool, Error> {
        let program = self.program(plan)?;
        let texels = self.data.texels(plan);
        self.pipelines
            .is_ready(self.device, &program, &texels, into(plan))
    }

    /// Draws `plan`. `progress` is told the rows drawn and all rows, and may end the picture.
    ///
    /// # Errors
    /// The Plan belongs to other data, the device is lost or refuses, or `progress` says stop.
    pub fn render(
        &mut self,
        plan: &Plan,
        progress: impl Fn(usize, usize) -> ControlFlow<()>,
    ) -> Result<Rendered, Error> {
        let start = Instant::now();
        let program = self.program(plan)?;
        let parameters = self.functions(plan)?.parameters(&program)?;
        let mut rendered = self.render_by(plan, &program, &parameters, &[], progress)?;
        let all = start.elapsed().as_secs_f64();
        let stats = &mut rendered.stats;
        stats.link_seconds = all - stats.prepare_seconds - stats.draw_seconds;
        Ok(rendered)
    }

    /// Draws `plan` by a program of the caller's, which reads what [`strahl_shader::bindings`] lists.
    /// `parameters` is its uniform block, `textures` what is bound from
    /// [`FIRST_TEXTURE`](strahl_shader::bindings::FIRST_TEXTURE) on.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub fn render_by(
        &mut self,
        plan: &Plan,
        program: &Arc<Program>,
        parameters: &[u8],
        textures: &[Table2d],
        progress: impl Fn(usize, usize) -> ControlFlow<()>,
    ) -> Result<Rendered, Error> {
        let start = Instant::now();
        self.data.check(plan)?;
        self.data.make_coefficients(self.device, plan)?;
        let texels = self.data.texels(plan);
        let ready = self
            .pipelines
            .of(self.device, program, &texels, into(plan))?;
        let linked = Instant::now();
        let mut prepared = self.prepare(plan, program, &ready, parameters, textures);
        if plan.with_depth {
            self.target.with_depth(self.device);
        }
        self.device.check()?;
        let prepared_at = Instant::now();

        let (width, height) = (plan.width as usize, plan.height as usize);
        let mut pixels = vec![[0.0; 4]; width * height];
        let frames = plan.lattice.frames;
        let mut sums = vec![[0.0f64; 4]; if frames == 1 { 0 } else { width * height }];
        let mut depth_mm = plan.with_depth.then(|| vec![f32::INFINITY; width * height]);
        let mut drawn = 0;
        for number in 0..frames {
            prepared.frame.number = number;
            for y in (0..plan.height).step_by(PART as usize) {
                for x in (0..plan.width).step_by(PART as usize) {
                    let size = [PART.min(plan.width - x), PART.min(plan.height - y)];
                    self.draw_part(&mut prepared, &ready, [x, y], size, plan.with_depth)?;
                    let color = self.target.color.read(self.device, size[1])?;
                    for row in 0..size[1] {
                        let start = (y + row) as usize * width + x as usize;
                        let place = start..start + size[0] as usize;
                        let part = bytemuck::cast_slice(color.row(row, size[0]));
                        if frames == 1 {
                            pixels[place].copy_from_slice(part);
                            continue;
                        }
                        for (sum, pixel) in sums[place].iter_mut().zip::<&[[f32; 4]]>(part) {
                            for (sum, c) in sum.iter_mut().zip(pixel) {
                                *sum += f64::from(*c);
                            }
                        }
                    }
                    if number == 0
                        && let Some(depth_mm) = &mut depth_mm
                    {
                        self.read_depth(&prepared, [x, y], size, width, depth_mm)?;
                    }
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
            depth_mm,
            stats: Stats {
                upload_seconds: self.upload_seconds,
                link_seconds: (linked - start).as_secs_f64(),
                prepare_seconds: (prepared_at - linked).as_secs_f64(),
                draw_seconds: prepared_at.elapsed().as_secs_f64(),
            },
        })
    }

    /// Draws `plan` by slices that are blended as `slicing` says. `program` is that of a slice; else as
    /// [`Renderer::render_by`].
    ///
    /// # Errors
    /// As [`Renderer::render`]; the Plan asks for what slices cannot do, or the device does not blend 32-bit floats.
    pub fn render_slices_by(
        &mut self,
        plan: &Plan,
        program: &Arc<Program>,
        parameters: &[u8],
        textures: &[Table2d],
        slicing: &Slicing,
        progress: impl Fn(usize, usize) -> ControlFlow<()>,
    ) -> Result<Rendered, Error> {
        let start = Instant::now();
        let slices = Slices::of(plan, slicing.order)?;
        if !self.device.can_blend() {
            return Err(Error::NoBlending {
                adapter: self.device.adapter().to_string(),
            });
        }
        self.data.check(plan)?;
        self.data.make_coefficients(self.device, plan)?;
        let texels = self.data.texels(plan);
        let into = Output::Slices(slicing.blend);
        let ready = self.pipelines.of(self.device, program, &texels, into)?;
        let linked = Instant::now();
        let mut prepared = self.prepare(plan, program, &ready, parameters, textures);
        self.device.check()?;
        let prepared_at = Instant::now();

        let (width, height) = (plan.width as usize, plan.height as usize);
        let mut sums = vec![[0.0f64; 4]; width * height];
        let frames = plan.lattice.frames;
        let mut drawn = 0;
        for number in 0..frames {
            prepared.frame.number = number;
            for y in (0..plan.height).step_by(PART as usize) {
                for x in (0..plan.width).step_by(PART as usize) {
                    let size = [PART.min(plan.width - x), PART.min(plan.height - y)];
                    prepared.frame.origin = [x, y];
                    let (frame, queue) = (&mut prepared.frame, &self.device.queue);
                    self.target.draw_slices(
                        self.device,
                        &ready.pipeline,
                        &prepared.bindings,
                        size,
                        (slices.count, slicing.start),
                        |before| {
                            frame.first_slice = slices.first + slices.direction * before as i32;
                            let bytes = frame.bytes(&prepared.objects);
                            queue.write_buffer(&prepared.frame_buffer, 0, &bytes);
                        },
                    )?;
                    let color = self.target.color.read(self.device, size[1])?;
                    for row in 0..size[1] {
                        let first = (y + row) as usize * width + x as usize;
                        let place = first..first + size[0] as usize;
                        let part: &[[f32; 4]] = bytemuck::cast_slice(color.row(row, size[0]));
                        for (sum, pixel) in sums[place].iter_mut().zip(part) {
                            let passing = 1.0 - pixel[3];
                            for (c, sum) in sum.iter_mut().enumerate() {
                                *sum += f64::from(pixel[c] + passing * plan.background[c]);
                            }
                        }
                    }
                }
                drawn += PART.min(plan.height - y) as usize;
                if progress(drawn, frames as usize * height).is_break() {
                    return Err(Error::Cancelled);
                }
            }
        }
        let mean = |sum: [f64; 4]| sum.map(|c| (c / f64::from(frames)) as f32);
        let pixels = sums.into_iter().map(mean).collect();
        Ok(Rendered {
            image: Image::from_pixels(plan.width, plan.height, pixels)
                .into_linear(plan.compositing),
            depth_mm: None,
            stats: Stats {
                upload_seconds: self.upload_seconds,
                link_seconds: (linked - start).as_secs_f64(),
                prepare_seconds: (prepared_at - linked).as_secs_f64(),
                draw_seconds: prepared_at.elapsed().as_secs_f64(),
            },
        })
    }

    fn draw_part(
        &mut self,
        prepared: &mut Prepared,
        ready: &Ready,
        origin: [u32; 2],
        size: [u32; 2],
        with_depth: bool,
    ) -> Result<(), Error> {
        prepared.frame.origin = origin;
        let bytes = prepared.frame.bytes(&prepared.objects);
        self.device
            .queue
            .write_buffer(&prepared.frame_buffer, 0, &bytes);
        if let Some(geometry) = &mut prepared.geometry {
            geometry.draw(self.device, &self.data.meshes, origin);
        }
        self.target.draw(
            self.device,
            &ready.pipeline,
            &prepared.bindings,
            size,
            with_depth,
        )
    }

    /// The nearer of what the volumes' rays hit and the geometry.
    fn read_depth(
        &self,
        prepared: &Prepared,
        [x, y]: [u32; 2],
        size: [u32; 2],
        width: usize,
        depth_mm: &mut [f32],
    ) -> Result<(), Error> {
        let geometry = prepared.geometry.as_ref().map(|g| &g.distance);
        for plane in [self.target.depth.as_ref(), geometry].into_iter().flatten() {
            let rows = plane.read(self.device, size[1])?;
            for row in 0..size[1] {
                let start = (y + row) as usize * width + x as usize;
                let place = start..start + size[0] as usize;
                for (depth, found) in depth_mm[place].iter_mut().zip(rows.row(row, size[0])) {
                    if *found < NOWHERE_MM {
                        *depth = depth.min(*found);
                    }
                }
            }
        }
        Ok(())
    }

    fn prepare(
        &self,
        plan: &Plan,
        program: &Program,
        ready: &Ready,
        parameters: &[u8],
        textures: &[Table2d],
    ) -> Prepared {
        let frame = Frame {
            // Parts are drawn into a corner of the target.
            viewport: [PART; 2],
            ..Frame::of(plan)
        };
        let mut objects: Vec<_> = plan
            .drawn_fields()
            .enumerate()
            .map(|(layer, field)| {
                let (slope, intercept) = self.data.value_of_texel(plan, field);
                Object::of(plan, layer, slope, intercept)
            })
            .collect();
        let tables = self.tables(plan, &mut objects);
        let bricks = self.bricks(plan, &mut objects);
        let pages = self.pages(plan, &mut objects);
        let tile = self.noise_tile(plan);
        let geometry =
            (!plan.meshes.is_empty()).then(|| Geometry::new(self.device, &self.data.meshes, plan));
        let frame_buffer = self.uniform("frame", &frame.bytes(&objects));
        let parameter_buffer = self.uniform("parameters", parameters);
        let device = &self.device.device;
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("volume"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        // What a program does not read is not in its layout; what it declares without a use is bound to
        // the small texture of its kind.
        let nothing = self.texture(
            "nothing",
            wgpu::TextureDimension::D3,
            wgpu::TextureFormat::R32Float,
            [1; 3],
            &[0; 4],
        );
        let textures: Vec<_> = (textures.iter())
            .map(|texture| {
                self.texture(
                    "texture of a graph",
                    wgpu::TextureDimension::D2,
                    wgpu::TextureFormat::Rgba32Float,
                    [texture.width, texture.height, 1],
                    bytemuck::cast_slice(&texture.texels),
                )
            })
            .collect();
        let entries: Vec<_> = program
            .bindings()
            .into_iter()
            .map(|binding| {
                let resource = match binding {
                    bindings::FRAME => frame_buffer.as_entire_binding(),
                    bindings::PARAMETERS => parameter_buffer.as_entire_binding(),
                    bindings::VOLUME_SAMPLER => Sampler(&sampler),
                    bindings::TABLES => TextureView(&tables),
                    bindings::BRICKS => TextureView(&bricks),
                    bindings::NOISE_TILE => TextureView(&tile),
                    bindings::PAGES => TextureView(&pages),
                    bindings::OPAQUE_MM | bindings::OPAQUE_COLOR => match &geometry {
                        Some(geometry) if binding == bindings::OPAQUE_MM => {
                            TextureView(&geometry.distance.view)
                        }
                        Some(geometry) => TextureView(&geometry.color.view),
                        None => TextureView(&self.target.color.view),
                    },
                    _ if binding < bindings::FIRST_VOLUME => {
                        let mask = (binding - bindings::FIRST_MASK) as usize;
                        TextureView(self.data.masks.get(mask).map_or(&nothing, |m| m.view()))
                    }
                    _ if binding >= bindings::FIRST_TEXTURE => {
                        let texture = (binding - bindings::FIRST_TEXTURE) as usize;
                        TextureView(textures.get(texture).unwrap_or(&tables))
                    }
                    _ => {
                        let volume = (binding - bindings::FIRST_VOLUME) as usize;
                        TextureView(self.data.view(plan, volume))
                    }
                };
                wgpu::BindGroupEntry { binding, resource }
            })
            .collect();
        let bindings = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("ray loop"),
            layout: &ready.layout,
            entries: &entries,
        });
        Prepared {
            frame,
            objects,
            frame_buffer,
            bindings,
            geometry,
        }
    }

    fn uniform(&self, label: &str, bytes: &[u8]) -> wgpu::Buffer {
        let buffer = self.device.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: bytes.len().max(16) as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        self.device.queue.write_buffer(&buffer, 0, bytes);
        buffer
    }

    /// The transfer tables of all objects in rows of [`TABLE_ROW`] entries.
    fn tables(&self, plan: &Plan, objects: &mut [Object]) -> wgpu::TextureView {
        let entries = tables(plan, objects);
        self.texture(
            "transfer tables",
            wgpu::TextureDimension::D2,
            wgpu::TextureFormat::Rgba32Float,
            [TABLE_ROW, entries.len() as u32 / TABLE_ROW, 1],
            bytemuck::cast_slice(&entries),
        )
    }

    /// Which bricks can be seen, the objects behind one another along z.
    fn bricks(&self, plan: &Plan, objects: &mut [Object]) -> wgpu::TextureView {
        let (dims, bytes) = visible_bricks(plan, objects, |i| self.data.bricks(plan, i));
        self.texture(
            "bricks",
            wgpu::TextureDimension::D3,
            wgpu::TextureFormat::R8Uint,
            dims,
            &bytes,
        )
    }

    /// The page tables of all paged volumes.
    fn pages(&self, plan: &Plan, objects: &mut [Object]) -> wgpu::TextureView {
        let of_object: Vec<_> = plan
            .drawn_fields()
            .map(|field| match self.data.pages(plan, field.volume) {
                Some(pages) => {
                    let entries = pages.entries.chunks_exact(2);
                    (pages.dims, entries.map(|e| [e[0], e[1]]).collect())
                }
                None => ([1; 3], vec![[0u32; 2]]),
            })
            .collect();
        let (dims, entries, first) = stacked(&of_object);
        for (object, first) in objects.iter_mut().zip(first) {
            object.pages_first = [0, 0, first];
        }
        self.texture(
            "pages",
            wgpu::TextureDimension::D3,
            wgpu::TextureFormat::Rg32Uint,
            dims,
            bytemuck::cast_slice(&entries),
        )
    }

    fn noise_tile(&self, plan: &Plan) -> wgpu::TextureView {
        let (edge, values) = noise_tile(plan);
        self.texture(
            "noise tile",
            wgpu::TextureDimension::D2,
            wgpu::TextureFormat::R32Float,
            [edge, edge, 1],
            bytemuck::cast_slice(&values),
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
