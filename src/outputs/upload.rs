//! Recordings that go to object storage. A run is recorded here first, so that a kill costs what it always costs; its recording is
//! then put there as a whole file, only where its name is free, and removed here.

use crate::cli::exit::Exit;
use crate::plan::{Plan, PlannedRun, Status};
use kinetoscope_object_storage::address::Address;
use kinetoscope_object_storage::error::StoreError;
use kinetoscope_object_storage::{Parcel, Put, Store};
use kinetoscope_recording::error::{ReadError, ReadFault};
use kinetoscope_recording::reader::Recording;
use kinetoscope_recording::recorder::Outcome;
use kinetoscope_recording::storage::Storage;
use rayon::ThreadPoolBuilder;
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// After a put that failed, runs go on for so long before the next is tried: a store that is away holds up no run.
const REST: Duration = Duration::from_secs(30);

/// Recordings that are asked for at the same time.
const ASKED_AT_ONCE: usize = 32;

/// Whether to stop.
pub type Stop<'a> = &'a (dyn Fn() -> bool + Sync);

/// The place of one experiment's recordings on object storage.
#[derive(Debug)]
pub struct Depot {
    store: Arc<Store>,
    keep_local: bool,
    state: Mutex<State>,
}

#[derive(Debug, Default)]
struct State {
    /// Recordings known to be there, by their file names.
    there: BTreeSet<String>,
    /// Whether what stands beside them is.
    side_files: bool,
    /// How many recordings came from here.
    put: usize,
    /// Recordings whose names are taken by other bytes.
    refused: Vec<String>,
    /// The last put that failed, and when.
    failure: Option<(StoreError, Instant)>,
}

/// What came of the puts.
#[derive(Debug)]
pub struct Delivery {
    /// How many recordings were put.
    pub put: usize,
    /// What went wrong, with the next step.
    pub complaints: Vec<String>,
    /// The exit code of it.
    pub exit: Exit,
}

impl Depot {
    /// Opens the place; nothing is asked of it yet.
    ///
    /// # Errors
    /// Settings that make no sense, or a program that was built without object storage.
    pub fn open(address: &Address, keep_local: bool) -> Result<Self, StoreError> {
        let store = Arc::new(Store::open(address)?);
        Ok(Self { store, keep_local, state: Mutex::default() })
    }

    /// Where it is.
    #[must_use]
    pub fn address(&self) -> &Address {
        self.store.address()
    }

    /// Marks the runs as done whose recordings are there: finished, and with the whole key. With `force` it only makes sure that the
    /// store answers.
    ///
    /// # Errors
    /// A store that does not answer, or has no such bucket, with the exit code.
    pub fn find(&self, plan: &mut Plan, force: bool) -> Result<(), (Exit, String)> {
        let objects = self.store.objects().map_err(|error| (exit_of(&error), error.to_string()))?;
        if force {
            return Ok(());
        }
        let names: BTreeSet<String> = objects.into_iter().map(|object| object.name).collect();
        let mut ask = || -> Result<(), ReadError> {
            let named = plan.runs.par_iter_mut().filter(|run| names.contains(&run.file_name()));
            named.try_for_each(|run| {
                if let Some(outcome) = self.outcome(run)? {
                    run.status = Status::Done(outcome);
                    self.state().there.insert(run.file_name());
                }
                Ok(())
            })
        };
        // An answer takes the way there and back, whatever the number of processors.
        let pool = ThreadPoolBuilder::new().num_threads(ASKED_AT_ONCE).build();
        let found = match pool {
            Ok(pool) => pool.install(ask),
            Err(_) => ask(),
        };
        found.map_err(|error| (Exit::Retryable, error.to_string()))
    }

    /// How a run ended by its recording there; `None` where something else has its name.
    fn outcome(&self, run: &PlannedRun) -> Result<Option<Outcome>, ReadError> {
        let path = PathBuf::from(self.address().to_string()).join(run.file_name());
        let storage: Arc<dyn Storage> = self.store.clone();
        match Recording::open_in(storage, &path) {
            Ok(recording) => Ok(run.outcome_in(&recording)),
            Err(error) if matches!(error.fault, ReadFault::Io(_)) => Err(error),
            Err(_) => Ok(None),
        }
    }

