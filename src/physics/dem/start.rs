//! The discs at the start: radii, masses, positions and velocities.

use super::discs::{Disc, Discs};
use super::motion;
use super::neighbors::cell_grid::CellGrid;
use super::parameters::Parameters;
use super::walls::PlacedWall;
use crate::model::{Proceed, SetupError};
use crate::placement::{Rectangle, random_sequential_addition, square_lattice};
use crate::random::{Generator, Seed, Stream};
use crate::restart_state;
use kinetoscope_manifest::model::{
    Boundary, DemConfig, DiscRadius, GivenState, Placement, StartFrom,
};

/// Overlap over the sum of radii that still counts as contact without overlap: decimal input is rounded.
const TOUCHING: f64 = 1e-12;

/// The drawn discs without overlap, inside the box, with their velocities at the positions' time.
///
/// # Errors
/// If the discs do not fit, or if given ones overlap or are outside the box.
pub(super) fn place(
    drawn: Vec<Disc>,
    config: &DemConfig,
    parameters: &Parameters,
    seed: Seed,
    proceed: Proceed<'_>,
) -> Result<Discs, SetupError> {
    let radii: &Vec<f64> = &drawn.iter().map(|disc| disc.radius).collect();
    let (_, largest) = parameters.radius_range;
    if 2.0 * largest > parameters.sides[0] || 2.0 * largest > parameters.sides[1] {
        return Err(SetupError::new(
            format!(
                "a disc of radius {largest:e} m has no room in a box of {:e} m x {:e} m",
                parameters.sides[0], parameters.sides[1]
            ),
            "take a smaller radius_m or a larger box",
        ));
    }
    let rectangle = match config.placement_region_m {
        Some([low, high]) => {
            Rectangle { min: low.map(|at| at.get()), max: high.map(|at| at.get()) }
        }
        None => Rectangle { min: [0.0, 0.0], max: parameters.sides },
    };
    let walls = parameters.walls_at(0);
    let positions = match &config.placement {
        Placement::Recorded(start) => return recorded_discs(start, config, parameters, drawn),
        Placement::Random => {
            let mut generator = seed.stream(Stream::Positions);
            let is_free = |center, radius| overlapped_wall(&walls, center, radius).is_none();
            let placed = random_sequential_addition(
                rectangle,
                Boundary::Walls,
                radii,
                &mut generator,
                is_free,
                proceed,
            );
            placed.map_err(|incomplete| {
                incomplete.into_error(|placed| {
                    no_room(config, parameters, radii, &format!("only {placed} are placed"))
                })
            })?
        }
        Placement::Lattice => square_lattice(rectangle, largest, radii.len()).ok_or_else(|| {
            no_room(config, parameters, radii, "a square lattice is too small for them")
        })?,
        Placement::Given(given) => given_positions(given, parameters, radii)?,
    };
    for (disc, (&center, &radius)) in positions.iter().zip(radii).enumerate() {
        if let Some(wall) = overlapped_wall(&walls, center, radius) {
            return Err(SetupError::new(
                format!(
                    "disc {disc} (counted from 0) at [{:e}, {:e}] m with radius {radius:e} m overlaps wall {wall} at the \
                     start (the box's own are counted first)",
                    center[0], center[1]
                ),
                "move it in positions_m, choose another placement_region_m, or placement = \"random\", which leaves walls free",
            ));
        }
    }
    let velocities = match &config.placement {
        Placement::Given(given) => {
            given.velocities_m_per_s.iter().map(|velocity| velocity.map(|v| v.get())).collect()
        }
        Placement::Random | Placement::Lattice | Placement::Recorded(_) => {
            drawn_velocities(config, seed, drawn.len())
        }
    };
    let mut discs = Discs::default();
    for (disc, (position, velocity)) in drawn.into_iter().zip(positions.into_iter().zip(velocities))
    {
        discs.push(&Disc { position, velocity, ..disc });
    }
    Ok(discs)
}

/// All discs, including those inserted later, with their radii, materials and masses only.
pub(super) fn drawn_discs(config: &DemConfig, parameters: &Parameters, seed: Seed) -> Vec<Disc> {
    let insertion = config.insertion.map_or(0, |insertion| insertion.discs.get());
    let count = config.discs.get() as usize + insertion as usize;
    let materials = parameters.law.materials.drawn(count, seed);
    let disc = |(id, (radius, material))| {
        let (position, velocity) = ([0.0; 2], [0.0; 2]);
        let mass = parameters.mass_of(radius, material);
        Disc { id, position, velocity, radius, mass, material }
    };
    (0..).zip(radii(config, seed, count).into_iter().zip(materials)).map(disc).collect()
}

