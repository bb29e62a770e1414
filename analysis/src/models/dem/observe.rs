//! Observer of DEM runs: energy balance, contacts, beds, stress, and the rebounds of a single disc.

use super::bed_shape;
use super::contact_constants;
use super::disc::{Disc, discs};
use super::elasticity::Elastic;
use super::laws as law;
use super::metrics as metric;
use super::rebounds::Rebounds;
use super::special_setups;
use super::stress::{self, StressProfile};
use crate::metric::Measurements;
use crate::metric::theory::ExpectedValue;
use crate::models::contract::{Extent, Observer};
use crate::models::flow_statistics::FlowStatistics;
use crate::models::lyapunov::Growth;
use crate::models::series::Series;
use crate::models::snapshots::{Snapshots, StateStyle};
use crate::models::{max_or_nan, relative_change};
use crate::statistics::{Estimate, MissingError};
use kinetoscope_manifest::model::{DemConfig, DiscRadius, PeriodicSides, Placement};
use kinetoscope_recording::channels::{
    DemContactForces, DemContactStatistics, DemEnergy, DemTemperature, DemWalls,
};
use kinetoscope_recording::error::ReadError;
use kinetoscope_recording::reader::{RecordedFrame, StateTable};
use std::f64::consts::PI;

/// Mechanical energy, J.
pub(super) fn total_j(energy: &DemEnergy) -> f64 {
    energy.kinetic_j + energy.gravitational_j + energy.elastic_j
}

/// Conserved sum, J: mechanical energy + dissipated + removed - entered - wall work.
pub(super) fn balance_j(energy: &DemEnergy) -> f64 {
    total_j(energy) + energy.dissipated_j + energy.removed_j - energy.entered_j - energy.wall_work_j
}

/// Energy that the run was given, J: the mechanical energy at the start and that of all discs inserted until the last frame.
pub(super) fn supplied_j(first: &DemEnergy, last: &DemEnergy) -> f64 {
    total_j(first) + last.entered_j
}

/// Observer of one DEM run.
#[derive(Clone, Debug, Default)]
pub(super) struct DemRun {
    pub(super) config: DemConfig,
    /// Time, s, and energies.
    pub(super) energies: Series<(f64, DemEnergy)>,
    pub(super) snapshots: Snapshots,
    /// Homogeneity of a free gas.
    flow: FlowStatistics,
    max_residual_j: f64,
    last_motion_s: f64,
    rebounds: Option<Rebounds>,
    /// Time, s, and number of removed discs.
    pub(super) removed: Series<(f64, f64)>,
    /// Time, s, and granular temperature, m^2/s^2.
    pub(super) temperature: Series<(f64, f64)>,
    /// Time, s, and mean upward force on a piston since the previous frame, N.
    piston: Series<(f64, f64)>,
    deposit_length_at_start_m: Option<f64>,
    /// `None` if the box does not support the bed.
    pub(super) stress: Option<StressProfile>,
    /// Time, s, and velocity along the row of each of its discs, m/s; empty without a row, and for one too long to be plotted.
    pub(super) row_velocities: Vec<Series<(f64, f64)>>,
    contacts: Option<DemContactStatistics>,
    max_overlap_over_radius: f64,
    /// Time, s, and largest overlap over radius in the steps since the previous frame.
    pub(super) overlaps: Series<(f64, f64)>,
    max_kinetic_disagreement_j: Option<f64>,
    /// Time over the number of steps in the last frame, s; `None` before the first step.
    time_step_s: Option<f64>,
    frames: u64,
    divergence: Growth,
    /// Whether the recording has no state of some frames.
    lacks_states: bool,
}

/// Discs have settled when their kinetic energy stays below this fraction of the mechanical energy at the start.
const SETTLED_FRACTION: f64 = 1e-3;
/// Why the force on the walls is missing.
const MATERIALS_ARE_NOT_RECORDED: &str =
    "stiffness or cohesion at the walls differ by material, which is not recorded";
/// Maximum number of discs in a row whose velocities are plotted, so that their curves have different colors.
const MOST_IN_ROW: usize = 8;

