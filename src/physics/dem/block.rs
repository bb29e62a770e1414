//! Blocks of discs that are adjacent in memory, with their neighbor lists: the data that all algorithms of a step share.

use crate::dem::motion;
use crate::simd::registers::MAX_WIDTH;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Discs per block: few enough that the lists of a block stay in the cache, enough that few pairs belong to two blocks.
pub(super) const BLOCK: usize = 2500;

/// Tiers of a list, each of an equal fraction of the skin; the first one also holds all pairs in contact.
pub(super) const TIERS: usize = 16;

/// Stretch of the tangential and the rolling spring of a contact, m; with Mindlin's springs, the first as in
/// [`mindlin_slider`](super::motion::mindlin_slider).
pub(super) type Stretch = [f64; 2];

/// The discs of a block, column by column.
pub(super) struct BlockDiscs<'a> {
    /// Index of the block's first disc.
    pub(super) start: usize,
    /// Centers, m.
    pub(super) positions: &'a mut [[f64; 2]],
    /// The integrator's velocities, m/s.
    pub(super) velocities: &'a mut [[f64; 2]],
    /// Angular velocities, rad/s.
    pub(super) spins: &'a mut [f64],
    /// Radii, m.
    pub(super) radii: &'a [f64],
    /// Masses, kg.
    pub(super) masses: &'a [f64],
    /// Inverse masses, 1/kg.
    pub(super) inverse_masses: &'a [f64],
    /// Material numbers.
    pub(super) materials: &'a [u8],
}

/// The index of a disc: `u16` within a block, `u32` among all discs. Lists are read from memory at every step; therefore, they are short.
pub(super) trait DiscIndex: Copy + Default + Into<u32> {
    /// The index, which must be in range.
    fn narrowed(index: u32) -> Self;
}

const _: () = assert!(BLOCK <= u16::MAX as usize);

impl DiscIndex for u16 {
    fn narrowed(index: u32) -> Self {
        index as Self
    }
}

impl DiscIndex for u32 {
    fn narrowed(index: u32) -> Self {
        index
    }
}

/// Pairs of a block with the constants that hold until the list is rebuilt, column by column.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Pairs<Second = u16> {
    /// A disc of the block, counted from the block's first disc.
    pub(super) first: Vec<u16>,
    /// The other disc: counted from the block's first disc for inner pairs, from the first of all discs for inter-block pairs.
    pub(super) second: Vec<Second>,
    /// r_i + r_j, m.
    pub(super) reach: Vec<f64>,
    /// eta of the pair, N s/m.
    pub(super) damping: Vec<f64>,
    /// R = r_i r_j / (r_i + r_j), m; empty until it is needed.
    #[serde(skip)]
    pub(super) reduced_radius: Vec<f64>,
    /// Stretch of the tangential springs, m; empty without friction.
    pub(super) stretch: Vec<f64>,
    /// Stretch of the rolling springs, m; empty without rolling friction.
    pub(super) rolling_stretch: Vec<f64>,
    /// End of each tier.
    pub(super) ends: [u32; TIERS],
}

/// The other side of a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Partner {
    /// A disc, by its index.
    Disc(u32),
    /// A wall, by its number.
    Wall(u32),
}

/// A disc and a wall that it may touch.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct WallPair {
    /// The disc, counted from the block's first disc.
    pub(super) disc: u32,
    pub(super) wall: u32,
    /// eta of the contact, N s/m.
    pub(super) damping: f64,
    pub(super) stretch: Stretch,
}

/// The neighbor lists of a block.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Block {
    /// Index of the first disc.
    pub(super) start: usize,
    /// Pairs within the block.
    pub(super) inner: Pairs,
    /// Pairs of two blocks, and pairs across a periodic side: the first disc belongs to this block, and the list that
    /// holds the second disc contains the pair as well.
    pub(super) inter_block: Pairs<u32>,
    /// Vector added to the second disc's center, m, for each inter-block pair.
    pub(super) shifts: Vec<[f64; 2]>,
    /// Discs near walls.
    pub(super) walls: Vec<WallPair>,
}

