//! Dashpots that take the velocities at the step's end, f = k delta - eta v_n': stable at any damping.
//!
//! For one contact alone this is v' = (v + k delta dt/m_eff) / (1 + c), c = eta dt/m_eff: it stops where the explicit
//! dashpot would multiply the velocity by c. In a bed each force changes the velocities of its neighbors' contacts. So the
//! contacts are solved in turn, in their fixed order, each by that formula with the velocities as the others have left
//! them, sweep after sweep until nothing moves any more (projected Gauss–Seidel, which converges for dashpots and for
//! forces clamped at zero; Cottle, Pang and Stone, The Linear Complementarity Problem, 1992, chapter 5).
//!
//! One sweep is not enough: a spring under load would be softened by the factor 1 + c, and a bed would sink into itself.

use crate::dem::discs::Discs;
use crate::dem::forces::contact::{Contact, Partner};
use crate::dem::forces::{Forces, Scene};
use crate::dem::motion;
use crate::dem::neighbors::BLOCK;
use crate::dem::parameters::Parameters;

/// Change of a velocity in a sweep at which the solution is found, over the fastest contact's and what gravity adds to it.
const TOLERANCE: f64 = 1e-6;
/// Sweeps after which the solution is taken as it is: every sweep brings it nearer. They make a bed some tens of times
/// slower than with explicit dashpots.
const MOST_SWEEPS: u32 = 50;

/// Replaces the contacts' forces by those with implicit dashpots.
pub(in crate::dem) fn solve_dashpots(
    discs: &Discs,
    parameters: &Parameters,
    contacts: &mut [Contact],
) {
    let Parameters { gravity, ref law, time_step, .. } = *parameters;
    // The velocities at the step's end, as far as they are known: by gravity and the springs, then by the dashpots too.
    // So a bed at rest is solved at once.
    let values = (0..discs.len()).map(|disc| discs.velocities[disc]).collect();
    let mut end = Velocities { values, discs, time_step };
    for v in &mut end.values {
        *v = [v[0] + gravity[0] * time_step, v[1] + gravity[1] * time_step];
    }
    let mut fastest = (gravity[0].abs() + gravity[1].abs()) * time_step;
    for contact in contacts.iter_mut() {
        contact.force = law.stiffness * contact.overlap;
        end.push(contact, contact.force);
    }
    for contact in contacts.iter() {
        let speed = end.separating(contact).abs() + contact.separating_speed.abs();
        fastest = if speed > fastest { speed } else { fastest };
    }
    for _ in 0..MOST_SWEEPS {
        let mut largest_change = 0.0;
        for contact in contacts.iter_mut() {
            let effective_mass = end.effective_mass(contact);
            let disc = contact.disc as usize;
            let damping = match contact.partner {
                Partner::Disc(other) => law.damping(discs, disc, other as usize),
                Partner::Wall(_) => law.wall_damping(discs, disc),
            };
            // What the contact would find without its own force.
            let free = end.separating(contact) - contact.force * time_step / effective_mass;
            let explicit = motion::contact_force(law.stiffness, damping, contact.overlap, free);
            let force = law.clamped(explicit / (1.0 + damping * time_step / effective_mass));
            let change = force - contact.force;
            end.push(contact, change);
            contact.force = force;
            let moved = change.abs() * time_step / effective_mass;
            largest_change = if moved > largest_change { moved } else { largest_change };
        }
        if largest_change <= TOLERANCE * fastest {
            break;
        }
    }
}

/// The forces of solved contacts on the discs, block by block, with their dissipative parts as `forces` has them.
pub(in crate::dem) fn forces_of(
    contacts: &[Contact],
    discs: &Discs,
    scene: &Scene<'_>,
    blocks: &mut [Forces],
) {
    for (number, block) in blocks.iter_mut().enumerate() {
        let count = Ord::min(BLOCK, discs.len() - number * BLOCK);
        block.forces.clear_to(count);
        block.sums.clear(scene, number * BLOCK);
    }
    for contact in contacts {
        let loss = scene.law.stiffness * contact.overlap - contact.force;
        let [nx, ny] = contact.normal;
        let on_disc = [contact.force * nx, contact.force * ny, loss * nx, loss * ny];
        let mut add = |disc: u32, sign: f64| {
            let block = &mut blocks[disc as usize / BLOCK];
            let sum = &mut block.forces[disc as usize % BLOCK];
            for (sum, part) in sum.iter_mut().zip(on_disc) {
                *sum += sign * part;
            }
            let deepest = &mut block.sums.deepest;
            if contact.overlap_over_radius > deepest.over_radius {
                deepest.over_radius = contact.overlap_over_radius;
                deepest.ends = Some((contact.disc, contact.partner));
            }
        };
        add(contact.disc, 1.0);
        match contact.partner {
            Partner::Disc(partner) => add(partner, -1.0),
            Partner::Wall(wall) => {
                let by_wall = &mut blocks[contact.disc as usize / BLOCK].sums.walls[wall as usize];
                // These walls are at rest.
                *by_wall = [by_wall[0] + on_disc[0], by_wall[1] + on_disc[1], 0.0];
            }
        }
    }
}

/// Velocities that forces act on for one step.
struct Velocities<'a> {
    values: Vec<[f64; 2]>,
    discs: &'a Discs,
    time_step: f64,
}

impl Velocities<'_> {
    fn effective_mass(&self, contact: &Contact) -> f64 {
        let mass = self.discs.masses[contact.disc as usize];
        match contact.partner {
            Partner::Disc(other) => motion::effective_mass(mass, self.discs.masses[other as usize]),
            Partner::Wall(_) => mass,
        }
    }

    /// Speed at which the two of a contact move apart.
    fn separating(&self, contact: &Contact) -> f64 {
        let mut v = self.values[contact.disc as usize];
        if let Partner::Disc(partner) = contact.partner {
            let other = self.values[partner as usize];
            v = [v[0] - other[0], v[1] - other[1]];
        }
        v[0] * contact.normal[0] + v[1] * contact.normal[1]
    }

    /// Lets a normal force act on both sides of a contact for the whole step.
    fn push(&mut self, contact: &Contact, force: f64) {
        let impulse = force * self.time_step;
        let mut change = |disc: usize, impulse: f64| {
            let speed = impulse / self.discs.masses[disc];
            let v = &mut self.values[disc];
            *v = [v[0] + speed * contact.normal[0], v[1] + speed * contact.normal[1]];
        };
        change(contact.disc as usize, impulse);
        if let Partner::Disc(partner) = contact.partner {
            change(partner as usize, -impulse);
        }
    }
}
