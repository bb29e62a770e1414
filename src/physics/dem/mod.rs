//! Spring–dashpot discs in a box, with friction where it is asked for.
//!
//! The equations of motion stand in [`motion`], one collision in closed form in [`restitution`], the forces of all contacts
//! in `forces`, the discretisation in `step`, the energy ledger in `energy`, and what can't be integrated is found by
//! `stability` before the first step.

pub mod motion;
pub mod restitution;

mod contact_forces;
mod diagnosis;
mod discs;
mod energy;
mod forces;
mod insertion;
mod integrate;
mod materials;
mod neighbors;
mod observe;
mod parameters;
mod recorded;
mod start;
mod step;
mod turn;
mod walls;

use crate::model::{Extent, Fault, Model, Progress, Refusal, Target};
use crate::random::Seed;
use diagnosis::{Diagnosis, messages};
use discs::Discs;
use energy::{Energies, Ledger};
use forces::Scene;
use forces::contact::Contact;
use insertion::Rain;
use kinetoscope_manifest::model::{DemConfig, DemIntegrator, Placement, Stability};
use kinetoscope_recording::channels::{
    ChannelDeclaration, DemContactForces, DemContacts, DemEnergy, DemEnergyShare, DemTemperature,
    DemWalls,
};
use kinetoscope_recording::frame::{Frame, StateColumn};
use kinetoscope_recording::scenery::Scenery;
use neighbors::{Neighbors, Scope, Surroundings};
use parameters::Parameters;

use serde::{Deserialize, Serialize};
use start::Kinds;
use step::{BlowUp, Evaluation, Moved, Workspace};
use walls::PlacedWall;

/// Discs with spring–dashpot contacts in a box with gravity.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Dem {
    parameters: Parameters,
    discs: Discs,
    /// Who may touch whom, always good for the present positions; with the springs of the contacts.
    neighbors: Neighbors,
    /// Steps since the start.
    count: u64,
    ledger: Ledger,
    /// Discs removed since the start.
    removed: u64,
    /// Discs that are still to come.
    rain: Option<Rain>,
    /// Speed of the fastest disc at the start, m/s.
    initial_top_speed: f64,
    /// c = eta dt/m_eff of the lightest pair, for the words of a fault.
    damping_step: f64,
    window: Window,
    /// Lines of the log of frame 0.
    facts: Vec<String>,
    warnings: Vec<String>,
    /// Four pairs at a time where the machine can: the same bits either way.
    #[serde(skip, default = "use_lanes")]
    use_lanes: bool,
    #[serde(skip)]
    workspace: Workspace,
}

/// Steps between two looks at the ledger while it runs.
const AUDIT_INTERVAL: u64 = 1000;
/// Residual over all the energy there was, from which a run has blown up.
const LARGEST_RESIDUAL: f64 = 0.5;

fn use_lanes() -> bool {
    true
}

/// What is gathered between frames.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Window {
    /// Largest overlap over the smaller radius of a contact since the last frame.
    largest_overlap: f64,
    /// Sum of each wall's force over the steps since the last frame, N.
    wall_forces: Vec<[f64; 2]>,
    /// Steps since the last frame.
    steps: u64,
    /// The target was reached: the next call opens a new window.
    is_closed: bool,
}

