//! Draws Plans on the GPU, through wgpu.
//!
//! The ray loop is linked from shader functions ([`strahl_shader`]) and runs in the fragment stage. It
//! draws in strips, so that no submission exceeds the time limit of a driver. It needs no window.
//!
//! ```
//! use strahl_gpu::{Device, Renderer};
//! use strahl_scene::{Scene, resolve};
//! use strahl_volume::{Control, Phantom};
//!
//! let device = match Device::open(None) {
//!     Ok(device) => device,
//!     Err(error) => return Ok(println!("skipped: {error}")),
//! };
//! let volume = Phantom::Tree.volume([32, 32, 32])?;
//! let scene = Scene::parse("scene", r#"{ "size": [64, 48] }"#)?;
//! let plan = resolve(&scene, &volume.header(), None)?;
//! let picture = Renderer::new(&device, &volume).render(&plan, &Control::NONE)?;
//! assert_eq!((picture.image.width(), picture.image.height()), (64, 48));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![warn(missing_docs)]

mod data;
mod device;
mod error;
mod geometry;
mod label_texture;
mod pipelines;
mod shown;
mod signal;
mod target;
mod volume_texture;

pub use device::{Adapter, Device, adapters};
pub use error::Error;
pub use shown::TextureTarget;
pub use strahl_scene::{Rendered, Stats};

/// What devices and textures of others are made with.
pub use wgpu;

use data::{Data, DeviceData};
use geometry::Geometry;
use pipelines::{COLOR, Output, Pipelines, Ready};
use shown::{Show, Shower};
use std::sync::Arc;
use std::time::Instant;
use strahl_program::{
    Frame, Functions, ImportanceBlock, Object, SegmentTable, Slices, Slicing, Table2d,
    has_important_places, noise_tile, stacked, tables, techniques_of, visible_bricks,
};
use strahl_scene::Image;
use strahl_scene::plan::{Compositing, Plan};
use strahl_shader::{Linker, NOWHERE_MM, Program, RayLoop, TABLE_ROW, bindings, ray_loop};
use strahl_volume::{Cancelled, Control, Datasets, Store, Work};
use target::{PART, Target};
use wgpu::BindingResource::{Sampler, TextureView};

/// Draws Plans of the same data. What it copies to the device stays in the [`Device::store`], for the next picture.
#[derive(Debug)]
pub struct Renderer {
    device: Device,
    data: Data,
    linker: Linker,
    pipelines: Pipelines,
    target: Target,
    /// Made when a picture first goes into a texture.
    shower: Option<Shower>,
}

/// What the ray loop reads of a Plan beside its parameters.
struct Prepared {
    frame: Frame,
    objects: Vec<Object>,
    frame_buffer: wgpu::Buffer,
    bindings: wgpu::BindGroup,
    geometry: Option<Geometry>,
    data: DeviceData,
    with_depth: bool,
}

/// What the rays of `plan` are drawn into.
fn into(plan: &Plan) -> Output {
    match plan.with_depth {
        true => Output::ColorAndDepth,
        false => Output::Color,
    }
}

impl Renderer {
    /// Draws from `data`, one volume or more. Nothing is copied to the device before the first picture. A volume with
    /// an edge longer than the device's largest texture is cut into pages.
    pub fn new(device: &Device, data: impl Into<Datasets>) -> Renderer {
        Renderer::with_store(device, data, Arc::default())
    }

    /// The same with what others make of the data, and share.
    pub fn with_store(device: &Device, data: impl Into<Datasets>, store: Arc<Store>) -> Renderer {
        let most = device.device.limits().max_texture_dimension_3d;
        Renderer {
            data: Data::new(data.into(), store, most),
            pipelines: Pipelines::default(),
            target: Target::new(device),
            linker: Linker::new(),
            shower: None,
            device: device.clone(),
        }
    }

