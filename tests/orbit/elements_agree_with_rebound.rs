//! Law: the elements of an ellipse and the position and velocity on it determine each other.
//!
//! Source: REBOUND 5.2.2 (Rein and Liu, A&A 537 (2012) A128), `benches/peers/orbit_elements_rebound.py`.
//! Setup: five ellipses around the Sun: nearly circular, inclined, retrograde, and of a comet like Halley's.
//! Tolerance: 1e-13 relative to the length of a vector, to the semi-major axis, and in rad. The input has 16 digits, and small
//! eccentricities and inclinations cost up to two of them.
//! Control: an eccentric anomaly in place of the mean anomaly, and a motion in the opposite sense, are rejected.

// An invalid configuration fails its test.
#![allow(clippy::unwrap_used)]

use crate::run::{distance, exercise, finished, prepare};
use kinetoscope_manifest::model::{
    OrbitBody, OrbitConfig, OrbitIntegrator, OrbitStart, OrbitState,
};
use kinetoscope_manifest::quantity::{Finite, NonNegative};
use kinetoscope_physics::constants::GM_SUN_AU3_PER_DAY2 as GM;
use kinetoscope_physics::model::Model;
use kinetoscope_physics::orbit::elements::{Anomaly, Elements, Ellipse};
use kinetoscope_physics::orbit::motion::{State, length};
use kinetoscope_recording::frame::Frame;

struct Reference {
    /// a in AU, e, inclination, node, argument of perihelion and true anomaly in rad.
    elements: [f64; 6],
    mean_anomaly: f64,
    position: [f64; 3],
    velocity: [f64; 3],
}

const REBOUND: [Reference; 5] = [
    Reference {
        elements: [0.999_345_4, 0.0167, 0.05, 2.1, 1.3, 0.7],
        mean_anomaly: 0.678_687_926_727_881_1,
        position: [-0.566_077_011_423_638_2, -0.806_637_175_478_373_4, 0.044_830_896_026_577_08],
        velocity: [
            0.014_148_458_684_433_741,
            -0.010_175_132_843_182_985,
            -0.000_354_105_431_071_289,
        ],
    },
    Reference {
        elements: [5.2, 0.0489, 0.3, -1.2, 2.5, -2.2],
        mean_anomaly: 4.163_975_155_655_706,
        position: [3.254_481_868_528_118, -4.209_510_695_290_882, 0.466_465_287_517_831_73],
        velocity: [0.005_272_288_209_979_817, 0.004_681_614_012_200_23, 0.002_044_835_671_604_69],
    },
    Reference {
        elements: [2.77, 0.2, 1.2, 0.4, -0.9, 1.9],
        mean_anomaly: 1.504_738_371_218_959_3,
        position: [1.077_257_203_176_354_8, 1.396_628_697_497_510_2, 2.229_737_800_980_024_6],
        velocity: [
            -0.007_642_994_275_729_994,
            -0.000_473_170_770_437_129_2,
            0.006_534_558_966_423_691,
        ],
    },
    Reference {
        elements: [17.8, 0.967, 2.83, 1.0, 1.96, 0.6],
        mean_anomaly: 0.002_725_773_347_275_861_6,
        position: [-0.007_366_258_674_698_048, -0.633_354_429_956_419_7, 0.108_221_790_905_925_78],
        velocity: [
            -0.027_899_916_505_948_648,
            -0.009_548_851_795_659_19,
            -0.005_899_847_998_300_732,
        ],
    },
    Reference {
        elements: [1.3, 0.7, 2.0, -2.5, -2.7, -1.1],
        mean_anomaly: 6.117_177_979_352_655,
        position: [0.242_196_446_132_025_15, 0.340_861_321_975_718_2, 0.279_971_442_088_057_7],
        velocity: [
            0.012_783_906_196_788_724,
            -0.006_074_972_110_908_834,
            -0.027_351_754_065_096_993,
        ],
    },
];

const TOLERANCE: f64 = 1e-13;

fn ellipse([a, e, inclination, node, argument, _]: [f64; 6], anomaly: Anomaly) -> Ellipse {
    Ellipse {
        semi_major_axis: a,
        eccentricity: e,
        inclination,
        ascending_node: node,
        argument_of_perihelion: argument,
        anomaly,
    }
}

/// Largest deviation of position and velocity relative to their lengths.
fn deviation(state: State, reference: &Reference) -> f64 {
    let [position, velocity] = [
        distance(state.position, reference.position) / length(reference.position),
        distance(state.velocity, reference.velocity) / length(reference.velocity),
    ];
    if position > velocity { position } else { velocity }
}

#[test]
fn vectors_follow_from_elements() {
    for reference in &REBOUND {
        let [_, e, .., anomaly] = reference.elements;
        for anomaly in [Anomaly::True(anomaly), Anomaly::Mean(reference.mean_anomaly)] {
            let found = deviation(ellipse(reference.elements, anomaly).state(GM), reference);
            println!("e = {e}, {anomaly:?}: {found:e}");
            assert!(found < TOLERANCE, "{anomaly:?}: {found:e}");
        }
        // Control: M + e sin M, the first iterate of Kepler's equation, in place of M.
        let wrong = reference.mean_anomaly + e * libm::sin(reference.mean_anomaly);
        let control =
            deviation(ellipse(reference.elements, Anomaly::Mean(wrong)).state(GM), reference);
        assert!(control > 1e3 * TOLERANCE, "{control:e}");
    }
}

