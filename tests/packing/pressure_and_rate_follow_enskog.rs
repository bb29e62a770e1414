//! Laws of elastic discs in equilibrium:
//! - collision rate per disc (Enskog): w = 2 sqrt(pi) n s g sqrt(kT/m);
//! - Z = P A / (N kT) = 1 + (sqrt(pi)/4) s w sqrt(m/kT) at any density: virial and rate agree;
//! - the pressure on the walls equals that of the virial, and Henderson's Z = (1 + f^2/8) / (1 - f)^2 at the density
//!   far from walls, with the correction for a finite box.
//!
//! Source: Chapman and Cowling, The Mathematical Theory of Non-uniform Gases; Henderson, Mol. Phys. 30 (1975) 971, g =
//! (1 - 7f/16) / (1 - f)^2. Independent simulations give Z(0.1) = 1.23615(9) and Z(0.3) = 2.0633(2); Henderson's values
//! are 1.2361 and 2.0638.
//! Setup: stated at each test.
//! Tolerance: stated at each test.
//! Control: stated at each test.

// Assertions compare within tolerances, so no bit of a run depends on these functions.
#![allow(clippy::disallowed_methods)]

use crate::runs::{advance_to_count, advance_to_time, at_fraction, disc_states, message, prepare};
use kinetoscope_physics::model::Model;
use kinetoscope_physics::packing::Packing;
use kinetoscope_recording::channels::{PackingCollisions, PackingPressure, PackingTemperature};
use std::f64::consts::PI;

fn henderson(fraction: f64) -> f64 {
    (1.0 + fraction * fraction / 8.0) / ((1.0 - fraction) * (1.0 - fraction))
}

/// Sums since the initial state, of which differences are taken.
struct Sums {
    time: f64,
    pairs: f64,
    energy_integral: f64,
    virial: f64,
    wall_impulse: f64,
}

impl Sums {
    fn of(packing: &Packing) -> Self {
        let pressure = message::<PackingPressure>(packing);
        Self {
            time: packing.time(),
            pairs: message::<PackingCollisions>(packing).pair_collisions as f64,
            energy_integral: pressure.kinetic_energy_time_integral,
            virial: pressure.collision_virial_sum,
            wall_impulse: pressure.wall_impulse,
        }
    }

    fn since(&self, earlier: &Self) -> Self {
        Self {
            time: self.time - earlier.time,
            pairs: self.pairs - earlier.pairs,
            energy_integral: self.energy_integral - earlier.energy_integral,
            virial: self.virial - earlier.virial,
            wall_impulse: self.wall_impulse - earlier.wall_impulse,
        }
    }
}

/// Setup: 2000 discs at 0.1 in a box of side L = 250; 60 events per disc are counted after the first 10. The walls have
/// two effects of first order in s/L: centers have only the area a^2, a = L - s, so n = N / a^2; and a disc within s of
/// a wall has no partners behind it, which reduces the rate by the fraction 4 s / (pi a).
/// Tolerance: 1 %. The two effects are 1.6 % and 1.0 %, and the next terms are smaller by the fraction 0.1 each; the
/// count of 50,000 pairs has an error of 0.4 %.
/// Control: the rate without g, lower by 12 %, is rejected.
#[test]
fn collision_rate_follows_enskog() {
    let (discs, fraction) = (2000_u32, 0.1);
    let config = at_fraction(discs, fraction);
    let mut packing = prepare(&config, 2, 0);
    advance_to_count(&mut packing, u64::from(10 * discs));
    let before = Sums::of(&packing);
    advance_to_count(&mut packing, u64::from(70 * discs));
    let counted = Sums::of(&packing).since(&before);
    let temperature = message::<PackingTemperature>(&packing).temperature;

    let rate = 2.0 * counted.pairs / (f64::from(discs) * counted.time);
    let side = config.width.get() - 2.0;
    let density = f64::from(discs) / (side * side);
    let local_fraction = density * PI;
    let contact = (1.0 - 7.0 * local_fraction / 16.0) / (1.0 - local_fraction).powi(2);
    let walls = 1.0 - 4.0 * 2.0 / (PI * side);
    let expected = 2.0 * PI.sqrt() * density * 2.0 * contact * temperature.sqrt() * walls;
    println!("rate over Enskog's: {:.4} after {} pairs", rate / expected, counted.pairs);
    assert!((rate / expected - 1.0).abs() < 0.01);
    assert!((rate / (expected / contact) - 1.0).abs() > 0.01);
}

