//! Pairs found while a block's list is built, several discs at a time with SIMD instructions.
//!
//! Sums, products and comparisons are the same at every width; therefore, so are the lists (a test compares them).

use crate::dem::discs::Discs;
use crate::dem::motion;
use crate::dem::neighbors::tiers;
use crate::simd::registers::{self, InstructionSet, Mask, RegisterKernel, Scalar};
use std::ops::Range;

/// Partners per comparison, and the width of its registers.
const PARTNERS: usize = 4;

/// Number of box lengths along each axis by which a disc is shifted.
pub(in crate::dem) type ImageShift = [i8; 2];

/// A disc and up to four adjacent discs that it is compared with.
#[derive(Clone, Copy, Default)]
struct Comparison {
    /// The disc, and the first of its partners.
    ends: [u32; 2],
    /// End of the partners.
    stop: u32,
    shift: ImageShift,
}

/// Comparisons to be made, in order. Room is reserved ahead, and a comparison is written before it is known whether it counts, so
/// there is no branch to predict.
#[derive(Default)]
pub(in crate::dem) struct Comparisons {
    comparisons: Vec<Comparison>,
    count: usize,
}

/// The pairs found, column by column, in the order in which they were found. Room is reserved ahead here as well.
#[derive(Default)]
pub(in crate::dem) struct PairBuffer {
    /// The disc, counted from the block's first disc, and its partner, counted from the first disc of the search space.
    pairs: Vec<[u32; 2]>,
    /// r_i + r_j, m.
    reach: Vec<f64>,
    tiers: Vec<u8>,
    /// Squared distances, m^2, of the pairs whose tiers are not yet known.
    distance_squared: Vec<f64>,
    /// Shifts of the partners; empty if none is shifted.
    shifts: Vec<ImageShift>,
    count: usize,
}

/// The discs among which pairs are searched.
#[derive(Clone, Copy)]
pub(in crate::dem) struct SearchSpace<'a> {
    pub(in crate::dem) discs: &'a Discs,
    /// Distance beyond contact up to which pairs are listed, m.
    pub(in crate::dem) skin: f64,
    /// The discs that the block's discs and their partners are counted from.
    pub(in crate::dem) counted_from: [usize; 2],
    /// Sides of the box, m.
    pub(in crate::dem) sides: [f64; 2],
}

impl Comparisons {
    pub(in crate::dem) fn len(&self) -> usize {
        self.count
    }

    /// Adds the comparisons of a disc with adjacent partners, of which there may be none. The range must not end before it begins.
    #[inline]
    pub(in crate::dem) fn add(&mut self, disc: u32, partners: Range<u32>, shift: ImageShift) {
        let Range { start, end: stop } = partners;
        let count = (stop - start + PARTNERS as u32 - 1) as usize / PARTNERS;
        // Two are written even if fewer count.
        let end = self.count + count + 2;
        if self.comparisons.len() < end {
            self.comparisons.resize(2 * end, Comparison::default());
        }
        let comparison = |first: u32| Comparison { ends: [disc, first], stop, shift };
        let room = &mut self.comparisons[self.count..];
        // Mostly one or two.
        if let Some(room) = room.first_chunk_mut::<2>() {
            *room = [comparison(start), comparison(start + PARTNERS as u32)];
        }
        if count > 2 {
            let firsts = (start..stop).step_by(PARTNERS);
            for (place, first) in room.iter_mut().zip(firsts).skip(2) {
                *place = comparison(first);
            }
        }
        self.count += count;
    }
}

impl SearchSpace<'_> {
    /// The vector, in m, of a shift.
    #[inline(always)]
    pub(in crate::dem) fn vector(&self, shift: ImageShift) -> [f64; 2] {
        [0, 1].map(|axis: usize| f64::from(shift[axis]) * self.sides[axis])
    }
}

impl PairBuffer {
    pub(in crate::dem) fn clear(&mut self) {
        self.count = 0;
        self.shifts.clear();
        self.tiers.clear();
    }

    pub(in crate::dem) fn pairs(&self) -> &[[u32; 2]] {
        &self.pairs[..self.count]
    }

    pub(in crate::dem) fn reach(&self) -> &[f64] {
        &self.reach[..self.count]
    }

    pub(in crate::dem) fn tiers(&self) -> &[u8] {
        &self.tiers
    }

    pub(in crate::dem) fn shifts(&self) -> &[ImageShift] {
        &self.shifts
    }

