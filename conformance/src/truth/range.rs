//! Intervals: what a number may be once single precision has rounded on the way to it.

/// The numbers from `lo` to `hi`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// The smallest.
    pub lo: f64,
    /// The largest.
    pub hi: f64,
}

impl Range {
    /// No number.
    pub const EMPTY: Range = Range {
        lo: f64::INFINITY,
        hi: f64::NEG_INFINITY,
    };

    /// One number.
    pub fn exactly(number: f64) -> Range {
        Range {
            lo: number,
            hi: number,
        }
    }

    /// The numbers of both and those between.
    pub fn hull(self, other: Range) -> Range {
        Range {
            lo: self.lo.min(other.lo),
            hi: self.hi.max(other.hi),
        }
    }

    /// `by` more on either side.
    pub fn widened(self, by: f64) -> Range {
        Range {
            lo: self.lo - by,
            hi: self.hi + by,
        }
    }

    /// Cut to 0 … 1.
    pub fn clamped_to_unit(self) -> Range {
        Range {
            lo: self.lo.clamp(0.0, 1.0),
            hi: self.hi.clamp(0.0, 1.0),
        }
    }

    /// The middle.
    pub fn middle(self) -> f64 {
        0.5 * (self.lo + self.hi)
    }

    /// Half the width.
    pub fn half_width(self) -> f64 {
        0.5 * (self.hi - self.lo)
    }
}

/// What a pixel may be: linear, premultiplied RGBA.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds(pub [Range; 4]);

impl Bounds {
    /// Every color.
    pub const ANYTHING: Bounds = Bounds(
        [Range {
            lo: f64::NEG_INFINITY,
            hi: f64::INFINITY,
        }; 4],
    );

    /// One color.
    pub fn exactly(rgba: [f64; 4]) -> Bounds {
        Bounds(rgba.map(Range::exactly))
    }

    /// The colors of both and those between.
    pub fn hull(self, other: Bounds) -> Bounds {
        Bounds(std::array::from_fn(|c| self.0[c].hull(other.0[c])))
    }

    /// A material of `opacity` with `color` (not premultiplied) in front of this: the "over" rule.
    pub fn under(self, opacity: Range, color: [Range; 3]) -> Bounds {
        Bounds(std::array::from_fn(|c| {
            let front = color.get(c).copied().unwrap_or(Range::exactly(1.0));
            let back = self.0[c];
            // For one opacity a larger color gives more; for one pair of colors the result is
            // linear in the opacity, so that its ends are at ends.
            let over = |a: f64, front: f64, back: f64| a * front + (1.0 - a) * back;
            Range {
                lo: over(opacity.lo, front.lo, back.lo).min(over(opacity.hi, front.lo, back.lo)),
                hi: over(opacity.lo, front.hi, back.hi).max(over(opacity.hi, front.hi, back.hi)),
            }
        }))
    }

    /// The middles.
    pub fn middle(self) -> [f64; 4] {
        self.0.map(Range::middle)
    }

    /// Half the width of the widest channel.
    pub fn doubt(self) -> f64 {
        self.0.iter().map(|r| r.half_width()).fold(0.0, f64::max)
    }

    /// How far outside `pixel` lies, in its worst channel; 0 inside, infinite for NaN.
    pub fn distance(self, pixel: [f32; 4]) -> f64 {
        let mut worst: f64 = 0.0;
        for (range, channel) in self.0.iter().zip(pixel) {
            let channel = f64::from(channel);
            if !channel.is_finite() {
                return f64::INFINITY;
            }
            worst = worst.max(range.lo - channel).max(channel - range.hi);
        }
        worst
    }
}
