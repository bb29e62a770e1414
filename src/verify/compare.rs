//! Two recordings: which keys of their manifests differ, which versions, and what they hold.

use crate::verify::diff::{Comparison, compare_messages};
use kinetoscope_manifest::{KeyDifference, differing_keys};
use kinetoscope_recording::error::{ReadError, RecordError};
use kinetoscope_recording::file::same_bytes;
use kinetoscope_recording::reader::Recording;
use std::fmt;
use std::path::Path;

/// All that tells two recordings apart, from the question to the answer.
#[derive(Debug)]
pub struct RecordingComparison {
    /// The keys of the manifests that differ.
    pub keys: Vec<KeyDifference>,
    /// Versions and run keys that differ: what, and both.
    pub versions: Vec<(&'static str, [String; 2])>,
    /// The messages.
    pub messages: Comparison,
    /// Whether the files are equal in every byte.
    pub same_bytes: bool,
}

/// Why two recordings can't be compared.
#[derive(Debug)]
pub enum CompareError {
    /// One of them is none.
    Read(ReadError),
    /// One of them could not be read to its end.
    Io(RecordError),
}

impl fmt::Display for CompareError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Read(error) => error.fmt(formatter),
            Self::Io(error) => error.fmt(formatter),
        }
    }
}

impl std::error::Error for CompareError {}

impl From<ReadError> for CompareError {
    fn from(error: ReadError) -> Self {
        Self::Read(error)
    }
}

/// Compares two recordings.
///
/// # Errors
/// A file that is no recording or can't be read at all. Damage further on is part of the answer.
pub fn compare_recordings(left: &Path, right: &Path) -> Result<RecordingComparison, CompareError> {
    let (left_recording, right_recording) = (Recording::open(left)?, Recording::open(right)?);
    Ok(RecordingComparison {
        keys: differing_keys(left_recording.manifest(), right_recording.manifest()),
        versions: versions(&left_recording, &right_recording),
        messages: compare_messages(&left_recording, &right_recording)?,
        same_bytes: same_bytes(left, right).map_err(CompareError::Io)?,
    })
}

fn versions(left: &Recording, right: &Recording) -> Vec<(&'static str, [String; 2])> {
    let entries = |recording: &Recording| {
        let provenance = recording.provenance();
        [
            ("run key", provenance.run_key.clone()),
            ("program version", provenance.program_version.clone()),
            ("physics version", provenance.physics_version.to_string()),
        ]
    };
    let pairs = entries(left).into_iter().zip(entries(right));
    pairs
        .filter(|((_, one), (_, other))| one != other)
        .map(|((what, one), (_, other))| (what, [one, other]))
        .collect()
}
