//! Pairs of a block side by side, four in a register.
//!
//! What the unsafe code keeps to:
//! - Places are those of discs, unchecked pair by pair: who calls has looked at [`Fours::beyond`] before.
//! - Loads of whole arrays through their own references: in bounds, and unaligned by instruction.
//! - Functions compiled for AVX2, called by others that are compiled for it.

#![allow(unsafe_code)]
#![cfg_attr(
    not(target_arch = "x86_64"),
    allow(dead_code, reason = "only AVX2 takes four at a time")
)]

use crate::dem::neighbors::Pairs;
use std::ops::Range;

/// Pairs at a time.
pub(in crate::dem) const LANES: usize = 4;

/// Pairs four by four: places of their discs in the block, and r_i + r_j, m.
#[derive(Clone, Copy)]
pub(in crate::dem) struct Fours<'a> {
    pub(in crate::dem) firsts: &'a [[u32; LANES]],
    pub(in crate::dem) seconds: &'a [[u32; LANES]],
    pub(in crate::dem) reaches: &'a [[f64; LANES]],
}

impl<'a> Fours<'a> {
    /// Pairs of a list, and the last of them, which fill no lanes.
    pub(in crate::dem) fn of(pairs: &'a Pairs, range: Range<usize>) -> (Self, Range<usize>) {
        let last = range.end - range.len() % LANES..range.end;
        let fours = Self {
            firsts: pairs.first[range.clone()].as_chunks().0,
            seconds: pairs.second[range.clone()].as_chunks().0,
            reaches: pairs.reach[range].as_chunks().0,
        };
        (fours, last)
    }

    /// The largest place.
    pub(in crate::dem) fn beyond(&self) -> usize {
        let largest = |of: &[[u32; LANES]]| {
            of.as_flattened().iter().fold(0, |most, &place| Ord::max(most, place))
        };
        Ord::max(largest(self.firsts), largest(self.seconds)) as usize
    }
}

/// For a set of eight lanes, an order that puts those first that are in it.
pub(in crate::dem) const fn those_first(set: usize) -> [u8; 8] {
    let mut order = [0; 8];
    let (mut lane, mut place) = (0, 0);
    while lane < 8 {
        if set >> lane & 1 == 1 {
            order[place] = lane;
            place += 1;
        }
        lane += 1;
    }
    order
}

/// Vectors of the first discs minus those of the second, of four pairs: along x, and along y.
///
/// # Safety
/// All places must be those of vectors.
#[cfg(target_arch = "x86_64")]
#[inline]
#[target_feature(enable = "avx2")]
pub(in crate::dem) unsafe fn differences(
    vectors: &[[f64; 2]],
    [first, second]: [&[u32; LANES]; 2],
) -> [std::arch::x86_64::__m256d; 2] {
    use std::arch::x86_64::*;
    let apart = |lane: usize, other: usize| {
        let of = |ends: &[u32; LANES]| {
            // SAFETY: the caller's promise; two f64 lie behind each reference.
            unsafe {
                let low = vectors.get_unchecked(ends[lane] as usize);
                let high = vectors.get_unchecked(ends[other] as usize);
                let (low, high) = (_mm_loadu_pd(low.as_ptr()), _mm_loadu_pd(high.as_ptr()));
                _mm256_insertf128_pd::<1>(_mm256_castpd128_pd256(low), high)
            }
        };
        _mm256_sub_pd(of(first), of(second))
    };
    let (even, odd) = (apart(0, 2), apart(1, 3));
    [_mm256_unpacklo_pd(even, odd), _mm256_unpackhi_pd(even, odd)]
}
