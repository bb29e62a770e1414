//! What was found in a recording, remembered beside the results: a sweep is put together again without reading recordings
//! that have not changed.

use crate::catalog;
use crate::figures::Figures;
use crate::files;
use crate::measurement::Measurement;
use crate::run::{Ending, OpenRun, RunAnalysis};
use crate::statistics::Estimate;
use kinetoscope_manifest::Coordinate;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

/// Folder of the remembered analyses, beside the results. It can be deleted at any time.
pub const FOLDER: &str = ".analysis-cache";

/// What must be the same for an analysis to be taken from memory.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Identity {
    /// Size and time of change of this program: another one may derive other numbers.
    program: Stamp,
    /// Of the recording.
    recording: Stamp,
    content_key: String,
    pictures_at: Vec<f64>,
}

/// Size of a file, and when it was last changed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Stamp {
    bytes: u64,
    changed_ns: u128,
}

impl Stamp {
    fn new(bytes: u64, changed: SystemTime) -> Option<Self> {
        let changed_ns = changed.duration_since(UNIX_EPOCH).ok()?.as_nanos();
        Some(Self { bytes, changed_ns })
    }
}

#[derive(Serialize, Deserialize)]
struct Remembered {
    identity: Identity,
    frames: u64,
    end_time: f64,
    time_unit: String,
    /// What went wrong with the physics; none of a run that reached its end.
    fault: Option<String>,
    measurements: Vec<Number>,
    /// None where they were not asked for.
    figures: Option<Figures>,
}

#[derive(Serialize, Deserialize)]
struct Number {
    name: String,
    value: f64,
    standard_error: Option<f64>,
    theory: Option<f64>,
    /// Place of the law among those of the definition.
    law: Option<usize>,
}

/// The memory of one folder of results.
#[derive(Clone, Debug)]
pub struct Memory {
    folder: PathBuf,
    program: Stamp,
}

impl Memory {
    /// The memory beside the results in `output`; `None` where this program can't tell itself from another one.
    #[must_use]
    pub fn beside(output: &Path) -> Option<Self> {
        let program = std::env::current_exe().ok()?;
        let program = std::fs::metadata(program).ok()?;
        let program = Stamp::new(program.len(), program.modified().ok()?)?;
        Some(Self { folder: output.join(FOLDER), program })
    }

    fn path(&self, file: &str) -> PathBuf {
        self.folder.join(format!("{file}.numbers"))
    }

    fn identity(&self, run: &OpenRun, pictures_at: &[f64]) -> Option<Identity> {
        Some(Identity {
            program: self.program.clone(),
            recording: Stamp::new(run.recording().bytes(), run.recording().changed()?)?,
            content_key: run.content_key.clone(),
            pictures_at: pictures_at.to_vec(),
        })
    }

    /// The analysis of an unchanged recording; `None` where it must be read.
    #[must_use]
    pub fn recall(
        &self,
        run: &OpenRun,
        coordinates: &[Coordinate],
        with_figures: bool,
        pictures_at: &[f64],
    ) -> Option<RunAnalysis> {
        let identity = self.identity(run, pictures_at)?;
        let bytes = std::fs::read(self.path(&run.file)).ok()?;
        let remembered: Remembered = postcard::from_bytes(&bytes).ok()?;
        if remembered.identity != identity || with_figures && remembered.figures.is_none() {
            return None;
        }
        let numbers = remembered.measurements.into_iter();
        let model = run.manifest.model.name();
        Some(RunAnalysis {
            file: run.file.clone(),
            coordinates: coordinates.to_vec(),
            manifest: run.manifest.clone(),
            frames: remembered.frames,
            end_time: remembered.end_time,
            time_unit: remembered.time_unit,
            ending: remembered.fault.map_or(Ending::Complete, Ending::Fault),
            measurements: numbers
                .map(|number| measurement(model, &number))
                .collect::<Option<_>>()?,
            figures: remembered.figures.filter(|_| with_figures).unwrap_or_default(),
        })
    }

    /// Remembers the analysis of a finished run. Where that can't be written, the next analysis reads the recording.
    pub fn keep(
        &self,
        run: &OpenRun,
        found: &RunAnalysis,
        with_figures: bool,
        pictures_at: &[f64],
    ) {
        let fault = match &found.ending {
            Ending::Complete => None,
            Ending::Fault(what) => Some(what.clone()),
            Ending::Unfinished | Ending::Damaged(_) => return,
        };
        let Some(identity) = self.identity(run, pictures_at) else { return };
        let remembered = Remembered {
            identity,
            frames: found.frames,
            end_time: found.end_time,
            time_unit: found.time_unit.clone(),
            fault,
            measurements: found.measurements.iter().map(number).collect(),
            figures: with_figures.then(|| found.figures.clone()),
        };
        if let Ok(bytes) = postcard::to_stdvec(&remembered) {
            let path = self.path(&run.file);
            drop(files::create_folder(&self.folder).and_then(|()| files::replace(&path, bytes)));
        }
    }
}

fn number(measurement: &Measurement) -> Number {
    let laws = measurement.definition.laws;
    Number {
        name: measurement.name().to_owned(),
        value: measurement.estimate.value,
        standard_error: measurement.estimate.standard_error,
        theory: measurement.theory,
        law: measurement.law.and_then(|law| laws.iter().position(|other| *other == law)),
    }
}

fn measurement(model: &str, number: &Number) -> Option<Measurement> {
    let named = |definition: &&&catalog::Definition| definition.name == number.name;
    let definition = catalog::of_model(model).iter().find(named)?;
    let law = number.law.and_then(|law| definition.laws.get(law)).copied();
    let estimate = Estimate { value: number.value, standard_error: number.standard_error };
    Some(Measurement::new(definition, estimate).against_law(number.theory, law))
}
