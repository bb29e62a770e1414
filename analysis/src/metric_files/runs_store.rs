//! Rows of runs whose recordings are not kept: from a run in memory, to `runs.parquet`, and back.

use crate::input::RUNS_TABLE;
use crate::input::UnreadableRecording;
use crate::input::recording::OpenRun;
use crate::metric_files::condition::Condition;
use crate::metric_files::run_row::RunRow;
use crate::metric_files::runs_query::{QueryError, Question, StoredRuns};
use crate::metric_files::runs_table::{DETAILS, ERROR_SUFFIX, MANIFEST, to_parquet};
use crate::run::{self, RunAnalysis, RunOptions};
use crate::table::Cell;
use crate::table::parquet::io_error;
use kinetoscope_console::Message;
use kinetoscope_files::atomic_file::NewFile;
use kinetoscope_manifest::RunManifest;
use kinetoscope_recording::reader::Recording;
use std::borrow::Cow;
use std::collections::HashSet;
use std::io;
use std::num::NonZeroUsize;
use std::ops::Range;
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

/// The row of a recording of this manifest in memory, analyzed on this thread. Its hash and its place in the sweep are those that the caller
/// knows.
///
/// # Errors
/// A recording that cannot be analyzed.
pub fn row_of_recording(
    recording: Recording,
    manifest: RunManifest,
) -> Result<RunRow, UnreadableRecording> {
    let run = OpenRun::of(recording, manifest);
    let options = RunOptions::default();
    run::analyze(&run, Vec::new(), options, NonZeroUsize::MIN).map(|found| RunRow::of(&found))
}

/// Writes the table of an experiment whose recordings are not kept. `read` returns a range of its rows, and `manifest` the canonical
/// manifest of a row.
///
/// # Errors
/// Rows that cannot be read, and a folder that cannot be written.
pub fn write_runs_table(
    folder: &Path,
    experiment: &str,
    rows: usize,
    read: &mut dyn FnMut(Range<usize>) -> io::Result<Vec<RunRow>>,
    manifest: &(dyn Fn(usize) -> String + Sync),
) -> io::Result<()> {
    let mut read = |range: Range<usize>| read(range).map(Cow::Owned);
    let file = NewFile::create(&folder.join(RUNS_TABLE))?;
    to_parquet(file, experiment, rows, &mut read, manifest).map_err(io_error)?.finish_synced()
}

/// What identifies a run in a table, and how it ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StoredOutcome {
    /// Name of the recording.
    pub file: String,
    /// The run key.
    pub run_key: String,
    /// Why the run failed; `None` for a complete one.
    pub fault: Option<String>,
}

/// Calls `each` with every run of the table in a folder that [`stored_rows`] reads.
///
/// # Errors
/// A table that cannot be read.
pub fn each_stored_outcome(
    folder: &Path,
    mut each: impl FnMut(StoredOutcome),
) -> Result<(), StoreError> {
    let Some(runs) = own_table(folder)? else { return Ok(()) };
    let names = ["file", "run_key", "outcome", "outcome_detail"].map(str::to_owned);
    runs.each_row(&names, |cells| {
        let is_fault = text(&cells[2]) == "fault";
        let fault = is_fault.then(|| text(&cells[3]));
        each(StoredOutcome { file: text(&cells[0]), run_key: text(&cells[1]), fault });
    })?;
    Ok(())
}

/// The runs of a table that meet a condition.
///
/// # Errors
/// A condition that does not fit the table, or a table that cannot be read.
pub fn stored_runs(path: &Path, condition: Option<&str>) -> Result<Vec<StoredRun>, StoreError> {
    let condition = condition.map_or(Ok(Condition::default()), |text| {
        Condition::parse(text).map_err(|what| QueryError::Question(what.into()))
    })?;
    let columns = COLUMNS_OF_RUN.map(str::to_owned).to_vec();
    let answered =
        StoredRuns::open(path)?.answer(&Question { columns, condition, group: Vec::new() })?;
    Ok(answered.rows.iter().map(|cells| stored_run(cells)).collect())
}

/// The columns of a [`StoredRun`].
const COLUMNS_OF_RUN: [&str; 5] = ["file", "run_key", "physics_version", "messages", MANIFEST];

fn stored_run(cells: &[Cell]) -> StoredRun {
    StoredRun {
        file: cells[0].text(),
        run_key: cells[1].text(),
        physics_version: integer(&cells[2]),
        messages: Some(cells[3].text()).filter(|hash| !hash.is_empty()),
        manifest: text(&cells[4]),
    }
}

