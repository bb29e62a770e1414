//! Observer of packing runs: temperature, a2, collision rates, pressure and structure.

use super::diffusion_windows::DiffusionWindows;
use super::displacement::Displacement;
use super::distributions::Distributions;
use super::equilibrium::{self, Equilibrium};
use super::free_flights::FreeFlights;
use super::in_gravity::{BETWEEN_COLLISIONS, InGravity};
use super::laws as law;
use super::mean_a2::{A2Sums, A2Weights, MeanA2, VelocityMoments, moments_of};
use super::metrics as metric;
use super::structure::Structure;
use super::tangent::Tangent;
use crate::metric::theory::{Expected, ExpectedValue};
use crate::metric::{Law, Measurements, NEEDS_ALL_STATES};
use crate::models::contract::{Extent, Observer};
use crate::models::flow_statistics::FlowStatistics;
use crate::models::hard_discs::DiscSizes;
use crate::models::relative_change;
use crate::models::series::Series;
use crate::models::snapshots::{Snapshots, StateStyle};
use crate::statistics::{AFTER_FEW_EVENTS, Blocking, Entries, Estimate, MissingError, Sum, mean};
use kinetoscope_manifest::model::{Boundary, PackingConfig};
use kinetoscope_recording::channels::{
    PackingCollisions, PackingPressure, PackingTemperature, PerCollision,
};
use kinetoscope_recording::error::ReadError;
use kinetoscope_recording::reader::{RecordedFrame, StateTable};
use std::f64::consts::PI;

/// Observer of one packing run.
#[derive(Clone, Debug, Default)]
pub(crate) struct PackingRun {
    pub(crate) config: PackingConfig,
    /// Moments per frame.
    pub(crate) frames: Series<VelocityMoments>,
    /// Events and pair collisions per frame.
    pub(crate) pairs: Series<(f64, f64)>,
    /// Time, and pressure over that of an ideal gas since the start, per frame.
    pub(super) pressures: Series<(f64, f64)>,
    /// Moments per collision, if recorded.
    pub(crate) collisions: Series<VelocityMoments>,
    pub(crate) snapshots: Snapshots,
    pub(crate) structure: Structure,
    pub(crate) displacement: Displacement,
    pub(super) distributions: Distributions,
    pub(super) self_diffusion: Option<DiffusionWindows>,
    pub(super) tangent: Tangent,
    pub(super) free_flights: Option<FreeFlights>,
    a2: MeanA2,
    pub(super) gravity: InGravity,
    /// Homogeneity of cooling discs.
    flow: FlowStatistics,
    /// Time integral of sqrt(kT/m), and the time.
    thermal_speed: (Sum, Sum),
    /// Time and totals since the start, of the last frame with either.
    totals: Option<(f64, PackingCollisions, PackingPressure)>,
    pair_rate: Blocking,
    wall_rate: Blocking,
    /// Collision virial per twice the time integral of the energy.
    virial_rate: Blocking,
    pressure: Option<PackingPressure>,
    counts: Option<PackingCollisions>,
    /// Whether the recording has neither state nor single collisions of some frames.
    pub(super) lacks_states: bool,
}

/// Events per disc after which means begin: velocities forget their start within a few collisions per disc.
const SETTLING_EVENTS_PER_DISC: f64 = 5.0;
/// Pair collisions per disc over which the correlation of a2 decays to 1/e: 1.0 to 1.2 in runs of 50 and 100 discs with e = 0.9 at packing
/// fractions of 0.09 and 0.1.
const A2_CORRELATION_PAIRS_PER_DISC: f64 = 1.2;
/// Packing fraction up to which the displacements of neighbors are independent enough for the scatter of the discs to be the
/// error of their mean: at 0.54, the mean scatters twice as much.
const MAX_LOOSE_FRACTION: f64 = 0.45;
/// Why the density of pairs is not measured among obstacles.
const UNKNOWN_ROOM: &str = "obstacles take room, so that the density of pairs of points at random is not that of an empty box";
/// Discs per sampling interval: the structure is sampled once per n/32 frames, so that the cost per disc is bounded.
const DISCS_PER_SAMPLE: u64 = 32;

