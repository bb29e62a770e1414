//! Reads the text of a manifest into an experiment with all its runs.

use crate::answer::{AnswerTemplate, FittedAlong, UnitOf};
use crate::baseline::{self, BaselineTolerance};
use crate::canonical::{RunKey, RunManifest};
use crate::checks::{self, Check, CheckedManifest, MetricNames};
use crate::diagnostics::{Diagnostic, Diagnostics, Errors};
use crate::exercise::{self, Exercise};
use crate::head::{ExpectedOutcome, Head, NAME_RULE, is_name};
use crate::keys::{HasKeys as _, Names, Reader};
use crate::model::{ModelConfig, Recordings, accept_misplaced, no_model};
use crate::overrides::{self, Override, set};
use crate::plots::{self, PlotRequest, PlottedManifest};
use crate::record::{Keep, RecordConfig};
use crate::sentence::{leading_comment, question};
use crate::sweep::{self, Axis, Coordinate, Points, Setting};
use crate::syntax::parse_toml;
use crate::tree::{Table, Value};
use crate::value::{ReplicateCount, quoted, refuse_type};
use crate::view::{self, ViewRequest, ViewedManifest, ViewedRun};
use std::sync::Arc;

/// An experiment: the contents of a valid manifest.
#[derive(Clone, Debug, PartialEq)]
pub struct Experiment {
    /// Name of the experiment and of its folder: letters, digits, `_` and `-`, without `-` at the start.
    pub name: String,
    /// The question it asks; empty if none is stated.
    pub question: String,
    /// The sentence that answers it; `None` for one that follows from the checks.
    pub answer: Option<AnswerTemplate>,
    /// What is run, in the user's words; may be empty.
    pub description: String,
    /// The comment at the start of the manifest: the question and the expected answer; may be empty.
    pub comment: String,
    /// Seed of all random streams.
    pub seed: u64,
    /// Number of replicates at each point of the sweep.
    pub replicates: u32,
    /// The sweep's axes in the order of the file; empty without a sweep.
    pub axes: Vec<Axis>,
    /// All runs: the first axis varies slowest, replicates fastest.
    pub runs: Vec<Run>,
    /// Conditions on the metrics.
    pub checks: Vec<Check>,
    /// The plots that the report shows first.
    pub plots: Vec<PlotRequest>,
    /// How the report shows the runs first.
    pub view: ViewRequest,
    /// How much metrics may differ from those of an earlier analysis.
    pub baseline: Vec<BaselineTolerance>,
    /// The answer to an exercise; `None` if the manifest is not one.
    pub exercise: Option<Exercise>,
    /// How the runs are expected to end.
    pub expected_outcome: ExpectedOutcome,
    /// The manifest's file as it was named.
    pub manifest: String,
}

/// One run of an experiment.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// The run's point in the sweep: one coordinate for each swept key, or `variant`.
    pub coordinates: Arc<[Coordinate]>,
    /// Number of the replicate, from 0.
    pub replicate: u32,
    /// All inputs of the run.
    pub manifest: RunManifest,
}

/// Maximum number of runs with recordings in one experiment: more files in one folder slow down a file system.
const MOST_RUNS: usize = 100_000;
/// Maximum number of runs of which only the metrics are kept: their plan takes some 500 MB.
const MOST_ROWS: usize = 2_000_000;
/// Maximum number of points of a sweep: each has its own values in the memory.
const MOST_POINTS: usize = 100_000;
/// Number of errors after which no further point of a sweep is read.
const ENOUGH_ERRORS: usize = 200;
/// Maximum length of a file stem before its run key; file systems allow 255 bytes.
const LONGEST_STEM: usize = 160;

/// What a manifest may refer to, looked up by the caller.
#[derive(Clone, Copy, Default)]
pub struct Lookup<'a> {
    /// Finds the recordings that runs start from. Without it, a start from a recording remains a name.
    pub recordings: Option<Recordings<'a>>,
    /// The metrics that checks and plots may name. Without it, any name is accepted.
    pub metrics: Option<MetricNames>,
    /// The charts of the model that plots may name. Without it, any name is accepted.
    pub figures: Option<MetricNames>,
    /// The swept keys along which a metric is fitted: an answer names none of them. Without it, an answer may name any point.
    pub fitted_along: Option<FittedAlong>,
    /// The unit of a metric: only a pure number can be in percent. Without it, an answer may take any number in percent.
    pub unit_of: Option<UnitOf>,
}

/// Reads a manifest. `origin` is the file's name, for messages and for the default of `name`.
///
/// # Errors
/// All errors of the manifest and of the overrides, each with its place.
pub fn parse(
    source: &str,
    origin: &str,
    overrides: &[Override],
) -> Result<Experiment, Diagnostics> {
    parse_with(source, origin, overrides, Lookup::default())
}

