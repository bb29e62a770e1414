//! Finding the pairs of a block's lists.

use super::cells::{Cells, Run, Runs, Stretch};
use super::discs::Discs;
use super::found::{Among, Found, Looks};
use super::neighbours::{Block, Pairs, Surroundings, WallPair};
use super::tiers::{Sorter, TIERS};
use std::ops::Range;

/// Where pairs are looked for.
pub(super) struct Grid<'a> {
    pub(super) discs: &'a Discs,
    /// The cells that the discs are sorted by.
    pub(super) cells: &'a Cells,
    pub(super) around: &'a Surroundings<'a>,
    /// How far the list reaches beyond touching, m.
    pub(super) skin: f64,
}

/// Memory of the search.
#[derive(Default)]
pub(super) struct Finder {
    around: Runs,
    inner: Looks,
    edges: Looks,
    found: Found,
    sorter: Sorter,
}

impl Finder {
    /// Lists the pairs of a block, its edges and its discs near walls anew.
    pub(super) fn fill(&mut self, block: &mut Block, grid: &Grid<'_>) {
        let own = block.start..block.start + block.len(grid.discs);
        self.inner.clear();
        self.edges.clear();
        let mut disc = own.start;
        while disc < own.end {
            disc = match grid.cells.stretch(disc, &own) {
                Some(stretch) => self.look_from_stretch(disc, &stretch),
                None => self.look_from_cell(disc, &own, grid),
            };
        }
        let Grid { discs, skin, around, .. } = *grid;
        let inner =
            Among { discs, skin, counted_from: [block.start, block.start], sides: around.sides };
        self.found.look::<false>(&self.inner, &inner);
        let ends = self.sorter.sort(&self.found, skin);
        self.sorter.deal_to_strands(ends[0]);
        self.hand_over(&mut block.inner, ends, &inner, around);
        let edges = Among { counted_from: [block.start, 0], ..inner };
        self.found.look::<true>(&self.edges, &edges);
        let ends = self.sorter.sort(&self.found, skin);
        self.hand_over(&mut block.edges, ends, &edges, around);
        block.shifts.clear();
        let turns = self.found.turns();
        let shifts = self.sorter.order().iter().map(|&pair| edges.shift(turns[pair as usize]));
        block.shifts.extend(shifts);
        block.walls.clear();
        for disc in own {
            list_walls(block, disc, grid);
        }
    }

    /// Each disc of a stretch, which begins with one, is compared with those behind it in its own column and with those
    /// beside it in the next. Returns where the stretch ends.
    fn look_from_stretch(&mut self, begin: usize, stretch: &Stretch<'_>) -> usize {
        for (disc, &cell) in (begin as u32..).zip(stretch.cells) {
            self.inner.add(disc, disc + 1..stretch.end_above(cell), [0, 0]);
            self.inner.add(disc, stretch.beside(cell), [0, 0]);
        }
        begin + stretch.cells.len()
    }

    /// The same for the rest of a cell that begins with a disc, wherever it is.
    fn look_from_cell(&mut self, begin: usize, own: &Range<usize>, grid: &Grid<'_>) -> usize {
        grid.cells.around(grid.discs.position(begin), &mut self.around);
        let end = grid.cells.end_of_cell(begin, own);
        let places = |discs: Range<usize>| discs.start as u32..discs.end as u32;
        for disc in begin..end {
            for Run { discs: run, shift } in &self.around.runs {
                let (disc, shift) = (disc as u32, *shift);
                if shift != [0, 0] {
                    // Images stand beside the block as a whole.
                    self.edges.add(disc, places(run.clone()), shift);
                    continue;
                }
                // Each inner pair once.
                let inner = Ord::max(run.start, disc as usize + 1)..Ord::min(run.end, own.end);
                self.inner.add(disc, places(inner), shift);
                // What stands before and behind the block.
                let before = run.start..Ord::min(run.end, own.start);
                self.edges.add(disc, places(before), shift);
                let behind = Ord::max(run.start, own.end)..run.end;
                self.edges.add(disc, places(behind), shift);
            }
        }
        end
    }

    /// Makes the pairs found a list, in the order that was found, with what does not change until it is built anew.
    fn hand_over(
        &self,
        list: &mut Pairs,
        ends: [u32; TIERS],
        among: &Among<'_>,
        around: &Surroundings<'_>,
    ) {
        let order = self.sorter.order();
        list.resize(order.len(), ends);
        let (pairs, touching) = (self.found.pairs(), self.found.touching());
        let columns = list.first.iter_mut().zip(&mut list.second).zip(&mut list.reach);
        for (((first, second), reach), &pair) in columns.zip(order) {
            [*first, *second] = pairs[pair as usize];
            *reach = touching[pair as usize];
        }
        let ends = [&*list.first, &*list.second];
        around.law.dampings(among.discs, among.counted_from, ends, &mut list.damping);
    }
}

fn list_walls(block: &mut Block, disc: usize, grid: &Grid<'_>) {
    let discs = grid.discs;
    for (wall, placed) in grid.around.walls.iter().enumerate() {
        if placed.shape.footing(discs.position(disc)).distance < discs.radii[disc] + grid.skin {
            block.walls.push(WallPair {
                disc: (disc - block.start) as u32,
                wall: wall as u32,
                damping: grid.around.law.wall_damping(discs, disc),
                stretch: [0.0; 2],
            });
        }
    }
}
