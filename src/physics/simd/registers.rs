//! Registers of four (AVX2) or eight (AVX-512) numbers, so that a formula is written once for both: `+`, `-`, `*`, `/` and
//! the rest act lane by lane, rounded as those of single numbers are, and never fused.
//!
//! What the unsafe code keeps to:
//! - A [`Machine`] is a proof that this machine has the instructions: only `run` makes one, after it has looked. Every
//!   register comes out of a machine, so that what is done with it needs no second look.
//! - Loads and stores go through references to as many numbers as are moved, and are unaligned by instruction.
//! - Everything is inlined into one of the two functions that are compiled for the instructions.

#![allow(unsafe_code)]

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A loop over columns of numbers for any width. `run` must be `#[inline(always)]`.
pub(crate) trait Kernel {
    /// What it returns.
    type Output;

    /// Runs the loop.
    fn run<const N: usize, M: Machine<N>>(self, machine: M) -> Self::Output;
}

/// Proof of instructions for `N` numbers at a time; makes registers.
pub(crate) trait Machine<const N: usize>: Copy {
    type Lanes: Lanes<N>;

    /// One number in all lanes.
    fn all(self, value: f64) -> Self::Lanes;

    /// A number a lane.
    fn of(self, values: [f64; N]) -> Self::Lanes;

    /// A number a lane, out of memory.
    fn load(self, values: &[f64; N]) -> Self::Lanes;

    /// Vectors `first` minus vectors `second`, along x and along y.
    fn differences(self, vectors: &[[f64; 2]], ends: [&[u32; N]; 2]) -> [Self::Lanes; 2];
}

/// A register. Each lane holds a number.
pub(crate) trait Lanes<const N: usize>:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// Yes or no for each lane.
    type Mask: Mask;

    fn sqrt(self) -> Self;
    fn abs(self) -> Self;

    /// `if self > other { self } else { other }`
    fn larger(self, other: Self) -> Self;
    fn is_less(self, other: Self) -> Self::Mask;
    fn is_at_most(self, other: Self) -> Self::Mask;

    /// `if mask { self } else { other }`
    fn or_else(self, mask: Self::Mask, other: Self) -> Self;

    /// `if mask { self } else { 0.0 }`
    fn only(self, mask: Self::Mask) -> Self;
    fn store(self, into: &mut [f64; N]);

    /// Adds rows, given by columns, to sums at `first`, and takes them off those at `second`.
    fn add_opposite(columns: [Self; 4], sums: &mut [[f64; 4]], ends: [&[u32; N]; 2]);

    /// Adds rows, given by columns, to sums at both ends.
    fn add_to_both(columns: [Self; 2], sums: &mut [[f64; 2]], ends: [&[u32; N]; 2]);
}

/// Yes or no for each lane.
pub(crate) trait Mask: Copy {
    /// A bit a lane, the first the lowest.
    fn bits(self) -> u32;
}

/// Runs a kernel with at most `most` lanes; `None` where this machine has no such registers.
#[cfg(target_arch = "x86_64")]
pub(crate) fn run<K: Kernel>(kernel: K, most: usize) -> Option<K::Output> {
    if most >= 8 && std::arch::is_x86_feature_detected!("avx512f") {
        // SAFETY: the machine has AVX-512.
        return Some(unsafe { avx512::run(kernel) });
    }
    if most >= 4 && std::arch::is_x86_feature_detected!("avx2") {
        // SAFETY: the machine has AVX2.
        return Some(unsafe { avx2::run(kernel) });
    }
    None
}

/// Runs a kernel with at most `most` lanes; `None` where this machine has no such registers.
#[cfg(not(target_arch = "x86_64"))]
pub(crate) fn run<K: Kernel>(_: K, _: usize) -> Option<K::Output> {
    None
}

/// Lane by lane operators of a register type.
#[cfg(target_arch = "x86_64")]
macro_rules! operators {
    ($register:ident: $($operator:ident $name:ident $intrinsic:ident),*) => {
        $(impl $operator for $register {
            type Output = Self;

            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                // SAFETY: a register is proof of its instructions.
                Self(unsafe { $intrinsic(self.0, other.0) })
            }
        })*
    };
}

/// What both widths do with rows.
#[cfg(target_arch = "x86_64")]
mod rows {
    use std::arch::x86_64::*;

