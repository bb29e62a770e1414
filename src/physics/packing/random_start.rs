//! Random radii, positions and velocities.

use super::motion::{self, Vector};
use super::near_obstacles::NearObstacles;
use crate::model::{Proceed, SetupError};
use crate::placement::{Rectangle, random_sequential_addition};
use crate::random::{Generator, Seed, Stream};
use kinetoscope_manifest::model::{InitialVelocities, PackingConfig};

/// Packing fraction below which random placement is supported (packing exercise, `NU`). Random sequential addition itself
/// saturates at 0.547 (Feder, J. Theor. Biol. 87 (1980) 237).
const RANDOM_PLACEMENT_LIMIT: f64 = 0.5;

/// What to do if random placement finds no room.
const OTHER_PLACEMENTS: &str = "use fewer discs or a smaller radius, or, without obstacles, placement = \"lattice\" or \"compressed\"";

/// The box as a rectangle.
pub(super) fn rectangle(config: &PackingConfig) -> Rectangle {
    let [x, y] = [0.5 * config.width.get(), 0.5 * config.height.get()];
    Rectangle { min: [-x, -y], max: [x, y] }
}

/// Whether all discs have the same radius.
pub(super) fn is_equal(config: &PackingConfig) -> bool {
    config.radius_half_width.get() == 0.0
}

/// The radius of each disc, uniformly distributed about the mean, from a random stream of their own. For a width of zero, all
/// are exactly the mean.
pub(super) fn random_radii(config: &PackingConfig, seed: Seed) -> Vec<f64> {
    let (radius, half_width) = (config.radius.get(), config.radius_half_width.get());
    let (min, max) = (radius * (1.0 - half_width), radius * (1.0 + half_width));
    let mut generator = seed.stream(Stream::Radii);
    (0..config.discs.get()).map(|_| generator.uniform_in(min, max)).collect()
}

/// Packing fraction n π `<r²>` / (lx ly).
pub(super) fn packing_fraction(config: &PackingConfig, radii: &[f64]) -> f64 {
    let areas = radii.iter().map(|radius| std::f64::consts::PI * radius * radius);
    areas.fold(0.0, |sum, area| sum + area) / (config.width.get() * config.height.get())
}

/// Rejects a packing fraction that random sequential addition would hardly reach.
pub(super) fn check_random_placement(
    config: &PackingConfig,
    radii: &[f64],
) -> Result<(), SetupError> {
    let fraction = packing_fraction(config, radii);
    if radii.len() > 1 && fraction >= RANDOM_PLACEMENT_LIMIT {
        return Err(SetupError::new(
            format!(
                "packing fraction {fraction:.4}: random placement needs a fraction below {RANDOM_PLACEMENT_LIMIT}"
            ),
            OTHER_PLACEMENTS,
        ));
    }
    Ok(())
}

/// Places discs of these radii by random sequential addition.
///
/// # Errors
/// A disc for which no free position was found, or a stop.
pub(super) fn random_positions(
    config: &PackingConfig,
    radii: &[f64],
    seed: Seed,
    proceed: Proceed<'_>,
) -> Result<Vec<Vector>, SetupError> {
    let mut generator = seed.stream(Stream::Positions);
    let (rectangle, boundary) = (rectangle(config), config.boundary);
    let (obstacles, of_obstacle) = (NearObstacles::of(config), config.obstacles().1);
    let is_free =
        |center, radius| obstacles.closer_than(of_obstacle + radius, center).next().is_none();
    let placed =
        random_sequential_addition(rectangle, boundary, radii, &mut generator, is_free, proceed);
    let takers = if obstacles.is_empty() { "walls" } else { "walls and obstacles" };
    placed.map_err(|incomplete| {
        incomplete.into_error(|placed| {
            SetupError::new(
                format!(
                    "random placement found room for {placed} of {} discs (packing fraction {:.4}, and {takers} take room)",
                    config.discs,
                    packing_fraction(config, radii)
                ),
                OTHER_PLACEMENTS,
            )
        })
    })
}

/// Standard deviation of a velocity component before the mean is subtracted: 1, or n^(-1/2).
pub(super) fn velocity_std(config: &PackingConfig) -> f64 {
    match config.initial_velocities {
        InitialVelocities::UnitVariance => 1.0,
        InitialVelocities::VarianceOneOverN => 1.0 / f64::from(config.discs.get()).sqrt(),
    }
}

/// Whether the mean velocity is subtracted: never from a single disc, which would stop.
pub(super) fn removes_mean_velocity(config: &PackingConfig) -> bool {
    config.remove_mean_velocity && config.discs.get() > 1
}

/// Normally distributed velocity components with the variance of the manifest. Their mean is subtracted if the manifest asks
/// for it and there are several discs. Both variances use the same random numbers, so the velocities differ by the factor n^(-1/2) only.
pub(super) fn random_velocities(config: &PackingConfig, mut generator: Generator) -> Vec<Vector> {
    let std = velocity_std(config);
    let mut velocities: Vec<Vector> = (0..config.discs.get())
        .map(|_| generator.normal_pair().map(|normal| normal * std))
        .collect();
    if removes_mean_velocity(config) {
        let count = velocities.len() as f64;
        let sum = velocities.iter().fold([0.0; 2], |sum, v| [sum[0] + v[0], sum[1] + v[1]]);
        for velocity in &mut velocities {
            *velocity = motion::difference(sum.map(|sum| sum / count), *velocity);
        }
    }
    velocities
}
