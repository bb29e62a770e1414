//! Random numbers of tests.

/// Uniform numbers in [0, 1) with 53 random bits, by Vigna's splitmix64.
pub(crate) struct Uniform(pub(crate) u64);

impl Uniform {
    /// The next number.
    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((bits ^ (bits >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Normal with variance 1 (Box and Muller 1958).
    pub(crate) fn normal(&mut self) -> f64 {
        let radius = (-2.0 * libm::log(1.0 - self.next())).sqrt();
        radius * libm::cos(std::f64::consts::TAU * self.next())
    }

    /// A series of normal numbers with variance 1, each with the correlation `rho` to the preceding one.
    pub(crate) fn correlated(&mut self, rho: f64, length: usize) -> impl Iterator<Item = f64> {
        let mut x = self.normal();
        (0..length).map(move |_| {
            x = rho * x + (1.0 - rho * rho).sqrt() * self.normal();
            x
        })
    }
}
