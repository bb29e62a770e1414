//! The contact scan in AVX-512 registers: eight pairs at a time, for discs of equal radius.
//!
//! The arithmetic is that of the portable scan (`scan`); results are bitwise identical. The gain is listed in
//! `benches/packing_speed.rs`.
//!
//! # Safety
//! - Intrinsics: [`first_contact`] is called only in code that is compiled for AVX-512 and runs only where the processor has
//!   it (`simd::registers`).
//! - Cells are read without bounds checks after an assertion on the largest index of the block.
//! - Disc records are read without bounds checks after an assertion on the ids of all lanes. A record is `repr(C)` and begins
//!   with position, velocity and time, which are five numbers.

#![allow(unsafe_code)]

use super::contact::{MovingDisc, PredictedContact};
use super::disc::DiscRecord;
use super::events::NEVER;
use super::motion;

use crate::cell_grid::BlockOffsets;
use crate::cell_lists::{CellLists, NO_DISC};
use crate::simd::avx512::F64x8;
use crate::simd::registers::Register;
use std::arch::x86_64::*;

/// Ids of up to sixteen candidates, one per lane.
#[repr(C, align(64))]
struct CandidateIds([u32; 16]);

/// Mask compression: packs the selected lanes of three registers, one per row of cells, into one register.
#[derive(Clone, Copy)]
struct RowCompression {
    selected: [__mmask16; 3],
    /// Number of selected lanes up to the end of each row.
    ends: [u32; 3],
}

impl RowCompression {
    #[inline(always)]
    fn new(selected: [__mmask16; 3]) -> Self {
        let first = selected[0].count_ones();
        let second = first + selected[1].count_ones();
        Self { selected, ends: [first, second, second + selected[2].count_ones()] }
    }

    /// Number of selected lanes.
    #[inline(always)]
    fn count(&self) -> u32 {
        self.ends[2]
    }

    /// Packs the selected lanes; the remaining ones are those of `rest`.
    ///
    /// # Safety
    /// The processor has AVX-512.
    #[inline(always)]
    unsafe fn pack(&self, rows: [__m512i; 3], rest: __m512i) -> __m512i {
        let [first, second, all] = self.ends;
        // SAFETY: required of the caller.
        unsafe {
            let packed = _mm512_mask_compress_epi32(rest, self.selected[0], rows[0]);
            let row = _mm512_maskz_compress_epi32(self.selected[1], rows[1]);
            let packed = _mm512_mask_expand_epi32(packed, lane_range(first, second), row);
            let row = _mm512_maskz_compress_epi32(self.selected[2], rows[2]);
            _mm512_mask_expand_epi32(packed, lane_range(second, all), row)
        }
    }
}

/// The mask of the lanes `from..to`.
#[inline(always)]
fn lane_range(from: u32, to: u32) -> __mmask16 {
    (u32::MAX << from & !(u32::MAX << to)) as __mmask16
}

/// Loads the slots of three adjacent cells.
///
/// # Safety
/// The processor has AVX-512, and `row + column` is in bounds for each column. A cell is four words.
#[inline(always)]
unsafe fn load_row(cells: &[[u32; 4]], row: usize, columns: [usize; 3]) -> __m512i {
    // SAFETY: required of the caller.
    unsafe {
        let cells = cells.as_ptr().add(row);
        let left = _mm_loadu_si128(cells.add(columns[0]).cast());
        let own = _mm_loadu_si128(cells.add(columns[1]).cast());
        let right = _mm_loadu_si128(cells.add(columns[2]).cast());
        _mm512_inserti64x4::<1>(
            _mm512_castsi256_si512(_mm256_set_m128i(own, left)),
            _mm256_zextsi128_si256(right),
        )
    }
}

/// Selects the slots of a row that contain a disc other than `excluded`.
///
/// # Safety
/// The processor has AVX-512.
#[inline(always)]
unsafe fn occupied(row: __m512i, excluded: __m512i) -> __mmask16 {
    // SAFETY: required of the caller.
    unsafe {
        let occupied = _mm512_mask_cmpneq_epi32_mask(0x0FFF, row, _mm512_set1_epi32(-1));
        _mm512_mask_cmpneq_epi32_mask(occupied, row, excluded)
    }
}

