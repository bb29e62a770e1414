//! Tables as Parquet, one row group at a time.

use super::seal::Sealing;
use super::{Cell, CellKind, Column};
use parquet::basic::{Compression, Encoding, LogicalType, Repetition, Type as Physical, ZstdLevel};
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::{ColumnPath, Type};
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::io::{self, Write};
use std::ops::Range;
use std::sync::Arc;

/// Rows per row group, which bound the memory.
pub(super) const ROWS_PER_GROUP: usize = 1 << 15;

/// Rows that are compared to choose the encoding of a column.
const MOST_COMPARED: usize = 1000;

/// A Parquet table that is written row by row.
pub(crate) struct ParquetTable<W: Write + Send> {
    writer: SerializedFileWriter<W>,
    /// The cells of the current row group, by column.
    group: Vec<Vec<Cell>>,
}

impl<W: Write + Send> ParquetTable<W> {
    /// Begins a table. Each cell may be missing.
    ///
    /// # Errors
    /// An output that cannot be written.
    pub(crate) fn new(output: W, columns: &[Column]) -> Result<Self, ParquetError> {
        let writer = begin(output, columns, None, |_| false)?;
        Ok(Self { writer, group: vec![Vec::new(); columns.len()] })
    }

    /// Adds a row of as many cells as there are columns.
    ///
    /// # Errors
    /// An output that cannot be written.
    pub(crate) fn row(
        &mut self,
        cells: impl IntoIterator<Item = Cell>,
    ) -> Result<(), ParquetError> {
        for (column, cell) in self.group.iter_mut().zip(cells) {
            column.push(cell);
        }
        let is_full = self.group.first().is_some_and(|column| column.len() == ROWS_PER_GROUP);
        if is_full { self.write_group() } else { Ok(()) }
    }

    /// Writes the last rows and the footer, and returns the output.
    ///
    /// # Errors
    /// An output that cannot be written.
    pub(crate) fn finish(mut self) -> Result<W, ParquetError> {
        self.write_group()?;
        self.writer.into_inner()
    }

    fn write_group(&mut self) -> Result<(), ParquetError> {
        if self.group.first().is_none_or(Vec::is_empty) {
            return Ok(());
        }
        add_group(&mut self.writer, &self.group)?;
        self.group.iter_mut().for_each(Vec::clear);
        Ok(())
    }
}

/// Writes a row group of these columns.
fn add_group<W: Write + Send>(
    writer: &mut SerializedFileWriter<W>,
    columns: impl IntoIterator<Item: AsRef<[Cell]>>,
) -> Result<(), ParquetError> {
    let mut group = writer.next_row_group()?;
    for cells in columns {
        if let Some(mut column) = group.next_column()? {
            write_cells(cells.as_ref(), column.untyped())?;
            column.close()?;
        }
    }
    group.close().map(drop)
}

/// Writes a table with a checksum, column by column, and returns the output. `read` returns a range of rows, and `cell` that of a row in
/// such a range and a column.
///
/// # Errors
/// Errors of `read` and of the output.
pub(crate) fn write<R: Sync, W: Write + Send>(
    output: W,
    columns: &[Column],
    (name, description): (&str, &str),
    rows: usize,
    mut read: impl FnMut(Range<usize>) -> io::Result<R>,
    cell: impl Fn(&R, usize, usize) -> Cell + Sync,
) -> Result<W, ParquetError> {
    let entry = KeyValue::new(name.to_owned(), description.to_owned());
    let compared = rows.min(MOST_COMPARED);
    let first_rows = read(0..compared)?;
    let is_mostly_different = |column: usize| {
        let text = |row| cell(&first_rows, row, column).text();
        (0..compared).map(text).collect::<BTreeSet<String>>().len() > compared / 2
    };
    let mut writer = begin(Sealing::new(output), columns, Some(vec![entry]), is_mostly_different)?;
    for first in (0..rows).step_by(ROWS_PER_GROUP) {
        let here = first..rows.min(first + ROWS_PER_GROUP);
        let (count, group) = (here.len(), read(here)?);
        let cells = |column| {
            let rows = (0..count).into_par_iter();
            rows.map(|row| cell(&group, row, column)).collect::<Vec<Cell>>()
        };
        add_group(&mut writer, (0..columns.len()).map(cells))?;
    }
    writer.inner_mut().begin_footer();
    Ok(writer.into_inner()?.finish()?)
}

