//! Code compiled for three instruction sets, of which the widest that the processor has is chosen at run time.
//!
//! Invariant: results are bitwise identical with every instruction set. Each version is compiled from the same source, and
//! Rust neither fuses nor reorders floating-point operations. `benches/packing_speed.rs` measures the gain.

#![allow(unsafe_code)]

/// Code that is compiled for every instruction set. `run` and every function on its hot path must be `#[inline(always)]`.
pub(crate) trait WideKernel {
    /// The value that it returns.
    type Output;

    /// Runs the code. If `HAS_AVX512`, it may use AVX-512 intrinsics.
    fn run<const HAS_AVX512: bool>(self) -> Self::Output;
}

/// Runs a kernel with the widest instruction set of this processor.
pub(crate) fn run<K: WideKernel>(kernel: K) -> K::Output {
    InstructionSet::widest().run(kernel)
}

/// An instruction set that this processor has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum InstructionSet {
    /// The one that the build assumes.
    Baseline,
    /// AVX2: registers of 256 bits.
    #[cfg(target_arch = "x86_64")]
    Avx2,
    /// AVX-512 F and VL: registers of 512 bits.
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl InstructionSet {
    /// The widest one of this processor.
    fn widest() -> Self {
        Self::available().last().unwrap_or(Self::Baseline)
    }

    /// All those of this processor, the widest last.
    pub(crate) fn available() -> impl Iterator<Item = Self> {
        #[cfg(target_arch = "x86_64")]
        let wider = [
            (is_x86_feature_detected!("avx2")
                && is_x86_feature_detected!("bmi1")
                && is_x86_feature_detected!("bmi2")
                && is_x86_feature_detected!("popcnt"))
            .then_some(Self::Avx2),
            (is_x86_feature_detected!("avx512f")
                && is_x86_feature_detected!("avx512vl")
                && is_x86_feature_detected!("bmi1")
                && is_x86_feature_detected!("bmi2")
                && is_x86_feature_detected!("popcnt"))
            .then_some(Self::Avx512),
        ];
        #[cfg(not(target_arch = "x86_64"))]
        let wider: [Option<Self>; 0] = [];
        std::iter::once(Self::Baseline).chain(wider.into_iter().flatten())
    }

    /// Runs a kernel with this instruction set.
    pub(crate) fn run<K: WideKernel>(self, kernel: K) -> K::Output {
        match self {
            Self::Baseline => kernel.run::<false>(),
            // SAFETY: only `available` returns this variant, after it found the features.
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => unsafe { run_with_avx2(kernel) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => unsafe { run_with_avx512(kernel) },
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,bmi2,popcnt")]
fn run_with_avx2<K: WideKernel>(kernel: K) -> K::Output {
    kernel.run::<false>()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,avx512f,avx512vl,bmi1,bmi2,popcnt")]
fn run_with_avx512<K: WideKernel>(kernel: K) -> K::Output {
    kernel.run::<true>()
}
