//! Parquet tables with the columns of the CSV format.

use super::tables::TableFile;
use crate::table::parquet::ParquetTable;
use crate::table::{Cell, Column};
use crate::write_file::WriteError;
use std::fs::File;
use std::path::{Path, PathBuf};

struct ParquetFile {
    path: PathBuf,
    /// `None` after the file was closed.
    table: Option<ParquetTable<File>>,
}

/// Creates a Parquet table.
pub(super) fn parquet_file(
    path: &Path,
    columns: &[Column],
) -> Result<Box<dyn TableFile>, WriteError> {
    let path = path.with_extension("parquet");
    let file = File::create(&path).map_err(|error| WriteError::new(&path, error))?;
    let table = ParquetTable::new(file, columns).map_err(|error| WriteError::new(&path, error))?;
    Ok(Box::new(ParquetFile { path, table: Some(table) }))
}

impl TableFile for ParquetFile {
    fn row(&mut self, cells: Vec<Cell>) -> Result<(), WriteError> {
        let written = self.table.as_mut().map_or(Ok(()), |table| table.row(cells));
        written.map_err(|error| WriteError::new(&self.path, error))
    }

    fn finish(&mut self) -> Result<PathBuf, WriteError> {
        let closed = self.table.take().map_or(Ok(()), |table| table.finish().map(drop));
        closed.map_err(|error| WriteError::new(&self.path, error))?;
        Ok(self.path.clone())
    }
}
