//! Numbered random streams: one per purpose and replicate, the same at every point of a sweep.
//!
//! The numbers in [`Stream`] determine the content of every recording, so they must not be changed or reused.

use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use serde::{Deserialize, Serialize};

/// Purpose of a stream of random numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Stream {
    /// Positions of particles at the start.
    Positions = 1,
    /// Velocities of particles at the start.
    Velocities = 2,
    /// Radii of particles.
    Radii = 3,
    /// Angles by which noisy walls rotate the reflected velocities.
    WallNoise = 4,
    /// Velocities of discs during the compression of a start.
    Compression = 5,
    /// Velocities emitted by a thermal wall: one position in the stream per wall collision and particle.
    ThermalWall = 7,
    /// Materials of discs.
    Materials = 8,
    /// Positions of inserted discs.
    Insertion = 9,
}

/// Seed of the manifest, and number of the replicate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Seed {
    /// `seed` of the manifest.
    pub seed: u64,
    /// Number of the replicate, from 0.
    pub replicate: u32,
}

/// A random number generator; a deserialized one continues where it was serialized.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Generator(ChaCha12Rng);

impl Seed {
    /// Creates the generator of a purpose: ChaCha12 with the seed as key and (replicate, purpose) as 64-bit stream number. Streams never
    /// overlap, and an additional replicate or purpose changes no other stream.
    #[must_use]
    pub fn stream(self, purpose: Stream) -> Generator {
        let mut key = [0_u8; 32];
        key[..8].copy_from_slice(&self.seed.to_le_bytes());
        let mut generator = ChaCha12Rng::from_seed(key);
        generator.set_stream(u64::from(self.replicate) << 32 | u64::from(purpose as u32));
        Generator(generator)
    }

    /// Eight uniform numbers in [0, 1) at one of the 2^64 positions of a purpose, 64 bytes apart: the numbers that [`Self::stream`] gives
    /// there. Numbered draws do not depend on the order in which they are made. The generator computes four positions at once, of which
    /// three would be wasted.
    #[must_use]
    pub fn uniforms_at(self, purpose: Stream, position: u64) -> [f64; 8] {
        let [low, high] = [self.seed as u32, (self.seed >> 32) as u32];
        let [from, to] = [position as u32, (position >> 32) as u32];
        let words = chacha12_block([
            // "expand 32-byte k"
            [0x6170_7865, 0x3320_646e, 0x7962_2d32, 0x6b20_6574],
            [low, high, 0, 0],
            [0; 4],
            [from, to, purpose as u32, self.replicate],
        ]);
        let pairs = words.as_flattened().as_chunks().0;
        std::array::from_fn(|index| {
            let [low, high] = pairs[index];
            uniform(u64::from(high) << 32 | u64::from(low))
        })
    }
}

/// One block of ChaCha12 (D. J. Bernstein, ChaCha, a variant of Salsa20, 2008): constant, key in two rows, and counter with stream.
fn chacha12_block(start: [[u32; 4]; 4]) -> [[u32; 4]; 4] {
    const DOUBLE_ROUNDS: usize = 6;
    let [mut a, mut b, mut c, mut d] = start;
    for _ in 0..DOUBLE_ROUNDS {
        quarter_rounds(&mut a, &mut b, &mut c, &mut d);
        // Diagonals become columns.
        (b, c, d) = (turned::<1>(b), turned::<2>(c), turned::<3>(d));
        quarter_rounds(&mut a, &mut b, &mut c, &mut d);
        (b, c, d) = (turned::<3>(b), turned::<2>(c), turned::<1>(d));
    }
    let mut end = [a, b, c, d];
    for (word, first) in end.as_flattened_mut().iter_mut().zip(start.as_flattened()) {
        *word = word.wrapping_add(*first);
    }
    end
}

/// A quarter round in each of the four columns.
#[inline(always)]
fn quarter_rounds(a: &mut [u32; 4], b: &mut [u32; 4], c: &mut [u32; 4], d: &mut [u32; 4]) {
    add_and_mix::<16>(a, b, d);
    add_and_mix::<12>(c, d, b);
    add_and_mix::<8>(a, b, d);
    add_and_mix::<7>(c, d, b);
}

/// `sum += term; mixed = (mixed ^ sum) <<< BITS`.
#[inline(always)]
fn add_and_mix<const BITS: u32>(sum: &mut [u32; 4], term: &[u32; 4], mixed: &mut [u32; 4]) {
    for ((sum, term), mixed) in sum.iter_mut().zip(term).zip(mixed) {
        *sum = sum.wrapping_add(*term);
        *mixed = (*mixed ^ *sum).rotate_left(BITS);
    }
}

#[inline(always)]
fn turned<const PLACES: usize>(row: [u32; 4]) -> [u32; 4] {
    std::array::from_fn(|column| row[(column + PLACES) % 4])
}

/// The number in [0, 1) of 64 random bits, a multiple of 2^-53.
fn uniform(bits: u64) -> f64 {
    (bits >> 11) as f64 * (1.0 / 9_007_199_254_740_992.0)
}

/// Radius and angle, rad, of a pair of independent standard normal numbers from two uniform numbers (Box and Muller, Ann. Math. Stat. 29
/// (1958) 610).
fn polar([first, second]: [f64; 2]) -> [f64; 2] {
    // 1 - u is in (0, 1], so the logarithm is finite.
    [flux_speed(first), std::f64::consts::TAU * second]
}

/// A standard normal number from two uniform numbers: the first of the pair.
#[must_use]
pub fn normal(uniforms: [f64; 2]) -> f64 {
    let [radius, angle] = polar(uniforms);
    radius * libm::cos(angle)
}

/// Speed toward a wall of temperature 1 from which a particle of mass 1 is emitted, from a uniform number: its density is
/// g exp(-g^2/2), that of the flux of a Maxwellian gas.
#[must_use]
pub fn flux_speed(uniform: f64) -> f64 {
    (-2.0 * libm::log(1.0 - uniform)).sqrt()
}

impl Generator {
    /// Draws a uniform number in [0, 1), a multiple of 2^-53.
    pub fn uniform(&mut self) -> f64 {
        uniform(self.0.next_u64())
    }

    /// Draws a uniform number in `[low, high)`, up to rounding.
    pub fn uniform_in(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// Draws a pair of independent standard normal numbers: always two uniform numbers per call.
    pub fn normal_pair(&mut self) -> [f64; 2] {
        let [radius, angle] = polar([self.uniform(), self.uniform()]);
        [radius * libm::cos(angle), radius * libm::sin(angle)]
    }
}
