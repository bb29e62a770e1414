//! The contact kernel: forces of the pairs within a block, for one, four or eight pairs at a time.
//!
//! The kernel is written once for every register width; width 1 is the scalar loop. Operations and their order do not depend
//! on the width, so results have the same bits. Each batch takes two passes: the first finds the kinematics of all contacts, with
//! all roots and quotients and no sum in memory that waits for them; the second adds the forces.
//!
//! The tangential force f of a pair acts on both rims. The torque on either disc is -r f, so f is summed per disc and multiplied
//! by the radius once.
//!
//! # Safety
//! - Loops do not check indices: the callers, in `pair_loops`, compare the largest index with the number of discs before.

#![allow(unsafe_code)]

use super::contact_law::{ContactKinematics, LawRegisters};
use crate::dem::block::{BlockView, PairGroups};
use crate::dem::materials::ContactLaw;
use crate::dem::motion::{self, NormalForce};
use crate::dem::totals::{Contact, ContactRecorder, MaxOverlap, Partner, overlap_over_radius};
use crate::simd::registers::{InstructionSet, MAX_WIDTH, Mask, Register};
use std::ops::Range;

/// Groups of pairs per batch: their kinematics stay in the nearest cache.
pub(super) const BATCH: usize = 16;

/// The law, the time step, and the discs of a block.
#[derive(Clone, Copy)]
pub(super) struct PairContext<'a> {
    pub(super) law: &'a ContactLaw,
    pub(super) time_step: f64,
    pub(super) discs: BlockView<'a>,
    /// Speeds r w of the rims, m/s; empty without friction.
    pub(super) rim_speeds: &'a [f64],
    /// Numbers in the widest register that may be used.
    pub(super) max_width: usize,
}

/// The sums that pairs add to.
pub(super) struct PairSums<'a> {
    /// Fx, Fy, Dx, Dy of each disc, N.
    pub(super) forces: &'a mut [[f64; 4]],
    /// Tangential force on the rim of each disc and the dashpots' part of it, N; empty without friction.
    pub(super) tangential: &'a mut [[f64; 2]],
    /// Torque of the rolling springs on each disc, N m; empty without friction.
    pub(super) rolling: &'a mut [f64],
    pub(super) max_overlap: &'a mut MaxOverlap,
}

/// Energies, J, summed separately over the pairs whose numbers have the same remainder modulo eight: their bits do not depend on
/// the width.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct FrictionEnergies {
    /// Energy of the tangential and rolling springs.
    pub(super) elastic: [f64; MAX_WIDTH],
    /// Energy dissipated by friction.
    pub(super) friction: [f64; MAX_WIDTH],
    /// Energy dissipated by rolling friction.
    pub(super) rolling: [f64; MAX_WIDTH],
}

/// The springs of the same groups; empty without friction.
pub(super) struct Springs<'a, const N: usize> {
    pub(super) stretch: &'a mut [[f64; N]],
    pub(super) rolling_stretch: &'a mut [[f64; N]],
}

/// The first pass's results.
pub(super) struct Batch<R: Register> {
    contacts: [ContactKinematics<R>; BATCH],
    /// With friction, which pairs are in contact. Without, those apart have no overlap and no speed.
    masks: [R::Mask; BATCH],
    groups: [usize; BATCH],
    count: usize,
}

impl<R: Register> Batch<R> {
    #[inline(always)]
    pub(super) fn new(zero: R) -> Self {
        let apart = ContactKinematics::new([zero; 2], zero, [zero; 2]);
        let masks = [zero.is_less(zero); BATCH];
        Self { contacts: [apart; BATCH], masks, groups: [0; BATCH], count: 0 }
    }
}

/// The columns of [`FrictionEnergies`]: eight registers at width 1, two at width 4, one at width 8.
pub(super) struct EnergyRegisters<R> {
    elastic: [R; MAX_WIDTH],
    friction: [R; MAX_WIDTH],
    rolling: [R; MAX_WIDTH],
}

impl<R: Register> EnergyRegisters<R> {
    #[inline(always)]
    pub(super) fn load<const N: usize>(
        instructions: impl InstructionSet<N, Register = R>,
        energies: &FrictionEnergies,
    ) -> Self {
        let zero = [instructions.splat(0.0); MAX_WIDTH];
        let mut registers = Self { elastic: zero, friction: zero, rolling: zero };
        for part in 0..MAX_WIDTH / N {
            let FrictionEnergies { elastic, friction, rolling } = energies;
            registers.elastic[part] = instructions.load(&elastic.as_chunks().0[part]);
            registers.friction[part] = instructions.load(&friction.as_chunks().0[part]);
            registers.rolling[part] = instructions.load(&rolling.as_chunks().0[part]);
        }
        registers
    }

