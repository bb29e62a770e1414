//! Sine and cosine of an angle in whole turns, without branches, for registers of any width. They use only additions and products,
//! so results are bitwise identical on every machine.

#![allow(clippy::excessive_precision, reason = "coefficients keep the digits of their source")]

use crate::simd::registers::{InstructionSet, Register};
use std::f64::consts::TAU;

/// 1.5 * 2^52: in the sum of this number and one below 2^51, the last bits are the nearest integer.
const ROUNDING: f64 = 6_755_399_441_055_744.0;

/// (sin, cos) of 2 pi `turns`, |turns| < 2^49, with an error of about an ulp of 1.
///
/// The angle is reduced to at most an eighth of a turn from a quarter turn, which is exact. The remainder is evaluated by the polynomials
/// of FreeBSD's msun (`k_sin.c`, `k_cos.c`: error below 2^-58 on [-pi/4, pi/4]).
#[inline(always)]
pub(super) fn sine_and_cosine<const N: usize, I: InstructionSet<N>>(
    instructions: I,
    turns: I::Register,
) -> [I::Register; 2] {
    let [rounding, one] = [instructions.splat(ROUNDING), instructions.splat(1.0)];
    let quarters = instructions.splat(4.0) * turns + rounding;
    let nearest = instructions.splat(0.25) * (quarters - rounding);
    let angle = (turns - nearest) * instructions.splat(TAU);
    let (sine, cosine) = (sine_near_zero(angle), cosine_near_zero(angle));
    let exchanged_sine = instructions.by_last_bit(quarters, cosine, sine);
    let exchanged_cosine = instructions.by_last_bit(quarters, sine, cosine);
    // Quarters 2 and 3 invert the sign of the sine, 1 and 2 that of the cosine. At this magnitude, the sum with 1 adds 1 to the bits.
    [
        instructions.inverted_by_second_bit(quarters, exchanged_sine),
        instructions.inverted_by_second_bit(quarters + one, exchanged_cosine),
    ]
}

/// A polynomial with these coefficients, the lowest first.
#[inline(always)]
fn polynomial<R: Register, const N: usize>(z: R, coefficients: [f64; N]) -> R {
    let mut value = z.splat(coefficients[N - 1]);
    for &coefficient in coefficients[..N - 1].iter().rev() {
        value = z.splat(coefficient) + z * value;
    }
    value
}

#[inline(always)]
fn sine_near_zero<R: Register>(x: R) -> R {
    let z = x * x;
    let factor = polynomial(
        z,
        [
            -1.666_666_666_666_663_243_48e-1,
            8.333_333_333_322_489_461_24e-3,
            -1.984_126_982_985_794_931_34e-4,
            2.755_731_370_707_006_767_89e-6,
            -2.505_076_025_340_686_341_95e-8,
            1.589_690_995_211_550_102_21e-10,
        ],
    );
    x + x * z * factor
}

#[inline(always)]
fn cosine_near_zero<R: Register>(x: R) -> R {
    let z = x * x;
    let tail = polynomial(
        z,
        [
            4.166_666_666_666_660_190_37e-2,
            -1.388_888_888_887_410_957_49e-3,
            2.480_158_728_947_672_941_78e-5,
            -2.755_731_435_139_066_330_35e-7,
            2.087_572_321_298_174_827_90e-9,
            -1.135_964_755_778_819_482_65e-11,
        ],
    );
    let (one, half) = (z.splat(1.0), z.splat(0.5) * z);
    let rest = one - half;
    rest + (((one - rest) - half) + z * z * tail)
}
