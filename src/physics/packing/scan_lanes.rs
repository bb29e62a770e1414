//! The contact scan in registers of four (AVX2) or two numbers (SSE2), for discs of equal radius.
//!
//! The slots of the block are examined at once: one bit per slot says whether it holds another disc. The first eight of them
//! are processed without a branch, which is enough in nearly every dilute and in most dense systems; up to eight more follow, by
//! four.
//!
//! The arithmetic is that of the portable scan (`scan`); results are bitwise identical. The gain is listed in
//! `benches/packing_speed.rs`.
//!
//! # Safety
//! - [`first_contact`] with the registers of AVX2 is called only in code that is compiled for AVX2 and runs only where the
//!   processor has it (`simd::registers`).
//! - Every x86-64 processor has SSE2.
//! - Loads go through references to as many numbers as are moved. Cells are read without bounds checks after an assertion on
//!   the largest index of the block; at most sixteen slots are taken, and the bits of sixteen slots behind the block are set.

#![allow(unsafe_code)]

use super::contact::{MovingDisc, PredictedContact, ScanInput};
use super::disc::DiscRecord;
use super::events::NEVER;
use super::motion::{self, Vector};
use crate::cell_grid::BlockOffsets;
use crate::cell_lists::{CellLists, NO_DISC};
use crate::simd::avx2::F64x4;
use crate::simd::registers::Register;
use crate::simd::sse2::F64x2;
use std::arch::x86_64::*;

/// Candidates that are processed together.
const ROUND: usize = 8;

/// Slots of a block.
const SLOTS: usize = 36;

/// Largest number of discs: the sign bit of an id tells an empty slot.
const MAX_DISCS: usize = i32::MAX as usize;

/// A register that can gather what a scan reads.
pub(super) trait ScanRegister<const N: usize>: Register {
    /// A number in every lane.
    fn new(number: f64) -> Self;
    /// One number per lane.
    fn numbers(numbers: [&f64; N]) -> Self;
    /// The x and the y of one vector per lane.
    fn vectors(vectors: [&Vector; N]) -> [Self; 2];
    /// The x and the y of the sum of two vectors per lane.
    fn sums(one: [&Vector; N], other: [&Vector; N]) -> [Self; 2];
    /// `if self < other { self } else { other }`
    fn smaller(self, other: Self) -> Self;
    /// The smallest number of all lanes.
    fn smallest(self) -> f64;
    /// The lanes of eight numbers that contain a number, as bits.
    fn lanes_equal_to(numbers: &[Self; 4], number: f64) -> u32;
}

/// The slots of a block, and those that contain another disc.
#[repr(C, align(64))]
struct Block {
    /// The block's slots, and the disc itself, which it never touches, in the place of missing candidates.
    slots: [__m128i; SLOTS / 4 + 2 * ROUND / 4],
    /// One bit per slot that contains another disc, and ones above.
    candidates: u64,
}

impl Block {
    /// Reads the slots. A slot is empty if its sign bit is set.
    #[inline(always)]
    fn new(cells: &CellLists, moving: &MovingDisc) -> Self {
        let (cells, rows, columns) = cells.block_indices(moving.cell);
        let largest = |three: [usize; 3]| three[0].max(three[1]).max(three[2]);
        assert!(largest(rows) + largest(columns) < cells.len());
        // SAFETY: every x86-64 processor has SSE2; the line above checks the cells, which are four u32 each.
        unsafe {
            let own = _mm_set1_epi32(moving.id.cast_signed());
            let mut slots = [own; SLOTS / 4 + 2 * ROUND / 4];
            let mut excluded = [own; SLOTS / 4];
            for cell in 0..SLOTS / 4 {
                let content = cells.get_unchecked(rows[cell / 3] + columns[cell % 3]);
                let content = _mm_loadu_si128(content.as_ptr().cast());
                slots[cell] = content;
                // The disc itself is in the central cell, or in the one that it is leaving by a side.
                excluded[cell] = if matches!(cell, 1 | 3 | 4 | 5 | 7) {
                    _mm_or_si128(content, _mm_cmpeq_epi32(content, own))
                } else {
                    content
                };
            }
            let last = _mm_movemask_ps(_mm_castsi128_ps(excluded[8])).cast_unsigned();
            let empty = signs([excluded[0], excluded[1], excluded[2], excluded[3]])
                | signs([excluded[4], excluded[5], excluded[6], excluded[7]]) << 16
                | u64::from(last) << 32;
            Self { slots, candidates: !empty }
        }
    }

