//! Entropy by boxes of a gas behind a partition, and what theory expects of it.
//!
//! Vertical strips, ten on each side of the partition, are the boxes. With n_s particles of species s, n_sb of them in box b, and the
//! fraction a_b of the area, the entropy per particle is -(1/N) sum of n_sb ln(n_sb/(n_s a_b)): zero for a uniform gas.

use kinetoscope_manifest::model::{GasConfig, GasPlacement, PartitionSide};
use kinetoscope_recording::reader::StateTable;
use std::f64::consts::PI;

/// Boxes on each side of the partition.
const BOXES_PER_SIDE: usize = 10;

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
pub(super) fn expected(config: &GasConfig) -> Option<[f64; 4]> {
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
