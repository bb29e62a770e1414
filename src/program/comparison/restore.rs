//! `restore`, and `verify --sample`: recordings of runs of which only the metrics were kept, executed again and compared with the hash of
//! their messages.

use crate::comparison::rerun::{listen, stop_if_interrupted};
use crate::messages::result_arguments::ResultArguments;
use crate::messages::{Failure, bad, exit, plural};
use clap::Args;
use kinetoscope::interrupt::Interrupt;
use kinetoscope::run::in_memory::run_with_hash;
use kinetoscope::run::{RunContext, RunSpec, execute};
use kinetoscope::verify::fingerprint::fingerprint;
use kinetoscope_analysis::{
    RunRow, StoreError, StoredRun, each_stored_key, each_stored_row, row_of_recording, stored_runs,
    stored_runs_of_keys,
};
use kinetoscope_console::text::shown_path;
use kinetoscope_console::{Exit, Explained as _};
use kinetoscope_manifest::{Run, RunKey, RunManifest, parse_run, run_key};
use kinetoscope_physics::kind_of;
use kinetoscope_recording::channels::SCHEMA_VERSION;
use kinetoscope_recording::reader::Recording;
use rayon::prelude::*;
use serde_json::json;
use std::collections::{HashMap, HashSet};
use std::fs;
use std::hash::{BuildHasher as _, RandomState};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

/// Write recordings of runs of which only the metrics were kept, and compare their messages with the hash in the table.
#[derive(Debug, Args)]
pub(crate) struct RestoreArguments {
    /// Folder of the experiment, or its runs.parquet
    #[arg(value_name = "EXPERIMENT")]
    path: PathBuf,
    /// Runs that meet all of these comparisons, such as 'temperature_k = 300, replicate = 17'
    #[arg(long = "where", value_name = "CONDITION")]
    condition: String,
    /// Folder for the recordings [default: `restored` in the folder of the experiment]
    #[arg(long, short, value_name = "DIR")]
    output: Option<PathBuf>,
    #[command(flatten)]
    result: ResultArguments,
}

impl RestoreArguments {
    /// Writes the recordings and prints the result.
    #[must_use]
    pub(crate) fn execute(&self) -> Exit {
        self.result.concluded(self.restore().unwrap_or_else(|failure| self.result.failed(&failure)))
    }

    fn restore(&self) -> Result<Exit, Failure> {
        let interrupt = &listen()?;
        let runs = read(&self.path, Some(&self.condition))?;
        let folder = self.output.clone().unwrap_or_else(|| folder_of(&self.path).join("restored"));
        let canonical = |path: &Path| fs::canonicalize(path).ok();
        if canonical(&folder).is_some_and(|it| Some(it) == canonical(folder_of(&self.path))) {
            let what = format!(
                "{} has the table, which an analysis there would replace",
                shown_path(&folder)
            );
            return Err(bad(what).help("name another folder with --output DIR"));
        }
        fs::create_dir_all(&folder).map_err(|error| {
            let what = format!("cannot write to {}: {error}", shown_path(&folder));
            Failure::new(exit::of_output(&error), what)
                .help("name another folder with --output DIR")
        })?;
        let restored: Vec<Result<(), Failure>> =
            runs.par_iter().map(|run| restored(run, &folder, interrupt)).collect();
        stop_if_interrupted(interrupt)?;
        let text = format!("in {}", shown_path(&folder));
        Ok(conclude(&restored, &text, &self.result))
    }
}

/// Executes a random sample of the runs of a table in memory, and compares their messages with the hashes in the table.
pub(crate) fn verify_sample(
    path: &Path,
    number: usize,
    result: &ResultArguments,
) -> Result<Exit, Failure> {
    let interrupt = &listen()?;
    let runs = sample(path, number)?;
    let chosen: HashSet<&str> = runs.iter().map(|run| run.run_key.as_str()).collect();
    let mut rows: HashMap<String, RunRow> = HashMap::new();
    each_stored_row(folder_of(path), |row| {
        if chosen.contains(row.run_key.as_str()) {
            rows.insert(row.run_key.clone(), row);
        }
    })
    .map_err(|error| Failure::of(Exit::Unreadable, error.message))?;
    let verified: Vec<Result<(), Failure>> = runs
        .par_iter()
        .map(|run| {
            let manifest = manifest_of(run)?;
            let rerun = Run { coordinates: Arc::from([]), replicate: manifest.replicate, manifest };
            let (recording, messages) = run_with_hash(&rerun, interrupt)
                .map_err(|error| Failure::of(Exit::RunFailed, error.message().about(&run.file)))?;
            stop_if_interrupted(interrupt)?;
            compared(run, &hexadecimal(&messages), None)?;
            let row = rows.get(run.run_key.as_str());
            row.map_or(Ok(()), |row| compared_metrics(run, row, recording, rerun.manifest))
        })
        .collect();
    stop_if_interrupted(interrupt)?;
    Ok(conclude(&verified, "executed again in memory", result))
}

/// Random runs of a table, of which only the keys are in the memory together.
fn sample(path: &Path, number: usize) -> Result<Vec<StoredRun>, Failure> {
    let unreadable = |error: StoreError| Failure::of(Exit::Unreadable, error.message);
    let mut keys = Vec::new();
    each_stored_key(path, |key| keys.extend(RunKey::from_hex(key))).map_err(unreadable)?;
    let random = RandomState::new();
    keys.sort_by_cached_key(|key| random.hash_one(key));
    keys.truncate(number);
    let keys = keys.iter().map(|key| key.as_str().to_owned()).collect();
    non_empty(path, stored_runs_of_keys(path, &keys).map_err(unreadable)?)
}

