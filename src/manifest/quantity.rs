//! Numbers that carry their range: a value of these types was checked once, where it came in.

use serde::Serialize;

macro_rules! quantity {
    ($(#[$doc:meta])* $name:ident, $range:literal, |$x:ident| $holds:expr) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, PartialOrd, Serialize)]
        #[serde(transparent)]
        pub struct $name(f64);

        impl $name {
            /// The range in words, as error messages and the schema state it.
            pub const RANGE: &'static str = $range;

            /// The value, or `None` if it is not a finite number in the range. Minus zero becomes zero.
            #[must_use]
            pub const fn new($x: f64) -> Option<Self> {
                // Adding zero turns -0.0 into 0.0, so that equal values have equal bytes.
                if $x.is_finite() && $holds { Some(Self($x + 0.0)) } else { None }
            }

            /// A value that is written in the source: checked where it is a constant, at compile time.
            ///
            /// # Panics
            /// Where the value is out of range.
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
    Finite, "a finite number", |x| x.is_finite()
);
quantity!(
    /// A finite number above zero.
    Positive, "a number > 0", |x| x > 0.0
);
quantity!(
    /// A finite number of at least zero.
    NonNegative, "a number >= 0", |x| x >= 0.0
);
quantity!(
    /// A share above zero and of at most one, such as a coefficient of restitution.
    Share, "a number in (0, 1]", |x| x > 0.0 && x <= 1.0
);
quantity!(
    /// The side of a packing box, by the input limits of the source document.
    BoxSide, "a number in [10, 100000]", |x| x >= 10.0 && x <= 100_000.0
);
