//! Observer of DEM runs: energy balance, contacts, beds, stress, and the rebounds of a single disc.

use super::bed_shape;
use super::cooling::{self, Cooling};
use super::laws as law;
use super::metrics as metric;
use super::outflow::Outflow;
use super::rebounds::Rebounds;
use super::special_walls;
use super::stress::{self, DiscState, StressProfile};
use crate::metric::Measurement;
use crate::models::contract::Observer;
use crate::models::relative_change;
use crate::models::series::Series;
use crate::models::snapshots::{Snapshots, StateStyle};
use crate::plot::drawing;
use kinetoscope_manifest::model::{DemConfig, DemWallShape, DiscRadius, PeriodicSides};
use kinetoscope_recording::channels::{
    DemContactForces, DemContacts, DemEnergy, DemTemperature, DemWalls,
};
use kinetoscope_recording::error::ReadError;
use kinetoscope_recording::reader::{RecordedFrame, StateTable};
use std::f64::consts::PI;

/// Energies at one instant, J.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnergyBalance {
    /// Simulated time, s.
    pub time_s: f64,
    /// Kinetic energy.
    pub kinetic_j: f64,
    /// Gravitational energy, zero at the origin.
    pub gravitational_j: f64,
    /// Energy of the contacts' springs.
    pub elastic_j: f64,
    /// Energy dissipated since the start.
    pub dissipated_j: f64,
    /// Part of the dissipated energy: work of friction.
    pub friction_j: f64,
    /// Work of the walls since the start.
    pub wall_work_j: f64,
    /// Energy of the removed discs.
    pub removed_j: f64,
    /// Energy of the inserted discs.
    pub entered_j: f64,
}

impl EnergyBalance {
    /// Mechanical energy.
    #[must_use]
    pub fn total_j(&self) -> f64 {
        self.kinetic_j + self.gravitational_j + self.elastic_j
    }

    /// Conserved sum: mechanical energy + dissipated + removed - entered - wall work.
    #[must_use]
    pub fn balance_j(&self) -> f64 {
        self.total_j() + self.dissipated_j + self.removed_j - self.entered_j - self.wall_work_j
    }
}

/// Observer of one DEM run.
#[derive(Clone, Debug)]
pub struct DemRun {
    pub(crate) config: DemConfig,
    pub(crate) energy_balance: Series<EnergyBalance>,
    pub(crate) snapshots: Snapshots,
    max_residual_j: f64,
    last_motion_s: f64,
    rebounds: Option<Rebounds>,
    outflow: Outflow,
    cooling: Cooling,
    /// Mean upward force on a piston since the previous frame, N, over time.
    piston: Series<(f64, f64)>,
    reach_at_start_m: Option<f64>,
    /// `None` if the box does not support the bed.
    pub(crate) stress: Option<StressProfile>,
    contacts: Option<DemContacts>,
    discs_removed: Option<u64>,
    largest_overlap_over_radius: f64,
    granular_temperature: Option<f64>,
    max_kinetic_disagreement_j: Option<f64>,
}

/// Discs have settled when their kinetic energy stays below this fraction of the mechanical energy at the start.
const SETTLED_SHARE: f64 = 1e-3;

impl DemRun {
    /// Creates an observer without frames.
    #[must_use]
    pub fn new(config: DemConfig, snapshots: Snapshots) -> Self {
        let [across, along] = config.gravity_m_per_s2.map(|component| component.get());
        let is_alone = config.discs.get() == 1 && config.rain.is_none();
        let drop = is_alone && across == 0.0 && along < 0.0;
        let sag = config.mass_kg.get() * -along / config.stiffness_n_per_m.get();
        Self {
            rebounds: drop.then(|| Rebounds::new(-along, sag)),
            stress: StressProfile::new(&config),
            snapshots: snapshots.with_style(state_style(&config)),
            config,
            energy_balance: Series::default(),
            outflow: Outflow::default(),
            cooling: Cooling::default(),
            piston: Series::default(),
            reach_at_start_m: None,
            max_residual_j: 0.0,
            last_motion_s: 0.0,
            contacts: None,
            discs_removed: None,
            largest_overlap_over_radius: 0.0,
            granular_temperature: None,
            max_kinetic_disagreement_j: None,
        }
    }

