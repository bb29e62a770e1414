//! Questions to `runs.parquet`: chosen columns of the rows that meet a condition, or means over groups of runs.

use crate::input::RUNS_TABLE;
use crate::metric_files::condition::{BoundComparison, Condition, nearest_column};
use crate::metric_files::runs_table::{
    DESCRIPTION, DETAILS, ERROR_SUFFIX, MANIFEST, RUNS_SCHEMA, RunsDescription,
};
use crate::statistics::mean_of_independent;
use crate::table::parquet_reader::ParquetReader;
use crate::table::{Cell, CellKind, Column};
use kinetoscope_console::Message;
use kinetoscope_console::text::shown_path;
use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

/// The column of a grouped table with the number of runs.
pub(crate) const RUNS: &str = "runs";
/// The end of the name of a column with the number of runs that have a metric, after that of the metric.
pub(crate) const COUNT_SUFFIX: &str = ".runs";

/// Why a question has no answer.
pub(crate) enum QueryError {
    /// The question does not fit the table.
    Question(Message),
    /// The bytes of the table are not those that were written.
    Damaged(Message),
    /// The table cannot be read.
    Table(Message),
}

/// The next step after a table that cannot be read.
const WRITE_AGAIN: &str =
    "write it again: analyze its recordings, or run its manifest if that has `keep = \"metrics\"`";

/// The table of an experiment.
pub(crate) struct StoredRuns {
    path: PathBuf,
    reader: ParquetReader,
    pub(crate) description: RunsDescription,
}

/// The rows that answer a question.
#[derive(Debug)]
pub(crate) struct Answered {
    pub(crate) columns: Vec<Column>,
    pub(crate) rows: Vec<Vec<Cell>>,
    /// Runs that meet the condition, but are not complete, so that they are in no group.
    pub(crate) left_out: u64,
}

/// A question: columns (all that are not standard errors if there are none), a condition, and the columns that define groups.
#[derive(Clone, Debug, Default)]
pub(crate) struct Question {
    pub(crate) columns: Vec<String>,
    pub(crate) condition: Condition,
    pub(crate) group: Vec<String>,
}

/// The cells of a group's keys, the number of its runs, and for each metric its values and the error of the last one.
type Group = (Vec<Cell>, u64, Vec<(Vec<f64>, Cell)>);

/// A column of a table and the number that it has there.
type Place = (usize, Column);

impl StoredRuns {
    /// Opens the table in the folder of an experiment, or the file.
    ///
    /// # Errors
    /// No such file, or one that is not a whole table of this version.
    pub(crate) fn open(path: &Path) -> Result<Self, QueryError> {
        let path = if path.is_dir() { path.join(RUNS_TABLE) } else { path.to_path_buf() };
        let shown = shown_path(&path);
        let failed = |what: String| QueryError::Table(Message::new(what, WRITE_AGAIN));
        let reader = ParquetReader::open(&path).map_err(|error| match error.kind() {
            io::ErrorKind::NotFound => failed(format!("{shown} does not exist")),
            io::ErrorKind::InvalidData => damaged(&path, &error),
            _ => failed(format!("{shown} cannot be read: {error}")),
        })?;
        let description = reader.entry(DESCRIPTION).unwrap_or_default();
        let Ok(description) = serde_json::from_str::<RunsDescription>(description) else {
            return Err(failed(format!("{shown} is not a table of runs of this program")));
        };
        if description.schema != RUNS_SCHEMA {
            let (found, read) = (description.schema, RUNS_SCHEMA);
            return Err(failed(format!("{shown} has schema {found}, this version reads {read}")));
        }
        Ok(Self { path, reader, description })
    }

    /// The names of all columns.
    pub(crate) fn columns(&self) -> Vec<String> {
        self.reader.columns.iter().map(|column| column.name.clone()).collect()
    }

