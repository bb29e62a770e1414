//! One recording from file to numbers.

pub mod cache;

use crate::input::UnreadableRecording;
use crate::input::recording::{OpenRun, is_partial};
use crate::metric::{Measurement, Metric, MetricScope, RunScope};
use crate::models::figures::Figures;
use crate::models::registry;
use kinetoscope_manifest::model::ModelConfig;
use kinetoscope_manifest::{Coordinate, RunManifest};
use kinetoscope_recording::error::{ReadError, ReadFault};
use kinetoscope_recording::reader::Outcome;
use std::num::NonZeroUsize;

/// How a run, or its file, ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RunStatus {
    /// It reached its end.
    Complete,
    /// Physics went wrong, in words.
    Fault(String),
    /// It was stopped and can be continued, or it is still under way.
    Unfinished,
    /// The file is damaged behind the frames that were read.
    Damaged(String),
}

impl RunStatus {
    /// In a few words.
    #[must_use]
    pub fn text(&self) -> String {
        match self {
            Self::Complete => "complete".to_owned(),
            Self::Fault(what) => format!("fault: {what}"),
            Self::Unfinished => "unfinished".to_owned(),
            Self::Damaged(_) => "damaged".to_owned(),
        }
    }
}

/// What was found in one recording.
#[derive(Clone, Debug, PartialEq)]
pub struct RunAnalysis {
    /// The file's name, without its folder.
    pub file: String,
    /// Where the run lies in its sweep.
    pub coordinates: Vec<Coordinate>,
    /// The run.
    pub manifest: RunManifest,
    /// Frames that were read.
    pub frames: u64,
    /// Simulated time of the last frame, in the model's unit.
    pub end_time: f64,
    /// "s", "d", or "" for dimensionless time.
    pub time_unit: String,
    /// How it ended.
    pub ending: RunStatus,
    /// The numbers.
    pub measurements: Vec<Measurement>,
    /// The plots, where they were asked for.
    pub figures: Figures,
}

impl RunAnalysis {
    /// A measurement by its name.
    #[must_use]
    pub fn measurement(&self, name: &str) -> Option<&Measurement> {
        self.measurements.iter().find(|measurement| measurement.name() == name)
    }

    /// The model and its values.
    #[must_use]
    pub fn model(&self) -> &ModelConfig {
        &self.manifest.model
    }

    /// The metrics of the run.
    pub fn metrics(&self) -> impl Iterator<Item = Metric> + '_ {
        self.measurements.iter().map(|measurement| Metric {
            definition: measurement.definition,
            value: measurement.estimate.value,
            standard_error: measurement.estimate.standard_error,
            theory: measurement.theory,
            rounding: measurement.definition.rounding,
            source: measurement.source(),
            scope: MetricScope::Run(RunScope {
                file: self.file.clone(),
                coordinates: self.coordinates.clone(),
                replicate: self.manifest.replicate,
                outcome: self.ending.text(),
            }),
        })
    }

    /// Whether the numbers are those of the whole run, as means and fits need them.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.ending == RunStatus::Complete
    }
}

/// Reads all frames of a recording, one after the other, with so many threads that unpack chunks. Memory: what `Frames` says,
/// three frames, and some megabytes for series and pictures, whatever the file's size.
///
/// # Errors
/// A recording of which not even the first frame could be read.
pub fn analyze(
    run: &OpenRun,
    coordinates: Vec<Coordinate>,
    with_figures: bool,
    snapshots_at: &[f64],
    threads: NonZeroUsize,
) -> Result<RunAnalysis, UnreadableRecording> {
    let mut observer = registry::observer(&run.manifest.model, snapshots_at).ok_or_else(|| {
        let model = run.manifest.model.name();
        UnreadableRecording(format!("the model {model} has no analysis"))
    })?;
    let (mut frames, mut end_time, mut failure) = (0, 0.0, None);
    for frame in run.recording().frames_on(threads).map_err(UnreadableRecording::new)? {
        let seen = frame.and_then(|frame| {
            let time = frame.clock.time;
            observer.observe(frame).map(|()| time)
        });
        match seen {
            Ok(time) => {
                frames += 1;
                end_time = time;
            }
            Err(error) => {
                failure = Some(error);
                break;
            }
        }
    }
    let ending = match (&failure, &run.recording().provenance().outcome) {
        (Some(error), _) if frames == 0 => return Err(UnreadableRecording::new(error)),
        (Some(error), _) if is_under_way(&run.file, error) => RunStatus::Unfinished,
        (Some(error), _) => RunStatus::Damaged(error.to_string()),
        (None, Some(Outcome::Complete)) => RunStatus::Complete,
        (None, Some(Outcome::Fault(what))) => RunStatus::Fault(what.clone()),
        (None, Some(Outcome::Interrupted) | None) => RunStatus::Unfinished,
    };
    if frames == 0 {
        let path = run.recording().path().display();
        return Err(UnreadableRecording(format!("{path} holds no frame")));
    }
    Ok(RunAnalysis {
        coordinates,
        frames,
        end_time,
        time_unit: run.recording().provenance().time_unit.clone(),
        ending,
        measurements: observer.measurements(),
        figures: if with_figures { observer.figures() } else { Figures::default() },
        file: run.file.clone(),
        manifest: run.manifest.clone(),
    })
}

/// A partial file has no footer while its run is under way: that is no damage.
fn is_under_way(file: &str, error: &ReadError) -> bool {
    is_partial(file) && matches!(error.fault, ReadFault::Torn { .. })
}
