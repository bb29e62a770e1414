//! A record that a file was verified, so that others can check it without a re-run.

use kinetoscope_manifest::run_key;
use kinetoscope_recording::atomic_file;
use kinetoscope_recording::reader::Recording;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// Version of the attestation's own layout.
const ATTESTATION_VERSION: u32 = 1;
/// Bytes that are hashed at once.
const HASHED_AT_ONCE: usize = 1 << 16;

/// How equal file and re-run were.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// In every byte.
    Bytes,
    /// In every message.
    Messages,
}

/// What `STEM.verified.json` says.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Attestation {
    /// Version of this record's layout.
    pub attestation_version: u32,
    /// SHA-256 of the file, 64 hexadecimal digits.
    pub sha256: String,
    /// Size of the file.
    pub bytes: u64,
    /// The run's run key.
    pub run_key: String,
    /// The program that did the run again.
    pub verified_by_program_version: String,
    /// Its version of the model's physics.
    pub verified_by_physics_version: u32,
    /// How equal both were.
    pub verdict: Verdict,
    /// Where the run was done again.
    pub operating_system: String,
    /// On what processors.
    pub architecture: String,
}

/// What a file and its attestation say of each other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum AttestationStatus {
    /// The file is the one that was verified.
    Attested(Attestation),
    /// It is another one; in what.
    Changed(&'static str),
    /// There is no attestation that this program can read.
    Unattested(String),
}

/// Name of the attestation of a recording.
#[must_use]
pub fn attestation_path(recording: &Path) -> PathBuf {
    recording.with_extension("verified.json")
}

impl Attestation {
    /// The attestation of a file that was verified just now by a program with this physics.
    ///
    /// # Errors
    /// A file that can't be read.
    pub fn of(recording: &Recording, physics_version: u32, verdict: Verdict) -> io::Result<Self> {
        let (sha256, bytes) = hash(recording.path())?;
        Ok(Self {
            attestation_version: ATTESTATION_VERSION,
            sha256,
            bytes,
            run_key: recording.provenance().run_key.clone(),
            verified_by_program_version: env!("CARGO_PKG_VERSION").to_owned(),
            verified_by_physics_version: physics_version,
            verdict,
            operating_system: std::env::consts::OS.to_owned(),
            architecture: std::env::consts::ARCH.to_owned(),
        })
    }

    /// Writes it beside the recording, and returns where.
    ///
    /// # Errors
    /// A folder that can't be written.
    pub fn write(&self, recording: &Path) -> io::Result<PathBuf> {
        let path = attestation_path(recording);
        atomic_file::replace(&path, serde_json::to_string_pretty(self)?.as_bytes())?;
        Ok(path)
    }
}

/// Compares a file with its attestation: size, hash and run key, without a re-run.
///
/// # Errors
/// A recording that can't be read.
pub fn attestation_status(recording: &Path) -> io::Result<AttestationStatus> {
    let path = attestation_path(recording);
    let attestation = match read(&path) {
        Ok(attestation) => attestation,
        Err(error) => {
            return Ok(AttestationStatus::Unattested(format!("{}: {error}", path.display())));
        }
    };
    if attestation.attestation_version != ATTESTATION_VERSION {
        let found = attestation.attestation_version;
        let what = format!("{}: layout version {found} is not known", path.display());
        return Ok(AttestationStatus::Unattested(what));
    }
    if File::open(recording)?.metadata()?.len() != attestation.bytes {
        return Ok(AttestationStatus::Changed("size"));
    }
    if hash(recording)?.0 != attestation.sha256 {
        return Ok(AttestationStatus::Changed("SHA-256"));
    }
    if !carries_key(recording, &attestation.run_key) {
        return Ok(AttestationStatus::Changed("run key"));
    }
    Ok(AttestationStatus::Attested(attestation))
}

fn read(path: &Path) -> io::Result<Attestation> {
    let text = std::fs::read_to_string(path)?;
    serde_json::from_str(&text).map_err(io::Error::other)
}

/// Whether the file's manifest and versions make this key.
fn carries_key(path: &Path, key: &str) -> bool {
    Recording::open(path).is_ok_and(|recording| {
        let provenance = recording.provenance();
        let made =
            run_key(recording.manifest(), provenance.physics_version, provenance.schema_version);
        made.as_str() == key && provenance.run_key == key
    })
}

/// SHA-256 and size of a file.
fn hash(path: &Path) -> io::Result<(String, u64)> {
    let mut file = File::open(path)?;
    let mut hash = Sha256::new();
    let mut part = vec![0; HASHED_AT_ONCE];
    let mut bytes = 0;
    loop {
        let count = file.read(&mut part)?;
        if count == 0 {
            let hexadecimal = hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
            return Ok((hexadecimal, bytes));
        }
        hash.update(&part[..count]);
        bytes += count as u64;
    }
}
