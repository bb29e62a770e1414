//! Law: the normalized runout (R - R0)/R0 of a released column of height H and width R0 is proportional to its aspect ratio
//! a = H/R0 for low columns, and to a^(2/3) for tall ones.
//!
//! Source: Lube et al., Phys. Rev. E 72 (2005) 041301 (two dimensions; J. Fluid Mech. 508 (2004) 175 for round columns);
//! Lajeunesse et al., Phys. Fluids 17 (2005) 103302; Staron and Hinch, J. Fluid Mech. 545 (2005) 1, simulations of discs with
//! the power 0.7 for tall columns. The regimes meet between a = 1.7 and 3.
//! Setup: discs as in `experiments/dem_column_collapse.toml` behind a gate that is removed. Low columns: twelve each of 75 and
//! 300 discs, ten diameters wide, a = 0.7 and 2.9; three each of 705 and 2820 discs, thirty diameters wide, a = 0.75 and 3.
//! Tall columns: four of 600 discs and two of 2400, ten diameters wide, a = 5.7 and 23.
//! Tolerance: 0.15 for the power of low columns and 0.13 for that of tall ones, about the mean of 2/3 and 0.7. Columns of 75 discs
//! scatter by 15 %, of 300 and 600 by 6 to 8 %, of 705 and more by 2 to 6 %, so that the powers have standard errors of 0.03 to 0.04.
//! Control: each band rejects the power of the other regime, as given by the sources and as measured. Without friction, columns
//! spread to the far wall: both bands reject the power.

use crate::scene::{discs, finite, non_negative, positive, run_to_time, segment, shipped_run};
use kinetoscope_manifest::model::{DemConfig, DemWall};
use kinetoscope_physics::dem::Dem;
use kinetoscope_physics::model::Model;
use kinetoscope_physics::random::Seed;
use std::num::NonZeroU32;
use std::ops::RangeInclusive;

/// Discs separated by a larger gap than this do not belong to the deposit, m.
const GAP_M: f64 = 2e-3;
/// Speed of the gate, m/s: no disc overtakes it.
const GATE_SPEED: f64 = 3.2;

/// Powers of low columns.
const LOW: RangeInclusive<f64> = 0.85..=1.15;
/// Powers of tall columns.
const TALL: RangeInclusive<f64> = 0.55..=0.81;

/// Columns that differ by their discs only: their width, the box, and the times at which the gate opens and the deposit rests.
#[derive(Clone, Copy)]
struct Setup {
    width_m: f64,
    box_m: [f64; 2],
    opens_s: f64,
    ends_s: f64,
}

const NARROW_LOW: Setup = Setup { width_m: 0.01, box_m: [0.17, 0.1], opens_s: 0.22, ends_s: 0.7 };
const WIDE_LOW: Setup = Setup { width_m: 0.03, box_m: [0.4, 0.2], opens_s: 0.35, ends_s: 1.05 };
const NARROW_TALL: Setup = Setup { width_m: 0.01, box_m: [0.6, 0.5], opens_s: 0.55, ends_s: 1.6 };

impl Setup {
    fn column(self, discs: u32) -> DemConfig {
        let (shipped, _) = shipped_run("dem_column_collapse", "discs=150");
        let Self { width_m, box_m: [width, height], opens_s, ends_s } = self;
        // The gate stops a diameter before the far wall.
        let closes_s = opens_s + (width - width_m - 1e-3) / GATE_SPEED;
        let gate = DemWall {
            velocity_m_per_s: finite([GATE_SPEED, 0.0]),
            moves_s: Some([opens_s, closes_s].map(non_negative)),
            ..segment([width_m, 0.0], [width_m, height])
        };
        DemConfig {
            discs: NonZeroU32::new(discs).expect("not empty"),
            width_m: positive(width),
            height_m: positive(height),
            placement_region_m: Some([finite([0.0; 2]), finite([width_m, height])]),
            walls: vec![gate],
            duration_s: positive(ends_s),
            ..shipped
        }
    }

    /// Mean normalized runout of several columns.
    fn runout(self, discs: u32, columns: u32) -> f64 {
        let config = self.column(discs);
        let (config, width_m) = (&config, self.width_m);
        let runouts: Vec<f64> = std::thread::scope(|scope| {
            let columns: Vec<_> = (0..columns)
                .map(|replicate| {
                    scope.spawn(move || runout(config, Seed { seed: 28, replicate }, width_m))
                })
                .collect();
            columns.into_iter().map(|column| column.join().expect("a runout")).collect()
        });
        println!("{discs} discs: {runouts:.2?}");
        runouts.iter().sum::<f64>() / f64::from(columns)
    }
}

/// (R - R0)/R0 at the end. R is the position of the first gap or, without friction, of the last disc: no deposit forms, the discs move
/// in one layer.
fn runout(config: &DemConfig, seed: Seed, width_m: f64) -> f64 {
    let mut model = Dem::prepare(config, seed, false).unwrap_or_else(|error| panic!("{error}"));
    run_to_time(&mut model, config.duration_s.get());
    let mut edges: Vec<f64> =
        discs(&model).iter().map(|disc| disc.position[0] + disc.radius).collect();
    edges.sort_by(f64::total_cmp);
    let has_friction = config.friction.get() > 0.0;
    let gap = edges.windows(2).position(|pair| pair[1] - pair[0] > GAP_M).filter(|_| has_friction);
    edges[gap.unwrap_or(edges.len() - 1)] / width_m - 1.0
}

/// The power between two numbers of discs, to which the heights are proportional.
fn power(few: (u32, f64), many: (u32, f64)) -> f64 {
    libm::log(many.1 / few.1) / libm::log(f64::from(many.0) / f64::from(few.0))
}

#[test]
#[ignore = "30 columns take two minutes"]
fn runout_of_low_columns_is_proportional_to_the_aspect_ratio() {
    for (setup, [few, many], columns) in [(NARROW_LOW, [75, 300], 12), (WIDE_LOW, [705, 2820], 3)] {
        let [low, high] = [few, many].map(|discs| (discs, setup.runout(discs, columns)));
        let power = power(low, high);
        println!("runout {:.2} and {:.2}: power {power:.3}", low.1, high.1);
        assert!(LOW.contains(&power), "{power}");
        assert!(!TALL.contains(&power), "control: {power}");
    }
    assert!(![2.0 / 3.0, 0.7].iter().any(|power| LOW.contains(power)), "control");
}

#[test]
#[ignore = "six tall columns take two minutes"]
fn runout_of_tall_columns_has_the_power_two_thirds() {
    let [low, high] =
        [(600, 4), (2400, 2)].map(|(discs, columns)| (discs, NARROW_TALL.runout(discs, columns)));
    let power = power(low, high);
    println!("runout {:.2} and {:.2}: power {power:.3}", low.1, high.1);
    assert!(TALL.contains(&power), "{power}");
    assert!(!LOW.contains(&power), "control: {power}");
    assert!(!TALL.contains(&1.0), "control");
}

#[test]
fn control_frictionless_columns_spread_to_the_far_wall() {
    let runout = |discs| {
        let config = DemConfig {
            friction: non_negative(0.0),
            rolling_friction: non_negative(0.0),
            ..NARROW_LOW.column(discs)
        };
        (discs, runout(&config, Seed { seed: 28, replicate: 0 }, NARROW_LOW.width_m))
    };
    let power = power(runout(75), runout(300));
    println!("without friction: power {power:.3}");
    assert!(!LOW.contains(&power) && !TALL.contains(&power), "{power}");
}
