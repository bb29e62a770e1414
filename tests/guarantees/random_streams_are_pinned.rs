//! Guarantee: a seed, a replicate and a purpose identify one stream of random numbers, in every version and on every platform.
//! Streams share no number, and the numbers follow their distributions.
//!
//! Source: the first numbers from `tests/interop/chacha12_streams.py` (an independent implementation of ChaCha12, itself checked
//! against published keystreams); normal numbers from these by Box and Muller in 40-digit arithmetic.
//! Tolerance: none for uniform numbers. 4e-15 for normal numbers: rounding an angle of up to 2 pi (1e-15, with that of the factor
//! 2 pi) moves a point at a radius of up to 3. In addition, the bits of normal numbers are pinned. Statistics: 5 standard errors of
//! each estimator, derived at the test; the seeds are fixed, so a test that passes always passes.
//! Control: numbers whose distribution deviates by a few percent, and a stream compared with itself, are rejected.

// Statistics in tests are not part of any recording; references keep all their digits.
#![allow(clippy::disallowed_methods, clippy::excessive_precision)]

use crate::uniformity::kolmogorov_smirnov;
use kinetoscope_physics::random::{Generator, Seed, Stream};
use std::collections::HashSet;
use std::process::Command;

const PURPOSES: [Stream; 4] =
    [Stream::Positions, Stream::Velocities, Stream::Radii, Stream::WallNoise];
/// A seed that uses all its bytes.
const LONG_SEED: u64 = 0x0123_4567_89ab_cdef;
/// 2^53.
const SCALE: f64 = 9_007_199_254_740_992.0;

/// Seed, replicate, and for each purpose draws 1, 2, 3 and 1000 as 53-bit numbers: `tests/interop/chacha12_streams.py`.
const PINNED: [(u64, u32, [[u64; 4]; 4]); 4] = [
    (
        14,
        0,
        [
            [0x167d7be3ae3be7, 0xae13fbe144c28, 0xb1d65cba6ac16, 0x11fa1caf43e31e],
            [0x17501e55144881, 0x31627f265d18, 0x1f5c2f2c5f2fe1, 0x1b4bd6a65c89d5],
            [0x1bba2978ce92cc, 0x17c50a9acac5c2, 0xa18f3e5ea249f, 0xb4fc784b97dd4],
            [0x26abaf967800c, 0x157e5a13b4d26d, 0x17d55a961f3bb4, 0x196cae1be88bf8],
        ],
    ),
    (
        14,
        3,
        [
            [0x1268e7d6353d6, 0x741fd32383268, 0x6464458be8860, 0x3ff05e1c688a2],
            [0x1f70d59ee63bac, 0x33159153fef1f, 0x2777cfdd21557, 0x126ecd8cfb5727],
            [0xc9089d8aa2cb2, 0x3ef04c0235af, 0xc46a9c7605fee, 0x12839747bcff04],
            [0xcca611c93b5e0, 0x1575d93df2d152, 0x1f865aa16f0be3, 0x8e414e5d2f459],
        ],
    ),
    (
        LONG_SEED,
        0,
        [
            [0x125b9f5ddee223, 0x1a4c637759e9ec, 0x388963351e5b6, 0x79a7bb0b3f93],
            [0x56cc39de3990c, 0x1c121e00e3965, 0xaf80548704c2, 0x113caeae745adc],
            [0xf7430152b46e1, 0x19f45f094035cd, 0xf6a75d548ef3, 0xc40134d9b9ba4],
            [0x1d10b93156db24, 0x107f89a155e77e, 0x1b92a9ef2ce402, 0xe940eba7b53fc],
        ],
    ),
    (
        LONG_SEED,
        3,
        [
            [0x15929d4faa6d81, 0x8cab2c951b496, 0x5bd418766c3f5, 0xea77eec641556],
            [0x1a1f7afe975e33, 0x37881cc4f8e68, 0x18915ccdfa8321, 0x1d40c9088c4706],
            [0x7b47694909b72, 0xa0dc8e5885750, 0xa7fe424458043, 0x1252417e542f22],
            [0x7000bf7fcf704, 0x1ed386fc5a02c1, 0x6cd11bf91596d, 0xcdf3f647bea6b],
        ],
    ),
];

