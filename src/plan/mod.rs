//! The plan: all runs of an experiment with their run keys, which of them are finished, and the resources of the others.

mod points;
pub mod preparation;
pub mod prune;
pub mod totals;
pub mod why;

use crate::plan::points::Points;
use crate::plan::preparation::{Preparation, RunPreparation, StartProgress};
use crate::run::RunSpec;
use crate::run::prepared::Prepared;
use crate::run::resources::memory::{self, PROGRAM_BYTES};
use crate::run::resources::sample::sample_of;
use crate::run::resources::{Estimate, nominal_seconds};
use kinetoscope_manifest::{Experiment, PlotRequest, Run, RunKey, RunManifest, run_key};
use kinetoscope_physics::kind_of;
use kinetoscope_physics::model::{Extent, SetupError};
use kinetoscope_recording::channels::SCHEMA_VERSION;
use kinetoscope_recording::layout::{layout_json, with_names, with_states, without_time_scale};
use kinetoscope_recording::reader::Recording;
use kinetoscope_recording::recorder::Outcome;
use kinetoscope_recording::requested_panels::PanelRequest;
use rayon::prelude::*;
use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

/// Memory for the starts that a plan of several runs keeps for their execution, by the runs' memory estimates. A run whose start
/// is not kept builds it again. The limit is below the estimate for one run, so that a cluster's task stays within the memory
/// that it requests.
const KEPT_STARTS_BYTES: u64 = 32 << 20;

/// Runs from which on an outline builds only the start of each point's first replicate, whose estimate the others share.
const MOST_STARTED: usize = 1000;

/// One run of the plan.
#[derive(Debug)]
pub struct PlannedRun {
    /// The run as expanded from the manifest.
    pub run: Run,
    /// The hash of all inputs.
    pub run_key: RunKey,
    /// Whether the run is finished.
    pub status: Status,
    /// The experiment's name and number of replicates, which are in the names of files.
    experiment: Arc<(String, u32)>,
    /// Seconds that the start took to build, or would take if only a sample was built.
    preparation_s: f64,
    /// The start that planning built, if it is kept for the execution.
    start: Mutex<Option<Box<Prepared>>>,
}

/// Status of a run.
#[derive(Debug)]
pub enum Status {
    /// Its recording exists, with this outcome.
    Done(Outcome),
    /// It is to be executed, with these resources.
    ToDo(Arc<Estimate>),
    /// It cannot be executed.
    Rejected(SetupError),
}

/// All runs of an experiment.
#[derive(Debug)]
pub struct Plan {
    /// The folder of the recordings: the output folder and the experiment's name.
    pub folder: PathBuf,
    /// The runs, in the manifest's order.
    pub runs: Vec<PlannedRun>,
    /// The viewer's layout of the run to be executed with the largest view, with the time scale that all runs to be executed have;
    /// `None` if all runs are finished. An outline has none of large runs.
    pub layout: Option<String>,
}

/// The starts that planning builds.
#[derive(Clone, Copy)]
enum Starts {
    /// All; those that fit into `room` bytes are kept for their execution.
    All { room: u64 },
    /// Of a large run, only that of its sample.
    Sampled,
}

impl Starts {
    fn room(self) -> u64 {
        match self {
            Self::All { room } => room,
            Self::Sampled => KEPT_STARTS_BYTES,
        }
    }

    /// The estimate of a run, its start if that was built, and the seconds that the start takes.
    fn estimated(
        self,
        manifest: &RunManifest,
        (canonical, run_key): (&str, &RunKey),
        preparation: &RunPreparation<'_>,
    ) -> Result<(Estimate, Option<Prepared>, f64), SetupError> {
        let (started, proceed) = (Instant::now(), |fraction| preparation.proceed(fraction));
        if let (Self::Sampled, Some(sample)) = (self, sample_of(manifest)) {
            memory::check(manifest)?;
            let start = Prepared::new_while(&sample, canonical, run_key.as_str(), &proceed);
            // If there is no sample, the start itself tells why.
            if let Ok(start) = start {
                let size = manifest.model.particles() as f64 / sample.model.particles() as f64;
                let seconds = size * started.elapsed().as_secs_f64();
                return Ok((Estimate::of_sample(start.model.as_ref(), manifest)?, None, seconds));
            }
        }
        let start = Prepared::new_while(manifest, canonical, run_key.as_str(), &proceed)?;
        Ok((Estimate::of(&start, manifest), Some(start), started.elapsed().as_secs_f64()))
    }
}