/// Finds the first contact of a disc with the discs of the 3 x 3 block around its cell; all radii are equal. Returns `None`
/// if the block has more than sixteen other discs.
#[inline(always)]
pub(super) fn first_contact(
    discs: &[DiscRecord],
    cells: &CellLists,
    offsets: &BlockOffsets,
    moving: MovingDisc,
    contact_distance: f64,
) -> Option<PredictedContact> {
    let (cells, rows, columns) = cells.block_indices(moving.cell);
    let largest = |three: [usize; 3]| three[0].max(three[1]).max(three[2]);
    assert!(largest(rows) + largest(columns) < cells.len());
    // SAFETY: the line above checks the cells, the assertion below checks the ids of the discs.
    unsafe {
        let own = _mm512_set1_epi32(moving.id.cast_signed());
        let slots = [
            load_row(cells, rows[0], columns),
            load_row(cells, rows[1], columns),
            load_row(cells, rows[2], columns),
        ];
        let compression = RowCompression::new([
            occupied(slots[0], own),
            occupied(slots[1], own),
            occupied(slots[2], own),
        ]);
        if compression.count() > 16 {
            return None;
        }
        // The remaining lanes contain the disc itself, which it never touches.
        let partners = compression.pack(slots, own);
        let outside = _mm512_cmpge_epu32_mask(partners, _mm512_set1_epi32(discs.len() as i32));
        assert!(outside == 0);
        // The cell of each lane within the block.
        let block_cells = compression.pack(
            [
                _mm512_setr_epi32(0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 0, 0, 0, 0),
                _mm512_setr_epi32(3, 3, 3, 3, 4, 4, 4, 4, 5, 5, 5, 5, 0, 0, 0, 0),
                _mm512_setr_epi32(6, 6, 6, 6, 7, 7, 7, 7, 8, 8, 8, 8, 0, 0, 0, 0),
            ],
            _mm512_set1_epi32(4),
        );
        let mut ids = CandidateIds([0; 16]);
        _mm512_store_si512(ids.0.as_mut_ptr().cast(), partners);
        let half = _mm512_castsi512_si256(block_cells);
        let first = contact_times(discs, &ids, 0, half, offsets, moving, contact_distance);
        let mut second = _mm512_set1_pd(NEVER);
        if compression.count() > 8 {
            let half = _mm512_extracti64x4_epi64::<1>(block_cells);
            second = contact_times(discs, &ids, 8, half, offsets, moving, contact_distance);
        }
        Some(earliest(&ids, [first, second], moving.id))
    }
}

/// The earliest of sixteen contacts; of several at the same time, the one with the smallest id.
///
/// # Safety
/// The processor has AVX-512.
#[inline(always)]
unsafe fn earliest(ids: &CandidateIds, times: [__m512d; 2], own: u32) -> PredictedContact {
    // SAFETY: required of the caller.
    let (time, lanes) = unsafe {
        let time = _mm512_reduce_min_pd(_mm512_min_pd(times[0], times[1]));
        let all = _mm512_set1_pd(time);
        let lanes = u32::from(_mm512_cmp_pd_mask::<_CMP_EQ_OQ>(times[0], all))
            | u32::from(_mm512_cmp_pd_mask::<_CMP_EQ_OQ>(times[1], all)) << 8;
        (time, lanes)
    };
    let mut partner = ids.0[lanes.trailing_zeros() as usize % 16];
    if (lanes & lanes.wrapping_sub(1) != 0) & (time < NEVER) {
        partner = smallest_id(ids, lanes);
    }
    partner = if time < NEVER { partner } else { own };
    PredictedContact { time_to_contact: time, partner }
}

/// The smallest id in these lanes.
#[cold]
fn smallest_id(ids: &CandidateIds, lanes: u32) -> u32 {
    let ids = ids.0.into_iter().enumerate();
    ids.fold(
        NO_DISC,
        |smallest, (lane, id)| {
            if lanes >> lane & 1 == 1 && id < smallest { id } else { smallest }
        },
    )
}