#[test]
fn elements_follow_from_vectors() {
    for reference in &REBOUND {
        let state = State { position: reference.position, velocity: reference.velocity };
        let worst = |state| {
            let found = Elements::of(state);
            let [a, expected @ ..] = reference.elements;
            let angle = |found: f64, expected: f64| {
                libm::remainder(found - expected, std::f64::consts::TAU)
            };
            let deviations = [
                found.semi_major_axis / a - 1.0,
                found.eccentricity - expected[0],
                found.inclination - expected[1],
                angle(found.ascending_node, expected[2]),
                angle(found.argument_of_perihelion, expected[3]),
                angle(found.true_anomaly, expected[4]),
                angle(found.bound.unwrap().mean_anomaly, reference.mean_anomaly),
            ];
            deviations.iter().fold(0.0, |max, next| if next.abs() > max { next.abs() } else { max })
        };
        let found = worst(state);
        println!("e = {}: {found:e}", reference.elements[1]);
        assert!(found < TOLERANCE, "{found:e}");
        let control = State { velocity: state.velocity.map(|part| -part), ..state };
        assert!(worst(control) > 1e3 * TOLERANCE);
    }
}

fn by_elements([a, e, inclination, node, argument, anomaly]: [f64; 6]) -> OrbitState {
    let number = |value| Finite::new(value).unwrap();
    OrbitState::Elements {
        semi_major_axis_au: number(a),
        eccentricity: number(e),
        inclination_rad: number(inclination),
        longitude_of_ascending_node_rad: number(node),
        argument_of_perihelion_rad: number(argument),
        true_anomaly_rad: Some(number(anomaly)),
        mean_anomaly_rad: None,
    }
}

#[test]
fn runs_start_where_their_elements_are() {
    for reference in &REBOUND {
        let start = OrbitStart::Given(by_elements(reference.elements));
        let config = OrbitConfig { start, ..exercise(OrbitIntegrator::Kepler, 1.0, 10.0) };
        let found = deviation(prepare(&config).state().unwrap(), reference);
        assert!(found < TOLERANCE, "{found:e}");
    }
}

/// The largest eccentricity of the manifest. 1 - e = 1e-6 is known to 2^-53, and so is the semi-major axis to 2e-10.
/// Control: a much thinner ellipse is not reproduced.
#[test]
fn thin_ellipses_are_reproduced() {
    let axis = |e: f64| {
        let state = ellipse([1.0, e, 0.0, 0.0, 0.0, 0.0], Anomaly::True(0.0)).state(GM);
        Elements::of(state).semi_major_axis
    };
    let found = axis(1.0 - 1e-6);
    println!("semi-major axis {found:?}");
    assert!((found - 1.0).abs() < 1e-9, "{found:?}");
    let control = axis(1.0 - 2.0 * f64::EPSILON);
    assert!((control - 1.0).abs() > 1e-3, "{control:?}");
    let thin = by_elements([1.0, 1.0 - 1e-6, 0.0, 0.0, 0.0, 3.0]);
    let config = OrbitConfig {
        start: OrbitStart::Given(thin),
        ..exercise(OrbitIntegrator::Kepler, 1.0, 10.0)
    };
    assert!(finished(&config).state().unwrap().is_finite());
}

/// A body of several is around the first one, wherever that is, and both masses attract.
#[test]
fn elements_of_several_bodies_are_relative_to_the_first() {
    let gm = |value| NonNegative::new(value).unwrap();
    let here = |part: f64| [part, -2.0 * part, 0.5].map(|part| Finite::new(part).unwrap());
    let center = OrbitState::Vectors { position_au: here(3.0), velocity_au_per_day: here(1e-3) };
    let reference = &REBOUND[2];
    let bodies = vec![
        OrbitBody { gm_au3_per_day2: gm(0.75 * GM), state: center },
        OrbitBody { gm_au3_per_day2: gm(0.25 * GM), state: by_elements(reference.elements) },
    ];
    let config = OrbitConfig {
        bodies: Some(bodies),
        ..exercise(OrbitIntegrator::VelocityVerlet, 1.0, 10.0)
    };
    let mut frame = Frame::new();
    prepare(&config).observe(&mut frame);
    let rows = frame.state().as_chunks::<6>().0;
    let relative =
        |first: usize| std::array::from_fn(|axis| rows[1][first + axis] - rows[0][first + axis]);
    let found = deviation(State { position: relative(0), velocity: relative(3) }, reference);
    println!("relative to the first body: {found:e}");
    // The positions are rounded relative to their center of mass.
    assert!(found < 2.0 * TOLERANCE, "{found:e}");
}
