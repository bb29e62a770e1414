//! Pairs found while a block's list is built, four discs at a time with AVX2 where the machine has it: the same sums,
//! products and comparisons as one by one, so the same list (a test compares them).
//!
//! What the unsafe code keeps to:
//! - Loads of whole `[f64; 4]` and `[u32; 8]` through their own references: in bounds, and unaligned by instruction.
//! - Stores of four pairs from a place on, of which those count that are near. A look moves the place on by four at most, and
//!   before the loop it is made sure that there is room for four pairs of every look.
//! - The call of a function compiled for AVX2 and POPCNT, made only where `is_x86_feature_detected!` has found them.

#![allow(unsafe_code)]

use crate::dem::discs::Discs;
use crate::dem::neighbors::tiers;
use std::ops::Range;

/// Discs at a time.
const LANES: usize = 4;

/// By how many box lengths along each axis a disc is shifted to stand beside the one that looks.
pub(in crate::dem) type Turns = [i8; 2];

/// A disc, and others that follow each other, of which it is compared with at most the first four.
#[derive(Clone, Copy, Default)]
struct Look {
    /// The disc, and the first of the others.
    ends: [u32; 2],
    /// Where the others end.
    stop: u32,
    turns: Turns,
}

/// Who is compared with whom, in order. Room is made ahead, and a look is written before it is known whether it counts: there
/// is no branch to guess.
#[derive(Default)]
pub(in crate::dem) struct Looks {
    looks: Vec<Look>,
    count: usize,
}

/// Pairs, column by column, in the order in which they were found. Here, too, room is made ahead.
#[derive(Default)]
pub(in crate::dem) struct Found {
    /// The disc, counted from the block's first, and the other, counted from where the others are.
    pairs: Vec<[u32; 2]>,
    /// r_i + r_j, m.
    touching: Vec<f64>,
    /// Their tiers.
    tiers: Vec<u8>,
    /// Squares of the distances of the centers, m^2, for the tiers that are not yet found.
    squared: Vec<f64>,
    /// Those of the others; empty where none is shifted.
    turns: Vec<Turns>,
    count: usize,
}

/// What pairs are looked for among.
#[derive(Clone, Copy)]
pub(in crate::dem) struct Among<'a> {
    pub(in crate::dem) discs: &'a Discs,
    /// How far the list reaches beyond touching, m.
    pub(in crate::dem) skin: f64,
    /// The disc that the block's own are counted from, and the one that the others are.
    pub(in crate::dem) counted_from: [usize; 2],
    /// The box, m.
    pub(in crate::dem) sides: [f64; 2],
}

impl Looks {
    /// How many there are.
    pub(in crate::dem) fn len(&self) -> usize {
        self.count
    }

    /// A disc is compared with others, of which there may be none: a range that begins behind its end is a mistake.
    #[inline]
    pub(in crate::dem) fn add(&mut self, disc: u32, others: Range<u32>, turns: Turns) {
        let Range { start, end: stop } = others;
        let looks = (stop - start + LANES as u32 - 1) as usize / LANES;
        // Two are written even where fewer count.
        let most = self.count + looks + 2;
        if self.looks.len() < most {
            self.looks.resize(2 * most, Look::default());
        }
        let look = |first: u32| Look { ends: [disc, first], stop, turns };
        let room = &mut self.looks[self.count..];
        // Mostly one or two.
        if let Some(room) = room.first_chunk_mut::<2>() {
            *room = [look(start), look(start + LANES as u32)];
        }
        if looks > 2 {
            let others = (start..stop).step_by(LANES);
            for (place, first) in room.iter_mut().zip(others).skip(2) {
                *place = look(first);
            }
        }
        self.count += looks;
    }
}

impl Among<'_> {
    /// What is added to the center of a disc, m.
    #[inline(always)]
    pub(in crate::dem) fn shift(&self, turns: Turns) -> [f64; 2] {
        [0, 1].map(|axis: usize| f64::from(turns[axis]) * self.sides[axis])
    }
}

impl Found {
    /// Forgets all pairs.
    pub(in crate::dem) fn clear(&mut self) {
        self.count = 0;
        self.turns.clear();
        self.tiers.clear();
    }

    pub(in crate::dem) fn pairs(&self) -> &[[u32; 2]] {
        &self.pairs[..self.count]
    }

    pub(in crate::dem) fn touching(&self) -> &[f64] {
        &self.touching[..self.count]
    }

    pub(in crate::dem) fn tiers(&self) -> &[u8] {
        &self.tiers
    }

    pub(in crate::dem) fn turns(&self) -> &[Turns] {
        &self.turns
    }

