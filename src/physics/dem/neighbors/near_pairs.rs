//! Pairs that may touch within the next steps, out of a block's list: most of those that a wide skin brings along are not.
//!
//! A pair with a gap g stays apart while no disc has moved by g/2. So once in a while all pairs of the tiers in reach are
//! looked at, and until the fastest discs may have come a horizon's way only those that were closer than twice that. Their
//! order is that of the list, so sums of forces have the same bits with and without.
//!
//! What the unsafe code keeps to:
//! - Loads and stores of whole arrays through their own references: in bounds, and unaligned by instruction.
//! - Positions by a pair's places, unchecked pair by pair: all places are checked before the loop.
//! - Functions compiled for AVX2 and POPCNT, called by others that are compiled for them.

#![allow(unsafe_code)]
#![cfg_attr(
    not(target_arch = "x86_64"),
    allow(dead_code, reason = "only AVX2 has use for near pairs")
)]

use crate::dem::forces::fours::{Fours, LANES};
use crate::dem::neighbors::tiers::TIERS;
use crate::dem::neighbors::{Pairs, Scope};

/// The near pairs of a block. They are no part of the state.
#[derive(Clone, Debug, Default)]
pub(in crate::dem) struct Near {
    good: Good,
    /// Pairs of the list before this one are not looked through: most of them touch.
    begin: usize,
    /// Where the list ends if near pairs are not copied: all from `begin` on are looked through.
    end_of_all: Option<usize>,
    /// Numbers in the list.
    numbers: Vec<u32>,
    /// Places of their discs in the block and r_i + r_j, m, in fours; filled up with a disc and itself.
    columns: Columns,
    /// Whether so few pairs of the list's first tier touch that it is looked through as well.
    is_sparse: bool,
}

/// Which of the near pairs of a block touch: memory that blocks share.
#[derive(Clone, Debug, Default)]
pub(in crate::dem) struct Touching {
    /// By their order among the near ones, and room behind them.
    places: Vec<u32>,
    count: usize,
}

/// Columns of fours of pairs.
#[derive(Clone, Debug, Default)]
struct Columns {
    firsts: Vec<[u32; LANES]>,
    seconds: Vec<[u32; LANES]>,
    reaches: Vec<[f64; LANES]>,
    /// The largest place.
    beyond: usize,
}

/// The horizon over the skin.
const HORIZON: f64 = 1.0 / TIERS as f64;

/// What near pairs are good for; by itself nothing.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::dem) struct Good {
    /// The number of the list that they are from, and the way of its fastest discs, m, that is too long for them.
    list_and_way: Option<(u64, f64)>,
}

impl Good {
    /// Whether pairs that were near are good for the lists and the ways of a scope.
    pub(in crate::dem) fn is_for(&self, scope: &Scope) -> bool {
        self.list_and_way.is_some_and(|(list, way)| list == scope.list && scope.way < way)
    }

    /// Pairs that are near now.
    pub(in crate::dem) fn until_the_horizon(scope: &Scope) -> Self {
        Self { list_and_way: Some((scope.list, scope.way + horizon(scope).0)) }
    }
}

/// The horizon, and the gap up to which pairs are near, m.
pub(in crate::dem) fn horizon(scope: &Scope) -> (f64, f64) {
    let horizon = HORIZON * scope.skin;
    // Gaps are rounded in their last digits.
    (horizon, 2.000_001 * horizon)
}

impl Near {
    /// Pairs of the list before this one are not among these: most of them touch. A multiple of the lanes.
    pub(in crate::dem) fn begin(&self) -> usize {
        self.begin
    }

    /// Numbers in the list of those that touch, in its order; with up to three more at its end.
    pub(in crate::dem) fn those(&self, touching: &Touching) -> impl Iterator<Item = usize> {
        let places = touching.places[..touching.count].iter().map(|&place| place as usize);
        places.map(|place| match self.end_of_all {
            Some(_) => self.begin + place,
            None => self.numbers[place] as usize,
        })
    }

    /// Takes note of how many of the list's first pairs touch.
    pub(in crate::dem) fn note(&mut self, touching: usize, of: usize) {
        let is_sparse = 2 * touching < of;
        if is_sparse != self.is_sparse {
            (self.is_sparse, self.good) = (is_sparse, Good::default());
        }
    }
}

/// Room for as many, and an eighth more: there are others each time.
fn make_room<T>(column: &mut Vec<T>, values: usize) {
    if column.capacity() < values {
        // What it held need not be moved.
        *column = Vec::with_capacity(values + values / 8);
    }
}

