//! Range in which results have digits: a start outside it is rejected with a remedy instead of giving wrong digits.

use super::clock::STEP_ROUNDING;
use super::motion::Particle;
use crate::model::SetupError;
use kinetoscope_manifest::model::{GasConfig, GasPlacement, Propagation, SpeedScale};

/// Masses, radii, speeds and times must be between the inverse of this number and this number, so that no product overflows.
const MAX_VALUE: f64 = 1e50;

/// Maximum path in radii: beyond it, the error of the position (2^-53 of the path) exceeds a millionth of the radius.
const MAX_PATH_IN_RADII: f64 = 1e10;

/// Maximum path in disc radii if discs collide.
const MAX_PATH_IN_DISC_RADII: f64 = 1e9;

/// Maximum distance of the center from the origin in radii: beyond it, absolute positions have fewer than seven digits.
const MAX_CENTER_DISTANCE_IN_RADII: f64 = 1e9;

/// Maximum number of steps: integers up to 2^53 are exact.
const MAX_STEPS: f64 = 9_007_199_254_740_992.0;

/// Rejects a configuration outside the range.
pub(super) fn check(config: &GasConfig, particles: &[Particle]) -> Result<(), SetupError> {
    let (radius, duration) = (config.radius_m.get(), config.duration_s.get());
    let gravity = config.gravity_m_per_s2.get();
    let fastest = max_speed(particles.iter().copied());
    let cause = if 4.0 * gravity * radius > fastest * fastest {
        "gravity_m_per_s2"
    } else {
        key_of_speeds(config)
    };
    // Falling across the container adds 4 g R to v^2.
    let fastest =
        if gravity > 0.0 { (fastest * fastest + 4.0 * gravity * radius).sqrt() } else { fastest };
    for (name, value) in [
        ("gravity_m_per_s2", if gravity > 0.0 { gravity } else { 1.0 }),
        ("mass_kg", config.mass_kg.get()),
        ("radius_m", radius),
        ("duration_s", duration),
        (
            &*format!("the speed of the fastest particle in m/s (from {cause})"),
            if fastest > 0.0 { fastest } else { 1.0 },
        ),
    ] {
        if !(1.0 / MAX_VALUE..=MAX_VALUE).contains(&value) {
            return Err(SetupError(format!(
                "{name} is {value:e}; must be between {:e} and {MAX_VALUE:e}, so that products do not overflow: choose another scale",
                1.0 / MAX_VALUE
            )));
        }
    }
    let path = fastest * duration / radius;
    if path > MAX_PATH_IN_RADII {
        return Err(SetupError(format!(
            "duration_s is {duration:e}, in which the fastest particle (from {cause}) would travel {path:e} radii, and its position would have less than six digits: \
             shorten duration_s to at most {:e}",
            MAX_PATH_IN_RADII * radius / fastest
        )));
    }
    let center = config.center_m.map(|axis| axis.get());
    let distance = libm::hypot(center[0], center[1]);
    if distance > MAX_CENTER_DISTANCE_IN_RADII * radius {
        return Err(SetupError(format!(
            "center_m is {distance:e} m from the origin, {:e} radii; must be at most {MAX_CENTER_DISTANCE_IN_RADII:e} radii, because \
             positions lose their digits: move it closer",
            distance / radius
        )));
    }
    check_collisions(config, fastest)?;
    check_steps(config)
}

/// The key that the speeds of the start follow from.
fn key_of_speeds(config: &GasConfig) -> &'static str {
    match (&config.placement, config.speed_scale) {
        (_, SpeedScale::Temperature(_)) => "temperature_k",
        (GasPlacement::Given(_), _) => "placement",
        (GasPlacement::Recorded(_), _) => "start_from",
        (_, SpeedScale::MaxSpeed(_)) => "max_speed_m_per_s",
        (_, SpeedScale::Given) => "speeds_m_per_s",
    }
}

/// Rejects discs whose contacts are below the rounding of positions and times.
fn check_collisions(config: &GasConfig, fastest: f64) -> Result<(), SetupError> {
    let Some(disc_radius) = config.disc_radius_m.map(|radius| radius.get()) else { return Ok(()) };
    let path = fastest * config.duration_s.get();
    let path = if path > config.radius_m.get() { path } else { config.radius_m.get() };
    if path > MAX_PATH_IN_DISC_RADII * disc_radius {
        return Err(SetupError(format!(
            "disc_radius_m is {disc_radius}; must be at least {:e} of the path of the fastest disc and of the container radius ({path:e} m), \
             so that contacts have six digits: shorten duration_s or increase disc_radius_m",
            1.0 / MAX_PATH_IN_DISC_RADII
        )));
    }
    Ok(())
}

/// Rejects a duration without a step, or with more steps than can be counted.
fn check_steps(config: &GasConfig) -> Result<(), SetupError> {
    let (Propagation::TimeStepped { time_step_s } | Propagation::AsPrinted { time_step_s }) =
        config.propagation
    else {
        return Ok(());
    };
    let steps = config.duration_s.get() / time_step_s.get();
    if steps + STEP_ROUNDING < 1.0 {
        return Err(SetupError(format!(
            "time_step_s is {}; must be at most duration_s = {}, because no step fits: reduce time_step_s",
            time_step_s.get(),
            config.duration_s.get()
        )));
    }
    if steps > MAX_STEPS {
        return Err(SetupError(format!(
            "duration_s / time_step_s is {steps:e} steps; must be at most {MAX_STEPS:e}, so that they can be counted: increase time_step_s"
        )));
    }
    Ok(())
}

/// Maximum |v|, m/s.
pub(super) fn max_speed(particles: impl Iterator<Item = Particle>) -> f64 {
    let mut fastest = 0.0;
    for particle in particles {
        let speed = particle.speed();
        fastest = if speed > fastest { speed } else { fastest };
    }
    fastest
}
