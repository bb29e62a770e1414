//! Law: the exact two-body motion is a conic with the Sun in its focus (Kepler's first law), sweeps equal areas in
//! equal times (second), and has P^2 = 4 pi^2 a^3 / GM (third), at any time, forward and backward.
//!
//! Source: elements and positions in 50-digit arithmetic from Kepler's equation in the eccentric anomaly, M = E - e sin
//! E, or its hyperbolic counterpart, solved by bisection; the program uses universal variables instead.
//! Setup: the initial state of the orbit exercise, the heliocentric one, a comet, a near-parabola, an inbound
//! hyperbola, a fast pass of the Sun, and a fall that misses the Sun by 1.7e-7 AU.
//! Tolerance: stated at each test.
//! Control: a velocity changed by 1e-9, a period changed by 1e-9, and areas of unequal times are rejected.

// Closed forms may use std's functions; reference values keep all their digits.
#![allow(clippy::disallowed_methods, clippy::excessive_precision)]

use crate::run::{distance, exercise, finished, observe, prepare};
use kinetoscope_manifest::model::{OrbitConfig, OrbitIntegrator};
use kinetoscope_physics::orbit::elements::Elements;
use kinetoscope_physics::orbit::kepler::Kepler;
use kinetoscope_physics::orbit::motion::{State, angular_momentum, cross, energy, length};
use kinetoscope_physics::orbit::{BARYCENTRIC_START, HELIOCENTRIC_START};
use std::f64::consts::TAU;

fn is_close(value: f64, expected: f64, relative: f64) -> bool {
    (value - expected).abs() <= relative * expected.abs()
}

/// Reference values: 50-digit arithmetic.
/// Tolerance: a few roundings of 1.1e-16, relative; absolute for the eccentricity, which is a difference of numbers
/// near one.
#[test]
fn elements_of_the_exercise_equal_the_reference() {
    let elements = Elements::of(BARYCENTRIC_START);
    let bound = elements.bound.unwrap();
    assert!(is_close(elements.semi_major_axis, 0.994_180_472_778_547_646_0, 2e-15));
    assert!((elements.eccentricity - 0.013_193_509_473_117_573_577_84).abs() < 1e-15);
    assert!(is_close(bound.period, 362.073_107_968_315_865_9, 2e-15));
    assert!(is_close(elements.energy, -0.000_148_822_178_837_004_190_357_3, 2e-15));
    assert!(is_close(elements.angular_momentum, 0.017_150_478_995_890_239_882_62, 1e-15));
    assert!(is_close(elements.perihelion, 0.981_063_743_292_955_43, 2e-15));
    assert!(is_close(bound.aphelion, 1.007_297_202_264_139_96, 2e-15));
    assert!(is_close(elements.inclination, 6.982_815_256_000_648e-5, 2e-15));
    // The reference has 13 digits here.
    assert!(is_close(bound.mean_anomaly.to_degrees(), 5.130_364_713_432, 1e-12));
    let heliocentric = Elements::of(HELIOCENTRIC_START);
    assert!(is_close(heliocentric.semi_major_axis, 0.999_345_417_141_490_3, 2e-15));
    assert!(is_close(heliocentric.bound.unwrap().period, 364.898_320_698_051_443_9, 2e-15));
}

/// Tolerance: half of the last digit of 364.898 days. Control: the start of the exercise has 362.073 days.
#[test]
fn default_year_is_364_898_days() {
    let period =
        |config: &OrbitConfig| Elements::of(observe(&prepare(config)).state).bound.unwrap().period;
    assert!((period(&OrbitConfig::default()) - 364.898).abs() < 5e-4);
    let control = exercise(OrbitIntegrator::VelocityVerlet, 0.25, 365.25);
    assert!((period(&control) - 362.073).abs() < 5e-4);
}