impl Columns {
    /// Copies pairs of a list.
    fn take(&mut self, pairs: &Pairs, numbers: &[u32]) {
        fn sized<T: Copy + Default>(column: &mut Vec<T>, fours: usize) {
            column.clear();
            make_room(column, fours);
            column.resize(fours, T::default());
        }
        let fours = numbers.len().div_ceil(LANES);
        sized(&mut self.firsts, fours);
        sized(&mut self.seconds, fours);
        sized(&mut self.reaches, fours);
        let ends = self.firsts.as_flattened_mut().iter_mut().zip(self.seconds.as_flattened_mut());
        let columns = ends.zip(self.reaches.as_flattened_mut());
        for (((first, second), reach), &number) in columns.zip(numbers) {
            let number = number as usize;
            (*first, *second) = (pairs.first[number], pairs.second[number]);
            *reach = pairs.reach[number];
        }
        self.beyond = Fours { firsts: &self.firsts, seconds: &self.seconds, reaches: &[] }.beyond();
    }
}

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use super::{Columns, Fours, Good, LANES, Near, Touching, horizon, make_room};
    use crate::dem::forces::fours::{differences, those_first};
    use crate::dem::neighbors::{Pairs, Scope};
    use std::arch::x86_64::*;

    impl Near {
        /// Finds out which pairs touch, by the positions, m, of the block's discs.
        #[inline]
        #[target_feature(enable = "avx2,popcnt")]
        pub(in crate::dem) fn look(
            &mut self,
            pairs: &Pairs,
            positions: &[[f64; 2]],
            scope: &Scope,
            touching: &mut Touching,
        ) {
            if !self.good.is_for(scope) {
                self.look_far(pairs, positions, scope, touching);
            }
            let Columns { firsts, seconds, reaches, .. } = &self.columns;
            let (fours, last) = match self.end_of_all {
                Some(end) => Fours::of(pairs, self.begin..end),
                None => (Fours { firsts, seconds, reaches }, 0..0),
            };
            let beyond =
                if self.end_of_all.is_some() { fours.beyond() } else { self.columns.beyond };
            assert!(beyond < positions.len(), "a pair of no disc");
            // SAFETY: no place is beyond the rows.
            unsafe { list(fours, positions, 0.0, touching) };
            for pair in last {
                // There is room behind those that count.
                touching.places[touching.count] = (pair - self.begin) as u32;
                touching.count += 1;
            }
        }

        /// Finds the near pairs anew.
        #[target_feature(enable = "avx2,popcnt")]
        fn look_far(
            &mut self,
            pairs: &Pairs,
            positions: &[[f64; 2]],
            scope: &Scope,
            found: &mut Touching,
        ) {
            let (horizon, margin) = horizon(scope);
            let end = pairs.in_tiers(scope.tiers_within(horizon));
            let first_tier = pairs.in_tiers(1);
            self.begin = if self.is_sparse { 0 } else { first_tier - first_tier % LANES };
            let (fours, last) = Fours::of(pairs, self.begin..end);
            assert!(fours.beyond() < positions.len(), "a pair of no disc");
            self.good = Good::until_the_horizon(scope);
            self.numbers.clear();
            self.end_of_all = scope.spares_memory.then_some(end);
            if scope.spares_memory {
                return;
            }
            // SAFETY: no place is beyond the rows.
            unsafe { list(fours, positions, margin, found) };
            make_room(&mut self.numbers, found.count + last.len());
            let found = &found.places[..found.count];
            self.numbers.extend(found.iter().map(|&place| place + self.begin as u32));
            self.numbers.extend(last.map(|pair| pair as u32));
            self.columns.take(pairs, &self.numbers);
        }
    }

    /// Lists the places of those pairs whose gaps are smaller than a margin, m. All places of discs must be those of positions.
    #[inline]
    #[target_feature(enable = "avx2,popcnt")]
    unsafe fn list(fours: Fours<'_>, positions: &[[f64; 2]], margin: f64, into: &mut Touching) {
        // Eight are written at a time, wherever the last that counts stands.
        let room = (fours.firsts.len() + 2) * LANES;
        if into.places.len() < room {
            into.places.resize(room, 0);
        }
        let mut count = 0;
        let mut numbers = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
        let margin = _mm256_set1_pd(margin);
        let ends = fours.firsts.iter().zip(fours.seconds);
        let mut fours = ends.zip(fours.reaches);
        while let Some(((first, second), reach)) = fours.next() {
            // SAFETY: the caller's promise.
            let mut set = unsafe { who_is_near([first, second], reach, margin, positions) };
            if let Some(((first, second), reach)) = fours.next() {
                // SAFETY: the caller's promise.
                set |= unsafe { who_is_near([first, second], reach, margin, positions) } << LANES;
            }
            // All are written before it is known who of them counts: there is no branch to guess.
            let Some(place) = into.places.get_mut(count..).and_then(|rest| rest.first_chunk_mut())
            else {
                break;
            };
            place_first(numbers, set as usize, place);
            numbers = _mm256_add_epi32(numbers, _mm256_set1_epi32(2 * LANES as i32));
            count += set.count_ones() as usize;
        }
        into.count = count;
    }

    /// Which of four pairs have gaps smaller than a margin, a bit each. All places must be those of positions.
    #[inline]
    #[target_feature(enable = "avx2")]
    unsafe fn who_is_near(
        ends: [&[u32; LANES]; 2],
        reach: &[f64; LANES],
        margin: __m256d,
        positions: &[[f64; 2]],
    ) -> u32 {
        // SAFETY: the caller's promise.
        let [x, y] = unsafe { differences(positions, ends) };
        // SAFETY: four f64 lie behind the reference.
        let reach = _mm256_add_pd(unsafe { _mm256_loadu_pd(reach.as_ptr()) }, margin);
        let squared = _mm256_add_pd(_mm256_mul_pd(x, x), _mm256_mul_pd(y, y));
        let is_near = _mm256_cmp_pd::<_CMP_LT_OQ>(squared, _mm256_mul_pd(reach, reach));
        _mm256_movemask_pd(is_near) as u32
    }

    /// For each set of eight that count, an order that puts these first.
    static COUNTING_FIRST: [[u8; 2 * LANES]; 256] = {
        let mut orders = [[0; 2 * LANES]; 256];
        let mut set = 0;
        while set < 256 {
            orders[set] = those_first(set);
            set += 1;
        }
        orders
    };

    /// Writes eight numbers with those first that count.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn place_first(numbers: __m256i, set: usize, into: &mut [u32; 2 * LANES]) {
        // SAFETY: eight u8 and eight u32 lie behind the references.
        unsafe {
            let order = _mm_loadl_epi64(COUNTING_FIRST[set].as_ptr().cast());
            let sorted = _mm256_permutevar8x32_epi32(numbers, _mm256_cvtepu8_epi32(order));
            _mm256_storeu_si256(into.as_mut_ptr().cast(), sorted);
        }
    }
}
