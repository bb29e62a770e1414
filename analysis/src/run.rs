//! One recording from file to numbers.

use crate::figures::Figures;
use crate::measurement::Measurement;
use crate::observables::observer;
use kinetoscope_manifest::model::ModelConfig;
use kinetoscope_manifest::{Coordinate, RunManifest, parse_run};
use kinetoscope_recording::error::{ReadError, ReadFault};
use kinetoscope_recording::reader::{Outcome, Recording};
use std::num::NonZeroUsize;
use std::path::Path;

/// How a run, or its file, ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Ending {
    /// It reached its end.
    Complete,
    /// Physics went wrong, in words.
    Fault(String),
    /// It was stopped and can be continued, or it is still under way.
    Unfinished,
    /// The file is damaged behind the frames that were read.
    Damaged(String),
}

impl Ending {
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
    pub ending: Ending,
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

    /// Whether the numbers are those of the whole run, as means and fits need them.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.ending == Ending::Complete
    }
}

/// A recording that told nothing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unreadable(pub String);

/// A recording that is open, with its manifest read.
pub struct OpenRun {
    recording: Recording,
    /// The file's name, without its folder.
    pub file: String,
    /// The canonical text of the run's manifest.
    pub canonical: String,
    /// The run's manifest.
    pub manifest: RunManifest,
    /// The run's run key.
    pub run_key: String,
}

impl OpenRun {
    /// The recording.
    #[must_use]
    pub fn recording(&self) -> &Recording {
        &self.recording
    }
}

/// Opens a recording and reads its manifest.
///
/// # Errors
/// A file that is no recording of ours, or whose manifest does not read.
pub fn open(path: &Path) -> Result<OpenRun, Unreadable> {
    opened(Recording::open(path).map_err(unreadable)?)
}

/// What an error of the reader says.
pub(crate) fn unreadable(error: ReadError) -> Unreadable {
    Unreadable(error.to_string())
}

/// Reads the manifest of an open recording.
///
/// # Errors
/// A manifest that does not read.
pub fn opened(recording: Recording) -> Result<OpenRun, Unreadable> {
    let canonical = recording.manifest().to_owned();
    let path = recording.path();
    let manifest = parse_run(&canonical).map_err(|diagnostics| {
        let path = path.display();
        Unreadable(format!(
            "{path}: its manifest is not one that this version reads; no frame was read\n{diagnostics}"
        ))
    })?;
    let file = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into());
    let run_key = recording.provenance().run_key.clone();
    Ok(OpenRun { recording, file, canonical, manifest, run_key })
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
    pictures_at: &[f64],
    threads: NonZeroUsize,
) -> Result<RunAnalysis, Unreadable> {
    let mut observer = observer(&run.manifest.model, pictures_at);
    let (mut frames, mut end_time, mut failure) = (0, 0.0, None);
    for frame in run.recording.frames_on(threads).map_err(|error| Unreadable(error.to_string()))? {
        let seen = frame.and_then(|frame| {
            let time = frame.clock.time;
            observer.see(frame).map(|()| time)
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
    let ending = match (&failure, &run.recording.provenance().outcome) {
        (Some(error), _) if frames == 0 => return Err(Unreadable(error.to_string())),
        (Some(error), _) if is_under_way(&run.file, error) => Ending::Unfinished,
        (Some(error), _) => Ending::Damaged(error.to_string()),
        (None, Some(Outcome::Complete)) => Ending::Complete,
        (None, Some(Outcome::Fault(what))) => Ending::Fault(what.clone()),
        (None, Some(Outcome::Interrupted) | None) => Ending::Unfinished,
    };
    if frames == 0 {
        let path = run.recording.path().display();
        return Err(Unreadable(format!("{path} holds no frame")));
    }
    Ok(RunAnalysis {
        coordinates,
        frames,
        end_time,
        time_unit: run.recording.provenance().time_unit.clone(),
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

/// Whether a file's name is that of a recording under way.
#[must_use]
pub fn is_partial(file: &str) -> bool {
    file.ends_with(".partial.mcap")
}
