use super::blinn_phong::highlight;
use super::surface::Surface;
use crate::lanes::{F32s, dot};
use crate::levels::Level;

/// As `blinn_phong`, with absolute values of both products.
#[inline(always)]
pub fn parts<S: Level>(
    surface: &Surface<S>,
    diffuse: f32,
    specular: f32,
    shininess: f32,
) -> (F32s<S>, F32s<S>) {
    let matt = dot(surface.normal, surface.to_light).abs() * F32s::splat(diffuse);
    let shiny = highlight(
        surface,
        specular,
        shininess,
        #[inline(always)]
        |cosine| cosine.abs(),
    );
    (matt, shiny)
}
