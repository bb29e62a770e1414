//! Promise: pairs that rub have the same forces, springs and energies to the last bit, whether they are taken one by one,
//! four or eight at a time: with rolling friction or without, for one material or several, with the force's tail or without.
//!
//! Setup: 1003 pairs of 60 discs that overlap, touch or are apart, with stretched springs, moving and turning at random; so
//! many that a few fill no register.
//! Tolerance: none. Control: discs that turn faster by one part in 10^15 are noticed.

use crate::dem::forces::Deepest;
use crate::dem::forces::contact::ContactLaw;
use crate::dem::forces::rubbing::{self, LaneSums, Sight, Totals};
use crate::dem::neighbors::Pairs;
use crate::dem::parameters::Parameters;
use crate::random::{Generator, Seed, Stream};
use kinetoscope_manifest::model::{DemConfig, DemContactConstants, DemMaterial, ForceTail};
use kinetoscope_manifest::quantity::{NonNegative, Positive, Share};

const DISCS: u32 = 60;
const PAIRS: usize = 1003;
const RADIUS: f64 = 5e-4;

struct Crowd {
    law: ContactLaw,
    positions: Vec<[f64; 2]>,
    velocities: Vec<[f64; 2]>,
    spins: Vec<f64>,
    radii: Vec<f64>,
    materials: Vec<u8>,
    pairs: Pairs,
}

/// Bits of all that came out.
#[derive(PartialEq)]
struct Outcome {
    sums: Vec<u64>,
    springs: Vec<u64>,
    energies: LaneSums,
    deepest: u64,
}

fn law(rolls: bool, differ: bool, force_tail: ForceTail) -> ContactLaw {
    let coefficient = |value: f64| NonNegative::new(value).expect("not negative");
    let material = |name: &str, friction: f64| DemMaterial {
        name: name.to_owned(),
        share: Positive::new(1.0).expect("above zero"),
        density_ratio: Positive::new(1.0).expect("above zero"),
        constants: DemContactConstants {
            restitution: Share::new(0.8),
            friction: Some(coefficient(friction)),
            rolling_friction: None,
        },
    };
    let config = DemConfig {
        friction: coefficient(0.5),
        rolling_friction: coefficient(if rolls { 0.1 } else { 0.0 }),
        materials: if differ { vec![material("a", 0.3), material("b", 0.0)] } else { vec![] },
        force_tail,
        ..DemConfig::default()
    };
    Parameters::new(&config).law
}

impl Crowd {
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
        Self { law, positions, velocities, spins, radii, materials, pairs }
    }

    fn by(&self, most: usize) -> Outcome {
        let count = self.positions.len();
        let (mut forces, mut tangential) = (vec![[0.0; 4]; count], vec![[0.0; 2]; count]);
        let (mut rolling, mut deepest) = (vec![0.0; count], Deepest::default());
        let rim_speeds: Vec<f64> = self.radii.iter().zip(&self.spins).map(|(r, w)| r * w).collect();
        let sight = Sight {
            positions: &self.positions,
            velocities: &self.velocities,
            rim_speeds: &rim_speeds,
            spins: &self.spins,
            radii: &self.radii,
            materials: &self.materials,
            law: &self.law,
            time_step: 1e-6,
            end: PAIRS,
        };
        let mut totals = Totals {
            forces: &mut forces,
            tangential: &mut tangential,
            rolling: &mut rolling,
            energies: LaneSums::default(),
            deepest: &mut deepest,
        };
        let mut pairs = self.pairs.clone();
        rubbing::in_lanes(&mut pairs, &sight, &mut totals, most);
        let energies = totals.energies;
        let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        Outcome {
            sums: [bits(forces.as_flattened()), bits(tangential.as_flattened()), bits(&rolling)]
                .concat(),
            springs: [bits(&pairs.stretch), bits(&pairs.rolling_stretch)].concat(),
            energies,
            deepest: deepest.over_radius.to_bits(),
        }
    }
}

#[test]
fn the_number_taken_at_a_time_changes_no_bit() {
    let mut generator = Seed { seed: 11, replicate: 0 }.stream(Stream::Positions);
    for (rolls, differ) in [(false, false), (false, true), (true, false), (true, true)] {
        for tail in [ForceTail::Clamped, ForceTail::Attractive] {
            let mut crowd = Crowd::new(law(rolls, differ, tail), &mut generator);
            let one_by_one = crowd.by(1);
            let LaneSums { elastic, friction, rolling } = one_by_one.energies;
            assert!(elastic.iter().chain(&friction).all(|&energy| energy > 0.0), "all rub");
            assert_eq!(rolling.iter().all(|&energy| energy > 0.0), rolls);
            for most in [4, 8] {
                assert!(crowd.by(most) == one_by_one, "{most}; {rolls} {differ} {tail:?}");
            }
            for spin in &mut crowd.spins {
                *spin *= 1.0 + 1e-15;
            }
            assert!(crowd.by(8) != one_by_one, "control: other spins");
        }
    }
}
