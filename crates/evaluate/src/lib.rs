//! Runs linked programs on the CPU.
//!
//! A [`Program`] is WGSL, checked by naga. The evaluator compiles naga's expressions and statements to
//! operations on registers of [`LANES`] numbers, one per pixel of a block, with masks for control flow.
//! It draws every program, whether it comes from settings, from a user's module or from a graph. The
//! CPU uses it for functions without a twin, and the tests use it to check GPUs independently.
//! Interpolation is exact, and the bytes are the same at any number of threads.
//!
//! ```
//! use strahl_evaluate::Evaluator;
//! use strahl_scene::{Scene, resolve};
//! use strahl_volume::{Control, Phantom};
//!
//! let volume = Phantom::Tree.volume([32, 32, 32])?;
//! let scene = Scene::parse("scene", r#"{ "size": [64, 48] }"#)?;
//! let plan = resolve(&scene, &volume.header(), None)?;
//! let picture = Evaluator::new(&volume).render(&plan, &Control::NONE)?;
//! assert_eq!((picture.image.width(), picture.image.height()), (64, 48));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`Machine`] runs single functions and entry points, such as a vertex stage or a function under test.
//! Unsupported features (derivatives, textures with several levels or layers, storage buffers, numbers
//! with other than 32 bits) are refused by name before a pixel is drawn.

#![warn(missing_docs)]

mod code;
mod compile;
mod data;
mod error;
mod geometry;
mod machine;
mod registers;
mod resources;
mod run;
mod scalar;
mod varyings;

pub use code::LANES;
pub use error::Error;
pub use machine::{Component, Machine, Results};
pub use resources::{Address, Filter, Numbers, Resource, Resources, Sampler, Texture};
pub use strahl_scene::{Rendered, Stats};

use code::{BLOCK, Lanes};
use data::Data;
use run::State;
use std::sync::Arc;
use strahl_program::{
    Frame, Functions, ImportanceBlock, Object, Order, SegmentTable, Slices, Slicing, Table2d,
    has_important_places, noise_tile, tables, techniques_of, visible_bricks,
};
use strahl_scene::plan::Plan;
use strahl_scene::{Image, OtherData};
use strahl_shader::{Linker, NOWHERE_MM, Program, RayLoop, TABLE_ROW, Texels, bindings, ray_loop};
use strahl_volume::{Control, Datasets, Parts, Stopwatch, Store, Work, cores};
use varyings::Inputs;

/// Draws Plans of the same data. What it makes of the data for that it keeps in a [`Store`], for the next picture.
#[derive(Debug)]
pub struct Evaluator {
    datasets: Datasets,
    store: Arc<Store>,
    linker: Linker,
}

impl Evaluator {
    /// Draws from `data`, which it reads in place.
    pub fn new(data: impl Into<Datasets>) -> Evaluator {
        Evaluator::with_store(data, Arc::default())
    }

    /// The same with what others make of the data, and share.
    pub fn with_store(data: impl Into<Datasets>, store: Arc<Store>) -> Evaluator {
        Evaluator {
            datasets: data.into(),
            store,
            linker: Linker::new(),
        }
    }

    /// Draws from other data from now on; programs stay linked.
    pub fn set_data(&mut self, data: impl Into<Datasets>) {
        self.datasets = data.into();
    }

    /// The program that draws `plan`, and its uniform block.
    fn program(&mut self, plan: &Plan) -> Result<(Arc<Program>, Vec<u8>), Error> {
        let functions = self.functions(plan)?;
        let skeleton = ray_loop(&RayLoop {
            is_finite: self.datasets.are_finite() && functions.selection.is_built_in(),
            ..self.loop_of(plan)?
        })?;
        let program = self.linker.link(&skeleton, &functions.selection)?;
        let parameters = functions.parameters(&program)?;
        Ok((program, parameters))
    }

