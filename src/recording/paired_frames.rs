//! The frames of two recordings in pairs, without decoding what is equal: chunks with the same bytes in both files are passed over.

use crate::error::ReadError;
use crate::frames::{Frames, RecordedFrame};
use crate::reader::Recording;
use std::num::NonZeroUsize;

/// The frames of two recordings in pairs.
///
/// Equal chunks need no decompression, so the first difference of two long recordings is found at the speed at which their
/// files are read. Of a row of equal chunks, the frames of the last one are delivered.
///
/// Memory: two chunks of each file and their content.
pub struct PairedFrames {
    left: Frames,
    right: Frames,
    passes_over: bool,
}

impl PairedFrames {
    /// The pairs of frames that can differ, and some that are equal.
    ///
    /// # Errors
    /// A file that cannot be opened.
    pub fn that_can_differ(left: &Recording, right: &Recording) -> Result<Self, ReadError> {
        let frames = |recording: &Recording| recording.frames_on(NonZeroUsize::MIN);
        Ok(Self { left: frames(left)?, right: frames(right)?, passes_over: true })
    }

    /// All pairs of frames.
    ///
    /// # Errors
    /// A file that cannot be opened.
    pub fn all(left: &Recording, right: &Recording) -> Result<Self, ReadError> {
        Ok(Self { left: left.frames()?, right: right.frames()?, passes_over: false })
    }

    /// The next pair; `None` where a recording has ended.
    ///
    /// # Errors
    /// A file that is damaged or ends inside a frame. Damage in a part that both files share is found at the end of that part
    /// at the earliest.
    pub fn advance(&mut self) -> Result<[Option<RecordedFrame>; 2], ReadError> {
        if self.passes_over {
            self.pass_over_equal_chunks()?;
        }
        Ok([self.left.next().transpose()?, self.right.next().transpose()?])
    }

    fn pass_over_equal_chunks(&mut self) -> Result<(), ReadError> {
        if !self.left.declares_the_channels_of(&self.right) {
            return Ok(());
        }
        let mut last = None;
        while let (Some(one), Some(other)) = (self.left.packed_chunk(), self.right.packed_chunk())
            && one == other
        {
            let mut checksum = crc32fast::Hasher::new();
            checksum.update(one);
            let bodies = (self.left.skip_chunk(&checksum), self.right.skip_chunk(&checksum));
            let (Some(body), Some(other)) = bodies else { break };
            self.right.reuse(other);
            if let Some(earlier) = last.replace(body) {
                self.left.reuse(earlier);
            }
        }
        if let Some(body) = last {
            self.right.deliver(body.clone())?;
            self.left.deliver(body)?;
        }
        Ok(())
    }
}
