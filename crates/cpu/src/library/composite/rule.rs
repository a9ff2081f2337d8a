use super::state::State;
use super::visible_values::VisibleValues;
use crate::doubles::F64s;
use crate::lanes::{F32s, Mask, Vec3s, each, scale};
use crate::levels::{Level, vectorized};
use crate::library::classify::Surface;
use crate::line::Line;
use crate::ray_packet::RayPacket;
use crate::scenery::{Look, Object, Scenery};

/// How the samples of a ray become a pixel, for a packet of rays: the composite functions of shaders, lane by lane.
pub trait Rule: Copy {
    /// Whether samples come from the last lattice point to the first.
    fn is_back_to_front(&self) -> bool {
        false
    }

    /// Whether what is seen lies at one place of the ray, which the depth of a picture is.
    fn has_depth(&self) -> bool {
        false
    }

    /// Which samples can change a ray, by their values; the others need not be reconstructed.
    fn sees(&self) -> VisibleValues {
        VisibleValues::Every
    }

    /// Rays without samples.
    #[inline(always)]
    fn start<S: Level>(&self) -> State<S> {
        State::start(0.0)
    }

    /// Whether it asks how opaque all is that lies before a run of segments.
    #[inline(always)]
    fn is_covered_by_ray(&self) -> bool {
        false
    }

    /// Runs without samples, of which something of this opacity lies before each.
    #[inline(always)]
    fn start_behind<S: Level>(&self, _opacity: F32s<S>) -> State<S> {
        self.start()
    }

    /// Adds a sample of the rays that it was taken of; says of which of them it showed something.
    fn add<S: Level>(&self, state: &mut State<S>, sample: &Sample<S>) -> Mask<S>;

    /// Which rays need no more.
    #[inline(always)]
    fn done<S: Level>(&self, _state: &State<S>) -> Mask<S> {
        Mask::none()
    }

    /// Makes the color and the opacity of what the rays have kept.
    #[inline(always)]
    fn finish<S: Level>(&self, _state: &mut State<S>, _rays: &Crossing<S>) {}
}

/// The rays of a packet, and what they go through.
#[derive(Clone, Copy)]
pub struct Crossing<'s, S: Level> {
    pub scenery: &'s Scenery<'s, S>,
    /// What is drawn of them.
    pub object: &'s Object<'s, S>,
    pub packet: &'s RayPacket<S>,
    /// Unit vectors.
    pub to_eye: &'s Vec3s<S>,
}

impl<'s, S: Level> Crossing<'s, S> {
    /// The lattice in the volume of rules that belong to one.
    #[inline(always)]
    pub fn line(&self) -> &'s Line<S> {
        &self.packet.lines[0]
    }

    /// How far a lattice coordinate is from the start of each ray.
    #[inline(always)]
    pub fn distance_mm(&self, place: F32s<S>) -> F32s<S> {
        let step_mm = F64s::splat(self.scenery.plan.lattice.step_mm);
        (self.packet.entry_mm + F64s::from_single(place) * step_mm).to_single()
    }

    /// Slot shade, of that volume.
    #[inline(always)]
    pub fn shade(
        &self,
        surface: Surface<S>,
        position: Vec3s<S>,
        shaded: Mask<S>,
        last_normal: &mut Vec3s<S>,
    ) -> Surface<S> {
        self.object
            .shade(surface, position, *self.to_eye, shaded, last_normal)
    }

    /// `value` at the place of each ray's state classified and shaded once, nothing where none was `found`.
    #[inline(never)]
    pub fn classify_once(&self, state: &mut State<S>, value: F32s<S>, found: Mask<S>) {
        vectorized::<S, _>(
            #[inline(always)]
            || {
                let position = self.line().position(state.place);
                let mut surface = self.object.classify(value, position, found);
                if !self.object.shading.is_unlit() {
                    surface = self.shade(surface, position, found, &mut state.last_normal);
                }
                let alpha = found.select(surface.opacity, F32s::zero());
                state.color = scale(surface.color, alpha);
                state.alpha = alpha;
            },
        );
    }
}

