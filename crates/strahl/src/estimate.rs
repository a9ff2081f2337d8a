//! How much memory and time a picture needs, about, told before it is drawn.

use std::fmt;
use strahl_scene::plan::{
    Classify, Field, Illustrate, Plan, Ray, Reconstruct, Sampling, Shade, Technique,
};
use strahl_volume::{Datasets, cores};

/// What drawing needs, about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Bytes of memory, those of the data included.
    pub memory_bytes: u64,
    /// Seconds on this machine. Skipping and rays that end early may make it a tenth.
    pub seconds: f64,
    /// Rays of all frames.
    pub rays: f64,
    /// Lattice points of a ray, in the mean over the picture.
    pub points: f64,
}

/// What draws, for how long that takes.
#[derive(Clone, Copy)]
pub(crate) enum Speed {
    Processor { threads: usize },
    Evaluated { threads: usize },
    Graphics,
}

impl Speed {
    /// Of a sample between eight voxels that is not lit, with all that works side by side: measured, and rounded.
    fn sample_seconds(self) -> f64 {
        let over = |nanoseconds: f64, threads: usize| {
            let there = cores::number().max(1);
            let threads = match threads {
                0 => there,
                asked => asked.min(there),
            };
            1e-9 * nanoseconds / threads as f64
        };
        match self {
            Speed::Processor { threads } => over(4.0, threads),
            Speed::Evaluated { threads } => over(100.0, threads),
            Speed::Graphics => 1e-10,
        }
    }
}

impl Estimate {
    /// Of drawing `plan` from `data` by what has this `speed`.
    pub(crate) fn of(plan: &Plan, data: &Datasets, speed: Speed) -> Estimate {
        let rays = f64::from(plan.width) * f64::from(plan.height) * f64::from(plan.lattice.frames);
        let (points, work) = along_rays(plan);
        Estimate {
            memory_bytes: data_bytes(plan, data).saturating_add(picture_bytes(plan)),
            seconds: rays * work * speed.sample_seconds(),
            rays,
            points,
        }
    }
}

/// Lattice points of a ray, and how many plain samples they cost as much as, in the mean over some rays of the picture.
fn along_rays(plan: &Plan) -> (f64, f64) {
    /// Rays that are looked at, across and down.
    const LOOKED_AT: u32 = 24;
    let (mut points, mut work) = (0.0, 0.0);
    for number in 0..LOOKED_AT * LOOKED_AT {
        let of = |index: u32, pixels: u32| {
            ((f64::from(index) + 0.5) / f64::from(LOOKED_AT) * f64::from(pixels)) as u32
        };
        let (x, y) = (
            of(number % LOOKED_AT, plan.width),
            of(number / LOOKED_AT, plan.height),
        );
        let ray = plan.camera.ray(x, y, plan.width, plan.height);
        let mut longest: f64 = 0.0;
        for (layer, field) in plan.drawn_fields().enumerate() {
            let inside = chord_mm(&ray, field) / plan.lattice.step_mm;
            longest = longest.max(inside);
            work += inside * cost(plan, layer, field);
        }
        points += longest;
    }
    let all = f64::from(LOOKED_AT * LOOKED_AT);
    (points / all, work / all)
}

/// The length of a ray in the box of a field.
fn chord_mm(ray: &Ray, field: &Field) -> f64 {
    let voxel_from_world = field.grid.world_from_voxel().inverse();
    let origin = voxel_from_world.transform_point3(ray.origin_mm).to_array();
    let direction = voxel_from_world.transform_vector3(ray.direction).to_array();
    let (mut from, mut to) = (0.0f64, f64::INFINITY);
    for axis in 0..3 {
        let ends = [-0.5, field.grid.dims()[axis] as f64 - 0.5];
        let at = ends.map(|end| (end - origin[axis]) / direction[axis]);
        // Not a number on a ray along a face: it says nothing then.
        from = from.max(at[0].min(at[1]));
        to = to.min(at[0].max(at[1]));
    }
    match (to - from).is_finite() {
        true => (to - from).max(0.0),
        false => 0.0,
    }
}

/// What a sample of a layer costs, in plain ones: with segments, one of the costliest technique.
fn cost(plan: &Plan, layer: usize, field: &Field) -> f64 {
    let of_sample = match plan.labeled() {
        Some(_) => plan.techniques.iter().map(cost_of_look).fold(1.0, f64::max),
        None => cost_of_look(plan.technique_of(layer)),
    };
    let kernel = match field.reconstruct {
        Reconstruct::Nearest | Reconstruct::Trilinear => 1.0,
        _ => 6.0,
    };
    let rule = if plan.sampling == Sampling::Regular {
        1.0
    } else {
        2.0
    };
    kernel * of_sample * rule
}

