//! A lattice that is cut into intervals, the states of its rays stored in between, gives the bytes of one that is not.

use crate::random::{Random, seeds};
use crate::segments::{any_segments, data};
use crate::variants::any_of;
use std::ops::{ControlFlow, Range};
use std::sync::atomic::{AtomicUsize, Ordering};
use strahl_cpu::{InstructionSet, Options, Renderer};
use strahl_scene::plan::{Composite, Plan, Sampling, Shade};
use strahl_scene::{Counts, Rendered};
use strahl_volume::{Control, Datasets, Grid, Volume};

/// Pixels and distances as bits, so that NaN equals itself and 0 is not −0.
fn bits(drawn: &Rendered) -> Vec<u32> {
    let pixels = drawn.image.pixels().iter().flatten();
    let depth = drawn.depth_mm.iter().flatten();
    pixels.chain(depth).map(|number| number.to_bits()).collect()
}

/// The lattice cut at random, in the order in which `plan` goes along it.
fn intervals(random: &mut Random, plan: &Plan, longest: u32) -> Vec<Range<u32>> {
    let mut ends: Vec<u32> = (0..1 + random.below(5))
        .map(|_| random.below(longest as usize + 2) as u32)
        .collect();
    ends.extend([0, u32::MAX]);
    ends.sort_unstable();
    let mut intervals: Vec<_> = ends.windows(2).map(|ends| ends[0]..ends[1]).collect();
    if plan.composite() == Composite::BackToFront {
        intervals.reverse();
    }
    intervals
}

/// Draws `plan` at once and in random cuts, with the same options for all intervals or with any for each.
fn check(random: &mut Random, what: &str, renderer: &Renderer, plan: &Plan) {
    let sets = InstructionSet::ALL.into_iter().filter(|set| set.is_there());
    let sets: Vec<_> = sets.collect();
    let options = |random: &mut Random| Options {
        threads: random.pick(&[1, 2]),
        tile: random.pick(&[1, 5, 8, 1 << 16]),
        skip: !random.once_in(3),
        instructions: Some(random.pick(&sets)),
    };
    let first = options(random);
    let at_once = renderer.render(plan, &first, &Control::NONE).unwrap();
    let counts = at_once.stats.counts.unwrap();
    let longest = counts.lattice_points / counts.rays_in_volume.max(1);
    let is_constant = random.once_in(2);
    let mut states = renderer.start(plan, &first).unwrap();
    for interval in intervals(random, plan, 2 * longest as u32) {
        let options = if is_constant { first } else { options(random) };
        // Again: no ray stands there any more.
        for _ in 0..2 {
            let interval = interval.clone();
            let marched = renderer.march(plan, interval, &mut states, &options, &Control::NONE);
            marched.unwrap();
        }
    }
    let options = if is_constant { first } else { options(random) };
    let in_cuts = renderer
        .finish(plan, &states, &options, &Control::NONE)
        .unwrap();
    let (expected, found) = (bits(&at_once), bits(&in_cuts));
    if let Some(i) = (0..expected.len()).find(|&i| expected[i] != found[i]) {
        let [expected, found] = [expected[i], found[i]].map(f32::from_bits);
        let (composite, sampling) = (plan.composite(), plan.sampling);
        panic!("{what}: number {i} is {found} instead of {expected}; {composite:?}, {sampling:?}");
    }
    let (a, b) = (counts, in_cuts.stats.counts.unwrap());
    assert_eq!(
        (a.lattice_points, a.rays_in_volume),
        (b.lattice_points, b.rays_in_volume),
        "{what}"
    );
    let is_extreme = matches!(plan.composite(), Composite::Mip | Composite::Minip);
    if is_constant && !is_extreme {
        let of_samples = |s: &Counts| {
            [
                s.samples,
                s.samples_visible,
                s.points_skipped,
                s.rays_ended_early,
            ]
        };
        assert_eq!(of_samples(&a), of_samples(&b), "{what}");
    }
}

/// Any composite of the registry, with random values.
fn any_composite(random: &mut Random, plan: &mut Plan, volume: &Volume) {
    let [lo, hi] = volume
        .statistics()
        .range
        .map(|end| end.clamp(-1e9, 1e9) as f32);
    let per_mm = (hi - lo).max(1.0);
    let technique = plan.technique_mut();
    if random.once_in(2) {
        let (name, values) = any_of("composite", random, [lo, lo + per_mm], per_mm);
        technique.composite = Composite::of(name, |parameter| values[parameter]).unwrap();
        if !technique.composite.function().has_place {
            technique.shade = Shade::Unlit;
        }
    }
    match &mut technique.shade {
        Shade::Lit {
            keep_last_normal, ..
        } => *keep_last_normal = random.once_in(3),
        Shade::Unlit if random.once_in(6) => {
            if let Composite::EmissionAbsorption { .. } = technique.composite {
                technique.shade = Shade::GradientOpacity {
                    full_per_mm: per_mm,
                };
            }
        }
        _ => {}
    }
}

