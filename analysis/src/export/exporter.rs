//! What every export format implements, and the run that it writes.

use crate::models::contract::Extent;
use crate::write_file::WriteError;
use kinetoscope_manifest::Coordinate;
use kinetoscope_recording::reader::RecordedFrame;
use std::path::PathBuf;

/// Writes the frames of one recording in one format.
pub(super) trait Exporter {
    /// Writes the next frame.
    fn write_frame(&mut self, frame: &RecordedFrame) -> Result<(), WriteError>;

    /// Writes buffered data, closes the files, and lists them.
    fn finish(&mut self) -> Result<Vec<WrittenFile>, WriteError>;
}

/// A file of an export.
pub(crate) struct WrittenFile {
    pub(crate) path: PathBuf,
    /// Number of rows: one per particle and frame, or one per entry of a message; 0 for a script.
    pub(crate) rows: u64,
}

/// The exported run.
pub(super) struct ExportedRun {
    pub(super) extent: Extent,
    /// Names of the state's columns.
    pub(super) columns: Vec<String>,
    /// Units of the state's columns; empty for dimensionless ones.
    pub(super) units: Vec<String>,
    /// "s", "d", or "" for dimensionless time.
    pub(super) time_unit: String,
    /// The run's point in the sweep, with the name of each axis.
    pub(super) coordinates: Vec<(String, Coordinate)>,
    /// Number of the replicate; `None` if the experiment has one.
    pub(super) replicate: Option<u32>,
}

impl ExportedRun {
    pub(super) fn index(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column == name)
    }
}
