use crate::doubles::F64s;
use crate::levels::Level;

/// Cuts to what lies before opaque geometry at `opaque_mm`; an occluder before the entry leaves
/// nothing.
#[inline(always)]
pub fn clip<S: Level>(opaque_mm: F64s<S>, [t0, t1]: [F64s<S>; 2]) -> [F64s<S>; 2] {
    [t0, t1.min(opaque_mm)]
}