/// A sample of each ray.
pub struct Sample<'s, S: Level> {
    /// Of the volume that it was taken of.
    pub crossing: Crossing<'s, S>,
    /// Number of the lattice point.
    pub k: F32s<S>,
    /// For how many lattice points it stands.
    pub stride: F32s<S>,
    /// In voxel space.
    pub position: Vec3s<S>,
    pub value: F32s<S>,
    /// Where there is one.
    pub sampled: Mask<S>,
}

impl<S: Level> Sample<'_, S> {
    /// The lattice coordinate.
    #[inline(always)]
    pub fn place(&self) -> F32s<S> {
        self.k + self.crossing.packet.jitter
    }

    /// Color, and opacity of one step.
    #[inline(always)]
    pub fn look(&self, last_normal: &mut Vec3s<S>) -> Look<S> {
        self.crossing.object.look(
            self.value,
            self.position,
            *self.crossing.to_eye,
            self.sampled,
            last_normal,
        )
    }

    /// The same, and the gradient where something is visible, which is asked for once.
    #[inline(always)]
    pub fn look_and_gradient(&self, last_normal: &mut Vec3s<S>) -> (Look<S>, Vec3s<S>) {
        let object = self.crossing.object;
        let mut surface = object.classify(self.value, self.position, self.sampled);
        let visible = self.sampled & F32s::zero().lt(surface.opacity);
        let mut gradient = [F32s::zero(); 3];
        if visible.any() {
            gradient = self.gradient(visible);
            if !object.shading.is_unlit() {
                surface = self.shade_by(surface, gradient, visible, last_normal);
            }
            surface.opacity = object.of_step(surface.opacity);
        }
        (Look { surface, visible }, gradient)
    }

    /// Slot shade, for a gradient that is known.
    #[inline(always)]
    pub fn shade_by(
        &self,
        surface: Surface<S>,
        gradient: Vec3s<S>,
        shaded: Mask<S>,
        last_normal: &mut Vec3s<S>,
    ) -> Surface<S> {
        let crossing = &self.crossing;
        let (position, to_eye) = (self.position, *crossing.to_eye);
        let object = crossing.object;
        object.shade_by(surface, gradient, position, to_eye, shaded, last_normal)
    }

    /// Slot illustrate, for a gradient that is known.
    #[inline(always)]
    pub fn illustrate(&self, color: Vec3s<S>, gradient: Vec3s<S>, shaded: Mask<S>) -> Vec3s<S> {
        let object = self.crossing.object;
        match object.shading.is_illustrated() {
            true => {
                let (position, to_eye) = (self.position, *self.crossing.to_eye);
                object.illustrate(color, gradient, [position; 2], to_eye, shaded)
            }
            false => color,
        }
    }

    /// The gradient where `asked`; anything elsewhere.
    #[inline(always)]
    pub fn gradient(&self, asked: Mask<S>) -> Vec3s<S> {
        self.crossing.object.gradient(self.position, asked)
    }

    /// Where it is classified as anything.
    #[inline(always)]
    pub fn shown(&self) -> Mask<S> {
        let surface = self
            .crossing
            .object
            .classify(self.value, self.position, self.sampled);
        self.sampled & F32s::zero().lt(surface.opacity)
    }

    /// The position as a color: 0 to 1 over the extent along each axis.
    #[inline(always)]
    pub fn position_color(&self) -> Vec3s<S> {
        let last = self.crossing.object.values.shape().last;
        let (half, one) = (F32s::splat(0.5), F32s::splat(1.0));
        each!([0, 1, 2], |axis| {
            let share = (self.position[axis] + half).over(F32s::splat(last[axis] + 1.0));
            share.max(F32s::zero()).min(one)
        })
    }
}
