//! What a submission leaves below the folder of the recordings: a line of run keys a task, the manifest as it was, and
//! the script of a task, which is told its index.

use crate::executor::cluster::task::{TaskCommand, keys, quoted};
use crate::plan::PlannedRun;
use kinetoscope_recording::atomic_file::replace;
use sha2::{Digest as _, Sha256};
use std::fmt::Write as _;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Start of the name of every job of this program; the name of the submission follows.
pub(super) const JOB_NAME: &str = "kinetoscope-";

/// What a task asks of the engine.
#[derive(Clone, Copy, Debug)]
pub struct Resources {
    /// Processors.
    pub processors: usize,
    /// Memory.
    pub memory_mib: u64,
    /// Minutes; `None` is the site's default.
    pub time_limit_min: Option<u64>,
}

/// A submission in its folder.
pub(super) struct Submission {
    /// Its name: the same tasks always have the same, so that a submission whose answer was lost is found again.
    pub(super) name: String,
    /// Its folder, absolute: tasks run in another working folder.
    pub(super) place: PathBuf,
    /// What a task does.
    pub(super) script: PathBuf,
}

/// The folder of submissions below that of the recordings.
fn folder_of_all(folder: &Path) -> PathBuf {
    folder.join(".tasks")
}

/// The run keys of a submission's tasks, a line each; none where it belongs to another folder.
pub(super) fn key_lines(folder: &Path, name: &str) -> Vec<String> {
    let text = fs::read_to_string(folder_of_all(folder).join(name).join("keys"));
    text.unwrap_or_default().lines().map(str::to_owned).collect()
}

/// Writes a submission. The engine tells a task its index in the environment variable `index_variable`.
pub(super) fn write(
    folder: &Path,
    tasks: &[Vec<&PlannedRun>],
    command: &TaskCommand,
    index_variable: &str,
) -> io::Result<Submission> {
    let lines: String = tasks.iter().fold(String::new(), |mut text, runs| {
        // Writing to a string does not fail.
        let _ = writeln!(text, "{}", keys(runs));
        text
    });
    let digest = Sha256::digest(lines.as_bytes());
    let name: String = digest.iter().take(8).map(|byte| format!("{byte:02x}")).collect();
    let place = folder_of_all(folder).join(&name);
    fs::create_dir_all(&place)?;
    let place = fs::canonicalize(place)?;
    // A manifest that is edited later does not change what was submitted. Its name may be that of the experiment.
    let manifest = place.join(command.manifest.file_name().unwrap_or_default());
    replace(&manifest, &fs::read(&command.manifest)?)?;
    let keys_file = place.join("keys");
    replace(&keys_file, lines.as_bytes())?;
    let starts_in = command.manifest.parent().map(Path::to_owned);
    let command = TaskCommand { manifest, starts_in, ..command.clone() };
    let text = format!(
        "#!/bin/sh\nkeys=$(sed -n \"$(({index_variable} + 1))p\" {})\nexec {}\n",
        quoted(&keys_file.display().to_string()),
        command.line("\"$keys\"")
    );
    let script = place.join("task.sh");
    replace(&script, text.as_bytes())?;
    Ok(Submission { name, place, script })
}
