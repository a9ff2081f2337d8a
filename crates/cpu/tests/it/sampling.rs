//! Steps in parts and steps left out, against formulas, against finer and regular pictures, and the same bytes
//! whatever must not change them.

use proptest::prelude::*;
use strahl_cpu::{InstructionSet, Options, Rendered, Renderer};
use strahl_scene::plan::{Composite, Curve, Plan, Sampling};
use strahl_scene::transfer::TransferTable;
use strahl_scene::{Scene, resolve};
use strahl_volume::{Control, Grid, Metadata, Phantom, Rescale, Samples, Volume};

fn linear(parts: u32) -> Sampling {
    Sampling::Split {
        parts,
        curve: Curve::Linear,
    }
}

fn cubic(parts: u32) -> Sampling {
    Sampling::Split {
        parts,
        curve: Curve::Cubic,
    }
}

fn of(dims: [usize; 3], samples: Samples) -> Volume {
    let grid = Grid::centered(dims, glam::DVec3::ONE).unwrap();
    Volume::new(grid, samples, Rescale::IDENTITY, Metadata::default()).unwrap()
}

/// 10 values per voxel along z, from 0.
fn ramp() -> Volume {
    let dims = [6, 6, 40];
    let sample = |i: usize| (10 * (i / 36)) as f32;
    of(dims, Samples::F32((0..6 * 6 * 40).map(sample).collect()))
}

/// A plan of emission–absorption that no ray ends early of, with this table.
fn plan(volume: &Volume, scene: &str, table: TransferTable) -> Plan {
    let scene = Scene::parse("scene", scene).unwrap();
    let mut plan = resolve(&scene, &volume.header(), None).unwrap();
    plan.technique_mut().composite = Composite::EmissionAbsorption {
        stop_at_transmittance: 0.0,
    };
    plan.technique_mut().table = table;
    plan
}

fn draw_with(renderer: &Renderer, plan: &Plan, options: &Options) -> Rendered {
    renderer.render(plan, options, &Control::NONE).unwrap()
}

fn draw(volume: &Volume, plan: &Plan) -> Rendered {
    draw_with(&Renderer::new(volume), plan, &Options::default())
}

fn sampled(plan: &Plan, sampling: Sampling) -> Plan {
    Plan {
        sampling,
        ..plan.clone()
    }
}

fn finer(plan: &Plan, times: f64) -> Plan {
    let mut plan = sampled(plan, Sampling::Regular);
    plan.lattice.step_mm /= times;
    plan
}

/// The largest difference of a channel.
fn difference(a: &Rendered, b: &Rendered) -> f64 {
    let pairs = a
        .image
        .pixels()
        .iter()
        .flatten()
        .zip(b.image.pixels().iter().flatten());
    pairs
        .map(|(a, b)| f64::from((a - b).abs()))
        .fold(0.0, f64::max)
}

/// The root of the mean squared difference of channels.
fn rms(a: &Rendered, b: &Rendered) -> f64 {
    let pairs = a
        .image
        .pixels()
        .iter()
        .flatten()
        .zip(b.image.pixels().iter().flatten());
    let squares = pairs.clone().map(|(a, b)| f64::from(a - b).powi(2));
    (squares.sum::<f64>() / pairs.count() as f64).sqrt()
}

/// Red up to the middle, blue behind it, 0 at both ends of the values of the ramp.
fn soft() -> TransferTable {
    let entry = |i: usize| {
        let x = i as f32 / 100.0;
        let opacity = (1.0 - (x - 0.5).abs() / 0.3).max(0.0);
        [1.0 - x, 0.2, x, 0.2 * opacity]
    };
    TransferTable::new([0.0, 390.0], 1.0, (0..=100).map(entry).collect())
}

/// Opaque white in a triangle of `width` values about 200.
fn peak(width: f32) -> TransferTable {
    let (lo, hi) = (200.0 - 0.5 * width, 200.0 + 0.5 * width);
    let entry = |opacity: f32| [1.0, 1.0, 1.0, opacity];
    TransferTable::new([lo, hi], 1.0, vec![entry(0.0), entry(0.7), entry(0.0)])
}

