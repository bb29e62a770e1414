//! Speed of the time-stepped gas compared with the tightest plain loop for the same physics, in one run.
//!
//! `cargo bench --bench gas_speed`; "elements" are particle steps. State: N particles with uniform speeds in a circle of radius 1,
//! v_max = 1, dt = 0.02, so that one particle in 160 collides with the wall per step. `benches/peers/gas_numpy.py` takes the same steps in
//! numpy. `gas_exact.rs` measures the closed form.

#![allow(missing_docs, reason = "criterion's macros")]
#![allow(clippy::unwrap_used, reason = "a benchmark may panic")]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use kinetoscope_manifest::model::{GasConfig, Propagation, SpeedDistribution, SpeedScale};
use kinetoscope_manifest::quantity::{NonNegative, Positive};
use kinetoscope_physics::gas::Gas;
use kinetoscope_physics::model::{Model, Target};
use kinetoscope_physics::random::Seed;
use kinetoscope_recording::frame::Frame;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::num::NonZeroU32;
use std::time::Duration;

const TIME_STEP: f64 = 0.02;
const STEPS: u64 = 64;

fn config(particles: u32, propagation: Propagation) -> GasConfig {
    GasConfig {
        particles: NonZeroU32::new(particles).unwrap(),
        speed_distribution: SpeedDistribution::Uniform,
        speed_scale: SpeedScale::MaxSpeed(NonNegative::new(1.0).unwrap()),
        propagation,
        duration_s: Positive::new(1e8).unwrap(),
        ..GasConfig::default()
    }
}

fn gas(particles: u32, propagation: Propagation) -> Gas {
    let seed = Seed { seed: 1, replicate: 0 };
    Gas::prepare(&config(particles, propagation), seed, false).unwrap()
}

fn stepped() -> Propagation {
    Propagation::TimeStepped { time_step_s: Positive::new(TIME_STEP).unwrap() }
}

fn frame(gas: &Gas) -> Frame {
    let mut frame = Frame::new();
    gas.observe(&mut frame);
    frame
}

fn on_threads(threads: usize) -> ThreadPool {
    ThreadPoolBuilder::new().num_threads(threads).build().unwrap()
}

/// State as plain columns.
struct Columns {
    x: Vec<f64>,
    y: Vec<f64>,
    vx: Vec<f64>,
    vy: Vec<f64>,
    wall_collisions: u64,
}

impl Columns {
    fn of(gas: &Gas) -> Self {
        let frame = frame(gas);
        let column = |index: usize| frame.state().chunks_exact(4).map(|row| row[index]).collect();
        Self { x: column(0), y: column(1), vx: column(2), vy: column(3), wall_collisions: 0 }
    }

    /// Tight loop of the steps: drift; if that ends outside, reflect once at the wall.
    fn step(&mut self, time_step: f64) {
        let columns = self.x.iter_mut().zip(&mut self.y).zip(self.vx.iter_mut().zip(&mut self.vy));
        for ((x, y), (vx, vy)) in columns {
            let (next_x, next_y) = (*x + time_step * *vx, *y + time_step * *vy);
            if next_x * next_x + next_y * next_y <= 1.0 {
                (*x, *y) = (next_x, next_y);
                continue;
            }
            let square = *vx * *vx + *vy * *vy;
            let along = *x * *vx + *y * *vy;
            let room = 1.0 - (*x * *x + *y * *y);
            let to_wall = ((along * along + square * room).sqrt() - along) / square;
            let (hit_x, hit_y) = (*x + to_wall * *vx, *y + to_wall * *vy);
            let twice = 2.0 * (*vx * hit_x + *vy * hit_y);
            *vx -= twice * hit_x;
            *vy -= twice * hit_y;
            let rest = time_step - to_wall;
            (*x, *y) = (hit_x + rest * *vx, hit_y + rest * *vy);
            self.wall_collisions += 1;
        }
    }
}

fn steps(criterion: &mut Criterion) {
    for particles in [1_000_u32, 100_000, 1_000_000] {
        let mut group = criterion.benchmark_group(format!("gas_stepped/{particles}"));
        group.throughput(Throughput::Elements(u64::from(particles) * STEPS)).sample_size(20);
        group.measurement_time(Duration::from_secs(2)).warm_up_time(Duration::from_millis(500));
        for threads in [1, 2] {
            let (pool, mut gas, mut done) = (on_threads(threads), gas(particles, stepped()), 0);
            group.bench_function(format!("{threads}_threads"), |bencher| {
                bencher.iter(|| {
                    done += STEPS;
                    pool.install(|| gas.advance(Target::Count(done), u64::MAX)).unwrap()
                });
            });
        }
        let mut columns = Columns::of(&gas(particles, stepped()));
        group.bench_function("tight_loop", |bencher| {
            bencher.iter(|| (0..STEPS).for_each(|_| columns.step(TIME_STEP)));
        });
        group.finish();
    }
}

criterion_group!(benches, steps);
criterion_main!(benches);