/// The runs of a table that have the hash of their messages and meet a condition.
fn read(path: &Path, condition: Option<&str>) -> Result<Vec<StoredRun>, Failure> {
    let runs = stored_runs(path, condition).map_err(|error| {
        Failure::of(
            if error.is_of_question { Exit::BadInput } else { Exit::Unreadable },
            error.message,
        )
    })?;
    non_empty(path, runs)
}

fn non_empty(path: &Path, runs: Vec<StoredRun>) -> Result<Vec<StoredRun>, Failure> {
    if runs.is_empty() {
        let what = format!("no run of {} meets the condition", shown_path(path));
        return Err(bad(what).help("list the runs with `kinetoscope table`"));
    }
    Ok(runs)
}

fn folder_of(path: &Path) -> &Path {
    if path.is_dir() { path } else { kinetoscope_files::folder::folder_of(path) }
}

/// The manifest of a run, if this program gives it the same key.
fn manifest_of(run: &StoredRun) -> Result<RunManifest, Failure> {
    let manifest = parse_run(&run.manifest).map_err(|errors| {
        Failure::new(Exit::Unreadable, format!("{}: its manifest is damaged\n{errors}", run.file))
    })?;
    let physics_version = kind_of(&manifest.model).physics_version;
    let key = run_key(&run.manifest, physics_version, SCHEMA_VERSION);
    if key.as_str() == run.run_key {
        return Ok(manifest);
    }
    let what = format!(
        "{}: its row is of physics version {}, this program has {physics_version}; or it is of another schema",
        run.file, run.physics_version
    );
    Err(Failure::new(Exit::Unreadable, what)
        .help("use the program that wrote the table, or execute the sweep again"))
}

/// Writes the recording of a run, unless it exists, and compares it with the row.
fn restored(run: &StoredRun, folder: &Path, interrupt: &Interrupt) -> Result<(), Failure> {
    let manifest = manifest_of(run)?;
    let Some(stem) = run.file.strip_suffix(".mcap").filter(|stem| !stem.contains(['/', '\\']))
    else {
        return Err(Failure::new(
            Exit::Unreadable,
            format!("{} is no name of a recording", run.file),
        ));
    };
    let path = folder.join(&run.file);
    if !path.exists() {
        let (canonical, run_key, stem) =
            (run.manifest.clone(), run.run_key.as_str(), stem.to_owned());
        let spec = RunSpec { manifest: &manifest, canonical, run_key, folder, stem };
        let context = RunContext {
            interrupt,
            checkpoint_every: Duration::from_secs(5),
            on_frame: &|_, _| {},
            on_written: &|| {},
            live: None,
            gnuplot: None,
        };
        execute(&spec, None, context).map_err(|error| {
            Failure::of(exit::of_run_error(&error), error.message().about(&run.file))
        })?;
        stop_if_interrupted(interrupt)?;
    }
    let recording = Recording::open(&path).and_then(|recording| fingerprint(&recording));
    let found = recording.map_err(|error| Failure::of(Exit::Unreadable, error.message()))?;
    compared(run, &found.messages, Some(&path))
}

/// Compares the hash of messages with that in the table; both files are kept.
fn compared(run: &StoredRun, found: &str, path: Option<&Path>) -> Result<(), Failure> {
    let Some(expected) = run.messages.as_deref() else {
        let what = format!("{}: its row has no hash of its messages", run.file);
        return Err(Failure::new(Exit::Unreadable, what)
            .help("compare its recording with `kinetoscope verify`"));
    };
    if found == expected {
        return Ok(());
    }
    let place = path.map_or_else(String::new, |path| format!(" in {}", shown_path(path)));
    let what = format!(
        "{}: the messages{place} have the hash {found}, and its row has {expected}",
        run.file
    );
    Err(Failure::new(Exit::Unreadable, what)
        .help("the program, the processor or the table has changed: compare with `kinetoscope doctor` and the table's `program_version`"))
}

/// Compares the metrics of a rerun with those of its row.
fn compared_metrics(
    run: &StoredRun,
    row: &RunRow,
    rerun: Recording,
    manifest: RunManifest,
) -> Result<(), Failure> {
    let found = row_of_recording(rerun, manifest)
        .map_err(|why| Failure::of(Exit::Unreadable, why.message.about(&run.file)))?;
    match found.differing_metric(row) {
        None => Ok(()),
        Some(name) => {
            let what = format!("{}: the rerun has another {name} than its row", run.file);
            Err(Failure::new(Exit::Unreadable, what)
                .help("the table was changed: execute the sweep again with --force"))
        }
    }
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Prints the errors and the number of equal runs, and returns the worst exit code.
fn conclude(results: &[Result<(), Failure>], place: &str, result: &ResultArguments) -> Exit {
    let failures = results.iter().filter_map(|result| result.as_ref().err());
    let exit = failures.clone().fold(Exit::Done, |exit, failure| exit.worst(failure.report()));
    let equal = results.iter().filter(|result| result.is_ok()).count();
    let runs = plural(results.len() as u64, "run");
    result.print(&format!("{equal} of {runs} {place}: equal to the table"), || {
        json!({
            "exit_code": exit.code(), "runs": results.len(), "equal": equal,
            "errors": failures.map(Failure::plain_text).collect::<Vec<_>>(),
        })
    });
    exit
}
