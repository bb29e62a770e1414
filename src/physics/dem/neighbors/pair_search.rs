//! Search for the pairs of a block's lists.
//!
//! A disc is compared with those behind it in its own column of three cells and with the three adjacent cells of the next column;
//! at the border of a band, of a block or of the box, with all surrounding cells. First all comparisons are listed, then they are made
//! in one loop, then the pairs found are sorted by tier.

use crate::dem::block::{Block, DiscIndex, Pairs, Partner, TIERS, WallPair};
use crate::dem::discs::Discs;
use crate::dem::neighbors::cell_grid::{CellGrid, CellRun, ColumnRun};
use crate::dem::neighbors::pair_buffer::{Comparisons, ImageShift, PairBuffer, SearchSpace};
use crate::dem::neighbors::tiers::Sorter;
use crate::dem::parameters::Parameters;
use crate::dem::spare::Spare;
use crate::dem::walls::{self, PlacedWall};
use std::ops::Range;

/// The discs, the cells, and the constants of a search.
pub(crate) struct PairSearch<'a> {
    pub(crate) discs: &'a Discs,
    /// The cells that the discs are sorted by.
    pub(crate) cells: &'a CellGrid,
    pub(crate) around: &'a Surroundings<'a>,
    /// Distance beyond contact up to which pairs are listed, m.
    pub(crate) skin: f64,
}

/// What lists depend on, besides the discs.
pub(crate) struct Surroundings<'a> {
    pub(crate) parameters: &'a Parameters,
    pub(crate) walls: &'a [PlacedWall],
    /// Displacements of the walls since the start, m.
    pub(crate) displacements: &'a [[f64; 2]],
    pub(crate) memory: &'a SearchMemory,
}

/// Memory of a search.
#[derive(Debug, Default)]
struct Finder {
    around: Vec<CellRun>,
    /// Comparisons within the block.
    inner: Comparisons,
    /// Comparisons with discs of other blocks or with images.
    inter_block: Comparisons,
    found: PairBuffer,
    sorter: Sorter,
    /// Whether each of the block's discs is near a wall.
    are_near: Vec<bool>,
}

/// Comparisons made at a time: they stay in the nearest cache.
const MANY: usize = 256;
/// Adjacent discs of which mostly none is near a wall.
const GROUP: usize = 16;

/// Memory of finished searches, which is kept from list to list.
#[derive(Clone, Debug, Default)]
pub(crate) struct SearchMemory(Spare<Finder>);

impl SearchMemory {
    /// Rebuilds the lists of a block: inner pairs, inter-block pairs and discs near walls.
    pub(crate) fn fill(&self, block: &mut Block, search: &PairSearch<'_>) {
        self.0.lend(|finder| finder.fill(block, search));
    }
}

impl Finder {
    fn fill(&mut self, block: &mut Block, search: &PairSearch<'_>) {
        let PairSearch { discs, skin, around, .. } = *search;
        let own = block.start..block.start + block.len(discs.len());
        let (counted_from, parameters) = ([block.start, block.start], around.parameters);
        let inner = SearchSpace { discs, skin, counted_from, parameters };
        self.found.clear();
        let mut disc = own.start;
        while disc < own.end {
            disc = match search.cells.column_run(disc, &own) {
                Some(run) => self.compare_column_run(disc, &run),
                None => self.compare_cell(disc, &own, search),
            };
            if self.inner.len() >= MANY {
                self.found.take::<false>(&mut self.inner, &inner);
            }
        }
        self.found.take::<false>(&mut self.inner, &inner);
        let ends = self.sorter.sort(&self.found.tiers);
        self.sorter.interleave_quarters(ends[0]);
        self.fill_list(&mut block.inner, ends, &inner);
        let inter_block = SearchSpace { counted_from: [block.start, 0], ..inner };
        self.found.clear();
        self.found.take::<true>(&mut self.inter_block, &inter_block);
        let ends = self.sorter.sort(&self.found.tiers);
        self.fill_list(&mut block.inter_block, ends, &inter_block);
        block.shifts.clear();
        let shifts = &self.found.shifts;
        let order = self.sorter.order().iter();
        block.shifts.extend(order.map(|&pair| inter_block.vector(shifts[pair as usize])));
        self.list_walls(block, own, search);
    }

    /// Compares each disc of a run, which begins with disc `begin`, with those behind it in its own column and with the adjacent
    /// ones in the next column. Returns the end of the run.
    fn compare_column_run(&mut self, begin: usize, run: &ColumnRun<'_>) -> usize {
        for (disc, &cell) in (begin as u32..).zip(run.cells) {
            self.inner.add(disc, disc + 1..run.end_above(cell), [0, 0]);
            self.inner.add(disc, run.next_column(cell), [0, 0]);
        }
        begin + run.cells.len()
    }