/// Calls `each` with the key of every run in the table of a folder or a file.
///
/// # Errors
/// A table that cannot be read.
pub fn each_stored_key(path: &Path, mut each: impl FnMut(&str)) -> Result<(), StoreError> {
    let column = ["run_key".to_owned()];
    StoredRuns::open(path)?.each_row(&column, |cells| each(&cells[0].text()))?;
    Ok(())
}

/// The runs with these keys in the table of a folder or a file, in its order.
///
/// # Errors
/// A table that cannot be read.
pub fn stored_runs_of_keys(
    path: &Path,
    keys: &HashSet<String>,
) -> Result<Vec<StoredRun>, StoreError> {
    let mut found = Vec::new();
    StoredRuns::open(path)?.each_row(&COLUMNS_OF_RUN.map(str::to_owned), |cells| {
        found.extend(Some(stored_run(cells)).filter(|run| keys.contains(&run.run_key)));
    })?;
    Ok(found)
}

/// The rows of the table in a folder, without their places in the sweep; none without a table, or if another version of the program has
/// derived its metrics.
///
/// # Errors
/// A table that cannot be read.
pub fn stored_rows(folder: &Path) -> Result<Vec<RunRow>, StoreError> {
    let mut rows = Vec::new();
    each_stored_row(folder, |row| rows.push(row))?;
    Ok(rows)
}

/// Calls `each` with the rows of [`stored_rows`], of which only a group is in the memory.
///
/// # Errors
/// A table that cannot be read.
pub fn each_stored_row(folder: &Path, mut each: impl FnMut(RunRow)) -> Result<(), StoreError> {
    let mut model = None;
    each_row_of_cells(folder, |names, cells| {
        // All runs of an experiment have the same model.
        if model.is_none() {
            model = manifest_of(names, cells).map(|manifest| manifest.model.name());
        }
        let row = model.and_then(|model| row_of_cells(names, cells, model));
        row.into_iter().for_each(&mut each);
    })
}

/// The analyses of the runs in the table of a folder, as [`stored_rows`], without their coordinates.
///
/// # Errors
/// A table that cannot be read.
pub(crate) fn stored_analyses(folder: &Path) -> Result<Vec<RunAnalysis>, StoreError> {
    let mut runs = Vec::new();
    each_row_of_cells(folder, |names, cells| {
        let analyzed = manifest_of(names, cells).and_then(|manifest| {
            row_of_cells(names, cells, manifest.model.name())?.analysis(manifest)
        });
        runs.extend(analyzed);
    })?;
    Ok(runs)
}

/// The table in a folder, if this version of the program has derived its metrics.
fn own_table(folder: &Path) -> Result<Option<StoredRuns>, StoreError> {
    if !folder.join(RUNS_TABLE).exists() {
        return Ok(None);
    }
    let runs = StoredRuns::open(folder)?;
    Ok(Some(runs).filter(|it| it.description.analysis_version == env!("CARGO_PKG_VERSION")))
}

fn each_row_of_cells(
    folder: &Path,
    mut each: impl FnMut(&[&str], &[Cell]),
) -> Result<(), StoreError> {
    let Some(runs) = own_table(folder)? else { return Ok(()) };
    let columns = runs.columns();
    let names: Vec<&str> = columns.iter().map(String::as_str).collect();
    runs.each_row(&columns, |cells| each(&names, cells))?;
    Ok(())
}

fn cell_of<'a>(names: &[&str], cells: &'a [Cell], name: &str) -> Option<&'a Cell> {
    names.iter().position(|known| *known == name).map(|at| &cells[at])
}

/// The manifest in these cells; `None` if they are not those of a run of this program.
fn manifest_of(names: &[&str], cells: &[Cell]) -> Option<RunManifest> {
    kinetoscope_manifest::parse_run(&text(cell_of(names, cells, MANIFEST)?)).ok()
}

/// The row with these cells; `None` if they are not those of a run of this program.
fn row_of_cells(names: &[&str], cells: &[Cell], model: &str) -> Option<RunRow> {
    let cell = |name: &str| cell_of(names, cells, name);
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
        ..RunRow::of_values(model, |metric| {
            cell(metric)?;
            Some([number(metric), number(&format!("{metric}{ERROR_SUFFIX}"))])
        })
    };
    row.details().is_some().then_some(row)
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
