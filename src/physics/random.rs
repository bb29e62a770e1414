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

    /// Creates the generator of a purpose at one of its 2^64 positions, 64 bytes apart. Numbered draws do not depend on the order in which
    /// they are made.
    #[must_use]
    pub fn stream_at(self, purpose: Stream, position: u64) -> Generator {
        /// 32-bit words per position.
        const WORDS: u128 = 16;
        let mut generator = self.stream(purpose);
        generator.0.set_word_pos(u128::from(position) * WORDS);
        generator
    }
}

impl Generator {
    /// Draws a uniform number in [0, 1), a multiple of 2^-53.
    pub fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 * (1.0 / 9_007_199_254_740_992.0)
    }

    /// Draws a uniform number in `[low, high)`, up to rounding.
    pub fn uniform_in(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// Draws a pair of independent standard normal numbers (Box and Muller, Ann. Math. Stat. 29 (1958) 610): always two uniform numbers
    /// per call.
    pub fn normal_pair(&mut self) -> [f64; 2] {
        // 1 - u is in (0, 1], so the logarithm is finite.
        let radius = (-2.0 * libm::log(1.0 - self.uniform())).sqrt();
        let angle = std::f64::consts::TAU * self.uniform();
        [radius * libm::cos(angle), radius * libm::sin(angle)]
    }
}
