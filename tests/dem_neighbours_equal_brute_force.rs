//! Law: the neighbour list holds every pair closer than touching, until a disc has moved by half the skin, and no pair twice.
//!
//! Source: all pairs, one by one.
//! Setup: random points, inside the box and beyond it, with radii from one to twenty; then moved by just under half the skin.
//! Tolerance: none, the sets are equal.

use kinetoscope::models::dem::neighbours::Neighbours;
use kinetoscope::random::{Generator, Seed, Stream};

const SKIN: f64 = 0.02;

struct Cloud {
    positions: Vec<[f64; 2]>,
    radii: Vec<f64>,
    sides: [f64; 2],
}

fn cloud(count: usize, sides: [f64; 2], radii: [f64; 2], generator: &mut Generator) -> Cloud {
    let mut positions = Vec::new();
    for _ in 0..count {
        let x = generator.uniform_in(-0.1 * sides[0], 1.1 * sides[0]);
        positions.push([x, generator.uniform_in(-0.1 * sides[1], 1.1 * sides[1])]);
    }
    let radii = (0..count).map(|_| generator.uniform_in(radii[0], radii[1])).collect();
    Cloud { positions, radii, sides }
}

/// Pairs closer than touching plus a margin, in order.
fn brute_force(cloud: &Cloud, margin: f64) -> Vec<[usize; 2]> {
    let mut pairs = Vec::new();
    for first in 0..cloud.radii.len() {
        for second in first + 1..cloud.radii.len() {
            let (a, b) = (cloud.positions[first], cloud.positions[second]);
            let reach = cloud.radii[first] + cloud.radii[second] + margin;
            let apart = [a[0] - b[0], a[1] - b[1]];
            if apart[0] * apart[0] + apart[1] * apart[1] < reach * reach {
                pairs.push([first, second]);
            }
        }
    }
    pairs
}

fn listed(neighbours: &Neighbours, count: usize) -> Vec<[usize; 2]> {
    (0..count)
        .flat_map(|first| neighbours.above(first).iter().map(move |&other| [first, other as usize]))
        .collect()
}

fn refreshed(neighbours: &mut Neighbours, cloud: &Cloud) {
    neighbours.refresh(&cloud.positions, &cloud.radii, cloud.sides, SKIN);
}

#[test]
fn the_list_is_that_of_all_pairs() {
    let mut generator = Seed { seed: 3, replicate: 0 }.stream(Stream::Positions);
    let mut pairs = 0;
    for (sides, radii) in [
        ([10.0, 10.0], [0.05, 0.05]),
        ([10.0, 3.0], [0.02, 0.4]),
        ([0.3, 20.0], [0.05, 0.3]),
        ([1.0, 1.0], [0.01, 0.02]),
    ] {
        for count in [1, 2, 30, 300] {
            let cloud = cloud(count, sides, radii, &mut generator);
            let mut neighbours = Neighbours::default();
            refreshed(&mut neighbours, &cloud);
            let expected = brute_force(&cloud, SKIN);
            pairs += expected.len();
            assert_eq!(listed(&neighbours, count), expected, "{count} in {sides:?}");
        }
    }
    assert!(pairs > 1000, "{pairs}");
}

#[test]
fn the_list_holds_until_half_the_skin_and_is_built_anew_beyond() {
    let mut generator = Seed { seed: 4, replicate: 0 }.stream(Stream::Positions);
    let mut cloud = cloud(400, [5.0, 5.0], [0.02, 0.2], &mut generator);
    let mut neighbours = Neighbours::default();
    refreshed(&mut neighbours, &cloud);
    let before = listed(&neighbours, 400);
    for position in &mut cloud.positions {
        let angle = generator.uniform_in(0.0, std::f64::consts::TAU);
        position[0] += 0.499 * SKIN * libm::cos(angle);
        position[1] += 0.499 * SKIN * libm::sin(angle);
    }
    refreshed(&mut neighbours, &cloud);
    assert_eq!(listed(&neighbours, 400), before, "nothing moved beyond half the skin");
    for pair in brute_force(&cloud, 0.0) {
        assert!(before.contains(&pair), "{pair:?} touch and are not listed");
    }
    // Control: one disc further on, and the list is another.
    cloud.positions[0][0] += SKIN;
    refreshed(&mut neighbours, &cloud);
    assert_eq!(listed(&neighbours, 400), brute_force(&cloud, SKIN));
    assert_ne!(listed(&neighbours, 400), before);
}
