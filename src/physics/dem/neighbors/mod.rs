//! Which discs may touch: half lists with a skin, in blocks of discs that lie side by side in memory.
//!
//! Discs are sorted by cell when the list is built. A block's pairs are listed once; a pair of two blocks, or one across a
//! periodic side, is listed with each of its discs, so that a block writes the forces on its own discs alone. The blocks
//! follow from the number of discs, and sums within a block run in the list's order: no thread can change them.
//!
//! The list holds every pair closer than touching plus the skin, and stays good until a disc or a wall has moved by half the
//! skin. Until then a step looks at a part of it alone: see `tiers`. The order of the discs is part of the sums' bits, so the list belongs to the state.

pub(super) mod cell_grid;
#[cfg(test)]
mod contact_history_survives_list_rebuild;
#[cfg(test)]
mod list_contains_every_contact;
pub(super) mod near_pairs;
pub(super) mod pair_buffer;
pub(super) mod pair_search;
pub(super) mod positions;
pub(super) mod springs;
pub(super) mod tiers;

use crate::dem::discs::Discs;
use crate::dem::forces::contact::ContactLaw;
use crate::dem::neighbors::cell_grid::{Cells, Periodic};
use crate::dem::neighbors::pair_search::{Finders, Grid};
use crate::dem::neighbors::springs::{Springs, Stretch};
use crate::dem::neighbors::tiers::TIERS;
use crate::dem::walls::PlacedWall;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Discs a block: small enough that its lists stay in the cache, large enough that few pairs belong to two blocks.
pub(super) const BLOCK: usize = 2500;

/// Pairs of a block with what does not change between two builds, column by column.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Pairs {
    /// A disc of the block, counted from its first.
    pub(super) first: Vec<u32>,
    /// The other: counted from the block's first for inner pairs, from the first of all for edges.
    pub(super) second: Vec<u32>,
    /// r_i + r_j, m.
    pub(super) reach: Vec<f64>,
    /// eta of the pair, N s/m.
    pub(super) damping: Vec<f64>,
    /// Stretch of the tangential springs, m; empty without friction.
    pub(super) stretch: Vec<f64>,
    /// Stretch of the rolling springs, m; empty without rolling friction.
    pub(super) rolling_stretch: Vec<f64>,
    /// Where each tier ends.
    pub(super) ends: [u32; TIERS],
}

/// A disc that may touch a wall.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct WallPair {
    /// The disc, counted from the block's first.
    pub(super) disc: u32,
    pub(super) wall: u32,
    /// eta of the contact, N s/m.
    pub(super) damping: f64,
    pub(super) stretch: Stretch,
}

/// The discs of a block, and whom they may touch.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Block {
    /// Where its discs begin.
    pub(super) start: usize,
    /// Pairs of which both discs are the block's.
    pub(super) inner: Pairs,
    /// Pairs of which the first disc is the block's; the force on the other is found elsewhere.
    pub(super) edges: Pairs,
    /// What is added to the second disc's center, m, for each edge.
    pub(super) shifts: Vec<[f64; 2]>,
    /// Discs near walls.
    pub(super) walls: Vec<WallPair>,
}

/// The list, and how far it can be trusted.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Neighbors {
    pub(super) blocks: Vec<Block>,
    /// Centers when the list was built.
    built_at: Vec<[f64; 2]>,
    /// Walls' displacements then.
    walls_at: Vec<[f64; 2]>,
    /// Bound of the largest displacement since.
    moved: f64,
    /// Sum of the ways of the fastest disc of each step since, m.
    #[serde(skip)]
    way: f64,
    /// How many lists there were before this one.
    #[serde(skip)]
    number: u64,
    /// Tiers that have pairs which may touch, or may have touched since.
    tiers: usize,
    /// Distance of the nearest center to a closed side of the box when the list was built, m.
    clearance: f64,
    /// How far it reaches beyond touching, m.
    skin: f64,
    /// Steps since it was built.
    age: u32,
    /// Springs taken out of the lists while discs are removed; empty at all other times.
    held: Option<Springs>,
}

/// How much of the lists and of the box a step must look at.
#[derive(Clone, Copy, Debug)]
pub(super) struct Scope {
    /// Tiers that have pairs which may touch.
    pub(super) tiers: usize,
    /// Bound of the way of any disc since the lists were built, m.
    pub(super) moved: f64,
    /// What any disc may have moved and still be inside the box, m.
    pub(super) clearance: f64,
    /// Sum of the ways of the fastest disc of each step since, m.
    pub(super) way: f64,
    /// The number of the lists.
    pub(super) list: u64,
    /// How far they reach beyond touching, m.
    pub(super) skin: f64,
    /// Whether there are so many discs that lists beside these would take too much memory.
    pub(super) spares_memory: bool,
}

