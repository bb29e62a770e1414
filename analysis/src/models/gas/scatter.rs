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

use super::laws::has_several_masses;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::random::Uniform;

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
                    let mean = crate::statistics::mean(&values).unwrap();
                    let scatter = crate::statistics::standard_deviation(&values).unwrap() / mean;
                    let allowed = 0.05 * expected + 1e-12;
                    assert!((scatter - expected).abs() < allowed, "{scatter} {expected}");
                }
            }
        }
    }
}