impl DemRun {
    /// Creates an observer without frames.
    pub(super) fn new(config: DemConfig, snapshots: Snapshots) -> Self {
        let [across, along] = config.gravity_m_per_s2.map(|component| component.get());
        let is_alone = config.discs.get() == 1 && config.insertion.is_none();
        let drop = is_alone && across == 0.0 && along < 0.0;
        let Extent { walls, radius, .. } = super::extent(&config);
        let weight = config.mass_kg.get() * -along;
        let elastic = Elastic::of_walls(&config).unwrap_or_else(|| Elastic::of(&config, 1.0));
        let sag = elastic.overlap_m(weight, config.radius_m.mean());
        let row = special_setups::row_of(&config).filter(|count| *count <= MOST_IN_ROW);
        Self {
            row_velocities: vec![Series::default(); row.unwrap_or(0)],
            rebounds: drop.then(|| Rebounds::new(-along, sag)),
            stress: StressProfile::new(&config),
            snapshots: snapshots.with_style(StateStyle { walls, radius }).with_velocities("m/s"),
            config,
            ..Self::default()
        }
    }

    fn add_energy(&mut self, time_s: f64, energy: &DemEnergy) {
        self.energies.add((time_s, energy.clone()));
        let Some((_, first)) = self.energies.first() else { return };
        let residual = (balance_j(energy) - balance_j(first)).abs();
        self.max_residual_j = max_or_nan(self.max_residual_j, residual);
        if energy.kinetic_j > SETTLED_FRACTION * total_j(first).abs() {
            self.last_motion_s = time_s;
        }
    }

    fn add_state(&mut self, time_s: f64, state: &StateTable, energy: Option<&DemEnergy>) {
        if let (Some(energy), Some(discs)) = (energy, discs(&self.config, state)) {
            // The moment of inertia of a disc is m r^2 / 2.
            let twice_kinetic: f64 = discs
                .map(|disc| {
                    let ([vx, vy], rim_speed) = (disc.velocity, disc.radius * disc.spin);
                    disc.mass * (vx * vx + vy * vy + rim_speed * rim_speed / 2.0)
                })
                .sum();
            let difference = (twice_kinetic / 2.0 - energy.kinetic_j).abs();
            let max = self.max_kinetic_disagreement_j.get_or_insert(0.0);
            *max = max_or_nan(*max, difference);
        }
        let in_row = discs(&self.config, state).filter(|_| !self.row_velocities.is_empty());
        for (disc, series) in in_row.into_iter().flatten().zip(&mut self.row_velocities) {
            series.add((time_s, disc.velocity[0]));
        }
        let first = discs(&self.config, state).and_then(|mut discs| discs.next());
        if let (Some(rebounds), Some(disc)) = (&mut self.rebounds, first) {
            rebounds.add_frame(time_s, disc.position[1] - disc.radius, disc.velocity[1]);
        }
    }

    fn add_stress(&mut self, time_s: f64, state: &StateTable, forces: &DemContactForces) {
        if let (Some(stress), Some(floor), Some(discs)) =
            (&mut self.stress, stress::floor_m(&self.config, time_s), discs(&self.config, state))
        {
            stress.add_frame(time_s, floor, discs, forces);
        }
    }

    fn measure_energies(&self, found: &mut Measurements) {
        let (Some((_, first)), Some((end_s, last))) = (self.energies.first(), self.energies.last())
        else {
            return;
        };
        found.add(metric::KINETIC, last.kinetic_j);
        found.add(metric::GRAVITATIONAL, last.gravitational_j);
        found.add(metric::ELASTIC, last.elastic_j);
        found.add(metric::DISSIPATED, last.dissipated_j);
        found.add(metric::FRICTION, last.friction_j);
        let has_lost = last.dissipated_j > 0.0;
        let of_friction = has_lost.then_some(last.friction_j / last.dissipated_j);
        found.add(metric::FRICTION_FRACTION, of_friction);
        found.add(metric::ROLLING, last.rolling_j);
        found.add(metric::WALL_WORK, last.wall_work_j);
        let residual = balance_j(last) - balance_j(first);
        found.compare(metric::RESIDUAL, residual, 0.0);
        if let Some(rebounds) = self.known_rebounds() {
            let per_rebound = residual / rebounds.count() as f64;
            found.compare(metric::RESIDUAL_PER_REBOUND, per_rebound, 0.0);
        }
        let has_settled = self.last_motion_s < *end_s;
        found.add(metric::SETTLING_TIME, has_settled.then_some(self.last_motion_s));
        let start = supplied_j(first, last);
        if start == 0.0 {
            return;
        }
        found.add(metric::TOTAL_CHANGE, relative_change(total_j(last), start));
        found.compare(metric::RELATIVE_RESIDUAL, residual / start.abs(), 0.0);
        found.compare(metric::MAX_RESIDUAL, self.max_residual_j / start.abs(), 0.0);
        let disagreement = self.max_kinetic_disagreement_j.map(|energy| energy / start.abs());
        found.compare(metric::KINETIC_DISAGREEMENT, disagreement, 0.0);
    }

