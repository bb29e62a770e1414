//! Analysis of one experiment: runs its recordings' analyses, derives sweep metrics, evaluates checks, and collects
//! plots.

mod drawn_runs;
mod engine;
pub(crate) mod engine_place;
mod file_links;
pub(crate) mod files;
mod head;
pub(crate) mod html;
pub(crate) mod index;
mod markup;
mod metrics_document;
mod metrics_of_runs;
mod metrics_reference;
mod numbers;
mod play;
mod plot_data;
mod plot_section;
mod plots;
mod provenance;
mod replay_section;
mod rerun;
mod sweep_data;
pub(crate) mod table;
pub(crate) mod text;
mod timing_section;
mod verify;

pub use metrics_reference::metrics_reference;
pub(crate) use metrics_reference::metrics_with;
pub use plot_data::charts_of_run;

pub(crate) use self::drawn_runs::snapshots_outside;
use self::drawn_runs::{drawn_files, drawn_runs};
use self::engine_place::EnginePlace;
use self::metrics_of_runs::{MAX_POINTS_SHOWN, metrics_of_runs};
use crate::answer::{Answer, AnswerSource};
use crate::checks::baseline::BaselineComparison;
use crate::checks::ci_formats::ExperimentChecks;
use crate::checks::{CheckResult, evaluate, outcome};
use crate::input::RecordingFolder;
use crate::input::UnreadableRecording;
use crate::input::coordinates;
use crate::input::host_file::HostFile;
use crate::input::recording::OpenRun;
use crate::metric::{Metric, MetricScope};
use crate::metric_files::rows_of_folder;
use crate::number_text::six_digits;
use crate::plot::Plot;
use crate::run::cache::AnalysisCache;
use crate::run::{self, RunAnalysis, RunOptions, RunStatus};
use crate::sweep;
use crate::sweep::fits::Refusal;
use crate::sweep::requested::{self, PlotData};
use kinetoscope_console::text::plural;
use kinetoscope_manifest::{
    BaselineTolerance, Check, Coordinate, ExperimentRecord, TimingTable, ViewRequest,
};
use rayon::iter::{IndexedParallelIterator as _, IntoParallelIterator as _, ParallelIterator as _};
use std::collections::BTreeMap;
use std::num::NonZeroUsize;
use std::thread::available_parallelism;
use std::time::Instant;

/// The analysis of one experiment.
#[derive(Debug)]
pub(crate) struct AnalysisReport {
    /// The experiment's name.
    pub(crate) name: String,
    /// The question that it asks; may be empty.
    pub(crate) question: String,
    /// The answer in one or two sentences.
    pub(crate) answer: Answer,
    /// The user's description; may be empty.
    pub(crate) description: String,
    /// The comment at the start of the manifest, with the question and the expected answer; may be empty.
    pub(crate) comment: String,
    /// Sizes of the recordings, bytes, by file.
    pub(crate) sizes: BTreeMap<String, u64>,
    /// Whether an existing table of runs is kept.
    #[cfg_attr(not(feature = "parquet"), allow(dead_code, reason = "the table is Parquet"))]
    keeps_table: bool,
    /// The host files of the runs that have one, in the order of the runs.
    pub(crate) hosts: Vec<HostFile>,
    /// The runs, in the order of the experiment.
    pub(crate) runs: Vec<RunAnalysis>,
    /// All metrics: fits, means over replicates, runs.
    pub(crate) metrics: Vec<Metric>,
    /// The outcomes of the runs against the expected one, and the results of the checks.
    pub(crate) check_results: Vec<CheckResult>,
    /// The comparison with an earlier analysis, if there is one.
    pub(crate) baseline: Option<BaselineComparison>,
    /// How much metrics may differ from those of an earlier analysis.
    tolerances: Vec<BaselineTolerance>,
    /// The manifest as it was named, if it is known.
    pub(crate) manifest: Option<String>,
    /// The plots, each with a unique file name.
    pub(crate) plots: Vec<(String, Plot)>,
    /// How many of them the manifest requests; these are the first.
    requested_plots: usize,
    /// How the replay begins.
    pub(crate) view: ViewRequest,
    /// Where the engine of the page is.
    pub(crate) engine: EnginePlace,
    /// Notes for the user.
    pub(crate) notes: Vec<String>,
    /// What could not be read, with reasons.
    pub(crate) unreadable: Vec<UnreadableRecording>,
    /// The run times, if `timing.json` is next to the recordings.
    pub(crate) timing: Option<TimingTable>,
}

