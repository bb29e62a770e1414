//! One experiment from its recordings to files and to the terminal.

use crate::baseline::Baseline;
use crate::checks::{Judge, Verdict, judge};
use crate::coordinates;
use crate::figures::{self, Figures};
use crate::input::Source;
use crate::memory::Memory;
use crate::metrics::{self, Metric, Place};
use crate::plot::Plot;
use crate::run::{self, Ending, OpenRun, RunAnalysis, Unreadable};
use crate::sweep;
use crate::table::{Terminal, Tone, six_digits, table};
use kinetoscope_manifest::{Check, Coordinate, ExperimentRecord, TimingTable};
use std::fmt::Write as _;
use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread::{self, available_parallelism};

/// All that was found in one experiment.
#[derive(Debug)]
pub struct Report {
    /// Its name.
    pub name: String,
    /// What it is about, in the user's words; may be empty.
    pub description: String,
    /// The runs, in the order of the experiment.
    pub runs: Vec<RunAnalysis>,
    /// All numbers: fits, means over replicates, runs.
    pub metrics: Vec<Metric>,
    /// What became of the checks.
    pub verdicts: Vec<Verdict>,
    /// The plots, each with a file name of its own.
    pub plots: Vec<(String, Plot)>,
    /// What the user should know.
    pub notes: Vec<String>,
    /// What could not be read, and why.
    pub unreadable: Vec<String>,
    /// How long the runs took on some machine, where `timing.json` stands beside the recordings.
    pub timing: Option<TimingTable>,
}

/// Plots of single runs are drawn for this many points of a sweep.
const MOST_RUNS_DRAWN: usize = 6;
/// In a longer sweep the terminal shows fits alone; everything is in the files.
const MOST_POINTS_SHOWN: usize = 6;

/// How recordings are to be analyzed.
#[derive(Clone, Debug, Default)]
pub struct Wishes {
    /// Checks beside the experiment's own.
    pub checks: Vec<Check>,
    /// Times of pictures beside those of start and end, in the model's unit.
    pub pictures_at: Vec<f64>,
    /// Where analyses are remembered.
    pub memory: Option<Memory>,
    /// Whether all recordings are read, also those that are remembered.
    pub fresh: bool,
}

/// One recording to be analyzed.
struct Task {
    run: OpenRun,
    coordinates: Vec<Coordinate>,
    with_figures: bool,
}

impl Task {
    /// From memory where the recording is unchanged, else by reading it.
    fn analyze(&self, wishes: &Wishes, threads: NonZeroUsize) -> Result<RunAnalysis, Unreadable> {
        let Self { run, coordinates, with_figures } = self;
        let (figures, pictures_at) = (*with_figures, &wishes.pictures_at);
        let recalled = wishes
            .memory
            .as_ref()
            .filter(|_| !wishes.fresh)
            .and_then(|memory| memory.recall(run, coordinates, figures, pictures_at));
        if let Some(found) = recalled {
            return Ok(found);
        }
        let found = run::analyze(run, coordinates.clone(), figures, pictures_at, threads)?;
        if let Some(memory) = &wishes.memory {
            memory.keep(run, &found, figures, pictures_at);
        }
        Ok(found)
    }
}

