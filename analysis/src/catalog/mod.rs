//! Every metric: its name, its unit, how it is found and the laws that it is held against. Measurements, files, reports and
//! the reference in `docs/metrics.md` all take them from here.

pub mod dem;
pub mod gas;
pub mod orbit;
pub mod packing;
mod reference;
pub mod sweep;

pub use reference::reference;

use crate::laws::Law;

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
            pub const $constant: &$crate::catalog::Definition = &$crate::catalog::Definition {
                name: $name,
                unit: $unit,
                how: $how,
                laws: &[$($law),*],
                rounding: $rounding,
            };
        )+

        /// All of this file, in its order.
        pub const ALL: &[&$crate::catalog::Definition] = &[$($constant),+];
    };
}
pub(crate) use definitions;

/// The metrics of a model's runs; none of a name that is no model's.
#[must_use]
pub fn of_model(model: &str) -> &'static [&'static Definition] {
    match model {
        "dem" => dem::ALL,
        "gas" => gas::ALL,
        "packing" => packing::ALL,
        "orbit" => orbit::ALL,
        _ => &[],
    }
}

/// Whether runs of a model, or a sweep over them, can have a metric of this name.
#[must_use]
pub fn is_metric(model: &str, name: &str) -> bool {
    of_model(model).iter().chain(sweep::ALL).any(|definition| definition.name == name)
}

/// The metric whose name is nearest to a misspelled one, if one is near.
#[must_use]
pub fn nearest_metric(model: &str, name: &str) -> Option<&'static str> {
    let names = of_model(model).iter().chain(sweep::ALL).map(|definition| definition.name);
    names
        .map(|known| (strsim::damerau_levenshtein(known, name), known))
        .filter(|(distance, _)| *distance <= 1 + name.len() / 4)
        .min()
        .map(|(_, known)| known)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    /// Checks and readers find a metric by its name: no table has one twice, and a sweep's never hides a run's.
    #[test]
    fn no_name_stands_for_two_metrics() {
        for model in ["dem", "gas", "packing", "orbit"] {
            let mut names = BTreeSet::new();
            for definition in of_model(model).iter().chain(sweep::ALL) {
                assert!(names.insert(definition.name), "{model}: {}", definition.name);
                assert!(definition.rounding >= 0.0);
            }
        }
    }
}
