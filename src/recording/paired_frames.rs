//! The frames of two recordings in pairs, without decoding what is equal: blocks with the same bytes in both files are passed over.

use crate::error::ReadError;
use crate::frames::Frames;
use crate::reader::Recording;
use crate::recorded_frame::RecordedFrame;
use std::num::NonZeroUsize;

/// The frames of two recordings in pairs, also those of which only scalars are stored.
///
/// Equal chunks need no decompression, so the first difference of two long recordings is found at the speed at which their
/// files are read. Of a row of equal blocks, the frames of the last one are delivered.
///
/// Memory: two blocks of each file and their content.
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
        let frames = |recording: &Recording| {
            Ok::<_, ReadError>(recording.frames_on(NonZeroUsize::MIN)?.with_scalar_frames())
        };
        Ok(Self { left: frames(left)?, right: frames(right)?, passes_over: true })
    }

    /// All pairs of frames.
    ///
    /// # Errors
    /// A file that cannot be opened.
    pub fn all(left: &Recording, right: &Recording) -> Result<Self, ReadError> {
        let [left, right] = [left.frames()?, right.frames()?].map(Frames::with_scalar_frames);
        Ok(Self { left, right, passes_over: false })
    }

    /// The next pair; `None` where a recording has ended.
    ///
    /// # Errors
    /// A file that is damaged or ends inside a frame. Damage in a part that both files share is found at the end of that part
    /// at the earliest.
    pub fn advance(&mut self) -> Result<[Option<RecordedFrame>; 2], ReadError> {
        if self.passes_over {
            self.pass_over_equal_blocks()?;
        }
        Ok([self.left.next().transpose()?, self.right.next().transpose()?])
    }

    fn pass_over_equal_blocks(&mut self) -> Result<(), ReadError> {
        if !self.left.declares_the_channels_of(&self.right) {
            return Ok(());
        }
        // The last block, and the chunks of the block that is not passed over yet.
        let (mut last, mut block) = (Vec::new(), Vec::new());
        while let (Some((one, ends_block)), Some((other, _))) =
            (self.left.packed_chunk(), self.right.packed_chunk())
            && one == other
        {
            let mut checksum = crc32fast::Hasher::new();
            checksum.update(one);
            let bodies = (self.left.skip_chunk(&checksum), self.right.skip_chunk(&checksum));
            let (Some(body), Some(other)) = bodies else { break };
            self.right.reuse(other);
            block.push(body);
            if ends_block {
                let earlier = std::mem::replace(&mut last, std::mem::take(&mut block));
                earlier.into_iter().for_each(|body| self.left.reuse(body));
            }
        }
        for body in last.into_iter().chain(block) {
            self.right.deliver(body.clone())?;
            self.left.deliver(body)?;
        }
        Ok(())
    }
}
