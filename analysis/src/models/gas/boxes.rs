//! Entropy by boxes of a gas behind a partition, and the change by its free expansion or by mixing.
//!
//! Vertical strips, ten on each side of the partition, are the boxes. With n_s particles of species s, n_sb of them in box b, and the
//! fraction a_b of the area, the entropy per particle is -(1/N) sum of n_sb ln(n_sb/(n_s a_b)): zero for a uniform gas.

use super::laws::has_partition_through_center;
use super::metrics as metric;
use super::observe::GasRun;
use crate::metric::Measurements;
use crate::metric::theory::ExpectedValue;
use crate::statistics::Estimate;
use kinetoscope_manifest::model::{GasConfig, GasPlacement, PartitionSide};
use kinetoscope_recording::reader::StateTable;
use std::f64::consts::PI;

/// Boxes on each side of the partition.
const BOXES_PER_SIDE: usize = 10;

/// Container crossings at the rms speed after which the gas has filled the container.
const CROSSINGS_TO_FILL: f64 = 50.0;

/// Container crossings up to which a particle is taken to be where it started.
const CROSSINGS_TO_MOVE: f64 = 5.0;

/// Entropy per particle over k_B, relative to that of a uniform gas; `None` without a partition or positions, or if particles leave.
pub(super) fn box_entropy(state: &StateTable, config: &GasConfig) -> Option<f64> {
    let partition = position_of(config).filter(|_| config.orifice_width_m.is_none())?;
    let (center, radius) = (config.center_m[0].get(), config.radius_m.get());
    let species = 1 + config.additional_masses_kg.len();
    let mut counts = vec![[0.0; 2 * BOXES_PER_SIDE]; species];
    for (id, x) in state.column("x")?.enumerate() {
        counts[config.species_of(id)][box_of((x - center) / radius, partition)] += 1.0;
    }
    let fractions = area_fractions(partition);
    let mut sum = 0.0;
    for counts in &counts {
        let members: f64 = counts.iter().sum();
        for (count, fraction) in counts.iter().zip(fractions).filter(|(count, _)| **count > 0.0) {
            sum -= count * libm::log(count / (members * fraction));
        }
    }
    Some(sum / state.rows() as f64)
}

/// Position of the partition relative to the center over the radius.
fn position_of(config: &GasConfig) -> Option<f64> {
    let x = config.partition?.x_m.get();
    Some((x - config.center_m[0].get()) / config.radius_m.get())
}

/// Box that contains a position. The rounding of a position never moves it to the other side of the partition.
fn box_of(x: f64, partition: f64) -> usize {
    let last = BOXES_PER_SIDE as f64 - 1.0;
    let within = |fraction: f64| (fraction * BOXES_PER_SIDE as f64).clamp(0.0, last) as usize;
    if x < partition {
        within((x + 1.0) / (partition + 1.0))
    } else {
        BOXES_PER_SIDE + within((x - partition) / (1.0 - partition))
    }
}

/// Fraction of the area of a unit circle to the left of x.
fn area_to_the_left(x: f64) -> f64 {
    let x = x.clamp(-1.0, 1.0);
    0.5 + (x * (1.0 - x * x).sqrt() + libm::asin(x)) / PI
}

fn area_fractions(partition: f64) -> [f64; 2 * BOXES_PER_SIDE] {
    let edge = |index: usize| {
        let fraction = |count: usize| count as f64 / BOXES_PER_SIDE as f64;
        match index.checked_sub(BOXES_PER_SIDE) {
            None => -1.0 + (partition + 1.0) * fraction(index),
            Some(right) => partition + (1.0 - partition) * fraction(right),
        }
    };
    std::array::from_fn(|index| area_to_the_left(edge(index + 1)) - area_to_the_left(edge(index)))
}

/// Number of particles per species and fraction of the area on which it starts.
fn starts(config: &GasConfig) -> Option<Vec<[f64; 2]>> {
    let (partition, side) = (position_of(config)?, config.partition?.side);
    let particles = config.particles.get() as usize;
    let species = 1 + config.additional_masses_kg.len();
    let left = area_to_the_left(partition);
    let start = |index: usize| {
        let members = (particles + species - 1 - index) / species;
        let is_right = side == Some(PartitionSide::ByMass) && index > 0;
        [members as f64, if is_right { 1.0 - left } else { left }]
    };
    Some((0..species).map(start).filter(|[members, _]| *members > 0.0).collect())
}

/// The entropy of a uniform gas on both sides, as measured by boxes; `None` where the start is given, and in gravity.
pub(super) fn entropy_at_equilibrium(config: &GasConfig) -> Option<f64> {
    let [start, _, change, _] = expected(config)?;
    Some(start + change)
}

