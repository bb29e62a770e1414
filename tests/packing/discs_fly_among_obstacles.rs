//! Law: a disc flies straight or on a parabola until it touches a fixed obstacle, |x - c| = r + R, and its velocity becomes v - (1 + e)(v·n) n there, as in
//! a collision with a disc of infinite mass. Energy is conserved, but for what collisions with restitution dissipate, and no disc overlaps an
//! obstacle.
//!
//! Source: free fall. REFERENCES: `python3 tests/interop/discs_among_obstacles.py`, which computes with 50 digits, without cells and
//! local times, and finds the roots of the polynomial of fourth degree by another method, those of Durand and Kerner.
//! Setup: one disc among three obstacles in a box of 10 x 10; hundreds of discs among pegs; chains of obstacles that touch.
//! Tolerance: 1e-14 times the growth of a difference at the start, by the same program, after up to 25 collisions; overlaps 1e-12 of the side;
//! energies 1e-12 of the energy exchanged.
//! Control: gravity that is stronger by 1e-9, or a start that is moved by 1e-9, is rejected; kinetic and potential energy alone change.

#![allow(clippy::disallowed_methods, clippy::excessive_precision, clippy::unwrap_used)]

use crate::discs_in_gravity_fly_on_parabolas::with_gravity;
use crate::runs::{
    DiscState, advance_to_count, advance_to_time, at_fraction, disc_states, distance, given,
    message, prepare, with_obstacles, with_restitution, without_noise,
};
use kinetoscope_manifest::model::{Boundary, CollapseGuard, PackingConfig, drawn_obstacles};
use kinetoscope_manifest::quantity::{BoxSide, NonNegative, Positive};
use kinetoscope_physics::model::{Model as _, Target};
use kinetoscope_physics::packing::Packing;
use kinetoscope_physics::random::Seed;
use kinetoscope_recording::channels::{PackingCollisions, PackingEnergy, PackingTemperature};

const OBSTACLES: [[f64; 2]; 3] = [[-2.75, -2.5], [2.75, -2.75], [0.25, 2.25]];

/// Gravity, restitution, time, numbers of collisions with obstacles and walls, growth, and the state at the end.
type Reference = ([f64; 3], [u64; 2], f64, [f64; 4]);

const REFERENCES: [Reference; 5] = [
    (
        [0.3, 1.0, 12.0],
        [8, 4],
        2.7e3,
        [-0.850690006730040276, -3.90912501813429138, -0.136881543565445107, -1.3710811259410276],
    ),
    (
        [0.3, 1.0, 28.0],
        [15, 7],
        1.4e6,
        [0.195458567022709119, -3.65010023321425988, 1.31979329302342207, 0.0364801811802999284],
    ),
    (
        [0.3, 0.75, 40.0],
        [12, 13],
        5.1e4,
        [-0.220713694171724687, -4.45719103468143631, -0.377174216576166322, 0.26300316360827197],
    ),
    (
        [0.0, 1.0, 70.0],
        [13, 6],
        1.0e9,
        [2.11945247574961388, 0.507779314753064502, 0.494674571156890409, -0.456532658909246675],
    ),
    (
        [0.0, 0.75, 200.0],
        [10, 7],
        5.0e7,
        [
            -0.344927602522985095,
            -2.08760550513671841,
            -0.104333793445182008,
            -0.00315035502361419322,
        ],
    ),
];

fn one_disc(gravity: f64, restitution: f64, start: [f64; 4]) -> PackingConfig {
    let config = PackingConfig {
        width: BoxSide::literal(10.0),
        height: BoxSide::literal(10.0),
        radius: Positive::literal(0.5),
        ..with_gravity(with_restitution(given(&[start]), restitution), gravity)
    };
    with_obstacles(config, &OBSTACLES, 1.75)
}

