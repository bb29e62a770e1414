//! Guarantee: contact forces, springs and energies are bitwise identical for registers of one, four and eight numbers: without
//! friction, with rolling friction or without, for one material or several, with the force's attractive tail or without.
//!
//! Setup: 1003 pairs of 60 discs that overlap, touch or are apart, with stretched springs and random velocities and spins; some
//! pairs do not fill a register. The sum of the recorded contacts' forces is compared as well: reported forces are those that move
//! the discs.
//! Tolerance: none. Control: velocities that are larger by one part in 10^15 are noticed.

use super::kernel::{FrictionEnergies, PairContext, PairSums};
use super::pair_loops::{self, NearMemory};
use crate::dem::block::{BlockView, Pairs, TIERS};
use crate::dem::materials::ContactLaw;
use crate::dem::neighbors::near_pairs::{ContactNumbers, NearPairs};
use crate::dem::neighbors::tiers::Scope;
use crate::dem::parameters::Parameters;
use crate::dem::totals::{Contact, ContactMask, MaxOverlap, Partner};
use crate::random::{Generator, Seed, Stream};
use kinetoscope_manifest::model::{DemConfig, DemContactConstants, DemMaterial};
use kinetoscope_manifest::quantity::{Fraction, NonNegative, Positive};

const DISCS: u32 = 60;
const PAIRS: usize = 1003;
const RADIUS: f64 = 5e-4;

struct Sample {
    law: ContactLaw,
    positions: Vec<[f64; 2]>,
    velocities: Vec<[f64; 2]>,
    spins: Vec<f64>,
    radii: Vec<f64>,
    materials: Vec<u8>,
    pairs: Pairs,
}

/// The bits of all results.
#[derive(PartialEq)]
struct Outcome {
    sums: Vec<u64>,
    springs: Vec<u64>,
    energies: FrictionEnergies,
    max_overlap: u64,
}

fn law(rolls: bool, differ: bool, limit_damping: bool, friction: f64) -> ContactLaw {
    let coefficient = |value: f64| NonNegative::new(value).expect("not negative");
    let material = |name: &str, friction: f64| DemMaterial {
        name: name.to_owned(),
        fraction: Positive::new(1.0).expect("above zero"),
        density_ratio: Positive::new(1.0).expect("above zero"),
        constants: DemContactConstants {
            restitution: Fraction::new(0.8),
            friction: Some(coefficient(friction)),
            rolling_friction: None,
        },
    };
    let config = DemConfig {
        friction: coefficient(friction),
        rolling_friction: coefficient(if rolls { 0.1 } else { 0.0 }),
        materials: if differ { vec![material("a", 0.3), material("b", 0.0)] } else { vec![] },
        limit_damping,
        ..DemConfig::default()
    };
    Parameters::new(&config).law
}

/// The sums of the recorded contacts' forces on the discs.
fn sums_of(contacts: &[Contact], count: usize) -> Vec<[f64; 2]> {
    let mut sums = vec![[0.0; 2]; count];
    for Contact { disc, partner, force: [fx, fy], .. } in contacts {
        let Partner::Disc(partner) = *partner else { unreachable!("there are no walls") };
        let [x, y] = &mut sums[*disc as usize];
        (*x, *y) = (*x + fx, *y + fy);
        let [x, y] = &mut sums[partner as usize];
        (*x, *y) = (*x - fx, *y - fy);
    }
    sums
}

impl Sample {
    fn new(law: ContactLaw, generator: &mut Generator) -> Self {
        let rolls = law.has_rolling_friction();
        let side = 1.5 * RADIUS;
        let mut within = |most: f64| generator.uniform_in(-most, most);
        let positions = (0..DISCS).map(|_| [within(side), within(side)]).collect();
        let velocities = (0..DISCS).map(|_| [within(0.02), within(0.02)]).collect();
        let spins = (0..DISCS).map(|_| within(20.0)).collect();
        let radii: Vec<f64> = (0..DISCS).map(|_| RADIUS + within(0.1 * RADIUS)).collect();
        let several = law.materials.only().is_none();
        let materials = (0..DISCS).map(|_| u8::from(several && within(1.0) > 0.0)).collect();
        let mut pairs = Pairs::default();
        while pairs.len() < PAIRS {
            let [a, b] = [0; 2].map(|_: u32| ((0.5 + within(0.5)) * f64::from(DISCS)) as u32);
            if a == b {
                continue;
            }
            pairs.first.push(a);
            pairs.second.push(b);
            pairs.reach.push(radii[a as usize] + radii[b as usize]);
            pairs.damping.push(0.5 + within(0.2));
            pairs.stretch.push(if within(1.0) > 0.0 { within(0.1 * RADIUS) } else { 0.0 });
            if rolls {
                pairs.rolling_stretch.push(within(0.1 * RADIUS));
            }
        }
        pairs.ends = [PAIRS as u32; TIERS];
        Self { law, positions, velocities, spins, radii, materials, pairs }
    }