    /// Two rows in one register.
    ///
    /// # Safety
    /// The machine has AVX.
    #[inline(always)]
    pub(super) unsafe fn two(low: &[f64; 2], high: &[f64; 2]) -> __m256d {
        // SAFETY: the caller knows the machine; two f64 lie behind each reference.
        unsafe {
            let (low, high) = (_mm_loadu_pd(low.as_ptr()), _mm_loadu_pd(high.as_ptr()));
            _mm256_insertf128_pd::<1>(_mm256_castpd128_pd256(low), high)
        }
    }

    /// Adds rows to sums at `first`, and takes them off those at `second`.
    ///
    /// # Safety
    /// The machine has AVX.
    #[inline(always)]
    pub(super) unsafe fn add_opposite<const N: usize>(
        rows: [__m256d; N],
        sums: &mut [[f64; 4]],
        [first, second]: [&[u32; N]; 2],
    ) {
        for lane in 0..N {
            let sum = &mut sums[first[lane] as usize];
            // SAFETY: the caller knows the machine; four f64 lie behind the reference.
            unsafe {
                let added = _mm256_add_pd(_mm256_loadu_pd(sum.as_ptr()), rows[lane]);
                _mm256_storeu_pd(sum.as_mut_ptr(), added);
            }
            let sum = &mut sums[second[lane] as usize];
            // SAFETY: the caller knows the machine; four f64 lie behind the reference.
            unsafe {
                let taken = _mm256_sub_pd(_mm256_loadu_pd(sum.as_ptr()), rows[lane]);
                _mm256_storeu_pd(sum.as_mut_ptr(), taken);
            }
        }
    }

    /// Adds rows to sums at both ends.
    ///
    /// # Safety
    /// The machine has AVX.
    #[inline(always)]
    pub(super) unsafe fn add_to_both<const N: usize>(
        rows: [__m128d; N],
        sums: &mut [[f64; 2]],
        [first, second]: [&[u32; N]; 2],
    ) {
        for lane in 0..N {
            for end in [first[lane], second[lane]] {
                let sum = &mut sums[end as usize];
                // SAFETY: the caller knows the machine; two f64 lie behind the reference.
                unsafe {
                    let added = _mm_add_pd(_mm_loadu_pd(sum.as_ptr()), rows[lane]);
                    _mm_storeu_pd(sum.as_mut_ptr(), added);
                }
            }
        }
    }
}

#[cfg(target_arch = "x86_64")]
pub(crate) mod avx2 {
    use super::{Add, Div, Kernel, Lanes, Machine, Mask, Mul, Neg, Sub, rows};
    use std::arch::x86_64::*;

    #[derive(Clone, Copy)]
    struct Avx2(());

    #[derive(Clone, Copy)]
    struct Four(__m256d);

    #[derive(Clone, Copy)]
    struct FourMask(__m256d);

    #[target_feature(enable = "avx2")]
    pub(super) fn run<K: Kernel>(kernel: K) -> K::Output {
        kernel.run(Avx2(()))
    }

    operators!(Four: Add add _mm256_add_pd, Sub sub _mm256_sub_pd, Mul mul _mm256_mul_pd, Div div _mm256_div_pd);

    /// Rows to columns, and back.
    #[inline]
    #[target_feature(enable = "avx2")]
    pub(crate) fn transposed(rows: [__m256d; 4]) -> [__m256d; 4] {
        let low = [_mm256_unpacklo_pd(rows[0], rows[1]), _mm256_unpacklo_pd(rows[2], rows[3])];
        let high = [_mm256_unpackhi_pd(rows[0], rows[1]), _mm256_unpackhi_pd(rows[2], rows[3])];
        [
            _mm256_permute2f128_pd::<0x20>(low[0], low[1]),
            _mm256_permute2f128_pd::<0x20>(high[0], high[1]),
            _mm256_permute2f128_pd::<0x31>(low[0], low[1]),
            _mm256_permute2f128_pd::<0x31>(high[0], high[1]),
        ]
    }

    impl Machine<4> for Avx2 {
        type Lanes = Four;

        #[inline(always)]
        fn all(self, value: f64) -> Four {
            // SAFETY: the machine is proof of AVX2.
            Four(unsafe { _mm256_set1_pd(value) })
        }

        #[inline(always)]
        fn of(self, [a, b, c, d]: [f64; 4]) -> Four {
            // SAFETY: the machine is proof of AVX2.
            Four(unsafe { _mm256_setr_pd(a, b, c, d) })
        }

        #[inline(always)]
        fn load(self, values: &[f64; 4]) -> Four {
            // SAFETY: the machine is proof of AVX2, and four f64 lie behind the reference.
            Four(unsafe { _mm256_loadu_pd(values.as_ptr()) })
        }

