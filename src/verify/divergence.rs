//! Why two runs differ: rounding errors that chaos amplifies, or different physics.
//!
//! The separation of two states is the largest difference of a value, in units of the largest value of its column so far; parts of
//! two files with the same bytes are not decoded and do not count. A
//! rounding error starts at 2^-53 of a value and is amplified by each step; a change of a coefficient or a formula
//! is visible above that level when the states differ for the first time. Between the last equal frame and the first one that
//! differs, a chaotic system may amplify a rounding error to any size. Therefore, both runs are executed again up to the step at
//! which their states differ.

use crate::interrupt::Interrupt;
use crate::run::prepared::Prepared;
use crate::verify::rerun::advance;
use crate::verify::source::Source;
use kinetoscope_physics::model::{Extent, Model, Target};
use kinetoscope_recording::error::ReadError;
use kinetoscope_recording::frame::Frame;
use kinetoscope_recording::paired_frames::PairedFrames;
use kinetoscope_recording::reader::{RecordedFrame, Recording};

/// Separation up to which a difference can be a rounding error of one step: some ten thousand units in the last place, because
/// a force is computed from a small difference of large positions.
pub const ROUNDING: f64 = 1e-11;
/// Separation above which two states are unrelated.
pub const UNRELATED: f64 = 0.1;
/// Instants at which a model without steps is compared between two frames.
const INSTANTS: u64 = 4096;
/// Values of a state in the frames after the first difference, from which the growth follows; more would take seconds.
const MOST_VALUES: usize = 1 << 22;

/// Where and by how much two runs differ for the first time.
#[derive(Clone, Debug, PartialEq)]
pub struct Divergence {
    /// Index of the first frame that differs.
    pub frame: u64,
    /// The step at which the states differ for the first time, if both runs were executed again.
    pub step: Option<Step>,
    /// The separation there, or in the first frame that differs.
    pub separation: f64,
    /// Time of the first frame that differs.
    time: f64,
    /// Time of the first frame with a separation above [`UNRELATED`], if one was compared.
    pub unrelated: Option<f64>,
    /// The particles that differ there; all if the number of particles differs.
    pub particles: Vec<usize>,
    /// The separation afterwards; `None` if no later frame was compared.
    pub growth: Option<Growth>,
    /// The model's unit of time.
    pub time_unit: String,
    /// Whether the time steps differ, so that the runs were not compared step by step.
    pub has_other_steps: bool,
}

