//! Law: in gravity, discs fly on parabolas, x = x0 + v t - g t^2/2 along y, and collide when these touch. Energy is conserved: kinetic and
//! potential energy plus what collisions have dissipated minus what the floor has added is constant.
//!
//! Source: free fall. REFERENCES: `python3 tests/interop/discs_in_gravity.py`, which computes with 50 digits, by the textbook's quadratic
//! formula, without cells and local times.
//! Setup: three discs in a box of 10 x 10, with the floor at rest and shaken, with and without restitution; a disc that bounces on
//! the floor; hundreds of discs.
//! Tolerance: 1e-11 after up to 26 collisions, in which a difference at the start grows 400 to 7000 times, by the same program;
//! energies to 1e-12 of the energy exchanged.
//! Control: gravity that is stronger by 1e-9 is rejected; kinetic and potential energy alone change.

#![allow(clippy::disallowed_methods, clippy::excessive_precision, clippy::unwrap_used)]

use crate::runs::{
    DiscState, advance_to_count, advance_to_time, at_fraction, disc_states, distance, given,
    message, prepare, with_duration, with_restitution, without_noise,
};
use kinetoscope_manifest::model::{CollapseGuard, PackingConfig, PackingPlacement, Shaking};
use kinetoscope_manifest::quantity::{BoxSide, NonNegative, Positive};
use kinetoscope_physics::model::{Model as _, Target};
use kinetoscope_physics::packing::Packing;
use kinetoscope_physics::random::Seed;
use kinetoscope_recording::channels::{PackingCollisions, PackingEnergy, PackingTemperature};

const SHAKEN: Shaking = Shaking { stroke: Positive::literal(0.5), period: Positive::literal(2.0) };

pub(crate) fn with_gravity(config: PackingConfig, gravity: f64) -> PackingConfig {
    PackingConfig { gravity: NonNegative::new(gravity).unwrap(), ..config }
}

/// Restitution, floor, time, number of collisions, and the state at the end.
type Reference = (f64, Option<Shaking>, f64, u64, [[f64; 4]; 3]);

const REFERENCES: [Reference; 6] = [
    (
        1.0,
        None,
        10.0,
        9,
        [
            [-2.6907506277495803, -3.6243755999125229, 1.6216724681755763, -0.54653462741204639],
            [3.4085442143774882, -1.1993207065914859, 1.5646906124420448, -0.88325829042440862],
            [-0.99291531353430085, -2.2079349108208897, -1.1254559140076827, -0.2879307256151567],
        ],
    ),
    (
        1.0,
        None,
        20.0,
        20,
        [
            [-2.3056212602295991, -2.1435404469965258, 0.10600829223451037, 0.58314522744287034],
            [0.59309127470365219, -1.4722684869931599, -1.6024938712522028, -0.79152752945493954],
            [2.7300958969829008, -0.071841365014609998, -0.67641173487555772, -1.2234209384865986],
        ],
    ),
    (
        0.75,
        None,
        10.0,
        9,
        [
            [-2.977554146161816, -3.6728558605539359, 1.624138993194207, -0.51875699306533274],
            [3.1208239551827606, -0.65133606438855585, 1.3547567255773423, -0.33068206478424689],
            [0.71345398617409506, -3.6089505051029054, -0.57775078090669796, -1.1678695414588209],
        ],
    ),
    (
        0.75,
        None,
        20.0,
        26,
        [
            [-2.2571789657883605, -1.2774540656860494, 0.73769448557145589, -0.041269327890651429],
            [1.2420997692110478, -2.1597966713066703, 0.35169054156842106, -0.59570356221759335],
            [-3.4835891936244829, -3.8579426853153, -0.36851488297946422, -0.10740006032573512],
        ],
    ),
    (
        0.75,
        Some(SHAKEN),
        10.0,
        9,
        [
            [-3.7292395745015985, -0.46633744709579866, -0.46442696742744383, 0.57042818784529925],
            [3.0, -2.0, 1.25, -1.5],
            [0.94708658157680481, -2.4662000916943332, 1.6296176752111931, -0.54682698848132738],
        ],
    ),
    (
        0.75,
        Some(SHAKEN),
        14.0,
        16,
        [
            [-2.4130525557886262, -0.58462469571460174, 0.46442696742744383, -0.62957181215470082],
            [1.6293665677467459, 1.8487935040116004, -0.75956517046240379, 1.2792257153311826],
            [-2.2732750883696724, -2.8721276043325195, -1.2645334942871453, 0.24647409611154322],
        ],
    ),
];