/// Ascending node, argument of the perihelion and true anomaly in 50-digit arithmetic from r x v and the eccentricity
/// vector.
/// Tolerance: about ten roundings of 2e-16, amplified by 1/e and 1/sin i: 76 and 14000 for the orbit of the exercise.
#[test]
fn angles_of_osculating_orbits_equal_the_reference() {
    let references = [
        (
            BARYCENTRIC_START,
            [-2.962_442_301_566_341, -1.656_022_888_431_26, 0.091_940_716_183_333_51],
            1e-11,
        ),
        (
            State { position: [0.587, 0.2, -0.1], velocity: [0.004, 0.0314, 0.013] },
            [0.620_543_891_099_320_1, -0.919_258_584_871_308_1, 0.587_312_257_678_012],
            5e-15,
        ),
        (
            State { position: [1.2, -0.3, 0.4], velocity: [0.003, 0.002, -0.016] },
            [2.947_970_660_733_847_9, -2.571_754_663_068_230_5, -0.886_656_465_302_702_6],
            5e-15,
        ),
    ];
    for (start, expected, tolerance) in references {
        let elements = Elements::of(start);
        let angles =
            [elements.ascending_node, elements.argument_of_perihelion, elements.true_anomaly];
        for (angle, expected) in angles.iter().zip(expected) {
            assert!((angle - expected).abs() < tolerance, "{angle} {expected}");
        }
        // Control.
        let changed = State { velocity: start.velocity.map(|v| v * (1.0 + 1e-9)), ..start };
        assert!((Elements::of(changed).true_anomaly - expected[2]).abs() > tolerance);
    }
}