    /// Compares the discs from `begin` to the end of its cell with all surrounding cells. Returns the end of the cell.
    fn compare_cell(&mut self, begin: usize, own: &Range<usize>, search: &PairSearch<'_>) -> usize {
        search.cells.around(search.discs.positions[begin], &mut self.around);
        let end = search.cells.end_of_cell(begin, own);
        let add = |to: &mut Comparisons, disc: usize, others: Range<usize>, shift: ImageShift| {
            if !others.is_empty() {
                to.add(disc as u32, others.start as u32..others.end as u32, shift);
            }
        };
        for disc in begin..end {
            for CellRun { discs: run, shift } in &self.around {
                if *shift != [0, 0] {
                    // Images never belong to the block.
                    add(&mut self.inter_block, disc, run.clone(), *shift);
                    continue;
                }
                // Each inner pair once.
                let inner = Ord::max(run.start, disc + 1)..Ord::min(run.end, own.end);
                add(&mut self.inner, disc, inner, *shift);
                // The discs before and behind the block.
                add(&mut self.inter_block, disc, run.start..Ord::min(run.end, own.start), *shift);
                add(&mut self.inter_block, disc, Ord::max(run.start, own.end)..run.end, *shift);
            }
        }
        end
    }

    /// Copies the pairs found into a list, in the order of the sorter, with their constants.
    fn fill_list<Second: DiscIndex>(
        &self,
        list: &mut Pairs<Second>,
        ends: [u32; TIERS],
        space: &SearchSpace<'_>,
    ) {
        let order = self.sorter.order();
        list.resize(order.len(), ends);
        let (pairs, reaches) = (self.found.pairs(), self.found.reach());
        let ends = list.first.chunks_mut(MANY).zip(list.second.chunks_mut(MANY));
        let constants = list.reach.chunks_mut(MANY).zip(list.damping.chunks_mut(MANY));
        let (mut wide_first, mut wide_second) = ([0; MANY], [0; MANY]);
        for (((firsts, seconds), (reach, damping)), order) in
            ends.zip(constants).zip(order.chunks(MANY))
        {
            let columns = firsts.iter_mut().zip(seconds).zip(reach);
            let wide = wide_first.iter_mut().zip(&mut wide_second);
            for ((((first, second), reach), wide), &pair) in columns.zip(wide).zip(order) {
                [*wide.0, *wide.1] = pairs[pair as usize];
                (*first, *second) = (DiscIndex::narrowed(*wide.0), DiscIndex::narrowed(*wide.1));
                *reach = reaches[pair as usize];
            }
            let ends = [&wide_first[..order.len()], &wide_second[..order.len()]];
            let law = &space.parameters.law;
            law.dampings(space.discs, space.counted_from, ends, damping);
        }
    }

    /// Lists the discs near walls, disc by disc.
    fn list_walls(&mut self, block: &mut Block, own: Range<usize>, search: &PairSearch<'_>) {
        let PairSearch { discs, skin, around, .. } = *search;
        block.walls.clear();
        self.are_near.clear();
        // Filled up to a whole group; there are no discs behind the last one.
        self.are_near.resize(own.len().next_multiple_of(GROUP), false);
        for wall in around.walls {
            let are_near = &mut self.are_near;
            let (positions, radii) = (&discs.positions[own.clone()], &discs.radii[own.clone()]);
            walls::mark_near(wall.shape, positions, radii, skin, are_near);
        }
        // Most groups are far from all walls.
        let (groups, _) = self.are_near.as_chunks::<GROUP>();
        let some = groups.iter().enumerate().filter(|&(_, group)| *group != [false; GROUP]);
        for number in some.flat_map(|(group, _)| group * GROUP..(group + 1) * GROUP) {
            if self.are_near[number] {
                list_walls_of(block, own.start + number, search);
            }
        }
    }
}

/// Lists the walls near a disc.
fn list_walls_of(block: &mut Block, disc: usize, search: &PairSearch<'_>) {
    let PairSearch { discs, skin, around, .. } = *search;
    let reach = discs.radii[disc] + skin;
    for (wall, placed) in (0..).zip(around.walls) {
        if placed.shape.contact(discs.positions[disc]).distance < reach {
            block.walls.push(WallPair {
                disc: (disc - block.start) as u32,
                wall,
                damping: around.parameters.law.damping(discs, disc, Partner::Wall(wall)),
                stretch: [0.0; 2],
            });
        }
    }
}
