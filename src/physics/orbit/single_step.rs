//! One step of length h, days: kick-drift compositions and Runge–Kutta methods. `integrators.rs` holds their coefficients.
//!
//! The order of the operations is part of the results, and no multiplication is fused with an addition.

use super::motion::{FixedSun, Force, Phase, State};

/// Positions, velocities and accelerations of bodies during an integration; the acceleration is passed on from step to step.
///
/// With `COMPENSATED` sums, the rounding error of each addition to r and v is stored and added to the next term (Kahan, Comm. ACM 8
/// (1965) 40; exact error of a sum by Knuth's six operations), so that a million additions round like one.
#[derive(Debug)]
pub struct IntegrationState<'a, F: Force, const COMPENSATED: bool> {
    pub(super) force: &'a F,
    /// Positions and velocities.
    pub phase: Phase<F::Vector>,
    /// Rounding errors that are not yet added; zero for plain sums.
    pub compensation: Phase<F::Vector>,
    /// a(r)
    acceleration: F::Vector,
    /// Distances of the pairs at r, if they are tracked. Not stored here, so that the other fields can stay in registers.
    pub(super) separations: Option<&'a mut F::Separations>,
}

/// A method that takes steps of any length.
pub trait Method {
    /// Number of force evaluations per step.
    fn evaluations(&self) -> u64;

    /// Takes one step.
    fn step<F: Force, const COMPENSATED: bool>(
        &self,
        state: &mut IntegrationState<'_, F, COMPENSATED>,
        h: f64,
    );
}

/// Exact solution of one part of the equations of motion, for a fraction of the step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Substep {
    /// v += a(r) w h
    Kick(f64),
    /// r += v w h
    Drift(f64),
}

/// A symplectic composition of kicks and drifts. The force is evaluated once after each drift.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Splitting<const N: usize>(pub [Substep; N]);

/// A Runge–Kutta method for y = (r, v), y' = (v, a(r)): k_i = y'(y + h sum over j < i of `stages[i][j]` k_j), and the step is
/// y + (h / divisor) sum of `weights[i]` k_i. Sums run from the first slope to the last; zero coefficients are skipped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tableau<const S: usize> {
    /// Row i: the weights of the slopes before slope i.
    pub stages: [[f64; S]; S],
    /// The weights of all slopes times the divisor.
    pub weights: [f64; S],
    /// Common denominator of the weights.
    pub divisor: f64,
}

/// A row of a tableau: the given coefficients, then zeros.
pub(super) const fn row<const GIVEN: usize, const S: usize>(given: [f64; GIVEN]) -> [f64; S] {
    let mut row = [0.0; S];
    let mut slope = 0;
    while slope < GIVEN {
        row[slope] = given[slope];
        slope += 1;
    }
    row
}

impl<'a, F: Force, const COMPENSATED: bool> IntegrationState<'a, F, COMPENSATED> {
    /// Bodies at a point of phase space; `compensation` is that of an earlier integration, or zero.
    #[inline]
    #[must_use]
    pub fn new(force: &'a F, phase: Phase<F::Vector>, compensation: Phase<F::Vector>) -> Self {
        let mut acceleration = phase.position.clone();
        force.accelerations(&phase.position, &mut acceleration);
        Self { force, phase, compensation, acceleration, separations: None }
    }

    /// (v, a(r))
    #[inline]
    fn slope(&self) -> Phase<F::Vector> {
        Phase { position: self.phase.velocity.clone(), velocity: self.acceleration.clone() }
    }

    /// v += a(r) h
    #[inline]
    fn kick(&mut self, h: f64) {
        let sums = self.phase.velocity.as_mut().iter_mut().zip(self.compensation.velocity.as_mut());
        for ((sum, compensation), rate) in sums.zip(self.acceleration.as_ref()) {
            add::<COMPENSATED>(sum, compensation, rate * h);
        }
    }

    /// r += v h
    #[inline]
    fn drift(&mut self, h: f64) {
        let sums = self.phase.position.as_mut().iter_mut().zip(self.compensation.position.as_mut());
        for ((sum, compensation), rate) in sums.zip(self.phase.velocity.as_ref()) {
            add::<COMPENSATED>(sum, compensation, rate * h);
        }
        self.update_acceleration();
    }

    /// Evaluates the force at r.
    #[inline]
    fn update_acceleration(&mut self) {
        let Self { force, phase, acceleration, separations, .. } = self;
        if let Some(separations) = separations {
            force.accelerations_and_separations(&phase.position, acceleration, separations);
        } else {
            force.accelerations(&phase.position, acceleration);
        }
    }
}

