//! The pairs of a block in tiers: those that touch or nearly do come first, then those that touch only after discs have moved.
//!
//! A pair whose gap was g when the list was built stays apart while no disc has moved by g/2. So a step looks at the first
//! few tiers alone, and at one more whenever the way of the fastest disc has grown by another share of the skin. The wider
//! the skin, the smaller the part of the list that is looked at: it costs memory, and is built seldom.

use super::found::Found;
use super::neighbours::Pairs;
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
pub(super) fn tier_of(gap: f64, skin: f64) -> u32 {
    // Below zero becomes the first.
    let tier = (gap / skin * TIERS as f64) as u32;
    if tier < TIERS as u32 { tier } else { TIERS as u32 - 1 }
}

/// Where each tier ends.
pub(super) fn ends_of(tiers: impl Iterator<Item = u32>) -> [u32; TIERS] {
    let mut ends = [0; TIERS];
    for tier in tiers {
        ends[tier as usize] += 1;
    }
    for tier in 1..TIERS {
        ends[tier] += ends[tier - 1];
    }
    ends
}

/// Makes pairs found a block's list, but for their damping: by tier, in the order found within a tier. `tiers` is memory for
/// the tier of each.
pub(super) fn sort(found: &Found, skin: f64, tiers: &mut Vec<u32>, list: &mut Pairs) {
    let count = found.pairs().len();
    tiers.clear();
    tiers.resize(count, 0);
    vector_width::run(Sorting {
        squared: found.squared(),
        touching: found.touching(),
        skin,
        tiers,
    });
    let ends = ends_of(tiers.iter().copied());
    list.resize(count, ends);
    let mut next = [0; TIERS];
    next[1..].copy_from_slice(&ends[..TIERS - 1]);
    let mut strands = Strands { quarter: ends[0] as usize / 4, strand: 0, number: 0 };
    let pairs = found.pairs().iter().zip(found.touching()).zip(&*tiers);
    for ((&[first, second], &touching), &tier) in pairs {
        let place = if tier == 0 {
            strands.next_place()
        } else {
            let next = &mut next[tier as usize];
            *next += 1;
            *next as usize - 1
        };
        list.first[place] = first;
        list.second[place] = second;
        list.reach[place] = touching;
    }
}

/// The first tier's order: the pairs of four quarters in turn. Four at a time have different discs, and a sum of forces is
/// not waited for where it goes on at once.
struct Strands {
    quarter: usize,
    strand: usize,
    number: usize,
}

impl Strands {
    fn next_place(&mut self) -> usize {
        while self.number == self.quarter && self.strand < 4 {
            (self.strand, self.number) = (self.strand + 1, 0);
        }
        // What four quarters leave over follows them.
        let place = if self.strand < 4 {
            4 * self.number + self.strand
        } else {
            4 * self.quarter + self.number
        };
        self.number += 1;
        place
    }
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
