//! The definition of a metric: name, unit, how it is derived, and the laws that it is compared with.

use crate::metric::law::Law;

/// The definition of a metric.
#[derive(Debug, PartialEq)]
pub struct Definition {
    /// The metric's name.
    pub name: &'static str,
    /// The metric's unit; "1" for a fraction or ratio, empty for the model's own dimensionless unit.
    pub unit: &'static str,
    /// The quantity in words, as a sentence names it after "the".
    pub label: &'static str,
    /// The source channel and the formula.
    pub how: &'static str,
    /// The laws that give theoretical values; the run determines which of several applies.
    pub laws: &'static [Law],
    /// A deviation below this, in the metric's unit, is a rounding error.
    pub rounding: f64,
}

/// Defines one constant per metric, and `ALL` with all of them: `CONSTANT: "name", "unit", "label", "how it is
/// derived", [laws], rounding;`
macro_rules! definitions {
    ($($constant:ident: $name:literal, $unit:literal, $label:literal, $how:literal, [$($law:expr),*], $rounding:literal;)+) => {
        $(
            #[doc = concat!("`", $name, "`: `", $how, "`.")]
            pub(crate) const $constant: &$crate::metric::definition::Definition = &$crate::metric::definition::Definition {
                name: $name,
                unit: $unit,
                label: $label,
                how: $crate::metric::law::for_reference($how),
                laws: &[$($law),*],
                rounding: $rounding,
            };
        )+

        /// All definitions of this file, in its order.
        pub(crate) const ALL: &[&$crate::metric::definition::Definition] = &[$($constant),+];
    };
}
pub(crate) use definitions;
