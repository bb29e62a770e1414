//! Registers of four numbers with AVX2.
//!
//! # Safety
//! - `Avx2` is created only by [`run`], which is called only where the processor has its instructions. Every register comes
//!   from it; therefore, intrinsics are allowed wherever there is a register.
//! - Loads and stores go through references to as many numbers as are moved, and are unaligned by instruction.

#![allow(unsafe_code)]

use super::registers::{InstructionSet, Kernel, Mask, Register, SELECTED_FIRST, selected_first};
use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Sub};

/// Proof that the processor has AVX2, BMI and POPCNT.
#[derive(Clone, Copy)]
struct Avx2(());

#[derive(Clone, Copy)]
pub(crate) struct F64x4(pub(crate) __m256d);

#[derive(Clone, Copy)]
pub(crate) struct MaskX4(__m256d);

#[target_feature(enable = "avx2,bmi1,bmi2,popcnt")]
pub(super) fn run<K: Kernel>(kernel: K) -> K::Output {
    kernel.run(Avx2(()))
}

/// Lane by lane operators of a register type.
macro_rules! operators {
    ($register:ident: $($operator:ident $name:ident $intrinsic:ident),*) => {
        $(impl $operator for $register {
            type Output = Self;

            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                // SAFETY: a register proves its instructions.
                Self(unsafe { $intrinsic(self.0, other.0) })
            }
        })*
    };
}
pub(super) use operators;

operators!(F64x4: Add add _mm256_add_pd, Sub sub _mm256_sub_pd, Mul mul _mm256_mul_pd, Div div _mm256_div_pd);
operators!(MaskX4: BitAnd bitand _mm256_and_pd, BitOr bitor _mm256_or_pd);

/// Two vectors in one register.
///
/// # Safety
/// - The processor has AVX.
/// - Both indices are less than the number of vectors.
#[inline(always)]
pub(super) unsafe fn two_vectors(vectors: &[[f64; 2]], [low, high]: [u16; 2]) -> __m256d {
    // SAFETY: the caller checked the processor and the indices; two f64 lie behind each reference.
    unsafe {
        let low = vectors.get_unchecked(usize::from(low));
        let high = vectors.get_unchecked(usize::from(high));
        let (low, high) = (_mm_loadu_pd(low.as_ptr()), _mm_loadu_pd(high.as_ptr()));
        _mm256_insertf128_pd::<1>(_mm256_castpd128_pd256(low), high)
    }
}

/// Adds rows to the sums at `first`, and subtracts them from those at `second`.
///
/// # Safety
/// - The processor has AVX.
/// - Every index is less than the number of sums.
#[inline(always)]
pub(super) unsafe fn add_opposite_rows<const N: usize>(
    rows: [__m256d; N],
    sums: &mut [[f64; 4]],
    [first, second]: [&[u16; N]; 2],
) {
    for lane in 0..N {
        // SAFETY: the caller checked the processor and the indices; four f64 lie behind each reference.
        unsafe {
            let sum = sums.get_unchecked_mut(usize::from(first[lane])).as_mut_ptr();
            _mm256_storeu_pd(sum, _mm256_add_pd(_mm256_loadu_pd(sum), rows[lane]));
            let sum = sums.get_unchecked_mut(usize::from(second[lane])).as_mut_ptr();
            _mm256_storeu_pd(sum, _mm256_sub_pd(_mm256_loadu_pd(sum), rows[lane]));
        }
    }
}

/// Adds rows to the sums at either end.
///
/// # Safety
/// - The processor has AVX.
/// - Every index is less than the number of sums.
#[inline(always)]
pub(super) unsafe fn add_rows_to_ends<const N: usize>(
    rows: [[__m128d; N]; 2],
    sums: &mut [[f64; 2]],
    [first, second]: [&[u16; N]; 2],
) {
    for lane in 0..N {
        for (end, rows) in [(first[lane], &rows[0]), (second[lane], &rows[1])] {
            // SAFETY: the caller checked the processor and the indices; two f64 lie behind the reference.
            unsafe {
                let sum = sums.get_unchecked_mut(usize::from(end));
                let added = _mm_add_pd(_mm_loadu_pd(sum.as_ptr()), rows[lane]);
                _mm_storeu_pd(sum.as_mut_ptr(), added);
            }
        }
    }
}

/// The rows of two columns.
///
/// # Safety
/// - The processor has AVX.
#[inline(always)]
pub(super) unsafe fn rows_of_two(x: __m256d, y: __m256d) -> [__m128d; 4] {
    // SAFETY: the caller checked the processor.
    unsafe {
        let (even, odd) = (_mm256_unpacklo_pd(x, y), _mm256_unpackhi_pd(x, y));
        [
            _mm256_castpd256_pd128(even),
            _mm256_castpd256_pd128(odd),
            _mm256_extractf128_pd::<1>(even),
            _mm256_extractf128_pd::<1>(odd),
        ]
    }
}

