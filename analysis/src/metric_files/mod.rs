//! The metrics of an experiment as files: `metrics.json`, `metrics.csv` and `metrics.parquet`.

pub(crate) mod document;
pub(crate) mod table;
