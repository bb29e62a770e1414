//! Runs of manifests from which lock files are derived: fresh ones in a temporary folder, or the finished ones of a folder.

use crate::comparison::rerun::{listen, stop_if_interrupted};
use crate::executor::thread_count;
use crate::manifests::ManifestReader;
use crate::messages::exit::unread_recording;
use crate::messages::{Failure, name_of};
use crate::planning::planner::Planner;
use crate::program_name::ProgramName;
use crate::running::RunArguments;
use clap::Args;
use data_encoding::HEXLOWER;
use kinetoscope::interrupt::Interrupt;
use kinetoscope::run::in_memory::run_with_hash;
use kinetoscope::verify::fingerprint::{Fingerprint, fingerprint};
use kinetoscope_analysis::stored_rows;
use kinetoscope_console::text::shown_path;
use kinetoscope_console::{Exit, Explained as _};
use kinetoscope_files::regular_file::{MAX_MANIFEST_BYTES, read_text};
use kinetoscope_manifest::{Experiment, Run, written_checks, written_values};
use kinetoscope_recording::error::ReadError;
use kinetoscope_recording::reader::Recording;
use std::cell::OnceCell;
use std::collections::{BTreeMap, HashMap};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::time::Instant;
use tempfile::TempDir;

/// Executes manifests below a folder.
pub(crate) struct Reruns {
    folder: Folder,
    parallel: Parallel,
    /// For signals between the runs of two manifests, where no run listens.
    interrupt: Interrupt,
}

/// Where the recordings are.
enum Folder {
    /// Every manifest is run; the folder is removed at the end.
    Temporary(TempDir),
    /// A run whose recording is there already is not repeated, and every recording is kept.
    Recordings(PathBuf),
}

impl Folder {
    fn path(&self) -> &Path {
        match self {
            Self::Temporary(folder) => folder.path(),
            Self::Recordings(folder) => folder,
        }
    }
}

/// How many processors are used. No result depends on it.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct Parallel {
    /// Number of runs to execute in parallel [default: number of CPUs]
    #[arg(long, value_name = "N", value_parser = thread_count, help_heading = "Execution")]
    pub(crate) jobs: Option<NonZeroUsize>,
    /// Number of threads per run [default: number of CPUs divided by the number of parallel runs]
    #[arg(long, value_name = "N", value_parser = thread_count, help_heading = "Execution")]
    pub(crate) threads: Option<NonZeroUsize>,
}

/// One manifest that was executed.
pub(crate) struct RerunExperiment {
    pub(crate) experiment: Experiment,
    pub(crate) runs: Vec<RerunRun>,
    /// The keys of the manifest that affect the runs, with their values.
    pub(crate) values: BTreeMap<String, String>,
    /// Its checks, as TOML.
    pub(crate) checks: String,
    /// The folder of their recordings.
    pub(crate) folder: PathBuf,
    /// Time that the runs took, s.
    pub(crate) seconds: f64,
}

/// One run that was executed.
pub(crate) struct RerunRun {
    /// Its coordinates in the sweep, or the name of the experiment.
    pub(crate) name: String,
    pub(crate) run_key: String,
    pub(crate) recording: PathBuf,
    /// What remains of a run of `keep = "metrics"`, which has no recording.
    pub(crate) row: Option<RowOfRun>,
}

/// A run of which only the metrics are kept.
pub(crate) struct RowOfRun {
    run: Run,
    /// The hash of its messages in the table.
    messages: String,
    interrupt: Interrupt,
}

impl Reruns {
    /// Runs below a new temporary folder.
    pub(crate) fn new(parallel: Parallel) -> Result<Self, Failure> {
        let folder =
            tempfile::Builder::new().prefix("kinetoscope-").tempdir().map_err(|error| {
                let folder = std::env::temp_dir();
                let what = format!("cannot create a folder in {}: {error}", shown_path(&folder));
                Failure::new(Exit::Retryable, what).help("name another folder in TMPDIR")
            })?;
        let interrupt = listen()?;
        Ok(Self { folder: Folder::Temporary(folder), parallel, interrupt })
    }

    /// The finished runs of a folder of recordings. Only those that are missing are executed.
    pub(crate) fn recorded(folder: PathBuf, parallel: Parallel) -> Result<Self, Failure> {
        let interrupt = listen()?;
        Ok(Self { folder: Folder::Recordings(folder), parallel, interrupt })
    }