    #[inline(always)]
    pub(super) fn store<const N: usize>(
        &self,
        instructions: impl InstructionSet<N, Register = R>,
        energies: &mut FrictionEnergies,
    ) {
        for part in 0..MAX_WIDTH / N {
            let FrictionEnergies { elastic, friction, rolling } = energies;
            instructions.store(self.elastic[part], &mut elastic.as_chunks_mut().0[part]);
            instructions.store(self.friction[part], &mut friction.as_chunks_mut().0[part]);
            instructions.store(self.rolling[part], &mut rolling.as_chunks_mut().0[part]);
        }
    }
}

/// A group in the second pass.
#[derive(Clone, Copy)]
struct Slider<'a, const N: usize, R: Register> {
    ends: [&'a [u32; N]; 2],
    reach: &'a [f64; N],
    group: usize,
    damping: R,
    mask: R::Mask,
}

/// The kernel with its constants in registers.
pub(super) struct ContactKernel<'a, 'b, const N: usize, I: InstructionSet<N>, C> {
    pub(super) instructions: I,
    pub(super) law: LawRegisters<I::Register>,
    pub(super) context: &'a PairContext<'a>,
    pub(super) sums: &'a mut PairSums<'b>,
    pub(super) energies: EnergyRegisters<I::Register>,
    pub(super) recorder: &'a mut C,
}

impl<const N: usize, I: InstructionSet<N>, C: ContactRecorder> ContactKernel<'_, '_, N, I, C> {
    /// Adds the forces of a range of groups, and returns the number of contacts.
    ///
    /// # Safety
    /// - Every index is less than the number of discs.
    #[inline(always)]
    pub(super) unsafe fn add<const FRICTION: bool, const ROLLING: bool, const MIXED: bool>(
        &mut self,
        groups: &PairGroups<'_, N>,
        springs: &mut Springs<'_, N>,
        batch: &mut Batch<I::Register>,
        range: Range<usize>,
    ) -> usize {
        let mut contacts = 0;
        for start in range.clone().step_by(BATCH) {
            let groups = groups.range(start..Ord::min(start + BATCH, range.end));
            // SAFETY: the caller checked the indices.
            unsafe {
                contacts +=
                    self.find_kinematics::<FRICTION, ROLLING>(&groups, springs, batch, start);
                if FRICTION || N == 1 {
                    for number in 0..Ord::min(batch.count, BATCH) {
                        let group = batch.groups[number];
                        self.add_forces::<FRICTION, ROLLING, MIXED>(
                            &groups,
                            springs,
                            batch,
                            [number, group, start],
                        );
                    }
                } else {
                    for group in 0..Ord::min(groups.first.len(), BATCH) {
                        self.add_forces::<FRICTION, ROLLING, MIXED>(
                            &groups,
                            springs,
                            batch,
                            [group, group, start],
                        );
                    }
                }
            }
        }
        contacts
    }

    /// The first pass: finds which pairs of a few groups are in contact, and their kinematics. Groups without contacts and
    /// stretched springs are skipped with friction and at width 1; otherwise a branch costs more than it saves.
    ///
    /// # Safety
    /// - Every index is less than the number of discs.
    #[inline(always)]
    unsafe fn find_kinematics<const FRICTION: bool, const ROLLING: bool>(
        &mut self,
        groups: &PairGroups<'_, N>,
        springs: &Springs<'_, N>,
        batch: &mut Batch<I::Register>,
        start: usize,
    ) -> usize {
        let Self { instructions, law, context, sums, .. } = self;
        let BlockView { positions, velocities, radii, .. } = context.discs;
        let mut bound = instructions.splat(sums.max_overlap.bound());
        let (mut contacts, mut count) = (law.zero, 0);
        for group in 0..Ord::min(groups.first.len(), BATCH) {
            let ends = [&groups.first[group], &groups.second[group]];
            let reach = instructions.load(&groups.reach[group]);
            // SAFETY: the caller checked the indices.
            let separation = unsafe { instructions.differences(positions, ends) };
            let distance_squared = motion::distance_squared(separation);
            let mask = motion::is_closer(distance_squared, reach);
            if FRICTION || N == 1 {
                let mut is_idle = mask.bits() == 0;
                if FRICTION {
                    let mut held = instructions.load(&springs.stretch[start + group]).abs();
                    if ROLLING {
                        held =
                            held + instructions.load(&springs.rolling_stretch[start + group]).abs();
                    }
                    is_idle &= law.zero.is_less(held).bits() == 0;
                }
                if is_idle {
                    continue;
                }
            }
            // SAFETY: the caller checked the indices.
            let velocity = unsafe { instructions.differences(velocities, ends) };
            let mut contact = law.kinematics(separation, distance_squared, reach, velocity);
            contact.overlap = contact.overlap.or_zero(mask);
            contact.separating_speed = contact.separating_speed.or_zero(mask);
            contacts = contacts + law.one.or_zero(mask);
            let deeper = bound.is_less(contact.overlap).bits();
            if deeper != 0 {
                let mut overlaps = [0.0; N];
                instructions.store(contact.overlap, &mut overlaps);
                for lane in (0..N).filter(|lane| deeper >> lane & 1 == 1) {
                    let ends = ends.map(|end| end[lane] as usize);
                    sums.max_overlap.note_pair(overlaps[lane], ends, radii);
                }
                bound = instructions.splat(sums.max_overlap.bound());
            }
            let place = if FRICTION || N == 1 { count % BATCH } else { group };
            batch.contacts[place].normal = contact.normal;
            batch.contacts[place].overlap = contact.overlap;
            batch.contacts[place].separating_speed = contact.separating_speed;
            if FRICTION {
                batch.contacts[place].sliding_speed = contact.sliding_speed;
                batch.masks[place] = mask;
            }
            if FRICTION || N == 1 {
                batch.groups[place] = group;
            }
            count += 1;
        }
        batch.count = count;
        let mut lanes = [0.0; N];
        instructions.store(contacts, &mut lanes);
        lanes.iter().sum::<f64>() as usize
    }