impl PackingRun {
    /// Creates an observer without frames.
    pub(crate) fn new(config: PackingConfig, snapshots: Snapshots) -> Self {
        let sides = [config.width.get(), config.height.get()];
        let periodic = config.boundary == Boundary::Periodic;
        let structure = Structure::new(config.radius.get(), sides, periodic);
        let Extent { walls, radius, .. } = super::extent(&config);
        let weights =
            if config.restitution.get() == 1.0 { A2Weights::Durations } else { A2Weights::Events };
        let settled_after = SETTLING_EVENTS_PER_DISC * f64::from(config.discs.get());
        let obstacle = config.obstacles.as_ref().map(|of| of.radius.get());
        let tangent = Tangent::new(obstacle, !periodic);
        let mut run = Self {
            config,
            snapshots: snapshots.with_style(StateStyle { walls, radius }),
            structure,
            displacement: Displacement::new(periodic.then_some(sides)),
            a2: MeanA2::new(weights, settled_after),
            pair_rate: Blocking::of(Entries::Intervals),
            wall_rate: Blocking::of(Entries::Intervals),
            tangent,
            virial_rate: Blocking::of(Entries::Intervals),
            ..Self::default()
        };
        // Cells with obstacles have less room for discs than others.
        let diameter =
            run.equal_radius().filter(|_| !run.has_obstacles()).map(|radius| 2.0 * radius);
        run.distributions = Distributions::new(run.discs(), sides, diameter);
        run
    }

    pub(super) fn discs(&self) -> f64 {
        f64::from(self.config.discs.get())
    }

    pub(super) fn is_elastic(&self) -> bool {
        self.config.restitution.get() == 1.0
    }

    pub(super) fn is_settled(&self, events: f64) -> bool {
        events >= SETTLING_EVENTS_PER_DISC * self.discs()
    }

    /// Adds recorded collisions.
    fn add_collisions(&mut self, batch: &PerCollision) {
        let columns =
            batch.event.iter().zip(&batch.time).zip(&batch.mean_square_velocity).zip(&batch.a2);
        for (((&event, &time), &mean_square), &a2) in columns {
            let temperature = mean_square / 2.0;
            let moments = VelocityMoments { events: event as f64, time, temperature, a2 };
            self.a2.add_collision(moments);
            self.collisions.add(moments);
        }
    }

    /// Mean of a2, exact between frames. That of cooling discs has an error if no flow can grow in their box.
    fn mean_a2(&self) -> Option<Estimate> {
        if self.is_elastic() {
            return self.a2.estimate();
        }
        let counts = self.counts.as_ref();
        let events = self.frames.last().map_or(0.0, |last| last.events);
        let pairs = counts.map_or(0.0, |counts| counts.pair_collisions as f64);
        // Wall collisions do not change speeds.
        let correlation = A2_CORRELATION_PAIRS_PER_DISC * self.discs() * events / pairs;
        let is_stable = self.stays_homogeneous();
        self.a2.estimate_with_correlation(correlation).map(|mean| match is_stable {
            true => mean,
            false => mean.without_error(MissingError::DependsOnStart),
        })
    }

    fn add_moments(&mut self, moments: VelocityMoments) {
        if let Some(before) = self.frames.last() {
            let step = moments.time - before.time;
            let speed = |moments: &VelocityMoments| moments.temperature.sqrt();
            let mean = law::mean_while_cooling(speed(before), speed(&moments));
            self.thermal_speed.0.add(mean * step);
            self.thermal_speed.1.add(step);
        }
        self.frames.add(moments);
    }

    fn add_totals(&mut self, time: f64, counts: &PackingCollisions, pressure: &PackingPressure) {
        let now = (time, counts.clone(), pressure.clone());
        let Some((earlier, before, before_pressure)) = self.totals.replace(now) else { return };
        let (discs, duration) = (self.discs(), time - earlier);
        let pairs = counts.pair_collisions as f64 - before.pair_collisions as f64;
        self.pair_rate.add_amount(2.0 * pairs / discs, duration);
        let walls = counts.wall_collisions as f64 - before.wall_collisions as f64;
        self.wall_rate.add_amount(walls / discs, duration);
        let virial = pressure.collision_virial_sum - before_pressure.collision_virial_sum;
        let energy =
            pressure.kinetic_energy_time_integral - before_pressure.kinetic_energy_time_integral;
        self.virial_rate.add_amount(virial, 2.0 * energy);
    }

