//! The start of a run: positions, velocities and radii.

use super::cells::patch_order;
use super::compression::compress;
use super::disc::LARGE_SYSTEM;
use super::domain::Domain;
use super::lattice::{hexagonal_lattice, max_in_hexagonal_lattice, periodic_hexagonal_lattice};
use super::motion::{self, Vector};
use super::near_obstacles::NearObstacles;
use super::random_start::{
    check_random_placement, is_equal, packing_fraction, random_positions, random_radii,
    random_velocities, rectangle, removes_mean_velocity, velocity_std,
};
use crate::cell_grid::Cell;
use crate::cell_lists::CellLists;
use crate::model::{Proceed, SetupError};
use crate::placement::square_lattice;
use crate::random::{Seed, Stream};
use crate::restart_state::rows;
use kinetoscope_manifest::model::{
    Boundary, PERIODIC_DIAMETERS, PackingConfig, PackingPlacement, PackingState, StartFrom,
};
use kinetoscope_manifest::quantity::Finite;

/// Overlap in diameters that is accepted for the positions of a manifest or a recording, whose decimals are rounded.
const ROUNDING: f64 = 1e-12;

/// Accepted range of speeds: their fourth power must be a normal number.
const SPEED_RANGE: [f64; 2] = [1e-60, 1e60];

/// The start of a run.
pub(super) struct PackingStart {
    /// Centers.
    pub(super) positions: Vec<Vector>,
    /// Velocities, one per disc.
    pub(super) velocities: Vec<Vector>,
    /// Radii, one per disc; empty if all are equal.
    pub(super) radii: Vec<f64>,
    /// Radius of the largest disc.
    pub(super) max_radius: f64,
    /// The start in words, for the log.
    pub(super) description: String,
}

/// Places the discs and assigns velocities.
///
/// # Errors
/// Discs that do not fit, overlap, or are outside of the box, or a stop.
pub(super) fn start(
    config: &PackingConfig,
    seed: Seed,
    proceed: Proceed<'_>,
) -> Result<PackingStart, SetupError> {
    check_size(config)?;
    let mut radii = random_radii(config, seed);
    let mut scale = 1.0;
    let (mut positions, placement) = match &config.placement {
        PackingPlacement::Random => {
            check_random_placement(config, &radii)?;
            let positions = random_positions(config, &radii, seed, proceed)?;
            (positions, "random sequential addition".to_owned())
        }
        PackingPlacement::Lattice => lattice_positions(config)?,
        PackingPlacement::Compressed => {
            let compressed = compress(config, &radii, seed, proceed)?;
            scale = compressed.scale;
            (compressed.positions, compressed.description)
        }
        PackingPlacement::Given(given) => {
            return given_start(config, given, radii);
        }
        PackingPlacement::Recorded(start) => return recorded_start(config, start),
    };
    // Allocated before the sort frees columns: an allocator does not return the memory of a column that is followed by
    // another allocation.
    let velocities = random_velocities(config, seed.stream(Stream::Velocities));
    sort_by_position(config, &mut positions, &mut radii);
    let momentum = if removes_mean_velocity(config) { ", mean velocity removed" } else { "" };
    let radii: Vec<f64> = radii.into_iter().map(|radius| radius * scale).collect();
    let description = format!(
        "start by {placement}, packing fraction {:.4}, velocity components normal with standard deviation {}{momentum}",
        packing_fraction(config, &radii),
        velocity_std(config)
    );
    Ok(PackingStart {
        positions,
        velocities,
        max_radius: config.largest_radius() * scale,
        radii: if is_equal(config) { Vec::new() } else { radii },
        description,
    })
}

/// Numbers the discs of a large system by position, so that neighbors are close in memory. Radii stay with their discs.
fn sort_by_position(config: &PackingConfig, positions: &mut Vec<Vector>, radii: &mut Vec<f64>) {
    if positions.len() < LARGE_SYSTEM {
        return;
    }
    let grid = Domain::new(config, config.largest_radius()).cell_grid(positions.len());
    let key = |position: &Vector| patch_order(grid.cell_at(*position));
    let mut order: Vec<(u64, u32)> = Vec::with_capacity(positions.len());
    order.extend(positions.iter().zip(0..).map(|(position, disc)| (key(position), disc)));
    order.sort_unstable();
    *positions = order.iter().map(|&(_, disc)| positions[disc as usize]).collect();
    *radii = order.iter().map(|&(_, disc)| radii[disc as usize]).collect();
}

