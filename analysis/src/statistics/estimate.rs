//! A value with its standard errors.

use super::missing_error::MissingError;
use super::sums::{mean, standard_deviation};
use serde::{Deserialize, Serialize};

/// A value with its standard error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// The standard error: the scatter that other seeds would show; `None` if it is unknown.
    pub standard_error: Option<f64>,
    /// The standard error given the start of this run, if the theoretical value is computed from that start.
    pub conditional_standard_error: Option<f64>,
    /// Degrees of freedom of the standard error, for Student's t; `None` if it is as good as exact.
    pub degrees_of_freedom: Option<f64>,
    /// Why the standard error is unknown.
    pub missing_error: Option<MissingError>,
}

impl Estimate {
    /// A value with its standard error, if that is known.
    pub(crate) fn new(value: f64, standard_error: impl Into<Option<f64>>) -> Self {
        Self { standard_error: standard_error.into(), ..Self::bare(value) }
    }

    /// A value with an unknown standard error.
    pub(crate) const fn bare(value: f64) -> Self {
        Self {
            value,
            standard_error: None,
            conditional_standard_error: None,
            degrees_of_freedom: None,
            missing_error: None,
        }
    }

    /// A value that the manifest alone determines.
    pub(crate) const fn set_by_manifest(value: f64) -> Self {
        Self::bare(value).without_error(MissingError::SetByManifest)
    }

    /// The same estimate with degrees of freedom of its standard error.
    pub(crate) fn with_degrees_of_freedom(self, degrees_of_freedom: f64) -> Self {
        Self { degrees_of_freedom: Some(degrees_of_freedom), ..self }
    }

    /// The same value without a standard error, and the reason.
    pub(crate) const fn without_error(self, reason: MissingError) -> Self {
        Self { missing_error: Some(reason), ..Self::bare(self.value) }
    }

    /// The estimate with a further independent error.
    pub(crate) fn with_further_error(self, error: f64) -> Self {
        Self { standard_error: self.standard_error.map(|own| libm::hypot(own, error)), ..self }
    }

    /// The estimate whose error is so far that for the given start, with the scatter of its expectation from start to
    /// start in addition. The degrees of freedom remain those of the conditional error, which is compared with theory.
    pub(crate) fn with_scatter_of_starts(self, scatter: f64) -> Self {
        match self.standard_error {
            Some(given) if scatter > 0.0 => Self {
                standard_error: Some(libm::hypot(given, scatter)),
                conditional_standard_error: Some(given),
                ..self
            },
            _ => self,
        }
    }

    /// The estimate whose error is that for the given start, while the scatter from start to start is unknown.
    pub(crate) fn with_unknown_scatter_of_starts(self) -> Self {
        match self.standard_error {
            None => self,
            given => Self {
                standard_error: None,
                conditional_standard_error: given,
                missing_error: Some(MissingError::DependsOnStart),
                ..self
            },
        }
    }

    /// A value whose scatter from start to start is unknown, with the error of a series of it in one run, if that has one.
    pub(crate) fn given_the_start(value: f64, series: Option<Self>) -> Self {
        Self {
            conditional_standard_error: series.and_then(|of| of.standard_error),
            degrees_of_freedom: series.and_then(|of| of.degrees_of_freedom),
            ..Self::bare(value).without_error(MissingError::DependsOnStart)
        }
    }

    /// The estimate of 1 over the value, by the first order of the error.
    pub(crate) fn inverse(self) -> Self {
        let scaled = |error: f64| error / (self.value * self.value);
        Self {
            value: 1.0 / self.value,
            standard_error: self.standard_error.map(scaled),
            conditional_standard_error: self.conditional_standard_error.map(scaled),
            ..self
        }
    }

    /// The estimate of a multiple of the value.
    pub(crate) fn times(self, factor: f64) -> Self {
        let scaled = |error: f64| factor.abs() * error;
        Self {
            value: factor * self.value,
            standard_error: self.standard_error.map(scaled),
            conditional_standard_error: self.conditional_standard_error.map(scaled),
            ..self
        }
    }

    /// The estimate of the value plus a constant.
    pub(crate) fn plus(self, constant: f64) -> Self {
        Self { value: constant + self.value, ..self }
    }
}

/// Mean of independent values with the standard error s / sqrt(n) and n - 1 degrees of freedom; the error of a single
/// value is `None`.
pub(crate) fn mean_of_independent(values: &[f64]) -> Option<Estimate> {
    let value = mean(values)?;
    let Some(deviation) = standard_deviation(values) else { return Some(Estimate::bare(value)) };
    let count = values.len() as f64;
    Some(Estimate::new(value, deviation / count.sqrt()).with_degrees_of_freedom(count - 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_of_one_to_five_is_three_with_error_root_half() {
        let estimate = mean_of_independent(&[1.0, 2.0, 3.0, 4.0, 5.0]).unwrap();
        assert_eq!(estimate.value, 3.0);
        // s^2 = 10/4, s^2/n = 1/2.
        assert!((estimate.standard_error.unwrap() - 0.5_f64.sqrt()).abs() < 1e-15);
        assert_eq!(estimate.degrees_of_freedom, Some(4.0));
        assert_eq!(mean_of_independent(&[7.0]).unwrap(), Estimate::bare(7.0));
        assert!(mean_of_independent(&[]).is_none());
    }

    #[test]
    fn scatter_of_starts_adds_to_the_error_for_a_given_start() {
        let given = Estimate::new(2.0, 0.3).with_degrees_of_freedom(24.0);
        let estimate = given.with_scatter_of_starts(0.4);
        assert!((estimate.standard_error.unwrap() - 0.5).abs() < 1e-15);
        assert_eq!(estimate.conditional_standard_error, Some(0.3));
        assert_eq!(given.with_scatter_of_starts(0.0), given);
        let inverse = estimate.inverse();
        assert_eq!((inverse.value, inverse.conditional_standard_error), (0.5, Some(0.3 / 4.0)));
    }
}