        #[inline(always)]
        fn differences(self, vectors: &[[f64; 2]], ends: [&[u32; 4]; 2]) -> [Four; 2] {
            let even =
                (self.every_other(vectors, ends[0], 0) - self.every_other(vectors, ends[1], 0)).0;
            let odd =
                (self.every_other(vectors, ends[0], 1) - self.every_other(vectors, ends[1], 1)).0;
            // SAFETY: the machine is proof of AVX2.
            unsafe { [Four(_mm256_unpacklo_pd(even, odd)), Four(_mm256_unpackhi_pd(even, odd))] }
        }
    }

    impl Avx2 {
        /// Every other of some vectors, from one of the first two on.
        #[inline(always)]
        fn every_other(self, vectors: &[[f64; 2]], ends: &[u32; 4], from: usize) -> Four {
            let (low, high) = (ends[from] as usize, ends[from + 2] as usize);
            // SAFETY: the machine is proof of AVX2.
            Four(unsafe { rows::two(&vectors[low], &vectors[high]) })
        }
    }

    impl Neg for Four {
        type Output = Self;

        #[inline(always)]
        fn neg(self) -> Self {
            // SAFETY: a register is proof of its instructions.
            Self(unsafe { _mm256_xor_pd(self.0, _mm256_set1_pd(-0.0)) })
        }
    }

    impl Mask for FourMask {
        #[inline(always)]
        fn bits(self) -> u32 {
            // SAFETY: a register is proof of its instructions.
            unsafe { _mm256_movemask_pd(self.0) as u32 }
        }
    }

    // SAFETY of all that follows: a register is proof of its instructions; references hold what is moved.
    impl Lanes<4> for Four {
        type Mask = FourMask;

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
        fn is_less(self, other: Self) -> FourMask {
            FourMask(unsafe { _mm256_cmp_pd::<_CMP_LT_OQ>(self.0, other.0) })
        }

        #[inline(always)]
        fn is_at_most(self, other: Self) -> FourMask {
            FourMask(unsafe { _mm256_cmp_pd::<_CMP_LE_OQ>(self.0, other.0) })
        }

        #[inline(always)]
        fn or_else(self, mask: FourMask, other: Self) -> Self {
            Self(unsafe { _mm256_blendv_pd(other.0, self.0, mask.0) })
        }

        #[inline(always)]
        fn only(self, mask: FourMask) -> Self {
            Self(unsafe { _mm256_and_pd(self.0, mask.0) })
        }

        #[inline(always)]
        fn store(self, into: &mut [f64; 4]) {
            unsafe { _mm256_storeu_pd(into.as_mut_ptr(), self.0) }
        }

        #[inline(always)]
        fn add_opposite(columns: [Self; 4], sums: &mut [[f64; 4]], ends: [&[u32; 4]; 2]) {
            let columns = [columns[0].0, columns[1].0, columns[2].0, columns[3].0];
            unsafe { rows::add_opposite(transposed(columns), sums, ends) }
        }

        #[inline(always)]
        fn add_to_both(columns: [Self; 2], sums: &mut [[f64; 2]], ends: [&[u32; 4]; 2]) {
            unsafe {
                let even = _mm256_unpacklo_pd(columns[0].0, columns[1].0);
                let odd = _mm256_unpackhi_pd(columns[0].0, columns[1].0);
                let rows = [
                    _mm256_castpd256_pd128(even),
                    _mm256_castpd256_pd128(odd),
                    _mm256_extractf128_pd::<1>(even),
                    _mm256_extractf128_pd::<1>(odd),
                ];
                rows::add_to_both(rows, sums, ends);
            }
        }
    }
}

#[cfg(target_arch = "x86_64")]
mod avx512 {
    use super::{Add, Div, Kernel, Lanes, Machine, Mask, Mul, Neg, Sub, rows};
    use std::arch::x86_64::*;

    #[derive(Clone, Copy)]
    struct Avx512(());

    #[derive(Clone, Copy)]
    struct Eight(__m512d);

    impl Mask for __mmask8 {
        #[inline(always)]
        fn bits(self) -> u32 {
            u32::from(self)
        }
    }

    #[target_feature(enable = "avx512f")]
    pub(super) fn run<K: Kernel>(kernel: K) -> K::Output {
        kernel.run(Avx512(()))
    }

    operators!(Eight: Add add _mm512_add_pd, Sub sub _mm512_sub_pd, Mul mul _mm512_mul_pd, Div div _mm512_div_pd);

