//! Slot illuminate: the light that a surface sends to the eye from one light.
//!
//! All vectors have length 1. Diffuse parts are multiplied by the surface color, highlights are
//! white; there is nothing where the light comes from behind, except for `tone`, whose tones have colors of their own, and
//! for `blinn_phong_two_sided`.

mod surface;

use crate::lanes::{F32s, Vec3s, dot, each};
use crate::levels::Level;
use strahl_scene::plan::{Illuminate, for_each_function};
use surface::Surface;

/// A file per model of the registry, each with a function `parts` of the surface and the model's parameters.
macro_rules! models {
    ($(; $meaning:literal $variant:ident $name:ident $word:literal { $($field:ident),* })*) => {
        $(mod $name;)*

        /// What is multiplied by the surface color, and the highlight.
        #[inline(always)]
        fn parts<S: Level>(model: Illuminate, surface: &Surface<S>) -> (F32s<S>, F32s<S>) {
            match model {
                $(Illuminate::$variant { $($field),* } => $name::parts(surface, $($field),*),)*
            }
        }
    };
}

for_each_function! { Illuminate => models! {} }

/// What one light does to a surface.
#[inline(always)]
pub fn illuminate<S: Level>(
    model: Illuminate,
    color: Vec3s<S>,
    normal: Vec3s<S>,
    to_eye: Vec3s<S>,
    to_light: Vec3s<S>,
    radiance: Vec3s<S>,
) -> Vec3s<S> {
    let cosine = dot(normal, to_light);
    let lit = F32s::zero().lt(cosine);
    let cosine = cosine.max(F32s::zero());
    let surface = Surface {
        normal,
        to_eye,
        to_light,
        cosine,
    };
    let (diffuse, highlight) = parts(model, &surface);
    if let Illuminate::Tone {
        diffuse: share,
        cool,
        warm,
        ..
    } = model
    {
        let tint = tone::tint(&surface, share, cool, warm);
        return each!([0, 1, 2], |c| radiance[c] * (diffuse * color[c] + tint[c]));
    }
    let highlight = match model {
        Illuminate::BlinnPhongTwoSided { .. } => highlight,
        _ => lit.select(highlight, F32s::zero()),
    };
    each!([0, 1, 2], |c| {
        radiance[c] * (diffuse * color[c] + highlight)
    })
}