/// Normal numbers by Box and Muller of the velocity stream, seed 14, replicate 0: 40-digit arithmetic, rounded.
const NORMAL: [[f64; 2]; 3] = [
    [1.613_712_572_472_114_6, 0.061_152_857_622_635_93],
    [-2.783_953_048_232_267, 0.271_933_323_778_580_84],
    [0.715_102_739_523_482_8, 1.354_915_371_707_219_7],
];

/// The same in f64, as Python's math module gives them: sqrt(-2 log(1 - u)) and 2 pi u, then cos and sin.
const NORMAL_BITS: [[u64; 2]; 3] = [
    [0x3ff9_d1c4_463e_9694, 0x3faf_4f6d_6717_a307],
    [0xc006_4589_2cfe_0e89, 0x3fd1_675b_0714_94e5],
    [0x3fe6_e21f_23f1_1154, 0x3ff5_adbb_bda5_4878],
];

fn stream(seed: u64, replicate: u32, purpose: Stream) -> Generator {
    Seed { seed, replicate }.stream(purpose)
}

fn uniforms(generator: &mut Generator, count: usize) -> Vec<f64> {
    (0..count).map(|_| generator.uniform()).collect()
}

#[test]
fn purposes_keep_their_numbers() {
    assert_eq!(PURPOSES.map(|purpose| purpose as u32), [1, 2, 3, 4]);
}

#[test]
fn uniform_numbers_equal_an_independent_chacha12() {
    for (seed, replicate, draws) in PINNED {
        for (purpose, expected) in PURPOSES.into_iter().zip(draws) {
            let drawn = uniforms(&mut stream(seed, replicate, purpose), 1000);
            let picked = [drawn[0], drawn[1], drawn[2], drawn[999]].map(|u| (u * SCALE) as u64);
            assert_eq!(picked, expected, "seed {seed}, replicate {replicate}, {purpose:?}");
        }
    }
}

/// Numbered draws compute single blocks of their own; those of a thermal wall have the particle in the upper half of the position.
#[test]
fn numbered_draws_are_those_of_the_stream() {
    /// `draw(0x0123456789ABCDEF, 7, 7, 8 * (5 << 32 | 9) + 1)` and the seven after it, of the script.
    const FAR: [u64; 8] = [
        0x1e94bac8dc5a4b,
        0x1adbbe66816d1c,
        0x06c7c981088518,
        0x0696919b989351,
        0x19d2affa4d712a,
        0x0d58a3cd26fd97,
        0x090c6a7dfe2db5,
        0x0d3e992c70100d,
    ];
    for (seed, replicate) in [(0, 0), (14, 1), (LONG_SEED, u32::MAX)] {
        let mut generator = stream(seed, replicate, Stream::ThermalWall);
        for position in 0..100 {
            let drawn = Seed { seed, replicate }.uniforms_at(Stream::ThermalWall, position);
            assert_eq!(drawn.as_slice(), uniforms(&mut generator, 8), "position {position}");
        }
    }
    let far = Seed { seed: LONG_SEED, replicate: 7 };
    let drawn = far.uniforms_at(Stream::ThermalWall, 5 << 32 | 9);
    assert_eq!(drawn.map(|u| (u * SCALE) as u64), FAR);
}

#[test]
#[ignore = "needs python3"]
fn independent_chacha12_prints_the_pinned_numbers() {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/interop/chacha12_streams.py");
    let output = Command::new("python3").arg(script).output().unwrap();
    let mut expected = String::new();
    for (seed, replicate, draws) in PINNED {
        for (purpose, [a, b, c, d]) in PURPOSES.into_iter().zip(draws) {
            let name = format!("{seed:#x} {replicate} {}", purpose as u32);
            expected += &format!("{name} {a:#x} {b:#x} {c:#x} {d:#x}\n");
        }
    }
    assert_eq!(String::from_utf8(output.stdout).unwrap(), expected);
}