/// Maximum number of sweep points with plots of single runs.
const MAX_RUNS_DRAWN: usize = 6;

/// Options of an analysis.
#[derive(Clone, Debug, Default)]
pub(crate) struct AnalysisOptions {
    /// Checks in addition to the experiment's own.
    pub(crate) checks: Vec<Check>,
    /// The file that contains them.
    pub(crate) checks_file: Option<String>,
    /// Times of snapshots in addition to start and end, in the model's unit.
    pub(crate) snapshots_at: Vec<f64>,
    /// The cache of analyses.
    pub(crate) cache: Option<AnalysisCache>,
    /// Whether all recordings are read, including cached ones.
    pub(crate) fresh: bool,
    /// Maximum size of all replays of a page, bytes; `None` for no replays.
    pub(crate) replay_bytes: Option<usize>,
    /// Where the engine of the page is.
    pub(crate) engine: EnginePlace,
}

/// One recording to be analyzed.
struct AnalysisTask {
    run: OpenRun,
    coordinates: Vec<Coordinate>,
    /// Fields of channels that requested plots show.
    fields: Vec<String>,
    /// Whether the run is plotted and, if the page has replays, replayed.
    is_drawn: bool,
}

impl AnalysisTask {
    /// The file and its size in bytes.
    fn size(&self) -> (String, u64) {
        (self.run.file.clone(), self.run.recording().bytes())
    }

    /// Loads the analysis of an unchanged recording from the cache, or reads the recording.
    fn analyze(
        &self,
        options: &AnalysisOptions,
        replay_bytes: Option<usize>,
        threads: NonZeroUsize,
        view: &ViewRequest,
    ) -> Result<RunAnalysis, UnreadableRecording> {
        let Self { run, coordinates, fields, is_drawn } = self;
        let run_options = RunOptions {
            with_figures: *is_drawn,
            snapshots_at: &options.snapshots_at,
            replay_bytes: replay_bytes.filter(|_| *is_drawn),
            fields,
            view: Some(view),
            with_claim: *is_drawn && options.engine.module().is_some(),
            with_messages: true,
        };
        let cached = options
            .cache
            .as_ref()
            .filter(|_| !options.fresh)
            .and_then(|cache| cache.load(run, coordinates, run_options));
        if let Some(found) = cached {
            return Ok(found);
        }
        let found = run::catch_defect(run.recording().path(), || {
            run::analyze(run, coordinates.clone(), run_options, threads)
        })?;
        if let Some(cache) = &options.cache {
            cache.store(run, &found, run_options);
        }
        Ok(found)
    }
}

/// Analyzes all recordings in parallel on all CPUs; results are in the order of the tasks. Each recording is closed when it was read. The replays of `replayed` runs share the
/// page's budget.
fn analyze_all(
    tasks: Vec<AnalysisTask>,
    replayed: usize,
    options: &AnalysisOptions,
    view: &ViewRequest,
) -> Vec<(Result<RunAnalysis, UnreadableRecording>, f64)> {
    let cores = available_parallelism().unwrap_or(NonZeroUsize::MIN);
    let threads = NonZeroUsize::new(cores.get() / tasks.len().clamp(1, cores.get()));
    let threads = threads.unwrap_or(NonZeroUsize::MIN);
    let replay_bytes = options.replay_bytes.map(|bytes| (bytes / replayed.max(1)).max(1));
    // One task at a time per thread, because recordings differ in length.
    let tasks = tasks.into_par_iter().with_max_len(1);
    let timed = tasks.map(|task| {
        let started = Instant::now();
        let result = task.analyze(options, replay_bytes, threads, view);
        (result, started.elapsed().as_secs_f64())
    });
    timed.collect()
}

