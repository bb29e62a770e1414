//! Registers of one, two (WebAssembly), four (AVX2) or eight (AVX-512) numbers, so that a formula is written once for every width, and the one
//! place that chooses instructions at run time.
//!
//! Operators act lane by lane. Each operation is rounded by IEEE 754 as that of a single number, and is neither fused (`fma` is
//! not among the features) nor reordered; therefore, results have the same bits at every width. Width 1 is plain `f64` arithmetic
//! with checked indices and runs on every processor.
//!
//! # Safety
//! - A value of an `InstructionSet` proves that the processor has the instructions: `run` is the only function that creates
//!   one, after detection. Every register comes from an instruction set, so operations on it need no second check.
//! - Everything is inlined into a function that is compiled for the instructions.

#![allow(unsafe_code)]

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Sub};

/// Numbers in the widest register.
pub(crate) const MAX_WIDTH: usize = 8;

/// Code that is compiled for every instruction set. `run` and every function on its hot path must be `#[inline(always)]`.
pub(crate) trait Kernel {
    /// What the code returns.
    type Output;

    /// Runs the code, which may use registers of `N` numbers.
    fn run<const N: usize, I: InstructionSet<N>>(self, instructions: I) -> Self::Output;
}

/// A real number, or a register of real numbers on which every operation acts lane by lane.
pub trait Register:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// The result of a comparison.
    type Mask: Mask;

    /// Another number in every lane.
    fn splat(self, value: f64) -> Self;
    /// The square root.
    fn sqrt(self) -> Self;
    /// The absolute value.
    fn abs(self) -> Self;
    /// `if self > other { self } else { other }`
    fn larger(self, other: Self) -> Self;
    /// `self < other`
    fn is_less(self, other: Self) -> Self::Mask;
    /// `self <= other`
    fn is_at_most(self, other: Self) -> Self::Mask;

    /// `if mask { self } else { other }`
    fn or_else(self, mask: Self::Mask, other: Self) -> Self;

    /// `if mask { self } else { 0.0 }`
    fn or_zero(self, mask: Self::Mask) -> Self;
}

/// One truth value per lane.
pub trait Mask: Copy + BitAnd<Output = Self> + BitOr<Output = Self> {
    /// One bit per lane, the first lane lowest.
    fn bits(self) -> u32;
}

/// Instructions for registers of `N` numbers.
pub(crate) trait InstructionSet<const N: usize>: Copy {
    type Register: Register;

    /// One number in all lanes.
    fn splat(self, value: f64) -> Self::Register;

    /// One number per lane.
    fn load(self, values: &[f64; N]) -> Self::Register;
    fn store(self, register: Self::Register, into: &mut [f64; N]);

    /// The x and the y of `N` adjacent vectors.
    fn columns(self, vectors: &[[f64; 2]; N]) -> [Self::Register; 2];

    /// Vectors `first` minus vectors `second`, along x and along y.
    ///
    /// # Safety
    /// - Every index is less than the number of vectors.
    unsafe fn differences(self, vectors: &[[f64; 2]], ends: [&[u16; N]; 2]) -> [Self::Register; 2];

    /// Adds rows, given by columns, to the sums at `first`, and subtracts them from those at `second`.
    ///
    /// # Safety
    /// - Every index is less than the number of sums.
    unsafe fn add_opposite(
        self,
        columns: [Self::Register; 4],
        sums: &mut [[f64; 4]],
        ends: [&[u16; N]; 2],
    );

    /// Adds rows, given by columns, to the sums at either end: lane after lane, first `first`, then `second`.
    ///
    /// # Safety
    /// - Every index is less than the number of sums.
    unsafe fn add_to_ends(
        self,
        columns: [[Self::Register; 2]; 2],
        sums: &mut [[f64; 2]],
        ends: [&[u16; N]; 2],
    );

    /// The x and the y of the vectors at `N` indices.
    ///
    /// # Safety
    /// - Every index is less than the number of vectors.
    unsafe fn gather_vectors(self, vectors: &[[f64; 2]], indices: &[u16; N])
    -> [Self::Register; 2];

    /// The largest integer that is not above each number, for numbers in [0, 2^51).
    fn floor(self, register: Self::Register) -> Self::Register;

    /// Lane by lane, `odd` if the last bit of `bits` is set, else `even`.
    fn by_last_bit(
        self,
        bits: Self::Register,
        odd: Self::Register,
        even: Self::Register,
    ) -> Self::Register;

