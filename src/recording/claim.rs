//! The claim of a recording: this manifest gives these messages. A report contains it, so that the engine in the page can check it.

use crate::error::ReadError;
use crate::frame_hashes::FrameHashes;
use crate::reader::{Outcome, Recording, StoredFrames};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

/// Frames in the list of a claim. Those of a longer run share a hash.
const MOST_LISTED: u64 = 512;
/// Bytes of the checksum before a claim.
const SUM_BYTES: usize = 32;

/// A manifest, the versions that give its messages, and their hashes.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Claim {
    /// The canonical text of the run.
    pub manifest: String,
    /// The run key.
    pub run_key: String,
    /// Version of the program that recorded the run.
    pub program_version: String,
    /// Version of the model's physics.
    pub physics_version: u32,
    /// Version of the messages.
    pub schema_version: u32,
    /// The hashes of its messages.
    pub hashes: FrameHashes,
}

/// The SHA-256 of bytes.
#[must_use]
pub fn sha256(bytes: &[u8]) -> [u8; SUM_BYTES] {
    Sha256::digest(bytes).into()
}

impl Claim {
    /// The claim of a recording; `None` if it does not have all messages of a run: those of an interrupted run or of keyframes only.
    ///
    /// # Errors
    /// A recording that cannot be read.
    pub fn of(recording: &Recording) -> Result<Option<Self>, ReadError> {
        let provenance = recording.provenance();
        let is_whole = matches!(provenance.outcome, Some(Outcome::Complete | Outcome::Fault(_)));
        if !is_whole || provenance.stored != StoredFrames::All {
            return Ok(None);
        }
        Ok(Some(Self {
            manifest: recording.manifest().to_owned(),
            run_key: provenance.run_key.clone(),
            program_version: provenance.program_version.clone(),
            physics_version: provenance.physics_version,
            schema_version: provenance.schema_version,
            hashes: FrameHashes::of(recording)?.thinned(MOST_LISTED),
        }))
    }

    /// The claim as bytes, after their SHA-256.
    ///
    /// # Errors
    /// A defect of the program.
    pub fn to_bytes(&self) -> Result<Vec<u8>, postcard::Error> {
        let body = postcard::to_stdvec(self)?;
        Ok([sha256(&body).to_vec(), body].concat())
    }

    /// The claim of these bytes; `None` if any of them was changed, or if the list of hashes is not whole.
    #[must_use]
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let (sum, body) = bytes.split_at_checked(SUM_BYTES)?;
        let is_intact = sha256(body).as_slice() == sum;
        let claim: Option<Self> = is_intact.then(|| postcard::from_bytes(body).ok()).flatten();
        claim.filter(|claim| claim.hashes.is_whole(MOST_LISTED))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Control: the same bytes without a change are read.
    #[test]
    fn every_changed_byte_of_a_claim_is_found() {
        let claim = Claim {
            manifest: "seed = 1".to_owned(),
            run_key: "key".to_owned(),
            program_version: "0.1.0".to_owned(),
            physics_version: 1,
            schema_version: 5,
            hashes: FrameHashes::default(),
        };
        let bytes = claim.to_bytes().unwrap();
        assert_eq!(Claim::from_bytes(&bytes), Some(claim.clone()));
        for place in 0..bytes.len() {
            let mut changed = bytes.clone();
            changed[place] ^= 1;
            assert_eq!(Claim::from_bytes(&changed), None, "byte {place}");
        }
        assert_eq!(Claim::from_bytes(&bytes[..bytes.len() - 1]), None);
        // A list that lacks hashes would leave frames that nothing is compared with.
        for (frames, every) in [(2, 1), (0, 0), (0, 2), (u64::MAX, u64::MAX)] {
            let mut hashes = FrameHashes::default();
            (hashes.frames, hashes.every) = (frames, every);
            let bytes = Claim { hashes, ..claim.clone() }.to_bytes().unwrap();
            assert_eq!(Claim::from_bytes(&bytes), None, "{frames} frames, every {every}");
        }
        assert_eq!(Claim::from_bytes(&[]), None);
    }
}
