//! The files of a submission, below the folder of the recordings: one line of run keys per task, a copy of the manifest, and the
//! script of a task, which receives its index.

use crate::executor::cluster::task::{Task, TaskCommand, quoted};
use kinetoscope_files::atomic_file::replace;
use kinetoscope_files::folder::folder_of;
use kinetoscope_files::regular_file::{
    MAX_EXPERIMENT_RECORD_BYTES, MAX_MANIFEST_BYTES, read, read_text,
};
use sha2::{Digest as _, Sha256};
use std::fmt::Write as _;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Start of the name of every job of this program; the name of the submission follows.
pub(super) const JOB_NAME: &str = "kinetoscope-";

/// The resources that a task requests.
#[derive(Clone, Copy, Debug)]
pub struct Resources {
    /// Number of processors.
    pub processors: usize,
    /// Memory.
    pub memory_mib: u64,
    /// Time limit in minutes; `None` is the site's default.
    pub time_limit_min: Option<u64>,
}

/// A submission in its folder.
pub(super) struct Submission {
    /// Its name, a hash of the tasks, so that a submission is recognized if the engine's answer was lost.
    pub(super) name: String,
    /// Its absolute folder, because tasks run in another working folder.
    pub(super) own_folder: PathBuf,
    /// The script of a task.
    pub(super) script: PathBuf,
}

/// The folder of submissions below that of the recordings.
fn folder_of_all(folder: &Path) -> PathBuf {
    folder.join(".tasks")
}

/// The run keys of a submission, one line per task; empty if the submission belongs to another folder.
pub(super) fn key_lines(folder: &Path, name: &str) -> Vec<String> {
    let text =
        read_text(&folder_of_all(folder).join(name).join("keys"), MAX_EXPERIMENT_RECORD_BYTES);
    text.unwrap_or_default().lines().map(str::to_owned).collect()
}

/// Writes a submission. A task receives its index in the environment variable `index_variable`.
pub(super) fn write(
    folder: &Path,
    tasks: &[Task<'_>],
    command: &TaskCommand,
    index_variable: &str,
) -> io::Result<Submission> {
    let lines: String = tasks.iter().fold(String::new(), |mut text, task| {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{}", task.keys);
        text
    });
    let digest = Sha256::digest(lines.as_bytes());
    let name: String = digest.iter().take(8).map(|byte| format!("{byte:02x}")).collect();
    let own_folder = folder_of_all(folder).join(&name);
    fs::create_dir_all(&own_folder)?;
    let own_folder = fs::canonicalize(own_folder)?;
    // A later change of the manifest does not affect the submission. The experiment may be named after the manifest's file.
    let manifest = own_folder.join(command.manifest.file_name().unwrap_or_default());
    replace(&manifest, &read(&command.manifest, MAX_MANIFEST_BYTES)?)?;
    let keys_file = own_folder.join("keys");
    replace(&keys_file, lines.as_bytes())?;
    let starts_in = Some(folder_of(&command.manifest).to_owned());
    let command = TaskCommand { manifest, starts_in, ..command.clone() };
    let text = format!(
        "#!/bin/sh\nkeys=$(sed -n \"$(({index_variable} + 1))p\" {})\nexec {}\n",
        quoted(&keys_file.to_string_lossy()),
        command.line("\"$keys\"")
    );
    let script = own_folder.join("task.sh");
    replace(&script, text.as_bytes())?;
    Ok(Submission { name, own_folder, script })
}
