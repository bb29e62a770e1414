//! Integration of bodies over many steps: steps of fixed length, or the steps that the adaptive method chooses.

use super::adaptive::{AdaptiveStep, Attempt, try_step};
use super::dormand_prince::DORMAND_PRINCE_8;
use super::integrators::{MethodVisitor, with_fixed_steps};
use super::motion::{Force, Phase};
use super::path::{PathTracker, StepPath};
use super::single_step::{IntegrationState, Method};
use kinetoscope_manifest::model::{OrbitIntegrator, OrbitSummation};
use serde::{Deserialize, Serialize};

/// Discretization of the equations of motion.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Discretization {
    pub(super) integrator: OrbitIntegrator,
    pub(super) summation: OrbitSummation,
    /// h, days; for the adaptive method, the first step to try and the spacing of the times at which frames are possible.
    pub(super) step: f64,
    /// Relative error per step of the adaptive method.
    pub(super) tolerance: f64,
}

impl Discretization {
    /// Time of a step, days.
    pub(super) fn time_at(&self, count: u64) -> f64 {
        count as f64 * self.step
    }

    /// The last multiple of the step before a positive time.
    fn count_before(&self, time: f64) -> u64 {
        // The quotient is rounded, so that the first candidates may be too large.
        let mut counts = (0..=(time / self.step).ceil() as u64).rev();
        counts.find(|&count| self.time_at(count) < time).unwrap_or(0)
    }
}

/// The work of one call.
#[derive(Clone, Copy)]
pub(super) struct StepBudget {
    /// Maximum number of steps.
    pub(super) steps: u64,
    /// Maximum number of attempted steps of the adaptive method. It may take many of them, or less than one, per step.
    pub(super) attempts: u64,
}

/// Positions and velocities of bodies, with the sums over their path.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Trajectory<V, R> {
    pub(super) phase: Phase<V>,
    /// Steps done.
    pub(super) count: u64,
    /// Rounding errors that compensated sums have not yet added.
    compensation: Phase<V>,
    /// Events of the path, tracked at every step, so that they do not depend on the frames.
    pub(super) path: R,
    /// Number of force evaluations.
    pub(super) evaluations: u64,
    /// Last whole step of the adaptive method.
    last_step: Option<AdaptiveStep<V, R>>,
}

/// Number of steps between two checks for finite numbers: a number that is not finite remains so.
const MAX_STEPS_PER_CHECK: u64 = 64;

/// Minimum number of steps without tracking, so that it saves more time than the estimate takes.
const MIN_QUIET_STEPS: u64 = 16;

/// Number of states before an event by which it is recognized.
const STATES_BEFORE: u64 = 2;

/// Number of steps of length h within a time of continuous motion.
fn quiet_steps(method: &impl Method, time: f64, h: f64) -> u64 {
    // The substeps of Yoshida's method, back and forth, add up to 4.41 steps.
    let path_factor = if method.evaluations() == 1 { 1.0 } else { 5.0 };
    // Events are searched up to one step before a state.
    ((time / (path_factor * h)) as u64).saturating_sub(1)
}

/// Error of a step whose result is not finite.
pub(super) struct NotFinite;

impl<V: Clone + AsRef<[f64]> + AsMut<[f64]>, R: Clone + Default> Trajectory<V, R> {
    /// Bodies at their start, with the record of a path without events.
    pub(super) fn new(phase: Phase<V>, path: R, discretization: &Discretization) -> Self {
        let mut compensation = phase.clone();
        compensation.position.as_mut().fill(0.0);
        compensation.velocity.as_mut().fill(0.0);
        let is_adaptive = discretization.integrator == OrbitIntegrator::Dop853;
        let last_step = is_adaptive.then(|| AdaptiveStep {
            time: 0.0,
            next_length: discretization.step,
            phase: phase.clone(),
            compensation: compensation.clone(),
            path: path.clone(),
        });
        Self { phase, count: 0, compensation, path, evaluations: 0, last_step }
    }

    /// Begins the steps of the adaptive method at the present state, days since the start, after it was displaced.
    pub(super) fn restart_at(&mut self, time: f64) {
        if let Some(last) = &mut self.last_step {
            last.time = time;
            last.phase.clone_from(&self.phase);
            last.compensation.clone_from(&self.compensation);
            last.path.clone_from(&self.path);
        }
    }