    /// Draws `plan`, under `control`.
    ///
    /// # Errors
    /// The Plan belongs to other data, its functions cannot be linked or do what is not covered, or
    /// `control` was cancelled.
    pub fn render(&mut self, plan: &Plan, control: &Control) -> Result<Rendered, Error> {
        let start = Stopwatch::start();
        let (program, parameters) = self.program(plan)?;
        let mut rendered = self.render_by(plan, &program, &parameters, &[], control)?;
        let stats = &mut rendered.stats;
        stats.link_seconds = start.seconds() - stats.draw_seconds;
        Ok(rendered)
    }

    /// The functions that a Plan asks for, as a graph compiler needs them.
    ///
    /// # Errors
    /// The Plan belongs to other data.
    pub fn functions(&self, plan: &Plan) -> Result<Functions, Error> {
        plan.check(&self.datasets)?;
        let threshold = |mask, threshold| data::mask_threshold(&self.datasets, mask, threshold);
        Ok(Functions::of(plan, false, threshold)?)
    }

    /// The loop that a Plan asks for, as a graph compiler needs it.
    ///
    /// # Errors
    /// The Plan belongs to other data.
    pub fn loop_of(&self, plan: &Plan) -> Result<RayLoop, Error> {
        plan.check(&self.datasets)?;
        Ok(RayLoop {
            volumes: vec![Texels::UnfilterableFloat; self.datasets.volumes.len()],
            objects: plan.layers.len(),
            is_before_geometry: !plan.meshes.is_empty(),
            techniques: techniques_of(plan),
            is_finite: false,
            has_important_places: has_important_places(plan),
        })
    }

    /// Draws `plan` by slices that are blended as `slicing` says. `program` is that of a slice; else as
    /// [`Evaluator::render_by`].
    ///
    /// # Errors
    /// As [`Evaluator::render`]; the Plan asks for what slices cannot do.
    pub fn render_slices_by(
        &mut self,
        plan: &Plan,
        program: &Arc<Program>,
        parameters: &[u8],
        textures: &[Table2d],
        slicing: &Slicing,
        control: &Control,
    ) -> Result<Rendered, Error> {
        let start = Stopwatch::start();
        let slices = Slices::of(plan, slicing.order)?;
        let data = Data::new(&self.datasets, plan, &self.store, control)?;
        let under = (&*self.store, control);
        let mut scenery = Scenery::new(plan, &data, program, parameters, textures, under)?;
        scenery.frame.first_slice = slices.first;
        let frames = plan.lattice.frames;
        let height = plan.height as usize;
        let rows = control.parts(Work::Drawing, frames as usize * height);
        let mut sums = vec![[0.0f64; 4]; plan.width as usize * height];
        for number in 0..frames {
            scenery.set_frame(number)?;
            let pixels = scenery.draw_slices(plan, slices, slicing, &rows)?;
            for (sum, pixel) in sums.iter_mut().zip(pixels) {
                let passing = 1.0 - pixel[3];
                for (c, sum) in sum.iter_mut().enumerate() {
                    *sum += f64::from(pixel[c] + passing * plan.background[c]);
                }
            }
        }
        let mean = |sum: [f64; 4]| sum.map(|c| (c / f64::from(frames)) as f32);
        let pixels = sums.into_iter().map(mean).collect();
        Ok(Rendered {
            image: Image::from_pixels(plan.width, plan.height, pixels)
                .into_linear(plan.compositing),
            depth_mm: None,
            stats: stats_since(start),
        })
    }