#[test]
fn paths_equal_those_of_50_digits() {
    let start = [-0.25, -1.5, 0.625, -0.25];
    for ([gravity, restitution, time], [obstacles, walls], growth, expected) in REFERENCES {
        let end = |config: &PackingConfig| {
            let mut disc = prepare(config, 1, 0);
            advance_to_time(&mut disc, time);
            let DiscState { position, velocity, .. } = disc_states(&disc)[0];
            let found = [position, velocity].concat().into_iter().zip(expected);
            let error =
                found.fold(0.0, |most, (found, expected)| f64::max(most, (found - expected).abs()));
            (error, disc.count(), message::<PackingCollisions>(&disc).wall_collisions)
        };
        let (error, all, of_walls) = end(&one_disc(gravity, restitution, start));
        println!(
            "gravity {gravity}, e = {restitution}, {all} collisions: error {error:.1e}, growth {growth:.0e}"
        );
        assert!(error < 1e-14 * growth, "{error:e}");
        assert_eq!([all - of_walls, of_walls], [obstacles, walls]);
        let moved = [start[0] + 1e-9, start[1], start[2], start[3]];
        let control = match gravity > 0.0 {
            true => one_disc(gravity * (1.0 + 1e-9), restitution, start),
            false => one_disc(gravity, restitution, moved),
        };
        assert!(end(&control).0 > 1e-13 * growth, "control");
    }
}

/// Rows of pegs, in turn shifted by half of their distance.
fn pegs(columns: u32, rows: u32, distance: f64) -> Vec<[f64; 2]> {
    let middle = |count: u32| (f64::from(count) - 1.0) / 2.0;
    let peg = |index: u32| {
        let [column, row] = [index % columns, index / columns];
        let shift = f64::from(row % 2) / 2.0 - 0.25;
        [
            distance * (f64::from(column) - middle(columns) + shift),
            distance * (f64::from(row) - middle(rows)),
        ]
    };
    (0..columns * rows).map(peg).collect()
}

/// The largest overlap of a disc with an obstacle.
fn overlap(discs: &[DiscState], pegs: &[[f64; 2]], radius: f64, side: Option<f64>) -> f64 {
    let mut most = f64::MIN;
    for disc in discs {
        for peg in pegs {
            let nearest = [0, 1].map(|axis| {
                let apart = disc.position[axis] - peg[axis];
                side.map_or(apart, |side| apart - side * (apart / side).round())
            });
            most = most.max(disc.radius + radius - distance(nearest, [0.0; 2]));
        }
    }
    most
}

/// Elastic discs of one size and of several, with gravity and without, in a box and in a periodic one, keep their energy and stay outside.
#[test]
fn elastic_discs_keep_their_energy_and_overlap_no_obstacle() {
    let config = without_noise(at_fraction(200, 0.2));
    let side = config.width.get();
    let several = PackingConfig { radius_half_width: NonNegative::literal(0.3), ..config.clone() };
    let periodic = PackingConfig { boundary: Boundary::Periodic, ..several.clone() };
    let chain: Vec<[f64; 2]> = (0..57).map(|index| [f64::from(index) - 28.0, 0.0]).collect();
    let large = vec![[0.0, -20.0], [28.0, 28.0]];
    let scenes = [
        (with_gravity(config.clone(), 0.1), pegs(6, 5, 8.0), 1.0),
        (with_gravity(several.clone(), 0.1), pegs(6, 5, 8.0), 0.1),
        (with_gravity(several, 0.3), chain, 0.5),
        (with_gravity(config.clone(), 0.05), large.clone(), 15.0),
        (config, pegs(6, 5, 8.0), 1.5),
        (periodic.clone(), pegs(7, 7, 8.0), 1.0),
        (periodic, large, 15.0),
    ];
    for (config, pegs, radius) in scenes {
        let images = (config.boundary == Boundary::Periodic).then_some(side);
        let config = with_obstacles(config, &pegs, radius);
        let mut discs = prepare(&config, 4, 0);
        let (first, falls) = (message::<PackingTemperature>(&discs), config.gravity.get() > 0.0);
        let mut most = f64::MIN;
        for part in 1..=200 {
            advance_to_count(&mut discs, part * 500);
            most = most.max(overlap(&disc_states(&discs), &pegs, radius, images));
            // Not at a collision.
            let between = discs.time() + 0.01;
            advance_to_time(&mut discs, between);
            most = most.max(overlap(&disc_states(&discs), &pegs, radius, images));
            let now = message::<PackingTemperature>(&discs);
            if falls {
                let energy = message::<PackingEnergy>(&discs);
                assert!(energy.residual.abs() < 1e-12 * energy.total, "{energy:?}");
                assert_eq!((energy.from_floor, energy.dissipated), (0.0, 0.0));
            } else {
                let change = now.kinetic_energy / first.kinetic_energy - 1.0;
                assert!(change.abs() < 1e-12, "{change:e}");
            }
        }
        let counts = message::<PackingCollisions>(&discs);
        let touched = discs.count() - counts.pair_collisions - counts.wall_collisions;
        println!(
            "{} obstacles of {radius}, {touched} collisions with them: overlap {most:.1e}",
            pegs.len()
        );
        assert!(most < 1e-12 * side && touched > 5_000, "{most:e} {touched}");
        // Control: an obstacle that is larger by 1e-9 overlaps a disc that touches it.
        assert!(most + 1e-9 > 1e-12 * side, "control: {most:e}");
        let moved = message::<PackingTemperature>(&discs).kinetic_energy - first.kinetic_energy;
        assert!(!falls || moved.abs() > 1e-3 * first.kinetic_energy, "control");
    }
}

