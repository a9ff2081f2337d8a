//! What programs are made for, and every renderer keeps to.

/// Objects, and volumes, in one ray loop.
pub const MOST_OBJECTS: usize = 8;

/// Masks in one ray loop.
pub const MOST_MASKS: usize = 4;

/// Edge of a brick of the occupancy texture, in voxels.
pub const BRICK_VOXELS: u32 = 8;
