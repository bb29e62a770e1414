//! A folder in which `kinetoscope` is called, and what it answers.

use serde_json::Value;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

/// A short experiment of few particles.
pub(crate) const GAS: &str =
    "seed = 1\n[model.gas]\nparticles = 20\nduration_s = 0.001\n[record]\nframes = 4\n";

/// Result of a call.
pub(crate) struct Called {
    pub(crate) code: Option<i32>,
    pub(crate) out: String,
    pub(crate) err: String,
}

impl Called {
    pub(crate) fn json(&self) -> Value {
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

pub(crate) fn command() -> Command {
    Command::new(env!("CARGO_BIN_EXE_kinetoscope"))
}

/// Calls `kinetoscope`.
pub(crate) fn call<A: AsRef<OsStr>>(arguments: impl IntoIterator<Item = A>) -> Called {
    command().args(arguments).output().unwrap().into()
}

/// A folder for manifests and recordings.
pub(crate) struct Bench(pub(crate) TempDir);

impl Bench {
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, text: &str) -> PathBuf {
        let path = self.path(name);
        fs::write(&path, text).unwrap();
        path
    }

    /// Calls a subcommand in this folder.
    pub(crate) fn call(&self, arguments: &[&str]) -> Called {
        command().current_dir(self.0.path()).args(arguments).output().unwrap().into()
    }

    /// Records the experiment [`GAS`], and returns the recording.
    pub(crate) fn recording(&self) -> PathBuf {
        self.write("gas.toml", GAS);
        let ran = self.call(&["run", "--quiet", "gas.toml"]);
        assert_eq!(ran.code, Some(0), "{}", ran.err);
        recordings(&self.path("recordings/gas")).remove(0)
    }
}

/// The recordings of a folder, sorted.
pub(crate) fn recordings(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut found: Vec<PathBuf> =
        entries.filter(|path| path.extension().is_some_and(|end| end == "mcap")).collect();
    found.sort();
    found
}
