//! Registers of two numbers with SSE2.
//!
//! # Safety
//! - Every x86-64 processor has SSE2; therefore, these intrinsics are allowed everywhere.

#![allow(unsafe_code)]

use super::avx2::operators;
use super::registers::{Mask, Register};
use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Sub};

/// Two numbers in one register.
#[derive(Clone, Copy)]
pub(crate) struct F64x2(pub(crate) __m128d);

/// One truth value per lane, as all bits of the lane.
#[derive(Clone, Copy)]
pub(crate) struct MaskX2(__m128d);

operators!(F64x2: Add add _mm_add_pd, Sub sub _mm_sub_pd, Mul mul _mm_mul_pd, Div div _mm_div_pd);
operators!(MaskX2: BitAnd bitand _mm_and_pd, BitOr bitor _mm_or_pd);

// SAFETY of all that follows: every x86-64 processor has the instructions.
impl Neg for F64x2 {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(unsafe { _mm_xor_pd(self.0, _mm_set1_pd(-0.0)) })
    }
}

impl Mask for MaskX2 {
    #[inline(always)]
    fn bits(self) -> u32 {
        unsafe { _mm_movemask_pd(self.0).cast_unsigned() }
    }
}

impl Register for F64x2 {
    type Mask = MaskX2;

    #[inline(always)]
    fn splat(self, value: f64) -> Self {
        Self(unsafe { _mm_set1_pd(value) })
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(unsafe { _mm_sqrt_pd(self.0) })
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(unsafe { _mm_andnot_pd(_mm_set1_pd(-0.0), self.0) })
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        Self(unsafe { _mm_max_pd(self.0, other.0) })
    }

    #[inline(always)]
    fn is_less(self, other: Self) -> MaskX2 {
        MaskX2(unsafe { _mm_cmplt_pd(self.0, other.0) })
    }

    #[inline(always)]
    fn is_at_most(self, other: Self) -> MaskX2 {
        MaskX2(unsafe { _mm_cmple_pd(self.0, other.0) })
    }

    #[inline(always)]
    fn or_else(self, mask: MaskX2, other: Self) -> Self {
        Self(unsafe { _mm_or_pd(_mm_and_pd(mask.0, self.0), _mm_andnot_pd(mask.0, other.0)) })
    }

    #[inline(always)]
    fn or_zero(self, mask: MaskX2) -> Self {
        Self(unsafe { _mm_and_pd(self.0, mask.0) })
    }
}
