//! `kinetoscope.lock`: what the runs of manifests gave, in a text file that is reviewed like any other.

use crate::verify::fingerprint::FrameTags;
use data_encoding::BASE64_NOPAD;
use kinetoscope_console::text::one_line;
use kinetoscope_files::output_file;
use kinetoscope_files::regular_file::{MAX_LOCK_FILE_BYTES, read_text};
use kinetoscope_manifest::{Diagnostics, excess_of_toml, toml_error};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io;
use std::path::{Component, Path};
use thiserror::Error;

/// Version of the file's layout.
const VERSION: u32 = 3;
/// Time that a manifest of the quick tier may take, s.
pub const QUICK_S: u64 = 5;
const HEAD: &str =
    "# Written by `kinetoscope lock`, compared by `kinetoscope check --locked`. Do not edit.\n";
/// The last line begins with it, and states how many entries the file has: a file that was cut between two of them is valid TOML.
const END: &str = "# End of the file: ";

/// The content of a lock file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LockFile {
    version: u32,
    /// Version of the program that wrote the file.
    pub program_version: String,
    /// Version of the recordings' layout.
    pub schema_version: u32,
    /// The manifests, sorted by path.
    #[serde(default, rename = "experiment", skip_serializing_if = "Vec::is_empty")]
    pub experiments: Vec<LockedExperiment>,
}

/// What the runs of one manifest gave.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LockedExperiment {
    /// Path of the manifest below the folder of the lock file, with `/` between folders.
    pub manifest: String,
    /// The model.
    pub model: String,
    /// Its physics version.
    pub physics_version: u32,
    /// Bound of the time that the runs took, s: 1, 2, 5, 10, 20, 50, …
    pub at_most_s: u64,
    /// The runs in the manifest's order, each as run key (16 digits) and hash of its messages (32 digits).
    pub runs: Vec<String>,
    /// Number of frames of the first run.
    pub frames: u64,
    /// Tags of the frames of the first run, in base64; see [`FrameTags`].
    pub tags: String,
    /// Metrics of the first run.
    #[serde(default)]
    pub metrics: BTreeMap<String, f64>,
}

/// The reason why a lock file cannot be used.
#[derive(Debug, Error)]
pub enum LockError {
    /// The file cannot be read or written.
    #[error("{0}")]
    Io(#[from] io::Error),
    /// The file has a layout that this program does not know.
    #[error("it has version {0} of the layout; this program reads version {VERSION}")]
    OtherVersion(u64),
    /// The file is damaged.
    #[error("{0}")]
    Damaged(String),
    /// The file is not the TOML of a lock file: the line and what is wrong there.
    #[error("{0}")]
    Syntax(Diagnostics),
}

impl LockFile {
    /// A file without an entry.
    #[must_use]
    pub fn new(schema_version: u32) -> Self {
        let program_version = env!("CARGO_PKG_VERSION").to_owned();
        Self { version: VERSION, program_version, schema_version, experiments: Vec::new() }
    }

    /// Reads a lock file.
    ///
    /// # Errors
    /// A file that cannot be read, has another version, or is damaged.
    pub fn read(path: &Path) -> Result<Self, LockError> {
        #[derive(Deserialize)]
        struct Version {
            version: u64,
        }
        let text = read_text(path, MAX_LOCK_FILE_BYTES).map_err(|error| match error.kind() {
            io::ErrorKind::InvalidData => LockError::Damaged(error.to_string()),
            _ => LockError::Io(error),
        })?;
        if let Some(excess) = excess_of_toml(&text) {
            return Err(LockError::Damaged(excess));
        }
        let damaged = |error: toml::de::Error| {
            let title = "this is not a lock file, or it is damaged";
            LockError::Syntax(toml_error(&text, &path.to_string_lossy(), title, &error))
        };
        let Version { version } = toml::from_str(&text).map_err(damaged)?;
        if version != u64::from(VERSION) {
            return Err(LockError::OtherVersion(version));
        }
        let file: Self = toml::from_str(&text).map_err(damaged)?;
        if text.trim_end().lines().next_back() != Some(file.last_line().as_str()) {
            let what =
                format!("its last line is not \"{}\": it was cut or merged", file.last_line());
            return Err(LockError::Damaged(what));
        }
        for experiment in &file.experiments {
            experiment.reject_damage()?;
        }
        // As they are written: sorted, each once.
        let paths = file.experiments.iter().map(|experiment| &experiment.manifest);
        if !paths.is_sorted_by(|one, next| one < next) {
            let what = "its manifests are not sorted, or one is listed twice";
            return Err(LockError::Damaged(what.to_owned()));
        }
        Ok(file)
    }

