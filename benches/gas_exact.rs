//! Speed of the exact gas compared with plain loops that reflect the same particles, in one run.
//!
//! `cargo bench --bench gas_exact`; one thread, N particles with uniform speeds in a circle of radius 1, v_max = 1. The engine computes frames
//! pi/0.68 apart, with about 1.5 wall collisions per particle between two of them, from its closed form. Both loops know no closed form.
//! They solve (p + v t)^2 = R^2 and reflect v' = v - 2 (v . p) p, four particles per AVX2 register if the processor has them, and sum the
//! impulse:
//! - "frames" follows each particle to the times of the same frames. Its positions are compared with the engine's;
//! - "wall to wall" reflects every particle once per pass and stops at no frame: an upper bound for such a loop;
//! - "two threads", which `-- threads` runs alone, compares the wall times of the shortest frames with one thread and with two.
//!
//! Figures are wall collisions per second of processor time and the ratio engine / loop: the median of pairs in turn, with the smallest and the largest.
//!
//! Measured on two busy virtual cores of an AMD EPYC (AVX2, no AVX-512), 15 pairs, at 10^3, 10^4, 10^5 and 10^6 particles: frames 3.5 (2.7 to
//! 5.0), 3.0 (2.7 to 4.7), 3.4 (2.7 to 3.8), 3.1 (2.4 to 3.5); wall to wall 0.26 (0.16 to 0.39), 0.28 (0.18 to 0.36), 0.37 (0.28 to 0.48),
//! 0.39 (0.33 to 0.56). More than half of a frame's arithmetic are the sine, the cosine and the rotated state, which a loop that stops at
//! no frame does not need. Alone and in thread time, the kernel reaches 0.38 to 0.48 of "wall to wall"; before, it was 0.13 to 0.24.
//!
//! What raised the speed of the kernel (alone, thread time, same bits, in turn): operations on four lanes instead of a loop over eight,
//! and results written in place, 1.5 to 1.85 at 10^4 particles and 1.85 to 2.6 at 10^5; with the processor's own floor and without the series
//! of a moving wall, 2.0 to 2.2 and 2.2 to 2.9. What did not: no division by a radius of 1 (1.0 to 1.1, within noise); collisions
//! first and rotations later for 16 groups at a time (1.05 to 1.16 at 10^4, 0.9 to 1.05 at 10^5).
//!
//! Eight lanes with AVX-512, columns that cross no cache line, and products with 1/R where R is a power of two, as it is here (24 Nov 2026,
//! Intel Xeon with AVX-512, two cores under a load of 10, two series of 15 pairs each before and after, in turn; medians): wall to
//! wall 0.21 and 0.27 to 0.39 and 0.36 at 10^3, 0.31 and 0.27 to 0.47 and 0.36 at 10^4, no change at 10^5 (0.28) and 10^6 (0.30 to 0.37), where
//! memory bounds the engine: it moves 144 bytes per particle, the loop 64. Single pairs ranged from 0.05 to 1.84. Eight lanes alone,
//! without other work on the machine: 0.41 (0.29 to 0.46), 0.43 (0.26 to 0.44), 0.33 (0.22 to 0.45) and 0.30 (0.18 to 0.59).
//!
//! The same code, two quiet cores of an AMD EPYC of the fourth generation (AVX-512): wall to wall 0.45 (0.39 to 0.45), 0.47 (0.38 to 0.47),
//! 0.47 (0.37 to 0.51) and 0.30 (0.24 to 0.38); frames 4.2, 4.3, 4.4 and 2.6.
//!
//! No count of the particles outside per frame, which the closed form keeps inside: wall to wall at 10^3 particles 0.43 (0.12 to 1.84)
//! and 0.37 (0.29 to 0.56) before, 0.64 (0.38 to 0.94) and 0.62 (0.47 to 0.71) after, in turn, two cores under a load of 20.
//!
//! In processor time, which other work changes less (27 Nov 2026, two cores with AVX-512 under a load of 45): wall to wall 0.60 (0.51 to 0.78),
//! 0.60 (0.48 to 0.71), 0.34 (0.24 to 0.42) and 0.61 (0.56 to 0.66); frames 7.9, 8.0, 3.6 and 2.9. The bar of 0.75 is not reached.
//! Idle (28 Nov 2026, three series): wall to wall 0.51 to 0.56 at 10^3 particles, 0.44 to 0.55 at 10^4, 0.37 to 0.60 at 10^5 and 0.43 to 0.52 at 10^6; two threads 2.07 at 10^5.