    /// The numbers, with their signs inverted in the lanes where the last bit but one of `bits` is set.
    fn inverted_by_second_bit(
        self,
        bits: Self::Register,
        numbers: Self::Register,
    ) -> Self::Register;

    /// Stores the lanes whose bits are set in `lanes`, packed from the front; the rest is undefined.
    fn store_selected(self, register: Self::Register, lanes: u32, into: &mut [f64; N]);

    /// Stores the pairs (`first`, `second` + lane) of the selected lanes, packed from the front; the rest is undefined.
    fn store_selected_pairs(self, ends: [u32; 2], lanes: u32, into: &mut [[u32; 2]; N]);

    /// Stores those of eight numbers from `first` on whose bits are set in `selected`, packed from the front.
    fn store_selected_numbers(self, first: u32, selected: u32, into: &mut [u32; 8]);
}

/// Runs a kernel with the widest registers of at most `max_width` numbers that the processor has.
pub(crate) fn run<K: Kernel>(kernel: K, max_width: usize) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    if max_width >= 4
        && is_x86_feature_detected!("avx2")
        && is_x86_feature_detected!("bmi1")
        && is_x86_feature_detected!("bmi2")
        && is_x86_feature_detected!("popcnt")
    {
        if max_width >= 8
            && is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512vl")
        {
            // SAFETY: the processor has these instructions.
            return unsafe { super::avx512::run(kernel) };
        }
        // SAFETY: the processor has these instructions.
        return unsafe { super::avx2::run(kernel) };
    }
    let _ = max_width;
    // Not also in width 1, which would make the module of a page larger by a tenth.
    #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
    return super::wasm128::run(kernel);
    #[cfg(not(all(target_arch = "wasm32", target_feature = "simd128")))]
    kernel.run(Scalar)
}

/// Numbers in the widest register that this processor has and that the kernels use: 8 with AVX-512, 4 with AVX2, 2 with those of
/// WebAssembly, else 1.
#[must_use]
pub fn widest() -> usize {
    struct Width;

    impl Kernel for Width {
        type Output = usize;

        #[inline(always)]
        fn run<const N: usize, I: InstructionSet<N>>(self, _: I) -> usize {
            N
        }
    }

    run(Width, MAX_WIDTH)
}

