//! Registers of eight numbers with AVX-512.
//!
//! # Safety
//! - `Avx512` is created only by [`run`], which is called only where the processor has its instructions. Every register is
//!   created in code compiled for them; therefore, intrinsics are allowed wherever there is a register.
//! - Loads and stores go through references to as many numbers as are moved, and are unaligned by instruction.

#![allow(unsafe_code)]

use super::avx2::{
    add_opposite_rows, add_rows_to_ends, operators, rows_of_two, store_selected_numbers,
    two_vectors,
};
use super::registers::{InstructionSet, Kernel, Mask, Register};
use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// Proof that the processor has AVX-512 F and VL, AVX2, BMI and POPCNT.
#[derive(Clone, Copy)]
struct Avx512(());

/// Eight numbers in one register.
#[derive(Clone, Copy)]
pub(crate) struct F64x8(__m512d);

#[target_feature(enable = "avx2,avx512f,avx512vl,bmi1,bmi2,popcnt")]
pub(super) fn run<K: Kernel>(kernel: K) -> K::Output {
    kernel.run(Avx512(()))
}

operators!(F64x8: Add add _mm512_add_pd, Sub sub _mm512_sub_pd, Mul mul _mm512_mul_pd, Div div _mm512_div_pd);

impl Avx512 {
    /// Four vectors in one register.
    ///
    /// # Safety
    /// - Every index is less than the number of vectors.
    #[inline(always)]
    unsafe fn four_vectors(self, vectors: &[[f64; 2]], [a, b, c, d]: [u16; 4]) -> __m512d {
        // SAFETY: the caller checked the indices.
        unsafe {
            let low = _mm512_castpd256_pd512(two_vectors(vectors, [a, b]));
            _mm512_insertf64x4::<1>(low, two_vectors(vectors, [c, d]))
        }
    }
}

/// Registers of the rows i and i + 4 to columns, and back.
///
/// # Safety
/// - The processor has AVX-512.
#[inline(always)]
unsafe fn transposed(rows: [__m512d; 4]) -> [__m512d; 4] {
    // SAFETY: the caller checked the processor.
    unsafe {
        let low = [_mm512_unpacklo_pd(rows[0], rows[1]), _mm512_unpacklo_pd(rows[2], rows[3])];
        let high = [_mm512_unpackhi_pd(rows[0], rows[1]), _mm512_unpackhi_pd(rows[2], rows[3])];
        let front = _mm512_setr_epi64(0, 1, 8, 9, 4, 5, 12, 13);
        let back = _mm512_setr_epi64(2, 3, 10, 11, 6, 7, 14, 15);
        [
            _mm512_permutex2var_pd(low[0], front, low[1]),
            _mm512_permutex2var_pd(high[0], front, high[1]),
            _mm512_permutex2var_pd(low[0], back, low[1]),
            _mm512_permutex2var_pd(high[0], back, high[1]),
        ]
    }
}

/// The rows of two columns.
///
/// # Safety
/// - The processor has AVX-512.
#[inline(always)]
unsafe fn eight_rows_of_two([x, y]: [F64x8; 2]) -> [__m128d; 8] {
    // SAFETY: the caller checked the processor.
    unsafe {
        let (low_x, low_y) = (_mm512_castpd512_pd256(x.0), _mm512_castpd512_pd256(y.0));
        let high_x = _mm512_extractf64x4_pd::<1>(x.0);
        let [a, b, c, d] = rows_of_two(low_x, low_y);
        let [e, f, g, h] = rows_of_two(high_x, _mm512_extractf64x4_pd::<1>(y.0));
        [a, b, c, d, e, f, g, h]
    }
}

// SAFETY of all that follows: the instruction set and its registers prove the instructions; references hold what is moved.
impl InstructionSet<8> for Avx512 {
    type Register = F64x8;

    #[inline(always)]
    fn splat(self, value: f64) -> F64x8 {
        F64x8(unsafe { _mm512_set1_pd(value) })
    }

    #[inline(always)]
    fn load(self, values: &[f64; 8]) -> F64x8 {
        F64x8(unsafe { _mm512_loadu_pd(values.as_ptr()) })
    }

    #[inline(always)]
    fn store(self, register: F64x8, into: &mut [f64; 8]) {
        unsafe { _mm512_storeu_pd(into.as_mut_ptr(), register.0) }
    }

    #[inline(always)]
    fn columns(self, vectors: &[[f64; 2]; 8]) -> [F64x8; 2] {
        let rows = vectors.as_flattened();
        unsafe {
            let low = _mm512_loadu_pd(rows[..8].as_ptr());
            let high = _mm512_loadu_pd(rows[8..].as_ptr());
            let even = _mm512_setr_epi64(0, 2, 4, 6, 8, 10, 12, 14);
            let odd = _mm512_setr_epi64(1, 3, 5, 7, 9, 11, 13, 15);
            [even, odd].map(|order| F64x8(_mm512_permutex2var_pd(low, order, high)))
        }
    }

    #[inline(always)]
    unsafe fn differences(
        self,
        vectors: &[[f64; 2]],
        [first, second]: [&[u16; 8]; 2],
    ) -> [F64x8; 2] {
        let [a, b, c, d, e, f, g, h] = *first;
        let [i, j, k, l, m, n, o, p] = *second;
        // SAFETY: the caller checked the indices.
        unsafe {
            let even = _mm512_sub_pd(
                self.four_vectors(vectors, [a, c, e, g]),
                self.four_vectors(vectors, [i, k, m, o]),
            );
            let odd = _mm512_sub_pd(
                self.four_vectors(vectors, [b, d, f, h]),
                self.four_vectors(vectors, [j, l, n, p]),
            );
            [F64x8(_mm512_unpacklo_pd(even, odd)), F64x8(_mm512_unpackhi_pd(even, odd))]
        }
    }

