//! Where discs stand and how they move at the start.

use super::cells::{Cells, Grid};
use super::compression::compress;
use super::disc::MANY;
use super::lattice::{hexagonal_rows, most_in_hexagonal_rows, periodic_hexagonal};
use super::motion::{self, Vector};
use crate::model::SetupError;
use crate::placement::{
    Rectangle, periodic_random_sequential_addition, random_sequential_addition, square_lattice,
};
use crate::random::{Generator, Seed, Stream};
use crate::restart_state::rows;
use kinetoscope_manifest::model::{
    Boundary, GivenState, InitialVelocities, PERIODIC_DIAMETERS, PackingConfig, PackingPlacement,
    StartFrom,
};

/// Random placement is offered below this packing fraction (packing document, `NU`). Random sequential addition itself
/// comes to its end at 0.547 (Feder, J. Theor. Biol. 87, 237, 1980).
const RANDOM_PLACEMENT_LIMIT: f64 = 0.5;

/// Discs that a manifest writes out may overlap each other or a wall by this share of their diameter: its decimals are
/// rounded.
const ROUNDING: f64 = 1e-12;

/// Speeds outside of this range can't be raised to the fourth power.
const SPEEDS: [f64; 2] = [1e-60, 1e60];

/// The start of a run.
pub(super) struct Start {
    /// Centers.
    pub(super) positions: Vec<Vector>,
    /// Velocities, as many.
    pub(super) velocities: Vec<Vector>,
    /// Radii, as many; empty where all are equal.
    pub(super) radii: Vec<f64>,
    /// Radius of the largest disc.
    pub(super) largest_radius: f64,
    /// How it came about, for the log.
    pub(super) account: String,
}

/// Places the discs and gives them velocities.
///
/// # Errors
/// Discs that do not fit, overlap, or stand outside.
pub(super) fn start(config: &PackingConfig, seed: Seed) -> Result<Start, SetupError> {
    check_size(config)?;
    let mut radii = radii(config, seed);
    let mut scale = 1.0;
    let (mut positions, placed) = match &config.placement {
        PackingPlacement::Random => {
            check_random(config, &radii)?;
            (random_positions(config, &radii, seed)?, "random sequential addition".to_owned())
        }
        PackingPlacement::Lattice => lattice_positions(config)?,
        PackingPlacement::Compressed => {
            let compressed = compress(config, &radii, seed)?;
            scale = compressed.scale;
            (compressed.positions, compressed.account)
        }
        PackingPlacement::Given(given) => {
            return given_start(config, given, radii);
        }
        PackingPlacement::Recorded(start) => return recorded_start(config, start),
    };
    // Before the numbering gives columns back: an allocator keeps what takes the place of a column that was given back.
    let velocities = random_velocities(config, seed.stream(Stream::Velocities));
    number_by_place(config, &mut positions, &mut radii);
    let momentum = if velocities.len() > 1 { ", mean velocity removed" } else { "" };
    let radii: Vec<f64> = radii.into_iter().map(|radius| radius * scale).collect();
    let account = format!(
        "start by {placed}, packing fraction {:.4}, velocity components normal with standard deviation {}{momentum}",
        packing_fraction(config, &radii),
        velocity_deviation(config)
    );
    Ok(Start {
        positions,
        velocities,
        largest_radius: config.largest_radius() * scale,
        radii: if is_equal(config) { Vec::new() } else { radii },
        account,
    })
}

/// Numbers the discs of a start by their places, if they are many: discs that stand near each other are near each other in
/// memory then. Radii go with their discs.
fn number_by_place(config: &PackingConfig, positions: &mut Vec<Vector>, radii: &mut Vec<f64>) {
    if positions.len() < MANY {
        return;
    }
    let sides = [config.width.get(), config.height.get()];
    let has_walls = config.boundary == Boundary::Walls;
    let grid = Grid::new(sides, 2.0 * config.largest_radius(), positions.len(), has_walls);
    let place = |position: &Vector| grid.order(grid.locate(*position).0);
    let mut order: Vec<(u64, u32)> = Vec::with_capacity(positions.len());
    order.extend(positions.iter().zip(0..).map(|(position, disc)| (place(position), disc)));
    order.sort_unstable();
    *positions = order.iter().map(|&(_, disc)| positions[disc as usize]).collect();
    *radii = order.iter().map(|&(_, disc)| radii[disc as usize]).collect();
}

