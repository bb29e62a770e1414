//! Sine and cosine of an angle in whole turns, without branches, for loops that the compiler turns into vector instructions. They use only
//! additions and products, so results are bitwise identical on every machine.

#![allow(clippy::excessive_precision, reason = "coefficients keep the digits of their source")]

use std::f64::consts::TAU;

/// 1.5 * 2^52: in the sum of this number and one below 2^51, the last bits are the nearest integer.
const ROUNDING: f64 = 6_755_399_441_055_744.0;

/// (sin, cos) of 2 pi `turns`, |turns| < 2^49, with an error of about an ulp of 1.
///
/// The angle is reduced to at most an eighth of a turn from a quarter turn, which is exact. The remainder is evaluated by the polynomials
/// of FreeBSD's msun (`k_sin.c`, `k_cos.c`: error below 2^-58 on [-pi/4, pi/4]).
#[must_use]
#[inline(always)]
pub fn sine_and_cosine(turns: f64) -> (f64, f64) {
    let shifted = 4.0 * turns + ROUNDING;
    let quarters = shifted - ROUNDING;
    let quarter = shifted.to_bits();
    let angle = (turns - 0.25 * quarters) * TAU;
    let (sine, cosine) = (sine_near_zero(angle), cosine_near_zero(angle));
    let odd = quarter & 1 == 1;
    let (sine, cosine) = if odd { (cosine, sine) } else { (sine, cosine) };
    // Quarters 2 and 3 invert the sign of the sine, 1 and 2 that of the cosine.
    let sine_sign = (quarter & 2) << 62;
    let cosine_sign = (quarter.wrapping_add(1) & 2) << 62;
    (f64::from_bits(sine.to_bits() ^ sine_sign), f64::from_bits(cosine.to_bits() ^ cosine_sign))
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
