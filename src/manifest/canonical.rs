//! The canonical manifest of one run and its run key.

use crate::head::Head;
use crate::keys::{HasKeys as _, Writer};
use crate::model::ModelConfig;
use crate::record::{Keep, RecordConfig};
use sha2::{Digest, Sha256};
use std::fmt;
use std::sync::Arc;

/// All inputs of a run: they determine its recording, and none is left to a default.
#[derive(Clone, Debug, PartialEq)]
pub struct RunManifest {
    /// Seed of all random streams, shared by all runs of an experiment.
    pub seed: u64,
    /// Number of the replicate, from 0.
    pub replicate: u32,
    /// The physics, shared by the replicates of a point.
    pub model: Arc<ModelConfig>,
    /// Which data are kept.
    pub record: Arc<RecordConfig>,
}

impl RunManifest {
    /// Maximum number of particles that the size of a frame follows from; `None` if a series of single collisions is recorded,
    /// whose length is not known in advance.
    #[must_use]
    pub fn particles_of_frames(&self) -> Option<u64> {
        let is_series = |name: &String| ["per_collision", "events"].contains(&name.as_str());
        let has_series = self.record.channels.iter().flatten().any(is_series);
        (!has_series).then(|| self.model.particles())
    }

    /// The same run with every frame stored, as `kinetoscope fill` restores it.
    #[must_use]
    pub fn with_all_frames(&self) -> Self {
        Self { record: Arc::new(self.record.with_all_frames()), ..self.clone() }
    }

    /// The TOML text of the run: every key, in a fixed order, numbers in their shortest exact form. Equal runs have
    /// equal texts, [`crate::parse_run`] gives the run back, and the text is itself a manifest of one run.
    #[must_use]
    pub fn canonical(&self) -> String {
        self.canonical_with(&self.shared_text())
    }

    /// [`RunManifest::canonical`], with the [`RunManifest::shared_text`] of its point.
    #[must_use]
    pub fn canonical_with(&self, shared_text: &str) -> String {
        let mut writer = Writer::default();
        Head::of_run(self.seed, self.replicate).keys(&mut writer);
        writer.text + shared_text
    }

    /// The end of the canonical text, which the replicates of a point share.
    #[must_use]
    pub fn shared_text(&self) -> String {
        let mut writer = Writer::default();
        writer.header(&format!("model.{}", self.model.name()));
        (*self.model).clone().keys(&mut writer);
        writer.header("record");
        let mut record = (*self.record).clone();
        // A run of which only the metrics are kept has the messages, and the key, of one with all frames.
        if record.keep == Keep::Metrics {
            record.keep = Keep::All;
        }
        record.keys_for(self.model.time_key(), &mut writer);
        writer.text
    }
}

/// The hash of all inputs of a recording: SHA-256 of the canonical manifest and of the versions that interpret it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct RunKey([u8; 64]);

impl RunKey {
    /// The whole key, 64 hexadecimal digits.
    #[must_use]
    pub fn as_str(&self) -> &str {
        // All bytes are digits.
        std::str::from_utf8(&self.0).unwrap_or_default()
    }

    /// The first eight characters, as in file names.
    #[must_use]
    pub fn short(&self) -> &str {
        &self.as_str()[..8]
    }

    /// Reads a key from 64 hexadecimal digits in lower case.
    #[must_use]
    pub fn from_hex(text: &str) -> Option<Self> {
        let hex = |byte: u8| byte.is_ascii_digit() || (b'a'..=b'f').contains(&byte);
        let digits: [u8; 64] = text.as_bytes().try_into().ok()?;
        text.bytes().all(hex).then_some(Self(digits))
    }
}

impl RunKey {
    /// The stem of a file that is to have this key, made of that of a file whose name ends in the start of another one.
    #[must_use]
    pub fn in_place_of(&self, other: &str, stem: &str) -> Option<String> {
        let (name, end) = stem.rsplit_once("__")?;
        let is_key = end.len() >= self.short().len() && other.starts_with(end);
        let own = self.as_str().get(..end.len()).filter(|_| is_key)?;
        Some(format!("{name}__{own}"))
    }
}

impl fmt::Display for RunKey {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(self.as_str())
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
    let mut digits = [0; 64];
    for (pair, byte) in digits.chunks_exact_mut(2).zip(hash.finalize()) {
        for (digit, half) in pair.iter_mut().zip([byte >> 4, byte & 15]) {
            *digit = if half < 10 { b'0' + half } else { b'a' + half - 10 };
        }
    }
    RunKey(digits)
}
