//! The command `kinetoscope table`: questions to the table of an experiment's runs.

use super::exit::CommandError;
use super::meant_paths::meant_paths;
use super::messages::{concluded, terminal};
use crate::metric_files::condition::Condition;
use crate::metric_files::runs_query::{
    Answered, COUNT_SUFFIX, QueryError, Question, RUNS, StoredRuns,
};
use crate::metric_files::runs_table::{DESCRIPTION, ERROR_SUFFIX};
use crate::number_text::{six_digits, with_error};
use crate::table::{self, Cell, Column};
use crate::write_file;
use kinetoscope_console::text::{one_line, plural, shown_path};
use kinetoscope_console::{Exit, Message, StandardOutput};
use serde_json::{Map, Value};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Columns about the recording and the program: a screen shows coordinates and metrics.
const ABOUT_THE_FILE: [&str; 9] = [
    "seed",
    "outcome_detail",
    "frames",
    "end_time",
    "messages",
    "file",
    "run_key",
    "program_version",
    "physics_version",
];

/// Print columns of the table of an experiment's runs (runs.parquet), or means over groups of complete runs with their standard
/// errors.
#[derive(Debug, clap::Args)]
pub struct TableArguments {
    /// Folder of an analyzed experiment, its manifest, or its runs.parquet
    #[arg(value_name = "EXPERIMENT")]
    path: PathBuf,
    /// Columns: coordinates of the sweep, replicate, seed, outcome, metrics and so on [default: all but standard errors; of those, a screen has as many as fit]
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    columns: Vec<String>,
    /// Rows that meet all of these comparisons, such as 'temperature_k > 250, outcome = complete'
    #[arg(long = "where", value_name = "CONDITION")]
    condition: Option<String>,
    /// Print one row per group of runs that agree in these columns, with means and standard errors over the complete runs
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    group: Vec<String>,
    /// Format
    #[arg(long, value_enum, default_value_t = TableFormat::Text)]
    format: TableFormat,
    /// File for the table [default: standard output]
    #[arg(long, short, value_name = "FILE", required_if_eq("format", "parquet"))]
    output: Option<PathBuf>,
    #[arg(skip)]
    standard_output: StandardOutput,
}

/// A format of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum TableFormat {
    /// Aligned columns; the digits in brackets are one standard error
    Text,
    /// One line per row; numbers have the fewest digits that give them back exactly
    Csv,
    /// A list of objects
    Json,
    /// A table for DuckDB and Polars
    Parquet,
}

impl From<QueryError> for CommandError {
    fn from(error: QueryError) -> Self {
        match error {
            QueryError::Question(message) => Self::usage(message),
            QueryError::Damaged(message) | QueryError::Table(message) => {
                Self { exit: Exit::Unreadable, message }
            }
        }
    }
}

impl TableArguments {
    /// Prints or writes the table.
    #[must_use]
    pub fn execute(&self) -> Exit {
        concluded(self.answer(), &self.standard_output, self.format == TableFormat::Json)
    }

    /// Rejects a file that cannot be written, and one with the ending of something else, such as a manifest.
    fn check_output(&self, file: &Path) -> Result<(), CommandError> {
        let ending = match self.format {
            TableFormat::Text => "txt",
            TableFormat::Csv => "csv",
            TableFormat::Json => "json",
            TableFormat::Parquet => "parquet",
        };
        if file.extension().is_none_or(|end| end != ending) {
            return Err(CommandError::usage(Message::new(
                format!("{} does not end in .{ending}", shown_path(file)),
                format!("name a file NAME.{ending}, or choose another --format"),
            )));
        }
        Ok(write_file::check(file)?)
    }

    /// The width to which the columns are limited; `None` if they are chosen, or written to a file.
    fn screen_width(&self) -> Option<usize> {
        let is_overview = self.columns.is_empty() && self.group.is_empty() && self.output.is_none();
        is_overview.then(|| terminal().width)
    }

    fn answer(&self) -> Result<Exit, CommandError> {
        let condition = self.condition.as_deref().map_or(Ok(Condition::default()), |text| {
            let help = "write comparisons such as 'temperature_k > 250, outcome = complete'";
            Condition::parse(text).map_err(|what| CommandError::usage(Message::new(what, help)))
        })?;
        self.output.as_deref().map_or(Ok(()), |file| self.check_output(file))?;
        let path = meant_paths(std::slice::from_ref(&self.path))?;
        let runs = StoredRuns::open(path.first().unwrap_or(&self.path))?;
        let (columns, group) = (self.columns.clone(), self.group.clone());
        let answered = runs.answer(&Question { columns, condition, group })?;
        let written = match self.format {
            TableFormat::Text => text(&answered, &runs, self.screen_width()).into_bytes(),
            TableFormat::Csv => csv_text(&answered).map_err(failed)?,
            TableFormat::Json => format!("{:#}\n", json(&answered)).into_bytes(),
            TableFormat::Parquet => parquet(&answered, &runs).map_err(failed)?,
        };
        match &self.output {
            Some(file) => {
                write_file::write(file, written)?;
                let rows = plural(answered.rows.len() as u64, "row");
                let line = format!("written: {} ({rows})\n", shown_path(file));
                self.standard_output.print(&line);
            }
            None if self.format == TableFormat::Json => {
                self.standard_output.print_json(&String::from_utf8_lossy(&written));
            }
            None => self.standard_output.print_exactly(&String::from_utf8_lossy(&written)),
        }
        Ok(Exit::Done)
    }
}

/// The error of a format's writer; none is expected.
fn failed(error: impl std::fmt::Display) -> CommandError {
    write_file::WriteError::new(Path::new("the table"), error).into()
}