/// What collisions with obstacles and discs dissipate, less what the floor has added, is the loss of energy.
#[test]
fn dissipation_at_obstacles_balances_the_energy() {
    let config = PackingConfig {
        collapse_guard: CollapseGuard::CutoffVelocity(Positive::literal(1e-3)),
        ..with_gravity(with_restitution(without_noise(at_fraction(200, 0.1)), 0.8), 0.2)
    };
    let hot = PackingConfig { floor_temperature: Positive::new(4.0), ..config.clone() };
    for config in [config, hot] {
        let mut discs = prepare(&with_obstacles(config, &pegs(7, 5, 9.0), 1.0), 7, 0);
        let start = message::<PackingEnergy>(&discs);
        for part in 1..=10 {
            advance_to_count(&mut discs, 10_000 * part);
            let now = message::<PackingEnergy>(&discs);
            let exchanged = start.total + now.from_floor.abs() + now.dissipated;
            assert!(now.residual.abs() < 1e-12 * exchanged, "{now:?}");
        }
        let now = message::<PackingEnergy>(&discs);
        println!("{now:?}");
        assert!(now.dissipated > 0.1 * start.total);
        assert!((now.total - start.total - now.from_floor).abs() > 0.1 * start.total, "control");
    }
}

/// One disc that rebounds from an obstacle straight below it: h' = e² h, by 2 sqrt(2 h/g) (1 + 2 e + 2 e² + …) until it lies there, which has its name;
/// elastic rebounds, and slow ones by a guard, go on.
#[test]
fn rebounds_on_top_of_an_obstacle_are_found_and_a_collapse_is_named() {
    let above = |e: f64, height: f64| {
        let start = given(&[[0.0, height - 2.0, 0.0, 0.0]]);
        with_obstacles(with_gravity(with_restitution(start, e), 0.5), &[[0.0, -5.0]], 2.0)
    };
    // 1e-12 per rebound, as from a floor.
    for height in [1.0, 1e-4, 1e-8] {
        let mut disc = prepare(&above(1.0, height), 1, 0);
        let period = 2.0 * (2.0 * height / 0.5_f64).sqrt();
        advance_to_time(&mut disc, 1000.25 * period);
        assert_eq!(disc.count(), 1000);
        let found = disc_states(&disc)[0].position;
        let error = found[1] + 2.0 - 0.75 * height;
        assert!(error.abs() < 1e-9 && found[0].abs() < 1e-13, "{height}: {error:e} {found:?}");
    }
    let collapse = 2.0 * (2.0_f64 / 0.5).sqrt() * (0.5 + 0.5 / 0.5);
    let mut disc = prepare(&above(0.5, 1.0), 1, 0);
    advance_to_time(&mut disc, 0.999 * collapse);
    let fault = format!("{:?}", disc.advance(Target::Time(1000.0), u64::MAX).unwrap_err());
    assert!(
        fault.contains("inelastic collapse") && (disc.time() / collapse - 1.0).abs() < 1e-6,
        "{fault}"
    );
    let guarded = PackingConfig {
        collapse_guard: CollapseGuard::CutoffVelocity(Positive::literal(1e-3)),
        ..above(0.5, 1.0)
    };
    advance_to_time(&mut prepare(&guarded, 1, 0), 1000.0);
    // In the corner of two obstacles, and below one, discs do not stop.
    let corner = given(&[[0.1, 3.0, 0.0, 0.0], [0.0, -3.5, 0.0, 1.0]]);
    let corner = with_obstacles(with_gravity(corner, 0.5), &[[-1.5, 0.0], [1.5, 0.0]], 1.5);
    advance_to_time(&mut prepare(&corner, 1, 0), 1000.0);
}

