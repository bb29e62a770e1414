//! The loops of the contact kernel over the pairs of a block, with and without friction.
//!
//! Without friction, pairs of the first tier are all computed, of the others only the near pairs in contact. The width is four:
//! eight pairs per register were slower (`benches/dem_speed.rs`). With friction, the width is that of the widest registers.
//!
//! # Safety
//! - Before the loops over a list, one assertion compares its largest index with the number of discs. A list from a damaged
//!   checkpoint fails that assertion.

#![allow(unsafe_code)]

use super::contact_law::LawRegisters;
use super::kernel::{
    BATCH, Batch, ContactKernel, EnergyRegisters, FrictionEnergies, PairContext, PairSums, Springs,
};
use crate::dem::block::{PairGroups, Pairs};
use crate::dem::neighbors::near_pairs::{ContactNumbers, NearPairs};
use crate::dem::neighbors::tiers::Scope;
use crate::dem::totals::{ContactMask, ContactRecorder};
use crate::simd::registers::{self, InstructionSet, RegisterKernel};
use std::ops::Range;

/// Register width without friction.
const FRICTIONLESS_WIDTH: usize = 4;
/// Near pairs that are gathered for a batch.
const GATHERED: usize = BATCH * FRICTIONLESS_WIDTH;

/// The near pairs of a block, memory that blocks share, and the set of discs in contact.
pub(super) struct NearMemory<'a> {
    pub(super) near: &'a mut NearPairs,
    pub(super) contacts: &'a mut ContactNumbers,
    /// Receives the discs of near pairs in contact. It is complete if the near pairs are all pairs.
    pub(super) mask: &'a mut ContactMask,
}

/// Adds the forces of a block's pairs without friction.
pub(super) fn add_without_friction<C: ContactRecorder>(
    context: &PairContext<'_>,
    pairs: &Pairs,
    scope: &Scope,
    memory: NearMemory<'_>,
    sums: &mut PairSums<'_>,
    recorder: &mut C,
) {
    let width = Ord::min(context.max_width, FRICTIONLESS_WIDTH);
    registers::run(Frictionless { context, pairs, scope, memory, sums, recorder }, width);
}

/// Adds the forces of the first `end` pairs of a list with friction; their springs advance by a step.
pub(super) fn add_with_friction<C: ContactRecorder>(
    context: &PairContext<'_>,
    pairs: &mut Pairs,
    end: usize,
    sums: &mut PairSums<'_>,
    recorder: &mut C,
) -> FrictionEnergies {
    let law = context.law;
    let run = match (law.has_rolling_friction(), law.materials.only().is_none()) {
        (false, false) => run_frictional::<C, false, false>,
        (false, true) => run_frictional::<C, false, true>,
        (true, false) => run_frictional::<C, true, false>,
        (true, true) => run_frictional::<C, true, true>,
    };
    let mut energies = FrictionEnergies::default();
    let done = run(context, pairs, 0..end, sums, &mut energies, recorder, context.max_width);
    // The pairs that do not fill a register.
    run(context, pairs, done..end, sums, &mut energies, recorder, 1);
    energies
}

fn run_frictional<C: ContactRecorder, const ROLLING: bool, const MIXED: bool>(
    context: &PairContext<'_>,
    pairs: &mut Pairs,
    range: Range<usize>,
    sums: &mut PairSums<'_>,
    energies: &mut FrictionEnergies,
    recorder: &mut C,
    width: usize,
) -> usize {
    let kernel =
        Frictional::<C, ROLLING, MIXED> { context, pairs, range, sums, energies, recorder };
    registers::run(kernel, width)
}

/// The pairs of a list with friction.
struct Frictional<'a, 'b, C, const ROLLING: bool, const MIXED: bool> {
    context: &'a PairContext<'a>,
    pairs: &'a mut Pairs,
    range: Range<usize>,
    sums: &'a mut PairSums<'b>,
    energies: &'a mut FrictionEnergies,
    recorder: &'a mut C,
}

impl<C: ContactRecorder, const ROLLING: bool, const MIXED: bool> RegisterKernel
    for Frictional<'_, '_, C, ROLLING, MIXED>
{
    /// The end of the pairs that filled whole registers.
    type Output = usize;

    #[inline(always)]
    fn run<const N: usize, I: InstructionSet<N>>(self, instructions: I) -> usize {
        let Self { context, pairs, range, sums, energies, recorder } = self;
        let Pairs { first, second, reach, damping, stretch, rolling_stretch, .. } = pairs;
        let groups = PairGroups::<N>::of([first, second], reach, damping);
        let mut springs = Springs {
            stretch: stretch.as_chunks_mut().0,
            rolling_stretch: rolling_stretch.as_chunks_mut().0,
        };
        let range = range.start / N..range.end / N;
        check_indices(context, sums, &groups.range(range.clone()));
        let law = LawRegisters::new(instructions, context.law, context.time_step);
        let mut batch = Batch::new(law.zero);
        let registers = EnergyRegisters::load(instructions, energies);
        let mut kernel =
            ContactKernel { instructions, law, context, sums, energies: registers, recorder };
        let end = range.end * N;
        // SAFETY: every index is less than the number of discs.
        unsafe { kernel.add::<true, ROLLING, MIXED>(&groups, &mut springs, &mut batch, range) };
        kernel.energies.store(instructions, energies);
        end
    }
}