const OBLIQUE: &str = r#"{ "size": [24, 20], "shading": { "model": "unlit" }, "background": "transparent",
    "camera": { "view": "front", "azimuth_deg": 20, "elevation_deg": 35 }, "step_voxels": 1.3 }"#;

/// Along z, from the low end.
const ALONG: &str = r#"{ "size": [4, 4], "shading": { "model": "unlit" }, "background": "transparent",
    "camera": { "view": "bottom", "projection": "orthographic", "zoom": 12 }, "step_voxels": 1.3 }"#;

#[test]
fn one_part_is_the_regular_picture() {
    let volume = Phantom::Tree.volume([40; 3]).unwrap();
    for model in ["unlit", "blinn-phong"] {
        let scene = format!(r#"{{ "size": [40, 30], "shading": {{ "model": "{model}" }} }}"#);
        let scene = Scene::parse("scene", &scene).unwrap();
        let plan = resolve(&scene, &volume.header(), None).unwrap();
        let regular = draw(&volume, &plan);
        for sampling in [Sampling::Refine { parts: 1 }, linear(1), cubic(1)] {
            let one = draw(&volume, &sampled(&plan, sampling));
            assert!(one.image == regular.image, "{sampling:?}, {model}");
        }
    }
}

#[test]
fn parts_of_a_ramp_are_the_lattice_that_is_as_many_times_finer() {
    let volume = ramp();
    // Samples of an odd number of parts are those of a lattice with the middle of its steps.
    for (parts, times) in [(3, 3.0), (7, 7.0)] {
        for table in [soft(), peak(40.0)] {
            let plan = plan(&volume, OBLIQUE, table);
            let fine = draw(&volume, &finer(&plan, times));
            let coarse = draw(&volume, &plan);
            assert!(difference(&coarse, &fine) > 2e-3);
            for sampling in [Sampling::Refine { parts }, linear(parts), cubic(parts)] {
                let drawn = draw(&volume, &sampled(&plan, sampling));
                let by = difference(&drawn, &fine);
                assert!(by < 2e-5, "{sampling:?}: {by}");
            }
        }
    }
}

#[test]
fn a_peak_between_two_samples_has_the_opacity_of_its_integral() {
    let volume = ramp();
    // Half a voxel wide, between two samples of a step of 1.3 voxels.
    let table = peak(5.0);
    // ∫ −ln(1 − a(v)) dv over 10 values per mm; the triangle goes to 0.7 and back.
    let depth: f64 = (0..100_000)
        .map(|i| {
            let value = 197.5 + 5.0 * (f64::from(i) + 0.5) / 1e5;
            -(1.0 - f64::from(table.at(value as f32)[3])).ln() * 5.0 / 1e5 / 10.0
        })
        .sum();
    let expected = 1.0 - (-depth).exp();
    let plan = plan(&volume, ALONG, table);
    let alpha = |plan: &Plan| f64::from(draw(&volume, plan).image.pixel(2, 2)[3]);
    assert_eq!(alpha(&plan), 0.0, "a sample meets the peak");
    for sampling in [Sampling::Refine { parts: 64 }, linear(64), cubic(64)] {
        let found = alpha(&sampled(&plan, sampling));
        assert!(
            (found - expected).abs() < 0.01 * expected,
            "{sampling:?}: {found} instead of {expected}"
        );
    }
}

#[test]
fn integrals_of_a_ramp_are_the_converged_picture() {
    let volume = ramp();
    for table in [soft(), peak(40.0), peak(2.0)] {
        let plan = plan(&volume, OBLIQUE, table);
        let fine = draw(&volume, &finer(&plan, 128.0));
        for coarser in [1.0, 2.5] {
            let mut plan = plan.clone();
            plan.lattice.step_mm *= coarser;
            let regular = difference(&draw(&volume, &plan), &fine);
            let drawn = draw(&volume, &sampled(&plan, Sampling::Integrated));
            let by = difference(&drawn, &fine);
            println!("{regular}, integrated {by}");
            assert!(by < 3e-3 && by < 0.2 * regular, "{by}, {regular}");
        }
    }
}

#[test]
fn an_integrated_peak_has_the_opacity_of_its_integral_at_any_step() {
    let volume = ramp();
    for width in [0.01, 1.0, 30.0] {
        let table = peak(width);
        // The mean of −ln(1 − a) over a line from 0 to 0.7, over 10 values per mm.
        let mean = (0.7 + 0.3 * 0.3f64.ln()) / 0.7;
        let expected = 1.0 - (-mean * f64::from(width) / 10.0).exp();
        let plan = plan(&volume, ALONG, table);
        for step_mm in [0.37, 1.3, 4.1, 17.0] {
            let mut plan = sampled(&plan, Sampling::Integrated);
            plan.lattice.step_mm = step_mm;
            let found = f64::from(draw(&volume, &plan).image.pixel(2, 2)[3]);
            assert!(
                (found - expected).abs() < 0.01 * expected,
                "{width} wide, steps of {step_mm}: {found} instead of {expected}"
            );
        }
    }
}

#[test]
fn integrals_end_where_the_ray_does() {
    // A block of one value: its opacity is that of the chord at any step and any beginning.
    let volume = of([6, 6, 20], Samples::F32(vec![100.0; 6 * 6 * 20]));
    let table = TransferTable::new([0.0, 200.0], 1.0, vec![[0.25, 0.5, 1.0, 0.1]; 2]);
    let plan = plan(&volume, ALONG, table);
    let expected = 1.0 - 0.9f64.powi(20);
    for (step_mm, seed) in [(0.7, None), (3.0, None), (3.0, Some(4)), (40.0, Some(9))] {
        let mut plan = sampled(&plan, Sampling::Integrated);
        plan.lattice.step_mm = step_mm;
        if let Some(seed) = seed {
            plan.lattice.jitter = strahl_scene::plan::Jitter::Hash(seed);
        }
        let [r, g, _, found] = draw(&volume, &plan).image.pixel(2, 2).map(f64::from);
        assert!(
            (found - expected).abs() < 1e-5,
            "{step_mm}: {found}, {expected}"
        );
        assert!((r - 0.25 * expected).abs() < 1e-5 && (g - 0.5 * expected).abs() < 1e-5);
    }
}

#[test]
fn what_is_left_is_looked_at_as_closely_as_what_is_entered() {
    // Up to the peak and no further: a thin sheet whose values are shown where the ray enters and leaves it.
    let dims = [6, 6, 41];
    let sample = |i: usize| 10.0 * (20.0 - (i as f32 / 36.0).floor()).abs();
    let volume = of(dims, Samples::F32((0..6 * 6 * 41).map(sample).collect()));
    let plan = plan(&volume, ALONG, peak(30.0).clone());
    let shown = TransferTable::new([90.0, 110.0], 1.0, {
        let entry = |opacity: f32| [1.0, 1.0, 1.0, opacity];
        vec![entry(0.0), entry(0.3), entry(0.0)]
    });
    let mut plan = plan;
    plan.technique_mut().table = shown;
    let alpha = |plan: &Plan| f64::from(draw(&volume, plan).image.pixel(2, 2)[3]);
    let fine = alpha(&finer(&plan, 65.0));
    for sampling in [Sampling::Refine { parts: 65 - 1 }, linear(64)] {
        let found = alpha(&sampled(&plan, sampling));
        assert!(
            (found - fine).abs() < 0.03 * fine,
            "{sampling:?}: {found}, {fine}"
        );
    }
}

#[test]
fn errors_fall() {
    let smooth = Phantom::Shells.volume([40; 3]).unwrap();
    let thin = Phantom::Tree.volume([48; 3]).unwrap();
    for model in ["unlit", "blinn-phong"] {
        let scene = format!(
            r#"{{ "size": [48, 40], "shading": {{ "model": "{model}" }}, "step_voxels": 1, "early_termination": 0 }}"#
        );
        let scene = Scene::parse("scene", &scene).unwrap();
        for (name, volume) in [("smooth", &smooth), ("thin", &thin)] {
            let mut plan = resolve(&scene, &volume.header(), None).unwrap();
            if name == "smooth" {
                // Sheets that are much thinner than a step.
                let [lo, hi] = volume.statistics().range.map(|v| v as f32);
                let entry = |i: usize| [1.0, 0.5, 0.2, if i % 20 == 10 { 0.9 } else { 0.0 }];
                plan.technique_mut().table =
                    TransferTable::new([lo, hi], 1.0, (0..=200).map(entry).collect());
            }
            let converged = draw(volume, &finer(&plan, 32.0));
            let error = |sampling| rms(&draw(volume, &sampled(&plan, sampling)), &converged);
            let regular = error(Sampling::Regular);
            let refined = [2, 4, 8].map(|parts| error(Sampling::Refine { parts }));
            let split = [
                error(linear(10)),
                error(cubic(10)),
                error(Sampling::Integrated),
            ];
            println!("{model}, {name}: {regular}, refined {refined:?}, split {split:?}");
            assert!(refined[2] < 0.4 * regular);
            assert!(refined[2] < refined[1] && refined[1] < refined[0]);
            // Between samples that miss what is thinner than a step, no curve brings it back.
            let bound = if name == "smooth" { 0.5 } else { 1.5 };
            assert!(split.iter().all(|&error| error < bound * regular));
        }
    }
}

/// A number for everything that is drawn by chance.
struct Random(u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.below(from.len())]
    }

    fn unit(&mut self) -> f32 {
        self.below(1 << 20) as f32 / (1 << 20) as f32
    }

    /// Blocks of few values with ramps between, noise on some of them.
    fn volume(&mut self) -> Volume {
        let dims: [usize; 3] = std::array::from_fn(|_| 1 + self.below(40));
        let block = 1 + self.below(12);
        let noise = self.pick(&[0.0, 0.0, 2.0, 255.0]);
        let levels: Vec<f32> = (0..8).map(|_| (self.below(256)) as f32).collect();
        let seed = self.bits();
        let mut samples = Vec::new();
        for z in 0..dims[2] {
            for y in 0..dims[1] {
                for x in 0..dims[0] {
                    let place = (x / block) + 7 * (y / block) + 31 * (z / block);
                    let level = levels[Random(seed ^ place as u64).below(8)];
                    samples.push((level + noise * (self.unit() - 0.5)).clamp(0.0, 255.0));
                }
            }
        }
        if self.below(4) == 0 {
            for _ in 0..1 + self.below(40) {
                let at = self.below(samples.len());
                samples[at] = self.pick(&[f32::NAN, f32::INFINITY, -1e20]);
            }
            return of(dims, Samples::F32(samples));
        }
        match self.below(2) {
            0 => of(dims, Samples::F32(samples)),
            _ => of(
                dims,
                Samples::U8(samples.iter().map(|&v| v as u8).collect()),
            ),
        }
    }

    fn table(&mut self, reference_mm: f64) -> TransferTable {
        let number = self.pick(&[2, 5, 64, 256, 1024]);
        let kind = self.below(3);
        let steps = 1 + self.below(6);
        let colors: Vec<[f32; 3]> = (0..=steps)
            .map(|_| std::array::from_fn(|_| self.unit()))
            .collect();
        let strength = self.pick(&[0.02, 0.3, 1.0]);
        let shown: Vec<f32> = (0..=steps).map(|_| self.pick(&[0.0, 0.4, 1.0])).collect();
        let entries = (0..number).map(|i| {
            let x = i as f32 / (number - 1) as f32;
            let part = ((x * steps as f32) as usize).min(steps);
            let [r, g, b] = colors[part];
            let opacity = match kind {
                // Peaks one entry wide.
                0 => f32::from(u8::from(self.below(12) == 0)),
                // Plateaus.
                1 => shown[part],
                _ => (1.5 * x - 0.5).max(0.0),
            };
            [r, g, b, opacity * strength]
        });
        let entries = entries.collect();
        TransferTable::new([0.0, 255.0], reference_mm as f32, entries)
    }

    /// A slow wave of values.
    fn wave(&mut self) -> Volume {
        let dims: [usize; 3] = std::array::from_fn(|_| 8 + self.below(40));
        let speed: [f32; 3] = std::array::from_fn(|_| 0.3 * (self.unit() - 0.5));
        let height = self.pick(&[1.0, 10.0, 100.0]);
        let mut samples = Vec::new();
        for z in 0..dims[2] {
            for y in 0..dims[1] {
                for x in 0..dims[0] {
                    let angle = speed[0] * x as f32 + speed[1] * y as f32 + speed[2] * z as f32;
                    samples.push(127.0 + height * angle.sin());
                }
            }
        }
        of(dims, Samples::F32(samples))
    }

    /// Colors and opacities that change slowly.
    fn gentle_table(&mut self, reference_mm: f64) -> TransferTable {
        let from: [f32; 4] = std::array::from_fn(|_| 0.05 + 0.6 * self.unit());
        let by: [f32; 4] = std::array::from_fn(|_| 0.3 * self.unit());
        let entry = |i: usize| std::array::from_fn(|c| from[c] + by[c] * i as f32 / 255.0);
        TransferTable::new(
            [0.0, 255.0],
            reference_mm as f32,
            (0..256).map(entry).collect(),
        )
    }

    fn plan(&mut self, volume: &Volume) -> Plan {
        let model = self.pick(&["unlit", "unlit", "blinn-phong", "gradient-opacity"]);
        let reconstruct = self.pick(&[
            "trilinear",
            "trilinear",
            "nearest",
            "b-spline",
            "b-spline-interpolating",
            "catmull-rom",
        ]);
        let [lowest, highest] = volume.statistics().range;
        // No gradient is steep for a volume of one value.
        let model = if lowest < highest { model } else { "unlit" };
        let whole = volume.statistics().not_finite == 0 && volume.statistics().range[0] >= 0.0;
        let reconstruct = if whole { reconstruct } else { "trilinear" };
        let jitter = self.pick(&[r#""off""#, r#"{ "seed": 3 }"#]);
        let projection = self.pick(&["perspective", "orthographic"]);
        let clips = self.pick(&[
            "[]",
            "[]",
            r#"[{ "box": { "min": [-9, -5, -9], "max": [6, 9, 3], "keep": "inside" } }]"#,
        ]);
        let scene = format!(
            r#"{{ "size": [21, 13], "shading": {{ "model": "{model}" }}, "reconstruct": "{reconstruct}",
                "background": "transparent", "jitter": {jitter}, "clips": {clips},
                "camera": {{ "azimuth_deg": {}, "elevation_deg": {}, "projection": "{projection}" }} }}"#,
            self.below(360),
            self.below(178) as i32 - 89,
        );
        let step_mm = self.pick(&[0.3, 0.5, 1.0, 2.0, 3.9, 4.5, 9.0]);
        let reference_mm = step_mm * self.pick(&[0.3, 1.0, 4.0]);
        let mut plan = plan(volume, &scene, self.table(reference_mm));
        plan.lattice.step_mm = step_mm;
        plan.technique_mut().composite = Composite::EmissionAbsorption {
            stop_at_transmittance: self.pick(&[0.0, 1.0 / 256.0, 0.3]),
        };
        let parts = self.pick(&[2, 3, 8]);
        let is_unlit = model == "unlit";
        let by_opacity = Sampling::ByOpacity {
            share: self.pick(&[0.01, 0.1, 1.0]),
        };
        plan.sampling = match self.below(if is_unlit { 8 } else { 6 }) {
            4 | 5 => by_opacity,
            0 => Sampling::Refine { parts },
            1 => linear(parts),
            2 => cubic(parts),
            3 => Sampling::Integrated,
            _ => Sampling::Adaptive {
                error: self.pick(&[0.001, 0.05, 0.5]),
            },
        };
        plan
    }
}

