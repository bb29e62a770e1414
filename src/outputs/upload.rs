//! Upload of recordings to object storage. A run is recorded in a local folder first, so that it can resume after a kill. The
//! finished recording is uploaded as a whole file if its name is free, and the local file is removed.

use crate::outputs::sidecars::layout_name;
use crate::plan::{Plan, PlannedRun, Status};
use kinetoscope_console::text::shown_path;
use kinetoscope_console::{Explained, Message};
use kinetoscope_files::atomic_file::remove_if_exists;
use kinetoscope_object_storage::address::Address;
use kinetoscope_object_storage::error::StoreError;
use kinetoscope_object_storage::{Put, Store, Upload};
use kinetoscope_recording::error::{ReadError, ReadFault};
use kinetoscope_recording::reader::Recording;
use kinetoscope_recording::recorder::Outcome;
use kinetoscope_recording::storage::Storage;
use rayon::ThreadPoolBuilder;
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};
use thiserror::Error;

/// Pause after a failed upload before the next attempt, so that an unreachable store does not delay the runs.
const PAUSE_AFTER_FAILURE: Duration = Duration::from_secs(30);

/// Number of recordings whose headers are read concurrently.
const CONCURRENT_READS: usize = 32;

/// Returns whether to stop.
pub type Stop<'a> = &'a (dyn Fn() -> bool + Sync);

/// Uploads the recordings of one experiment to one location on object storage.
#[derive(Debug)]
pub struct Uploader {
    store: Arc<Store>,
    keep_local: bool,
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    /// File names of the recordings that are known to be on the store.
    uploaded: BTreeSet<String>,
    /// Whether the side files are on the store.
    side_files: bool,
    /// Number of recordings uploaded by this process.
    put: usize,
    /// Messages about recordings whose names are taken by other bytes.
    conflicts: Vec<Message>,
    /// The last failed upload and its time.
    failure: Option<(StoreError, Instant)>,
}

/// Result of the uploads of an experiment.
#[derive(Debug)]
pub struct UploadReport {
    /// Number of uploaded recordings.
    pub put: usize,
    /// What failed.
    pub complaints: Vec<Message>,
    /// The last failed upload, if a recording is still to be uploaded.
    pub failure: Option<StoreError>,
    /// Whether a recording was rejected because its name is taken by other bytes.
    pub has_conflicts: bool,
}

impl UploadReport {
    /// Whether every finished recording is on object storage.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.failure.is_none() && !self.has_conflicts
    }
}

/// The reason why the existing recordings could not be found on object storage.
#[derive(Debug, Error)]
pub enum LookupError {
    /// The store does not answer, or has no such bucket.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The header of a recording could not be read.
    #[error(transparent)]
    Read(#[from] ReadError),
}

impl Explained for LookupError {
    fn help(&self) -> Option<String> {
        match self {
            Self::Store(error) => error.help(),
            Self::Read(error) => error.help(),
        }
    }
}

impl LookupError {
    /// Whether the same command may succeed later.
    #[must_use]
    pub fn is_retryable(&self) -> bool {
        match self {
            Self::Store(error) => error.is_retryable,
            Self::Read(_) => true,
        }
    }
}

impl Uploader {
    /// Opens the location without a request.
    ///
    /// # Errors
    /// Invalid settings, or a program that was built without object storage.
    pub fn open(address: &Address, keep_local: bool) -> Result<Self, StoreError> {
        let store = Arc::new(Store::open(address)?);
        Ok(Self { store, keep_local, state: Mutex::default() })
    }

    /// The location.
    #[must_use]
    pub fn address(&self) -> &Address {
        self.store.address()
    }

    /// Marks the runs as finished whose recordings are on the store, finished and with the whole key. With `force`, only checks that
    /// the store answers.
    ///
    /// # Errors
    /// A store that does not answer or has no such bucket, or a recording that cannot be read.
    pub fn find(&self, plan: &mut Plan, force: bool) -> Result<(), LookupError> {
        let objects = self.store.objects()?;
        if force {
            return Ok(());
        }
        let names: BTreeSet<String> = objects.into_iter().map(|object| object.name).collect();
        let mut ask = || -> Result<(), ReadError> {
            let named = plan.runs.par_iter_mut().filter(|run| names.contains(&run.file_name()));
            named.try_for_each(|run| {
                if let Some(outcome) = self.outcome(run)? {
                    run.status = Status::Done(outcome);
                    self.state().uploaded.insert(run.file_name());
                }
                Ok(())
            })
        };
        // The latency of the network dominates; therefore, the number of threads does not depend on the processors.
        let pool = ThreadPoolBuilder::new().num_threads(CONCURRENT_READS).build();
        let found = match pool {
            Ok(pool) => pool.install(ask),
            Err(_) => ask(),
        };
        Ok(found?)
    }