#[test]
fn normal_numbers_follow_box_and_muller() {
    let mut generator = stream(14, 0, Stream::Velocities);
    for expected in NORMAL {
        let pair = generator.normal_pair();
        for (value, expected) in pair.into_iter().zip(expected) {
            assert!((value - expected).abs() < 4e-15, "{value} {expected}");
        }
    }
    // A pair always takes two uniform numbers, so the next number is the seventh.
    assert_eq!(generator.uniform(), uniforms(&mut stream(14, 0, Stream::Velocities), 7)[6]);
}

/// libm rounds identically on every platform; a change of its last digit would change recordings.
#[test]
fn normal_numbers_keep_their_bits() {
    let mut generator = stream(14, 0, Stream::Velocities);
    let bits = NORMAL.map(|_| generator.normal_pair().map(f64::to_bits));
    assert_eq!(bits, NORMAL_BITS);
}

/// 96 streams of 2000 numbers: the probability of two equal numbers of 53 bits is 2e-6.
#[test]
fn no_two_streams_share_a_number() {
    let mut seen = HashSet::new();
    for seed in [0, 1, 14, LONG_SEED] {
        for replicate in [0, 1, 2, 3, 1000, u32::MAX] {
            for purpose in PURPOSES {
                for number in uniforms(&mut stream(seed, replicate, purpose), 2000) {
                    assert!(seen.insert(number.to_bits()), "{seed} {replicate} {purpose:?}");
                }
            }
        }
    }
}

#[test]
fn streams_are_independent_of_each_other() {
    let separate = uniforms(&mut stream(14, 1, Stream::Positions), 100);
    let mut among_others = Vec::new();
    let mut generator = stream(14, 1, Stream::Positions);
    for replicate in 0..100 {
        uniforms(&mut stream(14, replicate, Stream::Positions), 3);
        stream(14, 1, Stream::Radii).normal_pair();
        among_others.push(generator.uniform());
    }
    assert_eq!(separate, among_others);
}

#[test]
fn restored_generator_continues_its_stream() {
    let mut generator = stream(LONG_SEED, 7, Stream::WallNoise);
    // Advances into the middle of a block.
    uniforms(&mut generator, 1003);
    let text = serde_json::to_string(&generator).unwrap();
    let mut resumed: Generator = serde_json::from_str(&text).unwrap();
    assert_eq!(uniforms(&mut resumed, 100), uniforms(&mut generator, 100));
}

#[test]
fn uniform_in_spans_its_interval() {
    let mut generator = stream(14, 0, Stream::Radii);
    let drawn: Vec<f64> = (0..10_000).map(|_| generator.uniform_in(-3.0, 5.0)).collect();
    assert!(drawn.iter().all(|&x| (-3.0..5.0).contains(&x)));
    let scaled: Vec<f64> = drawn.iter().map(|x| (x + 3.0) / 8.0).collect();
    assert!(kolmogorov_smirnov(scaled) < CRITICAL);
}

/// Kolmogorov's distribution: exceeded with probability 2 exp(-2 x^2) = 1e-6.
const CRITICAL: f64 = 2.69;

/// Whether the mean of f lies within 5 standard errors of its value: variance of f over n.
fn within(values: impl Iterator<Item = f64>, expected: f64, variance: f64) -> bool {
    let (count, sum) = values.fold((0.0, 0.0), |(count, sum), value| (count + 1.0, sum + value));
    (sum / count - expected).abs() < 5.0 * f64::sqrt(variance / count)
}