    /// Draws `plan` by a program of the caller's, which reads what [`strahl_shader::bindings`] lists.
    /// `parameters` is its uniform block, `textures` are those of a graph.
    ///
    /// # Errors
    /// As [`Evaluator::render`].
    pub fn render_by(
        &mut self,
        plan: &Plan,
        program: &Arc<Program>,
        parameters: &[u8],
        textures: &[Table2d],
        control: &Control,
    ) -> Result<Rendered, Error> {
        let start = Stopwatch::start();
        let data = Data::new(&self.datasets, plan, &self.store, control)?;
        let under = (&*self.store, control);
        let mut scenery = Scenery::new(plan, &data, program, parameters, textures, under)?;
        let entry = if plan.with_depth {
            "fragment_with_depth"
        } else {
            "fragment"
        };
        let (width, height) = (plan.width as usize, plan.height as usize);
        let mut pixels = vec![[0.0; 4]; width * height];
        let frames = plan.lattice.frames;
        let mut sums = vec![[0.0f64; 4]; if frames == 1 { 0 } else { width * height }];
        let mut depth_mm = plan.with_depth.then(|| vec![f32::INFINITY; width * height]);
        let rows = control.parts(Work::Drawing, frames as usize * height);
        for number in 0..frames {
            scenery.set_frame(number)?;
            let (frame, depth) = scenery.draw(entry, plan, &rows)?;
            if frames == 1 {
                pixels = frame;
            } else {
                for (sum, pixel) in sums.iter_mut().zip(&frame) {
                    for (sum, c) in sum.iter_mut().zip(pixel) {
                        *sum += f64::from(*c);
                    }
                }
            }
            if number == 0
                && let Some(depth_mm) = &mut depth_mm
            {
                let geometry = scenery.distance_mm.iter().flatten();
                let planes = [depth.iter().collect::<Vec<_>>(), geometry.collect()];
                for plane in planes {
                    for (depth, found) in depth_mm.iter_mut().zip(plane) {
                        if *found < NOWHERE_MM {
                            *depth = depth.min(*found);
                        }
                    }
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
            stats: stats_since(start),
        })
    }
}

/// Compiling and drawing; nothing is counted.
fn stats_since(start: Stopwatch) -> Stats {
    Stats {
        threads: cores::number(),
        draw_seconds: start.seconds(),
        ..Stats::default()
    }
}

/// A program with all that it reads of a Plan and its data.
struct Scenery<'a> {
    machine: Machine<'a>,
    frame: Frame,
    objects: Vec<Object>,
    distance_mm: Option<Vec<f32>>,
    control: Control,
}

/// Everything that a program may read is here, whether it does or not.
const GROUP: u32 = 0;