    /// Makes the comparisons, keeps the pairs closer than contact plus the skin, and empties the comparisons. With `SHIFTED`,
    /// partners may be images beyond periodic sides.
    pub(in crate::dem) fn take<const SHIFTED: bool>(
        &mut self,
        comparisons: &mut Comparisons,
        space: &SearchSpace<'_>,
    ) {
        let before = self.count;
        let found = self.compare::<SHIFTED>(comparisons, space, PARTNERS);
        comparisons.count = 0;
        self.tiers.resize(self.count, 0);
        let gaps = [&self.distance_squared[..found], &self.reach[before..self.count]];
        tiers::find(gaps, space.skin, &mut self.tiers[before..]);
    }

    /// Makes the comparisons in registers of at most `max_width` numbers, and returns the number of pairs found.
    fn compare<const SHIFTED: bool>(
        &mut self,
        comparisons: &Comparisons,
        space: &SearchSpace<'_>,
        max_width: usize,
    ) -> usize {
        let comparisons = &comparisons.comparisons[..comparisons.count];
        let Self { pairs, reach, distance_squared, shifts, count, .. } = self;
        // Whole registers are written, even if fewer pairs count.
        let room = (comparisons.len() + 1) * PARTNERS;
        if distance_squared.len() < room {
            distance_squared.resize(room, 0.0);
        }
        let end = *count + room;
        if pairs.len() < end {
            pairs.resize(end + end / 4, [0; 2]);
            reach.resize(end + end / 4, 0.0);
        }
        let room = *count..end;
        let (pairs, reach) = (&mut pairs[room.clone()], &mut reach[room]);
        let room = Room { pairs, reach, distance_squared, shifts };
        let found = registers::run(Compare::<SHIFTED> { comparisons, space, room }, max_width);
        *count += found;
        found
    }
}

/// Room for the pairs of some comparisons.
struct Room<'a> {
    pairs: &'a mut [[u32; 2]],
    reach: &'a mut [f64],
    distance_squared: &'a mut [f64],
    shifts: &'a mut Vec<ImageShift>,
}

/// The loop over comparisons.
struct Compare<'a, const SHIFTED: bool> {
    comparisons: &'a [Comparison],
    space: &'a SearchSpace<'a>,
    room: Room<'a>,
}

impl<const SHIFTED: bool> RegisterKernel for Compare<'_, SHIFTED> {
    /// The number of pairs found.
    type Output = usize;

    #[inline(always)]
    fn run<const N: usize, I: InstructionSet<N>>(self, instructions: I) -> usize {
        let Self { comparisons, space, mut room } = self;
        let positions = space.discs.positions.as_slice();
        // Columns of one length, so that an index is checked once.
        let radii = &space.discs.radii[..positions.len()];
        let mut count = 0;
        for comparison in comparisons {
            let shift = if SHIFTED { space.vector(comparison.shift) } else { [0.0; 2] };
            let found = count;
            let Comparison { ends: [disc, first], stop, .. } = *comparison;
            let stop = Ord::min(stop, first + PARTNERS as u32);
            for group in 0..PARTNERS.div_ceil(N) as u32 {
                let first = first + group * N as u32;
                let partners = first as usize..first as usize + N;
                let centers = positions.get(partners.clone()).and_then(|part| part.first_chunk());
                let radii_of = radii.get(partners).and_then(|part| part.first_chunk());
                if let (Some(centers), Some(partner_radii)) = (centers, radii_of) {
                    let partners = Partners { disc, first, stop, shift, centers, partner_radii };
                    count += partners.compare::<I, SHIFTED>(instructions, space, &mut room, count);
                } else {
                    // The last discs in memory do not fill a register.
                    for first in first..stop {
                        let center = &[positions[first as usize]];
                        let radius = &[radii[first as usize]];
                        let partners = Partners {
                            disc,
                            first,
                            stop,
                            shift,
                            centers: center,
                            partner_radii: radius,
                        };
                        count += partners.compare::<_, SHIFTED>(Scalar, space, &mut room, count);
                    }
                    break;
                }
            }
            if SHIFTED {
                room.shifts.extend(std::iter::repeat_n(comparison.shift, count - found));
            }
        }
        count
    }
}

/// A disc and the partners that it is compared with at a time.
struct Partners<'a, const N: usize> {
    disc: u32,
    first: u32,
    stop: u32,
    /// Added to the partners' centers, m.
    shift: [f64; 2],
    centers: &'a [[f64; 2]; N],
    partner_radii: &'a [f64; N],
}

