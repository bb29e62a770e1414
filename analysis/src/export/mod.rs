//! Export of recordings to formats of other programs, in a second pass over the frames.

mod exporter;
mod gnuplot;
#[cfg(feature = "parquet")]
mod parquet;
#[cfg(feature = "parquet")]
pub(crate) mod sweep_table;
mod tables;
mod xyz;

use crate::input::RecordingFolder;
use crate::input::recording;
use crate::models;
use crate::write_file::{WriteError, create_folder};
use exporter::{ExportedRun, Exporter, WrittenFile};
use std::path::{Path, PathBuf};

/// A format of exported recordings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum ExportFormat {
    /// One CSV table per topic: one line per particle and frame, or per frame
    Csv,
    /// The same tables as Parquet (requires a program built with `--features parquet`)
    Parquet,
    /// One text file per frame with `x y r` per line, and a gnuplot script that plays them
    Gnuplot,
    /// Extended XYZ, for OVITO and ASE
    Xyz,
}

impl ExportFormat {
    /// Files per frame go to a folder of their own.
    const fn folder(self) -> &'static str {
        match self {
            Self::Gnuplot => "gnuplot",
            _ => "",
        }
    }
}

/// The error message for Parquet in a program without it.
pub(crate) const NEEDS_PARQUET: &str = "this program was built without Parquet. Build one with it, \
    `cargo build --release --package kinetoscope-analysis --features parquet`, or write CSV";

/// Why a recording was not exported as a whole.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ExportError {
    /// A file cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// This program was built without the format.
    #[error("{NEEDS_PARQUET}")]
    NotBuiltIn,
}

/// One recording in one format.
pub(crate) struct Export {
    pub(crate) recording: PathBuf,
    pub(crate) format: ExportFormat,
    pub(crate) files: Vec<WrittenFile>,
}

/// Exports the recordings of a folder to one subfolder of `folder` per recording. Unreadable recordings are skipped,
/// because the analysis reports them.
pub(crate) fn export(
    source: &RecordingFolder,
    format: ExportFormat,
    folder: &Path,
) -> Result<Vec<Export>, ExportError> {
    let mut exports = Vec::new();
    for path in &source.files {
        let Ok(recording) = source.recording(path) else { continue };
        let Ok(run) = recording::opened(recording) else { continue };
        let recording = run.recording();
        let stem = path.file_stem().unwrap_or_default();
        let folder = folder.join(stem).join(format.folder());
        create_folder(&folder)?;
        let run = ExportedRun {
            extent: models::extent(&run.manifest.model),
            columns: recording.state_columns().to_vec(),
        };
        let mut exporter = exporter(format, run, folder)?;
        let Ok(frames) = recording.frames() else { continue };
        // The intact frames of a damaged recording are exported.
        for frame in frames.map_while(Result::ok) {
            exporter.write_frame(&frame)?;
        }
        exports.push(Export { recording: path.clone(), format, files: exporter.finish()? });
    }
    Ok(exports)
}

fn exporter(
    format: ExportFormat,
    run: ExportedRun,
    folder: PathBuf,
) -> Result<Box<dyn Exporter>, ExportError> {
    Ok(match format {
        ExportFormat::Csv => Box::new(tables::Tables::new(run, folder, tables::csv_file)),
        ExportFormat::Gnuplot => Box::new(gnuplot::Gnuplot::new(run, folder)),
        ExportFormat::Xyz => Box::new(xyz::Xyz::new(run, folder)),
        #[cfg(feature = "parquet")]
        ExportFormat::Parquet => Box::new(tables::Tables::new(run, folder, parquet::parquet_file)),
        #[cfg(not(feature = "parquet"))]
        ExportFormat::Parquet => return Err(ExportError::NotBuiltIn),
    })
}
