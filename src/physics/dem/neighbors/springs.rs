//! Springs of friction are carried from one list to the next by the ids of their two discs.
//!
//! The stretch of a tangential spring does not depend on the order of its discs. That of a rolling spring does: it measures the
//! rotation of the first disc against the second, and changes sign if the next list swaps the two.

use crate::dem::block::{Block, DiscIndex, Pairs, Stretch};
use crate::dem::discs::Discs;
use crate::simd::registers::MAX_WIDTH;
use serde::{Deserialize, Serialize};

/// Stretched springs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Springs {
    /// The smaller id first; stretches are relative to it.
    pairs: Vec<([u32; 2], Stretch)>,
    /// A disc's id and a wall's number.
    walls: Vec<([u32; 2], Stretch)>,
}

/// The springs of each smaller id, so that a spring is found without a search, and the springs need not be sorted.
struct SpringIndex<'a> {
    springs: &'a [([u32; 2], Stretch)],
    /// Numbers of the springs, in the order of the smaller ids.
    order: Vec<u32>,
    /// The end of each smaller id's part of the order.
    ends: Vec<u32>,
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
        let ids = springs.iter().map(|([id, _], _)| *id as usize + 1).max().unwrap_or(0);
        let mut ends = vec![0; ids];
        for ([id, _], _) in springs {
            ends[*id as usize] += 1;
        }
        let mut sum = 0;
        for end in &mut ends {
            // The start at first; each spring then moves it by one.
            sum += std::mem::replace(end, sum);
        }
        let mut order = vec![0; springs.len()];
        for (number, ([id, _], _)) in springs.iter().enumerate() {
            let end = &mut ends[*id as usize];
            order[*end as usize] = number as u32;
            *end += 1;
        }
        Self { springs, order, ends }
    }

    /// The stretch of a spring, zero if there is none.
    fn stretch(&self, ends: [u32; 2]) -> Stretch {
        let id = ends[0] as usize;
        let Some(&end) = self.ends.get(id) else { return [0.0; 2] };
        let start = if id > 0 { self.ends[id - 1] } else { 0 };
        let mut springs = self.order[start as usize..end as usize].iter();
        let found = springs.find_map(|&number| {
            let (both, stretch) = self.springs[number as usize];
            (both == ends).then_some(stretch)
        });
        found.unwrap_or([0.0; 2])
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
