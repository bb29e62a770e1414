//! Forces of the pairs of two blocks, each on the disc of its own block.
//!
//! They depend on discs of other blocks; therefore, all blocks find them before any disc moves.

use super::contact_law::{ContactKinematics, LawRegisters, Surfaces, Torque};
use crate::dem::block::{Block, Partner};
use crate::dem::discs::Discs;
use crate::dem::laws::{NormalLaw, with_law};
use crate::dem::motion::{self, NormalForce};
use crate::dem::neighbors::near_pairs::{self, Validity};
use crate::dem::neighbors::tiers::Scope;
use crate::dem::parameters::StepContext;
use crate::dem::totals::{Contact, ContactSums};
use crate::simd::registers::Scalar;

/// Forces of a block's inter-block pairs on its own discs.
#[derive(Clone, Debug, Default)]
pub(crate) struct InterBlockForces {
    /// The disc, counted from the block's first disc, with Fx, Fy, Dx, Dy, N.
    pub(super) forces: Vec<(u32, [f64; 4])>,
    /// Torque of each; empty without friction.
    pub(super) torques: Vec<Torque>,
    pub(super) sums: ContactSums,
    /// The contacts, each in the block of its lower index, if they are recorded.
    pub(super) contacts: Vec<Contact>,
    /// Numbers of the near pairs; see `near_pairs`.
    near: Vec<u32>,
    validity: Validity,
}

/// The discs, the constants of the step, and the law with them.
struct InterBlockContext<'a, L: NormalLaw> {
    discs: &'a Discs,
    step: &'a StepContext<'a>,
    law: LawRegisters<f64, L>,
    has_rolling_friction: bool,
    /// Whether single contacts are recorded.
    is_recorded: bool,
}

/// Vector from the second disc of an inter-block pair to the first, m.
#[inline(always)]
fn separation(block: &Block, pair: usize, discs: &Discs) -> [f64; 2] {
    let [[x, y], [other_x, other_y]] =
        block.inter_block_ends(pair).map(|disc| discs.positions[disc]);
    let [shift_x, shift_y] = block.shifts[pair];
    [x - (other_x + shift_x), y - (other_y + shift_y)]
}

impl InterBlockForces {
    /// Finds the forces of a block's inter-block pairs; their springs advance by a step.
    pub(crate) fn find(
        &mut self,
        block: &mut Block,
        discs: &Discs,
        step: &StepContext<'_>,
        is_recorded: bool,
    ) {
        self.forces.clear();
        self.torques.clear();
        self.contacts.clear();
        self.sums.clear(step, block.start);
        with_law!(step.parameters.law.normal, law => {
            let law = LawRegisters::new(Scalar, step, law);
            let has_rolling_friction = step.parameters.law.has_rolling_friction();
            let context = InterBlockContext { discs, step, law, has_rolling_friction, is_recorded };
            self.find_in_scope(block, &context);
        });
    }

    /// Finds the forces of the pairs in scope.
    fn find_in_scope<L: NormalLaw>(
        &mut self,
        block: &mut Block,
        context: &InterBlockContext<'_, L>,
    ) {
        let InterBlockContext { discs, step, .. } = *context;
        let in_scope = 0..block.inter_block.in_tiers(step.scope.tiers);
        if step.parameters.law.has_friction() {
            in_scope.for_each(|pair| self.add::<_, true>(pair, block, context));
        } else if step.parameters.max_width > 1 {
            if !self.validity.holds_for(&step.scope) {
                self.validity = Validity::until_horizon(&step.scope);
                self.list_near(block, discs, &step.scope);
            }
            let near = std::mem::take(&mut self.near);
            near.iter().for_each(|&pair| self.add::<_, false>(pair as usize, block, context));
            self.near = near;
        } else {
            // All pairs are compared, which checks the near pairs.
            in_scope.for_each(|pair| self.add::<_, false>(pair, block, context));
        }
    }

    /// Lists the pairs that may come into contact before the horizon.
    fn list_near(&mut self, block: &Block, discs: &Discs, scope: &Scope) {
        let (horizon, margin) = near_pairs::horizon(scope);
        let in_scope = 0..block.inter_block.in_tiers(scope.tiers_within(horizon));
        let is_near = |&pair: &usize| {
            let distance_squared = motion::distance_squared(separation(block, pair, discs));
            motion::is_closer(distance_squared, block.inter_block.reach[pair] + margin)
        };
        self.near.clear();
        self.near.extend(in_scope.filter(is_near).map(|pair| pair as u32));
    }