/// Stores those of eight numbers from `first` on that are selected, packed from the front.
///
/// # Safety
/// - The processor has AVX2.
#[inline(always)]
pub(super) unsafe fn store_selected_numbers(first: u32, selected: u32, into: &mut [u32; 8]) {
    let order = &SELECTED_FIRST[(selected & 0xff) as usize];
    // SAFETY: the caller checked the processor; eight u8 and eight u32 lie behind the references.
    unsafe {
        let order = _mm256_cvtepu8_epi32(_mm_loadl_epi64(order.as_ptr().cast()));
        let numbers = _mm256_add_epi32(order, _mm256_set1_epi32(first as i32));
        _mm256_storeu_si256(into.as_mut_ptr().cast(), numbers);
    }
}

/// For each set of four lanes, an order of 32-bit halves that puts the selected lanes first.
static HALVES_SELECTED_FIRST: [[u32; 8]; 16] = {
    let mut orders = [[0; 8]; 16];
    let mut set = 0;
    while set < 16 {
        let lanes = selected_first(set);
        let mut half = 0;
        while half < 8 {
            orders[set][half] = 2 * lanes[half / 2] as u32 + half as u32 % 2;
            half += 1;
        }
        set += 1;
    }
    orders
};

/// Packs the selected lanes to the front.
///
/// # Safety
/// - The processor has AVX2.
#[inline(always)]
unsafe fn packed(lanes: __m256i, selected: u32) -> __m256i {
    let order = &HALVES_SELECTED_FIRST[(selected & 0xf) as usize];
    // SAFETY: the caller checked the processor; eight u32 lie behind the reference.
    unsafe { _mm256_permutevar8x32_epi32(lanes, _mm256_loadu_si256(order.as_ptr().cast())) }
}

/// Rows to columns, and back.
///
/// # Safety
/// - The processor has AVX2.
#[inline(always)]
unsafe fn transposed(rows: [__m256d; 4]) -> [__m256d; 4] {
    // SAFETY: the caller checked the processor.
    unsafe {
        let low = [_mm256_unpacklo_pd(rows[0], rows[1]), _mm256_unpacklo_pd(rows[2], rows[3])];
        let high = [_mm256_unpackhi_pd(rows[0], rows[1]), _mm256_unpackhi_pd(rows[2], rows[3])];
        [
            _mm256_permute2f128_pd::<0x20>(low[0], low[1]),
            _mm256_permute2f128_pd::<0x20>(high[0], high[1]),
            _mm256_permute2f128_pd::<0x31>(low[0], low[1]),
            _mm256_permute2f128_pd::<0x31>(high[0], high[1]),
        ]
    }
}

// SAFETY of all that follows: the instruction set and its registers prove the instructions; references hold what is moved.
impl InstructionSet<4> for Avx2 {
    type Register = F64x4;

    #[inline(always)]
    fn splat(self, value: f64) -> F64x4 {
        F64x4(unsafe { _mm256_set1_pd(value) })
    }

    #[inline(always)]
    fn load(self, values: &[f64; 4]) -> F64x4 {
        F64x4(unsafe { _mm256_loadu_pd(values.as_ptr()) })
    }

    #[inline(always)]
    fn store(self, register: F64x4, into: &mut [f64; 4]) {
        unsafe { _mm256_storeu_pd(into.as_mut_ptr(), register.0) }
    }

    #[inline(always)]
    fn columns(self, vectors: &[[f64; 2]; 4]) -> [F64x4; 2] {
        let rows = vectors.as_flattened();
        unsafe {
            let low = _mm256_loadu_pd(rows[..4].as_ptr());
            let high = _mm256_loadu_pd(rows[4..].as_ptr());
            let even = _mm256_permute2f128_pd::<0x20>(low, high);
            let odd = _mm256_permute2f128_pd::<0x31>(low, high);
            [F64x4(_mm256_unpacklo_pd(even, odd)), F64x4(_mm256_unpackhi_pd(even, odd))]
        }
    }

    #[inline(always)]
    unsafe fn differences(
        self,
        vectors: &[[f64; 2]],
        [[a, b, c, d], [e, f, g, h]]: [&[u16; 4]; 2],
    ) -> [F64x4; 2] {
        // SAFETY: the caller checked the indices.
        unsafe {
            let even =
                _mm256_sub_pd(two_vectors(vectors, [*a, *c]), two_vectors(vectors, [*e, *g]));
            let odd = _mm256_sub_pd(two_vectors(vectors, [*b, *d]), two_vectors(vectors, [*f, *h]));
            [F64x4(_mm256_unpacklo_pd(even, odd)), F64x4(_mm256_unpackhi_pd(even, odd))]
        }
    }

    #[inline(always)]
    unsafe fn add_opposite(self, columns: [F64x4; 4], sums: &mut [[f64; 4]], ends: [&[u16; 4]; 2]) {
        let columns = [columns[0].0, columns[1].0, columns[2].0, columns[3].0];
        // SAFETY: the caller checked the indices.
        unsafe { add_opposite_rows(transposed(columns), sums, ends) }
    }

