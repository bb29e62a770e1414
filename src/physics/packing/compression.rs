//! Dense random starts by compression: small discs grow while they move and collide (Lubachevsky and Stillinger, J. Stat.
//! Phys. 60 (1990) 561). All radii grow at the same constant relative rate; the velocities are rescaled regularly, because
//! growing discs heat each other.

use super::collision::CollisionPartner;
use super::domain::{Domain, Floor};
use super::engine::{Engine, StepOutcome};
use super::motion::Vector;
use super::random_start::{is_equal, packing_fraction, random_positions, random_velocities};
use super::velocity_moments::VelocityMoments;
use crate::model::{Proceed, SetupError};
use crate::random::{Seed, Stream};
use kinetoscope_manifest::model::{InitialVelocities, PackingConfig};

/// The initial packing fraction, or half of the target if this is less than twice the value.
const INITIAL_FRACTION: f64 = 0.2;

/// Collisions per disc between two rescalings of the velocities.
const COLLISIONS_BETWEEN_RESCALINGS: u64 = 4;

/// Reduced pressure P A/(N k T) above which discs are jammed: their radii could grow by a fraction of 1e-7 at most.
const JAMMED_PRESSURE: f64 = 1e7;

/// Packing fraction of the densest packing of equal discs, π/(2 √3).
const HEXAGONAL_FRACTION: f64 = 0.9069;

/// Events between two questions whether to proceed.
const EVENTS_PER_QUESTION: u64 = 1 << 14;

/// Mean square speed during compression, for a thermal speed of 1.
const MEAN_SQUARE_SPEED: f64 = 2.0;

/// The result of a compression.
pub(super) struct CompressedStart {
    /// Centers.
    pub(super) positions: Vec<Vector>,
    /// Final radius over full radius: 1 unless the manifest has a target pressure.
    pub(super) scale: f64,
    /// The compression in words, for the log.
    pub(super) description: String,
}

/// Lets discs grow to these radii, or until the pressure is the target of the manifest.
///
/// # Errors
/// Discs that jam before, or a stop: the number of collisions is proportional to 1/`compression_rate`, which has no lower bound.
pub(super) fn compress(
    config: &PackingConfig,
    radii: &[f64],
    seed: Seed,
    proceed: Proceed<'_>,
) -> Result<CompressedStart, SetupError> {
    let fraction = packing_fraction(config, radii);
    if is_equal(config)
        && fraction >= HEXAGONAL_FRACTION
        && config.target_reduced_pressure.is_none()
    {
        return Err(SetupError::new(
            format!(
                "packing fraction {fraction:.4}: equal discs reach {HEXAGONAL_FRACTION} at most"
            ),
            "use fewer discs, a smaller radius, a larger box, or a target_reduced_pressure",
        ));
    }
    let initial = if fraction > 2.0 * INITIAL_FRACTION { INITIAL_FRACTION } else { 0.5 * fraction };
    let scale = (initial / fraction).sqrt();
    let small: Vec<f64> = radii.iter().map(|radius| scale * radius).collect();
    // The small discs are placed in a fraction of the time that they take to grow.
    let positions = random_positions(config, &small, seed, &|_| proceed(0.0))?;
    // A thermal speed of 1, whatever the initial velocities of the run.
    let unmodified =
        PackingConfig { initial_velocities: InitialVelocities::UnitVariance, ..config.clone() };
    let velocities = random_velocities(&unmodified, seed.stream(Stream::Compression));
    let domain = Domain {
        restitution: 1.0,
        wall_noise_rad: 0.0,
        gravity: 0.0,
        floor: Floor::AtRest,
        ..Domain::new(config, config.largest_radius())
    };
    let noise = seed.stream(Stream::WallNoise);
    let radii = radii.to_vec();
    let discs = radii.len() as u64;
    let mut engine = Engine::new(domain, positions, velocities, radii, MEAN_SQUARE_SPEED, noise);
    // Growth of radius over full radius per unit of time, at a thermal speed of 1.
    let rate = config.compression_rate.get() / (2.0 * config.radius.get());
    engine.grow(scale, rate);
    let result = grow(&mut engine, config, [scale, rate], proceed)?;
    Ok(CompressedStart {
        positions: engine.positions_and_velocities().map(|(position, _)| position).collect(),
        scale: result.scale,
        description: format!(
            "compression at rate {} from packing fraction {initial:.4}, {} collisions per disc, reduced pressure {:.4}",
            config.compression_rate.get(),
            result.collisions / discs,
            result.reduced_pressure
        ),
    })
}

/// The end of the growth.
struct GrowthResult {
    scale: f64,
    collisions: u64,
    reduced_pressure: f64,
}

fn grow(
    engine: &mut Engine,
    config: &PackingConfig,
    [scale, rate]: [f64; 2],
    proceed: Proceed<'_>,
) -> Result<GrowthResult, SetupError> {
    let end = (1.0 - scale) / rate;
    let window = COLLISIONS_BETWEEN_RESCALINGS * u64::from(config.discs.get());
    let mut result = GrowthResult { scale: 1.0, collisions: 0, reduced_pressure: 1.0 };
    let (mut virial, mut window_start) = (0.0, 0.0);
    for event in 1_u64.. {
        if event.is_multiple_of(EVENTS_PER_QUESTION) && !proceed(engine.time() / end) {
            return Err(SetupError::stopped());
        }
        let outcome = engine
            .step::<1, false>(end)
            .map_err(|fault| jammed(config, engine.scale(), &fault.to_string()))?;
        let collision = match outcome {
            StepOutcome::Collision(collision) => collision,
            StepOutcome::Bookkeeping => continue,
            StepOutcome::NoEvent => break,
        };
        if let CollisionPartner::Disc { contact_distance, .. } = collision.partner {
            virial += contact_distance * engine.scale() * collision.normal_impulse;
        }
        result.collisions += 1;
        if result.collisions.is_multiple_of(window) {
            let moments = VelocityMoments::of(engine.velocities());
            let kinetic_energy = moments.mean_square_speed() * 0.5 * engine.count() as f64;
            let elapsed = engine.time() - window_start;
            let pressure = 1.0 + 0.5 * virial / (kinetic_energy * elapsed);
            result.reduced_pressure = pressure;
            if config.target_reduced_pressure.is_some_and(|target| pressure >= target.get()) {
                result.scale = engine.scale();
                return Ok(result);
            }
            // In a jam, no time passes, and the quotient is NaN.
            if pressure.is_nan() || pressure > JAMMED_PRESSURE {
                return Err(jammed(config, engine.scale(), "the discs jammed"));
            }
            engine.scale_velocities((MEAN_SQUARE_SPEED / moments.mean_square_speed()).sqrt());
            (virial, window_start) = (0.0, engine.time());
        }
    }
    engine.advance_clock_to(end);
    Ok(result)
}

fn jammed(config: &PackingConfig, scale: f64, reason: &str) -> SetupError {
    let fraction = packing_fraction(config, &[config.radius.get()])
        * f64::from(config.discs.get())
        * scale
        * scale;
    SetupError::new(
        format!("compression reached a packing fraction of only {fraction:.4}: {reason}"),
        "use fewer discs, a smaller radius, a smaller compression_rate, a target_reduced_pressure, or placement = \"lattice\"",
    )
}
