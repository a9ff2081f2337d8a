//! Slot shade: the look of a classified sample.

mod lit;
mod place;

pub use place::Place;

use crate::lanes::{F32s, Mask, Vec3s};
use crate::levels::Level;
use crate::library::classify::Surface;
use crate::library::light::Light;
use strahl_scene::plan::{Illustrate, Plan, Shade, Technique, for_each_function};

/// A file per function of the registry that the Plan has a variant for, each with a function `look` of the surface, its place
/// and the function's parameters.
macro_rules! functions {
    ($(; $meaning:literal $variant:ident $name:ident $word:literal { $($field:ident),* })*) => {
        $(mod $name;)*

        /// The look of `surface` by one of them.
        #[inline(always)]
        fn look_otherwise<S: Level>(
            model: Shade,
            surface: Surface<S>,
            place: &Place<S, impl Fn() -> Vec3s<S>, impl Fn() -> Vec3s<S>>,
        ) -> Surface<S> {
            match model {
                Shade::Unlit | Shade::Lit { .. } => surface,
                $(Shade::$variant { $($field),* } => $name::look(surface, place, $($field),*),)*
            }
        }
    };
}

for_each_function! { Shade => functions! {} }

/// How samples are shaded and illustrated.
pub struct Shading {
    model: Shade,
    lights: Vec<Light>,
    /// What follows the light.
    pub illustration: Illustrate,
    illustrates_by_gradient: bool,
}

impl Shading {
    /// That of `technique` under the lights of `plan`.
    pub fn new(technique: &Technique, plan: &Plan) -> Shading {
        let illustration = technique.illustrate;
        let function = illustration.function();
        Shading {
            model: technique.shade,
            lights: Light::all(plan),
            illustration,
            illustrates_by_gradient: function.is_some_and(|f| f.text.contains("gradient(")),
        }
    }

    /// Whether surfaces look as they are classified.
    #[inline(always)]
    pub fn is_unlit(&self) -> bool {
        matches!(self.model, Shade::Unlit) && !self.is_illustrated()
    }

    /// Whether illustration changes what shading has made.
    #[inline(always)]
    pub fn is_illustrated(&self) -> bool {
        !matches!(self.illustration, Illustrate::Plain)
    }

    /// Whether it does so by the gradient.
    #[inline(always)]
    pub fn is_illustrated_by_gradient(&self) -> bool {
        self.illustrates_by_gradient
    }

    /// Whether a sample's shading asks for nothing of earlier ones, and leaves its opacity as it is.
    pub fn is_of_single_samples(&self) -> bool {
        match self.model {
            Shade::Unlit => true,
            Shade::Lit {
                keep_last_normal, ..
            } => !keep_last_normal,
            _ => false,
        }
    }

    /// The look of `surface` towards the eye. `last_normal` is the last normal of each ray that is
    /// `shaded`; 0 if there was none yet.
    #[inline(always)]
    pub fn look<S: Level>(
        &self,
        surface: Surface<S>,
        place: &Place<S, impl Fn() -> Vec3s<S>, impl Fn() -> Vec3s<S>>,
        shaded: Mask<S>,
        last_normal: &mut Vec3s<S>,
    ) -> Surface<S> {
        match self.model {
            Shade::Unlit => surface,
            Shade::Lit {
                ambient,
                illuminate,
                keep_last_normal,
            } => {
                let mut unkept = [F32s::zero(); 3];
                let last_normal = if keep_last_normal {
                    last_normal
                } else {
                    &mut unkept
                };
                let color = lit::color(
                    &self.lights,
                    illuminate,
                    ambient,
                    surface.color,
                    place,
                    shaded,
                    last_normal,
                );
                Surface { color, ..surface }
            }
            model => look_otherwise(model, surface, place),
        }
    }
}
