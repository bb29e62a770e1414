//! Pairs found while a block's list is built, four discs at a time with AVX2 where the machine has it: the same sums,
//! products and comparisons as one by one, so the same list (a test compares them).
//!
//! What the unsafe code keeps to:
//! - Loads and stores of whole `[f64; 4]` and `[[u32; 2]; 4]` through their own references: in bounds, and unaligned by
//!   instruction.
//! - The call of a function compiled for AVX2, made only where `is_x86_feature_detected!` has found it.

#![allow(unsafe_code)]

use super::discs::Discs;
use super::tiers;
use std::ops::Range;

/// Discs at a time.
pub(super) const LANES: usize = 4;

/// By how many box lengths along each axis a disc is shifted to stand beside the one that looks.
pub(super) type Turns = [i8; 2];

/// A disc, and others that follow each other, of which it is compared with at most the first four.
#[derive(Clone, Copy, Default)]
struct Look {
    disc: u32,
    first: u32,
    /// Where the others end.
    end: u32,
    turns: Turns,
}

/// Who is compared with whom, in order. Room is made ahead, and a look is written before it is known whether it counts: there
/// is no branch to guess.
#[derive(Default)]
pub(super) struct Looks {
    looks: Vec<Look>,
    count: usize,
}

/// Pairs, column by column, in the order in which they were found. Here, too, room is made ahead.
#[derive(Default)]
pub(super) struct Found {
    /// The disc, counted from the block's first, and the other, counted from where the others are.
    pairs: Vec<[u32; 2]>,
    /// r_i + r_j, m.
    touching: Vec<f64>,
    /// Their tiers.
    tiers: Vec<u8>,
    /// Squares of the distances of the centres, m^2, for the tiers that are not yet found.
    squared: Vec<f64>,
    /// Those of the others; empty where none is shifted.
    turns: Vec<Turns>,
    count: usize,
}

/// What pairs are looked for among.
#[derive(Clone, Copy)]
pub(super) struct Among<'a> {
    pub(super) discs: &'a Discs,
    /// How far the list reaches beyond touching, m.
    pub(super) skin: f64,
    /// The disc that the block's own are counted from, and the one that the others are.
    pub(super) counted_from: [usize; 2],
    /// The box, m.
    pub(super) sides: [f64; 2],
}

impl Looks {
    /// How many there are.
    pub(super) fn len(&self) -> usize {
        self.count
    }

    /// A disc is compared with others, of which there may be none.
    #[inline]
    pub(super) fn add(&mut self, disc: u32, others: Range<u32>, turns: Turns) {
        let Range { start, end } = others;
        let looks = (end - start).div_ceil(LANES as u32) as usize;
        // Two are written even where fewer count.
        let most = self.count + looks + 2;
        if self.looks.len() < most {
            self.looks.resize(2 * most, Look::default());
        }
        let room = &mut self.looks[self.count..];
        // Mostly one or two.
        if let Some(room) = room.first_chunk_mut::<2>() {
            room[0] = Look { disc, first: start, end, turns };
            room[1] = Look { disc, first: start + LANES as u32, end, turns };
        }
        if looks > 2 {
            let others = (start..end).step_by(LANES);
            for (look, first) in room.iter_mut().zip(others).skip(2) {
                *look = Look { disc, first, end, turns };
            }
        }
        self.count += looks;
    }
}

impl Among<'_> {
    /// What is added to the centre of a disc, m.
    #[inline(always)]
    pub(super) fn shift(&self, turns: Turns) -> [f64; 2] {
        [0, 1].map(|axis: usize| f64::from(turns[axis]) * self.sides[axis])
    }

    /// Numbers of two discs in the list.
    #[inline(always)]
    fn counted(&self, discs: [u32; 2]) -> [u32; 2] {
        [0, 1].map(|end: usize| discs[end] - self.counted_from[end] as u32)
    }
}

impl Found {
    pub(super) fn clear(&mut self) {
        self.count = 0;
        self.turns.clear();
        self.tiers.clear();
    }

    pub(super) fn pairs(&self) -> &[[u32; 2]] {
        &self.pairs[..self.count]
    }

    pub(super) fn touching(&self) -> &[f64] {
        &self.touching[..self.count]
    }

    pub(super) fn tiers(&self) -> &[u8] {
        &self.tiers
    }

    pub(super) fn turns(&self) -> &[Turns] {
        &self.turns
    }