/// Reads a manifest as [`parse`], and looks up what it refers to.
///
/// # Errors
/// As [`parse`], each recording that no run can start from, and each name that is not a metric of the model.
pub fn parse_with(
    source: &str,
    origin: &str,
    overrides: &[Override],
    lookup: Lookup<'_>,
) -> Result<Experiment, Diagnostics> {
    experiment(read_document(source, origin, overrides, lookup), source, origin)
}

/// Reads the canonical text of a run, or any manifest of exactly one run.
///
/// # Errors
/// All errors of the text.
pub fn parse_run(text: &str) -> Result<RunManifest, Diagnostics> {
    let (document, diagnostics) = read_document(text, "run manifest", &[], Lookup::default());
    let mut runs = document.runs;
    if diagnostics.is_empty() && runs.len() != 1 {
        let title = format!("expected one run, found an experiment of {}", runs.len());
        return Err(diagnostics.with(Errors::of(Diagnostic::new(title))));
    }
    match runs.pop() {
        Some(run) if diagnostics.is_empty() => Ok(run.manifest),
        _ => Err(diagnostics),
    }
}

fn experiment(
    (document, diagnostics): (Document, Diagnostics),
    source: &str,
    origin: &str,
) -> Result<Experiment, Diagnostics> {
    if !diagnostics.is_empty() {
        return Err(diagnostics);
    }
    let stem = std::path::Path::new(origin).file_stem().map(|stem| stem.to_string_lossy());
    let name = document.head.name.or_else(|| stem.map(String::from)).unwrap_or_default();
    if !is_name(&name) {
        let title = format!(
            "the file name {} cannot name the experiment; add name = \"...\" of {NAME_RULE}",
            quoted(&name)
        );
        return Err(diagnostics.with(Errors::of(Diagnostic::new(title))));
    }
    let comment = leading_comment(source);
    Ok(Experiment {
        name,
        question: question(document.head.question, &comment),
        answer: document.head.answer,
        description: document.head.description.unwrap_or_default(),
        comment,
        seed: document.head.seed,
        replicates: document.head.replicates.map_or(1, ReplicateCount::get),
        axes: document.axes,
        runs: document.runs,
        checks: document.checks,
        plots: document.plots,
        view: document.view,
        baseline: document.baseline,
        exercise: document.exercise,
        expected_outcome: document.head.expected_outcome.unwrap_or(ExpectedOutcome::Complete),
        manifest: origin.to_owned(),
    })
}

impl std::str::FromStr for Experiment {
    type Err = Diagnostics;

    /// Reads the text of a manifest; an experiment without a name is called `manifest`.
    fn from_str(text: &str) -> Result<Self, Diagnostics> {
        parse(text, "manifest.toml", &[])
    }
}

impl Experiment {
    /// The name of the model that all runs share.
    #[must_use]
    pub fn model(&self) -> &'static str {
        self.runs.first().map_or("", |run| run.manifest.model.name())
    }

    /// Whether no recording of the runs is kept.
    #[must_use]
    pub fn keeps_only_metrics(&self) -> bool {
        self.runs.iter().any(|run| run.manifest.record.keep == Keep::Metrics)
    }
}

impl Run {
    /// The name of the run's files without their endings: `NAME[__key=value...][__rNNN]__KEY8`, where `key` is the last
    /// part of a swept key. If that is too long for a file system, the whole key replaces the coordinates.
    #[must_use]
    pub fn file_stem(&self, name: &str, key: &RunKey, replicates: u32) -> String {
        let mut stem = name.to_owned();
        for coordinate in self.coordinates.iter() {
            let last = coordinate.key.rsplit('.').next().unwrap_or_default();
            stem.push_str(&format!("__{}={}", safe(last), safe(&coordinate.value)));
        }
        if replicates > 1 {
            stem.push_str(&format!("__r{:03}", self.replicate));
        }
        if stem.len() > LONGEST_STEM {
            return format!("{name}__{key}");
        }
        format!("{stem}__{}", key.short())
    }
}

/// Replaces every character that is not safe in all file systems and shells.
fn safe(text: &str) -> String {
    let keep = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '+' | '.');
    text.chars().map(|c| if keep(c) { c } else { '-' }).collect()
}

/// The contents of a manifest; valid only if there were no errors.
#[derive(Default)]
pub(crate) struct Document {
    head: Head,
    axes: Vec<Axis>,
    pub(crate) runs: Vec<Run>,
    checks: Vec<Check>,
    plots: Vec<PlotRequest>,
    view: ViewRequest,
    baseline: Vec<BaselineTolerance>,
    exercise: Option<Exercise>,
}

