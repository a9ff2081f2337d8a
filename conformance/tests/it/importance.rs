//! Importance by place: pictures against the scheme in double precision, with values interpolated here.

use crate::random::{Random, seeds};
use crate::segments::labels;
use crate::simple::{centered, parallel, plan, volume};
use crate::variants::draw;
use glam::{DMat3, DVec3};
use strahl_conformance::{device, truth};
use strahl_evaluate::Evaluator;
use strahl_scene::Image;
use strahl_scene::plan::*;
use strahl_scene::transfer::TransferTable;
use strahl_volume::{Control, Datasets, Grid, LabelVolume, Samples, Volume};

/// The pictures of all renderers.
pub fn drawn(data: &Datasets, plan: &Plan) -> Vec<(&'static str, Image)> {
    let here = Evaluator::new(data.clone()).render(plan, &Control::NONE);
    let mut drawn = vec![
        ("CPU", draw(data.clone(), plan).image),
        ("evaluator", here.unwrap().image),
    ];
    if let Some(device) = device() {
        let mut renderer = strahl_gpu::Renderer::new(device, data.clone());
        drawn.push(("GPU", renderer.render(plan, &Control::NONE).unwrap().image));
    }
    drawn
}

/// What has been seen in front of a sample, and how important it is.
#[derive(Clone, Copy, Default)]
pub struct Seen {
    pub color: [f64; 3],
    pub alpha: f64,
    importance: f64,
}

impl Seen {
    /// Section 4 of the paper, equation by equation; `color` is premultiplied.
    pub fn add(&mut self, color: [f64; 3], opacity: f64, importance: f64) {
        if opacity == 0.0 {
            return;
        }
        let visibility = 1.0 - (self.importance - importance).exp();
        let m = match importance <= self.importance || 1.0 - self.alpha >= visibility {
            true => 1.0,
            false => (1.0 - visibility) / self.alpha,
        };
        let modulated = m * self.alpha * (1.0 - opacity) + opacity;
        let alpha = self.alpha * (1.0 - opacity) + opacity;
        for (sum, own) in self.color.iter_mut().zip(color) {
            *sum = (m * *sum + (1.0 - m * self.alpha) * own) * alpha / modulated;
        }
        let rest = (self.importance - importance).exp();
        let accumulated = importance + (opacity + (1.0 - opacity) * rest).ln();
        self.alpha = alpha;
        self.importance = self.importance.max(accumulated);
    }
}

/// The world coordinate y of the volume, on the y axis from red and clear to blue.
struct Case {
    volume: Volume,
    mask: Volume,
    labels: LabelVolume,
    plan: Plan,
}

const RED_TO_BLUE: [[f32; 4]; 2] = [[1.0, 0.0, 0.0, 0.05], [0.0, 0.0, 1.0, 0.4]];

/// Segments 1 and 2 lie in turns along the ray.
fn case(random: &mut Random) -> Case {
    let grid = centered([9, 14, 8], DMat3::IDENTITY);
    let volume = volume(grid, |place| place.y);
    let of_mask = centered(
        [5, 6, 4],
        random.rotation() * DMat3::from_diagonal(DVec3::new(2.3, 2.1, 3.0)),
    );
    let wave = random.direction();
    let mask = crate::simple::volume(of_mask, |place| 10.0 + 6.0 * place.dot(wave).sin());
    let labels = labels(grid, |place| 1 + (place.y / 3.0 + 9.0).floor() as u32 % 2);
    let table = TransferTable::new([-6.5, 6.5], 0.5, RED_TO_BLUE.to_vec());
    let mut plan = plan(&volume, parallel(DVec3::Y, 40.0, 3.0), table);
    plan.importance = Some(PlanImportance {
        mask: 0,
        unit_from_world: unit_from_world(&of_mask),
        low: 5.0,
        high: 14.0,
        gain_of_runs: 2.5,
    });
    Case {
        volume,
        mask,
        labels,
        plan,
    }
}

fn unit_from_world(grid: &Grid) -> glam::DAffine3 {
    let (first, last) = grid.extent_in_voxels();
    let size = DMat3::from_diagonal(last - first);
    let voxel_from_unit = glam::DAffine3::from_mat3_translation(size, 0.5 * (first + last));
    (grid.world_from_voxel() * voxel_from_unit).inverse()
}

/// The importance of a place, 0 to 1.
fn importance(mask: &Volume, plan: &Plan, place: DVec3) -> f64 {
    let PlanImportance { low, high, .. } = plan.importance.unwrap();
    let voxel = mask.grid().voxel_from_world().transform_point3(place);
    let dims = DVec3::from_array(mask.grid().dims().map(|n| n as f64));
    if voxel.cmplt(DVec3::splat(-0.5)).any() || voxel.cmpgt(dims - 0.5).any() {
        return 0.0;
    }
    let inside = voxel.clamp(DVec3::ZERO, dims - 1.0);
    let floor = inside.floor().min(dims - 2.0);
    let share = inside - floor;
    let Samples::F32(values) = mask.samples() else {
        panic!("{:?}", mask.sample_type());
    };
    let value = |corner: DVec3| {
        let at = floor + corner;
        let index = at.x + dims.x * (at.y + dims.y * at.z);
        f64::from(values[index as usize])
    };
    let mut sum = 0.0;
    for corner in 0..8 {
        let side = [0, 1, 2].map(|axis| f64::from(corner >> axis & 1));
        let side = DVec3::from_array(side);
        let weight = side * share + (1.0 - side) * (1.0 - share);
        sum += weight.x * weight.y * weight.z * value(side);
    }
    ((sum - f64::from(low)) / f64::from(high - low)).clamp(0.0, 1.0)
}

