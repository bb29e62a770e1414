//! Cache of the analyses of unchanged recordings, in a folder next to the results.

use crate::input::recording::OpenRun;
use crate::metric::{Definition, Measurement, Theory, Violation};
use crate::models::figures::Figures;
use crate::models::metrics_of;
use crate::replay::Replay;
use crate::run::fields::RecordedField;
use crate::run::{RunAnalysis, RunOptions, RunStatus};
use crate::statistics::Estimate;
use crate::write_file;
use kinetoscope_files::atomic_file::replace_own_unsynced;
use kinetoscope_files::regular_file::{MAX_SIDE_FILE_BYTES, read_own};
use kinetoscope_manifest::Coordinate;
use kinetoscope_recording::claim::Claim;
use kinetoscope_recording::plot_list::CACHE_FOLDER;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

/// A cached analysis is valid only if all of this is unchanged.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct CacheKey {
    /// The program file: another version may derive other values.
    program: FileStamp,
    /// The recording.
    recording: FileStamp,
    run_key: String,
    snapshots_at: Vec<f64>,
    /// How the replay begins, as text, of which only equality counts.
    view: String,
}

/// Size and modification time of a file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct FileStamp {
    bytes: u64,
    changed_ns: u128,
}

impl FileStamp {
    fn new(bytes: u64, changed: SystemTime) -> Option<Self> {
        let changed_ns = changed.duration_since(UNIX_EPOCH).ok()?.as_nanos();
        Some(Self { bytes, changed_ns })
    }
}

#[derive(Serialize, Deserialize)]
struct CachedAnalysis {
    identity: CacheKey,
    frames: u64,
    end_time: f64,
    time_unit: String,
    /// The simulation fault; `None` for a complete run.
    fault: Option<String>,
    measurements: Vec<CachedMeasurement>,
    messages: Option<[u8; 16]>,
    /// `None` if no plots were requested.
    figures: Option<Figures>,
    /// Maximum size of the replay, bytes; `None` if no replay was requested.
    replay_bytes: Option<usize>,
    replay: Option<Replay>,
    /// The fields that were requested.
    fields: Vec<RecordedField>,
    /// `None` if no claim was requested.
    claim: Option<Option<Claim>>,
}

/// A measurement as a file has it.
#[derive(Serialize, Deserialize)]
pub(crate) struct CachedMeasurement {
    pub(crate) name: String,
    pub(crate) estimate: Estimate,
    pub(crate) theory: Option<CachedTheory>,
    pub(crate) reason: Option<String>,
}

/// Value, accuracy, condition that the run does not meet, and index of the law among those of the definition.
pub(crate) type CachedTheory = (f64, f64, Option<Violation>, Option<usize>);

/// The cache of one folder of results.
#[derive(Clone, Debug)]
pub(crate) struct AnalysisCache {
    folder: PathBuf,
    program: FileStamp,
}

impl AnalysisCache {
    /// The cache in the folder of the results; `None` if the program file cannot be identified.
    pub(crate) fn in_folder(output: &Path) -> Option<Self> {
        let program = std::env::current_exe().ok()?;
        let program = std::fs::metadata(program).ok()?;
        let program = FileStamp::new(program.len(), program.modified().ok()?)?;
        Some(Self { folder: output.join(CACHE_FOLDER), program })
    }

    fn path(&self, file: &str) -> PathBuf {
        self.folder.join(format!("{file}.numbers"))
    }

    fn identity(&self, run: &OpenRun, options: RunOptions<'_>) -> Option<CacheKey> {
        Some(CacheKey {
            program: self.program.clone(),
            recording: FileStamp::new(run.recording().bytes(), run.recording().changed()?)?,
            run_key: run.run_key.clone(),
            snapshots_at: options.snapshots_at.to_vec(),
            view: format!("{:?}", options.view),
        })
    }

