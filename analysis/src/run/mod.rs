//! Analysis of one recording.

pub(crate) mod cache;
pub(crate) mod fields;

use crate::input::UnreadableRecording;
use crate::input::recording::{OpenRun, is_partial};
use crate::metric::{Measurement, Measurements, Metric, MetricScope, RunOrigin, RunScope};
use crate::models;
use crate::models::figures::Figures;
use crate::plot::DRAWS;
use crate::replay::{Replay, ReplayCollector};
use crate::run::fields::{FieldCollector, RecordedField};
use kinetoscope_console::text::shown_path;
use kinetoscope_console::{Explained as _, Message};
use kinetoscope_manifest::model::ModelConfig;
use kinetoscope_manifest::{Coordinate, RunManifest, ViewRequest};
use kinetoscope_recording::claim::Claim;
use kinetoscope_recording::error::{ReadError, ReadFault};
use kinetoscope_recording::frame_hashes::FrameHashes;
use kinetoscope_recording::reader::{Outcome, StoredFrames};
use std::num::NonZeroUsize;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Arc;

/// Size of a recording up to which its page can check it.
const MOST_CLAIMED_BYTES: u64 = 64 << 20;
/// Size of a recording up to which the table of the runs has the hash of its messages. A larger one is read without its drawings, and the
/// hash would take longer than the metrics.
const MOST_HASHED_BYTES: u64 = 1 << 20;

/// Status of a run or of its file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RunStatus {
    /// The run is complete.
    Complete,
    /// The run failed with a simulation fault.
    Fault(String),
    /// The run was interrupted or is still in progress.
    Unfinished,
    /// The file is damaged after the frames that were read.
    Damaged(Message),
}

impl RunStatus {
    /// The status in one word.
    pub(crate) const fn word(&self) -> &'static str {
        match self {
            Self::Complete => "complete",
            Self::Fault(_) => "fault",
            Self::Unfinished => "unfinished",
            Self::Damaged(_) => "damaged",
        }
    }

    /// What failed in the run or in its file.
    pub(crate) fn detail(&self) -> Option<String> {
        match self {
            Self::Complete | Self::Unfinished => None,
            Self::Fault(what) => Some(what.clone()),
            Self::Damaged(why) => Some(why.clause()),
        }
    }
}

/// What the analysis of a recording derives in addition to metrics.
#[derive(Clone, Copy, Debug, Default)]
pub struct RunOptions<'a> {
    /// Whether the run is plotted.
    pub with_figures: bool,
    /// Times of snapshots in addition to start and end, in the model's unit.
    pub snapshots_at: &'a [f64],
    /// Maximum size of the run's replay in the page, bytes; `None` for no replay.
    pub replay_bytes: Option<usize>,
    /// Fields of channels that are plotted over time, such as `/energy.kinetic_j`.
    pub fields: &'a [String],
    /// How the replay begins; `None` for the most telling frame in the colors of the speed.
    pub view: Option<&'a ViewRequest>,
    /// Whether the page can check the messages of the run.
    pub with_claim: bool,
    /// Whether the messages of a small recording are hashed, for the table of runs.
    pub with_messages: bool,
}

/// Metrics and plots of one recording.
#[derive(Clone, Debug, PartialEq)]
pub struct RunAnalysis {
    /// The file name without its folder.
    pub file: String,
    /// The run's coordinates in its sweep.
    pub(crate) coordinates: Vec<Coordinate>,
    /// The run's manifest.
    pub(crate) manifest: RunManifest,
    /// The run's identity and the programs behind it.
    pub(crate) origin: RunOrigin,
    /// Number of frames read.
    pub frames: u64,
    /// Simulated time of the last frame, in the model's unit.
    pub end_time: f64,
    /// "s", "d", or "" for dimensionless time.
    pub time_unit: String,
    /// The status of the run.
    pub ending: RunStatus,
    /// The metrics.
    pub measurements: Vec<Measurement>,
    /// The first half of the SHA-256 of all messages, as a lock file contains it; `None` for a recording that is large or lacks messages.
    pub messages: Option<[u8; 16]>,
    /// The plots, if requested.
    pub(crate) figures: Figures,
    /// The replay, if requested.
    pub(crate) replay: Option<Replay>,
    /// The requested fields over time.
    pub(crate) fields: Vec<RecordedField>,
    /// The command that restores frames whose states are not stored; `None` if all are.
    pub(crate) restored_by: Option<String>,
    /// The manifest and the hashes of all messages, if requested and if the recording is whole and not too large.
    pub(crate) claim: Option<Claim>,
}