/// Aligned columns; a value and its standard error are one column, with the unit in its head. Of limited width, numbers have six digits.
fn text(answered: &Answered, runs: &StoredRuns, screen: Option<usize>) -> String {
    let columns = &answered.columns;
    let is_error_of =
        |at: usize| at > 0 && columns[at].name == format!("{}{ERROR_SUFFIX}", columns[at - 1].name);
    // The number of runs that have a metric, if all runs of each group have it.
    let all_runs = columns.iter().position(|column| column.name == RUNS);
    let is_repeated = |at: usize| {
        let has_all = |runs: usize| answered.rows.iter().all(|row| row[at] == row[runs]);
        columns[at].name.ends_with(COUNT_SUFFIX) && all_runs.is_some_and(has_all)
    };
    let is_complete = |row: &Vec<Cell>| row.iter().any(|cell| cell.text() == "complete");
    let all_complete = answered.rows.iter().all(is_complete);
    let is_about_file = |at: usize| {
        let name = columns[at].name.as_str();
        screen.is_some() && (ABOUT_THE_FILE.contains(&name) || name == "outcome" && all_complete)
    };
    let is_shown = |at: &usize| !is_error_of(*at) && !is_repeated(*at) && !is_about_file(*at);
    let shown: Vec<usize> = (0..columns.len()).filter(is_shown).collect();
    let head = |at: &usize| match unit(&columns[*at], runs) {
        "" | "1" => columns[*at].text(),
        unit => format!("{} ({unit})", columns[*at].text()),
    };
    let cell = |row: &[Cell], at: usize| match (&row[at], row.get(at + 1)) {
        (Cell::Number(value), Some(error)) if at + 1 < columns.len() && is_error_of(at + 1) => {
            let error = if let Cell::Number(error) = error { Some(*error) } else { None };
            with_error(*value, error)
        }
        (Cell::Number(value), _) if screen.is_some() => six_digits(*value),
        (cell, _) => cell.text(),
    };
    // Names and units are those of a file.
    let heads: Vec<String> = shown.iter().map(|at| one_line(&head(at)).into_owned()).collect();
    let rows = answered.rows.iter();
    let rows: Vec<Vec<String>> = rows
        .map(|row| shown.iter().map(|at| one_line(&cell(row, *at)).into_owned()).collect())
        .collect();
    let width = |at: usize| {
        let widths = rows.iter().chain([&heads]).map(|row| row[at].chars().count());
        widths.max().unwrap_or(0)
    };
    let mut widths: Vec<usize> = (0..shown.len()).map(width).collect();
    let others = screen.map(|screen| limit(&mut widths, screen, columns.len())).unwrap_or_default();
    let line = |row: &Vec<String>| {
        let cells = row.iter().zip(&widths).map(|(text, width)| format!("{text:<width$}"));
        cells.collect::<Vec<_>>().join("  ").trim_end().to_owned() + "\n"
    };
    let lines: String = [&heads].into_iter().chain(&rows).map(line).collect();
    let left_out = match answered.left_out {
        0 => String::new(),
        number => format!("; without {} that did not end as expected", plural(number, "run")),
    };
    format!("{lines}{}{others}{left_out}\n", plural(rows.len() as u64, "row"))
}

/// Leaves out the columns that a screen has no room for, and says so.
fn limit(widths: &mut Vec<usize>, screen: usize, columns: usize) -> String {
    const BETWEEN: usize = 2;
    let ends = widths.iter().scan(0, |end, width| {
        *end += width + BETWEEN;
        Some(*end)
    });
    let fitting = ends.take_while(|end| *end <= screen + BETWEEN).count().max(1);
    widths.truncate(fitting);
    if fitting == columns {
        return String::new();
    }
    format!(
        ", {fitting} of {columns} columns: choose with --columns, or print all with --format csv"
    )
}

/// The unit of a column; empty if it has none.
fn unit<'a>(column: &Column, runs: &'a StoredRuns) -> &'a str {
    let description = &runs.description;
    let of_axis = description.coordinates.get(&column.name).map(|axis| axis.unit.as_str());
    let of_metric = || description.metrics.get(&column.name).map(|metric| metric.unit.as_str());
    of_axis.or_else(of_metric).unwrap_or_default()
}

fn csv_text(answered: &Answered) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(answered.columns.iter().map(Column::text))?;
    for row in &answered.rows {
        writer.write_record(row.iter().map(Cell::text))?;
    }
    writer.into_inner().map_err(|error| csv::Error::from(error.into_error()))
}

fn json(answered: &Answered) -> Value {
    let value = |cell: &Cell| match cell {
        Cell::Missing => Value::Null,
        Cell::Text(text) => text.as_str().into(),
        Cell::Integer(number) => (*number).into(),
        Cell::Number(number) => (*number).into(),
        Cell::Boolean(value) => (*value).into(),
    };
    let object = |row: &Vec<Cell>| {
        let names = answered.columns.iter().map(|column| column.name.clone());
        Value::Object(names.zip(row.iter().map(value)).collect::<Map<_, _>>())
    };
    Value::Array(answered.rows.iter().map(object).collect())
}

fn parquet(
    answered: &Answered,
    runs: &StoredRuns,
) -> Result<Vec<u8>, parquet::errors::ParquetError> {
    let description = serde_json::to_string(&runs.description).unwrap_or_default();
    let (columns, rows) = (&answered.columns, &answered.rows);
    let metadata = (DESCRIPTION, description.as_str());
    let read = |range: Range<usize>| Ok(&rows[range]);
    table::parquet::write(Vec::new(), columns, metadata, rows.len(), read, |rows, row, column| {
        rows[row][column].clone()
    })
}