#[test]
fn of_one_volume() {
    for seed in seeds(500) {
        let mut random = Random::new(seed ^ 0xC075);
        let volume = random.volume();
        let mask = random.volume();
        let mut plan = random.plan(&volume, [19, 13]);
        any_composite(&mut random, &mut plan, &volume);
        plan.sampling = random.sampling(&plan);
        plan.lattice.frames = random.pick(&[1, 1, 1, 3]);
        plan.with_depth = random.once_in(2);
        if random.once_in(4) {
            let clip = random.sample_clip(volume.grid(), &mask);
            plan.sample_clips.push(clip);
        }
        let data = Datasets {
            masks: vec![mask],
            ..Datasets::from(&volume)
        };
        let renderer = Renderer::new(data);
        check(&mut random, &format!("seed {seed}"), &renderer, &plan);
    }
}

#[test]
fn by_every_rule_of_sampling() {
    let mut others = 0;
    for seed in seeds(250) {
        let mut random = Random::new(seed ^ 0xC076);
        let volume = random.volume();
        let mut plan = random.plan(&volume, [19, 13]);
        while plan.sampling == Sampling::Regular && !random.once_in(8) {
            plan = random.plan(&volume, [19, 13]);
            plan.sampling = random.sampling(&plan);
        }
        others += usize::from(plan.sampling != Sampling::Regular);
        let renderer = Renderer::new(&volume);
        check(&mut random, &format!("seed {seed}"), &renderer, &plan);
    }
    assert!(others >= 150, "{others}");
}

#[test]
fn of_several_volumes() {
    for seed in seeds(200) {
        let mut random = Random::new(seed ^ 0xC077);
        let volumes = [random.volume(), random.volume()];
        let mut plan = random.plan(&volumes[0], [19, 13]);
        plan.technique_mut().composite = match random.below(3) {
            0 => Composite::BackToFront,
            _ => Composite::EmissionAbsorption {
                stop_at_transmittance: random.pick(&[0.0, 0.1]),
            },
        };
        let second = random.plan(&volumes[1], [19, 13]);
        let mut field = *second.field();
        field.volume = 1;
        // All layers read their fields the same way.
        let first = *plan.field();
        (field.fetch, field.reconstruct) = (first.fetch, first.reconstruct);
        field.gradient = first.gradient;
        // As large as the first one, and a little beside it.
        let mut placed = volumes[0].grid().world_from_voxel();
        placed.translation += 0.2 * (volumes[0].grid().center_mm() - placed.translation);
        field.grid = Grid::new(field.grid.dims(), placed).unwrap();
        field.is_moved = true;
        let mut technique = plan.technique().clone();
        technique.table = second.technique().table.clone();
        plan.add_layer(field, technique);
        let data = Datasets {
            volumes: volumes.to_vec(),
            ..Datasets::from(&volumes[0])
        };
        let renderer = Renderer::new(data);
        check(&mut random, &format!("seed {seed}"), &renderer, &plan);
    }
}

/// Each ray is then in the middle of a run by any local rule.
#[test]
fn of_segments() {
    for seed in seeds(150) {
        let mut random = Random::new(seed ^ 0xC079);
        let (volume, labels, plan) = any_segments(&mut random);
        let renderer = Renderer::new(data(&volume, &labels));
        check(&mut random, &format!("seed {seed}"), &renderer, &plan);
    }
}

/// What a march that was cancelled has left undone the next one does.
#[test]
fn cancelled_and_gone_on() {
    for seed in seeds(40) {
        let mut random = Random::new(seed ^ 0xC078);
        let volume = random.volume();
        let plan = random.plan(&volume, [19, 13]);
        let renderer = Renderer::new(&volume);
        let options = Options {
            tile: 4,
            ..Options::default()
        };
        let mut states = renderer.start(&plan, &options).unwrap();
        let told = AtomicUsize::new(0);
        let stop = Control::listening(move |_, _| match told.fetch_add(1, Ordering::Relaxed) {
            0..20 => ControlFlow::Continue(()),
            _ => ControlFlow::Break(()),
        });
        let all = 0..u32::MAX;
        let cancelled = renderer.march(&plan, all.clone(), &mut states, &options, &stop);
        assert!(matches!(cancelled, Err(strahl_cpu::Error::Cancelled)));
        let marched = renderer.march(&plan, all, &mut states, &options, &Control::NONE);
        marched.unwrap();
        let in_parts = renderer.finish(&plan, &states, &options, &Control::NONE);
        let at_once = renderer.render(&plan, &options, &Control::NONE);
        assert_eq!(
            bits(&in_parts.unwrap()),
            bits(&at_once.unwrap()),
            "seed {seed}"
        );
    }
}

#[test]
fn rays_of_another_picture_are_refused() {
    let mut random = Random::new(7);
    let volume = random.volume();
    let plan = random.plan(&volume, [19, 13]);
    let other = random.plan(&volume, [13, 19]);
    let renderer = Renderer::new(&volume);
    let options = Options::default();
    let states = renderer.start(&other, &options).unwrap();
    let finished = renderer.finish(&plan, &states, &options, &Control::NONE);
    assert_eq!(
        finished.unwrap_err().to_string(),
        "the plan has [19, 13, 1] rays (columns, rows, frames), the states are those of [13, 19, 1]; march the states that were started for this plan"
    );
}
