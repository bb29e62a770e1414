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

#[cfg(test)]
mod lists_contain_every_contact {
    //! Guarantee: the lists contain every pair closer than contact plus the skin, each once with each of its discs, including images
    //! beyond periodic sides. While the lists are valid, they contain every contact, and so do the tiers in scope.
    //!
    //! Source: comparison of all pairs and images.
    //! Setup: random points in boxes of several shapes, from one disc to several blocks, with size ratios from 1 to 10; then discs are
    //! displaced by just under nine tenths of half the skin, where the lists expire.
    //! Tolerance: none, the sets are equal. Control: a disc beyond the limit invalidates the lists; tiers of lists that count no
    //! displacement miss contacts.

    use crate::dem::block::TIERS;
    use crate::dem::discs::Discs;
    use crate::dem::neighbors::Neighbors;
    use crate::dem::neighbors::pair_search::{SearchMemory, Surroundings};
    use crate::dem::parameters::Parameters;
    use crate::random::{Generator, Seed, Stream};
    use kinetoscope_manifest::model::DemConfig;
    use std::collections::BTreeSet;

    /// The initial skin over the mean radius.
    const SKIN: f64 = 0.5;

    /// Two ids, and the number of box lengths by which the second disc is shifted.
    type Pair = (u32, u32, [i8; 2]);

    /// Random discs with their lists.
    pub(super) struct Case {
        parameters: Parameters,
        pub(super) discs: Discs,
        pub(super) neighbors: Neighbors,
    }

    impl Case {
        pub(super) fn new(
            count: u32,
            config: &DemConfig,
            (sides, periodic): ([f64; 2], [bool; 2]),
            (least, most): (f64, f64),
            generator: &mut Generator,
            memory: &SearchMemory,
        ) -> Self {
            let radius_range = (least, most);
            let default = Parameters::new(config);
            let parameters = Parameters { sides, periodic, radius_range, ..default };
            let mut place =
                || [generator.uniform_in(0.0, sides[0]), generator.uniform_in(0.0, sides[1])];
            let positions: Vec<[f64; 2]> = (0..count).map(|_| place()).collect();
            let discs = Discs::at_rest(positions, || generator.uniform_in(least, most));
            let neighbors = Neighbors::new(0.5 * (least + most));
            let mut case = Self { parameters, discs, neighbors };
            case.build(memory);
            case
        }

        pub(super) fn build(&mut self, memory: &SearchMemory) {
            let parameters = &self.parameters;
            let around = Surroundings { parameters, walls: &[], displacements: &[], memory };
            self.neighbors.build(&mut self.discs, &around);
        }

        /// Displaces each disc by just under a distance, in m, in a random direction.
        fn displace(&mut self, distance: f64, generator: &mut Generator) {
            for [x, y] in &mut self.discs.positions {
                let angle = generator.uniform_in(0.0, std::f64::consts::TAU);
                *x += 0.999 * distance * libm::cos(angle);
                *y += 0.999 * distance * libm::sin(angle);
            }
        }

        fn skin(&self) -> f64 {
            let (least, most) = self.parameters.radius_range;
            SKIN * 0.5 * (least + most)
        }

        /// The pairs in the first tiers of the lists, seen from either disc, and their number with repetitions.
        fn listed_in(&self, tiers: usize) -> (BTreeSet<Pair>, usize) {
            let ids = &self.discs.ids;
            let mut pairs = Vec::new();
            for block in &self.neighbors.blocks {
                let ends = block.inner.first.iter().zip(&block.inner.second);
                for (&a, &b) in ends.take(block.inner.in_tiers(tiers)) {
                    let [a, b] = [a, b].map(|disc| ids[block.start + usize::from(disc)]);
                    pairs.extend([(a, b, [0, 0]), (b, a, [0, 0])]);
                }
                let ends = block.inter_block.first.iter().zip(&block.inter_block.second);
                let ends = ends.zip(&block.shifts).take(block.inter_block.in_tiers(tiers));
                for ((&a, &b), shift) in ends {
                    let turns =
                        [0, 1].map(|axis: usize| (shift[axis] / self.parameters.sides[axis]) as i8);
                    pairs.push((ids[block.start + usize::from(a)], ids[b as usize], turns));
                }
            }
            let count = pairs.len();
            (pairs.into_iter().collect(), count)
        }