    /// Whether this can be a later state of a start: finite numbers, and as many bodies.
    pub(super) fn is_valid_after(&self, start: &Self) -> bool {
        let has_its_bodies = |phase: &Phase<V>| {
            let count = start.phase.position.as_ref().len();
            let columns = [&phase.position, &phase.velocity];
            phase.is_finite() && columns.iter().all(|column| column.as_ref().len() == count)
        };
        let has_last_step = match &self.last_step {
            None => start.last_step.is_none(),
            Some(step) => {
                start.last_step.is_some()
                    && step.time.is_finite()
                    && step.time >= 0.0
                    && step.next_length.is_normal()
                    && step.next_length > 0.0
                    && has_its_bodies(&step.phase)
                    && has_its_bodies(&step.compensation)
            }
        };
        has_its_bodies(&self.phase) && has_its_bodies(&self.compensation) && has_last_step
    }

    /// Takes as many steps as the budget allows. A step whose result is not finite is not taken.
    pub(super) fn advance<F: Force<Vector = V>>(
        &mut self,
        force: &F,
        discretization: &Discretization,
        budget: StepBudget,
        tracker: &impl PathTracker<F, Record = R>,
    ) -> Result<(), NotFinite> {
        match discretization.summation {
            OrbitSummation::Compensated => {
                self.integrate::<F, _, true>(force, discretization, budget, tracker)
            }
            OrbitSummation::Plain => {
                self.integrate::<F, _, false>(force, discretization, budget, tracker)
            }
        }
    }

    fn integrate<F: Force<Vector = V>, T: PathTracker<F, Record = R>, const COMPENSATED: bool>(
        &mut self,
        force: &F,
        discretization: &Discretization,
        budget: StepBudget,
        tracker: &T,
    ) -> Result<(), NotFinite> {
        let StepBudget { steps, attempts } = budget;
        if discretization.integrator == OrbitIntegrator::Dop853 {
            let before = self.clone();
            let take = |trajectory: &mut Self, steps, attempts| {
                let budget = StepBudget { steps, attempts };
                trajectory.take_adaptive_steps::<F, COMPENSATED>(
                    force,
                    discretization,
                    budget,
                    tracker,
                )
            };
            return take(self, steps, attempts).or_else(|NotFinite| {
                // However the work is divided, the run ends at the last possible time. Up to there, no other steps are attempted.
                *self = before;
                (0..steps).try_for_each(|_| take(self, 1, u64::MAX))
            });
        }
        let h = discretization.step;
        let steps = FixedSteps::<F, T, COMPENSATED> { trajectory: self, force, h, steps, tracker };
        // The exact solution takes no steps.
        with_fixed_steps(discretization.integrator, steps).unwrap_or(Ok(()))
    }

    /// Takes steps up to the given number of multiples of `step` from the current time: whole steps of the adaptive method that do not
    /// pass the last of them, then a shorter step to it that is not kept. After the last attempt of the budget, the state is that at the
    /// last multiple that was passed.
    fn take_adaptive_steps<F: Force<Vector = V>, const COMPENSATED: bool>(
        &mut self,
        force: &F,
        discretization: &Discretization,
        StepBudget { steps, attempts }: StepBudget,
        tracker: &impl PathTracker<F, Record = R>,
    ) -> Result<(), NotFinite> {
        // After a call that was stopped, the last whole step is beyond the state.
        if steps == 0 {
            return Ok(());
        }
        let Some(last) = &mut self.last_step else { return Ok(()) };
        let count = self.count + steps;
        let end = discretization.time_at(count);
        let mut separations = F::Separations::default();
        let mut state = last.integration::<F, COMPENSATED>(force);
        state.separations = Some(&mut separations);
        let mut attempted = 0;
        // The last multiple that was passed, and the whole step before it.
        let (mut passed, mut earlier) = (None, last.clone());
        while last.time + last.next_length <= end {
            let next = last.time + last.next_length;
            // The difference of the rounded times, so that times have no error of their own.
            let h = next - last.time;
            if h <= 0.0 {
                return Err(NotFinite);
            }
            if attempted == attempts {
                let Some(count) = passed else { return Ok(()) };
                return self.stop_after::<F, COMPENSATED>(
                    &earlier,
                    force,
                    discretization,
                    count,
                    tracker,
                );
            }
            attempted += 1;
            self.evaluations += DORMAND_PRINCE_8.evaluations();
            let Attempt { length_factor, is_accepted } =
                try_step(&mut state, h, discretization.tolerance);
            let next_length = last.next_length * length_factor;
            if is_accepted {
                let before = discretization.count_before(next);
                let is_passed = before > self.count && discretization.time_at(before) >= last.time;
                let mut path =
                    if is_passed { last.path.clone() } else { std::mem::take(&mut last.path) };
                last.track(tracker, &mut state, h, &mut path);
                if is_passed {
                    passed = Some(before);
                    // The memory of an older step is used again.
                    std::mem::swap(last, &mut earlier);
                }
                last.path = path;
                last.time = next;
                last.phase.clone_from(&state.phase);
                last.compensation.clone_from(&state.compensation);
            }
            last.next_length = next_length;
        }
        self.path = last.step_part(&mut state, end - last.time, tracker)?;
        self.phase = state.phase;
        self.count = count;
        Ok(())
    }

