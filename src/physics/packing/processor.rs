//! What is asked of the processor directly: its widest lanes, to fetch memory ahead, and large pages of memory.
//!
//! Invariant: results have the same bits on every processor. The wide versions are compiled from the same source as the
//! plain one, and Rust neither fuses nor reorders floating-point operations; fetching ahead and large pages change no value.
//! Gain, measured at packing fraction 0.3 and 0.7: see `benches/packing_speed.rs`.
#![allow(unsafe_code)]

/// Size of a large page of memory.
#[cfg(target_os = "linux")]
const LARGE_PAGE: usize = 2 << 20;

/// Work that is compiled for several widths of instructions. `run` must be `#[inline(always)]`, and so must be what it calls
/// where it counts.
pub(super) trait WideKernel {
    /// What it returns.
    type Output;

    /// Does the work; `HAS_AVX512` takes the instructions of 512 bits.
    fn run<const HAS_AVX512: bool>(self) -> Self::Output;
}

/// Does work with the widest instructions that this processor has.
pub(super) fn run<K: WideKernel>(kernel: K) -> K::Output {
    InstructionSet::widest().run(kernel)
}

/// How wide instructions are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum InstructionSet {
    /// As the build assumes.
    Plain,
    /// 256 bits.
    #[cfg(target_arch = "x86_64")]
    Avx2,
    /// 512 bits.
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl InstructionSet {
    /// Asks the processor for the widest.
    fn widest() -> Self {
        Self::available().last().unwrap_or(Self::Plain)
    }

    /// Asks the processor for all that it has, the widest last.
    pub(super) fn available() -> impl Iterator<Item = Self> {
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
        std::iter::once(Self::Plain).chain(wider.into_iter().flatten())
    }

    /// Does work with instructions of this width.
    pub(super) fn run<K: WideKernel>(self, kernel: K) -> K::Output {
        match self {
            Self::Plain => kernel.run::<false>(),
            // SAFETY: this value exists only where `available` found the features.
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

/// Asks for the cache line of one of several values that will be wanted soon; past their end, for that of the last one:
/// written without a branch, as whether somebody is there can't be guessed.
#[inline(always)]
pub(super) fn prefetch<T>(values: &[T], index: usize) {
    #[cfg(target_arch = "x86_64")]
    // SAFETY: fetching ahead reads nothing and may be asked of any address.
    unsafe {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let value = values.as_ptr().wrapping_add(index.min(values.len().wrapping_sub(1)));
        _mm_prefetch::<_MM_HINT_T0>(value.cast());
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (values, index);
}

/// Room for so many values, in large pages of memory where the system has them. Discs that meet next stand anywhere, and of
/// small pages the processor knows too few by heart: it would look up nearly each one.
pub(super) fn with_large_pages<T>(capacity: usize) -> Vec<T> {
    let room: Vec<T> = Vec::with_capacity(capacity);
    #[cfg(target_os = "linux")]
    {
        let begin = room.as_ptr().addr();
        let end = begin + room.capacity() * size_of::<T>();
        let (first, last) = (begin.next_multiple_of(LARGE_PAGE), end / LARGE_PAGE * LARGE_PAGE);
        if first < last {
            let place = room.as_ptr().cast::<u8>().wrapping_add(first - begin);
            // SAFETY: the advice changes no value, and it is given for memory of this vector only. It may be refused: then
            // pages are small.
            let _ = unsafe {
                libc::madvise(place.cast_mut().cast(), last - first, libc::MADV_HUGEPAGE)
            };
        }
    }
    room
}

/// The search with instructions of 512 bits: eight pairs side by side. The arithmetic is that of the plain search.
#[cfg(target_arch = "x86_64")]
pub(super) mod wide {
    use super::super::cells::{BlockOffsets, Cells, NO_DISC};
    use super::super::disc::DiscRecord;
    use super::super::events::NEVER;
    use super::super::motion;
    use super::super::scan::{MovingDisc, PredictedContact};
    use crate::collision_time::Numbers;
    use std::arch::x86_64::*;
    use std::ops::{Add, Div, Mul, Sub};

    /// Eight numbers.
    #[derive(Clone, Copy)]
    struct Eight(__m512d);

    /// Up to sixteen discs in order, each in a lane.
    #[repr(C, align(64))]
    struct Candidates([u32; 16]);

    /// Three rows of lanes, one for each row of cells, packed into one row.
    #[derive(Clone, Copy)]
    struct Packing {
        taken: [__mmask16; 3],
        /// InstructionSet before those of the second and of the third row, and of all.
        before: [u32; 3],
    }

    impl Packing {
        /// The lanes that are taken.
        #[inline(always)]
        fn new(taken: [__mmask16; 3]) -> Self {
            let first = taken[0].count_ones();
            let second = first + taken[1].count_ones();
            Self { taken, before: [first, second, second + taken[2].count_ones()] }
        }

        /// Number of lanes.
        #[inline(always)]
        fn count(&self) -> u32 {
            self.before[2]
        }

        /// Packs, with `rest` behind.
        #[inline(always)]
        unsafe fn pack(&self, rows: [__m512i; 3], rest: __m512i) -> __m512i {
            let [first, second, all] = self.before;
            // SAFETY: called in functions of these features only.
            unsafe {
                let packed = _mm512_mask_compress_epi32(rest, self.taken[0], rows[0]);
                let row = _mm512_maskz_compress_epi32(self.taken[1], rows[1]);
                let packed = _mm512_mask_expand_epi32(packed, lanes(first, second), row);
                let row = _mm512_maskz_compress_epi32(self.taken[2], rows[2]);
                _mm512_mask_expand_epi32(packed, lanes(second, all), row)
            }
        }
    }

    /// The lanes from one to before another one.
    #[inline(always)]
    fn lanes(from: u32, to: u32) -> __mmask16 {
        (u32::MAX << from & !(u32::MAX << to)) as __mmask16
    }

    /// Three cells side by side.
    #[inline(always)]
    unsafe fn row(cells: &[[u32; 4]], row: usize, columns: [usize; 3]) -> __m512i {
        // SAFETY: the caller's cells are there. A cell is four words.
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

    /// The lanes of three cells in which another disc stands.
    #[inline(always)]
    unsafe fn taken(row: __m512i, but: __m512i) -> __mmask16 {
        // SAFETY: called in functions of these features only.
        unsafe {
            let taken = _mm512_mask_cmpneq_epi32_mask(0x0FFF, row, _mm512_set1_epi32(-1));
            _mm512_mask_cmpneq_epi32_mask(taken, row, but)
        }
    }

    /// The first contact of one of equal discs with those of the nine cells around it; `None` where there are more than
    /// sixteen of them.
    #[inline(always)]
    pub(in super::super) fn first_contact(
        discs: &[DiscRecord],
        cells: &Cells,
        offsets: &BlockOffsets,
        moving: MovingDisc,
        contact_distance: f64,
    ) -> Option<PredictedContact> {
        let (cells, rows, columns) = cells.block(moving.cell);
        let greatest = |three: [usize; 3]| three[0].max(three[1]).max(three[2]);
        assert!(greatest(rows) + greatest(columns) < cells.len());
        // SAFETY: called in functions of these features only. The cells are there, as was just asked, and the discs, as is
        // asked below.
        unsafe {
            let own = _mm512_set1_epi32(moving.id.cast_signed());
            let slots = [
                row(cells, rows[0], columns),
                row(cells, rows[1], columns),
                row(cells, rows[2], columns),
            ];
            let packing =
                Packing::new([taken(slots[0], own), taken(slots[1], own), taken(slots[2], own)]);
            if packing.count() > 16 {
                return None;
            }
            // The lanes that are left over look at the disc itself, which it never touches.
            let partners = packing.pack(slots, own);
            let outside = _mm512_cmpge_epu32_mask(partners, _mm512_set1_epi32(discs.len() as i32));
            assert!(outside == 0);
            let places = packing.pack(
                [
                    _mm512_setr_epi32(0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 0, 0, 0, 0),
                    _mm512_setr_epi32(3, 3, 3, 3, 4, 4, 4, 4, 5, 5, 5, 5, 0, 0, 0, 0),
                    _mm512_setr_epi32(6, 6, 6, 6, 7, 7, 7, 7, 8, 8, 8, 8, 0, 0, 0, 0),
                ],
                _mm512_set1_epi32(4),
            );
            let mut near = Candidates([0; 16]);
            _mm512_store_si512(near.0.as_mut_ptr().cast(), partners);
            let near_places = _mm512_castsi512_si256(places);
            let first = waits(discs, &near, 0, near_places, offsets, moving, contact_distance);
            let mut second = _mm512_set1_pd(NEVER);
            if packing.count() > 8 {
                let near_places = _mm512_extracti64x4_epi64::<1>(places);
                second = waits(discs, &near, 8, near_places, offsets, moving, contact_distance);
            }
            let wait = _mm512_reduce_min_pd(_mm512_min_pd(first, second));
            let all = _mm512_set1_pd(wait);
            let earliest = u32::from(_mm512_cmp_pd_mask::<_CMP_EQ_OQ>(first, all))
                | u32::from(_mm512_cmp_pd_mask::<_CMP_EQ_OQ>(second, all)) << 8;
            let mut partner = near.0[earliest.trailing_zeros() as usize % 16];
            if (earliest & earliest.wrapping_sub(1) != 0) & (wait < NEVER) {
                partner = least_of(&near, earliest);
            }
            partner = if wait < NEVER { partner } else { moving.id };
            Some(PredictedContact { wait, partner })
        }
    }

    /// The least number in these lanes.
    #[cold]
    fn least_of(near: &Candidates, lanes: u32) -> u32 {
        let partners = near.0.into_iter().enumerate();
        partners.fold(
            NO_DISC,
            |least, (lane, disc)| {
                if lanes >> lane & 1 == 1 && disc < least { disc } else { least }
            },
        )
    }

    /// Two numbers of each of four discs, in every other lane.
    #[inline(always)]
    unsafe fn pairs(numbers: [*const f64; 4]) -> __m512d {
        // SAFETY: the caller's numbers are there.
        unsafe {
            let low = _mm256_set_m128d(_mm_load_pd(numbers[1]), _mm_load_pd(numbers[0]));
            let high = _mm256_set_m128d(_mm_load_pd(numbers[3]), _mm_load_pd(numbers[2]));
            _mm512_insertf64x4::<1>(_mm512_castpd256_pd512(low), high)
        }
    }

    /// A vector of each of eight discs, as x and y.
    ///
    /// Vectors are loaded as they were written: what was written just now is at hand only so. Those of the even and of the
    /// odd lanes, unpacked, are the coordinates in the order of the lanes.
    #[inline(always)]
    unsafe fn vectors(records: [*const f64; 8], offset: usize) -> [Eight; 2] {
        let [r0, r1, r2, r3, r4, r5, r6, r7] = records;
        // SAFETY: the caller's records are there, and two numbers behind their offset.
        unsafe {
            let even = pairs([r0.add(offset), r2.add(offset), r4.add(offset), r6.add(offset)]);
            let odd = pairs([r1.add(offset), r3.add(offset), r5.add(offset), r7.add(offset)]);
            [Eight(_mm512_unpacklo_pd(even, odd)), Eight(_mm512_unpackhi_pd(even, odd))]
        }
    }

    /// The last times of two discs.
    #[inline(always)]
    unsafe fn times(first: *const f64, second: *const f64) -> __m128d {
        // SAFETY: the caller's records are there; the fifth number is the time.
        unsafe { _mm_loadh_pd(_mm_load_sd(first.add(4)), second.add(4)) }
    }

    /// Where the cells of eight places begin, along one axis.
    #[inline(always)]
    unsafe fn shift(table: &[f64; 16], places: __m512i) -> Eight {
        // SAFETY: called in functions of these features only. The table is two registers.
        unsafe {
            let (low, high) = (table.as_ptr(), table.as_ptr().add(8));
            Eight(_mm512_permutex2var_pd(_mm512_loadu_pd(low), places, _mm512_loadu_pd(high)))
        }
    }

    /// When a disc touches eight others.
    #[inline(always)]
    unsafe fn waits(
        discs: &[DiscRecord],
        near: &Candidates,
        from: usize,
        places: __m256i,
        offsets: &BlockOffsets,
        moving: MovingDisc,
        contact_distance: f64,
    ) -> __m512d {
        // SAFETY: the caller's discs are there. A record begins with position, velocity and time, five numbers.
        unsafe {
            let mut records = [std::ptr::null::<f64>(); 8];
            for (lane, record) in records.iter_mut().enumerate() {
                *record = discs.as_ptr().add(near.0[from + lane] as usize).cast();
            }
            let position = vectors(records, 0);
            let velocity = vectors(records, 2);
            let [r0, r1, r2, r3, r4, r5, r6, r7] = records;
            let low = _mm256_set_m128d(times(r2, r3), times(r0, r1));
            let high = _mm256_set_m128d(times(r6, r7), times(r4, r5));
            let time = Eight(_mm512_insertf64x4::<1>(_mm512_castpd256_pd512(low), high));
            let places = _mm512_cvtepu32_epi64(places);
            let shift = [shift(&offsets[0], places), shift(&offsets[1], places)];
            let age = Eight::all(moving.now) - time;
            let own = [Eight::all(moving.position[0]), Eight::all(moving.position[1])];
            let separation = [
                position[0] + shift[0] + velocity[0] * age - own[0],
                position[1] + shift[1] + velocity[1] * age - own[1],
            ];
            let relative = [
                velocity[0] - Eight::all(moving.velocity[0]),
                velocity[1] - Eight::all(moving.velocity[1]),
            ];
            motion::time_to_contact(separation, relative, Eight::all(contact_distance)).0
        }
    }

    macro_rules! operation {
        ($name:ident, $method:ident, $instruction:ident) => {
            impl $name for Eight {
                type Output = Self;

                #[inline(always)]
                fn $method(self, other: Self) -> Self {
                    // SAFETY: a value is made in functions of these features only.
                    Self(unsafe { $instruction(self.0, other.0) })
                }
            }
        };
    }
    operation!(Add, add, _mm512_add_pd);
    operation!(Sub, sub, _mm512_sub_pd);
    operation!(Mul, mul, _mm512_mul_pd);
    operation!(Div, div, _mm512_div_pd);

    // SAFETY of all: a value is made in functions of these features only.
    impl Numbers for Eight {
        type Truth = __mmask8;

        #[inline(always)]
        fn all(number: f64) -> Self {
            Self(unsafe { _mm512_set1_pd(number) })
        }

        #[inline(always)]
        fn positive_part(self) -> Self {
            // The second operand where the first is no number: as x > 0 does not hold.
            Self(unsafe { _mm512_max_pd(self.0, _mm512_setzero_pd()) })
        }

        #[inline(always)]
        fn sqrt(self) -> Self {
            Self(unsafe { _mm512_sqrt_pd(self.0) })
        }

        #[inline(always)]
        fn is_negative(self) -> __mmask8 {
            unsafe { _mm512_cmp_pd_mask::<_CMP_LT_OQ>(self.0, _mm512_setzero_pd()) }
        }

        #[inline(always)]
        fn is_not_negative(self) -> __mmask8 {
            unsafe { _mm512_cmp_pd_mask::<_CMP_GE_OQ>(self.0, _mm512_setzero_pd()) }
        }

        #[inline(always)]
        fn is_not_positive(self) -> __mmask8 {
            unsafe { _mm512_cmp_pd_mask::<_CMP_LE_OQ>(self.0, _mm512_setzero_pd()) }
        }

        #[inline(always)]
        fn choose(truth: __mmask8, one: Self, other: Self) -> Self {
            Self(unsafe { _mm512_mask_blend_pd(truth, other.0, one.0) })
        }
    }
}

/// Without those instructions nobody asks for them.
#[cfg(not(target_arch = "x86_64"))]
pub(super) mod wide {
    use super::super::cells::{BlockOffsets, Cells};
    use super::super::disc::DiscRecord;
    use super::super::scan::{MovingDisc, PredictedContact};

    pub(in super::super) fn first_contact(
        _: &[DiscRecord],
        _: &Cells,
        _: &BlockOffsets,
        _: MovingDisc,
        _: f64,
    ) -> Option<PredictedContact> {
        None
    }
}