    /// Number of candidates.
    #[inline(always)]
    fn count(&self) -> usize {
        (self.candidates << (64 - SLOTS)).count_ones() as usize
    }

    /// The disc in a slot that is a candidate.
    #[inline(always)]
    fn disc_in(&self, slot: usize) -> u32 {
        let slots: &[u32; 4 * (SLOTS / 4 + 2 * ROUND / 4)] = bytemuck::cast_ref(&self.slots);
        // SAFETY: at most sixteen candidates are taken, and the bits above those of the slots are set.
        unsafe { *slots.get_unchecked(slot) }
    }
}

/// The sign bits of sixteen integers.
#[inline(always)]
fn signs([a, b, c, d]: [__m128i; 4]) -> u64 {
    // SAFETY: every x86-64 processor has SSE2.
    let bits = unsafe {
        // Packing saturates and keeps the signs.
        let bytes = _mm_packs_epi16(_mm_packs_epi32(a, b), _mm_packs_epi32(c, d));
        _mm_movemask_epi8(bytes)
    };
    u64::from(bits.cast_unsigned())
}

/// Finds the first contact of a disc with the discs of the 3 x 3 block around its cell; all radii are equal. Returns `None`
/// if the block has more than sixteen other discs, or if there are more than [`MAX_DISCS`].
#[inline(always)]
pub(super) fn first_contact<const N: usize, R: ScanRegister<N>, const FALLS: bool>(
    input: ScanInput<'_>,
    moving: MovingDisc,
    contact_distance: f64,
) -> Option<PredictedContact> {
    let ScanInput { discs, cells, offsets, gravity, .. } = input;
    let mut block = Block::new(cells, &moving);
    let count = block.count();
    if (count > 2 * ROUND) | (discs.len() > MAX_DISCS) {
        return None;
    }
    let mut ids = [moving.id; 2 * ROUND];
    let mut rounds = [[R::new(NEVER); 4]; 2];
    let scan = Scan::<FALLS> { discs, offsets, moving: &moving, contact_distance, gravity };
    let ([early, _], (first, _)) = (&mut rounds, ids.split_at_mut(ROUND));
    scan.next_four::<N, R>(&mut block, &mut first[..4], &mut early[..4 / N]);
    scan.next_four::<N, R>(&mut block, &mut first[4..], &mut early[4 / N..]);
    let mut least = smallest_of::<N, R>(&rounds[0]);
    if count > ROUND {
        let ([_, late], (_, second)) = (&mut rounds, ids.split_at_mut(ROUND));
        scan.next_four::<N, R>(&mut block, &mut second[..4], &mut late[..4 / N]);
        if count > ROUND + 4 {
            scan.next_four::<N, R>(&mut block, &mut second[4..], &mut late[4 / N..]);
        }
        least = least.smaller(smallest_of::<N, R>(&rounds[1]));
    }
    let time = least.smallest();
    let mut lanes = R::lanes_equal_to(&rounds[0], time);
    if count > ROUND {
        lanes |= R::lanes_equal_to(&rounds[1], time) << ROUND;
    }
    let mut partner = ids[lanes.trailing_zeros() as usize % (2 * ROUND)];
    if (lanes & lanes.wrapping_sub(1) != 0) & (time < NEVER) {
        partner = smallest_id(&ids, lanes);
    }
    partner = if time < NEVER { partner } else { moving.id };
    Some(PredictedContact { time_to_contact: time, partner })
}

/// The smallest number of each lane.
#[inline(always)]
fn smallest_of<const N: usize, R: ScanRegister<N>>(times: &[R; 4]) -> R {
    let mut least = times[0];
    for &register in &times[1..ROUND / N] {
        least = least.smaller(register);
    }
    least
}

