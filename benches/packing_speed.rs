//! Speed of the packing engine: collisions per second in periodic boxes at packing fractions 0.3 and 0.7, for fifty discs
//! within four walls, and in the box of the packing exercise. Bytes per disc of the whole program are printed as well.
//!
//! Million collisions per second, and their ratio to those of l09rin/EDMD (Cylinder2D), the fastest two-dimensional program
//! known to us. Both programs ran alternately on the same state (AMD EPYC with AVX-512, one thread, medians). The other
//! program cannot be included here; no command of this repository prints the ratios.
//!
//! | discs | 0.3 | ratio | 0.7 | ratio |
//! |---|---|---|---|---|
//! | 1e3 | 2.97 | 2.73 | 4.26 | 2.16 |
//! | 1e4 | 2.45 | 2.61 | 3.85 | 2.12 |
//! | 1e5 | 2.06 | 5.41 | 3.42 | 2.99 |
//! | 1e6 | 1.77 | 6.29 | 2.55 | 3.43 |
//!
//! Fifty discs within four walls: 3.23 million collisions per second at 0.3, 3.0 at 0.25, and 2.16 in the box of the
//! exercise, which is more dilute and has wall noise. For 1e4 discs at 0.3, walls, restitution and wall noise cost 2 %, and
//! <v²> and a2 of each collision 8 %. For 1e6 discs, the whole program uses 132 (0.3) and 125 (0.7) bytes per disc.
//!
//! Measured changes for small systems, as speed ratios at 1024 discs and packing fractions 0.3 and 0.7:
//!
//! | change | 0.3 | 0.7 |
//! |---|---|---|
//! | contact equation of growing discs outside of the loop over lanes | 1.15 | 1.15 |
//! | scan in registers, without arrays between its parts | 1.28 | 1.46 |
//! | no branch on the result of a scan; vectors loaded in the width in which they were stored (store forwarding) | 1.12 | 1.02 |
//! | functions that are always inlined instead of closures | 1.02 | 1.05 |
//! | rejected: event queue with 3, 5 or 14 events per bucket instead of 8 | 0.96, 0.99, 1.00 | |
//! | rejected: whole loop compiled for wide instructions, with a scan in arrays | 0.95 | 1.02 |
//! | rejected: buckets sorted by counting instead of comparing (0.8 in wide instructions) | 1.01 | 1.00 |
//!
//! Half as many cells in dilute systems: 1.25 at fraction 0.1, 3 at 0.02.
//!
//! Measured changes for large systems, as speed ratios at packing fraction 0.3:
//!
//! | change | 1e5 | 1e6 |
//! |---|---|---|
//! | prefetching for both partners and for the cell beyond a crossing; event queue that reads no chunk when it writes | 1.5 | 1.75 |
//! | prefetching without branches on empty slots | 1.16 | 1.10 |
//! | prefetching stages two events apart instead of four | 1.07 | |
//! | large pages of memory | 1.05 | 1.28 |
//! | discs numbered by position | 0.98 | 1.15 |
//! | rejected: cells in groups of four per cache line, in patches per memory page | 0.92 | |
//! | rejected: twice as many buckets | 0.95 | |
//! | rejected: half as many buckets | 1.02 | 0.97 |
//! | rejected: prefetching at 1e4 discs (0.97; 0.89 at fraction 0.7) | | |
//!
//! `cargo bench --bench packing_speed`; a part of it: `cargo bench --bench packing_speed -- 0.3/1000`.
//!
//! # Gravity
//!
//! The option `gravity` compares discs within four walls in gravity, which halves their density over the height, with the same discs
//! without it, alternately.
//!
//!     cargo bench --bench packing_speed -- gravity
//!
//! Speed in gravity over that without: medians of 0.82 to 0.88 with 50 discs, 0.84 to 0.90 with 1e3, 0.88 to 0.91 with 1e4 and 0.87 to
//! 0.91 with 1e5, at packing fractions of 0.1 to 0.6 (AVX2, nine pairs).
//!
//! # Widths of registers
//!
//! The option `width` compares plain x86-64 with AVX2, by alternating runs on copies of one state, and fails if their bits differ.
//!
//!     cargo bench --bench packing_speed -- width
//!
//! Speed of AVX2 and of plain x86-64 over that of an AVX-512 scan, which is not part of the program: the median of the four sizes
//! on the Xeon is 1.00 at 0.3 and 1.03 at 0.7, and a gain of some percent on the EPYC, which executes AVX-512 in two halves of 256
//! bits, did not pay for 19 unsafe blocks. Medians: AMD EPYC of the fourth generation, quiet, nine pairs; two virtual cores of an
//! Intel Xeon at 2.5 GHz with AVX-512 under a load of 20, 15 pairs, time on the processor, with quartiles.
//!
//! | discs | AVX2 on EPYC, 0.3 and 0.7 | plain on EPYC, 0.3 and 0.7 | AVX2 on Xeon, 0.3 | AVX2 on Xeon, 0.7 |
//! |---|---|---|---|---|
//! | 50 | | | 1.04 (0.98–1.15) | 1.14 (1.10–1.19) |
//! | 1e3 | 0.94, 0.92 | 0.89, 0.84 | 1.00 (0.90–1.05) | 1.00 (0.96–1.09) |
//! | 1e4 | 0.98, 0.94 | 0.91, 0.87 | 1.00 (0.91–1.05) | 1.05 (0.97–1.16) |
//! | 1e5 | 0.94, 0.93 | 0.92, 0.87 | 0.92 (0.88–1.00) | 0.90 (0.79–0.98) |
//!
//! Speed of the scans in registers over the one in arrays
//! (`scan`), which was used before; AMD EPYC of the third generation, seven pairs on a busy machine, time on the processor,
//! minimum to maximum:
//!
//! | discs | AVX2, 0.3 | AVX2, 0.7 | plain, 0.3 | plain, 0.7 |
//! |---|---|---|---|---|
//! | 1e3 | 1.27 (1.14–1.38) | 1.47 (1.39–1.61) | 1.21 (1.00–1.30) | 1.34 (0.95–1.41) |
//! | 1e4 | 1.38 (1.17–1.87) | 1.45 (1.30–1.94) | 1.07 (0.98–1.16) | 1.21 (1.02–1.54) |
//! | 1e5 | 1.23 (0.98–1.54) | 1.38 (1.27–1.54) | 1.13 (0.89–1.41), three times | 1.28 (1.12–1.46) |
//!
//! Plain over AVX2 at 1e3 discs: 0.89 (0.83–1.08) at 0.3 and 0.85 (0.72–1.05) at 0.7.
//!
//! Instructions per collision at 1e3 discs and 0.7 (valgrind): AVX2 2698 before and 1974 now, plain 3445 and 2537.
//!
//! | change of the scan in registers at 1e3 discs | AVX2, 0.3 and 0.7 | plain, 0.3 and 0.7 |
//! |---|---|---|
//! | lanes nine to sixteen by four instead of by eight, and cells read without bounds checks | 1.01, 1.03 | 1.06, 1.03 |
//! | rejected: closures instead of functions that are always inlined, which are not compiled for AVX2 | 0.18, 0.16 | |
//! | rejected: event at an edge and offset of a partner chosen by arithmetic instead of branches; at 1e5 0.96 to 0.98 | 1.00, 0.99 | 1.05, 1.04 |
//!
//! # Several threads: findings of a prototype
//!
//! The engine has one thread. A prototype on it, which is not part of the program, was bitwise identical with two threads in
//! periodic boxes of equal elastic discs; walls and mixtures were not tried. Its speed has yet to be measured on a machine with two
//! free processors. An estimate is the time on the processor (Intel Xeon of the Sapphire Rapids class, busy machine, 1e5 discs,
//! three runs of 200,000 collisions): one thread over the sum of the longer strip of each window, the events executed one at a time
//! and the merge. It is 1.19 to 1.27 at 0.3 and 1.15 to 1.16 at 0.7. It includes about four readings of the clock per window, which
//! lower it, and leaves out the synchronization and the caches of the second processor. The longer strip takes 1.13 (0.3) and 1.19
//! (0.7) times the mean: with 35 to 50 events per strip and window, waiting is a large loss.
//!
//! Each thread has a strip of rows of cells, with a queue of interior events, whose scans read rows of the strip only. The other
//! events are layer events, one heap per strip. The strips execute interior events in parallel up to a bound, the time of the
//! earliest layer event of any strip. An interior event that predicts an earlier layer event lowers the bound. What a strip has
//! executed at or after the final bound is undone from copies of the records. Then the events up to the bound are executed one at
//! a time, in the order of one thread. Two strips, 200,000 collisions of 1e5 discs, one run on a busy machine; what is undone
//! depends on the timing:
//!
//! | packing fraction | events | one at a time | parallel windows | events per window | windows undone | events undone |
//! |---|---|---|---|---|---|---|
//! | 0.3 | 458,915 | 5069 (1.10 %) | 4758 | 96 | 4 | 36 |
//! | 0.7 | 278,311 | 4213 (1.51 %) | 4019 | 69 | 0 | 0 |
//!
//! State that depends on the order of all events, and how each part keeps its bits:
//!
//! - sums, counts and time of the last collision: each strip logs its collisions, which are merged by time, event and disc;
//! - shift of the clock's origin, moments every n collisions, and targets: a window has room for fewer events than remain, and the
//!   last 64 are executed one at a time;
//! - random numbers of wall noise: wall collisions with noise are layer events;
//! - detection of inelastic collapse: not in the prototype; a rapid collision, or one of a disc that has a count, must be a layer event;
//! - cells of more than four discs: not in the prototype; the linked lists belong to the discs, but their number is one for all;
//! - queues: an undone event is scheduled again, and entries that are not the event of their disc are skipped, as with one thread;
//! - an event whose partner has moved into the layer since the prediction, or into another strip, is a layer event when it is due.
//!
//! Not solved: an old entry of a queue may name a disc that has moved into another strip. The reader must compare the cell, read as
//! an atomic number, before it reads the rest of the record. All accesses to records must go through cells (`UnsafeCell`), not
//! references to the whole array, which the scans use now. If another program takes a processor, a window waits for it: at a
//! load average of 19 on two processors, two threads were 6 (0.3) and 18 (0.7) times slower than one.
//!
//! Decision: an estimate of at most 1.27 is below 1.4, from which on the effort is worth it, so the engine keeps one thread.
//!
//! # Blocks for the cache: an upper bound
//!
//! `cargo bench --bench packing_speed -- blocks` visits independent boxes, together 1e6 discs, in turn for some collisions each, and
//! compares them with one box of 1e6 discs. This is what blocks for the cache could gain at most: independent boxes have no common
//! borders, no log of changes and nothing to undo. AMD EPYC with AVX-512, quiet, one thread, nine pairs, medians (the
//! ranges are up to 15 % wide):
//!
//! | collisions per visit | 1e3 discs, 0.3 and 0.7 | 1e4 discs | 1e5 discs |
//! |---|---|---|---|
//! | 10 | 0.31, 0.40 | 0.26, 0.39 | 0.81, 0.89 |
//! | 30 | 0.39, 0.48 | 0.26, 0.39 | 0.83, 0.90 |
//! | 100 | 0.55, 0.74 | 0.33, 0.42 | 0.86, 0.91 |
//! | 1000 | 1.39, 1.78 | 0.58, 0.76 | 0.84, 0.90 |
//! | 10,000 | 1.66, 1.99 | 1.20, 1.60 | 1.10, 1.34 |
//!
//! Boxes below 1e5 discs do not prefetch, so a visit begins slowly. A gain needs about one collision per disc and visit. Causality allows far
//! fewer: in the prototype above, 1.10 % (0.3) and 1.51 % (0.7) of the events touch one of two borders of strips of 158 rows, so a square of
//! 1e3, 1e4 or 1e5 discs, with four borders, has about 9, 29 or 91 events (0.3) and 7, 21 or 66 events (0.7) between two events at its own
//! border. At these lengths, blocks are slower than one box. A longer visit must be undone whenever an event at its border comes first.
//! Decision: no blocks.