    /// The cached analysis of an unchanged recording; `None` if it must be read, also because another user could have written
    /// the cache.
    pub(crate) fn load(
        &self,
        run: &OpenRun,
        coordinates: &[Coordinate],
        options: RunOptions<'_>,
    ) -> Option<RunAnalysis> {
        let RunOptions { with_figures, replay_bytes, fields, with_claim, .. } = options;
        let identity = self.identity(run, options)?;
        let bytes = read_own(&self.path(&run.file), MAX_SIDE_FILE_BYTES).ok()?;
        let cached: CachedAnalysis = postcard::from_bytes(&bytes).ok()?;
        let lacks_part = replay_bytes.is_some() && cached.replay_bytes != replay_bytes
            || with_figures && cached.figures.is_none()
            || with_claim && cached.claim.is_none();
        if cached.identity != identity || lacks_part {
            return None;
        }
        let fields = fields.iter().map(|name| cached.fields.iter().find(|it| it.name == *name));
        let fields = fields.map(Option::<&RecordedField>::cloned).collect::<Option<_>>()?;
        if !cached.figures.as_ref().is_none_or(Figures::have_plain_names) {
            return None;
        }
        let numbers = cached.measurements.into_iter();
        let model = run.manifest.model.name();
        Some(RunAnalysis {
            file: run.file.clone(),
            coordinates: coordinates.to_vec(),
            manifest: run.manifest.clone(),
            origin: run.origin(),
            frames: cached.frames,
            end_time: cached.end_time,
            time_unit: cached.time_unit,
            ending: cached.fault.map_or(RunStatus::Complete, RunStatus::Fault),
            measurements: numbers
                .map(|number| measurement(model, &number))
                .collect::<Option<_>>()?,
            messages: cached.messages,
            figures: cached.figures.filter(|_| with_figures).unwrap_or_default(),
            replay: cached.replay.filter(|_| replay_bytes.is_some()),
            fields,
            restored_by: run.keyframes().map(|(_, command)| command),
            claim: cached.claim.flatten().filter(|_| with_claim),
        })
    }

    /// Stores the analysis of a finished run. If it cannot be written, the next analysis reads the recording.
    pub(crate) fn store(&self, run: &OpenRun, found: &RunAnalysis, options: RunOptions<'_>) {
        let fault = match &found.ending {
            RunStatus::Complete => None,
            RunStatus::Fault(what) => Some(what.clone()),
            RunStatus::Unfinished | RunStatus::Damaged(_) => return,
        };
        let Some(identity) = self.identity(run, options) else { return };
        let cached = CachedAnalysis {
            identity,
            frames: found.frames,
            end_time: found.end_time,
            time_unit: found.time_unit.clone(),
            fault,
            measurements: found.measurements.iter().map(number).collect(),
            messages: found.messages,
            figures: options.with_figures.then(|| found.figures.clone()),
            replay_bytes: options.replay_bytes,
            replay: found.replay.clone(),
            fields: found.fields.clone(),
            claim: options.with_claim.then(|| found.claim.clone()),
        };
        if let Ok(bytes) = postcard::to_stdvec(&cached) {
            let path = self.path(&run.file);
            if write_file::create_folder(&self.folder).is_ok() {
                // Not synced: a lost entry is written again.
                drop(replace_own_unsynced(&path, &bytes));
            }
        }
    }
}

/// The measurement for a file.
pub(crate) fn number(measurement: &Measurement) -> CachedMeasurement {
    let laws = measurement.definition.laws;
    CachedMeasurement {
        name: measurement.name().to_owned(),
        estimate: measurement.estimate,
        theory: measurement.theory.map(|theory| {
            let law = theory.law.and_then(|law| laws.iter().position(|other| other == law));
            (theory.value, theory.accuracy, theory.violation, law)
        }),
        reason: measurement.reason.as_deref().map(str::to_owned),
    }
}

/// The measurement from a file; `None` if the model has no such metric.
pub(crate) fn measurement(model: &str, number: &CachedMeasurement) -> Option<Measurement> {
    let named = |definition: &&&Definition| definition.name == number.name;
    let definition = metrics_of(model).iter().find(named)?;
    let theory = number.theory.map(|(value, accuracy, violation, law)| {
        let law = law.and_then(|law| definition.laws.get(law));
        Theory { value, accuracy, violation, law }
    });
    let reason = number.reason.clone().map(Into::into);
    Some(Measurement { definition, estimate: number.estimate, theory, reason })
}
