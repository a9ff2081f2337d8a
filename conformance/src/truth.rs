//! The truth: a Plan integrated by brute force in double precision.
//!
//! Written from docs/plan.md alone, and sharing no code with a renderer: its own rays, clips,
//! reconstruction, table lookup, light and composites. It visits every lattice point, keeps all of
//! them, and composites back to front, where renderers go front to back.
//!
//! [`picture`] gives the exact answer. [`bounds`] gives for each pixel the interval that a renderer
//! in single precision must hit: positions, values and gradients carry the rounding of f32 as
//! intervals through classification, light and composite, and where rounding may decide a question
//! either way (is this sample inside the box, has the threshold been reached, may the ray end), both
//! answers are in the interval. So no tolerance has to be guessed, and pixels on an edge need no
//! exception. [`bounds_of_programs`] gives the same for renderers that find the rays themselves in single precision.

mod field;
mod range;
mod set_up;
mod surface;

pub use field::{Field, Formula, Voxels};
pub use range::{Bounds, Range};

use glam::{DAffine3, DVec3};
use set_up::SetUp;
use strahl_scene::plan::{
    Classify, ClipShape, Composite, Compositing, Fetch, GradientInput, GradientMethod, Illuminate,
    Illustrate, Jitter, Plan, Projection, Reconstruct, SampleClip, Sampling, Shade,
};
use surface::{Lighting, Seen, classify, illuminate, opacity_of_length};

/// The share of the values that a gradient is made of which rounding can make of it.
const GRADIENT_ROUNDING: f64 = 1.0 / 262_144.0;

/// The picture of `plan`, row by row from the top: linear, premultiplied RGBA.
pub fn picture(plan: &Plan, field: &dyn Field) -> Vec<[f64; 4]> {
    let pixels = pixels(plan, field, Numbers::Exact);
    pixels.into_iter().map(Bounds::middle).collect()
}

/// What a renderer may make of each pixel of `plan` that finds its rays in double precision, and works in single
/// precision along them.
pub fn bounds(plan: &Plan, field: &dyn Field) -> Vec<Bounds> {
    pixels(plan, field, Numbers::SingleAlongRays)
}

/// What a renderer may make of each pixel of `plan` that works in single precision throughout, camera and maps
/// included. Where that says nothing of the ray, the bounds are [`Bounds::ANYTHING`].
pub fn bounds_of_programs(plan: &Plan, field: &dyn Field) -> Vec<Bounds> {
    pixels(plan, field, Numbers::Single)
}

/// In which numbers a picture is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Numbers {
    /// As many digits as are needed.
    Exact,
    /// Rays are exact; what happens along them is rounded to f32.
    SingleAlongRays,
    /// f32.
    Single,
}

/// Whether the truth has everything that `plan` asks for. What it does not have is compared between
/// renderers, and function by function, only.
pub fn covers(plan: &Plan) -> bool {
    let lit_well = match plan.technique().shade {
        Shade::Unlit => true,
        Shade::Lit {
            illuminate,
            keep_last_normal,
            ..
        } => {
            let has_model = matches!(
                illuminate,
                Illuminate::BlinnPhong { .. } | Illuminate::Lambert { .. }
            );
            has_model && !keep_last_normal
        }
        _ => false,
    };
    let projection = matches!(
        plan.technique().composite,
        Composite::Mip | Composite::Minip | Composite::Average
    );
    plan.layers.len() == 1
        && plan.meshes.is_empty()
        && plan.modules.is_empty()
        && plan.field().fetch == Fetch::Stored
        && plan.lattice.frames == 1
        && plan.sampling == Sampling::Regular
        && matches!(plan.lattice.jitter, Jitter::Center | Jitter::Hash(_))
        && plan.field().reconstruct != Reconstruct::BSplineInterpolating
        && plan.technique().classify == Classify::Table
        && plan.field().gradient == GradientMethod::Central
        && plan.technique().gradient_input == GradientInput::Value
        && lit_well
        && plan.technique().illustrate == Illustrate::Plain
        && !(projection && plan.technique().shade != Shade::Unlit)
        && (projection
            || matches!(
                plan.technique().composite,
                Composite::EmissionAbsorption { .. }
                    | Composite::BackToFront
                    | Composite::FirstHit { .. }
            ))
        && plan
            .sample_clips
            .iter()
            .all(|clip| clip.shape == ClipShape::Box)
        && plan.compositing == Compositing::Linear
}

