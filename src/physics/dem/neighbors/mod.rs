//! Half neighbor lists with a skin, one per block of discs.
//!
//! When the lists are built, discs are sorted by cell, so that the discs of a block are adjacent in memory. A pair within a block
//! is listed once; a pair of two blocks, or one across a periodic side, is listed with each of its discs, so that each block
//! writes forces only on its own discs. Block boundaries depend only on the number of discs, and sums follow the order of the
//! list; therefore, results do not depend on the number of threads.
//!
//! The lists contain every pair closer than contact plus the skin. They are valid until a disc or a wall has moved by half the
//! skin. Until then, a step visits only the tiers that may be in contact: see `tiers`. The order of the discs determines the bits of
//! sums, so the lists belong to the state.

pub(super) mod cell_grid;
pub(super) mod near_pairs;
pub(super) mod pair_buffer;
pub(super) mod pair_search;
pub(super) mod springs;
pub(super) mod tiers;

use crate::dem::block::{BLOCK, Block, TIERS};
use crate::dem::discs::{self, Discs};
use crate::dem::parameters::Parameters;
use cell_grid::CellGrid;
use pair_search::{PairSearch, Surroundings};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use springs::Springs;
use tiers::Scope;

/// The lists, and how long they are valid.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Neighbors {
    pub(super) blocks: Vec<Block>,
    /// Centers when the lists were built.
    built_at: Vec<[f64; 2]>,
    /// Displacements of the walls at that time.
    walls_at: Vec<[f64; 2]>,
    scope: Scope,
    /// Steps since the lists were built.
    age: u32,
    /// Springs taken out of the lists while discs are inserted or removed; empty at all other times.
    held: Option<Springs>,
}

/// Range of the skin over the mean radius, and its initial value.
const SKIN_RANGE: [f64; 2] = [0.1, 2.0];
const INITIAL_SKIN: f64 = 0.5;
/// Cost of building the lists, per disc, over that of comparing a pair.
const BUILD_OVER_COMPARISON: f64 = 40.0;

/// Blocks up to which near pairs are copied. They take 40 bytes per disc, too much in larger runs; a gas of 10^4 discs was slower by
/// a factor of 1.18 without.
const MAX_BLOCKS_WITH_NEAR_PAIRS: usize = 80;

impl Neighbors {
    /// Empty lists with the initial skin.
    pub(super) fn new(mean_radius: f64) -> Self {
        let scope = Scope { skin: INITIAL_SKIN * mean_radius, ..Scope::default() };
        Self { scope, ..Self::default() }
    }

    /// Whether restored lists cover all discs and refer to existing ones.
    pub(super) fn is_valid_for(&self, discs: &Discs, parameters: &Parameters) -> bool {
        let (count, walls, law) = (discs.len(), parameters.walls.len(), &parameters.law);
        let has_springs = [law.has_friction(), law.has_rolling_friction()];
        let [least, most] = SKIN_RANGE;
        let skin = self.scope.skin / parameters.radius;
        let numbers = self.built_at.iter().chain(&self.walls_at).flatten();
        let block_is_valid = |(number, block): (usize, &Block)| {
            block.start == number * BLOCK && block.is_valid(count, walls, has_springs)
        };
        self.blocks.len() == count.div_ceil(BLOCK)
            && self.blocks.iter().enumerate().all(block_is_valid)
            && self.built_at.len() == count
            && self.walls_at.len() == walls
            && numbers.into_iter().all(|number| number.is_finite())
            && (0.99 * least..=1.01 * most).contains(&skin)
            && (0.0..f64::INFINITY).contains(&self.scope.moved)
            && !self.scope.clearance.is_nan()
            && (1..=TIERS).contains(&self.scope.tiers)
            && self.held.is_none()
    }

    /// Notes a step in which no disc moved further than `displacement`, m; returns whether the lists are still valid.
    pub(super) fn is_valid_after(
        &mut self,
        displacement: f64,
        discs: &Discs,
        displacements: &[[f64; 2]],
    ) -> bool {
        self.age = self.age.saturating_add(1);
        let limit = 0.5 * self.scope.skin;
        let walls_hold = self.walls_at.iter().zip(displacements).all(|(then, now)| {
            let moved = [now[0] - then[0], now[1] - then[1]];
            moved[0] * moved[0] + moved[1] * moved[1] < limit * limit
        });
        self.scope.moved += displacement;
        self.scope.displacement += displacement;
        self.scope.tiers =
            Ord::max(self.scope.tiers, tiers::in_reach(self.scope.moved, self.scope.skin));
        if !walls_hold {
            return false;
        }
        if self.scope.moved < limit {
            return true;
        }
        // The sum over all steps is only a bound; now the true displacements are needed.
        self.scope.moved = discs::max_displacement(&self.built_at, &discs.positions);
        // Closer to the limit, the displacements would be needed at every step.
        self.scope.moved < 0.9 * limit
    }

