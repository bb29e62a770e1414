//! Estimates with standard errors: means, blocking of correlated series, Student's t, and least-squares fits.
//!
//! A standard error is the scatter that other seeds would show. It comes with its degrees of freedom; a deviation in
//! standard errors is converted to the equally probable deviation of a normal distribution ([`students_t`]).

mod blocking;
mod estimate;
mod fits;
mod missing_error;
pub(crate) mod students_t;
mod sums;

#[cfg(test)]
pub(crate) mod random;

pub(crate) use blocking::Blocking;
pub use estimate::Estimate;
pub(crate) use estimate::mean_of_independent;
pub(crate) use fits::{least_squares_line, power_law_exponent, saturation};
pub(crate) use missing_error::{
    AFTER_FEW_EVENTS, BY_CHANCE, DEPENDS_ON_START, FRAMES_FAR_APART, NO_CHAOS, NOTHING_COUNTED,
    SET_BY_MANIFEST, SHORTER_THAN_WINDOW, is_of_short_series,
};
pub use missing_error::{Entries, MissingError};
#[cfg(test)]
pub(crate) use sums::standard_deviation;
pub(crate) use sums::{Sum, mean};