impl RunAnalysis {
    /// The measurement with this name; `None` if it has no value.
    #[must_use]
    pub fn measurement(&self, name: &str) -> Option<&Measurement> {
        let named = |measurement: &&Measurement| measurement.name() == name;
        self.measurements.iter().find(named).filter(|found| found.reason.is_none())
    }

    /// The model's configuration.
    pub(crate) fn model(&self) -> &ModelConfig {
        &self.manifest.model
    }

    /// The metrics of the run.
    pub(crate) fn metrics(&self) -> impl Iterator<Item = Metric> + '_ {
        let scope = Arc::new(RunScope {
            file: self.file.clone(),
            coordinates: self.coordinates.clone(),
            replicate: self.manifest.replicate,
            seed: self.manifest.seed,
            outcome: self.ending.word(),
            origin: self.origin.clone(),
        });
        self.measurements.iter().map(move |measurement| {
            let scope = MetricScope::Run(Arc::clone(&scope));
            let Measurement { definition, estimate, theory, .. } = *measurement;
            let metric = Metric::new(definition, estimate, theory, scope);
            Metric { reason: measurement.reason.clone(), ..metric }
        })
    }

    /// Whether the run is complete, as means and fits require.
    pub(crate) fn is_complete(&self) -> bool {
        self.ending == RunStatus::Complete
    }
}

