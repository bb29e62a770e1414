//! Bodies on their way through a run: so many steps of a method, or the steps that the adaptive one chooses.

use super::adaptive::{Node, try_step};
use super::dormand_prince::DORMAND_PRINCE_8;
use super::integrators::{
    EXPLICIT_EULER, Integrator, RUNGE_KUTTA_4, SEMI_IMPLICIT_EULER, VELOCITY_VERLET, YOSHIDA_4,
};
use super::motion::{Force, Phase};
use super::single_step::{Method, Walker};
use serde::{Deserialize, Serialize};

/// How a run is discretised.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Scheme {
    pub(super) integrator: Integrator,
    /// Whether sums keep what they round off.
    pub(super) compensated: bool,
    /// h, days: of the adaptive method the first trial and the grid of instants that can be looked at.
    pub(super) step: f64,
    /// Of the adaptive method: error of a step, relative.
    pub(super) tolerance: f64,
}

impl Scheme {
    /// The time of a step, days.
    pub(super) fn time_at(&self, count: u64) -> f64 {
        count as f64 * self.step
    }
}

/// How the angle about the Sun jumps on the way, in whole turns.
pub(super) trait Turns<V> {
    /// Which of two halves of space a position lies in: nothing jumps within one.
    fn side(&self, position: &V) -> bool;

    /// The jump on the straight way from one position to the next.
    fn between(&self, from: &V, to: &V) -> i64;
}

/// Where the bodies are, and what their way here has left.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Track<V> {
    pub(super) phase: Phase<V>,
    /// Steps done.
    pub(super) count: u64,
    /// What compensated sums hold back.
    lost: Phase<V>,
    /// Whole turns about the Sun: followed step by step, so that looking does not change it.
    pub(super) turns: i64,
    /// How often the force was asked for.
    pub(super) evaluations: u64,
    /// The adaptive method's last whole step.
    node: Option<Node<V>>,
}

/// Steps between two looks at whether there still are numbers: what is none once remains so.
const LONGEST_BLOCK: u64 = 64;

/// The next step leads to no number.
pub(super) struct Lost;

impl<V: Clone + AsRef<[f64]> + AsMut<[f64]>> Track<V> {
    /// Bodies at their start.
    pub(super) fn new(phase: Phase<V>, scheme: &Scheme) -> Self {
        let mut lost = phase.clone();
        lost.position.as_mut().fill(0.0);
        lost.velocity.as_mut().fill(0.0);
        let node = (scheme.integrator == Integrator::DormandPrince8).then(|| Node {
            time: 0.0,
            trial: scheme.step,
            phase: phase.clone(),
            lost: lost.clone(),
            turns: 0,
        });
        Self { phase, count: 0, lost, turns: 0, evaluations: 0, node }
    }

    /// So many steps. A step that leads to no number is not taken. `turns` says how the angle about the Sun jumps from one
    /// step to the next.
    pub(super) fn walk<F: Force<Vector = V>>(
        &mut self,
        force: &F,
        scheme: &Scheme,
        steps: u64,
        turns: &impl Turns<V>,
    ) -> Result<(), Lost> {
        if scheme.compensated {
            self.walk_by::<F, true>(force, scheme, steps, turns)
        } else {
            self.walk_by::<F, false>(force, scheme, steps, turns)
        }
    }