    /// A rate with its blocking error, for the kinetic energy of this run.
    fn rate(&self, rate: &Blocking) -> Option<Estimate> {
        let estimate = rate.estimate()?;
        // The rate of cooling discs drifts, so the scatter of its blocks is not a statistical error.
        let drifts = !self.is_elastic() || self.falls();
        Some(if drifts { estimate.without_error(MissingError::Drifting) } else { estimate })
    }

    /// The size distribution from the manifest or else from the last state.
    fn known_sizes(&self) -> Option<DiscSizes> {
        let given = self.equal_radius().map(|_| equilibrium::sizes(&self.config));
        given.or_else(|| self.sizes_of(self.snapshots.last()?))
    }

    /// Equilibrium theory; `None` where it has no value. That of cooling discs applies while they neither flow nor cluster.
    pub(super) fn equilibrium(&self) -> Option<Equilibrium> {
        let sizes = self.known_sizes().filter(|_| !self.falls())?;
        let found = if self.has_walls() {
            equilibrium::equilibrium(&self.config, sizes)?
        } else {
            equilibrium::periodic_equilibrium(&self.config, sizes)?
        };
        let uniform = if self.is_elastic() { None } else { self.flow.violation() };
        let violation = self.outside_fluid().or(uniform).or(found.violation);
        Some(Equilibrium { violation, ..found })
    }

    /// Selects the law for equal discs or that for several sizes.
    pub(super) fn law_of_sizes(&self, one: Law, several: Law) -> Law {
        let is_one = self.config.radius_half_width.get() == 0.0;
        if is_one { one } else { several }
    }

    /// The size distribution of a state with radii.
    fn sizes_of(&self, state: &StateTable) -> Option<DiscSizes> {
        let radii: Vec<f64> = state.column("radius")?.collect();
        let mean = mean(&radii)?;
        let square = radii.iter().map(|radius| radius * radius).sum::<f64>();
        Some(DiscSizes {
            packing_fraction: PI * square / (self.config.width.get() * self.config.height.get()),
            mean_radius: mean,
            squared_mean_over_mean_square: mean * mean / (square / radii.len() as f64),
        })
    }

    /// Packing fraction from the manifest or else from the state.
    pub(crate) fn packing_fraction(&self) -> Option<f64> {
        let given = self.equal_radius().map(|_| equilibrium::packing_fraction(&self.config));
        given.or_else(|| Some(self.sizes_of(self.snapshots.last()?)?.packing_fraction))
    }

    /// Time average of sqrt(kT/m) between frames, kT/m = `<v^2>`/2.
    fn mean_thermal_speed(&self) -> Option<f64> {
        let (area, length) = (self.thermal_speed.0.value(), self.thermal_speed.1.value());
        (length > 0.0).then(|| area / length)
    }