/// The samples of a pixel: where they lie, color and opacity.
fn samples(plan: &Plan, x: u32, y: u32) -> Vec<(DVec3, [f64; 3], f64)> {
    let (origin, direction) = truth::ray(plan, x, y);
    let entry = -7.0 - origin.y;
    let count = (14.0 / plan.lattice.step_mm - 0.5).ceil() as u32;
    let sample = |k: u32| {
        let t = entry + (f64::from(k) + 0.5) * plan.lattice.step_mm;
        let place = origin + t * direction;
        let share = (place.y.clamp(-6.5, 6.5) + 6.5) / 13.0;
        let mixed = |c: usize| {
            let [from, to] = RED_TO_BLUE.map(|entry| f64::from(entry[c]));
            from + share * (to - from)
        };
        (place, [mixed(0), mixed(1), mixed(2)], mixed(3))
    };
    (0..count).map(sample).collect()
}

fn compare(data: &Datasets, plan: &Plan, what: &str, expected: impl Fn(u32, u32) -> Seen) {
    for (renderer, image) in drawn(data, plan) {
        for y in 0..plan.height {
            for x in 0..plan.width {
                let Seen { color, alpha, .. } = expected(x, y);
                let [r, g, b] = color;
                for (found, right) in image.pixel(x, y).into_iter().zip([r, g, b, alpha]) {
                    let off = (f64::from(found) - right).abs();
                    assert!(off < 2e-4, "{what}, {renderer}, {x} {y}: {found} {right}");
                }
            }
        }
    }
}

#[test]
fn samples_are_as_important_as_their_places() {
    let mut raised = 0;
    for seed in seeds(4) {
        let mut random = Random::new(seed ^ 0x1A90);
        let Case {
            volume,
            mask,
            mut plan,
            ..
        } = case(&mut random);
        let gain = random.between(1.0, 6.0);
        plan.techniques[0].composite = Composite::ImportanceAware {
            measure: 5,
            gain: gain as f32,
            first: 0.4,
            second: 0.2,
            third: 0.6,
            full_per_mm: 1.0,
            low: 0.0,
            high: 1.0,
        };
        let data = Datasets {
            masks: vec![mask.clone()],
            ..Datasets::from(&volume)
        };
        let gain = f64::from(gain as f32);
        compare(&data, &plan, &format!("seed {seed}"), |x, y| {
            let mut seen = Seen::default();
            for (place, color, opacity) in samples(&plan, x, y) {
                let own = gain * importance(&mask, &plan, place);
                // Next to nothing would be seen of it.
                if 1.0 - seen.alpha < 1.0 / 256.0 && own - seen.importance < 1.0 / 256.0 {
                    continue;
                }
                seen.add(color.map(|c| c * opacity), opacity, own);
            }
            seen
        });
        let of_all = |at: &(DVec3, [f64; 3], f64)| importance(&mask, &plan, at.0);
        raised += usize::from(samples(&plan, 3, 3).iter().map(of_all).sum::<f64>() > 1.0);
    }
    assert!(raised > 2);
}

#[test]
fn runs_are_as_important_as_their_most_important_place() {
    for seed in seeds(4) {
        let mut random = Random::new(seed ^ 0x1A91);
        let Case {
            volume,
            mask,
            labels,
            mut plan,
        } = case(&mut random);
        let look = |importance: f32| SegmentLook {
            importance,
            ..SegmentLook::of(0)
        };
        plan.layers[0].segments = Segments::Labeled(Box::new(Labeled {
            labels: 0,
            grid: *labels.grid(),
            is_moved: false,
            looks: [(2, look(0.5))].into(),
            others: look(0.0),
            groups: Vec::new(),
        }));
        plan.global_rule = GlobalRule::ImportanceAware;
        let data = Datasets {
            masks: vec![mask.clone()],
            labels: vec![labels.clone()],
            ..Datasets::from(&volume)
        };
        let segment = |place: DVec3| 1 + (place.y / 3.0 + 9.0).floor() as u32 % 2;
        compare(&data, &plan, &format!("seed {seed}"), |x, y| {
            let (mut seen, mut run, mut most) = (Seen::default(), Seen::default(), 0.0f64);
            let samples = samples(&plan, x, y);
            for (i, (place, color, opacity)) in samples.iter().enumerate() {
                let passing = 1.0 - run.alpha;
                for (sum, own) in run.color.iter_mut().zip(color) {
                    *sum += passing * opacity * own;
                }
                run.alpha += passing * opacity;
                most = most.max(importance(&mask, &plan, *place));
                let here = segment(*place);
                if samples
                    .get(i + 1)
                    .is_none_or(|next| segment(next.0) != here)
                {
                    let own = 2.5 * most + if here == 2 { 0.5 } else { 0.0 };
                    seen.add(run.color, run.alpha, own);
                    (run, most) = (Seen::default(), 0.0);
                }
            }
            seen
        });
    }
}
