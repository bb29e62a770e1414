//! The definition of a metric: name, unit, how it is derived, and the laws that it is compared with.

use crate::metric::law::Law;

/// What a metric is, whatever its value.
#[derive(Debug, PartialEq)]
pub struct Definition {
    /// Its name.
    pub name: &'static str,
    /// Its unit; "1" for a share, empty for the model's own dimensionless unit.
    pub unit: &'static str,
    /// From which channel and by which formula.
    pub how: &'static str,
    /// The laws that give theory's value; of several, the run decides.
    pub laws: &'static [Law],
    /// A distance from theory below this, in the metric's unit, is rounding and no statement about physics.
    pub rounding: f64,
}

/// Makes a constant of each definition, and `ALL` of them all:
/// `CONSTANT: "name", "unit", "how it is found", [laws], rounding;`
macro_rules! definitions {
    ($($constant:ident: $name:literal, $unit:literal, $how:literal, [$($law:expr),*], $rounding:literal;)+) => {
        $(
            #[doc = concat!("`", $name, "`: ", $how, ".")]
            pub const $constant: &$crate::metric::definition::Definition = &$crate::metric::definition::Definition {
                name: $name,
                unit: $unit,
                how: $how,
                laws: &[$($law),*],
                rounding: $rounding,
            };
        )+

        /// All of this file, in its order.
        pub const ALL: &[&$crate::metric::definition::Definition] = &[$($constant),+];
    };
}
pub(crate) use definitions;