    fn measure_temperature(&self, found: &mut Measurements) {
        let (Some(first), Some(last)) = (self.frames.first(), self.frames.last()) else { return };
        let restitution = self.config.restitution.get();
        let cooled = if self.falls() {
            None
        } else if self.is_elastic() {
            Some(1.0)
        } else {
            let pairs = self.counts.as_ref().map(|counts| counts.pair_collisions as f64);
            pairs.map(|pairs| law::cooling(restitution, pairs, self.config.discs.get()))
        };
        let expected = |factor: f64| cooled.map(|cooled| self.cooled(factor * cooled));
        found.add(metric::TEMPERATURE_INITIAL, first.temperature);
        let theory = expected(first.temperature);
        found.compare(metric::TEMPERATURE_FINAL, last.temperature, theory);
        let ratio = last.temperature / first.temperature;
        found.compare(metric::TEMPERATURE_RATIO, ratio, expected(1.0));
        found.add(metric::MEAN_SQUARE_VELOCITY_INITIAL, 2.0 * first.temperature);
        found.add(metric::MEAN_SQUARE_VELOCITY_FINAL, 2.0 * last.temperature);
        let drift = relative_change(last.temperature, first.temperature);
        found.compare(
            metric::ENERGY_DRIFT,
            drift,
            (self.is_elastic() && !self.falls()).then_some(0.0),
        );
        found.add(metric::A2_FINAL, last.a2);
        let (law, theory) = match (self.is_elastic(), self.keeps_momentum()) {
            (false, _) => {
                let value = law::a2_cooling(restitution);
                let accuracy = Some(0.003 + 0.1 * value.abs() + 1.0 / self.discs());
                let violation = self.outside_fluid().or_else(|| self.flow.violation());
                (law::A2_COOLING, Some(ExpectedValue { value, accuracy, violation }))
            }
            (true, false) => {
                (law::A2_FIXED_ENERGY, law::a2_at_fixed_energy(self.config.discs.get()).expected())
            }
            // Without walls and obstacles, the momentum is fixed as well.
            (true, true) => {
                let theory = (self.discs() > 1.0).then(|| -1.0 / self.discs());
                (law::A2_FIXED_MOMENTUM, theory.expected())
            }
        };
        let theory = theory
            .filter(|_| !self.falls())
            .map(|theory| ExpectedValue { violation: self.drift().or(theory.violation), ..theory });
        let lacks_collisions = self.lacks_states && !self.collisions.is_empty();
        match self.mean_a2() {
            _ if self.falls() => found.explain(metric::A2_MEAN, BETWEEN_COLLISIONS),
            _ if lacks_collisions => found.explain(metric::A2_MEAN, NEEDS_ALL_STATES),
            Some(mean) => found.compare_with(metric::A2_MEAN, mean, law, theory),
            None => found.explain(metric::A2_MEAN, AFTER_FEW_EVENTS),
        }
    }

    /// A theoretical value in proportion to the temperature of elastic or cooling discs.
    fn cooled(&self, value: f64) -> ExpectedValue {
        if self.is_elastic() {
            return ExpectedValue { value, accuracy: None, violation: None };
        }
        let pairs = self.counts.as_ref().map_or(0.0, |counts| counts.pair_collisions as f64);
        let (restitution, discs) = (self.config.restitution.get(), self.config.discs.get());
        let accuracy = Some(value * law::cooling_accuracy(restitution, pairs, discs));
        let violation = self.outside_fluid().or_else(|| self.flow.violation());
        ExpectedValue { value, accuracy, violation }
    }

    fn measure_collisions(&self, found: &mut Measurements) {
        if self.counts.is_none() {
            return;
        }
        let equilibrium = self.equilibrium();
        let thermal_speed = self.mean_thermal_speed();
        let of_equilibrium = |of: fn(&Equilibrium) -> f64| {
            let equilibrium = equilibrium?;
            Some(equilibrium.proportional(of(&equilibrium) * thermal_speed?))
        };
        if let Some(rate) = self.rate(&self.pair_rate) {
            let theory = of_equilibrium(|equilibrium| equilibrium.pair_rate);
            let enskog = self.law_of_sizes(law::COLLISION_RATE, law::COLLISION_RATE_OF_SIZES);
            let of_starts = self.with_scatter_of_starts(rate);
            found.compare_with(metric::COLLISION_RATE, of_starts, enskog, theory);
            if rate.value > 0.0 {
                let free_time = of_starts.inverse();
                let theory = theory.filter(|theory| theory.value > 0.0);
                let theory = theory
                    .zip(equilibrium)
                    .map(|(theory, equilibrium)| equilibrium.proportional(1.0 / theory.value));
                found.compare_with(metric::MEAN_FREE_TIME, free_time, enskog, theory);
            }
            if let (Some(equilibrium), Some(speed)) = (equilibrium, thermal_speed) {
                self.measure_contact_values(rate, equilibrium, speed, found);
            }
        }
        if self.has_walls() {
            let theory = of_equilibrium(|equilibrium| equilibrium.wall_collision_rate_per_disc);
            let rate = self.rate(&self.wall_rate).map(|rate| self.with_scatter_of_starts(rate));
            found.compare(metric::WALL_COLLISION_RATE, rate, theory);
        }
    }

