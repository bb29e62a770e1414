//! The energy ledger: kinetic + m g y + elastic + dissipated + removed - entered - work of the walls = constant.
//!
//! What is left of that constant is the integrator's error, and is reported apart.
//!
//! With the mid-step velocity the work of all forces is the change of the kinetic energy, exactly: m (v' - v) . (v' + v)/2.
//! So dashpots and walls count by that velocity; the power at a frame's time counts half before and half after it.

use crate::dem::discs::Discs;
use crate::dem::motion;
use crate::dem::step::{Evaluation, Moved};
use crate::sum::CompensatedSum;
use serde::{Deserialize, Serialize};

/// The mechanical energy of an instant, J.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Energies {
    /// Sum of m v^2 / 2 + I w^2 / 2.
    pub(super) kinetic: f64,
    /// Sum of -m g . x, zero at the origin.
    pub(super) gravitational: f64,
    /// Sum of k delta^2 / 2.
    pub(super) elastic_normal: f64,
    /// Energy of the tangential and rolling springs.
    pub(super) elastic_tangential: f64,
}

impl Energies {
    /// Energies at the positions' time: with the integrator's own velocities, which are half a step behind, the kinetic
    /// energy has peaks of several percent within a contact.
    pub(super) fn of(discs: &Discs, evaluation: &Evaluation, gravity: [f64; 2]) -> Self {
        let mut kinetic = CompensatedSum::default();
        let mut gravitational = CompensatedSum::default();
        for disc in 0..discs.len() {
            let ([x, y], [vx, vy]) = (discs.positions[disc], evaluation.velocities[disc]);
            let (mass, spin) = (discs.masses[disc], evaluation.spins[disc]);
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
            elastic_normal: evaluation.touching.elastic.value(),
            elastic_tangential: evaluation.moved.contacts.elastic,
        }
    }

    /// Kinetic + gravitational + elastic.
    pub(super) fn total(&self) -> f64 {
        self.kinetic + self.gravitational + self.elastic_normal + self.elastic_tangential
    }
}

/// What has come and gone since the start, J.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Ledger {
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
    /// Energy that discs took along when they were removed.
    pub(super) removed: CompensatedSum,
    /// Energy that discs brought along when they came in.
    pub(super) entered: CompensatedSum,
    /// What gravity loses where discs are put back through a periodic side.
    pub(super) put_back: CompensatedSum,
}

/// The ledger closed at a frame's time, J.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Balance {
    pub(super) dashpot: f64,
    pub(super) friction: f64,
    pub(super) rolling: f64,
    /// Work of each wall.
    pub(super) walls: Vec<f64>,
    /// Work of all walls.
    pub(super) wall_work: f64,
}

impl Ledger {
    /// Takes stock at the start, so that the residual begins at zero.
    pub(super) fn open(&mut self, total: f64, moved: &Moved, time_step: f64) {
        self.initial = total;
        self.walls.resize(moved.contacts.walls.len(), CompensatedSum::default());
        // A frame adds half a step of the power at its time.
        self.add_powers(moved, -0.5 * time_step);
    }

    /// Adds a step.
    pub(super) fn add(&mut self, moved: &Moved, time_step: f64) {
        self.add_powers(moved, time_step);
        self.friction.add(moved.contacts.friction);
        self.rolling.add(moved.contacts.rolling);
    }

    fn add_powers(&mut self, moved: &Moved, time: f64) {
        self.dashpot.add((moved.dashpot_power + moved.contacts.wall_dissipation) * time);
        for (work, [_, _, power]) in self.walls.iter_mut().zip(&moved.contacts.walls) {
            work.add(power * time);
        }
    }

    /// The ledger at the present state, with its forces.
    pub(super) fn balance(&self, moved: &Moved, time_step: f64) -> Balance {
        let mut closed = self.clone();
        closed.add_powers(moved, 0.5 * time_step);
        let walls: Vec<f64> = closed.walls.iter().map(CompensatedSum::value).collect();
        Balance {
            dashpot: closed.dashpot.value(),
            friction: closed.friction.value() + moved.contacts.friction,
            rolling: closed.rolling.value() + moved.contacts.rolling,
            wall_work: walls.iter().sum(),
            walls,
        }
    }
}

impl Balance {
    /// Taken by dashpots, friction and rolling friction.
    pub(super) fn dissipated(&self) -> f64 {
        self.dashpot + self.friction + self.rolling
    }
}