#[test]
fn neither_skipping_nor_anything_else_changes_a_byte() {
    let (mut skipping, mut shown) = (0, 0);
    for seed in 0..1500 {
        let mut random = Random(seed);
        let volume = random.volume();
        let plan = random.plan(&volume);
        let renderer = Renderer::new(&volume);
        let plainly = Options {
            threads: 1,
            tile: 1 << 16,
            skip: false,
            instructions: Some(InstructionSet::Portable),
        };
        let expected = draw_with(&renderer, &plan, &plainly);
        for set in InstructionSet::ALL.into_iter().filter(|set| set.is_there()) {
            let options = Options {
                threads: random.pick(&[1, 2, 7]),
                tile: random.pick(&[1, 7, 32]),
                skip: true,
                instructions: Some(set),
            };
            let found = draw_with(&renderer, &plan, &options);
            let bits = |drawn: &Rendered| -> Vec<[u32; 4]> {
                drawn
                    .image
                    .pixels()
                    .iter()
                    .map(|p| p.map(f32::to_bits))
                    .collect()
            };
            assert!(
                bits(&found) == bits(&expected),
                "seed {seed}, {options:?}, {:?}, {:?}, step {}",
                plan.sampling,
                plan.field().reconstruct,
                plan.lattice.step_mm
            );
            skipping += usize::from(found.stats.counts.unwrap().points_skipped > 0);
        }
        shown += usize::from(expected.stats.counts.unwrap().samples_visible > 0);
    }
    assert!(
        skipping > 800 && shown > 700,
        "{skipping} skip, {shown} show something"
    );
}

