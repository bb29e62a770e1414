//! One table per topic, with the frame and its time in the first columns.

use super::exporter::{ExportedRun, Exporter, WrittenFile};
use crate::write_file::WriteError;
use kinetoscope_recording::channels;
use kinetoscope_recording::fields::{FieldValue, read_fields};
use kinetoscope_recording::reader::RecordedFrame;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

/// A table that is written row by row.
pub(super) trait TableFile {
    /// Adds a row: the frame, its time, and one value per column.
    fn row(&mut self, frame: u64, time: f64, values: &[f64]) -> Result<(), WriteError>;

    /// Closes the file and returns its path.
    fn finish(&mut self) -> Result<PathBuf, WriteError>;
}

/// Creates a table with these columns, without frame and time, in a file with this name without its extension.
pub(super) type Begin = fn(&Path, &[String]) -> Result<Box<dyn TableFile>, WriteError>;

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

    fn table(&mut self, topic: &str, columns: &[String]) -> Result<&mut OpenTable, WriteError> {
        Ok(match self.open.entry(topic.to_owned()) {
            Entry::Occupied(entry) => entry.into_mut(),
            Entry::Vacant(entry) => {
                let path = self.folder.join(topic.trim_start_matches('/'));
                entry.insert(OpenTable { file: (self.begin)(&path, columns)?, rows: 0 })
            }
        })
    }
}

impl Exporter for Tables {
    fn write_frame(&mut self, frame: &RecordedFrame) -> Result<(), WriteError> {
        let (index, time) = (frame.clock.frame, frame.clock.time);
        if let Some(state) = frame.state() {
            let mut columns = vec!["particle".to_owned()];
            columns.extend_from_slice(&self.run.columns);
            let table = self.table(channels::STATE, &columns)?;
            let mut values = vec![0.0; columns.len()];
            for particle in 0..state.rows() {
                values[0] = particle as f64;
                values[1..].copy_from_slice(state.row(particle));
                table.row(index, time, &values)?;
            }
        }
        for message in frame.messages() {
            let declared = channels::ALL.iter().find(|channel| {
                channel.topic == message.topic() && channel.schema == message.schema()
            });
            let Some(fields) = declared.and_then(|channel| read_fields(channel, message.payload()))
            else {
                continue;
            };
            // A message of series has one row per entry, any other message one row; texts are skipped.
            let fields: Vec<_> = fields
                .into_iter()
                .filter(|field| !matches!(field.values.first(), Some(FieldValue::Text(_))))
                .collect();
            let rows = fields.iter().map(|field| field.values.len()).max().unwrap_or(0);
            let columns: Vec<String> = fields.iter().map(|field| field.name.to_owned()).collect();
            let table = self.table(message.topic(), &columns)?;
            for row in 0..rows {
                let values: Vec<f64> =
                    fields.iter().map(|field| number(field.values.get(row))).collect();
                table.row(index, time, &values)?;
            }
        }
        Ok(())
    }

    fn finish(&mut self) -> Result<Vec<WrittenFile>, WriteError> {
        let tables = self.open.values_mut();
        tables
            .map(|table| Ok(WrittenFile { path: table.file.finish()?, rows: table.rows }))
            .collect()
    }
}

impl OpenTable {
    fn row(&mut self, frame: u64, time: f64, values: &[f64]) -> Result<(), WriteError> {
        self.rows += 1;
        self.file.row(frame, time, values)
    }
}

fn number(value: Option<&FieldValue>) -> f64 {
    match value {
        Some(FieldValue::Number(number)) => *number,
        Some(FieldValue::Count(count)) => *count as f64,
        Some(FieldValue::Text(_)) | None => f64::NAN,
    }
}

struct CsvFile {
    path: PathBuf,
    writer: csv::Writer<BufWriter<File>>,
}

/// Creates a CSV table. Numbers read back to the same bits.
pub(super) fn csv_file(path: &Path, columns: &[String]) -> Result<Box<dyn TableFile>, WriteError> {
    let path = path.with_extension("csv");
    let file = File::create(&path).map_err(|error| WriteError::new(&path, error))?;
    let mut writer = csv::Writer::from_writer(BufWriter::new(file));
    let header = ["frame", "time"].into_iter().chain(columns.iter().map(String::as_str));
    writer.write_record(header).map_err(|error| WriteError::new(&path, error))?;
    Ok(Box::new(CsvFile { path, writer }))
}

impl TableFile for CsvFile {
    fn row(&mut self, frame: u64, time: f64, values: &[f64]) -> Result<(), WriteError> {
        let numbers = values.iter().map(|value| format!("{value:?}"));
        let record = [frame.to_string(), format!("{time:?}")].into_iter().chain(numbers);
        self.writer.write_record(record).map_err(|error| WriteError::new(&self.path, error))
    }

    fn finish(&mut self) -> Result<PathBuf, WriteError> {
        self.writer.flush().map_err(|error| WriteError::new(&self.path, error))?;
        Ok(self.path.clone())
    }
}