impl Scope {
    /// Tiers that have pairs which may touch before the fastest discs have come a way, in m.
    pub(super) fn tiers_within(&self, way: f64) -> usize {
        if self.tiers == TIERS {
            return TIERS;
        }
        Ord::max(self.tiers, tiers::in_reach(self.moved + way, self.skin))
    }
}

/// What the list is built from, besides the discs.
pub(super) struct Surroundings<'a> {
    pub(super) sides: [f64; 2],
    pub(super) periodic: Periodic,
    pub(super) law: &'a ContactLaw,
    pub(super) walls: &'a [PlacedWall],
    /// Displacements of the walls since the start, m.
    pub(super) displacements: &'a [[f64; 2]],
    /// Largest radius, m.
    pub(super) largest_radius: f64,
    /// Memory.
    pub(super) finders: &'a Finders,
}

/// The skin's range over the mean radius, and where it begins.
const SKIN_RANGE: [f64; 2] = [0.1, 2.0];
const FIRST_SKIN: f64 = 0.5;
/// What it costs to build the list anew for a disc, over a look at a pair that does not touch.
const BUILD_OVER_LOOK: f64 = 40.0;

/// Near pairs are kept in runs of up to so many blocks. In larger ones every byte a disc counts: there they took 40, and a gas
/// of 10^4 discs was slower by 1.18 without.
const MOST_BLOCKS_WITH_NEAR_PAIRS: usize = 80;

impl Neighbors {
    /// An empty list with the skin to begin with.
    pub(super) fn new(mean_radius: f64) -> Self {
        Self { skin: FIRST_SKIN * mean_radius, ..Self::default() }
    }

    /// Takes note of a step in which no disc moved further than `way`, and says whether the list is still good.
    pub(super) fn is_good_after(
        &mut self,
        way: f64,
        discs: &Discs,
        displacements: &[[f64; 2]],
    ) -> bool {
        self.age = self.age.saturating_add(1);
        let limit = 0.5 * self.skin;
        let walls_hold = self.walls_at.iter().zip(displacements).all(|(then, now)| {
            let way = [now[0] - then[0], now[1] - then[1]];
            way[0] * way[0] + way[1] * way[1] < limit * limit
        });
        self.moved += way;
        self.way += way;
        self.tiers = Ord::max(self.tiers, tiers::in_reach(self.moved, self.skin));
        if !walls_hold {
            return false;
        }
        if self.moved < limit {
            return true;
        }
        // The sum of each step's fastest disc is a bound; now the true displacements are needed.
        self.moved = positions::longest_way(&self.built_at, &discs.positions);
        // Closer to the limit, the displacements would be asked for at every step.
        self.moved < 0.9 * limit
    }

    /// Chooses the skin that costs least, if the discs go on moving as they did.
    ///
    /// With s the skin over the mean radius, phi the packing fraction around the discs and u = s/age what motion uses up in a
    /// step, a disc has phi ((2 + g)^2 - 4)/2 pairs with gaps up to g. They are looked at while g grows from 0 to s: on the
    /// average phi (s + s^2/6) looks a step. With u/s builds a step the cost is least where s^2 (1 + s/3) = B u/phi, B being
    /// the cost of a build over that of a look.
    pub(super) fn adapt_skin(&mut self, mean_radius: f64) {
        let skin = self.skin / mean_radius;
        let (pairs, edges) = self.blocks.iter().fold((0, 0), |(pairs, edges), block| {
            (pairs + block.inner.len(), edges + block.edges.len())
        });
        let neighbors = (2 * pairs + edges) as f64 / self.built_at.len() as f64;
        // Neighbors and the disc itself, over all that have room within the reach.
        let fraction = (neighbors + 1.0) / ((2.0 + skin) * (2.0 + skin));
        let used = skin / f64::from(self.age);
        let wanted = BUILD_OVER_LOOK * used / fraction;
        // Newton's steps from above, where the function is convex, come down to the root.
        let [least, most] = SKIN_RANGE;
        let mut best = most;
        for _ in 0..8 {
            best -= (best * best * (1.0 + best / 3.0) - wanted) / (best * (2.0 + best));
        }
        let best = if best > least { best } else { least };
        let best = if best < most { best } else { most };
        self.skin = best * mean_radius;
    }

