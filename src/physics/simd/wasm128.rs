//! Registers of two numbers with the 128-bit instructions of WebAssembly.
//!
//! # Safety
//! - The file is compiled only where these instructions are part of the target (`+simd128`): a module that contains them is not even
//!   loaded where they are missing. Relaxed instructions, whose results differ between processors, are not used.
//! - Loads and stores go through references to as many numbers as are moved, and need no alignment.

#![allow(unsafe_code)]

use super::registers::{InstructionSet, Kernel, Mask, Register, SELECTED_FIRST};
use std::arch::wasm32::*;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Sub};

/// The instructions of the target.
#[derive(Clone, Copy)]
struct Simd128;

/// Two numbers in one register.
#[derive(Clone, Copy)]
pub(crate) struct F64x2(v128);

/// One truth value per lane, as all bits of the lane.
#[derive(Clone, Copy)]
pub(crate) struct MaskX2(v128);

#[inline(always)]
pub(super) fn run<K: Kernel>(kernel: K) -> K::Output {
    kernel.run(Simd128)
}

macro_rules! operators {
    ($register:ident: $($operator:ident $name:ident $intrinsic:ident),*) => {
        $(impl $operator for $register {
            type Output = Self;

            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                Self($intrinsic(self.0, other.0))
            }
        })*
    };
}

operators!(F64x2: Add add f64x2_add, Sub sub f64x2_sub, Mul mul f64x2_mul, Div div f64x2_div);
operators!(MaskX2: BitAnd bitand v128_and, BitOr bitor v128_or);

#[inline(always)]
fn loaded(pair: &[f64; 2]) -> v128 {
    // SAFETY: two numbers lie behind the reference.
    unsafe { v128_load(pair.as_ptr().cast()) }
}

#[inline(always)]
fn store(register: v128, into: &mut [f64; 2]) {
    // SAFETY: two numbers lie behind the reference.
    unsafe { v128_store(into.as_mut_ptr().cast(), register) }
}

/// The first and the second lanes of two registers.
#[inline(always)]
fn transposed(one: v128, other: v128) -> [v128; 2] {
    [i64x2_shuffle::<0, 2>(one, other), i64x2_shuffle::<1, 3>(one, other)]
}

/// The vectors at two indices, as rows.
///
/// # Safety
/// - Every index is less than the number of vectors.
#[inline(always)]
unsafe fn rows(vectors: &[[f64; 2]], indices: &[u16; 2]) -> [v128; 2] {
    // SAFETY: the caller checked the indices.
    indices.map(|index| loaded(unsafe { vectors.get_unchecked(usize::from(index)) }))
}

/// Packs the selected lanes to the front.
#[inline(always)]
fn packed(register: v128, selected: u32) -> v128 {
    if selected & 3 == 2 { i64x2_shuffle::<1, 1>(register, register) } else { register }
}

impl InstructionSet<2> for Simd128 {
    type Register = F64x2;

    #[inline(always)]
    fn splat(self, value: f64) -> F64x2 {
        F64x2(f64x2_splat(value))
    }

    #[inline(always)]
    fn load(self, values: &[f64; 2]) -> F64x2 {
        F64x2(loaded(values))
    }

    #[inline(always)]
    fn store(self, register: F64x2, into: &mut [f64; 2]) {
        store(register.0, into);
    }

    #[inline(always)]
    fn columns(self, [first, second]: &[[f64; 2]; 2]) -> [F64x2; 2] {
        transposed(loaded(first), loaded(second)).map(F64x2)
    }

    #[inline(always)]
    unsafe fn differences(
        self,
        vectors: &[[f64; 2]],
        [first, second]: [&[u16; 2]; 2],
    ) -> [F64x2; 2] {
        // SAFETY: the caller checked the indices.
        let (one, other) = unsafe { (rows(vectors, first), rows(vectors, second)) };
        transposed(f64x2_sub(one[0], other[0]), f64x2_sub(one[1], other[1])).map(F64x2)
    }

    #[inline(always)]
    unsafe fn add_opposite(
        self,
        [a, b, c, d]: [F64x2; 4],
        sums: &mut [[f64; 4]],
        [first, second]: [&[u16; 2]; 2],
    ) {
        let (low, high) = (transposed(a.0, b.0), transposed(c.0, d.0));
        for lane in 0..2 {
            let added = [low[lane], high[lane]];
            for (end, operation) in
                [(first, f64x2_add as fn(v128, v128) -> v128), (second, f64x2_sub)]
            {
                // SAFETY: the caller checked the indices; four numbers lie behind the reference.
                unsafe {
                    let sum =
                        sums.get_unchecked_mut(usize::from(end[lane])).as_mut_ptr().cast::<v128>();
                    v128_store(sum, operation(v128_load(sum), added[0]));
                    v128_store(sum.add(1), operation(v128_load(sum.add(1)), added[1]));
                }
            }
        }
    }

