//! One row of `runs.parquet`: a run with its outcome and its metrics, without its recording.

use crate::metric::{Definition, Measurement, RunOrigin};
use crate::models::figures::Figures;
use crate::models::metrics_of;
use crate::run::cache::{CachedMeasurement, CachedTheory, measurement, number};
use crate::run::{RunAnalysis, RunStatus};
use crate::statistics::{Estimate, MissingError};
use kinetoscope_manifest::{Coordinate, RunManifest};
use serde::{Deserialize, Serialize};

/// A run with its outcome and its metrics. The file of a sweep in progress holds what its plan does not know.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunRow {
    /// The run's coordinates in its sweep.
    #[serde(skip)]
    pub coordinates: Vec<Coordinate>,
    /// Number of the replicate.
    #[serde(skip)]
    pub replicate: u32,
    /// Seed of all random streams.
    #[serde(skip)]
    pub seed: u64,
    /// Name of the recording, also if it is not kept.
    #[serde(skip)]
    pub file: String,
    /// The run key.
    pub run_key: String,
    /// The first half of the SHA-256 of all messages; `None` if they were not hashed.
    pub messages: Option<[u8; 16]>,
    pub(crate) program_version: String,
    pub(crate) physics_version: u32,
    pub(crate) outcome: String,
    pub(crate) outcome_detail: Option<String>,
    pub(crate) frames: u64,
    pub(crate) end_time: f64,
    pub(crate) model: String,
    /// Index among the model's metrics, value and standard error; NaN if one is missing.
    pub(crate) values: Vec<(u16, f64, f64)>,
    /// The rest of the measurements, which an analysis of the row needs: [`Details`] as postcard.
    pub(crate) details: Vec<u8>,
}

/// The unit of the time, and the measurements without values and standard errors.
type Details = (String, Vec<Detail>);
/// Index among the model's metrics, conditional standard error, degrees of freedom, why there is no error, theory and reason.
type Detail =
    (u16, Option<f64>, Option<f64>, Option<MissingError>, Option<CachedTheory>, Option<String>);

impl RunRow {
    /// The row of an analyzed run.
    #[must_use]
    pub fn of(run: &RunAnalysis) -> Self {
        let model = run.model().name();
        let known = metrics_of(model);
        let index = |found: &Measurement| {
            let at = known.iter().position(|it| it.name == found.definition.name)?;
            u16::try_from(at).ok()
        };
        let value = |found: &Measurement| {
            let value = if found.reason.is_none() { found.estimate.value } else { f64::NAN };
            let error = found.estimate.standard_error.filter(|_| found.reason.is_none());
            Some((index(found)?, value, error.unwrap_or(f64::NAN)))
        };
        let detail = |found: &Measurement| {
            let CachedMeasurement { estimate, theory, reason, .. } = number(found);
            let (conditional, freedom) =
                (estimate.conditional_standard_error, estimate.degrees_of_freedom);
            Some((index(found)?, conditional, freedom, estimate.missing_error, theory, reason))
        };
        let details: Vec<Detail> = run.measurements.iter().filter_map(detail).collect();
        Self {
            coordinates: run.coordinates.clone(),
            replicate: run.manifest.replicate,
            seed: run.manifest.seed,
            file: run.file.clone(),
            run_key: run.origin.run_key.clone(),
            messages: run.messages,
            program_version: run.origin.program_version.clone(),
            physics_version: run.origin.physics_version,
            outcome: run.ending.word().to_owned(),
            outcome_detail: run.ending.detail(),
            frames: run.frames,
            end_time: run.end_time,
            model: model.to_owned(),
            values: run.measurements.iter().filter_map(value).collect(),
            // Without them, the run is executed again.
            details: postcard::to_stdvec(&(&run.time_unit, details)).unwrap_or_default(),
        }
    }

    /// The analysis of a row with its place in the sweep, without figures and replay; `None` if its details are not those of this program.
    pub(crate) fn analysis(&self, manifest: RunManifest) -> Option<RunAnalysis> {
        let (time_unit, details) = self.details()?;
        let known = metrics_of(&self.model);
        let measured = |detail: Detail| {
            let (at, conditional_standard_error, degrees_of_freedom, missing_error, ..) = detail;
            let definition = known.get(usize::from(at))?;
            let [value, error] = self.value(definition);
            let standard_error = Some(error).filter(|error| !error.is_nan());
            let estimate = Estimate {
                value,
                standard_error,
                conditional_standard_error,
                degrees_of_freedom,
                missing_error,
            };
            let (name, theory, reason) = (definition.name.to_owned(), detail.4, detail.5);
            measurement(&self.model, &CachedMeasurement { name, estimate, theory, reason })
        };
        Some(RunAnalysis {
            file: self.file.clone(),
            coordinates: self.coordinates.clone(),
            manifest,
            origin: RunOrigin {
                run_key: self.run_key.clone(),
                program_version: self.program_version.clone(),
                physics_version: self.physics_version,
            },
            frames: self.frames,
            end_time: self.end_time,
            time_unit,
            ending: match self.outcome.as_str() {
                "complete" => RunStatus::Complete,
                "fault" => RunStatus::Fault(self.outcome_detail.clone().unwrap_or_default()),
                _ => RunStatus::Unfinished,
            },
            measurements: details.into_iter().map(measured).collect::<Option<_>>()?,
            messages: self.messages,
            figures: Figures::default(),
            replay: None,
            fields: Vec::new(),
            restored_by: None,
            claim: None,
        })
    }

