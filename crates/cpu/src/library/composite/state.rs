use crate::lanes::{F32s, Mask, Vec3s};
use crate::levels::Level;

/// What a rule remembers along the rays; each uses what it needs.
#[derive(Clone, Copy)]
pub struct State<S: Level> {
    /// Premultiplied.
    pub color: Vec3s<S>,
    /// Opacity so far.
    pub alpha: F32s<S>,
    /// The value so far (largest, smallest, sum).
    pub value: F32s<S>,
    /// Lattice coordinate at which that value, or the hit, lies.
    pub place: F32s<S>,
    /// What rounding has lost from a sum.
    pub lost: F32s<S>,
    /// Number of samples added.
    pub number: F32s<S>,
    /// The last normal of each ray, 0 if there was none.
    pub last_normal: Vec3s<S>,
}

impl<S: Level> State<S> {
    /// A ray without samples, `value` so far.
    #[inline(always)]
    pub fn start(value: f32) -> State<S> {
        State {
            color: [F32s::zero(); 3],
            alpha: F32s::zero(),
            value: F32s::splat(value),
            place: F32s::zero(),
            lost: F32s::zero(),
            number: F32s::zero(),
            last_normal: [F32s::zero(); 3],
        }
    }

    /// `yes` where `mask` says so, `no` elsewhere.
    #[inline(always)]
    pub fn select(mask: Mask<S>, yes: &State<S>, no: &State<S>) -> State<S> {
        State {
            color: mask.select3(yes.color, no.color),
            alpha: mask.select(yes.alpha, no.alpha),
            value: mask.select(yes.value, no.value),
            place: mask.select(yes.place, no.place),
            lost: mask.select(yes.lost, no.lost),
            number: mask.select(yes.number, no.number),
            last_normal: mask.select3(yes.last_normal, no.last_normal),
        }
    }

    /// Keeps `value` at lattice coordinate `place` where `better`, and counts the `sampled`.
    #[inline(always)]
    pub fn keep(&mut self, better: Mask<S>, sampled: Mask<S>, value: F32s<S>, place: F32s<S>) {
        self.value = better.select(value, self.value);
        self.place = better.select(place, self.place);
        self.number = sampled.select(F32s::splat(1.0), self.number);
    }

    /// An opaque color where `hit`.
    #[inline(always)]
    pub fn paint(&mut self, hit: Mask<S>, color: Vec3s<S>) {
        self.color = hit.select3(color, self.color);
        self.alpha = hit.select(F32s::splat(1.0), self.alpha);
    }
}
