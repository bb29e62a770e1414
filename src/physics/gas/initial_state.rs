//! Particles at the start: positions, velocities and their scale.

use super::initial_positions::draw_special;
use super::motion::Particle;
use super::pressure::{SpeedMoments, speed_at};
use super::speed_distribution::InitialSpeeds;
use super::state::Substance;
use crate::model::{Proceed, SetupError};
use crate::placement::{Rectangle, random_sequential_addition};
use crate::random::{Seed, Stream};
use crate::restart_state;
use kinetoscope_manifest::model::{
    Boundary, GasConfig, GasPlacement, GivenState, PositionDistribution, SpeedDistribution,
    SpeedScale,
};
use std::f64::consts::TAU;

/// Particles relative to the center, and the distribution of their speeds.
pub(super) struct InitialState {
    pub(super) particles: Vec<Particle>,
    pub(super) initial_speeds: InitialSpeeds,
}

/// Distance outside the wall over the radius at which a given point still counts as on the wall: the rounding of decimals.
const ON_WALL_TOLERANCE: f64 = 1e-12;

/// Prepares the start that the manifest describes, with velocities at their final scale.
pub(super) fn prepare(
    config: &GasConfig,
    seed: Seed,
    substance: &Substance,
    proceed: Proceed<'_>,
) -> Result<InitialState, SetupError> {
    let mut unscaled = match &config.placement {
        GasPlacement::Random => draw(config, seed, proceed)?,
        GasPlacement::Given(state) => from_rows(config, &given_rows(config, state)?)?,
        GasPlacement::Recorded(start) => {
            from_rows(config, &restart_state::rows(start, ["x", "y", "vx", "vy"])?)?
        }
    };
    if let (GasPlacement::Random, SpeedScale::Temperature(_)) =
        (&config.placement, config.speed_scale)
    {
        // At one temperature, particles of m times the mass have 1/sqrt(m) times the speed.
        for (particle, ratio) in unscaled.particles.iter_mut().zip(&substance.mass_ratios) {
            particle.velocity = particle.velocity.map(|component| component / ratio.sqrt());
        }
    }
    let factor = match config.speed_scale {
        SpeedScale::Given => 1.0,
        SpeedScale::MaxSpeed(speed) => speed.get(),
        SpeedScale::Temperature(temperature) => {
            factor_to_temperature(&unscaled.particles, temperature.get(), substance)?
        }
    };
    Ok(unscaled.scaled(factor))
}

/// Factor that scales the velocities to a temperature, K.
fn factor_to_temperature(
    particles: &[Particle],
    temperature_k: f64,
    substance: &Substance,
) -> Result<f64, SetupError> {
    let Substance { mass_kg, mass_ratios, boltzmann_j_per_k, definition, .. } = substance;
    let target = speed_at(temperature_k, *mass_kg, *boltzmann_j_per_k);
    let moments = SpeedMoments::of(particles.iter().copied().zip(mass_ratios.iter().copied()));
    let present = moments.squared_speed(*definition).sqrt();
    if target > 0.0 && !(present > 0.0 && present.is_finite()) {
        return Err(SetupError::new(
            format!(
                "velocities with a mean of {present} m/s cannot be scaled to {temperature_k} K"
            ),
            "give some particle a finite velocity, or set temperature_k = 0",
        ));
    }
    Ok(if target > 0.0 { target / present } else { 0.0 })
}

impl InitialState {
    /// Multiplies all velocities by a factor: step (d) of the gas exercise.
    fn scaled(mut self, factor: f64) -> Self {
        for particle in &mut self.particles {
            // The added zero makes both components of a particle at rest +0.
            particle.velocity = particle.velocity.map(|component| component * factor + 0.0);
        }
        self.initial_speeds = match self.initial_speeds {
            InitialSpeeds::Uniform { max_speed } => {
                InitialSpeeds::Uniform { max_speed: max_speed * factor }
            }
            InitialSpeeds::Maxwell { mean_square } => {
                InitialSpeeds::Maxwell { mean_square: mean_square * factor * factor }
            }
            InitialSpeeds::Equal => InitialSpeeds::Equal,
            InitialSpeeds::Given => InitialSpeeds::Given,
        };
        self
    }
}

