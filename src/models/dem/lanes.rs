//! Normal forces of four pairs at a time with AVX2, where the machine has it: the same operations in the same order as
//! `forces::inner_pairs`, so the same bits (a test compares them). No fused multiply-add.
//!
//! What the unsafe code keeps to:
//! - Loads and stores of a whole `[f64; 4]` through its own reference: in bounds, and unaligned by instruction.
//! - Rows of states and forces by a pair's indices, unchecked pair by pair: all indices are checked before the loop.
//! - The call of a function compiled for AVX2, made only where `is_x86_feature_detected!` has found it.

#![allow(unsafe_code)]

use super::contacts::ContactLaw;
use super::forces::Deepest;
use super::neighbours::Pairs;

/// Pairs at a time.
const LANES: usize = 4;

/// What the lanes take their pairs from.
pub(super) struct Lanes<'a> {
    pub(super) pairs: &'a Pairs,
    /// Pairs up to here touch or nearly do.
    pub(super) near: usize,
    /// Pairs up to here are looked at.
    pub(super) end: usize,
    /// x, y in m, vx, vy in m/s of the block's discs, and their radii, m.
    pub(super) own: &'a [[f64; 4]],
    pub(super) radii: &'a [f64],
    pub(super) law: &'a ContactLaw,
}

/// Memory of the lanes.
#[derive(Clone, Debug, Default)]
pub(super) struct Touching {
    /// Numbers of pairs that touch, and room behind them.
    numbers: Vec<u32>,
    count: usize,
    /// Whether all that touch are among these.
    is_all: bool,
    /// Whether so few of the near pairs touch that it pays to look who does first.
    is_sparse: bool,
}

impl Touching {
    /// The numbers of all pairs that touch, of those that filled whole lanes, if they were found out.
    pub(super) fn all(&self) -> Option<&[u32]> {
        self.is_all.then(|| &self.numbers[..self.count])
    }
}

