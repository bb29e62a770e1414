//! Plausible limits for the sizes that a file claims. A claim above its limit is damage, and it is rejected before memory or time
//! is spent on it.
//!
//! A recorded block has up to 13 MiB of messages before its last frame, so its size follows from that of a frame.

use crate::record_kind as kind;
use kinetoscope_files::regular_file::MAX_MANIFEST_BYTES;

/// Maximum size of a record outside the chunks. The largest are the indexes of a chunk's messages: 16 bytes per message.
const MAX_RECORD_BYTES: u64 = 16 << 20;
/// Maximum size of a record with texts: provenance, outcome and their indexes.
const MAX_TEXT_BYTES: u64 = 1 << 20;
/// Name, type and checksum of the manifest's attachment.
const ATTACHMENT_EXTRA_BYTES: u64 = 4 << 10;
/// Maximum number of channels and of schemas of a recording; the models have up to 16.
pub(crate) const MAX_CHANNELS: usize = 64;
/// Maximum number of columns of the state; the models have up to 9.
pub(crate) const MAX_STATE_COLUMNS: usize = 64;
/// Maximum number of log lines of a frame; the models write up to a few.
pub(crate) const MAX_LOG_LINES: usize = 1000;
/// Maximum number of messages of a chunk: those of frames without particles take a few bytes each.
pub(crate) const MAX_CHUNK_MESSAGES: usize = 1 << 20;
/// Size to which any chunk may be decompressed: 1 MiB of payloads in the smallest messages, with their headers.
const CHUNK_FLOOR_BYTES: u64 = 64 << 20;
/// Maximum size of a frame if its number of particles is not known.
const UNKNOWN_FRAME_BYTES: u64 = 4 << 30;
/// Maximum size of the drawing, the contact forces and the other messages of a frame per particle: measured are 150 bytes with
/// velocity arrows, and 150 bytes of contact forces (up to three contacts of 48 bytes).
const DRAWN_BYTES: u64 = 1024;
/// Maximum size of a chunk over its compressed size, for chunks above [`ANY_RATIO_BYTES`]. Such a chunk has one frame, and the most
/// compressible state is a lattice of discs at rest: measured are 110 to 120 at any number of columns.
const UNPACKED_RATIO: u64 = 192;
/// Size up to which a chunk may have any compression ratio: a frame of 3.7 million discs with 9 columns.
const ANY_RATIO_BYTES: u64 = 256 << 20;
/// Maximum size of the chunks that are decompressed ahead, with their compressed bytes. One chunk may exceed it alone.
pub(crate) const MAX_AHEAD_BYTES: u64 = 256 << 20;

/// Maximum size of the body of a record outside the chunks; `None` for a kind that no recording has there.
pub(crate) fn record_bytes(kind: u8) -> Option<u64> {
    match kind {
        // Sparse files and zeroed disks read as records of kind 0 and length 0.
        0 | kind::CHUNK | kind::MESSAGE => None,
        kind::ATTACHMENT => Some(MAX_MANIFEST_BYTES + ATTACHMENT_EXTRA_BYTES),
        kind::HEADER | kind::METADATA | kind::METADATA_INDEX | kind::DATA_END => {
            Some(MAX_TEXT_BYTES)
        }
        _ => Some(MAX_RECORD_BYTES),
    }
}

/// Limits for the chunks of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ChunkLimits {
    content_bytes: u64,
}

impl ChunkLimits {
    /// The limits for frames of up to `particles` particles with `columns` values each; `None` if the number is not known.
    pub(crate) fn new(particles: Option<u64>, columns: usize) -> Self {
        let row = 8 * columns as u64 + DRAWN_BYTES;
        let frame = particles.map_or(UNKNOWN_FRAME_BYTES, |count| count.saturating_mul(row));
        Self { content_bytes: frame.saturating_add(CHUNK_FLOOR_BYTES) }
    }

    /// Maximum size of the body of a chunk's record. Compressed data that cannot be compressed grow by less than 1 %.
    pub(crate) fn body_bytes(self) -> u64 {
        self.content_bytes.saturating_add(self.content_bytes / 64)
    }

    /// Maximum size of the content of a chunk, and of the chunks of a block together.
    pub(crate) fn max_content_bytes(self) -> u64 {
        self.content_bytes
    }

    /// Maximum size of the content of a chunk with this compressed size.
    pub(crate) fn content_bytes(self, packed_bytes: u64) -> u64 {
        let ratio = packed_bytes.saturating_mul(UNPACKED_RATIO);
        self.content_bytes.min(ratio.max(ANY_RATIO_BYTES))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn content_of_a_chunk_follows_from_its_compressed_size() {
        let limits = ChunkLimits::new(Some(4_000_000), 9);
        // A bomb: zeros are compressed 30,000-fold.
        assert!(limits.content_bytes(1_500_000) < 300 << 20);
        // A lattice of 4 million discs at rest is compressed 120-fold.
        let lattice = 4_000_000 * 9 * 8;
        assert!(limits.content_bytes(lattice / 120) > lattice);
        // Small chunks have any ratio, and a frame of few particles is small.
        assert_eq!(limits.content_bytes(1), ANY_RATIO_BYTES);
        assert!(ChunkLimits::new(Some(2), 9).content_bytes(1_500_000) < 65 << 20);
    }
}
