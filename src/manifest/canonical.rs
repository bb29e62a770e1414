//! The canonical manifest of one run and its run key.

use crate::head::Head;
use crate::keys::{HasKeys as _, Writer};
use crate::model::ModelConfig;
use crate::record::{Keep, RecordConfig};
use sha2::{Digest, Sha256};
use std::fmt;

/// All inputs of a run: they determine its recording, and none is left to a default.
#[derive(Clone, Debug, PartialEq)]
pub struct RunManifest {
    /// Seed of all random streams, shared by all runs of an experiment.
    pub seed: u64,
    /// Number of the replicate, from 0.
    pub replicate: u32,
    /// The physics.
    pub model: ModelConfig,
    /// Which data are kept.
    pub record: RecordConfig,
}

impl RunManifest {
    /// Maximum number of particles that the size of a frame follows from; `None` if a series of single collisions is recorded,
    /// whose length is not known in advance.
    #[must_use]
    pub fn particles_of_frames(&self) -> Option<u64> {
        let is_series = |name: &String| name == "per_collision";
        let has_series = self.record.channels.iter().flatten().any(is_series);
        (!has_series).then(|| self.model.particles())
    }

    /// The same run with every frame stored, as `kinetoscope fill` restores it.
    #[must_use]
    pub fn with_all_frames(&self) -> Self {
        Self { record: self.record.with_all_frames(), ..self.clone() }
    }

    /// The TOML text of the run: every key, in a fixed order, numbers in their shortest exact form. Equal runs have
    /// equal texts, [`crate::parse_run`] gives the run back, and the text is itself a manifest of one run.
    #[must_use]
    pub fn canonical(&self) -> String {
        let mut writer = Writer::default();
        Head::of_run(self.seed, self.replicate).keys(&mut writer);
        writer.header(&format!("model.{}", self.model.name()));
        self.model.clone().keys(&mut writer);
        writer.header("record");
        let mut record = self.record.clone();
        // A run of which only the metrics are kept has the messages, and the key, of one with all frames.
        if record.keep == Keep::Metrics {
            record.keep = Keep::All;
        }
        record.keys_for(self.model.time_key(), &mut writer);
        writer.text
    }
}

/// The hash of all inputs of a recording: SHA-256 of the canonical manifest and of the versions that interpret it.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct RunKey(String);

impl RunKey {
    /// The whole key, 64 hexadecimal digits.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// The first eight characters, as in file names.
    #[must_use]
    pub fn short(&self) -> &str {
        &self.0[..8]
    }

    /// Reads a key from 64 hexadecimal digits in lower case.
    #[must_use]
    pub fn from_hex(text: &str) -> Option<Self> {
        let hex = |byte: u8| byte.is_ascii_digit() || (b'a'..=b'f').contains(&byte);
        (text.len() == 64 && text.bytes().all(hex)).then(|| Self(text.to_owned()))
    }
}

impl RunKey {
    /// The stem of a file that is to have this key, made of that of a file whose name ends in the start of another one.
    #[must_use]
    pub fn in_place_of(&self, other: &str, stem: &str) -> Option<String> {
        let (name, end) = stem.rsplit_once("__")?;
        let is_key = end.len() >= self.short().len() && other.starts_with(end);
        let own = self.0.get(..end.len()).filter(|_| is_key)?;
        Some(format!("{name}__{own}"))
    }
}

impl fmt::Display for RunKey {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.0)
    }
}

/// Returns the run key of a run: the hash of its canonical manifest, of the version of the model's physics and of the
/// version of the recording's schema.
#[must_use]
pub fn run_key(canonical: &str, physics_version: u32, schema_version: u32) -> RunKey {
    let mut hash = Sha256::new();
    // The versions have a fixed length and come first, so that no two inputs give the same bytes.
    hash.update(physics_version.to_le_bytes());
    hash.update(schema_version.to_le_bytes());
    hash.update(canonical.as_bytes());
    RunKey(hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect())
}
