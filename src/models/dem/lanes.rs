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

/// Adds the forces of as many pairs as fill whole lanes, and returns their number: 0 where the machine has no AVX2.
pub(super) fn inner_pairs(
    pairs: &Pairs,
    own: &[[f64; 4]],
    radii: &[f64],
    law: &ContactLaw,
    forces: &mut [[f64; 4]],
    deepest: &mut Deepest,
) -> usize {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") {
        // SAFETY: the machine has AVX2.
        return unsafe { avx2::inner_pairs(pairs, own, radii, law, forces, deepest) };
    }
    0
}

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use super::{ContactLaw, Deepest, LANES, Pairs};
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

    /// Rows to columns.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn transposed(rows: [__m256d; 4]) -> [__m256d; 4] {
        let low = [_mm256_unpacklo_pd(rows[0], rows[1]), _mm256_unpacklo_pd(rows[2], rows[3])];
        let high = [_mm256_unpackhi_pd(rows[0], rows[1]), _mm256_unpackhi_pd(rows[2], rows[3])];
        [
            _mm256_permute2f128_pd::<0x20>(low[0], low[1]),
            _mm256_permute2f128_pd::<0x20>(high[0], high[1]),
            _mm256_permute2f128_pd::<0x31>(low[0], low[1]),
            _mm256_permute2f128_pd::<0x31>(high[0], high[1]),
        ]
    }

    #[target_feature(enable = "avx2")]
    pub(super) fn inner_pairs(
        pairs: &Pairs,
        own: &[[f64; 4]],
        radii: &[f64],
        law: &ContactLaw,
        forces: &mut [[f64; 4]],
        deepest: &mut Deepest,
    ) -> usize {
        let (firsts, _) = pairs.first.as_chunks::<LANES>();
        let (seconds, _) = pairs.second.as_chunks::<LANES>();
        let (reaches, _) = pairs.reach.as_chunks::<LANES>();
        let (dampings, _) = pairs.damping.as_chunks::<LANES>();
        // Also a list out of a damaged checkpoint must not reach beyond.
        let largest = |of: &[u32]| of.iter().fold(0, |most, &index| Ord::max(most, index)) as usize;
        let beyond = Ord::max(largest(&pairs.first), largest(&pairs.second));
        assert!(beyond < own.len() && own.len() <= forces.len(), "a pair of no disc");
        let stiffness = _mm256_set1_pd(law.stiffness);
        let floor = _mm256_set1_pd(law.least_force());
        let smallest = _mm256_set1_pd(f64::MIN_POSITIVE);
        let one = _mm256_set1_pd(1.0);
        for (((first, second), reach), damping) in
            firsts.iter().zip(seconds).zip(reaches).zip(dampings)
        {
            let apart = |lane: usize| {
                let (a, b) = (first[lane] as usize, second[lane] as usize);
                // SAFETY: no index reaches beyond, see above.
                let (a, b) = unsafe { (own.get_unchecked(a), own.get_unchecked(b)) };
                _mm256_sub_pd(load(a), load(b))
            };
            let [x, y, vx, vy] = transposed([apart(0), apart(1), apart(2), apart(3)]);
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
                // SAFETY: as above.
                let on_first = unsafe { forces.get_unchecked_mut(first[lane] as usize) };
                let sum = _mm256_add_pd(load(on_first), row);
                store(on_first, sum);
                // SAFETY: as above.
                let on_second = unsafe { forces.get_unchecked_mut(second[lane] as usize) };
                let sum = _mm256_sub_pd(load(on_second), row);
                store(on_second, sum);
            }
        }
        firsts.len() * LANES
    }
}