    fn walk_by<F: Force<Vector = V>, const COMPENSATED: bool>(
        &mut self,
        force: &F,
        scheme: &Scheme,
        steps: u64,
        turns: &impl Turns<V>,
    ) -> Result<(), Lost> {
        let h = scheme.step;
        match scheme.integrator {
            Integrator::ExplicitEuler => {
                self.repeat::<F, _, COMPENSATED>(force, &EXPLICIT_EULER, h, steps, turns)
            }
            Integrator::SemiImplicitEuler => {
                self.repeat::<F, _, COMPENSATED>(force, &SEMI_IMPLICIT_EULER, h, steps, turns)
            }
            Integrator::VelocityVerlet => {
                self.repeat::<F, _, COMPENSATED>(force, &VELOCITY_VERLET, h, steps, turns)
            }
            Integrator::Rk4 => {
                self.repeat::<F, _, COMPENSATED>(force, &RUNGE_KUTTA_4, h, steps, turns)
            }
            Integrator::Yoshida4 => {
                self.repeat::<F, _, COMPENSATED>(force, &YOSHIDA_4, h, steps, turns)
            }
            Integrator::DormandPrince8 => {
                let before = self.clone();
                let go = |track: &mut Self, steps| {
                    track.choose_steps::<F, COMPENSATED>(force, scheme, steps, turns)
                };
                go(self, steps).or_else(|Lost| {
                    // However work is cut, the run ends at the last instant that can be reached.
                    *self = before;
                    (0..steps).try_for_each(|_| go(self, 1))
                })
            }
            // The exact solution takes no steps.
            Integrator::Kepler => Ok(()),
        }
    }

    /// One step of fixed length after the other.
    fn repeat<F: Force<Vector = V>, M: Method, const COMPENSATED: bool>(
        &mut self,
        force: &F,
        method: &M,
        h: f64,
        steps: u64,
        turns: &impl Turns<V>,
    ) -> Result<(), Lost> {
        let mut walker =
            Walker::<F, COMPENSATED>::new(force, self.phase.clone(), self.lost.clone());
        let end = self.count + steps;
        let mut from = self.phase.position.clone();
        let mut side = turns.side(&from);
        let mut block = LONGEST_BLOCK;
        while self.count < end {
            let steps = block.min(end - self.count);
            let turns_before = self.turns;
            for _ in 0..steps {
                method.step(&mut walker, h);
                let next = turns.side(&walker.phase.position);
                if next != side {
                    self.turns += turns.between(&from, &walker.phase.position);
                    side = next;
                }
                from.clone_from(&walker.phase.position);
            }
            if walker.phase.is_finite() {
                self.phase.clone_from(&walker.phase);
                self.lost.clone_from(&walker.lost);
                self.count += steps;
                self.evaluations += steps * method.evaluations();
            } else {
                // Once more and step by step, to the last one that leads to numbers.
                walker = Walker::new(force, self.phase.clone(), self.lost.clone());
                self.turns = turns_before;
                if steps == 1 {
                    return Err(Lost);
                }
                from.clone_from(&walker.phase.position);
                side = turns.side(&from);
                block = 1;
            }
        }
        Ok(())
    }

    /// The way over so many instants of the grid: whole steps of the adaptive method as far as they do not pass the last of
    /// them, then one shorter step to it that is not kept.
    fn choose_steps<F: Force<Vector = V>, const COMPENSATED: bool>(
        &mut self,
        force: &F,
        scheme: &Scheme,
        steps: u64,
        turns: &impl Turns<V>,
    ) -> Result<(), Lost> {
        let Some(node) = &mut self.node else { return Ok(()) };
        let end = scheme.time_at(self.count + steps);
        let mut walker =
            Walker::<F, COMPENSATED>::new(force, node.phase.clone(), node.lost.clone());
        while node.time + node.trial <= end {
            let next = node.time + node.trial;
            // The step as the clock sees it, so that times have no error of their own.
            let h = next - node.time;
            if h <= 0.0 {
                return Err(Lost);
            }
            self.evaluations += DORMAND_PRINCE_8.evaluations();
            let (factor, taken) =
                try_step(&mut walker, h, scheme.tolerance).unwrap_or((0.1, false));
            node.trial *= factor;
            if taken {
                node.turns += turns.between(&node.phase.position, &walker.phase.position);
                node.time = next;
                node.phase.clone_from(&walker.phase);
                node.lost.clone_from(&walker.lost);
            }
        }
        DORMAND_PRINCE_8.step(&mut walker, end - node.time);
        if !walker.phase.is_finite() {
            return Err(Lost);
        }
        self.turns = node.turns + turns.between(&node.phase.position, &walker.phase.position);
        self.phase = walker.phase;
        self.count += steps;
        Ok(())
    }
}
