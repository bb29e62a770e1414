//! Where discs stand and how they move at the start.

use super::cells::{Cells, Grid};
use super::lattice::{hexagonal_rows, most_in_hexagonal_rows};
use super::motion::{self, Vector};
use crate::model::Refusal;
use crate::placement::{Rectangle, random_sequential_addition, square_lattice};
use crate::random::{Seed, Stream};
use kinetoscope_manifest::model::{Boundary, GivenState, InitialVelocities, PackingConfig, PackingPlacement};

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
    /// Centres.
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
pub(super) fn start(config: &PackingConfig, seed: Seed) -> Result<Start, Refusal> {
    let (width, height, radius) = (config.width.get(), config.height.get(), config.radius.get());
    let shorter = if width < height { width } else { height };
    if 2.0 * radius >= shorter {
        return Err(Refusal(format!(
            "a disc of radius {radius} does not fit into a box of {width} x {height}: the radius must be below {}",
            0.5 * shorter
        )));
    }
    let (positions, placed) = match &config.placement {
        PackingPlacement::Random => (random_positions(config, seed)?, "random sequential addition"),
        PackingPlacement::Lattice => lattice_positions(config)?,
        PackingPlacement::Compressed => todo!(),
        PackingPlacement::Given(given) => {
            check_given(config, given)?;
            let values = |pairs: &[[kinetoscope_manifest::quantity::Finite; 2]]| {
                pairs.iter().map(|pair| pair.map(|value| value.get())).collect::<Vec<Vector>>()
            };
            return Ok(Start {
                positions: values(&given.positions),
                velocities: values(&given.velocities),
                radii: Vec::new(),
                largest_radius: radius,
                account: format!(
                    "start as given in the manifest, packing fraction {:.4}",
                    packing_fraction(config)
                ),
            });
        }
    };
    let velocities = random_velocities(config, seed);
    let momentum = if velocities.len() > 1 { ", mean velocity removed" } else { "" };
    let account = format!(
        "start by {placed}, packing fraction {:.4}, velocity components normal with standard deviation {}{momentum}",
        packing_fraction(config),
        velocity_deviation(config)
    );
    Ok(Start { positions, velocities, radii: Vec::new(), largest_radius: radius, account })
}

/// Standard deviation of a velocity component before the mean is removed: 1, or n^-1/2.
pub(super) fn velocity_deviation(config: &PackingConfig) -> f64 {
    match config.initial_velocities {
        InitialVelocities::Unmodified => 1.0,
        InitialVelocities::Modified => 1.0 / f64::from(config.discs.get()).sqrt(),
    }
}

/// Share of the box that discs cover, n pi r^2 / (lx ly).
fn packing_fraction(config: &PackingConfig) -> f64 {
    let radius = config.radius.get();
    let discs = f64::from(config.discs.get()) * std::f64::consts::PI * radius * radius;
    discs / (config.width.get() * config.height.get())
}

fn rectangle(config: &PackingConfig) -> Rectangle {
    let [x, y] = [0.5 * config.width.get(), 0.5 * config.height.get()];
    Rectangle { min: [-x, -y], max: [x, y] }
}

fn random_positions(config: &PackingConfig, seed: Seed) -> Result<Vec<Vector>, Refusal> {
    let fraction = packing_fraction(config);
    if fraction >= RANDOM_PLACEMENT_LIMIT {
        return Err(Refusal(format!(
            "packing fraction {fraction:.4}: random placement needs a fraction below {RANDOM_PLACEMENT_LIMIT}; \
             use placement = \"lattice\", fewer discs or a smaller radius"
        )));
    }
    let radii = vec![config.radius.get(); config.discs.get() as usize];
    let mut generator = seed.stream(Stream::Positions);
    random_sequential_addition(rectangle(config), &radii, &mut generator).map_err(|jammed| {
        Refusal(format!(
            "random placement found room for {} of {} discs (packing fraction {fraction:.4}, and walls take room); \
             use placement = \"lattice\", fewer discs or a smaller radius",
            jammed.placed, config.discs
        ))
    })
}