/// Pairs in groups of as many as a register holds.
#[derive(Clone, Copy)]
pub(super) struct PairGroups<'a, const N: usize> {
    pub(super) first: &'a [[u16; N]],
    pub(super) second: &'a [[u16; N]],
    pub(super) reach: &'a [[f64; N]],
    /// Empty if only distances matter.
    pub(super) damping: &'a [[f64; N]],
}

impl<'a, const N: usize> PairGroups<'a, N> {
    /// The groups of some columns, without the pairs that do not fill a register.
    #[inline(always)]
    pub(super) fn of(ends: [&'a [u16]; 2], reach: &'a [f64], damping: &'a [f64]) -> Self {
        let [first, second] = ends.map(|column| column.as_chunks().0);
        Self { first, second, reach: reach.as_chunks().0, damping: damping.as_chunks().0 }
    }

    /// A range of the groups. All columns then have one length, so that loops over them check no index.
    #[inline(always)]
    pub(super) fn range(&self, range: Range<usize>) -> Self {
        Self {
            first: &self.first[range.clone()],
            second: &self.second[range.clone()],
            reach: &self.reach[range.clone()],
            damping: &self.damping[range],
        }
    }

    /// The largest index.
    #[inline(always)]
    pub(super) fn max_index(&self) -> usize {
        let columns = [self.first, self.second].map(|column| {
            column.as_flattened().iter().fold(0, |most, &index| Ord::max(most, index))
        });
        usize::from(Ord::max(columns[0], columns[1]))
    }
}

impl<Second: DiscIndex> Pairs<Second> {
    /// Number of pairs.
    pub(super) fn len(&self) -> usize {
        self.first.len()
    }

    /// Stretch of a pair's springs; zero without springs.
    pub(super) fn stretch_of(&self, pair: usize) -> Stretch {
        let of = |column: &[f64]| column.get(pair).copied().unwrap_or(0.0);
        [of(&self.stretch), of(&self.rolling_stretch)]
    }

    /// Sets the stretch of those springs that a pair has.
    pub(super) fn set_stretch(&mut self, pair: usize, [sliding, rolling]: Stretch) {
        for (column, value) in [(&mut self.stretch, sliding), (&mut self.rolling_stretch, rolling)]
        {
            if let Some(stretch) = column.get_mut(pair) {
                *stretch = value;
            }
        }
    }

    /// Resizes the list to `pairs` pairs with these tier ends. Ends, reach and damping keep old values until they are written;
    /// springs are removed.
    pub(super) fn resize(&mut self, pairs: usize, ends: [u32; TIERS]) {
        fn reserve<T>(column: &mut Vec<T>, pairs: usize) {
            let needed = pairs.next_multiple_of(MAX_WIDTH);
            if column.capacity() < needed {
                // Old values need not be moved.
                *column = Vec::with_capacity(needed);
            }
        }
        reserve(&mut self.first, pairs);
        reserve(&mut self.second, pairs);
        reserve(&mut self.reach, pairs);
        reserve(&mut self.damping, pairs);
        self.reduced_radius.clear();
        self.stretch.clear();
        self.rolling_stretch.clear();
        self.ends = ends;
        self.set_len(pairs);
    }

    /// Fills the last register up with pairs of a disc and itself, which are not in contact; returns the number of pairs before.
    pub(super) fn fill_registers(&mut self) -> usize {
        let count = self.len();
        self.set_len(count.next_multiple_of(MAX_WIDTH));
        count
    }

    /// Removes the pairs behind the first `count`, or adds pairs of a disc and itself.
    pub(super) fn set_len(&mut self, count: usize) {
        self.first.resize(count, 0);
        self.second.resize(count, Second::default());
        self.reach.resize(count, 0.0);
        self.damping.resize(count, 0.0);
        for column in [&mut self.reduced_radius, &mut self.stretch, &mut self.rolling_stretch] {
            if !column.is_empty() {
                column.resize(count, 0.0);
            }
        }
    }