    /// Takes a shorter step from a whole one to a multiple of `step`.
    fn stop_after<F: Force<Vector = V>, const COMPENSATED: bool>(
        &mut self,
        step: &AdaptiveStep<V, R>,
        force: &F,
        discretization: &Discretization,
        count: u64,
        tracker: &impl PathTracker<F, Record = R>,
    ) -> Result<(), NotFinite> {
        let mut separations = F::Separations::default();
        let mut state = step.integration::<F, COMPENSATED>(force);
        state.separations = Some(&mut separations);
        let h = discretization.time_at(count) - step.time;
        self.path = step.step_part(&mut state, h, tracker)?;
        self.phase = state.phase;
        self.count = count;
        Ok(())
    }
}

/// Steps of fixed length to take with the integrator of the manifest.
struct FixedSteps<'a, F: Force, T: PathTracker<F>, const COMPENSATED: bool> {
    trajectory: &'a mut Trajectory<F::Vector, T::Record>,
    force: &'a F,
    h: f64,
    steps: u64,
    tracker: &'a T,
}

impl<F: Force, T: PathTracker<F>, const COMPENSATED: bool> MethodVisitor
    for FixedSteps<'_, F, T, COMPENSATED>
{
    type Output = Result<(), NotFinite>;

    // Inlined, so that the coefficients are constants: with them in memory, Runge–Kutta steps take 2.7 times as long.
    #[inline(always)]
    fn visit(self, method: &impl Method) -> Self::Output {
        let Self { trajectory, force, h, steps, tracker } = self;
        let restart = |trajectory: &Trajectory<F::Vector, T::Record>| {
            let (phase, compensation) = (trajectory.phase.clone(), trajectory.compensation.clone());
            IntegrationState::<F, COMPENSATED>::new(force, phase, compensation)
        };
        let mut separations = F::Separations::default();
        let mut state = restart(trajectory);
        state.separations = Some(&mut separations);
        let end = trajectory.count + steps;
        let mut from = trajectory.phase.clone();
        let mut signs = tracker.signs(&from);
        let mut steps_per_check = MAX_STEPS_PER_CHECK;
        let mut quiet_end = 0;
        while trajectory.count < end {
            let left = end - trajectory.count;
            if left >= MIN_QUIET_STEPS && quiet_end < trajectory.count + MIN_QUIET_STEPS {
                let time = tracker.quiet_time(&from, &trajectory.path);
                quiet_end = trajectory.count.saturating_add(quiet_steps(method, time, h));
            }
            let quiet = quiet_end.saturating_sub(trajectory.count);
            let is_quiet = quiet >= MIN_QUIET_STEPS && steps_per_check > 1;
            let steps = left.min(if is_quiet { quiet } else { steps_per_check });
            let untracked = if is_quiet { steps.saturating_sub(STATES_BEFORE) } else { 0 };
            let path_before = trajectory.path.clone();
            let tracked = state.separations.take();
            for _ in 0..untracked {
                method.step(&mut state, h);
            }
            state.separations = tracked;
            for index in untracked..steps {
                method.step(&mut state, h);
                let IntegrationState { phase, separations: Some(separations), .. } = &mut state
                else {
                    continue;
                };
                if !is_quiet && tracker.has_event(phase, separations, &mut signs, &trajectory.path)
                {
                    let start = (trajectory.count + index) as f64 * h;
                    // Copies, so that the states of ordinary steps stay in registers.
                    let ends = [from.clone(), phase.clone()];
                    add_step(method, force, tracker, ends, [start, h], &mut trajectory.path);
                }
                tracker.complete_step(separations, h, &mut trajectory.path);
                from.copy_from(phase);
            }
            if state.phase.is_finite() {
                trajectory.phase.clone_from(&state.phase);
                trajectory.compensation.clone_from(&state.compensation);
                trajectory.count += steps;
                trajectory.evaluations += steps * method.evaluations();
            } else {
                // Repeats the steps one by one up to the last one with finite numbers.
                let separations = state.separations;
                state = restart(trajectory);
                state.separations = separations;
                trajectory.path = path_before;
                if steps == 1 {
                    return Err(NotFinite);
                }
                from.clone_from(&state.phase);
                signs = tracker.signs(&from);
                steps_per_check = 1;
            }
        }
        Ok(())
    }
}

