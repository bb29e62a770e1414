//! The time at which two hard discs in free flight collide: shared by the packing and the gas.
//!
//! Symbols: r separation of the two centers (second minus first), v relative velocity (second minus first), s contact
//! distance (sum of the radii), t time. Any consistent units.

use crate::simd::registers::Register;

/// Returns the time until two discs touch, |r + v t| = s, or [`f64::MAX`] if they never do.
///
/// t = (r² − s²) / (−r·v + √(v² s² − (r × v)²))
///
/// This is the smaller root of v² t² + 2 (r·v) t + r² − s² = 0 in the form without cancellation (Press et al., Numerical
/// Recipes, section 5.6). The discriminant (r·v)² − v² (r² − s²) is written with the cross product, which keeps its
/// precision for distant discs.
///
/// Discs that separate or keep their distance (r·v >= 0) never touch. This also excludes a disc and itself, and the pair
/// that has just collided. Discs that approach and overlap due to rounding touch immediately. The function has no branches,
/// so it also runs on a register of eight pairs.
#[inline(always)]
#[must_use]
pub fn time_to_contact<N: Register>(r: [N; 2], v: [N; 2], contact_distance: N) -> N {
    let r_dot_v = r[0] * v[0] + r[1] * v[1];
    let square = contact_distance * contact_distance;
    let gap = r[0] * r[0] + r[1] * r[1] - square;
    let cross = r[0] * v[1] - r[1] * v[0];
    let discriminant = (v[0] * v[0] + v[1] * v[1]) * square - cross * cross;
    let zero = gap.splat(0.0);
    let time = gap.larger(zero) / (discriminant.larger(zero).sqrt() - r_dot_v);
    let touches = r_dot_v.is_less(zero) & (zero.is_at_most(discriminant) | gap.is_at_most(zero));
    time.or_else(touches, gap.splat(f64::MAX))
}