/// The error of the output or of the rows behind that of a table.
pub(crate) fn io_error(error: ParquetError) -> io::Error {
    match error {
        ParquetError::External(error) => match error.downcast::<io::Error>() {
            Ok(error) => *error,
            Err(error) => io::Error::other(error),
        },
        error => io::Error::other(error),
    }
}

fn begin<W: Write + Send>(
    output: W,
    columns: &[Column],
    metadata: Option<Vec<KeyValue>>,
    is_mostly_different: impl Fn(usize) -> bool,
) -> Result<SerializedFileWriter<W>, ParquetError> {
    let fields: Result<Vec<Arc<Type>>, ParquetError> = columns.iter().map(field).collect();
    let schema = Type::group_type_builder("table").with_fields(fields?).build()?;
    let zstd = Compression::ZSTD(ZstdLevel::try_new(1)?);
    let mut properties =
        WriterProperties::builder().set_compression(zstd).set_key_value_metadata(metadata);
    // A dictionary of different values is longer than they are, and the first bytes of numbers are alike.
    for (_, column) in columns.iter().enumerate().filter(|(at, _)| is_mostly_different(*at)) {
        let path = ColumnPath::new(vec![column.name.clone()]);
        properties = properties.set_column_dictionary_enabled(path.clone(), false);
        if column.kind == CellKind::Number {
            properties = properties.set_column_encoding(path, Encoding::BYTE_STREAM_SPLIT);
        }
    }
    SerializedFileWriter::new(output, Arc::new(schema), Arc::new(properties.build()))
}

fn field(column: &Column) -> Result<Arc<Type>, ParquetError> {
    let (physical, logical) = match column.kind {
        CellKind::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
        CellKind::Integer => (Physical::INT64, None),
        CellKind::Number => (Physical::DOUBLE, None),
        CellKind::Boolean => (Physical::BOOLEAN, None),
    };
    let field = Type::primitive_type_builder(&column.name, physical)
        .with_logical_type(logical)
        .with_repetition(Repetition::OPTIONAL);
    field.build().map(Arc::new)
}

/// Writes the cells of one column; a cell of another type than the column's is missing.
fn write_cells(cells: &[Cell], writer: &mut ColumnWriter<'_>) -> Result<(), ParquetError> {
    /// The values that are present, and for each cell whether it is.
    fn present<T>(cells: &[Cell], value: impl Fn(&Cell) -> Option<T>) -> (Vec<T>, Vec<i16>) {
        let values: Vec<Option<T>> = cells.iter().map(value).collect();
        let levels = values.iter().map(|value| i16::from(value.is_some())).collect();
        (values.into_iter().flatten().collect(), levels)
    }
    match writer {
        ColumnWriter::ByteArrayColumnWriter(writer) => {
            let (values, levels) = present(cells, |cell| match cell {
                Cell::Text(text) => Some(ByteArray::from(text.as_str())),
                _ => None,
            });
            writer.write_batch(&values, Some(&levels), None)?;
        }
        ColumnWriter::Int64ColumnWriter(writer) => {
            let (values, levels) = present(cells, |cell| match cell {
                Cell::Integer(number) => Some(*number),
                _ => None,
            });
            writer.write_batch(&values, Some(&levels), None)?;
        }
        ColumnWriter::DoubleColumnWriter(writer) => {
            let (values, levels) = present(cells, |cell| match cell {
                Cell::Number(number) => Some(*number),
                Cell::Integer(number) => Some(*number as f64),
                _ => None,
            });
            writer.write_batch(&values, Some(&levels), None)?;
        }
        ColumnWriter::BoolColumnWriter(writer) => {
            let (values, levels) = present(cells, |cell| match cell {
                Cell::Boolean(value) => Some(*value),
                _ => None,
            });
            writer.write_batch(&values, Some(&levels), None)?;
        }
        _ => return Err(ParquetError::General("a column of another type".to_owned())),
    }
    Ok(())
}
