//! Dashpots at the velocities of the step's end, f = f_e - eta v_n': stable at any damping.
//!
//! For a single contact this is v' = (v + f_e dt/m_eff) / (1 + c), c = eta dt/m_eff: it stops where the explicit
//! dashpot would multiply the velocity by c. In a bed, each force changes the velocities of the neighboring contacts. Therefore, the
//! contacts are solved in turn, in their fixed order, each by that formula with the velocities that result from the others,
//! sweep after sweep until the velocities no longer change (projected Gauss–Seidel, which converges for dashpots and for
//! forces clamped at zero; Cottle, Pang and Stone, The Linear Complementarity Problem, 1992, chapter 5).
//!
//! One sweep is not enough: a spring under load would be softened by the factor 1 + c, and a bed would sink into itself.
//! Friction, cohesion and moving walls are not supported.

use crate::dem::block::{BLOCK, Partner};
use crate::dem::discs::Discs;
use crate::dem::materials::ContactLaw;
use crate::dem::motion;
use crate::dem::parameters::{Parameters, StepContext};
use crate::dem::totals::{BlockForces, Contact};
use crate::simd::registers::Register as _;

/// Change of a velocity in a sweep at which the solution is accepted, over the fastest contact's and the change by gravity.
const TOLERANCE: f64 = 1e-6;
/// Sweeps after which the solution is accepted anyway: every sweep improves it. A bed runs some tens of times slower than with
/// explicit dashpots.
const MAX_SWEEPS: u32 = 50;

/// Replaces the contacts' explicit forces by those with implicit dashpots.
pub(crate) fn solve(discs: &Discs, parameters: &Parameters, contacts: &mut [Contact]) {
    let Parameters { gravity, ref law, time_step, .. } = *parameters;
    contacts.iter_mut().for_each(set_normal);
    let mut end = Velocities { values: discs.velocities.clone(), discs, time_step };
    let begin: Vec<f64> = contacts.iter().map(|contact| end.separating(contact)).collect();
    // The velocities at the step's end as far as they are known: after gravity and the springs, later after the dashpots too.
    // Therefore, a bed at rest is solved at once.
    for v in &mut end.values {
        *v = [v[0] + gravity[0] * time_step, v[1] + gravity[1] * time_step];
    }
    let mut fastest = (gravity[0].abs() + gravity[1].abs()) * time_step;
    for contact in contacts.iter_mut() {
        contact.normal_force = elastic_force(contact, discs, law);
        end.apply(contact, contact.normal_force);
    }
    for (contact, separating_speed) in contacts.iter().zip(begin) {
        let speed = end.separating(contact).abs() + separating_speed.abs();
        fastest = speed.larger(fastest);
    }
    for _ in 0..MAX_SWEEPS {
        let mut largest_change = 0.0;
        for contact in contacts.iter_mut() {
            let disc = contact.disc as usize;
            let effective_mass = discs.effective_mass(disc, contact.partner);
            let of_pair = law.damping(discs, disc, contact.partner);
            let radius = discs.reduced_radius(disc, contact.partner);
            let circle = motion::circle_of_contact(radius, contact.overlap);
            let damping = law.normal.damping(of_pair, [contact.overlap, circle]);
            // The speed that the contact would have without its own force.
            let free = end.separating(contact) - contact.normal_force * time_step / effective_mass;
            let elastic = elastic_force(contact, discs, law);
            let damping_step = damping * time_step / effective_mass;
            let force = motion::implicit_normal_force(
                elastic,
                damping,
                free,
                damping_step,
                law.least_force(),
            );
            let change = force - contact.normal_force;
            end.apply(contact, change);
            contact.normal_force = force;
            largest_change = (change.abs() * time_step / effective_mass).larger(largest_change);
        }
        if largest_change <= TOLERANCE * fastest {
            break;
        }
    }
    for contact in contacts {
        contact.force = contact.normal.map(|part| contact.normal_force * part);
    }
}

fn elastic_force(contact: &Contact, discs: &Discs, law: &ContactLaw) -> f64 {
    law.force_and_energy(discs, (contact.disc, contact.partner), contact.overlap)[0]
}

/// Sets the normal of two discs by division. Two centers on one point have no normal; any will do, because such an overlap ends the
/// run.
fn set_normal(contact: &mut Contact) {
    if let Partner::Disc(_) = contact.partner {
        let distance = motion::distance_squared(contact.separation).sqrt();
        let unit = contact.separation.map(|part| part / distance);
        contact.normal = if distance > 0.0 { unit } else { [0.0, 1.0] };
    }
}

/// The forces of solved contacts on the discs, block by block, with their dissipative parts.
pub(crate) fn forces_of(
    contacts: &[Contact],
    discs: &Discs,
    step: &StepContext<'_>,
) -> Vec<BlockForces> {
    let blocks = 0..discs.len().div_ceil(BLOCK);
    let mut blocks: Vec<BlockForces> = blocks
        .map(|number| {
            let mut block = BlockForces::default();
            block.forces.clear_to(Ord::min(BLOCK, discs.len() - number * BLOCK));
            block.sums.clear(step, number * BLOCK);
            block
        })
        .collect();
    for contact in contacts {
        let elastic = elastic_force(contact, discs, &step.parameters.law);
        let loss = elastic - contact.normal_force;
        let ([fx, fy], [nx, ny]) = (contact.force, contact.normal);
        let on_disc = [fx, fy, loss * nx, loss * ny];
        let mut add = |disc: u32, sign: f64| {
            let block = &mut blocks[disc as usize / BLOCK];
            let sum = &mut block.forces[disc as usize % BLOCK];
            for (sum, part) in sum.iter_mut().zip(on_disc) {
                *sum += sign * part;
            }
            let ends = (contact.disc, contact.partner);
            block.sums.max_overlap.note_ratio(contact.overlap_over_radius, ends);
        };
        add(contact.disc, 1.0);
        match contact.partner {
            Partner::Disc(partner) => add(partner, -1.0),
            Partner::Wall(wall) => {
                let by_wall = &mut blocks[contact.disc as usize / BLOCK].sums.walls[wall as usize];
                // These walls are at rest.
                *by_wall = [by_wall[0] + fx, by_wall[1] + fy, 0.0];
            }
        }
    }
    blocks
}

/// Velocities that forces act on for one step.
struct Velocities<'a> {
    values: Vec<[f64; 2]>,
    discs: &'a Discs,
    time_step: f64,
}

impl Velocities<'_> {
    /// Relative velocity along the normal, positive if the two move apart, m/s.
    fn separating(&self, contact: &Contact) -> f64 {
        let mut v = self.values[contact.disc as usize];
        if let Partner::Disc(partner) = contact.partner {
            let other = self.values[partner as usize];
            v = [v[0] - other[0], v[1] - other[1]];
        }
        v[0] * contact.normal[0] + v[1] * contact.normal[1]
    }

    /// Applies a normal force to both sides of a contact for the whole step.
    fn apply(&mut self, contact: &Contact, force: f64) {
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
