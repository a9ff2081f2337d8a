/// Which samples a rule of compositing sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum VisibleValues {
    /// Whatever their values are.
    Every,
    /// Those whose values are classified as anything.
    Shown,
    /// Those with values from this one on.
    From(f32),
    /// Those with values larger than all before.
    Larger,
    /// Those with values smaller than all before.
    Smaller,
}

impl VisibleValues {
    /// Whether one value is kept of each ray, the largest or the smallest.
    pub fn is_extreme(self) -> bool {
        matches!(self, VisibleValues::Larger | VisibleValues::Smaller)
    }
}