/// Normally distributed velocities of mean zero, or discs at rest.
fn drawn_velocities(config: &DemConfig, seed: Seed, count: usize) -> Vec<[f64; 2]> {
    let Some(deviation) = config.velocity_std_m_per_s else {
        return vec![[0.0, 0.0]; count];
    };
    let mut generator = seed.stream(Stream::Velocities);
    let mut drawn: Vec<[f64; 2]> =
        (0..count).map(|_| generator.normal_pair().map(|v| v * deviation.get())).collect();
    let mean = [0, 1].map(|axis: usize| {
        let sum: f64 = drawn.iter().map(|velocity| velocity[axis]).sum();
        sum / count as f64
    });
    for velocity in &mut drawn {
        *velocity = [velocity[0] - mean[0], velocity[1] - mean[1]];
    }
    drawn
}

/// The first wall that a disc overlaps; contact without overlap is allowed.
pub(super) fn overlapped_wall(
    walls: &[PlacedWall],
    center: [f64; 2],
    radius: f64,
) -> Option<usize> {
    wall_within(walls, center, radius * (1.0 - TOUCHING))
}

/// The first wall closer to a center than a distance, m. A position that is not a number is close to every wall.
fn wall_within(walls: &[PlacedWall], center: [f64; 2], distance: f64) -> Option<usize> {
    walls.iter().position(|wall| {
        let is_apart = wall.shape.contact(center).distance >= distance;
        !is_apart
    })
}

/// Fraction of the box that the discs cover.
pub(super) fn packing_fraction(radii: &[f64], sides: [f64; 2]) -> f64 {
    let squares: f64 = radii.iter().map(|radius| radius * radius).sum();
    std::f64::consts::PI * squares / (sides[0] * sides[1])
}

fn radii(config: &DemConfig, seed: Seed, count: usize) -> Vec<f64> {
    let mut generator = seed.stream(Stream::Radii);
    let mut draw = || match config.radius_m {
        DiscRadius::Equal(radius) => radius.get(),
        DiscRadius::Uniform { min, max } => generator.uniform_in(min.get(), max.get()),
        DiscRadius::Normal { mean, std } => normal_radius(mean.get(), std.get(), &mut generator),
        DiscRadius::TwoSizes { small, large, small_fraction } => {
            let is_small = generator.uniform() < small_fraction.get();
            if is_small { small.get() } else { large.get() }
        }
    };
    (0..count).map(|_| draw()).collect()
}

/// Number of draws of a radius. Of all normal numbers, 0.27 % are beyond three standard deviations.
const MAX_DRAWS: u32 = 1000;

/// A normally distributed radius; values beyond three standard deviations are rejected.
fn normal_radius(mean: f64, deviation: f64, generator: &mut Generator) -> f64 {
    let mut draws = (0..MAX_DRAWS).map(|_| generator.normal_pair()[0]);
    let drawn = draws.find(|drawn| drawn.abs() <= 3.0);
    mean + deviation * drawn.unwrap_or(0.0)
}

fn no_room(config: &DemConfig, parameters: &Parameters, radii: &[f64], found: &str) -> SetupError {
    SetupError::new(
        format!(
            "{} discs cannot be placed without overlap: {found}. They would cover {:.1} % of the box; random placement \
             reaches about 54 %, and placement = \"lattice\" 78 %",
            config.discs,
            100.0 * packing_fraction(radii, parameters.sides)
        ),
        "use fewer discs, a smaller radius_m or a larger box",
    )
}

fn given_positions(
    given: &GivenState,
    parameters: &Parameters,
    radii: &[f64],
) -> Result<Vec<[f64; 2]>, SetupError> {
    if given.positions_m.len() != radii.len() || given.velocities_m_per_s.len() != radii.len() {
        return Err(SetupError::new(
            format!(
                "discs = {}, but positions_m has {} entries and velocities_m_per_s {}",
                radii.len(),
                given.positions_m.len(),
                given.velocities_m_per_s.len()
            ),
            "make them equal",
        ));
    }
    let positions: Vec<[f64; 2]> =
        given.positions_m.iter().map(|position| position.map(|x| x.get())).collect();
    for (disc, (position, radius)) in positions.iter().zip(radii).enumerate() {
        let room = |axis: usize| {
            if parameters.periodic[axis] { 0.0 } else { radius * (1.0 - TOUCHING) }
        };
        let is_inside = |axis: usize| {
            position[axis] >= room(axis) && parameters.sides[axis] - position[axis] >= room(axis)
        };
        if !is_inside(0) || !is_inside(1) {
            return Err(SetupError::new(
                format!(
                    "disc {disc} (counted from 0) at [{:e}, {:e}] m with radius {radius:e} m reaches outside the box",
                    position[0], position[1]
                ),
                "move its entry in positions_m inwards",
            ));
        }
    }
    match first_overlap(&positions, radii, parameters) {
        Some((first, second, overlap)) => Err(SetupError::new(
            format!(
                "discs {first} and {second} (counted from 0) overlap at the start by {overlap:e} m"
            ),
            "move their entries in positions_m apart, or take a smaller radius_m",
        )),
        None => Ok(positions),
    }
}

