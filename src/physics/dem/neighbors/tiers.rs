//! The pairs of a block in tiers of increasing gap: pairs in or near contact come first.
//!
//! A pair whose gap was g when the list was built stays apart while no disc has moved by g/2. Therefore, a step visits only the
//! first tiers, and one more whenever the displacement of the fastest disc has grown by another fraction of the skin. The wider
//! the skin, the smaller the visited part of the list: a wide skin costs memory, and lists are built less often.

use crate::dem::block::TIERS;
use crate::simd::registers::vectorized;
use serde::{Deserialize, Serialize};

/// The part of the lists and of the box that a step must visit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Scope {
    /// Bound of the displacement of any disc since the lists were built, m.
    pub(crate) moved: f64,
    /// Sum of the largest displacements of all steps since the lists were built, m.
    #[serde(skip)]
    pub(crate) displacement: f64,
    /// The number of the lists.
    #[serde(skip)]
    pub(crate) list: u64,
    /// Tiers that have pairs which may be, or may have been, in contact.
    pub(crate) tiers: usize,
    /// Displacement up to which every disc is inside the box: the distance of the nearest center to a closed side when the lists
    /// were built, m.
    pub(crate) clearance: f64,
    /// Distance beyond contact up to which pairs are listed, m.
    pub(crate) skin: f64,
    /// Whether there are so many discs that copies of near pairs would take too much memory.
    #[serde(skip)]
    pub(crate) spares_memory: bool,
}

impl Scope {
    /// Tiers that have pairs which may come into contact before the fastest discs have moved by a distance, in m.
    pub(crate) fn tiers_within(&self, distance: f64) -> usize {
        if self.tiers == TIERS {
            return TIERS;
        }
        Ord::max(self.tiers, in_reach(self.moved + distance, self.skin))
    }
}

/// The number of leading tiers that contain every pair which may be in contact, if no disc has moved further than `moved`, in m,
/// since the list was built with a skin.
pub(crate) fn in_reach(moved: f64, skin: f64) -> usize {
    // Gaps are rounded in their last digits.
    let begun = 2.000_001 * moved / skin * TIERS as f64;
    // The cast saturates for a displacement that is far too large.
    Ord::min(begun as usize, TIERS - 1) + 1
}

/// The tier of a gap, in m, in a list with a skin.
#[inline(always)]
fn tier_of(gap: f64, skin: f64) -> u8 {
    let tier = (gap / skin * TIERS as f64) as i32;
    // Discs that overlap belong to the first.
    Ord::clamp(tier, 0, TIERS as i32 - 1) as u8
}

vectorized! {
    /// Finds the tiers of pairs by their squared distances, m^2, and their reach r_i + r_j, m.
    pub(crate) fn find(
        squared: &[f64],
        reach: &[f64],
        skin: f64,
        tiers: &mut [u8],
    ) -> () {
        for (tier, (&squared, &reach)) in tiers.iter_mut().zip(squared.iter().zip(reach)) {
            *tier = tier_of(squared.sqrt() - reach, skin);
        }
    }
}

/// Sorts pairs by tier; within a tier they keep the order in which they were found.
#[derive(Debug, Default)]
pub(crate) struct Sorter {
    order: Vec<u32>,
    quarters: Vec<u32>,
}

/// Parts of a list that are counted and sorted in turn, so that a pair does not wait for the counter of the one before.
const PARTS: usize = 4;

impl Sorter {
    /// Finds the order of pairs, and the end of each tier.
    pub(crate) fn sort(&mut self, tiers: &[u8]) -> [u32; TIERS] {
        let length = tiers.len() / PARTS;
        let (parts, rest) = tiers.split_at(PARTS * length);
        let parts: [&[u8]; PARTS] =
            std::array::from_fn(|part| &parts[part * length..(part + 1) * length]);
        // The place of the next pair of each part and tier. The remainder belongs to the last part.
        let mut next = [[0_u32; TIERS]; PARTS];
        for number in 0..length {
            for (counts, tiers) in next.iter_mut().zip(parts) {
                counts[usize::from(tiers[number]) % TIERS] += 1;
            }
        }
        for &tier in rest {
            next[PARTS - 1][usize::from(tier) % TIERS] += 1;
        }
        let mut end = 0;
        let mut begin_next = |count: &mut u32| {
            end += *count;
            *count = end - *count;
            end
        };
        let ends = std::array::from_fn(|tier| {
            next.each_mut().map(|counts| begin_next(&mut counts[tier]))[PARTS - 1]
        });
        self.order.resize(tiers.len(), 0);
        let mut place = |part: usize, number: usize, tier: u8| {
            let next = &mut next[part][usize::from(tier) % TIERS];
            self.order[*next as usize] = number as u32;
            *next += 1;
        };
        for number in 0..length {
            for (part, tiers) in parts.into_iter().enumerate() {
                place(part, part * length + number, tiers[number]);
            }
        }
        for (number, &tier) in rest.iter().enumerate() {
            place(PARTS - 1, PARTS * length + number, tier);
        }
        ends
    }

    /// Interleaves the four quarters of the first tier, which ends at `end`; the remainder follows. Four successive pairs then
    /// have different discs, so that no addition to a force waits for the one before.
    pub(crate) fn interleave_quarters(&mut self, end: u32) {
        let quarter = end as usize / 4;
        let interleaved = &mut self.order[..4 * quarter];
        self.quarters.clear();
        self.quarters.extend_from_slice(interleaved);
        for (quarter_number, numbers) in
            self.quarters.chunks_exact(Ord::max(quarter, 1)).enumerate()
        {
            for (places, &number) in interleaved.as_chunks_mut::<4>().0.iter_mut().zip(numbers) {
                places[quarter_number] = number;
            }
        }
    }

    /// For each place in the list, the number of the pair found.
    pub(crate) fn order(&self) -> &[u32] {
        &self.order
    }
}
