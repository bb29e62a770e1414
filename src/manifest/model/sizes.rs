//! Sizes of numbers with a unit whose products neither overflow nor vanish.

use crate::quantity::Finite;

/// Smallest size of a number with a unit, so that no product of the equations of motion vanishes.
pub(super) const SMALLEST: f64 = 1e-50;
/// Largest such size, so that no product overflows.
pub(super) const LARGEST: f64 = 1e50;

/// The nearest size whose products do not overflow.
pub(super) fn nearest_size(size: f64) -> f64 {
    let least = if size < SMALLEST { SMALLEST } else { size };
    if least > LARGEST { LARGEST } else { least }
}

/// The number, or up to a thousandth less, with four digits.
pub(super) fn rounded_down(number: f64) -> f64 {
    format!("{:.3e}", number * 0.9995).parse().unwrap_or(number)
}

/// Length of a vector.
pub(super) fn length<const N: usize>(vector: [Finite; N]) -> f64 {
    // The largest component as the unit: no square overflows.
    let components = vector.map(|component| component.get().abs());
    let unit = components.iter().fold(0.0, |most, next| if *next > most { *next } else { most });
    if unit == 0.0 {
        return 0.0;
    }
    let squares = components.iter().map(|component| (component / unit) * (component / unit));
    unit * squares.sum::<f64>().sqrt()
}
