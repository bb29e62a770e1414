//! Deviation of a value from theory.

use crate::metric::theory::Theory;
use crate::statistics::students_t::normal_equivalent;
use crate::statistics::{Estimate, MissingError};

/// Deviation of a value from theory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Deviation {
    /// Within rounding errors.
    Rounding,
    /// In standard errors: the deviation of a normal distribution with the probability that Student's t gives this one.
    StandardErrors(f64),
    /// Inside or outside the accuracy of the law, a bound that is larger than the standard error; it is no measure of the scatter.
    Bound {
        /// Whether the difference is within the accuracy, and for a value with an error within [`MAX_SIGMA`] of that in addition.
        is_inside: bool,
    },
    /// The difference, if no standard error is known.
    Bare(f64),
}

/// Standard errors beyond the accuracy of a law up to which a value with an error is inside it.
const MAX_SIGMA: f64 = 4.0;

/// Deviations below this fraction of the theoretical value are rounding errors.
pub(crate) const ROUNDING_FRACTION: f64 = 1e-9;

impl Deviation {
    /// The deviation of an estimate; `None` without a theoretical value, outside its law's range, and if nothing was counted.
    ///
    /// The accuracy of a law is a bound. An accuracy below the standard error is added to it; beyond that, a deviation in units of the
    /// accuracy would be below 1 for every correct program, so that the value is only inside or outside. Theory that is conditional on
    /// the start of the run is compared by the conditional standard error.
    pub(crate) fn of(estimate: &Estimate, theory: Option<Theory>, rounding: f64) -> Option<Self> {
        let is_measured = !estimate.value.is_nan()
            && estimate.missing_error != Some(MissingError::NothingCounted);
        let theory = theory.filter(|theory| theory.in_range() && is_measured)?;
        let difference = estimate.value - theory.value;
        let rounding = rounding.max(ROUNDING_FRACTION * theory.value.abs());
        let error = estimate.conditional_standard_error.or(estimate.standard_error);
        Some(match error {
            _ if difference.abs() <= rounding => Self::Rounding,
            _ if theory.law.is_some_and(|law| law.is_conservation()) => Self::Bare(difference),
            // Without a scatter, as of a trajectory that uses no random numbers, or with one that is smaller.
            error
                if theory.accuracy > rounding.max(error.unwrap_or(0.0))
                    && (error.is_some() || estimate.missing_error.is_none()) =>
            {
                let beyond = difference.abs() - theory.accuracy;
                Self::Bound { is_inside: is_chance(beyond, error, estimate.degrees_of_freedom) }
            }
            // A standard error within rounding is not a measure of the deviation.
            Some(error) if error > rounding => {
                let combined = libm::hypot(error, theory.accuracy);
                let deviation = difference / combined;
                // The accuracy of the law is known, so it adds freedom (Welch 1947, Satterthwaite 1946).
                let freedom =
                    estimate.degrees_of_freedom.map(|own| own * (combined / error).powi(4));
                Self::StandardErrors(
                    freedom.map_or(deviation, |freedom| normal_equivalent(deviation, freedom)),
                )
            }
            _ => Self::Bare(difference),
        })
    }

    /// The deviation in standard errors, if a standard error is known.
    pub(crate) const fn in_standard_errors(self) -> Option<f64> {
        match self {
            Self::StandardErrors(deviation) => Some(deviation),
            Self::Rounding | Self::Bound { .. } | Self::Bare(_) => None,
        }
    }
}

