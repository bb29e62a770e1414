//! A register of eight numbers (AVX-512).
//!
//! # Safety
//! - A value is created only in functions that are compiled for AVX-512, which run only where the processor has it
//!   (`instruction_set`). Therefore every method may use these instructions.

#![allow(unsafe_code)]

use super::real::Real;
use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Sub};

/// Eight numbers in one register.
#[derive(Clone, Copy)]
pub(crate) struct F64x8(pub(crate) __m512d);

macro_rules! operator {
    ($trait:ident, $method:ident, $instruction:ident) => {
        impl $trait for F64x8 {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: as stated in the module's documentation.
                Self(unsafe { $instruction(self.0, other.0) })
            }
        }
    };
}

operator!(Add, add, _mm512_add_pd);
operator!(Sub, sub, _mm512_sub_pd);
operator!(Mul, mul, _mm512_mul_pd);
operator!(Div, div, _mm512_div_pd);

// SAFETY of every method: as stated in the module's documentation.
impl Real for F64x8 {
    type Mask = __mmask8;

    #[inline(always)]
    fn splat(number: f64) -> Self {
        Self(unsafe { _mm512_set1_pd(number) })
    }

    #[inline(always)]
    fn positive_part(self) -> Self {
        // The instruction returns its second operand if the first is NaN, as the comparison x > 0 does.
        Self(unsafe { _mm512_max_pd(self.0, _mm512_setzero_pd()) })
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(unsafe { _mm512_sqrt_pd(self.0) })
    }

    #[inline(always)]
    fn is_negative(self) -> __mmask8 {
        unsafe { _mm512_cmp_pd_mask::<_CMP_LT_OQ>(self.0, _mm512_setzero_pd()) }
    }

    #[inline(always)]
    fn is_non_negative(self) -> __mmask8 {
        unsafe { _mm512_cmp_pd_mask::<_CMP_GE_OQ>(self.0, _mm512_setzero_pd()) }
    }

    #[inline(always)]
    fn is_non_positive(self) -> __mmask8 {
        unsafe { _mm512_cmp_pd_mask::<_CMP_LE_OQ>(self.0, _mm512_setzero_pd()) }
    }

    #[inline(always)]
    fn select(mask: __mmask8, accepted: Self, rejected: Self) -> Self {
        Self(unsafe { _mm512_mask_blend_pd(mask, rejected.0, accepted.0) })
    }
}
