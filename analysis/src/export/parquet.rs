//! Parquet tables with the columns of the CSV format: all doubles except the frame.

use super::tables::TableFile;
use crate::write_file::WriteError;
use parquet::basic::{Compression, Repetition, Type as Physical, ZstdLevel};
use parquet::data_type::{DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Rows per row group, which bound the memory.
const ROWS_PER_GROUP: usize = 1 << 16;

struct ParquetFile {
    path: PathBuf,
    /// `None` after the file was closed.
    writer: Option<SerializedFileWriter<File>>,
    frames: Vec<i64>,
    /// The time, then the columns.
    columns: Vec<Vec<f64>>,
}

/// Creates a Parquet table.
pub(super) fn parquet_file(
    path: &Path,
    columns: &[String],
) -> Result<Box<dyn TableFile>, WriteError> {
    let path = path.with_extension("parquet");
    let begin = || -> Result<SerializedFileWriter<File>, ParquetError> {
        let field = |name: &str, physical| {
            let column = Type::primitive_type_builder(name, physical);
            column.with_repetition(Repetition::REQUIRED).build().map(Arc::new)
        };
        let mut fields = vec![field("frame", Physical::INT64)?, field("time", Physical::DOUBLE)?];
        for column in columns {
            fields.push(field(column, Physical::DOUBLE)?);
        }
        let schema = Type::group_type_builder("table").with_fields(fields).build()?;
        let zstd = Compression::ZSTD(ZstdLevel::try_new(1)?);
        let properties = WriterProperties::builder().set_compression(zstd).build();
        SerializedFileWriter::new(File::create(&path)?, Arc::new(schema), Arc::new(properties))
    };
    let writer = begin().map_err(|error| WriteError::new(&path, error))?;
    let columns = vec![Vec::new(); columns.len() + 1];
    Ok(Box::new(ParquetFile { path, writer: Some(writer), frames: Vec::new(), columns }))
}

impl ParquetFile {
    fn write_group(&mut self) -> Result<(), ParquetError> {
        let Some(writer) = self.writer.as_mut().filter(|_| !self.frames.is_empty()) else {
            return Ok(());
        };
        let mut group = writer.next_row_group()?;
        if let Some(mut column) = group.next_column()? {
            column.typed::<Int64Type>().write_batch(&self.frames, None, None)?;
            column.close()?;
        }
        for values in &mut self.columns {
            if let Some(mut column) = group.next_column()? {
                column.typed::<DoubleType>().write_batch(values, None, None)?;
                column.close()?;
            }
            values.clear();
        }
        self.frames.clear();
        group.close().map(drop)
    }
}

impl TableFile for ParquetFile {
    fn row(&mut self, frame: u64, time: f64, values: &[f64]) -> Result<(), WriteError> {
        self.frames.push(frame.cast_signed());
        for (column, value) in self.columns.iter_mut().zip([time].iter().chain(values)) {
            column.push(*value);
        }
        if self.frames.len() == ROWS_PER_GROUP {
            self.write_group().map_err(|error| WriteError::new(&self.path, error))?;
        }
        Ok(())
    }

    fn finish(&mut self) -> Result<PathBuf, WriteError> {
        let written = self.write_group();
        let closed = written.and_then(|()| match self.writer.take() {
            Some(writer) => writer.close().map(drop),
            None => Ok(()),
        });
        closed.map_err(|error| WriteError::new(&self.path, error))?;
        Ok(self.path.clone())
    }
}
