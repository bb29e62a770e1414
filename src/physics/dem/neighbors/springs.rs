//! Springs of friction are carried from one list to the next by the ids of their two discs.
//!
//! The stretch of a tangential spring does not depend on the order of its discs. That of a rolling spring does: it measures the
//! rotation of the first disc against the second, and changes sign if the next list swaps the two.

use crate::dem::block::{Block, DiscIndex, Pairs, Stretch};
use crate::dem::discs::Discs;
use crate::simd::registers::MAX_WIDTH;
use serde::{Deserialize, Serialize};

/// Stretched springs, in the order of the ids of their ends.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Springs {
    /// The smaller id first; stretches are relative to it.
    pairs: Vec<([u32; 2], Stretch)>,
    /// A disc's id and a wall's number.
    walls: Vec<([u32; 2], Stretch)>,
}

/// The first spring of each smaller id in a sorted list, so that a spring is found without a search.
struct SpringIndex<'a> {
    springs: &'a [([u32; 2], Stretch)],
    starts: Vec<u32>,
}

/// Finds springs while lists are built.
pub(crate) struct SpringFinder<'a> {
    pairs: SpringIndex<'a>,
    walls: SpringIndex<'a>,
}

impl Springs {
    /// All stretched springs of the lists.
    pub(crate) fn of(blocks: &[Block], discs: &Discs) -> Self {
        let mut springs = Self::default();
        for block in blocks {
            let id = |local: u32| discs.ids[block.start + local as usize];
            for (a, b, stretch) in stretched(&block.inner) {
                springs.pairs.push(from_smaller_id(id(a), id(b), stretch));
            }
            for (a, b, stretch) in stretched(&block.inter_block) {
                let (a, b) = (id(a), discs.ids[b as usize]);
                // The other block has a copy.
                if a < b {
                    springs.pairs.push(([a, b], stretch));
                }
            }
            let walls = block.walls.iter().filter(|pair| pair.stretch != [0.0; 2]);
            springs.walls.extend(walls.map(|pair| ([id(pair.disc), pair.wall], pair.stretch)));
        }
        springs.pairs.sort_unstable_by_key(|spring| spring.0);
        springs.walls.sort_unstable_by_key(|spring| spring.0);
        springs
    }

    pub(crate) fn finder(&self) -> SpringFinder<'_> {
        SpringFinder { pairs: SpringIndex::of(&self.pairs), walls: SpringIndex::of(&self.walls) }
    }
}

/// Pairs of a list with stretched springs.
fn stretched<Second: DiscIndex>(
    pairs: &Pairs<Second>,
) -> impl Iterator<Item = (u32, u32, Stretch)> {
    (0..pairs.stretch.len()).filter_map(|pair| {
        let stretch = pairs.stretch_of(pair);
        (stretch != [0.0; 2])
            .then(|| (pairs.first[pair].into(), pairs.second[pair].into(), stretch))
    })
}

/// A spring relative to the smaller of two ids; the same function converts back.
fn from_smaller_id(first: u32, second: u32, [sliding, rolling]: Stretch) -> ([u32; 2], Stretch) {
    if first < second {
        ([first, second], [sliding, rolling])
    } else {
        ([second, first], [sliding, -rolling])
    }
}

impl<'a> SpringIndex<'a> {
    fn of(springs: &'a [([u32; 2], Stretch)]) -> Self {
        let ids = springs.last().map_or(0, |spring| spring.0[0] as usize + 1);
        let mut starts = vec![0; ids + 1];
        for ([id, _], _) in springs {
            // Only a list from a damaged checkpoint is not sorted.
            if let Some(count) = starts.get_mut(*id as usize + 1) {
                *count += 1;
            }
        }
        let mut sum = 0;
        for start in &mut starts {
            sum += *start;
            *start = sum;
        }
        Self { springs, starts }
    }

    /// The stretch of a spring, zero if there is none.
    fn stretch(&self, ends: [u32; 2]) -> Stretch {
        let id = ends[0] as usize;
        let Some(&[start, end]) = self.starts.get(id..id + 2).and_then(|range| range.first_chunk())
        else {
            return [0.0; 2];
        };
        let from_here = &self.springs[start as usize..end as usize];
        from_here.iter().find(|spring| spring.0 == ends).map_or([0.0; 2], |spring| spring.1)
    }
}

impl SpringFinder<'_> {
    /// Copies the springs of persisting contacts into a block's new lists.
    pub(crate) fn fill_block(&self, block: &mut Block, discs: &Discs, has_rolling_friction: bool) {
        let start = block.start;
        let id = |local: u32| discs.ids[start + local as usize];
        self.fill(&mut block.inner, has_rolling_friction, |a, b| [id(a), id(b)]);
        self.fill(&mut block.inter_block, has_rolling_friction, |a, b| {
            [id(a), discs.ids[b as usize]]
        });
        for pair in &mut block.walls {
            pair.stretch = self.walls.stretch([id(pair.disc), pair.wall]);
        }
    }

    fn fill<Second: DiscIndex>(
        &self,
        pairs: &mut Pairs<Second>,
        has_rolling_friction: bool,
        ids: impl Fn(u32, u32) -> [u32; 2],
    ) {
        let Pairs { first, second, stretch, rolling_stretch, .. } = pairs;
        stretch.clear();
        let room = first.len().next_multiple_of(MAX_WIDTH);
        stretch.reserve_exact(room);
        rolling_stretch.clear();
        rolling_stretch.reserve_exact(if has_rolling_friction { room } else { 0 });
        for (&a, &b) in first.iter().zip(&*second) {
            let [a, b] = ids(a.into(), b.into());
            let (ends, _) = from_smaller_id(a, b, [0.0; 2]);
            let (_, [sliding, rolling]) = from_smaller_id(a, b, self.pairs.stretch(ends));
            stretch.push(sliding);
            if has_rolling_friction {
                rolling_stretch.push(rolling);
            }
        }
    }
}