/// Analyses all, as many side by side as there are cores; results in the order of the tasks.
fn analyse_all(tasks: &[Task], wishes: &Wishes) -> Vec<Result<RunAnalysis, Unreadable>> {
    let cores = available_parallelism().unwrap_or(NonZeroUsize::MIN);
    let workers = tasks.len().min(cores.get());
    let threads = NonZeroUsize::new(cores.get() / workers.max(1)).unwrap_or(NonZeroUsize::MIN);
    let next = AtomicUsize::new(0);
    let work = || {
        let mut found = Vec::new();
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(task) = tasks.get(index) else { return found };
            found.push((index, task.analyze(wishes, threads)));
        }
    };
    let mut found: Vec<_> = thread::scope(|scope| {
        let others: Vec<_> = (1..workers).map(|_| scope.spawn(work)).collect();
        let mut found = work();
        for other in others {
            match other.join() {
                Ok(theirs) => found.extend(theirs),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
        found
    });
    found.sort_by_key(|(index, _)| *index);
    found.into_iter().map(|(_, result)| result).collect()
}

/// Analyses the recordings of one folder and remembers what was found, with plots where the analysis of the whole experiment will
/// draw them. Returns what could not be read, and why.
#[must_use]
pub fn remember(source: &mut Source, wishes: &Wishes) -> Vec<String> {
    let drawn = source.record.as_ref().map(drawn_files);
    let tasks: Vec<Task> = source
        .open()
        .into_iter()
        .map(|(run, coordinates)| {
            let with_figures = drawn.as_ref().is_none_or(|drawn| drawn.contains(&run.file));
            Task { run, coordinates, with_figures }
        })
        .collect();
    let results = analyse_all(&tasks, wishes).into_iter();
    let unread = results.filter_map(|result| result.err().map(|Unreadable(why)| why));
    source.unreadable.drain(..).chain(unread).collect()
}

/// The recordings that the analysis of a whole experiment draws where all runs are there: see [`analyze`].
fn drawn_files(record: &ExperimentRecord) -> Vec<String> {
    let mut drawn: Vec<(&[Coordinate], String)> = Vec::new();
    for run in &record.runs {
        if drawn.len() == figures::sweep::MOST_CURVES {
            break;
        }
        if !drawn.iter().any(|(coordinates, _)| *coordinates == run.coordinates) {
            drawn.push((&run.coordinates, run.file.clone()));
        }
    }
    drawn.into_iter().map(|(_, file)| file).collect()
}

/// Analyses the recordings of one folder.
#[must_use]
pub fn analyze(source: &mut Source, wishes: &Wishes) -> Report {
    let mut drawn: Vec<Vec<Coordinate>> = Vec::new();
    let tasks: Vec<Task> = source
        .open()
        .into_iter()
        .map(|(run, coordinates)| {
            // One run a point is drawn, and no more points than a chart can hold: plots are the largest part of memory.
            let with_figures =
                drawn.len() < figures::sweep::MOST_CURVES && !drawn.contains(&coordinates);
            if with_figures {
                drawn.push(coordinates.clone());
            }
            Task { run, coordinates, with_figures }
        })
        .collect();
    let mut runs: Vec<RunAnalysis> = Vec::new();
    let (mut notes, mut unreadable) = (source.notes.clone(), source.unreadable.clone());
    for result in analyse_all(&tasks, wishes) {
        match result {
            Ok(run) => runs.push(run),
            Err(Unreadable(why)) => unreadable.push(why),
        }
    }
    for run in &runs {
        match &run.ending {
            Ending::Complete => {}
            Ending::Damaged(why) => unreadable.push(why.clone()),
            other => notes.push(format!(
                "{}: {} after {} frames, t = {}; not part of means and fits",
                run.file,
                other.text(),
                run.frames,
                last_time(run)
            )),
        }
    }
    let timing = timing_beside(source, &mut notes);
    let points = sweep::points(&runs);
    let (mut metrics, refused) = sweep::fits(&points);
    notes.extend(refused);
    metrics.extend(sweep::replicate_means(&points));
    metrics.extend(runs.iter().flat_map(metrics::of_run));
    let plots = plots(&runs, &points, &mut notes);
    // A part of an experiment is not held to the checks of the whole.
    let own = source.record.as_ref().filter(|_| source.whole);
    let own = own.map_or(&[][..], |record| &record.checks);
    let verdicts =
        own.iter().chain(&wishes.checks).flat_map(|check| judge(check, &metrics)).collect();
    let record = source.record.as_ref();
    let description = record.map_or_else(String::new, |record| record.description.clone());
    Report {
        name: source.name.clone(),
        description,
        runs,
        metrics,
        verdicts,
        plots,
        notes,
        unreadable,
        timing,
    }
}

/// The timing table beside the recordings; where it does not read, a note says so.
fn timing_beside(source: &Source, notes: &mut Vec<String>) -> Option<TimingTable> {
    let path = source.folder.join(TimingTable::FILE);
    let text = match std::fs::read_to_string(&path) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return None,
        Err(error) => {
            notes.push(format!("{} can't be read: {error}", path.display()));
            return None;
        }
    };
    let complaint = match TimingTable::from_json(&text) {
        Ok(table) if table.schema != TimingTable::SCHEMA => {
            format!("has the layout {}, this version reads {}", table.schema, TimingTable::SCHEMA)
        }
        Ok(table) if table.experiment != source.name => {
            format!("is about the experiment {}", table.experiment)
        }
        Ok(table) => return Some(table),
        Err(error) => format!("is no timing table: {error}"),
    };
    notes.push(format!(
        "{} {complaint}; not shown. `kinetoscope benchmark --output` writes it again",
        path.display()
    ));
    None
}

