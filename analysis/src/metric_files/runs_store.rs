//! Rows of runs whose recordings are not kept: from a run in memory, to `runs.parquet`, and back.

use crate::input::RUNS_TABLE;
use crate::input::UnreadableRecording;
use crate::input::recording::opened;
use crate::metric_files::condition::Condition;
use crate::metric_files::run_row::RunRow;
use crate::metric_files::runs_query::{Answered, QueryError, Question, StoredRuns};
use crate::metric_files::runs_table::{DETAILS, ERROR_SUFFIX, MANIFEST, to_parquet};
use crate::run::{self, RunAnalysis, RunOptions};
use crate::table::Cell;
use kinetoscope_console::Message;
use kinetoscope_files::atomic_file;
use kinetoscope_manifest::RunManifest;
use kinetoscope_recording::reader::Recording;
use std::io;
use std::num::NonZeroUsize;
use std::path::Path;

/// A run in a table, as far as its recording follows from it.
#[derive(Clone, Debug)]
pub struct StoredRun {
    /// Name of the recording.
    pub file: String,
    /// The run key.
    pub run_key: String,
    /// Version of the model's physics.
    pub physics_version: i64,
    /// The hash of all messages, if it is known.
    pub messages: Option<String>,
    /// The canonical manifest.
    pub manifest: String,
}

/// Why a table gives no runs.
#[derive(Clone, Debug)]
pub struct StoreError {
    /// The reason, with the user's next step.
    pub message: Message,
    /// Whether the condition is the reason.
    pub is_of_question: bool,
    /// Whether the reason is a table whose bytes are not those that were written.
    pub is_of_damage: bool,
}

impl From<QueryError> for StoreError {
    fn from(error: QueryError) -> Self {
        let is_of_question = matches!(error, QueryError::Question(_));
        let is_of_damage = matches!(error, QueryError::Damaged(_));
        let (QueryError::Question(message)
        | QueryError::Damaged(message)
        | QueryError::Table(message)) = error;
        Self { message, is_of_question, is_of_damage }
    }
}

/// The row of a recording in memory, analyzed on this thread. Its hash and its place in the sweep are those that the caller knows.
///
/// # Errors
/// A recording that cannot be analyzed.
pub fn row_of_recording(recording: &Recording) -> Result<RunRow, UnreadableRecording> {
    let run = opened(recording.clone())?;
    let options = RunOptions::default();
    run::analyze(&run, Vec::new(), options, NonZeroUsize::MIN).map(|found| RunRow::of(&found))
}

/// Writes the table of an experiment whose recordings are not kept.
///
/// # Errors
/// A folder that cannot be written.
pub fn write_runs_table(
    folder: &Path,
    experiment: &str,
    rows: &[RunRow],
    manifest: &dyn Fn(usize) -> String,
) -> io::Result<()> {
    let table = to_parquet(experiment, rows, manifest).map_err(io::Error::other)?;
    atomic_file::replace(&folder.join(RUNS_TABLE), &table)
}

/// The runs of a table that meet a condition.
///
/// # Errors
/// A condition that does not fit the table, or a table that cannot be read.
pub fn stored_runs(path: &Path, condition: Option<&str>) -> Result<Vec<StoredRun>, StoreError> {
    let condition = condition.map_or(Ok(Condition::default()), |text| {
        Condition::parse(text).map_err(|what| QueryError::Question(what.into()))
    })?;
    let names = ["file", "run_key", "physics_version", "messages", MANIFEST];
    let columns = names.map(str::to_owned).to_vec();
    let answered =
        StoredRuns::open(path)?.answer(&Question { columns, condition, group: Vec::new() })?;
    let run = |cells: &Vec<Cell>| StoredRun {
        file: cells[0].text(),
        run_key: cells[1].text(),
        physics_version: integer(&cells[2]),
        messages: Some(cells[3].text()).filter(|hash| !hash.is_empty()),
        manifest: text(&cells[4]),
    };
    Ok(answered.rows.iter().map(run).collect())
}

/// The rows of the table in a folder, without their places in the sweep; none without a table, or if another version of the program has
/// derived its metrics.
///
/// # Errors
/// A table that cannot be read.
pub fn stored_rows(folder: &Path) -> Result<Vec<RunRow>, StoreError> {
    read_rows(folder).map(|rows| rows.into_iter().map(|(row, _)| row).collect())
}

/// The analyses of the runs in the table of a folder, as [`stored_rows`], without their coordinates.
///
/// # Errors
/// A table that cannot be read.
pub(crate) fn stored_analyses(folder: &Path) -> Result<Vec<RunAnalysis>, StoreError> {
    let analyzed = |(row, manifest): (RunRow, RunManifest)| row.analysis(manifest);
    read_rows(folder).map(|rows| rows.into_iter().filter_map(analyzed).collect())
}

fn read_rows(folder: &Path) -> Result<Vec<(RunRow, RunManifest)>, StoreError> {
    if !folder.join(RUNS_TABLE).exists() {
        return Ok(Vec::new());
    }
    let runs = StoredRuns::open(folder)?;
    if runs.description.analysis_version != env!("CARGO_PKG_VERSION") {
        return Ok(Vec::new());
    }
    let columns = runs.columns();
    let Answered { columns, rows, .. } =
        runs.answer(&Question { columns, ..Question::default() })?;
    let names: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
    Ok(rows.iter().filter_map(|cells| row_of_cells(&names, cells)).collect())
}

/// The row with these cells; `None` if they are not those of a run of this program.
fn row_of_cells(names: &[&str], cells: &[Cell]) -> Option<(RunRow, RunManifest)> {
    let cell = |name: &str| names.iter().position(|known| *known == name).map(|at| &cells[at]);
    let manifest = kinetoscope_manifest::parse_run(&text(cell(MANIFEST)?)).ok()?;
    let number = |name: &str| match cell(name) {
        Some(Cell::Number(number)) => *number,
        _ => f64::NAN,
    };
    let detail = text(cell("outcome_detail")?);
    let messages = bytes(&text(cell("messages")?));
    let row = RunRow {
        file: text(cell("file")?),
        run_key: text(cell("run_key")?),
        messages: messages.and_then(|bytes| bytes.try_into().ok()),
        program_version: text(cell("program_version")?),
        physics_version: u32::try_from(integer(cell("physics_version")?)).ok()?,
        outcome: text(cell("outcome")?),
        outcome_detail: Some(detail).filter(|detail| !detail.is_empty()),
        frames: u64::try_from(integer(cell("frames")?)).ok()?,
        end_time: number("end_time"),
        details: bytes(&text(cell(DETAILS)?))?,
        ..RunRow::of_values(manifest.model.name(), |metric| {
            cell(metric)?;
            Some([number(metric), number(&format!("{metric}{ERROR_SUFFIX}"))])
        })
    };
    row.details().map(|_| (row, manifest))
}

/// The bytes with these hexadecimal digits.
fn bytes(digits: &str) -> Option<Vec<u8>> {
    let byte = |at: usize| u8::from_str_radix(digits.get(at..at + 2)?, 16).ok();
    (0..digits.len()).step_by(2).map(byte).collect()
}

fn integer(cell: &Cell) -> i64 {
    if let Cell::Integer(number) = cell { *number } else { 0 }
}

/// A text as it was stored.
fn text(cell: &Cell) -> String {
    if let Cell::Text(text) = cell { text.clone() } else { String::new() }
}
