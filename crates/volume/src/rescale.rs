//! What a stored number means.

/// value = slope · stored + intercept. A value is what the user means: HU for CT.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rescale {
    /// Finite and not 0.
    pub slope: f64,
    /// Finite.
    pub intercept: f64,
}

impl Rescale {
    /// Stored numbers are values.
    pub const IDENTITY: Rescale = Rescale {
        slope: 1.0,
        intercept: 0.0,
    };

    /// A rescale; a slope that is 0 or not finite means identity (files in the wild have both),
    /// an intercept that is not finite means 0.
    pub fn new(slope: f64, intercept: f64) -> Rescale {
        if slope == 0.0 || !slope.is_finite() {
            return Rescale::IDENTITY;
        }
        Rescale {
            slope,
            intercept: if intercept.is_finite() {
                intercept
            } else {
                0.0
            },
        }
    }

    /// The value of a stored number.
    #[inline]
    pub fn value(&self, stored: f64) -> f64 {
        self.slope * stored + self.intercept
    }

    /// The stored number (not rounded) of a value.
    #[inline]
    pub fn stored(&self, value: f64) -> f64 {
        (value - self.intercept) / self.slope
    }
}