    fn add_energy_balance(&mut self, entry: EnergyBalance) {
        self.energy_balance.add(entry);
        let Some(first) = self.energy_balance.first() else { return };
        let residual = (entry.balance_j() - first.balance_j()).abs();
        self.max_residual_j = max_or_nan(self.max_residual_j, residual);
        if entry.kinetic_j > SETTLED_SHARE * first.total_j().abs() {
            self.last_motion_s = entry.time_s;
        }
    }

    /// Radius of equal discs, m.
    pub(crate) fn equal_radius(&self) -> Option<f64> {
        match self.config.radius_m {
            DiscRadius::Equal(radius) => Some(radius.get()),
            _ => None,
        }
    }

    /// Mass of a disc, kg: the areal density is that of a disc with the mean radius and the manifest's mass.
    fn mass_kg(&self, radius: f64) -> f64 {
        let mean = self.config.radius_m.mean();
        let ratio = radius / mean;
        self.config.mass_kg.get() * ratio * ratio
    }

    fn add_state(&mut self, time: f64, state: &StateTable, energy_balance: Option<&EnergyBalance>) {
        let index = |name: &str| state.columns().iter().position(|column| column == name);
        let (radius, equal) = (index("radius"), self.equal_radius());
        if radius.is_none() && equal.is_none() {
            return;
        }
        let radius_of = |row: &[f64]| radius.map_or(equal.unwrap_or(0.0), |column| row[column]);
        if let (Some(energy_balance), Some(vx), Some(vy)) =
            (energy_balance, index("vx"), index("vy"))
        {
            let spin = index("spin");
            // The moment of inertia of a disc is m r^2 / 2.
            let mass = index("mass");
            let doubled: f64 = (0..state.rows())
                .map(|disc| {
                    let row = state.row(disc);
                    let radius = radius_of(row);
                    let turning = radius * spin.map_or(0.0, |column| row[column]);
                    let squares = row[vx] * row[vx] + row[vy] * row[vy];
                    let mass = mass.map_or_else(|| self.mass_kg(radius), |column| row[column]);
                    mass * (squares + turning * turning / 2.0)
                })
                .sum();
            let kinetic = doubled / 2.0;
            let apart = (kinetic - energy_balance.kinetic_j).abs();
            let largest = self.max_kinetic_disagreement_j.get_or_insert(0.0);
            *largest = max_or_nan(*largest, apart);
        }
        if let (Some(rebounds), Some(y), Some(vy)) =
            (&mut self.rebounds, state.value(0, "y"), state.value(0, "vy"))
        {
            rebounds.add_frame(time, y - radius_of(state.row(0)), vy);
        }
    }

    fn energy_measurements(&self, found: &mut Vec<Measurement>) {
        let (Some(first), Some(last)) = (self.energy_balance.first(), self.energy_balance.last())
        else {
            return;
        };
        found.extend([
            Measurement::new(metric::KINETIC, last.kinetic_j),
            Measurement::new(metric::GRAVITATIONAL, last.gravitational_j),
            Measurement::new(metric::ELASTIC, last.elastic_j),
            Measurement::new(metric::DISSIPATED, last.dissipated_j),
            Measurement::new(metric::FRICTION, last.friction_j),
            Measurement::new(metric::WALL_WORK, last.wall_work_j),
        ]);
        let residual = last.balance_j() - first.balance_j();
        found.push(Measurement::new(metric::RESIDUAL_DRIFT, residual).against(0.0));
        if let Some(count) = self.rebounds.as_ref().map(Rebounds::count).filter(|&count| count > 0)
        {
            let each = residual / count as f64;
            found.push(Measurement::new(metric::RESIDUAL_PER_REBOUND, each).against(0.0));
        }
        if self.last_motion_s < last.time_s {
            found.push(Measurement::new(metric::SETTLING_TIME, self.last_motion_s));
        }
        let start = first.total_j() + last.entered_j;
        if start == 0.0 {
            return;
        }
        let change = relative_change(last.total_j(), start);
        let largest = self.max_residual_j / start.abs();
        found.extend([
            Measurement::new(metric::TOTAL_CHANGE, change),
            Measurement::new(metric::RESIDUAL, residual / start.abs()).against(0.0),
            Measurement::new(metric::LARGEST_RESIDUAL, largest).against(0.0),
        ]);
        if let Some(apart) = self.max_kinetic_disagreement_j {
            found.push(Measurement::new(metric::KINETIC_DISAGREEMENT, apart / start.abs()));
        }
    }

