//! The data path of a ray: what its samples make of its light, one after the other.
//!
//! In the pipeline the samples of many rays alternate, but those of one ray stay in order and no ray looks at another. So what
//! a ray looks like can be known before its clocks are counted, for many tiles at the same time: [`DataPath::value`] walks
//! along one ray, with the functions that the pipeline calls too.

use crate::fixed_point::{scaled, whole};
use crate::frame::Frame;
use crate::messages::{Classified, LitSample, Read, Sample, Slot, VisibleSample};
use crate::polygons::Fragment;
use crate::rays::Ray;
use crate::spec::{Classification, Leaping, Reconstruction};
use crate::stages::absorb::Absorber;
use crate::stages::address::AddressGenerator;
use crate::stages::composite::Compositor;
use crate::stages::interpolate::Interpolator;
use crate::stages::shade::length;

/// State of a ray in the data path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Light {
    pub passing: u32,
    pub accumulator: [u32; 3],
    /// The polygon in front of which the ray still is.
    pub fragment: Option<Fragment>,
    /// Word (pre-integration) or opacity (adaptive sampling) of the sample before.
    pub before: u32,
    pub has_ended: bool,
}

/// What the address generator makes of the next read of a ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    pub position: [i32; 3],
    pub cell: [i32; 3],
    /// The distance word: 0 where the cell is not empty.
    pub distance: u32,
    /// Steps to go, not more than are left.
    pub steps: u32,
    /// Whether steps in between are interpolated instead of leapt over.
    pub is_adaptive: bool,
}

/// What becomes of a ray.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RayValue {
    /// Plane of the sample at which it ends early; `u32::MAX` if it does not.
    pub end_plane: u32,
    pub light: Light,
}

/// The units of the data path, for one frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DataPath<'f> {
    frame: &'f Frame,
    pub generator: AddressGenerator,
    interpolator: Interpolator,
    pub absorber: Absorber,
    pub compositor: Compositor,
}