/// What a scan reads.
struct Scan<'a, const FALLS: bool> {
    discs: &'a [DiscRecord],
    offsets: &'a BlockOffsets,
    moving: &'a MovingDisc,
    contact_distance: f64,
    gravity: f64,
}

impl<const FALLS: bool> Scan<'_, FALLS> {
    /// The next four candidates of a block, and the times until the disc touches them.
    #[inline(always)]
    fn next_four<const N: usize, R: ScanRegister<N>>(
        &self,
        block: &mut Block,
        ids: &mut [u32],
        times: &mut [R],
    ) {
        for register in 0..4 / N {
            let mut records = [&self.discs[0]; N];
            let mut offsets = [&self.offsets.vectors[0]; N];
            for lane in 0..N {
                let slot = block.candidates.trailing_zeros() as usize;
                block.candidates &= block.candidates - 1;
                let id = block.disc_in(slot);
                ids[register * N + lane] = id;
                records[lane] = &self.discs[id as usize];
                offsets[lane] = &self.offsets.vectors[slot / 4 % 16];
            }
            times[register] = self.times_to::<N, R>(records, offsets);
        }
    }

    /// The times until the disc touches the discs of the lanes.
    #[inline(always)]
    fn times_to<const N: usize, R: ScanRegister<N>>(
        &self,
        records: [&DiscRecord; N],
        offsets: [&Vector; N],
    ) -> R {
        let Self { moving, contact_distance, .. } = *self;
        let (mut positions, mut velocities, mut times) = (offsets, offsets, [&0.0; N]);
        for lane in 0..N {
            positions[lane] = &records[lane].position;
            velocities[lane] = &records[lane].velocity;
            times[lane] = &records[lane].time;
        }
        let position = R::sums(positions, offsets);
        let mut velocity = R::vectors(velocities);
        let age = R::new(moving.now) - R::numbers(times);
        let mut position = [position[0] + velocity[0] * age, position[1] + velocity[1] * age];
        if FALLS {
            let fall = R::new(self.gravity) * age;
            position[1] = position[1] - R::new(0.5) * fall * age;
            velocity[1] = velocity[1] - fall;
        }
        let separation =
            [position[0] - R::new(moving.position[0]), position[1] - R::new(moving.position[1])];
        let relative =
            [velocity[0] - R::new(moving.velocity[0]), velocity[1] - R::new(moving.velocity[1])];
        motion::time_to_contact(separation, relative, R::new(contact_distance))
    }
}

/// The smallest id in these lanes.
#[cold]
fn smallest_id(ids: &[u32; 2 * ROUND], lanes: u32) -> u32 {
    let ids = ids.iter().enumerate();
    let in_lanes = ids.filter(|(lane, _)| lanes >> lane & 1 == 1);
    in_lanes.fold(NO_DISC, |smallest, (_, &id)| if id < smallest { id } else { smallest })
}

// SAFETY of all that follows: every x86-64 processor has SSE2.
impl ScanRegister<2> for F64x2 {
    #[inline(always)]
    fn new(number: f64) -> Self {
        unsafe { Self(_mm_set1_pd(number)) }
    }

    #[inline(always)]
    fn numbers([first, second]: [&f64; 2]) -> Self {
        unsafe { Self(_mm_set_pd(*second, *first)) }
    }

    #[inline(always)]
    fn vectors([first, second]: [&Vector; 2]) -> [Self; 2] {
        unsafe {
            let [first, second] = [pair(first), pair(second)];
            [Self(_mm_unpacklo_pd(first, second)), Self(_mm_unpackhi_pd(first, second))]
        }
    }

    #[inline(always)]
    fn sums(one: [&Vector; 2], other: [&Vector; 2]) -> [Self; 2] {
        unsafe {
            let first = _mm_add_pd(pair(one[0]), pair(other[0]));
            let second = _mm_add_pd(pair(one[1]), pair(other[1]));
            [Self(_mm_unpacklo_pd(first, second)), Self(_mm_unpackhi_pd(first, second))]
        }
    }

