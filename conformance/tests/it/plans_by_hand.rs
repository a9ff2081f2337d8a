//! Plans that `resolve` would not make: each is refused with what is wrong, by every renderer, before anything is drawn.

use crate::random::Random;
use crate::segments::{any_segments, data};
use strahl_conformance::device;
use strahl_evaluate::Evaluator;
use strahl_scene::plan::{
    Classify, Composite, Curve, Field, GradientInput, Illustrate, MOST_LAYERS, Plan, Reconstruct,
    Sampling, SegmentLook, Segments,
};
use strahl_volume::{Control, Datasets};

type Change = fn(&mut Plan);

const WHOLE: [(Change, &str); 21] = [
    (|plan| plan.width = 0, "width is 0; it has to be 1 to 65535"),
    (|plan| plan.height = 65_536, "height is 65536"),
    (|plan| plan.lattice.frames = 0, "lattice.frames is 0"),
    (|plan| plan.lattice.step_mm = 0.0, "lattice.step_mm is 0"),
    (|plan| plan.lattice.step_mm = -1.0, "lattice.step_mm is -1"),
    (
        |plan| plan.lattice.step_mm = f64::NAN,
        "lattice.step_mm is NaN",
    ),
    (
        |plan| plan.lattice.step_mm = f64::INFINITY,
        "lattice.step_mm is inf",
    ),
    (
        |plan| plan.layers.clear(),
        "the number of layers is 0; it has to be 1 to 8",
    ),
    (
        |plan| plan.layers = vec![plan.layers[0].clone(); MOST_LAYERS + 1],
        "the number of layers is 9",
    ),
    (
        |plan| plan.fields.clear(),
        "a layer asks for field 0, of which there are 0",
    ),
    (|plan| plan.layers[0].field = 5, "a layer asks for field 5"),
    (
        |plan| plan.techniques.clear(),
        "a layer asks for technique 0, of which there are 0",
    ),
    (
        |plan| plan.layers[0].segments = Segments::Whole { technique: 9 },
        "a layer asks for technique 9",
    ),
    (
        |plan| {
            plan.technique_mut().composite = Composite::Mip;
            add_the_same(plan);
        },
        "works on the values of one volume",
    ),
    (
        |plan| {
            plan.sampling = Sampling::Refine { parts: 2 };
            add_the_same(plan);
        },
        "\"refine\" is for one layer",
    ),
    (
        |plan| {
            plan.technique_mut().composite = Composite::Mip;
            plan.sampling = Sampling::Integrated;
        },
        "\"integrated\" is for one layer by emission and absorption",
    ),
    (
        |plan| {
            plan.technique_mut().composite = Composite::Average;
            plan.technique_mut().illustrate = Illustrate::Halo {
                width_mm: 1.0,
                reach_mm: 1.0,
                strength: 1.0,
                steps: 1,
            };
        },
        "`illustrate` has to be Plain",
    ),
    (
        |plan| {
            plan.technique_mut().illustrate = Illustrate::Halo {
                width_mm: 1.0,
                reach_mm: 1.0,
                strength: 1.0,
                steps: 4_000_000_000,
            };
        },
        "steps of a halo is 4000000000; it has to be 1 to 64",
    ),
    (
        |plan| {
            plan.technique_mut().classify = Classify::GradientTable {
                low_per_mm: 1.0,
                high_per_mm: 2.0,
            };
            plan.technique_mut().gradient_input = GradientInput::Segment;
        },
        "it has to be Value",
    ),
    (
        |plan| {
            plan.technique_mut().composite = Composite::Average;
            plan.sampling = Sampling::Split {
                parts: 2,
                curve: Curve::Linear,
            };
        },
        "is for one layer by emission and absorption",
    ),
    (
        |plan| {
            add_the_same(plan);
            plan.fields[1].reconstruct = Reconstruct::Nearest;
        },
        "which have to be the same",
    ),
];

