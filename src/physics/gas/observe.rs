//! Messages and scenery of a frame.

use super::Gas;
use super::energy_balance::EnergyBalance;
use super::motion::{Particle, dot};
use super::pressure::{
    SpeedMoments, ideal_gas_pressure, kinetic_pressure, measured_pressure, temperature_of,
};
use super::speed_distribution::histogram;
use super::state::Substance;
use crate::event_record::EventRecord;
use crate::model::Model;
use crate::sum::CompensatedSum;
use kinetoscope_manifest::model::TemperatureDefinition;
use kinetoscope_recording::channels::{
    GasCollisions, GasEnergyBalance, GasEvents, GasInvariants, GasPressure, GasSpeeds,
    GasTemperature,
};
use kinetoscope_recording::frame::Frame;
use kinetoscope_recording::scenery::{DrawnRadius, Scenery, Wall};
use std::f64::consts::TAU;

/// Distance from the center over the radius above which a particle is outside: a position on the wall is known only to rounding.
const OUTSIDE: f64 = 1.0 + 1e-9;

/// Radius of a drawn point over the radius of the container.
const DRAWN_RADIUS_OVER_RADIUS: f64 = 0.012;

/// Maximum number of particles that are drawn with arrows: more arrows would hide one another.
const MAX_ARROWS: usize = 1000;

impl Gas {
    /// Fills a frame with state, messages and log.
    pub(super) fn fill(&self, frame: &mut Frame) {
        self.push_particles(frame);
        let moments = self.moments();
        frame.push(&self.pressure(&moments));
        frame.push(&self.temperature(&moments));
        frame.push(&self.invariants());
        let ratios = self.state.substance.mass_ratios.iter();
        let particles = self.state.particles.iter().zip(ratios).enumerate();
        let reduced = particles
            .filter(|(id, _)| self.is_inside(*id))
            .map(|(_, (particle, ratio))| ratio.sqrt() * particle.speed());
        let mean_square = moments.reduced_mean_square;
        let speeds = histogram(reduced, self.initial_speeds, self.speed_range_top, mean_square);
        frame.push(&self.energy_balance(&speeds));
        frame.push(&self.collisions());
        frame.push(&speeds);
        if let Some(events) = self.scheme.events() {
            frame.push(&self.events_message(events));
        }
        if self.has_moving_wall() || self.scheme.partition_m().is_some() {
            self.drawn_walls().into_iter().for_each(|wall| frame.push_wall(wall));
        }
        if self.time() == 0.0 {
            self.log_start(&moments, frame);
        }
        self.log_losses(frame);
    }

    /// The message of `/events`.
    fn events_message(&self, events: &EventRecord) -> GasEvents {
        let EventRecord { event, time, discs, impulse, normal } = events.clone();
        let mass_kg = self.state.substance.mass_kg;
        let in_n_s = |column: Vec<f64>| column.into_iter().map(|part| mass_kg * part).collect();
        let ([first_id, second_id], [impulse_x_n_s, impulse_y_n_s]) = (discs, impulse.map(in_n_s));
        let [normal_x, normal_y] = normal;
        GasEvents {
            event,
            time_s: time,
            first_id,
            second_id,
            impulse_x_n_s,
            impulse_y_n_s,
            normal_x,
            normal_y,
        }
    }

    /// One row per particle, with its mass if there are several.
    fn push_particles(&self, frame: &mut Frame) {
        let [cx, cy] = self.state.container.center_m;
        let particles = self.state.particles.iter();
        let rows = particles.map(|now| (now.position, now.velocity));
        match self.masses_kg() {
            [_] => rows.for_each(|([x, y], [vx, vy])| frame.push_state(&[cx + x, cy + y, vx, vy])),
            masses => rows.zip(masses.iter().cycle()).for_each(|(([x, y], [vx, vy]), mass)| {
                frame.push_state(&[cx + x, cy + y, vx, vy, *mass]);
            }),
        }
    }

    /// The scenery at the current time.
    pub(super) fn draw(&self) -> Scenery {
        let ([x, y], radius) = (self.state.container.center_m, self.state.container.circle.radius);
        Scenery {
            walls: self.drawn_walls(),
            view: [[x - radius, y - radius], [x + radius, y + radius]],
            drawn_radius: DrawnRadius::Fixed(match self.scheme.center_limit_m() {
                Some(limit) => radius - limit,
                None => DRAWN_RADIUS_OVER_RADIUS * radius,
            }),
            speed_range_top: self.speed_range_top,
            speed_unit: "m/s",
            arrows: self.state.particles.len() <= MAX_ARROWS,
            force_range_top: None,
            trail: false,
            unused_fields: self.unused_fields(),
            names: Vec::new(),
            central_particle: None,
        }
    }

