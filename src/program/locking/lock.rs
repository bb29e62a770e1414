//! `lock`: runs manifests and writes what they gave into a lock file.

use crate::locking::locked_runs::{Parallel, RerunExperiment, Reruns};
use crate::manifests::{canonical, expand};
use crate::messages::exit;
use crate::messages::exit::{ON_FAILED_DISK, unread};
use crate::messages::has_colors;
use crate::messages::result_arguments::ResultArguments;
use crate::messages::{Failure, bad, complain, plural};
use clap::Args;
use kinetoscope::run::recording;
use kinetoscope::run::resources::nominal_seconds;
use kinetoscope::verify::fingerprint::fingerprint;
use kinetoscope::verify::lock_file::{
    LockError, LockFile, LockedExperiment, LockedValue, RunHashes, bound_s, checks_hash,
    metrics_hash,
};
use kinetoscope_analysis::{CheckedExperiment, CheckedValue, checked_experiment};
use kinetoscope_console::Exit;
use kinetoscope_console::text::{one_line, shown_path};
use kinetoscope_files::folder::folder_of;
use kinetoscope_files::output_file::{self, FolderLock};
use kinetoscope_files::regular_file::is_of_file;
use kinetoscope_manifest::RunManifest;
use kinetoscope_physics::kind_of;
use kinetoscope_recording::channels::SCHEMA_VERSION;
use kinetoscope_recording::reader::{Recording, StoredFrames};
use serde_json::json;
use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::thread;
use std::time::{Duration, Instant};

/// The usual name of a lock file.
pub(crate) const USUAL: &str = "kinetoscope.lock";
/// Longest wait for other processes that write a lock file in the same folder; each takes a fraction of a second.
const LONGEST_WAIT: Duration = Duration::from_secs(60);
/// Time between two attempts to exclude them.
const BETWEEN_TRIALS: Duration = Duration::from_millis(20);

/// Run manifests, and write the hash of all messages of each run into a lock file, with which `check --locked` compares.
#[derive(Debug, Args)]
pub(crate) struct LockArguments {
    /// Manifests (TOML files), or folders of manifests
    #[arg(required = true, value_name = "MANIFEST")]
    manifests: Vec<PathBuf>,
    /// The lock file. Entries of other manifests are kept while these exist
    #[arg(long, value_name = "FILE", default_value = USUAL)]
    lock_file: PathBuf,
    #[command(flatten)]
    parallel: Parallel,
    #[command(flatten)]
    result: ResultArguments,
}

impl LockArguments {
    /// Runs the manifests and writes the file.
    #[must_use]
    pub(crate) fn execute(&self) -> Exit {
        let locked = self.lock();
        self.result.concluded(locked.unwrap_or_else(|failure| self.result.failed(&failure)))
    }

    fn lock(&self) -> Result<Exit, Failure> {
        output_file::check(&self.lock_file).map_err(|error| self.unwritten(&error))?;
        let manifests = expand(&self.manifests)?;
        let paths = manifests.iter().map(|manifest| relative_to(&self.lock_file, manifest));
        let paths = paths.collect::<Result<Vec<String>, Failure>>()?;
        self.existing(&paths)?;
        let reruns = Reruns::new(self.parallel)?;
        let mut entries = Vec::new();
        for (manifest, path) in manifests.iter().zip(&paths) {
            let rerun = reruns.execute(manifest)?;
            let entry = entry(path.clone(), &rerun)?;
            let runs = plural(entry.runs as u64, "run");
            let (shown, seconds) = (shown_path(manifest), rerun.seconds);
            self.result.say(&format!("{shown}: {runs}, {seconds:.1} s"));
            reruns.remove(rerun);
            entries.push(entry);
        }
        // Other processes may have added entries during the runs.
        let _lock = self.wait_for_others(&reruns)?;
        let mut file = self.existing(&paths)?;
        file.program_version = env!("CARGO_PKG_VERSION").to_owned();
        entries.into_iter().for_each(|entry| file.put(entry));
        file.experiments.retain(|entry| {
            let exists = self.lock_file.with_file_name(&entry.manifest).exists();
            if !exists {
                let manifest = one_line(&entry.manifest);
                self.result.say(&format!("{manifest} no longer exists: its entry is removed"));
            }
            exists
        });
        file.write(&self.lock_file).map_err(|error| self.unwritten(&error))?;
        let count = plural(file.experiments.len() as u64, "manifest");
        let text = format!("{}: {count}", shown_path(&self.lock_file));
        self.result.print(
            &text,
            || json!({ "exit_code": 0, "lock_file": self.lock_file, "manifests": file.experiments.len() }),
        );
        Ok(Exit::Done)
    }

