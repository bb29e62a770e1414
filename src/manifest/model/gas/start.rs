//! `[model.gas]`: positions and speeds at the start, and the temperature that they define.

use crate::model::start::{GivenState, starts};
use crate::quantity::NonNegative;
use crate::table::choice;
use crate::value::words;

words! {
    /// The distribution of the positions at the start.
    pub enum PositionDistribution {
        /// Uniform over the area: stationary.
        UniformInArea = "uniform-in-area",
        /// Distance from the center uniform in [0, r]: too many in the middle, and not stationary.
        UniformInRadius = "uniform-in-radius",
        /// Equilibrium in gravity: density proportional to exp(-m g y / (k_B T)).
        Barometric = "barometric",
    }
}

words! {
    /// The distribution of the speeds at the start; directions are uniform.
    pub enum SpeedDistribution {
        /// Uniform in `[0, v_max)`, as the gas exercise asks.
        Uniform = "uniform",
        /// Maxwell's in two dimensions.
        Maxwell = "maxwell",
        /// All equal.
        Equal = "equal",
    }
}

choice! {
    /// What fixes the scale of the speeds.
    pub enum SpeedScale {
        /// All velocities are rescaled at the start to exactly this temperature.
        temperature_k: Temperature(NonNegative) ["K"],
        /// Upper bound of uniform speeds, or the speed itself for equal ones, in place of `temperature_k`; nothing is
        /// rescaled.
        max_speed_m_per_s: MaxSpeed(NonNegative) ["m/s"],
        |
        /// The start is written out with its velocities, or its speeds are; nothing is rescaled.
        Given,
    }
}

words! {
    /// The mean of the speeds that defines the temperature.
    #[derive(serde::Serialize, serde::Deserialize)]
    pub enum TemperatureDefinition {
        /// `N k_B T = N m <v>^2 / 2`: the gas exercise's equation (13).
        MeanSpeed = "mean-speed",
        /// `N k_B T = N m <v^2> / 2`: equipartition in two dimensions.
        MeanSquare = "mean-square",
    }
}

words! {
    /// Boltzmann's constant.
    pub enum BoltzmannConstant {
        /// 1.380658e-23 J/K (CODATA 1986), the gas exercise's.
        Codata1986 = "codata-1986",
        /// 1.380649e-23 J/K, exact in the SI since 2019.
        Si2019 = "si-2019",
    }
}

starts! {
    /// How particles are placed at the start: points need no lattice.
    pub enum GasPlacement {
        /// Uniformly at random.
        Random = "random",
        | GivenState with positions_m
    }
}