const LABELED: [(Change, &str); 6] = [
    (
        |plan| techniques(plan, Some(9)),
        "a layer asks for technique 9",
    ),
    (
        |plan| techniques(plan, Some(usize::MAX)),
        "a layer asks for technique",
    ),
    (|plan| plan.techniques.clear(), "of which there are 0"),
    (add_the_same, "beside other layers"),
    (
        |plan| plan.sampling = Sampling::Refine { parts: 2 },
        "sampled by the rule \"refine\"",
    ),
    (
        |plan| plan.techniques[2].composite = Composite::BackToFront,
        "make no sample of a run",
    ),
];

fn add_the_same(plan: &mut Plan) {
    let field: Field = *plan.field();
    let technique = plan.technique().clone();
    plan.add_layer(field, technique);
}

/// The technique of a segment.
fn techniques(plan: &mut Plan, technique: Option<usize>) {
    if let Segments::Labeled(labeled) = &mut plan.layers[0].segments {
        let look = technique.map_or(SegmentLook::HIDDEN, SegmentLook::of);
        labeled.looks.insert(300, look);
    }
}

fn refused(data: &Datasets, plan: &Plan, expected: &str) {
    let (options, control) = (strahl_cpu::Options::default(), Control::NONE);
    let cpu = strahl_cpu::Renderer::new(data);
    let mut messages = vec![
        cpu.render(plan, &options, &control)
            .map(|_| ())
            .unwrap_err()
            .to_string(),
        cpu.start(plan, &options)
            .map(|_| ())
            .unwrap_err()
            .to_string(),
    ];
    let here = Evaluator::new(data).render(plan, &control);
    messages.push(here.map(|_| ()).unwrap_err().to_string());
    if let Some(device) = device() {
        let gpu = strahl_gpu::Renderer::new(device, data.clone()).render(plan, &control);
        messages.push(gpu.map(|_| ()).unwrap_err().to_string());
    }
    for message in messages {
        assert!(
            message.contains(expected),
            "{message} instead of {expected}"
        );
    }
}

#[test]
fn each_is_refused_by_name() {
    let (volume, labels, labeled) = any_segments(&mut Random::new(7));
    let data = data(&volume, &labels);
    let mut whole = labeled.clone();
    whole.layers[0].segments = Segments::Whole { technique: 0 };
    whole.technique_mut().composite = Composite::EmissionAbsorption {
        stop_at_transmittance: 0.0,
    };
    whole.technique_mut().illustrate = Illustrate::Plain;
    for (change, expected) in WHOLE {
        let mut plan = whole.clone();
        change(&mut plan);
        refused(&data, &plan, expected);
    }
    for (change, expected) in LABELED {
        let mut plan = labeled.clone();
        change(&mut plan);
        refused(&data, &plan, expected);
    }
}

/// A picture without room ends in a message, as does a tile larger than the picture in a picture.
#[test]
fn sizes_end_in_a_message_or_a_picture() {
    let (volume, labels, mut plan) = any_segments(&mut Random::new(7));
    let renderer = strahl_cpu::Renderer::new(data(&volume, &labels));
    let options = strahl_cpu::Options {
        tile: u32::MAX,
        ..Default::default()
    };
    let draw = |plan: &Plan, options| renderer.render(plan, options, &Control::NONE).unwrap();
    let at_once = draw(&plan, &options);
    let in_tiles = draw(&plan, &Default::default());
    assert!(at_once.image == in_tiles.image);
    let many = strahl_cpu::Options {
        threads: 100_000,
        ..options
    };
    let message = renderer
        .render(&plan, &many, &Control::NONE)
        .unwrap_err()
        .to_string();
    assert!(message.contains("at most 1024 draw together"), "{message}");
    (plan.width, plan.height, plan.lattice.frames) = (65_535, 65_535, 65_536);
    let message = renderer.start(&plan, &options).unwrap_err().to_string();
    assert!(message.contains("make the picture smaller"), "{message}");
}
