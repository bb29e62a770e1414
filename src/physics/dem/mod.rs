//! Spring–dashpot discs in a box, with optional friction.
//!
//! Start reading at [`motion`], the equation of motion as it is executed, then `step`, its discretization. One collision in closed
//! form is in [`restitution`], the forces of all contacts are in `forces`, the neighbor lists in `neighbors`, the energy balance in
//! `energy`. `diagnosis` finds out before the first step whether a run can be integrated.
//!
//! *Invariant:* results have the same bits for any number of threads and any register width, and observation does not affect
//! them.

pub mod motion;
pub mod restitution;

mod block;
mod diagnosis;
mod discs;
mod energy;
mod expected_load;
mod forces;
mod insertion;
mod integrate;
mod laws;
mod materials;
mod neighbors;
mod observe;
mod parameters;
mod spare;
mod start;
mod step;
mod totals;
mod twin;
mod validity;
mod walls;

use crate::model::{
    Extent, Model, ModelKind, Proceed, Progress, SetupError, SimulationFault, Target,
};
use crate::random::Seed;
use crate::simd::registers::Register as _;
use diagnosis::{Diagnosis, messages};
use discs::Discs;
use energy::{ClosedBalance, Energies, EnergyBalance};
use insertion::Insertion;
use kinetoscope_manifest::model::{DemConfig, Placement, UnstableTimeStep};
use kinetoscope_recording::channels::{
    ChannelDeclaration, DemContactForces, DemContactStatistics, DemDiscForces, DemEnergy,
    DemEnergyPercent, DemTemperature, DemWalls, Divergence,
};
use kinetoscope_recording::frame::{Frame, StateColumn};
use kinetoscope_recording::scenery::Scenery;
use neighbors::Neighbors;
use neighbors::pair_search::Surroundings;
use parameters::{Parameters, StepContext};
use serde::{Deserialize, Serialize};
use step::{Evaluation, Workspace};
use totals::{BlowUp, Contact, StepTotals};

/// Discs with spring–dashpot contacts in a box with gravity.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Dem {
    parameters: Parameters,
    discs: Discs,
    /// The neighbor lists, always valid for the present positions, with the springs of the contacts.
    neighbors: Neighbors,
    /// Steps since the start.
    count: u64,
    balance: EnergyBalance,
    /// Discs removed since the start.
    removed: u64,
    /// Discs that are inserted during the run.
    insertion: Option<Insertion>,
    /// Speed of the fastest disc at the start, m/s.
    initial_top_speed: f64,
    /// c = eta dt/m_eff of the lightest pair, for the message of a fault.
    damping_step: f64,
    window: Window,
    /// Log lines of frame 0.
    facts: Vec<String>,
    warnings: Vec<String>,
    #[serde(skip)]
    workspace: Workspace,
}

/// Steps between two checks of the energy balance.
const AUDIT_INTERVAL: u64 = 1000;
/// Residual over all energy, above which a run has blown up.
const MAX_RESIDUAL: f64 = 0.5;

/// Quantities accumulated between frames.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Window {
    /// Largest overlap over the smaller radius of a contact since the last frame.
    max_overlap: f64,
    /// Sum of each wall's force over the steps since the last frame, N.
    wall_forces: Vec<[f64; 2]>,
    /// Steps since the last frame.
    steps: u64,
    /// Whether the target was reached; the next call then opens a new window.
    is_closed: bool,
}

