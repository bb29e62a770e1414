//! The contact kernel: forces of the pairs within a block, for one, four or eight pairs at a time.
//!
//! The kernel is written once for every register width; width 1 is the scalar loop. Operations and their order do not depend
//! on the width, so results have the same bits. Each batch takes two passes: the first finds the kinematics of all contacts, with
//! all roots and quotients and no sum in memory that waits for them; the second adds the forces.
//!
//! The tangential force f of a pair acts at its contact point. The torque on either disc is -a f with the arm a = r - delta/2.
//!
//! # Safety
//! - Loops do not check indices: the callers, in `pair_loops`, compare the largest index with the number of discs before.

#![allow(unsafe_code)]

use super::contact_law::{ContactKinematics, LawRegisters};
use crate::dem::block::{BlockDiscs, PairGroups, Partner};
use crate::dem::laws::NormalLaw;
use crate::dem::motion::{self, NormalForce};
use crate::dem::parameters::StepContext;
use crate::dem::totals::{Contact, ContactRecorder, MaxOverlap};
use crate::simd::registers::{InstructionSet, MAX_WIDTH, Mask, Register};

/// Groups of pairs per batch: their kinematics stay in the nearest cache.
pub(super) const BATCH: usize = 16;

/// The constants of the step and the discs of a block.
#[derive(Clone, Copy)]
pub(super) struct PairContext<'a> {
    pub(super) step: &'a StepContext<'a>,
    pub(super) discs: &'a BlockDiscs<'a>,
    /// Radius, m, and spin, rad/s, of each disc; empty without friction.
    pub(super) rotors: &'a [[f64; 2]],
}

/// The sums that pairs add to.
pub(super) struct PairSums<'a> {
    /// Fx, Fy, Dx, Dy of each disc, N.
    pub(super) forces: &'a mut [[f64; 4]],
    /// Torque on each disc and the part of it that dashpots take, N m; empty without friction.
    pub(super) torques: &'a mut [[f64; 2]],
    pub(super) max_overlap: &'a mut MaxOverlap,
}

/// The springs of groups of pairs; empty without friction.
pub(super) struct Springs<'a, const N: usize> {
    /// R = r_i r_j / (r_i + r_j), m; empty if no force depends on it.
    pub(super) reduced_radius: &'a [[f64; N]],
    pub(super) stretch: &'a mut [[f64; N]],
    pub(super) rolling_stretch: &'a mut [[f64; N]],
}

/// A group of pairs after the first pass.
#[derive(Clone, Copy)]
struct GroupContact<R: Register> {
    kinematics: ContactKinematics<R>,
    /// With friction, which pairs are in contact. Without, those apart have no overlap and no speed.
    mask: R::Mask,
    /// The part of the step for which the discs attract each other, also of pairs that have just parted; 0 without cohesion.
    part: R,
    /// Number of the group in the batch.
    group: usize,
}

/// Memory for the results of the first pass.
pub(super) struct Batch<R: Register>([GroupContact<R>; BATCH]);

impl<R: Register> Batch<R> {
    #[inline(always)]
    pub(super) fn new<const N: usize>(instructions: impl InstructionSet<N, Register = R>) -> Self {
        let zero = instructions.splat(0.0);
        let kinematics = ContactKinematics::new([zero; 2], zero, [zero; 2]);
        Self([GroupContact { kinematics, mask: zero.is_less(zero), part: zero, group: 0 }; BATCH])
    }
}

/// The kernel with its constants in registers.
pub(super) struct ContactKernel<'a, 'b, const N: usize, I: InstructionSet<N>, L: NormalLaw> {
    instructions: I,
    law: LawRegisters<I::Register, L>,
    context: &'a PairContext<'a>,
    sums: &'a mut PairSums<'b>,
    /// Energies, J, of the springs, dissipated by friction, and by rolling friction; summed separately over the pairs whose
    /// numbers have the same remainder modulo eight: in eight registers at width 1, two at width 4, one at width 8.
    energies: [[I::Register; MAX_WIDTH]; 3],
    recorder: ContactRecorder<'a>,
}

impl<'a, 'b, const N: usize, I: InstructionSet<N>, L: NormalLaw> ContactKernel<'a, 'b, N, I, L> {
    #[inline(always)]
    pub(super) fn new(
        instructions: I,
        law: L,
        context: &'a PairContext<'a>,
        sums: &'a mut PairSums<'b>,
        recorder: ContactRecorder<'a>,
    ) -> Self {
        let law = LawRegisters::new(instructions, context.step, law);
        let energies = [[law.zero; MAX_WIDTH]; 3];
        Self { instructions, law, context, sums, energies, recorder }
    }