    fn outcome(&self, max_width: usize) -> Outcome {
        let count = self.positions.len();
        let (mut forces, mut tangential) = (vec![[0.0; 4]; count], vec![[0.0; 2]; count]);
        let (mut rolling, mut max_overlap) = (vec![0.0; count], MaxOverlap::new(0.0, 0.0, 0));
        let rim_speeds: Vec<f64> = self.radii.iter().zip(&self.spins).map(|(r, w)| r * w).collect();
        let discs = BlockView {
            start: 0,
            positions: &self.positions,
            velocities: &self.velocities,
            spins: &self.spins,
            radii: &self.radii,
            materials: &self.materials,
        };
        let (law, rim_speeds) = (&self.law, rim_speeds.as_slice());
        let context = PairContext { law, time_step: 1e-6, discs, rim_speeds, max_width };
        let mut sums = PairSums {
            forces: &mut forces,
            tangential: &mut tangential,
            rolling: &mut rolling,
            max_overlap: &mut max_overlap,
        };
        let mut pairs = self.pairs.clone();
        let mut contacts = Vec::new();
        let energies = if law.has_friction() {
            pair_loops::add_with_friction(&context, &mut pairs, PAIRS, &mut sums, &mut contacts)
        } else {
            let scope = Scope {
                tiers: TIERS,
                moved: 0.0,
                clearance: 0.0,
                displacement: 0.0,
                list: 1,
                skin: RADIUS,
                spares_memory: false,
            };
            let memory = NearMemory {
                near: &mut NearPairs::default(),
                contacts: &mut ContactNumbers::default(),
                mask: &mut ContactMask::default(),
            };
            pair_loops::add_without_friction(
                &context,
                &pairs,
                &scope,
                memory,
                &mut sums,
                &mut contacts,
            );
            FrictionEnergies::default()
        };
        let moving = forces.iter().map(|&[fx, fy, ..]| [fx, fy]);
        assert!(
            moving.eq(sums_of(&contacts, count)),
            "recorded forces are not those that move the discs"
        );
        let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        let recorded = contacts.iter().flat_map(|contact| {
            let [[x, y], [fx, fy]] = [contact.normal, contact.force];
            [x, y, fx, fy, contact.overlap, contact.overlap_over_radius, contact.normal_force]
        });
        let recorded = bits(&recorded.collect::<Vec<f64>>());
        let sums = [forces.as_flattened(), tangential.as_flattened(), rolling.as_slice()];
        Outcome {
            sums: [sums.map(bits).concat(), recorded].concat(),
            springs: [bits(&pairs.stretch), bits(&pairs.rolling_stretch)].concat(),
            energies,
            max_overlap: max_overlap.over_radius.to_bits(),
        }
    }
}

#[test]
fn register_width_changes_no_bit() {
    let mut generator = Seed { seed: 11, replicate: 0 }.stream(Stream::Positions);
    for (rolls, differ, friction) in [
        (false, false, 0.0),
        (false, false, 0.5),
        (false, true, 0.5),
        (true, false, 0.5),
        (true, true, 0.5),
    ] {
        for tail in [true, false] {
            let mut sample = Sample::new(law(rolls, differ, tail, friction), &mut generator);
            let scalar = sample.outcome(1);
            let FrictionEnergies { elastic, friction: lost, rolling } = scalar.energies;
            assert_eq!(elastic.iter().chain(&lost).all(|&energy| energy > 0.0), friction > 0.0);
            assert_eq!(rolling.iter().all(|&energy| energy > 0.0), rolls);
            for width in [4, 8] {
                assert!(sample.outcome(width) == scalar, "{width}; {rolls} {differ} {tail:?}");
            }
            for [vx, _] in &mut sample.velocities {
                *vx *= 1.0 + 1e-15;
            }
            assert!(sample.outcome(8) != scalar, "control: other velocities");
        }
    }
}