    /// The second pass: adds the forces of a group; its springs advance by a step. The three numbers are its place in the batch, its
    /// number, and that of the first group of the batch.
    ///
    /// # Safety
    /// - Every index is less than the number of discs.
    #[inline(always)]
    unsafe fn add_forces<const FRICTION: bool, const ROLLING: bool, const MIXED: bool>(
        &mut self,
        groups: &PairGroups<'_, N>,
        springs: &mut Springs<'_, N>,
        batch: &Batch<I::Register>,
        [number, group, start]: [usize; 3],
    ) {
        let (contact, mask) = (&batch.contacts[number], batch.masks[number]);
        let ends = [&groups.first[group], &groups.second[group]];
        let damping = self.instructions.load(&groups.damping[group]);
        let normal = self.law.normal_force(contact, damping);
        let on_first = if FRICTION {
            let (reach, group) = (&groups.reach[group], start + group);
            let slider = Slider { ends, reach, group, damping, mask };
            self.friction::<ROLLING, MIXED>(springs, contact, &normal, slider)
        } else {
            // A pair apart adds 0, which changes no bit: a sum that began with +0 is never -0. A branch would cost more.
            contact.along_normal(&normal)
        };
        // SAFETY: the caller checked the indices.
        unsafe { self.instructions.add_opposite(on_first, self.sums.forces, ends) };
        if C::IS_ACTIVE {
            // SAFETY: the caller checked the indices.
            unsafe { self.record(ends, &groups.reach[group], contact, &normal, on_first) };
        }
    }

    /// Fx, Fy, Dx, Dy on the first discs with friction. Adds the tangential forces, torques and energies; springs of pairs apart
    /// are released.
    #[inline(always)]
    fn friction<const ROLLING: bool, const MIXED: bool>(
        &mut self,
        springs: &mut Springs<'_, N>,
        contact: &ContactKinematics<I::Register>,
        normal: &NormalForce<I::Register>,
        Slider { ends, reach, group, damping, mask }: Slider<'_, N, I::Register>,
    ) -> [I::Register; 4] {
        let Self { instructions, law, context, sums, energies, .. } = self;
        let pressing = law.pressing(normal);
        let [friction, rolling_friction] =
            if MIXED { coefficients(*instructions, context, ends) } else { law.friction };
        // Columns of one length, so that an index is checked once.
        let rim_speeds = &context.rim_speeds[..sums.forces.len()];
        let tangential = &mut sums.tangential[..sums.forces.len()];
        let rim_speeds = gathered_at_both(*instructions, rim_speeds, ends);
        let rim_speed = rim_speeds[0] + rim_speeds[1];
        let before = instructions.load(&springs.stretch[group]);
        let slid = law.sliding(contact, damping, rim_speed, before, friction * pressing);
        instructions.store(slid.stretch.or_zero(mask), &mut springs.stretch[group]);
        let part = group % (MAX_WIDTH / N);
        let lost = slid.loss.or_else(mask, law.spring_energy(before));
        energies.friction[part] = energies.friction[part] + lost;
        let mut elastic = law.spring_energy(slid.stretch);
        if ROLLING {
            let before = instructions.load(&springs.rolling_stretch[group]);
            let radii = gathered_at_both(*instructions, context.discs.radii, ends);
            let spins = gathered_at_both(*instructions, context.discs.spins, ends);
            let reduced_radius = radii[0] * radii[1] / instructions.load(reach);
            let rate = spins[0] - spins[1];
            let (rolled, torque) =
                law.rolling(reduced_radius, rate, before, rolling_friction * pressing);
            instructions.store(rolled.stretch.or_zero(mask), &mut springs.rolling_stretch[group]);
            let lost = rolled.loss.or_else(mask, law.spring_energy(before));
            energies.rolling[part] = energies.rolling[part] + lost;
            elastic = elastic + law.spring_energy(rolled.stretch);
            add_torques(*instructions, torque.or_zero(mask), sums.rolling, ends);
        }
        energies.elastic[part] = energies.elastic[part] + elastic.or_zero(mask);
        let on_rims = [slid.force.or_zero(mask), slid.dashpot.or_zero(mask)];
        instructions.add_to_both(on_rims, tangential, ends);
        let [fx, fy, dx, dy] = contact.with_friction(normal, &slid);
        [fx.or_zero(mask), fy.or_zero(mask), dx.or_zero(mask), dy.or_zero(mask)]
    }

