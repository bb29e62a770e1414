//! Finding the pairs of a block's lists.

use super::cells::{Cells, Run, Runs};
use super::discs::Discs;
use super::found::{Found, Looker};
use super::neighbours::{Block, Surroundings, WallPair};
use super::tiers;
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
    found: Found,
    tiers: Vec<u32>,
    edges: Vec<Edge>,
}

/// A pair of two blocks, or across a periodic side, that was found.
struct Edge {
    tier: u32,
    /// The block's disc, counted from its first, and the other, counted from the first of all.
    ends: [u32; 2],
    /// r_i + r_j, m.
    touching: f64,
    /// What is added to the other's centre, m.
    shift: [f64; 2],
}

impl Finder {
    /// Lists the pairs of a block, its edges and its discs near walls anew.
    pub(super) fn fill(&mut self, block: &mut Block, grid: &Grid<'_>) {
        let Grid { discs, cells, .. } = *grid;
        let own = block.start..block.start + block.len(discs);
        self.edges.clear();
        block.walls.clear();
        self.found.clear();
        self.around = Runs::default();
        let mut is_inside = false;
        for disc in own.clone() {
            let from = Looker { disc, start: own.start };
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
                        self.found.look(from, after, discs, grid.skin);
                    }
                }
                if !is_inside {
                    // What stands before and after the block; images stand beside it as a whole.
                    let own = if shift == [0, 0] { own.clone() } else { end..end };
                    let (before, behind) =
                        (start..Ord::min(end, own.start), Ord::max(start, own.end)..end);
                    self.list_edges(from, before, shift, grid);
                    self.list_edges(from, behind, shift, grid);
                }
            }
            list_walls(block, disc, grid);
        }
        self.hand_over(block, grid);
        self.hand_over_edges(block, grid);
    }

    /// Makes the pairs found the block's, with what does not change until the list is built anew.
    fn hand_over(&mut self, block: &mut Block, grid: &Grid<'_>) {
        let list = &mut block.inner;
        tiers::sort(&self.found, grid.skin, &mut self.tiers, list);
        let ends = list.first.iter().zip(&list.second);
        for (damping, (&first, &second)) in list.damping.iter_mut().zip(ends) {
            let [first, second] = [first, second].map(|disc| block.start + disc as usize);
            *damping = grid.around.law.damping(grid.discs, first, second);
        }
    }

    /// Lists a disc's pairs with a run of discs of other blocks, or with images beyond a periodic side.
    fn list_edges(&mut self, from: Looker, others: Range<usize>, shift: [i8; 2], grid: &Grid<'_>) {
        if others.is_empty() {
            return;
        }
        let discs = grid.discs;
        let [x, y] = discs.position(from.disc);
        let radius = discs.radii[from.disc];
        let shift = [0, 1].map(|axis: usize| f64::from(shift[axis]) * grid.around.sides[axis]);
        for other in others {
            let [other_x, other_y] = discs.position(other);
            let apart = [x - (other_x + shift[0]), y - (other_y + shift[1])];
            let squared = apart[0] * apart[0] + apart[1] * apart[1];
            let touching = radius + discs.radii[other];
            let reach = touching + grid.skin;
            if squared < reach * reach {
                let tier = tiers::tier_of(squared.sqrt() - touching, grid.skin);
                let ends = [(from.disc - from.start) as u32, other as u32];
                self.edges.push(Edge { tier, ends, touching, shift });
            }
        }
    }

    /// Makes the edges found the block's, by tier, in the order found within a tier.
    fn hand_over_edges(&mut self, block: &mut Block, grid: &Grid<'_>) {
        self.edges.sort_by_key(|edge| edge.tier);
        let list = &mut block.edges;
        list.clear();
        list.ends = tiers::ends_of(self.edges.iter().map(|edge| edge.tier));
        list.first.extend(self.edges.iter().map(|edge| edge.ends[0]));
        list.second.extend(self.edges.iter().map(|edge| edge.ends[1]));
        list.reach.extend(self.edges.iter().map(|edge| edge.touching));
        list.damping.extend(self.edges.iter().map(|edge| {
            let [own, other] = edge.ends.map(|disc| disc as usize);
            grid.around.law.damping(grid.discs, block.start + own, other)
        }));
        block.shifts.clear();
        block.shifts.extend(self.edges.iter().map(|edge| edge.shift));
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