    #[inline(always)]
    unsafe fn add_to_ends(
        self,
        [[x, y], [other_x, other_y]]: [[F64x2; 2]; 2],
        sums: &mut [[f64; 2]],
        [first, second]: [&[u16; 2]; 2],
    ) {
        let rows = [transposed(x.0, y.0), transposed(other_x.0, other_y.0)];
        for lane in 0..2 {
            for (end, rows) in [(first[lane], rows[0]), (second[lane], rows[1])] {
                // SAFETY: the caller checked the indices.
                let sum = unsafe { sums.get_unchecked_mut(usize::from(end)) };
                store(f64x2_add(loaded(sum), rows[lane]), sum);
            }
        }
    }

    #[inline(always)]
    unsafe fn gather_vectors(self, vectors: &[[f64; 2]], indices: &[u16; 2]) -> [F64x2; 2] {
        // SAFETY: the caller checked the indices.
        let [first, second] = unsafe { rows(vectors, indices) };
        transposed(first, second).map(F64x2)
    }

    #[inline(always)]
    fn floor(self, register: F64x2) -> F64x2 {
        F64x2(f64x2_floor(register.0))
    }

    #[inline(always)]
    fn by_last_bit(self, bits: F64x2, odd: F64x2, even: F64x2) -> F64x2 {
        let is_odd = i64x2_shr(i64x2_shl(bits.0, 63), 63);
        F64x2(v128_bitselect(odd.0, even.0, is_odd))
    }

    #[inline(always)]
    fn inverted_by_second_bit(self, bits: F64x2, numbers: F64x2) -> F64x2 {
        let sign = v128_and(i64x2_shl(bits.0, 62), f64x2_splat(-0.0));
        F64x2(v128_xor(numbers.0, sign))
    }

    #[inline(always)]
    fn store_selected(self, register: F64x2, lanes: u32, into: &mut [f64; 2]) {
        store(packed(register.0, lanes), into);
    }

    #[inline(always)]
    fn store_selected_pairs(self, [first, second]: [u32; 2], lanes: u32, into: &mut [[u32; 2]; 2]) {
        let pairs = u32x4(first, second, first, second.wrapping_add(1));
        // SAFETY: four indices lie behind the reference.
        unsafe { v128_store(into.as_mut_ptr().cast(), packed(pairs, lanes)) }
    }

    #[inline(always)]
    fn store_selected_numbers(self, first: u32, selected: u32, into: &mut [u32; 8]) {
        let order = &SELECTED_FIRST[(selected & 0xff) as usize];
        // SAFETY: eight bytes and eight numbers lie behind the references.
        unsafe {
            let order = v128_load64_zero(order.as_ptr().cast());
            let order = u16x8_extend_low_u8x16(order);
            let first = u32x4_splat(first);
            let into = into.as_mut_ptr().cast::<v128>();
            v128_store(into, u32x4_add(u32x4_extend_low_u16x8(order), first));
            v128_store(into.add(1), u32x4_add(u32x4_extend_high_u16x8(order), first));
        }
    }
}

impl Neg for F64x2 {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self(f64x2_neg(self.0))
    }
}

impl Mask for MaskX2 {
    #[inline(always)]
    fn bits(self) -> u32 {
        u32::from(i64x2_bitmask(self.0))
    }
}

impl Register for F64x2 {
    type Mask = MaskX2;

    #[inline(always)]
    fn splat(self, value: f64) -> Self {
        Self(f64x2_splat(value))
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(f64x2_sqrt(self.0))
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self(f64x2_abs(self.0))
    }

    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        // The instruction gives its second operand where that is larger, and the first one otherwise.
        Self(f64x2_pmax(other.0, self.0))
    }

    #[inline(always)]
    fn is_less(self, other: Self) -> MaskX2 {
        MaskX2(f64x2_lt(self.0, other.0))
    }

    #[inline(always)]
    fn is_at_most(self, other: Self) -> MaskX2 {
        MaskX2(f64x2_le(self.0, other.0))
    }

    #[inline(always)]
    fn or_else(self, mask: MaskX2, other: Self) -> Self {
        Self(v128_bitselect(self.0, other.0, mask.0))
    }

    #[inline(always)]
    fn or_zero(self, mask: MaskX2) -> Self {
        Self(v128_and(self.0, mask.0))
    }
}
