//! Scatter of the initial speeds from seed to seed.
//!
//! The speeds are drawn, and then multiplied by a factor that gives the mean square or the mean of the manifest. For N
//! particles, x = v^2/`<v^2>` and y = v/`<v>`, the relative variance of a mean is 1/N times:
//!
//! | factor | `<v^2>` | `<v>` |
//! |---|---|---|
//! | none | Var x | Var y |
//! | for `<v^2>` | 0 | Var(y - x/2) |
//! | for `<v>` | Var(x - 2y) | 0 |
//!
//! In gravity, speeds change, and with them the scatter of the temperature.

use super::laws::{barometric_mean_square_m2_per_s2, has_several_masses, temperature_of_k};
use crate::statistics::{Estimate, mean};
use kinetoscope_manifest::model::{
    GasConfig, GasPlacement, SpeedDistribution, SpeedScale, TemperatureDefinition,
};
use std::f64::consts::PI;

/// Moments of a distribution of speeds: variances and covariance of x = v^2/`<v^2>` and y = v/`<v>`.
#[derive(Clone, Copy, Debug, PartialEq)]
struct SpeedVariances {
    x: f64,
    y: f64,
    xy: f64,
}

impl SpeedVariances {
    const fn of(distribution: SpeedDistribution) -> Self {
        match distribution {
            SpeedDistribution::Maxwell => Self { x: 1.0, y: 4.0 / PI - 1.0, xy: 0.5 },
            SpeedDistribution::Uniform => Self { x: 0.8, y: 1.0 / 3.0, xy: 0.5 },
            SpeedDistribution::Equal => Self { x: 0.0, y: 0.0, xy: 0.0 },
        }
    }
}

/// Standard deviations over seeds of means over the initial speeds, relative to the means.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct StartScatter {
    /// Of `<v>`.
    pub(super) mean: f64,
    /// Of `<v^2>`.
    pub(super) mean_square: f64,
    /// Of the thermal energy of discs with a given total energy. A circular wall conserves the angular momentum, so the
    /// energy of rotation, which is kT/2 on average and follows a chi-square distribution with one degree of freedom, never
    /// becomes thermal: sqrt(2)/2 kT out of N kT.
    pub(super) thermal_energy: f64,
}

impl StartScatter {
    /// The scatter of the manifest's starts; zero where all seeds have the same speeds. `None` for several masses.
    pub(super) fn new(config: &GasConfig) -> Option<Self> {
        if has_several_masses(config) {
            return None;
        }
        let is_drawn = config.placement == GasPlacement::Random && config.speeds_m_per_s.is_empty();
        let SpeedVariances { x, y, xy } = SpeedVariances::of(config.speed_distribution);
        let (mean, mean_square) = match (config.speed_scale, config.temperature_definition) {
            _ if !is_drawn => (0.0, 0.0),
            (SpeedScale::Temperature(_), TemperatureDefinition::MeanSquare) => {
                (y + x / 4.0 - xy, 0.0)
            }
            (SpeedScale::Temperature(_), TemperatureDefinition::MeanSpeed) => {
                (0.0, x + 4.0 * y - 4.0 * xy)
            }
            (SpeedScale::MaxSpeed(_) | SpeedScale::Given, _) => (y, x),
        };
        let particles = f64::from(config.particles.get());
        let relative = |variance: f64| (variance / particles).sqrt();
        let thermal_energy = if is_drawn { 0.5_f64.sqrt() / particles } else { 0.0 };
        Some(Self { mean: relative(mean), mean_square: relative(mean_square), thermal_energy })
    }
}