    /// Ratios of the pressure to a formula that does not apply: with a moving wall, the formula is that of the end of each frame's window;
    /// in gravity, the pressure depends on the height.
    fn unused_fields(&self) -> Vec<&'static str> {
        if self.has_moving_wall() || self.scheme.gravity_m_per_s2() > 0.0 {
            vec![
                "/pressure.pressure_over_mean_square_formula",
                "/pressure.window_pressure_over_mean_square_formula",
            ]
        } else {
            Vec::new()
        }
    }

    /// The wall at its current position, with its opening.
    fn drawn_wall(&self) -> Wall {
        let (center, radius) = (self.state.container.center_m, self.current_radius());
        match self.state.container.half_opening_rad {
            Some(half) => Wall::Arc { center, radius, angles_rad: [half, TAU - half] },
            None => Wall::Circle { center, radius },
        }
    }

    /// The wall, and the partition until it is removed.
    fn drawn_walls(&self) -> Vec<Wall> {
        let mut walls = vec![self.drawn_wall()];
        if let Some(x) = self.scheme.partition_m().filter(|_| self.scheme.is_partition_closed()) {
            let radius = self.state.container.circle.radius;
            let [cx, cy] = self.state.container.center_m;
            let half = ((radius - x) * (radius + x)).sqrt();
            walls.push(Wall::Segment { from: [cx + x, cy - half], to: [cx + x, cy + half] });
        }
        walls
    }

    fn has_moving_wall(&self) -> bool {
        self.state.container.circle.wall_speed != 0.0
    }

    /// Current radius of the container, m.
    fn current_radius(&self) -> f64 {
        self.state.container.circle.radius_at(self.time())
    }

    fn pressure(&self, moments: &SpeedMoments) -> GasPressure {
        let (count, radius) = (moments.count, self.current_radius());
        let Substance { mass_kg: mass, boltzmann_j_per_k, definition, .. } = self.state.substance;
        let by_formula = |mean| kinetic_pressure(count, mass, moments.squared_speed(mean), radius);
        let wall = &self.state.wall;
        let (time_s, opened_s) = (self.time(), wall.window_opened_s);
        let window_s = time_s - opened_s;
        // The radius changes at a constant rate, so its mean over a window is the radius at the middle of the window.
        let mean_radius = |from: f64| self.state.container.circle.radius_at((from + time_s) / 2.0);
        let window_impulse = mass * wall.window.impulse_per_mass.value();
        let impulse = mass * wall.total.impulse_per_mass.value();
        let since_start = measured_pressure(impulse, mean_radius(0.0), time_s);
        let in_window = measured_pressure(window_impulse, mean_radius(opened_s), window_s);
        let by_mean_square = by_formula(TemperatureDefinition::MeanSquare);
        // The ratio is not defined for a gas at rest.
        let over_formula =
            |pressure: f64| if by_mean_square > 0.0 { pressure / by_mean_square } else { f64::NAN };
        let temperature_k = self.temperature_k(moments, definition);
        GasPressure {
            measured_n_per_m: in_window,
            measured_since_start_n_per_m: since_start,
            mean_speed_formula_n_per_m: by_formula(TemperatureDefinition::MeanSpeed),
            mean_square_formula_n_per_m: by_mean_square,
            ideal_gas_n_per_m: ideal_gas_pressure(count, boltzmann_j_per_k, temperature_k, radius),
            // With a moving wall, the formula changes, and a mean since the start is not comparable with its present value.
            pressure_over_mean_square_formula: if self.has_moving_wall() {
                f64::NAN
            } else {
                over_formula(since_start)
            },
            wall_impulse_n_s: window_impulse,
            window_s,
            window_pressure_over_mean_square_formula: over_formula(in_window),
        }
    }

    fn collisions(&self) -> GasCollisions {
        let (wall, pairs) = (&self.state.wall, self.scheme.pair_tally());
        GasCollisions {
            wall_collisions: wall.total.collisions,
            wall_collisions_since_last_frame: wall.window.collisions,
            pair_collisions: pairs.collisions,
            pair_collisions_since_last_frame: pairs.window_collisions,
            pair_virial_sum_j_s: self.state.substance.mass_kg * pairs.virial.value(),
        }
    }

    fn temperature(&self, moments: &SpeedMoments) -> GasTemperature {
        GasTemperature {
            mean_speed_temperature_k: self.temperature_k(moments, TemperatureDefinition::MeanSpeed),
            mean_square_temperature_k: self
                .temperature_k(moments, TemperatureDefinition::MeanSquare),
            mean_speed_m_per_s: moments.mean_speed,
            mean_velocity_m_per_s: moments.mean_velocity,
            rms_speed_m_per_s: moments.mean_square.sqrt(),
        }
    }

    /// Temperature by a definition, K.
    pub(super) fn temperature_k(
        &self,
        moments: &SpeedMoments,
        definition: TemperatureDefinition,
    ) -> f64 {
        let Substance { mass_kg, boltzmann_j_per_k, .. } = self.state.substance;
        temperature_of(moments.squared_speed(definition), mass_kg, boltzmann_j_per_k)
    }

    fn invariants(&self) -> GasInvariants {
        let Substance { mass_kg: mass, mass_ratios, .. } = &self.state.substance;
        let mut squares = CompensatedSum::default();
        let mut angular_momentum = CompensatedSum::default();
        for (id, (now, ratio)) in self.state.particles.iter().zip(mass_ratios).enumerate() {
            if self.is_inside(id) {
                squares.add(ratio * dot(now.velocity, now.velocity));
                angular_momentum.add(ratio * now.angular_momentum_per_mass());
            }
        }
        let [speed_change, angular_momentum_change] = self.max_invariant_changes();
        GasInvariants {
            kinetic_j: mass * squares.value() / 2.0,
            angular_momentum_j_s: mass * angular_momentum.value(),
            max_speed_change_relative: speed_change,
            max_angular_momentum_change_relative: angular_momentum_change,
            particles_outside: self.particles_outside(),
        }
    }

    /// Maximum relative changes of |R v - u p|, which is R |v| for a wall at rest, and of p x v since the start of the paths. Zero if
    /// these quantities are not conserved.
    fn max_invariant_changes(&self) -> [f64; 2] {
        let (mut of_speed, mut of_angular_momentum) = (0.0, 0.0);
        if !self.scheme.conserves_invariants() {
            return [0.0, 0.0];
        }
        let (circle, time_s) = (self.state.container.circle, self.time());
        for (id, (now, first)) in self.state.particles.iter().zip(self.start.iter()).enumerate() {
            let speed_at_start = circle.scaled(first, self.start_s).speed();
            // The relative change is not defined for a particle at rest, which remains at rest.
            if speed_at_start > 0.0 && self.is_inside(id) {
                let speed = circle.scaled(now, time_s).speed();
                raise(&mut of_speed, (speed - speed_at_start).abs() / speed_at_start);
                let change = now.angular_momentum_per_mass() - first.angular_momentum_per_mass();
                raise(&mut of_angular_momentum, change.abs() / speed_at_start);
            }
        }
        [of_speed, of_angular_momentum]
    }

    /// Number of particles outside the wall, including those that the scheme has lost, without those that left through the opening.
    pub(super) fn particles_outside(&self) -> u64 {
        let limit = OUTSIDE * self.scheme.center_limit_m().unwrap_or_else(|| self.current_radius());
        let is_outside = |particle: Particle| {
            let [x, y] = particle.position;
            x * x + y * y > limit * limit
        };
        let lost = self.scheme.lost_particles();
        let outside = self.state.particles.iter().enumerate().filter(|(id, particle)| {
            self.is_inside(*id) && (lost.get(*id) == Some(&true) || is_outside(*particle))
        });
        outside.count() as u64
    }

    fn energy_balance(&self, speeds: &GasSpeeds) -> GasEnergyBalance {
        let (mass, circle) = (self.state.substance.mass_kg, self.state.container.circle);
        let moments = self.moments();
        let energy = moments.reduced_mean_square * moments.count / 2.0 + self.potential_energy();
        let EnergyBalance { at_start, rescaling, heat, escaped_energy, escaped } =
            self.state.energy_balance;
        let (heat, left, rescaling) = (heat.value(), escaped_energy.value(), rescaling.value());
        // Force on the gas times displacement of the wall. The added zero makes the work of a wall at rest +0.
        let work = -circle.wall_speed * self.state.wall.total.impulse_per_mass.value() + 0.0;
        let residual = energy - (at_start + work + heat + rescaling - left);
        let radius_m = self.current_radius();
        let growth = radius_m / circle.radius;
        let over_start = |value: f64| if at_start > 0.0 { value / at_start } else { 0.0 };
        GasEnergyBalance {
            wall_work_j: mass * work,
            wall_heat_j: mass * heat,
            rescaling_j: mass * rescaling,
            escaped_j: mass * left,
            residual_relative: over_start(residual),
            radius_m,
            particles_escaped: escaped,
            energy_times_area_over_initial: over_start(energy * growth * growth),
            relative_entropy: relative_entropy(speeds),
        }
    }
}

/// Relative entropy of the measured speeds with respect to the Maxwell distribution: the sum over the bins of p ln(p/q) - p + q, p
/// measured, q Maxwellian. It is never negative, also if some speeds are beyond the bins. For uniform directions, it equals
/// Boltzmann's H minus its minimum at the same energy.
fn relative_entropy(speeds: &GasSpeeds) -> f64 {
    let [first, second, ..] = speeds.speed_m_per_s[..] else { return 0.0 };
    let width = second - first;
    let mut sum = CompensatedSum::default();
    for (density, maxwell) in speeds.density.iter().zip(&speeds.maxwell) {
        sum.add(width * (maxwell - density));
        if *density > 0.0 && *maxwell > 0.0 {
            sum.add(width * density * libm::log(density / maxwell));
        }
    }
    sum.value()
}

fn raise(max: &mut f64, value: f64) {
    if value > *max {
        *max = value;
    }
}
