//! Law: in a row of N separated discs, the last disc obtains the velocity v ((1 + e)/2)^(N - 1), if each gap is longer
//! than the displacement during a contact, v pi/w. Touching discs share the momentum.
//!
//! Source: momentum and restitution, collision by collision. Touching rows: Herrmann and Seitz, Am. J. Phys. 50 (1982)
//! 977; their velocities are computed here with another integrator, the fourth-order Runge-Kutta method, from m x'' =
//! sum of k delta - eta v on a line.
//! Setup: `experiments/dem_newtons_cradle.toml`.
//! Tolerance: 0.009, the band of the restitution, 0.5 w0 dt = 0.0022 at N_t = 1000, for each of four collisions.
//! Control: a touching row does not transmit all of the velocity.

use crate::scene::{discs, prepared, run_to_time, shipped_run};

const ROW: usize = 5;
const MASS: f64 = 1e-3;
const STIFFNESS: f64 = 5e4;
const DIAMETER: f64 = 1e-3;
const TOLERANCE: f64 = 0.009;

fn coordinates(variant: &str, restitution: &str) -> String {
    format!("model.dem.restitution={restitution} variant={variant} ")
}

/// Velocities of all discs at the end, m/s; the initial velocity of the first disc is 1 m/s.
fn measured(variant: &str, restitution: &str) -> Vec<f64> {
    let (config, _) = shipped_run("dem_newtons_cradle", &coordinates(variant, restitution));
    let mut model = prepared(&config);
    run_to_time(&mut model, 6e-3);
    discs(&model).iter().map(|disc| disc.velocity[0]).collect()
}

/// Accelerations of a row on a line.
fn accelerations(x: &[f64; ROW], v: &[f64; ROW], damping: f64) -> [f64; ROW] {
    let mut a = [0.0; ROW];
    for left in 0..ROW - 1 {
        let overlap = DIAMETER - (x[left + 1] - x[left]);
        if overlap > 0.0 {
            let force = STIFFNESS * overlap - damping * (v[left + 1] - v[left]);
            a[left] -= force / MASS;
            a[left + 1] += force / MASS;
        }
    }
    a
}

/// The same velocities by the Runge-Kutta method with a twentieth of the step.
fn reference(gap: f64, damping_ratio: f64) -> [f64; ROW] {
    let damping = 2.0 * damping_ratio * (STIFFNESS * 0.5 * MASS).sqrt();
    let mut x: [f64; ROW] = std::array::from_fn(|disc| disc as f64 * (DIAMETER + gap));
    let mut v = [1.0, 0.0, 0.0, 0.0, 0.0];
    let step = 2e-8;
    let shifted = |from: &[f64; ROW], by: &[f64; ROW], time: f64| -> [f64; ROW] {
        std::array::from_fn(|disc| from[disc] + by[disc] * time)
    };
    for _ in 0..300_000 {
        let a1 = accelerations(&x, &v, damping);
        let v2 = shifted(&v, &a1, 0.5 * step);
        let a2 = accelerations(&shifted(&x, &v, 0.5 * step), &v2, damping);
        let v3 = shifted(&v, &a2, 0.5 * step);
        let a3 = accelerations(&shifted(&x, &v2, 0.5 * step), &v3, damping);
        let v4 = shifted(&v, &a3, step);
        let a4 = accelerations(&shifted(&x, &v3, step), &v4, damping);
        for disc in 0..ROW {
            x[disc] += step / 6.0 * (v[disc] + 2.0 * v2[disc] + 2.0 * v3[disc] + v4[disc]);
            v[disc] += step / 6.0 * (a1[disc] + 2.0 * a2[disc] + 2.0 * a3[disc] + a4[disc]);
        }
    }
    v
}

#[test]
fn separated_discs_transmit_the_velocity_of_binary_collisions() {
    for (restitution, e) in [("1", 1.0_f64), ("0.9", 0.9)] {
        let transmitted = measured("apart", restitution)[ROW - 1];
        let factor = 0.5 * (1.0 + e);
        let expected = factor * factor * factor * factor;
        println!("e = {e}: {transmitted:.5} of the velocity, expected {expected:.5}");
        assert!((transmitted - expected).abs() < TOLERANCE);
    }
}

#[test]
fn touching_discs_follow_the_runge_kutta_solution() {
    // Attractive tail: zeta = -ln e / sqrt(pi^2 + ln^2 e) at e = 0.9.
    for (restitution, zeta) in [("1", 0.0), ("0.9", 0.033_518_45)] {
        let (found, expected) = (measured("touching", restitution), reference(0.0, zeta));
        println!("e = {restitution}: {found:.4?}, Runge-Kutta {expected:.4?}");
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < TOLERANCE);
        }
    }
}

#[test]
fn control_touching_discs_do_not_transmit_all_velocity() {
    assert!(measured("touching", "1")[ROW - 1] < 1.0 - 5.0 * TOLERANCE);
    // The reference distinguishes separated from touching discs.
    assert!((reference(4e-4, 0.0)[ROW - 1] - 1.0).abs() < 1e-3);
}
