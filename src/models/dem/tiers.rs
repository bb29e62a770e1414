//! The pairs of a block in tiers: those that touch or nearly do come first, then those that touch only after discs have moved.
//!
//! A pair whose gap was g when the list was built stays apart while no disc has moved by g/2. So a step looks at the first
//! few tiers alone, and at one more whenever the way of the fastest disc has grown by another share of the skin. The wider
//! the skin, the smaller the part of the list that is looked at: it costs memory, and is built seldom.

use super::found::Found;
use crate::vector_width::{self, Kernel};

/// Tiers, each of an equal share of the skin; the first holds all that touch as well.
pub(super) const TIERS: usize = 16;

/// The tiers that hold every pair that can touch where no disc has moved further than `moved`, in m, since the list was
/// built with a skin.
pub(super) fn in_reach(moved: f64, skin: f64) -> usize {
    // Gaps are rounded in their last digits.
    let begun = 2.000_001 * moved / skin * TIERS as f64;
    Ord::min(begun as usize + 1, TIERS)
}

/// The tier of a gap, in m, in a list with a skin.
#[inline(always)]
fn tier_of(gap: f64, skin: f64) -> u32 {
    // Below zero becomes the first.
    let tier = (gap / skin * TIERS as f64) as u32;
    if tier < TIERS as u32 { tier } else { TIERS as u32 - 1 }
}

/// Sorts pairs by their tiers; in a tier they keep the order in which they were found.
#[derive(Default)]
pub(super) struct Sorter {
    tiers: Vec<u32>,
    order: Vec<u32>,
    strands: Vec<u32>,
}

impl Sorter {
    /// Finds the order of the pairs found, and where each tier ends.
    pub(super) fn sort(&mut self, found: &Found, skin: f64) -> [u32; TIERS] {
        let (squared, touching) = (found.squared(), found.touching());
        self.tiers.resize(squared.len(), 0);
        self.order.resize(squared.len(), 0);
        vector_width::run(Sorting { squared, touching, skin, tiers: &mut self.tiers });
        // Where the next pair of each tier goes, and in the end where the tier ends.
        let mut ends = [0; TIERS];
        let mut begin = 0;
        for (end, count) in ends.iter_mut().zip(counts(&self.tiers)) {
            (*end, begin) = (begin, begin + count);
        }
        for (number, &tier) in (0..).zip(&self.tiers) {
            let next = &mut ends[tier as usize];
            self.order[*next as usize] = number;
            *next += 1;
        }
        ends
    }

    /// Puts the pairs of the first tier, which ends at `end`, into another order: four quarters in turn, then what they leave
    /// over. Four at a time have different discs, and a sum of forces is not waited for where it goes on at once.
    pub(super) fn deal_to_strands(&mut self, end: u32) {
        let quarter = end as usize / 4;
        let dealt = &mut self.order[..4 * quarter];
        self.strands.clear();
        self.strands.extend_from_slice(dealt);
        for (strand, numbers) in self.strands.chunks_exact(Ord::max(quarter, 1)).enumerate() {
            for (places, &number) in dealt.as_chunks_mut::<4>().0.iter_mut().zip(numbers) {
                places[strand] = number;
            }
        }
    }

    /// For each place, which of the pairs found comes there.
    pub(super) fn order(&self) -> &[u32] {
        &self.order
    }
}

/// How many pairs each tier has.
fn counts(tiers: &[u32]) -> [u32; TIERS] {
    // Two counters of each: a count need not wait for the one before.
    let mut counts = [[0; TIERS]; 2];
    let (pairs, last) = tiers.as_chunks::<2>();
    for &[one, other] in pairs {
        counts[0][one as usize] += 1;
        counts[1][other as usize] += 1;
    }
    for &tier in last {
        counts[0][tier as usize] += 1;
    }
    std::array::from_fn(|tier| counts[0][tier] + counts[1][tier])
}

/// Finds the tiers of pairs.
struct Sorting<'a> {
    squared: &'a [f64],
    touching: &'a [f64],
    skin: f64,
    tiers: &'a mut [u32],
}

impl Kernel for Sorting<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let gaps = self.squared.iter().zip(self.touching);
        for (tier, (&squared, &touching)) in self.tiers.iter_mut().zip(gaps) {
            *tier = tier_of(squared.sqrt() - touching, self.skin);
        }
    }
}