fn check_size(config: &PackingConfig) -> Result<(), SetupError> {
    let (width, height, radius) =
        (config.width.get(), config.height.get(), config.largest_radius());
    let shorter = if width < height { width } else { height };
    if 2.0 * radius >= shorter {
        return Err(SetupError::new(
            format!("a disc of radius {radius} does not fit into a box of {width} x {height}"),
            format!("set the radius to less than {}", 0.5 * shorter),
        ));
    }
    if config.boundary == Boundary::Periodic && shorter < PERIODIC_DIAMETERS * 2.0 * radius {
        return Err(SetupError::new(
            format!(
                "a periodic box of {width} x {height} is too small for discs of radius {radius}"
            ),
            format!("make both sides at least {PERIODIC_DIAMETERS} diameters"),
        ));
    }
    Ok(())
}

fn lattice_positions(config: &PackingConfig) -> Result<(Vec<Vector>, String), SetupError> {
    let (rectangle, radius) = (rectangle(config), config.largest_radius());
    let count = config.discs.get() as usize;
    if let Some(positions) = square_lattice(rectangle, radius, count) {
        return Ok((positions, "square lattice".to_owned()));
    }
    let sides = [config.width.get(), config.height.get()];
    let hexagonal = match config.boundary {
        Boundary::Walls => hexagonal_lattice(sides, radius, count),
        Boundary::Periodic => periodic_hexagonal_lattice(sides, radius, count),
    };
    if let Some(positions) = hexagonal {
        return Ok((positions, "hexagonal rows".to_owned()));
    }
    let capacity = match config.boundary {
        Boundary::Walls => format!(", which hold {}", max_in_hexagonal_lattice(sides, radius)),
        Boundary::Periodic => " that continue across the edges".to_owned(),
    };
    Err(SetupError::new(
        format!(
            "{count} discs of radius {radius} fit into a box of {} x {} neither on a square lattice nor in hexagonal \
             rows{capacity}",
            sides[0], sides[1],
        ),
        "use fewer discs, a smaller radius or a larger box",
    ))
}

fn values(pairs: &[[Finite; 2]]) -> Vec<Vector> {
    pairs.iter().map(|pair| pair.map(|value| value.get())).collect()
}

/// The start of a manifest with positions and velocities.
fn given_start(
    config: &PackingConfig,
    given: &PackingState,
    radii: Vec<f64>,
) -> Result<PackingStart, SetupError> {
    let discs = config.discs.get() as usize;
    if given.positions.len() != discs || given.velocities.len() != discs {
        return Err(SetupError::new(
            format!(
                "discs = {discs}, but the placement gives {} positions and {} velocities",
                given.positions.len(),
                given.velocities.len()
            ),
            "make them equal",
        ));
    }
    let (positions, velocities) = (values(&given.positions), values(&given.velocities));
    check_given(config, &positions, &velocities, &radii)?;
    Ok(PackingStart {
        positions,
        velocities,
        description: format!(
            "start as given in the manifest, packing fraction {:.4}",
            packing_fraction(config, &radii)
        ),
        max_radius: config.largest_radius(),
        radii: if is_equal(config) { Vec::new() } else { radii },
    })
}

/// The last state of a recording, with its radii. The wall noise is that of this run's seed.
fn recorded_start(config: &PackingConfig, start: &StartFrom) -> Result<PackingStart, SetupError> {
    let rows = rows(start, ["x", "y", "vx", "vy", "radius"])?;
    let radii: Vec<f64> = rows.iter().map(|row| row[4]).collect();
    let fold = |first: f64, replaces: fn(f64, f64) -> bool| {
        radii.iter().fold(first, |most, &next| if replaces(next, most) { next } else { most })
    };
    let smallest = fold(f64::INFINITY, |next, least| next < least);
    let largest = fold(0.0, |next, most| next > most);
    let half_width = config.radius_half_width.get();
    let lower_limit = config.radius.get() * (1.0 - half_width) * (1.0 - ROUNDING);
    if smallest < lower_limit || largest > config.largest_radius() * (1.0 + ROUNDING) {
        return Err(SetupError::new(
            format!(
                "the discs of the recording in start_from have radii between {smallest} and {largest}"
            ),
            format!(
                "set radius = {} and radius_half_width = {}",
                0.5 * (smallest + largest),
                (largest - smallest) / (largest + smallest)
            ),
        ));
    }
    let positions: Vec<Vector> = rows.iter().map(|&[x, y, ..]| [x, y]).collect();
    let velocities: Vec<Vector> = rows.iter().map(|&[_, _, vx, vy, _]| [vx, vy]).collect();
    check_given(config, &positions, &velocities, &radii)?;
    Ok(PackingStart {
        positions,
        velocities,
        description: format!(
            "start where the recording ended, packing fraction {:.4}",
            packing_fraction(config, &radii)
        ),
        max_radius: largest,
        radii: if smallest < largest { radii } else { Vec::new() },
    })
}