#![allow(clippy::unwrap_used, reason = "a benchmark may panic")]
#![allow(
    unsafe_code,
    reason = "the loops are compiled for AVX2, which is checked before their call"
)]

use kinetoscope_manifest::model::{GasConfig, Propagation, SpeedDistribution, SpeedScale};
use kinetoscope_manifest::quantity::{NonNegative, Positive};
use kinetoscope_physics::gas::Gas;
use kinetoscope_physics::model::{Model, Target};
use kinetoscope_physics::random::Seed;
use kinetoscope_recording::channels::GasCollisions;
use kinetoscope_recording::frame::Frame;
use rayon::ThreadPoolBuilder;
use std::num::NonZeroU32;
use std::time::Instant;

const FRAME_S: f64 = 4.62;
const PAIRS: usize = 15;
/// Particle frames per measurement: some 50 ms.
const WORK: u32 = 5_000_000;
/// Particle frames of which the shortest is taken: on a busy machine, few have both processors to themselves.
const TRIED: u32 = 20_000_000;

type Four = [f64; 4];

fn main() {
    if !std::env::args().any(|word| word == "threads") {
        compare_with_loops();
    }
    for particles in [10_000, 100_000, 1_000_000] {
        let [one, two] = shortest_frames(particles);
        let what = format!("{particles}, two threads");
        println!("{what:<32}{:>9.3} ms{:>9.3} ms{:>8.2}", 1e3 * one, 1e3 * two, one / two);
    }
}

fn compare_with_loops() {
    let pool = ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    println!("{:<32}{:>12}{:>12}{:>8}   range", "M wall collisions/s", "engine", "loop", "ratio");
    for particles in [1_000, 10_000, 100_000, 1_000_000] {
        for (name, pass) in [("frames", to_frame as Pass), ("wall to wall", wall_to_wall as Pass)] {
            let mut gas = gas(particles);
            let mut frames = 0;
            let mut reflected = Reflected::of(&gas);
            if name == "frames" {
                check(particles);
            }
            let count = (WORK / particles).max(1);
            let pairs: Vec<[f64; 2]> = (0..PAIRS)
                .map(|_| {
                    let engine = pool.install(|| advance(&mut gas, &mut frames, count));
                    [engine, reflected.speed_of(pass, count)]
                })
                .collect();
            let ratios = sorted(pairs.iter().map(|[engine, plain]| engine / plain));
            println!(
                "{:<32}{:>12.1}{:>12.1}{:>8.2}   {:.2} to {:.2}",
                format!("{particles}, {name}"),
                sorted(pairs.iter().map(|pair| pair[0]))[PAIRS / 2] / 1e6,
                sorted(pairs.iter().map(|pair| pair[1]))[PAIRS / 2] / 1e6,
                ratios[PAIRS / 2],
                ratios[0],
                ratios[PAIRS - 1]
            );
        }
    }
}

/// Wall times of the shortest frame with one thread and with two, in turn, s.
fn shortest_frames(particles: u32) -> [f64; 2] {
    let (mut gas, mut shortest) = (gas(particles), [f64::INFINITY; 2]);
    let pools =
        [1, 2].map(|threads| ThreadPoolBuilder::new().num_threads(threads).build().unwrap());
    for frame in 1..=(TRIED / particles).max(20) {
        for (half, (pool, shortest)) in pools.iter().zip(&mut shortest).enumerate() {
            let time_s = (f64::from(frame) + 0.5 * half as f64) * FRAME_S;
            let start = Instant::now();
            pool.install(|| gas.advance(Target::Time(time_s), u64::MAX)).unwrap();
            let took = start.elapsed().as_secs_f64();
            *shortest = if took < *shortest { took } else { *shortest };
        }
    }
    shortest
}

