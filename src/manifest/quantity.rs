//! Numbers with a range: a value of these types was checked when it was read.

use crate::diagnostics::Errors;
use crate::tree::Node;
use crate::value::{TomlValue, number, refuse, shortest};
use serde::Serialize;
use serde_json::{Value as Json, json};

/// Defines types of numbers: each line gives the range in words, as JSON Schema keywords, and as a condition.
macro_rules! quantities {
    ($($(#[$doc:meta])* $name:ident: $range:literal, [$($bound:ident: $limit:literal),*], |$x:ident| $holds:expr;)+) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Serialize)]
        #[serde(transparent)]
        pub struct $name(f64);

        impl $name {
            /// The value, or `None` if it is not a finite number in the range. Minus zero becomes zero.
            #[must_use]
            pub const fn new($x: f64) -> Option<Self> {
                // Adding zero turns -0.0 into 0.0, so that equal values have equal bytes.
                if $x.is_finite() && $holds { Some(Self($x + 0.0)) } else { None }
            }

            /// A value that is written in the source; in a constant, it is checked at compile time.
            ///
            /// # Panics
            /// If the value is out of range.
            #[must_use]
            pub const fn literal(value: f64) -> Self {
                match Self::new(value) {
                    Some(quantity) => quantity,
                    None => panic!("out of range"),
                }
            }

            /// The bare number, in the unit that its key names.
            #[must_use]
            pub const fn get(self) -> f64 {
                self.0
            }
        }

        impl TomlValue for $name {
            fn read(node: &Node, name: &str, errors: &mut Errors) -> Option<Self> {
                number(node).and_then(Self::new).or_else(|| refuse(node, name, $range, errors))
            }

            fn write(&self) -> String {
                shortest(self.get())
            }

            fn schema() -> Json {
                json!({ "type": "number" $(, (stringify!($bound)): $limit)* })
            }
        }
    )+};
}

quantities! {
    /// A finite number of either sign.
    Finite: "a finite number", [], |x| x.is_finite();
    /// A finite number above zero.
    Positive: "a number > 0", [exclusiveMinimum: 0.0], |x| x > 0.0;
    /// A finite number of at least zero.
    NonNegative: "a number >= 0", [minimum: 0.0], |x| x >= 0.0;
    /// A fraction above zero and at most one, such as a coefficient of restitution.
    Fraction: "a number in (0, 1]", [exclusiveMinimum: 0.0, maximum: 1.0], |x| x > 0.0 && x <= 1.0;
    /// Poisson's ratio: the upper limit is that of an incompressible material.
    PoissonRatio: "a number in [0, 0.5]", [minimum: 0.0, maximum: 0.5], |x| x >= 0.0 && x <= 0.5;
    /// The side of a packing box, by the input limits of the packing exercise.
    BoxSide: "a number in [10, 100000]", [minimum: 10.0, maximum: 100_000.0], |x| x >= 10.0 && x <= 100_000.0;
    /// Frames per second of playback: viewers warn above 60.
    PlaybackRate: "a number in (0, 50]", [exclusiveMinimum: 0.0, maximum: 50.0], |x| x > 0.0 && x <= 50.0;
    /// Relative error per step of an adaptive method; below 1e-15, rounding dominates.
    StepTolerance: "a number in [1e-15, 0.01]", [minimum: 1e-15, maximum: 0.01], |x| x >= 1e-15 && x <= 0.01;
}
