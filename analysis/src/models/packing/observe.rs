//! Observer of packing runs: temperature, a2, collision rates, pressure and structure.

use super::displacement::Displacement;
use super::laws as law;
use super::metrics as metric;
use super::structure::Structure;
use crate::metric::Law;
use crate::metric::Measurement;
use crate::models::contract::Observer;
use crate::models::relative_change;
use crate::models::series::Series;
use crate::models::snapshots::{Snapshots, StateStyle};
use crate::plot::drawing;
use crate::statistics::{Blocking, Estimate, Sum, mean};
use kinetoscope_manifest::model::{Boundary, PackingConfig, PackingPlacement};
use kinetoscope_recording::channels::{
    PackingCollisions, PackingPressure, PackingTemperature, PerCollision,
};
use kinetoscope_recording::error::ReadError;
use kinetoscope_recording::reader::{RecordedFrame, StateTable};
use std::f64::consts::PI;

/// Velocity moments after an event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VelocityMoments {
    /// Pair and wall collisions since the start.
    pub events: f64,
    /// Simulated time.
    pub time: f64,
    /// `<v^2>`/2 = kT/m.
    pub temperature: f64,
    /// `<v^4>` / (2 `<v^2>^2`) - 1.
    pub a2: f64,
}

/// Totals since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct CollisionTotals {
    time: f64,
    pair: f64,
    wall: f64,
    energy_integral: f64,
    virial: f64,
}

/// Observer of one packing run.
#[derive(Clone, Debug)]
pub struct PackingRun {
    pub(crate) config: PackingConfig,
    /// Moments per frame.
    pub(crate) frames: Series<VelocityMoments>,
    /// Events and pair collisions per frame.
    pub(crate) pairs: Series<(f64, f64)>,
    /// Moments per collision, if recorded.
    pub(crate) collisions: Series<VelocityMoments>,
    pub(crate) snapshots: Snapshots,
    pub(crate) structure: Structure,
    pub(crate) displacement: Displacement,
    last_of_collisions: Option<VelocityMoments>,
    a2_by_collisions: Blocking,
    a2_by_frames: Blocking,
    /// Time integral of sqrt(kT/m), and the time.
    thermal_speed: (Sum, Sum),
    totals: Option<CollisionTotals>,
    rates: CollisionRates,
    pressure: Option<PackingPressure>,
    counts: Option<PackingCollisions>,
    /// Size distribution in the last state.
    sizes: Option<law::DiscSizes>,
}

/// Increments of totals between frames, relative to those of a second total.
#[derive(Clone, Debug, Default)]
struct CollisionRates {
    pair: Blocking,
    wall: Blocking,
    virial: Blocking,
}

/// Events per disc after which means begin: velocities forget their start within a few collisions per disc.
const SETTLING_EVENTS_PER_DISC: f64 = 5.0;
/// Discs per sampling interval: the structure is sampled once per n/32 frames, so that the cost per disc is bounded.
const DISCS_PER_SAMPLE: u64 = 32;

impl PackingRun {
    /// Creates an observer without frames.
    #[must_use]
    pub fn new(config: PackingConfig, snapshots: Snapshots) -> Self {
        let sides = [config.width.get(), config.height.get()];
        let periodic = config.boundary == Boundary::Periodic;
        let structure = Structure::new(config.radius.get(), sides, periodic);
        let half = sides.map(|side| side / 2.0);
        let walls = vec![drawing::rectangle([half.map(|side| -side), half])];
        let style = StateStyle { walls, radius: config.radius.get() };
        Self {
            config,
            frames: Series::default(),
            pairs: Series::default(),
            collisions: Series::default(),
            snapshots: snapshots.with_style(style),
            structure,
            displacement: Displacement::new(periodic.then_some(sides)),
            last_of_collisions: None,
            a2_by_collisions: Blocking::default(),
            a2_by_frames: Blocking::default(),
            thermal_speed: Default::default(),
            totals: None,
            rates: CollisionRates::default(),
            pressure: None,
            counts: None,
            sizes: None,
        }
    }

    fn discs(&self) -> f64 {
        f64::from(self.config.discs.get())
    }

