//! What double precision can still carry: a start beyond it is refused in words instead of giving wrong digits.

use super::motion::Particle;
use crate::model::SetupError;
use kinetoscope_manifest::model::{GasConfig, Propagation};

/// Masses, radii, speeds and times lie between the inverse of this and this, so that no product of theirs overflows.
const LARGEST: f64 = 1e50;

/// Path in radii after which the place on it would be wrong by more than a millionth of the radius (2^-53 of the path).
const LONGEST_PATH_IN_RADII: f64 = 1e10;

/// The same in radii of a disc, where discs collide.
const LONGEST_PATH_IN_DISC_RADII: f64 = 1e9;

/// Distance of the center from the origin, in radii, beyond which absolute positions would keep fewer than seven digits.
const FARTHEST_CENTER_IN_RADII: f64 = 1e9;

/// Steps beyond which a count times a step is not exact any more.
const MOST_STEPS: f64 = 9_007_199_254_740_992.0;

/// Refuses a configuration whose numbers leave the range in which results have digits.
pub(super) fn check(config: &GasConfig, particles: &[Particle]) -> Result<(), SetupError> {
    let (radius, duration) = (config.radius_m.get(), config.duration_s.get());
    let fastest = fastest_speed(particles.iter().copied());
    for (name, value) in [
        ("mass_kg", config.mass_kg.get()),
        ("radius_m", radius),
        ("duration_s", duration),
        ("the fastest particle's speed in m/s", if fastest > 0.0 { fastest } else { 1.0 }),
    ] {
        if !(1.0 / LARGEST..=LARGEST).contains(&value) {
            return Err(SetupError(format!(
                "{name} = {value:e} leaves the range {:e} to {LARGEST:e} in which products do not overflow: choose another scale",
                1.0 / LARGEST
            )));
        }
    }
    let path = fastest * duration / radius;
    if path > LONGEST_PATH_IN_RADII {
        return Err(SetupError(format!(
            "the fastest particle would fly {path:e} radii, of which less than six digits of its place would remain: \
             shorten duration_s to at most {:e}",
            LONGEST_PATH_IN_RADII * radius / fastest
        )));
    }
    let center = config.center_m.map(|axis| axis.get());
    let away = libm::hypot(center[0], center[1]);
    if away > FARTHEST_CENTER_IN_RADII * radius {
        return Err(SetupError(format!(
            "center_m lies {away:e} m from the origin, {:e} radii: positions would lose their digits; move it nearer",
            away / radius
        )));
    }
    check_collisions(config, fastest)?;
    check_steps(config)
}

/// Refuses discs whose contacts would drown in the rounding of places and times.
fn check_collisions(config: &GasConfig, fastest: f64) -> Result<(), SetupError> {
    let Some(disc_radius) = config.disc_radius_m.map(|radius| radius.get()) else { return Ok(()) };
    let path = fastest * config.duration_s.get();
    let path = if path > config.radius_m.get() { path } else { config.radius_m.get() };
    if path > LONGEST_PATH_IN_DISC_RADII * disc_radius {
        return Err(SetupError(format!(
            "disc_radius_m = {disc_radius} is too small beside {path:e} m, the container's radius or the way of the fastest disc: \
             contacts would be known to less than six digits; shorten duration_s or enlarge the discs"
        )));
    }
    Ok(())
}

fn check_steps(config: &GasConfig) -> Result<(), SetupError> {
    let (Propagation::Stepped { time_step_s } | Propagation::Literal { time_step_s }) =
        config.propagation
    else {
        return Ok(());
    };
    let steps = config.duration_s.get() / time_step_s.get();
    if steps + super::STEP_ROUNDING < 1.0 {
        return Err(SetupError(format!(
            "time_step_s = {} is longer than duration_s = {}: no step fits; shorten the step",
            time_step_s.get(),
            config.duration_s.get()
        )));
    }
    if steps > MOST_STEPS {
        return Err(SetupError(format!(
            "duration_s over time_step_s is {steps:e} steps, more than can be counted: lengthen the step"
        )));
    }
    Ok(())
}

/// Largest |v|, m/s.
pub(super) fn fastest_speed(particles: impl Iterator<Item = Particle>) -> f64 {
    let mut fastest = 0.0;
    for particle in particles {
        let speed = particle.speed();
        fastest = if speed > fastest { speed } else { fastest };
    }
    fastest
}
