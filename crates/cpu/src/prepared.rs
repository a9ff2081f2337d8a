//! What a picture needs beside its rays, found or made before the first of them.

use crate::brick_number::EDGE;
use crate::clipped::ClippedBricks;
use crate::error::Error;
use crate::even::EvenCubes;
use crate::important_places::ImportantPlaces;
use crate::label_bricks::{LabelBricks, LabelBricksKey};
use crate::levels::Level;
use crate::library::classify::Integrals;
use crate::library::composite::{Rule, with_rule};
use crate::library::fetch::{Shape, of_function};
use crate::library::jitter::Jitters;
use crate::library::reconstruct::{Values, of_voxels, values};
use crate::making::Making;
use crate::meshes::Meshes;
use crate::outline::Outline;
use crate::rejection::{CubicBounds, Rejection};
use crate::scenery::{Known, Object, Scenery, Stored};
use crate::segment_looks::SegmentLooks;
use crate::segment_numbers::SegmentNumbers;
use crate::skip::Skip;
use crate::strides::Strides;
use crate::technique_bricks::TechniqueBricks;
use crate::unseen_segments::{UnseenSegments, unseen_segments};
use std::sync::Arc;
use strahl_scene::Source;
use strahl_scene::plan::{Fetch, Field, Plan, Reconstruct, Sampling};
use strahl_scene::visibility::ContributionKey;
use strahl_volume::bricks::{BrickRange, Bricks, BricksKey};
use strahl_volume::{
    Cancelled, CoefficientsKey, ContentId, Datasets, Key, LabelNumbers, LabelNumbersKey, Rescale,
    Stopwatch, Volume,
};

/// What the objects of a Plan are drawn from, and what is known of it.
pub struct Prepared {
    sources: Vec<Source>,
    known: Vec<Known<'static>>,
    masks: Vec<Volume>,
    /// Of the label volume whose segments are drawn.
    labels: Option<NumberedLabels>,
    /// Where its segments show nothing.
    unseen: Option<Arc<UnseenSegments>>,
    jitters: Jitters,
    meshes: Meshes,
    outline: Option<Outline>,
    /// For bricks, and for the rest.
    pub bricks_seconds: f64,
    pub seconds: f64,
}

impl Prepared {
    /// Finds or makes what `plan` needs of `data`; nothing for skipping unless it `skips`.
    pub fn new(
        making: &Making,
        data: &Datasets,
        plan: &Plan,
        skips: bool,
    ) -> Result<Prepared, Error> {
        let start = Stopwatch::start();
        let (mut sources, mut known) = (Vec::new(), Vec::new());
        let mut bricks_seconds = 0.0;
        let mut bricks_of_labeled = None;
        for (layer, field) in plan.drawn_fields().enumerate() {
            let source = Source::new(field, data, |own| {
                let make = || own.b_spline_coefficients_under(making.control);
                making.find(&CoefficientsKey(own.id()), make)
            })?;
            let bricks_start = Stopwatch::start();
            let reading = Reading::new(making, field, source)?;
            bricks_seconds += bricks_start.seconds();
            known.push(match plan.labeled() {
                // Every lattice point says whether a run ends.
                Some(_) => {
                    bricks_of_labeled = Some((reading.source.volume.id(), reading.bricks.clone()));
                    Known::default()
                }
                None => reading.known(making, &data.masks, plan, layer, skips)?,
            });
            sources.push(reading.source);
        }
        let labels = NumberedLabels::of_plan(making, data, plan)?;
        let mut unseen = None;
        if let (Some(labeled), Some(numbers), Some((source, bricks))) = (
            plan.labeled(),
            labels.as_ref().map(|labels| &*labels.numbers),
            bricks_of_labeled.filter(|_| skips),
        ) {
            let labels = (data.labels[labeled.labels].content_id(), numbers);
            let known = TechniqueBricks::new(making, plan, (source, &bricks))?;
            unseen = unseen_segments(making, plan, &known, labels)?;
        }
        Ok(Prepared {
            sources,
            known,
            masks: data.masks.clone(),
            labels,
            unseen,
            jitters: Jitters::find(plan.lattice.jitter, making.store, making.control)?,
            meshes: Meshes::new(making, &data.meshes)?,
            outline: skips.then(|| Outline::of(plan)).flatten(),
            bricks_seconds,
            seconds: start.seconds() - bricks_seconds,
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
        let of_layers = self.sources.iter().zip(plan.drawn_fields());
        let values: Vec<_> = of_layers
            .map(|(source, field)| values_of(source, field))
            .collect();
        let stored = |index: usize| {
            let field = plan.field_of(index);
            let is_plain =
                field.fetch == Fetch::Stored && field.reconstruct == Reconstruct::Trilinear;
            let samples = self.sources[index].volume.samples();
            is_plain
                .then(|| Stored::new(&field.grid, samples))
                .flatten()
        };
        let object = |(index, known): (usize, Known<'static>)| {
            let technique = plan.technique_of(index);
            let stored = stored(index);
            Object::new(
                plan,
                index,
                technique,
                &*values[index],
                stored,
                &masks,
                known,
            )
        };
        let segments = self.labels.as_ref().and_then(|labels| {
            SegmentNumbers::new(plan, &labels.numbers, &labels.bricks, self.unseen.clone())
        });
        let segments = segments.map(Arc::new);
        let of_segments = |technique| {
            let known = Known {
                segments: segments.clone(),
                ..Known::default()
            };
            let stored = stored(0);
            Object::new(plan, 0, technique, &*values[0], stored, &masks, known)
        };
        let objects: Vec<Object<S>> = match &segments {
            Some(_) => plan.drawn_techniques().map(of_segments).collect(),
            None => self.known.into_iter().enumerate().map(object).collect(),
        };
        let looks = segments.as_deref();
        let looks = looks.and_then(|segments| SegmentLooks::new(plan, segments));
        draw(&Scenery {
            plan,
            objects,
            segments,
            looks,
            important_places: ImportantPlaces::new(plan, &masks),
            jitters: self.jitters,
            meshes: &self.meshes,
            outline: self.outline,
            composite: plan.composite(),
        })
    }
}

/// The numbers of a label volume, by voxel and in bricks.
struct NumberedLabels {
    numbers: Arc<LabelNumbers>,
    bricks: Arc<LabelBricks>,
}

impl NumberedLabels {
    /// Of the label volume whose segments `plan` draws, if it draws such.
    fn of_plan(
        making: &Making,
        data: &Datasets,
        plan: &Plan,
    ) -> Result<Option<NumberedLabels>, Error> {
        let Some(labeled) = plan.labeled() else {
            return Ok(None);
        };
        let labels = &data.labels[labeled.labels];
        let key = LabelNumbersKey(labels.content_id());
        let numbers = making.find(&key, || labels.numbers_under(making.control))?;
        let dims = labels.grid().dims();
        let key = LabelBricksKey(labels.content_id());
        let make = || LabelBricks::under(&numbers, dims, making.control);
        let bricks = making.find(&key, make)?;
        Ok(Some(NumberedLabels { numbers, bricks }))
    }
}

/// The values of a field: slots fetch and reconstruct.
fn values_of<'a, S: Level>(source: &'a Source, field: &Field) -> Box<dyn Values<S> + 'a> {
    match of_function(field.fetch, Shape::new(&field.grid)) {
        Some(numbers) => of_voxels(numbers, Rescale::IDENTITY, field.reconstruct),
        None => {
            let samples = source.volume.samples();
            values(&field.grid, samples, source.rescale, field.reconstruct)
        }
    }
}

