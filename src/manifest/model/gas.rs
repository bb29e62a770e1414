//! `[model.gas]`: point particles in a circular container.

use super::Placement;
use crate::quantity::{Finite, NonNegative, Positive};
use std::num::NonZeroU32;

/// All physics of a gas run.
#[derive(Clone, Debug, PartialEq)]
pub struct GasConfig {
    /// Number of particles N.
    pub particles: NonZeroU32,
    /// Mass m of a particle, kg.
    pub mass_kg: Positive,
    /// Radius r of the container, m.
    pub radius_m: Positive,
    /// Centre c of the container, m.
    pub centre_m: [Finite; 2],
    /// The law that speeds are drawn from.
    pub speed_distribution: SpeedDistribution,
    /// The scale of the speeds.
    pub speed_scale: SpeedScale,
    /// Which mean the temperature is defined by.
    pub temperature_definition: TemperatureDefinition,
    /// Boltzmann's constant in use.
    pub boltzmann_constant: BoltzmannConstant,
    /// How particles are moved.
    pub propagation: Propagation,
    /// How particles are placed at the start; never [`Placement::Lattice`].
    pub placement: Placement,
    /// Simulated time, s.
    pub duration_s: Positive,
}

/// The law of the speeds at the start; directions are uniform.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SpeedDistribution {
    /// Uniform in `[0, v_max)`, as the source document asks.
    Uniform,
    /// Maxwell's in two dimensions.
    Maxwell,
    /// All equal.
    Equal,
}

/// What fixes the scale of the speeds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SpeedScale {
    /// The start is rescaled to exactly this temperature, K.
    Temperature(NonNegative),
    /// Upper bound of uniform speeds, m/s; nothing is rescaled. For `equal` the speed itself; not for `maxwell`.
    MaxSpeed(NonNegative),
    /// The start is written out with its velocities; nothing is rescaled.
    Given,
}

/// Which mean of the speeds the temperature is defined by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TemperatureDefinition {
    /// N k_B T = N m <v>^2 / 2: the source document's equation (13).
    MeanSpeed,
    /// N k_B T = N m <v^2> / 2: equipartition in two dimensions.
    MeanSquare,
}

/// Boltzmann's constant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BoltzmannConstant {
    /// 1.380658e-23 J/K (CODATA 1986), the source document's.
    Codata1986,
    /// 1.380649e-23 J/K, exact in the SI since 2019.
    Si2019,
}

/// How particles are moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Propagation {
    /// Closed form: exact at any time.
    Exact,
    /// The source document's steps with its defects mended.
    Stepped {
        /// Time step, s.
        time_step_s: Positive,
    },
    /// The source document's steps as printed, losses included.
    Literal {
        /// Time step, s.
        time_step_s: Positive,
    },
}

impl Default for GasConfig {
    /// A thousand of the document's particles at 300 K by its own definition of temperature.
    fn default() -> Self {
        Self {
            particles: const { NonZeroU32::new(1000).expect("not zero") },
            mass_kg: const { Positive::literal(1e-26) },
            radius_m: const { Positive::literal(1.0) },
            centre_m: const { [Finite::literal(0.0), Finite::literal(0.0)] },
            speed_distribution: SpeedDistribution::Uniform,
            speed_scale: SpeedScale::Temperature(const { NonNegative::literal(300.0) }),
            temperature_definition: TemperatureDefinition::MeanSpeed,
            boltzmann_constant: BoltzmannConstant::Codata1986,
            propagation: Propagation::Exact,
            placement: Placement::Random,
            duration_s: const { Positive::literal(0.1) },
        }
    }
}
