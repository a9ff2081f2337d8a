//! How long something takes.

/// Runs from its start on. In builds without the feature `clock`, for where there is no clock that could be asked, it says
/// that no time has gone.
#[derive(Clone, Copy, Debug)]
pub struct Stopwatch {
    #[cfg(feature = "clock")]
    start: std::time::Instant,
}

impl Stopwatch {
    /// One that is started now.
    pub fn start() -> Stopwatch {
        Stopwatch {
            #[cfg(feature = "clock")]
            start: std::time::Instant::now(),
        }
    }

    /// Seconds since then.
    pub fn seconds(&self) -> f64 {
        #[cfg(feature = "clock")]
        {
            self.start.elapsed().as_secs_f64()
        }
        #[cfg(not(feature = "clock"))]
        0.0
    }
}
