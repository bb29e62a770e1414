//! What a frame of a gas says.

use super::collisions::PairTally;
use super::motion::Particle;
use super::pressure::{
    SpeedMean, SpeedMoments, ideal_gas_pressure, kinetic_pressure, measured_pressure,
    temperature_of,
};
use super::speed_distribution::{SpeedLaw, histogram};
use super::{Gas, Propagator, numeric_range};
use crate::model::Model;
use crate::sum::CompensatedSum;
use kinetoscope_recording::channels::{GasCollisions, GasInvariants, GasPressure, GasTemperature};
use kinetoscope_recording::frame::{Frame, Level};
use kinetoscope_recording::scenery::{DrawnRadius, Scenery, Wall};
use std::f64::consts::TAU;

/// Distance from the center, over the radius, above which a particle is outside: a place on the wall is only known to rounding.
const OUTSIDE: f64 = 1.0 + 1e-9;

/// Largest distance a step, over the radius, at which the document's "many steps across" holds.
const LONGEST_STEP_OVER_RADIUS: f64 = 0.1;

/// Radius of a drawn point, over the container's.
const DRAWN_RADIUS_OVER_RADIUS: f64 = 0.012;

/// Particles above which arrows would only hide one another.
const MOST_ARROWS: usize = 1000;

impl Gas {
    pub(super) fn fill(&self, frame: &mut Frame) {
        let [cx, cy] = self.container.center_m;
        for Particle { position: [x, y], velocity: [vx, vy] } in self.particles.iter() {
            frame.push_state(&[cx + x, cy + y, vx, vy]);
        }
        let moments = self.moments();
        frame.push(&self.pressure(&moments));
        frame.push(&self.temperature(&moments));
        frame.push(&self.invariants());
        let ratios = self.substance.mass_ratios.iter();
        let inside = self.particles.iter().zip(ratios).enumerate();
        let reduced = inside
            .filter(|(id, _)| self.is_inside(*id))
            .map(|(_, (particle, ratio))| ratio.sqrt() * particle.speed());
        let mean_square = moments.reduced_mean_square;
        let speeds = histogram(reduced, self.speed_law, self.speed_range_top, mean_square);
        frame.push(&self.ledger(&speeds));
        frame.push(&self.collisions());
        frame.push(&speeds);
        if self.container.circle.wall_speed != 0.0 {
            frame.push_wall(self.drawn_wall());
        }
        if self.time() == 0.0 {
            self.log_start(&moments, frame);
        }
        self.log_losses(frame);
    }

    pub(super) fn draw(&self) -> Scenery {
        let ([x, y], radius) = (self.container.center_m, self.container.circle.radius);
        Scenery {
            walls: vec![self.drawn_wall()],
            view: [[x - radius, y - radius], [x + radius, y + radius]],
            drawn_radius: DrawnRadius::Fixed(match &self.propagator {
                Propagator::Colliding { discs, .. } => radius - discs.reach_m(),
                _ => DRAWN_RADIUS_OVER_RADIUS * radius,
            }),
            speed_range_top: self.speed_range_top,
            speed_unit: "m/s",
            arrows: self.particles.len() <= MOST_ARROWS,
            force_range_top: None,
            trail: false,
        }
    }

    /// The wall where it is now, with its opening.
    fn drawn_wall(&self) -> Wall {
        let (center, radius) = (self.container.center_m, self.radius_now());
        match self.half_opening() {
            Some(half) => Wall::Arc { center, radius, angles_rad: [half, TAU - half] },
            None => Wall::Circle { center, radius },
        }
    }

    fn pressure(&self, moments: &SpeedMoments) -> GasPressure {
        let (count, radius) = (moments.count, self.radius_now());
        let (mass, boltzmann) = (self.substance.mass_kg, self.substance.boltzmann_j_per_k);
        let by_formula = |mean| kinetic_pressure(count, mass, moments.squared_speed(mean), radius);
        let (time_s, opened_s) = (self.time(), self.wall.window_opened_s);
        let window_s = time_s - opened_s;
        // Radii change evenly: the mean over a window is that at its middle.
        let mean_radius = |from: f64| self.container.circle.radius_at((from + time_s) / 2.0);
        let window_impulse = mass * self.wall.window.impulse_per_mass.value();
        let impulse = mass * self.wall.total.impulse_per_mass.value();
        let since_start = measured_pressure(impulse, mean_radius(0.0), time_s);
        let in_window = measured_pressure(window_impulse, mean_radius(opened_s), window_s);
        let by_mean_square = by_formula(SpeedMean::MeanSquare);
        // A gas at rest has no pressure to compare with.
        let over_ideal =
            |pressure: f64| if by_mean_square > 0.0 { pressure / by_mean_square } else { 0.0 };
        GasPressure {
            measured_n_per_m: in_window,
            measured_since_start_n_per_m: since_start,
            mean_speed_formula_n_per_m: by_formula(SpeedMean::MeanSpeed),
            mean_square_formula_n_per_m: by_mean_square,
            ideal_gas_n_per_m: ideal_gas_pressure(
                count,
                boltzmann,
                self.kelvin(moments, self.substance.definition),
                radius,
            ),
            pressure_over_ideal: over_ideal(since_start),
            wall_impulse_n_s: window_impulse,
            window_s,
            window_pressure_over_ideal: over_ideal(in_window),
        }
    }

