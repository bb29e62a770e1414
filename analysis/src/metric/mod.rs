//! Metrics: definition, value with a standard error, theoretical value, and the run or sweep described.

pub(crate) mod definition;
pub(crate) mod deviation;
pub(crate) mod law;
pub(crate) mod measurement;
pub(crate) mod symbols;
pub(crate) mod theory;
pub(crate) mod violation;

pub use definition::Definition;
pub(crate) use deviation::Deviation;
pub use law::Law;
pub use measurement::Measurement;
pub(crate) use measurement::{Measurements, NEEDS_ALL_STATES};
pub use theory::Theory;
pub(crate) use violation::Quantity;
pub use violation::Violation;

use crate::metric::theory::Expected as _;
use crate::statistics::Estimate;
use kinetoscope_manifest::Coordinate;
use std::borrow::Cow;
use std::sync::Arc;

/// A part of the reasons why a value that does not scatter has no error, by which a baseline is known to contain one.
pub(crate) const BOUND_ONLY: &str = "the accuracy of its law, which is no standard error";

/// Version of the layout of `metrics.json`.
pub(crate) const SCHEMA: u32 = 3;

/// A value with its definition and scope.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Metric {
    /// The definition.
    pub(crate) definition: &'static Definition,
    /// The value with its errors.
    pub(crate) estimate: Estimate,
    /// The theoretical value, if there is one.
    pub(crate) theory: Option<Theory>,
    /// Why the metric has no value; then the value is NaN.
    pub(crate) reason: Option<Cow<'static, str>>,
    /// A deviation below this is a rounding error.
    pub(crate) rounding: f64,
    /// The run or the part of the sweep that the value describes.
    pub(crate) scope: MetricScope,
}

impl Metric {
    pub(crate) fn new(
        definition: &'static Definition,
        estimate: Estimate,
        theory: Option<Theory>,
        scope: MetricScope,
    ) -> Self {
        let rounding = definition.rounding;
        Self { definition, estimate, theory, reason: None, rounding, scope }
    }

    /// The value; NaN if there is none.
    pub(crate) const fn value(&self) -> f64 {
        self.estimate.value
    }

    /// The standard error, if it is known.
    pub(crate) const fn standard_error(&self) -> Option<f64> {
        self.estimate.standard_error
    }

    /// The theoretical value, if there is one.
    pub(crate) fn theory_value(&self) -> Option<f64> {
        self.theory.map(|theory| theory.value)
    }

    /// Whether the value is the violation of a conservation law, which has no deviation in standard errors.
    pub(crate) fn is_of_conservation_law(&self) -> bool {
        let law = self.theory.and_then(|theory| theory.law);
        law.is_some_and(|law| law.is_conservation())
    }

    /// Whether the law is an identity of the recorded values, which holds whatever the run does.
    pub(crate) fn is_of_identity(&self) -> bool {
        let law = self.theory.and_then(|theory| theory.law);
        law.is_some_and(|law| law.is_identity)
    }

    /// Whether it is of one run rather than of a part of the sweep.
    pub(crate) const fn is_of_run(&self) -> bool {
        matches!(self.scope, MetricScope::Run(_))
    }

    /// Whether it is a fit along an axis of the sweep.
    pub(crate) fn is_fit(&self) -> bool {
        matches!(&self.scope, MetricScope::Sweep(sweep) if sweep.along.is_some())
    }

