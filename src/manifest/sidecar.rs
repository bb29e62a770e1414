//! `experiment.toml`, next to the recordings: what the analysis needs to know about the whole experiment.

use crate::canonical::RunKey;
use crate::checks::{self, Check};
use crate::diagnostics::{Diagnostic, Diagnostics};
use crate::experiment::Experiment;
use crate::head::ExpectedOutcome;
use crate::keys::{HasKeys as _, Reader, Writer};
use crate::model::ModelConfig;
use crate::sweep::{Axis, Coordinate};
use crate::syntax::parse_toml;
use crate::table::table;
use crate::tree::{Node, Table, Value};
use crate::value::{TomlValue, quoted, refuse};

/// The runs of an experiment: which file belongs to which point, and the checks.
#[derive(Clone, Debug, PartialEq)]
pub struct ExperimentRecord {
    /// Name of the experiment.
    pub name: String,
    /// The question it asks; may be empty.
    pub description: String,
    /// Name of the model.
    pub model: String,
    /// Number of replicates at each point.
    pub replicates: u32,
    /// The sweep's axes.
    pub axes: Vec<Axis>,
    /// All runs; any other recording in the folder is stale.
    pub runs: Vec<RunRecord>,
    /// Conditions on the metrics.
    pub checks: Vec<Check>,
    /// How the runs are expected to end.
    pub expected_outcome: ExpectedOutcome,
    /// The manifest's file as it was named.
    pub manifest: String,
}

/// One run and its file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RunRecord {
    /// Name of the recording within the folder.
    pub file: String,
    /// Its run key.
    pub run_key: RunKey,
    /// Its point in the sweep.
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
            expected_outcome: experiment.expected_outcome,
            manifest: experiment.manifest.clone(),
        }
    }

    /// The text of `experiment.toml`.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let mut writer = Writer::default();
        writer
            .text
            .push_str("# Written by run-experiment: what the recordings in this folder are.\n");
        Head {
            name: self.name.clone(),
            description: self.description.clone(),
            model: self.model.clone(),
            replicates: self.replicates,
            expected_outcome: self.expected_outcome,
            manifest: self.manifest.clone(),
            check_lines: self.checks.iter().map(|check| check.line).collect(),
        }
        .keys(&mut writer);
        for Axis { keys, values } in self.axes.iter().cloned() {
            writer.text.push_str("\n[[axes]]\n");
            AxisKeys { keys, values }.keys(&mut writer);
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
    /// All errors of the text.
    pub fn from_toml(text: &str, origin: &str) -> Result<Self, Diagnostics> {
        let mut diagnostics = Diagnostics::default();
        let (root, syntax) = parse_toml(text, origin, &mut diagnostics);
        let mut errors = syntax.errors;
        let mut head = Head::default();
        let mut reader = Reader::new("", &root, &mut errors);
        head.keys(&mut reader);
        reader.also_known(&["axes", "runs", "checks"]);
        if ModelConfig::with_defaults(&head.model).is_none() {
            reader.report(Diagnostic::new(format!("unknown model {}", quoted(&head.model))));
        }
        reader.finish();
        let mut record = Self {
            name: head.name,
            description: head.description,
            model: head.model,
            replicates: head.replicates,
            axes: Vec::new(),
            runs: Vec::new(),
            checks: Vec::new(),
            expected_outcome: head.expected_outcome,
            manifest: head.manifest,
        };
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
            for (check, line) in record.checks.iter_mut().zip(head.check_lines) {
                check.line = line;
            }
        }
        let diagnostics = diagnostics.with(errors);
        if diagnostics.is_empty() { Ok(record) } else { Err(diagnostics) }
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

table! {
    /// The keys before the first table.
    struct Head {
        name: String [""] = String::new(),
        description: String [""] = String::new(),
        model: String [""] = String::new(),
        replicates: u32 ["1"] = 1,
        expected_outcome: ExpectedOutcome [""] = ExpectedOutcome::Complete,
        manifest: String [""] = String::new(),
        check_lines: Vec<u32> [""] = Vec::new(),
    }

    /// The keys of one of `[[axes]]`.
    struct AxisKeys {
        keys: Vec<String> [""] = Vec::new(),
        values: Vec<Vec<String>> [""] = Vec::new(),
    }

    /// The keys of one of `[[runs]]`.
    struct RunKeys {
        file: String [""] = String::new(),
        run_key: String [""] = String::new(),
        coordinates: Vec<Coordinate> [""] = Vec::new(),
        replicate: u32 ["1"] = 0,
    }
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

    fn into_record(self, reader: &mut Reader<'_>) -> Option<RunRecord> {
        let Some(run_key) = RunKey::from_hex(&self.run_key) else {
            reader.refuse(&["run_key"], "this is not a run key", "must be 64 hexadecimal digits");
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
