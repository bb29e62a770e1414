//! Pairs that may come into contact within the next steps: a wide skin lists many pairs that cannot.
//!
//! A pair with a gap g stays apart while no disc has moved by g/2. Therefore, all pairs of the tiers in scope are compared only
//! once per horizon; until the fastest discs may have moved by the horizon, only those are compared whose gap was less than twice
//! the horizon. They keep the order of the list, so sums of forces have the same bits with and without.
//!
//! # Safety
//! - Every index is compared with the number of positions before a loop that does not check it.

#![allow(unsafe_code)]

use crate::dem::block::{PairGroups, Pairs, TIERS};
use crate::dem::motion;
use crate::dem::neighbors::tiers::Scope;
use crate::simd::registers::{InstructionSet, MAX_WIDTH, Mask};
use std::ops::Range;

/// The near pairs of a block. They are not part of the state.
#[derive(Clone, Debug, Default)]
pub(crate) struct NearPairs {
    validity: Validity,
    /// Pairs of the list before this one are not compared here, because most of them are in contact.
    begin: usize,
    /// The end of the compared range if near pairs are not copied.
    end_of_range: Option<usize>,
    /// Positions in the list.
    numbers: Vec<u32>,
    /// Indices of the near pairs' discs and r_i + r_j, m; filled up to whole registers with pairs of a disc and itself.
    first: Vec<u16>,
    second: Vec<u16>,
    reach: Vec<f64>,
    /// The largest index in these columns.
    max_index: usize,
    /// Whether less than half of the list's first tier is in contact; then near pairs include that tier.
    is_sparse: bool,
}

/// The near pairs of a block that are in contact: memory that blocks share.
#[derive(Clone, Debug, Default)]
pub(crate) struct ContactNumbers {
    /// Numbers among the near pairs, followed by unused room.
    numbers: Vec<u32>,
    count: usize,
}

/// The horizon over the skin.
const HORIZON: f64 = 1.0 / TIERS as f64;
/// Pairs per store of selected numbers.
const STORED: usize = 8;

/// How long near pairs are valid; by default they are not.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Validity {
    /// The number of their list, and the displacement of the fastest discs, m, at which they expire.
    list_and_displacement: Option<(u64, f64)>,
}

impl Validity {
    /// Whether the near pairs hold for the lists and displacements of a scope.
    pub(crate) fn holds_for(&self, scope: &Scope) -> bool {
        self.list_and_displacement
            .is_some_and(|(list, limit)| list == scope.list && scope.displacement < limit)
    }

    /// The validity of near pairs found now.
    pub(crate) fn until_horizon(scope: &Scope) -> Self {
        let limit = scope.displacement + horizon(scope).0;
        Self { list_and_displacement: Some((scope.list, limit)) }
    }
}

/// The horizon, and the gap up to which pairs are near, m.
pub(crate) fn horizon(scope: &Scope) -> (f64, f64) {
    let horizon = HORIZON * scope.skin;
    // Gaps are rounded in their last digits.
    (horizon, 2.000_001 * horizon)
}

impl NearPairs {
    /// Pairs of the list before this one are not among the near pairs. A multiple of the register's width.
    pub(crate) fn begin(&self) -> usize {
        self.begin
    }

    /// Positions in the list of the pairs in contact, in its order; a few at its end may be apart.
    pub(crate) fn in_contact(&self, contacts: &ContactNumbers) -> impl Iterator<Item = usize> {
        let numbers = contacts.numbers[..contacts.count].iter().map(|&number| number as usize);
        numbers.map(|number| match self.end_of_range {
            Some(_) => self.begin + number,
            None => self.numbers[number] as usize,
        })
    }

    /// Notes how many pairs of the first tier are in contact.
    pub(crate) fn note_first_tier(&mut self, contacts: usize, pairs: usize) {
        let is_sparse = 2 * contacts < pairs;
        if is_sparse != self.is_sparse {
            (self.is_sparse, self.validity) = (is_sparse, Validity::default());
        }
    }

    /// Finds the near pairs that are in contact; first the near pairs, if those found before have expired.
    #[inline(always)]
    pub(crate) fn find_contacts<const N: usize, I: InstructionSet<N>>(
        &mut self,
        instructions: I,
        pairs: &Pairs,
        positions: &[[f64; 2]],
        scope: &Scope,
        contacts: &mut ContactNumbers,
    ) {
        if !self.validity.holds_for(scope) {
            self.find_near(instructions, pairs, positions, scope, contacts);
        }
        let (groups, rest) = match self.end_of_range {
            Some(end) => groups_of(pairs, self.begin..end),
            None => (PairGroups::of([&self.first, &self.second], &self.reach, &[]), 0..0),
        };
        let max_index = self.end_of_range.map_or(self.max_index, |_| groups.max_index());
        assert!(max_index < positions.len(), "a pair names a disc that does not exist");
        // SAFETY: every index is less than the number of positions.
        unsafe { list_closer(instructions, &groups, positions, 0.0, contacts) };
        for pair in rest {
            // There is room behind the numbers that count.
            contacts.numbers[contacts.count] = (pair - self.begin) as u32;
            contacts.count += 1;
        }
    }