/// Compares the largest index with the number of discs.
#[inline(always)]
fn check_indices<const N: usize>(
    context: &PairContext<'_>,
    sums: &PairSums<'_>,
    groups: &PairGroups<'_, N>,
) {
    let discs = context.discs.positions.len();
    let is_one_length = context.discs.velocities.len() == discs && sums.forces.len() == discs;
    assert!(is_one_length, "columns of different lengths");
    assert!(groups.max_index() < discs, "a pair names a disc that does not exist");
}

/// The pairs of a block without friction.
struct Frictionless<'a, 'b, C> {
    context: &'a PairContext<'a>,
    pairs: &'a Pairs,
    scope: &'a Scope,
    memory: NearMemory<'a>,
    sums: &'a mut PairSums<'b>,
    recorder: &'a mut C,
}

/// Near pairs in contact, gathered for a batch.
struct Gathered {
    first: [u32; GATHERED],
    second: [u32; GATHERED],
    reach: [f64; GATHERED],
    damping: [f64; GATHERED],
    count: usize,
}

impl Gathered {
    /// Completes the last group with pairs of a disc and itself, which are not in contact; returns the groups.
    fn take<const N: usize>(&mut self) -> PairGroups<'_, N> {
        let end = self.count.next_multiple_of(N);
        self.first[self.count..end].fill(0);
        self.second[self.count..end].fill(0);
        self.reach[self.count..end].fill(0.0);
        self.damping[self.count..end].fill(0.0);
        self.count = 0;
        let ends = [&self.first[..end], &self.second[..end]];
        PairGroups::of(ends, &self.reach[..end], &self.damping[..end])
    }
}

impl<C: ContactRecorder> RegisterKernel for Frictionless<'_, '_, C> {
    type Output = ();

    #[inline(always)]
    fn run<const N: usize, I: InstructionSet<N>>(self, instructions: I) {
        let Self { context, pairs, scope, memory, sums, recorder } = self;
        let NearMemory { near, contacts, mask } = memory;
        let discs = context.discs.positions.len();
        // At width 1 all pairs are compared, which checks the near pairs of the wider registers.
        let dense = if N == 1 {
            pairs.in_tiers(scope.tiers)
        } else {
            near.find_contacts(instructions, pairs, context.discs.positions, scope, contacts);
            near.begin()
        };
        let ends = [&pairs.first[..dense], &pairs.second[..dense]];
        let groups = PairGroups::<N>::of(ends, &pairs.reach, &pairs.damping);
        check_indices(context, sums, &groups);
        let law = LawRegisters::new(instructions, context.law, context.time_step);
        let mut batch = Batch::new(law.zero);
        let energies = EnergyRegisters::load(instructions, &FrictionEnergies::default());
        let mut kernel = ContactKernel { instructions, law, context, sums, energies, recorder };
        let springs = &mut Springs { stretch: &mut [], rolling_stretch: &mut [] };
        let mut add = |groups: &PairGroups<'_, N>| {
            let range = 0..groups.first.len();
            // SAFETY: every index is less than the number of discs.
            unsafe { kernel.add::<false, false, false>(groups, springs, &mut batch, range) }
        };
        let mut first_tier_contacts = add(&groups);
        if N == 1 {
            return;
        }
        let mut gathered = Gathered {
            first: [0; GATHERED],
            second: [0; GATHERED],
            reach: [0.0; GATHERED],
            damping: [0.0; GATHERED],
            count: 0,
        };
        for pair in near.in_contact(contacts) {
            let ends = [pairs.first[pair], pairs.second[pair]];
            let is_disc = (Ord::max(ends[0], ends[1]) as usize) < discs;
            assert!(is_disc, "a pair names a disc that does not exist");
            mask.insert(ends[0]);
            mask.insert(ends[1]);
            let at = gathered.count % GATHERED;
            [gathered.first[at], gathered.second[at]] = ends;
            (gathered.reach[at], gathered.damping[at]) = (pairs.reach[pair], pairs.damping[pair]);
            gathered.count += 1;
            first_tier_contacts += usize::from(pair < pairs.in_tiers(1));
            if gathered.count == GATHERED {
                add(&gathered.take());
            }
        }
        add(&gathered.take());
        if near.begin() == 0 {
            mask.mark_complete();
        }
        near.note_first_tier(first_tier_contacts, pairs.in_tiers(1));
    }
}
