//! Every function of the library, alone and linked.

use crate::{loop_over, one};
use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;
use strahl_shader::registry::Function;
use strahl_shader::{
    Fold, Linker, Module, Program, SLOTS, Selection, Texels, built_in, library, slot,
};

/// One function in every slot, so that everything can be needed.
fn full() -> Selection {
    [
        ("clip_ray", "plane"),
        ("jitter", "hash"),
        ("clip_sample", "box"),
        ("fetch", "stored"),
        ("reconstruct", "trilinear"),
        ("classify", "table"),
        ("gradient_input", "value"),
        ("gradient", "central"),
        ("light", "head"),
        ("illuminate", "blinn_phong"),
        ("shade", "lit"),
        ("composite", "emission_absorption"),
    ]
    .into_iter()
    .fold(Selection::new(), |selection, (slot, name)| {
        selection.with(built_in(slot, name).unwrap())
    })
}

fn with(modules: &[Arc<Module>]) -> Selection {
    let mut selection = Selection::new();
    for slot in &SLOTS {
        let own: Vec<_> = modules.iter().filter(|m| m.slot() == slot).collect();
        let of_slot = if own.is_empty() {
            full().of(slot).to_vec()
        } else {
            own.into_iter().cloned().collect()
        };
        for module in of_slot {
            selection = selection.with(module);
        }
    }
    selection
}

#[test]
fn every_function_can_be_read() {
    for module in library() {
        assert!(!module.meaning().is_empty(), "{}", module.file());
        for parameter in module.parameters() {
            assert!(
                !parameter.meaning.is_empty(),
                "{}: {}",
                module.file(),
                parameter.name
            );
        }
    }
}

#[test]
fn the_registry_says_what_the_texts_say() {
    for module in library() {
        let function = Function::find(module.slot().name, module.name()).unwrap();
        assert_eq!(
            function.parameters,
            module.parameters(),
            "{}",
            module.file()
        );
        assert_eq!(function.meaning, module.meaning().replace('\n', " "));
        let needs_looks = module.slot().name == "composite" && module.needs().contains(&"look");
        assert_eq!(function.adds_looks, needs_looks, "{}", module.file());
    }
}

#[test]
fn every_text_of_the_folder_is_in_the_registry() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("library");
    for slot in SLOTS.iter().map(|slot| slot.name) {
        for file in std::fs::read_dir(folder.join(slot)).unwrap() {
            let file = file.unwrap().path();
            let name = file.file_stem().unwrap().to_str().unwrap();
            assert!(Function::names(slot).contains(&name), "{}", file.display());
        }
    }
}

#[test]
fn every_pair_of_functions_links_to_a_valid_program() {
    let mut linker = Linker::new();
    let (mut pairs, mut linked) = (0, BTreeSet::new());
    let skeletons = [
        one(Texels::Float),
        one(Texels::Unsigned),
        one(Texels::SignedPages),
        loop_over(&[Texels::Float, Texels::Signed], 3),
    ];
    for skeleton in skeletons {
        for (i, a) in library().iter().enumerate() {
            for b in &library()[i..] {
                let same_slot = a.slot() == b.slot();
                if same_slot && a.slot().fold == Fold::One && a != b {
                    continue;
                }
                let modules = if a == b {
                    vec![a.clone()]
                } else {
                    vec![a.clone(), b.clone()]
                };
                let by_gradient = ["gradient_table", "value_gradient"];
                let circle = a.name() == "opacity" && by_gradient.contains(&b.name())
                    || b.name() == "opacity" && by_gradient.contains(&a.name());
                let needs_one = [a, b].iter().any(|module| {
                    module.slot().name == "composite" && !module.needs().contains(&"look")
                });
                let what = format!("{} and {}", a.file(), b.file());
                let refusal = match (circle, needs_one && skeleton.objects > 1) {
                    (true, _) => Some("in a circle"),
                    (_, true) => Some("look"),
                    _ => None,
                };
                match (linker.link(&skeleton, &with(&modules)), refusal) {
                    (Ok(program), None) => {
                        pairs += 1;
                        assert_eq!(
                            program.default_parameters().len(),
                            program.parameter_bytes() as usize
                        );
                        if a == b {
                            is_valid(&what, program.wgsl());
                        }
                        for module in &modules {
                            if !linked.contains(module.file()) && has(&program, module) {
                                linked.insert(module.file().to_owned());
                            }
                        }
                    }
                    (Err(error), Some(why)) => {
                        assert!(error.to_string().contains(why), "{what}: {error}");
                    }
                    (Ok(_), Some(why)) => panic!("{what}: not refused ({why})"),
                    (Err(error), None) => panic!("{what}: {error}"),
                }
            }
        }
    }
    println!("{pairs} programs");
    // A program that leaves a function out says nothing of it.
    let left_out: Vec<_> = library()
        .iter()
        .filter(|module| !linked.contains(module.file()))
        .map(|module| module.file())
        .collect();
    assert!(left_out.is_empty(), "in no program: {left_out:?}");
}