    /// Bed of the last frame: its height and packing fraction, and the forces on floor and side walls.
    fn bed_measurements(&self, found: &mut Vec<Measurement>) {
        let Some(discs) = self.discs_at_end() else { return };
        let (width, height) = (self.config.width_m.get(), self.config.height_m.get());
        let area = |[_, _, radius, _]: &[f64; 4]| PI * radius * radius;
        let covered: f64 = discs.iter().map(area).sum();
        let raised: f64 = discs.iter().map(|disc| area(disc) * disc[1]).sum();
        let bed_height = 2.0 * raised / covered;
        let overlaps = |gap: &dyn Fn(&[f64; 4]) -> f64| -> f64 {
            let overlaps = discs.iter().map(|disc| disc[2] - gap(disc));
            overlaps.filter(|overlap| *overlap > 0.0).sum()
        };
        let stiffness = self.config.stiffness_n_per_m.get();
        let floor = stiffness * overlaps(&|disc| disc[1]);
        let sides = stiffness * (overlaps(&|disc| disc[0]) + overlaps(&|disc| width - disc[0]));
        found.push(Measurement::new(metric::PACKING_FRACTION, covered / (width * height)));
        let has_floor = !matches!(self.config.periodic, PeriodicSides::Y | PeriodicSides::Both);
        let down = -self.config.gravity_m_per_s2[1].get();
        if discs.len() < 2 || !has_floor || down <= 0.0 {
            return;
        }
        // Walls inside the box may support the discs instead of its floor.
        let weight = self.resting_weight_n().filter(|_| self.config.walls.is_empty());
        let carried = discs.iter().map(|disc| disc[3] * down).sum::<f64>();
        found.extend([
            Measurement::new(metric::BED_HEIGHT, bed_height),
            Measurement::new(metric::BED_PACKING_FRACTION, covered / (width * bed_height)),
            Measurement::new(metric::WEIGHT, carried),
            Measurement::new(metric::FLOOR_FORCE, floor).against(weight),
            Measurement::new(metric::FLOOR_STRESS, floor / width)
                .against(weight.map(|weight| weight / width)),
        ]);
        if self.config.periodic == PeriodicSides::None {
            let stress = sides / (2.0 * bed_height);
            found.push(Measurement::new(metric::SIDE_WALL_STRESS, stress));
        }
    }

    fn add_stress(&mut self, time_s: f64, state: &StateTable, forces: &DemContactForces) {
        let index = |name: &str| state.columns().iter().position(|column| column == name);
        let Some([x, y, vx, vy]) = all(["x", "y", "vx", "vy"].map(index)) else { return };
        let Some(floor) = stress::floor_m(&self.config, time_s) else { return };
        let mass = index("mass");
        let equal = self.equal_radius().map(|radius| self.mass_kg(radius));
        let grains = (0..state.rows()).filter_map(|disc| {
            let row = state.row(disc);
            let mass = mass.map(|column| row[column]).or(equal)?;
            Some(DiscState { position: [row[x], row[y]], velocity: [row[vx], row[vy]], mass })
        });
        if let Some(stress) = &mut self.stress {
            stress.add_frame(time_s, floor, grains, forces);
        }
    }

    /// Weight of the discs in the last frame, divided by the box width, N/m.
    pub(crate) fn weight_over_width(&self) -> Option<f64> {
        let down = -self.config.gravity_m_per_s2[1].get();
        let weight = self.discs_at_end()?.iter().map(|disc| disc[3] * down).sum::<f64>();
        Some(weight / self.config.width_m.get())
    }

    fn stress_measurements(&self, found: &mut Vec<Measurement>) {
        let Some(stress) = &self.stress else { return };
        let (layers, whole) = (stress.layers(), self.weight_over_width());
        let (Some(floor), Some(whole)) = (layers.first(), whole) else { return };
        let rests = self.resting_weight_n().is_some();
        let mid = layers.iter().find(|layer| layer.weight_above <= whole / 2.0);
        for (definition, layer) in
            [(metric::STRESS_AT_FLOOR, Some(floor)), (metric::STRESS_AT_MID_HEIGHT, mid)]
        {
            found.extend(layer.map(|layer| {
                let theory = rests.then_some(layer.weight_above);
                Measurement::new(definition, layer.vertical).against(theory)
            }));
        }
        let ratio = stress.horizontal_over_vertical();
        found.extend(ratio.map(|ratio| Measurement::new(metric::STRESS_RATIO, ratio)));
        let distances =
            layers.iter().map(|layer| (layer.vertical.value - layer.weight_above).abs() / whole);
        found.push(Measurement::new(metric::STRESS_DISTANCE, distances.fold(0.0, max_or_nan)));
    }