fn three_discs(restitution: f64, shaking: Option<Shaking>, gravity: f64) -> PackingConfig {
    let discs = [[-2.5, -3.25, 0.75, 0.5], [1.5, -2.0, -1.25, 1.5], [0.25, 2.5, 0.5, -0.25]];
    PackingConfig {
        width: BoxSide::literal(10.0),
        height: BoxSide::literal(10.0),
        shaking,
        ..with_gravity(with_restitution(given(&discs), restitution), gravity)
    }
}

fn error(discs: &[DiscState], expected: &[[f64; 4]]) -> f64 {
    let pairs = discs.iter().zip(expected).flat_map(|(disc, row)| {
        let state = [disc.position, disc.velocity].concat();
        state.into_iter().zip(*row).collect::<Vec<_>>()
    });
    pairs.fold(0.0, |most, (found, expected)| f64::max(most, (found - expected).abs()))
}

#[test]
fn paths_equal_those_of_50_digits() {
    for (restitution, shaking, time, collisions, expected) in REFERENCES {
        let mut discs = prepare(&three_discs(restitution, shaking, 0.3), 1, 0);
        advance_to_time(&mut discs, time);
        let found = error(&disc_states(&discs), &expected);
        println!("{collisions} collisions: error {found:e}");
        assert!(found < 1e-11, "{found:e}");
        let counts = message::<PackingCollisions>(&discs);
        assert_eq!(counts.pair_collisions + counts.wall_collisions, collisions);
        let mut control = prepare(&three_discs(restitution, shaking, 0.3 * (1.0 + 1e-9)), 1, 0);
        advance_to_time(&mut control, time);
        assert!(error(&disc_states(&control), &expected) > 1e-10, "control");
    }
}

/// A disc that falls from rest at the height h bounces with the period 2 sqrt(2 h/g).
#[test]
fn bouncing_disc_returns_to_its_height() {
    let (gravity, height): (f64, f64) = (0.2, 10.0);
    let config = with_gravity(given(&[[0.5, height - 19.0, 0.0, 0.0]]), gravity);
    let mut disc = prepare(&config, 1, 0);
    let half = (2.0 * height / gravity).sqrt();
    for bounces in [1.0, 10.0, 1000.0, 100_000.0] {
        for (phase, fall) in [(0.0, 0.0), (0.5, 0.25)] {
            advance_to_time(&mut disc, (2.0 * bounces + phase) * half);
            let found = disc_states(&disc)[0];
            let expected = height * (1.0 - fall) - 19.0;
            assert!((found.position[1] - expected).abs() < 1e-12 * bounces + 1e-12, "{found:?}");
            assert!(found.position[0] == 0.5);
        }
        let counted = message::<PackingCollisions>(&disc).wall_collisions;
        assert_eq!(counted, bounces as u64);
    }
}

fn energy(packing: &Packing) -> PackingEnergy {
    message(packing)
}

/// Elastic discs of one size and of several, from dilute to dense, keep their energy, stay apart and inside.
#[test]
fn elastic_discs_keep_their_energy() {
    let several = PackingConfig {
        radius_half_width: NonNegative::literal(0.3),
        ..without_noise(at_fraction(200, 0.2))
    };
    let dense = PackingConfig {
        placement: PackingPlacement::Compressed,
        ..without_noise(at_fraction(300, 0.6))
    };
    let scenes = [
        (at_fraction(200, 0.3), 0.05),
        (without_noise(at_fraction(1000, 0.01)), 0.01),
        (several, 0.3),
        (dense, 0.1),
    ];
    for (config, gravity) in scenes {
        let mut discs = prepare(&with_gravity(config.clone(), gravity), 4, 0);
        let start = energy(&discs);
        for part in 1..=10 {
            advance_to_count(&mut discs, part * 10_000);
            let (states, now) = (disc_states(&discs), energy(&discs));
            assert!(now.residual.abs() < 1e-12 * start.total, "{now:?}");
            assert_eq!((now.from_floor, now.dissipated), (0.0, 0.0));
            for (one, disc) in states.iter().enumerate() {
                let limit = [config.width.get(), config.height.get()];
                for (axis, limit) in limit.into_iter().enumerate() {
                    let outside = disc.position[axis].abs() + disc.radius - limit / 2.0;
                    assert!(outside < 1e-12 * limit, "{disc:?}");
                }
                for other in &states[..one] {
                    let gap = distance(disc.position, other.position) - disc.radius - other.radius;
                    assert!(gap > -1e-12 * limit[0], "{gap:e}");
                }
            }
        }
        assert!((energy(&discs).kinetic - start.kinetic).abs() > 1e-3 * start.total, "control");
    }
}