    /// Contact value and compressibility factor derived from the collision rate.
    fn measure_contact_values(
        &self,
        rate: Estimate,
        equilibrium: Equilibrium,
        thermal_speed: f64,
        found: &mut Measurements,
    ) {
        let Some(sizes) = self.known_sizes() else { return };
        let speed = thermal_speed * equilibrium.approach;
        if !self.has_walls() {
            let density = self.discs() / (self.config.width.get() * self.config.height.get());
            let one = 2.0 * PI.sqrt() * density * 2.0 * sizes.mean_radius * speed;
            let theory = equilibrium.proportional(equilibrium.pair_rate * thermal_speed / one);
            let value = self.with_scatter_of_sizes(rate.times(1.0 / one));
            found.compare(metric::CONTACT_VALUE, value, theory);
        }
        let inelastic = (1.0 + self.config.restitution.get()) / 2.0;
        let excess = rate.times(inelastic * PI.sqrt() / 4.0 * sizes.collision_diameter() / speed);
        let theory = equilibrium.compressibility();
        let factor = self.with_scatter_of_sizes(excess).plus(1.0);
        found.compare(metric::COMPRESSIBILITY_BY_RATE, factor, theory);
    }

    fn measure_pressure(&self, found: &mut Measurements) {
        let end_time = self.totals.as_ref().map_or(0.0, |(time, ..)| *time);
        let Some(pressure) = self.pressure.as_ref().filter(|_| end_time > 0.0) else { return };
        let excess = self.rate(&self.virial_rate);
        let factor = excess.map(|excess| self.excess_with_scatter_of_starts(excess).plus(1.0));
        let theory = self.equilibrium().map(|of| of.compressibility());
        found.compare_with(metric::COMPRESSIBILITY, factor, self.law_of_compressibility(), theory);
        self.measure_reduced_pressure(excess, found);
        found.add(metric::PRESSURE_VIRIAL, pressure.virial);
        found.add(metric::PRESSURE_WALL, self.has_walls().then_some(pressure.wall));
    }

    /// The sampled structure, or that of the last frame if no frame was sampled.
    pub(crate) fn sampled_structure(&self) -> Structure {
        let mut structure = self.structure.clone();
        let samples = self.equal_radius().is_some();
        if let Some(state) = self.snapshots.last().filter(|_| samples && structure.frames() == 0) {
            structure.add_frame(state);
        }
        structure
    }

    fn measure_structure(&self, found: &mut Measurements) {
        if let Some([near, global, local]) = self.sampled_structure().estimates() {
            found.add(metric::PSI6_GLOBAL, global);
            found.add(metric::PSI6_LOCAL, local);
            match self.has_obstacles() {
                true => found.explain(metric::PAIR_CORRELATION, UNKNOWN_ROOM),
                false => found.add(metric::PAIR_CORRELATION, near),
            }
        } else if self.snapshots.last().is_some() && self.equal_radius().is_none() {
            for metric in [metric::PSI6_GLOBAL, metric::PSI6_LOCAL, metric::PAIR_CORRELATION] {
                found.explain(
                    metric,
                    "the discs have several radii, so no single distance defines neighbors",
                );
            }
        }
        let displacement = self.displacement.last_mean_square();
        let is_loose = self.packing_fraction().is_some_and(|found| found <= MAX_LOOSE_FRACTION);
        // Cooling discs flow together, so that their mean scatters more from seed to seed than independent discs would.
        let moves_alone = is_loose && (self.is_elastic() || self.stays_homogeneous());
        let displacement = displacement.map(|moved| match moves_alone {
            true => moved.with_further_error(self.drift_scatter()),
            false => moved.without_error(MissingError::DependsOnStart),
        });
        if self.lacks_states && self.snapshots.last().is_some() {
            // Whether a disc has gone too far between two frames is not known.
            found.explain(metric::DISPLACEMENT, NEEDS_ALL_STATES);
        } else {
            found.add(metric::DISPLACEMENT, displacement);
        }
        let correlation = self.displacement.velocity_autocorrelation.last();
        found.add(metric::VELOCITY_AUTOCORRELATION, correlation.map(|(_, value)| *value));
        self.measure_self_diffusion(found);
    }
}