    /// Takes the pairs that are closer than touching plus the skin, and empties the looks. With `SHIFTED`, the others may be
    /// images beyond periodic sides.
    pub(super) fn take<const SHIFTED: bool>(&mut self, looks: &mut Looks, among: &Among<'_>) {
        let before = self.count;
        self.make_room(looks.count);
        self.look::<SHIFTED>(&looks.looks[..looks.count], among);
        looks.count = 0;
        self.tiers.resize(self.count, 0);
        let (new, found) = (before..self.count, self.count - before);
        let gaps = [&self.squared[..found], &self.touching[new.clone()]];
        tiers::find(gaps, among.skin, &mut self.tiers[new]);
    }

    fn look<const SHIFTED: bool>(&mut self, looks: &[Look], among: &Among<'_>) {
        let before = self.count;
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2")
            && std::arch::is_x86_feature_detected!("popcnt")
        {
            // SAFETY: the machine has these instructions.
            unsafe { avx2::look::<SHIFTED>(self, looks, among) };
            return;
        }
        for look in looks {
            self.look_one_by_one::<SHIFTED>(look, before, among);
        }
    }

    /// Takes the pairs of one look; squares are counted from those before it, and there must be room.
    fn look_one_by_one<const SHIFTED: bool>(
        &mut self,
        look: &Look,
        before: usize,
        among: &Among<'_>,
    ) {
        let Among { discs, skin, .. } = *among;
        let [x, y] = discs.position(look.disc as usize);
        let radius = discs.radii[look.disc as usize];
        let shift = among.shift(look.turns);
        for other in look.first..Ord::min(look.end, look.first + LANES as u32) {
            let [mut other_x, mut other_y] = discs.position(other as usize);
            if SHIFTED {
                (other_x, other_y) = (other_x + shift[0], other_y + shift[1]);
            }
            let apart = [x - other_x, y - other_y];
            let squared = apart[0] * apart[0] + apart[1] * apart[1];
            let touching = radius + discs.radii[other as usize];
            let reach = touching + skin;
            // A position that is no number is near nothing.
            if squared < reach * reach {
                self.pairs[self.count] = among.counted([look.disc, other]);
                self.touching[self.count] = touching;
                self.squared[self.count - before] = squared;
                self.count += 1;
                if SHIFTED {
                    self.turns.push(look.turns);
                }
            }
        }
    }

