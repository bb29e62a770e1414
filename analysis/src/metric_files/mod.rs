//! The metrics of an experiment as files: `metrics.json`, `metrics.csv`, `metrics.parquet` and `runs.parquet`.

#[cfg(feature = "parquet")]
pub(crate) mod condition;
pub(crate) mod document;
#[cfg(feature = "parquet")]
mod rows_of_folder;
#[cfg(feature = "parquet")]
pub(crate) mod run_row;
#[cfg(feature = "parquet")]
pub(crate) mod runs_query;
#[cfg(feature = "parquet")]
pub(crate) mod runs_store;
#[cfg(feature = "parquet")]
pub(crate) mod runs_table;
pub(crate) mod table;

use crate::input::RecordingFolder;
use crate::input::recording::OpenRun;
use crate::run::RunAnalysis;
use kinetoscope_manifest::Coordinate;

/// The runs without recordings, and whether the table of the folder is kept.
pub(crate) fn rows_of_folder(
    source: &mut RecordingFolder,
    opened: &[(OpenRun, Vec<Coordinate>)],
) -> (Vec<RunAnalysis>, bool) {
    #[cfg(feature = "parquet")]
    return (rows_of_folder::tabled_runs(source), rows_of_folder::has_other_rows(source, opened));
    #[cfg(not(feature = "parquet"))]
    (Vec::new(), source.is_table && opened.is_empty())
}