#![allow(clippy::unwrap_used, reason = "a benchmark may panic")]

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group};
use kinetoscope_manifest::model::{Boundary, PackingConfig, PackingPlacement};
use kinetoscope_manifest::quantity::{BoxSide, Fraction, NonNegative, Positive};
use kinetoscope_physics::model::{Model, Target};
use kinetoscope_physics::packing::Packing;
use kinetoscope_physics::random::Seed;
use kinetoscope_physics::simd::registers::widest;
use std::hint::black_box;
use std::num::NonZeroU32;
use std::time::Instant;

/// Collisions per measurement.
const COLLISIONS: u64 = 100_000;

/// Collisions per disc before the measurement, which destroy the initial lattice, except for some order at fraction 0.7.
const EQUILIBRATION: u64 = 20;

fn periodic(discs: u32, fraction: f64) -> PackingConfig {
    let side = (f64::from(discs) * std::f64::consts::PI / fraction).sqrt();
    let (side, radius) = if side < 10.0 { (10.0, 10.0 / side) } else { (side, 1.0) };
    PackingConfig {
        discs: NonZeroU32::new(discs).unwrap(),
        width: BoxSide::new(side).unwrap(),
        height: BoxSide::new(side).unwrap(),
        radius: Positive::new(radius).unwrap(),
        boundary: Boundary::Periodic,
        remove_mean_velocity: true,
        placement: PackingPlacement::Lattice,
        ..PackingConfig::default()
    }
}

