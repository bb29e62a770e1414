//! Pairs found while a block's list is built, several discs at a time with SIMD instructions.
//!
//! Sums, products and comparisons are the same at every width; therefore, so are the lists.

use crate::dem::discs::Discs;
use crate::dem::motion;
use crate::dem::neighbors::tiers;
use crate::dem::parameters::Parameters;
use crate::simd::registers::{self, InstructionSet, Kernel, Mask, Scalar};
use std::ops::Range;

/// Partners per comparison, and the width of its registers.
const PARTNERS: usize = 4;

/// Number of box lengths along each axis by which a disc is shifted.
pub(crate) type ImageShift = [i8; 2];

/// A disc and up to four adjacent discs that it is compared with.
#[derive(Clone, Copy, Debug, Default)]
struct Comparison {
    /// The disc, and the first of its partners.
    ends: [u32; 2],
    /// End of the partners.
    stop: u32,
    shift: ImageShift,
}

/// Comparisons to be made, in order. Room is reserved ahead, and a comparison is written before it is known whether it counts, so
/// there is no branch to predict.
#[derive(Debug, Default)]
pub(crate) struct Comparisons {
    comparisons: Vec<Comparison>,
    count: usize,
}

/// The pairs found, column by column, in the order in which they were found. Room is reserved ahead here as well.
#[derive(Debug, Default)]
pub(crate) struct PairBuffer {
    /// The disc, counted from the block's first disc, and its partner, counted from the first disc of the search space.
    pairs: Vec<[u32; 2]>,
    /// r_i + r_j, m.
    reach: Vec<f64>,
    pub(crate) tiers: Vec<u8>,
    /// Squared distances, m^2, of the pairs whose tiers are not yet known.
    distance_squared: Vec<f64>,
    /// Shifts of the partners; empty if none is shifted.
    pub(crate) shifts: Vec<ImageShift>,
    count: usize,
}

/// The discs among which pairs are searched.
#[derive(Clone, Copy)]
pub(crate) struct SearchSpace<'a> {
    pub(crate) discs: &'a Discs,
    /// Distance beyond contact up to which pairs are listed, m.
    pub(crate) skin: f64,
    /// The discs that the block's discs and their partners are counted from.
    pub(crate) counted_from: [usize; 2],
    pub(crate) parameters: &'a Parameters,
}

impl Comparisons {
    pub(crate) fn len(&self) -> usize {
        self.count
    }

    /// Adds the comparisons of a disc with adjacent partners, of which there may be none. The range must not end before it begins.
    #[inline]
    pub(crate) fn add(&mut self, disc: u32, partners: Range<u32>, shift: ImageShift) {
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
    pub(crate) fn vector(&self, shift: ImageShift) -> [f64; 2] {
        [0, 1].map(|axis: usize| f64::from(shift[axis]) * self.parameters.sides[axis])
    }
}

impl PairBuffer {
    pub(crate) fn clear(&mut self) {
        self.count = 0;
        self.shifts.clear();
        self.tiers.clear();
    }

    pub(crate) fn pairs(&self) -> &[[u32; 2]] {
        &self.pairs[..self.count]
    }

    pub(crate) fn reach(&self) -> &[f64] {
        &self.reach[..self.count]
    }

    /// Makes the comparisons, keeps the pairs closer than contact plus the skin, and empties the comparisons. With `SHIFTED`,
    /// partners may be images beyond periodic sides.
    pub(crate) fn take<const SHIFTED: bool>(
        &mut self,
        comparisons: &mut Comparisons,
        space: &SearchSpace<'_>,
    ) {
        let count = std::mem::take(&mut comparisons.count);
        let comparisons = &comparisons.comparisons[..count];
        // Whole registers are written, even if fewer pairs count.
        let (begin, length) = (self.count, (count + 1) * PARTNERS);
        let end = begin + length;
        if self.distance_squared.len() < length {
            self.distance_squared.resize(length, 0.0);
        }
        if self.pairs.len() < end {
            self.pairs.resize(end + end / 4, [0; 2]);
            self.reach.resize(end + end / 4, 0.0);
        }
        let room = Room {
            pairs: &mut self.pairs[begin..end],
            reach: &mut self.reach[begin..end],
            distance_squared: &mut self.distance_squared[..length],
            shifts: &mut self.shifts,
        };
        let kernel = Compare::<SHIFTED> { comparisons, space, room };
        let found = registers::run(kernel, Ord::min(space.parameters.max_width, PARTNERS));
        self.count += found;
        self.tiers.resize(self.count, 0);
        let (squared, reach) = (&self.distance_squared[..found], &self.reach[begin..self.count]);
        tiers::find(squared, reach, space.skin, &mut self.tiers[begin..]);
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

impl<const SHIFTED: bool> Kernel for Compare<'_, SHIFTED> {
    /// The number of pairs found.
    type Output = usize;

    #[inline(always)]
    fn run<const N: usize, I: InstructionSet<N>>(self, instructions: I) -> usize {
        let Self { comparisons, space, room } = self;
        // Columns of one length, so that room is checked once.
        let length = room.pairs.len();
        let mut room = Room {
            pairs: room.pairs,
            reach: &mut room.reach[..length],
            distance_squared: &mut room.distance_squared[..length],
            shifts: room.shifts,
        };
        // Copied out of the structure, so that the loop does not load them again.
        let (space, positions) = (*space, space.discs.positions.as_slice());
        // Columns of one length, so that an index is checked once.
        let radii = &space.discs.radii[..positions.len()];
        let mut count = 0;
        for comparison in comparisons {
            let shift = if SHIFTED { space.vector(comparison.shift) } else { [0.0; 2] };
            let found = count;
            let Comparison { ends: [disc, first], stop, .. } = *comparison;
            let (center, radius) = (positions[disc as usize], radii[disc as usize]);
            for group in 0..PARTNERS.div_ceil(N) as u32 {
                let first = first + group * N as u32;
                let partners = first as usize..first as usize + N;
                let centers = positions.get(partners.clone()).and_then(|part| part.first_chunk());
                let radii_of = radii.get(partners).and_then(|part| part.first_chunk());
                if let (Some(centers), Some(partner_radii)) = (centers, radii_of) {
                    let ends = [disc, first];
                    let partners =
                        Partners { center, radius, ends, stop, shift, centers, partner_radii };
                    count += partners.compare::<I, SHIFTED>(instructions, &space, &mut room, count);
                } else {
                    // The last discs in memory do not fill a register.
                    for first in first..Ord::min(stop, first + N as u32) {
                        let (ends, last) = ([disc, first], first as usize);
                        let (centers, partner_radii) = (&[positions[last]], &[radii[last]]);
                        let partners =
                            Partners { center, radius, ends, stop, shift, centers, partner_radii };
                        count += partners.compare::<_, SHIFTED>(Scalar, &space, &mut room, count);
                    }
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
    /// The disc's center and radius, m.
    center: [f64; 2],
    radius: f64,
    /// The disc, and the first of the partners; their end.
    ends: [u32; 2],
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
        let Self { center, radius, ends: [disc, first], stop, shift, centers, partner_radii } =
            *self;
        let [mut other_x, mut other_y] = instructions.columns(centers);
        if SHIFTED {
            other_x = other_x + instructions.splat(shift[0]);
            other_y = other_y + instructions.splat(shift[1]);
        }
        let [x, y] = [instructions.splat(center[0]), instructions.splat(center[1])];
        let separation = [x - other_x, y - other_y];
        let distance_squared = motion::distance_squared(separation);
        let reach = instructions.splat(radius) + instructions.load(partner_radii);
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