/// Draws positions, directions and speeds; speeds are in units of their scale.
fn draw(config: &GasConfig, seed: Seed, proceed: Proceed<'_>) -> Result<InitialState, SetupError> {
    let initial_speeds = match (config.speed_distribution, config.speed_scale) {
        (_, SpeedScale::Given | SpeedScale::Temperature(_))
            if !config.speeds_m_per_s.is_empty() =>
        {
            InitialSpeeds::Given
        }
        (_, SpeedScale::Given) => {
            return Err(SetupError::new(
                "random speeds must have a scale",
                "give temperature_k or max_speed_m_per_s",
            ));
        }
        (SpeedDistribution::Maxwell, SpeedScale::MaxSpeed(_)) => {
            return Err(SetupError::new(
                "the Maxwell distribution has no upper bound",
                "give temperature_k instead of max_speed_m_per_s",
            ));
        }
        (SpeedDistribution::Uniform, _) => InitialSpeeds::Uniform { max_speed: 1.0 },
        (SpeedDistribution::Maxwell, _) => InitialSpeeds::Maxwell { mean_square: 2.0 },
        (SpeedDistribution::Equal, _) => InitialSpeeds::Equal,
    };
    let mut draws = seed.stream(Stream::Velocities);
    let listed = &config.speeds_m_per_s;
    let velocity = |id: usize| {
        if !listed.is_empty() {
            return from_polar(listed[id % listed.len()].get(), TAU * draws.uniform());
        }
        match config.speed_distribution {
            SpeedDistribution::Uniform => {
                let speed = draws.uniform();
                from_polar(speed, TAU * draws.uniform())
            }
            SpeedDistribution::Maxwell => draws.normal_pair(),
            SpeedDistribution::Equal => from_polar(1.0, TAU * draws.uniform()),
        }
    };
    let velocities: Vec<[f64; 2]> = (0..config.particles.get() as usize).map(velocity).collect();
    let particles = draw_positions(config, seed, proceed)?
        .into_iter()
        .zip(velocities)
        .map(|(position, velocity)| Particle { position, velocity })
        .collect();
    Ok(InitialState { particles, initial_speeds })
}

/// Draws positions relative to the center: those of points from their distribution, those of discs uniformly without overlap.
fn draw_positions(
    config: &GasConfig,
    seed: Seed,
    proceed: Proceed<'_>,
) -> Result<Vec<[f64; 2]>, SetupError> {
    let radius = config.radius_m.get();
    let mut draws = seed.stream(Stream::Positions);
    let count = config.particles.get();
    if let Some(positions) = draw_special(config, &mut draws)? {
        return Ok(positions);
    }
    let Some(disc_radius) = config.disc_radius_m.map(|radius| radius.get()) else {
        return Ok((0..count)
            .map(|_| {
                // The area inside a radius grows as its square, so the root of a uniform number is uniform over the area.
                let fraction = draws.uniform();
                let distance = radius
                    * match config.position_distribution {
                        PositionDistribution::UniformInRadius => fraction,
                        _ => fraction.sqrt(),
                    };
                from_polar(distance, TAU * draws.uniform())
            })
            .collect());
    };
    let square = Rectangle { min: [-radius, -radius], max: [radius, radius] };
    let center_limit = radius - disc_radius;
    let is_inside = |[x, y]: [f64; 2], _: f64| x * x + y * y <= center_limit * center_limit;
    let radii = vec![disc_radius; count as usize];
    let placed =
        random_sequential_addition(square, Boundary::Walls, &radii, &mut draws, is_inside, proceed);
    placed.map_err(|incomplete| {
        incomplete.into_error(|placed| {
            SetupError::new(
                format!("only {placed} of {count} discs fit without overlap"),
                "reduce particles or disc_radius_m, or increase radius_m",
            )
        })
    })
}

fn from_polar(length: f64, angle: f64) -> [f64; 2] {
    let (sin, cos) = libm::sincos(angle);
    [length * cos, length * sin]
}

/// Particles given in the manifest: x, y in m, vx, vy in m/s.
fn given_rows(config: &GasConfig, state: &GivenState) -> Result<Vec<[f64; 4]>, SetupError> {
    if let SpeedScale::MaxSpeed(_) = config.speed_scale {
        return Err(SetupError::new(
            "max_speed_m_per_s cannot be used with given velocities",
            "remove it, or rescale the velocities by temperature_k",
        ));
    }
    let (count, positions, velocities) =
        (config.particles.get() as usize, state.positions_m.len(), state.velocities_m_per_s.len());
    if positions != count || velocities != count {
        return Err(SetupError::new(
            format!(
                "expected {count} positions and velocities (particles = {count}), found {positions} positions and {velocities} velocities"
            ),
            "make the three numbers equal",
        ));
    }
    let rows = state.positions_m.iter().zip(&state.velocities_m_per_s);
    Ok(rows.map(|([x, y], [vx, vy])| [x, y, vx, vy].map(|value| value.get())).collect())
}

/// Particles of a given or recorded start; a point outside the wall is rejected.
fn from_rows(config: &GasConfig, rows: &[[f64; 4]]) -> Result<InitialState, SetupError> {
    let (radius, center) = (config.radius_m.get(), config.center_m.map(|axis| axis.get()));
    let is_given = matches!(config.placement, GasPlacement::Given(_));
    let key = if is_given { "placement" } else { "start_from" };
    let mut particles = Vec::with_capacity(rows.len());
    for (index, &[x, y, vx, vy]) in rows.iter().enumerate() {
        let mut position = [x - center[0], y - center[1]];
        let distance = libm::hypot(position[0], position[1]);
        if distance > radius * (1.0 + ON_WALL_TOLERANCE) {
            return Err(SetupError::new(
                format!(
                    "{key}: particle {index} (counted from 0) at [{x}, {y}] is {distance} m from the center, outside the wall at {radius} m"
                ),
                format!("move it inside or increase radius_m to {distance}"),
            ));
        }
        if distance > radius {
            position = position.map(|component| component * (radius / distance));
        }
        particles.push(Particle { position, velocity: [vx, vy] });
    }
    Ok(InitialState { particles, initial_speeds: InitialSpeeds::Given })
}