    /// The file to which entries of these manifests are added; a new one if there is none. One of another schema is replaced, and
    /// must not have entries of other manifests, which would be lost.
    fn existing(&self, named: &[String]) -> Result<LockFile, Failure> {
        let file = match LockFile::read(&self.lock_file) {
            Ok(file) if file.schema_version == SCHEMA_VERSION => return Ok(file),
            Ok(file) => file,
            Err(LockError::Io(error)) if error.kind() == io::ErrorKind::NotFound => {
                return Ok(LockFile::new(SCHEMA_VERSION));
            }
            Err(error) => return Err(unreadable(&self.lock_file, &error)),
        };
        match file.experiments.iter().find(|entry| !named.contains(&entry.manifest)) {
            None => Ok(LockFile::new(SCHEMA_VERSION)),
            Some(lost) => {
                let what = format!(
                    "{} is of another recording schema; the entry of {} would be lost",
                    shown_path(&self.lock_file),
                    one_line(&lost.manifest)
                );
                Err(bad(what).help("name all manifests of the file, or remove it first"))
            }
        }
    }

    /// Excludes other processes that change a lock file of this folder, until the value is dropped. A user who can read the folder can
    /// keep it locked, so the results of the runs are written after [`LONGEST_WAIT`] without the lock.
    fn wait_for_others(&self, reruns: &Reruns) -> Result<Option<FolderLock>, Failure> {
        let start = Instant::now();
        while start.elapsed() < LONGEST_WAIT {
            if let Some(lock) = FolderLock::of(&self.lock_file) {
                return Ok(Some(lock));
            }
            reruns.stop_if_interrupted()?;
            thread::sleep(BETWEEN_TRIALS);
        }
        let shown = shown_path(&self.lock_file);
        complain(&format!(
            "note: another process keeps the folder of {shown} locked; the file is written nevertheless"
        ));
        Ok(None)
    }

    /// The error of a lock file that cannot be written.
    fn unwritten(&self, error: &io::Error) -> Failure {
        let what = format!("cannot write {}: {error}", shown_path(&self.lock_file));
        Failure::new(exit::of_output(error), what).help("name another file with --lock-file")
    }
}

/// What to do with a damaged lock file.
const RESTORE: &str = "restore the file, or remove it and write it again with `kinetoscope lock`";

/// The error of a lock file that cannot be used.
pub(crate) fn unreadable(path: &Path, error: &LockError) -> Failure {
    let what = format!("cannot use the lock file {}: {error}", shown_path(path));
    match error {
        LockError::Io(error) if !is_of_file(error) => {
            Failure::new(Exit::Retryable, what).help(ON_FAILED_DISK)
        }
        LockError::Io(_) => Failure::new(Exit::Unreadable, what).help(
            "write it with `kinetoscope lock MANIFEST…`, or name another file with --lock-file",
        ),
        LockError::OtherVersion(_) => Failure::new(Exit::Differs, what)
            .help("use the program that wrote it, or remove it and write it again with `kinetoscope lock`"),
        LockError::Damaged(_) => Failure::new(Exit::Unreadable, what).help(RESTORE),
        LockError::Syntax(errors) => {
            Failure::rendered(Exit::Unreadable, errors.render(has_colors())).help(RESTORE)
        }
    }
}

/// The entry of a manifest.
pub(crate) fn entry(
    manifest: String,
    rerun: &RerunExperiment,
) -> Result<LockedExperiment, Failure> {
    let (mut messages, mut first, mut seconds) = (Vec::new(), None, 0.0);
    for (index, run) in rerun.runs.iter().enumerate() {
        let manifest = &rerun.experiment.runs[index].manifest;
        // Only the first of the runs without recordings is executed again; the others have about its steps.
        if let (Some(_), Some(_)) = (&run.row, &first) {
            seconds += seconds / index as f64;
            messages.push(run.messages()?);
            continue;
        }
        let (recording, found) = run.fingerprint()?;
        seconds += nominal_seconds(manifest, found.steps_or_events, found.frames.len() as u64);
        messages.push(found.messages.clone());
        first.get_or_insert_with(|| (found.tags(), recording));
    }
    let (tags, recording) = first.ok_or_else(|| bad(format!("{manifest} has no run")))?;
    let keys: Vec<String> = rerun.runs.iter().map(|run| run.run_key.clone()).collect();
    let hashes = RunHashes::new(&keys, &messages);
    let values = text_of(&rerun.values);
    let checked: String = checked(rerun)?.values.iter().map(line_of).collect();
    Ok(LockedExperiment {
        manifest,
        model: rerun.experiment.model().to_owned(),
        physics_version: physics_version(&rerun.experiment.runs[0].manifest),
        at_most_s: bound_s(seconds),
        runs: rerun.runs.len(),
        keys: hashes.keys,
        messages: hashes.messages,
        groups: hashes.groups,
        frames: tags.frames,
        tags: LockedExperiment::tags_text(&tags),
        metrics: metrics_of(&recording)?,
        checks: checks_hash(&rerun.checks, &values, &checked),
        values,
        checked,
    })
}