    /// The metric's name.
    pub(crate) const fn name(&self) -> &'static str {
        self.definition.name
    }

    /// The metric's unit; empty for the model's own.
    pub(crate) const fn unit(&self) -> &'static str {
        self.definition.unit
    }

    /// The coordinates of the run or of the part of the sweep.
    pub(crate) fn coordinates(&self) -> &[Coordinate] {
        match &self.scope {
            MetricScope::Run(run) => &run.coordinates,
            MetricScope::Sweep(sweep) => &sweep.coordinates,
        }
    }

    /// Whether the metric has a value; if not, [`Self::reason`] states why.
    pub(crate) fn is_applicable(&self) -> bool {
        self.reason.is_none() && self.value().is_finite()
    }

    /// Why the value, its error or its deviation from theory is missing; `None` if none is, or if there is no reason to give.
    pub(crate) fn reason(&self) -> Option<String> {
        if let Some(reason) = &self.reason {
            return Some(reason.to_string());
        }
        if !self.value().is_finite() {
            return Some("the value is not finite".to_owned());
        }
        let error = self.estimate.missing_error.filter(|_| self.standard_error().is_none());
        let error = error.map(|missing| missing.to_string());
        let range = self.theory.and_then(|theory| theory.out_of_range());
        let reasons: Vec<String> = error.into_iter().chain(range).collect();
        (!reasons.is_empty()).then(|| reasons.join("; "))
    }

    /// The reason as in the files, where every value without an error has one: also a value whose scatter one run cannot tell.
    pub(crate) fn reason_in_files(&self) -> Option<String> {
        let stated = self.reason();
        if stated.is_some() || self.standard_error().is_some() {
            return stated;
        }
        let why = match (self.deviation(), &self.scope) {
            (Some(Deviation::Rounding), _) => {
                "equal to theory up to rounding, which has no standard error"
            }
            (Some(Deviation::Bound { is_inside }), _) => {
                let side = if is_inside { "inside" } else { "outside" };
                return Some(format!("{side} {BOUND_ONLY}"));
            }
            (_, MetricScope::Run(_)) => {
                "one run does not tell the scatter between seeds: a standard error needs replicates; without random numbers there is none"
            }
            (_, MetricScope::Sweep(_)) => "one replicate does not tell the scatter between seeds",
        };
        Some(why.to_owned())
    }

    /// Deviation from theory; `None` without a theoretical value, and outside its law's range.
    pub(crate) fn deviation(&self) -> Option<Deviation> {
        Deviation::of(&self.estimate, self.theory, self.rounding)
    }

    /// Deviation from a given value, which does not follow the start of the run, as theory does.
    pub(crate) fn deviation_from(&self, expected: f64) -> Option<Deviation> {
        let estimate = Estimate { conditional_standard_error: None, ..self.estimate };
        Deviation::of(&estimate, expected.expected().map(|value| value.by(None)), self.rounding)
    }

    /// Deviation from theory in standard errors, if a standard error is known.
    pub(crate) fn deviation_in_standard_errors(&self) -> Option<f64> {
        self.deviation().and_then(Deviation::in_standard_errors)
    }
}

/// The run or the part of a sweep that a metric describes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum MetricScope {
    /// One run.
    Run(Arc<RunScope>),
    /// A point of the sweep, or a fit along one of its axes.
    Sweep(SweepScope),
}

/// One run.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct RunScope {
    /// The recording's file name.
    pub(crate) file: String,
    /// The run's coordinates in the sweep.
    pub(crate) coordinates: Vec<Coordinate>,
    /// Number of the replicate.
    pub(crate) replicate: u32,
    /// Seed of the random streams.
    pub(crate) seed: u64,
    /// How the run ended, in one word.
    pub(crate) outcome: &'static str,
    /// The run's identity and the programs behind it.
    pub(crate) origin: RunOrigin,
}

/// What identifies a recorded run, and the versions that produced it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct RunOrigin {
    /// The run key.
    pub(crate) run_key: String,
    /// Version of the program that recorded the run.
    pub(crate) program_version: String,
    /// Version of the model's physics.
    pub(crate) physics_version: u32,
}

/// A part of a sweep.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SweepScope {
    /// The key along which a fit was made; `None` for the mean over a point's replicates.
    pub(crate) along: Option<String>,
    /// The coordinates that all runs of this part share.
    pub(crate) coordinates: Vec<Coordinate>,
    /// Number of averaged replicates.
    pub(crate) replicates: usize,
}
