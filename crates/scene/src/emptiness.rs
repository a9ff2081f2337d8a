//! Why a picture shows nothing but its background.

use crate::Headers;
use crate::plan::{Classify, ClipShape, Composite, Plan, Ray, Technique};
use glam::DVec3;
use strahl_shader::registry::Skips;
use strahl_volume::Grid;

/// Rays along an edge of the picture that are looked at.
const RAYS: u32 = 24;

/// What may be the reason that the picture of `plan`, with data of these headers, shows nothing: each as a sentence
/// without its full stop. Empty if none is known.
pub fn why_nothing_is_seen(plan: &Plan, headers: &Headers) -> Vec<String> {
    let mut why = of_values(plan, headers);
    let seen = Seen::of(plan);
    if seen.longest_mm == 0.0 {
        why.push("no ray meets a volume: the camera looks past them, or is too far away".into());
    } else if seen.longest_kept_mm == 0.0 {
        why.push("the clips leave nothing of what the camera looks at".into());
    } else if seen.longest_kept_mm < 0.5 * plan.lattice.step_mm {
        why.push(format!(
            "what the clips leave is at most {:.3} mm thick, and samples are {:.3} mm apart: a shorter step_mm finds it",
            seen.longest_kept_mm, plan.lattice.step_mm
        ));
    } else if !plan.ray_clips.is_empty() || !plan.sample_clips.is_empty() {
        let masks = |shape: &ClipShape| matches!(shape, ClipShape::Mask { .. });
        let has_mask = plan.sample_clips.iter().any(|clip| masks(&clip.shape));
        let what = if has_mask { "clips and masks" } else { "clips" };
        why.push(format!("the {what} may leave only what is transparent"));
    }
    why
}

/// Reasons that lie in the values of a volume.
fn of_values(plan: &Plan, headers: &Headers) -> Vec<String> {
    let mut why = Vec::new();
    for (layer, field) in plan.drawn_fields().enumerate() {
        let Some(header) = headers.volumes.get(field.volume) else {
            continue;
        };
        let statistics = &header.statistics;
        let [lo, hi] = statistics.range;
        if statistics.histogram.iter().all(|&count| count == 0) {
            why.push("no voxel has a value".into());
            continue;
        }
        if lo == hi {
            why.push(format!("all voxels have the value {lo}"));
        }
        // Of segments, each may be drawn in another way.
        if plan.labeled().is_none() {
            why.extend(of_technique(plan.technique_of(layer), [lo, hi]));
        }
    }
    why
}

/// Why a technique shows nothing of values in this range, if it does not.
fn of_technique(technique: &Technique, [lo, hi]: [f64; 2]) -> Option<String> {
    if let Composite::FirstHit { threshold } = technique.composite
        && f64::from(threshold) > hi
    {
        return Some(format!(
            "the threshold {threshold} lies above all values, {lo} to {hi}"
        ));
    }
    let table = &technique.table;
    let [first, last] = table.domain().map(f64::from);
    let last_entry = (table.entries().len() - 1) as f64;
    let place = |value: f64| ((value - first) / (last - first)).clamp(0.0, 1.0) * last_entry;
    let (from, to) = (place(lo).floor() as usize, place(hi).ceil() as usize);
    let shown = &table.entries()[from.min(to)..=to];
    let shows = shown.iter().any(|entry| entry[3] > 0.0);
    let asks = technique.composite.function().skips == Skips::Clear
        && !matches!(technique.classify, Classify::Identity { .. });
    (asks && !shows)
        .then(|| format!("the transfer function is transparent for all values, {lo} to {hi}"))
}

/// The longest pieces of rays inside a volume, before and after planes have cut them.
struct Seen {
    longest_mm: f64,
    longest_kept_mm: f64,
}

impl Seen {
    fn of(plan: &Plan) -> Seen {
        let mut seen = Seen {
            longest_mm: 0.0,
            longest_kept_mm: 0.0,
        };
        for row in 0..RAYS {
            for column in 0..RAYS {
                let ray = plan.camera.ray(column, row, RAYS, RAYS);
                let ray = of_picture(plan, ray, column, row);
                for (layer, field) in plan.drawn_fields().enumerate() {
                    let inside = inside(&field.grid, &ray);
                    let cut = plan.ray_clips.iter().filter(|c| c.layers >> layer & 1 == 1);
                    let kept = cut.fold(inside, |interval, plane| {
                        cut_by(interval, &ray, plane.normal, plane.offset_mm)
                    });
                    seen.longest_mm = seen.longest_mm.max(inside[1] - inside[0]);
                    seen.longest_kept_mm = seen.longest_kept_mm.max(kept[1] - kept[0]);
                }
            }
        }
        seen
    }
}

/// The ray through the same part of a picture of the Plan's shape.
fn of_picture(plan: &Plan, square: Ray, column: u32, row: u32) -> Ray {
    if plan.width == plan.height {
        return square;
    }
    let pixel = |i: u32, edge: u32| (i * edge + edge / 2) / RAYS;
    let (x, y) = (pixel(column, plan.width), pixel(row, plan.height));
    plan.camera.ray(x, y, plan.width, plan.height)
}

/// The interval of a ray inside the sampled extent of a grid.
fn inside(grid: &Grid, ray: &Ray) -> [f64; 2] {
    let map = grid.voxel_from_world();
    let (first, last) = grid.extent_in_voxels();
    let mut interval = [0.0, f64::INFINITY];
    for axis in 0..3 {
        let normal = map.matrix3.row(axis);
        let shift = map.translation[axis];
        interval = cut_by(interval, ray, normal, shift - first[axis]);
        interval = cut_by(interval, ray, -normal, last[axis] - shift);
    }
    interval
}

/// What of an interval lies where normal·p + offset ≥ 0.
fn cut_by([start, end]: [f64; 2], ray: &Ray, normal: DVec3, offset: f64) -> [f64; 2] {
    let height = normal.dot(ray.origin_mm) + offset;
    let slope = normal.dot(ray.direction);
    let [start, end] = if slope > 0.0 {
        [start.max(-height / slope), end]
    } else if slope < 0.0 {
        [start, end.min(-height / slope)]
    } else if height < 0.0 {
        [start, start]
    } else {
        [start, end]
    };
    [start, end.max(start)]
}
