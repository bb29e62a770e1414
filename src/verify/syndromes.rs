//! Which particles of a frame differ, from eight bytes per frame.
//!
//! The syndromes of a Reed–Solomon code (Reed and Solomon, J. SIAM 8, 300, 1960): `S_m = Σ_i h_i i^m mod p`, with a hash `h_i` of
//! particle `i`. If two frames differ in particles `i` and `j`, the differences of their syndromes are
//! `D_m = a i^m + b j^m`, from which `i` and `j` follow as the roots of `x² − e1 x + e2`, with
//! `e1 = (D0 D3 − D1 D2) / (D0 D2 − D1²)` and `e2 = (D1 D3 − D2²) / (D0 D2 − D1²)`.

/// The largest prime below 2^16.
const P: u64 = 65521;

/// The syndromes of order 0 to 3 of a frame's particles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Syndromes([u64; 4]);

impl Syndromes {
    /// Adds a particle with a hash of its values.
    pub fn add(&mut self, particle: u64, hash: u64) {
        let (x, mut term) = (particle % P, hash % P);
        for sum in &mut self.0 {
            *sum = (*sum + term) % P;
            term = term * x % P;
        }
    }

    /// Little-endian numbers of 16 bits.
    pub fn bytes(self) -> [u8; 8] {
        let mut bytes = [0; 8];
        for (place, sum) in bytes.as_chunks_mut::<2>().0.iter_mut().zip(self.0) {
            *place = (sum as u16).to_le_bytes();
        }
        bytes
    }

    /// The inverse of [`Self::bytes`].
    pub fn from_bytes(bytes: [u8; 8]) -> Self {
        let mut sums = [0; 4];
        for (sum, place) in sums.iter_mut().zip(bytes.as_chunks::<2>().0) {
            *sum = u64::from(u16::from_le_bytes(*place));
        }
        Self(sums)
    }

    /// The particles of which the values differ, if they are one or two of fewer than `p` particles; `None` if they are more.
    pub fn differing(&self, other: &Self, particles: u64) -> Option<Vec<u64>> {
        let mut d = [0; 4];
        for ((difference, one), other) in d.iter_mut().zip(self.0).zip(other.0) {
            *difference = (one % P + P - other % P) % P;
        }
        if d == [0; 4] {
            return Some(Vec::new());
        }
        if particles >= P {
            return None;
        }
        let minus = |one: u64, other: u64| (one + P - other) % P;
        let determinant = minus(d[0] * d[2] % P, d[1] * d[1] % P);
        if determinant == 0 {
            let particle = d[1] * inverse(d[0]) % P;
            let fits = d[0] != 0 && (1..4).all(|m| d[m] == d[m - 1] * particle % P);
            return (fits && particle < particles).then(|| vec![particle]);
        }
        let scale = inverse(determinant);
        let e1 = minus(d[0] * d[3] % P, d[1] * d[2] % P) * scale % P;
        let e2 = minus(d[1] * d[3] % P, d[2] * d[2] % P) * scale % P;
        let is_root = |x: &u64| minus((x * x + e2) % P, e1 * x % P) == 0;
        let roots: Vec<u64> = (0..particles).filter(is_root).collect();
        (roots.len() == 2).then_some(roots)
    }
}

/// The inverse modulo `p` by Fermat's little theorem; 0 for 0.
fn inverse(number: u64) -> u64 {
    let (mut power, mut base, mut exponent) = (1, number % P, P - 2);
    while exponent > 0 {
        if exponent % 2 == 1 {
            power = power * base % P;
        }
        base = base * base % P;
        exponent /= 2;
    }
    if number.is_multiple_of(P) { 0 } else { power }
}

#[cfg(test)]
mod tests {
    use super::Syndromes;

    /// Hashes of particles, of which those in `changed` differ.
    fn frame(particles: u64, changed: &[u64]) -> Syndromes {
        let mut syndromes = Syndromes::default();
        for particle in 0..particles {
            let hash = particle.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 7;
            syndromes.add(particle, if changed.contains(&particle) { hash ^ 0x5a5a } else { hash });
        }
        syndromes
    }

    #[test]
    fn one_or_two_differing_particles_are_named() {
        let equal = frame(1000, &[]);
        for changed in [&[][..], &[0], &[999], &[0, 1], &[17, 998]] {
            assert_eq!(frame(1000, changed).differing(&equal, 1000), Some(changed.to_vec()));
            let stored = Syndromes::from_bytes(frame(1000, changed).bytes());
            assert_eq!(stored.differing(&equal, 1000), Some(changed.to_vec()));
        }
    }

    /// Control: three particles are not taken for two.
    #[test]
    fn three_differing_particles_are_not_named() {
        let equal = frame(1000, &[]);
        for third in 3..200 {
            assert_eq!(frame(1000, &[1, 2, third]).differing(&equal, 1000), None);
        }
    }
}