    /// The granular temperature of the first frame, of drawn velocities or of those that the manifest lists.
    fn measure_start(&self, found: &mut Measurements) {
        let Some(&(_, start)) = self.temperature.first() else { return };
        if let Some([expected, scatter]) = law::drawn_temperature(&self.config) {
            let start = Estimate::new(start, scatter);
            found.compare(metric::GRANULAR_TEMPERATURE_START, start, expected);
        } else if matches!(self.config.placement, Placement::Given(_))
            && self.config.discs.get() > 1
        {
            // A disc may fall in at the start, if there is room.
            let start = match self.config.insertion {
                None => Estimate::set_by_manifest(start),
                Some(_) => Estimate::bare(start),
            };
            found.add(metric::GRANULAR_TEMPERATURE_START, start);
        }
    }

    /// The rebounds, if there are any. Between keyframes, there may be.
    pub(super) fn known_rebounds(&self) -> Option<&Rebounds> {
        let may_have = self.lacks_states && self.snapshots.last().is_some();
        self.rebounds.as_ref().filter(|rebounds| rebounds.count() > 0 || may_have)
    }

    /// Bed of the last frame: its height and packing fraction, and the forces on floor and side walls.
    fn measure_bed(&self, found: &mut Measurements) {
        let Some(discs) = self.discs_at_end() else { return };
        let (width, height) = (self.config.width_m.get(), self.config.height_m.get());
        let area = |[_, _, radius, _]: &[f64; 4]| PI * radius * radius;
        let covered: f64 = discs.iter().map(area).sum();
        let raised: f64 = discs.iter().map(|disc| area(disc) * disc[1]).sum();
        let bed_height = 2.0 * raised / covered;
        let contacts = |distances: &dyn Fn(&[f64; 4]) -> f64| -> Vec<[f64; 2]> {
            let overlaps = discs.iter().map(|disc| [disc[2] - distances(disc), disc[2]]);
            overlaps.filter(|[overlap, _]| *overlap > 0.0).collect()
        };
        let floor = self.wall_force_n(&[contacts(&|disc| disc[1])]);
        let sides = [contacts(&|disc| disc[0]), contacts(&|disc| width - disc[0])];
        let sides = self.wall_force_n(&sides);
        let of_discs = |value: f64| match self.has_given_discs() {
            true => Estimate::set_by_manifest(value),
            false => Estimate::bare(value),
        };
        found.add(metric::PACKING_FRACTION, of_discs(covered / (width * height)));
        let down = -self.config.gravity_m_per_s2[1].get();
        if discs.len() < 2 || !special_setups::has_floor(&self.config) || down <= 0.0 {
            return;
        }
        // Walls inside the box may support the discs instead of its floor.
        let weight = self.resting_weight_n().filter(|_| self.config.walls.is_empty());
        found.add(metric::BED_HEIGHT, bed_height);
        found.add(metric::BED_PACKING_FRACTION, covered / (width * bed_height));
        found.add(metric::WEIGHT, self.weight_n().map(of_discs));
        found.compare(metric::FLOOR_FORCE, floor, weight);
        let stress = floor.map(|floor| floor / width);
        found.compare(metric::FLOOR_STRESS, stress, weight.map(|weight| weight / width));
        if self.config.periodic == PeriodicSides::None {
            found.add(metric::SIDE_WALL_STRESS, sides.map(|sides| sides / (2.0 * bed_height)));
        }
        if floor.is_none() {
            found.explain(metric::FLOOR_FORCE, MATERIALS_ARE_NOT_RECORDED);
        }
    }

