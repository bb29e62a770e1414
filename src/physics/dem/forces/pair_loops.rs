//! The loops of the contact kernel over the pairs of a block, with and without friction.
//!
//! Without friction, pairs of the first tier are all computed, of the others only the near pairs in contact. The width is four:
//! eight pairs per register were slower (`benches/dem_speed.rs`). With friction, the width is that of the widest registers.
//!
//! # Safety
//! - Before the loops over a list, one assertion compares its largest index with the number of discs. A list from a damaged
//!   checkpoint fails that assertion.

#![allow(unsafe_code)]

use super::kernel::{BATCH, Batch, ContactKernel, PairContext, PairSums, Springs};
use crate::dem::block::{PairGroups, Pairs};
use crate::dem::laws::{NormalLaw, with_law};
use crate::dem::neighbors::near_pairs::{ContactNumbers, NearPairs};
use crate::dem::totals::{ContactMask, ContactRecorder};
use crate::simd::registers::{self, InstructionSet, Kernel};

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
pub(super) fn add_without_friction(
    context: &PairContext<'_>,
    pairs: &Pairs,
    memory: NearMemory<'_>,
    sums: &mut PairSums<'_>,
    recorder: ContactRecorder<'_>,
) {
    // The module of report pages is smaller with the same loops for both.
    let run = if cfg!(target_arch = "wasm32") || recorder.is_some() {
        run_frictionless::<true>
    } else {
        run_frictionless::<false>
    };
    run(context, pairs, memory, sums, recorder);
}

fn run_frictionless<const RECORDED: bool>(
    context: &PairContext<'_>,
    pairs: &Pairs,
    memory: NearMemory<'_>,
    sums: &mut PairSums<'_>,
    recorder: ContactRecorder<'_>,
) {
    let width = Ord::min(context.step.parameters.max_width, FRICTIONLESS_WIDTH);
    with_law!(context.step.parameters.law.normal, law => {
        let kernel = Frictionless::<_, RECORDED> { law, context, pairs, memory, sums, recorder };
        registers::run(kernel, width);
    });
}

/// Adds the forces of a block's pairs with friction; their springs advance by a step. Returns the energies of the springs,
/// dissipated by friction, and by rolling friction, J.
pub(super) fn add_with_friction(
    context: &PairContext<'_>,
    pairs: &mut Pairs,
    sums: &mut PairSums<'_>,
    recorder: ContactRecorder<'_>,
) -> [f64; 3] {
    let law = &context.step.parameters.law;
    // The module of report pages is smaller without the loops for one material; those for several give the same bits.
    let is_mixed = cfg!(target_arch = "wasm32") || law.materials.only().is_none();
    let run = match (law.has_rolling_friction(), is_mixed) {
        (false, false) => run_frictional::<false, false>,
        (false, true) => run_frictional::<false, true>,
        (true, false) => run_frictional::<true, false>,
        (true, true) => run_frictional::<true, true>,
    };
    let count = pairs.fill_registers();
    let energies = run(context, pairs, sums, recorder);
    pairs.set_len(count);
    energies
}

fn run_frictional<const ROLLING: bool, const MIXED: bool>(
    context: &PairContext<'_>,
    pairs: &mut Pairs,
    sums: &mut PairSums<'_>,
    recorder: ContactRecorder<'_>,
) -> [f64; 3] {
    with_law!(context.step.parameters.law.normal, law => {
        let kernel = Frictional::<_, ROLLING, MIXED> { law, context, pairs, sums, recorder };
        registers::run(kernel, context.step.parameters.max_width)
    })
}

/// The pairs of a list with friction.
struct Frictional<'a, 'b, L, const ROLLING: bool, const MIXED: bool> {
    law: L,
    context: &'a PairContext<'a>,
    pairs: &'a mut Pairs,
    sums: &'a mut PairSums<'b>,
    recorder: ContactRecorder<'a>,
}

