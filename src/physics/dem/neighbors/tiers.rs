//! The pairs of a block in tiers: those that touch or nearly do come first, then those that touch only after discs have moved.
//!
//! A pair whose gap was g when the list was built stays apart while no disc has moved by g/2. So a step looks at the first
//! few tiers alone, and at one more whenever the way of the fastest disc has grown by another share of the skin. The wider
//! the skin, the smaller the part of the list that is looked at: it costs memory, and is built seldom.

use crate::simd::dispatch::{self, Kernel};

/// Tiers, each of an equal share of the skin; the first holds all that touch as well.
pub(in crate::dem) const TIERS: usize = 16;

/// The tiers that hold every pair that can touch where no disc has moved further than `moved`, in m, since the list was
/// built with a skin.
pub(in crate::dem) fn in_reach(moved: f64, skin: f64) -> usize {
    // Gaps are rounded in their last digits.
    let begun = 2.000_001 * moved / skin * TIERS as f64;
    Ord::min(begun as usize + 1, TIERS)
}

/// The tier of a gap, in m, in a list with a skin.
#[inline(always)]
fn tier_of(gap: f64, skin: f64) -> u8 {
    let tier = (gap / skin * TIERS as f64) as i32;
    // Discs that overlap belong to the first.
    Ord::clamp(tier, 0, TIERS as i32 - 1) as u8
}

/// Finds the tiers of pairs by the squares of their distances, m^2, and the distances at which they touch, m.
pub(in crate::dem) fn find([squared, touching]: [&[f64]; 2], skin: f64, tiers: &mut [u8]) {
    dispatch::run(Tiers { squared, touching, skin, tiers });
}

struct Tiers<'a> {
    squared: &'a [f64],
    touching: &'a [f64],
    skin: f64,
    tiers: &'a mut [u8],
}

impl Kernel for Tiers<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let gaps = self.squared.iter().zip(self.touching);
        for (tier, (&squared, &touching)) in self.tiers.iter_mut().zip(gaps) {
            *tier = tier_of(squared.sqrt() - touching, self.skin);
        }
    }
}

/// Sorts pairs by their tiers; in a tier they keep the order in which they were found.
#[derive(Default)]
pub(in crate::dem) struct Sorter {
    order: Vec<u32>,
    strands: Vec<u32>,
}

/// Parts of a list that are counted and sorted side by side: what is written to a counter is not waited for by the next pair.
const PARTS: usize = 4;

impl Sorter {
    /// Finds the order of pairs, and where each tier ends.
    pub(in crate::dem) fn sort(&mut self, tiers: &[u8]) -> [u32; TIERS] {
        let length = tiers.len() / PARTS;
        let (parts, rest) = tiers.split_at(PARTS * length);
        let parts: [&[u8]; PARTS] =
            std::array::from_fn(|part| &parts[part * length..(part + 1) * length]);
        // Where the next pair of each part and tier goes. What four parts leave over belongs to the last of them.
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

    /// Puts the pairs of the first tier, which ends at `end`, into another order: four quarters in turn, then what they leave
    /// over. Four at a time have different discs, and a sum of forces is not waited for where it goes on at once.
    pub(in crate::dem) fn deal_to_strands(&mut self, end: u32) {
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
    pub(in crate::dem) fn order(&self) -> &[u32] {
        &self.order
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_side_by_side_give_the_order_of_a_stable_sort() {
        for length in 0..100_u32 {
            let tier = |number: u32| (number * number % 23 % TIERS as u32) as u8;
            let tiers: Vec<u8> = (0..length).map(tier).collect();
            let mut sorted: Vec<u32> = (0..length).collect();
            sorted.sort_by_key(|&number| tier(number));
            let mut sorter = Sorter::default();
            let ends = sorter.sort(&tiers);
            assert_eq!(sorter.order(), sorted);
            for (tier, &end) in (0..).zip(&ends) {
                assert_eq!(tiers.iter().filter(|&&other| other <= tier).count(), end as usize);
            }
        }
    }

    #[test]
    fn strands_take_turns() {
        let mut sorter = Sorter { order: (0..12).collect(), strands: Vec::new() };
        sorter.deal_to_strands(10);
        // Quarters of two, dealt out; two are left over, and two belong to another tier.
        assert_eq!(sorter.order(), [0, 2, 4, 6, 1, 3, 5, 7, 8, 9, 10, 11]);
    }
}