    /// Force on walls by the overlaps and radii of the discs in contact with each, N; `None` if it depends on the materials.
    fn wall_force_n(&self, walls: &[Vec<[f64; 2]>]) -> Option<f64> {
        let elastic = Elastic::of_walls(&self.config)?;
        let cohesion = contact_constants::with_walls(&self.config, |pair| Some(pair.cohesion_n))?;
        let force = |&[overlap, radius]: &[f64; 2]| elastic.force_over_factor(overlap, radius);
        let pushes = |contacts: &Vec<[f64; 2]>| contacts.iter().map(force).sum::<f64>();
        let contacts: usize = walls.iter().map(Vec::len).sum();
        let pushed: f64 = walls.iter().map(pushes).sum();
        Some(elastic.factor() * pushed - contacts as f64 * cohesion)
    }

    /// Whether the manifest alone determines number, sizes and masses of the discs in the last frame.
    fn has_given_discs(&self) -> bool {
        matches!(self.config.radius_m, DiscRadius::Equal(_))
            && self.config.materials.len() < 2
            && self.config.insertion.is_none()
            && self.config.remove_below_m.is_none()
    }

    fn measure_stress(&self, found: &mut Measurements) {
        let Some(stress) = &self.stress else { return };
        let (layers, whole) = (stress.layers(), self.weight_over_width());
        let (Some(floor), Some(whole)) = (layers.first(), whole) else { return };
        let rests = self.resting_weight_n().is_some();
        let mid = layers.iter().find(|layer| layer.weight_above <= whole / 2.0);
        for (definition, layer) in
            [(metric::STRESS_AT_FLOOR, Some(floor)), (metric::STRESS_AT_MID_HEIGHT, mid)]
        {
            let weight = layer.filter(|_| rests).map(|layer| layer.weight_above);
            found.compare(definition, layer.map(|layer| layer.vertical), weight);
        }
        found.add(metric::LATERAL_STRESS_RATIO, stress.lateral_ratio());
        let deviations =
            layers.iter().map(|layer| (layer.vertical.value - layer.weight_above).abs() / whole);
        found.add(metric::OVERBURDEN_DEVIATION, deviations.fold(0.0, max_or_nan));
    }

    /// Weight of the discs in the last frame, N.
    fn weight_n(&self) -> Option<f64> {
        let down = -self.config.gravity_m_per_s2[1].get();
        Some(self.discs_at_end()?.iter().map(|disc| disc[3] * down).sum())
    }

    /// The weight divided by the box width, N/m.
    pub(super) fn weight_over_width(&self) -> Option<f64> {
        self.weight_n().map(|weight| weight / self.config.width_m.get())
    }

    /// The weight if the discs are at rest and supported only from below.
    fn resting_weight_n(&self) -> Option<f64> {
        // At rest, the kinetic energy is far below the elastic energy.
        let (_, last) = self.energies.last()?;
        let rests = last.kinetic_j < SETTLED_FRACTION * last.elastic_j.abs()
            && self.config.gravity_m_per_s2[0].get() == 0.0
            && law::are_walls_frictionless(&self.config);
        self.weight_n().filter(|_| rests)
    }