    /// Adds the force of a pair in contact, or of one that has just parted.
    #[inline(always)]
    fn add<L: NormalLaw, const FRICTION: bool>(
        &mut self,
        pair: usize,
        block: &mut Block,
        context: &InterBlockContext<'_, L>,
    ) {
        let InterBlockContext { discs, step, law, .. } = context;
        let (ends, reach) = (block.inter_block_ends(pair), block.inter_block.reach[pair]);
        let separation = separation(block, pair, discs);
        let distance_squared = motion::distance_squared(separation);
        let [[vx, vy], [other_vx, other_vy]] = ends.map(|disc| discs.velocities[disc]);
        let velocity = [vx - other_vx, vy - other_vy];
        let part = law.attracted_part(separation, velocity, reach);
        let is_apart = !motion::is_closer(distance_squared, reach);
        let is_held = FRICTION && (part != 0.0 || block.inter_block.stretch_of(pair) != [0.0; 2]);
        if is_apart && !is_held {
            return;
        }
        let [first, second] = ends.map(|disc| discs.materials[disc]);
        let law = law.of_pair(step.parameters.law.materials.between(first, second));
        let radii = ends.map(|disc| discs.radii[disc]);
        let reduced_radius = motion::reduced_radius(radii[0], radii[1]);
        let mut contact = ContactKinematics::between(separation, distance_squared, reach, velocity);
        let own = block.inter_block.first[pair].into();
        let partner = Partner::Disc(ends[1] as u32);
        let (mut normal_force, mut force) = (0.0, [0.0; 4]);
        if is_apart {
            let mut stretch = block.inter_block.stretch_of(pair);
            law.release(&mut stretch, &mut self.sums, 0.5);
            block.inter_block.set_stretch(pair, stretch);
            self.torques.push([0.0; 2]);
        } else {
            contact = contact.with_circle::<L>(reduced_radius);
            if FRICTION && L::HAS_MINDLIN_SPRINGS {
                let before = motion::overlap_before(separation, velocity, law.time_step, reach);
                contact = contact.with_circle_before(reduced_radius, before);
            }
            self.sums.max_overlap.note(contact.overlap, own as usize, radii[0], partner, radii[1]);
            let normal = law.normal_force::<true>(&contact, block.inter_block.damping[pair]);
            normal_force = normal.force;
            force = if FRICTION {
                self.friction(pair, block, context, (&law, &contact, &normal))
            } else {
                contact.along_normal(&normal)
            };
        }
        let force = law.attracted(force, contact.normal, part);
        self.forces.push((own, force));
        if context.is_recorded && ends[0] <= ends[1] && (part != 0.0 || !is_apart) {
            let numbers = [contact.overlap, normal_force - law.cohesion * part];
            let vectors = [separation, contact.normal];
            self.contacts.push(Contact::new((ends[0], partner, radii), vectors, numbers, force));
        }
    }

    /// Fx, Fy, Dx, Dy on the first disc of a pair with friction. Adds the torque; the springs advance by a step.
    #[inline(always)]
    fn friction<L: NormalLaw>(
        &mut self,
        pair: usize,
        block: &mut Block,
        InterBlockContext { discs, has_rolling_friction, .. }: &InterBlockContext<'_, L>,
        (law, contact, normal): (&LawRegisters<f64, L>, &ContactKinematics<f64>, &NormalForce<f64>),
    ) -> [f64; 4] {
        let (ends, reach) = (block.inter_block_ends(pair), block.inter_block.reach[pair]);
        let [spin, other_spin] = ends.map(|disc| discs.spins[disc]);
        let radii = ends.map(|disc| discs.radii[disc]);
        let arms = radii.map(|radius| motion::lever_arm(radius, contact.overlap));
        let surfaces = Surfaces {
            damping: block.inter_block.damping[pair],
            arm: arms[0],
            surface_speed: arms[0] * spin + arms[1] * other_spin,
            rolling_rate: spin - other_spin,
            reduced_radius: has_rolling_friction.then(|| radii[0] * radii[1] / reach),
        };
        let (mut stretch, sums) = (block.inter_block.stretch_of(pair), &mut self.sums);
        let (force, torque) =
            law.with_friction(contact, normal, &surfaces, &mut stretch, sums, 0.5);
        block.inter_block.set_stretch(pair, stretch);
        self.torques.push(torque);
        force
    }
}
