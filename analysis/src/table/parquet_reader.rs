//! Reader of the tables that this program writes as Parquet: one column of one row group at a time.

use super::parquet::ROWS_PER_GROUP;
use super::{Cell, CellKind, Column, seal};
use kinetoscope_files::regular_file;
use parquet::column::reader::ColumnReader;
use parquet::data_type::ByteArray;
use parquet::errors::ParquetError;
use parquet::file::reader::FileReader as _;
use parquet::file::serialized_reader::SerializedFileReader;
use std::fs::File;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

/// A table on the disk.
pub(crate) struct ParquetReader {
    reader: SerializedFileReader<File>,
    /// The columns of the file.
    pub(crate) columns: Vec<Column>,
}

impl ParquetReader {
    /// Opens a table, checks all of its bytes, and reads its footer.
    ///
    /// # Errors
    /// A file that cannot be read, or `InvalidData` for one that is not a table as this program writes it.
    pub(crate) fn open(path: &Path) -> io::Result<Self> {
        let (file, _) = regular_file::open(path)?;
        seal::check(&file)?;
        let invalid = |why: ParquetError| io::Error::new(io::ErrorKind::InvalidData, why);
        let reader = caught(|| SerializedFileReader::new(file).map_err(invalid))?;
        // The reader reserves memory for the rows that the footer states.
        let rows = |group: usize| reader.metadata().row_group(group).num_rows();
        if (0..reader.num_row_groups()).any(|at| !(0..=ROWS_PER_GROUP as i64).contains(&rows(at))) {
            return Err(invalid(ParquetError::General("a group with too many rows".to_owned())));
        }
        let schema = reader.metadata().file_metadata().schema_descr();
        let column = |at: usize| {
            let column = schema.column(at);
            let kind = match column.physical_type() {
                parquet::basic::Type::BYTE_ARRAY => CellKind::Text,
                parquet::basic::Type::INT64 => CellKind::Integer,
                parquet::basic::Type::BOOLEAN => CellKind::Boolean,
                _ => CellKind::Number,
            };
            Column::new(column.name(), kind)
        };
        let columns = (0..schema.num_columns()).map(column).collect();
        Ok(Self { reader, columns })
    }

    /// The text of an entry of the file's metadata.
    pub(crate) fn entry(&self, name: &str) -> Option<&str> {
        let entries = self.reader.metadata().file_metadata().key_value_metadata()?;
        entries.iter().find(|entry| entry.key == name)?.value.as_deref()
    }

    /// The number of row groups.
    pub(crate) fn groups(&self) -> usize {
        self.reader.num_row_groups()
    }

    /// The number of rows of a row group.
    pub(crate) fn rows(&self, group: usize) -> usize {
        usize::try_from(self.reader.metadata().row_group(group).num_rows()).unwrap_or(0)
    }

    /// The cells of a column in a row group.
    ///
    /// # Errors
    /// A file that cannot be read or is damaged.
    pub(crate) fn cells(&self, group: usize, column: usize) -> io::Result<Vec<Cell>> {
        caught(|| self.decoded(group, column))
    }

    fn decoded(&self, group: usize, column: usize) -> io::Result<Vec<Cell>> {
        let rows = self.rows(group);
        let group = self.reader.get_row_group(group).map_err(io::Error::other)?;
        let cells = match group.get_column_reader(column).map_err(io::Error::other)? {
            ColumnReader::DoubleColumnReader(mut reader) => {
                read(rows, Cell::Number, |levels, values| {
                    reader.read_records(rows, Some(levels), None, values)
                })
            }
            ColumnReader::Int64ColumnReader(mut reader) => {
                read(rows, Cell::Integer, |levels, values| {
                    reader.read_records(rows, Some(levels), None, values)
                })
            }
            ColumnReader::BoolColumnReader(mut reader) => {
                read(rows, Cell::Boolean, |levels, values| {
                    reader.read_records(rows, Some(levels), None, values)
                })
            }
            ColumnReader::ByteArrayColumnReader(mut reader) => {
                let text =
                    |bytes: ByteArray| Cell::Text(String::from_utf8_lossy(bytes.data()).into());
                read(rows, text, |levels, values| {
                    reader.read_records(rows, Some(levels), None, values)
                })
            }
            _ => Err(ParquetError::General("a column of another type".to_owned())),
        };
        cells.map_err(io::Error::other)
    }
}

/// What is read, or an error: the crate panics on some tables that were forged with a correct checksum.
fn caught<T>(read: impl FnOnce() -> io::Result<T>) -> io::Result<T> {
    // A panic leaves nothing behind that is used again: the table was only read.
    catch_unwind(AssertUnwindSafe(read)).unwrap_or_else(|_| {
        let what = "its reader has failed, as described above";
        Err(io::Error::new(io::ErrorKind::InvalidData, what))
    })
}

/// The cells of the values that `read` adds, with the level of each row: 0 for a missing one.
fn read<T>(
    rows: usize,
    cell: impl Fn(T) -> Cell,
    read: impl FnOnce(&mut Vec<i16>, &mut Vec<T>) -> Result<(usize, usize, usize), ParquetError>,
) -> Result<Vec<Cell>, ParquetError> {
    let (mut levels, mut values) = (Vec::new(), Vec::new());
    read(&mut levels, &mut values)?;
    if levels.len() != rows {
        return Err(ParquetError::General("a column ends early".to_owned()));
    }
    let mut values = values.into_iter();
    let cells = levels.iter().map(|level| match level {
        0 => Cell::Missing,
        _ => values.next().map_or(Cell::Missing, &cell),
    });
    Ok(cells.collect())
}