fn plots(
    runs: &[RunAnalysis],
    points: &[sweep::SweepPoint<'_>],
    notes: &mut Vec<String>,
) -> Vec<(String, Plot)> {
    let mut all: Vec<(String, Plot)> = Vec::new();
    let mut add = |stem: String, plot: Plot| {
        let taken = |stem: &str| all.iter().any(|(other, _)| other == stem);
        let mut name = stem.clone();
        let mut number = 2;
        while taken(&name) {
            name = format!("{stem}_{number}");
            number += 1;
        }
        all.push((name, plot));
    };
    for plot in figures::sweep::plots(points) {
        add(plot.stem().to_owned(), plot);
    }
    let drawn: Vec<&RunAnalysis> =
        runs.iter().filter(|run| run.figures != Figures::default()).collect();
    for plot in figures::sweep::comparisons(&drawn) {
        add(plot.stem().to_owned(), plot);
    }
    for run in drawn.iter().take(MOST_RUNS_DRAWN) {
        for plot in &run.figures.plots {
            let place = coordinates::file_part(&run.coordinates);
            let mut plot = plot.clone();
            plot.add_to_title(&coordinates::label(&run.coordinates));
            add(format!("{}{place}", plot.stem()), plot);
        }
    }
    if drawn.len() > MOST_RUNS_DRAWN {
        notes.push(format!(
            "the first {MOST_RUNS_DRAWN} points of the sweep have plots of their own; plots of several runs show the first {}",
            figures::sweep::MOST_CURVES
        ));
    }
    all
}

impl Report {
    /// Name of the model; empty where no run could be read.
    pub(crate) fn model(&self) -> &str {
        self.runs.first().map_or("", |run| run.model().name())
    }

    /// Judges the metrics by those of an earlier analysis as well.
    pub fn compare(&mut self, baseline: &Baseline) {
        let (verdicts, notes) = baseline.judge(&self.metrics);
        self.verdicts.extend(verdicts);
        self.notes.extend(notes);
    }

    /// Whether all checks hold.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.verdicts.iter().all(|verdict| verdict.holds)
    }

    /// What the terminal shows.
    #[must_use]
    pub fn text(&self, terminal: Terminal) -> String {
        let mut text = String::new();
        let runs = match self.runs.len() {
            0 => "nothing readable".to_owned(),
            1 => format!("{}, 1 run", self.model()),
            runs => format!("{}, {runs} runs", self.model()),
        };
        let heading = format!("{} ({runs})", self.name);
        let _ = writeln!(text, "{}", terminal.paint(Tone::Heading, &heading));
        if !self.description.is_empty() {
            let _ = writeln!(text, "{}", terminal.wrapped(&self.description, 0));
        }
        for note in &self.notes {
            let _ = writeln!(text, "{}", terminal.wrapped(&format!("note: {note}"), 2));
        }
        for why in &self.unreadable {
            let line = terminal.wrapped(&format!("unreadable: {why}"), 2);
            let _ = writeln!(text, "{}", terminal.paint(Tone::Bad, &line));
        }
        for (title, metrics) in self.sections() {
            let _ = writeln!(text, "\n{}", terminal.wrapped(&title, 2));
            if !metrics.is_empty() {
                let _ = writeln!(text, "{}", table(&metrics, terminal));
            }
        }
        for (judge, title) in [(Judge::Check, "checks"), (Judge::Baseline, "against the baseline")]
        {
            text += &self.verdict_text(judge, title, terminal);
        }
        text
    }

    /// The verdicts of one judge. Of a long list those that hold are counted only.
    fn verdict_text(&self, judge: Judge, title: &str, terminal: Terminal) -> String {
        let verdicts = || self.verdicts.iter().filter(|verdict| verdict.judge == judge);
        if verdicts().next().is_none() {
            return String::new();
        }
        let mut text = format!("\n{title}\n");
        let inside = Terminal { width: terminal.width - 2, ..terminal };
        let counted = judge == Judge::Baseline;
        for verdict in verdicts().filter(|verdict| !(counted && verdict.holds)) {
            let (tone, word) =
                if verdict.holds { (Tone::Good, "ok") } else { (Tone::Bad, "FAILED") };
            let line = inside.wrapped(&format!("{word} {}", verdict.text()), 4);
            let _ = writeln!(text, "  {}", line.replacen(word, &terminal.paint(tone, word), 1));
        }
        if counted {
            let held = verdicts().filter(|verdict| verdict.holds).count();
            let _ =
                writeln!(text, "  {held} of {} metrics are where they were", verdicts().count());
        }
        text
    }

    /// The metrics that are shown, under their titles: fits, then the points of a short sweep.
    pub(crate) fn sections(&self) -> Vec<(String, Vec<&Metric>)> {
        let mut sections = Vec::new();
        let fits: Vec<&Metric> = self
            .metrics
            .iter()
            .filter(|metric| matches!(&metric.place, Place::Sweep(place) if place.along.is_some()))
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
        for (place, runs) in points.iter().take(MOST_POINTS_SHOWN) {
            let here = |metric: &&Metric| metric.coordinates() == place.as_slice();
            let means: Vec<&Metric> = self
                .metrics
                .iter()
                .filter(here)
                .filter(
                    |metric| matches!(&metric.place, Place::Sweep(place) if place.along.is_none()),
                )
                .collect();
            let name = coordinates::text(place);
            if means.is_empty() {
                for run in runs {
                    let of_run = |metric: &&Metric| matches!(&metric.place, Place::Run(place) if place.file == run.file);
                    let metrics = self.metrics.iter().filter(of_run).collect();
                    sections.push((run_title(run, &name), metrics));
                }
            } else {
                let complete = runs.iter().filter(|run| run.is_complete()).count();
                let name = if name.is_empty() { String::new() } else { format!("{name}, ") };
                sections.push((format!("{name}mean of {complete} replicates"), means));
            }
        }
        if points.len() > MOST_POINTS_SHOWN {
            let rest = points.len() - MOST_POINTS_SHOWN;
            sections
                .push((format!("{rest} more points of the sweep: see metrics.csv"), Vec::new()));
        }
        sections.retain(|(title, metrics)| !metrics.is_empty() || title.ends_with("metrics.csv"));
        sections
    }
}

fn run_title(run: &RunAnalysis, place: &str) -> String {
    let name = if place.is_empty() { run.file.clone() } else { place.to_owned() };
    format!("{name}: {} frames to t = {}, {}", run.frames, last_time(run), run.ending.text())
}

/// Simulated time of the last frame with its unit.
fn last_time(run: &RunAnalysis) -> String {
    format!("{} {}", six_digits(run.end_time), run.time_unit).trim_end().to_owned()
}