/// Analyzes the recordings of one folder and caches the results, with plots where the analysis of the whole experiment
/// draws them. Returns what could not be read, with reasons.
pub(crate) fn fill_cache(
    source: &mut RecordingFolder,
    options: &AnalysisOptions,
) -> Vec<UnreadableRecording> {
    let drawn = source.record.as_ref().map(drawn_files);
    let fields = source.record.as_ref().map(fields_of_files).unwrap_or_default();
    let tasks: Vec<AnalysisTask> = source
        .open()
        .into_iter()
        .map(|(run, coordinates)| {
            let is_drawn = drawn.as_ref().is_none_or(|drawn| drawn.contains(&run.file));
            let fields = fields.get(&run.file).cloned().unwrap_or_default();
            AnalysisTask { run, coordinates, fields, is_drawn }
        })
        .collect();
    let replayed = drawn.map_or(tasks.len(), |drawn| drawn.len()).min(sweep::figures::MAX_CURVES);
    let view = source.record.as_ref().and_then(|record| record.view.clone()).unwrap_or_default();
    let results = analyze_all(tasks, replayed, options, &view);
    let unread = results.into_iter().filter_map(|(result, _)| result.err());
    source.unreadable.drain(..).chain(unread).collect()
}

/// The fields of channels that [`analyze`] plots from each recording if all runs are complete.
fn fields_of_files(record: &ExperimentRecord) -> BTreeMap<String, Vec<String>> {
    let coordinates = record.runs.iter().map(|run| &run.coordinates);
    let fields = requested::fields_to_read(&record.plots, coordinates);
    record.runs.iter().map(|run| run.file.clone()).zip(fields).collect()
}

/// The tasks of opened runs with the fields to read from each, and the number of runs that are drawn.
fn tasks(
    opened: Vec<(OpenRun, Vec<Coordinate>)>,
    fields: Vec<Vec<String>>,
    view: &ViewRequest,
) -> (Vec<AnalysisTask>, usize) {
    let drawn = drawn_runs(opened.iter().map(|(_, place)| place.as_slice()), view);
    let task = |(index, ((run, coordinates), fields))| AnalysisTask {
        run,
        coordinates,
        fields,
        is_drawn: drawn.contains(&index),
    };
    let tasks = opened.into_iter().zip(fields).enumerate().map(task).collect();
    (tasks, drawn.len())
}

/// Analyzes the recordings of one folder.
pub(crate) fn analyze(source: &mut RecordingFolder, options: &AnalysisOptions) -> AnalysisReport {
    let opened = source.open();
    let (tabled, keeps_table) = rows_of_folder(source, &opened);
    let places = places_of(&opened, &tabled);
    let requests = source.record.as_ref().map_or(&[][..], |record| &record.plots);
    let fields = requested::fields_to_read(requests, &places);
    let view = source.record.as_ref().and_then(|record| record.view.clone()).unwrap_or_default();
    let (tasks, drawn) = tasks(opened, fields, &view);
    let sizes = tasks.iter().map(AnalysisTask::size).collect();
    let hosts = tasks.iter().filter_map(|task| source.host_file(&task.run.file)).collect();
    let (mut runs, mut seconds): (Vec<RunAnalysis>, Vec<f64>) = (Vec::new(), Vec::new());
    let (mut notes, mut unreadable) = (source.notes.clone(), source.unreadable.clone());
    for (result, took) in analyze_all(tasks, drawn, options, &view) {
        match result {
            Ok(run) => {
                runs.push(run);
                seconds.push(took);
            }
            Err(why) => unreadable.push(why),
        }
    }
    runs.extend(tabled);
    seconds.resize(runs.len(), 0.0);
    add_endings(&runs, &mut notes, &mut unreadable);
    notes.extend(snapshots_outside(&runs, &options.snapshots_at));
    let points = sweep::points(&runs);
    let (mut metrics, refusals) = sweep::fits::fits(&points);
    notes.extend(refusals.iter().map(Refusal::note));
    metrics.extend(sweep::replicate_means(&points));
    let record = source.record.as_ref();
    metrics.extend(metrics_of_runs(&runs, &metrics, record, &options.checks));
    let axes = record.map_or(&[][..], |record| &record.axes);
    let data = PlotData { runs: &runs, points: &points, metrics: &metrics, places: &places, axes };
    let mut check_results = outcome::all(record, &options.checks, &runs, &seconds);
    check_results.extend(evaluate_checks(source, options, &metrics));
    let timing = timing_section::timing_beside(source, &mut notes);
    let answer = Answer::of(&AnswerSource {
        record,
        runs: &runs,
        metrics: &metrics,
        checks: &applying(source, options),
        refusals: &refusals,
        timing: timing.as_ref(),
    });
    let requests = plots::requests(record, &answer, data);
    let (plots, requested_plots) = plots::plots(data, &requests, &mut notes);
    // What concerns all sweeps alike comes last.
    notes.extend(sweep::correlation_note(&points).map(str::to_owned));
    let text = |of: fn(&ExperimentRecord) -> &String| record.map(of).cloned().unwrap_or_default();
    AnalysisReport {
        name: source.name.clone(),
        question: text(|record| &record.question),
        answer,
        description: text(|record| &record.description),
        comment: text(|record| &record.comment),
        sizes,
        keeps_table,
        hosts,
        runs,
        metrics,
        check_results,
        baseline: None,
        tolerances: record.map_or_else(Vec::new, |record| record.baseline.clone()),
        manifest: record.map(|record| record.manifest.clone()).filter(|name| !name.is_empty()),
        plots,
        requested_plots,
        view,
        engine: options.engine,
        notes,
        unreadable,
        timing,
    }
}