    /// The energies of the springs, dissipated by friction, and by rolling friction, J. The order of the sums does not depend
    /// on the width.
    #[inline(always)]
    pub(super) fn energies(&self) -> [f64; 3] {
        self.energies.each_ref().map(|registers| {
            let mut lanes = [0.0; MAX_WIDTH];
            for (register, part) in registers.iter().zip(lanes.as_chunks_mut().0) {
                self.instructions.store(*register, part);
            }
            let [a, b, c, d, e, f, g, h] = lanes;
            ((a + e) + (c + g)) + ((b + f) + (d + h))
        })
    }

    /// Compares the largest index with the number of discs.
    #[inline(always)]
    pub(super) fn check_indices(&self, groups: &PairGroups<'_, N>) {
        let (context, sums) = (self.context, &self.sums);
        let discs = context.discs.positions.len();
        let is_one_length = |lengths: &[usize]| lengths.iter().all(|&length| length == discs);
        let BlockDiscs { velocities, spins, radii, .. } = context.discs;
        let lengths = [velocities.len(), spins.len(), radii.len(), sums.forces.len()];
        assert!(is_one_length(&lengths), "columns of different lengths");
        if !context.rotors.is_empty() {
            let lengths = [context.rotors.len(), sums.torques.len()];
            assert!(is_one_length(&lengths), "columns of different lengths");
        }
        assert!(groups.max_index() < discs, "a pair names a disc that does not exist");
    }

    /// Adds the forces of groups of pairs, and returns the number of contacts.
    ///
    /// # Safety
    /// - Every index is less than the number of discs, and all columns have that length.
    #[inline(always)]
    pub(super) unsafe fn add<const FRICTION: bool, const ROLLING: bool, const MIXED: bool>(
        &mut self,
        groups: &PairGroups<'_, N>,
        springs: &mut Springs<'_, N>,
        Batch(batch): &mut Batch<I::Register>,
    ) -> usize {
        let mut contacts = 0;
        for start in (0..groups.first.len()).step_by(BATCH) {
            let end = Ord::min(start + BATCH, groups.first.len());
            let groups = groups.range(start..end);
            let springs = &mut Springs {
                reduced_radius: if FRICTION && (ROLLING || L::HAS_CIRCLE) {
                    &springs.reduced_radius[start..end]
                } else {
                    &[]
                },
                stretch: if FRICTION { &mut springs.stretch[start..end] } else { &mut [] },
                rolling_stretch: if ROLLING {
                    &mut springs.rolling_stretch[start..end]
                } else {
                    &mut []
                },
            };
            // SAFETY: the caller checked the indices.
            unsafe {
                let [count, in_contact] =
                    self.find_kinematics::<FRICTION, ROLLING, MIXED>(&groups, springs, batch);
                contacts += in_contact;
                for (place, contact) in batch.iter().enumerate().take(count) {
                    let skips = skips_idle_groups::<FRICTION, N>();
                    let group = if skips { contact.group } else { place };
                    self.add_forces::<FRICTION, ROLLING, MIXED>(&groups, springs, contact, group);
                }
            }
        }
        contacts
    }

