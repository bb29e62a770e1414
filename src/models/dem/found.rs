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
pub(super) const LANES: usize = 4;

/// By how many box lengths along each axis a disc is shifted to stand beside the one that looks.
pub(super) type Turns = [i8; 2];

/// A disc, and at most four others that follow each other, with which it is compared.
#[derive(Clone, Copy, Default)]
struct Look {
    disc: u32,
    first: u32,
    others: u32,
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
    /// Squares of the distances of the centres, m^2.
    squared: Vec<f64>,
    /// r_i + r_j, m.
    touching: Vec<f64>,
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
    pub(super) fn clear(&mut self) {
        self.count = 0;
    }

    /// A disc is compared with some that follow each other.
    #[inline]
    pub(super) fn add(&mut self, disc: u32, others: Range<u32>, turns: Turns) {
        let length = others.end.saturating_sub(others.start);
        let looks = length.div_ceil(LANES as u32);
        let most = self.count + Ord::max(looks as usize, 2);
        if self.looks.len() < most {
            self.looks.resize(2 * most, Look::default());
        }
        let look = |number: u32| {
            let begun = number * LANES as u32;
            let others_left = Ord::min(length.saturating_sub(begun), LANES as u32);
            Look { disc, first: others.start + begun, others: others_left, turns }
        };
        let room = &mut self.looks[self.count..most];
        // Mostly one or two.
        (room[0], room[1]) = (look(0), look(1));
        for number in 2..looks {
            room[number as usize] = look(number);
        }
        self.count += looks as usize;
    }

    fn all(&self) -> &[Look] {
        &self.looks[..self.count]
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
    pub(super) fn pairs(&self) -> &[[u32; 2]] {
        &self.pairs[..self.count]
    }

    pub(super) fn squared(&self) -> &[f64] {
        &self.squared[..self.count]
    }

    pub(super) fn touching(&self) -> &[f64] {
        &self.touching[..self.count]
    }

    pub(super) fn turns(&self) -> &[Turns] {
        &self.turns
    }

    /// Finds the pairs that are closer than touching plus the skin. With `SHIFTED`, the others may be images beyond periodic
    /// sides.
    pub(super) fn look<const SHIFTED: bool>(&mut self, looks: &Looks, among: &Among<'_>) {
        self.count = 0;
        self.turns.clear();
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2") {
            // SAFETY: the machine has AVX2.
            unsafe { avx2::look::<SHIFTED>(self, looks.all(), among) };
            return;
        }
        for look in looks.all() {
            self.look_one_by_one::<SHIFTED>(look, among);
        }
    }

    fn look_one_by_one<const SHIFTED: bool>(&mut self, look: &Look, among: &Among<'_>) {
        self.make_room();
        let Among { discs, skin, .. } = *among;
        let [x, y] = discs.position(look.disc as usize);
        let radius = discs.radii[look.disc as usize];
        let shift = among.shift(look.turns);
        for other in look.first..look.first + look.others {
            let [mut other_x, mut other_y] = discs.position(other as usize);
            if SHIFTED {
                (other_x, other_y) = (other_x + shift[0], other_y + shift[1]);
            }
            let apart = [x - other_x, y - other_y];
            let squared = apart[0] * apart[0] + apart[1] * apart[1];
            let touching = radius + discs.radii[other as usize];
            let reach = touching + skin;
            self.pairs[self.count] = among.counted([look.disc, other]);
            self.squared[self.count] = squared;
            self.touching[self.count] = touching;
            // A position that is no number is near nothing.
            let is_near = usize::from(squared < reach * reach);
            self.take::<SHIFTED>(is_near, look.turns);
        }
    }

    /// Makes room for those that a look may find.
    #[inline]
    fn make_room(&mut self) {
        let needed = self.count + LANES;
        if self.pairs.len() < needed {
            self.pairs.resize(2 * needed, [0; 2]);
            self.squared.resize(2 * needed, 0.0);
            self.touching.resize(2 * needed, 0.0);
        }
    }

    /// So many of those that were written count.
    #[inline(always)]
    fn take<const SHIFTED: bool>(&mut self, more: usize, turns: Turns) {
        self.count += more;
        if SHIFTED {
            self.turns.extend(std::iter::repeat_n(turns, more));
        }
    }
}

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use super::{Among, Found, LANES, Look};
    use std::arch::x86_64::*;

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
    pub(super) fn look<const SHIFTED: bool>(found: &mut Found, looks: &[Look], among: &Among<'_>) {
        let discs = among.discs;
        let skin = _mm256_set1_pd(among.skin);
        let steps = _mm256_set_epi64x(3 << 32, 2 << 32, 1 << 32, 0);
        for look in looks {
            let (disc, first) = (look.disc as usize, look.first as usize);
            let rows = discs.states.get(first..first + LANES).and_then(|rows| rows.first_chunk());
            let radii = discs.radii.get(first..first + LANES).and_then(|radii| radii.first_chunk());
            let (Some(rows), Some(radii)) = (rows, radii) else {
                // The last few discs of all.
                found.look_one_by_one::<SHIFTED>(look, among);
                continue;
            };
            let [mut other_x, mut other_y] = centres(rows);
            if SHIFTED {
                let [shift_x, shift_y] = among.shift(look.turns).map(|part| _mm256_set1_pd(part));
                other_x = _mm256_add_pd(other_x, shift_x);
                other_y = _mm256_add_pd(other_y, shift_y);
            }
            let [x, y] = discs.position(disc).map(|value| _mm256_set1_pd(value));
            let (x, y) = (_mm256_sub_pd(x, other_x), _mm256_sub_pd(y, other_y));
            let squared = _mm256_add_pd(_mm256_mul_pd(x, x), _mm256_mul_pd(y, y));
            let touching = _mm256_add_pd(_mm256_set1_pd(discs.radii[disc]), load(radii));
            let reach = _mm256_add_pd(touching, skin);
            let near = _mm256_cmp_pd::<_CMP_LT_OQ>(squared, _mm256_mul_pd(reach, reach));
            // Discs behind the last one do not count.
            let counts = _mm256_movemask_pd(near) as u32 & ((1_u32 << look.others) - 1);
            // A pair as one number: the disc below, the other above.
            let [own, other] = among.counted([look.disc, look.first]).map(i64::from);
            let pairs = _mm256_add_epi64(_mm256_set1_epi64x(other << 32 | own), steps);
            append(found, counts as usize, pairs, [squared, touching]);
            found.take::<SHIFTED>(counts.count_ones() as usize, look.turns);
        }
    }

    /// Writes four pairs with those first that count.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn append(found: &mut Found, counts: usize, pairs: __m256i, values: [__m256d; 2]) {
        found.make_room();
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
        wide.look::<SHIFTED>(looks, among);
        for look in looks.all() {
            single.look_one_by_one::<SHIFTED>(look, among);
        }
        assert_eq!(wide.pairs(), single.pairs());
        assert_eq!(wide.squared(), single.squared());
        assert_eq!(wide.touching(), single.touching());
        assert_eq!(wide.turns(), single.turns());
        assert_eq!(wide.turns().len(), if SHIFTED { wide.count } else { 0 });
        wide.count
    }
}