    /// What the columns of values and errors lack; `None` if this program has not written it.
    pub(crate) fn details(&self) -> Option<Details> {
        postcard::from_bytes(&self.details).ok()
    }

    /// A row of a model with the values and errors of the metrics that have a column, and nothing else.
    pub(crate) fn of_values(model: &str, value: impl Fn(&str) -> Option<[f64; 2]>) -> Self {
        let known = metrics_of(model).iter().enumerate();
        let values = known.filter_map(|(at, metric)| {
            let [value, error] = value(metric.name)?;
            Some((u16::try_from(at).ok()?, value, error))
        });
        Self {
            coordinates: Vec::new(),
            replicate: 0,
            seed: 0,
            file: String::new(),
            run_key: String::new(),
            messages: None,
            program_version: String::new(),
            physics_version: 0,
            outcome: String::new(),
            outcome_detail: None,
            frames: 0,
            end_time: f64::NAN,
            model: model.to_owned(),
            values: values.collect(),
            details: Vec::new(),
        }
    }

    /// Why the run failed; `None` for a complete one.
    #[must_use]
    pub fn fault(&self) -> Option<&str> {
        (self.outcome == "fault").then(|| self.outcome_detail.as_deref().unwrap_or_default())
    }

    /// The name of the first metric of which another row of the run has another value or error; a missing one is missing in both.
    #[must_use]
    pub fn differing_metric(&self, other: &Self) -> Option<&'static str> {
        let is_same = |one: f64, other: f64| one == other || (one.is_nan() && other.is_nan());
        let differs = |metric: &&Definition| {
            let [own, others] = [self.value(metric), other.value(metric)];
            !is_same(own[0], others[0]) || !is_same(own[1], others[1])
        };
        metrics_of(&self.model).iter().copied().find(differs).map(|metric| metric.name)
    }

    /// The row as bytes.
    ///
    /// # Errors
    /// A defect of the program.
    pub fn to_bytes(&self) -> Result<Vec<u8>, postcard::Error> {
        postcard::to_stdvec(self)
    }

    /// The row of these bytes; `None` if they are not one that this version of the program has derived.
    #[must_use]
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let row: Option<Self> = postcard::from_bytes(bytes).ok();
        row.filter(|row| row.program_version == env!("CARGO_PKG_VERSION"))
    }

    /// The metrics with a value or an error, in the order in which they were derived.
    pub(crate) fn definitions(&self) -> impl Iterator<Item = &'static Definition> {
        let known = metrics_of(&self.model);
        let has_cell =
            |(_, value, error): &&(u16, f64, f64)| value.is_finite() || error.is_finite();
        let present = self.values.iter().filter(has_cell);
        present.filter_map(|(at, ..)| known.get(usize::from(*at)).copied())
    }

    /// The value and the standard error of a metric; NaN if one is missing.
    pub(crate) fn value(&self, definition: &Definition) -> [f64; 2] {
        let known = metrics_of(&self.model);
        let is_it = |(at, ..): &&(u16, f64, f64)| {
            known.get(usize::from(*at)).is_some_and(|it| it.name == definition.name)
        };
        self.values.iter().find(is_it).map_or([f64::NAN; 2], |(_, value, error)| [*value, *error])
    }
}

#[cfg(test)]
mod tests {
    use super::RunRow;

    /// Guarantee: `verify --sample` finds a changed value, a changed error and one that appeared. Control: a metric that is missing in both.
    #[test]
    fn changed_metric_of_a_row_is_named() {
        let row = |pressure: f64, error: f64, speed: f64| {
            RunRow::of_values("gas", move |name| match name {
                "pressure.measured" => Some([pressure, error]),
                "mean_speed" => Some([speed, f64::NAN]),
                _ => None,
            })
        };
        let stored = row(1.0, 0.1, f64::NAN);
        assert_eq!(row(1.0, 0.1, f64::NAN).differing_metric(&stored), None);
        let changed = f64::from_bits(1.0_f64.to_bits() + 1);
        for other in [row(changed, 0.1, f64::NAN), row(1.0, f64::NAN, f64::NAN)] {
            assert_eq!(other.differing_metric(&stored), Some("pressure.measured"));
        }
        assert_eq!(row(1.0, 0.1, 2.0).differing_metric(&stored), Some("mean_speed"));
    }
}