/// Setup: 400 discs at 0.2 and 0.45, 200,000 events.
/// Tolerance: 0.6 % of Z - 1. |g| at collisions has the density g exp(-g^2 / 4kT), so its mean over C = 160,000
/// collisions scatters by sqrt(4/pi - 1) / sqrt(C) = 0.13 %. Constant energy lowers it by 1/(8n).
/// Control: the exercise's temperature <v^2>, twice kT/m, is rejected.
#[test]
fn virial_and_rate_give_the_same_compressibility_factor() {
    for fraction in [0.2, 0.45] {
        let discs = 400_u32;
        let mut packing = prepare(&at_fraction(discs, fraction), 3, 0);
        advance_to_count(&mut packing, 200_000);
        let excess = message::<PackingPressure>(&packing).compressibility_factor - 1.0;
        let rate = message::<PackingCollisions>(&packing).pair_collision_rate_per_disc;
        let temperature = message::<PackingTemperature>(&packing);
        let from_rate = |temperature: f64| PI.sqrt() / 4.0 * 2.0 * rate / temperature.sqrt();
        let ratio = excess / from_rate(temperature.temperature);
        println!(
            "fraction {fraction}: Z - 1 from the virial {excess:.4}, over that from the rate {ratio:.5}"
        );
        assert!((ratio - 1.0).abs() < 0.006);
        assert!((excess / from_rate(temperature.mean_square_velocity) - 1.0).abs() > 0.006);
    }
}

/// Setup: 400 discs at 0.3, 1.6 million events, 1500 frames. The density is that of discs more than 4 diameters from
/// each wall. A box of side a with walls of line tension gamma has the pressure P - 2 gamma / a; scaled particle theory
/// (Helfand, Frisch and Lebowitz, J. Chem. Phys. 34 (1961) 1037) gives gamma = -kT f^2 / (pi r (1 - f)^2) at the line
/// of centers, so the pressure on the walls is P (1 + 2 f r / a).
/// Tolerance: 1 % between wall and virial (300,000 wall collisions scatter by 0.1 %, slow fluctuations of the density
/// by as much again); 1 % for Henderson (the count inside scatters by 1.4 % per frame over about fifty independent
/// ones, which gives 0.2 %, and d ln P / d ln f = 1.9).
/// Control: Henderson's pressure at the mean fraction of the whole box is rejected.
#[test]
fn pressure_follows_henderson_at_the_density_far_from_walls() {
    let (discs, fraction) = (400_u32, 0.3);
    let config = at_fraction(discs, fraction);
    let side = config.width.get();
    let mut packing = prepare(&config, 4, 0);
    advance_to_count(&mut packing, u64::from(20 * discs));
    let before = Sums::of(&packing);
    let half_inside = 0.5 * side - 8.0;
    let frames = 1500_u32;
    let interval = before.time * (4000.0 / 20.0) / f64::from(frames);
    let mut inside = 0;
    for frame in 1..=frames {
        advance_to_time(&mut packing, before.time + f64::from(frame) * interval);
        inside += disc_states(&packing)
            .iter()
            .filter(|disc| disc.position.iter().all(|coordinate| coordinate.abs() < half_inside))
            .count();
    }
    let counted = Sums::of(&packing).since(&before);
    let temperature = message::<PackingTemperature>(&packing).temperature;
    let wall = counted.wall_impulse / (4.0 * (side - 2.0) * counted.time);
    let area = (side - 2.0) * (side - 2.0);
    let virial = (2.0 * counted.energy_integral + counted.virial) / (2.0 * area * counted.time);
    let density = inside as f64 / f64::from(frames) / (4.0 * half_inside * half_inside);
    let corners = 1.0 + 2.0 * density * PI / (side - 2.0);
    let expected = density * temperature * henderson(density * PI) * corners;
    println!(
        "{} pairs, wall over virial {:.4}, fraction inside {:.4}, virial over Henderson {:.4}",
        counted.pairs,
        wall / virial,
        density * PI,
        virial / expected
    );
    assert!((wall / virial - 1.0).abs() < 0.01);
    assert!((virial / expected - 1.0).abs() < 0.01);
    let whole_box = f64::from(discs) / (side * side) * temperature * henderson(fraction);
    assert!((virial / whole_box - 1.0).abs() > 0.01);
}
