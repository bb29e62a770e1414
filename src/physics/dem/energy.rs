//! The energy balance: kinetic + m g y + elastic + dissipated + removed - entered - work of the walls = constant.
//!
//! With the mid-step velocity, the work of all forces equals the change of the kinetic energy exactly: m (v' - v) . (v' + v)/2.
//! Therefore, dashpots and walls count with that velocity; the power at a frame's time counts half before and half after it.

use super::discs::Discs;
use super::motion;
use super::step::Evaluation;
use super::totals::StepTotals;
use crate::sum::CompensatedSum;
use serde::{Deserialize, Serialize};

/// The mechanical energy of a state, J.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Energies {
    /// Sum of m v^2 / 2 + I w^2 / 2.
    pub(super) kinetic: f64,
    /// Sum of -m g . x, zero at the origin.
    pub(super) gravitational: f64,
    /// Potential energy of the normal forces, k delta^2 / 2 - F_c delta each for linear springs.
    pub(super) elastic_normal: f64,
    /// Energy of the tangential and rolling springs.
    pub(super) elastic_tangential: f64,
}

impl Energies {
    /// Energies at the positions' time. With the integrator's own velocities, which are half a step behind, the kinetic
    /// energy would have peaks of several percent within a contact.
    pub(super) fn of(discs: &Discs, evaluation: &Evaluation, gravity: [f64; 2]) -> Self {
        let mut kinetic = CompensatedSum::default();
        let mut gravitational = CompensatedSum::default();
        for disc in 0..discs.len() {
            let ([x, y], [vx, vy]) = (discs.positions[disc], evaluation.velocities[disc]);
            let (mass, spin) = (discs.masses[disc], evaluation.spin(disc));
            kinetic.add(0.5 * mass * (vx * vx + vy * vy));
            if spin != 0.0 {
                let inertia = motion::moment_of_inertia(mass, discs.radii[disc]);
                kinetic.add(0.5 * inertia * spin * spin);
            }
            gravitational.add(-mass * (gravity[0] * x + gravity[1] * y));
        }
        Self {
            kinetic: kinetic.value(),
            gravitational: gravitational.value(),
            elastic_normal: evaluation.contacts.elastic.value(),
            elastic_tangential: evaluation.totals.contacts.elastic,
        }
    }

    /// Kinetic + gravitational + elastic.
    pub(super) fn total(&self) -> f64 {
        self.kinetic + self.gravitational + self.elastic_normal + self.elastic_tangential
    }
}

/// Energies gained and lost since the start, J.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct EnergyBalance {
    /// Kinetic + gravitational + elastic at the start.
    pub(super) initial: f64,
    /// Taken by the dashpots, up to half a step before the positions' time.
    dashpot: CompensatedSum,
    /// Taken by friction, up to the step before.
    friction: CompensatedSum,
    /// Taken by rolling friction, up to the step before.
    rolling: CompensatedSum,
    /// Done by each wall on the discs, up to half a step before the positions' time.
    walls: Vec<CompensatedSum>,
    /// Energy of removed discs.
    pub(super) removed: CompensatedSum,
    /// Energy of inserted discs.
    pub(super) entered: CompensatedSum,
    /// Potential energy lost as discs are wrapped around a periodic side.
    pub(super) put_back: CompensatedSum,
}

impl EnergyBalance {
    /// Whether the sums are numbers, one per wall.
    pub(super) fn is_valid(&self, walls: usize) -> bool {
        let Self { dashpot, friction, rolling, removed, entered, put_back, .. } = self;
        let mut sums = [dashpot, friction, rolling, removed, entered, put_back].into_iter();
        self.initial.is_finite()
            && sums.all(|sum| sum.is_finite())
            && [0, walls].contains(&self.walls.len())
            && self.walls.iter().all(|sum| sum.is_finite())
    }
}

/// The balance at a frame's time, J.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ClosedBalance {
    pub(super) dashpot: f64,
    pub(super) friction: f64,
    pub(super) rolling: f64,
    /// Work of each wall.
    pub(super) walls: Vec<f64>,
    /// Work of all walls.
    pub(super) wall_work: f64,
    /// Energy that the balance does not account for: the error of the integrator.
    pub(super) residual: f64,
}

impl EnergyBalance {
    /// Sets the energy at the start, so that the residual begins at zero.
    pub(super) fn open(&mut self, total: f64, totals: &StepTotals, time_step: f64) {
        self.initial = total;
        self.walls.resize(totals.contacts.walls.len(), CompensatedSum::default());
        // A frame adds half a step of the power at its time.
        self.add_powers(totals, -0.5 * time_step);
    }

    /// Adds a step.
    pub(super) fn add(&mut self, totals: &StepTotals, time_step: f64) {
        self.add_powers(totals, time_step);
        self.friction.add(totals.contacts.friction);
        self.rolling.add(totals.contacts.rolling);
    }

    fn add_powers(&mut self, totals: &StepTotals, time: f64) {
        self.dashpot.add((totals.dashpot_power + totals.contacts.wall_dissipation) * time);
        for (work, [_, _, power]) in self.walls.iter_mut().zip(&totals.contacts.walls) {
            work.add(power * time);
        }
    }

    /// The balance of a state with these energies, with the totals of the step that begins there.
    pub(super) fn balance(
        &self,
        energies: &Energies,
        totals: &StepTotals,
        time_step: f64,
    ) -> ClosedBalance {
        let mut closed = self.clone();
        closed.add_powers(totals, 0.5 * time_step);
        let walls: Vec<f64> = closed.walls.iter().map(CompensatedSum::value).collect();
        let mut balance = ClosedBalance {
            dashpot: closed.dashpot.value(),
            friction: closed.friction.value() + totals.contacts.friction,
            rolling: closed.rolling.value() + totals.contacts.rolling,
            wall_work: walls.iter().sum(),
            walls,
            residual: 0.0,
        };
        let lost = balance.dissipated() + self.removed.value() - self.entered.value();
        balance.residual = energies.total() + lost - balance.wall_work - self.initial;
        balance
    }
}

impl ClosedBalance {
    /// Taken by dashpots, friction and rolling friction.
    pub(super) fn dissipated(&self) -> f64 {
        self.dashpot + self.friction + self.rolling
    }
}