impl<'f> DataPath<'f> {
    pub fn new(frame: &'f Frame) -> DataPath<'f> {
        let spec = &frame.spec;
        let widths = &spec.widths;
        DataPath {
            frame,
            generator: AddressGenerator::new(widths.position_fraction, widths.fraction),
            interpolator: Interpolator {
                fraction: widths.fraction,
                guard: widths.lerp_guard,
            },
            absorber: Absorber {
                data: widths.data,
                transmittance: widths.transmittance,
                threshold: (spec.optimisation.termination_threshold
                    * f64::from(1u32 << widths.transmittance))
                .round() as u32,
            },
            compositor: Compositor {
                intensity: widths.intensity,
                fraction: widths.accumulator_fraction,
                transmittance: widths.transmittance,
            },
        }
    }

    /// A ray before its first sample.
    pub fn light(&self, ray: &Ray) -> Light {
        let fragments = self.frame.fragments.as_ref();
        Light {
            passing: self.absorber.full(),
            fragment: fragments.and_then(|f| f[ray.pixel as usize]),
            ..Light::default()
        }
    }

    /// The next read of a ray.
    #[inline(always)]
    pub fn step(&self, ray: &Ray) -> Step {
        let position = self.bent(ray);
        let cell = self.generator.cell(position);
        // The distance arrives with the voxels; what it does to the ray is known when the ray comes back.
        let distance = match &self.frame.distance {
            Some(distance) => u32::from(distance.steps(cell)),
            None => 0,
        };
        let mut steps = distance.max(1).min(ray.remaining);
        let mut is_adaptive = false;
        if distance == 0
            && let Some(radius) = &self.frame.radius
        {
            // The last sample is always read.
            steps = u32::from(radius.steps(cell))
                .min(ray.remaining.saturating_sub(1))
                .max(1);
            is_adaptive = true;
        }
        Step {
            position,
            cell,
            distance,
            steps,
            is_adaptive,
        }
    }

    /// Whether a read goes through the data path: empty cells have no sample, but for the document's rule, which leaps from
    /// cells that are not empty, too.
    #[inline(always)]
    pub fn is_sample(&self, distance: u32) -> bool {
        distance == 0 || self.frame.spec.optimisation.leaping == Leaping::Document
    }

    /// The position of a ray's sample, bent if rays are.
    #[inline(always)]
    fn bent(&self, ray: &Ray) -> [i32; 3] {
        let Some(deformation) = &self.frame.deformation else {
            return ray.position;
        };
        let [right, up] = deformation.offset(&self.frame.setup, ray.pixel, ray.plane);
        let axes = &self.frame.setup.axes;
        let offset = (axes.right * f64::from(right) + axes.up * f64::from(up)) / 256.0;
        let one = f64::from(1u32 << self.frame.spec.widths.position_fraction);
        let offset = (offset * one).round().to_array();
        std::array::from_fn(|i| ray.position[i].wrapping_add(offset[i] as i32))
    }

    #[inline(always)]
    pub fn interpolate(&self, read: Read) -> Sample {
        let address = self.generator.split(read.position);
        let modules = self.frame.voxels.modules(address.cell, address.lowest);
        // Nothing interpolates to nothing; most of a volume is air.
        let [a, b, c, d, e, f, g, h] = modules;
        if a | b | c | d | e | f | g | h == 0 {
            return Sample {
                slot: read.slot,
                value: 0,
                gradient: [0; 3],
                steps: read.steps,
                plane: read.plane,
                pixel: read.pixel,
            };
        }
        let fraction = match self.frame.spec.look.reconstruction {
            Reconstruction::Trilinear => address.fraction,
            Reconstruction::Nearest => {
                let one = 1 << self.interpolator.fraction;
                address.fraction.map(|x| if 2 * x >= one { one } else { 0 })
            }
        };
        let (value, gradient) = self
            .interpolator
            .interpolate(modules, fraction, address.lowest);
        Sample {
            slot: read.slot,
            value,
            gradient,
            steps: read.steps,
            plane: read.plane,
            pixel: read.pixel,
        }
    }

    #[inline(always)]
    pub fn classify(&self, light: &mut Light, sample: Sample) -> Classified {
        let mut before = sample.value;
        if self.frame.spec.look.classification == Classification::PreIntegrated {
            before = std::mem::replace(&mut light.before, sample.value);
        }
        Classified {
            slot: sample.slot,
            opacity: self.frame.tables.opacity(before, sample.value),
            gradient: sample.gradient,
            steps: sample.steps,
            plane: sample.plane,
            word: sample.value as u16,
            pixel: sample.pixel,
        }
    }

    /// What is visible of a sample of a ray that has not ended; it may end the ray.
    #[inline(always)]
    pub fn absorb(&self, light: &mut Light, word: Classified) -> Option<VisibleSample> {
        if light.fragment.is_some_and(|f| word.plane >= f.plane) {
            light.has_ended = self.merge_fragment(light);
            if light.has_ended {
                return None;
            }
        }
        let (mut weight, mut passing, mut ends) = (0, light.passing, false);
        if word.steps > 1 {
            // Samples that were not read lie on a line between the one before and this one.
            for step in 1..u32::from(word.steps) {
                let gap = u32::from(word.steps);
                let opacity = ((gap - step) * light.before + step * word.opacity + gap / 2) / gap;
                let (added, behind, is_last) = self.absorber.absorb(opacity, passing);
                (weight, passing, ends) = (weight + added, behind, is_last);
                if ends {
                    break;
                }
            }
        }
        if !ends {
            let (added, behind, is_last) = self.absorber.absorb(word.opacity, passing);
            (weight, passing, ends) = (weight + added, behind, is_last);
        }
        if self.frame.radius.is_some() {
            light.before = word.opacity;
        }
        light.passing = passing;
        light.has_ended = ends;
        Some(VisibleSample {
            slot: word.slot,
            weight,
            gradient: word.gradient,
            word: word.word,
        })
    }

    /// What a visible sample weighs, with the length of its gradient if that counts.
    #[inline(always)]
    fn weight(&self, visible: &VisibleSample) -> u32 {
        let look = &self.frame.spec.look;
        let widths = &self.frame.spec.widths;
        if !look.gradient_weighting {
            return visible.weight;
        }
        let length = length(
            visible.gradient,
            widths.lerp_guard,
            widths.data,
            look.gradient_gain,
        );
        scaled(visible.weight, whole(length, widths.data), widths.data)
    }

    #[inline(always)]
    pub fn shade(&self, visible: VisibleSample) -> LitSample {
        let widths = &self.frame.spec.widths;
        let weight = self.weight(&visible);
        let intensity = match (&self.frame.materials, &self.frame.map) {
            (Some(materials), _) => materials.reflect(visible.word, visible.gradient),
            (None, Some(map)) => [map.reflect(visible.gradient); 3],
            (None, None) => [(1 << widths.intensity) - 1; 3],
        };
        LitSample {
            slot: visible.slot,
            weight,
            intensity,
        }
    }

    #[inline(always)]
    pub fn composite(&self, light: &mut Light, lit: LitSample) {
        for (accumulator, intensity) in light.accumulator.iter_mut().zip(lit.intensity) {
            *accumulator = self.compositor.add(*accumulator, lit.weight, intensity);
        }
    }

    /// Lays a polygon over what is in front of it; whether the ray ends there.
    pub fn merge_fragment(&self, light: &mut Light) -> bool {
        let Some(fragment) = light.fragment.take() else {
            return false;
        };
        let (weight, passing, ends) = self.absorber.absorb(fragment.opacity, light.passing);
        for (accumulator, intensity) in light.accumulator.iter_mut().zip(fragment.intensity) {
            *accumulator = self.compositor.add(*accumulator, weight, intensity);
        }
        light.passing = passing;
        // Nothing is seen behind an opaque one, whatever the threshold.
        ends || passing == 0
    }

    /// What becomes of a ray, without polygons and shadows.
    pub fn value(&self, ray: &Ray) -> RayValue {
        let mut ray = *ray;
        let mut light = self.light(&ray);
        let mut gap = 1;
        while ray.remaining > 0 {
            let step = self.step(&ray);
            if self.is_sample(step.distance) {
                let read = Read {
                    slot: Slot(0),
                    position: step.position,
                    steps: gap,
                    plane: ray.plane as u16,
                    pixel: ray.pixel,
                };
                let word = self.classify(&mut light, self.interpolate(read));
                // What weighs nothing adds nothing.
                if let Some(visible) = self.absorb(&mut light, word)
                    && visible.weight > 0
                    && self.weight(&visible) > 0
                {
                    let lit = self.shade(visible);
                    self.composite(&mut light, lit);
                }
                if light.has_ended {
                    return RayValue {
                        end_plane: ray.plane,
                        light,
                    };
                }
            }
            gap = if step.distance == 0 {
                step.steps as u8
            } else {
                1
            };
            ray.position = AddressGenerator::advance(ray.position, ray.step, step.steps);
            ray.remaining -= step.steps;
            ray.plane += step.steps;
        }
        RayValue {
            end_plane: u32::MAX,
            light,
        }
    }
}