/// Peak memory of the program so far, if the system reports it.
fn peak_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM"))?;
    line.split_whitespace().nth(1)?.parse::<u64>().ok().map(|kibibytes| kibibytes * 1024)
}

/// Measures one configuration. With `has_series`, <v²> and a2 are recorded after each collision.
fn measure(criterion: &mut Criterion, group: &str, config: &PackingConfig, has_series: bool) {
    let mut group = criterion.benchmark_group(group);
    group.sample_size(10).throughput(Throughput::Elements(COLLISIONS));
    // Prepared only if the filter of the command line selects it.
    let mut prepared: Option<Packing> = None;
    group.bench_function(BenchmarkId::from_parameter(config.discs), |bencher| {
        let packing = prepared.get_or_insert_with(|| equilibrated(config, 0, has_series));
        bencher.iter(|| {
            let target = Target::Count(packing.count() + COLLISIONS);
            packing.advance(target, u64::MAX).unwrap()
        });
    });
    if prepared.is_some()
        && let Some(bytes) = peak_bytes()
    {
        println!("peak so far: {:.0} bytes per disc", bytes as f64 / f64::from(config.discs.get()));
    }
}

fn speeds(criterion: &mut Criterion) {
    for discs in [50, 1_000, 10_000, 100_000, 1_000_000] {
        for fraction in [0.3, 0.7] {
            measure(criterion, &format!("periodic {fraction}"), &periodic(discs, fraction), false);
        }
    }
    let within_walls = PackingConfig { boundary: Boundary::Walls, ..periodic(50, 0.3) };
    measure(criterion, "four walls 0.3", &within_walls, false);
    let exercise = PackingConfig {
        wall_noise_variance_rad2: NonNegative::literal(std::f64::consts::PI / 1000.0),
        remove_mean_velocity: true,
        ..PackingConfig::default()
    };
    measure(criterion, "exercise, four walls with noise", &exercise, false);
    let with_all = PackingConfig {
        boundary: Boundary::Walls,
        restitution: Fraction::new(0.999).unwrap(),
        wall_noise_variance_rad2: NonNegative::literal(0.0031),
        ..periodic(10_000, 0.3)
    };
    measure(criterion, "walls, restitution and noise 0.3", &with_all, false);
    measure(
        criterion,
        "mean square speed and a2 of each collision 0.3",
        &periodic(10_000, 0.3),
        true,
    );
}

