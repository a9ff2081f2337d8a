//! Every word on every wire, with its width.

use crate::spec::{Shadow, Spec};

/// Number of a ray in the parameter RAM: it holds two tiles, the second half is the other one. Light rays have numbers
/// behind both.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slot(pub u16);

impl Slot {
    /// As an index.
    #[inline(always)]
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// Queue → parameter RAM → address generator → memory: a sample to be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Read {
    /// Whose sample.
    pub slot: Slot,
    /// Position in voxels, `widths.position_fraction` fraction bits.
    pub position: [i32; 3],
    /// Steps that the sample stands for (more than 1 only with adaptive sampling).
    pub steps: u8,
    /// Distance from the image plane in steps: what polygons are compared with.
    pub plane: u16,
    /// Whose light is asked for, of a light ray: its pixel.
    pub pixel: u32,
}

/// Address generator → queue, over the sort bus: a ray that goes on. One word, so that it stays in a register: key, number, and
/// whether there is a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Return(u64);

impl Return {
    /// A ray with its key, or none if it is at its end.
    #[inline(always)]
    pub fn new(slot: Slot, key: Option<u32>) -> Return {
        let has_key = u64::from(key.is_some());
        Return(u64::from(key.unwrap_or(0)) | u64::from(slot.0) << 32 | has_key << 48)
    }

    /// Which ray.
    #[inline(always)]
    pub fn slot(self) -> Slot {
        Slot((self.0 >> 32) as u16)
    }

    /// Its key, or none if it is at its end.
    #[inline(always)]
    pub fn key(self) -> Option<u32> {
        (self.0 >> 48 != 0).then_some(self.0 as u32)
    }
}

/// Interpolator → classification.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sample {
    /// Whose sample.
    pub slot: Slot,
    /// Interpolated value: `widths.data` bits.
    pub value: u32,
    /// Knittel's gradient: `widths.data` + `widths.lerp_guard` bits and sign.
    pub gradient: [i32; 3],
    /// As in [`Read`].
    pub steps: u8,
    /// As in [`Read`].
    pub plane: u16,
    /// As in [`Read`].
    pub pixel: u32,
}

/// Classification → absorption.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Classified {
    /// Whose sample.
    pub slot: Slot,
    /// Opacity: `widths.data` bits.
    pub opacity: u32,
    /// As in [`Sample`].
    pub gradient: [i32; 3],
    /// As in [`Read`].
    pub steps: u8,
    /// As in [`Read`].
    pub plane: u16,
    /// The word that was classified, for its material.
    pub word: u16,
    /// As in [`Read`].
    pub pixel: u32,
}

/// Absorption → shading: what is still visible of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VisibleSample {
    /// Whose sample.
    pub slot: Slot,
    /// Opacity · light that passes: `widths.transmittance` bits.
    pub weight: u32,
    /// As in [`Sample`].
    pub gradient: [i32; 3],
    /// As in [`Classified`].
    pub word: u16,
}

/// Shading → compositing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LitSample {
    /// Whose sample.
    pub slot: Slot,
    /// As in [`VisibleSample`], times the length of the gradient if that weighs.
    pub weight: u32,
    /// Reflected light: `widths.intensity` bits; red, green and blue with materials, else only the first.
    pub intensity: [u32; 3],
}

/// Absorption → queue: a ray that is to end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Terminate(pub Slot);

/// A wire as it appears in waveforms and documents.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Wire {
    /// Unit that drives it.
    pub unit: &'static str,
    /// Its name.
    pub name: &'static str,
    /// Its width in bits.
    pub bits: u32,
    /// What it carries.
    pub meaning: &'static str,
}

/// Every wire of a processor, with its width.
pub fn wires(spec: &Spec) -> Vec<Wire> {
    let w = &spec.widths;
    let rays = spec.queue.bundle[0] * spec.queue.bundle[1];
    let passes = if spec.shadow == Shadow::None { 1 } else { 2 };
    let slot = (2 * passes * rays).next_power_of_two().trailing_zeros();
    let position = 1 + w.position_integer + w.position_fraction;
    let gradient = 1 + w.data + w.lerp_guard;
    let wire = |unit, name, bits, meaning| Wire {
        unit,
        name,
        bits,
        meaning,
    };
    vec![
        wire("queue", "issue_valid", 1, "a ray leaves the queue"),
        wire("queue", "issue_ray", slot, "number of that ray"),
        wire("queue", "waiting", slot, "rays that wait in the queue"),
        wire("address", "x", position, "position along x, fixed point"),
        wire("address", "y", position, "position along y, fixed point"),
        wire("address", "z", position, "position along z, fixed point"),
        wire(
            "address",
            "plane",
            w.key,
            "distance from the image plane in steps, for polygons and the buffer of shadows",
        ),
        wire("memory", "freeze", 1, "the memory holds everything"),
        wire(
            "memory",
            "data_valid",
            1,
            "voxels arrive for the interpolator",
        ),
        wire("memory", "data_ray", slot, "ray of these voxels"),
        wire("sort", "sort_valid", 1, "a ray comes back to the queue"),
        wire("sort", "sort_ray", slot, "number of that ray"),
        wire("sort", "sort_key", w.key, "its key"),
        wire("interpolate", "value_valid", 1, "an interpolated value"),
        wire("interpolate", "value_ray", slot, "ray of that value"),
        wire("interpolate", "value", w.data, "the value"),
        wire("interpolate", "gradient_x", gradient, "gradient along x"),
        wire("interpolate", "gradient_y", gradient, "gradient along y"),
        wire("interpolate", "gradient_z", gradient, "gradient along z"),
        wire("classify", "opacity_valid", 1, "a classified sample"),
        wire("classify", "opacity_ray", slot, "ray of that sample"),
        wire("classify", "opacity", w.data, "its opacity"),
        wire("absorb", "weight_valid", 1, "a visible sample"),
        wire("absorb", "weight_ray", slot, "ray of that sample"),
        wire(
            "absorb",
            "weight",
            w.transmittance,
            "opacity times light that passes",
        ),
        wire("absorb", "terminate_valid", 1, "a ray is to end"),
        wire("absorb", "terminate_ray", slot, "number of that ray"),
        wire("shade", "light_valid", 1, "a lit sample"),
        wire("shade", "light_ray", slot, "ray of that sample"),
        wire("shade", "light", w.intensity, "reflected light"),
    ]
}