/// Adds the events of a step between two states that begins at `start` and takes `h`, days.
#[cold]
#[inline(never)]
fn add_step<F: Force, T: PathTracker<F>>(
    method: &impl Method,
    force: &F,
    tracker: &T,
    [from, to]: [Phase<F::Vector>; 2],
    [start, h]: [f64; 2],
    path: &mut T::Record,
) {
    let part = |part| after_part(method, force, &from, part);
    tracker.add_step(&StepPath { from: &from, to: &to, start, length: h, part: &part }, path);
}

impl<V: Clone + AsRef<[f64]> + AsMut<[f64]>, R: Clone> AdaptiveStep<V, R> {
    /// An integration from the end of this step.
    fn integration<'a, F: Force<Vector = V>, const COMPENSATED: bool>(
        &self,
        force: &'a F,
    ) -> IntegrationState<'a, F, COMPENSATED> {
        IntegrationState::new(force, self.phase.clone(), self.compensation.clone())
    }

    /// Takes a step of length h from this one that is not kept, and returns the path after it.
    fn step_part<F: Force<Vector = V>, T: PathTracker<F, Record = R>, const COMPENSATED: bool>(
        &self,
        state: &mut IntegrationState<'_, F, COMPENSATED>,
        h: f64,
        tracker: &T,
    ) -> Result<R, NotFinite> {
        DORMAND_PRINCE_8.step(state, h);
        if !state.phase.is_finite() {
            return Err(NotFinite);
        }
        let mut path = self.path.clone();
        self.track(tracker, state, h, &mut path);
        Ok(path)
    }

    /// Adds the events of the step of length h from this one to the current state of an integration.
    fn track<F: Force<Vector = V>, T: PathTracker<F, Record = R>, const COMPENSATED: bool>(
        &self,
        tracker: &T,
        state: &mut IntegrationState<'_, F, COMPENSATED>,
        h: f64,
        path: &mut R,
    ) {
        let IntegrationState { force, phase: to, separations: Some(separations), .. } = state
        else {
            return;
        };
        if tracker.has_event(to, separations, &mut tracker.signs(&self.phase), path) {
            let part = |part| after_part(&DORMAND_PRINCE_8, *force, &self.phase, part);
            let step = StepPath { from: &self.phase, to, start: self.time, length: h, part: &part };
            tracker.add_step(&step, path);
        }
        tracker.complete_step(separations, h, path);
    }
}

/// State after a step that is shorter than that of the integration.
#[cold]
#[inline(never)]
fn after_part<F: Force>(
    method: &impl Method,
    force: &F,
    from: &Phase<F::Vector>,
    h: f64,
) -> Phase<F::Vector> {
    let mut zeros = from.clone();
    zeros.position.as_mut().fill(0.0);
    zeros.velocity.as_mut().fill(0.0);
    let mut state = IntegrationState::<F, false>::new(force, from.clone(), zeros);
    method.step(&mut state, h);
    state.phase
}
