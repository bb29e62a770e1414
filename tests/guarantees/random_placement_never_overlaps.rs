//! Law: discs placed at random lie inside their rectangle and do not overlap, and each disc takes every free position with equal
//! probability (random sequential addition). Discs that do not fit are rejected.
//!
//! Source: Feder, J. Theor. Biol. 87, 237 (1980); the lattice follows from its construction.
//! Setup: equal and mixed radii up to a packing fraction of 0.5, long and short rectangles away from the origin.
//! Tolerance: none for overlap: every pair is compared by the squares of distance and reach, as the definition states. Statistics:
//! Kolmogorov–Smirnov at a probability of 1e-6 (sqrt(n) D < 2.69), means at 5 standard errors; the seeds are fixed.
//! Control: a pair that overlaps by 1e-9, a disc that protrudes by 1e-9, and positions biased to one side by 10 % are rejected.

// Statistics in tests are not part of any recording.
#![allow(clippy::disallowed_methods)]

use crate::uniformity::kolmogorov_smirnov;
use kinetoscope_manifest::model::Boundary;
use kinetoscope_physics::placement::{
    Incomplete, Rectangle, random_sequential_addition, square_lattice,
};
use kinetoscope_physics::random::{Generator, Seed, Stream};
use std::cell::Cell;

const SQUARE: Rectangle = Rectangle { min: [-20.0, -20.0], max: [20.0, 20.0] };
const STRIP: Rectangle = Rectangle { min: [3.0, -1.0], max: [203.0, 2.5] };

fn positions(seed: u64) -> Generator {
    Seed { seed, replicate: 0 }.stream(Stream::Positions)
}

fn place(
    rectangle: Rectangle,
    radii: &[f64],
    generator: &mut Generator,
) -> Result<Vec<[f64; 2]>, Incomplete> {
    random_sequential_addition(rectangle, Boundary::Walls, radii, generator, |_, _| true, &|_| true)
}

fn overlaps(centers: &[[f64; 2]], radii: &[f64]) -> bool {
    (0..centers.len()).any(|first| {
        (0..first).any(|second| {
            let distance = [0, 1].map(|axis| centers[first][axis] - centers[second][axis]);
            let reach = radii[first] + radii[second];
            distance[0] * distance[0] + distance[1] * distance[1] < reach * reach
        })
    })
}

/// Inside, except for the rounding of `min + radius + (width - 2 radius) u` at coordinates of size 200.
fn inside(rectangle: Rectangle, centers: &[[f64; 2]], radii: &[f64]) -> bool {
    centers.iter().zip(radii).all(|(center, radius)| {
        [0, 1].iter().all(|&axis| {
            center[axis] - radius >= rectangle.min[axis] - 1e-13
                && center[axis] + radius <= rectangle.max[axis] + 1e-13
        })
    })
}

fn filled(rectangle: Rectangle, radii: &[f64]) -> f64 {
    let area = (rectangle.max[0] - rectangle.min[0]) * (rectangle.max[1] - rectangle.min[1]);
    radii.iter().map(|radius| std::f64::consts::PI * radius * radius).sum::<f64>() / area
}

#[test]
fn placed_discs_do_not_overlap_or_protrude() {
    let equal = vec![1.0; 250];
    let mut generator = Seed { seed: 5, replicate: 0 }.stream(Stream::Radii);
    let mixed: Vec<f64> = (0..550).map(|_| generator.uniform_in(0.1, 0.9)).collect();
    let one_giant: Vec<f64> = std::iter::once(12.0).chain(std::iter::repeat_n(0.3, 700)).collect();
    let tight = vec![1.74; 27];
    let runs = [
        (SQUARE, &equal, 0.49),
        (SQUARE, &mixed, 0.3),
        (SQUARE, &one_giant, 0.4),
        (STRIP, &mixed[..250].to_vec(), 0.3),
        (STRIP, &tight, 0.3),
    ];
    for (rectangle, radii, at_least) in runs {
        assert!(filled(rectangle, radii) > at_least, "the rectangle must be crowded");
        for seed in 0..3 {
            let centers = place(rectangle, radii, &mut positions(seed)).unwrap();
            assert_eq!(centers.len(), radii.len());
            assert!(!overlaps(&centers, radii));
            assert!(inside(rectangle, &centers, radii));
        }
    }
}

#[test]
fn control_an_overlap_of_a_billionth_is_found() {
    let radii = [1.0, 1.0];
    assert!(!overlaps(&[[0.0, 0.0], [2.0, 0.0]], &radii), "touching discs do not overlap");
    assert!(overlaps(&[[0.0, 0.0], [2.0 - 1e-9, 0.0]], &radii));
    assert!(!inside(SQUARE, &[[19.0 + 1e-9, 0.0]], &[1.0]));
    assert!(!inside(SQUARE, &[[0.0, -19.0 - 1e-9]], &[1.0]));
}

#[test]
fn placement_is_determined_by_the_seed() {
    let radii = vec![1.0; 50];
    let centers = |seed| place(SQUARE, &radii, &mut positions(seed)).unwrap();
    assert_eq!(centers(14), centers(14));
    assert_ne!(centers(14), centers(15));
}

