//! Attestation of a verified file, which others can check without a rerun.

use kinetoscope_console::text::{shortened, shown_path};
use kinetoscope_files::atomic_file;
use kinetoscope_files::regular_file::{self, MAX_SIDE_FILE_BYTES};
use kinetoscope_manifest::run_key;
use kinetoscope_recording::error::{ReadError, ReadFault};
use kinetoscope_recording::reader::Recording;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// Version of the attestation's layout.
const ATTESTATION_VERSION: u32 = 1;
/// Maximum size of a version or of the name of a platform.
const MAX_TEXT_BYTES: usize = 64;
/// Length up to which the error of a file is shown; it quotes the file.
const MAX_REASON_CHARACTERS: usize = 300;
/// Size of the parts in which a file is hashed.
const HASHED_AT_ONCE: usize = 1 << 16;

/// How the file and its rerun agreed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// All bytes were equal.
    Bytes,
    /// All messages were equal.
    Messages,
}

/// Content of `STEM.verified.json`.
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
    /// Version of the program that verified the file.
    pub verified_by_program_version: String,
    /// Its physics version of the model.
    pub verified_by_physics_version: u32,
    /// How file and rerun agreed.
    pub verdict: Verdict,
    /// Operating system of the rerun.
    pub operating_system: String,
    /// Processor architecture of the rerun.
    pub architecture: String,
}

/// Result of the comparison of a file with its attestation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum AttestationStatus {
    /// The file is the verified one.
    Attested(Attestation),
    /// The file differs in this property.
    Changed(&'static str),
    /// No readable attestation exists.
    Unattested(String),
}

/// Name of the attestation of a recording.
#[must_use]
pub fn attestation_path(recording: &Path) -> PathBuf {
    recording.with_extension("verified.json")
}

impl Attestation {
    /// Attests a file that was verified with this physics version.
    ///
    /// # Errors
    /// A file that cannot be read.
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

    /// The texts that messages show.
    fn texts(&self) -> impl Iterator<Item = &str> {
        [&self.verified_by_program_version, &self.operating_system, &self.architecture]
            .into_iter()
            .map(String::as_str)
    }

    /// Writes the attestation next to the recording and returns its path.
    ///
    /// # Errors
    /// A folder that cannot be written.
    pub fn write(&self, recording: &Path) -> io::Result<PathBuf> {
        let path = attestation_path(recording);
        atomic_file::replace(&path, serde_json::to_string_pretty(self)?.as_bytes())?;
        Ok(path)
    }
}

/// Compares a file with its attestation: size, run key, end and hash, without a rerun. The hash comes last, because a file may claim
/// any size.
///
/// # Errors
/// A recording that cannot be read.
pub fn attestation_status(recording: &Path) -> Result<AttestationStatus, ReadError> {
    let path = attestation_path(recording);
    let attestation = match read(&path) {
        Ok(attestation) => attestation,
        Err(error) => {
            let reason = error.to_string();
            let reason = shortened(&reason, MAX_REASON_CHARACTERS);
            return Ok(AttestationStatus::Unattested(format!("{}: {reason}", shown_path(&path))));
        }
    };
    if attestation.attestation_version != ATTESTATION_VERSION {
        let found = attestation.attestation_version;
        let what = format!("{}: layout version {found} is not known", shown_path(&path));
        return Ok(AttestationStatus::Unattested(what));
    }
    if !is_sha256(&attestation.sha256) {
        let what =
            format!("{}: its SHA-256 is not 64 lowercase hexadecimal digits", shown_path(&path));
        return Ok(AttestationStatus::Unattested(what));
    }
    if attestation.texts().any(|text| text.len() > MAX_TEXT_BYTES) {
        let what =
            format!("{}: it has texts of more than {MAX_TEXT_BYTES} bytes", shown_path(&path));
        return Ok(AttestationStatus::Unattested(what));
    }
    let unread = |error| ReadError {
        path: recording.to_owned(),
        intact_frames: 0,
        fault: ReadFault::Io(error),
    };
    if regular_file::open(recording).map_err(unread)?.1.len() != attestation.bytes {
        return Ok(AttestationStatus::Changed("size"));
    }
    let opened = Recording::open(recording)?;
    if !has_key(&opened, &attestation.run_key) {
        return Ok(AttestationStatus::Changed("run key"));
    }
    // Only finished runs are attested, and a sparse file has no end.
    if opened.provenance().outcome.is_none() {
        return Ok(AttestationStatus::Changed("end"));
    }
    if hash(recording).map_err(unread)?.0 != attestation.sha256 {
        return Ok(AttestationStatus::Changed("SHA-256"));
    }
    Ok(AttestationStatus::Attested(attestation))
}

fn is_sha256(text: &str) -> bool {
    text.len() == 64 && text.bytes().all(|byte| matches!(byte, b'0'..=b'9' | b'a'..=b'f'))
}

fn read(path: &Path) -> io::Result<Attestation> {
    let text = regular_file::read_text(path, MAX_SIDE_FILE_BYTES)?;
    serde_json::from_str(&text).map_err(io::Error::other)
}

/// Whether this run key follows from the recording's manifest and versions.
fn has_key(recording: &Recording, key: &str) -> bool {
    let provenance = recording.provenance();
    let made = run_key(recording.manifest(), provenance.physics_version, provenance.schema_version);
    made.as_str() == key && provenance.run_key == key
}

/// SHA-256 and size of a file.
fn hash(path: &Path) -> io::Result<(String, u64)> {
    let (mut file, _) = regular_file::open(path)?;
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