/// Loads two numbers of each of four records.
///
/// # Safety
/// The processor has AVX-512, and two numbers are at each address, aligned to 16 bytes.
#[inline(always)]
unsafe fn load_pairs(numbers: [*const f64; 4]) -> __m512d {
    // SAFETY: required of the caller.
    unsafe {
        let low = _mm256_set_m128d(_mm_load_pd(numbers[1]), _mm_load_pd(numbers[0]));
        let high = _mm256_set_m128d(_mm_load_pd(numbers[3]), _mm_load_pd(numbers[2]));
        _mm512_insertf64x4::<1>(_mm512_castpd256_pd512(low), high)
    }
}

/// Loads a vector of each of eight records, as x and y.
///
/// Vectors are loaded in the width in which they were written, because a wider load cannot be forwarded from the store
/// buffer. Those of the even and of the odd lanes, unpacked, are the coordinates in the order of the lanes.
///
/// # Safety
/// The processor has AVX-512, and two numbers are at this offset of each record.
#[inline(always)]
unsafe fn load_vectors(records: [*const f64; 8], offset: usize) -> [F64x8; 2] {
    let [r0, r1, r2, r3, r4, r5, r6, r7] = records;
    // SAFETY: required of the caller.
    unsafe {
        let even = load_pairs([r0.add(offset), r2.add(offset), r4.add(offset), r6.add(offset)]);
        let odd = load_pairs([r1.add(offset), r3.add(offset), r5.add(offset), r7.add(offset)]);
        [F64x8(_mm512_unpacklo_pd(even, odd)), F64x8(_mm512_unpackhi_pd(even, odd))]
    }
}

/// Loads the times of two records.
///
/// # Safety
/// Both are addresses of records; the fifth number is the time.
#[inline(always)]
unsafe fn load_times(first: *const f64, second: *const f64) -> __m128d {
    // SAFETY: required of the caller.
    unsafe { _mm_loadh_pd(_mm_load_sd(first.add(4)), second.add(4)) }
}

/// Looks up the offsets of eight cells of the block along one axis.
///
/// # Safety
/// The processor has AVX-512. The table is two registers.
#[inline(always)]
unsafe fn look_up_offsets(table: &[f64; 16], block_cells: __m512i) -> F64x8 {
    // SAFETY: required of the caller.
    unsafe {
        let (low, high) = (table.as_ptr(), table.as_ptr().add(8));
        F64x8(_mm512_permutex2var_pd(_mm512_loadu_pd(low), block_cells, _mm512_loadu_pd(high)))
    }
}

/// Calculates the times until a disc touches the eight candidates of the lanes from `from` on.
///
/// # Safety
/// The processor has AVX-512, and all ids are in bounds.
#[inline(always)]
unsafe fn contact_times(
    discs: &[DiscRecord],
    ids: &CandidateIds,
    from: usize,
    block_cells: __m256i,
    offsets: &BlockOffsets,
    moving: MovingDisc,
    contact_distance: f64,
) -> __m512d {
    // SAFETY: required of the caller.
    unsafe {
        let mut records = [std::ptr::null::<f64>(); 8];
        for (lane, record) in records.iter_mut().enumerate() {
            *record = discs.as_ptr().add(ids.0[from + lane] as usize).cast();
        }
        let position = load_vectors(records, 0);
        let velocity = load_vectors(records, 2);
        let [r0, r1, r2, r3, r4, r5, r6, r7] = records;
        let low = _mm256_set_m128d(load_times(r2, r3), load_times(r0, r1));
        let high = _mm256_set_m128d(load_times(r6, r7), load_times(r4, r5));
        let time = F64x8(_mm512_insertf64x4::<1>(_mm512_castpd256_pd512(low), high));
        let block_cells = _mm512_cvtepu32_epi64(block_cells);
        let offset = [
            look_up_offsets(&offsets.columns[0], block_cells),
            look_up_offsets(&offsets.columns[1], block_cells),
        ];
        let age = time.splat(moving.now) - time;
        let own = [time.splat(moving.position[0]), time.splat(moving.position[1])];
        let separation = [
            position[0] + offset[0] + velocity[0] * age - own[0],
            position[1] + offset[1] + velocity[1] * age - own[1],
        ];
        let relative = [
            velocity[0] - time.splat(moving.velocity[0]),
            velocity[1] - time.splat(moving.velocity[1]),
        ];
        motion::time_to_contact(separation, relative, time.splat(contact_distance)).0
    }
}