fn is_equal(config: &PackingConfig) -> bool {
    config.polydispersity.get() == 0.0
}

fn check_size(config: &PackingConfig) -> Result<(), SetupError> {
    let (width, height, radius) =
        (config.width.get(), config.height.get(), config.largest_radius());
    let shorter = if width < height { width } else { height };
    if 2.0 * radius >= shorter {
        return Err(SetupError(format!(
            "a disc of radius {radius} does not fit into a box of {width} x {height}: the radius must be below {}",
            0.5 * shorter
        )));
    }
    if config.boundary == Boundary::Periodic && shorter < PERIODIC_DIAMETERS * 2.0 * radius {
        return Err(SetupError(format!(
            "a periodic box of {width} x {height} is too small for discs of radius {radius}: both sides must be at least \
             {PERIODIC_DIAMETERS} diameters"
        )));
    }
    Ok(())
}

/// The radius of each disc: uniform about the mean, from a stream of their own.
fn radii(config: &PackingConfig, seed: Seed) -> Vec<f64> {
    let (radius, spread) = (config.radius.get(), config.polydispersity.get());
    let mut generator = seed.stream(Stream::Radii);
    (0..config.discs.get())
        .map(|_| {
            if is_equal(config) {
                radius
            } else {
                generator.uniform_in(radius * (1.0 - spread), radius * (1.0 + spread))
            }
        })
        .collect()
}

fn values(pairs: &[[kinetoscope_manifest::quantity::Finite; 2]]) -> Vec<Vector> {
    pairs.iter().map(|pair| pair.map(|value| value.get())).collect()
}

fn given_start(
    config: &PackingConfig,
    given: &GivenState,
    radii: Vec<f64>,
) -> Result<Start, SetupError> {
    let discs = config.discs.get() as usize;
    if given.positions.len() != discs || given.velocities.len() != discs {
        return Err(SetupError(format!(
            "discs = {discs}, but the placement gives {} positions and {} velocities",
            given.positions.len(),
            given.velocities.len()
        )));
    }
    let (positions, velocities) = (values(&given.positions), values(&given.velocities));
    check_given(config, &positions, &velocities, &radii)?;
    Ok(Start {
        positions,
        velocities,
        account: format!(
            "start as given in the manifest, packing fraction {:.4}",
            packing_fraction(config, &radii)
        ),
        largest_radius: config.largest_radius(),
        radii: if is_equal(config) { Vec::new() } else { radii },
    })
}

/// Discs where the run of a recording ended, with their radii. Their wall noise is that of this run's seed.
fn recorded_start(config: &PackingConfig, start: &StartFrom) -> Result<Start, SetupError> {
    let rows = rows(start, ["x", "y", "vx", "vy", "radius"])?;
    let radii: Vec<f64> = rows.iter().map(|row| row[4]).collect();
    let fold = |first: f64, is_beyond: fn(f64, f64) -> bool| {
        radii.iter().fold(first, |most, &next| if is_beyond(next, most) { next } else { most })
    };
    let smallest = fold(f64::INFINITY, |next, least| next < least);
    let largest = fold(0.0, |next, most| next > most);
    let spread = config.polydispersity.get();
    let least = config.radius.get() * (1.0 - spread) * (1.0 - ROUNDING);
    if smallest < least || largest > config.largest_radius() * (1.0 + ROUNDING) {
        return Err(SetupError(format!(
            "the discs of the recording in start_from have radii of {smallest} to {largest}: write radius = {} and \
             polydispersity = {}",
            0.5 * (smallest + largest),
            (largest - smallest) / (largest + smallest)
        )));
    }
    let positions: Vec<Vector> = rows.iter().map(|&[x, y, ..]| [x, y]).collect();
    let velocities: Vec<Vector> = rows.iter().map(|&[_, _, vx, vy, _]| [vx, vy]).collect();
    check_given(config, &positions, &velocities, &radii)?;
    Ok(Start {
        positions,
        velocities,
        account: format!(
            "start where the recording ended, packing fraction {:.4}",
            packing_fraction(config, &radii)
        ),
        largest_radius: largest,
        radii: if smallest < largest { radii } else { Vec::new() },
    })
}