/// What an object is reconstructed from, with its bricks, and what there is for cubic kernels.
struct Reading {
    source: Source,
    bricks: Arc<Bricks>,
    of_cubic: Option<CubicBounds>,
}

impl Reading {
    fn new(making: &Making, field: &Field, source: Source) -> Result<Reading, Error> {
        let (volume, control) = (&source.volume, making.control);
        volume.statistics_under(control)?;
        let is_linear = matches!(
            field.reconstruct,
            Reconstruct::Nearest | Reconstruct::Trilinear
        );
        if field.fetch == Fetch::Stored && !is_linear {
            let of_cubic = CubicBounds::new(making, volume)?;
            return Ok(Reading {
                bricks: of_cubic.bricks.clone(),
                of_cubic: Some(of_cubic),
                source,
            });
        }
        let make = || Bricks::under(volume, EDGE, 0, control);
        let bricks = making.find(&BricksKey::new(volume, EDGE, 0), make)?;
        Ok(Reading {
            source,
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
    ) -> Result<Known<'static>, Error> {
        let (bricks, of) = (&*self.bricks, (plan, layer));
        let contribution = ContributionKey::new(plan, layer, self.source.volume.id(), bricks);
        let clipped = ClippedBricks::new(making, masks, bricks, plan, layer)?;
        let clipped = clipped.as_ref();
        let skip = match skips {
            true => Skip::new(making, &contribution, bricks, of, clipped)?,
            false => None,
        };
        let rejection = self.of_cubic.as_ref().filter(|_| skips);
        let sees = with_rule!(plan.technique_of(layer).composite, rule => rule.sees());
        // Both need what is beside a voxel to have a value: bricks side by side have one in common then.
        let is_whole = plan.sampling == Sampling::Regular || self.is_whole(making)?;
        let even = match is_whole {
            true => EvenCubes::new(making, &contribution, bricks, plan, layer)?,
            false => None,
        };
        Ok(Known {
            segments: None,
            skip: skip.filter(|_| is_whole || !plan.sampling.is_of_segments()),
            rejection: rejection.and_then(|of_cubic| {
                Rejection::new(of_cubic, plan, layer, self.source.rescale, sees)
            }),
            even,
            strides: Strides::new(making, &contribution, bricks, of, clipped)?,
            integrals: Integrals::of_plan(making, plan, layer)?,
        })
    }

    /// Whether every voxel has a value, and none is so large that differences overflow.
    fn is_whole(&self, making: &Making) -> Result<bool, Cancelled> {
        let volume = &self.source.volume;
        let fits = |range: BrickRange| range.lo > -1e37 && range.hi < 1e37;
        let is_whole = making.find(&IsWholeKey(volume.id()), || {
            let statistics = volume.statistics_under(making.control)?;
            let whole = self.bricks.whole_under(making.control)?;
            Ok::<_, Cancelled>(statistics.not_finite == 0 && fits(whole))
        })?;
        Ok(*is_whole)
    }
}

/// Key of whether a volume is whole.
#[derive(Clone, PartialEq)]
struct IsWholeKey(ContentId);

impl Key for IsWholeKey {
    type Value = bool;

    const NAME: &str = "wholeness";

    fn bytes(&self, _: &bool) -> usize {
        size_of::<(IsWholeKey, bool)>()
    }
}