        /// All pairs closer than contact plus a margin, seen from either disc.
        fn all(&self, margin: f64) -> BTreeSet<Pair> {
            let mut pairs = BTreeSet::new();
            let turns = |axis: usize| if self.parameters.periodic[axis] { -1..=1 } else { 0..=0 };
            for turn in turns(0).flat_map(|x| turns(1).map(move |y| [x, y])) {
                let shift =
                    [0, 1].map(|axis: usize| f64::from(turn[axis]) * self.parameters.sides[axis]);
                for (a, &[x, y]) in self.discs.positions.iter().enumerate() {
                    for (b, &[other_x, other_y]) in self.discs.positions.iter().enumerate() {
                        let apart = [x - (other_x + shift[0]), y - (other_y + shift[1])];
                        let reach = self.discs.radii[a] + self.discs.radii[b] + margin;
                        if a != b && apart[0] * apart[0] + apart[1] * apart[1] < reach * reach {
                            pairs.insert((self.discs.ids[a], self.discs.ids[b], turn));
                        }
                    }
                }
            }
            pairs
        }
    }

    fn cases() -> Vec<Case> {
        let config = &DemConfig::default();
        let mut generator = Seed { seed: 3, replicate: 0 }.stream(Stream::Positions);
        // The memory of one search must not affect the next one.
        let memory = SearchMemory::default();
        let mut cases = Vec::new();
        for (sides, radii) in
            [([10.0, 10.0], (0.05, 0.05)), ([40.0, 3.0], (0.02, 0.2)), ([2.0, 30.0], (0.05, 0.3))]
        {
            for periodic in [[false, false], [true, false], [false, true], [true, true]] {
                for count in [1, 2, 30, 300] {
                    let space = (sides, periodic);
                    cases.push(Case::new(count, config, space, radii, &mut generator, &memory));
                }
            }
        }
        // Several blocks and bands.
        for periodic in [[false, false], [true, true]] {
            let (space, radii) = (([12.0, 12.0], periodic), (0.05, 0.05));
            cases.push(Case::new(6000, config, space, radii, &mut generator, &memory));
        }
        cases
    }

    #[test]
    fn lists_equal_all_pairs_within_the_skin() {
        let mut pairs = 0;
        for case in cases() {
            let (listed, count) = case.listed_in(TIERS);
            assert_eq!(listed.len(), count, "a pair is listed twice");
            let (discs, sides) = (case.discs.len(), case.parameters.sides);
            assert!(listed == case.all(case.skin()), "{discs} in {sides:?}");
            pairs += count;
        }
        // Seen from either disc.
        assert!(pairs > 20_000, "{pairs}");
    }

    #[test]
    fn valid_lists_contain_every_contact() {
        let mut generator = Seed { seed: 4, replicate: 0 }.stream(Stream::Positions);
        for mut case in cases().into_iter().filter(|case| case.discs.len() == 300) {
            let (listed, _) = case.listed_in(TIERS);
            let limit = 0.5 * 0.9 * case.skin();
            case.displace(limit, &mut generator);
            // So long that the true displacements are needed.
            let displacement = case.skin();
            assert!(case.neighbors.is_valid_after(displacement, &case.discs, &[]));
            assert!(case.all(0.0).is_subset(&listed), "a contact is not listed");
            // Control: one disc beyond the limit.
            case.discs.positions[7][0] += 2.0 * limit;
            assert!(!case.neighbors.is_valid_after(displacement, &case.discs, &[]));
        }
    }

    #[test]
    fn tiers_in_scope_contain_every_contact() {
        let mut generator = Seed { seed: 5, replicate: 0 }.stream(Stream::Positions);
        let (mut visited, mut listed, mut missing) = (0, 0, 0);
        for mut case in cases().into_iter().filter(|case| case.discs.len() == 300) {
            // Two discs that approach use up a gap of six tenths of the skin.
            let displacement = 0.3 * case.skin();
            case.displace(displacement, &mut generator);
            let contacts = case.all(0.0);
            // Control: the tiers in scope before any displacement do not contain them all.
            missing += contacts.difference(&case.listed_in(case.neighbors.scope().tiers).0).count();
            assert!(case.neighbors.is_valid_after(displacement, &case.discs, &[]));
            let (tiers, count) = case.listed_in(case.neighbors.scope().tiers);
            assert!(contacts.is_subset(&tiers), "a contact is not visited");
            visited += count;
            listed += case.listed_in(TIERS).1;
        }
        assert!(missing > 50, "{missing}");
        assert!(visited < listed, "{visited} of {listed}");
    }
}