    fn elastic(&self) -> bool {
        self.config.restitution.get() == 1.0
    }

    fn settled(&self, events: f64) -> bool {
        events >= SETTLING_EVENTS_PER_DISC * self.discs()
    }

    /// Weight of a value of a2: its duration. For cooling discs, whose time scale grows without bound, it is the number
    /// of events.
    fn weight(&self, before: &VelocityMoments, after: &VelocityMoments) -> f64 {
        if self.elastic() { after.time - before.time } else { after.events - before.events }
    }

    /// Adds recorded collisions; a2 is constant from one collision to the next.
    fn add_collisions(&mut self, batch: &PerCollision) {
        let columns =
            batch.event.iter().zip(&batch.time).zip(&batch.mean_square_velocity).zip(&batch.a2);
        for (((&event, &time), &mean_square), &a2) in columns {
            let temperature = mean_square / 2.0;
            let moments = VelocityMoments { events: event as f64, time, temperature, a2 };
            if let Some(before) = self.last_of_collisions
                && self.settled(before.events)
            {
                let weight = self.weight(&before, &moments);
                self.a2_by_collisions.add_weighted(before.a2, weight);
            }
            self.last_of_collisions = Some(moments);
            self.collisions.add(moments);
        }
    }

    /// Mean of a2: exact if collisions were recorded, else by the trapezoidal rule between frames.
    fn mean_a2(&self) -> Option<Estimate> {
        let exact = self.a2_by_collisions.entries() > 0;
        if exact { &self.a2_by_collisions } else { &self.a2_by_frames }.estimate()
    }

    fn add_moments(&mut self, moments: VelocityMoments) {
        if let Some(before) = self.frames.last() {
            let step = moments.time - before.time;
            if self.settled(before.events) {
                self.a2_by_frames.add_weighted((before.a2 + moments.a2) / 2.0, step);
            }
            let speed = |moments: &VelocityMoments| moments.temperature.sqrt();
            let mean = mean_while_cooling(speed(before), speed(&moments));
            self.thermal_speed.0.add(mean * step);
            self.thermal_speed.1.add(step);
        }
        self.frames.add(moments);
    }

    fn add_totals(&mut self, now: CollisionTotals) {
        if let Some(before) = self.totals.replace(now) {
            let discs = self.discs();
            let time = now.time - before.time;
            self.rates.pair.add_amount(2.0 * (now.pair - before.pair) / discs, time);
            self.rates.wall.add_amount((now.wall - before.wall) / discs, time);
            let energy = 2.0 * (now.energy_integral - before.energy_integral);
            self.rates.virial.add_amount(now.virial - before.virial, energy);
        }
    }

    /// A rate with its blocking error.
    fn rate(&self, rate: &Blocking) -> Option<Estimate> {
        let estimate = rate.estimate()?;
        // The rate of cooling discs drifts, so the scatter of its blocks is not a statistical error.
        Some(if self.elastic() { estimate } else { Estimate::bare(estimate.value) })
    }

    fn has_walls(&self) -> bool {
        self.config.boundary == Boundary::Walls
    }

    /// Whether the discs drift through a periodic box: their drawn velocities have a mean, and no wall takes it up. Theory
    /// is that of discs whose total momentum is zero.
    fn has_drift(&self) -> bool {
        let is_drawn = !matches!(
            self.config.placement,
            PackingPlacement::Given(_) | PackingPlacement::Recorded(_)
        );
        !self.has_walls() && is_drawn && !self.config.remove_mean_velocity
    }

    /// The radius of equal discs; `None` if radii differ or result from a compression.
    pub(crate) fn equal_radius(&self) -> Option<f64> {
        let is_given = self.config.radius_half_width.get() == 0.0
            && self.config.target_reduced_pressure.is_none();
        is_given.then(|| self.config.radius.get())
    }

    /// The size distribution from the manifest or else from the last state.
    fn known_sizes(&self) -> Option<law::DiscSizes> {
        self.equal_radius().map(|_| law::DiscSizes::equal(&self.config)).or(self.sizes)
    }

