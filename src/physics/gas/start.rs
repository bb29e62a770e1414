//! The particles at the start: places, speeds and their scale.

use super::motion::Particle;
use super::pressure::{SpeedMean, SpeedMoments, speed_at};
use super::speeds::SpeedLaw;
use crate::model::SetupError;
use crate::placement::{Rectangle, random_sequential_addition_where};
use crate::random::{Seed, Stream};
use crate::restart_state;
use kinetoscope_manifest::model::{
    GasConfig, GivenState, PlaceDistribution, Placement, SpeedDistribution, SpeedScale,
};
use std::f64::consts::TAU;

/// Particles relative to the center, and the law of their speeds.
pub(super) struct Start {
    pub(super) particles: Vec<Particle>,
    pub(super) speed_law: SpeedLaw,
}

/// How far outside a written point may be and still be meant to stand on the wall, over the radius: the rounding of
/// written decimals.
const WRITTEN_ON_WALL: f64 = 1e-12;

/// Builds the start of a configuration, its speeds at their final scale.
pub(super) fn start(
    config: &GasConfig,
    seed: Seed,
    definition: SpeedMean,
    boltzmann_j_per_k: f64,
    mass_ratios: &[f64],
) -> Result<Start, SetupError> {
    let mut unscaled = match &config.placement {
        Placement::Random => drawn(config, seed)?,
        Placement::Given(state) => {
            let particles = written(config, state)?;
            given(config, &particles)?
        }
        Placement::Recorded(start) => {
            given(config, &restart_state::rows(start, ["x", "y", "vx", "vy"])?)?
        }
        Placement::Lattice => {
            return Err(SetupError(
                "a gas is not placed on a lattice: use placement = \"random\" or written positions"
                    .to_owned(),
            ));
        }
    };
    if let (Placement::Random, SpeedScale::Temperature(_)) = (&config.placement, config.speed_scale)
    {
        // At one temperature, particles of m times the mass have 1/sqrt(m) of the speed.
        for (particle, ratio) in unscaled.particles.iter_mut().zip(mass_ratios) {
            particle.velocity = particle.velocity.map(|component| component / ratio.sqrt());
        }
    }
    let factor = match config.speed_scale {
        SpeedScale::Given => 1.0,
        SpeedScale::MaxSpeed(speed) => speed.get(),
        SpeedScale::Temperature(temperature) => {
            let wanted = speed_at(temperature.get(), config.mass_kg.get(), boltzmann_j_per_k);
            let present = SpeedMoments::of(
                unscaled.particles.iter().copied().zip(mass_ratios.iter().copied()),
            )
            .squared_speed(definition)
            .sqrt();
            if wanted > 0.0 && !(present > 0.0 && present.is_finite()) {
                return Err(SetupError(format!(
                    "velocities of mean {present} m/s can't be scaled to {} K: give some particle a finite velocity, or temperature_k = 0",
                    temperature.get()
                )));
            }
            if wanted > 0.0 { wanted / present } else { 0.0 }
        }
    };
    Ok(unscaled.scaled(factor))
}

impl Start {
    /// All velocities times a factor: step (d) of the gas document.
    fn scaled(mut self, factor: f64) -> Self {
        for particle in &mut self.particles {
            // Adding zero makes a particle at rest +0 in both components.
            particle.velocity = particle.velocity.map(|component| component * factor + 0.0);
        }
        self.speed_law = match self.speed_law {
            SpeedLaw::Uniform { max_speed } => SpeedLaw::Uniform { max_speed: max_speed * factor },
            SpeedLaw::Maxwell { mean_square } => {
                SpeedLaw::Maxwell { mean_square: mean_square * factor * factor }
            }
            SpeedLaw::Equal => SpeedLaw::Equal,
            SpeedLaw::Given => SpeedLaw::Given,
        };
        self
    }
}

