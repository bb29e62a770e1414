//! The metrics of an experiment as files: `metrics.json`, `metrics.csv`, `metrics.parquet` and `runs.parquet`.

#[cfg(feature = "parquet")]
pub(crate) mod condition;
pub(crate) mod document;
#[cfg(feature = "parquet")]
pub(crate) mod rows_of_folder;
#[cfg(feature = "parquet")]
pub(crate) mod run_row;
#[cfg(feature = "parquet")]
pub(crate) mod runs_query;
#[cfg(feature = "parquet")]
pub(crate) mod runs_store;
#[cfg(feature = "parquet")]
pub(crate) mod runs_table;
pub(crate) mod table;
