//! Limits of the runs of an answer, most of which are checked before the runs are executed.

use crate::grading::key::Key;
use crate::messages::progress::size;
use crate::messages::{Failure, bad, plural};
use kinetoscope::Run;
use kinetoscope::interrupt::Interrupt;
use kinetoscope::run::prepared::Prepared;
use kinetoscope::run::resources::Estimate;
use kinetoscope::run::resources::time::measured_seconds;
use kinetoscope_console::text::one_line;
use kinetoscope_console::{Exit, Explained as _};
use kinetoscope_manifest::Experiment;

/// Maximum number of runs of an answer.
const MOST_RUNS: usize = 64;
/// Maximum number of particles of a run.
const MOST_PARTICLES: u64 = 20_000;
/// Maximum size of all recordings, bytes.
const MOST_RECORDED_BYTES: u64 = 64 << 20;
/// Maximum time of all runs, s.
const MOST_SECONDS: u64 = 60;
/// The same if they are not the runs that the exercise asks for.
const MOST_OTHER_SECONDS: u64 = 30;
/// Maximum work, and maximum number of particles of a run, as a multiple of those of the solution. More replicates are welcome.
const MOST_TIMES: u32 = 4;

/// The limits of an answer.
#[derive(Debug)]
pub(crate) struct Limits<'a> {
    key: Option<&'a Key>,
    /// The keys in which its manifest differs from that of the exercise.
    others: Vec<String>,
}

impl<'a> Limits<'a> {
    /// The limits of an experiment, relative to the solution if the key is given.
    pub(crate) fn new(experiment: &Experiment, key: Option<&'a Key>) -> Self {
        Self { key, others: key.map(|key| key.other_keys(experiment)).unwrap_or_default() }
    }

    /// Maximum time of all runs, s.
    pub(crate) fn seconds(&self) -> u64 {
        if self.others.is_empty() { MOST_SECONDS } else { MOST_OTHER_SECONDS }
    }

    /// The error of runs beyond a limit, with the keys that may be the reason.
    pub(crate) fn exceeded(&self, what: &str) -> Failure {
        let listed: Vec<String> =
            self.others.iter().map(|key| format!("`{}`", one_line(key))).collect();
        let what = match listed.is_empty() {
            true => what.to_owned(),
            false => format!("{what}: check {}", listed.join(", ")),
        };
        bad(what).help("use the duration, frames and numbers that the exercise asks for")
    }

    /// Rejects before it is run what no exercise needs.
    pub(crate) fn check(&self, experiment: &Experiment, stop: &Interrupt) -> Result<(), Failure> {
        if experiment.runs.len() > MOST_RUNS {
            let found = plural(experiment.runs.len() as u64, "run");
            let what = format!("the manifest has {found}; at most {MOST_RUNS} are graded");
            return Err(self.exceeded(&what));
        }
        let (particles, most) = (most_particles(experiment), self.most_particles());
        if particles > most {
            let what = format!("a run has {particles} particles; at most {most} are graded");
            return Err(self.exceeded(&what));
        }
        let (mut bytes, mut work, mut costliest) = (0, 0.0, None);
        for run in &experiment.runs {
            let (start, estimate) = estimated(run, stop)?;
            bytes += estimate.bytes;
            work += estimate.relative_cost;
            if costliest.as_ref().is_none_or(|(_, _, cost)| estimate.relative_cost > *cost) {
                costliest = Some((run, start, estimate.relative_cost));
            }
        }
        if bytes > MOST_RECORDED_BYTES {
            let (found, most) = (size(bytes), size(MOST_RECORDED_BYTES));
            let what = format!("the recordings have up to {found}; at most {most} are graded");
            return Err(self.exceeded(&what));
        }
        let Some(key) = self.key else { return Ok(()) };
        if work > f64::from(MOST_TIMES) * work_of_solution(key, stop)? {
            let what =
                format!("the runs take more than {MOST_TIMES} times the work of the exercise");
            return Err(self.exceeded(&what));
        }
        // The events of a run that ends at a time are not known before it.
        if let (false, Some((run, start, _))) = (self.others.is_empty(), costliest) {
            let each = measured_seconds(&run.manifest, Some(start), stop).unwrap_or(0.0);
            let seconds = each * experiment.runs.len() as f64;
            if seconds > MOST_OTHER_SECONDS as f64 {
                return Err(self.exceeded(&self.too_slow()));
            }
        }
        Ok(())
    }

    /// What is wrong with runs that take too long.
    pub(crate) fn too_slow(&self) -> String {
        format!("the runs take more than {} s", self.seconds())
    }

    fn most_particles(&self) -> u64 {
        let most = |key: &Key| most_particles(&key.solution).saturating_mul(u64::from(MOST_TIMES));
        self.key.map_or(MOST_PARTICLES, most).min(MOST_PARTICLES)
    }
}

fn most_particles(experiment: &Experiment) -> u64 {
    experiment.runs.iter().map(|run| run.manifest.model.particles()).max().unwrap_or(0)
}

fn estimated(run: &Run, stop: &Interrupt) -> Result<(Prepared, Estimate), Failure> {
    let manifest = &run.manifest;
    let start = Prepared::new(manifest, &manifest.canonical(), "", stop)
        .map_err(|error| Failure::of(Exit::BadInput, error.message()))?;
    let estimate = Estimate::of(&start, manifest);
    Ok((start, estimate))
}

fn work_of_solution(key: &Key, stop: &Interrupt) -> Result<f64, Failure> {
    if let Some(work) = key.work.get() {
        return Ok(*work);
    }
    let of_run = |run: &Run| Ok(estimated(run, stop)?.1.relative_cost);
    let work = key.solution.runs.iter().map(of_run).sum::<Result<f64, Failure>>()?;
    Ok(*key.work.get_or_init(|| work))
}