fn pixels(plan: &Plan, field: &dyn Field, numbers: Numbers) -> Vec<Bounds> {
    assert!(covers(plan), "the truth does not cover this plan");
    let mut pixels = Vec::new();
    for y in 0..plan.height {
        for x in 0..plan.width {
            let line = Line::new(plan, field, numbers, x, y);
            pixels.push(line.map_or(Bounds::ANYTHING, |line| line.pixel()));
        }
    }
    pixels
}

/// A ray of the pixel in column `x`, row `y`: where t = 0, and the unit direction.
pub fn ray(plan: &Plan, x: u32, y: u32) -> (DVec3, DVec3) {
    let (width, height) = (f64::from(plan.width), f64::from(plan.height));
    let across = (2.0 * f64::from(x) + 1.0 - width) / height;
    let upward = (height - 2.0 * f64::from(y) - 1.0) / height;
    let camera = &plan.camera;
    let offset = across * camera.right + upward * camera.up;
    match camera.projection {
        Projection::Perspective { tan_half_height } => {
            let towards = camera.forward + tan_half_height * offset;
            (camera.eye_mm, towards / towards.length())
        }
        Projection::Orthographic { half_height_mm } => {
            (camera.eye_mm + half_height_mm * offset, camera.forward)
        }
    }
}

/// Yes, no, or as rounding will have it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Answer {
    Yes,
    Maybe,
    No,
}

impl Answer {
    /// Whether `signed` ≥ 0, when it may be `doubt` off.
    fn not_negative(signed: f64, doubt: f64) -> Answer {
        if signed >= doubt {
            Answer::Yes
        } else if signed < -doubt {
            Answer::No
        } else {
            Answer::Maybe
        }
    }

    fn and(self, other: Answer) -> Answer {
        match (self, other) {
            (Answer::No, _) | (_, Answer::No) => Answer::No,
            (Answer::Yes, Answer::Yes) => Answer::Yes,
            _ => Answer::Maybe,
        }
    }
}

/// A value of the field: its range, and whether there is one at all.
#[derive(Clone, Copy, Debug)]
struct Value {
    range: Range,
    exists: Answer,
}

/// A sample of the ray.
struct Sample {
    /// Lattice coordinate k + jitter.
    s: f64,
    value: Range,
    /// Yes or maybe.
    exists: Answer,
}

/// One ray of a Plan.
struct Line<'p> {
    plan: &'p Plan,
    field: &'p dyn Field,
    rounded: bool,
    origin: DVec3,
    direction: DVec3,
    t_entry: f64,
    t_exit: f64,
    jitter: f64,
    /// How far single precision may move a place, in voxels along each axis.
    shift: DVec3,
    /// How far it may move the end, seen from the entry.
    length_doubt_mm: f64,
    /// Whether places are turned to world space in single precision on the way to a clip.
    has_single_maps: bool,
}

