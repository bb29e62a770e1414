//! Speed of the gas compared with the tightest plain loop for the same physics, in one run.
//!
//! `cargo bench --bench gas_speed`; "elements" are particle steps for the time-stepped propagator and wall collisions for the closed form.
//! State: N particles with uniform speeds in a circle of radius 1, v_max = 1. Time steps: dt = 0.02, so that one particle in 160 collides
//! with the wall per step. Closed form: frames pi/0.68 apart, with about 1.5 wall collisions per particle between two frames.
//! `benches/peers/gas_numpy.py` takes the same steps in numpy.

#![allow(missing_docs, reason = "criterion's macros")]
#![allow(clippy::unwrap_used, reason = "a benchmark may panic")]

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use kinetoscope_manifest::model::{GasConfig, Propagation, SpeedDistribution, SpeedScale};
use kinetoscope_manifest::quantity::{NonNegative, Positive};
use kinetoscope_physics::gas::Gas;
use kinetoscope_physics::model::{Model, Target};
use kinetoscope_physics::random::Seed;
use kinetoscope_recording::channels::GasCollisions;
use kinetoscope_recording::frame::Frame;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::num::NonZeroU32;
use std::time::Duration;

const TIME_STEP: f64 = 0.02;
const STEPS: u64 = 64;
const FRAME: f64 = 4.62;

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

/// Positions of the wall collisions, and the rotation from one to the next.
struct WallPositions {
    x: Vec<f64>,
    y: Vec<f64>,
    sine: Vec<f64>,
    cosine: Vec<f64>,
}

impl WallPositions {
    fn of(columns: &Columns) -> Self {
        let mut positions = Self { x: vec![], y: vec![], sine: vec![], cosine: vec![] };
        for index in 0..columns.x.len() {
            let (vx, vy) = (columns.vx[index], columns.vy[index]);
            let offset =
                (columns.x[index] * vy - columns.y[index] * vx) / (vx * vx + vy * vy).sqrt();
            let half_chord = (1.0 - offset * offset).sqrt();
            positions.x.push(columns.x[index]);
            positions.y.push(columns.y[index]);
            positions.sine.push(2.0 * half_chord * offset);
            positions.cosine.push(offset * offset - half_chord * half_chord);
        }
        positions
    }

    /// Tight loop of wall collisions: the next one of each particle is its last one, rotated.
    fn rotate(&mut self) {
        let rotations = self.sine.iter().zip(&self.cosine);
        for ((x, y), (sine, cosine)) in self.x.iter_mut().zip(&mut self.y).zip(rotations) {
            (*x, *y) = (cosine * *x - sine * *y, sine * *x + cosine * *y);
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

fn wall_collisions(criterion: &mut Criterion) {
    for particles in [1_000_u32, 100_000, 1_000_000] {
        let mut probe = gas(particles, Propagation::Exact);
        probe.advance(Target::Time(100.0 * FRAME), u64::MAX).unwrap();
        let collisions = frame(&probe).get::<GasCollisions>().unwrap().wall_collisions / 100;
        let mut group = criterion.benchmark_group(format!("gas_exact/{particles}"));
        group.throughput(Throughput::Elements(collisions)).sample_size(20);
        group.measurement_time(Duration::from_secs(2)).warm_up_time(Duration::from_millis(500));
        for threads in [1, 2] {
            let (pool, mut gas, mut done) =
                (on_threads(threads), gas(particles, Propagation::Exact), 0_u32);
            group.bench_function(format!("{threads}_threads"), |bencher| {
                bencher.iter(|| {
                    done += 1;
                    let time = f64::from(done) * FRAME;
                    pool.install(|| gas.advance(Target::Time(time), u64::MAX)).unwrap()
                });
            });
        }
        let mut tight = WallPositions::of(&Columns::of(&probe));
        let mut pending = 0;
        group.bench_function("tight_loop", |bencher| {
            bencher.iter(|| {
                pending += collisions;
                while pending >= u64::from(particles) {
                    tight.rotate();
                    pending -= u64::from(particles);
                }
            });
        });
        group.finish();
    }
}

criterion_group!(benches, steps, wall_collisions);
criterion_main!(benches);
