//! State of the gas that all propagators share: container, particles and what is summed over their collisions.

use super::energy_balance::EnergyBalance;
use super::motion::Circle;
use super::particle_groups::Particles;
use super::tallies::WallTallies;
use crate::constants::{BOLTZMANN_CODATA_1986_J_PER_K, BOLTZMANN_SI_2019_J_PER_K};
use crate::simd::registers::MAX_WIDTH;
use kinetoscope_manifest::model::{BoltzmannConstant, GasConfig, TemperatureDefinition};
use serde::{Deserialize, Serialize};

/// Container, particles and tallies. Positions are relative to the center, so that a distant center costs no digits.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct GasState {
    pub(super) container: Container,
    pub(super) substance: Substance,
    /// Particles at the current time.
    pub(super) particles: Particles,
    pub(super) wall: WallTallies,
    pub(super) energy_balance: EnergyBalance,
    /// Numbers in the widest register that may be used; results have the same bits at every width.
    #[serde(skip, default = "max_width")]
    pub(super) max_width: usize,
}

pub(super) fn max_width() -> usize {
    MAX_WIDTH
}

/// Circular container.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Container {
    pub(super) center_m: [f64; 2],
    pub(super) circle: Circle,
    /// Half the angle of the opening, centered on the positive x axis, rad.
    pub(super) half_opening_rad: Option<f64>,
}

/// Masses of the particles and the definition of their temperature.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Substance {
    /// Mass of the first particle.
    pub(super) mass_kg: f64,
    /// The masses that the particles have in turn.
    pub(super) masses_kg: Vec<f64>,
    /// Mass of each particle relative to the first one.
    pub(super) mass_ratios: Vec<f64>,
    pub(super) boltzmann_j_per_k: f64,
    pub(super) definition: TemperatureDefinition,
}

impl Container {
    /// The container that the manifest describes.
    pub(super) fn new(config: &GasConfig) -> Self {
        let radius = config.radius_m.get();
        Self {
            center_m: config.center_m.map(|axis| axis.get()),
            circle: Circle { radius, wall_speed: config.wall_speed_m_per_s.get() },
            half_opening_rad: config.orifice_width_m.map(|width| width.get() / radius / 2.0),
        }
    }
}

impl Substance {
    /// The substance that the manifest describes.
    pub(super) fn new(config: &GasConfig) -> Self {
        let mut masses = vec![config.mass_kg.get()];
        masses.extend(config.additional_masses_kg.iter().map(|mass| mass.get()));
        let ratios = masses.iter().map(|mass| mass / masses[0]).cycle();
        Self {
            mass_kg: masses[0],
            mass_ratios: ratios.take(config.particles.get() as usize).collect(),
            masses_kg: masses,
            boltzmann_j_per_k: match config.boltzmann_constant {
                BoltzmannConstant::Codata1986 => BOLTZMANN_CODATA_1986_J_PER_K,
                BoltzmannConstant::Si2019 => BOLTZMANN_SI_2019_J_PER_K,
            },
            definition: config.temperature_definition,
        }
    }
}