/// Checks mean, variance and fourth central moment, m_k = (1/2)^k / (k + 1): 1/12, 1/80, and 1/2304 for the eighth.
fn is_uniform(numbers: &[f64]) -> bool {
    let power = |k: i32| numbers.iter().map(move |u| (u - 0.5).powi(k));
    let [second, fourth, eighth] = [1.0 / 12.0, 1.0 / 80.0, 1.0 / 2304.0];
    within(power(1), 0.0, second)
        && within(power(2), second, fourth - second * second)
        && within(power(4), fourth, eighth - fourth * fourth)
        && kolmogorov_smirnov(numbers.to_vec()) < CRITICAL
}

/// Checks products of deviations from the mean: mean 0, variance (1/12)^2.
fn is_independent(first: &[f64], second: &[f64]) -> bool {
    let products = first.iter().zip(second).map(|(a, b)| (a - 0.5) * (b - 0.5));
    within(products, 0.0, 1.0 / 144.0)
}

#[test]
fn uniform_numbers_are_uniform_and_independent() {
    for purpose in PURPOSES {
        for replicate in 0..3 {
            let drawn = uniforms(&mut stream(14, replicate, purpose), 100_000);
            assert!(drawn.iter().all(|u| (0.0..1.0).contains(u)));
            assert!(is_uniform(&drawn), "{purpose:?} {replicate}");
            assert!(is_independent(&drawn[1..], &drawn), "consecutive numbers");
            let next = uniforms(&mut stream(14, replicate + 1, purpose), 100_000);
            assert!(is_independent(&drawn, &next), "replicates");
            let other_seed = uniforms(&mut stream(15, replicate, purpose), 100_000);
            assert!(is_independent(&drawn, &other_seed), "seeds");
            let other =
                uniforms(&mut stream(14, replicate, PURPOSES[(purpose as usize) % 4]), 100_000);
            assert!(is_independent(&drawn, &other), "purposes");
        }
    }
    let drawn = uniforms(&mut stream(14, 0, Stream::Positions), 100_000);
    let bent: Vec<f64> = drawn.iter().map(|u| u.powf(1.05)).collect();
    assert!(!is_uniform(&bent), "control: a density with a slope of 5 %");
    assert!(!is_independent(&drawn, &drawn), "control: a stream compared with itself");
}

/// Checks the moments of normal numbers: 0, 1, 3, and 105 for the eighth; products within a pair: 0 with variance 1, and of squares
/// 1 with variance 3 * 3 - 1. The distribution is checked by Kolmogorov and Smirnov.
fn is_normal(pairs: &[[f64; 2]]) -> bool {
    let power = |k: i32| pairs.iter().flatten().map(move |x| x.powi(k));
    let probabilities =
        pairs.iter().flatten().map(|x| 0.5 * libm::erfc(-x / std::f64::consts::SQRT_2)).collect();
    within(power(1), 0.0, 1.0)
        && within(power(2), 1.0, 2.0)
        && within(power(3), 0.0, 15.0)
        && within(power(4), 3.0, 96.0)
        && within(pairs.iter().map(|[x, y]| x * y), 0.0, 1.0)
        && within(pairs.iter().map(|[x, y]| x * x * y * y), 1.0, 8.0)
        && kolmogorov_smirnov(probabilities) < CRITICAL
}

#[test]
fn normal_numbers_are_normal_and_independent() {
    for replicate in 0..3 {
        let mut generator = stream(14, replicate, Stream::Velocities);
        let pairs: Vec<[f64; 2]> = (0..100_000).map(|_| generator.normal_pair()).collect();
        assert!(is_normal(&pairs), "{replicate}");
        let wide: Vec<[f64; 2]> = pairs.iter().map(|pair| pair.map(|x| 1.02 * x)).collect();
        assert!(!is_normal(&wide), "control: a standard deviation that is 2 % too large");
        let tied: Vec<[f64; 2]> =
            pairs.iter().map(|&[x, y]| [x, 0.05 * x + 0.998_75 * y]).collect();
        assert!(!is_normal(&tied), "control: pairs with a correlation of 5 %");
    }
}
