//! Density of a gas in gravity over twenty layers, against the barometric law.

use super::chi_square::ChiSquare;
use super::laws::{self, boltzmann_j_per_k};
use super::metrics as metric;
use super::observe::GasRun;
use crate::metric::theory::ExpectedValue;
use crate::metric::{Measurements, Quantity};
use crate::models::contract::HeightLayers;
use crate::statistics::Estimate;
use kinetoscope_manifest::model::{GasConfig, PositionDistribution, SpeedScale};
use kinetoscope_recording::reader::StateTable;
use std::f64::consts::PI;

/// Number of layers of equal height.
pub(super) const LAYERS: usize = 20;

/// Intervals of Simpson's rule per layer.
const INTERVALS: usize = 4096;

/// Expected fraction of the particles per layer, from the bottom to the top, and their mean height above the center, m.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct BarometricLaw {
    pub(super) fractions: [f64; LAYERS],
    mean_height_m: f64,
}

impl BarometricLaw {
    /// The law of the manifest's gas at the temperature of a thermal wall, or else of the start; `None` without gravity or without a
    /// temperature.
    pub(super) fn of(config: &GasConfig) -> Option<Self> {
        let gravity = config.gravity_m_per_s2.get();
        let temperature_k = match (config.thermal_wall, config.speed_scale) {
            (Some(wall), _) => wall.temperature_k.get(),
            (None, SpeedScale::Temperature(temperature)) => temperature.get(),
            (None, _) => 0.0,
        };
        // Particles that have left are below the container.
        if gravity == 0.0 || temperature_k == 0.0 || config.orifice_width_m.is_some() {
            return None;
        }
        let thermal = boltzmann_j_per_k(config) * temperature_k;
        let masses = std::iter::once(config.mass_kg).chain(config.additional_masses_kg.clone());
        let masses: Vec<f64> = masses.map(|mass| mass.get()).collect();
        let particles = config.particles.get() as usize;
        let (mut fractions, mut mean) = ([0.0; LAYERS], 0.0);
        for (species, mass) in masses.iter().enumerate() {
            let members = (particles + masses.len() - 1 - species) / masses.len();
            let weight = mass * gravity * config.radius_m.get() / thermal;
            let share = members as f64 / particles as f64;
            let layers = layers(weight);
            let total: f64 = layers.iter().map(|[content, _]| content).sum();
            for (fraction, [content, moment]) in fractions.iter_mut().zip(layers) {
                *fraction += share * content / total;
                mean += share * moment / total;
            }
        }
        Some(Self { fractions, mean_height_m: mean * config.radius_m.get() })
    }
}

/// Content and first moment of each layer of the unit circle for w = m g R / (k_B T): the integrals of exp(-w (1 + y)) 2 sqrt(1 - y^2)
/// and of y times that. With y = -cos(t), the integrand is exp(-w (1 - cos t)) 2 sin^2 t, smooth at both ends.
fn layers(weight: f64) -> [[f64; 2]; LAYERS] {
    let edge =
        |layer: usize| libm::acos((1.0 - 2.0 * layer as f64 / LAYERS as f64).clamp(-1.0, 1.0));
    std::array::from_fn(|layer| {
        let (from, to) = (edge(layer), edge(layer + 1));
        let step = (to - from) / INTERVALS as f64;
        let mut sums = [0.0; 2];
        for node in 0..=INTERVALS {
            let angle = from + step * node as f64;
            let simpson = match node {
                0 | INTERVALS => 1.0,
                _ if node % 2 == 1 => 4.0,
                _ => 2.0,
            };
            // 1 - cos t without cancellation.
            let height = 2.0 * libm::sin(angle / 2.0).powi(2);
            let density = simpson * libm::exp(-weight * height) * 2.0 * libm::sin(angle).powi(2);
            sums[0] += density;
            sums[1] += density * (height - 1.0);
        }
        sums.map(|sum| sum * step / 3.0)
    })
}

/// Number of particles per layer, from the bottom to the top, and the sums of their heights above the center and of the squares.
pub(super) fn counts(state: &StateTable, config: &GasConfig) -> Option<([f64; LAYERS], [f64; 2])> {
    let (center, radius) = (config.center_m[1].get(), config.radius_m.get());
    let (mut counts, mut sums) = ([0.0; LAYERS], [0.0; 2]);
    for y in state.column("y")? {
        let height = y - center;
        let layer = ((height / radius + 1.0) / 2.0 * LAYERS as f64).clamp(0.0, LAYERS as f64 - 1.0);
        counts[layer as usize] += 1.0;
        sums[0] += height;
        sums[1] += height * height;
    }
    Some((counts, sums))
}