    /// Weight of the discs in the last frame, N, if they are at rest and supported only from below.
    fn resting_weight_n(&self) -> Option<f64> {
        let [across, along] = self.config.gravity_m_per_s2.map(|component| component.get());
        let rests = across == 0.0 && self.has_settled() && law::walls_are_smooth(&self.config);
        let discs = self.discs_at_end().filter(|_| rests)?;
        Some(discs.iter().map(|disc| disc[3] * -along).sum())
    }

    /// Metrics of special setups: outlets, free cooling, rows of discs, pistons, heaps, columns.
    fn scene_measurements(&self, found: &mut Vec<Measurement>) {
        if let Some(width) = special_walls::opening_width_m(&self.config) {
            found.push(Measurement::new(metric::OPENING_WIDTH, width));
            let free = width - law::EMPTY_ANNULUS * 2.0 * self.config.radius_m.mean();
            found.push(Measurement::new(metric::FREE_OPENING_WIDTH, free));
        }
        if let Some(rate) = self.outflow.rate_per_s() {
            found.push(Measurement::new(metric::OUTFLOW_RATE, rate));
        }
        if cooling::is_free_gas(&self.config)
            && let Some(rate) = self.cooling.rate_per_s()
        {
            let temperature = self.cooling.first();
            let theory = temperature.and_then(|first| law::cooling_rate_per_s(&self.config, first));
            found.push(Measurement::new(metric::COOLING_RATE, rate).against(theory));
        }
        let last = self.snapshots.last();
        if let Some(passed) =
            last.and_then(|end| special_walls::transmitted_velocity(&self.config, end))
        {
            let theory = law::transmitted_velocity(&self.config);
            found.push(Measurement::new(metric::TRANSMITTED_VELOCITY, passed).against(theory));
        }
        if let Some(force) = special_walls::late_mean(&self.piston) {
            let weight = self.resting_weight_n();
            found.push(Measurement::new(metric::PISTON_FORCE, force).against(weight));
        }
        let falls = self.config.gravity_m_per_s2[1].get() < 0.0;
        let discs = self.discs_at_end().filter(|discs| falls && discs.len() > 1);
        let Some(discs) = discs else { return };
        let width = self.config.width_m.get();
        if let Some(slope) = bed_shape::slope_deg(&discs, width) {
            found.push(Measurement::new(metric::SLOPE, slope));
        }
        if let (Some(reach), Some(start)) =
            (bed_shape::reach_m(&discs, width), self.reach_at_start_m)
        {
            found.push(Measurement::new(metric::REACH, reach));
            found.extend(
                special_walls::has_gate(&self.config)
                    .then(|| Measurement::new(metric::RUN_OUT, reach / start - 1.0)),
            );
        }
    }

    /// Whether the discs are at rest: the kinetic energy is far below the elastic energy.
    fn has_settled(&self) -> bool {
        self.energy_balance
            .last()
            .is_some_and(|last| last.kinetic_j < SETTLED_SHARE * last.elastic_j)
    }

    /// x, y, radius (m) and mass (kg) of all discs in the last frame.
    pub(crate) fn discs_at_end(&self) -> Option<Vec<[f64; 4]>> {
        let state = self.snapshots.last()?;
        let index = |name: &str| state.columns().iter().position(|column| column == name);
        let (x, y, radius) = (index("x")?, index("y")?, index("radius"));
        let mass = index("mass");
        let equal = self.equal_radius();
        (0..state.rows())
            .map(|disc| {
                let row = state.row(disc);
                let radius = radius.map(|column| row[column]).or(equal)?;
                let mass = mass.map_or_else(|| self.mass_kg(radius), |column| row[column]);
                Some([row[x], row[y], radius, mass])
            })
            .collect()
    }
}

