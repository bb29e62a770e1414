//! Speed of the DEM in particle-steps per second on one thread, with and without SIMD instructions.
//!
//! Changes that raised the speed (processor time, one thread of an AMD EPYC, before and after in million particle-steps per second
//! (M/s) or as a factor, 10^4 discs unless stated):
//! - blocks that are patches instead of rows of the box: a collapsing bed of 10^6 discs 6.8 to 68 M/s with all of the below;
//! - patches, pairs in contact first in the list, SIMD kick and drift: gas 88 to 108 M/s, collapse 51 to 68;
//! - lists from whole columns of cells, inner discs by a shorter path, and two discs per register instead of columns of four
//!   for kick and drift (18 instructions per disc instead of 37): gas 113 to 148, collapse 72 to 86, settled 71 to 80;
//! - friction without a copy of the sums in memory for each pair: with moves in place 15 to 20;
//! - friction with AVX2, springs in separate columns, the torque's radius factored out of the sums: 20 to 41; eight pairs per
//!   register with AVX-512 instead of four: 41 to 50; energies summed in registers, not in memory: 50 to 53; SIMD spins: 53 to 56;
//! - lists in tiers with wider skins, lists found four discs at a time, only centers compared if few pairs are in contact, 1/m stored,
//!   the box checked only if a disc may have left it, forces set to zero by the pass that reads them: gas 157 to 214, collapse 99 to
//!   123, settled 84 to 97 (best of interleaved runs on a busy machine);
//! - lists built in half the time: 79 to 39 ns per disc in a gas, 102 to 50 in a collapse, 94 to 50 settled (best of interleaved runs);
//!   therefore gas 188 to 225, collapse 122 to 143, settled 96 to 101. In a gas, comparisons listed first and made in one loop, cells
//!   located once per column, inter-block pairs found like inner pairs and dampings found four at a time took it to 47; tiers sorted in
//!   four parts and discs wrapped in groups to 44; search memory kept, and columns of one value left unsorted, to 42; a leaner loop
//!   to 39. In beds, discs near walls are found in 3 ns instead of 8;
//! - forces without friction in two passes, the first with all roots and quotients and no sum that waits for them (1.08 settled), rows
//!   at multiples of 32 bytes (1.12 settled, 1.05 in a gas; 1.03 before the two passes);
//! - contacts listed singly instead of in groups of four, eight pairs compared at a time (1.05 in a gas); only those pairs compared that
//!   may touch within a sixteenth of the skin (1.18 in a gas, 1.11 in a collapse); near inter-block pairs likewise, and discs without
//!   contacts moved by a pass that reads no forces (1.06 and 1.10 in a gas); the fastest disc's speed instead of the largest components
//!   (1.05 in a gas);
//! - free flight that writes no velocities (1.07 in a gas), then positions and velocities in separate columns (1.07 in a gas at 10^4,
//!   1.00 at 10^5; 0.95 settled, 0.96 with friction, where every pair needs both).
//!
//! In total, the two rounds without friction made settled beds faster by a factor of 1.15, a collapse by 1.3 and a gas by 2.
//!
//! Changes that did not:
//! - moving in place instead of into a second copy of the state (1.00 at 10^4; it saves a third of the memory), and indices checked
//!   once per block instead of once per pair, with pairs interleaved from four quarters (1.01 in a gas, 1.03 settled);
//! - smaller blocks, whose states fit the nearest cache: 1250 discs 0.95, 700 0.92, 400 0.88 in a gas, less in beds: more inter-block
//!   pairs;
//! - tiers within strips of 256 discs (1.00 in a gas, 0.97 in beds); 4 or 8 tiers instead of 16 (no difference beyond noise);
//! - blocks of 800, 1250 and 5000 discs again later (0.86, 0.93 and 1.02 in a gas; 0.88, 0.93 and 0.97 settled); other horizons for near
//!   pairs, or other skins once builds cost less (0.92 to 1.00 in a gas);
//! - only lists found four discs at a time (1.03 in a collapse, 1.00 in a gas);
//! - eight pairs without friction per register with AVX-512 instead of four (0.92 settled, 0.97 in a gas, 0.98 in a collapse);
//! - one codegen unit (1.03 settled and in a collapse, 1.01 in a gas; 0.97 in packing);
//! - comparisons listed for a whole block instead of column by column (1.0 of a build); cells of discs found with SIMD instructions (0.99
//!   of a build); two runs of discs listed at once (1.02 of a build, not worth its lines);
//! - two passes for pairs with friction (1.00 while their energies were still summed in memory).
//!
//! Nor did these (26 Nov 2026, AMD EPYC of the fourth generation with AVX-512, runs of `dem_peer` in turn, same bits, medians and ranges of 3
//! to 5 ratios, at 10^4 discs unless stated; other work on the host disturbed some series):
//! - indices stored as offsets in bytes, so that no instruction multiplies them: settled 1.02 (1.01 to 1.03), with friction 1.03 (1.01
//!   to 1.04) and 1.01 (1.00 to 1.02) at 10^5, gas 1.00, collapse 1.01; not worth its lines;
//! - positions and velocities of a block copied to common rows before its pairs are visited: settled 0.98 (0.95 to 1.01);
//! - batches of 4, 8 and 32 groups instead of 16: settled 0.95, 0.98 and 0.99; in a disturbed series 0.94, 0.90 and 0.87;
//! - the memory of the next block requested while a block is computed: settled 1.01 (0.80 to 1.18), 0.98 (0.93 to 1.01) at 10^5;
//! - overlap over radius computed only for those contacts at walls and between blocks where it may be the largest: settled 0.98 (0.97
//!   to 1.03), 1.01 (0.97 to 1.09) at 10^5.
//!
//! Nor did one kernel that decides per group whether contacts are recorded, instead of one for each case (29 Nov 2026, Intel Xeon with
//! AVX-512, medians of 9 alternate runs of `dem_peer`): settled 0.89, other scenes without friction 1.00; with friction 0.97 to 1.03, where it stays: it is
//! smaller. One for each case without friction again: settled 0.98 to 1.01.
//!
//! One contact kernel for every register width, compared with the hand-written loops before it, same bits (22 Nov 2026, thread time of an
//! Intel Xeon with AVX-512, 10^4 discs, minima of 14 alternate runs on a busy machine, a ratio above 1 is faster): settled 1.01, with
//! friction 1.03 to 1.06, collapse 0.98, gas 0.96 to 0.97. The gas was below the aim of 0.97: its contact kernel and the comparisons of its
//! pair search each take some 2 % of the step more than before.
//!
//! Free flight with chosen instructions (23 Nov 2026, AMD EPYC with AVX2, 2000 discs, periodic, same bits): 1208 to 844 ns per step, because
//! the compiler's own shuffles crossed the halves of registers. With it, and with discs in contact counted by SIMD instructions, runs of
//! a dilute gas are faster by a factor of 1.05 to 1.08 (20 alternate pairs on a busy machine). Their speed over that with hand-written
//! loops is 0.98 to 1.04, depending on the series and on the statistic. Fewer shuffles from the compiler, by another order of the
//! maxima, gave 1.00: it loaded velocities in pieces.
//!
//! Speed over that of LAMMPS (22 Jul 2025), wall time in turn, medians of series of 3 to 5 pairs. `benches/peers/dem_lammps.py DEM_PEER` with
//! - `settled 10000 5000 3`: 10.4, 10.6, 10.4; `settled 100000 1000 5`: 12.5 (11.6 to 12.7), quiet; before, 11.3 (eight pairs of 500 or
//!   1000 steps, 7.0 to 13.2);
//! - `collapse 10000 6000 3`: 8.7, 8.7, 9.5; with 5 pairs, quiet, 8.5 (8.3 to 8.8);
//! - `gas 10000 4000 5`: 9.8, 9.4, 9.2, 9.7, 9.4, 9.4, and with 8000 steps 9.5; `gas 100000 1000 3`: 12.8;
//! - `frictional 10000 3000 3` (gran/hooke/history): 6.3, 6.4, 6.1;
//! - `spheres_history 10000 500 3` (gran/hertz/history): 11.8 (9.7 to 12.5), on a busy machine; `spheres 10000 500 3` (granular with the
//!   same law and dashpot): kinetic energies of the bed, radii +-10 %, 2.6e-14 apart;
//! - `frictional_spheres_history` (gran/hertz/history with its tangential springs, of another stiffness; 29 Nov 2026, on a busy machine):
//!   `10000 500 5` 5.3 (5.2 to 5.4) and 4.9 (4.1 to 5.6), `10000 2000 7` 4.9 (4.5 to 6.2), `10000 1000 6` 5.4 (4.8 to 6.3); on an idle
//!   Intel Xeon with AVX-512, `10000 2000 7` 4.8 (4.3 to 5.6), where `spheres_history 10000 1000 3` gives 9.5 (8.9 to 10.0); since reduced
//!   radii are kept with the pairs (1.04 of the program before, nine pairs, same bits) and springs are not sorted when lists are rebuilt (1.01 to
//!   1.02), 5.0 (4.7 to 5.4, nine pairs) on the same machine, busy. What did not help: radii from the vectors of radius and spin (0.99), four
//!   pairs per register (0.98), springs sorted by one number (1.003);
//! - `equal 2000 10000 1`: kinetic energies of a bed at rest 8e-12 apart; those of the gas are 1e-4 apart after 4000 steps. While a bed still
//!   moves, they diverge, because its motion is chaotic.
//!
//! Hertz's law over the linear spring (28 Nov 2026, processor time of `dem_peer SCENE 10000 4000 1 FILE` with its 20,000 steps before, in
//! turn, minima of 5 on a busy machine, AMD EPYC): `spheres` 0.81 of `settled`, `frictional_spheres` 0.86 of `frictional`. Over the program
//! with the linear spring alone, same bits: settled 0.99, with friction 1.04, gas (`gas 10000 30000`, 4 pairs) 1.00.
//!
//! Two threads over one, `dem_peer SCENE 100000 1000 THREADS FILE`: settled 2.1 to 2.5, frictional 1.9 to 2.6: each core has a cache of its own.
//!
//! In a settled bed the pair loop takes two thirds of the time. A gas spends 15 % in free flight, 17 % on comparing near pairs, 9 % on
//! finding them, 9 % on kicks, 25 % on building the list.

mod dem_beds;

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use dem_beds::Scene;
use kinetoscope_physics::model::{Model, Target};

const STEPS: u64 = 20;

fn speed(criterion: &mut Criterion) {
    for (scene, discs) in [
        (Scene::Settled, 10_000),
        (Scene::Settled, 100_000),
        (Scene::Frictional, 10_000),
        (Scene::Gas, 10_000),
        (Scene::Collapse, 10_000),
    ] {
        let model = scene.model(discs);
        let mut group = criterion.benchmark_group(format!("{scene:?}/{discs}"));
        group.throughput(Throughput::Elements(u64::from(discs) * STEPS)).sample_size(20);
        for (name, width) in [("scalar", 1), ("simd", 8)] {
            group.bench_function(name, |bencher| {
                bencher.iter_batched_ref(
                    || model.clone().with_max_width(width),
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