    /// The first pass: finds which pairs of a batch are in contact, and their kinematics. Returns the number of groups for the
    /// second pass, and that of contacts.
    ///
    /// # Safety
    /// - Every index is less than the number of discs.
    #[inline(always)]
    unsafe fn find_kinematics<const FRICTION: bool, const ROLLING: bool, const MIXED: bool>(
        &mut self,
        groups: &PairGroups<'_, N>,
        springs: &Springs<'_, N>,
        batch: &mut [GroupContact<I::Register>; BATCH],
    ) -> [usize; 2] {
        let Self { instructions, law, context, sums, .. } = self;
        // Copied out of the structure, so that the loop does not load them again.
        let (positions, velocities) = (&*context.discs.positions, &*context.discs.velocities);
        let mut bound = instructions.splat(sums.max_overlap.bound());
        let (mut contacts, mut count) = (law.zero, 0);
        for group in 0..Ord::min(groups.first.len(), BATCH) {
            let ends = [&groups.first[group], &groups.second[group]];
            let reach = instructions.load(&groups.reach[group]);
            // SAFETY: the caller checked the indices.
            let separation = unsafe { instructions.differences(positions, ends) };
            let distance_squared = motion::distance_squared(separation);
            let mask = motion::is_closer(distance_squared, reach);
            let mut part = law.zero;
            if MIXED && law.is_cohesive {
                // SAFETY: the caller checked the indices.
                let velocity = unsafe { instructions.differences(velocities, ends) };
                part = law.attracted_part(separation, velocity, reach);
            }
            if skips_idle_groups::<FRICTION, N>() && mask.bits() == 0 {
                let mut held = part.abs();
                for stretch in [&*springs.stretch, &*springs.rolling_stretch] {
                    if let Some(stretch) = stretch.get(group) {
                        held = held + instructions.load(stretch).abs();
                    }
                }
                if law.zero.is_less(held).bits() == 0 {
                    continue;
                }
            }
            // SAFETY: the caller checked the indices.
            let velocity = unsafe { instructions.differences(velocities, ends) };
            let mut contact =
                ContactKinematics::between(separation, distance_squared, reach, velocity)
                    .or_zero(mask);
            if L::HAS_CIRCLE {
                // SAFETY: the caller checked the indices.
                let radius = unsafe { reduced_radii(*instructions, springs, group, context, ends) };
                contact = contact.with_circle::<L>(radius);
                if FRICTION && L::HAS_MINDLIN_SPRINGS {
                    let before = motion::overlap_before(separation, velocity, law.time_step, reach);
                    contact = contact.with_circle_before(radius, before);
                }
            }
            contacts = contacts + law.zero.splat(1.0).or_zero(mask);
            if bound.is_less(contact.overlap).bits() != 0 {
                let lanes = (contact.overlap, bound);
                note_deeper(*instructions, lanes, ends, context.discs.radii, sums.max_overlap);
                bound = instructions.splat(sums.max_overlap.bound());
            }
            let place = if skips_idle_groups::<FRICTION, N>() { count % BATCH } else { group };
            // Only what the second pass reads is stored.
            let stored = &mut batch[place];
            stored.kinematics.normal = contact.normal;
            stored.kinematics.overlap = contact.overlap;
            stored.kinematics.separating_speed = contact.separating_speed;
            if L::HAS_CIRCLE {
                stored.kinematics.circle = contact.circle;
            }
            if FRICTION && L::HAS_MINDLIN_SPRINGS {
                stored.kinematics.circle_before = contact.circle_before;
            }
            if FRICTION {
                stored.kinematics.sliding_speed = contact.sliding_speed;
                stored.mask = mask;
            }
            if MIXED {
                stored.part = part;
            }
            if skips_idle_groups::<FRICTION, N>() {
                stored.group = group;
            }
            count += 1;
        }
        let mut lanes = [0.0; N];
        instructions.store(contacts, &mut lanes);
        [count, lanes.iter().sum::<f64>() as usize]
    }

    /// The second pass: adds the forces of a group; its springs advance by a step.
    ///
    /// # Safety
    /// - Every index is less than the number of discs.
    #[inline(always)]
    unsafe fn add_forces<const FRICTION: bool, const ROLLING: bool, const MIXED: bool>(
        &mut self,
        groups: &PairGroups<'_, N>,
        springs: &mut Springs<'_, N>,
        contact: &GroupContact<I::Register>,
        group: usize,
    ) {
        let kinematics = &contact.kinematics;
        let ends = [&groups.first[group], &groups.second[group]];
        let damping = self.instructions.load(&groups.damping[group]);
        let (instructions, context) = (self.instructions, self.context);
        let mut law = self.law;
        if MIXED && law.has_plain_springs {
            law.friction = constants_of_pairs(instructions, context, ends);
        } else if MIXED {
            law = law.of_pairs(constants_of_pairs(instructions, context, ends));
        }
        let mut normal = law.normal_force::<MIXED>(kinematics, damping);
        let mut on_first = if FRICTION {
            // SAFETY: the caller checked the indices.
            unsafe { self.friction::<ROLLING>(&law, groups, springs, contact, &normal) }
        } else {
            // A pair apart adds 0, which changes no bit: a sum that began with +0 is never -0. A branch would cost more.
            kinematics.along_normal(&normal)
        };
        if MIXED && law.is_cohesive {
            on_first = law.attracted(on_first, kinematics.normal, contact.part);
            normal.force = normal.force - law.cohesion * contact.part;
        }
        // SAFETY: the caller checked the indices.
        unsafe { self.instructions.add_opposite(on_first, self.sums.forces, ends) };
        if self.recorder.is_some() {
            // SAFETY: the caller checked the indices.
            unsafe { self.record(ends, &groups.reach[group], contact, &normal, on_first) };
        }
    }

