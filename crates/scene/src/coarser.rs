//! Coarser pictures of the same scene, for when the camera moves.

use crate::plan::{Lattice, Plan};

impl Plan {
    /// The same picture with `n` times fewer columns and rows (as far as they divide; at least one), steps `n` times
    /// as long, and one frame: n³ times fewer samples. For pictures that follow a hand; n = 2 looks at an eighth of
    /// the samples, 1 and 0 change nothing but the number of frames.
    #[must_use]
    pub fn coarser(&self, n: u32) -> Plan {
        let n = n.max(1);
        let fewer = |pixels: u32| ((pixels + n / 2) / n).max(1);
        Plan {
            width: fewer(self.width),
            height: fewer(self.height),
            lattice: Lattice {
                step_mm: self.lattice.step_mm * f64::from(n),
                frames: 1,
                ..self.lattice
            },
            ..self.clone()
        }
    }
}