    /// Number of leading tiers that contain all stretched springs: a spring that a fast pair released is visited once more.
    fn tiers_with_springs(&self) -> usize {
        let columns = [&self.stretch, &self.rolling_stretch];
        let last = columns.map(|column| column.iter().rposition(|&stretch| stretch != 0.0));
        let count = last.into_iter().flatten().max().map_or(0, |last| last as u32 + 1);
        self.ends.partition_point(|&end| end < count) + usize::from(count > 0)
    }

    /// Number of pairs in the first `tiers` tiers.
    pub(super) fn in_tiers(&self, tiers: usize) -> usize {
        Ord::min(self.ends[tiers - 1] as usize, self.len())
    }
}

impl Pairs {
    /// Finds the reduced radii of the pairs, unless they are known since the list was built; `radii` are those of the block's discs, m.
    pub(super) fn find_reduced_radii(&mut self, radii: &[f64]) {
        if self.reduced_radius.len() == self.len() {
            return;
        }
        self.reduced_radius.clear();
        let ends = self.first.iter().zip(&self.second);
        let radii = ends.map(|(&one, &other)| [radii[usize::from(one)], radii[usize::from(other)]]);
        self.reduced_radius.extend(radii.map(|[one, other]| motion::reduced_radius(one, other)));
    }
}

impl<Second: DiscIndex> Pairs<Second> {
    /// Whether all columns have one length, tiers end in order, indices are below the given numbers of discs, and numbers are
    /// finite. Springs are missing without friction.
    fn is_valid(&self, firsts: usize, seconds: usize, has_springs: [bool; 2]) -> bool {
        let count = self.first.len();
        let are_below = |index: u32, limit: usize| (index as usize) < limit;
        let springs = [&self.stretch, &self.rolling_stretch];
        let numbers = self.reach.iter().chain(&self.damping).chain(springs.into_iter().flatten());
        [self.second.len(), self.reach.len(), self.damping.len()].iter().all(|len| *len == count)
            && (0..2).all(|kind| springs[kind].len() == if has_springs[kind] { count } else { 0 })
            && self.ends.is_sorted()
            && self.ends[TIERS - 1] as usize == count
            && self.first.iter().all(|&disc| are_below(disc.into(), firsts))
            && self.second.iter().all(|&disc| are_below(disc.into(), seconds))
            && numbers.into_iter().all(|number| number.is_finite())
    }
}

impl Block {
    /// Whether the lists refer to existing discs and walls. `discs` is the number of all discs.
    pub(super) fn is_valid(&self, discs: usize, walls: usize, has_springs: [bool; 2]) -> bool {
        let own = self.len(discs);
        let is_valid = |pair: &WallPair| {
            (pair.disc as usize) < own
                && (pair.wall as usize) < walls
                && pair.damping.is_finite()
                && pair.stretch.iter().all(|stretch| stretch.is_finite())
        };
        self.inner.is_valid(own, own, has_springs)
            && self.inter_block.is_valid(own, discs, has_springs)
            && self.shifts.len() == self.inter_block.len()
            && self.shifts.iter().flatten().all(|shift| shift.is_finite())
            && self.walls.iter().all(is_valid)
    }

    /// The indices of the two discs of an inter-block pair.
    pub(super) fn inter_block_ends(&self, pair: usize) -> [usize; 2] {
        [
            self.start + usize::from(self.inter_block.first[pair]),
            self.inter_block.second[pair] as usize,
        ]
    }

    /// Number of leading tiers that contain all stretched springs of the block.
    pub(super) fn tiers_with_springs(&self) -> usize {
        Ord::max(self.inner.tiers_with_springs(), self.inter_block.tiers_with_springs())
    }

    /// Number of the block's discs, given the number of all discs.
    pub(super) fn len(&self, discs: usize) -> usize {
        Ord::min(BLOCK, discs - self.start)
    }
}