#[test]
fn what_is_left_out_changes_no_pixel_by_more_than_the_error() {
    let (mut samples, mut regular_samples) = (0, 0);
    let (mut changed, mut worst) = (0, 0.0f64);
    for seed in 0..1500 {
        let mut random = Random(seed ^ 0xADA);
        let is_gentle = seed % 2 == 0;
        let volume = if is_gentle {
            random.wave()
        } else {
            random.volume()
        };
        let mut plan = random.plan(&volume);
        if is_gentle {
            let reference_mm = f64::from(plan.technique().table.reference_mm());
            plan.technique_mut().table = random.gentle_table(reference_mm);
        }
        plan.technique_mut().shade = strahl_scene::plan::Shade::Unlit;
        plan.technique_mut().composite = Composite::EmissionAbsorption {
            stop_at_transmittance: 0.0,
        };
        let error = random.pick(&[0.002, 0.02, 0.2, 0.5]);
        let regular = draw(&volume, &sampled(&plan, Sampling::Regular));
        let adaptive = draw(&volume, &sampled(&plan, Sampling::Adaptive { error }));
        let by = difference(&adaptive, &regular);
        assert!(
            by <= f64::from(error) + 2e-5,
            "seed {seed}: {by} with an error of {error}"
        );
        assert!(adaptive.stats.counts.unwrap().samples <= regular.stats.counts.unwrap().samples);
        worst = worst.max(by / f64::from(error));
        changed += usize::from(by > 1e-4);
        samples += adaptive.stats.counts.unwrap().samples;
        regular_samples += regular.stats.counts.unwrap().samples;
    }
    println!(
        "{samples} of {regular_samples} samples, {changed} pictures changed, by up to {worst} of the error"
    );
    assert!(samples * 10 < regular_samples * 9 && changed > 50);
}