    /// Answers a question.
    ///
    /// # Errors
    /// Unknown columns, and a table that cannot be read.
    pub(crate) fn answer(&self, question: &Question) -> Result<Answered, QueryError> {
        let bound = question.condition.bound(&self.reader.columns);
        let comparisons = bound.map_err(QueryError::Question)?;
        if question.group.is_empty() {
            self.listed(question, &comparisons)
        } else {
            self.grouped(question, &comparisons)
        }
    }

    /// Calls `each` with the cells of these columns in every row.
    ///
    /// # Errors
    /// Unknown columns, and a table that cannot be read.
    pub(crate) fn each_row(
        &self,
        columns: &[String],
        mut each: impl FnMut(&[Cell]),
    ) -> Result<(), QueryError> {
        let places = self.places(columns)?;
        for group in 0..self.reader.groups() {
            let columns: Vec<Vec<Cell>> =
                places.iter().map(|place| self.cells(group, place.0)).collect::<Result<_, _>>()?;
            let mut columns: Vec<_> = columns.into_iter().map(Vec::into_iter).collect();
            for _ in 0..self.reader.rows(group) {
                let row: Vec<Cell> = columns.iter_mut().filter_map(Iterator::next).collect();
                each(&row);
            }
        }
        Ok(())
    }

    /// The chosen columns of the rows that meet the condition.
    fn listed(
        &self,
        question: &Question,
        comparisons: &[BoundComparison],
    ) -> Result<Answered, QueryError> {
        let is_default = |column: &&Column| {
            let name = column.name.as_str();
            !name.ends_with(ERROR_SUFFIX) && ![MANIFEST, DETAILS].contains(&name)
        };
        let default = self.reader.columns.iter().filter(is_default);
        let chosen = match question.columns.as_slice() {
            [] => default.map(|column| column.name.clone()).collect(),
            chosen => chosen.to_vec(),
        };
        let places = self.places(&chosen)?;
        let mut rows = Vec::new();
        for group in 0..self.reader.groups() {
            let selected = self.selected(group, comparisons)?;
            let columns: Vec<Vec<Cell>> =
                places.iter().map(|place| self.cells(group, place.0)).collect::<Result<_, _>>()?;
            rows.extend(
                selected.into_iter().map(|row| {
                    columns.iter().map(|cells| cells[row].clone()).collect::<Vec<Cell>>()
                }),
            );
        }
        let columns = places.into_iter().map(|(_, column)| column).collect();
        Ok(Answered { columns, rows, left_out: 0 })
    }

    /// Means over the complete runs of each group that meet the condition, with their standard errors and the number of runs that have
    /// the metric, in the order of the table. The error of a single run is its own.
    fn grouped(
        &self,
        question: &Question,
        comparisons: &[BoundComparison],
    ) -> Result<Answered, QueryError> {
        let keys = self.places(&question.group)?;
        let metrics = self.metrics(question)?;
        let outcome = self.places(&["outcome".to_owned()])?[0].0;
        let mut index: BTreeMap<Vec<String>, usize> = BTreeMap::new();
        let mut groups: Vec<Group> = Vec::new();
        let mut left_out = 0;
        for group in 0..self.reader.groups() {
            let outcomes = self.cells(group, outcome)?;
            let selected = self.selected(group, comparisons)?.into_iter();
            let (selected, others): (Vec<usize>, Vec<usize>) =
                selected.partition(|row| outcomes[*row] == Cell::from("complete"));
            left_out += others.len() as u64;
            let of_keys: Vec<Vec<Cell>> =
                keys.iter().map(|place| self.cells(group, place.0)).collect::<Result<_, _>>()?;
            let place_of = |row: &usize| {
                let cells: Vec<Cell> = of_keys.iter().map(|cells| cells[*row].clone()).collect();
                let place = index.entry(cells.iter().map(Cell::text).collect());
                *place.or_insert_with(|| {
                    groups.push((cells, 0, vec![(Vec::new(), Cell::Missing); metrics.len()]));
                    groups.len() - 1
                })
            };
            let places: Vec<usize> = selected.iter().map(place_of).collect();
            places.iter().for_each(|place| groups[*place].1 += 1);
            for (metric, [value, error]) in metrics.iter().enumerate() {
                let [values, errors] = [self.cells(group, value.0)?, self.cells(group, error.0)?];
                for (row, place) in selected.iter().zip(&places) {
                    if let Cell::Number(number) = values[*row] {
                        let (numbers, last) = &mut groups[*place].2[metric];
                        numbers.push(number);
                        *last = errors[*row].clone();
                    }
                }
            }
        }
        let of_metrics = metrics.into_iter().flat_map(|[(_, value), (_, error)]| {
            let count = Column::new(format!("{}{COUNT_SUFFIX}", value.name), CellKind::Integer);
            [value, error, count]
        });
        let keys = keys.into_iter().map(|(_, column)| column);
        let columns = keys.chain([Column::new(RUNS, CellKind::Integer)]).chain(of_metrics);
        let rows = groups.into_iter().map(|(mut cells, runs, metrics)| {
            cells.push(runs.into());
            for (values, error) in metrics {
                let mean = mean_of_independent(&values);
                cells.push(mean.map(|mean| mean.value).into());
                cells.push(match values.len() {
                    1 => error,
                    _ => mean.and_then(|mean| mean.standard_error).into(),
                });
                cells.push((values.len() as u64).into());
            }
            cells
        });
        Ok(Answered { columns: columns.collect(), rows: rows.collect(), left_out })
    }