/// Read and checked by naga, apart from the linker, which does so for every program.
fn is_valid(what: &str, wgsl: &str) {
    let module = naga::front::wgsl::parse_str(wgsl)
        .unwrap_or_else(|error| panic!("{what}: {}", error.emit_to_string(wgsl)));
    let flags = naga::valid::ValidationFlags::all();
    let mut validator = naga::valid::Validator::new(flags, naga::valid::Capabilities::empty());
    let valid = validator.validate(&module);
    assert!(valid.is_ok(), "{what}: {valid:?}");
}

/// Whether a program has text of a module.
fn has(program: &Program, module: &Module) -> bool {
    let starts = program.wgsl().match_indices('\n').map(|(at, _)| at + 1);
    starts
        .filter_map(|at| program.origin(at))
        .any(|origin| origin.file == module.file())
}

#[test]
fn what_is_not_needed_is_not_there() {
    let program = Linker::new()
        .link(
            &one(Texels::Float),
            &with(&[built_in("composite", "average").unwrap()]),
        )
        .unwrap();
    for absent in [
        "fn gradient(",
        "fn illuminate(",
        "fn lighting(",
        "fn shade(",
    ] {
        assert!(!program.wgsl().contains(absent), "{absent}");
    }
    assert!(slot("gradient").is_some());
}

#[test]
fn costs_are_those_that_a_person_counts() {
    let reads = |texels, slot: &str, name: &str| {
        let function = built_in(slot, name).unwrap();
        let program = Linker::new().link(&one(texels), &with(&[function]));
        let cost = program.unwrap().cost();
        let of = |name: &str| cost.functions.iter().find(|(n, _)| n == name);
        (
            of(slot).map_or(0, |(_, work)| work.texture_reads),
            cost.per_sample,
        )
    };
    assert_eq!(reads(Texels::Float, "reconstruct", "nearest").0, 1);
    assert_eq!(reads(Texels::Float, "reconstruct", "trilinear").0, 8);
    assert_eq!(
        reads(Texels::Float, "reconstruct", "trilinear_sampler").0,
        1
    );
    assert_eq!(
        reads(Texels::Unsigned, "reconstruct", "trilinear_sampler").0,
        8
    );
    assert_eq!(reads(Texels::Float, "reconstruct", "b_spline_sampler").0, 8);
    assert_eq!(reads(Texels::Float, "reconstruct", "catmull_rom").0, 64);
    assert_eq!(reads(Texels::Float, "gradient", "central").0, 6 * 8);
    assert_eq!(reads(Texels::Float, "gradient", "sobel").0, 27 * 8);
    // A sample, its gradient, two entries of the table, and whether its brick is empty.
    let (_, sample) = reads(Texels::Float, "reconstruct", "trilinear_sampler");
    assert_eq!(sample.texture_reads, 1 + 6 + 2 + 1);
    assert!(sample.instructions > 50);
}