impl Observer for PackingRun {
    fn observe(&mut self, mut frame: RecordedFrame) -> Result<(), ReadError> {
        let (time, events) = (frame.clock.time, frame.clock.step_or_event_count as f64);
        if !frame.is_complete() {
            self.lacks_states = true;
            self.flow.add_frame_without_state();
        }
        if let Some(batch) = frame.get::<PerCollision>()? {
            self.add_collisions(&batch);
        }
        let recorded = frame.get::<PackingTemperature>()?;
        if let Some(sums) = &recorded {
            let (integral, sum) = (sums.a2_time_integral, sums.a2_event_sum);
            self.a2.add_sums(A2Sums { events, time, integral, sum });
        }
        let recorded = recorded.map(|moments| (moments.temperature, moments.a2));
        let state = frame.take_state();
        self.add_recorded_collisions(&frame, state.as_ref())?;
        if let Some((temperature, a2)) = state.as_ref().and_then(moments_of).or(recorded) {
            self.add_moments(VelocityMoments { events, time, temperature, a2 });
        }
        if let Some(state) = state {
            let stride = u64::from(self.config.discs.get()).div_ceil(DISCS_PER_SAMPLE);
            if self.equal_radius().is_some()
                && self.is_settled(events)
                && frame.clock.frame.is_multiple_of(stride)
            {
                self.structure.add_frame(&state);
            }
            if self.equal_radius().is_some() && self.is_settled(events) {
                self.structure.add_waves(&state);
            }
            if !self.is_elastic() {
                let sides = [self.config.width.get(), self.config.height.get()];
                self.flow.add_state(&state, sides.map(|side| -side / 2.0), sides);
            }
            self.displacement.add_frame(time, &state);
            self.gravity.add_state(&self.config, time, &state);
            if self.is_settled(events) {
                self.distributions.add_frame(&state);
                self.add_to_self_diffusion(time, &state);
            }
            self.snapshots.add_state(&frame, state);
        }
        let counts = frame.get::<PackingCollisions>()?;
        let pressure = frame.get::<PackingPressure>()?;
        if counts.is_some() || pressure.is_some() {
            let none = (PackingCollisions::default(), PackingPressure::default());
            let (counts, pressure) =
                (counts.as_ref().unwrap_or(&none.0), pressure.as_ref().unwrap_or(&none.1));
            self.add_totals(time, counts, pressure);
        }
        if let Some(counts) = counts {
            self.pairs.add((events, counts.pair_collisions as f64));
            self.counts = Some(counts);
        }
        if let Some(sums) = pressure.as_ref().filter(|sums| sums.kinetic_energy_time_integral > 0.0)
        {
            let twice_energy = 2.0 * sums.kinetic_energy_time_integral;
            self.pressures.add((time, 1.0 + sums.collision_virial_sum / twice_energy));
        }
        self.gravity.add_energy(frame.get()?);
        self.pressure = pressure.or(self.pressure.take());
        self.snapshots.keep_scenes(frame);
        Ok(())
    }

    fn measure(&self, found: &mut Measurements) {
        self.measure_temperature(found);
        self.measure_collisions(found);
        self.measure_pressure(found);
        let is_given = self.equal_radius().is_some();
        let fraction = self.packing_fraction().map(|fraction| match is_given {
            true => Estimate::set_by_manifest(fraction),
            false => Estimate::new(fraction, self.scatter_of_area().map(|of| of * fraction)),
        });
        found.add(metric::PACKING_FRACTION, fraction);
        self.measure_structure(found);
        self.measure_liquid(found);
        self.measure_free_flights(found);
        self.measure_lyapunov(found);
        self.measure_gravity(found);
    }
}
