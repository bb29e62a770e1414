//! Sine and cosine of an angle in whole turns, without branches, for loops that the compiler turns into vector instructions. They use only
//! additions and products, so results are bitwise identical on every machine.

#![allow(clippy::excessive_precision, reason = "coefficients keep the digits of their source")]

use crate::simd::registers::each;
use std::f64::consts::TAU;

/// 1.5 * 2^52: in the sum of this number and one below 2^51, the last bits are the nearest integer.
const ROUNDING: f64 = 6_755_399_441_055_744.0;

/// (sin, cos) of 2 pi `turns`, |turns| < 2^49, of four angles, with an error of about an ulp of 1. Operation by operation, so that the
/// compiler keeps four numbers in one register.
///
/// The angle is reduced to at most an eighth of a turn from a quarter turn, which is exact. The remainder is evaluated by the polynomials
/// of FreeBSD's msun (`k_sin.c`, `k_cos.c`: error below 2^-58 on [-pi/4, pi/4]).
#[inline(always)]
pub(super) fn sines_and_cosines(turns: [f64; 4]) -> [[f64; 4]; 2] {
    let shifted = each(|i| 4.0 * turns[i] + ROUNDING);
    let angle = each(|i| (turns[i] - 0.25 * (shifted[i] - ROUNDING)) * TAU);
    let (sine, cosine) = (each(|i| sine_near_zero(angle[i])), each(|i| cosine_near_zero(angle[i])));
    let quarter = shifted.map(f64::to_bits);
    let is_odd = |i: usize| quarter[i] & 1 == 1;
    let exchanged_sine = each(|i| if is_odd(i) { cosine[i] } else { sine[i] });
    let exchanged_cosine = each(|i| if is_odd(i) { sine[i] } else { cosine[i] });
    // Quarters 2 and 3 invert the sign of the sine, 1 and 2 that of the cosine.
    [
        each(|i| inverted_by(quarter[i], exchanged_sine[i])),
        each(|i| inverted_by(quarter[i].wrapping_add(1), exchanged_cosine[i])),
    ]
}

/// The number, with its sign inverted if the second bit of `quarter` is set.
#[inline(always)]
fn inverted_by(quarter: u64, number: f64) -> f64 {
    f64::from_bits(number.to_bits() ^ (quarter & 2) << 62)
}

#[inline(always)]
fn sine_near_zero(x: f64) -> f64 {
    let z = x * x;
    let tail = 8.333_333_333_322_489_461_24e-3
        + z * (-1.984_126_982_985_794_931_34e-4
            + z * (2.755_731_370_707_006_767_89e-6
                + z * (-2.505_076_025_340_686_341_95e-8 + z * 1.589_690_995_211_550_102_21e-10)));
    x + x * z * (-1.666_666_666_666_663_243_48e-1 + z * tail)
}

#[inline(always)]
fn cosine_near_zero(x: f64) -> f64 {
    let z = x * x;
    let tail = 4.166_666_666_666_660_190_37e-2
        + z * (-1.388_888_888_887_410_957_49e-3
            + z * (2.480_158_728_947_672_941_78e-5
                + z * (-2.755_731_435_139_066_330_35e-7
                    + z * (2.087_572_321_298_174_827_90e-9
                        + z * -1.135_964_755_778_819_482_65e-11))));
    let half = 0.5 * z;
    let rest = 1.0 - half;
    rest + (((1.0 - rest) - half) + z * z * tail)
}