    /// The same on a device whose textures have at most this many voxels along an axis: for tests, and to
    /// leave room for others.
    pub fn with_largest_texture(device: &Device, data: impl Into<Datasets>, most: u32) -> Renderer {
        Renderer {
            data: Data::new(data.into(), Arc::default(), most),
            ..Renderer::new(device, Datasets::default())
        }
    }

    /// Draws from other data from now on; programs stay linked.
    pub fn set_data(&mut self, data: impl Into<Datasets>) {
        self.data = self.data.of(data.into());
    }

    /// The device that draws.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// The functions of `plan` as this device runs them.
    ///
    /// # Errors
    /// As [`Renderer::program`].
    pub fn functions(&self, plan: &Plan) -> Result<Functions, Error> {
        self.data.check(plan)?;
        let device = &self.device;
        let threshold = |mask, threshold| self.data.mask_threshold(device, mask, threshold);
        let is_filtered = self.data.is_filtered(device, plan);
        Ok(Functions::of(plan, is_filtered, threshold)?)
    }

    /// The ray loop over the data of `plan` as this device holds it.
    ///
    /// # Errors
    /// The Plan belongs to other data.
    pub fn loop_of(&self, plan: &Plan) -> Result<RayLoop, Error> {
        self.data.check(plan)?;
        Ok(RayLoop {
            volumes: self.data.texels(&self.device, plan),
            objects: plan.layers.len(),
            is_before_geometry: !plan.meshes.is_empty(),
            techniques: techniques_of(plan),
            is_finite: self.data.are_finite() && plan.modules.is_empty(),
            has_important_places: has_important_places(plan),
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
        let texels = self.data.texels(&self.device, plan);
        self.pipelines
            .is_ready(&self.device, &program, &texels, into(plan))
    }

    /// Draws `plan`, under `control`.
    ///
    /// # Errors
    /// The Plan belongs to other data, this does not fit the device, the device is lost or refuses, or `control` was
    /// cancelled.
    pub fn render(&mut self, plan: &Plan, control: &Control) -> Result<Rendered, Error> {
        pollster::block_on(self.render_async(plan, control))
    }

    /// As [`Renderer::render`], where nothing may block: in a web page.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub async fn render_async(
        &mut self,
        plan: &Plan,
        control: &Control,
    ) -> Result<Rendered, Error> {
        let start = Instant::now();
        let program = self.program(plan)?;
        let parameters = self.functions(plan)?.parameters(&program)?;
        let drawing = self.render_by_async(plan, &program, &parameters, &[], control);
        let mut rendered = drawing.await?;
        let all = start.elapsed().as_secs_f64();
        let stats = &mut rendered.stats;
        let others = stats.upload_seconds + stats.prepare_seconds + stats.draw_seconds;
        stats.link_seconds = all - others;
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
        control: &Control,
    ) -> Result<Rendered, Error> {
        let drawing = self.render_by_async(plan, program, parameters, textures, control);
        pollster::block_on(drawing)
    }

    /// As [`Renderer::render_by`], where nothing may block.
    ///
    /// # Errors
    /// As [`Renderer::render`].
    pub async fn render_by_async(
        &mut self,
        plan: &Plan,
        program: &Arc<Program>,
        parameters: &[u8],
        textures: &[Table2d],
        control: &Control,
    ) -> Result<Rendered, Error> {
        let start = Instant::now();
        self.data.check(plan)?;
        let data = self.data.on_device(&self.device, plan, control).await?;
        let uploaded = Instant::now();
        let texels = self.data.texels(&self.device, plan);
        let ready = self
            .pipelines
            .of(&self.device, program, &texels, into(plan))?;
        let linked = Instant::now();
        let read = (parameters, textures, data);
        let mut prepared = self.prepare(plan, program, &ready, read, control)?;
        if plan.with_depth {
            self.target.with_depth(&self.device);
        }
        self.device.check()?;
        let prepared_at = Instant::now();

        let (width, height) = (plan.width as usize, plan.height as usize);
        let mut pixels = vec![[0.0; 4]; width * height];
        let frames = plan.lattice.frames;
        let mut sums = vec![[0.0f64; 4]; if frames == 1 { 0 } else { width * height }];
        let mut depth_mm = plan.with_depth.then(|| vec![f32::INFINITY; width * height]);
        let rows_drawn = control.parts(Work::Drawing, frames as usize * height);
        for number in 0..frames {
            prepared.frame.number = number;
            for y in (0..plan.height).step_by(PART as usize) {
                for x in (0..plan.width).step_by(PART as usize) {
                    let size = [PART.min(plan.width - x), PART.min(plan.height - y)];
                    self.draw_part(&mut prepared, &ready, [x, y], size, control)
                        .await?;
                    let color = self.target.color.read(&self.device, size[1]).await?;
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
                        self.read_depth(&prepared, [x, y], size, width, depth_mm)
                            .await?;
                    }
                }
                rows_drawn.done(PART.min(plan.height - y) as usize)?;
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
                upload_seconds: (uploaded - start).as_secs_f64(),
                link_seconds: (linked - uploaded).as_secs_f64(),
                prepare_seconds: (prepared_at - linked).as_secs_f64(),
                draw_seconds: prepared_at.elapsed().as_secs_f64(),
                ..Stats::default()
            },
        })
    }

    /// Draws `plan` into a texture of the caller's, on this renderer's device, under `control`. The picture does not
    /// come to memory; distances are not drawn.
    ///
    /// # Errors
    /// As [`Renderer::render`]; the texture is smaller than the picture or cannot be drawn into.
    pub fn render_into(
        &mut self,
        plan: &Plan,
        target: &TextureTarget,
        control: &Control,
    ) -> Result<Stats, Error> {
        pollster::block_on(self.render_into_async(plan, target, control))
    }

    /// As [`Renderer::render_into`], where nothing may block: in a web page.
    ///
    /// # Errors
    /// As [`Renderer::render_into`].
    pub async fn render_into_async(
        &mut self,
        plan: &Plan,
        target: &TextureTarget<'_>,
        control: &Control,
    ) -> Result<Stats, Error> {
        let start = Instant::now();
        let program = self.program(plan)?;
        let parameters = self.functions(plan)?.parameters(&program)?;
        let data = self.data.on_device(&self.device, plan, control).await?;
        let uploaded = Instant::now();
        let texels = self.data.texels(&self.device, plan);
        let ready = self
            .pipelines
            .of(&self.device, &program, &texels, Output::Color)?;
        let linked = Instant::now();
        let read = (&parameters[..], &[][..], data);
        let mut prepared = self.prepare(plan, &program, &ready, read, control)?;
        prepared.with_depth = false;
        self.device.check()?;
        let prepared_at = Instant::now();
        let mut shower = match self.shower.take() {
            Some(shower) => shower,
            None => Shower::new(&self.device),
        };
        let parts = plan.height.div_ceil(PART) * plan.width.div_ceil(PART);
        let parts = control.parts(Work::Drawing, parts as usize);
        for y in (0..plan.height).step_by(PART as usize) {
            for x in (0..plan.width).step_by(PART as usize) {
                let place = [x, y];
                self.draw_shown_part(
                    plan,
                    &mut prepared,
                    &ready,
                    place,
                    target,
                    &mut shower,
                    control,
                )
                .await?;
                parts.done(1)?;
            }
        }
        self.device.done().await?;
        self.shower = Some(shower);
        Ok(Stats {
            upload_seconds: (uploaded - start).as_secs_f64(),
            link_seconds: (linked - uploaded).as_secs_f64(),
            prepare_seconds: (prepared_at - linked).as_secs_f64(),
            draw_seconds: prepared_at.elapsed().as_secs_f64(),
            ..Stats::default()
        })
    }

    /// Draws all frames of a part, and their mean into `target`.
    #[expect(
        clippy::too_many_arguments,
        reason = "what a part is drawn with, and into"
    )]
    async fn draw_shown_part(
        &mut self,
        plan: &Plan,
        prepared: &mut Prepared,
        ready: &Ready,
        [x, y]: [u32; 2],
        target: &TextureTarget<'_>,
        shower: &mut Shower,
        control: &Control,
    ) -> Result<(), Error> {
        let size = [PART.min(plan.width - x), PART.min(plan.height - y)];
        let frames = plan.lattice.frames;
        let sums = [0, 1].map(|i: usize| shower.sums[i].view.clone());
        let nothing = shower.nothing.clone();
        for number in 0..frames {
            prepared.frame.number = number;
            self.draw_part(prepared, ready, [x, y], size, control)
                .await?;
            let before = match number {
                0 => &nothing,
                number => &sums[number as usize % 2],
            };
            let read = [&self.target.color.view, before];
            if number + 1 < frames {
                let sum = TextureTarget {
                    view: &sums[(number as usize + 1) % 2],
                    format: COLOR,
                };
                let how = Show {
                    origin: [0.0; 2],
                    weight: 1.0,
                    is_encoded: 0,
                };
                shower.show(&self.device, read, how, size, &sum);
                continue;
            }
            let how = Show {
                origin: [x as f32, y as f32],
                weight: 1.0 / frames as f32,
                is_encoded: u32::from(plan.compositing == Compositing::Display),
            };
            shower.show(&self.device, read, how, size, target);
        }
        self.device.check()
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
        control: &Control,
    ) -> Result<Rendered, Error> {
        let of = (program, parameters, textures);
        pollster::block_on(self.render_slices_by_async(plan, of, slicing, control))
    }

    /// As [`Renderer::render_slices_by`], where nothing may block.
    ///
    /// # Errors
    /// As [`Renderer::render_slices_by`].
    pub async fn render_slices_by_async(
        &mut self,
        plan: &Plan,
        (program, parameters, textures): (&Arc<Program>, &[u8], &[Table2d]),
        slicing: &Slicing,
        control: &Control,
    ) -> Result<Rendered, Error> {
        let start = Instant::now();
        let slices = Slices::of(plan, slicing.order)?;
        if !self.device.can_blend() {
            return Err(Error::NoBlending {
                adapter: self.device.adapter().to_string(),
            });
        }
        self.data.check(plan)?;
        let data = self.data.on_device(&self.device, plan, control).await?;
        let uploaded = Instant::now();
        let texels = self.data.texels(&self.device, plan);
        let into = Output::Slices(slicing.blend);
        let ready = self.pipelines.of(&self.device, program, &texels, into)?;
        let linked = Instant::now();
        let read = (parameters, textures, data);
        let mut prepared = self.prepare(plan, program, &ready, read, control)?;
        self.device.check()?;
        let prepared_at = Instant::now();

        let (width, height) = (plan.width as usize, plan.height as usize);
        let mut sums = vec![[0.0f64; 4]; width * height];
        let frames = plan.lattice.frames;
        let rows_drawn = control.parts(Work::Drawing, frames as usize * height);
        for number in 0..frames {
            prepared.frame.number = number;
            for y in (0..plan.height).step_by(PART as usize) {
                for x in (0..plan.width).step_by(PART as usize) {
                    let size = [PART.min(plan.width - x), PART.min(plan.height - y)];
                    prepared.frame.origin = [x, y];
                    let (frame, queue) = (&mut prepared.frame, &self.device.queue);
                    let at_slice = |before| {
                        frame.first_slice = slices.first + slices.direction * before as i32;
                        let bytes = frame.bytes(&prepared.objects);
                        queue.write_buffer(&prepared.frame_buffer, 0, &bytes);
                    };
                    let (pipeline, bindings) = (&ready.pipeline, &prepared.bindings);
                    let range = (slices.count, slicing.start);
                    self.target
                        .draw_slices(
                            &self.device,
                            pipeline,
                            bindings,
                            size,
                            range,
                            at_slice,
                            control,
                        )
                        .await?;
                    let color = self.target.color.read(&self.device, size[1]).await?;
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
                rows_drawn.done(PART.min(plan.height - y) as usize)?;
            }
        }
        let mean = |sum: [f64; 4]| sum.map(|c| (c / f64::from(frames)) as f32);
        let pixels = sums.into_iter().map(mean).collect();
        Ok(Rendered {
            image: Image::from_pixels(plan.width, plan.height, pixels)
                .into_linear(plan.compositing),
            depth_mm: None,
            stats: Stats {
                upload_seconds: (uploaded - start).as_secs_f64(),
                link_seconds: (linked - uploaded).as_secs_f64(),
                prepare_seconds: (prepared_at - linked).as_secs_f64(),
                draw_seconds: prepared_at.elapsed().as_secs_f64(),
                ..Stats::default()
            },
        })
    }

    async fn draw_part(
        &mut self,
        prepared: &mut Prepared,
        ready: &Ready,
        origin: [u32; 2],
        size: [u32; 2],
        control: &Control,
    ) -> Result<(), Error> {
        prepared.frame.origin = origin;
        let bytes = prepared.frame.bytes(&prepared.objects);
        let device = &self.device;
        device.queue.write_buffer(&prepared.frame_buffer, 0, &bytes);
        if let Some(geometry) = &mut prepared.geometry {
            geometry.draw(device, &prepared.data.meshes, origin);
        }
        let (pipeline, bindings) = (&ready.pipeline, &prepared.bindings);
        self.target
            .draw(
                device,
                pipeline,
                bindings,
                size,
                prepared.with_depth,
                control,
            )
            .await
    }

    /// The nearer of what the volumes' rays hit and the geometry.
    async fn read_depth(
        &self,
        prepared: &Prepared,
        [x, y]: [u32; 2],
        size: [u32; 2],
        width: usize,
        depth_mm: &mut [f32],
    ) -> Result<(), Error> {
        let geometry = prepared.geometry.as_ref().map(|g| &g.distance);
        for plane in [self.target.depth.as_ref(), geometry].into_iter().flatten() {
            let rows = plane.read(&self.device, size[1]).await?;
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
        (parameters, textures, data): (&[u8], &[Table2d], DeviceData),
        control: &Control,
    ) -> Result<Prepared, Error> {
        let frame = Frame {
            // Parts are drawn into a corner of the target.
            viewport: [PART; 2],
            ..Frame::of(plan)
        };
        let mut objects: Vec<_> = plan
            .drawn_fields()
            .enumerate()
            .map(|(layer, field)| {
                let (slope, intercept) = self.data.value_of_texel(&self.device, plan, field);
                Object::of(plan, layer, slope, intercept)
            })
            .collect();
        let labels = data.labels.as_deref();
        let segments = labels.and_then(|labels| SegmentTable::of(plan, &labels.ids));
        let tables = self.tables(plan, &mut objects, segments.as_ref())?;
        let entries = segments.as_ref().map_or(&[0; 1][..], |s| &s.entries);
        let segment_entries = self.texture(
            "segments",
            wgpu::TextureDimension::D2,
            wgpu::TextureFormat::R32Uint,
            [
                TABLE_ROW.min(entries.len() as u32),
                (entries.len() as u32).div_ceil(TABLE_ROW),
                1,
            ],
            bytemuck::cast_slice(entries),
        );
        let bricks = self.bricks(plan, &mut objects, &data, control)?;
        let pages = self.pages(plan, &mut objects, &data);
        let tile = self.noise_tile(plan, control)?;
        let geometry =
            (!plan.meshes.is_empty()).then(|| Geometry::new(&self.device, &data.meshes, plan));
        let frame_buffer = self.uniform("frame", &frame.bytes(&objects));
        let parameter_buffer = self.uniform("parameters", parameters);
        let number = |mask, value| self.data.mask_threshold(&self.device, mask, value);
        let importance = ImportanceBlock::of(plan, number);
        let importance = self.uniform("importance", bytemuck::bytes_of(&importance));
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
                    bindings::IMPORTANCE => importance.as_entire_binding(),
                    bindings::VOLUME_SAMPLER => Sampler(&sampler),
                    bindings::TABLES => TextureView(&tables),
                    bindings::BRICKS => TextureView(&bricks),
                    bindings::NOISE_TILE => TextureView(&tile),
                    bindings::PAGES => TextureView(&pages),
                    bindings::LABELS => TextureView(labels.map_or(&bricks, |l| &l.view)),
                    bindings::SEGMENTS => TextureView(&segment_entries),
                    bindings::OPAQUE_MM | bindings::OPAQUE_COLOR => match &geometry {
                        Some(geometry) if binding == bindings::OPAQUE_MM => {
                            TextureView(&geometry.distance.view)
                        }
                        Some(geometry) => TextureView(&geometry.color.view),
                        None => TextureView(&self.target.color.view),
                    },
                    _ if binding < bindings::FIRST_VOLUME => {
                        let mask = (binding - bindings::FIRST_MASK) as usize;
                        TextureView(data.mask(mask).unwrap_or(&nothing))
                    }
                    _ if binding >= bindings::FIRST_TEXTURE => {
                        let texture = (binding - bindings::FIRST_TEXTURE) as usize;
                        TextureView(textures.get(texture).unwrap_or(&tables))
                    }
                    _ => {
                        let volume = (binding - bindings::FIRST_VOLUME) as usize;
                        TextureView(data.view(volume))
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
        Ok(Prepared {
            frame,
            objects,
            frame_buffer,
            bindings,
            geometry,
            data,
            with_depth: plan.with_depth,
        })
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
    fn tables(
        &self,
        plan: &Plan,
        objects: &mut [Object],
        segments: Option<&SegmentTable>,
    ) -> Result<wgpu::TextureView, Error> {
        let entries = tables(plan, objects, segments)?;
        Ok(self.texture(
            "transfer tables",
            wgpu::TextureDimension::D2,
            wgpu::TextureFormat::Rgba32Float,
            [TABLE_ROW, entries.len() as u32 / TABLE_ROW, 1],
            bytemuck::cast_slice(&entries),
        ))
    }

    /// Which bricks can be seen, the objects behind one another along z.
    fn bricks(
        &self,
        plan: &Plan,
        objects: &mut [Object],
        data: &DeviceData,
        control: &Control,
    ) -> Result<wgpu::TextureView, Cancelled> {
        let of_object = |i: usize| data.bricks(plan.field_of(i).volume);
        let store = &self.data.store;
        let (dims, bytes) = visible_bricks(plan, objects, of_object, store, control)?;
        let view = self.texture(
            "bricks",
            wgpu::TextureDimension::D3,
            wgpu::TextureFormat::R8Uint,
            dims,
            &bytes,
        );
        Ok(view)
    }

    /// The page tables of all paged volumes.
    fn pages(&self, plan: &Plan, objects: &mut [Object], data: &DeviceData) -> wgpu::TextureView {
        let of_object: Vec<_> = plan
            .drawn_fields()
            .map(|field| match data.pages(field.volume) {
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

    fn noise_tile(&self, plan: &Plan, control: &Control) -> Result<wgpu::TextureView, Error> {
        let (edge, values) = noise_tile(plan, &self.data.store, control)?;
        Ok(self.texture(
            "noise tile",
            wgpu::TextureDimension::D2,
            wgpu::TextureFormat::R32Float,
            [edge, edge, 1],
            bytemuck::cast_slice(&values),
        ))
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
