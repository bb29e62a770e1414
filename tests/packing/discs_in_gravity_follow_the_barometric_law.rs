//! Law: colliding discs in gravity come to equilibrium. The density of points is proportional to exp(-g y/T), and that of discs follows
//! from the balance of weight and pressure, dp/dy = -n g (the mass of a disc is 1), with the equation of state p = n T Z(φ). The velocities
//! are Maxwell's at one temperature at all heights.
//!
//! Source: barometric law, Landau and Lifshitz, Statistical Physics, section 38; Z = (1 + φ^2/8)/(1 - φ)^2, Henderson, Mol. Phys. 30
//! (1975) 971, whose fourth virial coefficient is 1 % off, which is below 1e-6 of Z here.
//! Setup: 20 seeds of 2000 discs that start uniformly in a box and exchange energy by collisions only: the temperature of each seed is that
//! of its energy. 16 states, each 20 units of time after the one before, in 20 layers. Then dense discs above a floor with a
//! temperature. Among pegs, the density is the same where there is room for centers, and a layer has as many discs fewer as it has less room.
//! Tolerance: chi-square of 19 degrees of freedom exceeds 43.8 with a probability of 0.001.
//! Control: gravity in the law stronger by 1 %, and a law without the pegs.

#![allow(clippy::disallowed_methods, clippy::unwrap_used)]

use crate::discs_in_gravity_fly_on_parabolas::with_gravity;
use crate::runs::{DiscState, advance_to_time, disc_states, message, prepare, with_obstacles};
use kinetoscope_manifest::model::PackingConfig;
use kinetoscope_manifest::quantity::{BoxSide, Positive};
use kinetoscope_recording::channels::{PackingCollisions, PackingEnergy};
use std::f64::consts::PI;
use std::num::NonZeroU32;

const LAYERS: usize = 20;

/// Discs in gravity, in a box whose lowest and highest centers are at half of `height` below and above its middle.
#[derive(Clone, Copy)]
struct Column {
    /// Pegs per row; none without.
    pegs: u32,
    discs: f64,
    radius: f64,
    width: f64,
    height: f64,
    gravity: f64,
}

/// Number of points in the integration over the height.
const POINTS: usize = 2_000;

/// Heights of the rows of pegs, which do not overlap, and the radius of a peg.
const ROWS: [f64; 3] = [-7.75, -4.75, -1.75];
const PEG: f64 = 1.25;

impl Column {
    fn config(self) -> PackingConfig {
        let side = |side: f64| BoxSide::new(side + 2.0 * self.radius).unwrap();
        let config = PackingConfig {
            discs: NonZeroU32::new(self.discs as u32).unwrap(),
            radius: Positive::new(self.radius).unwrap(),
            width: side(self.width),
            height: side(self.height),
            ..PackingConfig::default()
        };
        let config = with_gravity(config, self.gravity);
        if self.pegs > 0 { with_obstacles(config, &self.centers_of_pegs(), PEG) } else { config }
    }

    /// Rows in the lower half of the box, at a distance from each other and from the walls.
    fn centers_of_pegs(self) -> Vec<[f64; 2]> {
        let spacing = self.width / f64::from(self.pegs.max(1));
        let x = |column: u32| spacing * (f64::from(column) + 0.5) - 0.5 * self.width;
        let pegs = ROWS.iter().flat_map(|y| (0..self.pegs).map(move |column| [x(column), *y]));
        pegs.collect()
    }

    /// The width that the pegs leave for centers at each height.
    fn widths(self) -> Vec<f64> {
        let step = self.height / POINTS as f64;
        let width = |index: usize| {
            let y = step * (index as f64 + 0.5) - 0.5 * self.height;
            let contact = PEG + self.radius;
            let half = |row: &f64| (contact * contact - (y - row) * (y - row)).max(0.0).sqrt();
            self.width - 2.0 * f64::from(self.pegs) * ROWS.iter().map(half).sum::<f64>()
        };
        (0..POINTS).map(width).collect()
    }

    /// p/T at a packing fraction times the area of a disc, φ Z, and its slope.
    fn pressure(fraction: f64) -> [f64; 2] {
        let rest = 1.0 - fraction;
        let square = fraction * fraction;
        let factor = (1.0 + square / 8.0) / (rest * rest);
        let slope = fraction / 4.0 / (rest * rest) + 2.0 * factor / rest;
        [fraction * factor, factor + fraction * slope]
    }

    /// The number of discs at each height, for a packing fraction at the floor: d(φ Z)/dy = -φ g/T, by the midpoint rule.
    fn profile(self, temperature: f64, at_floor: f64, widths: &[f64]) -> Vec<f64> {
        let step = self.height / POINTS as f64;
        let slope =
            |fraction: f64| -fraction * self.gravity / temperature / Self::pressure(fraction)[1];
        let mut fraction = at_floor;
        let area = PI * self.radius * self.radius;
        let layer = |width: &f64| {
            let middle = fraction + 0.5 * step * slope(fraction);
            fraction += step * slope(middle);
            middle / area * width * step
        };
        widths.iter().map(layer).collect()
    }

    /// The profile of all discs, by bisection.
    fn profile_of_all(self, temperature: f64) -> Vec<f64> {
        let (mut low, mut high, widths) = (0.0, 0.9, self.widths());
        for _ in 0..45 {
            let middle = 0.5 * (low + high);
            let discs: f64 = self.profile(temperature, middle, &widths).iter().sum();
            if discs < self.discs { low = middle } else { high = middle }
        }
        self.profile(temperature, low, &widths)
    }