/// Numbers in a register of AVX2.
const AVX2: usize = 4;

/// Alternating measurements of two widths.
const PAIRS: usize = 9;

/// A packing after its equilibration.
fn equilibrated(config: &PackingConfig, replicate: u32, has_series: bool) -> Packing {
    let mut packing = Packing::prepare(config, Seed { seed: 1, replicate }, has_series).unwrap();
    let events = EQUILIBRATION * u64::from(config.discs.get());
    packing.advance(Target::Count(events), u64::MAX).unwrap();
    packing
}

/// Million collisions per second.
fn speed(packing: &mut Packing, width: usize) -> f64 {
    let target = Target::Count(packing.count() + COLLISIONS);
    let start = Instant::now();
    black_box(packing.advance_at_width(target, u64::MAX, width).unwrap());
    COLLISIONS as f64 / start.elapsed().as_secs_f64() / 1e6
}

/// Median, minimum and maximum.
fn summary(mut values: Vec<f64>) -> [f64; 3] {
    values.sort_unstable_by(f64::total_cmp);
    [values[values.len() / 2], values[0], values[values.len() - 1]]
}

/// Prints the speeds of registers of a width, and their ratios to those of AVX2.
fn compare_width(start: &Packing, width: usize) {
    let (mut reference, mut packing) = (start.clone(), start.clone());
    let (mut speeds, mut ratios) = (Vec::new(), Vec::new());
    for pair in 0..=PAIRS {
        let of_widest = speed(&mut reference, AVX2);
        let of_width = speed(&mut packing, width);
        // The first pair only fills the caches.
        if pair > 0 {
            speeds.push(of_width);
            ratios.push(of_width / of_widest);
        }
    }
    assert!(reference == packing, "width {width} gives other bits");
    let ([speed, ..], [ratio, least, largest]) = (summary(speeds), summary(ratios));
    println!(
        "    width {width}: {speed:.2} M/s, over AVX2: {ratio:.3} ({least:.3} to {largest:.3})"
    );
}

