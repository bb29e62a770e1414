//! Hard discs: collisions a second of the engine alone, in periodic boxes at packing fractions 0.3 and 0.7, and in the
//! document's box of fifty within walls; bytes a disc of the whole program are printed beside.
//!
//! What helped, at 1024 discs and packing fractions 0.3 and 0.7 (AMD EPYC with AVX-512, one thread, processor time):
//! the contact equation of growing discs kept out of the loop over lanes, 1.15 and 1.15; the search in registers,
//! without arrays between its parts, 1.28 and 1.46; no branch on the outcome of a search, and vectors read back in
//! the width in which they were written (a wider read waits until the writes have left the processor), 1.12 and 1.02;
//! functions that are always inlined instead of closures, 1.02 and 1.05; half as many cells in dilute systems, 1.25 at
//! fraction 0.1 and 3 at 0.02. What did not: pages of the calendar for 3, 5 or 14 events instead of 8, 0.96, 0.99 and 1.00
//! at fraction 0.3; the whole loop compiled for wide instructions while the search still went through arrays, 0.95 and
//! 1.02.
//!
//! `cargo bench --bench packing_speed`; a part of it: `cargo bench --bench packing_speed -- 0.3/1000`.

#![allow(clippy::unwrap_used, reason = "a benchmark may panic")]

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use kinetoscope::model::{Model, Target};
use kinetoscope::models::packing::Packing;
use kinetoscope::random::Seed;
use kinetoscope_manifest::model::{Boundary, PackingConfig, PackingPlacement};
use kinetoscope_manifest::quantity::{BoxSide, NonNegative, Positive};
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

fn measure(criterion: &mut Criterion, group: &str, config: &PackingConfig) {
    let mut group = criterion.benchmark_group(group);
    group.sample_size(10).throughput(Throughput::Elements(COLLISIONS));
    // Made only when the filter of the command line asks for it.
    let mut mixed: Option<Packing> = None;
    group.bench_function(BenchmarkId::from_parameter(config.discs), |bencher| {
        let packing = mixed.get_or_insert_with(|| {
            let mut packing =
                Packing::prepare(config, Seed { seed: 1, replicate: 0 }, false).unwrap();
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
            measure(criterion, &format!("periodic {fraction}"), &periodic(discs, fraction));
        }
    }
    measure(criterion, "document, four walls with noise", &PackingConfig::default());
}

criterion_group!(benches, speeds);
criterion_main!(benches);
