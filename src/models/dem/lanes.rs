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
    /// Pairs up to here mostly touch; of those behind, few do.
    pub(super) dense: usize,
    /// Pairs up to here are looked at.
    pub(super) end: usize,
    /// x, y in m, vx, vy in m/s of the block's discs, and their radii, m.
    pub(super) own: &'a [[f64; 4]],
    pub(super) radii: &'a [f64],
    pub(super) law: &'a ContactLaw,
}

/// Adds the forces of as many pairs as fill whole lanes, and returns their number: 0 where the machine has no AVX2. `touching`
/// is memory.
pub(super) fn inner_pairs(
    lanes: &Lanes<'_>,
    forces: &mut [[f64; 4]],
    deepest: &mut Deepest,
    touching: &mut Vec<u32>,
) -> usize {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") {
        // SAFETY: the machine has AVX2.
        return unsafe { avx2::inner_pairs(lanes, forces, deepest, touching) };
    }
    0
}

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use super::{Deepest, LANES, Lanes};
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

        fn at(&self, number: u32) -> Four<'a> {
            let number = number as usize;
            Four {
                first: &self.firsts[number],
                second: &self.seconds[number],
                reach: &self.reaches[number],
                damping: &self.dampings[number],
            }
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

    /// Lists the numbers of those fours in which any pair touches. All indices must be those of rows.
    #[inline]
    #[target_feature(enable = "avx2")]
    unsafe fn touching_fours(sparse: Columns<'_>, own: &[[f64; 4]], touching: &mut Vec<u32>) {
        touching.clear();
        touching.resize(sparse.firsts.len(), 0);
        let mut count = 0;
        for (number, Four { first, second, reach, .. }) in (0..).zip(sparse.all()) {
            let centres = |lane: usize, other: usize| {
                let of = |ends: &[u32; 4]| {
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
                _mm256_sub_pd(of(first), of(second))
            };
            let (even, odd) = (centres(0, 2), centres(1, 3));
            let (x, y) = (_mm256_unpacklo_pd(even, odd), _mm256_unpackhi_pd(even, odd));
            let reach = load(reach);
            let squared = _mm256_add_pd(_mm256_mul_pd(x, x), _mm256_mul_pd(y, y));
            let touch = _mm256_cmp_pd::<_CMP_LT_OQ>(squared, _mm256_mul_pd(reach, reach));
            // Written before it is known whether it counts: there is no branch to guess.
            touching[count] = number;
            count += usize::from(_mm256_movemask_pd(touch) != 0);
        }
        touching.truncate(count);
    }

    #[target_feature(enable = "avx2")]
    pub(super) fn inner_pairs(
        lanes: &Lanes<'_>,
        forces: &mut [[f64; 4]],
        deepest: &mut Deepest,
        touching: &mut Vec<u32>,
    ) -> usize {
        let columns = Columns::of(lanes);
        let whole = columns.firsts.len();
        let [dense, sparse] = columns.split_at(Ord::min(lanes.dense.div_ceil(LANES), whole));
        // Also a list out of a damaged checkpoint must not reach beyond.
        let rows = Ord::min(lanes.own.len(), forces.len());
        assert!(columns.beyond() < rows, "a pair of no disc");
        // SAFETY: no index reaches beyond the rows.
        unsafe {
            touching_fours(sparse, lanes.own, touching);
            push(lanes, dense.all(), forces, deepest);
            push(lanes, touching.iter().map(|&number| sparse.at(number)), forces, deepest);
        }
        whole * LANES
    }

    /// Adds the forces of pairs. All indices must be those of rows of discs and of forces.
    #[inline]
    #[target_feature(enable = "avx2")]
    unsafe fn push<'a>(
        lanes: &Lanes<'_>,
        fours: impl Iterator<Item = Four<'a>>,
        forces: &mut [[f64; 4]],
        deepest: &mut Deepest,
    ) {
        let Lanes { own, radii, law, .. } = *lanes;
        let stiffness = _mm256_set1_pd(law.stiffness);
        let floor = _mm256_set1_pd(law.least_force());
        let smallest = _mm256_set1_pd(f64::MIN_POSITIVE);
        let one = _mm256_set1_pd(1.0);
        for Four { first, second, reach, damping } in fours {
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
            let (reach, damping) = (load(reach), load(damping));
            let squared = _mm256_add_pd(_mm256_mul_pd(x, x), _mm256_mul_pd(y, y));
            let touch = _mm256_cmp_pd::<_CMP_LT_OQ>(squared, _mm256_mul_pd(reach, reach));
            let touching = _mm256_movemask_pd(touch);
            if touching == 0 {
                continue;
            }
            let distance = _mm256_sqrt_pd(squared);
            let inverse = _mm256_div_pd(one, _mm256_max_pd(distance, smallest));
            let (nx, ny) = (_mm256_mul_pd(x, inverse), _mm256_mul_pd(y, inverse));
            let speed = _mm256_add_pd(_mm256_mul_pd(vx, nx), _mm256_mul_pd(vy, ny));
            let overlap = _mm256_sub_pd(reach, distance);
            let spring = _mm256_mul_pd(stiffness, overlap);
            let force = _mm256_sub_pd(spring, _mm256_mul_pd(damping, speed));
            let force = _mm256_max_pd(force, floor);
            let loss = _mm256_and_pd(_mm256_sub_pd(spring, force), touch);
            let force = _mm256_and_pd(force, touch);
            let (nx, ny) = (_mm256_and_pd(nx, touch), _mm256_and_pd(ny, touch));
            let rows = transposed([
                _mm256_mul_pd(force, nx),
                _mm256_mul_pd(force, ny),
                _mm256_mul_pd(loss, nx),
                _mm256_mul_pd(loss, ny),
            ]);
            let deep = _mm256_cmp_pd::<_CMP_GT_OQ>(overlap, _mm256_set1_pd(deepest.bound()));
            if _mm256_movemask_pd(_mm256_and_pd(deep, touch)) != 0 {
                let mut overlaps = [0.0; 4];
                store(&mut overlaps, overlap);
                for lane in (0..LANES).filter(|lane| touching >> lane & 1 == 1) {
                    let ends = [first[lane] as usize, second[lane] as usize];
                    deepest.note_pair(overlaps[lane], ends, radii);
                }
            }
            // A pair apart adds +0, which changes no bit: a sum that began with +0 is never -0. It costs less than a branch.
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
