//! Law: the list holds every pair closer than touching plus the skin, each once with each of its discs, images beyond
//! periodic sides too; until it says that it is no longer good, it holds every pair that touches, and so do the tiers of
//! it that are looked at.
//!
//! Source: all pairs and images, one by one.
//! Setup: random points in boxes of several shapes, from one disc to several blocks, with radii from equal to one in ten;
//! then moved by just under nine tenths of half the skin, where the list is built anew.
//! Tolerance: none, the sets are equal.

use crate::dem::discs::Discs;
use crate::dem::neighbors::pair_search::Finders;
use crate::dem::neighbors::tiers::TIERS;
use crate::dem::neighbors::{Neighbors, Surroundings};
use crate::dem::parameters::Parameters;
use crate::random::{Generator, Seed, Stream};
use kinetoscope_manifest::model::DemConfig;
use std::collections::BTreeSet;

/// A list begins with a skin of so many mean radii.
const SKIN: f64 = 0.5;

/// Two ids, and by how many box lengths the second is shifted.
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
        finders: &Finders,
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
        case.build(finders);
        case
    }

    fn build(&mut self, finders: &Finders) {
        let around = Surroundings {
            sides: self.sides,
            periodic: self.periodic,
            law: &Parameters::new(&DemConfig::default()).law,
            walls: &[],
            displacements: &[],
            largest_radius: self.radii[1],
            finders,
        };
        self.neighbors.build(&mut self.discs, &around);
    }

    fn skin(&self) -> f64 {
        SKIN * 0.5 * (self.radii[0] + self.radii[1])
    }

    /// What is listed, from either side; and how often.
    fn listed(&self) -> (BTreeSet<Pair>, usize) {
        self.listed_in(TIERS)
    }

    /// The same of the first few tiers.
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

    /// All pairs closer than touching plus a margin, from either side.
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
    // What is kept of one search must not show in the next.
    let finders = Finders::default();
    let mut cases = Vec::new();
    for (sides, radii) in
        [([10.0, 10.0], [0.05, 0.05]), ([40.0, 3.0], [0.02, 0.2]), ([2.0, 30.0], [0.05, 0.3])]
    {
        for periodic in [[false, false], [true, false], [false, true], [true, true]] {
            for count in [1, 2, 30, 300] {
                cases.push(Case::new(count, sides, periodic, radii, &mut generator, &finders));
            }
        }
    }
    // Several blocks and bands.
    for periodic in [[false, false], [true, true]] {
        cases.push(Case::new(6000, [12.0, 12.0], periodic, [0.05, 0.05], &mut generator, &finders));
    }
    cases
}

#[test]
fn the_list_is_that_of_all_pairs() {
    let mut pairs = 0;
    for case in cases() {
        let (listed, count) = case.listed();
        assert_eq!(listed.len(), count, "a pair is listed twice");
        assert!(listed == case.all(case.skin()), "{:?} in {:?}", case.discs.len(), case.sides);
        pairs += count;
    }
    // Seen from either side.
    assert!(pairs > 20_000, "{pairs}");
}

#[test]
fn the_list_holds_all_that_touch_until_it_says_no() {
    let mut generator = Seed { seed: 4, replicate: 0 }.stream(Stream::Positions);
    for mut case in cases().into_iter().filter(|case| case.discs.len() == 300) {
        let (listed, _) = case.listed();
        let limit = 0.5 * 0.9 * case.skin();
        for [x, y] in &mut case.discs.positions {
            let angle = generator.uniform_in(0.0, std::f64::consts::TAU);
            *x += 0.999 * limit * libm::cos(angle);
            *y += 0.999 * limit * libm::sin(angle);
        }
        // So long a way that the true displacements are asked for.
        let way = case.skin();
        assert!(case.neighbors.is_good_after(way, &case.discs, &[]));
        assert!(case.all(0.0).is_subset(&listed), "a pair that touches is not listed");
        // Control: one disc beyond the limit.
        case.discs.positions[7][0] += 2.0 * limit;
        assert!(!case.neighbors.is_good_after(way, &case.discs, &[]));
    }
}

#[test]
fn the_tiers_in_scope_hold_all_that_touch() {
    let mut generator = Seed { seed: 5, replicate: 0 }.stream(Stream::Positions);
    let (mut looked_at, mut listed, mut missing) = (0, 0, 0);
    for mut case in cases().into_iter().filter(|case| case.discs.len() == 300) {
        // Two discs that approach use up a gap of six tenths of the skin.
        let way = 0.3 * case.skin();
        for [x, y] in &mut case.discs.positions {
            let angle = generator.uniform_in(0.0, std::f64::consts::TAU);
            *x += 0.999 * way * libm::cos(angle);
            *y += 0.999 * way * libm::sin(angle);
        }
        let touching = case.all(0.0);
        // Control: the tiers of a list that nothing has moved since do not hold them all.
        missing += touching.difference(&case.listed_in(case.neighbors.scope().tiers).0).count();
        assert!(case.neighbors.is_good_after(way, &case.discs, &[]));
        let (tiers, count) = case.listed_in(case.neighbors.scope().tiers);
        assert!(touching.is_subset(&tiers), "a pair that touches is not looked at");
        looked_at += count;
        listed += case.listed().1;
    }
    assert!(missing > 50, "{missing}");
    assert!(looked_at < listed, "{looked_at} of {listed}");
}
