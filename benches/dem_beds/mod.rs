//! Scenes of the DEM benchmarks.
#![allow(dead_code, reason = "each benchmark uses a part of it")]

use kinetoscope_manifest::model::{
    DemConfig, DiscRadius, Dissipation, Elasticity, GivenState, PeriodicSides, Placement,
};
use kinetoscope_manifest::quantity::{Finite, Fraction, NonNegative, Positive};
use kinetoscope_physics::dem::Dem;
use kinetoscope_physics::model::{Model, Target};
use kinetoscope_physics::random::Seed;
use std::num::NonZeroU32;

const RADIUS: f64 = 5e-4;
const SEED: Seed = Seed { seed: 7, replicate: 0 };

fn positive(value: f64) -> Positive {
    Positive::new(value).expect("above zero")
}

/// A scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Scene {
    /// A bed of discs at rest, radii +-10 %, packing fraction about 0.8.
    Settled,
    /// The same with friction 0.5.
    Frictional,
    /// The bed at rest with spheres by Hertz's law, and the same with friction 0.5.
    Spheres,
    FrictionalSpheres,
    /// Packing fraction 0.3, periodic, without gravity, e = 1.
    Gas,
    /// A loose bed that collapses.
    Collapse,
    /// A bed of equal discs at rest, on whose energy two programs must agree.
    Equal,
}

impl Scene {
    /// The scene with a name.
    pub(crate) fn named(name: &str) -> Option<Self> {
        match name {
            "settled" => Some(Self::Settled),
            "frictional" => Some(Self::Frictional),
            "spheres" => Some(Self::Spheres),
            "frictional_spheres" => Some(Self::FrictionalSpheres),
            "gas" => Some(Self::Gas),
            "collapse" => Some(Self::Collapse),
            "equal" => Some(Self::Equal),
            _ => None,
        }
    }

    /// The manifest of the scene, from its initial placement.
    pub(crate) fn config(self, discs: u32) -> DemConfig {
        let count = f64::from(discs);
        // Beds are placed at random, 40 rows of discs high, packing fraction 0.46: they settle in a time that does not depend on the number.
        let rows = 40.0;
        let bed = [(count / rows).ceil() * 2.6 * RADIUS, rows * 2.6 * RADIUS];
        let gas_side = RADIUS * (std::f64::consts::PI * count / 0.3).sqrt();
        let is_gas = self == Self::Gas;
        DemConfig {
            discs: NonZeroU32::new(discs).expect("not zero"),
            radius_m: if self == Self::Equal {
                DiscRadius::Equal(positive(RADIUS))
            } else {
                DiscRadius::Uniform { min: positive(0.9 * RADIUS), max: positive(1.1 * RADIUS) }
            },
            width_m: positive(if is_gas { gas_side } else { bed[0] }),
            height_m: positive(if is_gas { gas_side } else { bed[1] }),
            gravity_m_per_s2: [0.0, if is_gas { 0.0 } else { -9.81 }]
                .map(|g| Finite::new(g).expect("finite")),
            // Spheres that fall through the bed overlap about as much as the discs.
            elasticity: match self {
                Self::Spheres | Self::FrictionalSpheres => Elasticity::Hertz(positive(2e8)),
                _ => Elasticity::Spring(positive(5e4)),
            },
            dissipation: Dissipation::Restitution(
                Fraction::new(if is_gas { 1.0 } else { 0.5 }).expect("a fraction"),
            ),
            friction: NonNegative::literal(match self {
                Self::Frictional | Self::FrictionalSpheres => 0.5,
                _ => 0.0,
            }),
            periodic: if is_gas { PeriodicSides::Both } else { PeriodicSides::None },
            placement: Placement::Random,
            duration_s: positive(1e3),
            on_unstable_time_step: kinetoscope_manifest::model::UnstableTimeStep::Warn,
            ..DemConfig::default()
        }
    }

    /// The model in the state at which timing begins.
    pub(crate) fn model(self, discs: u32) -> Dem {
        let config = self.config(discs);
        let config = if self == Self::Gas { with_speeds(config) } else { config };
        let mut model = Dem::prepare(&config, SEED, false).expect("a start");
        let steps = match self {
            Self::Settled | Self::Frictional | Self::Spheres | Self::FrictionalSpheres => 20_000,
            // Until no disc moves: while a bed settles, its motion is chaotic, and rounding errors grow.
            Self::Equal => 200_000,
            Self::Gas => 2000,
            Self::Collapse => 200,
        };
        model.advance(Target::Count(steps), u64::MAX).expect("no blow-up");
        model
    }
}

/// Prints the header of a table of two speeds and their ratio.
pub(crate) fn print_header(names: [&str; 2]) {
    let [one, other] = names;
    println!("{:<12}{one:>12}{other:>12}{:>8}   range", "M/s", "ratio");
}

/// Prints medians of pairs of speeds, and the median of `ratio` with the smallest and the largest.
pub(crate) fn print_row(
    name: impl std::fmt::Display,
    pairs: &[[f64; 2]],
    ratio: fn(&[f64; 2]) -> f64,
) {
    let sorted = |of: &dyn Fn(&[f64; 2]) -> f64| {
        let mut values: Vec<f64> = pairs.iter().map(of).collect();
        values.sort_by(f64::total_cmp);
        values
    };
    let middle = pairs.len() / 2;
    let ratios = sorted(&ratio);
    println!(
        "{name:<12}{:>12.1}{:>12.1}{:>8.2}   {:.2} to {:.2}",
        sorted(&|pair| pair[0])[middle],
        sorted(&|pair| pair[1])[middle],
        ratios[middle],
        ratios[0],
        ratios[pairs.len() - 1]
    );
}

/// Random velocities of about 0.1 m/s, for a gas.
fn with_speeds(config: DemConfig) -> DemConfig {
    let start = Dem::prepare(&config, SEED, false).expect("a start");
    let mut frame = kinetoscope_recording::frame::Frame::new();
    start.observe(&mut frame);
    let finite = |value: f64| Finite::new(value).expect("finite");
    let rows = frame.state().chunks_exact(Dem::kind().state_columns.len());
    let mut generator = SEED.stream(kinetoscope_physics::random::Stream::Velocities);
    let positions: Vec<[Finite; 2]> = rows.map(|row| [finite(row[0]), finite(row[1])]).collect();
    let velocities =
        positions.iter().map(|_| generator.normal_pair().map(|v| finite(0.1 * v))).collect();
    DemConfig {
        placement: Placement::Given(GivenState {
            positions_m: positions,
            velocities_m_per_s: velocities,
        }),
        ..config
    }
}