#[test]
fn discs_that_do_not_fit_are_rejected() {
    let small = Rectangle { min: [0.0, 0.0], max: [3.0, 3.0] };
    // The centers of two unit discs need a distance of 2; the square of possible centers has a diagonal of 1.41.
    let jammed = place(small, &[1.0, 1.0], &mut positions(1));
    assert_eq!(jammed, Err(Incomplete::Jammed { placed: 1 }));
    let too_large = place(small, &[1.0, 1.6], &mut positions(1));
    assert_eq!(too_large, Err(Incomplete::Jammed { placed: 1 }));
    // A disc that fits exactly is in the middle.
    let exact = place(small, &[1.5], &mut positions(1));
    assert_eq!(exact, Ok(vec![[1.5, 1.5]]));
    assert_eq!(place(small, &[], &mut positions(1)), Ok(vec![]));
}

/// Guarantee: the caller is asked before each disc whether to proceed.
#[test]
fn placement_stops_between_two_discs() {
    let asked = Cell::new(0);
    let stops_after = |discs| {
        asked.set(0);
        let proceed = |_: f64| {
            asked.set(asked.get() + 1);
            asked.get() <= discs
        };
        let (radii, all) = ([1.0; 50], |_, _| true);
        let generator = &mut positions(14);
        random_sequential_addition(SQUARE, Boundary::Walls, &radii, generator, all, &proceed)
    };
    assert_eq!((stops_after(7), asked.get()), (Err(Incomplete::Stopped), 8));
    assert_eq!(stops_after(50), place(SQUARE, &[1.0; 50], &mut positions(14)));
}

/// Position of the first disc for 20000 seeds, as fractions of the range of its center.
#[allow(clippy::unwrap_used)] // a failed placement fails the test
fn positions_of_one_disc(radius: f64) -> Vec<[f64; 2]> {
    (0..20_000)
        .map(|seed| {
            let center = place(STRIP, &[radius], &mut positions(seed)).unwrap()[0];
            [0, 1].map(|axis| {
                let room = STRIP.max[axis] - STRIP.min[axis] - 2.0 * radius;
                (center[axis] - STRIP.min[axis] - radius) / room
            })
        })
        .collect()
}

#[test]
fn position_of_a_single_disc_is_uniform() {
    let places = positions_of_one_disc(0.75);
    for axis in [0, 1] {
        let along: Vec<f64> = places.iter().map(|place| place[axis]).collect();
        let leaning = along.iter().map(|share| share.powf(1.1)).collect();
        assert!(kolmogorov_smirnov(along) < 2.69);
        assert!(kolmogorov_smirnov(leaning) > 2.69, "control");
    }
    // x and y are independent: products of deviations from the mean have variance (1/12)^2.
    let product: f64 = places.iter().map(|[x, y]| (x - 0.5) * (y - 0.5)).sum();
    assert!((product / 20_000.0).abs() < 5.0 / 12.0 / 20_000_f64.sqrt());
}

/// Two discs in a corridor of their own width: the first disc excludes a length of 4 for the center of the second, which
/// is uniform over the remaining length on both sides.
#[test]
fn position_of_the_second_disc_is_uniform_over_the_free_length() {
    let corridor = Rectangle { min: [0.0, 0.0], max: [20.0, 2.0] };
    let shares = (0..20_000)
        .map(|seed| {
            let centers = place(corridor, &[1.0, 1.0], &mut positions(seed)).unwrap();
            let [first, second] = [centers[0][0], centers[1][0]];
            // Centers are in [1, 19]; the first disc excludes (first - 2, first + 2).
            let below = if first > 3.0 { first - 2.0 - 1.0 } else { 0.0 };
            let above = if first < 17.0 { 19.0 - (first + 2.0) } else { 0.0 };
            let place = if second < first { second - 1.0 } else { below + second - (first + 2.0) };
            place / (below + above)
        })
        .collect();
    assert!(kolmogorov_smirnov(shares) < 2.69);
}

#[test]
fn lattice_that_does_not_fit_is_rejected() {
    for (rectangle, radius, count) in [
        (SQUARE, 1.0, 400),
        (SQUARE, 1.0, 1),
        (SQUARE, 0.4, 1789),
        (STRIP, 0.5, 199),
        (STRIP, 0.5, 600),
        (STRIP, 1.75, 57),
    ] {
        let centers = square_lattice(rectangle, radius, count).unwrap();
        let radii = vec![radius; count];
        assert_eq!(centers.len(), count);
        assert!(!overlaps(&centers, &radii), "{rectangle:?} {radius} {count}");
        assert!(inside(rectangle, &centers, &radii), "{rectangle:?} {radius} {count}");
    }
    assert_eq!(square_lattice(SQUARE, 1.0, 401), None);
    assert_eq!(square_lattice(STRIP, 1.76, 1), None);
    assert_eq!(square_lattice(STRIP, 1.75, 58), None);
    assert_eq!(square_lattice(SQUARE, 1.0, 0), None);
}
