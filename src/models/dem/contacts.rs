//! Who touches whom, and with what force: a pure function of positions and velocities.

use super::motion;
use super::neighbours::Neighbours;
use super::restitution;
use serde::{Deserialize, Serialize};

/// The discs, column by column, in the order of their ids.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Discs {
    /// Centres, m.
    pub(super) positions: Vec<[f64; 2]>,
    /// The integrator's velocities, half a step behind the positions, m/s.
    pub(super) velocities: Vec<[f64; 2]>,
    /// Radii, m.
    pub(super) radii: Vec<f64>,
    /// Masses, kg.
    pub(super) masses: Vec<f64>,
}

/// How the damping of a contact is found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) enum Dashpot {
    /// From the damping ratio zeta, for each pair by its effective mass: one restitution for all.
    Ratio(f64),
    /// One damping eta for all, N s/m.
    Damping(f64),
}

/// The force law of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct ContactLaw {
    /// Stiffness k, N/m.
    pub(super) stiffness: f64,
    /// The dashpot.
    pub(super) dashpot: Dashpot,
    /// Whether the force is clamped at zero where it would pull.
    pub(super) only_pushes: bool,
    /// Whether the dashpot takes the velocities at the step's end.
    pub(super) is_implicit: bool,
}

/// Two discs, or a disc and a wall, that overlap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Contact {
    /// The disc that the normal points to.
    pub(super) disc: u32,
    /// The other disc; `None` is a wall.
    pub(super) partner: Option<u32>,
    /// Unit vector from the partner to the disc.
    pub(super) normal: [f64; 2],
    /// Overlap delta, m.
    pub(super) overlap: f64,
    /// Overlap over the smaller radius of the two.
    pub(super) overlap_over_radius: f64,
    /// Speed v_n at which the two move apart, by the integrator's velocities, m/s.
    pub(super) separating_speed: f64,
    /// Normal force f, positive where it pushes, N.
    pub(super) force: f64,
}

impl ContactLaw {
    /// Damping eta of a contact, N s/m.
    pub(super) fn damping(&self, effective_mass: f64) -> f64 {
        match self.dashpot {
            Dashpot::Ratio(ratio) => restitution::damping(ratio, self.stiffness, effective_mass),
            Dashpot::Damping(damping) => damping,
        }
    }

    /// Damping ratio zeta = eta / (2 sqrt(k m_eff)) of a contact.
    pub(super) fn damping_ratio(&self, effective_mass: f64) -> f64 {
        match self.dashpot {
            Dashpot::Ratio(ratio) => ratio,
            Dashpot::Damping(damping) => damping / (2.0 * (self.stiffness * effective_mass).sqrt()),
        }
    }

    /// The force in use with an explicit dashpot, N: equation (1), clamped or not.
    fn force(&self, overlap: f64, separating_speed: f64, effective_mass: f64) -> f64 {
        let damping = self.damping(effective_mass);
        let force = motion::contact_force(self.stiffness, damping, overlap, separating_speed);
        self.clamped(force)
    }

    /// The force without its attractive tail, where it has none.
    pub(super) fn clamped(&self, force: f64) -> f64 {
        if self.only_pushes && force < 0.0 { 0.0 } else { force }
    }
}

/// Finds all contacts with their explicit forces: pairs in the order of their ids, then each disc's walls (left, right, floor, ceiling).
pub(super) fn find(
    discs: &Discs,
    sides: [f64; 2],
    law: &ContactLaw,
    neighbours: &Neighbours,
    contacts: &mut Vec<Contact>,
) {
    contacts.clear();
    for disc in 0..discs.positions.len() {
        for &partner in neighbours.above(disc) {
            contacts.extend(pair_contact(discs, law, disc, partner as usize));
        }
    }
    for disc in 0..discs.positions.len() {
        wall_contacts(discs, sides, law, disc, contacts);
    }
}

fn pair_contact(discs: &Discs, law: &ContactLaw, disc: usize, partner: usize) -> Option<Contact> {
    let [x, y] = discs.positions[disc];
    let [other_x, other_y] = discs.positions[partner];
    let apart = [x - other_x, y - other_y];
    let reach = discs.radii[disc] + discs.radii[partner];
    let distance_squared = apart[0] * apart[0] + apart[1] * apart[1];
    if distance_squared >= reach * reach {
        return None;
    }
    let distance = distance_squared.sqrt();
    // Centres on one point have no normal; any will do, for such an overlap ends the run.
    let normal =
        if distance > 0.0 { [apart[0] / distance, apart[1] / distance] } else { [0.0, 1.0] };
    let [vx, vy] = discs.velocities[disc];
    let [other_vx, other_vy] = discs.velocities[partner];
    let separating_speed = (vx - other_vx) * normal[0] + (vy - other_vy) * normal[1];
    let overlap = reach - distance;
    let effective_mass = motion::effective_mass(discs.masses[disc], discs.masses[partner]);
    let (radius, other_radius) = (discs.radii[disc], discs.radii[partner]);
    Some(Contact {
        disc: disc as u32,
        partner: Some(partner as u32),
        normal,
        overlap,
        overlap_over_radius: overlap / if radius < other_radius { radius } else { other_radius },
        separating_speed,
        force: law.force(overlap, separating_speed, effective_mass),
    })
}

fn wall_contacts(
    discs: &Discs,
    sides: [f64; 2],
    law: &ContactLaw,
    disc: usize,
    contacts: &mut Vec<Contact>,
) {
    let [x, y] = discs.positions[disc];
    let radius = discs.radii[disc];
    let walls = [
        (x, [1.0, 0.0]),
        (sides[0] - x, [-1.0, 0.0]),
        (y, [0.0, 1.0]),
        (sides[1] - y, [0.0, -1.0]),
    ];
    for (distance, normal) in walls {
        if distance >= radius {
            continue;
        }
        let [vx, vy] = discs.velocities[disc];
        let separating_speed = vx * normal[0] + vy * normal[1];
        let overlap = radius - distance;
        contacts.push(Contact {
            disc: disc as u32,
            partner: None,
            normal,
            overlap,
            overlap_over_radius: overlap / radius,
            separating_speed,
            force: law.force(overlap, separating_speed, discs.masses[disc]),
        });
    }
}

/// Accelerations of all discs, m/s^2, contact forces added up in the order of the contacts.
pub(super) fn accelerations(
    discs: &Discs,
    gravity: [f64; 2],
    contacts: &[Contact],
    accelerations: &mut Vec<[f64; 2]>,
) {
    accelerations.clear();
    accelerations.resize(discs.positions.len(), [0.0, 0.0]);
    for contact in contacts {
        let force = [contact.force * contact.normal[0], contact.force * contact.normal[1]];
        let on_disc = &mut accelerations[contact.disc as usize];
        *on_disc = [on_disc[0] + force[0], on_disc[1] + force[1]];
        if let Some(partner) = contact.partner {
            let on_partner = &mut accelerations[partner as usize];
            *on_partner = [on_partner[0] - force[0], on_partner[1] - force[1]];
        }
    }
    // So far these are forces.
    for (value, &mass) in accelerations.iter_mut().zip(&discs.masses) {
        *value = motion::acceleration(gravity, *value, mass);
    }
}