/// The laws of a fluid do not hold among obstacles, and say so; energy is conserved, and the velocities are those of a fixed energy.
#[test]
fn laws_of_a_fluid_are_not_compared_among_obstacles() {
    let analyzed = |keys: &str| {
        let manifest = format!(
            "seed = 3\n[model.packing]\nboundary = \"periodic\"\n{keys}events_per_disc = 200\n[record]\nframes = 100\n"
        );
        let experiment: kinetoscope::Experiment = manifest.parse().unwrap();
        kinetoscope_analysis::analyze(&kinetoscope::run(&experiment.runs[0]).unwrap()).unwrap()
    };
    let pegs = "obstacles = { positions = [[-9.0, 1.0], [3.0, 8.0], [9.0, -7.0]], radius = 3.0 }\n";
    let [among, free] = [pegs, ""].map(analyzed);
    let theory = |analysis: &kinetoscope_analysis::RunAnalysis, name: &str| {
        analysis.measurement(name).unwrap_or_else(|| panic!("{name}")).theory.unwrap()
    };
    for name in [
        "compressibility_factor",
        "pair_collision_rate_per_disc",
        "mean_free_time",
        "contact_value.from_collision_rate",
    ] {
        let why = theory(&among, name).violation.unwrap().to_string();
        assert_eq!(why, "there are obstacles", "{name}");
        assert!(theory(&free, name).in_range(), "control: {name}");
    }
    assert!(among.measurement("pair_correlation.near_contact").is_none());
    assert!(free.measurement("pair_correlation.near_contact").is_some(), "control");
    // Obstacles take up momentum: -1/(N + 1) in place of -1/N.
    assert!((theory(&among, "a2.mean").value + 1.0 / 51.0).abs() < 1e-12);
    assert!((theory(&free, "a2.mean").value + 1.0 / 50.0).abs() < 1e-12);
    let drift = among.measurement("energy.drift_relative").unwrap();
    assert!(drift.estimate.value.abs() < 1e-12 && drift.theory.unwrap().in_range());
}

