//! What a large bed costs: speed per disc of beds of 10^5 discs over that of 10^4, in turn, on one thread.
//!
//! `cargo bench --bench dem_large_beds [-- frictional]`; settled beds without friction, frictional beds with it. Figures are million
//! particle-steps per second and the ratio large / small: the median of pairs, with the smallest and the largest. Beds settle for
//! 20 000 steps before the first pair.
//!
//! Aim: 0.7 with friction. Two quiet cores of an AMD EPYC of the fourth generation (AVX-512), two series: with friction 0.67 (0.53 to 0.79)
//! and 0.80 (0.73 to 0.92), settled 0.77 (0.73 to 0.83) and 0.84 (0.82 to 0.87). Memory is shared with other machines.
//!
//! A large bed does not visit more pairs per disc than a small one, nor rebuild its lists more often (friction: 2.0 to 2.1 pairs in scope
//! per disc at either size). It is slower because its lists, springs and discs come from memory. Changes that raised its speed
//! (24 Nov 2026, AMD EPYC with AVX-512, processor time on a busy machine, alternate runs, median and range of 5 ratios, same bits):
//! - indices of two bytes within a block: friction at 10^5 discs 1.09 (1.02 to 1.13), settled 1.16 (1.02 to 1.29); 1.02 settled at 10^4;
//! - and memory for forces that is lent for each block, instead of a piece for each group of blocks, which was no longer in the cache
//!   when its turn came: with both, friction 1.45 (1.24 to 1.60), settled 1.30 (1.08 to 1.46); 1.00 and 1.02 at 10^4. In a simulated cache of
//!   1 MiB, a disc with friction misses 2.05 lines per step instead of 2.67.
//!
//! Lists and springs requested two batches before they are read: 0.86 with friction, 1.00 settled.

mod dem_beds;

use dem_beds::{Scene, print_header, print_row};
use kinetoscope_physics::dem::Dem;
use kinetoscope_physics::model::{Model, Target};
use rayon::ThreadPoolBuilder;
use std::time::Instant;

const PAIRS: usize = 7;
const SIZES: [u32; 2] = [10_000, 100_000];
/// Particle-steps per measurement.
const WORK: u64 = 10_000_000;

fn main() {
    let chosen: Vec<String> = std::env::args().skip(1).filter(|word| word != "--bench").collect();
    let pool = ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    print_header(["10^4 discs", "10^5 discs"]);
    for (name, scene) in [("frictional", Scene::Frictional), ("settled", Scene::Settled)] {
        if !chosen.is_empty() && !chosen.iter().any(|word| word == name) {
            continue;
        }
        let mut models = SIZES.map(|discs| scene.model(discs));
        let pairs: Vec<[f64; 2]> = (0..PAIRS)
            .map(|_| {
                let [small, large] = &mut models;
                [(small, SIZES[0]), (large, SIZES[1])]
                    .map(|(model, discs)| pool.install(|| speed(model, discs)))
            })
            .collect();
        print_row(name, &pairs, |[small, large]| large / small);
    }
}

/// Million particle-steps per second.
fn speed(model: &mut Dem, discs: u32) -> f64 {
    let steps = WORK / u64::from(discs);
    let goal = Target::Count(model.count() + steps);
    let start = Instant::now();
    model.advance(goal, u64::MAX).expect("no blow-up");
    (u64::from(discs) * steps) as f64 / start.elapsed().as_secs_f64() / 1e6
}