/// In the plane z = 0, the ascending node is undefined; its angle is set to zero, and the perihelion is measured from
/// the x axis.
#[test]
fn orbit_in_the_reference_plane_has_zero_ascending_node() {
    let start = State { position: [0.0, 0.8, 0.0], velocity: [-0.02, 0.0, 0.0] };
    let elements = Elements::of(start);
    assert_eq!((elements.inclination, elements.ascending_node), (0.0, 0.0));
    assert!((elements.argument_of_perihelion - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
    assert!(elements.true_anomaly.abs() < 1e-15);
}

/// Tolerance: 1e-12 AU. After a hundred revolutions, a rounding of the period, 2e-16 of it, has grown to 1.3e-13 rad.
#[test]
fn position_of_the_earth_equals_the_reference_for_a_century() {
    let references = [
        (
            365.25,
            [
                -0.235_581_131_349_202_767_76,
                0.952_503_897_764_050_857_39,
                -6.837_841_885_922_249_3e-5,
            ],
        ),
        (
            36_525.0,
            [
                0.558_531_684_740_465_315_71,
                0.810_190_907_330_808_890_48,
                -4.871_892_065_661_585_4e-5,
            ],
        ),
    ];
    for (duration, expected) in references {
        let run = finished(&exercise(OrbitIntegrator::Kepler, 0.25, duration));
        let found = observe(&run);
        let error = distance(found.state.position, expected);
        println!("{duration} d: {error:e} AU");
        assert!(error < 1e-12, "{duration} d: {error:e} AU");
        assert_eq!(found.orbit.position_error_au, 0.0);
        assert!(found.orbit.phase_error_rad.abs() < 2e-15);
        assert!(found.energy.drift_ppm.abs() < 1e-8);
    }
    let faster = State {
        velocity: BARYCENTRIC_START.velocity.map(|v| v * (1.0 + 1e-9)),
        ..BARYCENTRIC_START
    };
    let control = distance(Kepler::from_start(faster).at(36_525.0).state.position, references[1].1);
    assert!(control > 1e-12, "control: a velocity changed by 1e-9: {control:e}");
}

/// One conic: initial state, and time (days), position, velocity and angle traversed at several points (50-digit
/// arithmetic).
struct Reference {
    name: &'static str,
    start: State,
    /// Amplification of the rounding of the initial state: |a| / r0 from a perihelion to the far end, r0 / q through a
    /// pass of the Sun, otherwise 1.
    sensitivity: f64,
    points: &'static [(f64, [f64; 3], [f64; 3], f64)],
}

const COMET: Reference = Reference {
    name: "a comet, e = 0.974",
    start: State { position: [0.587, 0.0, 0.0], velocity: [0.0, 0.0314, 0.003] },
    sensitivity: 38.0,
    points: &[
        (
            100.0,
            [-0.78349591827857314731, 1.746499634413958529, 0.16686302239623809353],
            [-0.014592662740051758801, 0.0090035952658510644972, 0.00086021610820233109321],
            1.9907989467105385493,
        ),
        (
            19000.0,
            [-44.044474655069084796, 0.10696578432590780124, 0.010219660922857434312],
            [-0.000038989465976304761889, -0.00041838686022494209003, -0.000039973266900472178402],
            3.139153013582452978,
        ),
        (
            27000.0,
            [-39.311919239800782458, -3.1182677569623974168, -0.2979236710473628418],
            [0.0012694333979592229528, -0.00036816739160572925089, -0.000035175228497362670975],
            3.2211070352652576267,
        ),
        (
            80000.0,
            [-19.101380097280331881, 5.0266654549193157341, 0.48025466129802384666],
            [-0.0040845296592541708434, 0.00010992735221604604853, 0.00001050261326904898663],
            15.449519816258673179,
        ),
    ],
};
const INBOUND: Reference = Reference {
    name: "a hyperbola, e = 1.54, inbound at first",
    start: State { position: [3.0, 1.0, 0.5], velocity: [-0.02, -0.001, 0.002] },
    sensitivity: 5.0,
    points: &[
        (
            100.0,
            [0.78160875308914068325, 0.79628675604854805009, 0.63450389494434806431],
            [-0.025715152133273069891, -0.0044480503317782194541, -0.00040476029266287273748],
            0.57062960021808168102,
        ),
        (
            200.0,
            [-1.3457972721030448607, -0.59445558312661372884, -0.36157624410401220645],
            [-0.010177788666396514916, -0.017127574690801775056, -0.01462333666981394786],
            3.2665098452832250339,
        ),
        (
            1000.0,
            [-5.2046403990624425326, -10.77773516330642326, -9.3783624479556862253],
            [-0.0040424633425233763135, -0.011637422505501468183, -0.010358388337159708832],
            4.0198899768451735922,
        ),
        (
            -400.0,
            [10.059387226539714859, 1.1695630781768553923, -0.37855640091291769832],
            [-0.016540614559485856053, -0.00023314462663705762453, 0.0022130130807365716553],
            -0.28258969230726873575,
        ),
    ],
};
const NEAR_PARABOLA: Reference = Reference {
    name: "nearly a parabola, e = 1.002",
    start: State { position: [1.0, 0.0, 0.0], velocity: [0.001, 0.02432, 0.0] },
    sensitivity: 1.0,
    points: &[
        (
            50.0,
            [0.75108114590408866312, 1.1094758285886208458, 0.0],
            [-0.0090757581100875628841, 0.018973536785545252149, 0.0],
            0.97569496179234421754,
        ),
        (
            1000.0,
            [-7.6091363618444495682, 6.718586667720557423, 0.0],
            [-0.0070533720104653823252, 0.0030317095206313565209, 0.0],
            2.418270335307142104,
        ),
        (
            -300.0,
            [-2.4106060944936236071, -3.3544067960841539781, 0.0],
            [0.010880672335843358634, 0.0050519250146822443351, 0.0],
            -2.1939221776662108168,
        ),
    ],
};
const FAST_PASS: Reference = Reference {
    name: "a fast pass of the Sun, whose bracket of X overflows",
    start: State { position: [0.01, 0.0, 0.0], velocity: [-1.0, 0.3, 0.0] },
    sensitivity: 5.0,
    points: &[
        (
            0.02,
            [-0.010961812427873183421, 0.0040544644294425584496, 0.0],
            [-1.0342176162704433802, 0.10885047936392131157, 0.0],
            2.7873255713221231407,
        ),
        (
            1000.0,
            [-1010.0236015462490345, 103.23878891588109578, 0.0],
            [-1.0100298878442442488, 0.10323646123739456282, 0.0],
            3.0397321740761852254,
        ),
        (
            -1000.0,
            [971.28314000255007111, -295.72411714510705313, 0.0],
            [-0.97127024229474343768, 0.2957232789103835408, 0.0],
            -0.2955503316206855299,
        ),
    ],
};
const FALL: Reference = Reference {
    name: "a fall, e = 1 - 3.4e-7",
    start: State { position: [1.0, 0.0, 0.0], velocity: [0.0, 1e-5, 0.0] },
    sensitivity: 1.0,
    points: &[
        (
            30.0,
            [0.86026646580577112115, 0.00028503643729158433457, 0.0],
            [-0.0098046082589922970458, 8.3756948331913648018e-6, 0.0],
            0.00033133504349015174294,
        ),
        (
            60.0,
            [0.28406860850699365773, 0.00037074984104228766235, 0.0],
            [-0.03862070902591080807, -0.000015202741883359325442, 0.0],
            0.0013051411505125499963,
        ),
        (
            64.5,
            [0.018425283030014693271, 0.00011056159023662096942, 0.0],
            [-0.17756001507474623807, -0.00052272291358634584285, 0.0],
            0.0060004648562880624759,
        ),
    ],
};

/// Tolerance: a rounding of the velocity, 1e-16 of it, changes the position by that fraction of (v t + r); ten times
/// that, multiplied by the amplification of the initial state.
#[test]
fn every_kind_of_conic_equals_the_reference() {
    for reference in [COMET, INBOUND, NEAR_PARABOLA, FAST_PASS, FALL] {
        let exact = Kepler::from_start(reference.start);
        for &(time, position, velocity, angle) in reference.points {
            let point = exact.at(time);
            let speed = length(velocity);
            let allowed = 1e-15 * reference.sensitivity * (length(position) + speed * time.abs());
            let error = distance(point.state.position, position);
            println!("{}, {time} d: {error:e} of {allowed:e} AU", reference.name);
            assert!(error < allowed, "{}, {time} d: {error:e} AU", reference.name);
            let traversed = point.turns as f64 * std::f64::consts::TAU + point.angle;
            let angle_error = (traversed - angle).abs();
            assert!(angle_error < 10.0 * allowed / length(position), "{angle_error:e}");
            let drift = (energy(point.state) - energy(reference.start)).abs();
            assert!(drift < 1e-14 * speed * speed, "{drift:e}");
            // The velocity changes by its own magnitude over a distance |r|, and it is a sum that contains v0.
            let velocity_error = distance(point.state.velocity, velocity);
            assert!(
                velocity_error
                    < allowed / length(position) * speed + 1e-15 * length(reference.start.velocity),
                "{velocity_error:e}"
            );
        }
    }
}

/// The second law by triangles: r(t) x r(t + d) / d = L (1 - (d^2 GM / r^3) / 6 ...) at any position.
/// Tolerance: 5e-10 plus rounding. That term is 2.3e-10 for d = 2^-10 days (so that t + d is exact) and the smallest r,
/// 0.587 AU; the rounding of the product is 1e-16 r^2 / (d L) for each of a few operations.
#[test]
fn areas_are_equal_in_equal_times_and_the_plane_is_fixed() {
    const D: f64 = 1.0 / 1024.0;
    let exact = Kepler::from_start(COMET.start);
    let momentum = angular_momentum(COMET.start);
    for step in 0..200 {
        let time = 500.0 * f64::from(step);
        let [here, there] = [exact.at(time).state, exact.at(time + D).state];
        let area = cross(here.position, there.position).map(|component| component / D);
        let rounding = 1e-16 * length(here.position).powi(2) / (D * length(momentum));
        let error = distance(area, momentum) / length(momentum);
        assert!(error < 5e-10 + 40.0 * rounding, "{time} d: {error:e}");
    }
    let [here, there] = [0.0, 1.0].map(|day| exact.at(19_000.0 + day).state.position);
    let control = exact.at(19_001.1).state.position;
    let [area, other] = [there, control].map(|end| length(cross(here, end)));
    assert!((other / area - 1.1).abs() < 1e-3, "control: 10 % more time sweeps 10 % more area");
}

/// P is compared with the motion itself: the body has returned after 100 periods.
/// Tolerance: 1e-13 of the distance traveled.
#[test]
fn period_follows_keplers_third_law() {
    for start in [BARYCENTRIC_START, HELIOCENTRIC_START, COMET.start] {
        let elements = Elements::of(start);
        let a = elements.semi_major_axis;
        let gm = kinetoscope_physics::constants::GM_SUN_AU3_PER_DAY2;
        let period = (4.0 * std::f64::consts::PI.powi(2) * a.powi(3) / gm).sqrt();
        // Shortly before and shortly after the return, so that the reduction of the time does not hide a wrong period.
        let exact = Kepler::from_start(start);
        let offset = 1e-3;
        for side in [-offset, offset] {
            let point = exact.at(100.0 * period + side);
            let expected = exact.at(side);
            let error = distance(point.state.position, expected.state.position);
            assert!(error < 1e-13 * 100.0 * period * length(start.velocity), "{error:e}");
            assert_eq!(point.turns, 100);
        }
        let late = exact.at(100.0 * period * (1.0 + 1e-9)).state.position;
        assert!(distance(late, start.position) > 1e-9, "control");
    }
}

/// Tolerance: 1e-13 of the distance traveled, as for the points of the conics.
#[test]
fn backward_motion_returns_to_the_initial_state() {
    for reference in [COMET, INBOUND, NEAR_PARABOLA] {
        for time in [1e-6, 3.0, 77.0, 800.0] {
            let there = Kepler::from_start(reference.start).at(time).state;
            let back = Kepler::from_start(there).at(-time).state;
            let error = distance(back.position, reference.start.position);
            assert!(
                error < 1e-13 * (1.0 + time * length(there.velocity)),
                "{} {error:e}",
                reference.name
            );
        }
    }
}

/// A circle has no direction of the perihelion.
/// Tolerance: 1e-14 of the angle v t / r, and 2e-15 for the radius.
#[test]
fn circular_motion_is_uniform() {
    let speed = kinetoscope_physics::constants::GM_SUN_AU3_PER_DAY2.sqrt();
    let exact =
        Kepler::from_start(State { position: [1.0, 0.0, 0.0], velocity: [0.0, speed, 0.0] });
    for day in [0.0, 1.0, 100.0, 182.0, 183.0, 365.0, 366.0, 3_652.5] {
        let point = exact.at(day);
        let angle = point.turns as f64 * std::f64::consts::TAU + point.angle;
        // On a circle of radius 1 AU, the angle is v t / r.
        assert!((angle - speed * day).abs() < 1e-15 * (1.0 + 10.0 * speed * day), "{day}: {angle}");
        assert!((length(point.state.position) - 1.0).abs() < 2e-15);
    }
}

/// Law: Kepler's equation, M = E - e sin E, with cos E = (a - r)/(a e) of the position at every time.
/// Setup: ellipses with a = 2 AU from the perihelion, 20,000 times in ten periods. At 2611.5 days in that of e = 0.5, Newton's method
/// alternates between two points for ever.
/// Tolerance: roundings of 2e-16 of the phase of ten periods, amplified by 1/(1 - e) near the perihelion. Control: a phase that is
/// changed by 1e-9.
#[test]
fn every_time_of_an_ellipse_has_its_position() {
    let gm = kinetoscope_physics::constants::GM_SUN_AU3_PER_DAY2;
    let axis = 2.0;
    let mean_motion = (gm / (axis * axis * axis)).sqrt();
    for e in [0.1, 0.5, 0.9, 0.99] {
        let perihelion = axis * (1.0 - e);
        let speed = (gm * (2.0 / perihelion - 1.0 / axis)).sqrt();
        let orbit = Kepler::from_start(State {
            position: [perihelion, 0.0, 0.0],
            velocity: [0.0, speed, 0.0],
        });
        let period = TAU / mean_motion;
        let times = (0..20_000).map(|step| f64::from(step) * period / 2000.0).chain([2611.5]);
        for time in times {
            let [x, y, _] = orbit.at(time).state.position;
            let cosine = x / axis + e;
            let sine = y / (axis * (1.0 - e * e).sqrt());
            let anomaly = sine.atan2(cosine);
            let phase = |time: f64| {
                let difference = anomaly - e * sine - mean_motion * time;
                (difference - TAU * (difference / TAU).round()).abs()
            };
            assert!(phase(time) < 1e-12 / (1.0 - e), "e = {e}, {time} days: {:e}", phase(time));
            assert!(phase(time + 1e-9 / mean_motion) > 1e-10);
        }
    }
}
