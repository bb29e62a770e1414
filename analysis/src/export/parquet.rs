//! Parquet tables with the columns of the CSV format.

use super::tables::TableFile;
use crate::table::parquet::ParquetTable;
use crate::table::{Cell, Column};
use crate::write_file::{WriteError, begin};
use kinetoscope_files::atomic_file::NewFile;
use std::path::{Path, PathBuf};

struct ParquetFile {
    path: PathBuf,
    table: ParquetTable<NewFile>,
}

/// Creates a Parquet table.
pub(super) fn parquet_file(
    path: &Path,
    columns: &[Column],
) -> Result<Box<dyn TableFile>, WriteError> {
    let path = path.with_extension("parquet");
    let table = ParquetTable::new(begin(&path)?, columns);
    let table = table.map_err(|error| WriteError::new(&path, error))?;
    Ok(Box::new(ParquetFile { path, table }))
}

impl TableFile for ParquetFile {
    fn row(&mut self, cells: Vec<Cell>) -> Result<(), WriteError> {
        self.table.row(cells).map_err(|error| WriteError::new(&self.path, error))
    }

    fn finish(self: Box<Self>) -> Result<PathBuf, WriteError> {
        let Self { path, table } = *self;
        let file = table.finish().map_err(|error| WriteError::new(&path, error))?;
        file.finish().map_err(|error| WriteError::new(&path, error))?;
        Ok(path)
    }
}