/// Standard deviation of a velocity component before the mean is removed: 1, or n^-1/2.
pub(super) fn velocity_deviation(config: &PackingConfig) -> f64 {
    match config.initial_velocities {
        InitialVelocities::Unmodified => 1.0,
        InitialVelocities::Modified => 1.0 / f64::from(config.discs.get()).sqrt(),
    }
}

/// Share of the box that discs cover, n pi <r^2> / (lx ly).
pub(super) fn packing_fraction(config: &PackingConfig, radii: &[f64]) -> f64 {
    covered(radii) / (config.width.get() * config.height.get())
}

fn covered(radii: &[f64]) -> f64 {
    radii.iter().fold(0.0, |sum, radius| sum + std::f64::consts::PI * radius * radius)
}

fn rectangle(config: &PackingConfig) -> Rectangle {
    let [x, y] = [0.5 * config.width.get(), 0.5 * config.height.get()];
    Rectangle { min: [-x, -y], max: [x, y] }
}

/// Refuses what random sequential addition would hardly reach. Centers have only a x b with a = lx - 2r: next to a wall
/// discs stand denser than elsewhere, by 0.33 diameters of room at each wall (as cars at the ends of Renyi's street), so
/// that the fraction of (a + 0.66 s) (b + 0.66 s) is what counts.
fn check_random(config: &PackingConfig, radii: &[f64]) -> Result<(), SetupError> {
    let diameter = 2.0 * config.largest_radius();
    let lost = if config.boundary == Boundary::Walls { (1.0 - 0.66) * diameter } else { 0.0 };
    let room = (config.width.get() - lost) * (config.height.get() - lost);
    let fraction = covered(radii) / room;
    if radii.len() > 1 && fraction >= RANDOM_PLACEMENT_LIMIT {
        return Err(SetupError(format!(
            "packing fraction {:.4}, {fraction:.4} of the room that walls leave: random placement needs a fraction below \
             {RANDOM_PLACEMENT_LIMIT}; use placement = \"lattice\" or \"compressed\", fewer discs or a smaller radius",
            packing_fraction(config, radii)
        )));
    }
    Ok(())
}

/// Random sequential addition of discs of these radii.
pub(super) fn random_positions(
    config: &PackingConfig,
    radii: &[f64],
    seed: Seed,
) -> Result<Vec<Vector>, SetupError> {
    let mut generator = seed.stream(Stream::Positions);
    let placed = match config.boundary {
        Boundary::Walls => random_sequential_addition(rectangle(config), radii, &mut generator),
        Boundary::Periodic => {
            periodic_random_sequential_addition(rectangle(config), radii, &mut generator)
        }
    };
    placed.map_err(|jammed| {
        SetupError(format!(
            "random placement found room for {} of {} discs (packing fraction {:.4}, and walls take room); \
             use placement = \"lattice\" or \"compressed\", fewer discs or a smaller radius",
            jammed.placed,
            config.discs,
            packing_fraction(config, radii)
        ))
    })
}

fn lattice_positions(config: &PackingConfig) -> Result<(Vec<Vector>, String), SetupError> {
    let (rectangle, radius) = (rectangle(config), config.largest_radius());
    let count = config.discs.get() as usize;
    if let Some(positions) = square_lattice(rectangle, radius, count) {
        return Ok((positions, "square lattice".to_owned()));
    }
    let sides = [config.width.get(), config.height.get()];
    let hexagonal = match config.boundary {
        Boundary::Walls => hexagonal_rows(sides, radius, count),
        Boundary::Periodic => periodic_hexagonal(sides, radius, count),
    };
    if let Some(positions) = hexagonal {
        return Ok((positions, "hexagonal rows".to_owned()));
    }
    let hold = match config.boundary {
        Boundary::Walls => format!(", which hold {}", most_in_hexagonal_rows(sides, radius)),
        Boundary::Periodic => " that go on over the edges".to_owned(),
    };
    Err(SetupError(format!(
        "{count} discs of radius {radius} fit into a box of {} x {} neither on a square lattice nor in hexagonal rows{hold}; \
         use fewer discs, a smaller radius or a larger box",
        sides[0], sides[1],
    )))
}

