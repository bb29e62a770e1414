//! Steps per second of one orbit on one core: the model as `run-experiment` runs it, compared with a tight loop of the same operations
//! in the same run. `benches/peers/orbit_rebound.py` measures REBOUND.
//!
//!     cargo bench --bench orbit_speed
//!
//! Tracked events cost velocity Verlet a tenth of its speed (23 Nov 2026, AMD EPYC: 26.8 ns per step, 23.4 ns before events were tracked). Repeating
//! the steps since the last check at an event, instead of keeping a copy of the state before each step, gave 1.00: the copy is not the cost.
//! Closest approaches cost six bodies 0.03 of their speed (24 Nov 2026, AMD EPYC: 106.2 ns per step, 102.7 ns before they were tracked).

// A benchmark may panic.
#![allow(clippy::unwrap_used, missing_docs)]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use kinetoscope_manifest::model::{
    ModelConfig, OrbitConfig, OrbitIntegrator, OrbitStart, OrbitSummation,
};
use kinetoscope_manifest::quantity::Positive;
use kinetoscope_physics::constants::GM_SUN_AU3_PER_DAY2 as GM;
use kinetoscope_physics::model::{Model, Progress, Target};
use kinetoscope_physics::orbit::motion::State;
use kinetoscope_physics::orbit::{BARYCENTRIC_START, Orbit};
use kinetoscope_physics::random::Seed;
use std::hint::black_box;
use std::time::Duration;

/// A thousand years in steps of a quarter of a day.
const STEPS: u64 = 1_461_000;

/// Runs the model to its end, with the budget of a program run per call.
fn model(integrator: OrbitIntegrator, summation: OrbitSummation) -> State {
    let config = OrbitConfig {
        start: OrbitStart::Barycentric,
        integrator,
        summation,
        duration_days: Positive::new(0.25 * STEPS as f64).unwrap(),
        ..OrbitConfig::default()
    };
    let mut orbit = Orbit::prepare(&config, Seed { seed: 0, replicate: 0 }, false).unwrap();
    while orbit.advance(Target::Count(STEPS), 10_000).unwrap() == Progress::Working {}
    orbit.state().unwrap()
}

/// a(r) / r
#[inline(always)]
fn factor([x, y, z]: [f64; 3]) -> f64 {
    let r = ((x * x + y * y) + z * z).sqrt();
    -GM / ((r * r) * r)
}

/// Only explicit Euler.
fn tight_euler() -> State {
    let State { position: mut r, velocity: mut v } = black_box(BARYCENTRIC_START);
    for _ in 0..STEPS {
        let k = factor(r);
        let old = r;
        for axis in 0..3 {
            r[axis] += v[axis] * 0.25;
            v[axis] += (k * old[axis]) * 0.25;
        }
    }
    State { position: r, velocity: v }
}

/// Only velocity Verlet: one force evaluation per step.
fn tight_verlet() -> State {
    let State { position: mut r, velocity: mut v } = black_box(BARYCENTRIC_START);
    let mut k = factor(r);
    for _ in 0..STEPS {
        for axis in 0..3 {
            v[axis] += (k * r[axis]) * 0.125;
            r[axis] += v[axis] * 0.25;
        }
        k = factor(r);
        for axis in 0..3 {
            v[axis] += (k * r[axis]) * 0.125;
        }
    }
    State { position: r, velocity: v }
}

/// Runs six mutually attracting bodies for a hundred years with velocity Verlet.
fn six_bodies() -> u64 {
    let text = include_str!("../experiments/orbit_outer_planets.toml");
    let experiment = kinetoscope_manifest::parse(text, "orbit_outer_planets.toml", &[]).unwrap();
    let ModelConfig::Orbit(config) = &*experiment.runs[0].manifest.model else { return 0 };
    let mut orbit = Orbit::prepare(config, Seed { seed: 0, replicate: 0 }, false).unwrap();
    while orbit.advance(orbit.extent().end(), 10_000).unwrap() == Progress::Working {}
    orbit.count()
}

fn orbit_steps(criterion: &mut Criterion) {
    // The tight loops must give the same result; otherwise, the comparison has no meaning.
    let plain = OrbitSummation::Plain;
    assert_eq!(model(OrbitIntegrator::ExplicitEuler, plain), tight_euler());
    assert_eq!(model(OrbitIntegrator::VelocityVerlet, plain), tight_verlet());

    let mut group = criterion.benchmark_group("orbit");
    group.throughput(Throughput::Elements(STEPS));
    group.sample_size(10).warm_up_time(Duration::from_millis(500));
    group.measurement_time(Duration::from_secs(3));
    group.bench_function("explicit Euler, tight loop", |bencher| bencher.iter(tight_euler));
    group.bench_function("velocity Verlet, tight loop", |bencher| bencher.iter(tight_verlet));
    for (name, integrator) in [
        ("explicit Euler", OrbitIntegrator::ExplicitEuler),
        ("semi-implicit Euler", OrbitIntegrator::SemiImplicitEuler),
        ("velocity Verlet", OrbitIntegrator::VelocityVerlet),
        ("RK4", OrbitIntegrator::Rk4),
        ("Yoshida 4", OrbitIntegrator::Yoshida4),
    ] {
        group.bench_function(name, |bencher| bencher.iter(|| model(integrator, plain)));
    }
    group.bench_function("velocity Verlet, compensated", |bencher| {
        bencher.iter(|| model(OrbitIntegrator::VelocityVerlet, OrbitSummation::Compensated));
    });
    group.throughput(Throughput::Elements(six_bodies()));
    group.bench_function("velocity Verlet, six bodies", |bencher| bencher.iter(six_bodies));
    group.finish();
}

criterion_group!(benches, orbit_steps);
criterion_main!(benches);