    /// Takes the pairs that are closer than touching plus the skin, and empties the looks. With `SHIFTED`, the others may be
    /// images beyond periodic sides.
    pub(in crate::dem) fn take<const SHIFTED: bool>(
        &mut self,
        looks: &mut Looks,
        among: &Among<'_>,
    ) {
        let before = self.count;
        let mut room = self.room(looks.count);
        room.look::<SHIFTED>(&looks.looks[..looks.count], among);
        let found = room.count;
        looks.count = 0;
        self.count += found;
        self.tiers.resize(self.count, 0);
        let gaps = [&self.squared[..found], &self.touching[before..self.count]];
        tiers::find(gaps, among.skin, &mut self.tiers[before..]);
    }

    /// Makes room for the pairs that so many looks may find.
    fn room(&mut self, looks: usize) -> Room<'_> {
        let Self { pairs, touching, squared, turns, count, .. } = self;
        let most = looks * LANES;
        if squared.len() < most {
            squared.resize(most, 0.0);
        }
        let end = *count + most;
        if pairs.len() < end {
            pairs.resize(end + end / 4, [0; 2]);
            touching.resize(end + end / 4, 0.0);
        }
        let (pairs, touching) = (&mut pairs[*count..end], &mut touching[*count..end]);
        Room { pairs, touching, squared, turns, count: 0 }
    }
}

/// Room for the pairs of some looks, four for each.
struct Room<'a> {
    pairs: &'a mut [[u32; 2]],
    touching: &'a mut [f64],
    squared: &'a mut [f64],
    turns: &'a mut Vec<Turns>,
    /// How many were found.
    count: usize,
}

