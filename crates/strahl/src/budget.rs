//! How much memory and time a picture may take.

use crate::Error;
use crate::backend::Backend;
use crate::estimate::{Estimate, Speed, picture_bytes};
use std::fs;
use strahl_scene::plan::Plan;
use strahl_volume::Datasets;

/// How much a picture may take. What needs more is refused before it is drawn, with what to change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Budget {
    /// Bytes of memory: data, what is made of it, the picture.
    pub memory_bytes: u64,
    /// Seconds of drawing, as far as they can be told before; the other part is for [`Control`](crate::Control).
    pub seconds: f64,
}

/// Longer, and nobody waits for what may be a slip of the pen.
const USUAL_SECONDS: f64 = 1800.0;

impl Budget {
    /// Everything that is asked for.
    pub const UNLIMITED: Budget = Budget {
        memory_bytes: u64::MAX,
        seconds: f64::INFINITY,
    };

    /// Half an hour, and the memory that the system says there is for this process now, with what it has already
    /// (without limit where the system does not say).
    pub fn of_machine() -> Budget {
        Budget {
            memory_bytes: memory_bytes_there().unwrap_or(u64::MAX),
            seconds: USUAL_SECONDS,
        }
    }

    /// Whether `plan` can be drawn from `data` within it.
    pub(crate) fn check(
        &self,
        plan: &Plan,
        data: &Datasets,
        backend: &Backend,
        is_evaluated: bool,
        threads: usize,
    ) -> Result<(), Error> {
        let speed = match backend {
            Backend::Gpu { .. } => Speed::Graphics,
            _ if is_evaluated || !plan.modules.is_empty() => Speed::Evaluated { threads },
            _ => Speed::Processor { threads },
        };
        let estimate = Estimate::of(plan, data, speed);
        if estimate.memory_bytes > self.memory_bytes {
            return Err(Error::TooMuchMemory {
                bytes: estimate.memory_bytes,
                most_bytes: self.memory_bytes,
                size: [plan.width, plan.height],
            });
        }
        if estimate.seconds > self.seconds {
            return Err(Error::TooMuchTime {
                estimate: Box::new(estimate),
                most_seconds: self.seconds,
                size: [plan.width, plan.height],
                step_mm: plan.lattice.step_mm,
                frames: plan.lattice.frames,
            });
        }
        room_for(picture_bytes(plan))
    }
}

impl Default for Budget {
    fn default() -> Budget {
        Budget::of_machine()
    }
}

/// Whether the system has room for as many bytes at once; they are given back.
fn room_for(bytes: u64) -> Result<(), Error> {
    let reserved = usize::try_from(bytes)
        .ok()
        .map(|number| Vec::<u8>::new().try_reserve_exact(number));
    match reserved {
        Some(Ok(())) => Ok(()),
        _ => Err(Error::NoMemory { bytes }),
    }
}

/// What Linux says of the memory that there is for this process, with what it has already.
fn memory_bytes_there() -> Option<u64> {
    let number = |file: &str, line: &str, word: usize| -> Option<u64> {
        let text = fs::read_to_string(file).ok()?;
        let line = text.lines().find(|text| text.starts_with(line))?;
        line.split_whitespace().nth(word)?.parse().ok()
    };
    let left = number("/proc/meminfo", "MemAvailable:", 1);
    let own = number("/proc/self/status", "VmRSS:", 1).unwrap_or(0);
    let machine = left.map(|kibibytes| (kibibytes + own).saturating_mul(1024));
    // A word that is no number says that there is no limit.
    let process = number("/proc/self/limits", "Max address space", 3);
    machine.into_iter().chain(process).min()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Phantom, Render};

    #[test]
    fn what_takes_too_long_or_too_much_is_refused_with_what_to_change() {
        let render = Render::phantom(Phantom::Tree).size(64, 48).budget(Budget {
            seconds: 0.0,
            ..Budget::UNLIMITED
        });
        let said = render.picture().unwrap_err().to_string();
        for part in ["64 × 48", "step", "limit"] {
            assert!(said.contains(part), "{said}");
        }
        // 128³ voxels of a byte: no room for them, or for nothing beside them.
        let with = |memory_bytes: u64| Budget {
            memory_bytes,
            ..Budget::UNLIMITED
        };
        let render = render.budget(with(10_000));
        let said = render.picture().unwrap_err().to_string();
        assert!(
            said.contains("2097152 bytes") && said.contains("10000 bytes"),
            "{said}"
        );
        let render = render.budget(with(2_100_000));
        let said = render.picture().unwrap_err().to_string();
        assert!(
            said.contains("2.0 MiB") && said.contains("64 × 48"),
            "{said}"
        );
        render.budget(Budget::UNLIMITED).picture().unwrap();
        let said = room_for(u64::MAX / 4).unwrap_err().to_string();
        assert!(said.contains("no memory for"), "{said}");
    }
}