/// Reads a manifest and all its errors.
pub(crate) fn read_document(
    source: &str,
    origin: &str,
    overrides: &[Override],
    lookup: Lookup<'_>,
) -> (Document, Diagnostics) {
    let mut diagnostics = Diagnostics::default();
    let (mut root, syntax) = parse_toml(source, origin, &mut diagnostics);
    let mut errors = Errors::default();
    let set = overrides::read(overrides, &mut diagnostics, &mut errors);
    accept_misplaced(&mut root, &mut errors);
    let document = read_root(source, &mut root, set, lookup, &mut errors);
    if !syntax.hides_tables {
        errors.retain(|error| !syntax.explains(source, error));
        errors.append(syntax.errors);
    } else {
        errors = syntax.errors;
    }
    (document, diagnostics.with(errors))
}

/// The name of the model whose table a manifest has.
fn model_of(root: &Table) -> Option<&str> {
    let tables = root.get("model")?.node.table()?;
    tables.entries.first().map(|table| table.key.as_str())
}

fn read_root(
    source: &str,
    root: &mut Table,
    sets: Vec<Setting>,
    lookup: Lookup<'_>,
    errors: &mut Errors,
) -> Document {
    let is_overridden = !sets.is_empty();
    let sweep = root.take("sweep");
    let axes = sweep::read(sweep.as_ref(), model_of(root), errors);
    overrides::apply(root, sets, &axes, errors);
    let checks = root.take("checks");
    let plots = root.take("plots");
    let view = root.take("view");
    let baseline = root.take("baseline");
    let exercise = root.take("exercise");
    let model = root.take("model");
    let record = root.take("record");
    let base = Table { entries: [model, record].into_iter().flatten().collect() };
    let mut head = Head::default();
    let answer = root.get("answer").map(|entry| entry.node.clone());
    let mut reader = Reader::new("", root, errors);
    head.keys(&mut reader);
    head.check(&mut reader);
    reader.also_known(&[
        "model", "record", "sweep", "checks", "plots", "view", "baseline", "exercise",
    ]);
    reader.suggest_keys_of(&base);
    reader.finish();
    let runs = expand(&head, &base, &axes, lookup.recordings, errors);
    let numbers_of_variants = sweep::numbers_of_variants(&axes);
    let axes: Vec<Axis> = axes.into_iter().map(|points| points.axis).collect();
    let model = runs.first().map(|run| run.manifest.model.name());
    let metrics = model.zip(lookup.metrics).map(|(model, metrics)| metrics(model));
    let metrics = metrics.as_deref();
    let figures = model.zip(lookup.figures).map(|(model, figures)| figures(model));
    let manifest = CheckedManifest { source, axes: Some(&axes), metrics };
    if let Some((template, node)) = head.answer.as_ref().zip(answer) {
        template.check(&node, manifest, (lookup.fitted_along, lookup.unit_of), errors);
    }
    let checks =
        checks.map_or_else(Vec::new, |checks| checks::read(&checks.node, Some(manifest), errors));
    // A manifest whose runs cannot be read has no known channels; its errors are reported first.
    let requesting = runs.first().map(|run| PlottedManifest {
        manifest,
        numbers_of_variants: &numbers_of_variants,
        channels: run.manifest.model.channels(),
        recorded: run.manifest.record.channels.as_deref(),
        figures: figures.as_deref(),
    });
    let plots = plots.map_or_else(Vec::new, |plots| plots::read(&plots.node, requesting, errors));
    // A view that fits the manifest need not fit the runs of an override, such as a shorter duration.
    let viewed = runs.iter().filter(|_| !is_overridden);
    let viewed = viewed.map(|run| (&*run.coordinates, &run.manifest));
    let viewed: Vec<ViewedRun<'_>> = viewed.collect();
    let viewed = ViewedManifest { axes: &axes, runs: &viewed };
    let view =
        view.map_or_else(ViewRequest::default, |view| view::read(&view, Some(viewed), errors));
    let baseline =
        baseline.map_or_else(Vec::new, |baseline| baseline::read(&baseline.node, metrics, errors));
    let exercise = exercise.and_then(|entry| exercise::read(&entry, errors));
    Document { head, axes, runs, checks, plots, view, baseline, exercise }
}