/// Defines functions that contain loops in plain arithmetic and are compiled for wider instructions as well. Functions that they
/// call must be `#[inline(always)]`.
macro_rules! vectorized {
    ($($(#[$attribute:meta])* $visibility:vis fn $name:ident(
        $($argument:ident: $type:ty),* $(,)?
    ) -> $output:ty $body:block)+) => {$(
        $(#[$attribute])*
        $visibility fn $name($($argument: $type),*) -> $output {
            struct Arguments<T>(T);

            impl $crate::simd::registers::Kernel for Arguments<($($type,)*)> {
                type Output = $output;

                #[inline(always)]
                fn run<const N: usize, I: $crate::simd::registers::InstructionSet<N>>(
                    self,
                    _: I,
                ) -> $output {
                    let Self(($($argument,)*)) = self;
                    $body
                }
            }

            $crate::simd::registers::run(Arguments(($($argument,)*)), 4)
        }
    )+};
}
pub(crate) use vectorized;

/// Four numbers, each by its place: what the compiler keeps in one register, or in two.
#[inline(always)]
pub(crate) fn each(value: impl Fn(usize) -> f64) -> [f64; 4] {
    [value(0), value(1), value(2), value(3)]
}

/// Width 1.
#[derive(Clone, Copy)]
pub(crate) struct Scalar;

impl Mask for bool {
    #[inline(always)]
    fn bits(self) -> u32 {
        u32::from(self)
    }
}

impl Register for f64 {
    type Mask = bool;

    #[inline(always)]
    fn splat(self, value: f64) -> Self {
        value
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self::sqrt(self)
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self::abs(self)
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        if self > other { self } else { other }
    }

    #[inline(always)]
    fn is_less(self, other: Self) -> bool {
        self < other
    }

    #[inline(always)]
    fn is_at_most(self, other: Self) -> bool {
        self <= other
    }

    #[inline(always)]
    fn or_else(self, mask: bool, other: Self) -> Self {
        if mask { self } else { other }
    }

    #[inline(always)]
    fn or_zero(self, mask: bool) -> Self {
        if mask { self } else { 0.0 }
    }
}

impl InstructionSet<1> for Scalar {
    type Register = f64;

    #[inline(always)]
    fn splat(self, value: f64) -> f64 {
        value
    }

    #[inline(always)]
    fn load(self, [value]: &[f64; 1]) -> f64 {
        *value
    }

    #[inline(always)]
    fn store(self, value: f64, into: &mut [f64; 1]) {
        *into = [value];
    }

    #[inline(always)]
    fn columns(self, [[x, y]]: &[[f64; 2]; 1]) -> [f64; 2] {
        [*x, *y]
    }

    #[inline(always)]
    unsafe fn differences(
        self,
        vectors: &[[f64; 2]],
        [[first], [second]]: [&[u16; 1]; 2],
    ) -> [f64; 2] {
        let ([x, y], [other_x, other_y]) =
            (vectors[usize::from(*first)], vectors[usize::from(*second)]);
        [x - other_x, y - other_y]
    }

    #[inline(always)]
    unsafe fn add_opposite(
        self,
        columns: [f64; 4],
        sums: &mut [[f64; 4]],
        [[first], [second]]: [&[u16; 1]; 2],
    ) {
        let sum = sums[usize::from(*first)];
        sums[usize::from(*first)] = [0, 1, 2, 3].map(|part: usize| sum[part] + columns[part]);
        let sum = sums[usize::from(*second)];
        sums[usize::from(*second)] = [0, 1, 2, 3].map(|part: usize| sum[part] - columns[part]);
    }

    #[inline(always)]
    unsafe fn add_to_ends(
        self,
        columns: [[f64; 2]; 2],
        sums: &mut [[f64; 2]],
        [[first], [second]]: [&[u16; 1]; 2],
    ) {
        for (end, added) in [first, second].into_iter().zip(columns) {
            let [x, y] = sums[usize::from(*end)];
            sums[usize::from(*end)] = [x + added[0], y + added[1]];
        }
    }

    #[inline(always)]
    unsafe fn gather_vectors(self, vectors: &[[f64; 2]], [index]: &[u16; 1]) -> [f64; 2] {
        vectors[usize::from(*index)]
    }

    #[inline(always)]
    fn floor(self, number: f64) -> f64 {
        // 2^52: its addition rounds to the nearest integer. The processor may not have an instruction for it.
        const ROUNDING: f64 = 4_503_599_627_370_496.0;
        let nearest = (number + ROUNDING) - ROUNDING;
        if nearest > number { nearest - 1.0 } else { nearest }
    }

    #[inline(always)]
    fn by_last_bit(self, bits: f64, odd: f64, even: f64) -> f64 {
        if bits.to_bits() & 1 == 1 { odd } else { even }
    }

    #[inline(always)]
    fn inverted_by_second_bit(self, bits: f64, number: f64) -> f64 {
        f64::from_bits(number.to_bits() ^ (bits.to_bits() & 2) << 62)
    }

    #[inline(always)]
    fn store_selected(self, value: f64, _: u32, into: &mut [f64; 1]) {
        *into = [value];
    }

    #[inline(always)]
    fn store_selected_pairs(self, ends: [u32; 2], _: u32, into: &mut [[u32; 2]; 1]) {
        *into = [ends];
    }

    #[inline(always)]
    fn store_selected_numbers(self, first: u32, selected: u32, into: &mut [u32; 8]) {
        let selected = (0..8).filter(|number| selected >> number & 1 == 1);
        for (place, number) in into.iter_mut().zip(selected) {
            *place = first + number;
        }
    }
}

/// For a set of eight lanes, an order that puts the lanes in the set first.
#[cfg(any(target_arch = "x86_64", all(target_arch = "wasm32", target_feature = "simd128")))]
pub(super) const fn selected_first(set: usize) -> [u8; 8] {
    let mut order = [0; 8];
    let (mut lane, mut place) = (0, 0);
    while lane < 8 {
        if set >> lane & 1 == 1 {
            order[place] = lane;
            place += 1;
        }
        lane += 1;
    }
    order
}

/// The order of [`selected_first`] for every set of eight lanes.
#[cfg(any(target_arch = "x86_64", all(target_arch = "wasm32", target_feature = "simd128")))]
pub(super) static SELECTED_FIRST: [[u8; 8]; 256] = {
    let mut orders = [[0; 8]; 256];
    let mut set = 0;
    while set < 256 {
        orders[set] = selected_first(set);
        set += 1;
    }
    orders
};
