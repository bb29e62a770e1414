//! Pairs found while a block's list is built, four discs at a time with AVX2 where the machine has it: the same sums,
//! products and comparisons as one by one, so the same list (a test compares them).
//!
//! What the unsafe code keeps to:
//! - Loads and stores of whole `[f64; 4]` and `[[u32; 2]; 4]` through their own references: in bounds, and unaligned by
//!   instruction.
//! - The call of a function compiled for AVX2, made only where `is_x86_feature_detected!` has found it.

#![allow(unsafe_code)]

use super::discs::Discs;
use std::ops::Range;

/// Discs at a time.
const LANES: usize = 4;

/// Pairs, column by column, in the order in which they were found. Room is made ahead, and a pair is written before it is
/// known whether it counts: there is no branch to guess.
#[derive(Default)]
pub(super) struct Found {
    /// Places in the block.
    pairs: Vec<[u32; 2]>,
    /// Squares of the distances of the centres, m^2.
    squared: Vec<f64>,
    /// r_i + r_j, m.
    touching: Vec<f64>,
    count: usize,
}

/// A disc of a block, and where that begins.
#[derive(Clone, Copy)]
pub(super) struct Looker {
    pub(super) disc: usize,
    pub(super) start: usize,
}

impl Found {
    pub(super) fn clear(&mut self) {
        self.count = 0;
    }

    pub(super) fn pairs(&self) -> &[[u32; 2]] {
        &self.pairs[..self.count]
    }

    pub(super) fn squared(&self) -> &[f64] {
        &self.squared[..self.count]
    }

    pub(super) fn touching(&self) -> &[f64] {
        &self.touching[..self.count]
    }