/// The plots that a manifest requests, as the layout needs them.
fn panel_requests(experiment: &Experiment) -> Vec<PanelRequest> {
    let request = |plot: &PlotRequest| PanelRequest {
        subjects: plot
            .figure
            .as_deref()
            .into_iter()
            .chain(plot.ordinates())
            .map(str::to_owned)
            .collect(),
        title: plot.title.clone(),
    };
    experiment.plots.iter().map(request).collect()
}

/// What planning keeps of the starts that it builds.
struct Kept {
    free_bytes: u64,
    /// The plots for which the layout has panels.
    requests: Vec<PanelRequest>,
    /// The names of bodies.
    names: Vec<String>,
    /// Height of the largest view so far, index of its run, and the layout.
    layout: Option<(f64, usize, Option<String>)>,
    /// The different time scales so far.
    time_scales: HashSet<Option<String>>,
    /// Whether a run has frames without a drawing.
    is_thinned: bool,
}

impl Kept {
    /// Keeps the layout if the view is the largest so far, the time scale, and the start if there is room for it.
    fn take(&mut self, index: usize, start: Prepared, estimate: &Estimate) -> Option<Prepared> {
        let [[_, bottom], [_, top]] = start.header.scenery.view;
        let height = top - bottom;
        let is_largest = self.layout.as_ref().is_none_or(|(largest, at, _)| {
            height > *largest || (height == *largest && index < *at)
        });
        if is_largest {
            // A template that does not fit the model leaves the experiment without a layout.
            let layout = layout_json(&start.header, &self.requests);
            let layout = layout.and_then(|layout| with_names(&layout, &start.header, &self.names));
            self.layout = Some((height, index, layout.ok()));
        }
        self.time_scales.insert(start.header.simulated_per_second());
        self.is_thinned |= start.header.draw_every.get() > 1;
        self.free_bytes = self.free_bytes.checked_sub(start_bytes(estimate))?;
        Some(start)
    }

    fn into_layout(self) -> Option<String> {
        let (.., layout) = self.layout?;
        let layout = if self.is_thinned { with_states(&layout?).ok() } else { layout };
        if self.time_scales.len() > 1 { without_time_scale(&layout?).ok() } else { layout }
    }
}

/// Upper estimate of the memory of a start.
fn start_bytes(estimate: &Estimate) -> u64 {
    estimate.memory_bytes.saturating_sub(PROGRAM_BYTES)
}