    fn collisions(&self) -> GasCollisions {
        let pairs = match &self.propagator {
            Propagator::Colliding { discs, .. } => *discs.tally(),
            _ => PairTally::default(),
        };
        GasCollisions {
            wall: self.wall.total.hits,
            wall_since_last_frame: self.wall.window.hits,
            pair: pairs.collisions,
            pair_since_last_frame: pairs.window,
            pair_virial_j_s: self.substance.mass_kg * pairs.virial.value(),
        }
    }

    fn temperature(&self, moments: &SpeedMoments) -> GasTemperature {
        GasTemperature {
            mean_speed_temperature_k: self.kelvin(moments, SpeedMean::MeanSpeed),
            mean_square_temperature_k: self.kelvin(moments, SpeedMean::MeanSquare),
            mean_speed_m_per_s: moments.mean_speed,
            mean_velocity_m_per_s: moments.mean_velocity,
            rms_speed_m_per_s: moments.mean_square.sqrt(),
        }
    }

    fn kelvin(&self, moments: &SpeedMoments, definition: SpeedMean) -> f64 {
        let squared_speed = moments.squared_speed(definition);
        temperature_of(squared_speed, self.substance.mass_kg, self.substance.boltzmann_j_per_k)
    }

    fn invariants(&self) -> GasInvariants {
        let mass = self.substance.mass_kg;
        let mut squares = CompensatedSum::default();
        let mut angular_momentum = CompensatedSum::default();
        for (id, (now, ratio)) in self.particles.iter().zip(&self.substance.mass_ratios).enumerate()
        {
            if self.is_inside(id) {
                squares.add(ratio * super::motion::dot(now.velocity, now.velocity));
                angular_momentum.add(ratio * now.angular_momentum_per_mass());
            }
        }
        let [speed_change, angular_momentum_change] = self.largest_changes();
        GasInvariants {
            kinetic_j: mass * squares.value() / 2.0,
            angular_momentum_j_s: mass * angular_momentum.value(),
            largest_speed_change_relative: speed_change,
            largest_angular_momentum_change_relative: angular_momentum_change,
            particles_outside: self.particles_outside(),
        }
    }

    /// Largest changes of |R v - u p|, which is R |v| while the wall rests, and of p x v since the paths began; zero where the wall
    /// or collisions change both.
    fn largest_changes(&self) -> [f64; 2] {
        let (mut of_speed, mut of_angular_momentum) = (0.0, 0.0);
        match &self.propagator {
            Propagator::HitByHit { law, .. } if law.thermal.is_some() => return [0.0, 0.0],
            Propagator::Colliding { .. } => return [0.0, 0.0],
            _ => {}
        }
        let circle = self.container.circle;
        for (id, (now, first)) in self.particles.iter().zip(self.start.iter()).enumerate() {
            let speed_at_start = circle.scaled(first, self.start_s).speed();
            // A particle at rest stays at rest: it has no relative change.
            if speed_at_start > 0.0 && self.is_inside(id) {
                let speed = circle.scaled(now, self.time()).speed();
                raise(&mut of_speed, (speed - speed_at_start).abs() / speed_at_start);
                let change = now.angular_momentum_per_mass() - first.angular_momentum_per_mass();
                raise(&mut of_angular_momentum, change.abs() / speed_at_start);
            }
        }
        [of_speed, of_angular_momentum]
    }

    /// Particles outside the wall, those that a 0/0 lost among them.
    pub(super) fn particles_outside(&self) -> u64 {
        let limit = OUTSIDE
            * match &self.propagator {
                Propagator::Colliding { discs, .. } => discs.reach_m(),
                _ => self.radius_now(),
            };
        let is_outside = |particle: Particle| {
            let [x, y] = particle.position;
            x * x + y * y > limit * limit
        };
        let count = match &self.propagator {
            Propagator::Literal { frozen, .. } => self
                .particles
                .iter()
                .zip(frozen)
                .filter(|(particle, frozen)| **frozen || is_outside(*particle))
                .count(),
            Propagator::HitByHit { .. } if self.has_opening() => self
                .particles
                .iter()
                .enumerate()
                .filter(|(id, particle)| self.is_inside(*id) && is_outside(*particle))
                .count(),
            Propagator::Exact(_)
            | Propagator::HitByHit { .. }
            | Propagator::Colliding { .. }
            | Propagator::Stepped { .. } => {
                self.particles.iter().filter(|particle| is_outside(*particle)).count()
            }
        };
        count as u64
    }

