//! When hard discs in free flight meet: shared by the packing and the gas. A pure function.
//!
//! Symbols: r separation of two centers (second minus first), v relative velocity (second minus first), s distance of the centers
//! at contact.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Sub};

/// One number, or as many as the processor takes side by side: what is written for them holds for each.
pub trait Numbers:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// Whether something holds, for each.
    type Truth: Copy + BitAnd<Output = Self::Truth> + BitOr<Output = Self::Truth>;

    /// The same number everywhere.
    fn all(number: f64) -> Self;
    /// x, or 0 where x > 0 does not hold.
    fn positive_part(self) -> Self;
    /// The square root.
    fn sqrt(self) -> Self;
    /// x < 0.
    fn is_negative(self) -> Self::Truth;
    /// x >= 0.
    fn is_not_negative(self) -> Self::Truth;
    /// x <= 0.
    fn is_not_positive(self) -> Self::Truth;
    /// One where it holds, the other elsewhere.
    fn choose(truth: Self::Truth, one: Self, other: Self) -> Self;
}

impl Numbers for f64 {
    type Truth = bool;

    #[inline(always)]
    fn all(number: f64) -> Self {
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
    fn is_not_negative(self) -> bool {
        self >= 0.0
    }

    #[inline(always)]
    fn is_not_positive(self) -> bool {
        self <= 0.0
    }

    #[inline(always)]
    fn choose(truth: bool, one: Self, other: Self) -> Self {
        if truth { one } else { other }
    }
}

/// Time until two discs touch, |r + v t| = s, or [`f64::MAX`] where they never do.
///
/// The smaller root of v^2 t^2 + 2 (r . v) t + r^2 - s^2 = 0 without cancellation (Numerical Recipes, section 5.6):
///
/// t = (r^2 - s^2) / (-r . v + sqrt(v^2 s^2 - (r x v)^2))
///
/// where (r . v)^2 - v^2 (r^2 - s^2) is written with the cross product, which keeps its digits for discs far apart.
/// Discs that part or keep their distance (r . v >= 0) never touch: this also leaves out a disc and itself, and the pair
/// that has just collided. Discs that overlap by rounding and approach touch now. Without branches: a pair that does not
/// touch costs as much as one that does, and eight pairs as much as one where the processor has lanes for it.
#[inline(always)]
#[must_use]
pub fn time_to_contact<N: Numbers>(r: [N; 2], v: [N; 2], contact_distance: N) -> N {
    let approach = r[0] * v[0] + r[1] * v[1];
    let square = contact_distance * contact_distance;
    let gap = r[0] * r[0] + r[1] * r[1] - square;
    let cross = r[0] * v[1] - r[1] * v[0];
    let discriminant = (v[0] * v[0] + v[1] * v[1]) * square - cross * cross;
    let wait = gap.positive_part() / (discriminant.positive_part().sqrt() - approach);
    let touches = approach.is_negative() & (discriminant.is_not_negative() | gap.is_not_positive());
    N::choose(touches, wait, N::all(f64::MAX))
}