impl Model for Dem {
    type Config = DemConfig;
    const NAME: &'static str = "dem";
    const PHYSICS_VERSION: u32 = 3;
    const TIME_UNIT: &'static str = "s";
    /// `vx`, `vy` and `spin` belong to the positions' time, v + a dt/2; `vx_step` and `vy_step` are the integrator's own.
    const STATE_COLUMNS: &'static [StateColumn] = &[
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
    ];
    const CHANNELS: &'static [ChannelDeclaration] = &[
        ChannelDeclaration::of::<DemEnergy>(),
        ChannelDeclaration::of::<DemEnergyShare>(),
        ChannelDeclaration::of::<DemContacts>(),
        ChannelDeclaration::of::<DemWalls>(),
        ChannelDeclaration::of::<DemTemperature>(),
        ChannelDeclaration::opt_in::<DemContactForces>(),
    ];

    /// On request frames tell the force of every contact.
    fn prepare(config: &DemConfig, seed: Seed, contact_forces: bool) -> Result<Self, Refusal> {
        let diagnosis = Diagnosis::of(config);
        let mut warnings = Vec::new();
        if diagnosis.is_refused() {
            let text = messages::refusal(config, &diagnosis);
            if config.stability == Stability::Refuse || !diagnosis.is_countable() {
                return Err(Refusal(text));
            }
            warnings.push(text);
        }
        warnings.extend(diagnosis.doubts());
        let parameters =
            Parameters { tells_contact_forces: contact_forces, ..Parameters::new(config) };
        let kinds = Kinds::drawn(config, &parameters, seed);
        let mut discs = start::discs(config, &parameters, seed, &kinds)?;
        let rain = Rain::new(config, &parameters, seed, kinds.rain(config, &parameters));
        let facts = messages::facts(config, &parameters, &diagnosis, &discs);
        let initial_top_speed = discs.velocities.iter().fold(0.0, |top, [vx, vy]| {
            let speed = (vx * vx + vy * vy).sqrt();
            if speed > top { speed } else { top }
        });
        // The velocities of a recording are the integrator's own already.
        let is_recorded = matches!(config.placement, Placement::Recorded(_));
        if config.integrator == DemIntegrator::VelocityVerlet && !is_recorded {
            step::set_back_by_half_a_step(&mut discs, parameters.gravity, parameters.time_step);
        }
        let mut model = Self {
            neighbors: Neighbors::new(parameters.radius),
            parameters,
            discs,
            count: 0,
            ledger: Ledger::default(),
            removed: 0,
            rain,
            initial_top_speed,
            damping_step: diagnosis.damping_step,
            window: Window { is_closed: true, ..Window::default() },
            facts,
            warnings,
            use_lanes: true,
            workspace: Workspace::default(),
        };
        model.list_neighbors();
        model.open_ledger();
        Ok(model)
    }

    fn extent(&self) -> Extent {
        Extent::Steps { total: self.parameters.total_steps, step: self.parameters.time_step }
    }

    fn particles_to_come(&self) -> u64 {
        self.rain.as_ref().map_or(0, Rain::to_come)
    }

    fn advance(&mut self, target: Target, at_most: u64) -> Result<Progress, Fault> {
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
            self.step().map_err(|blow_up| messages::fault(self, blow_up))?;
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
    /// Chooses between the pair loops of one and of four pairs at a time, which give the same bits; for tests and benchmarks.
    #[must_use]
    pub fn with_lanes(self, use_lanes: bool) -> Self {
        Self { use_lanes, ..self }
    }

    /// One time step: forces at the present state, the ledger's share, kick and drift; then a good neighbor list again.
    fn step(&mut self) -> Result<(), BlowUp> {
        let walls = self.parameters.walls_at(self.count);
        let scope = self.neighbors.scope();
        let scene = scene(&self.parameters, &walls, &self.window, scope, self.use_lanes);
        let (neighbors, discs) = (&mut self.neighbors, &mut self.discs);
        let moved = self.workspace.advance(neighbors, discs, &scene, &self.parameters);
        self.window.take(&moved);
        let time_step = self.parameters.time_step;
        self.ledger.add(&moved, time_step);
        self.count += 1;
        if let Some(blow_up) = moved.blow_up() {
            return Err(blow_up);
        }
        let displacements = self.parameters.displacements_at(self.count);
        let way = moved.longest_way(time_step);
        if !self.neighbors.is_good_after(way, &self.discs, &displacements) {
            self.neighbors.adapt_skin(self.parameters.radius);
            self.put_back();
            self.list_neighbors();
            self.remove_discs();
        }
        self.let_discs_in();
        if self.count.is_multiple_of(AUDIT_INTERVAL) { self.audit() } else { Ok(()) }
    }

    fn list_neighbors(&mut self) {
        let walls = self.parameters.walls_at(self.count);
        let around = Surroundings {
            sides: self.parameters.sides,
            periodic: self.parameters.periodic,
            law: &self.parameters.law,
            walls: &walls,
            displacements: &self.parameters.displacements_at(self.count),
            largest_radius: self.parameters.radius_range.1,
            finders: &self.workspace.finders,
        };
        self.neighbors.build(&mut self.discs, &around);
    }

    /// Takes discs that sank below the outlet out of the run, with their energy.
    fn remove_discs(&mut self) {
        let Some(outlet) = self.parameters.outlet_below else { return };
        let stays: Vec<u32> = (0..self.discs.len() as u32)
            .filter(|&disc| self.discs.positions[disc as usize][1] >= outlet)
            .collect();
        let leaving = self.discs.len() - stays.len();
        if leaving == 0 {
            return;
        }
        let before = self.energies(&self.evaluate()).total();
        // Lists speak of places in memory: they are built anew at once, with the springs of those that stay.
        self.list_only(&stays);
        let after = self.energies(&self.evaluate()).total();
        self.ledger.removed.add(before - after);
        self.removed += leaving as u64;
    }

    /// Lets discs of the rain in, with their energy.
    fn let_discs_in(&mut self) {
        let time = self.time();
        let Some(rain) = self.rain.as_mut().filter(|rain| rain.opens_at(self.count)) else {
            return;
        };
        let walls = self.parameters.walls_at(self.count);
        let entering = rain.entering(time, &self.discs, &walls, &self.parameters);
        if entering.is_empty() {
            return;
        }
        let before = self.energies(&self.evaluate()).total();
        let springs = self.neighbors.springs(&self.discs);
        entering.iter().for_each(|disc| self.discs.push(disc));
        self.neighbors.hold(springs);
        self.list_neighbors();
        let after = self.energies(&self.evaluate()).total();
        self.ledger.entered.add(after - before);
    }

    fn list_only(&mut self, stays: &[u32]) {
        let springs = self.neighbors.springs(&self.discs);
        self.discs.reorder(stays);
        self.neighbors.hold(springs);
        self.list_neighbors();
    }

    /// Puts discs that left through a periodic side back at the other one.
    fn put_back(&mut self) {
        let Parameters { sides, periodic, gravity, .. } = self.parameters;
        let Discs { positions, masses, .. } = &mut self.discs;
        for disc in
            neighbors::positions::groups_that_left(positions, sides, periodic).into_iter().flatten()
        {
            for axis in (0..2).filter(|&axis| periodic[axis]) {
                let before = positions[disc][axis];
                if before >= 0.0 && before < sides[axis] {
                    continue;
                }
                let turns = (before / sides[axis]).floor();
                if turns != 0.0 {
                    let after = before - turns * sides[axis];
                    positions[disc][axis] = after;
                    self.ledger.put_back.add(masses[disc] * gravity[axis] * (after - before));
                }
            }
        }
    }

    /// Stops a run whose ledger does not close.
    fn audit(&self) -> Result<(), BlowUp> {
        let evaluation = self.evaluate();
        let energies = self.energies(&evaluation);
        let balance = self.ledger.balance(&evaluation.moved, self.parameters.time_step);
        let residual = self.residual(&energies, &balance);
        let throughput = energies.kinetic + energies.elastic_normal + energies.elastic_tangential;
        let came = self.ledger.initial.abs() + self.ledger.entered.value().abs();
        let scale = came + throughput + balance.dissipated().abs();
        let share = residual.abs() / scale;
        // Written so that no number is no closed ledger.
        let is_closed = share <= LARGEST_RESIDUAL || scale == 0.0;
        if is_closed { Ok(()) } else { Err(BlowUp::Residual(share)) }
    }

    /// Takes stock at the start, so that the ledger's residual begins at zero.
    fn open_ledger(&mut self) {
        let evaluation = self.evaluate();
        let total = self.energies(&evaluation).total();
        self.ledger.open(total, &evaluation.moved, self.parameters.time_step);
    }

    /// Forces at the present state, found without touching it.
    fn evaluate(&self) -> Evaluation {
        self.evaluate_showing(&mut |_| {})
    }

    /// The same; `on_contact` is shown all contacts.
    fn evaluate_showing(&self, on_contact: &mut dyn FnMut(&Contact)) -> Evaluation {
        let walls = self.parameters.walls_at(self.count);
        let scope = self.neighbors.scope();
        let scene = scene(&self.parameters, &walls, &Window::default(), scope, self.use_lanes);
        Evaluation::of(&self.neighbors, &self.discs, &scene, &self.parameters, on_contact)
    }

    fn energies(&self, evaluation: &Evaluation) -> Energies {
        let Parameters { gravity, .. } = &self.parameters;
        let mut energies = Energies::of(&self.discs, evaluation, *gravity);
        energies.gravitational += self.ledger.put_back.value();
        energies
    }

    fn residual(&self, energies: &Energies, balance: &energy::Balance) -> f64 {
        let gone = balance.dissipated() + self.ledger.removed.value() - self.ledger.entered.value();
        energies.total() + gone - balance.wall_work - self.ledger.initial
    }
}

fn scene<'a>(
    parameters: &'a Parameters,
    walls: &'a [PlacedWall],
    window: &Window,
    scope: Scope,
    use_lanes: bool,
) -> Scene<'a> {
    Scene {
        law: &parameters.law,
        walls,
        time_step: parameters.time_step,
        smallest_radius: parameters.radius_range.0,
        known_overlap: window.largest_overlap,
        scope,
        use_lanes,
    }
}

impl Window {
    /// Adds a step.
    fn take(&mut self, moved: &Moved) {
        let deepest = moved.contacts.deepest.over_radius;
        if deepest > self.largest_overlap {
            self.largest_overlap = deepest;
        }
        self.wall_forces.resize(moved.contacts.walls.len(), [0.0; 2]);
        for (sum, [fx, fy, _]) in self.wall_forces.iter_mut().zip(&moved.contacts.walls) {
            *sum = [sum[0] + fx, sum[1] + fy];
        }
        self.steps += 1;
    }
}
