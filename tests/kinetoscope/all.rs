//! Guarantees of the program `kinetoscope`: each subcommand, its arguments, its exit codes and its JSON.
//!
//! - `arguments`: help, old flags, misspelled names, closed pipes
//! - `side_files`: large manifests and files next to recordings
//! - `subcommands`: every subcommand on a recorded experiment
//! - `hostile_files`: `info` on files that are not recordings
//! - `hostile_paths`: control characters in the names of folders
//! - `hostile_text`: control characters and commands of CI systems in text of manifests
//! - `full_output`: standard output and standard error on a full disk
//! - `narrow_terminals`: output for 60 columns, and inputs that are something else
//! - `oversized_files`: sizes that files and manifests claim, pipes, devices and links, and concurrent starts
//! - `shared_folders`: links, pipes, forged files and other processes in the folder of the recordings
//! - `baselines`: other seeds, changed keys and the same run against an earlier analysis
//! - `plots`: plots as SVG and PNG, and what cannot be plotted
//! - `pipelines`: several manifests, folders, and manifests that start from manifests
//! - `merged_recordings`: several runs in one recording
//! - `keyframes`: recordings that keep only keyframes, `fill` and `zoom`
//! - `restored_runs`: the files of `fill` and `zoom`, and what replaces what
//! - `lock`: golden values of runs, and the place of the first difference
//! - `view`: the server of recordings for Lichtblick, and who may read

#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod arguments;
mod baselines;
mod full_output;
mod hostile_files;
mod hostile_paths;
mod hostile_text;
mod keyframes;
mod lock;
mod merged_recordings;
mod narrow_terminals;
mod oversized_files;
mod pipelines;
mod plots;
mod restored_runs;
mod shared_folders;
mod side_files;
mod subcommands;
mod view;

use serde_json::Value;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

/// A short experiment of few particles.
const GAS: &str =
    "seed = 1\n[model.gas]\nparticles = 20\nduration_s = 0.001\n[record]\nframes = 4\n";

/// Result of a call.
struct Called {
    code: Option<i32>,
    out: String,
    err: String,
}

impl Called {
    fn json(&self) -> Value {
        serde_json::from_str(&self.out).unwrap_or_else(|error| panic!("{error}: {}", self.out))
    }
}

impl From<Output> for Called {
    fn from(output: Output) -> Self {
        let [out, err] =
            [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
        Self { code: output.status.code(), out, err }
    }
}

fn command() -> Command {
    Command::new(env!("CARGO_BIN_EXE_kinetoscope"))
}

/// Calls `kinetoscope`.
fn call<A: AsRef<OsStr>>(arguments: impl IntoIterator<Item = A>) -> Called {
    command().args(arguments).output().unwrap().into()
}

/// A folder for manifests and recordings.
struct Bench(TempDir);

impl Bench {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.path(name);
        fs::write(&path, text).unwrap();
        path
    }

    /// Calls a subcommand in this folder.
    fn call(&self, arguments: &[&str]) -> Called {
        command().current_dir(self.0.path()).args(arguments).output().unwrap().into()
    }

    /// Records the experiment [`GAS`], and returns the recording.
    fn recording(&self) -> PathBuf {
        self.write("gas.toml", GAS);
        let ran = self.call(&["run", "--quiet", "gas.toml"]);
        assert_eq!(ran.code, Some(0), "{}", ran.err);
        recordings(&self.path("recordings/gas")).remove(0)
    }
}

/// The recordings of a folder, sorted.
fn recordings(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut found: Vec<PathBuf> =
        entries.filter(|path| path.extension().is_some_and(|end| end == "mcap")).collect();
    found.sort();
    found
}