/// Reads every combination of the axes' points, as if its values were written in the tables.
fn expand(
    head: &Head,
    base: &Table,
    axes: &[Points],
    recordings: Option<Recordings<'_>>,
    errors: &mut Errors,
) -> Vec<Run> {
    let replicates = head.replicate_numbers();
    let points =
        axes.iter().try_fold(1_usize, |product, axis| product.checked_mul(axis.settings.len()));
    let has_rows = keeps_only_metrics(base);
    let most = if has_rows { MOST_ROWS } else { MOST_RUNS };
    let is_small =
        |points: &usize| *points <= MOST_POINTS && points.saturating_mul(replicates.len()) <= most;
    let Some(points) = points.filter(is_small) else {
        errors.push(too_many_runs(axes, replicates.len(), has_rows));
        return Vec::new();
    };
    let mut runs = Vec::with_capacity(points * replicates.len());
    for point in 0..points {
        let mut root = base.clone();
        let mut coordinates = Vec::new();
        for (axis, index) in axes.iter().zip(indices(point, axes)) {
            for setting in &axis.settings[index] {
                set(&mut root, &setting.key, setting.key_span, &setting.node, errors);
            }
            let values = axis.axis.keys.iter().zip(&axis.axis.values[index]);
            coordinates.extend(
                values.map(|(key, value)| Coordinate { key: key.clone(), value: value.clone() }),
            );
        }
        if let Some((model, record)) = read_physics(&root, recordings, errors) {
            let (coordinates, model, record) =
                (Arc::from(coordinates), Arc::new(model), Arc::new(record));
            runs.extend(replicates.clone().map(|replicate| Run {
                coordinates: Arc::clone(&coordinates),
                replicate,
                manifest: RunManifest {
                    seed: head.seed,
                    replicate,
                    model: Arc::clone(&model),
                    record: Arc::clone(&record),
                },
            }));
        }
        if errors.len() > ENOUGH_ERRORS {
            break;
        }
    }
    let name = |run: &Run| run.manifest.model.name();
    if let Some(other) = runs.iter().find(|run| name(run) != name(&runs[0])) {
        let title = format!(
            "an experiment must have one model; the sweep mixes {} and {}",
            name(&runs[0]),
            name(other)
        );
        errors.push(Diagnostic::new(title));
    }
    runs
}

/// Whether `[record]` keeps only the metrics of the runs.
fn keeps_only_metrics(base: &Table) -> bool {
    let record = base.get("record").and_then(|entry| entry.node.table());
    let keep = record.and_then(|record| record.get("keep"));
    keep.is_some_and(|keep| matches!(&keep.node.value, Value::Text(keep) if keep == "metrics"))
}

fn too_many_runs(axes: &[Points], replicates: usize, has_rows: bool) -> Diagnostic {
    let factors: Vec<String> = axes.iter().map(|axis| axis.settings.len().to_string()).collect();
    let (limit, step) = match has_rows {
        true => (format!("{MOST_ROWS} runs or {MOST_POINTS} points"), ""),
        false => {
            (format!("{MOST_RUNS} runs"), ", or keep only their metrics: `keep = \"metrics\"`")
        }
    };
    Diagnostic::new(format!(
        "the sweep has more than {limit}: {} points and {replicates} replicates; split it into several experiments{step}",
        factors.join(" x "),
    ))
}

/// Returns the indices on the axes that belong to a point's number: the last axis varies fastest.
fn indices(point: usize, axes: &[Points]) -> Vec<usize> {
    let mut rest = point;
    let mut indices: Vec<usize> = axes
        .iter()
        .rev()
        .map(|axis| {
            let length = axis.settings.len();
            let index = rest % length;
            rest /= length;
            index
        })
        .collect();
    indices.reverse();
    indices
}

/// Reads the tables `[model]` and `[record]`.
fn read_physics(
    root: &Table,
    recordings: Option<Recordings<'_>>,
    errors: &mut Errors,
) -> Option<(ModelConfig, RecordConfig)> {
    let empty = Table::default();
    let errors_before = errors.len();
    let model = match root.get("model") {
        None => {
            errors.push(no_model());
            None
        }
        Some(entry) => match entry.node.table() {
            Some(models) => ModelConfig::read(models, recordings, RecordConfig::names(), errors),
            None => refuse_type(&entry.node, "model", "a table [model.<NAME>]", errors),
        },
    };
    let table = match root.get("record") {
        None => &empty,
        Some(entry) => {
            let table = entry.node.table();
            table
                .or_else(|| refuse_type(&entry.node, "record", "a table", errors))
                .unwrap_or(&empty)
        }
    };
    let model = model?;
    let sound = errors.len() == errors_before;
    let mut record = RecordConfig::default();
    let mut reader = Reader::new("record", table, errors);
    reader.names_elsewhere(&format!("model.{}", model.name()), Names::of(&mut model.clone()));
    record.keys_for(model.time_key(), &mut reader);
    record.check(&model, sound, &mut reader);
    reader.finish();
    Some((model, record))
}
