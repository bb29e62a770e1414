//! When hard discs in free flight meet: shared by the packing and the gas. A pure function.
//!
//! Symbols: r separation of two centres (second minus first), v relative velocity (second minus first), s distance of the centres
//! at contact.

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
pub fn time_to_contact(r: [f64; 2], v: [f64; 2], contact_distance: f64) -> f64 {
    let approach = r[0] * v[0] + r[1] * v[1];
    let square = contact_distance * contact_distance;
    let gap = r[0] * r[0] + r[1] * r[1] - square;
    let cross = r[0] * v[1] - r[1] * v[0];
    let discriminant = (v[0] * v[0] + v[1] * v[1]) * square - cross * cross;
    let root = (if discriminant > 0.0 { discriminant } else { 0.0 }).sqrt();
    let wait = (if gap > 0.0 { gap } else { 0.0 }) / (root - approach);
    let touches = (approach < 0.0) & ((discriminant >= 0.0) | (gap <= 0.0));
    if touches { wait } else { f64::MAX }
}