/// The hash of all metrics of a recording; of none for one that holds only keyframes, because they need all frames.
pub(crate) fn metrics_of(recording: &Recording) -> Result<String, Failure> {
    if let StoredFrames::Keyframes(_) = recording.provenance().stored {
        return Ok(metrics_hash(std::iter::empty()));
    }
    let unreadable = |error| Failure::new(Exit::Unreadable, error);
    let analysis = kinetoscope_analysis::analyze(recording).map_err(unreadable)?;
    let with_value = analysis.measurements.iter().filter(|found| found.reason.is_none());
    let values = with_value.map(|found| (found.name(), found.estimate.value));
    Ok(metrics_hash(values))
}

/// The checked metrics of an experiment.
pub(crate) fn checked(rerun: &RerunExperiment) -> Result<CheckedExperiment, Failure> {
    checked_experiment(&rerun.folder).map_err(|error| Failure::new(Exit::Unreadable, error))
}

/// Keys and values below the header of their table, as [`kinetoscope_manifest::manifest_values`] reads them.
fn text_of(values: &BTreeMap<String, String>) -> String {
    let split = |key: &str| {
        let (table, name) = key.rsplit_once('.').unwrap_or(("", key));
        (table.to_owned(), name.to_owned())
    };
    let mut sorted: Vec<_> = values.iter().map(|(key, value)| (split(key), value)).collect();
    sorted.sort();
    let (mut text, mut last) = (String::new(), String::new());
    for ((table, name), value) in sorted {
        if table != last {
            text += &format!("[{}]\n", one_line(&table));
            last = table;
        }
        text += &format!("{} = {value}\n", one_line(&name));
    }
    text
}

fn line_of(found: &CheckedValue) -> String {
    let CheckedValue { value, standard_error, .. } = *found;
    format!("{} = {}\n", one_line(&found.name), LockedValue { value, standard_error }.text())
}

/// The version of the physics of a run.
pub(crate) fn physics_version(run: &RunManifest) -> u32 {
    kind_of(&run.model).physics_version
}

/// The recording at a path, if its messages are those of a locked run.
pub(crate) fn locked_recording(
    path: &Path,
    entry: &LockedExperiment,
    run: usize,
) -> Option<Recording> {
    let recording = recording::open(path).ok()?;
    let messages = fingerprint(&recording).ok()?.messages;
    entry.is_locked_run(run, &messages).then_some(recording)
}

/// The path of a manifest below the folder of the lock file, the same on every system. Manifests elsewhere have no entry: a lock file
/// of a stranger would read any file of this machine.
pub(crate) fn relative_to(lock_file: &Path, manifest: &Path) -> Result<String, Failure> {
    let found = fs::canonicalize(manifest).map_err(|error| {
        let what = format!("cannot read the manifest {}: {error}", shown_path(manifest));
        unread(&error, what, "check the path")
    })?;
    let below = found.strip_prefix(canonical(folder_of(lock_file))).map_err(|_| {
        let (manifest, lock_file) = (shown_path(manifest), shown_path(lock_file));
        let what = format!("the manifest {manifest} is not in the folder of {lock_file}");
        bad(what).help("name a lock file in a folder above it with --lock-file")
    })?;
    let parts = below.components().map(|part| part.as_os_str().to_string_lossy());
    let path = parts.collect::<Vec<_>>().join("/");
    if path.contains(char::REPLACEMENT_CHARACTER) {
        return Err(bad(format!("{} is not UTF-8", shown_path(manifest))).help("rename it"));
    }
    Ok(path)
}

/// The manifest of an entry. One that is a link out of the folder of the lock file is not read.
pub(crate) fn manifest_of(lock_file: &Path, entry: &LockedExperiment) -> Result<PathBuf, Failure> {
    // A name next to that of the lock file: messages show it as the user wrote the other one.
    let manifest = lock_file.with_file_name(&entry.manifest);
    match fs::canonicalize(&manifest) {
        Ok(found) if !found.starts_with(canonical(folder_of(lock_file))) => {
            let (manifest, lock_file) = (shown_path(&manifest), shown_path(lock_file));
            let what =
                format!("the manifest {manifest} is a link out of the folder of {lock_file}");
            Err(Failure::new(Exit::Unreadable, what).help("replace the link by the manifest"))
        }
        // What does not exist is reported where it is read.
        Ok(_) | Err(_) => Ok(manifest),
    }
}
