//! Export of recordings to formats of other programs, in a second pass over the frames.

mod exporter;
mod gnuplot;
#[cfg(feature = "parquet")]
mod parquet;
#[cfg(feature = "parquet")]
pub(crate) mod sweep_table;
mod tables;
mod xyz;

use crate::input::coordinates::AxisNames;
use crate::input::recording::opened_with_its_frames;
use crate::input::{OpenedRuns, RecordingFolder, UnreadableRecording};
use crate::models;
use crate::write_file::{WriteError, create_folder};
use exporter::{ExportedRun, Exporter, WrittenFile};
use kinetoscope_console::Message;
use kinetoscope_files::atomic_file::leftovers;
use kinetoscope_recording::error::ReadError;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// A format of exported recordings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum ExportFormat {
    /// One CSV table per topic: one line per particle and frame, or per frame
    Csv,
    /// The same tables as Parquet
    Parquet,
    /// One text file per frame with `x y r vx vy` per line, the borders, and gnuplot scripts that play particles and velocities
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
pub(crate) fn needs_parquet() -> Message {
    Message::new(
        "this program was built without Parquet",
        "write CSV instead, use a released program (`pip install kinetoscope`), or build with \
         `cargo build --release --features parquet` in a clone",
    )
}

/// Why a recording was not exported as a whole.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ExportError {
    /// A file cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// This program was built without the format.
    #[error("{}", needs_parquet().what)]
    #[cfg_attr(
        feature = "parquet",
        allow(dead_code, reason = "the error of a build without the feature")
    )]
    NotBuiltIn,
}

/// One recording in one format.
pub(crate) struct Export {
    pub(crate) recording: PathBuf,
    pub(crate) format: ExportFormat,
    pub(crate) files: Vec<WrittenFile>,
}

/// Exports the recordings of a folder to one subfolder of `folder` per recording. `unreadable` receives the reasons why
/// recordings, or the rest of a damaged one, cannot be read.
pub(crate) fn export(
    source: &RecordingFolder,
    format: ExportFormat,
    folder: &Path,
    unreadable: &mut BTreeSet<UnreadableRecording>,
) -> Result<Vec<Export>, ExportError> {
    let mut exports = Vec::new();
    let OpenedRuns { runs, unreadable: unread, .. } = source.opened(opened_with_its_frames);
    unreadable.extend(unread);
    let names = AxisNames::of(runs.iter().map(|(_, coordinates)| coordinates.as_slice()));
    let has_replicates = runs.iter().any(|(run, _)| run.manifest.replicate > 0);
    for (run, coordinates) in runs {
        let recording = run.recording();
        let path = recording.path();
        let stem = path.file_stem().unwrap_or_default();
        let folder = folder.join(stem).join(format.folder());
        create_folder(&folder)?;
        for leftover in leftovers(&folder) {
            // A leftover that cannot be removed is of no harm.
            let _ = std::fs::remove_file(leftover);
        }
        let run = ExportedRun {
            extent: models::extent(&run.manifest.model),
            columns: recording.state_columns().to_vec(),
            units: recording.provenance().state_units.clone(),
            time_unit: recording.provenance().time_unit.clone(),
            replicate: has_replicates.then_some(run.manifest.replicate),
            coordinates: coordinates
                .into_iter()
                .map(|coordinate| (names.name(&coordinate.key).to_owned(), coordinate))
                .collect(),
        };
        let mut exporter = exporter(format, run, folder)?;
        let mut reported = |error: ReadError| {
            unreadable.insert(error.into());
        };
        // The intact frames of a damaged recording are exported.
        match recording.frames() {
            Ok(frames) => {
                for frame in
                    frames.with_scalar_frames().map_while(|frame| frame.map_err(&mut reported).ok())
                {
                    exporter.write_frame(&frame)?;
                }
            }
            Err(error) => {
                reported(error);
                continue;
            }
        }
        exports.push(Export { recording: path.to_path_buf(), format, files: exporter.finish()? });
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
