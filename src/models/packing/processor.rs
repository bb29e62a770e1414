//! What is asked of the processor directly: its widest lanes, and to fetch memory ahead.
//!
//! Invariant: results have the same bits on every processor. The wide versions are compiled from the same source as the
//! plain one, and Rust neither fuses nor reorders floating-point operations; fetching ahead changes no value.
//! Gain, measured at packing fraction 0.3 and 0.7: see `benches/packing_speed.rs`.
#![allow(unsafe_code)]

use super::motion::Vector;
use super::scan::{Contact, Field, first_contact};

/// The widest lanes that this processor has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Lanes {
    /// As the build assumes.
    Plain,
    /// 256 bits.
    #[cfg(target_arch = "x86_64")]
    Avx2,
    /// 512 bits.
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl Lanes {
    /// Asks the processor for the widest.
    pub(super) fn widest() -> Self {
        Self::available().last().unwrap_or(Self::Plain)
    }

    /// Asks the processor for all that it has, the widest last.
    pub(super) fn available() -> impl Iterator<Item = Self> {
        #[cfg(target_arch = "x86_64")]
        let wider = [
            is_x86_feature_detected!("avx2").then_some(Self::Avx2),
            (is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512vl"))
                .then_some(Self::Avx512),
        ];
        #[cfg(not(target_arch = "x86_64"))]
        let wider: [Option<Self>; 0] = [];
        std::iter::once(Self::Plain).chain(wider.into_iter().flatten())
    }

    /// [`first_contact`] in these lanes.
    #[inline(always)]
    pub(super) fn first_contact(
        self,
        field: Field<'_>,
        disc: u32,
        position: Vector,
        now: f64,
    ) -> Contact {
        match self {
            Self::Plain => first_contact::<false>(field, disc, position, now),
            // SAFETY: this value exists only where `available` found the feature.
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => unsafe { first_contact_avx2(field, disc, position, now) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => unsafe { first_contact_avx512(field, disc, position, now) },
        }
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn first_contact_avx2(field: Field<'_>, disc: u32, position: Vector, now: f64) -> Contact {
    first_contact::<false>(field, disc, position, now)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,avx512f,avx512vl")]
fn first_contact_avx512(field: Field<'_>, disc: u32, position: Vector, now: f64) -> Contact {
    first_contact::<true>(field, disc, position, now)
}

/// Asks for the cache line of a value that will be wanted soon.
#[inline(always)]
pub(super) fn fetch_ahead<T>(value: &T) {
    #[cfg(target_arch = "x86_64")]
    // SAFETY: fetching ahead reads nothing and may be asked of any address; this one is a reference's.
    unsafe {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        _mm_prefetch::<_MM_HINT_T0>(std::ptr::from_ref(value).cast());
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = value;
}

/// The search's instructions of 512 bits. They only move numbers: all arithmetic is that of the plain search.
#[cfg(target_arch = "x86_64")]
pub(super) mod wide {
    use super::super::cells::Shifts;
    use super::super::disc::Disc;
    use super::super::scan::{Collected, Gathered, LANES};
    use std::arch::x86_64::*;
    use std::mem::transmute;

    /// Collects the discs of three rows of twelve places but for one, without branches and without memory between; `None`
    /// where there are more than sixteen. Lanes that are left over hold that one.
    #[inline(always)]
    pub(in super::super) fn collect(rows: [&[u32]; 3], but: u32) -> Option<Collected> {
        // SAFETY: called in functions of these features only. Twelve words are read, of twelve; a register is sixteen words.
        unsafe {
            let nobody = _mm512_set1_epi32(-1);
            let own = _mm512_set1_epi32(but.cast_signed());
            let columns = _mm512_setr_epi32(0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2, 0, 0, 0, 0);
            let (mut discs, mut places, mut count) = (own, _mm512_set1_epi32(4), 0);
            for (row, slots) in rows.into_iter().enumerate() {
                assert!(slots.len() == 12);
                let here = _mm512_maskz_loadu_epi32(0x0FFF, slots.as_ptr().cast());
                let taken = _mm512_mask_cmpneq_epi32_mask(0x0FFF, here, nobody);
                let taken = _mm512_mask_cmpneq_epi32_mask(taken, here, own);
                let place = _mm512_add_epi32(columns, _mm512_set1_epi32(3 * row as i32));
                // Behind what is there already; the lanes behind that are filled again with the disc itself.
                let behind = (0xFFFF_u32 << count) as u16;
                let here = _mm512_mask_compress_epi32(own, taken, here);
                let place = _mm512_mask_compress_epi32(_mm512_set1_epi32(4), taken, place);
                discs = _mm512_mask_expand_epi32(discs, behind, here);
                places = _mm512_mask_expand_epi32(places, behind, place);
                count += taken.count_ones();
                if count > 16 {
                    return None;
                }
            }
            Some(Collected {
                discs: transmute::<__m512i, [u32; 16]>(discs),
                places: transmute::<__m512i, [u32; 16]>(places),
                count: count as usize,
            })
        }
    }

    /// The numbers of eight discs side by side: a record's first four numbers are one load, and the rest is exchange.
    #[inline(always)]
    pub(in super::super) fn gather(
        others: [&Disc; LANES],
        places: &[u32; LANES],
        shifts: &Shifts,
    ) -> Gathered {
        // SAFETY: called in functions of these features only. A record begins with position and velocity, four numbers; a
        // table of shifts has sixteen, places are eight words; a register is eight numbers.
        unsafe {
            let row = |lane: usize| _mm256_load_pd(std::ptr::from_ref(others[lane]).cast());
            let two = |low: usize| {
                _mm512_insertf64x4::<1>(_mm512_castpd256_pd512(row(low)), row(low + 4))
            };
            let (r0, r1, r2, r3) = (two(0), two(1), two(2), two(3));
            let (x01, x23) = (_mm512_unpacklo_pd(r0, r1), _mm512_unpacklo_pd(r2, r3));
            let (y01, y23) = (_mm512_unpackhi_pd(r0, r1), _mm512_unpackhi_pd(r2, r3));
            let first = _mm512_setr_epi64(0, 1, 8, 9, 4, 5, 12, 13);
            let second = _mm512_setr_epi64(2, 3, 10, 11, 6, 7, 14, 15);
            let places = _mm512_cvtepu32_epi64(_mm256_loadu_si256(places.as_ptr().cast()));
            let shift = |axis: usize| {
                let table: *const f64 = shifts[axis].as_ptr();
                _mm512_permutex2var_pd(
                    _mm512_loadu_pd(table),
                    places,
                    _mm512_loadu_pd(table.add(8)),
                )
            };
            let numbers = |register: __m512d| transmute::<__m512d, [f64; LANES]>(register);
            let mut time = [0.0; LANES];
            for (time, other) in time.iter_mut().zip(others) {
                *time = other.time;
            }
            Gathered {
                position: [
                    numbers(_mm512_permutex2var_pd(x01, first, x23)),
                    numbers(_mm512_permutex2var_pd(y01, first, y23)),
                ],
                velocity: [
                    numbers(_mm512_permutex2var_pd(x01, second, x23)),
                    numbers(_mm512_permutex2var_pd(y01, second, y23)),
                ],
                time,
                shift: [numbers(shift(0)), numbers(shift(1))],
            }
        }
    }
}

/// Without those instructions nobody asks for them.
#[cfg(not(target_arch = "x86_64"))]
pub(super) mod wide {
    use super::super::cells::Shifts;
    use super::super::disc::Disc;
    use super::super::scan::{Collected, Gathered, LANES};

    pub(in super::super) fn collect(_: [&[u32]; 3], _: u32) -> Option<Collected> {
        None
    }

    pub(in super::super) fn gather(_: [&Disc; LANES], _: &[u32; LANES], _: &Shifts) -> Gathered {
        let zero = [0.0; LANES];
        Gathered { position: [zero; 2], velocity: [zero; 2], time: zero, shift: [zero; 2] }
    }
}