/// The places of all runs in the sweep.
fn places_of(
    opened: &[(OpenRun, Vec<Coordinate>)],
    tabled: &[RunAnalysis],
) -> Vec<Vec<Coordinate>> {
    let of_rows = tabled.iter().map(|run| &run.coordinates);
    opened.iter().map(|(_, place)| place).chain(of_rows).cloned().collect()
}

/// Notes the runs that are not complete, and reports damaged files.
fn add_endings(
    runs: &[RunAnalysis],
    notes: &mut Vec<String>,
    unreadable: &mut Vec<UnreadableRecording>,
) {
    for run in runs {
        match &run.ending {
            RunStatus::Complete => {}
            RunStatus::Damaged(why) => unreadable.push(why.clone().into()),
            other => notes.push(format!(
                "{}: {} after {}, t = {}; not part of means and fits",
                run.file,
                other.word(),
                plural(run.frames, "frame"),
                last_time(run)
            )),
        }
    }
}

/// The experiment's own checks, which do not apply to a part of it, and those of the checks file.
pub(crate) fn applying<'a>(
    source: &'a RecordingFolder,
    options: &'a AnalysisOptions,
) -> Vec<&'a Check> {
    let own = source.record.as_ref().filter(|_| source.whole);
    own.iter().flat_map(|record| &record.checks).chain(&options.checks).collect()
}

/// The results of the experiment's own checks and of those in the checks file.
fn evaluate_checks(
    source: &RecordingFolder,
    options: &AnalysisOptions,
    metrics: &[Metric],
) -> Vec<CheckResult> {
    // The checks of an experiment do not apply to a part of it.
    let own = source.record.as_ref().filter(|_| source.whole);
    let own = own.map_or(&[][..], |record| &record.checks).iter();
    let own = own.flat_map(|check| evaluate(check, metrics));
    let further = options.checks.iter().flat_map(|check| evaluate(check, metrics));
    let file = &options.checks_file;
    own.chain(further.map(|result| CheckResult { file: file.clone(), ..result })).collect()
}

impl AnalysisReport {
    /// The model and the number of its runs, or those of each model.
    pub(crate) fn models_and_runs(&self) -> String {
        let counted = |(model, runs): (&str, usize)| match runs {
            1 => format!("{model}, 1 run"),
            runs => format!("{model}, {runs} runs"),
        };
        let mut by_model = BTreeMap::<&str, usize>::new();
        self.runs.iter().for_each(|run| *by_model.entry(run.model().name()).or_default() += 1);
        let number = by_model.len();
        let all = by_model.into_iter().map(counted).collect::<Vec<_>>().join("; ");
        if number > 1 { format!("{number} models: {all}") } else { all }
    }