#[cfg(test)]
mod contact_history_survives_list_rebuild {
    //! Law: a contact's springs keep their stretch when the lists are rebuilt, in any order of the discs and of the pair. A rolling spring
    //! is stretched by the rotation of the first disc against the second: if the two are swapped, its stretch changes sign.
    //!
    //! Source: Newton's third law: the torque of a rolling spring on one disc is the opposite of that on the other (Luding,
    //! Granular Matter 10 (2008) 235, section 3.3), before and after.
    //! Setup: 6000 random discs, several blocks; the springs of every listed pair are stretched by numbers that follow from the ids
    //! of its two discs; then the discs are displaced at random, so that their order changes, and the lists are rebuilt.
    //! Tolerance: none. Control: springs of pairs that leave the lists are released; many pairs are swapped.

    use crate::dem::block::{DiscIndex, Pairs, Stretch};
    use crate::dem::neighbors::lists_contain_every_contact::Case;
    use crate::dem::neighbors::pair_search::SearchMemory;
    use crate::random::{Seed, Stream};
    use kinetoscope_manifest::model::DemConfig;
    use kinetoscope_manifest::quantity::NonNegative;
    use std::collections::BTreeMap;

    const DISCS: u32 = 6000;
    const SIDE: f64 = 12.0;
    const RADIUS: f64 = 0.05;

    /// The stretch of two discs' springs, relative to the first.
    fn stretch(first: u32, second: u32) -> Stretch {
        let (low, high) = (f64::from(first.min(second)), f64::from(first.max(second)));
        let sense = if first < second { 1.0 } else { -1.0 };
        [1e-6 * (low + 1.0) + 1e-9 * high, sense * (1e-6 * (high + 1.0) + 1e-9 * low)]
    }

    /// Calls a function with the ids and the stretches of every listed pair, in the order of the list.
    fn for_each_pair(case: &mut Case, mut visit: impl FnMut([u32; 2], [&mut f64; 2])) {
        let ids = &case.discs.ids;
        for block in &mut case.neighbors.blocks {
            let own = &ids[block.start..];
            visit_all(&mut block.inner, [own, own], &mut visit);
            visit_all(&mut block.inter_block, [own, ids], &mut visit);
        }
    }

    /// The same for one list, whose indices are counted from the first of the given ids.
    fn visit_all<Second: DiscIndex>(
        pairs: &mut Pairs<Second>,
        [ids, other_ids]: [&[u32]; 2],
        visit: &mut impl FnMut([u32; 2], [&mut f64; 2]),
    ) {
        for pair in 0..pairs.len() {
            let second: u32 = pairs.second[pair].into();
            let ends = [ids[usize::from(pairs.first[pair])], other_ids[second as usize]];
            visit(ends, [&mut pairs.stretch[pair], &mut pairs.rolling_stretch[pair]]);
        }
    }

    #[test]
    fn springs_keep_their_stretch_and_sign() {
        let mut generator = Seed { seed: 5, replicate: 0 }.stream(Stream::Positions);
        let coefficient = NonNegative::new(0.5).expect("not negative");
        let config = DemConfig {
            friction: coefficient,
            rolling_friction: coefficient,
            ..DemConfig::default()
        };
        let (space, radii) = (([SIDE; 2], [false; 2]), (RADIUS, RADIUS));
        let memory = SearchMemory::default();
        let mut case = Case::new(DISCS, &config, space, radii, &mut generator, &memory);
        let mut was = BTreeMap::new();
        for_each_pair(&mut case, |ends, springs| {
            let [sliding, rolling] = stretch(ends[0], ends[1]);
            (*springs[0], *springs[1]) = (sliding, rolling);
            was.insert(ends, [sliding, rolling]);
        });
        // Far enough for other cells; some are in other rows.
        for [x, y] in &mut case.discs.positions {
            *x = (*x + generator.uniform_in(-RADIUS, RADIUS)).abs();
            *y = SIDE - (SIDE - *y - 0.3 * RADIUS).abs();
        }
        case.build(&memory);
        let (mut kept, mut swapped, mut new) = (0, 0, 0);
        for_each_pair(&mut case, |[first, second], springs| {
            let springs = springs.map(|stretch| *stretch);
            let is_old = was.contains_key(&[first, second]) || was.contains_key(&[second, first]);
            let wanted = if is_old { stretch(first, second) } else { [0.0; 2] };
            assert!(springs == wanted, "{first} and {second}: {springs:?} for {wanted:?}");
            kept += u32::from(is_old);
            new += u32::from(!is_old);
            swapped += u32::from(is_old && !was.contains_key(&[first, second]));
        });
        assert!(kept > 5000 && swapped > 100 && new > 500, "{kept}, {swapped}, {new}");
        // Springs of pairs that are now apart are visited once more, to be released.
        let tiers = case.neighbors.scope().tiers;
        for block in &case.neighbors.blocks {
            let ends = [block.inner.in_tiers(tiers), block.inter_block.in_tiers(tiers)];
            let stretches = [&block.inner.stretch, &block.inter_block.stretch];
            for (stretches, end) in stretches.into_iter().zip(ends) {
                let left = &stretches[end..];
                assert!(left.iter().all(|&stretch| stretch == 0.0), "a spring is forgotten");
            }
        }
    }
}