impl Observer for DemRun {
    fn observe(&mut self, mut frame: RecordedFrame) -> Result<(), ReadError> {
        let time_s = frame.clock.time;
        let energy_balance = frame.get::<DemEnergy>()?.map(|energy| EnergyBalance {
            time_s,
            kinetic_j: energy.kinetic_j,
            gravitational_j: energy.gravitational_j,
            elastic_j: energy.elastic_j,
            dissipated_j: energy.dissipated_j,
            friction_j: energy.friction_j,
            wall_work_j: energy.wall_work_j,
            removed_j: energy.removed_j,
            entered_j: energy.entered_j,
        });
        energy_balance.into_iter().for_each(|entry| self.add_energy_balance(entry));
        if let Some(contacts) = frame.get::<DemContacts>()? {
            self.largest_overlap_over_radius =
                max_or_nan(self.largest_overlap_over_radius, contacts.largest_overlap_over_radius);
            self.contacts = Some(contacts);
        }
        if let Some(walls) = frame.get::<DemWalls>()? {
            self.outflow.add_frame(time_s, walls.discs_removed);
            if let Some(number) = special_walls::piston(&self.config)
                && let Some(&force) = walls.mean_force_y_n.get(number)
            {
                self.piston.add((time_s, force));
            }
            self.discs_removed = Some(walls.discs_removed);
        }
        if let Some(temperature) = frame.get::<DemTemperature>()? {
            self.cooling.add_frame(time_s, temperature.granular_temperature_m2_per_s2);
            self.granular_temperature = Some(temperature.granular_temperature_m2_per_s2);
        }
        let forces = frame.get::<DemContactForces>()?;
        if let Some(state) = frame.take_state() {
            if let Some(forces) = forces {
                self.add_stress(time_s, &state, &forces);
            }
            self.add_state(time_s, &state, energy_balance.as_ref());
            self.snapshots.add_state(&frame, state);
            if self.reach_at_start_m.is_none() {
                let width = self.config.width_m.get();
                let discs = self.discs_at_end();
                self.reach_at_start_m = discs.and_then(|discs| bed_shape::reach_m(&discs, width));
            }
        }
        self.snapshots.keep_scenes(frame);
        Ok(())
    }

    fn measurements(&self) -> Vec<Measurement> {
        let mut found = Vec::new();
        self.energy_measurements(&mut found);
        if let Some(rebounds) = self.rebounds.as_ref().filter(|rebounds| rebounds.count() > 0) {
            let theory = law::wall_restitution(&self.config);
            found.extend(
                rebounds
                    .restitution()
                    .map(|value| Measurement::new(metric::RESTITUTION, value).against(theory)),
            );
            let theory = law::wall_contact_duration_s(&self.config);
            found.extend(
                rebounds
                    .contact_duration_s()
                    .map(|value| Measurement::new(metric::CONTACT_DURATION, value).against(theory)),
            );
        }
        if let Some(contacts) = &self.contacts {
            let overlap = self.largest_overlap_over_radius;
            found.push(Measurement::new(metric::LARGEST_OVERLAP, overlap));
            found.push(Measurement::new(metric::COORDINATION, contacts.coordination_number));
        }
        if let Some(removed) = self.discs_removed {
            found.push(Measurement::new(metric::DISCS_REMOVED, removed as f64));
        }
        if let Some(temperature) = self.granular_temperature {
            found.push(Measurement::new(metric::GRANULAR_TEMPERATURE, temperature));
        }
        self.bed_measurements(&mut found);
        self.stress_measurements(&mut found);
        self.scene_measurements(&mut found);
        found
    }
}

/// How states without scenes are drawn: in the box with its walls at rest.
fn state_style(config: &DemConfig) -> StateStyle {
    let outline = [[0.0; 2], [config.width_m.get(), config.height_m.get()]];
    let at_rest = config.walls.iter().filter(|wall| wall.is_at_rest());
    let inner = at_rest.map(|wall| match wall.shape {
        DemWallShape::Segment { from_m, to_m } => {
            drawing::wall(vec![[from_m, to_m].map(|end| end.map(|coordinate| coordinate.get()))])
        }
        DemWallShape::Drum { center_m, radius_m, .. } => {
            drawing::circle(center_m.map(|coordinate| coordinate.get()), radius_m.get())
        }
    });
    let walls = [drawing::rectangle(outline)].into_iter().chain(inner).collect();
    StateStyle { walls, radius: config.radius_m.mean() }
}

/// All indices; `None` if one is missing.
fn all<const N: usize>(found: [Option<usize>; N]) -> Option<[usize; N]> {
    let found: Vec<usize> = found.into_iter().collect::<Option<_>>()?;
    found.try_into().ok()
}

/// The larger of two, or not a number if either is none: a blow-up is not hidden.
pub(super) fn max_or_nan(a: f64, b: f64) -> f64 {
    if a >= b || a.is_nan() { a } else { b }
}