/// Rejects discs outside of the box or in an obstacle, speeds out of range, discs that lie on a floor, and overlaps.
fn check_given(
    config: &PackingConfig,
    positions: &[Vector],
    velocities: &[Vector],
    radii: &[f64],
) -> Result<(), SetupError> {
    let tolerance = ROUNDING * 2.0 * config.radius.get();
    let (obstacles, of_obstacle) = (NearObstacles::of(config), config.obstacles().1);
    for (disc, ([x, y], radius)) in positions.iter().zip(radii).enumerate() {
        let margin = if config.boundary == Boundary::Walls { *radius } else { 0.0 };
        let limit = [0.5 * config.width.get() - margin, 0.5 * config.height.get() - margin];
        if x.abs() > limit[0] + tolerance || y.abs() > limit[1] + tolerance {
            return Err(SetupError::new(
                format!("disc {disc} at [{x}, {y}] is not inside"),
                format!("move its center to |x| <= {} and |y| <= {}", limit[0], limit[1]),
            ));
        }
        let contact = of_obstacle + radius;
        if let Some((center, apart)) = obstacles.closer_than(contact - tolerance, [*x, *y]).next() {
            let is_inside = (0..2).all(|axis: usize| center[axis].abs() <= limit[axis] + margin);
            let of = if is_inside { "" } else { "periodic image of the " };
            return Err(SetupError::new(
                format!(
                    "disc {disc} at [{x}, {y}] overlaps the {of}obstacle at {center:?}: their centers are {apart} apart"
                ),
                format!("move the disc or the obstacle away: they touch at {contact}"),
            ));
        }
    }
    let falls = config.gravity.get() > 0.0 && config.floor_temperature.is_none();
    for (disc, &velocity) in velocities.iter().enumerate() {
        let speed = motion::speed(velocity);
        if velocity != [0.0, 0.0] && !(SPEED_RANGE[0] < speed && speed < SPEED_RANGE[1]) {
            return Err(SetupError::new(
                format!("disc {disc} has the speed {speed}"),
                format!("set it to 0 or between {} and {}", SPEED_RANGE[0], SPEED_RANGE[1]),
            ));
        }
        let contact = of_obstacle + radii[disc];
        let mut touched = obstacles.closer_than(contact + tolerance, positions[disc]);
        let lies_on = |center: Vector| {
            let [x, y] = motion::difference(center, positions[disc]);
            let leaving = (x * velocity[0] + y * velocity[1]).abs();
            y > 0.0 && leaving <= ROUNDING * speed * contact
        };
        let under = touched.find(|(center, _)| config.gravity.get() > 0.0 && lies_on(*center));
        if let Some((center, _)) = under {
            return Err(SetupError::new(
                format!("disc {disc} at {:?} lies on the obstacle at {center:?}", positions[disc]),
                "give it a velocity away from the obstacle, or move one of the two away",
            ));
        }
        // Without a velocity up or down, it would touch the floor without end.
        let (y, lowest) = (positions[disc][1], radii[disc] - 0.5 * config.height.get());
        if falls && velocity[1] == 0.0 && y <= lowest + tolerance {
            return Err(SetupError::new(
                format!("disc {disc} at {:?} lies on the floor", positions[disc]),
                format!("give it a velocity up or down, or move its center above {lowest}"),
            ));
        }
    }
    check_overlaps(config, positions, radii, tolerance)
}

fn check_overlaps(
    config: &PackingConfig,
    positions: &[Vector],
    radii: &[f64],
    tolerance: f64,
) -> Result<(), SetupError> {
    let grid = Domain::new(config, config.largest_radius()).cell_grid(positions.len());
    let mut cells = CellLists::new(grid);
    let located: Vec<(Cell, Vector)> =
        positions.iter().map(|&position| grid.locate(position)).collect();
    for (disc, (cell, _)) in located.iter().enumerate() {
        cells.insert(disc as u32, *cell, located.len());
    }
    for (disc, &(cell, relative)) in located.iter().enumerate() {
        let mut overlapping: Option<(u32, f64)> = None;
        for other in cells.discs_around(cell) {
            let (other_cell, other_relative) = located[other as usize];
            let offset = grid.offset_between(cell, other_cell);
            let r = motion::difference(relative, other_relative);
            let distance = motion::speed([r[0] + offset[0], r[1] + offset[1]]);
            let contact_distance = radii[disc] + radii[other as usize];
            if other as usize > disc
                && distance < contact_distance - tolerance
                && overlapping.is_none_or(|(id, _)| other < id)
            {
                overlapping = Some((other, distance));
            }
        }
        if let Some((other, distance)) = overlapping {
            return Err(SetupError::new(
                format!("discs {disc} and {other} overlap: their centers are {distance} apart"),
                format!("move them apart: they touch at {}", radii[disc] + radii[other as usize]),
            ));
        }
    }
    Ok(())
}