    /// The checks and their results, for the formats of CI systems.
    pub(crate) fn checks(&self) -> ExperimentChecks<'_> {
        let Self { name, check_results, unreadable, .. } = self;
        let (manifest, answer) = (self.manifest.as_deref(), self.answer.text());
        ExperimentChecks { name, manifest, answer, check_results, unreadable }
    }

    /// Runs without the expected outcome, unfinished or damaged; `None` if there are none.
    pub(crate) fn headline(&self) -> Option<String> {
        outcome::headline(&self.runs, &self.check_results)
    }

    /// The first plot that the manifest requests, with the name of its file.
    pub(crate) fn first_requested_plot(&self) -> Option<&(String, Plot)> {
        self.plots.first().filter(|_| self.requested_plots > 0)
    }

    /// Whether a plot is one that the manifest requests, by the name of its file.
    pub(crate) fn is_requested_plot(&self, stem: &str) -> bool {
        self.plots[..self.requested_plots].iter().any(|(requested, _)| requested == stem)
    }

    /// How many files could not be read at all; `None` if all were. The damaged ones are in the headline.
    pub(crate) fn unreadable_files(&self) -> Option<String> {
        let is_damaged = |run: &&RunAnalysis| matches!(run.ending, RunStatus::Damaged(_));
        let damaged = self.runs.iter().filter(is_damaged).count();
        match self.unreadable.len().saturating_sub(damaged) {
            0 => None,
            1 => Some("1 file unreadable".to_owned()),
            files => Some(format!("{files} files unreadable")),
        }
    }

    /// The metrics to show with their titles: fits, then the points of a short sweep.
    pub(crate) fn sections(&self) -> Vec<(String, Vec<&Metric>)> {
        let mut sections = Vec::new();
        let fits: Vec<&Metric> = self
            .metrics
            .iter()
            .filter(|metric| matches!(&metric.scope, MetricScope::Sweep(scope) if scope.along.is_some()))
            .collect();
        let places = fits.iter().map(|metric| (metric.coordinates().to_vec(), *metric));
        for (place, fits) in coordinates::grouped(places) {
            let place = coordinates::text(&place);
            let title = if place.is_empty() {
                "the sweep".to_owned()
            } else {
                format!("the sweep at {place}")
            };
            sections.push((title, fits));
        }
        let points =
            coordinates::grouped(self.runs.iter().map(|run| (run.coordinates.clone(), run)));
        for (place, runs) in points.iter().take(MAX_POINTS_SHOWN) {
            let here = |metric: &&Metric| metric.coordinates() == place.as_slice();
            let means: Vec<&Metric> = self
                .metrics
                .iter()
                .filter(here)
                .filter(
                    |metric| matches!(&metric.scope, MetricScope::Sweep(scope) if scope.along.is_none()),
                )
                .collect();
            let name = coordinates::text(place);
            if means.is_empty() {
                for run in runs {
                    let of_run = |metric: &&Metric| matches!(&metric.scope, MetricScope::Run(scope) if scope.file == run.file);
                    let metrics = self.metrics.iter().filter(of_run).collect();
                    sections.push((run_title(run, &name), metrics));
                }
            } else {
                let complete = runs.iter().filter(|run| run.is_complete()).count();
                let name = if name.is_empty() { String::new() } else { format!("{name}, ") };
                sections.push((format!("{name}mean of {complete} replicates"), means));
            }
        }
        if points.len() > MAX_POINTS_SHOWN {
            let rest = points.len() - MAX_POINTS_SHOWN;
            sections
                .push((format!("{rest} more points of the sweep: see metrics.csv"), Vec::new()));
        }
        sections.retain(|(title, metrics)| !metrics.is_empty() || title.ends_with("metrics.csv"));
        sections
    }
}

fn run_title(run: &RunAnalysis, place: &str) -> String {
    let name = if place.is_empty() { run.file.clone() } else { place.to_owned() };
    let frames = plural(run.frames, "frame");
    format!("{name}: {frames} to t = {}, {}", last_time(run), run.ending.word())
}

/// Formats the simulated time of the last frame with its unit.
fn last_time(run: &RunAnalysis) -> String {
    format!("{} {}", six_digits(run.end_time), run.time_unit).trim_end().to_owned()
}