fn sorted(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values
}

fn gas(particles: u32) -> Gas {
    let config = GasConfig {
        particles: NonZeroU32::new(particles).unwrap(),
        speed_distribution: SpeedDistribution::Uniform,
        speed_scale: SpeedScale::MaxSpeed(NonNegative::new(1.0).unwrap()),
        propagation: Propagation::Exact,
        duration_s: Positive::new(1e8).unwrap(),
        ..GasConfig::default()
    };
    Gas::prepare(&config, Seed { seed: 1, replicate: 0 }, false).unwrap()
}

fn observed(gas: &Gas) -> Frame {
    let mut frame = Frame::new();
    gas.observe(&mut frame);
    frame
}

fn wall_collisions(gas: &Gas) -> f64 {
    observed(gas).get::<GasCollisions>().unwrap().wall_collisions as f64
}

/// Wall collisions per second of the engine over the next frames.
fn advance(gas: &mut Gas, frames: &mut u32, count: u32) -> f64 {
    let before = wall_collisions(gas);
    let start = thread_seconds();
    for _ in 0..count {
        *frames += 1;
        gas.advance(Target::Time(f64::from(*frames) * FRAME_S), u64::MAX).unwrap();
    }
    let seconds = thread_seconds() - start;
    (wall_collisions(gas) - before) / seconds
}

/// Processor time of this thread so far, s, which Linux reports in ns: other work on the machine changes it less than the wall time.
fn thread_seconds() -> f64 {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap();
    text.split(' ').next().unwrap().parse::<f64>().unwrap() / 1e9
}

/// The loop to the frames must end where the engine does: it is the same physics.
fn check(particles: u32) {
    let mut gas = gas(particles);
    let mut reflected = Reflected::of(&gas);
    gas.advance(Target::Time(FRAME_S), u64::MAX).unwrap();
    let [collisions, _] = reflected.sums_of(to_frame);
    assert_eq!(collisions, wall_collisions(&gas));
    let frame = observed(&gas);
    for (id, row) in frame.state().chunks_exact(4).enumerate() {
        let (four, lane) = (&reflected.0[id / 4], id % 4);
        for (found, expected) in
            [four.x[lane], four.y[lane], four.vx[lane], four.vy[lane]].iter().zip(row)
        {
            assert!((found - expected).abs() < 1e-6, "particle {id}: {found}, {expected}");
        }
    }
}

#[derive(Clone, Copy)]
struct Particles {
    x: Four,
    y: Four,
    vx: Four,
    vy: Four,
}

/// A loop over some particles that returns their wall collisions and their impulse per mass.
type Pass = fn(&mut [Particles]) -> [f64; 2];

struct Reflected(Vec<Particles>);

impl Reflected {
    fn of(gas: &Gas) -> Self {
        let frame = observed(gas);
        let columns = |rows: &[f64]| {
            // Particles beyond the last one are copies of it.
            let column = |index: usize| each(|lane| rows[lane * 4 % rows.len() + index]);
            Particles { x: column(0), y: column(1), vx: column(2), vy: column(3) }
        };
        Self(frame.state().chunks(16).map(columns).collect())
    }

    /// Both sums, in blocks, with AVX2 if the processor has it.
    fn sums_of(&mut self, pass: Pass) -> [f64; 2] {
        self.0
            .chunks_mut(256)
            .map(pass)
            .fold([0.0; 2], |sum, block| [sum[0] + block[0], sum[1] + block[1]])
    }

    fn speed_of(&mut self, pass: Pass, count: u32) -> f64 {
        let start = thread_seconds();
        let collisions: f64 = (0..count).map(|_| self.sums_of(pass)[0]).sum();
        collisions / (thread_seconds() - start)
    }
}

