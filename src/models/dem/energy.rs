//! The energy ledger: kinetic + m g y + k delta^2/2 + dissipated - work of the walls = constant.
//!
//! What is left of that constant is the integrator's error, and is reported apart.

use super::contacts::{Contact, Discs};
use crate::sum::CompensatedSum;

/// The mechanical energy of an instant, J.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Energies {
    /// Sum of m v^2 / 2.
    pub(super) kinetic: f64,
    /// Sum of -m g . x, zero at the origin.
    pub(super) gravitational: f64,
    /// Sum of k delta^2 / 2.
    pub(super) elastic: f64,
}

impl Energies {
    /// `velocities` are those at the positions' time, v_n + a_n dt/2: with the integrator's own, which are half a step
    /// behind, the kinetic energy has peaks of several per cent within a contact.
    pub(super) fn of(
        discs: &Discs,
        velocities: &[[f64; 2]],
        gravity: [f64; 2],
        contacts: &[Contact],
        stiffness: f64,
    ) -> Self {
        let mut kinetic = CompensatedSum::default();
        let mut gravitational = CompensatedSum::default();
        let mut elastic = CompensatedSum::default();
        for ((&[x, y], &[vx, vy]), &mass) in
            discs.positions.iter().zip(velocities).zip(&discs.masses)
        {
            kinetic.add(0.5 * mass * (vx * vx + vy * vy));
            gravitational.add(-mass * (gravity[0] * x + gravity[1] * y));
        }
        for contact in contacts {
            elastic.add(0.5 * stiffness * contact.overlap * contact.overlap);
        }
        Self {
            kinetic: kinetic.value(),
            gravitational: gravitational.value(),
            elastic: elastic.value(),
        }
    }

    /// Kinetic + gravitational + elastic.
    pub(super) fn total(&self) -> f64 {
        self.kinetic + self.gravitational + self.elastic
    }
}

/// Power taken by the dashpots, W: sum of (k delta - f) v_n, with f the force in use and v_n the separating speed of the
/// mid-step velocities v_n + a_n dt/2. It equals eta v_n^2 where the force is not clamped, and k delta v_n where it is.
///
/// With the mid-step velocity the work of all forces is the change of the kinetic energy, exactly: m (v' - v) . (v' + v)/2.
pub(super) fn dissipated_power(
    contacts: &[Contact],
    accelerations: &[[f64; 2]],
    stiffness: f64,
    time_step: f64,
) -> f64 {
    let mut power = 0.0;
    for contact in contacts {
        let mut acceleration = accelerations[contact.disc as usize];
        if let Some(partner) = contact.partner {
            let other = accelerations[partner as usize];
            acceleration = [acceleration[0] - other[0], acceleration[1] - other[1]];
        }
        let separating = acceleration[0] * contact.normal[0] + acceleration[1] * contact.normal[1];
        let mid_step_speed = contact.separating_speed + 0.5 * time_step * separating;
        power += (stiffness * contact.overlap - contact.force) * mid_step_speed;
    }
    power
}