    /// The error of a command that received a signal.
    pub(crate) fn stop_if_interrupted(&self) -> Result<(), Failure> {
        stop_if_interrupted(&self.interrupt)
    }

    /// Executes the runs of a manifest.
    pub(crate) fn execute(&self, manifest: &Path) -> Result<RerunExperiment, Failure> {
        let Parallel { jobs, threads } = self.parallel;
        let run = RunArguments::of_manifest(manifest, self.folder.path(), jobs, threads);
        self.stop_if_interrupted()?;
        let start = Instant::now();
        let interrupt = OnceCell::from(self.interrupt.clone());
        let exit = run.execute_until(ProgramName::Kinetoscope, interrupt);
        let seconds = start.elapsed().as_secs_f64();
        if exit != Exit::Done {
            self.stop_if_interrupted()?;
            let what = format!("{} was not run to its end", shown_path(manifest));
            return Err(Failure::new(exit, what).help("see the error above"));
        }
        let reader = ManifestReader::new(run.output.folder()?, None);
        let experiment = reader.read(manifest, &[])?;
        // The runs exist, so that no start is built.
        let planner = Planner { is_outline: true, ..run.planner(&self.interrupt) };
        let plan = planner.plan(&experiment)?.plan;
        self.stop_if_interrupted()?;
        let mut rows = self.rows(&experiment, &plan.folder)?;
        let runs = plan.runs.iter().map(|planned| RerunRun {
            name: name_of(planned, &experiment),
            run_key: planned.run_key.as_str().to_owned(),
            recording: plan.folder.join(planned.file_name()),
            row: rows.remove(planned.run_key.as_str()).map(|messages| RowOfRun {
                run: planned.run.clone(),
                messages,
                interrupt: self.interrupt.clone(),
            }),
        });
        let runs = runs.collect();
        let text = text_of(manifest);
        let (values, checks) = (written_values(&text), written_checks(&text));
        let folder = plan.folder.clone();
        Ok(RerunExperiment { experiment, runs, values, checks, folder, seconds })
    }

    /// The hashes of messages in the table of an experiment that keeps only metrics, by run key.
    fn rows(
        &self,
        experiment: &Experiment,
        folder: &Path,
    ) -> Result<HashMap<String, String>, Failure> {
        if !experiment.keeps_only_metrics() {
            return Ok(HashMap::new());
        }
        let rows =
            stored_rows(folder).map_err(|error| Failure::of(Exit::Unreadable, error.message))?;
        let hashed = rows.into_iter().filter_map(|row| Some((row.run_key, row.messages?)));
        Ok(hashed.map(|(key, messages)| (key, HEXLOWER.encode(&messages))).collect())
    }

    /// Removes recordings from the temporary folder: those of all manifests together would need much space.
    pub(crate) fn remove(&self, experiment: RerunExperiment) {
        if let Folder::Temporary(_) = self.folder {
            for run in experiment.runs {
                // What remains is removed with the folder.
                let _ = std::fs::remove_file(run.recording);
            }
        }
    }
}

/// The keys of a manifest that affect its runs, with their values; none if it cannot be read.
pub(crate) fn values_of(manifest: &Path) -> BTreeMap<String, String> {
    written_values(&text_of(manifest))
}

fn text_of(manifest: &Path) -> String {
    read_text(manifest, MAX_MANIFEST_BYTES).unwrap_or_default()
}

impl RerunRun {
    /// Reads the recording; a run without one is executed again in memory.
    pub(crate) fn fingerprint(&self) -> Result<(Recording, Fingerprint), Failure> {
        let unreadable = |error: ReadError| unread_recording(&error);
        let recording = match &self.row {
            None => kinetoscope::run::recording::open(&self.recording).map_err(unreadable)?,
            Some(row) => {
                let rerun = run_with_hash(&row.run, &row.interrupt).map_err(|error| {
                    Failure::of(Exit::RunFailed, error.message().about(&self.name))
                })?;
                stop_if_interrupted(&row.interrupt)?;
                rerun.0
            }
        };
        let found = fingerprint(&recording).map_err(unreadable)?;
        Ok((recording, found))
    }

    /// The hash of all messages: that of the table, or of the recording.
    pub(crate) fn messages(&self) -> Result<String, Failure> {
        match &self.row {
            Some(row) => Ok(row.messages.clone()),
            None => Ok(self.fingerprint()?.1.messages),
        }
    }
}
