//! Guarantee: a run has the same bits in registers of every width: AVX2 and plain x86-64.
//!
//! Setup: periodic boxes from dilute to dense, walls with restitution and noise, radii of several sizes, inelastic discs with the
//! TC model, and a lattice whose collisions are simultaneous. Widths that the processor does not have are left out.
//! Tolerance: none; the whole state is compared, including the time and the statistics.
//! Control: a run that is one collision longer, or of another seed, is not equal.

#![allow(clippy::unwrap_used)] // An invalid configuration fails its test.

use crate::runs::{at_fraction, given, prepare, with_restitution, without_noise};
use kinetoscope_manifest::model::{Boundary, CollapseGuard, PackingConfig, PackingPlacement};
use kinetoscope_manifest::quantity::{NonNegative, Positive};
use kinetoscope_physics::model::{Model, Progress, Target};
use kinetoscope_physics::packing::Packing;
use kinetoscope_physics::simd::registers::widest;

/// Widths of the engine's registers.
const WIDTHS: [usize; 2] = [1, 4];

fn periodic(discs: u32, fraction: f64) -> PackingConfig {
    PackingConfig {
        boundary: Boundary::Periodic,
        placement: PackingPlacement::Lattice,
        ..without_noise(at_fraction(discs, fraction))
    }
}

/// Discs on a square lattice; the columns approach each other in pairs at the same speed.
fn simultaneous() -> PackingConfig {
    let disc = |index: u32| {
        let [column, row] = [index % 8, index / 8].map(f64::from);
        let velocity = if index.is_multiple_of(2) { 1.0 } else { -1.0 };
        [4.0 * column - 14.0, 4.0 * row - 14.0, velocity, 0.0]
    };
    let discs: Vec<[f64; 4]> = (0..64).map(disc).collect();
    given(&discs)
}

/// Discs that fly between two discs at rest and touch both at the same time. They have the largest ids, so that their events come first. With
/// 16 more discs, the numbers that describe cells are exact, and so is the symmetry.
fn two_at_once() -> PackingConfig {
    let discs: Vec<[f64; 4]> = (0..16)
        .flat_map(|group: u32| {
            let [x, y] = [group % 4, group / 4].map(|index| 9.0 * f64::from(index) - 13.5);
            let first = if group.is_multiple_of(2) { 1.25 } else { -1.25 };
            let at_rest = [y + first, y - first, y + 4.5].map(|y| [x, y, 0.0, 0.0]);
            [at_rest[0], at_rest[1], at_rest[2], [x - 3.0, y, 1.0, 0.0]]
        })
        .collect();
    given(&discs)
}

fn scenes() -> [(&'static str, PackingConfig); 12] {
    let walled = with_restitution(at_fraction(500, 0.3), 0.999);
    let several_sizes = PackingConfig {
        radius_half_width: NonNegative::literal(0.4),
        placement: PackingPlacement::Random,
        ..periodic(300, 0.3)
    };
    let inelastic = PackingConfig {
        collapse_guard: CollapseGuard::ContactTime(Positive::literal(1e-3)),
        ..with_restitution(periodic(500, 0.5), 0.8)
    };
    let falls =
        |config: PackingConfig| PackingConfig { gravity: NonNegative::literal(0.05), ..config };
    [
        ("gravity", falls(at_fraction(500, 0.3))),
        ("gravity, dilute", falls(without_noise(at_fraction(1000, 0.02)))),
        (
            "gravity, several sizes",
            falls(PackingConfig { boundary: Boundary::Walls, ..several_sizes.clone() }),
        ),
        ("dilute", periodic(1000, 0.02)),
        ("periodic", periodic(1000, 0.3)),
        ("dense", periodic(1000, 0.7)),
        ("walls, restitution and noise", walled),
        ("few discs", at_fraction(9, 0.3)),
        ("several sizes", several_sizes),
        ("inelastic", inelastic),
        ("simultaneous", simultaneous()),
        ("two at once", two_at_once()),
    ]
}

fn advanced(config: &PackingConfig, seed: u64, width: usize, collisions: u64) -> Packing {
    let mut packing = prepare(config, seed, 0);
    let target = Target::Count(collisions);
    assert_eq!(packing.advance_at_width(target, u64::MAX, width), Ok(Progress::Reached));
    packing
}

#[test]
fn every_width_gives_the_same_bits() {
    for (name, config) in scenes() {
        let collisions = if name == "two at once" { 200 } else { 10_000 };
        let plain = advanced(&config, 6, 1, collisions);
        for width in WIDTHS.into_iter().filter(|&width| width <= widest()) {
            let packing = advanced(&config, 6, width, collisions);
            assert_eq!(packing.time().to_bits(), plain.time().to_bits(), "{name}, width {width}");
            assert!(packing == plain, "{name}, width {width}");
        }
        assert!(advanced(&config, 6, widest(), collisions + 1) != plain, "control: {name}");
    }
    let config = periodic(1000, 0.3);
    assert!(advanced(&config, 6, 1, 1000) != advanced(&config, 7, 1, 1000), "control: seed");
}

/// Guarantee: of simultaneous events, the order is that of their kinds, partners and discs, however the queue was filled: a run whose queue is
/// built again before every collision has the same bits. Control: at least ten collisions are simultaneous with the one before.
#[test]
fn simultaneous_events_have_one_order() {
    for config in [simultaneous(), two_at_once()] {
        let mut whole = prepare(&config, 6, 0);
        let mut restored = prepare(&config, 6, 0);
        let (mut ties, mut before) = (0, f64::NAN);
        for count in 1..=200 {
            let text = serde_json::to_string(&restored).unwrap();
            restored = serde_json::from_str(&text).unwrap();
            for packing in [&mut whole, &mut restored] {
                assert_eq!(packing.advance(Target::Count(count), u64::MAX), Ok(Progress::Reached));
            }
            assert!(whole == restored, "collision {count}");
            ties += u32::from(whole.time() == std::mem::replace(&mut before, whole.time()));
        }
        assert!(ties >= 10, "control: {ties}");
    }
}