const KIND: ModelKind = ModelKind {
    name: "dem",
    physics_version: 4,
    time_unit: "s",
    // `vx`, `vy` and `spin` belong to the positions' time, v + a dt/2; `vx_step` and `vy_step` are the integrator's own.
    state_columns: &[
        StateColumn { name: "x", unit: "m" },
        StateColumn { name: "y", unit: "m" },
        StateColumn { name: "vx", unit: "m/s" },
        StateColumn { name: "vy", unit: "m/s" },
        StateColumn { name: "vx_step", unit: "m/s" },
        StateColumn { name: "vy_step", unit: "m/s" },
        StateColumn { name: "radius", unit: "m" },
        StateColumn { name: "spin", unit: "rad/s" },
        StateColumn { name: "id", unit: "" },
        StateColumn { name: "mass", unit: "kg" },
    ],
    channels: &[
        ChannelDeclaration::of::<DemEnergy>(),
        ChannelDeclaration::of::<DemEnergyPercent>(),
        ChannelDeclaration::of::<DemContactStatistics>(),
        ChannelDeclaration::of::<DemWalls>(),
        ChannelDeclaration::of::<DemTemperature>(),
        ChannelDeclaration::opt_in::<DemContactForces>(),
        ChannelDeclaration::opt_in::<DemDiscForces>(),
        ChannelDeclaration::opt_in::<Divergence>(),
    ],
};

impl Model for Dem {
    type Config = DemConfig;

    fn kind() -> &'static ModelKind {
        &KIND
    }

    /// Prepares the first state; with `forces`, frames contain the force of every contact and on every disc.
    fn prepare(config: &DemConfig, seed: Seed, forces: bool) -> Result<Self, SetupError> {
        Self::prepare_while(config, seed, forces, &|_| true)
    }

    fn prepare_while(
        config: &DemConfig,
        seed: Seed,
        forces: bool,
        proceed: Proceed<'_>,
    ) -> Result<Self, SetupError> {
        let diagnosis = Diagnosis::of(config);
        let mut warnings = Vec::new();
        if diagnosis.is_rejected() {
            if config.on_unstable_time_step == UnstableTimeStep::Error || !diagnosis.is_countable {
                return Err(messages::rejection(config, &diagnosis));
            }
            warnings.push(messages::warning(config, &diagnosis));
        }
        warnings.extend(diagnosis.warnings());
        let parameters = Parameters { records_forces: forces, ..Parameters::new(config) };
        let mut drawn = start::drawn_discs(config, &parameters, seed);
        let inserted = drawn.split_off(config.discs.get() as usize);
        let mut discs = start::place(drawn, config, &parameters, seed, proceed)?;
        let insertion = Insertion::new(config, &parameters, seed, inserted);
        let facts = messages::facts(config, &parameters, &diagnosis, &discs);
        let initial_top_speed = discs
            .velocities
            .iter()
            .fold(0.0, |top, [vx, vy]| (vx * vx + vy * vy).sqrt().larger(top));
        // The velocities of a recording are the integrator's own already.
        if !matches!(config.placement, Placement::Recorded(_)) {
            for velocity in &mut discs.velocities {
                *velocity = parameters.integrator_velocity(config, *velocity);
            }
        }
        let mut model = Self {
            neighbors: Neighbors::new(parameters.radius),
            parameters,
            discs,
            count: 0,
            balance: EnergyBalance::default(),
            removed: 0,
            insertion,
            initial_top_speed,
            damping_step: diagnosis.damping_step,
            window: Window { is_closed: true, ..Window::default() },
            facts,
            warnings,
            workspace: Workspace::default(),
        };
        model.list_neighbors();
        model.open_balance();
        Ok(model)
    }

    fn is_valid_for(&self, config: &DemConfig) -> bool {
        self.is_valid_state(config)
    }

    fn channels(&self) -> &'static [ChannelDeclaration] {
        KIND.channels
    }

    fn extent(&self) -> Extent {
        Extent::Steps { total: self.parameters.total_steps, step: self.parameters.time_step }
    }

    fn particles_to_come(&self) -> u64 {
        self.insertion.as_ref().map_or(0, Insertion::remaining)
    }

    fn advance(&mut self, target: Target, at_most: u64) -> Result<Progress, SimulationFault> {
        if self.window.is_closed {
            self.window = Window::default();
        }
        let goal = match target {
            Target::Count(count) => count,
            Target::Time(time) => (time / self.parameters.time_step + 1e-9).floor() as u64,
        };
        let mut budget = if at_most > 0 { at_most } else { 1 };
        while self.count < goal {
            if budget == 0 {
                return Ok(Progress::Working);
            }
            self.step().map_err(|blow_up| self.fault(blow_up))?;
            budget -= 1;
        }
        self.window.is_closed = true;
        Ok(Progress::Reached)
    }

    fn count(&self) -> u64 {
        self.count
    }

    fn time(&self) -> f64 {
        self.count as f64 * self.parameters.time_step
    }

    fn observe(&self, frame: &mut Frame) {
        self.fill(frame);
    }

    fn scenery(&self) -> Scenery {
        self.drawing()
    }
}

