//! The last message of `/particles`, with which each state is compared.

use crate::block_writer::LARGE_MESSAGE_BYTES;
use crate::column::StateColumn;
use crate::table::Rows;
use sha2::{Digest as _, Sha256};

/// The message, or the SHA-256 of a large one, which would take 24 bytes per disc for the whole run.
#[derive(Debug)]
pub(crate) enum LastParticles {
    Message(Vec<u8>),
    Digest([u8; 32]),
}

impl Default for LastParticles {
    fn default() -> Self {
        Self::Message(Vec::new())
    }
}

impl LastParticles {
    /// The message, if there is one: of a run that is resumed, until its first frame.
    pub(crate) fn message(&self) -> Option<&[u8]> {
        match self {
            Self::Message(message) if !message.is_empty() => Some(message),
            _ => None,
        }
    }

    /// Takes the particles of these rows for the last ones. Returns their message if they differ from those before.
    pub(crate) fn update(&mut self, rows: &Rows, columns: &[StateColumn]) -> Option<Vec<u8>> {
        let other = (!self.are_those_of(rows, columns)).then(|| message(rows, columns));
        let last = other.as_deref().or(self.message()).unwrap_or_default();
        if last.len() >= LARGE_MESSAGE_BYTES {
            *self = Self::Digest(Sha256::digest(last).into());
        } else if let Some(other) = &other {
            *self = Self::Message(other.clone());
        }
        other
    }

    fn are_those_of(&self, rows: &Rows, columns: &[StateColumn]) -> bool {
        match self {
            Self::Message(message) => {
                let (mut rest, mut is_equal) = (&message[..], !message.is_empty());
                rows.particles(columns, |piece| {
                    match rest.strip_prefix(piece) {
                        Some(after) => rest = after,
                        None => is_equal = false,
                    }
                    is_equal
                });
                is_equal && rest.is_empty()
            }
            Self::Digest(digest) => {
                let mut hasher = Sha256::new();
                rows.particles(columns, |piece| {
                    hasher.update(piece);
                    true
                });
                hasher.finalize().as_slice() == digest
            }
        }
    }
}

/// The message of `/particles` of these rows.
pub(crate) fn message(rows: &Rows, columns: &[StateColumn]) -> Vec<u8> {
    let mut message = Vec::new();
    rows.particles(columns, |piece| {
        message.extend_from_slice(piece);
        true
    });
    message
}

#[cfg(test)]
mod tests {
    use super::*;

    const COLUMNS: &[StateColumn] = &[
        StateColumn { name: "x", unit: "m" },
        StateColumn { name: "radius", unit: "m" },
        StateColumn { name: "id", unit: "" },
    ];

    /// Guarantee: particles are recorded again when a constant of one of them has changed, and not when a coordinate has, whether the message
    /// is kept or only its hash.
    #[test]
    fn particles_are_recorded_when_a_constant_changes() {
        for count in [0, 1, ROWS, LARGE_MESSAGE_BYTES / 16 + 7] {
            let rows = |x: f64, last_radius: f64| {
                let mut rows = Rows::default();
                for id in 0..count {
                    let radius = if id + 1 == count { last_radius } else { 0.5 };
                    rows.push(&[x, radius, id as f64]);
                }
                rows
            };
            let mut last = LastParticles::default();
            let first = last.update(&rows(1.0, 0.5), COLUMNS).unwrap();
            assert_eq!(first.len() >= LARGE_MESSAGE_BYTES, count > ROWS);
            assert_eq!(last.message().is_some(), count <= ROWS);
            assert!(last.update(&rows(2.0, 0.5), COLUMNS).is_none());
            assert_eq!(last.update(&rows(2.0, 0.25), COLUMNS).is_some(), count > 0);
            // The message of a run that is resumed.
            last = LastParticles::Message(first);
            assert!(last.update(&rows(3.0, 0.5), COLUMNS).is_none());
        }
    }

    /// More than one piece.
    const ROWS: usize = 1025;
}