    /// The outcome of a run by its recording on the store; `None` if another object has its name.
    fn outcome(&self, run: &PlannedRun) -> Result<Option<Outcome>, ReadError> {
        let path = PathBuf::from(self.address().to_string()).join(run.file_name());
        let storage: Arc<dyn Storage> = self.store.clone();
        match Recording::open_in(storage, &path) {
            Ok(recording) => Ok(run.outcome_in(&recording)),
            Err(error) if matches!(error.fault, ReadFault::Io(_)) => Err(error),
            Err(_) => Ok(None),
        }
    }

    /// Uploads the recording of a run that has just ended, unless an upload failed shortly before.
    pub fn put_soon(&self, run: &PlannedRun, folder: &Path, stop: Stop<'_>) {
        let is_paused = matches!(&self.state().failure, Some((_, when)) if when.elapsed() < PAUSE_AFTER_FAILURE);
        if !is_paused {
            self.put(run, folder, stop);
        }
    }

    /// Uploads all recordings that are still in the local folder, including those of earlier commands, until an upload fails.
    /// If this process executes the whole experiment, uploads the side files first, once.
    pub fn put_all(&self, plan: &Plan, is_whole: bool, stop: Stop<'_>) {
        self.state().failure = None;
        if is_whole && !self.state().side_files {
            match self.put_side_files(&plan.folder, stop) {
                Ok(()) => self.state().side_files = true,
                Err(error) => self.fail(error),
            }
        }
        for run in &plan.runs {
            if stop() || self.state().failure.is_some() {
                return;
            }
            self.put(run, &plan.folder, stop);
        }
    }

    /// Uploads `experiment.toml` and `NAME.layout.json`, which replace those of an earlier plan.
    fn put_side_files(&self, folder: &Path, stop: Stop<'_>) -> Result<(), StoreError> {
        // A plan whose runs are all finished has no new layout.
        let names = ["experiment.toml".to_owned(), layout_name(folder)];
        let files = names.map(|name| (folder.join(&name), name));
        files
            .iter()
            .filter(|(file, _)| file.exists())
            .try_for_each(|(file, name)| self.store.replace(Upload { file, name, stop }))
    }

    fn put(&self, run: &PlannedRun, folder: &Path, stop: Stop<'_>) {
        let name = run.file_name();
        let file = folder.join(&name);
        if self.keep_local && self.state().uploaded.contains(&name)
            || run.recorded(folder).is_none()
        {
            return;
        }
        match self.store.put_once(Upload { file: &file, name: &name, stop }) {
            Ok(put @ (Put::Created | Put::Same)) => {
                self.put_host_file(run, folder, stop);
                if !self.keep_local
                    && let Err(error) = remove_if_exists(&file)
                {
                    let file = shown_path(&file);
                    let warning = format!(
                        "warning: {file} is uploaded, but the local file cannot be removed: {error}"
                    );
                    kinetoscope_console::complain(&warning, false);
                }
                let mut state = self.state();
                state.put += usize::from(put == Put::Created);
                state.uploaded.insert(name);
            }
            Ok(Put::Differs) => self.state().conflicts.push(Message::new(
                format!(
                    "{}/{name} already exists with other bytes than {}; both were kept",
                    self.address(),
                    shown_path(&file)
                ),
                "download it, compare the two with `kinetoscope compare`, and remove one of them",
            )),
            Err(error) => self.fail(error),
        }
    }

    /// Uploads host and timing of a run. A failure loses only this file.
    fn put_host_file(&self, run: &PlannedRun, folder: &Path, stop: Stop<'_>) {
        let name = format!("{}.host.json", run.stem());
        let file = folder.join(&name);
        let put = self.store.replace(Upload { file: &file, name: &name, stop });
        if put.is_ok() && !self.keep_local {
            // The next upload overwrites a timing file that could not be removed.
            let _ = remove_if_exists(&file);
        }
    }

    fn fail(&self, error: StoreError) {
        self.state().failure = Some((error, Instant::now()));
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Reports the uploads so far.
    #[must_use]
    pub fn report(&self, plan: &Plan) -> UploadReport {
        let state = self.state();
        let mut report = UploadReport {
            put: state.put,
            complaints: state.conflicts.clone(),
            failure: None,
            has_conflicts: !state.conflicts.is_empty(),
        };
        if let Some((error, _)) = &state.failure {
            let left = plan.runs.iter().filter(|run| {
                !state.uploaded.contains(&run.file_name()) && run.recorded(&plan.folder).is_some()
            });
            let left = match left.count() {
                1 => "1 recording is".to_owned(),
                left => format!("{left} recordings are"),
            };
            let message = error.message();
            let first = message.help.map_or_else(String::new, |help| format!("{help}. "));
            report.complaints.push(Message::new(
                message.what,
                format!(
                    "{first}{left} still in {}: run the same command again to upload without rerunning",
                    shown_path(&plan.folder)
                ),
            ));
            report.failure = Some(error.clone());
        }
        report
    }
}
