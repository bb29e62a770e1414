//! Normal forces of four pairs at a time with AVX2, where the machine has it: the same operations in the same order as
//! `forces::inner_pairs`, so the same bits (a test compares them). No fused multiply-add.
//!
//! What the unsafe code keeps to:
//! - Loads and stores of a whole `[f64; 4]` through its own reference: in bounds, and unaligned by instruction.
//! - Discs and rows of forces by a pair's places, unchecked pair by pair: all places are checked before the loop.
//! - The call of a function compiled for AVX2 and POPCNT, made only where `is_x86_feature_detected!` has found them.

#![allow(unsafe_code)]

use crate::dem::forces::contact::ContactLaw;
use crate::dem::forces::touched::Touched;
use crate::dem::forces::{Deepest, Own};
use crate::dem::neighbors::near_pairs::{Near, Touching};
use crate::dem::neighbors::{Pairs, Scope};

/// What the lanes take their pairs from.
pub(in crate::dem) struct Lanes<'a> {
    pub(in crate::dem) pairs: &'a Pairs,
    pub(in crate::dem) scope: &'a Scope,
    pub(in crate::dem) own: &'a Own<'a>,
    pub(in crate::dem) law: &'a ContactLaw,
}

/// What is known of a block's pairs from one step to the next, and memory that blocks share.
pub(in crate::dem) struct Memory<'a> {
    pub(in crate::dem) near: &'a mut Near,
    pub(in crate::dem) touching: &'a mut Touching,
    /// Takes the discs of pairs that touch; completed where no pairs but the near ones have to be looked at.
    pub(in crate::dem) touched: &'a mut Touched,
}