proptest! {
    /// Twice the same plateau: nothing changes but rounding, and most samples are left out.
    #[test]
    fn plateaus_are_free(level in 20f32..200.0, opacity in 0.01f32..0.5) {
        let volume = of([32; 3], Samples::F32(vec![level; 32 * 32 * 32]));
        let entry = [0.3, 0.6, 0.9, opacity];
        let table = TransferTable::new([0.0, 255.0], 1.0, vec![entry; 16]);
        let plan = plan(&volume, OBLIQUE, table);
        let regular = draw(&volume, &sampled(&plan, Sampling::Regular));
        let adaptive = draw(&volume, &sampled(&plan, Sampling::Adaptive { error: 1e-4 }));
        prop_assert!(difference(&adaptive, &regular) < 1e-5);
        prop_assert!(adaptive.stats.counts.unwrap().samples * 4 < regular.stats.counts.unwrap().samples);
    }
}

fn by_opacity(share: f32) -> Sampling {
    Sampling::ByOpacity { share }
}

#[test]
fn strides_that_may_show_nothing_are_the_regular_picture() {
    let volume = Phantom::Tree.volume([40; 3]).unwrap();
    for model in ["unlit", "phong"] {
        let scene = format!(r#"{{ "size": [40, 32], "shading": {{ "model": "{model}" }} }}"#);
        let scene = Scene::parse("scene", &scene).unwrap();
        let plan = resolve(&scene, &volume.header(), None).unwrap();
        let regular = draw(&volume, &plan);
        let found = draw(&volume, &sampled(&plan, by_opacity(1e-9)));
        assert_eq!(found.image, regular.image, "{model}");
        assert_eq!(
            found.stats.counts.unwrap().samples,
            regular.stats.counts.unwrap().samples
        );
    }
}

/// Faint fog with one slice of voxels that nothing is seen through.
#[test]
fn strides_do_not_step_over_thin_sheets() {
    let dims = [24, 24, 40];
    let sample = |i: usize| if i / (24 * 24) == 21 { 200.0 } else { 100.0 };
    let volume = of(dims, Samples::F32((0..24 * 24 * 40).map(sample).collect()));
    let entry = |i: usize| match i {
        0..=185 => [0.5, 0.5, 0.5, 0.01],
        _ => [1.0, 0.0, 0.0, 0.95],
    };
    let table = TransferTable::new([0.0, 255.0], 1.0, (0..256).map(entry).collect());
    let mut plan = plan(&volume, ALONG, table);
    // The sheet is opaque over 0.28 voxels: every third step falls into it.
    plan.lattice.step_mm = 0.09;
    let regular = draw(&volume, &sampled(&plan, Sampling::Regular));
    let found = draw(&volume, &sampled(&plan, by_opacity(0.1)));
    assert!(difference(&found, &regular) < 2e-3);
    assert!(found.stats.counts.unwrap().samples * 2 < regular.stats.counts.unwrap().samples);
}

/// In fog of one value a sample for several steps is exact.
#[test]
fn strides_through_fog_change_nothing() {
    let volume = of([32; 3], Samples::F32(vec![100.0; 32 * 32 * 32]));
    let table = TransferTable::new([0.0, 255.0], 1.0, vec![[0.3, 0.6, 0.9, 0.05]; 16]);
    let plan = plan(&volume, OBLIQUE, table);
    let plan = Plan {
        lattice: strahl_scene::plan::Lattice {
            step_mm: 0.5,
            ..plan.lattice
        },
        ..plan
    };
    let regular = draw(&volume, &sampled(&plan, Sampling::Regular));
    let found = draw(&volume, &sampled(&plan, by_opacity(0.11)));
    assert!(difference(&found, &regular) < 1e-5);
    // All but the last ones of rays stand for four.
    assert!(found.stats.counts.unwrap().samples * 3 < regular.stats.counts.unwrap().samples);
}

/// Opaque in the middle of much fog: half the step, and longer ones in the fog.
#[test]
fn strides_are_nearer_to_the_truth_with_fewer_samples() {
    let along = |i: usize| (i as f32 - 31.5) / 31.5;
    let sample = |i: usize| {
        let [x, y, z] = [along(i % 64), along(i / 64 % 64), along(i / 4096)];
        255.0 * (1.0 - (x * x + y * y + z * z).sqrt()).max(0.0)
    };
    let volume = of(
        [64; 3],
        Samples::F32((0..64 * 64 * 64).map(sample).collect()),
    );
    let entry = |i: usize| match i {
        0..200 => [0.5, 0.5, 0.5, 0.02 * (i as f32 / 200.0)],
        _ => [1.0, 0.7, 0.2, 0.7],
    };
    let entries: Vec<[f32; 4]> = (0..256).map(entry).collect();
    for model in ["unlit", "phong"] {
        let scene = format!(r#"{{ "size": [96, 72], "shading": {{ "model": "{model}" }} }}"#);
        let mut plan = plan(
            &volume,
            &scene,
            TransferTable::new([0.0, 255.0], 1.0, entries.clone()),
        );
        plan.technique_mut().composite = Composite::EmissionAbsorption {
            stop_at_transmittance: 1.0 / 256.0,
        };
        plan.lattice.step_mm = 1.0;
        let truth = draw(&volume, &finer(&plan, 16.0));
        let regular = draw(&volume, &plan);
        let mut half = sampled(&plan, by_opacity(0.15));
        half.lattice.step_mm = 0.5;
        let found = draw(&volume, &half);
        let (regular_error, error) = (rms(&regular, &truth), rms(&found, &truth));
        println!(
            "{model}: {error} with {} samples, {regular_error} with {}",
            found.stats.counts.unwrap().samples,
            regular.stats.counts.unwrap().samples
        );
        assert!(error < 0.8 * regular_error, "{model}");
        assert!(
            found.stats.counts.unwrap().samples * 10 < regular.stats.counts.unwrap().samples * 9,
            "{model}"
        );
    }
}

/// Long enough for bounds of more than a brick.
#[test]
fn projections_of_long_volumes_have_the_same_bytes_with_skipping() {
    let along = [
        ("left", 0, [1201, 3, 5]),
        ("front", 1, [4, 700, 6]),
        ("top", 2, [7, 2, 530]),
    ];
    for (view, axis, dims) in along {
        let mut random = Random(dims[0] as u64);
        let number: usize = dims.iter().product();
        let stride: usize = dims[..axis].iter().product();
        // Noise about three levels along the long axis, three times.
        let mut sample = |i: usize| {
            let along = 9 * (i / stride % dims[axis]) / dims[axis];
            (100 * (along % 3) + random.below(50)) as u8
        };
        let samples = (0..number).map(&mut sample).collect();
        let volume = of(dims, Samples::U8(samples));
        for method in ["mip", "minip"] {
            for rule in ["regular", "refine"] {
                let scene = format!(
                    r#"{{ "size": [64, 48], "method": "{method}", "sampling": {{ "rule": "{rule}" }},
                        "camera": {{ "view": "{view}", "azimuth_deg": 0.1, "elevation_deg": 0.1, "zoom": 50 }} }}"#
                );
                let scene = Scene::parse("scene", &scene).unwrap();
                let plan = resolve(&scene, &volume.header(), None).unwrap();
                let renderer = Renderer::new(&volume);
                let all = Options {
                    skip: false,
                    ..Options::default()
                };
                let found = draw_with(&renderer, &plan, &Options::default());
                let expected = draw_with(&renderer, &plan, &all);
                assert_eq!(found.image, expected.image, "{dims:?}, {method}, {rule}");
                assert!(
                    found.stats.counts.unwrap().samples < expected.stats.counts.unwrap().samples
                );
            }
        }
    }
}