/// Whether a positive excess is within the scatter of a value with this error.
fn is_chance(excess: f64, error: Option<f64>, degrees_of_freedom: Option<f64>) -> bool {
    let sigma = |error: f64| {
        let t = excess / error;
        degrees_of_freedom.map_or(t, |freedom| normal_equivalent(t, freedom))
    };
    excess <= 0.0 || error.is_some_and(|error| error > 0.0 && sigma(error) <= MAX_SIGMA)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metric::Law;
    use crate::metric::theory::Expected as _;
    use crate::models::MODELS;

    /// Guarantee: a value without scatter, or with a smaller one, is inside or outside the accuracy of its law, which is no measure
    /// of a scatter. Controls: one whose error is unknown is neither; a larger error gives a deviation in standard errors.
    #[test]
    fn accuracy_of_a_law_is_a_bound() {
        let theory = 1.0_f64.expected().unwrap().by(None);
        let inexact = Some(Theory { accuracy: 0.02, ..theory });
        let is_inside = |estimate: &Estimate| match Deviation::of(estimate, inexact, 0.0) {
            Some(Deviation::Bound { is_inside }) => is_inside,
            other => panic!("{other:?}"),
        };
        let off = Estimate::bare(0.95);
        assert!(is_inside(&Estimate::bare(0.981)) && !is_inside(&off));
        assert!(!is_inside(&Estimate::bare(1.021)));
        // Three hundredths beyond the bound are 3 and 30 standard errors.
        assert!(is_inside(&Estimate::new(0.95, 0.01)) && !is_inside(&Estimate::new(0.95, 0.001)));
        // With one degree of freedom, 30 standard errors are as probable as 2.1 σ.
        assert!(is_inside(&Estimate::new(0.95, 0.001).with_degrees_of_freedom(1.0)));
        let Some(Deviation::StandardErrors(sigma)) =
            Deviation::of(&Estimate::new(0.95, 0.03), inexact, 0.0)
        else {
            panic!("no deviation")
        };
        assert!((sigma + 0.05 / libm::hypot(0.02, 0.03)).abs() < 1e-12, "{sigma}");
        assert!(matches!(Deviation::of(&off, Some(theory), 0.0), Some(Deviation::Bare(_))));
        let unknown = off.without_error(MissingError::DependsOnStart);
        assert!(matches!(Deviation::of(&unknown, inexact, 0.0), Some(Deviation::Bare(_))));
    }

    /// Guarantee: a mean of largest energy errors is never 0, however small its standard error is, so it is not compared in standard
    /// errors. Control: by a law that is no conservation law, it is.
    #[test]
    fn violation_of_a_conservation_law_is_not_statistical() {
        let estimate = Estimate::new(1e-4, 1e-5);
        let law = |is_conservation: bool| Law {
            statement: "",
            source: "",
            range: "",
            relative_accuracy: 0.0,
            conserved: is_conservation.then_some("energy"),
            name: None,
            is_of_integrator: false,
            is_identity: false,
            is_of_manifest: false,
        };
        let by = |law| {
            Deviation::of(
                &estimate,
                Some(0.0_f64.expected().unwrap().by(Some(Box::leak(Box::new(law))))),
                1e-9,
            )
        };
        assert_eq!(by(law(true)), Some(Deviation::Bare(1e-4)));
        assert!(matches!(by(law(false)), Some(Deviation::StandardErrors(_))));
    }

    /// Guarantee: a small value is not equal to theory because it is small. An absolute rounding is for metrics whose
    /// theoretical value is zero; the temperature of cooling discs tends to zero, and 11 % off is no rounding.
    #[test]
    fn value_that_cools_to_zero_is_compared_relative_to_theory() {
        for (model, name) in
            [("packing", "temperature.final_over_initial"), ("dem", "row.velocity_transmission")]
        {
            let model = MODELS.iter().find(|found| found.name == model).unwrap();
            let metric = model.metrics.iter().find(|metric| metric.name == name).unwrap();
            let theory = Some(5.603e-9_f64.expected().unwrap().by(None));
            let off = Deviation::of(&Estimate::bare(4.975_576e-9), theory, metric.rounding);
            assert!(matches!(off, Some(Deviation::Bare(_))), "{name}: {off:?}");
            let equal = Estimate::bare(5.603e-9 * (1.0 + 1e-12));
            assert_eq!(Deviation::of(&equal, theory, metric.rounding), Some(Deviation::Rounding));
        }
    }
}