    /// Writes the file as a whole, behind a symbolic link as well.
    ///
    /// # Errors
    /// A folder that cannot be written.
    pub fn write(&self, path: &Path) -> io::Result<()> {
        output_file::write(path, self.text()?.as_bytes())
    }

    /// The text of the file.
    ///
    /// # Errors
    /// A number that TOML cannot express.
    pub fn text(&self) -> io::Result<String> {
        let text =
            toml::to_string_pretty(self).map_err(|error| io::Error::other(error.to_string()))?;
        Ok(format!("{HEAD}{text}\n{}\n", self.last_line()))
    }

    fn last_line(&self) -> String {
        format!("{END}manifests = {}", self.experiments.len())
    }

    /// The entry of a manifest.
    #[must_use]
    pub fn experiment(&self, manifest: &str) -> Option<&LockedExperiment> {
        self.experiments.iter().find(|experiment| experiment.manifest == manifest)
    }

    /// Adds or replaces the entry of a manifest. A time that is at most one bound away from the old one is not changed.
    pub fn put(&mut self, mut experiment: LockedExperiment) {
        match self.experiments.binary_search_by(|other| other.manifest.cmp(&experiment.manifest)) {
            Ok(index) => {
                let old = self.experiments[index].at_most_s;
                if bound_s(old as f64 + 0.5) == experiment.at_most_s
                    || bound_s(experiment.at_most_s as f64 + 0.5) == old
                {
                    experiment.at_most_s = old;
                }
                self.experiments[index] = experiment;
            }
            Err(index) => self.experiments.insert(index, experiment),
        }
    }

    /// The entries of the quick tier: those that take at most [`QUICK_S`], and the quickest of each model.
    #[must_use]
    pub fn quick(&self) -> Vec<&LockedExperiment> {
        let quickest = |model: &str| {
            let of_model = self.experiments.iter().filter(|other| other.model == model);
            of_model.map(|other| other.at_most_s).min()
        };
        let is_quick = |experiment: &&LockedExperiment| {
            experiment.at_most_s <= QUICK_S
                || quickest(&experiment.model) == Some(experiment.at_most_s)
        };
        self.experiments.iter().filter(is_quick).collect()
    }
}

/// The smallest of 1, 2, 5, 10, 20, 50, … that is not below the time.
#[must_use]
pub fn bound_s(seconds: f64) -> u64 {
    let mut scale = 1;
    loop {
        for bound in [scale, 2 * scale, 5 * scale] {
            if seconds <= bound as f64 || bound > 1_000_000_000 {
                return bound;
            }
        }
        scale *= 10;
    }
}

impl LockedExperiment {
    fn reject_damage(&self) -> Result<(), LockError> {
        let is_hash = |run: &String| {
            let digits = run.split_once(' ').map(|(key, hash)| (key.len(), hash.len()));
            digits == Some((16, 32))
                && run.bytes().all(|byte| byte == b' ' || byte.is_ascii_hexdigit())
        };
        if self.manifest.is_empty() {
            return Err(LockError::Damaged("an entry has no name of its manifest".to_owned()));
        }
        let parts = Path::new(&self.manifest).components();
        if !parts.into_iter().all(|part| matches!(part, Component::Normal(_))) {
            return Err(LockError::Damaged(format!(
                "the manifest {} is not in the folder of the lock file",
                one_line(&self.manifest)
            )));
        }
        if self.runs.is_empty() || !self.runs.iter().all(is_hash) || self.frame_tags().is_none() {
            return Err(LockError::Damaged(format!(
                "the entry of {} is damaged",
                one_line(&self.manifest)
            )));
        }
        Ok(())
    }

    /// The text of the tags of a run.
    #[must_use]
    pub fn tags_text(tags: &FrameTags) -> String {
        BASE64_NOPAD.encode(&tags.tags)
    }

    /// The tags of the first run; `None` if their text is damaged.
    #[must_use]
    pub fn frame_tags(&self) -> Option<FrameTags> {
        let tags = BASE64_NOPAD.decode(self.tags.as_bytes()).ok()?;
        Some(FrameTags { frames: self.frames, tags })
    }

    /// The line of a run.
    #[must_use]
    pub fn run_line(run_key: &str, messages: &str) -> String {
        format!("{} {messages}", &run_key[..16.min(run_key.len())])
    }
}
