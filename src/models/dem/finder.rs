//! Finding the pairs of a block's lists.

use super::cells::{Cells, Run, Runs};
use super::discs::Discs;
use super::neighbours::{Block, Surroundings, WallPair};
use std::ops::Range;

/// Discs of a block that are nearer to touching than this share of the skin come first in its list. Most of them touch,
/// most of the others do not, so that the branch on it is guessed well.
const NEAR_SHARE: f64 = 0.125;

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
    near: Found,
    far: Found,
}

/// Pairs found, by their places in the block. Room is made ahead, and a pair is written before it is known whether it
/// counts: there is no branch to guess.
#[derive(Default)]
struct Found {
    pairs: Vec<[u32; 2]>,
    count: usize,
}

impl Found {
    fn make_room(&mut self, more: usize) {
        let needed = self.count + more;
        if self.pairs.len() < needed {
            self.pairs.resize(2 * needed, [0; 2]);
        }
    }

    fn all(&self) -> &[[u32; 2]] {
        &self.pairs[..self.count]
    }

    /// The pairs of four quarters in turn: four at a time have different discs, and a sum of forces is not waited for
    /// where it goes on at once.
    fn in_four_strands(&self) -> impl Iterator<Item = &[u32; 2]> + Clone {
        let all = self.all();
        let quarter = all.len().div_ceil(4);
        let of_each = move |number| {
            (0..4).filter_map(move |strand| {
                all.get(strand * quarter + number).filter(|_| number < quarter)
            })
        };
        (0..quarter).flat_map(of_each)
    }

    #[inline]
    fn offer(&mut self, pair: [u32; 2], counts: bool) {
        self.pairs[self.count] = pair;
        self.count += usize::from(counts);
    }
}

impl Finder {
    /// Lists the pairs of a block, its edges and its discs near walls anew.
    pub(super) fn fill(&mut self, block: &mut Block, grid: &Grid<'_>) {
        let Grid { discs, cells, .. } = *grid;
        let own = block.start..block.start + block.len(discs);
        block.edges.clear();
        block.shifts.clear();
        block.walls.clear();
        (self.near.count, self.far.count) = (0, 0);
        self.around = Runs::default();
        let mut is_inside = false;
        for disc in own.clone() {
            // Discs of one cell follow each other.
            if cells.around(discs.position(disc), &mut self.around) {
                is_inside = self.around.are_within(&own);
            }
            for number in 0..self.around.runs.len() {
                let Run { discs: ref run, shift } = self.around.runs[number];
                let (start, end) = (run.start, run.end);
                if is_inside || shift == [0, 0] {
                    // Each inner pair once.
                    let after = Ord::max(start, disc + 1)..Ord::min(end, own.end);
                    if !after.is_empty() {
                        self.list_inner(own.start, disc, after, grid);
                    }
                }
                if !is_inside {
                    // What stands before and after the block; images stand beside it as a whole.
                    let own = if shift == [0, 0] { own.clone() } else { end..end };
                    list_edges(block, disc, start..Ord::min(end, own.start), shift, grid);
                    list_edges(block, disc, Ord::max(start, own.end)..end, shift, grid);
                }
            }
            list_walls(block, disc, grid);
        }
        self.hand_over(block, grid);
    }

    /// Lists a disc's pairs with others of its block.
    fn list_inner(&mut self, start: usize, disc: usize, others: Range<usize>, grid: &Grid<'_>) {
        let discs = grid.discs;
        let [x, y] = discs.position(disc);
        let radius = discs.radii[disc];
        self.near.make_room(others.len());
        self.far.make_room(others.len());
        for other in others {
            let [other_x, other_y] = discs.position(other);
            let apart = [x - other_x, y - other_y];
            let squared = apart[0] * apart[0] + apart[1] * apart[1];
            let touching = radius + discs.radii[other];
            let near = touching + NEAR_SHARE * grid.skin;
            let reach = touching + grid.skin;
            // A position that is no number is near nothing.
            let (is_near, is_listed) = (squared < near * near, squared < reach * reach);
            let pair = [(disc - start) as u32, (other - start) as u32];
            self.near.offer(pair, is_near);
            self.far.offer(pair, is_listed & !is_near);
        }
    }

    /// Makes what was found the block's list, with what does not change until it is built again.
    fn hand_over(&self, block: &mut Block, grid: &Grid<'_>) {
        let own = block.start..block.start + block.len(grid.discs);
        let radii = &grid.discs.radii[own.clone()];
        let (near, far) = (self.near.in_four_strands(), self.far.all());
        let found = || near.clone().chain(far);
        let list = &mut block.inner;
        list.clear();
        list.reserve(self.near.count + far.len());
        list.first.extend(found().map(|pair| pair[0]));
        list.second.extend(found().map(|pair| pair[1]));
        list.reach.extend(found().map(|pair| radii[pair[0] as usize] + radii[pair[1] as usize]));
        list.damping.extend(found().map(|pair| {
            let [first, second] = pair.map(|disc| own.start + disc as usize);
            grid.around.law.damping(grid.discs, first, second)
        }));
    }
}

/// Lists a disc's pairs with a run of discs of other blocks, or with images beyond a periodic side.
fn list_edges(
    block: &mut Block,
    disc: usize,
    others: Range<usize>,
    shift: [i8; 2],
    grid: &Grid<'_>,
) {
    if others.is_empty() {
        return;
    }
    let discs = grid.discs;
    let [x, y] = discs.position(disc);
    let shift = [0, 1].map(|axis: usize| f64::from(shift[axis]) * grid.around.sides[axis]);
    for other in others {
        let [other_x, other_y] = discs.position(other);
        let apart = [x - (other_x + shift[0]), y - (other_y + shift[1])];
        let touching = discs.radii[disc] + discs.radii[other];
        let reach = touching + grid.skin;
        if apart[0] * apart[0] + apart[1] * apart[1] < reach * reach {
            block.edges.first.push((disc - block.start) as u32);
            block.edges.second.push(other as u32);
            block.edges.reach.push(touching);
            block.edges.damping.push(grid.around.law.damping(discs, disc, other));
            block.shifts.push(shift);
        }
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
