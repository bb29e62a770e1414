//! Observer of packing runs: temperature, a2, collision rates, pressure and structure.

use super::displacement::Displacement;
use super::laws as law;
use super::metrics as metric;
use super::structure::Structure;
use crate::metric::{Law, Measurements};
use crate::models::contract::Observer;
use crate::models::relative_change;
use crate::models::series::Series;
use crate::models::snapshots::{Snapshots, StateStyle};
use crate::plot::drawing;
use crate::statistics::{Blocking, Estimate, Sum, mean};
use kinetoscope_manifest::model::{Boundary, PackingConfig};
use kinetoscope_recording::channels::{
    PackingCollisions, PackingPressure, PackingTemperature, PerCollision,
};
use kinetoscope_recording::error::ReadError;
use kinetoscope_recording::reader::{RecordedFrame, StateTable};
use std::f64::consts::PI;

/// Velocity moments after an event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct VelocityMoments {
    /// Pair and wall collisions since the start.
    pub(crate) events: f64,
    /// Simulated time.
    pub(crate) time: f64,
    /// `<v^2>`/2 = kT/m.
    pub(crate) temperature: f64,
    /// `<v^4>` / (2 `<v^2>^2`) - 1.
    pub(crate) a2: f64,
}

/// Observer of one packing run.
#[derive(Clone, Debug, Default)]
pub(crate) struct PackingRun {
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
    /// Time and totals since the start, of the last frame with either.
    totals: Option<(f64, PackingCollisions, PackingPressure)>,
    pair_rate: Blocking,
    wall_rate: Blocking,
    /// Collision virial per twice the time integral of the energy.
    virial_rate: Blocking,
    pressure: Option<PackingPressure>,
    counts: Option<PackingCollisions>,
    /// Size distribution in the last state.
    sizes: Option<law::DiscSizes>,
}

/// Events per disc after which means begin: velocities forget their start within a few collisions per disc.
const SETTLING_EVENTS_PER_DISC: f64 = 5.0;
/// Discs per sampling interval: the structure is sampled once per n/32 frames, so that the cost per disc is bounded.
const DISCS_PER_SAMPLE: u64 = 32;

impl PackingRun {
    /// Creates an observer without frames.
    pub(crate) fn new(config: PackingConfig, snapshots: Snapshots) -> Self {
        let sides = [config.width.get(), config.height.get()];
        let periodic = config.boundary == Boundary::Periodic;
        let structure = Structure::new(config.radius.get(), sides, periodic);
        let half = sides.map(|side| side / 2.0);
        let walls = vec![drawing::rectangle([half.map(|side| -side), half])];
        let style = StateStyle { walls, radius: config.radius.get() };
        Self {
            config,
            snapshots: snapshots.with_style(style),
            structure,
            displacement: Displacement::new(periodic.then_some(sides)),
            ..Self::default()
        }
    }

    fn discs(&self) -> f64 {
        f64::from(self.config.discs.get())
    }

    fn is_elastic(&self) -> bool {
        self.config.restitution.get() == 1.0
    }

    fn is_settled(&self, events: f64) -> bool {
        events >= SETTLING_EVENTS_PER_DISC * self.discs()
    }

    /// Weight of a value of a2: its duration. For cooling discs, whose time scale grows without bound, it is the number
    /// of events.
    fn weight(&self, before: &VelocityMoments, after: &VelocityMoments) -> f64 {
        if self.is_elastic() { after.time - before.time } else { after.events - before.events }
    }

