//! The discs at the start: how large, how heavy, where and how fast.

use super::contacts::Discs;
use super::neighbours::Neighbours;
use super::parameters::{Parameters, mass_of, radius_range};
use crate::model::Refusal;
use crate::placement::{Rectangle, random_sequential_addition, square_lattice};
use crate::random::{Seed, Stream};
use kinetoscope_manifest::model::{DemConfig, DiscRadius, GivenState, Placement};

/// Overlap over the sum of radii that is still touching: decimals typed in are rounded.
const TOUCHING: f64 = 1e-12;

/// Discs without overlap, inside the box, with their velocities at the positions' time.
///
/// # Errors
/// Where they have no room, or where those given overlap or stand outside.
pub(super) fn discs(
    config: &DemConfig,
    parameters: &Parameters,
    seed: Seed,
) -> Result<Discs, Refusal> {
    let radii = radii(config, seed);
    let (_, largest) = radius_range(config);
    if 2.0 * largest > parameters.sides[0] || 2.0 * largest > parameters.sides[1] {
        return Err(Refusal(format!(
            "A disc of radius {largest:e} m has no room in a box of {:e} m x {:e} m: take a smaller radius_m or a larger \
             box.",
            parameters.sides[0], parameters.sides[1]
        )));
    }
    let rectangle = Rectangle { min: [0.0, 0.0], max: parameters.sides };
    let positions = match &config.placement {
        Placement::Random => {
            let mut generator = seed.stream(Stream::Positions);
            random_sequential_addition(rectangle, &radii, &mut generator).map_err(|jammed| {
                no_room(config, parameters, &radii, &format!("only {} stand", jammed.placed))
            })?
        }
        Placement::Lattice => square_lattice(rectangle, largest, radii.len()).ok_or_else(|| {
            no_room(config, parameters, &radii, "a square lattice is too small for them")
        })?,
        Placement::Given(given) => given_positions(given, parameters, &radii)?,
    };
    let velocities = match &config.placement {
        Placement::Given(given) => {
            given.velocities.iter().map(|velocity| velocity.map(|v| v.get())).collect()
        }
        Placement::Random | Placement::Lattice => vec![[0.0, 0.0]; radii.len()],
    };
    let masses =
        radii.iter().map(|&radius| mass_of(radius, parameters.radius, parameters.mass)).collect();
    Ok(Discs { positions, velocities, radii, masses })
}

/// Share of the box that the discs cover.
pub(super) fn packing_fraction(radii: &[f64], sides: [f64; 2]) -> f64 {
    let squares: f64 = radii.iter().map(|radius| radius * radius).sum();
    std::f64::consts::PI * squares / (sides[0] * sides[1])
}

fn radii(config: &DemConfig, seed: Seed) -> Vec<f64> {
    let count = config.discs.get() as usize;
    match config.radius_m {
        DiscRadius::Equal(radius) => vec![radius.get(); count],
        DiscRadius::Uniform { min, max } => {
            let mut generator = seed.stream(Stream::Radii);
            (0..count).map(|_| generator.uniform_in(min.get(), max.get())).collect()
        }
    }
}

fn no_room(config: &DemConfig, parameters: &Parameters, radii: &[f64], found: &str) -> Refusal {
    Refusal(format!(
        "{} discs find no place without overlap: {found}. They would cover {:.1} % of the box; at random there is room \
         up to some 54 %, on the square lattice of placement = \"lattice\" up to 78 %. Take fewer discs, a smaller \
         radius_m or a larger box.",
        config.discs,
        100.0 * packing_fraction(radii, parameters.sides)
    ))
}

fn given_positions(
    given: &GivenState,
    parameters: &Parameters,
    radii: &[f64],
) -> Result<Vec<[f64; 2]>, Refusal> {
    if given.positions.len() != radii.len() || given.velocities.len() != radii.len() {
        return Err(Refusal(format!(
            "discs = {}, but positions_m has {} entries and velocities_m_per_s {}: make them equal.",
            radii.len(),
            given.positions.len(),
            given.velocities.len()
        )));
    }
    let positions: Vec<[f64; 2]> =
        given.positions.iter().map(|position| position.map(|x| x.get())).collect();
    for (disc, (position, radius)) in positions.iter().zip(radii).enumerate() {
        let room = radius * (1.0 - TOUCHING);
        let is_inside =
            |axis: usize| position[axis] >= room && parameters.sides[axis] - position[axis] >= room;
        if !is_inside(0) || !is_inside(1) {
            return Err(Refusal(format!(
                "Disc {disc} (counted from 0) at [{:e}, {:e}] m with radius {radius:e} m reaches outside the box: \
                 move its entry in positions_m inwards.",
                position[0], position[1]
            )));
        }
    }
    let mut neighbours = Neighbours::default();
    neighbours.refresh(&positions, radii, parameters.sides, parameters.skin);
    for (disc, position) in positions.iter().enumerate() {
        for &partner in neighbours.above(disc) {
            let other = positions[partner as usize];
            let apart = [position[0] - other[0], position[1] - other[1]];
            let distance = (apart[0] * apart[0] + apart[1] * apart[1]).sqrt();
            let reach = radii[disc] + radii[partner as usize];
            if distance < reach * (1.0 - TOUCHING) {
                return Err(Refusal(format!(
                    "Discs {disc} and {partner} (counted from 0) overlap at the start by {:e} m: move their entries in \
                     positions_m apart, or take a smaller radius_m.",
                    reach - distance
                )));
            }
        }
    }
    Ok(positions)
}