    /// Metrics of special setups: outlets, free cooling, rows of discs, pistons, heaps, columns.
    fn measure_special_setups(&self, found: &mut Measurements) {
        let config = &self.config;
        let orifice = special_setups::orifice_width_m(config);
        let annulus = law::EMPTY_ANNULUS * 2.0 * config.radius_m.mean();
        found.add(metric::ORIFICE_WIDTH, orifice.map(Estimate::set_by_manifest));
        let effective = orifice.map(|width| Estimate::set_by_manifest(width - annulus));
        found.add(metric::EFFECTIVE_WIDTH, effective);
        found.add(metric::DISCHARGE_RATE, special_setups::discharge_rate_per_s(&self.removed));
        if let Some((_, first)) = self.temperature.first()
            && special_setups::is_free_gas(config)
        {
            let rate = special_setups::cooling_rate_per_s(&self.temperature);
            let rate =
                rate.map(|rate| Estimate::bare(rate).without_error(MissingError::DependsOnStart));
            let theory = law::cooling_rate_per_s(config, *first).map(|theory| ExpectedValue {
                violation: theory.violation.or_else(|| self.flow.violation()),
                ..theory
            });
            found.compare(metric::COOLING_RATE, rate, theory);
        }
        let end = self.snapshots.last();
        let transmission = end.and_then(|end| special_setups::velocity_transmission(config, end));
        let theory = law::velocity_transmission(config);
        found.compare(metric::VELOCITY_TRANSMISSION, transmission, theory);
        let force = special_setups::late_mean(&self.piston);
        found.compare(metric::PISTON_FORCE, force, self.resting_weight_n());
        let falls = config.gravity_m_per_s2[1].get() < 0.0;
        let discs = self.discs_at_end().filter(|discs| falls && discs.len() > 1);
        let Some(discs) = discs else { return };
        let width = config.width_m.get();
        let angle = bed_shape::surface_angle_deg(&discs, width).filter(|_| self.is_bed(&discs));
        found.add(metric::SURFACE_ANGLE, angle);
        if let (Some(length), Some(start)) =
            (bed_shape::deposit_length_m(&discs, width), self.deposit_length_at_start_m)
        {
            let has_gate = special_setups::has_gate(config);
            found.add(metric::DEPOSIT_LENGTH, length);
            found.add(metric::RUNOUT, has_gate.then(|| length / start - 1.0));
        }
    }

    /// Whether the discs of the last frame form a bed instead of flying: each touches another on average, or the kinetic energy
    /// could not raise them by a quarter of a radius and the contacts carry the discs. Discs in the air at the start are slow, too.
    pub(super) fn is_bed(&self, discs: &[[f64; 4]]) -> bool {
        let down = -self.config.gravity_m_per_s2[1].get();
        // A disc that carries only itself has the elastic energy of its weight, or about half of it on two contacts. A quarter is
        // enough.
        let ratio = contact_constants::max_stiffness(&self.config);
        let elastic = Elastic::of(&self.config, ratio);
        let carried = discs.iter().map(|disc| elastic.energy_j(disc[3] * down, disc[2]));
        let least_elastic_j = carried.sum::<f64>() / 4.0;
        let raised: f64 = discs.iter().map(|[.., radius, mass]| mass * down * radius / 4.0).sum();
        let rests =
            |last: &DemEnergy| last.kinetic_j < raised && last.elastic_j.abs() > least_elastic_j;
        // Without energies, a run of several frames counts as settled.
        let is_settled = self.energies.last().map_or(self.frames > 1, |(_, last)| rests(last));
        let touches = |contacts: &DemContactStatistics| contacts.coordination_number >= 1.0;
        is_settled || self.contacts.as_ref().is_some_and(touches)
    }

    /// x, y, radius (m) and mass (kg) of all discs in the last frame.
    pub(super) fn discs_at_end(&self) -> Option<Vec<[f64; 4]>> {
        let discs = discs(&self.config, self.snapshots.last()?)?;
        Some(
            discs
                .map(|disc| [disc.position[0], disc.position[1], disc.radius, disc.mass])
                .collect(),
        )
    }
}