/// Normal velocity components of the law that the manifest asks for, their mean removed unless there is one disc only.
/// The same draws serve both laws: their velocities differ by the factor n^-1/2 alone.
pub(super) fn random_velocities(config: &PackingConfig, mut generator: Generator) -> Vec<Vector> {
    let deviation = velocity_deviation(config);
    let mut velocities: Vec<Vector> = (0..config.discs.get())
        .map(|_| generator.normal_pair().map(|normal| normal * deviation))
        .collect();
    if velocities.len() > 1 {
        let count = velocities.len() as f64;
        let sum = velocities.iter().fold([0.0; 2], |sum, v| [sum[0] + v[0], sum[1] + v[1]]);
        for velocity in &mut velocities {
            *velocity = motion::difference(sum.map(|sum| sum / count), *velocity);
        }
    }
    velocities
}

fn check_given(
    config: &PackingConfig,
    positions: &[Vector],
    velocities: &[Vector],
    radii: &[f64],
) -> Result<(), SetupError> {
    let slack = ROUNDING * 2.0 * config.radius.get();
    for (disc, ([x, y], radius)) in positions.iter().zip(radii).enumerate() {
        let kept_off = if config.boundary == Boundary::Walls { *radius } else { 0.0 };
        let reach = [0.5 * config.width.get() - kept_off, 0.5 * config.height.get() - kept_off];
        if x.abs() > reach[0] + slack || y.abs() > reach[1] + slack {
            return Err(SetupError(format!(
                "disc {disc} at [{x}, {y}] is not inside: centers need |x| <= {} and |y| <= {}",
                reach[0], reach[1]
            )));
        }
    }
    for (disc, &velocity) in velocities.iter().enumerate() {
        let speed = motion::speed(velocity);
        if velocity != [0.0, 0.0] && !(SPEEDS[0] < speed && speed < SPEEDS[1]) {
            return Err(SetupError(format!(
                "disc {disc} has the speed {speed}: it must be 0 or between {} and {}",
                SPEEDS[0], SPEEDS[1]
            )));
        }
    }
    check_apart(config, positions, radii, slack)
}

fn check_apart(
    config: &PackingConfig,
    positions: &[Vector],
    radii: &[f64],
    slack: f64,
) -> Result<(), SetupError> {
    let sides = [config.width.get(), config.height.get()];
    let has_walls = config.boundary == Boundary::Walls;
    let grid = Grid::new(sides, 2.0 * config.largest_radius(), positions.len(), has_walls);
    let mut cells = Cells::new(grid);
    let places: Vec<([u16; 2], Vector)> =
        positions.iter().map(|&position| grid.locate(position)).collect();
    for (disc, (cell, _)) in places.iter().enumerate() {
        cells.insert(disc as u32, *cell, places.len());
    }
    for (disc, &(cell, inside)) in places.iter().enumerate() {
        let mut overlapping: Option<(u32, f64)> = None;
        cells.for_each_near(cell, |other| {
            let (other_cell, other_inside) = places[other as usize];
            let shift = grid.shift(cell, other_cell);
            let apart = motion::difference(inside, other_inside);
            let distance = motion::speed([apart[0] + shift[0], apart[1] + shift[1]]);
            let least = radii[disc] + radii[other as usize] - slack;
            if other as usize > disc
                && distance < least
                && overlapping.is_none_or(|(id, _)| other < id)
            {
                overlapping = Some((other, distance));
            }
        });
        if let Some((other, distance)) = overlapping {
            return Err(SetupError(format!(
                "discs {disc} and {other} overlap: their centers are {distance} apart, and they touch at {}",
                radii[disc] + radii[other as usize]
            )));
        }
    }
    Ok(())
}