impl<'p> Line<'p> {
    /// `None` if `numbers` say nothing of it.
    fn new(
        plan: &'p Plan,
        field: &'p dyn Field,
        numbers: Numbers,
        x: u32,
        y: u32,
    ) -> Option<Line<'p>> {
        let (origin, direction) = ray(plan, x, y);
        let [t_entry, t_exit] = seen(plan, origin, direction);
        let dims = plan.field().grid.dims().map(|n| n as f64);
        // Entry, step, product and sum round once each, the lattice coordinate once more.
        let along = (DVec3::from_array(dims) + 1.0) * 3.0 * f64::from(f32::EPSILON);
        // Ends of the ray come from f64 arithmetic on lengths of this size.
        let length = origin.length() + t_exit.abs().min(1e12) + plan.lattice.step_mm;
        let (shift, length_doubt_mm) = match numbers {
            Numbers::Exact => (DVec3::ZERO, 0.0),
            Numbers::SingleAlongRays => (along, 1e-12 * length),
            Numbers::Single => {
                let SetUp { place, length_mm } = SetUp::new(plan, origin, direction)?;
                (along + place, length_mm + 1e-12 * length)
            }
        };
        Some(Line {
            plan,
            field,
            rounded: numbers != Numbers::Exact,
            origin,
            direction,
            t_entry,
            t_exit,
            jitter: jitter(plan.lattice.jitter, x, y),
            shift,
            length_doubt_mm,
            has_single_maps: numbers == Numbers::Single,
        })
    }

    /// Lattice coordinate → voxel space.
    fn place(&self, s: f64) -> DVec3 {
        let t = self.t_entry + s * self.plan.lattice.step_mm;
        let world = self.origin + t * self.direction;
        self.plan
            .field()
            .grid
            .voxel_from_world()
            .transform_point3(world)
    }

    /// The value at a place in voxel space.
    fn value(&self, place: DVec3) -> Value {
        let mut range = Range::EMPTY;
        let (mut some, mut none) = (false, false);
        let mut look = |value: f64| {
            if value.is_finite() {
                some = true;
                range = range.hull(Range::exactly(value));
            } else {
                none = true;
            }
        };
        look(self.field.value(place));
        if self.rounded {
            // Between two cells also the voxel plane that parts them: there lies the kink of an interpolation.
            let [xs, ys, zs] = [0, 1, 2].map(|axis| {
                let (low, high) = (
                    place[axis] - self.shift[axis],
                    place[axis] + self.shift[axis],
                );
                let plane = high.floor();
                [low, high]
                    .into_iter()
                    .chain((low < plane).then_some(plane))
            });
            for z in zs {
                for y in ys.clone() {
                    for x in xs.clone() {
                        look(self.field.value(DVec3::new(x, y, z)));
                    }
                }
            }
        }
        Value {
            range,
            exists: match (some, none) {
                (true, false) => Answer::Yes,
                (true, true) => Answer::Maybe,
                (false, _) => Answer::No,
            },
        }
    }

    /// The same with the rounding of the value itself.
    fn rounded_value(&self, place: DVec3) -> Value {
        let value = self.value(place);
        let by = if self.rounded {
            self.field.rounding()
        } else {
            0.0
        };
        Value {
            range: value.range.widened(by),
            ..value
        }
    }

    /// Whether the sample clips keep a place in voxel space.
    fn kept(&self, place: DVec3) -> Answer {
        let grid = &self.plan.field().grid;
        let world = grid.world_from_voxel().transform_point3(place);
        let mut kept = Answer::Yes;
        for clip in &self.plan.sample_clips {
            let unit = clip.unit_from_world.transform_point3(world);
            let map = clip.unit_from_world * grid.world_from_voxel();
            let mut inside = Answer::Yes;
            for axis in 0..3 {
                let row = map.matrix3.row(axis).abs();
                let doubt = if self.rounded {
                    let size = row.dot(place.abs()) + map.translation[axis].abs();
                    row.dot(self.shift)
                        + 4.0 * f64::from(f32::EPSILON) * (size + 0.5)
                        + self.doubt_by_maps(clip, axis, place)
                } else {
                    0.0
                };
                inside = inside.and(Answer::not_negative(0.5 - unit[axis].abs(), doubt));
            }
            kept = kept.and(match (clip.keep_inside, inside) {
                (true, inside) => inside,
                (false, Answer::Yes) => Answer::No,
                (false, Answer::No) => Answer::Yes,
                (false, Answer::Maybe) => Answer::Maybe,
            });
        }
        kept
    }

    /// What two maps in single precision, voxel space → world → the shape of a clip, add to the doubt in a
    /// coordinate of the shape. Both have four rounded products each, of which the second cancel.
    fn doubt_by_maps(&self, clip: &SampleClip, axis: usize, place: DVec3) -> f64 {
        if !self.has_single_maps {
            return 0.0;
        }
        let to_world = self.plan.field().grid.world_from_voxel();
        let to_unit = clip.unit_from_world;
        let row = |map: &DAffine3, axis: usize| map.matrix3.row(axis).abs();
        let sizes =
            [0, 1, 2].map(|a| row(&to_world, a).dot(place.abs()) + to_world.translation[a].abs());
        let row = row(&to_unit, axis);
        let size = row.dot(DVec3::from_array(sizes)) + to_unit.translation[axis].abs();
        12.0 * 0.5 * f64::from(f32::EPSILON) * size
    }

    fn samples(&self) -> Vec<Sample> {
        let step = self.plan.lattice.step_mm;
        let mut samples = Vec::new();
        for k in 0u32.. {
            let s = f64::from(k) + self.jitter;
            let t = self.t_entry + s * step;
            // t < t_exit.
            let before_exit = match Answer::not_negative(t - self.t_exit, self.length_doubt_mm) {
                Answer::Yes => break,
                Answer::Maybe => Answer::Maybe,
                Answer::No => Answer::Yes,
            };
            let place = self.place(s);
            let value = self.rounded_value(place);
            let exists = before_exit.and(self.kept(place)).and(value.exists);
            if exists != Answer::No {
                samples.push(Sample {
                    s,
                    value: value.range,
                    exists,
                });
            }
        }
        samples
    }

    fn background(&self) -> Bounds {
        Bounds::exactly(self.plan.background.map(f64::from))
    }

    fn pixel(&self) -> Bounds {
        let samples = self.samples();
        match self.plan.technique().composite {
            Composite::EmissionAbsorption {
                stop_at_transmittance,
            } => self.emission_absorption(&samples, f64::from(stop_at_transmittance)),
            Composite::Mip => self.extreme(&samples, f64::max),
            Composite::Minip => self.extreme(&samples, f64::min),
            Composite::Average => self.average(&samples),
            Composite::FirstHit { threshold } => self.first_hit(&samples, f64::from(threshold)),
            Composite::BackToFront => self.emission_absorption(&samples, 0.0),
            other => unreachable!("{other:?} is not covered"),
        }
    }

    fn emission_absorption(&self, samples: &[Sample], stop: f64) -> Bounds {
        let table = &self.plan.technique().table;
        let exponent = self.plan.lattice.step_mm / f64::from(table.reference_mm());
        let mut layers = Vec::new();
        // What still passes after each sample decides where the ray ends.
        let mut passes = Range::exactly(1.0);
        for sample in samples {
            let surface = classify(table, sample.value, self.rounded);
            let mut opacity = opacity_of_length(surface.opacity, exponent, self.rounded);
            if sample.exists == Answer::Maybe {
                opacity.lo = 0.0;
            }
            passes = Range {
                lo: passes.lo * (1.0 - opacity.hi),
                hi: passes.hi * (1.0 - opacity.lo),
            };
            let doubt = if self.rounded { 1e-5 } else { 0.0 };
            let color = if opacity.hi > 0.0 {
                self.light(self.place(sample.s)).color(surface.color)
            } else {
                surface.color
            };
            let must_end = passes.hi + doubt < stop;
            layers.push((opacity, color, passes.lo - doubt < stop));
            if must_end {
                break;
            }
        }
        let behind_all = self.background();
        let mut pixel = behind_all;
        for (i, (opacity, color, may_end)) in layers.iter().enumerate().rev() {
            if *may_end && i + 1 < layers.len() {
                pixel = pixel.hull(behind_all);
            }
            pixel = pixel.under(*opacity, *color);
        }
        pixel
    }

    /// The extreme value, classified once.
    fn extreme(&self, samples: &[Sample], choose: fn(f64, f64) -> f64) -> Bounds {
        let sure = samples.iter().filter(|s| s.exists == Answer::Yes);
        let sure = sure.map(|s| s.value).reduce(|a, b| Range {
            lo: choose(a.lo, b.lo),
            hi: choose(a.hi, b.hi),
        });
        let mut pixel = None;
        let mut add = |value: Range| {
            let classified = self.classified(value);
            pixel = Some(match pixel {
                None => classified,
                Some(pixel) => classified.hull(pixel),
            });
        };
        if let Some(sure) = sure {
            add(sure);
        }
        for sample in samples.iter().filter(|s| s.exists == Answer::Maybe) {
            add(sure.map_or(sample.value, |sure| Range {
                lo: choose(sure.lo, sample.value.lo),
                hi: choose(sure.hi, sample.value.hi),
            }));
        }
        self.or_nothing(pixel, sure.is_none())
    }

    fn average(&self, samples: &[Sample]) -> Bounds {
        // The least mean that some choice of the doubtful samples gives, and the greatest.
        let mean = |value: fn(&Sample) -> f64, better: fn(&f64, &f64) -> bool| {
            let (mut doubtful, mut sum, mut number) = (Vec::new(), 0.0, 0.0);
            for sample in samples {
                if sample.exists == Answer::Yes {
                    sum += value(sample);
                    number += 1.0;
                } else {
                    doubtful.push(value(sample));
                }
            }
            doubtful.sort_by(f64::total_cmp);
            if better(&1.0, &0.0) {
                doubtful.reverse();
            }
            for value in doubtful {
                if number == 0.0 || better(&value, &(sum / number)) {
                    sum += value;
                    number += 1.0;
                }
            }
            sum / number
        };
        if samples.is_empty() {
            return self.background();
        }
        let range = Range {
            lo: mean(|s| s.value.lo, |a, b| a < b),
            hi: mean(|s| s.value.hi, |a, b| a > b),
        };
        let none_sure = samples.iter().all(|s| s.exists == Answer::Maybe);
        self.or_nothing(Some(self.classified(range)), none_sure)
    }

    /// A value of the ray as a pixel.
    fn classified(&self, value: Range) -> Bounds {
        let surface = classify(&self.plan.technique().table, value, self.rounded);
        self.background().under(surface.opacity, surface.color)
    }

    fn or_nothing(&self, pixel: Option<Bounds>, may_be_nothing: bool) -> Bounds {
        match pixel {
            None => self.background(),
            Some(pixel) if may_be_nothing => pixel.hull(self.background()),
            Some(pixel) => pixel,
        }
    }

    fn first_hit(&self, samples: &[Sample], threshold: f64) -> Bounds {
        let doubt = if self.rounded {
            threshold.abs() * f64::from(f32::EPSILON)
        } else {
            0.0
        };
        let reached = |value: Range| {
            if value.lo >= threshold + doubt {
                Answer::Yes
            } else if value.hi < threshold - doubt {
                Answer::No
            } else {
                Answer::Maybe
            }
        };
        let reached_at = |s: f64| {
            let place = self.place(s);
            let value = self.rounded_value(place);
            match value.exists {
                Answer::No => Answer::No,
                exists => exists.and(reached(value.range)).and(self.kept(place)),
            }
        };
        let mut hits = Vec::new();
        for sample in samples {
            let answer = reached(sample.value).and(sample.exists);
            if answer != Answer::No {
                hits.push((sample.s, answer));
            }
            if answer == Answer::Yes {
                break;
            }
        }
        let mut pixel = self.background();
        for &(s, answer) in hits.iter().rev() {
            let mut places = Vec::new();
            let mut budget = 200;
            // The sample before the first is the entry.
            let before = if s < 1.0 { 0.0 } else { s - 1.0 };
            let at_entry = if s < 1.0 { reached_at(0.0) } else { Answer::No };
            if at_entry != Answer::No {
                places.push(0.0);
            }
            if at_entry != Answer::Yes {
                refine(before, s, 12, &reached_at, &mut places, &mut budget);
            }
            let surface = |s: f64| {
                let place = self.place(s);
                let value = self.rounded_value(place);
                if value.exists == Answer::No {
                    return None;
                }
                let surface = classify(&self.plan.technique().table, value.range, self.rounded);
                let color = self.light(place).color(surface.color);
                Some(self.background().under(Range::exactly(1.0), color))
            };
            let hit = places.into_iter().filter_map(surface).reduce(Bounds::hull);
            let Some(hit) = hit else { continue };
            pixel = match answer {
                Answer::Yes => hit,
                _ => hit.hull(pixel),
            };
        }
        pixel
    }

    /// The light at a place in voxel space.
    fn light(&self, place: DVec3) -> Lighting {
        if self.plan.technique().shade == strahl_scene::plan::Shade::Unlit {
            return Lighting::UNLIT;
        }
        let mut per_voxel = DVec3::ZERO;
        let mut doubt = DVec3::ZERO;
        let mut largest = 0.0f64;
        let mut exists = Answer::Yes;
        for axis in 0..3 {
            let mut away = DVec3::ZERO;
            away[axis] = 1.0;
            let ahead = self.value(place + away);
            let behind = self.value(place - away);
            exists = exists.and(ahead.exists).and(behind.exists);
            for value in [ahead.range.middle(), behind.range.middle()] {
                largest = largest.max(value.abs());
            }
            per_voxel[axis] = 0.5 * (ahead.range.middle() - behind.range.middle());
            doubt[axis] = 0.5 * (ahead.range.half_width() + behind.range.half_width());
            // The same voxels give the same value: nothing is rounded away from 0.
            if self.rounded && (doubt[axis] != 0.0 || per_voxel[axis] != 0.0) {
                doubt[axis] += self.field.rounding();
            }
        }
        if exists == Answer::No {
            return Lighting::UNLIT;
        }
        // What rounding could have made of it counts as zero: docs/plan.md.
        let is_more = Answer::not_negative(
            per_voxel.abs().max_element() - largest * GRADIENT_ROUNDING,
            // One of six values stands for all where differences are small.
            doubt.max_element()
                + if self.rounded {
                    0.5 * largest * GRADIENT_ROUNDING
                } else {
                    0.0
                },
        );
        if is_more == Answer::No {
            return Lighting::UNLIT;
        }
        // The chain rule: world gradient = (voxel_from_world)ᵀ · voxel gradient.
        let map = self.plan.field().grid.voxel_from_world().matrix3;
        let axes = [map.x_axis, map.y_axis, map.z_axis];
        let gradient = DVec3::from_array(axes.map(|axis| axis.dot(per_voxel)));
        let doubt = DVec3::from_array(axes.map(|axis| {
            let rounding = if self.rounded {
                3.0 * f64::from(f32::EPSILON) * axis.abs().dot(per_voxel.abs())
            } else {
                0.0
            };
            axis.abs().dot(doubt) + rounding
        }));
        let grid = &self.plan.field().grid;
        let seen = Seen {
            place_mm: grid.world_from_voxel().transform_point3(place),
            direction: self.direction,
        };
        let light = illuminate(self.plan, gradient, doubt, seen);
        match exists.and(is_more) {
            Answer::Maybe => light.hull(Lighting::UNLIT),
            _ => light,
        }
    }
}

