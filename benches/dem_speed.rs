//! Particle-steps a second of the DEM, one thread, with and without AVX2.

mod dem_beds;

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use dem_beds::Scene;
use kinetoscope::model::{Model, Target};

const STEPS: u64 = 20;

fn speed(criterion: &mut Criterion) {
    for (scene, discs) in [
        (Scene::Settled, 10_000),
        (Scene::Settled, 100_000),
        (Scene::Rubbing, 10_000),
        (Scene::Gas, 10_000),
        (Scene::Collapse, 10_000),
    ] {
        let model = scene.model(discs);
        let mut group = criterion.benchmark_group(format!("{scene:?}/{discs}"));
        group.throughput(Throughput::Elements(u64::from(discs) * STEPS)).sample_size(20);
        for (name, lanes) in [("scalar", false), ("four at a time", true)] {
            group.bench_function(name, |bencher| {
                bencher.iter_batched_ref(
                    || model.clone().with_lanes(lanes),
                    |model| {
                        let goal = Target::Count(model.count() + STEPS);
                        model.advance(goal, u64::MAX).expect("no blow-up");
                    },
                    BatchSize::LargeInput,
                );
            });
        }
        group.finish();
    }
}

criterion_group!(benches, speed);
criterion_main!(benches);