    /// Finds the pairs whose gap is less than twice the horizon.
    #[inline(always)]
    fn find_near<const N: usize, I: InstructionSet<N>>(
        &mut self,
        instructions: I,
        pairs: &Pairs,
        positions: &[[f64; 2]],
        scope: &Scope,
        found: &mut ContactNumbers,
    ) {
        let (horizon, margin) = horizon(scope);
        let end = pairs.in_tiers(scope.tiers_within(horizon));
        let first_tier = pairs.in_tiers(1);
        self.begin = if self.is_sparse { 0 } else { first_tier - first_tier % N };
        self.validity = Validity::until_horizon(scope);
        self.numbers.clear();
        self.end_of_range = scope.spares_memory.then_some(end);
        if scope.spares_memory {
            return;
        }
        let (groups, rest) = groups_of::<N>(pairs, self.begin..end);
        assert!(groups.max_index() < positions.len(), "a pair names a disc that does not exist");
        // SAFETY: every index is less than the number of positions.
        unsafe { list_closer(instructions, &groups, positions, margin, found) };
        make_room(&mut self.numbers, found.count + rest.len());
        let found = &found.numbers[..found.count];
        self.numbers.extend(found.iter().map(|&number| number + self.begin as u32));
        self.numbers.extend(rest.map(|pair| pair as u32));
        self.copy_columns(pairs);
    }

    /// Copies the near pairs' columns out of the list.
    fn copy_columns(&mut self, pairs: &Pairs) {
        fn sized<T: Copy + Default>(column: &mut Vec<T>, length: usize) {
            column.clear();
            make_room(column, length);
            column.resize(length, T::default());
        }
        let length = self.numbers.len().next_multiple_of(MAX_WIDTH);
        sized(&mut self.first, length);
        sized(&mut self.second, length);
        sized(&mut self.reach, length);
        let columns = self.first.iter_mut().zip(&mut self.second).zip(&mut self.reach);
        for (((first, second), reach), &number) in columns.zip(&self.numbers) {
            let number = number as usize;
            (*first, *second) = (pairs.first[number], pairs.second[number]);
            *reach = pairs.reach[number];
        }
        self.max_index =
            PairGroups::<MAX_WIDTH>::of([&self.first, &self.second], &[], &[]).max_index();
    }
}

/// Reserves room for as many values and an eighth more, because their number differs each time.
fn make_room<T>(column: &mut Vec<T>, values: usize) {
    if column.capacity() < values {
        // Old values need not be moved.
        *column = Vec::with_capacity(values + values / 8);
    }
}

/// The groups of a range of pairs, and the pairs at its end that do not fill a register.
fn groups_of<const N: usize>(
    pairs: &Pairs,
    range: Range<usize>,
) -> (PairGroups<'_, N>, Range<usize>) {
    let rest = range.end - range.len() % N..range.end;
    let ends = [&pairs.first[range.clone()], &pairs.second[range.clone()]];
    (PairGroups::of(ends, &pairs.reach[range], &[]), rest)
}

/// Lists the numbers of the pairs whose gap is less than a margin, m.
///
/// # Safety
/// - Every index is less than the number of positions.
#[inline(always)]
unsafe fn list_closer<const N: usize, I: InstructionSet<N>>(
    instructions: I,
    groups: &PairGroups<'_, N>,
    positions: &[[f64; 2]],
    margin: f64,
    into: &mut ContactNumbers,
) {
    // Eight numbers are written at a time, even if fewer count.
    let room = groups.first.len() * N + 2 * STORED;
    if into.numbers.len() < room {
        into.numbers.resize(room, 0);
    }
    let mut count = 0;
    let margin = instructions.splat(margin);
    let mut columns = groups.first.iter().zip(groups.second).zip(groups.reach);
    for number in (0..(groups.first.len() * N) as u32).step_by(STORED) {
        let mut selected = 0;
        for part in 0..STORED / N {
            let Some(((first, second), reach)) = columns.next() else { break };
            // SAFETY: the caller checked the indices.
            let separation = unsafe { instructions.differences(positions, [first, second]) };
            let reach = instructions.load(reach) + margin;
            let is_near = motion::is_closer(motion::distance_squared(separation), reach);
            selected |= is_near.bits() << (part * N);
        }
        // All numbers are stored before it is known which of them count, so there is no branch to predict.
        let Some(place) = into.numbers.get_mut(count..).and_then(|rest| rest.first_chunk_mut())
        else {
            break;
        };
        instructions.store_selected_numbers(number, selected, place);
        count += selected.count_ones() as usize;
    }
    into.count = count;
}