    /// Chooses the skin of least cost, assuming that the discs continue to move as they did.
    ///
    /// With s the skin over the mean radius, phi the packing fraction around the discs and u = s/age the skin that motion uses up
    /// per step, a disc has phi ((2 + g)^2 - 4)/2 pairs with gaps up to g. They are compared while g grows from 0 to s: on
    /// average phi (s + s^2/6) comparisons per step. With u/s builds per step, the cost is least at s^2 (1 + s/3) = B u/phi; B is
    /// the cost of a build over that of a comparison.
    pub(super) fn adapt_skin(&mut self, mean_radius: f64) {
        let skin = self.scope.skin / mean_radius;
        let (pairs, inter_block) =
            self.blocks.iter().fold((0, 0), |(pairs, inter_block), block| {
                (pairs + block.inner.len(), inter_block + block.inter_block.len())
            });
        let neighbors = (2 * pairs + inter_block) as f64 / self.built_at.len() as f64;
        // Neighbors and the disc itself, over all discs that would fit within the reach.
        let fraction = (neighbors + 1.0) / ((2.0 + skin) * (2.0 + skin));
        let used = skin / f64::from(self.age);
        let wanted = BUILD_OVER_COMPARISON * used / fraction;
        // Newton's method from above, where the function is convex, descends to the root.
        let [least, most] = SKIN_RANGE;
        let mut best = most;
        for _ in 0..8 {
            best -= (best * best * (1.0 + best / 3.0) - wanted) / (best * (2.0 + best));
        }
        let best = if best > least { best } else { least };
        let best = if best < most { best } else { most };
        self.scope.skin = best * mean_radius;
    }

    /// Sorts the discs and rebuilds the lists; springs of persisting contacts are kept.
    pub(super) fn build(&mut self, discs: &mut Discs, around: &Surroundings<'_>) {
        let springs = self.held.take().unwrap_or_else(|| Springs::of(&self.blocks, discs));
        let springs = springs.finder();
        // Otherwise, old and new lists would be in memory at the same time.
        self.blocks.clear();
        let Parameters { sides, periodic, radius_range, ref law, .. } = *around.parameters;
        let reach = 2.0 * radius_range.1 + self.scope.skin;
        let (cells, order) = CellGrid::sort(&discs.positions, sides, reach, periodic, BLOCK);
        discs.reorder(&order);
        let count = discs.len().div_ceil(BLOCK);
        self.blocks.resize_with(count, Block::default);
        let skin = self.scope.skin;
        let discs = &*discs;
        self.blocks.par_iter_mut().enumerate().for_each(|(number, block)| {
            block.start = number * BLOCK;
            around.memory.fill(block, &PairSearch { discs, cells: &cells, around, skin });
            if law.has_friction() {
                springs.fill_block(block, discs, law.has_rolling_friction());
            }
        });
        self.built_at.clear();
        self.built_at.extend_from_slice(&discs.positions);
        self.walls_at.clear();
        self.walls_at.extend_from_slice(around.displacements);
        (self.scope.moved, self.scope.displacement) = (0.0, 0.0);
        self.scope.list += 1;
        let with_springs = self.blocks.iter().map(Block::tiers_with_springs).max().unwrap_or(0);
        self.scope.tiers = Ord::max(tiers::in_reach(0.0, skin), with_springs);
        self.scope.clearance = discs::clearance(&discs.positions, sides, periodic);
        self.age = 0;
    }

    /// The part of the lists that the next step must visit.
    pub(super) fn scope(&self) -> Scope {
        Scope { spares_memory: self.blocks.len() > MAX_BLOCKS_WITH_NEAR_PAIRS, ..self.scope }
    }

    /// Takes the springs out of the lists for the next build, because the discs are about to change.
    pub(super) fn hold_springs(&mut self, discs: &Discs) {
        self.held = Some(Springs::of(&self.blocks, discs));
    }
}