/// Reads all frames of a recording in order; `threads` is the number of threads that decompress chunks. Of a recording of keyframes,
/// metrics and charts that need the states of all frames are withheld, as is the replay. The memory is bounded for any file size: that
/// of `Frames`, three frames, some megabytes for series and snapshots, and fifteen times the maximum size of the replay.
///
/// # Errors
/// A recording without a readable frame, or a disk that fails, after which the frames before are not a result.
pub fn analyze(
    run: &OpenRun,
    coordinates: Vec<Coordinate>,
    options: RunOptions<'_>,
    threads: NonZeroUsize,
) -> Result<RunAnalysis, UnreadableRecording> {
    let mut observer = models::observer(&run.manifest.model, options.snapshots_at);
    let view = || options.view.cloned().unwrap_or_default();
    let replay_bytes = if DRAWS { options.replay_bytes } else { None };
    let mut replay = replay_bytes.map(|bytes| ReplayCollector::new(bytes, run, view()));
    let mut fields = FieldCollector::new(options.fields);
    let (mut frames, mut end_time, mut failure) = (0, 0.0, None);
    let (mut lacks_states, mut has_end) = (false, true);
    let all = run.recording().frames_on(threads)?.with_first_drawing_only().with_scalar_frames();
    for frame in all {
        let observed = frame.and_then(|frame| {
            has_end = frame.is_complete();
            lacks_states |= !has_end;
            let time = frame.clock.time;
            if DRAWS && let Some(replay) = &mut replay {
                replay.observe(&frame);
            }
            fields.observe(&frame);
            observer.observe(frame).map(|()| time)
        });
        match observed {
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
    if let Some(error) = failure.take_if(|error| frames == 0 || error.is_of_machine()) {
        return Err(error.into());
    }
    let ending = ending(run, failure.as_ref());
    if frames == 0 {
        let path = shown_path(run.recording().path());
        return Err(UnreadableRecording::new(
            format!("{path} holds no frame"),
            "run its manifest again",
        ));
    }
    if !has_end {
        return Err(between_keyframes(run, failure, &ending));
    }
    let mut measurements = Measurements::default();
    observer.measure(&mut measurements);
    let mut figures = if options.with_figures { observer.figures() } else { Figures::default() };
    let mut replay = if DRAWS { replay.map(ReplayCollector::finish) } else { None };
    let restored_by = run.keyframes().map(|(_, command)| command);
    if let Some(command) = restored_by.as_deref().filter(|_| lacks_states) {
        withhold(run, command, &mut measurements, &mut figures, &mut replay);
    }
    Ok(RunAnalysis {
        coordinates,
        frames,
        end_time,
        time_unit: run.recording().provenance().time_unit.clone(),
        ending,
        measurements: measurements.0,
        messages: options.with_messages.then(|| message_hash(run)).flatten(),
        replay,
        fields: fields.finish(),
        restored_by,
        claim: options.with_claim.then(|| claim(run)).flatten(),
        figures,
        file: run.file.clone(),
        manifest: run.manifest.clone(),
        origin: run.origin(),
    })
}

/// The hash of all messages of a small recording that has all of them.
fn message_hash(run: &OpenRun) -> Option<[u8; 16]> {
    let recording = run.recording();
    let provenance = recording.provenance();
    let is_whole = matches!(provenance.outcome, Some(Outcome::Complete | Outcome::Fault(_)))
        && provenance.stored == StoredFrames::All;
    let is_hashed = is_whole && recording.bytes() <= MOST_HASHED_BYTES;
    is_hashed.then(|| FrameHashes::of(recording).ok()).flatten().map(|hashes| hashes.messages)
}

/// The claim of a recording, for which all of its messages are read. A page runs what takes some seconds; therefore, a larger recording has
/// none.
fn claim(run: &OpenRun) -> Option<Claim> {
    let recording = run.recording();
    let is_small = recording.bytes() <= MOST_CLAIMED_BYTES;
    is_small.then(|| Claim::of(recording).ok()).flatten().flatten()
}

/// Leaves out what needs the states of all frames, which a command restores.
fn withhold(
    run: &OpenRun,
    command: &str,
    measurements: &mut Measurements,
    figures: &mut Figures,
    replay: &mut Option<Replay>,
) {
    let model = run.manifest.model.name();
    measurements.withhold(|metric| models::needs_all_states(model, metric), command);
    figures.retain(|chart| !models::chart_needs_all_states(model, chart));
    if let Some(replay) = replay {
        replay.film = None;
        replay.note = format!(
            "No replay: the recording holds keyframes, and `{command}` restores all frames."
        );
    }
}

/// How a run ended; `failure` is the error after which no frame was read.
fn ending(run: &OpenRun, failure: Option<&ReadError>) -> RunStatus {
    match (failure, &run.recording().provenance().outcome) {
        (Some(error), _) if is_under_way(&run.file, error) => RunStatus::Unfinished,
        (Some(error), _) => RunStatus::Damaged(error.message()),
        (None, Some(Outcome::Complete)) => RunStatus::Complete,
        (None, Some(Outcome::Fault(what))) => RunStatus::Fault(what.clone()),
        (None, Some(Outcome::Interrupted) | None) => RunStatus::Unfinished,
    }
}

/// The error of a recording of keyframes that ends between two of them: most metrics need the state at the end.
fn between_keyframes(
    run: &OpenRun,
    failure: Option<ReadError>,
    ending: &RunStatus,
) -> UnreadableRecording {
    match (failure, ending) {
        (Some(error), RunStatus::Damaged(_)) => error.into(),
        (_, ending) => {
            let command = run.keyframes().filter(|_| matches!(ending, RunStatus::Fault(_)));
            let help = match command {
                Some((_, command)) => format!("restore all frames with `{command}`"),
                None => "run the experiment again to resume it".to_owned(),
            };
            let path = shown_path(run.recording().path());
            let what = format!(
                "{path}: it holds keyframes and ends between two of them, and metrics need the state at the end"
            );
            UnreadableRecording::new(what, help)
        }
    }
}

/// Analyzes a recording so that a panic, which is a defect of the program, leaves only this recording unread.
///
/// # Errors
/// Those of `analyze`, or a panic.
pub(crate) fn catch_defect<T>(
    recording: &Path,
    analyze: impl FnOnce() -> Result<T, UnreadableRecording>,
) -> Result<T, UnreadableRecording> {
    // A panic leaves nothing behind that is used again: the recording was only read.
    catch_unwind(AssertUnwindSafe(analyze)).unwrap_or_else(|_| {
        Err(UnreadableRecording::new(
            format!(
                "{} cannot be analyzed: a defect of the program, which is described above",
                shown_path(recording)
            ),
            "please report it with this recording",
        ))
    })
}

/// Whether an error is only the missing footer of a recording in progress.
fn is_under_way(file: &str, error: &ReadError) -> bool {
    is_partial(file) && matches!(error.fault, ReadFault::Torn { .. } | ReadFault::Growing { .. })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panic_in_the_analysis_of_one_run_makes_only_this_run_unreadable() {
        let path = Path::new("one.mcap");
        let panicked: Result<(), _> = catch_defect(path, || panic!("a defect, on purpose"));
        let Err(why) = panicked.map_err(|error| error.message) else {
            panic!("the panic was lost")
        };
        assert!(why.what.contains("one.mcap") && why.what.contains("defect"), "{why}");
        assert_eq!(catch_defect(path, || Ok(7)), Ok(7));
    }
}
