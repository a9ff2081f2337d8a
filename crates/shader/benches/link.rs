//! What it takes to change a function: linking and validating a combination that was not seen before,
//! and finding one that was.
//!
//!     cargo bench -p strahl-shader

use criterion::{Criterion, criterion_group, criterion_main};
use std::hint::black_box;
use strahl_shader::{Linker, RayLoop, Selection, Techniques, Texels, built_in, ray_loop};

fn link(criterion: &mut Criterion) {
    let skeleton = ray_loop(&RayLoop {
        volumes: vec![Texels::Float],
        objects: 1,
        is_before_geometry: false,
        techniques: Techniques::One,
        is_finite: false,
        has_important_places: false,
    })
    .unwrap();
    let selection = [
        ("clip_ray", "plane"),
        ("jitter", "hash"),
        ("clip_sample", "box"),
        ("fetch", "stored"),
        ("reconstruct", "b_spline_sampler"),
        ("classify", "table"),
        ("gradient_input", "value"),
        ("gradient", "sobel"),
        ("light", "head"),
        ("light", "directional"),
        ("illuminate", "cook_torrance"),
        ("shade", "lit"),
        ("composite", "emission_absorption"),
    ]
    .into_iter()
    .fold(Selection::new(), |selection, (slot, name)| {
        selection.with(built_in(slot, name).unwrap())
    });
    criterion.bench_function("link and validate", |bench| {
        bench.iter(|| {
            let mut linker = Linker::new();
            black_box(linker.link(&skeleton, &selection).unwrap())
        });
    });
    let mut linker = Linker::new();
    linker.link(&skeleton, &selection).unwrap();
    criterion.bench_function("seen before", |bench| {
        bench.iter(|| black_box(linker.link(&skeleton, &selection).unwrap()));
    });
}

criterion_group!(benches, link);
criterion_main!(benches);
