//! How the equation of motion is discretised.
//!
//! Semi-implicit Euler is the source document's equation (3):
//!
//! v' = v + a dt, x' = x + v' dt, with a from x and v at the step's start alone.
//!
//! So v stands half a step behind x. The velocity at the positions' time is the mid-step one, v + a dt/2.
//!
//! Velocity Verlet with the dashpot evaluated at the half-step velocity (half kick, drift, half kick) is the same map: two
//! half kicks in a row by the same acceleration are one kick. Only its start differs: there the half-step velocity is
//! v - a dt/2 of the given one, where Euler takes the given one itself.
//!
//! The implicit dashpot changes the forces, not the step: see `implicit`.

use super::contacts::{self, Contact, Discs};
use super::energy;
use super::implicit;
use super::neighbours::Neighbours;
use super::parameters::Parameters;

/// Forces and accelerations at the present positions and velocities. It follows from the state and is no part of it.
#[derive(Clone, Debug, Default)]
pub(super) struct Evaluation {
    neighbours: Neighbours,
    /// All contacts, in a fixed order.
    pub(super) contacts: Vec<Contact>,
    /// Accelerations, m/s^2.
    pub(super) accelerations: Vec<[f64; 2]>,
}

/// What can't go on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum BlowUp {
    /// Two discs, or a disc and a wall, overlap by more than the smaller radius.
    Overlap(Contact),
    /// A disc's centre is outside the box, or no number.
    Outside(usize),
}

impl Evaluation {
    /// Finds contacts, forces and accelerations anew.
    pub(super) fn update(&mut self, discs: &Discs, parameters: &Parameters) {
        let Parameters { sides, gravity, law, time_step, skin, .. } = parameters;
        self.neighbours.refresh(&discs.positions, &discs.radii, *sides, *skin);
        contacts::find(discs, *sides, law, &self.neighbours, &mut self.contacts);
        if law.is_implicit {
            implicit::solve_dashpots(discs, *gravity, law, *time_step, &mut self.contacts);
        }
        contacts::accelerations(discs, *gravity, &self.contacts, &mut self.accelerations);
    }

    /// Velocities at the positions' time, v + a dt/2.
    pub(super) fn velocities_at_positions(&self, discs: &Discs, time_step: f64) -> Vec<[f64; 2]> {
        let half = 0.5 * time_step;
        discs
            .velocities
            .iter()
            .zip(&self.accelerations)
            .map(|(v, a)| [v[0] + a[0] * half, v[1] + a[1] * half])
            .collect()
    }

    /// Power taken by the dashpots now, W.
    pub(super) fn dissipated_power(&self, parameters: &Parameters) -> f64 {
        let Parameters { law, time_step, .. } = parameters;
        energy::dissipated_power(&self.contacts, &self.accelerations, law.stiffness, *time_step)
    }

    /// Largest overlap over the smaller radius of a contact, 0 without contacts.
    pub(super) fn largest_overlap(&self) -> f64 {
        self.contacts.iter().fold(0.0, |largest, contact| {
            let overlap = contact.overlap_over_radius;
            if overlap > largest { overlap } else { largest }
        })
    }

    /// The first contact that overlaps by more than the smaller radius.
    pub(super) fn blow_up(&self) -> Result<(), BlowUp> {
        let is_too_deep = |contact: &&Contact| contact.overlap_over_radius > 1.0;
        match self.contacts.iter().find(is_too_deep) {
            Some(contact) => Err(BlowUp::Overlap(*contact)),
            None => Ok(()),
        }
    }
}

/// Equation (3), kick and drift: v' = v + a dt, x' = x + v' dt.
///
/// # Errors
/// Where a disc's centre left the box; all discs have moved then.
pub(super) fn kick_and_drift(
    discs: &mut Discs,
    accelerations: &[[f64; 2]],
    sides: [f64; 2],
    time_step: f64,
) -> Result<(), BlowUp> {
    let mut first_outside = None;
    let moving = discs.positions.iter_mut().zip(&mut discs.velocities).zip(accelerations);
    for (disc, ((x, v), a)) in moving.enumerate() {
        *v = [v[0] + a[0] * time_step, v[1] + a[1] * time_step];
        *x = [x[0] + v[0] * time_step, x[1] + v[1] * time_step];
        // No number is inside nothing.
        let is_inside = x[0] >= 0.0 && x[0] <= sides[0] && x[1] >= 0.0 && x[1] <= sides[1];
        if !is_inside && first_outside.is_none() {
            first_outside = Some(disc);
        }
    }
    match first_outside {
        Some(disc) => Err(BlowUp::Outside(disc)),
        None => Ok(()),
    }
}

/// Turns the velocities of the start, at the positions' time, into those of velocity Verlet's half step before:
/// v - a dt/2. Nothing overlaps at the start, so a is gravity.
pub(super) fn set_back_by_half_a_step(discs: &mut Discs, gravity: [f64; 2], time_step: f64) {
    let half = 0.5 * time_step;
    for v in &mut discs.velocities {
        *v = [v[0] - gravity[0] * half, v[1] - gravity[1] * half];
    }
}
