//! What is seen of a DEM run: the energy ledger, contacts, and the rebound of a single disc.

use super::rebounds::Rebounds;
use super::{Observer, Snapshot, relative_change};
use crate::figures::{self, Figures};
use crate::laws;
use crate::measurement::Measurement;
use kinetoscope_manifest::model::{DemConfig, DiscRadius};
use kinetoscope_recording::channels::{DemContacts, DemEnergy, DemTemperature, DemWalls};
use kinetoscope_recording::error::ReadError;
use kinetoscope_recording::reader::{RecordedFrame, StateTable};
use std::f64::consts::PI;

/// The ledger at one instant, J.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ledger {
    /// Simulated time, s.
    pub time_s: f64,
    /// Kinetic energy.
    pub kinetic_j: f64,
    /// Gravitational energy, zero at the origin.
    pub gravitational_j: f64,
    /// Energy of the contacts' springs.
    pub elastic_j: f64,
    /// Taken by the dashpots since the start.
    pub dissipated_j: f64,
    /// Part of what is dissipated: taken by friction.
    pub friction_j: f64,
    /// Done by the walls since the start.
    pub wall_work_j: f64,
    /// Taken along by discs that were removed.
    pub removed_j: f64,
}

impl Ledger {
    /// Mechanical energy.
    #[must_use]
    pub fn total_j(&self) -> f64 {
        self.kinetic_j + self.gravitational_j + self.elastic_j
    }

    /// What must stay constant: mechanical energy + dissipated + removed - wall work.
    #[must_use]
    pub fn balance_j(&self) -> f64 {
        self.total_j() + self.dissipated_j + self.removed_j - self.wall_work_j
    }
}

/// A DEM run while its frames go by.
#[derive(Clone, Debug)]
pub struct DemRun {
    pub(crate) config: DemConfig,
    pub(crate) ledger: Vec<Ledger>,
    pub(crate) snapshot: Snapshot,
    rebounds: Option<Rebounds>,
    contacts: Option<DemContacts>,
    discs_removed: Option<u64>,
    largest_overlap_over_radius: f64,
    granular_temperature: Option<f64>,
    packing_fraction: Option<f64>,
    largest_kinetic_disagreement_j: Option<f64>,
}

impl DemRun {
    /// Nothing seen yet.
    #[must_use]
    pub fn new(config: DemConfig) -> Self {
        let [across, along] = config.gravity_m_per_s2.map(|component| component.get());
        let drop = config.discs.get() == 1 && across == 0.0 && along < 0.0;
        let sag = config.mass_kg.get() * -along / config.stiffness_n_per_m.get();
        Self {
            rebounds: drop.then(|| Rebounds::new(-along, sag)),
            config,
            ledger: Vec::new(),
            snapshot: Snapshot::default(),
            contacts: None,
            discs_removed: None,
            largest_overlap_over_radius: 0.0,
            granular_temperature: None,
            packing_fraction: None,
            largest_kinetic_disagreement_j: None,
        }
    }

    /// Radius of equal discs, m.
    pub(crate) fn equal_radius(&self) -> Option<f64> {
        match self.config.radius_m {
            DiscRadius::Equal(radius) => Some(radius.get()),
            _ => None,
        }
    }

    /// Mass of a disc, kg: the areal density is that of a disc of the mean radius with the manifest's mass.
    fn mass_kg(&self, radius: f64) -> f64 {
        let mean = self.config.radius_m.mean();
        let ratio = radius / mean;
        self.config.mass_kg.get() * ratio * ratio
    }

    fn see_state(&mut self, time: f64, state: &StateTable, ledger: Option<&Ledger>) {
        self.snapshot.take(time, state, self.equal_radius());
        let radii: Option<Vec<f64>> = match (state.column("radius"), self.equal_radius()) {
            (Some(radii), _) => Some(radii.collect()),
            (None, equal) => equal.map(|radius| vec![radius; state.rows()]),
        };
        let Some(radii) = radii else { return };
        self.packing_fraction = Some(
            radii.iter().map(|radius| PI * radius * radius).sum::<f64>()
                / (self.config.width_m.get() * self.config.height_m.get()),
        );
        if let (Some(ledger), Some(vx), Some(vy)) = (ledger, state.column("vx"), state.column("vy"))
        {
            let masses: Vec<f64> = radii.iter().map(|radius| self.mass_kg(*radius)).collect();
            let kinetic = kinetic_energy_j(&masses, vx.zip(vy));
            let apart = (kinetic - ledger.kinetic_j).abs();
            let largest = self.largest_kinetic_disagreement_j.get_or_insert(0.0);
            if apart > *largest || apart.is_nan() {
                *largest = apart;
            }
        }
        if let (Some(rebounds), Some(y), Some(vy)) =
            (&mut self.rebounds, state.value(0, "y"), state.value(0, "vy"))
        {
            rebounds.see(time, y - radii[0], vy);
        }
    }

