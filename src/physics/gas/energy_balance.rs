//! Energy balance of the particles inside the container: energy at the start, heat, work and escaped energy.

use crate::sum::CompensatedSum;
use serde::{Deserialize, Serialize};

/// Energies per first mass, m^2/s^2. The work of a moving wall follows from its speed and the wall impulse.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct EnergyBalance {
    /// Kinetic energy of all particles at the start.
    pub(super) at_start: f64,
    /// Added by changes of the set temperature.
    pub(super) rescaling: CompensatedSum,
    /// Added by the thermal wall.
    pub(super) heat: CompensatedSum,
    /// Energy of the particles that left through the opening.
    pub(super) escaped_energy: CompensatedSum,
    /// Number of particles that left through the opening.
    pub(super) escaped: u64,
}

impl EnergyBalance {
    /// Whether all sums are numbers.
    pub(super) fn is_finite(&self) -> bool {
        let sums = [&self.rescaling, &self.heat, &self.escaped_energy];
        self.at_start.is_finite() && sums.iter().all(|sum| sum.is_finite())
    }
}