impl<const N: usize> Partners<'_, N> {
    /// Writes the pairs found from number `count` on, and returns how many they are.
    #[inline(always)]
    fn compare<I: InstructionSet<N>, const SHIFTED: bool>(
        &self,
        instructions: I,
        space: &SearchSpace<'_>,
        room: &mut Room<'_>,
        count: usize,
    ) -> usize {
        let Self { disc, first, stop, shift, centers, partner_radii } = *self;
        let [mut other_x, mut other_y] = instructions.columns(centers);
        if SHIFTED {
            other_x = other_x + instructions.splat(shift[0]);
            other_y = other_y + instructions.splat(shift[1]);
        }
        let [x, y] = space.discs.positions[disc as usize].map(|part| instructions.splat(part));
        let separation = [x - other_x, y - other_y];
        let distance_squared = motion::distance_squared(separation);
        let radius = instructions.splat(space.discs.radii[disc as usize]);
        let reach = radius + instructions.load(partner_radii);
        let is_near = motion::is_closer(distance_squared, reach + instructions.splat(space.skin));
        // Partners from the end on do not count.
        let partners = (1 << Ord::min(stop.saturating_sub(first), N as u32)) - 1;
        let near = is_near.bits() & partners;
        let columns =
            (room.pairs[count..].first_chunk_mut(), room.reach[count..].first_chunk_mut());
        let squares = room.distance_squared[count..].first_chunk_mut();
        let ((Some(pairs), Some(reaches)), Some(squares)) = (columns, squares) else {
            unreachable!("there is room for whole registers")
        };
        let from = space.counted_from.map(|disc| disc as u32);
        instructions.store_selected_pairs([disc - from[0], first - from[1]], near, pairs);
        instructions.store_selected(reach, near, reaches);
        instructions.store_selected(distance_squared, near, squares);
        near.count_ones() as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dem::discs::Disc;

    /// Discs at evenly spread positions: multiples of irrational numbers (Weyl 1916).
    fn discs(count: u32) -> Discs {
        let mut discs = Discs::default();
        for id in 0..count {
            let part = |root: f64| (f64::from(id) * root.sqrt()).fract();
            discs.push(&Disc {
                id,
                position: [10.0 * part(2.0), 10.0 * part(3.0)],
                velocity: [0.0; 2],
                radius: 0.5 + part(5.0),
                mass: 1.0,
                material: 0,
            });
        }
        discs
    }

    #[test]
    fn pairs_do_not_depend_on_the_register_width() {
        const COUNT: u32 = 203;
        let discs = discs(COUNT);
        let mut comparisons = Comparisons::default();
        let mut compared = 0;
        for disc in 3..COUNT {
            for length in 0..12 {
                let partners = Ord::min(disc + 1, COUNT)..Ord::min(disc + 1 + length, COUNT);
                compared += partners.len();
                comparisons.add(disc, partners, [(disc % 3) as i8 - 1, (length % 3) as i8 - 1]);
            }
        }
        let space =
            SearchSpace { discs: &discs, skin: 2.0, counted_from: [3, 1], sides: [3.0, 4.0] };
        let near = [found::<false>(&comparisons, &space), found::<true>(&comparisons, &space)];
        // Pairs within contact and skin, 2 to 5 in a box of 10, are many, but not all.
        assert!(near.iter().all(|&near| near > 1000 && near < compared - 1000), "{near:?}");
        assert!(near[0] != near[1]);
    }

    /// The number of pairs found, which is the same at every width.
    fn found<const SHIFTED: bool>(comparisons: &Comparisons, space: &SearchSpace<'_>) -> usize {
        let (mut wide, mut single) = (PairBuffer::default(), PairBuffer::default());
        // Twice, as for a second column of cells.
        for _ in 0..2 {
            let found = single.compare::<SHIFTED>(comparisons, space, 1);
            assert_eq!(wide.compare::<SHIFTED>(comparisons, space, PARTNERS), found);
            assert_eq!(wide.distance_squared[..found], single.distance_squared[..found]);
        }
        assert_eq!(wide.pairs(), single.pairs());
        assert_eq!(wide.reach(), single.reach());
        assert_eq!(wide.shifts(), single.shifts());
        assert_eq!(wide.shifts().len(), if SHIFTED { wide.count } else { 0 });
        wide.count / 2
    }
}
