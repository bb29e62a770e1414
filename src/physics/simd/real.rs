//! Arithmetic that one number and a register of numbers share, so that a formula is written once for both.
//!
//! Invariant: each lane of a register is rounded as a single number is; operations are neither fused nor reordered.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Sub};

/// A real number, or a SIMD register of real numbers on which every operation acts lane by lane.
pub trait Real:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// The result of a comparison, one truth value per lane.
    type Mask: Copy + BitAnd<Output = Self::Mask> + BitOr<Output = Self::Mask>;

    /// The same number in every lane.
    fn splat(number: f64) -> Self;
    /// x if x > 0, else 0; 0 for NaN.
    fn positive_part(self) -> Self;
    /// The square root.
    fn sqrt(self) -> Self;
    /// x < 0.
    fn is_negative(self) -> Self::Mask;
    /// x >= 0.
    fn is_non_negative(self) -> Self::Mask;
    /// x <= 0.
    fn is_non_positive(self) -> Self::Mask;
    /// `accepted` in the lanes where the mask is true, `rejected` in the others.
    fn select(mask: Self::Mask, accepted: Self, rejected: Self) -> Self;
}

impl Real for f64 {
    type Mask = bool;

    #[inline(always)]
    fn splat(number: f64) -> Self {
        number
    }

    #[inline(always)]
    fn positive_part(self) -> Self {
        if self > 0.0 { self } else { 0.0 }
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        self.sqrt()
    }

    #[inline(always)]
    fn is_negative(self) -> bool {
        self < 0.0
    }

    #[inline(always)]
    fn is_non_negative(self) -> bool {
        self >= 0.0
    }

    #[inline(always)]
    fn is_non_positive(self) -> bool {
        self <= 0.0
    }

    #[inline(always)]
    fn select(mask: bool, accepted: Self, rejected: Self) -> Self {
        if mask { accepted } else { rejected }
    }
}
