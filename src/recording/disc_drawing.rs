//! The drawing of a frame's discs, which takes long enough to be shared between threads.

use crate::frame::Frame;
use crate::playback::log_times;
use crate::scene::SceneBuilder;
use crate::stored_frames::DrawnFrames;
use std::sync::Arc;

/// Encodes the drawing of the discs of a frame, on any thread: the bytes do not depend on which one.
#[derive(Debug)]
pub(crate) struct DiscDrawing {
    scenes: Arc<SceneBuilder>,
    playback_fps: f64,
    drawn: DrawnFrames,
}

impl DiscDrawing {
    pub(crate) fn new(scenes: Arc<SceneBuilder>, playback_fps: f64, drawn: DrawnFrames) -> Self {
        Self { scenes, playback_fps, drawn }
    }

    /// An upper bound of the size of a frame's drawing, bytes.
    pub(crate) fn max_bytes(&self, frame: &Frame) -> usize {
        self.scenes.max_drawing_bytes(frame.state())
    }

    /// Encodes the drawing of the frame with this index, unless it is encoded already or not drawn. A frame without a time is left for the recorder
    /// to reject.
    pub(crate) fn encode(&self, frame: &mut Frame, index: u64) {
        if frame.discs().is_empty()
            && self.drawn.has(index)
            && let Some((_, time)) = log_times(index, self.playback_fps)
        {
            frame.make_nan_canonical();
            let (state, discs) = frame.state_and_discs();
            self.scenes.discs(state, time, discs);
        }
    }
}
