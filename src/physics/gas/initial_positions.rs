//! Positions at the start in gravity or behind a partition, relative to the center of the container.

use super::state::Substance;
use crate::model::SetupError;
use crate::random::Generator;
use kinetoscope_manifest::model::{GasConfig, PartitionSide, PositionDistribution, SpeedScale};

/// Draws the positions of points in barometric equilibrium or on their sides of the partition; `None` for other starts.
pub(super) fn draw_special(
    config: &GasConfig,
    draws: &mut Generator,
) -> Result<Option<Vec<[f64; 2]>>, SetupError> {
    let radius = config.radius_m.get();
    let count = config.particles.get() as usize;
    if let Some(partition) = config.partition {
        let x = (partition.x_m.get() - config.center_m[0].get()) / radius;
        if x.abs() >= 1.0 {
            return Err(SetupError::new(
                format!("partition_x_m is {}, outside the container", partition.x_m.get()),
                "set it to less than radius_m from the center",
            ));
        }
        let is_right =
            |id| partition.side == Some(PartitionSide::ByMass) && config.species_of(id) > 0;
        let positions = (0..count).map(|id| {
            // The right side is the left one of the mirrored circle.
            let sign = if is_right(id) { -1.0 } else { 1.0 };
            let [x, y] = in_left_segment(sign * x, draws)?;
            Some([sign * radius * x, radius * y])
        });
        let positions: Option<_> = positions.collect();
        return positions.map(Some).ok_or_else(|| {
            SetupError::new(
                format!(
                    "partition_x_m is {}: the side of the particles is too narrow to draw positions in it",
                    partition.x_m.get()
                ),
                "move it toward the center",
            )
        });
    }
    if config.position_distribution != PositionDistribution::Barometric {
        return Ok(None);
    }
    let SpeedScale::Temperature(temperature) = config.speed_scale else {
        return Err(SetupError::new(
            "a barometric start needs a temperature",
            "give temperature_k",
        ));
    };
    let Substance { mass_kg, mass_ratios, boltzmann_j_per_k, .. } = Substance::new(config);
    let weight = mass_kg * config.gravity_m_per_s2.get() * radius;
    let positions = mass_ratios.iter().map(|ratio| {
        let weight = ratio * weight / (boltzmann_j_per_k * temperature.get());
        Some(barometric(weight, draws)?.map(|axis| radius * axis))
    });
    let positions: Option<_> = positions.collect();
    positions.map(Some).ok_or_else(|| {
        SetupError::new(
            "no position of a barometric start was found: m g R/(k_B T) is not a number",
            "choose another temperature_k, gravity_m_per_s2 or radius_m",
        )
    })
}

/// Number of trials of a position. At least one trial in ten is accepted, so that more are needed once in 10^45 positions, unless
/// rounding leaves no number in a segment.
const MAX_TRIALS: u32 = 1000;

/// Point of the unit circle with a coordinate x below the given one, uniform over the area: rejection from a rectangle around it.
/// `None` if no trial of [`MAX_TRIALS`] is accepted.
fn in_left_segment(limit: f64, draws: &mut Generator) -> Option<[f64; 2]> {
    let half = if limit < 0.0 { (1.0 - limit * limit).sqrt() } else { 1.0 };
    (0..MAX_TRIALS).find_map(|_| {
        let x = draws.uniform_in(-1.0, limit);
        let y = draws.uniform_in(-half, half);
        (x * x + y * y <= 1.0 && x < limit).then_some([x, y])
    })
}

/// Point of the unit circle with a density proportional to exp(-w y), w = m g R / (k_B T).
///
/// The height u = 1 + y above the bottom has the density exp(-w u) sqrt(u (2 - u)). For w > 1, u is drawn from the Gamma distribution
/// with shape 3/2, the sum of an exponential number and half a squared normal one, and accepted with probability sqrt(1 - u/2);
/// otherwise, a uniform point is accepted with probability exp(-w u). `None` if no trial of [`MAX_TRIALS`] is accepted.
fn barometric(weight: f64, draws: &mut Generator) -> Option<[f64; 2]> {
    for _ in 0..MAX_TRIALS {
        if weight > 1.0 {
            let normal = draws.normal_pair()[0];
            let height = (normal * normal / 2.0 - libm::log(1.0 - draws.uniform())) / weight;
            let is_accepted = height < 2.0 && draws.uniform() < (1.0 - height / 2.0).sqrt();
            let x = draws.uniform_in(-1.0, 1.0) * (height * (2.0 - height)).sqrt();
            if is_accepted {
                return Some([x, height - 1.0]);
            }
        } else {
            let [x, y] = [draws.uniform_in(-1.0, 1.0), draws.uniform_in(-1.0, 1.0)];
            if x * x + y * y <= 1.0 && draws.uniform() < libm::exp(-weight * (1.0 + y)) {
                return Some([x, y]);
            }
        }
    }
    None
}
