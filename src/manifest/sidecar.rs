//! `experiment.toml`, which lies beside the recordings: what analysis needs to know of the whole experiment.

use crate::canonical::RunKey;
use crate::checks::{self, Check};
use crate::diagnostics::{Diagnostic, Diagnostics};
use crate::experiment::{Experiment, parse_toml};
use crate::keys::{Keys, Reader, Writer};
use crate::model::ModelConfig;
use crate::sweep::{Axis, Coordinate};
use crate::tree::{Node, Table, Value};
use crate::value::{TomlValue, quoted, refuse};

/// What was run: which file belongs to which point, and what must hold.
#[derive(Clone, Debug, PartialEq)]
pub struct ExperimentRecord {
    /// Name of the experiment.
    pub name: String,
    /// What it is about; may be empty.
    pub description: String,
    /// Name of the model.
    pub model: String,
    /// Number of replicates at each point.
    pub replicates: u32,
    /// The sweep's axes.
    pub axes: Vec<Axis>,
    /// All runs; a recording in the folder that is not among them is stale.
    pub runs: Vec<RunRecord>,
    /// What analysis must find.
    pub checks: Vec<Check>,
}

/// One run and its file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RunRecord {
    /// Name of the recording within the folder.
    pub file: String,
    /// Its run key.
    pub run_key: RunKey,
    /// Where it lies in the sweep.
    pub coordinates: Vec<Coordinate>,
    /// Number of the replicate, from 0.
    pub replicate: u32,
}

impl ExperimentRecord {
    /// The record of an experiment whose runs have these files, in the order of [`Experiment::runs`].
    #[must_use]
    pub fn new(experiment: &Experiment, files: impl IntoIterator<Item = (String, RunKey)>) -> Self {
        let runs = experiment.runs.iter().zip(files).map(|(run, (file, run_key))| RunRecord {
            file,
            run_key,
            coordinates: run.coordinates.clone(),
            replicate: run.replicate,
        });
        Self {
            name: experiment.name.clone(),
            description: experiment.description.clone(),
            model: experiment.model().to_owned(),
            replicates: experiment.replicates,
            axes: experiment.axes.clone(),
            runs: runs.collect(),
            checks: experiment.checks.clone(),
        }
    }

    /// The text of `experiment.toml`.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let mut writer = Writer::default();
        writer
            .text
            .push_str("# Written by run-experiment: what the recordings in this folder are.\n");
        self.clone().keys(&mut writer);
        for axis in &self.axes {
            writer.text.push_str("\n[[axes]]\n");
            AxisKeys::of(axis).keys(&mut writer);
        }
        for run in &self.runs {
            writer.text.push_str("\n[[runs]]\n");
            RunKeys::of(run).keys(&mut writer);
        }
        checks::write(&self.checks, &mut writer);
        writer.text
    }

    /// Reads the text of an `experiment.toml`.
    ///
    /// # Errors
    /// Everything that is wrong with the text.
    pub fn from_toml(text: &str, origin: &str) -> Result<Self, Diagnostics> {
        let mut diagnostics = Diagnostics::default();
        let (root, syntax) = parse_toml(text, origin, &mut diagnostics);
        let mut errors = syntax.errors;
        let mut record = Self {
            name: String::new(),
            description: String::new(),
            model: String::new(),
            replicates: 1,
            axes: Vec::new(),
            runs: Vec::new(),
            checks: Vec::new(),
        };
        let mut reader = Reader::new("", &root, &mut errors);
        record.keys(&mut reader);
        reader.also_known(&["axes", "runs", "checks"]);
        if ModelConfig::with_defaults(&record.model).is_none() {
            reader.report(Diagnostic::new(format!("{origin} names no known model")));
        }
        reader.finish();
        for_each(&root, "axes", &mut errors, |reader| {
            let mut axis = AxisKeys::default();
            axis.keys(reader);
            record.axes.push(Axis { keys: axis.keys, values: axis.values });
        });
        for_each(&root, "runs", &mut errors, |reader| {
            let mut run = RunKeys::default();
            run.keys(reader);
            record.runs.extend(run.into_record(reader));
        });
        if let Some(entry) = root.get("checks") {
            record.checks = checks::read(&entry.node, None, &mut errors);
        }
        let diagnostics = diagnostics.with(errors);
        if diagnostics.is_empty() { Ok(record) } else { Err(diagnostics) }
    }

    fn keys(&mut self, keys: &mut impl Keys) {
        keys.key("name", "", "", &mut self.name);
        keys.key("description", "", "", &mut self.description);
        keys.key("model", "", "", &mut self.model);
        keys.key("replicates", "1", "", &mut self.replicates);
    }
}

/// Reads each table of an array of tables.
fn for_each(
    root: &Table,
    key: &str,
    errors: &mut Vec<Diagnostic>,
    mut read: impl FnMut(&mut Reader<'_>),
) {
    let Some(entry) = root.get(key) else { return };
    let Value::Array(elements) = &entry.node.value else {
        refuse(&entry.node, key, "an array of tables", errors);
        return;
    };
    for element in elements.iter() {
        let Some(table) = element.table() else {
            refuse(element, key, "a table", errors);
            continue;
        };
        let mut reader = Reader::new(key, table, errors);
        read(&mut reader);
        reader.finish();
    }
}

#[derive(Default)]
struct AxisKeys {
    keys: Vec<String>,
    values: Vec<Vec<String>>,
}

impl AxisKeys {
    fn of(axis: &Axis) -> Self {
        Self { keys: axis.keys.clone(), values: axis.values.clone() }
    }

    fn keys(&mut self, keys: &mut impl Keys) {
        keys.key("keys", "", "", &mut self.keys);
        keys.key("values", "", "", &mut self.values);
    }
}

#[derive(Default)]
struct RunKeys {
    file: String,
    run_key: String,
    coordinates: Vec<Coordinate>,
    replicate: u32,
}

impl RunKeys {
    fn of(run: &RunRecord) -> Self {
        Self {
            file: run.file.clone(),
            run_key: run.run_key.to_string(),
            coordinates: run.coordinates.clone(),
            replicate: run.replicate,
        }
    }

    fn keys(&mut self, keys: &mut impl Keys) {
        keys.key("file", "", "", &mut self.file);
        keys.key("content_key", "", "", &mut self.run_key);
        keys.key("coordinates", "", "", &mut self.coordinates);
        keys.key("replicate", "1", "", &mut self.replicate);
    }

    fn into_record(self, reader: &mut Reader<'_>) -> Option<RunRecord> {
        let Some(run_key) = RunKey::from_hex(&self.run_key) else {
            reader.refuse(&["content_key"], "this is no run key", "must be 64 hexadecimal digits");
            return None;
        };
        Some(RunRecord {
            file: self.file,
            run_key,
            coordinates: self.coordinates,
            replicate: self.replicate,
        })
    }
}

/// A coordinate is written `["key", "value"]`.
impl TomlValue for Coordinate {
    fn read(node: &Node, name: &str, errors: &mut Vec<Diagnostic>) -> Option<Self> {
        let [key, value] = <[String; 2]>::read(node, name, errors)?;
        Some(Self { key, value })
    }

    fn write(&self) -> String {
        format!("[{}, {}]", quoted(&self.key), quoted(&self.value))
    }

    fn schema() -> serde_json::Value {
        <[String; 2]>::schema()
    }
}
