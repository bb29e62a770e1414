//! Loops over columns of numbers, as wide as the machine allows: the one place that chooses instructions at run time.
//!
//! A kernel is written once, in plain arithmetic on slices. It is compiled for any x86-64 and again with AVX2; each
//! element goes through the same additions, products, divisions and roots, all rounded by IEEE 754 and never
//! fused (`fma` is not among the features), so that both give the same bits. `benches/gas_speed.rs` measures.

/// A loop that can be compiled for wider instructions. `run` must be `#[inline(always)]`, and so must be what it calls.
pub trait Kernel {
    /// What it returns.
    type Output;

    /// Runs the loop.
    fn run(self) -> Self::Output;
}

/// Four numbers, each by its place: what the compiler keeps in one register, or in two.
#[inline(always)]
pub fn each(value: impl Fn(usize) -> f64) -> [f64; 4] {
    [value(0), value(1), value(2), value(3)]
}

/// The larger of two; the second where either is no number.
#[inline(always)]
pub fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// Runs a kernel with the widest instructions that this machine has.
pub fn run<K: Kernel>(kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") {
        // SAFETY: the function asks for nothing but AVX2, and the line above found that this machine has it.
        #[allow(
            unsafe_code,
            reason = "calling a function compiled for AVX2; see the head of the file"
        )]
        return unsafe { run_with_avx2(kernel) };
    }
    kernel.run()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn run_with_avx2<K: Kernel>(kernel: K) -> K::Output {
    kernel.run()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A step of a particle in a circle: sums, products, a quotient and a root, which a compiler might be tempted to fuse.
    struct Chords<'a>(&'a [[f64; 4]]);

    impl Kernel for Chords<'_> {
        type Output = Vec<u64>;

        #[inline(always)]
        fn run(self) -> Vec<u64> {
            let chord = |[x, y, vx, vy]: [f64; 4]| {
                let along = x * vx + y * vy;
                let speed_squared = vx * vx + vy * vy;
                let room = speed_squared * (1.0 - (x * x + y * y)) + along * along;
                ((room.sqrt() - along) / speed_squared).to_bits()
            };
            self.0.iter().map(|&particle| chord(particle)).collect()
        }
    }

    #[test]
    fn wider_instructions_give_the_same_bits() {
        // The fractional parts of multiples of irrational numbers fill the unit interval evenly (Weyl 1916).
        let part = |index: u32, root: f64| (f64::from(index) * root.sqrt()).fract() - 0.5;
        let particles: Vec<[f64; 4]> =
            (1..10_000).map(|index| [2.0, 3.0, 5.0, 7.0].map(|root| part(index, root))).collect();
        assert_eq!(run(Chords(&particles)), Chords(&particles).run());
    }
}
