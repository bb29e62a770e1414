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

struct Case {
    sides: [f64; 2],
    periodic: [bool; 2],
    radii: [f64; 2],
    discs: Discs,
    neighbors: Neighbors,
}

impl Case {
    fn new(
        count: u32,
        sides: [f64; 2],
        periodic: [bool; 2],
        radii: [f64; 2],
        generator: &mut Generator,
        memory: &SearchMemory,
    ) -> Self {
        let mut place =
            || [generator.uniform_in(0.0, sides[0]), generator.uniform_in(0.0, sides[1])];
        let positions: Vec<[f64; 2]> = (0..count).map(|_| place()).collect();
        let length = positions.len();
        let discs = Discs {
            ids: (0..count).collect(),
            positions,
            velocities: vec![[0.0; 2]; length],
            spins: vec![0.0; length],
            radii: (0..count).map(|_| generator.uniform_in(radii[0], radii[1])).collect(),
            masses: vec![1.0; length],
            inverse_masses: vec![1.0; length],
            materials: vec![0; length],
        };
        let neighbors = Neighbors::new(0.5 * (radii[0] + radii[1]));
        let mut case = Self { sides, periodic, radii, discs, neighbors };
        case.build(memory);
        case
    }

    fn build(&mut self, memory: &SearchMemory) {
        let around = Surroundings {
            sides: self.sides,
            periodic: self.periodic,
            law: &Parameters::new(&DemConfig::default()).law,
            walls: &[],
            displacements: &[],
            largest_radius: self.radii[1],
            memory,
        };
        self.neighbors.build(&mut self.discs, &around);
    }

    fn skin(&self) -> f64 {
        SKIN * 0.5 * (self.radii[0] + self.radii[1])
    }

    /// The listed pairs, seen from either disc, and their number with repetitions.
    fn listed(&self) -> (BTreeSet<Pair>, usize) {
        self.listed_in(TIERS)
    }

    /// The same for the first `tiers` tiers.
    fn listed_in(&self, tiers: usize) -> (BTreeSet<Pair>, usize) {
        let ids = &self.discs.ids;
        let mut pairs = Vec::new();
        for block in &self.neighbors.blocks {
            let ends = block.inner.first.iter().zip(&block.inner.second);
            for (&a, &b) in ends.take(block.inner.in_tiers(tiers)) {
                let [a, b] = [a, b].map(|disc| ids[block.start + disc as usize]);
                pairs.extend([(a, b, [0, 0]), (b, a, [0, 0])]);
            }
            let ends = block.edges.first.iter().zip(&block.edges.second);
            let ends = ends.zip(&block.shifts).take(block.edges.in_tiers(tiers));
            for ((&a, &b), shift) in ends {
                let turns = [0, 1].map(|axis: usize| (shift[axis] / self.sides[axis]) as i8);
                pairs.push((ids[block.start + a as usize], ids[b as usize], turns));
            }
        }
        let count = pairs.len();
        (pairs.into_iter().collect(), count)
    }

    /// All pairs closer than contact plus a margin, seen from either disc.
    fn all(&self, margin: f64) -> BTreeSet<Pair> {
        let mut pairs = BTreeSet::new();
        let turns = |axis: usize| if self.periodic[axis] { -1..=1 } else { 0..=0 };
        for turn in turns(0).flat_map(|x| turns(1).map(move |y| [x, y])) {
            let shift = [0, 1].map(|axis: usize| f64::from(turn[axis]) * self.sides[axis]);
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
    let mut generator = Seed { seed: 3, replicate: 0 }.stream(Stream::Positions);
    // The memory of one search must not affect the next one.
    let memory = SearchMemory::default();
    let mut cases = Vec::new();
    for (sides, radii) in
        [([10.0, 10.0], [0.05, 0.05]), ([40.0, 3.0], [0.02, 0.2]), ([2.0, 30.0], [0.05, 0.3])]
    {
        for periodic in [[false, false], [true, false], [false, true], [true, true]] {
            for count in [1, 2, 30, 300] {
                cases.push(Case::new(count, sides, periodic, radii, &mut generator, &memory));
            }
        }
    }
    // Several blocks and bands.
    for periodic in [[false, false], [true, true]] {
        cases.push(Case::new(6000, [12.0, 12.0], periodic, [0.05, 0.05], &mut generator, &memory));
    }
    cases
}

#[test]
fn lists_equal_all_pairs_within_the_skin() {
    let mut pairs = 0;
    for case in cases() {
        let (listed, count) = case.listed();
        assert_eq!(listed.len(), count, "a pair is listed twice");
        assert!(listed == case.all(case.skin()), "{:?} in {:?}", case.discs.len(), case.sides);
        pairs += count;
    }
    // Seen from either disc.
    assert!(pairs > 20_000, "{pairs}");
}

#[test]
fn valid_lists_contain_every_contact() {
    let mut generator = Seed { seed: 4, replicate: 0 }.stream(Stream::Positions);
    for mut case in cases().into_iter().filter(|case| case.discs.len() == 300) {
        let (listed, _) = case.listed();
        let limit = 0.5 * 0.9 * case.skin();
        for [x, y] in &mut case.discs.positions {
            let angle = generator.uniform_in(0.0, std::f64::consts::TAU);
            *x += 0.999 * limit * libm::cos(angle);
            *y += 0.999 * limit * libm::sin(angle);
        }
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
        for [x, y] in &mut case.discs.positions {
            let angle = generator.uniform_in(0.0, std::f64::consts::TAU);
            *x += 0.999 * displacement * libm::cos(angle);
            *y += 0.999 * displacement * libm::sin(angle);
        }
        let contacts = case.all(0.0);
        // Control: the tiers in scope before any displacement do not contain them all.
        missing += contacts.difference(&case.listed_in(case.neighbors.scope().tiers).0).count();
        assert!(case.neighbors.is_valid_after(displacement, &case.discs, &[]));
        let (tiers, count) = case.listed_in(case.neighbors.scope().tiers);
        assert!(contacts.is_subset(&tiers), "a contact is not visited");
        visited += count;
        listed += case.listed().1;
    }
    assert!(missing > 50, "{missing}");
    assert!(visited < listed, "{visited} of {listed}");
}