    /// Puts the recording of a run that has just ended, unless the store has failed a moment ago.
    pub fn put_soon(&self, run: &PlannedRun, folder: &Path, stop: Stop<'_>) {
        let rests = matches!(&self.state().failure, Some((_, when)) if when.elapsed() < REST);
        if !rests {
            self.put(run, folder, stop);
        }
    }

    /// Puts all recordings that are still here, of earlier commands too, until the store fails; before them, once,
    /// what stands beside them, where this process answers for the whole experiment.
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

    /// Puts `experiment.toml` and `layout.json`, in place of those of an earlier plan.
    fn put_side_files(&self, folder: &Path, stop: Stop<'_>) -> Result<(), StoreError> {
        // A plan without a run to do has no new layout.
        let files = ["experiment.toml", "layout.json"].map(|name| (name, folder.join(name)));
        files
            .iter()
            .filter(|(_, file)| file.exists())
            .try_for_each(|(name, file)| self.store.replace(Parcel { file, name, stop }))
    }

    fn put(&self, run: &PlannedRun, folder: &Path, stop: Stop<'_>) {
        let name = run.file_name();
        let file = folder.join(&name);
        if self.keep_local && self.state().there.contains(&name) || run.recorded(folder).is_none() {
            return;
        }
        match self.store.put_once(Parcel { file: &file, name: &name, stop }) {
            Ok(put @ (Put::Created | Put::Same)) => {
                self.put_host_file(run, folder, stop);
                if !self.keep_local && let Err(error) = remove(&file) {
                    eprintln!("warning: {} is there and can't be removed here: {error}", file.display());
                }
                let mut state = self.state();
                state.put += usize::from(put == Put::Created);
                state.there.insert(name);
            }
            Ok(Put::Differs) => self.state().refused.push(format!(
                "{}/{name} is there already and holds other bytes than {}. Both were kept: fetch it, compare the two with \
                 `kinetoscope compare`, and remove the one that is not wanted",
                self.address(),
                file.display()
            )),
            Err(error) => self.fail(error),
        }
    }

    /// Host and timing of a run. Where they can't be put nothing is lost but themselves.
    fn put_host_file(&self, run: &PlannedRun, folder: &Path, stop: Stop<'_>) {
        let name = format!("{}.host.json", run.stem);
        let file = folder.join(&name);
        let put = self.store.replace(Parcel { file: &file, name: &name, stop });
        if put.is_ok() && !self.keep_local {
            // A timing file that stays is overwritten by the next.
            let _ = remove(&file);
        }
    }

    fn fail(&self, error: StoreError) {
        self.state().failure = Some((error, Instant::now()));
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// What came of it all.
    #[must_use]
    pub fn delivery(&self, plan: &Plan) -> Delivery {
        let state = self.state();
        let mut delivery =
            Delivery { put: state.put, complaints: state.refused.clone(), exit: Exit::Done };
        if let Some((error, _)) = &state.failure {
            let left = plan.runs.iter().filter(|run| {
                !state.there.contains(&run.file_name()) && run.recorded(&plan.folder).is_some()
            });
            let left = match left.count() {
                1 => "1 recording waits".to_owned(),
                left => format!("{left} recordings wait"),
            };
            delivery.complaints.push(format!(
                "{error}\n{left} in {}: the same command puts it all there without running again",
                plan.folder.display()
            ));
            delivery.exit = exit_of(error);
        }
        if !state.refused.is_empty() {
            delivery.exit = Exit::RunFailed;
        }
        delivery
    }
}

fn exit_of(error: &StoreError) -> Exit {
    if error.is_retryable { Exit::Retryable } else { Exit::BadManifest }
}

/// Removes a file that another process may have removed.
fn remove(file: &Path) -> io::Result<()> {
    match fs::remove_file(file) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        Ok(()) | Err(_) => Ok(()),
    }
}
