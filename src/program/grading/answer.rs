//! A completed exercise: a manifest with the stated answer.

use crate::messages::exit::unread;
use crate::messages::{Failure, bad, has_colors};
use kinetoscope_analysis::metric_names;
use kinetoscope_console::Exit;
use kinetoscope_console::text::shown_path;
use kinetoscope_files::regular_file::read_text;
use kinetoscope_manifest::{Exercise, Experiment, Lookup, Override, parse_with};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Maximum size of an exercise, bytes.
const MOST_BYTES: u64 = 16 << 10;
/// Maximum size of a hand-in, bytes.
pub(crate) const MOST_HAND_IN_BYTES: u64 = 1024;

/// A completed exercise.
#[derive(Debug)]
pub(crate) struct Answer {
    /// The file.
    pub(crate) path: PathBuf,
    /// Its text.
    pub(crate) text: String,
    /// The manifest.
    pub(crate) experiment: Experiment,
    /// Lesson and name of the exercise.
    pub(crate) name: String,
    pub(crate) value: f64,
    pub(crate) unit: String,
    pub(crate) standard_error: f64,
    /// The hash of a hand-in.
    pub(crate) hash: Option<String>,
}

impl Answer {
    /// Reads a completed exercise.
    pub(crate) fn read(path: &Path) -> Result<Self, Failure> {
        Self::of(path, MOST_BYTES)
    }

    /// Reads a hand-in, which has a hash unless it was written in a browser.
    pub(crate) fn read_hand_in(path: &Path) -> Result<Self, Failure> {
        Self::of(path, MOST_HAND_IN_BYTES)
    }

    fn of(path: &Path, most_bytes: u64) -> Result<Self, Failure> {
        let text = read_text(path, most_bytes).map_err(|error| {
            let reason = match error.kind() {
                ErrorKind::FileTooLarge => format!("it is larger than {most_bytes} bytes"),
                _ => error.to_string(),
            };
            let what = format!("cannot read {}: {reason}", shown_path(path));
            unread(&error, what, "name a completed exercise (*.toml)")
        })?;
        let origin = path.to_string_lossy();
        let lookup = Lookup { metrics: Some(metric_names), ..Lookup::default() };
        // Whatever the file is called.
        let name = Override { key: "name".to_owned(), value: "\"exercise\"".to_owned() };
        let mut experiment = parse_with(&text, &origin, &[name], lookup)
            .map_err(|errors| Failure::rendered(Exit::BadInput, errors.render(has_colors())))?;
        let Some(exercise) = experiment.exercise.take() else {
            return Err(bad(format!("{} has no table [exercise]", shown_path(path)))
                .help("name a completed exercise: a manifest with the answer in [exercise]"));
        };
        if experiment.runs.iter().any(|run| run.manifest.model.start_from().is_some()) {
            return Err(bad("`start_from` names another file, and an answer consists of one")
                .at(&shown_path(path))
                .help("leave `start_from` out, and use the start of the exercise"));
        }
        let missing = |key: &str| {
            bad(format!("the answer is not complete: `exercise.{key}` is missing"))
                .at(&shown_path(path))
                .help("state value, unit and standard_error in [exercise]")
        };
        let Exercise { name, value, unit, standard_error, hash } = exercise;
        Ok(Self {
            value: value.ok_or_else(|| missing("value"))?.get(),
            unit: unit.ok_or_else(|| missing("unit"))?.replace(char::is_whitespace, ""),
            standard_error: standard_error.ok_or_else(|| missing("standard_error"))?.get(),
            path: path.to_owned(),
            text,
            experiment,
            name,
            hash,
        })
    }

    /// The lesson of the exercise.
    pub(crate) fn lesson(&self) -> &str {
        self.name.split_once('/').map_or("", |(lesson, _)| lesson)
    }
}