impl Room<'_> {
    fn look<const SHIFTED: bool>(&mut self, looks: &[Look], among: &Among<'_>) {
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2")
            && std::arch::is_x86_feature_detected!("popcnt")
        {
            // SAFETY: the machine has these instructions.
            unsafe { avx2::look::<SHIFTED>(self, looks, among) };
            return;
        }
        self.look_one_by_one::<SHIFTED>(looks, among);
    }

    fn look_one_by_one<const SHIFTED: bool>(&mut self, looks: &[Look], among: &Among<'_>) {
        let Among { discs, skin, .. } = *among;
        for &Look { ends: [disc, first], stop, turns } in looks {
            let [x, y] = discs.positions[disc as usize];
            let radius = discs.radii[disc as usize];
            let shift = among.shift(turns);
            for other in first..Ord::min(stop, first + LANES as u32) {
                let [mut other_x, mut other_y] = discs.positions[other as usize];
                if SHIFTED {
                    (other_x, other_y) = (other_x + shift[0], other_y + shift[1]);
                }
                let apart = [x - other_x, y - other_y];
                let squared = apart[0] * apart[0] + apart[1] * apart[1];
                let touching = radius + discs.radii[other as usize];
                let reach = touching + skin;
                // A position that is no number is near nothing.
                if squared < reach * reach {
                    let [from, others_from] = among.counted_from.map(|disc| disc as u32);
                    self.pairs[self.count] = [disc - from, other - others_from];
                    self.touching[self.count] = touching;
                    self.squared[self.count] = squared;
                    self.count += 1;
                    if SHIFTED {
                        self.turns.push(turns);
                    }
                }
            }
        }
    }
}

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use super::{Among, LANES, Look, Room};
    use crate::dem::forces::fours::those_first;
    use std::arch::x86_64::*;

    /// For each set of lanes that are near, an order of 32-bit halves that puts these lanes first.
    const NEAR_FIRST: [[u32; 8]; 16] = {
        let mut orders = [[0; 8]; 16];
        let mut set = 0;
        while set < 16 {
            let lanes = those_first(set);
            let mut half = 0;
            while half < 8 {
                orders[set][half] = 2 * lanes[half / 2] as u32 + half as u32 % 2;
                half += 1;
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

    /// The x of four centers, and their y.
    #[inline]
    #[target_feature(enable = "avx2")]
    fn columns(&[a, b, c, d]: &[[f64; 2]; LANES]) -> [__m256d; 2] {
        let (low, high) = (load(&[a[0], a[1], b[0], b[1]]), load(&[c[0], c[1], d[0], d[1]]));
        let even = _mm256_permute2f128_pd::<0x20>(low, high);
        let odd = _mm256_permute2f128_pd::<0x31>(low, high);
        [_mm256_unpacklo_pd(even, odd), _mm256_unpackhi_pd(even, odd)]
    }

    /// For each number of others, the lanes that hold them.
    const LANES_OF: [u32; LANES + 1] = [0, 1, 3, 7, 15];

    #[target_feature(enable = "avx2,popcnt")]
    pub(in crate::dem) fn look<const SHIFTED: bool>(
        room: &mut Room<'_>,
        looks: &[Look],
        among: &Among<'_>,
    ) {
        let mut rest = looks;
        while let Some((one, others)) = rest.split_first() {
            let done = look_at_fours::<SHIFTED>(room, rest, among);
            if done > 0 {
                rest = &rest[done..];
            } else {
                // The last few discs of all.
                room.look_one_by_one::<SHIFTED>(std::slice::from_ref(one), among);
                rest = others;
            }
        }
    }

    /// Looks at fours of discs up to the first look behind which fewer discs stand in memory; returns how many were done.
    #[inline]
    #[target_feature(enable = "avx2,popcnt")]
    fn look_at_fours<const SHIFTED: bool>(
        room: &mut Room<'_>,
        looks: &[Look],
        among: &Among<'_>,
    ) -> usize {
        let most = room.count + looks.len() * LANES;
        assert!(room.pairs.len() >= most, "no room for pairs");
        assert!(room.touching.len() >= most, "no room for their reach");
        assert!(room.squared.len() >= most, "no room for their distances");
        let pairs = room.pairs.as_mut_ptr();
        let (touchings, squares) = (room.touching.as_mut_ptr(), room.squared.as_mut_ptr());
        let positions = &among.discs.positions[..];
        // Of one length: looked at once.
        let radii = &among.discs.radii[..positions.len()];
        let skin = _mm256_set1_pd(among.skin);
        let [a, b] = among.counted_from.map(|disc| disc as i32);
        let counted = _mm256_sub_epi32(
            _mm256_setr_epi32(0, 0, 0, 1, 0, 2, 0, 3),
            _mm256_setr_epi32(a, b, a, b, a, b, a, b),
        );
        let mut count = room.count;
        for (number, look) in looks.iter().enumerate() {
            let [disc, first] = look.ends.map(|disc| disc as usize);
            let others = first..first + LANES;
            let centers = positions.get(others.clone()).and_then(|centers| centers.first_chunk());
            let other_radii = radii.get(others).and_then(|radii| radii.first_chunk());
            let (Some(centers), Some(other_radii)) = (centers, other_radii) else {
                room.count = count;
                return number;
            };
            let [mut other_x, mut other_y] = columns(centers);
            if SHIFTED {
                let [shift_x, shift_y] = among.shift(look.turns).map(|part| _mm256_set1_pd(part));
                other_x = _mm256_add_pd(other_x, shift_x);
                other_y = _mm256_add_pd(other_y, shift_y);
            }
            let [x, y] = positions[disc].map(|value| _mm256_set1_pd(value));
            let (x, y) = (_mm256_sub_pd(x, other_x), _mm256_sub_pd(y, other_y));
            let squared = _mm256_add_pd(_mm256_mul_pd(x, x), _mm256_mul_pd(y, y));
            let touching = _mm256_add_pd(_mm256_set1_pd(radii[disc]), load(other_radii));
            let reach = _mm256_add_pd(touching, skin);
            let near = _mm256_cmp_pd::<_CMP_LT_OQ>(squared, _mm256_mul_pd(reach, reach));
            // Discs behind the last one do not count.
            let others = LANES_OF[Ord::min(look.stop - look.ends[1], LANES as u32) as usize];
            let near = _mm256_movemask_pd(near) as u32 & others;
            // The disc below, the other above.
            let ends = u64::from(look.ends[1]) << 32 | u64::from(look.ends[0]);
            let ends = _mm256_add_epi32(_mm256_set1_epi64x(ends as i64), counted);
            let (touching, squared) = (_mm256_castpd_si256(touching), _mm256_castpd_si256(squared));
            // SAFETY: there is room for four pairs of every look.
            unsafe {
                let order = order_of(near);
                store(pairs.add(count).cast(), ends, order);
                store(touchings.add(count).cast(), touching, order);
                store(squares.add(count).cast(), squared, order);
            }
            let found = near.count_ones() as usize;
            if SHIFTED {
                room.turns.extend(std::iter::repeat_n(look.turns, found));
            }
            count += found;
        }
        room.count = count;
        looks.len()
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
    use crate::dem::discs::Disc;

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
            let (mut wide_room, mut room) = (wide.room(looks.len()), single.room(looks.len()));
            wide_room.look::<SHIFTED>(looks, among);
            room.look_one_by_one::<SHIFTED>(looks, among);
            let found = room.count;
            assert_eq!(wide_room.count, found);
            assert_eq!(wide_room.squared[..found], room.squared[..found]);
            wide.count += found;
            single.count += found;
        }
        assert_eq!(wide.pairs(), single.pairs());
        assert_eq!(wide.touching(), single.touching());
        assert_eq!(wide.turns(), single.turns());
        assert_eq!(wide.turns().len(), if SHIFTED { wide.count } else { 0 });
        wide.count / 2
    }
}
