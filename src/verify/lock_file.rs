//! `kinetoscope.lock`: what the runs of manifests gave, in a text file that is reviewed like any other.

use crate::verify::fingerprint::FrameTags;
use data_encoding::{BASE64_NOPAD, HEXLOWER};
use kinetoscope_console::text::one_line;
use kinetoscope_files::output_file;
use kinetoscope_files::regular_file::{MAX_LOCK_FILE_BYTES, read_text};
use kinetoscope_manifest::{Diagnostics, excess_of_toml, toml_error};
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};
use std::io;
use std::ops::Range;
use std::path::{Component, Path};
use thiserror::Error;

/// Version of the file's layout.
const VERSION: u32 = 5;
/// Estimated time that a manifest of the quick tier may take, s.
pub const QUICK_S: u64 = 5;
/// Groups of runs that have a hash of their own in an entry.
const MOST_GROUPS: usize = 64;
/// Bytes of the hash of a group of runs.
const GROUP_BYTES: usize = 2;
/// The digits of tags, those of base64.
const TAG_DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
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
    #[serde(rename = "physics")]
    pub physics_version: u32,
    /// Bound of the time that the runs take by their number of steps or events, s: 1, 2, 5, 10, 20, 50, …
    pub at_most_s: u64,
    /// Number of runs.
    pub runs: usize,
    /// Hash of their run keys in the manifest's order, 16 digits.
    pub keys: String,
    /// Hash of their messages, 32 digits: that of the run, or of the hashes of all runs.
    pub messages: String,
    /// Two bytes per run, in base64: the start of the hash of its messages; of more than 64 runs, each group of neighbors has one.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub groups: String,
    /// Number of frames of the first run.
    pub frames: u64,
    /// Tags of the frames of the first run, one digit each; see [`FrameTags`].
    pub tags: String,
    /// Hash of the metrics of the first run, 16 digits; see [`metrics_hash`].
    pub metrics: String,
    /// Hash of the manifest's checks and of the readable texts of the entry, 8 digits; see [`checks_hash`].
    pub checks: String,
    /// The keys of the manifest that affect its runs, one line `key = value` each below the header of their table.
    #[serde(default)]
    pub values: String,
    /// The checked metrics, one line each: `name = value`, or `name = value ± standard error`.
    #[serde(default)]
    pub checked: String,
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

    /// Adds or replaces the entry of a manifest.
    pub fn put(&mut self, experiment: LockedExperiment) {
        match self.experiments.binary_search_by(|other| other.manifest.cmp(&experiment.manifest)) {
            Ok(index) => self.experiments[index] = experiment,
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
        let is_hash = |text: &String, digits: usize| {
            text.len() == digits && text.bytes().all(|byte| byte.is_ascii_hexdigit())
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
        let is_intact = self.runs > 0
            && is_hash(&self.keys, 16)
            && is_hash(&self.messages, 32)
            && is_hash(&self.metrics, 16)
            && is_hash(&self.checks, 8)
            && self.frame_tags().is_some()
            && self.group_hashes().is_some()
            && self.checked.lines().all(|line| locked_value(line).is_some());
        if !is_intact {
            return Err(LockError::Damaged(format!(
                "the entry of {} is damaged",
                one_line(&self.manifest)
            )));
        }
        Ok(())
    }

    /// The tags of the first run; `None` if their text is damaged.
    #[must_use]
    pub fn frame_tags(&self) -> Option<FrameTags> {
        let digit = |byte: u8| TAG_DIGITS.iter().position(|other| *other == byte);
        let tags = self.tags.bytes().map(|byte| u8::try_from(digit(byte)?).ok());
        FrameTags::new(self.frames, tags.collect::<Option<_>>()?)
    }

    /// The checked metrics by name.
    #[must_use]
    pub fn checked_values(&self) -> Vec<(String, LockedValue)> {
        self.checked.lines().filter_map(locked_value).collect()
    }

    /// The text of the tags of a run.
    #[must_use]
    pub fn tags_text(tags: &FrameTags) -> String {
        tags.tags.iter().map(|tag| char::from(TAG_DIGITS[usize::from(tag % 64)])).collect()
    }

    /// The hashes of the groups of runs; `None` if their text is damaged.
    fn group_hashes(&self) -> Option<Vec<u8>> {
        let hashes = BASE64_NOPAD.decode(self.groups.as_bytes()).ok()?;
        let groups = if self.runs == 1 { 0 } else { self.runs.div_ceil(self.runs_per_group()) };
        (hashes.len() == GROUP_BYTES * groups).then_some(hashes)
    }

    fn runs_per_group(&self) -> usize {
        self.runs.div_ceil(MOST_GROUPS)
    }

    /// The numbers of the runs, from 0, of the first group that differs from runs of these hashes; `None` if no group does.
    #[must_use]
    pub fn first_other_runs(&self, found: &[String]) -> Option<Range<usize>> {
        let locked = self.group_hashes()?;
        let size = self.runs_per_group();
        let mut pairs = found.chunks(size).zip(locked.chunks(GROUP_BYTES));
        let index = pairs.position(|(runs, locked)| group_hash(runs) != locked)?;
        Some(index * size..found.len().min((index + 1) * size))
    }

    /// Whether the messages of a run, which has a hash of its own, are those that are locked. Another run passes one time in 65,536.
    #[must_use]
    pub fn is_locked_run(&self, run: usize, messages: &str) -> bool {
        if self.runs == 1 {
            return self.messages == messages;
        }
        let Some(hashes) = self.group_hashes().filter(|_| self.runs_per_group() == 1) else {
            return false;
        };
        hashes.chunks(GROUP_BYTES).nth(run) == Some(&group_hash(&[messages.to_owned()])[..])
    }
}

/// What an entry keeps of the messages of all runs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RunHashes {
    /// See [`LockedExperiment::keys`].
    pub keys: String,
    /// See [`LockedExperiment::messages`].
    pub messages: String,
    /// See [`LockedExperiment::groups`].
    pub groups: String,
}