    /// The columns of values and errors of the metrics to be averaged.
    fn metrics(&self, question: &Question) -> Result<Vec<[Place; 2]>, QueryError> {
        let is_metric = |name: &str| self.description.metrics.contains_key(name);
        let known = self.reader.columns.iter().map(|column| column.name.clone());
        let names: Vec<String> = match question.columns.as_slice() {
            [] => known.filter(|name| is_metric(name)).collect(),
            chosen => {
                let chosen = chosen.iter().filter(|name| !question.group.contains(name));
                chosen.cloned().collect()
            }
        };
        self.places(&names)?;
        if let Some(other) = names.iter().find(|name| !is_metric(name)) {
            return Err(QueryError::Question(Message::new(
                format!("`{other}` is not a metric, so it has no mean"),
                format!("name it in --group as well, or leave it out of --columns: {other}"),
            )));
        }
        let pair = |name: &String| {
            let both = self.places(&[name.clone(), format!("{name}{ERROR_SUFFIX}")])?;
            <[Place; 2]>::try_from(both).map_err(|_| {
                QueryError::Table(Message::from(format!("`{name}` has no column of errors")))
            })
        };
        names.iter().map(pair).collect()
    }

    /// The columns with these names.
    fn places(&self, names: &[String]) -> Result<Vec<Place>, QueryError> {
        let columns = &self.reader.columns;
        let place = |name: &String| {
            let found = columns.iter().position(|column| column.name == *name);
            found.map(|at| (at, columns[at].clone())).ok_or_else(|| {
                let what = format!("`{name}` is no column of {}", shown_path(&self.path));
                QueryError::Question(Message::new(what, nearest_column(name, columns)))
            })
        };
        names.iter().map(place).collect()
    }

    /// The rows of a row group that meet the comparisons.
    fn selected(
        &self,
        group: usize,
        comparisons: &[BoundComparison],
    ) -> Result<Vec<usize>, QueryError> {
        let mut rows: Vec<usize> = (0..self.reader.rows(group)).collect();
        for comparison in comparisons {
            let cells = self.cells(group, comparison.column)?;
            rows.retain(|row| comparison.holds(&cells[*row]));
        }
        Ok(rows)
    }

    fn cells(&self, group: usize, column: usize) -> Result<Vec<Cell>, QueryError> {
        self.reader.cells(group, column).map_err(|error| damaged(&self.path, &error))
    }
}

fn damaged(path: &Path, why: &io::Error) -> QueryError {
    let what = format!("{} is not a whole table of runs: {why}", shown_path(path));
    QueryError::Damaged(Message::new(what, WRITE_AGAIN))
}
