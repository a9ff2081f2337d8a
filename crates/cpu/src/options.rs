//! What a picture is drawn with, and does not change it.

use crate::error::Error;
use crate::levels::{InstructionSet, Task, dispatch};
use crate::pools::Pool;

/// What does not change a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// Number of threads; 0 means the surrounding rayon pool, by default all cores.
    pub threads: usize,
    /// Edge of a tile in pixels, > 0.
    pub tile: u32,
    /// Whether bricks that cannot show anything are left out, and rays that meet no volume.
    pub skip: bool,
    /// The instructions to draw with; `None` takes what `STRAHL_SIMD` says, or the fastest that the
    /// processor has.
    pub instructions: Option<InstructionSet>,
}

impl Default for Options {
    fn default() -> Options {
        Options {
            threads: 0,
            tile: 32,
            skip: true,
            instructions: None,
        }
    }
}

impl Options {
    /// Runs `task` with these instructions, in `pool` or else the surrounding one.
    pub(crate) fn run<T, R>(&self, pool: Option<&Pool>, task: T) -> Result<R, Error>
    where
        T: Task<Output = Result<R, Error>> + Send,
        R: Send,
    {
        let set = match self.instructions {
            Some(set) => set,
            None => InstructionSet::from_environment()?,
        };
        if !set.is_there() {
            return Err(Error::NoSuchInstructions {
                value: set.to_string(),
            });
        }
        match pool {
            Some(pool) => pool.install(|| dispatch(set, task)),
            None => dispatch(set, task),
        }
    }
}
