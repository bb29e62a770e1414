//! One table per topic: the run's coordinates, the frame, its time, and the values, each with its unit in the header.

use super::exporter::{ExportedRun, Exporter, WrittenFile};
use crate::input::coordinates::{CoordinateValue, value_of};
use crate::table::{Cell, CellKind, Column};
use crate::write_file::{WriteError, begin};
use kinetoscope_files::atomic_file::NewFile;
use kinetoscope_recording::channels::{self, Channel as _, FrameClock};
use kinetoscope_recording::fields::{FieldValue, FieldValues, read_fields};
use kinetoscope_recording::reader::{RecordedFrame, RecordedMessage};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::path::{Path, PathBuf};

/// A table that is written row by row.
pub(super) trait TableFile {
    /// Adds a row with one cell per column.
    fn row(&mut self, cells: Vec<Cell>) -> Result<(), WriteError>;

    /// Completes the file and returns its path.
    fn finish(self: Box<Self>) -> Result<PathBuf, WriteError>;
}

/// Creates a table with these columns in a file with this name without its extension.
pub(super) type Begin = fn(&Path, &[Column]) -> Result<Box<dyn TableFile>, WriteError>;

/// All tables of a recording.
pub(super) struct Tables {
    run: ExportedRun,
    folder: PathBuf,
    begin: Begin,
    open: BTreeMap<String, OpenTable>,
}

struct OpenTable {
    file: Box<dyn TableFile>,
    rows: u64,
}

impl Tables {
    pub(super) fn new(run: ExportedRun, folder: PathBuf, begin: Begin) -> Self {
        Self { run, folder, begin, open: BTreeMap::new() }
    }

    /// The columns that all tables begin with, and their cells in a frame.
    fn first_cells(&self, clock: &FrameClock) -> Vec<(Column, Cell)> {
        let coordinates = self.run.coordinates.iter().map(|(name, coordinate)| {
            let (kind, cell) = match value_of(coordinate) {
                CoordinateValue::Integer(number) => (CellKind::Integer, Cell::Integer(number)),
                CoordinateValue::Number(number) => (CellKind::Number, Cell::Number(number)),
                CoordinateValue::Text(text) => (CellKind::Text, Cell::Text(text)),
            };
            (Column::new(name, kind), cell)
        });
        let integer =
            |name: &str, number: u64| (Column::new(name, CellKind::Integer), number.into());
        let replicate = self.run.replicate.map(|replicate| integer("replicate", replicate.into()));
        let time = Column::new(with_unit("time", &self.run.time_unit), CellKind::Number);
        let clock = [integer("frame", clock.frame), (time, Cell::Number(clock.time))];
        coordinates.chain(replicate).chain(clock).collect()
    }

    /// Writes rows to the table of a topic, which is created with the first of them.
    fn write(
        &mut self,
        topic: &str,
        clock: &FrameClock,
        columns: impl Iterator<Item = Column>,
        rows: impl Iterator<Item = Vec<Cell>>,
    ) -> Result<(), WriteError> {
        let (mut all, first): (Vec<Column>, Vec<Cell>) =
            self.first_cells(clock).into_iter().unzip();
        let table = match self.open.entry(topic.to_owned()) {
            Entry::Occupied(entry) => entry.into_mut(),
            Entry::Vacant(entry) => {
                for column in columns {
                    let is_taken = all.iter().any(|other| other.name == column.name);
                    // A series may have a time of its own: that of each entry.
                    let name =
                        if is_taken { format!("entry_{}", column.name) } else { column.name };
                    all.push(Column::new(name, column.kind));
                }
                let path = self.folder.join(topic.trim_start_matches('/'));
                entry.insert(OpenTable { file: (self.begin)(&path, &all)?, rows: 0 })
            }
        };
        for cells in rows {
            table.rows += 1;
            table.file.row(first.iter().cloned().chain(cells).collect())?;
        }
        Ok(())
    }
}