/// What a sample costs for the look that a technique gives to it, in plain ones.
fn cost_of_look(technique: &Technique) -> f64 {
    let has_gradient = matches!(technique.shade, Shade::Lit { .. })
        || matches!(
            technique.classify,
            Classify::GradientTable { .. } | Classify::ValueGradient { .. }
        );
    let beside = match technique.illustrate {
        Illustrate::Plain | Illustrate::DepthCue { .. } => 0.0,
        Illustrate::Silhouette { .. } => 2.0,
        // Three gradients.
        Illustrate::ContourLines { .. } => 6.0,
        Illustrate::Halo { steps, .. } => 8.0 * f64::from(steps),
    };
    beside + if has_gradient { 3.0 } else { 1.0 }
}

/// The data, and what is made of it: coefficients where a kernel needs them, bricks and what is known of them.
fn data_bytes(plan: &Plan, data: &Datasets) -> u64 {
    let stored = |volume: &strahl_volume::Volume| volume.samples().as_bytes().len() as u64;
    let mut bytes: u64 = data.volumes.iter().chain(&data.masks).map(stored).sum();
    for field in plan.drawn_fields() {
        let voxels = field.grid.voxel_count() as u64;
        bytes += voxels / 8;
        if field.reconstruct == Reconstruct::BSplineInterpolating {
            bytes += 4 * voxels;
        }
    }
    let of_mesh = |mesh: &strahl_volume::Mesh| 400 * mesh.triangles().len() as u64;
    bytes + data.meshes.iter().map(of_mesh).sum::<u64>()
}

/// The picture while it is drawn and encoded.
pub(crate) fn picture_bytes(plan: &Plan) -> u64 {
    let pixels = u64::from(plan.width) * u64::from(plan.height);
    let of_frames = if plan.lattice.frames > 1 { 32 } else { 0 };
    let of_depth = if plan.with_depth { 8 } else { 0 };
    pixels * (2 * size_of::<[f32; 4]>() as u64 + of_frames + of_depth)
}

/// Seconds as people say them.
pub(crate) struct About(pub f64);

impl fmt::Display for About {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const UNITS: [(&str, f64); 4] = [
            ("days", 86_400.0),
            ("hours", 3600.0),
            ("minutes", 60.0),
            ("seconds", 1.0),
        ];
        let fits = |unit: &&(&str, f64)| self.0 >= 1.5 * unit.1;
        let (name, seconds) = UNITS.iter().find(fits).unwrap_or(&UNITS[3]);
        write!(f, "{:.0} {name}", (self.0 / seconds).min(1e12))
    }
}

/// Bytes as people say them.
pub(crate) struct Bytes(pub u64);

impl fmt::Display for Bytes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let bytes = self.0 as f64;
        match self.0 {
            0x4000_0000.. => write!(f, "{:.1} GiB", bytes / 1_073_741_824.0),
            0x10_0000.. => write!(f, "{:.1} MiB", bytes / 1_048_576.0),
            bytes => write!(f, "{bytes} bytes"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Phantom, Render};
    use strahl_scene::plan::Projection as PlanProjection;
    use strahl_scene::{Camera, Projection, View};

    /// A cube seen from the front without perspective: every ray in it is as long as its edge.
    #[test]
    fn work_is_that_of_the_lattice_in_the_box() {
        let render = Render::phantom(Phantom::Tree)
            .camera(Camera {
                view: Some(View::Front),
                projection: Some(Projection::Orthographic),
                ..Camera::default()
            })
            .size(240, 240)
            .with(|scene| {
                scene.volume.as_mut().unwrap().dims = Some([8, 8, 8]);
                scene.step_mm = Some(0.5);
                scene.preset = Some("mip".into());
            });
        let plan = render.plan().unwrap();
        let edge = plan.field().grid.spacing_mm().x * 8.0;
        let PlanProjection::Orthographic { half_height_mm } = plan.camera.projection else {
            panic!("{:?}", plan.camera.projection);
        };
        // The middles of pixels 5, 15, 25 … of 240.
        let places = (0..24).map(|i| (f64::from(10 * i) + 5.5) / 120.0 - 1.0);
        let inside = places.filter(|place| place.abs() * half_height_mm < edge / 2.0);
        let share = inside.count() as f64 / 24.0;
        let (points, _) = along_rays(&plan);
        let expected = share * share * edge / 0.5;
        assert!(
            (points - expected).abs() < 1e-6 * expected,
            "{points} {expected}"
        );
    }

    #[test]
    fn times_are_said_as_people_say_them() {
        for (seconds, words) in [
            (0.4, "0 seconds"),
            (80.0, "80 seconds"),
            (1800.0, "30 minutes"),
            (7000.0, "2 hours"),
            (1e6, "12 days"),
        ] {
            assert_eq!(About(seconds).to_string(), words);
        }
    }
}