impl Dem {
    /// Limits the registers of force loops to `max_width` numbers (1, 4 or 8), which changes no bit; for tests and benchmarks.
    #[must_use]
    pub fn with_max_width(self, max_width: usize) -> Self {
        let parameters = Parameters { max_width, ..self.parameters };
        Self { parameters, ..self }
    }

    /// One time step: forces of the present state, energy balance, kick and drift; then the neighbor lists are made valid again.
    fn step(&mut self) -> Result<(), BlowUp> {
        let (parameters, scope) = (&self.parameters, self.neighbors.scope());
        let (walls, known_overlap) = (&parameters.walls_at(self.count), self.window.max_overlap);
        let time_before = self.time_before();
        let step = StepContext { parameters, walls, known_overlap, time_before, scope };
        let totals = self.workspace.advance(&mut self.neighbors, &mut self.discs, &step);
        self.window.add(&totals);
        let time_step = self.parameters.time_step;
        self.balance.add(&totals, time_step);
        self.count += 1;
        if let Some(blow_up) = totals.blow_up() {
            return Err(blow_up);
        }
        let displacements = self.parameters.displacements_at(self.count);
        let displacement = totals.max_displacement(time_step);
        if !self.neighbors.is_valid_after(displacement, &self.discs, &displacements) {
            self.neighbors.adapt_skin(self.parameters.radius);
            self.wrap();
            self.list_neighbors();
            self.remove_discs();
        }
        self.insert_discs();
        if self.count.is_multiple_of(AUDIT_INTERVAL) { self.audit() } else { Ok(()) }
    }

    fn list_neighbors(&mut self) {
        let walls = self.parameters.walls_at(self.count);
        let around = Surroundings {
            parameters: &self.parameters,
            walls: &walls,
            displacements: &self.parameters.displacements_at(self.count),
            memory: &self.workspace.search,
        };
        self.neighbors.build(&mut self.discs, &around);
    }

    /// Removes discs below the outlet, with their energy.
    fn remove_discs(&mut self) {
        let Some(outlet) = self.parameters.outlet_below else { return };
        let remaining: Vec<u32> = (0..self.discs.len() as u32)
            .filter(|&disc| self.discs.positions[disc as usize][1] >= outlet)
            .collect();
        let leaving = self.discs.len() - remaining.len();
        if leaving > 0 {
            let gained = self.change_discs(|discs| discs.reorder(&remaining));
            self.balance.removed.add(-gained);
            self.removed += leaving as u64;
        }
    }

    /// Inserts the discs that are due, with their energy.
    fn insert_discs(&mut self) {
        let time = self.time();
        let Some(insertion) = self.insertion.as_mut().filter(|all| all.is_open_at(self.count))
        else {
            return;
        };
        let walls = self.parameters.walls_at(self.count);
        let entering = insertion.due(time, &self.discs, &walls, &self.parameters);
        if !entering.is_empty() {
            let gained = self.change_discs(|discs| discs.extend(&entering));
            self.balance.entered.add(gained);
        }
    }

    /// Removes or adds discs, and returns the energy that they add, J. The lists, which contain indices, are rebuilt at once, with
    /// the springs of the discs that remain.
    fn change_discs(&mut self, change: impl FnOnce(&mut Discs)) -> f64 {
        let before = self.energies(&self.evaluate()).total();
        self.neighbors.hold_springs(&self.discs);
        change(&mut self.discs);
        self.list_neighbors();
        self.energies(&self.evaluate()).total() - before
    }

