//! Spring–dashpot discs in a box.
//!
//! The equation of motion stands in [`motion`], one collision in closed form in [`restitution`], the discretisation in
//! `step`, the energy ledger in `energy`, and what can't be integrated is found by `stability` before the first step.

pub mod motion;
pub mod neighbours;
pub mod restitution;

mod contacts;
mod energy;
mod implicit;
mod observe;
mod parameters;
mod remedies;
mod report;
mod stability;
mod start;
mod step;

use crate::model::{Extent, Fault, Model, Progress, Refusal, Target};
use crate::random::Seed;
use crate::sum::CompensatedSum;
use contacts::Discs;
use kinetoscope_manifest::model::{DemConfig, DemIntegrator, Stability};
use kinetoscope_recording::channels::{
    ChannelDeclaration, DemContacts, DemEnergy, DemEnergyShare, DemTemperature,
};
use kinetoscope_recording::frame::{Frame, StateColumn};
use kinetoscope_recording::scenery::Scenery;
use parameters::Parameters;
use serde::{Deserialize, Serialize};
use stability::Diagnosis;
use step::{BlowUp, Evaluation};

/// Discs with spring–dashpot contacts in a box with gravity.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Dem {
    parameters: Parameters,
    discs: Discs,
    /// Steps since the start.
    count: u64,
    /// Energy taken by the dashpots up to half a step before the positions' time, J.
    dissipated: CompensatedSum,
    /// Kinetic + gravitational + elastic at the start, J.
    initial_energy: f64,
    /// Speed of the fastest disc at the start, m/s.
    initial_top_speed: f64,
    /// c = eta dt/m_eff of the lightest pair, for the words of a fault.
    damping_step: f64,
    window: Window,
    /// Lines of the log of frame 0.
    facts: Vec<String>,
    warnings: Vec<String>,
    /// Follows from the state; kept only for its memory and its neighbour list.
    #[serde(skip)]
    evaluation: Evaluation,
}

/// What is gathered between frames.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Window {
    /// Largest overlap over the smaller radius of a contact since the last frame.
    largest_overlap: f64,
    /// The target was reached: the next call opens a new window.
    is_closed: bool,
}

impl Model for Dem {
    type Config = DemConfig;
    const NAME: &'static str = "dem";
    const PHYSICS_VERSION: u32 = 1;
    const TIME_UNIT: &'static str = "s";
    /// `vx` and `vy` belong to the positions' time, v + a dt/2; `vx_step` and `vy_step` are the integrator's own.
    const STATE_COLUMNS: &'static [StateColumn] = &[
        StateColumn { name: "x", unit: "m" },
        StateColumn { name: "y", unit: "m" },
        StateColumn { name: "vx", unit: "m/s" },
        StateColumn { name: "vy", unit: "m/s" },
        StateColumn { name: "vx_step", unit: "m/s" },
        StateColumn { name: "vy_step", unit: "m/s" },
        StateColumn { name: "radius", unit: "m" },
    ];
    const CHANNELS: &'static [ChannelDeclaration] = &[
        ChannelDeclaration::of::<DemEnergy>(),
        ChannelDeclaration::of::<DemEnergyShare>(),
        ChannelDeclaration::of::<DemContacts>(),
        ChannelDeclaration::of::<DemTemperature>(),
    ];

    /// There is no series per collision: contacts last many steps.
    fn prepare(config: &DemConfig, seed: Seed, _per_collision: bool) -> Result<Self, Refusal> {
        let diagnosis = Diagnosis::of(config);
        let mut warnings = Vec::new();
        if diagnosis.is_refused() {
            let text = report::refusal(config, &diagnosis);
            if config.stability == Stability::Refuse || !diagnosis.is_countable() {
                return Err(Refusal(text));
            }
            warnings.push(text);
        }
        warnings.extend(diagnosis.doubts());
        let parameters = Parameters::new(config);
        let mut discs = start::discs(config, &parameters, seed)?;
        let facts = report::facts(config, &parameters, &diagnosis, &discs);
        let initial_top_speed = discs.velocities.iter().fold(0.0, |top, v| {
            let speed = (v[0] * v[0] + v[1] * v[1]).sqrt();
            if speed > top { speed } else { top }
        });
        if config.integrator == DemIntegrator::VelocityVerlet {
            step::set_back_by_half_a_step(&mut discs, parameters.gravity, parameters.time_step);
        }
        let mut model = Self {
            parameters,
            discs,
            count: 0,
            dissipated: CompensatedSum::default(),
            initial_energy: 0.0,
            initial_top_speed,
            damping_step: diagnosis.damping_step,
            window: Window { largest_overlap: 0.0, is_closed: true },
            facts,
            warnings,
            evaluation: Evaluation::default(),
        };
        model.open_ledger();
        Ok(model)
    }

    fn extent(&self) -> Extent {
        Extent::Steps { total: self.parameters.total_steps, step: self.parameters.time_step }
    }

    fn advance(&mut self, target: Target, at_most: u64) -> Result<Progress, Fault> {
        if self.window.is_closed {
            self.window = Window { largest_overlap: 0.0, is_closed: false };
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
            self.step().map_err(|blow_up| report::fault(self, blow_up))?;
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
    /// One time step: forces at the present state, the ledger's share, kick and drift.
    fn step(&mut self) -> Result<(), BlowUp> {
        let parameters = &self.parameters;
        self.evaluation.update(&self.discs, parameters);
        let overlap = self.evaluation.largest_overlap();
        if overlap > self.window.largest_overlap {
            self.window.largest_overlap = overlap;
        }
        self.evaluation.blow_up()?;
        let power = self.evaluation.dissipated_power(parameters);
        self.dissipated.add(power * parameters.time_step);
        let accelerations = &self.evaluation.accelerations;
        let moved = step::kick_and_drift(
            &mut self.discs,
            accelerations,
            parameters.sides,
            parameters.time_step,
        );
        self.count += 1;
        moved
    }

    /// Takes stock at the start, so that the ledger's residual begins at zero.
    fn open_ledger(&mut self) {
        let evaluation = self.evaluate();
        let time_step = self.parameters.time_step;
        let velocities = evaluation.velocities_at_positions(&self.discs, time_step);
        self.initial_energy = self.energies(&evaluation, &velocities).total();
        // A frame adds half a step of the power at its time.
        self.dissipated.add(-0.5 * time_step * evaluation.dissipated_power(&self.parameters));
    }
}