    /// Takes the pairs of a disc with a run of others of its block that are closer than touching plus the skin, m.
    pub(super) fn look(&mut self, from: Looker, others: Range<usize>, discs: &Discs, skin: f64) {
        self.make_room(others.len() + LANES);
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2") {
            // SAFETY: the machine has AVX2.
            unsafe { avx2::look(self, from, others, discs, skin) };
            return;
        }
        self.look_one_by_one(from, others, discs, skin);
    }

    fn look_one_by_one(&mut self, from: Looker, others: Range<usize>, discs: &Discs, skin: f64) {
        let [x, y] = discs.position(from.disc);
        let radius = discs.radii[from.disc];
        for other in others {
            let [other_x, other_y] = discs.position(other);
            let apart = [x - other_x, y - other_y];
            let squared = apart[0] * apart[0] + apart[1] * apart[1];
            let touching = radius + discs.radii[other];
            let reach = touching + skin;
            self.pairs[self.count] = [from.disc, other].map(|disc| (disc - from.start) as u32);
            self.squared[self.count] = squared;
            self.touching[self.count] = touching;
            // A position that is no number is near nothing.
            self.count += usize::from(squared < reach * reach);
        }
    }

    fn make_room(&mut self, more: usize) {
        let needed = self.count + more;
        if self.pairs.len() < needed {
            self.pairs.resize(2 * needed, [0; 2]);
            self.squared.resize(2 * needed, 0.0);
            self.touching.resize(2 * needed, 0.0);
        }
    }
}

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use super::{Discs, Found, LANES, Looker};
    use std::arch::x86_64::*;
    use std::ops::Range;

    /// For each set of lanes that count, an order of 32-bit halves that puts these lanes first.
    const COUNTING_FIRST: [[u32; 8]; 16] = {
        let mut orders = [[0; 8]; 16];
        let mut set = 0;
        while set < 16 {
            let (mut lane, mut place) = (0, 0);
            while lane < 4 {
                if set >> lane & 1 == 1 {
                    orders[set][2 * place] = 2 * lane;
                    orders[set][2 * place + 1] = 2 * lane + 1;
                    place += 1;
                }
                lane += 1;
            }
            set += 1;
        }
        orders
    };

    #[inline]
    #[target_feature(enable = "avx2")]
    fn load(values: &[f64; LANES]) -> __m256d {
        // SAFETY: four f64 lie behind the reference.
        unsafe { _mm256_loadu_pd(values.as_ptr()) }
    }

    #[inline]
    #[target_feature(enable = "avx2")]
    fn store(into: &mut [f64; LANES], values: __m256d) {
        // SAFETY: four f64 lie behind the reference.
        unsafe { _mm256_storeu_pd(into.as_mut_ptr(), values) }
    }

    /// The x of four rows, and their y.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn centres(rows: &[[f64; 4]; LANES]) -> [__m256d; 2] {
        let [a, b, c, d] = [load(&rows[0]), load(&rows[1]), load(&rows[2]), load(&rows[3])];
        let (even, odd) =
            (_mm256_permute2f128_pd::<0x20>(a, c), _mm256_permute2f128_pd::<0x20>(b, d));
        [_mm256_unpacklo_pd(even, odd), _mm256_unpackhi_pd(even, odd)]
    }

    #[target_feature(enable = "avx2")]
    pub(super) fn look(
        found: &mut Found,
        from: Looker,
        others: Range<usize>,
        discs: &Discs,
        skin: f64,
    ) {
        let [x, y] = discs.position(from.disc).map(|value| _mm256_set1_pd(value));
        let radius = _mm256_set1_pd(discs.radii[from.disc]);
        let skin_lanes = _mm256_set1_pd(skin);
        // A pair as one number: the disc below, the other above.
        let own = (from.disc - from.start) as i64;
        let steps = _mm256_set_epi64x(3 << 32, 2 << 32, 1 << 32, 0);
        let mut next = others.start;
        while next < others.end {
            let rows = discs.states.get(next..).and_then(|rows| rows.first_chunk::<LANES>());
            let radii = discs.radii.get(next..).and_then(|radii| radii.first_chunk::<LANES>());
            let (Some(rows), Some(radii)) = (rows, radii) else {
                // The last few discs of all.
                return found.look_one_by_one(from, next..others.end, discs, skin);
            };
            let [other_x, other_y] = centres(rows);
            let (x, y) = (_mm256_sub_pd(x, other_x), _mm256_sub_pd(y, other_y));
            let squared = _mm256_add_pd(_mm256_mul_pd(x, x), _mm256_mul_pd(y, y));
            let touching = _mm256_add_pd(radius, load(radii));
            let reach = _mm256_add_pd(touching, skin_lanes);
            let near = _mm256_cmp_pd::<_CMP_LT_OQ>(squared, _mm256_mul_pd(reach, reach));
            // Discs behind the run's end do not count.
            let run = (1_u32 << Ord::min(others.end - next, LANES)) - 1;
            let counts = _mm256_movemask_pd(near) as u32 & run;
            let first = ((next - from.start) as i64) << 32 | own;
            let pairs = _mm256_add_epi64(_mm256_set1_epi64x(first), steps);
            append(found, counts as usize, pairs, [squared, touching]);
            next += LANES;
        }
    }

    /// Writes four pairs with those first that count.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn append(found: &mut Found, counts: usize, pairs: __m256i, values: [__m256d; 2]) {
        let at = found.count..found.count + LANES;
        // SAFETY: eight u32 lie behind the reference.
        let order = unsafe { _mm256_loadu_si256(COUNTING_FIRST[counts].as_ptr().cast()) };
        let sorted = |values: __m256i| _mm256_permutevar8x32_epi32(values, order);
        let room = [&mut found.squared[at.clone()], &mut found.touching[at.clone()]];
        for (room, values) in room.into_iter().zip(values) {
            if let Some(room) = room.first_chunk_mut() {
                store(room, _mm256_castsi256_pd(sorted(_mm256_castpd_si256(values))));
            }
        }
        if let Some(room) = found.pairs[at].first_chunk_mut::<LANES>() {
            // SAFETY: eight u32 lie behind the reference.
            unsafe { _mm256_storeu_si256(room.as_mut_ptr().cast(), sorted(pairs)) };
        }
        found.count += counts.count_ones() as usize;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::dem::discs::Disc;

    /// Places evenly spread, by the multiples of irrational numbers (Weyl 1916).
    fn discs(count: u32) -> Discs {
        let mut discs = Discs::default();
        for id in 0..count {
            let part = |root: f64| (f64::from(id) * root.sqrt()).fract();
            discs.push(&Disc {
                id,
                position: [10.0 * part(2.0), 10.0 * part(3.0)],
                velocity: [0.0; 2],
                radius: 0.5 + part(5.0),
                mass: 1.0,
                material: 0,
            });
        }
        discs
    }

    #[test]
    fn four_discs_at_a_time_give_the_same_list() {
        let discs = discs(203);
        let (mut wide, mut single) = (Found::default(), Found::default());
        for disc in 0..203 {
            for length in 0..12 {
                let others = disc + 1..Ord::min(disc + 1 + length, 203);
                let from = Looker { disc, start: 0 };
                wide.look(from, others.clone(), &discs, 2.0);
                single.make_room(others.len());
                single.look_one_by_one(from, others, &discs, 2.0);
            }
        }
        // 13 366 pairs are offered; those within touching and skin of 2 to 5 in a box of 10 are many, not all.
        assert!(wide.count > 1000 && wide.count < 10_000, "{}", wide.count);
        assert_eq!(wide.pairs(), single.pairs());
        assert_eq!(wide.squared(), single.squared());
        assert_eq!(wide.touching(), single.touching());
    }
}