/// Places uniform over the area, directions uniform, speeds by their law in units of its scale.
fn drawn(config: &GasConfig, seed: Seed) -> Result<Start, SetupError> {
    let speed_law = match (config.speed_distribution, config.speed_scale) {
        (_, SpeedScale::Given | SpeedScale::Temperature(_))
            if !config.speeds_m_per_s.is_empty() =>
        {
            SpeedLaw::Given
        }
        (_, SpeedScale::Given) => {
            return Err(SetupError(
                "drawn speeds need a scale: give temperature_k or max_speed_m_per_s".to_owned(),
            ));
        }
        (SpeedDistribution::Maxwell, SpeedScale::MaxSpeed(_)) => {
            return Err(SetupError(
                "Maxwell's speeds have no upper bound: give temperature_k, not max_speed_m_per_s"
                    .to_owned(),
            ));
        }
        (SpeedDistribution::Uniform, _) => SpeedLaw::Uniform { max_speed: 1.0 },
        (SpeedDistribution::Maxwell, _) => SpeedLaw::Maxwell { mean_square: 2.0 },
        (SpeedDistribution::Equal, _) => SpeedLaw::Equal,
    };
    let mut motions = seed.stream(Stream::Velocities);
    let listed = &config.speeds_m_per_s;
    let velocity = |id: usize| {
        if !listed.is_empty() {
            return from_polar(listed[id % listed.len()].get(), TAU * motions.uniform());
        }
        match config.speed_distribution {
            SpeedDistribution::Uniform => {
                let speed = motions.uniform();
                from_polar(speed, TAU * motions.uniform())
            }
            SpeedDistribution::Maxwell => motions.normal_pair(),
            SpeedDistribution::Equal => from_polar(1.0, TAU * motions.uniform()),
        }
    };
    let velocities: Vec<[f64; 2]> = (0..config.particles.get() as usize).map(velocity).collect();
    let particles = places(config, seed)?
        .into_iter()
        .zip(velocities)
        .map(|(position, velocity)| Particle { position, velocity })
        .collect();
    Ok(Start { particles, speed_law })
}

/// Places relative to the center: of points by their law, of discs uniform among those without overlap.
fn places(config: &GasConfig, seed: Seed) -> Result<Vec<[f64; 2]>, SetupError> {
    let radius = config.radius_m.get();
    let mut draws = seed.stream(Stream::Positions);
    let count = config.particles.get();
    let Some(disc_radius) = config.disc_radius_m.map(|radius| radius.get()) else {
        return Ok((0..count)
            .map(|_| {
                // The area inside a radius grows as its square: the root of a uniform number is uniform over the disc.
                let share = draws.uniform();
                let distance = radius
                    * match config.place_distribution {
                        PlaceDistribution::Area => share.sqrt(),
                        PlaceDistribution::Radius => share,
                    };
                from_polar(distance, TAU * draws.uniform())
            })
            .collect());
    };
    let square = Rectangle { min: [-radius, -radius], max: [radius, radius] };
    let reach = radius - disc_radius;
    let is_inside = |[x, y]: [f64; 2], _: f64| x * x + y * y <= reach * reach;
    let radii = vec![disc_radius; count as usize];
    random_sequential_addition_where(square, &radii, &mut draws, is_inside).map_err(|jammed| {
        SetupError(format!(
            "only {} of {count} discs found a place: choose fewer discs, a smaller disc_radius_m or a larger radius_m",
            jammed.placed
        ))
    })
}

fn from_polar(length: f64, angle: f64) -> [f64; 2] {
    let (sin, cos) = libm::sincos(angle);
    [length * cos, length * sin]
}

/// Particles as written: x, y in m, vx, vy in m/s.
fn written(config: &GasConfig, state: &GivenState) -> Result<Vec<[f64; 4]>, SetupError> {
    if let SpeedScale::MaxSpeed(_) = config.speed_scale {
        return Err(SetupError(
            "written velocities have no law to bound: leave max_speed_m_per_s out, or rescale them by temperature_k"
                .to_owned(),
        ));
    }
    let (count, places, motions) =
        (config.particles.get() as usize, state.positions.len(), state.velocities.len());
    if places != count || motions != count {
        return Err(SetupError(format!(
            "particles = {count}, but {places} positions and {motions} velocities are written: the three must agree"
        )));
    }
    let moving = state.positions.iter().zip(&state.velocities);
    Ok(moving.map(|([x, y], [vx, vy])| [x, y, vx, vy].map(|value| value.get())).collect())
}

/// Particles of a given or recorded start; a point outside is refused.
fn given(config: &GasConfig, rows: &[[f64; 4]]) -> Result<Start, SetupError> {
    let (radius, center) = (config.radius_m.get(), config.center_m.map(|axis| axis.get()));
    let mut particles = Vec::with_capacity(rows.len());
    for (index, &[x, y, vx, vy]) in rows.iter().enumerate() {
        let mut position = [x - center[0], y - center[1]];
        let distance = libm::hypot(position[0], position[1]);
        if distance > radius * (1.0 + WRITTEN_ON_WALL) {
            return Err(SetupError(format!(
                "particle {index} (counted from 0) at [{x}, {y}] is {distance} m from the center, outside the wall at {radius} m: \
                 move it inside or enlarge radius_m"
            )));
        }
        if distance > radius {
            position = position.map(|component| component * (radius / distance));
        }
        particles.push(Particle { position, velocity: [vx, vy] });
    }
    Ok(Start { particles, speed_law: SpeedLaw::Given })
}