    /// Registers of the rows i and i + 4 to columns, and back.
    #[inline]
    #[target_feature(enable = "avx512f")]
    fn transposed(rows: [__m512d; 4]) -> [__m512d; 4] {
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

    impl Machine<8> for Avx512 {
        type Lanes = Eight;

        #[inline(always)]
        fn all(self, value: f64) -> Eight {
            // SAFETY: the machine is proof of AVX-512.
            Eight(unsafe { _mm512_set1_pd(value) })
        }

        #[inline(always)]
        fn of(self, [a, b, c, d, e, f, g, h]: [f64; 8]) -> Eight {
            // SAFETY: the machine is proof of AVX-512.
            Eight(unsafe { _mm512_setr_pd(a, b, c, d, e, f, g, h) })
        }

        #[inline(always)]
        fn load(self, values: &[f64; 8]) -> Eight {
            // SAFETY: the machine is proof of AVX-512, and eight f64 lie behind the reference.
            Eight(unsafe { _mm512_loadu_pd(values.as_ptr()) })
        }

        #[inline(always)]
        fn differences(self, vectors: &[[f64; 2]], ends: [&[u32; 8]; 2]) -> [Eight; 2] {
            let even =
                (self.every_other(vectors, ends[0], 0) - self.every_other(vectors, ends[1], 0)).0;
            let odd =
                (self.every_other(vectors, ends[0], 1) - self.every_other(vectors, ends[1], 1)).0;
            // SAFETY: the machine is proof of AVX-512.
            unsafe { [Eight(_mm512_unpacklo_pd(even, odd)), Eight(_mm512_unpackhi_pd(even, odd))] }
        }
    }

    impl Avx512 {
        /// Every other of some vectors, from one of the first two on.
        #[inline(always)]
        fn every_other(self, vectors: &[[f64; 2]], ends: &[u32; 8], from: usize) -> Eight {
            let (a, b) = (ends[from] as usize, ends[from + 2] as usize);
            let (c, d) = (ends[from + 4] as usize, ends[from + 6] as usize);
            // SAFETY: the machine is proof of AVX-512.
            Eight(unsafe {
                let low = _mm512_castpd256_pd512(rows::two(&vectors[a], &vectors[b]));
                _mm512_insertf64x4::<1>(low, rows::two(&vectors[c], &vectors[d]))
            })
        }
    }

    impl Neg for Eight {
        type Output = Self;

        #[inline(always)]
        fn neg(self) -> Self {
            // SAFETY: a register is proof of its instructions.
            Self(unsafe {
                let sign = _mm512_castpd_si512(_mm512_set1_pd(-0.0));
                _mm512_castsi512_pd(_mm512_xor_si512(_mm512_castpd_si512(self.0), sign))
            })
        }
    }

    // SAFETY of all that follows: a register is proof of its instructions; references hold what is moved.
    impl Lanes<8> for Eight {
        type Mask = __mmask8;

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
        fn only(self, mask: __mmask8) -> Self {
            Self(unsafe { _mm512_maskz_mov_pd(mask, self.0) })
        }

        #[inline(always)]
        fn store(self, into: &mut [f64; 8]) {
            unsafe { _mm512_storeu_pd(into.as_mut_ptr(), self.0) }
        }

        #[inline(always)]
        fn add_opposite(columns: [Self; 4], sums: &mut [[f64; 4]], ends: [&[u32; 8]; 2]) {
            let columns = [columns[0].0, columns[1].0, columns[2].0, columns[3].0];
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
                rows::add_opposite(rows, sums, ends);
            }
        }

        #[inline(always)]
        fn add_to_both(columns: [Self; 2], sums: &mut [[f64; 2]], ends: [&[u32; 8]; 2]) {
            unsafe {
                let even = _mm512_unpacklo_pd(columns[0].0, columns[1].0);
                let odd = _mm512_unpackhi_pd(columns[0].0, columns[1].0);
                let (low_even, low_odd) =
                    (_mm512_castpd512_pd256(even), _mm512_castpd512_pd256(odd));
                let (high_even, high_odd) =
                    (_mm512_extractf64x4_pd::<1>(even), _mm512_extractf64x4_pd::<1>(odd));
                let rows = [
                    _mm256_castpd256_pd128(low_even),
                    _mm256_castpd256_pd128(low_odd),
                    _mm256_extractf128_pd::<1>(low_even),
                    _mm256_extractf128_pd::<1>(low_odd),
                    _mm256_castpd256_pd128(high_even),
                    _mm256_castpd256_pd128(high_odd),
                    _mm256_extractf128_pd::<1>(high_even),
                    _mm256_extractf128_pd::<1>(high_odd),
                ];
                rows::add_to_both(rows, sums, ends);
            }
        }
    }
}
