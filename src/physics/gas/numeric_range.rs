//! Range in which results have digits: a start outside it is rejected with a remedy instead of giving wrong digits.

use super::motion::Particle;
use crate::model::SetupError;
use kinetoscope_manifest::model::{GasConfig, GasPlacement, SpeedScale};

/// The speed of the fastest particle must be at most this number, m/s, so that no product overflows.
const MAX_SPEED: f64 = 1e50;

/// Maximum path in radii: beyond it, the error of the position (2^-53 of the path) exceeds a millionth of the radius.
const MAX_PATH_IN_RADII: f64 = 1e10;

/// Maximum path in disc radii if discs collide.
const MAX_PATH_IN_DISC_RADII: f64 = 1e9;

/// Rejects speeds outside the range. The manifest has checked the sizes of all other numbers.
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
    if fastest > 0.0 && !(1.0 / MAX_SPEED..=MAX_SPEED).contains(&fastest) {
        return Err(SetupError::new(
            format!(
                "{cause} gives the fastest particle {fastest:e} m/s; must be between {:e} and {MAX_SPEED:e}, so that products do not overflow",
                1.0 / MAX_SPEED
            ),
            "choose another scale",
        ));
    }
    let path = fastest * duration / radius;
    if path > MAX_PATH_IN_RADII {
        return Err(SetupError::new(
            format!(
                "duration_s is {duration:e}, in which the fastest particle (from {cause}) would travel {path:e} radii, and its position would have less than six digits"
            ),
            format!("shorten duration_s to at most {:e}", MAX_PATH_IN_RADII * radius / fastest),
        ));
    }
    check_collisions(config, fastest)
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
        return Err(SetupError::new(
            format!(
                "disc_radius_m is {disc_radius}; must be at least {:e} of the path of the fastest disc and of the container radius ({path:e} m), \
                 so that contacts have six digits",
                1.0 / MAX_PATH_IN_DISC_RADII
            ),
            "shorten duration_s or increase disc_radius_m",
        ));
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