    /// Equilibrium theory; `None` outside its range of validity.
    fn equilibrium(&self) -> Option<law::Equilibrium> {
        let is_fluid = |sizes: &law::DiscSizes| sizes.packing_fraction <= law::DENSEST_FLUID;
        let sizes = self.known_sizes().filter(is_fluid)?;
        if self.has_walls() {
            return Some(law::equilibrium(&self.config, sizes));
        }
        if self.has_drift() {
            return None;
        }
        law::periodic_equilibrium(&self.config, sizes)
    }

    /// Selects the law for equal discs or that for several sizes.
    fn law_of_sizes(&self, one: Law, several: Law) -> Law {
        let is_one = self.config.radius_half_width.get() == 0.0;
        if is_one { one } else { several }
    }

    /// The size distribution of a state with radii.
    fn sizes_of(&self, state: &StateTable) -> Option<law::DiscSizes> {
        let radii: Vec<f64> = state.column("radius")?.collect();
        let mean = mean(&radii)?;
        let square = radii.iter().map(|radius| radius * radius).sum::<f64>();
        Some(law::DiscSizes {
            packing_fraction: PI * square / (self.config.width.get() * self.config.height.get()),
            mean_radius: mean,
            squared_mean_over_mean_square: mean * mean / (square / radii.len() as f64),
        })
    }

    /// Packing fraction from the manifest or else from the state.
    pub(crate) fn packing_fraction(&self) -> Option<f64> {
        let given = self.equal_radius().map(|_| law::packing_fraction(&self.config));
        given.or(self.sizes.map(|sizes| sizes.packing_fraction))
    }

    /// Time average of sqrt(kT/m) between frames, kT/m = `<v^2>`/2.
    fn mean_thermal_speed(&self) -> Option<f64> {
        let (area, length) = (self.thermal_speed.0.value(), self.thermal_speed.1.value());
        (length > 0.0).then(|| area / length)
    }

    fn temperature_measurements(&self, found: &mut Vec<Measurement>) {
        let (Some(first), Some(last)) = (self.frames.first(), self.frames.last()) else { return };
        let restitution = self.config.restitution.get();
        let pairs = self.counts.as_ref().map(|counts| counts.pair_collisions as f64);
        let cooled = match (self.elastic(), pairs) {
            (true, _) => Some(1.0),
            (false, _) if self.has_drift() => None,
            (false, pairs) => {
                pairs.map(|pairs| law::cooling(restitution, pairs, self.config.discs.get()))
            }
        };
        let ratio = last.temperature / first.temperature;
        let drift = relative_change(last.temperature, first.temperature);
        found.extend([
            Measurement::new(metric::TEMPERATURE_INITIAL, first.temperature),
            Measurement::new(metric::TEMPERATURE_FINAL, last.temperature)
                .against(cooled.map(|cooled| cooled * first.temperature)),
            Measurement::new(metric::TEMPERATURE_RATIO, ratio).against(cooled),
            Measurement::new(metric::MEAN_SQUARE_VELOCITY_INITIAL, 2.0 * first.temperature),
            Measurement::new(metric::MEAN_SQUARE_VELOCITY_FINAL, 2.0 * last.temperature),
            Measurement::new(metric::ENERGY_DRIFT, drift).against(self.elastic().then_some(0.0)),
            Measurement::new(metric::A2_FINAL, last.a2),
        ]);
        if let Some(a2) = self.mean_a2() {
            let found_a2 = Measurement::new(metric::A2_MEAN, a2);
            found.push(if self.elastic() {
                // Without walls, the momentum is fixed as well.
                if self.has_walls() {
                    let theory = law::a2_at_fixed_energy(self.config.discs.get());
                    found_a2.against_law(theory, law::A2_FIXED_ENERGY)
                } else {
                    let theory =
                        (self.discs() > 1.0 && !self.has_drift()).then(|| -1.0 / self.discs());
                    found_a2.against_law(theory, law::A2_FIXED_MOMENTUM)
                }
            } else {
                let theory = (!self.has_drift()).then(|| law::a2_cooling(restitution));
                found_a2.against_law(theory, law::A2_COOLING)
            });
        }
    }

