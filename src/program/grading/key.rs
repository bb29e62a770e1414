//! The key of an exercise: which runs are expected, and which metric of theirs answers the question.

use crate::grading::answer::Answer;
use crate::messages::{Failure, bad};
use kinetoscope_console::text::{one_line, shown_path};
use kinetoscope_files::regular_file::read_text;
use kinetoscope_manifest::{Experiment, parse};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use toml::{Table, Value};

/// Maximum size of a key and of a solution, bytes.
const MOST_BYTES: u64 = 16 << 10;
/// Keys of a manifest that each student may choose.
const FREE: [&str; 3] = ["seed", "replicate", "record."];

/// How the metric of the runs becomes one number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Combination {
    /// The mean over all runs.
    Mean,
    /// That at the last point of the sweep over that at the first.
    Ratio,
    /// The exponent of a power law of the swept key through first and last point.
    Exponent,
}

/// How near the stated value must be.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Tolerance {
    /// A fraction of the value.
    Relative(f64),
    /// Combined standard errors.
    StandardErrors(f64),
}

/// A wrong answer that is known.
#[derive(Clone, Debug)]
pub(crate) struct WrongAnswer {
    /// Factor of the right value.
    pub(crate) factor: Option<f64>,
    /// Another metric of the same runs.
    pub(crate) metric: Option<String>,
    /// What leads to it.
    pub(crate) hint: String,
}

/// The key of an exercise.
#[derive(Clone, Debug)]
pub(crate) struct Key {
    pub(crate) metric: String,
    pub(crate) combination: Combination,
    pub(crate) tolerance: Tolerance,
    /// Largest standard error, as a fraction of the value, that still answers the question.
    pub(crate) max_relative_error: Option<f64>,
    /// Fewest replicates.
    pub(crate) min_replicates: usize,
    /// A value that a check of the answer must reject.
    pub(crate) check_rejects: Option<f64>,
    /// Accepted units, and the factor from each to that of the metric.
    pub(crate) units: Vec<(String, f64)>,
    pub(crate) wrong: Vec<WrongAnswer>,
    /// Further keys of the manifest that each student may choose.
    free: Vec<String>,
    /// The manifest of the solution.
    pub(crate) solution: Experiment,
    /// The canonical texts of its points, without free keys.
    points: Vec<Vec<(String, String)>>,
    /// The work of its runs, once it is computed.
    pub(crate) work: OnceLock<f64>,
}

/// The folder of solutions that belongs to an exercise: `solutions` next to a folder above it.
fn solutions_of(answer: &Path) -> Option<PathBuf> {
    let path = answer.canonicalize().ok()?;
    path.ancestors().skip(1).take(4).map(|folder| folder.join("solutions")).find(|it| it.is_dir())
}

/// Rejects a lesson without keys.
pub(crate) fn check_lesson(
    lesson: &str,
    solutions: Option<&Path>,
    hand_ins: &[PathBuf],
) -> Result<(), Failure> {
    let above = || hand_ins.iter().find_map(|path| solutions_of(path));
    let is_name = !lesson.is_empty() && lesson.chars().all(|c| c.is_alphanumeric() || c == '_');
    match solutions.map(Path::to_owned).or_else(above) {
        Some(folder) if !is_name || !folder.join(lesson).is_dir() => {
            let what = format!("{} has no lesson {}", shown_path(&folder), one_line(lesson));
            Err(bad(what).help("name a lesson with --lesson, such as gas_pressure"))
        }
        _ => Ok(()),
    }
}

impl Key {
    /// Finds and reads the key of an answer.
    pub(crate) fn of(answer: &Answer, solutions: Option<&Path>) -> Result<Self, Failure> {
        let found = solutions.map(Path::to_owned).or_else(|| solutions_of(&answer.path));
        let name = &answer.name;
        let missing = || {
            bad(format!("the key of the exercise {name} is missing")).help(
                "name the folder of the solutions with --solutions DIR; without it, --hand-in FILE writes what your teacher grades",
            )
        };
        let folder = found.ok_or_else(missing)?;
        let path = folder.join(format!("{name}.key.toml"));
        if !path.is_file() {
            return Err(missing());
        }
        Self::read(&path, &folder.join(format!("{name}.toml")))
    }