/// Refined projections are nearer to those of shorter steps, and never on the other side of the regular ones.
#[test]
fn refined_projections_are_nearer_to_the_truth() {
    let volume = Random(5).wave();
    for (method, sign) in [("mip", 1.0), ("minip", -1.0)] {
        let scene = format!(
            r#"{{ "size": [48, 40], "method": "{method}", "step_voxels": 2, "shading": {{ "model": "unlit" }},
                "background": "transparent", "camera": {{ "azimuth_deg": 25, "elevation_deg": 40, "zoom": 3 }} }}"#
        );
        let scene = Scene::parse("scene", &scene).unwrap();
        let mut plan = resolve(&scene, &volume.header(), None).unwrap();
        let [lo, hi] = volume.statistics().range;
        // The value itself, as opaque gray.
        let table = TransferTable::new(
            [lo as f32, hi as f32],
            1.0,
            vec![[0.0, 0.0, 0.0, 1.0], [1.0, 1.0, 1.0, 1.0]],
        );
        plan.technique_mut().table = table;
        let truth = draw(&volume, &finer(&plan, 32.0));
        let regular = draw(&volume, &plan);
        let refined = draw(&volume, &sampled(&plan, Sampling::Refine { parts: 8 }));
        let pairs = regular.image.pixels().iter().zip(refined.image.pixels());
        let further = pairs.filter(|(a, b)| sign * (b[0] - a[0]) > 0.0).count();
        let back = regular.image.pixels().iter().zip(refined.image.pixels());
        assert!(back.into_iter().all(|(a, b)| sign * (b[0] - a[0]) >= 0.0));
        let (regular_error, error) = (rms(&regular, &truth), rms(&refined, &truth));
        println!("{method}: {regular_error}, refined {error}, {further} pixels changed");
        assert!(error < 0.5 * regular_error, "{method}");
    }
}