    fn collision_measurements(&self, found: &mut Vec<Measurement>) {
        if self.counts.is_none() {
            return;
        }
        let equilibrium = self.equilibrium();
        let thermal_speed = self.mean_thermal_speed();
        if let Some(rate) = self.rate(&self.rates.pair) {
            let theory = thermal_speed.and_then(|speed| Some(equilibrium?.pair_rate * speed));
            let enskog = self.law_of_sizes(law::COLLISION_RATE, law::COLLISION_RATE_OF_SIZES);
            let measured = Measurement::new(metric::COLLISION_RATE, rate);
            found.push(measured.against_law(theory, enskog));
            if rate.value > 0.0 {
                let free_time = Estimate {
                    value: 1.0 / rate.value,
                    standard_error: rate
                        .standard_error
                        .map(|error| error / (rate.value * rate.value)),
                };
                let theory = theory.filter(|theory| *theory > 0.0).map(|theory| 1.0 / theory);
                let measured = Measurement::new(metric::MEAN_FREE_TIME, free_time);
                found.push(measured.against_law(theory, enskog));
            }
            if let (Some(equilibrium), Some(speed)) = (equilibrium, thermal_speed) {
                self.contact_measurements(rate, equilibrium, speed, found);
            }
        }
        if let Some(rate) = self.rate(&self.rates.wall) {
            let theory = thermal_speed
                .and_then(|speed| Some(equilibrium?.wall_collision_rate_per_disc * speed));
            found.push(Measurement::new(metric::WALL_RATE, rate).against(theory));
        }
    }

    /// Contact value and compressibility factor derived from the collision rate.
    fn contact_measurements(
        &self,
        rate: Estimate,
        equilibrium: law::Equilibrium,
        thermal_speed: f64,
        found: &mut Vec<Measurement>,
    ) {
        let Some(sizes) = self.known_sizes() else { return };
        let scaled = |factor: f64| Estimate {
            value: factor * rate.value,
            standard_error: rate.standard_error.map(|error| factor * error),
        };
        let speed = thermal_speed * equilibrium.approach;
        if !self.has_walls() {
            let density = self.discs() / (self.config.width.get() * self.config.height.get());
            let one = 2.0 * PI.sqrt() * density * 2.0 * sizes.mean_radius * speed;
            let theory = equilibrium.pair_rate * thermal_speed / one;
            found.push(Measurement::new(metric::CONTACT_VALUE, scaled(1.0 / one)).against(theory));
        }
        let share = (1.0 + self.config.restitution.get()) / 2.0;
        let excess = scaled(share * PI.sqrt() / 4.0 * sizes.collision_diameter() / speed);
        let z = Estimate { value: 1.0 + excess.value, ..excess };
        found.push(
            Measurement::new(metric::COMPRESSIBILITY_BY_RATE, z)
                .against(equilibrium.compressibility_factor),
        );
    }

