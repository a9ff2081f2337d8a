//! The modeled processor against the CPU renderer's picture in floating point: two programs that share no arithmetic.

use glam::DVec3;
use strahl_cpu::{Options, Renderer};
use strahl_scene::plan::{Plan, Projection};
use strahl_scene::{Scene, resolve};
use strahl_sim::spec::{Optimisation, Shading, Widths};
use strahl_sim::study::psnr_db;
use strahl_sim::{Frame, NoObserver, Spec, VolumeStore, run};
use strahl_volume::{Control, Phantom, Volume};

const EDGE: usize = 48;
/// Rays twice as dense as voxels, so that x and z are interpolated.
const PIXELS: u32 = 2 * EDGE as u32;
/// Opacity of the largest value.
const OPACITY: f64 = 0.3;

/// From the front, one sample per voxel along y: the lattice of the Plan begins half a step behind the half voxel before
/// the first center, so its samples are the processor's.
fn plan(volume: &Volume) -> Plan {
    let scene = format!(
        r##"{{ "size": [{PIXELS}, {PIXELS}], "method": "emission-absorption", "background": "black",
              "shading": {{ "model": "unlit" }},
              "transfer_function": {{ "points": [
                  {{ "value": 0, "opacity": 0, "color": "#ffffff" }},
                  {{ "value": 1, "opacity": {OPACITY}, "color": "#ffffff" }} ] }} }}"##
    );
    let scene = Scene::parse("front", &scene).unwrap();
    let mut plan = resolve(&scene, &volume.header(), None).unwrap();
    let spacing = volume.grid().spacing_mm();
    let center = volume.grid().center_mm();
    plan.lattice.step_mm = spacing.y;
    plan.camera.eye_mm = center - DVec3::Y * 10.0 * spacing.y * EDGE as f64;
    plan.camera.forward = DVec3::Y;
    plan.camera.right = DVec3::X;
    plan.camera.up = DVec3::Z;
    plan.camera.projection = Projection::Orthographic {
        half_height_mm: 0.5 * spacing.z * EDGE as f64,
    };
    plan
}

fn simulated(volume: &Volume, widths: Widths) -> Vec<f32> {
    let mut spec = Spec {
        widths,
        optimisation: Optimisation::none(),
        ..Spec::default()
    };
    spec.look.opacity = vec![[0.0, 0.0], [1.0, OPACITY]];
    spec.look.shading = Shading::Unlit;
    spec.look.gradient_weighting = false;
    spec.view.pixel = 0.5;
    let frame = Frame::new(&spec, &VolumeStore::new(volume).unwrap()).unwrap();
    let drawn = run(&frame, &mut NoObserver, &strahl_sim::no_progress).unwrap();
    assert_eq!(drawn.size, [PIXELS, PIXELS]);
    drawn.picture
}

#[test]
fn words_of_the_document_cost_what_their_bits_say() {
    let volume = Phantom::Shells.volume([EDGE; 3]).unwrap();
    let drawn = Renderer::new(&volume)
        .render(&plan(&volume), &Options::default(), &Control::NONE)
        .unwrap();
    // The outermost pixels lie before the centers of the first voxels: the renderer clamps there, the processor sends no ray.
    let inner = |i: usize| {
        let (x, y) = (i % PIXELS as usize, i / PIXELS as usize);
        [x, y].iter().all(|c| (1..PIXELS as usize - 1).contains(c))
    };
    let keep = |picture: Vec<f32>| -> Vec<f32> {
        picture
            .into_iter()
            .enumerate()
            .filter(|(i, _)| inner(*i))
            .map(|(_, p)| p)
            .collect()
    };
    let truth = keep(drawn.image.pixels().iter().map(|p| p[0]).collect());
    let brightest = truth.iter().copied().fold(0.0, f32::max);
    assert!(brightest > 0.5, "the picture shows something: {brightest}");
    let psnr = |widths| psnr_db(&keep(simulated(&volume, widths)), &truth);
    let document = psnr(Widths::default());
    let wide = psnr(Widths::wide());
    let six = psnr(Widths {
        data: 6,
        ..Widths::default()
    });
    println!("document {document:.1} dB, 6 bits of data {six:.1} dB, wide {wide:.1} dB");
    // What is left with wide words: the renderer ends its rays at 1/256 of light, and the processor's T has 20 bits.
    assert!(wide > 65.0, "{wide} dB");
    assert!((45.0..wide).contains(&document), "{document} dB");
    assert!(six < document - 6.0, "{six} dB");
}