impl RunHashes {
    /// The hashes of runs with these keys and hashes of their messages.
    #[must_use]
    pub fn new(keys: &[String], messages: &[String]) -> Self {
        let groups: Vec<u8> = match messages {
            [_] => Vec::new(),
            _ => messages
                .chunks(messages.len().div_ceil(MOST_GROUPS).max(1))
                .flat_map(group_hash)
                .collect(),
        };
        let all = match messages {
            [one] => one.clone(),
            _ => HEXLOWER.encode(&hash_of(messages)[..16]),
        };
        let keys = HEXLOWER.encode(&hash_of(keys)[..8]);
        Self { keys, messages: all, groups: BASE64_NOPAD.encode(&groups) }
    }
}

/// The hash of metrics in the order of the analysis: names and bits of the values.
#[must_use]
pub fn metrics_hash<'a>(metrics: impl Iterator<Item = (&'a str, f64)>) -> String {
    let texts: Vec<String> =
        metrics.map(|(name, value)| format!("{name} {:016x}\n", value.to_bits())).collect();
    HEXLOWER.encode(&hash_of(&texts)[..8])
}

/// The hash of a manifest's checks, as [`kinetoscope_manifest::written_checks`] gives them, and of the readable texts of its entry, values
/// and checked metrics. A check that was removed or weakened changes no run, and neither does an edit of the lock file.
#[must_use]
pub fn checks_hash(checks: &str, values: &str, checked: &str) -> String {
    HEXLOWER.encode(&hash_of(&[checks, values, checked].map(|text| format!("{text}\0")))[..4])
}

fn hash_of(texts: &[String]) -> [u8; 32] {
    let mut hash = Sha256::new();
    texts.iter().for_each(|text| hash.update(text));
    hash.finalize().into()
}

fn group_hash(runs: &[String]) -> [u8; GROUP_BYTES] {
    let [first, second, ..] = hash_of(runs);
    [first, second]
}

/// A line of a checked metric, whose name may contain ` = `.
fn locked_value(line: &str) -> Option<(String, LockedValue)> {
    let (name, value) = line.rsplit_once(" = ")?;
    Some((name.to_owned(), LockedValue::read(value)?))
}

/// A metric as the file keeps it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LockedValue {
    /// The value.
    pub value: f64,
    /// Its standard error, if it is known.
    pub standard_error: Option<f64>,
}

impl LockedValue {
    /// Reads `value` or `value ± standard error`.
    #[must_use]
    pub fn read(text: &str) -> Option<Self> {
        let (value, error) = match text.split_once(" ± ") {
            Some((value, error)) => (value, Some(error.parse().ok()?)),
            None => (text, None),
        };
        Some(Self { value: value.parse().ok()?, standard_error: error })
    }

    /// The text of the file: ten digits of the value, two of the error.
    #[must_use]
    pub fn text(self) -> String {
        let digits = |value: f64, digits: usize| {
            let rounded = format!("{value:.digits$e}").parse::<f64>().unwrap_or(value);
            format!("{rounded:?}")
        };
        let value = digits(self.value, 9);
        self.standard_error
            .map_or_else(|| value.clone(), |error| format!("{value} ± {}", digits(error, 1)))
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may panic")]
mod tests {
    use super::*;

    fn entry(runs: usize) -> (LockedExperiment, Vec<String>) {
        let messages: Vec<String> = (0..runs).map(|run| format!("{run:032x}")).collect();
        let RunHashes { keys, messages: all, groups } = RunHashes::new(&messages, &messages);
        let entry = LockedExperiment {
            manifest: "x.toml".to_owned(),
            model: "gas".to_owned(),
            physics_version: 1,
            at_most_s: 1,
            runs,
            keys,
            messages: all,
            groups,
            frames: 0,
            tags: String::new(),
            metrics: "0".repeat(16),
            checks: "00000000".to_owned(),
            values: String::new(),
            checked: String::new(),
        };
        entry.reject_damage().unwrap();
        (entry, messages)
    }

    /// Control: no run differs.
    #[test]
    fn first_other_run_follows_from_the_hashes_of_groups() {
        for (runs, changed, expected) in
            [(2, 1, 1..2), (64, 33, 33..34), (65, 33, 32..34), (600, 599, 590..600)]
        {
            let (entry, mut messages) = entry(runs);
            assert_eq!(entry.first_other_runs(&messages), None);
            assert_eq!(entry.is_locked_run(changed, &messages[changed]), runs <= 64);
            messages[changed] = "f".repeat(32);
            assert_eq!(entry.first_other_runs(&messages), Some(expected));
            assert!(!entry.is_locked_run(changed, &messages[changed]));
            assert_ne!(RunHashes::new(&[], &messages).messages, entry.messages);
        }
        let (one, messages) = entry(1);
        assert!(one.is_locked_run(0, &messages[0]) && one.groups.is_empty());
    }

    #[test]
    fn locked_values_are_read_as_they_are_written() {
        for (value, error, text) in [
            (0.043_062_282_535_577_47, None, "0.04306228254"),
            (24.5, Some(2.2222), "24.5 ± 2.2"),
            (-1e-300, Some(1e-310), "-1e-300 ± 1e-310"),
            (0.0, None, "0.0"),
        ] {
            let locked = LockedValue { value, standard_error: error };
            assert_eq!(locked.text(), text);
            assert_eq!(LockedValue::read(text).unwrap().text(), text);
        }
        assert!(LockedValue::read("1 ± x").is_none() && LockedValue::read("x").is_none());
    }
}
