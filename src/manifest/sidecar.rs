//! `experiment.toml`, next to the recordings: what the analysis needs to know about the whole experiment.

use crate::answer::AnswerTemplate;
use crate::baseline::{self, BaselineTolerance};
use crate::canonical::RunKey;
use crate::checks::{self, Check};
use crate::diagnostics::{Diagnostic, Diagnostics, Errors};
use crate::experiment::Experiment;
use crate::head::ExpectedOutcome;
use crate::keys::{HasKeys as _, Reader, Writer};
use crate::model::ModelConfig;
use crate::plots::{self, PlotRequest};
use crate::sweep::{Axis, Coordinate};
use crate::syntax::parse_toml;
use crate::table::table;
use crate::tree::{Node, Table};
use crate::value::{TomlValue, quoted, tables};
use crate::view::{self, ViewRequest};

table! {
    /// The runs of an experiment: which file belongs to which point, and the checks.
    pub struct ExperimentRecord {
        /// Name of the experiment.
        name: String [""] = String::new(),
        /// The question it asks; may be empty.
        question: String [""] = String::new(),
        /// The sentence that answers it, if the manifest has one.
        answer: Option<AnswerTemplate> ["", optional],
        /// What is run; may be empty.
        description: String [""] = String::new(),
        /// The comment at the start of the manifest, with the question and the expected answer; may be empty.
        comment: String [""] = String::new(),
        /// Name of the model.
        model: String [""] = String::new(),
        /// Number of replicates at each point.
        replicates: u32 ["1"] = 1,
        /// How the runs are expected to end.
        expected_outcome: ExpectedOutcome [""] = ExpectedOutcome::Complete,
        /// The manifest's file as it was named.
        manifest: String [""] = String::new(),
        /// The number of runs, if there are so many that they are not listed.
        unlisted_runs: Option<u64> ["1", optional],
        /// The line of each check in the manifest.
        check_lines: Vec<u32> [""] = Vec::new(),
        /// The sweep's axes.
        axes: Vec<Axis> [apart] = Vec::new(),
        /// All runs; any other recording in the folder is stale.
        runs: Vec<RunRecord> [apart] = Vec::new(),
        /// Conditions on the metrics.
        checks: Vec<Check> [apart] = Vec::new(),
        /// The plots that the report shows first.
        plots: Vec<PlotRequest> [apart] = Vec::new(),
        /// How the report shows the runs first.
        view: Option<ViewRequest> [apart] = None,
        /// How much metrics may differ from those of an earlier analysis.
        baseline: Vec<BaselineTolerance> [apart] = Vec::new(),
    }

    /// The keys of one of `[[runs]]`.
    struct RunKeys {
        file: String [""] = String::new(),
        run_key: String [""] = String::new(),
        coordinates: Vec<Coordinate> [""] = Vec::new(),
        replicate: u32 ["1"] = 0,
    }
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
    /// The first line of `experiment.toml`, which distinguishes it from a manifest.
    pub const FIRST_LINE: &str =
        "# Written by run-experiment: what the recordings in this folder are.\n";

    /// The record of an experiment whose runs have these files, in the order of [`Experiment::runs`].
    #[must_use]
    pub fn new(experiment: &Experiment, files: impl IntoIterator<Item = (String, RunKey)>) -> Self {
        let runs = experiment.runs.iter().zip(files).map(|(run, (file, run_key))| RunRecord {
            file,
            run_key,
            coordinates: run.coordinates.to_vec(),
            replicate: run.replicate,
        });
        Self {
            name: experiment.name.clone(),
            question: experiment.question.clone(),
            answer: experiment.answer.clone(),
            description: experiment.description.clone(),
            comment: experiment.comment.clone(),
            model: experiment.model().to_owned(),
            replicates: experiment.replicates,
            axes: experiment.axes.clone(),
            runs: runs.collect(),
            unlisted_runs: None,
            checks: experiment.checks.clone(),
            plots: experiment.plots.clone(),
            view: Some(experiment.view.clone()).filter(|view| *view != ViewRequest::default()),
            baseline: experiment.baseline.clone(),
            expected_outcome: experiment.expected_outcome,
            manifest: experiment.manifest.clone(),
            check_lines: experiment.checks.iter().map(|check| check.line).collect(),
        }
    }

    /// The record of an experiment with too many runs to list them: `runs.parquet` has them.
    #[must_use]
    pub fn without_runs(experiment: &Experiment) -> Self {
        let runs = experiment.runs.len() as u64;
        Self { unlisted_runs: Some(runs), ..Self::new(experiment, []) }
    }

    /// The text of `experiment.toml`.
    #[must_use]
    pub fn to_toml(mut self) -> String {
        let mut writer = Writer::default();
        writer.text.push_str(Self::FIRST_LINE);
        self.keys(&mut writer);
        for mut axis in self.axes {
            writer.text.push_str("\n[[axes]]\n");
            axis.keys(&mut writer);
        }
        for RunRecord { file, run_key, coordinates, replicate } in self.runs {
            writer.text.push_str("\n[[runs]]\n");
            let run_key = run_key.to_string();
            RunKeys { file, run_key, coordinates, replicate }.keys(&mut writer);
        }
        checks::write(&self.checks, &mut writer);
        plots::write(&self.plots, &mut writer);
        view::write(&self.view.unwrap_or_default(), &mut writer);
        baseline::write(&self.baseline, &mut writer);
        writer.text
    }

    /// Reads the text of an `experiment.toml`.
    ///
    /// # Errors
    /// All errors of the text.
    pub fn from_toml(text: &str, origin: &str) -> Result<Self, Diagnostics> {
        let mut diagnostics = Diagnostics::default();
        let (root, syntax) = parse_toml(text, origin, &mut diagnostics);
        if syntax.hides_tables {
            return Err(diagnostics.with(syntax.errors));
        }
        let mut errors = syntax.errors;
        let mut record = Self::default();
        let mut reader = Reader::new("", &root, &mut errors);
        record.keys(&mut reader);
        reader.also_known(&["axes", "runs", "checks", "plots", "view", "baseline"]);
        if ModelConfig::with_defaults(&record.model).is_none() {
            reader.report(Diagnostic::new(format!("unknown model {}", quoted(&record.model))));
        }
        reader.finish();
        for_each(&root, "axes", &mut errors, |reader| {
            let mut axis = Axis::default();
            axis.keys(reader);
            record.axes.push(axis);
        });
        for_each(&root, "runs", &mut errors, |reader| {
            let mut run = RunKeys::default();
            run.keys(reader);
            let RunKeys { file, run_key, coordinates, replicate } = run;
            match RunKey::from_hex(&run_key) {
                Some(run_key) => {
                    record.runs.push(RunRecord { file, run_key, coordinates, replicate });
                }
                None => {
                    let title = "this is not a run key";
                    reader.refuse(&["run_key"], title, "must be 64 hexadecimal digits");
                }
            }
        });
        if let Some(entry) = root.get("checks") {
            record.checks = checks::read(&entry.node, None, &mut errors);
            for (check, line) in record.checks.iter_mut().zip(&record.check_lines) {
                check.line = *line;
            }
        }
        if let Some(entry) = root.get("plots") {
            record.plots = plots::read(&entry.node, None, &mut errors);
        }
        if let Some(entry) = root.get("view") {
            record.view = Some(view::read(entry, None, &mut errors));
        }
        if let Some(entry) = root.get("baseline") {
            record.baseline = baseline::read(&entry.node, None, &mut errors);
        }
        diagnostics.ok_or(record, errors)
    }
}

/// Reads each table of an array of tables.
fn for_each(root: &Table, key: &str, errors: &mut Errors, mut read: impl FnMut(&mut Reader<'_>)) {
    let Some(entry) = root.get(key) else { return };
    for (_, table) in tables(&entry.node, key, ["an array of tables", "a table"], errors) {
        let mut reader = Reader::new(key, table, errors);
        read(&mut reader);
        reader.finish();
    }
}

/// A coordinate is written `["key", "value"]`.
impl TomlValue for Coordinate {
    fn read(node: &Node, name: &str, errors: &mut Errors) -> Option<Self> {
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
