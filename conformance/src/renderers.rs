//! The renderers under test.

use strahl_scene::{Image, plan::Plan};
use strahl_volume::Control;
use strahl_volume::Volume;

/// A renderer, as the tests see it.
pub struct Renderer {
    /// The name in messages.
    pub name: &'static str,
    /// Draws a Plan of a volume.
    pub draw: fn(&Volume, &Plan) -> Image,
    /// How far a pixel may lie outside [`truth::bounds`](crate::truth::bounds), as a share of the brightest colour
    /// that the Plan can give (at least 1): what is lost where the samples of a ray are added up.
    pub tolerance: f64,
}

/// Every renderer that is tested. A new one is one more line.
pub fn renderers() -> Vec<Renderer> {
    vec![Renderer {
        name: "cpu",
        draw: draw_on_cpu,
        tolerance: 1e-6,
    }]
}

fn draw_on_cpu(volume: &Volume, plan: &Plan) -> Image {
    strahl_cpu::Renderer::new(volume)
        .render(plan, &strahl_cpu::Options::default(), &Control::NONE)
        .unwrap_or_else(|error| panic!("cpu: {error}"))
        .image
}