    /// Adds recorded collisions; a2 is constant from one collision to the next.
    fn add_collisions(&mut self, batch: &PerCollision) {
        let columns =
            batch.event.iter().zip(&batch.time).zip(&batch.mean_square_velocity).zip(&batch.a2);
        for (((&event, &time), &mean_square), &a2) in columns {
            let temperature = mean_square / 2.0;
            let moments = VelocityMoments { events: event as f64, time, temperature, a2 };
            if let Some(before) = self.last_of_collisions
                && self.is_settled(before.events)
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
            if self.is_settled(before.events) {
                self.a2_by_frames.add_weighted((before.a2 + moments.a2) / 2.0, step);
            }
            let speed = |moments: &VelocityMoments| moments.temperature.sqrt();
            let mean = mean_while_cooling(speed(before), speed(&moments));
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

    /// A rate with its blocking error.
    fn rate(&self, rate: &Blocking) -> Option<Estimate> {
        let estimate = rate.estimate()?;
        // The rate of cooling discs drifts, so the scatter of its blocks is not a statistical error.
        Some(if self.is_elastic() { estimate } else { Estimate::bare(estimate.value) })
    }

    fn has_walls(&self) -> bool {
        self.config.boundary == Boundary::Walls
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

    fn measure_temperature(&self, found: &mut Measurements) {
        let (Some(first), Some(last)) = (self.frames.first(), self.frames.last()) else { return };
        let restitution = self.config.restitution.get();
        let cooled = if self.is_elastic() {
            Some(1.0)
        } else {
            let pairs = self.counts.as_ref().map(|counts| counts.pair_collisions as f64);
            pairs.map(|pairs| law::cooling(restitution, pairs, self.config.discs.get()))
        };
        let theory = cooled.map(|cooled| cooled * first.temperature);
        found.add(metric::TEMPERATURE_INITIAL, first.temperature);
        found.compare(metric::TEMPERATURE_FINAL, last.temperature, theory);
        found.compare(metric::TEMPERATURE_RATIO, last.temperature / first.temperature, cooled);
        found.add(metric::MEAN_SQUARE_VELOCITY_INITIAL, 2.0 * first.temperature);
        found.add(metric::MEAN_SQUARE_VELOCITY_FINAL, 2.0 * last.temperature);
        let drift = relative_change(last.temperature, first.temperature);
        found.compare(metric::ENERGY_DRIFT, drift, self.is_elastic().then_some(0.0));
        found.add(metric::A2_FINAL, last.a2);
        let (law, theory) = match (self.is_elastic(), self.has_walls()) {
            (false, _) => (law::A2_COOLING, Some(law::a2_cooling(restitution))),
            (true, true) => {
                (law::A2_FIXED_ENERGY, Some(law::a2_at_fixed_energy(self.config.discs.get())))
            }
            // Without walls, the momentum is fixed as well.
            (true, false) => {
                (law::A2_FIXED_MOMENTUM, (self.discs() > 1.0).then(|| -1.0 / self.discs()))
            }
        };
        found.compare_with(metric::A2_MEAN, self.mean_a2(), law, theory);
    }

    fn measure_collisions(&self, found: &mut Measurements) {
        if self.counts.is_none() {
            return;
        }
        let equilibrium = self.equilibrium();
        let thermal_speed = self.mean_thermal_speed();
        let of_equilibrium = |of: fn(&law::Equilibrium) -> f64| {
            thermal_speed.and_then(|speed| Some(of(&equilibrium?) * speed))
        };
        if let Some(rate) = self.rate(&self.pair_rate) {
            let theory = of_equilibrium(|equilibrium| equilibrium.pair_rate);
            let enskog = self.law_of_sizes(law::COLLISION_RATE, law::COLLISION_RATE_OF_SIZES);
            found.compare_with(metric::COLLISION_RATE, rate, enskog, theory);
            if rate.value > 0.0 {
                let error = rate.standard_error.map(|error| error / (rate.value * rate.value));
                let free_time = Estimate::new(1.0 / rate.value, error);
                let theory = theory.filter(|theory| *theory > 0.0).map(|theory| 1.0 / theory);
                found.compare_with(metric::MEAN_FREE_TIME, free_time, enskog, theory);
            }
            if let (Some(equilibrium), Some(speed)) = (equilibrium, thermal_speed) {
                self.measure_contact_values(rate, equilibrium, speed, found);
            }
        }
        let theory = of_equilibrium(|equilibrium| equilibrium.wall_collision_rate_per_disc);
        found.compare(metric::WALL_COLLISION_RATE, self.rate(&self.wall_rate), theory);
    }

    /// Contact value and compressibility factor derived from the collision rate.
    fn measure_contact_values(
        &self,
        rate: Estimate,
        equilibrium: law::Equilibrium,
        thermal_speed: f64,
        found: &mut Measurements,
    ) {
        let Some(sizes) = self.known_sizes() else { return };
        let speed = thermal_speed * equilibrium.approach;
        if !self.has_walls() {
            let density = self.discs() / (self.config.width.get() * self.config.height.get());
            let one = 2.0 * PI.sqrt() * density * 2.0 * sizes.mean_radius * speed;
            let theory = equilibrium.pair_rate * thermal_speed / one;
            found.compare(metric::CONTACT_VALUE, rate.times(1.0 / one), theory);
        }
        let inelastic = (1.0 + self.config.restitution.get()) / 2.0;
        let excess = rate.times(inelastic * PI.sqrt() / 4.0 * sizes.collision_diameter() / speed);
        let theory = equilibrium.compressibility_factor;
        found.compare(metric::COMPRESSIBILITY_BY_RATE, excess.plus(1.0), theory);
    }

    fn measure_pressure(&self, found: &mut Measurements) {
        let end_time = self.totals.as_ref().map_or(0.0, |(time, ..)| *time);
        let Some(pressure) = self.pressure.as_ref().filter(|_| end_time > 0.0) else { return };
        let factor = self.rate(&self.virial_rate).map(|excess| excess.plus(1.0));
        let theory = self.equilibrium().map(|of| of.compressibility_factor);
        let henderson = self.law_of_sizes(law::COMPRESSIBILITY, law::COMPRESSIBILITY_OF_SIZES);
        found.compare_with(metric::COMPRESSIBILITY, factor, henderson, theory);
        found.add(metric::PRESSURE_VIRIAL, pressure.virial);
        found.add(metric::PRESSURE_WALL, pressure.wall);
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
            found.add(metric::PAIR_CORRELATION, near);
        }
        found.add(metric::DISPLACEMENT, self.displacement.last_mean_square());
        let correlation = self.displacement.velocity_autocorrelation.last();
        found.add(metric::VELOCITY_AUTOCORRELATION, correlation.map(|(_, value)| *value));
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
                && self.is_settled(events)
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
            let none = (PackingCollisions::default(), PackingPressure::default());
            let (counts, pressure) =
                (counts.as_ref().unwrap_or(&none.0), pressure.as_ref().unwrap_or(&none.1));
            self.add_totals(time, counts, pressure);
        }
        if let Some(counts) = counts {
            self.pairs.add((events, counts.pair_collisions as f64));
            self.counts = Some(counts);
        }
        self.pressure = pressure.or(self.pressure.take());
        self.snapshots.keep_scenes(frame);
        Ok(())
    }

    fn measure(&self, found: &mut Measurements) {
        self.measure_temperature(found);
        self.measure_collisions(found);
        self.measure_pressure(found);
        found.add(metric::PACKING_FRACTION, self.packing_fraction());
        self.measure_structure(found);
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
    let (vx, vy, count) = (state.index("vx")?, state.index("vy")?, state.rows() as f64);
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
