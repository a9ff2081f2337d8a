//! Simulated clocks per second of the default machine on the jaw, with and without optimisation, and with somebody looking
//! on: elements are clocks.
//!
//!     RAYON_NUM_THREADS=1 cargo bench -p strahl-sim --bench clocks

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use strahl_sim::spec::Optimisation;
use strahl_sim::{Frame, NoObserver, Observer, Spec, VolumeStore, Wires, jaw, no_progress, run};

/// Looks at one wire: every word is made in its clock.
#[derive(Default)]
struct Reads(u64);

impl Observer for Reads {
    fn clock(&mut self, wires: &Wires) {
        self.0 += u64::from(wires.issue.is_some());
    }
}

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
        let once = run(&frame, &mut NoObserver, &no_progress).unwrap();
        group.throughput(Throughput::Elements(once.counters.clocks));
        group.bench_function(name, |b| {
            b.iter(|| run(black_box(&frame), &mut NoObserver, &no_progress).unwrap());
        });
        group.bench_function(format!("{name}, observed"), |b| {
            b.iter(|| run(black_box(&frame), &mut Reads::default(), &no_progress).unwrap());
        });
    }
    group.finish();
}

criterion_group!(benches, clocks);
criterion_main!(benches);
