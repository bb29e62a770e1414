//! What every export format implements, and the run that it writes.

use crate::models::contract::Extent;
use crate::write_file::WriteError;
use kinetoscope_recording::reader::RecordedFrame;

/// Writes the frames of one recording in one format.
pub(super) trait Exporter {
    /// Writes the next frame.
    fn write_frame(&mut self, frame: &RecordedFrame) -> Result<(), WriteError>;

    /// Writes buffered data and closes the files.
    fn finish(&mut self) -> Result<(), WriteError>;
}

/// The exported run.
pub(super) struct ExportedRun {
    pub(super) extent: Extent,
    pub(super) columns: Vec<String>,
}

impl ExportedRun {
    pub(super) fn index(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column == name)
    }
}