impl Plan {
    /// Plans all runs of `experiment` below `output`. With `force`, no run counts as finished. After an interrupt, the runs whose
    /// starts are not complete are rejected.
    #[must_use]
    pub fn new<'a>(
        experiment: &Experiment,
        output: &Path,
        force: bool,
        preparation: impl Into<Preparation<'a>>,
    ) -> Self {
        let room = if experiment.runs.len() == 1 { u64::MAX } else { KEPT_STARTS_BYTES };
        let starts = Starts::All { room };
        let runs: Vec<usize> = (0..experiment.runs.len()).collect();
        Self::of(experiment, (output, force), starts, preparation.into(), &runs)
    }

    /// The plan without the starts of large runs, which are estimated from samples: for a plan that is not executed.
    #[must_use]
    pub fn outline<'a>(
        experiment: &Experiment,
        output: &Path,
        force: bool,
        preparation: impl Into<Preparation<'a>>,
    ) -> Self {
        let runs: Vec<usize> = (0..experiment.runs.len()).collect();
        Self::of(experiment, (output, force), Starts::Sampled, preparation.into(), &runs)
    }

    /// Plans only the runs with these run keys.
    ///
    /// # Errors
    /// The first key that belongs to no run.
    pub fn of_keys<'a>(
        experiment: &Experiment,
        output: &Path,
        force: bool,
        keys: &[String],
        preparation: impl Into<Preparation<'a>>,
    ) -> Result<Self, String> {
        let wanted: HashSet<&str> = keys.iter().map(String::as_str).collect();
        let room = if keys.len() == 1 { u64::MAX } else { KEPT_STARTS_BYTES };
        let (starts, points) = (Starts::All { room }, Points::of(&experiment.runs));
        let is_wanted = |run: &usize| {
            let (_, key) = points.identity(*run, &experiment.runs[*run].manifest);
            wanted.contains(key.as_str())
        };
        let runs: Vec<usize> =
            (0..experiment.runs.len()).into_par_iter().filter(is_wanted).collect();
        let plan = Self::of(experiment, (output, force), starts, preparation.into(), &runs);
        let planned: HashSet<&str> = plan.runs.iter().map(|run| run.run_key.as_str()).collect();
        match keys.iter().find(|key| !planned.contains(key.as_str())) {
            Some(unknown) => Err(unknown.clone()),
            None => Ok(plan),
        }
    }

    /// Builds the starts of the runs to be executed, on all processors, so that a run is rejected before the first one starts.
    fn of(
        experiment: &Experiment,
        (output, force): (&Path, bool),
        starts: Starts,
        preparation: Preparation<'_>,
        runs: &[usize],
    ) -> Self {
        let folder = output.join(&experiment.name);
        let free_bytes = starts.room();
        let requests = panel_requests(experiment);
        let names = experiment.view.names.clone();
        let kept = Mutex::new(Kept {
            free_bytes,
            requests,
            names,
            layout: None,
            time_scales: HashSet::new(),
            is_thinned: false,
        });
        let progress = StartProgress::new(preparation, runs.len());
        let points = Points::of(&experiment.runs);
        let named = Arc::new((experiment.name.clone(), experiment.replicates));
        let has_recordings = !force && has_recordings(&folder);
        let is_shared = matches!(starts, Starts::Sampled) && runs.len() > MOST_STARTED;
        let estimated = |index: usize, preparation: &RunPreparation<'_>| {
            let manifest = &experiment.runs[index].manifest;
            let (canonical, key) = points.identity(index, manifest);
            let identity = (canonical.as_str(), &key);
            let (estimate, start, seconds) = starts.estimated(manifest, identity, preparation)?;
            let mut kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
            let start = start.and_then(|start| kept.take(index, start, &estimate));
            Ok::<_, SetupError>((Arc::new(estimate), start, seconds))
        };
        let planned = |index: &usize| {
            let (preparation, run) = (progress.of_run(), &experiment.runs[*index]);
            let (_, run_key) = points.identity(*index, &run.manifest);
            let stem = || run.file_stem(&experiment.name, &run_key, experiment.replicates);
            let recorded = has_recordings.then(|| finished(&folder, &stem(), &run_key)).flatten();
            let of_point = || {
                points.estimate(*index, |first| {
                    let found = estimated(first, &preparation).ok();
                    found.map(|(estimate, _, seconds)| (estimate, seconds))
                })
            };
            let shared = (is_shared && recorded.is_none()).then(of_point).flatten();
            let (status, start, preparation_s) = match (recorded, shared) {
                (Some(outcome), _) => (Status::Done(outcome), None, 0.0),
                (None, Some((estimate, seconds))) => (Status::ToDo(estimate), None, seconds),
                (None, None) => match estimated(*index, &preparation) {
                    Ok((estimate, start, seconds)) => (Status::ToDo(estimate), start, seconds),
                    Err(error) => (Status::Rejected(error), None, 0.0),
                },
            };
            preparation.proceed(1.0);
            let (run, start) = (run.clone(), Mutex::new(start.map(Box::new)));
            let experiment = Arc::clone(&named);
            PlannedRun { run, run_key, status, experiment, preparation_s, start }
        };
        let runs = runs.par_iter().map(planned).collect();
        let kept = kept.into_inner().unwrap_or_else(PoisonError::into_inner);
        Self { folder, runs, layout: kept.into_layout() }
    }

    /// The runs to be executed.
    #[must_use]
    pub fn to_do(&self) -> Vec<&PlannedRun> {
        self.runs.iter().filter(|run| matches!(run.status, Status::ToDo(_))).collect()
    }

    /// The runs whose recordings exist and are finished, with their outcomes.
    pub fn finished(&self) -> impl Iterator<Item = (&PlannedRun, &Outcome)> {
        self.runs.iter().filter_map(|run| match &run.status {
            Status::Done(outcome) => Some((run, outcome)),
            _ => None,
        })
    }

    /// The runs to be executed in descending order of cost, so that no long run executes alone at the end.
    #[must_use]
    pub fn to_do_by_cost(&self) -> Vec<&PlannedRun> {
        let mut runs = self.to_do();
        let cost = |run: &PlannedRun| run.estimate().map_or(0.0, |estimate| estimate.relative_cost);
        runs.sort_by(|one, other| cost(other).total_cmp(&cost(one)));
        runs
    }

    /// Upper estimate of the memory of the starts that this plan has kept.
    #[must_use]
    pub fn kept_bytes(&self) -> u64 {
        let kept = self.runs.iter().filter(|run| run.has_start());
        let bytes = kept.filter_map(PlannedRun::estimate).map(start_bytes);
        bytes.fold(0, u64::saturating_add)
    }

    /// The runs that cannot be executed, with the reason.
    pub fn rejected(&self) -> impl Iterator<Item = (&PlannedRun, &SetupError)> {
        self.runs.iter().filter_map(|run| match &run.status {
            Status::Rejected(error) => Some((run, error)),
            Status::Done(_) | Status::ToDo(_) => None,
        })
    }

    /// The recordings that keep only keyframes and have no restored one next to them.
    #[must_use]
    pub fn unrestored(&self) -> Vec<PathBuf> {
        let is_unrestored = |run: &&PlannedRun| {
            let restored = run.restored_file_name();
            restored.is_some_and(|restored| !self.folder.join(restored).exists())
        };
        let runs = self.runs.iter().filter(is_unrestored);
        runs.map(|run| self.folder.join(run.file_name())).collect()
    }
}