    /// Wraps discs that left through a periodic side around to the other one.
    fn wrap(&mut self) {
        let Parameters { sides, periodic, gravity, .. } = self.parameters;
        let Discs { positions: centers, masses, .. } = &mut self.discs;
        for disc in discs::groups_that_left(centers, sides, periodic).into_iter().flatten() {
            for axis in (0..2).filter(|&axis| periodic[axis]) {
                let before = centers[disc][axis];
                if before >= 0.0 && before < sides[axis] {
                    continue;
                }
                let turns = (before / sides[axis]).floor();
                if turns != 0.0 {
                    let after = before - turns * sides[axis];
                    centers[disc][axis] = after;
                    self.balance.put_back.add(masses[disc] * gravity[axis] * (after - before));
                }
            }
        }
    }

    /// Stops a run whose energy balance does not close.
    fn audit(&self) -> Result<(), BlowUp> {
        let (energies, balance) = self.balance_of(&self.evaluate());
        // Cohesion makes the energy of contacts negative.
        let elastic = energies.elastic_normal.abs() + energies.elastic_tangential;
        let throughput = energies.kinetic + elastic;
        let supplied = self.balance.initial.abs() + self.balance.entered.value().abs();
        let scale = supplied + throughput + balance.dissipated().abs();
        let fraction = balance.residual.abs() / scale;
        // Written so that a residual that is not a number fails.
        let is_closed = fraction <= MAX_RESIDUAL || scale == 0.0;
        if is_closed { Ok(()) } else { Err(BlowUp::Residual(fraction)) }
    }

    /// Opens the energy balance at the start, so that its residual begins at zero.
    fn open_balance(&mut self) {
        let evaluation = self.evaluate();
        let total = self.energies(&evaluation).total();
        self.balance.open(total, &evaluation.totals, self.parameters.time_step);
    }

    /// Forces of the present state, which does not change.
    fn evaluate(&self) -> Evaluation {
        self.evaluate_contacts(&mut |_| {})
    }

    /// The same; `on_contact` receives all contacts.
    fn evaluate_contacts(&self, on_contact: &mut dyn FnMut(&Contact)) -> Evaluation {
        let (parameters, scope) = (&self.parameters, self.neighbors.scope());
        let walls = &parameters.walls_at(self.count);
        let time_before = self.time_before();
        let step = StepContext { parameters, walls, known_overlap: 0.0, time_before, scope };
        Evaluation::of(&self.neighbors, &self.discs, &step, on_contact)
    }

    /// Time of the last step, s; 0 at the start.
    fn time_before(&self) -> f64 {
        if self.count == 0 { 0.0 } else { self.parameters.time_step }
    }

    fn fault(&self, blow_up: BlowUp) -> SimulationFault {
        let Self { parameters, discs, count, damping_step, .. } = self;
        messages::fault(parameters, discs, (*count, self.time()), *damping_step, blow_up)
    }

    fn energies(&self, evaluation: &Evaluation) -> Energies {
        let Parameters { gravity, .. } = &self.parameters;
        let mut energies = Energies::of(&self.discs, evaluation, *gravity);
        energies.gravitational += self.balance.put_back.value();
        energies
    }

    /// The energies and the balance of a state.
    fn balance_of(&self, evaluation: &Evaluation) -> (Energies, ClosedBalance) {
        let (energies, time_step) = (self.energies(evaluation), self.parameters.time_step);
        (energies, self.balance.balance(&energies, &evaluation.totals, time_step))
    }
}

impl Window {
    /// Adds a step.
    fn add(&mut self, totals: &StepTotals) {
        self.max_overlap = totals.contacts.max_overlap.over_radius.larger(self.max_overlap);
        self.wall_forces.resize(totals.contacts.walls.len(), [0.0; 2]);
        for (sum, [fx, fy, _]) in self.wall_forces.iter_mut().zip(&totals.contacts.walls) {
            *sum = [sum[0] + fx, sum[1] + fy];
        }
        self.steps += 1;
    }
}