/// Adds the forces of as many pairs as fill whole lanes, and returns their number: 0 where the machine has no AVX2.
pub(super) fn inner_pairs(
    lanes: &Lanes<'_>,
    forces: &mut [[f64; 4]],
    deepest: &mut Deepest,
    touching: &mut Touching,
) -> usize {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("popcnt")
    {
        // SAFETY: the machine has AVX2 and POPCNT.
        return unsafe { avx2::inner_pairs(lanes, forces, deepest, touching) };
    }
    0
}

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use super::{Deepest, LANES, Lanes, Touching};
    use crate::models::dem::registers::avx2::transposed;
    use std::arch::x86_64::*;

    #[inline]
    #[target_feature(enable = "avx2")]
    fn load(values: &[f64; 4]) -> __m256d {
        // SAFETY: four f64 lie behind the reference.
        unsafe { _mm256_loadu_pd(values.as_ptr()) }
    }

    #[inline]
    #[target_feature(enable = "avx2")]
    fn store(into: &mut [f64; 4], values: __m256d) {
        // SAFETY: four f64 lie behind the reference.
        unsafe { _mm256_storeu_pd(into.as_mut_ptr(), values) }
    }

    /// The pairs of the lanes, four by four.
    #[derive(Clone, Copy)]
    struct Columns<'a> {
        firsts: &'a [[u32; LANES]],
        seconds: &'a [[u32; LANES]],
        reaches: &'a [[f64; LANES]],
        dampings: &'a [[f64; LANES]],
    }

    /// Four pairs.
    struct Four<'a> {
        first: &'a [u32; LANES],
        second: &'a [u32; LANES],
        reach: &'a [f64; LANES],
        damping: &'a [f64; LANES],
    }

    impl<'a> Columns<'a> {
        fn of(lanes: &Lanes<'a>) -> Self {
            let (pairs, range) = (lanes.pairs, 0..lanes.end);
            Self {
                firsts: pairs.first[range.clone()].as_chunks().0,
                seconds: pairs.second[range.clone()].as_chunks().0,
                reaches: pairs.reach[range.clone()].as_chunks().0,
                dampings: pairs.damping[range].as_chunks().0,
            }
        }

        fn all(self) -> impl Iterator<Item = Four<'a>> {
            let ends = self.firsts.iter().zip(self.seconds);
            let constants = self.reaches.iter().zip(self.dampings);
            ends.zip(constants).map(|((first, second), (reach, damping))| Four {
                first,
                second,
                reach,
                damping,
            })
        }

        /// The same pairs, no more at a time than fit a batch.
        fn batches(self) -> impl Iterator<Item = Self> {
            let ends = self.firsts.chunks(BATCH).zip(self.seconds.chunks(BATCH));
            let constants = self.reaches.chunks(BATCH).zip(self.dampings.chunks(BATCH));
            ends.zip(constants).map(|((firsts, seconds), (reaches, dampings))| Self {
                firsts,
                seconds,
                reaches,
                dampings,
            })
        }

        /// Those before a number, and the others.
        fn split_at(self, number: usize) -> [Self; 2] {
            let (firsts, other_firsts) = self.firsts.split_at(number);
            let (seconds, other_seconds) = self.seconds.split_at(number);
            let (reaches, other_reaches) = self.reaches.split_at(number);
            let (dampings, other_dampings) = self.dampings.split_at(number);
            let others = Self {
                firsts: other_firsts,
                seconds: other_seconds,
                reaches: other_reaches,
                dampings: other_dampings,
            };
            [Self { firsts, seconds, reaches, dampings }, others]
        }

        /// The largest index.
        fn beyond(&self) -> usize {
            let largest = |of: &[[u32; LANES]]| {
                of.as_flattened().iter().fold(0, |most, &index| Ord::max(most, index))
            };
            Ord::max(largest(self.firsts), largest(self.seconds)) as usize
        }
    }

    /// Row `a` less row `b`, which must both be there.
    #[inline]
    #[target_feature(enable = "avx2")]
    unsafe fn difference(rows: &[[f64; 4]], a: u32, b: u32) -> __m256d {
        // SAFETY: the caller's promise.
        let (a, b) = unsafe { (rows.get_unchecked(a as usize), rows.get_unchecked(b as usize)) };
        _mm256_sub_pd(load(a), load(b))
    }

    /// x and y of a row.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn centre(row: &[f64; 4]) -> __m128d {
        // SAFETY: four f64 lie behind the reference.
        unsafe { _mm_loadu_pd(row.as_ptr()) }
    }

    /// Which of four pairs touch, a bit each. All indices must be those of rows.
    #[inline]
    #[target_feature(enable = "avx2")]
    unsafe fn who_touches(four: &Four<'_>, own: &[[f64; 4]]) -> u32 {
        let centres = |lane: usize, other: usize| {
            let of = |ends: &[u32; LANES]| {
                // SAFETY: the caller's promise.
                let (low, high) = unsafe {
                    (
                        own.get_unchecked(ends[lane] as usize),
                        own.get_unchecked(ends[other] as usize),
                    )
                };
                let (low, high) = (centre(low), centre(high));
                _mm256_insertf128_pd::<1>(_mm256_castpd128_pd256(low), high)
            };
            _mm256_sub_pd(of(four.first), of(four.second))
        };
        let (even, odd) = (centres(0, 2), centres(1, 3));
        let (x, y) = (_mm256_unpacklo_pd(even, odd), _mm256_unpackhi_pd(even, odd));
        let reach = load(four.reach);
        let squared = _mm256_add_pd(_mm256_mul_pd(x, x), _mm256_mul_pd(y, y));
        let touch = _mm256_cmp_pd::<_CMP_LT_OQ>(squared, _mm256_mul_pd(reach, reach));
        _mm256_movemask_pd(touch) as u32
    }

    /// Lists the numbers of those pairs that touch, counted from the first of `sparse`, and returns how many there are. All
    /// indices must be those of rows.
    #[inline]
    #[target_feature(enable = "avx2,popcnt")]
    unsafe fn list_touching(
        sparse: Columns<'_>,
        own: &[[f64; 4]],
        touching: &mut Vec<u32>,
    ) -> usize {
        let room = sparse.firsts.len() * LANES + 2 * LANES;
        if touching.len() < room {
            touching.resize(2 * room, 0);
        }
        let mut count = 0;
        let mut numbers = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
        let mut fours = sparse.all();
        while let Some(four) = fours.next() {
            // SAFETY: the caller's promise.
            let mut set = unsafe { who_touches(&four, own) };
            if let Some(four) = fours.next() {
                // SAFETY: the caller's promise.
                set |= unsafe { who_touches(&four, own) } << LANES;
            }
            // All are written before it is known who of them counts: there is no branch to guess.
            let Some(place) = touching.get_mut(count..).and_then(|rest| rest.first_chunk_mut())
            else {
                break;
            };
            place_first(numbers, set as usize, place);
            numbers = _mm256_add_epi32(numbers, _mm256_set1_epi32(2 * LANES as i32));
            count += set.count_ones() as usize;
        }
        count
    }

    /// For each set of eight that count, an order that puts these first.
    static COUNTING_FIRST: [[u8; 2 * LANES]; 256] = {
        let mut orders = [[0; 2 * LANES]; 256];
        let mut set = 0;
        while set < 256 {
            let (mut lane, mut place) = (0, 0);
            while lane < 2 * LANES {
                if set >> lane & 1 == 1 {
                    orders[set][place] = lane as u8;
                    place += 1;
                }
                lane += 1;
            }
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

    /// Fours that are worked on at a time: what is found of them stays in the nearest cache.
    const BATCH: usize = 32;

    /// What contacts are like, four by four: unit normal, and overlap and separating speed, both zero where two are apart.
    struct Meetings([[[f64; LANES]; 4]; BATCH]);

    /// Pairs copied from where they stand apart.
    #[derive(Default)]
    struct Gathered {
        firsts: [[u32; LANES]; BATCH],
        seconds: [[u32; LANES]; BATCH],
        reaches: [[f64; LANES]; BATCH],
        dampings: [[f64; LANES]; BATCH],
    }

    impl Gathered {
        /// Copies pairs, no more than fit. A last four is filled up with pairs of a disc and itself, which do not touch.
        fn take(&mut self, sparse: Columns<'_>, numbers: &[u32]) -> Columns<'_> {
            let fours = numbers.len().div_ceil(LANES);
            for (four, numbers) in numbers.chunks(LANES).enumerate() {
                self.firsts[four] = [0; LANES];
                self.seconds[four] = [0; LANES];
                self.reaches[four] = [0.0; LANES];
                self.dampings[four] = [0.0; LANES];
                for (lane, &number) in numbers.iter().enumerate() {
                    let number = number as usize;
                    self.firsts[four][lane] = sparse.firsts.as_flattened()[number];
                    self.seconds[four][lane] = sparse.seconds.as_flattened()[number];
                    self.reaches[four][lane] = sparse.reaches.as_flattened()[number];
                    self.dampings[four][lane] = sparse.dampings.as_flattened()[number];
                }
            }
            Columns {
                firsts: &self.firsts[..fours],
                seconds: &self.seconds[..fours],
                reaches: &self.reaches[..fours],
                dampings: &self.dampings[..fours],
            }
        }
    }

    #[target_feature(enable = "avx2,popcnt")]
    pub(super) fn inner_pairs(
        lanes: &Lanes<'_>,
        forces: &mut [[f64; 4]],
        deepest: &mut Deepest,
        touching: &mut Touching,
    ) -> usize {
        let columns = Columns::of(lanes);
        let whole = columns.firsts.len();
        let near = if touching.is_sparse { 0 } else { Ord::min(lanes.near.div_ceil(LANES), whole) };
        let [dense, sparse] = columns.split_at(near);
        // Also a list out of a damaged checkpoint must not reach beyond.
        let rows = Ord::min(lanes.own.len(), forces.len());
        assert!(columns.beyond() < rows, "a pair of no disc");
        let mut meetings = Meetings([[[0.0; LANES]; 4]; BATCH]);
        let mut gathered = Gathered::default();
        // SAFETY: no index reaches beyond the rows.
        unsafe {
            let mut count = list_touching(sparse, lanes.own, &mut touching.numbers);
            (touching.count, touching.is_all) = (count, near == 0);
            let numbers = &touching.numbers[..count];
            for batch in dense.batches() {
                count += meet(lanes, batch, &mut meetings, deepest);
                push(lanes, batch, &meetings, forces);
            }
            for numbers in numbers.chunks(BATCH * LANES) {
                let batch = gathered.take(sparse, numbers);
                meet(lanes, batch, &mut meetings, deepest);
                push(lanes, batch, &meetings, forces);
            }
            // Either way gives the same bits.
            touching.is_sparse = 2 * count < lanes.near;
        }
        whole * LANES
    }

    /// Finds what the contacts of a batch are like, and returns how many there are. All indices must be those of rows.
    ///
    /// Roots and quotients take long: without sums in memory that wait for them, more fours are under way at a time.
    #[inline]
    #[target_feature(enable = "avx2")]
    unsafe fn meet(
        lanes: &Lanes<'_>,
        batch: Columns<'_>,
        meetings: &mut Meetings,
        deepest: &mut Deepest,
    ) -> usize {
        let own = lanes.own;
        let mut count = _mm256_setzero_si256();
        let smallest = _mm256_set1_pd(f64::MIN_POSITIVE);
        let one = _mm256_set1_pd(1.0);
        let mut bound = _mm256_set1_pd(deepest.bound());
        for (Four { first, second, reach, .. }, meeting) in batch.all().zip(&mut meetings.0) {
            // SAFETY: the caller's promise.
            let rows = unsafe {
                [
                    difference(own, first[0], second[0]),
                    difference(own, first[1], second[1]),
                    difference(own, first[2], second[2]),
                    difference(own, first[3], second[3]),
                ]
            };
            let [x, y, vx, vy] = transposed(rows);
            let reach = load(reach);
            let squared = _mm256_add_pd(_mm256_mul_pd(x, x), _mm256_mul_pd(y, y));
            let touch = _mm256_cmp_pd::<_CMP_LT_OQ>(squared, _mm256_mul_pd(reach, reach));
            // A lane of yes is -1 as a whole number.
            count = _mm256_sub_epi64(count, _mm256_castpd_si256(touch));
            let distance = _mm256_sqrt_pd(squared);
            let inverse = _mm256_div_pd(one, _mm256_max_pd(distance, smallest));
            let (nx, ny) = (_mm256_mul_pd(x, inverse), _mm256_mul_pd(y, inverse));
            let speed = _mm256_add_pd(_mm256_mul_pd(vx, nx), _mm256_mul_pd(vy, ny));
            let overlap = _mm256_and_pd(_mm256_sub_pd(reach, distance), touch);
            store(&mut meeting[0], nx);
            store(&mut meeting[1], ny);
            store(&mut meeting[2], overlap);
            store(&mut meeting[3], _mm256_and_pd(speed, touch));
            let deep = _mm256_cmp_pd::<_CMP_GT_OQ>(overlap, bound);
            let deep = _mm256_movemask_pd(deep);
            if deep != 0 {
                for lane in (0..LANES).filter(|lane| deep >> lane & 1 == 1) {
                    let ends = [first[lane] as usize, second[lane] as usize];
                    deepest.note_pair(meeting[2][lane], ends, lanes.radii);
                }
                bound = _mm256_set1_pd(deepest.bound());
            }
        }
        let mut counts = [0_u64; LANES];
        // SAFETY: four u64 lie behind the reference.
        unsafe { _mm256_storeu_si256(counts.as_mut_ptr().cast(), count) };
        counts.iter().sum::<u64>() as usize
    }

    /// Adds the forces of a batch. All indices must be those of rows of forces.
    #[inline]
    #[target_feature(enable = "avx2")]
    unsafe fn push(
        lanes: &Lanes<'_>,
        batch: Columns<'_>,
        meetings: &Meetings,
        forces: &mut [[f64; 4]],
    ) {
        let stiffness = _mm256_set1_pd(lanes.law.stiffness);
        let floor = _mm256_set1_pd(lanes.law.least_force());
        for (Four { first, second, damping, .. }, meeting) in batch.all().zip(&meetings.0) {
            let [nx, ny, overlap, speed] = meeting.each_ref().map(|column| load(column));
            let spring = _mm256_mul_pd(stiffness, overlap);
            let force = _mm256_sub_pd(spring, _mm256_mul_pd(load(damping), speed));
            let force = _mm256_max_pd(force, floor);
            let loss = _mm256_sub_pd(spring, force);
            let rows = transposed([
                _mm256_mul_pd(force, nx),
                _mm256_mul_pd(force, ny),
                _mm256_mul_pd(loss, nx),
                _mm256_mul_pd(loss, ny),
            ]);
            // A pair apart adds 0, which changes no bit: a sum that began with +0 is never -0. It costs less than a branch.
            for (lane, row) in rows.into_iter().enumerate() {
                // SAFETY: the caller's promise.
                let on_first = unsafe { forces.get_unchecked_mut(first[lane] as usize) };
                let sum = _mm256_add_pd(load(on_first), row);
                store(on_first, sum);
                // SAFETY: the caller's promise.
                let on_second = unsafe { forces.get_unchecked_mut(second[lane] as usize) };
                let sum = _mm256_sub_pd(load(on_second), row);
                store(on_second, sum);
            }
        }
    }
}
