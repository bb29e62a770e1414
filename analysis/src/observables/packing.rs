//! What is seen of a packing run: temperature, a2, collision rates and pressure.

use super::{Observer, Snapshot, relative_change};
use crate::figures::{self, Figures};
use crate::laws::packing as law;
use crate::measurement::Measurement;
use crate::statistics::{Blocking, Estimate, Sum, mean};
use kinetoscope_manifest::model::PackingConfig;
use kinetoscope_recording::channels::{
    PackingCollisions, PackingPressure, PackingTemperature, PerCollision,
};
use kinetoscope_recording::error::ReadError;
use kinetoscope_recording::reader::{RecordedFrame, StateTable};
use std::f64::consts::PI;

/// Moments of the velocities after an event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moments {
    /// Events, pair and wall, since the start.
    pub events: f64,
    /// Simulated time.
    pub time: f64,
    /// <v^2>.
    pub temperature: f64,
    /// <v^4> / (2 <v^2>^2) - 1.
    pub a2: f64,
}

/// Totals since the start at a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Totals {
    time: f64,
    pair: f64,
    wall: f64,
    energy_integral: f64,
    virial: f64,
}

/// A packing run while its frames go by.
#[derive(Clone, Debug)]
pub struct PackingRun {
    pub(crate) config: PackingConfig,
    /// By frames.
    pub(crate) frames: Vec<Moments>,
    /// Events and pair collisions, by frames.
    pub(crate) pairs: Vec<(f64, f64)>,
    /// By collisions where they were recorded, thinned out while they are many.
    pub(crate) collisions: Thinned,
    pub(crate) snapshot: Snapshot,
    last_of_collisions: Option<Moments>,
    a2: Blocking,
    totals: Vec<Totals>,
    pressure: Option<PackingPressure>,
    counts: Option<PackingCollisions>,
}

/// Velocities forget their start in a few collisions a disc: means begin after this many events a disc.
const SETTLING_EVENTS_PER_DISC: f64 = 5.0;