/// Expected entropy per particle over k_B at the start and its standard deviation, then the expected change and its standard deviation.
///
/// `None` where the start is given, in gravity, and where particles leave. The change is the sum of x_s ln(A/A_s): ln(A/A_s) for free expansion, and -sum of x_s ln x_s for mixing at equal density. A species in
/// B boxes adds -(B - 1)/(2N) on average with a standard deviation of sqrt(2 (B - 1))/(2N) (Wilks 1938).
fn expected(config: &GasConfig) -> Option<[f64; 4]> {
    let is_uniform = config.gravity_m_per_s2.get() == 0.0 && config.orifice_width_m.is_none();
    if config.placement != GasPlacement::Random || !is_uniform {
        return None;
    }
    let particles = f64::from(config.particles.get());
    let [few, all] = [BOXES_PER_SIDE as f64 - 1.0, 2.0 * BOXES_PER_SIDE as f64 - 1.0];
    let (mut start, mut change, mut species) = (0.0, 0.0, 0.0);
    for [members, fraction] in starts(config)? {
        let ideal = -members / particles * libm::log(fraction);
        start += -ideal - few / (2.0 * particles);
        change += ideal - (all - few) / (2.0 * particles);
        species += 1.0;
    }
    let deviation = |freedoms: f64| (species * freedoms / 2.0).sqrt() / particles;
    Some([start, deviation(few), change, deviation(few + all)])
}

impl GasRun {
    /// Entropy per particle over k_B that is missing because particles are too slow to have moved: of a species of which a fraction f
    /// is still on its side of the center, the densities are 1 + f and 1 - f, and f^2/2 is missing. `None` without velocities.
    fn entropy_of_unmoved(&self, open_s: f64) -> Option<f64> {
        let state = self.snapshots.last()?;
        let slowest = CROSSINGS_TO_MOVE * 2.0 * self.config.radius_m.get() / open_s;
        let mut species = vec![[0.0; 2]; 1 + self.config.additional_masses_kg.len()];
        for (id, (vx, vy)) in state.column("vx")?.zip(state.column("vy")?).enumerate() {
            let [members, unmoved] = &mut species[self.config.species_of(id)];
            *members += 1.0;
            *unmoved += f64::from(u8::from(vx * vx + vy * vy < slowest * slowest));
        }
        let missing = |[members, unmoved]: &[f64; 2]| unmoved * unmoved / (2.0 * members);
        let present = species.iter().filter(|[members, _]| *members > 0.0);
        Some(present.map(missing).sum::<f64>() / state.rows() as f64)
    }

    /// Adds the entropy by boxes and the change of the temperature, which is zero if only specular reflections occur.
    pub(super) fn measure_boxes(&self, found: &mut Measurements) {
        let Some(partition) = self.config.partition else { return };
        if self.config.keeps_energy() && self.config.orifice_width_m.is_none() {
            found.compare(metric::TEMPERATURE_MAX_CHANGE, self.max_temperature_change, 0.0);
        } else {
            found.add(metric::TEMPERATURE_MAX_CHANGE, self.max_temperature_change);
        }
        let ends = (self.box_entropy.first(), self.box_entropy.last());
        let (Some(&(_, first)), Some(&(_, last))) = ends else { return };
        let Some([start, start_error, change, change_error]) = expected(&self.config) else {
            found.add(metric::BOX_ENTROPY_AT_START, first);
            found.add(metric::BOX_ENTROPY_CHANGE, last - first);
            return;
        };
        found.compare(metric::BOX_ENTROPY_AT_START, Estimate::new(first, Some(start_error)), start);
        let open_s = partition.opens_s.map_or(0.0, |opens| self.time_s - opens.get());
        let rms = self.mean_square().map_or(0.0, f64::sqrt);
        let crossings = rms * open_s / (2.0 * self.config.radius_m.get());
        let unmoved = self.entropy_of_unmoved(open_s);
        let in_range = crossings >= CROSSINGS_TO_FILL
            && unmoved.is_some_and(|missing| missing <= change_error / 2.0)
            && has_partition_through_center(&self.config);
        // A partition that stays changes nothing, up to the scatter of both entropies.
        let value = if partition.opens_s.is_some() { change } else { 0.0 };
        let in_range = in_range || partition.opens_s.is_none();
        let theory = ExpectedValue { value, accuracy: None, in_range };
        let change = Estimate::new(last - first, Some(change_error));
        found.compare(metric::BOX_ENTROPY_CHANGE, change, theory);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Guarantee: the boxes cover the circle, and each contains the positions between its edges.
    #[test]
    fn boxes_cover_the_circle() {
        for partition in [-0.7, 0.0, 0.4] {
            let fractions = area_fractions(partition);
            assert!((fractions.iter().sum::<f64>() - 1.0).abs() < 1e-14);
            let left: f64 = fractions[..BOXES_PER_SIDE].iter().sum();
            assert!((left - area_to_the_left(partition)).abs() < 1e-14);
            assert_eq!([-1.0, partition, 1.0].map(|x| box_of(x, partition)), [0, 10, 19]);
            assert_eq!(box_of(partition - 1e-12, partition), 9);
        }
        assert!((area_to_the_left(0.5) - (2.0 / 3.0 + 3.0_f64.sqrt() / (4.0 * PI))).abs() < 1e-14);
    }
}