    /// Makes room for those that so many looks may find.
    fn make_room(&mut self, looks: usize) {
        let most = looks * LANES;
        if self.squared.len() < most {
            self.squared.resize(most, 0.0);
        }
        let most = self.count + most;
        if self.pairs.len() < most {
            self.pairs.resize(most + most / 4, [0; 2]);
            self.touching.resize(most + most / 4, 0.0);
        }
    }
}

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use super::{Among, Found, LANES, Look};
    use std::arch::x86_64::*;

    /// For each set of lanes that are near, an order of 32-bit halves that puts these lanes first.
    const NEAR_FIRST: [[u32; 8]; 16] = {
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

    /// The x of four rows, and their y.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn centres(rows: &[[f64; 4]; LANES]) -> [__m256d; 2] {
        let [a, b, c, d] = [load(&rows[0]), load(&rows[1]), load(&rows[2]), load(&rows[3])];
        let (even, odd) =
            (_mm256_permute2f128_pd::<0x20>(a, c), _mm256_permute2f128_pd::<0x20>(b, d));
        [_mm256_unpacklo_pd(even, odd), _mm256_unpackhi_pd(even, odd)]
    }

    #[target_feature(enable = "avx2,popcnt")]
    pub(super) fn look<const SHIFTED: bool>(found: &mut Found, looks: &[Look], among: &Among<'_>) {
        let (before, most) = (found.count, looks.len() * LANES);
        assert!(found.pairs.len() >= before + most, "no room for pairs");
        assert!(found.touching.len() >= before + most, "no room for their reach");
        assert!(found.squared.len() >= most, "no room for their distances");
        let states = &among.discs.states[..];
        // Of one length: looked at once.
        let radii = &among.discs.radii[..states.len()];
        let skin = _mm256_set1_pd(among.skin);
        let steps = _mm256_set_epi64x(3 << 32, 2 << 32, 1 << 32, 0);
        let mut count = found.count;
        for look in looks {
            let (disc, first) = (look.disc as usize, look.first as usize);
            let others = first..first + LANES;
            let rows = states.get(others.clone()).and_then(|rows| rows.first_chunk());
            let other_radii = radii.get(others).and_then(|radii| radii.first_chunk());
            let (Some(rows), Some(other_radii)) = (rows, other_radii) else {
                // The last few discs of all.
                found.count = count;
                found.look_one_by_one::<SHIFTED>(look, before, among);
                count = found.count;
                continue;
            };
            let [mut other_x, mut other_y] = centres(rows);
            if SHIFTED {
                let [shift_x, shift_y] = among.shift(look.turns).map(|part| _mm256_set1_pd(part));
                other_x = _mm256_add_pd(other_x, shift_x);
                other_y = _mm256_add_pd(other_y, shift_y);
            }
            let [x, y, ..] = states[disc].map(|value| _mm256_set1_pd(value));
            let (x, y) = (_mm256_sub_pd(x, other_x), _mm256_sub_pd(y, other_y));
            let squared = _mm256_add_pd(_mm256_mul_pd(x, x), _mm256_mul_pd(y, y));
            let touching = _mm256_add_pd(_mm256_set1_pd(radii[disc]), load(other_radii));
            let reach = _mm256_add_pd(touching, skin);
            let near = _mm256_cmp_pd::<_CMP_LT_OQ>(squared, _mm256_mul_pd(reach, reach));
            // Discs behind the last one do not count.
            let others = Ord::min(look.end - look.first, LANES as u32);
            let near = _mm256_movemask_pd(near) as u32 & ((1_u32 << others) - 1);
            // A pair as one number: the disc below, the other above.
            let [own, other] = among.counted([look.disc, look.first]).map(i64::from);
            let pairs = _mm256_add_epi64(_mm256_set1_epi64x(other << 32 | own), steps);
            // SAFETY: there is room for as many pairs as all looks may find.
            unsafe {
                let order = order_of(near);
                store(found.pairs.as_mut_ptr().add(count).cast(), pairs, order);
                store(
                    found.touching.as_mut_ptr().add(count).cast(),
                    _mm256_castpd_si256(touching),
                    order,
                );
                store(
                    found.squared.as_mut_ptr().add(count - before).cast(),
                    _mm256_castpd_si256(squared),
                    order,
                );
            }
            if SHIFTED {
                found.turns.extend(std::iter::repeat_n(look.turns, near.count_ones() as usize));
            }
            count += near.count_ones() as usize;
        }
        found.count = count;
    }

    #[inline]
    #[target_feature(enable = "avx2")]
    fn order_of(near: u32) -> __m256i {
        // SAFETY: eight u32 lie behind the reference.
        unsafe { _mm256_loadu_si256(NEAR_FIRST[near as usize].as_ptr().cast()) }
    }

    /// Writes four lanes in an order. There must be room.
    #[inline]
    #[target_feature(enable = "avx2")]
    unsafe fn store(into: *mut __m256i, lanes: __m256i, order: __m256i) {
        // SAFETY: the caller's promise.
        unsafe { _mm256_storeu_si256(into, _mm256_permutevar8x32_epi32(lanes, order)) };
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
        const COUNT: u32 = 203;
        let discs = discs(COUNT);
        let mut looks = Looks::default();
        let mut compared = 0;
        for disc in 3..COUNT {
            for length in 0..12 {
                let others = Ord::min(disc + 1, COUNT)..Ord::min(disc + 1 + length, COUNT);
                compared += others.len();
                looks.add(disc, others, [(disc % 3) as i8 - 1, (length % 3) as i8 - 1]);
            }
        }
        let among = Among { discs: &discs, skin: 2.0, counted_from: [3, 1], sides: [3.0, 4.0] };
        let near = [compare::<false>(&looks, &among), compare::<true>(&looks, &among)];
        // Those within touching and skin of 2 to 5 in a box of 10 are many, not all.
        assert!(near.iter().all(|&near| near > 1000 && near < compared - 1000), "{near:?}");
        assert!(near[0] != near[1]);
    }

    /// How many pairs are near, by either way of looking.
    fn compare<const SHIFTED: bool>(looks: &Looks, among: &Among<'_>) -> usize {
        let (mut wide, mut single) = (Found::default(), Found::default());
        let looks = &looks.looks[..looks.count];
        // Twice, as a second column of cells is.
        for _ in 0..2 {
            wide.make_room(looks.len());
            wide.look::<SHIFTED>(looks, among);
            single.make_room(looks.len());
            let before = single.count;
            for look in looks {
                single.look_one_by_one::<SHIFTED>(look, before, among);
            }
            let found = wide.count - before;
            assert_eq!(wide.squared[..found], single.squared[..found]);
        }
        assert_eq!(wide.pairs(), single.pairs());
        assert_eq!(wide.touching(), single.touching());
        assert_eq!(wide.turns(), single.turns());
        assert_eq!(wide.turns().len(), if SHIFTED { wide.count } else { 0 });
        wide.count / 2
    }
}
