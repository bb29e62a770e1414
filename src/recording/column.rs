//! The columns of a state and of a message: their lengths, and the bits of their NaNs.
//!
//! The sign and the payload of a computed NaN differ between processors: 0/0 is negative on x86-64 and positive on aarch64. A recording
//! contains one NaN only, that of `f64::NAN`.

/// One column of the state, as a model declares it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StateColumn {
    /// Name in the recording, such as `vx`.
    pub name: &'static str,
    /// Unit, such as "m/s"; empty for dimensionless.
    pub unit: &'static str,
}

/// Names of the columns that a particle keeps from frame to frame. They are recorded on `/particles`, not in every `/state`.
const CONSTANTS: [&str; 3] = ["id", "mass", "radius"];

/// Whether a particle keeps the value of the state's column with this name.
pub(crate) fn is_constant(name: &str) -> bool {
    CONSTANTS.contains(&name)
}

/// A field that may be a column.
pub(crate) trait Column {
    /// Number of values; `None` for a field with a single value.
    fn length(&self) -> Option<usize>;

    /// Whether it contains a NaN with other bits than those of `f64::NAN`.
    fn has_other_nan(&self) -> bool {
        false
    }

    /// Gives every NaN the bits of `f64::NAN`.
    fn make_nan_canonical(&mut self) {}
}

/// Numbers that are compared before the search for a NaN can end.
const NUMBERS_AT_ONCE: usize = 256;

/// Whether a number is a NaN with other bits than those of `f64::NAN`.
fn is_other_nan(number: &f64) -> bool {
    number.is_nan() & (number.to_bits() != f64::NAN.to_bits())
}

impl Column for [f64] {
    fn length(&self) -> Option<usize> {
        Some(self.len())
    }

    fn has_other_nan(&self) -> bool {
        // A search without an end inside a part compares several numbers at once. States have many, and hardly ever a NaN.
        let has_nan = |part: &&[f64]| part.iter().fold(false, |any, number| any | number.is_nan());
        self.chunks(NUMBERS_AT_ONCE).filter(has_nan).flatten().any(is_other_nan)
    }

    fn make_nan_canonical(&mut self) {
        self.iter_mut().filter(|number| number.is_nan()).for_each(|number| *number = f64::NAN);
    }
}

impl Column for Vec<f64> {
    fn length(&self) -> Option<usize> {
        Some(self.len())
    }

    fn has_other_nan(&self) -> bool {
        self.as_slice().has_other_nan()
    }

    fn make_nan_canonical(&mut self) {
        self.as_mut_slice().make_nan_canonical();
    }
}

impl Column for Vec<u64> {
    fn length(&self) -> Option<usize> {
        Some(self.len())
    }
}

impl Column for Vec<String> {
    fn length(&self) -> Option<usize> {
        Some(self.len())
    }
}

impl Column for f64 {
    fn length(&self) -> Option<usize> {
        None
    }

    fn has_other_nan(&self) -> bool {
        is_other_nan(self)
    }

    fn make_nan_canonical(&mut self) {
        std::slice::from_mut(self).make_nan_canonical();
    }
}

impl Column for u64 {
    fn length(&self) -> Option<usize> {
        None
    }
}

impl Column for String {
    fn length(&self) -> Option<usize> {
        None
    }
}