    fn log_start(&self, moments: &SpeedMoments, frame: &mut Frame) {
        let ([cx, cy], radius) = (self.container.center_m, self.container.circle.radius);
        let mass = self.substance.mass_kg;
        let count = self.particles.len();
        frame.log(
            Level::Info,
            format!(
                "N = {count} particles of {mass:e} kg in a circle of radius r = {radius} m about ({cx}, {cy}) m"
            ),
        );
        frame.log(
            Level::Info,
            match self.speed_law {
                SpeedLaw::Uniform { max_speed } => format!(
                    "start: places uniform over the area, directions uniform, speeds uniform in [0, {}) m/s",
                    short(max_speed)
                ),
                SpeedLaw::Maxwell { .. } => {
                    "start: places uniform over the area, velocities by Maxwell's law".to_owned()
                }
                SpeedLaw::Equal => format!(
                    "start: places uniform over the area, directions uniform, all speeds {} m/s",
                    short(moments.mean_speed)
                ),
                SpeedLaw::Given => "start: places and velocities as written".to_owned(),
            },
        );
        frame.log(Level::Info, self.temperature_in_words(moments));
        frame.log(Level::Info, self.propagation_in_words());
        self.warn_of_long_steps(frame);
    }

    fn temperature_in_words(&self, moments: &SpeedMoments) -> String {
        let by_mean_speed = short(self.kelvin(moments, SpeedMean::MeanSpeed));
        let by_mean_square = short(self.kelvin(moments, SpeedMean::MeanSquare));
        let expected = match self.speed_law {
            SpeedLaw::Uniform { .. } => " (4/3 of it expected for uniform speeds)",
            SpeedLaw::Maxwell { .. } => " (4/pi of it expected for Maxwell's law)",
            SpeedLaw::Equal | SpeedLaw::Given => "",
        };
        match self.substance.definition {
            SpeedMean::MeanSpeed => format!(
                "temperature by the mean-speed definition: {by_mean_speed} K here is {by_mean_square} K by the mean square{expected}"
            ),
            SpeedMean::MeanSquare => format!(
                "temperature by the mean-square definition: {by_mean_square} K here is {by_mean_speed} K by the mean speed"
            ),
        }
    }

    fn propagation_in_words(&self) -> String {
        match &self.propagator {
            Propagator::Exact(_) => "propagation: closed form, exact at any time".to_owned(),
            Propagator::HitByHit { .. } => {
                "propagation: closed form from hit to hit, exact at any time".to_owned()
            }
            Propagator::Colliding { discs, .. } => format!(
                "propagation: discs of radius {} m from collision to collision, exact at any time",
                short(self.container.circle.radius - discs.reach_m())
            ),
            Propagator::Stepped { clock, .. } => format!(
                "propagation: {} steps of {} s, mirrored until each is used up",
                clock.total, clock.time_step_s
            ),
            Propagator::Literal { clock, .. } => format!(
                "propagation: {} steps of {} s as the document prints them, its defects included",
                clock.total, clock.time_step_s
            ),
        }
    }

    fn warn_of_long_steps(&self, frame: &mut Frame) {
        let (Propagator::Stepped { clock, .. } | Propagator::Literal { clock, .. }) =
            &self.propagator
        else {
            return;
        };
        let fastest = match self.speed_law {
            SpeedLaw::Uniform { max_speed } => max_speed,
            _ => numeric_range::fastest_speed(self.start.iter()),
        };
        let step_over_radius = fastest * clock.time_step_s / self.container.circle.radius;
        if step_over_radius > LONGEST_STEP_OVER_RADIUS {
            frame.log(
                Level::Warning,
                format!(
                    "v_max dt / r = {} is above {LONGEST_STEP_OVER_RADIUS}: a particle takes few steps across the container; \
                     time_step_s of at most {} would do",
                    short(step_over_radius),
                    short(LONGEST_STEP_OVER_RADIUS * self.container.circle.radius / fastest)
                ),
            );
        }
    }

    fn log_losses(&self, frame: &mut Frame) {
        let outside = self.particles_outside();
        if outside > self.outside_at_last_frame {
            frame.log(
                Level::Warning,
                format!(
                    "{outside} of {} particles are outside the wall or lost to 0/0, {} more than at the last frame",
                    self.particles.len(),
                    outside - self.outside_at_last_frame
                ),
            );
        }
    }
}

fn raise(largest: &mut f64, value: f64) {
    if value > *largest {
        *largest = value;
    }
}

/// Six digits, by an exponent where a plain number would be long.
fn short(value: f64) -> String {
    let rounded = format!("{value:.5e}");
    match rounded.parse::<f64>() {
        Ok(number) if number == 0.0 || (1e-3..1e7).contains(&number.abs()) => number.to_string(),
        Ok(number) => format!("{number:e}"),
        Err(_) => rounded,
    }
}