    /// The temperature at an energy, kinetic and above the bottom of the box, by bisection, and the profile.
    fn profile_of_energy(self, energy: f64) -> (f64, Vec<f64>) {
        let (mut low, mut high) = (0.0, energy / self.discs);
        for _ in 0..30 {
            let middle = 0.5 * (low + high);
            let profile = self.profile_of_all(middle);
            let step = self.height / POINTS as f64;
            let heights = profile
                .iter()
                .enumerate()
                .map(|(index, discs)| discs * (self.radius + step * (index as f64 + 0.5)));
            let potential = self.gravity * heights.sum::<f64>();
            if self.discs * middle + potential < energy { low = middle } else { high = middle }
        }
        (low, self.profile_of_all(low))
    }
}

/// Contents of the layers of a profile.
fn layers(profile: &[f64]) -> Vec<f64> {
    profile.chunks(POINTS / LAYERS).map(|part| part.iter().sum()).collect()
}

fn count(column: Column, discs: &[DiscState], counts: &mut [f64]) {
    for disc in discs {
        let layer = (disc.position[1] / column.height + 0.5) * LAYERS as f64;
        counts[layer.clamp(0.0, LAYERS as f64 - 1.0) as usize] += 1.0;
    }
}

fn chi_square(counts: &[f64], expected: &[f64]) -> f64 {
    let [counted, all] = [counts, expected].map(|numbers| numbers.iter().sum::<f64>());
    let terms = counts.iter().zip(expected).map(|(count, expected)| {
        let expected = expected * counted / all;
        (count - expected) * (count - expected) / expected
    });
    terms.sum()
}

#[test]
fn density_of_20_seeds_follows_the_law() {
    assert_law(0);
}

#[test]
fn density_among_pegs_of_20_seeds_follows_the_law() {
    assert_law(16);
}

fn assert_law(pegs: u32) {
    let column =
        Column { pegs, discs: 2000.0, radius: 0.015, width: 80.0, height: 20.0, gravity: 0.5 };
    let (mut counts, mut expected, mut control) = ([0.0; LAYERS], [0.0; LAYERS], [0.0; LAYERS]);
    let mut without_pegs = [0.0; LAYERS];
    let mut temperatures = Vec::new();
    for seed in 0..20 {
        let mut discs = prepare(&column.config(), seed, 0);
        let start = message::<PackingEnergy>(&discs);
        let (temperature, profile) = column.profile_of_energy(start.total);
        let stronger = Column { gravity: column.gravity * 1.01, ..column };
        for state in 0..16 {
            advance_to_time(&mut discs, 100.0 + 20.0 * f64::from(state));
            count(column, &disc_states(&discs), &mut counts);
            temperatures
                .push(message::<PackingEnergy>(&discs).kinetic / column.discs / temperature);
        }
        let per_disc = layers(&profile);
        let of_control = layers(&stronger.profile_of_all(temperature));
        let of_free = layers(&Column { pegs: 0, ..column }.profile_of_all(temperature));
        for layer in 0..LAYERS {
            expected[layer] += per_disc[layer];
            control[layer] += of_control[layer];
            without_pegs[layer] += of_free[layer];
        }
        if seed == 0 {
            let pairs = message::<PackingCollisions>(&discs).pair_collisions;
            println!(
                "T = {temperature:.4}, {:.0} collisions per disc",
                2.0 * pairs as f64 / 2000.0
            );
            assert!(pairs > 100_000, "{pairs}");
        }
    }
    let (found, controlled) = (chi_square(&counts, &expected), chi_square(&counts, &control));
    let mean = temperatures.iter().sum::<f64>() / temperatures.len() as f64;
    println!(
        "{pegs} pegs per row: chi-square {found:.1} of 19, control {controlled:.1}, T over that of the energy {mean:.5}"
    );
    assert!(found < 43.8, "{found}");
    assert!(controlled > 43.8, "control: {controlled}");
    assert!(pegs == 0 || chi_square(&counts, &without_pegs) > 43.8, "control: no pegs");
    // The kinetic energy of all discs fluctuates by less than 1/sqrt(N).
    assert!((mean - 1.0).abs() < 4.0 / (320.0_f64 * 2000.0).sqrt(), "{mean}");
}

/// Discs that are dense at the floor, which has a temperature: the layers are those of the equation of state, not those of points.
#[test]
fn dense_layers_follow_the_equation_of_state() {
    let column =
        Column { pegs: 0, discs: 2000.0, radius: 0.5, width: 100.0, height: 60.0, gravity: 0.2 };
    let floor_temperature = Some(Positive::literal(2.0));
    let mut discs = prepare(&PackingConfig { floor_temperature, ..column.config() }, 3, 0);
    let mut counts = [0.0; LAYERS];
    for state in 0..50 {
        advance_to_time(&mut discs, 400.0 + 20.0 * f64::from(state));
        count(column, &disc_states(&discs), &mut counts);
    }
    let expected = layers(&column.profile_of_all(2.0));
    let points = layers(&Column { radius: 1e-6, ..column }.profile_of_all(2.0));
    println!("{counts:?}\n{expected:?}\n{points:?}");
    for layer in 1..LAYERS / 2 {
        let found = counts[layer] / 50.0;
        // Neighboring layers exchange discs: their numbers scatter less than those of points, over some 25 independent states.
        let scatter = 4.0 * (expected[layer] / 25.0).sqrt();
        assert!((found - expected[layer]).abs() < scatter, "{layer}: {found} {}", expected[layer]);
    }
    assert!((points[1] / expected[1] - 1.0).abs() > 0.2, "control");
}
