use crate::lanes::{Affine, F32s, Mask, Vec3s};

/// A box of any orientation; what lies exactly on its faces is inside.
pub struct Box {
    /// Voxel space → the cube from −0.5 to 0.5.
    pub unit_from_voxel: Affine,
    /// Whether the inside is kept (else the outside).
    pub keep_inside: bool,
}

impl Box {
    #[inline(always)]
    pub fn keep(&self, position: Vec3s) -> Mask {
        let unit = self.unit_from_voxel.point(position);
        let half = F32s::splat(0.5);
        let inside = unit[0].abs().le(half) & unit[1].abs().le(half) & unit[2].abs().le(half);
        if self.keep_inside { inside } else { !inside }
    }
}