    fn ledger_measurements(&self, found: &mut Vec<Measurement>) {
        let (Some(first), Some(last)) = (self.ledger.first(), self.ledger.last()) else { return };
        for (name, value) in [
            ("energy.kinetic", last.kinetic_j),
            ("energy.gravitational", last.gravitational_j),
            ("energy.elastic", last.elastic_j),
            ("energy.dissipated", last.dissipated_j),
            ("energy.friction", last.friction_j),
            ("energy.wall_work", last.wall_work_j),
        ] {
            found.push(Measurement::new(name, "J", value, "/energy, last frame"));
        }
        let start = first.total_j();
        if start == 0.0 {
            return;
        }
        let change = relative_change(last.total_j(), start);
        let from = "/energy: mechanical energy, last frame against the first, over its size there";
        found.push(Measurement::new("energy.total_change_relative", "1", change, from));
        let residuals = || self.ledger.iter().map(|entry| entry.balance_j() - first.balance_j());
        let last_residual = last.balance_j() - first.balance_j();
        let from = "/energy: change of the ledger's sum over the energy at the start, last frame";
        found.push(
            Measurement::new("energy.residual_relative", "1", last_residual / start.abs(), from)
                .against(0.0, laws::dem::ENERGY_LEDGER),
        );
        let largest = residuals().map(f64::abs).fold(0.0, largest_or_nan);
        let from = "/energy: largest size of the ledger's residual over the energy at the start";
        found.push(
            Measurement::new("energy.largest_residual_relative", "1", largest / start.abs(), from)
                .against(0.0, laws::dem::ENERGY_LEDGER),
        );
        if let Some(apart) = self.largest_kinetic_disagreement_j {
            let from = "kinetic energy of /state against /energy, largest over frames, over the energy at the start";
            let value = apart / start.abs();
            found.push(Measurement::new("energy.kinetic_disagreement_relative", "1", value, from));
        }
    }
}

impl Observer for DemRun {
    fn see(&mut self, frame: &RecordedFrame) -> Result<(), ReadError> {
        let time_s = frame.clock.time;
        let ledger = frame.get::<DemEnergy>()?.map(|energy| Ledger {
            time_s,
            kinetic_j: energy.kinetic_j,
            gravitational_j: energy.gravitational_j,
            elastic_j: energy.elastic_j,
            dissipated_j: energy.dissipated_j,
            friction_j: energy.friction_j,
            wall_work_j: energy.wall_work_j,
            removed_j: energy.removed_j,
        });
        self.ledger.extend(ledger);
        if let Some(contacts) = frame.get::<DemContacts>()? {
            self.largest_overlap_over_radius = largest_or_nan(
                self.largest_overlap_over_radius,
                contacts.largest_overlap_over_radius,
            );
            self.contacts = Some(contacts);
        }
        if let Some(walls) = frame.get::<DemWalls>()? {
            self.discs_removed = Some(walls.discs_removed);
        }
        if let Some(temperature) = frame.get::<DemTemperature>()? {
            self.granular_temperature = Some(temperature.granular_temperature_m2_per_s2);
        }
        if let Some(state) = frame.state() {
            self.see_state(time_s, state, ledger.as_ref());
        }
        Ok(())
    }

    fn measurements(&self) -> Vec<Measurement> {
        let mut found = Vec::new();
        self.ledger_measurements(&mut found);
        if let Some(restitution) = self.rebounds.as_ref().and_then(Rebounds::restitution) {
            let from = "/state: sqrt(energy after / before) of each rebound, mean";
            found.push(
                Measurement::new("restitution.measured", "1", restitution, from)
                    .against(laws::dem::wall_restitution(&self.config), laws::dem::RESTITUTION),
            );
        }
        if let Some(contacts) = &self.contacts {
            let from = "/contact_count: largest since the start";
            let overlap = self.largest_overlap_over_radius;
            found.push(Measurement::new("largest_overlap_over_radius", "1", overlap, from));
            let contacts = contacts.coordination_number;
            let from = "/contact_count: contacts a disc, last frame";
            found.push(Measurement::new("coordination_number", "1", contacts, from));
        }
        if let Some(removed) = self.discs_removed {
            let from = "/wall_forces: discs that left through the outlet, last frame";
            found.push(Measurement::new("discs_removed", "1", removed as f64, from));
        }
        if let Some(temperature) = self.granular_temperature {
            let from = "/temperature: <(v - <v>)^2> / 2, last frame";
            found.push(Measurement::new("granular_temperature", "m^2/s^2", temperature, from));
        }
        if let Some(fraction) = self.packing_fraction {
            let from = "/state: discs' area over the box's";
            found.push(Measurement::new("packing_fraction", "1", fraction, from));
        }
        found
    }

    fn figures(&self) -> Figures {
        figures::dem::figures(self)
    }
}

/// Sum of m v^2 / 2, J.
fn kinetic_energy_j(masses: &[f64], velocities: impl Iterator<Item = (f64, f64)>) -> f64 {
    masses.iter().zip(velocities).map(|(mass, (vx, vy))| mass * (vx * vx + vy * vy) / 2.0).sum()
}

/// The larger of two, or not a number if either is none: a blow-up is not hidden.
pub(super) fn largest_or_nan(a: f64, b: f64) -> f64 {
    if a >= b || a.is_nan() { a } else { b }
}