    #[inline(always)]
    fn smaller(self, other: Self) -> Self {
        unsafe { Self(_mm_min_pd(self.0, other.0)) }
    }

    #[inline(always)]
    fn smallest(self) -> f64 {
        unsafe { _mm_cvtsd_f64(_mm_min_sd(self.0, _mm_unpackhi_pd(self.0, self.0))) }
    }

    #[inline(always)]
    fn lanes_equal_to(numbers: &[Self; 4], number: f64) -> u32 {
        unsafe {
            let number = _mm_set1_pd(number);
            let [a, b, c, d] = *numbers;
            let [a, b] = [_mm_cmpeq_pd(a.0, number), _mm_cmpeq_pd(b.0, number)];
            let [c, d] = [_mm_cmpeq_pd(c.0, number), _mm_cmpeq_pd(d.0, number)];
            let low = _mm_packs_epi32(_mm_castpd_si128(a), _mm_castpd_si128(b));
            let high = _mm_packs_epi32(_mm_castpd_si128(c), _mm_castpd_si128(d));
            // Eight lanes of sixteen bits, four of them twice.
            let low = _mm_packs_epi32(low, high);
            _mm_movemask_epi8(_mm_packs_epi16(low, low)).cast_unsigned() & 0xff
        }
    }
}

#[inline(always)]
fn pair(vector: &Vector) -> __m128d {
    // SAFETY: every x86-64 processor has SSE2; two numbers lie behind the reference.
    unsafe { _mm_loadu_pd(vector.as_ptr()) }
}

/// Two vectors in one register.
///
/// # Safety
/// The processor has AVX.
#[inline(always)]
unsafe fn two_pairs(low: &Vector, high: &Vector) -> __m256d {
    // SAFETY: required of the caller.
    unsafe { _mm256_insertf128_pd::<1>(_mm256_castpd128_pd256(pair(low)), pair(high)) }
}

// SAFETY of all that follows: these registers are used only in code compiled for AVX2.
impl ScanRegister<4> for F64x4 {
    #[inline(always)]
    fn new(number: f64) -> Self {
        Self(unsafe { _mm256_set1_pd(number) })
    }

    #[inline(always)]
    fn numbers([a, b, c, d]: [&f64; 4]) -> Self {
        Self(unsafe { _mm256_setr_pd(*a, *b, *c, *d) })
    }

    #[inline(always)]
    fn vectors([a, b, c, d]: [&Vector; 4]) -> [Self; 2] {
        unsafe {
            let (even, odd) = (two_pairs(a, c), two_pairs(b, d));
            [Self(_mm256_unpacklo_pd(even, odd)), Self(_mm256_unpackhi_pd(even, odd))]
        }
    }

    #[inline(always)]
    fn sums([a, b, c, d]: [&Vector; 4], [e, f, g, h]: [&Vector; 4]) -> [Self; 2] {
        unsafe {
            let even = _mm256_add_pd(two_pairs(a, c), two_pairs(e, g));
            let odd = _mm256_add_pd(two_pairs(b, d), two_pairs(f, h));
            [Self(_mm256_unpacklo_pd(even, odd)), Self(_mm256_unpackhi_pd(even, odd))]
        }
    }

    #[inline(always)]
    fn smaller(self, other: Self) -> Self {
        Self(unsafe { _mm256_min_pd(self.0, other.0) })
    }

    #[inline(always)]
    fn smallest(self) -> f64 {
        unsafe {
            let halves = [_mm256_castpd256_pd128(self.0), _mm256_extractf128_pd::<1>(self.0)];
            F64x2(_mm_min_pd(halves[0], halves[1])).smallest()
        }
    }

    #[inline(always)]
    fn lanes_equal_to(numbers: &[Self; 4], number: f64) -> u32 {
        unsafe {
            let number = _mm256_set1_pd(number);
            let low = _mm256_cmp_pd::<_CMP_EQ_OQ>(numbers[0].0, number);
            let high = _mm256_cmp_pd::<_CMP_EQ_OQ>(numbers[1].0, number);
            (_mm256_movemask_pd(low) | _mm256_movemask_pd(high) << 4).cast_unsigned()
        }
    }
}