/// The places that `halvings` of the bracket from `outside` to `inside` may end at.
fn refine(
    outside: f64,
    inside: f64,
    halvings: u32,
    reached: &impl Fn(f64) -> Answer,
    places: &mut Vec<f64>,
    budget: &mut u32,
) {
    if halvings == 0 || *budget == 0 {
        places.push(inside);
        return;
    }
    *budget -= 1;
    let middle = 0.5 * (outside + inside);
    let answer = reached(middle);
    if answer != Answer::No {
        refine(outside, middle, halvings - 1, reached, places, budget);
    }
    if answer != Answer::Yes {
        refine(middle, inside, halvings - 1, reached, places, budget);
    }
}

/// Where a ray enters and leaves what is drawn: the half-spaces of the extent's six faces and of the
/// clip planes, one after the other, in world space (M. Cyrus and J. Beck, 1978).
fn seen(plan: &Plan, origin: DVec3, direction: DVec3) -> [f64; 2] {
    let grid = &plan.field().grid;
    let map = grid.voxel_from_world();
    let mut half_spaces: Vec<(DVec3, f64)> = Vec::new();
    for axis in 0..3 {
        let normal = map.matrix3.row(axis);
        let at_origin = map.translation[axis];
        half_spaces.push((normal, at_origin + 0.5));
        half_spaces.push((-normal, grid.dims()[axis] as f64 - 0.5 - at_origin));
    }
    half_spaces.extend(
        plan.ray_clips
            .iter()
            .map(|clip| (clip.normal, clip.offset_mm)),
    );
    let (mut entry, mut exit) = (0.0f64, f64::INFINITY);
    for (normal, offset) in half_spaces {
        let height = normal.dot(origin) + offset;
        let slope = normal.dot(direction);
        if slope > 0.0 {
            entry = entry.max(-height / slope);
        } else if slope < 0.0 {
            exit = exit.min(-height / slope);
        } else if height < 0.0 {
            exit = f64::NEG_INFINITY;
        }
    }
    [entry, exit]
}

/// The hash of docs/plan.md.
fn jitter(jitter: Jitter, x: u32, y: u32) -> f64 {
    let Jitter::Hash(seed) = jitter else {
        return 0.5;
    };
    let multiply = |a: u64, b: u64| a * b % (1 << 32);
    let mut h = multiply(x.into(), 0x9E37_79B1)
        ^ multiply(y.into(), 0x85EB_CA77)
        ^ multiply(seed.into(), 0xC2B2_AE3D);
    h ^= h >> 16;
    h = multiply(h, 0x7FEB_352D);
    h ^= h >> 15;
    h = multiply(h, 0x846C_A68B);
    h ^= h >> 16;
    (h / 256) as f64 / 16_777_216.0
}
