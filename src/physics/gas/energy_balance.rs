//! Where the energy of the particles inside comes from and goes to.

use super::event_driven::Happened;
use super::{Gas, Propagator};
use crate::model::Model;
use crate::sum::CompensatedSum;
use kinetoscope_recording::channels::{GasLedger, GasSpeeds};
use serde::{Deserialize, Serialize};

/// Energies over the first mass, m^2/s^2.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Ledger {
    pub(super) energy_at_start: f64,
    heat: CompensatedSum,
    escaped_energy: CompensatedSum,
    escaped: u64,
}

impl Ledger {
    /// Books what happened at a wall that does more than mirror.
    pub(super) fn book(&mut self, happened: &Happened) {
        self.heat.add(happened.heat.value());
        self.escaped_energy.add(happened.escaped_energy.value());
        self.escaped += happened.escaped;
    }
}

impl Gas {
    /// Radius of the container now, m.
    pub(super) fn radius_now(&self) -> f64 {
        self.container.circle.radius_at(self.time())
    }

    pub(super) fn ledger(&self, speeds: &GasSpeeds) -> GasLedger {
        let (mass, circle) = (self.substance.mass_kg, self.container.circle);
        let moments = self.moments();
        let energy = moments.reduced_mean_square * moments.count / 2.0;
        let Ledger { energy_at_start, heat, escaped_energy, escaped } = self.ledger;
        let (heat, left, rescaling) =
            (heat.value(), escaped_energy.value(), self.schedule.energy.value());
        // Force on the gas times way of the wall: adding zero makes the work of a wall at rest +0.
        let work = -circle.wall_speed * self.wall.total.impulse_per_mass.value() + 0.0;
        let residual = energy - (energy_at_start + work + heat + rescaling - left);
        let radius_m = self.radius_now();
        let growth = radius_m / circle.radius;
        let over_start =
            |value: f64| if energy_at_start > 0.0 { value / energy_at_start } else { 0.0 };
        GasLedger {
            wall_work_j: mass * work,
            wall_heat_j: mass * heat,
            rescaling_j: mass * rescaling,
            escaped_j: mass * left,
            residual_relative: over_start(residual),
            radius_m,
            particles_escaped: escaped,
            energy_times_area_over_initial: over_start(energy * growth * growth),
            excess_h: excess_h(speeds),
        }
    }

    /// Half the angle of the opening about the direction of x, rad.
    pub(super) fn half_opening(&self) -> Option<f64> {
        match &self.propagator {
            Propagator::HitByHit { law, .. } => law.half_opening,
            _ => None,
        }
    }

    /// Whether particles may be beyond the wall because they left through its opening.
    pub(super) fn has_opening(&self) -> bool {
        self.half_opening().is_some()
    }
}

/// Sum over the bins of p ln(p/q) - p + q, p measured and q Maxwell's: the relative entropy of the speeds, never below zero, also where
/// some speeds are beyond the bins. With the directions uniform in both it is H less its least value at this energy.
fn excess_h(speeds: &GasSpeeds) -> f64 {
    let [first, second, ..] = speeds.speed_m_per_s[..] else { return 0.0 };
    let width = second - first;
    let mut sum = CompensatedSum::default();
    for (density, maxwell) in speeds.density.iter().zip(&speeds.maxwell) {
        sum.add(width * (maxwell - density));
        if *density > 0.0 && *maxwell > 0.0 {
            sum.add(width * density * libm::log(density / maxwell));
        }
    }
    sum.value()
}