impl<L: NormalLaw, const ROLLING: bool, const MIXED: bool> Kernel
    for Frictional<'_, '_, L, ROLLING, MIXED>
{
    type Output = [f64; 3];

    #[inline(always)]
    fn run<const N: usize, I: InstructionSet<N>>(self, instructions: I) -> [f64; 3] {
        let Self { law, context, pairs, sums, recorder } = self;
        // A register may hold pairs behind the tiers in scope: they are apart, and their springs are not stretched.
        let range = 0..pairs.in_tiers(context.step.scope.tiers).div_ceil(N);
        if ROLLING || L::HAS_CIRCLE {
            pairs.find_reduced_radii(context.discs.radii);
        }
        let Pairs { first, second, reach, damping, stretch, rolling_stretch, .. } = pairs;
        let groups = PairGroups::<N>::of([first, second], reach, damping).range(range);
        let springs = &mut Springs {
            reduced_radius: pairs.reduced_radius.as_chunks().0,
            stretch: stretch.as_chunks_mut().0,
            rolling_stretch: rolling_stretch.as_chunks_mut().0,
        };
        let mut kernel = ContactKernel::new(instructions, law, context, sums, recorder);
        kernel.check_indices(&groups);
        let batch = &mut Batch::new(instructions);
        // SAFETY: every index is less than the number of discs.
        unsafe { kernel.add::<true, ROLLING, MIXED>(&groups, springs, batch) };
        kernel.energies()
    }
}

/// The pairs of a block without friction.
struct Frictionless<'a, 'b, L, const RECORDED: bool> {
    law: L,
    context: &'a PairContext<'a>,
    pairs: &'a Pairs,
    memory: NearMemory<'a>,
    sums: &'a mut PairSums<'b>,
    recorder: ContactRecorder<'a>,
}

/// Near pairs in contact, gathered for a batch.
struct Gathered {
    ends: [[u16; GATHERED]; 2],
    /// Reach and damping.
    constants: [[f64; GATHERED]; 2],
    count: usize,
}

impl Gathered {
    /// Completes the last group with pairs of a disc and itself, which are not in contact; returns the groups.
    fn take<const N: usize>(&mut self) -> PairGroups<'_, N> {
        let end = self.count.next_multiple_of(N);
        self.ends.iter_mut().for_each(|column| column[self.count..end].fill(0));
        self.constants.iter_mut().for_each(|column| column[self.count..end].fill(0.0));
        self.count = 0;
        let [reach, damping] = self.constants.each_ref().map(|column| &column[..end]);
        PairGroups::of(self.ends.each_ref().map(|column| &column[..end]), reach, damping)
    }
}

impl<L: NormalLaw, const RECORDED: bool> Kernel for Frictionless<'_, '_, L, RECORDED> {
    type Output = ();

    #[inline(always)]
    fn run<const N: usize, I: InstructionSet<N>>(self, instructions: I) {
        let Self { law, context, pairs, memory, sums, recorder } = self;
        let recorder = if RECORDED { recorder } else { None };
        let NearMemory { near, contacts, mask } = memory;
        let (scope, discs) = (&context.step.scope, context.discs.positions.len());
        // At width 1 all pairs are compared, which checks the near pairs of the wider registers.
        let dense = if N == 1 {
            pairs.in_tiers(scope.tiers)
        } else {
            near.find_contacts(instructions, pairs, context.discs.positions, scope, contacts);
            near.begin()
        };
        let ends = [&pairs.first[..dense], &pairs.second[..dense]];
        let groups = PairGroups::<N>::of(ends, &pairs.reach, &pairs.damping);
        let mut kernel = ContactKernel::new(instructions, law, context, sums, recorder);
        kernel.check_indices(&groups);
        let batch = &mut Batch::new(instructions);
        let springs =
            &mut Springs { reduced_radius: &[], stretch: &mut [], rolling_stretch: &mut [] };
        let mut add = |groups: &PairGroups<'_, N>| {
            // SAFETY: every index is less than the number of discs.
            unsafe { kernel.add::<false, false, false>(groups, springs, batch) }
        };
        let mut first_tier_contacts = add(&groups);
        if N == 1 {
            return;
        }
        let (ends, constants) = ([[0; GATHERED]; 2], [[0.0; GATHERED]; 2]);
        let mut gathered = Gathered { ends, constants, count: 0 };
        for pair in near.in_contact(contacts) {
            let ends = [pairs.first[pair], pairs.second[pair]];
            let is_disc = usize::from(Ord::max(ends[0], ends[1])) < discs;
            assert!(is_disc, "a pair names a disc that does not exist");
            mask.insert(ends[0].into());
            mask.insert(ends[1].into());
            let at = gathered.count % GATHERED;
            [gathered.ends[0][at], gathered.ends[1][at]] = ends;
            [gathered.constants[0][at], gathered.constants[1][at]] =
                [pairs.reach[pair], pairs.damping[pair]];
            gathered.count += 1;
            first_tier_contacts += usize::from(pair < pairs.in_tiers(1));
            if gathered.count == GATHERED {
                add(&gathered.take());
            }
        }
        add(&gathered.take());
        if near.begin() == 0 {
            mask.is_complete = true;
        }
        near.note_first_tier(first_tier_contacts, pairs.in_tiers(1));
    }
}