/// The first pair that overlaps, with its overlap, m.
fn first_overlap(
    positions: &[[f64; 2]],
    radii: &[f64],
    parameters: &Parameters,
) -> Option<(usize, usize, f64)> {
    let reach = 2.0 * parameters.radius_range.1;
    let count = positions.len();
    let (cells, order) =
        CellGrid::sort(positions, parameters.sides, reach, parameters.periodic, count);
    let mut found = Vec::new();
    for disc in 0..count {
        cells.around(positions[disc], &mut found);
        for run in &found {
            for &other in &order[run.discs.clone()] {
                let other = other as usize;
                let along = |axis: usize| {
                    let shift = f64::from(run.shift[axis]) * parameters.sides[axis];
                    positions[disc][axis] - (positions[other][axis] + shift)
                };
                let distance = motion::distance_squared([along(0), along(1)]).sqrt();
                let reach = radii[disc] + radii[other];
                if disc < other && distance < reach * (1.0 - TOUCHING) {
                    return Some((disc, other, reach - distance));
                }
            }
        }
    }
    None
}

/// Overlap with a wall over the radius that is accepted at the start. A bed at rest overlaps its floor by far less; a
/// wall of the new run must not cut through discs.
const MAX_WALL_OVERLAP: f64 = 0.5;

/// The discs of a recording's last frame.
///
/// Positions, radii, spins and the integrator's velocities are taken over bit for bit. A recording contains no tangential and rolling
/// springs; they begin unstretched. Discs are renumbered from 0 in their order.
///
/// # Errors
/// Several materials, which a recording does not distinguish, radii outside the range of `radius_m`, or discs outside of the box or
/// within a wall.
fn recorded_discs(
    start: &StartFrom,
    config: &DemConfig,
    parameters: &Parameters,
    drawn: Vec<Disc>,
) -> Result<Discs, SetupError> {
    if config.materials.len() > 1 {
        return Err(SetupError::new(
            "a recording does not say which disc is of which material",
            "with start_from, give one material at most",
        ));
    }
    let rows = restart_state::rows(start, ["x", "y", "vx_step", "vy_step", "radius", "spin"])?;
    check_recorded(&rows, config, parameters)?;
    let mut discs = Discs::default();
    for (disc, &[x, y, vx, vy, radius, _]) in drawn.iter().zip(&rows) {
        let mass = parameters.mass_of(radius, disc.material);
        discs.push(&Disc { position: [x, y], velocity: [vx, vy], radius, mass, ..*disc });
    }
    discs.spins = rows.iter().map(|row| row[5]).collect();
    Ok(discs)
}

fn check_recorded(
    rows: &[[f64; 6]],
    config: &DemConfig,
    parameters: &Parameters,
) -> Result<(), SetupError> {
    let (smallest, largest) = config.radius_m.range();
    let walls = parameters.walls_at(0);
    for (disc, &[x, y, _, _, radius, _]) in rows.iter().enumerate() {
        if radius < smallest * (1.0 - TOUCHING) || radius > largest * (1.0 + TOUCHING) {
            return Err(SetupError::new(
                format!(
                    "disc {disc} (counted from 0) of the recording in start_from has the radius {radius:e} m, which radius_m \
                     does not allow"
                ),
                "write the radius_m of the recording's manifest",
            ));
        }
        let [width, height] = parameters.sides;
        let is_inside = (0.0..=width).contains(&x) && (0.0..=height).contains(&y);
        let within = wall_within(&walls, [x, y], radius * (1.0 - MAX_WALL_OVERLAP));
        if !is_inside || within.is_some() {
            return Err(SetupError::new(
                format!(
                    "disc {disc} (counted from 0) of the recording in start_from is at [{x:e}, {y:e}] m, outside of this \
                     run's box or within one of its walls"
                ),
                "keep width_m, height_m and walls as they were, or move the walls to where there is no disc",
            ));
        }
    }
    Ok(())
}