#[inline(always)]
fn each(value: impl Fn(usize) -> f64) -> Four {
    [value(0), value(1), value(2), value(3)]
}

fn to_frame(particles: &mut [Particles]) -> [f64; 2] {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx2") {
        #[target_feature(enable = "avx2")]
        fn wide(particles: &mut [Particles]) -> [f64; 2] {
            plain_to_frame(particles)
        }
        // SAFETY: the processor has these instructions.
        return unsafe { wide(particles) };
    }
    plain_to_frame(particles)
}

fn wall_to_wall(particles: &mut [Particles]) -> [f64; 2] {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("avx2") {
        #[target_feature(enable = "avx2")]
        fn wide(particles: &mut [Particles]) -> [f64; 2] {
            plain_wall_to_wall(particles)
        }
        // SAFETY: the processor has these instructions.
        return unsafe { wide(particles) };
    }
    plain_wall_to_wall(particles)
}

/// Later root t of (p + v t)^2 = 1. Rounding must not give a negative radicand.
#[inline(always)]
fn times_to_wall(Particles { x, y, vx, vy }: &Particles) -> Four {
    let square = each(|i| vx[i] * vx[i] + vy[i] * vy[i]);
    let along = each(|i| x[i] * vx[i] + y[i] * vy[i]);
    let room = each(|i| 1.0 - (x[i] * x[i] + y[i] * y[i]));
    let root = each(|i| (along[i] * along[i] + square[i] * room[i]).abs().sqrt());
    each(|i| (root[i] - along[i]) / square[i])
}

/// Moves the particles by `step` and reflects them at the wall with the given normal speed.
#[inline(always)]
fn moved(from: &Particles, step: Four) -> Particles {
    Particles {
        x: each(|i| from.x[i] + step[i] * from.vx[i]),
        y: each(|i| from.y[i] + step[i] * from.vy[i]),
        ..*from
    }
}

#[inline(always)]
fn mirrored(from: &Particles, normal: Four) -> Particles {
    Particles {
        vx: each(|i| from.vx[i] - 2.0 * normal[i] * from.x[i]),
        vy: each(|i| from.vy[i] - 2.0 * normal[i] * from.y[i]),
        ..*from
    }
}

#[inline(always)]
fn plain_to_frame(particles: &mut [Particles]) -> [f64; 2] {
    let (mut collisions, mut impulse) = ([0.0; 4], [0.0; 4]);
    for four in particles {
        let (mut at, mut left) = (*four, [FRAME_S; 4]);
        while left != [0.0; 4] {
            let to_wall = times_to_wall(&at);
            let step = each(|i| if to_wall[i] <= left[i] { to_wall[i] } else { left[i] });
            at = moved(&at, step);
            let normal = each(|i| at.x[i] * at.vx[i] + at.y[i] * at.vy[i]);
            let normal = each(|i| if to_wall[i] <= left[i] { normal[i] } else { 0.0 });
            at = mirrored(&at, normal);
            impulse = each(|i| impulse[i] + 2.0 * normal[i]);
            collisions = each(|i| collisions[i] + if to_wall[i] <= left[i] { 1.0 } else { 0.0 });
            left = each(|i| left[i] - step[i]);
        }
        *four = at;
    }
    [collisions, impulse].map(|sums| sums.iter().sum())
}

#[inline(always)]
fn plain_wall_to_wall(particles: &mut [Particles]) -> [f64; 2] {
    let mut impulse = [0.0; 4];
    for four in &mut *particles {
        let at = moved(four, times_to_wall(four));
        let normal = each(|i| at.x[i] * at.vx[i] + at.y[i] * at.vy[i]);
        impulse = each(|i| impulse[i] + 2.0 * normal[i]);
        *four = mirrored(&at, normal);
    }
    [4.0 * particles.len() as f64, impulse.iter().sum()]
}
