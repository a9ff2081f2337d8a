use super::Surface;
use crate::lanes::F32s;

/// The value itself as grey and as opacity; NaN is nothing.
#[inline(always)]
pub fn at(value: F32s, black: f32, white: f32) -> Surface {
    let share = (value - F32s::splat(black)).over(F32s::splat(white - black));
    let grey = share.max(F32s::ZERO).min(F32s::splat(1.0));
    Surface {
        colour: [grey; 3],
        opacity: grey,
    }
}

/// The same above a threshold, nothing up to it.
#[inline(always)]
pub fn above(value: F32s, threshold: f32, black: f32, white: f32) -> Surface {
    let above = F32s::splat(threshold).lt(value);
    let Surface { colour, opacity } = at(value, black, white);
    Surface {
        colour: colour.map(|c| above.select(c, F32s::ZERO)),
        opacity: above.select(opacity, F32s::ZERO),
    }
}