/// The work of a shaken floor and the heat of one with a temperature, less what collisions dissipate, is the change of the energy.
#[test]
fn floor_and_dissipation_balance_the_energy() {
    let driven = PackingConfig {
        collapse_guard: CollapseGuard::CutoffVelocity(Positive::literal(1e-4)),
        ..with_gravity(with_restitution(without_noise(at_fraction(200, 0.2)), 0.9), 0.2)
    };
    let strong = Shaking { stroke: Positive::literal(3.0), period: Positive::literal(4.0) };
    let fast = Shaking { stroke: Positive::literal(0.02), period: Positive::literal(0.01) };
    for (shaking, temperature) in
        [(Some(SHAKEN), None), (Some(strong), None), (Some(fast), None), (None, Some(3.0))]
    {
        let floor_temperature = temperature.and_then(Positive::new);
        let config = PackingConfig { shaking, floor_temperature, ..driven.clone() };
        let mut discs = prepare(&config, 6, 0);
        let start = energy(&discs);
        for part in 1..=10 {
            advance_to_count(&mut discs, 10_000 * part);
            let now = energy(&discs);
            let exchanged = start.total + now.from_floor.abs() + now.dissipated;
            assert!(now.residual.abs() < 1e-12 * exchanged, "{now:?}");
        }
        let now = energy(&discs);
        println!("{now:?}");
        assert!((now.total - start.total - now.from_floor).abs() > 0.1 * start.total, "control");
        assert!(now.from_floor > 0.1 * start.total && now.dissipated > 0.1 * start.total);
    }
}

/// The integrals of the kinetic energy and of a2 since the start are those of a sum over short times.
#[test]
fn integrals_include_the_fall_between_collisions() {
    let config = with_gravity(without_noise(at_fraction(20, 0.05)), 0.3);
    let mut discs = prepare(&with_duration(config, 10.0), 3, 0);
    let read = |discs: &Packing| {
        let now = message::<PackingTemperature>(discs);
        (now.kinetic_energy, now.a2, now.a2_time_integral)
    };
    let (mut kinetic, mut a2, step) = (0.0, 0.0, 10.0 / 65_536.0);
    let mut before = read(&discs);
    for index in 1..=65_536 {
        advance_to_time(&mut discs, step * f64::from(index));
        let now = read(&discs);
        kinetic += 0.5 * (before.0 + now.0) * step;
        a2 += 0.5 * (before.1 + now.1) * step;
        before = now;
    }
    let pressure = message::<kinetoscope_recording::channels::PackingPressure>(&discs);
    let measured = pressure.kinetic_energy_time_integral;
    println!("{measured} {kinetic}, {} {a2}", before.2);
    // The trapezoidal rule neglects collisions within its steps.
    assert!((measured / kinetic - 1.0).abs() < 1e-6);
    assert!((before.2 - a2).abs() < 1e-4);
    // Control: with the kinetic energy at the start.
    let first = message::<PackingTemperature>(&prepare(
        &with_gravity(without_noise(at_fraction(20, 0.05)), 0.3),
        3,
        0,
    ));
    assert!((first.kinetic_energy * 10.0 / kinetic - 1.0).abs() > 1e-2);
}

#[test]
fn discs_that_cannot_fall_are_rejected_and_a_collapse_is_named() {
    let on_floor = with_gravity(given(&[[0.0, -19.0, 1.0, 0.0]]), 1.0);
    let seed = Seed { seed: 1, replicate: 0 };
    let message = format!("{:?}", Packing::prepare(&on_floor, seed, false).unwrap_err());
    assert!(message.contains("disc 0 at [0.0, -19.0] lies on the floor"), "{message}");
    assert!(message.contains("move its center above -19"), "{message}");
    let below = with_gravity(given(&[[0.0, -19.5, 1.0, 1.0]]), 1.0);
    let message = format!("{:?}", Packing::prepare(&below, seed, false).unwrap_err());
    assert!(message.contains("not inside"), "{message}");
    // One disc above another one, which bounces on the floor.
    let column = with_gravity(given(&[[0.0, -18.0, 0.0, 0.0], [0.0, -15.0, 0.0, 0.0]]), 1.0);
    let mut discs = prepare(&with_restitution(column.clone(), 0.5), 1, 0);
    let fault = format!("{:?}", discs.advance(Target::Time(1000.0), u64::MAX).unwrap_err());
    assert!(fault.contains("inelastic collapse"), "{fault}");
    let guarded = PackingConfig {
        collapse_guard: CollapseGuard::CutoffVelocity(Positive::literal(1e-2)),
        ..with_restitution(column, 0.5)
    };
    advance_to_time(&mut prepare(&guarded, 1, 0), 1000.0);
}
