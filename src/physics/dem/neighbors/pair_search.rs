//! Finding the pairs of a block's lists.
//!
//! A disc is compared with those behind it in its own column of three cells and with the three cells beside it in the next column;
//! at the edge of a band, of a block or of the box with what stands around it, piece by piece. Who is compared with whom is
//! noted first, then all comparisons are made in one loop, then the pairs found are sorted by their tiers.

use crate::dem::discs::Discs;
use crate::dem::neighbors::cell_grid::{Cells, Run, Stretch};
use crate::dem::neighbors::pair_buffer::{Among, Found, Looks, Turns};
use crate::dem::neighbors::tiers::{Sorter, TIERS};
use crate::dem::neighbors::{Block, Pairs, Surroundings, WallPair};
use std::ops::Range;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::{fmt, mem};

/// Where pairs are looked for.
pub(in crate::dem) struct Grid<'a> {
    pub(in crate::dem) discs: &'a Discs,
    /// The cells that the discs are sorted by.
    pub(in crate::dem) cells: &'a Cells,
    pub(in crate::dem) around: &'a Surroundings<'a>,
    /// How far the list reaches beyond touching, m.
    pub(in crate::dem) skin: f64,
}

/// Memory of a search.
#[derive(Default)]
struct Finder {
    around: Vec<Run>,
    /// Comparisons with discs of the block, and with others or images.
    inner: Looks,
    edges: Looks,
    found: Found,
    sorter: Sorter,
    /// Which of the block's discs are near a wall.
    are_near: Vec<bool>,
}

/// So many looks are taken at once: they stay in the nearest cache.
const MANY: usize = 256;
/// Discs that follow each other, of which mostly none is near a wall.
const GROUP: usize = 16;

/// Memory of searches that are over. It is kept from list to list: fresh memory would have to be cleared, and
/// is not in the cache.
#[derive(Default)]
pub(in crate::dem) struct Finders(Mutex<Vec<Finder>>);

/// A search: its memory is given back when it ends.
pub(in crate::dem) struct Search<'a> {
    finders: &'a Finders,
    finder: Finder,
}

impl Finders {
    fn idle(&self) -> MutexGuard<'_, Vec<Finder>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Begins a search.
    pub(in crate::dem) fn search(&self) -> Search<'_> {
        let finder = self.idle().pop().unwrap_or_default();
        Search { finders: self, finder }
    }
}

/// A copy of a run finds its own memory.
impl Clone for Finders {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl fmt::Debug for Finders {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_struct("Finders").finish_non_exhaustive()
    }
}

impl Drop for Search<'_> {
    fn drop(&mut self) {
        self.finders.idle().push(mem::take(&mut self.finder));
    }
}

impl Search<'_> {
    /// Lists the pairs of a block, its edges and its discs near walls anew.
    pub(in crate::dem) fn fill(&mut self, block: &mut Block, grid: &Grid<'_>) {
        self.finder.fill(block, grid);
    }
}

impl Finder {
    fn fill(&mut self, block: &mut Block, grid: &Grid<'_>) {
        let Grid { discs, skin, around, .. } = *grid;
        let own = block.start..block.start + block.len(discs);
        let inner =
            Among { discs, skin, counted_from: [block.start, block.start], sides: around.sides };
        self.found.clear();
        let mut disc = own.start;
        while disc < own.end {
            disc = match grid.cells.stretch(disc, &own) {
                Some(stretch) => self.look_from_stretch(disc, &stretch),
                None => self.look_from_cell(disc, &own, grid),
            };
            if self.inner.len() >= MANY {
                self.found.take::<false>(&mut self.inner, &inner);
            }
        }
        self.found.take::<false>(&mut self.inner, &inner);
        let ends = self.sorter.sort(self.found.tiers());
        self.sorter.deal_to_strands(ends[0]);
        self.hand_over(&mut block.inner, ends, &inner, around);
        let edges = Among { counted_from: [block.start, 0], ..inner };
        self.found.clear();
        self.found.take::<true>(&mut self.edges, &edges);
        let ends = self.sorter.sort(self.found.tiers());
        self.hand_over(&mut block.edges, ends, &edges, around);
        block.shifts.clear();
        let turns = self.found.turns();
        let shifts = self.sorter.order().iter().map(|&pair| edges.shift(turns[pair as usize]));
        block.shifts.extend(shifts);
        self.list_walls(block, own, grid);
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
        grid.cells.around(grid.discs.positions[begin], &mut self.around);
        let end = grid.cells.end_of_cell(begin, own);
        let add = |looks: &mut Looks, disc: usize, others: Range<usize>, shift: Turns| {
            if !others.is_empty() {
                looks.add(disc as u32, others.start as u32..others.end as u32, shift);
            }
        };
        for disc in begin..end {
            for Run { discs: run, shift } in &self.around {
                if *shift != [0, 0] {
                    // Images stand beside the block as a whole.
                    add(&mut self.edges, disc, run.clone(), *shift);
                    continue;
                }
                // Each inner pair once.
                let inner = Ord::max(run.start, disc + 1)..Ord::min(run.end, own.end);
                add(&mut self.inner, disc, inner, *shift);
                // What stands before and behind the block.
                add(&mut self.edges, disc, run.start..Ord::min(run.end, own.start), *shift);
                add(&mut self.edges, disc, Ord::max(run.start, own.end)..run.end, *shift);
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

    /// Lists the discs near walls: a disc with one wall after the other.
    fn list_walls(&mut self, block: &mut Block, own: Range<usize>, grid: &Grid<'_>) {
        let Grid { discs, skin, around, .. } = *grid;
        block.walls.clear();
        self.are_near.clear();
        // Up to a whole group; there are no discs behind the last one.
        self.are_near.resize(own.len().next_multiple_of(GROUP), false);
        for wall in around.walls {
            let are_near = &mut self.are_near;
            let (positions, radii) = (&discs.positions[own.clone()], &discs.radii[own.clone()]);
            wall.shape.mark_near(positions, radii, skin, are_near);
        }
        // Most discs are far from all walls.
        let (groups, _) = self.are_near.as_chunks::<GROUP>();
        let some = groups.iter().enumerate().filter(|&(_, group)| *group != [false; GROUP]);
        for number in some.flat_map(|(group, _)| group * GROUP..(group + 1) * GROUP) {
            if self.are_near[number] {
                list_walls_of(block, own.start + number, grid);
            }
        }
    }
}

/// Lists a disc with the walls that it is near.
fn list_walls_of(block: &mut Block, disc: usize, grid: &Grid<'_>) {
    let Grid { discs, skin, around, .. } = *grid;
    let reach = discs.radii[disc] + skin;
    for (wall, placed) in (0..).zip(around.walls) {
        if placed.shape.footing(discs.positions[disc]).distance < reach {
            block.walls.push(WallPair {
                disc: (disc - block.start) as u32,
                wall,
                damping: around.law.wall_damping(discs, disc),
                stretch: [0.0; 2],
            });
        }
    }
}