    /// Fx, Fy, Dx, Dy on the first discs with friction. Adds the torques and energies; springs of pairs apart are released.
    ///
    /// # Safety
    /// - Every index is less than the number of discs.
    #[inline(always)]
    unsafe fn friction<const ROLLING: bool>(
        &mut self,
        law: &LawRegisters<I::Register, L>,
        groups: &PairGroups<'_, N>,
        springs: &mut Springs<'_, N>,
        &GroupContact { ref kinematics, mask, group, .. }: &GroupContact<I::Register>,
        normal: &NormalForce<I::Register>,
    ) -> [I::Register; 4] {
        let Self { instructions, context, sums, energies, .. } = self;
        let ends = [&groups.first[group], &groups.second[group]];
        // SAFETY: the caller checked the indices.
        let rotors = |end| unsafe { instructions.gather_vectors(context.rotors, end) };
        // Not by `map`: its closure would not be compiled with the instructions of the kernel.
        let ([radius, spin], [other_radius, other_spin]) = (rotors(ends[0]), rotors(ends[1]));
        // Friction acts only on contacts that press.
        let pressing = normal.force.larger(law.zero);
        let [friction, rolling_friction] = law.friction;
        let arm = motion::lever_arm(radius, kinematics.overlap);
        let other_arm = motion::lever_arm(other_radius, kinematics.overlap);
        let damping = instructions.load(&groups.damping[group]);
        let before = instructions.load(&springs.stretch[group]);
        let surface_speed = arm * spin + other_arm * other_spin;
        let slid = law.sliding(kinematics, damping, surface_speed, before, friction * pressing);
        instructions.store(slid.stretch.or_zero(mask), &mut springs.stretch[group]);
        let part = group % (MAX_WIDTH / N);
        let lost = slid.loss.or_else(mask, law.spring_energy(before));
        energies[1][part] = energies[1][part] + lost;
        let mut elastic = law.spring_energy(slid.stretch);
        let (force, dashpot) = (slid.force.or_zero(mask), slid.dashpot.or_zero(mask));
        let mut torques =
            [[-(arm * force), arm * dashpot], [-(other_arm * force), other_arm * dashpot]];
        if ROLLING {
            let before = instructions.load(&springs.rolling_stretch[group]);
            let reduced_radius = instructions.load(&springs.reduced_radius[group]);
            let limit = rolling_friction * pressing;
            let (rolled, torque) = law.rolling(reduced_radius, spin - other_spin, before, limit);
            instructions.store(rolled.stretch.or_zero(mask), &mut springs.rolling_stretch[group]);
            let lost = rolled.loss.or_else(mask, law.spring_energy(before));
            energies[2][part] = energies[2][part] + lost;
            elastic = elastic + law.spring_energy(rolled.stretch);
            let torque = torque.or_zero(mask);
            torques[0][0] = torques[0][0] + torque;
            torques[1][0] = torques[1][0] - torque;
        }
        energies[0][part] = energies[0][part] + elastic.or_zero(mask);
        // SAFETY: the caller checked the indices.
        unsafe { instructions.add_to_ends(torques, sums.torques, ends) };
        let [fx, fy, dx, dy] = kinematics.with_friction(normal, &slid);
        [fx.or_zero(mask), fy.or_zero(mask), dx.or_zero(mask), dy.or_zero(mask)]
    }