    #[inline(always)]
    unsafe fn add_opposite(self, columns: [F64x8; 4], sums: &mut [[f64; 4]], ends: [&[u16; 8]; 2]) {
        let columns = [columns[0].0, columns[1].0, columns[2].0, columns[3].0];
        // SAFETY: the caller checked the indices.
        unsafe {
            let [a, b, c, d] = transposed(columns);
            let rows = [
                _mm512_castpd512_pd256(a),
                _mm512_castpd512_pd256(b),
                _mm512_castpd512_pd256(c),
                _mm512_castpd512_pd256(d),
                _mm512_extractf64x4_pd::<1>(a),
                _mm512_extractf64x4_pd::<1>(b),
                _mm512_extractf64x4_pd::<1>(c),
                _mm512_extractf64x4_pd::<1>(d),
            ];
            add_opposite_rows(rows, sums, ends);
        }
    }

    #[inline(always)]
    unsafe fn add_to_ends(
        self,
        columns: [[F64x8; 2]; 2],
        sums: &mut [[f64; 2]],
        ends: [&[u16; 8]; 2],
    ) {
        // SAFETY: the caller checked the indices.
        unsafe {
            let rows = [eight_rows_of_two(columns[0]), eight_rows_of_two(columns[1])];
            add_rows_to_ends(rows, sums, ends);
        }
    }

    #[inline(always)]
    unsafe fn gather_vectors(
        self,
        vectors: &[[f64; 2]],
        &[a, b, c, d, e, f, g, h]: &[u16; 8],
    ) -> [F64x8; 2] {
        // SAFETY: the caller checked the indices.
        unsafe {
            let even = self.four_vectors(vectors, [a, c, e, g]);
            let odd = self.four_vectors(vectors, [b, d, f, h]);
            [F64x8(_mm512_unpacklo_pd(even, odd)), F64x8(_mm512_unpackhi_pd(even, odd))]
        }
    }

    #[inline(always)]
    fn floor(self, register: F64x8) -> F64x8 {
        // Toward minus infinity, without exceptions.
        F64x8(unsafe { _mm512_roundscale_pd::<9>(register.0) })
    }

    #[inline(always)]
    fn by_last_bit(self, bits: F64x8, odd: F64x8, even: F64x8) -> F64x8 {
        unsafe {
            let is_odd = _mm512_test_epi64_mask(_mm512_castpd_si512(bits.0), _mm512_set1_epi64(1));
            F64x8(_mm512_mask_blend_pd(is_odd, even.0, odd.0))
        }
    }

    #[inline(always)]
    fn inverted_by_second_bit(self, bits: F64x8, numbers: F64x8) -> F64x8 {
        unsafe {
            let shifted = _mm512_slli_epi64::<62>(_mm512_castpd_si512(bits.0));
            let sign = _mm512_and_si512(shifted, _mm512_set1_epi64(i64::MIN));
            F64x8(_mm512_castsi512_pd(_mm512_xor_si512(_mm512_castpd_si512(numbers.0), sign)))
        }
    }

    #[inline(always)]
    fn store_selected(self, register: F64x8, lanes: u32, into: &mut [f64; 8]) {
        self.store(F64x8(unsafe { _mm512_maskz_compress_pd(lanes as u8, register.0) }), into);
    }

    #[inline(always)]
    fn store_selected_pairs(self, [first, second]: [u32; 2], lanes: u32, into: &mut [[u32; 2]; 8]) {
        // The first index below, the second above.
        let ends = (u64::from(second) << 32 | u64::from(first)) as i64;
        unsafe {
            let lane = _mm512_setr_epi32(0, 0, 0, 1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 6, 0, 7);
            let pairs = _mm512_add_epi32(_mm512_set1_epi64(ends), lane);
            let packed = _mm512_maskz_compress_epi64(lanes as u8, pairs);
            _mm512_storeu_si512(into.as_mut_ptr().cast(), packed);
        }
    }

    #[inline(always)]
    fn store_selected_numbers(self, first: u32, selected: u32, into: &mut [u32; 8]) {
        unsafe { store_selected_numbers(first, selected, into) }
    }
}

impl Mask for __mmask8 {
    #[inline(always)]
    fn bits(self) -> u32 {
        u32::from(self)
    }
}

impl Neg for F64x8 {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(unsafe {
            let sign = _mm512_castpd_si512(_mm512_set1_pd(-0.0));
            _mm512_castsi512_pd(_mm512_xor_si512(_mm512_castpd_si512(self.0), sign))
        })
    }
}

impl Register for F64x8 {
    type Mask = __mmask8;

    #[inline(always)]
    fn splat(self, value: f64) -> Self {
        Self(unsafe { _mm512_set1_pd(value) })
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(unsafe { _mm512_sqrt_pd(self.0) })
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(unsafe { _mm512_abs_pd(self.0) })
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        Self(unsafe { _mm512_max_pd(self.0, other.0) })
    }

    #[inline(always)]
    fn is_less(self, other: Self) -> __mmask8 {
        unsafe { _mm512_cmp_pd_mask::<_CMP_LT_OQ>(self.0, other.0) }
    }

    #[inline(always)]
    fn is_at_most(self, other: Self) -> __mmask8 {
        unsafe { _mm512_cmp_pd_mask::<_CMP_LE_OQ>(self.0, other.0) }
    }

    #[inline(always)]
    fn or_else(self, mask: __mmask8, other: Self) -> Self {
        Self(unsafe { _mm512_mask_blend_pd(mask, other.0, self.0) })
    }

    #[inline(always)]
    fn or_zero(self, mask: __mmask8) -> Self {
        Self(unsafe { _mm512_maskz_mov_pd(mask, self.0) })
    }
}