/// Density of a layer over that of a uniform gas.
pub(super) fn relative_density(layer: usize, fraction: f64) -> f64 {
    let chord = |y: f64| y * (1.0 - y * y).max(0.0).sqrt() + libm::asin(y);
    let edge = |layer: usize| (2.0 * layer as f64 / LAYERS as f64 - 1.0).clamp(-1.0, 1.0);
    fraction * PI / (chord(edge(layer + 1)) - chord(edge(layer)))
}

/// The layers of a container at rest; `None` without gravity or a temperature.
pub(super) fn height_layers(config: &GasConfig) -> Option<HeightLayers> {
    let law = BarometricLaw::of(config)?;
    let (center, radius) = (config.center_m[1].get(), config.radius_m.get());
    // Five digits are more than a picture shows.
    let short = |value: f64| libm::round(value * 1e5) / 1e5;
    let areas = (0..LAYERS).map(|layer| short(1.0 / relative_density(layer, 1.0))).collect();
    let law = law.fractions.map(short).to_vec();
    Some(HeightLayers { range: [center - radius, center + radius], areas, law })
}

impl GasRun {
    /// Adds the metrics of the layers.
    pub(super) fn measure_layers(&self, found: &mut Measurements) {
        let Some(barometric) = BarometricLaw::of(&self.config) else { return };
        let Some((counts, sums)) =
            self.snapshots.last().and_then(|state| counts(state, &self.config))
        else {
            return;
        };
        // Without a thermal wall, only a start in equilibrium has a known distribution later: each particle keeps its energy. A
        // partition may leave more particles on one side.
        let (chi_law, height_law, not_in_equilibrium) = match self.config.thermal_wall {
            Some(_) => (
                laws::BAROMETRIC_CHI_OF_WALL,
                laws::BAROMETRIC_HEIGHT_OF_WALL,
                self.not_thermalized(),
            ),
            None => {
                let distribution = self.config.position_distribution;
                let is_barometric = distribution == PositionDistribution::Barometric;
                let violation = Quantity::BarometricStart.required(is_barometric);
                (laws::BAROMETRIC_CHI, laws::BAROMETRIC_HEIGHT, violation)
            }
        };
        let violation = not_in_equilibrium
            .or_else(|| Quantity::NoPartition.required(self.config.partition.is_none()));
        let particles: f64 = counts.iter().sum();
        let pairs = counts.iter().zip(&barometric.fractions);
        let pairs = pairs.map(|(count, fraction)| [*count, particles * fraction]);
        if let Some(chi_square) = ChiSquare::of(pairs)
            && let Some(value) = chi_square.expected(1.0)
        {
            let of_law = (2.0 * value / chi_square.bins).sqrt();
            let error = if violation.is_none() { of_law } else { chi_square.scatter };
            let per_layer = Estimate::new(chi_square.per_bin, Some(error));
            let theory = ExpectedValue { value, accuracy: None, violation };
            found.compare_with(metric::LAYERS_CHI_SQUARE, per_layer, chi_law, theory);
        }
        let mean = sums[0] / particles;
        let variance = (sums[1] / particles - mean * mean).max(0.0);
        let height = Estimate::new(mean, Some((variance / particles).sqrt()));
        let theory = ExpectedValue { value: barometric.mean_height_m, accuracy: None, violation };
        found.compare_with(metric::MEAN_HEIGHT, height, height_law, theory);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Law: without weight, the contents are areas; with weight w, their sum is 2 pi exp(-w) I1(w)/w.
    /// Source: Abramowitz and Stegun 9.6.18, I1(1) = 0.565159103992485, I1(10) = 2670.988303701255.
    /// Control: the weight 10.001 deviates by more than the tolerance.
    #[test]
    fn layer_contents_equal_closed_forms() {
        let total = |weight| layers(weight).iter().map(|[content, _]| content).sum::<f64>();
        assert!((total(0.0) / PI - 1.0).abs() < 1e-12);
        for (weight, bessel) in [(1.0_f64, 0.565_159_103_992_485), (10.0, 2_670.988_303_701_255)] {
            let exact = 2.0 * PI * libm::exp(-weight) * bessel / weight;
            assert!((total(weight) / exact - 1.0).abs() < 1e-12, "{weight}");
            assert!((total(weight + 1e-3) / exact - 1.0).abs() > 1e-5, "control");
        }
        for (layer, [content, _]) in layers(0.0).into_iter().enumerate() {
            assert!((relative_density(layer, content / PI) - 1.0).abs() < 1e-9, "{layer}");
        }
        // Far above the scale height, the layer at the bottom contains everything, and 2e5 (1 + <y>) is 3.
        let [content, moment] = layers(2e5)[0];
        assert!((2e5 * (1.0 + moment / content) / 1.5 - 1.0).abs() < 1e-5);
    }
}