/// Adds the forces of all pairs that touch; false where the machine has no AVX2, and nothing was done.
pub(in crate::dem) fn inner_pairs(
    lanes: &Lanes<'_>,
    memory: Memory<'_>,
    forces: &mut [[f64; 4]],
    deepest: &mut Deepest,
) -> bool {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("popcnt")
    {
        // SAFETY: the machine has AVX2 and POPCNT.
        unsafe { avx2::inner_pairs(lanes, memory, forces, deepest) };
        return true;
    }
    false
}

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use super::{Deepest, Lanes, Memory, Own};
    use crate::dem::forces::fours::{Fours, LANES, differences};
    use crate::simd::registers::avx2::transposed;
    use std::arch::x86_64::*;

    #[inline]
    #[target_feature(enable = "avx2")]
    fn load(values: &[f64; 4]) -> __m256d {
        // SAFETY: four f64 lie behind the reference.
        unsafe { _mm256_loadu_pd(values.as_ptr()) }
    }

    #[inline]
    #[target_feature(enable = "avx2")]
    fn store(into: &mut [f64; 4], values: __m256d) {
        // SAFETY: four f64 lie behind the reference.
        unsafe { _mm256_storeu_pd(into.as_mut_ptr(), values) }
    }

    /// Pairs, four by four, and eta of each, N s/m.
    #[derive(Clone, Copy)]
    struct Damped<'a> {
        fours: Fours<'a>,
        dampings: &'a [[f64; LANES]],
    }

    impl Damped<'_> {
        /// The same pairs, no more at a time than fit a batch.
        fn batches(self) -> impl Iterator<Item = Self> {
            let Fours { firsts, seconds, reaches } = self.fours;
            let ends = firsts.chunks(BATCH).zip(seconds.chunks(BATCH));
            let constants = reaches.chunks(BATCH).zip(self.dampings.chunks(BATCH));
            ends.zip(constants).map(|((firsts, seconds), (reaches, dampings))| Self {
                fours: Fours { firsts, seconds, reaches },
                dampings,
            })
        }
    }

    /// Fours that are worked on at a time: what is found of them stays in the nearest cache.
    const BATCH: usize = 16;

    /// What contacts are like, four by four: unit normal, and overlap and separating speed, both zero where two are apart.
    struct Meetings([[[f64; LANES]; 4]; BATCH]);

    /// Near pairs that touch, side by side.
    #[derive(Default)]
    struct Gathered {
        firsts: [[u32; LANES]; BATCH],
        seconds: [[u32; LANES]; BATCH],
        reaches: [[f64; LANES]; BATCH],
        dampings: [[f64; LANES]; BATCH],
        count: usize,
    }

    impl Gathered {
        fn take(&mut self, ends: [u32; 2], [reach, damping]: [f64; 2]) {
            let at = self.count;
            self.firsts.as_flattened_mut()[at] = ends[0];
            self.seconds.as_flattened_mut()[at] = ends[1];
            self.reaches.as_flattened_mut()[at] = reach;
            self.dampings.as_flattened_mut()[at] = damping;
            self.count += 1;
        }

        fn is_full(&self) -> bool {
            self.count == BATCH * LANES
        }

        /// Hands its pairs over; the last four is filled up with pairs of a disc and itself, which do not touch.
        fn give(&mut self) -> Damped<'_> {
            let fours = self.count.div_ceil(LANES);
            while self.count < fours * LANES {
                self.take([0; 2], [0.0; 2]);
            }
            self.count = 0;
            Damped {
                fours: Fours {
                    firsts: &self.firsts[..fours],
                    seconds: &self.seconds[..fours],
                    reaches: &self.reaches[..fours],
                },
                dampings: &self.dampings[..fours],
            }
        }
    }

    #[target_feature(enable = "avx2,popcnt")]
    pub(in crate::dem) fn inner_pairs(
        lanes: &Lanes<'_>,
        memory: Memory<'_>,
        forces: &mut [[f64; 4]],
        deepest: &mut Deepest,
    ) {
        let Lanes { pairs, scope, own, .. } = *lanes;
        let Memory { near, touching, touched } = memory;
        near.look(pairs, own.positions, scope, touching);
        let dampings = pairs.damping[..near.begin()].as_chunks().0;
        let dense = Damped { fours: Fours::of(pairs, 0..near.begin()).0, dampings };
        let discs = own.positions.len();
        assert!(own.velocities.len() == discs && forces.len() == discs, "columns of other lengths");
        // Also a list out of a damaged checkpoint must not reach beyond.
        assert!(dense.fours.beyond() < discs, "a pair of no disc");
        let mut meetings = Meetings([[[0.0; LANES]; 4]; BATCH]);
        let mut gathered = Gathered::default();
        let mut count = 0;
        // SAFETY: no place is beyond the rows.
        unsafe {
            for batch in dense.batches() {
                count += meet(lanes, batch, &mut meetings, deepest);
                push(lanes, batch, &meetings, forces);
            }
            for pair in near.those(touching) {
                let ends = [pairs.first[pair], pairs.second[pair]];
                assert!((Ord::max(ends[0], ends[1]) as usize) < discs, "a pair of no disc");
                touched.note(ends[0]);
                touched.note(ends[1]);
                gathered.take(ends, [pairs.reach[pair], pairs.damping[pair]]);
                count += usize::from(pair < pairs.in_tiers(1));
                if gathered.is_full() {
                    let batch = gathered.give();
                    meet(lanes, batch, &mut meetings, deepest);
                    push(lanes, batch, &meetings, forces);
                }
            }
            let batch = gathered.give();
            meet(lanes, batch, &mut meetings, deepest);
            push(lanes, batch, &meetings, forces);
        }
        if near.begin() == 0 {
            touched.complete();
        }
        near.note(count, pairs.in_tiers(1));
    }

    /// Finds what the contacts of a batch are like, and returns how many there are. All places must be those of rows.
    ///
    /// Roots and quotients take long: without sums in memory that wait for them, more fours are under way at a time.
    #[inline]
    #[target_feature(enable = "avx2")]
    unsafe fn meet(
        lanes: &Lanes<'_>,
        batch: Damped<'_>,
        meetings: &mut Meetings,
        deepest: &mut Deepest,
    ) -> usize {
        let Own { positions, velocities, radii, .. } = lanes.own;
        let Fours { firsts, seconds, reaches } = batch.fours;
        let mut count = _mm256_setzero_si256();
        let smallest = _mm256_set1_pd(f64::MIN_POSITIVE);
        let one = _mm256_set1_pd(1.0);
        let mut bound = _mm256_set1_pd(deepest.bound());
        let ends = firsts.iter().zip(seconds);
        for (((first, second), reach), meeting) in ends.zip(reaches).zip(&mut meetings.0) {
            let ends = [first, second];
            // SAFETY: the caller's promise.
            let ([x, y], [vx, vy]) =
                unsafe { (differences(positions, ends), differences(velocities, ends)) };
            let reach = load(reach);
            let squared = _mm256_add_pd(_mm256_mul_pd(x, x), _mm256_mul_pd(y, y));
            let touch = _mm256_cmp_pd::<_CMP_LT_OQ>(squared, _mm256_mul_pd(reach, reach));
            // A lane of yes is -1 as a whole number.
            count = _mm256_sub_epi64(count, _mm256_castpd_si256(touch));
            let distance = _mm256_sqrt_pd(squared);
            let inverse = _mm256_div_pd(one, _mm256_max_pd(distance, smallest));
            let (nx, ny) = (_mm256_mul_pd(x, inverse), _mm256_mul_pd(y, inverse));
            let speed = _mm256_add_pd(_mm256_mul_pd(vx, nx), _mm256_mul_pd(vy, ny));
            let overlap = _mm256_and_pd(_mm256_sub_pd(reach, distance), touch);
            store(&mut meeting[0], nx);
            store(&mut meeting[1], ny);
            store(&mut meeting[2], overlap);
            store(&mut meeting[3], _mm256_and_pd(speed, touch));
            let deep = _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_GT_OQ>(overlap, bound));
            if deep != 0 {
                for lane in (0..LANES).filter(|lane| deep >> lane & 1 == 1) {
                    let ends = [first[lane] as usize, second[lane] as usize];
                    deepest.note_pair(meeting[2][lane], ends, radii);
                }
                bound = _mm256_set1_pd(deepest.bound());
            }
        }
        let mut counts = [0_u64; LANES];
        // SAFETY: four u64 lie behind the reference.
        unsafe { _mm256_storeu_si256(counts.as_mut_ptr().cast(), count) };
        counts.iter().sum::<u64>() as usize
    }

    /// Adds the forces of a batch. All places must be those of rows of forces.
    #[inline]
    #[target_feature(enable = "avx2")]
    unsafe fn push(
        lanes: &Lanes<'_>,
        batch: Damped<'_>,
        meetings: &Meetings,
        forces: &mut [[f64; 4]],
    ) {
        let stiffness = _mm256_set1_pd(lanes.law.stiffness);
        let floor = _mm256_set1_pd(lanes.law.least_force());
        let ends = batch.fours.firsts.iter().zip(batch.fours.seconds);
        for (((first, second), damping), meeting) in ends.zip(batch.dampings).zip(&meetings.0) {
            let [nx, ny, overlap, speed] = meeting.each_ref().map(|column| load(column));
            let spring = _mm256_mul_pd(stiffness, overlap);
            let force = _mm256_sub_pd(spring, _mm256_mul_pd(load(damping), speed));
            let force = _mm256_max_pd(force, floor);
            let loss = _mm256_sub_pd(spring, force);
            let rows = transposed([
                _mm256_mul_pd(force, nx),
                _mm256_mul_pd(force, ny),
                _mm256_mul_pd(loss, nx),
                _mm256_mul_pd(loss, ny),
            ]);
            // A pair apart adds 0, which changes no bit: a sum that began with +0 is never -0. It costs less than a branch.
            for (lane, row) in rows.into_iter().enumerate() {
                // SAFETY: the caller's promise.
                let on_first = unsafe { forces.get_unchecked_mut(first[lane] as usize) };
                let sum = _mm256_add_pd(load(on_first), row);
                store(on_first, sum);
                // SAFETY: the caller's promise.
                let on_second = unsafe { forces.get_unchecked_mut(second[lane] as usize) };
                let sum = _mm256_sub_pd(load(on_second), row);
                store(on_second, sum);
            }
        }
    }
}