/// sum += term
#[inline]
fn add<const COMPENSATED: bool>(sum: &mut f64, compensation: &mut f64, term: f64) {
    if COMPENSATED {
        let term = term + *compensation;
        let next = *sum + term;
        let added = next - *sum;
        *compensation = (*sum - (next - added)) + (term - added);
        *sum = next;
    } else {
        *sum += term;
    }
}

impl<const N: usize> Method for Splitting<N> {
    fn evaluations(&self) -> u64 {
        let drifts = self.0.iter().filter(|substep| matches!(substep, Substep::Drift(_)));
        drifts.count() as u64
    }

    // Inlined at each of its calls, so that the coefficients are constants.
    #[inline(always)]
    fn step<F: Force, const COMPENSATED: bool>(
        &self,
        state: &mut IntegrationState<'_, F, COMPENSATED>,
        h: f64,
    ) {
        for substep in self.0 {
            match substep {
                Substep::Kick(weight) => state.kick(weight * h),
                Substep::Drift(weight) => state.drift(weight * h),
            }
        }
    }
}

impl<const S: usize> Method for Tableau<S> {
    fn evaluations(&self) -> u64 {
        S as u64
    }

    // Inlined at each of its calls, so that the coefficients are constants.
    #[inline(always)]
    fn step<F: Force, const COMPENSATED: bool>(
        &self,
        state: &mut IntegrationState<'_, F, COMPENSATED>,
        h: f64,
    ) {
        let slopes = self.slopes(state, h);
        self.finish(state, &slopes, h);
    }
}

impl<const S: usize> Tableau<S> {
    /// Slopes k_1 to k_S.
    #[inline]
    pub(super) fn slopes<F: Force, const COMPENSATED: bool>(
        &self,
        state: &IntegrationState<'_, F, COMPENSATED>,
        h: f64,
    ) -> [Phase<F::Vector>; S] {
        let mut slopes: [Phase<F::Vector>; S] = std::array::from_fn(|_| state.slope());
        for stage in 1..S {
            let mut position = state.phase.position.clone();
            let mut velocity = state.phase.velocity.clone();
            let weights = &self.stages[stage];
            for (axis, sum) in position.as_mut().iter_mut().enumerate() {
                *sum += weighted(weights, |slope| slopes[slope].position.as_ref()[axis]) * h;
            }
            for (axis, sum) in velocity.as_mut().iter_mut().enumerate() {
                *sum += weighted(weights, |slope| slopes[slope].velocity.as_ref()[axis]) * h;
            }
            state.force.accelerations(&position, &mut slopes[stage].velocity);
            slopes[stage].position = velocity;
        }
        slopes
    }

    /// Moves the bodies to y + (h / divisor) sum of weights times slopes, and evaluates the force there.
    #[inline]
    pub(super) fn finish<F: Force, const COMPENSATED: bool>(
        &self,
        state: &mut IntegrationState<'_, F, COMPENSATED>,
        slopes: &[Phase<F::Vector>; S],
        h: f64,
    ) {
        let h = h / self.divisor;
        let Phase { position, velocity } = &mut state.phase;
        let sums = position.as_mut().iter_mut().zip(state.compensation.position.as_mut());
        for (axis, (sum, compensation)) in sums.enumerate() {
            let rate = weighted(&self.weights, |slope| slopes[slope].position.as_ref()[axis]);
            add::<COMPENSATED>(sum, compensation, rate * h);
        }
        let sums = velocity.as_mut().iter_mut().zip(state.compensation.velocity.as_mut());
        for (axis, (sum, compensation)) in sums.enumerate() {
            let rate = weighted(&self.weights, |slope| slopes[slope].velocity.as_ref()[axis]);
            add::<COMPENSATED>(sum, compensation, rate * h);
        }
        state.update_acceleration();
    }
}

/// Sum of weight times component over the slopes, in their order.
#[inline]
pub(super) fn weighted<const S: usize>(
    weights: &[f64; S],
    component: impl Fn(usize) -> f64,
) -> f64 {
    // Minus zero is the neutral element of addition: a term of +0 or -0 keeps its sign.
    let mut sum = -0.0;
    for (slope, weight) in weights.iter().enumerate() {
        if *weight != 0.0 {
            sum += weight * component(slope);
        }
    }
    sum
}

/// State of a light body around the Sun after one step with plain sums.
#[inline]
#[must_use]
pub fn take_step(method: &impl Method, start: State, h: f64) -> State {
    let zeros = Phase { position: [0.0; 3], velocity: [0.0; 3] };
    let mut state = IntegrationState::<_, false>::new(&FixedSun, start, zeros);
    method.step(&mut state, h);
    state.phase
}
