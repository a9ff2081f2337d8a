//! How far the rays of a picture have come.

use crate::error::Error;
use crate::lanes::{LANES, PACKET, lanes};
use crate::raster::Raster;
use crate::ray_state::RayState;
use strahl_scene::plan::Plan;

/// How far each ray of a picture has come.
#[derive(Clone, Debug, PartialEq)]
pub struct RayStates {
    size: [usize; 2],
    frames: usize,
    states: Vec<RayState>,
}

impl RayStates {
    /// Rays of a picture of `plan` that have all come as far as `state` says.
    pub(crate) fn new(plan: &Plan, state: RayState) -> RayStates {
        let size = Raster::ALL.size(plan);
        let frames = plan.lattice.frames as usize;
        RayStates {
            size,
            frames,
            states: vec![state; size[0] * size[1] * frames],
        }
    }

    /// Row by row from the top; of each pixel one ray per frame of the Plan.
    pub fn states(&self) -> &[RayState] {
        &self.states
    }

    /// The same, to be replaced by what was computed elsewhere for the same Plan.
    pub fn states_mut(&mut self) -> &mut [RayState] {
        &mut self.states
    }

    /// Number of rays of each pixel.
    pub(crate) fn frames(&self) -> usize {
        self.frames
    }

    /// Those of the block of pixels with its corner at column `x`, row `y`, as far as it lies left of and above those of
    /// `end`, in picture number `frame`.
    pub(crate) fn of_packet(
        &self,
        [x, y]: [u32; 2],
        end: [u32; 2],
        frame: u32,
    ) -> [RayState; LANES] {
        let width = self.size[0];
        let end = end.map(|end| end as usize);
        lanes(|lane| {
            let (x, y) = (x as usize + lane % PACKET[0], y as usize + lane / PACKET[0]);
            if x < end[0] && y < end[1] {
                self.states[(y * width + x) * self.frames + frame as usize]
            } else {
                RayState::default()
            }
        })
    }

    /// That they belong to such a Plan.
    pub(crate) fn check(&self, plan: &Plan) -> Result<(), Error> {
        let size = Raster::ALL.size(plan);
        let frames = plan.lattice.frames as usize;
        if (self.size, self.frames) == (size, frames) {
            return Ok(());
        }
        let rays = |[width, height]: [usize; 2], frames| [width, height, frames];
        Err(Error::OtherRays {
            plan: rays(size, frames),
            states: rays(self.size, self.frames),
        })
    }
}
