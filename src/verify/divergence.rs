//! Why two runs differ: rounding errors that chaos amplifies, or different physics.
//!
//! The separation of two states is the largest difference of a value, in units of the largest value of its column so far; parts of
//! two files with the same bytes are not decoded and do not count. A
//! rounding error starts at 2^-53 of a value and is amplified by each step; a change of a coefficient or a formula
//! is visible above that level when the states differ for the first time. Between the last equal frame and the first one that
//! differs, a chaotic system may amplify a rounding error to any size. Therefore, both runs are executed again up to the step at
//! which their states differ.

use crate::interrupt::Interrupt;
use crate::plan::restart_files::StartFiles;
use crate::run::prepared::Prepared;
use kinetoscope_manifest::parse_run;
use kinetoscope_physics::model::{Progress, Target};
use kinetoscope_recording::error::ReadError;
use kinetoscope_recording::frame::Frame;
use kinetoscope_recording::paired_frames::PairedFrames;
use kinetoscope_recording::reader::{RecordedFrame, Recording};
use std::path::Path;

/// Separation up to which a difference can be a rounding error of one step: some ten thousand units in the last place, because
/// a force is computed from a small difference of large positions.
pub const ROUNDING: f64 = 1e-11;
/// Instants at which a model without steps is compared between two frames.
const INSTANTS: u64 = 4096;
/// Values of a state in the frames after the first difference, from which the growth follows; more would take seconds.
const MOST_VALUES: usize = 1 << 22;
/// Steps of one call, after which an interrupt is noticed.
const BUDGET: u64 = 10_000;

/// Where and by how much two runs differ for the first time.
#[derive(Clone, Debug, PartialEq)]
pub struct Divergence {
    /// Index of the first frame that differs.
    pub frame: u64,
    /// The step at which the states differ for the first time, if both runs were executed again.
    pub step: Option<Step>,
    /// The separation there, or in the first frame that differs.
    pub separation: f64,
    /// The particles that differ there; all if the number of particles differs.
    pub particles: Vec<usize>,
    /// Time in which the separation of the following frames grows by a factor of e, if it grows.
    pub growth_time: Option<f64>,
}

/// The instant of a first difference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Number of steps or events since the start.
    pub count: u64,
    /// Time since the start, in the model's unit.
    pub time: f64,
}

/// The cause of a difference.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// Rounding errors, amplified or not.
    Rounding,
    /// Different equations, coefficients or initial values.
    Physics,
    /// The frames are too far apart: the first step that differs must be found.
    Undecided,
}

impl Divergence {
    /// The cause that follows from the first difference.
    #[must_use]
    pub fn cause(&self) -> Cause {
        match (self.separation <= ROUNDING, self.step) {
            (true, _) => Cause::Rounding,
            (false, Some(_)) => Cause::Physics,
            (false, None) if self.frame == 0 => Cause::Physics,
            (false, None) => Cause::Undecided,
        }
    }
}

/// The largest absolute value of each column in the frames that were decoded.
#[derive(Default)]
struct Scales(Vec<f64>);

impl Scales {
    fn add(&mut self, values: &[f64], columns: usize) {
        self.0.resize(columns, 0.0);
        for row in values.chunks_exact(columns.max(1)) {
            for (scale, value) in self.0.iter_mut().zip(row) {
                if value.abs() > *scale {
                    *scale = value.abs();
                }
            }
        }
    }

    /// The separation of two states, and the particles that differ.
    fn separation(&self, one: &[f64], other: &[f64]) -> (f64, Vec<usize>) {
        let columns = self.0.len().max(1);
        if one.len() != other.len() {
            return (f64::INFINITY, (0..one.len().max(other.len()) / columns).collect());
        }
        let (mut largest, mut particles) = (0.0, Vec::new());
        let rows = one.chunks_exact(columns).zip(other.chunks_exact(columns));
        for (particle, (one, other)) in rows.enumerate() {
            let mut differs = false;
            for ((a, b), scale) in one.iter().zip(other).zip(&self.0) {
                if a.to_bits() != b.to_bits() {
                    differs = true;
                    let difference = ((a - b) / scale).abs();
                    if difference.is_nan() || difference > largest {
                        largest = if difference.is_nan() { f64::INFINITY } else { difference };
                    }
                }
            }
            if differs {
                particles.push(particle);
            }
        }
        (largest, particles)
    }
}

/// The values of a recorded state, row by row.
fn values(frame: &RecordedFrame) -> Vec<f64> {
    let Some(state) = frame.state() else { return Vec::new() };
    (0..state.rows()).flat_map(|row| state.row(row).iter().copied()).collect()
}