impl PlannedRun {
    /// The run as [`crate::run::execute`] takes it.
    #[must_use]
    pub fn spec<'a>(&'a self, folder: &'a Path) -> RunSpec<'a> {
        RunSpec {
            manifest: &self.run.manifest,
            canonical: self.run.manifest.canonical(),
            run_key: self.run_key.as_str(),
            folder,
            stem: self.stem(),
        }
    }

    /// Takes the run's start, if the plan has kept it.
    #[must_use]
    pub fn take_start(&self) -> Option<Prepared> {
        self.start.lock().unwrap_or_else(PoisonError::into_inner).take().map(|start| *start)
    }

    /// Whether the plan has kept the run's start.
    fn has_start(&self) -> bool {
        self.start.lock().unwrap_or_else(PoisonError::into_inner).is_some()
    }

    /// The resources of a run that is to be executed.
    #[must_use]
    pub fn estimate(&self) -> Option<&Estimate> {
        match &self.status {
            Status::ToDo(estimate) => Some(estimate),
            Status::Done(_) | Status::Rejected(_) => None,
        }
    }

    /// Seconds on one core within a factor of some three, to order the runs of several experiments. For a run that ends at a time, the
    /// number of events is not known, and only the frames count.
    #[must_use]
    pub fn nominal_seconds(&self) -> f64 {
        self.estimate().map_or(0.0, |estimate| {
            let count = match estimate.extent {
                Extent::Steps { total, .. } | Extent::Events(total) => total,
                Extent::Time(_) => 0,
            };
            nominal_seconds(&self.run.manifest, count, estimate.frames)
        })
    }

    /// The recording's file name without its extension.
    #[must_use]
    pub fn stem(&self) -> String {
        let (name, replicates) = &*self.experiment;
        self.run.file_stem(name, &self.run_key, *replicates)
    }

    /// The outcome of its finished recording in `folder`, whose whole key is checked.
    #[must_use]
    pub fn recorded(&self, folder: &Path) -> Option<Outcome> {
        finished(folder, &self.stem(), &self.run_key)
    }

    /// The outcome of a recording if it is finished and has this run's whole key.
    #[must_use]
    pub fn outcome_in(&self, recording: &Recording) -> Option<Outcome> {
        outcome(recording, &self.run_key)
    }

