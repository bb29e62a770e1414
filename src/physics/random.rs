//! Numbered random streams: one for each purpose and replicate, the same at every point of a sweep.
//!
//! The numbers in [`Stream`] are part of every recording's meaning and are never changed or reused.

use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use serde::{Deserialize, Serialize};

/// What a stream of random numbers is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Stream {
    /// Positions of particles at the start.
    Positions = 1,
    /// Velocities of particles at the start.
    Velocities = 2,
    /// Radii of particles.
    Radii = 3,
    /// Angles by which walls turn outgoing directions.
    WallNoise = 4,
    /// Velocities of discs while a start is compressed.
    Compression = 5,
    /// What a thermal wall gives back: one place in the stream for each hit of each particle.
    ThermalWall = 7,
    /// Materials of discs.
    Materials = 8,
    /// Places where discs enter.
    Rain = 9,
}

/// The manifest's seed together with the replicate's number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Seed {
    /// `seed` of the manifest.
    pub seed: u64,
    /// Number of the replicate, from 0.
    pub replicate: u32,
}

/// A generator that continues exactly where it was saved.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Generator(ChaCha12Rng);

impl Seed {
    /// The generator of one purpose: ChaCha12 with the seed as key and (replicate, purpose) as its 64-bit stream number,
    /// so that streams never overlap and adding a replicate or a purpose changes no other stream.
    #[must_use]
    pub fn stream(self, purpose: Stream) -> Generator {
        let mut key = [0_u8; 32];
        key[..8].copy_from_slice(&self.seed.to_le_bytes());
        let mut generator = ChaCha12Rng::from_seed(key);
        generator.set_stream(u64::from(self.replicate) << 32 | u64::from(purpose as u32));
        Generator(generator)
    }

    /// The generator of one purpose at one of its 2^64 places, 64 bytes apart: for draws that are numbered, so that they do not
    /// depend on who draws first.
    #[must_use]
    pub fn stream_at(self, purpose: Stream, place: u64) -> Generator {
        /// Words of 32 bits in 64 bytes.
        const WORDS: u128 = 16;
        let mut generator = self.stream(purpose);
        generator.0.set_word_pos(u128::from(place) * WORDS);
        generator
    }
}

impl Generator {
    /// Uniform in [0, 1), a multiple of 2^-53.
    pub fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 * (1.0 / 9_007_199_254_740_992.0)
    }

    /// Uniform in `[low, high)` up to rounding.
    pub fn uniform_in(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// A pair of independent standard normal numbers, by Box and Muller: two uniform numbers a call, always.
    pub fn normal_pair(&mut self) -> [f64; 2] {
        // 1 - u lies in (0, 1]: the logarithm is finite.
        let radius = (-2.0 * libm::log(1.0 - self.uniform())).sqrt();
        let angle = std::f64::consts::TAU * self.uniform();
        [radius * libm::cos(angle), radius * libm::sin(angle)]
    }
}