#[test]
fn starts_that_overlap_obstacles_are_rejected_and_random_ones_avoid_them() {
    let seed = Seed { seed: 1, replicate: 0 };
    let message = |config: &PackingConfig| {
        format!("{:?}", Packing::prepare(config, seed, false).unwrap_err())
    };
    let inside = with_obstacles(given(&[[1.0, 2.0, 0.0, 1.0]]), &[[9.0, 9.0], [1.0, 0.5]], 2.0);
    let rejected = message(&inside);
    assert!(
        rejected.contains("disc 0 at [1, 2] overlaps the obstacle at [1.0, 0.5]"),
        "{rejected}"
    );
    assert!(rejected.contains("1.5 apart") && rejected.contains("they touch at 3"), "{rejected}");
    // Gravity presses a disc that lies on an obstacle; below one, or with a velocity away from it, it leaves.
    let at_peg = |y: f64, speed: f64| {
        let disc = with_obstacles(given(&[[1.0, y, 0.0, speed]]), &[[1.0, 0.5]], 2.0);
        with_gravity(disc, 0.1)
    };
    let rejected = message(&at_peg(3.5, 0.0));
    assert!(rejected.contains("lies on the obstacle at [1.0, 0.5]"), "{rejected}");
    for (y, speed) in [(3.5, 1.0), (3.6, 0.0), (-2.5, 0.0)] {
        prepare(&at_peg(y, speed), 1, 0).advance(Target::Time(1.0), u64::MAX).unwrap();
    }
    // In a wedge, it must leave both obstacles.
    let wedge = |velocity: [f64; 2]| {
        let disc = given(&[[0.0, 5.0_f64.sqrt(), velocity[0], velocity[1]]]);
        with_gravity(with_obstacles(disc, &[[-2.0, 0.0], [2.0, 0.0]], 2.0), 0.1)
    };
    let rejected = message(&wedge([0.1 * 5.0_f64.sqrt(), 0.2]));
    assert!(rejected.contains("lies on the obstacle at [2.0, 0.0]"), "{rejected}");
    prepare(&wedge([0.0, 0.2]), 1, 0).advance(Target::Time(0.1), u64::MAX).unwrap();
    // A periodic image overlaps.
    let image = with_obstacles(given(&[[19.5, 0.0, 1.0, 0.0]]), &[[-19.0, 0.0]], 1.0);
    prepare(
        &PackingConfig {
            boundary: Boundary::Walls,
            ..with_obstacles(given(&[[18.5, 0.0, 1.0, 0.0]]), &[[-19.0, 0.0]], 1.0)
        },
        1,
        0,
    );
    let periodic = PackingConfig { boundary: Boundary::Periodic, ..image };
    assert!(
        message(&periodic).contains("overlaps the periodic image of the obstacle at [21.0, 0.0]"),
        "{}",
        message(&periodic)
    );
    // No room is left.
    let full = with_obstacles(without_noise(at_fraction(20, 0.4)), &pegs(4, 4, 3.2), 1.0);
    assert!(message(&full).contains("walls and obstacles take room"), "{}", message(&full));
}

#[test]
fn obstacles_beyond_a_periodic_edge_are_drawn_as_their_images() {
    let drawn = |center, is_periodic| drawn_obstacles(&[center], 2.0, [40.0, 20.0], is_periodic);
    assert_eq!(drawn([-19.0, 0.0], false), [[-19.0, 0.0]]);
    assert_eq!(drawn([-19.0, 0.0], true), [[-19.0, 0.0], [21.0, 0.0]]);
    assert_eq!(drawn([17.0, 0.0], true), [[17.0, 0.0]]);
    let corner = [[19.0, 9.0], [19.0, -11.0], [-21.0, 9.0], [-21.0, -11.0]];
    assert_eq!(drawn([19.0, 9.0], true), corner);
}

#[test]
fn mean_height_has_no_theory_where_obstacles_keep_discs_from_the_floor() {
    let why = |pegs: u32| {
        let positions: Vec<String> =
            (0..pegs).map(|peg| format!("[{:?}, -9.0]", -10.0 + f64::from(peg))).collect();
        let manifest = format!(
            "seed = 3\n[model.packing]\ndiscs = 20\nradius = 0.5\nwidth = 20\nheight = 20\ngravity = 0.1\nfloor_temperature = 1.0\nduration = 3000\nobstacles = {{ positions = [{}], radius = 0.5 }}\n[record]\nframes = 100\n",
            positions.join(", ")
        );
        let experiment: kinetoscope::Experiment = manifest.parse().unwrap();
        let run = kinetoscope::run(&experiment.runs[0]).unwrap();
        let analysis = kinetoscope_analysis::analyze(&run).unwrap();
        let theory = analysis.measurement("height.mean").unwrap().theory.unwrap();
        theory.violation.map(|why| why.to_string()).unwrap_or_default()
    };
    assert_eq!(why(21), "obstacles keep discs from the floor or from a part of the box");
    assert_eq!(why(1), "", "control");
}