    /// The recording's file name.
    #[must_use]
    pub fn file_name(&self) -> String {
        format!("{}.mcap", self.stem())
    }

    /// The file in which `kinetoscope fill` restores the run, if it keeps only keyframes.
    #[must_use]
    pub fn restored_file_name(&self) -> Option<String> {
        let manifest = &self.run.manifest;
        manifest.record.distance_of_keyframes()?;
        let physics_version = kind_of(&manifest.model).physics_version;
        let canonical = manifest.with_all_frames().canonical();
        let key = run_key(&canonical, physics_version, SCHEMA_VERSION);
        Some(format!("{}.mcap", key.in_place_of(self.run_key.as_str(), &self.stem())?))
    }
}

/// Whether a folder has any recording: otherwise, none is searched for a million runs.
fn has_recordings(folder: &Path) -> bool {
    let files = std::fs::read_dir(folder).into_iter().flatten().flatten();
    files.into_iter().any(|file| file.path().extension().is_some_and(|end| end == "mcap"))
}

/// The outcome of a finished recording with the whole key: the file name contains only the start of the key.
fn finished(folder: &Path, stem: &str, run_key: &RunKey) -> Option<Outcome> {
    outcome(&Recording::open(&folder.join(format!("{stem}.mcap"))).ok()?, run_key)
}

fn outcome(recording: &Recording, run_key: &RunKey) -> Option<Outcome> {
    let provenance = recording.provenance();
    match provenance.outcome.clone()? {
        Outcome::Interrupted => None,
        outcome => (provenance.run_key == run_key.as_str()).then_some(outcome),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may panic")]
mod tests {
    use super::*;
    use crate::interrupt::Interrupt;

    /// Guarantee: an outline of many runs, which builds the start of one replicate of each point, has the keys and the estimates of the plan.
    #[test]
    fn outline_of_many_replicates_has_the_estimates_of_the_plan() {
        let output = tempfile::tempdir().unwrap();
        let text = "seed = 1\nreplicates = 600\n[model.gas]\nparticles = 20\n[record]\nframes = 6\n[sweep]\n\"model.gas.particles\" = [20, 30]\n";
        let experiment = kinetoscope_manifest::parse(text, "many.toml", &[]).unwrap();
        let plan = Plan::new(&experiment, output.path(), false, &Interrupt::default());
        let outline = Plan::outline(&experiment, output.path(), false, &Interrupt::default());
        assert!(plan.runs.len() > MOST_STARTED && outline.runs.len() == plan.runs.len());
        for (one, other) in plan.runs.iter().zip(&outline.runs) {
            assert_eq!(one.run_key, other.run_key);
            assert_eq!(one.estimate(), other.estimate());
        }
    }

    /// Guarantee: an outline, which builds only the sample of a large run, has the estimates of the plan, which builds its start.
    #[test]
    fn outline_has_the_estimates_of_the_plan() {
        let output = tempfile::tempdir().unwrap();
        for model in [
            "[model.gas]\nparticles = 200000\n",
            "[model.packing]\ndiscs = 200000\nwidth = 1400.0\nheight = 1500.0\nplacement = \"lattice\"\n",
            "[model.dem]\ndiscs = 200000\nwidth_m = 0.5\nheight_m = 0.6\nstiffness_n_per_m = 4e6\nplacement = \"lattice\"\nfriction = 0.5\n",
        ] {
            let text = format!("seed = 1\n{model}[record]\nframes = 60\n");
            let experiment = kinetoscope_manifest::parse(&text, "large.toml", &[]).unwrap();
            let run = &experiment.runs[0].manifest;
            assert!(sample_of(run).is_some(), "{model} has no sample");
            let plan = Plan::new(&experiment, output.path(), false, &Interrupt::default());
            let outline = Plan::outline(&experiment, output.path(), false, &Interrupt::default());
            assert!(plan.runs[0].estimate().is_some(), "{model}: {:?}", plan.runs[0].status);
            assert_eq!(outline.runs[0].estimate(), plan.runs[0].estimate(), "{model}");
            assert!(plan.runs[0].take_start().is_some() && outline.runs[0].take_start().is_none());
        }
    }
}
