/// What a packet of rays has cost.
#[derive(Clone, Copy, Default)]
pub struct Counts {
    /// Lattice points of all rays.
    pub points: u64,
    /// Of these, how many were reconstructed …
    pub samples: u64,
    /// … how many of those changed the pixel …
    pub visible: u64,
    /// … and how many points bricks left out.
    pub skipped: u64,
    /// Rays with at least one lattice point.
    pub rays_in_volume: u64,
    /// Rays that ended before their last lattice point.
    pub ended_early: u64,
}

impl Counts {
    /// Those of both.
    pub fn plus(self, other: Counts) -> Counts {
        Counts {
            points: self.points + other.points,
            samples: self.samples + other.samples,
            visible: self.visible + other.visible,
            skipped: self.skipped + other.skipped,
            rays_in_volume: self.rays_in_volume + other.rays_in_volume,
            ended_early: self.ended_early + other.ended_early,
        }
    }
}
