//! Dense random starts: small discs that grow while they move and collide (Lubachevsky and Stillinger, J. Stat. Phys. 60,
//! 561, 1990). All diameters grow at one constant relative rate; the velocities are scaled back now and then, as growing
//! discs heat each other.

use super::arena::{Arena, Guard};
use super::engine::{Engine, Step, With};
use super::motion::Vector;
use super::observables::Moments;
use super::start::{packing_fraction, random_positions, random_velocities};
use crate::model::SetupError;
use crate::random::{Seed, Stream};
use kinetoscope_manifest::model::{Boundary, InitialVelocities, PackingConfig};

/// Discs begin at this packing fraction, or at half of the one that is wanted.
const FRACTION_AT_BEGIN: f64 = 0.2;

/// Collisions a disc between two scalings of the velocities.
const COLLISIONS_BETWEEN_SCALINGS: u64 = 4;

/// Discs whose pressure is so many times the ideal one are jammed: they would grow by less than its inverse.
const JAMMED: f64 = 1e7;

/// The densest packing of equal discs, pi / (2 sqrt 3).
const HEXAGONAL: f64 = 0.9069;

/// Discs that have grown.
pub(super) struct Compressed {
    /// Centers.
    pub(super) positions: Vec<Vector>,
    /// The share of the full radius that was reached: 1 unless a pressure was wanted.
    pub(super) scale: f64,
    /// How it went, for the log.
    pub(super) account: String,
}

/// Lets discs grow to these radii, or up to the pressure that the manifest wants.
///
/// # Errors
/// Discs that jam before.
pub(super) fn compress(
    config: &PackingConfig,
    radii: &[f64],
    seed: Seed,
) -> Result<Compressed, SetupError> {
    let fraction = packing_fraction(config, radii);
    let is_equal = config.polydispersity.get() == 0.0;
    if is_equal && fraction >= HEXAGONAL && config.compression_pressure.is_none() {
        return Err(SetupError(format!(
            "packing fraction {fraction:.4}: equal discs reach {HEXAGONAL} at most; use fewer discs, a smaller radius, a \
             larger box, or a compression_pressure"
        )));
    }
    let begin = if fraction > 2.0 * FRACTION_AT_BEGIN { FRACTION_AT_BEGIN } else { 0.5 * fraction };
    let scale = (begin / fraction).sqrt();
    let small: Vec<f64> = radii.iter().map(|radius| scale * radius).collect();
    let positions = random_positions(config, &small, seed)?;
    // Thermal speed 1, whatever the law of the run.
    let unmodified =
        PackingConfig { initial_velocities: InitialVelocities::Unmodified, ..config.clone() };
    let velocities = random_velocities(&unmodified, seed.stream(Stream::Compression));
    let arena = Arena {
        sides: [config.width.get(), config.height.get()],
        has_walls: config.boundary == Boundary::Walls,
        largest_radius: config.largest_radius(),
        restitution: 1.0,
        guard: Guard::Off,
        wall_noise_rad: 0.0,
    };
    let noise = seed.stream(Stream::WallNoise);
    let mut engine = Engine::new(arena, positions, velocities, radii.to_vec(), 2.0, noise);
    let rate = growth_rate(config);
    engine.grow(scale, rate);
    let outcome = grow(&mut engine, config, [scale, rate])?;
    let reached = outcome.scale;
    Ok(Compressed {
        positions: engine.look().map(|(position, _)| position).collect(),
        scale: reached,
        account: format!(
            "compression at rate {} from packing fraction {begin:.4}, {} collisions a disc, pressure over ideal {:.4}",
            config.compression_rate.get(),
            outcome.collisions / radii.len() as u64,
            outcome.pressure
        ),
    })
}

/// Growth of the scale in a unit of time: thermal speed 1.
fn growth_rate(config: &PackingConfig) -> f64 {
    config.compression_rate.get() / (2.0 * config.radius.get())
}

struct Outcome {
    scale: f64,
    collisions: u64,
    pressure: f64,
}

fn grow(
    engine: &mut Engine,
    config: &PackingConfig,
    [scale, rate]: [f64; 2],
) -> Result<Outcome, SetupError> {
    let end = (1.0 - scale) / rate;
    let window = COLLISIONS_BETWEEN_SCALINGS * u64::from(config.discs.get());
    let mut outcome = Outcome { scale: 1.0, collisions: 0, pressure: 1.0 };
    let (mut virial, mut opened) = (0.0, 0.0);
    loop {
        let step =
            engine.step::<false>(end).map_err(|fault| jammed(config, engine.scale(), &fault.0))?;
        let collision = match step {
            Step::Collision(collision) => collision,
            Step::Other => continue,
            Step::Quiet => break,
        };
        if let With::Disc(reach) = collision.with {
            virial += reach * engine.scale() * collision.normal_impulse;
        }
        outcome.collisions += 1;
        if outcome.collisions.is_multiple_of(window) {
            let moments = Moments::of(engine.velocities());
            let kinetic = moments.temperature() * 0.5 * engine.count() as f64;
            let elapsed = engine.time() - opened;
            outcome.pressure = 1.0 + 0.5 * virial / (kinetic * elapsed);
            if config.compression_pressure.is_some_and(|wanted| outcome.pressure >= wanted.get()) {
                outcome.scale = engine.scale();
                return Ok(outcome);
            }
            // No time passes in a jam: the quotient is no number then.
            if outcome.pressure.is_nan() || outcome.pressure > JAMMED {
                return Err(jammed(config, engine.scale(), "they jammed"));
            }
            // Mean square speed 2 is a thermal speed of 1.
            engine.scale_velocities((2.0 / moments.temperature()).sqrt());
            (virial, opened) = (0.0, engine.time());
        }
    }
    engine.wait_until(end);
    Ok(outcome)
}

fn jammed(config: &PackingConfig, scale: f64, what: &str) -> SetupError {
    SetupError(format!(
        "compression came to a packing fraction of {:.4} only: {what}; use fewer discs, a smaller radius, a smaller \
         compression_rate, a compression_pressure, or placement = \"lattice\"",
        packing_fraction(config, &[config.radius.get()])
            * f64::from(config.discs.get())
            * scale
            * scale
    ))
}