    /// Records the contacts of a group.
    ///
    /// # Safety
    /// - Every index is less than the number of discs.
    #[inline(always)]
    unsafe fn record(
        &mut self,
        ends: [&[u32; N]; 2],
        reach: &[f64; N],
        contact: &ContactKinematics<I::Register>,
        normal: &NormalForce<I::Register>,
        on_first: [I::Register; 4],
    ) {
        let Self { instructions, context, recorder, .. } = self;
        let BlockView { start, positions, radii, .. } = context.discs;
        // SAFETY: the caller checked the indices.
        let separation = unsafe { instructions.differences(positions, ends) };
        let reach = instructions.load(reach);
        let lanes = motion::is_closer(motion::distance_squared(separation), reach).bits();
        let ([x, y], [nx, ny]) = (separation, contact.normal);
        let registers = [x, y, nx, ny, contact.overlap, normal.force, on_first[0], on_first[1]];
        let mut columns = [[0.0; N]; 8];
        for (column, register) in columns.iter_mut().zip(registers) {
            instructions.store(register, column);
        }
        for lane in (0..N).filter(|lane| lanes >> lane & 1 == 1) {
            let [x, y, nx, ny, overlap, normal_force, fx, fy] = columns.map(|column| column[lane]);
            let [disc, partner] = ends.map(|end| end[lane] as usize);
            recorder.record(Contact {
                disc: (start + disc) as u32,
                partner: Partner::Disc((start + partner) as u32),
                separation: [x, y],
                normal: [nx, ny],
                overlap,
                overlap_over_radius: overlap_over_radius(overlap, radii[disc], radii[partner]),
                normal_force,
                force: [fx, fy],
            });
        }
    }
}

/// One number per disc, for a register of discs.
#[inline(always)]
fn gathered<const N: usize, I: InstructionSet<N>>(
    instructions: I,
    column: &[f64],
    discs: &[u32; N],
) -> I::Register {
    let mut values = [0.0; N];
    for (value, disc) in values.iter_mut().zip(discs) {
        *value = column[*disc as usize];
    }
    instructions.load(&values)
}

/// One number per disc, for the first discs of a group and for the second ones.
#[inline(always)]
fn gathered_at_both<const N: usize, I: InstructionSet<N>>(
    instructions: I,
    column: &[f64],
    [first, second]: [&[u32; N]; 2],
) -> [I::Register; 2] {
    [gathered(instructions, column, first), gathered(instructions, column, second)]
}

/// Friction and rolling friction of discs of several materials.
#[inline(always)]
fn coefficients<const N: usize, I: InstructionSet<N>>(
    instructions: I,
    context: &PairContext<'_>,
    [first, second]: [&[u32; N]; 2],
) -> [I::Register; 2] {
    let (mut friction, mut rolling_friction) = ([0.0; N], [0.0; N]);
    for lane in 0..N {
        let [one, other] =
            [first[lane], second[lane]].map(|disc| context.discs.materials[disc as usize]);
        let pair = context.law.materials.between(one, other);
        (friction[lane], rolling_friction[lane]) = (pair.friction, pair.rolling_friction);
    }
    [instructions.load(&friction), instructions.load(&rolling_friction)]
}

/// Adds torques to those on the first discs, and subtracts them from those on the second.
#[inline(always)]
fn add_torques<const N: usize, I: InstructionSet<N>>(
    instructions: I,
    torques: I::Register,
    sums: &mut [f64],
    [first, second]: [&[u32; N]; 2],
) {
    let mut on_first = [0.0; N];
    instructions.store(torques, &mut on_first);
    for (lane, torque) in on_first.into_iter().enumerate() {
        sums[first[lane] as usize] += torque;
        sums[second[lane] as usize] -= torque;
    }
}