impl PackingRun {
    /// Nothing seen yet.
    #[must_use]
    pub fn new(config: PackingConfig) -> Self {
        Self {
            config,
            frames: Vec::new(),
            pairs: Vec::new(),
            collisions: Thinned::default(),
            snapshot: Snapshot::default(),
            last_of_collisions: None,
            a2: Blocking::default(),
            totals: Vec::new(),
            pressure: None,
            counts: None,
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

    /// What a value of a2 counts for: the time that it lasted; while discs cool, time stretches without end and events count.
    fn weight(&self, before: &Moments, after: &Moments) -> f64 {
        if self.elastic() { after.time - before.time } else { after.events - before.events }
    }

    /// a2 holds from one collision to the next.
    fn see_collisions(&mut self, batch: &PerCollision) {
        let columns = batch.event.iter().zip(&batch.time).zip(&batch.temperature).zip(&batch.a2);
        for (((&event, &time), &temperature), &a2) in columns {
            let moments = Moments { events: event as f64, time, temperature, a2 };
            if let Some(before) = self.last_of_collisions
                && self.settled(before.events)
            {
                let weight = self.weight(&before, &moments);
                self.a2.add_weighted(before.a2, weight);
            }
            self.last_of_collisions = Some(moments);
            self.collisions.add(moments);
        }
    }

    /// Mean of a2: exact where collisions were recorded, else by the trapezium rule between frames.
    fn mean_a2(&self) -> Option<Estimate> {
        if self.a2.entries() > 0 {
            return self.a2.estimate();
        }
        let mut blocking = Blocking::default();
        for pair in self.frames.windows(2) {
            if self.settled(pair[0].events) {
                blocking.add_weighted((pair[0].a2 + pair[1].a2) / 2.0, pair[1].time - pair[0].time);
            }
        }
        blocking.estimate()
    }

    /// A total's growth per growth of another total, with the error from blocks of frames.
    fn rate(
        &self,
        amount: impl Fn(&Totals) -> f64,
        length: impl Fn(&Totals) -> f64,
    ) -> Option<Estimate> {
        let mut blocking = Blocking::default();
        for pair in self.totals.windows(2) {
            blocking.add_amount(
                amount(&pair[1]) - amount(&pair[0]),
                length(&pair[1]) - length(&pair[0]),
            );
        }
        let estimate = blocking.estimate()?;
        // While the discs cool, the rate drifts: windows then differ for other reasons than chance.
        Some(if self.elastic() { estimate } else { Estimate::bare(estimate.value) })
    }

    /// Mean over time of sqrt(kT/m) between frames, kT/m = <v^2>/2.
    fn mean_thermal_speed(&self) -> Option<f64> {
        let (mut area, mut length) = (Sum::default(), Sum::default());
        for pair in self.frames.windows(2) {
            let step = pair[1].time - pair[0].time;
            let speed = |moments: &Moments| (moments.temperature / 2.0).sqrt();
            area.add(mean_while_cooling(speed(&pair[0]), speed(&pair[1])) * step);
            length.add(step);
        }
        (length.value() > 0.0).then(|| area.value() / length.value())
    }

    fn temperature_measurements(&self, found: &mut Vec<Measurement>) {
        let (Some(first), Some(last)) = (self.frames.first(), self.frames.last()) else { return };
        let restitution = self.config.restitution.get();
        let pairs = self.counts.as_ref().map(|counts| counts.pair as f64);
        let cooled = match (self.elastic(), pairs) {
            (true, _) => Some(1.0),
            (false, pairs) => {
                pairs.map(|pairs| law::cooling(restitution, pairs, self.config.discs.get()))
            }
        };
        let ratio = last.temperature / first.temperature;
        found.extend([
            Measurement::new("temperature.initial", "", first.temperature, "<v^2>, first frame"),
            Measurement::new("temperature.final", "", last.temperature, "<v^2>, last frame")
                .against(cooled.map(|cooled| cooled * first.temperature), law::COOLING),
            Measurement::new(
                "temperature.final_over_initial",
                "1",
                ratio,
                "<v^2>, last over first",
            )
            .against(cooled, law::COOLING),
            Measurement::new(
                "temperature.kinetic_final",
                "",
                last.temperature / 2.0,
                "<v^2>/2 = k_B T/m, last frame",
            ),
        ]);
        let drift = relative_change(last.temperature, first.temperature);
        let from = "kinetic energy, last frame against the first";
        found.push(
            Measurement::new("energy.drift_relative", "1", drift, from)
                .against(self.elastic().then_some(0.0), law::ELASTIC_ENERGY),
        );
        found.push(Measurement::new("a2.final", "1", last.a2, "<v^4>/(2 <v^2>^2) - 1, last frame"));
        if let Some(a2) = self.mean_a2() {
            let from = "mean over time (over events for alpha < 1) after 5 events a disc; error by blocking";
            let found_a2 = Measurement::new("a2.mean", "1", a2, from);
            found.push(if self.elastic() {
                let theory = law::a2_at_fixed_energy(self.config.discs.get());
                found_a2.against(theory, law::A2_FIXED_ENERGY)
            } else {
                found_a2.against(law::a2_cooling(restitution), law::A2_COOLING)
            });
        }
    }

    fn collision_measurements(&self, found: &mut Vec<Measurement>) {
        let equilibrium = law::equilibrium(&self.config);
        let thermal_speed = self.mean_thermal_speed();
        let discs = self.discs();
        let time = |totals: &Totals| totals.time;
        let pair =
            self.counts.is_some().then(|| self.rate(|totals| 2.0 * totals.pair / discs, time));
        if let Some(rate) = pair.flatten() {
            let from = "/collisions: pair collisions a disc and unit of time; error by blocking";
            found.push(Measurement::new("collision_rate", "", rate, from).against(
                thermal_speed.map(|speed| equilibrium.pair_rate * speed),
                law::COLLISION_RATE,
            ));
            if let Some(speed) = thermal_speed {
                let share = (1.0 + self.config.restitution.get()) / 2.0;
                let factor = share * PI.sqrt() / 4.0 * 2.0 * self.config.radius.get()
                    / (speed * law::fixed_energy_speed(discs));
                let z = Estimate {
                    value: 1.0 + factor * rate.value,
                    standard_error: rate.standard_error.map(|error| factor * error),
                };
                let from = "1 + (1 + alpha)/2 (sqrt(pi)/4) s w sqrt(m/kT) from the collision rate";
                found.push(
                    Measurement::new("compressibility_factor.by_rate", "1", z, from)
                        .against(equilibrium.compressibility_factor, law::VIRIAL_IDENTITY),
                );
            }
        }
        let wall = self.counts.is_some().then(|| self.rate(|totals| totals.wall / discs, time));
        if let Some(rate) = wall.flatten() {
            let from = "/collisions: wall collisions a disc and unit of time; error by blocking";
            found.push(
                Measurement::new("wall_rate", "", rate, from).against(
                    thermal_speed.map(|speed| equilibrium.wall_rate * speed),
                    law::WALL_RATE,
                ),
            );
        }
    }

    fn pressure_measurements(&self, found: &mut Vec<Measurement>) {
        let Some(pressure) = self.pressure.as_ref().filter(|_| self.end_time() > 0.0) else {
            return;
        };
        let equilibrium = law::equilibrium(&self.config);
        let excess = self.rate(|totals| totals.virial, |totals| 2.0 * totals.energy_integral);
        if let Some(excess) = excess {
            let z = Estimate { value: 1.0 + excess.value, ..excess };
            let from =
                "/pressure: P A/(N kT) by the pair virial since the start; error by blocking";
            found.push(
                Measurement::new("compressibility_factor", "1", z, from)
                    .against(equilibrium.compressibility_factor, law::COMPRESSIBILITY),
            );
        }
        let from = "/pressure: by the pair virial since the start";
        found.push(Measurement::new("pressure.virial", "", pressure.virial, from));
        let from = "/pressure: impulse on the walls since the start";
        found.push(Measurement::new("pressure.wall", "", pressure.wall, from));
    }

    fn end_time(&self) -> f64 {
        self.totals.last().map_or(0.0, |totals| totals.time)
    }
}

impl Observer for PackingRun {
    fn see(&mut self, frame: &RecordedFrame) -> Result<(), ReadError> {
        let (time, events) = (frame.clock.time, frame.clock.step_or_event_count as f64);
        if let Some(batch) = frame.get::<PerCollision>()? {
            self.see_collisions(&batch);
        }
        let told = frame.get::<PackingTemperature>()?.map(|told| (told.temperature, told.a2));
        let seen = frame.state().and_then(moments_of);
        if let Some((temperature, a2)) = seen.or(told) {
            self.frames.push(Moments { events, time, temperature, a2 });
        }
        if let Some(state) = frame.state() {
            self.snapshot.take(time, state, Some(self.config.radius.get()));
        }
        let counts = frame.get::<PackingCollisions>()?;
        let pressure = frame.get::<PackingPressure>()?;
        if counts.is_some() || pressure.is_some() {
            let count =
                |of: fn(&PackingCollisions) -> u64| counts.as_ref().map_or(0.0, |c| of(c) as f64);
            let amount = |of: fn(&PackingPressure) -> f64| pressure.as_ref().map_or(0.0, of);
            self.totals.push(Totals {
                time,
                pair: count(|counts| counts.pair),
                wall: count(|counts| counts.wall),
                energy_integral: amount(|pressure| pressure.kinetic_energy_time_integral),
                virial: amount(|pressure| pressure.collision_virial),
            });
        }
        if let Some(counts) = counts {
            self.pairs.push((events, counts.pair as f64));
            self.counts = Some(counts);
        }
        self.pressure = pressure.or(self.pressure.take());
        Ok(())
    }

    fn measurements(&self) -> Vec<Measurement> {
        let mut found = Vec::new();
        self.temperature_measurements(&mut found);
        self.collision_measurements(&mut found);
        self.pressure_measurements(&mut found);
        let fraction = law::packing_fraction(&self.config);
        found.push(Measurement::new("packing_fraction", "1", fraction, "n pi r^2 / (lx ly)"));
        found
    }

    fn figures(&self) -> Figures {
        figures::packing::figures(self)
    }
}

/// Mean over time of a speed between two values, where its inverse grows evenly as Haff's law has it.
fn mean_while_cooling(before: f64, after: f64) -> f64 {
    if (before - after).abs() <= 1e-6 * before {
        return (before + after) / 2.0;
    }
    before * after * (before / after).ln() / (before - after)
}

/// <v^2> and a2 of a state; `None` without velocities.
fn moments_of(state: &StateTable) -> Option<(f64, f64)> {
    let squares: Vec<f64> =
        state.column("vx")?.zip(state.column("vy")?).map(|(x, y)| x * x + y * y).collect();
    let fourths: Vec<f64> = squares.iter().map(|square| square * square).collect();
    let temperature = mean(&squares)?;
    Some((temperature, mean(&fourths)? / (2.0 * temperature * temperature) - 1.0))
}

/// A series that stays short: when it is full, every second entry goes, and from then on twice as few come in.
#[derive(Clone, Debug)]
pub struct Thinned {
    entries: Vec<Moments>,
    stride: u64,
    seen: u64,
}

impl Default for Thinned {
    fn default() -> Self {
        Self { entries: Vec::new(), stride: 1, seen: 0 }
    }
}

impl Thinned {
    const MOST: usize = 4096;

    fn add(&mut self, moments: Moments) {
        if self.seen.is_multiple_of(self.stride) {
            if self.entries.len() == Self::MOST {
                let mut index = 0;
                self.entries.retain(|_| {
                    index += 1;
                    index % 2 == 1
                });
                self.stride *= 2;
            }
            if self.seen.is_multiple_of(self.stride) {
                self.entries.push(moments);
            }
        }
        self.seen += 1;
    }

    /// What was kept.
    #[must_use]
    pub fn entries(&self) -> &[Moments] {
        &self.entries
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_series_is_thinned_evenly() {
        let mut thinned = Thinned::default();
        for event in 0..100_000 {
            let events = f64::from(event);
            thinned.add(Moments { events, time: 0.0, temperature: 0.0, a2: 0.0 });
        }
        let entries = thinned.entries();
        assert!((1024..=4096).contains(&entries.len()));
        let step = entries[1].events - entries[0].events;
        assert!(entries.windows(2).all(|pair| pair[1].events - pair[0].events == step));
    }
}
