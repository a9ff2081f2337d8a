//! Plain volumes and Plans, for tests that change one thing of them.

use glam::{DAffine3, DMat3, DVec3};
use strahl_conformance::{Renderer, renderers};
use strahl_scene::Image;
use strahl_scene::plan::*;
use strahl_scene::transfer::TransferTable;
use strahl_volume::{Grid, Metadata, Rescale, Samples, Volume};

/// A volume of f32 samples of a formula over the world.
pub fn volume(grid: Grid, value: impl Fn(DVec3) -> f64) -> Volume {
    let [nx, ny, nz] = grid.dims();
    let mut samples = Vec::with_capacity(grid.voxel_count());
    for z in 0..nz {
        for y in 0..ny {
            for x in 0..nx {
                let voxel = DVec3::new(x as f64, y as f64, z as f64);
                samples.push(value(grid.world_from_voxel().transform_point3(voxel)) as f32);
            }
        }
    }
    of_samples(grid, Samples::F32(samples))
}

/// A volume of these samples as they are.
pub fn of_samples(grid: Grid, samples: Samples) -> Volume {
    Volume::new(grid, samples, Rescale::IDENTITY, Metadata::default()).unwrap()
}

/// A grid with its center at the origin.
pub fn centered(dims: [usize; 3], axes: DMat3) -> Grid {
    let last = DVec3::from_array(dims.map(|n| n as f64 - 1.0));
    Grid::new(
        dims,
        DAffine3::from_mat3_translation(axes, axes * (-0.5 * last)),
    )
    .unwrap()
}

/// Cubic, anisotropic, oblique, sheared.
pub fn grids() -> Vec<Grid> {
    let turned = DMat3::from_rotation_z(0.4) * DMat3::from_rotation_x(-0.7);
    let sheared = DMat3::from_cols(
        DVec3::new(1.0, 0.1, 0.0),
        DVec3::new(0.4, 1.2, 0.2),
        DVec3::new(-0.3, 0.5, 0.9),
    );
    vec![
        centered([12, 12, 12], DMat3::IDENTITY),
        centered([20, 9, 7], DMat3::from_diagonal(DVec3::new(0.5, 1.3, -2.1))),
        centered([12, 10, 8], turned),
        centered([9, 12, 11], turned * sheared),
    ]
}

/// White everywhere, with one opacity per `reference_mm`.
pub fn white(opacity: f64, reference_mm: f64) -> TransferTable {
    let entry = [1.0, 1.0, 1.0, opacity as f32];
    TransferTable::new([0.0, 1.0], reference_mm as f32, vec![entry; 2])
}

/// Opaque, black at `lo` to white at `hi`: what [`value_shown`] reads back.
pub fn grey(lo: f64, hi: f64) -> TransferTable {
    let entries = vec![[0.0, 0.0, 0.0, 1.0], [1.0, 1.0, 1.0, 1.0]];
    TransferTable::new([lo as f32, hi as f32], 1.0, entries)
}

/// The value that a pixel shows under [`grey`].
pub fn value_shown(pixel: [f32; 4], lo: f64, hi: f64) -> f64 {
    lo + f64::from(pixel[0]) * (hi - lo)
}

/// Parallel rays along `forward` through the world's origin, from `distance_mm` before it.
pub fn parallel(forward: DVec3, distance_mm: f64, half_height_mm: f64) -> PlanCamera {
    let forward = forward.normalize();
    let right = forward.cross(if forward.z.abs() < 0.9 {
        DVec3::Z
    } else {
        DVec3::Y
    });
    let right = right.normalize();
    PlanCamera {
        eye_mm: -distance_mm * forward,
        right,
        up: right.cross(forward).normalize(),
        forward,
        projection: Projection::Orthographic { half_height_mm },
    }
}

/// The same camera with rays from one eye.
pub fn from_eye(camera: PlanCamera, tan_half_height: f64) -> PlanCamera {
    PlanCamera {
        projection: Projection::Perspective { tan_half_height },
        ..camera
    }
}

/// Emission–absorption of `volume`, unlit, no early end, half a voxel per step, transparent background.
pub fn plan(volume: &Volume, camera: PlanCamera, table: TransferTable) -> Plan {
    Plan {
        width: 8,
        height: 6,
        camera,
        fields: vec![Field {
            volume: 0,
            grid: *volume.grid(),
            is_moved: false,
            rescale: volume.rescale(),
            fetch: Fetch::Stored,
            reconstruct: Reconstruct::Trilinear,
            gradient: GradientMethod::Central,
        }],
        techniques: vec![Technique {
            classify: Classify::Table,
            table,
            gradient_input: GradientInput::Value,
            shade: Shade::Unlit,
            illustrate: Illustrate::Plain,
            composite: Composite::EmissionAbsorption {
                stop_at_transmittance: 0.0,
            },
        }],
        layers: vec![Layer {
            field: 0,
            segments: Segments::Whole { technique: 0 },
        }],
        global_rule: GlobalRule::EmissionAbsorption {
            stop_at_transmittance: 0.0,
        },
        importance: None,
        meshes: Vec::new(),
        lattice: Lattice {
            step_mm: 0.5 * volume.grid().min_spacing_mm(),
            jitter: Jitter::Center,
            frames: 1,
        },
        sampling: Sampling::Regular,
        lights: Vec::new(),
        ray_clips: Vec::new(),
        sample_clips: Vec::new(),
        modules: Vec::new(),
        background: [0.0; 4],
        compositing: Compositing::Linear,
        with_depth: false,
        display: Display::PLAIN,
    }
}

/// Light and surface.
pub fn blinn_phong(ambient: f32, diffuse: f32, specular: f32, shininess: f32) -> Shade {
    Shade::Lit {
        ambient,
        illuminate: Illuminate::BlinnPhong {
            diffuse,
            specular,
            shininess,
        },
        keep_last_normal: false,
    }
}

/// Keeps normal·p + offset_mm ≥ 0 of every object.
pub fn plane(normal: DVec3, offset_mm: f64) -> ClipPlane {
    ClipPlane {
        normal,
        offset_mm,
        layers: ALL_LAYERS,
    }
}

/// Keeps the inside or the outside of a box of every object.
pub fn cut_box(unit_from_world: DAffine3, keep_inside: bool) -> SampleClip {
    SampleClip {
        shape: ClipShape::Box,
        unit_from_world,
        keep_inside,
        layers: ALL_LAYERS,
    }
}

/// Cuts every ray to one sample: at `distance_mm` along the view from the world's origin.
pub fn one_sample_at(plan: &mut Plan, distance_mm: f64) {
    let forward = plan.camera.forward;
    let half = 0.5 * plan.lattice.step_mm;
    plan.ray_clips = vec![
        plane(forward, half - distance_mm),
        plane(-forward, half + distance_mm),
    ];
}

/// Every pixel of every renderer that can draw it: name, column, row, color.
pub fn draw(volume: &Volume, plan: &Plan) -> Vec<(Renderer, u32, u32, [f32; 4])> {
    draw_by(&renderers(), volume, plan)
}

/// The same of these renderers.
pub fn draw_by(
    renderers: &[Renderer],
    volume: &Volume,
    plan: &Plan,
) -> Vec<(Renderer, u32, u32, [f32; 4])> {
    let mut pixels = Vec::new();
    for renderer in renderers.iter().filter(|r| r.can_draw(volume, plan)) {
        let image: Image = renderer.draw(volume, plan);
        for y in 0..plan.height {
            for x in 0..plan.width {
                pixels.push((*renderer, x, y, image.pixel(x, y)));
            }
        }
    }
    pixels
}
