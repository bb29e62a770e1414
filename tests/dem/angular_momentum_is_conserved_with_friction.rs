//! Law: a contact of two free discs conserves L = sum of m (x vy - y vx) + I w, I = m r^2/2, friction, rolling resistance and
//! dashpots included, because the arms of the tangential forces, r - delta/2, add up to the distance of the centers.
//!
//! Source: Newton's third law at the contact point; LAMMPS' `pair_style granular` takes the same arm.
//! Setup: two discs of different radii without gravity, oblique collisions of eight seeds with overlaps up to 0.2 of a radius,
//! friction 0.5, rolling friction 0.1, e = 0.7; L about the corner of the box, which is near,
//! in every step.
//! Tolerance: 1e-12 of L about the center of mass, for rounding.
//! Control: torques with the full radius as their arm, from the recorded forces, change L by more than 1e-3: by some percent at an
//! overlap of 0.085 of a radius.

use crate::scene::{
    Disc, discs, equal, frame, given, gravity, non_negative, positive, restitution, run_to, spring,
    time_step,
};
use kinetoscope_manifest::model::{DemConfig, DiscRadius};
use kinetoscope_physics::dem::Dem;
use kinetoscope_physics::dem::motion::{effective_mass, moment_of_inertia};
use kinetoscope_physics::model::Model;
use kinetoscope_physics::random::Seed;
use kinetoscope_recording::channels::{DemContactForces, DemContactStatistics};

const RADIUS: f64 = 5e-4;
const STEPS: u64 = 120;

/// Two discs that meet obliquely, more obliquely with each seed.
fn collision(seed: u64) -> DemConfig {
    let slant = 0.2 + 0.08 * seed as f64;
    let offset = 0.9 * RADIUS * slant;
    let discs = [
        ([0.0022, 0.003 + 0.5 * offset], [0.6, 0.01 * seed as f64]),
        ([0.0037, 0.003 - 0.5 * offset], [-0.4, -0.2 * slant]),
    ];
    let config = DemConfig {
        radius_m: DiscRadius::Uniform { min: positive(0.8 * RADIUS), max: positive(RADIUS) },
        gravity_m_per_s2: gravity(0.0, 0.0),
        elasticity: spring(5e4),
        dissipation: restitution(0.7),
        friction: non_negative(0.5),
        rolling_friction: non_negative(0.1),
        ..DemConfig::default()
    };
    given(config, &discs)
}

/// Orbital and spin angular momentum of a disc, J s.
fn angular_momentum(disc: &Disc) -> [f64; 2] {
    let Disc { position: [x, y], velocity: [vx, vy], mass, .. } = *disc;
    [mass * (x * vy - y * vx), moment_of_inertia(mass, disc.radius) * disc.spin]
}

/// What a collision did.
struct Collision {
    /// Largest change of L over its value about the center of mass at the start.
    change: f64,
    /// The change with the full radius as the arm, over the same.
    change_with_radius: f64,
    max_overlap: f64,
    /// Spin angular momentum at the end over the same.
    spin: f64,
}

fn collide(config: &DemConfig, seed: u64) -> Collision {
    let seed = Seed { seed, replicate: 0 };
    let mut model = Dem::prepare(config, seed, true).unwrap_or_else(|error| panic!("{error}"));
    let total = |discs: &[Disc]| discs.iter().flat_map(angular_momentum).sum::<f64>();
    let start = discs(&model);
    let [first, second] = start[..] else { panic!("not two discs") };
    let apart = |of: fn(&Disc) -> [f64; 2]| [0, 1].map(|axis| of(&first)[axis] - of(&second)[axis]);
    let ([x, y], [vx, vy]) = (apart(|disc| disc.position), apart(|disc| disc.velocity));
    let scale = effective_mass(first.mass, second.mass) * (x * vy - y * vx).abs();
    let step = time_step(&model);
    let (mut change, mut added, mut max_overlap) = (0.0, 0.0, 0.0);
    for count in 1..=STEPS {
        let forces: DemContactForces = frame(&model).get().expect("forces are requested");
        if let [from_x] = forces.from_x_m[..] {
            let [x, y] = [from_x - forces.to_x_m[0], forces.from_y_m[0] - forces.to_y_m[0]];
            let distance = (x * x + y * y).sqrt();
            let tangential = (x * forces.force_y_n[0] - y * forces.force_x_n[0]) / distance;
            let overlap = discs(&model).iter().map(|disc| disc.radius).sum::<f64>() - distance;
            added += overlap * tangential * step;
        }
        run_to(&mut model, count);
        let now = (total(&discs(&model)) - total(&start)).abs() / scale;
        change = if now > change { now } else { change };
        let contacts: DemContactStatistics = frame(&model).get().expect("contacts are recorded");
        if contacts.max_overlap_over_radius > max_overlap {
            max_overlap = contacts.max_overlap_over_radius;
        }
    }
    let spin = discs(&model).iter().map(|disc| angular_momentum(disc)[1]).sum::<f64>() / scale;
    let change_with_radius = added.abs() / scale;
    Collision { change, change_with_radius, max_overlap, spin: spin.abs() }
}

#[test]
fn angular_momentum_is_conserved_with_friction() {
    for seed in 1..=8 {
        let found = collide(&collision(seed), seed);
        println!(
            "seed {seed}: change of L {:.1e}; spin {:.2e}; overlap {:.3} r; with the full radius {:.2e}",
            found.change, found.spin, found.max_overlap, found.change_with_radius
        );
        assert!(found.max_overlap > 0.04 && found.spin > 1e-3, "the discs do not slide");
        assert!(found.change < 1e-12, "seed {seed}: {:e}", found.change);
        // Control.
        assert!(found.change_with_radius > 1e-3, "seed {seed}: {:e}", found.change_with_radius);
    }
}

#[test]
fn control_full_radius_adds_percents_of_the_relative_angular_momentum() {
    let offset = RADIUS;
    let speed = 0.425 / (1.0 - 0.25_f64).sqrt();
    let config = DemConfig {
        radius_m: equal(RADIUS),
        gravity_m_per_s2: gravity(0.0, 0.0),
        dissipation: restitution(1.0),
        friction: non_negative(0.5),
        ..DemConfig::default()
    };
    let discs = [
        ([0.0024, 0.003 + 0.5 * offset], [0.5 * speed, 0.0]),
        ([0.0036, 0.003 - 0.5 * offset], [-0.5 * speed, 0.0]),
    ];
    let config = given(config, &discs);
    let found = collide(&config, 1);
    let Collision { change, change_with_radius: with_radius, max_overlap, .. } = found;
    println!("overlap {max_overlap:.4} r: {change:.1e}, with the full radius {with_radius:.4}");
    assert!((max_overlap - 0.085).abs() < 2e-3, "{max_overlap}");
    assert!(change < 1e-12, "{change:e}");
    assert!((0.01..0.1).contains(&with_radius), "{with_radius}");
}
