//! The ray loop that functions are linked into.

use crate::link::Skeleton;

/// How the texture of a volume is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Texels {
    /// `texture_3d<f32>`: 32- and 16-bit float, 8- and 16-bit unorm; the texture unit interpolates.
    Float,
    /// `texture_3d<u32>`.
    Unsigned,
    /// `texture_3d<i32>`.
    Signed,
}

/// Edge of a brick of the occupancy texture, in voxels.
pub const BRICK_VOXELS: u32 = 8;

/// Entries in a row of the transfer table's texture.
pub const TABLE_ROW: u32 = 4096;

/// The ray loop over one volume with these texels. Its uniform block `Frame` is bound at group 0,
/// binding 0; 2 the volume, 3 its sampler, 4 the transfer table, 5 the bricks.
pub fn ray_loop(texels: Texels) -> Skeleton {
    let (name, volume) = match texels {
        Texels::Float => ("float", include_str!("../skeleton/volume_float.wgsl")),
        Texels::Unsigned => ("unsigned", include_str!("../skeleton/volume_unsigned.wgsl")),
        Texels::Signed => ("signed", include_str!("../skeleton/volume_signed.wgsl")),
    };
    Skeleton {
        name: format!("ray loop over a {name} texture"),
        wgsl: format!("{}{volume}", include_str!("../skeleton/march.wgsl")).into(),
    }
}