    /// Sorts the discs and lists their pairs anew; springs of contacts that go on are kept.
    pub(super) fn build(&mut self, discs: &mut Discs, around: &Surroundings<'_>) {
        let springs = match self.held.take() {
            Some(springs) => springs,
            None => self.springs(discs),
        };
        let springs = springs.finder();
        // Old lists would stand beside the new ones, and new ones in the gaps of the old.
        self.blocks.clear();
        let reach = 2.0 * around.largest_radius + self.skin;
        let (cells, order) =
            Cells::sort(&discs.positions, around.sides, reach, around.periodic, BLOCK);
        discs.reorder(&order);
        let count = discs.len().div_ceil(BLOCK);
        self.blocks.resize_with(count, Block::default);
        let skin = self.skin;
        let discs = &*discs;
        let blocks = self.blocks.par_iter_mut().enumerate();
        blocks.for_each_init(
            || around.finders.search(),
            |search, (number, block)| {
                block.start = number * BLOCK;
                search.fill(block, &Grid { discs, cells: &cells, around, skin });
                if around.law.has_friction() {
                    springs.hand_on(block, discs, around.law.has_rolling_friction());
                }
            },
        );
        self.built_at.clear();
        self.built_at.extend_from_slice(&discs.positions);
        self.walls_at.clear();
        self.walls_at.extend_from_slice(around.displacements);
        (self.moved, self.way) = (0.0, 0.0);
        self.number += 1;
        let with_springs = self.blocks.iter().map(Block::tiers_with_springs).max().unwrap_or(0);
        self.tiers = Ord::max(tiers::in_reach(0.0, skin), with_springs);
        self.clearance = positions::clearance(&discs.positions, around.sides, around.periodic);
        self.age = 0;
    }

    /// What a step need not look at.
    pub(super) fn scope(&self) -> Scope {
        let Self { tiers, moved, clearance, way, number: list, skin, .. } = *self;
        let spares_memory = self.blocks.len() > MOST_BLOCKS_WITH_NEAR_PAIRS;
        Scope { tiers, moved, clearance, way, list, skin, spares_memory }
    }

    /// Keeps springs for the next build: the lists no longer fit the discs.
    pub(super) fn hold(&mut self, springs: Springs) {
        self.held = Some(springs);
    }

    /// Every spring that is stretched.
    pub(super) fn springs(&self, discs: &Discs) -> Springs {
        Springs::of(&self.blocks, discs)
    }
}

impl Pairs {
    /// Number of pairs.
    pub(super) fn len(&self) -> usize {
        self.first.len()
    }

    /// Stretches of a pair's springs; zero where it has none.
    pub(super) fn stretch_of(&self, pair: usize) -> Stretch {
        let of = |column: &[f64]| column.get(pair).copied().unwrap_or(0.0);
        [of(&self.stretch), of(&self.rolling_stretch)]
    }

    /// Sets the stretches of those springs that a pair has.
    pub(super) fn set_stretch(&mut self, pair: usize, [sliding, rolling]: Stretch) {
        for (column, value) in [(&mut self.stretch, sliding), (&mut self.rolling_stretch, rolling)]
        {
            if let Some(stretch) = column.get_mut(pair) {
                *stretch = value;
            }
        }
    }

    /// Makes it so many pairs in tiers with these ends; their ends, reach and damping are to be written, and springs handed on.
    pub(super) fn resize(&mut self, pairs: usize, ends: [u32; TIERS]) {
        /// What was written before may stay.
        fn sized<T: Copy + Default>(column: &mut Vec<T>, pairs: usize) {
            if column.capacity() < pairs {
                *column = Vec::with_capacity(pairs);
            }
            column.resize(pairs, T::default());
        }
        sized(&mut self.first, pairs);
        sized(&mut self.second, pairs);
        sized(&mut self.reach, pairs);
        sized(&mut self.damping, pairs);
        self.stretch.clear();
        self.rolling_stretch.clear();
        self.ends = ends;
    }

    /// How many tiers, from the first, have stretched springs: one that was let go by a fast pair is looked at once more.
    fn tiers_with_springs(&self) -> usize {
        let columns = [&self.stretch, &self.rolling_stretch];
        let last = columns.map(|column| column.iter().rposition(|&stretch| stretch != 0.0));
        let count = last.into_iter().flatten().max().map_or(0, |last| last as u32 + 1);
        self.ends.partition_point(|&end| end < count) + usize::from(count > 0)
    }

    /// How many pairs, from the first, stand in the first few tiers.
    pub(super) fn in_tiers(&self, tiers: usize) -> usize {
        Ord::min(self.ends[tiers - 1] as usize, self.len())
    }
}

impl Block {
    /// The two discs of an edge, counted from the first of all.
    pub(super) fn edge(&self, edge: usize) -> [usize; 2] {
        [self.start + self.edges.first[edge] as usize, self.edges.second[edge] as usize]
    }

    fn tiers_with_springs(&self) -> usize {
        Ord::max(self.inner.tiers_with_springs(), self.edges.tiers_with_springs())
    }

    /// The number of its discs.
    pub(super) fn len(&self, discs: &Discs) -> usize {
        Ord::min(BLOCK, discs.len() - self.start)
    }
}