/// Compares plain x86-64 with AVX2, and AVX2 with itself for the scatter.
fn compare_widths() {
    assert!(widest() >= AVX2, "this processor has no AVX2");
    println!("{PAIRS} pairs, same bits");
    for discs in [50, 1_000, 10_000, 100_000] {
        for fraction in [0.3, 0.7] {
            println!("{discs} discs, packing fraction {fraction}");
            let start = equilibrated(&periodic(discs, fraction), 0, false);
            compare_width(&start, AVX2);
            compare_width(&start, 1);
        }
    }
}

/// Compares discs in gravity, which halves their density over the height of the box, with the same discs without it.
fn compare_gravity() {
    println!("{PAIRS} pairs: speed in gravity over that without");
    for discs in [50, 1_000, 10_000, 100_000] {
        for fraction in [0.1, 0.3, 0.6] {
            let still = PackingConfig { boundary: Boundary::Walls, ..periodic(discs, fraction) };
            let gravity = NonNegative::new(std::f64::consts::LN_2 / still.height.get()).unwrap();
            let falling = PackingConfig { gravity, ..still.clone() };
            let [mut still, mut falling] =
                [still, falling].map(|config| equilibrated(&config, 0, false));
            let ratios = (0..=PAIRS).map(|_| {
                let without = speed(&mut still, AVX2);
                speed(&mut falling, AVX2) / without
            });
            // The first pair only fills the caches.
            let [ratio, least, largest] = summary(ratios.skip(1).collect());
            println!("    {discs} discs, {fraction}: {ratio:.3} ({least:.3} to {largest:.3})");
        }
    }
}

/// Discs of all blocks, and of the one box with which they are compared.
const DISCS_OF_BLOCKS: u32 = 1_000_000;
/// Collisions of a measurement of blocks.
const COLLISIONS_OF_BLOCKS: u64 = 500_000;

/// Advances boxes in turn by some collisions each; million collisions per second.
fn speed_of_blocks(blocks: &mut [Packing], per_visit: u64) -> f64 {
    let visits = COLLISIONS_OF_BLOCKS / per_visit;
    let start = Instant::now();
    for visit in 0..visits {
        let block = &mut blocks[visit as usize % blocks.len()];
        let target = Target::Count(block.count() + per_visit);
        black_box(block.advance(target, u64::MAX).unwrap());
    }
    (visits * per_visit) as f64 / start.elapsed().as_secs_f64() / 1e6
}

/// Compares independent boxes, each visited for some collisions, with one box of as many discs: what blocks for the cache could gain.
fn compare_blocks() {
    println!("{DISCS_OF_BLOCKS} discs in blocks over one box; {PAIRS} pairs");
    for fraction in [0.3, 0.7] {
        let mut whole = [equilibrated(&periodic(DISCS_OF_BLOCKS, fraction), 0, false)];
        for discs in [1_000, 10_000, 100_000] {
            let config = periodic(discs, fraction);
            let replicates = 0..DISCS_OF_BLOCKS / discs;
            let mut blocks: Vec<Packing> =
                replicates.map(|replicate| equilibrated(&config, replicate, false)).collect();
            for per_visit in [10, 30, 100, 1_000, 10_000] {
                let ratios = (0..=PAIRS).map(|_| {
                    let one = speed_of_blocks(&mut whole, COLLISIONS_OF_BLOCKS);
                    speed_of_blocks(&mut blocks, per_visit) / one
                });
                // The first pair only fills the caches.
                let [ratio, least, largest] = summary(ratios.skip(1).collect());
                println!(
                    "    fraction {fraction}, blocks of {discs}, {per_visit} collisions per visit: {ratio:.2} ({least:.2} to {largest:.2})"
                );
            }
        }
    }
}

criterion_group!(benches, speeds);

fn main() {
    let mut arguments = std::env::args().skip(1).filter(|argument| argument != "--bench");
    let part = arguments.next();
    if part.as_deref() == Some("width") {
        compare_widths();
    } else if part.as_deref() == Some("gravity") {
        compare_gravity();
    } else if part.as_deref() == Some("blocks") {
        compare_blocks();
    } else {
        benches();
        Criterion::default().configure_from_args().final_summary();
    }
}