/// Temperature of a gas that starts in equilibrium with gravity, with its scatter over seeds, from the squared speeds of the first and of
/// the last frame.
///
/// The kinetic energies of N points have the variance (kT)^2 each. Their sum is given at the start, and those of one point at both
/// instants have the correlation c, so that N (kT)^2 (1 - c^2) remains of the variance of the sum.
pub(super) fn temperature_in_equilibrium(
    config: &GasConfig,
    first: &[f64],
    last: &[f64],
) -> Option<Estimate> {
    let (before, now) = (mean(first)?, mean(last)?);
    let moment = |one: &[f64], one_mean: f64, other: &[f64], other_mean: f64| -> f64 {
        one.iter().zip(other).map(|(a, b)| (a - one_mean) * (b - other_mean)).sum()
    };
    let variances = moment(first, before, first, before) * moment(last, now, last, now);
    let squared_correlation = moment(first, before, last, now).powi(2) / variances;
    let remaining = (1.0 - squared_correlation).max(0.0);
    let expected = temperature_of_k(config, barometric_mean_square_m2_per_s2(config)?);
    let error = expected * (remaining / first.len() as f64).sqrt();
    Some(Estimate::new(temperature_of_k(config, now), (error > 0.0).then_some(error)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::random::Uniform;
    use crate::statistics::standard_deviation;
    use kinetoscope_manifest::model::PositionDistribution;

    /// Law: the formulas above. Setup: 4000 samples of 100 Maxwell speeds and of 100 uniform ones, rescaled as by the
    /// manifest. Tolerance: 5 %, four standard errors of a standard deviation, and 1/N.
    #[test]
    fn scatter_of_means_equals_that_of_drawn_speeds() {
        for distribution in [SpeedDistribution::Maxwell, SpeedDistribution::Uniform] {
            for definition in [TemperatureDefinition::MeanSquare, TemperatureDefinition::MeanSpeed]
            {
                let config = GasConfig {
                    particles: 100.try_into().unwrap(),
                    speed_distribution: distribution,
                    temperature_definition: definition,
                    ..GasConfig::default()
                };
                let expected = StartScatter::new(&config).unwrap();
                let mut uniform = Uniform(5);
                let (mut means, mut squares) = (Vec::new(), Vec::new());
                for _ in 0..4000 {
                    let speeds: Vec<f64> = (0..100)
                        .map(|_| match distribution {
                            SpeedDistribution::Maxwell => {
                                libm::hypot(uniform.normal(), uniform.normal())
                            }
                            _ => uniform.next(),
                        })
                        .collect();
                    let mean = speeds.iter().sum::<f64>() / 100.0;
                    let square = speeds.iter().map(|speed| speed * speed).sum::<f64>() / 100.0;
                    let factor = match definition {
                        TemperatureDefinition::MeanSquare => 1.0 / square.sqrt(),
                        TemperatureDefinition::MeanSpeed => 1.0 / mean,
                    };
                    means.push(mean * factor);
                    squares.push(square * factor * factor);
                }
                for (values, expected) in [(means, expected.mean), (squares, expected.mean_square)]
                {
                    let mean = mean(&values).unwrap();
                    let scatter = standard_deviation(&values).unwrap() / mean;
                    let allowed = 0.05 * expected + 1e-12;
                    assert!((scatter - expected).abs() < allowed, "{scatter} {expected}");
                }
            }
        }
    }

    /// Law: the mean of the squared speeds whose sum was given at first scatters by sqrt(1 - c^2) of independent ones. Setup: 2000
    /// samples of 200 velocities of which a fraction a^2 = c = 0.8 remains. Tolerance: 8 %, five standard errors of a standard deviation;
    /// the mean is that of the law within 0.2 %. Control: independent ones, 1/sqrt(N), scatter by a factor of 1/0.6.
    #[test]
    fn temperature_in_equilibrium_scatters_by_what_its_start_leaves() {
        let config = GasConfig {
            position_distribution: PositionDistribution::Barometric,
            ..GasConfig::default()
        };
        let square = barometric_mean_square_m2_per_s2(&config).unwrap();
        let given = temperature_of_k(&config, square);
        let (kept, drawn) = (0.8_f64.sqrt(), 0.2_f64.sqrt());
        let mut uniform = Uniform(300);
        let (mut temperatures, mut errors) = (Vec::new(), Vec::new());
        for _ in 0..2000 {
            let velocities: Vec<[f64; 2]> =
                (0..200).map(|_| [uniform.normal(), uniform.normal()]).collect();
            let squares = velocities.iter().map(|[x, y]| x * x + y * y);
            let scale = (200.0 * square / squares.sum::<f64>()).sqrt();
            let component = (square / 2.0).sqrt();
            let (first, last): (Vec<f64>, Vec<f64>) = velocities
                .iter()
                .map(|velocity| {
                    let before = velocity.map(|v| scale * v);
                    let now = before.map(|v| kept * v + drawn * component * uniform.normal());
                    let squared = |[x, y]: [f64; 2]| x * x + y * y;
                    (squared(before), squared(now))
                })
                .unzip();
            let found = temperature_in_equilibrium(&config, &first, &last).unwrap();
            temperatures.push(found.value);
            errors.push(found.standard_error.unwrap());
        }
        let scatter = standard_deviation(&temperatures).unwrap();
        let ratio = scatter / mean(&errors).unwrap();
        assert!((ratio - 1.0).abs() < 0.08, "{ratio}");
        assert!((mean(&temperatures).unwrap() / given - 1.0).abs() < 0.002);
        assert!(scatter < 0.7 * given / 200.0_f64.sqrt(), "control: {scatter}");
    }
}