/// The separation after the first difference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Growth {
    /// The last frame that was compared.
    pub frame: u64,
    /// The separation there.
    pub separation: f64,
    /// Time in which the separation grows by a factor of e, if it grows exponentially up to a thousandth.
    pub time_per_e: Option<f64>,
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
    /// Time and separation of the first difference.
    #[must_use]
    pub fn first(&self) -> (f64, f64) {
        (self.step.map_or(self.time, |step| step.time), self.separation)
    }

    /// The cause that follows from the first difference.
    #[must_use]
    pub fn cause(&self) -> Cause {
        match (self.separation <= ROUNDING, self.step) {
            (true, _) => Cause::Rounding,
            (false, Some(_)) => Cause::Physics,
            (false, None) if self.frame == 0 || self.has_other_steps => Cause::Physics,
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

    /// The scale of each column for differences. A column that is zero but for rounding errors, such as the spins of discs that
    /// collide head-on, has no scale of its own: it takes the largest one of the state.
    fn for_differences(&self) -> Vec<f64> {
        let largest = self
            .0
            .iter()
            .fold(0.0, |largest, &scale| if scale > largest { scale } else { largest });
        let is_zero = |scale: f64| scale <= ROUNDING * largest;
        self.0.iter().map(|&scale| if is_zero(scale) { largest } else { scale }).collect()
    }

    /// The separation of two states, and the particles that differ.
    fn separation(&self, one: &[f64], other: &[f64]) -> (f64, Vec<usize>) {
        let scales = self.for_differences();
        let columns = scales.len().max(1);
        if one.len() != other.len() {
            return (f64::INFINITY, (0..one.len().max(other.len()) / columns).collect());
        }
        let (mut largest, mut particles) = (0.0, Vec::new());
        let rows = one.chunks_exact(columns).zip(other.chunks_exact(columns));
        for (particle, (one, other)) in rows.enumerate() {
            let mut differs = false;
            for ((a, b), scale) in one.iter().zip(other).zip(&scales) {
                differs |= a.to_bits() != b.to_bits();
                // 0.0 and -0.0 differ in their bits only.
                if a.to_bits() != b.to_bits() && a != b {
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
    let (mut points, mut compared) = (Vec::new(), 0);
    let mut pairs = PairedFrames::that_can_differ(left, right)?;
    while let Ok([Some(one), Some(other)]) = pairs.advance() {
        // Between keyframes, only scalars are stored; a recording without states has none to compare.
        let has_state = |frame: &RecordedFrame| frame.is_complete() && frame.state().is_some();
        if !has_state(&one) || !has_state(&other) {
            continue;
        }
        let [a, b] = [values(&one), values(&other)];
        scales.add(&a, columns);
        scales.add(&b, columns);
        let (separation, particles) = scales.separation(&a, &b);
        match &mut found {
            None if !particles.is_empty() => {
                points.push((one.clock.time, separation));
                let (frame, time) = (one.clock.frame, one.clock.time);
                found = Some(Divergence {
                    frame,
                    step: None,
                    separation,
                    time,
                    unrelated: (separation > UNRELATED).then_some(time),
                    particles,
                    growth: None,
                    time_unit: one.clock.time_unit.clone(),
                    has_other_steps: false,
                });
            }
            None => {}
            Some(divergence) => {
                // Beyond a thousandth, no growth is exponential.
                let was_small = divergence.growth.is_none_or(|growth| growth.separation <= 1e-3);
                if separation <= 1e-3 && was_small {
                    points.push((one.clock.time, separation));
                }
                let (frame, time) = (one.clock.frame, one.clock.time);
                if was_small {
                    divergence.growth =
                        Some(Growth { frame, separation, time_per_e: time_per_e(&points) });
                }
                if separation > UNRELATED && divergence.unrelated.is_none() {
                    divergence.unrelated = Some(time);
                }
                compared += a.len();
                if divergence.unrelated.is_some() || compared > MOST_VALUES {
                    break;
                }
            }
        }
    }
    Ok(found)
}

/// Time in which a separation grows by a factor of e; `None` unless it grows by 100 or more at rates that agree within a factor
/// of 2 in both halves: growth by a power of time is fast at first.
fn time_per_e(points: &[(f64, f64)]) -> Option<f64> {
    let [first, .., last] = points else { return None };
    let middle = points[points.len() / 2];
    let rate = |from: (f64, f64), to: (f64, f64)| libm::log(to.1 / from.1) / (to.0 - from.0);
    let [early, late] = [rate(*first, middle), rate(middle, *last)];
    let is_exponential =
        last.1 >= 100.0 * first.1 && early > 0.0 && early <= 2.0 * late && late <= 2.0 * early;
    is_exponential.then(|| 1.0 / rate(*first, *last))
}

/// Executes both runs again up to the first step at which their states differ. Only states of the same time are compared, or
/// those after the same number of events. `None` if a run cannot be executed by this program, gives other numbers than the
/// recording, or was interrupted, or if no such states before the frame differ.
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
    let mut runs = [start_of(left, interrupt)?, start_of(right, interrupt)?];
    if have_other_steps(&runs) {
        return Some(Divergence { has_other_steps: true, ..divergence.clone() });
    }
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
            advance(&mut *run.model, run.schedule.target(frame - 1), interrupt).ok()?;
        }
        let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        if bits(&observed(&*run.model)) != bits(recorded) {
            return None;
        }
    }
    let instants = common_instants(&runs, frame)?;
    let [one, other] = runs.each_mut().map(|run| &mut *run.model);
    let mut scales = Scales::default();
    let columns = left.state_columns().len();
    recorded.iter().for_each(|values| scales.add(values, columns));
    for [a, b] in instants {
        advance(one, a, interrupt).ok()?;
        advance(other, b, interrupt).ok()?;
        let count = match [a, b] {
            [Target::Count(count), _] | [_, Target::Count(count)] => count,
            _ => one.count(),
        };
        let step = Step { count, time: one.time() };
        let (a, b) = (observed(one), observed(other));
        scales.add(&a, columns);
        let (separation, particles) = scales.separation(&a, &b);
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

/// Whether two times are the same apart from rounding errors.
fn is_same(one: f64, other: f64) -> bool {
    (one - other).abs() <= ROUNDING * (one.abs() + other.abs())
}

fn have_other_steps(runs: &[Prepared; 2]) -> bool {
    match runs.each_ref().map(|run| run.model.extent()) {
        [Extent::Steps { step: one, .. }, Extent::Steps { step: other, .. }] => {
            !is_same(one, other)
        }
        _ => false,
    }
}

/// The steps or events from the predecessor of a frame to the frame, or instants of models without steps: the targets of both
/// runs, which have the same time. `None` if there are none.
fn common_instants(runs: &[Prepared; 2], frame: u64) -> Option<Vec<[Target; 2]>> {
    let [one, other] = runs.each_ref().map(|run| &run.model);
    let (from, extents) = (one.time(), [one.extent(), other.extent()]);
    let is_aligned = match extents {
        [Extent::Events(_), Extent::Events(_)] => one.count() == other.count(),
        _ => is_same(from, other.time()),
    };
    if !is_aligned {
        return None;
    }
    let counts = |model: &dyn Model, end: u64| model.count() + 1..=end;
    let of_steps = |model: &dyn Model, step: f64, to: u64, end: f64| {
        let times = counts(model, to).map(move |count| (count, count as f64 * step));
        let times = times.take_while(move |(_, time)| *time <= end || is_same(*time, end));
        times.map(move |(count, time)| {
            [Target::Count(count), Target::Time(if time < end { time } else { end })]
        })
    };
    let targets = runs.each_ref().map(|run| run.schedule.target(frame));
    Some(match (targets, extents) {
        ([Target::Count(to), Target::Time(end)], [Extent::Steps { step, .. }, _]) => {
            of_steps(&**one, step, to, end).collect()
        }
        ([Target::Time(end), Target::Count(to)], [_, Extent::Steps { step, .. }]) => {
            of_steps(&**other, step, to, end).map(|[one, other]| [other, one]).collect()
        }
        ([Target::Count(one_end), Target::Count(other_end)], _) => {
            counts(&**one, one_end.min(other_end)).map(|count| [Target::Count(count); 2]).collect()
        }
        ([Target::Time(one_end), Target::Time(other_end)], _) => {
            let end = if one_end < other_end { one_end } else { other_end };
            let of = |part: u64| from + (end - from) * (part as f64 / INSTANTS as f64);
            (1..INSTANTS).map(of).chain([end]).map(|time| [Target::Time(time); 2]).collect()
        }
        _ => return None,
    })
}

/// The start of the run of a recording; `None` if this program cannot execute it, or after an interrupt.
fn start_of(recording: &Recording, interrupt: &Interrupt) -> Option<Prepared> {
    Source::of(recording).ok()?.prepared(interrupt).ok()
}

/// The values of a model's state, row by row.
fn observed(model: &dyn Model) -> Vec<f64> {
    let mut frame = Frame::new();
    model.observe(&mut frame);
    frame.state().to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn time_per_e_of(separation: impl Fn(f64) -> f64) -> [Option<f64>; 3] {
        [3, 10, 100].map(|frames| {
            let points = (1..=frames).map(|frame| (f64::from(frame), separation(f64::from(frame))));
            time_per_e(&points.collect::<Vec<_>>())
        })
    }

    /// Guarantee: columns that are zero in both states but for rounding errors are no different physics. Values: the spins of a
    /// head-on collision with another rounding mode, as one run has 0 and the other -0 or -1.4e-20.
    #[test]
    fn rounding_of_a_column_that_is_zero_is_rounding() {
        let of = |one: &[f64; 3], other: &[f64; 3]| {
            let mut scales = Scales::default();
            scales.add(one, 3);
            scales.add(other, 3);
            scales.separation(one, other)
        };
        let (separation, particles) = of(&[0.1, 2.0, 0.0], &[0.1, 2.0, -0.0]);
        assert_eq!((separation, particles), (0.0, vec![0]));
        let (separation, particles) = of(&[0.1, 2.0, 0.0], &[0.1, 2.0, -1.4e-20]);
        assert!(separation <= ROUNDING && particles == [0], "{separation}");
        let (separation, _) = of(&[0.1, 2.0, 0.0], &[0.1, 2.0, 1e-3]);
        assert!(separation > ROUNDING, "control_spin_of_a_friction_that_differs: {separation}");
        assert_eq!(of(&[0.0; 3], &[-0.0; 3]), (0.0, vec![0]));
    }

    /// Law: exp(t/τ) has the rate 1/τ at any time; t and t² have none, however many frames are compared.
    #[test]
    fn only_exponential_growth_has_a_rate() {
        let [few, some, many] = time_per_e_of(|time| 1e-16 * libm::exp(time / 1.25));
        assert_eq!(few, None);
        assert!((some.unwrap() - 1.25).abs() < 1e-12 && (many.unwrap() - 1.25).abs() < 1e-12);
        assert_eq!(time_per_e_of(|time| 1e-16 * time), [None; 3]);
        assert_eq!(time_per_e_of(|time| 1e-16 * time * time), [None; 3]);
        assert_eq!(time_per_e_of(|_| 1e-16), [None; 3]);
        assert_eq!(time_per_e_of(|time| if time > 2.0 { 1e-16 * time } else { 0.0 }), [None; 3]);
    }
}