fn lattice_positions(config: &PackingConfig) -> Result<(Vec<Vector>, &'static str), Refusal> {
    let (rectangle, radius) = (rectangle(config), config.radius.get());
    let count = config.discs.get() as usize;
    if let Some(positions) = square_lattice(rectangle, radius, count) {
        return Ok((positions, "square lattice"));
    }
    let sides = [config.width.get(), config.height.get()];
    if let Some(positions) = hexagonal_rows(sides, radius, count) {
        return Ok((positions, "hexagonal rows"));
    }
    Err(Refusal(format!(
        "{count} discs of radius {radius} fit into a box of {} x {} neither on a square lattice nor in hexagonal rows, \
         which hold {}; use fewer discs, a smaller radius or a larger box",
        sides[0],
        sides[1],
        most_in_hexagonal_rows(sides, radius)
    )))
}

/// Normal velocity components of the law that the manifest asks for, their mean removed unless there is one disc only.
/// The same draws serve both laws: their velocities differ by the factor n^-1/2 alone.
fn random_velocities(config: &PackingConfig, seed: Seed) -> Vec<Vector> {
    let deviation = velocity_deviation(config);
    let mut generator = seed.stream(Stream::Velocities);
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

fn check_given(config: &PackingConfig, given: &GivenState) -> Result<(), Refusal> {
    let discs = config.discs.get() as usize;
    if given.positions.len() != discs || given.velocities.len() != discs {
        return Err(Refusal(format!(
            "discs = {discs}, but the placement gives {} positions and {} velocities",
            given.positions.len(),
            given.velocities.len()
        )));
    }
    let radius = config.radius.get();
    let slack = ROUNDING * 2.0 * radius;
    let reach = [0.5 * config.width.get() - radius, 0.5 * config.height.get() - radius];
    let positions: Vec<Vector> =
        given.positions.iter().map(|pair| pair.map(|value| value.get())).collect();
    for (disc, [x, y]) in positions.iter().enumerate() {
        if x.abs() > reach[0] + slack || y.abs() > reach[1] + slack {
            return Err(Refusal(format!(
                "disc {disc} at [{x}, {y}] is not inside: centres need |x| <= {} and |y| <= {}",
                reach[0], reach[1]
            )));
        }
    }
    for (disc, velocity) in given.velocities.iter().enumerate() {
        let speed = motion::speed(velocity.map(|value| value.get()));
        if velocity.iter().any(|value| value.get() != 0.0)
            && !(SPEEDS[0] < speed && speed < SPEEDS[1])
        {
            return Err(Refusal(format!(
                "disc {disc} has the speed {speed}: it must be 0 or between {} and {}",
                SPEEDS[0], SPEEDS[1]
            )));
        }
    }
    check_apart(config, &positions, 2.0 * radius - slack)
}

fn check_apart(config: &PackingConfig, positions: &[Vector], least: f64) -> Result<(), Refusal> {
    let sides = [config.width.get(), config.height.get()];
    let grid = Grid::new(sides, 2.0 * config.radius.get(), positions.len(), config.boundary == Boundary::Walls);
    let mut cells = Cells::new(grid);
    for (disc, &position) in positions.iter().enumerate() {
        cells.insert(disc as u32, grid.locate(position).0, positions.len());
    }
    for disc in 0..config.discs.get() {
        let mut overlapping: Option<(u32, f64)> = None;
        cells.for_each_near(grid.locate(positions[disc as usize]).0, |other| {
            let distance = motion::speed(motion::difference(
                positions[disc as usize],
                positions[other as usize],
            ));
            if other > disc && distance < least && overlapping.is_none_or(|(id, _)| other < id) {
                overlapping = Some((other, distance));
            }
        });
        if let Some((other, distance)) = overlapping {
            return Err(Refusal(format!(
                "discs {disc} and {other} overlap: their centres are {distance} apart, and a diameter is {}",
                2.0 * config.radius.get()
            )));
        }
    }
    Ok(())
}
