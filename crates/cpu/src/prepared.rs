//! What a picture needs beside its rays, found or made before the first of them.

use crate::brick_number::EDGE;
use crate::clipped::Clipped;
use crate::error::Error;
use crate::even::EvenCubes;
use crate::levels::Level;
use crate::library::classify::Integrals;
use crate::library::fetch::{MarschnerLobb, Noise, Shape};
use crate::library::jitter::Jitters;
use crate::library::reconstruct::{Values, of_fetch, values};
use crate::library::shade::Shading;
use crate::making::Making;
use crate::meshes::Meshes;
use crate::rejection::{OfCubic, Rejection};
use crate::scenery::{Known, Object, Scenery, Stored};
use crate::skip::Skip;
use crate::strides::Strides;
use std::sync::Arc;
use std::time::Instant;
use strahl_scene::plan::{Fetch, Field, Plan, Reconstruct, Sampling};
use strahl_scene::visibility::ContributionOf;
use strahl_volume::bricks::{BrickRange, Bricks, BricksOf};
use strahl_volume::{Cancelled, CoefficientsOf, ContentId, Datasets, Key, Rescale, Volume};

/// What the objects of a Plan are drawn from, and what is known of it.
pub struct Prepared {
    reads: Vec<Read>,
    known: Vec<Known>,
    masks: Vec<Volume>,
    meshes: Meshes,
    /// For bricks, and for the rest.
    pub bricks_seconds: f64,
    pub seconds: f64,
}

/// What an object is reconstructed from: its voxels, or coefficients in their place.
struct Read {
    volume: Arc<Volume>,
    rescale: Rescale,
}

impl Prepared {
    /// Finds or makes what `plan` needs of `data`; nothing for skipping unless it `skips`.
    pub fn new(
        making: &Making,
        data: &Datasets,
        plan: &Plan,
        skips: bool,
    ) -> Result<Prepared, Error> {
        let start = Instant::now();
        let (mut reads, mut known) = (Vec::new(), Vec::new());
        let mut bricks_seconds = 0.0;
        for (layer, field) in plan.drawn_fields().enumerate() {
            let own = &data.volumes[field.volume];
            let read = Read::new(making, field, own)?;
            let bricks_start = Instant::now();
            let source = Source::new(making, field, read)?;
            bricks_seconds += bricks_start.elapsed().as_secs_f64();
            known.push(source.known(making, &data.masks, plan, layer, skips)?);
            reads.push(source.read);
        }
        Ok(Prepared {
            reads,
            known,
            masks: data.masks.clone(),
            meshes: Meshes::new(making, &data.meshes)?,
            bricks_seconds,
            seconds: start.elapsed().as_secs_f64() - bricks_seconds,
        })
    }

    /// What `draw` makes of `plan`, whose scenery this is.
    pub fn with_scenery<S: Level, R>(self, plan: &Plan, draw: impl FnOnce(&Scenery<S>) -> R) -> R {
        let masks: Vec<Box<dyn Values<S> + '_>> = self
            .masks
            .iter()
            .map(|mask| {
                let trilinear = Reconstruct::Trilinear;
                values(mask.grid(), mask.samples(), mask.rescale(), trilinear)
            })
            .collect();
        let of_layers = self.reads.iter().zip(plan.drawn_fields());
        let sources: Vec<_> = of_layers.map(|(read, field)| read.values(field)).collect();
        let object = |(index, known): (usize, Known)| {
            let field = plan.field_of(index);
            let is_plain =
                field.fetch == Fetch::Stored && field.reconstruct == Reconstruct::Trilinear;
            let samples = self.reads[index].volume.samples();
            let stored = is_plain
                .then(|| Stored::new(&field.grid, samples))
                .flatten();
            Object::new(plan, index, &*sources[index], stored, &masks, known)
        };
        draw(&Scenery {
            plan,
            objects: self.known.into_iter().enumerate().map(object).collect(),
            shading: Shading::new(plan),
            jitters: Jitters::new(plan),
            meshes: &self.meshes,
            composite: plan.technique().composite,
        })
    }
}

impl Read {
    fn new(making: &Making, field: &Field, own: &Volume) -> Result<Read, Error> {
        if !field.reads_coefficients() {
            return Ok(Read {
                volume: Arc::new(own.clone()),
                rescale: field.rescale,
            });
        }
        let make = || own.b_spline_coefficients_under(making.control);
        let volume = making.find(&CoefficientsOf(own.id()), make)?;
        Ok(Read {
            rescale: volume.rescale(),
            volume,
        })
    }

