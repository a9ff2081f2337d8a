//! Single slots over many packets, for benches (feature `bench-kernels`): no part of what this crate promises.

pub mod layout;

use crate::error::Error;
use crate::lanes::{F32s, LANES, Vec3s, dot};
use crate::levels::{InstructionSet, Level, Task, dispatch, vectorized};
use crate::library::reconstruct::values;
use crate::scenery::{Known, Object};
use strahl_scene::plan::Plan;
use strahl_volume::Volume;

/// Samples of one packet: x, y, z (voxel space) of each.
pub type Packet = [[f32; LANES]; 3];

/// A slot, with those that it calls.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kernel {
    /// Fetch, reconstruct and rescale.
    Reconstruct,
    /// Gradient, of values that are reconstructed.
    Gradient,
    /// Classify; the value of a sample is its x, so that nothing is reconstructed that need not be.
    Classify,
}

/// The instructions that `STRAHL_SIMD` says, or the fastest that the CPU has.
///
/// # Errors
/// It names none that there is.
pub fn instructions() -> Result<InstructionSet, Error> {
    InstructionSet::from_environment()
}

/// Runs `kernel` as `plan` chooses it, on its first object, which shows `volume`; the sum of what comes of it, so that nothing is
/// left out.
///
/// # Panics
/// If the Plan is not that of the volume.
pub fn run(
    kernel: Kernel,
    set: InstructionSet,
    plan: &Plan,
    volume: &Volume,
    packets: &[Packet],
) -> f32 {
    assert_eq!(plan.field().grid, *volume.grid(), "of another volume");
    let running = Running {
        kernel,
        plan,
        volume,
        packets,
    };
    dispatch(set, running)
}

struct Running<'k> {
    kernel: Kernel,
    plan: &'k Plan,
    volume: &'k Volume,
    packets: &'k [Packet],
}

impl Task for Running<'_> {
    type Output = f32;

    fn run<S: Level>(self) -> f32 {
        let (plan, volume) = (self.plan, self.volume);
        let samples = volume.samples();
        let rescale = plan.field().rescale;
        let values = values::<S>(volume.grid(), samples, rescale, plan.field().reconstruct);
        let object = Object::new(
            plan,
            0,
            plan.technique(),
            &*values,
            None,
            &[],
            Known::default(),
        );
        vectorized::<S, _>(
            #[inline(always)]
            || {
                let all = F32s::<S>::zero().le(F32s::zero());
                let mut sum = F32s::<S>::zero();
                for packet in self.packets {
                    let [x, y, z] = *packet;
                    let position: Vec3s<S> = [
                        F32s::from_array(x),
                        F32s::from_array(y),
                        F32s::from_array(z),
                    ];
                    sum += match self.kernel {
                        Kernel::Reconstruct => object.values.at(position),
                        Kernel::Gradient => {
                            let gradient = object.gradient(position, all);
                            dot(gradient, gradient)
                        }
                        Kernel::Classify => {
                            let surface = object.classify(position[0], position, all);
                            surface.color[0] + surface.opacity
                        }
                    };
                }
                (0..LANES).map(|lane| sum.lane(lane)).sum()
            },
        )
    }
}