    fn pressure_measurements(&self, found: &mut Vec<Measurement>) {
        let Some(pressure) = self.pressure.as_ref().filter(|_| self.end_time() > 0.0) else {
            return;
        };
        let equilibrium = self.equilibrium();
        if let Some(excess) = self.rate(&self.rates.virial) {
            let z = Estimate { value: 1.0 + excess.value, ..excess };
            let measured = Measurement::new(metric::COMPRESSIBILITY, z);
            let theory = equilibrium.map(|of| of.compressibility_factor);
            let henderson = self.law_of_sizes(law::COMPRESSIBILITY, law::COMPRESSIBILITY_OF_SIZES);
            found.push(measured.against_law(theory, henderson));
        }
        found.push(Measurement::new(metric::PRESSURE_VIRIAL, pressure.virial));
        found.push(Measurement::new(metric::PRESSURE_WALL, pressure.wall));
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

    fn structure_measurements(&self, found: &mut Vec<Measurement>) {
        if let Some([near, global, local]) = self.sampled_structure().estimates() {
            found.extend([
                Measurement::new(metric::PSI6_GLOBAL, global),
                Measurement::new(metric::PSI6_LOCAL, local),
                Measurement::new(metric::PAIR_CORRELATION, near),
            ]);
        }
        if let Some(displacement) = self.displacement.last_mean_square() {
            found.push(Measurement::new(metric::DISPLACEMENT, displacement));
        }
        if let Some((_, memory)) = self.displacement.velocity_autocorrelation.last() {
            found.push(Measurement::new(metric::VELOCITY_MEMORY, *memory));
        }
    }

    fn end_time(&self) -> f64 {
        self.totals.map_or(0.0, |totals| totals.time)
    }
}

impl Observer for PackingRun {
    fn observe(&mut self, mut frame: RecordedFrame) -> Result<(), ReadError> {
        let (time, events) = (frame.clock.time, frame.clock.step_or_event_count as f64);
        if let Some(batch) = frame.get::<PerCollision>()? {
            self.add_collisions(&batch);
        }
        let recorded =
            frame.get::<PackingTemperature>()?.map(|moments| (moments.temperature, moments.a2));
        let state = frame.take_state();
        if let Some((temperature, a2)) = state.as_ref().and_then(moments_of).or(recorded) {
            self.add_moments(VelocityMoments { events, time, temperature, a2 });
        }
        if let Some(state) = state {
            let stride = u64::from(self.config.discs.get()).div_ceil(DISCS_PER_SAMPLE);
            if self.equal_radius().is_some()
                && self.settled(events)
                && frame.clock.frame.is_multiple_of(stride)
            {
                self.structure.add_frame(&state);
            }
            self.displacement.add_frame(time, &state);
            self.sizes = self.sizes_of(&state).or(self.sizes);
            self.snapshots.add_state(&frame, state);
        }
        let counts = frame.get::<PackingCollisions>()?;
        let pressure = frame.get::<PackingPressure>()?;
        if counts.is_some() || pressure.is_some() {
            let count =
                |of: fn(&PackingCollisions) -> u64| counts.as_ref().map_or(0.0, |c| of(c) as f64);
            let amount = |of: fn(&PackingPressure) -> f64| pressure.as_ref().map_or(0.0, of);
            self.add_totals(CollisionTotals {
                time,
                pair: count(|counts| counts.pair_collisions),
                wall: count(|counts| counts.wall_collisions),
                energy_integral: amount(|pressure| pressure.kinetic_energy_time_integral),
                virial: amount(|pressure| pressure.collision_virial_sum),
            });
        }
        if let Some(counts) = counts {
            self.pairs.add((events, counts.pair_collisions as f64));
            self.counts = Some(counts);
        }
        self.pressure = pressure.or(self.pressure.take());
        self.snapshots.keep_scenes(frame);
        Ok(())
    }

    fn measurements(&self) -> Vec<Measurement> {
        let mut found = Vec::new();
        self.temperature_measurements(&mut found);
        self.collision_measurements(&mut found);
        self.pressure_measurements(&mut found);
        found.extend(
            self.packing_fraction()
                .map(|fraction| Measurement::new(metric::PACKING_FRACTION, fraction)),
        );
        self.structure_measurements(&mut found);
        found
    }
}

/// Time average of a speed between two values if its inverse grows linearly, as in Haff's law.
fn mean_while_cooling(before: f64, after: f64) -> f64 {
    if (before - after).abs() <= 1e-6 * before {
        return (before + after) / 2.0;
    }
    before * after * (before / after).ln() / (before - after)
}

/// `<v^2>` and a2 of a state; `None` without velocities.
fn moments_of(state: &StateTable) -> Option<(f64, f64)> {
    let index = |name: &str| state.columns().iter().position(|column| column == name);
    let (vx, vy, count) = (index("vx")?, index("vy")?, state.rows() as f64);
    let (mut squares, mut fourths) = (0.0, 0.0);
    for disc in 0..state.rows() {
        let row = state.row(disc);
        let square = row[vx] * row[vx] + row[vy] * row[vy];
        squares += square;
        fourths += square * square;
    }
    let mean_square = squares / count;
    let a2 = fourths / count / (2.0 * mean_square * mean_square) - 1.0;
    (count > 0.0).then_some((mean_square / 2.0, a2))
}