    /// Records the contacts of a group, and the pairs that attract each other in the first step apart.
    ///
    /// # Safety
    /// - Every index is less than the number of discs.
    #[inline(always)]
    unsafe fn record(
        &mut self,
        ends: [&[u16; N]; 2],
        reach: &[f64; N],
        &GroupContact { kinematics: ref contact, part, .. }: &GroupContact<I::Register>,
        normal: &NormalForce<I::Register>,
        on_first: [I::Register; 4],
    ) {
        let Self { instructions, law, context, recorder, .. } = self;
        let Some(contacts) = recorder else { return };
        let BlockDiscs { start, positions, radii, .. } = context.discs;
        // SAFETY: the caller checked the indices.
        let separation = unsafe { instructions.differences(positions, ends) };
        let reach = instructions.load(reach);
        let distance_squared = motion::distance_squared(separation);
        let lanes =
            motion::is_closer(distance_squared, reach).bits() | law.zero.is_less(part.abs()).bits();
        let ([x, y], [nx, ny]) = (separation, contact.normal);
        // As `contact.overlap`, which is 0 of pairs apart.
        let overlap = reach - distance_squared.sqrt();
        let [fx, fy, dx, dy] = on_first;
        let registers = [x, y, nx, ny, overlap, normal.force, fx, fy, dx, dy];
        let mut columns = [[0.0; N]; 10];
        for (column, register) in columns.iter_mut().zip(registers) {
            instructions.store(register, column);
        }
        for lane in (0..N).filter(|lane| lanes >> lane & 1 == 1) {
            let [x, y, nx, ny, overlap, normal_force, fx, fy, dx, dy] =
                columns.map(|column| column[lane]);
            let [disc, partner] = ends.map(|end| usize::from(end[lane]));
            let radii = [radii[disc], radii[partner]];
            let ends = (start + disc, Partner::Disc((start + partner) as u32), radii);
            let (vectors, numbers) = ([[x, y], [nx, ny]], [overlap, normal_force]);
            contacts.push(Contact::new(ends, vectors, numbers, [fx, fy, dx, dy]));
        }
    }
}

/// Notes the overlaps of those pairs that are deeper than the bound; both in `lanes`, m.
#[inline(always)]
fn note_deeper<const N: usize, I: InstructionSet<N>>(
    instructions: I,
    lanes: (I::Register, I::Register),
    ends: [&[u16; N]; 2],
    radii: &[f64],
    max_overlap: &mut MaxOverlap,
) {
    let (overlap, bound) = lanes;
    let deeper = bound.is_less(overlap).bits();
    let mut overlaps = [0.0; N];
    instructions.store(overlap, &mut overlaps);
    for lane in (0..N).filter(|lane| deeper >> lane & 1 == 1) {
        let ends = ends.map(|end| usize::from(end[lane]));
        max_overlap.note_pair(overlaps[lane], ends, radii);
    }
}

/// Whether the first pass skips groups without contacts and stretched springs. Otherwise, a branch costs more than it saves.
#[inline(always)]
fn skips_idle_groups<const FRICTION: bool, const N: usize>() -> bool {
    FRICTION || N == 1
}

/// Reduced radii of pairs, m, which are not found again if they are known.
///
/// # Safety
/// - Every index is less than the number of radii.
#[inline(always)]
unsafe fn reduced_radii<const N: usize, I: InstructionSet<N>>(
    instructions: I,
    springs: &Springs<'_, N>,
    group: usize,
    context: &PairContext<'_>,
    [first, second]: [&[u16; N]; 2],
) -> I::Register {
    if let Some(known) = springs.reduced_radius.get(group) {
        return instructions.load(known);
    }
    let radii = context.discs.radii;
    let mut columns = [[0.0; N]; 2];
    for lane in 0..N {
        // SAFETY: the caller checked the indices.
        columns[0][lane] = unsafe { *radii.get_unchecked(usize::from(first[lane])) };
        // SAFETY: the caller checked the indices.
        columns[1][lane] = unsafe { *radii.get_unchecked(usize::from(second[lane])) };
    }
    motion::reduced_radius(instructions.load(&columns[0]), instructions.load(&columns[1]))
}

/// The first constants of [`LawRegisters::of_pairs`], of pairs of discs of several materials.
#[inline(always)]
fn constants_of_pairs<const N: usize, const COUNT: usize, I: InstructionSet<N>>(
    instructions: I,
    context: &PairContext<'_>,
    [first, second]: [&[u16; N]; 2],
) -> [I::Register; COUNT] {
    let mut columns = [[0.0; N]; COUNT];
    for lane in 0..N {
        let [one, other] =
            [first[lane], second[lane]].map(|disc| context.discs.materials[usize::from(disc)]);
        let pair = context.step.parameters.law.materials.between(one, other).of_contact();
        for (column, constant) in columns.iter_mut().zip(pair) {
            column[lane] = constant;
        }
    }
    let mut constants = [instructions.splat(0.0); COUNT];
    for (constant, column) in constants.iter_mut().zip(&columns) {
        *constant = instructions.load(column);
    }
    constants
}
