//! How a table of `integrators` moves bodies: one step of length h (days).
//!
//! The order of the operations is part of the results' bits. Nothing is fused.

use super::integrators::{Splitting, Substep, Tableau};
use super::motion::{FixedSun, Force, Phase, State};

/// Bodies on their way: where they are, and the force there, which one step hands on to the next.
///
/// With `COMPENSATED` sums, what each addition to r and v rounds off is kept and added with the next one (Kahan, Comm. ACM
/// 8, 40, 1965; the exact error of a sum by Knuth's six operations), so that a million steps round like one.
#[derive(Debug)]
pub struct Walker<'a, F: Force, const COMPENSATED: bool> {
    force: &'a F,
    /// Where the bodies are and how they move.
    pub phase: Phase<F::Vector>,
    /// What sums have rounded off and not yet added; zeros where sums are plain.
    pub lost: Phase<F::Vector>,
    /// a(r).
    acceleration: F::Vector,
}

/// What every table can do.
pub trait Method {
    /// How often a step asks for the force.
    fn evaluations(&self) -> u64;

    /// One step.
    fn step<F: Force, const COMPENSATED: bool>(
        &self,
        walker: &mut Walker<'_, F, COMPENSATED>,
        h: f64,
    );
}

impl<'a, F: Force, const COMPENSATED: bool> Walker<'a, F, COMPENSATED> {
    /// Bodies at a place; `lost` as another walker left it, or zeros.
    #[inline]
    #[must_use]
    pub fn new(force: &'a F, phase: Phase<F::Vector>, lost: Phase<F::Vector>) -> Self {
        let mut acceleration = phase.position.clone();
        force.accelerations(&phase.position, &mut acceleration);
        Self { force, phase, lost, acceleration }
    }

    /// (v, a(r)).
    #[inline]
    fn slope(&self) -> Phase<F::Vector> {
        Phase { position: self.phase.velocity.clone(), velocity: self.acceleration.clone() }
    }

    #[inline]
    fn kick(&mut self, h: f64) {
        let (sums, lost) = (self.phase.velocity.as_mut(), self.lost.velocity.as_mut());
        for ((sum, lost), rate) in sums.iter_mut().zip(lost).zip(self.acceleration.as_ref()) {
            add::<COMPENSATED>(sum, lost, rate * h);
        }
    }

    #[inline]
    fn drift(&mut self, h: f64) {
        let (sums, lost) = (self.phase.position.as_mut(), self.lost.position.as_mut());
        for ((sum, lost), rate) in sums.iter_mut().zip(lost).zip(self.phase.velocity.as_ref()) {
            add::<COMPENSATED>(sum, lost, rate * h);
        }
        self.force.accelerations(&self.phase.position, &mut self.acceleration);
    }
}

/// sum += term.
#[inline]
fn add<const COMPENSATED: bool>(sum: &mut f64, lost: &mut f64, term: f64) {
    if COMPENSATED {
        let term = term + *lost;
        let next = *sum + term;
        let added = next - *sum;
        *lost = (*sum - (next - added)) + (term - added);
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

    #[inline]
    fn step<F: Force, const COMPENSATED: bool>(
        &self,
        walker: &mut Walker<'_, F, COMPENSATED>,
        h: f64,
    ) {
        for substep in self.0 {
            match substep {
                Substep::Kick(share) => walker.kick(share * h),
                Substep::Drift(share) => walker.drift(share * h),
            }
        }
    }
}

impl<const S: usize> Method for Tableau<S> {
    fn evaluations(&self) -> u64 {
        S as u64
    }

    #[inline]
    fn step<F: Force, const COMPENSATED: bool>(
        &self,
        walker: &mut Walker<'_, F, COMPENSATED>,
        h: f64,
    ) {
        let slopes = self.slopes(walker, h);
        self.finish(walker, &slopes, h);
    }
}

impl<const S: usize> Tableau<S> {
    /// k_1 to k_S.
    #[inline]
    pub(super) fn slopes<F: Force, const COMPENSATED: bool>(
        &self,
        walker: &Walker<'_, F, COMPENSATED>,
        h: f64,
    ) -> [Phase<F::Vector>; S] {
        let mut slopes: [Phase<F::Vector>; S] = std::array::from_fn(|_| walker.slope());
        for stage in 1..S {
            let mut position = walker.phase.position.clone();
            let mut velocity = walker.phase.velocity.clone();
            for (axis, sum) in position.as_mut().iter_mut().enumerate() {
                *sum +=
                    weighted(&self.stages[stage], |slope| slopes[slope].position.as_ref()[axis])
                        * h;
            }
            for (axis, sum) in velocity.as_mut().iter_mut().enumerate() {
                *sum +=
                    weighted(&self.stages[stage], |slope| slopes[slope].velocity.as_ref()[axis])
                        * h;
            }
            walker.force.accelerations(&position, &mut slopes[stage].velocity);
            slopes[stage].position = velocity;
        }
        slopes
    }

    /// y + (h / divisor) sum of weights times slopes, and the force there.
    #[inline]
    pub(super) fn finish<F: Force, const COMPENSATED: bool>(
        &self,
        walker: &mut Walker<'_, F, COMPENSATED>,
        slopes: &[Phase<F::Vector>; S],
        h: f64,
    ) {
        let h = h / self.divisor;
        let Phase { position, velocity } = &mut walker.phase;
        let sums = position.as_mut().iter_mut().zip(walker.lost.position.as_mut());
        for (axis, (sum, lost)) in sums.enumerate() {
            let rate = weighted(&self.weights, |slope| slopes[slope].position.as_ref()[axis]);
            add::<COMPENSATED>(sum, lost, rate * h);
        }
        let sums = velocity.as_mut().iter_mut().zip(walker.lost.velocity.as_mut());
        for (axis, (sum, lost)) in sums.enumerate() {
            let rate = weighted(&self.weights, |slope| slopes[slope].velocity.as_ref()[axis]);
            add::<COMPENSATED>(sum, lost, rate * h);
        }
        walker.force.accelerations(&walker.phase.position, &mut walker.acceleration);
    }
}

/// Sum over the slopes, in their order, of weight times component.
#[inline]
pub(super) fn weighted<const S: usize>(
    weights: &[f64; S],
    component: impl Fn(usize) -> f64,
) -> f64 {
    // To minus zero anything may be added without a change of its bits.
    let mut sum = -0.0;
    for (slope, weight) in weights.iter().enumerate() {
        if *weight != 0.0 {
            sum += weight * component(slope);
        }
    }
    sum
}

/// One step of a light body about the Sun, with plain sums.
#[inline]
#[must_use]
pub fn stepped(method: &impl Method, start: State, h: f64) -> State {
    let zeros = Phase { position: [0.0; 3], velocity: [0.0; 3] };
    let mut walker = Walker::<_, false>::new(&FixedSun, start, zeros);
    method.step(&mut walker, h);
    walker.phase
}
