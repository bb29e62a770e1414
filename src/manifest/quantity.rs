//! Numbers with a range: a value of these types was checked when it was read.

use serde::Serialize;

macro_rules! quantity {
    ($(#[$doc:meta])* $name:ident, $range:literal, [$($bound:ident: $limit:literal),*], |$x:ident| $holds:expr) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Serialize)]
        #[serde(transparent)]
        pub struct $name(f64);

        impl $name {
            /// The range in words, as error messages and the schema state it.
            pub const RANGE: &'static str = $range;

            /// The range as JSON Schema keywords with their limits.
            pub(crate) const BOUNDS: &'static [(&'static str, f64)] = &[$((stringify!($bound), $limit)),*];

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
    };
}

quantity!(
    /// A finite number of either sign.
    Finite, "a finite number", [], |x| x.is_finite()
);
quantity!(
    /// A finite number above zero.
    Positive, "a number > 0", [exclusiveMinimum: 0.0], |x| x > 0.0
);
quantity!(
    /// A finite number of at least zero.
    NonNegative, "a number >= 0", [minimum: 0.0], |x| x >= 0.0
);
quantity!(
    /// A fraction above zero and at most one, such as a coefficient of restitution.
    Fraction, "a number in (0, 1]", [exclusiveMinimum: 0.0, maximum: 1.0], |x| x > 0.0 && x <= 1.0
);
quantity!(
    /// The side of a packing box, by the input limits of the packing exercise.
    BoxSide, "a number in [10, 100000]", [minimum: 10.0, maximum: 100_000.0], |x| x >= 10.0 && x <= 100_000.0
);
quantity!(
    /// Frames per second of playback: viewers warn above 60.
    PlaybackRate, "a number in (0, 50]", [exclusiveMinimum: 0.0, maximum: 50.0], |x| x > 0.0 && x <= 50.0
);
quantity!(
    /// Relative error per step of an adaptive method; below 1e-15, rounding dominates.
    StepTolerance, "a number in [1e-15, 0.01]", [minimum: 1e-15, maximum: 0.01], |x| x >= 1e-15 && x <= 0.01
);

impl From<PlaybackRate> for Positive {
    fn from(rate: PlaybackRate) -> Self {
        Self(rate.0)
    }
}