impl Observer for DemRun {
    fn observe(&mut self, mut frame: RecordedFrame) -> Result<(), ReadError> {
        let time_s = frame.clock.time;
        let steps = frame.clock.step_or_event_count;
        self.time_step_s = (steps > 0).then(|| time_s / steps as f64);
        self.frames += 1;
        self.divergence.add_frame(&frame, self.config.duration_s.get())?;
        if !frame.is_complete() {
            self.lacks_states = true;
            self.flow.add_frame_without_state();
        }
        let energy = frame.get::<DemEnergy>()?;
        if let Some(energy) = &energy {
            self.add_energy(time_s, energy);
        }
        if let Some(contacts) = frame.get::<DemContactStatistics>()? {
            self.max_overlap_over_radius =
                max_or_nan(self.max_overlap_over_radius, contacts.max_overlap_over_radius);
            self.overlaps.add((time_s, contacts.max_overlap_over_radius));
            self.contacts = Some(contacts);
        }
        if let Some(walls) = frame.get::<DemWalls>()? {
            self.removed.add((time_s, walls.discs_removed as f64));
            if let Some(number) = special_setups::piston(&self.config)
                && let Some(&force) = walls.mean_force_y_n.get(number)
                && !force.is_nan()
            {
                self.piston.add((time_s, force));
            }
        }
        if let Some(temperature) = frame.get::<DemTemperature>()? {
            self.temperature.add((time_s, temperature.granular_temperature_m2_per_s2));
        }
        let forces = frame.get::<DemContactForces>()?;
        if let Some(state) = frame.take_state() {
            if let Some(forces) = forces {
                self.add_stress(time_s, &state, &forces);
            }
            self.add_state(time_s, &state, energy.as_ref());
            if special_setups::is_free_gas(&self.config) {
                let sides = [self.config.width_m.get(), self.config.height_m.get()];
                self.flow.add_state(&state, [0.0; 2], sides);
            }
            self.snapshots.add_state(&frame, state);
            if self.deposit_length_at_start_m.is_none() {
                let width = self.config.width_m.get();
                self.deposit_length_at_start_m = self
                    .discs_at_end()
                    .and_then(|discs| bed_shape::deposit_length_m(&discs, width));
            }
        }
        self.snapshots.keep_scenes(frame);
        Ok(())
    }

    fn measure(&self, found: &mut Measurements) {
        self.measure_energies(found);
        if let Some(rebounds) = self.known_rebounds() {
            let contact = law::WallContact::of(&self.config);
            let theory = contact.map(|contact| contact.restitution());
            found.compare(metric::RESTITUTION, rebounds.restitution(), theory);
            let velocity = rebounds.impact_velocity();
            let constants = [rebounds.gravity(), self.time_step_s.unwrap_or(0.0)];
            let hertz = velocity.and_then(|it| law::hertz_duration_s(&self.config, it, constants));
            let (by, theory) = match hertz {
                Some(_) => (law::HERTZ_DURATION, hertz),
                None => (law::CONTACT_DURATION, contact.and_then(|contact| contact.duration_s())),
            };
            let duration = rebounds.contact_duration_s();
            found.compare_with(metric::CONTACT_DURATION, duration, by, theory);
            found.add(metric::IMPACT_VELOCITY, velocity);
        }
        if let Some(contacts) = &self.contacts {
            found.add(metric::MAX_OVERLAP, self.max_overlap_over_radius);
            found.add(metric::COORDINATION_NUMBER, contacts.coordination_number);
        }
        let last = self.snapshots.last().and_then(|state| discs(&self.config, state));
        if let Some(last) = last {
            let rotational = |disc: Disc| disc.mass * (disc.radius * disc.spin).powi(2) / 4.0;
            let (count, rotational_j) =
                last.fold((0, 0.0), |(count, sum), disc| (count + 1, sum + rotational(disc)));
            found.add(metric::ROTATIONAL, rotational_j);
            let pairs = self.contacts.as_ref().filter(|_| count > 0);
            let per_disc = pairs.map(|all| 2.0 * all.pair_contacts as f64 / f64::from(count));
            found.add(metric::PAIR_COORDINATION_NUMBER, per_disc);
        }
        found.add(metric::DISCS_REMOVED, self.removed.last().map(|(_, removed)| *removed));
        self.measure_start(found);
        let temperature = self.temperature.last().map(|(_, temperature)| *temperature);
        found.add(metric::GRANULAR_TEMPERATURE, temperature);
        self.measure_bed(found);
        self.measure_stress(found);
        self.measure_special_setups(found);
        let exponent = self.divergence.exponent().map(|exponent| match self.energies.last() {
            Some((_, last)) if last.dissipated_j > 0.0 => {
                exponent.without_error(MissingError::Drifting)
            }
            _ => exponent,
        });
        Growth::measure(exponent, [metric::LYAPUNOV, metric::DIVERGENCE_TIME], None, found);
        found.add(metric::TIME_STEP, self.time_step_s.map(Estimate::set_by_manifest));
    }
}
