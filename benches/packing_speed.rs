//! Hard discs: collisions a second of the engine alone, in periodic boxes at packing fractions 0.3 and 0.7, of
//! fifty discs within four walls, and in the document's box; bytes a disc of the whole program are printed beside.
//!
//! Million collisions a second, and how many times those of l09rin/EDMD (Cylinder2D), the fastest program in two dimensions
//! that we know, in turn with it on the same state (AMD EPYC with AVX-512, one thread, medians). That program is not ours to
//! keep here: the ratios were measured beside this repository, and no command of it prints them.
//!
//! | discs | 0.3 | times | 0.7 | times |
//! |---|---|---|---|---|
//! | 1e3 | 2.97 | 2.73 | 4.26 | 2.16 |
//! | 1e4 | 2.45 | 2.61 | 3.85 | 2.12 |
//! | 1e5 | 2.06 | 5.41 | 3.42 | 2.99 |
//! | 1e6 | 1.77 | 6.29 | 2.55 | 3.43 |
//!
//! Fifty discs within four walls: 3.23 million collisions a second at 0.3, 3.0 at 0.25, and 2.16 in the document's box, which is
//! emptier and whose walls add noise. At 1e4 discs and 0.3, walls, restitution and wall
//! noise cost 2 % and T and a2 of each collision 8 %. At 1e6 discs the whole program takes 132 and 125 bytes a disc.
//!
//! What helped small systems, at 1024 discs and packing fractions 0.3 and 0.7:
//! the contact equation of growing discs kept out of the loop over lanes, 1.15 and 1.15; the search in registers,
//! without arrays between its parts, 1.28 and 1.46; no branch on the outcome of a search, and vectors read back in
//! the width in which they were written (a wider read waits until the writes have left the processor), 1.12 and 1.02;
//! functions that are always inlined instead of closures, 1.02 and 1.05; half as many cells in dilute systems, 1.25 at
//! fraction 0.1 and 3 at 0.02. What did not: pages of the calendar for 3, 5 or 14 events instead of 8, 0.96, 0.99 and 1.00
//! at fraction 0.3; the whole loop compiled for wide instructions while the search still went through arrays, 0.95 and
//! 1.02; pages of the calendar sorted by counting instead of comparing, 1.01 and 1.00, and 0.8 in wide instructions.
//!
//! What helped large systems, at fraction 0.3 and 1e5 and 1e6 discs: fetching ahead for both partners and for the cell
//! beyond a crossing, entry by entry, with a calendar that reads no sheet to write on it, 1.5 and 1.75; fetching
//! without branches on who is there, 1.16 and 1.10; stages two events apart instead of four, 1.07 at 1e5; large pages of
//! memory, 1.05 and 1.28; numbers by place, 0.98 and 1.15. What did not: cells in quads that fill a cache line, and these
//! in patches that fill a page of memory, 0.92 at 1e5; fetching ahead at 1e4 discs, 0.97, and 0.89 at fraction 0.7; twice and
//! half as many pages in the calendar, 0.95 and 1.02 at 1e5, and the latter 0.97 at 1e6.
//!
//! `cargo bench --bench packing_speed`; a part of it: `cargo bench --bench packing_speed -- 0.3/1000`.

#![allow(clippy::unwrap_used, reason = "a benchmark may panic")]

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use kinetoscope_manifest::model::{Boundary, PackingConfig, PackingPlacement};
use kinetoscope_manifest::quantity::{BoxSide, NonNegative, Positive, Share};
use kinetoscope_physics::model::{Model, Target};
use kinetoscope_physics::packing::Packing;
use kinetoscope_physics::random::Seed;
use std::num::NonZeroU32;

/// Collisions of one measurement.
const COLLISIONS: u64 = 100_000;

/// Collisions a disc before measuring: the lattice is forgotten, or at 0.7 at least shaken.
const COLLISIONS_TO_MIX: u64 = 20;

fn periodic(discs: u32, fraction: f64) -> PackingConfig {
    let side = (f64::from(discs) * std::f64::consts::PI / fraction).sqrt();
    let (side, radius) = if side < 10.0 { (10.0, 10.0 / side) } else { (side, 1.0) };
    PackingConfig {
        discs: NonZeroU32::new(discs).unwrap(),
        width: BoxSide::new(side).unwrap(),
        height: BoxSide::new(side).unwrap(),
        radius: Positive::new(radius).unwrap(),
        boundary: Boundary::Periodic,
        wall_noise_variance_rad2: NonNegative::literal(0.0),
        placement: PackingPlacement::Lattice,
        ..PackingConfig::default()
    }
}

/// The peak memory of the program so far, where the system tells.
fn peak_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM"))?;
    line.split_whitespace().nth(1)?.parse::<u64>().ok().map(|kibibytes| kibibytes * 1024)
}

/// `has_series` records T and a2 after each collision, too.
fn measure(criterion: &mut Criterion, group: &str, config: &PackingConfig, has_series: bool) {
    let mut group = criterion.benchmark_group(group);
    group.sample_size(10).throughput(Throughput::Elements(COLLISIONS));
    // Made only when the filter of the command line asks for it.
    let mut mixed: Option<Packing> = None;
    group.bench_function(BenchmarkId::from_parameter(config.discs), |bencher| {
        let packing = mixed.get_or_insert_with(|| {
            let mut packing =
                Packing::prepare(config, Seed { seed: 1, replicate: 0 }, has_series).unwrap();
            let events = COLLISIONS_TO_MIX * u64::from(config.discs.get());
            packing.advance(Target::Count(events), u64::MAX).unwrap();
            packing
        });
        bencher.iter(|| {
            let target = Target::Count(packing.count() + COLLISIONS);
            packing.advance(target, u64::MAX).unwrap()
        });
    });
    if mixed.is_some()
        && let Some(bytes) = peak_bytes()
    {
        println!("peak so far: {:.0} bytes a disc", bytes as f64 / f64::from(config.discs.get()));
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
    measure(criterion, "document, four walls with noise", &PackingConfig::default(), false);
    let with_all = PackingConfig {
        boundary: Boundary::Walls,
        restitution: Share::new(0.999).unwrap(),
        wall_noise_variance_rad2: NonNegative::literal(0.0031),
        ..periodic(10_000, 0.3)
    };
    measure(criterion, "walls, restitution and noise 0.3", &with_all, false);
    measure(criterion, "T and a2 of each collision 0.3", &periodic(10_000, 0.3), true);
}

criterion_group!(benches, speeds);
criterion_main!(benches);