impl<'a> Scenery<'a> {
    fn new(
        plan: &Plan,
        data: &'a Data<'a>,
        program: &'a Program,
        parameters: &[u8],
        textures: &[Table2d],
        (store, control): (&Store, &Control),
    ) -> Result<Scenery<'a>, Error> {
        let frame = Frame::of(plan);
        let mut objects: Vec<_> = plan
            .drawn_fields()
            .enumerate()
            .map(|(layer, field)| {
                let (slope, intercept) = data.value_of_texel(field);
                Object::of(plan, layer, slope, intercept)
            })
            .collect();
        let segments = data.segments();
        let segments = segments.and_then(|numbers| SegmentTable::of(plan, &numbers.ids));
        let entries = tables(plan, &mut objects, segments.as_ref())?;
        let of_objects = data.of_objects(plan);
        let of_object = |i: usize| of_objects[i];
        let (brick_dims, bricks) = visible_bricks(plan, &mut objects, of_object, store, control)?;
        let geometry = match plan.meshes.is_empty() {
            true => None,
            false => Some(geometry::draw(plan, data.meshes(), control)?),
        };
        let mut resources = Resources::new();
        for binding in program.bindings() {
            let flat = |numbers: Vec<f32>, [width, height]: [u32; 2], channels| {
                let numbers = Numbers::F32(numbers.into());
                Ok(Resource::Texture(Texture::new(
                    [width, height, 1],
                    channels,
                    numbers,
                )?))
            };
            let nothing = || Texture::new([1; 3], 1, Numbers::F32(vec![0.0].into()));
            let resource: Result<Resource, Error> = match binding {
                bindings::FRAME => Ok(Resource::Uniform(frame.bytes(&objects))),
                bindings::PARAMETERS => Ok(Resource::Uniform(parameters.to_vec())),
                bindings::IMPORTANCE => {
                    let block =
                        ImportanceBlock::of(plan, |mask, value| data.mask_number(mask, value));
                    Ok(Resource::Uniform(bytemuck::bytes_of(&block).to_vec()))
                }
                bindings::VOLUME_SAMPLER => Ok(Resource::Sampler(Sampler::default())),
                bindings::TABLES => {
                    let size = [TABLE_ROW, entries.len() as u32 / TABLE_ROW];
                    flat(entries.concat(), size, 4)
                }
                bindings::BRICKS => {
                    let bricks: Vec<u32> = bricks.iter().map(|b| u32::from(*b)).collect();
                    let numbers = Numbers::U32(bricks.into());
                    Ok(Resource::Texture(Texture::new(brick_dims, 1, numbers)?))
                }
                bindings::NOISE_TILE => {
                    let (edge, values) = noise_tile(plan, store, control)?;
                    let rows = values.len() as u32 / edge;
                    flat(values, [edge, rows], 1)
                }
                bindings::OPAQUE_MM | bindings::OPAQUE_COLOR => {
                    let size = [plan.width, plan.height];
                    match &geometry {
                        Some(geometry) if binding == bindings::OPAQUE_MM => {
                            flat(geometry.distance_mm.clone(), size, 1)
                        }
                        Some(geometry) => flat(geometry.color.concat(), size, 4),
                        None if binding == bindings::OPAQUE_MM => flat(vec![NOWHERE_MM], [1; 2], 1),
                        None => flat(vec![0.0; 4], [1; 2], 4),
                    }
                }
                bindings::LABELS => {
                    let labels = data.labels(plan).unwrap_or_else(nothing);
                    Ok(Resource::Texture(labels?))
                }
                bindings::SEGMENTS => {
                    let entries = segments.as_ref().map(|s| s.entries.clone());
                    let entries = entries.unwrap_or(vec![0]);
                    let width = TABLE_ROW.min(entries.len() as u32);
                    let size = [width, entries.len() as u32 / width, 1];
                    let numbers = Numbers::U32(entries.into());
                    Ok(Resource::Texture(Texture::new(size, 1, numbers)?))
                }
                bindings::PAGES => Err(Error::NotCovered {
                    what: "volume in pages".into(),
                    function: "stored".into(),
                }),
                _ if binding < bindings::FIRST_VOLUME => {
                    let mask = (binding - bindings::FIRST_MASK) as usize;
                    let mask = data.mask(mask).unwrap_or_else(nothing);
                    Ok(Resource::Texture(mask?))
                }
                _ if binding >= bindings::FIRST_TEXTURE => {
                    let index = (binding - bindings::FIRST_TEXTURE) as usize;
                    OtherData::unless_there("texture", index, textures.len())?;
                    let table = &textures[index];
                    flat(table.texels.concat(), [table.width, table.height], 4)
                }
                _ => {
                    let volume = (binding - bindings::FIRST_VOLUME) as usize;
                    OtherData::unless_there("volume", volume, data.volumes())?;
                    let kind = texel_kind(program.naga(), binding);
                    Ok(Resource::Texture(data.volume(volume, kind)?))
                }
            };
            resources.put(GROUP, binding, resource?);
        }
        Ok(Scenery {
            machine: Machine::unprepared(program.naga(), resources)?,
            frame,
            objects,
            distance_mm: geometry.map(|geometry| geometry.distance_mm),
            control: control.clone(),
        })
    }

    fn set_frame(&mut self, number: u32) -> Result<(), Error> {
        self.frame.number = number;
        if !self.machine.has(GROUP, bindings::FRAME) {
            return Ok(());
        }
        let bytes = self.frame.bytes(&self.objects);
        self.machine.set_uniform(GROUP, bindings::FRAME, &bytes)
    }

    /// Colors, and what location 1 says.
    fn draw(
        &self,
        entry: &str,
        plan: &Plan,
        rows_drawn: &Parts,
    ) -> Result<(Vec<[f32; 4]>, Vec<f32>), Error> {
        let (width, height) = (plan.width as usize, plan.height as usize);
        let code = self.machine.code(entry)?;
        let run = self.machine.prepared(&code).under(&self.control);
        let inputs = Inputs::of(&self.machine, entry, 1, [plan.width, plan.height])?;
        let mut pixels = vec![[0.0; 4]; width * height];
        let mut depth_mm = vec![NOWHERE_MM; if plan.with_depth { width * height } else { 0 }];
        let with_depth = plan.with_depth;
        let strip = BLOCK * width;
        let mut no_depth: Vec<[f32; 0]> = vec![[]; height.div_ceil(BLOCK)];
        let depth_strips: Vec<&mut [f32]> = if with_depth {
            depth_mm.chunks_mut(strip).collect()
        } else {
            no_depth.iter_mut().map(|none| &mut none[..]).collect()
        };
        cores::try_for_each(
            pixels.chunks_mut(strip).zip(depth_strips).enumerate(),
            || State::new(&run),
            |state, (row, (pixels, depth))| -> Result<(), Error> {
                let rows = pixels.len() / width;
                for left in (0..width).step_by(BLOCK) {
                    let active = in_picture([width - left, rows]);
                    self.control.check()?;
                    inputs.set(0, [left, row * BLOCK], &code, &mut state.registers);
                    let killed = state.run(active)?;
                    for lane in 0..code::LANES {
                        if active.0[lane] & !killed.0[lane] == 0 {
                            continue;
                        }
                        let pixel = lane / BLOCK * width + left + lane % BLOCK;
                        let number = |i: usize| {
                            let register = code.outputs[i] as usize;
                            f32::from_bits(state.registers[register].0[lane])
                        };
                        pixels[pixel] = [number(0), number(1), number(2), number(3)];
                        if with_depth {
                            depth[pixel] = number(4);
                        }
                    }
                }
                Ok(rows_drawn.done(rows)?)
            },
        )?;
        Ok((pixels, depth_mm))
    }

    /// All slices, blended; without the background.
    fn draw_slices(
        &self,
        plan: &Plan,
        slices: Slices,
        slicing: &Slicing,
        rows_drawn: &Parts,
    ) -> Result<Vec<[f32; 4]>, Error> {
        debug_assert_eq!(slices.direction > 0, slicing.order == Order::FrontToBack);
        let (width, height) = (plan.width as usize, plan.height as usize);
        let code = self.machine.code("fragment")?;
        let run = self.machine.prepared(&code).under(&self.control);
        let size = [plan.width, plan.height];
        let inputs = Inputs::of(&self.machine, "fragment", slices.count, size)?;
        let mut pixels = vec![slicing.start; width * height];
        cores::try_for_each(
            pixels.chunks_mut(BLOCK * width).enumerate(),
            || State::new(&run),
            |state, (row, pixels)| -> Result<(), Error> {
                let rows = pixels.len() / width;
                for left in (0..width).step_by(BLOCK) {
                    let active = in_picture([width - left, rows]);
                    self.control.check()?;
                    for slice in 0..slices.count as usize {
                        inputs.set(slice, [left, row * BLOCK], &code, &mut state.registers);
                        let killed = state.run(active)?;
                        for lane in 0..code::LANES {
                            if active.0[lane] & !killed.0[lane] == 0 {
                                continue;
                            }
                            let pixel = lane / BLOCK * width + left + lane % BLOCK;
                            let number = |i: usize| {
                                let register = code.outputs[i] as usize;
                                f32::from_bits(state.registers[register].0[lane])
                            };
                            let source = [number(0), number(1), number(2), number(3)];
                            pixels[pixel] = slicing.blend.blended(source, pixels[pixel]);
                        }
                    }
                }
                Ok(rows_drawn.done(rows)?)
            },
        )?;
        Ok(pixels)
    }
}

/// The lanes of a block that lie in what is left of the picture; those outside do nothing.
fn in_picture([columns, rows]: [usize; 2]) -> Lanes {
    let mut active = Lanes::NONE;
    for (lane, active) in active.0.iter_mut().enumerate() {
        let is_inside = lane % BLOCK < columns && lane / BLOCK < rows;
        *active = if is_inside { !0 } else { 0 };
    }
    active
}

/// The kind of numbers of the texture at a binding.
fn texel_kind(module: &naga::Module, binding: u32) -> naga::ScalarKind {
    let mut variables = module.global_variables.iter();
    let found = variables.find(|(_, v)| v.binding.as_ref().is_some_and(|b| b.binding == binding));
    match found.map(|(_, variable)| &module.types[variable.ty].inner) {
        Some(naga::TypeInner::Image {
            class: naga::ImageClass::Sampled { kind, .. },
            ..
        }) => *kind,
        _ => naga::ScalarKind::Float,
    }
}
