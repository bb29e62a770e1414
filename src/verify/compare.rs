//! Comparison of two recordings: the manifest keys that differ, the versions, and the messages.

use crate::interrupt::Interrupt;
use crate::run::recording;
use crate::verify::diff::{Comparison, compare_messages};
use crate::verify::divergence::{self, Divergence};
use crate::verify::error::VerifyError;
use kinetoscope_manifest::{KeyDifference, differing_keys};
use kinetoscope_recording::file::same_bytes;
use kinetoscope_recording::reader::Recording;
use std::path::Path;

/// The differences between two recordings.
#[derive(Debug)]
pub struct RecordingComparison {
    /// The keys of the manifests that differ.
    pub keys: Vec<KeyDifference>,
    /// Versions and run keys that differ: the name and both values.
    pub versions: Vec<(&'static str, [String; 2])>,
    /// Comparison of the messages.
    pub messages: Comparison,
    /// Whether the files are byte-identical; not known of files that cannot be read to their end.
    pub same_bytes: Option<bool>,
    /// Where the states of the particles differ for the first time; `None` if the recordings keep different frames.
    pub divergence: Option<Divergence>,
}

impl RecordingComparison {
    /// Whether the runs have other equations, coefficients or initial values according to their manifests and versions.
    #[must_use]
    pub fn has_other_physics(&self) -> bool {
        let is_physics = |key: &KeyDifference| key.key == "seed" || key.key.starts_with("model.");
        self.keys.iter().any(is_physics)
            || self.versions.iter().any(|(what, _)| *what == "physics version")
    }
}

/// Compares two recordings. With an interrupt, both runs are executed again up to the first step that differs.
///
/// # Errors
/// A file that is not a recording or cannot be opened, or a signal. Damage after the first frame is part of the result.
pub fn compare_recordings(
    left: &Path,
    right: &Path,
    find_step: Option<&Interrupt>,
) -> Result<RecordingComparison, VerifyError> {
    let (left_recording, right_recording) = (recording::open(left)?, recording::open(right)?);
    let keys = differing_keys(left_recording.manifest(), right_recording.manifest());
    let divergence = match keys.iter().any(selects_frames) {
        true => None,
        false => divergence::in_frames(&left_recording, &right_recording)?,
    };
    let divergence = divergence.map(|found| {
        let step = find_step.and_then(|interrupt| {
            divergence::find_step([&left_recording, &right_recording], &found, interrupt)
        });
        step.unwrap_or(found)
    });
    if let Some(code) = find_step.and_then(Interrupt::exit_code) {
        return Err(VerifyError::Interrupted(code));
    }
    let messages = compare_messages(&left_recording, &right_recording)?;
    // Behind the damage, a file of a few bytes may claim any size.
    let same_bytes = match (&messages.difference, &messages.unreadable) {
        (None, None) => Some(same_bytes(left, right)?),
        (Some(_), _) => Some(false),
        (None, Some(_)) => None,
    };
    Ok(RecordingComparison {
        divergence,
        keys,
        versions: versions(&left_recording, &right_recording),
        same_bytes,
        messages,
    })
}

/// Whether a key decides at which times frames are recorded: states of other times differ without another physics.
fn selects_frames(difference: &KeyDifference) -> bool {
    difference.key.strip_prefix("record.").is_some_and(|key| {
        matches!(
            key,
            "frames"
                | "frames_per_decade"
                | "decades"
                | "keep"
                | "keyframe_distance"
                | "draw_every"
        ) || key.starts_with("every_")
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
