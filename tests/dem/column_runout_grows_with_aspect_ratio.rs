//! Law: a column of discs of height H and width R0 that is let go runs out by (R - R0)/R0 which grows as a power of the aspect ratio
//! a = H/R0 between 1 (2.5 a, low columns) and 0.7 (3.25 a^0.7, tall ones).
//!
//! Source: Staron and Hinch, J. Fluid Mech. 545 (2005) 1, simulations of discs; Lube et al., Phys. Rev. E 72 (2005) 041301, 2/3.
//! Setup: `experiments/dem_column_collapse.toml`: 150 and 600 discs behind a gate that goes, a = 1.4 and 5.7.
//! Tolerance: the power of the mean of eight columns each between 0.6 and 1.05: single columns of so few discs scatter by some 10 %, a
//! power over a factor of four by 0.1, and by 0.035 for the mean. Sixteen columns of each of the experiment's sizes give 0.97(2).
//! Control: without friction both run to the far wall.

use crate::scene::{discs, non_negative, run_to_time, shipped_run};
use kinetoscope_manifest::model::DemConfig;
use kinetoscope_physics::dem::Dem;
use kinetoscope_physics::model::Model;
use kinetoscope_physics::random::Seed;

const WIDTH: f64 = 0.01;
/// Discs further apart than this do not belong to the heap any more, m.
const GAP: f64 = 2e-3;

const COLUMNS: u32 = 8;

/// The mean of so many columns.
fn run_out(words: &str, has_friction: bool) -> f64 {
    let run_out = |replicate| run_out_of_one(words, has_friction, replicate);
    (0..COLUMNS).map(run_out).sum::<f64>() / f64::from(COLUMNS)
}

/// (R - R0)/R0 at the end: R where the first gap is; without friction that of the last disc.
fn run_out_of_one(words: &str, has_friction: bool, replicate: u32) -> f64 {
    let (config, seed) = shipped_run("dem_column_collapse", words);
    let seed = Seed { replicate, ..seed };
    let coefficient = |given| if has_friction { given } else { non_negative(0.0) };
    let config = DemConfig {
        friction: coefficient(config.friction),
        rolling_friction: coefficient(config.rolling_friction),
        ..config
    };
    let mut model =
        Dem::prepare(&config, seed, false).unwrap_or_else(|refusal| panic!("{refusal}"));
    run_to_time(&mut model, config.duration_s.get());
    let mut edges: Vec<f64> =
        discs(&model).iter().map(|disc| disc.position[0] + disc.radius).collect();
    edges.sort_by(f64::total_cmp);
    // Without friction there is no heap: discs roll about in one layer.
    let gap = edges.windows(2).position(|pair| pair[1] - pair[0] > GAP).filter(|_| has_friction);
    edges[gap.unwrap_or(edges.len() - 1)] / WIDTH - 1.0
}

fn exponent(low: f64, tall: f64) -> f64 {
    libm::log(tall / low) / libm::log(4.0)
}

fn is_a_columns(exponent: f64) -> bool {
    (0.6..=1.05).contains(&exponent)
}

#[test]
fn the_run_out_grows_with_the_aspect_ratio() {
    let (low, tall) = (run_out("discs=150", true), run_out("discs=600", true));
    let exponent = exponent(low, tall);
    println!("run-out {low:.2} and {tall:.2}: power {exponent:.3}");
    assert!(is_a_columns(exponent));
}

#[test]
fn without_friction_the_far_wall_ends_it() {
    let exponent = exponent(run_out("discs=150", false), run_out("discs=600", false));
    println!("without friction: power {exponent:.3}");
    assert!(exponent < 0.1 && !is_a_columns(exponent));
}
