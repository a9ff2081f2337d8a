//! Simulated clocks per second of the default machine on the jaw, with and without optimisation: elements are clocks.
//!
//!     cargo bench -p strahl-sim

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use strahl_sim::spec::Optimisation;
use strahl_sim::{Frame, Nobody, Spec, VolumeStore, jaw, no_progress, run};

fn clocks(c: &mut Criterion) {
    let volume = jaw([128, 128, 64])
        .and_then(|jaw| VolumeStore::new(&jaw))
        .unwrap();
    let mut group = c.benchmark_group("clocks");
    group.sample_size(10);
    for (name, optimisation) in [
        ("brute force", Optimisation::none()),
        ("default", Optimisation::default()),
    ] {
        let mut spec = Spec {
            optimisation,
            ..Spec::default()
        };
        spec.look.opacity = vec![[1000.0, 0.0], [4095.0, 1.0]];
        let frame = Frame::new(&spec, &volume).unwrap();
        let once = run(&frame, &mut Nobody, &no_progress).unwrap();
        group.throughput(Throughput::Elements(once.counters.clocks));
        group.bench_function(name, |b| {
            b.iter(|| run(black_box(&frame), &mut Nobody, &no_progress).unwrap());
        });
    }
    group.finish();
}

criterion_group!(benches, clocks);
criterion_main!(benches);