impl Exporter for Tables {
    fn write_frame(&mut self, frame: &RecordedFrame) -> Result<(), WriteError> {
        if let Some(state) = frame.state() {
            let units = self.run.units.iter().map(String::as_str).chain(std::iter::repeat(""));
            let named = self.run.columns.iter().zip(units);
            let named =
                named.map(|(name, unit)| Column::new(with_unit(name, unit), CellKind::Number));
            let particle = Column::new("particle", CellKind::Integer);
            let columns: Vec<Column> = [particle].into_iter().chain(named).collect();
            let rows = (0..state.rows()).map(|particle| {
                let values = state.row(particle).iter().map(|value| Cell::Number(*value));
                [Cell::from(particle as u64)].into_iter().chain(values).collect()
            });
            self.write(channels::STATE, &frame.clock, columns.into_iter(), rows)?;
        }
        for message in frame.messages() {
            let fields = fields(message);
            // A message of series has one row per entry, any other message one row.
            let rows = fields.iter().map(|field| field.values.len()).max().unwrap_or(0);
            if rows == 0 && fields.iter().all(|field| !field.series) {
                continue;
            }
            let columns = fields.iter().map(|field| {
                let is_count = matches!(field.values.first(), Some(FieldValue::Count(_)));
                let kind = if is_count { CellKind::Integer } else { CellKind::Number };
                Column::new(field.name, kind)
            });
            let rows =
                (0..rows).map(|row| fields.iter().map(|it| cell(it.values.get(row))).collect());
            self.write(message.topic(), &frame.clock, columns, rows)?;
        }
        Ok(())
    }

    fn finish(&mut self) -> Result<Vec<WrittenFile>, WriteError> {
        let tables = std::mem::take(&mut self.open).into_values();
        tables
            .map(|table| Ok(WrittenFile { path: table.file.finish()?, rows: table.rows }))
            .collect()
    }
}

/// The fields of a message that its table contains: numbers, except those of the first columns.
fn fields(message: &RecordedMessage) -> Vec<FieldValues> {
    let declared = channels::ALL
        .iter()
        .find(|channel| channel.topic == message.topic() && channel.schema == message.schema());
    let fields = declared.and_then(|channel| read_fields(channel, message.payload()));
    let is_clock = message.topic() == FrameClock::TOPIC;
    let is_exported = |field: &FieldValues| {
        let is_text = matches!(field.values.first(), Some(FieldValue::Text(_)));
        let is_first_column = is_clock && matches!(field.name, "frame" | "time");
        !is_text && !is_first_column
    };
    fields.unwrap_or_default().into_iter().filter(is_exported).collect()
}

fn cell(value: Option<&FieldValue>) -> Cell {
    match value {
        Some(FieldValue::Number(number)) => Cell::Number(*number),
        Some(FieldValue::Count(count)) => (*count).into(),
        Some(FieldValue::Text(_)) | None => Cell::Missing,
    }
}

/// A name with its unit last, as the fields of messages have it: `vx` in m/s is `vx_m_per_s`.
fn with_unit(name: &str, unit: &str) -> String {
    let words = unit.split('/').map(|part| match part {
        "d" if unit == "d" => "days".to_owned(),
        "d" => "day".to_owned(),
        part => part.to_lowercase().replace('^', ""),
    });
    match words.collect::<Vec<_>>().join("_per_") {
        unit if unit.is_empty() => name.to_owned(),
        unit => format!("{name}_{unit}"),
    }
}

struct CsvFile {
    path: PathBuf,
    writer: csv::Writer<NewFile>,
}

/// Creates a CSV table. Numbers read back to the same bits.
pub(super) fn csv_file(path: &Path, columns: &[Column]) -> Result<Box<dyn TableFile>, WriteError> {
    let path = path.with_extension("csv");
    let mut writer = csv::Writer::from_writer(begin(&path)?);
    writer
        .write_record(columns.iter().map(Column::text))
        .map_err(|error| WriteError::new(&path, error))?;
    Ok(Box::new(CsvFile { path, writer }))
}

impl TableFile for CsvFile {
    fn row(&mut self, cells: Vec<Cell>) -> Result<(), WriteError> {
        let record = cells.iter().map(Cell::text);
        self.writer.write_record(record).map_err(|error| WriteError::new(&self.path, error))
    }

    fn finish(self: Box<Self>) -> Result<PathBuf, WriteError> {
        let Self { path, writer } = *self;
        let file = writer.into_inner().map_err(|error| WriteError::new(&path, error.error()))?;
        file.finish().map_err(|error| WriteError::new(&path, error))?;
        Ok(path)
    }
}

#[cfg(test)]
mod tests {
    use super::with_unit;

    #[test]
    fn units_end_a_name_as_in_the_fields_of_messages() {
        assert_eq!(with_unit("vx", "AU/d"), "vx_au_per_day");
        assert_eq!(with_unit("time", "d"), "time_days");
        assert_eq!(with_unit("spin", "rad/s"), "spin_rad_per_s");
        assert_eq!(with_unit("x", ""), "x");
    }
}