    #[inline(always)]
    unsafe fn add_to_ends(
        self,
        columns: [[F64x4; 2]; 2],
        sums: &mut [[f64; 2]],
        ends: [&[u16; 4]; 2],
    ) {
        // SAFETY: the caller checked the indices.
        unsafe {
            let [[x, y], [other_x, other_y]] = columns;
            let rows = [rows_of_two(x.0, y.0), rows_of_two(other_x.0, other_y.0)];
            add_rows_to_ends(rows, sums, ends);
        }
    }

    #[inline(always)]
    unsafe fn gather_vectors(self, vectors: &[[f64; 2]], &[a, b, c, d]: &[u16; 4]) -> [F64x4; 2] {
        // SAFETY: the caller checked the indices.
        unsafe {
            let (even, odd) = (two_vectors(vectors, [a, c]), two_vectors(vectors, [b, d]));
            [F64x4(_mm256_unpacklo_pd(even, odd)), F64x4(_mm256_unpackhi_pd(even, odd))]
        }
    }

    #[inline(always)]
    fn floor(self, register: F64x4) -> F64x4 {
        F64x4(unsafe { _mm256_floor_pd(register.0) })
    }

    #[inline(always)]
    fn by_last_bit(self, bits: F64x4, odd: F64x4, even: F64x4) -> F64x4 {
        unsafe {
            let is_odd = _mm256_slli_epi64::<63>(_mm256_castpd_si256(bits.0));
            F64x4(_mm256_blendv_pd(even.0, odd.0, _mm256_castsi256_pd(is_odd)))
        }
    }

    #[inline(always)]
    fn inverted_by_second_bit(self, bits: F64x4, numbers: F64x4) -> F64x4 {
        unsafe {
            let sign = _mm256_slli_epi64::<62>(_mm256_castpd_si256(bits.0));
            let sign = _mm256_and_pd(_mm256_castsi256_pd(sign), _mm256_set1_pd(-0.0));
            F64x4(_mm256_xor_pd(numbers.0, sign))
        }
    }

    #[inline(always)]
    fn store_selected(self, register: F64x4, lanes: u32, into: &mut [f64; 4]) {
        unsafe {
            let packed = packed(_mm256_castpd_si256(register.0), lanes);
            _mm256_storeu_si256(into.as_mut_ptr().cast(), packed);
        }
    }

    #[inline(always)]
    fn store_selected_pairs(self, [first, second]: [u32; 2], lanes: u32, into: &mut [[u32; 2]; 4]) {
        // The first index below, the second above.
        let ends = (u64::from(second) << 32 | u64::from(first)) as i64;
        unsafe {
            let lane = _mm256_setr_epi32(0, 0, 0, 1, 0, 2, 0, 3);
            let pairs = _mm256_add_epi32(_mm256_set1_epi64x(ends), lane);
            _mm256_storeu_si256(into.as_mut_ptr().cast(), packed(pairs, lanes));
        }
    }

    #[inline(always)]
    fn store_selected_numbers(self, first: u32, selected: u32, into: &mut [u32; 8]) {
        unsafe { store_selected_numbers(first, selected, into) }
    }
}

impl Neg for F64x4 {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(unsafe { _mm256_xor_pd(self.0, _mm256_set1_pd(-0.0)) })
    }
}

impl Mask for MaskX4 {
    #[inline(always)]
    fn bits(self) -> u32 {
        unsafe { _mm256_movemask_pd(self.0) as u32 }
    }
}

impl Register for F64x4 {
    type Mask = MaskX4;

    #[inline(always)]
    fn splat(self, value: f64) -> Self {
        Self(unsafe { _mm256_set1_pd(value) })
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(unsafe { _mm256_sqrt_pd(self.0) })
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(unsafe { _mm256_andnot_pd(_mm256_set1_pd(-0.0), self.0) })
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        Self(unsafe { _mm256_max_pd(self.0, other.0) })
    }

    #[inline(always)]
    fn is_less(self, other: Self) -> MaskX4 {
        MaskX4(unsafe { _mm256_cmp_pd::<_CMP_LT_OQ>(self.0, other.0) })
    }

    #[inline(always)]
    fn is_at_most(self, other: Self) -> MaskX4 {
        MaskX4(unsafe { _mm256_cmp_pd::<_CMP_LE_OQ>(self.0, other.0) })
    }

    #[inline(always)]
    fn or_else(self, mask: MaskX4, other: Self) -> Self {
        Self(unsafe { _mm256_blendv_pd(other.0, self.0, mask.0) })
    }

    #[inline(always)]
    fn or_zero(self, mask: MaskX4) -> Self {
        Self(unsafe { _mm256_and_pd(self.0, mask.0) })
    }
}