    fn read(path: &Path, solution: &Path) -> Result<Self, Failure> {
        let of_file = |path: &Path, what: String| {
            bad(format!("{}: {what}", shown_path(path))).help("correct the key of the exercise")
        };
        let text = |path: &Path| {
            read_text(path, MOST_BYTES).map_err(|error| of_file(path, error.to_string()))
        };
        let table: Table = text(path)?
            .parse()
            .map_err(|error: toml::de::Error| of_file(path, error.message().to_owned()))?;
        let solved = text(solution)?;
        let experiment = parse(&solved, &solution.to_string_lossy(), &[])
            .map_err(|errors| of_file(solution, errors.render(false)))?;
        let mut key = Self::of_table(&table, experiment).ok_or_else(|| {
            let what =
                "needs metric, units, and relative_tolerance or standard_errors, each of its type";
            of_file(path, what.to_owned())
        })?;
        key.points = key.points_of(&key.solution);
        Ok(key)
    }

    fn of_table(table: &Table, solution: Experiment) -> Option<Self> {
        let number = |name: &str| table.get(name).and_then(of_number);
        let tolerance = match (number("relative_tolerance"), number("standard_errors")) {
            (Some(fraction), None) => Tolerance::Relative(fraction),
            (None, Some(errors)) => Tolerance::StandardErrors(errors),
            _ => return None,
        };
        let combination = match table.get("combination").map_or(Some("mean"), Value::as_str)? {
            "mean" => Combination::Mean,
            "ratio" => Combination::Ratio,
            "exponent" => Combination::Exponent,
            _ => return None,
        };
        let units = table.get("units")?.as_table()?.iter();
        let units = units.map(|(unit, factor)| Some((unit.clone(), of_number(factor)?)));
        let list =
            |name: &str| table.get(name).and_then(Value::as_array).cloned().unwrap_or_default();
        let wrong = list("wrong").into_iter().map(|wrong| {
            Some(WrongAnswer {
                factor: wrong.get("factor").and_then(of_number),
                metric: wrong.get("metric").and_then(Value::as_str).map(str::to_owned),
                hint: wrong.get("hint")?.as_str()?.to_owned(),
            })
        });
        Some(Self {
            metric: table.get("metric")?.as_str()?.to_owned(),
            combination,
            tolerance,
            max_relative_error: number("max_relative_error"),
            min_replicates: number("min_replicates").map_or(1, |count| count as usize),
            check_rejects: number("check_rejects"),
            units: units.collect::<Option<_>>()?,
            wrong: wrong.collect::<Option<_>>()?,
            free: list("free").iter().filter_map(Value::as_str).map(str::to_owned).collect(),
            solution,
            points: Vec::new(),
            work: OnceLock::new(),
        })
    }

    /// The points of an experiment without the keys that each student may choose.
    fn points_of(&self, experiment: &Experiment) -> Vec<Vec<(String, String)>> {
        let is_free = |key: &str| {
            FREE.iter().any(|free| key.starts_with(free))
                || self.free.iter().any(|free| key == free)
        };
        let mut points: Vec<Vec<(String, String)>> = Vec::new();
        for run in &experiment.runs {
            let mut values = kinetoscope_manifest::manifest_values(&run.manifest.canonical());
            values.retain(|(key, _)| !is_free(key));
            if !points.contains(&values) {
                points.push(values);
            }
        }
        points
    }

    /// The keys in which the manifest of an answer differs from that of the exercise; empty if it does not.
    pub(crate) fn other_keys(&self, experiment: &Experiment) -> Vec<String> {
        let points = self.points_of(experiment);
        if points == self.points {
            return Vec::new();
        }
        let mut keys = Vec::new();
        for (found, expected) in points.iter().zip(&self.points) {
            for difference in kinetoscope_manifest::differing_values(found.clone(), expected) {
                if !keys.contains(&difference.key) {
                    keys.push(difference.key);
                }
            }
        }
        if points.len() != self.points.len() {
            keys.push("sweep".to_owned());
        }
        keys
    }
}

fn of_number(value: &Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|integer| integer as f64))
}