    /// The values of a field: slots fetch and reconstruct.
    fn values<'a, S: Level>(&'a self, field: &Field) -> Box<dyn Values<S> + 'a> {
        let shape = Shape::new(&field.grid);
        match field.fetch {
            Fetch::MarschnerLobb { frequency, alpha } => {
                let fetch = MarschnerLobb {
                    shape,
                    frequency,
                    alpha,
                };
                of_fetch(fetch, Rescale::IDENTITY, field.reconstruct)
            }
            Fetch::Noise {
                cell_voxels,
                octaves,
                seed,
            } => {
                let fetch = Noise {
                    shape,
                    cell_voxels,
                    octaves,
                    seed,
                };
                of_fetch(fetch, Rescale::IDENTITY, field.reconstruct)
            }
            Fetch::Stored => {
                let samples = self.volume.samples();
                values(&field.grid, samples, self.rescale, field.reconstruct)
            }
        }
    }
}

/// What an object is reconstructed from, with its bricks, and what there is for cubic kernels.
struct Source {
    read: Read,
    bricks: Arc<Bricks>,
    of_cubic: Option<OfCubic>,
}

impl Source {
    fn new(making: &Making, field: &Field, read: Read) -> Result<Source, Cancelled> {
        let (volume, control) = (&read.volume, making.control);
        volume.statistics_under(control)?;
        let is_linear = matches!(
            field.reconstruct,
            Reconstruct::Nearest | Reconstruct::Trilinear
        );
        if field.fetch == Fetch::Stored && !is_linear {
            let of_cubic = OfCubic::new(making, volume)?;
            return Ok(Source {
                bricks: of_cubic.bricks.clone(),
                of_cubic: Some(of_cubic),
                read,
            });
        }
        let make = || Bricks::under(volume, EDGE, 0, control);
        let bricks = making.find(&BricksOf::new(volume, EDGE, 0), make)?;
        Ok(Source {
            read,
            bricks,
            of_cubic: None,
        })
    }

    /// What is known of layer number `layer`.
    fn known(
        &self,
        making: &Making,
        masks: &[Volume],
        plan: &Plan,
        layer: usize,
        skips: bool,
    ) -> Result<Known, Error> {
        let (bricks, of) = (&*self.bricks, (plan, layer));
        let contribution = ContributionOf::new(plan, layer, self.read.volume.id(), bricks);
        let clipped = Clipped::new(making, masks, bricks, plan, layer)?;
        let clipped = clipped.as_ref();
        let skip = match skips {
            true => Skip::new(making, &contribution, bricks, of, clipped)?,
            false => None,
        };
        let rejection = self.of_cubic.as_ref().filter(|_| skips);
        // Both need what is beside a voxel to have a value: bricks side by side have one in common then.
        let is_whole = plan.sampling == Sampling::Regular || self.is_whole(making)?;
        let even = match is_whole {
            true => EvenCubes::new(making, &contribution, bricks, plan, layer)?,
            false => None,
        };
        Ok(Known {
            skip: skip.filter(|_| is_whole || !plan.sampling.is_of_segments()),
            rejection: rejection
                .and_then(|of_cubic| Rejection::new(of_cubic, plan, layer, self.read.rescale)),
            even,
            strides: Strides::new(making, &contribution, bricks, of, clipped)?,
            integrals: Integrals::of_plan(making, plan, layer)?,
        })
    }

    /// Whether every voxel has a value, and none is so large that differences overflow.
    fn is_whole(&self, making: &Making) -> Result<bool, Cancelled> {
        let volume = &self.read.volume;
        let fits = |range: BrickRange| range.lo > -1e37 && range.hi < 1e37;
        let is_whole = making.find(&IsWholeOf(volume.id()), || {
            let statistics = volume.statistics_under(making.control)?;
            Ok::<_, Cancelled>(statistics.not_finite == 0 && self.bricks.ranges().all(fits))
        })?;
        Ok(*is_whole)
    }
}

/// Key of whether a volume is whole.
#[derive(Clone, PartialEq)]
struct IsWholeOf(ContentId);

impl Key for IsWholeOf {
    type Value = bool;

    const NAME: &str = "wholeness";

    fn bytes(&self, _: &bool) -> usize {
        size_of::<(IsWholeOf, bool)>()
    }
}