/// Where the states of two recordings differ for the first time; `None` if all common frames are equal, or if the columns are
/// not the same. Memory: two frames.
///
/// # Errors
/// A recording that cannot be read. Damage ends the search.
pub fn in_frames(left: &Recording, right: &Recording) -> Result<Option<Divergence>, ReadError> {
    if left.state_columns() != right.state_columns() {
        return Ok(None);
    }
    let columns = left.state_columns().len();
    let (mut scales, mut found) = (Scales::default(), None::<Divergence>);
    let (mut start, mut compared) = (0.0, 0);
    let mut pairs = PairedFrames::that_can_differ(left, right)?;
    while let Ok([Some(one), Some(other)]) = pairs.advance() {
        let [a, b] = [values(&one), values(&other)];
        scales.add(&a, columns);
        scales.add(&b, columns);
        let (separation, particles) = scales.separation(&a, &b);
        match &mut found {
            None if !particles.is_empty() => {
                start = one.clock.time;
                let frame = one.clock.frame;
                found = Some(Divergence {
                    frame,
                    step: None,
                    separation,
                    particles,
                    growth_time: None,
                });
            }
            None => {}
            Some(divergence) => {
                // Up to a thousandth, the growth is exponential.
                let factor = separation / divergence.separation;
                compared += a.len();
                if separation > 1e-3 || separation.is_nan() || compared > MOST_VALUES {
                    break;
                }
                if factor > std::f64::consts::E {
                    divergence.growth_time = Some((one.clock.time - start) / libm::log(factor));
                }
            }
        }
    }
    Ok(found)
}

/// Executes both runs again up to the first step at which their states differ. `None` if a run cannot be executed by this
/// program, gives other numbers than the recording, or was interrupted.
#[must_use]
pub fn find_step(
    [left, right]: [&Recording; 2],
    divergence: &Divergence,
    interrupt: &Interrupt,
) -> Option<Divergence> {
    let frame = divergence.frame;
    if frame == 0 {
        return None;
    }
    let mut runs = [Rerun::new(left)?, Rerun::new(right)?];
    let recorded: Vec<Vec<f64>> = [left, right]
        .into_iter()
        .map(|recording| {
            let mut frames = recording.frames().ok()?;
            frames.find_map(|found| found.ok().filter(|found| found.clock.frame + 1 == frame))
        })
        .map(|found| Some(values(&found?)))
        .collect::<Option<_>>()?;
    for (run, recorded) in runs.iter_mut().zip(&recorded) {
        if frame > 1 {
            run.advance(run.start.schedule.target(frame - 1), interrupt)?;
        }
        let same = run.observe().iter().map(|value| value.to_bits());
        if !same.eq(recorded.iter().map(|value| value.to_bits())) {
            return None;
        }
    }
    let [one, other] = &mut runs;
    let mut scales = Scales::default();
    let columns = left.state_columns().len();
    recorded.iter().for_each(|values| scales.add(values, columns));
    let instants = one.instants(frame).into_iter().zip(other.instants(frame));
    for (a, b) in instants {
        one.advance(a, interrupt)?;
        other.advance(b, interrupt)?;
        let step = Step { count: one.start.model.count(), time: one.start.model.time() };
        let (a, b) = (one.observe().to_vec(), other.observe());
        scales.add(&a, columns);
        let (separation, particles) = scales.separation(&a, b);
        if !particles.is_empty() {
            return Some(Divergence {
                step: Some(step),
                separation,
                particles,
                ..divergence.clone()
            });
        }
    }
    None
}

/// A run that is executed again.
struct Rerun {
    start: Prepared,
    frame: Frame,
}

impl Rerun {
    fn new(recording: &Recording) -> Option<Self> {
        let mut manifest = parse_run(recording.manifest()).ok()?;
        let folder = recording.path().parent().unwrap_or(Path::new("."));
        let starts = StartFiles::relative_to(folder);
        manifest.model.read_start(&|name: &str| starts.read(name)).ok()?;
        let key = &recording.provenance().run_key;
        let start = Prepared::new(&manifest, recording.manifest(), key).ok()?;
        Some(Self { start, frame: Frame::new() })
    }

    /// The steps, or the instants of a model without steps, from a frame's predecessor to the frame.
    fn instants(&self, frame: u64) -> Vec<Target> {
        match self.start.schedule.target(frame) {
            Target::Count(end) => (self.start.model.count() + 1..=end).map(Target::Count).collect(),
            Target::Time(end) => {
                let from = self.start.model.time();
                let of = |part: u64| from + (end - from) * (part as f64 / INSTANTS as f64);
                (1..INSTANTS).map(of).chain([end]).map(Target::Time).collect()
            }
        }
    }

    /// Advances to a target; `None` after a fault or an interruption.
    fn advance(&mut self, target: Target, interrupt: &Interrupt) -> Option<()> {
        while self.start.model.advance(target, BUDGET).ok()? == Progress::Working {
            if interrupt.is_raised() {
                return None;
            }
        }
        Some(())
    }

    fn observe(&mut self) -> &[f64] {
        self.frame.clear();
        self.start.model.observe(&mut self.frame);
        self.frame.state()
    }
}
